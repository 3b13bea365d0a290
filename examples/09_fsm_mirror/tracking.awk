# Root mean square of the references, LATE rows before, less the positions, over the second period of the record.
BEGIN { FS = ","; period = 8192 }
NR == 1 { for (i = 1; i <= NF; i++) column[$i] = i; next }
{
    n = NR - 2
    for (i = 1; i <= 3; i++) past[i, n % 4096] = $column["reference[" i "]"]
    if (n < period) next
    count++
    for (i = 1; i <= 3; i++) {
        e = past[i, (n - LATE) % 4096] - $column["position[" i "]"]
        square[i] += e * e; whole[i] += past[i, n % 4096] ^ 2
    }
}
END {
    printf "tracking, %s:", NAME
    for (i = 1; i <= 3; i++) printf " y%d %.4f um (%.1f %%)", i, sqrt(square[i] / count), 100 * sqrt(square[i] / whole[i])
    print ""
}

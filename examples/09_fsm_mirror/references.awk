# The outputs y1 to y3 of a record as references, low-passed at FC Hz (Butterworth, fourth order); FC=0: as they are.
BEGIN { FS = OFS = ","; rate = 6400 }
NR == 1 { for (i = 1; i <= NF; i++) column[$i] = i; next }
{ n++; for (i = 1; i <= 3; i++) y[i, n] = $column["y" i] }
END {
    if (FC > 0) {
        w = atan2(0, -1) * FC / rate; k = sin(w) / cos(w)
        for (i = 1; i <= 3; i++) for (section = 1; section <= 2; section++) {
            q = section == 1 ? 0.541196 : 1.306563
            scale = 1 / (1 + k / q + k * k); b = k * k * scale
            a1 = 2 * (k * k - 1) * scale; a2 = (1 - k / q + k * k) * scale
            x1 = x2 = v1 = v2 = 0
            for (s = 1; s <= n; s++) {
                x = y[i, s]; v = b * (x + 2 * x1 + x2) - a1 * v1 - a2 * v2
                x2 = x1; x1 = x; v2 = v1; v1 = v; y[i, s] = v
            }
        }
    }
    print "time,reference[1],reference[2],reference[3]"
    for (s = 1; s <= n; s++) printf "%.9f,%.9g,%.9g,%.9g\n", (s - 1) / rate, y[1, s], y[2, s], y[3, s]
}

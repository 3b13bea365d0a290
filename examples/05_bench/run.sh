#!/bin/sh
# Runs the commands of README.md. Usage: sh run.sh [FOLDER]
set -eu
here=$(cd "$(dirname "$0")" && pwd)
out=${1:-bench-example}
mkdir -p "$out"
cd "$out"

# Two network namespaces, joined by a virtual cable; without the privilege, loopback.
ns=pl$$
machine="" ; runner="" ; machine_ip=127.0.0.1 ; runner_ip=127.0.0.1
started=""
end() {
    [ -z "$started" ] || kill "$started" 2>/dev/null || true
    ip netns del "${ns}m" 2>/dev/null || true
    ip netns del "${ns}r" 2>/dev/null || true
}
trap end EXIT
if ip netns add "${ns}m" 2>/dev/null && ip netns add "${ns}r" 2>/dev/null &&
    ip link add "${ns}a" netns "${ns}m" type veth peer name "${ns}b" netns "${ns}r" 2>/dev/null; then
    machine_ip=10.77.0.2 ; runner_ip=10.77.0.1
    ip -n "${ns}m" addr add $machine_ip/24 dev "${ns}a" && ip -n "${ns}m" link set "${ns}a" up
    ip -n "${ns}r" addr add $runner_ip/24 dev "${ns}b" && ip -n "${ns}r" link set "${ns}b" up
    machine="ip netns exec ${ns}m" ; runner="ip netns exec ${ns}r"
    # The cable needs a moment.
    sleep 1
else
    echo "SKIPPED: network namespaces (no privilege to make them); both ends on loopback"
fi

echo "The machine: rig p1, whose position sensor rounds to 20 nm and whose line takes 2.5 ms"
$machine piezoloop bench emulate p1 --gateway udp://$machine_ip:9000 --peer $runner_ip:9001 --rate 1k \
    --timing commands --inject delay,seconds=0.0025 --inject quantisation,step=0.02 > machine.txt &
started=$!
sleep 3

echo "Measure it"
$runner piezoloop bench run --plan "$here/plan.toml" --gateway udp://$machine_ip:9000 \
    --bind $runner_ip:9001 --record run.parquet
kill "$started" && wait "$started" || true
started=""
cat machine.txt

echo "What does the machine do that the model p1 does not?"
piezoloop diagnose --model p1 --log run.parquet --report gap.html

echo "Close the loop with a controller FMU: the inverse and PID of p1, 500 times a second"
piezoloop -q invert p1 --period 2e-3 -o controller.toml
piezoloop -q pack controller.toml -o controller.fmu
piezoloop -q signal ellipse --set centre_y=15 --set semi_axis_long=5 --set semi_axis_short=5 --set frequency=2 --set duration=3 \
    --set sample_time=2e-3 --rename 'y=reference[1]' -o reference.csv
$machine piezoloop bench emulate p1-truth --gateway udp://$machine_ip:9000 --peer $runner_ip:9001 --rate 500 \
    --timing commands > machine.txt &
started=$!
sleep 1
$runner piezoloop bench run controller.fmu --plan "$here/watch.toml" --gateway udp://$machine_ip:9000 --bind $runner_ip:9001 --rate 500 \
    --reference reference.csv --record loop.csv
kill "$started" && wait "$started" || true
started=""
# The rows in which the reference was played, from the second second on.
awk -F, 'NR == 1 { for (i = 1; i <= NF; i++) at[$i] = i; next }
    $at["bench.row"] >= 500 && $at["bench.row"] < 1500 { e = $at["reference[1]"] - $at["position[1]"]; sum += e * e; n++ }
    END { printf "loop.csv: rms error %.4f um of 10 um over %d rows\n", sqrt(sum / n), n }' loop.csv

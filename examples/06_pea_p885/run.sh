#!/bin/sh
# Runs this example in the folder given, or in a new one. Needs `piezoloop` on the PATH, and the
# measured log pea_p885_1hz_inverse_ff/test_ff.csv, which is not part of the project.
set -e
here=$(cd "$(dirname "$0")" && pwd)
data=${PIEZOLOOP_DATA:-$here/../../../shared/data}/pea_p885_1hz_inverse_ff
if [ ! -f "$data/test_ff.csv" ]; then
    echo "SKIPPED: no measured log at $data/test_ff.csv"
    exit 0
fi
cd "${1:-$(mktemp -d)}"
cp "$here/line.toml" .
piezoloop diagnose --model line.toml --log "$data/test_ff.csv" \
    --unit u1=V --unit u2=V --unit u3=V --unit y=um --map u=u1 \
    --json gap.json --report gap.html --repair repaired.toml --next-experiment next.csv \
    --picture gap.svg

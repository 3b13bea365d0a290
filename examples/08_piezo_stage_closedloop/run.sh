#!/bin/sh
# Runs this example in the folder given, or in a new one. Needs `piezoloop` on the PATH, and the
# measured log piezo_stage_closedloop_triangle/triangle_100_400um_50khz_dec5.csv, which is not part
# of the project.
set -e
here=$(cd "$(dirname "$0")" && pwd)
data=${PIEZOLOOP_DATA:-$here/../../../shared/data}/piezo_stage_closedloop_triangle
log=$data/triangle_100_400um_50khz_dec5.csv
if [ ! -f "$log" ]; then
    echo "SKIPPED: no measured log at $log"
    exit 0
fi
cd "${1:-$(mktemp -d)}"
cp "$here/servo.toml" .
piezoloop diagnose --model servo.toml --log "$log" --unit r=um --unit y=um \
    --json gap.json --report gap.html --repair repaired.toml --next-experiment next.csv \
    --picture gap.svg

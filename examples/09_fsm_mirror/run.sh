#!/bin/sh
# Runs this example in the folder given, or in a new one. Needs `piezoloop` on the PATH, and the
# measured logs fsm_cubespec_multisine/fsm_{100,200,300}mV_{train,test}.csv, which are not part of the
# project.
set -e
here=$(cd "$(dirname "$0")" && pwd)
data=${PIEZOLOOP_DATA:-$here/../../../shared/data}/fsm_cubespec_multisine
if [ ! -f "$data/fsm_300mV_train.csv" ]; then
    echo "SKIPPED: no measured logs in $data"
    exit 0
fi
cd "${1:-$(mktemp -d)}"
units="--unit u1=V --unit u2=V --unit u3=V --unit y1=um --unit y2=um --unit y3=um"

# A linear model of what the mirror does at 100 mV.
piezoloop frequency-response "$data/fsm_100mV_train.csv" --input u1 --input u2 --input u3 \
    --output y1 --output y2 --output y3 $units --lines 4000 --longest-delay 6e-4 --modes 24 \
    --plant mirror.toml --report response.html
piezoloop pack mirror.toml -o mirror.fmu

# The same at 300 mV, to compare: modes and static gains.
piezoloop frequency-response "$data/fsm_300mV_train.csv" --input u1 --input u2 --input u3 \
    --output y1 --output y2 --output y3 $units --lines 4000 --longest-delay 6e-4 --modes 24 \
    --plant mirror_300mV.toml

# What it lacks at 300 mV: its modes are known to a thousandth, their damping to 2 %.
piezoloop diagnose --model mirror.fmu --log "$data/fsm_300mV_train.csv" \
    --holdout "$data/fsm_300mV_test.csv" --drop 0.1 $units \
    --map "command[1]=u1" --map "command[2]=u2" --map "command[3]=u3" \
    --map "position[1]=y1" --map "position[2]=y2" --map "position[3]=y3" \
    --tune "coupling.modes.frequency*=0.001" --tune "coupling.modes.damping*=0.02" \
    --tune "*.gain.gain=0.05" \
    --json gap.json --report gap.html --repair repaired.fmu

# One plant for all three levels, whose modes follow the amplitude; driven by the commands of records that no
# fit has seen. The record begins in the middle of the motion: its second period is judged.
piezoloop frequency-response "$data/fsm_100mV_train.csv" "$data/fsm_200mV_train.csv" \
    "$data/fsm_300mV_train.csv" --input u1 --input u2 --input u3 --output y1 --output y2 --output y3 \
    $units --lines 4000 --modes 24 --softening --plant softening.toml
piezoloop pack softening.toml -o softening.fmu
for level in 100 200 300; do
    piezoloop simulate softening.fmu --log "$data/fsm_${level}mV_test.csv" --drop 1.28 $units \
        --map "command[1]=u1" --map "command[2]=u2" --map "command[3]=u3" \
        --map "position[1]=y1" --map "position[2]=y2" --map "position[3]=y3" -o "softening_$level.csv"
done

# Controllers that know the plant of 100 mV only: integral control, the same loop for all axes with notches, and with
# the inverse of the modes as feedforward. The amplifier gives 1.2 V.
sed 's/min = -0[.][0-9]*, max = 0[.][0-9]*/min = -1.2, max = 1.2/' mirror.toml > wide.toml
piezoloop invert wide.toml --command-acts at-once --feedback integral --feedforward none -o integral.toml
piezoloop invert wide.toml --command-acts at-once --feedforward none -o notches.toml
piezoloop invert wide.toml --command-acts at-once --feedforward preview -o preview.toml
late=$(awk '$1 == "preview" { print int($3 * 6400 + 0.5) }' preview.toml)
for controller in integral notches preview; do
    piezoloop pack "$controller.toml" -o "$controller.fmu"
done

# They follow what the mirror did at 300 mV, on the plant of all levels: below 200 Hz, and the whole record.
for band in 200 0; do
    awk -v FC="$band" -f "$here/references.awk" "$data/fsm_300mV_test.csv" > "reference_$band.csv"
    for controller in integral notches preview; do
        piezoloop simulate --loop softening.fmu "$controller.fmu" --reference "reference_$band.csv" \
            -o "run_${controller}_$band.csv"
        awk -v LATE="$([ "$controller" = preview ] && echo "$late" || echo 0)" -v NAME="$controller $band" \
            -f "$here/tracking.awk" "run_${controller}_$band.csv"
    done
done

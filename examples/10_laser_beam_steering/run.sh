#!/bin/sh
# Runs the commands of README.md in the folder given, or in a new one. Needs `piezoloop` on the PATH, and a Python with fmpy,
# which the variable PYTHON may name.
set -eu
here=$(cd "$(dirname "$0")" && pwd)
python=${PYTHON:-python3}
cd "${1:-$(mktemp -d)}"
machine=""
trap '[ -z "$machine" ] || kill "$machine" 2>/dev/null || true' EXIT

echo "Measure the machine: each axis by itself"
piezoloop -q signal p0-train-h -o excitation.csv
for i in 1 2 3 4; do
    piezoloop -q simulate p0-truth --log excitation.csv --map "command[$i]=u" -o "moved$i.csv"
done
"$python" "$here/logs.py" angles

echo "A model of each axis"
for i in 1 2 3 4; do
    piezoloop identify --log "axis$i.csv" --input "u$i" --output "theta$i" --model modified-prandtl-ishlinskii \
        --hold-out 0.2 -o "axis$i.toml" > "identify$i.txt" &
    eval "job$i=$!"
done
# One after the other: `wait` of several jobs tells the last one's end only.
for job in $job1 $job2 $job3 $job4; do wait "$job"; done
grep -h "csv: held out" identify?.txt
"$python" "$here/logs.py" join

echo "All axes at once through their inverses, to calibrate the optics"
piezoloop -q invert axes.toml --period 5e-3 --feedback none -o drive.toml
piezoloop -q pack drive.toml -o drive.fmu
"$python" "$here/logs.py" together
piezoloop -q simulate drive.fmu --log together.csv --map 'reference[1]=theta1' --map 'reference[2]=theta2' \
    --map 'reference[3]=theta3' --map 'reference[4]=theta4' -o commands.csv
piezoloop -q simulate p0-truth --log commands.csv -o answers.csv
"$python" "$here/logs.py" calibration

echo "The controller: four inverses, four PIDs, one Jacobian"
piezoloop -q invert axes.toml --period 5e-3 -o motions.toml
piezoloop calibrate calibration.csv --motion theta1 --motion theta2 --motion theta3 --motion theta4 \
    --position x1 --position y1 --position x2 --position y2 --zero x1:theta3 --zero x1:theta4 --zero y1:theta3 --zero y1:theta4 \
    --longest-delay 0.03 --blueprint motions.toml -o controller.toml
piezoloop pack controller.toml -o controller.fmu
piezoloop -q pack p0-truth -o machine.fmu
piezoloop check controller.fmu

echo "Both trajectories, in fmpy"
for rate in 1 2; do
    piezoloop -q signal "p0-trajectory-$rate" --rename 'x1=reference[1]' --rename 'y1=reference[2]' --rename 'x2=reference[3]' \
        --rename 'y2=reference[4]' -o "path$rate.csv"
done
"$python" "$here/loop.py"

echo "The same file in real time, 200 times a second"
piezoloop bench emulate p0-truth --gateway udp://127.0.0.1:9020 --peer 127.0.0.1:9021 --rate 200 --timing commands > machine.txt &
machine=$!
sleep 1
piezoloop bench run controller.fmu --plan "$here/watch.toml" --gateway udp://127.0.0.1:9020 --bind 127.0.0.1:9021 --rate 200 --reference path1.csv \
    --record run.csv
kill "$machine" && wait "$machine" || true
machine=""
"$python" "$here/logs.py" bench

echo "What has the machine that the models have not? Those of the bench"
piezoloop -q calibrate calibration.csv --motion theta1 --motion theta2 --motion theta3 --motion theta4 \
    --position x1 --position y1 --position x2 --position y2 --longest-delay 0.03 --blueprint optics.toml -o model.toml
piezoloop diagnose --model model.toml --log run.csv --drop 1 --unit 'position[1]=um' --unit 'position[2]=um' \
    --unit 'position[3]=um' --unit 'position[4]=um' --report gap.html

echo "And the data sheet's, on a record in which all axes move at once"
sed 's/^step = 2.5e-4/step = 1e-3/' "$here/../../rigs/p0.toml" > datasheet.toml
"$python" "$here/logs.py" drive
piezoloop -q simulate p0-truth --log drive.csv --map 'command[1]=u1' --map 'command[2]=u2' --map 'command[3]=u3' \
    --map 'command[4]=u4' -o driven.csv
piezoloop diagnose --model datasheet.toml --log driven.csv --repair repaired.toml --report datasheet.html
piezoloop -q simulate repaired.toml --log drive.csv --map 'command[1]=u1' --map 'command[2]=u2' --map 'command[3]=u3' \
    --map 'command[4]=u4' -o repaired.csv
piezoloop -q simulate datasheet.toml --log drive.csv --map 'command[1]=u1' --map 'command[2]=u2' --map 'command[3]=u3' \
    --map 'command[4]=u4' -o datasheet.csv
"$python" "$here/logs.py" compare

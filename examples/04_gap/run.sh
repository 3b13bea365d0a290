#!/bin/sh
# Runs this example in the folder given, or in a new one. Needs `piezoloop` on the PATH.
set -e
here=$(cd "$(dirname "$0")" && pwd)
cd "${1:-$(mktemp -d)}"
cp "$here/model.toml" "$here/machine.toml" .

# Signals to play: a multisine, nested loops, a staircase; and another multisine to judge by.
common="--set low=5 --set high=125 --set sample_time=2e-4"
piezoloop signal multisine $common --set highest_frequency=900 --set periods=2 -o multisine.csv
piezoloop signal triangle-decaying $common --set frequency=5 --set cycles=8 -o loops.csv
piezoloop signal staircase $common --set steps=4 --set hold=0.2 -o stairs.csv
piezoloop signal multisine $common --set highest_frequency=400 --set periods=2 --set seed=7 -o new.csv

# The machine answers; its logs are all that the diagnosis gets to see of it.
for signal in multisine loops stairs new; do
    piezoloop simulate machine.toml --log $signal.csv --map 'command[1]=u' -o log_$signal.csv
done

# The model as a blueprint: effects go in where they act.
piezoloop diagnose --model model.toml --log log_multisine.csv --log log_loops.csv \
    --log log_stairs.csv --holdout log_new.csv \
    --json gap.json --report gap.html --repair repaired.toml --next-experiment next.csv \
    --picture gap.svg

# The same model as an FMU, of which nobody sees the inside: effects go around it.
piezoloop pack model.toml -o model.fmu
piezoloop diagnose --model model.fmu --log log_multisine.csv --log log_loops.csv \
    --log log_stairs.csv --holdout log_new.csv --tune '*.frequency=0.01' \
    --json gap_fmu.json --report gap_fmu.html --repair repaired.fmu

# Both repaired models against a log that no diagnosis has seen.
piezoloop signal multisine $common --set highest_frequency=200 --set seed=11 -o unseen.csv
piezoloop simulate machine.toml --log unseen.csv --map 'command[1]=u' -o log_unseen.csv
for model in model.toml repaired.toml repaired.fmu; do
    echo "$model against a new log:"
    piezoloop simulate $model --log log_unseen.csv
done

#!/bin/sh
# Runs this example in the folder given, or in a new one. Needs `piezoloop` on the PATH.
set -e
here=$(cd "$(dirname "$0")" && pwd)
cd "${1:-$(mktemp -d)}"

# Nested loops, slow and ten times as fast, played to a machine with creep and noise.
nested="--set low=0 --set high=120 --set sample_time=1e-3"
piezoloop signal triangle-decaying $nested --set frequency=2 --set cycles=6 -o slow.csv
piezoloop signal triangle-decaying $nested --set frequency=20 --set cycles=40 -o fast.csv
for signal in slow fast; do
    piezoloop simulate evc-truth --log $signal.csv --map 'command[1]=u' -o log_$signal.csv
done

# Every hysteresis model on the same logs; the second half of each is held out.
piezoloop identify --log log_slow.csv --log log_fast.csv --input 'command[1]' --output 'position[1]' \
    --plays 10 --all models -o best.toml --report page.html --picture loop.svg

# Plays between two curves with a small network, which is learned and not among `--all`.
piezoloop identify --log log_slow.csv --log log_fast.csv --input 'command[1]' --output 'position[1]' \
    --plays 10 --model learned-plays -o network.toml

# The same on a measured stack, where its log is at hand.
stack="$here/../../../shared/data/pea_p885_1hz_inverse_ff/model_1hz_3v6.csv"
if [ -f "$stack" ]; then
    echo "PI P-885.91 stack, 1 Hz:"
    piezoloop identify --log "$stack" --input u --output y --unit u=V --unit y=um --drop 2 --rest 0 \
        --all stack -o stack.toml --report stack.html --picture stack.svg
    piezoloop identify --log "$stack" --input u --output y --unit u=V --unit y=um --drop 2 --rest 0 \
        --model learned-plays -o stack_network.toml
else
    echo "SKIPPED: the measured stack: $stack is not there"
fi

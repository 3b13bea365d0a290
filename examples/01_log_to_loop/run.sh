#!/bin/sh
# From a measured log to a closed loop; the results go into the folder given, by default this one.
set -eu
here=$(cd "$(dirname "$0")" && pwd)
cd "${1:-$here}"
piezoloop identify --log "$here/stage.csv" --input u --output y --model prandtl-ishlinskii -o plant.toml --report identify.html --picture loop.svg
piezoloop invert plant.toml --period 2e-5 -o controller.toml
piezoloop pack plant.toml --step 2e-5 -o plant.fmu
piezoloop pack controller.toml -o controller.fmu
piezoloop check plant.fmu controller.fmu
piezoloop simulate plant.fmu --log "$here/stage.csv" -o run.csv
piezoloop simulate --loop plant.fmu controller.fmu --reference "$here/reference.csv" --drop 0.05 -o loop.csv

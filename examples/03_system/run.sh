#!/bin/sh
# Runs this example in the folder given, or in a new one. Needs `piezoloop` on the PATH.
set -e
here=$(cd "$(dirname "$0")" && pwd)
cd "${1:-$(mktemp -d)}"
cp "$here"/loop.toml "$here"/reference.csv "$here"/*.ssv .
piezoloop pack evc --all-effects -o plant.fmu
piezoloop invert evc -o controller.toml
piezoloop pack controller.toml -o controller.fmu
piezoloop system loop.toml --input reference.csv -o run.csv
piezoloop system loop.toml --export loop.ssp
piezoloop system loop.ssp --input reference.csv -o ssp.csv
piezoloop system loop.ssp --input reference.csv --isolate -o isolated.csv
piezoloop system loop.ssp --input reference.csv --algorithm jacobi -o jacobi.csv
piezoloop system loop.ssp --input reference.csv --parameters nominal.ssv -o nominal.csv
piezoloop system loop.ssp --input reference.csv --parameters repaired.ssv -o repaired.csv

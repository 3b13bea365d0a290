#!/bin/sh
# Runs this example in the folder given, or in a new one. Needs `piezoloop` on the PATH, a C compiler and Python.
set -e
here=$(cd "$(dirname "$0")" && pwd)
cd "${1:-$(mktemp -d)}"
cp "$here"/process.c "$here"/modelDescription.xml "$here"/cutting.toml "$here"/air.ssv .
mkdir -p process/binaries/linux64 process/sources
cp modelDescription.xml process && cp process.c process/sources
cc -std=c11 -O2 -shared -fPIC -w -o process/binaries/linux64/process.so process.c -lm
(cd process && "${PYTHON:-python3}" -m zipfile -c ../process.fmu modelDescription.xml binaries sources)
piezoloop check process.fmu
piezoloop pack evc --ports mechanical,electrical --port-value 'stiffness=20 N/um' --port-value 'capacitance=3.1 uF' -o plant.fmu
piezoloop invert evc -o controller.toml
piezoloop pack controller.toml -o controller.fmu
piezoloop signal p4-ellipse --rename 'y=reference[1]' --rename 'z=reference[2]' -o ellipse.csv
piezoloop system cutting.toml --input ellipse.csv -o cut.csv
piezoloop system cutting.toml --export cutting.ssp
piezoloop system cutting.ssp --input ellipse.csv -o ssp.csv
piezoloop system cutting.ssp --input ellipse.csv --parameters air.ssv -o air.csv

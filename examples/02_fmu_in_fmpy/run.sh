#!/bin/sh
# Runs this example in the folder given, or in a new one. Needs `piezoloop` on the PATH, and a Python
# with fmpy, which the variable PYTHON may name.
set -e
here=$(cd "$(dirname "$0")" && pwd)
cd "${1:-$(mktemp -d)}"
piezoloop pack evc -o plant.fmu
piezoloop pack evc --fmi 3 -o plant3.fmu
piezoloop check plant.fmu plant3.fmu
"${PYTHON:-python3}" "$here/loop.py"

"""The loop of plant.fmu and controller.fmu as a container FMU of the FMU Manipulation Toolbox.

Compares the container's trajectory with ours (run.csv). Arguments: the order that is meant, and the
version of the standard, in which the axes are scalars (2) or arrays (3). What the toolbox says of the
wiring is its affair; whatever else it complains of ends the script.
"""

import json
import subprocess
import sys
from pathlib import Path

import numpy as np
from fmpy import extract, read_model_description
from fmpy.fmi2 import FMU2Slave
from fmpy.fmi3 import FMU3Slave
from fmpy.util import read_csv

one_after_the_other, version = sys.argv[1] == "controller-first", sys.argv[2]
axes = (1, 2)
elements = [""] if version == "3" else [f"[{i}]" for i in axes]
assembly = {
    "name": "loop.fmu",
    "step_size": 20e-6,
    "sequential": one_after_the_other,
    "auto_link": False,
    "auto_input": False,
    "auto_output": False,
    "fmu": ["controller.fmu", "plant.fmu"],
    "link": [["controller.fmu", f"command{i}", "plant.fmu", f"command{i}"] for i in elements]
    + [["plant.fmu", f"position{i}", "controller.fmu", f"measured{i}"] for i in elements],
    "input": [[f"r{i}", "controller.fmu", f"reference{i}"] for i in elements],
    "output": [["plant.fmu", f"position{i}", f"y{i}"] for i in elements],
}
Path("loop.json").write_text(json.dumps(assembly))
tool = Path(sys.executable).with_name("fmucontainer")
done = subprocess.run([tool, "-fmu-directory", ".", "-fmi", version, "-container", "loop.json"],
                      capture_output=True, text=True)
said = done.stdout + done.stderr
assert done.returncode == 0, said
of_the_wiring = ("is not connected", "Loop of links through the embedded FMU")
for line in said.splitlines():
    fine = line.startswith("INFO ") or any(words in line for words in of_the_wiring)
    assert fine, line

# Its own model description of FMI 3.0 is not valid, hence no validation.
description = read_model_description("loop.fmu", validate=False)
references = {v.name: v.valueReference for v in description.modelVariables}
slave = FMU3Slave if version == "3" else FMU2Slave
fmu = slave(guid=description.guid, unzipDirectory=extract("loop.fmu"), instanceName="loop",
            modelIdentifier=description.coSimulation.modelIdentifier)
fmu.instantiate()
if version == "2":
    fmu.setupExperiment(startTime=0.0)
fmu.enterInitializationMode()
fmu.exitInitializationMode()
reference, ours = read_csv("reference.csv"), read_csv("run.csv")
r, y = [references[f"r{i}"] for i in elements], [references[f"y{i}"] for i in elements]
write = fmu.setFloat64 if version == "3" else fmu.setReal
read = (lambda: fmu.getFloat64(y, nValues=2)) if version == "3" else (lambda: fmu.getReal(y))
time = reference["time"]
run = [read()]
for k in range(len(time) - 1):
    write(r, [reference[f"reference[{i}]"][k] for i in axes])
    fmu.doStep(time[k], time[k + 1] - time[k])
    run.append(read())
fmu.terminate()
fmu.freeInstance()
for i in axes:
    want = ours[f"position[{i}]"]
    difference = np.abs(np.array(run)[:, i - 1] - want).max() / np.ptp(want)
    assert np.ptp(want) > 1.0 and difference <= 1e-9, (i, difference)
    print(f"fmucontainer, FMI {version}.0, {sys.argv[1]}: position[{i}] differs by {difference:g} "
          "of its range")

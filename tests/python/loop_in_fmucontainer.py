"""The loop of plant.fmu and controller.fmu as a container FMU of the FMU Manipulation Toolbox.

Compares the container's trajectory with ours (run.csv); the argument says which order is meant.
"""

import json
import subprocess
import sys
from pathlib import Path

import numpy as np
from fmpy import extract, read_model_description
from fmpy.fmi2 import FMU2Slave
from fmpy.util import read_csv

one_after_the_other = sys.argv[1] == "controller-first"
axes = (1, 2)
assembly = {
    "name": "loop.fmu",
    "step_size": 20e-6,
    "sequential": one_after_the_other,
    "auto_link": False,
    "auto_input": False,
    "auto_output": False,
    "fmu": ["controller.fmu", "plant.fmu"],
    "link": [["controller.fmu", f"command[{i}]", "plant.fmu", f"command[{i}]"] for i in axes]
    + [["plant.fmu", f"position[{i}]", "controller.fmu", f"measured[{i}]"] for i in axes],
    "input": [[f"r{i}", "controller.fmu", f"reference[{i}]"] for i in axes],
    "output": [["plant.fmu", f"position[{i}]", f"y{i}"] for i in axes],
}
Path("loop.json").write_text(json.dumps(assembly))
tool = Path(sys.executable).with_name("fmucontainer")
subprocess.run([tool, "-fmu-directory", ".", "-container", "loop.json"], check=True, capture_output=True)

description = read_model_description("loop.fmu", validate=False)
references = {v.name: v.valueReference for v in description.modelVariables}
fmu = FMU2Slave(guid=description.guid, unzipDirectory=extract("loop.fmu"), instanceName="loop",
                modelIdentifier=description.coSimulation.modelIdentifier)
fmu.instantiate()
fmu.setupExperiment(startTime=0.0)
fmu.enterInitializationMode()
fmu.exitInitializationMode()
reference, ours = read_csv("reference.csv"), read_csv("run.csv")
r, y = [references[f"r{i}"] for i in axes], [references[f"y{i}"] for i in axes]
time = reference["time"]
run = [fmu.getReal(y)]
for k in range(len(time) - 1):
    fmu.setReal(r, [reference[f"reference[{i}]"][k] for i in axes])
    fmu.doStep(time[k], time[k + 1] - time[k])
    run.append(fmu.getReal(y))
fmu.terminate()
fmu.freeInstance()
for i in axes:
    want = ours[f"position[{i}]"]
    difference = np.abs(np.array(run)[:, i - 1] - want).max() / np.ptp(want)
    assert np.ptp(want) > 1.0 and difference <= 1e-9, (i, difference)
    print(f"fmucontainer, {sys.argv[1]}: position[{i}] differs by {difference:g} of its range")

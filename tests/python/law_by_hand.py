"""The same integral law computed here, around stage.fmu in fmpy; compared with our run of the loop
of stage.fmu and the law's FMU. The controller steps first."""

import numpy as np
from fmpy import extract, read_model_description
from fmpy.fmi2 import FMU2Slave
from fmpy.util import read_csv

description = read_model_description("stage.fmu")
references = {v.name: v.valueReference for v in description.modelVariables}
fmu = FMU2Slave(guid=description.guid, unzipDirectory=extract("stage.fmu"), instanceName="stage",
                modelIdentifier=description.coSimulation.modelIdentifier)
fmu.instantiate()
fmu.setupExperiment(startTime=0.0)
fmu.enterInitializationMode()
fmu.exitInitializationMode()
ours = read_csv("run.csv")
reference, time = read_csv("reference.csv")["reference[1]"], ours["time"]
u, y = [references["command[1]"]], [references["position[1]"]]
command, run = 0.0, [fmu.getReal(y)[0]]
for k in range(len(time) - 1):
    step = time[k + 1] - time[k]
    command += 400.0 * step * (reference[k] - run[-1])
    fmu.setReal(u, [command])
    fmu.doStep(time[k], step)
    run.append(fmu.getReal(y)[0])
want = ours["position[1]"]
difference = np.abs(np.array(run) - want).max() / np.ptp(want)
print(f"a law of PythonFMU in our master: position[1] differs by {difference:g} of its range")
assert np.ptp(want) > 1.0 and difference <= 1e-9, difference

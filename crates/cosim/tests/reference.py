"""The same runs in fmpy: by simulate_fmu, and a closed loop stepped by hand.

usage: reference.py drive FMU TABLE | reference.py loop CONTROLLER PLANT STEP STEPS GAIN COUPLING
Prints lines `row numbers,…` among what fmpy prints.
"""
import shutil
import sys

import fmpy
import numpy as np
from fmpy.fmi2 import FMU2Slave


def drive(fmu, table):
    signals = np.genfromtxt(table, delimiter=",", names=True, deletechars="")
    description = fmpy.read_model_description(fmu)
    folder = fmpy.extract(fmu)
    instance = fmpy.instantiate_fmu(folder, description, "CoSimulation")
    time = signals["time"]
    result = fmpy.simulate_fmu(
        folder, fmu_instance=instance, start_time=time[0], stop_time=time[-1],
        output_interval=(time[-1] - time[0]) / (len(time) - 1), input=signals,
        start_values={"k": 3.0}, output=["position[1]"])
    print("history", instance.getString([1])[0].decode())
    for t, y in zip(result["time"], result["position[1]"]):
        print(f"row {float(t)!r},{float(y)!r}")
    instance.freeInstance()
    shutil.rmtree(folder)


def slave(fmu, stop):
    description = fmpy.read_model_description(fmu)
    instance = FMU2Slave(guid=description.guid, unzipDirectory=fmpy.extract(fmu),
                         modelIdentifier=description.coSimulation.modelIdentifier,
                         instanceName=description.modelName)
    instance.instantiate()
    instance.setupExperiment(startTime=0.0, stopTime=stop)
    references = {v.name: v.valueReference for v in description.modelVariables}
    return instance, references


def loop(controller_fmu, plant_fmu, dt, steps, gain, coupling):
    controller, c = slave(controller_fmu, steps * dt)
    plant, p = slave(plant_fmu, steps * dt)
    controller.setReal([c["k"]], [gain])
    for instance in controller, plant:
        instance.enterInitializationMode()
        instance.exitInitializationMode()
    for k in range(steps):
        t, h = k * dt, (k + 1) * dt - k * dt
        y = plant.getReal([p["position[1]"]])
        u = controller.getReal([c["command[1]"]])
        controller.setReal([c["reference[1]"], c["measured[1]"]], [np.sin(0.3 * k), *y])
        controller.doStep(t, h)
        if coupling == "controller-first":
            u = controller.getReal([c["command[1]"]])
        print(f"row {float(u[0])!r},{float(y[0])!r}")
        plant.setReal([p["command[1]"]], u)
        plant.doStep(t, h)
    for instance in controller, plant:
        instance.terminate()
        instance.freeInstance()


if sys.argv[1] == "drive":
    drive(*sys.argv[2:])
else:
    loop(sys.argv[2], sys.argv[3], float(sys.argv[4]), int(sys.argv[5]), float(sys.argv[6]),
         sys.argv[7])

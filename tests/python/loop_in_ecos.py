"""The loop of plant.fmu and controller.fmu in ecos, whose fixed-step algorithm is Jacobi."""

import sys

import numpy as np
from fmpy.util import read_csv

try:
    from ecospy import EcosSimulation, EcosSimulationStructure
except OSError as error:
    print("SKIPPED: ecospy does not load:", error)
    sys.exit()

axes = (1, 2)
reference, ours = read_csv("reference.csv"), read_csv("run.csv")
with EcosSimulationStructure() as structure:
    structure.add_model("plant", "plant.fmu")
    structure.add_model("controller", "controller.fmu")
    for i in axes:
        structure.make_real_connection(f"controller::command[{i}]", f"plant::command[{i}]")
        structure.make_real_connection(f"plant::position[{i}]", f"controller::measured[{i}]")
    with EcosSimulation(structure=structure, step_size=20e-6) as simulation:
        simulation.init()
        read = lambda: [simulation.get_real(f"plant::position[{i}]") for i in axes]
        run = [read()]
        for k in range(len(reference) - 1):
            for i in axes:
                simulation.set_real(f"controller::reference[{i}]", reference[f"reference[{i}]"][k])
            simulation.step(1)
            run.append(read())
        simulation.terminate()
for i in axes:
    want = ours[f"position[{i}]"]
    difference = np.abs(np.array(run)[:, i - 1] - want).max() / np.ptp(want)
    assert np.ptp(want) > 1.0 and difference <= 1e-9, (i, difference)
    print(f"ecos: position[{i}] differs by {difference:g} of its range")

"""loop.ssp with each parameter set in fmpy.ssp, and its FMUs and connections in ecos: as in our master.

fmpy.ssp is Jacobi with a step of delay on every connection, those from the system's inputs too, and
its row k is our row k + 1; so its references are given one step ahead. ecos knows no connectors of
the outermost system, so it gets the components, the connections between them and the parameters.
"""

import sys
import zipfile

import numpy as np
from fmpy.ssp.simulation import simulate_ssp
from fmpy.ssp.ssd import System, get_connections, read_ssd, read_ssv
from fmpy.util import read_csv

STEP = 20e-6
AXES = (1, 2)


def in_fmpy(parameters, reference):
    last = len(reference) - 1
    ahead = {
        name: lambda t, name=name: reference[name][min(round(t / STEP) + 1, last)]
        for name in (f"reference[{i}]" for i in AXES)
    }
    run = simulate_ssp("loop.ssp", stop_time=reference["time"][-1], step_size=STEP,
                       parameter_set=parameters, input=ahead)
    return np.array([run[f"plant.position[{i}]"] for i in AXES]).T


def in_ecos(parameters, reference):
    from ecospy import EcosSimulation, EcosSimulationStructure

    system = read_ssd("loop.ssp").system
    with zipfile.ZipFile("loop.ssp") as archive:
        archive.extractall("loop")
    with EcosSimulationStructure() as structure:
        for component in system.elements:
            structure.add_model(component.name, f"loop/{component.source}")
        for a, b in get_connections(system):
            if not isinstance(a.parent, System) and not isinstance(b.parent, System):
                structure.make_real_connection(f"{a.parent.name}::{a.name}", f"{b.parent.name}::{b.name}")
        start = {
            parameter.name.replace(".", "::", 1):
                parameter.value == "true" if parameter.type == "Boolean" else float(parameter.value)
            for parameter in parameters.parameters
        }
        structure.add_parameter_set("start", start)
        with EcosSimulation(structure=structure, step_size=STEP) as simulation:
            assert simulation.init(parameter_set="start")
            rows = []
            for k in range(len(reference) - 1):
                for i in AXES:
                    simulation.set_real(f"controller::reference[{i}]", reference[f"reference[{i}]"][k])
                simulation.step(1)
                rows.append([simulation.get_real(f"plant::position[{i}]") for i in AXES])
            simulation.terminate()
    return np.array(rows)


def main():
    tool = {"fmpy.ssp": in_fmpy, "ecos": in_ecos}[sys.argv[1]]
    reference = read_csv("short.csv")
    runs = []
    for name in ("nominal", "repaired"):
        ours = read_csv(f"{name}.csv")
        ours = np.array([ours[f"position[{i}]"] for i in AXES]).T[1:]
        theirs = tool(read_ssv(f"{name}.ssv"), reference)[: len(ours)]
        apart = np.abs(theirs - ours).max() / np.ptp(ours)
        print(f"{sys.argv[1]}, {name}.ssv: positions differ by {apart:.1e} of their range")
        assert np.ptp(ours) > 1.0 and apart <= 1e-9
        runs.append(ours)
    assert np.abs(runs[0] - runs[1]).max() > 0.01, "the sets make a difference"


main()

"""cutting.ssp of example 11 in fmpy.ssp, libcosim or ecos: tip, force and power as in our master side by side.

fmpy.ssp has a step of delay on every connection, those from the system's inputs too, and its row k is our row k + 1, so
its references are given one step ahead. libcosim and ecos know no connectors of the outermost system: libcosim reads the
SSP without them, ecos gets components and connections, and both are given the references step by step.
"""

import re
import sys
import zipfile

import numpy as np
from fmpy import read_model_description
from fmpy.ssp.ssd import System, get_connections, read_ssd
from fmpy.util import read_csv

STEP = 20e-6
WANTED = {"plant": ["tip[1]", "tip[2]", "position[1]", "position[2]", "current[1]"], "process": ["force_y", "force_z", "power"]}


def columns():
    return [f"{fmu}.{name}" for fmu, names in WANTED.items() for name in names]


def in_fmpy(reference, rows):
    from fmpy.ssp.simulation import simulate_ssp

    last = len(reference["time"]) - 1
    ahead = {
        name: lambda t, name=name: reference[name][min(round(t / STEP) + 1, last)]
        for name in ("reference[1]", "reference[2]")
    }
    run = simulate_ssp("cutting.ssp", stop_time=(rows - 1) * STEP, step_size=STEP, input=ahead)
    return np.array([run[name] for name in columns()]).T


def unpacked():
    with zipfile.ZipFile("cutting.ssp") as archive:
        archive.extractall("cutting")
    return read_ssd("cutting.ssp").system


def numbers(system):
    """Value references of each FMU's variables."""
    found = {}
    for component in system.elements:
        described = read_model_description(f"cutting/{component.source}")
        found[component.name] = {v.name: v.valueReference for v in described.modelVariables}
    return found


def in_libcosim(reference, rows):
    from libcosimpy.CosimExecution import CosimExecution
    from libcosimpy.CosimManipulator import CosimManipulator
    from libcosimpy.CosimObserver import CosimObserver

    vr = numbers(unpacked())
    with zipfile.ZipFile("cutting.ssp") as whole, zipfile.ZipFile("inner.ssp", "w") as inner:
        for name in whole.namelist():
            content = whole.read(name)
            if name == "SystemStructure.ssd":
                text = re.sub(r"<ssd:Connection (?:startConnector|startElement=\S+ startConnector=\S+ endConnector)=[^>]*/>", "", content.decode())
                assert text != content.decode(), "connections of the outermost system are left out"
                content = text.encode()
            inner.writestr(name, content)
    execution = CosimExecution.from_ssp_file(ssp_path="inner.ssp", step_size=round(STEP * 1e9))
    observer, manipulator = CosimObserver.create_last_value(), CosimManipulator.create_override()
    assert execution.add_observer(observer) and execution.add_manipulator(manipulator)
    at = {name: execution.slave_index_from_instance_name(name) for name in vr}
    of_reference = [vr["controller"][f"reference[{i}]"] for i in (1, 2)]
    table = []
    for k in range(rows - 1):
        values = [float(reference[f"reference[{i}]"][k]) for i in (1, 2)]
        assert manipulator.slave_real_values(at["controller"], of_reference, values)
        assert execution.step()
        table.append([x for fmu, names in WANTED.items() for x in observer.last_real_values(at[fmu], [vr[fmu][n] for n in names])])
    return np.array(table)


def in_ecos(reference, rows):
    from ecospy import EcosSimulation, EcosSimulationStructure

    system = unpacked()
    with EcosSimulationStructure() as structure:
        for component in system.elements:
            structure.add_model(component.name, f"cutting/{component.source}")
        for a, b in get_connections(system):
            if not isinstance(a.parent, System) and not isinstance(b.parent, System):
                structure.make_real_connection(f"{a.parent.name}::{a.name}", f"{b.parent.name}::{b.name}")
        with EcosSimulation(structure=structure, step_size=STEP) as simulation:
            assert simulation.init()
            table = []
            for k in range(rows - 1):
                for i in (1, 2):
                    simulation.set_real(f"controller::reference[{i}]", reference[f"reference[{i}]"][k])
                simulation.step(1)
                table.append([simulation.get_real(name.replace(".", "::", 1)) for name in columns()])
            simulation.terminate()
    return np.array(table)


def main():
    tool = {"fmpy.ssp": in_fmpy, "libcosim": in_libcosim, "ecos": in_ecos}[sys.argv[1]]
    ours, reference = read_csv("jacobi.csv"), read_csv("ellipse.csv")
    names = {"force_y": "force[1]", "force_z": "force[2]"}
    ours = np.array([ours[names.get(name, name)] for names_ in WANTED.values() for name in names_]).T[1:]
    theirs = tool(reference, len(ours) + 1)[: len(ours)]
    assert theirs.shape == ours.shape, (theirs.shape, ours.shape)
    for k, name in enumerate(columns()):
        size = np.ptp(ours[:, k])
        apart = np.abs(theirs[:, k] - ours[:, k]).max() / size
        print(f"{sys.argv[1]}, {name}: differs by {apart:.1e} of its range, {size:.3g}")
        assert size > 0 and apart <= 1e-9, name


main()

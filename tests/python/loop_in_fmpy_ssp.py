"""The loop of plant.fmu and controller.fmu as an SSP system in fmpy.ssp.

fmpy.ssp is Jacobi with a step of delay on *every* connection, those from the system's inputs too,
and records a row at t_k after the step from t_k. So its references are given one step ahead, and
its row k is compared with our row k + 1.

With an argument that file, written by our tool, is the system; else it is written here.
"""

import sys
import zipfile

import numpy as np
from fmpy.ssp.simulation import simulate_ssp
from fmpy.util import read_csv

axes = (1, 2)
step = 20e-6


def connectors(inputs, outputs):
    kinds = [(name, "input") for name in inputs] + [(name, "output") for name in outputs]
    one = '<ssd:Connector name="{}" kind="{}"><ssc:Real/></ssd:Connector>'
    return "<ssd:Connectors>" + "".join(one.format(*kind) for kind in kinds) + "</ssd:Connectors>"


def component(name, inputs, outputs):
    return (f'<ssd:Component name="{name}" type="application/x-fmu-sharedlibrary" '
            f'source="resources/{name}.fmu">{connectors(inputs, outputs)}</ssd:Component>')


def connection(start, start_connector, end, end_connector):
    start = f'startElement="{start}" ' if start else ""
    end = f'endElement="{end}" ' if end else ""
    return (f'<ssd:Connection {start}startConnector="{start_connector}" '
            f'{end}endConnector="{end_connector}"/>')


def named(kind):
    return [f"{kind}[{i}]" for i in axes]


elements = component("controller", named("reference") + named("measured"), named("command"))
elements += component("plant", named("command"), named("position"))
connections = "".join(
    connection("controller", f"command[{i}]", "plant", f"command[{i}]")
    + connection("plant", f"position[{i}]", "controller", f"measured[{i}]")
    + connection(None, f"reference[{i}]", "controller", f"reference[{i}]")
    + connection("plant", f"position[{i}]", None, f"position[{i}]")
    for i in axes
)
root = "http://ssp-standard.org/SSP1"
description = f"""<?xml version="1.0" encoding="UTF-8"?>
<ssd:SystemStructureDescription xmlns:ssd="{root}/SystemStructureDescription"
 xmlns:ssc="{root}/SystemStructureCommon" name="loop" version="1.0"><ssd:System name="loop">
{connectors(named("reference"), named("position"))}<ssd:Elements>{elements}</ssd:Elements>
<ssd:Connections>{connections}</ssd:Connections></ssd:System></ssd:SystemStructureDescription>"""
system = sys.argv[1] if len(sys.argv) > 1 else "by_hand.ssp"
if system == "by_hand.ssp":
    with zipfile.ZipFile(system, "w") as archive:
        archive.writestr("SystemStructure.ssd", description)
        for name in ("plant", "controller"):
            archive.write(f"{name}.fmu", f"resources/{name}.fmu")

reference, ours = read_csv("reference.csv"), read_csv("run.csv")
last = len(reference) - 1
ahead = {
    name: lambda t, name=name: reference[name][min(round(t / step) + 1, last)]
    for name in named("reference")
}
assert all(reference[name][0] == 0.0 for name in named("reference")), "fmpy.ssp begins with zeros"
run = simulate_ssp(system, stop_time=reference["time"][-1], step_size=step, input=ahead)
for name in named("position"):
    want = ours[name][1:]
    difference = np.abs(run[name][: len(want)] - want).max() / np.ptp(want)
    assert np.ptp(want) > 1.0 and difference <= 1e-9, (name, difference)
    print(f"fmpy.ssp, {system}: {name} differs by {difference:g} of its range")

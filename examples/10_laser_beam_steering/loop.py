"""Machine and controller in fmpy, stepped in turn; errors on both detectors, and a picture of the beams' paths."""

import fmpy
from fmpy.fmi2 import FMU2Slave

from logs import AXES, read, report


class Unit:
    """An FMU that is stepped."""

    def __init__(self, file):
        description = fmpy.read_model_description(file)
        self.name = {variable.name: variable.valueReference for variable in description.modelVariables}
        self.slave = FMU2Slave(
            guid=description.guid,
            unzipDirectory=fmpy.extract(file),
            modelIdentifier=description.coSimulation.modelIdentifier,
        )
        self.slave.instantiate()
        self.slave.setupExperiment(startTime=0)
        self.slave.enterInitializationMode()

    def set(self, name, values):
        self.slave.setReal([self.name[f"{name}[{k}]"] for k in AXES], values)

    def get(self, name):
        return self.slave.getReal([self.name[f"{name}[{k}]"] for k in AXES])


def run(rate):
    path = read(f"path{rate}.csv")
    references = list(zip(*(path[f"reference[{k}]"] for k in AXES)))
    machine, controller = Unit("machine.fmu"), Unit("controller.fmu")
    controller.set("reference", references[0])
    machine.set("command", controller.get("command"))
    controller.set("measured", machine.get("position"))
    for unit in (machine, controller):
        unit.slave.exitInitializationMode()
    step, positions = 0.005, []
    for row, wanted in enumerate(references):
        positions.append(machine.get("position"))
        controller.set("reference", wanted)
        controller.set("measured", positions[-1])
        controller.slave.doStep(row * step, step)
        machine.set("command", controller.get("command"))
        machine.slave.doStep(row * step, step)
    columns = {f"position[{k}]": [row[k - 1] for row in positions] for k in AXES}
    columns |= {f"reference[{k}]": path[f"reference[{k}]"] for k in AXES}
    report(f"in fmpy, rate {rate}", columns, 200)
    return columns


def picture(columns, file):
    """The path of the beam on both detectors: wanted, and found with ten times the error."""
    parts = []
    for psd, left in ((0, 20), (1, 340)):
        x, y = 2 * psd + 1, 2 * psd + 2
        wanted = list(zip(columns[f"reference[{x}]"], columns[f"reference[{y}]"]))[200:]
        found = list(zip(columns[f"position[{x}]"], columns[f"position[{y}]"]))[200:]
        far = [(r[0] + 10 * (p[0] - r[0]), r[1] + 10 * (p[1] - r[1])) for r, p in zip(wanted, found)]
        lows = [min(point[k] for point in far) for k in (0, 1)]
        scale = 260 / max(max(point[k] for point in far) - lows[k] for k in (0, 1))
        at = lambda point: f"{left + (point[0] - lows[0]) * scale:.1f},{300 - (point[1] - lows[1]) * scale:.1f}"
        for points, colour, width in ((wanted, "#999", 3), (far, "#06c", 1)):
            line = " ".join(at(point) for point in points)
            parts.append(f'<polyline points="{line}" fill="none" stroke="{colour}" stroke-width="{width}"/>')
        parts.append(f'<text x="{left}" y="322">PSD {psd + 1}, {50 * scale:.0f} px are 50 um</text>')
    with open(file, "w") as text:
        text.write(
            '<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 640 350" font-family="sans-serif" font-size="13">'
            '<rect width="640" height="350" fill="#fff"/>'
            + "".join(parts)
            + '<text x="20" y="342">grey: wanted; blue: found, with ten times the error</text></svg>'
        )


run(1)
picture(run(2), "paths.svg")

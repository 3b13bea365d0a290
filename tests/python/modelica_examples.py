"""The text of modelica/Piezoloop/Examples and Rigs: made from the cases and the tool's rigs, so that what is shown is what is tried."""

import html
import re

from modelica_cases import CONTROLLER, COUPLING, PLANT

RESERVED = {"initial", "delay", "sample", "pre", "der", "reinit", "time"}
STEP, ROWS = 1e-4, 300
# Steps in which what can be switched off is off: from the first to the one before the second. The command is held inside its limits
# then: at a limit, anti-windup at the return depends on the last bit.
OFF = (72, 121)
# The two waves of all cases: amplitudes and frequencies.
WAVES = {1: ([40.0, 12.0], [60.0, 170.0]), 2: ([30.0], [90.0])}
INPUT = re.compile(r"^    (?:Interfaces\.\w+Input|input Boolean) (\w+)(?:\[axes\])?(?: |\()", re.M)
# Further inputs: number of the wave (0: none), factor, offset, in the connectors' units.
FURTHER = {"displacement": (0, 0.0, 0.0), "n": (0, 0.0, 0.0), "drive": (0, 0.0, 0.0), "temperature": (2, 0.1, 273.15),
           "force": (2, 0.5, 0.0), "disturbance": (2, 0.01e-6, 0.0), "command": (1, 1.0, 0.0),
           "reference": (1, 1e-6, 0.0), "measured": (2, 0.5e-6, 0.0)}
# Control components that stand behind a feedforward of 8 V/um, and those whose reference the law behind them sees.
BEHIND, BEFORE = {"pid", "incremental-pid", "repetitive", "command-curve"}, {"reference-filter", "reference-preview"}


def camel(kind):
    return "".join(part.capitalize() for part in re.split("[- ]", kind))


def further(text):
    return [name for name in INPUT.findall(text) if name != "u"]


def scales(text):
    """What turns um into the connectors' metres: factors of the input u and of the output y."""
    base = re.search(r"extends Interfaces\.(\w+);", text)
    base = base[1] if base else "PositionFilter"
    return (1e-6 if base in ("PositionFilter", "Inverse", "ReferenceFilter") else 1.0,
            1e-6 if base in ("PositionFilter", "Actuator", "ReferenceFilter") else 1.0)


def flat(rows):
    return [cell for row in rows for cell in row] if isinstance(rows[0], list) else rows


def value(x):
    if isinstance(x, bool):
        return str(x).lower()
    if isinstance(x, list):
        return "{" + ", ".join(value(cell) for cell in flat(x)) + "}"
    return repr(x)


def modifiers(row, parameters, text, step=STEP, axes=2):
    """The arguments of a block; lengths of arrays are given."""
    written = dict(parameters)
    for quantity in row["parameters"]:
        length, given = quantity["length"], parameters.get(quantity["name"])
        if length and given is not None and length not in ("axes", "entries"):
            written[length] = len(flat(given))
    if re.search(r"parameter Integer entries", text):
        written["entries"] = axes * axes
    if re.search(r"parameter Integer axes", text):
        written["axes"] = axes
    if "longest" in parameters and "cells" in text:
        written["cells"] = round(parameters["longest"] / step) + 2
    if "cycle" in parameters:
        written["cells"] = round(parameters["cycle"] / step) + parameters["half"]
    if re.search(r"parameter Real step", text):
        written["step"] = step
    names = ((name + "_" if name in RESERVED else name, x) for name, x in written.items())
    return ", ".join(f"{name} = {value(x)}" for name, x in names)


def place(x, y, half=10):
    return f"annotation(Placement(transformation(extent={{{{{x - half},{y - half}}},{{{x + half},{y + half}}}}})))"


def connect(one, other, *points):
    line = ",".join(f"{{{x},{y}}}" for x, y in points)
    return f"    connect({one}, {other}) annotation(Line(points={{{line}}}, color={{0,0,127}}));"


class Model:
    """A model with its sources on the left and one component in the middle."""

    def __init__(self, name, summary, what):
        self.name, self.summary, self.what = name, summary, what
        self.declared, self.equations, self.sources = [], [], 0

    def source(self, name, wave, scale, offset, target=None):
        y = 60 - 30 * self.sources
        self.sources += 1
        if wave:
            amplitude, frequency = WAVES[wave]
            arguments = f"scale = {scale!r}, amplitude = {value(amplitude)}, frequency = {value(frequency)}, step = {STEP!r}"
            arguments = f"offset = {offset!r}, {arguments}" if offset else arguments
            self.declared.append(f"    Sources.Wave {name}({arguments}) {place(-70, y)};")
        else:
            self.declared.append(f"    Sources.Constant {name}(k = {offset!r}) {place(-70, y)};")
        if target:
            self.equations.append(connect(f"{name}.y", target, (-59, y), (-40, y), (-40, 0), (-24, 0)))

    def enable(self, target):
        y = 60 - 30 * self.sources
        self.sources += 1
        off, on = (step * STEP for step in OFF)
        self.declared.append(f"    Sources.Enable enable(off = {off!r}, on = {on!r}, step = {STEP!r}) {place(-70, y)};")
        self.equations.append(connect("enable.y", target, (-59, y), (-40, y), (-40, 0), (-24, 0)))

    def text(self, stop=(ROWS - 1) * STEP, interval=STEP):
        lines = [f'  model {self.name} "{self.summary}"', "    extends Icons.Example;", *self.declared, "  equation", *self.equations,
                 f"    annotation(experiment(StartTime=0, StopTime={stop:g}, Interval={interval:g}, Tolerance=1e-9),",
                 f'      Documentation(info="<html><p>{html.escape(self.what, quote=False)}</p></html>"));', f"  end {self.name};"]
        return "\n".join(lines)


def example(rows, written, case, parameters):
    """The example of a case: its package, its model, and the variables to look at with their factors to V and um."""
    kind = case.split()[0]
    home, summary, text = written[camel(kind)]
    name = camel(case)
    package = home.split(".")[-1]
    model = Model(name, summary, f"Block Piezoloop.{home}.{camel(kind)} as it is compared with the FMU.")
    into, out = scales(text)
    extra = further(text)
    model.declared.append(f"    Piezoloop.{home}.{camel(kind)} device({modifiers(rows[kind], parameters, text)}) {place(0, 0, 20)};")
    lead = 0.08 if case in CONTROLLER else 1.0
    wanted = [("device.y", 1 / out)]
    if case in COUPLING or kind == "jacobian-coordinator":
        unit = 1e-6 * (0.1 if case in COUPLING else lead)
        second = 1.0 if case in COUPLING else 0.5
        model.source("wave1", 1, unit, 0.0, "device.u[1]")
        model.source("wave2", 2, unit * second, 0.0, "device.u[2]")
        wanted = [("device.y[1]", 1e6), ("device.y[2]", 1e6)]
        if "command" in extra:
            model.source("command1", 1, 1.0, 0.0, "device.command[1]")
            model.source("command2", 2, 1.0, 0.0, "device.command[2]")
        if kind == "jacobian-coordinator":
            model.source("measured1", 2, 0.5 * unit, 0.0, "device.measured[1]")
            model.source("measured2", 1, 0.25 * unit, 0.0, "device.measured[2]")
            model.declared.append('    Types.Position command[2] "Twice the reference less the measured motion: feedback of gain 1";')
            model.equations += [f"    command[{i}] = 2*device.y[{i}] - device.measured_motion[{i}];" for i in (1, 2)]
            wanted = [("command[1]", 1e6), ("command[2]", 1e6)]
        return package, model, wanted
    scale = 1e-6 * 0.1 if case in PLANT and into == 1e-6 else into * lead * (8.0 if kind in BEHIND else 1.0)
    model.source("wave", 1, scale, 0.0, "device.u")
    for input_ in extra:
        if input_ == "enable":
            model.enable("device.enable")
        else:
            wave, factor, offset = FURTHER[input_]
            model.source(input_, wave, factor * (lead if wave and input_ in ("reference", "measured") else 1.0), offset, f"device.{input_}")
    if kind in BEFORE:
        model.source("measured", 2, 0.5e-6 * lead, 0.0)
        model.declared.append('    Types.Position command "Command of a law of gain 1 behind it";')
        model.equations.append("    command = device.y + device.reference - measured.y;")
        wanted = [("command", 1e6)]
    return package, model, wanted


def cases():
    return {**PLANT, **COUPLING, **CONTROLLER}


def packages(rows, written):
    """Name of the package: its text, for all examples of single components."""
    found = {}
    for case, (parameters, _) in cases().items():
        package, model, _ = example(rows, written, case, parameters)
        found.setdefault(package, []).append(model.text())
    return {
        name: f'within Piezoloop.Examples;\npackage {name} "Examples of single blocks: {name}"\n  extends Icons.ExamplesPackage;\n\n'
        + "\n\n".join(models)
        + f'\n  annotation(Documentation(info="<html><p>One model per block; the numbers are those of the comparison with the FMU.</p></html>"));\nend {name};\n'
        for name, models in found.items()
    }

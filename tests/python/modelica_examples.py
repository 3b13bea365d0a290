"""The text of modelica/Piezoloop/Examples and Rigs: made from the cases and the tool's rigs, so that what is shown is what is tried."""

import html
import math
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
           "actuator_temperature": (2, 0.1, 273.15), "voltage": (1, 1.0, 0.0), "force": (2, 0.5, 0.0), "disturbance": (2, 0.01e-6, 0.0), "command": (1, 1.0, 0.0),
           "reference": (1, 1e-6, 0.0), "measured": (2, 0.5e-6, 0.0)}
# Interfaces of control components that stand behind a feedforward of 8 V/um, and components whose reference the law behind them sees.
BEHIND = {"Controller", "CommandFilter"}
BEFORE = {"reference-filter", "reference-preview"}


def camel(kind):
    return "".join(part.capitalize() for part in re.split("[- ]", kind))


def further(text):
    return [name for name in INPUT.findall(text) if name != "u"]


def base(text):
    """The interface that a block extends."""
    found = re.search(r"extends Interfaces\.(\w+)[;(]", text)
    return found[1] if found else "PositionFilter"


def scales(text):
    """What turns um into the connectors' metres: factors of the input u and of the output y."""
    return (1e-6 if base(text) in ("PositionFilter", "Inverse", "ReferenceFilter") else 1.0,
            1e-6 if base(text) in ("PositionFilter", "Actuator", "ReferenceFilter") else 1.0)


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
    scale = 1e-6 * 0.1 if case in PLANT and into == 1e-6 else into * lead * (8.0 if case in CONTROLLER and base(text) in BEHIND else 1.0)
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


def documentation(kind, summary, pages):
    """What docs/effects.md, which is made from the registry, says of a component, as Modelica's HTML."""
    section = re.search(rf"^## {kind}\n(.*?)(?=^## |\Z)", pages, re.S | re.M)[1]
    lines = [line for line in section.strip().splitlines() if line and not line.startswith(("![", "Default strength", "* In `"))]
    out, table = [f"<p>Component <code>{kind}</code>. {html.escape(summary, quote=False)}.</p>"], []
    for line in lines[1:]:
        line = line if line.startswith("    ") else re.sub(r"\[([^]]*)\]\([^)]*\)", r"\1", line)
        text = html.escape(line, quote=False).replace('"', "'")
        if line.startswith("    "):
            out.append(f"<p><code>{text.strip()}</code></p>")
        elif line.startswith("|"):
            if not line.startswith("|---"):
                cells = [cell.strip().strip("`") for cell in text.strip("|").split(" | ")]
                cells = [cells[0].strip(), *cells[1:]]
                tag = "th" if not table else "td"
                table.append("<tr>" + "".join(f"<{tag}>{cell.strip(' |`')}</{tag}>" for cell in cells) + "</tr>")
        else:
            text = re.sub("`([^`]*)`", r"<code>\1</code>", text.removeprefix("* "))
            out.append(f"<p>{text}</p>")
    if table:
        out.insert(2, "<table border='1'>" + "".join(table) + "</table>")
    return "<html>" + "".join(out).replace("\\", "/") + "</html>"


# Rigs: the stages of a signal path, and the disturbances that they leave out.
ORDER = ["timing", "amplifier", "actuator", "mechanics", "coupling", "environment", "sensor"]
RANDOM = {"sensor-noise", "sensor-drift", "floor-vibration", "mains-hum"}


def parameters(xml, place):
    """Values of a component's parameters in an FMU's model description, arrays as lists."""
    found = {}
    pattern = rf'<ScalarVariable name="{re.escape(place)}\.(\w+)(?:\[(\d+)(?:,\d+)?\])?"[^>]*>\s*<(?:Real|Integer)[^>]*start="([^"]*)"'
    for name, index, start in re.findall(pattern, xml):
        if index:
            found.setdefault(name, []).append(float(start))
        else:
            found[name] = float(start)
    return found


def places(xml, start):
    """Names of the components of an axis or of all couplings, in the blueprint's order."""
    return list(dict.fromkeys(re.findall(rf'<ScalarVariable name="{re.escape(start)}\.(\w+)\.', xml)))


def at_rest(kind, values, u):
    """What a block of a rig gives at rest under u, in V and um."""
    plays = lambda x: sum(w * max(x - r, min(x + r, 0.0)) for r, w in zip(values["r"], values["w"]))
    if kind == "amplifier-nonlinearity":
        xi = (u - values["centre"]) / values["half_range"]
        return u + values["offset"] + values["half_range"] * (values["quadratic"] * xi**2 + values["cubic"] * xi**3)
    if kind == "generalised-play":
        side = lambda a: values[f"{a}_a0"] * math.tanh(values[f"{a}_a1"] * u + values[f"{a}_a2"]) + values[f"{a}_a3"]
        virgin = lambda a: values[f"{a}_a0"] * math.tanh(values[f"{a}_a2"]) + values[f"{a}_a3"]
        return values["offset"] + plays(max(side("left"), min(side("right"), max(virgin("left"), min(virgin("right"), 0.0)))))
    if kind == "prandtl-ishlinskii":
        return values["offset"] + plays(u)
    if kind == "kelvin-voigt-creep":
        return u * (1 + sum(values["share"]))
    return u * values.get("gain", 1.0) + (values.get("offset", 0.0) if "r" in values else 0.0)


def rig(rows, written, blueprint, xml):
    """A rig as a model: the blocks of its axes and couplings, with a hold where the FMU hands a value on once per step."""
    step, axes = float(blueprint["step"]), blueprint["axis"]
    declared, equations, delays = [], [], [0] * len(axes)
    last, dropped = [f"u[{i + 1}]" for i in range(len(axes))], []
    units, rest = ["V"] * len(axes), [0.0] * len(axes)

    def add(name, kind, values, i, x):
        home, _, text = written[camel(kind)]
        sampled = "sample(" in text
        # The state of a drift does not depend on what goes through it.
        moves = "der(" in text and not kind.startswith("thermal")
        y = 40 - 60 * i
        if moves and last_moves[i]:
            hold = f"{name}_hold"
            start = rest[i] * (1e-6 if units[i] == "m" else 1.0)
            declared.append(f"    {'Hold' if units[i] == 'm' else 'HoldCommand'} {hold}(u_start = {start!r}, step = step) {place(x - 12, y, 6)};")
            equations.append(connect(last[i], f"{hold}.u", (x - 24, y), (x - 18, y)))
            last[i], delays[i], last_moves[i] = f"{hold}.y", delays[i] + 1, False
        arguments = modifiers(rows[kind], values, text, step, 1).replace(f"step = {step!r}", "step = step")
        declared.append(f"    Piezoloop.{home}.{camel(kind)} {name}({arguments}) {place(x, y, 8)};")
        equations.append(connect(last[i], f"{name}.u", (x - 24, y), (x - 10, y)))
        last[i] = f"{name}.y"
        rest[i] = at_rest(kind, values, rest[i])
        if sampled and last_moves[i]:
            delays[i] += 1
        last_moves[i] = moves or (last_moves[i] and not sampled)
        units[i] = "m" if base(text) in ("Actuator", "PositionFilter") else "V"

    last_moves = [False] * len(axes)
    stages = {name: row["stage"] for name, row in rows.items()}
    x = [-80] * len(axes)
    for part in ("before", "coupling", "behind"):
        if part == "coupling":
            couplings = blueprint.get("coupling", [])
            for name, coupling in zip(places(xml, "coupling"), couplings, strict=True):
                kind = coupling["type"]
                home, _, text = written[camel(kind)]
                members = [[axis["name"] for axis in axes].index(member) for member in coupling["axes"]]
                values = parameters(xml, f"coupling.{name}")
                arguments = modifiers(rows[kind], values, text, step, len(members))
                declared.append(f"    Piezoloop.{home}.{camel(kind)} {name}({arguments}) {place(max(x), 0, 10)};")
                n, before = len(members), [rest[i] for i in members]
                for k, i in enumerate(members):
                    if "matrix" in values:
                        row = values["matrix"][k * n : (k + 1) * n]
                        own = values["offset"][k] if "offset" in values else before[k]
                        rest[i] = own + sum(a * b for a, b in zip(row, before))
                    elif kind == "psd-pincushion":
                        rest[i] = before[k] * (1 + values["distortion"] * (before[0]**2 + before[1]**2) / values["half_size"]**2)
                    equations.append(connect(last[i], f"{name}.u[{k + 1}]", (max(x) - 20, 40 - 60 * i), (max(x) - 12, 0)))
                    last[i], units[i] = f"{name}.y[{k + 1}]", "m"
                x = [max(x) + 30] * len(axes)
            continue
        for i, axis in enumerate(axes):
            for name, component in zip(places(xml, f"axis[{i + 1}]"), axis["component"], strict=True):
                kind = component["type"]
                early = ORDER.index(stages[kind]) < ORDER.index("coupling")
                if early != (part == "before"):
                    continue
                if kind in RANDOM:
                    dropped.append(f"{axis['name']}.{name}")
                    continue
                values = parameters(xml, f"axis[{i + 1}].{name}")
                values |= {q["name"]: int(component[q["name"]]) for q in rows[kind]["structure"] if q["name"] in component}
                values |= {k: component[k] for k in ("longest",) if k in component}
                if rest[i] and "u_start" in written[camel(kind)][2]:
                    values["u_start"] = rest[i]
                add(f"{name}{i + 1}", kind, values, i, x[i])
                x[i] += 30
    for i in range(len(axes)):
        equations.append(connect(last[i], f"y[{i + 1}]", (100, 40 - 60 * i), (110, 40 - 60 * i)))
    name = camel(re.sub("_", "-", blueprint["name"]))
    note = f"Without disturbances: {', '.join(dropped)} left out. " if dropped else ""
    n = len(axes)
    source = html.escape(blueprint.get("source", ""), quote=False).replace('"', "'")
    text = "\n".join([
        f'  block {name} "{blueprint["description"]}"', "    extends Icons.Rig;",
        f'    Interfaces.CommandInput u[{n}] "Commands" annotation(Placement(transformation(extent={{{{-120,-20}},{{-80,20}}}})));',
        f'    Interfaces.PositionOutput y[{n}] "Positions" annotation(Placement(transformation(extent={{{{100,-10}},{{120,10}}}})));',
        f'    parameter Real step(unit="s", min = 0) = {step!r} "Time between samples: the step of the blueprint";',
        *declared, "  equation", *equations,
        f'    annotation(Documentation(info="<html><p>Rig <code>{blueprint["name"].replace("_", "-")}</code>. {note}Blocks that run once per step answer a step '
        f'later than in the FMU: y[i] is the FMU\'s position {delays} steps later.</p><p>Source: {source}.</p></html>"));',
        f"  end {name};"])
    return name, text, delays


HOLD = """  block {name} "Hands a {what} on once per step"
    extends Icons.Block;
    Interfaces.{kind}Input u "{kind} in front" annotation(Placement(transformation(extent={{{{-120,-20}},{{-80,20}}}})));
    Interfaces.{kind}Output y "{kind} at the last sample" annotation(Placement(transformation(extent={{{{100,-10}},{{120,10}}}})));
    parameter Real u_start(unit="{unit}") = 0 "{kind} before the first sample";
    parameter Real step(unit="s", min = 0) = 20e-6 "Time between samples: the step of the blueprint";
  protected
    discrete Real held(start = u_start, fixed = true, unit="{unit}") "{kind} at the last sample";
  equation
    when sample((1 - 1e-7)*step, step) then
      held = u;
    end when;
    y = held;
    annotation(Icon(graphics={{Line(points={{{{-80,-60}},{{-40,-60}},{{-40,-20}},{{0,-20}},{{0,20}},{{40,20}},{{40,60}},{{80,60}}}}, color={{0,0,127}})}}),
      Documentation(info="<html><p>Sampled just before the end of each step{why}.</p></html>"));
  end {name};

"""
WHY = ", so that a block with direct feed-through is read with the input that it had"
RIGS = (
    'within Piezoloop;\npackage Rigs "Known machines, as the tool\'s blueprints have them"\n  extends Icons.Package;\n\n'
    + HOLD.format(name="Hold", what="position", kind="Position", unit="m", why=WHY)
    + HOLD.format(name="HoldCommand", what="command", kind="Command", unit="V", why="")
)


def rig_example(name, description, blueprint):
    """A rig under waves of some 40 % of its range: the model, and its inputs as (amplitudes, frequencies) of each axis."""
    step, axes = float(blueprint["step"]), blueprint["axis"]
    model, inputs = Model(name, description, f"Rig Piezoloop.Rigs.{name} as it is compared with its FMU."), []
    model.declared.append(f"    Piezoloop.Rigs.{name} device {place(0, 0, 20)};")
    for i, axis in enumerate(axes, 1):
        top = float(axis["command"]["max"])
        amplitudes = [round(0.15 * top, 6), round(0.05 * top, 6)]
        frequencies = [float(f"{1 / (240 * step) / i:.6g}"), float(f"{1 / (87 * step) / i:.6g}")]
        inputs.append((amplitudes, frequencies))
        y = 60 - 30 * i
        model.declared.append(f"    Sources.Wave wave{i}(amplitude = {value(amplitudes)}, frequency = {value(frequencies)}, step = {step!r}) {place(-70, y)};")
        model.equations.append(connect(f"wave{i}.y", f"device.u[{i}]", (-59, y), (-24, 0)))
    return model, inputs, model.text((ROWS - 1) * step, step)


def rigs(rows, written, read):
    """Texts of Rigs.mo and Examples/Rigs.mo; per rig its name in Modelica, inputs, and delays. `read(rig)`: blueprint and XML."""
    blocks, models, facts = [], [], {}
    for kind in KNOWN:
        blueprint, xml = read(kind)
        name, text, delays = rig(rows, written, blueprint, xml)
        _, inputs, example_ = rig_example(name, blueprint["description"], blueprint)
        blocks.append(text)
        models.append(example_)
        facts[kind] = (name, blueprint, inputs, delays)
    end = '  annotation(Documentation(info="<html><p>{}</p></html>"));\nend Rigs;\n'
    plants = RIGS + "\n\n".join(blocks) + "\n" + end.format("All rigs of the tool: nominal, truth, machine.")
    tried = 'within Piezoloop.Examples;\npackage Rigs "Each rig under waves"\n  extends Icons.ExamplesPackage;\n\n'
    return plants, tried + "\n\n".join(models) + "\n" + end.format("One model per rig."), facts


KNOWN = ["p0", "p0-truth", "p0-machine", "p1", "p1-truth", "p1-machine", "p2", "p2-truth", "p2-machine", "p3", "p3-truth", "p3-machine", "evc", "p4-truth",
         "evc-truth", "p4-machine", "p885"]


UNITS = {"kHz": (1e3, "Hz"), "nm": (1e-3, "um"), "mV": (1e-3, "V")}


def records(rows, texts):
    """Text of Records.mo: a Modelica record per specimen, values in the registry's units with their sources."""
    made = []
    for text in texts:
        lines = []
        for kind, values in text.items():
            if not isinstance(values, dict):
                continue
            known = {q["name"]: q for q in rows[kind]["parameters"]}
            for name, entry in values.items():
                given, unit = entry["value"], known[name]["unit"].replace("{position}", "um").replace("{command}", "V")
                if isinstance(given, str):
                    number, unit = given.split(" ", 1)
                    scale, unit = UNITS.get(unit, (1.0, unit))
                    given = float(f"{float(number) * scale:.12g}")
                size = f"[{len(given)}]" if isinstance(given, list) else ""
                each = "each " if size else ""
                source = html.escape(entry["source"], quote=False).replace('"', "'")
                lines.append(f'    parameter Real {kind.replace("-", "_")}_{name}{size}({each}unit="{unit}") = {value(given)} "{known[name]["description"]} ({source})";')
        title = camel(text["name"])
        title = title if title[0].isalpha() else f"R{title}"
        made.append(f'  record {title} "{text["description"]}"\n    extends Icons.Record;\n' + "\n".join(lines)
                    + f'\n    annotation(Documentation(info="<html><p>Record <code>{text["name"]}</code> of the tool; the source stands at each value.</p></html>"));\n  end {title};')
    return ('within Piezoloop;\npackage Records "Measured and printed values of specimens"\n  extends Icons.Package;\n\n' + "\n\n".join(made)
            + '\n  annotation(Documentation(info="<html><p>Records of parameters. Pass their fields to the blocks: <code>Mechanics.Mode(frequency = specimen.mode_frequency)</code>.</p></html>"));\nend Records;\n')

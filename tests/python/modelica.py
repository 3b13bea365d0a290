"""The Modelica package against the registry and, compiled by rumoca, against the tool's FMUs.

usage: modelica.py text|plant|coupling|controller|rig PIEZOLOOP PACKAGE [TYPE ...]
"""

import csv
import html
import json
import math
import re
import subprocess
import sys
import tomllib
from pathlib import Path

import rumoca
from modelica_cases import CONTROLLER, COUPLING, PLANT

RESERVED = {"initial", "delay", "sample", "pre", "der", "reinit", "time"}
STEP, ROWS = 1e-4, 300
BLOCK = re.compile(r'^  block (\w+) "([^"]*)"\n(.*?)^  end \1;', re.S | re.M)
PARAMETER = re.compile(
    r'^    parameter (Real|Integer) (\w+)(?:\[(\w+)\])?(?:\((.*?)\))?(?: = ([^ ]+))? "([^"]*)";', re.M
)
# Packages of what is no component.
FRAME = {"package", "Interfaces", "Icons", "Sources", "Acausal", "Rigs", "Examples", "UsersGuide", "Records"}
# What a block has beyond its component: the FMU takes them from the blueprint or works them out.
OWN = {"step", "elements", "cells"}


def camel(kind):
    return "".join(part.capitalize() for part in kind.split("-"))


def registry(tool):
    said = subprocess.run([tool, "list", "models", "--json"], check=True, capture_output=True, text=True)
    rows = [row for row in json.loads(said.stdout) if not re.match("lssvm|gaussian|gp-", row["type"])]
    return {row["type"]: row for row in rows}


def blocks(package):
    """Block name: (package, summary, text) of all blocks that are components of the registry."""
    found = {}
    for file in sorted(package.rglob("*.mo")):
        home = ".".join(file.relative_to(package).with_suffix("").parts)
        if home not in FRAME and not home.startswith(("Rigs.", "Examples.")):
            found |= {name: (home, summary, text) for name, summary, text in BLOCK.findall(file.read_text())}
    return found


def scales(text):
    """What turns um into the connectors' metres: factors of the input u and of the output y."""
    base = re.search(r"extends Interfaces\.(\w+);", text)
    base = base[1] if base else "PositionFilter"
    return (1e-6 if base in ("PositionFilter", "Inverse", "ReferenceFilter") else 1.0,
            1e-6 if base in ("PositionFilter", "Actuator", "ReferenceFilter") else 1.0)


def modelica_unit(unit):
    """The registry's unit on an axis in V and um, as Modelica writes it: one slash."""
    above, below, sign = [], [], "."
    for token in re.findall(r"[./]|[^./]+", unit):
        if token in "./":
            sign = token
            continue
        token = {"{command}": "V", "{position}": "um"}.get(token, token)
        if token != "1":
            (above if sign == "." else below).append(token)
        sign = "."
    top = ".".join(above) or "1"
    if not below:
        return top
    return f"{top}/{below[0]}" if len(below) == 1 else f"{top}/({'.'.join(below)})"


def declared(text):
    """Parameter name: its declaration as the registry would say it."""
    found = {}
    for kind, name, length, modifiers, start, description in PARAMETER.findall(text):
        attributes = dict(re.findall(r"(?:each )?(\w+) ?= ?(\"[^\"]*\"|[^,]+)", modifiers))
        number = lambda key: float(attributes[key]) if key in attributes else None
        found[name] = {
            "integer": kind == "Integer",
            "unit": attributes.get("unit", '"1"').strip('"'),
            "min": number("min"),
            "max": number("max"),
            "start": float(start) if start else None,
            "length": length or None,
            "description": description,
        }
    return found


def check_text(tool, package):
    rows, written = registry(tool), blocks(package)
    problems, compared = [], 0
    for kind, row in rows.items():
        _, summary, text = written.pop(camel(kind), (None, None, ""))
        if summary != row["summary"] or html.escape(row["equation"], quote=False) not in text:
            problems.append(f"{kind}: summary or equation differ from the registry's")
        has = declared(text)
        for quantity in row["structure"] + row["parameters"]:
            name = quantity["name"]
            if name == "seed" and "NoiseInput" in text:
                continue
            own = has.pop(name + "_" if name in RESERVED else name, None)
            wanted = {key: quantity[key] for key in ("description", "start", "min", "max", "length")}
            wanted["unit"] = modelica_unit(quantity["unit"])
            wanted["integer"] = own is not None and own["integer"]
            compared += 1
            if own != wanted:
                problems.append(f"{kind}.{name}: Modelica {own}, registry {wanted}")
        problems += [f"{kind}: the registry has no {name}" for name in has.keys() - OWN]
    problems += [f"{kind}: no case in modelica_cases.py" for kind in rows.keys() - PLANT.keys() - COUPLING.keys() - CONTROLLER.keys()]
    problems += [f"{name}: no component of the registry" for name in written.keys()]
    if problems:
        sys.exit("\n".join(problems))
    print(f"{len(rows)} components, {compared} parameters: as the registry says")


def flat(rows):
    return [cell for row in rows for cell in row] if isinstance(rows[0], list) else rows


def value(x):
    if isinstance(x, bool):
        return str(x).lower()
    if isinstance(x, list):
        return "{" + ", ".join(value(cell) for cell in flat(x)) + "}"
    return repr(x)


def modifiers(row, parameters, text):
    """The arguments of a block: lengths of arrays are told."""
    written = dict(parameters)
    for quantity in row["parameters"]:
        length, given = quantity["length"], parameters.get(quantity["name"])
        if length and given is not None and length not in ("axes", "entries"):
            written[length] = len(flat(given))
    if re.search(r"parameter Integer entries", text):
        written["entries"] = 4
    if re.search(r"parameter Integer axes", text):
        written["axes"] = 2
    if "longest" in parameters and "cells" in text:
        written["cells"] = round(parameters["longest"] / STEP) + 2
    if "cycle" in parameters:
        written["cells"] = round(parameters["cycle"] / STEP) + parameters["half"]
    if re.search(r"parameter Real step", text):
        written["step"] = STEP
    names = ((name + "_" if name in RESERVED else name, x) for name, x in written.items())
    return ", ".join(f"{name} = {value(x)}" for name, x in names)


def waves(lead):
    """Two inputs, as text that Python and Modelica both read: `t` is the time."""
    pi2 = repr(2 * math.pi)
    one = f"{lead} * (40.0 * (1.0 - cos({pi2} * 60.0 * t)) + 12.0 * (1.0 - cos({pi2} * 170.0 * t)))"
    return [one, f"{lead} * 30.0 * (1.0 - cos({pi2} * 90.0 * t))"]


def tabulate(texts):
    names = {"cos": math.cos, "sin": math.sin}
    return [[eval(text, names | {"t": k * STEP}) for text in texts] for k in range(ROWS)]


def held(texts):
    """Modelica: the inputs as the FMU sees them, held over each step."""
    lines = [f"  discrete Real u{i}(start = 0, fixed = true);" for i in range(1, len(texts) + 1)]
    when = [f"    u{i} = {text.replace(' t)', ' time)')};" for i, text in enumerate(texts, 1)]
    return "\n".join(lines), "  when sample(0, {!r}) then\n{}\n  end when;".format(STEP, "\n".join(when))


def simulate(session, declarations, equations, wanted):
    """Values of the variables just before each sample but the first."""
    source = f"model Run\n{declarations}\nequation\n{equations}\nend Run;\n"
    model = session.loads(source, model="Run")
    config = rumoca.SimConfig(solver="rk-like", rtol=1e-9, atol=1e-11)
    run = model.simulate(t=(0, (ROWS - 1) * STEP), dt=STEP, config=config)
    rows, at = [], 0
    for k in range(1, ROWS):
        while run.time[at] < k * STEP - 1e-4 * STEP:
            at += 1
        rows.append([run[name][at] for name in wanted])
    return rows


def toml(parameters):
    write = lambda x: f"[{', '.join(map(write, x))}]" if isinstance(x, list) else repr(x)
    return "\n".join(f"{name} = {write(x)}" for name, x in parameters.items())


def fmu(tool, blueprint, inputs, output):
    """The FMU's outputs at the samples but the first: what its input of the step before made."""
    Path("run.toml").write_text(blueprint)
    with open("input.csv", "w", newline="") as file:
        rows = csv.writer(file)
        rows.writerow(["time", *inputs])
        for k, row in enumerate(zip(*inputs.values())):
            rows.writerow([repr(k * STEP), *map(repr, row)])
    for arguments in (["pack", "run.toml", "-o", "run.fmu"],
                      ["simulate", "run.fmu", "--log", "input.csv", "-o", "run.csv"]):
        said = subprocess.run([tool, *arguments], capture_output=True, text=True)
        if said.returncode:
            sys.exit(f"{arguments}: {said.stderr}\n{blueprint}")
    with open("run.csv", newline="") as file:
        table = list(csv.DictReader(file))
    return [[float(row[name]) for name in output] for row in table[1:]]


def blueprint(kind, axes, components, coupling=""):
    text = f'piezoloop = 1\nkind = "{kind}"\nname = "run"\nstep = {STEP!r}\n'
    for axis in range(1, axes + 1):
        text += f'[[axis]]\nname = "A{axis}"\n'
        if kind == "plant":
            text += f'command = {{ name = "u{axis}", unit = "V", min = -1000, max = 1000, start = 0 }}\n'
            text += f'position = {{ name = "y{axis}", unit = "um" }}\n'
        else:
            text += f'command = {{ name = "u{axis}", unit = "V" }}\nposition = {{ unit = "um" }}\n'
            text += f'reference = {{ name = "r{axis}" }}\nmeasured = {{ name = "m{axis}" }}\n'
        for name, parameters in components:
            text += f'[[axis.component]]\ntype = "{name}"\n{toml(parameters)}\n'
    return text + coupling


def difference(ours, theirs):
    size = max(abs(x) for row in ours for x in row)
    return max(abs(a - b) for x, y in zip(ours, theirs, strict=True) for a, b in zip(x, y)) / size


def judge(results):
    bad = [line for line, fine in results if not fine]
    for line, _ in results:
        print(line)
    if bad:
        sys.exit(f"{len(bad)} of {len(results)} differ:\n" + "\n".join(bad))


def verdict(kind, apart, bound):
    return f"{kind}: {apart:.1e} (bound {bound:.0e})", apart <= bound


SIGNALS = {"displacement": "0", "n": "0", "drive": "0", "temperature": "273.15 + 0.1*u2", "force": "0.5*u2",
           "disturbance": "1e-6*(0.01*u2)", "command": "u1", "reference": "1e-6*u1", "measured": "1e-6*(0.5*u2)", "enable": "on"}
COLUMNS = {"temperature": ("temperature", lambda x: 0.1 * x), "force": ("force[1]", lambda x: 0.5 * x),
           "disturbance": ("disturbance[1]", lambda x: 0.01 * x)}
INPUT = re.compile(r"^    (?:Interfaces\.\w+Input|input Boolean) (\w+)(?:\[axes\])?(?: |\()", re.M)


def further(text):
    return [name for name in INPUT.findall(text) if name != "u"]


def plant(session, tool, rows, written, kind, parameters, bound):
    """The component in front of a gain of 1, or behind one of 0.1."""
    package, _, text = written[camel(kind)]
    filter_of = re.search(r"extends Interfaces\.(\w+);", text)[1]
    ones = [("actuator-gain", {"gain": 1.0})] if filter_of == "CommandFilter" else []
    before = [("actuator-gain", {"gain": 0.1})] if filter_of == "PositionFilter" else []
    texts = waves("1.0")
    table = tabulate(texts)
    inputs = {"command[1]": [row[0] for row in table]}
    extra = further(text)
    for name in extra:
        if name in COLUMNS:
            column, of = COLUMNS[name]
            inputs[column] = [of(row[1]) for row in table]
    ours = fmu(tool, blueprint("plant", 1, before + [(kind, parameters)] + ones), inputs, ["position[1]"])
    declarations, equations = held(texts)
    declarations += f"\n  Piezoloop.{package}.{camel(kind)} c({modifiers(rows[kind], parameters, text)});"
    into, out = scales(text)
    equations += f"\n  c.u = {'1e-6*(0.1*u1)' if before else 'u1'};"
    equations += "".join(f"\n  c.{name} = {SIGNALS[name]};" for name in extra)
    theirs = simulate(session, declarations, equations, ["c.y"])
    return verdict(kind, difference(ours, [[y / out for y in row] for row in theirs]), bound)


def coupling(session, tool, rows, written, kind, parameters, bound):
    package, _, text = written[camel(kind)]
    texts = waves("1.0")
    table = tabulate(texts)
    inputs = {f"command[{i + 1}]": [row[i] for row in table] for i in (0, 1)}
    tail = f'[[coupling]]\ntype = "{kind}"\naxes = ["A1", "A2"]\n{toml(parameters)}\n'
    ours = fmu(tool, blueprint("plant", 2, [("actuator-gain", {"gain": 0.1})], tail), inputs,
               ["position[1]", "position[2]"])
    declarations, equations = held(texts)
    declarations += f"\n  Piezoloop.{package}.{camel(kind)} c({modifiers(rows[kind], parameters, text)});"
    equations += "\n  c.u[1] = 1e-6*(0.1*u1);\n  c.u[2] = 1e-6*(0.1*u2);"
    if "command" in further(text):
        equations += "\n  c.command[1] = u1;\n  c.command[2] = u2;"
    theirs = simulate(session, declarations, equations, ["c.y[1]", "c.y[2]"])
    return verdict(kind, difference(ours, [[y * 1e6 for y in row] for row in theirs]), bound)


# What stands around a control component: components in front of it and behind it.
FEEDFORWARD, LIMITS = ("feedforward-gain", {"gain": 8.0}), {"output_min": -1e6, "output_max": 1e6}
LINEAR, OPEN, CLOSED = ("feedforward-gain", {"gain": 1.0}), ("pid", {"kp": 0.0} | LIMITS), ("pid", {"kp": 1.0} | LIMITS)
AROUND = {"pid": ([FEEDFORWARD], []), "incremental-pid": ([FEEDFORWARD], []), "repetitive": ([FEEDFORWARD], []),
          "reference-lead": ([], [LINEAR, OPEN]), "inverse-kelvin-voigt-creep": ([], [LINEAR, OPEN]),
          "reference-curve": ([], [LINEAR, OPEN]), "command-curve": ([FEEDFORWARD], [OPEN]),
          "notch": ([], [LINEAR, OPEN]), "disturbance-observer": ([], [LINEAR]),
          "reference-filter": ([], [LINEAR, CLOSED]), "reference-preview": ([], [LINEAR, CLOSED])}
# Steps in which what can be switched off is off: from the first to the one before the second.
OFF = (80, 121)


def enabled():
    """Modelica: `on` as the FMU sees it."""
    low, high = ((step - 0.5) * STEP for step in OFF)
    when = f"\n  when sample(0, {STEP!r}) then\n    on = time < {low!r} or time > {high!r};\n  end when;"
    return "\n  discrete Boolean on(start = true, fixed = true);", when


def controller(session, tool, rows, written, case, parameters, bound):
    """The component on a reference and a measured position, and off for a while where it can be."""
    kind = case.split()[0]
    package, _, text = written[camel(kind)]
    texts = waves("0.08")
    table = tabulate(texts)
    inputs = {"reference[1]": [row[0] for row in table], "measured[1]": [0.5 * row[1] for row in table]}
    declarations, equations = held(texts)
    declarations += f"\n  Piezoloop.{package}.{camel(kind)} c({modifiers(rows[kind], parameters, text)});"
    if kind == "jacobian-coordinator":
        return coordinator(session, tool, (kind, parameters, bound), inputs, declarations, equations)
    before, behind = AROUND.get(kind, ([], [OPEN]))
    extra = further(text)
    if "enable" in extra:
        inputs["enable"] = [0.0 if OFF[0] <= k < OFF[1] else 1.0 for k in range(ROWS)]
        declared_on, when_on = enabled()
        declarations, equations = declarations + declared_on, equations + when_on
    ours = fmu(tool, blueprint("controller", 1, [*before, (kind, parameters), *behind]), inputs, ["command[1]"])
    into, out = scales(text)
    equations += f"\n  c.u = {into!r}*({'8*u1' if before else 'u1'});"
    equations += "".join(f"\n  c.{name} = {SIGNALS[name]};" for name in extra)
    wanted = "c.y"
    if CLOSED in behind:
        wanted = "command"
        declarations += "\n  Real command;"
        equations += f"\n  command = c.y + c.reference - {SIGNALS['measured']};"
    theirs = simulate(session, declarations, equations, [wanted])
    return verdict(case, difference(ours, [[y / out for y in row] for row in theirs]), bound)


def coordinator(session, tool, case, inputs, declarations, equations):
    """Two axes behind their coordinator, each under feedback of gain 1."""
    kind, parameters, bound = case
    inputs |= {"reference[2]": inputs["measured[1]"], "measured[2]": [0.25 * x for x in inputs["reference[1]"]]}
    tail = f'[[coupling]]\ntype = "{kind}"\naxes = ["A1", "A2"]\n{toml(parameters)}\n'
    ours = fmu(tool, blueprint("controller", 2, [LINEAR, CLOSED], tail), inputs, ["command[1]", "command[2]"])
    declarations += "\n  Real command[2];"
    equations += "\n  c.u[1] = 1e-6*u1;\n  c.u[2] = 1e-6*(0.5*u2);\n  c.measured[1] = 1e-6*(0.5*u2);\n  c.measured[2] = 1e-6*(0.25*u1);"
    equations += "".join(f"\n  command[{i}] = (2*c.y[{i}] - c.measured_motion[{i}])*1e6;" for i in (1, 2))
    wanted = ["command[1]", "command[2]"]
    return verdict(kind, difference(ours, simulate(session, declarations, equations, wanted)), bound)


def rig(session, tool, package):
    """Rigs.Evc has the blueprint's values and, two steps later, its trajectory."""
    said = subprocess.run([tool, "list", "rigs", "--show", "evc"], check=True, capture_output=True, text=True)
    wanted = tomllib.loads(said.stdout)
    text = blocks(package)["Evc"][2]
    problems, axes = [], {"Y": "y", "Z": "z"}
    for axis in wanted["axis"]:
        for component in axis["component"]:
            name = f"{axes[axis['name']]}_{component['name']}"
            own = re.search(rf"\.{camel(component['type'])} {name}\((.*)\);", text)
            given = {k: v for k, v in component.items() if k not in ("type", "name", "note")}
            for key, x in given.items():
                numbers = re.search(rf"\b{key} = (\{{[^}}]*\}}|[^,]+)", own[1] if own else "")
                numbers = [float(n) for n in numbers[1].strip("{}").split(",")] if numbers else None
                if numbers != (x if isinstance(x, list) else [x]):
                    problems.append(f"{name}.{key}: Modelica {numbers}, rig {x}")
    if problems:
        sys.exit("\n".join(problems))
    texts = waves("1.0")
    table = tabulate(texts)
    inputs = {f"command[{i + 1}]": [row[i] for row in table] for i in (0, 1)}
    step = f"step = {STEP!r}\n"
    ours = fmu(tool, re.sub(r"^step = .*\n", step, said.stdout, flags=re.M), inputs, ["position[1]", "position[2]"])
    declarations, equations = held(texts)
    declarations += f"\n  Piezoloop.Rigs.Evc evc(step = {STEP!r});"
    equations += "\n  evc.u[1] = u1;\n  evc.u[2] = u2;"
    theirs = simulate(session, declarations, equations, ["evc.y[1]", "evc.y[2]"])
    judge([verdict("rig evc", difference(ours[:-2], theirs[2:]), 1e-8)])


TASKS = {"plant": (PLANT, plant), "coupling": (COUPLING, coupling), "controller": (CONTROLLER, controller)}


def main():
    task, tool, package, *only = sys.argv[1:]
    package = Path(package)
    if task == "text":
        return check_text(tool, package)
    session = rumoca.Session(roots=[str(package)])
    if task == "rig":
        return rig(session, tool, package)
    rows, written = registry(tool), blocks(package)
    cases, run = TASKS[task]
    kinds = [kind for kind in cases if not only or kind.split()[0] in only]
    judge([run(session, tool, rows, written, kind, *cases[kind]) for kind in kinds])


if __name__ == "__main__":
    main()

"""The Modelica package against the registry and, compiled by rumoca, against the tool's FMUs.

usage: modelica.py text|write|library|energy|units|plant|coupling|controller|rig PIEZOLOOP PACKAGE [TYPE ...]
"""

import csv
import json
import math
import re
import subprocess
import sys
import tomllib
import zipfile
from pathlib import Path

import rumoca
from modelica_cases import CONTROLLER, COUPLING, PLANT, add_declared
from modelica_examples import (
    OFF, RANDOM, RESERVED, ROWS, STEP, base, camel, documentation, example, further, packages, records, rigs,
)

BLOCK = re.compile(r'^  block (\w+) "([^"]*)"\n(.*?)^  end \1;', re.S | re.M)
PARAMETER = re.compile(
    r'^    parameter (Real|Integer) (\w+)(?:\[(\w+)\])?(?:\((.*?)\))?(?: = ([^ ]+))? "([^"]*)";', re.M
)
# Packages of what is no component.
FRAME = {"package", "Interfaces", "Icons", "Sources", "Acausal", "Rigs", "Examples", "UsersGuide", "Records"}
# What a block has beyond its component: the FMU takes them from the blueprint or works them out.
OWN = {"step", "elements", "cells", "u_start"}


def registry(tool):
    said = subprocess.run([tool, "list", "models", "--json"], check=True, capture_output=True, text=True)
    rows = [row for row in json.loads(said.stdout) if not re.match("lssvm|gaussian|gp-|(inverse-)?learned-|preview-coordinator|feedback-notch", row["type"])]
    rows = {row["type"]: row for row in rows}
    add_declared(rows)
    return rows


def blocks(package):
    """Block name: (package, summary, text) of all blocks that are components of the registry."""
    found = {}
    for file in sorted(package.rglob("*.mo")):
        home = ".".join(file.relative_to(package).with_suffix("").parts)
        if home not in FRAME and not home.startswith(("Rigs.", "Examples.")):
            found |= {name: (home, summary, text) for name, summary, text in BLOCK.findall(file.read_text())}
    return found


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


def made(tool, package):
    """Files of the package that are made from the cases and the rigs, and those of blocks with the registry's documentation."""
    rows, written = registry(tool), blocks(package)
    found = {package / "Examples" / f"{name}.mo": text for name, text in packages(rows, written).items()}
    found[package / "Rigs.mo"], found[package / "Examples" / "Rigs.mo"], _ = rigs(rows, written, read_rig(tool))
    pages = (package / "../../docs/effects.md").read_text()
    of_block = {camel(kind): (kind, row["summary"]) for kind, row in rows.items()}

    def documented(block):
        name, _, text = block.groups()
        if name not in of_block:
            return block[0]
        info = documentation(*of_block[name], pages)
        return block[0].replace(text, re.sub(r'(?<=Documentation\(info=")[^"]*', lambda _: info, text, count=1))

    for home in {home for home, _, _ in written.values()}:
        file = package / f"{home.replace('.', '/')}.mo"
        found[file] = BLOCK.sub(documented, file.read_text())
    texts = [tomllib.loads(file.read_text()) for file in sorted((package / "../../rigs/records").glob("*.toml"))]
    found[package / "Records.mo"] = records(rows, texts)
    return found


def check_text(tool, package):
    rows, written = registry(tool), blocks(package)
    pages = (package / "../../docs/effects.md").read_text()
    problems, compared = [], 0
    for kind, row in rows.items():
        _, summary, text = written.pop(camel(kind), (None, None, ""))
        if summary != row["summary"] or documentation(kind, summary, pages) not in text:
            problems.append(f"{kind}: summary or documentation differ from the registry's and docs/effects.md's")
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
    for file, text in made(tool, package).items():
        if not file.exists() or file.read_text() != text:
            problems.append(f"{file}: differs from what the cases say; modelica.py write TOOL PACKAGE makes it anew")
    if problems:
        sys.exit("\n".join(problems))
    print(f"{len(rows)} components, {compared} parameters: as the registry says")


def waves(lead):
    """Two inputs, as text that Python and Modelica both read: `t` is the time."""
    pi2 = repr(2 * math.pi)
    one = f"{lead} * (40.0 * (1.0 - cos({pi2} * 60.0 * t)) + 12.0 * (1.0 - cos({pi2} * 170.0 * t)))"
    return [one, f"{lead} * 30.0 * (1.0 - cos({pi2} * 90.0 * t))"]


def tabulate(texts):
    names = {"cos": math.cos, "sin": math.sin}
    return [[eval(text, names | {"t": k * STEP}) for text in texts] for k in range(ROWS)]


def simulate(session, name, wanted, factor=1):
    """Values of the variables of an example, in V and um, just before each sample but the first."""
    model = session.loads(f"model Run\n  extends Piezoloop.{name};\nend Run;\n", model="Run")
    config = rumoca.SimConfig(solver="rk-like", rtol=1e-9, atol=1e-14)
    run = model.simulate(t=(0, (ROWS - 1) * STEP), dt=STEP / factor, config=config)
    rows, at = [], 0
    for k in range(1, ROWS):
        while run.time[at] < k * STEP - 1e-4 * STEP:
            at += 1
        rows.append([run[name][at] * scale for name, scale in wanted])
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


COLUMNS = {"temperature": ("temperature", lambda x: 0.1 * x), "force": ("force[1]", lambda x: 0.5 * x),
           "actuator_temperature": ("actuator_temperature[1]", lambda x: 273.15 + 0.1 * x),
           "disturbance": ("disturbance[1]", lambda x: 0.01 * x)}


def compared(session, rows, written, case, parameters, ours, bound):
    package, model, wanted = example(rows, written, case, parameters)
    theirs = simulate(session, f"Examples.{package}.{model.name}", wanted)
    return verdict(case, difference(ours, theirs), bound)


def plant(session, tool, rows, written, kind, parameters, bound):
    """The component in front of a gain of 1, or behind one of 0.1."""
    _, _, text = written[camel(kind)]
    filter_of = re.search(r"extends Interfaces\.(\w+)[;(]", text)[1]
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
    return compared(session, rows, written, kind, parameters, ours, bound)


def coupling(session, tool, rows, written, kind, parameters, bound):
    texts = waves("1.0")
    table = tabulate(texts)
    inputs = {f"command[{i + 1}]": [row[i] for row in table] for i in (0, 1)}
    tail = f'[[coupling]]\ntype = "{kind}"\naxes = ["A1", "A2"]\n{toml(parameters)}\n'
    ours = fmu(tool, blueprint("plant", 2, [("actuator-gain", {"gain": 0.1})], tail), inputs,
               ["position[1]", "position[2]"])
    return compared(session, rows, written, kind, parameters, ours, bound)


# What stands around a control component: components in front of it and behind it.
FEEDFORWARD, LIMITS = ("feedforward-gain", {"gain": 8.0}), {"output_min": -1e6, "output_max": 1e6}
LINEAR, OPEN, CLOSED = ("feedforward-gain", {"gain": 1.0}), ("pid", {"kp": 0.0} | LIMITS), ("pid", {"kp": 1.0} | LIMITS)
AROUND = {"reference-lead": ([], [LINEAR, OPEN]), "inverse-kelvin-voigt-creep": ([], [LINEAR, OPEN]),
          "reference-curve": ([], [LINEAR, OPEN]), "command-curve": ([FEEDFORWARD], [OPEN]),
          "notch": ([], [LINEAR, OPEN]), "disturbance-observer": ([], [LINEAR]),
          "reference-filter": ([], [LINEAR, CLOSED]), "reference-preview": ([], [LINEAR, CLOSED])}


def controller(session, tool, rows, written, case, parameters, bound):
    """The component on a reference and a measured position, and off for a while where it can be."""
    kind = case.split()[0]
    _, _, text = written[camel(kind)]
    table = tabulate(waves("0.08"))
    inputs = {"reference[1]": [row[0] for row in table], "measured[1]": [0.5 * row[1] for row in table]}
    output, tail, axes = ["command[1]"], "", 1
    before, behind = AROUND.get(kind, ([FEEDFORWARD], []) if base(text) == "Controller" else ([], [OPEN]))
    component = [*before, (kind, parameters), *behind]
    if "enable" in further(text):
        inputs["enable"] = [0.0 if OFF[0] <= k < OFF[1] else 1.0 for k in range(ROWS)]
    if kind == "jacobian-coordinator":
        # Two axes behind their coordinator, each under feedback of gain 1.
        inputs |= {"reference[2]": inputs["measured[1]"], "measured[2]": [0.25 * x for x in inputs["reference[1]"]]}
        tail = f'[[coupling]]\ntype = "{kind}"\naxes = ["A1", "A2"]\n{toml(parameters)}\n'
        output, axes, component = ["command[1]", "command[2]"], 2, [LINEAR, CLOSED]
    ours = fmu(tool, blueprint("controller", axes, component, tail), inputs, output)
    return compared(session, rows, written, case, parameters, ours, bound)


def read_rig(tool):
    """Blueprint of a rig, and the model description of its FMU."""
    def read(name):
        shown = subprocess.run([tool, "list", "rigs", "--show", name], check=True, capture_output=True, text=True)
        subprocess.run([tool, "pack", name, "-o", "rig.fmu"], check=True, capture_output=True)
        with zipfile.ZipFile("rig.fmu") as fmu:
            return tomllib.loads(shown.stdout), fmu.read("modelDescription.xml").decode()
    return read


def rig_case(session, tool, name, fact, bound):
    """A rig's trajectory beside that of its FMU with the noises off, later by the holds."""
    model, blueprint, inputs, delays = fact
    step = float(blueprint["step"])
    wave = lambda amplitudes, frequencies, t: sum(a * (1 - math.cos(2 * math.pi * f * t)) for a, f in zip(amplitudes, frequencies))
    with open("input.csv", "w", newline="") as file:
        rows = csv.writer(file)
        rows.writerow(["time", *(f"command[{i + 1}]" for i in range(len(inputs)))])
        for k in range(ROWS):
            rows.writerow([repr(k * step), *(repr(wave(*one, k * step)) for one in inputs)])
    off = []
    for i, axis in enumerate(blueprint["axis"], 1):
        for component in axis["component"]:
            if component["type"] in RANDOM:
                off += ["--start", f"axis[{i}].{component.get('name', component['type'].replace('-', '_'))}.enabled=false"]
    for arguments in (["pack", name, "-o", "rig.fmu"], ["simulate", "rig.fmu", "--log", "input.csv", *off, "-o", "run.csv"]):
        said = subprocess.run([tool, *arguments], capture_output=True, text=True)
        if said.returncode:
            sys.exit(f"{arguments}: {said.stderr}")
    with open("run.csv", newline="") as file:
        table = list(csv.DictReader(file))
    run = session.loads(f"model Run\n  extends Piezoloop.Examples.Rigs.{model};\nend Run;\n", model="Run").simulate(
        t=(0, (ROWS - 1) * step), dt=step, config=rumoca.SimConfig(solver="rk-like", rtol=1e-9, atol=1e-14))
    worst = 0.0
    for i, late in enumerate(delays, 1):
        ours = [float(row[f"position[{i}]"]) for row in table]
        size = max(ours) - min(ours)
        # Just before each step.
        at, theirs = 0, []
        for k in range(1, ROWS):
            while run.time[at] < (k - 1e-4) * step:
                at += 1
            theirs.append(run[f"device.y[{i}]"][at] * 1e6)
        worst = max(worst, max(abs(a - b) for a, b in zip(ours[1:], theirs[late:])) / size)
    return verdict(f"rig {name}", worst, bound)


CLASS = re.compile(
    r'^(?P<indent> *)(?:partial )?(?P<kind>package|block|model|connector|function|record|class|type) (?P<name>\w+)(?P<short> = [^\n]*)? "', re.M)


def classes(package):
    """Full name of each class: its kind, whether it is partial, its text."""
    found = {}
    for file in sorted(package.rglob("*.mo")):
        text = file.read_text()
        within = re.match(r"within ([\w.]+);", text)
        path = [(-1, within[1] if within else "")]
        for match in CLASS.finditer(text):
            indent, name = len(match["indent"]), match["name"]
            while path[-1][0] >= indent:
                path.pop()
            full = f"{path[-1][1]}.{name}".strip(".")
            if match["short"]:
                body = text[match.start():text.index(";\n", match.start())]
            else:
                body = text[match.start():text.index(f"\n{match['indent']}end {name};", match.start())]
                path.append((indent, full))
            found[full] = (match["kind"], match[0].lstrip().startswith("partial"), body)
    return found


def library(package):
    """Icon, documentation and example of every class; every class in both compilers."""
    import pymoca.ast
    import pymoca.parser
    import pymoca.tree

    found, problems = classes(package), []
    inherits = {name: re.findall(r"extends ([\w.]+)", body) for name, (_, _, body) in found.items()}

    def has_icon(name, body):
        if re.search(r"(?<!\w)Icon\(", body.split("\n\n", 1)[0] if found[name][0] == "package" else body):
            return True
        bases = [next((other for other in found if other.endswith(f".{base}")), None) for base in inherits[name][:1]]
        return any(base and base != name and has_icon(base, found[base][2]) for base in bases)

    shown = "\n".join(body for name, (_, _, body) in found.items() if ".Examples." in name or ".Rigs." in name)
    for name, (kind, partial, body) in found.items():
        last = name.split(".")[-1]
        if "Documentation(" not in body:
            problems.append(f"{name}: no documentation")
        if kind not in ("type",) and not has_icon(name, body):
            problems.append(f"{name}: no icon")
        is_used = re.search(rf"\b{last} \w+[ (;]", shown) or ".Examples." in name
        if kind in ("block", "model") and not partial and not is_used and not (".Rigs." in name and last.startswith("Hold")):
            problems.append(f"{name}: no example")
    tree = None
    for file in sorted(package.rglob("*.mo"), key=lambda file: (len(file.parts), file.name != "package.mo")):
        part = pymoca.parser.parse(file.read_text())
        if part is None:
            sys.exit(f"pymoca cannot read {file}")
        if tree is None:
            tree = part
        else:
            tree.extend(part)
    session = rumoca.Session(roots=[str(package)])
    written = blocks(package)
    homes = {case: written[camel(case.split()[0])][0].split(".")[-1] for case in [*PLANT, *COUPLING, *CONTROLLER]}
    beside = {f"Piezoloop.Examples.{home}.{camel(case)}" for case, home in homes.items()}
    beside |= {name for name in found if name.startswith("Piezoloop.Examples.Rigs.")}
    whole = [name for name, (kind, partial, _) in found.items() if kind in ("block", "model") and not partial]
    counts = {"pymoca": 0, "rumoca": 0}
    for name in whole:
        try:
            pymoca.tree.flatten(tree, pymoca.ast.ComponentRef.from_string(name))
            counts["pymoca"] += 1
        except Exception as error:  # the compiler's own kinds
            problems.append(f"{name}: pymoca: {error!r:.200}")
        # The tasks that compare with the FMUs compile and run the others.
        if ".Examples." in name and name not in beside:
            try:
                session.loads(f"model Run\n  extends {name};\nend Run;\n", model="Run")
                counts["rumoca"] += 1
            except rumoca.CompileError as error:
                problems.append(f"{name}: rumoca: {error!s:.200}")
    if problems:
        sys.exit("\n".join(problems))
    examples = sum(".Examples." in name for name in whole)
    print(f"{len(found)} classes, each with icon and documentation; pymoca flattens {counts['pymoca']} of {len(whole)} blocks and models, "
          f"rumoca compiles {counts['rumoca']} of {examples} examples, in which all stand; the others run beside FMUs")


def wrong_unit(session):
    """A voltage at an input for a position is refused."""
    source = ("model Run\n  Piezoloop.Electrical.AmplifierLag amplifier(bandwidth = 50);\n"
              "  Piezoloop.Mechanics.Mode stage(frequency = 10, damping = 0.1);\nequation\n  amplifier.u = 1;\n"
              "  connect(amplifier.y, stage.u);\nend Run;\n")
    try:
        session.loads(source, model="Run").simulate(t=(0, 1e-3), dt=1e-4)
    except rumoca.CompileError as error:
        return print(f"refused: {error}")
    return sys.exit("a voltage was connected to a position")


def energy(session):
    """Chains with pins and flanges keep their energy, and move as the chain of blocks does."""
    results = []
    for name, stop, wanted in (("StackWithPayload", 0.03, {"difference": "sensor.y", "balance": "amplifier.delivered"}),
                               ("StageWithFriction", 0.05, {"balance": "amplifier.delivered"})):
        model = session.loads(f"model Run\n  extends Piezoloop.Examples.Electromechanics.{name};\nend Run;\n", model="Run")
        run = model.simulate(t=(0, stop), dt=1e-4, config=rumoca.SimConfig(solver="rk-like", rtol=1e-9, atol=1e-14))
        for small, size in wanted.items():
            apart = max(map(abs, run[small])) / max(map(abs, run[size]))
            results.append(verdict(f"{name}, {small} over {size}", apart, 1e-6))
    judge(results)


TASKS = {"plant": (PLANT, plant), "coupling": (COUPLING, coupling), "controller": (CONTROLLER, controller)}


def main():
    task, tool, package, *only = sys.argv[1:]
    package = Path(package)
    if task == "text":
        return check_text(tool, package)
    if task == "write":
        for file, text in made(tool, package).items():
            file.write_text(text)
        return None
    if task == "library":
        return library(package)
    session = rumoca.Session(roots=[str(package)])
    if task in ("energy", "units"):
        return {"energy": energy, "units": wrong_unit}[task](session)
    rows, written = registry(tool), blocks(package)
    if task == "rig":
        facts = rigs(rows, written, read_rig(tool))[2]
        return judge([rig_case(session, tool, name, fact, 1e-6) for name, fact in facts.items() if not only or name in only])
    cases, run = TASKS[task]
    kinds = [kind for kind in cases if not only or kind.split()[0] in only]
    judge([run(session, tool, rows, written, kind, *cases[kind]) for kind in kinds])


if __name__ == "__main__":
    main()

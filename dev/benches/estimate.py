"""The same estimation by `piezoloop estimate` and by fmpy with scipy: time on one core, and the optimum.

    cargo build --release
    python dev/benches/estimate.py [TOOL]        (needs cc, fmpy, scipy; Linux)

The FMU is tests/c/lag.c, y' = (a b u - y)/tau, z = y^2, driven by a log of 2000 rows with noise. Both
minimise the same weighted squares of both outputs from the same start. fmpy is used as its users who care
for speed do: unpacked once, one instance that is reset, `simulate_fmu` for each run; scipy's
`least_squares` with its default method and tight tolerances. Times are processor times, least of some rounds.
"""

import json
import math
import os
import pathlib
import random
import re
import subprocess
import sys
import tempfile
import time

for variable in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS"):
    os.environ[variable] = "1"

import numpy as np  # noqa: E402
from fmpy import extract, instantiate_fmu, read_model_description, simulate_fmu  # noqa: E402
from scipy.optimize import least_squares  # noqa: E402

ROOT = pathlib.Path(__file__).resolve().parents[2]
TOOL = sys.argv[1] if len(sys.argv) > 1 else str(ROOT / "target/release/piezoloop")
ROWS, STEP, TRUTH, START = 2000, 0.05, (2.5, 0.3), (1.0, 1.0)
ROUNDS = 3
VARIABLES = (
    ("u", 'causality="input"', 'start="0"'),
    ("y", 'causality="output"', ""),
    ("a", 'causality="parameter" variability="fixed"', 'start="1"'),
    ("b", 'causality="parameter" variability="fixed"', 'start="1"'),
    ("tau", 'causality="parameter" variability="fixed"', 'start="1" min="0.001"'),
    ("idle", 'causality="parameter" variability="fixed"', 'start="0.5"'),
    ("z", 'causality="output"', ""),
)
FUNCTIONS = [
    f"fmi2{name}"
    for name in (
        "GetTypesPlatform GetVersion SetDebugLogging Instantiate FreeInstance SetupExperiment"
        " EnterInitializationMode ExitInitializationMode Terminate Reset GetReal GetInteger GetBoolean"
        " GetString SetReal SetInteger SetBoolean SetString GetFMUstate SetFMUstate FreeFMUstate"
        " SerializedFMUstateSize SerializeFMUstate DeSerializeFMUstate GetDirectionalDerivative"
        " SetRealInputDerivatives GetRealOutputDerivatives DoStep CancelStep GetStatus GetRealStatus"
        " GetIntegerStatus GetBooleanStatus GetStringStatus"
    ).split()
]


def fmu(folder):
    """Packs tests/c/lag.c."""
    binaries = folder / "lag" / "binaries" / "linux64"
    binaries.mkdir(parents=True)
    source = ROOT / "tests/c/lag.c"
    # fmpy wants all functions of the standard, also those that nobody calls.
    there = re.findall(r"(fmi2\w+)\(", source.read_text())
    rest = "".join(f"int {name}(void) {{ return 3; }}\n" for name in FUNCTIONS if name not in there)
    (folder / "rest.c").write_text(rest)
    compiler = ["cc", "-std=gnu11", "-O2", "-w", "-shared", "-fPIC"]
    files = ["-o", binaries / "lag.so", source, folder / "rest.c", "-lm"]
    subprocess.run([*compiler, *files], check=True)
    variables = "".join(
        f'<ScalarVariable name="{name}" valueReference="{reference}" {kind}><Real {real}/></ScalarVariable>\n'
        for reference, (name, kind, real) in enumerate(VARIABLES)
    )
    unknowns = '<Unknown index="2"/><Unknown index="7"/>'
    (folder / "lag" / "modelDescription.xml").write_text(
        '<?xml version="1.0" encoding="UTF-8"?>\n'
        '<fmiModelDescription fmiVersion="2.0" modelName="lag" guid="lag">\n'
        '<CoSimulation modelIdentifier="lag" canHandleVariableCommunicationStepSize="true"/>\n'
        f"<ModelVariables>\n{variables}</ModelVariables>\n<ModelStructure><Outputs>{unknowns}</Outputs>"
        f"<InitialUnknowns>{unknowns}</InitialUnknowns></ModelStructure>\n</fmiModelDescription>\n"
    )
    file = folder / "lag.fmu"
    subprocess.run([sys.executable, "-m", "zipfile", "-c", file, *os.listdir(folder / "lag")],
                   check=True, cwd=folder / "lag")
    return file


def log(file):
    """A log of the machine: time, u, y, z."""
    noise = random.Random(7)
    rows, y = [], 0.0
    for k in range(ROWS):
        u = (1.0, -0.5, 0.0, 2.0, 1.5)[k // 12 % 5]
        rows.append((k * STEP, u, y + noise.gauss(0, 0.05), y * y + noise.gauss(0, 0.5)))
        y += (TRUTH[0] * u - y) * -math.expm1(-STEP / TRUTH[1])
    text = "".join(f"{t!r},{u!r},{y!r},{z!r}\n" for t, u, y, z in rows)
    file.write_text("time,u,y,z\n" + text)
    return np.array(rows)


def ours(folder):
    """Answer and processor seconds."""
    call = [TOOL, "estimate", "lag.fmu", "--log", "log.csv", "--starts", "1", "--json"]
    call += ["--tune", f"a={START[0]!r}", "--tune", f"tau={START[1]!r}"]
    begin = os.times()
    answer = subprocess.run(call, cwd=folder, check=True, stdout=subprocess.PIPE).stdout
    end = os.times()
    spent = end.children_user + end.children_system - begin.children_user - begin.children_system
    return json.loads(answer), spent


def theirs(file, rows, weights):
    """Optimum, number of runs, processor seconds from opening the FMU."""
    begin = time.process_time()
    description = read_model_description(file)
    unpacked = extract(file)
    instance = instantiate_fmu(unpacked, description)
    table = np.zeros(len(rows), dtype=[("time", float), ("u", float)])
    table["time"], table["u"] = rows[:, 0], rows[:, 1]
    runs = 0

    def residuals(values):
        nonlocal runs
        runs += 1
        instance.reset()
        result = simulate_fmu(
            unpacked,
            model_description=description,
            fmu_instance=instance,
            start_time=0.0,
            stop_time=rows[-1, 0],
            output_interval=STEP,
            input=table,
            output=["y", "z"],
            start_values={"a": values[0], "tau": values[1]},
        )
        of = [(result[name] - rows[:, k]) / weights[name] for name, k in (("y", 2), ("z", 3))]
        return np.concatenate(of)

    tolerances = dict(xtol=1e-12, ftol=1e-12, gtol=1e-12)
    found = least_squares(residuals, START, bounds=((-np.inf, 0.001), np.inf), jac="3-point", **tolerances)
    return found.x, runs, time.process_time() - begin


def main():
    os.sched_setaffinity(0, {min(os.sched_getaffinity(0))})
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        file = fmu(folder)
        rows = log(folder / "log.csv")
        answer, _ = ours(folder)
        weights = dict(answer["weights"])
        our_time = min(ours(folder)[1] for _ in range(ROUNDS))
        optimum, runs, their_time = min((theirs(file, rows, weights) for _ in range(ROUNDS)), key=lambda t: t[2])
        values = np.array([parameter["value"] for parameter in answer["parameters"]])
        apart = np.max(np.abs(values - optimum) / np.abs(optimum))
        print(f"{'':16}{'a':>22}{'tau':>22}{'runs':>8}{'s':>10}")
        print(f"{'piezoloop':16}{values[0]:22.15f}{values[1]:22.15f}{answer['runs']:8}{our_time:10.3f}")
        print(f"{'fmpy + scipy':16}{optimum[0]:22.15f}{optimum[1]:22.15f}{runs:8}{their_time:10.3f}")
        print(f"times as fast: {their_time / our_time:.1f}; optimum apart by {apart:.1e} of its values")


if __name__ == "__main__":
    main()

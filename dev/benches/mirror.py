"""The public benchmark FineSteeringMirror: one plant for all three levels, and its official test errors.

usage: mirror.py PIEZOLOOP DATA [--levels 100,200,300]

DATA is the folder `data` of github.com/merijnfloren/fsm-benchmark-data (u_100mV_train.npy and so on; the same arrays as
nonlinear_benchmarks.FineSteeringMirror() gives). Needs numpy and fmpy. The plant is fitted to the training records alone, packed, and
driven by the test inputs in fmpy, free run. The data are periodic and in steady state: one period goes in front. Scoring as in
submission_examples/FineSteeringMirror.py: rms without the first 100 samples, mean over outputs, realisations and periods.
With one level the plant is linear.
"""

import subprocess
import sys
import tempfile
import time
from pathlib import Path

import fmpy
import numpy as np
from fmpy.fmi2 import FMU2Slave

RATE, INITIAL = 6400, 100


def read(data, level, kind):
    """Inputs in V and outputs in um: samples, channels, realisations, periods."""
    return np.load(data / f"u_{level}mV_{kind}.npy"), 1e6 * np.load(data / f"y_{level}mV_{kind}.npy")


def write(path, u, y):
    """All realisations as records of whole periods."""
    samples, _, realisations, periods = u.shape
    row = np.arange(samples * periods) / RATE
    records = []
    for r in range(realisations):
        u_r, y_r = (np.concatenate([x[:, :, r, p] for p in range(periods)]) for x in (u, y))
        records.append(np.column_stack([np.full(len(row), r), row, u_r, y_r]))
    head = "realization,time,u1,u2,u3,y1,y2,y3"
    np.savetxt(path, np.vstack(records), delimiter=",", header=head, comments="", fmt="%.9g")


def run(fmu, inputs):
    folder = fmpy.extract(fmu)
    description = fmpy.read_model_description(fmu)
    places = {v.name: v.valueReference for v in description.modelVariables}
    name = description.coSimulation.modelIdentifier
    slave = FMU2Slave(guid=description.guid, unzipDirectory=folder, modelIdentifier=name, instanceName="mirror")
    slave.instantiate()
    slave.setupExperiment(startTime=0.0)
    slave.enterInitializationMode()
    slave.exitInitializationMode()
    u = [places[f"command[{j}]"] for j in (1, 2, 3)]
    y = [places[f"position[{j}]"] for j in (1, 2, 3)]
    outputs = np.empty_like(inputs)
    for k, row in enumerate(inputs):
        outputs[k] = slave.getReal(y)
        slave.setReal(u, list(row))
        slave.doStep(currentCommunicationPoint=k / RATE, communicationStepSize=1 / RATE)
    slave.terminate()
    slave.freeInstance()
    return outputs


def score(fmu, u, y):
    samples, _, realisations, periods = u.shape
    errors = []
    for r in range(realisations):
        each = [u[:, :, r, p] for p in range(periods)]
        moved = run(fmu, np.concatenate([each[0], *each]))[samples:]
        for p in range(periods):
            rest = y[:, :, r, p] - moved[p * samples : (p + 1) * samples]
            errors.append(np.sqrt((rest[INITIAL:] ** 2).mean(0)))
    return np.mean(errors, axis=0)


def main():
    tool, data = Path(sys.argv[1]).resolve(), Path(sys.argv[2])
    levels = sys.argv[4].split(",") if sys.argv[3:4] == ["--levels"] else ["100", "200", "300"]
    with tempfile.TemporaryDirectory() as folder:
        at = Path(folder)
        logs = [at / f"{level}mV.csv" for level in levels]
        for log, level in zip(logs, levels):
            write(log, *read(data, level, "train"))
        channels = [word for k in (1, 2, 3) for word in ("--input", f"u{k}", "--output", f"y{k}", "--unit", f"u{k}=V", "--unit", f"y{k}=um")]
        call = [tool, "frequency-response", *logs, *channels, "--lines", "4000", "--modes", "24", "--plant", at / "mirror.toml"]
        start = time.monotonic()
        subprocess.run([*call, "--softening" if len(levels) > 1 else "--refine"], check=True, stdout=subprocess.DEVNULL)
        print(f"fitted in {time.monotonic() - start:.0f} s")
        subprocess.run([tool, "pack", "mirror.toml", "-o", "mirror.fmu"], check=True, stdout=subprocess.DEVNULL, cwd=at)
        for level in levels:
            each = score(str(at / "mirror.fmu"), *read(data, level, "test"))
            print(f"{level} mV: test RMSE {each.mean():.4f} um; outputs {', '.join(f'{e:.4f}' for e in each)}")


main()

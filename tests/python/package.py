"""The Python package: FMUs of rigs run in fmpy, a diagnosis comes back as objects, logs as arrays."""

import os
import sys

import fmpy
import numpy as np

import piezoloop

names = [rig.name for rig in piezoloop.rigs()]
assert "evc" in names, names

os.environ["XDG_CACHE_HOME"] = os.path.abspath("cache")
plant = piezoloop.path_to_fmu("evc")
assert piezoloop.path_to_fmu("evc") == plant
for fmu in (plant, piezoloop.path_to_fmu("evc", fmi=3, folder="here")):
    result = fmpy.simulate_fmu(fmu, stop_time=0.002, output_interval=1e-4)
    assert len(result) == 21, len(result)

try:
    piezoloop.path_to_fmu("no-such-rig")
    raise AssertionError("an unknown rig must be refused")
except piezoloop.PiezoloopError as error:
    assert "evc-truth" in str(error), error

# A log of a plant with a gain that is 30 % larger than the model's, and a little noise.
generator = np.random.default_rng(7)
time = np.arange(4000) * 1e-4
command = 50 - 40 * np.cos(2 * np.pi * 5 * time) + 10 * np.sin(2 * np.pi * 35 * time)
# Row k is read before command k acts.
before = np.concatenate([command[:1], command[:-1]])
position = 0.13 * before + generator.normal(0, 0.01, len(time))
rows = np.column_stack([time, command, position])
np.savetxt("stage.csv", rows, delimiter=",", header="time,command [V],position [um]", comments="")
stage = sys.argv[1]

log = piezoloop.load("stage.csv")
assert len(log) == len(time) and log.units == {"command": "V", "position": "um"}, log.units
assert np.array_equal(log.time, np.loadtxt("stage.csv", delimiter=",", skiprows=1)[:, 0])
assert np.allclose(log["position"], position, rtol=0, atol=1e-12)

gap = piezoloop.diagnose(
    stage,
    "stage.csv",
    map={"command[1]": "command", "position[1]": "position"},
    tune={"axis[1].actuator.gain": 0.5},
    noise=0.01,
    report="gap.html",
    seed=1,
    threads=1,
)
assert gap["schema"] == "piezoloop.gap/1"
assert gap.verdict == "retune", gap.verdict
assert gap.shrink.rms_after < 0.1 * gap.shrink.rms_as_given, gap.shrink
assert os.path.getsize("gap.html") > 1000

try:
    piezoloop.diagnose(stage, ["absent.csv"])
    raise AssertionError("an absent log must be refused")
except piezoloop.PiezoloopError as error:
    assert "absent.csv" in str(error), error
print("the package works")

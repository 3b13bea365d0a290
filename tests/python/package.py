"""The Python package: FMUs of rigs run in fmpy, a diagnosis comes back as objects, logs as arrays."""

import os
import sys
import zipfile

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
assert gap["schema"] == "piezoloop.gap/1" and isinstance(gap, piezoloop.Gap)
assert gap.verdict == "retune", gap.verdict
assert gap.shrink.rms_after < 0.1 * gap.shrink.rms_as_given, gap.shrink
assert os.path.getsize("gap.html") > 1000

try:
    piezoloop.diagnose(stage, ["absent.csv"])
    raise AssertionError("an absent log must be refused")
except piezoloop.PiezoloopError as error:
    assert "absent.csv" in str(error), error
# Arrays in, typed results and arrays out: from a log to a closed loop and a diagnosis.
time = np.arange(3000) * 1e-3
command = 5 - 4.5 * np.cos(2 * np.pi * 2 * time) * np.exp(-time / 3)
machine = piezoloop.simulate("p1", {"time": time, "command[1]": command})
assert np.array_equal(machine.time, time) and machine["position[1]"].shape == (3000,)
measured = {"time": time, "u": command, "y": machine["position[1]"] + generator.normal(0, 1e-3, 3000)}
stage = piezoloop.identify(measured, "u", "y", model="prandtl-ishlinskii", unit={"u": "V", "y": "um"})
assert stage.held_out < 1e-3, stage.held_out
assert stage.axes[0].method == "prandtl-ishlinskii" and "kind = \"plant\"" in stage.blueprint
controller = piezoloop.invert(stage, period=1e-3)
low, high = controller.axes[0].reach
wanted = (low + high) / 2 - 0.3 * (high - low) * np.cos(2 * np.pi * 2 * time[:1000])
result = piezoloop.loop(stage, controller, {"time": time[:1000], "reference[1]": wanted})
error = (result["position[1]"] - wanted)[100:]
assert np.sqrt(np.mean(error**2)) < 1e-3 * (high - low), np.sqrt(np.mean(error**2))
assert piezoloop.pack(controller, "controller.fmu", fmi=3).stat().st_size > 1000
piezoloop.pack("p1", "ported.fmu", fmi=3, ports=["electrical"], port_value={"capacitance": "2.1 uF"})
assert b"current" in zipfile.ZipFile("ported.fmu").read("modelDescription.xml")
found = piezoloop.estimate("p1", {"time": time, "command[1]": command, "position[1]": measured["y"]},
                           {"axis[1].actuator.gain": 3.0}, unit={"position[1]": "um"})
assert isinstance(found, piezoloop.Estimated) and isinstance(found.parameters[0], piezoloop.Parameter)
assert found.parameters[0].name == "axis[1].actuator.gain", found.parameters
assert found.parameters[0].interval[0] < found.parameters[0].value < found.parameters[0].interval[1], found.parameters
gap = piezoloop.diagnose("p1", {"time": time, "command[1]": command, "position[1]": measured["y"]}, noise=1e-3,
                         unit={"position[1]": "um"}, seed=1, threads=1)
assert gap.verdict == "adequate", gap.verdict
# A log alone: a hysteretic machine lacks nothing but what no linear model has.
plays = piezoloop.simulate("p1-truth", {"time": time, "command[1]": command})["position[1]"]
alone = piezoloop.diagnose(None, {"time": time, "u": command, "y": plays}, input="u", output="y", unit={"u": "V", "y": "um"},
                           baseline="linear.toml", seed=1, threads=1)
assert alone.baseline and os.path.getsize("linear.toml") > 100, alone.sentence
for effect in alone.effects:
    assert isinstance(effect, piezoloop.Effect) and 0 < effect.probability < 1 and effect.effect in effect.set, effect
    assert all(isinstance(value.value, float) for value in effect.parameters.values()), effect
for wrong, why in (({"u": command, "y": command}, "'time'"), ({"time": time, "u": command[:5]}, "one length")):
    try:
        piezoloop.identify(wrong, "u", "y")
        raise AssertionError("a log without time, or with columns of several lengths, must be refused")
    except ValueError as error:
        assert why in str(error), error
print("the package works")

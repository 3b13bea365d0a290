"""The same closed loop of two FMUs in several masters: time per communication step and FMU.

    cargo build --release
    python dev/benches/masters.py [TOOL]        (needs fmpy; ecospy where there is one)

The loop is the plant `evc` with its controller, two axes, four connections, 20 us, side by side
(Jacobi) in every master, without a record. The times are those of the processor that the masters
use, taken in turns in this one run; each figure is the slope between a short and a long run, so that
loading and initialisation do not count, and the least of some rounds, so that what else the machine
does matters little. The time of the FMUs themselves is in all figures. The last table is the peak memory of our master's process
for a run and for one of twenty times its length.
"""

import os
import pathlib
import subprocess
import sys
import tempfile
import time

ROOT = pathlib.Path(__file__).resolve().parents[2]
TOOL = sys.argv[1] if len(sys.argv) > 1 else str(ROOT / "target/release/piezoloop")
STEP = 20e-6
ROUNDS = 5
AXES = (1, 2)
LOOP = """\
name = "loop"
step = 2e-5
algorithm = "jacobi"
[fmus]
controller = "controller.fmu"
plant = "plant.fmu"
[connections]
"plant.command[1]" = "controller.command[1]"
"plant.command[2]" = "controller.command[2]"
"controller.measured[1]" = "plant.position[1]"
"controller.measured[2]" = "plant.position[2]"
[record]
"position[1]" = "plant.position[1]"
"position[2]" = "plant.position[2]"
"command[1]" = "plant.command[1]"
"""


def ours(steps, *arguments):
    """Processor seconds of our master for so many steps."""
    call = [TOOL, "system", "loop.toml", "--stop", repr(steps * STEP), "-q", *arguments]
    begin = os.times()
    subprocess.run(call, check=True)
    end = os.times()
    return end.children_user + end.children_system - begin.children_user - begin.children_system


class Fmpy:
    """The loop by hand, value references looked up once, as fmpy's users write it."""

    def __init__(self):
        from fmpy import extract, read_model_description
        from fmpy.fmi2 import FMU2Slave

        self.slaves, self.references = {}, {}
        for name in ("controller", "plant"):
            file = f"{name}.fmu"
            d = read_model_description(file)
            slave = FMU2Slave(guid=d.guid, unzipDirectory=extract(file), instanceName=name,
                              modelIdentifier=d.coSimulation.modelIdentifier)
            slave.instantiate()
            slave.setupExperiment(startTime=0.0)
            slave.enterInitializationMode()
            slave.exitInitializationMode()
            self.slaves[name] = slave
            self.references |= {(name, v.name): v.valueReference for v in d.modelVariables}
        self.done = 0

    def run(self, steps):
        c, p = self.slaves["controller"], self.slaves["plant"]
        of = lambda name, what: [self.references[name, f"{what}[{i}]"] for i in AXES]
        measured, command = of("controller", "measured"), of("controller", "command")
        acting, position = of("plant", "command"), of("plant", "position")
        begin = time.process_time()
        for k in range(self.done, self.done + steps):
            u, y = c.getReal(command), p.getReal(position)
            p.setReal(acting, u)
            c.setReal(measured, y)
            c.doStep(k * STEP, STEP)
            p.doStep(k * STEP, STEP)
        took = time.process_time() - begin
        self.done += steps
        return took


class Ecos:
    """The fixed-step algorithm of ecos, many steps per call."""

    def __init__(self):
        from ecospy import EcosSimulation, EcosSimulationStructure

        self.structure = EcosSimulationStructure()
        self.structure.add_model("plant", "plant.fmu")
        self.structure.add_model("controller", "controller.fmu")
        for i in AXES:
            connect = self.structure.make_real_connection
            connect(f"controller::command[{i}]", f"plant::command[{i}]")
            connect(f"plant::position[{i}]", f"controller::measured[{i}]")
        self.simulation = EcosSimulation(structure=self.structure, step_size=STEP)
        self.simulation.init()

    def run(self, steps):
        begin = time.process_time()
        self.simulation.step(steps)
        return time.process_time() - begin


def made(master):
    try:
        return master()
    except (ImportError, OSError) as error:
        print(f"SKIPPED: {master.__name__.lower()}: {error}")
        return None


def per_step(run, short, long):
    """ns per step and FMU: the slope between two lengths."""
    return (run(long) - run(short)) / (long - short) / 2 * 1e9


def speed():
    masters = {"ours": (ours, 20_000, 2_020_000)}
    for name, master in (("ecos", Ecos), ("fmpy", Fmpy)):
        if one := made(master):
            lengths = (2_000, 402_000) if name == "ecos" else (500, 20_500)
            masters[name] = (one.run, *lengths)
    least = dict.fromkeys(masters, float("inf"))
    for _ in range(ROUNDS):
        for name, what in masters.items():
            least[name] = min(least[name], per_step(*what))
    print(f"{'master':10}{'ns per step and FMU':>22}{'times ours':>14}")
    for name, figure in least.items():
        print(f"{name:10}{figure:22.0f}{figure / least['ours']:14.1f}")


def peak(steps, ending):
    """Peak resident memory in MB of a process of our master alone."""
    code = ("import os, resource, subprocess, sys; subprocess.run(sys.argv[1:], check=True); "
            "print(resource.getrusage(resource.RUSAGE_CHILDREN).ru_maxrss)")
    call = [TOOL, "system", "loop.toml", "--stop", repr(steps * STEP), "-q", "-o", f"run.{ending}"]
    said = subprocess.run([sys.executable, "-c", code, *call], check=True, capture_output=True)
    size = os.path.getsize(f"run.{ending}") / 1e6
    os.remove(f"run.{ending}")
    return int(said.stdout) / 1024, size


def memory():
    print(f"\n{'record':10}{'peak MB':>10}{'file MB':>10}{'20x: peak MB':>16}{'file MB':>10}")
    for ending in ("csv", "npy", "npz", "parquet"):
        short, long = peak(50_000, ending), peak(1_000_000, ending)
        print(f"{ending:10}{short[0]:10.1f}{short[1]:10.1f}{long[0]:16.1f}{long[1]:10.1f}")


if __name__ == "__main__":
    with tempfile.TemporaryDirectory() as folder:
        os.chdir(folder)
        controller = ROOT / "tests/blueprints/controller.toml"
        for blueprint, name in (("evc", "plant"), (controller, "controller")):
            pack = [TOOL, "pack", str(blueprint), "--fmi", "2", "-o", f"{name}.fmu"]
            subprocess.run(pack, check=True, stdout=subprocess.DEVNULL)
        pathlib.Path("loop.toml").write_text(LOOP)
        speed()
        memory()
        os.chdir(ROOT)

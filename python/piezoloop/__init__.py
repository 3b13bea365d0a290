"""Piezoloop for Python: FMUs of the known machines, diagnoses as objects, logs as NumPy arrays.

The tool ``piezoloop``, which this package contains, does the work::

    import fmpy, piezoloop

    plant = piezoloop.path_to_fmu("evc")
    result = fmpy.simulate_fmu(plant, stop_time=0.01, start_values={"command[1]": 60.0})

    stage = piezoloop.identify(log, input="u", output="y", unit={"u": "V", "y": "um"})      # arrays, data frames or files
    controller = piezoloop.invert(stage, period=1e-3)
    result = piezoloop.loop(stage, controller, {"time": t, "reference[1]": wanted})
    gap = piezoloop.diagnose(stage, ["measured.csv"])
    print(gap.verdict, [effect.effect for effect in gap.effects])

    log = piezoloop.load("measured.mf4")
    print(log.time, log["position[1]"], log.units["position[1]"])

    piezoloop.sweep("plan.toml", "plan.parquet")              # many runs, here or on Dask
"""

from ._dask import sweep
from ._diagnose import diagnose
from ._log import Log, load
from ._results import Effect, Estimate, Estimated, Figure, Gap, Parameter, Shrink, Swept
from ._rigs import path_to_fmu, rigs
from ._tables import Blueprint
from ._tool import PiezoloopError, Record, executable, run
from ._workflow import Controller, Identified, estimate, identify, invert, loop, pack, simulate

__all__ = [
    "Blueprint",
    "Controller",
    "Effect",
    "Estimate",
    "Estimated",
    "Figure",
    "Gap",
    "Identified",
    "Log",
    "Parameter",
    "PiezoloopError",
    "Record",
    "Shrink",
    "Swept",
    "diagnose",
    "estimate",
    "executable",
    "identify",
    "invert",
    "load",
    "loop",
    "pack",
    "path_to_fmu",
    "rigs",
    "run",
    "simulate",
    "sweep",
]

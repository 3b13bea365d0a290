"""Piezoloop for Python: FMUs of the known machines, diagnoses as objects, logs as NumPy arrays.

Everything is done by the tool ``piezoloop``, which this package brings along::

    import fmpy, piezoloop

    plant = piezoloop.path_to_fmu("evc")
    result = fmpy.simulate_fmu(plant, stop_time=0.01, start_values={"command[1]": 60.0})

    gap = piezoloop.diagnose(plant, ["measured.csv"])
    print(gap.verdict, [effect.effect for effect in gap.effects])

    log = piezoloop.load("measured.mf4")
    print(log.time, log["position[1]"], log.units["position[1]"])

    piezoloop.sweep("plan.toml", "plan.parquet")              # many runs, here or on Dask
"""

from ._dask import sweep
from ._diagnose import diagnose
from ._log import Log, load
from ._rigs import path_to_fmu, rigs
from ._tool import PiezoloopError, Record, executable, run

__all__ = [
    "Log",
    "PiezoloopError",
    "Record",
    "diagnose",
    "executable",
    "load",
    "path_to_fmu",
    "rigs",
    "run",
    "sweep",
]

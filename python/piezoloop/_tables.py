"""Tables in and out: what a caller has in memory becomes a file for the tool, and back."""

from __future__ import annotations

import csv
import os
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any, Union

import numpy as np

if TYPE_CHECKING:
    from ._log import Log

PathLike = Union[str, "os.PathLike[str]"]
Table = Union[PathLike, "Log", Mapping[str, Any], np.ndarray, Any]
"""A log: a file of any format that the tool reads, a :class:`Log`, a mapping of names to arrays of shape
(rows,) with ``"time"`` in s, a structured array, or a pandas data frame. An optional column ``"record"`` separates records."""


class Blueprint(str):
    """The text of a blueprint (TOML). Pass it where a plant, a controller or a model is wanted."""

    def save(self, path: PathLike) -> Path:
        """Writes the text to a file and returns its path."""
        file = Path(path)
        file.write_text(self, encoding="utf-8")
        return file


class Files:
    """A folder of a call: tables and blueprints in memory are written to it once each."""

    def __init__(self, folder: PathLike) -> None:
        self.folder = Path(folder)
        self.count = 0

    def model(self, model: PathLike) -> str:
        """The path of a blueprint or FMU, or the name of a rig."""
        if isinstance(model, Blueprint):
            self.count += 1
            return os.fspath(model.save(self.folder / f"model_{self.count}.toml"))
        return os.fspath(model)

    def table(self, table: Table) -> tuple[str, list[str]]:
        """The path of a log, and the options ``--unit`` that say the units it has in memory."""
        if isinstance(table, (str, os.PathLike)):
            return os.fspath(table), []
        units: Mapping[str, str | None] = getattr(table, "units", {})
        columns = _columns(table)
        self.count += 1
        path = self.folder / f"log_{self.count}.npy"
        rows = {len(values) for values in columns.values()}
        if len(rows) != 1:
            lengths = ", ".join(f"{name}: {len(values)}" for name, values in columns.items())
            raise ValueError(f"columns of a log have one length; these have {lengths}")
        if "time" not in columns:
            raise ValueError(f"a log needs a column 'time' in s; this one has {', '.join(columns)}")
        kinds = [(name, np.int64 if name == "record" else np.float64) for name in columns]
        whole = np.empty(rows.pop(), dtype=kinds)
        for name, values in columns.items():
            whole[name] = values
        np.save(path, whole)
        return os.fspath(path), [f"--unit={name}={unit}" for name, unit in units.items() if unit]

    def tables(self, option: str, given: Table | Iterable[Table]) -> list[str]:
        """``--log FILE`` for each of one or several logs, with their units."""
        arguments: list[str] = []
        for one in several(given):
            path, units = self.table(one)
            arguments += [option, path, *(unit for unit in units if unit not in arguments)]
        return arguments


def several(given: Any) -> list[Any]:
    """A list of one or several tables."""
    return list(given) if isinstance(given, (list, tuple)) else [given]


def _columns(table: Any) -> dict[str, np.ndarray]:
    if hasattr(table, "record") and hasattr(table, "columns") and hasattr(table, "time") and isinstance(table.columns, dict):
        return {"time": table.time, "record": table.record, **table.columns}
    if isinstance(table, np.ndarray):
        if table.dtype.names is None:
            raise ValueError("an array is a log only with named fields; pass a mapping of names to arrays")
        return {name: np.asarray(table[name]).ravel() for name in table.dtype.names}
    # Mappings, and data frames: both have keys and columns by name.
    return {str(name): np.asarray(table[name]).ravel() for name in table.keys()}


def read_csv(path: PathLike) -> dict[str, np.ndarray]:
    """Columns of a file that the tool wrote."""
    with open(path, encoding="utf-8", newline="") as rows:
        names = next(csv.reader(rows))
        values = np.loadtxt(rows, delimiter=",", ndmin=2).reshape(-1, len(names))
    return {name: np.ascontiguousarray(values[:, at]) for at, name in enumerate(names)}


def options(**given: Any) -> list[str]:
    """Options of the tool: ``hold_out=0.3`` is ``--hold-out 0.3``; mappings and lists are repeated, ``True`` is a switch."""
    arguments: list[str] = []
    for name, value in given.items():
        option = f"--{name.replace('_', '-')}"
        if value is None or value is False:
            continue
        if value is True:
            arguments.append(option)
        elif isinstance(value, Mapping):
            arguments += [f"{option}={key}={_text(one)}" for key, one in value.items()]
        elif isinstance(value, (list, tuple)):
            arguments += [f"{option}={_text(one)}" for one in value]
        else:
            arguments.append(f"{option}={_text(value)}")
    return arguments


def _text(value: Any) -> str:
    if isinstance(value, bool):
        return str(value).lower()
    return os.fspath(value) if isinstance(value, os.PathLike) else str(value)

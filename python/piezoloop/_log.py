"""Logs as NumPy arrays."""

from __future__ import annotations

import os
import tempfile
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from ._tables import read_csv
from ._tool import run


@dataclass(frozen=True)
class Log:
    """A measured log or a simulated run: ``log["position[1]"]`` is a column of float64."""

    time: np.ndarray
    """Time in s, shape (rows,); starts anew in each record."""
    record: np.ndarray
    """Number of the record that a row belongs to, shape (rows,)."""
    columns: dict[str, np.ndarray]
    """Signals by name, each of shape (rows,)."""
    units: dict[str, str | None] = field(default_factory=dict)
    """Unit of each signal; ``None``: the log does not say."""

    def __getitem__(self, name: str) -> np.ndarray:
        return self.columns[name]

    def __len__(self) -> int:
        return len(self.time)

    def to_pandas(self):
        """A pandas data frame with ``time`` in s and ``record`` in front. Needs pandas."""
        import pandas

        return pandas.DataFrame({"time": self.time, "record": self.record, **self.columns})


def load(
    path: str | os.PathLike[str], *, rate: float | None = None, group: str | None = None
) -> Log:
    """Reads a log of any format that the tool reads: CSV, Parquet, NumPy, MATLAB 5, MDF 4, TDMS.

    Args:
        path: the file.
        rate: sample rate in Hz, for logs without a time column.
        group: the group of a measurement file (MDF, TDMS), or the length of arrays (MAT, npz).

    Raises:
        PiezoloopError: no such file, or none that can be read, with line or place.
    """
    options = [] if rate is None else ["--rate", repr(float(rate))]
    options += [] if group is None else ["--group", group]
    with tempfile.TemporaryDirectory() as folder:
        text = Path(folder) / "log.csv"
        about = run("log", path, *options, "--out", text)
        columns = read_csv(text)
    time = columns.pop("time")
    record = columns.pop("record", np.zeros(len(time))).astype(int)
    units = {column.name: column.unit for column in about.logs[0].columns}
    return Log(time, record, columns, units)

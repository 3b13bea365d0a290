"""The diagnosis as objects."""

from __future__ import annotations

import os
import tempfile
from collections.abc import Iterable, Mapping, Sequence

from ._tables import Files, PathLike as Path, Table
from ._tool import Record, run
from ._workflow import Identified, _model


def diagnose(
    model: Path | Identified,
    logs: Table | Sequence[Table],
    *,
    holdout: Table | Sequence[Table] = (),
    map: Mapping[str, str] | None = None,
    unit: Mapping[str, str] | None = None,
    outputs: Iterable[str] = (),
    tune: Mapping[str, str | float] | None = None,
    noise: float | Mapping[str, float] | None = None,
    rest: Table | None = None,
    max_effects: int | None = None,
    without: Iterable[str] = (),
    report: Path | None = None,
    repair: Path | None = None,
    next_experiment: Path | None = None,
    threads: int | None = None,
    seed: int | None = None,
) -> Record:
    """Says which effect a model lacks, where the gap lies and how far it shrinks.

    The arguments are the options of ``piezoloop diagnose``; ``map={"position[1]": "y"}`` is
    ``--map position[1]=y``, ``tune={"axis[1].*": 0.05}`` a relative tolerance (1 σ) and
    ``tune={"axis[1].delay.time": "+-1e-4"}`` an absolute one.

    ``model`` is an FMU, a blueprint's path or text, a rig's name, or what :func:`identify` returned; logs are files or
    tables in memory, as for :func:`identify`.

    Returns:
        the fields of ``gap.json`` (schema ``piezoloop.gap/1``): ``gap.verdict``,
        ``gap.effects[0].probability``, ``gap.shrink.fraction``, …

    Raises:
        PiezoloopError: bad input, with the tool's own message.
    """
    with tempfile.TemporaryDirectory() as folder:
        files = Files(folder)
        arguments: list[Path] = ["diagnose", "--model", files.model(_model(model))]

        def add(option: str, *values: object) -> None:
            for value in values:
                if value is not None:
                    text = os.fspath(value) if isinstance(value, os.PathLike) else str(value)
                    arguments.extend([option, text])

        for option, tables in (("--log", logs), ("--holdout", holdout), ("--rest", rest)):
            if tables is not None:
                arguments += files.tables(option, tables)
        add("--map", *_pairs(map))
        add("--unit", *_pairs(unit))
        names = ",".join(outputs)
        add("--outputs", names or None)
        add("--tune", *_pairs(tune))
        add("--noise", *(_pairs(noise) if isinstance(noise, Mapping) else [noise]))
        add("--max-effects", max_effects)
        add("--without", *without)
        add("--report", report)
        add("--repair", repair)
        add("--next-experiment", next_experiment)
        add("--threads", threads)
        add("--seed", seed)
        return run(*arguments)


def _pairs(values: Mapping[str, object] | None) -> list[str]:
    return [f"{name}={value}" for name, value in (values or {}).items()]

"""The diagnosis as objects."""

from __future__ import annotations

import os
from collections.abc import Iterable, Mapping
from typing import Union

from ._tool import Record, run

Path = Union[str, "os.PathLike[str]"]


def diagnose(
    model: Path,
    logs: Path | Iterable[Path],
    *,
    holdout: Path | Iterable[Path] = (),
    map: Mapping[str, str] | None = None,
    unit: Mapping[str, str] | None = None,
    outputs: Iterable[str] = (),
    tune: Mapping[str, str | float] | None = None,
    noise: float | Mapping[str, float] | None = None,
    rest: Path | None = None,
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

    Returns:
        the fields of ``gap.json`` (schema ``piezoloop.gap/1``): ``gap.verdict``,
        ``gap.effects[0].probability``, ``gap.shrink.fraction``, …

    Raises:
        PiezoloopError: bad input, with the tool's own message.
    """
    arguments: list[Path] = ["diagnose", "--model", model]

    def add(option: str, *values: object) -> None:
        for value in values:
            if value is not None:
                text = os.fspath(value) if isinstance(value, os.PathLike) else str(value)
                arguments.extend([option, text])

    add("--log", *_several(logs))
    add("--holdout", *_several(holdout))
    add("--map", *_pairs(map))
    add("--unit", *_pairs(unit))
    names = ",".join(outputs)
    add("--outputs", names or None)
    add("--tune", *_pairs(tune))
    add("--noise", *(_pairs(noise) if isinstance(noise, Mapping) else [noise]))
    add("--rest", rest)
    add("--max-effects", max_effects)
    add("--without", *without)
    add("--report", report)
    add("--repair", repair)
    add("--next-experiment", next_experiment)
    add("--threads", threads)
    add("--seed", seed)
    return run(*arguments)


def _several(paths: Path | Iterable[Path]) -> list[Path]:
    return [paths] if isinstance(paths, (str, os.PathLike)) else list(paths)


def _pairs(values: Mapping[str, object] | None) -> list[str]:
    return [f"{name}={value}" for name, value in (values or {}).items()]

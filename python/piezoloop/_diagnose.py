"""The diagnosis as objects."""

from __future__ import annotations

import os
import tempfile
from collections.abc import Iterable, Mapping, Sequence

from ._tables import Files, PathLike as Path, Table
from ._results import Gap
from ._tool import run
from ._workflow import Identified, _model


def diagnose(
    model: Path | Identified | None,
    logs: Table | Sequence[Table],
    *,
    input: str | Sequence[str] | None = None,
    output: str | Sequence[str] | None = None,
    frequency_response: Path | None = None,
    baseline: Path | None = None,
    holdout: Table | Sequence[Table] = (),
    map: Mapping[str, str] | None = None,
    unit: Mapping[str, str] | None = None,
    outputs: Iterable[str] = (),
    tune: Mapping[str, str | float] | None = None,
    noise: float | Mapping[str, float] | None = None,
    rest: Table | None = None,
    drop: float | None = None,
    accuracy: float | None = None,
    gain_tolerance: float | None = None,
    max_effects: int | None = None,
    without: Iterable[str] = (),
    report: Path | None = None,
    repair: Path | None = None,
    next_experiment: Path | None = None,
    isolate: bool = False,
    threads: int | None = None,
    seed: int | None = None,
) -> Gap:
    """Finds the effect that a model lacks, where the gap lies, and how much of it the effect explains.

    The arguments are the options of ``piezoloop diagnose``; ``map={"position[1]": "y"}`` is
    ``--map position[1]=y``, ``tune={"axis[1].*": 0.05}`` a relative tolerance (1 σ) and
    ``tune={"axis[1].delay.time": "+-1e-4"}`` an absolute one.

    Args:
        model: an FMU, a blueprint's path or text, a rig's name, or what :func:`identify` returned. ``None``: a linear model is
            identified from the logs with ``input`` and ``output``, or from ``frequency_response``.
        logs: files or tables in memory, as for :func:`identify`.
        input, output: without a model: the columns of command and position; lists for several axes.
        baseline: blueprint file for that linear model.
        holdout: logs that are not fitted, only judged; otherwise the last 30 % of each record.
        noise: standard deviation of the noise in the log's unit, also by output.
        rest: a record of the machine at rest.
        drop: seconds at the start of each record that are neither fitted nor judged.
        accuracy: rms over the range of the output that is good enough.
        report, repair, next_experiment: files to write: HTML page, repaired model (``.toml`` or ``.fmu``), log of the next experiment.
        isolate: run an FMU in a separate process.

    Returns:
        the fields of ``gap.json`` (schema ``piezoloop.gap/1``): ``gap.verdict``, ``gap.effects[0].probability``,
        ``gap.shrink.fraction``, …

    Raises:
        PiezoloopError: bad input, with the tool's own message.
    """
    with tempfile.TemporaryDirectory() as folder:
        files = Files(folder)
        arguments: list[Path] = ["diagnose"]
        if model is not None:
            arguments += ["--model", files.model(_model(model))]

        def add(option: str, *values: object) -> None:
            for value in values:
                if value is not None:
                    text = os.fspath(value) if isinstance(value, os.PathLike) else str(value)
                    arguments.extend([option, text])

        for option, tables in (("--log", logs), ("--holdout", holdout), ("--rest", rest)):
            if tables is not None:
                arguments += files.tables(option, tables)
        add("--input", *_columns(input))
        add("--output", *_columns(output))
        add("--frequency-response", frequency_response)
        add("--baseline", baseline)
        add("--drop", drop)
        add("--accuracy", accuracy)
        add("--gain-tolerance", gain_tolerance)
        if isolate:
            arguments.append("--isolate")
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
        return Gap(run(*arguments))


def _columns(names: str | Sequence[str] | None) -> list[str]:
    return [names] if isinstance(names, str) else list(names or ())


def _pairs(values: Mapping[str, object] | None) -> list[str]:
    return [f"{name}={value}" for name, value in (values or {}).items()]

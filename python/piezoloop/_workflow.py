"""From a log to a controller: the tool's main commands as functions, arrays in and out."""

from __future__ import annotations

import tempfile
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from ._log import Log
from ._tables import Blueprint, Files, PathLike, Table, options, read_csv
from ._results import Estimated
from ._tool import Record, run


@dataclass(frozen=True)
class Identified:
    """A plant from measured logs."""

    blueprint: Blueprint
    """The plant; pass it to :func:`invert`, :func:`pack`, :func:`simulate`, :func:`diagnose`."""
    axes: list[Record]
    """Per axis: ``method``, ``records`` (errors on fitted and held-out rows, in the position's unit and as share of range),
    ``candidates`` (structures that were tried) and ``parameters`` with their deviations and verdicts."""
    notes: list[Any]
    """What was assumed, dropped or guessed."""

    @property
    def held_out(self) -> float:
        """Root mean square error on held-out rows over the range, the greatest of all axes and records."""
        return max(part.held_out.nrmse for axis in self.axes for part in axis.records if part.get("held_out"))


@dataclass(frozen=True)
class Controller:
    """A controller for a plant."""

    blueprint: Blueprint
    """The controller; pass it to :func:`pack` or :func:`loop`."""
    axes: list[Record]
    """Per axis: gains, ``gain_margin``, ``phase_margin`` in degrees, ``bandwidth`` in Hz, ``reach`` (positions that the command's limits
    allow, in the position's unit) and ``checks`` (its errors on its own plant)."""
    answer: Record
    """The whole answer of the tool."""


def identify(
    log: Table | Sequence[Table],
    input: str | Sequence[str],
    output: str | Sequence[str],
    *,
    model: str | None = None,
    unit: Mapping[str, str] | None = None,
    map: Mapping[str, str] | None = None,
    rate: float | None = None,
    drop: float | None = None,
    hold_out: float | None = None,
    static: bool = False,
    name: str | None = None,
    seed: int | None = None,
    threads: int | None = None,
    report: PathLike | None = None,
) -> Identified:
    """Identifies a plant: hysteresis, delay, amplifier lag and mode, judged in simulation mode on held-out rows.

    Args:
        log: one or several logs; columns have shape (rows,), ``"time"`` is in s.
        input, output: the column of the command and that of the position; lists for several axes.
        model: the hysteresis model, such as ``"prandtl-ishlinskii"``; ``None`` tries all.
        unit: units of columns, ``{"y": "um"}``, if the log does not state them.
        map: columns by the names of variables; ``{"time": "t"}`` names the time column.
        rate: sample rate in Hz of a log without times.
        drop: seconds at the start of each record that are left out.
        hold_out: last part of each record, 0 to 1, that is not fitted but judges the fit.
        static: no amplifier lag and no mode.
        name: name of the plant.
        seed, threads: of the particle swarm.
        report: HTML page to write.

    Returns:
        the plant; its errors are in :attr:`Identified.axes`.

    Raises:
        PiezoloopError: bad input, with the tool's own message.
    """
    with tempfile.TemporaryDirectory() as folder:
        files = Files(folder)
        out = Path(folder) / "plant.toml"
        columns = [(input, output)] if isinstance(input, str) else list(zip(input, output, strict=True))
        axes = [f"--{key}={value}" for pair in columns for key, value in zip(("input", "output"), pair)]
        answer = run(
            "identify", *files.tables("--log", log), *axes, "--out", out,
            *options(model=model, unit=unit, map=map, rate=rate, drop=drop, hold_out=hold_out, static=static, name=name,
                     seed=seed, threads=threads, report=report),
        )
        return Identified(Blueprint(out.read_text(encoding="utf-8")), answer.axes, answer.get("notes", []))


def invert(
    plant: PathLike | Identified,
    *,
    period: float | None = None,
    feedforward: str | None = None,
    feedback: str | None = None,
    sensitivity: float | None = None,
    command_acts: str | None = None,
    damping: str | None = None,
    noise: float | None = None,
    force: bool = False,
    name: str | None = None,
) -> Controller:
    """Designs the controller of a plant: inverse feedforward and feedback with margins, tested on the plant before it is returned.

    Args:
        plant: an identified plant, a blueprint's text or path, or a rig's name.
        period: sample time of the controller in s.
        feedforward, feedback: kinds by name; ``piezoloop invert PLANT --list`` shows what suits a plant.
        sensitivity: greatest peak of the sensitivity function.
        command_acts: ``at-once`` or ``next-period``, if that is known; the margins then hold for this case only.
        damping: inner loop for the first resonance: ``irc``, ``ppf``, ``nrc``, ``automatic`` or ``notch``.
        noise: greatest amplification of sensor noise by the controller.
        force: return the controller even if its error is larger than that of feedback alone.

    Raises:
        PiezoloopError: the plant cannot be inverted, with the component and what to do.
    """
    with tempfile.TemporaryDirectory() as folder:
        out = Path(folder) / "controller.toml"
        answer = run(
            "invert", Files(folder).model(_model(plant)), "--out", out,
            *options(period=period, feedforward=feedforward, feedback=feedback, sensitivity=sensitivity,
                     command_acts=command_acts, damping=damping,
                     noise=noise, force=force, name=name),
        )
        return Controller(Blueprint(out.read_text(encoding="utf-8")), answer.axes, answer)


def pack(
    blueprint: PathLike | Identified | Controller,
    out: PathLike,
    *,
    fmi: int = 2,
    step: float | None = None,
    all_effects: bool = False,
    libraries: PathLike | None = None,
    ports: Iterable[str] | None = None,
    port_value: Mapping[str, float | str] | None = None,
) -> Path:
    """Packs a plant or a controller as a co-simulation FMU and returns its path.

    Args:
        blueprint: an identified plant, a controller, a blueprint's text or path, or a rig's name.
        out: the FMU to write.
        fmi: 2 or 3.
        step: internal step in s.
        all_effects: add every effect of the library, disabled.
        libraries: folder with the libraries of further platforms.
        ports: ``mechanical``, ``electrical``, ``thermal``: variables for system simulation, in SI units.
        port_value: values that the ports need and the blueprint does not state, such as ``{"capacitance": "2.1 uF"}``.
    """
    with tempfile.TemporaryDirectory() as folder:
        answer = run(
            "pack", Files(folder).model(_model(blueprint)), "--out", out,
            *options(fmi=fmi, step=step, all_effects=all_effects, libraries=libraries,
                     ports=None if ports is None else list(ports), port_value=port_value),
        )
    return Path(answer.fmu)


def simulate(
    model: PathLike | Identified | Controller,
    log: Table,
    *,
    start: Mapping[str, float | bool] | None = None,
    map: Mapping[str, str] | None = None,
    unit: Mapping[str, str] | None = None,
    record: Iterable[str] | None = None,
    step: float | None = None,
    isolate: bool = False,
) -> Log:
    """Runs a blueprint or any co-simulation FMU under the inputs of a log.

    Args:
        model: an FMU, a blueprint, a rig's name, or what :func:`identify` or :func:`invert` returned.
        log: columns of shape (rows,) whose names are the model's inputs, or are mapped to them.
        start: start values by variable.
        map: ``{"command[1]": "u"}`` takes the column ``u`` as that input.
        record: variables to record; ``None``: driven inputs and all outputs.

    Returns:
        the run: columns of shape (rows,) float64 over ``time`` in s.
    """
    with tempfile.TemporaryDirectory() as folder:
        files, out = Files(folder), Path(folder) / "run.csv"
        run(
            "simulate", files.model(_model(model)), *files.tables("--log", log), "--out", out,
            *options(start=start, map=map, unit=unit, record=None if record is None else list(record), step=step, isolate=isolate),
        )
        return _log(out)


def loop(
    plant: PathLike | Identified,
    controller: PathLike | Controller,
    reference: Table,
    *,
    coupling: str | None = None,
    start: Mapping[str, float | bool] | None = None,
    map: Mapping[str, str] | None = None,
) -> Log:
    """Closes the loop of a plant and a controller along a reference; both may be FMUs or blueprints.

    Args:
        reference: columns ``reference[1]``, … in the position's unit over ``time`` in s.
        coupling: ``"controller-first"`` or ``"side-by-side"`` (one step more delay, as in masters that step all FMUs at once).
    """
    with tempfile.TemporaryDirectory() as folder:
        files, out = Files(folder), Path(folder) / "run.csv"
        both = []
        for name, model in (("plant", _model(plant)), ("controller", _model(controller))):
            path = files.model(model)
            both.append(path if path.endswith(".fmu") else pack(path, Path(folder) / f"{name}.fmu"))
        run(
            "simulate", "--loop", *both, *files.tables("--reference", reference), "--out", out,
            *options(coupling=coupling, start=start, map=map),
        )
        return _log(out)


def estimate(
    model: PathLike | Identified,
    log: Table | Sequence[Table],
    tune: Mapping[str, float | str] | Iterable[str],
    *,
    output: Iterable[str] | None = None,
    held_out: Table | Sequence[Table] | None = None,
    start: Mapping[str, float | bool] | None = None,
    map: Mapping[str, str] | None = None,
    unit: Mapping[str, str] | None = None,
    starts: int | None = None,
    report: PathLike | None = None,
) -> Estimated:
    """Estimates parameters and start values of any co-simulation FMU or blueprint from logs.

    Args:
        model: an FMU of FMI 2.0 or 3.0, a blueprint, or a rig's name.
        tune: ``{"mass": 0.2}`` begins at 0.2; ``{"damping": "1,0.1..10"}`` adds bounds; for a list of names the FMU's start values are used.
        output: outputs to compare; ``None``: all that the logs have.
        held_out: logs that are not fitted, only judged.
        start: fixed start values by variable.
        starts: number of starting points of the search.

    Returns:
        values with 95 % intervals, correlation, parameters that the logs do not determine, errors per record.
    """
    with tempfile.TemporaryDirectory() as folder:
        files = Files(folder)
        judged = [] if held_out is None else files.tables("--held-out", held_out)
        wanted: Any = tune if isinstance(tune, Mapping) else list(tune)
        answer = run(
            "estimate", files.model(_model(model)), *files.tables("--log", log), *judged,
            *options(tune=wanted, output=None if output is None else list(output), start=start, map=map, unit=unit, starts=starts, report=report),
        )
        return Estimated(answer)


def _model(given: PathLike | Identified | Controller) -> PathLike:
    return given.blueprint if isinstance(given, (Identified, Controller)) else given


def _log(path: Path) -> Log:
    columns = read_csv(path)
    time = columns.pop("time")
    record = columns.pop("record", np.zeros(len(time))).astype(int)
    return Log(time, record, columns, {})

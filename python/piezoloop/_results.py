"""What the functions return, with types: each class names the fields of the tool's JSON answer, read as attributes or keys."""

from __future__ import annotations

from typing import Any

from ._tool import Record


class Estimate(Record):
    """A value with its uncertainty."""

    value: float
    std: float | None
    """One standard deviation; ``None``: the data do not determine it."""
    unit: str


class Effect(Record):
    """An effect that the model lacks."""

    effect: str
    """Identifier, such as ``"creep"``; ``piezoloop list effects`` lists them."""
    output: str
    also: list[str]
    """Further outputs that show the same cause."""
    stage: str
    """Place in the signal path: ``"timing"``, ``"amplifier"``, ``"actuator"``, ``"mechanics"``, ``"coupling"``, ``"environment"``, ``"sensor"``."""
    probability: float
    set: list[str]
    """The smallest set of names whose probabilities sum to 95 %, the most probable first."""
    group: str | None
    """Effects that look alike in a log: ``"lag"``, ``"gain"``, ``"slow"``, ``"static_map"``."""
    parameters: dict[str, Estimate]
    explained: float
    """Share of the held-out gap's power that this effect explains, given the others."""


class Shrink(Record):
    """The gap on held-out rows, before and after."""

    unit: str
    rms_before: float
    """Residual of the re-tuned model, in ``unit``."""
    rms_after: float
    """The same with the effects added."""
    noise_floor: float
    fraction: float | None
    """``1 - (rms_after² - noise²)/(rms_before² - noise²)``."""
    ci95: list[float] | None
    rms_as_given: float
    """Residual of the model before the re-tune."""
    relative_gap: float


class Gap(Record):
    """The answer of :func:`piezoloop.diagnose`: ``gap.json`` (schema ``piezoloop.gap/1``)."""

    sentence: str
    verdict: str
    """``"adequate"``, ``"retune"``, ``"effects"``, ``"unknown"`` or ``"insufficient_excitation"``."""
    effects: list[Effect]
    shrink: Shrink
    retuned: dict[str, Record]
    leftover: Record
    next_experiment: Record | None
    candidates: list[Record]
    outputs: list[Record]
    baseline: list[Record]
    """The linear models that were identified, if no model was given."""
    warnings: list[str]

    def __init__(self, answer: Any) -> None:
        super().__init__(answer)
        self["effects"] = [Effect(effect) for effect in self["effects"]]
        for effect in self["effects"]:
            effect["parameters"] = {name: Estimate(value) for name, value in effect["parameters"].items()}
        self["shrink"] = Shrink(self["shrink"])


class Parameter(Record):
    """A parameter that was estimated."""

    name: str
    unit: str | None
    start: float
    value: float
    sigma: float | None
    """Standard deviation; ``None``: the logs do not determine it."""
    interval: list[float] | None
    """95 % interval."""
    at_bound: bool


class Estimated(Record):
    """The answer of :func:`piezoloop.estimate`."""

    parameters: list[Parameter]
    correlation: list[list[float | None]]
    """Shape (parameters, parameters)."""
    undetermined: list[Any]
    """Parameters, alone or in groups, that the logs do not determine."""
    fits: list[Record]
    """Per log, record and output: ``rmse``, ``nrmse_percent`` and ``fit_percent`` with the estimates, ``rmse_at_start`` before."""
    notes: list[str]

    def __init__(self, answer: Any) -> None:
        super().__init__(answer)
        self["parameters"] = [Parameter(parameter) for parameter in self["parameters"]]


class Figure(Record):
    """A column of the table of a sweep."""

    name: str
    unit: str | None
    median: float
    percent_5: float
    percent_95: float
    max: float
    max_run: int
    """The run with the greatest value."""


class Swept(Record):
    """The answer of :func:`piezoloop.sweep`; the runs are in the Parquet file ``table``."""

    table: str
    runs: int
    failed: int
    first_failure: str | None
    figures: list[Figure]

    def __init__(self, answer: Any) -> None:
        super().__init__(answer)
        self["figures"] = [Figure(figure) for figure in self["figures"]]

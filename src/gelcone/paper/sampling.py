"""Shares of parameter ranges, by low-discrepancy samples that grow until the answer is certain or a budget ends.

A sample is a scrambled Sobol sequence, judged whenever its length is a power of two. In one dimension it has one point
in each of equal parts of the range, and a share is judged as that of strata, so that a sharp edge costs few points. In
more dimensions the points count as independent. The confidence allows for repeated judging.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np

from gelcone import dataset
from gelcone.motion.attractor.classification import classify
from gelcone.motion.lyapunov import finite_exponents
from gelcone.motion.start import complete
from gelcone.paper.effort import Effort
from gelcone.paper.truths import Share, share, stratified
from gelcone.physics.model import ConeModel
from gelcone.quantity import Array

if TYPE_CHECKING:
    import xarray as xr

SEED = 104
FIRST = 16
"""Points of the first judgement; each later one has twice as many."""
SIGN_BUDGET = 2_000.0
"""Averaging time of exponents of which only the sign is needed."""


@dataclass(frozen=True)
class Sample:
    """A sample: a parameter set with ``changes``, and parameters ``drawn`` uniformly between two bounds each.

    ``logarithmic``: uniformly in the logarithm. ``inner``: parameters with several values at every draw, the same
    number for each. ``answered`` takes the study of the points so far and returns whether they suffice. A ``costly``
    sample has a smaller budget in quick runs.
    """

    name: str
    preset: str
    drawn: Mapping[str, tuple[float, float]]
    answered: Callable[[xr.Dataset], bool]
    changes: Mapping[str, Any] = field(default_factory=dict)
    inner: Mapping[str, Any] = field(default_factory=dict)
    logarithmic: bool = False
    costly: bool = False

    def values(self, shares: Array) -> dict[str, Array]:
        """Values of the drawn parameters at points of the unit cube (points, parameters)."""
        values = {}
        for k, (name, (low, high)) in enumerate(self.drawn.items()):
            even = np.log([low, high]) if self.logarithmic else np.array([low, high])
            at = even[0] + (even[1] - even[0]) * shares[:, k]
            values[name] = np.exp(at) if self.logarithmic else at
        return values


Observe = Callable[[ConeModel, tuple[float, float], Effort], "xr.Dataset"]


def sampled(
    samples: Sequence[Sample], effort: Effort, progress: Callable[[float], None], observe: Observe | None = None
) -> xr.Dataset:
    """The observations of all samples over ``point``, with the name of the sample in ``part``; see `observed`."""
    import xarray as xr

    parts = []
    for sample in samples:
        part = _grown(sample, effort, observe or observed)
        parts.append(part.assign_coords(part=("point", np.full(part.sizes["point"], sample.name))))
        progress(1.0 / len(samples))
    result = xr.concat(parts, "point", join="exact", combine_attrs="override", coords="minimal", compat="override")
    return result.assign_attrs(preset=samples[0].preset)


def _grown(sample: Sample, effort: Effort, observe: Observe) -> xr.Dataset:
    import xarray as xr
    from scipy.stats import qmc

    preset, sequence = effort.preset(sample.preset), qmc.Sobol(len(sample.drawn), seed=SEED)
    most = effort.costly_samples if sample.costly else effort.samples
    seen: list[xr.Dataset] = []
    count = FIRST
    while True:
        values = sample.values(sequence.random(count if not seen else count // 2))
        if sample.inner:
            values = {name: drawn[:, None] for name, drawn in values.items()}
        model = preset.model.replace(**sample.changes, **values, **sample.inner)
        points = over_points(observe(model, preset.initial, effort))
        at = {f"drawn_{name}": ("point", np.ravel(drawn)) for name, drawn in values.items()}
        seen.append(points.assign_coords(at).assign_attrs(window=effort.window))
        whole = xr.concat(seen, "point", join="exact", combine_attrs="override")
        if count >= most or sample.answered(whole):
            return whole
        count *= 2


def over_points(study: xr.Dataset) -> xr.Dataset:
    """An ensemble's Dataset with its dims named ``point`` and ``inner``."""
    dims = {"member": "point", "member_0": "point", "member_1": "inner"}
    return study.rename({old: new for old, new in dims.items() if old in study.dims})


def observed(model: ConeModel, initial: tuple[float, float], effort: Effort) -> xr.Dataset:
    """Regime, exponents, extent and exponents over the window of every member of an ensemble."""
    members = model.members()
    states = complete(members, np.tile(initial, (model.size, 1)))
    evidence = classify(members, states, patience=effort.patience, budget=SIGN_BUDGET)
    finite, *_ = finite_exponents(members, states, effort.window, {})
    extent = np.fmax(np.abs(evidence.lowest), np.abs(evidence.highest))
    variables: dict[str, dataset.Variable] = {
        "regime": ((), evidence.regime, "kind of motion in the long run", "code"),
        "lyapunov": (("exponent",), evidence.exponents, "Lyapunov exponents of the long run", "rate"),
        "standard_error": (("exponent",), evidence.standard_error, "standard error of the exponents", "rate"),
        "share_chaotic": ((), evidence.share_chaotic, "share of nearby starts that are chaotic", "share"),
        "lifetime_high": ((), evidence.lifetime_high, "largest mean lifetime of chaos", "time"),
        "extent": ((), extent, "largest displacement in the long run", "length"),
        "finite": (("exponent",), finite, "Lyapunov exponents over the window from the start", "rate"),
    }
    return dataset.label(model, variables, outcome=evidence.outcome, options={}, title="a sample of parameters")


def share_of(points: xr.Dataset, truths: Array) -> Share:
    """The share of a sample's points at which a statement holds."""
    drawn = [name for name in points.coords if str(name).startswith("drawn_")]
    return stratified(points[drawn[0]].values, truths) if len(drawn) == 1 else share(truths)


def part(study: xr.Dataset, name: str) -> xr.Dataset:
    """The points of one sample of a study."""
    return study.isel(point=np.flatnonzero(study["part"].values == name))

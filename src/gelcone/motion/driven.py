"""The driven half of an operating envelope: what the settled motion does over peak voltage and drive frequency."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from gelcone.codes import Outcome, Regime
from gelcone.errors import InputError, unknown_name
from gelcone.membrane.pull_in import PullInCurve
from gelcone.motion.attractor.classification import classify
from gelcone.motion.equilibrium import Ramp, drive_ramp
from gelcone.motion.floquet import onset_voltage
from gelcone.motion.flow import integrate
from gelcone.motion.linear import stiffness_under
from gelcone.motion.natural import frequency_of
from gelcone.motion.response import dissipated_energy, even_times
from gelcone.motion.settle import start_states
from gelcone.motion.validity import lasting, slack_places
from gelcone.physics.model import ConeModel
from gelcone.quantity import Array

DRIVEN_LIMITS = (
    "pull-in",
    "dielectric breakdown",
    "hoop slack",
    "meridional slack",
    "stretch limit",
    "chaos",
    "onset of rest",
)
"""``pull-in``: the film, or the membrane in its place, loses its equilibrium during the motion; first, to be named
where several are met at once.
``onset of rest``: rest loses its stability under the drive (Floquet), where rest is flat."""
BISECTIONS = 6
CHUNK = 128
PERIODS = 12.0
"""Drive periods of the settled motion that are examined."""
NUDGE = 1e-3
"""Displacement from rest at which each motion starts, so that it leaves an unstable rest."""
SPAN = (0.1, 3.0, 24)
"""Drive frequencies over the natural one that are examined: from, to, how many."""
RESONANCES = (0.5, 1.0, 2.0)
"""Drive frequencies over the natural one where the first resonances lie: by a sine, by a bias, parametric."""
TOO_CLOSE = 0.03
"""Frequencies nearer to each other than this share add nothing."""
WITHIN = 0.01
"""Share to which the lowest limit between two frequencies is known by the straight line from one to the other."""
NARROWEST = 1.002
"""Frequencies over each other between which a limit that does not follow the line jumps."""
REFINEMENTS = 10
FROM = ("rest", "settled", "both")
"""What the limits hold for: the motion from rest, switched on at once, with its transient; the motion that is settled
while the voltage rises slowly; or both."""

Progress = Callable[[float], None]


@dataclass(frozen=True)
class DriveShape:
    """The shape of a drive, its peak voltage being 1: shares of amplitude and bias."""

    amplitude: float
    bias: float

    @classmethod
    def of(cls, model: ConeModel) -> DriveShape:
        peak = peak_of(model)
        if peak == 0.0:
            raise InputError("voltage = 0: the envelope scales the device's drive; give it an amplitude or a bias")
        return cls(float(model.voltage) / peak, float(model.voltage_bias) / peak)


def peak_of(model: ConeModel) -> float:
    """The largest absolute voltage of a single model's drive."""
    return float(model.peak_voltage)


@dataclass(frozen=True)
class Plane:
    """A single model at any peak voltage and drive frequency, started next to its rest."""

    model: ConeModel
    shape: DriveShape
    rest: float
    threads: int | None
    membrane: PullInCurve | None = None
    """Above which voltages the film as a membrane has pulled in; None: the model's own film tells."""
    limits_from: str = "rest"

    def __post_init__(self) -> None:
        if self.limits_from not in FROM:
            raise unknown_name("limits_from", str(self.limits_from), FROM)

    @classmethod
    def of(
        cls, model: ConeModel, threads: int | None, membrane: PullInCurve | None = None, limits_from: str = "rest"
    ) -> Plane:
        """That of a single model; `InputError` for a drive without voltage."""
        shape = DriveShape.of(model)
        return cls(model, shape, drive_ramp(model, np.zeros(1), shape.bias).rest, threads, membrane, limits_from)

    def at(self, omegas: Array, peaks: Array) -> ConeModel:
        return self.model.replace(
            drive_frequency=omegas, voltage=self.shape.amplitude * peaks, voltage_bias=self.shape.bias * peaks
        )

    def ramp(self, levels: Array) -> Ramp:
        """Of the drive in proportion, to constant peak voltages."""
        return drive_ramp(self.model, levels, self.shape.bias)

    def natural_frequency(self, peak: float = 0.0) -> float:
        """About the equilibrium under the drive's mean-square voltages; NaN where there is no stable one."""
        drive = self.model.replace(voltage=self.shape.amplitude * peak, voltage_bias=self.shape.bias * peak)
        return float(frequency_of(stiffness_under(drive)))

    def default_frequencies(self, own_peak: float) -> Array:
        """Frequencies around the natural one, those of the first resonances and the model's own among them."""
        natural = self.natural_frequency()
        naturals = np.array([natural, self.natural_frequency(own_peak)])
        special = np.concatenate([[self.model.drive_frequency], np.outer(RESONANCES, naturals).ravel()])
        kept: list[float] = []
        for omega in [*special[np.isfinite(special)], *natural * np.geomspace(*SPAN)]:
            inside = SPAN[0] * natural <= omega <= SPAN[1] * natural
            if inside and all(abs(omega / other - 1.0) > TOO_CLOSE for other in kept):
                kept.append(float(omega))
        return np.sort(kept)

    def examine(
        self, omegas: Array, peaks: Array, progress: Progress = lambda share: None, lower: Array | None = None
    ) -> dict[str, Array]:
        """What the settled motion does at pairs of frequency and peak, arrays (pairs,); and which limits it meets.

        ``lower``: states (pairs, N) settled at lower peaks, from which the voltage rises; without them all start from
        rest.
        """
        parts = []
        for first in range(0, len(omegas), CHUNK):
            part = slice(first, first + CHUNK)
            model = self.at(omegas[part], peaks[part])
            start = start_states(model, (self.rest + NUDGE, 0.0))
            slow = None if lower is None or self.limits_from == "rest" else self._examine(model, lower[part])
            if slow is None or self.limits_from == "both":
                found = self._examine(model, start, transient=self.limits_from != "settled")
                if slow is not None:
                    met = {name: np.maximum(found[name], slow[name]) for name in DRIVEN_LIMITS[:-1]}
                    found = found | met | {"final": slow["final"]}
            else:
                found = slow
            parts.append(found)
            progress(len(found["regime"]) / len(omegas))
        return {name: np.concatenate([part[name] for part in parts]) for name in parts[0]}

    def _examine(self, model: ConeModel, start: Array, transient: bool = False) -> dict[str, Array]:
        """`examine` from ``start``, with the limits that the ``transient`` from there meets."""
        evidence = classify(model.members(), start, threads=self.threads)
        ran = evidence.outcome == Outcome.OK
        pulled_in = evidence.outcome == Outcome.PULLED_IN
        left = ~ran & ~pulled_in
        after = np.where(ran[:, None], evidence.final, start)
        seen = self._look(model, after)
        shares = {name: seen[name] for name in (*_SLACK_AND_LIMIT.values(), "breakdown", "beyond_membrane")}
        if transient:
            early = self._look(model, start)
            shares = {name: np.maximum(values, early[name]) for name, values in shares.items()}
        breakdown = shares["breakdown"]

        def where_ran(values: Any) -> Array:
            return np.where(ran, values, np.nan)

        return (
            {name: where_ran(seen[name]) for name in ("stroke", "power", "apparent_power", "field")}
            | {
                "final": after,
                "regime": evidence.regime.astype(float),
                "outcome": evidence.outcome.astype(float),
                "pull-in": (pulled_in | (ran & (shares["beyond_membrane"] > 0.0))).astype(float),
                "dielectric breakdown": np.where(np.isnan(breakdown), np.nan, left | (breakdown > 0.0)),
                "chaos": np.isin(evidence.regime, (Regime.CHAOTIC, Regime.TRANSIENT_CHAOS)).astype(float),
            }
            | {limit: (left | (shares[name] > 0.0)).astype(float) for limit, name in _SLACK_AND_LIMIT.items()}
        )

    def _look(self, model: ConeModel, states: Array) -> dict[str, Array]:
        """What motions from ``states`` do over `PERIODS` drive periods: that part of what `simulate` tells."""
        members = model.members()
        times = even_times(model, PERIODS * model.drive_period)
        run = integrate(members, states, times, keep="work", threads=self.threads)
        assert run.work is not None
        x, n = run.states[..., 0], members.numbers(trailing=1)
        voltages = members.voltages(times, run.states)
        voltage, film = voltages[0], members.system.film
        with np.errstate(over="ignore", invalid="ignore"):  # of a motion that leaves the domain
            current = members.system.currents(times, list(np.moveaxis(run.states, -1, 0)), n)[0]
            state = film.state(x, voltage, n)
            apparent = [np.sqrt(np.mean(values * values, axis=1)) for values in (voltage, current)]
        beyond = np.zeros(len(x)) if self.membrane is None else (voltage > self.membrane.voltage(x)).mean(axis=1)
        found = lasting(members, times, run.states).shares()
        if film.kinds:  # wrinkles bound the use of a film, too
            times_of = run.film_times[:, 0]
            found |= {name: times_of[:, places].sum(axis=1) for name, places in slack_places(film).items()}
        return found | {
            "beyond_membrane": beyond,
            "stroke": np.ptp(x, axis=1),
            "power": dissipated_energy(members.system, run.work)[:, -1] / (PERIODS * model.drive_period),
            "apparent_power": apparent[0] * apparent[1],
            "field": state.true_field.max(axis=1),
        }


_SLACK_AND_LIMIT = {
    "hoop slack": "hoop_slack",
    "meridional slack": "meridional_slack",
    "stretch limit": "near_limit",
}


def driven(
    plane: Plane,
    omegas: Array,
    volts: Array,
    *,
    refine: bool,
    progress: Progress,
    ceiling: float = np.inf,
) -> dict[str, Array]:
    """All that `Plane.examine` finds, each (frequencies, peaks); ``low`` and ``high`` (frequencies, limits), the
    intervals of the peak voltage in which each limit is first met; and ``frequency`` (frequencies,).

    With ``refine`` frequencies are added until the lowest limit, or the ``ceiling`` where that is lower, is known to
    `WITHIN` its share between any two.
    """
    found = _rows(plane, omegas, volts, lambda share: progress(0.5 * share if refine else share))
    confirmed = set[tuple[float, float]]()
    for _ in range(REFINEMENTS if refine else 0):
        between = unknown_between(plane, found, min(ceiling, float(volts[-1])), confirmed)
        if between.size:
            more = _rows(plane, between, volts, lambda share: progress(0.5 * share / REFINEMENTS))
            order = np.argsort(np.concatenate([found["frequency"], between]))
            found = {name: np.concatenate([values, more[name]])[order] for name, values in found.items()}
        else:
            progress(0.5 / REFINEMENTS)
    return found


def unknown_between(
    plane: Plane, found: dict[str, Array], ceiling: float, confirmed: set[tuple[float, float]]
) -> Array:
    """Middles of neighbouring frequencies at which the lowest limit is off the straight line between them; those on
    it are added to the ``confirmed`` pairs.

    ``found`` holds ``frequency``, ``low`` and ``final_below`` of `driven`. Only two voltages are examined at each: one
    `WITHIN` below the line, which must meet no limit, and one above, which must meet one.
    """
    known = found["frequency"]
    lowest = np.clip(np.fmin.reduce(found["low"], axis=1), 0.0, ceiling)
    pairs = list(zip(known[:-1].tolist(), known[1:].tolist(), strict=True))
    line = 0.5 * (lowest[:-1] + lowest[1:])
    open_ = np.array([pair not in confirmed for pair in pairs]) & (known[1:] > NARROWEST * known[:-1]) & (line > 0.0)
    at = np.flatnonzero(open_)
    if not at.size:
        return np.empty(0)
    middle, below, above = np.sqrt(known[at] * known[at + 1]), line[at] * (1.0 - WITHIN), line[at] * (1.0 + WITHIN)
    lower = 0.5 * (found["final_below"][at] + found["final_below"][at + 1])
    seen = plane.examine(np.tile(middle, 2), np.concatenate([below, above]), lower=np.tile(lower, (2, 1)))
    met = np.any([seen[name] > 0.0 for name in DRIVEN_LIMITS[:-1]], axis=0).reshape(2, -1)
    onset = _onset(plane, middle, ceiling)[0]
    met |= np.stack([below, above]) >= onset
    on_line = ~met[0] & (met[1] | (above >= ceiling))
    confirmed.update(pairs[k] for k in at[on_line])
    return np.asarray(middle[~on_line])


def _rows(plane: Plane, omegas: Array, volts: Array, progress: Progress) -> dict[str, Array]:
    """`driven` at the given frequencies."""
    seen, lower = [], None
    step = len(volts) if plane.limits_from == "rest" else 1
    for first in range(0, len(volts), step):  # slowly: each voltage from the motion at the one before
        some = volts[first : first + step]
        grid_omega, grid_peak = (mesh.ravel() for mesh in np.meshgrid(omegas, some, indexing="ij"))
        part = plane.examine(grid_omega, grid_peak, lambda done: progress(0.6 * step / len(volts) * done), lower)
        seen.append({name: v.reshape(len(omegas), len(some), *v.shape[1:]) for name, v in part.items()})
        lower = seen[-1]["final"][:, -1]
    found = {name: np.concatenate([part[name] for part in seen], axis=1) for name in seen[0]}
    low, high = _limits(plane, found, omegas, volts, lambda share: progress(0.4 * share))
    final = found.pop("final")
    return found | {"low": low, "high": high, "frequency": omegas, "final_below": _below_all(final, low, volts)}


def _below_all(final: Array, low: Array, volts: Array) -> Array:
    """The settled states (frequencies, N) at the highest voltage below all limits, or the lowest voltage."""
    lowest = np.fmin.reduce(low, axis=1)
    place = np.clip(np.searchsorted(volts, lowest, side="right") - 1, 0, len(volts) - 1)
    return np.asarray(final[np.arange(len(final)), place])


def _limits(
    plane: Plane, seen: dict[str, Array], omegas: Array, volts: Array, progress: Progress
) -> tuple[Array, Array]:
    """Intervals of the peak voltage in which each limit is first met, (frequencies, limits) each."""
    met = np.stack([seen[name] for name in DRIVEN_LIMITS[:-1]], axis=1)
    reached, first = (met > 0.0).any(axis=2), np.argmax(met > 0.0, axis=2)
    below = np.concatenate([[0.0], volts])
    low, high = np.full((2, len(omegas), len(DRIVEN_LIMITS)), np.nan)
    low[:, :-1] = np.where(reached, below[first], np.inf)
    high[:, :-1] = np.where(reached, volts[first], np.inf)
    unknown = np.isnan(met).any(axis=2)
    low[:, :-1][unknown] = high[:, :-1][unknown] = np.nan
    rows, columns = np.nonzero(reached & ~unknown)
    for _ in range(BISECTIONS if rows.size else 0):
        middle = 0.5 * (low[rows, columns] + high[rows, columns])
        # a motion that leaves the domain meets several limits at one voltage: it is looked at once
        points, of = np.unique(np.stack([rows, middle]), axis=1, return_inverse=True)
        at = points[0].astype(np.intp)
        place = np.clip(np.searchsorted(volts, points[1]) - 1, 0, len(volts) - 1)
        now = plane.examine(omegas[at], points[1], lower=seen["final"][at, place])
        hit = np.stack([now[name] for name in DRIVEN_LIMITS[:-1]])[columns, of.ravel()] > 0.0
        high[rows, columns] = np.where(hit, middle, high[rows, columns])
        low[rows, columns] = np.where(hit, low[rows, columns], middle)
        progress(0.9 / BISECTIONS)
    low[:, -1], high[:, -1] = _onset(plane, omegas, float(volts[-1]))
    progress(0.1 if rows.size else 1.0)
    return low, high


def _onset(plane: Plane, omegas: Array, highest: float) -> tuple[Any, Any]:
    """Peak voltages at which flat rest loses stability under an unbiased drive; NaN where rest is not flat."""
    if not is_flat(plane.model) or plane.shape.bias != 0.0:
        return np.nan, np.nan
    amplitude = plane.shape.amplitude
    found = onset_voltage(plane.model.replace(drive_frequency=omegas), highest=amplitude * highest)
    onset = np.where(np.isnan(found["onset_voltage"].values), np.inf, found["onset_voltage"].values)
    return onset / amplitude, (onset + np.nan_to_num(found["onset_error"].values)) / amplitude


def is_flat(model: ConeModel) -> bool:
    """Whether a single model's flat film is an equilibrium."""
    return bool(model.members().symmetric[0])

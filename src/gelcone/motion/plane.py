"""The plane of peak voltage and drive frequency: a single model in it, the limits of its motion and its yields."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
import numpy.typing as npt

from gelcone.codes import Outcome, Regime
from gelcone.errors import InputError, check_name
from gelcone.motion.attractor.classification import classify
from gelcone.motion.attractor.search import (
    CHAOS_TRANSIENTS,
    PATIENCE,
    Search,
    Starts,
    are_slow,
    patience_of,
    transient_of,
    transient_of_the_disc,
)
from gelcone.motion.corners import between_corners, sampled_evenly
from gelcone.motion.delivery import lost_in_jumps
from gelcone.motion.electrical import apparent_power, charge_of, field_of
from gelcone.motion.extent import extent
from gelcone.motion.flow import integrate
from gelcone.motion.job import Keep, Trajectories
from gelcone.motion.natural import driven_frequency
from gelcone.motion.peaks import Value, largest
from gelcone.motion.ramp import Ramp, drive_ramp
from gelcone.motion.response import dissipated_energy, heat_of
from gelcone.motion.settle import alike, next_power_of_two
from gelcone.motion.start import start_states
from gelcone.motion.validity import slack_places, violations
from gelcone.physics.balance import StaticBalance
from gelcone.physics.film.pull_in import PullInCurve, curves_of_members
from gelcone.physics.members import Members
from gelcone.physics.model import ConeModel
from gelcone.physics.statics import every_balance, rest_displacement
from gelcone.quantity import Array

Rows = npt.NDArray[np.intp]

DRIVEN_LIMITS = (
    "pull-in",
    "dielectric breakdown",
    "hoop slack",
    "meridional slack",
    "stretch limit",
    "chaos",
    "onset of rest",
)
"""``pull-in``: the film, or the membrane in its place, loses its equilibrium during the motion; it comes first, so that
it is named where several limits are met at once.
``onset of rest``: rest loses its stability under the drive (Floquet), where rest is flat."""
CHUNK = 128
PERIODS = 12
"""Drive periods of the settled motion that are examined."""
DECAYS, LONGEST_TRANSIENT = 4.0, 1000.0
"""Decay times for which the transient from rest is examined, and the longest time by the damping of the disc. For far
slower states the drift is examined instead, where its course is known."""
LONGEST_WAIT = 16.0
"""Transients of the disc for which a motion with slow states is followed if it does not drift."""
PER_PERIOD, PER_OSCILLATION = 16, 10
"""Fewest samples of a drive period and of the fastest oscillation."""
BLOCK_SAMPLES = 2**17
TOLERANCE = 1e-10
"""Relative error of a step, far below the error of limits."""
NUDGE = 1e-3
"""Displacement from rest at which each motion starts, so that it leaves an unstable rest."""
SPAN = (0.1, 3.0, 24)
"""Default drive frequencies over the natural one: first, last, number."""
RESONANCES = (0.5, 1.0, 2.0)
"""Drive frequencies over the natural one of the first resonances: by a sine, by a bias, parametric."""
TOO_CLOSE = 0.03
"""Smallest relative distance of default frequencies."""
FROM = ("rest", "settled", "both")
"""Motions for which limits hold: switched on from rest, with the transient; settled while the voltage rises slowly; or
both."""


@dataclass(frozen=True)
class DriveShape:
    """The shape of a drive, its peak voltage being 1: shares of amplitude and bias."""

    amplitude: float
    bias: float

    @classmethod
    def of(cls, model: ConeModel) -> DriveShape:
        """The shape of a model's drive. Raises `InputError` for one without voltage."""
        model.system.waveform.check_repeats()
        peak = float(model.peak_voltage)
        if peak == 0.0:
            bias = float(model.voltage_bias)
            if bias < 0.0:
                raise InputError(f"voltage_bias = {bias:g}: the drive stays at 0 V, and here it is scaled; raise it")
            raise InputError("voltage = 0: here the device's drive is scaled; give it an amplitude or a bias")
        return cls(float(model.voltage) / peak, float(model.voltage_bias) / peak)

    def at(self, peak: Any) -> dict[str, Any]:
        """The voltages of the drive at a peak voltage, as parameters of a model."""
        return {"voltage": self.amplitude * peak, "voltage_bias": self.bias * peak}


@dataclass(frozen=True)
class Plane:
    """A single model at any peak voltage and drive frequency, started next to its rest.

    ``membrane`` gives the voltages above which the membrane has pulled in that the first film stands for, where the
    model itself has no ``radius_ratio`` by which it is known. Constant voltages keep the proportion of the drive; with
    ``own_bias`` those of films in opposite phase keep the model's bias. Motions are followed for the
    ``patience``, by default that of `regime`; if ``brief`` for `CHAOS_TRANSIENTS` transients, enough to see chaos, but
    not its end.
    """

    model: ConeModel
    shape: DriveShape
    rest: float
    threads: int | None
    membrane: PullInCurve | None = None
    limits_from: str = "rest"
    own_bias: bool = False
    patience: float | None = None
    brief: bool = False

    def __post_init__(self) -> None:
        check_name("motion that limits hold from", self.limits_from, FROM)

    @classmethod
    def of(
        cls, model: ConeModel, threads: int | None, membrane: PullInCurve | None = None, limits_from: str = "rest"
    ) -> Plane:
        """The plane of a single model. Raises `InputError` for a drive without voltage."""
        shape = DriveShape.of(model)
        return cls(model, shape, rest_displacement(model), threads, membrane, limits_from)

    def at(self, omegas: Array, peaks: Array) -> ConeModel:
        """The model at pairs of frequency and peak voltage."""
        return self.model.replace(drive_frequency=omegas, **self.shape.at(peaks))

    @cached_property
    def membranes(self) -> list[PullInCurve]:
        """The curves of the membranes that the films stand for."""
        model, curves = self.model, [] if self.membrane is None else [self.membrane]
        for film in model.system.films:
            curves += [curve for _, curve in curves_of_members(film, model.members().values) or ()]
        return curves

    @cached_property
    def bias_share(self) -> float:
        """The bias over the voltage of the drive's peak, negative if they have different signs."""
        along, against = self.model.system.waveform.along_bias(self.model.own_numbers)
        return abs(self.shape.bias) * (1.0 if along >= against else -1.0)

    @cached_property
    def _balance(self) -> StaticBalance:
        (balance,) = every_balance(self.model, None if self.own_bias else self.bias_share)
        return balance

    def ramp(self, levels: Array) -> Ramp:
        """The ramp to constant peak voltages."""
        return drive_ramp(self._balance, levels)

    def natural_frequency(self, peak: float = 0.0) -> float:
        """Natural frequency about the equilibrium under the drive's mean-square voltages; NaN without a stable one."""
        return driven_frequency(self.model.replace(**self.shape.at(peak)))

    def default_frequencies(self) -> Array:
        """Frequencies around the natural one, including those of the first resonances and the model's own."""
        natural = self.natural_frequency()
        naturals = np.array([natural, self.natural_frequency(float(self.model.peak_voltage))])
        special = np.concatenate([[self.model.drive_frequency], np.outer(RESONANCES, naturals).ravel()])
        kept: list[float] = []
        for omega in [*special[np.isfinite(special)], *natural * np.geomspace(*SPAN)]:
            inside = SPAN[0] * natural <= omega <= SPAN[1] * natural
            if inside and all(abs(omega / other - 1.0) > TOO_CLOSE for other in kept):
                kept.append(float(omega))
        return np.sort(kept)

    def examine(
        self,
        omegas: Array,
        peaks: Array,
        lower: Array | None = None,
        *,
        yields: bool = True,
        shift: float = 0.0,
    ) -> dict[str, Array]:
        """The settled motion at pairs of frequency and peak, arrays (pairs,), and the limits that it meets.

        ``lower`` are states (pairs, N) settled at lower peaks, from which the voltage rises; by default motions start
        from rest. All starts are displaced by ``shift``. Without ``yields``, stroke, powers and field are left out.
        """
        parts = []
        for first in range(0, len(omegas), CHUNK):
            part = slice(first, first + CHUNK)
            model = self.at(omegas[part], peaks[part])
            start = start_states(model, (self.rest + NUDGE + shift, 0.0))
            slow = None
            if lower is not None and self.limits_from != "rest":
                slow = self._examine(model, lower[part] + shift * np.eye(1, lower.shape[1]), yields)
            if slow is None or self.limits_from == "both":
                examined = self._examine(model, start, yields, transient=self.limits_from != "settled")
                if slow is not None:
                    met = {name: np.maximum(examined[name], slow[name]) for name in DRIVEN_LIMITS[:-1]}
                    examined = examined | met | {"final": slow["final"]}
            else:
                examined = slow
            parts.append(examined)
        return {name: np.concatenate([part[name] for part in parts]) for name in parts[0]}

    def _examine(self, model: ConeModel, start: Array, yields: bool, transient: bool = False) -> dict[str, Array]:
        """`examine` from ``start``; with ``transient``, limits that the transient from there meets count, too."""
        members = model.members()
        final, regime, outcome, search = self._settle(members, start, classified=yields)
        ran, pulled_in = outcome == Outcome.OK, outcome == Outcome.PULLED_IN
        escaped = ~ran & ~pulled_in
        after = np.where(ran[:, None], final, start)
        observed = self._observe(members, after, 0.0, yields)
        fails = {name: observed[name] for name in _FAILINGS}
        if transient:
            lasts = self._transient(members, search.cycles.attracting)
            early = self._observe(members, start, lasts, yields=False)
            fails = {name: np.maximum(values, early[name]) for name, values in fails.items()}
            for rows, course in search.courses:
                which, at = np.nonzero(np.isfinite(course[..., 0]))
                passed = self._observe(members.take(rows[which]), course[which, at], 0.0, yields=False)
                for name, values in fails.items():
                    np.fmax.at(values, rows[which], passed[name])
        breakdown = fails["breakdown"]
        return (
            {name: np.where(ran, observed[name], np.nan) for name in (YIELDS if yields else ())}
            | {
                "final": after,
                "regime": regime.astype(float),
                "outcome": outcome.astype(float),
                "pull-in": (pulled_in | (ran & (fails["beyond_membrane"] > 0.0))).astype(float),
                "dielectric breakdown": np.where(np.isnan(breakdown), np.nan, escaped | (breakdown > 0.0)),
                "chaos": np.isin(regime, (Regime.CHAOTIC, Regime.TRANSIENT_CHAOS)).astype(float),
            }
            | {limit: (escaped | (fails[name] > 0.0)).astype(float) for limit, name in _SLACK_AND_LIMIT.items()}
        )

    def violations(self, members: Members, motion: Array, voltages: Sequence[Array]) -> list[dict[str, Array]]:
        """Excesses over the validity of each film (`gelcone.motion.validity.violations`), of the first film also over
        the pull-in of the ``membrane``."""
        excesses = violations(members, motion, voltages)
        if self.membrane is not None and "beyond_membrane" not in excesses[0]:
            excesses[0]["beyond_membrane"] = np.abs(voltages[0]) / self.membrane.voltage(motion[..., 0]) - 1.0
        return excesses

    @staticmethod
    def _transient(members: Members, known: npt.NDArray[np.bool_]) -> Array:
        """Time for which the transient from rest is examined sample by sample, (members,); ``known`` is the mask of the
        drifts that are known to their end."""
        with np.errstate(divide="ignore"):
            of_disc = np.minimum(DECAYS / members.damping_ratio, LONGEST_TRANSIENT)
        of_states = DECAYS * members.time_constant
        of_states = np.where(are_slow(members), np.minimum(of_states, LONGEST_TRANSIENT), of_states)
        return np.where(known, of_disc, np.maximum(of_disc, of_states))

    def _settle(
        self, members: Members, start: Array, classified: bool
    ) -> tuple[Array, npt.NDArray[np.int8], npt.NDArray[np.int8], Search]:
        """Settled states (members, N) of motions from ``start``, their regimes and outcomes, and the search.

        Unless motions are to be ``classified``, one that returns without separating from a nearby one counts as
        periodic.
        """
        flow: dict[str, Any] = {"tolerance": TOLERANCE, "threads": self.threads}
        slow, disc = are_slow(members), transient_of_the_disc(members)
        duration = transient_of(members, None)
        search = Search(members, Starts.at(start, 2), None, **flow)
        followed = np.flatnonzero(slow) if classified else np.arange(members.size)
        search.begin(followed, np.where(slow, np.minimum(duration, LONGEST_WAIT * disc), duration), 1.0)
        starts, attracted = search.starts, search.cycles.attracting
        final, outcome = starts.state[:, 0].copy(), starts.outcome[:, 0].copy()
        regime = np.where(attracted & search.cycles.resting, Regime.REST, Regime.PERIODIC).astype(np.int8)
        regime[outcome != Outcome.OK] = Regime.LEFT_THE_DOMAIN
        unclear = ~attracted & (classified | (starts.period[:, 0] == 0) | np.isfinite(starts.apart))
        waits = np.where(slow, disc, 0.0)  # slow states hardly change, so that a transient of the disc suffices
        options: dict[str, Any]
        for wait in np.unique(waits):
            rows = np.flatnonzero((outcome == Outcome.OK) & unclear & (waits == wait))
            if rows.size:
                origin, options = (final, {"transient": float(wait), "patience": PATIENCE}) if wait else (start, {})
                part = members.take(rows)
                evidence = classify(part, origin[rows], **(options if wait else self._budget(part)), **flow)
                final[rows], regime[rows], outcome[rows] = evidence.final, evidence.regime, evidence.outcome
        return final, regime, outcome, search

    def _budget(self, members: Members) -> dict[str, Any]:
        """The longest time for which motions are followed, as `classify` takes it; empty for its default."""
        if self.patience is not None:
            return {"patience": self.patience}
        longest = np.minimum(patience_of(members, None), CHAOS_TRANSIENTS * transient_of(members, None))
        return {"patience": longest} if self.brief else {}

    def _observe(self, members: Members, states: Array, lasts: Array | float, yields: bool) -> dict[str, Array]:
        """Flags (members,) by name of the assumptions that motions from ``states`` break within `PERIODS` drive periods
        or within the time ``lasts``, whichever is longer; and their yields."""
        keep: Keep = "work" if yields else "states"
        flow: dict[str, Any] = {"tolerance": TOLERANCE, "threads": self.threads}
        observations: dict[str, Array] = {}
        period = members.drive_period
        samples = next_power_of_two(np.maximum(PER_OSCILLATION / (2.0 * np.pi) * period * members.rate, PER_PERIOD))
        turns = PERIODS * next_power_of_two(np.maximum(lasts / (PERIODS * period), 1.0))
        for (of_period, periods), rows in alike(samples, turns.astype(np.int64)):
            size = max(1, BLOCK_SAMPLES // (of_period * periods))
            for first in range(0, rows.size, size):
                block = rows[first : first + size]
                block_members = members.take(block)
                times = period[block][:, None] * (np.arange(of_period * periods + 1) / of_period)
                run = integrate(block_members, states[block], times, keep=keep, **flow)
                observed = self._fails(block_members, run) | (
                    _yields(block_members, run, of_period, **flow) if yields else {}
                )
                for name, values in observed.items():
                    observations.setdefault(name, np.full(members.size, np.nan))[block] = values
        return observations

    def _fails(self, members: Members, run: Trajectories) -> dict[str, Array]:
        """Flags (members,) by name of the assumptions that runs break at any time; NaN where that is unknown."""
        voltages = members.voltages(run.times, run.states)
        fails = {name: np.full(members.size, np.nan) for name in _FAILINGS}
        with np.errstate(all="ignore"):  # of a motion that leaves the domain
            for excesses in self.violations(members, run.states, voltages):
                for name, excess in excesses.items():
                    fails[name] = np.fmax(fails[name], _ever(excess))
        for times, film in zip(np.moveaxis(run.film_times, 1, 0), members.system.films, strict=True):
            for name, places in slack_places(film).items() if film.kinds else ():  # wrinkles bound its use, too
                fails[name] = np.fmax(fails[name], times[:, places].sum(axis=1))
        return fails


def _ever(excess: Array) -> Array:
    """1 for members whose excess (members, samples), NaN after the end of a run, is positive at any time, else 0."""
    known = np.where(np.isnan(excess), -np.inf, excess)
    return 1.0 * (np.fmax(_highest(known), known.max(axis=1)) > 0.0)


def _highest(x: Array) -> Array:
    """Largest value of each row (members, samples), by the parabola through the largest sample and its neighbours."""
    at = np.clip(np.argmax(x, axis=1), 1, x.shape[1] - 2)
    before, here, after = (np.take_along_axis(x, at[:, None] + k, axis=1)[:, 0] for k in (-1, 0, 1))
    curvature = before - 2.0 * here + after
    rise = (before - after) ** 2 / np.where(curvature < 0.0, -8.0 * curvature, np.inf)
    return np.maximum(here + rise, x.max(axis=1))


def _yields(members: Members, run: Trajectories, samples: int, **flow: Any) -> dict[str, Array]:
    """The yields, by `YIELDS`, of runs of ``members`` over whole drive periods of ``samples`` each."""
    assert run.work is not None
    system, begin, lasts = members.system, run.states[:, 0], run.times[:, -1]
    few = run.times[:, min(FEW * samples, run.times.shape[1] - 1)]
    with np.errstate(over="ignore", invalid="ignore"):  # of a motion that leaves the domain
        if system.waveform.pieced:
            path = between_corners(members, begin, 0.0 * few, few, **flow)
        else:
            even = few[:, None] * np.linspace(0.0, 1.0, FEW * max(samples, CLOSE) + 1)[1:]
            path = sampled_evenly(even, integrate(members, begin, even, **flow).states, begin, 0.0 * few, few)
        apparent, jumps = apparent_power(members, path), lost_in_jumps(members, begin, lasts, **flow)
        peaks = {
            name: np.maximum(of(members, run.times, run.states).max(axis=1), largest(members, path, of, **flow))
            for name, of in _PEAKS.items()
        }
    return {
        "stroke": np.subtract(*extent(members, run.times, run.states, **flow)[::-1]),
        "power": (dissipated_energy(system, run.work)[:, -1] + jumps) / lasts,
        "damper_power": run.work[:, -1, system.causes.index("damper")] / lasts,
        "heating": heat_of(system, run.work)[:, -1] / lasts,
        "apparent_power": np.where(jumps > 0.0, np.inf, apparent),
        **peaks,
    }


_PEAKS: Mapping[str, Value] = {"peak_charge": charge_of, "field": field_of}
FEW = 4
"""Drive periods over which apparent powers, and largest values between samples, are computed."""
CLOSE = 64
"""Fewest samples of a drive period for apparent powers, since the current has kinks where a film begins to be slack."""
YIELDS = ("stroke", "power", "damper_power", "apparent_power", "peak_charge", "field", "heating")
_SLACK_AND_LIMIT = {"hoop slack": "hoop_slack", "meridional slack": "meridional_slack", "stretch limit": "near_limit"}
_FAILINGS = (*_SLACK_AND_LIMIT.values(), "breakdown", "beyond_membrane")

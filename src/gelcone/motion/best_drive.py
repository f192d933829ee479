"""Best drive within the operating envelope: the largest safe stroke, work, speed or power."""

from __future__ import annotations

from dataclasses import replace
from functools import partial
from typing import TYPE_CHECKING, Any, Literal, NamedTuple, get_args

import numpy as np

from gelcone import dataset
from gelcone.codes import Outcome, Regime
from gelcone.devices.analysis import analysis, check_model, check_one, dimensionless, plain
from gelcone.devices.device import Device
from gelcone.devices.si import device_attributes
from gelcone.errors import InputError, check_name
from gelcone.motion.coexisting import coexisting
from gelcone.motion.envelope import MARGIN, check_window, plane_of, window_of
from gelcone.motion.plane import NUDGE, Plane
from gelcone.motion.proportion import held_at_peak
from gelcone.motion.regime import regime
from gelcone.motion.response import simulate
from gelcone.motion.settle import check_budgets
from gelcone.motion.start import start_states
from gelcone.motion.static_limits import static_limits_of
from gelcone.motion.swing import settled_swing
from gelcone.physics.model import ConeModel
from gelcone.physics.statics import rest_displacement, rest_displacements
from gelcone.progress import Progress, advance, weighted
from gelcone.quantity import Array, Frequency, Time

if TYPE_CHECKING:
    import xarray as xr

Largest = Literal["stroke", "work", "speed", "power"]
COARSE, FINE = 25, 9
"""Numbers of drive frequencies in a given range, and around the best of them."""
CLOSEST = 33
"""Frequencies between the neighbours of the best one at which the motions at the window's edge are compared."""
PEAKS = (0.3, 1.4, 12)
"""Lowest, highest and number of peak voltages around the best drive, over the limit there."""
STEP = 0.01
"""Relative change of a field for its sensitivity."""
JUMP = 0.5
"""Difference of the logarithms of two strokes that are no longer those of one motion."""
DETUNED = 0.01
"""Relative error of the drive frequency at which half of the margin is left."""
NOT_CHANGED = ("release_height", "release_velocity", "dielectric_strength", "material.dielectric_strength")
"""Fields without effect on the settled motion."""


class Candidates(NamedTuple):
    """Drives inside the window of an envelope and their yields, arrays (drives,)."""

    frequency: Array
    peak: Array
    periodic: Array
    edge: Array
    stroke: Array
    power: Array
    supplied: Array
    apparent: Array

    def value(self, largest: str, damping_ratio: float) -> Array:
        """The quantity to maximise; NaN for a motion that is not periodic."""
        with np.errstate(divide="ignore", invalid="ignore"):
            values = {
                "stroke": self.stroke,
                "power": self.power,
                "work": self.power * 2.0 * np.pi / self.frequency,
                "speed": np.sqrt(self.power / (2.0 * damping_ratio)),
            }[largest]
        return np.where(self.periodic > 0.0, values, np.nan)


@analysis(
    takes="device",
    answers="drive",
    single=True,
    examples=(
        "biased-pump --out results",
        'mine.toml --largest work --lowest-frequency "5 Hz" --highest-frequency 20Hz',
    ),
)
def drive(
    model: ConeModel | Device,
    *,
    largest: str = "stroke",
    lowest_frequency: Frequency | None = None,
    highest_frequency: Frequency | None = None,
    margin: float = MARGIN,
    patience: Time | None = None,
    threads: int | None = None,
    progress: Progress = None,
) -> xr.Dataset:
    """Find the drive with the largest stroke, work, speed or power that is safely below all limits.

    Parameters
    ----------
    model : a single model, or a device; its drive gives the proportion of amplitude to offset.
    largest : the quantity to maximise: ``"stroke"`` (default), ``"work"`` in a drive period, ``"speed"`` (root mean
        square) or ``"power"`` (mean); work and power are those on the damper or a load.
    lowest_frequency, highest_frequency : ends of the range of drive frequencies, both or neither (a range is
        searched faster than the default, which takes a minute or two of a processor). Default a tenth of the natural
        frequency and three times that.
    margin : share of the lowest limit by which the voltage stays below it. Half of it is left if the frequency is off
        by one per cent. Default 0.2.
    patience : longest time for which a motion is followed to see on what it settles. Default 32 transients of `regime`,
        and at most its patience: chaos is seen, but not whether it ends.
    threads : worker threads; default one a core. Does not change a bit of the result.
    progress : called with the share of the work just done (the shares add up to 1).

    Returns
    -------
    Dataset with ``drive_frequency``, ``peak_voltage``, ``voltage`` and ``voltage_bias`` (amplitude and offset) of the
    best drive, and of the motion that it settles to from rest: ``stroke``, ``work``, ``speed``, ``power`` on damper or
    load, ``supplied_power`` of the source and ``apparent_power``. Over ``detuning``, one per cent either way,
    ``detuned_stroke`` is the stroke at a frequency that is off by it: next to a jump it is another one.
    ``limit_voltage`` is the lowest limit of `gelcone.envelope` there, whose name is the attribute ``limit``.
    ``frequency_low`` and ``frequency_high`` are the examined frequencies between which the same peak voltage stays
    below all limits. ``kick`` is a sudden change of velocity that leads to another motion (infinity: none of those
    tried). ``undecided_motions`` is the number of examined motions that had neither settled nor shown chaos within the
    ``patience``; none of them is taken. Over ``frequency``: ``window_peak``, the window's edge, and ``window_value``,
    the quantity to maximise there. Over ``time``: ``displacement`` and ``drive_voltage`` of two drive periods. Over
    ``field``: ``sensitivity``, the relative change of the stroke over that of a field at this drive (NaN if the motion
    ends, or another one takes its place, within one per cent).

    Raises
    ------
    InputError : for an ensemble, what `envelope` refuses, an unknown ``largest``, frequencies that do not increase, or
        if no drive within the window moves the disc periodically.

    Examples
    --------
    >>> import gelcone
    >>> drive = {"voltage": 0.3, "voltage_bias": 0.6}
    >>> model = gelcone.ConeModel(**drive, rest_height=0.8, hoop_prestretch=1.4, damping_ratio=0.3)
    >>> best = gelcone.drive(model, lowest_frequency=0.8, highest_frequency=0.805)
    >>> best.attrs["limit"], round(best.peak_voltage.item(), 4), best.drive_frequency.item()
    ('meridional slack', 0.7188, 0.805)
    """
    check_name("quantity to be largest", largest, get_args(Largest))
    device = model if isinstance(model, Device) else None
    cone = model.to_model() if isinstance(model, Device) else model
    check_model(cone, "drive")
    check_one(cone, "drive")
    ends: dict[str, Any] = {"lowest_frequency": lowest_frequency, "highest_frequency": highest_frequency}
    given = [name for name, value in ends.items() if value is not None]
    if len(given) == 1:
        raise InputError(f"{given[0]}: is given alone; give both ends of the frequencies, or neither")
    if device is not None:
        ends = dimensionless(dict.fromkeys(ends, "frequency"), ends, device.scales)
        patience = dimensionless({"patience": "time"}, {"patience": patience}, device.scales)["patience"]
    if given and not 0.0 < ends["lowest_frequency"] < ends["highest_frequency"]:
        raise InputError(
            f"lowest_frequency = {lowest_frequency}: must be greater than 0 and below the highest frequency, "
            f"{highest_frequency}{'' if device is None else ' (in Hz, if without unit)'}"
        )
    check_window(cone, margin)
    check_budgets(patience=patience)
    plane, zeta = replace(plane_of(cone, threads), patience=patience, brief=True), float(cone.damping_ratio)
    envelopes = _searches(plane, largest, margin, _range(**ends), weighted(progress, 0.95))
    best = _best(largest, zeta, margin, *envelopes)
    peak, omega = float(best.peak), float(best.frequency)
    drives = plane.shape.at(peak)
    chosen = cone.replace(drive_frequency=omega, **drives)
    names, change = _sensitivities(chosen, device, threads)
    detunings = DETUNED * np.array([-1.0, 1.0])
    detuned = plane.examine(omega * (1.0 + detunings), np.full(2, peak))
    limit, bound = _limit(omega, *envelopes)
    band = _safe_band(omega, peak, *envelopes)
    curve = _edge(largest, zeta, *envelopes)
    motion = settled_periods(chosen, threads)
    variables: dict[str, dataset.Variable] = {
        "drive_frequency": ((), omega, "frequency of the best drive", "frequency"),
        "peak_voltage": ((), peak, "peak voltage of the best drive", "voltage"),
        "voltage": ((), drives["voltage"], "amplitude of the best drive", "voltage"),
        "voltage_bias": ((), drives["voltage_bias"], "offset of the best drive", "voltage"),
        "stroke": ((), best.stroke, "stroke, peak to peak", "length"),
        "work": ((), best.value("work", zeta), "work on damper or load a drive period", "energy"),
        "speed": ((), best.value("speed", zeta), "root mean square speed", "velocity"),
        "power": ((), best.power, "mean power to damper or load", "power"),
        "supplied_power": ((), best.supplied, "mean power that the voltage source supplies", "power"),
        "apparent_power": ((), best.apparent, "root mean square voltage times current", "apparent power"),
        "detuned_stroke": (
            ("detuning",),
            np.where(detuned["outcome"] == Outcome.OK, detuned["stroke"], np.nan),
            "stroke at the same voltage and a frequency that is off by a share",
            dataset.absent("length", nan="the motion ends"),
        ),
        "limit_voltage": ((), bound, "peak voltage of the lowest limit there", dataset.absent("voltage")),
        "frequency_low": ((), band[0], "lowest frequency at which this voltage is below all limits", "frequency"),
        "frequency_high": ((), band[1], "highest frequency at which this voltage is below all limits", "frequency"),
        "kick": ((), _kick(plane, best), "kick that leads to another motion", dataset.absent("velocity", "unknown")),
        "undecided_motions": ((), _undecided(*envelopes), "examined motions that had not settled in time", "count"),
        "window_peak": (("frequency",), curve[1], "highest recommended peak voltage", "voltage"),
        "window_value": (("frequency",), curve[2], f"{largest} there", _QUANTITY[largest]),
        "displacement": (("time",), motion["displacement"].values, "displacement", "length"),
        "drive_voltage": (("time",), motion["drive_voltage"].values, "voltage of the drive", "voltage"),
        "sensitivity": (("field",), change, "relative change of the stroke over that of the field", _SHARE),
    }
    result = dataset.label(
        cone,
        variables,
        coords={
            "frequency": (("frequency",), curve[0], "drive frequency", "frequency"),
            "time": (("time",), motion["time"].values, "time", "time"),
            "detuning": (("detuning",), detunings, "share by which the frequency is off", "share"),
            "field": (("field",), np.array(names), "field of the device, or parameter of the model", "code"),
        },
        outcome=np.zeros(()),
        options={"largest": largest, **ends, "margin": margin, "patience": patience},
        title="best drive",
    )
    about = {} if device is None else device_attributes(device)
    advance(progress, 0.05)
    return result.assign_attrs(limit=limit, largest=largest, **about)


_QUANTITY = {"stroke": "length", "work": "energy", "speed": "velocity", "power": "power"}
_YIELDS = ("stroke", "damper_power", "power", "apparent_power")
"""Variables of an envelope in the order of the yields of `Candidates`."""
_SHARE = dataset.absent("share", nan="the motion ends, is no longer periodic or is another one")


def _searches(
    plane: Plane, largest: str, margin: float, frequencies: Array | None, progress: Progress
) -> tuple[xr.Dataset, ...]:
    """Envelopes at the ``frequencies``, around the best drive in that one, and at the best frequency in both."""
    window = partial(window_of, plane, static_limits_of(plane), margin=margin, to_first=True)
    zeta = float(plane.model.damping_ratio)
    wide = window(frequencies=frequencies, progress=weighted(progress, 0.63))
    around = _around(wide, float(_best(largest, zeta, margin, wide).frequency))
    near = window(frequencies=around["frequencies"], peaks=around["peaks"], progress=weighted(progress, 0.27))
    best = float(_best(largest, zeta, margin, wide, near).frequency)
    closest = _closest(plane, largest, zeta, best, wide, near)
    return wide, near, window(frequencies=closest, peaks=around["peaks"], progress=weighted(progress, 0.1))


def _undecided(*envelopes: xr.Dataset) -> int:
    """The number of examined motions that had neither settled nor shown chaos."""
    return sum(int((one["regime"].values == Regime.TRANSIENT).sum()) for one in envelopes)


def candidates(*envelopes: xr.Dataset) -> Candidates:
    """All drives inside the windows of envelopes."""
    return Candidates(*(np.concatenate(parts) for parts in zip(*map(_inside, envelopes), strict=True)))


def _inside(found: xr.Dataset) -> Candidates:
    """The drives inside one window: those at its edge, and those examined below."""
    peaks, edges, frequency = (found[n].values for n in ("peak_voltage", "recommended_peak", "drive_frequency"))
    below = np.nonzero(peaks <= edges[:, None])
    periodic = (found["regime"].values == Regime.PERIODIC) & (found["outcome"].values == 0)
    return Candidates(
        np.concatenate([frequency, frequency[below[0]]]),
        np.concatenate([edges, peaks[below[1]]]),
        1.0 * np.concatenate([found["window_regime"].values == Regime.PERIODIC, periodic[below]]),
        np.repeat([1.0, 0.0], [edges.size, below[0].size]),
        *(np.concatenate([found[f"window_{n}"].values, found[f"driven_{n}"].values[below]]) for n in _YIELDS),
    )


def _best(largest: str, damping_ratio: float, margin: float, *envelopes: xr.Dataset) -> Candidates:
    """The drive with the largest value among those that keep half of the margin at slightly different frequencies."""
    motions = candidates(*envelopes)
    safe = motions.peak <= (1.0 - margin / 2.0) * _detuned(motions.frequency, *envelopes)
    values = np.where(safe, motions.value(largest, damping_ratio), np.nan)
    if not (values > 0.0).any():
        raise InputError(
            "drive: no drive within the window moves the disc periodically; see gelcone envelope, lower the margin or "
            "give the device an offset or an initial height"
        )
    at = int(np.nanargmax(values))
    return Candidates(*(column[at] for column in motions))


def _detuned(frequency: Array, *envelopes: xr.Dataset) -> Array:
    """The lowest limit at frequencies within `DETUNED` of each given one."""
    known, limits, _ = _rows(*envelopes)
    low, high = frequency * (1.0 - DETUNED), frequency * (1.0 + DETUNED)
    with np.errstate(divide="ignore"):
        ends = [1.0 / np.interp(one, known, 1.0 / limits) for one in (low, high)]
    between = (known >= low[:, None]) & (known <= high[:, None])
    return np.minimum.reduce([*ends, np.where(between, limits, np.inf).min(axis=-1)])


def _range(lowest_frequency: float | None, highest_frequency: float | None) -> Array | None:
    """Frequencies of a range; None for those of the envelope."""
    if lowest_frequency is None or highest_frequency is None:
        return None
    return np.geomspace(lowest_frequency, highest_frequency, COARSE)


def _around(wide: xr.Dataset, omega: float) -> dict[str, Array]:
    """Frequencies between the neighbours of ``omega``, and peak voltages around its limit."""
    known = wide["drive_frequency"].values
    at = int(np.argmin(np.abs(known - omega)))
    below, above = known[max(at - 1, 0)], known[min(at + 1, len(known) - 1)]
    _, bound = _limit(omega, wide)
    top = bound if np.isfinite(bound) else float(wide["peak_voltage"][-1])
    return {"frequencies": np.geomspace(below, above, FINE), "peaks": top * np.linspace(*PEAKS)}


def _rows(*envelopes: xr.Dataset) -> tuple[Array, Array, list[str]]:
    """Examined frequencies in rising order, with the lowest limit of each and its name: "none" and the highest examined
    peak voltage if no limit is met."""
    limits: dict[float, tuple[float, str]] = {}
    for envelope in envelopes:
        static = envelope["static_limit_voltage"].values
        constant = float(np.nanmin(static, initial=np.inf))
        constant_name = str(envelope["static_limit"].values[int(np.nanargmin(static))]) if np.isfinite(constant) else ""
        way = "of the drive held at its peak" if held_at_peak(envelope) else "at a constant voltage"
        for k, omega in enumerate(envelope["drive_frequency"].values):
            row = int(envelope["first_limit"][k])
            low = float(envelope["peak_voltage"][-1] if row < 0 else envelope["limit_low"][row, k])
            name = "none" if row < 0 else str(envelope["driven_limit"].values[row])
            limits[float(omega)] = (low, name) if low <= constant else (constant, f"{constant_name} {way}")
    order = sorted(limits)
    return np.array(order), np.array([limits[omega][0] for omega in order]), [limits[omega][1] for omega in order]


def _closest(plane: Plane, largest: str, damping_ratio: float, omega: float, *envelopes: xr.Dataset) -> Array:
    """The frequency of the largest value along the edge between the neighbours of ``omega``, and those that are off by
    `DETUNED`; the edge is interpolated."""
    omegas, edge, _ = _edge(largest, damping_ratio, *envelopes)
    at = int(np.argmin(np.abs(omegas - omega)))
    tried = np.geomspace(omegas[max(at - 1, 0)], omegas[min(at + 1, len(omegas) - 1)], CLOSEST)
    with np.errstate(divide="ignore"):
        peaks = 1.0 / np.interp(tried, omegas, 1.0 / edge)
    examined = plane.examine(tried, peaks)
    periodic = examined["regime"] == Regime.PERIODIC
    motions = Candidates(tried, peaks, periodic, np.ones(CLOSEST), *(examined[name] for name in _YIELDS))
    values = motions.value(largest, damping_ratio)
    best = np.exp(_vertex(np.log(tried), values)) if (values > 0.0).any() else omega
    return np.unique(np.clip(best * (1.0 + DETUNED * np.array([-1.0, 0.0, 1.0])), omegas[0], omegas[-1]))


def _vertex(places: Array, values: Array) -> float:
    """The place of the largest value, moved to the vertex of the parabola through its neighbours."""
    k = int(np.nanargmax(values))
    if not 0 < k < len(places) - 1:
        return float(places[k])
    before, here, after = values[k - 1 : k + 2]
    bend = before - 2.0 * here + after
    return float(places[k] + (0.5 * (before - after) / bend * (places[k + 1] - places[k]) if bend < 0.0 else 0.0))


def _limit(omega: float, *envelopes: xr.Dataset) -> tuple[str, float]:
    """Name and peak voltage of the lowest limit at a frequency; infinite if none is met."""
    known, limits, names = _rows(*envelopes)
    at = int(np.argmin(np.abs(known - omega)))
    return names[at], np.inf if names[at] == "none" else float(limits[at])


def _safe_band(omega: float, peak: float, *envelopes: xr.Dataset) -> tuple[float, float]:
    """Ends of the band of examined frequencies around ``omega`` in which a peak voltage is below all limits."""
    known, limits, _ = _rows(*envelopes)
    at = int(np.argmin(np.abs(known - omega)))
    below = np.flatnonzero(limits[:at] <= peak)
    above = np.flatnonzero(limits[at + 1 :] <= peak)
    first = int(below[-1]) + 1 if below.size else 0
    last = at + int(above[0]) if above.size else len(known) - 1
    return float(known[first]), float(known[last])


def _kick(plane: Plane, best: Candidates) -> float:
    """The kick that leads away from the best drive; NaN below the window's edge, where none is tried."""
    if not best.edge:
        return float("nan")
    members = plane.at(np.array([best.frequency]), np.array([best.peak])).members()
    motions = coexisting(members, members.start_states((plane.rest + NUDGE, 0.0)), threads=plane.threads)
    return float(motions["kick_high"][0])


def _edge(largest: str, damping_ratio: float, *envelopes: xr.Dataset) -> tuple[Array, Array, Array]:
    """Frequency, peak voltage and value along the edge of the window."""
    motions = candidates(*envelopes)
    rows = np.stack([motions.frequency, motions.peak, motions.value(largest, damping_ratio)], axis=1)[
        motions.edge > 0.0
    ]
    table = np.array(sorted({row[0]: row for row in rows.tolist()}.values()))
    return table[:, 0], table[:, 1], table[:, 2]


def settled_periods(chosen: ConeModel, threads: int | None) -> xr.Dataset:
    """Two drive periods of the settled motion."""
    start = (rest_displacement(chosen) + NUDGE, 0.0)
    points = plain(regime)(chosen, start, threads=threads)["section"].values
    known = points[np.isfinite(points).all(axis=-1)]
    return plain(simulate)(chosen, known[-1], periods=2.0, threads=threads)


def _sensitivities(chosen: ConeModel, device: Device | None, threads: int | None) -> tuple[list[str], Array]:
    """Fields of a device or parameters of a model, and the slope d log(stroke) / d log(field) of each."""
    if device is None:
        numbers = {n: v for n, v in chosen.parameters().items() if isinstance(v, float) and _counts(v)}
        numbers.pop("dielectric_strength", None)
    else:
        scales = device.scales
        driven = device.replace_quietly(
            voltage_amplitude=float(chosen.voltage) * scales.voltage,
            voltage_offset=float(chosen.voltage_bias) * scales.voltage,
            frequency=float(chosen.drive_frequency) * scales.frequency,
        )
        fields = driven.swept_fields()
        numbers = {
            n: v for n in fields if n not in NOT_CHANGED and isinstance(v := driven.get(n), float) and _counts(v)
        }
    names = list(numbers)
    spread = {name: np.full(2 * len(names), value) for name, value in numbers.items()}
    for k, name in enumerate(names):
        spread[name][2 * k : 2 * k + 2] *= (1.0 + STEP, 1.0 - STEP)
    points = None if device is None else driven.replace_quietly(spread)
    members = chosen.replace(**spread) if points is None else points.to_model()
    starts = np.stack([rest_displacements(members) + NUDGE, np.zeros(2 * len(names))], axis=-1)
    swings = settled_swing(members.members(), start_states(members, starts), only_extent=True, threads=threads)
    length = 1.0 if points is None else points.scales.length
    strokes = np.where(swings.forcing_periods > 0, 2.0 * swings.amplitude, np.nan) * length
    with np.errstate(divide="ignore", invalid="ignore"):
        ratio = np.log(strokes[0::2] / strokes[1::2]) / np.log((1.0 + STEP) / (1.0 - STEP))
        jumps = np.abs(np.log(strokes[0::2] / strokes[1::2])) > JUMP
    return names, np.where(np.isfinite(ratio) & ~jumps, ratio, np.nan)


def _counts(value: float) -> bool:
    """True if a number can be changed by a share of itself."""
    return bool(np.isfinite(value) and value != 0.0)

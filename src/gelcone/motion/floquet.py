"""Stability of rest under the drive: Floquet multipliers of x = 0, the onset voltage and the instability tongues.

Small motions about the flat film obey a damped Hill equation, x'' + 2 zeta x' + (k - v(tau)^2) x = 0 with the
small-signal stiffness k. Over one forcing period T a deviation is mapped linearly; the eigenvalues of the map are
the Floquet multipliers, and rest is stable while both lie inside the unit circle. Their product is exp(-2 zeta T), so
that they leave the circle along the real axis: at +1 where the trace of the map passes 1 + exp(-2 zeta T) (a motion
with the period of the force grows), at -1 where it passes the negative of that (a motion with twice that period).
Magnus and Winkler, Hill's Equation (1966); Nayfeh and Mook, Nonlinear Oscillations (1979), chapter 5.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from gelcone import dataset
from gelcone.codes import Code
from gelcone.devices.analysis import analysis, check_one, for_devices
from gelcone.errors import InputError
from gelcone.motion.flow import DEFAULT_TOLERANCE
from gelcone.motion.monodromy import STILL_STABLE, Monodromy, monodromy
from gelcone.motion.settle import next_power_of_two
from gelcone.motion.start import start_states
from gelcone.motion.static_bifurcations import PITCHFORK_ABSENT, pitchfork_voltages
from gelcone.motion.static_results import padded
from gelcone.physics.drive import VOLTAGE
from gelcone.physics.members import Ensemble, Members
from gelcone.physics.model import ConeModel
from gelcone.physics.statics import every_balance
from gelcone.progress import Counted, Progress, advance, weighted
from gelcone.quantity import Array, Frequencies, Voltage, Voltages
from gelcone.register.analysis import Axis

if TYPE_CHECKING:
    import xarray as xr

BEFORE_PULL_IN = 1.0 - 1e-6
"""Share of the voltage at which the flat film pulls in up to which rest is examined."""
FEWEST_STEPS, MOST_STEPS = 256, 4096
STEPS_PER_LOBE = 12
NEAR_ONSET = -0.2
"""Margin below which a peak is not followed up, since its true height is lower: 5 points per lobe come close to it."""
SECTIONS = 8
"""Points inside a bracket that are computed at once, one per lane of the integrator."""
ROUNDS = 6
_ONSET = dataset.absent("voltage", nan="not reached")
PEAK_ROUNDS = 4


class Onset(Code):
    """The multiplier that leaves the unit circle where rest loses its stability.

    Examples
    --------
    >>> import gelcone
    >>> found = gelcone.onset_voltage(gelcone.ConeModel(spring_stiffness=0.5, drive_frequency=0.5))
    >>> gelcone.Onset(found.onset_kind.item())
    <Onset.MINUS_ONE: 2>
    """

    NONE = 0, "rest stays stable in the searched interval"
    PLUS_ONE = 1, "multiplier +1: a motion with the period of one forcing period grows"
    MINUS_ONE = 2, "multiplier -1: a motion with the period of two forcing periods grows (period doubling)"
    AT_START = 3, "rest is unstable without voltage already"


@for_devices
def floquet_multipliers(
    model: Ensemble, *, tolerance: float = DEFAULT_TOLERANCE, threads: int | None = None, progress: Progress = None
) -> xr.Dataset:
    """Compute the Floquet multipliers of rest over one forcing period.

    Parameters
    ----------
    model : one actuator or an ensemble, with ``rest_height`` 0 (or no spring).
    tolerance : relative error of one step. Default 1e-15.
    threads : worker threads; default one a core. Does not change a bit of the result.
    progress : called with the share of the work just done (the shares add up to 1).

    Returns
    -------
    Dataset over the ensemble's dims: ``multiplier_real`` and ``multiplier_imag`` over ``multiplier`` (2), the larger
    modulus first, infinite where they overflow; ``log_modulus`` of each, which does not; ``growth_rate``, that of the
    first per unit time (positive: rest is unstable); ``spectral_radius``, the larger modulus; ``margin`` =
    (|trace| - 1 - p)/(|trace| + 1 + p) with the product p of the multipliers, which passes 0 where the stability
    changes; ``forcing_period`` T; ``product_error``, how far the determinant of the computed map departs from
    exp(-2 zeta T), relatively. The multipliers use this exact product.

    Raises
    ------
    InputError : when x = 0 is not a solution, or lies beyond the stretch limit for all members.

    Examples
    --------
    >>> import gelcone
    >>> model = gelcone.ConeModel(spring_stiffness=0.5, drive_frequency=0.5, voltage=[0.3, 0.6])
    >>> found = gelcone.floquet_multipliers(model)
    >>> found.spectral_radius.values.round(4).tolist()
    [0.7304, 1.0035]
    """
    _check_rest(model)
    maps = monodromy(model.members(), {"tolerance": tolerance, "threads": threads}, progress)
    real, imag, log_modulus = maps.multipliers()
    with np.errstate(over="ignore"):
        radius = np.exp(log_modulus[:, 0])
    pair = ("multiplier",)
    return dataset.label(
        model,
        {
            "multiplier_real": (pair, real, "real part of the Floquet multiplier of rest", "multiplier"),
            "multiplier_imag": (pair, imag, "imaginary part of the Floquet multiplier of rest", "multiplier"),
            "log_modulus": (pair, log_modulus, "natural logarithm of the multiplier's modulus", "multiplier"),
            "growth_rate": ((), log_modulus[:, 0] / maps.repeat, *_GROWTH),
            "spectral_radius": ((), radius, *_RADIUS),
            "margin": ((), maps.margin(), *_MARGIN),
            "forcing_period": ((), maps.repeat, "forcing period", "time"),
            "product_error": ((), maps.product_error, "relative error of the product of the multipliers", "error"),
        },
        outcome=maps.outcome,
        options={"tolerance": tolerance},
        title="Floquet multipliers of rest",
    )


_GROWTH = ("growth rate of deviations from rest", "rate")
_RADIUS = ("larger modulus of the Floquet multipliers of rest", "multiplier")
_MARGIN = ("instability margin of rest, positive where it is unstable", "margin")


@for_devices
def onset_voltage(
    model: Ensemble,
    *,
    highest: Voltages | None = None,
    steps: int | None = None,
    tolerance: float = DEFAULT_TOLERANCE,
    threads: int | None = None,
    progress: Progress = None,
) -> xr.Dataset:
    """Compute the smallest voltage amplitude at which rest loses its stability under the drive.

    The amplitudes are scanned in even steps, peaks of the margin between them are followed up, and the first crossing
    is narrowed down. A tongue that is narrower than about a hundredth of a step can be missed; without
    damping there are tongues of any narrowness.

    Parameters
    ----------
    model : one actuator or an ensemble, with ``rest_height`` 0 (or no spring); its ``voltage`` plays no part.
    highest : amplitudes from 0 to this one are searched; a number or one a member. Default three times the static
        pitchfork voltage of each member (3 where it has none), but not up to where its flat film pulls in,
        the bias included.
    steps : of the scan, at least 2. Default 12 for each half oscillation of the free disc in a forcing period, from 256
        to 4096 and a power of 2.
    tolerance : relative error of one step of the integrator. Default 1e-15.
    threads : worker threads; default one a core. Does not change a bit of the result.
    progress : called with the share of the work just done (the shares add up to 1).

    Returns
    -------
    Dataset over the ensemble's dims: ``onset_voltage``, NaN where rest stays stable; ``onset_kind``, an `Onset`;
    ``onset_error``, the width of the last bracket (the onset is interpolated inside it, to about 1e-12); ``searched``,
    the interval of amplitudes (``bound``, 2).

    Raises
    ------
    InputError : when x = 0 is not a solution, or lies beyond the stretch limit for all members; for a ``highest`` that
        is not positive, or fewer than 2 steps.

    Examples
    --------
    >>> import gelcone
    >>> found = gelcone.onset_voltage(gelcone.ConeModel(spring_stiffness=0.5, drive_frequency=0.5))
    >>> round(found.onset_voltage.item(), 5), gelcone.Onset(found.onset_kind.item()).name
    (0.59953, 'MINUS_ONE')
    """
    _check_rest(model)
    members = model.members()
    ends = _search_ends(model, highest)
    counts = _scan_steps(members, steps)
    options = {"tolerance": tolerance, "threads": threads}
    onsets = np.full((3, model.size), np.nan)
    outcome = np.zeros(model.size, dtype=np.int8)
    for count in np.unique(counts):
        rows = np.flatnonzero(counts == count)
        share = weighted(progress, rows.size * int(count) / float(counts.sum()))
        onsets[:, rows], outcome[rows] = _onsets(members.take(rows), ends[rows], int(count), options, share)
    return dataset.label(
        model,
        {
            "onset_voltage": ((), onsets[0], "voltage amplitude at which the flat film loses stability", _ONSET),
            "onset_kind": ((), onsets[1].astype(np.int8), "how rest loses stability", Onset),
            "onset_error": ((), onsets[2], "width to which the onset is known", _ONSET),
            "searched": (("bound",), np.stack([0.0 * ends, ends], axis=1), "voltage amplitudes searched", "voltage"),
        },
        outcome=outcome,
        options={"steps": steps, "tolerance": tolerance},
        title="onset voltage of rest",
    )


@analysis(
    axes={
        "frequencies": Axis("drive_frequency", "frequency", default=(0.2, 3.0, 120)),
        "voltages": Axis("voltage", "voltage_amplitude", default=(0.0, 2.0, 100)),
    },
    answers="stability",
    single=True,
    examples=(
        "--over drive_frequency=0.2:3:120 --over voltage=0:2:100 --out results",
        "--set damping_ratio=0.01 --set drive_frequency=0.1 --json",
    ),
)
def tongues(
    model: ConeModel,
    frequencies: Frequencies,
    voltages: Voltages,
    *,
    highest: Voltage | None = None,
    tolerance: float = DEFAULT_TOLERANCE,
    threads: int | None = None,
    progress: Progress = None,
) -> xr.Dataset:
    """Compute where rest is unstable over drive frequency and voltage amplitude: the instability tongues.

    Parameters
    ----------
    model : one actuator, with ``rest_height`` 0 (or no spring); its voltage plays no part, except for the bias.
    frequencies : increasing drive frequencies, at least two.
    voltages : increasing voltage amplitudes, at least two.
    highest : voltage amplitude up to which the onset at the model's frequency is searched. Default three times the
        static pitchfork voltage.
    tolerance : relative error of one integration step. Default 1e-15.
    threads : worker threads; default one a core. Does not change a bit of the result.
    progress : called with the share of the work just done (the shares add up to 1).

    Returns
    -------
    Dataset over ``drive_frequency`` and ``voltage``: ``growth_rate``, ``spectral_radius`` and ``margin`` as in
    `floquet_multipliers`, and ``doubles``, whether the larger multiplier is negative; over the frequency,
    ``onset_voltage`` and ``onset_kind`` up to the highest voltage, and ``boundary_voltage`` (``boundary``, NaN-padded):
    all voltages at which the stability changes, each between two neighbours of the grid and narrowed down. At
    ``pitchfork_amplitude`` the peak of the voltage reaches the static pitchfork. ``operating_onset_voltage``,
    ``operating_onset_kind`` and ``operating_searched`` are those of `onset_voltage` at the model's frequency;
    ``outcome`` is that of a place.

    Raises
    ------
    InputError : as `onset_voltage`; for an ensemble; for frequencies or voltages that do not increase.

    Examples
    --------
    >>> import gelcone
    >>> model = gelcone.ConeModel(spring_stiffness=0.5, drive_frequency=0.5)
    >>> found = gelcone.tongues(model, [0.45, 0.5], [0.3, 0.6])
    >>> (found.growth_rate.values > 0.0).tolist(), round(float(found.onset_voltage[1]), 5)
    ([[False, False], [False, True]], 0.59953)
    """
    check_one(model, "tongues")
    omega, volts = (_axis(n, v) for n, v in (("drive_frequency", frequencies), ("voltage", voltages)))
    _check_rest(model)
    options = {"tolerance": tolerance, "threads": threads}
    operating = onset_voltage(model, highest=highest, tolerance=tolerance, threads=threads)
    rows = model.replace(drive_frequency=omega)
    grid = model.replace(drive_frequency=omega[:, None], voltage=volts).members()
    maps = monodromy(grid, options, weighted(progress, 0.4))
    shape = (omega.size, volts.size)
    margin, log_modulus = maps.margin().reshape(shape), maps.multipliers()[2][:, 0].reshape(shape)
    boundary = _boundaries(rows.members(), volts, margin, options, weighted(progress, 0.2))
    onset = onset_voltage(
        rows, highest=volts[-1], tolerance=tolerance, threads=threads, progress=weighted(progress, 0.4)
    )
    static = model.system.waveform.amplitude_at(model.own_numbers, pitchfork_voltages(every_balance(model))[0])
    plane, line = ("drive_frequency", "voltage"), ("drive_frequency",)
    with np.errstate(over="ignore"):
        radius = np.exp(log_modulus)
    result = dataset.label(
        model,
        {
            "growth_rate": (plane, log_modulus / maps.repeat.reshape(shape), *_GROWTH),
            "spectral_radius": (plane, radius, *_RADIUS),
            "margin": (plane, margin, *_MARGIN),
            "boundary_voltage": ((*line, "boundary"), boundary, "voltages at which the stability changes", "voltage"),
            "doubles": (plane, maps.trace.reshape(shape) < 0.0, "whether the larger multiplier is negative", "flag"),
            "pitchfork_amplitude": (
                (),
                static,
                "amplitude whose peak voltage is at the static pitchfork",
                PITCHFORK_ABSENT,
            ),
        },
        coords={
            "drive_frequency": (line, omega, "drive frequency", "frequency"),
            "voltage": (("voltage",), volts, "voltage amplitude", "voltage"),
        },
        options={"highest": highest, "tolerance": tolerance},
        title="instability tongues of rest",
    )
    for name in ("onset_voltage", "onset_kind"):
        result[name] = (line, onset[name].values, onset[name].attrs)
    result["outcome"] = dataset.outcome_array(maps.outcome.reshape(shape), plane)
    return result.assign({f"operating_{name}": operating[name] for name in ("onset_voltage", "onset_kind", "searched")})


def _check_rest(model: Ensemble) -> None:
    start_states(model, (0.0, 0.0))
    members = model.members()
    if members.symmetric.all():
        return
    values = members.take([int(np.argmin(members.symmetric))]).values
    moved = [name for name in ("rest_height", "second_flat_height") if values.get(name, [0.0])[0]]
    raise InputError(
        f"{moved[0]} = {float(values[moved[0]][0]):g}: must be 0, or the disc does not rest at x = 0 and has no "
        "Floquet multipliers there; set it to 0"
        if moved
        else f"bias = {members.system.bias.name}: pushes the flat film, so the disc does not rest at x = 0 and has no "
        "Floquet multipliers there; take one without a force at x = 0"
    )


# --- searching over the voltage -------------------------------------------------------------------------------------


def _onsets(
    members: Members, ends: Array, steps: int, options: dict[str, Any], progress: Progress
) -> tuple[Array, npt.NDArray[np.int8]]:
    """Onset, kind and error (3, members), and the outcomes."""
    scan = ends[:, None] * (np.arange(steps + 1) / steps)
    whole = steps + 2 * SECTIONS * PEAK_ROUNDS + SECTIONS * ROUNDS
    counted = Counted(progress)
    maps = _at_voltages(members, scan, options, weighted(counted, steps / whole))
    margin = maps.margin().reshape(scan.shape)
    rows, low, high = _first_brackets(scan, margin)
    early, early_low, early_high = _hidden_brackets(members, scan, margin, options)
    rows, low, high = np.append(early, rows), np.append(early_low, low), np.append(early_high, high)
    rows, first = np.unique(rows, return_index=True)
    low, high = low[first], high[first]
    counted(2 * SECTIONS * PEAK_ROUNDS / whole)
    onsets = np.full((3, members.size), np.nan)
    onsets[1] = Onset.NONE
    if rows.size:
        unstable = members.take(rows)
        voltage, width = _refine(unstable, low, high, np.ones(rows.size), options)
        doubles = _at_voltages(unstable, voltage[:, None], options).trace < 0.0
        onsets[:, rows] = voltage, np.where(doubles, Onset.MINUS_ONE, Onset.PLUS_ONE), width
    onsets[:, margin[:, 0] > STILL_STABLE] = np.array([[0.0], [Onset.AT_START], [0.0]])
    counted.finish()
    return onsets, maps.outcome.reshape(scan.shape).max(axis=1)


def _at_voltages(members: Members, voltages: Array, options: dict[str, Any], progress: Progress = None) -> Monodromy:
    """The maps of every member at its voltages (members, voltages), flattened."""
    rows = np.repeat(np.arange(len(voltages)), voltages.shape[1])
    return monodromy(members.take(rows).replace(voltage=voltages.ravel()), options, progress)


def _first_brackets(scan: Array, margin: Array) -> tuple[npt.NDArray[np.intp], Array, Array]:
    """Members that become unstable on the scan, and the step in which they first do."""
    unstable = margin[:, 1:] > 0.0
    rows = np.flatnonzero(unstable.any(axis=1))
    step = unstable[rows].argmax(axis=1)
    return rows, scan[rows, step], scan[rows, step + 1]


def _hidden_brackets(
    members: Members, scan: Array, margin: Array, options: dict[str, Any]
) -> tuple[npt.NDArray[np.intp], Array, Array]:
    """Members with a tongue between two points of the scan, and its brackets, lowest first; found at peaks of the
    margin."""
    stable_so_far = np.logical_and.accumulate(~(margin > 0.0), axis=1)
    peak = (margin[:, 1:-1] >= margin[:, :-2]) & (margin[:, 1:-1] >= margin[:, 2:]) & stable_so_far[:, 1:-1]
    rows, at = np.nonzero(peak & (margin[:, 1:-1] > NEAR_ONSET))
    low, high = scan[rows, at], scan[rows, at + 2]
    begin, best, value, each = low, scan[rows, at + 1], margin[rows, at + 1], np.arange(rows.size)
    for _ in range(PEAK_ROUNDS if rows.size else 0):
        points, inner = _sections(members.take(rows), low, high, options)
        top = inner.argmax(axis=1) + 1
        best, value = points[each, top], inner[each, top - 1]
        low, high = points[each, top - 1], points[each, top + 1]
    hidden = value > 0.0
    return rows[hidden], begin[hidden], best[hidden]


def _boundaries(rows: Members, volts: Array, margin: Array, options: dict[str, Any], progress: Progress) -> Array:
    """All voltages at which the stability of each row changes on the grid, shape (rows, most changes), NaN-padded."""
    row, step = np.nonzero((margin[:, 1:] > 0.0) != (margin[:, :-1] > 0.0))
    rising = np.where(margin[row, step + 1] > 0.0, 1.0, -1.0)
    crossings = _refine(rows.take(row), volts[step], volts[step + 1], rising, options)[0] if row.size else volts[:0]
    advance(progress, 1.0)
    return padded(np.split(crossings, np.searchsorted(row, np.arange(1, len(margin)))))


def _refine(members: Members, low: Array, high: Array, rising: Array, options: dict[str, Any]) -> tuple[Array, Array]:
    """Roots of the margin in brackets, one per member, where it rises (1) or falls (-1) through 0; and their widths.

    A bracket is cut into sections until interpolation inside it is exact to rounding.
    """
    each = np.arange(low.size)
    ends = rising[:, None] * _at_voltages(members, np.stack([low, high], axis=1), options).margin().reshape(-1, 2)
    for _ in range(ROUNDS):
        points, inner = _sections(members, low, high, options)
        values = np.concatenate([ends[:, :1], rising[:, None] * inner, ends[:, 1:]], axis=1)
        passed = values > 0.0
        passed[:, -1] = True
        step = np.maximum(passed.argmax(axis=1), 1)
        low, high = points[each, step - 1], points[each, step]
        ends = np.stack([values[each, step - 1], values[each, step]], axis=1)
    before, past = np.minimum(ends[:, 0], 0.0), np.maximum(ends[:, 1], 0.0)
    share = before / np.where(before == past, 1.0, before - past)
    return low + (high - low) * share, high - low


def _sections(members: Members, low: Array, high: Array, options: dict[str, Any]) -> tuple[Array, Array]:
    """Voltages that cut each bracket into sections, its ends among them, and the margins at those inside."""
    points = low[:, None] + (high - low)[:, None] * (np.arange(SECTIONS + 2) / (SECTIONS + 1))
    return points, _at_voltages(members, points[:, 1:-1], options).margin().reshape(-1, SECTIONS)


def _search_ends(model: Ensemble, highest: npt.ArrayLike | None) -> Array:
    if highest is None:
        pitchfork = pitchfork_voltages(every_balance(model))
        members = model.members()
        film = BEFORE_PULL_IN * np.sqrt(members.system.film.highest_squared(np.zeros(members.size), members.numbers()))
        free = members.system.waveform.amplitude_at(members.numbers(), film)
        free = np.where(free > 0.0, free, film)  # a film that the bias alone pulls in is refused elsewhere
        return np.minimum(np.where((pitchfork > 0.0) & np.isfinite(pitchfork), 3.0 * pitchfork, 3.0), free)
    ends = np.asarray(VOLTAGE["voltage"].check("highest", highest))
    if not (ends > 0.0).all():
        raise InputError("highest = 0: must be greater than 0, or there is no interval to search")
    try:
        return np.broadcast_to(ends, model.shape).ravel()
    except ValueError:
        raise InputError(
            f"highest has the shape {ends.shape}: must be a number or one a member {model.shape}"
        ) from None


def _scan_steps(members: Members, steps: int | None) -> npt.NDArray[np.int64]:
    """Steps of the scan for each member: the trace swings about once for each half oscillation in a forcing period."""
    if steps is not None:
        if steps < 2:
            raise InputError(f"steps = {steps}: must be at least 2")
        return np.full(members.size, steps)
    stiffness = np.nan_to_num(members.stiffness(np.zeros(members.shape)), nan=0.0, posinf=0.0, neginf=0.0)
    lobes = members.forcing_period * np.sqrt(np.maximum(stiffness, 0.0)) / np.pi
    return next_power_of_two(np.clip(STEPS_PER_LOBE * lobes, FEWEST_STEPS, MOST_STEPS))


def _axis(name: str, values: npt.ArrayLike) -> Array:
    axis = np.atleast_1d(np.asarray(VOLTAGE[name].check(name, values), dtype=float))
    if axis.ndim > 1 or axis.size < 2 or not (np.diff(axis) > 0.0).all():
        raise InputError(f"{name}: must be at least two increasing values; sort them and leave out doubles")
    return axis

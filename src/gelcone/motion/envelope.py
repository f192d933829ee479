"""Operating envelope of a device: the limit that comes first as the voltage rises, at rest and at each drive frequency.

The drive is scaled as a whole; its peak is the largest absolute voltage of its waveform with the bias. Quasi-static
limits hold for a constant peak voltage reached on a slow ramp, driven limits for the motion that starts from rest.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from gelcone import dataset
from gelcone.codes import Outcome, Regime
from gelcone.devices.analysis import analysis, check_one
from gelcone.errors import InputError
from gelcone.motion.coexisting import coexisting
from gelcone.motion.creep import Holding, check_holds, holding, thresholds
from gelcone.motion.delivery import JUMPS
from gelcone.motion.driven import driven
from gelcone.motion.electrical import MEANINGS as ELECTRICAL
from gelcone.motion.plane import DRIVEN_LIMITS, NUDGE, Plane
from gelcone.motion.proportion import in_proportion
from gelcone.motion.response import HEAT, heats
from gelcone.motion.static_limits import STATIC_LIMITS, held_limits, peaks_of, static_curves, static_limits_of
from gelcone.motion.validity import validity_variables
from gelcone.physics.film.membrane import MembraneFilm
from gelcone.physics.film.pull_in import membrane_pull_in
from gelcone.physics.model import ConeModel
from gelcone.physics.system import ConeSystem
from gelcone.progress import Progress, weighted
from gelcone.quantity import Array, Frequencies, Time, Voltages
from gelcone.register.analysis import Axis

if TYPE_CHECKING:
    import xarray as xr

MARGIN = 0.2
"""Share of the lowest limit by which the recommended voltage is below it."""
COEXISTING_SHARE = 0.3
"""Share of the progress for coexisting motions."""
HELD_SHARE = 0.1
"""Share of the progress for constant voltages that are held."""
HELD_LEVELS = 32
"""Number of constant voltages that are held for a duration."""


@analysis(
    axes={
        "frequencies": Axis("drive_frequency", "frequency", one="operating-limits"),
        "peaks": Axis("peak_voltage", "peak_voltage"),
    },
    answers="envelope",
    drawn=True,
    examples=(
        "biased-pump --out results",
        'my-device.toml --over "frequency=5 Hz:20 Hz:31" --margin 0.3 --json',
        "my-device.toml --duration 10min",
    ),
)
def envelope(
    model: ConeModel,
    *,
    peaks: Voltages | None = None,
    frequencies: Frequencies | None = None,
    margin: float = MARGIN,
    limits_from: str = "rest",
    duration: Time | None = None,
    threads: int | None = None,
    progress: Progress = None,
) -> xr.Dataset:
    """Compute limits over peak voltage and drive frequency, which comes first, and the recommended window.

    Parameters
    ----------
    model : a single model; its drive gives the proportion of amplitude to bias, and its own point of operation. Without
        a ``dielectric_strength`` breakdown is NaN, and the window does not account for it.
    peaks : increasing peak voltages of the driven plane; default 20 up to a little above the constant
        voltage of pull-in, or to twice the lowest quasi-static limit where that is less.
    frequencies : increasing drive frequencies; default some 30 from a tenth to three times the natural frequency at
        rest, the first resonances and the model's own among them, and more until the lowest limit is known to 1 %
        between any two, or to jump between two that are 0.2 % apart.
    margin : share of the lowest limit that the recommended voltage stays below it. Default 0.2.
    limits_from : the motion that the limits hold for: ``"rest"``, switched on from rest, ``"settled"``, settled while
        the voltage rises slowly, or ``"both"``. Default rest, with its transient over at least 12 drive periods and 4
        decay times; of states far slower than the disc at points of their drift.
    duration : of a film that creeps, for how long it must bear a constant voltage. Default: without end, so that limits
        at constant voltage are those of the relaxed film.
    threads : worker threads; default one a core. Does not change a bit of the result.
    progress : called with the share of the work just done (the shares add up to 1).

    Returns
    -------
    Dataset with, over ``constant_voltage`` (quasi-static): ``static_displacement``, ``stroke``, ``blocked_force``,
    ``natural_frequency`` (of small motions, in which a film that creeps is stiffer than on the ramp), ``static_field``,
    ``static_hoop_stress``, ``static_meridional_stress``; over ``static_limit``: ``static_limit_voltage`` (infinity:
    none on the way to pull-in or the stretch limit, NaN: unknown or not applicable); ``recommended_constant``, the
    lowest of them less the margin; ``rest_displacement``; and ``operating_peak_voltage`` and ``operating_frequency`` of
    the device's drive. Of films in opposite phase all this is of a drive that is held at its peak, to which bias and
    amplitude rise in proportion, unlike the constant voltages of `gelcone.static` at the device's bias; the second film
    then has ``recommended_second_voltage``, and thresholds of creep are named ``proportional_...``.

    Over ``drive_frequency`` and ``peak_voltage``, of the settled motion: ``driven_stroke``, ``driven_power``,
    ``driven_damper_power``, ``driven_apparent_power``, ``driven_peak_charge``, ``driven_field``, ``regime``,
    ``outcome``; NaN where it was not
    examined: well above the pull-in of the film, and the yields at frequencies that were added. Over
    ``driven_limit`` and
    ``drive_frequency``: ``limit_low`` and ``limit_high``, the interval of the peak voltage in which the limit is first
    met (both infinite: not up to the highest peak, or to pull-in; both NaN: unknown or not applicable).

    Over ``drive_frequency``: ``first_limit``, its index (-1: none); ``recommended_peak``, the lowest known limit,
    driven or quasi-static, less the margin; and at that peak, the window's edge, ``window_stroke``, ``window_power``,
    ``window_apparent_power``, ``window_peak_charge`` and ``window_regime``; NaN where there is no window.

    The pull-in of a cone is that of the membrane for which it stands, which comes earlier than the cone's: of a motion
    whose voltage exceeds the one at which the membrane has pulled in at that displacement. A wrinkling cone stands for
    one of the ``radius_ratio`` 0.2 where it has no other; taut and double cones only with their own, as those of
    devices. The attribute ``pull_in_of`` says whether it is ``membrane`` or ``cone``, and
    ``pull_in_error`` how well the membrane's force is known, over that without voltage (0 for the cone).

    Of a film that creeps ``long_term_pull_in_voltage`` and ``instantaneous_pull_in_voltage`` are the constant voltages
    at which the film itself pulls in, relaxed and at once; between them it pulls in late, see `gelcone.creep`. With a
    ``duration`` the limits at constant voltage are those that it meets while a voltage is held for so long,
    ``holding_voltage`` is the highest that it bears, and ``held_displacement``, over ``held_voltage``, where it then
    is. The pull-in of a membrane that a cone stands for is that of its relaxed gel at the displacements of the cone.

    Of a film that creeps or leaks ``driven_heating`` and ``window_heating`` are the rates at which its temperature
    rises as long as it gives no heat away; ``static_heating`` that at a constant voltage.

    At that peak, too, at the given or default frequencies, other motions to which kicks lead
    (`gelcone.motion.coexisting`): ``coexisting_motions``, their number; ``kick_low`` and ``kick_high``, the interval
    of the smallest sudden change of the disc's velocity that leads away from the window's motion (both infinite: none
    up to ``kick_tried``); and over ``motion`` as well, padded with NaN, for each other motion ``motion_stroke``,
    ``motion_lowest``, ``motion_highest``, ``motion_period``, ``motion_regime``, ``motion_outcome``,
    ``motion_kick_low`` and ``motion_kick_high`` (NaN for one found without a kick), and its shares outside the
    model's validity, ``motion_validity_*``.

    The power is the mean of all losses over 12 drive periods, which in a settled motion is the power of the voltage
    source. ``driven_damper_power`` and ``window_damper_power`` are the part 2 zeta x'^2 of the damper: friction, or the
    work on a load that acts as a damper. The rest is lost in film, leak and resistance, and at jumps of an ideal
    source's voltage. The apparent power, for which the amplifier must be built, is the product of the root mean squares
    of voltage and current d(v q)/dtau.

    Raises
    ------
    InputError : for an ensemble, a drive without voltage, a margin outside [0, 1), or axes that do not increase.

    Examples
    --------
    >>> import gelcone
    >>> model = gelcone.ConeModel(voltage=0.3, voltage_bias=0.6, rest_height=0.8, hoop_prestretch=1.4)
    >>> window = gelcone.envelope(model, peaks=[0.5, 1.0, 1.5], frequencies=[0.6, 0.8])
    >>> window.recommended_peak.values.round(3).tolist()
    [0.727, 0.681]
    """
    check_window(model, margin, duration)
    plane = plane_of(model, threads, limits_from)
    return window_of(
        plane,
        static_limits_of(plane),
        peaks=peaks,
        frequencies=frequencies,
        margin=margin,
        duration=duration,
        kicked=True,
        progress=progress,
    )


def window_of(
    plane: Plane,
    static_limits: Array,
    *,
    peaks: npt.ArrayLike | None = None,
    frequencies: npt.ArrayLike | None = None,
    margin: float = MARGIN,
    duration: float | None = None,
    kicked: bool = False,
    to_first: bool = False,
    progress: Progress = None,
) -> xr.Dataset:
    """Compute the `envelope` in a plane with ``static_limits``, those of `static_limits_of`; without the motions to
    which kicks lead unless motions are ``kicked``, and ``to_first``, with peaks up to the first limit alone."""
    model = plane.model
    film_error = float(model.own_numbers["film_error"]) if isinstance(model.film, MembraneFilm) else None
    refine = frequencies is None
    omegas = plane.default_frequencies() if frequencies is None else positive_axis("frequencies", frequencies)
    default = peaks_of(plane, static_limits)
    creeps: dict[str, dataset.Variable] = thresholds(model, plane.bias_share) if duration is None else {}
    levels: dict[str, dataset.Variable] = {}
    if duration is not None:
        share = weighted(progress, HELD_SHARE)
        held = holding(model, duration, float(default[-1]), count=HELD_LEVELS, threads=plane.threads, progress=share)
        static_limits, creeps = held_limits(plane, held, static_limits), _held_variables(held, duration)
        default = peaks_of(plane, static_limits) if np.isfinite(static_limits).any() else default  # none above the held
        levels = {"held_voltage": (("held_voltage",), held.levels, "constant voltage that is held", "voltage")}
        progress = weighted(progress, 1.0 - HELD_SHARE)
    volts = default if peaks is None else positive_axis("peaks", peaks)
    static = static_curves(plane, max(float(volts[-1]), float(default[-1])))
    lowest_static = np.nanmin(static_limits, initial=np.inf)
    share = weighted(progress, 1.0 - COEXISTING_SHARE) if kicked else progress
    reach: dict[str, Any] = {"ceiling": lowest_static, "pull_in": static_limits[-1], "to_first": to_first}
    examined = driven(plane, omegas, volts, refine=refine, progress=share, **reach)
    low = np.where(np.isnan(examined["low"]), np.inf, examined["low"])
    first = np.where(np.isfinite(low.min(axis=1)), low.argmin(axis=1), -1)
    recommended = recommended_peaks(examined["low"], lowest_static, volts, margin)
    constant = (1.0 - margin) * np.minimum(lowest_static, default[-1])
    edge = plane.examine(examined["frequency"], recommended)
    window = {name: np.where(recommended > 0.0, edge[name], np.nan) for name in _WINDOW}
    others: dict[str, dataset.Variable] = {}
    if kicked:
        has_window = np.isin(examined["frequency"], omegas) & (recommended > 0.0)
        others = _coexisting(
            plane, examined["frequency"], recommended, has_window, weighted(progress, COEXISTING_SHARE)
        )
    of_constant, of_frequency = ("constant_voltage",), ("drive_frequency",)
    of_both = ("drive_frequency", "peak_voltage")
    of_limit = ("driven_limit", "drive_frequency")
    result = dataset.label(
        model,
        {name: (of_constant, values, *_STATIC[name]) for name, values in static.items() if name in _STATIC}
        | {name: (of_both, examined[name.removeprefix("driven_")], *_DRIVEN[name]) for name in _of(model, _DRIVEN)}
        | {f"window_{name}": (of_frequency, window[name], *_WINDOW[name]) for name in _of(model, _WINDOW)}
        | others
        | creeps
        | {
            "static_limit_voltage": (("static_limit",), static_limits, "voltage of the quasi-static limit", _VOLTAGE),
            "limit_low": (of_limit, examined["low"].T, "lower end of the interval of the limit's voltage", _VOLTAGE),
            "limit_high": (of_limit, examined["high"].T, "upper end of the interval of the limit's voltage", _VOLTAGE),
            "first_limit": (of_frequency, first, "index of the limit that comes first, -1 if none", "code"),
            "recommended_peak": (of_frequency, recommended, "recommended highest peak voltage", "voltage"),
            "recommended_constant": ((), constant, "recommended highest constant voltage", "voltage"),
            "rest_displacement": ((), np.array(plane.rest), "rest without voltage", "length"),
        },
        coords=levels
        | {
            "constant_voltage": (of_constant, static["constant_voltage"], "constant voltage", "voltage"),
            "drive_frequency": (of_frequency, examined["frequency"], "drive frequency", "frequency"),
            "peak_voltage": (("peak_voltage",), volts, "peak voltage", "voltage"),
            "operating_peak_voltage": ((), float(model.peak_voltage), "peak voltage of the device's drive", "voltage"),
            "operating_frequency": ((), float(model.drive_frequency), "frequency of its drive", "frequency"),
            "static_limit": (("static_limit",), np.array(STATIC_LIMITS), "quasi-static limit", "code"),
            "driven_limit": (("driven_limit",), np.array(DRIVEN_LIMITS), "limit of the driven motion", "code"),
        },
        options={"margin": margin, "limits_from": plane.limits_from, "duration": duration},
        title="operating envelope",
    )
    return _of_both_films(result, plane).assign_attrs(
        pull_in_of=pull_in_of(plane),
        pull_in_error=film_error or max((curve.error for curve in plane.membranes), default=0.0),
    )


def _of_both_films(result: xr.Dataset, plane: Plane) -> xr.Dataset:
    """The envelope; of films in opposite phase with the voltage of the second one, and of a drive held at its peak."""
    if not plane.model.system.in_opposite_phase:
        return result
    second = second_voltage(plane, result["recommended_constant"].values)
    result = result.assign(dataset.columns((), {"recommended_second_voltage": (second, *SECOND)}))
    return said_in_proportion(result, plane.model.system)


def said_in_proportion(result: xr.Dataset, system: ConeSystem) -> xr.Dataset:
    """The envelope with the meanings of a drive that is held at its peak, if its films are in opposite phase."""
    suffix = in_proportion(system)
    if not suffix:
        return result
    for name, variable in result.variables.items():
        words = str(variable.attrs["long_name"])
        asked = "constant_voltage" in variable.dims or variable.attrs.get("quantity") == "voltage"
        if asked and not str(name).startswith("operating_") and not words.endswith(suffix):
            variable.attrs["long_name"] = _HELD_AT_PEAK.get(str(name), words) + suffix
    return result


_HELD_AT_PEAK = {
    "constant_voltage": "peak voltage at which the drive is held",
    "static_displacement": "displacement under a drive that is held at its peak",
    "recommended_constant": "recommended highest peak voltage at which the drive is held",
}
"""Meanings where a constant voltage is not that of a drive held at its peak."""


def second_voltage(plane: Plane, peaks: Array) -> Array:
    """The commanded voltage of the second film in opposite phase while the drive is held at peaks."""
    return np.abs(2.0 * plane.bias_share - 1.0) * peaks


SECOND = "commanded voltage of the second film while the drive is held at the recommended peak", "voltage"


def check_window(model: ConeModel, margin: float, duration: float | None = None) -> None:
    """Raises `InputError` for an ensemble, a margin outside [0, 1), and a duration for which no voltage can be held."""
    check_one(model, "envelope")
    if not (isinstance(margin, float | int) and 0.0 <= margin < 1.0):
        raise InputError(f"margin = {margin}: must be a number from 0 up to, but not including, 1")
    if duration is not None:
        check_holds(model, duration)


def plane_of(model: ConeModel, threads: int | None, limits_from: str = "rest") -> Plane:
    """The driven plane of an envelope, with the pull-in of the film as a membrane; raises `InputError`."""
    return Plane.of(model, threads, membrane_pull_in(model), limits_from)


def pull_in_of(plane: Plane) -> str:
    """The model, ``membrane`` or ``cone``, whose pull-in an envelope shows."""
    return "membrane" if plane.membranes or isinstance(plane.model.film, MembraneFilm) else "cone"


def recommended_peaks(low: Array, static: float, peaks: Array, margin: float = MARGIN) -> Array:
    """The recommended highest peak voltages (frequencies,): below the driven limits ``low`` (frequencies, limits), the
    lowest ``static`` one and the largest of the ``peaks`` examined, less the margin."""
    lowest = np.where(np.isnan(low), np.inf, low).min(axis=1)
    return np.asarray((1.0 - margin) * np.minimum(np.minimum(lowest, static), peaks[-1]))


_VOLTAGE = dataset.absent("voltage", nan="unknown or not applicable")
_APPARENT = dataset.absent("apparent power", infinite=JUMPS)
_STATIC: dict[str, tuple[str, dataset.Of]] = {
    "static_displacement": ("displacement on a slow voltage ramp", "length"),
    "stroke": ("displacement from the rest without voltage", "length"),
    "blocked_force": ("force on a stop at the rest position", "force"),
    "natural_frequency": ("natural frequency of small undamped motions", dataset.absent("frequency")),
    "static_field": ("true electric field", "field"),
    "static_hoop_stress": ("true hoop stress", "stress"),
    "static_meridional_stress": ("true meridional stress", "stress"),
    "static_heating": (f"{HEAT['heating'][0]} at a constant voltage", "heating"),
}
_DRIVEN: dict[str, tuple[str, dataset.Of]] = {
    "driven_stroke": ("stroke of the settled motion, peak to peak", "length"),
    "driven_power": ("mean power that the voltage source supplies and the device dissipates", "power"),
    "driven_damper_power": ELECTRICAL["damper_power"],
    "driven_apparent_power": ("root mean square voltage times current", _APPARENT),
    "driven_peak_charge": ("largest charge of a source", "charge"),
    "driven_field": ("highest true field", "field"),
    "driven_heating": HEAT["heating"],
    "regime": ("kind of motion", Regime),
    "outcome": ("how the run ended", Outcome),
}
_WINDOW: dict[str, tuple[str, dataset.Of]] = {
    "stroke": ("stroke at the recommended peak voltage, peak to peak", "length"),
    "power": ("mean power that the voltage source supplies there", "power"),
    "damper_power": ELECTRICAL["damper_power"],
    "apparent_power": ("root mean square voltage times current there", _APPARENT),
    "peak_charge": ("largest charge of a source there", "charge"),
    "heating": (f"{HEAT['heating'][0]} there", "heating"),
    "regime": ("kind of motion there", Regime),
}


def _of(model: ConeModel, meanings: Mapping[str, tuple[str, dataset.Of]]) -> list[str]:
    """The names of the variables that a model has; heating only of films that get warm."""
    return [name for name, (_, of) in meanings.items() if of != "heating" or heats(model.system)]


_KICK = dataset.absent("velocity")
_KICKS = {
    "kick_low": ("lower end of the interval of the smallest kick that leads away from the window's motion", _KICK),
    "kick_high": ("upper end of the interval of the smallest kick that leads away from the window's motion", _KICK),
    "kick_tried": ("largest kick that was tried", _KICK),
}
_MOTIONS: dict[str, tuple[str, dataset.Of]] = {
    "stroke": ("stroke of a coexisting motion, peak to peak", "length"),
    "lowest": ("lowest displacement of a coexisting motion", "length"),
    "highest": ("highest displacement of a coexisting motion", "length"),
    "period": ("period of a coexisting motion in forcing periods, 0 if none", "count"),
    "regime": ("kind of a coexisting motion", Regime),
    "outcome": ("how the run of a coexisting motion ended", Outcome),
    "kick_low": ("lower end of the interval of the smallest kick to a coexisting motion", _KICK),
    "kick_high": ("upper end of the interval of the smallest kick to a coexisting motion", _KICK),
}


def _coexisting(
    plane: Plane, omegas: Array, peaks: Array, kicked: npt.NDArray[np.bool_], progress: Progress
) -> dict[str, dataset.Variable]:
    """The motions that coexist with the window's at the frequencies at which motions are ``kicked``."""
    kicked_rows = np.flatnonzero(kicked)
    of_frequency, of_motion = ("drive_frequency",), ("drive_frequency", "motion")
    members = (
        plane.at(omegas[kicked_rows], peaks[kicked_rows]).members()
        if kicked_rows.size
        else plane.model.members().take(kicked_rows)
    )
    start = members.start_states((plane.rest + NUDGE, 0.0))
    motions = coexisting(members, start, threads=plane.threads, progress=progress)
    of_ok = np.zeros(1, dtype=np.int8)
    shares = validity_variables(motions["validity"], of_ok, members.system, of_motion, "coexisting motion")
    variables: dict[str, dataset.Variable] = {
        "coexisting_motions": (of_frequency, motions["motions"], "motions other than the window's", "count")
    }
    variables |= {name: (of_frequency, motions[name], *about) for name, about in _KICKS.items()}
    for name, about in _MOTIONS.items():
        variables[f"motion_{name}"] = (of_motion, motions[f"motion_{name}" if "kick" in name else name], *about)
    variables |= {f"motion_{name}": variable for name, variable in shares.items()}

    def all_frequencies(values: Array) -> Array:
        spread = np.full((len(omegas), *values.shape[1:]), np.nan)
        spread[kicked_rows] = values
        return spread

    return {
        n: (dims, all_frequencies(values), words, quantity) for n, (dims, values, words, quantity) in variables.items()
    }


def positive_axis(name: str, values: npt.ArrayLike) -> Array:
    """At least two positive numbers that increase, for an axis; `InputError` for others."""
    axis = np.atleast_1d(np.asarray(values, dtype=float))
    if axis.ndim != 1 or axis.size < 2 or not np.isfinite(axis).all() or axis[0] <= 0.0 or (np.diff(axis) <= 0.0).any():
        raise InputError(f"{name}: must be at least 2 positive numbers that increase; sort them and leave out doubles")
    return axis


def _held_variables(held: Holding, duration: float) -> dict[str, dataset.Variable]:
    at_end = held.runs[1].states[:, -1, 0]
    return held.variables | {
        "held_displacement": (("held_voltage",), at_end, "displacement after the holding time", "length"),
        "holding_time": ((), duration, "for how long a constant voltage is held", "time"),
    }

"""The data sheet of an actuator; each number comes from its own analysis."""

from __future__ import annotations

import json
from collections.abc import Mapping
from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np

from gelcone import dataset
from gelcone.bracket import crossing
from gelcone.devices.analysis import analysis, check_one, plain
from gelcone.errors import InputError
from gelcone.motion.delivery import JUMPS
from gelcone.motion.electrical import MEANINGS
from gelcone.motion.equilibrium import static
from gelcone.motion.natural import natural_frequency
from gelcone.motion.operating_limits import limit_variable, operating_limits, slow_limits
from gelcone.motion.plane import DRIVEN_LIMITS, NUDGE, DriveShape, Plane
from gelcone.motion.proportion import at_own_bias
from gelcone.motion.ramp import on_the_way, stroke_and_blocked_force
from gelcone.motion.settled import settled
from gelcone.motion.state_space import StateSpace, state_space
from gelcone.motion.static_bifurcations import PULL_IN
from gelcone.motion.static_limits import MEMBRANE_PULL_IN, membrane_pull_in_at_own_bias
from gelcone.motion.static_results import own_levels
from gelcone.physics.balance import StaticBalance
from gelcone.physics.film.pull_in import membrane_pull_in
from gelcone.physics.model import ConeModel
from gelcone.physics.statics import every_balance, rest_displacement
from gelcone.progress import Progress, advance, weighted
from gelcone.quantity import Array, Voltages
from gelcone.register.analysis import CONSTANT_VOLTAGE

if TYPE_CHECKING:
    import xarray as xr

RAMP = 41
"""Number of voltages of the ramp over which stroke and blocked force are drawn."""
PLACES, AROUND = 121, 0.3
"""Number of displacements of the force, and their range beyond the longest stroke, over that stroke."""
FREQUENCIES, LOWEST, HIGHEST = 201, 0.02, 4.0
"""Number of frequencies of the small-signal response, and their ends over the highest natural frequency."""
STEP = 1e-5
"""Relative change of a voltage over which the slope of the charge is computed."""
HALF_POWER = np.sqrt(0.5)
NO_LIMIT = "none up to the voltages examined"
STEPS = 4000
"""Least number of samples of the step response, until all modes have settled, or over some 300 slow periods."""


@analysis(
    axes={"voltages": CONSTANT_VOLTAGE},
    answers="datasheet",
    single=True,
    file_only=(
        "displacement", "force", "stiffness", "branch_voltage", "branch_displacement", "branch_slope", "branch_fails",
        "equilibrium", "ramp_voltage", "ramp_stroke", "ramp_blocked_force", "gain", "drive_frequency",
    ),
    examples=("biased-pump --out results", 'biased-pump --over "constant_voltage=0.5 kV,1 kV" --film wrinkling --json'),
)  # fmt: skip
def datasheet(
    model: ConeModel,
    voltages: Voltages | None = None,
    *,
    threads: int | None = None,
    progress: Progress = None,
) -> xr.Dataset:
    """Compute the data sheet of an actuator: force, stroke, stiffness, work, coupling, bandwidth, power and limits.

    Parameters
    ----------
    model : a single actuator; its drive decides power, current and the limits.
    voltages : constant commanded voltages v of the statics and of the small-signal numbers. Default the peak of the
        drive and, where it has one, its offset.
    threads : worker threads; default one a core. Does not change a bit of the result.
    progress : called with the share of the work just done (the shares add up to 1).

    Returns
    -------
    Dataset of `gelcone.static` at 0 and the voltages, and over ``constant_voltage``: ``stiffness_at_rest``, the slope
    of the force where the disc rests under the voltage, at 0 without voltage on any film; ``stroke_work``, of a stroke
    from a stop at rest on a load that follows the force, and ``load_work``, the largest on a constant load;
    ``volume_work`` and ``mass_work``, the work of a stroke over the film's volume and over all that moves, and
    ``volume_power`` and ``mass_power``, these times the natural frequency; ``capacitance`` and ``field_energy``
    (unknown of two films); ``coupling``, the share of the electrical energy of a small slow cycle that comes out as
    work, (g^2/K)/(dQ/dv + g^2/K) with the blocked force's slope g over the voltage, the stiffness K and the slope dQ/dv
    of the charge of the held film; ``natural_frequency``
    of small motions as if undamped, in which the branches of a film that creeps have little time to relax, so that it
    lies above that of ``stiffness_at_rest``; ``half_width`` of its resonance, ``bandwidth``, to which the small-signal
    response stays above half power, ``gain``, that response over the static one at each ``drive_frequency``, and
    ``rise_time``, from 10 to 90 % of a small step.
    Over ``ramp_voltage``: ``ramp_stroke`` and ``ramp_blocked_force``. Of the drive: ``drive_stroke``, ``peak_current``,
    ``apparent_power``, ``mean_power``. Limits as in `gelcone.operating_limits`; the attribute ``first_limit`` names the
    lowest, ``first_limit_voltage``. ``pull_in_voltage`` and ``pull_in_kind`` are those of the film as given under a
    constant voltage, as all over ``constant_voltage``, and ``membrane_pull_in_voltage`` that of the membrane for which
    a cone stands: of films in opposite phase at the device's bias.

    Raises
    ------
    InputError : for an ensemble, voltages out of bounds, or none above 0.

    Examples
    --------
    >>> import gelcone
    >>> model = gelcone.ConeModel(voltage=0.3, voltage_bias=0.6, rest_height=0.8, hoop_prestretch=1.4)
    >>> sheet = gelcone.datasheet(model, [0.6, 0.9])
    >>> sheet.natural_frequency.values.round(4).tolist(), sheet.first_limit
    ([1.5788, 1.4842, 1.3535], 'driven meridional slack')
    """
    check_one(model, "datasheet")
    levels = own_levels(model) if voltages is None else np.unique(np.asarray(voltages, dtype=float))
    if not np.any(levels):
        raise InputError("voltages = 0: a data sheet takes one above 0; give --over constant_voltage=..., or a drive")
    levels = np.unique([0.0, *np.atleast_1d(levels)])
    ramp, displacements = _ramp(model, float(levels[-1]))
    sheet = plain(static)(model, levels, displacements, progress=weighted(progress, 0.3)).assign(ramp)
    sheet = sheet.assign(_static_numbers(model, sheet))
    sheet = sheet.assign(_dynamic_numbers(model, sheet))
    advance(progress, 0.3)
    sheet = _with_membrane(_with_limits(sheet.assign(_drive(model, threads)), model, threads), model)
    advance(progress, 0.4)
    options = {"voltages": None if voltages is None else levels[1:].tolist()}
    return sheet.assign_attrs(title="data sheet", options=json.dumps(options))


_LEVELS = ("constant_voltage",)
_BEYOND = "beyond pull-in"


def _of(quantity: str) -> dict[str, str]:
    return dataset.absent(quantity, nan=_BEYOND, infinite=_BEYOND)


def _static_numbers(model: ConeModel, found: xr.Dataset) -> dict[str, object]:
    """Stiffness, work, charge and coupling at the end of a slow ramp to each voltage."""
    (balance,) = every_balance(model)
    rest, volts = float(found["rest_displacement"]), found["constant_voltage"].values
    x = rest + found["stroke"].values
    x = np.where(np.isfinite(x), x, np.nan)
    squared = volts**2
    on_film = np.sqrt(balance.films(x, squared)[0])
    capacitance, slope, gain = _electric(model, x, on_film)
    of_one = partial(dataset.absent, nan=_BEYOND if len(model.system.films) == 1 else "unknown of two films")
    with np.errstate(all="ignore"):
        stiffness = np.where(np.isfinite(x), balance.stiffness(x, squared), np.nan)
        stiffness[volts == 0.0] = balance.together.stiffness(np.asarray(rest), np.zeros(()))
        moved = gain**2 / np.where(np.isfinite(x), model.stiffness(x, on_film), np.nan)
        coupling = moved / (slope + moved)
    work, load = np.array([_works(balance, rest, at, v2) for at, v2 in zip(x, squared, strict=True)]).T
    natural = natural_frequency(model, volts, x) / (2.0 * np.pi)
    return dataset.columns(_LEVELS, {
        "stiffness_at_rest": (stiffness, "slope of the force where it rests under the voltage", _of("stiffness")),
        "stroke_work": (work, "work of a stroke from a stop at rest", _of("energy")),
        "load_work": (load, "largest work of a stroke on a constant load", _of("energy")),
        "volume_work": (work, "work of a stroke over the film's volume", _of("energy density")),
        "mass_work": (work, "work of a stroke over the mass that moves", _of("specific energy")),
        "volume_power": (work * natural, "work over volume at the natural frequency", _of("power density")),
        "mass_power": (work * natural, "work over mass at the natural frequency", _of("specific power")),
        "capacitance": (capacitance, "charge over voltage", of_one("capacitance")),
        "field_energy": (0.5 * capacitance * on_film**2, "energy of the field", of_one("energy")),
        "coupling": (coupling, "electromechanical coupling factor, squared", of_one("share")),
    })  # fmt: skip


def _electric(model: ConeModel, x: Array, volts: Array) -> tuple[Any, Any, Any]:
    """Capacitance, and slopes of charge and force over the voltage of the held film; NaN (unknown) for two films."""
    film, n = model.system.film, model.numbers()
    if len(model.system.films) > 1:
        return (np.full(volts.size, np.nan),) * 3
    with np.errstate(all="ignore"):
        here, above, below = (
            film.capacitance(x, (share * volts) ** 2, [], n) for share in (1.0, 1.0 + STEP, 1.0 - STEP)
        )
        slope = here if film.linear_charge else 0.5 * ((1.0 + STEP) * above - (1.0 - STEP) * below) / STEP
        return here, slope, 2.0 * volts * film.voltage_gain(x, volts**2, n)


def _works(balance: StaticBalance, rest: float, reached: float, squared: float) -> tuple[float, float]:
    """Work of a stroke from a stop at rest: on a load that follows the force all the way, and the largest on a constant
    load, which the disc lifts until the force equals it."""
    from scipy.optimize import minimize_scalar

    if not np.isfinite(reached):
        return np.nan, np.nan
    x, weights = on_the_way(rest, reached)
    whole = float(-balance.force(x, np.full(x.shape, squared)) @ weights)

    def lost(at: float) -> float:
        return float(balance.force(at, squared)) * (at - rest)

    ends = sorted((rest, reached))
    best = minimize_scalar(lost, bounds=ends, method="bounded", options={"xatol": 1e-9 * max(map(abs, ends))})
    return whole, max(0.0, -float(best.fun))


# --- small signals ----------------------------------------------------------------------------------------------------


def _dynamic_numbers(model: ConeModel, found: xr.Dataset) -> dict[str, object]:
    """Natural frequency, width, bandwidth and rise time about each voltage that moves the disc."""
    volts = found["constant_voltage"].values
    x = float(found["rest_displacement"]) + found["stroke"].values
    natural = np.asarray(natural_frequency(model, volts, np.where(np.isfinite(x), x, np.nan)))
    known = natural[np.isfinite(natural)]
    omega = np.linspace(LOWEST, HIGHEST, FREQUENCIES) * (known.max() if known.size else 1.0)
    blank = np.nan, np.nan, np.nan, np.full(omega.size, np.nan)
    rows = [
        _small(model, v, omega) if v > 0.0 and np.isfinite(w) else blank for v, w in zip(volts, natural, strict=True)
    ]
    width, bandwidth, rise, gain = (np.array(column) for column in zip(*rows, strict=True))
    frequency = {"units": "1", "quantity": "frequency", dataset.NAN: "not applicable", dataset.INFINITE: "none"}
    time = dataset.absent("time", infinite="none")
    columns = dataset.columns(_LEVELS, {
        "natural_frequency": (natural, "natural frequency of small undamped motions", _of("frequency")),
        "half_width": (width, "half width of the resonance at half power", frequency),
        "bandwidth": (bandwidth, "frequency to which it stays above half power", frequency),
        "rise_time": (rise, "time from 10 to 90 % of a small step", time),
    })  # fmt: skip
    curves = {"gain": (gain, "small-signal stroke over the static one", "share")}
    axis = {"drive_frequency": (omega, "drive frequency", "frequency")}
    return {
        **columns,
        **dataset.columns((*_LEVELS, "drive_frequency"), curves),
        **dataset.columns("drive_frequency", axis),
    }


def _small(model: ConeModel, voltage: float, omega: Array) -> tuple[float, float, float, Array]:
    """Compute half width, bandwidth, rise time, and the gain over the static one, of small signals about a constant
    voltage."""
    space = state_space(model, voltage=float(voltage))
    values = np.linalg.eigvals(space.A)
    swinging = values[np.abs(values.imag) > 1e-9 * np.abs(values)]
    width = float(-swinging.real[np.argmax(np.abs(swinging.imag))]) if swinging.size else np.nan
    still = space.transfer(np.zeros(1))[0, 0, 0]
    gain = np.abs(space.transfer(omega)[:, 0, 0] / still) if still else np.full(omega.size, np.nan)
    return width, _edge(space, still, values), _rise_time(space, values), gain


def _edge(space: StateSpace, still: complex, values: Any) -> float:
    """The lowest frequency at which the response falls below half the static power."""
    from scipy.optimize import brentq

    if not still:
        return np.nan

    def above(log_omega: float) -> float:
        return float(np.abs(space.transfer(np.exp([log_omega]))[0, 0, 0] / still) - HALF_POWER)

    sizes = np.abs(values[np.abs(values) > 0.0])
    grid = np.linspace(np.log(1e-3 * sizes.min()), np.log(1e2 * sizes.max()), 2000)
    heights = np.array([above(at) for at in grid])
    below = np.flatnonzero(heights < 0.0)
    if not below.size or below[0] == 0:
        return np.inf if not below.size else float(np.exp(grid[0]))
    return float(np.exp(brentq(above, grid[below[0] - 1], grid[below[0]])))


def _rise_time(space: StateSpace, values: Any) -> float:
    """The time from 10 to 90 % of the final displacement after a small step of the voltage."""
    from scipy.linalg import expm

    if not (values.real < 0.0).all():
        return np.nan
    end = np.linalg.solve(space.A, -space.B[:, 0])
    goal = float(space.C[0] @ end)
    if goal == 0.0:
        return np.nan
    longest = min(20.0 / -values.real.max(), 2000.0 / np.abs(values).min())
    fastest = np.abs(values.imag).max() or np.abs(values).min()
    step = min(longest / STEPS, 0.02 / fastest)
    turn, state, heights = expm(step * space.A), -end, [0.0]
    for _ in range(int(min(longest / step, 400_000))):
        state = turn @ state
        heights.append(float(space.C[0] @ (state + end)) / goal)
        if heights[-1] >= 0.9:
            break
    if heights[-1] < 0.9:
        return np.inf
    times = step * np.arange(len(heights))
    return float(np.interp(0.9, heights[-2:], times[-2:]) - crossing(times, np.array(heights), 0.1))


# --- ramp, drive and limits -------------------------------------------------------------------------------------------


def _ramp(model: ConeModel, highest: float) -> tuple[dict[str, object], Array | None]:
    """Stroke and blocked force on a slow ramp from 0; and displacements from somewhat below the rest to beyond the
    longest stroke, None if the disc does not move."""
    levels = np.linspace(0.0, highest, RAMP)
    response = plain(stroke_and_blocked_force)(model, levels)
    stroke, rest = response["stroke"].values, float(response["rest_displacement"])
    variables = dataset.columns("ramp_voltage", {
        "ramp_voltage": (levels, "constant voltage", "voltage"),
        "ramp_stroke": (stroke, "displacement from the rest without voltage", _of("length")),
        "ramp_blocked_force": (response["blocked_force"].values, "force on a stop at the rest position", _of("force")),
    })  # fmt: skip
    longest = float(np.max(stroke, initial=0.0, where=np.isfinite(stroke)))
    around = rest + longest * np.linspace(-AROUND, 1.0 + AROUND, PLACES)
    return variables, around if longest > 0.0 and np.isfinite(rest) else None


def _drive(model: ConeModel, threads: int | None) -> dict[str, object]:
    """Stroke, current and power of the settled motion under the actuator's drive, from next to rest, which may be
    unstable; none of a motion that does not repeat, of which each run has others."""
    settled_motion: Mapping[Any, Any] = {}
    if float(model.voltage) > 0.0:
        motion = plain(settled)(model, (rest_displacement(model) + NUDGE, 0.0), threads=threads)
        if motion["period"] or motion["resting"]:
            settled_motion = motion

    def of(name: str, words: str, quantity: str) -> tuple[Any, str, dataset.Of]:
        absent = dataset.absent(quantity, "not driven, or without a motion that repeats", JUMPS)
        return float(settled_motion.get(name, np.nan)), words, absent

    return dataset.columns((), {
        "drive_stroke": of("stroke", "stroke of the drive, peak to peak", "length"),
        "peak_current": of("current", "largest current of the source", "current"),
        "apparent_power": of("apparent_power", MEANINGS["apparent_power"][0], "apparent power"),
        "mean_power": of("power", "mean power that the drive supplies", "power"),
    })  # fmt: skip


def _with_limits(found: xr.Dataset, model: ConeModel, threads: int | None) -> xr.Dataset:
    """The sheet with the limits of the drive that it does not have yet, and the name and voltage of the lowest."""
    if not (float(model.voltage) > 0.0 or abs(float(model.voltage_bias)) > 0.0):
        return found.assign_attrs(first_limit="not asked: the device has no drive")
    limits = plain(operating_limits)(model, threads=threads)
    names = [name for name in map(str, limits.data_vars) if name.endswith("_voltage") and name not in found]
    shown = [*slow_limits(model.system), *(f"driven {name}" for name in DRIVEN_LIMITS)]
    peaks = {name: float(limits[limit_variable(name, model.system)]) for name in shown}
    finite_peaks = {name: peak for name, peak in peaks.items() if np.isfinite(peak)}
    first = min(finite_peaks, key=lambda name: finite_peaks[name]) if finite_peaks else NO_LIMIT
    voltage = dataset.columns((), {
        "first_limit_voltage": (
            finite_peaks.get(first, np.inf), "peak voltage of the drive at the first limit",
            dataset.absent("voltage", infinite="none"),
        )
    })  # fmt: skip
    found = found.assign({name: limits[name] for name in names}).assign(voltage)
    return found.assign_attrs(first_limit=first, pull_in_of=limits.attrs["pull_in_of"])


def _with_membrane(found: xr.Dataset, model: ConeModel) -> xr.Dataset:
    """The sheet with the pull-in of the membrane for which a cone stands under a constant voltage, where the limits of
    the drive do not have it."""
    name = "membrane_pull_in_voltage"
    if name in found or MEMBRANE_PULL_IN not in slow_limits(model.system):
        return found
    plane = Plane(model, DriveShape(1.0, 0.0), rest_displacement(model), None, membrane_pull_in(model))
    words = f"{PULL_IN}{at_own_bias(model.system)}, of the membrane"
    of = dataset.absent("voltage", nan="unknown", infinite="none before pull-in")
    return found.assign(dataset.columns((), {name: (membrane_pull_in_at_own_bias(plane), words, of)}))

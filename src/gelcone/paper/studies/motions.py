"""Studies behind figures 3 to 12: statics, energies, three values of a parameter side by side, spectra, resonances.

Whatever the paper shows over a window from the start stands beside the same for the long run.
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass, fields
from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from gelcone import dataset
from gelcone.device import Device, find_device
from gelcone.model import ConeModel
from gelcone.motion.cycle import RETURN_TOLERANCE, periods_of
from gelcone.motion.equilibrium import pitchfork_voltage, pull_in_voltage
from gelcone.motion.equilibrium import static as static_curves
from gelcone.motion.floquet import onset_voltage
from gelcone.motion.flow import Outcome, integrate
from gelcone.motion.lyapunov import finite_exponents
from gelcone.motion.regime import classify, label_evidence, regime
from gelcone.motion.response import simulate
from gelcone.motion.section import Progress as MaybeProgress
from gelcone.motion.section import repeat_of, section, weighted
from gelcone.motion.spectrum import FEWEST_PERIODS, spectrum
from gelcone.paper.effort import Effort
from gelcone.paper.presets import Preset, find_preset
from gelcone.paper.studies.study import Progress, Study
from gelcone.quantity import Array
from gelcone.si import to_si

if TYPE_CHECKING:
    import xarray as xr

SPACING = 0.05
"""Between samples of a time response; the fastest motions shown take about 2 for a swing."""
LATE_REPEATS = 32
"""Drive repeats of the long run that are kept densely."""

TRIPLES: dict[str, tuple[str, str, tuple[float, float, float], dict[str, float]]] = {
    "damping": ("base", "damping_ratio", (0.001, 0.05, 0.5), {"voltage": 0.5}),
    "limit": ("fast", "stretch_limit", (1.0, 10.0, 100.0), {"voltage": 1.005}),
    "voltage": ("base", "voltage", (0.5, 1.04, 1.7), {}),
    "prestretch": ("base", "prestretch", (0.8, 1.0, 1.5), {"voltage": 1.0}),
    "spring": ("spring", "spring_stiffness", (1.0, 5.0, 10.0), {}),
}
"""Study -> parameter set, the parameter and its three values, and what else differs from the set. Only the voltage 1.04
is from the paper's text; the other values are reconstructed."""


# --- three values side by side ----------------------------------------------------------------------------------------


def triple(name: str, effort: Effort, progress: Progress) -> xr.Dataset:
    """The motions at three values of a parameter, see `motions`."""
    preset_name, parameter, values, changes = TRIPLES[name]
    preset = find_preset(preset_name)
    model = preset.model.replace(**changes, **{parameter: np.array(values)})
    return motions(preset, model, parameter, effort, progress)


def motions(preset: Preset, model: ConeModel, parameter: str, effort: Effort, progress: Progress) -> xr.Dataset:
    """Motions of an ensemble over one parameter: over a window from the start, and in the long run.

    Dataset over the parameter with

    * the window: ``displacement``, ``velocity`` and ``slack`` over ``time``; with the prefix ``window_`` the
      ``lowest`` and ``highest`` displacement and the shares ``validity_*`` of its time (``slack``: either stress);
      ``early_section_*`` over ``early_repeat``; ``finite`` exponents with their running estimate;
    * the long run, after the transient that the regime took to settle: the same with the prefix ``late_``, over
      ``late_time`` from a whole drive repeat on; the section ``section_*`` over ``repeat``;
    * the variables of `gelcone.regime` (its ``lowest`` and ``highest``, coarsely sampled, left out).
    """
    kinds = regime(model, preset.initial, progress=weighted(progress, 0.3))
    repeat = repeat_of(model)
    settled = int(np.ceil((kinds["settled_time"].values / repeat).max()))
    early_repeats = int(effort.window / repeat.min()) + 1
    early = section(model, preset.initial, repeats=early_repeats, discard=0, progress=weighted(progress, 0.1))
    late = section(
        model, preset.initial, repeats=effort.section_points, discard=settled, progress=weighted(progress, 0.3)
    )
    finite = finite_exponents(model.take(slice(None)), np.tile(preset.initial, (model.size, 1)), effort.window, {})
    parts = [
        kinds.drop_vars(["lowest", "highest", "section"]),
        _finite(model, finite),
        _points(early, "early_section", "early_repeat"),
        _points(late, "section", "repeat"),
        _window(model, preset.initial, effort.window, "window", weighted(progress, 0.2)),
        _long_run(model, late, preset, weighted(progress, 0.1)),
    ]
    result = _merged(*parts).swap_dims(member=parameter)
    options = {"initial": list(preset.initial), "window": effort.window, "settled_repeats": settled}
    return _about(result, kinds, preset.name, parameter, effort, options, f"motions at three values of {parameter}")


def _merged(*parts: xr.Dataset) -> xr.Dataset:
    import xarray as xr

    return xr.merge(parts, compat="no_conflicts", join="exact", combine_attrs="override")


def _points(points: xr.Dataset, prefix: str, dim: str) -> xr.Dataset:
    """Section points under the names ``prefix_displacement`` and ``prefix_velocity`` over ``dim``."""
    named = points[["displacement", "velocity"]].drop_vars("time").rename(repeat=dim)
    return named.rename(displacement=f"{prefix}_displacement", velocity=f"{prefix}_velocity")


def _long_run(model: ConeModel, late: xr.Dataset, preset: Preset, progress: MaybeProgress) -> xr.Dataset:
    """The time response that follows the last point of a section; NaN for a member that has failed before."""
    ends = np.stack([late[name].isel(repeat=-1).values for name in ("displacement", "velocity")], axis=-1)
    states = np.where(np.isfinite(ends), ends, np.asarray(preset.initial))
    run = _window(model, states, LATE_REPEATS * float(repeat_of(model).max()), "late", progress)
    ran = late["outcome"] == Outcome.OK
    return run if ran.all() else run.where(ran)


def _window(model: ConeModel, states: npt.ArrayLike, length: float, name: str, progress: MaybeProgress) -> xr.Dataset:
    """A time response from ``states`` with its extent and validity, named after the window that it covers."""
    times = np.linspace(0.0, length, round(length / SPACING) + 1)
    run = simulate(model, states, times=times, progress=progress)
    slack = (run["hoop_stress"] < 0.0) | (run["meridional_stress"] < 0.0)
    kept = run[["displacement", "velocity"]]
    kept = kept.assign(slack=slack.astype(np.int8).assign_attrs(_meaning("1 where the film is slack", "code")))
    shares = {str(n): f"{name}_{n}" for n in run if str(n).startswith("validity_") and n != "validity_breakdown"}
    ends = {"lowest": run["displacement"].min("time"), "highest": run["displacement"].max("time")}
    described = {
        f"{name}_validity_slack": kept["slack"].mean("time").assign_attrs(_meaning("share of slack film", "share"))
    } | {f"{name}_{end}": value.assign_attrs(_meaning(f"{end} displacement", "length")) for end, value in ends.items()}
    if name == "late":
        kept = kept.rename({n: f"late_{n}" for n in ("displacement", "velocity", "slack", "time")})
    else:
        kept = kept.assign(initial=run["initial"])
    return _merged(kept.assign(described), run[list(shares)].rename(shares))


def _finite(model: ConeModel, finite: tuple[Array, Array]) -> xr.Dataset:
    """The exponents over the window from the start as a Dataset."""
    values, running = finite
    variables = {
        "finite": (("exponent",), values, "Lyapunov exponents per unit time over the window", "rate"),
        "finite_time": (("window",), running[..., 0], "window length, from the start", "time"),
        "finite_exponent": (("window",), running[..., 1], "largest exponent over that window", "rate"),
    }
    return dataset.label(model, variables, options={}, title="")


def _about(
    result: xr.Dataset,
    model_from: xr.Dataset,
    preset: str,
    parameter: str,
    effort: Effort,
    options: Mapping[str, Any],
    title: str,
) -> xr.Dataset:
    """The result with the attributes of all studies."""
    result.attrs = dict(model_from.attrs) | {"title": title, "options": json.dumps(dict(options))}
    return result.assign_attrs(preset=preset, parameter=parameter, window=effort.window)


# --- statics and energies ---------------------------------------------------------------------------------------------


STATIC_VOLTAGES = (0.0, 1.0, 1.5)


def static(effort: Effort, progress: Progress) -> xr.Dataset:
    """Force over displacement and all equilibria at three constant voltages, and where the film is slack."""
    preset = find_preset("table1")
    result = static_curves(preset.model, STATIC_VOLTAGES)
    x, voltage = result["displacement"].values, result["constant_voltage"].values
    slack = _slack(preset.model, x, voltage[:, None]).astype(np.int8)
    dims = ("constant_voltage", "displacement")
    result["slack"] = (dims, slack, _meaning("1 where the film is slack", "code"))
    progress(1.0)
    return result.assign_attrs(preset=preset.name, parameter="constant_voltage")


def _slack(model: ConeModel, x: Array, voltage: Any) -> npt.NDArray[np.bool_]:
    """Where a true stress of a single actuator is compressive at a constant voltage."""
    lm, lh = model.stretches
    q = 1.0 + x * x
    meridional, hoop = lm * lm * q, lh * lh + 0.0 * x
    thickness = 1.0 / (meridional * hoop)
    response = model.law.response(model.strain(x), model.coefficients().law)
    return (np.minimum(meridional, hoop) - thickness) * response - voltage * voltage * q < 0.0


LIMITS = (1.0, 1.5, 2.0, 5.0, 10.0, 50.0, 100.0)
SURFACES = (1.0, 100.0)
WIDEST = 4.0


def energy(effort: Effort, progress: Progress) -> xr.Dataset:
    """Strain energy over displacement for seven stretch limits; energy without voltage over the phase plane for two."""
    preset = find_preset("fast")
    model = preset.model.replace(stretch_limit=np.array(LIMITS))
    reach = _reach(model)
    # The energy grows like a logarithm towards the limit: only ever closer points follow it up.
    near = (reach[:, None] * (1.0 - np.logspace(-3.0, -12.0, 10))).ravel()
    near = near[near < WIDEST]
    x = np.unique(np.concatenate([np.linspace(-WIDEST, WIDEST, 1601), near, -near]))
    c = model.coefficients(trailing=1)
    strains = model.strain(np.broadcast_to(x, (model.size, x.size)))
    inside = strains < np.array(LIMITS)[:, None]
    film = np.where(inside, model.law.energy(strains, c.law), np.nan)
    q = 1.0 + x * x
    force = np.where(inside, x * model.law.film_stiffness(q, c.A, c.B, c.G, c.law)[0], np.nan)
    over = {
        "film_energy": (("displacement",), film, "strain energy of the film, NaN beyond the stretch limit", "energy"),
        "film_force": (("displacement",), force, "its slope: the force of the film", "force"),
        "reach": ((), reach, "displacement at which the film reaches its stretch limit", "length"),
    }
    coords = {"displacement": (("displacement",), x, "displacement x = h/(b-a)", "length")}
    result = dataset.label(model, over, coords=coords, options={}, title="energies")
    result = result.swap_dims(member="stretch_limit").assign(_surfaces(preset.model))
    progress(1.0)
    return _about(result, result, preset.name, "stretch_limit", effort, {}, "energies")


def _reach(model: ConeModel) -> Array:
    """The displacement (members,) at which I1 - 3 = J, for a film that is not pre-stretched: q + 1/q - 2 = J."""
    limit = np.asarray(model.strain_limit())
    return np.sqrt(0.5 * (limit + np.sqrt(limit * (limit + 4.0))))


def _surfaces(base: ConeModel) -> dict[str, Any]:
    """Film, spring and kinetic energy over displacement and velocity, for a small and a large stretch limit."""
    x, velocity = np.linspace(-3.0, 3.0, 301), np.linspace(-3.0, 3.0, 121)
    model = base.replace(stretch_limit=np.array(SURFACES))
    displacements = np.broadcast_to(x, (model.size, x.size))
    inside = model.strain(displacements) < np.array(SURFACES)[:, None]
    potential = np.where(inside, model.energy(displacements), np.nan)
    total = potential[:, :, None] + 0.5 * velocity**2
    plane = ("surface_limit", "surface_displacement", "surface_velocity")
    return {
        "surface_energy": (plane, total, _meaning("energy of film, spring and motion without voltage", "energy")),
        "surface_limit": ("surface_limit", np.array(SURFACES), _meaning("stretch limit", "parameter of a surface")),
        "surface_displacement": ("surface_displacement", x, _meaning("displacement x = h/(b-a)", "length")),
        "surface_velocity": ("surface_velocity", velocity, _meaning("velocity of the disc", "velocity")),
    }


def _meaning(long_name: str, quantity: str) -> dict[str, str]:
    return {"long_name": long_name, "units": "1", "quantity": quantity}


# --- spectra ----------------------------------------------------------------------------------------------------------


SETS = ("base", "fast")


def spectra(effort: Effort, progress: Progress) -> xr.Dataset:
    """Spectra at three voltages of two parameter sets, over ``set`` and ``voltage``: at first and in the long run.

    The variables of `gelcone.spectrum` in the long run; the same with the prefix ``early_`` over the first 16 periods
    of the drive; and those of `gelcone.regime`.
    """
    voltages = np.array(TRIPLES["voltage"][2])
    presets = [find_preset(name) for name in SETS]
    stiffness = np.array([[preset.model.spring_stiffness] for preset in presets])
    omega = np.array([[preset.model.drive_frequency] for preset in presets])
    initial = presets[0].initial
    model = presets[0].model.replace(spring_stiffness=stiffness, drive_frequency=omega, voltage=voltages)
    kinds = regime(model, initial, progress=weighted(progress, 0.3))
    settled = int(np.ceil((kinds["settled_time"].values.ravel() / repeat_of(model)).max()))
    early = spectrum(model, initial, periods=FEWEST_PERIODS, discard=0, progress=weighted(progress, 0.1))
    late = spectrum(model, initial, periods=effort.spectrum_periods, discard=settled, progress=weighted(progress, 0.6))
    early = early.drop_vars(["initial", "outcome"])
    own = [str(name) for name in (*early.data_vars, "frequency", "frequency_ratio") if name in early]
    early = early.rename({name: f"early_{name}" for name in [*own, "line"]})
    parts = [kinds.drop_vars("section"), late.drop_vars("outcome"), early]
    result = _merged(*parts).drop_vars("voltage")
    attrs = kinds["voltage"].attrs
    result = result.rename(member_0="set", member_1="voltage").assign_coords(
        voltage=("voltage", voltages, attrs), set=("set", list(SETS), {"long_name": "parameter set"})
    )
    options = {"initial": list(initial), "periods": effort.spectrum_periods, "settled_repeats": settled}
    return _about(result, kinds, ", ".join(SETS), "voltage", effort, options, "spectra at three voltages")


# --- a device in volts and millimetres --------------------------------------------------------------------------------

VOLTS = np.linspace(10.0, 50.0, 9)
HEIGHTS = (0.0, 0.02)
SETTLED_DECAYS = 40.0
"""Decay times before the late amplitude is taken: the swing from the start is then lost to rounding."""


def practical(effort: Effort, progress: Progress) -> xr.Dataset:
    """A device of the paper's Table 1 at 10 to 50 V, in SI units, over ``initial_height`` and ``voltage_amplitude``.

    ``displacement`` over ``time`` from the release; ``window_amplitude`` (half of what it covers) from the start and
    ``late_amplitude`` in the long run, about ``late_middle``; ``pitchfork_voltage`` and ``onset_voltage`` (Floquet),
    where the flat film is at rest, ``pull_in_voltage`` for both; ``rest_displacement`` without voltage;
    ``largest_field`` and ``dielectric_strength`` (assumed); the shares ``window_validity_*``; and the variables of
    `gelcone.regime`, for which swings of less than a millionth of b - a are rest.
    """
    import xarray as xr

    base = find_device("paper-table1")
    parts = [
        _practical(base.replace(initial_height=height, voltage_amplitude=VOLTS), effort, weighted(progress, 0.5))
        for height in HEIGHTS
    ]
    heights = xr.DataArray(1e3 * np.array(HEIGHTS), dims="initial_height", name="initial_height")
    result = xr.concat(parts, heights, join="exact", combine_attrs="override")
    result["initial_height"].attrs = {"long_name": "height at which the spring is free", "units": "mm"}
    single = dataset.label(base.to_model(), {}, options={}, title="")
    options = {"release_height_mm": 40.0, "window": effort.window, "settled_decays": SETTLED_DECAYS}
    result = _about(result, single, "table1", "voltage_amplitude", effort, options, "a device at practical voltages")
    return result.assign_attrs(device=base.name)


def _practical(device: Device, effort: Effort, progress: MaybeProgress) -> xr.Dataset:
    model, state = device.to_model(), device.initial_state()
    times = np.linspace(0.0, effort.window, round(effort.window / SPACING) + 1)
    run = simulate(model, state, times=times, field_limit=device.breakdown_field(), progress=weighted(progress, 0.3))
    settle = SETTLED_DECAYS / float(np.asarray(model.damping_ratio))
    evidence = classify(model.take(slice(None)), np.tile(state, (model.size, 1)), transient=settle)
    late = _swing(model, evidence.final)
    kinds = label_evidence(model, evidence, {}, "").drop_vars(["section", "lowest", "highest"])
    shares = {str(n): f"window_{n}" for n in run if str(n).startswith("validity_")}
    window = run["displacement"]
    numbers: dict[str, dataset.Variable] = {
        "window_amplitude": ((), 0.5 * np.ptp(window.values, axis=1), "half the swing from the start", "length"),
        "late_amplitude": ((), late.amplitude, "half the swing in the long run", "length"),
        "late_middle": ((), late.middle, "middle of the swing in the long run", "length"),
        "largest_field": ((), run["true_field"].max("time").values, "largest true field from the start", "field"),
        "dielectric_strength": ((), np.asarray(device.breakdown_field()), "dielectric strength (assumed)", "field"),
    }
    result = _merged(
        kinds.assign(displacement=window),
        run[list(shares)].rename(shares),
        dataset.label(model, numbers | _thresholds(model), options={}, title=""),
    )
    if progress is not None:
        progress(0.7)
    in_volts = {"long_name": "voltage amplitude", "units": "V"}
    volts = np.asarray(device.voltage_amplitude)
    in_si = to_si(result, device).assign_coords(voltage_amplitude=("member", volts, in_volts))
    return in_si.swap_dims(member="voltage_amplitude")


def _thresholds(model: ConeModel) -> dict[str, dataset.Variable]:
    """Voltages at which rest is lost; a single one for all members, which differ in their voltage alone."""
    one = model.take([0])
    flat = not np.any(np.asarray(one.rest_height))
    lost = pull_in_voltage(one)
    onset = onset_voltage(one)["onset_voltage"].values[0] if flat else np.nan
    return {
        "pitchfork_voltage": ((), pitchfork_voltage(one)[0], "constant voltage at which flat rest is lost", "voltage"),
        "onset_voltage": ((), onset, "drive voltage at which flat rest is lost (Floquet)", "voltage"),
        "pull_in_voltage": ((), lost["pull_in_voltage"].values[0], "voltage at which a slow ramp is lost", "voltage"),
        "rest_displacement": ((), lost["rest_displacement"].values[0], "rest without voltage", "length"),
    }


# --- amplitude over drive frequency -----------------------------------------------------------------------------------

STIFFNESSES = (0.1, 0.5, 1.0, 5.0, 10.0, 20.0)
BAND = (0.05, 6.0)
"""Drive frequencies swept: from far below half the lowest natural frequency to above the highest one."""
SWEEPS = ("up", "down")
NUDGE = 1e-4
"""A sweep moves each state by this much before it goes on, lest it stays on a motion that has become unstable."""
SWING_REPEATS = 24
SWING_SAMPLES = 128
SETTLING_DECAYS = 20.0
SETTLING_ROUNDS = 6
NARROWINGS = 3
NARROWED_AT = 7
"""Frequencies inside a peak's bracket at which each narrowing looks; the bracket shrinks to a quarter."""


@dataclass(frozen=True)
class _Swing:
    """What settled motions cover, arrays over the same dims: ``lowest`` and ``highest`` displacement, between samples
    as well; the ``period`` in drive repeats (0: none found); the ``outcome``; and (..., 2) the ``final`` states."""

    lowest: Array
    highest: Array
    period: npt.NDArray[np.int64]
    outcome: npt.NDArray[np.int8]
    final: Array

    @classmethod
    def blank(cls, *shape: int) -> _Swing:
        whole, code = np.zeros(shape, dtype=np.int64), np.zeros(shape, dtype=np.int8)
        return cls(np.full(shape, np.nan), np.full(shape, np.nan), whole, code, np.full((*shape, 2), np.nan))

    def put(self, where: Any, other: _Swing) -> None:
        for field in fields(self):
            getattr(self, field.name)[where] = getattr(other, field.name)

    @property
    def amplitude(self) -> Array:
        return 0.5 * (self.highest - self.lowest)

    @property
    def middle(self) -> Array:
        return 0.5 * (self.highest + self.lowest)


def _swing(model: ConeModel, states: Array) -> _Swing:
    """Follows a flattened ensemble from ``states`` at phase 0 of the drive over `SWING_REPEATS` repeats."""
    ticks = np.arange(1, SWING_REPEATS * SWING_SAMPLES + 1) / SWING_SAMPLES
    run = integrate(model, states, repeat_of(model)[:, None] * ticks)
    x, points = run.states[..., 0], run.states[:, SWING_SAMPLES - 1 :: SWING_SAMPLES]
    period, _ = periods_of(points)
    return _Swing(-_highest(-x), _highest(x), period, run.outcome, points[:, -1])


def _highest(x: Array) -> Array:
    """Largest value of each row (members, samples), by the parabola through the largest sample and its neighbours."""
    at = np.clip(np.argmax(x, axis=1), 1, x.shape[1] - 2)
    before, here, after = (np.take_along_axis(x, at[:, None] + k, axis=1)[:, 0] for k in (-1, 0, 1))
    curvature = before - 2.0 * here + after
    rise = (before - after) ** 2 / np.where(curvature < 0.0, -8.0 * curvature, np.inf)
    return np.maximum(here + rise, x.max(axis=1))


def _settled_swing(model: ConeModel, states: Array) -> _Swing:
    """The swing after a transient; a motion whose section points do not return is given more time, up to a limit."""
    swing = _Swing.blank(model.size)
    swing.final[:] = states
    open_ = np.arange(model.size)
    for trial in range(SETTLING_ROUNDS):
        part = model.take(open_)
        repeat = repeat_of(part)
        span = SETTLING_DECAYS * 2 ** max(trial - 1, 0) / np.asarray(part.damping_ratio)
        run = integrate(part, swing.final[open_], (np.ceil(span / repeat) * repeat)[:, None])
        ran = run.outcome == Outcome.OK
        swing.outcome[open_] = run.outcome
        part, open_ = part.take(ran), open_[ran]
        if open_.size:
            swing.put(open_, _swing(part, run.states[ran, 0]))
            open_ = open_[(swing.period[open_] == 0) & (swing.outcome[open_] == Outcome.OK)]
        if not open_.size:
            break
    return swing


def frequency(effort: Effort, progress: Progress) -> xr.Dataset:
    """Amplitude over drive frequency for six spring stiffnesses, in a sweep up and one down.

    Dataset over ``spring_stiffness``, ``sweep`` and ``step``, whose drive frequency is ``swept_frequency``
    (spring_stiffness, step), closer together around half the ``natural_frequency`` and around it: ``amplitude`` (half
    of what the settled motion covers), ``lowest``, ``highest``, ``period`` in drive repeats (0: none up to 16) and
    ``outcome``. Over ``spring_stiffness`` and ``sweep`` the highest peak: ``peak_frequency`` between ``peak_low`` and
    ``peak_high``, ``peak_amplitude`` with ``peak_amplitude_error``.
    """
    preset = find_preset("spring")
    single = preset.model.replace(spring_stiffness=np.array(STIFFNESSES))
    natural = natural_frequencies(single)
    grid = _frequencies(natural, float(np.asarray(single.damping_ratio)), effort.frequencies)
    # One member for each stiffness and sweep, the sweep varying fastest.
    model = preset.model.replace(spring_stiffness=np.repeat(STIFFNESSES, len(SWEEPS)))
    grids = np.repeat(grid, len(SWEEPS), axis=0)
    swept = _sweep(model, grids, preset, weighted(progress, 0.8))
    peaks = _peaks(model, grids, swept, weighted(progress, 0.2))
    result = _label_sweep(single, natural, grid, swept, peaks)
    options = {"initial": list(preset.initial), "nudge": NUDGE}
    return _about(result, result, preset.name, "drive_frequency", effort, options, "amplitude over drive frequency")


def natural_frequencies(model: ConeModel) -> Array:
    """Frequencies of small swings about the stable equilibrium under the drive's mean-square voltage, (members,)."""
    at = static_curves(model, float(np.asarray(model.voltage)) / np.sqrt(2.0)).isel(constant_voltage=0)
    return np.sqrt(at["slope"].where(at["stable"]).max("equilibrium").values)


def _frequencies(natural: Array, damping: float, count: int) -> Array:
    """Drive frequencies (members, count): even ones on a log scale, and more around the resonances.

    The force has twice the drive's frequency, so the disc resonates at half its natural frequency; at the natural
    frequency itself the drive excites parametrically.
    """
    near_half, near_whole = int(0.35 * count), int(0.25 * count)
    even = np.geomspace(*BAND, count - near_half - near_whole)
    return np.stack(
        [
            np.sort(
                np.concatenate(
                    [
                        even,
                        0.5 * own + _around(min(4.0 * damping, 0.35 * own), near_half),
                        own + _around(min(8.0 * damping, 0.4 * own), near_whole),
                    ]
                )
            )
            for own in natural
        ]
    )


def _around(reach: float, count: int) -> Array:
    """Offsets up to ``reach`` to either side, closer together in the middle."""
    u = np.linspace(-1.0, 1.0, count)
    return reach * (0.3 * u + 0.7 * u**3)


def _sweep(model: ConeModel, grids: Array, preset: Preset, progress: MaybeProgress) -> _Swing:
    """Swings (members, steps) at the frequencies ``grids``; odd members are swept down."""
    count = grids.shape[1]
    down = np.arange(model.size) % len(SWEEPS) == 1
    swept = _Swing.blank(*grids.shape)
    members, states = np.arange(model.size), np.tile(preset.initial, (model.size, 1))
    for k in range(count):
        step = np.where(down, count - 1 - k, k)
        swing = _settled_swing(model.replace(drive_frequency=grids[members, step]), states)
        swept.put((members, step), swing)
        lost = (swing.outcome != Outcome.OK)[:, None]
        states = np.where(lost, preset.initial, swing.final + np.array([NUDGE, 0.0]))
        if progress is not None:
            progress(1.0 / count)
    return swept


@dataclass(frozen=True)
class _Peaks:
    """Highest peak of each sweep, arrays (members,)."""

    frequency: Array
    low: Array
    high: Array
    amplitude: Array
    error: Array


def _peaks(model: ConeModel, grids: Array, swept: _Swing, progress: MaybeProgress) -> _Peaks:
    """Narrows down the highest point of each sweep between its neighbours, starting from the motion there."""
    members, amplitude = np.arange(model.size), np.where(np.isnan(swept.amplitude), -1.0, swept.amplitude)
    best = amplitude.argmax(axis=1)
    around = np.clip(best[:, None] + np.array([-1, 0, 1]), 0, grids.shape[1] - 1)
    low, at, high = grids[members[:, None], around].T
    height, error = amplitude[members, best], np.full(model.size, np.inf)
    state = swept.final[members, best]
    shares = np.arange(1, NARROWED_AT + 1) / (NARROWED_AT + 1)
    for _ in range(NARROWINGS):
        tried = low[:, None] + (high - low)[:, None] * shares
        ensemble = model.take(np.repeat(members, NARROWED_AT)).replace(drive_frequency=tried.ravel())
        swing = _settled_swing(ensemble, np.repeat(state, NARROWED_AT, axis=0))
        # What was highest before stays in the race, lest a narrow peak is lost between the new frequencies.
        heights = np.column_stack([swing.amplitude.reshape(tried.shape), height])
        places, finals = np.column_stack([tried, at]), swing.final.reshape(*tried.shape, 2)
        finals = np.concatenate([finals, state[:, None]], axis=1)
        first, second = np.argsort(-np.nan_to_num(heights, nan=-1.0), axis=1, kind="stable")[:, :2].T
        at, height, state = places[members, first], heights[members, first], finals[members, first]
        # Neither the frequencies nor the settling tell heights apart any closer.
        error = height - heights[members, second] + RETURN_TOLERANCE * np.abs(swept.highest[members, best])
        edges = np.column_stack([low, np.sort(places, axis=1), high])
        low = np.where(edges < at[:, None], edges, -np.inf).max(axis=1, initial=-np.inf)
        high = np.where(edges > at[:, None], edges, np.inf).min(axis=1, initial=np.inf)
        if progress is not None:
            progress(1.0 / NARROWINGS)
    return _Peaks(at, low, high, height, error)


def _label_sweep(model: ConeModel, natural: Array, grid: Array, swept: _Swing, peaks: _Peaks) -> xr.Dataset:
    import xarray as xr

    shape = (model.size, len(SWEEPS))
    each, peak = ("sweep", "step"), ("sweep",)
    variables: dict[str, dataset.Variable] = {
        "natural_frequency": ((), natural, "frequency of small swings at the mean-square voltage", "frequency"),
        "amplitude": (each, _split(swept.amplitude), "half of what the settled motion covers", "length"),
        "lowest": (each, _split(swept.lowest), "lowest displacement", "length"),
        "highest": (each, _split(swept.highest), "highest displacement", "length"),
        "period": (each, _split(swept.period), "period in drive repeats, 0 if none", "count"),
        "peak_frequency": (peak, peaks.frequency.reshape(shape), "drive frequency of the highest peak", "frequency"),
        "peak_low": (peak, peaks.low.reshape(shape), "the peak lies above this frequency", "frequency"),
        "peak_high": (peak, peaks.high.reshape(shape), "the peak lies below this frequency", "frequency"),
        "peak_amplitude": (peak, peaks.amplitude.reshape(shape), "amplitude at the peak", "length"),
        "peak_amplitude_error": (peak, peaks.error.reshape(shape), "error of the amplitude at the peak", "length"),
    }
    coords: dict[str, dataset.Variable] = {"swept_frequency": (("step",), grid, "drive frequency", "frequency")}
    result = dataset.label(model, variables, coords=coords, options={}, title="").swap_dims(member="spring_stiffness")
    result["outcome"] = dataset.outcome_array(_split(swept.outcome), ("spring_stiffness", *each))
    return result.assign_coords(sweep=xr.DataArray(list(SWEEPS), dims="sweep"))


def _split(values: Any) -> Any:
    """(members, ...) as (stiffness, sweep, ...)."""
    return values.reshape(-1, len(SWEEPS), *values.shape[1:])


RESPONSE_STIFFNESS = 1.0
RESPONSES = (0.7, 1.0, 1.5)
"""Drive frequencies of the responses, over that of the forced resonance, half the natural frequency."""


def frequency_responses(effort: Effort, progress: Progress) -> xr.Dataset:
    """Motions below, at and above the forced resonance of one stiffness, see `motions`."""
    preset = find_preset("spring")
    one = preset.model.replace(spring_stiffness=np.array([RESPONSE_STIFFNESS]))
    resonance = 0.5 * natural_frequencies(one)[0]
    model = preset.model.replace(spring_stiffness=RESPONSE_STIFFNESS, drive_frequency=resonance * np.array(RESPONSES))
    return motions(preset, model, "drive_frequency", effort, progress)


STUDIES: tuple[Study, ...] = (
    Study("static", static, work=0.5),
    Study("energy", energy, work=0.1),
    *(Study(name, partial(triple, name)) for name in TRIPLES),
    Study("spectra", spectra, work=3.0),
    Study("practical", practical, work=0.5),
    Study("frequency", frequency, work=3.5),
    Study("frequency-responses", frequency_responses, work=0.5),
)

"""Analyses of every draw of uncertain parameters, which propagate the uncertainty of a fit to results.

Where films differ between draws, membranes are made of a few of them alone, see
`gelcone.physics.film.interpolated_pull_in`.
"""

from __future__ import annotations

import json
import reprlib
from collections.abc import Callable, Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from gelcone import dataset
from gelcone.atlas.frequency import frequency
from gelcone.atlas.hysteresis import BRANCHES
from gelcone.atlas.plan import Plan
from gelcone.atlas.record import over_axes
from gelcone.atlas.sweep import sweep
from gelcone.atlas.workers import threads as in_threads
from gelcone.codes import Outcome
from gelcone.dataset import Variable
from gelcone.devices.analysis import plain, state_of
from gelcone.devices.points import at
from gelcone.devices.scales import MEASURES
from gelcone.devices.si import shown_values, to_si
from gelcone.devices.units import parse_many
from gelcone.errors import InputError, check_name, unknown_name
from gelcone.motion.driven import driven
from gelcone.motion.envelope import (
    MARGIN,
    SECOND,
    plane_of,
    positive_axis,
    recommended_peaks,
    said_in_proportion,
    second_voltage,
)
from gelcone.motion.plane import DRIVEN_LIMITS, Plane
from gelcone.motion.static_limits import STATIC_LIMITS, peaks_of, static_limits_of
from gelcone.physics.film.interpolated_pull_in import interpolated_curves
from gelcone.physics.model import ConeModel, single
from gelcone.progress import Counted, Progress, advance, weighted
from gelcone.quantity import Array
from gelcone.register.analyses import find_analysis, sweepable
from gelcone.statistics import spread

if TYPE_CHECKING:
    import xarray as xr

    from gelcone.devices.device import Device

ALONE = ("envelope", "frequency")
"""Analyses over an axis of their own, which run once per draw."""
SHEET = "datasheet"
AT_ONCE = 16
"""Draws whose frequency responses are computed together."""
DRAWN_SHARE = 0.95
"""Share of the progress for the draws, after the axis that they share."""


def over_draws(
    model: ConeModel | Device,
    draws: Any,
    analysis: str = "limits",
    *,
    initial: Any = None,
    threads: int | None = None,
    progress: Progress = None,
    **options: Any,
) -> xr.Dataset:
    """Run an analysis of every draw of uncertain parameters, correlated as they are drawn.

    Where many films differ, membranes are made of some of them alone, and pull-in voltages are interpolated between
    these; the attribute ``membranes`` states of how many, and the error. `gelcone.sweep` of a plan with draws makes one
    membrane for each draw.

    Parameters
    ----------
    model : a single model or `Device`; what is drawn replaces its own.
    draws : name -> values, as many of each, as in `Plan`; or a Dataset of `gelcone.fitted_draws`.
    analysis : one that can be swept, ``"envelope"``, ``"frequency"`` or ``"datasheet"``. Default ``"limits"``.
    initial : as in `Plan`; not of an envelope or a data sheet, which have starts of their own.
    threads : worker threads; default one a core. Does not change a bit of the result.
    progress : called with the share of the work just done (the shares add up to 1).
    **options : of the analysis, in SI units with a device. An envelope takes ``frequencies``, ``peaks``, ``margin``
        and ``limits_from``, and a frequency response ``frequencies``, ``transient``, ``patience`` and ``tolerance``;
        all draws share the axis, by default that of the model without its additions. A data sheet takes ``voltages``.

    Returns
    -------
    Dataset over ``draw``: as of `gelcone.sweep`; of an envelope ``recommended_peak``, ``first_limit``,
    ``limit_low`` and ``limit_high`` over ``drive_frequency``, ``static_limit_voltage`` and ``recommended_constant``; of
    a frequency response what `gelcone.frequency` gives, with the number of ``jumps`` in their place. ``outcome`` says
    which draws failed. Of a data sheet that of the model, with the 95 % interval of each figure over the draws as
    ``NAME_low`` and ``NAME_high``, and the standard deviation of each field over its mean as the attribute ``drawn``;
    where that is above 1, mean and standard deviation.

    Raises
    ------
    InputError : as `Plan`, for draws without names, an unknown analysis, options that it does not take of draws, and if
        all draws of an envelope or a frequency response are refused.

    Examples
    --------
    >>> import gelcone
    >>> model = gelcone.ConeModel(voltage=0.3, voltage_bias=0.6, rest_height=0.8, hoop_prestretch=1.4)
    >>> draws = gelcone.draw({"spring_stiffness": gelcone.Uniform(0.9, 1.1)}, 4)
    >>> window = gelcone.over_draws(model, draws, "envelope", frequencies=[0.6, 0.8], peaks=[0.5, 1.0])
    >>> low, high = window.recommended_peak.quantile([0.025, 0.975], "draw").sel(drive_frequency=0.6).values.round(3)
    >>> f"{low} to {high}"
    '0.701 to 0.727'
    """
    if not hasattr(draws, "keys"):
        raise InputError(
            f"draws = {reprlib.repr(draws)}: must be name -> values or a Dataset; read a file with pandas.read_csv or "
            "xarray.open_dataset"
        )
    values = {str(n): v.values for n, v in draws.data_vars.items()} if hasattr(draws, "data_vars") else dict(draws)
    analyses = (*sweepable(), *ALONE, SHEET)
    check_name("analysis of draws", analysis, analyses)
    if initial is not None and analysis in ("envelope", SHEET):
        raise InputError(f"initial: {analysis} has a start of its own; leave it out")
    plan = Plan(model, {}, initial, values, {} if analysis in (*ALONE, SHEET) else options)
    members = plan.possible()[1].members()
    with interpolated_curves(members) as between:
        if analysis == SHEET:
            analysed = _sheet(plan, options, threads, progress)
        elif analysis not in ALONE:
            analysed = sweep(plan, analysis, workers=in_threads(threads), progress=progress)
        else:
            run = _windows if analysis == "envelope" else _responses
            errors = dataset.film_errors(members)
            analysed = _labelled(plan, analysis, errors, *run(plan, options, threads, progress))
            analysed = said_in_proportion(analysed, plan.cone.system) if analysis == "envelope" else analysed
    analysed = analysed.assign_attrs(membranes=json.dumps(None if between is None else vars(between)))
    return analysed if plan.device is None else to_si(analysed, plan.device)


def _size(plan: Plan, quantity: str) -> Array:
    """The unit of a quantity in SI, (draws,); 1 without a device."""
    scale: Any = 1.0 if plan.device is None else at(plan.device, plan.grid).scales.size(quantity)
    return np.broadcast_to(np.asarray(scale, dtype=float), (plan.size,))


def _axis(plan: Plan, name: str, quantity: str, given: Any, default: Any) -> tuple[Array, Array]:
    """An axis that all draws share, in SI, and dimensionless for each draw; ``default`` gives that of the model."""
    own = 1.0 if plan.device is None else float(plan.device.scales.size(quantity))
    if given is None:
        given = np.asarray(default(), dtype=float) * own
    elif plan.device is not None:
        given = parse_many(name, given, MEASURES[quantity].unit)
    shared = positive_axis(name, given)
    return shared, shared / _size(plan, quantity)[:, None]


def _labelled(
    plan: Plan,
    analysis: str,
    errors: Mapping[str, float],
    variables: Mapping[str, Variable],
    outcome: Array,
    options: Mapping[str, Any],
) -> xr.Dataset:
    """The result of all draws. Variables are (draws, ...) with the dims after the draws given, or common to all."""
    scales = None if plan.device is None else at(plan.device, plan.grid).scales
    columns: dict[str, Any] = {}
    for name, (dims, values, meaning, of) in variables.items():
        attrs: Any = dataset.attributes(meaning, of)
        column = np.asarray(values)
        is_per_draw = column.ndim == len(dims) + 1
        if is_per_draw and scales is not None:
            column, attrs = shown_values(column, attrs, scales)
        columns[name] = (("draw", *dims) if is_per_draw else dims, column, attrs)
    result = over_axes(plan, columns, options, f"draws: {analysis}", errors)
    result["outcome"] = dataset.outcome_array(outcome.astype(np.int8), ("draw",))
    return result.assign_attrs(analysis=analysis)


def _shown_frequencies(values: Array, device: Device | None) -> dict[str, Variable]:
    """The axis of drive frequencies as a variable, in the unit in which it is read."""
    if device is None:
        return {"drive_frequency": (("drive_frequency",), values, "drive frequency", "frequency")}
    measure = MEASURES["frequency"]
    attrs = {"units": measure.shown, "quantity": "frequency"}
    return {"drive_frequency": (("drive_frequency",), values * measure.per_unit, "drive frequency", attrs)}


Result = tuple[dict[str, Variable], Array, dict[str, Any]]


# --- envelopes --------------------------------------------------------------------------------------------------------


def _windows(plan: Plan, options: Mapping[str, Any], threads: int | None, progress: Progress) -> Result:
    """The limits of every draw over the drive frequency, as `gelcone.envelope` finds them.

    Raises the `InputError` of the last draw if all are refused.
    """
    taken = {"frequencies": None, "peaks": None, "margin": MARGIN, "limits_from": "rest"}
    settings = _options("envelope", options, taken)
    if not 0.0 <= settings["margin"] < 1.0:
        raise InputError(f"margin = {settings['margin']:g}: must be at least 0 and below 1")
    from_ = settings["limits_from"]
    nominal, members = plan.cone, plan.at(plan.grid)[0].members()
    opposite = nominal.system.in_opposite_phase
    default = plane_of(nominal, threads, from_).default_frequencies
    hertz, omegas = _axis(plan, "frequencies", "frequency", settings["frequencies"], default)
    peaks: Sequence[Array | None] = [None] * plan.size
    if settings["peaks"] is not None:
        peaks = [*_axis(plan, "peaks", "voltage", settings["peaks"], None)[1]]
    of_limit, count = (len(DRIVEN_LIMITS), hertz.size), plan.size
    low, high = np.full((2, count, *of_limit), np.nan)
    recommended, static = np.full((count, hertz.size), np.nan), np.full((count, len(STATIC_LIMITS)), np.nan)
    constant, second, top = np.full((3, count), np.nan)
    outcome = np.full(count, Outcome.OK)
    for row in range(count):
        counted = Counted(weighted(progress, 1.0 / count))
        try:
            plane = plane_of(single(members, row), threads, from_)
            limits, static[row], volts = _window(plane, omegas[row], peaks[row], counted)
        except InputError as error:
            outcome[row], refused = Outcome.ERROR, error
            counted.finish()
            continue
        low[row], high[row] = limits["low"].T, limits["high"].T
        lowest = np.nanmin(static[row], initial=np.inf)
        recommended[row] = recommended_peaks(limits["low"], lowest, volts, settings["margin"])
        top[row] = volts[-1]
        constant[row] = (1.0 - settings["margin"]) * min(lowest, top[row])
        second[row] = second_voltage(plane, constant[row]) if opposite else np.nan
        counted.finish()
    if (outcome == Outcome.ERROR).all():
        raise refused
    least = np.where(np.isnan(low), np.inf, low)
    first = np.where(np.isfinite(least.min(axis=1)), least.argmin(axis=1), -1)
    along, each = ("drive_frequency",), ("driven_limit", "drive_frequency")
    variables: dict[str, Variable] = {
        "recommended_peak": (along, recommended, "recommended highest peak voltage", "voltage"),
        "first_limit": (along, first, "index of the limit that comes first, -1 if none", "code"),
        "limit_low": (each, low, "lower end of the interval of the limit's peak voltage", dataset.absent("voltage")),
        "limit_high": (each, high, "upper end of the interval of the limit's peak voltage", dataset.absent("voltage")),
        "static_limit_voltage": (
            ("static_limit",), static, "voltage of the quasi-static limit", dataset.absent("voltage"),
        ),
        "recommended_constant": ((), constant, "recommended highest constant voltage", "voltage"),
        "operating_peak_voltage": ((), members.peak_voltage, "peak voltage of the device's drive", "voltage"),
        "operating_frequency": ((), members.values["drive_frequency"], "frequency of its drive", "frequency"),
    }  # fmt: skip
    if opposite:
        variables["recommended_second_voltage"] = ((), second, *SECOND)
    variables |= _shown_frequencies(hertz, plan.device)
    variables |= {
        "static_limit": (("static_limit",), np.array(STATIC_LIMITS), "quasi-static limit", "code"),
        "driven_limit": (("driven_limit",), np.array(DRIVEN_LIMITS), "limit of the driven motion", "code"),
    }
    highest = float(np.fmax.reduce(top * _size(plan, "voltage")))
    return variables, outcome, {"margin": settings["margin"], "limits_from": from_, "highest_peak": highest}


def _window(
    plane: Plane, omegas: Array, peaks: Array | None, progress: Progress
) -> tuple[dict[str, Array], Array, Array]:
    """The driven limits of one draw, its quasi-static ones, and the peak voltages examined, by default its own."""
    static = static_limits_of(plane)
    volts = peaks_of(plane, static) if peaks is None else peaks
    return driven(plane, omegas, volts, refine=False, progress=progress, pull_in=static[-1]), static, volts


def _options(analysis: str, given: Mapping[str, Any], taken: Mapping[str, Any]) -> dict[str, Any]:
    """The options of an analysis of draws with defaults ``taken``; raises `InputError` for one not among these."""
    for name in given:
        if name not in taken:
            known = find_analysis(analysis).signature.parameters
            if name in known:
                raise InputError(f"{name}: is not computed for draws; leave it out, or run {analysis} of one device")
            raise unknown_name(f"option of {analysis} of draws", name, taken)
    return dict(taken) | dict(given)


# --- frequency responses ----------------------------------------------------------------------------------------------


def _responses(plan: Plan, options: Mapping[str, Any], threads: int | None, progress: Progress) -> Result:
    """The frequency responses of all draws over the same frequencies."""
    import xarray as xr

    taken = {"frequencies": None, "transient": None, "patience": None, "tolerance": None}
    settings = {name: value for name, value in _options("frequency", options, taken).items() if value is not None}
    alone = plain(frequency)

    def default() -> Array:
        start = plan.initial if plan.device is None else state_of(plan.device, plan.initial)
        nominal = alone(plan.cone, initial=start, threads=threads)
        return np.asarray(nominal["drive_frequency"].values)

    hertz, omegas = _axis(plan, "frequencies", "frequency", settings.pop("frequencies", None), default)
    times: dict[str, Any] = {name: settings.pop(name) for name in ("transient", "patience") if name in settings}
    settings |= _times(plan, times)
    model, states = plan.at(plan.grid)
    if np.ndim(model.drive_frequency):
        model = model.replace(drive_frequency=float(plan.cone.drive_frequency))
    advance(progress, 1.0 - DRAWN_SHARE)

    def of(rows: Array, share: Progress = None) -> xr.Dataset:
        models = model.replace(**{n: np.asarray(v)[rows] for n, v in model.values.items() if np.ndim(v)})
        response = alone(models, omegas[rows], states[rows, :2], threads=threads, progress=share, **settings)
        jumps = np.bincount(response["jump_member"].values.astype(int), minlength=rows.size)
        return response.drop_dims("jump").assign(jumps=("member", jumps))

    parts = _parts(of, plan.size, weighted(progress, DRAWN_SHARE))
    whole = xr.concat(parts, dim="member", join="override")
    variables: dict[str, Variable] = {"jumps": ((), whole["jumps"].values, "number of jumps of its sweeps", "count")}
    for name, variable in whole.data_vars.items():
        dims = tuple("drive_frequency" if dim == "step" else str(dim) for dim in variable.dims if dim != "member")
        if name not in variables and name != "outcome":
            variables[str(name)] = dims, variable.values, "", dict(variable.attrs)
    outcome = whole["outcome"].transpose("member", ...).values.reshape(plan.size, -1)
    variables |= _shown_frequencies(hertz, plan.device)
    variables["branch"] = ("branch",), np.array(BRANCHES), "sweep", "code"
    return variables, outcome[np.arange(plan.size), (outcome != Outcome.OK).argmax(axis=1)], {}


def _parts(of: Callable[..., xr.Dataset], count: int, progress: Progress) -> list[xr.Dataset]:
    """Results of the function ``of`` for all draws, some at once; NaN with `Outcome.ERROR` for a draw that it refuses.

    Raises the `InputError` of the last draw if all are refused.
    """
    parts: list[xr.Dataset | None] = []
    for rows in np.split(np.arange(count), range(AT_ONCE, count, AT_ONCE)):
        counted = Counted(weighted(progress, rows.size / count))
        try:
            parts.append(of(rows, counted))
        except InputError:
            for row in rows:
                try:
                    parts.append(of(np.array([row])))
                except InputError as error:
                    parts.append(None)
                    refused = error
        counted.finish()
    good_parts = [part for part in parts if part is not None]
    if not good_parts:
        raise refused
    part = good_parts[0].isel(member=[0])
    missing = part.map(lambda array: array.where(False) if array.dtype.kind == "f" else array * 0, keep_attrs=True)
    missing["outcome"] = part["outcome"] * 0 + Outcome.ERROR
    return [missing if part is None else part for part in parts]


def _times(plan: Plan, given: Mapping[str, Any]) -> dict[str, Any]:
    """Budgets of time, dimensionless; for each draw at least as long as given."""
    return dict(Plan(plan.model, {}, None, plan.draws, given).options) if given else {}


# --- data sheets ------------------------------------------------------------------------------------------------------


def _sheet(plan: Plan, options: Mapping[str, Any], threads: int | None, progress: Progress) -> xr.Dataset:
    """The data sheet of the model, with the ends of the intervals of its figures over the draws."""
    settings, made = _options(SHEET, options, {"voltages": None}), find_analysis(SHEET).call
    sheet = made(plan.model, settings["voltages"], threads=threads)
    volts = sheet["constant_voltage"].values[1:]
    volts = volts if plan.device is None else volts / MEASURES["voltage"].per_unit
    names = [
        str(n) for n, v in sheet.data_vars.items() if v.dims in ((), ("constant_voltage",)) and v.dtype.kind == "f"
    ]
    rows: dict[str, list[Array]] = {name: [] for name in names}
    failed = 0
    for k in range(plan.size):
        values = {name: float(drawn[k]) for name, drawn in plan.draws.items()}
        try:
            device = plan.device
            model = plan.cone.replace(**values) if device is None else device.replace_quietly(values)
            draw_sheet = made(model, volts, threads=threads)
        except InputError:
            draw_sheet, failed = None, failed + 1
        for name, column in rows.items():
            column.append(np.full_like(sheet[name].values, np.nan) if draw_sheet is None else draw_sheet[name].values)
        advance(progress, 1.0 / plan.size)
    for name, column in rows.items():
        for end, values in zip(("low", "high"), spread(column)[[0, 2]], strict=True):
            sheet[f"{name}_{end}"] = sheet[name].dims, values, dict(sheet[name].attrs)
    widths = {name: _spread(drawn) for name, drawn in plan.draws.items()}
    return sheet.assign_attrs(draws=plan.size, drawn=json.dumps(widths), failed=failed)


def _spread(drawn: Array) -> float | list[float]:
    """The standard deviation over the mean; both of them where the mean is the smaller one."""
    mean, deviation = float(np.mean(drawn)), float(np.std(drawn))
    return deviation / abs(mean) if abs(mean) > deviation else [mean, deviation]

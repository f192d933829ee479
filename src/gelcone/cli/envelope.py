"""`gelcone envelope`."""

from __future__ import annotations

import itertools
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click
import numpy as np

from gelcone.cli.options import Subject, output_options, read_subject, subject_options
from gelcone.cli.output import check_folder, common_json, deliver, heading, progress_bar
from gelcone.cli.sweeps import over_option, read_over
from gelcone.errors import InputError
from gelcone.words import unit_of

if TYPE_CHECKING:
    import xarray as xr

NAME = "envelope"
AXES = {"voltage": "peaks", "drive_frequency": "frequencies"}
STATIC = ("peak_voltage", "stroke", "blocked_force", "natural_frequency")
DRIVEN = ("driven_peak", "driven_stroke", "driven_power", "driven_apparent_power")
WINDOW = ("drive_frequency", "recommended_peak", "window_stroke", "window_power", "window_apparent_power")


@click.command(NAME)
@subject_options
@over_option(
    "Frequencies or peak voltages that are looked at in place of the default ones: drive_frequency=from:to:count, "
    "voltage=from:to:count."
)
@click.option("--margin", type=float, default=0.2, show_default=True, help="Share kept below the lowest limit.")
@output_options
def command(
    device: str | None,
    settings: tuple[str, ...],
    initial: str | None,
    over: tuple[str, ...],
    margin: float,
    out: Path | None,
    force: bool,
    as_json: bool,
) -> None:
    """Where a device is safe to drive: limits over voltage and frequency, which comes first, a recommended window.

    \b
    gelcone envelope biased-pump --out results
    gelcone envelope my-device.toml --over "drive_frequency=5 Hz:20 Hz:31" --margin 0.3 --json
    """
    if initial is not None:
        raise InputError("--initial: an envelope starts from the device's rest; leave it out")
    subject = read_subject(device, settings, None)
    axes = read_over(over, subject.device)
    for name in axes:
        if name not in AXES:
            raise InputError(f"--over {name}: an envelope is over drive_frequency and voltage; leave it out")
    check_folder(out, NAME, force)
    from gelcone.motion.envelope import envelope
    from gelcone.plots.envelope import envelope_figure

    options: Any = {AXES[name]: values for name, values in axes.items()}
    field_limit = subject.device.breakdown_field() if subject.device else None
    with progress_bar(NAME, hidden=as_json) as progress:
        result = envelope(subject.model, field_limit=field_limit, margin=margin, progress=progress, **options)
    deliver(
        NAME,
        result,
        subject,
        figure=envelope_figure,
        report=report,
        summary=summary,
        out=out,
        force=force,
        as_json=as_json,
    )


def report(result: xr.Dataset, shown: xr.Dataset, subject: Subject) -> dict[str, Any]:
    """The JSON object; voltages, frequencies and so on in SI units for a device."""
    from gelcone.codes import Regime

    values = (*STATIC, *DRIVEN, *WINDOW, "recommended_constant")
    common = common_json(result.drop_vars("outcome").assign(outcome=0), subject)
    static = zip(names(shown, "static_limit"), shown["static_limit_voltage"].values, strict=True)
    return {
        **{k: v for k, v in common.items() if k != "outcome"},
        "units": {name: shown[name].attrs["units"] for name in values},
        "static_limits": {name: reading(name, voltage) for name, voltage in static},
        "driven_limits": {
            name: reading(name, np.nan)
            if np.isnan(shown["limit_low"].values[i]).all()
            else {"low": shown["limit_low"].values[i], "high": shown["limit_high"].values[i]}
            for i, name in enumerate(names(shown, "driven_limit"))
        },
        "first_limit": [first_name(shown, i) for i in shown["first_limit"].values],
        "window_motion": [None if r != r else Regime(int(r)).label for r in shown["window_regime"].values],
        **{name: shown[name] for name in values},
    }


def names(shown: xr.Dataset, dim: str) -> list[str]:
    """The names along a dim of limits."""
    return [str(name) for name in shown[dim].values]


def first_name(shown: xr.Dataset, index: int) -> str | None:
    """Name of the driven limit that comes first, None where none does."""
    return None if index < 0 else names(shown, "driven_limit")[int(index)]


def reading(name: str, voltage: float) -> float | str:
    """A limit's voltage, or in words why it has none."""
    if np.isnan(voltage):
        return "unknown" if name == "dielectric breakdown" else "not applicable"
    return "not reached" if np.isinf(voltage) else float(voltage)


# --- text -------------------------------------------------------------------------------------------------------------


def summary(shown: xr.Dataset, subject: Subject) -> str:
    """What an engineer pins to the wall: all limits, the window over frequency with what it yields, the own drive."""
    return "\n".join([*heading(subject), *limits_table(shown), *static_lines(shown), *window_table(shown)])


def limits_table(shown: xr.Dataset) -> Iterator[str]:
    """Each limit at a constant voltage, and the lowest peak voltage at which a driven motion meets it."""
    static = dict(zip(names(shown, "static_limit"), shown["static_limit_voltage"].values, strict=True))
    driven_names = names(shown, "driven_limit")
    yield f"{'limit':22s}  {'constant voltage':16s}  driven, lowest peak voltage"
    for name in dict.fromkeys([*static, *driven_names]):
        told = _static_reading(shown, name, static[name]) if name in static else "-"
        row = _lowest_driven(shown, driven_names.index(name)) if name in driven_names else "-"
        yield f"  {name:20s}  {told:16s}  {row}"
    if np.isnan(static["dielectric breakdown"]):
        yield "the dielectric strength is not given: the window takes no account of breakdown"


def _static_reading(shown: xr.Dataset, name: str, voltage: float) -> str:
    if np.isinf(voltage) and name not in ("pitchfork", "pull-in"):
        return f"above {plain(shown['peak_voltage'].max())}{unit_of(shown['peak_voltage'])}"
    value = reading(name, voltage)
    return value if isinstance(value, str) else f"{plain(value)}{unit_of(shown['peak_voltage'])}"


def _lowest_driven(shown: xr.Dataset, row: int) -> str:
    low = shown["limit_low"].values[row]
    if np.isnan(low).all():
        return str(reading(names(shown, "driven_limit")[row], np.nan))
    k = int(np.argmin(low))
    frequency = shown["drive_frequency"]
    if np.isinf(low[k]):
        return f"above {plain(shown['driven_peak'].max())}{unit_of(shown['driven_peak'])}"
    return f"{_interval(shown, row, k)} at {plain(frequency[k])}{unit_of(frequency)}"


def _interval(shown: xr.Dataset, row: int, k: int) -> str:
    low, high = (plain(shown[name].values[row, k]) for name in ("limit_low", "limit_high"))
    return f"{low if low == high else f'{low} to {high}'}{unit_of(shown['driven_peak'])}"


def static_lines(shown: xr.Dataset) -> Iterator[str]:
    """The recommended constant voltage, with stroke, blocked force and natural frequency there."""
    highest, margin = float(shown["recommended_constant"]), margin_of(shown)
    if highest <= 0.0:
        yield "no constant voltage is recommended: the film is slack from 0 on; pre-stretch it"
        return
    at = {
        name: f"{plain(np.interp(highest, shown['peak_voltage'], shown[name]))}{unit_of(shown[name])}"
        for name in STATIC
    }
    still = plain(shown["natural_frequency"][0])
    yield (
        f"recommended constant voltage, {margin:.0%} below its limits: {at['peak_voltage']}; stroke {at['stroke']}, "
        f"blocked force {at['blocked_force']}, natural frequency {at['natural_frequency']} ({still} at 0)"
    )


def margin_of(shown: xr.Dataset) -> float:
    """The margin that the envelope was made with."""
    import json

    return float(json.loads(shown.attrs["options"])["margin"])


def window_table(shown: xr.Dataset) -> Iterator[str]:
    """The recommended window over drive frequency; neighbouring frequencies of equal rows in one."""
    recommended = shown["recommended_peak"].values
    if (recommended <= 0.0).all():
        first = dict.fromkeys(first_name(shown, i) for i in shown["first_limit"].values)
        yield f"no driven window is recommended: {', '.join(map(str, first))} from 0 on at every frequency"
    else:
        units = [shown[name].attrs["units"].replace("1", "") for name in WINDOW]
        told = [f"{text} ({u})" if u else text for text, u in zip(HEADS, units, strict=True)]
        yield f"recommended drive, {margin_of(shown):.0%} below its limits:"
        yield "  " + "".join(f"{head:{width}s}" for head, width in zip(told, WIDTHS, strict=True)) + "first limit"
        frequency = shown["drive_frequency"].values
        rows = [window_row(shown, k) for k in range(frequency.size)]
        for row, group in itertools.groupby(range(frequency.size), key=lambda k: rows[k]):
            ks = list(group)
            span = plain(frequency[ks[0]]) + (f" to {plain(frequency[ks[-1]])}" if len(ks) > 1 else "")
            yield f"  {span:{WIDTHS[0]}s}{row}"
        if (shown["window_regime"].values == 0.0).all():
            yield "within the window the film stays at rest: only a bias and a spring that lifts the disc move it there"
    yield own_line(shown)


HEADS = ("frequency", "up to", "stroke", "power", "apparent")
WIDTHS = (18, 12, 14, 14, 16)


def window_row(shown: xr.Dataset, k: int) -> str:
    """Recommended peak, what it yields, and the limit that comes first, at one drive frequency."""
    recommended = float(shown["recommended_peak"][k])
    if recommended <= 0.0:
        cells = ["none", "-", "-", "-"]
    else:
        rest = shown["window_regime"].values[k] == 0.0
        moved = ["at rest", "0"] if rest else [plain(shown[name][k]) for name in WINDOW[2:4]]
        cells = [plain(recommended), *moved, plain(shown[WINDOW[4]][k])]
    first = int(shown["first_limit"].values[k])
    lowest_static = float(np.nanmin(shown["static_limit_voltage"].values, initial=np.inf))
    low = np.inf if first < 0 else float(shown["limit_low"].values[first, k])
    if np.isinf(min(low, lowest_static)):
        told = "none met"
    elif lowest_static < low:
        at = int(np.nanargmin(shown["static_limit_voltage"].values))
        told = f"{names(shown, 'static_limit')[at]} held at {plain(lowest_static)}{unit_of(shown['driven_peak'])}"
    else:
        told = f"{first_name(shown, first)} {_interval(shown, first, k)}"
    return "".join(f"{cell:{width}s}" for cell, width in zip(cells, WIDTHS[1:], strict=True)) + told


def own_line(shown: xr.Dataset) -> str:
    """Where the device's own drive lies."""
    peak, frequency = float(shown["own_peak"]), float(shown["own_frequency"])
    volt, hertz = unit_of(shown["own_peak"]), unit_of(shown["own_frequency"])
    own = f"its own drive, {plain(peak)}{volt} at {plain(frequency)}{hertz}:"
    looked = shown["drive_frequency"].values
    if not looked[0] <= frequency <= looked[-1]:
        return f"{own} outside the frequencies looked at"
    highest = float(np.interp(frequency, looked, shown["recommended_peak"].values))
    limit = highest / (1.0 - margin_of(shown))
    if peak <= highest:
        return f"{own} inside the window, {plain(highest)}{volt} there"
    return f"{own} above the window, {plain(highest)}{volt} there, and {'below' if peak <= limit else 'beyond'} a limit"


def plain(value: Any) -> str:
    """A number to four digits, a large one without an exponent."""
    return f"{float(f'{float(value):.4g}'):.10g}"

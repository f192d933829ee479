"""Files that the page saves (results computed again in double precision, and their figures), and the command and Python
lines that give the same numbers."""

from __future__ import annotations

import inspect
import math
import shlex
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING, Any

from gelcone.analyses.answer import in_si
from gelcone.analyses.ask import arguments_of
from gelcone.analyses.values import is_number
from gelcone.devices.units import DIMENSIONS, parse
from gelcone.errors import InputError, check_name
from gelcone.register.analyses import find_analysis
from gelcone.register.analysis import Analysis
from gelcone.studio.grids import Axis, Source
from gelcone.studio.look import check_periods
from gelcone.studio.setting import STATES, Setting, typed

if TYPE_CHECKING:
    import xarray as xr

    from gelcone.analyses.request import Subject

OPTIONS: Mapping[str, Mapping[str, Callable[[Any], float]]] = {
    "simulate": {"periods": check_periods},
    **{name: {} for name in ("section", "spectrum", "regime", "static", "map", "bifurcation", "envelope")},
}
"""Result that the page can save -> the options that the page sends for it, and their checks."""
OVER: Mapping[str, tuple[str, ...]] = {"map": ("x", "y"), "bifurcation": ("over",)}
"""Result over parameters -> the axes that the page sends for it."""
FORMATS = ("nc", "png", "svg")


@dataclass(frozen=True)
class Wanted:
    """A result to save: its ``analysis``, options, and swept parameters as they would be typed."""

    analysis: Analysis
    options: Mapping[str, Any]
    over: tuple[str, ...] = ()

    @classmethod
    def read(cls, name: Any, options: Any, axes: tuple[Axis, ...]) -> Wanted:
        """The result from the page's request; `InputError` for one that cannot be saved."""
        check_name("result that can be saved", name, OPTIONS)
        if not isinstance(options, dict) or not options.keys() <= set(OPTIONS[name]):
            raise InputError(f"options of {name}: must be among {', '.join(OPTIONS[name]) or 'none'}")
        checked = {option: OPTIONS[name][option](value) for option, value in options.items()}
        return cls(find_analysis(name), checked, tuple(over_text(a) for a in axes))

    @property
    def given(self) -> dict[str, Any]:
        """The options as the command line passes them to the analysis."""
        return {**self.options, **({"over": self.over} if self.over else {})}


def fitting(setting: Setting, wanted: Wanted) -> Setting:
    """The setting without the values that the result sweeps, and without a start if the analysis takes none."""
    left_out = {text.partition("=")[0] for text in wanted.over}
    if "initial" not in wanted.analysis.signature.parameters:
        left_out |= set(STATES)
    values = {name: value for name, value in setting.values.items() if name not in left_out}
    return replace(setting, values=values)


def over_text(axis: Axis) -> str:
    """The swept parameter as it is typed: ``name=from:to:count`` with units."""
    low, high = axis.texts((0, len(axis.values) - 1))
    return f"{axis.name}={low}:{high}:{len(axis.values)}"


def make(source: Source, wanted: Wanted, form: str) -> bytes:
    """The bytes of a file: the result as netCDF, or its figure."""
    from gelcone.netcdf import write_netcdf
    from gelcone.plots import plot, style

    check_name("format", form, FORMATS)
    subject = source.subject()
    shown = in_si(compute(subject, wanted), subject)
    with TemporaryDirectory() as folder:
        path = Path(folder) / f"{wanted.analysis.command}.{form}"
        if form == "nc":
            write_netcdf(shown, path)
        else:
            style.draw_file(plot(shown), path)
        return path.read_bytes()


def compute(subject: Subject, wanted: Wanted) -> xr.Dataset:
    """The result of an analysis as the command line computes it."""
    analysis = wanted.analysis
    if analysis.name == "map":  # the command computes it through a plan
        over = subject.over(wanted.over)
        return analysis.call(subject.target, over, subject.beginning)
    arguments = arguments_of(analysis, subject, wanted.given)
    return analysis.call(subject.target if analysis.planned else subject.model, **arguments)


# --- command and Python lines -----------------------------------------------------------------------------------------


def command(setting: Setting, wanted: Wanted, device: str) -> str:
    """The command that writes the same netCDF and PNG; ``device`` is the device's name or file on the command line."""
    options = typed(setting)
    words = ["gelcone", wanted.analysis.command]
    if setting.preset is None:
        words.append(device)
    else:
        words += ["--preset", setting.preset]
    words += [word for value in options["settings"] for word in ("--set", value)]
    words += ["--initial", options["initial"]] if "initial" in options else []
    words += [word for value in wanted.over for word in ("--over", value)]
    words += [w for name, value in wanted.options.items() for w in (f"--{name.replace('_', '-')}", f"{value:.15g}")]
    words += ["--uniform"] if wanted.analysis.name == "map" else []
    return shlex.join([*words, "--out", "results"])


def lines(setting: Setting, wanted: Wanted, device: str) -> str:
    """The Python lines that save the same netCDF; ``device`` as in `command`."""
    analysis, name = wanted.analysis, wanted.analysis.name
    if setting.preset is None:
        values = f".replace({dict(setting.values)!r})" if setting.values else ""
        text = ["import gelcone", "", f"device = gelcone.find_device({device!r}){values}", "model = device.to_model()"]
        initial, saved = "device.initial_state()", "gelcone.to_si(result, device)"
    else:
        changes = {n: v for n, v in setting.values.items() if n not in STATES}
        values = ", ".join(f"{n}={_plain(v)}" for n, v in changes.items())
        text = [
            "import gelcone\nimport gelcone.presets", "", f'preset = gelcone.presets.find_preset("{setting.preset}")',
            "model = preset.model" + (f".replace({values})" if changes else ""),
        ]  # fmt: skip
        initial = f"({typed(setting)['initial']})" if "initial" in typed(setting) else "preset.initial"
        saved = "result"
    first = "device" if setting.preset is None and analysis.planned else "model"
    begins = first == "model" and "initial" in inspect.signature(analysis.call).parameters
    text += _swept(setting, wanted)
    passed = [f"initial={initial}"] if begins else []
    passed += [f"{n}={value:.15g}" for n, value in wanted.options.items()]
    given = {"map": ["over"], "bifurcation": ["parameter", "values"]}.get(name, [])
    text.append(f"result = gelcone.{name}({', '.join([first, *given, *passed])})")
    text.append(f'gelcone.save({saved}, "{analysis.command}.nc")')
    return "\n".join(text) + "\n"


def _swept(setting: Setting, wanted: Wanted) -> list[str]:
    """The lines that define the swept parameters, in SI units for a device."""
    axes = []
    for text in wanted.over:
        name, _, ends = text.partition("=")
        low, high, count = ends.split(":")
        first, last = (float(end) if setting.preset else parse(name, end, _si_unit(end)) for end in (low, high))
        axes.append((name, f"np.linspace({first!r}, {last!r}, {count})"))
    if not axes:
        return []
    if wanted.analysis.name == "map":
        return ["import numpy as np", "over = {" + ", ".join(f"{name!r}: {values}" for name, values in axes) + "}"]
    return ["import numpy as np", f"parameter, values = {axes[0][0]!r}, {axes[0][1]}"]


def _si_unit(text: str) -> str:
    """The SI unit of a typed value; ``"1"`` for a pure number."""
    shown = text.partition(" ")[2]
    return next(unit for unit, dimension in DIMENSIONS.items() if shown in dimension.powers)


def _plain(value: str) -> str:
    """A value as a Python literal: a number, or else a text."""
    if not is_number(value):
        return repr(value)
    return value if math.isfinite(float(value)) else f"float({value!r})"

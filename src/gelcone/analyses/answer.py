"""Answers in words and as JSON: what all analyses share. SI units for a device, headings, outcomes, members, files."""

from __future__ import annotations

import json
import textwrap
from collections.abc import Callable, Collection, Iterable, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from gelcone import dataset
from gelcone._version import __version__
from gelcone.amounts import missing, unit_of
from gelcone.codes import Outcome, Regime, meanings
from gelcone.devices.fields import GEL
from gelcone.devices.numbers import numbers_of
from gelcone.devices.points import STATES
from gelcone.devices.si import DEVICE, to_si
from gelcone.devices.units import format_range, without_rounding
from gelcone.errors import InputError
from gelcone.motion.validity import ASSUMPTIONS
from gelcone.physics.film.pull_in import is_cone
from gelcone.quantity import Array
from gelcone.words import DISCORD, members_of, regime_counts, shortened
from gelcone.words import MOST_LINES as MOST_PRINTED

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.figure import Figure

    from gelcone.analyses.request import Subject
    from gelcone.devices.device import Device

WIDTH = 118
"""Columns of a text."""
_EVERYWHERE = ("title", "model", "options", "gelcone_version", "device", DEVICE, *dataset.FILM_ERRORS)
"""Attributes of every result, for which the JSON object has places of its own."""


# --- SI units ---------------------------------------------------------------------------------------------------------


def in_si(result: xr.Dataset, subject: Subject) -> xr.Dataset:
    """The result in millimetres, volts and so on when there is a device, its axes and states included."""
    return result if subject.device is None else to_si(result, subject.device)


# --- JSON -------------------------------------------------------------------------------------------------------------


def answer_json(command: str, content: Mapping[str, Any], shown: xr.Dataset, subject: Subject) -> dict[str, Any]:
    """The JSON object of a command: the same members for every one, described by ``docs/answer.schema.json``.

    ``content`` is the command's own; ``shown`` the result, with a device in its units.
    """
    device = subject.device
    return bare_answer(command, content) | {
        "subject": {
            "device": None if device is None else device.name,
            "fields": None if device is None else device.parameters(),
            "film": subject.model.film.name,
            **{name: shown.attrs.get(name) for name in dataset.FILM_ERRORS},
            "members": subject.model.size,
            "initial": initial_json(subject),
        },
        "parameters": parameters_json(subject.model) if device is None else None,
        "options": options_json(command, shown, device),
        "outcome": outcome_names(shown) if "outcome" in shown else None,
        "validity": validity_json(shown),
        "film_state": film_state_json(shown),
        "dims": {str(name): list(variable.dims) for name, variable in shown.variables.items() if variable.dims},
        "units": None if device is None else units_json(shown),
    }


def bare_answer(command: str, content: Mapping[str, Any]) -> dict[str, Any]:
    """The JSON answer of a command that does not run a model."""
    nothing = ("subject", "parameters", "options", "outcome", "validity", "film_state")
    return {
        "version": __version__,
        "command": command,
        **dict.fromkeys(nothing),
        "result": content,
        "dims": None,
        "units": None,
    }


def initial_json(subject: Subject) -> Any:
    """The initial displacement and velocity, of a device in the units in which results are read."""
    if subject.initial is None:
        return None
    state = np.asarray(subject.initial, dtype=float)
    if subject.device is None:
        return state
    return without_rounding(state * shown_states(subject.device))


def shown_states(device: Device) -> Array:
    """The factors of displacement and velocity to the units in which results are read."""
    return np.stack(np.broadcast_arrays(*(device.scales.shown(quantity) for quantity in STATES.values())), axis=-1)


def options_json(command: str, shown: xr.Dataset, device: Device | None) -> dict[str, Any]:
    """The options of a result, those that measure something in the units in which results are read."""
    options: dict[str, Any] = json.loads(shown.attrs["options"])
    if device is None:
        return options
    from gelcone.devices.analysis import option_scale
    from gelcone.devices.scales import MEASURES

    for name, quantity in _option_quantities(command, shown).items():
        if quantity in MEASURES and options.get(name) is not None:
            scale = option_scale(name, quantity, device.scales) * MEASURES[quantity].per_unit
            options[name] = without_rounding(np.asarray(options[name], dtype=float) * scale).tolist()
    return options


def _option_quantities(command: str, shown: xr.Dataset) -> dict[str, str]:
    """Map the options of a command, and of the analysis that it asks of every cell, to their quantities."""
    from gelcone.register.analyses import ANALYSES, COMMANDS

    names = [COMMANDS.get(command), shown.attrs.get("analysis")]
    known = [ANALYSES[name] for name in names if name is not None and name in ANALYSES]
    return {name: quantity for one in known for name, quantity in one.quantities.items()}


def units_json(shown: xr.Dataset) -> dict[str, str]:
    """The unit of every variable of a result that has one."""
    units = {str(name): str(variable.attrs.get("units", "1")) for name, variable in shown.variables.items()}
    return {name: unit for name, unit in units.items() if unit != "1"}


def validity_json(result: xr.Dataset) -> dict[str, Any] | None:
    """The share of the motion outside the model's validity, by assumption; null where a result has none.

    A share is a number, or a list over what the result is over; a word where it is not known.
    """
    names = [name for name in (*ASSUMPTIONS, "error") if f"validity_{name}" in result]
    return {name: result[f"validity_{name}"] for name in names} or None


def film_state_json(result: xr.Dataset) -> dict[str, Any] | None:
    """The share of the time that a film was in each of its states; null for a film without states."""
    start = "film_state_"
    return {str(n).removeprefix(start): v for n, v in result.items() if str(n).startswith(start)} or None


def plain(value: Any) -> Any:
    """``value`` in the types of JSON; what is not a finite number becomes the words of its variable."""
    if isinstance(value, Mapping):
        return {str(k): plain(v) for k, v in value.items()}
    if isinstance(value, list | tuple):
        return [plain(v) for v in value]
    if hasattr(value, "dims"):
        numbers = value.values
        if numbers.dtype.kind == "f" and not np.isfinite(numbers).all():
            numbers = np.vectorize(lambda v: _known(v, value), otypes=[object])(numbers)
        value = numbers
    if isinstance(value, np.ndarray):
        return plain(value.tolist())
    if isinstance(value, np.generic):
        return plain(value.item())
    if isinstance(value, float) and not np.isfinite(value):
        return None
    return value


def _known(value: Any, variable: xr.DataArray) -> Any:
    """A value, or the words of its variable for one that is not finite."""
    return float(value) if np.isfinite(value) else missing(float(value), variable)


def parameters_json(model: Any) -> dict[str, Any]:
    """The model's parameters; an infinite stretch limit is the string "inf"."""

    def write(value: Any) -> Any:
        array = np.asarray(value, dtype=object)
        return (
            ["inf" if v == np.inf else v for v in array.ravel()] if array.ndim else "inf" if value == np.inf else value
        )

    return {name: write(value) for name, value in model.parameters().items()}


def outcome_names(result: xr.Dataset) -> Any:
    """The outcome of a single run as a name, of an ensemble as (nested) lists; a word where nothing has run."""
    there = result["status"].values > 0 if "status" in result else True
    return variable_json(result["outcome"].where(there, -1))


_SIGNS = {-1: "negative", 0: "uncertain", 1: "positive"}
_REGIMES = dataset.flags(Regime)["flag_meanings"]
"""Flags of regimes, whose names in JSON have blanks and hyphens."""
_YES_OR_NO = ("symmetric", "doubtful", "coexisting", "stable", "resting", "resolved", "supercritical", "cascade")


def result_json(result: xr.Dataset, left_out: Collection[str] = ()) -> dict[str, Any]:
    """The JSON object of a result: its attributes, coordinates and variables by name, but for those ``left_out`` and
    what every answer has a place for."""
    attributes: dict[str, Any] = {name: value for name, value in result.attrs.items() if name not in _EVERYWHERE}
    if "totals" in attributes:
        attributes["totals"] = json.loads(attributes["totals"])
    names = [name for name in map(str, result.variables) if name not in (*left_out, "outcome", "initial")]
    return attributes | {n: variable_json(result[n]) for n in names if not n.startswith(("validity_", "film_state_"))}


def variable_json(variable: xr.DataArray) -> Any:
    """A variable of a result, names for what it holds as codes."""
    name = str(variable.name)
    if name.endswith(("period", "cycle")) and variable.attrs.get("quantity") == "count":
        return np.vectorize(_period, otypes=[object])(variable.values).tolist()
    codes = _codes(name, variable)
    return variable if codes is None else _names(variable, codes, "none" if name.startswith("fate") else "unknown")


def _period(value: Any) -> Any:
    """A number of periods; a word where a motion has none, or nothing is known."""
    return int(value) if value > 0 else "unknown" if np.isnan(value) else "none"


def _codes(name: str, variable: xr.DataArray) -> Mapping[int, Any] | None:
    """Map the codes of a variable to their names; None for a variable that holds numbers."""
    if "flag_meanings" in variable.attrs:
        is_regime = variable.attrs["flag_meanings"] == _REGIMES
        return {regime.value: regime.label for regime in Regime} if is_regime else meanings(variable)
    if variable.attrs.get("quantity") not in ("code", "flag"):
        return None
    if name == "sign":
        return _SIGNS
    return {0: False, 1: True} if name.endswith(_YES_OR_NO) and variable.dtype.kind == "i" else None


def _names(variable: xr.DataArray, codes: Mapping[int, Any], none: str) -> Any:
    return np.vectorize(lambda code: codes.get(code, none), otypes=[object])(variable.values).tolist()


def first(variable: xr.DataArray) -> xr.DataArray:
    """The largest exponent of a variable that holds all; another variable as it is."""
    return variable.isel(exponent=0) if "exponent" in variable.dims else variable


# --- words ------------------------------------------------------------------------------------------------------------


_USUAL_PARTS = {"bias": "spring", "waveform": "sine", "circuit": "ideal"}


def heading(subject: Subject, swept: Iterable[Any] = ()) -> list[str]:
    """First lines of a text: what was computed on, with those numbers that are one and not swept."""
    from gelcone.devices.template import component_in_words, fields_in_words

    swept = set(swept)
    system = subject.model.system
    if subject.device is not None:
        name, numbers = subject.device.name, fields_in_words(subject.device, swept)
        numbers += [_spread(k, v, subject.device.fields[k].unit) for k, v in subject.device if _several(k, v, swept)]
    else:
        given = {k: v for k, v in subject.model.parameters().items() if isinstance(v, float) and k not in swept}
        name, numbers = "cone model, dimensionless", [f"{k} {v:.4g}" for k, v in given.items()]
        parts = {"bias": system.bias, "waveform": system.waveform, "circuit": system.circuit}
        numbers += [f"{k} {component_in_words(v)}" for k, v in parts.items() if v.name != _USUAL_PARTS[k]]
        numbers += [_spread(k, v) for k, v in subject.model.values.items() if _several(k, v, swept)]
    unbroken = ", ".join(number.replace(" ", "\0") for number in numbers)
    wrapped = textwrap.wrap(unbroken, WIDTH, initial_indent="  ", subsequent_indent="  ", break_on_hyphens=False)
    lines = [name, *(line.replace("\0", " ") for line in wrapped)]
    abouts = [film.film.describe() for film in system.films]
    same = not swept & _names_of_films(subject)
    for k, film in enumerate(system.films):
        if same and film.prefix + "film_error" in system.numbers:
            model_numbers = subject.model.own_numbers
            force, gain, area = (np.max(model_numbers[film.prefix + name]) for name in dataset.FILM_ERRORS)
            abouts[k] += f"; its force is known to {force:.1%}, what a voltage takes from it to {gain:.1%}, "
            abouts[k] += f"its capacitance to {area:.1%}"
    if subject.device is None and system.films[0].film.name == "taut":
        abouts[0] += ", the default without a device; --film membrane wrinkles, as the film of devices does"
    about, *seconds = abouts
    films = [about, *(f"second {second}" for second in seconds if second and second != about)]
    for text in filter(None, (*films, system.circuit.describe(), _stiff_line(subject))):
        lines += textwrap.wrap(text, WIDTH, initial_indent="  ", subsequent_indent="    ", break_on_hyphens=False)
    return lines


def pulled_in(subject: Subject) -> str:
    """Name what the pull-in voltages are those of: a cone pulls in at others than the membrane for which it stands."""
    return "the cone itself" if any(map(is_cone, subject.model.system.films)) else "the film"


def _names_of_films(subject: Subject) -> set[str]:
    """Names under which numbers may be swept that change the films."""
    device = subject.device
    parameters = [name for film in subject.model.system.films for name in film.parameters]
    if device is None:
        return set(parameters)
    numbers = numbers_of(device)
    fields = {numbers[name].field for name in parameters if name in numbers}
    gel = {name for name in device.swept_fields() if name.startswith(GEL)}
    return {"disc_radius", "film_radius", "material", *fields, *gel}


def _several(name: str, value: Any, swept: Collection[Any]) -> bool:
    """Whether a field or parameter has a number for each member of an ensemble, and is not swept."""
    return name not in swept and isinstance(value, np.ndarray) and value.ndim > 0 and value.dtype.kind == "f"


def _spread(name: str, values: Any, unit: str = "1") -> str:
    """Name, smallest and largest value of a number of an ensemble, and the number of its values."""
    return f"{name} {format_range(values.min(), values.max(), unit)} ({len(np.unique(values))} values)"


def _stiff_line(subject: Subject) -> str:
    """A line about states that cost time and could be left out; empty if there are none."""
    stiff = subject.model.stiff
    return f"stiff: {' and '.join(stiff)}; --set reduced={'+'.join(stiff)} takes less time" if stiff else ""


def state_lines(result: xr.Dataset, subject: Subject) -> list[str]:
    """A line for statics of a film that has had no time to creep."""
    creeps = any(film.states for film in subject.model.system.films)
    at_once = creeps and json.loads(result.attrs.get("options", "{}")).get("at_once")
    return ["  at once, before it has crept"] if at_once else []


def outcome_lines(result: xr.Dataset) -> list[str]:
    """Count the runs that failed, a line for each kind of failure, with the remedy, and the reason of the first that is
    impossible."""
    counts, size = _outcome_counts(result), result["outcome"].size
    share = "" if size == 1 else f" of {size} runs"
    how = {outcome: "cannot be made" if outcome == Outcome.IMPOSSIBLE else "failed" for outcome in counts if outcome}
    lines = [f"{counts[one] if share else ''}{share} {words}: {one.meaning}".lstrip() for one, words in how.items()]
    reason = result.attrs.get("impossible")
    return lines if reason is None else [*lines, f"  the first that cannot be made: {reason}"]


def _outcome_counts(result: xr.Dataset) -> dict[Outcome, int]:
    """Map the outcomes that occur to the number of their runs."""
    codes = result["outcome"].values
    return {outcome: count for outcome in Outcome if (count := int((codes == outcome).sum()))}


def ending_lines(result: xr.Dataset) -> list[str]:
    """Count the endings of the members of an ensemble, a line for each kind; of a single run, only a failure."""
    counts, size = _outcome_counts(result), result["outcome"].size
    if size > 1:
        return [f"  {count} of {size}: {outcome.meaning}" for outcome, count in counts.items()]
    return [f"failed: {outcome.meaning}" for outcome in counts if outcome]


def counts_text(result: xr.Dataset) -> str:
    """Count the cells of each regime that occurs, in one line."""
    counts = regime_counts(result)
    pulled_in, left = int((result["outcome"].values == Outcome.PULLED_IN).sum()), Regime.LEFT_THE_DOMAIN.label
    if pulled_in:
        counts |= {left: counts[left] - pulled_in, Outcome.PULLED_IN.words: pulled_in}
    return ", ".join(f"{name} {count}" for name, count in counts.items() if count)


def doubt_lines(result: xr.Dataset) -> list[str]:
    """Count the doubtful results, in a line; no line if there are none."""
    doubtful = (result["doubtful"].values != 0) & (result["outcome"].values == 0)
    count = int(doubtful.sum())
    return [f"{count} of {doubtful.size} doubtful: {DISCORD}, check before you rely on it"] * bool(count)


def member_lines(result: xr.Dataset, describe: Callable[[xr.Dataset], str]) -> list[str]:
    """One line for each of the first members of an ensemble, beginning with its varied parameters."""
    count = result["outcome"].size
    lines = [f"  {name}: {describe(one)}" for name, one in members_of(result, range(count)[:MOST_PRINTED])]
    return shortened(lines, count)


def grid_text(shown: xr.Dataset, names: Iterable[Any]) -> str:
    """The swept coordinates in one line."""
    return "; ".join(f"{dim} {_ends(shown[dim])}, {shown.sizes[dim]} values" for dim in names)


def _ends(coordinate: xr.DataArray) -> str:
    if coordinate.dtype.kind in "OU":
        return ", ".join(map(str, coordinate.values))
    return f"{float(coordinate[0]):.6g} to {float(coordinate[-1]):.6g}{unit_of(coordinate)}"


# --- files ------------------------------------------------------------------------------------------------------------


def result_paths(out: Path, name: str) -> tuple[Path, Path]:
    """The files NAME.nc and NAME.png in the folder ``out``."""
    return out / f"{name}.nc", out / f"{name}.png"


def check_folder(out: Path | None, name: str, force: bool) -> None:
    """Refuses a result that exists or a folder that cannot be written, before any work is done."""
    if out is not None:
        from gelcone.files import check_writable

        # first whether the name is one that the file system takes: a look into the folder fails otherwise
        check_writable(result_paths(out, name), force=force)
        for folder in (out.absolute(), *out.absolute().parents):
            if (folder / "zarr.json").exists():
                raise InputError(f"{out}: lies inside the store {folder}; choose a folder outside")


def write_results(out: Path, name: str, result: xr.Dataset, figure: Figure, force: bool) -> tuple[Path, Path]:
    """Writes NAME.nc and NAME.png; both appear whole or none does."""
    from gelcone.files import write_together
    from gelcone.netcdf import write_netcdf
    from gelcone.plots import style

    data, picture = result_paths(out, name)
    write_together(
        {data: lambda to: write_netcdf(result, to), picture: lambda to: style.draw_file(figure, to)},
        force=force,
    )
    return data, picture

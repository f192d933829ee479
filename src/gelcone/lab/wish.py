"""A wish for a device: requirements, fields that are free within bounds, and tolerances."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from gelcone.devices.device import Device
from gelcone.devices.units import parse, parse_share, share_of
from gelcone.errors import InputError, check_name, check_names, check_path, unknown_name
from gelcone.files import read_text, read_toml
from gelcone.motion.envelope import MARGIN
from gelcone.physics.records import FILMS
from gelcone.quantity import Array

MEASURES: Mapping[str, str] = {
    "stroke": "m",
    "blocked_force": "N",
    "peak_voltage": "V",
    "apparent_power": "W",
    "current": "A",
    "natural_frequency": "Hz",
    "rest_height": "m",
    "footprint": "m",
}
"""Numbers of a design, and the diameter of its ring, that may be required -> SI unit."""
SMALL, LARGE = ("apparent_power", "current", "peak_voltage", "footprint", "film_thickness", "moving_mass"), (
    "stroke", "blocked_force", "natural_frequency", "probability",
)  # fmt: skip
"""Objectives that may be made smallest, and largest."""
SETTINGS = ("margin", "confidence", "smallest", "largest", "free", "tolerances")
MOST_FREE, MOST_TOLERANCES, MOST_OBJECTIVES = 16, 24, 3
MUST_MEET = 0.95
"""Default share of the devices within the tolerances that must meet all requirements."""
REMEDY = "`gelcone init --wish wish.toml` writes one to fill in"


class Requirement(NamedTuple):
    """A number of a design and its bound in SI, a lower one if ``least``."""

    name: str
    least: bool
    bound: float


class Tolerance(NamedTuple):
    """The standard deviation of a field, over its value if ``relative``, else in SI."""

    name: str
    deviation: float
    relative: bool


class Samples(NamedTuple):
    """Correlated fields: their ``names``, the ``medians`` of their draws, and a ``root`` of the covariance of their
    logarithms."""

    names: tuple[str, ...]
    medians: Array
    root: Array


NO_SAMPLES = Samples((), np.zeros(0), np.zeros((0, 0)))


class Objective(NamedTuple):
    """A number to be made smallest, or largest."""

    name: str
    largest: bool


@dataclass(frozen=True)
class Wish:
    """Requirements on a device; ``device`` has the fixed fields, and the ``free`` ones in the middle of their
    bounds."""

    text: str
    device: Device
    requirements: tuple[Requirement, ...]
    free: Mapping[str, tuple[float, float]]
    tolerances: tuple[Tolerance, ...]
    objectives: tuple[Objective, ...]
    margin: float
    confidence: float
    samples: Samples = NO_SAMPLES

    @property
    def uncertain(self) -> int:
        """The number of uncertain fields."""
        return len(self.tolerances) + len(self.samples.names)

    @property
    def name(self) -> str:
        """The name of the wished device."""
        return str(self.device.name)


def read_wish(path: str | Path) -> Wish:
    """Read a wish from a TOML file, as `gelcone init --wish` writes one.

    Parameters
    ----------
    path : the file: fields of a device with their values; requirements such as ``stroke = ">= 5 mm"``; a table
        ``[free]`` of fields with bounds, ``"4 mm:15 mm"``; a table ``[tolerances]`` of fields with their standard
        deviation, ``"5 %"``; ``margin`` below all limits, ``confidence``, and objectives, ``smallest`` or ``largest``.

    Returns
    -------
    The wish: requirements, free fields with their bounds in SI, tolerances and objectives.

    Raises
    ------
    InputError : in one line, for a file that cannot be read or used.

    Examples
    --------
    >>> import gelcone, pathlib, tempfile
    >>> path = pathlib.Path(tempfile.mkdtemp(), "wish.toml")
    >>> text = '''
    ... stroke = ">= 2 mm"
    ... smallest = ["apparent_power"]
    ... frequency = "10 Hz"
    ... footprint = "60 mm"
    ... film = "taut"
    ... disc_radius = "8 mm"
    ... film_thickness = "0.2 mm"
    ... hoop_prestretch = 1.4
    ... moving_mass = "5 g"
    ... damping_coefficient = "10 mN s/m"
    ... material = "PVC-DBA 6:1"
    ... voltage_offset = "0.8 kV"
    ... voltage_amplitude = "0.7 kV"
    ... [free]
    ... spring_rate = "1 N/m:100 N/m"
    ... initial_height = "5 mm:40 mm"
    ... [tolerances]
    ... film_thickness = "5 %"
    ... '''
    >>> _ = path.write_text(text)
    >>> wish = gelcone.read_wish(path)
    >>> sorted(wish.free), [f"{low:g} to {high:g}" for low, high in wish.free.values()]
    (['initial_height', 'spring_rate'], ['1 to 100', '0.005 to 0.04'])
    """
    check_path("read_wish", path)
    path = Path(path)
    text = read_text(path, REMEDY)
    content = read_toml(path, text)
    try:
        return _wish(content, path.stem, text)
    except InputError as error:
        raise InputError(f"{path}: {str(error).splitlines()[0]}") from None


def with_samples(wish: Wish, draws: Mapping[str, Array]) -> Wish:
    """Add the uncertainty of ``draws``, with their correlations, to a wish; fixed fields are set to their medians.

    Raises `InputError` for a field that also has a tolerance, and for values that are not positive.
    """
    fields = wish.device.swept_fields()
    for name, values in draws.items():
        check_name("field of a design", name, fields, where="samples: ")
        if any(one.name == name for one in wish.tolerances):
            raise InputError(
                f"samples: [tolerances] holds {name}, too, and the samples have its correlations; leave one of them out"
            )
        if not (np.asarray(values) > 0.0).all():
            raise InputError(f"samples: {name} is not positive in every draw; give a tolerance in its place")
    logs = np.log(np.array([np.asarray(values, dtype=float) for values in draws.values()]))
    size, vectors = np.linalg.eigh(np.cov(logs).reshape(len(logs), len(logs)))
    root = vectors * np.sqrt(np.maximum(size, 0.0))
    medians = np.exp(np.median(logs, axis=1))
    middle = zip(draws, medians.tolist(), strict=True)
    device = wish.device.replace_quietly({name: value for name, value in middle if name not in wish.free})
    return replace(wish, device=device, samples=Samples(tuple(draws), medians, root))


def _wish(content: Mapping[str, Any], name: str, text: str) -> Wish:
    free, tolerances = (_table(content, key) for key in ("free", "tolerances"))
    texts = {key: value for key, value in content.items() if key in MEASURES}
    fixed = {key: value for key, value in content.items() if key not in (*SETTINGS, *MEASURES)}
    requirements = [_requirement(key, value) for key, value in texts.items() if not _is_size(key, value)]
    if _is_size("footprint", texts.get("footprint")):
        if "film_radius" in fixed or "film_radius" in free:
            raise InputError("footprint and film_radius are both given; give one: a footprint is twice the radius")
        fixed["film_radius"] = 0.5 * parse("footprint", texts["footprint"], "m", above=0.0)
    if both := sorted(free.keys() & fixed.keys()):
        raise InputError(f"{both[0]}: is given and free; give it once")
    if not free:
        raise InputError('[free]: is missing; give fields and their bounds, disc_radius = "4 mm:15 mm"')
    if not requirements:
        raise InputError('nothing is required; give what the device must do, such as stroke = ">= 5 mm"')
    bounds = _bounds(free)
    device = _device(
        fixed | {key: float(_middle(span)) for key, span in bounds.items()} | {"name": fixed.get("name", name)}
    )
    check_names("field that can be free", bounds, device.swept_fields(), where="[free] ")
    return Wish(
        text,
        device,
        tuple(requirements),
        bounds,
        tuple(_tolerance(device, *item) for item in tolerances.items()),
        _objectives(content),
        _share(content, "margin", MARGIN, 0.0, 0.9),
        _share(content, "confidence", MUST_MEET, 0.5, 0.99),
    )


def _table(content: Mapping[str, Any], key: str) -> dict[str, Any]:
    """A table of fields, those of ``[free.material]`` under dotted names."""
    given = content.get(key, {})
    if not isinstance(given, dict):
        raise InputError(f"{key} = {str(given)[:60]!r}: must be a table, [{key}]")
    flat: dict[str, Any] = {}
    for name, value in given.items():
        inner = {f"{name}.{leaf}": entry for leaf, entry in value.items()} if isinstance(value, dict) else {name: value}
        flat |= inner
    most = MOST_FREE if key == "free" else MOST_TOLERANCES
    if len(flat) > most:
        raise InputError(f"[{key}]: has {len(flat)} fields; give at most {most}")
    return flat


def _is_size(key: str, value: Any) -> bool:
    """Whether a footprint is stated as a size, not as a bound."""
    return key == "footprint" and value is not None and not str(value).strip().startswith(("<", ">"))


_EXAMPLES = {"m": "5 mm", "N": "50 mN", "V": "2 kV", "W": "5 mVA", "A": "0.1 mA", "Hz": "10 Hz"}


def _requirement(name: str, value: Any) -> Requirement:
    text = str(value).strip()
    sign = text[:2]
    if sign not in (">=", "<="):
        raise InputError(f'{name} = {text[:60]!r}: must be a bound, such as {name} = ">= {_EXAMPLES[MEASURES[name]]}"')
    bound = parse(name, text[2:].strip().replace("VA", "W"), MEASURES[name], above=0.0)
    return Requirement(name, sign == ">=", bound)


def _bounds(free: Mapping[str, Any]) -> dict[str, tuple[float, float]]:
    from gelcone.devices.fields import DEVICE_FIELDS

    bounds = {}
    for name, value in free.items():
        check_name("device field", name, DEVICE_FIELDS, where="[free] ")
        low, colon, high = (part.strip() for part in str(value).partition(":"))
        if not colon:
            raise InputError(f'[free] {name} = {str(value)[:60]!r}: must be two bounds, such as "4 mm:15 mm"')
        field = DEVICE_FIELDS[name]
        if not field.unit:
            raise InputError(f"[free] {name}: is not a number, and cannot be free")
        ends = [
            parse(f"[free] {name}", _number(end), field.unit, above=field.above, least=field.least)
            for end in (low, high)
        ]
        if not ends[0] < ends[1]:
            raise InputError(f"[free] {name} = {str(value)[:60]!r}: the first bound must be the smaller one")
        bounds[name] = (ends[0], ends[1])
    return bounds


def _number(text: str) -> Any:
    """The number in a text, which `parse` takes as SI; other texts unchanged."""
    try:
        return float(text)
    except ValueError:
        return text


def _middle(span: tuple[float, float]) -> float:
    return float(np.sqrt(span[0] * span[1])) if span[0] > 0.0 else 0.5 * (span[0] + span[1])


def _device(values: Mapping[str, Any]) -> Device:
    if "film" in values and values["film"] not in FILMS:
        raise unknown_name("film of a design", str(values["film"])[:60], FILMS)
    unknown = next((name for name in values if "." not in name and name not in Device.fields), None)
    if unknown is not None:
        raise unknown_name("field, requirement or setting", unknown, [*Device.fields, *MEASURES, *SETTINGS])
    device = Device(**{"film": "membrane", **values})
    _check(device)
    return device


def _check(device: Device) -> None:
    """Raise `InputError` for a device whose designs cannot be computed."""
    system = device.to_model().system
    if len(system.films) > 1 or system.circuit.states:
        raise InputError("design: takes a device with one film and an ideal source; leave second_film and circuit out")
    if device.material.branches:
        raise InputError("design: takes a gel that does not creep; leave the viscous branches out")
    if device.beam_rate is not None:
        raise InputError("design: takes a spring, a weight or a constant force; leave beam_rate out")
    if system.waveform.name != "sine":
        raise InputError("design: takes a sine; leave waveform out")


def _tolerance(device: Device, name: str, value: Any) -> Tolerance:
    fields = device.swept_fields()
    check_name("field with a tolerance", name, fields, where="[tolerances] ")
    if device.get(name) is None:
        raise InputError(f"[tolerances] {name}: is not set; give it a value, or make it free")
    if str(value).strip().endswith("%"):
        return Tolerance(name, parse_share(f"[tolerances] {name}", value), True)
    return Tolerance(name, parse(f"[tolerances] {name}", value, fields[name].unit, above=0.0), False)


def _objectives(content: Mapping[str, Any]) -> tuple[Objective, ...]:
    objectives = []
    for key, allowed in (("smallest", SMALL), ("largest", LARGE)):
        given = content.get(key, [])
        listed: Sequence[Any] = [given] if isinstance(given, str) else given
        if not isinstance(listed, list) or not all(isinstance(name, str) for name in listed):
            raise InputError(f'{key} = {str(given)[:60]!r}: must be a list of names, such as ["{allowed[0]}"]')
        for name in listed:
            check_name("objective", name, allowed, where=f"{key}: ")
            objectives.append(Objective(name, key == "largest"))
    if len(objectives) > MOST_OBJECTIVES:
        raise InputError(f"{len(objectives)} objectives: give at most {MOST_OBJECTIVES}")
    names = [objective.name for objective in objectives]
    if twice := next((name for k, name in enumerate(names) if name in names[:k]), ""):
        raise InputError(f"{twice}: is an objective twice; give it once")
    return tuple(objectives) or (Objective("probability", True),)


def _share(content: Mapping[str, Any], key: str, default: float, low: float, high: float) -> float:
    value = content.get(key, default)
    share = share_of(value)
    if not low <= share <= high:
        raise InputError(f"{key} = {str(value)[:60]}: must be a share from {low:g} to {high:g}, such as {default:g}")
    return share


FIRST_WISH = """\
# What a device must do. `gelcone design {file} --out designs` finds devices that do it in spite of their tolerances.

# --- what it must do: >= or <=, of stroke, blocked_force, peak_voltage, apparent_power, current, natural_frequency,
#     rest_height and footprint (the diameter of the ring)
stroke = ">= 5 mm"                     # peak to peak, of the settled motion
peak_voltage = "<= 2 kV"
margin = 0.2                           # share that the drive stays below pull-in, slackness and breakdown
confidence = 0.95                      # share of the devices within the tolerances that must meet all this
smallest = ["apparent_power", "peak_voltage"]  # up to three; or film_thickness, moving_mass, footprint, current
# largest = ["probability"]            # or stroke, blocked_force, natural_frequency

# --- what is fixed: fields of a device, see `gelcone help device`
frequency = "10 Hz"
footprint = "60 mm"                    # twice the film_radius
moving_mass = "5 g"
damping_coefficient = "10 mN s/m"
material = "PVC-DBA 6:1"               # see `gelcone materials`
dielectric_strength = "20 kV/mm"

# --- what is free, between two bounds
[free]
disc_radius = "4 mm:15 mm"
film_thickness = "50 um:500 um"
meridional_prestretch = "1:1.6"
hoop_prestretch = "1:2"
spring_rate = "1 N/m:100 N/m"
initial_height = "5 mm:40 mm"
voltage_offset = "0 V:2 kV"
voltage_amplitude = "20 V:1 kV"

# --- tolerances: standard deviations, in percent or in the unit of the field
[tolerances]
film_thickness = "5 %"
meridional_prestretch = "2 %"
hoop_prestretch = "2 %"
spring_rate = "3 %"
initial_height = "1 %"
moving_mass = "2 %"
damping_coefficient = "20 %"
material.shear_modulus = "10 %"
material.relative_permittivity = "5 %"
"""
"""The text of a first wish, with the name of its ``file``."""

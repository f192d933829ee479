"""What an analysis is asked about, described in text: a device or preset, settings, an initial state, swept values.

There is one language at a time. With a device names are its fields and every number has its SI unit: a bare number is
the SI value of a field, and is refused where it is not a field's. Without a device names are the model's parameters and
numbers are dimensionless.
"""

from __future__ import annotations

import math
import tomllib
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from gelcone.errors import InputError, unknown_name
from gelcone.physics.model import ConeModel, parameter_names, parameter_quantity
from gelcone.quantity import Array
from gelcone.register.analysis import Analysis, annotation_of

if TYPE_CHECKING:
    from gelcone.atlas.uncertain import Distribution
    from gelcone.devices.device import Device
    from gelcone.devices.record import Field
    from gelcone.physics.system import ConeSystem

MOST_POINTS = 100_000
RADIUS_RATIO = "radius_ratio"
DEFAULT_INITIAL = (1.0, 0.0)
STATES = {"displacement": "length", "velocity": "velocity"}
"""Components of the initial state, and the quantity of each."""
DEFAULT_STATES = (-2.0, 2.0, 81)
"""Initial displacements and velocities of a basin by default, dimensionless."""
Reader = Callable[[str, str], float]
"""Reads one number: (option, text) -> value."""


@dataclass(frozen=True)
class Subject:
    """What an analysis works on.

    Attributes
    ----------
    model : the dimensionless model, of the device if there is one.
    device : the device; None without one.
    initial : the initial state, dimensionless.
    start : the same with a device, in SI, where it was stated; None for the device's own.
    starts : whether the initial state was stated rather than taken by default.
    given : the names that ``--set`` gave.
    """

    model: ConeModel
    device: Device | None = None
    initial: Any = DEFAULT_INITIAL
    start: tuple[float, ...] | None = None
    starts: bool = False
    given: frozenset[str] = frozenset()

    @property
    def target(self) -> ConeModel | Device:
        """What a plan is made of: the device or, without one, the model."""
        return self.model if self.device is None else self.device

    @property
    def beginning(self) -> tuple[float, ...] | None:
        """The initial state of a plan."""
        return self.initial if self.device is None else self.start

    def over(self, texts: Iterable[str]) -> dict[str, Array]:
        """What to sweep in a plan and its values, see `read_over`; those of a device in SI."""
        swept = read_over(texts, self.device, self.model.system)
        self._not_set(swept)
        return swept

    def axes(self, texts: Iterable[str], analysis: Analysis) -> dict[str, Array]:
        """The values of ``--over`` for an analysis with axes of its own: keyword -> dimensionless values.

        Raises `InputError` for another name, and what `read_over` refuses.
        """
        named = {k: a.of_model if self.device is None else a.of_device for k, a in analysis.axes.items()}
        known = {name: keyword for keyword, name in named.items()}
        found: dict[str, Array] = {}
        for name, values in _pairs(texts, f"name=from:to:count, for example {example(self.device, next(iter(known)))}"):
            if name not in known:
                own = " and ".join(known)
                raise InputError(f"--over {name}: cannot be swept here; {analysis.command} sweeps {own}")
            if known[name] in found:
                raise InputError(f"--over {name}: is given twice; give it once")
            _, quantity = annotation_of(analysis.call, known[name])
            numbers = read_measures(f"--over {name}", values, quantity, self.device)
            found[known[name]] = increasing(f"--over {name}", np.atleast_1d(numbers))
        self._not_set(named[keyword] for keyword in found if analysis.axes[keyword].replaces)
        defaults = {k: np.linspace(*a.default) for k, a in analysis.axes.items() if a.default is not None}
        return defaults | found

    def _not_set(self, swept: Iterable[str]) -> None:
        for name in swept:
            if name in self.given:
                raise InputError(f"--set {name}: is swept by --over {name}; leave one of them out")

    def alone(self, name: str) -> Subject:
        """This subject; `InputError` where it is an ensemble."""
        if self.model.shape:
            raise InputError(f"{name} starts from one actuator, not {self.model.size}; sweep a parameter with --over")
        return self

    def without_initial(self, remedy: str) -> None:
        """`InputError` with the remedy where an initial state was stated."""
        if self.starts:
            raise InputError(f"--initial: {remedy}")


def example(device: Device | None, name: str) -> str:
    """A value of ``--over``, for messages."""
    if device is None:
        return f"--over {name}=0:2:401"
    unit = {"frequency": "Hz", "displacement": "mm", "velocity": "m/s"}.get(name, "V")
    return f'--over "{name}=5 {unit}:20 {unit}:31"'


def read_subject(
    device: str | Device | None = None,
    *,
    preset: str | None = None,
    film: str | None = None,
    settings: Iterable[str] = (),
    initial: str | None = None,
) -> Subject:
    """The subject that a device or preset, ``name=value`` settings and an initial state describe.

    With a device a setting changes one of its fields (``film_radius``, ``material.shear_modulus``), else a parameter of
    the model.

    Raises
    ------
    InputError : for a device together with a preset, unknown names, and values that cannot be used.
    """
    given = read_pairs(settings, device is not None)
    if device is not None:
        if preset is not None:
            raise InputError(f"--preset {preset} and the device {device!r} are both given; give one or the other")
        return _of_device(device, given, film, initial)
    for name, text in given.items():
        _no_decimal_comma(f"--set {name}", text, _parts(text))
    values = {name: read_value(text) for name, text in given.items()}
    of_film = {} if film is None else {name: values.pop(name) for name in ("pull_in", RADIUS_RATIO) if name in values}
    _only_of_model(values)
    if preset is None:
        model, start = ConeModel.from_parameters(values), DEFAULT_INITIAL
    else:
        from gelcone.presets import find_preset

        chosen = find_preset(preset)
        model, start = chosen.model.replace(**values), chosen.initial
    if film is not None:
        model = model.replace(film=film, **of_film)
    begin = start if initial is None else read_initial(initial, None, model)
    return Subject(model, None, begin, None, initial is not None, frozenset(given))


def _of_device(device: str | Device, given: dict[str, str], film: str | None, initial: str | None) -> Subject:
    from gelcone.devices.device import find_device

    found = find_device(device) if isinstance(device, str) else device
    texts = ({} if film is None else {"film": film}) | given
    fields = found.fields_with({setting: _table(text) for setting, text in texts.items()})
    for setting, text in given.items():
        _unit_or_brackets(f"--set {setting}", text)
    changes = {setting: read_field(f"--set {setting}", text, setting, fields) for setting, text in texts.items()}
    if changes:
        found = found.replace(**changes)
    model = found.to_model()
    start = None if initial is None else read_initial(initial, found, model)
    if start is None:
        state = found.initial_state()
    else:
        from gelcone.devices.points import dimensionless_state

        state = dimensionless_state(found, start)
        state = state if state.ndim > 1 else tuple(map(float, state))
    return Subject(model, found, state, start, initial is not None, frozenset(given))


def _only_of_model(values: Iterable[str]) -> None:
    """`InputError` for a field of a device where there is none, with the parameter of the model of that meaning."""
    known = parameter_names()
    for name in values:
        if name in known or name.partition(".")[0] in known:
            continue
        from gelcone.devices.fields import DEVICE_FIELDS

        if name in DEVICE_FIELDS:
            same = [other for other in known if other in DEVICE_FIELDS[name].near]
            remedy = f"without a device, set {same[0]!r}, dimensionless" if same else "give a device to set it"
            raise InputError(f"--set {name}: is a field of a device; {remedy}")


# --- single values ----------------------------------------------------------------------------------------------------


def read_pairs(settings: Iterable[str], device: bool = False) -> dict[str, str]:
    """``name=value`` pairs as texts; `InputError` for one that is not a pair, or a name given twice."""
    values: dict[str, str] = {}
    example = '--set "voltage_amplitude=500 V"' if device else "--set voltage=1.04"
    for setting in settings:
        name, equals, value = (part.strip() for part in setting.partition("="))
        if not equals or not name or not value:
            raise InputError(f"--set {setting!r}: must be name=value, for example {example}")
        if name in values:
            raise InputError(f"--set {name}: is given twice; give it once")
        values[name] = value
    return values


def read_value(text: str) -> Any:
    """Read a number, a list ``0.5,1,2`` or ``[1, 2]``, a range ``0:2:5``, or else the text itself."""
    if text.count(":") == 2:
        return read_range(text)
    try:
        numbers = [float(part) for part in _parts(text)]
    except ValueError:
        return text
    return numbers[0] if len(numbers) == 1 else numbers


def read_range(text: str) -> Array:
    """``from:to:count`` as evenly spaced values."""
    return read_numbers("", text, lambda option, part: float(part))


def read_numbers(option: str, text: str, read: Reader) -> Any:
    """Read a number, a list ``v1,v2,...`` or ``[v1, v2, ...]`` or a range ``from:to:count``, each number by ``read``.

    Among values with units a bare number is refused, but 0.
    """
    shown = f"{option} {text!r}" if option else repr(text)
    if text.count(":") == 2:
        first, last, count = (part.strip() for part in text.split(":"))
        _one_manner(shown, [first, last])
        try:
            begin, end, number = read(option, first), read(option, last), int(count)
        except ValueError as error:
            if isinstance(error, InputError):
                raise
            raise InputError(f"{shown}: must be a range from:to:count, for example 0:2:401") from None
        if not (math.isfinite(begin) and math.isfinite(end)):
            raise InputError(f"{shown}: the ends of a range must be finite")
        if not begin < end:
            raise InputError(f"{shown}: is empty or reversed; the first end must be below the second")
        if not 2 <= number <= MOST_POINTS:
            raise InputError(f"{shown}: has {number} points; a range takes 2 to {MOST_POINTS}")
        return np.linspace(begin, end, number)
    if ":" in text:
        raise InputError(f"{shown}: must be a range from:to:count, the last being the number of values: {text}:21")
    parts = _parts(text)
    if not all(parts):
        raise InputError(f"{shown}: has an empty value; must be a number, a list v1,v2,... or a range from:to:count")
    if len(parts) > MOST_POINTS:
        raise InputError(f"{option}: has {len(parts)} values; a list takes at most {MOST_POINTS}")
    _one_manner(shown, parts)
    numbers = [read(option, part) for part in parts]
    return numbers[0] if len(numbers) == 1 else np.array(numbers)


def _parts(text: str) -> list[str]:
    """The values of a list, with or without brackets."""
    inner = text[1:-1] if text.startswith("[") and text.endswith("]") else text
    return [part.strip() for part in inner.split(",")]


def _no_decimal_comma(option: str, text: str, parts: list[str]) -> None:
    """`InputError` for a setting that may be one number with a decimal comma, not a list."""
    if len(parts) == 2 and not text.startswith("[") and parts[0].lstrip("+-").isdecimal() and parts[1].isdecimal():
        one, two = ".".join(parts), ", ".join(parts)
        raise InputError(f"{option}={text}: may be one number or two; write {one} with a point, or the list [{two}]")


def _unit_or_brackets(option: str, text: str) -> None:
    """`InputError` for a setting of a device that lists bare numbers without brackets."""
    parts = _parts(text)
    if len(parts) > 1 and not text.startswith("[") and all(map(is_number, parts)):
        _no_decimal_comma(option, text, parts)
        raise InputError(f"{option}={text}: a list needs a unit on every value, or brackets: [{', '.join(parts)}]")


def _one_manner(shown: str, parts: list[str]) -> None:
    bare = [part for part in parts if is_number(part)]
    if 0 < len(bare) < len(parts) and any(float(part) != 0.0 for part in bare):
        odd = next(part for part in bare if float(part) != 0.0)
        raise InputError(
            f"{shown}: {odd} has no unit and others have; give each its unit, and write decimals with a point"
        )


def is_number(text: str) -> bool:
    """Whether a text is a number without a unit."""
    try:
        float(text)
    except ValueError:
        return False
    return True


def read_field(option: str, text: str, name: str, fields: Mapping[str, Field]) -> Any:
    """The value of a device's field: text, number, list or range; a bare number is in the field's SI unit."""
    from gelcone.devices.record import unknown_field

    if name not in fields:
        raise InputError(f"{option}: {unknown_field('device', name, fields)}")
    field = fields[name]
    if name == "material" and "," in text and not text.startswith("{"):
        return [part.strip() for part in text.split(",")]
    if not field.unit:
        return _table(text)
    if "," not in text and ":" not in text and not is_number(text):
        return text  # read with its unit where the device is made
    return read_numbers(option, text, lambda option, part: _of_field(option, part, field))


def _table(text: str) -> Any:
    """A component's table, as in a device file: ``{component = "module:Class", ...}``; any other text as it is."""
    if not text.startswith("{"):
        return text
    try:
        return tomllib.loads(f"table = {text}")["table"]
    except ValueError as error:
        raise InputError(f"{text}: is not a table such as {{component = 'module:Class'}} ({error})") from None


def _of_field(option: str, text: str, field: Field) -> float:
    from gelcone.devices.units import parse

    if is_number(text):
        number = float(text)
        if not math.isfinite(number) and not (field.infinite and number == math.inf):
            raise InputError(f"{option} {text}: must be finite")
        return number
    return parse(option, text, field.unit, example=field.example_text())


def measure_reader(quantity: str, device: Device | None, *, in_si: bool = False) -> Reader:
    """Reads a number of a quantity: dimensionless or, with a device, with a unit, and then scaled to the model.

    With a device a bare number is refused, but 0. ``in_si`` leaves what is read in SI.
    """

    def read(option: str, text: str) -> float:
        bare = is_number(text)
        if device is None:
            if not bare:
                raise InputError(f"{option} {text!r}: must be a number (units need a device)")
            number = float(text)
        else:
            from gelcone.devices.analysis import option_scale
            from gelcone.devices.scales import MEASURES
            from gelcone.devices.units import DIMENSIONS, parse

            unit = MEASURES[quantity].unit
            if bare and float(text) != 0.0:
                raise InputError(
                    f"{option} {text}: has no unit; with a device give one, such as {DIMENSIONS[unit].example!r}"
                )
            number = 0.0 if bare else parse(option, text, unit)
            number = number if in_si else number / option_scale(option, quantity, device.scales)
        if not math.isfinite(number):
            raise InputError(f"{option} {text}: must be finite")
        return number

    return read


def read_measures(option: str, text: str, quantity: str, device: Device | None, *, in_si: bool = False) -> Any:
    """One or several numbers of a quantity, see `read_numbers` and `measure_reader`."""
    return read_numbers(option, text, measure_reader(quantity, device, in_si=in_si))


def read_initial(text: str, device: Device | None, model: ConeModel) -> tuple[float, ...]:
    """A displacement and a velocity, or all states, dimensionless or - with a device - with units, in SI; or some of
    the states by name, ``displacement=0.5,charge=0.2``, of which the others start by default."""
    parts, states = [part.strip() for part in text.split(",")], model.system.states
    names = [state.name for state in states]
    named = [part.partition("=")[::2] for part in parts] if "=" in text else []
    if not named and len(parts) not in (2, len(names)):
        form = "1,0" if device is None else '"5 mm,0 m/s"'
        more = f", or all states ({', '.join(names)}), or some by name=value" if len(names) > 2 else ""
        raise InputError(
            f"--initial {text!r}: must be a displacement and a velocity{more}, for example --initial {form}"
        )
    given = [(name.strip(), value.strip()) for name, value in named] or list(zip(names, parts, strict=False))
    found: dict[str, float] = {}
    for name, part in given:
        if name not in names:
            raise unknown_name("component of the initial state", name, names)
        if name in found:
            raise InputError(f"--initial {name}: is given twice; give it once")
        found[name] = _read_component(name, part, states[names.index(name)].quantity, device)
    if len(found) == 2 and found.keys() == STATES.keys():
        return found["displacement"], found["velocity"]
    return _completed(found, device, model)


def _read_component(name: str, part: str, quantity: str, device: Device | None) -> float:
    from gelcone.devices.scales import MEASURES

    pure = quantity not in MEASURES
    return measure_reader(quantity, None if pure else device, in_si=True)(f"--initial {name}", part)


def _completed(found: Mapping[str, float], device: Device | None, model: ConeModel) -> tuple[float, ...]:
    """All states of a single actuator, those that are not ``found`` at their start; of a device in SI."""
    if model.shape:
        raise InputError("--initial: states by name are those of one actuator; sweep a parameter with --over")
    sizes = np.ones(len(model.system.states))
    own = DEFAULT_INITIAL
    if device is not None:
        from gelcone.devices.scales import MEASURES

        known = [device.scales.size(s.quantity) if s.quantity in MEASURES else 1.0 for s in model.system.states]
        sizes, own = np.array(known, dtype=float), device.initial_state()
    disc = [found[name] / sizes[k] if name in found else own[k] for k, name in enumerate(STATES)]
    start = model.members().start_states(disc)[0] * sizes
    return tuple(found.get(s.name, float(value)) for s, value in zip(model.system.states, start, strict=True))


# --- swept values -----------------------------------------------------------------------------------------------------


def read_over(over: Iterable[str], device: Device | None = None, system: ConeSystem | None = None) -> dict[str, Array]:
    """What to sweep -> its values, in the order given: parameters of the model or, with a device, its fields in SI.

    Values are a range ``from:to:count`` or a list ``v1,v2,...``, increasing and at least two. ``system`` brings the
    parameters of its own components.

    Raises
    ------
    InputError : for what is not ``name=values``, a name that is unknown (with the nearest one) or given twice, values
        that are empty, reversed, repeated or fewer than two, and values out of bounds.
    """
    swept: dict[str, Array] = {}
    name = "voltage" if device is None else "voltage_amplitude"
    form = f"name=from:to:count or name=v1,v2,..., for example {example(device, name)}"
    for name, text in _pairs(over, form):
        option = f"--over {name}"
        _sweepable(option, name, device, system)  # refuses an unknown name before its values are read
        if name in swept:
            raise InputError(f"{option}: is given twice; give it once")
        values = np.atleast_1d(_values(option, text, name, device, system))
        swept[name] = values if values.dtype.kind == "U" else increasing(option, values)
    return swept


def _sweepable(option: str, name: str, device: Device | None, system: ConeSystem | None) -> None:
    """`InputError` for a name that cannot be swept."""
    if device is None:
        known = [*parameter_names(), *(system.parameters if system else {})]
        if name not in known:
            _only_of_model([name])
        parameter_quantity(name, system)
        return
    from gelcone.devices.points import GELS, swept_field
    from gelcone.devices.record import unknown_field

    if name == GELS:
        return
    try:
        swept_field(device, name)
    except InputError as error:
        raise InputError(f"{option}: {error}") from None
    if name in STATES:
        raise InputError(f"{option}: {unknown_field('device', name, device.swept_fields())}")


def _values(option: str, text: str, name: str, device: Device | None, system: ConeSystem | None) -> Any:
    """The values of a parameter or field, within its bounds."""
    if device is None:
        numbers = read_numbers(option, text, _plain)
        return np.asarray(parameter_quantity(name, system).check(name, numbers), dtype=float)
    from gelcone.devices.points import GELS, point_fields, read_swept

    if name == GELS:
        return read_swept(device, name, [part.strip() for part in text.split(",")])
    return read_swept(device, name, read_field(option, text, name, point_fields(device)))


def _plain(option: str, text: str) -> float:
    if not is_number(text):
        raise InputError(f"{option} {text!r}: must be a number; give a range from:to:count or a list v1,v2,...")
    return float(text)


def read_states(over: Iterable[str], device: Device | None, system: ConeSystem | None = None) -> dict[str, Array]:
    """The values of two initial states, with a device in m and m/s: displacement and velocity by default, without a
    device any of the states of a ``system``."""
    known = list(STATES) if system is None or device is not None else [state.name for state in system.states]
    given: dict[str, str] = {}
    for name, text in _pairs(over, f"name=from:to:count, for example {example(device, 'displacement')}"):
        if name not in known:
            raise unknown_name("component of the initial state", name, known)
        if name in given:
            raise InputError(f"--over {name}: is given twice; give it once")
        given[name] = text
    if len(given) > 2:
        raise InputError(f"--over: {', '.join(given)} are {len(given)} states; vary two of them")
    names = [*given, *(name for name in STATES if name not in given)][:2]
    return {name: _states(name, given.get(name), device) for name in known if name in names}


def _states(name: str, text: str | None, device: Device | None) -> Array:
    if text is None:
        scale = 1.0 if device is None else float(getattr(device.scales, STATES[name]))
        return scale * np.linspace(*DEFAULT_STATES)
    option = f"--over {name}"
    quantity = STATES.get(name, "1")
    return increasing(option, np.atleast_1d(read_measures(option, text, quantity, device, in_si=True)))


def _pairs(over: Iterable[str], form: str) -> Iterable[tuple[str, str]]:
    for text in over:
        name, equals, values = (part.strip() for part in text.partition("="))
        if not (equals and name and values):
            raise InputError(f"--over {text!r}: must be {form}")
        yield name, values


def increasing(option: str, values: Array) -> Array:
    """``values``, refused where they are fewer than two or do not increase."""
    if values.size < 2:
        raise InputError(f"{option}: has one point; a sweep takes at least two values")
    if not (values[1:] > values[:-1]).all():
        raise InputError(f"{option}: must increase; sort the values and remove duplicates")
    return values


def read_uncertain(texts: Iterable[str], subject: Subject) -> dict[str, Distribution]:
    """``name=low:high`` and ``name=mean~deviation`` as distributions, and names alone whose range the material states;
    `InputError` for anything else."""
    from gelcone.atlas.uncertain import Normal, Uniform

    device, system = subject.device, subject.model.system
    spread: dict[str, Distribution] = {}
    form = "prestretch=1~0.02" if device is None else '"film_thickness=0.2 mm~0.01 mm"'
    for text in texts:
        name, equals, values = (part.strip() for part in text.partition("="))
        if not equals and (span := _own_range(name, device)):
            equals, values = "=", span
        sign = "~" if "~" in values else ":"
        parts = [part.strip() for part in values.split(sign)]
        option = f"--uncertain {name}"
        if not (equals and name) or name in spread or len(parts) != 2 or not all(parts):
            raise InputError(
                f"--uncertain {text!r}: must be name=low:high or name=mean~deviation, each name once, such as {form}"
            )
        if name not in STATES:
            _sweepable(option, name, device, system)
        if name in subject.given:
            raise InputError(f"--set {name}: is drawn by --uncertain {name}; leave one of them out")
        one, other = _two(option, values, parts, name, device)
        spread[name] = Normal(one, other) if sign == "~" else Uniform(one, other)
    return spread


def _own_range(name: str, device: Device | None) -> str:
    """The range that a material states for a number of its own, as ``low:high``; empty where it states none."""
    from gelcone.devices.materials import RANGED

    field = name.removeprefix("material.")
    if device is None or field == name or field not in RANGED:
        return ""
    span = getattr(device.material, f"{field}_range")
    if span is None:
        raise InputError(
            f"--uncertain {name}: the material {device.material.name!r} states no range of it; give {name}=low:high"
        )
    return ":".join(f"{end:.15g}" for end in span)


def read_drawn(option: str, name: str, numbers: Array, unit: str, subject: Subject) -> Array:
    """A column of a table of draws; of a device in SI, from numbers in a unit that the table names."""
    device = subject.device
    if name not in STATES:
        _sweepable(option, name, device, subject.model.system)
    if name in subject.given:
        raise InputError(f"--set {name}: is drawn by --uncertain {option.partition(':')[0]}; leave one of them out")
    if device is None:
        if unit not in ("", "1"):
            raise InputError(f"{option} [{unit}]: a model without a device is dimensionless; leave the unit out")
        return numbers
    from gelcone.devices.points import swept_field
    from gelcone.devices.units import parse

    field = swept_field(device, name)
    if unit in ("", "1") and field.unit not in ("", "1"):
        example = field.example_text()
        raise InputError(f"{option}: has no unit; write it into the header, as in {name} [{example.split()[-1]}]")
    return numbers if unit in ("", "1") else numbers * parse(option, f"1 {unit}", field.unit)


def _two(option: str, text: str, parts: list[str], name: str, device: Device | None) -> list[float]:
    """The two numbers of a distribution."""
    _one_manner(f"{option}={text}", parts)
    if device is None:
        return [_plain(option, part) for part in parts]
    from gelcone.devices.points import point_fields

    return [_of_field(option, part, point_fields(device)[name]) for part in parts]

"""The subject of an analysis, read from text: a device or preset, settings, an initial state, swept values.

There is one language at a time. With a device names are its fields and every number has its SI unit: a bare number is
the SI value of a field, and is refused where it is not a field's. Without a device names are the model's parameters and
numbers are dimensionless.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from gelcone.analyses.swept import example, increasing, only_of_model, read_over
from gelcone.analyses.values import (
    no_decimal_comma,
    pairs,
    parts_of,
    read_field,
    read_measure,
    read_measures,
    read_pairs,
    read_table,
    read_value,
    unit_or_brackets,
)
from gelcone.atlas.plan import DEFAULT_INITIAL
from gelcone.devices.analysis import check_one
from gelcone.devices.points import STATES, dimensionless_state
from gelcone.errors import InputError, check_name, nearest
from gelcone.physics.model import ConeModel
from gelcone.quantity import Array
from gelcone.register.analysis import Analysis, annotation_of

if TYPE_CHECKING:
    from gelcone.devices.device import Device


@dataclass(frozen=True)
class Subject:
    """The subject of an analysis: a model, perhaps of a device, and its initial state.

    Attributes
    ----------
    model : the dimensionless model, of the device if there is one.
    device : the device; None without one.
    initial : the initial state, dimensionless.
    start : the same with a device, in SI, where it was stated; None for that of the device.
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
        """The device or, without one, the model: the first argument of a plan."""
        return self.model if self.device is None else self.device

    @property
    def beginning(self) -> tuple[float, ...] | None:
        """The initial state of a plan."""
        return self.initial if self.device is None else self.start

    def over(self, texts: Iterable[str]) -> dict[str, Array]:
        """The swept parameters of a plan with their values, see `read_over`; those of a device in SI."""
        swept = read_over(texts, self.device, self.model.system)
        self._not_set(swept)
        return swept

    def axes(self, texts: Iterable[str], analysis: Analysis, *, in_si: bool = False) -> dict[str, Array]:
        """The values of ``--over`` for an analysis with axes of its own: keyword -> values, dimensionless or, with a
        device, ``in_si``.

        Raises `InputError` for another name, and what `read_over` refuses.
        """
        axes_by_name = {axis.name(self.device is not None): (keyword, axis) for keyword, axis in analysis.axes.items()}
        given_axes: dict[str, Array] = {}
        form = f"name=from:to:count or name=v1,v2,..., for example {example(self.device, next(iter(axes_by_name)))}"
        for name, values in pairs("--over", texts, form).items():
            if name not in axes_by_name:
                axes_text = f"{analysis.command} sweeps {' and '.join(axes_by_name)}"
                parts = [f"--over {name}: cannot be swept here", axes_text, nearest(name, axes_by_name)]
                raise InputError("; ".join(filter(None, parts)))
            keyword, axis = axes_by_name[name]
            _, quantity = annotation_of(analysis.call, keyword)
            numbers = np.atleast_1d(read_measures(f"--over {name}", values, quantity, self.device, in_si=in_si))
            if numbers.size < axis.least and axis.one:
                at = f'gelcone {axis.one} --set "{name}={values}"'
                raise InputError(f"--over {name}: has one point; give at least two, or take {at}")
            given_axes[keyword] = increasing(f"--over {name}", numbers, axis.least)
            if axis.replaces:
                self._not_set([name])
        defaults = {k: np.linspace(*a.default) for k, a in analysis.axes.items() if a.default is not None}
        return defaults | given_axes

    def _not_set(self, swept: Iterable[str]) -> None:
        for name in swept:
            if name in self.given:
                raise InputError(f"--set {name}: is swept by --over {name}; leave one of them out")

    @contextmanager
    def axes_as_typed(self, texts: Iterable[str], analysis: Analysis) -> Iterator[None]:
        """Name the axes in errors of the input as ``--over`` gave them."""
        try:
            yield
        except InputError as error:
            raise InputError(self._as_typed(str(error), texts, analysis)) from None

    def _as_typed(self, message: str, texts: Iterable[str], analysis: Analysis) -> str:
        """A message about ``voltages = -1.0: ...`` as one about ``--over constant_voltage=-1: ...``."""
        typed = pairs("--over", texts, "")
        for keyword, axis in analysis.axes.items():
            name = axis.name(self.device is not None)
            match = re.match(rf"({keyword}s?|{name})( (=|from) [^:]*)?: ", message)
            if match and name in typed:
                return f"--over {name}={typed[name]}: {message[match.end() :]}"
        return message

    def without_initial(self, remedy: str) -> None:
        """`InputError` with the remedy where an initial state was stated."""
        if self.starts:
            raise InputError(f"--initial: {remedy}")


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
    InputError : for a device together with a preset, a film given twice, unknown names, and values that cannot be used.
    """
    given = read_pairs(settings, device is not None)
    if film is not None and "film" in given:
        raise InputError(f"--film {film} and --set film={given['film']} are both given; give one or the other")
    if device is not None:
        if preset is not None:
            raise InputError(f"--preset {preset} and the device {device!r} are both given; give one or the other")
        return _of_device(device, given, film, initial)
    for name, text in given.items():
        no_decimal_comma(f"--set {name}", text, parts_of(text))
    values = {name: read_value(text) for name, text in given.items()}
    of_film = {} if film is None or "pull_in" not in values else {"pull_in": values.pop("pull_in")}
    only_of_model(values)
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

    chosen_device = find_device(device) if isinstance(device, str) else device
    texts = ({} if film is None else {"film": film}) | given
    fields = chosen_device.fields_with({setting: read_table(text) for setting, text in texts.items()})
    for setting, text in given.items():
        unit_or_brackets(f"--set {setting}", text)
    changes = {setting: read_field(f"--set {setting}", text, setting, fields) for setting, text in texts.items()}
    if changes:
        chosen_device = chosen_device.replace(**changes)
    model = chosen_device.to_model()
    start = None if initial is None else read_initial(initial, chosen_device, model)
    if start is None:
        state = chosen_device.initial_state()
    else:
        state = dimensionless_state(chosen_device, start)
        state = state if state.ndim > 1 else tuple(map(float, state))
    return Subject(model, chosen_device, state, start, initial is not None, frozenset(given))


def read_initial(text: str, device: Device | None, model: ConeModel) -> tuple[float, ...]:
    """A displacement and a velocity, or all states, dimensionless or - with a device - with units, in SI; or some of
    the states by name, ``displacement=0.5,charge=0.2``, of which the others start by default."""
    parts, states = [part.strip() for part in text.split(",")], model.system.states
    names = [state.name for state in states]
    named = [part.partition("=")[::2] for part in parts] if "=" in text else []
    if not named and len(parts) not in (2, len(names)):
        form, alone = ("1,0", "0.5") if device is None else ('"5 mm,0 m/s"', '"5 mm"')
        more_forms = f", or all states ({', '.join(names)}), or some by name=value" if len(names) > 2 else ""
        form += f" or --initial displacement={alone}" if more_forms else ""
        raise InputError(
            f"--initial {text!r}: must be a displacement and a velocity{more_forms}, for example --initial {form}"
        )
    given = [(name.strip(), value.strip()) for name, value in named] or list(zip(names, parts, strict=False))
    given_states: dict[str, float] = {}
    for name, part in given:
        check_name("component of --initial", name, names)
        if name in given_states:
            raise InputError(f"--initial {name}: is given twice; give it once")
        given_states[name] = _read_component(name, part, states[names.index(name)].quantity, device)
    if len(given_states) == 2 and given_states.keys() == STATES.keys():
        return given_states["displacement"], given_states["velocity"]
    return _completed(given_states, device, model)


def _read_component(name: str, part: str, quantity: str, device: Device | None) -> float:
    from gelcone.devices.scales import MEASURES

    pure = quantity not in MEASURES
    return read_measure(f"--initial {name}", part, quantity, None if pure else device, in_si=True)


def _completed(found: Mapping[str, float], device: Device | None, model: ConeModel) -> tuple[float, ...]:
    """All states of a single actuator, those that are not ``found`` at their start; of a device in SI."""
    check_one(model, "--initial by name")
    sizes = np.ones(len(model.system.states))
    default_state = DEFAULT_INITIAL
    if device is not None:
        from gelcone.devices.scales import MEASURES

        state_scales = [device.scales.size(s.quantity) if s.quantity in MEASURES else 1.0 for s in model.system.states]
        sizes, default_state = np.array(state_scales, dtype=float), device.initial_state()
    disc = [found[name] / sizes[k] if name in found else default_state[k] for k, name in enumerate(STATES)]
    start = model.members().start_states(disc)[0] * sizes
    return tuple(found.get(s.name, float(value)) for s, value in zip(model.system.states, start, strict=True))

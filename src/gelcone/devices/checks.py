"""Checks of the fields of a device taken together: contradictions, and implausible values."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import astuple

import numpy as np

from gelcone.devices.cone import cone_of_device, undamped_cone
from gelcone.devices.fields import BELONGING, DAMPINGS, ELECTRIC, DeviceFields
from gelcone.devices.units import FieldError, format_si
from gelcone.errors import InputError
from gelcone.physics.model import ConeModel
from gelcone.physics.statics import every_balance

THICK = 0.5
"""Thickness, over the width b - a of the ring, above which a film is too thick for the membrane model."""
SAME = 1e-9
"""Share by which radii differ that are one, as where 25 mm is a value of two axes, with different rounding."""
_FAR = {"m": 10.0, "kg": 10.0, "Pa": 10.0, "m/s^2": 1.0, "ohm": 1.0}
"""Units of fields whose values are compared with the usual range -> the factor beyond the range that causes a warning.
A drive may be as small as one likes."""

SCALED = ("disc_radius", "film_radius", "film_thickness", "moving_mass", "payload", "material.shear_modulus")
"""Fields that give the scales of time and energy."""


def misfits(device: DeviceFields) -> Iterator[FieldError]:
    """Find the errors of the fields of a device taken together."""
    errors = [*_own_misfits(device)]
    yield from errors
    if not errors:
        with np.errstate(all="ignore"):
            try:
                undamped = undamped_cone(device)
                _check_heights(device, undamped)
                cone_of_device(device, undamped)
            except FieldError as error:
                yield error
            except InputError as error:
                yield FieldError(str(error).split(" ")[0], str(error))


def _own_misfits(device: DeviceFields) -> Iterator[FieldError]:
    lengths = {n: value.size for n in device.swept_fields() if isinstance(value := device.get(n), np.ndarray)}
    if len(set(lengths.values())) > 1:
        counts = ", ".join(f"{name} has {length}" for name, length in lengths.items())
        yield FieldError(next(iter(lengths)), f"{counts} values; give lists of one length")
        return
    for owner, names in BELONGING:
        if getattr(device, owner) is None:
            for name in names:
                if getattr(device, name) is not None:
                    yield FieldError(name, f"{name}: there is no {owner}; give {owner}, or leave {name} out")
    yield from _circuit_misfits(device)
    if device.second_voltage is not None and device.second_film is not None and device.second_drive != "constant":
        yield FieldError("second_voltage", 'second_voltage: is taken where second_drive is "constant" alone; give that')
    given = [name for name in DAMPINGS if getattr(device, name) is not None]
    if not given:
        yield FieldError(
            DAMPINGS[0],
            f"{DAMPINGS[0]}: is missing; give the viscous damping in N s/m, or {' or '.join(DAMPINGS[1:])}",
        )
    if len(given) > 1:
        yield FieldError(given[1], f"{' and '.join(given)} are both given; give one of them")
    yield from _size_misfits(device)


def _size_misfits(device: DeviceFields) -> Iterator[FieldError]:
    disc, film = np.broadcast_arrays(device.disc_radius, device.film_radius)
    if (disc >= (1.0 - SAME) * film).any():
        at = int(np.argmax(disc - film))
        yield FieldError(
            "disc_radius",
            f"disc_radius = {format_si(disc.flat[at], 'm')}: must be less than film_radius = "
            f"{format_si(film.flat[at], 'm')}; make the disc smaller or the film larger",
        )
    elif not _usable_scales(device):
        unlikely = [(name, value, usual) for name, value, usual in _unusual(device) if name in SCALED]
        for name, value, usual in unlikely[:1]:
            yield FieldError(
                name, f"{name} = {value}: gives no finite time and energy; usual is {usual}, check its unit"
            )
        if not unlikely:
            yield FieldError(
                "film_thickness", "the sizes, mass and shear modulus give no finite time and energy; check their units"
            )


def _unusual(device: DeviceFields) -> Iterator[tuple[str, str, str]]:
    """Find the fields far outside their usual range: name, value and range."""
    for name, field in device.all_fields().items():
        odd = field.implausible(device.get(name), _FAR[field.unit]) if field.unit in _FAR else None
        if odd is not None:
            yield name, format_si(odd, field.unit), field.typical_text()


def _circuit_misfits(device: DeviceFields) -> Iterator[FieldError]:
    if device.circuit in (None, "ideal"):
        return
    kind = device.circuit if isinstance(device.circuit, str) else device.circuit.name
    for name in ELECTRIC:
        if device.get(name) is not None:
            yield FieldError(name, f"{name}: the circuit {kind!r} does not take it; leave out one of the two")


def _usable_scales(device: DeviceFields) -> bool:
    try:
        with np.errstate(all="ignore"):
            return all(bool((np.isfinite(scale) & (np.asarray(scale) > 0.0)).all()) for scale in astuple(device.scales))
    except (OverflowError, ZeroDivisionError):
        return False


def _check_heights(device: DeviceFields, model: ConeModel) -> None:
    members = model.members()
    system, n = model.system, members.numbers()
    flat = np.broadcast_to(system.film.strain(np.zeros(members.size), n), members.shape)
    limit = np.broadcast_to(system.film.strain_limit(n), members.shape)
    if not (flat < limit).any():
        raise FieldError(
            "prestretch",
            f"prestretch: mounted flat, the film has I1 - 3 = {float(flat[0]):.4g}, which must be "
            f"less than its stretch limit {float(limit[0]):.4g}; lower the pre-stretch or raise "
            "the limit",
        )
    if len(system.films) > 1 and not any(balance.reachable for balance in every_balance(model)):
        raise FieldError("second_flat_height", system.unreachable(members.numbers_at(0)))
    if device.release_height is None:
        return
    lengths = np.broadcast_to(device.scales.length, members.shape)
    starts = np.broadcast_to(device.release_height, members.shape) / lengths
    if not (members.strain(starts) >= members.strain_limit()).all():
        return
    start = f"release_height = {format_si(np.ravel(device.release_height)[0], 'm')}"
    if len(system.films) > 1:
        reason = "out of reach of the films within their stretch limits; start between their planes"
        raise FieldError("release_height", f"{start}: is {reason} or raise material.stretch_limit")
    highest = system.film.reach(members.numbers_at(0))[1] * lengths[0]
    raise FieldError(
        "release_height",
        f"{start}: must be less than {format_si(highest, 'm')}, where the film reaches its stretch limit "
        f"{float(limit[0]):.4g}; start lower or raise material.stretch_limit",
    )


def doubts(device: DeviceFields) -> list[str]:
    """Warnings about values far outside the usual range, one line each."""
    lines = [
        f"{name} = {value} is outside the usual range, {usual}; check its unit"
        for name, value, usual in _unusual(device)
    ]
    with np.errstate(all="ignore"):
        thick = np.ravel(np.asarray(device.film_thickness) / device.scales.length)
    if thick.max() > THICK and not any(text.startswith("film_thickness") for text in lines):
        at = int(thick.argmax())
        thickness, width = (np.broadcast_to(v, thick.shape)[at] for v in (device.film_thickness, device.scales.length))
        lines.append(
            f"film_thickness = {format_si(thickness, 'm')} is too thick for the membrane model on a "
            f"ring {format_si(width, 'm')} wide "
            "(film_radius - disc_radius); check the units"
        )
    return lines

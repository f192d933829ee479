"""The dimensionless model of a device, and its initial state."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable
from typing import Any

import numpy as np

from gelcone.devices.fields import DeviceFields
from gelcone.devices.numbers import numbers_of
from gelcone.devices.parts import component_of
from gelcone.devices.scales import Scales, carried_mass
from gelcone.devices.units import FieldError
from gelcone.physics.bias import Bias, Together
from gelcone.physics.film.film import Film
from gelcone.physics.film.gel import BranchedFilm, GelFilm
from gelcone.physics.model import ConeModel
from gelcone.physics.records import find_bias
from gelcone.physics.statics import balances_of, rest_displacements, switched_off


def model_of_device(device: DeviceFields) -> ConeModel:
    """Make the model with the film of the device; arrays make an ensemble of their length."""
    return _damped(device, lambda ratio: _model(device, ratio))


def cone_of_device(device: DeviceFields, undamped: ConeModel | None = None) -> ConeModel:
    """Make the model with taut cones, which are quick, in place of films that ship; a user-defined film stays.

    ``undamped`` is the result of `undamped_cone`, if it is known.
    """
    return _damped(device, lambda ratio: _model(device, ratio, cone=True), undamped)


def critical_share(get: Callable[[str], Any]) -> Any:
    """The damping over the critical one about the rest, from the fields of a device; None where neither damping ratio
    nor quality factor is given."""
    quality = get("quality_factor")
    return get("damping_ratio") if quality is None else 0.5 / quality


def undamped_cone(device: DeviceFields) -> ConeModel:
    """Make the model of `cone_of_device` without damping, which may refer to a rest that does not exist."""
    return _model(device, np.zeros(device.shape)[()], cone=True)


def initial_state(device: DeviceFields) -> Any:
    """Displacement and velocity at t = 0, dimensionless: two numbers, or an array (members, 2) where they differ.

    Raises `InputError` without a release height and a rest.
    """
    s = device.scales
    velocity = device.release_velocity / s.velocity
    if device.release_height is not None:
        x = device.release_height / s.length
    else:
        model = _model(device)
        x = rest_displacements(model)
        if np.isnan(x).all():
            balances_of(switched_off(model))  # raises where no height at all is possible
            raise FieldError(
                "initial_height",
                "initial_height: no stable rest position was found without voltage; give a release_height",
            )
        # A member without a rest has a film beyond its stretch limit, and fails wherever it starts.
        x = np.where(np.isnan(x), 0.0, x)[()]
    states = np.stack(np.broadcast_arrays(x, velocity), axis=-1)
    if states.ndim > 1 and (states != states[0]).any():
        return states
    return float(np.ravel(x)[0]), float(np.ravel(velocity)[0])


def breakdown_field(device: DeviceFields) -> Any:
    """Dielectric strength over the scale of the field; None if it is unknown."""
    device_strength = device.dielectric_strength
    strength = device.material.dielectric_strength if device_strength is None else device_strength
    return None if strength is None else strength / device.scales.field


def _model(device: DeviceFields, damping_ratio: Any = 0.0, *, cone: bool = False) -> ConeModel:
    """Make the model with a damping ratio; ``cone``: with taut cones in place of films that ship."""
    film = "taut" if cone and not isinstance(device.film, Film) else device.film
    numbers = {
        parameter: device.scales.dimensionless(quantity, value)
        for parameter, (field, quantity) in numbers_of(device).items()
        if (value := device.get(field)) is not None
    }
    own = component_of("film", film)
    if (count := device.material.branches) and not isinstance(own, BranchedFilm):
        raise FieldError(
            "material.viscous_modulus_1",
            f"material.viscous_modulus_1: the film {own.name!r} does not creep; set film = membrane, wrinkling or taut",
        )
    if isinstance(own, BranchedFilm) and (count or own.branches):
        of_gel = {"branches": count, "flow": device.material.flow or "log"} if count else {}
        own = film = dataclasses.replace(own, rested="raised", **of_gel)  # a device has crept at its rest
    if "radius_ratio" in own.parameters:
        numbers["radius_ratio"] = device.disc_radius / device.film_radius
    gel = isinstance(own, GelFilm)
    if gel:
        numbers |= {"law": device.material.law, "prestretch_mode": device.prestretch_mode}
    else:
        numbers = {name: value for name, value in numbers.items() if name not in device.material.law_parameters}
    numbers |= following(device, device.get, device.scales)
    if device.second_film is not None:
        numbers |= {
            "second_film": "taut" if cone else device.second_film,
            "second_drive": device.second_drive or "same",
        }
    return ConeModel(
        **_loads(device) | numbers,
        film=film,
        pull_in=None if cone else device.pull_in,
        reduced=None if cone else device.reduced,
        damping_ratio=damping_ratio,
        dielectric_strength=breakdown_field(device),
        waveform=device.waveform,
        circuit=device.circuit or "ideal",
    )


def following(device: DeviceFields, get: Callable[[str], Any], scales: Scales) -> dict[str, Any]:
    """Weight and filter time, which follow from several fields of a device, of numbers or expressions."""
    numbers: dict[str, Any] = {}
    if device.gravity is not None:
        numbers["weight"] = carried_mass(get) * get("gravity") / scales.force
    if device.filter_frequency is not None:
        numbers["filter_time"] = scales.frequency / get("filter_frequency")
    return numbers


def _loads(device: DeviceFields) -> dict[str, Any]:
    """The bias of a device, and the parameters of the beam that it leaves at 0."""
    kinds, numbers = ["spring"], {}
    if device.beam_rate is not None:
        kinds.append("beam")
        numbers = {"beam_cubic": 0.0, "beam_height": 0.0}
    if device.gravity is not None:
        kinds.append("weight")
    if device.constant_force is not None:
        kinds.append("force")
    bias: Any = "+".join(kinds)
    if isinstance(device.bias, Bias):
        more = device.bias.parts if isinstance(device.bias, Together) else (device.bias,)
        bias = Together((*(find_bias(kind) for kind in kinds), *more))
    return {"bias": bias} | numbers


def _damped(device: DeviceFields, build: Callable[[Any], ConeModel], undamped: ConeModel | None = None) -> ConeModel:
    """Make the model by ``build`` from the damping ratio c/(2 m Omega0) of the device; ``undamped`` is that of 0."""
    if device.damping_coefficient is not None:
        ratio = device.damping_coefficient * device.scales.time / (2.0 * carried_mass(device.get))
        return build(np.broadcast_to(ratio, device.shape)[()])
    model = build(0.0) if undamped is None else undamped
    name = "damping_ratio" if device.quality_factor is None else "quality_factor"
    rests = rest_displacements(model)
    if np.isnan(rests).any():
        raise FieldError(
            name,
            f"{name}: refers to the free vibration about the rest without voltage, and no such rest was found within "
            "the stretch limit; lower the pre-stretch, change spring or bias, or give damping_coefficient",
        )
    stiffness = np.asarray(switched_off(model).stiffness(rests))
    if not (stiffness > 0.0).all():
        raise FieldError(
            name,
            f"{name}: refers to the free vibration about the rest without voltage, and there is none, for nothing "
            "pulls the disc back; give damping_coefficient",
        )
    ratio = critical_share(device.get) * np.sqrt(stiffness)
    return model.replace(damping_ratio=np.broadcast_to(ratio, device.shape)[()])

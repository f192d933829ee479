"""Answers about constant voltages: equilibria, pitchfork, folds, pull-in, stroke and blocked force."""

from __future__ import annotations

import json
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from gelcone.analyses.answer import heading, outcome_lines
from gelcone.errors import InputError
from gelcone.physics.balance import PullIn
from gelcone.words import FAILINGS, meaning_at, measured, members_of, shortened, strength_in_words, unit_of

if TYPE_CHECKING:
    import xarray as xr

    from gelcone.analyses.request import Subject


def static_arguments(subject: Subject, given: Mapping[str, Any]) -> dict[str, Any]:
    """The arguments of `gelcone.static`."""
    if (np.diff(np.atleast_1d(given.get("displacements", 0.0))) <= 0.0).any():
        raise InputError("--displacements: must increase; sort the values and remove duplicates")
    return dict(given)


def static_json(result: xr.Dataset, subject: Subject) -> dict[str, Any]:
    """The JSON object; for an ensemble each entry is a list over its members."""
    own = _own_levels(result, subject) if json.loads(result.attrs["options"])["voltages"] is None else None
    return _members_json(result, own)


def _own_levels(result: xr.Dataset, subject: Subject) -> list[int]:
    """For each member, which of the voltages is the peak of its own drive."""
    scale = 1.0 if subject.device is None else subject.device.scales.shown("voltage")
    own = np.broadcast_to(subject.model.peak_voltage * scale, subject.model.shape).ravel()
    levels = [member["constant_voltage"].values for _, member in members_of(result)]
    return [int(np.abs(known - peak).argmin()) for known, peak in zip(levels, own, strict=True)]


def _members_json(result: xr.Dataset, own: list[int] | None) -> dict[str, Any]:
    """The members side by side; a single one by itself."""
    each = [
        _member_json(member) | ({} if own is None else {"equilibria": _equilibria(member, own[i])})
        for i, (_, member) in enumerate(members_of(result))
    ]
    return each[0] if not result["outcome"].dims else {name: [one[name] for one in each] for name in each[0]}


def _member_json(member: xr.Dataset) -> dict[str, Any]:
    """What is known of one actuator."""
    folds = np.isfinite(member["fold_voltage"].values)
    return {
        "pitchfork_voltage": member["pitchfork_voltage"],
        "fold_voltages": member["fold_voltage"].values[folds],
        "fold_displacements": member["fold_displacement"].values[folds],
        "pull_in": {
            "voltage": member["pull_in_voltage"],
            "kind": PullIn(int(member["pull_in_kind"])).name.lower(),
            "from": member["pull_in_from"],
            "to": member["pull_in_to"],
        },
        "rest_displacement": member["rest_displacement"],
        "displacement": member["displacement"],
        "curves": [
            {
                "voltage": member["constant_voltage"][i],
                "equilibria": _equilibria(member, i),
                **{name: member[name][i] for name in ("stroke", "blocked_force", "cycle_work", "force")},
            }
            for i in range(member.sizes["constant_voltage"])
        ],
    }


def _equilibria(member: xr.Dataset, level: int) -> list[dict[str, Any]]:
    """The equilibria at one of the voltages."""
    one = member.isel(constant_voltage=level)
    names = {"displacement": "equilibrium_displacement", "slope": "slope"}
    return [
        {key: one[name][k] for key, name in names.items()}
        | {"stable": bool(one["stable"][k]), "validity": {name: one[f"validity_{name}"][k] for name in FAILINGS}}
        | {name: _state(one[name][k]) for name in ("film_state", "second_film_state") if name in one}
        for k in range(int(one["equilibria"]))
    ]


def _state(code: xr.DataArray) -> str | None:
    """The name of the film's state; None where it has none."""
    return None if int(code) < 0 else meaning_at(code, int(code))


def static_words(shown: xr.Dataset, subject: Subject) -> str:
    """The statics as text."""
    lines = heading(subject) + outcome_lines(shown)
    members = members_of(shown)
    fitted = any(film.film.name == "continuum" for film in subject.model.system.films)
    if len(members) == 1:
        return "\n".join(lines + _curve_lines(members[0][1]) + _event_lines(members[0][1], fitted))
    listed = [line for name, one in members for line in (f"{name}:", *(f"  {e}" for e in _event_lines(one, fitted)))]
    return "\n".join(lines + shortened(listed))


def _curve_lines(member: xr.Dataset) -> list[str]:
    """The equilibria, stroke and blocked force at each voltage."""
    if int(member["outcome"]):
        return []
    length = unit_of(member["displacement"])
    lines = []
    for i in range(member.sizes["constant_voltage"]):
        one = member.isel(constant_voltage=i)
        places = [f"{float(e['displacement']):.4g}{length} ({', '.join(_about(e))})" for e in _equilibria(member, i)]
        yields = {"stroke": "stroke", "blocked force": "blocked_force", "work of a cycle": "cycle_work"}
        told = [f"{words} {measured(one[name])}" for words, name in yields.items() if np.isfinite(one[name])]
        lines.append(
            f"  {measured(one['constant_voltage'])}: rests at {', '.join(places) or 'nothing'}; "
            f"{', '.join(told) or 'beyond pull-in'}"
        )
    return ["constant voltage:", *shortened(lines), *strength_in_words(member)]


def _about(equilibrium: dict[str, Any]) -> list[str]:
    """Whether an equilibrium is stable, the states of films that wrinkle, and which assumptions of the model fail."""
    states = [
        f"{film} {str(equilibrium[name]).replace('_', ' ')}"
        for name, film in (("film_state", "film"), ("second_film_state", "second film"))
        if equilibrium.get(name) not in (None, "taut")
    ]
    failing = [name for name in FAILINGS if float(equilibrium["validity"][name]) > 0.0]
    return ["stable" if equilibrium["stable"] else "unstable", *states, *(FAILINGS[name] for name in failing)]


def _event_lines(member: xr.Dataset, fitted: bool = False) -> list[str]:
    """Pitchfork, folds and pull-in; ``fitted`` says whether the range of a fit may end first."""
    if int(member["outcome"]):
        return ["nothing can be reached inside the stretch limit"]
    volt, length = unit_of(member["constant_voltage"]), unit_of(member["displacement"])
    pitchfork = float(member["pitchfork_voltage"])
    lines = [f"pitchfork of the flat film at {pitchfork:.4g}{volt}"] if np.isfinite(pitchfork) else []
    for voltage, place in zip(member["fold_voltage"].values, member["fold_displacement"].values, strict=True):
        if np.isfinite(voltage):
            lines.append(f"fold at {voltage:.4g}{volt}, displacement {place:.4g}{length}")
    kind = PullIn(int(member["pull_in_kind"]))
    voltage, begin, end = (float(member[f"pull_in_{part}"]) for part in ("voltage", "from", "to"))
    ramp = "slow voltage ramp from 0"
    if np.isnan(voltage):
        return [*lines, f"{ramp}: no stable equilibrium to start from"]
    if kind == PullIn.NEVER:
        return [*lines, f"{ramp}: {kind.meaning}"]
    event = f"{ramp}: at {voltage:.4g}{volt} the disc {kind.meaning}"
    if fitted and kind == PullIn.FILM:
        event += " or its displacement leaves the range of the fit"
    if np.isinf(end):
        return [*lines, event]
    return [*lines, f"{event} ({'it leaves it gradually' if begin == end else f'moves to {end:.4g}{length}'})"]

"""Answers about constant voltages: equilibria, pitchfork, folds, pull-in, stroke and blocked force."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from gelcone.amounts import sized
from gelcone.analyses.answer import heading, outcome_lines, state_lines
from gelcone.physics.balance import STAYS, PullIn
from gelcone.words import FAILINGS, event_label, members_of, shortened, strength_in_words

if TYPE_CHECKING:
    import xarray as xr

    from gelcone.analyses.request import Subject
    from gelcone.physics.placed import PlacedFilm


def static_words(shown: xr.Dataset, subject: Subject) -> str:
    """The statics as text."""
    lines = heading(subject) + state_lines(shown, subject) + outcome_lines(shown)
    members, last = members_of(shown), subject.model.system.films[-1]
    if len(members) == 1:
        return "\n".join(lines + _curve_lines(members[0][1], last) + _event_lines(members[0][1], last.drive))
    listed = [
        line
        for name, one in members
        for line in (f"{name}:", *(f"  {text}" for text in (*_curve_lines(one, last), *_event_lines(one, last.drive))))
    ]
    return "\n".join(lines + shortened(listed))


def _curve_lines(member: xr.Dataset, last: PlacedFilm) -> list[str]:
    """The equilibria, stroke and blocked force at each voltage, given the ``last`` film."""
    if int(member["outcome"]):
        return []
    lines = []
    for i in range(member.sizes["constant_voltage"]):
        one = member.isel(constant_voltage=i)
        equilibria = [one.isel(equilibrium=k) for k in range(int(one["equilibria"]))]
        places = [f"{sized(e['equilibrium_displacement'])} ({', '.join(_about(e))})" for e in equilibria]
        yields = {"stroke": "stroke", "blocked force": "blocked_force", "work of a cycle out and back": "cycle_work"}
        named = [f"{words} {sized(one[name])}" for words, name in yields.items() if np.isfinite(one.get(name, np.nan))]
        if not np.isfinite(one["stroke"]):
            beyond = one["constant_voltage"] >= one["pull_in_voltage"]
            named.append("beyond pull-in" if beyond else "no slow ramp leads there")
        where = f"{'equilibrium' if len(places) == 1 else 'equilibria'} at {', '.join(places)}"
        lines.append(f"  {sized(one['constant_voltage'])}: {where if places else 'no equilibrium'}; {', '.join(named)}")
    of_film = " of the first film" if last.has_other_voltage else ""
    return [f"constant voltage{of_film}:", *shortened(lines), *strength_in_words(member)]


def _about(equilibrium: xr.Dataset) -> list[str]:
    """Whether an equilibrium is stable, the voltages on films that do not rest at the commanded one, the states of
    films that wrinkle, and which assumptions of the model fail."""
    states = [
        f"{film} {event_label(equilibrium[name])}"
        for name, film in (("film_state", "film"), ("second_film_state", "second film"))
        if name in equilibrium and int(equilibrium[name]) > 0
    ]
    known = {name: equilibrium.get(f"validity_{name}", 0.0) for name in FAILINGS}  # files of 0.2 do not have all
    failing = [text for name, text in FAILINGS.items() if float(known[name]) > 0.0]
    volts = [
        f"{sized(equilibrium[name])} on the {film}"
        for name, film in (("film_voltage", "film"), ("second_film_voltage", "second film"))
        if name in equilibrium
    ]
    return ["stable" if equilibrium["stable"] else "unstable", *volts, *states, *failing]


def _event_lines(member: xr.Dataset, drive: str | None) -> list[str]:
    """Pitchfork, folds and pull-in, given the ``drive`` of the second film."""
    if int(member["outcome"]):
        return ["nothing can be reached inside the stretch limit"]
    lines = []
    if np.isfinite(member["pitchfork_voltage"]):
        at = "0" if "pitchfork_displacement" not in member else sized(member["pitchfork_displacement"])  # files of 0.2
        lines.append(f"pitchfork at {sized(member['pitchfork_voltage'])}, displacement {at}")
    for voltage, place in zip(member["fold_voltage"], member["fold_displacement"], strict=True):
        if np.isfinite(voltage):
            lines.append(f"fold at {sized(voltage)}, displacement {sized(place)}")
    kind = PullIn(int(member["pull_in_kind"]))
    voltage, end = member["pull_in_voltage"], member["pull_in_to"]
    ramp = f"slow voltage ramp{' of the first film' if drive == 'constant' else ''} from 0"
    if "ramp_begin_voltage" in member and member["ramp_begin_voltage"] > 0.0:
        ramp = f"slow voltage ramp of both films from 0 to {sized(member['ramp_begin_voltage'])}"
        if np.isnan(voltage) and member["rest_displacement"].notnull():
            return [*lines, f"{ramp}: pull-in on the way"]
        ramp += ", then of the first up and of the second down"
    if np.isnan(voltage):
        return [*lines, f"{ramp}: no stable equilibrium to start from"]
    if kind in STAYS:
        return [*lines, f"{ramp}: {kind.meaning}"]
    event = f"{ramp}: at {sized(voltage)} the disc {kind.meaning}"
    return [*lines, event if np.isinf(end) else f"{event} (moves to {sized(end)})"]

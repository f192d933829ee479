"""Answers about branches of periodic orbits."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from gelcone.amounts import unit_of
from gelcone.analyses.answer import heading
from gelcone.analyses.swept import read_over
from gelcone.analyses.values import is_number
from gelcone.atlas.branches.attached import attached_branches
from gelcone.dataset import load
from gelcone.errors import InputError, unknown_name
from gelcone.words import branch_endings, event_label, shortened, validity_in_words

if TYPE_CHECKING:
    import xarray as xr

    from gelcone.analyses.request import Subject


def continue_branch_arguments(subject: Subject, given: dict[str, Any]) -> dict[str, Any]:
    """The arguments of `gelcone.continue_branch`."""
    name, low, high = (str(given[key]) for key in ("parameter", "low", "high"))
    parameter, *ends = _interval(name, low, high, subject.over)
    if "start" in given:
        given["start"] = _start(str(given["start"]))
    return {**given, "parameter": parameter, "low": ends[0], "high": ends[1]}


def _interval(name: str, low: str, high: str, read: Callable[[list[str]], dict[str, Any]]) -> tuple[str, float, float]:
    """The name and the ends of an interval, by a function that takes ``NAME=from:to:2``; errors are in the words of a
    command that takes NAME FROM TO."""
    if is_number(low) and is_number(high) and float(low) >= float(high):
        what = "is empty" if float(low) == float(high) else "is reversed"
        raise InputError(f"{name} from {low} to {high}: {what}; give the lower end first, as in {name} 0.5 1.5")
    try:
        ((axis_name, ends),) = read([f"{name}={low}:{high}:2"]).items()
    except InputError as error:
        named = str(error).replace(f"--over {name} '{low}:{high}:2'", f"{name} from {low} to {high}")
        raise InputError(named.replace(f"{low}:{high}:2", f"{low} {high}").replace("--over ", "")) from None
    return axis_name, float(ends[0]), float(ends[-1])


def _start(text: str) -> Any:
    """``rest``, ``settled``, or a result that was written."""
    from gelcone.atlas.branches.continuation import STARTS

    if text in STARTS:
        return text
    if not Path(text).exists():
        if "/" in text or "." in text:
            raise InputError(f"--from {text}: no such file")
        raise unknown_name("start of branches", text, STARTS)
    return load(text)


def followed_lines(shown: xr.Dataset, name: str = "") -> list[str]:
    """The branches that go with a diagram, in words; ``name`` is what the parameter is called there."""
    followed = attached_branches(shown)
    if followed is None:
        return []
    return branch_lines(followed, name)


def continue_branch_words(shown: xr.Dataset, subject: Subject) -> str:
    """Branches as text: each with its events, how it ends, and what brute force says."""
    return "\n".join([*heading(subject, [shown.attrs["parameter"]]), *branch_lines(shown), *_cut_lines(shown)])


def _cut_lines(shown: xr.Dataset) -> list[str]:
    """State the values before which intervals were cut, and why these make no actuator."""
    cut = shown.attrs.get("impossible")
    return [] if cut is None else [f"no actuator can be made {cut}"]


def branch_lines(shown: xr.Dataset, name: str = "") -> list[str]:
    """Describe the branches, each in a few lines."""
    name, unit = name or shown.attrs["parameter"], unit_of(shown["value"])
    lines = []
    for k in range(shown.sizes["branch"]):
        branch = shown.isel(branch=k)
        values = branch["value"].values[np.isfinite(branch["value"].values)]
        kind = "rest" if bool(branch["resting"]) else f"period {int(branch['period'])}"
        kind += ", symmetric" * bool(branch["symmetric"])
        share = float((branch["stable"] == 1).sum()) / values.size
        lines.append(
            f"branch {k}: {kind}, {name} {values.min():.6g} to {values.max():.6g}{unit}, {values.size} points, "
            f"{100 * share:.3g} % of them stable; ends: {', '.join(branch_endings(branch))}"
        )
        lines += [f"  {line}" for line in validity_in_words(branch)]
        lines += [_event_line(shown.isel(event=e)) for e in np.flatnonzero(shown["event_branch"].values == k)]
    return [*shortened(lines), *_check_lines(shown, name)]


def _event_line(event: xr.Dataset) -> str:
    kind = {-1: "", 0: ", subcritical", 1: ", supercritical"}[int(event["event_supercritical"])]
    born = int(event["event_born_branch"])
    leaves = f", branch {born} is born" if born >= 0 else ""
    unresolved = "" if int(event["event_resolved"]) else ", unresolved"
    return f"  {event_label(event['event_kind'])} at {_located(event, 'value')}{kind}{leaves}{unresolved}"


def _located(event: xr.Dataset, place: str) -> str:
    """The place of an event, with its error and unit."""
    value, error = event[f"event_{place}"], event["event_error" if place == "value" else f"event_{place}_error"]
    return f"{float(value):.10g} ± {float(error):.0e}{unit_of(value)}"


def _check_lines(shown: xr.Dataset, name: str) -> list[str]:
    """Report the agreement of a branch with direct simulation."""
    cycles, orbits, seeded = (int(shown[key]) for key in ("checked_cycles", "checked_orbits", "seeded"))
    ran = f"{orbits} stable orbits run from 1e-5 away" if orbits else "no stable orbit decays fast enough to be run"
    explanations = [str(text) for text in shown["flag_explanation"].values]
    explained = sum(map(bool, explanations))
    lines = [
        f"brute force: {cycles} settled cycles, all on these branches ({seeded} started one); {ran}; "
        f"{len(explanations)} contradiction(s)" + f", {explained} explained" * bool(explained)
    ]
    flags, unit = [], unit_of(shown["value"])
    for k, explanation in enumerate(explanations):
        flag = shown.isel(flag=k)
        branch = "none" if flag["flag_branch"] < 0 else int(flag["flag_branch"])
        at = f"{name} {float(flag['flag_value']):.6g}{unit}"
        text = f"  {event_label(flag['flag_kind'])}, branch {branch}, {at}"
        flags.append(f"{text}: {explanation}" if explanation else text)
    return lines + shortened(flags)


# --- loci -------------------------------------------------------------------------------------------------------------


def locus_arguments(subject: Subject, given: dict[str, Any]) -> dict[str, Any]:
    """The arguments of `gelcone.locus`."""
    over: dict[str, tuple[float, float]] = {}
    for text in given.get("over", ()):
        name, _, ends = str(text).partition("=")
        parts = ends.split(":")
        if len(parts) not in (2, 3) or not name:
            raise InputError(f"--over {text}: must be NAME=from:to, for example --over voltage=0.9:1.5")
        if name in over:
            raise InputError(f"--over {name}: is given twice; give it once")
        read = partial(read_over, device=subject.device, system=subject.model.system)
        over[name] = _interval(name, parts[0], parts[1], read)[1:]
    if len(over) != 2:
        raise InputError(
            f"--over: a locus takes two parameters, not {len(over)}; for example {_two_intervals(subject)}"
        )
    return {**given, "over": over}


def _two_intervals(subject: Subject) -> str:
    if subject.device is None:
        return "--over voltage=0.95:1.5 --over drive_frequency=0.07:0.13"
    return '--over "voltage_amplitude=100 V:800 V" --over "frequency=5 Hz:20 Hz"'


def locus_words(shown: xr.Dataset, subject: Subject) -> str:
    """A locus as text."""
    names = shown.attrs["parameters"].split(",")
    lines = heading(subject, names)
    for k in range(shown.sizes["curve"]):
        curve = shown.isel(curve=k)
        spans = [
            f"{name} {float(curve[name].min()):.6g} to {float(curve[name].max()):.6g}{unit_of(curve[name])}"
            for name in names
        ]
        kind = f"period {int(curve['period'])}" + ", symmetric" * bool(curve["symmetric"])
        count = int(np.isfinite(curve[names[0]].values).sum())
        ends = ", ".join(branch_endings(curve))
        lines.append(f"curve {k}: {shown.attrs['event']}, {kind}, {', '.join(spans)}, {count} points; ends: {ends}")
        for e in np.flatnonzero(shown["event_curve"].values == k):
            event = shown.isel(event=e)
            at = ", ".join(
                f"{name} {_located(event, place)}" for place, name in zip(("first", "second"), names, strict=True)
            )
            lines.append(f"  {event_label(event['event_kind'])} at {at}")
    return "\n".join([*shortened(lines), *_cut_lines(shown)])

"""Answers about branches of periodic orbits."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any

import numpy as np

from gelcone.analyses.answer import heading
from gelcone.analyses.request import read_over
from gelcone.atlas.branches.attached import attached_branches
from gelcone.errors import InputError
from gelcone.words import branch_endings, event_label, flag_label, shortened, unit_of, validity_in_words

if TYPE_CHECKING:
    import xarray as xr

    from gelcone.analyses.request import Subject


def continue_branch_arguments(subject: Subject, given: Mapping[str, Any]) -> dict[str, Any]:
    """The arguments of `gelcone.continue_branch`."""
    name, low, high = (str(given[key]) for key in ("parameter", "low", "high"))
    _check_order(name, low, high)
    with _in_words(name, low, high):
        ((parameter, ends),) = subject.over([f"{name}={low}:{high}:2"]).items()
    arguments = {key: value for key, value in given.items() if key not in ("parameter", "low", "high")}
    if "start" in arguments:
        arguments["start"] = _start(str(arguments["start"]))
    return {"parameter": parameter, "low": float(ends[0]), "high": float(ends[-1]), **arguments}


@contextmanager
def _in_words(name: str, low: str, high: str) -> Iterator[None]:
    """What is told of ``--over NAME=from:to:2``, in the words of a command that takes NAME FROM TO."""
    try:
        yield
    except InputError as error:
        told = str(error).replace(f"--over {name} '{low}:{high}:2'", f"{name} from {low} to {high}")
        raise InputError(told.replace(f"{low}:{high}:2", f"{low} {high}").replace("--over ", "")) from None


def _check_order(name: str, low: str, high: str) -> None:
    """`InputError` for two equal or reversed numbers, in the words of the command."""
    try:
        reversed_ends = float(low) >= float(high)
    except ValueError:
        return
    if reversed_ends:
        what = "is empty" if float(low) == float(high) else "is reversed"
        raise InputError(f"{name} from {low} to {high}: {what}; give the lower end first, as in {name} 0.5 1.5")


def _start(text: str) -> Any:
    """``rest``, ``settled``, or a result that was written."""
    from gelcone.atlas.branches.continuation import STARTS

    if text in STARTS:
        return text
    from pathlib import Path

    from gelcone.dataset import load
    from gelcone.errors import unknown_name

    if not Path(text).exists():
        if "/" in text or "." in text:
            raise InputError(f"--from {text}: no such file")
        raise unknown_name("start of branches", text, STARTS)
    return load(text)


def continue_branch_json(result: xr.Dataset, subject: Subject) -> dict[str, Any]:
    """The JSON object of branches; their orbits are in the netCDF file."""
    return branches_json(result)


def branches_json(result: xr.Dataset) -> dict[str, Any]:
    """Branches, events, and what brute force says of them."""
    return {
        "parameter": result.attrs["parameter"],
        "branches": [_branch_json(result, k) for k in range(result.sizes["branch"])],
        "events": events_json(result),
        "check": {
            "cycles": int(result["checked_cycles"]),
            "orbits": int(result["checked_orbits"]),
            "seeded": int(result["seeded"]),
            "flags": flags_json(result),
        },
    }


def followed_json(diagram: xr.Dataset) -> dict[str, Any] | None:
    """The branches beside a bifurcation diagram; null where it has none."""
    followed = attached_branches(diagram)
    if followed is None:
        return None
    return branches_json(followed)


def followed_lines(shown: xr.Dataset, name: str = "") -> list[str]:
    """The branches beside a diagram in words; ``name`` is what the parameter is called there."""
    followed = attached_branches(shown)
    if followed is None:
        return []
    return branch_lines(followed, name)


def _branch_json(result: xr.Dataset, k: int) -> dict[str, Any]:
    own = result.isel(branch=k)
    there = np.isfinite(own["value"].values)
    born = int(own["born"])
    return {
        "number": k,
        "period": int(own["period"]),
        "symmetric": bool(own["symmetric"]),
        "rest": bool(own["resting"]),
        "level": int(own["level"]),
        "born_at_event": None if born < 0 else born,
        "ended": branch_endings(own),
        "values": own["value"].values[there],
        "stable": own["stable"].values[there].astype(bool),
        "lowest": own["lowest"].values[there],
        "highest": own["highest"].values[there],
        "lyapunov": own["lyapunov"].values[there],
    }


def events_json(result: xr.Dataset) -> list[dict[str, Any]]:
    """The events in the order of their branches."""
    parameter = result.attrs["parameter"]
    events = []
    for k in range(result.sizes["event"]):
        own = result.isel(event=k)
        branch, born, kind = int(own["event_branch"]), int(own["event_born_branch"]), int(own["event_supercritical"])
        events.append(
            {
                "kind": event_label(own["event_kind"]),
                "parameter": parameter,
                "value": float(own["event_value"]),
                "value_error": float(own["event_error"]),
                "period": int(result["period"][branch]),
                "symmetric": bool(result["symmetric"][branch]),
                "supercritical": None if kind < 0 else bool(kind),
                "multipliers": np.stack([own["event_multiplier_real"], own["event_multiplier_imag"]], axis=1).tolist(),
                "branch": branch,
                "born_branch": None if born < 0 else born,
            }
        )
    return events


def flags_json(result: xr.Dataset) -> list[dict[str, Any]]:
    """The contradictions between branches and brute force, and what explains them."""
    return [
        {
            "kind": flag_label(result["flag_kind"], k),
            "branch": None if int(result["flag_branch"][k]) < 0 else int(result["flag_branch"][k]),
            "value": float(result["flag_value"][k]),
            "explanation": str(result["flag_explanation"][k].values) or None,
        }
        for k in range(result.sizes["flag"])
    ]


def continue_branch_words(shown: xr.Dataset, subject: Subject) -> str:
    """Branches as text: each with its events, how it ends, and what brute force says."""
    name = shown.attrs["parameter"]
    return "\n".join([*heading(subject, [name]), *branch_lines(shown)])


def branch_lines(shown: xr.Dataset, name: str = "") -> list[str]:
    """What the branches are, line by line."""
    name, unit = name or shown.attrs["parameter"], unit_of(shown["value"])

    def at(value: float, form: str = ".10g") -> str:
        return f"{value:{form}}{unit}"

    lines = []
    for k in range(shown.sizes["branch"]):
        own = shown.isel(branch=k)
        values = own["value"].values[np.isfinite(own["value"].values)]
        kind = "rest" if bool(own["resting"]) else f"period {int(own['period'])}"
        kind += ", symmetric" * bool(own["symmetric"])
        share = float((own["stable"] == 1).sum()) / values.size
        lines.append(
            f"branch {k}: {kind}, {name} {values.min():.6g} to {values.max():.6g}{unit}, {values.size} points, "
            f"{100 * share:.3g} % of them stable; ends: {', '.join(branch_endings(own))}"
        )
        lines += [f"  {line}" for line in validity_in_words(own)]
        lines += [_event_line(shown.isel(event=e), at) for e in np.flatnonzero(shown["event_branch"].values == k)]
    return [*shortened(lines), *_check_lines(shown, name, at)]


def _event_line(event: xr.Dataset, at: Any) -> str:
    kind = {-1: "", 0: ", subcritical", 1: ", supercritical"}[int(event["event_supercritical"])]
    born = int(event["event_born_branch"])
    leaves = f", branch {born} is born" if born >= 0 else ""
    unresolved = "" if int(event["event_resolved"]) else ", unresolved"
    value, error = at(float(event["event_value"])), at(float(event["event_error"]), ".0e")
    return f"  {event_label(event['event_kind'])} at {value} ± {error}{kind}{leaves}{unresolved}"


def _check_lines(shown: xr.Dataset, name: str, at: Any) -> list[str]:
    """What brute force says."""
    cycles, orbits, seeded = (int(shown[key]) for key in ("checked_cycles", "checked_orbits", "seeded"))
    ran = (
        f"{orbits} stable orbits run from 1e-5 beside"
        if orbits
        else "no stable orbit decays fast enough to be run beside"
    )
    flags = flags_json(shown)
    explained = sum(flag["explanation"] is not None for flag in flags)
    lines = [
        f"brute force: {cycles} settled cycles, all on these branches ({seeded} started one); {ran}; "
        f"{len(flags)} contradiction(s)" + f", {explained} explained" * bool(explained)
    ]
    told = [
        f"  {flag['kind']}, branch {flag['branch']}, {name} {at(flag['value'], '.6g')}"
        + (f": {flag['explanation']}" if flag["explanation"] else "")
        for flag in flags
    ]
    return lines + shortened(told)


# --- loci -------------------------------------------------------------------------------------------------------------


def locus_arguments(subject: Subject, given: Mapping[str, Any]) -> dict[str, Any]:
    """The arguments of `gelcone.locus`."""
    over: dict[str, tuple[float, float]] = {}
    for text in given.get("over", ()):
        name, _, ends = str(text).partition("=")
        parts = ends.split(":")
        if len(parts) not in (2, 3) or not name:
            raise InputError(f"--over {text}: must be NAME=from:to, for example --over voltage=0.9:1.5")
        _check_order(name, parts[0], parts[1])
        if name in over:
            raise InputError(f"--over {name}: is given twice; give it once")
        with _in_words(name, parts[0], parts[1]):
            typed = [f"{name}={parts[0]}:{parts[1]}:2"]
            ((_, between),) = read_over(typed, subject.device, subject.model.system).items()
        over[name] = (float(between[0]), float(between[-1]))
    if len(over) != 2:
        raise InputError(
            f"--over: a locus takes two parameters, not {len(over)}; for example {_two_intervals(subject)}"
        )
    return {"over": over, **{key: value for key, value in given.items() if key != "over"}}


def _two_intervals(subject: Subject) -> str:
    if subject.device is None:
        return "--over voltage=0.95:1.5 --over drive_frequency=0.07:0.13"
    return '--over "voltage_amplitude=100 V:800 V" --over "frequency=5 Hz:20 Hz"'


def locus_json(result: xr.Dataset, subject: Subject) -> dict[str, Any]:
    """The JSON object of a locus: its curves, and their points of codimension two."""
    names = result.attrs["parameters"].split(",")
    curves = []
    for k in range(result.sizes["curve"]):
        own = result.isel(curve=k)
        there = np.isfinite(own[names[0]].values)
        curves.append(
            {
                "number": k,
                "kind": result.attrs["event"],
                "period": int(own["period"]),
                "symmetric": bool(own["symmetric"]),
                "ended": branch_endings(own),
                **{name: own[name].values[there] for name in names},
                "curvature": own["curvature"].values[there],
            }
        )
    return {"parameters": names, "curves": curves, "events": _special_json(result, names)}


def _special_json(result: xr.Dataset, names: list[str]) -> list[dict[str, Any]]:
    """The points of codimension two; what events of branches have one of, these have two of."""
    events = []
    for k in range(result.sizes["event"]):
        own, curve = result.isel(event=k), int(result["event_curve"][k])
        events.append(
            {
                "kind": event_label(own["event_kind"]),
                "parameter": names,
                "value": [float(own["event_first"]), float(own["event_second"])],
                "value_error": [float(own["event_first_error"]), float(own["event_second_error"])],
                "period": int(result["period"][curve]),
                "symmetric": bool(result["symmetric"][curve]),
                "supercritical": None,
                "multipliers": np.stack([own["event_multiplier_real"], own["event_multiplier_imag"]], axis=1).tolist(),
                "branch": curve,
                "born_branch": None,
            }
        )
    return events


def locus_words(shown: xr.Dataset, subject: Subject) -> str:
    """A locus as text."""
    names = shown.attrs["parameters"].split(",")
    lines = heading(subject, names)
    for k in range(shown.sizes["curve"]):
        own = shown.isel(curve=k)
        spans = [
            f"{name} {float(own[name].min()):.6g} to {float(own[name].max()):.6g}{unit_of(own[name])}" for name in names
        ]
        kind = f"period {int(own['period'])}" + ", symmetric" * bool(own["symmetric"])
        count = int(np.isfinite(own[names[0]].values).sum())
        ends = ", ".join(branch_endings(own))
        lines.append(f"curve {k}: {shown.attrs['event']}, {kind}, {', '.join(spans)}, {count} points; ends: {ends}")
        for e in np.flatnonzero(shown["event_curve"].values == k):
            event = shown.isel(event=e)
            at = ", ".join(
                f"{name} {float(event[f'event_{place}']):.10g} ± {float(event[f'event_{place}_error']):.0e}"
                f"{unit_of(event[f'event_{place}'])}"
                for place, name in zip(("first", "second"), names, strict=True)
            )
            lines.append(f"  {event_label(event['event_kind'])} at {at}")
    return "\n".join(shortened(lines))

"""Answers about designs that meet a wish."""

from __future__ import annotations

import json
from collections.abc import Iterable
from typing import TYPE_CHECKING, Any

from gelcone.amounts import sized
from gelcone.analyses.answer import result_json
from gelcone.devices.units import format_si
from gelcone.lab.design import designed_devices
from gelcone.lab.front import NEW_DRAWS
from gelcone.statistics import wilson

if TYPE_CHECKING:
    import xarray as xr


def design_words(result: xr.Dataset) -> str:
    """The designs as text: a table, the fields of each, and what binds it."""
    count, attrs = result.sizes["design"], result.attrs
    lines = [
        f"{attrs['title'].removeprefix('designs: ')}: {count} design{'s' * (count > 1)} at {attrs['frequency']:g} Hz, "
        f"{attrs['margin']:.0%} below all limits",
    ]
    rows = [_row(result.isel(design=k)) for k in range(count)]
    lines += [_line(cells, rows[0]) for cells in (rows[0], *(row.values() for row in rows))]
    lines += _films(result)
    lines += [line for k in range(count) for line in _about(result.isel(design=k), json.loads(attrs["free"]))]
    lines += [f"left out: {reason}" for reason in json.loads(attrs["left_out"])]
    traps = json.loads(attrs["nominal_probabilities"])
    if traps:
        every = ", ".join(
            f"{_share(share, *map(float, wilson(share, NEW_DRAWS)))} (best {name})" for name, share in traps.items()
        )
        alone, those = (
            ("where nothing is uncertain", "draws")
            if _drawn(result)
            else (
                "without tolerances",
                "devices within them",
            )
        )
        lines.append(f"{alone} the best designs meet all in {every} of the {those}")
    return "\n".join(lines)


def _drawn(result: xr.Dataset) -> bool:
    """Whether fields were drawn as a fit leaves them."""
    return bool(json.loads(result.attrs.get("samples", "{}")))


def _films(result: xr.Dataset) -> list[str]:
    """The film whose numbers are shown, and that of the draws behind the probability."""
    film = result.attrs.get("film", "")
    if not film:
        return []
    drawn = (
        "; the probability is that of draws of the homogeneous cone, times what the film has over the cone at nominal "
        "values"
    )
    return [f"all numbers are of the film {film}{drawn if 'probability' in result else ''}"]


def _row(one: xr.Dataset) -> dict[str, str]:
    """The cells of a design by their head."""
    cells = {
        "design": str(int(one["design"])),
        "stroke": sized(one["stroke"], 3),
        "peak": f"{float(one['peak_voltage']):.4g} V",
        "apparent": sized(one["apparent_power"], 3),
    }
    if "probability" in one:
        cells["probability"] = _share(*(float(one[f"probability{end}"]) for end in ("", "_low", "_high")))
    return cells | {"first limit": f"{one['first_limit'].item()}, {float(one['recommended']):.4g} V recommended"}


_WIDTHS = {"design": 8, "stroke": 11, "peak": 12, "apparent": 15, "probability": 25, "first limit": 30}


def _line(cells: Iterable[str], heads: Iterable[str]) -> str:
    return "".join(f"{cell:{_WIDTHS[head]}s}" for cell, head in zip(cells, heads, strict=True)).rstrip()


def _share(share: float, low: float, high: float) -> str:
    """A share and its 95 % interval."""
    return f"{share:.1%} ({low:.1%} to {high:.1%})"


def _about(one: xr.Dataset, free: list[str]) -> list[str]:
    """The fields of a design, how far from resonance it is, and what weakening what binds would buy."""
    fields = ", ".join(f"{name} {format_si(_short(one[name]), one[name].attrs['units'])}" for name in free)
    distance, relaxed = float(one["distance"]), float(one["relaxed"])
    side = "below" if distance < 0.0 else "above"
    near = f"natural frequency {abs(distance):.1f} half widths {side} that of the drive"
    bought = f"; weakening that by 10 % improves the first objective by {relaxed:.0%}" if relaxed > 0.0 else ""
    return [f"design {int(one['design'])}: {fields}", f"  {near}; bound by {one['binding_requirement'].item()}{bought}"]


def _short(value: Any) -> float:
    return float(f"{float(value):.4g}")


def design_json(result: xr.Dataset) -> dict[str, Any]:
    """The JSON object of designs."""
    json_object = result_json(result, ())
    for name in ("objectives", "free", "left_out", "nominal_probabilities", "samples"):
        json_object[name] = json.loads(json_object.get(name, "{}"))
    json_object["devices"] = [device.parameters() for device in designed_devices(result)]
    return json_object


def device_text(result: xr.Dataset, k: int) -> str:
    """The device file of a design, with what was found of it as comments."""
    one, those = result.isel(design=k), "draws" if _drawn(result) else "devices within the tolerances"
    said = [
        f"design {k + 1} of {result.attrs['title'].removeprefix('designs: ')}, found by gelcone design",
        f"settled stroke {sized(one['stroke'], 3)} at {result.attrs['frequency']:g} Hz "
        f"with the film {result.attrs['film']}, {sized(one['apparent_power'], 3)}",
        f"first limit: {one['first_limit'].item()}; recommended up to {float(one['recommended']):.4g} V, "
        f"{result.attrs['margin']:.0%} below it",
        f"bound by {one['binding_requirement'].item()}",
    ]
    if "probability" in one:
        share, low, high = (float(one[f"probability{end}"]) for end in ("", "_low", "_high"))
        said.insert(2, f"{share:.1%} of the {those} meet all ({low:.1%} to {high:.1%})")
    return "\n".join([*(f"# {line}" for line in said), "", json.loads(result.attrs["devices"])[k]])

"""Answers about designs that meet a wish."""

from __future__ import annotations

import json
from typing import TYPE_CHECKING, Any

from gelcone.amounts import sized
from gelcone.analyses.answer import result_json
from gelcone.devices.units import format_si
from gelcone.lab.design import designed_devices

if TYPE_CHECKING:
    import xarray as xr

_WIDTHS = (8, 11, 14, 12, 15, 25, 30)


def design_words(result: xr.Dataset) -> str:
    """The designs as text: a table, the fields of each, and what binds it."""
    count, attrs = result.sizes["design"], result.attrs
    lines = [
        f"{attrs['title'].removeprefix('designs: ')}: {count} design{'s' * (count > 1)} at {attrs['frequency']:g} Hz, "
        f"{attrs['margin']:.0%} below all limits",
        "".join(f"{name:{width}s}" for name, width in zip(_HEADS, _WIDTHS, strict=True)).rstrip(),
    ]
    lines += [*(_row(result.isel(design=k)) for k in range(count)), _AS_MEMBRANE]
    lines += [line for k in range(count) for line in _about(result.isel(design=k), json.loads(attrs["free"]))]
    lines += [f"left out: {reason}" for reason in json.loads(attrs["left_out"])]
    traps = json.loads(attrs["nominal_probabilities"])
    if traps:
        every = ", ".join(f"{share:.1%} (best {name})" for name, share in traps.items())
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


_AS_MEMBRANE = (
    "as membrane: the settled stroke with the film membrane; the other columns are of the wish's film, by default "
    "wrinkling"
)
"""The explanation of a column."""
_HEADS = ("design", "stroke", "as membrane", "peak", "apparent", "probability", "first limit")


def _row(one: xr.Dataset) -> str:
    share = (
        f"{float(one['probability']):.1%} ({float(one['probability_low']):.1%} to {float(one['probability_high']):.1%})"
    )
    cells = (
        str(int(one["design"])),
        sized(one["stroke"], 3),
        sized(one["membrane_stroke"], 3),
        f"{float(one['peak_voltage']):.4g} V",
        sized(one["apparent_power"], 3),
        share,
        f"{one['first_limit'].item()}, {float(one['recommended']):.4g} V recommended",
    )
    return "".join(f"{cell:{width}s}" for cell, width in zip(cells, _WIDTHS, strict=True)).rstrip()


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
    found = result_json(result, ())
    for name in ("objectives", "free", "left_out", "nominal_probabilities", "samples"):
        found[name] = json.loads(found.get(name, "{}"))
    found["devices"] = [device.parameters() for device in designed_devices(result)]
    return found


def device_text(result: xr.Dataset, k: int) -> str:
    """The device file of a design, with what was found of it as comments."""
    one, those = result.isel(design=k), "draws" if _drawn(result) else "devices within the tolerances"
    said = [
        f"design {k + 1} of {result.attrs['title'].removeprefix('designs: ')}, found by gelcone design",
        f"settled stroke {sized(one['stroke'], 3)} at {result.attrs['frequency']:g} Hz "
        f"({sized(one['membrane_stroke'], 3)} as a membrane), {sized(one['apparent_power'], 3)}",
        f"{float(one['probability']):.1%} of the {those} meet all "
        f"({float(one['probability_low']):.1%} to {float(one['probability_high']):.1%})",
        f"first limit: {one['first_limit'].item()}; recommended up to {float(one['recommended']):.4g} V, "
        f"{result.attrs['margin']:.0%} below it",
        f"bound by {one['binding_requirement'].item()}",
    ]
    return "\n".join([*(f"# {line}" for line in said), "", json.loads(result.attrs["devices"])[k]])

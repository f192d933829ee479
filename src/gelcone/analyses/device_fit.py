"""Answers about the plan of a device's tests, and about a device fitted to them."""

from __future__ import annotations

import json
from typing import TYPE_CHECKING, Any

import numpy as np

from gelcone.analyses.answer import result_json
from gelcone.analyses.material_fit import note_lines
from gelcone.devices.units import format_si
from gelcone.lab.device import UNDECIDED
from gelcone.lab.fitted import fitted_device
from gelcone.lab.predictions import PREDICTIONS
from gelcone.statistics import Z

if TYPE_CHECKING:
    import xarray as xr

    from gelcone.devices.device import Device

MOST_NEXT = 5
FILE_ONLY = (
    "covariance",
    "reading_test",
    "reading_name",
    "reading_along",
    "reading_axis",
    "reading_unit",
    "measured",
    "noise",
    "predicted",
)


def device_plan_words(result: xr.Dataset, device: Device) -> str:
    """The plan as text."""
    attrs, count = result.attrs, len(json.loads(result.attrs["tests"]))
    lines = [f"{device.name}: plan of {attrs['readings']} readings in {count} tests, {attrs['film']} film"]
    lines += _learnt_lines(result)
    return "\n".join(
        [*lines, *_unknown_lines(result, device), *_prediction_lines(result), *_next_lines(result), *note_lines(result)]
    )


def device_fit_words(result: xr.Dataset, device: Device) -> str:
    """The fit as text; what is not to be relied on says so first."""
    attrs = result.attrs
    lines = [f"{device.name}: fitted to {attrs['readings']} readings, {attrs['chosen']}", verdict(result)]
    lines += [*_structure_lines(result), *_unknown_lines(result, device), *_learnt_lines(result)]
    return "\n".join(
        [*lines, *_left_out_lines(result), *_prediction_lines(result), *_next_lines(result), *note_lines(result)]
    )


def device_fit_json(result: xr.Dataset) -> dict[str, Any]:
    """The JSON object of a plan or a fit."""
    json_object = result_json(result, FILE_ONLY)
    for name in ("tests", "next", "impossible", "reading"):
        if name in json_object:
            json_object[name] = json.loads(json_object[name])
    if "fitted" in json_object:
        json_object["fitted"] = fitted_device(result).parameters()
    return json_object


def verdict(result: xr.Dataset) -> str:
    """The verdict of chi2 on the structure, with what follows from it."""
    attrs = result.attrs
    size = f"chi2 = {attrs['chi2']:.4g} of {attrs['readings']} points"
    if attrs["refused"]:
        other = next(film for film in ("wrinkling", "taut") if film != attrs["film"])
        return (
            f"{size}: no device of this structure makes these data; the intervals below are not to be relied on; try "
            f"--films {other}"
        )
    return f"{size} (p = {attrs['p_value']:.2g}): the structure is not refused"


def _structure_lines(result: xr.Dataset) -> list[str]:
    impossible = json.loads(result.attrs["impossible"])
    refused = [f"structure {name}: {reason.partition(':')[0]}" for name, reason in impossible.items()]
    if result.sizes["structure"] < 2:
        return refused
    rows = zip(result["structure_objective"].values.tolist(), result["structure"].values, strict=True)
    ranked = sorted((value, str(name)) for value, name in rows)
    every = "; ".join(f"{name} {value:.4g}" for value, name in ranked)
    lines = [*refused, f"structures compared, chi2 with priors: {every}"]
    alike = [name for value, name in ranked[1:] if value - ranked[0][0] < UNDECIDED]
    if alike:
        lines.append(f"these tests cannot distinguish {ranked[0][1]} from {' or '.join(alike)}")
    return lines


def _unknown_lines(result: xr.Dataset, device: Device) -> list[str]:
    fields = list(map(str, result["field"].values))
    lines = [f"{'':32s}{'value':>14s}{'deviation':>11s}{'known to':>10s}{'prior':>8s}{'left of it':>12s}"]
    for k, name in enumerate(map(str, result["unknown"].values)):
        prior, left, moved = (float(result[key][k]) for key in ("prior", "posterior", "deviation"))
        value = ""
        if name in fields:
            value = format_si(float(result["value"][fields.index(name)]), device.swept_fields()[name].unit)
        known = f"{100.0 * prior:.3g} %" if prior < 10.0 else "none"
        line = f"  {name:30s}{value:>14s}{100.0 * np.expm1(moved):>+9.1f} %{100.0 * left:>8.2g} %{known:>8s}"
        line += f"{left / prior:>12.2f}"
        far = "  more than 2 standard deviations from its prior" if abs(moved) > 2.0 * prior else ""
        lines.append(line + far)
        if "profile_low" in result and np.isfinite(result["profile_low"][k]):
            low, high = (100.0 * float(np.expm1(result[f"profile_{end}"][k])) for end in ("low", "high"))
            lines.append(
                f"    95 % by profile: {low:+.2f} to {high:+.2f} %; by curvature "
                f"{100.0 * np.expm1(moved - Z * left):+.2f} to {100.0 * np.expm1(moved + Z * left):+.2f} %"
            )
    return lines


def _learnt_lines(result: xr.Dataset) -> list[str]:
    count = result.sizes["field"]
    learnt = result.attrs["learnt"]
    lines = [f"{learnt} of {count} directions of the fields are learnt from the tests, the others from the priors"]
    if result.sizes.get("invariant", 0):
        lines.append("changes that leave every reading as it is (s: any factor):")
    for row in result["exponent"].values if "exponent" in result else ():
        parts = [(str(name), share) for name, share in zip(result["field"].values, row, strict=True) if share]
        lines.append(
            "  " + ", ".join(f"{name} x s{'' if abs(share - 1.0) < 1e-3 else f'^{share:.3g}'}" for name, share in parts)
        )
    return lines


def _left_out_lines(result: xr.Dataset) -> list[str]:
    if "left_out_chi2" not in result:
        return []
    lines = ["each test predicted from the others:"]
    for k, name in enumerate(result["test"].values):
        chi2, points, p = (float(result[f"left_out_{key}"][k]) for key in ("chi2", "points", "p_value"))
        lines.append(f"  {name!s:40s} chi2 {chi2:.4g} of {points:.0f}, p = {p:.2g}{': refused' if p < 0.01 else ''}")
    return lines


def _prediction_lines(result: xr.Dataset) -> list[str]:
    lines = []
    for k, name in enumerate(map(str, result["prediction"].values) if "prediction" in result.coords else ()):
        unit = PREDICTIONS[name.partition("@")[0].strip()]
        value, spread, prior = (float(result[f"predicted_{key}"][k]) for key in ("value", "spread", "prior"))
        if not np.isfinite(value):
            lines.append(f"{name}: none")
            continue
        lines.append(
            f"{name}: {format_si(value, unit)} +- {format_si(spread, unit, 3)} ({100.0 * spread / abs(value):.2g} %; "
            f"from the priors alone {100.0 * prior / abs(value):.2g} %)"
        )
    return lines


def _next_lines(result: xr.Dataset) -> list[str]:
    lines = []
    names = map(str, result["prediction"].values) if "prediction" in result.coords else ()
    for name, experiments in zip(names, json.loads(result.attrs.get("next", "[]")), strict=False):
        if experiments:
            lines.append(f"next for {name}, what it would leave of the standard deviation:")
        lines += [f"  {ratio:.2f}  {words}" for words, ratio in experiments[:MOST_NEXT]]
    return lines

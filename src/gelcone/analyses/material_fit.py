"""Answers about a material fitted to tests on coupons."""

from __future__ import annotations

import json
from typing import TYPE_CHECKING, Any

import numpy as np

from gelcone.analyses.answer import result_json
from gelcone.devices.materials import Material
from gelcone.devices.units import format_range, format_si
from gelcone.lab.material import fitted_material, unit_of

if TYPE_CHECKING:
    import xarray as xr

FILE_ONLY = ("sample_test", "time", "stretch", "stress", "predicted", "left_out", "draws")
MOST_TESTS = 40
"""Tests of which a text has a line each."""


def fit_words(result: xr.Dataset) -> str:
    """The fit as text: the material, how sure it is, what was compared, and what was done to each test."""
    gel, attrs = fitted_material(result), result.attrs
    flow = f", {'logarithmic' if (gel.flow or 'log') == 'log' else 'linear'} flow" if gel.branches else ""
    rule = f"{gel.law} with {gel.branches} Maxwell branch{'' if gel.branches == 1 else 'es'}{flow}"
    used = [str(use) for use in result["test_use"].values]
    at = f" at {attrs['temperature'] - 273.15:.3g} degC" if np.isfinite(attrs["temperature"]) else ""
    lines = [f"{attrs['title'].partition(': ')[2]}: {rule}", f"  fitted to {used.count('fit')} tests{at}"]
    lines += [f"  {line}" for line in _parameter_lines(result, gel)]
    return "\n".join(
        [*lines, *_quality_lines(result), *_compared_lines(result), *_test_lines(result), *note_lines(result)]
    )


def fit_json(result: xr.Dataset) -> dict[str, Any]:
    """The JSON object of a fit."""
    json_object = result_json(result, FILE_ONLY)
    for name in ("material", "files", "reading"):
        json_object[name] = json.loads(json_object[name])
    return json_object


def _parameter_lines(result: xr.Dataset, gel: Material) -> list[str]:
    lines = []
    for k, name in enumerate(map(str, result["parameter"].values)):
        unit = unit_of(name)
        value, low, high = (float(result[key][k]) for key in ("value", "low", "high"))
        spread = f" (95 %: {format_range(low, high, unit, 3)})" if np.isfinite(low) else ""
        lines.append(f"{name} {format_si(value, unit, 4)}{spread}")
    note = str(result.attrs["permittivity_note"])
    return [*lines, f"relative_permittivity {gel.relative_permittivity:.4g}{f' ({note})' if note else ''}"]


def _quality_lines(result: xr.Dataset) -> list[str]:
    law, count = str(result.attrs["chosen_law"]), int(result.attrs["chosen_branches"])
    chosen_fit = result.sel(law=law, branch_count=count)
    lines = [f"mean error {float(chosen_fit['fit_error']):.2%} of a test's largest stress"]
    if not np.isfinite(float(chosen_fit["prediction_error"])):
        return [f"{lines[0]}; too few tests to leave one out: the error of a prediction is not known"]
    attrs = result.attrs
    return [
        f"{lines[0]}; each test predicted from the others: {float(chosen_fit['prediction_error']):.2%}",
        f"a prediction is within +-{attrs['band']:.1%} of a test's largest stress; this band, from the other tests, "
        f"covers a test to {attrs['band_mean']:.0%} in the mean and {attrs['band_least']:.0%} at worst",
    ]


def _compared_lines(result: xr.Dataset) -> list[str]:
    if result["prediction_error"].isnull().all():
        return []
    counts = [int(count) for count in result["branch_count"].values]
    lines = ["mean error of tests left out, %, by number of branches:"]
    lines.append("  ".join(["  " + " " * 12, *(f"{count:6d}" for count in counts)]))
    for law in result["law"].values:
        errors = 100.0 * result["prediction_error"].sel(law=law).values
        lines.append(
            "  ".join([f"  {law!s:12s}", *(f"{error:6.2f}" if np.isfinite(error) else f"{'-':>6}" for error in errors)])
        )
    chosen = f"{result.attrs['chosen_law']}, {result.attrs['chosen_branches']}"
    return [*lines, f"chosen: {chosen}: the fewest branches within 3 % of the best (a device takes up to 3)"]


def _test_lines(result: xr.Dataset) -> list[str]:
    """A line for each test."""
    lines = ["tests: error, and predicted from the others, % of the largest stress"]
    for k in range(min(result.sizes["test"], MOST_TESTS)):
        one = result.isel(test=k)
        errors = [float(one[name]) for name in ("error", "left_out_error")]
        shown = "  ".join(f"{100.0 * error:6.2f}" if np.isfinite(error) else f"{'-':>6}" for error in errors)
        voltage = f", {float(one['voltage']):g} V" if float(one["voltage"]) else ""
        use = {"fit": "", "check": ", predicted only", "leave out": ", left out"}[str(one["test_use"].values)]
        kind = f"{one['test_mode'].values} {one['test_kind'].values}"
        lines.append(f"  {one['test_name'].values!s:28s} {shown}  {kind}{voltage}{use}")
    more = result.sizes["test"] - MOST_TESTS
    return [*lines, *([f"  and {more} more (all with --json or --out)"] if more > 0 else [])]


def note_lines(result: xr.Dataset) -> list[str]:
    """List the assumptions made about the files, each once, with the files or tests that it concerns."""
    lines = [f"  {', '.join(where)}: {note}" for note, where in json.loads(result.attrs.get("reading", "[]"))]
    return ["read as:", *lines] if lines else []

"""The answers to fits, plans, draws and designs, in the words of their commands."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import TYPE_CHECKING, Any

from gelcone.analyses.answer import result_json
from gelcone.analyses.design import design_json, design_words
from gelcone.analyses.device_fit import device_fit_json, device_fit_words, device_plan_words
from gelcone.analyses.material_fit import fit_json, fit_words
from gelcone.analyses.tables import series_lines
from gelcone.devices.device import Device
from gelcone.lab.fitted import fitted_device

if TYPE_CHECKING:
    import xarray as xr


def lab_answer(result: xr.Dataset) -> tuple[Callable[[], str], Callable[[], dict[str, Any]]] | None:
    """The text and the JSON of a fit, a plan, its draws or of designs; None for another result."""
    whole = str(result.attrs.get("title", ""))
    title = whole.partition(":")[0]
    if title == "device plan" and "planned" in result.attrs:
        device = Device.from_text(result.attrs["planned"])
        return lambda: device_plan_words(result, device), partial(device_fit_json, result)
    if title.startswith("draws of "):
        return lambda: "\n".join([whole, *series_lines(result)]), partial(result_json, result)
    if title == "device fit":
        return lambda: device_fit_words(result, fitted_device(result)), partial(device_fit_json, result)
    if title == "material fit":
        return partial(fit_words, result), partial(fit_json, result)
    return (partial(design_words, result), partial(design_json, result)) if title == "designs" else None

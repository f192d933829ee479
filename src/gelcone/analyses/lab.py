"""The answers for files of fits and designs, in the words of their commands."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import TYPE_CHECKING, Any

from gelcone.analyses.design import design_json, design_words
from gelcone.analyses.device_fit import device_fit_json, device_fit_words
from gelcone.analyses.material_fit import fit_json, fit_words
from gelcone.lab.fitted import fitted_device

if TYPE_CHECKING:
    import xarray as xr


def lab_answer(result: xr.Dataset) -> tuple[Callable[[], str], Callable[[], dict[str, Any]]] | None:
    """The text and the JSON of a fit or of designs; None for another result."""
    title = str(result.attrs.get("title", "")).partition(":")[0]
    if title == "device fit":
        return lambda: device_fit_words(result, fitted_device(result)), partial(device_fit_json, result)
    if title == "material fit":
        return partial(fit_words, result), partial(fit_json, result)
    return (partial(design_words, result), partial(design_json, result)) if title == "designs" else None

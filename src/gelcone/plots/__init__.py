"""The figures of gelcone, one for each kind of result.

`FIGURES` maps the title of a result to the module and function that draw it, and `plot` draws any result with it.
Functions are imported when first used; importing this package does not load matplotlib.
"""

from __future__ import annotations

from collections.abc import Callable
from importlib import import_module
from inspect import signature
from types import MappingProxyType
from typing import TYPE_CHECKING, Any

from gelcone.errors import InputError, unknown_name

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.figure import Figure

FIGURES = MappingProxyType(
    {
        "bifurcation diagram": "bifurcation.bifurcation_figure",
        "cone and continuum": "validation.validation_figure",
        "draws": "drawn.drawn_figure",
        "extrema": "section.section_figure",
        "basins of attraction": "basin.basin_figure",
        "best drive": "drive.drive_figure",
        "branches": "branches.branches_figure",
        "creep": "creep.creep_figure",
        "data sheet": "datasheet.datasheet_figure",
        "designs": "design.design_figure",
        "device fit": "device_fit.device_fit_figure",
        "device plan": "device_fit.device_plan_figure",
        "film": "profile.profile_figure",
        "frequency response": "frequency.frequency_figure",
        "instability tongues of rest": "floquet.tongues_figure",
        "Lyapunov exponents": "lyapunov.lyapunov_figure",
        "locus": "locus.locus_figure",
        "material fit": "coupons.coupon_figure",
        "operating envelope": "envelope.envelope_figure",
        "parameter map": "sweep.any_figure",
        "Poincare section": "section.section_figure",
        "probability": "sweep.probability_figure",
        "regime of motion": "regime.regime_figure",
        "spectrum": "spectrum.spectrum_figure",
        "statics": "equilibrium.static_figure",
        "step": "step.step_figure",
        "sweep": "sweep.any_figure",
        "time response": "response.response_figure",
        "transfer functions": "transfer.transfer_figure",
        "triptych": "triptych.triptych_figure",
    }
)
"""Title of a result (up to a colon) -> module.function of its figure."""
ANY = "values.values_figure"
"""Figure of results whose title is not in `FIGURES`: their numbers as curves, or as text."""

__all__ = ["FIGURES", "figure_of", "plot", *(path.split(".")[1] for path in sorted({*FIGURES.values(), ANY}))]


def plot(result: xr.Dataset, **options: Any) -> Figure:
    """Draw any result of gelcone.

    Parameters
    ----------
    result : a Dataset that an analysis returned, also one read by `gelcone.load` or converted by `gelcone.to_si`.
    options : options of the figure's function, for example ``middle="extent"`` for a bifurcation diagram.

    Returns
    -------
    A matplotlib ``Figure`` outside pyplot's global state; ``figure.savefig("name.png")`` writes it.

    Raises
    ------
    InputError : for anything but a result of gelcone, an option that its figure does not have, or a result that lacks a
        variable which its figure draws (written by another version, or with variables removed).

    Examples
    --------
    >>> import gelcone
    >>> response = gelcone.simulate(gelcone.ConeModel(), periods=2)
    >>> figure = gelcone.plot(response)
    >>> len(figure.axes)
    4
    """
    draw = figure_of(result)
    known = list(signature(draw).parameters)[1:]
    if unknown := [name for name in options if name not in known]:
        otherwise = "" if known else "this figure has none"
        raise unknown_name("option of plot for this result", unknown[0], known, otherwise)
    from gelcone.plots.frame import add_footnote, fixed_parameters

    try:
        figure = draw(result, **options)
    except KeyError as error:
        attrs, what = result.attrs, str(error.args[0]).partition(". ")[0]
        raise InputError(
            f"the result {attrs['title']!r} of gelcone {attrs['gelcone_version']} lacks what its figure draws: {what}; "
            "compute it again, or give it whole"
        ) from error
    add_footnote(figure, fixed_parameters(result))
    return figure


def figure_of(result: Any) -> Callable[..., Figure]:
    """The function that draws a result; `InputError` for anything but a result of gelcone."""
    attrs = getattr(result, "attrs", {})
    if not {"title", "gelcone_version"} <= set(attrs) or not hasattr(result, "data_vars"):
        raise InputError(
            f"plot: an object of type {type(result).__name__} without gelcone's attributes is not a result of gelcone; "
            "give a Dataset that one of its analyses returned or gelcone.load read"
        )
    return _function(FIGURES.get(attrs["title"].partition(":")[0], ANY))


def _function(path: str) -> Callable[..., Figure]:
    module, _, name = path.partition(".")
    function: Callable[..., Figure] = getattr(import_module(f"gelcone.plots.{module}"), name)
    return function


def __getattr__(name: str) -> Any:
    """Loads a figure's function when it is first used."""
    for path in (*FIGURES.values(), ANY):
        if path.endswith(f".{name}"):
            return _function(path)
    raise AttributeError(f"module 'gelcone.plots' has no attribute {name!r}")


def __dir__() -> list[str]:
    return sorted(__all__)

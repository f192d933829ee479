"""Uncertain parameters: draws of them for a sweep, and what the draws say about the chance of a kind of motion."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import astuple, dataclass
from numbers import Real
from typing import TYPE_CHECKING, Any, Literal, get_args

import numpy as np

from gelcone import dataset
from gelcone.codes import Outcome, Regime
from gelcone.devices.fields import SWEPT_FIELDS
from gelcone.devices.points import STATE_FIELDS
from gelcone.devices.units import parse, parse_deviation
from gelcone.errors import InputError, check_kind, check_name, check_result
from gelcone.quantity import Array
from gelcone.statistics import CONFIDENCE, share_interval

if TYPE_CHECKING:
    import xarray as xr

Method = Literal["sobol", "latin-hypercube"]
METHODS: tuple[Method, ...] = get_args(Method)


@dataclass(frozen=True)
class Uniform:
    """Anything between two bounds, with the same density.

    Parameters
    ----------
    low : the lower bound; of a field of a device a text with a unit.
    high : the upper bound, likewise.

    Examples
    --------
    >>> import gelcone
    >>> drawn = gelcone.draw({"voltage": gelcone.Uniform(0.4, 0.8)}, 8)["voltage"]
    >>> bool((drawn > 0.4).all() and (drawn < 0.8).all()), (drawn < 0.6).sum().item()
    (True, 4)
    """

    low: Any
    high: Any

    def __post_init__(self) -> None:
        if _worded(self):
            return
        if not (np.isfinite(self.low) and np.isfinite(self.high) and self.low < self.high):
            raise InputError(f"{self.low:g}:{self.high:g}: a uniform distribution goes from a lower to a higher bound")

    def at(self, share: Array) -> Array:
        """Values below which lie these shares of the distribution."""
        return self.low + (self.high - self.low) * share


@dataclass(frozen=True)
class Normal:
    """The normal distribution of an uncertain parameter.

    Parameters
    ----------
    mean : its mean; of a field of a device a text with a unit.
    deviation : its standard deviation, likewise; or a share of the mean, as ``"3 %"``.

    Examples
    --------
    >>> import gelcone
    >>> drawn = gelcone.draw({"film_thickness": gelcone.Normal("0.2 mm", "0.01 mm")}, 64)["film_thickness"]
    >>> f"{1e3 * drawn.mean():.4f} mm, within 0.18 and 0.22 mm: {((drawn > 0.18e-3) & (drawn < 0.22e-3)).sum()} of 64"
    '0.1999 mm, within 0.18 and 0.22 mm: 61 of 64'
    """

    mean: Any
    deviation: Any

    def __post_init__(self) -> None:
        if _worded(self):
            return
        if not (np.isfinite(self.mean) and np.isfinite(self.deviation) and self.deviation > 0.0):
            bound = f"the standard deviation {self.deviation:g} must be positive and both numbers finite"
            raise InputError(f"{self.mean:g}~{self.deviation:g}: {bound}; give mean~deviation")

    def at(self, share: Array) -> Array:
        """Values below which lie these shares of the distribution."""
        from scipy.special import ndtri

        values: Array = self.mean + self.deviation * ndtri(share)
        return values


Distribution = Uniform | Normal


def _worded(given: Distribution) -> bool:
    """Whether a distribution is given by texts, which `draw` reads; `InputError` for neither text nor number."""
    texts = [isinstance(value, str) for value in astuple(given)]
    for value in astuple(given):
        if isinstance(value, bool) or not isinstance(value, str | Real):
            raise InputError(f"{given}: {value!r} must be a number, or a text such as '0.25 mm' for a device's field")
    if any(texts) and not all(texts):
        raise InputError(f"{given}: mixes a number and a text; give both as numbers in SI, or both with a unit")
    return all(texts)


def _in_numbers(name: str, given: Distribution) -> Distribution:
    """A distribution in SI numbers; texts are read as values of the device's field ``name``."""
    if not isinstance(given, Distribution):
        raise InputError(f"{name} = {given!r}: must be a distribution, such as gelcone.Uniform(low, high)")
    if not _worded(given):
        return given
    fields = {**SWEPT_FIELDS, **STATE_FIELDS}
    if name not in fields:
        raise InputError(f"{name}: {given} has units, and {name} is not a device's field with one; give numbers")
    field, (one, other) = fields[name], astuple(given)
    first = parse(name, one, field.unit, example=field.example_text())
    if isinstance(given, Normal):
        return Normal(first, parse_deviation(name, other, field.unit, first))
    return Uniform(first, parse(name, other, field.unit, example=field.example_text()))


def draw(
    uncertain: Mapping[str, Distribution],
    count: int,
    *,
    method: Method = "sobol",
    seed: int = 0,
    indices: bool = False,
) -> dict[str, Array]:
    """Draw independent uncertain parameters that fill their ranges evenly: for `Plan`'s ``draws``.

    Parameters
    ----------
    uncertain : name -> distribution, of a device's field also in texts: ``{"frequency": Normal("9 Hz", "0.1 Hz")}``.
    count : number of draws, at least 2; powers of 2 suit Sobol's sequence.
    method : ``"sobol"``, scrambled (Owen, J. Complexity 14 (1998) 466; default), or ``"latin-hypercube"`` (McKay et
        al., Technometrics 21 (1979) 239).
    seed : the same seed gives the same draws.
    indices : adds the draws that Sobol indices need (Saltelli et al., Comput. Phys. Commun. 181 (2010) 259): half of
        ``count`` for each of the parameters, which are two or more. Default no.

    Returns
    -------
    Name -> values, of a device in SI: with ``indices`` more than ``count`` of them.

    Raises
    ------
    InputError : for nothing uncertain, fewer than 2 draws, an unknown method, or indices of a single parameter or of a
        number of draws that is not a power of 2.

    Examples
    --------
    >>> import gelcone
    >>> draws = gelcone.draw({"voltage": gelcone.Uniform(0.4, 0.8), "damping_ratio": gelcone.Normal(0.05, 0.005)}, 8)
    >>> sorted(draws), draws["voltage"].shape, round(float(draws["voltage"].mean()), 3)
    (['damping_ratio', 'voltage'], (8,), 0.601)
    """
    check_kind("draw", uncertain, Mapping, "give name -> distribution, such as {'voltage': gelcone.Uniform(0.4, 0.8)}")
    if not uncertain:
        raise InputError("uncertain: is empty; give at least one parameter and its distribution")
    if count < 2:
        raise InputError(f"count = {count}: must be at least 2 draws")
    check_name("method of drawing", method, METHODS)
    known = {name: _in_numbers(name, given) for name, given in uncertain.items()}
    if indices and (len(uncertain) < 2 or count & (count - 1)):
        raise InputError(
            f"count = {count} draws of {len(uncertain)}: Sobol indices need two parameters or more, and a power of 2"
        )
    inside = np.clip(_shares(len(uncertain), count, method, seed, indices), 0.5 / 2**53, 1.0 - 2.0**-53)
    return {name: known[name].at(inside[:, k]) for k, name in enumerate(known)}


def _shares(dimension: int, count: int, method: Method, seed: int, indices: bool) -> Array:
    """Points of the unit cube (draws, parameters)."""
    import warnings

    from scipy.stats import qmc

    sampler = qmc.Sobol if method == "sobol" else qmc.LatinHypercube
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", category=UserWarning)  # that a number of draws is not a power of 2
        if not indices:
            return np.asarray(sampler(dimension, seed=seed).random(count))
        # both halves come from one sequence in twice the dimensions: they are independent of each other
        both = sampler(2 * dimension, seed=seed).random(count // 2)
    first, second = both[:, :dimension], both[:, dimension:]
    mixed = [np.where(np.arange(dimension) == k, second, first) for k in range(dimension)]
    return np.concatenate([first, second, *mixed])


def probability(cells: xr.Dataset, kind: Regime = Regime.CHAOTIC, *, confidence: float = CONFIDENCE) -> xr.Dataset:
    """The probability of a kind of motion at every point of a grid, from the draws made there.

    Parameters
    ----------
    cells : what `gelcone.sweep` gives of a plan with draws and the analysis ``"regime"``.
    kind : default chaos.
    confidence : of the interval. Default 0.95.

    Returns
    -------
    Dataset over the grid: ``probability``, the share of the decided draws; ``low`` and ``high``, its interval (Clopper
    and Pearson, Biometrika 26 (1934) 404: exact for independent draws, and wider than it need be for the even ones of
    `draw`); ``decided``, the number of draws behind it: not those that failed or did not settle.

    Raises
    ------
    InputError : for a sweep without draws or regimes, or a confidence that is not between 0 and 1.

    Examples
    --------
    >>> import gelcone
    >>> model = gelcone.ConeModel(voltage=0.3, voltage_bias=0.6, rest_height=0.8, hoop_prestretch=1.4)
    >>> draws = gelcone.draw({"damping_ratio": gelcone.Uniform(0.05, 0.1)}, 4)
    >>> cells = gelcone.sweep(gelcone.Plan(model, {"drive_frequency": [0.6, 0.8]}, draws=draws))
    >>> found = gelcone.probability(cells, gelcone.Regime.PERIODIC)
    >>> found.probability.values.tolist(), found.low.values.round(3).tolist()
    ([1.0, 1.0], [0.398, 0.398])
    """
    check_result("probability", cells)
    if "draw" not in cells.dims or "regime" not in cells:
        raise InputError("the sweep has no draws of the regime; give uncertain parameters and the analysis 'regime'")
    if not 0.0 < confidence < 1.0:
        raise InputError(f"confidence = {confidence}: must be between 0 and 1")
    regime, failed = cells["regime"], cells["outcome"].isin([Outcome.STEP_LIMIT, Outcome.ERROR])
    decided = ~failed & (regime != Regime.TRANSIENT) & (regime >= 0)
    n = decided.sum("draw")
    k = (decided & (regime == kind)).sum("draw")
    low, high = share_interval(k, n, confidence)
    share = np.where(n > 0, k / np.maximum(n, 1), np.nan)
    options = {"kind": kind.label, "confidence": confidence}
    result = dataset.label(dataset.model_of(cells), {}, options=options, title=f"probability: {kind.label}")
    table: dataset.Table = {
        "probability": (share, f"probability that the motion is {kind.label}", "share"),
        "low": (low, f"lower end of its {100.0 * confidence:g} % interval", "share"),
        "high": (high, f"upper end of its {100.0 * confidence:g} % interval", "share"),
        "decided": (n.values, "draws that are decided", "count"),
    }
    coords = {str(dim): cells[dim] for dim in n.dims}
    return result.assign_coords(coords).assign(dataset.columns(tuple(coords), table))

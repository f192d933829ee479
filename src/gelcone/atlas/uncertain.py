"""Draws of uncertain parameters for a sweep."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Literal, get_args

import numpy as np

from gelcone.atlas.distribution import Distribution, in_numbers
from gelcone.errors import InputError, check_kind, check_name
from gelcone.quantity import Array

Method = Literal["sobol", "latin-hypercube"]
METHODS: tuple[Method, ...] = get_args(Method)


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
    known = {name: in_numbers(name, given) for name, given in uncertain.items()}
    if indices and (len(uncertain) < 2 or count & (count - 1)):
        raise InputError(
            f"count = {count} draws of {len(uncertain)}: Sobol indices need two parameters or more, and a power of 2"
        )
    inside = np.clip(_shares(len(uncertain), count, method, seed, indices), 0.5 / 2**53, 1.0 - 2.0**-53)
    return {name: known[name].at(inside[:, k]) for k, name in enumerate(known)}


def _shares(dimension: int, count: int, method: Method, seed: int, indices: bool) -> Array:
    """Points of the unit cube, (draws, parameters)."""
    import warnings

    from scipy.stats import qmc

    sampler = qmc.Sobol if method == "sobol" else qmc.LatinHypercube
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", category=UserWarning)  # of a number of draws that is not a power of 2
        if not indices:
            return np.asarray(sampler(dimension, seed=seed).random(count))
        # both halves come from one sequence in twice the dimensions: they are independent of each other
        both = sampler(2 * dimension, seed=seed).random(count // 2)
    first, second = both[:, :dimension], both[:, dimension:]
    mixed = [np.where(np.arange(dimension) == k, second, first) for k in range(dimension)]
    return np.concatenate([first, second, *mixed])

"""Static bifurcations: pitchforks, folds and pull-in under constant voltages."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from gelcone import dataset
from gelcone.devices.analysis import for_devices
from gelcone.motion.proportion import at_own_bias
from gelcone.motion.static_results import PLACE, label_static, padded, rests_near
from gelcone.physics.balance import ROUNDING, PullIn, StaticBalance, rest_of
from gelcone.physics.film.pull_in import is_cone
from gelcone.physics.members import Ensemble
from gelcone.physics.statics import balances_of, each
from gelcone.quantity import Array, Lengths

if TYPE_CHECKING:
    import xarray as xr

    from gelcone.physics.system import ConeSystem

_FOLD: dataset.Of = dataset.absent("voltage", nan="none")
_FROM = dataset.absent("length")
_TO = dataset.absent("length", infinite="no other equilibrium")
PITCHFORK = "constant voltage at which the flat film, or the middle of two equal ones, loses stability"
PITCHFORK_ABSENT = dataset.absent("voltage", infinite="none before pull-in")
PULL_IN = "constant voltage at which the disc jumps or the film pulls in"
PULL_IN_ABSENT = dataset.absent("voltage", infinite="none")
PULL_IN_KIND = "how the disc jumps or pulls in"


@for_devices
def pitchfork_voltage(model: Ensemble) -> xr.Dataset:
    """Compute the constant voltage at which the flat film, or a raised pair of equal films, loses stability.

    For a single film it is the root of the small-signal stiffness, kappa + (A - G)/(1 - (A+B+G-3)/J) for the taut cone
    with Gent's law.

    Parameters
    ----------
    model : one actuator or an ensemble; its drive plays no part.

    Returns
    -------
    Dataset over the ensemble's dims: ``pitchfork_voltage`` and ``pitchfork_displacement``, the place that the disc
    leaves there (NaN without a pitchfork). The voltage is infinite where the flat film stays stable until it pulls in
    or at any voltage; NaN where x = 0 is not an equilibrium (``rest_height`` with a spring; of two films where they do
    not rest in their middle), cannot be reached or is unstable without voltage already.

    Raises
    ------
    InputError : for what is neither a model nor a device.

    Examples
    --------
    >>> import gelcone
    >>> found = gelcone.pitchfork_voltage(gelcone.ConeModel(spring_stiffness=[0.5, 1.5]))
    >>> found.pitchfork_voltage.values.round(4).tolist()
    [0.7071, 1.2247]
    """
    balances = balances_of(model)
    return label_static(model, balances, pitchfork_variable(balances), title="pitchfork")


def pitchfork_voltages(balances: list[StaticBalance]) -> Array:
    """Voltages of the pitchforks, (members,); infinite where the film keeps its stability until it pulls in, NaN where
    it has none to lose."""
    squared = np.array(each(lambda balance: balance.pitchfork(), balances))
    highest = np.array([balance.highest_squared if balance.flat else np.inf for balance in balances])
    with np.errstate(invalid="ignore"):
        voltage = np.where(squared < highest, np.sqrt(np.maximum(squared, 0.0)), np.inf)
        return np.where(squared >= -ROUNDING, voltage, np.nan)


@for_devices
def fold_voltages(model: Ensemble) -> xr.Dataset:
    """Compute all folds of the equilibria: constant voltages and displacements at which two of them meet and vanish.

    Parameters
    ----------
    model : one actuator or an ensemble; its drive plays no part.

    Returns
    -------
    Dataset with ``fold_voltage`` and ``fold_displacement`` over the ensemble's dims and ``fold``, in the order of the
    voltage, NaN-padded. Displacements up to the stretch limit are searched, at most 1000.

    Raises
    ------
    InputError : for what is neither a model nor a device.

    Examples
    --------
    >>> import gelcone
    >>> model = gelcone.ConeModel(hoop_prestretch=1.4, rest_height=0.3, spring_stiffness=0.5)
    >>> found = gelcone.fold_voltages(model)
    >>> found.fold_voltage.values.round(4).tolist(), found.fold_displacement.values.round(4).tolist()
    ([1.217], [-0.5313])
    """
    balances = balances_of(model)
    folds = each(lambda balance: balance.folds(), balances)
    return label_static(model, balances, fold_variables(folds), title="folds of the equilibria")


@for_devices
def pull_in_voltage(model: Ensemble, start: Lengths | None = None) -> xr.Dataset:
    """Compute where the disc jumps or a film pulls in on a slow (quasi-static) voltage ramp from 0.

    A pitchfork from which the disc rises gradually is neither: the ramp follows it (`pitchfork_voltage`). Films in
    opposite phase both rise to their bias first (`stroke_and_blocked_force`).

    Parameters
    ----------
    model : one actuator or an ensemble; its drive plays no part, but for the bias of films in opposite phase.
    start : the ramp starts from the stable equilibrium without voltage nearest to this displacement; default the
        model's ``rest_height`` (of two equally near ones the higher).

    Returns
    -------
    Dataset over the ensemble's dims: ``pull_in_voltage`` (infinity if never, NaN where nothing is stable at v = 0);
    ``pull_in_kind``, a `PullIn`; ``pull_in_from``, the displacement there; ``pull_in_to``, where the disc goes: to the
    next stable equilibrium that the force leads to, infinity when there is none, NaN if never; ``rest_displacement``,
    where the ramp starts; and ``outcome``.

    Raises
    ------
    InputError : for what is neither a model nor a device.

    Examples
    --------
    >>> import gelcone
    >>> model = gelcone.ConeModel(film="wrinkling", law="neo-hookean", hoop_prestretch=1.4, rest_height=0.8)
    >>> found = gelcone.pull_in_voltage(model)
    >>> gelcone.PullIn(found.pull_in_kind.item()).name, round(found.pull_in_voltage.item(), 4)
    ('FILM', 0.9312)
    """
    balances = balances_of(model)
    variables = pull_in_variables(balances, rests_near(model, balances, start), model.system)
    return label_static(model, balances, variables, start=start, title="pull-in")


def fold_variables(folds: list[list[tuple[float, float]]]) -> dict[str, dataset.Variable]:
    """Variables of the folds (voltage, displacement) of each member, padded with NaN."""
    rows = [np.array(member_folds).reshape(-1, 2) for member_folds in folds]
    voltage, place = (padded([row[:, k] for row in rows]) for k in range(2))
    return {
        "fold_voltage": (("fold",), voltage, "voltage at which two equilibria meet in a fold", _FOLD),
        "fold_displacement": (("fold",), place, "displacement of the fold", PLACE),
    }


def pitchfork_variable(balances: list[StaticBalance]) -> dict[str, dataset.Variable]:
    """Variables of the voltage and displacement of each pitchfork."""
    voltage = pitchfork_voltages(balances)
    place = np.array([0.5 * balance.flat_height for balance in balances])
    meaning = PITCHFORK + at_own_bias(balances[0].system)
    return {
        "pitchfork_voltage": ((), voltage, meaning, PITCHFORK_ABSENT),
        "pitchfork_displacement": (
            (),
            np.where(np.isfinite(voltage), place, np.nan),
            "displacement that is left in the pitchfork",
            dataset.absent("length"),
        ),
    }


def jump_voltages(model: Ensemble) -> tuple[Array, Array]:
    """The constant voltage at which each member jumps or pulls in on a slow ramp from rest, (members,), infinite if
    never, and the `PullIn` that it is. A pitchfork that continues smoothly does not count."""
    balances = balances_of(model)
    lost = each(lambda balance, rest: balance.jump(rest), balances, each(rest_of, balances, [None] * len(balances)))
    return np.array([loss.voltage for loss in lost]), np.array([loss.kind for loss in lost], dtype=np.int8)


def of_the_cone(system: ConeSystem) -> str:
    """The addition to the meaning of a pull-in of the film as given: empty where that is a membrane already."""
    return ", of the cone itself" if any(map(is_cone, system.films)) else ""


def pull_in_variables(
    balances: list[StaticBalance], rests: list[float], system: ConeSystem
) -> dict[str, dataset.Variable]:
    """Variables of the jump or pull-in that ends the slow ramp of each member of a ``system`` from its rest."""
    lost = each(lambda balance, rest: balance.jump(rest), balances, rests)
    voltage, kind, before, after = (np.array([row[k] for row in lost]) for k in range(4))
    meaning = PULL_IN + at_own_bias(system) + of_the_cone(system)
    return {
        "rest_displacement": ((), np.array(rests), "stable equilibrium without voltage", "length"),
        "pull_in_voltage": ((), voltage, meaning, PULL_IN_ABSENT),
        "pull_in_kind": ((), kind.astype(np.int8), PULL_IN_KIND, PullIn),
        "pull_in_from": ((), before, "displacement at which the disc jumps or the film pulls in", _FROM),
        "pull_in_to": ((), after, "displacement that the disc jumps to", _TO),
    }

"""Maps over one or two parameters, and basins over initial states: the regime and its evidence in every cell."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from gelcone import dataset
from gelcone.atlas.plan import DEFAULT_INITIAL, Plan
from gelcone.atlas.sweep import sweep
from gelcone.codes import Regime
from gelcone.devices.analysis import analysis, plain
from gelcone.devices.device import Device
from gelcone.devices.si import in_words
from gelcone.errors import unknown_name
from gelcone.motion.flow import DEFAULT_TOLERANCE
from gelcone.motion.start import inside
from gelcone.motion.static_bifurcations import jump_voltages
from gelcone.physics.model import ConeModel
from gelcone.progress import weighted
from gelcone.quantity import Time
from gelcone.register.analyses import find_analysis

if TYPE_CHECKING:
    import xarray as xr

SAME_ATTRACTOR = 1e-3
"""Largest difference between the extents of equal cycles, as a share of the size of the larger one."""


TITLE = "parameter map"
ALSO = ("power", "margin")
"""Quantities that a map may hold in addition to the regimes."""


@analysis(
    answers="grids",
    over="A parameter of the map, or a field of a device: name=from:to:count or name=v1,v2,...; give two, the "
    "first one is drawn along x.",
    single=True,
    takes="device",
    examples=(
        "--preset base --over voltage=0:2:101 --over prestretch=0.4:2:81 --out results",
        'biased-pump --over "film_thickness=0.1 mm:0.3 mm:41" --over "frequency=5 Hz:20 Hz:61" --out results',
        "--preset base --over voltage=0:2:512 --over prestretch=0.4:2:512 --store map.zarr",
        "--resume map.zarr --out results",
    ),
)
def map(
    model: ConeModel | Device,
    over: Mapping[str, npt.ArrayLike],
    initial: tuple[float, float] = DEFAULT_INITIAL,
    *,
    transient: Time | None = None,
    patience: Time | None = None,
    budget: Time = 20_000.0,
    tolerance: float = DEFAULT_TOLERANCE,
    coarsest: int | None = None,
    also: str | None = None,
    store: str | Path | None = None,
    threads: int | None = None,
    progress: Callable[[float], None] | None = None,
) -> xr.Dataset:
    """Compute regime, exponents with errors, amplitude and outcome over a grid of parameters (usually two).

    `gelcone.sweep` does the same for any analysis, on a cluster too, and resumes a store.

    Parameters
    ----------
    model : a single model, or a device; what is swept replaces its own.
    over : name -> increasing values, at least two of each: parameters of the model, or fields of the device.
    initial : displacement and velocity at time 0 in every cell, as in `Plan`. Default (1, 0), or that of the device.
    transient, patience, budget, tolerance : as in `regime`.
    coarsest : points along each axis that are computed at least; the map is refined where it changes between them.
        Default: every cell is computed.
    also : another number of every cell: ``"power"``, the mean power that the source gives the settled motion, or
        ``"margin"``, by which share the peak voltage is below the constant voltage at which the disc jumps or the film
        pulls in. Default none.
    store : folder that keeps what is computed while the map runs. Default none.
    threads : number of threads of this process. Default one process a core for 1,024 cells or more, else one thread a
        core. Does not change a bit of the result.
    progress : called with the share of the work just done (the shares add up to 1).

    Returns
    -------
    Dataset over the swept names with the variables of `regime` but the section, ``status`` and ``source`` as in
    `gelcone.sweep`, and what was asked for ``also``. A cell that fails carries its ``outcome`` and the regime ``left
    the domain`` or, where it ran out of steps or digits, ``transient``; the others are not affected by it.

    Raises
    ------
    InputError : for unknown names, too few or unsorted values, budgets that are not positive, no cell inside its limit,
        and an unknown name ``also``.

    Examples
    --------
    >>> import gelcone
    >>> model = gelcone.ConeModel(damping_ratio=0.1, spring_stiffness=0.5)
    >>> found = gelcone.map(model, {"voltage": [0.4, 0.8], "drive_frequency": [0.4, 0.5]})
    >>> [[gelcone.Regime(code).label for code in row] for row in found.regime.values], found.period.values.max().item()
    ([['rest', 'rest'], ['periodic', 'periodic']], 2)
    """
    options = {"transient": transient, "patience": patience, "budget": budget, "tolerance": tolerance}
    if also is not None and also not in ALSO:
        raise unknown_name("quantity of a map", also, ALSO)
    plan = Plan(model, over, initial, options=options)
    plan.check_order("a map")
    report = progress if also != "power" else weighted(progress, 0.5)
    result = plain(sweep)(plan, coarsest=coarsest, store=store, threads=threads, progress=report)
    return with_quantity(result, plan, also, threads=threads, progress=report).assign_attrs(title=TITLE)


def with_quantity(result: xr.Dataset, plan: Plan, also: str | None, **options: Any) -> xr.Dataset:
    """The map of a ``plan`` with the quantity ``also``, see `map`; ``options`` are those of `gelcone.sweep`."""
    if also is None or also in result:
        return result
    if also == "power":
        option_names = find_analysis("settled").options
        settled_options = {name: value for name, value in plan.options.items() if name in option_names}
        settled = plain(sweep)(replace(plan, options=settled_options), "settled", **options)
        return result.assign(power=settled["power"])
    cells, model, _ = plan.possible()
    members = model.members()
    is_inside, margin = inside(members, 0.0), np.full(plan.size, np.nan)
    if is_inside.any():
        members_inside = members.take(is_inside)
        margin[cells[is_inside]] = 1.0 - members_inside.peak_voltage / jump_voltages(members_inside)[0]
    about = dataset.attributes("by which share the peak voltage is below the constant one of pull-in", "share")
    return result.assign(margin=(tuple(plan.over), margin.reshape(plan.shape), about))


@analysis(
    answers="grids",
    over="Initial displacements or velocities, from:to:count or v1,v2,... (with a device '-5 mm:5 mm:41').",
    single=True,
    takes="device",
    examples=(
        "--set voltage=1.04 --set drive_frequency=0.1 --out results",
        "--set voltage=1.2 --over displacement=-1:1:41 --over velocity=-1:1:41 --json",
    ),
)
def basin(
    model: ConeModel | Device,
    over: Mapping[str, npt.ArrayLike],
    *,
    transient: Time | None = None,
    patience: Time | None = None,
    budget: Time = 20_000.0,
    tolerance: float = DEFAULT_TOLERANCE,
    threads: int | None = None,
    progress: Callable[[float], None] | None = None,
) -> xr.Dataset:
    """Find the regimes that coexist: the attractor that each initial state ends on, and the attractors' shares.

    Parameters
    ----------
    model : a single model, or a device.
    over : two of the states -> increasing values: ``displacement`` and ``velocity``, or of a model others by their
        names; other states start from 0, or from their component's default.
    transient, patience, budget, tolerance : as in `regime`.
    threads : number of threads of this process. Default one process a core for 1,024 cells or more, else one thread a
        core. Does not change a bit of the result.
    progress : called with the share of the work just done (the shares add up to 1).

    Returns
    -------
    Dataset over ``displacement`` and ``velocity`` with ``attractor`` (number of the attractor, -1 where the motion has
    left the domain or not settled) and the variables of `regime` but the section; over ``attractor_number`` the
    attractors by falling ``attractor_share`` of the grid: ``attractor_regime``, ``attractor_period``,
    ``attractor_lowest``, ``attractor_highest`` and ``attractor_lyapunov``. A motion and its mirror image are two
    attractors.

    Raises
    ------
    InputError : as `map`.

    Examples
    --------
    >>> import gelcone
    >>> model = gelcone.ConeModel(damping_ratio=0.1, voltage=0.8, spring_stiffness=0.5, drive_frequency=0.5)
    >>> found = gelcone.basin(model, {"displacement": [-0.8, 0.8], "velocity": [-0.5, 0.5]})
    >>> found.attractor.values.tolist(), found.attractor_share.values.tolist()
    ([[0, 0], [0, 0]], [1.0])
    """
    options = {"transient": transient, "patience": patience, "budget": budget, "tolerance": tolerance}
    plan = Plan(model, over, (0.0, 0.0), options=options)
    result = plain(sweep)(plan, threads=threads, progress=progress).drop_vars(["status", "source"])
    result = result.assign_attrs(title="basins of attraction")
    flat = {name: result[name].values.reshape(plan.size, -1)[:, 0] for name in _DESCRIBING}
    ends = np.where(flat["period"] > 0, Regime.PERIODIC, Regime.REST)
    flat["regime"] = np.where(flat["regime"] == Regime.TRANSIENT_CHAOS, ends, flat["regime"])
    width = 1.0 if plan.device is None else plan.device.scales.shown("length")
    numbers, first = attractors({**flat, "lowest": flat["lowest"] / width, "highest": flat["highest"] / width})
    shares = np.array([(numbers == n).mean() for n in range(len(first))])
    table: dict[str, tuple[Any, str, dataset.Of]] = {
        "attractor_share": (shares, "share of the initial states", "share")
    }
    # the cells of a device are in its units already, so that their attributes are copied
    for name, meaning in _DESCRIBING.items():
        attrs = result[name].attrs
        table[f"attractor_{name}"] = (
            flat[name][first],
            meaning if attrs.get("units") == "1" else in_words(meaning),
            attrs,
        )
    about = dataset.attributes("number of the attractor, -1 if none", "code")
    result["attractor"] = tuple(plan.over), numbers.reshape(plan.shape), about
    return result.assign(dataset.columns("attractor_number", table))


_DESCRIBING = {
    "regime": "kind of motion",
    "period": "period in forcing periods, 0 if none",
    "lowest": "lowest displacement",
    "highest": "highest displacement",
    "lyapunov": "largest Lyapunov exponent per unit time",
}
"""Variables of a cell that describe its attractor -> meaning."""


def attractors(cells: Mapping[str, npt.NDArray[Any]]) -> tuple[npt.NDArray[np.int64], npt.NDArray[np.intp]]:
    """Number of the attractor of each cell, -1 for none, in order of falling frequency, and one cell of each attractor.

    ``cells`` holds ``regime``, ``period``, ``lowest`` and ``highest`` of each cell, dimensionless.
    """
    numbers = np.full(len(cells["regime"]), -1)
    first_cells: list[int] = []
    settled = ~np.isin(cells["regime"], (Regime.TRANSIENT, Regime.LEFT_THE_DOMAIN))
    for cell in np.flatnonzero(settled):
        match = next((n for n, other in enumerate(first_cells) if _same(cells, int(cell), other)), len(first_cells))
        if match == len(first_cells):
            first_cells.append(int(cell))
        numbers[cell] = match
    counts = np.bincount(numbers[numbers >= 0], minlength=len(first_cells))
    order = np.argsort(-counts, kind="stable")
    rank = np.empty(len(first_cells), dtype=int)
    rank[order] = np.arange(len(first_cells))
    return np.where(numbers >= 0, rank[numbers] if first_cells else -1, -1), np.array(first_cells, dtype=int)[order]


def _same(cells: Mapping[str, npt.NDArray[Any]], one: int, other: int) -> bool:
    """True if two settled motions are on one attractor: of the same regime and, for rests and cycles, the same extent.

    Chaotic and quasi-periodic motions reach their extent too slowly; each of these regimes counts as one attractor.
    """
    regime, period = cells["regime"], cells["period"]
    if regime[one] != regime[other] or period[one] != period[other]:
        return False
    if regime[one] in (Regime.CHAOTIC, Regime.QUASI_PERIODIC):
        return True
    ends = np.array([[cells["lowest"][i], cells["highest"][i]] for i in (one, other)])
    return bool(np.abs(ends[0] - ends[1]).max() <= SAME_ATTRACTOR * max(np.abs(ends).max(), 1e-2))

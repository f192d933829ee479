"""The membrane from disc to rim at held heights and voltages: shape, stretches, field, wrinkles and capacitance."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
import numpy.typing as npt

from gelcone import dataset
from gelcone.codes import Code, FilmPullIn, Outcome
from gelcone.devices.analysis import analysis
from gelcone.errors import InputError
from gelcone.membrane.elements import Elements
from gelcone.membrane.gel import Gel
from gelcone.membrane.profile import Profile, held, profile
from gelcone.motion.ramp import stroke_and_blocked_force
from gelcone.motion.static_results import constant_voltages, own_levels
from gelcone.physics.balance import StaticBalance
from gelcone.physics.film.membrane import KINDS, MembraneFilm
from gelcone.physics.members import Members
from gelcone.physics.model import ConeModel
from gelcone.physics.placed import PlacedFilm
from gelcone.physics.statics import every_balance
from gelcone.progress import Counted, Progress
from gelcone.quantity import Array, Lengths, Voltages
from gelcone.register.analysis import CONSTANT_VOLTAGE, Axis

if TYPE_CHECKING:
    import xarray as xr

MOST_CELLS = 4000
"""Most states (heights times voltages times members) of one call."""
MOST_AT_ONCE = 250
"""States that are computed together."""
SMALLEST_EXCESS = 1e-9
"""Excess of the hoop length below which a ring is not wrinkled."""
SLACK = KINDS.index("slack")


class Held(Code):
    """Outcomes of holding a film at a height and a voltage."""

    HELD = 0, "held in tension"
    SLACK = 1, "slack: without tension, of no definite shape; raise the disc or lower the voltage"
    LOCALISED = 2, "pulled in: one ring has localised; lower the voltage or the disc"
    MINIMUM = 3, "pulled in: the slack film thins without limit; lower the voltage"
    STRETCH_LIMIT = (
        4,
        "beyond 90 % of the stretch limit next to the disc, or of the heights that are computed; lower the disc",
    )
    NO_REST = 5, "the disc does not rest at this voltage on a slow ramp; give a height or a lower voltage"
    UNRESOLVED = 6, "closer to pull-in than the rings are resolved; lower the voltage slightly"


@analysis(
    axes={"height": Axis("displacement", "displacement", least=1), "voltage": CONSTANT_VOLTAGE},
    answers="profile",
    examples=(
        "--film membrane --set radius_ratio=0.3 --over displacement=0.8 --over constant_voltage=0.3",
        'paper-table1 --film membrane --over "displacement=10 mm:30 mm:5" --over "constant_voltage=0 kV:4 kV:5"',
    ),
)
def film(
    model: ConeModel, height: Lengths | None = None, voltage: Voltages | None = None, *, progress: Progress = None
) -> xr.Dataset:
    """Compute shape, stretches, thickness, wrinkles, true field and capacitance of the membrane from disc to rim.

    Parameters
    ----------
    model : one actuator or an ensemble whose film is the membrane, of two films at least one.
    height : displacements x at which the disc is held, one number or a list. Default where it rests on a slow ramp to
        each voltage.
    voltage : constant voltages v, at least 0, one number or a list. Default the peak of the drive and, where it has
        one, its offset.
    progress : called with the share of the work just done (the shares add up to 1).

    Returns
    -------
    Dataset over the ensemble's dims, ``height`` (one entry at the rests), ``constant_voltage`` and ``ring``, from the
    disc to the rim. Of each state ``displacement``, ``held`` (a `Held`) and ``film_state``; ``force``, which pulls the
    disc back, ``charge``, ``capacitance`` (charge over voltage) and ``pull_in_film_voltage`` at that height;
    ``largest_field`` and ``largest_field_radius``, the mounted radius of its ring, ``breakdown_share``, that field over
    the dielectric strength, ``largest_limit_share`` of the stretch limit, ``least_tangent_stiffness`` (slope of a
    ring's meridional tension, zero where it localises) and ``least_tangent_stiffness_radius``, and ``wrinkled_share``
    of the mounted area. Of each ring ``mounted_radius``, ``ring_radius``, ``ring_height`` above the rim,
    ``meridional_stretch``, ``hoop_stretch``, ``thickness``, ``true_field``, ``limit_share``, ``tangent_stiffness``, and
    ``wrinkle_excess``, the share of the hoop that lies in wrinkles. ``outcome`` is that of the member.
    What belongs to the rings is NaN where the film is not held in tension; of a slack film the force is 0 and the
    capacitance known. In a double cone the second film's variables have ``second_`` before their names.

    All this is of states by finite elements, within 2e-4. Devices run on a film that is fitted to such states; the
    stated error of its force is ``film_error``.

    Raises
    ------
    InputError : for a film that is not the membrane, voltages below 0, heights that are not finite, and more than
        4000 states.

    Examples
    --------
    >>> import gelcone
    >>> rings = gelcone.film(gelcone.find_device("biased-pump"), ["20 mm"], ["0 V"])
    >>> f"the film pulls back with {rings.force.item():.1f} {rings.force.units}"
    'the film pulls back with 0.2 N'
    """
    members = model.members()
    films = [placed for placed in members.system.films if isinstance(placed.film, MembraneFilm)]
    if not films:
        raise InputError(f"film = {model.film.name}: does not vary from disc to rim; take film = membrane")
    levels = own_levels(model) if voltage is None else constant_voltages(voltage)
    heights = None if height is None else _heights(height)
    count = (members.size, 1 if heights is None else heights.size, levels.size)
    if np.prod(count) > MOST_CELLS:
        raise InputError(f"heights and voltages: make {np.prod(count)} states; take at most {MOST_CELLS}")
    balances = every_balance(members)
    x = _rests(members, levels) if heights is None else np.broadcast_to(heights[:, None], count)
    counted = Counted(progress)
    variables: dict[str, dataset.Variable] = {
        "displacement": (_CELL, x, "height of the disc", dataset.absent("length", nan="beyond pull-in"))
    }
    for placed in films:
        variables |= _variables(members, balances, placed, x, levels)
        counted(1.0 / len(films))
    coords: dict[str, dataset.Variable] = {
        "constant_voltage": (("constant_voltage",), levels, "constant voltage", "voltage")
    }
    if heights is not None:
        coords["height"] = (("height",), heights, "height of the disc", "length")
    counted.finish()
    return dataset.label(
        model,
        variables,
        coords=coords,
        outcome=np.full(members.size, Outcome.OK),
        options={
            "height": None if heights is None else heights.tolist(),
            "voltage": None if voltage is None else levels.tolist(),
        },
        title="film",
    )


_CELL = ("height", "constant_voltage")
_RING = (*_CELL, "ring")


def _heights(height: npt.ArrayLike) -> Array:
    """The heights. Raises `InputError` for anything but one or more finite numbers."""
    try:
        x = np.atleast_1d(np.asarray(height, dtype=float))
    except (TypeError, ValueError):
        raise InputError("height: must be a number or a list of numbers") from None
    if x.ndim > 1 or not x.size or not np.isfinite(x).all():
        raise InputError(f"height = {np.asarray(height).tolist()}: must be one finite number or a list of them")
    return x


def _rests(members: Members, levels: Array) -> Array:
    """Displacement at the end of a slow ramp to each voltage, (members, 1, voltages); NaN beyond pull-in."""
    ramp = stroke_and_blocked_force(members, levels)
    return np.reshape(ramp["displacement"].values, (members.size, 1, levels.size))


class _Cells(NamedTuple):
    """States of one film, flattened: its displacement and voltage, force and capacitance, the voltage at which it
    pulls in at that height, its state, and the code of `Held`."""

    x: Array
    voltage: Array
    force: Array
    capacitance: Array
    pull_in: Array
    kind: npt.NDArray[np.int8]
    held: npt.NDArray[np.int8]


def _variables(
    members: Members, balances: Sequence[StaticBalance], placed: PlacedFilm, x: Array, levels: Array
) -> dict[str, dataset.Variable]:
    """The variables of one film."""
    which = list(members.system.films).index(placed)
    squares = [balance.films(x[k], levels**2)[which] + np.zeros(x[k].shape) for k, balance in enumerate(balances)]
    cells = [_cells(members.numbers_at(k), placed, x[k], squares[k]) for k in range(members.size)]
    each = [_with_rings(members, placed, k, film_cells) for k, film_cells in enumerate(cells)]
    shape = x.shape
    states = _Cells(
        *(np.stack(values).reshape(shape) for values in zip(*(film_cells for film_cells, _ in each), strict=True))
    )
    profiles = Profile(*(np.stack(values) for values in zip(*(rings for _, rings in each), strict=True)))
    n = members.numbers(trailing=2)
    film_numbers = placed.own(n)
    lm, lh = np.sqrt(film_numbers["A"]), np.sqrt(film_numbers["B"])
    every = {name: value.reshape(*shape, -1) for name, value in zip(Profile._fields[1:], profiles[1:], strict=True)}
    at = Profile(profiles.radius, **every)
    field = states.voltage[..., None] * at.field
    strength = members.values.get("dielectric_strength")
    share = np.full(shape, np.nan) if strength is None else np.asarray(strength)[:, None, None]
    mounted = np.broadcast_to(profiles.radius[:, None, None], field.shape)
    up = np.sign(np.where(states.x == 0.0, 1.0, states.x))[..., None]
    nowhere = dataset.absent("field")
    highest, place = _largest(field, mounted)
    least, weakest = _largest(-at.tangent_stiffness, mounted)
    longest, _ = _largest(at.limit_share, mounted)
    cell: dict[str, dataset.Variable] = {
        "held": (_CELL, states.held, "whether the film is held in tension", Held),
        "film_state": (_CELL, states.kind, "state of the film", _KINDS),
        "force": (_CELL, states.force, "force with which the film pulls the disc back", "force"),
        "charge": (_CELL, states.capacitance * states.voltage, "charge on the film", "charge"),
        "capacitance": (_CELL, states.capacitance, "charge over voltage", "capacitance"),
        "pull_in_film_voltage": (_CELL, states.pull_in, "voltage on it at which it pulls in at this height", _NEVER),
        "largest_field": (_CELL, highest, "largest true electric field", nowhere),
        "largest_field_radius": (_CELL, place, "mounted radius of the ring of the largest field", "length"),
        "breakdown_share": (_CELL, highest / share, "largest field over the dielectric strength", _STRENGTH),
        "largest_limit_share": (_CELL, longest, "largest share of the stretch limit", "share"),
        "least_tangent_stiffness": (_CELL, -least, "least slope of a ring's tension by its stretch", "stress"),
        "least_tangent_stiffness_radius": (_CELL, weakest, "mounted radius of the ring where it is least", "length"),
        "wrinkled_share": (_CELL, _wrinkled(at), "share of the mounted area that is wrinkled", "share"),
        "film_error": ((), members.number(placed.prefix + "film_error"), "stated error of the force of runs", "share"),
        "mounted_radius": (("ring",), profiles.radius, "mounted radius of the ring", "length"),
        "ring_radius": (_RING, at.r, "radius of the ring", "length"),
        "ring_height": (_RING, up * at.z, "height of the ring above the rim", "length"),
        "meridional_stretch": (_RING, lm[..., None] * at.l1, "meridional stretch", "stretch"),
        "hoop_stretch": (_RING, lh[..., None] * at.width, "hoop stretch of the material", "stretch"),
        "thickness": (_RING, at.thickness, "thickness", "thickness"),
        "wrinkle_excess": (_RING, at.excess, "share of the hoop that lies in wrinkles", "share"),
        "true_field": (_RING, field, "true electric field", "field"),
        "limit_share": (_RING, at.limit_share, "share of the stretch limit", "share"),
        "tangent_stiffness": (_RING, at.tangent_stiffness, "slope of the meridional tension by its stretch", "stress"),
    }
    words = "" if placed.drive is None else "second film: "
    return {
        placed.prefix + name: (dims, values, words + meaning, quantity)
        for name, (dims, values, meaning, quantity) in cell.items()
    }


_KINDS = {"units": "1", "quantity": "flag"} | dataset.flags_of(KINDS)
_NEVER = dataset.absent("voltage")
_STRENGTH = dataset.absent("share", nan="unknown")


def _largest(values: Array, at: Array) -> tuple[Array, Array]:
    """The largest value of the rings of each state, and the value of ``at`` there; NaN where all values are NaN."""
    known = np.where(np.isnan(values), -np.inf, values)
    place = np.argmax(known, axis=-1)[..., None]
    highest, where = (np.take_along_axis(one, place, axis=-1)[..., 0] for one in (known, at))
    lost = np.isneginf(highest)
    return np.where(lost, np.nan, highest), np.where(lost, np.nan, where)


def _wrinkled(at: Profile) -> Array:
    """The share of the mounted area whose hoop is wrinkled."""
    R = at.radius[:, None, None]
    area = np.diff(R * R, axis=-1)
    slack = (at.excess > SMALLEST_EXCESS) + 0.0 * at.l1
    total = np.sum(0.5 * (slack[..., 1:] + slack[..., :-1]) * area, axis=-1)
    return np.asarray(total / area.sum(axis=-1))


def capacitance_of_states(members: Members, placed: PlacedFilm, x: Array, squared: Array) -> Array:
    """Capacitance of the membrane of one member at heights and squared voltages on it, as `film` gives it; NaN where no
    state is found."""
    return _with_rings(members, placed, 0, _cells(members.numbers_at(0), placed, x, squared))[0].capacitance


def _cells(n: Mapping[str, Any], placed: PlacedFilm, x: Array, squared: Array) -> _Cells:
    """States of the fitted film, on which devices run, under squared voltages on it."""
    numbers, at, V = placed.own(n), np.ravel(placed.place(x, n)), np.ravel(squared)
    v, finite = np.sqrt(V), np.isfinite(at)
    x0, fitted = np.where(finite, at, 0.0), placed.film
    kind = np.where(finite, fitted.state(x0, v, [], numbers).kind, -1)
    cell_values = (
        fitted.force(x0, V, [], numbers)[0],
        fitted.capacitance(x0, V, [], numbers),
        fitted.highest_squared(x0, numbers),
    )
    force, area, limit = (np.where(finite, values, np.nan) for values in cell_values)
    localised = fitted.pull_in_kind(fitted.switches(x0, V, [], numbers)) == FilmPullIn.LOCALISATION
    unsupported = np.where(
        np.abs(x0) > fitted.reach(numbers)[1], Held.STRETCH_LIMIT, np.where(localised, Held.LOCALISED, Held.MINIMUM)
    )
    as_held = np.where(kind == -1, unsupported, np.where(kind == SLACK, Held.SLACK, Held.HELD))
    as_held = np.where(finite, as_held, Held.NO_REST).astype(np.int8)
    return _Cells(at, v, force, area, np.sqrt(limit), kind.astype(np.int8), as_held)


def _with_rings(members: Members, placed: PlacedFilm, k: int, cells: _Cells) -> tuple[_Cells, Profile]:
    """The states of one member and their rings; force and capacitance are those of the rings where these are found."""
    n: dict[str, Any] = dict(placed.own(members.numbers_at(k)))
    ratio = float(members.values[placed.prefix + "radius_ratio"][k])
    assert isinstance(placed.film, MembraneFilm)
    elements = Elements(Gel(placed.film.law, n, n["A"], n["B"]), ratio)
    held_rows = np.flatnonzero(cells.held == Held.HELD)
    parts = []
    for start in range(0, max(held_rows.size, 1), MOST_AT_ONCE):
        block = held_rows[start : start + MOST_AT_ONCE]
        at = held(elements, np.abs(cells.x[block]), cells.voltage[block] ** 2)
        measured = elements.measures(at)
        parts.append((measured.force * np.sign(cells.x[block]), measured.area, at.found, *profile(elements, at)))
    force, area, found, radius, *rings = zip(*parts, strict=True)
    values = [np.full((cells.x.size, radius[0].size), np.nan) for _ in rings]
    for whole, ring in zip(values, rings, strict=True):
        whole[held_rows] = np.concatenate(ring)
    as_held, forces, areas = cells.held.copy(), cells.force.copy(), cells.capacitance.copy()
    forces[held_rows], areas[held_rows] = np.concatenate(force), np.concatenate(area)
    as_held[held_rows[~np.concatenate(found)]] = Held.UNRESOLVED
    return cells._replace(held=as_held, force=forces, capacitance=areas), Profile(radius[0], *values)

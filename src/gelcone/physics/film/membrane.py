"""The film as a membrane that wrinkles: its innermost ring is stretched most, and localises first.

The relaxed axisymmetric membrane (tension field, with a voltage; see `gelcone.membrane`) on a disc of the radius a
inside a ring of the radius b, for one axisymmetric state at each height and voltage. Its force x k(x^2, V) is fitted to
states of the membrane (`gelcone.membrane.table`) and vanishes where the film is slack. Energy and charge follow from it
(`gelcone.physics.film.membrane_energy`); programs take the charge from a fit (`gelcone.physics.film.membrane_charge`).

Below the cut between the two pieces of the fit a film falls slack as the voltage rises, and pulls in as a slack film;
above the cut it localises. A slack film above the cut counts as pulled in.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cache, cached_property, partial
from typing import Any

import numpy as np

from gelcone.bracket import RESOLVED
from gelcone.codes import FilmPullIn
from gelcone.errors import InputError
from gelcone.membrane import force as formulas
from gelcone.membrane.force import NEVER
from gelcone.membrane.gel import Gel
from gelcone.membrane.made import numbers_of, refusal
from gelcone.membrane.mean_length import mean_length
from gelcone.membrane.table import names as table_names
from gelcone.physics.component import Numbers
from gelcone.physics.film import membrane_charge, membrane_slack
from gelcone.physics.film.creeping_membrane import CreepingMembrane
from gelcone.physics.film.elastic import STEEP
from gelcone.physics.film.film import Border, FilmState, TracedState
from gelcone.physics.film.gel import RADIUS_RATIO, BranchedFilm
from gelcone.physics.film.membrane_energy import energy_and_area
from gelcone.physics.film.wrinkling import WrinklingCone, without_push
from gelcone.physics.implicit import known, root, traced
from gelcone.quantity import Array

KINDS = ("taut", "partly_wrinkled", "wrinkled", "slack")
"""States of the film: all hoops in tension, some, none; and without tension."""
SWITCHES = ("pulls", "near", "rim_taut", "any_taut")
ROUNDS = 16
"""Most Newton or bisection steps to the voltage at which the film has a given pull."""


@dataclass(frozen=True)
class MembraneFilm(BranchedFilm):
    """The membrane that wrinkles.

    Parameters
    ----------
    law : a strain-energy law. Default Gent.
    prestretch_mode : ``"radial"`` or ``"equibiaxial"``, as for the taut cone.
    branches, flow, flow_exponent, rested : Maxwell branches, as for the taut cone, on one mean length of the film (see
        `gelcone.physics.film.creeping_membrane`).
    """

    name = "membrane"
    kinds = KINDS
    traced_charge = True
    fitted_charge = True

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.reduced:
            raise InputError(
                f"reduced: relaxation_time_{self.reduced[0]} takes its states in a membrane; take the taut film, or "
                "leave it out of reduced"
            )

    def complete(self, given: Mapping[str, Any]) -> dict[str, Any]:
        ratio = RADIUS_RATIO["radius_ratio"]
        values = {"radius_ratio": ratio.check("radius_ratio", given.get("radius_ratio", ratio.default))}
        return super().complete(given) | values

    def numbers(self, parameters: Numbers) -> dict[str, Any]:
        """The numbers of the gel, of the fits of force and charge, and the switches."""
        law = self.law.numbers(parameters)
        ring_numbers = self._ring.numbers(parameters)
        table = numbers_of(self.law, law, parameters["radius_ratio"], ring_numbers["A"], ring_numbers["B"])
        ratio = {"radius_ratio": parameters["radius_ratio"]}
        charges = membrane_charge.numbers_of(self._area_of, ring_numbers | ratio, table, self.law)
        even = np.where(
            (ring_numbers["A"] >= ring_numbers["B"]) | (ring_numbers["B"] <= 1.0), 1.0, 0.0
        )  # as `Gel.has_rims`, of arrays
        geometry = ratio | {"even_slack": even}
        return (
            ring_numbers
            | table
            | charges
            | dict.fromkeys(self.switch_names, 1.0)
            | geometry
            | self.viscous.numbers(parameters)
        )

    @property
    def switch_names(self) -> tuple[str, ...]:
        """Names of the switches of the borders."""
        return (*SWITCHES, "in_tension") if self.branches else SWITCHES

    @property
    def number_names(self) -> tuple[str, ...]:
        """The names of `numbers`, without computing them, which takes seconds."""
        names = (
            *self._ring.number_names,
            *table_names(),
            *membrane_charge.names(),
            *self.switch_names,
            "radius_ratio",
            "even_slack",
            *self.viscous.numbers({name: q.default for name, q in self.viscous.parameters.items()}),
        )
        return tuple(dict.fromkeys(names))

    def _area_of(self, n: Numbers) -> membrane_charge.Area:
        """The capacitance of a film with numbers ``n`` as a function of s and V."""
        return lambda s, V: np.asarray(self._energy_and_area(s, V, n)[1])

    # --- branches ----------------------------------------------------------------------------------------------------

    @cached_property
    def creeping(self) -> CreepingMembrane:
        """The formulas of a film whose branches have states."""
        return CreepingMembrane(self)

    def resting_lengths(self, x: Any, squared: Any, n: Numbers) -> tuple[Any, Any]:
        s = np.maximum(np.square(x), n["mean_begin"])  # below, the film without voltage is loose
        return mean_length(s, n)[0], 1.0

    def branch_lengths(self, x: Any, squared: Any, y: list[Any], n: Numbers, xp: Any = np) -> tuple[Any, Any]:
        return self.creeping.lengths(x, squared, y, n, xp)

    def _place(self, x: Any, squared: Any, y: list[Any], n: Numbers, xp: Any = np) -> Any:
        """The squared height at which the film hangs: that of the disc, or its natural height where it is loose."""
        s = x * x
        return self.creeping.place(s, squared, y, n, xp)[0] if self.branches and y else s

    # --- force -------------------------------------------------------------------------------------------------------

    def force(self, x: Any, squared: Any, y: list[Any], n: Numbers, xp: Any = np) -> tuple[Any, Any]:
        """x k and its slope by x; 0 where the film is slack, NaN where it has pulled in."""
        if self.branches and y:
            force, slope = self.creeping.force(x, squared, y, n, xp)
        else:
            s = x * x
            film_pull, pulls = self.relaxed_pull(s, squared, n, xp)
            force, slope = x * (pulls * film_pull.k), pulls * (film_pull.k + 2.0 * s * film_pull.by_s)
        if traced(xp):
            return force, slope
        gone = self._gone(self._place(x, squared, y, n), squared, n)
        return np.where(gone, np.nan, force)[()], np.where(gone, np.nan, slope)[()]

    def relaxed_pull(self, s: Any, squared: Any, n: Numbers, xp: Any = np) -> tuple[formulas.Pull, Any]:
        """The pull of the film with relaxed branches, and 1 where it is in tension, else 0."""
        if traced(xp):
            pulls = 0.5 + 0.5 * n["pulls"]
            none = 0.0 * s
            slack = formulas.Pull(none, none, none, none, none, none, none, none)
            return (slack if known(pulls) == 0.0 else self._pull(s, squared, n)), pulls
        film_pull, slack = self._at(s, squared, n)
        return film_pull._replace(k=np.where(slack, 0.0, film_pull.k), by_s=np.where(slack, 0.0, film_pull.by_s)), 1.0

    def _pull(self, s: Any, squared: Any, n: Numbers) -> formulas.Pull:
        """The pull in a program, chosen by switches."""
        behind = 0.5 - 0.5 * n["rim_taut"], 0.5 - 0.5 * n["any_taut"]
        return formulas.Pull(*_of_switch(n, partial(formulas.pull, s=s, V=squared, n=n, behind=behind)))

    def _at(self, s: Any, squared: Any, n: Numbers, formula: Callable[..., Any] = formulas.pull) -> tuple[Any, Any]:
        """Values of a ``formula`` of the film in tension, of arrays, and a mask of where it is slack."""
        s, squared = np.broadcast_arrays(np.asarray(s, dtype=float), np.asarray(squared, dtype=float))
        with np.errstate(all="ignore"):
            near = s < n["cut_squared"]
            values = _of_pieces(near, partial(formula, s=s, V=squared, n=n))
            slack = near & (values.base <= 0.0) | (s < n["begin_squared"])
        return values, slack

    def _gone(self, s: Any, squared: Any, n: Numbers) -> Any:
        """Mask of where the film has pulled in."""
        with np.errstate(all="ignore"):
            return (squared > self._highest(s, n)) | np.isnan(s) | (s > n["reach_squared"])

    def _highest(self, s: Any, n: Numbers) -> Any:
        return np.where(s < n["cut_squared"], n["slack_limit"], formulas.pull_in(s, n))

    # --- borders -----------------------------------------------------------------------------------------------------

    @property
    def borders(self) -> tuple[Border, ...]:  # type: ignore[override]
        """Borders with the switches ``pulls`` (in tension or slack), ``near`` (below or above the cut), ``rim_taut``
        (all hoops in tension or not) and ``any_taut`` (some hoop in tension or none). The film ends at the last."""
        return (
            *((self.creeping.border,) if self.branches else ()),
            Border(self._slack_border, "pulls", divides=True, gentle=not self.branches),
            Border(self._cut_border, "near", divides=True),
            Border(partial(self._hoop_border, "rim", "rim_taut"), "rim_taut", divides=True, gentle=True),
            Border(partial(self._hoop_border, "whole", "any_taut"), "any_taut", divides=True, gentle=True),
            Border(self._end_border, seldom=True),
        )

    def _slack_border(self, x: Any, squared: Any, y: list[Any], n: Numbers, xp: Any) -> Any:
        near = 0.5 + 0.5 * n["near"]
        if known(near) == 0.0:
            return 1.0 + 0.0 * x
        s = self._place(x, squared, y, n, xp)
        return near * (n["pulls"] * formulas.tension(s, squared, n)) + (1.0 - near)

    def _cut_border(self, x: Any, squared: Any, y: list[Any], n: Numbers, xp: Any) -> Any:
        return n["near"] * (n["cut_squared"] - self._place(x, squared, y, n, xp))

    def _hoop_border(self, which: str, switch: str, x: Any, squared: Any, y: list[Any], n: Numbers, xp: Any) -> Any:
        s = self._place(x, squared, y, n, xp)
        pulls = 0.5 + 0.5 * n["pulls"]
        if known(pulls) == 0.0:
            return 1.0 + 0.0 * s
        (away,) = _of_switch(n, lambda piece: (formulas.distance(piece, which, s, squared, n),))
        return (1.0 - pulls) - pulls * (n[switch] * away)

    def _end_border(self, x: Any, squared: Any, y: list[Any], n: Numbers, xp: Any) -> Any:
        near, pulls = 0.5 + 0.5 * n["near"], 0.5 + 0.5 * n["pulls"]
        slack = n["slack_limit"] - squared
        if known(near) == 1.0:
            return pulls + (1.0 - pulls) * slack
        # a slack film does not come above the cut, below which there is no curve of localisation
        s = (1.0 - near) * self._place(x, squared, y, n, xp) + near * n["reach_squared"]
        above = pulls * (formulas.pull_in(s, n, xp) - squared) - (1.0 - pulls)
        return near * (pulls + (1.0 - pulls) * slack) + (1.0 - near) * above

    def switches(self, x: Any, squared: Any, y: list[Any], n: Numbers) -> dict[str, Any]:
        s = self._place(x, squared, y, n)
        spot, slack = self._at(s, squared, n, formulas.spot)

        def sign(positive: Any) -> Any:
            return np.where(positive, 1.0, -1.0)

        switches = {
            "pulls": sign(~slack),
            "near": sign(s < n["cut_squared"]),
            "rim_taut": sign(spot.rim <= 0.0),
            "any_taut": sign(spot.whole <= 0.0),
        }
        return switches | ({"in_tension": sign(s <= np.square(x))} if self.branches else {})

    def times_of_kinds(self, switches: Sequence[str], dwell: Array) -> Array:
        place = np.arange(dwell.shape[1])
        pulls, rim, some, tense = (
            (place >> list(switches).index(name)) & 1 == 0
            for name in ("pulls", "rim_taut", "any_taut", "in_tension" if self.branches else "pulls")
        )
        places = [pulls & rim & some & tense, pulls & ~rim & some & tense, tense & ~(pulls & some), ~tense]
        return np.stack([dwell[:, which].sum(axis=1) for which in places], axis=1)

    def pull_in_kind(self, switches: Numbers) -> Any:
        return np.where(switches["pulls"] > 0.0, FilmPullIn.LOCALISATION, FilmPullIn.MINIMUM)

    # --- where it has a state ----------------------------------------------------------------------------------------

    def strain_limit(self, n: Numbers) -> Any:
        """The x^2 at which the innermost ring of the film without voltage reaches 90 % of its stretch limit, or 9."""
        return n["reach_squared"]

    def reach(self, n: Numbers) -> tuple[float, float]:
        return 0.0, float(np.sqrt(n["reach_squared"]))

    def outside(self, x: float, n: Numbers) -> str:
        return self.refusal(n) or (
            f"initial displacement {x:g}: must be less than {self.reach(n)[1]:g} times film_radius - disc_radius "
            "either way, beyond which the membrane is not computed; start lower, or take film = wrinkling"
        )

    def unreachable(self, n: Numbers) -> str:
        return self.refusal(n) or super().unreachable(n)

    def refusal(self, n: Numbers) -> str:
        """Why the membrane cannot be computed, in words; empty where it can."""
        law = {name: n[name] for name in self.law.number_names}
        return refusal(self.law, law, n["radius_ratio"], n["A"], n["B"])

    def limit_share(self, x: Any, voltage: Any, y: list[Any], n: Numbers, state: FilmState | None = None) -> Any:
        """The larger of two shares: of the stretch limit, of the innermost ring; and of the largest squared height."""
        film_state = self.state(x, voltage, y, n) if state is None else state
        height = self._place(np.asarray(x, dtype=float), np.square(voltage), y, n) / n["reach_squared"]
        share = np.fmax(height, film_state.limit_share)
        if not (self.branches and y):
            return share
        lengths = self.branch_lengths(np.asarray(x), np.square(voltage), y, n)
        return np.fmax(share, self.viscous.limit_share(*lengths, y, n))

    def highest_squared(self, x: Any, n: Numbers) -> Any:
        """The V at which the film localises at x; below the cut, at which a slack film pulls in."""
        with np.errstate(invalid="ignore"):  # the curve of localisation begins at a height
            highest = self._highest(np.square(np.asarray(x, dtype=float)), n)
        return np.where(highest >= NEVER, np.inf, highest)[()]

    # --- statics -----------------------------------------------------------------------------------------------------

    def voltage_gain(self, x: Any, squared: Any, n: Numbers) -> Any:
        film_pull, slack = self._at(np.square(x), squared, n)
        gone = self._gone(np.square(x), squared, n)
        return (x * np.where(gone, np.nan, np.where(slack, 0.0, -film_pull.by_v)))[()]

    def balancing(self, x: Any, pull: Any, n: Numbers) -> Any:
        """Solve k(x^2, V) = ``pull`` for V, by Newton's method within a bracket; k falls as V rises.

        The film does not push, and has a least pull before it pulls in. Below these V rises so steeply that it is never
        reached, and the result stays monotone.
        """
        s, pull = np.broadcast_arrays(np.square(np.asarray(x, dtype=float)), np.asarray(pull, dtype=float))
        target = np.maximum(pull, 0.0)
        near = s < n["cut_squared"]
        with np.errstate(all="ignore"):
            slackening = s * 0.0 + formulas.tension(s, 0.0, n)
            low, high = np.zeros_like(s), np.where(near, np.maximum(slackening, 0.0), formulas.pull_in(s, n))
            end = np.where(high >= NEVER, 0.0, high)

            held = cache(lambda piece: formulas.Held.at(piece, s, n))

            def weight(V: Any) -> tuple[Any, Any]:
                film_pull, slack = self._at(s, V, n, lambda piece, s, V, n: held(piece).pull(V))
                return np.where(slack, 0.0, film_pull.k), film_pull.by_v

            weakest, strongest = weight(end)[0], weight(low)[0]
            too_weak, too_strong = weakest > target, target > strongest
            high, V = np.array(end), 0.5 * (low + end)
            moves = ~(too_weak | too_strong)
            for _ in range(ROUNDS):
                if not moves.any():
                    break
                strength, slope = weight(V)
                above = strength > target
                low, high = np.where(above, V, low), np.where(above, high, V)
                step = V - (strength - target) / slope
                step = np.where((step >= low) & (step <= high), step, 0.5 * (low + high))
                V, moves = np.where(moves, step, V), moves & (np.abs(step - V) > RESOLVED * V)
            squared = np.where(too_weak, end + STEEP * (weakest - target), V)
            squared = np.where(too_strong, strongest - target, squared)
        return (squared - STEEP * np.minimum(pull, 0.0))[()]

    # --- energies ----------------------------------------------------------------------------------------------------

    def work(self, x: Any, squared: Any, y: list[Any], n: Numbers) -> Any:
        """Energy of film and field less the charge times the voltage, plus V/2, so that it is 0 if no ring moves."""
        energy = self._energy_and_area(self._place(np.asarray(x), squared, y, n), squared, n)[0] + 0.5 * squared
        if not (self.branches and y):
            return energy
        return energy + self.viscous.energy(*self.branch_lengths(np.asarray(x), squared, y, n), y, n)

    def capacitance(self, x: Any, squared: Any, y: list[Any], n: Numbers, xp: Any = np) -> Any:
        """Mean square of the deformed over the mounted area; in a program from the fit of `membrane_charge`."""
        if not traced(xp):
            return self._energy_and_area(self._place(np.asarray(x), squared, y, n), squared, n)[1]
        pulls, near = 0.5 + 0.5 * n["pulls"], 0.5 + 0.5 * n["near"]
        if known(pulls) == 0.0:
            return membrane_slack.traced_area(self.law, squared, pulls, n, xp)
        behind, s = (0.5 - 0.5 * n["rim_taut"], 0.5 - 0.5 * n["any_taut"]), self._place(x, squared, y, n, xp)
        shares = {"near": near, "far": 1.0 - near}
        parts = {piece: share for piece, share in shares.items() if known(share) != 0.0}
        spots = {piece: formulas.spot(piece, s, squared, n) for piece in parts}
        areas = [
            share * membrane_charge.capacitance(piece, s, spots[piece], n, behind) for piece, share in parts.items()
        ]
        area = sum(areas[1:], areas[0])
        if known(pulls) == 1.0:
            return area
        return pulls * area + (1.0 - pulls) * membrane_slack.traced_area(self.law, squared, pulls, n, xp)

    def fitted_capacitance(self, x: Any, squared: Any, y: list[Any], n: Numbers) -> Any:
        """The `capacitance` that programs have, of arrays, which is faster by far; NaN where the film has pulled in."""
        x, squared = np.broadcast_arrays(np.asarray(x, dtype=float), np.asarray(squared, dtype=float))
        s = self._place(x, squared, y, n)
        spot, slack = self._at(s, squared, n, formulas.spot)
        behind = np.where(spot.rim > 0.0, 1.0, 0.0), np.where(spot.whole > 0.0, 1.0, 0.0)
        with np.errstate(all="ignore"):
            charge = partial(membrane_charge.capacitance, s=s, own=spot, n=n, behind=behind)
            area = _of_pieces(s < n["cut_squared"], charge)
            if slack.any():
                area = np.where(slack, membrane_slack.area(self.law, squared, n), area)
        return np.where(self._gone(s, squared, n), np.nan, area)[()]

    def _energy_and_area(self, s: Any, squared: Any, n: Numbers) -> tuple[Any, Any]:
        """Energy and capacitance, of arrays; NaN where the film has pulled in."""
        s, V = np.broadcast_arrays(np.asarray(s, dtype=float), np.asarray(squared, dtype=float))
        with np.errstate(all="ignore"):
            energy, area = energy_and_area(self.law, s, V, n)
            gone = self._gone(s, V, n)
        return np.where(gone, np.nan, energy)[()], np.where(gone, np.nan, area)[()]

    # --- what is asked of a film -------------------------------------------------------------------------------------

    @cached_property
    def _ring(self) -> WrinklingCone:
        """The ring next to the disc, whose hoop is held: a wrinkling cone at the meridian of the ring."""
        return WrinklingCone(law=self.law, prestretch_mode=self.prestretch_mode, pull_in="minimum")

    def state(self, x: Any, voltage: Any, y: list[Any], n: Numbers) -> FilmState:
        """Stretches and stresses next to the disc, where the meridian is stretched most, and the largest field of all
        rings; NaN where the film has pulled in."""
        s = self._place(np.asarray(x, dtype=float), np.square(voltage), y, n)
        s, squared = np.broadcast_arrays(s, np.square(voltage))
        spot, slack = self._at(s, squared, n, formulas.spot)
        gone = self._gone(s, squared, n)
        with np.errstate(all="ignore"):
            disc, largest = _of_pieces(s < n["cut_squared"], partial(formulas.ends, u=spot.u, q=spot.q, n=n))
            t = membrane_slack.natural_stretch(self.law, squared, n) if slack.any() else 1.0
            held = Gel(self.law, n, n["A"], n["B"]).width(np.sqrt(disc), np.ones_like(s), squared)
            m, width = np.where(slack, t / n["A"], disc), np.where(slack, t / n["B"], held)
            state = self._ring.state_of_lengths(m, width, np.broadcast_to(voltage, s.shape), n)
            field = np.where(slack, state.true_field, np.abs(voltage) * np.sqrt(np.maximum(largest, 1.0)))
            taut_kind = np.where(spot.rim <= 0.0, 0, np.where(spot.whole <= 0.0, 1, 2))
            kind = np.where(slack, 3, taut_kind)
        if self.branches and y:
            along, across = self.viscous.stresses(*self.branch_lengths(np.asarray(x), squared, y, n), y, n)
            stresses = state.meridional_stress + along, state.hoop_stress + across
            state = without_push(state._replace(meridional_stress=stresses[0], hoop_stress=stresses[1]))
            kind = np.where(s > np.square(x), 3, np.where(slack, 2, taut_kind))
        film_state = FilmState(*(np.where(gone, np.nan, values)[()] for values in state._replace(true_field=field)))
        return film_state._replace(kind=np.where(gone, -1, kind))

    def traced_state(self, x: Any, squared: Any, y: list[Any], n: Numbers, xp: Any) -> TracedState | None:
        """Stresses next to the disc, where a slack hoop takes its natural width, and the largest field of all rings."""
        s, pulls, near = self._place(x, squared, y, n, xp), 0.5 + 0.5 * n["pulls"], 0.5 + 0.5 * n["near"]
        share, disc, largest = s / n["reach_squared"], 1.0, 1.0
        if known(pulls) != 0.0:
            for piece, weight in {"near": near, "far": 1.0 - near}.items():
                if known(weight) != 0.0:
                    taut = formulas.spot(piece, s, squared, n)
                    ends = formulas.ends(piece, taut.u, taut.q, n)
                    disc, largest = disc + weight * (ends.disc - 1.0), largest + weight * (ends.field - 1.0)
        if known(pulls) is None:  # the formulas of a film in tension may give a slack one a negative length
            disc = pulls * disc + (1.0 - pulls)
        width = self._traced_width(disc, squared, pulls, n, xp) if known(pulls) != 0.0 else 1.0
        if known(pulls) != 1.0:
            t = membrane_slack.traced_stretch(self.law, squared, 1.0 - pulls, n, xp)
            disc, width = (pulls * taut + (1.0 - pulls) * (t / n[name]) for taut, name in ((disc, "A"), (width, "B")))
            largest = pulls * largest + (1.0 - pulls) * (disc * width)
        branch_stress: tuple[Any, Any] = (0.0, 0.0)
        if self.branches and y:
            lengths = mean_length(s, n)[0], 1.0
            branch_stress = self.viscous.stresses(*lengths, y, n)
            share = xp.maximum(share, self.viscous.limit_share(*lengths, y, n, xp))
        ring = without_push(self.traced_ring(disc, width, squared, n, xp, branch_stress), xp)
        field = squared * xp.maximum(largest, 1.0) if known(pulls) != 0.0 else ring.field_squared
        return ring._replace(field_squared=field, limit_share=xp.maximum(share, ring.limit_share))

    def _traced_width(self, m: Any, squared: Any, pulls: Any, n: Numbers, xp: Any) -> Any:
        """The squared width of the ring at the disc in a program: the larger of 1 and the width without hoop stress,
        the root n of B - r/n = V m K with r = G/(m n)."""

        def residual(width: Any, m: Any, squared: Any, xp: Any) -> Any:
            thin = n["G"] / (m * width)
            compliance = self.law.compliance(n["A"] * m + n["B"] * width + thin - 3.0, n, xp)
            slack = n["B"] - thin / width - squared * m * compliance
            return slack if known(pulls) == 1.0 else pulls * slack + (1.0 - pulls) * (width - 1.0)

        name = f"width at the disc at {[xp.node(value).index for value in (m, squared, pulls, n['G'])]}"
        first = lambda m, squared, xp: xp.sqrt(n["G"] / (n["B"] * m))  # noqa: E731
        return xp.maximum(root(xp, name, residual, (m, squared), first), 1.0)

    def describe(self) -> str:
        words = "membrane film: wrinkles where it would be compressed, and localises first at its innermost ring"
        reduced = " on one mean length of the film; it pulls in where the relaxed film does, early for a short time"
        return words + self.viscous.words + (reduced if self.branches else "")


def _of_pieces(near: Any, formula: Callable[[str], Any]) -> Any:
    """The arrays of a ``formula``, evaluated for the piece, near or far, of each place."""
    if near.all() or not near.any():
        return formula("near" if near.all() else "far")
    one, other = (formula(piece) for piece in formulas.PIECES)
    if not isinstance(one, tuple):
        return np.where(near, one, other)
    return type(one)(*(np.where(near, *pair) for pair in zip(one, other, strict=True)))


def _of_switch(n: Numbers, formula: Callable[[str], Sequence[Any]]) -> Sequence[Any]:
    """The values of a ``formula`` in a program, of the piece, near or far, that the switch ``near`` names."""
    near = 0.5 + 0.5 * n["near"]
    if known(near) == 1.0:
        return formula("near")
    far = formula("far")
    if known(near) == 0.0:
        return far
    return [near * one + (1.0 - near) * other for one, other in zip(formula("near"), far, strict=True)]

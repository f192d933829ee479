"""Double cones whose films have no limit, against what far displacements leave of the balance."""

import math
from dataclasses import dataclass

import numpy as np
import pytest

import gelcone
from gelcone.physics.balance import SEARCH_RANGE, PullIn, rest_of
from gelcone.physics.pair import Curve, PairBalance, _isolated
from gelcone.physics.statics import balances_of, rest_displacements
from tests.toys import CubicBias, PowerFilm

PAIR = gelcone.ConeModel(
    law="neo-hookean", film="taut", second_film="taut", second_flat_height=0.5, spring_stiffness=0.3
)


@pytest.mark.parametrize(("drive", "driven", "side"), [("same", 2, -1), ("opposite", 2, -1), ("constant", 1, 1)])
def test_without_a_limit_the_disc_leaves_where_the_voltage_takes_the_stiffness_of_all(drive, driven, side):
    """Far away a neo-Hookean film pulls with x (1 - v^2): all is gone at k + 2 = v^2 times the films that v drives."""
    found = gelcone.pull_in_voltage(PAIR.replace(second_drive=drive))
    assert int(found["pull_in_kind"]) == PullIn.RUNAWAY
    assert float(found["pull_in_voltage"]) == pytest.approx(math.sqrt(2.3 / driven), rel=1e-3)
    assert 0.9 * SEARCH_RANGE < side * float(found["pull_in_from"]) < SEARCH_RANGE
    assert float(found["pull_in_to"]) == side * math.inf


@pytest.mark.parametrize("drive", ["same", "constant"])
def test_with_a_limit_it_does_not(drive):
    found = gelcone.pull_in_voltage(PAIR.replace(second_drive=drive, law="gent"))
    assert int(found["pull_in_kind"]) == PullIn.NEVER
    assert float(found["pull_in_voltage"]) == math.inf


SINGLE = gelcone.ConeModel(
    film="taut", hoop_prestretch=1.3, rest_height=0.5, spring_stiffness=0.6, voltage=0.2, voltage_bias=0.4,
    drive_frequency=0.7, damping_ratio=0.1, stretch_limit=30.0,
)  # fmt: skip


def doubled(model, **changes):
    """Two such films flat in one plane, a spring twice as stiff, and all sqrt(2) as fast: the same motions."""
    return model.replace(
        second_film=model.film.name,
        spring_stiffness=2.0 * model.spring_stiffness,
        drive_frequency=math.sqrt(2.0) * model.drive_frequency,
        damping_ratio=math.sqrt(2.0) * model.damping_ratio,
        **changes,
    )


@pytest.mark.parametrize(
    "more", [{}, {"rest_height": -0.5}, {"law": "neo-hookean"}, {"hoop_prestretch": 0.9, "rest_height": 0.0}]
)
def test_two_equal_films_are_lost_where_one_is_with_half_the_spring(more):
    single = SINGLE.replace(**more)
    one, two = (gelcone.pull_in_voltage(model) for model in (single, doubled(single)))
    for name in ("rest_displacement", "pull_in_voltage", "pull_in_from", "pull_in_to"):
        assert float(two[name]) == pytest.approx(float(one[name]), rel=2e-3, abs=1e-6, nan_ok=True), name
    assert int(two["pull_in_kind"]) == int(one["pull_in_kind"])
    levels = [0.0, 0.3, 0.5]
    one, two = (gelcone.static(model, levels) for model in (single, doubled(single)))
    for k in range(3):
        at = [np.sort(found["equilibrium_displacement"].values[k].ravel()) for found in (one, two)]
        at = [places[np.isfinite(places)] for places in at]
        np.testing.assert_allclose(at[1], at[0], atol=1e-9)


def test_two_equal_films_move_as_one_with_half_the_spring():
    one, two = (gelcone.settled(model) for model in (SINGLE, doubled(SINGLE)))
    for name in ("lowest", "highest", "mean", "stroke", "field"):
        assert float(two[name]) == pytest.approx(float(one[name]), rel=1e-9), name
    np.testing.assert_allclose(two["harmonic_amplitude"], one["harmonic_amplitude"], rtol=1e-6, atol=1e-12)
    # the source gives twice the charge and the energy a period, whose length is the same over sqrt(2)
    for name in ("power", "current"):
        assert float(two[name]) == pytest.approx(2.0 * math.sqrt(2.0) * float(one[name]), rel=1e-6), name


@pytest.mark.parametrize("apart", [0.0, 0.5])
def test_of_two_equally_near_equilibria_past_a_pitchfork_the_higher_one_is_taken(apart):
    """Two equal films symmetric about the middle between their planes."""
    model = gelcone.ConeModel(
        film="taut", second_film="taut", second_flat_height=apart, rest_height=0.5 * apart, hoop_prestretch=1.2
    )
    lost = float(gelcone.pitchfork_voltage(model).pitchfork_voltage)
    levels = lost * np.array([0.98, 1.02, 1.1])
    found = gelcone.stroke_and_blocked_force(model, levels)["displacement"].values
    places = gelcone.static(model, levels)["equilibrium_displacement"].values
    assert found[0] == pytest.approx(0.5 * apart, abs=1e-9)
    np.testing.assert_allclose(found[1:], np.nanmax(places[1:], axis=1), rtol=1e-9)
    assert (found[1:] > 0.5 * apart + 0.05).all()


@pytest.mark.parametrize("drive", ["same", "opposite", "constant"])
def test_a_ramp_rests_where_forces_balance_up_to_its_first_loss_and_beyond(drive):
    """At each level a stable equilibrium of all that there are, and of neighbouring levels one near the other."""
    model = PAIR.replace(second_drive=drive, rest_height=0.3, hoop_prestretch=1.3)
    (balance,) = balances_of(model.members())
    assert isinstance(balance, PairBalance)
    rest = float(rest_displacements(model))
    lost = balance.losses(rest)[0]
    levels = np.concatenate([[0.0], lost.voltage * np.array([0.3, 0.31, 0.6, 0.9, 0.99])])
    place, losses = balance.along_ramp(rest, levels**2)
    assert losses.tolist() == [0] * 6
    assert place[0] == rest
    for x, level in zip(place, levels, strict=True):
        stable = [e.displacement for e in balance.equilibria(np.array([level**2]))[0] if e.stable]
        assert min(abs(x - other) for other in stable) < 1e-9
        assert abs(float(balance.force(x, level**2))) < 1e-12
    assert abs(place[2] - place[1]) < 0.05


@dataclass(frozen=True)
class NoStateAbove(PowerFilm):
    """A power film that pulls in at V = 2, at every displacement."""

    def highest_squared(self, x, n):
        return np.full(np.shape(x), 2.0)[()]


@pytest.mark.parametrize("drive", ["same", "constant"])
def test_where_a_film_has_pulled_in_there_is_no_equilibrium(drive):
    """Also where that is the second one."""
    model = gelcone.ConeModel(film=PowerFilm(), second_film=NoStateAbove(), second_drive=drive)
    for level, found in ((1.39, True), (1.42, False), (3.0, False)):
        own = {"second_voltage": level} if drive == "constant" else {}
        (balance,) = balances_of(model.replace(**own).members())
        at = balance.equilibria(np.array([level**2 if drive == "same" else 0.1]))[0]
        assert bool(at) == found
        assert all(abs(e.displacement) < 1.0 for e in at if e.stable)


class Softening(CubicBias):
    """k1 x + k3 x^3, of which k3 may be negative."""

    name = "softening"
    parameters = CubicBias.parameters | {"bias_cubic": gelcone.Quantity("k3", "cubic stiffness", -0.8)}


def test_a_pitchfork_that_does_not_continue_smoothly_throws_the_disc_where_it_throws_a_single_film():
    single = gelcone.ConeModel(film=PowerFilm(), bias=Softening(), film_modulus=0.5, bias_cubic=-1.0)
    pair = single.replace(second_film=PowerFilm(), bias_stiffness=2.4, bias_cubic=-2.0)
    (one,), (two,) = (balances_of(model.members()) for model in (single, pair))
    lost, same = one.losses(0.0)[0], two.losses(0.0)[0]
    assert (lost.kind, same.kind) == (PullIn.PITCHFORK, PullIn.PITCHFORK)
    assert same.voltage == pytest.approx(math.sqrt(1.2), rel=1e-6)
    assert same.before == pytest.approx(0.0, abs=1e-6)
    assert abs(same.after) > 0.3
    assert abs(same.after) == pytest.approx(abs(lost.after), rel=1e-4)


def test_a_pair_loses_its_flat_state_at_the_square_of_the_voltage_that_takes_its_stiffness():
    """k1 - 2 V = 0 of two power films; none where no voltage that is searched takes it, or where none is left."""
    model = gelcone.ConeModel(film=PowerFilm(), second_film=PowerFilm(), bias=CubicBias(), bias_stiffness=0.9)
    (balance,) = balances_of(model.members())
    assert balance.pitchfork() == pytest.approx(0.45, rel=1e-9)
    (stiff,) = balances_of(model.replace(bias_stiffness=2.0 * 21.0**2).members())
    assert math.isinf(stiff.pitchfork())
    (lost,) = balances_of(model.replace(bias_stiffness=-0.3).members())
    assert math.isnan(lost.pitchfork())


def test_each_curve_of_equilibria_is_followed_once():
    """The flat one, and the one that is born from it to both sides."""
    model = gelcone.ConeModel(film="taut", second_film="taut", hoop_prestretch=1.2)
    (balance,) = balances_of(model.members())
    highest = 1.3 * math.sqrt(balance.pitchfork())
    curves = balance.curves(highest)
    assert len(curves) == 2
    (flat,) = (curve for curve in curves if np.abs(curve[0]).max() < 1e-6)
    assert sorted([flat[1].min(), flat[1].max()]) == pytest.approx([0.0, highest], abs=1e-6)
    assert np.ptp(np.sign(np.diff(flat[1]))) == 0.0  # also with the pitchfork among its points
    assert np.abs(flat[1] - math.sqrt(balance.pitchfork())).min() < 1e-9
    born = next(curve for curve in curves if curve is not flat)
    assert born[0].min() == pytest.approx(-born[0].max(), rel=1e-6)
    assert born[0].max() > 0.1
    for x, voltage, slope in curves:
        np.testing.assert_allclose(balance.force(x, voltage**2), 0.0, atol=1e-8)
        np.testing.assert_allclose(slope, balance.slope(x, voltage**2), rtol=1e-12, atol=1e-14)


def test_a_pair_is_flat_where_nothing_lifts_it_and_films_are_flat_together():
    for changes, flat in (({}, True), ({"rest_height": 0.2}, False), ({"second_flat_height": 0.3}, False)):
        own = {"second_flat_height": 0.0, "rest_height": 0.0} | changes
        (balance,) = balances_of(PAIR.replace(**own).members())
        assert balance.flat == flat
        assert (balance.flat_height, balance.highest_squared) == (own["second_flat_height"], math.inf)


def test_a_pair_reaches_what_both_of_its_films_reach():
    """The flat films of pre-stretch 0.5 are beyond their limit of 8: the disc stays away from either plane."""
    wide = {"law": "gent", "stretch_limit": 8.0, "prestretch": 0.5, "prestretch_mode": "equibiaxial"}
    model = PAIR.replace(**wide, second_flat_height=4.0, second_prestretch=0.5, second_stretch_limit=6.0)
    (balance,) = balances_of(model.members())
    (least, most), (near, far) = (film.film.reach(film.own(balance.n)) for film in model.system.films)
    assert least > 0.5
    assert near > least
    x = np.array([-1.01 * (far - 4.0), 0.0, 0.99 * least, 1.01 * least, 4.0 - 1.01 * near, 4.0 - 0.99 * near, 4.0])
    inside = [4.0 - far < place < most and abs(place) > least and abs(4.0 - place) > near for place in x]
    assert balance.inside(x).tolist() == inside
    assert 0 < sum(inside) < x.size
    assert (balance.lowest, balance.highest) == (
        pytest.approx(max(-most, 4.0 - far)),
        pytest.approx(min(most, 4.0 + far)),
    )


def test_past_a_fold_the_disc_goes_where_the_force_leads_it():
    """A weak spring between two raised films: the upper well is lost, and the disc falls through both planes."""
    model = PAIR.replace(law="gent", hoop_prestretch=1.3, spring_stiffness=0.05, rest_height=0.3)
    (balance,) = balances_of(model.replace(second_flat_height=1.5).members())
    lost = balance.losses(
        float(balance.legs(float(rest_displacements(model.replace(second_flat_height=1.5))))[0].x[0])
    )[0]
    assert lost.kind == PullIn.FOLD
    between = np.linspace(lost.before, lost.after, 50)[1:-1]
    force = balance.force(between, (1.001 * lost.voltage) ** 2)
    assert (force * (lost.after - lost.before) < 0.0).all()
    assert abs(lost.after - lost.before) > 0.5


def test_a_fold_that_leads_nearby_is_a_jump_and_a_pitchfork_that_does_is_none():
    (balance,) = balances_of(PAIR.members())
    for end, before in ((PullIn.FOLD, 0.31), (PullIn.PITCHFORK, 0.30)):
        legs = [
            Curve(np.array([0.2, 0.3]), np.array([0.0, 0.5]), end),
            Curve(np.array([0.31]), np.array([0.5]), PullIn.NEVER),
        ]
        assert balance._loss(legs, 0).after == before


def test_of_places_in_a_row_at_which_nothing_acts_the_middle_one_counts():
    x = np.arange(10.0)
    holds = np.array([0, 1, 1, 1, 0, 0, 1, 0, 1, 1], dtype=bool)
    assert _isolated(x, holds) == [2.0, 6.0, 9.0]
    assert _isolated(x, np.zeros(10, dtype=bool)) == []


@pytest.mark.parametrize("drive", ["same", "constant"])
def test_folds_and_losses_of_a_pair_lie_where_its_force_and_its_slope_vanish(drive):
    model = PAIR.replace(law="gent", hoop_prestretch=1.3, spring_stiffness=0.05, rest_height=0.3, second_drive=drive)
    (balance,) = balances_of(model.replace(second_flat_height=1.5).members())
    folds = balance.folds()
    assert len(folds) > 0
    assert folds == sorted(folds)
    rest = rest_of(balance, None)
    lost = [(loss.voltage, loss.before) for loss in balance.losses(rest) if loss.kind == PullIn.FOLD]
    for voltage, x in folds + lost:
        assert abs(float(balance.force(x, voltage**2))) < 1e-9
        assert abs(float(balance.slope(x, voltage**2))) < 1e-5
    assert lost == [] or min(abs(voltage - lost[0][0]) for voltage, _ in folds) < 1e-8
    x = np.array([-0.2, 0.4, 1.1])
    taken = balance.voltage_force(x, 0.4)
    np.testing.assert_allclose(balance.force(x, 0.4), balance.force(x, 0.0) - taken, rtol=1e-12)
    each = 0.4 * x - (0.4 * (1.5 - x) if drive == "same" else 0.0)
    np.testing.assert_allclose(taken, each, rtol=1e-12)


def test_a_ramp_is_followed_once(monkeypatch):
    (balance,) = balances_of(gelcone.ConeModel(rest_height=0.8, second_film="taut", second_flat_height=1.4))
    rest, followed = rest_of(balance, None), []
    monkeypatch.setattr(
        PairBalance, "curve", lambda own, *at, whole=PairBalance.curve: followed.append(at) or whole(own, *at)
    )
    first = balance.losses(rest)
    count = len(followed)
    assert balance.losses(rest) == first
    assert len(followed) == count > 0


def test_a_ramp_goes_along_the_one_that_has_been_followed_further(monkeypatch):
    model = PAIR.replace(second_drive="opposite", voltage_bias=0.3, hoop_prestretch=1.2, rest_height=0.4)
    (balance,), (other,) = balances_of(model.members()), balances_of(model.members())
    rest, squared = rest_of(balance, None), np.linspace(0.4, 0.9, 5) ** 2
    alone = other.along_ramp(rest, squared)
    balance.losses(rest)
    monkeypatch.setattr(PairBalance, "curve", lambda *given: pytest.fail("another curve is followed"))
    found = balance.along_ramp(rest, squared)
    np.testing.assert_allclose(found[0], alone[0], rtol=1e-13)
    np.testing.assert_array_equal(found[1], alone[1])


def test_all_levels_of_a_ramp_are_solved_at_once(monkeypatch):
    """Each level converges for itself: at 200 levels the places are those at single levels, with as many calls."""
    model = PAIR.replace(second_drive="opposite", voltage_bias=0.3, hoop_prestretch=1.2, rest_height=0.4)
    (balance,) = balances_of(model.members())
    levels = np.linspace(0.0, 0.9, 200)
    place, _ = balance.along_ramp(rest := rest_of(balance, None), levels**2)
    alone = [balance.along_ramp(rest, levels[k : k + 1] ** 2)[0][0] for k in (0, 40, 120, 199)]
    np.testing.assert_allclose(place[[0, 40, 120, 199]], alone, rtol=1e-13)
    calls, whole = list[int](), PairBalance.force_and_slope
    monkeypatch.setattr(PairBalance, "force_and_slope", lambda own, *at: calls.append(1) or whole(own, *at))
    balance.along_ramp(rest, levels**2)
    assert 0 < len(calls) < 20


@pytest.mark.parametrize("circuit", [{}, {"series_resistance": 3.0, "leakage_time": 12.0}], ids=["ideal", "leak"])
def test_a_ramp_in_opposite_phase_goes_from_the_bias_both_ways_and_is_its_mirror_image(circuit):
    """Equal films: with v and 2 v0 - v exchanged the disc is as far from the other plane."""
    own = {"hoop_prestretch": 1.3, "second_hoop_prestretch": 1.3, "spring_stiffness": 0.0, "second_flat_height": 1.5}
    model = PAIR.replace(**own, **circuit, second_drive="opposite", voltage_bias=0.8)
    (balance,) = balances_of(model.members())
    rest = rest_of(balance, None)
    assert rest == pytest.approx(0.75)
    away = np.array([0.0, 0.05, 0.1, 0.3, 0.8])
    above, below = (balance.along_ramp(rest, (0.8 + side * away) ** 2) for side in (1.0, -1.0))
    np.testing.assert_allclose(above[0], 1.5 - below[0], rtol=1e-9)
    assert (np.diff(above[0][:4]) > 0.01).all()
    assert balance.along_ramp(rest, np.array([0.25]))[0][0] == pytest.approx(below[0][3], rel=1e-12)
    lost = float(balance.jump(rest).voltage)
    assert lost > 1.1
    assert above[1].tolist() == below[1].tolist() == [0, 0, 0, 0, int(lost < 1.6)]


def test_films_in_opposite_phase_have_at_their_bias_what_films_of_one_voltage_have_there():
    model = PAIR.replace(second_drive="opposite", voltage_bias=-0.6, rest_height=0.4)
    (opposite,), (same,) = (balances_of(one.members()) for one in (model, model.replace(second_drive="same")))
    rest, at = rest_of(same, None), np.array([0.36])
    assert rest_of(opposite, None) == rest
    np.testing.assert_allclose(opposite.along_ramp(rest, at)[0], same.along_ramp(rest, at)[0], rtol=1e-13)
    assert opposite.voltage_force(0.3, 0.36) == pytest.approx(same.voltage_force(0.3, 0.36), rel=1e-13)


@dataclass(frozen=True)
class Touching(PairBalance):
    """A pair whose force has a minimum of a size ``below`` zero between two neighbours of the grid."""

    below: float = 0.0

    @property
    def bottom(self):
        return float(self.grid[700] + 0.4 * (self.grid[701] - self.grid[700]))

    def force_and_slope(self, x, squared):
        away = np.asarray(x) - self.bottom
        return away * away * (2.0 + np.cos(away)) - self.below, away * (4.0 + 2.0 * np.cos(away) - away * np.sin(away))


@pytest.mark.parametrize("below", [1e-7, 1e-12, -1e-12])
def test_two_equilibria_between_neighbours_of_the_grid_are_found(below):
    (pair,) = balances_of(PAIR.members())
    balance = Touching(pair.system, pair.n, -1.0, 1.0, False, below)
    (found,) = balance.equilibria(np.zeros(1))
    width = math.sqrt(below / 3.0) if below > 0.0 else None
    wanted = [] if width is None else [balance.bottom - width, balance.bottom + width]
    assert [e.displacement for e in found] == pytest.approx(wanted, abs=1e-3 * (width or 1.0))
    assert np.diff(balance.grid)[700] > 2.5 * (width or 0.0)


def test_equilibria_on_known_curves_are_not_solved_for_again(monkeypatch):
    (balance,) = balances_of(PAIR.replace(second_flat_height=0.0, hoop_prestretch=1.2).members())
    solved, equilibria = [], PairBalance._equilibria
    monkeypatch.setattr(PairBalance, "_equilibria", lambda own, w: solved.append(w) or equilibria(own, w))
    curves = balance.curves(2.0 * math.sqrt(balance.pitchfork()))
    assert len(curves) == 2
    assert len(solved) < 4


@pytest.mark.parametrize("mirrored", [False, True])
def test_a_pair_pulls_in_where_the_field_of_a_film_does_and_its_mirror_image_there_too(mirrored):
    """The films' heights are h and d - h; the end of the curve is that of the film, not the last step before it."""
    own = {"meridional_prestretch": 1.412251, "hoop_prestretch": 1.413574}
    other = {"meridional_prestretch": 1.281896, "hoop_prestretch": 1.178611}
    first, second, height, gravity = (other, own, 6.69841, 8.185) if mirrored else (own, other, 4.16449, -8.185)
    device = gelcone.find_device("double-cone").replace(
        film="wrinkling", second_film="wrinkling", second_drive="same", second_flat_height="10.8629 mm",
        initial_height=f"{height} mm", spring_rate="8.16946 N/m", gravity=f"{gravity} m/s^2",
        **first, **{f"second_{name}": value for name, value in second.items()},
    )  # fmt: skip
    limits = gelcone.limits(device)
    assert float(limits["pull_in_voltage"]) == pytest.approx(2754.2028, abs=1e-3)  # a ramp of 2.4 V/s: 2754.20 V
    model = device.to_model()
    (balance,) = balances_of(model.members())
    end = balance.legs(rest_of(balance, None))[-1]
    assert end.end is PullIn.FILM
    assert not balance._pulled_in(end.x[-1], end.voltage[-1] ** 2)
    assert balance._pulled_in(end.x[-1], (end.voltage[-1] * (1.0 + 1e-7)) ** 2)

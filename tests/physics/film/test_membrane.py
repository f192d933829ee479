"""The membrane as a film: certified states and limits, one energy for force and charge, the engine against SciPy."""

import json
from functools import cache
from pathlib import Path

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from gelcone import ConeModel, InputError
from gelcone.codes import FilmPullIn, Outcome
from gelcone.membrane import force as formulas
from gelcone.membrane.force import NEVER
from gelcone.membrane.mean_length import mean_length
from gelcone.motion.flow import integrate
from gelcone.motion.response import simulate
from gelcone.physics.film.membrane import KINDS, MembraneFilm
from gelcone.physics.film.wrinkling import WrinklingCone
from gelcone.physics.trace import Graph
from tests.physics.film.membranes import MADE, film_of
from tests.physics.film.programs import in_program

REFERENCE = json.loads((Path(__file__).parents[2] / "reference" / "membrane.json").read_text())


def model_of(prestretch, **changes):
    own = {"prestretch": prestretch, "prestretch_mode": "equibiaxial"}
    own |= {"damping_ratio": 0.01, "spring_stiffness": 0.9, "rest_height": 0.5, "voltage": 0.3, "drive_frequency": 0.1}
    return ConeModel(film="membrane", **(own | changes))


def rows(kind):
    return [
        pytest.param(r, id=f"{r['meridional_prestretch']}-{r['hoop_prestretch']}-{r['x']:.2f}-{r['v']}")
        for r in REFERENCE[kind]
        if (r["radius_ratio"], r["meridional_prestretch"], r["hoop_prestretch"]) in MADE
    ]


@pytest.mark.parametrize("row", rows("states"))
def test_forces_and_charges_are_the_certified_ones(row):
    film, n = film_of(row["radius_ratio"], row["meridional_prestretch"], row["hoop_prestretch"])
    x, V = row["x"], row["v"] ** 2
    digits = 4e-3 if x < 2.0 else 1e-2
    force, without = (film.force(x, squared, [], n)[0] for squared in (V, 0.0))
    assert abs(force - row["force"]) < n["film_error"] * (row["force"] + 0.1 * without)
    assert force == pytest.approx(row["force"], rel=1e-3)
    assert film.capacitance(x, V, [], n) == pytest.approx(row["area"], rel=digits)
    state = film.state(x, row["v"], [], n)
    assert state.meridional_stretch / row["meridional_prestretch"] == pytest.approx(row["disc_m"] ** 0.5, rel=digits)
    if x < 2.0:  # where the films of devices are
        assert state.true_field == pytest.approx(row["largest_field"], rel=5e-3, abs=1e-9)


@pytest.mark.parametrize("row", rows("pull_in"))
def test_the_film_localises_at_the_certified_voltages(row):
    film, n = film_of(row["radius_ratio"], row["meridional_prestretch"], row["hoop_prestretch"])
    limit = float(film.highest_squared(row["x"], n))
    if (
        row["meridional_prestretch"] == 1 and row["x"] < 0.683
    ):  # of the states of tension above the lowest V that localises there the film knows none
        assert limit < row["v"] ** 2
    else:
        assert limit == pytest.approx(row["v"] ** 2, rel=4e-3)
        below, above = film.force(row["x"], np.array([0.999, 1.001]) * limit, [], n)[0]
        assert below > 0.0
        assert np.isnan(above)


def test_the_stated_error_is_that_of_the_fit_and_small():
    for made in MADE:
        assert 2e-4 < film_of(*made)[1]["film_error"] < 2e-2


def test_a_film_is_slack_below_the_height_at_which_it_begins_to_pull_also_where_no_voltage_slackens_it():
    """With the numbers of a film that has no piece in which it falls slack."""
    film, n = film_of(*MADE[1])
    own = {**n, "cut_squared": -1.0, "begin_squared": 0.09}
    force, slope = film.force(np.array([0.1, 0.29, 0.31, 0.6]), 0.0, [], own)
    np.testing.assert_array_equal(force[:2], 0.0)
    np.testing.assert_array_equal(slope[:2], 0.0)
    assert (force[2:] > 0.0).all()


def test_a_film_that_never_pulls_in_has_no_highest_voltage():
    film, n = film_of(*MADE[0])
    never = {**n, "slack_limit": NEVER, "cut_squared": 1.0}
    assert film.highest_squared(0.5, never) == np.inf
    assert np.isfinite(film.highest_squared(0.5, n))


def test_beyond_its_reach_the_film_has_no_state():
    film, n = film_of(*MADE[0])
    x = np.array([-1.0 - 1e-6, -1.0 + 1e-6, 1.0 - 1e-6, 1.0 + 1e-6]) * film.reach(n)[1]
    gone = [True, False, False, True]
    for found in (*film.force(x, 0.0, [], n), film.work(x, 0.0, [], n), film.state(x, 0.0, [], n).hoop_stress):
        np.testing.assert_array_equal(np.isnan(found), gone)
    np.testing.assert_array_equal(film.state(x, 0.0, [], n).kind, [-1, 0, 0, -1])
    for of in (film.work, film.capacitance):  # as of a motion that has ended
        assert np.isnan(of(np.array([np.nan, np.nan]), 0.01, [], n)).all()
    bound = f"initial displacement -9: must be less than {n['reach_squared'] ** 0.5:g} times film_radius - disc_radius "
    assert film.outside(-9.0, n).startswith(bound)
    assert film.unreachable(n) == "the film has no state at any displacement; change its parameters"
    early = {**n, "inverse_stretch_limit": 0.5}  # of a gel that is too close to its limit
    assert film.unreachable(early) == film.outside(0.1, early) == film.refusal(early) != ""


def test_the_kinds_follow_each_other_as_the_voltage_rises():
    film, n = film_of(0.2, 1, 1)
    kinds = film.state(0.5, np.linspace(0.0, 0.66, 40), [], n).kind
    assert list(dict.fromkeys(kinds.tolist())) == [0, 1, 2, 3]


@pytest.mark.parametrize("prestretch", [(1, 1), (1.5, 1.5), (1, 1.5)])
def test_balancing_is_the_voltage_at_which_the_film_pulls_so(prestretch):
    film, n = film_of(0.2, *prestretch)
    x, V = np.array([0.2, 0.45, 0.8]), np.array([0.05, 0.2, 0.2])
    pull = film.force(x, V, [], n)[0] / x
    assert film.balancing(x, pull, n) == pytest.approx(V, rel=1e-9)
    assert np.all(film.balancing(x, -np.ones(3), n) > 1e6)
    far = 0.9 * film.reach(n)[1]  # where it localises under tension no voltage makes it pull less
    highest = float(film.highest_squared(far, n))
    weakest = film.force(far, highest * (1.0 - 1e-9), [], n)[0] / far
    assert film.balancing(far, 0.5 * weakest, n) == pytest.approx(highest + 0.5e10 * weakest, rel=1e-6)


def test_pulls_that_no_voltage_balances_take_no_steps(monkeypatch):
    """At a height at which the film localises before it is slack; heights next to it are found as without it."""
    film, n = film_of(0.2, 1.0, 1.0)
    asked, pull = [], formulas.Held.pull
    monkeypatch.setattr(formulas.Held, "pull", lambda held, *given: asked.append(held.piece) or pull(held, *given))
    far, x = 0.9 * film.reach(n)[1], np.array([0.2, 0.8])
    alone = film.balancing(np.array([far, far]), np.array([1e-6, 1e3]), n)
    assert asked == ["far", "far"]  # the weakest and the strongest pull
    some = film.force(x, 0.1, [], n)[0] / x
    among = film.balancing(np.array([*x, far, far]), np.array([*some, 1e-6, 1e3]), n)
    np.testing.assert_array_equal(among, [*film.balancing(x, some, n), *alone])


@pytest.mark.parametrize(("prestretch", "voltage", "start"), [(1.0, 0.6, 0.5), (1.0, 0.3, 0.3), (1.5, 0.6, 0.5)])
def test_the_engine_follows_the_same_motion_as_scipy(prestretch, voltage, start):
    model = model_of(prestretch, voltage=voltage)
    period = float(model.drive_period)
    times = period * np.linspace(0.0, 0.5, 21)
    run = integrate(model, (start, 0.0), times, tolerance=1e-13)
    n, film = model.own_numbers, model.film

    def rates(time, state):
        squared = (voltage * np.sin(2.0 * np.pi * time / period)) ** 2
        own = {**n, **film.switches(state[0], squared, [], n)}
        return [float(value) for value in model.system.rates(time, list(state), own, np)]

    found = solve_ivp(rates, (0.0, times[-1]), (start, 0.0), method="DOP853", rtol=1e-9, atol=1e-11, t_eval=times)
    assert run.outcome[0] == Outcome.OK
    assert np.max(np.abs(run.states[0, :, 0] - found.y[0])) < 1e-7


@pytest.mark.usefixtures("undelivered")
def test_the_energy_of_a_long_run_through_all_kinds_balances():
    result = simulate(model_of(1.0, voltage=0.6), initial=(0.5, 0.0), periods=200)
    assert result["outcome"].item() == 0
    assert all(result[f"film_state_{kind}"].item() > 0.0 for kind in KINDS)
    moved = float(result["dissipated_energy"].max())
    assert np.max(np.abs(result["energy_residual"].values)) < 1e-10 * moved


@pytest.mark.parametrize("film", ["membrane", "wrinkling"])
def test_a_film_without_tension_passes_the_flat_state_without_pulling_in(film):
    """Near the flat state such a film has no force: spring and damper alone move the disc, up to far below rounding."""
    damping, own = 0.02, {"radius_ratio": 0.2} if film == "membrane" else {}
    model = ConeModel(film=film, drive_frequency=1.004, damping_ratio=damping, spring_stiffness=1.5, **own)
    springs = -float(model.system.rates(0.0, [1e-6, 0.0], model.own_numbers, np)[1]) / 1e-6
    model = model.replace(voltage=np.geomspace(0.003, 0.4, 10))
    times = np.linspace(0.0, 600.0 * float(model.drive_period), 601)
    for start in (1e-3, 1e-5):
        run = integrate(model, (start, 0.0), times)
        assert (run.outcome == Outcome.OK).all()
        own = np.sqrt(springs - damping**2)
        free = np.exp(-damping * times) * (np.cos(own * times) + damping / own * np.sin(own * times))
        assert np.abs(run.states[..., 0] / start - free).max() < 1e-3
        assert np.abs(run.states[:, -1, 0]).max() < 1e-30


def test_borders_at_which_a_film_does_not_end_are_gentle():
    def gentle(film):
        return [border.switch for border in film.borders if border.gentle]

    assert gentle(MembraneFilm()) == ["pulls", "rim_taut", "any_taut"]
    assert gentle(MembraneFilm(branches=1)) == ["rim_taut", "any_taut"]
    assert gentle(WrinklingCone()) == ["width_held", "pulls"]
    assert gentle(WrinklingCone(pull_in="minimum")) == []


def test_a_program_traces_no_force_for_the_borders_at_which_hoops_fall_slack(monkeypatch):
    """They are all alike in the laws of a second film, and a force takes longest to trace."""
    film = film_of(*MADE[0])[0]
    graph = Graph()
    n = {name: graph.number(name) for name in film.number_names}
    n |= {name: graph.switch(name) for name in film.switch_names}
    monkeypatch.setattr(formulas, "pull", lambda *given, **more: pytest.fail("a force is traced"))
    for border in film.borders:
        if border.switch in ("rim_taut", "any_taut"):
            assert graph.node(border.value(graph.state(0), graph.state(1), [], n, graph)).operation != "constant"


def test_a_film_raised_in_voltage_ends_by_localisation_before_the_cone_does():
    model = model_of(1.5, voltage=0.0, voltage_bias=1.3, rest_height=0.6, damping_ratio=0.3)
    run = integrate(model, (0.3, 0.0), [0.0, 50.0])
    assert run.outcome[0] == Outcome.PULLED_IN
    assert run.pull_in[0, 0] == FilmPullIn.LOCALISATION
    cone = integrate(model.replace(film="wrinkling"), (0.3, 0.0), [0.0, 50.0])
    assert cone.outcome[0] == Outcome.OK


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"radius_ratio": 1.0}, "radius_ratio = 1: must be below 1"),
        ({"radius_ratio": -0.1}, "radius_ratio"),
        ({"prestretch": 1.5, "stretch_limit": 1.75}, "stretch_limit: is too close to the pre-stretch"),
    ],
)
def test_films_that_are_not_computed_are_refused_in_words(changes, message):
    with pytest.raises(InputError, match=message):
        model_of(**({"prestretch": 1.0} | changes)).own_numbers  # noqa: B018


@pytest.mark.parametrize(("x", "exact"), [(0.1, 0.015409023585171428), (0.03, 0.0023216358788137044)])
def test_a_film_that_hangs_in_a_fold_is_ever_softer_towards_the_flat_one(x, exact):
    """Certified forces of a film whose hoop alone is stretched, without voltage: F/x falls with ln x."""
    film, n = film_of(0.2, 1, 1.5)
    force = film.force(x, 0.0, [], n)[0]
    assert force == pytest.approx(exact, rel=0.06)  # that of s + 1e-4
    assert force / x < film.force(0.3, 0.0, [], n)[0] / 0.3


def test_such_a_film_falls_slack_while_its_rims_are_taut_and_then_pulls_in():
    film, n = film_of(0.2, 1, 1.5)
    flat = 0.94426695
    heights = {0.4: 0.0537, 0.6: 0.1188, 0.8: 0.208}  # certified
    for share, x in heights.items():
        assert film.force(0.97 * x, share * flat, [], n)[0] == 0.0
        assert film.force(1.1 * x, share * flat, [], n)[0] > 0.0
    assert film.highest_squared(0.1, n) == pytest.approx(0.9210 * flat, rel=1e-3)


@pytest.mark.usefixtures("undelivered")
def test_the_energy_of_a_long_run_of_a_folded_film_balances():
    model = ConeModel(
        film="membrane", prestretch=1.5, prestretch_mode="radial", stretch_limit=50.0, damping_ratio=0.02, voltage=0.4,
        voltage_bias=0.3, rest_height=0.3, drive_frequency=0.7,
    )  # fmt: skip
    result = simulate(model, initial=(0.3, 0.0), periods=100)
    assert result["outcome"].item() == 0
    assert result["displacement"].min() < 0.1
    moved = float(result["dissipated_energy"].max())
    assert np.max(np.abs(result["energy_residual"].values)) < 1e-9 * moved


def test_branches_of_a_loose_membrane_are_as_long_as_where_it_begins_to_pull():
    """Below that height, where the fitted mean length means nothing, they start and end as they do there."""
    model = ConeModel(
        film="membrane", law="neo-hookean", prestretch=0.8, prestretch_mode="equibiaxial", rested="raised",
        viscous_modulus_1=0.5, relaxation_time_1=5.0, viscous_limit_1=0.01,
    )  # fmt: skip
    film, n = model.film, {name: value[0] for name, value in model.members().numbers().items()}
    begin = np.sqrt(n["mean_begin"])
    assert begin > 0.7
    for state, beyond in ((1.0, False), (0.7, True)):
        assert [bool(film.overstretched(x, [state, 1.0], n)) for x in (0.0, 0.2, begin)] == [beyond] * 3
    assert film.starts(0.2, n) == film.starts(begin, n)


# --- borders, programs and branches -----------------------------------------------------------------------------------


def sampled(n, count=240, seed=5):
    """Heights and squared voltages over all that the film has states for."""
    random = np.random.default_rng(seed)
    film, reach = MembraneFilm(), float(n["reach_squared"]) ** 0.5
    x = random.uniform(0.02, 0.95, count) * min(reach, 1.6)
    return x, random.uniform(0.0, 0.99, count) * np.minimum(film.highest_squared(x, n), 1.5)


def by_switches(signs):
    """The rows of equal switches, as a dict and a mask each."""
    table = np.array(list(signs.values())).T
    for row in np.unique(table, axis=0):
        yield dict(zip(signs, row, strict=True)), (table == row).all(axis=1)


@pytest.mark.parametrize("made", MADE)
def test_a_program_has_the_formulas_of_arrays_and_its_borders_the_side_of_the_switches(made):
    film, n = film_of(*made)
    x, squared = sampled(n)
    state, seen = film.state(x, np.sqrt(squared), [], n), 0
    share = film.limit_share(x, np.sqrt(squared), [], n)

    def formulas(x, squared, n, xp):
        borders = [border.value(x, squared, [], n, xp) for border in film.borders]
        own = film.traced_state(x, squared, [], n, xp)
        return [*film.force(x, squared, [], n, xp), film.capacitance(x, squared, [], n, xp), *own, *borders]

    for own, here in by_switches(film.switches(x, squared, [], n)):
        at = x[here], squared[here]
        force, slope, charge, along, across, field, limit, *borders = in_program(formulas, n, own, *at)
        np.testing.assert_allclose((force + 0.0 * at[0], slope + 0.0 * at[0]), film.force(*at, [], n), 1e-9, 1e-12)
        np.testing.assert_allclose(charge + 0.0 * at[0], film.capacitance(*at, [], n), rtol=3e-3)
        np.testing.assert_allclose(along, state.meridional_stress[here], rtol=1e-8, atol=1e-9)
        np.testing.assert_allclose(across, state.hoop_stress[here], rtol=1e-8, atol=1e-9)
        np.testing.assert_allclose(field, state.true_field[here] ** 2, rtol=1e-8)
        np.testing.assert_allclose(limit, share[here], rtol=1e-8)
        assert all(np.all(value > -1e-12) for value in borders)
        seen += 1
    assert seen > 1


@pytest.mark.parametrize("made", MADE)
def test_the_film_ends_where_its_border_says_so(made):
    """A slack one at its own limit, one in tension where it localises: which of the two the kind of pull-in names."""
    film, n = film_of(*made)
    x = np.linspace(0.03, 1.5, 60)
    highest = film.highest_squared(x, n)
    border = film.borders[-1]
    assert (border.switch, border.seldom) == (None, True)
    for share, whole in ((1.0 - 1e-9, True), (1.0 + 1e-9, False)):
        for own, here in by_switches(film.switches(x, share * highest, [], n)):
            value = border.value(x[here], share * highest[here], [], {**n, **own}, np)
            np.testing.assert_array_equal(value > 0.0, whole)
            kind = FilmPullIn.LOCALISATION if own["pulls"] > 0.0 else FilmPullIn.MINIMUM
            assert film.pull_in_kind(own) == kind
        np.testing.assert_array_equal(np.isnan(film.force(x, share * highest, [], n)[0]), not whole)


@pytest.mark.parametrize("branches", [0, 1])
def test_the_time_in_each_kind_is_counted_by_the_switches(branches):
    """In tension all around, partly wrinkled, wrinkled all around, slack: by hand for each set of switches."""
    film = MembraneFilm(branches=branches)
    names = ["another", *film.switch_names]
    dwell = np.random.default_rng(0).uniform(0.0, 1.0, (2, 2 ** len(names)))
    expected = np.zeros((2, 4))
    for place in range(dwell.shape[1]):
        on = {name: not (place >> k) & 1 for k, name in enumerate(names)}
        if not on["in_tension" if branches else "pulls"]:
            kind = 3
        elif not (on["pulls"] and on["any_taut"]):
            kind = 2
        else:
            kind = 0 if on["rim_taut"] else 1
        expected[:, kind] += dwell[:, place]
    np.testing.assert_allclose(film.times_of_kinds(names, dwell), expected, rtol=1e-14)


@cache
def creeping(made=MADE[0]):
    film, (_, n) = MembraneFilm(branches=1), film_of(*made)
    return film, n | film.viscous.numbers({"viscous_modulus_1": 0.4, "relaxation_time_1": 3.0, "viscous_limit_1": 20.0})


@pytest.mark.parametrize("made", [MADE[0], MADE[2]])
def test_a_film_that_creeps_is_one_energy_where_it_pulls_and_hangs_loose_where_it_would_push(made):
    """Loose it neither pulls nor knows where its disc is: charge, energy and stresses are those of its own height."""
    (film, n), h = creeping(made), 1e-4
    x, squared = sampled(n, 40, 6)
    random = np.random.default_rng(8)
    y = [random.uniform(0.35, 1.0, 40), random.uniform(0.9, 1.1, 40)]
    signs = film.switches(x, squared, y, n)
    loose = signs["in_tension"] < 0.0
    assert 3 < loose.sum() < 37
    force, slope = film.force(x, squared, y, n)
    own = film.work(x, squared, y, n)
    ahead, behind = (film.work(x + d, squared, y, n) for d in (h, -h))
    smooth = np.isfinite(ahead - behind) & (np.abs(ahead - 2.0 * own + behind) < 1e-6)
    assert smooth.sum() > 20
    np.testing.assert_allclose(force[smooth], ((ahead - behind) / (2.0 * h))[smooth], atol=2e-5)
    assert (force[loose & smooth] == 0.0).all()
    assert (slope[loose & smooth] == 0.0).all()
    s = film._place(x, squared, y, n)
    assert (s[loose] > x[loose] ** 2).all()
    np.testing.assert_array_equal(s[~loose], x[~loose] ** 2)
    for name in ("capacitance", "work"):
        at_own = getattr(film, name)(np.sqrt(s), squared, y, n)
        np.testing.assert_allclose(getattr(film, name)(x, squared, y, n), at_own, rtol=1e-9, atol=1e-12)
    state = film.state(x, np.sqrt(squared), y, n)
    whole = state.kind >= 0
    assert (state.kind[loose & whole] == 3).all()
    (m, width), hoop = (
        film.branch_lengths(x, squared, y, n),
        film.viscous.stresses(*film.branch_lengths(x, squared, y, n), y, n),
    )
    np.testing.assert_allclose(m, mean_length(s, n)[0], rtol=1e-12)
    assert width == 1.0
    elastic = film_of(*made)[0].state(np.sqrt(s), np.sqrt(squared), [], n)
    for found, plain, more in zip(
        (state.meridional_stress, state.hoop_stress),
        (elastic.meridional_stress, elastic.hoop_stress),
        hoop,
        strict=True,
    ):
        np.testing.assert_allclose(found[whole], np.maximum(plain + more, 0.0)[whole], rtol=1e-9, atol=1e-12)
    share = np.fmax(film_of(*made)[0].limit_share(x, np.sqrt(squared), [], n), film.viscous.limit_share(m, width, y, n))
    assert (film.limit_share(x, np.sqrt(squared), y, n) >= share - 1e-12)[whole].all()


def test_a_program_has_the_formulas_of_a_film_that_creeps():
    film, n = creeping()
    n = n | {"inverse_viscous_limit_1": 0.4}  # so that the share of the branch is the largest in some places
    x, squared = sampled(n, 60, 6)
    random = np.random.default_rng(8)
    y = [random.uniform(0.7, 1.0, 60), random.uniform(0.9, 1.1, 60)]

    def formulas(x, squared, y, n, xp):
        borders = [border.value(x, squared, y, n, xp) for border in film.borders[:-1]]
        own = film.traced_state(x, squared, y, n, xp)
        return [film.force(x, squared, y, n, xp)[0], film._place(x, squared, y, n, xp), *own, *borders]

    for own, here in by_switches(film.switches(x, squared, y, n)):
        at = x[here], squared[here], [value[here] for value in y]
        force = film.force(*at, n)[0]
        whole = np.isfinite(force)
        found, place, along, across, field, share, *borders = in_program(formulas, n, own, *at)
        state = film.state(at[0], np.sqrt(at[1]), at[2], n)
        np.testing.assert_allclose(along[whole], state.meridional_stress[whole], rtol=1e-7, atol=1e-8)
        np.testing.assert_allclose(across[whole], state.hoop_stress[whole], rtol=1e-7, atol=1e-8)
        np.testing.assert_allclose(field[whole], state.true_field[whole] ** 2, rtol=1e-7)
        right = film.limit_share(at[0], np.sqrt(at[1]), at[2], n)
        np.testing.assert_allclose((share + 0.0 * at[0])[whole], right[whole], rtol=1e-7)
        np.testing.assert_allclose((found + 0.0 * at[0])[whole], force[whole], rtol=1e-8, atol=1e-10)
        np.testing.assert_allclose((place + 0.0 * at[0])[whole], film._place(*at, n)[whole], rtol=1e-7)
        near = [border.switch for border in film.borders].index("near")  # by the height at which it hangs
        np.testing.assert_allclose(borders[near], own["near"] * (n["cut_squared"] - place), rtol=1e-12)
        assert all(np.all((value + 0.0 * at[0])[whole] > -1e-9) for value in borders)


@pytest.mark.parametrize("made", MADE[:2])
def test_a_program_in_which_a_switch_may_change_has_the_same_formulas(made):
    """The circuit's limits and the second film's switches do not divide laws: formulas then weigh both sides."""
    film, n = film_of(*made)
    x, squared = sampled(n, 120, 7)
    signs = film.switches(x, squared, [], n)
    state, own = film.state(x, np.sqrt(squared), [], n), {**n, **signs}

    def formulas(x, squared, n, xp):
        borders = [border.value(x, squared, [], n, xp) for border in film.borders]
        traced = film.traced_state(x, squared, [], n, xp)
        return [*film.force(x, squared, [], n, xp), film.capacitance(x, squared, [], n, xp), *traced, *borders]

    force, slope, charge, along, across, field, limit, *borders = in_program(formulas, own, {}, x, squared)
    np.testing.assert_allclose((force, slope), film.force(x, squared, [], n), 1e-9, 1e-12)
    np.testing.assert_allclose(charge, film.capacitance(x, squared, [], n), rtol=3e-3)
    np.testing.assert_allclose(along, state.meridional_stress, rtol=1e-8, atol=1e-9)
    np.testing.assert_allclose(across, state.hoop_stress, rtol=1e-8, atol=1e-9)
    np.testing.assert_allclose(field, state.true_field**2, rtol=1e-8)
    np.testing.assert_allclose(limit, film.limit_share(x, np.sqrt(squared), [], n), rtol=1e-8)
    for border in borders:
        assert (border > -1e-12).all()


def test_no_voltage_weakens_the_force_of_a_slack_film():
    film, n = film_of(*MADE[0])
    np.testing.assert_array_equal(film.voltage_gain(0.3, np.array([0.4, 0.43]), n), [0.0, 0.0])
    assert film.voltage_gain(0.5, 0.1, n) > 0.1

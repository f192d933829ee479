"""The search of designs: cubes of fields, margins, quantiles and levels, in a world of closed forms."""

from dataclasses import replace

import numpy as np
import pytest

from gelcone.errors import InputError
from gelcone.lab import front as fronts
from gelcone.lab.candidates import LIMITS, Found
from gelcone.lab.wish import FIRST_WISH, NO_SAMPLES, Objective, Requirement, Samples, Tolerance, read_wish

WISH = FIRST_WISH.replace("{file}", "wish.toml")
POWER, PEAK = Objective("apparent_power", False), Objective("peak_voltage", False)


@pytest.fixture
def wish(tmp_path):
    """Reads a text as a wish."""

    def read(text):
        (tmp_path / "wish.toml").write_text(text, encoding="utf-8")
        return read_wish(tmp_path / "wish.toml")

    return read


def test_a_footprint_is_that_of_each_design(wish):
    """Where the ring is free, it is not that of the middle of its bounds."""
    text = WISH.replace('footprint = "60 mm"', 'footprint = "<= 60 mm"').replace(
        "[free]", '[free]\nfilm_radius = "20 mm:60 mm"'
    )
    problem = fronts.Problem(wish(text), 1)
    at = problem.names.index("film_radius")
    unit = np.full((2, len(problem.names)), 0.5)
    unit[:, at] = [0.05, 0.95]
    rows = problem.designs(unit)
    found = problem.found(rows, np.zeros((1, len(problem.wish.tolerances))))
    np.testing.assert_allclose(
        problem.margins(found)["footprint"][:, 0], np.minimum(2.0 * rows[:, at] / 0.06 - 1.0, 1.0)
    )
    assert wish(WISH).device.film_radius == pytest.approx(0.03)  # a size is twice the radius
    smallest = Objective("footprint", False)
    np.testing.assert_allclose(problem.objective(rows, found, np.zeros(2), smallest), 2.0 * rows[:, at])


def test_margins_are_signed_and_a_relaxed_requirement_is_weaker(wish):
    problem = fronts.Problem(wish(WISH), 1)
    unit = problem.designs(np.full((1, len(problem.names)), 0.5))
    found = problem.found(unit, np.zeros((1, len(problem.wish.tolerances))))
    margins = problem.margins(found)
    stroke, peak = (float(found.values[name][0, 0]) for name in ("stroke", "peak_voltage"))
    assert margins["stroke"][0, 0] == pytest.approx(1.0 - stroke / 5e-3)
    assert margins["peak_voltage"][0, 0] == pytest.approx(peak / 2e3 - 1.0)
    assert margins["hoop slack"][0, 0] == pytest.approx(min(peak / (0.8 * found.limits[1, 0, 0]) - 1.0, 1.0))
    weaker = replace(problem, relaxed="stroke").margins(found)
    assert weaker["stroke"][0, 0] == pytest.approx(1.0 - stroke / 4.5e-3)
    np.testing.assert_array_equal(weaker["hoop slack"], margins["hoop slack"])


def test_rows_that_another_beats_in_all_are_dominated():
    assert fronts.dominated(np.array([[1.0, 5.0], [2.0, 4.0], [2.0, 5.0], [3.0, 1.0]])).tolist() == [
        False,
        False,
        True,
        False,
    ]


NOTHING = fronts.Found({}, np.zeros(0), np.zeros(0))
"""What a replaced `examine` finds."""


def test_draws_change_fields_by_their_tolerances_under_a_drive_harder_by_the_margin(wish, monkeypatch):
    """Relative deviations in the logarithm, absolute ones over the value."""
    asked = []
    monkeypatch.setattr(
        fronts, "examine", lambda device, fields, share: asked.append((device, fields, share)) or NOTHING
    )
    problem = fronts.Problem(wish(WISH), 1)
    unit = np.array([[0.0] * len(problem.names), [0.5] * len(problem.names), [1.0] * len(problem.names)])
    rows = problem.designs(unit)
    bounds = np.array(list(problem.wish.free.values()))
    np.testing.assert_allclose(rows[[0, 2]], bounds.T)
    tolerances = problem.wish.tolerances
    normal = np.array([[0.0] * len(tolerances), [1.0] * len(tolerances)])
    problem.found(rows, normal)
    ((device, fields, share),) = asked
    assert share == pytest.approx(1.0 / (1.0 - problem.wish.margin), rel=1e-12)
    for name, deviation, relative in tolerances:
        values = np.broadcast_to(fields[name], (3, 2))
        usual = rows[:, problem.names.index(name)] if name in problem.names else np.full(3, float(device.get(name)))
        np.testing.assert_allclose(values[:, 0], usual)
        np.testing.assert_allclose(np.log(values[:, 1] / usual), deviation / (1.0 if relative else usual), rtol=1e-9)
    assert set(fields) == {*problem.names, *(one.name for one in tolerances)}


# --- a world of closed forms ------------------------------------------------------------------------------------------


def found_of(fields, scale=1.0):
    """Stroke in proportion to the voltage over the spring, limits at 2 kV and above, a power of both."""
    volts, spring = fields["voltage_amplitude"], fields["spring_rate"]
    values = {"stroke": 1e-5 * volts / spring, "peak_voltage": volts, "apparent_power": 1e-9 * volts**2 * spring}
    limits = np.array([(2000.0 + 500.0 * k) * np.ones_like(volts) for k in range(len(LIMITS))])
    return Found(values, limits, scale * volts / 3000.0 - 1.0)


@pytest.fixture
def small(wish, monkeypatch):
    """A problem with a spring and a voltage that are free, the spring uncertain by 10 %; and what was examined."""
    own = wish(WISH)
    monkeypatch.setattr(fronts, "examine", lambda device, fields, share: found_of(fields))
    own = replace(
        own, free={"spring_rate": (1.0, 100.0), "voltage_amplitude": (0.0, 2000.0)}, objectives=(POWER, PEAK),
        tolerances=(Tolerance("spring_rate", 0.1, True),), requirements=(Requirement("stroke", True, 1e-3),),
        samples=NO_SAMPLES,
    )  # fmt: skip
    return fronts.Problem(own, 64, 3)


def unit_of(spring, volts):
    return np.array([np.log(spring) / np.log(100.0), volts / 2000.0])


def test_bounds_of_a_large_ratio_are_searched_by_logarithm_and_others_evenly(small):
    wide = {"spring_rate": (1.0, 100.0), "voltage_offset": (0.0, 2000.0), "hoop_prestretch": (1.0, 2.0)}
    wide |= {"initial_height": (0.01, 0.03), "disc_radius": (0.004, 0.0121)}
    problem = replace(small, wish=replace(small.wish, free=wide))
    found = problem.designs(np.array([[0.0] * 5, [0.5] * 5, [1.0] * 5]))
    np.testing.assert_allclose(found[[0, 2]], np.array(list(wide.values())).T)
    np.testing.assert_allclose(found[1], [10.0, 1000.0, 1.5, 0.02, np.sqrt(0.004 * 0.0121)])
    assert fronts.fields_of(problem, np.array([0.123456] * 5))["voltage_offset"] == 246.9


def test_samples_move_fields_together_and_a_deviation_in_units_is_a_share_of_the_value(small, monkeypatch):
    asked = []
    monkeypatch.setattr(fronts, "examine", lambda device, fields, share: asked.append(fields) or NOTHING)
    root = np.array([[0.2, 0.0], [0.1, 0.3]])
    samples = Samples(("moving_mass", "spring_rate"), np.array([5e-3, 10.0]), root)
    tolerances = (Tolerance("voltage_amplitude", 30.0, False),)
    problem = replace(small, wish=replace(small.wish, samples=samples, tolerances=tolerances))
    problem.found(np.array([[20.0, 600.0]]), np.array([[0.0, 0.0, 0.0], [1.0, 1.0, -2.0]]))
    (fields,) = asked
    mass = float(problem.device.moving_mass)
    np.testing.assert_allclose(fields["voltage_amplitude"], [[600.0, 600.0 * np.exp(30.0 / 600.0)]])
    np.testing.assert_allclose(fields["moving_mass"], [[mass, mass * np.exp(0.2)]])
    np.testing.assert_allclose(fields["spring_rate"], [[20.0, 20.0 * np.exp(0.1 - 0.6)]])


def test_margins_are_to_the_limits_less_the_wished_margin_and_a_missing_number_misses(small):
    found = found_of({"voltage_amplitude": np.array([[1200.0]]), "spring_rate": np.array([[6.0]])})
    margins = replace(small, pull_in=0.9).margins(found)
    assert margins["stroke"][0, 0] == pytest.approx(1.0 - 2e-3 / 1e-3)
    for k, name in enumerate(LIMITS):
        assert margins[name][0, 0] == pytest.approx(1200.0 / (0.8 * 0.9 * (2000.0 + 500.0 * k)) - 1.0)
    assert margins["swing beyond the film's limits"][0, 0] == pytest.approx(-0.6)
    assert "swing beyond the film's limits" not in replace(small, draws=1).margins(found)
    relaxed = replace(small, relaxed="limits").margins(found)
    assert relaxed[LIMITS[0]][0, 0] == pytest.approx(1200.0 / (0.8 * 1.1 * 2000.0) - 1.0)
    most = replace(small.wish, requirements=(Requirement("apparent_power", False, 1e-3),))
    power = 1e-9 * 1200.0**2 * 6.0
    for name, bound in (("", 1e-3), ("apparent_power", 1.1e-3)):
        own = replace(small, wish=most, relaxed=name).margins(found)["apparent_power"][0, 0]
        assert own == pytest.approx(min(power / bound - 1.0, 1.0))
    lost = found._replace(values=found.values | {"stroke": np.array([[np.nan]])})
    assert small.margins(lost)["stroke"][0, 0] == 1.0
    far = found._replace(limits=0.01 * found.limits)
    assert small.margins(far)[LIMITS[0]][0, 0] == 1.0


def test_a_design_is_as_good_as_its_draws_at_the_wished_confidence_and_some_beyond(small):
    """The largest margin of each draw; with many draws a quantile, never beyond the last of few."""
    one, other = np.linspace(-1.0, 0.0, 101), np.where(np.arange(101) == 3, 0.7, -2.0)
    problem = replace(small, draws=101, extra=0.0, wish=replace(small.wish, confidence=0.9))
    worst = np.sort(np.maximum(one, other))
    found = problem.robust({"a": one[None], "b": other[None]})
    assert found[0] == pytest.approx(np.quantile(worst, 0.9))
    assert replace(problem, extra=0.05).robust({"a": one[None]})[0] == pytest.approx(-0.05)
    few = replace(problem, draws=5, extra=0.2).robust({"a": np.array([[0.0, 1.0, 2.0, 3.0, 4.0]])})
    assert few[0] == pytest.approx(4.0 * 0.9)
    assert replace(problem, draws=1).robust({"a": np.array([[0.3]]), "b": np.array([[-0.1]])})[0] == 0.3


def test_the_probability_is_the_share_of_new_draws_that_meet_all(small):
    """Of a stroke that a spring softer by 5 % would just have, which half a deviation is: 31 % are softer still. Levels
    and weaker requirements play no part."""
    unit = unit_of(10.0 * np.exp(0.05), 1000.0)
    share, low, high = fronts.probability_of(small, unit, 5)
    assert share == pytest.approx(0.3085, abs=2e-3)
    assert low < share < high
    assert high - low == pytest.approx(2.0 * 1.96 * np.sqrt(share * (1.0 - share) / 4096.0), rel=0.02)
    bounded = replace(small, levels=((PEAK, 1.0),), relaxed="stroke")
    assert fronts.probability_of(bounded, unit, 5) == (share, low, high)
    assert len({fronts.probability_of(small, unit, seed)[0] for seed in range(5, 9)}) > 1
    sure = fronts.probability_of(small, unit_of(5.0, 1000.0), 5)
    assert sure[0] == 1.0


def test_a_search_minimises_its_objective_below_levels_and_counts_what_misses_by_how_much(small):
    good, weak, hopeless = unit_of(5.0, 1000.0), unit_of(10.0, 1000.0), unit_of(90.0, 500.0)
    cube = np.array([good, weak, hopeless])
    found = small.fitness(cube, POWER)
    assert found[0] == pytest.approx(1e-9 * 1000.0**2 * 5.0)
    worst = small.robust(small.margins(small.found(small.designs(weak[None]), small.normal)))[0]
    assert found[1] == pytest.approx(fronts.MISSED * (1.0 + worst))
    assert worst > 0.0
    for spring, near in ((1e-5 * 1000.0 / 1e-3 / 0.71, True), (1e-5 * 1000.0 / 1e-3 / 0.69, False)):
        (own,) = small.fitness(unit_of(spring, 1000.0)[None], POWER)  # misses by less than 0.3 without tolerances
        assert (own < 2.0 * fronts.MISSED) == near
    assert found[2] == pytest.approx(fronts.WORSE * (1.0 + 1.0 - 1e-5 * 500.0 / 90.0 / 1e-3))
    assert small.fitness(cube, Objective("stroke", True))[0] == pytest.approx(-2e-3)
    assert small.fitness(cube, Objective("spring_rate", False))[0] == pytest.approx(5.0)
    assert small.fitness(cube, Objective("probability", True))[1] == pytest.approx(worst)
    level = replace(small, levels=((PEAK, 800.0),)).fitness(cube, POWER)
    assert level[0] == pytest.approx(fronts.MISSED * 1.25)
    assert replace(small, levels=((PEAK, 1001.0),)).fitness(cube, POWER)[0] == found[0]
    fixed = Objective("moving_mass", False)
    assert small.fitness(cube, fixed)[0] == pytest.approx(float(small.device.moving_mass))


@pytest.mark.parametrize(
    ("high", "low", "levels"),
    [
        (10.0, 1.0, np.geomspace(10.0, 1.02, 6)[1:]), (1.0, -5.0, np.linspace(1.0, -4.9, 6)[1:]), (-1.0, -1.01, []),
        (1.0, 1.0, []), (1.0, 0.99, []),
    ],
)  # fmt: skip
def test_levels_lie_between_both_ends_and_none_where_they_are_close(high, low, levels):
    np.testing.assert_allclose(fronts.levels_between(high, low), levels)


def test_what_binds_is_missed_first_and_weaker_it_leaves_a_better_objective(small, monkeypatch):
    unit = unit_of(8.0, 1000.0)
    assert fronts.binding_of(small, unit) == "stroke"
    assert fronts.binding_of(small, unit_of(2.0, 1500.0)) == LIMITS[0]
    asked = []

    def search(own, which, start, generations):
        asked.append((own.relaxed, which, start.shape, generations))
        return None, None, answers.pop(0)

    monkeypatch.setattr(fronts.Problem, "search", search)
    before = 1e-9 * 1000.0**2 * 8.0
    answers = [0.6 * before, 1.2 * before, 2.0 * fronts.MISSED, before]
    for share in (0.4, 0.0, 0.0):
        assert fronts.relaxation(small, unit, np.zeros((9, 2)), "stroke") == pytest.approx(share)
    fronts.relaxation(small, unit, np.zeros((9, 2)), LIMITS[2])
    assert [own for own, *_ in asked] == ["stroke"] * 3 + ["limits"]
    assert asked[0][1:] == (POWER, (10, 2), fronts.SHORT)
    rare = replace(small, wish=replace(small.wish, objectives=(Objective("probability", True),)))
    assert np.isnan(fronts.relaxation(rare, unit, np.zeros((9, 2)), "stroke"))


def test_where_no_design_holds_the_closest_says_which_bounds_it_lies_at(small):
    said = fronts.closest(small, unit_of(1.0, 2000.0))
    assert (
        "with a margin of 20 % at a confidence of 95 %; the closest: margin 0 %, stroke 20 mm; it is bound by" in said
    )
    assert said.endswith("lower spring_rate below 1 N/m or raise voltage_amplitude above 2 kV, or weaken a requirement")
    inside = fronts.closest(small, unit_of(10.0, 1500.0))
    assert "margin 25 %, stroke 1.5 mm" in inside
    assert inside.endswith("; widen the bounds, or weaken a requirement")


def test_a_population_has_the_best_in_front_and_a_quarter_of_a_further_search_is_new(small):
    population = np.arange(2.0 * fronts.POPULATION).reshape(-1, 2)
    found = fronts.with_best(population, np.array([-1.0, -2.0]))
    assert found.shape == population.shape
    np.testing.assert_array_equal(found[0], [-1.0, -2.0])
    np.testing.assert_array_equal(found[1:], population[:-1])
    again, new = small._population(population), small._population(None)
    kept = 3 * fronts.POPULATION // 4
    np.testing.assert_array_equal(again[:kept], population[:kept])
    np.testing.assert_array_equal(again[kept:], new[kept:])
    assert ((new >= 0.0) & (new <= 1.0)).all()


def test_a_search_reports_each_generation_and_finds_the_same(small):
    shares = []
    best, population, fitness = small.search(POWER, generations=4, progress=shares.append)
    assert shares == [0.25] * 4
    again = small.search(POWER, generations=4)
    np.testing.assert_array_equal(best, again[0])
    np.testing.assert_array_equal(population, again[1])
    assert fitness == again[2]


def test_the_front_leads_from_the_best_of_the_first_objective_to_that_of_the_second(small, monkeypatch):
    """Levels of the second between both, and with three objectives a bound on the middle one; no design is an error."""
    asked, shares = [], []

    def search(own, which, start=None, generations=fronts.GENERATIONS, progress=None):
        if progress is not None:
            progress(1.0)
        asked.append((own.levels, which, None if start is None else start.shape))
        return unit_of(5.0, 1000.0 if which == POWER else 600.0), np.zeros((fronts.POPULATION, 2)), fitness

    monkeypatch.setattr(fronts.Problem, "search", search)
    fitness = 0.5
    found = fronts.front(small.wish, 3, False, shares.append)
    assert len(found) == fronts.ROWS
    assert sum(shares) == pytest.approx(1.0)
    assert [which for _, which, _ in asked] == [POWER, PEAK] + [POWER] * (fronts.ROWS - 1)
    levels = [level for (((_, level),), *_) in asked[2:]]
    np.testing.assert_allclose(levels, fronts.levels_between(1000.0, 600.0))
    asked.clear()
    three = replace(small.wish, objectives=(POWER, Objective("spring_rate", False), PEAK))
    fronts.front(three, 3, False, None)
    assert [objective for objective, _ in asked[-1][0]] == [PEAK, Objective("spring_rate", False)]
    assert asked[-1][0][1][1] == pytest.approx(5.0)
    assert len(fronts.front(replace(small.wish, objectives=(POWER,)), 3, True, None)) == 1
    fitness = 2.0 * fronts.MISSED
    with pytest.raises(InputError, match="no design within the bounds meets all"):
        fronts.front(small.wish, 3, False, None)

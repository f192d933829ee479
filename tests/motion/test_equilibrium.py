"""Statics: every equilibrium found, folds and pitchforks where theory has them, pull-in as a slow ramp sees it."""

import json

import numpy as np
import pytest
import xarray as xr

import gelcone
from gelcone import (
    ConeModel,
    InputError,
    PullIn,
    fold_voltages,
    load,
    model_of,
    pull_in_voltage,
    save,
    static,
    stroke_and_blocked_force,
)
from gelcone.motion import equilibrium as module
from gelcone.motion.validity import invalid
from gelcone.physics.statics import every_balance
from gelcone.plots.equilibrium import static_figure
from tests.motion.balances import MODEL, SOFTENING, TABLE1, Balance, random_model
from tests.recorded import record


def sign_changes(model, voltage, x):
    """Places where the force changes sign between reachable points, and whether it rises there."""
    force = model.force(x, voltage)
    i = np.flatnonzero((np.sign(force[:-1]) * np.sign(force[1:]) < 0) & np.isfinite(force[:-1] + force[1:]))
    return x[i], force[i] < 0.0


def test_the_papers_static_case_is_bistable_at_the_highest_voltage():
    result = static(TABLE1, [0.0, 1.0, 1.5])
    assert result.equilibria.values.tolist() == [1, 1, 3]
    place, slope = result.equilibrium_displacement.values, result.slope.values
    assert place[0, 0] == place[1, 0] == place[2, 1] == 0.0
    assert np.sign(slope[2]).tolist() == [1.0, -1.0, 1.0]
    assert result.stable.values[2].tolist() == [True, False, True]
    assert place[2, 2] == -place[2, 0] == pytest.approx(0.98583217, abs=1e-8)
    np.testing.assert_allclose(TABLE1.force(place[2], 1.5), 0.0, atol=1e-14)
    np.testing.assert_allclose(TABLE1.stiffness(place[2], 1.5), slope[2], rtol=1e-12)
    assert np.isnan(place[:2, 1:]).all()


@pytest.mark.parametrize("seed", range(25))
def test_no_equilibrium_is_missed_or_made_up(seed):
    rng = np.random.default_rng(seed)
    model = random_model(rng)
    x = np.linspace(-30.0, 30.0, 200_001) + 1e-7
    result = static(model, rng.uniform(0.0, 2.5, 3))
    for k, voltage in enumerate(result.constant_voltage.values):
        expected, rising = sign_changes(model, voltage, x)
        place, stable = result.equilibrium_displacement.values[k], result.stable.values[k]
        within = np.abs(place) < 30.0
        np.testing.assert_allclose(place[within], expected, atol=3.1e-4)
        assert stable[within].tolist() == rising.tolist()


def test_equilibria_near_the_stretch_limit_are_found():
    """At v = 100 the film is held at 1e-4 of its limit from it."""
    result = static(ConeModel(stretch_limit=1.0), [100.0])
    outer = float(result.equilibrium_displacement[0, 2])
    assert 0.0 < 1.0 - TABLE1.replace(stretch_limit=1.0).strain(outer) < 2e-4
    assert bool(result.stable[0, 2])


def test_without_a_stretch_limit_there_is_no_equilibrium_beyond_the_highest_secant_stiffness():
    """Neo-Hookean: w(x) = kappa + 1 - 1/q^2 < kappa + 1, so that only the flat film is left, unstably."""
    flat = ConeModel(law="neo-hookean", spring_stiffness=1.5)
    q = 1.0 / np.sqrt(2.5 - 1.5**2)
    result = static(flat, [1.5, 1.6])
    assert result.equilibria.values.tolist() == [3, 1]
    assert float(result.equilibrium_displacement[0, 2]) == pytest.approx(np.sqrt(q - 1.0), rel=1e-14)
    assert not result.stable[1].any()


def test_exactly_on_a_fold_two_equilibria_are_one_and_unstable():
    folds = fold_voltages(SOFTENING)
    voltage, place = folds.fold_voltage.values, folds.fold_displacement.values
    at = static(SOFTENING, voltage)
    above, below = (static(SOFTENING, voltage * (1.0 + change)) for change in (1e-9, -1e-9))
    for k in range(len(voltage)):
        i = np.flatnonzero(at.equilibrium_displacement.values[k] == place[k])
        assert i.size == 1
        assert not at.stable.values[k, i[0]]
        assert {int(above.equilibria[k]) - int(at.equilibria[k]), int(below.equilibria[k]) - int(at.equilibria[k])} == {
            -1,
            1,
        }


def test_exactly_on_a_pitchfork_the_flat_film_is_the_only_equilibrium():
    result = static(TABLE1, [np.sqrt(1.5)])
    assert result.equilibria.values.tolist() == [1]
    assert bool(result.stable[0, 0])


def test_a_film_that_is_only_within_its_limit_when_lifted_has_no_flat_equilibrium():
    model = ConeModel(prestretch=0.4, stretch_limit=3.0)
    result = static(model, [0.5])
    assert np.isnan(model.strain_limit() - 3.0) or model.strain(0.0) > 3.0
    assert result.equilibria.values.tolist() == [2]
    assert result.stable.values.tolist() == [[True, True]]
    assert np.isnan(result.force.sel(displacement=0.0, method="nearest")).all()


def test_forces_are_the_models_and_nan_beyond_the_limit():
    x = np.array([-8.0, -1.0, 0.0, 0.5, 8.0])
    result = static(TABLE1, [0.0, 1.2], x)
    for k, voltage in enumerate([0.0, 1.2]):
        np.testing.assert_allclose(result.force[k, 1:4], TABLE1.force(x[1:4], voltage), rtol=1e-14)
        np.testing.assert_allclose(result.stiffness[k, 1:4], TABLE1.stiffness(x[1:4], voltage), rtol=1e-14)
    assert np.isnan(result.force.values[:, [0, 4]]).all()


@pytest.mark.parametrize("model", [SOFTENING, SOFTENING.replace(rest_height=0.0), ConeModel(spring_stiffness=1.5)])
def test_branches_are_equilibria_and_change_stability_at_the_folds_only(model):
    """Raised and flat films: the slope is that of the force at each point, of the flat branch, too."""
    result = static(model, [0.0, 1.5])
    x, voltage, slope = (result[f"branch_{n}"].values for n in ("displacement", "voltage", "slope"))
    on = np.isfinite(x)
    np.testing.assert_allclose([model.force(a, v) for a, v in zip(x[on], voltage[on], strict=True)], 0.0, atol=1e-8)
    stiffness = [model.stiffness(a, v) for a, v in zip(x[on], voltage[on], strict=True)]
    np.testing.assert_allclose(slope[on], stiffness, atol=1e-7 * np.abs(stiffness).max())
    folds = result.fold_displacement.values
    assert set(folds[np.isfinite(folds)]) <= set(x[slope == 0.0])


def test_a_lifted_wrinkling_film_has_its_equilibrium_at_every_voltage_up_to_pull_in():
    """One equilibrium: film and spring add up to no force; the branch passes through it and ends before the pull-in."""
    model = ConeModel(
        film="wrinkling",
        meridional_prestretch=1.1,
        hoop_prestretch=1.4,
        spring_stiffness=1.68,
        rest_height=0.91,
        stretch_limit=50.0,
    )
    lost = float(pull_in_voltage(model).pull_in_voltage)
    levels = lost * np.array([0.0, 0.5, 0.6, 0.7, 0.9, 0.999, 1.001])
    result = static(model, levels)
    assert result.equilibria.values.tolist() == [1, 1, 1, 1, 1, 1, 0]
    place = result.equilibrium_displacement.values[:-1, 0]
    film = model.system.film.force(place, levels[:-1] ** 2, [], model.own_numbers)[0]
    np.testing.assert_allclose(film + 1.68 * (place - 0.91), 0.0, atol=1e-14)
    assert result.stable.values[:-1, 0].all()
    assert (np.diff(place) > 0.0).all()
    np.testing.assert_allclose(stroke_and_blocked_force(model, levels[:-1]).displacement, place, rtol=1e-14)
    x, voltage = result.branch_displacement.values, result.branch_voltage.values
    on = np.isfinite(voltage)
    assert 0.98 * lost < voltage[on].max() < lost
    film = model.system.film.force(x[on], voltage[on] ** 2, [], model.own_numbers)[0]
    np.testing.assert_allclose(film + 1.68 * (x[on] - 0.91), 0.0, atol=1e-14)


@pytest.mark.parametrize("analysis", [static, stroke_and_blocked_force])
def test_an_ensemble_is_its_members(analysis):
    model = ConeModel(rest_height=[[0.0, 0.1]], spring_stiffness=[[0.5], [1.5]])
    together = analysis(model, [0.0, 1.4])
    x = {"displacements": together.displacement.values} if analysis is static else {}
    for i, j in np.ndindex(2, 2):
        alone = analysis(model.take(2 * i + j), [0.0, 1.4], **x)
        for name in set(alone) - {n for n in alone if "branch" in str(n)}:
            ours, theirs = alone[name].values, together[name][i, j].values
            kept = tuple(slice(n) for n in ours.shape)
            np.testing.assert_array_equal(theirs[kept], ours)


def test_a_member_beyond_its_limit_is_outside_and_leaves_the_rest_alone():
    model = ConeModel(prestretch=[0.2, 1.0], stretch_limit=2.0)
    result = static(model, [0.5])
    assert result.outcome.values.tolist() == [1, 0]
    assert result.equilibria.values.tolist() == [[0], [1]]
    assert np.isnan(result.force[0]).all()


def test_results_are_written_and_read_back_equal(tmp_path):
    for name, result in {
        "static": static(SOFTENING, [0.0, 1.4]),
        "pull_in": pull_in_voltage(SOFTENING),
        "stroke": stroke_and_blocked_force(ConeModel(rest_height=[0.0, 0.1]), [0.0, 1.0]),
    }.items():
        save(result, tmp_path / f"{name}.nc")
        back = load(tmp_path / f"{name}.nc")
        xr.testing.assert_identical(back, result)
        assert model_of(back).shape == model_of(result).shape


def test_the_figure_tells_stable_from_unstable():
    figure = static_figure(static(TABLE1, [0.0, 1.0, 1.5]))
    force, branches = figure.axes
    dots = [line for line in force.lines if line.get_marker() == "o"]
    filled = [len(d.get_xdata()) for d in dots if d.get_markerfacecolor() != "white"]
    opened = [len(d.get_xdata()) for d in dots if d.get_markerfacecolor() == "white"]
    assert (filled, opened) == ([1, 1, 2], [0, 0, 1])
    dashed = [line for line in branches.lines if line.get_linestyle() == "--" and np.isfinite(line.get_ydata()).any()]
    (unstable,) = dashed
    drawn = np.isfinite(unstable.get_ydata())
    assert drawn.sum() >= 2
    assert (unstable.get_ydata()[drawn] == 0.0).all()
    assert unstable.get_xdata()[drawn].min() == pytest.approx(np.sqrt(1.5))


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda: static(TABLE1, [-1.0]), "voltages = -1: must be at least 0"),
        (lambda: static(TABLE1, []), "voltages = .*empty"),
        (lambda: static(TABLE1, [np.nan]), "voltages = nan"),
        (lambda: static(TABLE1, [[0.0, 1.0]]), r"shape \(1, 2\)"),
        (lambda: static(TABLE1, [0.0], [1.0, 0.0]), "increasing"),
        (lambda: static(TABLE1, [0.0], [np.inf]), "finite"),
        (lambda: static(TABLE1, [0.0], [30.0, 40.0]), r"none is reached; stay within 7\.\d"),
        (lambda: static(ConeModel(prestretch=0.2, stretch_limit=1.0), [0.0]), "stretch_limit = 1: must exceed"),
        (lambda: pull_in_voltage(TABLE1, start=np.nan), "start = nan: must be finite"),
        (lambda: pull_in_voltage(TABLE1, start=[0.0, 1.0]), "start = "),
    ],
)
def test_bad_input_is_refused_with_the_bound_and_the_remedy(call, message):
    with pytest.raises(InputError, match=message):
        call()


def test_by_default_the_voltages_are_the_offset_and_the_peak_of_the_drive():
    model = ConeModel(voltage=0.3, voltage_bias=-0.2, rest_height=0.3)
    assert static(model)["constant_voltage"].values == pytest.approx([0.2, 0.5], rel=1e-15)
    assert static(model.replace(voltage_bias=0.0))["constant_voltage"].values.tolist() == [0.3]


def test_forces_and_branches_reach_past_all_that_happens():
    """Forces are sampled beyond the height at which the spring is free, branches reach beyond pitchforks and folds."""
    for height in (2.0, -2.0):
        lifted = static(ConeModel(spring_stiffness=0.05, rest_height=height), 0.1)
        assert float(np.abs(lifted["displacement"]).max()) > 2.0
    flat = static(ConeModel(), 0.1)
    assert float(flat["branch_voltage"].max()) > 1.2 * float(flat["pitchfork_voltage"])


CREEPING = {"material.viscous_modulus_1": "4 kPa", "material.relaxation_time_1": "2 s"}


@pytest.mark.parametrize("film", ["taut", "wrinkling"])
def test_statics_at_once_are_those_of_a_fast_step(film):
    """The elastic film's, stiffer by its branches; without branches, its own."""
    device = gelcone.find_device("biased-pump").replace({"film": film, **CREEPING})
    levels = ["0 V", "1 kV"]
    slow, fast = (gelcone.static(device, levels, at_once=at_once) for at_once in (False, True))
    assert float(fast["rest_displacement"]) == pytest.approx(float(slow["rest_displacement"]), rel=1e-12)
    assert float(fast["blocked_force"][1]) == pytest.approx(float(slow["blocked_force"][1]), rel=1e-9)
    assert 0.5 * float(slow["stroke"][1]) < float(fast["stroke"][1]) < 0.95 * float(slow["stroke"][1])
    held = gelcone.creep(device, levels[1:], tolerance=1e-7, duration="1 ms") if film == "taut" else None
    place = fast["equilibrium_displacement"][1].dropna("equilibrium").values
    assert held is None or np.abs(place - float(held["initial_displacement"][0])).min() < 1e-12
    films = [float(found["stiffness"].max()) - device.spring_rate for found in (slow, fast)]
    assert 1.2 * films[0] < films[1] < 1.5 * films[0]
    elastic = gelcone.find_device("biased-pump").replace(film=film)
    one, other = (gelcone.static(elastic, levels, at_once=at_once) for at_once in (False, True))
    xr.testing.assert_equal(one, other)


def test_limits_at_once_are_those_of_creep():
    device = gelcone.find_device("biased-pump").replace({"film": "wrinkling", **CREEPING})
    slow, fast = (float(gelcone.limits(device, at_once=at_once)["pull_in_voltage"]) for at_once in (False, True))
    assert 1.02 * slow < fast < 1.2 * slow


def test_both_films_of_a_double_cone_are_stiff_at_once():
    given = {"second_film": "taut", "viscous_modulus_1": 0.5, "second_viscous_modulus_1": 0.5, "rest_height": 0.3}
    model = ConeModel(prestretch=1.3, second_flat_height=0.4, **given)
    slow, fast = (gelcone.static(model, [0.0], [0.1, 0.3], at_once=at_once) for at_once in (False, True))
    held = fast["stiffness"][0] - slow["stiffness"][0]
    x = np.array([0.1, 0.3])

    def pull(x):  # of a branch rested on the flat film
        return 0.5 * x * (1.0 - 1.0 / (1.0 + x * x) ** 2)

    near = 1e-6
    more = [(pull(at + near) - pull(at - near)) / (2.0 * near) for at in (x, 0.4 - x)]
    np.testing.assert_allclose(held, more[0] + more[1], rtol=1e-6)


def test_each_equilibrium_has_the_state_of_its_film_and_one_that_is_not_there_has_none():
    model = gelcone.ConeModel(
        film="wrinkling", prestretch=1.2, spring_stiffness=0.3, rest_height=0.1, stretch_limit=50.0
    )
    levels = np.array([0.0, 0.5, 0.9, 1.1])
    found = gelcone.static(model, levels)
    place, states = found["equilibrium_displacement"].values, found["film_state"].values
    missing = np.isnan(place)
    assert missing.any()
    assert (states[missing] == -1).all()
    for name in ("hoop_slack", "meridional_slack", "near_limit", "pulled_in"):
        np.testing.assert_array_equal(np.isnan(found[f"validity_{name}"].values), missing)
    n = model.own_numbers
    for k, v in enumerate(levels):
        there = ~missing[k]
        np.testing.assert_array_equal(states[k][there], model.film.state(place[k][there], v, [], n).kind)


@pytest.mark.parametrize("film", ["taut", "wrinkling"])
def test_a_branch_fails_where_equilibria_at_its_voltages_do(film):
    """Slack, breakdown, the stretch limit, a membrane that has pulled in, and jumps."""
    model = ConeModel(
        film=film, rest_height=0.8, hoop_prestretch=1.3, spring_stiffness=1.3, stretch_limit=20.0,
        dielectric_strength=1.2, radius_ratio=0.25,
    )  # fmt: skip
    branches = gelcone.static(model, [0.1])
    volts, place, fails = (branches[f"branch_{name}"].values for name in ("voltage", "displacement", "fails"))
    points = np.flatnonzero(np.isfinite(volts))[::9]
    assert 0.0 < fails[points].mean() < 1.0
    levels, back = np.unique(volts[points], return_inverse=True)
    found = gelcone.static(model, levels)
    where, at = invalid(found).values, found["equilibrium_displacement"].values
    for point, level in zip(points, back, strict=True):
        nearest = np.nanargmin(np.abs(at[level] - place[point]))
        assert at[level, nearest] == pytest.approx(place[point], abs=1e-6)
        assert where[level, nearest] == fails[point]


@pytest.mark.parametrize("at_once", [False, True])
def test_the_statics_hold_what_the_balances_give(monkeypatch, balances, at_once):
    """At once they are those of the films before they creep, whose states decide on validity, too."""
    fast = MODEL.replace(rest_height=0.125)
    asked = record(
        monkeypatch, module, films_at_once=fast, _with_validity=lambda result, members, balances, levels, place: result
    )
    x, shares = np.array([-1.0, 0.5, 1.75]), []
    found = module.static(MODEL, [0.5, 1.0], x, at_once=at_once, progress=shares.append)
    held = fast if at_once else MODEL
    assert [model for model, *_ in balances] == [held]
    assert asked["films_at_once"] == ([{"model": MODEL, "states": None}] if at_once else [])
    (validity,) = asked["_with_validity"]
    np.testing.assert_array_equal(
        validity["members"].number("rest_height"), np.ravel(held.members().number("rest_height"))
    )
    np.testing.assert_array_equal(validity["levels"], [0.5, 1.0])
    np.testing.assert_array_equal(validity["place"], found["equilibrium_displacement"])
    at, squared = np.array([1.0, 2.0])[:, None, None], np.array([0.25, 1.0])[:, None]
    beyond = np.array([False, False, True])
    np.testing.assert_array_equal(found["force"], np.where(beyond, np.nan, at + 3.0 * x + squared))
    np.testing.assert_array_equal(found["stiffness"], np.where(beyond, np.nan, at + 4.0 * x - squared))
    assert found["equilibria"].values.tolist() == [[1, 2]] * 2
    nan = np.nan
    np.testing.assert_array_equal(
        found["equilibrium_displacement"], [[[1.25, nan], [2.0, 3.0]], [[2.25, nan], [3.0, 4.0]]]
    )
    np.testing.assert_array_equal(found["slope"], [[[1.0, nan], [1.0, 2.0]]] * 2)
    assert found["stable"].values.tolist() == [[[True, False], [True, False]]] * 2
    each = {
        "pitchfork_voltage": [0.5, 1.0], "pitchfork_displacement": [0.75, 0.75],
        "fold_voltage": [[0.3], [0.6]], "fold_displacement": [[6.0], [7.0]],
        "pull_in_voltage": [0.625, 1.25], "pull_in_kind": [PullIn.FOLD] * 2, "pull_in_from": [8.5, 9.0],
        "pull_in_to": [9.5, 10.0],
        "rest_displacement": [0.5, 1.0], "stroke": [[0.25, 1.0]] * 2, "blocked_force": [[0.125, 0.5], [0.25, 1.0]],
    }  # fmt: skip
    for name, values in each.items():
        np.testing.assert_array_equal(found[name], values, name)
    reach = 1.875  # over the largest of the events and 1.2 times the highest level
    np.testing.assert_array_equal(found["branch_displacement"], [[nan, 1.0, nan], [nan, 2.0, nan]])
    np.testing.assert_array_equal(found["branch_voltage"], [[nan, reach, nan]] * 2)
    np.testing.assert_array_equal(found["branch_slope"], [[nan, 8.0, nan], [nan, 9.0, nan]])
    assert sum(shares) == pytest.approx(1.0)
    assert max(shares) < 0.5
    options = json.loads(found.attrs["options"])
    assert (options["voltages"], options["displacements"], options["at_once"]) == ([0.5, 1.0], x.tolist(), at_once)


def test_branches_reach_a_fifth_beyond_the_highest_voltage_and_half_beyond_the_last_event():
    balances, levels = [Balance(1.0), Balance(2.0)], np.array([0.1, 4.0])
    folds = [[(0.3, 1.0)], [(0.6, 2.0)]]
    assert module._branch_limit(balances, levels, folds, np.array([0.5, np.inf])) == pytest.approx(4.8)
    assert module._branch_limit(balances, levels[:1], folds, np.array([0.5, np.nan])) == pytest.approx(1.5 * 1.0)
    assert module._branch_limit(balances, levels[:1], [[(7.0, 0.0)], []], np.array([0.5])) == pytest.approx(10.5)
    assert module._branch_limit([Balance(0.0)], 0.0 * levels, [[]], np.array([0.0])) == 1e-3


def test_branches_reach_beyond_a_pitchfork_at_a_low_voltage():
    """A weak spring holds the flat film up to its square root."""
    found = gelcone.static(ConeModel(spring_stiffness=0.04), [0.0])
    assert float(found["pitchfork_voltage"]) == pytest.approx(0.2)
    assert float(found["branch_voltage"].max()) == pytest.approx(0.3, rel=1e-3)
    assert (abs(found["branch_displacement"].values[found["branch_voltage"].values > 0.25]) > 0.1).any()


def test_what_fails_at_equilibria_is_what_fails_of_the_films_there(monkeypatch):
    """A disc has pulled in beyond the displacement and above the voltage at which a ramp jumps."""
    levels, place = np.array([0.4, 0.6]), np.array([[[0.2, np.nan], [0.7, 0.3]]] * 3)
    dims, along = ("member", "constant_voltage", "equilibrium"), ("member", "branch_point")
    result = xr.Dataset(
        {
            "slope": (dims, place), "pull_in_voltage": ("member", [0.5, np.inf, 0.65]), "pull_in_from": ("member",
            [-0.5, np.nan, -0.5]), "branch_displacement": (along, [[0.2, 0.7, np.nan]] * 3),
            "branch_voltage": (along, [[0.45, 0.55, np.nan]] * 3),
        }
    )  # fmt: skip

    def fails(members, motion, voltages, states):
        """True of each first point."""
        return {"hoop_slack": np.arange(motion[..., 0].size).reshape(motion.shape[:-1]) % 2 == 0}

    asked = record(monkeypatch, module, outside=fails)
    members = ConeModel(damping_ratio=[0.1, 0.2, 0.3]).members()
    found = module._with_validity(result, members, every_balance(members), levels, place)
    np.testing.assert_array_equal(found["validity_hoop_slack"], [[[1.0, np.nan], [1.0, 0.0]]] * 3)
    assert np.isnan(found["validity_breakdown"]).all()
    pulled = [[[0.0, np.nan], [1.0, 0.0]], *[[[0.0, np.nan], [0.0, 0.0]]] * 2]
    np.testing.assert_array_equal(found["validity_pulled_in"], pulled)
    call, of_branches = asked["outside"]
    np.testing.assert_array_equal(of_branches["motion"][..., 0], result["branch_displacement"])
    np.testing.assert_array_equal(of_branches["voltages"][0][:, :2], [[0.45, 0.55]] * 3)
    np.testing.assert_array_equal(found["branch_fails"][0, :2], [True, True])  # the second has pulled in
    np.testing.assert_array_equal(found["branch_fails"][1, :2], [False, True])
    assert not found["branch_fails"][:, 2].any()  # a gap
    np.testing.assert_array_equal(call["motion"], place.reshape(3, 4, 1))
    np.testing.assert_array_equal(call["voltages"][0], [[0.4, 0.4, 0.6, 0.6]] * 3)


def test_displacements_that_none_reaches_are_refused_with_the_farthest_that_one_does(balances):
    far, near = Balance(1.0), Balance(1.0)
    far.highest, near.highest = 3.0, 2.0
    for one in (far, near):
        one.inside = lambda x: np.zeros(x.shape, dtype=bool)
    with pytest.raises(InputError, match="stay within 3"):
        module._wanted([5.0, 6.0], [near, far])


@pytest.mark.parametrize(("drive", "second"), [("opposite", [0.6, 0.3]), ("constant", [0.4, 0.4]), ("same", None)])
def test_of_two_films_with_voltages_of_their_own_it_states_that_of_the_second(drive, second):
    own = {"second_voltage": 0.4} if drive == "constant" else {}
    model = ConeModel(rest_height=0.8, hoop_prestretch=1.4, spring_stiffness=1.5, voltage_bias=-0.3, voltage=0.2)
    model = model.replace(second_film="taut", second_drive=drive, second_flat_height=1.4, **own)
    found = static(model, [0.0, 0.3])
    assert "film_voltage" not in found  # it is the commanded one
    assert found.get("ramp_begin_voltage") == (0.3 if drive == "opposite" else None)
    volts = found.get("second_film_voltage")
    assert (volts is None) == (second is None)
    if volts is not None:
        np.testing.assert_allclose(volts[:, 0], second)

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
    integrate,
    load,
    model_of,
    pitchfork_voltage,
    pull_in_voltage,
    save,
    static,
    stroke_and_blocked_force,
)
from gelcone.motion import equilibrium as module
from gelcone.physics.balance import Equilibrium, Loss
from gelcone.plots.equilibrium import static_figure
from tests.recorded import record

TABLE1 = ConeModel(spring_stiffness=1.5, stretch_limit=50.0)
# Softens and then stiffens: folds on both sides, and a jump on the ramp.
SOFTENING = ConeModel(law="yeoh", **{"yeoh_c2": -0.2, "yeoh_c3": 0.02}, spring_stiffness=1.5, rest_height=0.1)


def random_model(rng):
    law = rng.choice(["gent", "yeoh", "neo-hookean"])
    own = {
        "gent": {"stretch_limit": 10.0 ** rng.uniform(-0.3, 2.0)},
        "yeoh": {"yeoh_c2": rng.normal(0.0, 0.5), "yeoh_c3": rng.normal(0.0, 0.1)},
        "neo-hookean": {},
    }[law]
    return ConeModel.from_parameters(
        {
            "law": law,
            "spring_stiffness": rng.uniform(0.0, 3.0),
            "rest_height": rng.choice([0.0, rng.normal(0.0, 0.3)]),
            "prestretch": rng.uniform(0.7, 1.4),
            "prestretch_mode": rng.choice(["radial", "equibiaxial"]),
            **own,
        }
    )


def sign_changes(model, voltage, x):
    """Places where the force changes sign between reachable points, and whether it rises there."""
    force = model.force(x, voltage)
    i = np.flatnonzero((np.sign(force[:-1]) * np.sign(force[1:]) < 0) & np.isfinite(force[:-1] + force[1:]))
    return x[i], force[i] < 0.0


# --- equilibria ---------------------------------------------------------------------------------------------------


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


# --- force, branches ----------------------------------------------------------------------------------------------


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


# --- pitchfork and folds ------------------------------------------------------------------------------------------


def test_the_pitchfork_is_the_root_of_the_small_signal_stiffness():
    assert pitchfork_voltage(TABLE1) == np.sqrt(1.5)
    model = ConeModel(prestretch=[0.9, 1.0, 1.3], spring_stiffness=1.0, prestretch_mode="equibiaxial")
    A = B = np.array([0.9, 1.0, 1.3]) ** 2
    G = 1.0 / (A * B)
    expected = np.sqrt(1.0 + (A - G) / (1.0 - (A + B + G - 3.0) / 50.0))
    np.testing.assert_allclose(pitchfork_voltage(model), expected, rtol=1e-14)
    np.testing.assert_allclose(static(model, [0.0]).pitchfork_voltage, expected, rtol=1e-14)


@pytest.mark.parametrize(
    "changes", [{"rest_height": 0.1}, {"prestretch": 0.6, "spring_stiffness": 0.1}, {"stretch_limit": 0.1}]
)
def test_there_is_no_pitchfork_without_a_stable_flat_film(changes):
    model = ConeModel(prestretch=1.3).replace(**changes) if "stretch_limit" in changes else TABLE1.replace(**changes)
    assert np.isnan(pitchfork_voltage(model))


@pytest.mark.parametrize("seed", range(12))
def test_folds_are_the_extrema_of_the_voltage_along_the_equilibria(seed):
    """v^2 = force without voltage over displacement: its extrema on a fine grid, by brute force."""
    model = random_model(np.random.default_rng(100 + seed))
    model = model.replace(rest_height=0.2) if seed % 2 else model
    folds = fold_voltages(model)
    found = np.sort(folds.fold_displacement.values[np.abs(folds.fold_displacement.values) < 20.0])
    expected = []
    for side in (-1.0, 1.0):
        x = side * np.linspace(0.02, 20.0, 400_001)
        w = model.force(x) / x
        rising = np.sign(np.diff(w))
        turn = 1 + np.flatnonzero(rising[:-1] * rising[1:] < 0)
        expected += [a for a, v in zip(x[turn], w[turn], strict=True) if v >= 0.0]
    np.testing.assert_allclose(found[np.abs(found) > 0.02], np.sort(expected), atol=2e-3)
    np.testing.assert_allclose(
        folds.fold_voltage**2, model.force(folds.fold_displacement.values) / folds.fold_displacement, atol=1e-10
    )


# --- pull-in ------------------------------------------------------------------------------------------------------


def settled(model, voltages, start):
    """A slow ramp by the equation of motion: let come to rest at each constant voltage, from the last state."""
    states = [np.array([start, 0.0])]
    for voltage in voltages:
        held = model.replace(voltage=0.0, voltage_bias=voltage, damping_ratio=0.7, drive_frequency=1.0)
        states.append(integrate(held, states[-1] + [1e-7, 0.0], [500.0]).states[0, -1])
    return np.array(states[1:])[:, 0]


def test_pull_in_in_a_fold_is_where_a_slow_ramp_jumps_and_to_where():
    result = pull_in_voltage(SOFTENING)
    assert PullIn(int(result.pull_in_kind)) == PullIn.FOLD
    voltage = float(result.pull_in_voltage)
    ramp = np.append(np.linspace(0.5, 0.99, 4), 1.01) * voltage
    place = settled(SOFTENING, ramp, float(result.rest_displacement))
    expected = stroke_and_blocked_force(SOFTENING, ramp)
    np.testing.assert_allclose(place, expected.displacement, atol=1e-6)
    assert expected.losses.values.tolist() == [0, 0, 0, 0, 1]
    assert place[-2] < float(result.pull_in_from) < float(result.pull_in_to) < place[-1]
    assert SOFTENING.force(float(result.pull_in_to), voltage) == pytest.approx(0.0, abs=1e-10)


def test_a_slow_ramp_leaves_the_flat_film_gradually_in_a_pitchfork_which_is_no_pull_in():
    result, voltage = pull_in_voltage(TABLE1), float(pitchfork_voltage(TABLE1))
    assert PullIn(int(result.pull_in_kind)) == PullIn.NEVER
    assert (voltage, float(result.pull_in_voltage)) == (np.sqrt(1.5), np.inf)
    ramp = np.array([0.9, 0.99, 1.06, 1.2]) * voltage
    place = settled(TABLE1, ramp, 0.0)
    np.testing.assert_allclose(place, stroke_and_blocked_force(TABLE1, ramp).displacement, atol=1e-6)
    assert (np.abs(place[:2]) < 1e-6).all()
    assert (place[2:] > 0.1).all()


def test_a_subcritical_pitchfork_jumps():
    model = SOFTENING.replace(
        rest_height=0.0, yeoh_c2=-0.25, yeoh_c3=0.03, prestretch=1.5, prestretch_mode="equibiaxial"
    )
    result = pull_in_voltage(model)
    assert PullIn(int(result.pull_in_kind)) == PullIn.PITCHFORK
    assert float(result.pull_in_voltage) == pitchfork_voltage(model)
    voltage = float(result.pull_in_voltage)
    assert float(result.pull_in_to) > 0.9
    jumped = settled(model, [1.03 * voltage], 0.0)
    np.testing.assert_allclose(jumped, stroke_and_blocked_force(model, 1.03 * voltage).displacement, atol=1e-6)
    assert model.force(float(result.pull_in_to), float(result.pull_in_voltage)) == pytest.approx(0.0, abs=1e-10)


def test_a_lifted_gent_film_never_pulls_in_and_an_unlimited_one_runs_away():
    lifted = pull_in_voltage(TABLE1.replace(rest_height=0.1))
    assert PullIn(int(lifted.pull_in_kind)) == PullIn.NEVER
    assert float(lifted.pull_in_voltage) == np.inf
    away = pull_in_voltage(ConeModel(law="neo-hookean", spring_stiffness=1.5, rest_height=0.1))
    assert PullIn(int(away.pull_in_kind)) == PullIn.SEARCH_RANGE
    assert float(away.pull_in_voltage) == pytest.approx(np.sqrt(2.5), rel=1e-4)
    assert float(away.pull_in_to) == np.inf


def test_a_film_that_is_unstable_when_flat_starts_from_the_side_asked_for():
    buckled = TABLE1.replace(prestretch=0.6, spring_stiffness=0.1)
    up, down = (pull_in_voltage(buckled, start=side) for side in (0.5, -0.5))
    assert float(up.rest_displacement) == -float(down.rest_displacement) > 0.0
    assert float(pull_in_voltage(buckled).rest_displacement) == float(up.rest_displacement)


def test_stroke_and_blocked_force_are_those_of_the_rest_position():
    model = TABLE1.replace(rest_height=0.1)
    voltages = np.array([0.0, 0.5, 1.0])
    result = stroke_and_blocked_force(model, voltages)
    rest = float(result.rest_displacement)
    assert model.force(rest) == pytest.approx(0.0, abs=1e-15)
    np.testing.assert_allclose(result.blocked_force, [-model.force(rest, v) for v in voltages], atol=1e-15)
    assert float(result.stroke[0]) == 0.0
    np.testing.assert_allclose(
        [model.force(x, v) for x, v in zip(result.displacement.values, voltages, strict=True)], 0.0, atol=1e-14
    )


# --- ensembles, files, figures, bad input -------------------------------------------------------------------------


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
    dashed = [line for line in branches.lines if line.get_linestyle() == "--" and len(line.get_xdata())]
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


@pytest.mark.parametrize("film", ["taut", "wrinkling"])
def test_the_work_of_a_cycle_is_the_area_between_the_forces(film):
    model = ConeModel(rest_height=0.4, spring_stiffness=0.8, hoop_prestretch=1.4, film=film)
    levels = [0.0, 0.2, 0.4]
    wide = static(model, levels)
    rest = float(wide["rest_displacement"])
    for k, level in enumerate(levels):
        end = rest + float(wide["stroke"][k])
        x = np.linspace(rest, end, 2001)
        force = static(model, [0.0, level], x)["force"] if end > rest else np.zeros((2, 2001))
        area = float(np.trapezoid(force[0] - force[-1], x))
        assert float(wide["cycle_work"][k]) == pytest.approx(area, rel=1e-6, abs=1e-15)
        if film == "taut":  # the field pushes by v^2 x
            assert area == pytest.approx(level**2 * (end**2 - rest**2) / 2.0, rel=1e-6)


def test_beyond_pull_in_there_is_no_work_of_a_cycle():
    result = static(ConeModel(film="wrinkling", rest_height=0.4), [0.1, 5.0])
    assert np.isnan(result["cycle_work"].values).tolist() == [False, True]


def test_forces_and_branches_reach_past_all_that_happens():
    """Forces are sampled beyond the height at which the spring is free, branches reach beyond pitchforks and folds."""
    for height in (2.0, -2.0):
        lifted = static(ConeModel(spring_stiffness=0.05, rest_height=height), 0.1)
        assert float(np.abs(lifted["displacement"]).max()) > 2.0
    flat = static(ConeModel(), 0.1)
    assert float(flat["branch_voltage"].max()) > 1.2 * float(flat["pitchfork_voltage"])


# --- at once ----------------------------------------------------------------------------------------------------------

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
    begin = gelcone.creep(device, levels[1:], tolerance=1e-7, duration="1 ms")["begin"] if film == "taut" else None
    place = fast["equilibrium_displacement"][1].dropna("equilibrium").values
    assert begin is None or np.abs(place - float(begin[0])).min() < 1e-12
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


# --- what is handed on ------------------------------------------------------------------------------------------------


class Balance:
    """A made-up balance, all of whose numbers are its own."""

    reachable, flat, free_height, highest, highest_squared = True, True, 0.25, 2.0, 9.0
    system, n = ConeModel().system, {}

    def __init__(self, at):
        self.at = at

    def equilibria(self, squared):
        return [[Equilibrium(self.at + w + k, 1.0 + k, k == 0) for k in range(1 + (w > 0.5))] for w in squared]

    def whole(self, x, squared):
        return np.broadcast_to(np.asarray(x) < 1.5, np.broadcast_shapes(np.shape(x), np.shape(squared)))

    def inside(self, x):
        return x < 1.5

    def force(self, x, squared):
        return self.at + 3.0 * x + squared

    def slope(self, x, squared):
        return self.at + 4.0 * x - squared

    def folds(self):
        return [(0.3 * self.at, 5.0 + self.at)]

    def curves(self, highest):
        return [np.array([[self.at], [highest], [7.0 + self.at]])]

    def pitchfork(self):
        return 0.25 * self.at**2

    def along_ramp(self, rest, squared):
        return rest + squared, np.arange(squared.size) + self.at

    def voltage_force(self, x, squared):
        return x * squared

    flat_height = 1.5

    def jump(self, rest):
        return Loss(0.625 * self.at, PullIn.FOLD, 8.0 + rest, 9.0 + rest)


MODEL = ConeModel(damping_ratio=[0.1, 0.2])


@pytest.fixture
def balances(monkeypatch):
    """Two balances in the place of any model's, which rest at 0.5 and at where they are started from."""
    own, asked = [Balance(1.0), Balance(2.0)], []
    for name in ("balances_of", "every_balance"):
        monkeypatch.setattr(module, name, lambda model, *more: asked.append((model, *more)) or own[: model.size])
    monkeypatch.setattr(module, "rest_of", lambda balance, start: 0.5 * balance.at if start is None else start)
    return asked


@pytest.mark.parametrize("at_once", [False, True])
def test_the_statics_hold_what_the_balances_give(monkeypatch, balances, at_once):
    """At once they are those of the films before they creep, whose states decide on validity, too."""
    fast = MODEL.replace(rest_height=0.125)
    asked = record(
        monkeypatch, module, films_at_once=fast, _with_validity=lambda result, members, levels, place: result
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


def test_a_ramp_starts_where_it_is_asked_to(balances):
    """For all members, or for each its own."""
    found = module.pull_in_voltage(MODEL, start=[0.25, 0.75])
    assert found["rest_displacement"].values.tolist() == [0.25, 0.75]
    assert found["pull_in_from"].values.tolist() == [8.25, 8.75]
    assert json.loads(found.attrs["options"])["start"] == [0.25, 0.75]
    found = module.stroke_and_blocked_force(MODEL, [0.5, 1.0], start=0.25)
    assert found["rest_displacement"].values.tolist() == [0.25] * 2
    assert found["displacement"].values.tolist() == [[0.5, 1.25]] * 2
    assert found["blocked_force"].values.tolist() == [[0.0625, 0.25]] * 2
    assert found["losses"].values.tolist() == [[1.0, 2.0], [2.0, 3.0]]
    voltage, kind = module.jump_voltages(MODEL)
    assert (voltage.tolist(), kind.tolist()) == ([0.625, 1.25], [PullIn.FOLD] * 2)


def test_the_ramp_of_a_drive_is_that_of_its_balance(balances):
    """The blocked force is that at rest; beyond the film there is no stiffness."""
    levels = np.array([0.5, 1.0])
    (balance,) = module.every_balance(ConeModel())
    found = module.drive_ramp(balance, levels)
    assert found.rest == 0.5
    assert found.displacement.tolist() == [0.75, 1.5]
    assert found.stroke.tolist() == [0.25, 1.0]
    assert found.blocked_force.tolist() == [0.125, 0.5]
    np.testing.assert_array_equal(found.stiffness, [3.75, np.nan])
    np.testing.assert_allclose(found.voltages, [levels])
    assert (found.pitchfork, found.pull_in) == (0.5, 0.625)


def test_what_fails_at_equilibria_is_what_fails_of_the_films_there(monkeypatch):
    """A disc has pulled in beyond the displacement and above the voltage at which a ramp jumps."""
    levels, place = np.array([0.4, 0.6]), np.array([[[0.2, np.nan], [0.7, 0.3]]] * 3)
    dims = ("member", "constant_voltage", "equilibrium")
    result = xr.Dataset(
        {
            "slope": (dims, place), "pull_in_voltage": ("member", [0.5, np.inf, 0.65]), "pull_in_from": ("member",
            [-0.5, np.nan, -0.5]),
        }
    )  # fmt: skip
    fails = {"hoop_slack": np.arange(12).reshape(3, 4) % 2 == 0}
    asked = record(monkeypatch, module, outside=fails)
    members = ConeModel(damping_ratio=[0.1, 0.2, 0.3]).members()
    found = module._with_validity(result, members, levels, place)
    np.testing.assert_array_equal(found["validity_hoop_slack"], [[[1.0, np.nan], [1.0, 0.0]]] * 3)
    assert np.isnan(found["validity_breakdown"]).all()
    pulled = [[[0.0, np.nan], [1.0, 0.0]], *[[[0.0, np.nan], [0.0, 0.0]]] * 2]
    np.testing.assert_array_equal(found["validity_pulled_in"], pulled)
    (call,) = asked["outside"]
    np.testing.assert_array_equal(call["motion"], place.reshape(3, 4, 1))
    np.testing.assert_array_equal(call["voltages"][0], [[0.4, 0.4, 0.6, 0.6]] * 3)


def test_displacements_that_none_reaches_are_refused_with_the_farthest_that_one_does(balances):
    far, near = Balance(1.0), Balance(1.0)
    far.highest, near.highest = 3.0, 2.0
    for one in (far, near):
        one.inside = lambda x: np.zeros(x.shape, dtype=bool)
    with pytest.raises(InputError, match="stay within 3"):
        module._wanted([5.0, 6.0], [near, far])

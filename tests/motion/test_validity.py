"""For which share of a settled motion the model does not hold, in every analysis that knows the motion."""

from types import SimpleNamespace

import numpy as np
import pytest
from scipy.optimize import brentq

import gelcone
from gelcone import ConeModel, Outcome, regime, settled, simulate
from gelcone.motion import validity as module
from gelcone.motion.flow import integrate
from gelcone.motion.validity import BLOCKS, SHARES, invalid, unknown, validity, validity_variables
from gelcone.physics.film.wrinkling import STATES
from gelcone.presets import find_preset
from tests.recorded import numbers

STILL = ConeModel(damping_ratio=0.5, spring_stiffness=2.0, voltage=1.0, drive_frequency=1.0, dielectric_strength=0.5)
"""Rests flat: the true field is |sin|, above 0.5 for two thirds of the time."""
SWINGS = ConeModel(damping_ratio=0.3, voltage=0.5, voltage_bias=0.9, rest_height=0.6, dielectric_strength=1.4)
"""Follows its drive in a cycle of one period."""


@pytest.mark.parametrize("strength", [0.5, 0.999999, 1.000001])
def test_the_share_above_the_dielectric_strength_is_that_of_a_sine(strength):
    """Also where that is exceeded for less than a sample at a time."""
    model = STILL.replace(dielectric_strength=strength)
    expected = 1.0 - 2.0 * np.arcsin(min(strength, 1.0)) / np.pi
    for result in (gelcone.regime(model, (0.1, 0.0)), gelcone.simulate(model, (0.0, 0.0), periods=3)):
        assert float(result["validity_breakdown"]) == pytest.approx(expected, abs=1e-9)
        assert float(result["validity_error"]) < 1e-9


@pytest.mark.parametrize("waveform", ["sine", "triangle"])
def test_shares_are_those_between_exact_crossings_within_their_errors(waveform):
    """Crossings by bisection of the run's own integration, from samples 1e-4 of a period apart."""
    model = SWINGS.replace(waveform=waveform)
    period = float(model.drive_period)
    begin = integrate(model, (0.6, 0.0), [100.0 * period]).states[0, 0]
    members = model.members()

    def excess(phase):
        times = np.atleast_1d(phase) * period
        states = integrate(model, begin, times).states
        (voltage,) = members.voltages(times[None], states)
        state = model.film.state(states[0, :, 0], voltage[0], [], model.own_numbers)
        return {"breakdown": state.true_field - 1.4, "meridional_slack": -state.meridional_stress}

    phases = np.linspace(1e-9, 1.0, 10_001)
    coarse = excess(phases)
    for result in (gelcone.regime(model, (0.6, 0.0)), gelcone.settled(model, (0.6, 0.0))):
        for name, values in coarse.items():
            places = []
            for k in np.flatnonzero((values[1:] > 0.0) != (values[:-1] > 0.0)):
                ends = phases[k], phases[k + 1]
                places.append(brentq(lambda at, name=name: excess(at)[name][0], *ends, xtol=1e-13))
            gaps = np.diff([0.0, *places, 1.0])
            share = gaps[int(values[0] <= 0.0) :: 2].sum()
            assert abs(float(result[f"validity_{name}"]) - share) <= float(result["validity_error"]) + 1e-12
            assert float(result["validity_error"]) < 1e-6


@pytest.mark.parametrize("analysis", ["regime", "settled", "frequency", "bifurcation", "basin", "sweep", "map"])
def test_every_analysis_of_settled_motions_says_the_same_as_a_long_run(analysis):
    settled = gelcone.simulate(SWINGS, (0.6, 0.0), periods=60)
    late = settled.isel(time=slice(settled.sizes["time"] // 2, None))
    rows = {
        "regime": lambda: gelcone.regime(SWINGS, (0.6, 0.0)),
        "settled": lambda: gelcone.settled(SWINGS, (0.6, 0.0)),
        "frequency": lambda: gelcone.frequency(SWINGS, [1.0, 1.1], (0.6, 0.0)).isel(branch=0, drive_frequency=0),
        "bifurcation": lambda: gelcone.bifurcation(SWINGS, "drive_frequency", [1.0, 1.1], (0.6, 0.0)).isel(
            branch=0, drive_frequency=0
        ),
        "basin": lambda: gelcone.basin(SWINGS, {"displacement": [0.6, 0.7], "velocity": [0.0, 0.1]}).isel(
            displacement=0, velocity=0
        ),
        "sweep": lambda: gelcone.sweep(gelcone.Plan(SWINGS, {"drive_frequency": [1.0, 1.1]}, (0.6, 0.0))).isel(
            drive_frequency=0
        ),
        "map": lambda: gelcone.map(SWINGS, {"drive_frequency": [1.0, 1.1]}, (0.6, 0.0)).isel(drive_frequency=0),
    }
    found = rows[analysis]()
    for name in SHARES:
        if name != "beyond_membrane":
            assert float(found[f"validity_{name}"]) == pytest.approx(float(late[name].mean()), abs=0.01), name
    assert 0.1 < float(found["validity_breakdown"]) < 0.9
    assert float(found["validity_pulled_in"]) == 0.0


def test_what_is_not_known_is_not_a_number():
    assert np.isnan(gelcone.regime(STILL.replace(dielectric_strength=None), (0.1, 0.0))["validity_breakdown"])
    outside = gelcone.regime(STILL.replace(stretch_limit=[0.4, 50.0]), (1.0, 0.0))
    assert outside["outcome"].values.tolist() == [Outcome.OUTSIDE, Outcome.OK]
    for name in outside:
        if str(name).startswith("validity_"):
            assert np.isnan(outside[name].values[0]), name


def test_the_error_covers_what_another_start_gives():
    """Shares of chaotic motions differ from run to run; those of five starts lie within three errors of their mean."""
    chaotic = find_preset("base").model.replace(voltage=1.7)
    starts = np.array([[1.0 + 1e-3 * k, 0.0] for k in range(5)])
    kinds = gelcone.regime(
        chaotic.replace(damping_ratio=np.full(5, float(chaotic.damping_ratio))), starts, budget=200.0
    )
    assert (kinds["regime"] == gelcone.Regime.CHAOTIC).all()
    share, error = kinds["validity_hoop_slack"].values, kinds["validity_error"].values
    assert np.ptp(share) > 0.0
    assert (np.abs(share - share.mean()) < 3.0 * error).all()


def test_the_error_is_that_of_the_parts():
    times = np.arange(0.0, 81.0)[None]
    members = ConeModel(dielectric_strength=0.5, voltage=0.0, voltage_bias=1.0).members()
    states = np.zeros((1, 81, 2))
    states[0, :40, 0] = np.nan  # a field of 1 at every sample that is there
    assert np.isnan(validity(members, times, np.full_like(states, np.nan))[0]).all()
    assert validity(members, times, states)[0, SHARES.index("breakdown")] == 1.0
    expected = np.std(np.repeat([0.0, 1.0], BLOCKS // 2), ddof=1) / np.sqrt(BLOCKS)
    assert validity(members, times, states)[0, len(SHARES)] == pytest.approx(expected)
    assert validity(members, times, states, whole=True)[0, len(SHARES)] == 0.0


def test_a_run_that_ends_by_pull_in_has_pulled_in():
    found = unknown(3)
    found[:2, : len(SHARES) + 1] = 0.0
    outcome = np.array([Outcome.OK, Outcome.PULLED_IN, Outcome.STRETCH_LIMIT])
    share = validity_variables(found, outcome, ConeModel().system)["validity_pulled_in"][1]
    np.testing.assert_array_equal(share, [0.0, 1.0, np.nan])


def test_equilibria_say_where_they_do_not_hold():
    """The flat film's hoops are slack at any voltage without pre-stretch, and its field is the voltage."""
    found = gelcone.static(ConeModel(spring_stiffness=3.0, dielectric_strength=0.75), [0.0, 0.5, 1.0]).isel(
        equilibrium=0
    )
    assert found["equilibrium_displacement"].values.tolist() == [0.0, 0.0, 0.0]
    assert found["validity_breakdown"].values.tolist() == [0.0, 0.0, 1.0]
    assert found["validity_hoop_slack"].values.tolist() == [0.0, 1.0, 1.0]
    assert found["validity_pulled_in"].values.tolist() == [0.0, 0.0, 0.0]


def test_the_dielectric_strength_travels_with_a_device():
    device = gelcone.find_device("biased-pump").replace(film="taut")
    model = device.to_model()
    assert float(model.dielectric_strength) == pytest.approx(device.breakdown_field(), rel=1e-14)
    twice = gelcone.static(model, [3.0 * float(model.voltage_bias + model.voltage)])
    assert np.nanmax(twice["validity_breakdown"]) == 1.0
    assert float(gelcone.simulate(model, device.initial_state(), periods=2).validity_breakdown) == 0.0
    assert gelcone.model_of(twice).dielectric_strength == model.dielectric_strength


@pytest.mark.parametrize("films", [("wrinkling", "taut"), ("taut", "wrinkling"), ("wrinkling", "wrinkling")])
def test_a_mixed_double_cone_is_untrue_where_the_film_that_bears_compression_does(films):
    """Slack is compression in the taut film, and what the other one does. The films mirror each other in time."""
    numbers = {"second_flat_height": 0.8, "spring_stiffness": 0.0, "voltage": 0.1, "voltage_bias": 0.4}
    model = ConeModel(film=films[0], second_film=films[1], second_drive="opposite", drive_frequency=0.2, **numbers)
    found = gelcone.simulate(model, initial=(0.5, 0.0), periods=5.0)
    share, slack = float(found["validity_hoop_slack"]), float(found["hoop_slack"].mean())
    if "taut" not in films:
        assert share == 0.0 < slack
        assert not bool(invalid(found))
        return
    compressed = found["hoop_stress" if films[0] == "taut" else "second_hoop_stress"] < 0.0
    assert 0.1 < share < 0.9 * slack
    assert share == pytest.approx(float(compressed.mean()), abs=2e-3)
    assert bool(invalid(found))


def test_the_error_of_a_wandering_motion_is_also_that_of_the_films_states():
    """A film that is taut in one half of the motion and slack, flat under a voltage, in the other."""
    members = ConeModel(film="wrinkling", voltage=0.0, voltage_bias=0.3).members()
    times, states = np.arange(0.0, 81.0)[None], np.zeros((1, 81, 2))
    states[0, 41:, 0] = 0.9
    (voltage,) = members.voltages(times, states)
    kind = members.system.film.state(states[..., 0], voltage, [], members.numbers(trailing=1)).kind
    assert kind[0, 0] != kind[0, -1]
    expected = np.std(np.repeat([0.0, 1.0], BLOCKS // 2), ddof=1) / np.sqrt(BLOCKS)
    assert validity(members, times, states)[0, len(SHARES)] == pytest.approx(expected)


# --- the membrane that a cone stands for ------------------------------------------------------------------------------

ABOVE = {"film": "wrinkling", "stretch_limit": 50.0, "rest_height": 0.9, "spring_stiffness": 4.0, "radius_ratio": 0.2}


@pytest.mark.parametrize("film", ["wrinkling", "taut"])
def test_a_cone_states_for_how_long_its_membrane_has_pulled_in(film):
    """Held almost fast at x .9 the membrane pulls in at v .476 (certified: .4989 at .8622, .438 at .998)."""
    model = ConeModel(**ABOVE | {"film": film, "spring_stiffness": 4000.0, "damping_ratio": 1.0, "voltage": 0.55})
    run = simulate(model, (0.9, 0.0), periods=2)
    share = 2.0 / np.pi * np.arccos(0.476 / 0.55)  # of a sine above a level
    assert float(run["validity_beyond_membrane"]) == pytest.approx(share, abs=0.02)
    flagged = run["beyond_membrane"].values.astype(bool)
    assert np.abs(run["drive_voltage"].values[flagged]).min() > 0.46
    assert np.abs(run["drive_voltage"].values[~flagged]).max() < 0.49


def test_settled_and_regime_agree_on_the_share():
    model = ConeModel(**ABOVE | {"voltage": 0.55, "damping_ratio": 0.2, "drive_frequency": 0.3})
    shares = [float(analysis(model)["validity_beyond_membrane"]) for analysis in (settled, regime)]
    assert 0.05 < shares[0] < 0.5
    assert shares[1] == pytest.approx(shares[0], abs=2e-3)


def test_members_of_other_pre_stretches_and_ratios_have_their_own_membrane():
    several = ConeModel(**ABOVE | {"voltage": 0.55, "prestretch": [1.0, 1.0, 1.2], "radius_ratio": [0.2, 0.3, 0.2]})
    found = simulate(several, (0.9, 0.0), periods=2)["validity_beyond_membrane"].values
    alone = [float(simulate(several.take([k]), (0.9, 0.0), periods=2)["validity_beyond_membrane"][0]) for k in range(3)]
    np.testing.assert_allclose(found, alone, atol=1e-6)
    assert len(set(np.round(found, 4))) == 3


@pytest.mark.parametrize("changes", [{"film": "membrane"}, {"radius_ratio": None}])
def test_it_is_unknown_without_a_ratio_and_of_the_membrane_itself(changes):
    run = simulate(ConeModel(**ABOVE | {"voltage": 0.3} | changes), (0.7, 0.0), periods=2)
    assert np.isnan(run["validity_beyond_membrane"])


# --- made-up films ----------------------------------------------------------------------------------------------------


def made_up_state(**numbers_of):
    return SimpleNamespace(kind=None, **numbers_of)


def test_each_assumption_fails_by_its_own_number_of_its_own_film_and_member(monkeypatch):
    """Hoops by the hoop stress and meridians by theirs, the field over the strength of each member."""
    model = ConeModel(dielectric_strength=[2.0, 4.0], second_film="taut", second_drive="same")
    members, motion = model.members(), numbers(2, 3, 2, at=0.1)
    monkeypatch.setattr(type(members.system.films[0]), "limit_share", lambda film, x, v, y, n, state: state.share)
    states = [
        made_up_state(
            hoop_stress=numbers(2, 3, at=at), meridional_stress=numbers(2, 3, at=at + 1.0),
            true_field=numbers(2, 3, at=at + 2.0), share=numbers(2, 3, at=at + 3.0),
        )
        for at in (10.0, 20.0)
    ]  # fmt: skip
    found = module.violations(members, motion, [numbers(2, 3), numbers(2, 3)], states)
    for own, at in zip(found, (10.0, 20.0), strict=True):
        np.testing.assert_allclose(own["hoop_slack"], -numbers(2, 3, at=at))
        np.testing.assert_allclose(own["meridional_slack"], -numbers(2, 3, at=at + 1.0))
        np.testing.assert_allclose(own["breakdown"], numbers(2, 3, at=at + 2.0) - [[2.0], [4.0]])
        np.testing.assert_allclose(own["near_limit"], numbers(2, 3, at=at + 3.0) - module.NEAR_LIMIT)


@pytest.mark.parametrize(
    ("film", "hoops", "meridians"),
    [
        (ConeModel(film="wrinkling"), {"hoop_slack", "crumpled"}, {"meridional_slack", "crumpled"}),
        (ConeModel(film="membrane", radius_ratio=0.2), {"partly_wrinkled", "wrinkled", "slack"}, {"slack"}),
        (ConeModel(film="taut"), set(), set()),
    ],
    ids=["wrinkling", "membrane", "taut"],
)
def test_hoops_and_meridians_are_slack_in_these_states_of_a_film(film, hoops, meridians):
    kinds, places = film.system.film.kinds, module.slack_places(film.system.films[0])
    found = {name: {kinds[k] for k in own} for name, own in places.items()}
    assert found == {"hoop_slack": hoops, "meridional_slack": meridians}


def test_slack_of_a_film_that_wrinkles_follows_from_its_state_and_is_no_fault_of_the_model():
    """Four samples, one in each state; a film that bears compression is slack where a stress is negative."""
    model = ConeModel(film="wrinkling", second_film="taut", second_drive="same", second_flat_height=0.8)
    members, motion = model.members(), np.zeros((1, 4, 2))
    states = [
        made_up_state(true_field=np.zeros((1, 4))),
        made_up_state(
            hoop_stress=np.array([[1.0, 1.0, -1.0, 0.0]]), meridional_stress=np.array([[1.0, 1.0, 1.0, -1.0]])
        ),
    ]
    states[0].kind = np.array([[model.system.film.kinds.index(kind) for kind in STATES]])
    wrinkling, taut = module.broken_by_film(members, motion, [np.zeros((1, 4))] * 2, states)
    assert wrinkling["hoop_slack"].tolist() == [[False, True, False, True]]
    assert wrinkling["meridional_slack"].tolist() == [[False, False, True, True]]
    assert taut["hoop_slack"].tolist() == [[False, False, True, False]]
    assert taut["meridional_slack"].tolist() == [[False, False, False, True]]
    either, untrue = (f(members, motion, [np.zeros((1, 4))] * 2, states) for f in (module.broken, module.outside))
    assert either["hoop_slack"].tolist() == [[False, True, True, True]]
    for name in module.SLACK_IN:
        assert untrue[name].tolist() == taut[name].tolist()


def test_shares_and_their_error_are_over_the_time_that_each_motion_ran():
    """The third ran for no time."""
    times = {"hoop_slack": np.array([[0.5, 0.25], [1.0, 0.0], [0.0, 0.0]])}
    spans = np.array([[1.0, 2.0], [1.0, 0.0], [0.0, 0.0]])
    shares, error = module.shares_of(times, spans, np.array([0.3, 0.2, 0.1]))
    np.testing.assert_allclose(shares[SHARES.index("hoop_slack")], [0.25, 1.0, np.nan])
    np.testing.assert_allclose(error[:2], [0.1, 0.2])
    assert not np.isfinite(error[2])
    assert np.isnan(shares[SHARES.index("breakdown")]).all()


def test_columns_are_variables_of_their_own_names_and_a_film_that_failed_has_pulled_in_for_its_share():
    """A run that ended so has all the time; of a film with states each has its share."""
    system = ConeModel(film="wrinkling", damping_ratio=0.1).system
    kinds = system.film.kinds
    found = np.full((3, unknown(3).shape[1]), np.nan)
    columns = numbers(3, len(SHARES) + 1 + len(kinds), at=1.0)
    found[:, : columns.shape[1]] = columns
    told = validity_variables(found, np.array([0, Outcome.PULLED_IN, 0]), system, (), "motion")
    meanings = ["slack hoops under compression", "slack meridians under compression"]
    assert [told[f"validity_{name}"][2].partition(" with ")[2] for name in SHARES[:2]] == meanings
    for k, name in enumerate((*SHARES, "error")):
        np.testing.assert_array_equal(told[f"validity_{name}"][1], columns[:, k], name)
    for k, kind in enumerate(kinds):
        np.testing.assert_array_equal(told[f"film_state_{kind}"][1], columns[:, len(SHARES) + 1 + k], kind)
    failed = columns[:, len(SHARES) + 1 + kinds.index(module.FAILED)] if module.FAILED in kinds else np.zeros(3)
    np.testing.assert_array_equal(told["validity_pulled_in"][1], [failed[0], 1.0, failed[2]])


def test_a_pair_of_films_has_pulled_in_for_the_longer_share_of_its_films():
    films = {"film": "wrinkling", "second_film": "wrinkling", "second_flat_height": 0.8, "second_drive": "opposite"}
    system = ConeModel(**films, pull_in="memoryless").system
    found, first = np.zeros((2, unknown(2).shape[1])), len(SHARES) + 1
    for row, place in enumerate((0, module.MOST_KINDS)):
        found[row, first + place + system.films[0].kinds.index(module.FAILED)] = 0.3
    told = validity_variables(found, np.zeros(2, dtype=np.int8), system)
    assert told["validity_pulled_in"][1].tolist() == [0.3, 0.3]

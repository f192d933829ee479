"""Creep: certified delays, delayed snap-through, runs of simulate, circuits, and what is refused."""

import importlib
import json
from dataclasses import replace
from itertools import pairwise
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

import gelcone
from gelcone import ConeModel, InputError, Outcome
from gelcone.motion.constant_voltage import at_constant_voltages
from gelcone.motion.creep import _Held, _margin, _Ramp, holding, thresholds
from gelcone.motion.flow import DEFAULT_TOLERANCE
from gelcone.motion.job import Trajectories
from gelcone.motion.plane import Plane
from gelcone.motion.validity import VALIDITY
from gelcone.physics.balance import PullIn
from gelcone.physics.film.at_once import films_at_once
from gelcone.physics.film.taut import TautCone
from gelcone.physics.film.wrinkling import WrinklingCone
from tests.recorded import numbers, record

creep_module = importlib.import_module("gelcone.motion.creep")
rest_module = importlib.import_module("gelcone.motion.rest")
DELAYS = json.loads((Path(__file__).parents[1] / "reference" / "viscous.json").read_text())["delays"]
BRANCH = {"material.viscous_modulus_1": "4 kPa", "material.relaxation_time_1": "2 s"}
PUMP = gelcone.find_device("biased-pump").replace({"film": "taut", **BRANCH})
FLAT = {"rest_height": 0.0, "stretch_limit": 50.0, "viscous_limit_1": 50.0}


@pytest.mark.slow
def test_delays_and_thresholds_are_certified():
    """The first three of the certified delays, at a coarser tolerance."""
    film, cases = WrinklingCone(branches=1), DELAYS[:3]
    model = ConeModel(film=film, prestretch=1.0, viscous_modulus_1=0.5, relaxation_time_1=1.0, **FLAT)
    found = gelcone.creep(model, [*(float(case["v"]) for case in cases), 0.9], duration=15.0, tolerance=1e-10)
    np.testing.assert_allclose(found["pull_in_time"], [*(float(case["time"]) for case in cases), 0.0], rtol=1e-6)
    assert (found["outcome"] == Outcome.PULLED_IN).all()
    instant = float(found["instantaneous_pull_in_voltage"])
    assert instant == pytest.approx(float(cases[0]["thresholds"]["instantaneous"]), rel=1e-10)
    np.testing.assert_allclose(found["margin"][:3, 0], 1.0 - found["constant_voltage"][:3] / instant, rtol=1e-6)
    assert (np.diff(found["margin"][0].dropna("time")) < 0.0).all()
    held = found["time_to_pull_in"].values
    assert (np.diff(held[np.isfinite(held)]) < 0.0).all()
    holding = float(found["holding_voltage"])
    assert float(found["long_term_pull_in_voltage"]) < holding < found["held_voltage"].values[np.isfinite(held)].min()
    assert found["held_voltage"].values[np.isinf(held)].max() == holding


def test_the_margin_is_that_to_the_certified_threshold_at_once():
    model = ConeModel(film=WrinklingCone(branches=1), prestretch=1.0, viscous_modulus_1=0.5, **FLAT)
    volts, instant = np.array([0.7, 0.8, 0.86]), float(DELAYS[0]["thresholds"]["instantaneous"])
    held = films_at_once(model.replace(voltage=volts))
    np.testing.assert_allclose(_margin(held, np.zeros(3), volts), np.maximum(1.0 - volts / instant, 0.0), atol=1e-8)


def test_a_film_that_no_voltage_pulls_in_has_all_the_margin_and_one_beyond_has_none():
    """Raised neo-Hookean films at v^2 = 0.2 and beyond the stiffness; one with a low limit that stiffens before."""
    model = ConeModel(
        film="taut", rest_height=0.6, spring_stiffness=2.0, voltage=0.0, voltage_bias=[0.447, 0.447, 2.5],
        stretch_limit=[np.inf, 0.6, np.inf],
    )  # fmt: skip
    members = films_at_once(model.members())
    margin = _margin(members, np.full(3, 0.45), np.array([0.447, 0.447, 2.5]))
    jump = gelcone.pull_in_voltage(model.take([0]))["pull_in_voltage"].item()
    assert margin[0] == pytest.approx(1.0 - 0.447 / jump, rel=1e-3)
    assert margin[1] == 1.0
    assert margin[2] == 0.0


@pytest.mark.slow
def test_a_raised_disc_localises_as_late_as_certified():
    """`viscous.md`, section 4: after 49.0, 15.7 and 3.9, from a start nearby."""
    numbers = {"spring_stiffness": 3.0, "damping_ratio": 0.3, "viscous_modulus_1": 0.5, "relaxation_time_1": 10.0}
    film = WrinklingCone(branches=1)
    model = ConeModel(film=film, prestretch=1.0, **{**FLAT, **numbers, "rest_height": 1.4})
    found = gelcone.creep(model, [0.62, 0.66, 0.7], duration=60.0, tolerance=1e-10)
    np.testing.assert_allclose(found["pull_in_time"], [49.0, 15.7, 3.9], rtol=0.08)
    np.testing.assert_allclose(found["pull_in_time"][:2], [49.0, 15.7], rtol=2e-3)


def test_a_cone_holds_above_the_voltage_at_which_a_ring_of_the_relaxed_film_lengthens_slowly():
    """A hoop-slack cone: relaxed it localises, and a run of the homogeneous film lasts without end."""
    film = WrinklingCone(branches=1)
    model = ConeModel(
        film=film, meridional_prestretch=1.15, hoop_prestretch=1.2, rest_height=1.0, spring_stiffness=3.0,
        damping_ratio=0.3, viscous_modulus_1=0.5, relaxation_time_1=10.0,
    )  # fmt: skip
    low = float(gelcone.pull_in_voltage(model)["pull_in_voltage"])
    found = gelcone.creep(model, [0.99 * low, 1.01 * low], duration=1000.0, tolerance=1e-10)
    assert float(found["long_term_pull_in_voltage"]) == low
    assert PullIn(int(found["long_term_pull_in_kind"])) == PullIn.FILM
    assert np.isinf(found["pull_in_time"]).all()
    np.testing.assert_array_equal(np.isnan(found["equilibrium_displacement"]), [False, True])


def test_a_beam_snaps_late():
    """Certified: from 0.42 the disc passes 1 after 78.4, less than the way to halfway of its jump."""
    film = TautCone(branches=1, prestretch_mode="equibiaxial")
    beam = {"beam_stiffness": -0.6, "beam_cubic": 2.0, "beam_height": 1.0, "damping_ratio": 0.3}
    branch = {"viscous_modulus_1": 1.0, "viscous_limit_1": 50.0, "relaxation_time_1": 20.0, "stretch_limit": 50.0}
    model = ConeModel(film=film, bias=gelcone.BuckledBeam(), prestretch=1.2, **beam, **branch)
    found = gelcone.creep(model, [1.1, 1.25], duration=200.0, tolerance=1e-10)
    assert float(found["long_term_pull_in_voltage"]) == pytest.approx(1.1946, abs=5e-5)
    assert PullIn(int(found["long_term_pull_in_kind"])) == PullIn.FOLD
    assert np.isinf(found["pull_in_time"][0])
    assert float(found["final_displacement"][0]) == pytest.approx(float(found["equilibrium_displacement"][0]), rel=1e-3)
    one = found.isel(constant_voltage=1)
    x, at = one["displacement"].values, one["time"].values
    known = np.isfinite(x)
    assert np.interp(1.0, x[known], at[known]) == pytest.approx(78.4, abs=1.5)
    assert 78.4 < float(one["pull_in_time"]) < 90.0
    longer = gelcone.creep(model, [1.25], duration=230.0, tolerance=1e-10)  # with samples at other times
    assert float(longer["pull_in_time"][0]) == pytest.approx(float(one["pull_in_time"]), rel=1e-6)


def test_a_creeping_device_is_a_run_of_simulate_and_ends_relaxed():
    found = gelcone.creep(PUMP, ["1 kV"], duration="20 s", tolerance=1e-10)
    assert found["initial_displacement"].attrs["units"] == "mm"
    one = found.isel(constant_voltage=0)
    static = gelcone.static(PUMP, ["1 kV"])["equilibrium_displacement"].values.ravel()
    assert np.abs(static - float(one["equilibrium_displacement"])).min() < 1e-9
    assert float(one["final_displacement"]) == pytest.approx(float(one["equilibrium_displacement"]), rel=1e-4)
    assert float(one["initial_displacement"]) < float(one["final_displacement"])
    assert float(one["initial_displacement"]) == float(one["displacement"][0])
    held = PUMP.replace(voltage_amplitude=0.0, voltage_offset="1 kV")
    late = gelcone.simulate(held, times=[15.0, 20.0], tolerance=1e-10)["displacement"][-1]
    assert float(one["final_displacement"]) == pytest.approx(float(late), rel=1e-4)


@pytest.mark.parametrize(("film", "strength"), [(TautCone, 1.165), (WrinklingCone, 1.3)])
def test_the_model_holds_for_the_share_of_the_time_for_which_it_holds_in_simulate(film, strength):
    """Slack, breakdown, and a membrane that has pulled in, while voltages are held and until a film pulls in."""
    model = ConeModel(
        film=film(branches=1, prestretch_mode="equibiaxial"), bias=gelcone.BuckledBeam(), beam_stiffness=-0.6,
        beam_cubic=2.0, beam_height=1.0, prestretch=1.2, damping_ratio=0.3, viscous_modulus_1=1.0,
        relaxation_time_1=5.0, dielectric_strength=strength, radius_ratio=0.2,
    )  # fmt: skip
    levels, options = [0.4, 0.95, 1.07], {"tolerance": 1e-10}
    found = gelcone.creep(model, levels, duration=15.0, **options)
    starts = _Held.of(model, 1e-10, None).starts(np.array(levels))
    for k, level in enumerate(levels):
        held = at_constant_voltages(model, [level]).take([0])
        alone = gelcone.simulate(held, starts[k], times=[15.0], **options).isel(member=0)
        shares = [name for name in alone if str(name).startswith(("validity_", "film_state_"))]
        assert {str(name) for name in found} >= set(shares)
        for name in shares:
            np.testing.assert_allclose(found[name][k], alone[name], atol=1e-8, err_msg=f"{level} {name}")
    assert 0.05 < float(found["validity_breakdown"].max()) < 0.95
    assert float(found["validity_beyond_membrane"].max()) == 1.0


def test_a_leaking_film_behind_a_resistance_creeps_at_its_own_voltage():
    film = TautCone(branches=1)
    numbers = {"rest_height": 0.5, "damping_ratio": 0.2, "viscous_modulus_1": 0.5, "relaxation_time_1": 10.0}
    model = ConeModel(film=film, prestretch=1.2, **numbers)
    behind = model.replace(series_resistance=0.5, leakage_time=20.0)
    plain, found = (gelcone.creep(one, [0.5], tolerance=1e-10).isel(constant_voltage=0) for one in (model, behind))
    q = 1.0 + float(found["initial_displacement"]) ** 2
    voltage = 0.5 / (1.0 + 0.5 * q / 20.0)
    alone = gelcone.creep(model, [voltage], tolerance=1e-10).isel(constant_voltage=0)
    assert float(found["initial_displacement"]) == pytest.approx(float(alone["initial_displacement"]), rel=1e-9)
    assert float(found["initial_displacement"]) < float(plain["initial_displacement"])
    assert float(found["current"][1]) == pytest.approx(voltage * q / 20.0, rel=1e-2)


def test_films_at_different_levels_have_different_laws():
    """Taut at one voltage and wrinkled at the other, behind a resistance and with a leak."""
    branch = {"material.viscous_modulus_1": "5 kPa", "material.relaxation_time_1": "0.5 s"}
    device = gelcone.find_device("biased-pump").replace({"film": "wrinkling", "material.resistivity": 5e9, **branch})
    model = device.replace(series_resistance=1e6, meridional_prestretch=1.0, hoop_prestretch=1.05).to_model()
    ramps = (_Ramp(films_at_once(model)), _Ramp(model))
    held = _Held(model, *ramps, tolerance=1e-10, threads=None)
    states = held.starts(np.array([0.2, 0.8]))
    alone = [held.starts(np.array([level]))[0] for level in (0.2, 0.8)]
    volts = states[:, -1]
    np.testing.assert_array_equal(states, alone)
    assert (volts < [0.2, 0.8]).all()
    rows = zip(states[:, 0], volts, states[:, 2:4], strict=True)
    kinds = [int(model.film.state(x, v, list(y), model.numbers()).kind) for x, v, y in rows]
    assert kinds[0] != kinds[1]


def test_voltages_between_the_thresholds_are_those_of_the_source(monkeypatch):
    """Of a resistance and a leak the film has a part of the commanded voltage, here 0.83 to 0.93 of it."""
    film = TautCone(branches=1, prestretch_mode="equibiaxial")
    beam = {"beam_stiffness": -0.6, "beam_cubic": 2.0, "beam_height": 1.0, "damping_ratio": 0.3}
    branch = {"viscous_modulus_1": 1.0, "relaxation_time_1": 20.0, "series_resistance": 0.5, "leakage_time": 8.0}
    model = ConeModel(film=film, bias=gelcone.BuckledBeam(), prestretch=1.2, **beam, **branch)
    alone = _Ramp(model.replace(series_resistance=0.0, leakage_time=np.inf))
    held = _Held(model, _Ramp(films_at_once(model)), _Ramp(model), tolerance=1e-10, threads=None)
    monkeypatch.setattr(_Held, "run", lambda own, levels, *given: (None, np.full(levels.size, np.inf)))
    voltages, ends, highest = held.curve(10.0, None)
    assert np.isinf(ends).all()
    threshold = held.relaxed.lost.voltage
    assert voltages.min() > threshold > alone.lost.voltage / 0.93
    assert threshold < alone.lost.voltage / 0.83
    assert highest == voltages.max()
    found = holding(model, 10.0, 9.0, count=3, threads=None)
    assert found.variables["holding_voltage"][1] == found.highest == pytest.approx(highest, rel=1e-12)
    np.testing.assert_allclose(found.levels, found.highest * np.array([0.0, 0.75, 1.0]))


def test_a_voltage_above_that_at_once_pulls_in_at_once():
    model = ConeModel(film=WrinklingCone(branches=1), prestretch=1.0, viscous_modulus_1=0.5, damping_ratio=0.1, **FLAT)
    held = _Held(model, _Ramp(films_at_once(model)), _Ramp(model), tolerance=1e-10, threads=None)
    levels = np.array([0.3, 0.95])
    _, ends = held.run(levels, held.starts(levels), np.array([0.0, 0.5]), None)
    assert ends.tolist() == [np.inf, 0.0]


@pytest.mark.parametrize(
    ("device", "options", "message"),
    [
        (gelcone.find_device("biased-pump").replace(film="taut"), {}, "the film has no branch that relaxes"),
        (PUMP, {"duration": -1.0}, "duration = -.*must be positive"),
        (PUMP, {"voltages": [-5.0]}, "voltages"),
        (PUMP.replace(spring_rate=[10.0, 15.0]), {}, "takes one actuator"),
    ],
)
def test_what_cannot_creep_is_refused(device, options, message):
    with pytest.raises(InputError, match=message):
        gelcone.creep(device, **options)


def test_a_default_duration_that_is_too_long_is_refused_by_its_cause():
    slow = PUMP.replace({"material.relaxation_time_1": "300000000 s"})
    with pytest.raises(InputError, match=r"^duration: 8 time constants of the slowest state last \S+ \w+, longer than"):
        gelcone.creep(slow)


def test_a_voltage_is_held_for_eight_time_constants_of_the_slowest_state_where_no_time_is_given(monkeypatch):
    """A branch of 0.2 of the modulus creeps in 1.2 times its relaxation time."""

    class Stop(Exception):
        """Ends the analysis where the time is known."""

    def run(held, lasts):
        asked.append(lasts)
        raise Stop

    asked = []
    monkeypatch.setattr(creep_module, "times_of_run", run)
    times = {"relaxation_time_1": 3.0, "relaxation_time_2": 50.0}
    model = ConeModel(film=TautCone(branches=2), viscous_modulus_1=0.5, viscous_modulus_2=0.2, **times)
    for duration in (None, 7.0):
        with pytest.raises(Stop):
            gelcone.creep(model, [0.3], duration=duration)
    assert asked == [pytest.approx(8.0 * 50.0 * (1.0 + 0.2)), 7.0]  # under a constant load


# --- what is handed on ------------------------------------------------------------------------------------------------


class Films:
    """Made-up runs at constant voltages: of the first the film pulls in, the second is held."""

    def __init__(self):
        self.asked = {}
        lost = {
            name: SimpleNamespace(voltage=v, kind=PullIn.FOLD) for name, v in (("relaxed", 0.75), ("at_once", 1.25))
        }
        self.relaxed, self.at_once = (
            SimpleNamespace(lost=lost[name], place=lambda volts, by=by: by + volts)
            for name, by in (("relaxed", 50.0), ("at_once", 60.0))
        )

    def run(self, levels, states, times, progress):
        np.testing.assert_array_equal(states, self.starts(levels))
        self.asked["run"] = levels, times
        if progress is not None:
            progress(1.0)
        outcome = np.array([Outcome.PULLED_IN, Outcome.OK], dtype=np.int8)[: levels.size]
        ends = np.array([times[40], np.inf])[: levels.size]
        run = Trajectories.blank(np.tile(times, (levels.size, 1)), ConeModel(**RELAXING).system, "states", outcome)
        return replace(run, states=numbers(levels.size, times.size, 3, at=5.0)), ends

    def members(self, levels):
        return "members", levels.tolist()

    def starts(self, levels, progress=None):
        if progress is not None:
            progress(1.0)
        return numbers(levels.size, 3, at=7.0)

    def curve(self, lasts, progress):
        self.asked["curve"] = lasts
        if progress is not None:
            progress(1.0)
        return numbers(4, at=9.0), numbers(4, at=10.0), 0.875

    def margins(self, levels, run, x):
        self.asked["margins"] = levels, x
        return numbers(*x.shape, at=11.0)


RELAXING = {"rest_height": 0.8, "viscous_modulus_1": 0.5, "relaxation_time_1": 10.0, "damping_ratio": 0.2}


def test_creep_says_of_each_number_what_was_found(monkeypatch):
    """A run that pulls in is known up to and at that time."""
    films, asked, shares = Films(), [], []
    monkeypatch.setattr(_Held, "of", lambda *given: asked.append(given) or films)
    sampled = []
    monkeypatch.setattr(
        creep_module, "times_of_run", lambda held, lasts: sampled.append(held) or np.array([0.0, lasts])
    )
    electric = {}

    def electrics(members, run):
        electric["members"] = members
        return numbers(2, 121, at=12.0), numbers(2, 121, at=13.0)

    monkeypatch.setattr(creep_module, "_electric", electrics)
    monkeypatch.setattr(creep_module, "validity_of_run", lambda members, run: numbers(2, VALIDITY, at=14.0))
    model = ConeModel(**RELAXING)
    found = gelcone.creep(model, [0.25, 0.5], duration=30.0, tolerance=2e-9, threads=5, progress=shares.append)
    assert asked == [(model, 2e-9, 5)]
    assert sampled == [("members", [0.25, 0.5])]
    levels, times = films.asked["run"]
    assert levels.tolist() == films.asked["margins"][0].tolist() == [0.25, 0.5]
    assert (times[0], times[-1], films.asked["curve"]) == (0.0, 30.0, 30.0)
    assert electric["members"] == ("members", [0.25, 0.5])
    gone = np.zeros((2, 121), dtype=bool)
    gone[0, 41:] = True
    states = np.where(gone, np.nan, numbers(2, 121, 3, at=5.0)[..., 0])
    np.testing.assert_array_equal(films.asked["margins"][1], states)
    expected = {
        "initial_displacement": numbers(2, 3, at=7.0)[:, 0], "final_displacement": states[:, -1],
        "equilibrium_displacement": [50.25, 50.5],
        "pull_in_time": [times[40], np.inf], "displacement": states, "margin": numbers(2, 121, at=11.0),
        "current": np.where(gone, np.nan, numbers(2, 121, at=12.0)), "time": times,
        "heating": np.where(gone, np.nan, numbers(2, 121, at=13.0)), "long_term_pull_in_voltage": 0.75,
        "instantaneous_pull_in_voltage": 1.25,
        "holding_voltage": 0.875, "time_to_pull_in": numbers(4, at=10.0), "held_voltage": numbers(4, at=9.0),
        "constant_voltage": [0.25, 0.5], "outcome": [Outcome.PULLED_IN, Outcome.OK],
        "validity_hoop_slack": numbers(2, VALIDITY, at=14.0)[:, 0], "validity_pulled_in": [1.0, 0.0],
    }  # fmt: skip
    for name, values in expected.items():
        np.testing.assert_array_equal(found[name], values, name)
    assert np.isfinite(states[0, 40])
    assert sum(shares) == pytest.approx(1.0)
    assert json.loads(found.attrs["options"]) == {"duration": 30.0, "tolerance": 2e-9}


@pytest.mark.parametrize(("borne", "highest"), [(0.875, 0.875), (np.inf, 0.375), (np.nan, 0.375)])
def test_levels_that_are_held_end_at_the_highest_or_where_there_is_none_at_the_one_given(monkeypatch, borne, highest):
    films, asked = Films(), []
    monkeypatch.setattr(_Held, "of", lambda *given: asked.append(given) or films)
    curve = films.curve
    films.curve = lambda *given: (*curve(*given)[:2], borne)
    model = ConeModel(**RELAXING)
    found = holding(model, 30.0, 0.375, count=2, threads=5)
    assert asked == [(model, DEFAULT_TOLERANCE, 5)]
    np.testing.assert_allclose(films.asked["run"][0], [0.0, highest])
    np.testing.assert_allclose(found.levels, [0.0, highest])
    assert found.runs[0] == ("members", [0.0, highest])
    assert found.at(np.array([0.25]))[0] == ("members", [0.25])
    np.testing.assert_array_equal(films.asked["run"][0], [0.25])
    np.testing.assert_array_equal([found.highest, found.variables["holding_voltage"][1]], [borne] * 2)
    assert (found.variables["long_term_pull_in_voltage"][1], found.variables["instantaneous_pull_in_voltage"][1]) == (
        0.75,
        1.25,
    )
    assert (films.asked["run"][1][-1], films.asked["curve"]) == (30.0, 30.0)


def test_a_run_ends_where_the_film_pulls_in_or_meets_its_limit_and_is_unknown_where_it_failed(monkeypatch):
    outcomes = [Outcome.OK, Outcome.PULLED_IN, Outcome.STRETCH_LIMIT, Outcome.STEP_LIMIT, Outcome.OK]
    outcome = np.array(outcomes, dtype=np.int8)
    run = SimpleNamespace(outcome=outcome, end_times=numbers(5, at=3.0), states=np.zeros((5, 2, 3)))
    states = numbers(5, 3, at=4.0)
    states[4, 0] = np.nan
    ramp = SimpleNamespace(lost=SimpleNamespace(before=0.1, after=np.inf, kind=0, voltage=1.0))
    held = _Held(ConeModel(**RELAXING), ramp, ramp, 2e-9, 5)
    asked = record(monkeypatch, creep_module, integrate=run)
    times = np.array([0.0, 1.0])
    found, ends = held.run(np.arange(5.0), states, times, None)
    assert found is run
    (call,) = asked["integrate"]
    assert (call["tolerance"], call["threads"], call["times"] is times) == (2e-9, 5, True)
    np.testing.assert_array_equal(call["initial"], states)
    np.testing.assert_array_equal(ends, [np.inf, *numbers(5, at=3.0)[1:3], np.nan, 0.0])


@pytest.mark.parametrize("circuit", [{}, {"filter_time": 0.5}])
def test_films_in_opposite_phase_creep_to_where_statics_rest(circuit):
    """At v the second film has 2 v0 - v, with the bias of the device."""
    films = {"second_film": TautCone(branches=1), "second_drive": "opposite", "second_flat_height": 1.2}
    gel = {"viscous_modulus_1": 0.5, "relaxation_time_1": 2.0, "hoop_prestretch": 1.4, "second_prestretch": 1.2}
    drive = {"voltage": 0.2, "voltage_bias": 0.4, "damping_ratio": 0.2}
    model = ConeModel(film=TautCone(branches=1), **films, **circuit, **gel, **drive)
    found = gelcone.creep(model, [0.1, 0.6], duration=80.0)
    statics, at_once = (gelcone.static(model, [0.1, 0.6], at_once=early) for early in (False, True))
    np.testing.assert_allclose(found.initial_displacement, at_once.equilibrium_displacement[:, 0], rtol=1e-8)
    np.testing.assert_allclose(found.final_displacement, statics.equilibrium_displacement[:, 0], rtol=1e-8)
    np.testing.assert_allclose(found.displacement[:, 0], found.initial_displacement, rtol=1e-12)
    np.testing.assert_allclose(found.equilibrium_displacement, statics.equilibrium_displacement[:, 0], rtol=1e-8)


def test_the_thresholds_of_an_envelope_are_at_its_own_proportion_of_the_bias():
    """In the long run that is the pull-in of the ramp of the peak."""
    gel = {"viscous_modulus_1": 0.5, "relaxation_time_1": 2.0, "hoop_prestretch": 1.2}
    films = {"second_film": TautCone(branches=1), "second_drive": "opposite", "second_flat_height": 2.0}
    model = ConeModel(film=TautCone(branches=1), **films, **gel, voltage=0.3, voltage_bias=1.0, damping_ratio=0.2)
    plane = Plane.of(model, None)
    found = thresholds(model, plane.bias_share)
    pull_in = plane.ramp(np.zeros(1)).pull_in
    assert found["proportional_long_term_pull_in_voltage"][1] == pytest.approx(pull_in, rel=1e-9)
    assert pull_in < found["proportional_instantaneous_pull_in_voltage"][1] < np.inf
    envelope = gelcone.envelope(model, frequencies=[1.0, 1.2], peaks=[0.2, 0.3], limits_from="settled")
    assert float(envelope["proportional_long_term_pull_in_voltage"]) == pytest.approx(pull_in, rel=1e-9)


def test_the_voltages_of_both_films_times_their_currents_are_the_power_that_heats_them():
    """Voltages of opposite signs, which drive currents of opposite signs."""
    films = {"second_film": TautCone(branches=1), "second_drive": "opposite", "second_flat_height": 1.2}
    gel = {"viscous_modulus_1": 0.5, "relaxation_time_1": 2.0, "hoop_prestretch": 1.4, "leakage_time": 50.0}
    model = ConeModel(film=TautCone(branches=1), **films, **gel, damping_ratio=0.2, voltage_bias=0.2)
    late = gelcone.creep(model, [0.5], duration=80.0, tolerance=1e-10).isel(constant_voltage=0, time=-1)
    first, second = float(late["current"]), float(late["second_current"])
    assert first > 0.0 > second
    assert 0.5 * first - 0.1 * second == pytest.approx(2.0 * float(late["heating"]), rel=1e-6)


@pytest.mark.parametrize("drive", ["same", "opposite"])
def test_heat_is_over_the_volume_of_both_films_and_each_has_its_current(drive):
    members = ConeModel(damping_ratio=0.1, second_film="taut", second_drive=drive, leakage_time=7.0, voltage=0.0,
                        voltage_bias=[0.2, 0.3]).members()  # fmt: skip
    system = members.system
    run = SimpleNamespace(times=np.tile([0.0, 1.0], (2, 1)), states=numbers(2, 2, len(system.states), at=0.25))
    first, second, heat = creep_module._electric(members, run)
    z, n = list(np.moveaxis(run.states, -1, 0)), members.numbers(trailing=1)
    each = [np.broadcast_to(own, (2, 2)) for own in system.currents(run.times, z, n)]
    np.testing.assert_allclose([first, second], each)
    powers = dict(zip(system.causes, system.powers(run.times, z, n), strict=True))
    np.testing.assert_allclose(heat, np.broadcast_to(powers["leak"], (2, 2)) / 2.0)
    assert (heat > 0.0).all()


def test_the_time_to_pull_in_is_sought_between_both_thresholds_at_the_source(monkeypatch):
    """From 1.5 to 2.5, and closer where it is just held."""
    relaxed, at_once = (SimpleNamespace(lost=SimpleNamespace(voltage=v)) for v in (1.5, 2.5))
    held = _Held(ConeModel(**RELAXING), at_once, relaxed, 2e-9, 5)
    levels = []

    def runs(own, at, states, times, progress):
        assert states == "starts"
        levels.append(at)
        return None, np.where(at < 1.85, np.inf, 3.0)

    monkeypatch.setattr(_Held, "run", runs)
    monkeypatch.setattr(_Held, "starts", lambda own, levels, progress: "starts")
    voltages, ends, highest = held.curve(30.0, None)
    shares = (np.arange(1, creep_module.CURVE + 1) / (creep_module.CURVE + 1)) ** 1.5
    np.testing.assert_allclose(levels[0], 1.5 + shares)
    assert len(levels) == 1 + creep_module.FINER
    for before, at in pairwise(levels):
        assert before[before < 1.85].max() <= at.min() < at.max() <= before[before >= 1.85].min()
        assert at.size == creep_module.FINE
    assert (np.diff(voltages) > 0.0).all()
    np.testing.assert_array_equal(ends, np.where(voltages < 1.85, np.inf, 3.0))
    assert highest == voltages[voltages < 1.85].max()
    assert 1.85 - highest < 0.01


def test_starts_at_many_levels_take_one_search_together(monkeypatch):
    """Behind a resistance, with a leak: a search for each level takes most of the time of a membrane's creep."""
    held = _Held.of(PUMP.replace({"series_resistance": 2e6, "material.resistivity": 5e9}).to_model(), 1e-10, 1)
    asked, own = [], rest_module.circuits_at_rest
    monkeypatch.setattr(rest_module, "circuits_at_rest", lambda *given: asked.append(given) or own(*given))
    states = held.starts(np.linspace(0.1, 0.6, 6))
    assert np.shape(asked[0][1]) == (6,)
    assert len(asked) <= 2
    assert (np.diff(states[:, -1]) > 0.0).all()


def test_the_progress_counts_the_starts(monkeypatch):
    """Behind a resistance they take longer than the runs from there."""
    shares, held = [], _Held.of(ConeModel(**RELAXING), 1e-10, 1)
    held.starts(np.array([0.1, 0.2, 0.3, 0.4]), shares.append)
    assert shares == [0.5, 0.5]
    monkeypatch.setattr(_Held, "run", lambda own, at, states, times, progress: progress(1.0) or (None, at < 0.5))
    shares.clear()
    lost = [SimpleNamespace(voltage=voltage) for voltage in (0.3, 0.6)]
    relaxed = SimpleNamespace(rest=held.relaxed.rest, lost=lost[0])
    at_once = SimpleNamespace(place=held.at_once.place, lost=lost[1])
    replace(held, relaxed=relaxed, at_once=at_once).curve(1.0, shares.append)
    assert sum(shares) == pytest.approx(1.0)
    assert max(shares) < 0.2


def test_the_margin_is_that_of_maps():
    """Of a film whose branches hardly pull, one voltage has one margin, whichever analysis is asked."""
    model = ConeModel(rest_height=0.8, viscous_modulus_1=1e-9, relaxation_time_1=1.0, voltage=0.0, voltage_bias=0.3)
    held = gelcone.creep(model.replace(film="wrinkling", prestretch=1.2), duration=8.0)
    over = {"voltage_bias": [0.3, 0.4], "drive_frequency": [0.5, 0.6]}
    cells = gelcone.map(model.replace(film="wrinkling", prestretch=1.2), over, also="margin")
    assert float(held["margin"][0, -1]) == pytest.approx(float(cells["margin"][0, 0]), rel=1e-6)
    assert 0.0 < float(cells["margin"][0, 0]) < 1.0

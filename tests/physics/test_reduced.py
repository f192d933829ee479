"""Resistances and branches without states: second order against the full model, losses, tangents, and what refuses."""

import numpy as np
import pytest

import gelcone
from gelcone import ConeModel, InputError, simulate
from gelcone.analyses import answer
from gelcone.analyses.request import Subject
from gelcone.motion.flow import integrate
from gelcone.physics.amplifier import REDUCED_RESISTANCE
from gelcone.physics.film.branches import REDUCED_TIME
from gelcone.physics.waveforms import Samples, Staircase

DRIVE = {
    "voltage": 0.5, "voltage_bias": 0.5, "drive_frequency": 0.6, "rest_height": 0.8, "hoop_prestretch": 1.3,
    "damping_ratio": 0.02,
}  # fmt: skip
TIMES = np.linspace(0.0, 20.0, 101)


def charged(full, reduced):
    """The start of a full model whose films have the voltages of the reduced one."""
    known = {s.name: float(reduced[s.name][0]) for s in full.system.states if s.name.endswith("film_voltage")}
    start = full.members().start_states((0.6, 0.1))[0]
    return [known.get(state.name, value) for state, value in zip(full.system.states, start, strict=True)]


def errors(more, name, values):
    """Of the reduced model and of the one without the stiff part, each over the values."""
    found = []
    for value in values:
        full = ConeModel(**DRIVE | more, **{name: value})
        assert full.stiff == (name,)
        reduced = full.replace(reduced=name)
        assert reduced.reduced == (name,)
        run = simulate(reduced, (0.6, 0.1), times=TIMES)
        assert float(abs(run["energy_residual"]).max()) < 1e-12
        exact = simulate(full, charged(full, run), times=TIMES)
        bare = {"series_resistance": 0.0} if name == "series_resistance" else {"viscous_modulus_1": 0.0}
        without = simulate(full.replace(**bare), (0.6, 0.1), times=TIMES)
        x = exact["displacement"].values
        found.append([np.abs(one["displacement"].values - x).max() for one in (run, without)])
        lost = "resistor_dissipation" if name == "series_resistance" else "film_dissipation"
        assert float(run[lost][-1]) == pytest.approx(float(exact[lost][-1]), rel=0.02)
    return np.array(found)


@pytest.mark.parametrize(
    "more",
    [
        {},
        {"filter_time": 0.2, "slew_rate": 0.5, "waveform": "trapezoid"},
        {"leakage_time": 5.0, "leakage_field": 0.5},
        {"second_film": "taut", "second_flat_height": 1.0, "second_drive": "opposite"},
    ],
    ids=["alone", "filter", "leak", "two films"],
)
def test_a_resistance_without_a_state_errs_by_its_square(more):
    """By 9 from 0.009 to 0.003; the ideal source by 3, and by far more."""
    found = errors(more, "series_resistance", (0.009, 0.003))
    assert found[0, 0] / found[1, 0] == pytest.approx(9.0, rel=0.15)
    assert found[0, 1] / found[1, 1] == pytest.approx(3.0, rel=0.15)
    assert found[0, 0] < 0.04 * found[0, 1]
    assert found[0, 0] < 1.5e-3


@pytest.mark.parametrize("flow", ["log", "linear"])
def test_a_fast_branch_is_a_damper_to_second_order(flow):
    found = errors({"flow": flow, "viscous_modulus_1": 0.5, "rested": "raised"}, "relaxation_time_1", (0.012, 0.004))
    assert found[0, 0] / found[1, 0] == pytest.approx(9.0, rel=0.15)
    assert found[0, 1] / found[1, 1] == pytest.approx(3.0, rel=0.15)
    assert found[0, 0] < 2.6e-4


def test_one_branch_may_be_reduced_and_others_not():
    """Of a double cone, too, whose second film has the first one's branches; and statics are the same."""
    numbers = {"viscous_modulus_1": 0.3, "relaxation_time_1": 5.0, "viscous_modulus_2": 0.5, "relaxation_time_2": 0.004}
    full = ConeModel(**DRIVE, **numbers, second_film="taut", second_flat_height=1.0, rested="raised")
    reduced = full.replace(reduced="relaxation_time_2")
    assert [s.name for s in reduced.system.states[2:4]] == ["viscous_meridional_1", "viscous_hoop_1"]
    assert len(reduced.system.states) == len(full.system.states) - 4
    ends = [integrate(model, (0.6, 0.1), TIMES).states[0, :, 0] for model in (full, reduced)]
    np.testing.assert_allclose(ends[1], ends[0], atol=2e-5)
    static = [gelcone.static(model, [0.5])["equilibrium_displacement"].values for model in (full, reduced)]
    np.testing.assert_array_equal(*static)
    assert reduced.replace(reduced="none").system == full.system
    assert reduced.replace(relaxation_time_2=0.01).reduced == ("relaxation_time_2",)


@pytest.mark.parametrize(
    "given",
    [
        {"series_resistance": 0.005, "leakage_time": 8.0, "reduced": "series_resistance"},
        {"relaxation_time_1": 0.01, "viscous_modulus_1": 2.0, "reduced": "relaxation_time_1"},
    ],
)
def test_tangents_and_trace_are_those_of_differences(given):
    model = ConeModel(**DRIVE, **given)
    assert not model.system.planar
    run = integrate(model, (0.6, 0.1), [5.0], keep="tangents")
    starts = np.array([0.6, 0.1]) + 1e-6 * np.array([[1, 0], [0, 1], [-1, 0], [0, -1]])
    ends = np.array([integrate(model, start, [5.0]).states[0, -1] for start in starts])
    np.testing.assert_allclose(run.tangents[0, -1], ((ends[:2] - ends[2:]) / 2e-6).T, atol=1e-8)
    assert float(run.divergence[0, -1]) == pytest.approx(np.log(np.linalg.det(run.tangents[0, -1])), abs=1e-10)
    assert float(run.divergence[0, -1]) < -2.0 * 0.02 * 5.0


def test_small_signals_settled_motion_and_records_know_it():
    full = ConeModel(**DRIVE | {"voltage": 0.02}, series_resistance=0.008, leakage_time=10.0)
    reduced = full.replace(reduced="series_resistance")
    ends = [gelcone.settled(model) for model in (full, reduced)]
    assert float(ends[1]["stroke"]) == pytest.approx(float(ends[0]["stroke"]), rel=1e-3)
    assert float(ends[1]["linear_stroke"]) == pytest.approx(float(ends[0]["linear_stroke"]), rel=1e-3)
    assert float(ends[1]["resistor_power"]) == pytest.approx(float(ends[0]["resistor_power"]), rel=0.02)
    again = gelcone.model_of(ends[1])
    assert again.system == reduced.system
    lines = [answer.heading(Subject(model, None, (1.0, 0.0))) for model in (full, reduced)]
    assert lines[0][-1] == "  stiff: series_resistance; --set reduced=series_resistance takes less time"
    assert lines[1][-1].startswith("  reduced: the series resistance, below 0.01")


@pytest.mark.parametrize("waveform", ["triangle", "square", "trapezoid", "ramp", "half_wave", "burst", "staircase"])
def test_drives_with_corners_that_do_not_jump_are_taken_behind_a_filter(waveform):
    """As none does by default, bursts included, whose sine ends at zero but for rounding."""
    given = {"waveform": waveform, "filter_time": 0.2, "series_resistance": 0.009, "reduced": "series_resistance"}
    assert ConeModel(**DRIVE, **given).reduced == ("series_resistance",)


class Chord(gelcone.Film):
    """A user's film, whose capacitance is known in programs and whose gain is the default."""

    name = "chord"
    linear_charge = traced_charge = True
    parameters = {"film_modulus": gelcone.Quantity("c", "modulus of the film", 2.0, positive=True)}

    def force(self, x, squared, y, n, xp=np):
        return (n["film_modulus"] - squared) * x, n["film_modulus"] - squared + 0.0 * x

    def capacitance(self, x, squared, y, n, xp=np):
        return 1.0 + x * x


def test_a_film_of_ones_own_takes_a_resistance_without_a_state():
    found = errors({"film": Chord(), "hoop_prestretch": None}, "series_resistance", (0.009, 0.003))
    assert found[0, 0] / found[1, 0] == pytest.approx(9.0, rel=0.15)
    assert found[0, 0] < 0.1 * found[0, 1]


def test_each_call_states_the_whole_choice():
    """Whichever way round, each name once, and together with the number of branches that goes with it."""
    numbers = {
        "viscous_modulus_1": 0.3,
        "relaxation_time_1": 0.01,
        "viscous_modulus_2": 0.5,
        "relaxation_time_2": 0.004,
    }
    model = ConeModel(**numbers, series_resistance=0.005, reduced="relaxation_time_1+relaxation_time_1")
    assert model.film == model.replace(reduced="relaxation_time_1").film
    assert model.replace(voltage=1.0).reduced == ("relaxation_time_1",)
    for names in (("series_resistance",), ("series_resistance", "relaxation_time_2"), ("relaxation_time_2",), ()):
        model = model.replace(reduced="+".join(names) or "none")
        assert model.reduced == names
    second = model.replace(reduced="relaxation_time_2")
    assert second.replace(branches=1, reduced="none").film.branches == 1
    with pytest.raises(InputError, match="there is no relaxation_time_2"):
        second.replace(branches=1)


def test_the_balance_beside_a_film_whose_charge_no_program_knows_closes():
    """By the first law, in which the damper's work is what the films give the disc less; and it is that of the film
    whose charge is known."""

    class Unknown(Chord):
        traced_charge = False

    own = {"viscous_modulus_1": 2.0, "relaxation_time_1": 0.01, "reduced": "relaxation_time_1"}
    runs = []
    for second in (Chord(), Unknown()):
        model = ConeModel(**DRIVE, **own, second_film=second)
        runs.append(simulate(model, (0.6, 0.1), times=TIMES))
    known, unknown = runs
    assert float(known["film_dissipation"][-1]) > 5e-3
    np.testing.assert_allclose(unknown["supplied_energy"], known["supplied_energy"], atol=1e-11)
    for run in runs:
        assert float(abs(run["energy_residual"]).max()) < 1e-12


def test_a_device_takes_it():
    device = gelcone.find_device("biased-pump").replace({"film": "taut", "series_resistance": "0.1 MOhm"})
    assert device.to_model().stiff == ("series_resistance",)
    reduced = device.replace(reduced="series_resistance")
    assert len(reduced.to_model().system.states) == 2
    assert float(reduced.to_model().series_resistance) < REDUCED_RESISTANCE
    with pytest.raises(InputError, match=r"series_resistance = .*must be below 0\.01; leave it out of reduced"):
        reduced.replace(series_resistance="5 MOhm").to_model()


@pytest.mark.parametrize(
    ("given", "message"),
    [
        (
            {"series_resistance": 0.03},
            r"series_resistance = 0.03 \(times C0 Omega0\): without a state it must be below",
        ),
        ({"series_resistance": 0.003, "current_limit": 1.0}, "current_limit: takes the voltage on the film as a state"),
        ({"series_resistance": 0.003, "film": "wrinkling"}, "the capacitance of the film 'wrinkling' depends"),
        ({"series_resistance": 0.003, "waveform": "triangle"}, "the waveform 'triangle' has corners"),
        *(
            ({"series_resistance": 0.009, "filter_time": 0.003} | jumping, f"the waveform '{name}' jumps, and behind")
            for name, jumping in {
                "square": {"waveform": "square", "rise": [0.1, 0.0]},
                "ramp": {"waveform": "ramp", "fall": 0.0},
                "staircase": {"waveform": Staircase((0.0, 1.0), 0.0)},
                "samples": {"waveform": Samples((0.0, 0.5, 1.0), (0.0, 1.0, 0.5), repeat=True, jump=True)},
            }.items()
        ),
        ({"circuit": "charge"}, "the circuit 'charge' has no series_resistance"),
        ({}, "reduced: there is no series_resistance"),
        ({"reduced": "damping"}, "'damping' is not a.*reduced"),
        ({"reduced": "relaxation_time_1"}, "there is no relaxation_time_1"),
        (
            {"reduced": "relaxation_time_1", "relaxation_time_1": REDUCED_TIME},
            "relaxation_time_1 = 0.02 .*must be below",
        ),
        (
            {"reduced": "relaxation_time_1", "relaxation_time_1": 0.01, "film": "wrinkling"},
            "relaxation_time_1 takes its states in a film that wrinkles",
        ),
    ],
)
def test_what_is_not_right_to_second_order_keeps_its_state(given, message):
    with pytest.raises(InputError, match=message):
        ConeModel(**{"reduced": "series_resistance"} | given)

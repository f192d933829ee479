"""The settled motion and its harmonics: phases in degrees, and none of what does not move."""

import importlib
import json
from types import SimpleNamespace

import numpy as np
import pytest

from gelcone import frequency, settled
from gelcone.codes import Outcome
from gelcone.motion.attractor.cycle import FIRST_TOLERANCE
from gelcone.motion.electrical import MEANINGS, known_of
from gelcone.motion.state_space import small_signal_response
from gelcone.motion.swing import Swing, settled_swing, swing
from gelcone.physics.model import ConeModel
from tests.recorded import numbers, record

module, swing_module = (importlib.import_module(f"gelcone.motion.{name}") for name in ("settled", "swing"))
SMALL = ConeModel(
    voltage=1e-4, voltage_bias=0.3, rest_height=0.3, spring_stiffness=2.0, damping_ratio=0.2, drive_frequency=0.8
)


def test_phases_are_degrees_ahead_of_the_voltage():
    """Of a small motion about a bias the first phase is that of linear theory; the third harmonic is rounding."""
    result = settled(SMALL, (0.3, 0.0))
    linear = small_signal_response(SMALL, [0.8])
    assert result["harmonic_phase"].attrs["units"] == linear["phase"].attrs["units"] == "degree"
    assert float(result["harmonic_phase"][0]) == pytest.approx(float(linear["phase"][0]), abs=1e-3)
    assert -179.0 < float(linear["phase"][0]) < -1.0
    assert np.isnan(result["harmonic_phase"].values[2:]).all()


def test_what_does_not_move_has_no_phase():
    still = ConeModel(voltage=0.2, damping_ratio=0.3, drive_frequency=[0.4, 0.8])
    at_rest = settled(still, (0.3, 0.0))
    assert at_rest["resting"].values.all()
    assert np.isnan(at_rest["harmonic_phase"].values).all()
    swept = frequency(still.replace(drive_frequency=0.4), [0.4, 0.5], (0.3, 0.0))
    assert np.isnan(swept["harmonic_phase"].values).all()
    assert np.isnan(small_signal_response(still.replace(drive_frequency=0.4), [0.4])["phase"].values).all()


def test_rounding_is_that_of_the_largest_displacement_on_either_side():
    found = Swing.blank(1)
    found.lowest[:], found.highest[:] = -1.0, 1e-3
    found.harmonics[:] = [0.5, 5e-13, 1e-3j, -1e-9]
    np.testing.assert_allclose(found.phases, [[0.0, np.nan, 90.0, 180.0]])


# --- what is handed on ------------------------------------------------------------------------------------------------


def swings(count, **changes):
    """Settled motions in which no two numbers are equal."""
    blank = Swing.blank(count)
    own = {name: numbers(*values.shape, at=k + 1.0) for k, (name, values) in enumerate(vars(blank).items())}
    own |= {"period": 2 + np.arange(count), "resting": np.arange(count) == 1, "outcome": np.zeros(count, dtype=np.int8)}
    return Swing(**(own | {"harmonics": own["harmonics"] * np.exp(0.5j)} | changes))


def test_each_variable_holds_its_number_of_the_swing_and_the_linear_stroke_that_of_motions_that_ran(monkeypatch):
    """The first of four members has no damping, the second ended; the others have frequencies of their own."""
    model = ConeModel(damping_ratio=[0.0, 0.1, 0.2, 0.3], drive_frequency=[0.5, 0.6, 0.7, 0.8], film="taut")
    own = swings(3, outcome=np.array([4, 0, 0], dtype=np.int8))
    asked = record(
        monkeypatch, module, settled_swing=own,
        linear_response=lambda members, omega: SimpleNamespace(stroke=10.0 * omega),
    )  # fmt: skip
    options, shares = {"transient": 11.0, "patience": 12.0, "tolerance": 2e-9}, []
    states = numbers(4, 2, at=0.5)
    found = settled(model, states, **options, threads=5, progress=shares.append)
    ((search,), (linear,)) = asked.values()
    np.testing.assert_array_equal(search["states"], states[1:])
    assert search["members"].damping_ratio.tolist() == [0.1, 0.2, 0.3]
    assert {name: search[name] for name in options} == options
    assert (search["threads"], search["source"], search["only_extent"]) == (5, True, False)
    assert search["progress"] == shares.append
    assert linear["model"].damping_ratio.tolist() == [0.2, 0.3]
    assert linear["frequencies"].tolist() == [[0.7], [0.8]]
    np.testing.assert_array_equal(found["linear_stroke"], [np.nan, np.nan, 7.0, 8.0])
    expected = {
        "stroke": own.highest - own.lowest, "lowest": own.lowest, "highest": own.highest, "mean": own.mean,
        "period": [2, 0, 4], "resting": [0, 1, 0],
        "harmonic_amplitude": np.abs(own.harmonics), "harmonic_phase": own.phases,
    }  # fmt: skip
    expected |= {name: own.source[:, list(MEANINGS).index(name)] for name in known_of(model.system)}
    for name, values in expected.items():
        np.testing.assert_allclose(found[name][1:], values, err_msg=name)
    assert {"current", "power", "apparent_power", "field"} <= expected.keys()
    assert found["harmonic"].values.tolist() == [1, 2, 3, 4]
    assert found["outcome"].values.tolist() == [Outcome.ERROR, 4, 0, 0]
    assert json.loads(found.attrs["options"]) == options


def test_motions_are_swung_on_the_cycles_that_the_search_found_or_from_where_it_ended(monkeypatch):
    """Of four motions the third ended; on the last there is no cycle."""
    cycles = SimpleNamespace(
        found=np.array([True, True, False]), point=numbers(3, 2, at=5.0), period=np.array([3, 1, 7]),
        resting=np.array([False, True, False]),
    )  # fmt: skip
    rows, taken = [0, 1, 3], []
    reached = SimpleNamespace(
        outcome=np.array([0, 0, 4, 0], dtype=np.int8), state=numbers(4, 2, at=6.0),
        cycles=SimpleNamespace(take=lambda of: taken.append(of.tolist()) or cycles),
    )  # fmt: skip
    asked = record(monkeypatch, swing_module, search=reached, swing=swings(3))
    members, states = ConeModel(damping_ratio=0.1, voltage=[0.1, 0.2, 0.3, 0.4]).members(), numbers(4, 2)
    budgets, flow, shares = {"transient": 11.0, "patience": 12.0}, {"tolerance": 2e-9, "threads": 5}, []
    found = settled_swing(members, states, **budgets, **flow, only_extent=True, source=True, progress=shares.append)
    ((search,), (swung,)) = asked.values()
    assert {name: search[name] for name in (budgets | flow)} == budgets | flow
    assert search["progress"] == shares.append
    np.testing.assert_array_equal(search["states"], states)
    np.testing.assert_array_equal(swung["states"], [*numbers(3, 2, at=5.0)[:2], numbers(4, 2, at=6.0)[3]])
    assert swung["period"].tolist() == [3, 1, 0]
    assert swung["members"].number("voltage").tolist() == [0.1, 0.2, 0.4]
    assert {name: swung[name] for name in flow} == flow
    assert (swung["only_extent"], swung["source"]) == (True, True)
    assert taken == [rows]
    np.testing.assert_array_equal(found.lowest, [*swings(3).lowest[:2], np.nan, swings(3).lowest[2]])
    assert found.resting.tolist() == [False, True, False, False]
    assert found.outcome.tolist() == [0, 0, 4, 0]


@pytest.mark.parametrize("only_extent", [False, True])
def test_a_swing_is_sampled_over_whole_turns_and_drive_periods(monkeypatch, only_extent):
    """A cycle of three forcing periods over six, one of two over two, and what has no period over 24; source and
    harmonics are taken at each second sample."""
    periods, runs = np.array([3, 0, 2, 3]), []

    def sampling(members, states, repeats, samples, **flow):
        count = members.size

        def validity(part, *, turn):
            runs[-1]["validity"] = part.number("voltage").tolist(), turn
            return np.zeros((count, SHAPE)) + 7.0

        runs.append({"states": states, "repeats": repeats, "samples": samples, "flow": flow})
        at = 10.0 * len(runs)
        times = np.tile(np.arange(9.0), (count, 1))
        return SimpleNamespace(
            times=times, states=numbers(count, 9, 2, at=at), path=numbers(count, 4, 2, at=at + 1.0), validity=validity,
            outcome=np.full(count, len(runs), dtype=np.int8),
        )  # fmt: skip

    def source(members, times, states, begin, **flow):
        return {name: np.full(members.size, k + 0.5) for k, name in enumerate(MEANINGS)}

    SHAPE = Swing.blank(1).validity.shape[1]
    asked = record(
        monkeypatch, swing_module, sampled=sampling, electrical=source,
        extent=lambda members, times, states: (states[:, 0, 0], states[:, -1, 0]),
        harmonics_of=lambda members, x, samples: np.full((members.size, 4), x[:, :1] * 1j),
    )  # fmt: skip
    members, states = ConeModel(damping_ratio=0.1, voltage=[0.1, 0.2, 0.3, 0.4]).members(), numbers(4, 2)
    flow = {"tolerance": 2e-9, "threads": 5}
    found = swing(members, states, periods, only_extent=only_extent, source=not only_extent, **flow)
    assert [run["repeats"] for run in runs] == [24, 2, 6]
    for run, rows, own in zip(runs, ([1], [2], [0, 3]), range(1, 4), strict=True):
        at = 10.0 * own
        np.testing.assert_array_equal(run["states"], states[rows])
        assert (run["samples"], run["flow"]) == (swing_module.SAMPLES, flow)
        times, path = numbers(len(rows), 9, 2, at=at), numbers(len(rows), 4, 2, at=at + 1.0)
        np.testing.assert_array_equal(found.lowest[rows], times[:, 0, 0])
        np.testing.assert_array_equal(found.highest[rows], times[:, -1, 0])
        np.testing.assert_array_equal(found.final[rows], path[:, -1])
        np.testing.assert_array_equal(found.mean[rows], path[..., 0].mean(axis=1))
        assert found.outcome[rows].tolist() == [own] * len(rows)
        if not only_extent:
            assert run["validity"] == ([[0.1, 0.2, 0.3, 0.4][row] for row in rows], own > 1)
            call = asked["electrical"][own - 1]
            np.testing.assert_array_equal(call["times"], np.tile([2.0, 4.0, 6.0, 8.0], (len(rows), 1)))
            np.testing.assert_array_equal(call["states"], path)
            np.testing.assert_array_equal(call["begin"], states[rows])
            assert {name: call[name] for name in flow} == flow
            np.testing.assert_array_equal(found.harmonics[rows, 0], path[:, 0, 0] * 1j)
    if only_extent:
        assert not asked["electrical"]
        assert np.isnan(found.harmonics).all()
    else:
        np.testing.assert_array_equal(found.source, np.tile(np.arange(len(MEANINGS)) + 0.5, (4, 1)))
        assert {call["samples"] for call in asked["harmonics_of"]} == {swing_module.SAMPLES}


def test_every_integration_has_the_tolerance_and_the_threads_of_the_call(integrations):
    settled(SMALL, (0.3, 0.0), tolerance=2e-15, threads=2)
    assert integrations == {(2e-15, 2), (FIRST_TOLERANCE, 2)}

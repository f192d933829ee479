"""Settled motions by their cycles: over what they are sampled, their extremes, phases and harmonics."""

import importlib
from types import SimpleNamespace

import numpy as np
import pytest

from gelcone.motion.averages import AVERAGES
from gelcone.motion.electrical import MEANINGS
from gelcone.motion.swing import Swing, settled_swing, swing
from gelcone.physics.model import ConeModel
from tests.motion.swings import swings
from tests.recorded import numbers, record

swing_module = importlib.import_module("gelcone.motion.swing")


def test_rounding_is_that_of_the_largest_displacement_on_either_side():
    found = Swing.blank(1)
    found.lowest[:], found.highest[:] = -1.0, 1e-3
    found.harmonics[:] = [0.5, 5e-13, 1e-3j, -1e-9]
    np.testing.assert_allclose(found.phases, [[0.0, np.nan, 90.0, 180.0]])


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
        extremes=lambda members, start, repeats, motion, **own: (
            (motion.states[:, 0, 0], motion.states[:, -1, 0])
            if (own, repeats) == (flow, runs[-1]["repeats"]) and (start == runs[-1]["states"]).all()
            else (None, None)
        ),
        harmonics_of=lambda members, x, samples: np.full((members.size, 4), x[:, :1] * 1j),
        averages=lambda *given, **own: (np.full((1, len(AVERAGES)), np.nan), np.full(len(AVERAGES), 0.5)),
    )  # fmt: skip
    members, states = ConeModel(damping_ratio=0.1, voltage=[0.1, 0.2, 0.3, 0.4]).members(), numbers(4, 2)
    flow = {"tolerance": 2e-9, "threads": 5}
    found = swing(members, states, periods, only_extent=only_extent, source=not only_extent, **flow)
    assert [run["repeats"] for run in runs] == [24, 2, 6]
    if not only_extent:  # those of cycles have no error
        np.testing.assert_array_equal(found.errors[:, 0], [0.0, 0.5, 0.0, 0.0])
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


@pytest.mark.parametrize("turn", [1.0, 2.0])
def test_harmonics_are_those_of_which_a_displacement_is_made(turn):
    """x = sum of Im(h exp(i k omega t)), from one spacing after phase 0 on; a forcing period may be half a turn."""
    members = SimpleNamespace(
        drive_frequency=np.array([0.7, 1.1]), forcing_period=2.0 * np.pi / turn / np.array([0.7, 1.1]), shape=(2,)
    )
    harmonics = np.array([[0.5j, 0.2 - 0.1j, 0.03 + 0.04j, -0.01], [-0.3, 0.1j, 0.0, 0.02 + 0.01j]])
    samples = 16
    phases = 2.0 * np.pi / turn * np.arange(1, 2 * samples + 1) / samples
    waves = np.exp(1j * np.outer(swing_module.HARMONICS, phases))
    x = 0.4 + (harmonics[:, :, None] * waves).imag.sum(axis=1)
    np.testing.assert_allclose(swing_module.harmonics_of(members, x, samples), harmonics, atol=1e-15)


def test_amplitude_and_middle_are_those_of_the_turning_points_and_a_rest_has_no_period():
    found = Swing.blank(3)
    found.lowest[:], found.highest[:], found.period[:], found.resting[1] = (
        [-1.0, 0.2, 0.3],
        [0.5, 0.2, 0.4],
        [3, 1, 0],
        True,
    )
    np.testing.assert_allclose(found.amplitude, [0.75, 0.0, 0.05])
    np.testing.assert_allclose(found.middle, [-0.25, 0.2, 0.35])
    assert found.forcing_periods.tolist() == [3, 0, 0]
    found.harmonics[:] = 0.1
    np.testing.assert_array_equal(np.isfinite(found.phases).all(axis=1), [True, False, True])

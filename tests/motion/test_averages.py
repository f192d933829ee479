"""Averages of motions that do not repeat: their errors against other runs, closed forms, and motions that repeat."""

import numpy as np
import pytest

import gelcone
from gelcone.motion import averages
from gelcone.motion.electrical import MEANINGS
from gelcone.presets import find_preset


def test_errors_of_batch_means_are_those_of_independent_numbers_and_grow_with_correlation():
    rng = np.random.default_rng(3)
    blocks = rng.normal([1.0, 5.0], [0.1, 2.0], (400, 2))
    means, errors = averages.batch_means(blocks)
    np.testing.assert_allclose(means, blocks.mean(axis=0))
    np.testing.assert_allclose(errors, np.array([0.1, 2.0]) / 20.0, rtol=0.4)
    alike = np.repeat(blocks, 4, axis=0)  # four times the numbers, and not more known
    np.testing.assert_allclose(averages.batch_means(alike)[1], errors, rtol=0.3)


def test_the_error_of_a_mean_holds_a_slow_part_behind_a_fast_one():
    rng = np.random.default_rng(1)
    slow, fast = np.repeat(rng.normal(size=(16, 1000)), 8, axis=0), rng.normal(0.0, 3.0, (128, 1000))
    means, errors = averages.batch_means(slow + fast)
    assert (np.abs(means) < 3.0 * errors).mean() > 0.97


def test_batches_that_do_not_differ_have_no_error():
    np.testing.assert_array_equal(averages.batch_means(np.ones((64, 3)))[1], 0.0)


def test_points_repeat_after_a_lag_and_those_of_chaos_do_not():
    steps = np.arange(200)
    assert averages.repeats(np.stack([np.sin(2.0 * np.pi * steps / 7.0), np.cos(2.0 * np.pi * steps / 7.0)], axis=1))
    assert averages.repeats(1.0 + 1e-9 * np.random.default_rng(0).normal(size=(50, 1)))  # at rest, with rounding
    assert averages.repeats(1e-18 * np.random.default_rng(0).normal(size=(50, 2)))  # the same of a flat film
    assert not averages.repeats(np.random.default_rng(0).normal(size=(200, 2)))
    logistic = [0.3]
    for _ in range(399):
        logistic.append(4.0 * logistic[-1] * (1.0 - logistic[-1]))
    assert not averages.repeats(np.array(logistic)[:, None])


def test_the_error_of_a_record_is_that_of_many_records():
    """Noise that is constant in each period: mean and rms under the window scatter as the errors say."""
    rng, periods, each = np.random.default_rng(5), 128, 8
    window = np.sin(np.pi * np.arange(periods * each) / (periods * each)) ** 4
    means, roots, said = [], [], []
    for _ in range(200):
        record = np.repeat(rng.normal(size=periods), each)
        means.append((window * record).sum() / window.sum())
        roots.append(np.sqrt((window * (record - means[-1]) ** 2).sum() / window.sum()))
        said.append(averages.of_record(record, periods))
    np.testing.assert_allclose(np.mean(said, axis=0), [np.std(means), np.std(roots)], rtol=0.15)
    assert averages.of_record(np.tile(np.sin(np.arange(16) * np.pi / 4.0), 40), 80) == (0.0, 0.0)


CHAOTIC = find_preset("fast").model.replace(voltage=1.05)


def test_runs_from_starts_next_to_each_other_agree_within_their_errors():
    model = CHAOTIC.replace(voltage=float(CHAOTIC.voltage) * (1.0 + 1e-12 * np.arange(2)))
    found = gelcone.settled(model, initial=(1.0, 0.0))
    assert (found["period"] == 0).all()
    for name in averages.AVERAGES:
        if name not in found:
            continue
        one, other = found[name].values
        error = found[f"{name}_standard_error"].values
        assert (error > 0.0).all(), name
        assert one != other, name
        assert abs(one - other) < 4.0 * np.hypot(*error), name
        assert found[f"{name}_standard_error"].attrs["units"] == found[name].attrs["units"]


def test_averages_of_motions_that_repeat_have_no_error():
    model = gelcone.ConeModel(voltage=0.3, voltage_bias=0.6, rest_height=0.8, hoop_prestretch=1.4)
    found, lines = gelcone.settled(model), gelcone.spectrum(model)
    assert float(found["power_standard_error"]) == float(found["mean_standard_error"]) == 0.0
    assert float(lines["rms_standard_error"]) == float(lines["mean_displacement_standard_error"]) == 0.0


def test_extremes_have_no_error():
    assert set(MEANINGS) - set(averages.AVERAGES) == {"current", "field"}
    assert averages.BATCH % 2 == 0  # two forcing periods are a whole number of drive periods


@pytest.mark.parametrize("analysis", ["section", "extrema", "spectrum", "settled", "regime"])
def test_every_answer_about_chaos_says_that_another_run_differs(command_line, analysis):
    code, out, err = command_line(analysis, "--preset", "fast", "--set", "voltage=1.05")
    assert code == 0, err
    assert out.count("the motion does not repeat: numbers are of one run, those of another differ") == 1
    code, out, _ = command_line(analysis, "biased-pump")
    assert (code, "another differ" in out) == (0, False)

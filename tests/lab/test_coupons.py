"""What is made of the tests in a table: clocks, rates, repeats, temperatures."""

import dataclasses
from pathlib import Path

import numpy as np
import pytest

from gelcone.lab.coupons import LOADING_RATE, same_temperature
from gelcone.lab.measured import read_tests

VHB = Path(__file__).parents[2] / "docs" / "measured" / "vhb"


@pytest.fixture(scope="module")
def vhb():
    """All tests on VHB, read without a list."""
    return read_tests(*sorted(VHB.glob("*.csv")))


def by_id(tests):
    return {test.name.split()[-1]: test for test in tests}


def test_all_of_them_are_read_without_a_hand(vhb):
    kinds = [(test.kind, test.use) for test in vhb.coupons]
    assert kinds.count(("cyclic", "fit")) == 9
    assert kinds.count(("relaxation", "fit")) == 4
    assert kinds.count(("quasi-static", "fit")) == 1
    assert kinds.count(("quasi-static", "leave out")) == 2
    assert [len(spectrum.frequency) for spectrum in vhb.spectra] == [40] * 5
    assert sum(len(test.stress) for test in vhb.coupons) == 147 + 473 + 73 + 52


def test_the_list_reads_as_the_files_alone(vhb):
    listed = by_id(read_tests(VHB / "tests.toml").coupons)
    for name, test in by_id(vhb.coupons).items():
        for field in ("time", "stretch", "stress"):
            np.testing.assert_array_equal(getattr(listed[name], field), getattr(test, field))


@pytest.mark.parametrize(
    ("test", "note"),
    [
        ("101", "its clock starts at 900 s, one step: the hold is taken to begin with the first sample"),
        ("101", "its loading is not recorded: taken as 0.005 1/s (loading_rate in tests.toml)"),
        ("116", "starts with a stress of -1.06 kPa, below 0: taken as it is"),
        ("128", "starts at stretch 0.9968, below 1: taken as it is"),
        ("130", "its unloading is cut at stretch 1.755, where the stress has come to 0"),
        ("201", "has neither time nor rate: taken as quasi-static, with all branches relaxed"),
        ("202", "repeats the first 24 rows of vhb-quasi-static 201: left out"),
        ("203", "repeats the first 11 rows of vhb-quasi-static 201: left out"),
        ("701", "is not UTF-8: read as Latin-1"),
        ("116", "letters were lost when it was exported (they read \ufffd), numbers were not"),
        ("116", "column 'stress' has no unit: taken as Pa"),
        ("116", "column 'temp' has no unit: taken as K"),
    ],
)
def test_each_quirk_is_named(vhb, test, note):
    assert any(own.startswith(note) for own in by_id(vhb.coupons)[test].notes)


def test_a_hold_begins_when_its_loading_ends(vhb):
    test = by_id(vhb.coupons)["102"]
    assert test.time[0] == pytest.approx((test.stretch[0] - 1.0) / LOADING_RATE)
    np.testing.assert_allclose(np.diff(test.time), 900.0)
    np.testing.assert_allclose(test.history[1], [1.0, *[2.0] * 13])


def test_time_follows_from_the_rate(vhb):
    test = by_id(vhb.coupons)["701"]
    top = int(np.argmax(test.stretch))
    assert test.time[top] == pytest.approx((test.stretch[top] - 1.0) / 0.2)
    assert test.time[-1] == pytest.approx((2.0 * test.stretch[top] - 1.0 - test.stretch[-1]) / 0.2)


def test_tests_at_another_temperature_are_left_out(vhb):
    temperature, tests = same_temperature(vhb.coupons)
    assert temperature == pytest.approx(293.15)
    assert by_id(tests)["701"].use == "fit"
    assert by_id(tests)["702"].use == "leave out"
    assert by_id(tests)["702"].notes[-1] == "at 50 degC, not at 20 degC as most: left out"


@pytest.mark.parametrize(
    ("heads", "factors"),
    [
        (("time (s)", "stress (Pa)", "temp (K)"), (1.0, 1.0, 0.0)),
        (("time (min)", "stress (kPa)", "temp (degC)"), (1 / 60.0, 1e-3, -273.15)),
        (("time (h)", "stress (MPa)", "temp (C)"), (1 / 3600.0, 1e-6, -273.15)),
        (("time (ms)", "stress (kPa)", "temp (K)"), (1e3, 1e-3, 0.0)),
        (("rate (1/s)", "stress (Pa)", "temp (K)"), (0.5, 1.0, 0.0)),
        (("rate (%/s)", "stress (Pa)", "temp (K)"), (50.0, 1.0, 0.0)),
        (("rate (1/min)", "stress (Pa)", "temp (K)"), (30.0, 1.0, 0.0)),
    ],
)
def test_a_test_is_the_same_in_any_units(heads, factors, tmp_path):
    """A stretch of 0.05 a second, or at that rate."""
    stretch, stress = np.array([1.0, 1.1, 1.2, 1.3]), np.array([0.0, 5e3, 9e3, 12.5e3])
    clock, size, zero = factors
    first = (stretch - 1.0) / 0.05 * clock if heads[0].startswith("time") else np.full(4, 0.1 * clock)
    rows = zip(first, stretch, size * stress, np.full(4, 300.0 + zero), strict=True)
    text = f"{heads[0]},stretch,{heads[1]},{heads[2]}\n" + "\n".join(",".join(f"{v:.12g}" for v in row) for row in rows)
    (tmp_path / "pull.csv").write_text(text + "\n")
    (test,) = read_tests(tmp_path / "pull.csv").coupons
    np.testing.assert_allclose(test.time, (stretch - 1.0) / 0.05, atol=1e-9)
    np.testing.assert_allclose(test.stress, stress, atol=1e-9)
    assert (test.kind, test.temperature) == ("loading", pytest.approx(300.0))


def test_a_crowd_within_some_kelvin_counts_and_not_one_far_away(vhb):
    test = by_id(vhb.coupons)["701"]
    degrees = [20.0, 20.0, 40.0, 41.0, 42.0]
    tests = [dataclasses.replace(test, name=f"test {k}", temperature=t + 273.15) for k, t in enumerate(degrees)]
    chosen, found = same_temperature(tests)
    assert 312.0 < chosen < 316.0
    assert [own.use for own in found] == ["leave out"] * 2 + ["fit"] * 3


def test_a_clock_that_starts_at_the_hold_stays_as_it_is(tmp_path):
    (tmp_path / "hold.csv").write_text("time (s),stretch,stress (kPa)\n1,2,9\n10,2,8\n100,2,7\n1000,2,6\n")
    (test,) = read_tests(tmp_path / "hold.csv").coupons
    np.testing.assert_allclose(test.time - test.history[0][1], [1.0, 10.0, 100.0, 1000.0])


def test_a_hold_may_begin_where_the_list_says(tmp_path):
    (tmp_path / "hold.csv").write_text("time (s),stretch,stress (kPa)\n900,2,9\n1800,2,8\n2700,2,7\n3600,2,6\n")
    (tmp_path / "list.toml").write_text('[[test]]\nfile = "hold.csv"\nhold_from = "0 s"\nloading_rate = 0.5\n')
    (test,) = read_tests(tmp_path / "list.toml").coupons
    np.testing.assert_allclose(test.time, np.array([900.0, 1800.0, 2700.0, 3600.0]) + 2.0)


def test_long_tests_are_thinned_and_say_so(tmp_path):
    rows = "\n".join(f"{k},{1 + k / 5000},{k}" for k in range(5000))
    (tmp_path / "long.csv").write_text(f"time (s),stretch,stress (Pa)\n{rows}\n")
    (test,) = read_tests(tmp_path / "long.csv").coupons
    assert len(test.stress) == 400
    assert "thinned from 5000 to 400 samples" in test.notes
    assert (test.stress[0], test.stress[-1]) == (0.0, 4999.0)

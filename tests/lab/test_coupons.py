"""What is made of the tests in a table: clocks, rates, repeats, temperatures."""

import dataclasses
from pathlib import Path

import numpy as np
import pytest

from gelcone.errors import InputError
from gelcone.lab import coupons
from gelcone.lab.coupons import LOADING_RATE, ROLES, same_temperature
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
    (tmp_path / "list.toml").write_text('[[test]]\nfile = "hold.csv"\nhold_from = "1000 s"\n')
    with pytest.raises(InputError, match=r"^hold\.csv: hold_from = 1000 s: is after the first sample, at 900 s"):
        read_tests(tmp_path / "list.toml")


def test_a_test_of_as_many_samples_as_are_taken_is_not_thinned(read):
    (test,) = read(f"stretch,stress (Pa)\n{rows(1.0 + np.arange(400) / 400, np.arange(400.0))}").coupons
    assert len(test.stress) == 400
    assert not any("thinned" in note for note in test.notes)


def test_long_tests_are_thinned_and_say_so(tmp_path):
    rows = "\n".join(f"{k},{1 + k / 5000},{k}" for k in range(5000))
    (tmp_path / "long.csv").write_text(f"time (s),stretch,stress (Pa)\n{rows}\n")
    (test,) = read_tests(tmp_path / "long.csv").coupons
    assert len(test.stress) == 400
    assert "thinned from 5000 to 400 samples" in test.notes
    assert (test.stress[0], test.stress[-1]) == (0.0, 4999.0)


@pytest.fixture
def read(tmp_path):
    """The tests of a table and of its entry in a list."""

    def of(text, entry="", name="pull.csv"):
        (tmp_path / name).write_text(text)
        (tmp_path / "tests.toml").write_text(f'[[test]]\nfile = "{name}"\n{entry}')
        return read_tests(tmp_path / "tests.toml")

    return of


def rows(*columns):
    return "\n".join(",".join(f"{value:.12g}" for value in row) for row in zip(*columns, strict=True)) + "\n"


STRETCH, STRESS = np.array([1.0, 1.1, 1.3, 1.6]), np.array([0.0, 5e3, 9e3, 12.5e3])


@pytest.mark.parametrize(
    ("head", "columns", "entry"),
    [
        ("strain,stress (Pa)", (STRETCH - 1.0, STRESS), ""),
        ("strain (mm/mm),stress (Pa)", (STRETCH - 1.0, STRESS), ""),
        ("strain (%),stress (kPa)", (100.0 * (STRETCH - 1.0), 1e-3 * STRESS), ""),
        ("extension (mm),stress (Pa)", (20.0 * (STRETCH - 1.0), STRESS), 'gauge_length = "20 mm"\n'),
        ("stretch,force (mN)", (STRETCH, STRESS * 5e-3), 'specimen_width = "1 cm"\nthickness = "0.5 mm"\n'),
        ("lambda,F (N)", (STRETCH, STRESS * 5e-6), 'force = "F, N"\nspecimen_width = "5 mm"\nthickness = "1 mm"\n'),
    ],
)
def test_stretch_and_stress_follow_from_what_was_measured(read, head, columns, entry):
    (test,) = read(f"{head}\n{rows(*columns)}", entry).coupons
    np.testing.assert_allclose(test.stretch, STRETCH)
    np.testing.assert_allclose(test.stress, STRESS, atol=1e-9)
    assert (test.kind, test.width, test.mode, test.voltage) == ("quasi-static", "free", "uniaxial", 0.0)


@pytest.mark.parametrize(
    ("head", "entry", "message"),
    [
        ("extension (mm),stress (Pa)", "", "its extension needs gauge_length"),
        ("stretch,force (mN)", 'thickness = "1 mm"\n', "its force needs specimen_width"),
        ("stretch,force (mN)", 'specimen_width = "1 mm"\n', "its force needs thickness"),
        ("stretch,other", "", "no column is a stress .columns: stretch, other.; name it in tests.toml: stress"),
        ("stretch,force", 'specimen_width = "1 mm"\n', 'column "force" has no unit; write "force .N.", or name it'),
        ("stretch (mm),stress (Pa)", "", "stretch has no unit; 'mm' is one"),
        ("stretch,stress (V)", "", "'V' is not a unit of"),
        ("strain (mm),stress (Pa)", "", "column 'strain': 'mm' is not a unit of a strain; write it in %"),
    ],
)
def test_what_a_table_lacks_is_named(read, head, entry, message):
    with pytest.raises(InputError, match=message):
        read(f"{head}\n{rows(STRETCH, STRESS)}", entry)


def test_stresses_without_a_unit_are_pascals_where_an_elastomer_may_have_them(read):
    """The stress over the strain, of which no more than 2 counts, is from 2 kPa to 1 GPa at strains from 0.1 on."""
    stretch = np.array([1.0, 1.05, 3.5, 4.0])
    for size, fits in ((2.1e3, True), (1.9e3, False), (0.99e9, True), (1.01e9, False)):
        text = f"stretch,stress\n{rows(stretch, 2.0 * size * np.array([0.0, 0.5, 0.9, 1.0]))}"
        if fits:
            assert "column 'stress' has no unit: taken as Pa" in read(text).coupons[0].notes
            continue
        with pytest.raises(InputError, match=r"the largest stress is .*: is it in kPa or MPa\? write the unit"):
            read(text)
    assert len(read(f"stretch,stress\n{rows(1.0 + 0.09 * np.arange(4) / 3, np.arange(4.0))}").coupons) == 1


def test_rates_temperatures_and_voltages_are_those_of_each_test(read):
    text = "id,stretch,stress (Pa),rate (1/s),temp (degC),voltage (kV)\n"
    for name, rate, degrees, volts in (("a", 0.1, 20.0, 0.0), ("b", 0.5, 50.0, -2.0)):
        text += "".join(f"{name},{x},{y},{rate},{degrees},{volts}\n" for x, y in zip(STRETCH, STRESS, strict=True))
    a, b = read(text).coupons
    np.testing.assert_allclose(a.time, (STRETCH - 1.0) / 0.1)
    np.testing.assert_allclose(b.time, (STRETCH - 1.0) / 0.5)
    assert (a.temperature, b.temperature) == (pytest.approx(293.15), pytest.approx(323.15))
    assert (a.voltage, b.voltage, a.use, b.use) == (0.0, pytest.approx(2e3), "fit", "check")
    assert (a.name, b.name, a.kind, a.file) == ("pull a", "pull b", "loading", "pull.csv")


def test_settings_count_where_the_table_says_nothing(read):
    entry = (
        'rate = "0.2 1/s"\ntemperature = "30 degC"\nvoltage = "1 kV"\nthickness = "0.5 mm"\nmode = "pure shear"\n'
        'width = "held"\nuse = "fit"\n'
    )
    (test,) = read(f"stretch,stress (Pa)\n{rows(STRETCH, STRESS)}", entry).coupons
    np.testing.assert_allclose(test.time, (STRETCH - 1.0) / 0.2)
    assert (test.temperature, test.voltage, test.thickness) == (pytest.approx(303.15), 1e3, 5e-4)
    assert (test.mode, test.width, test.use) == ("pure shear", "held", "fit")


def test_a_spectrum_is_in_the_order_of_its_frequencies(read):
    text = "id,freq (Hz),dielec,temp (degC)\na,100,4,20\na,1,6,22\na,10,5,21\nb,1,3,40\n"
    a, b = read(text, name="eps.csv").spectra
    assert (a.frequency.tolist(), a.permittivity.tolist()) == ([1.0, 10.0, 100.0], [6.0, 5.0, 4.0])
    assert (a.temperature, b.temperature) == (pytest.approx(294.15), pytest.approx(313.15))
    assert (a.name, b.permittivity.tolist()) == ("eps a", [3.0])
    with pytest.raises(InputError, match=r"a relative permittivity of 0\.5 is below 1"):
        read("freq (Hz),dielec\n1,0.5\n2,3\n", name="eps.csv")


@pytest.mark.parametrize(
    ("kind", "stretch", "stress", "voltage", "note"),
    [
        ("cyclic", [1.0, 2.0, 1.031], [0.0, 100.0, 14.9], 0.0, "its unloading is cut at stretch 1.031"),
        ("cyclic", [1.0, 2.0, 1.029], [0.0, 100.0, 14.9], 0.0, None),
        ("cyclic", [1.0, 2.0, 1.031], [0.0, 100.0, 15.1], 0.0, None),
        ("loading", [1.0, 2.0, 1.031], [0.0, 100.0, 14.9], 0.0, None),
        ("loading", [1.0, 2.0, 3.0], [0.09, 50.0, 100.0], 10.0, "has no stress at its first stretch under voltage"),
        ("loading", [1.0, 2.0, 3.0], [0.11, 50.0, 100.0], 10.0, None),
        ("loading", [1.0, 2.0, 3.0], [0.09, 50.0, 100.0], 0.0, None),
        ("loading", [0.99, 2.0, 3.0], [0.0, 50.0, 100.0], 0.0, "starts at stretch 0.99, below 1"),
        ("loading", [1.0, 2.0, 3.0], [-20.0, 50.0, 100.0], 0.0, "starts with a stress of -20 Pa, below 0"),
    ],
)
def test_what_is_odd_about_a_test_is_noted(vhb, kind, stretch, stress, voltage, note):
    test = dataclasses.replace(
        vhb.coupons[0], kind=kind, stretch=np.array(stretch), stress=np.array(stress), voltage=voltage
    )
    found = list(coupons._oddities(test))
    assert [own.startswith(note) for own in found] == [True] if note else found == []


def test_of_equal_tests_the_later_one_repeats_the_earlier_and_the_shorter_one_the_longer(vhb):
    test = vhb.coupons[0]
    half = dataclasses.replace(test, name="half", **{n: getattr(test, n)[:5] for n in ("time", "stretch", "stress")})
    twin, other = dataclasses.replace(test, name="twin"), dataclasses.replace(test, name="other", voltage=7.0)
    found = coupons._without_repeats([half, test, twin, other])
    assert [own.use for own in found] == ["leave out", test.use, "leave out", test.use]
    assert found[0].notes[-1] == f"repeats the first 5 rows of {test.name}: left out"
    assert found[2].notes[-1] == f"repeats the first {len(test.stress)} rows of {test.name}: left out"


def test_of_two_temperatures_with_as_many_tests_the_one_nearer_to_a_room_counts(vhb):
    test = vhb.coupons[0]
    tests = [dataclasses.replace(test, use="fit", name=str(t), temperature=t) for t in (333.15, 283.15, 333.15, 283.15)]
    chosen, found = same_temperature(tests)
    assert chosen == 283.15
    assert [own.use for own in found] == ["leave out", "fit"] * 2
    edge = [dataclasses.replace(test, use="fit", temperature=t) for t in (293.15, 298.15, 293.15)]
    assert [own.use for own in same_temperature(edge)[1]] == ["fit"] * 3
    assert np.isnan(same_temperature([dataclasses.replace(test, temperature=np.nan)])[0])


def test_a_rate_or_temperature_of_a_test_is_the_middle_one_of_its_rows(read):
    table = "stretch,stress (Pa),rate (1/s),temp (K)\n" + rows(
        STRETCH, STRESS, [9.0, 0.1, 0.2, 0.2], [0.0, 300, 301, 301]
    )
    (test,) = read(table).coupons
    np.testing.assert_allclose(test.time, (STRETCH - 1.0) / 0.2)
    assert test.temperature == 300.5


@pytest.mark.parametrize(("row", "stretch"), [(3, "0.0"), (4, "-0.25"), (2, "60.0")])
def test_a_stretch_that_is_none_is_named_with_its_line(row, stretch, tmp_path):
    rows = [f"{1.0 + 0.25 * k},{10.0 * k}" for k in range(8)]
    rows[row] = f"{stretch},5.0"
    path = tmp_path / "coupon.csv"
    path.write_text("\n".join(["stretch,stress (kPa)", *rows]) + "\n", encoding="utf-8")
    with pytest.raises(InputError, match=rf"line {row + 2}: stretch {float(stretch):.4g}: must be over 0 and at most"):
        read_tests(path)


NAMED = {role: ROLES[role] for role in ("stretch", "strain", "stress", "force", "extension")}


def coupon_of(tmp_path, length, pull, list_of_tests=""):
    """The test of a file whose headings are given, with what a list says of it."""
    rows = [f"{0.25 * k + (length in NAMED['stretch'])},{10.0 * k}" for k in range(8)]
    (tmp_path / "a.csv").write_text("\n".join([f"{length},{pull} (kPa)", *rows]) + "\n", encoding="utf-8")
    (tmp_path / "tests.toml").write_text(f'[[test]]\nfile = "a.csv"\n{list_of_tests}', encoding="utf-8")
    (test,) = read_tests(tmp_path / "tests.toml").coupons
    return test


@pytest.mark.parametrize("pull", ["stress", "nominal stress", "engineering stress"])
@pytest.mark.parametrize("length", ["stretch", "stretch ratio", "strain", "engineering strain", "nominal strain"])
def test_stresses_and_strains_are_nominal(length, pull, tmp_path):
    test = coupon_of(tmp_path, length, pull)
    np.testing.assert_allclose(test.stress, 1e4 * np.arange(8))
    np.testing.assert_allclose(test.stretch, 1.0 + 0.25 * np.arange(8))
    assert np.isnan(test.thickness)  # what is not stated is not assumed


@pytest.mark.parametrize(
    ("length", "pull"), [(f"{kind} strain", "stress") for kind in ("true", "log", "Hencky")]
    + [("stretch", f"{kind} stress") for kind in ("true", "Cauchy")],
)  # fmt: skip
def test_true_stresses_and_strains_are_not_taken_for_nominal_ones(length, pull, tmp_path):
    with pytest.raises(InputError, match=r"stress|stretch|strain"):
        coupon_of(tmp_path, length, pull)


def test_a_note_about_one_test_is_not_one_about_the_next(tmp_path):
    rows = [f"{name},{1.0 + 0.25 * k},{10.0 * k}" for name in ("a", "b", "c") for k in range(8)]
    rows[3] = "a,,30.0"
    rows[9] = rows[10] = "b,1.3,"
    path = tmp_path / "coupon.csv"
    path.write_text("\n".join(["id,stretch,stress (kPa)", *rows]) + "\n", encoding="utf-8")
    left = [[note for note in test.notes if "left out" in note] for test in read_tests(path).coupons]
    assert left == [["1 rows without stretch or stress left out"], ["2 rows without stretch or stress left out"], []]

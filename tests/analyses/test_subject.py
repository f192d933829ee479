"""What an analysis is asked about, read from text without the command line."""

import numpy as np
import pytest

from gelcone import InputError, Normal, Uniform, find_device
from gelcone.analyses.subject import (
    read_over,
    read_settings,
    read_states,
    read_subject,
    read_uncertain,
    read_value,
    read_values,
)


def test_over_reads_ranges_and_lists_in_their_order():
    swept = read_over(["voltage=0:2:5", "stretch_limit=1, 10, inf"])
    assert list(swept) == ["voltage", "stretch_limit"]
    assert swept["voltage"].tolist() == [0.0, 0.5, 1.0, 1.5, 2.0]
    assert swept["stretch_limit"].tolist() == [1.0, 10.0, np.inf]


def test_over_reads_the_units_of_a_device():
    device = find_device("paper-table1")
    swept = read_over(["voltage=0 V:1 kV:3", "drive_frequency=1 Hz,2 Hz", "spring_stiffness=10 N/m,0.1 N/mm"], device)
    scales = device.scales
    np.testing.assert_allclose(swept["voltage"] * scales.voltage, [0.0, 500.0, 1000.0])
    np.testing.assert_allclose(swept["drive_frequency"] * scales.frequency, [1.0, 2.0])
    np.testing.assert_allclose(swept["spring_stiffness"] * scales.force / scales.length, [10.0, 100.0])


@pytest.mark.parametrize(
    ("over", "message"),
    [
        ("voltage", "must be name=from:to:count"),
        ("=1,2", "must be name=from:to:count"),
        ("voltage=", "must be name=from:to:count"),
        ("voltge=0:1:3", "did you mean 'voltage'"),
        ("law=1,2", "not a numeric model parameter"),
        ("voltage=1", "has one point"),
        ("voltage=0:1:1", "has 1 points"),
        ("voltage=2:0:5", "empty or reversed"),
        ("voltage=1:1:5", "empty or reversed"),
        ("voltage=0,2,1", "must increase"),
        ("voltage=0,1,1", "must increase"),
        ("voltage=0:1", "must be a number"),
        ("voltage=0:inf:3", "must be finite"),
        ("voltage=-1,1", "must be at least 0"),
        ("voltage=0 V:1 V:3", "units need a device"),
        ("drive_frequency=0,1", "must be greater than 0"),
    ],
)
def test_over_refuses_what_is_no_sweep(over, message):
    with pytest.raises(InputError, match=message):
        read_over([over])


def test_over_refuses_a_name_given_twice_and_a_unit_of_another_kind():
    with pytest.raises(InputError, match="given twice"):
        read_over(["voltage=0,1", "voltage=0,2"])
    with pytest.raises(InputError, match="Hz is a unit of frequency, not of voltage"):
        read_over(["voltage=0 Hz,1 Hz"], find_device("paper-table1"))


@pytest.mark.parametrize("over", ["drive_frequency=1:20 Hz:5", "drive_frequency=1,2 Hz"])
def test_over_refuses_bare_numbers_among_units(over):
    with pytest.raises(InputError, match="'1': has no unit"):
        read_over([over], find_device("paper-table1"))


def test_values_may_be_one_and_in_any_order():
    assert read_values("--voltages", "1", "voltage").tolist() == [1.0]
    assert read_values("--voltages", "1,0", "voltage").tolist() == [1.0, 0.0]


@pytest.mark.parametrize(
    ("text", "value"),
    [
        ("1.5", 1.5),
        ("-2e-3", -0.002),
        ("inf", np.inf),
        ("1,2.5", [1.0, 2.5]),
        ("0:2:5", [0.0, 0.5, 1.0, 1.5, 2.0]),
        ("-1:1:2", [-1.0, 1.0]),
        ("50 mm", "50 mm"),
        ("radial", "radial"),
        ("PVC-DBA 4:1", "PVC-DBA 4:1"),
    ],
)
def test_values_are_numbers_lists_ranges_or_text(text, value):
    np.testing.assert_array_equal(read_value(text), value)


def test_settings_keep_what_follows_the_first_equals_sign():
    assert read_settings(("name=a=b", " voltage = 1 ")) == {"name": "a=b", "voltage": 1.0}


def test_an_axis_of_a_basin_that_is_not_given_takes_its_default():
    swept = read_states(["velocity=-1,0,2"], None)
    np.testing.assert_array_equal(swept["displacement"], np.linspace(-2.0, 2.0, 81))
    np.testing.assert_array_equal(swept["velocity"], [-1.0, 0.0, 2.0])
    device = find_device("soft-film")
    in_mm = read_states(["displacement=-5 mm:5 mm:3"], device)["displacement"]
    np.testing.assert_allclose(in_mm * device.scales.length, [-5e-3, 0.0, 5e-3], atol=1e-18)


def test_a_subject_needs_no_command_line():
    device = read_subject("soft-film", settings=["voltage=0.3"], initial="5 mm, 0 m/s")
    assert device.device == find_device("soft-film")
    assert device.model.voltage == 0.3
    assert device.initial[0] * device.device.scales.length == pytest.approx(5e-3)
    assert device.starts
    preset = read_subject(preset="base", settings=["damping_ratio=0.2"])
    assert (preset.model.damping_ratio, preset.initial, preset.starts) == (0.2, (1.0, 0.0), False)
    with pytest.raises(InputError, match="are both given; give one or the other"):
        read_subject("soft-film", preset="base")


def test_an_ensemble_or_an_initial_state_is_refused_where_it_makes_no_sense():
    with pytest.raises(InputError, match="map starts from one actuator, not 2; sweep a parameter with --over"):
        read_subject(settings=["voltage=0.1,0.2"]).alone("map")
    with pytest.raises(InputError, match="--initial: a basin does not take it"):
        read_subject(initial="0.5,0").without_initial("a basin does not take it")
    read_subject().without_initial("never said")


def test_uncertain_parameters_are_read():
    spread = read_uncertain(["prestretch=1~0.02", "voltage=0.1:0.3"])
    assert spread == {"prestretch": Normal(1.0, 0.02), "voltage": Uniform(0.1, 0.3)}
    for text in ("prestretch=1", "=1~0.1", "prestretch=a~b"):
        with pytest.raises(InputError, match="must be name="):
            read_uncertain([text])

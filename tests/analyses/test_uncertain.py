"""Distributions and columns of draws, from text."""

import numpy as np
import pytest

from gelcone import InputError, Normal, Uniform
from gelcone.analyses.request import read_subject
from gelcone.analyses.uncertain import read_drawn, read_uncertain


def test_a_range_that_the_material_states_is_drawn_by_its_name():
    device = read_subject("biased-pump")
    spread = read_uncertain(["material.shear_modulus", "film_thickness=1e-4:2e-4"], device)
    low, high = device.device.material.shear_modulus_range
    assert spread["material.shear_modulus"] == Uniform(low, high)
    acrylic = read_subject("biased-pump", settings=["material=VHB 4910", "film=taut"])
    spread = read_uncertain(["material.relative_permittivity"], acrylic)
    assert spread["material.relative_permittivity"] == Uniform(3.59, 4.73)
    own = read_subject("biased-pump", settings=["material.shear_modulus=9 kPa"])
    with pytest.raises(InputError, match=r"states no range of it; give material\.shear_modulus=low:high"):
        read_uncertain(["material.shear_modulus"], own)
    for text in ("film_thickness", "material.stretch_limit", "material"):
        with pytest.raises(InputError, match="must be name=low:high or name=mean~deviation"):
            read_uncertain([text], device)


def test_uncertain_parameters_are_read():
    alone, device = read_subject(settings=["damping_ratio=0.1"]), read_subject("soft-film")
    spread = read_uncertain(["prestretch=1~0.02", "voltage=0.1:0.3"], alone)
    assert spread == {"prestretch": Normal(1.0, 0.02), "voltage": Uniform(0.1, 0.3)}
    for text in ("prestretch=1", "=1~0.1", "prestretch=a~b"):
        with pytest.raises(InputError, match=r"must be (name=|a number)"):
            read_uncertain([text], alone)
    spread = read_uncertain(["film_thickness=0.2 mm~10 um", "frequency=8:10"], device)
    assert spread == {"film_thickness": Normal(2e-4, 1e-5), "frequency": Uniform(8.0, 10.0)}
    for text in ("spring_rate=15 N/m~3%", "spring_rate=15 ~ 3 %", "spring_rate=15 N/m~0.45 N/m"):
        spread = read_uncertain([text], device)["spring_rate"]
        assert (spread.mean, spread.deviation) == (15.0, pytest.approx(0.45, rel=1e-15))
    assert read_uncertain(["prestretch=1.2~5%"], alone)["prestretch"].deviation == pytest.approx(0.06, rel=1e-15)
    for text, message in {
        "spring_rate=15 N/m~-3%": "--uncertain spring_rate = '-3%': must be greater than 0 and below 10",
        "voltage_offset=0~3%": "--uncertain voltage_offset = '3%': is a share of 0; give the deviation with a unit",
        "voltage=1~0.1": "did you mean 'voltage_amplitude'",
        "frequency=8:9 Hz": "8 has no unit, but the others do",
        "spring_rate=20 N/m:10 N/m": "--uncertain spring_rate=20 N/m:10 N/m: 20:10: a uniform distribution goes",
    }.items():
        with pytest.raises(InputError, match=message):
            read_uncertain([text], device)
    with pytest.raises(InputError, match="--set damping_ratio: is drawn by --uncertain"):
        read_uncertain(["damping_ratio=0.1:0.2"], alone)


def test_a_drawn_column_is_in_the_unit_of_its_header():
    device, numbers = read_subject("soft-film", settings=["frequency=9"]), np.array([1.0, 2.0])
    np.testing.assert_allclose(read_drawn("d.csv: a", "film_thickness", numbers, "mm", device), [1e-3, 2e-3])
    assert read_drawn("d.csv: a", "prestretch", numbers, "1", device) is numbers
    assert read_drawn("d.csv: a", "voltage", numbers, "", read_subject()) is numbers
    for subject, name, unit, message in (
        (device, "frequency", "Hz", "--set frequency: is drawn by --uncertain d.csv; leave one of them out"),
        (device, "film_thickness", "",
         "d.csv: film_thickness: has no unit; write it into the header, as in film_thickness [um]"),
        (read_subject(), "voltage", "V",
         "d.csv: voltage [V]: a model without a device is dimensionless; leave the unit out"),
    ):  # fmt: skip
        with pytest.raises(InputError) as error:
            read_drawn(f"d.csv: {name}", name, numbers, unit, subject)
        assert str(error.value) == message

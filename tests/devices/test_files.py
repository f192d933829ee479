"""Where a device file is wrong, and which devices ship."""

import pytest

from gelcone import find_device
from gelcone.devices.files import _line_of, located, shipped_devices, what_ships
from gelcone.devices.units import FieldError
from gelcone.errors import InputError

SOURCE = """\
# film_radius = "3 mm" was too small
name = "pump"
film_radius_note = 1
film_radius = "50 mm"
[material]
"shear_modulus" = 3
young_modulus = 4
[waveform]
component = "samples"
circuit = {component = "mine:Filter", filter_time = "2 ms"}
second_film_radius = 1
"""


@pytest.mark.parametrize(
    ("field", "line"),
    [
        ("film_radius", 4), ("material.shear_modulus", 6), ("material.young_modulus", 7), ("name", 2),
        ("waveform", 8), ("waveform.component", 8), ("filter_time", 10), ("moving_mass", None), ("modulus", None),
    ],
)  # fmt: skip
def test_a_field_is_found_on_the_line_that_sets_it(field, line):
    """Not in comments, nor as a part of another name; of a table its head."""
    assert _line_of(field, SOURCE) == line


def test_an_error_has_the_file_and_the_line_where_there_is_one():
    error = FieldError("film_radius", "film_radius = 0: must be greater than 0")
    assert located("pump.toml", SOURCE, error) == f"pump.toml, line 4: {error}"
    assert located("pump.toml", "", error) == f"pump.toml: {error}"


def test_devices_that_ship_are_files_by_name():
    found = shipped_devices()
    assert {"biased-pump", "double-cone", "paper-table1"} <= set(found)
    assert all(path.stem == name and path.suffix == ".toml" and path.is_file() for name, path in found.items())
    assert list(found) == sorted(found)
    assert what_ships("zzz") == f"give a TOML file or a name; devices that ship: {', '.join(found)}"


@pytest.mark.parametrize(
    ("name", "near"),
    [("biased", "biased-pump"), ("pump", "biased-pump"), ("snapcone", "snap-cone"), ("biased-pump.tml", "biased-pump")],
)
def test_a_name_that_does_not_ship_suggests_the_one_that_does(name, near):
    with pytest.raises(InputError) as error:
        find_device(name)
    assert str(error.value) == f"{name}: there is no such file; did you mean '{near}', which ships?"


def test_a_file_that_is_not_there_is_no_part_of_a_name():
    with pytest.raises(InputError, match=r"pump\.tml: there is no such file; give a TOML file or a name"):
        find_device("pump.tml")


def test_a_device_is_found_by_name_or_file_only():
    with pytest.raises(InputError, match="find_device: was given the number 3; give a name or a TOML file"):
        find_device(3)

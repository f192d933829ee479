"""Draws from the command line: distributions, or tables within bounds."""

import numpy as np
import pytest
import xarray as xr

import gelcone
from gelcone.analyses import draws
from gelcone.analyses.draws import drawn_options, read_draws
from gelcone.analyses.request import Subject, read_subject
from gelcone.devices.device import find_device
from gelcone.errors import DoubtfulInput, InputError
from gelcone.physics.model import ConeModel
from gelcone.register.analyses import find_analysis

HOW = {"count": 8, "method": "sobol", "seed": 0, "indices": False}


def of_model():
    return Subject(ConeModel(), None, (1.0, 0.0))


def of_device():
    device = find_device("soft-film")
    return Subject(device.to_model(), device, None)


def table(tmp_path, text, name="draws.csv"):
    path = tmp_path / name
    path.write_text(text, encoding="utf-8")
    return str(path)


def test_a_table_is_read_as_it_comes(tmp_path):
    path = table(tmp_path, "voltage,prestretch\n0.5,1.0\n0.7,1.1\n\n0.9,1.2\n")
    found = read_draws([path], of_model(), **HOW)
    assert {name: values.tolist() for name, values in found.items()} == {
        "voltage": [0.5, 0.7, 0.9],
        "prestretch": [1.0, 1.1, 1.2],
    }


def test_columns_of_a_device_have_units(tmp_path):
    path = table(tmp_path, "film_thickness [um], prestretch ,material.shear_modulus (kPa)\n100,1.3,8\n90,1.2,9\n")
    found = read_draws([path], of_device(), **HOW)
    np.testing.assert_allclose(found["film_thickness"], [1e-4, 9e-5])
    np.testing.assert_allclose(found["material.shear_modulus"], [8e3, 9e3])
    np.testing.assert_allclose(found["prestretch"], [1.3, 1.2])


def test_a_netcdf_table_is_the_same_as_csv(tmp_path):
    data = xr.Dataset({"film_thickness": ("draw", [100.0, 90.0], {"units": "um"}), "prestretch": ("draw", [1.3, 1.2])})
    gelcone.save(data, tmp_path / "draws.nc")
    found = read_draws([str(tmp_path / "draws.nc")], of_device(), **HOW)
    np.testing.assert_allclose(found["film_thickness"], [1e-4, 9e-5])
    assert found["prestretch"].tolist() == [1.3, 1.2]


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", "is empty"),
        ("voltage\n1\n", "has 1 draws; give 2 to 100000"),
        ("voltage,voltage\n1,2\n3,4\n", "has two columns 'voltage'"),
        ("voltage,prestretch\n1,2\n3\n4,5\n", "line 3: has 1 cells for 2 columns"),
        ("voltage,prestretch\n1,2\n0,5,3\n", "line 3: has 3 cells for 2 columns; decimal commas need semicolons"),
        ("voltage\n1\nhigh\n", "line 3: column 'voltage' holds 'high'; give one number a cell"),
        ("voltage [V\n1\n2\n", "bracket that is not closed"),
        ("voltage [V]\n1\n2\n", "is dimensionless; leave the unit out"),
        ("volts\n1\n2\n", "volts"),
        (",".join(f"p{k}" for k in range(70)) + "\n", "has 70 columns; give at most 64"),
    ],
)
def test_bad_tables_are_refused(tmp_path, text, message):
    with pytest.raises(InputError, match=message.replace("[", r"\[")):
        read_draws([table(tmp_path, text)], of_model(), **HOW)


def test_decimal_commas_of_a_table_are_read_with_a_warning(tmp_path):
    path = table(tmp_path, "voltage;prestretch\n0,5;1\n0,7;1,1\n")
    with pytest.warns(DoubtfulInput, match="decimals are written with commas: 0,5 is 0.5"):
        assert read_draws([path], of_model(), **HOW)["voltage"].tolist() == [0.5, 0.7]


def test_tables_have_bounds(tmp_path, monkeypatch):
    monkeypatch.setattr(draws, "MOST_DRAWS", 3)
    assert read_draws([table(tmp_path, "voltage\n" + "1\n" * 3)], of_model(), **HOW)["voltage"].size == 3
    gelcone.save(xr.Dataset({"voltage": ("draw", np.ones(3))}), tmp_path / "few.nc")
    assert read_draws([str(tmp_path / "few.nc")], of_model(), **HOW)["voltage"].size == 3
    text = "voltage\n" + "1\n" * 4
    with pytest.raises(InputError, match="give 2 to 3"):
        read_draws([table(tmp_path, text)], of_model(), **HOW)
    gelcone.save(xr.Dataset({"voltage": ("draw", np.ones(4))}), tmp_path / "draws.nc")
    with pytest.raises(InputError, match="of 2 to 3 draws"):
        read_draws([str(tmp_path / "draws.nc")], of_model(), **HOW)


@pytest.mark.parametrize(
    "data",
    [
        xr.Dataset({"voltage": (("chain", "draw"), np.ones((2, 3)))}),
        xr.Dataset({"voltage": ("draw", ["a", "b"])}),
        xr.Dataset({"voltage": 1.0}),
    ],
)
def test_netcdf_tables_have_one_dimension_and_numbers(tmp_path, data):
    gelcone.save(data, tmp_path / "draws.nc")
    with pytest.raises(InputError, match=r"one dimension|variables of numbers"):
        read_draws([str(tmp_path / "draws.nc")], of_model(), **HOW)


def test_a_table_names_its_units_and_stands_alone(tmp_path):
    path = table(tmp_path, "film_thickness\n1\n2\n")
    with pytest.raises(InputError, match=r"has no unit; write it into the header, as in film_thickness \["):
        read_draws([path], of_device(), **HOW)
    with pytest.raises(InputError, match="give it alone"):
        read_draws([path, "voltage=0:1"], of_model(), **HOW)
    with pytest.raises(InputError, match="no such file"):
        read_draws(["nowhere.csv"], of_model(), **HOW)


def test_two_distributions_are_arranged_for_indices_where_that_is_possible():
    two = ["voltage=0:1", "prestretch=1~0.1"]
    how = HOW | {"indices": True}
    assert len(read_draws(two, of_model(), **how)["voltage"]) == 16
    assert len(read_draws(two, of_model(), **HOW)["voltage"]) == 8
    assert len(read_draws(two, of_model(), **(how | {"count": 10}))["voltage"]) == 10
    assert len(read_draws(two[:1], of_model(), **how)["voltage"]) == 8
    assert read_draws([], of_model(), **how) == {}


@pytest.mark.parametrize("count", [2, draws.MOST_COLUMNS])
def test_a_table_has_as_many_parameters_as_are_allowed(count, monkeypatch, tmp_path):
    """And of so few draws: two."""
    monkeypatch.setattr(
        draws, "read_drawn", lambda option, name, numbers, unit, subject: (option, numbers.tolist(), unit)
    )
    names = [f"p{k}" for k in range(count)]
    text = f"{','.join(names)}\n{','.join(['1'] * count)}\n{','.join(['2'] * count)}\n"
    path = table(tmp_path, text)
    assert read_draws([path], of_model(), **HOW) == {name: (f"{path}: {name}", [1.0, 2.0], "") for name in names}
    with pytest.raises(InputError, match=f"has {draws.MOST_COLUMNS + 1} columns; give at most {draws.MOST_COLUMNS}"):
        read_draws([table(tmp_path, ",".join(["a"] * (draws.MOST_COLUMNS + 1)) + "\n1\n2\n")], of_model(), **HOW)
    gelcone.save(xr.Dataset({name: ("draw", [1.0, 2.0], {"units": "mm"}) for name in names}), tmp_path / "draws.nc")
    assert list(read_draws([str(tmp_path / "draws.nc")], of_model(), **HOW)) == names


def test_axes_of_an_analysis_of_draws_are_in_si_units_of_a_device_alone():
    """Scales differ from draw to draw, so that a frequency is another number in each."""
    analysis = find_analysis("frequency")
    device = read_subject("biased-pump", film="taut")
    found = drawn_options(analysis, device, {"over": ["frequency=8 Hz:10 Hz:3"]})
    np.testing.assert_allclose(found["frequencies"], [8.0, 9.0, 10.0])
    found = drawn_options(analysis, read_subject(), {"over": ["drive_frequency=0.5:1:3"]})
    assert found["frequencies"].tolist() == [0.5, 0.75, 1.0]
    assert "over" not in found

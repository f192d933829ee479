"""A type checker, completion and help know the names of gelcone, of devices and of materials."""

import inspect
from pathlib import Path

import pytest

import gelcone
from gelcone.devices.fields import DeviceFields
from gelcone.devices.given import DeviceValues, MaterialValues, Number, Text

RIGHT = """
import gelcone

pump = gelcone.find_device("biased-pump")
gelcone.regime(pump.replace(film_thickness="0.3 mm", frequency=[8.0, 9.0]))
pump.replace({"material.shear_modulus": "9 kPa"}, voltage_offset=0)
gelcone.Material(shear_modulus="8 kPa", relative_permittivity=6, stretch_limit=50.0)
"""
WRONG = {
    "gelcone.regim(pump)": 'Module has no attribute "regim"; maybe "regime"?',
    "gelcone.Device(disc_radiu=3)": 'Unexpected keyword argument "disc_radiu" for "Device"',
    "pump.replace(film_thicknes=3)": 'Unexpected keyword argument "film_thicknes" for "replace" of "Device"',
    "pump.replace(film_thickness={})": 'Argument "film_thickness" to "replace" of "Device" has incompatible type',
    "gelcone.Material(shear_modulu=3)": 'Unexpected keyword argument "shear_modulu" for "Material"',
}


@pytest.mark.slow
def test_a_type_checker_refuses_what_does_not_exist(tmp_path, monkeypatch):
    from mypy import api

    root = Path(__file__).parents[2]
    script = tmp_path / "script.py"
    script.write_text(RIGHT + "\n".join(WRONG) + "\n")
    monkeypatch.setenv("MYPYPATH", str(root / "src"))
    monkeypatch.chdir(root)
    told, _, _ = api.run(["--follow-imports=silent", "--cache-dir", str(root / ".mypy_cache"), str(script)])
    errors = [line.partition("error: ")[2] for line in told.splitlines() if "script.py" in line and "error: " in line]
    assert len(errors) == len(WRONG), told
    for error, expected in zip(errors, WRONG.values(), strict=True):
        assert error.startswith(expected)


@pytest.mark.parametrize(("values", "kind"), [(DeviceValues, DeviceFields), (MaterialValues, gelcone.Material)])
def test_every_field_can_be_given(values, kind):
    assert list(values.__annotations__) == list(kind.fields)
    for name, field in kind.fields.items():
        told = inspect.get_annotations(values, eval_str=True)[name]
        assert told != Number or field.unit, name
        assert told != Text or not field.unit, name


@pytest.mark.parametrize("kind", [gelcone.Device, gelcone.Material])
def test_help_lists_the_fields_as_keywords(kind):
    known = inspect.signature(kind).parameters
    assert list(known) == list(kind.fields)
    assert known["name"].default is not inspect.Parameter.empty
    required = {name for name, field in kind.fields.items() if field.required}
    assert {name for name, one in known.items() if one.default is inspect.Parameter.empty} == required

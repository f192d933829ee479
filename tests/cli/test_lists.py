"""What ships, as it is listed: every number and source of each, in text and as JSON."""

import tomllib

import pytest

import gelcone
from gelcone.devices.files import shipped_devices
from gelcone.devices.materials import load_materials
from tests.answers import result


def test_every_device_has_name_title_and_file(command_line):
    lines = command_line("devices")[1].splitlines()
    listed = result(command_line("devices", "--json")[1])["result"]
    assert [lines[k : k + 3] for k in range(0, len(lines), 3)] == [
        [stem, f"  {gelcone.find_device(stem).name}", f"  {path}"] for stem, path in shipped_devices().items()
    ]
    assert listed == {
        stem: {"name": gelcone.find_device(stem).name, "file": str(path)} for stem, path in shipped_devices().items()
    }


def test_a_device_that_ships_is_printed_with_its_comments_and_another_as_it_is_read(command_line, tmp_path):
    text = shipped_devices()["soft-film"].read_text(encoding="utf-8")
    assert "#" in text
    assert command_line("devices", "soft-film")[1] == text
    own = gelcone.find_device("soft-film").replace(name="mine")
    (tmp_path / "mine.toml").write_text("# a note\n" + own.to_toml(), encoding="utf-8")
    assert command_line("devices", "mine.toml")[1] == own.to_toml()
    (tmp_path / "soft-film").write_text(own.to_toml(), encoding="utf-8")  # a file goes before a device that ships
    assert command_line("devices", "soft-film")[1] == own.to_toml()


@pytest.mark.parametrize("name", load_materials())
def test_a_gel_is_printed_with_all_its_numbers_as_the_table_of_a_device_file(name, command_line):
    printed = command_line("materials", name)[1]
    assert gelcone.Material(**tomllib.loads(printed)["material"]) == load_materials()[name]
    assert "333" not in printed  # a third of Young's modulus
    one = result(command_line("materials", name, "--json")[1])["result"]
    assert one == {name: load_materials()[name].parameters()}


def test_a_gel_of_another_name_is_refused_with_those_that_ship(command_line):
    assert "did you mean 'VHB 4910'?" in command_line("materials", "vhb 4910")[2]


def test_every_gel_has_its_numbers_and_sources(command_line):
    gels = load_materials()
    lines = iter(command_line("materials")[1].splitlines())
    for name, gel in gels.items():
        span = gel.shear_modulus_range
        wide = "" if span is None else f" ({span[0] / 1e3:.4g} to {span[1] / 1e3:.4g})"
        wanted = f"{name}: shear modulus {gel.shear_modulus / 1e3:.4g} kPa{wide}, relative permittivity "
        count = sum(own.startswith("viscous_modulus") for own in gel.parameters())
        wanted += f"{gel.relative_permittivity:.3g}{f', creeps: {count} Maxwell branches' if count else ''}"
        assert next(lines) == wanted
        for field, source in gel.sources.items():
            assert next(lines) == f"  {field}: {source}"
    assert next(lines, None) is None
    listed = result(command_line("materials", "--json")[1])["result"]
    assert list(listed) == list(gels)
    assert all(listed[name]["shear_modulus"] == gel.shear_modulus for name, gel in gels.items())
    assert {gel.shear_modulus_range is None for gel in gels.values()} == {True, False}

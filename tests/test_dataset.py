"""Results on disk: whole or not at all, never over another one unasked, read back as they were."""

import os
import stat

import numpy as np
import pytest
import xarray as xr

import gelcone
from gelcone import ConeModel, InputError
from gelcone.dataset import label, model_of, outcome_array
from gelcone.devices import si
from gelcone.files import check_writable, write_together, write_whole
from tests import toys


def write_text(text):
    return lambda path: path.write_text(text)


def half_written(path):
    path.write_text("half")
    raise RuntimeError("disk full")


# --- whole or not at all ----------------------------------------------------------------------------------------------


def test_a_file_appears_with_the_folders_above_it(tmp_path):
    path = tmp_path / "some" / "where" / "a.txt"
    write_whole(path, write_text("whole"))
    assert path.read_text() == "whole"
    assert os.listdir(path.parent) == ["a.txt"]


def test_a_file_has_the_usual_permissions(tmp_path):
    write_whole(tmp_path / "a.txt", write_text("whole"))
    (tmp_path / "b.txt").write_text("by hand")
    modes = {stat.S_IMODE((tmp_path / name).stat().st_mode) for name in ("a.txt", "b.txt")}
    assert len(modes) == 1


def test_the_writer_sees_the_suffix_of_the_file(tmp_path):
    seen = []
    write_whole(tmp_path / "a.nc", lambda path: seen.append(path))
    assert [path.suffix for path in seen] == [".nc"]
    assert seen[0].parent == tmp_path


def test_a_writer_that_raises_leaves_nothing(tmp_path):
    with pytest.raises(RuntimeError, match="disk full"):
        write_whole(tmp_path / "a.txt", half_written)
    assert os.listdir(tmp_path) == []


def test_a_writer_that_raises_leaves_the_old_file(tmp_path):
    path = tmp_path / "a.txt"
    path.write_text("old")
    with pytest.raises(RuntimeError, match="disk full"):
        write_whole(path, half_written, force=True)
    assert path.read_text() == "old"
    assert os.listdir(tmp_path) == ["a.txt"]


def test_an_interrupt_while_writing_leaves_nothing(tmp_path):
    def interrupted(path):
        path.write_text("half")
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        write_together({tmp_path / "a.txt": write_text("whole"), tmp_path / "b.txt": interrupted})
    assert os.listdir(tmp_path) == []


def test_several_files_appear_together(tmp_path):
    files = {tmp_path / "a.txt": write_text("one"), tmp_path / "b.txt": write_text("two")}
    write_together(files)
    assert sorted(os.listdir(tmp_path)) == ["a.txt", "b.txt"]
    with pytest.raises(RuntimeError, match="disk full"):
        write_together(dict.fromkeys(files, half_written), force=True)
    assert [path.read_text() for path in files] == ["one", "two"]


# --- what is refused --------------------------------------------------------------------------------------------------


def test_an_existing_file_is_kept_unless_forced(tmp_path):
    path = tmp_path / "a.txt"
    path.write_text("old")
    with pytest.raises(InputError, match="exists already; choose another folder or give --force to overwrite it"):
        write_whole(path, write_text("new"))
    assert path.read_text() == "old"
    write_whole(path, write_text("new"), force=True)
    assert path.read_text() == "new"


def test_a_folder_is_never_replaced(tmp_path):
    (tmp_path / "a.nc").mkdir()
    with pytest.raises(InputError, match="is a folder"):
        write_whole(tmp_path / "a.nc", write_text("new"), force=True)


@pytest.mark.parametrize("below", ["a.nc", "more/a.nc"])
def test_a_folder_that_is_a_file_is_refused(tmp_path, below):
    (tmp_path / "file").write_text("not a folder")
    with pytest.raises(InputError) as error:
        write_whole(tmp_path / "file" / below, write_text("new"))
    assert "cannot be written" in str(error.value)
    assert str(error.value).endswith("file is a file); choose another folder")
    assert (tmp_path / "file").read_text() == "not a folder"


@pytest.mark.skipif(not hasattr(os, "geteuid") or os.geteuid() == 0, reason="the superuser may write everywhere")
def test_a_folder_without_permission_is_refused(tmp_path):
    tmp_path.chmod(0o500)
    with pytest.raises(InputError, match="no permission"):
        write_whole(tmp_path / "a.nc", write_text("new"))


@pytest.mark.parametrize("name", ["x" * 300, "nul\0byte"])
def test_a_name_that_no_folder_can_have_is_refused(tmp_path, name):
    with pytest.raises(InputError, match="cannot be written"):
        write_whole(tmp_path / name / "a.nc", write_text("new"))


def test_looking_whether_files_can_be_written_touches_nothing(tmp_path):
    check_writable([tmp_path / "new" / "a.nc", tmp_path / "b.nc"])
    assert os.listdir(tmp_path) == []


# --- Datasets ---------------------------------------------------------------------------------------------------------


def labelled(model, **variables):
    return label(model, variables, outcome=np.zeros(model.shape), options={"steps": 3}, title="numbers")


def test_values_over_members_take_the_shape_of_the_ensemble():
    model = ConeModel(voltage=[[0.1], [0.2]], rest_height=[0.0, 0.1, 0.2])
    result = labelled(
        model,
        each=(("part",), np.arange(12.0).reshape(6, 2), "one row a member", "length"),
        shared=(("part",), np.arange(2.0), "the same for all", "time"),
        single=((), np.arange(6.0), "one number a member", "share"),
    )
    assert result.each.dims == ("member_0", "member_1", "part")
    assert result.shared.dims == ("part",)
    assert result.single.dims == result.outcome.dims == ("member_0", "member_1")
    np.testing.assert_array_equal(result.each[1, 0], [6.0, 7.0])
    assert result.each.attrs == {"long_name": "one row a member", "units": "1", "quantity": "length"}


def test_save_and_load_give_the_same_dataset(tmp_path):
    values = np.array([[1.0, np.nan], [np.inf, -1e-300]])
    result = labelled(ConeModel(voltage=[1 / 3, 0.2]), each=(("part",), values, "numbers", "length"))
    gelcone.save(result, tmp_path / "a.nc")
    read = gelcone.load(str(tmp_path / "a.nc"))
    xr.testing.assert_identical(read, result)
    assert read.outcome.dtype == np.int8
    np.testing.assert_array_equal(model_of(read).voltage, [1 / 3, 0.2])
    with pytest.raises(InputError, match="exists already"):
        gelcone.save(result, tmp_path / "a.nc")


def test_a_loaded_dataset_does_not_hold_its_file_open(tmp_path):
    result = labelled(ConeModel(), single=((), 1.0, "a number", "share"))
    gelcone.save(result, tmp_path / "a.nc")
    read = gelcone.load(tmp_path / "a.nc")
    gelcone.save(read, tmp_path / "a.nc", force=True)
    xr.testing.assert_identical(gelcone.load(tmp_path / "a.nc"), result)


def test_what_is_not_a_result_is_refused_in_one_line(tmp_path):
    (tmp_path / "text.nc").write_text("no netCDF")
    for path, message in (
        (tmp_path / "none.nc", "none.nc: no such file"),
        (tmp_path / "text.nc", "text.nc: is not a readable netCDF-4 file"),
        (tmp_path, "is not a readable netCDF-4 file"),
    ):
        with pytest.raises(InputError) as error:
            gelcone.load(path)
        assert message in str(error.value)
        assert "\n" not in str(error.value)


def test_a_dataset_from_elsewhere_has_no_model():
    with pytest.raises(InputError, match="does not say which model"):
        model_of(xr.Dataset())


def test_outcomes_are_flags_with_meanings():
    array = outcome_array([0, 2], ("member",))
    assert array.dtype == np.int8
    assert len(array.attrs["flag_meanings"].split()) == array.attrs["flag_values"].size == len(gelcone.Outcome)


# --- SI units ---------------------------------------------------------------------------------------------------------


def test_results_of_a_device_are_scaled_once():
    device = gelcone.find_device("soft-film").replace(frequency=[8.0, 10.0])
    result = gelcone.simulate(device.to_model(), device.initial_state(), periods=2)
    shown = gelcone.to_si(result, device)
    scales = {"displacement": 1e3 * device.scales.length, "drive_voltage": device.scales.voltage, "hoop_stretch": 1.0}
    for name, scale in scales.items():
        np.testing.assert_allclose(shown[name], result[name] * scale, rtol=1e-15)
    np.testing.assert_allclose(shown.time, result.time * 1e3 * device.scales.time, rtol=1e-15)
    assert [shown[name].attrs["units"] for name in ("time", "displacement", "hoop_stretch")] == ["ms", "mm", "1"]
    assert "device" not in result.attrs
    xr.testing.assert_identical(gelcone.to_si(shown, device), shown)


def test_every_scaled_quantity_has_a_unit():
    device = gelcone.find_device("soft-film")
    for quantity in si.READ_AS:
        assert si.factor(device, quantity) > 0.0


# --- components of one's own ------------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", toys.TOYS)
def test_a_result_of_own_components_comes_back_from_its_file_with_their_numbers(name, tmp_path):
    """A class that can be imported is found by module and name; swept parameters of its own are coordinates."""
    pytest.importorskip("heyoka")
    own = {"film": "film_modulus", "waveform": "second_harmonic", "bias": "bias_cubic", "circuit": "filter_time"}[name]
    model = ConeModel(**toys.TOYS[name], **{own: [0.2, 0.4]})
    result = gelcone.simulate(model, (0.3, 0.0), periods=1)
    np.testing.assert_array_equal(result[own], [0.2, 0.4])
    assert result[own].attrs["long_name"] == model.system.parameters[own].meaning
    gelcone.save(result, tmp_path / "own.nc")
    read = gelcone.load(tmp_path / "own.nc")
    again = model_of(read)
    assert again.system == model.system
    np.testing.assert_array_equal(getattr(again, own), [0.2, 0.4])
    repeated = gelcone.simulate(again, (0.3, 0.0), periods=1)
    np.testing.assert_array_equal(repeated["displacement"], read["displacement"])


def test_a_field_of_a_component_is_kept_to_the_last_digit(tmp_path):
    pytest.importorskip("heyoka")
    model = ConeModel(film=toys.PowerFilm(0.1 + 0.2))
    gelcone.save(gelcone.simulate(model, (0.3, 0.0), periods=1), tmp_path / "own.nc")
    assert model_of(gelcone.load(tmp_path / "own.nc")).film == toys.PowerFilm(0.1 + 0.2)


def test_a_class_that_is_gone_says_what_to_do(tmp_path):
    """The numbers of the result are still read; only the model needs the class."""
    pytest.importorskip("heyoka")
    result = gelcone.simulate(ConeModel(bias=toys.CubicBias()), (0.3, 0.0), periods=1)
    result.attrs["model"] = result.attrs["model"].replace("toys:CubicBias", "toys_of_last_year:CubicBias")
    gelcone.save(result, tmp_path / "own.nc")
    read = gelcone.load(tmp_path / "own.nc")
    np.testing.assert_array_equal(read["displacement"], result["displacement"])
    with pytest.raises(InputError) as error:
        model_of(read)
    assert "toys_of_last_year" in str(error.value)
    assert "put its class into a module that Python finds" in str(error.value)
    assert "\n" not in str(error.value)

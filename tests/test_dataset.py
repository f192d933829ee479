"""Results: labelled, on disk, and read back as they were."""

import ast
import json
import re
from collections import Counter
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
import xarray as xr

import gelcone
from gelcone import ConeModel, InputError
from gelcone.codes import Outcome
from gelcone.dataset import (
    absent,
    attributes,
    columns,
    film_errors,
    flags_of,
    label,
    model_of,
    of_states,
    outcome_array,
    with_initial,
)
from tests.test_contracts import QUANTITIES
from tests.toys import STATED


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


def not_in_json(constant):
    raise ValueError(f"{constant} is not JSON")


def test_a_film_without_stretch_limit_is_stated_in_json_and_read_back():
    model = ConeModel(stretch_limit=np.inf, voltage=0.25, rest_height=[0.0, 0.5])
    stated = json.loads(labelled(model).attrs["model"], parse_constant=not_in_json)
    assert (stated["stretch_limit"], stated["voltage"]) == ("inf", 0.25)
    assert "rest_height" not in stated
    found = model_of(labelled(model)).parameters()
    assert {name: found[name] for name in ("stretch_limit", "voltage")} == {"stretch_limit": np.inf, "voltage": 0.25}
    np.testing.assert_array_equal(found["rest_height"], [0.0, 0.5])


def test_parameters_on_axes_of_their_own_give_every_combination_back():
    coords = {name: (name, values, {"quantity": "parameter"})
              for name, values in (("voltage", [0.1, 0.2]), ("rest_height", [0.3, 0.4, 0.5]))}  # fmt: skip
    axes = xr.Dataset(coords=coords, attrs=labelled(ConeModel(drive_frequency=0.3)).attrs)
    found = model_of(axes)
    assert (found.shape, found.drive_frequency) == ((2, 3), 0.3)
    np.testing.assert_array_equal(found.voltage, [[0.1] * 3, [0.2] * 3])
    np.testing.assert_array_equal(found.rest_height, [[0.3, 0.4, 0.5]] * 2)


def test_parameters_of_members_are_coordinates_with_their_meaning():
    result = labelled(ConeModel(voltage=[[0.1], [0.2]], rest_height=[0.0, 0.1, 0.2]))
    assert result.voltage.dims == result.rest_height.dims == ("member_0", "member_1")
    np.testing.assert_array_equal(result.voltage, [[0.1] * 3, [0.2] * 3])
    assert result.rest_height.attrs == {
        "long_name": ConeModel().system.parameters["rest_height"].meaning, "units": "1", "quantity": "parameter"
    }  # fmt: skip
    assert labelled(ConeModel(voltage=[0.1, 0.2])).voltage.dims == ("member",)
    assert (json.loads(result.attrs["options"]), result.attrs["title"]) == ({"steps": 3}, "numbers")
    assert result.attrs["gelcone_version"] == gelcone.__version__


def test_a_variable_is_named_by_its_own_words_or_by_those_of_its_parameter():
    parameter = {"long_name": "stretch at rest", "units": "1", "quantity": "prestretch"}
    assert attributes("", parameter) == parameter
    assert attributes("largest of them", parameter) == parameter | {"long_name": "largest of them"}
    assert attributes("phase", "angle") == {"long_name": "phase", "units": "degree", "quantity": "angle"}
    ended = attributes("how it ended", Outcome)
    assert (ended["long_name"], ended["units"], ended["quantity"]) == ("how it ended", "1", "flag")
    assert ended["flag_meanings"].split()[ended["flag_values"].tolist().index(Outcome.PULLED_IN)] == "pulled_in"
    assert (flags_of(("rise", "fall"))["flag_values"].tolist(), flags_of(("rise", "fall"))["flag_meanings"]) == (
        [0, 1], "rise fall"
    )  # fmt: skip
    missing = absent("voltage", "not asked")
    assert missing == {"units": "1", "quantity": "voltage", "nan_means": "not asked", "infinite_means": "not reached"}
    table = {"a": ([1, 2], "first", "length"), "b": ([3.0, 4.0], "second", missing)}
    found = xr.Dataset(columns("row", table))
    assert (found.a.dims, found.b.dims, found.b.values.tolist()) == (("row",), ("row",), [3.0, 4.0])
    assert found.a.attrs == {"long_name": "first", "units": "1", "quantity": "length"}
    assert found.b.attrs == missing | {"long_name": "second"}


def test_initial_states_have_the_shape_of_the_ensemble_and_their_names():
    model = ConeModel(voltage=[[0.1], [0.2]], rest_height=[0.0, 0.1, 0.2])
    states = np.arange(12.0).reshape(6, 2)
    result = with_initial(labelled(model), model, states)
    assert result.initial.dims == ("member_0", "member_1", "state")
    assert result.state.values.tolist() == ["displacement", "velocity"]
    np.testing.assert_array_equal(result.initial.sel(state="velocity"), [[1, 3, 5], [7, 9, 11]])
    assert result.initial.attrs["state_quantities"] == of_states(model.system)["state_quantities"] == "length, velocity"


SMALL = ConeModel(spring_stiffness=0.5, drive_frequency=0.3, voltage=0.4)
ENTRIES = {
    "fate": (lambda: gelcone.regime(SMALL), [1, 2, 3]),
    "bound": (lambda: gelcone.onset_voltage(SMALL, highest=1.0, steps=20), ["lowest", "highest"]),
    "harmonic": (lambda: gelcone.sweep(gelcone.Plan(SMALL, {"voltage": [0.3, 0.4]}), "settled"), [1, 2, 3, 4]),
}


@pytest.mark.parametrize("dim", ENTRIES)
def test_a_dim_of_fixed_entries_says_what_each_is_in_the_dataset_the_file_and_the_table(dim, tmp_path):
    compute, entries = ENTRIES[dim]
    result = compute()
    gelcone.save(result, tmp_path / "a.nc")
    for each in (result, gelcone.load(tmp_path / "a.nc")):
        assert each[dim].values.tolist() == entries
        assert len(each[dim].attrs["long_name"].split()) > 2
        assert each[dim].attrs["units"] == "1"
    over = next(v.dims for v in result.data_vars.values() if dim in v.dims)
    assert sorted(set(gelcone.table(result, over)[dim])) == sorted(entries)


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


def test_only_results_and_devices_are_saved(tmp_path):
    device = gelcone.find_device("biased-pump").replace(spring_rate="16 N/m")
    gelcone.save(device, tmp_path / "new" / "mine.toml")
    assert gelcone.find_device(tmp_path / "new" / "mine.toml") == device
    with pytest.raises(InputError, match="exists already"):
        gelcone.save(device, tmp_path / "new" / "mine.toml")
    gelcone.save(device.replace(spring_rate="17 N/m"), tmp_path / "new" / "mine.toml", force=True)
    assert gelcone.find_device(tmp_path / "new" / "mine.toml").spring_rate == 17.0
    with pytest.raises(InputError, match=r"^save: was given .*; give a result of an analysis, or a device$"):
        gelcone.save([1.0], tmp_path / "list.nc")


def test_a_file_that_another_program_changed_is_refused_with_the_remedy(tmp_path):
    gelcone.save(labelled(ConeModel(), single=((), 1.0, "a number", "share")), tmp_path / "a.nc")
    changed = xr.load_dataset(tmp_path / "a.nc")
    changed.assign(single=2.0).to_netcdf(tmp_path / "b.nc")
    with pytest.raises(
        InputError, match=r"b\.nc: its contents do not .*; run it again, or open it with xarray\.open_d"
    ):
        gelcone.load(tmp_path / "b.nc")


def test_a_dataset_from_elsewhere_has_no_model():
    with pytest.raises(InputError, match="does not say which model"):
        model_of(xr.Dataset())


def test_of_films_and_members_the_largest_stated_error_counts():
    """A member without a film has none."""
    model = ConeModel(film="tests.toys:StatedCone", second_film="tests.toys:StatedCone", voltage=[0.1, 0.2, 0.3])
    own = model.members().own_numbers
    stated = {"film_error": np.array([0.01, np.nan, 0.02]), "second_film_error": np.array([0.0, np.nan, 0.05])}
    members = SimpleNamespace(own_numbers={name: own[name] for name in model.system.numbers} | stated)
    errors = film_errors(SimpleNamespace(system=model.system, members=lambda: members))
    assert errors == STATED | {"film_error": 0.05}
    assert film_errors(ConeModel()) == {}


def test_outcomes_are_flags_with_meanings():
    array = outcome_array([0, 2], ("member",))
    assert array.dtype == np.int8
    assert len(array.attrs["flag_meanings"].split()) == array.attrs["flag_values"].size == len(gelcone.Outcome)


def test_every_long_name_stands_alone():
    """A table or a figure shows one variable without its neighbours. Long names stand in the values of dicts."""
    source = Path(gelcone.__file__).parent
    trees = {path: ast.parse(path.read_text(encoding="utf-8")) for path in source.rglob("*.py")}
    assert trees
    dicts = [(path, node) for path, tree in trees.items() for node in ast.walk(tree) if isinstance(node, ast.Dict)]
    values = [(path, value) for path, node in dicts for value in node.values]
    parts = [(path, part) for path, value in values for part in (value, *getattr(value, "elts", ()))]
    texts = [
        (path, part.value) for path, part in parts if isinstance(part, ast.Constant) and isinstance(part.value, str)
    ]
    assert "period in forcing periods, 0 if none" in dict(map(reversed, texts))
    leaning = r"(and|its|the same|that|of it|of that)\b|.*\bits 95 %"
    assert [(path.name, text) for path, text in texts if re.match(leaning, text)] == []


QUANTITY_OF = {
    ("voltage", "constant"): {"voltage"},
    ("displacement", "stroke", "extent", "radius", "highest", "lowest"): {"length"},
    ("amplitude",): {"length", "voltage"},
    ("velocity",): {"velocity"},
    ("frequency",): {"frequency"},
    ("time",): {"time"},
    ("period",): {"count", "time"},
    ("energy",): {"energy"},
    ("slope", "stiffness"): {"stiffness", "stress"},
    ("lyapunov", "finite"): {"rate"},
    ("real", "imag"): {"multiplier"},
    ("stable",): {"flag"},
    ("share", "chaotic"): {"share", "ratio"},
    ("low", "high"): {"frequency", "share", "time"},
    ("regime", "sign", "slack", "symmetric", "resting", "limit"): {"code", "flag", "share", "parameter of a surface"},
}
"""Last words of the names of variables -> their quantities."""
OF_PARTS = {"load", "apparent power", "parameter value", "parameter of a surface", "gain", "coefficient", "error"}
"""Quantities of single analyses and studies."""


def described_in_source():
    """Place of the dict, name, long name and quantity of each variable that a dict of the source describes in words."""
    for path in sorted(Path(gelcone.__file__).parent.rglob("*.py")):
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            for key, value in zip(node.keys, node.values, strict=True) if isinstance(node, ast.Dict) else ():
                *_, last = value.elts if isinstance(value, ast.Tuple) and len(value.elts) in (3, 4) else (None,)
                parts = last.args if isinstance(last, ast.Call) else value.elts[-2:] if last is not None else ()
                if all(isinstance(part, ast.Constant) for part in getattr(value, "elts", ())):
                    continue  # names in files
                name = key.values[-1] if isinstance(key, ast.JoinedStr) else key
                texts = [part.value for part in (name, *parts) if isinstance(part, ast.Constant)]
                if len(texts) == 3 and all(isinstance(text, str) for text in texts) and " " in texts[1]:
                    yield f"{path.parent.parent.name}/{path.name}:{node.lineno}", *texts


def test_a_variable_has_a_known_quantity_that_fits_its_name():
    found = list(described_in_source())
    assert len(found) > 300
    assert {quantity for _, _, _, quantity in found} - QUANTITIES - OF_PARTS == set()
    assert {row[3] for row in found if row[2].startswith("number of ")} == {"count"}
    fits = {word: quantities for words, quantities in QUANTITY_OF.items() for word in words}
    ends = [(row, fits.get(row[1].rpartition("_")[2])) for row in found]
    assert [row for row, quantities in ends if quantities and row[3] not in quantities] == []


def test_a_long_name_speaks_of_what_the_name_speaks_of():
    """An end of an interval says which, an extreme says whether it is the largest, and a sort of number which."""
    words = {
        "low": "lower|lowest|above",
        "high": "upper|highest|largest|below",
        **{word: word for word in ("velocity", "lowest", "highest", "share", "energy", "phase", "radius")},
        "voltage": "voltage|drive",
        "regime": "^(?!.*from the start)",
        "beyond": "beyond",
    }
    times = {"late_": "from the start", "window_": "long run", "early_": "long run"}
    ends = [(row, words.get(row[1].rpartition("_")[2], "")) for row in described_in_source()]
    assert [row for row, word in ends if not re.search(word, row[2])] == []
    assert [row for row, _ in ends if row[2].endswith(times.get(row[1].partition("_")[0] + "_", "."))] == []
    assert [row for row, _ in ends if row[2] != " ".join(row[2].split()) or row[2].endswith((".", ","))] == []


def test_two_variables_of_one_study_of_the_paper_are_not_described_alike():
    counted = Counter((place, said) for place, _, said, _ in described_in_source() if place.startswith("paper/"))
    assert len(counted) > 30
    assert [said for said, count in counted.items() if count > 1] == []

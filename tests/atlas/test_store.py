"""What a store writes and in which order, and what it says of a disk that takes no more."""

import errno

import numpy as np
import pytest

from gelcone.atlas import store
from gelcone.atlas.store import Field, Status, difference, fill_of, open_store, read_plan
from gelcone.errors import InputError

DIMS, SHAPE = ("voltage", "prestretch"), (3, 4)
STORED = {"over": {"voltage": [0.0, 1.0, 2.0]}, "analysis": "regime"}


def fields(first=0.0):
    """Twelve cells; the name of one field sorts before ``status``, that of another after it."""
    values = first + np.arange(12.0)
    return {
        "status": Field((), np.full(12, Status.COMPUTED, dtype=np.uint8), {}),
        "lowest": Field((), values, {"units": "1"}),
        "velocity": Field(("state",), np.stack([values, -values], axis=1), {}),
        "zero_one": Field((), values, {}),
    }


@pytest.fixture
def opened(tmp_path):
    with open_store(tmp_path / "store", STORED, DIMS, SHAPE, resume=False) as made:
        yield made


@pytest.fixture
def writes(monkeypatch):
    """The names of arrays in the order in which they are made and written."""
    order = []
    create, part = store._create, store._write_part

    def creating(group, name, *rest):
        order.append(f"make {name}")
        return create(group, name, *rest)

    def writing(array, *rest):
        order.append(f"write {array.basename}")
        return part(array, *rest)

    monkeypatch.setattr(store, "_create", creating)
    monkeypatch.setattr(store, "_write_part", writing)
    return order


def test_status_is_made_last(opened, writes):
    """Where it is, the other arrays are, whenever the run ends."""
    opened.begin(fields(), {"voltage": Field(("voltage",), np.arange(3.0), {})})
    assert writes[0] == "make voltage"
    assert writes[-1] == "make status"
    assert sorted(writes[1:-1]) == ["make lowest", "make velocity", "make zero_one"]


def test_axes_hold_their_values_and_arrays_the_names_of_their_axes(opened):
    import zarr

    opened.begin(fields(), {"voltage": Field(("voltage",), np.array([0.5, 1.0, 1.5]), {"units": "V"})})
    group = zarr.open_group(store=opened.path, mode="r", zarr_format=3)
    assert group["voltage"][...].tolist() == [0.5, 1.0, 1.5]
    assert group["voltage"].attrs["units"] == "V"
    for name, dims in (("velocity", (*DIMS, "state")), ("lowest", DIMS)):
        assert group[name].metadata.dimension_names == dims
        assert "Crc32cCodec" in [type(codec).__name__ for codec in group[name].metadata.codecs]  # of every tile


def test_a_store_whose_run_was_killed_before_it_collected_its_metadata_has_them_once_resumed(tmp_path, monkeypatch):
    with open_store(tmp_path / "s", STORED, DIMS, SHAPE, resume=False) as made, monkeypatch.context() as patch:
        patch.setattr(store, "_consolidate", lambda path: None)
        made.begin(fields(), {})
    assert store._consolidated(tmp_path / "s") == []
    with open_store(tmp_path / "s", STORED, DIMS, SHAPE, resume=True):
        assert sorted(store._consolidated(tmp_path / "s")) == sorted(fields())


def test_a_folder_of_results_is_no_store_and_its_first_file_is_named(tmp_path):
    for name in ("b.nc", "a.nc"):
        (tmp_path / name).write_bytes(b"")
    with pytest.raises(InputError, match=r"holds no metadata .*; name a file in it, such as .*a\.nc$"):
        read_plan(tmp_path)


def test_an_array_that_is_gone_is_noticed(opened):
    opened.begin(fields(), {})
    opened.write(fields(), np.arange(12))
    (opened.path / "lowest" / "zarr.json").unlink()
    with pytest.raises(InputError, match="is damaged: its array lowest is missing"):
        opened.read()


def test_status_of_a_tile_is_written_last_and_tile_by_tile(opened, writes, monkeypatch):
    monkeypatch.setattr(opened, "tile", (2, 4))
    opened.begin(fields(), {})
    writes.clear()
    opened.write(fields(), np.arange(12))
    assert [name == "write status" for name in writes] == [False, False, False, True] * 2


def test_a_run_that_ends_between_two_fields_leaves_the_tile_unknown(opened, monkeypatch):
    opened.begin(fields(), {})
    part, written = store._write_part, []

    def stopping(array, *rest):
        if len(written) == 2:
            raise KeyboardInterrupt
        written.append(array.basename)
        part(array, *rest)

    monkeypatch.setattr(store, "_write_part", stopping)
    with pytest.raises(KeyboardInterrupt):
        opened.write(fields(), np.arange(12))
    assert not opened.read()["status"].values.any()


def test_what_is_written_is_read_back_and_only_the_tiles_of_the_cells_are_touched(opened, monkeypatch):
    monkeypatch.setattr(opened, "tile", (2, 2))
    opened.begin(fields(), {})
    opened.write(fields(), np.array([0]))
    read = opened.read()
    known = np.array([0, 1, 4, 5])
    assert np.flatnonzero(read["status"].values).tolist() == known.tolist()
    np.testing.assert_array_equal(read["velocity"].values[known], fields()["velocity"].values[known])
    assert np.isnan(read["lowest"].values[2])
    assert read["velocity"].dims == ("state",)
    assert read["lowest"].attributes["units"] == "1"


@pytest.mark.parametrize(
    ("code", "remedy"),
    [
        (errno.ENOSPC, "free some space"),
        (errno.EDQUOT, "free some space"),
        (errno.EACCES, "make it writable"),
        (errno.EROFS, "make it writable"),
    ],
)
def test_a_write_that_fails_says_what_is_safe_and_what_to_do(opened, monkeypatch, code, remedy):
    opened.begin(fields(), {})
    opened.write(fields(), np.arange(12))

    def failing(*_):
        raise OSError(code, "the reason")

    monkeypatch.setattr(store, "_write_part", failing)
    with pytest.raises(InputError) as error:
        opened.write(fields(100.0), np.arange(12))
    said = str(error.value)
    assert said.startswith(f"{opened.path}: cannot be written (the reason); what it holds is safe: {remedy}")
    assert said.endswith(f"--resume {opened.path}")
    np.testing.assert_array_equal(opened.read()["lowest"].values, np.arange(12.0))


def test_a_folder_that_cannot_be_made_says_so(tmp_path):
    (tmp_path / "file").write_text("")
    with (
        pytest.raises(InputError, match=r"cannot be written .*make it writable"),
        open_store(tmp_path / "file" / "store", STORED, DIMS, SHAPE, resume=False),
    ):
        pass


def test_a_tile_that_is_gone_or_changed_is_noticed(opened):
    opened.begin(fields(), {})
    opened.write(fields(), np.arange(12))
    chunk = opened.path / "lowest" / "c" / "0" / "0"
    whole = chunk.read_bytes()
    chunk.write_bytes(whole[:-1] + bytes([whole[-1] ^ 1]))
    with pytest.raises(InputError, match="is damaged: a tile of lowest cannot be read"):
        opened.read()
    chunk.unlink()
    with pytest.raises(InputError, match="is damaged: a tile of lowest is missing"):
        opened.read()


def test_a_store_is_for_one_run_at_a_time_and_for_one_plan(tmp_path):
    path = tmp_path / "store"
    with open_store(path, STORED, DIMS, SHAPE, resume=False):
        with (
            pytest.raises(InputError, match="another run is writing to it"),
            open_store(path, STORED, DIMS, SHAPE, resume=True),
        ):
            pass
        with (
            pytest.raises(InputError, match=r"is not empty; .* --resume"),
            open_store(path, STORED, DIMS, SHAPE, resume=False),
        ):
            pass
    (path / "c.partial").write_bytes(b"half")
    with open_store(path, STORED, DIMS, SHAPE, resume=True):
        assert not (path / "c.partial").exists()
    other = STORED | {"analysis": "lyapunov"}
    with (
        pytest.raises(InputError, match="holds another run: analysis is regime there and lyapunov here"),
        open_store(path, other, DIMS, SHAPE, resume=True),
    ):
        pass
    assert read_plan(path) == STORED


@pytest.mark.parametrize(
    ("stored", "asked", "said"),
    [
        ({"a": 1}, {"a": 1}, "nothing"),
        ({"a": 1, "b": 2}, {"b": 3, "a": 1}, "b is 2 there and 3 here"),
        ({"a": 1}, {}, "a is 1 there and missing here"),
        (
            {"over": {"v": [0, 1]}},
            {"over": {"v": [0, 1, 2, 3, 4]}},
            "over: v is [0, 1] there and 5 values from 0 to 4 here",
        ),
        ({"over": {"v": [0, 1]}}, {"over": {"v": [0, 1, 2, 4]}}, "over: v is [0, 1] there and [0, 1, 2, 4] here"),
        ({"model": {"law": "gent"}}, {"model": {"law": "yeoh"}}, "law is gent there and yeoh here"),
    ],
)
def test_the_difference_of_two_plans_in_words(stored, asked, said):
    assert difference(stored, asked) == said


def test_a_store_is_resumed_where_the_stated_errors_of_films_are_rounded_otherwise(tmp_path):
    plans = [{"gelcone_version": "1", "over": {"x": [1.0, 2.0]}, "film_errors": {"film_error": e}} for e in (0.1, 0.2)]
    with open_store(tmp_path / "s", plans[0], ("x",), (2,), resume=False):
        pass
    with open_store(tmp_path / "s", plans[1], ("x",), (2,), resume=True):
        assert read_plan(tmp_path / "s") == plans[0]
    with (
        pytest.raises(InputError, match="over: x"),
        open_store(tmp_path / "s", plans[1] | {"over": {"x": [1.0, 3.0]}}, ("x",), (2,), resume=True),
    ):
        pass


def test_what_stands_for_nothing():
    assert np.isnan(fill_of(np.float64))
    assert fill_of(np.int8) == -1
    assert fill_of(np.bool_) == 0


@pytest.mark.parametrize(
    ("shape", "tile"), [((5,), (5,)), ((20000,), (16384,)), ((300, 100), (128, 100)), ((100, 100, 100), (25, 25, 25))]
)
def test_a_tile_is_as_wide_along_each_axis_and_holds_a_bounded_number_of_cells(shape, tile):
    assert store._tile(shape) == tile
    assert np.prod(tile) <= store.TILE_CELLS


@pytest.mark.parametrize("left", [(), (store.LOCK,), (store.LOCK, "zarr.json.4711.partial")])
def test_a_run_that_was_killed_before_it_wrote_is_resumed_as_one_not_begun(left, tmp_path):
    """Without the plan of a run, which the folder lacks, the remedy is said."""
    for name in left:
        (tmp_path / name).write_bytes(b"")
    with pytest.raises(InputError, match=r"is empty: no run has written to it yet; begin one with --store "):
        read_plan(tmp_path)
    with open_store(tmp_path, STORED, DIMS, SHAPE, resume=True) as made:
        assert made.read() == {}
        made.begin(fields(), {})
    assert read_plan(tmp_path) == STORED
    assert not list(tmp_path.glob("*.partial"))


def test_a_folder_is_empty_but_for_what_a_run_left_that_was_killed_before_it_wrote(tmp_path):
    """Halves of files are removed, in subfolders too; anything else is somebody's."""
    place = tmp_path / "store"
    place.mkdir()
    for name in ("zarr.json.4711.partial", store.LOCK):
        (place / name).write_bytes(b"{")
    with open_store(place, STORED, DIMS, SHAPE, resume=False) as made:
        made.begin(fields(), {})
        (place / "lowest" / "half.partial").write_bytes(b"1")
    assert not [path for path in place.iterdir() if path.suffix == ".partial"]
    with open_store(place, STORED, DIMS, SHAPE, resume=True):
        assert not list(place.rglob("*.partial"))
    other = tmp_path / "other"
    other.mkdir()
    (other / "notes.txt").write_text("mine")
    with (
        pytest.raises(InputError, match="is not empty; resume it with --resume"),
        open_store(other, STORED, DIMS, SHAPE, resume=False),
    ):
        pass
    assert (other / "notes.txt").read_text() == "mine"


def test_a_store_of_another_version_says_which_one_resumes_it_whatever_else_differs():
    plans = [{store.VERSION: version, "analysis": analysis} for version, analysis in (("0.1.0", "a"), ("0.3.0", "b"))]
    said = str(store._another("map.zarr", *plans))
    assert said.startswith("map.zarr: gelcone_version is 0.1.0 there and 0.3.0 here, so that its cells would not match")
    assert "resume it with gelcone 0.1.0" in said
    plans[0][store.VERSION] = "0.3.0"
    assert str(store._another("map.zarr", *plans)) == (
        "map.zarr: holds another run: analysis is a there and b here; choose another store"
    )


def test_a_tile_that_holds_nothing_but_fill_values_is_written_like_any_other(opened):
    """Of cells that all failed; it does not look like one that was lost."""
    failed = fields() | {"lowest": Field((), np.full(12, np.nan), {})}
    opened.begin(failed, {})
    opened.write(failed, np.arange(12))
    assert np.isnan(opened.read()["lowest"].values).all()


def test_a_tile_of_which_some_cells_are_computed_is_missed_as_well(opened):
    some = fields() | {"status": Field((), (np.arange(12) == 5).astype(np.uint8), {})}
    opened.begin(some, {})
    opened.write(some, np.array([5]))
    (opened.path / "lowest" / "c" / "0" / "0").unlink()
    with pytest.raises(InputError, match="is damaged: a tile of lowest is missing"):
        opened.read()


def test_a_store_is_read_and_continued_by_the_tiles_that_it_was_written_in(opened, monkeypatch):
    """A later version may cut others."""
    monkeypatch.setattr(opened, "tile", (2, 3))
    opened.begin(fields(), {})
    opened.write(fields(), np.arange(12))
    later = store.Store(opened.path, STORED, DIMS, SHAPE)
    assert later.tile != (2, 3)
    later.read()
    assert later.tile == (2, 3)
    (opened.path / "lowest" / "c" / "1" / "1").unlink()
    with pytest.raises(InputError, match="is damaged: a tile of lowest is missing"):
        later.read()


def test_one_array_of_another_shape_than_the_plan_is_refused(opened):
    import zarr

    opened.begin(fields(), {})
    opened.write(fields(), np.arange(12))
    group = zarr.open_group(store=opened.path, mode="r+", zarr_format=3, use_consolidated=False)
    group.create_array("lowest", shape=(3, 5), chunks=(3, 5), dtype=float, overwrite=True)
    with pytest.raises(InputError, match="is damaged: its arrays do not have the shape of its plan"):
        opened.read()

"""Results in other programs' formats hold the numbers of the result, each with its unit."""

import csv

import numpy as np
import pandas as pd
import pytest
from scipy.io import loadmat

import gelcone
from gelcone import Regime, interchange
from tests.edited import made

PUMP = gelcone.find_device("biased-pump")


@pytest.fixture(scope="module")
def run():
    return gelcone.simulate(PUMP, times=["0 ms", "1 ms", "2 ms"])


def test_a_table_has_a_row_for_each_time_and_units_in_its_head(run, tmp_path):
    paths = gelcone.export(run, tmp_path / "run.csv")
    assert [path.name for path in paths] == ["run.time.csv", "run.csv", "run.state.csv"]
    with open(tmp_path / "run.time.csv", newline="") as file:
        rows = list(csv.DictReader(file))
    assert [float(row["time (ms)"]) for row in rows] == run["time"].values.tolist()
    assert [float(row["displacement (mm)"]) for row in rows] == run["displacement"].values.tolist()
    assert {row["film_state"] for row in rows} == {"taut"}


def test_members_and_cells_have_a_row_each_with_what_varies(tmp_path):
    several = gelcone.static(
        PUMP.replace(film_thickness=["0.2 mm", "0.3 mm"], film_radius=["30 mm", "60 mm"], disc_radius=["8 mm", "16 mm"])
    )
    gelcone.export(several, tmp_path / "many.parquet")
    table = pd.read_parquet(tmp_path / "many.member-fold.parquet")
    assert table["film_thickness (mm)"].tolist() == [0.2, 0.3]
    forces = pd.read_parquet(next(path for path in tmp_path.iterdir() if "displacement_sample" in path.name))
    of_second = forces[forces["film_thickness (mm)"] == 0.3]["force (N)"].to_numpy()
    own = several["force"].isel(member=1).values.ravel()
    np.testing.assert_array_equal(of_second, own)


def test_without_dims_a_table_is_over_the_first_dim_alone_else_over_those_of_most_variables():
    result = made({"stroke": ("draw", [1.0, 2.0, 3.0]), "low": ("field", [4.0, 5.0]), "high": ("field", [6.0, 7.0])})
    assert gelcone.table(result)["stroke"].tolist() == [1.0, 2.0, 3.0]
    crossed = result.assign(stroke=(("draw", "field"), np.zeros((3, 2))))[["stroke", "low", "high"]]
    assert next(iter(crossed.sizes)) == "draw"
    assert gelcone.table(crossed)["high"].tolist() == [6.0, 7.0]


def test_a_code_that_stands_for_nothing_is_an_empty_word():
    (frame,) = interchange.tables(made({"regime": ("cell", [Regime.CHAOTIC, -1, np.nan, Regime.REST])})).values()
    assert frame["regime"].tolist() == ["chaotic", "", "", "rest"]


def test_matlab_has_arrays_and_their_units(run, tmp_path):
    run.gelcone.export(tmp_path / "run.mat")
    held = loadmat(tmp_path / "run.mat", squeeze_me=True, simplify_cells=True)
    np.testing.assert_array_equal(held["displacement"], run["displacement"])
    assert held["units"]["displacement"] == "mm"
    assert held["long_names"]["displacement"] == run["displacement"].attrs["long_name"]
    assert held["dims"]["displacement"] == "time"
    assert held["attributes"]["device"] == "biased pumping cone"


def test_what_is_there_is_kept_and_other_formats_are_refused(run, tmp_path):
    gelcone.export(run, tmp_path / "run.csv")
    with pytest.raises(gelcone.InputError, match="exists already"):
        gelcone.export(run, tmp_path / "run.csv")
    assert len(gelcone.export(run, tmp_path / "run.csv", force=True)) == 3
    with pytest.raises(gelcone.InputError, match=r"run.xls: a result is written to NAME.csv, NAME.mat or NAME.parq"):
        gelcone.export(run, tmp_path / "run.xls")
    with pytest.raises(gelcone.InputError, match="a device is written to"):
        gelcone.export(PUMP, tmp_path / "pump.csv")

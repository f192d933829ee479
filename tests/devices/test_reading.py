"""Measured tables in all their quirks, and files that nobody should trust: one clear line each."""

import os
import random
import re
import time
import warnings
from pathlib import Path

import numpy as np
import pytest

import gelcone
from gelcone.devices import reading as module
from gelcone.devices.reading import read_table
from gelcone.devices.recorded import read_recording
from gelcone.errors import InputError
from gelcone.lab.coupons import coupons_of, roles_of
from gelcone.lab.device_tests import read_device_tests
from gelcone.lab.measured import read_tests

PLAIN = "stretch,stress (kPa)\n1.0,0.0\n1.1,5.0\n1.2,9.0\n1.3,12.5\n"
SAME = {
    "semicolons and decimal commas": "stretch;stress (kPa)\n1,0;0,0\n1,1;5,0\n1,2;9,0\n1,3;12,5\n",
    "tabs": "stretch\tstress (kPa)\n1.0\t0.0\n1.1\t5.0\n1.2\t9.0\n1.3\t12.5\n",
    "spaces": "stretch stress_kPa\n1.0 0.0\n1.1  5.0\n1.2 9.0\n1.3 12.5\n".replace("_kPa", "[kPa]"),
    "a unit in brackets": PLAIN.replace("(kPa)", "[kPa]"),
    "a unit after a slash": PLAIN.replace("(kPa)", "/ kPa"),
    "a unit after a slash without spaces": PLAIN.replace(" (kPa)", "/kPa"),
    "a slash and brackets": PLAIN.replace(" (kPa)", "/(kPa)"),
    "units in the second row": "stretch,stress\n-,kPa\n1.0,0.0\n1.1,5.0\n1.2,9.0\n1.3,12.5\n",
    "a byte-order mark": "\ufeff" + PLAIN,
    "Windows lines": PLAIN.replace("\n", "\r\n"),
    "old Mac lines": PLAIN.replace("\n", "\r"),
    "comments and empty lines": "# made by a rig\n\n" + PLAIN.replace("1.1,", "\n% a pause\n1.1,"),
    "strain in %": "strain (%),stress (kPa)\n0,0\n10,5\n20,9\n30,12.5\n",
    "megapascals": "stretch,stress (MPa)\n1.0,0\n1.1,0.005\n1.2,0.009\n1.3,0.0125\n",
    "a column of words": "stretch,remark,stress (kPa)\n1.0,a,0.0\n1.1,,5.0\n1.2,b,9.0\n1.3,c,12.5\n",
    "words with commas": 'name,stretch,stress (kPa)\n"a, b",1.0,0\n"a, b",1.1,5\n"a, b",1.2,9\n"a, b",1.3,12.5\n',
    "a trailing separator": PLAIN.replace("\n", ",\n"),
    "a cut-off last line": PLAIN + "1.4\n",
    "a missing cell": PLAIN + "1.4,\n",
}


def written(folder, text, name="test.csv", encoding="utf-8"):
    path = folder / name
    path.write_bytes(text if isinstance(text, bytes) else text.encode(encoding))
    return path


@pytest.mark.parametrize("quirk", SAME)
def test_the_same_numbers_in_every_dress(quirk, tmp_path):
    table = read_table(written(tmp_path, SAME[quirk]))
    (test,) = coupons_of(table, {"columns": {}})
    assert ("column 'remark' is not used" in test.notes) == (quirk == "a column of words")
    np.testing.assert_allclose(test.stretch, [1.0, 1.1, 1.2, 1.3])
    np.testing.assert_allclose(test.stress, [0.0, 5e3, 9e3, 12.5e3])


@pytest.mark.parametrize("mark", [";", "\t", ","])
def test_a_first_line_that_names_the_separator_is_left_out(mark, tmp_path):
    """As Excel reads and writes it; a header of one name with a comma in it is then no two names."""
    path = tmp_path / "test.csv"
    path.write_text(f"sep={mark}\r\ntime (s){mark}force (mN)\r\n0{mark}1\r\n1{mark}2\r\n", newline="")
    table = read_table(path)
    assert [(column.unit, list(column.values)) for column in table.columns.values()] == [("s", [0, 1]), ("mN", [1, 2])]
    assert list(table.lines) == [3, 4]
    path.write_text("sep=;\nforce, mean\n1,5\n2,5\n")
    assert list(read_table(path).columns["force, mean"].values) == [1.5, 2.5]
    path.write_text(f"sep={mark}\n")
    with pytest.raises(InputError, match="is empty"):
        read_table(path)


@pytest.mark.parametrize("mark", [";", "\t"])
def test_a_header_with_commas_in_its_names_is_split_where_cells_are(mark, tmp_path):
    text = PLAIN.replace("stretch,stress", "stretch, true,stress").replace(",", mark).replace(f"{mark} true", ", true")
    table = read_table(written(tmp_path, text))
    assert list(table.columns) == ["stretch, true", "stress"]
    assert table.columns["stress"].values.tolist() == [0.0, 5.0, 9.0, 12.5]


def test_a_slash_stands_before_a_unit_or_within_a_name(tmp_path):
    """As in F/A, a force over an area and not in amperes, and in L/L0."""
    for heads, expected in {
        "L/L0,F/A / kPa": [("L/L0", None), ("F/A", "kPa")],
        "t/s,F/A/kPa": [("t", "s"), ("F/A", "kPa")],
        "lambda/-,F/A": [("lambda", "-"), ("F/A", None)],
        "E/V/m,V/m": [("E", "V/m"), ("V/m", None)],
    }.items():
        columns = read_table(written(tmp_path, PLAIN.replace("stretch,stress (kPa)", heads))).columns
        assert [(column.name, column.unit) for column in columns.values()] == expected


@pytest.mark.parametrize("head", ["voltage [kV]", "voltage / kV", "voltage (kV)", "voltage/kV"])
def test_a_table_of_one_column_needs_no_separator(head, tmp_path):
    table = read_table(written(tmp_path, f"{head}\n0.5\n1\n"))
    assert (table.columns["voltage"].unit, table.columns["voltage"].values.tolist()) == ("kV", [0.5, 1.0])
    assert table.notes == ()
    assert read_table(written(tmp_path, f"{head}\n0,5\n1\n")).notes == ("decimals are written with commas: 0,5 is 0.5",)


@pytest.mark.parametrize("cell", ["", "nan", "NA", "N/A", "-", "--", "null", "None"])
def test_what_stands_in_an_empty_cell_is_no_number_and_no_word(cell, tmp_path):
    table = read_table(written(tmp_path, PLAIN.replace("1.1,5.0", f"1.1,{cell}")))
    np.testing.assert_array_equal(table.columns["stress"].values, [0.0, np.nan, 9.0, 12.5])
    assert table.notes == ("column 'stress' has 1 empty cells",)


def test_rows_stand_on_their_lines_of_the_file(tmp_path):
    text = "# a rig\nstretch,stress\n-,kPa\n1.0,0.0\n\n1.1,5.0\n% a pause\n1.2,9.0\n1.3,12.5\n"
    table = read_table(written(tmp_path, text))
    lines = text.splitlines()
    own = [float(lines[number - 1].partition(",")[0]) for number in table.lines]
    assert own == table.columns["stretch"].values.tolist()


@pytest.mark.parametrize("encoding", ["utf-16", "utf-16-le", "utf-16-be", "utf-8-sig", "latin-1"])
def test_encodings(encoding, tmp_path):
    text = PLAIN.replace("stretch", "id,stretch").replace("\n1", "\n20\N{DEGREE SIGN}C,1")
    mark = "\ufeff" if encoding.startswith("utf-16-") else ""
    table = read_table(written(tmp_path, mark + text, encoding=encoding))
    assert table.columns["id"].words[0] == "20\N{DEGREE SIGN}C"
    assert any("Latin-1" in note for note in table.notes) == (encoding == "latin-1")


def test_what_was_interpreted_is_named(tmp_path):
    text = SAME["semicolons and decimal commas"].replace("stretch", "id;stretch").replace("\n1", "\n\ufffd;1")
    table = read_table(written(tmp_path, text + "\ufffd;1,4\n"))
    assert table.notes == (
        "letters were lost when it was exported (they read \ufffd), numbers were not",
        "cells are separated by semicolons",
        "line 6, the last, is cut off (2 cells of 3) and left out",
        "decimals are written with commas: 1,0 is 1.0",
    )


REFUSED = {
    "force without a unit": (
        "lam,F\n1,0\n1.1,5\n1.2,9\n1.3,12\n",
        'test.csv, line 1: column "F" has no unit; write "F (N)", or name it in tests.toml: force = "F, mN"',
    ),
    "commas for everything": (
        "stretch,stress (kPa)\n1,0,0,0\n1,1,5,0\n",
        "test.csv: decimal comma and comma separator cannot be distinguished in line 2; export with semicolons",
    ),
    "kilopascals without a unit": (
        "stretch,stress\n1,0\n1.1,5\n1.2,9\n1.3,12.5\n",
        "test.csv: the largest stress is 12.5: is it in kPa or MPa? write the unit",
    ),
    "kilovolts without a unit": (
        "stretch,stress (kPa),voltage\n1,0,6\n1.1,5,6\n1.2,9,6\n1.3,12.5,6\n",
        "test.csv: 4 of 4 voltages are below 20 V: kilovolts? write the unit",
    ),
    "a foreign unit": (PLAIN.replace("kPa", "psi"), "'psi' is not a unit of pressure; write one of Pa, kPa, MPa"),
    "marks between thousands": (
        "stretch;stress (Pa)\n1,0;0\n1,1;5.000,1\n1,2;9000\n1,3;12500\n",
        "line 3: column 'stress' holds '5.000,1'; give one number a cell",
    ),
    "points and commas": (
        "stretch;stress (Pa)\n1,0;0.5\n1,1;5000,1\n1,2;9000\n1,3;12500\n",
        "line 2: column 'stress' has decimal points and decimal commas (0.5)",
    ),
    "too many cells": (PLAIN + "1.4,15,3\n", "line 6: has 3 cells for 2 columns"),
    "too few cells": (PLAIN.replace("1.1,5.0", "1.1"), "line 3: has 1 cells for 2 columns; complete it"),
    "no header": ("1,0\n1.1,5\n", "line 1: is a row of numbers, not a header"),
    "no rows": ("stretch,stress (kPa)\n", "has a header and no numbers"),
    "nothing": ("", "is empty"),
    "only separators": (",,,\n;;;\n", "is empty"),
    "two columns of one name": ("a,a\n1,2\n3,4\n", "has two columns 'a'"),
    "a column without a name": ("stretch,,stress (kPa)\n1,2,3\n", "column 2 has no name"),
    "two columns for one thing": (
        "stretch,lambda,stress (kPa)\n1,1,0\n1,1,0\n1,1,0\n1,1,0\n",
        "columns 'stretch' and 'lambda' both look like stretch",
    ),
    "no stress": ("stretch,temp\n1,2\n1,2\n1,2\n1,2\n", "no column is a stress (columns: stretch, temp)"),
    "three rows": ("stretch,stress (kPa)\n1,0\n1.1,5\n1.2,9\n", "has 3 rows; give at least 4"),
    "strain as stretch": (
        "stretch,stress (kPa)\n0,0\n0.1,5\n0.2,9\n0.3,12\n",
        "line 2: stretch 0: must be over 0 and at most 50; is it a strain",
    ),
    "percent as stretch": ("stretch,stress (kPa)\n1,0\n110,5\n120,9\n130,12\n", "line 3: stretch 110: must be over 0"),
    "time that runs back": (
        "time (s),stretch,stress (kPa)\n0,1,0\n2,1.1,5\n1,1.2,9\n3,1.3,12\n",
        "line 4: the time does not increase",
    ),
    "a temperature in Fahrenheit": (
        "stretch,stress (kPa),temp (F)\n1,0,70\n1.1,5,70\n1.2,9,70\n1.3,12,70\n",
        "'F' is not K or degC",
    ),
    "a negative rate": (
        "stretch,stress (kPa),rate (1/s)\n1,0,-1\n1.1,5,-1\n1.2,9,-1\n1.3,12,-1\n",
        "strain rate -1: must be greater than 0",
    ),
    "a rate in mm/s": ("stretch,stress (kPa),rate (mm/s)\n1,0,1\n1.1,5,1\n1.2,9,1\n1.3,12,1\n", "is not a strain rate"),
    "infinity": (PLAIN + "1.4,1e999\n", "column 'stress' holds '1e999'"),
    "a huge exponent": (PLAIN + "1.4,1\n1.5,1e308e5\n", "column 'stress' holds '1e308e5'"),
    "words for numbers": ("stretch,stress (kPa)\na,b\nc,d\ne,f\ng,h\n", "holds words"),
    "a quote that is not closed": ('stretch,stress (kPa)\n"1,0\n1.1,5\n', "close every quote"),
    "binary": (bytes(range(256)) * 40, "is not text"),
    "zeros": (b"\x00" * 5000, "is not text"),
    "half of UTF-16": (b"\xff\xfe" + "stretch".encode("utf-16-le") + b"1", "is not UTF-16 text"),
    "too many columns": (",".join(f"c{k}" for k in range(100)) + "\n1\n", "has 100 columns; give at most 64"),
    "a permittivity below 1": ("freq (Hz),dielec\n1,4.7\n10,0.3\n", "a relative permittivity of 0.3 is below 1"),
    "extension without a length": (
        "extension (mm),stress (kPa)\n0,0\n1,5\n2,9\n3,12\n",
        'test.csv: its extension needs gauge_length; add gauge_length = "20 mm" in tests.toml',
    ),
}


@pytest.mark.parametrize("kind", REFUSED)
def test_a_file_that_is_not_certain_is_refused_in_one_line(kind, tmp_path):
    text, message = REFUSED[kind]
    with pytest.raises(InputError) as error:
        read_tests(written(tmp_path, text))
    assert message in str(error.value)
    assert "\n" not in str(error.value)


@pytest.mark.parametrize(
    ("name", "message"),
    [
        ("data.tdms", "data.tdms: TDMS is not read; export CSV (TDMS has a viewer that does) with units in the header"),
        ("data.xlsx", "Excel files are not read; save the sheet as CSV (UTF-8) with units in the header"),
        ("data.mat", "there is no such file"),
        ("data.uff", "UFF is not read"),
        ("no-such.csv", "there is no such file"),
        (".", "is a folder"),
    ],
)
def test_files_that_are_no_tables(name, message, tmp_path):
    with pytest.raises(InputError) as error:
        read_tests(tmp_path / name)
    assert message in str(error.value)


def test_what_cannot_be_read_to_an_end_is_not_opened(tmp_path):
    os.mkfifo(tmp_path / "pipe.csv")
    with pytest.raises(InputError, match="is not a regular file"):
        read_tests(tmp_path / "pipe.csv")
    large = tmp_path / "large.csv"
    with large.open("wb") as file:
        file.truncate(2**24 + 1)
    with pytest.raises(InputError, match="is larger than 16 MB"):
        read_tests(large)


@pytest.mark.parametrize("seed", range(60))
def test_damaged_files_are_read_or_refused_in_one_line(seed, tmp_path):
    """Cells and bytes of a good file changed at random."""
    rng = random.Random(seed)
    text = rng.choice([*SAME.values(), *(t for t, _ in REFUSED.values() if isinstance(t, str))]).encode()
    data = bytearray(text)
    for _ in range(rng.randint(1, 6)):
        at = rng.randrange(len(data) + 1)
        piece = rng.choice(
            [b",", b";", b"\n", b"\t", b'"', b"\x00", b"\xff", b"-", b"e", b"9" * 400, b"(", b"nan", b"%"]
        )
        data[at : at + rng.randint(0, 3)] = piece
    said = ""
    try:
        read_tests(written(tmp_path, bytes(data)))
    except InputError as error:
        said = str(error)
    assert "\n" not in said
    assert len(said) < 400


def test_a_column_is_known_by_many_names(tmp_path):
    for name in ("lambda", "Stretch Ratio", "STRETCH", "stretch_ratio"):
        table = read_table(written(tmp_path, PLAIN.replace("stretch", name)))
        assert roles_of(table, {})["stretch"][0].name == name


def test_a_binary_file_may_have_as_many_rows_as_a_table_and_no_more(monkeypatch):
    vectors = {"stress": (np.arange(5.0), "Pa"), "stretch": (np.ones(5), None)}
    monkeypatch.setattr(module, "read_vectors", lambda path, file, remedy: vectors)
    monkeypatch.setattr(module, "MOST_ROWS", 5)
    found = module.read_table(Path("a.mat"))
    assert (found.file, list(found.lines), found.columns["stress"].unit) == ("a.mat", [1, 2, 3, 4, 5], "Pa")
    np.testing.assert_array_equal(found.columns["stress"].values, np.arange(5.0))
    monkeypatch.setattr(module, "MOST_ROWS", 4)
    with pytest.raises(InputError, match=r"a\.mat: has 5 rows; give at most 4"):
        module.read_table(Path("a.mat"))


# --- one reader for all ----------------------------------------------------------------------------------------------

SERIES = "time (ms),voltage (kV),stroke (mm)\n0,0,0\n200,0.7,1\n1500,0.25,2.5\n"
ALIKE = {
    "commas": SERIES,
    "a slash": SERIES.replace(" (ms)", "/ms").replace(" (kV)", " / kV").replace(" (mm)", "/mm"),
    "short names": SERIES.replace("time", "T").replace("voltage", "HV"),
    "minutes": "t (min),u (V),stroke (mm)\n0,0,0\n0.5,1,1\n2,3,2.5\n",
    "tabs": SERIES.replace(",", "\t"),
    "decimal commas": SERIES.replace(",", ";").replace(".", ","),
    "quoted decimal commas": SERIES.replace("0.25,2.5", '"0,25","2,5"').replace("0.7", '"0,7"'),
    "a second row": SERIES.replace(" (ms)", "").replace(" (kV)", "").replace(" (mm)\n", "\nms,kV,mm\n"),
    "comments": "# a rig\n% of ours\n" + SERIES.replace("200,", "\n# a pause\n200,"),
    "UTF-16": SERIES.encode("utf-16"),
    "a byte-order mark": "\ufeff" + SERIES,
    "Latin-1": re.sub(r"\n(\d+),", r"\n\1,20,", SERIES.replace(",v", ",\N{DEGREE SIGN}C,v")).encode("latin-1"),
    "a cut-off last line": SERIES + "1600,0.",
    "a trailing separator": SERIES.replace("\n", ",\n"),
    "words": re.sub(r"\n(\d+),", r"\n\1,on,", SERIES.replace(",v", ",note,v")),
    "an empty cell": SERIES.replace("0.7", ""),
    "no number": SERIES.replace("0.7", "inf"),
    "a number too many": SERIES.replace("0.7", "0,7"),
    "too large": SERIES.replace("0.7", "1e21"),
    "marks of thousands": SERIES.replace("0.7", '"1,000"').replace("0.25", '"2,000"'),
    "repeated headings": SERIES.replace("stroke", "time"),
    "no header": SERIES.partition("\n")[2],
    "a quote": SERIES.replace("0.7", '"0.7'),
    "a bracket": SERIES.replace("(kV)", "(kV"),
    "a foreign unit": SERIES.replace("kV", "A"),
    "zeros": SERIES.replace("0.7", "\0"),
    "a million columns": ",".join(["a"] * 1_000_000) + "\n1\n",
    "nothing": "",
}


@pytest.mark.parametrize("kind", ALIKE)
def test_a_recording_and_a_test_on_a_device_read_a_table_alike(kind, tmp_path):
    """The same numbers with the same notes, or the same message."""
    path = written(tmp_path, ALIKE[kind])
    written(tmp_path, '[[test]]\nkind = "series"\nfile = "test.csv"\nnoise = "10 um"\n', "list.toml")
    if list(ALIKE).index(kind) >= list(ALIKE).index("an empty cell"):
        with pytest.raises(InputError) as one:
            read_recording(path, True)
        with pytest.raises(InputError) as other:
            read_device_tests(tmp_path / "list.toml")
        assert str(one.value) == str(other.value)
        return
    with warnings.catch_warnings(record=True) as stated:
        warnings.simplefilter("always")
        times, volts = read_recording(path, True)
    (test,) = read_device_tests(tmp_path / "list.toml").tests
    np.testing.assert_array_equal(test.set["time"], times)
    np.testing.assert_array_equal(test.set["voltage"], volts)
    assert [str(one.message) for one in stated] == [f"test.csv: {'; '.join(test.notes)}"] * bool(test.notes)
    if kind != "minutes":
        np.testing.assert_allclose([times, volts], [[0.0, 0.2, 1.5], [0.0, 700.0, 250.0]], rtol=1e-15)


def test_the_reader_has_bounds(tmp_path, monkeypatch):
    spaces = "a" + " " * 7000 + "b,c\n1,2\n"
    for text in ("\n" * 300_000 + "a,b", spaces, "(" * 7000, "a," * 5000, "9" * 200_000):
        begin = time.process_time()
        with pytest.raises(InputError) as error:
            read_table(written(tmp_path, text))
        assert time.process_time() - begin < 1.0
        assert len(str(error.value)) < 250
    with pytest.raises(InputError, match=r"is a header of 900\d letters"):
        read_table(written(tmp_path, "a" + " " * 9000 + "b,c\n1,2\n"))
    monkeypatch.setattr(module, "MOST_ROWS", 5)
    with pytest.raises(InputError, match="has more than 5 rows"):
        read_table(written(tmp_path, SERIES + "1,2,3\n" * 10 + '"'))
    path = written(tmp_path, SERIES, "a\nb.csv")
    with pytest.raises(InputError, match=r"^a\?b.csv, line 3: "):
        read_recording(written(tmp_path, SERIES.replace("0.7", "x"), path.name), True)
    (tmp_path / "link.csv").symlink_to("/dev/zero")
    with pytest.raises(InputError, match="is not a regular file"):
        read_table(tmp_path / "link.csv")


@pytest.mark.parametrize("read", [gelcone.read_wish, gelcone.read_device_tests, gelcone.compare_measured])
def test_what_is_no_path_is_refused_in_the_name_of_the_function(read):
    with pytest.raises(
        InputError, match=f"^{read.__name__}: was given the number 3; give the path of a file or folder"
    ):
        read(3)


def test_lines_above_the_header_of_a_machines_export_are_named_and_left_out_once_marked(tmp_path):
    above = ["Pruefmaschine Z005;;", "Probe;Gel 3;", "Zeit;Kraft", "s;mN", "0;0,5", "1;1,5"]
    with pytest.raises(InputError, match=r"line 3: has 2 cells for 1 columns; .* lines above the header a # before"):
        read_table(written(tmp_path, "\n".join(above)))
    found = read_table(written(tmp_path, "\n".join(["# " + line for line in above[:2]] + above[2:])))
    assert found.columns["Kraft"].unit == "mN"
    np.testing.assert_array_equal(found.columns["Kraft"].values, [0.5, 1.5])

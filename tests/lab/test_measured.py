"""Lists of measured files: what a table [[test]] may state, in SI, and which tests are taken."""

import numpy as np
import pytest

from gelcone.errors import InputError
from gelcone.lab.measured import _setting, listed_tables, notes_of, place_of, read_tests

TABLE = "test,stretch,stress (kPa)\n" + "".join(
    f"{test},{1.0 + 0.1 * k},{test * k}\n" for test in (1, 2) for k in range(5)
)


def written(folder, text, name):
    path = folder / name
    path.write_text(text)
    return path


@pytest.fixture
def lists(tmp_path):
    (tmp_path / "pulls.csv").write_text(TABLE)

    def write(text):
        (tmp_path / "tests.toml").write_text(text)
        return tmp_path / "tests.toml"

    return write


@pytest.mark.parametrize(
    ("key", "value", "found"),
    [
        ("thickness", "0.5 mm", 5e-4), ("gauge_length", "20 mm", 0.02), ("specimen_width", "1 cm", 0.01),
        ("voltage", "3 kV", 3e3), ("voltage", 0, 0.0), ("hold_from", "2 min", 120.0), ("hold_from", 0.0, 0.0),
        ("rate", "0.05 1/s", 0.05), ("loading_rate", "0.2/s", 0.2), ("rate", 0.3, 0.3),
        ("temperature", "20 degC", 293.15), ("temperature", "293 K", 293.0), ("only", [101, "b"], ["101", "b"]),
        ("mode", "uniaxial", "uniaxial"), ("width", "held", "held"),
    ],
)  # fmt: skip
def test_settings_are_read_in_si(key, value, found):
    assert _setting("here", key, value) == pytest.approx(found) if isinstance(found, float) else found


@pytest.mark.parametrize(
    ("key", "value", "message"),
    [
        ("thickness", 0.0, "thickness"), ("thickness", "-1 mm", "thickness"), ("gauge_length", "5 V", "gauge_length"),
        ("voltage", "-1 kV", "voltage"), ("rate", 0.0, "rate"), ("temperature", 20, "has no unit"),
        ("only", [], "must be a list of ids"), ("only", "a", "must be a list of ids"), ("mode", "uniaxal", "uniaxial"),
        ("stress", 3.0, "must name a column"),
    ],
)  # fmt: skip
def test_settings_that_cannot_be_are_refused_where_they_stand(key, value, message):
    with pytest.raises(InputError, match=f"^here: .*{message}"):
        _setting("here", key, value)


def test_the_tests_that_are_asked_for_are_taken_in_that_order(lists):
    every = read_tests(lists('[[test]]\nfile = "pulls.csv"\n'))
    assert len(every.coupons) == 2
    own = read_tests(lists('[[test]]\nfile = "pulls.csv"\nonly = [2, 1]\nthickness = "0.5 mm"\nvoltage = "1 kV"\n'))
    assert [float(test.stress.max()) for test in own.coupons] == [8e3, 4e3]
    assert {(test.thickness, test.voltage) for test in own.coupons} == {(5e-4, 1e3)}
    assert len(read_tests(lists('[[test]]\nfile = "pulls.csv"\nonly = [2]\n')).coupons) == 1
    with pytest.raises(InputError, match=r"pulls\.csv: .*'3'"):
        read_tests(lists('[[test]]\nfile = "pulls.csv"\nonly = [3]\n'))


def test_an_id_of_several_words_names_one_test(tmp_path):
    """Two ids that end alike are two tests."""
    rows = [f"{name},{s},{k * s}" for k, name in ((1, "soft 1"), (2, "hard 1")) for s in (1.0, 1.1, 1.2, 1.3)]
    (tmp_path / "pulls.csv").write_text("\n".join(["id,stretch,stress (kPa)", *rows, ""]))
    (tmp_path / "list.toml").write_text('[[test]]\nfile = "pulls.csv"\nonly = ["soft 1"]\n')
    (test,) = read_tests(tmp_path / "list.toml").coupons
    assert (test.name, float(test.stress.max())) == ("pulls soft 1", pytest.approx(1.3e3))


@pytest.mark.parametrize(
    "name", ["/etc/passwd", "../pulls.csv", "a/../../b.csv", "c:\\x.csv", "a:b", "", "  ", None, 3]
)
def test_files_lie_in_the_folder_of_the_list(tmp_path, name):
    with pytest.raises(InputError, match=r"must lie in the folder|file is missing"):
        place_of(tmp_path / "tests.toml", "here", name)
    assert place_of(tmp_path / "tests.toml", "here", "sub/pulls.csv") == tmp_path / "sub" / "pulls.csv"


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ('[[test]]\nfile = "pulls.csv"\n[[test]]\nfile = "pulls.csv"\n', "is listed twice"),
        ('[[test]]\nfile = "pulls.csv"\nthicknes = 3\n', "test 1: .*did you mean 'thickness'"),
        ('title = "mine"\n', "'title' is not known"),
        ("test = []\n", "give a list of tests"),
        ("[[test]\n", "broken TOML"),
        ('[[test]]\nfile = "a.csv"\n' * 201, "lists 201 files; give at most 200"),
    ],
)
def test_lists_that_cannot_be_used_are_refused(lists, text, message):
    with pytest.raises(InputError, match=message):
        read_tests(lists(text))


def test_other_tables_are_handed_on_where_they_are_known(lists):
    path = lists('[[test]]\nfile = "pulls.csv"\n[device]\nname = "x"\n')
    tables, others = listed_tables(path, ("device", "amplifier"))
    assert tables == [{"file": "pulls.csv"}]
    assert others == {"device": {"name": "x"}}
    with pytest.raises(InputError, match="'device' is not known"):
        listed_tables(path)


def test_files_are_named_and_settings_reach_their_tests_alone(lists, tmp_path):
    (tmp_path / "more.csv").write_text("stretch,stress (kPa)\n" + "".join(f"{1 + 0.1 * k},{k}\n" for k in range(5)))
    (tmp_path / "eps.csv").write_text("freq (Hz),dielec\n1,5\n10,4\n")
    text = (
        '[[test]]\nfile = "pulls.csv"\nmode = "pure shear"\n[[test]]\nfile = "more.csv"\nrate = "0.1 1/s"\n'
        '[[test]]\nfile = "eps.csv"\n'
    )
    found = read_tests(lists(text))
    assert found.files == ("pulls.csv", "more.csv", "eps.csv")
    assert [(test.name, test.mode, test.kind) for test in found.coupons] == [
        ("pulls 1", "pure shear", "quasi-static"), ("pulls 2", "pure shear", "quasi-static"),
        ("more", "uniaxial", "loading"),
    ]  # fmt: skip
    assert [one.name for one in found.spectra] == ["eps"]
    alone = read_tests(tmp_path / "more.csv", tmp_path / "eps.csv")
    assert (alone.files, len(alone.coupons), len(alone.spectra)) == (("more.csv", "eps.csv"), 1, 1)
    assert (alone.coupons[0].use, alone.coupons[0].kind, alone.coupons[0].width) == ("fit", "quasi-static", "free")
    with pytest.raises(InputError, match="no measured file is given"):
        read_tests()


def test_a_list_may_have_as_many_files_as_are_allowed(lists):
    text = "".join(f'[[test]]\nfile = "{k}.csv"\n' for k in range(200))
    assert len(listed_tables(lists(text))[0]) == 200


@pytest.mark.parametrize(
    ("value", "kelvin"), [("20degC", 293.15), ("-10 degC", 263.15), ("300K", 300.0), (" 1 K ", 1.0)]
)
def test_a_temperature_is_read_in_either_unit(value, kelvin):
    assert _setting("here", "temperature", value) == pytest.approx(kelvin)


PLAIN = "stretch,stress (kPa)\n1.0,0.0\n1.1,5.0\n1.2,9.0\n1.3,12.5\n"
LISTS = {
    "broken": ("[[test]\n", "broken TOML"),
    "nothing": ("", "give a list of tests: a table [[test]] for each file"),
    "an unknown table": ("[[tests]]\nfile = 'test.csv'\n", "'tests' is not known"),
    "an unknown setting": (
        "[[test]]\nfile = 'test.csv'\nthicknes = '1 mm'\n",
        "'thicknes' is not a setting of a test; did you mean 'thickness'?",
    ),
    "no file": ("[[test]]\nmode = 'uniaxial'\n", "list.toml, test 1: file is missing"),
    "a file elsewhere": ("[[test]]\nfile = '../secret.csv'\n", "must lie in the folder of the list; put it there"),
    "a file at the root": ("[[test]]\nfile = '/etc/passwd'\n", "must lie in the folder of the list; put it there"),
    "a Windows path": ("[[test]]\nfile = 'C:\\\\secret.csv'\n", "must lie in the folder of the list; put it there"),
    "a file that is not there": ("[[test]]\nfile = 'other.csv'\n", "there is no such file"),
    "an unknown mode": ("[[test]]\nfile = 'test.csv'\nmode = 'biaxial'\n", "'biaxial' is not a mode; did you mean"),
    "a thickness without a unit": ("[[test]]\nfile = 'test.csv'\nthickness = '1'\n", "thickness = '1': has no unit"),
    "no thickness at all": ("[[test]]\nfile = 'test.csv'\nthickness = 0.0\n", "must be greater than 0 m"),
    "a temperature without a unit": ("[[test]]\nfile = 'test.csv'\ntemperature = 20\n", "write '20 degC' or '293 K'"),
    "a test that is not there": ("[[test]]\nfile = 'test.csv'\nonly = [7]\n", "'7' is not a test of the file"),
    "only what": ("[[test]]\nfile = 'test.csv'\nonly = 7\n", "must be a list of ids, such as [101, 102]"),
    "another unit than in the heading": (
        "[[test]]\nfile = 'test.csv'\nstress = 'stress, MPa'\n",
        "is in kPa by its heading and in MPa",
    ),
    "a column that is not there": ("[[test]]\nfile = 'test.csv'\nstress = 'F, kPa'\n", "'F' is not a column"),
    "a column that is a number": ("[[test]]\nfile = 'test.csv'\nstress = 7\n", "must name a column"),
    "twice the same": ("[[test]]\nfile = 'test.csv'\n[[test]]\nfile = 'test.csv'\n", "test.csv: is listed twice"),
}


@pytest.mark.parametrize("kind", LISTS)
def test_a_list_that_is_wrong_is_refused_in_one_line(kind, tmp_path):
    written(tmp_path, PLAIN, "test.csv")
    text, message = LISTS[kind]
    with pytest.raises(InputError) as error:
        read_tests(written(tmp_path, text, "list.toml"))
    assert message in str(error.value)
    assert "\n" not in str(error.value)


def test_a_list_says_what_a_header_does_not(tmp_path):
    written(tmp_path, "L,F\n0,0\n2,0.1\n4,0.18\n6,0.25\n", "tension.csv")
    text = """
        [[test]]
        file = "tension.csv"
        force = "F, N"
        extension = "L, mm"
        gauge_length = "20 mm"
        specimen_width = "10 mm"
        thickness = "1 mm"
        rate = "0.1 1/s"
        temperature = "22 degC"
        mode = "pure shear"
        use = "check"
    """
    (test,) = read_tests(written(tmp_path, text, "list.toml")).coupons
    np.testing.assert_allclose(test.stretch, [1.0, 1.1, 1.2, 1.3])
    np.testing.assert_allclose(test.stress, [0.0, 1e4, 1.8e4, 2.5e4])
    np.testing.assert_allclose(test.time, [0.0, 1.0, 2.0, 3.0])
    assert (test.mode, test.kind, test.use) == ("pure shear", "loading", "check")
    assert test.temperature == pytest.approx(295.15)


def test_a_note_is_said_once_of_the_files_or_tests_that_it_is_about():
    read = [("a.csv", "a1", ("thinned", "warm")), ("a.csv", "a2", ("thinned",)), ("b.csv", "b", ("warm",))]
    assert notes_of(read) == [("thinned", ["a.csv"]), ("warm", ["a1", "b.csv"])]

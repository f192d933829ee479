"""`gelcone fit`: measured files in, a material, a figure and words out."""

import re
import shutil
from pathlib import Path

import numpy as np
import pytest

import gelcone
from gelcone.devices.device import Device
from tests.answers import result

VHB = Path(__file__).parents[2] / "docs" / "measured" / "vhb"
QUICK = ("--laws", "yeoh,gent", "--branches", "1,2", "--draws", "4")


@pytest.fixture
def vhb(command_line, tmp_path):
    """The command line in a folder with tests on VHB."""
    for path in VHB.iterdir():
        shutil.copy(path, tmp_path / path.name)
    return command_line


def test_a_fit_from_files_to_a_device(vhb, tmp_path, undrawn):
    code, out, err = vhb("fit", "material.toml", "--data", "tests.toml", *QUICK, "--out", "fitted")
    assert code == 0, err
    assert out.startswith("VHB 4905: yeoh with 2 Maxwell branches, logarithmic flow\n  fitted to 13 tests at 20 degC\n")
    for line in (
        "mean error of tests left out, %, by number of branches:",
        "  yeoh           10.67    5.19",
        "chosen: yeoh, 2: the fewest branches within 3 % of the best (a device takes up to 3)",
        "  vhb-cyclic-0kV 702: at 50 degC, not at 20 degC as most: left out",
        "  vhb-quasi-static 202: repeats the first 24 rows of vhb-quasi-static 201: left out",
        "wrote fitted/material.toml",
    ):
        assert line in out.splitlines(), line
    table = (tmp_path / "fitted" / "material.toml").read_text(encoding="utf-8")
    pump = [line for line in gelcone.find_device("biased-pump").to_toml().splitlines() if "material =" not in line]
    device = Device.from_text("\n".join([*pump, 'film = "taut"', table]))
    assert device.material == gelcone.fitted_material(gelcone.load(tmp_path / "fitted" / "fit.nc"))
    assert vhb("fit", "material.toml", "--data", "tests.toml", *QUICK, "--out", "fitted")[0] == 2
    code, shown, _ = vhb("show", "fitted/fit.nc")
    assert code == 0
    assert shown.splitlines() == out.splitlines()[: len(shown.splitlines())]


def test_the_guide_shows_what_is_printed(vhb):
    page = (VHB.parents[1] / "lab.md").read_text(encoding="utf-8")
    (block,) = re.findall(r"```text\n(VHB.*?)```", page, flags=re.DOTALL)
    code, out, err = vhb("fit", "material.toml", "--data", "tests.toml", "--draws", "2")
    assert code == 0, err
    printed = iter(out.splitlines())
    for line in block.splitlines():
        assert any(own.startswith(line.removesuffix(" ...")) for own in printed), line


def test_files_without_a_list_and_the_answer_as_json(vhb):
    data = [f"vhb-{name}.csv" for name in ("loading-20C", "relaxation", "dielectric")]
    code, out, err = vhb("fit", *(word for name in data for word in ("--data", name)), *QUICK, "--json")
    assert code == 0, err
    found = result(out)
    assert found["command"] == "fit"
    assert found["chosen_law"] == "yeoh"
    assert found["material"]["law"] == "yeoh"
    assert found["files"] == data
    assert len(found["test_name"]) == 11
    assert "stretch" not in found


@pytest.mark.parametrize(
    ("typed", "message"),
    [
        (["--data", "none.csv"], "none.csv: there is no such file; give a CSV file with a header"),
        ([], "--data is missing; give tests.toml or a measured CSV file"),
        (["none.toml", "--data", "tests.toml"], "none.toml: there is no such file"),
        (["bad.toml", "--data", "tests.toml"], "'modulus' is not a material field; did you mean"),
        (["--data", "tests.toml", "--laws", "mooney"], "'mooney' is not a law; known: gent, neo-hookean, yeoh"),
        (["--data", "tests.toml", "--branches", "two"], "--branches = 'two': must be whole numbers, such as 1,2,3"),
        (["--data", "tests.toml", "--flow", "fast"], "'fast' is not a flow; known: log, linear"),
        (["--data", "vhb-quasi-static.csv"], "relative_permittivity: is missing; give it in the material's file"),
        (
            ["known.toml", "--data", "one.csv", "--laws", "yeoh,gent"],
            "Error: --laws: of 1 tests, fewer than 3, none can be left out to choose a law; give one law and one",
        ),
    ],
)
def test_what_is_wrong_is_said_in_one_line(typed, message, vhb, tmp_path):
    (tmp_path / "bad.toml").write_text("[material]\nmodulus = 1\n")
    (tmp_path / "known.toml").write_text("[material]\nrelative_permittivity = 5\n")
    (tmp_path / "one.csv").write_text("stretch,stress (kPa)\n1,0\n1.1,5\n1.2,9\n1.3,12\n")
    code, out, err = vhb("fit", *typed)
    assert (code, out) == (2, "")
    assert message in err
    assert err.count("\n") == 1


def test_a_data_sheet_is_a_page(command_line, tmp_path):
    code, out, err = command_line("datasheet", "biased-pump", "--film", "taut", "--out", "sheet")
    assert code == 0, err
    assert (tmp_path / "sheet" / "datasheet.pdf").read_bytes().startswith(b"%PDF")
    assert (tmp_path / "sheet" / "datasheet.png").stat().st_size > 50_000
    for start in ("constant voltage", "blocked force", "coupling factor, squared", "rise time", "first limit: "):
        assert any(line.startswith(start) for line in out.splitlines()), start
    assert out.endswith("wrote sheet/datasheet.png\nwrote sheet/datasheet.pdf\n")
    assert command_line("datasheet", "biased-pump", "--film", "taut", "--out", "sheet")[0] == 2


PUMP = VHB.parent / "pump"
FREE = ("--free", "spring_rate~10%", "--free", "material.shear_modulus~50%", "--free", "damping_coefficient~100%")


@pytest.fixture
def pump(command_line, tmp_path):
    """The command line in a folder with tests on a pump."""
    for path in PUMP.iterdir():
        shutil.copy(path, tmp_path / path.name)
    return command_line


def test_a_plan_says_what_tests_tell(pump):
    code, out, err = pump("fit", "pump.toml", "--data", "pump-tests.toml", *FREE, "--plan", "--next", "stroke@2.15 kV")
    assert code == 0, err
    assert out.startswith("pump as drawn: plan of 77 readings in 4 tests, taut film\n3 of 3 directions of the fields")
    assert "next for stroke@2.15 kV, what it would leave of the standard deviation:\n" in out
    again = result(pump("fit", "pump.toml", "--data", "pump-tests.toml", *FREE, "--plan", "--json")[1])
    assert again["learnt"] == 3
    assert again["unknown"][0] == "spring_rate"


def test_a_fit_that_chi2_refuses_is_marked_and_ends_with_1(pump, tmp_path, undrawn):
    arguments = (
        "fit",
        "pump.toml",
        "--data",
        "pump-tests.toml",
        "--free",
        "damping_coefficient~100%",
        "--out",
        "fitted",
    )
    code, out, _ = pump(*arguments)
    assert code == 1
    assert "no device of this structure makes these data; the intervals below are not to be relied on" in out
    assert "each test predicted from the others:" in out
    fitted = gelcone.find_device(tmp_path / "fitted" / "device.toml")
    assert fitted == gelcone.fitted_device(gelcone.load(tmp_path / "fitted" / "fit.nc"))
    assert fitted.damping_coefficient != 0.01
    swept = ("sweep", "fitted/device.toml", "--analysis", "limits", "--uncertain", "fitted/draws.nc", "--json")
    code, out, err = pump(*swept)
    assert code == 0, err
    assert len(result(out)["drawn_damping_coefficient"]) == 64
    code, again, err = pump("limits", "fitted/device.toml", "--samples", "fitted/draws.nc", "--json")
    assert code == 0, err
    assert result(again)["drawn_damping_coefficient"] == result(out)["drawn_damping_coefficient"]
    assert result(again)["onset_voltage"] == result(out)["onset_voltage"]
    for command in (("limits", "fitted/device.toml"), ("sweep", "fitted/device.toml", "--analysis", "limits")):
        code, _, err = pump(*command, "--samples", "pump.toml")
        assert (code, err.count("\n")) == (2, 1)
        assert "pump.toml: is not a table of draws; give a file that ends with .csv or .nc" in err
    for name, words in (("damping_coefficient", "it already, with its correlations"), ("spring_rate", "all that is")):
        _, _, err = pump(*swept[:4], "--samples", "fitted/draws.nc", "--uncertain", f"{name}=1:2")
        assert f"--samples fitted/draws.nc and --uncertain {name}: the samples hold {words}" in err


@pytest.mark.parametrize(
    ("typed", "message"),
    [
        (["pump.toml", "--data", "pump-tests.toml"], "free: names no field; give some with priors"),
        (["pump.toml", "--data", "force.csv", *FREE], "is not a list of tests on a device; give tests.toml"),
        (
            ["pump.toml", "--data", "pump-tests.toml", *FREE, "--laws", "yeoh"],
            "--laws: is an option of the fit of a material",
        ),
        (["--data", "force.csv", *FREE], "--free: is an option of the fit of a device"),
        (
            ["biased-pump", "--data", "pump-tests.toml", *FREE, "--free", "hoop_prestretch~3%"],
            "--free hoop_prestretch: the film 'membrane' is computed anew for each value, which takes seconds",
        ),
        (
            ["pump.toml", "--data", "pump-tests.toml", *FREE, "--plan", "--films", "taut,wrinkling"],
            "--films: a plan is that of one structure; give one",
        ),
    ],
)
def test_what_is_wrong_with_a_device_is_said_in_one_line(typed, message, pump):
    code, out, err = pump("fit", *typed)
    assert (code, out) == (2, "")
    assert message in err
    assert err.count("\n") == 1


def test_samples_without_axes_are_said_as_median_and_interval(command_line, tmp_path):
    (tmp_path / "draws.csv").write_text("film_thickness [mm]\n0.19\n0.20\n0.21\n")
    code, out, err = command_line("limits", "biased-pump", "--film", "wrinkling", "--samples", "draws.csv")
    assert code == 0, err
    pump = gelcone.find_device("biased-pump").replace(film="wrinkling")
    middle = float(gelcone.limits(pump.replace(film_thickness="0.2 mm"))["pull_in_voltage"])
    (line,) = (line for line in out.splitlines() if "95 % within" in line)
    assert f": {middle / 1e3:.4g} kV, 95 % within " in line
    assert float(line.partition("within ")[2].split()[0]) < float(line.partition(" to ")[2].split()[0])


def test_samples_of_analyses_over_frequency_have_a_table_a_figure_and_a_file(command_line, tmp_path, undrawn):
    (tmp_path / "draws.csv").write_text("moving_mass [g]\n4.8\n5.0\n5.2\n")
    own = ("--film", "taut", "--samples", "draws.csv", "--over", "frequency=9 Hz:11 Hz:2")
    code, out, err = command_line("envelope", "biased-pump", *own, "--margin", "0.3", "--out", "results")
    assert code == 0, err
    assert "3 draws of moving_mass" in out
    assert "recommended drive, 30% below its limits:\n" in out
    assert out == command_line("show", "results/envelope.nc")[1] + "".join(
        f"wrote results/envelope.{end}\n" for end in ("nc", "png")
    )
    code, out, err = command_line("frequency", "biased-pump", *own, "--json")
    assert code == 0, err
    found = result(out)
    assert np.shape(found["stroke"]) == (3, 2, 2)
    assert found["drive_frequency"] == [9.0, 11.0]
    for command, typed, message in (
        ("frequency", ["--branches"], "branches: is not computed for draws"),
        ("envelope", ["--initial", "1 mm,0 m/s"], "--initial: envelope does not start from a state; leave it out"),
        ("limits", ["--initial", "1 mm,0 m/s"], "--initial: limits does not start from a state; leave it out"),
    ):
        code, _, err = command_line(command, "biased-pump", "--film", "taut", "--samples", "draws.csv", *typed)
        assert (code, err.count("\n")) == (2, 1)
        assert message in err


def test_a_data_sheet_has_tolerances(command_line, tmp_path):
    (tmp_path / "draws.csv").write_text("film_thickness [mm]\n0.19\n0.20\n0.21\n")
    own = ("datasheet", "biased-pump", "--film", "taut", "--over", "constant_voltage=1 kV")
    code, out, err = command_line(*own, "--samples", "draws.csv", "--out", "sheet")
    assert code == 0, err
    assert "tolerances: within these intervals lie 95 % of 3 draws, of film_thickness 4.1 %" in out
    assert (tmp_path / "sheet" / "datasheet.pdf").read_bytes().startswith(b"%PDF")
    assert (tmp_path / "sheet" / "datasheet.png").stat().st_size > 50_000
    code, again, err = command_line(*own, "--uncertain", "draws.csv")
    assert again == "".join(line for line in out.splitlines(keepends=True) if not line.startswith("wrote "))
    code, _, err = command_line(*own, "--samples", "draws.csv", "--uncertain", "film_thickness=0.1 mm:0.2 mm")
    assert (code, err.count("\n")) == (2, 1)
    assert "--uncertain film_thickness: the samples hold it already, with its correlations; leave one out" in err


def test_an_envelope_of_draws_of_a_model_needs_no_start(command_line, tmp_path):
    (tmp_path / "draws.csv").write_text("rest_height\n0.3\n0.31\n")
    own = (
        "envelope",
        "--set",
        "voltage_bias=0.1",
        "--over",
        "peak_voltage=0.3:0.6:2",
        "--over",
        "drive_frequency=0.3:0.5:2",
    )
    code, out, err = command_line(*own, "--samples", "draws.csv")
    assert code == 0, err
    assert "recommended drive, 20% below its limits" in out


def test_a_first_list_of_tests_is_a_plan_as_it_is(pump):
    assert pump("init", "--tests", "first.toml")[0] == 0
    code, out, err = pump("fit", "pump.toml", "--data", "first.toml", *FREE, "--plan")
    assert code == 0, err
    assert out.startswith("pump as drawn: plan of 24 readings in 4 tests, taut film\n3 of 3 directions of the fields")
    code, _, err = pump("init", "--tests", "--wish", "second.toml")
    assert (code, err) == (2, "Error: --wish and --tests: give one of them\n")


def test_columns_that_are_not_used_are_asked_for(pump, tmp_path):
    (tmp_path / "gang.csv").write_text("f (Hz),Hub (um),phase (deg)\n4,70,-1\n6,80,-2\n", encoding="utf-8")
    head = '[[test]]\nkind = "frequency response"\nfile = "gang.csv"\n'
    head += 'voltage_offset = "1 kV"\nvoltage_amplitude = "60 V"\n'
    fit = ("fit", "pump.toml", "--data", "list.toml", *FREE, "--plan")
    for more, message in (
        ('noise = "8 um"', "test 1: which column of gang.csv is amplitude? not used yet: Hub; name it, amplitude = "),
        (
            'amplitude = "Hub, um"',
            "the noise is missing; give that of the displacement at the frequency of the drive, no",
        ),
    ):
        (tmp_path / "list.toml").write_text(head + more, encoding="utf-8")
        code, _, err = pump(*fit)
        assert (code, err.count("\n")) == (2, 1)
        assert message in err
    (tmp_path / "list.toml").write_text(head + 'amplitude = "Hub, um"\nnoise = "8 um"', encoding="utf-8")
    assert pump(*fit)[0] == 0


def test_forces_of_the_opposite_sign_are_said_and_can_be_turned_round(pump, tmp_path):
    text = (tmp_path / "pump-tests.toml").read_text(encoding="utf-8")
    (tmp_path / "turned.toml").write_text(text.replace('force = "F, mN"', 'force = "-F, mN"'), encoding="utf-8")
    code, _, err = pump("fit", "pump.toml", "--data", "turned.toml", *FREE)
    assert (code, err.count("\n")) == (2, 1)
    assert "blocked force, force.csv: force has the opposite sign of the device's; upward is positive" in err
    lines = (tmp_path / "force.csv").read_text(encoding="utf-8").splitlines()
    rows = [line.rsplit(",", 1) for line in lines[1:]]
    (tmp_path / "force.csv").write_text("\n".join([lines[0], *(f"{a},{-float(b)}" for a, b in rows)]), encoding="utf-8")
    turned = result(pump("fit", "pump.toml", "--data", "turned.toml", *FREE, "--json")[1])
    shutil.copy(PUMP / "force.csv", tmp_path / "force.csv")
    assert turned["chi2"] == result(pump("fit", "pump.toml", "--data", "pump-tests.toml", *FREE, "--json")[1])["chi2"]


def test_a_fit_that_runs_out_of_a_field_says_so(pump, tmp_path):
    (tmp_path / "stroke.csv").write_text("voltage (V),stroke (um)\n1000,1\n1500,2\n", encoding="utf-8")
    (tmp_path / "list.toml").write_text(
        '[[test]]\nkind = "stroke over voltage"\nfile = "stroke.csv"\nnoise = "0.1 um"\n', encoding="utf-8"
    )
    free = ("--free", "material.relative_permittivity~300%")
    code, _, err = pump("fit", "pump.toml", "--data", "list.toml", *free)
    assert (code, err.count("\n")) == (2, 1)
    assert "Error: the fit runs into material.relative_permittivity" in err
    assert "are the units and signs of the readings right? else give that field a narrower prior" in err

"""A newcomer's first minutes: a device file of one's own, three numbers changed, and what it does."""

import re
import time

import pytest

import gelcone
from tests.answers import answer

pytestmark = pytest.mark.usefixtures("computed_once")

COMMANDS = {
    "simulate": ["--periods", "10"],
    "static": ["--over", "constant_voltage=0 V:1.5 kV:4"],
    "frequency": ["--over", "frequency=8 Hz:9 Hz:2"],
    "envelope": ["--over", "frequency=8 Hz,10 Hz", "--over", "peak_voltage=500 V:1.5 kV:3"],
    "map": ["--over", "film_thickness=0.2 mm:0.3 mm:3", "--over", "moving_mass=4 g:8 g:3", "--patience", "1 s"],
}
AXES = {
    "simulate": {"time": "ms"},
    "static": {"constant_voltage": "V", "displacement": "mm"},
    "frequency": {"drive_frequency": "Hz"},
    "envelope": {"drive_frequency": "Hz"},
    "map": {"film_thickness": "mm", "moving_mass": "g"},
}


@pytest.fixture
def device_file(command_line, tmp_path):
    """A first device file with three numbers changed."""
    code, out, err = command_line("init", "mine.toml")
    assert (code, err) == (0, ""), err
    assert "gelcone simulate mine.toml" in out
    path = tmp_path / "mine.toml"
    text = path.read_text(encoding="utf-8")
    for name, new in {"film_thickness": "0.25 mm", "voltage_amplitude": "700 V", "moving_mass": "6 g"}.items():
        text, count = re.subn(rf'^{name} = ".*"$', f'{name} = "{new}"', text, flags=re.MULTILINE)
        assert count == 1, name
    path.write_text(text, encoding="utf-8")
    return path


@pytest.mark.parametrize("command", [name for name in COMMANDS if name != "envelope"])
def test_a_first_device_answers_in_its_own_words(command, command_line, device_file, tmp_path):
    check(command, command_line, tmp_path)


@pytest.mark.slow
def test_the_window_of_a_first_device(command_line, device_file, tmp_path):
    check("envelope", command_line, tmp_path)


@pytest.mark.slow
def test_all_of_it_takes_less_than_a_minute_on_two_cores(command_line, device_file, tmp_path):
    begun = time.process_time()
    for command in COMMANDS:
        check(command, command_line, tmp_path)
    assert time.process_time() - begun < 120.0


@pytest.mark.parametrize("command", ["devices", "materials"])
def test_lists_are_answers_too(command, command_line):
    assert answer(command_line(command, "--json")[1])["command"] == command


def check(command, command_line, folder):
    """Runs a command; its text and files are in the device's units, and say where the model holds."""
    code, out, err = command_line(command, "mine.toml", *COMMANDS[command], "--out", "results")
    assert code == 0, err
    assert out.startswith("my device\n")
    assert "moving_mass 6 g" in out or command == "map"
    assert "dimensionless" not in out
    assert (folder / "results" / f"{command}.png").stat().st_size > 10_000
    result = gelcone.load(folder / "results" / f"{command}.nc")
    for name, unit in AXES[command].items():
        assert result[name].attrs["units"] == unit
        assert result[name].attrs["long_name"]
    assert gelcone.model_of(result).system == gelcone.find_device(folder / "mine.toml").to_model().system


@pytest.mark.parametrize(
    ("typed", "following"),
    [
        (["first.toml"], "gelcone simulate first.toml"),
        (["--wish", "first.toml"], "gelcone design first.toml --out designs"),
        (["--tests", "first.toml"], "gelcone fit DEVICE --data first.toml --free spring_rate~3% --plan"),
    ],
)
def test_a_first_file_names_the_command_that_takes_it(typed, following, command_line):
    code, out, err = command_line("init", *typed)
    assert (code, err) == (0, "")
    assert out == f"wrote first.toml: change its numbers, then `{following}`\n"


@pytest.mark.parametrize("option", [["--drive-scale", "2"], ["--drive-repeat"], ["--drive-interpolation", "pchip"]])
def test_an_option_of_a_recording_needs_one_and_is_named_as_it_is_typed(option, command_line):
    code, out, err = command_line("simulate", "biased-pump", *option)
    assert (code, out) == (2, "")
    assert err == f"Error: {option[0]}: there is no --drive; name a CSV file\n"


def test_a_first_file_is_not_overwritten(command_line, device_file):
    before = device_file.read_text(encoding="utf-8")
    code, _, err = command_line("init", "mine.toml")
    assert code == 2
    assert err.startswith("Error: mine.toml: exists already; choose another name, or overwrite it with force")
    assert device_file.read_text(encoding="utf-8") == before
    assert command_line("init", "")[0] == 2


def test_a_device_is_printed_as_a_file_that_reads_back(command_line, tmp_path):
    code, out, _ = command_line("devices", "biased-pump")
    assert code == 0
    (tmp_path / "copy.toml").write_text(out, encoding="utf-8")
    assert gelcone.find_device(tmp_path / "copy.toml") == gelcone.find_device("biased-pump")
    code, out, _ = command_line("devices", "soft-film", "--json")
    assert gelcone.Device(**answer(out)["result"]) == gelcone.find_device("soft-film")


@pytest.mark.parametrize("topic", ["device", "units", "simulate", "map", None])
def test_help_explains_subjects_and_commands(command_line, topic):
    code, out, _ = command_line("help", *([topic] if topic else []))
    assert code == 0
    expected = {"device": "film_thickness", "units": "20 kPa", None: "gelcone init mine.toml"}
    assert expected.get(topic, f"gelcone {topic} [OPTIONS]") in out
    code, _, err = command_line("help", "devise")
    assert (code, err) == (2, "Error: 'devise' is not a subject of help; did you mean 'device'?\n")


@pytest.mark.parametrize(
    ("arguments", "told"),
    [
        (["--set", "voltage=500"], "'voltage' is not a device field; did you mean 'voltage_amplitude'?"),
        (["--over", "time=20,40"], "--over time 20: has no unit; with a device give one, such as '5 ms'"),
        (["--initial", "1,0"], "--initial displacement 1: has no unit"),
        (["--set", "film_thickness=0.2"], "Warning: film_thickness = 200 mm is outside the usual range"),
        (["--set", "initial_height=0"], "Warning: the disc starts at rest in the middle of the flat film"),
    ],
)
def test_what_was_silent_is_said(command_line, device_file, arguments, told):
    length = [] if "--over" in arguments else ["--periods", "2"]
    _, _, err = command_line("simulate", "mine.toml", *length, *arguments)
    assert told in err


@pytest.mark.parametrize(
    ("arguments", "told"),
    [
        (["simulate", "--set", "voltage=1e155"], "voltage = 1e+155: is beyond what the equations can be computed with"),
        (["simulate", "--set", "spring_stiffness=1e300"], "spring_stiffness = 1e+300: is beyond"),
        (["simulate", "mine.toml", "--set", "voltage_amplitude=1e200 V"], "voltage_amplitude"),
        (["simulate", "--periods", "3", "--over", "time=1,2"], "periods and times are both given; give one of them"),
        (["static", "--initial", "1,0"], "--initial: static does not start from a state"),
        (["bifurcation", "--over", "voltage=0:1:3", "--set", "voltage=1"], "--set voltage: is swept by --over voltage"),
        (["static", "--over", "constant_voltage=0:1:10000000"], "a range takes 2 to 100000"),
        (["simulate", "--out", ""], "'--out': is empty"),
        (["simulate", "--out", "store.zarr/inside"], "lies inside the store"),
        (["simulate", "mine.toml", "--set", "film_thickness=0.2:0.3 mm:3"], "0.2 has no unit, but the others do"),
    ],
)
def test_bad_input_is_one_clear_line(command_line, device_file, tmp_path, arguments, told):
    (tmp_path / "store.zarr").mkdir()
    (tmp_path / "store.zarr" / "zarr.json").write_text("{}", encoding="utf-8")
    code, out, err = command_line(*arguments)
    assert (code, out) == (2, "")
    assert told in err
    assert err.startswith("Error: ")
    assert err.count("\n") == 1


def test_each_line_that_is_left_out_can_be_taken_in(command_line, tmp_path):
    command_line("init", "mine.toml")
    text = (tmp_path / "mine.toml").read_text(encoding="utf-8")
    lines = re.findall(r"^# (\w+) = .*$", text.split("# --- a gel")[0], flags=re.MULTILINE)
    assert {"pull_in", "second_drive", "circuit"} <= set(lines)
    refused = {name: why for name in lines if (why := refusal(re.sub(rf"(?m)^# {name} = ", f"{name} = ", text)))}
    assert "cannot be imported" in refused.pop("bias")  # one's own, a class that is not there
    for why in refused.values():
        assert re.search(r"there is no [a-z_.]+; give|are both given; give", why)


def refusal(text):
    """Why the text of a device file is refused; empty where it is not."""
    try:
        gelcone.Device.from_text(text)
    except gelcone.InputError as error:
        return str(error)
    return ""


@pytest.mark.parametrize(
    ("topic", "meaning"),
    [("film_thickness", "thickness of the film as mounted"), ("shear-modulus", "small-strain shear")],
)
def test_help_explains_a_field(command_line, topic, meaning):
    code, out, _ = command_line("help", topic)
    assert code == 0
    assert meaning in out


def test_an_answer_tells_what_is_not_usual():
    gel = gelcone.Material(shear_modulus=8e3, relative_permittivity=5, law="yeoh")
    device = gelcone.find_device("biased-pump").replace(
        prestretch=1.2, meridional_prestretch=None, hoop_prestretch=None, prestretch_mode="equibiaxial",
        waveform="triangle", film="taut", material=gel,
    )  # fmt: skip
    told = gelcone.settled(device).gelcone.words()
    for words in ("prestretch 1.2", "prestretch_mode equibiaxial", "law yeoh", "waveform triangle"):
        assert words in " ".join(told.split())

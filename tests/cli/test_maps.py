"""`gelcone lyapunov`, `regime`, `bifurcation`, `map` and `basin`: JSON, files, SI units, text, one-line errors."""

import numpy as np
import pytest

from gelcone.analyses.grids import read_sweeps
from gelcone.codes import Outcome
from gelcone.dataset import load
from gelcone.devices.device import find_device
from gelcone.motion.lyapunov import lyapunov
from gelcone.motion.regime import regime
from gelcone.words import MOST_LINES, shortened
from tests.answers import result

pytestmark = pytest.mark.usefixtures("computed_once")

MODEL = ["--set", "damping_ratio=0.3", "--set", "stretch_limit=5"]
QUICK = ["--transient", "60", "--budget", "100"]
QUICK_DEVICE = ["--transient", "1 s", "--budget", "2 s"]
SWEEP = ["--over", "voltage=1:2:3", "--bisections", "2"]
GRID = ["--over", "voltage=0.5:2:3", "--over", "prestretch=0.7,1,2.8"]
STATES = ["--over", "displacement=-2.6:2.6:5", "--over", "velocity=-1:1:3"]
COMMANDS = {"lyapunov": [], "regime": [], "bifurcation": SWEEP, "map": GRID, "basin": STATES}
REGIMES = {"rest", "periodic", "quasi-periodic", "chaotic", "transient", "left the domain"}
UNIT = "per unit dimensionless time"


@pytest.fixture
def gelcone(command_line):
    return command_line


@pytest.fixture
def found(gelcone):
    """The JSON object that a command prints."""

    def run(*arguments):
        quick = QUICK_DEVICE if "soft-film" in arguments else QUICK
        code, out, err = gelcone(*arguments, *quick, "--json")
        assert (code, err) == (0, "")
        assert len(out.splitlines()) == 1
        return result(out)

    return run


# --- JSON --------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("command", COMMANDS)
def test_every_object_says_what_it_was_computed_from(found, command):
    content = found(command, *MODEL, *COMMANDS[command])
    assert content["parameters"]["damping_ratio"] == 0.3
    assert content["options"]["budget"] == 100.0
    assert np.isin(np.ravel(content["outcome"]), ["ok", "outside"]).all()
    assert content["subject"]["device"] is content["units"] is None


def test_exponents(found):
    content = found("lyapunov", *MODEL, "--window", 30)
    for name in ("lyapunov", "standard_error", "finite"):
        assert len(content[name]) == 2
    assert sum(content["lyapunov"]) == pytest.approx(-0.6, abs=1e-9)
    assert sum(content["finite"]) == pytest.approx(-0.6, abs=1e-9)
    assert abs(content["sum_residual"]) < 1e-9
    assert content["averaged_time"] > 0.0


def test_exponents_of_an_ensemble_are_lists_member_by_member(found):
    content = found("lyapunov", *MODEL, "--set", "voltage=0.5,1")
    assert np.shape(content["lyapunov"]) == np.shape(content["finite"]) == (2, 2)
    one = found("lyapunov", *MODEL, "--set", "voltage=1")
    assert content["lyapunov"][1] == one["lyapunov"]


def test_regime_with_its_evidence(found):
    content = found("regime", *MODEL)
    assert (content["regime"], content["period"], content["symmetric"]) == ("rest", "none", True)
    assert content["lyapunov"][0] < 0.0
    assert content["zero_one"] == "not applicable"
    assert content["doubtful"] is False
    assert content["dims"]["section"] == ["point", "state"]
    assert len(content["section"]) > 1


def test_regimes_of_an_ensemble_are_lists_member_by_member(found):
    content = found("regime", *MODEL, "--set", "voltage=0.5,2")
    assert content["regime"] == ["rest", "periodic"]
    assert content["period"][0] == "none"
    assert content["period"][1] >= 1


def test_bifurcation_diagram_with_thresholds(found):
    content = found("bifurcation", *MODEL, *SWEEP)
    assert content["voltage"] == [1.0, 1.5, 2.0]
    assert content["parameter"] == "voltage"
    assert set(content["branch"]) == {"up", "down", "from 1,0"}
    assert set(np.ravel(content["regime"])) <= REGIMES
    assert np.shape(content["regime"]) == np.shape(content["lyapunov"])[:2] == (3, 3)
    thresholds = [content[f"threshold_{name}"] for name in ("low", "high", "from", "to")]
    assert thresholds[0]
    for low, high, *kinds in zip(*thresholds, strict=True):
        assert high - low == pytest.approx(0.5 / 4)
        assert set(kinds) <= REGIMES
    assert set(np.ravel(content["outcome"])) == {"ok"}


def test_a_diagram_without_sweeps_has_one_branch(found):
    content = found("bifurcation", *MODEL, *SWEEP, "--sweeps", "none", "--initial", "0.5,0.1")
    assert content["branch"] == ["from 0.5,0.1"]
    assert content["subject"]["initial"] == [0.5, 0.1]


def test_a_map_names_its_failed_cells(found):
    content = found("map", *MODEL, *GRID)
    assert content["dims"]["regime"] == ["voltage", "prestretch"]
    assert content["prestretch"] == [0.7, 1.0, 2.8]
    assert [row[2] for row in content["outcome"]] == ["outside"] * 3
    assert {kind for row in content["outcome"] for kind in row[:2]} == {"ok"}
    assert np.shape(content["lyapunov"]) == np.shape(content["standard_error"]) == (3, 3, 2)
    assert [row[2] for row in content["lyapunov"]] == [["unknown"] * 2] * 3
    assert [row[2] for row in content["regime"]] == ["left the domain"] * 3


def test_basin_names_its_attractors(found):
    content = found("basin", *MODEL, "--set", "voltage=2", *STATES)
    shares = content["attractor_share"]
    assert shares == sorted(shares, reverse=True)
    assert set(content["attractor_regime"]) <= REGIMES
    numbers = np.array(content["attractor"])
    assert numbers.shape == (5, 3)
    for k, share in enumerate(shares):
        assert content["attractor_lowest"][k] <= content["attractor_highest"][k]
        assert (numbers == k).mean() == pytest.approx(share)
    assert (numbers == -1).sum() >= sum(kind != "ok" for row in content["outcome"] for kind in row) == 6


# --- devices -----------------------------------------------------------------------------------------------------


def test_exponents_of_a_device_are_per_second(found):
    content = found("lyapunov", "soft-film")
    device = find_device("soft-film")
    scale = device.scales.time
    assert (content["units"]["lyapunov"], content["units"]["averaged_time"]) == ("1/s", "ms")
    assert [content["options"][name] for name in ("transient", "budget")] == pytest.approx([1e3, 2e3])
    alone = lyapunov(device.to_model(), device.initial_state(), transient=1.0 / scale, budget=2.0 / scale)
    np.testing.assert_allclose(np.array(content["lyapunov"]) * scale, alone["lyapunov"])
    np.testing.assert_allclose(np.array(content["finite"]) * scale, alone["finite"])
    assert content["subject"]["device"] == device.name


def test_regime_of_a_device_in_millimetres(found):
    content = found("regime", "soft-film")
    device = find_device("soft-film")
    times = {"transient": 1.0 / device.scales.time, "budget": 2.0 / device.scales.time}
    alone = regime(device.to_model(), device.initial_state(), **times)
    assert content["units"]["highest"] == "mm"
    highest = 1e3 * device.scales.length * float(alone["highest"])
    assert content["highest"] == pytest.approx(highest)


def test_thresholds_of_a_device_in_volts(found, undrawn, tmp_path):
    over = ["--over", "voltage_amplitude=0 V:3200 V:3", "--sweeps", "none", "--bisections", "1"]
    content = found("bifurcation", "soft-film", *over, "--set", "damping_coefficient=0.02", "--out", tmp_path)
    np.testing.assert_allclose(content["voltage_amplitude"], [0.0, 1600.0, 3200.0], atol=1e-9)
    assert content["units"]["voltage_amplitude"] == content["units"]["threshold_low"] == "V"
    assert min(content["threshold_low"]) > 100.0
    written = load(tmp_path / "bifurcation.nc")
    assert written["voltage_amplitude"].attrs["units"] == "V"
    assert written["section"].attrs["units"] == "mm, m/s"
    ends = written["section"].isel(state=0)
    assert float(ends.max()) <= float(written["highest"].max()) + 1e-9


def test_a_map_over_two_fields_of_a_device(found):
    over = ["--over", "film_thickness=90 um,0.1 mm", "--over", "prestretch=1.2,1.3"]
    content = found("map", "soft-film", *over, "--set", "voltage_amplitude=300 V")
    assert content["film_thickness"] == pytest.approx([0.09, 0.1])
    assert (content["units"]["film_thickness"], content["units"]["lyapunov"]) == ("mm", "1/s")
    assert content["prestretch"] == [1.2, 1.3]
    assert content["subject"]["fields"]["voltage_amplitude"] == 300.0


# --- text and files ----------------------------------------------------------------------------------------------


@pytest.mark.parametrize("command", COMMANDS)
def test_text_and_files(gelcone, undrawn, tmp_path, command):
    out = tmp_path / "results"
    arguments = [command, *MODEL, *COMMANDS[command], *QUICK, "--out", out]
    code, text, err = gelcone(*arguments)
    assert (code, err) == (0, "")
    assert text.splitlines()[-2:] == [f"wrote {out / command}.nc", f"wrote {out / command}.png"]
    assert "cone model, dimensionless" in text
    assert load(out / f"{command}.nc").attrs["model"]
    code, text, err = gelcone(*arguments)
    assert (code, text) == (2, "")
    assert "--force" in err
    assert gelcone(*arguments, "--force")[0] == 0


def test_exponents_in_text_say_their_error_and_their_time(gelcone):
    _, text, _ = gelcone("lyapunov", *MODEL, *QUICK)
    assert "±" in text
    assert "per unit time" in text
    assert "per forcing period" in text
    assert "certainly negative" in text
    assert "per second" in gelcone("lyapunov", "soft-film", *QUICK_DEVICE)[1]


def test_failed_cells_are_told_with_the_remedy(gelcone):
    _, text, _ = gelcone("map", *MODEL, *GRID, *QUICK)
    assert f"3 of 9 runs failed: {Outcome.OUTSIDE.meaning}" in text
    assert "left the domain 3" in text


def test_thresholds_in_text(gelcone):
    _, text, _ = gelcone("bifurcation", *MODEL, *SWEEP, *QUICK)
    assert "changes of regime:" in text
    assert "rest -> periodic at voltage" in text
    _, text, _ = gelcone("bifurcation", *MODEL, "--over", "voltage=0,0.1", "--sweeps", "none", *QUICK)
    assert "no change of regime" in text


def test_an_ensemble_in_text_is_one_line_a_member(gelcone):
    _, text, _ = gelcone("regime", *MODEL, "--set", "voltage=0.5,2", *QUICK)
    assert "  voltage 0.5: rest; largest exponent" in text
    assert "  voltage 2: periodic, period" in text


def test_long_lists_are_cut():
    lines = shortened([str(i) for i in range(MOST_LINES + 5)])
    assert len(lines) == MOST_LINES + 1
    assert "5 more" in lines[-1]
    assert shortened(["a"]) == ["a"]


# --- bad input ---------------------------------------------------------------------------------------------------

BAD = {
    "no parameter": (["bifurcation"], "takes one parameter, not 0"),
    "two parameters": (["bifurcation", *GRID], "gelcone map"),
    "one parameter of a map": (["map", "--over", "voltage=0:1:3"], "gelcone bifurcation"),
    "three parameters": (["map", *GRID, "--over", "damping_ratio=0.1,0.2"], "not 3; fix the others with --set"),
    "reversed": (["bifurcation", "--over", "voltage=2:0:5"], "empty or reversed"),
    "empty": (["bifurcation", "--over", "voltage="], "--over"),
    "one point": (["bifurcation", "--over", "voltage=1"], "at least two"),
    "one point of a range": (["map", "--over", "voltage=0:1:1", "--over", "prestretch=1,2"], "1 points"),
    "unknown": (["map", "--over", "voltag=0:1:3", "--over", "prestretch=1,2"], "did you mean 'voltage'?"),
    "given twice": (["map", "--over", "voltage=0:1:3", "--over", "voltage=0:1:3"], "twice"),
    "wrong sweeps": (["bifurcation", *SWEEP, "--sweeps", "sideways"], "must be up, down, up,down or none"),
    "doubled sweeps": (["bifurcation", *SWEEP, "--sweeps", "up,up"], "must be up, down, up,down or none"),
    "negative bisections": (["bifurcation", *SWEEP, "--bisections", "-1"], "at least 0"),
    "an ensemble": (
        ["map", *GRID, "--set", "damping_ratio=0.1,0.2"],
        "map: takes one actuator, not an ensemble of 2; give every field",
    ),
    "no budget": (["lyapunov", "--budget", "0"], "--budget 0: "),
    "no transient": (["regime", "--transient", "0"], "--transient 0: "),
    "no window": (["lyapunov", "--window", "-1"], "--window -1: "),
    "not a number": (["regime", "--budget", "much"], "--budget"),
    "nan": (["basin", *STATES, "--budget", "nan"], "--budget nan: must be finite"),
    "basin over a parameter": (["basin", "--over", "voltage=0:1:3"], "known: displacement, velocity"),
    "basin over nothing": (["basin", "--over", "displacement"], "must be name=from:to:count"),
    "basin reversed": (["basin", "--over", "displacement=1:-1:5"], "empty or reversed"),
    "basin unsorted": (["basin", "--over", "displacement=1,0"], "must increase"),
    "basin of one state": (["basin", "--over", "displacement=1"], "at least two"),
    "basin twice": (["basin", *STATES, *STATES], "twice"),
    "basin in words": (["basin", "--over", "displacement=a:b:3"], "must be a number"),
    "basin with a start": (["basin", "--initial", "1,0"], "starts from a grid of states"),
    "all outside": (["regime", "--set", "stretch_limit=0.1", "--initial", "1,0"], "start lower or raise it"),
}


@pytest.mark.parametrize("case", BAD)
def test_bad_input_is_one_line_and_writes_nothing(gelcone, tmp_path, case):
    arguments, told = BAD[case]
    code, out, err = gelcone(*arguments, "--out", tmp_path / "results")
    assert (code, out) == (2, "")
    assert len(err.splitlines()) == 1
    assert err.startswith("Error: ")
    assert told in err
    assert not (tmp_path / "results").exists()


def test_sweeps():
    assert read_sweeps("up,down") == ["up", "down"]
    assert read_sweeps(" down ") == ["down"]
    assert read_sweeps("none") == []


def test_a_map_is_coloured_by_what_it_is_asked_for(gelcone, tmp_path):
    model = ("--preset", "base", "--over", "voltage=0.3,0.6", "--over", "prestretch=1,1.2", "--budget", "500")
    for colour in ("power", "margin"):
        _, text, _ = gelcone("map", *model, "--colour", colour, "--out", str(tmp_path / colour))
        assert f"wrote {tmp_path / colour / 'map.png'}" in text
        assert np.isfinite(load(tmp_path / colour / "map.nc")[colour]).all()

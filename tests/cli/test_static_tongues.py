"""`gelcone static`, `gelcone tongues` and --over: JSON, files, units of a device, and one-line errors."""

import numpy as np
import pytest

from gelcone import ConeModel, find_device, floquet_multipliers, load, onset_voltage, static
from tests.answers import result

pytestmark = pytest.mark.usefixtures("computed_once")

TABLE1 = ["--set", "spring_stiffness=1.5"]
COARSE = ["--over", "drive_frequency=0.5:2:4", "--over", "voltage=0:2:9"]


@pytest.fixture
def gelcone(command_line):
    return command_line


@pytest.fixture
def as_json(gelcone):
    """Runs a command with --json and reads what it prints."""

    def run(*arguments):
        code, out, err = gelcone(*arguments, "--json")
        assert (code, err) == (0, "")
        return result(out)

    return run


# --- static -------------------------------------------------------------------------------------------------------


def test_static_takes_the_voltage_amplitude_as_a_constant_voltage(as_json):
    content = as_json("static", *TABLE1, "--set", "voltage=1.5")
    assert content["stable"] == [[True, False, True]]
    assert [np.sign(slope) for slope in content["slope"][0]] == [1.0, -1.0, 1.0]
    assert content["equilibrium_displacement"][0][2] == pytest.approx(0.98583217)
    assert content["pitchfork_voltage"] == np.sqrt(1.5)
    assert content["fold_voltage"] == ["none"]
    pull_in = [content[f"pull_in_{name}"] for name in ("voltage", "kind", "from", "to")]
    assert pull_in == ["none", "never", "not applicable", "not applicable"]
    assert content["pitchfork_displacement"] == 0.0
    assert content["outcome"] == "ok"
    assert content["units"] is None
    assert content["validity"]["hoop_slack"] == [[1.0, 1.0, 1.0]]
    assert content["validity"]["breakdown"] == [["unknown"] * 3]  # without a dielectric strength


def test_static_lists_a_curve_for_each_voltage(as_json):
    content = as_json("static", *TABLE1, "--over", "constant_voltage=0,1,1.5")
    assert content["constant_voltage"] == [0.0, 1.0, 1.5]
    assert content["equilibria"] == [1, 1, 3]
    assert np.shape(content["force"]) == (3, len(content["displacement"]))


def test_static_takes_one_voltage_too(as_json):
    content = as_json("static", *TABLE1, "--over", "constant_voltage=1.5", "--over", "displacement=0.5")
    assert (content["constant_voltage"], content["displacement"]) == ([1.5], [0.5])


def test_static_of_an_ensemble_lists_its_members(as_json):
    content = as_json("static", *TABLE1, "--set", "voltage=0,1,1.5")
    assert content["equilibria"] == [[1, 1, 3]] * 3  # each at the peaks of all
    assert content["pitchfork_voltage"] == [np.sqrt(1.5)] * 3


def test_static_of_a_device_is_in_volts_and_millimetres(as_json):
    device = find_device("paper-table1").replace(initial_height=0.005)
    arguments = ("paper-table1", "--set", "initial_height=0.005", "--over", "constant_voltage=0 kV,4 kV,16 kV")
    content = as_json("static", *arguments)
    assert content["options"]["voltages"] == pytest.approx([0.0, 4000.0, 16000.0], rel=1e-12)
    units = {"displacement": "mm", "force": "N", "slope": "N/m", "constant_voltage": "V"}
    assert {name: content["units"][name] for name in units} == units
    scales = device.scales
    levels = [0.0, 4000.0, 16000.0]
    found = static(device.to_model(), np.array(levels) / scales.voltage)
    assert content["constant_voltage"] == pytest.approx(levels, rel=1e-12)
    millimetres = scales.length * 1e3
    for name, scale in (("stroke", millimetres), ("blocked_force", scales.force)):
        assert content[name] == pytest.approx((found[name] * scale).values)
    places = [[np.nan if x == "none" else x for x in row] for row in content["equilibrium_displacement"]]
    np.testing.assert_allclose(places, found["equilibrium_displacement"] * millimetres)
    assert content["fold_voltage"][0] == pytest.approx(float(found["fold_voltage"][0]) * scales.voltage)
    pull_in = [content[f"pull_in_{name}"] for name in ("voltage", "kind", "from", "to")]
    assert pull_in == ["none", "never", "not applicable", "not applicable"]


def test_static_of_devices_of_several_sizes(as_json):
    """Each is that of the device alone, though length and voltage have another scale in each."""
    pump = ("static", "biased-pump", "--film", "wrinkling")
    sizes = {
        "film_radius": ("30 mm", "33.75 mm"),
        "disc_radius": ("8 mm", "9 mm"),
        "film_thickness": ("0.2 mm", "0.3 mm"),
    }

    def set_to(values):
        return [part for name, value in zip(sizes, values, strict=True) for part in ("--set", f"{name}={value}")]

    both = as_json(*pump, *set_to(map(",".join, sizes.values())))
    for k, sized in enumerate(zip(*sizes.values(), strict=True)):
        one = as_json(*pump, *set_to(sized))
        assert both["rest_displacement"][k] == pytest.approx(one["rest_displacement"], rel=1e-12)
        # the voltages of the members are those of all in the units of each
        own = int(np.argmin(np.abs(np.array(both["constant_voltage"])[..., k] - one["constant_voltage"][0])))
        place = one["equilibrium_displacement"][0][0]
        assert both["equilibrium_displacement"][k][own][0] == pytest.approx(place, rel=1e-9)


def test_static_writes_data_and_a_figure_and_tells_what_it_found(gelcone, tmp_path):
    code, out, _ = gelcone("static", *TABLE1, "--over", "constant_voltage=0:1.5:4", "--out", tmp_path)
    assert code == 0
    assert "1.5: equilibria at -0.9858 (stable, hoop slack" in out
    assert "breakdown unknown: the dielectric strength is not given" in out
    assert "pitchfork at 1.225, displacement 0" in out
    written = load(tmp_path / "static.nc")
    np.testing.assert_array_equal(written.force, static(ConeModel(), np.linspace(0.0, 1.5, 4)).force)
    assert (tmp_path / "static.png").stat().st_size > 10_000
    code, _, err = gelcone("static", *TABLE1, "--out", tmp_path)
    assert code == 2
    assert "exists already" in err


# --- tongues ------------------------------------------------------------------------------------------------------


def test_static_beyond_pull_in_and_where_no_ramp_leads(gelcone):
    """Without a voltage on the first of two films in opposite phase the second has twice the offset, and localises; at
    an offset beyond pull-in a slow ramp comes to no voltage of the first."""
    code, out, _ = gelcone("static", "double-cone", "--over", "constant_voltage=0 V,1.13 kV")
    assert code == 0
    assert "0 V: no equilibrium; blocked force -" in out
    assert "mN, no slow ramp leads there" in out
    assert "1.13 kV: equilibrium at 10 mm (stable, 1.13 kV on the second film); stroke 0 mm" in out
    code, out, _ = gelcone("static", "double-cone", "--set", "voltage_offset=5 kV")
    assert code == 0
    assert "slow voltage ramp of both films from 0 to 5 kV: pull-in on the way" in out
    assert "5 kV: no equilibrium; no slow ramp leads there" in out
    code, out, _ = gelcone("static", "soft-film", "--over", "constant_voltage=0.2 kV,3 kV")
    assert code == 0
    assert "3 kV: no equilibrium; beyond pull-in" in out


def test_tongues_give_the_onset_at_the_models_own_frequency_and_the_grid(as_json):
    content = as_json("tongues", *COARSE, "--set", "drive_frequency=0.9")
    model = ConeModel(drive_frequency=0.9)
    assert content["operating_onset_voltage"] == float(onset_voltage(model).onset_voltage)
    assert content["operating_onset_kind"] == "minus_one"
    np.testing.assert_allclose(content["operating_searched"], [0.0, 3.0 * np.sqrt(1.5)])
    assert np.shape(content["growth_rate"]) == (len(content["drive_frequency"]), len(content["voltage"])) == (4, 9)
    assert len(content["boundary_voltage"]) == 4
    assert content["pitchfork_amplitude"] == np.sqrt(1.5)


def test_tongues_say_when_nothing_is_found_in_what_was_searched(as_json, gelcone):
    content = as_json("tongues", *COARSE, "--highest", "0.3")
    found = [content[f"operating_{name}"] for name in ("onset_voltage", "onset_kind", "searched")]
    assert found == ["not reached", "none", [0.0, 0.3]]
    _, out, _ = gelcone("tongues", *COARSE, "--highest", "0.3")
    assert "rest stays stable in the searched interval (searched up to 0.3)" in out


def test_tongues_of_a_device_are_in_volts_and_hertz(as_json, undrawn, tmp_path):
    over = ["--over", "frequency=4 Hz:12 Hz:3", "--over", "voltage_amplitude=0 kV:16 kV:5"]
    content = as_json("tongues", "paper-table1", *over, "--out", tmp_path)
    units = {"drive_frequency": "Hz", "voltage": "V", "growth_rate": "1/s"}
    assert {name: content["units"][name] for name in units} == units
    np.testing.assert_allclose(content["drive_frequency"], [4.0, 8.0, 12.0], rtol=1e-12)
    np.testing.assert_allclose(content["voltage"], np.linspace(0.0, 16e3, 5), rtol=1e-12)
    device = find_device("paper-table1")
    cone, scales = device.to_model(), device.scales
    omega, volts = np.array([4.0, 8.0, 12.0]) / scales.frequency, np.linspace(0.0, 16e3, 5) / scales.voltage
    rates = floquet_multipliers(cone.replace(drive_frequency=omega[:, None], voltage=volts))["growth_rate"]
    np.testing.assert_allclose(content["growth_rate"], rates / scales.time, rtol=1e-9)
    assert content["operating_onset_voltage"] == pytest.approx(
        float(onset_voltage(cone).onset_voltage) * scales.voltage
    )
    assert (tmp_path / "tongues.png").exists()
    assert load(tmp_path / "tongues.nc").growth_rate.attrs["units"] == "1/s"


# --- sweeps -------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["static", "--over", "constant_voltage=x"], "--over constant_voltage 'x': must be a number"),
        (["static", "--over", "constant_voltage=-1"], "--over constant_voltage=-1: must be at least 0"),
        (["static", "--over", "constant_voltage=2:1:3"], "empty or reversed"),
        (["static", "--set", "prestretch=0.2", "--set", "stretch_limit=1"], "stretch_limit = 1: must exceed"),
        (["tongues", "--over", "damping_ratio=0:1:5"], "sweeps drive_frequency and voltage"),
        (["tongues", "--set", "rest_height=0.1"], "rest_height = 0.1: must be 0"),
        (["tongues", "--set", "voltage=[0,1]"], "one actuator"),
        (["tongues", "--highest", "0"], "--highest 0: must be greater than 0"),
    ],
)
def test_bad_arguments_are_one_line_and_exit_with_2(gelcone, arguments, message):
    code, out, err = gelcone(*arguments)
    assert (code, out) == (2, "")
    assert message in err
    assert err.count("\n") == 1

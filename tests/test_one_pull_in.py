"""One question about pull-in has one answer, whichever command is asked.

On a slow ramp to a constant voltage, and when the drive is switched on from rest at its own frequency. Double cones in
opposite phase have two slow ramps: to a constant voltage at the actuator's bias, and of the drive held at its peak, to
which the bias rises in proportion.
"""

import numpy as np
import pytest

import gelcone
from gelcone.analyses.envelope import envelope_words
from gelcone.analyses.request import Subject
from gelcone.analyses.statics import static_words
from gelcone.codes import Outcome
from gelcone.motion.plane import DRIVEN_LIMITS, NUDGE
from gelcone.motion.static_limits import STATIC_LIMITS
from gelcone.studio.performance import pull_in
from gelcone.words import sheet_limits

pytestmark = pytest.mark.slow

SHIPPED = ("biased-pump", "soft-film", "weight-cone", "beam-cone", "snap-cone", "paper-table1", "double-cone")
OTHERS = {
    "a stiff pump": ("biased-pump", {"material": "PVC-DBA 4:1"}),
    "an even pump": ("biased-pump", {"meridional_prestretch": 1.2, "hoop_prestretch": 1.2}),
    "a thick soft film": ("soft-film", {"film_thickness": "0.2 mm", "voltage_amplitude": "900 V"}),
}


def device_of(name):
    shipped, changes = OTHERS.get(name, (name, {}))
    films = {"film": "membrane"} | ({"second_film": "membrane"} if shipped == "double-cone" else {})
    return gelcone.find_device(shipped).replace(films | changes)


def voltage(dataset, name):
    """A voltage in V."""
    found = dataset[name]
    assert found.attrs["units"] == "V"
    return float(found)


@pytest.mark.parametrize("name", [*SHIPPED, *OTHERS])
def test_pull_in_on_a_slow_ramp_is_one_voltage(name):
    device = device_of(name)
    expected = voltage(gelcone.limits(device), "pull_in_voltage")
    assert 100.0 < expected < 2e4
    assert voltage(gelcone.static(device), "pull_in_voltage") == pytest.approx(expected, rel=1e-9)
    swept = gelcone.sweep(gelcone.Plan(device, {"frequency": [5.0, 7.0]}), "limits")["pull_in_voltage"]
    assert swept.values == pytest.approx(expected, rel=1e-9)
    model = device.to_model()
    assert device.scales.voltage * pull_in(model) == pytest.approx(expected, rel=1e-9)
    around = [0.999 * expected, 1.001 * expected]
    found = gelcone.step(device, around)["equilibrium_displacement"]
    assert np.isfinite(found).values.tolist() == [True, bool(np.isfinite(gelcone.static(device, around)["stroke"][1]))]
    sheet = gelcone.datasheet(device, around)
    assert np.isfinite(sheet["stroke"][1:]).values.tolist() == np.isfinite(found).values.tolist()
    assert voltage(sheet, "pull_in_voltage") == pytest.approx(expected, rel=1e-9)
    creeps = device.replace({"material.viscous_modulus_1": "2 kPa", "material.relaxation_time_1": "1 s"})
    relaxed = voltage(gelcone.creep(creeps, around[:1], duration="2 s"), "long_term_pull_in_voltage")
    assert relaxed == pytest.approx(voltage(gelcone.limits(creeps), "pull_in_voltage"), rel=1e-9)
    if device.second_drive == "opposite":  # an envelope answers another question of it
        return
    drive = device.voltage_amplitude, device.frequency
    found = gelcone.envelope(device, peaks=[0.1 * drive[0], 0.2 * drive[0]], frequencies=[drive[1], 1.1 * drive[1]])
    of_envelope = float(found["static_limit_voltage"][STATIC_LIMITS.index("pull-in")])
    assert of_envelope == pytest.approx(expected, rel=1e-9)


def held_in_proportion(device, share):
    """The device with ``share`` times its voltages."""
    volts = {name: share * device.get(name) for name in ("voltage_amplitude", "voltage_offset")}
    return device.replace(volts)


def test_pull_in_of_a_drive_that_is_held_at_its_peak_is_one_voltage():
    """It is the constant voltage of pull-in at the bias in proportion; a slow drive with a peak beyond it pulls in."""
    device = device_of("double-cone")
    expected = voltage(gelcone.operating_limits(device), "proportional_pull_in_voltage")
    own = voltage(gelcone.limits(device), "pull_in_voltage")
    assert expected > 1.05 * own
    peak = device.voltage_amplitude + device.voltage_offset
    window = gelcone.envelope(device, peaks=[0.1 * peak, 0.2 * peak], frequencies=[14.0, 15.0])
    of_envelope = float(window["static_limit_voltage"][STATIC_LIMITS.index("pull-in")])
    assert of_envelope == pytest.approx(expected, rel=1e-9)
    sheet = gelcone.datasheet(device, [0.5 * peak])
    assert voltage(sheet, "proportional_pull_in_voltage") == pytest.approx(expected, rel=1e-9)
    scaled = held_in_proportion(device, expected / peak)
    assert voltage(gelcone.limits(scaled), "pull_in_voltage") == pytest.approx(expected, rel=1e-6)
    runs = [held_in_proportion(device, share * expected / peak).replace(frequency="0.1 Hz") for share in (0.99, 1.01)]
    assert [int(gelcone.simulate(run, periods=0.5)["outcome"]) for run in runs] == [Outcome.OK, Outcome.PULLED_IN]


def test_of_two_slow_ramps_no_name_and_no_meaning_is_one():
    device = gelcone.find_device("double-cone").replace(film="taut", second_film="taut")
    device = device.replace({"material.viscous_modulus_1": "2 kPa", "material.relaxation_time_1": "1 s"})
    bias = [gelcone.limits(device), gelcone.static(device), gelcone.pull_in_voltage(device), gelcone.creep(device)]
    scaled = [
        gelcone.operating_limits(device),
        gelcone.envelope(device, peaks=[100.0, 200.0], frequencies=[14.0, 15.0]),
    ]

    def said(results):
        """Names and meanings of what has to do with voltages."""
        of = [{n: v for n, v in one.variables.items() if v.attrs.get("quantity") == "voltage"} for one in results]
        return {str(n) for one in of for n in one}, {v.attrs["long_name"] for one in of for v in one.values()}

    (names, meanings), (other_names, other_meanings) = said(bias), said(scaled)
    assert names & other_names == {"constant_voltage"}  # an axis, whose meanings differ
    assert not meanings & other_meanings
    assert all("at the actuator's bias" in one["pull_in_voltage"].attrs["long_name"] for one in bias[:3])
    slow = [words for words in other_meanings if "on a slow ramp" in words or "constant" in words]
    assert slow == []
    sheet = gelcone.datasheet(device, [1000.0])
    assert voltage(sheet, "membrane_pull_in_voltage") < voltage(sheet, "pull_in_voltage")
    assert (
        voltage(sheet, "pull_in_voltage") == voltage(bias[0], "pull_in_voltage") == voltage(bias[1], "pull_in_voltage")
    )
    held = ("proportional_pull_in_voltage", "proportional_membrane_pull_in_voltage")
    assert [voltage(sheet, name) for name in held] == [voltage(scaled[0], name) for name in held]
    foot = "\n".join(sheet_limits(sheet))
    assert "under constant voltage at the bias of 1.13 kV" in foot
    assert "below every limit: peaks up to" in foot
    assert foot.count(", bias and amplitude in proportion") == 2
    text = envelope_words(scaled[1], Subject(device.to_model(), device))
    assert "constant" not in text
    assert "on the second, bias and amplitude in proportion; stroke" in text


@pytest.mark.parametrize("name", [*SHIPPED, *OTHERS])
def test_pull_in_of_a_drive_that_is_switched_on_from_rest_is_one_voltage(name):
    """Operating limits and envelope name the same interval; below it all commands run on, above it all pull in."""
    device = device_of(name)
    alone = gelcone.operating_limits(device)
    lower = voltage(alone, "driven_pull_in_voltage")
    if not np.isfinite(lower):
        pytest.skip("does not pull in up to the voltages examined")
    own = device.frequency
    found = gelcone.envelope(device, frequencies=[own, 1.1 * own])
    row = DRIVEN_LIMITS.index("pull-in")
    low, high = (float(found[end][row, 0]) for end in ("limit_low", "limit_high"))
    assert low == lower
    assert high - low <= voltage(alone, "driven_error_voltage") * (1.0 + 1e-9)
    scale = device.scales.voltage
    model = device.to_model()
    share = np.array([low, high * 1.0001]) / scale / float(model.peak_voltage)
    both = model.replace(voltage=float(model.voltage) * share, voltage_bias=float(model.voltage_bias) * share)
    start = (float(found["rest_displacement"]) / 1e3 / device.scales.length + NUDGE, 0.0)
    expected = [Outcome.OK, Outcome.PULLED_IN]
    if voltage(alone, "driven_chaos_voltage") < lower:
        # of one run out of chaos, as its meaning says: up to the onset of chaos all run on
        assert "out of chaos" in alone["driven_pull_in_voltage"].attrs["long_name"]
        quiet = voltage(alone, "driven_chaos_voltage") / low
        both = both.replace(voltage=both.voltage[:1] * quiet, voltage_bias=both.voltage_bias[:1] * quiet)
        expected = expected[:1]
    kinds = gelcone.regime(both, start)
    assert kinds["outcome"].values.tolist() == expected
    assert gelcone.settled(both, start)["outcome"].values.tolist() == expected
    # so near the limit a motion may go on for long before it pulls in
    lasts = 3.0 * max(200.0 * float(both.members().drive_period[0]), float(kinds["settled_time"].max()))
    assert gelcone.simulate(both, start, times=np.linspace(0.0, lasts, 11))["outcome"].values.tolist() == expected


def test_a_film_that_stiffens_without_limit_never_pulls_in_whichever_command_is_asked():
    """The end of the displacements searched is no event: no voltage, no branch and no mark of it."""
    law = {"law": "yeoh", "yeoh_c2": 0.02, "yeoh_c3": 0.001, "film": "taut", "hoop_prestretch": 1.3}
    model = gelcone.ConeModel(voltage=0.2, voltage_bias=0.3, rest_height=0.5, damping_ratio=0.2, **law)
    at_rest = gelcone.static(model, [0.5])
    for found in (gelcone.limits(model), gelcone.pull_in_voltage(model), at_rest):
        assert float(found["pull_in_voltage"]) == np.inf
        assert gelcone.PullIn(int(found["pull_in_kind"])) == gelcone.PullIn.SEARCH_RANGE
    assert pull_in(model) == np.inf
    assert float(at_rest["branch_voltage"].max()) < 10.0
    legends = [axes.get_legend_handles_labels()[1] for axes in gelcone.plot(at_rest).axes]
    assert not any("pull-in" in label for own in legends for label in own)
    assert "stable up to 1000 times the width of the film, where the search ends" in static_words(
        at_rest, Subject(model)
    )
    limits, sheet = gelcone.operating_limits(model), gelcone.datasheet(model, [0.5])
    for found in (limits, sheet):
        assert float(found["pull_in_voltage"]) == float(found["driven_pull_in_voltage"]) == np.inf
        assert float(found["hoop_slack_voltage"]) < 10.0
        assert found.attrs["pull_in_of"] == "cone"
    window = gelcone.envelope(model, frequencies=[0.9, 1.0])
    assert float(window["static_limit_voltage"][STATIC_LIMITS.index("pull-in")]) == np.inf
    assert np.isinf(window["limit_low"].values[DRIVEN_LIMITS.index("pull-in")]).all()
    assert not str(gelcone.drive(model, lowest_frequency=0.9, highest_frequency=1.0).attrs["limit"]).startswith(
        "pull-in"
    )

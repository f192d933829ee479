"""One question about pull-in has one answer, whichever command is asked.

On a slow ramp to a constant voltage, and when the drive is switched on from rest at its own frequency.
"""

import numpy as np
import pytest

import gelcone
from gelcone.analyses.request import Subject
from gelcone.analyses.statics import static_words
from gelcone.codes import Outcome
from gelcone.motion.plane import DRIVEN_LIMITS, NUDGE
from gelcone.motion.static_limits import STATIC_LIMITS
from gelcone.studio.performance import pull_in

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
    if device.second_drive == "opposite":  # its offset rises with the drive in an envelope: another question
        device = device.replace(second_drive="same")
    expected = voltage(gelcone.limits(device), "pull_in_voltage")
    assert 100.0 < expected < 2e4
    assert voltage(gelcone.static(device), "pull_in_voltage") == pytest.approx(expected, rel=1e-9)
    swept = gelcone.sweep(gelcone.Plan(device, {"frequency": [5.0, 7.0]}), "limits")["pull_in_voltage"]
    assert swept.values == pytest.approx(expected, rel=1e-9)
    model = device.to_model()
    assert device.scales.voltage * pull_in(model) == pytest.approx(expected, rel=1e-9)
    drive = device.voltage_amplitude, device.frequency
    found = gelcone.envelope(device, peaks=[0.1 * drive[0], 0.2 * drive[0]], frequencies=[drive[1], 1.1 * drive[1]])
    of_envelope = float(found["static_limit_voltage"][STATIC_LIMITS.index("pull-in")])
    assert of_envelope == pytest.approx(expected, rel=1e-9)


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

"""What an analysis is asked about, read from text without the command line."""

import numpy as np
import pytest

from gelcone import InputError, find_device
from gelcone.analyses.request import read_subject
from gelcone.register.analyses import find_analysis

CREEPING = ["viscous_modulus_1=0.5", "relaxation_time_1=3"]


def test_an_initial_state_names_any_state():
    def initial(text, **more):
        return read_subject(None, settings=CREEPING, initial=text, **more).beginning

    assert initial("0.5,0.1") == (0.5, 0.1)
    assert initial("0.5,0.1,0.9,1.2") == (0.5, 0.1, 0.9, 1.2)
    assert initial("viscous_hoop_1=1.2, displacement=0.5") == (0.5, 0.0, 1.0, 1.2)
    assert initial("displacement=0.5, velocity=0.1") == (0.5, 0.1)
    device = find_device("biased-pump").replace(
        film={"component": "taut", "branches": 1, "relaxation_time_1": "0.6 s"}, release_height="6 mm"
    )
    stated = read_subject(device, initial="displacement=5 mm,viscous_hoop_1=1.2")
    x = 5e-3 / device.scales.length
    np.testing.assert_allclose(stated.start, [5e-3, 0.0, 1.0 / (1.0 + x * x), 1.2])
    np.testing.assert_allclose(stated.initial, [x, 0.0, 1.0 / (1.0 + x * x), 1.2])


def test_states_that_are_not_named_begin_where_the_device_does_in_si_units():
    device = find_device("biased-pump").replace(film="taut", series_resistance="1 Mohm", release_height="6 mm")
    stated = read_subject(device, initial="velocity=0.1 m/s, film_voltage=20 V")
    np.testing.assert_allclose(stated.start, [6e-3, 0.1, 20.0])
    scales = device.scales
    np.testing.assert_allclose(stated.initial, [6e-3 / scales.length, 0.1 / scales.velocity, 20.0 / scales.voltage])


def test_axes_are_those_that_were_given_and_the_others_their_default():
    tongues = find_analysis("tongues")
    found = read_subject().axes(["drive_frequency=0.5:1:3"], tongues)
    np.testing.assert_array_equal(found["frequencies"], [0.5, 0.75, 1.0])
    np.testing.assert_array_equal(found["voltages"], np.linspace(*tongues.axes["voltages"].default))


def test_what_an_axis_takes_the_place_of_is_not_set_too():
    """The frequency of a response is swept; the window of an envelope is that of a device with a drive of its own."""
    own, over = read_subject(settings=["drive_frequency=0.7"]), ["drive_frequency=0.5:1:3"]
    with pytest.raises(InputError, match="--set drive_frequency: is swept by --over drive_frequency; leave one of"):
        own.axes(over, find_analysis("frequency"))
    assert own.axes(over, find_analysis("envelope"))["frequencies"].tolist() == [0.5, 0.75, 1.0]


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("charge=3", "'charge' is not a component of --initial; known: displacement, velocity, viscous_mer"),
        ("1,0,3", "must be a displacement and a velocity, or all states"),
        ("displacement=1,displacement=2", "--initial displacement: is given twice"),
        ("displacement=1 mm", "must be a number"),
        ("1,viscous_hoop_1=2", "'1' is not a component of --initial"),
    ],
)
def test_an_initial_state_that_cannot_be_is_refused(text, message):
    with pytest.raises(InputError, match=message):
        read_subject(None, settings=CREEPING, initial=text)


def test_a_subject_needs_no_command_line():
    device = read_subject("soft-film", settings=["voltage_amplitude=0.3 kV", "frequency=9"], initial="5 mm, 0")
    assert device.device == find_device("soft-film").replace(voltage_amplitude=300.0, frequency=9.0)
    assert device.model.parameters() == device.device.to_model().parameters()
    assert device.initial[0] * device.device.scales.length == pytest.approx(5e-3)
    assert (device.starts, device.start, device.target) == (True, (0.005, 0.0), device.device)
    assert read_subject("soft-film").beginning is None
    for setting in ("voltage=0.3", "circuit=x", "material=x"):
        with pytest.raises(InputError, match=f"{setting.partition('=')[0]}"):
            read_subject("soft-film", settings=[setting])
    preset = read_subject(preset="base", settings=["damping_ratio=0.2"])
    assert (preset.model.damping_ratio, preset.initial, preset.starts) == (0.2, (1.0, 0.0), False)
    with pytest.raises(InputError, match="are both given; give one or the other"):
        read_subject("soft-film", preset="base")


def test_an_ensemble_or_an_initial_state_is_refused_where_it_makes_no_sense():
    with pytest.raises(InputError, match="--initial by name: takes one actuator, not an ensemble of 2"):
        read_subject(settings=["voltage=0.1,0.2"], initial="displacement=1")
    with pytest.raises(InputError, match="--initial: a basin does not take it"):
        read_subject(initial="0.5,0").without_initial("a basin does not take it")
    read_subject().without_initial("never said")

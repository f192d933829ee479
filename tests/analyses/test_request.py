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
    ("device", "name", "values"), [(None, "voltage", "0:2:5"), ("biased-pump", "film_thickness", "0.1 mm:0.2 mm:3")]
)
def test_what_is_swept_is_not_set_too(device, name, values):
    own = read_subject(device, film="taut", settings=[f"{name}={values.split(':')[1]}"])
    with pytest.raises(InputError) as error:
        own.over([f"{name}={values}"])
    assert str(error.value) == f"--set {name}: is swept by --over {name}; leave one of them out"
    other = {None: "damping_ratio=0.1:0.3:3", "biased-pump": "frequency=5 Hz:7 Hz:3"}[device]
    ((found, numbers),) = own.over([other]).items()
    assert found == other.partition("=")[0]
    np.testing.assert_allclose(numbers, [0.1, 0.2, 0.3] if device is None else [5.0, 6.0, 7.0])


def test_axes_of_a_device_are_in_its_units_dimensionless_or_in_si():
    """The name of a device for each axis, and the frequency that a response would replace."""
    own, over = read_subject("biased-pump", film="taut"), ["frequency=5 Hz:7 Hz:3", "peak_voltage=1 kV,2 kV"]
    analysis, scales = find_analysis("envelope"), own.device.scales
    hertz, volts = np.array([5.0, 6.0, 7.0]), np.array([1000.0, 2000.0])
    for in_si, per_hertz, per_volt in ((True, 1.0, 1.0), (False, 2.0 * np.pi * scales.time, 1.0 / scales.voltage)):
        found = own.axes(over, analysis, in_si=in_si)
        assert list(found) == ["frequencies", "peaks"]
        np.testing.assert_allclose(found["frequencies"], hertz * per_hertz, rtol=1e-12)
        np.testing.assert_allclose(found["peaks"], volts * per_volt, rtol=1e-12)
    for message, said in (
        ("peaks = 40.0: is too high", "--over peak_voltage=1 kV,2 kV: is too high"),
        ("frequency from 1 to 2: is low", "--over frequency=5 Hz:7 Hz:3: is low"),
        ("margin = 2: is too large", "margin = 2: is too large"),
    ):
        with pytest.raises(InputError) as error, own.axes_as_typed(over, analysis):
            raise InputError(message)
        assert str(error.value) == said


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("charge=3", "'charge' is not a component of --initial; known: displacement, velocity, viscous_mer"),
        ("1,0,3", "must be a displacement and a velocity, or all states"),
        ("1,0,3", "for example --initial 1,0 or --initial displacement=0.5"),
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


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ({"device": "soft-film", "settings": ["gravity=9.5,9.81"]}, "--set gravity=9.5,9.81: a list needs a unit on"),
        ({"settings": ["voltage=0,5"]}, "--set voltage=0,5: may be one number or two; write 0.5 with a point"),
        ({"settings": ["frequency=3"]}, "--set frequency: is a field of a device; without a device, set 'drive_frequ"),
        ({"settings": ["pull_in=minimum"]}, "pull_in: the film 'taut' does not take it"),
        ({"film": "taut", "settings": ["film=wrinkling"]}, "--film taut and --set film=wrinkling are both given; give"),
        ({"device": "soft-film", "film": "taut", "settings": ["film=wrinkling"]}, "--film taut and --set film=wrinkl"),
        ({"initial": "1"}, "--initial '1': must be a displacement and a velocity, for example --initial 1,0"),
        ({"device": "soft-film", "initial": "1"},
         "--initial '1': must be a displacement and a velocity, for example --initial \"5 mm,0 m/s\""),
    ],
)  # fmt: skip
def test_what_describes_no_actuator_is_refused(given, message):
    with pytest.raises(InputError) as error:
        read_subject(**given)
    assert str(error.value).startswith(message)


def test_a_way_to_pull_in_may_be_chosen_with_the_film_that_takes_it():
    for film, settings in (("wrinkling", []), (None, ["film=wrinkling"])):
        film = read_subject(film=film, settings=[*settings, "pull_in=minimum"]).model.film
        assert (film.name, film.pull_in) == ("wrinkling", "minimum")


@pytest.mark.parametrize(
    ("name", "over", "found"),
    [
        ("step", "constant_voltage=1", {"voltages": [1.0]}),
        ("frequency", "drive_frequency=0.5,1", {"frequencies": [0.5, 1.0]}),
        ("frequency", "drive_frequency=0.5", 'has one point; give at least two, or take gelcone settled --set "drive_'),
        ("envelope", "peak_voltage=0.5", "--over peak_voltage: has one point; a sweep takes at least two values"),
        ("step", "drive_frequency=1,2", "--over drive_frequency: cannot be swept here; step sweeps constant_voltage"),
        ("static", "voltage=1,2", "static sweeps constant_voltage and displacement; did you mean 'constant_voltage'?"),
        ("envelope", "damping_ratio=1,2", "cannot be swept here; envelope sweeps drive_frequency and peak_voltage"),
    ],
)
def test_an_axis_takes_as_many_values_as_it_needs(name, over, found):
    if isinstance(found, str):
        with pytest.raises(InputError) as error:
            read_subject().axes([over], find_analysis(name))
        assert found in str(error.value)
    else:
        axes = read_subject().axes([over], find_analysis(name))
        assert {keyword: values.tolist() for keyword, values in axes.items()} == found

"""Analyses of a device: options in SI, its own start, results in SI; sweeps over its fields; and what is refused."""

import inspect

import numpy as np
import pytest
import xarray as xr

import gelcone
from gelcone.analyses.request import read_subject
from gelcone.devices.analysis import (
    OF_DEVICES,
    Scaled,
    at_rest,
    dimensionless,
    for_devices,
    for_swept_devices,
    plain,
    state_of,
    with_units,
)
from gelcone.errors import DoubtfulInput, InputError
from gelcone.quantity import Time, Voltage
from gelcone.register.analyses import ANALYSES

DEVICE = gelcone.find_device("soft-film")


def test_a_device_runs_from_its_own_start_and_answers_in_si():
    shown = gelcone.simulate(DEVICE, periods=3)
    direct = gelcone.to_si(gelcone.simulate(DEVICE.to_model(), DEVICE.initial_state(), periods=3), DEVICE)
    xr.testing.assert_identical(shown, direct)
    assert shown.displacement.attrs == {"units": "mm", "quantity": "length", "long_name": "displacement"}
    assert shown.initial.values == pytest.approx([2.0, 0.0])
    assert shown.initial.attrs["units"] == "mm, m/s"
    xr.testing.assert_identical(gelcone.to_si(shown), shown)
    assert gelcone.model_of(shown).parameters() == DEVICE.to_model().parameters()


def test_options_of_a_device_are_si_numbers_or_texts():
    texts = gelcone.simulate(DEVICE, ("5 mm", "0 m/s"), times=["10 ms", "20 ms"])
    numbers = gelcone.simulate(DEVICE, (0.005, 0.0), times=[0.01, 0.02])
    xr.testing.assert_identical(texts, numbers)
    np.testing.assert_allclose(texts.time, [10.0, 20.0])
    assert float(gelcone.pitchfork_voltage(DEVICE.replace(film="taut")).pitchfork_voltage) > 100.0
    ramp = gelcone.stroke_and_blocked_force(DEVICE, ["0 V", "1 kV"])
    np.testing.assert_allclose(ramp.constant_voltage, [0.0, 1000.0])


def test_an_ensemble_of_devices_has_each_members_scales():
    """Thickness changes the scale of the voltage, mass that of the time; each member is the device run alone."""
    varied = DEVICE.replace({"film_thickness": [1e-4, 1.2e-4], "moving_mass": [1e-3, 2e-3]})
    both = gelcone.simulate(varied, periods=2)
    assert both.film_thickness.attrs["units"] == "mm"
    np.testing.assert_allclose(both.moving_mass, [1.0, 2.0])
    for k in range(2):
        alone = gelcone.simulate(
            DEVICE.replace(film_thickness=varied.film_thickness[k], moving_mass=varied.moving_mass[k]), periods=2
        )
        np.testing.assert_allclose(both.displacement[k][-1], alone.displacement[-1], rtol=1e-9)
        np.testing.assert_allclose(both.drive_voltage[k].max(), 530.0, rtol=1e-3)
        np.testing.assert_allclose(both.time[k][-1], alone.time[-1], rtol=1e-12)


@pytest.mark.parametrize("field", ["film_thickness", "material.young_modulus", "moving_mass", "damping_coefficient"])
def test_a_cell_of_a_sweep_is_the_device_of_its_values(field):
    own = {"material.young_modulus": 3.0 * DEVICE.material.shear_modulus}.get(field) or DEVICE.get(field)
    values = own * np.array([0.9, 1.1])
    swept = gelcone.sweep(gelcone.Plan(DEVICE, {field: values}), "settled")
    for k, value in enumerate(values):
        alone = gelcone.settled(DEVICE.replace({field: value}))
        for name in ("stroke", "highest"):
            assert float(swept[name][k]) == pytest.approx(float(alone[name]), rel=1e-9), name
        assert swept[name].attrs["units"] == "mm"
    assert swept[field].attrs["units"] in ("mm", "kPa", "g", "N s/m")
    assert swept[field].attrs["long_name"]
    assert gelcone.model_of(swept).shape == (2,)


def test_a_plan_of_a_device_survives_its_store(tmp_path):
    plan = gelcone.Plan(DEVICE, {"film_thickness": ["90 um", "0.1 mm"]}, options={"tolerance": 1e-9})
    first = gelcone.sweep(plan, "limits", store=tmp_path / "s")
    again = gelcone.sweep(plan, "limits", store=tmp_path / "s", resume=True)
    np.testing.assert_array_equal(first.onset_voltage, again.onset_voltage)
    assert gelcone.to_si(gelcone.show(tmp_path / "s")).film_thickness.values == pytest.approx([0.09, 0.1])


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda: gelcone.simulate("soft-film"), "was given the text 'soft-film'; gelcone.find_device"),
        (lambda: gelcone.simulate(gelcone.Plan(DEVICE, {"frequency": [8.0, 9.0]})), "was given a plan"),
        (lambda: gelcone.simulate(3), "was given the number 3 in place of a ConeModel or a Device"),
        (lambda: gelcone.settled(DEVICE, tolerance="x"), "tolerance = 'x': must be a number, without a unit"),
        (lambda: gelcone.limits(DEVICE, at_once="x"), "at_once = 'x': must be True or False"),
        (lambda: gelcone.limits(DEVICE.to_model(), at_once=1), "at_once = 1: must be True or False"),
        (
            lambda: gelcone.sweep(gelcone.Plan(DEVICE, {"frequency": [8.0, 9.0]}, options={"at_once": "x"}), "limits"),
            "at_once = 'x': must be True or False",
        ),
        (lambda: gelcone.lyapunov(DEVICE.to_model(), window="5 s"), "window = '5 s': must be a number, without a unit"),
        (
            lambda: gelcone.settled(DEVICE, threads="two"),
            "threads = 'two': must be a whole number, at least 1; leave it",
        ),
        (lambda: gelcone.simulate(DEVICE, period=3), "'period' is not an option of simulate; did you mean 'periods'?"),
        (
            lambda: gelcone.simulate(DEVICE.to_model(), zz=3),
            "'zz' is not an option of simulate; known: initial, periods",
        ),
        (lambda: gelcone.static(DEVICE, voltages="-1 kV"), "voltages = -1 kV: must be at least 0; leave out the sign"),
        (lambda: gelcone.basin(DEVICE, 3), "over: was given the number 3; give names and their values"),
        (lambda: gelcone.simulate(DEVICE, workers=2), "takes no workers; threads=N"),
        (lambda: gelcone.simulate(DEVICE.to_model(), workers=2), "takes no workers; threads=N"),
        (lambda: gelcone.map(DEVICE.to_model(), {"voltage": [0.1, 0.2]}, workers=2), "workers"),
        (lambda: gelcone.sweep(DEVICE), "was given a Device; give a plan"),
        (lambda: gelcone.regime(gelcone.simulate(DEVICE, periods=1)), "was given a result"),
        (lambda: gelcone.to_si(DEVICE), "to_si: was given a Device; give a Dataset"),
        (lambda: gelcone.to_si(xr.Dataset()), "does not say of which device"),
        (lambda: gelcone.simulate(DEVICE, times=["20 mm"]), "mm is a unit of length, not of time"),
        (lambda: gelcone.simulate(DEVICE, (1.0,)), "must be a displacement and a velocity, such as"),
        (lambda: gelcone.Plan(DEVICE, {"voltage": [1.0, 2.0]}), "did you mean 'voltage_amplitude'"),
        (lambda: gelcone.map(DEVICE, {"material": [1.0, 2.0]}), "is not a material"),
        (lambda: gelcone.map(DEVICE, {"waveform": [1.0, 2.0]}), "is not numeric and cannot be swept"),
        (
            lambda: gelcone.frequency(DEVICE.replace(damping_coefficient=0.0)),
            "damping_coefficient = 0: without damping",
        ),
    ],
)
def test_what_is_in_the_wrong_place_gives_one_clear_line(call, message):
    with pytest.raises(InputError) as caught:
        call()
    assert message in str(caught.value)
    assert "\n" not in str(caught.value)


def test_a_device_that_nothing_moves_says_so():
    flat = DEVICE.replace(release_height=None)
    with pytest.warns(DoubtfulInput, match="starts at rest in the middle of the flat film, .* set release_height"):
        still = gelcone.simulate(flat, periods=1)
    assert float(abs(still.displacement).max()) == 0.0
    gelcone.simulate(flat, ("1 mm", "0 m/s"), periods=1)


AMPLIFIED = DEVICE.replace(
    {
        "film": "taut",
        "series_resistance": "5 MOhm",
        "material.viscous_modulus_1": "4 kPa",
        "material.relaxation_time_1": "2 s",
    }
)
"""Its states are those of its material and of its amplifier."""


def test_a_start_has_the_states_of_material_and_amplifier():
    names = [state.name for state in AMPLIFIED.to_model().system.states]
    assert names[2:] == ["viscous_meridional_1", "viscous_hoop_1", "film_voltage"]
    scales = AMPLIFIED.scales
    run = gelcone.simulate(AMPLIFIED, ("2 mm", 0.0, 0.9, 1.1, "1 kV"), times=["10 ms"])
    assert run.initial.values == pytest.approx([2.0, 0.0, 0.9, 1.1, 1e3])
    assert run.initial.units == "mm, m/s, 1, 1, V"
    text = "displacement=2 mm, viscous_meridional_1=0.9, viscous_hoop_1=1.1, film_voltage=1 kV"
    subject = read_subject(AMPLIFIED, initial=text)
    plain = gelcone.simulate(AMPLIFIED.to_model(), subject.initial, times=[1.0])
    np.testing.assert_allclose(plain.initial, [2e-3 / scales.length, 0.0, 0.9, 1.1, 1e3 / scales.voltage], rtol=1e-12)
    with pytest.raises(InputError, match="or all of them: displacement, velocity, viscous_meridional_1"):
        gelcone.simulate(AMPLIFIED, ("2 mm", 0.0, 0.9), times=["10 ms"])


def test_the_pitchfork_of_devices_that_differ_in_their_unit_of_voltage_is_in_volts():
    device = DEVICE.replace(film="taut", initial_height=0.0)
    for one in (device, device.replace(film_thickness=[1e-4, 2e-4])):
        own = gelcone.pitchfork_voltage(one.to_model()).pitchfork_voltage * one.scales.voltage
        np.testing.assert_allclose(gelcone.pitchfork_voltage(one).pitchfork_voltage, own, rtol=1e-14)
        assert np.all(own > 100.0)


def test_one_option_of_devices_in_different_units_is_a_time_that_is_long_enough_in_each_or_refused():
    """A mass changes the unit of time, and so of a velocity, and leaves that of voltage."""
    several = DEVICE.replace(moving_mass=[4e-3, 1e-3])
    slow, fast = several.scales.time
    assert slow > fast
    taken = dimensionless(
        {"window": "time", "level": "voltage", "start": "velocity"}, {"window": "2 s"}, several.scales
    )
    assert float(taken["window"]) == pytest.approx(2.0 / fast)
    assert float(taken["window"]) * slow >= 2.0
    volts = dimensionless({"level": "voltage"}, {"level": "2 kV"}, several.scales)["level"]
    assert float(volts) == pytest.approx(2e3 / DEVICE.scales.voltage)
    for quantity, value in (("velocity", "1 m/s"), ("frequency", "1 Hz")):
        with pytest.raises(InputError, match=f"speed: is one {quantity} for devices whose units of {quantity} differ"):
            dimensionless({"speed": quantity}, {"speed": value}, several.scales)
    kept = dimensionless({"a": "time", "b": "", "c": "time"}, {"a": Scaled(3.0), "b": 4.0, "c": None}, several.scales)
    assert kept == {"a": 3.0, "b": 4.0, "c": None}


def test_an_analysis_of_a_swept_device_takes_options_in_si_and_leaves_defaults_as_they_are():
    """Also the start: without one each device has its own, given in millimetres it is that of all."""
    seen = {}

    def own(model, *, initial=(1.0, 0.0), window: Time = 30.0, level: Voltage = 2.0):
        """Do nothing."""
        seen.update(initial=initial, window=window, level=level)
        return gelcone.simulate(model, periods=1)

    run = for_swept_devices(own)
    run(DEVICE)
    assert seen == {"initial": None, "window": 30.0, "level": 2.0}
    assert isinstance(seen["window"], Scaled)
    run(DEVICE, initial=("1 mm", "0 m/s"), level="1 kV")
    assert seen == {"initial": ("1 mm", "0 m/s"), "window": 30.0, "level": "1 kV"}
    run(DEVICE.to_model())
    assert seen == {"initial": (1.0, 0.0), "window": 30.0, "level": 2.0}


def test_a_docstring_states_once_of_each_parameter_what_it_is_of_a_device():
    """Not where it speaks of devices itself; of a quantity with its unit."""

    def analysis(model, initial, own, wait: "Time", volts: "Voltage"):
        """Do it.

        Parameters
        ----------
        model : a model.
        initial : where it begins; of a device its own release.
        own : a number.
        wait, volts : quantities.

        Returns
        -------
        What it does.
        """

    entries = with_units(analysis).partition("----------\n")[2].partition("\n\n")[0].splitlines()
    assert entries == [
        "model : a model.",
        f"    {OF_DEVICES['model']}",
        "initial : where it begins; of a device its own release.",
        "own : a number.",
        "wait, volts : quantities.",
        "    With a device in V, or texts with units.",
        "    With a device in s, or texts with units.",
    ]
    assert with_units(analysis).endswith("Returns\n-------\nWhat it does.")


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (
            lambda: gelcone.environment("biased-pump"),
            "environment: takes a device, and was given the text 'biased-pump'",
        ),
        (lambda: gelcone.rates(gelcone.ConeModel()), "rates: takes a device, and was given a ConeModel"),
        (lambda: gelcone.integrate(gelcone.find_device("biased-pump"), (0.0, 0.0), [1.0]), "integrate: takes a model"),
        (lambda: gelcone.model_of(3), "model_of: was given the number 3; give a Dataset"),
        (
            lambda: gelcone.design("wish.toml"),
            "design: was given the text 'wish.toml'; give a wish, such as gelcone.read_",
        ),
        (
            lambda: gelcone.fit_device(DEVICE, "tests.toml", {}),
            "fit_device: was given the text 'tests.toml'; give tests",
        ),
        (lambda: gelcone.plan_device(DEVICE, None, {}), "plan_device: was given None; give tests on a device, such as"),
        (
            lambda: gelcone.fit_material("a.csv"),
            "fit_material: was given the text 'a.csv'; give tests on coupons, such",
        ),
    ],
)
def test_what_a_function_does_not_take_is_refused_in_words(call, message):
    with pytest.raises(gelcone.InputError, match=message):
        call()


def test_an_analysis_gets_numbers_without_units():
    """The model, its start and options by position or name; what is not a Dataset comes back as it is."""
    seen = {}

    def wait(model, initial=(1.0, 0.0), span: "Time" = 5.0, *, level: "Voltage" = 2.0, count=3):
        """Do nothing."""
        seen.update(model=model, initial=initial, span=span, level=level, count=count)
        return 7.0

    scales = DEVICE.scales
    run = for_devices(wait)
    assert run(DEVICE, ("1 mm", "0.1 m/s"), "3 s", level=500.0) == 7.0
    np.testing.assert_allclose(seen["initial"], [1e-3 / scales.length, 0.1 / scales.velocity])
    assert float(seen["span"]) == pytest.approx(3.0 / scales.time)
    assert float(seen["level"]) == pytest.approx(500.0 / scales.voltage)
    assert seen["count"] == 3
    assert seen["model"].parameters() == DEVICE.to_model().parameters()
    run(DEVICE)
    np.testing.assert_allclose(seen["initial"], DEVICE.initial_state())
    assert (seen["span"], seen["level"]) == (5.0, 2.0)
    assert run(DEVICE.to_model(), span=4.0) == 7.0
    assert (seen["initial"], seen["span"]) == ((1.0, 0.0), 4.0)
    assert plain(run) is wait


def test_states_of_many_starts_are_over_length_and_velocity():
    starts = np.array([[1e-3, 0.1], [2e-3, 0.2], [3e-3, 0.3]])
    found = state_of(DEVICE, starts)
    np.testing.assert_allclose(found[:, 0], starts[:, 0] / DEVICE.scales.length)
    np.testing.assert_allclose(found[:, 1], starts[:, 1] / DEVICE.scales.velocity)
    several = DEVICE.replace(moving_mass=[1e-3, 4e-3])
    found = state_of(several, starts[:2])
    np.testing.assert_allclose(found[:, 1], starts[:2, 1] / several.scales.velocity)


def test_a_start_from_which_nothing_moves_is_told_apart_from_one_that_was_chosen():
    """Raised with no voltage at its own rest; or flat, where a drive alone does nothing to a symmetric film."""
    raised = gelcone.find_device("biased-pump").replace(film="taut")
    still = raised.replace(voltage_amplitude=0.0, voltage_offset=0.0)
    state = raised.initial_state()
    told = "without a voltage the disc stays at its rest; set voltage_amplitude, voltage_offset or release_height"
    assert at_rest(still, state) == told
    assert at_rest(raised, state) == ""
    for moving in ({"voltage_offset": 10.0}, {"voltage_amplitude": 10.0}, {"release_height": 1e-3},
                   {"release_velocity": 0.1}):  # fmt: skip
        assert at_rest(still.replace(moving), state) == ""
    flat = DEVICE.replace(film="taut", release_height=None)
    assert at_rest(flat, (0.0, 0.0)).startswith("the disc starts at rest in the middle of the flat film")
    assert at_rest(flat.replace(initial_height=[0.0, 1e-3]), (0.0, 0.0)) == ""
    assert at_rest(raised, (0.0, 0.0)) == ""


def test_a_time_of_devices_with_several_units_is_that_of_the_fastest():
    several = DEVICE.replace(moving_mass=[4e-3, 1e-3, 9e-3])
    taken = dimensionless({"window": "time"}, {"window": "2 s"}, several.scales)
    assert float(taken["window"]) == pytest.approx(2.0 / several.scales.time[1])


OF_ONE = {
    "datasheet": lambda own: gelcone.datasheet(own),
    "drive": lambda own: gelcone.drive(own),
    "envelope": lambda own: gelcone.envelope(own),
    "transfer": lambda own: gelcone.transfer(own),
    "creep": lambda own: gelcone.creep(own),
    "step": lambda own: gelcone.step(own),
    "tongues": lambda own: gelcone.tongues(own, ["5 Hz", "9 Hz"], ["1 kV", "2 kV"]),
    "state_space": lambda own: gelcone.state_space(own),
    "rates": lambda own: gelcone.rates(own),
    "environment": lambda own: gelcone.environment(own),
    "Plan": lambda own: gelcone.Plan(own, {"frequency": [1.0, 2.0]}),
    "continue_branch": lambda own: gelcone.continue_branch(own, "frequency", "5 Hz", "6 Hz"),
    "export": lambda own: gelcone.export(own, "own.fmu"),
    "studio": lambda own: gelcone.studio(own),
}  # fmt: skip


@pytest.mark.parametrize("name", OF_ONE)
def test_what_takes_one_actuator_says_so_in_the_same_words(name):
    with pytest.raises(InputError) as raised:
        OF_ONE[name](DEVICE.replace(frequency=[7.0, 8.0, 9.0]))
    text = "takes one actuator, not an ensemble of 3; give every field and parameter one value"
    assert str(raised.value) == f"{name}: {text}"


@pytest.mark.parametrize("name", [name for name, one in ANALYSES.items() if one.planned])
def test_an_analysis_of_one_actuator_refuses_an_ensemble_in_its_own_name(name):
    """Also those that make a plan, with models as with devices."""
    asked = {"over": {}, "parameter": "voltage", "values": [0.1], "low": 0.1, "high": 0.2, "event": "fold"}
    taken = inspect.signature(getattr(gelcone, name)).parameters
    given = {word: value for word, value in asked.items() if word in taken}
    for several in (gelcone.ConeModel(voltage=[0.1, 0.2]), DEVICE.replace(film="taut", frequency=["8 Hz", "9 Hz"])):
        with pytest.raises(InputError, match=f"^{name}: takes one actuator, not an ensemble of 2; give every field"):
            getattr(gelcone, name)(several, **given)

"""Designs by closed forms, against the analyses of the devices that they stand for."""

from types import SimpleNamespace

import numpy as np
import pytest

import gelcone
from gelcone.devices import cone
from gelcone.lab import candidates
from gelcone.lab.candidates import LIMITS, draws_of, examine

PUMP = gelcone.find_device("biased-pump").replace(film="taut", voltage_amplitude=30.0, voltage_offset=900.0)
THICK = np.array([[1.9e-4, 2.1e-4], [2.3e-4, 2.5e-4]])


@pytest.fixture(scope="module")
def found():
    return examine(PUMP, {"film_thickness": THICK}, 1.2)


def device(thickness, **changes):
    return PUMP.replace(film_thickness=float(thickness), **changes)


def test_values_are_those_of_each_device(found):
    for place in ((0, 0), (1, 1)):
        own = device(THICK[place])
        settled, s = gelcone.settled(own), own.scales
        values = {name: float(value[place]) for name, value in found.values.items()}
        assert values["rest_height"] == pytest.approx(own.initial_state()[0] * s.length, rel=1e-9)
        assert values["peak_voltage"] == pytest.approx(930.0, rel=1e-12)
        assert values["footprint"] == 2.0 * own.film_radius
        assert 1e3 * values["stroke"] == pytest.approx(float(settled["stroke"]), rel=0.03)
        assert 1e3 * values["apparent_power"] == pytest.approx(float(settled["apparent_power"]), rel=0.01)
        assert 1e3 * values["current"] == pytest.approx(float(settled["current"]), rel=0.02)
        blocked = gelcone.stroke_and_blocked_force(own, ["930 V"])["blocked_force"]
        assert values["blocked_force"] == pytest.approx(float(blocked[0]), rel=1e-6)


def test_the_natural_frequency_is_that_about_the_height_of_the_mean_square(found):
    own = device(THICK[0, 0])
    volts = np.hypot(900.0, 30.0 / np.sqrt(2.0))
    transfer = gelcone.transfer(own, ["5 Hz"], bias=f"{volts} V", amplitudes=0.0)
    assert float(found.values["natural_frequency"][0, 0]) == pytest.approx(
        float(transfer["natural_frequency"]), rel=1e-6
    )


def test_a_motion_lags_as_the_settled_one_does(monkeypatch):
    """Near its resonance, by a quarter of a turn and more; its mean is that of the settled one."""
    own, motions = device(THICK[0, 0], frequency=11.2, damping_coefficient="30 mN s/m"), []
    monkeypatch.setattr(
        candidates, "_motion", lambda *given, made=candidates._motion: motions.append(made(*given)) or motions[-1]
    )
    examine(own, {"film_thickness": THICK[:1, :1]}, 1.2)
    settled = gelcone.settled(own)
    parts = np.fft.rfft(motions[0].x[0]) * own.scales.length * 1e3 * 2.0 / candidates.PHASES
    phase = np.degrees(np.angle(parts[1])) + 90.0  # ahead of a sine
    assert abs(parts[1]) == pytest.approx(float(settled["harmonic_amplitude"][0]), rel=0.03)
    assert (phase - float(settled["harmonic_phase"][0]) + 180.0) % 360.0 - 180.0 == pytest.approx(0.0, abs=3.0)
    assert 0.5 * parts[0].real == pytest.approx(float(settled["mean"]), rel=0.01)


@pytest.mark.parametrize(("name", "value"), [("damping_ratio", 0.04), ("quality_factor", 12.5)])
def test_a_damping_over_the_critical_one_is_that_about_the_rest_of_each_design(monkeypatch, name, value):
    """Near the resonance, whether it is fixed or changes, and without a search for the rests of the designs."""
    pump, rates = PUMP.replace(frequency=11.0), np.array([[20.0], [40.0]])
    relative = pump.replace({name: value})
    owns = [relative.replace(spring_rate=rate).to_model().damping_ratio for rate in rates[:, 0]]
    coefficients = 2.0 * np.array(owns)[:, None] / relative.scales.time * relative.moving_mass
    expected = examine(pump, {"spring_rate": rates, "damping_coefficient": coefficients}, 1.2)
    monkeypatch.setattr(cone, "rest_displacements", lambda model: pytest.fail("searched"))
    for changes in ({"spring_rate": rates}, {"spring_rate": rates, name: np.full_like(rates, value)}):
        found = examine(relative, changes, 1.2)
        for measure in ("stroke", "apparent_power"):
            np.testing.assert_allclose(found.values[measure], expected.values[measure], rtol=1e-9)


def test_a_design_without_a_rest_has_no_values_and_others_do():
    """Stretched beyond its limit as mounted; its damping ratio has nothing to refer to."""
    pump = PUMP.replace({"damping_ratio": 0.05, "material.stretch_limit": 20.0})
    found = examine(pump, {"hoop_prestretch": np.array([[1.4], [6.0]])}, 1.2)
    assert np.isfinite(found.values["stroke"][0, 0])
    assert np.isnan(found.values["stroke"][1, 0])


def test_limits_are_met_where_the_states_of_a_ramp_meet_them(found):
    """The voltage at each limit, within the lines between forty heights; below the first none is met."""
    own = device(THICK[1, 1])
    limits = dict(zip(LIMITS, found.limits[:, 1, 1], strict=True))
    volts = np.linspace(1.0, min(limits["pull-in"] * 0.999, 6e3), 400)
    ramp = gelcone.stroke_and_blocked_force(own, volts)
    model, s = own.to_model(), own.scales
    x = ramp["displacement"].values * 1e-3 / s.length
    state = model.system.film.state(x, volts / s.voltage, [], model.own_numbers)
    strength = own.dielectric_strength / s.field
    beyond = {
        "hoop slack": state.hoop_stress < 0.0,
        "meridional slack": state.meridional_stress < 0.0,
        "dielectric breakdown": state.true_field > strength,
        "stretch limit": state.limit_share > 1.0,
    }
    for name, met in beyond.items():
        first = volts[np.argmax(met)] if np.any(met) else np.inf
        expected = limits[name] if limits[name] < volts[-1] else np.inf
        assert first == pytest.approx(expected, rel=0.02), name
    pull_in = float(gelcone.pull_in_voltage(own)["pull_in_voltage"])
    assert limits["pull-in"] == pytest.approx(pull_in, rel=0.02)


def test_a_value_rises_through_zero_on_the_line_between_columns_up_to_the_last():
    voltage = np.array([[0.0, 1.0, 2.0, 4.0]] * 4)
    beyond = np.array([[-1.0, -1.0, 1.0, 5.0], [-3.0, -2.0, -1.0, 0.5], [2.0, 3.0, 4.0, 5.0], [-1.0, -1.0, -1.0, 3.0]])
    last = np.array([3, 3, 3, 2])
    with np.errstate(all="ignore"):
        found = candidates._first(voltage, beyond, last)
    np.testing.assert_allclose(found, [1.5, 2.0 + 2.0 * (1.0 / 1.5), 0.0, np.inf])


def test_a_height_of_the_ramp_is_on_the_line_between_columns_and_none_beyond_its_fold():
    x = np.array([[1.0, 2.0, 3.0, 4.0]])
    squared = np.array([[0.0, 1.0, 3.0, 2.0]])
    means = np.array([[0.0], [0.5], [2.0], [3.0], [3.5]])
    with np.errstate(all="ignore"):
        found = candidates._on_ramp(np.repeat(x, 5, axis=0), np.repeat(squared, 5, axis=0), means)[:, 0]
    np.testing.assert_allclose(found, [1.0, 1.5, 2.5, 3.0, np.nan])


def test_a_harder_drive_fails_where_a_limit_is_met_and_not_below():
    """The share by which it is beyond: positive under a drive above the first limit of the ramp, negative below."""
    volts = np.array([300.0, 900.0, 2300.0])
    own = PUMP.replace(voltage_amplitude=1.0, voltage_offset=0.0)
    found = examine(own, {"voltage_offset": volts[:, None]}, 1.0)
    first = np.nanmin(found.limits[:, 0, 0])
    beyond = found.failing[:, 0]
    assert (beyond[volts < 0.97 * first] < 0.0).all()
    assert not (beyond[volts > 1.03 * first] < 0.0).any()
    assert (volts < 0.97 * first).any()


def test_draws_are_normal_and_repeat_with_their_seed():
    drawn = draws_of(2, 4096, 3)
    np.testing.assert_allclose(drawn.std(axis=0), [1.0, 1.0], rtol=0.02)
    np.testing.assert_allclose(drawn.mean(axis=0), 0.0, atol=0.02)
    assert abs(np.corrcoef(drawn.T)[0, 1]) < 0.02
    np.testing.assert_array_equal(drawn, draws_of(2, 4096, 3))
    assert (drawn != draws_of(2, 4096, 4)).any()
    assert draws_of(0, 8, 3).shape == (1, 0)


@pytest.mark.parametrize("limit", [np.inf, 300.0, 12.0, 3.0])
def test_a_ramp_rises_in_equal_ratios_from_the_rest_to_the_stretch_limit(limit):
    """At each of its heights its voltage holds the disc; where nothing lifts the disc there is no rest."""
    model = PUMP.replace(film_thickness="0.2 mm").to_model().replace(stretch_limit=limit)
    model = model.replace(spring_stiffness=np.array([float(model.spring_stiffness), 1e-9]), rest_height=[0.8, -0.5])
    members = model.members()
    n, system = members.numbers(trailing=1), members.system
    rest, highest = candidates._rest(system, n, 2)
    assert float(system.static_force(rest, 0.0, n)[0][0, 0]) == pytest.approx(0.0, abs=1e-9)
    assert np.isnan(rest[1, 0])
    if limit < 100.0:
        np.testing.assert_allclose(system.film.strain(highest, n), np.full((2, 1), limit), rtol=2e-6)
    else:
        np.testing.assert_array_equal(highest, candidates.GREATEST_HEIGHT)
    x, squared = candidates._ramp(system, n, rest, highest)
    np.testing.assert_allclose(x[0, 1:] / x[0, :-1], (highest[0, 0] / rest[0, 0]) ** (1.0 / 39.0))
    assert (x[0, 0], squared[0, 0]) == (rest[0, 0], 0.0)
    np.testing.assert_allclose(system.static_force(x, squared, n)[0][0], 0.0, atol=1e-9)


def spectral(values, times):
    """The derivative of a periodic function over the phase, ``times`` over."""
    count = np.arange(candidates.PHASES // 2 + 1)
    return np.fft.irfft(np.fft.rfft(values) * (1j * count) ** times, candidates.PHASES)


@pytest.mark.parametrize("offset", [0.0, 0.7, -0.7])
def test_a_motion_obeys_its_equation_and_its_current_is_the_rate_of_the_charge(offset):
    """Of constant stiffness, with a capacitance C = c + 2 g x: x'' + 2 d x' + k (x - x0) = g V^2, whose two harmonics
    the phases resolve, and I = d(C V)/dt."""
    k, x0, g, c, d, omega, amplitude = 3.0, 0.4, 0.2, 1.5, 0.15, 0.9, 0.3
    film = SimpleNamespace(
        voltage_gain=lambda x, squared, n: g + 0.0 * x, capacitance=lambda x, squared, y, n: c + 2.0 * g * x
    )
    system = SimpleNamespace(film=film, static_force=lambda x, squared, n: (k * (x - x0) - g * squared, k + 0.0 * x))
    own = {"voltage_bias": offset, "voltage": amplitude, "drive_frequency": omega, "damping_ratio": d}
    own = {name: np.full((1, 1), value) for name, value in own.items()}
    heights = np.linspace(x0, 2.0, 8)[None]
    for share in (1.0, 1.25):
        motion = candidates._motion(system, None, own, heights, k * (heights - x0) / g, share)
        x, volts = motion.x[0], motion.voltage[0]
        phases = 2.0 * np.pi * np.arange(candidates.PHASES) / candidates.PHASES
        np.testing.assert_allclose(volts, share * (offset + amplitude * np.sin(phases)), atol=1e-15)
        pull = omega**2 * spectral(x, 2) + 2.0 * d * omega * spectral(x, 1) + k * (x - x0)
        np.testing.assert_allclose(pull, g * volts**2, atol=1e-13)
        np.testing.assert_allclose(motion.current[0], omega * spectral((c + 2.0 * g * x) * volts, 1), atol=1e-13)
        assert motion.natural[0] == np.sqrt(k)


def test_where_nothing_holds_the_disc_there_is_no_motion():
    """A stiffness that is negative at the height of the ramp."""
    film = SimpleNamespace(
        voltage_gain=lambda x, squared, n: 0.2 + 0.0 * x, capacitance=lambda x, squared, y, n: 1.0 + 0.0 * x
    )
    system = SimpleNamespace(film=film, static_force=lambda x, squared, n: (0.1 - x, -1.0 + 0.0 * x))
    own = {"voltage_bias": 0.3, "voltage": 0.1, "drive_frequency": 0.9, "damping_ratio": 0.1}
    own = {name: np.full((1, 1), value) for name, value in own.items()}
    heights = np.linspace(0.4, 2.0, 8)[None]
    with np.errstate(all="ignore"):
        motion = candidates._motion(system, None, own, heights, heights - 0.4, 1.0)
    assert np.isnan(motion.x).all()
    assert np.isnan(motion.natural).all()


def beyond_by(x=(0.5, 0.6), hoop=(0.1, 0.2), meridional=(0.3, 0.2), field=(1.0, 1.5), share=(0.2, 0.4), **own):
    """`_failing` of a motion with these states at two phases."""
    at = lambda values: np.array([values])  # noqa: E731
    state = SimpleNamespace(
        hoop_stress=at(hoop), meridional_stress=at(meridional), true_field=at(field), limit_share=at(share)
    )
    film = SimpleNamespace(state=lambda x, voltage, y, n: state)
    motion = candidates.Motion(at(x), at((0.0, 0.0)), at((0.0, 0.0)), np.ones(1))
    with np.errstate(all="ignore"):
        return float(candidates._failing(SimpleNamespace(film=film), None, own, motion)[0])


def test_a_motion_fails_by_the_largest_of_its_shares_at_any_phase():
    """Of compression, of the field over its strength, of the stretch limit, and of falling below the flat film."""
    assert beyond_by() == pytest.approx(-0.1)
    assert beyond_by(hoop=(0.5, -0.3)) == pytest.approx(0.3)
    assert beyond_by(meridional=(-0.4, 0.5)) == pytest.approx(0.4)
    assert beyond_by(share=(1.2, 0.1)) == pytest.approx(0.2)
    assert beyond_by(x=(0.4, -0.7)) == pytest.approx(0.7)
    assert beyond_by(dielectric_strength=np.array([[1.25]])) == pytest.approx(0.2)
    assert beyond_by(dielectric_strength=np.array([[np.nan]])) == pytest.approx(-0.1)


def test_a_drive_of_the_opposite_sign_does_the_same():
    """The film sees the square of its voltage: peak, power and limits are those of the mirrored drive."""
    mirrored = [examine(PUMP, {"voltage_offset": np.array([[volts]])}, 1.2) for volts in (900.0, -900.0)]
    for name, values in mirrored[0].values.items():
        np.testing.assert_allclose(mirrored[1].values[name], values, rtol=1e-9, err_msg=name)
    np.testing.assert_allclose(mirrored[1].limits, mirrored[0].limits, rtol=1e-9)
    assert float(mirrored[1].values["peak_voltage"][0, 0]) == pytest.approx(930.0)


def test_beyond_the_fold_of_a_ramp_no_limit_is_met():
    """A voltage that falls behind its fold meets a limit there at once by the film's state, and not on the ramp."""
    x = np.linspace(0.5, 2.0, candidates.HEIGHTS)[None]
    squared = np.where(x < 1.2, x - 0.5, 1.9 - x)
    film = SimpleNamespace(
        state=lambda x, voltage, y, n: SimpleNamespace(
            hoop_stress=1.0 + 0.0 * x, meridional_stress=1.5 - x, true_field=x * voltage, limit_share=0.6 * x
        )
    )
    with np.errstate(all="ignore"):
        found = candidates._limits(
            SimpleNamespace(film=film), None, {"dielectric_strength": np.array([[0.7]])}, x, squared
        )
    limits = dict(zip(LIMITS, found[:, 0], strict=True))
    assert limits["pull-in"] == np.sqrt(squared.max())
    assert np.isinf([limits["hoop slack"], limits["meridional slack"], limits["stretch limit"]]).all()
    fields = x[0] * np.sqrt(np.maximum(x[0] - 0.5, 0.0))
    assert limits["dielectric breakdown"] == pytest.approx(0.7 / np.interp(0.7, fields, x[0]), rel=1e-2)

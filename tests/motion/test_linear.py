"""Linear theory: the motion under a weak drive, dynamic stiffness, loaded circuits, amplifiers."""

from __future__ import annotations

import numpy as np
import pytest

import gelcone
from gelcone.motion import linear as module
from gelcone.motion.flow import integrate
from gelcone.motion.linear import linear_response
from gelcone.motion.state_space import equilibrium_under_bias, small_signal_response, state_space
from gelcone.physics.model import ConeModel
from gelcone.physics.waveforms import Burst, Chirp, Harmonics, Staircase
from tests.physics.test_circuit import BRANCH, Lossy
from tests.toys import CubicBias, FilteredVoltage, PowerFilm, SeriesResistor, ThreeHarmonics

# --- circuits, waveforms and films of one's own -----------------------------------------------------------------------


@pytest.mark.parametrize(
    "parts",
    [
        {},
        {"waveform": ThreeHarmonics()},
        {"circuit": FilteredVoltage()},
        {"bias": CubicBias(), "film": PowerFilm(), "waveform": ThreeHarmonics(), "circuit": FilteredVoltage()},
    ],
    ids=["sine", "three harmonics", "filter", "all"],
)
def test_the_linear_response_is_the_motion_under_a_weak_drive(parts):
    """A small drive about a large constant force: stroke and first two harmonics against the full motion."""
    kept = {} if "film" in parts else {"hoop_prestretch": 1.4}
    own = {"bias_stiffness": -0.1} if "bias" in parts else {"rest_height": 0.8}
    model = ConeModel(damping_ratio=0.2, voltage=1e-4, voltage_bias=0.6, drive_frequency=0.7, **kept, **own, **parts)
    place = equilibrium_under_bias(model, 0.6)
    assert place > 0.1
    period = float(model.drive_period)
    times = np.concatenate([[40 * period], 40 * period + period * np.arange(1, 129) / 128])
    start = model.members().start_states((place, 0.0))
    if len(model.system.states) == 3:
        start[:, 2] = 0.6
    x = integrate(model, start, times).states[0, 1:, 0]
    found = linear_response(model, np.array([0.7]))
    assert np.ptp(x) == pytest.approx(float(found.stroke[0]), rel=1e-3)
    turn = np.exp(-1j * np.outer([1, 2], 0.7 * times[1:]))
    harmonics = 2j * (turn * x).mean(axis=1)
    np.testing.assert_allclose(found.harmonics[0, 0], harmonics[0], rtol=1e-3)
    if "waveform" in parts:
        np.testing.assert_allclose(found.harmonics[1, 0], harmonics[1], rtol=2e-3)


def test_harmonics_that_the_drive_lacks_are_exactly_zero():
    """The square of a sine has no part at its own frequency, only rounding."""
    model = ConeModel(voltage=0.3, rest_height=0.4, spring_stiffness=2.0, damping_ratio=0.1)
    first, second = linear_response(model, np.array([0.7])).harmonics[:, 0]
    assert first == 0.0 < abs(second)


RICH = {
    "sine": {}, "triangle": {"waveform": "triangle"}, "square": {"waveform": "square"},
    "jumps": {"waveform": "square", "rise": 0.0, "duty": 0.3}, "trapezoid": {"waveform": "trapezoid"},
    "ramp": {"waveform": "ramp"}, "half wave": {"waveform": "half_wave", "voltage": 3e-3, "voltage_bias": -1e-3},
    "burst": {"waveform": Burst(10, 20)}, "ninth harmonic": {"waveform": Harmonics(((9, 1.0, 0.0),))},
    "staircase": {"waveform": Staircase()},
}  # fmt: skip
CHIRP = Chirp(repeat=True)
LOADS = {
    "ideal": {},
    "amplifier": {"filter_time": 0.3, "series_resistance": 0.2, "leakage_time": 5.0},
    "late": {"dielectric_share": 0.4, "dielectric_time": 2.0, "series_resistance": 0.1},
}


BEHIND = {"amplifier": ("sine", "jumps", "half wave", "ninth harmonic"), "late": ("triangle", "trapezoid", "burst")}
CASES = [
    pytest.param(wave, load, marks=[] if wave in BEHIND.get(load, RICH) else pytest.mark.slow)
    for load in LOADS
    for wave in RICH
]
"""All pairs; of each load, a factor of each harmonic, some waveforms, and all of an ideal source."""


@pytest.mark.parametrize(("wave", "load"), CASES)
def test_linear_theory_has_all_harmonics_of_the_drive(wave, load):
    """Of a weak drive the stroke is that of the settled motion: slow, around resonances of several harmonics, fast."""
    weak = {"voltage": 1e-4, "voltage_bias": 0.6, "rest_height": 0.8, "hoop_prestretch": 1.4, "film": "taut"}
    model = ConeModel(damping_ratio=0.3, **(weak | LOADS[load] | RICH[wave]))
    resonance = np.abs(np.linalg.eigvals(state_space(model, voltage=0.6).A)).max() if load == "ideal" else 1.5
    found = gelcone.settled(model.replace(drive_frequency=resonance * np.array([0.1, 1 / 3, 0.95, 5.0])), (0.55, 0.0))
    assert np.isfinite(found["linear_stroke"]).all()
    np.testing.assert_allclose(found["linear_stroke"], found["stroke"], rtol=2e-4)


def test_the_linear_stroke_of_slow_jumps_has_their_overshoot():
    """Between jumps an oscillator comes to rest, each time after an overshoot exp(-pi zeta/sqrt(1 - zeta^2))."""
    model = ConeModel(
        damping_ratio=0.2, voltage=1e-4, voltage_bias=0.6, rest_height=0.8, hoop_prestretch=1.4, waveform="square",
        rise=0.0,
    )  # fmt: skip
    linear = state_space(model)
    stiffness, zeta = -linear.A[1, 0], -0.5 * linear.A[1, 1] / np.sqrt(-linear.A[1, 0])
    overshoot = np.exp(-np.pi * zeta / np.sqrt(1.0 - zeta * zeta))
    expected = 2e-4 * linear.B[1, 0] / stiffness * (1.0 + 2.0 * overshoot)
    slow = linear_response(model, np.array([1e-2, 1e-3])).stroke
    np.testing.assert_allclose(slow, expected, rtol=5e-4)


def test_a_waveform_with_times_of_its_own_has_another_shape_at_each_frequency():
    """A chirp sweeps the same frequencies in any repeat."""
    model = ConeModel(damping_ratio=0.3, voltage=1e-3, voltage_bias=0.6, rest_height=0.8, film="taut", waveform=CHIRP)
    grid = np.array([0.1, 0.2])
    found = linear_response(model.replace(drive_frequency=0.5), grid)
    alone = gelcone.settled(model.replace(drive_frequency=grid), (0.55, 0.0))
    np.testing.assert_array_equal(found.stroke, alone["linear_stroke"])
    np.testing.assert_allclose(found.stroke, alone["stroke"], rtol=2e-3)


def test_more_harmonics_than_can_be_computed_leave_no_linear_stroke_and_say_so():
    """A sine has two harmonics at any frequency, a square with jumps too many in a period of 1e7 oscillations."""
    model = ConeModel(damping_ratio=0.2, voltage=1e-4, voltage_bias=0.6, rest_height=0.8, film="taut")
    slow = model.replace(waveform="square", rise=0.0)
    assert np.isfinite(linear_response(model, np.array([1e-7])).stroke).all()
    stroke = linear_response(slow, np.array([1e-7, 1.0])).stroke
    assert np.isnan(stroke).tolist() == [True, False]
    of = module.quantity_of_stroke(slow.members(), stroke[None], np.array([[1e-7, 1.0]]))
    assert (of["quantity"], of["nan_means"]) == ("length", module.TOO_MANY)
    lost = np.array([[np.nan, 0.5]])  # at a frequency at which there are few harmonics
    assert module.quantity_of_stroke(model.members(), lost, np.array([[1.0, 2.0]]))["nan_means"] == module.UNSTABLE
    both = module.quantity_of_stroke(slow.members(), np.array([[np.nan, np.nan]]), np.array([[1e-7, 1.0]]))
    assert both["nan_means"] == f"{module.UNSTABLE} or {module.TOO_MANY}"
    own = slow.replace(drive_frequency=[1e-7, 1.0]).members()
    assert module.quantity_of_stroke(own, np.array([np.nan, 0.5]))["nan_means"] == module.TOO_MANY
    assert module.quantity_of_stroke(own, np.array([0.25, 0.5]))["nan_means"] == "not applicable"


def test_members_and_frequencies_have_the_linear_stroke_that_each_has_alone():
    """Members and frequencies need different numbers of harmonics."""
    model = ConeModel(
        damping_ratio=[0.1, 0.3], voltage=0.1, voltage_bias=0.5, rest_height=0.8, waveform="square", film="taut",
        spring_stiffness=[1.0, 50.0],
    )  # fmt: skip
    grid = np.array([0.003, 0.05, 0.9])
    together = linear_response(model, grid)
    for member in range(2):
        alone = model.replace(damping_ratio=[0.1, 0.3][member], spring_stiffness=[1.0, 50.0][member])
        for k, omega in enumerate(grid):
            one = linear_response(alone, np.array([omega]))
            assert one.stroke[0] == together.stroke[member, k]
            np.testing.assert_array_equal(one.harmonics[:, 0], together.harmonics[member, :, k])


@pytest.mark.parametrize(
    "parts",
    [
        {"film": "taut", "filter_time": 0.4, "dielectric_share": 0.3, "dielectric_time": 2.0},
        {
            "film": "taut",
            "series_resistance": 0.2,
            "leakage_time": 5.0,
            "dielectric_share": 0.5,
            "dielectric_time": 3.0,
        },
        {"film": "taut", "dielectric_share": 0.3, "dielectric_time": 0.5},
        {"film": "taut", "circuit": "charge"},
        {
            "film": "wrinkling",
            "hoop_prestretch": 1.4,
            "series_resistance": 0.2,
            "leakage_time": 5.0,
        },
        {"film": "wrinkling", "hoop_prestretch": 1.4, "viscous_modulus_1": 0.5, "relaxation_time_1": 2.0},
    ],
    ids=["filter", "resistance", "late", "charge", "wrinkling", "creep"],
)
def test_the_linear_stroke_of_a_small_sine_is_that_of_the_transfer_function(parts):
    """Both linearise the same system, with all its states."""
    model = ConeModel(damping_ratio=0.2, voltage=1e-6, voltage_bias=0.5, rest_height=0.8, **parts)
    omega = np.array([0.05, 0.9, 1.6, 6.0])
    gain = np.abs(state_space(model).transfer(omega)[:, 0, 0])
    np.testing.assert_allclose(linear_response(model, omega).stroke, 2e-6 * gain, rtol=2e-4)


# --- states that move with the disc -----------------------------------------------------------------------------------

OMEGA = np.array([0.6, 1.2, 3.0])
WEAK = {"rest_height": 0.7, "damping_ratio": 0.1, "voltage": 1e-4, "voltage_bias": 0.5}


def test_linear_theory_has_the_films_own_dynamic_stiffness():
    """A branch g s/(1 + s) stiffens the film over the frequency; statics know only its slope at rest."""
    model = ConeModel(film=Lossy(), **WEAK)
    place, s = equilibrium_under_bias(model, 0.5), 1j * OMEGA
    settled = float(model.stiffness(place, 0.5))
    expected = 2.0 * place * 0.5 / (s * s + 0.2 * s + settled + BRANCH * s / (1.0 + s))
    found = linear_response(model, OMEGA).harmonics[0] / 1e-4
    np.testing.assert_allclose(found, expected, rtol=1e-7)
    np.testing.assert_allclose(small_signal_response(model, OMEGA)["gain"], np.abs(expected), rtol=1e-9)


def test_linear_theory_has_the_circuits_loaded_gain():
    """A resistance in front of a film that leaks: the film rests at v/(1 + rho q/tau) and the motion pumps charge."""
    rho, leak = 0.8, 1.0 / 20.0
    model = ConeModel(circuit=SeriesResistor(), series_resistance=rho, leakage_time=20.0, **WEAK)
    x = 0.5
    for _ in range(100):
        v = 0.5 / (1.0 + rho * leak * (1.0 + x * x))
        x = equilibrium_under_bias(model.replace(circuit="ideal"), v)
    s, q, stiffness = 1j * OMEGA, 1.0 + x * x, float(model.stiffness(x, v))
    y = s + leak
    loaded = (s * s + 0.2 * s + stiffness) * (1.0 + rho * q * y) + 4.0 * x * x * v * v * rho * y
    found = linear_response(model, OMEGA).harmonics[0] / 1e-4
    np.testing.assert_allclose(found, 2.0 * x * v / loaded, rtol=1e-7)
    np.testing.assert_allclose(small_signal_response(model, OMEGA)["gain"], np.abs(2.0 * x * v / loaded), rtol=1e-8)


def test_linear_theory_is_that_of_an_amplifier_within_its_limit_also_where_the_drive_reaches_it():
    """At rest no current flows, and so none is limited."""
    device = gelcone.find_device("biased-pump").replace(film="wrinkling", series_resistance="1 MOhm")
    strokes = [
        float(gelcone.settled(device.replace(current_limit=limit))["linear_stroke"])
        for limit in ("1 uA", "0.02 mA", "10 mA")
    ]
    assert strokes == pytest.approx([strokes[-1]] * 3, rel=1e-12)
    assert strokes[-1] > 1.0


def test_there_is_no_linear_response_about_an_unstable_equilibrium(monkeypatch):
    """Nor about one whose stiffness is 0."""
    members = ConeModel(damping_ratio=[0.1] * 3, voltage=0.1, voltage_bias=0.3, rest_height=0.4).members()
    stiffness = np.array([[2.0], [0.0], [-2.0]])
    real = module._equilibria
    monkeypatch.setattr(module, "_equilibria", lambda own, squares: (real(own, squares)[0], stiffness))
    found = module.linear_response(members, np.array([0.5]))
    assert np.isfinite(found.stroke).tolist() == [[True], [False], [False]]
    assert np.isfinite(found.harmonics[:, 0, 0]).tolist() == [True, False, False]
    harmonic = np.abs(found.harmonics[0, :, 0])
    assert found.stroke[0, 0] == pytest.approx(2.0 * harmonic[0], rel=2.0 * harmonic[1] / harmonic[0])


@pytest.mark.parametrize("more", [{"current_limit": 0.1}, {"current_limit": 0.1, "leakage_field": 0.4}, {}])
def test_a_bias_of_either_sign_has_one_response_through_a_limited_source(more):
    """A leaking film rests below its command, with a current within the limit."""
    given = {"rest_height": 0.8, "hoop_prestretch": 1.4, "damping_ratio": 0.25, "voltage": 0.02}
    model = ConeModel(**given, series_resistance=3.0, leakage_time=12.0, **more)
    up, down = (linear_response(model.replace(voltage_bias=bias), np.array([0.5, 1.0])) for bias in (0.5, -0.5))
    assert (up.stroke > 1e-3).all()
    np.testing.assert_allclose(down.stroke, up.stroke, rtol=1e-9)

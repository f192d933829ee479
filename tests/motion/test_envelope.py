"""Operating envelope: limits against independent routes."""

from __future__ import annotations

import importlib
import json
from types import SimpleNamespace

import numpy as np
import pytest

import gelcone
from gelcone.codes import Outcome, Regime
from gelcone.devices.scales import MEASURES
from gelcone.errors import InputError
from gelcone.motion import driven as driven_module
from gelcone.motion import plane as plane_module
from gelcone.motion.attractor import search as search_module
from gelcone.motion.attractor.classification import Evidence
from gelcone.motion.creep import Holding, _Ramp, thresholds
from gelcone.motion.driven import driven
from gelcone.motion.envelope import envelope
from gelcone.motion.floquet import onset_voltage
from gelcone.motion.flow import integrate
from gelcone.motion.plane import DRIVEN_LIMITS, SPAN, TOO_CLOSE, YIELDS, DriveShape, Plane
from gelcone.motion.response import simulate
from gelcone.motion.static_limits import STATIC_LIMITS
from gelcone.motion.validity import unknown
from gelcone.physics.model import ConeModel
from tests.motion.planes import BEAM, FLAT, LOW, OMEGAS, TAUT, VOLTS, WRINKLING, Curve, straight
from tests.recorded import numbers, record
from tests.toys import FilteredVoltage, ThreeHarmonics

envelope_module = importlib.import_module("gelcone.motion.envelope")


@pytest.fixture(scope="module")
def taut():
    return envelope(
        TAUT.replace(dielectric_strength=1.2), peaks=np.linspace(0.2, 2.0, 8), frequencies=[0.02, 0.5], margin=0.25
    )


@pytest.fixture(scope="module")
def flat():
    return envelope(FLAT, peaks=np.linspace(0.2, 2.4, 5), frequencies=[0.4, 0.9])


def test_breakdown_and_slack_are_where_the_formulas_pass_zero(taut):
    limits = dict(zip(STATIC_LIMITS, taut["static_limit_voltage"].values, strict=True))
    x = np.interp(limits["dielectric breakdown"], taut["constant_voltage"], taut["static_displacement"])
    assert limits["dielectric breakdown"] * np.sqrt(1 + x * x) == pytest.approx(1.2, rel=1e-4)
    v = limits["hoop slack"]
    x = np.interp(v, taut["constant_voltage"], taut["static_displacement"])
    q, lm, lh = 1 + x * x, 1.2, 1.5
    e = lm**2 * q + lh**2 + 1 / (lm**2 * lh**2 * q) - 3
    assert (lh**2 - 1 / (lm**2 * lh**2 * q)) / (1 - e / 50) - v * v * q == pytest.approx(0.0, abs=1e-3)


def test_a_slow_drive_meets_the_quasi_static_breakdown(taut):
    row = DRIVEN_LIMITS.index("dielectric breakdown")
    static = float(taut["static_limit_voltage"][STATIC_LIMITS.index("dielectric breakdown")])
    assert float(taut["limit_low"][row, 0]) <= float(taut["limit_high"][row, 0])
    assert float(taut["limit_high"][row, 0]) == pytest.approx(static, rel=0.03)


def test_the_window_keeps_the_margin_to_the_lowest_limit(taut):
    low = np.fmin(taut["limit_low"].min("driven_limit"), float(taut["static_limit_voltage"].min()))
    np.testing.assert_allclose(taut["recommended_peak"], 0.75 * np.minimum(low, 2.0))


def test_the_pitchfork_is_met_by_a_slow_ramp_in_time(flat):
    pitchfork, pull_in = (float(flat["static_limit_voltage"][STATIC_LIMITS.index(k)]) for k in ("pitchfork", "pull-in"))
    assert pull_in > 1.1 * pitchfork  # the disc rises from it gradually
    levels = pitchfork * np.array([0.97, 1.03])
    constant = FLAT.replace(voltage=0.0, voltage_bias=levels)
    end = np.abs(integrate(constant, (1e-3, 0.0), [2000.0]).states[:, 0, 0])
    assert end[0] < 1e-6
    assert end[1] > 0.05


def test_onset_of_rest_separates_decay_from_growth(flat):
    row = DRIVEN_LIMITS.index("onset of rest")
    for column, omega in enumerate(flat["drive_frequency"].values):
        onset = float(flat["limit_low"][row, column])
        if not np.isfinite(onset):
            continue
        model = FLAT.replace(drive_frequency=omega, voltage=onset * np.array([0.99, 1.01]))
        end = np.abs(integrate(model, (1e-6, 0.0), [200 * 2 * np.pi / omega]).states[:, 0]).max(axis=1)
        assert end[0] < 1e-6 < end[1]


def test_in_the_window_the_source_gives_what_the_damper_takes(taut):
    peak = taut["recommended_peak"].values
    model = TAUT.replace(drive_frequency=taut["drive_frequency"].values, voltage=peak / 2, voltage_bias=peak / 2)
    periods = 400
    settled = integrate(model, (0.5, 0.0), model.drive_period[:, None] * periods).states[:, -1]
    run = simulate(model, settled, periods=1)
    given = np.diff(run["supplied_energy"].values[:, [0, -1]])[:, 0]
    taken = np.diff(run["dissipated_energy"].values[:, [0, -1]])[:, 0]
    np.testing.assert_allclose(given, taken, rtol=1e-6)
    np.testing.assert_allclose(taut["window_power"], given / model.drive_period, rtol=1e-6)
    np.testing.assert_allclose(taut["window_stroke"], np.ptp(run["displacement"].values, axis=1), rtol=1e-3)


def test_a_motionless_film_is_a_capacitor_that_takes_no_power(flat):
    peak, omega = flat["recommended_peak"].values, flat["drive_frequency"].values
    assert (flat["window_regime"] == Regime.REST).all()
    np.testing.assert_allclose(flat["window_power"], 0.0, atol=1e-9)
    # v sin(omega t) across the capacitance 1: root mean squares v/sqrt 2 and v omega/sqrt 2
    np.testing.assert_allclose(flat["window_apparent_power"], 0.5 * peak**2 * omega, rtol=1e-2)


def test_at_the_edge_of_the_window_no_limit_is_met(taut):
    drive = DriveShape.of(TAUT)
    plane = Plane(TAUT.replace(dielectric_strength=1.2), drive, float(taut["rest_displacement"]), None)
    edge = plane.examine(taut["drive_frequency"].values, taut["recommended_peak"].values)
    for name in DRIVEN_LIMITS[:-1]:
        assert (edge[name] == 0.0).all(), name


def test_a_film_that_pulls_in_meets_that_limit_and_no_other():
    device = gelcone.find_device("biased-pump")
    model, rest = device.to_model(), device.initial_state()[0]
    peaks = np.array([1860.0, 1970.0]) / device.scales.voltage
    found = Plane(model, DriveShape.of(model), rest, None).examine(np.full(2, float(model.drive_frequency)), peaks)
    assert found["pull-in"].tolist() == [0.0, 1.0]
    for name in DRIVEN_LIMITS[1:-1]:
        assert found[name].tolist() == [0.0, 0.0], name


def test_default_frequencies_hold_the_first_resonances_and_the_models_own():
    plane = Plane(TAUT, DriveShape.of(TAUT), 0.3, None)
    natural = plane.natural_frequency()
    found = plane.default_frequencies()
    for wanted in (float(TAUT.drive_frequency), 0.5 * natural, natural, 2.0 * natural):
        assert np.abs(found / wanted - 1.0).min() < 0.03
    assert (np.diff(found) > 0.0).all()
    assert found[-1] <= 3.0 * natural


@pytest.mark.parametrize("stiffness", [0.05, 30.0])
def test_default_frequencies_are_as_close_for_slow_and_for_fast_discs(stiffness):
    """Over their span none is missing and none is doubled, both by its share of the frequency."""
    model = TAUT.replace(spring_stiffness=stiffness)
    plane = Plane(model, DriveShape.of(model), 0.3, None)
    found, span = plane.default_frequencies(), plane.natural_frequency() * np.geomspace(*SPAN)
    inside = span[1:-1]
    assert np.abs(found[:, None] / inside - 1.0).min(axis=0).max() <= 1.01 * TOO_CLOSE
    assert (np.diff(found) / found[:-1]).min() > 0.99 * TOO_CLOSE


def test_frequencies_are_added_where_the_lowest_limit_falls_steeply():
    omegas, volts = np.array([1.3, 1.7, 2.4]), np.array([0.6, 1.2])
    taut = FLAT.replace(damping_ratio=0.03, spring_stiffness=1.0, meridional_prestretch=1.5, hoop_prestretch=1.5)
    plane = Plane(taut, DriveShape(1.0, 0.0), 0.0, None)
    found = driven(plane, omegas, volts, refine=True, progress=lambda share: None)
    assert found["frequency"].size > omegas.size
    assert (np.diff(found["frequency"]) > 0.0).all()
    assert found["low"].shape == (found["frequency"].size, len(DRIVEN_LIMITS))
    onset = found["low"][:, -1]
    for omega, low in zip(found["frequency"], onset, strict=True):
        alone = onset_voltage(plane.model.replace(drive_frequency=omega), highest=1.2)["onset_voltage"]
        assert low == pytest.approx(float(alone.fillna(np.inf)), rel=1e-9)


def test_without_a_dielectric_strength_breakdown_is_unknown_not_skipped(flat):
    row = DRIVEN_LIMITS.index("dielectric breakdown")
    assert np.isnan(flat["static_limit_voltage"][STATIC_LIMITS.index("dielectric breakdown")])
    assert np.isnan(flat["limit_low"][row]).all()


@pytest.mark.parametrize(
    ("model", "options", "message"),
    [
        (ConeModel(voltage=[1.0, 2.0]), {}, "envelope: takes one actuator, not an ensemble"),
        (ConeModel(voltage=0.0), {}, "amplitude or a bias"),
        (ConeModel(), {"margin": 1.0}, "margin = 1"),
        (ConeModel(), {"peaks": [2.0, 1.0]}, "peaks"),
        (ConeModel(), {"frequencies": [1.0]}, "frequencies"),
    ],
)
def test_bad_input_is_refused(model, options, message):
    with pytest.raises(InputError, match=message):
        envelope(model, **options)


def test_under_a_sine_the_natural_frequency_is_that_of_its_root_mean_square():
    """A flat film, whose stiffness falls by the mean of v^2: half of the square of the amplitude."""
    plane = Plane(FLAT, DriveShape(1.0, 0.0), 0.0, None)
    at_rest = float(FLAT.stiffness(0.0))
    for peak in (0.0, 0.4, 0.6):
        assert plane.natural_frequency(peak) == pytest.approx(np.sqrt(at_rest - 0.5 * peak**2), rel=1e-12)
    biased = Plane(FLAT, DriveShape(0.0, 1.0), 0.0, None)
    assert biased.natural_frequency(0.4) == pytest.approx(np.sqrt(at_rest - 0.4**2), rel=1e-12)


@pytest.mark.parametrize("bias", [0.0, 0.3])
@pytest.mark.parametrize("waveform", ["triangle", ThreeHarmonics()])
def test_peak_and_mean_square_are_those_of_the_waveform(waveform, bias):
    """Against the voltage of a million times of a period."""
    model = FLAT.replace(waveform=waveform, voltage=0.8, voltage_bias=bias)
    drive = model.system.waveform.voltage(2.0 * np.pi * np.arange(10**6) / 10**6, model.own_numbers)
    peak = np.abs(drive).max()
    plane = Plane(model, DriveShape.of(model), 0.0, None)
    assert model.peak_voltage == pytest.approx(peak, rel=1e-4)
    assert plane.natural_frequency(peak / 2) == pytest.approx(
        np.sqrt(float(FLAT.stiffness(0.0)) - np.mean(drive**2) / 4), rel=1e-4
    )
    at = plane.at(np.array([1.0]), np.array([2 * peak]))
    assert (float(at.voltage[0]), float(at.voltage_bias[0])) == pytest.approx((1.6, 2 * bias), rel=1e-4)


def test_the_onset_of_rest_is_a_peak_voltage_of_the_waveform(flat):
    """The onset is an amplitude; the peak of three harmonics lies above it."""
    model = FLAT.replace(waveform=ThreeHarmonics(), drive_frequency=0.9)
    shape = DriveShape.of(model)
    assert shape.amplitude < 0.97
    plane = Plane(model, shape, 0.0, None)
    onset = float(onset_voltage(model, highest=2.4)["onset_voltage"])
    assert driven_module._onset(plane, np.array([0.9]), 2.4)[0] == pytest.approx(onset / shape.amplitude, rel=1e-9)


def test_a_motion_that_leaves_the_domain_meets_every_limit_of_the_film():
    free = ConeModel(law="neo-hookean", damping_ratio=0.1, voltage=8.0, meridional_prestretch=1.2, hoop_prestretch=1.5)
    free = free.replace(dielectric_strength=1e12)
    plane = Plane(free, DriveShape.of(free), 0.0, None)
    found = plane.examine(np.array([1.0, 1.0]), np.array([0.1, 8.0]))
    assert found["outcome"].tolist()[0] == 0.0
    assert found["outcome"].tolist()[1] != 0.0
    for name in ("dielectric breakdown", "hoop slack", "meridional slack", "stretch limit"):
        assert found[name].tolist() == [0.0, 1.0], name
    assert np.isfinite(found["stroke"][0])
    assert np.isnan(found["stroke"][1])


def test_a_motion_that_could_not_be_followed_meets_every_limit(monkeypatch):
    """Whatever it would be from its start: nothing is known of it, so nothing counts as safe."""

    def out_of_steps(members, states, **options):
        evidence = Evidence.blank(members.size)
        evidence.final[:] = states
        evidence.outcome[1] = Outcome.STEP_LIMIT
        return evidence

    monkeypatch.setattr(plane_module, "classify", out_of_steps)
    strong = TAUT.replace(dielectric_strength=1e6)
    found = Plane(strong, DriveShape.of(strong), 0.3, None).examine(np.array([1.0, 1.0]), np.array([0.1, 0.1]))
    for name in ("dielectric breakdown", "hoop slack", "meridional slack", "stretch limit"):
        assert found[name].tolist() == [0.0, 1.0], name
    assert np.isnan(found["power"]).tolist() == [False, True]


def test_limits_are_narrowed_to_a_64th_of_the_peaks_apart(taut):
    width = (taut["limit_high"] - taut["limit_low"]).values[:-1]
    found = width[np.isfinite(width) & (width > 0.0)]
    assert found.size
    apart = np.diff(np.linspace(0.2, 2.0, 8))[0]
    first = 0.2  # the lowest peak lies that far above no voltage
    np.testing.assert_allclose(np.minimum(np.abs(found - apart / 64), np.abs(found - first / 64)), 0.0, atol=1e-12)


def test_the_onset_of_rest_is_as_wide_as_it_is_known(flat):
    row = DRIVEN_LIMITS.index("onset of rest")
    found = onset_voltage(FLAT.replace(drive_frequency=flat["drive_frequency"].values), highest=2.4)
    reached = np.isfinite(found["onset_voltage"].values)
    assert reached.any()
    assert (found["onset_error"].values[reached] > 0.0).all()
    np.testing.assert_array_equal(flat["limit_low"].values[row, reached], found["onset_voltage"].values[reached])
    high = (found["onset_voltage"] + found["onset_error"]).values
    np.testing.assert_array_equal(flat["limit_high"].values[row, reached], high[reached])


@pytest.mark.parametrize("level", [0.3, 0.4])
def test_pull_in_is_that_of_the_membrane_where_there_is_one(monkeypatch, level):
    """Of a membrane that pulls in at one voltage at all displacements; the cone's comes far later."""
    curve = Curve((0.0, 2.0), (level, level), 0.01)
    monkeypatch.setattr(envelope_module, "membrane_pull_in", lambda model: curve)
    found = envelope(WRINKLING, peaks=np.linspace(0.1, 0.5, 5), frequencies=[0.1, 0.2])
    assert (found.attrs["pull_in_of"], found.attrs["pull_in_error"]) == ("membrane", 0.01)
    static = float(found["static_limit_voltage"][STATIC_LIMITS.index("pull-in")])
    assert static == pytest.approx(level, abs=2e-3)
    row = DRIVEN_LIMITS.index("pull-in")
    low, high = (found[name].values[row] for name in ("limit_low", "limit_high"))
    assert (low <= level * 1.001).all()
    assert (high >= level * 0.98).all()
    assert (found["recommended_peak"].values <= 0.8 * level + 1e-9).all()


def test_without_a_membrane_pull_in_is_that_of_the_cone(monkeypatch):
    monkeypatch.setattr(envelope_module, "membrane_pull_in", lambda model: None)
    found = envelope(WRINKLING, peaks=np.linspace(0.1, 0.5, 5), frequencies=[0.1, 0.2])
    assert (found.attrs["pull_in_of"], found.attrs["pull_in_error"]) == ("cone", 0.0)
    assert float(found["static_limit_voltage"][STATIC_LIMITS.index("pull-in")]) > 0.5


def test_between_two_frequencies_the_lowest_limit_is_known_to_one_percent():
    """Or it jumps between two that are 0.2 % apart; a limit of the plane alone tells at frequencies of its own."""
    plane = Plane.of(TAUT.replace(dielectric_strength=1.2), None)
    volts = np.linspace(0.3, 1.5, 5)
    found = driven(plane, np.array([0.4, 0.9]), volts, refine=True, progress=lambda share: None)
    known, lowest = found["frequency"], np.fmin.reduce(found["low"], axis=1)
    assert known.size > 4
    between = np.geomspace(0.43, 0.87, 4)
    alone = driven(plane, between, volts, refine=False, progress=lambda share: None)
    low, high = (np.fmin.reduce(alone[end], axis=1) for end in ("low", "high"))
    line = np.interp(np.log(between), np.log(known), lowest)
    resolved = (volts[1] - volts[0]) / 64.0
    assert (line * 0.985 - resolved < high).all()
    assert (line * 1.015 + resolved > low).all()
    assert np.abs(np.interp(between, [0.4, 0.9], lowest[[0, -1]]) / low - 1.0).max() > 0.02  # two alone do not tell


def test_the_transient_of_switching_on_counts_where_limits_hold_from_rest():
    """A bias that is switched on lifts the disc twice as high as it holds it."""
    model = TAUT.replace(dielectric_strength=1.1, voltage=0.03, voltage_bias=0.57, damping_ratio=0.05)
    low = {}
    for start in ("rest", "settled", "both"):
        plane = Plane.of(model, None, None, start)
        found = driven(plane, np.array([0.3, 0.4]), np.array([0.4, 1.0]), refine=False, progress=None)
        low[start] = found["low"][:, DRIVEN_LIMITS.index("dielectric breakdown")]
    assert (low["rest"] < 0.98 * low["settled"]).all()
    np.testing.assert_allclose(low["both"], low["rest"], atol=0.02)
    peak = 0.5 * (low["rest"][0] + low["settled"][0])
    drive = model.replace(voltage=0.05 * peak, voltage_bias=0.95 * peak, drive_frequency=0.3)
    rest = plane.rest
    assert float(simulate(drive, (rest, 0.0), periods=12)["validity_breakdown"]) > 0.0
    assert float(gelcone.regime(drive, (rest, 0.0))["validity_breakdown"]) == 0.0


def test_what_was_not_searched_is_not_called_beyond_a_limit():
    found = envelope(TAUT.replace(dielectric_strength=9.0), peaks=[0.1, 0.2], frequencies=[0.5, 2.0])
    own = importlib.import_module("gelcone.analyses.envelope")._own_line(found)
    assert own == "its drive, 0.6 at 1: above the voltages examined, up to 0.2, at which no limit was met"


def test_limits_hold_from_what_is_known():
    with pytest.raises(InputError, match="'start' is not a motion that limits hold from; known: rest, settled, both"):
        envelope(TAUT, limits_from="start")


def test_every_limit_counts_the_transient_from_rest(monkeypatch):
    names = ("hoop_slack", "meridional_slack", "near_limit", "breakdown", "beyond_membrane")
    quiet = {name: np.zeros(1) for name in (*names, *plane_module.YIELDS)}
    states = iter([quiet, quiet | {name: np.ones(1) for name in names}] * 2)
    monkeypatch.setattr(Plane, "_observe", lambda *arguments, **options: next(states))
    for start, met in (("rest", 1.0), ("settled", 0.0)):
        plane = Plane.of(TAUT.replace(dielectric_strength=9.0), None, None, start)
        found = plane.examine(np.array([0.5]), np.array([0.1]))
        for name in ("hoop slack", "meridional slack", "stretch limit", "dielectric breakdown", "pull-in"):
            assert found[name].tolist() == [met], (start, name)


@pytest.mark.parametrize(("time", "lasts"), [(30.0, 120.0), (500.0, 40.0)])
def test_the_transient_from_rest_lasts_as_long_as_that_of_slow_states_or_their_drift_is_examined(
    monkeypatch, time, lasts
):
    lasted, filtered = [], []

    def look(plane, members, states, lasts, yields):
        lasted.append(np.max(lasts))
        filtered.append(np.abs(states[:, 2]).max())
        names = ("hoop_slack", "meridional_slack", "near_limit", "breakdown", "beyond_membrane")
        return {name: np.zeros(members.size) for name in (*names, *plane_module.YIELDS)}

    monkeypatch.setattr(Plane, "_observe", look)
    slow = TAUT.replace(circuit=FilteredVoltage(), filter_time=time)
    Plane.of(slow, None).examine(np.array([0.5]), np.array([0.1]))
    assert max(lasted) == lasts
    settled, start, *course = filtered
    assert start == 0.0 < settled
    assert bool(course) == (time > 100.0)
    assert all(values > 0.5 * settled for values in course)


def test_the_transient_from_rest_counts_until_it_has_decayed():
    """Lightly damped and driven next to resonance, the motion beats: it is largest after more than 12 periods."""
    model = TAUT.replace(damping_ratio=0.01, voltage=0.3, voltage_bias=0.3, dielectric_strength=0.7)
    plane = Plane.of(model, None)
    omega = 0.975 * plane.natural_frequency(0.45)
    found = envelope(model, peaks=np.linspace(0.05, 0.75, 8), frequencies=[omega, 1.2 * omega])
    low, high = (float(found[end].sel(driven_limit="dielectric breakdown")[0]) for end in ("limit_low", "limit_high"))
    share = {}
    for peak in (0.999 * low, 1.001 * high):
        drive = plane.at(np.array([omega]), np.array([peak]))
        for periods in (12, 80):
            share[peak, periods] = simulate(drive, (plane.rest + 1e-3, 0.0), periods=periods)["validity_breakdown"]
    below, above = (0.999 * low, 80), (1.001 * high, 80)
    assert float(share[below][0]) == 0.0 < float(share[above][0])
    assert float(share[1.001 * high, 12][0]) == 0.0


def test_a_pair_is_the_same_whatever_is_examined_with_it():
    plane = Plane.of(TAUT.replace(dielectric_strength=1.2), None)
    omegas, peaks = np.array([0.1, 0.5, 3.0]), np.array([0.3, 0.9, 0.5])
    together = plane.examine(omegas, peaks)
    for k in range(3):
        alone = plane.examine(omegas[k : k + 1], peaks[k : k + 1])
        for name, values in alone.items():
            np.testing.assert_array_equal(values[0], together[name][k], err_msg=name)


def test_nothing_is_examined_far_above_pull_in_and_kicks_are_tried_at_default_frequencies(monkeypatch):
    curve = Curve((0.0, 2.0), (0.3, 0.3), 0.01)
    monkeypatch.setattr(plane_module, "SPAN", (*SPAN[:2], 5))  # fewer frequencies
    monkeypatch.setattr(envelope_module, "membrane_pull_in", lambda model: curve)
    found = envelope(WRINKLING, peaks=[0.05, 0.2, 0.35, 0.7, 1.0])
    assert np.isnan(found["regime"].values[:, found["peak_voltage"] > 0.4]).all()
    assert np.isfinite(found["regime"].values[:, 0]).all()
    kicked = np.isfinite(found["kick_tried"].values)
    given = Plane.of(WRINKLING, None, curve).default_frequencies()
    assert set(found["drive_frequency"].values[kicked]) == set(given)


def test_a_film_that_creeps_has_both_thresholds():
    """Those of `gelcone.limits`; an elastic film has one."""
    device = gelcone.find_device("biased-pump").replace(
        {"film": "wrinkling", "material.viscous_modulus_1": "4 kPa", "material.relaxation_time_1": "2 s"}
    )
    found = thresholds(device.to_model(), 0.5)
    both = [float(gelcone.limits(device, at_once=at_once)["pull_in_voltage"]) for at_once in (False, True)]
    assert [
        found[name][1] * device.scales.voltage
        for name in ("long_term_pull_in_voltage", "instantaneous_pull_in_voltage")
    ] == pytest.approx(both, rel=1e-12)
    assert thresholds(gelcone.ConeModel(), 0.5) == {}


def test_a_film_that_creeps_slowly_is_not_waited_for_and_has_the_same_limits(monkeypatch):
    """Raised, it localises late; the limits of a slow branch do not depend on its relaxation time."""
    model = ConeModel(film="wrinkling", spring_stiffness=3.0, rest_height=1.4, damping_ratio=0.3).replace(
        voltage=0.1, voltage_bias=0.5, viscous_modulus_1=0.5, relaxation_time_1=300.0
    )
    omegas, volts = np.array([0.5]), np.array([0.6, 0.7])

    def limits(time: float) -> list[list[float]]:
        plane = Plane.of(model.replace(relaxation_time_1=time), None)
        return driven(plane, omegas, volts, refine=False, progress=None)["low"].tolist()

    drifted = limits(300.0)
    np.testing.assert_array_equal(limits(1e6), drifted)
    assert drifted[0][0] == pytest.approx(0.645, abs=0.005)
    monkeypatch.setattr(search_module, "SLOW", np.inf)
    np.testing.assert_array_equal(limits(300.0), drifted)


def test_a_voltage_that_is_held_for_a_time_is_that_of_creep():
    """Both are asked for the same time, and a run of simulate at the limit comes through it, and 1 % above does not."""
    found = envelope(BEAM, peaks=[0.6, 0.8], frequencies=[0.5, 0.6], duration=60.0)
    held = gelcone.creep(BEAM, duration=60.0)
    for name in ("holding_voltage", "long_term_pull_in_voltage", "instantaneous_pull_in_voltage"):
        assert float(found[name]) == float(held[name])
    limits = dict(zip(STATIC_LIMITS, found["static_limit_voltage"].values, strict=True))
    highest = float(held["holding_voltage"])
    assert limits["pull-in"] == highest
    assert 1.02 * float(held["long_term_pull_in_voltage"]) < highest < float(held["instantaneous_pull_in_voltage"])
    assert float(found["recommended_constant"]) == pytest.approx(0.8 * min(v for v in limits.values() if v == v))
    begun = gelcone.creep(BEAM, [highest], duration=60.0)["initial_displacement"].item()
    runs = [
        simulate(BEAM.replace(voltage=0.0, voltage_bias=share * highest), (begun, 0.0), times=[60.0])
        for share in (1.0, 1.01)
    ]
    ends = [float(run["displacement"][-1]) for run in runs]
    assert float(found["held_displacement"][-1]) == pytest.approx(ends[0], rel=1e-9)
    halfway = np.mean(_Ramp(BEAM).lost[2:])
    assert ends[0] < halfway < ends[1]


@pytest.mark.parametrize(
    ("model", "message"),
    [
        (TAUT, "duration: the film has no branch that relaxes.*or leave it out"),
        (BEAM.replace(second_film="taut", second_drive="opposite"), "duration: films in opposite phase"),
    ],
)
def test_what_holds_no_voltage_takes_no_duration(monkeypatch, model, message):
    """Before any work."""
    monkeypatch.delattr(envelope_module, "plane_of")
    with pytest.raises(InputError, match=message):
        envelope(model, peaks=[0.2, 0.3], frequencies=[0.5, 0.6], duration=10.0)
    with pytest.raises(InputError, match="duration = -1: must be positive"):
        envelope(BEAM, peaks=[0.2, 0.3], frequencies=[0.5, 0.6], duration=-1.0)


def test_no_constant_voltage_is_recommended_above_those_that_were_held():
    """A slow branch carries such a film past the pull-in of the relaxed membrane, up to which voltages are held."""
    branch = {"film": gelcone.TautCone(branches=1), "viscous_modulus_1": 3.0, "relaxation_time_1": 500.0}
    model = ConeModel(**branch, prestretch=1.2, radius_ratio=0.2, rest_height=0.8, damping_ratio=0.3, voltage=0.3)
    found = envelope(model, peaks=[0.2, 0.3], frequencies=[0.5, 0.6], duration=1.0, margin=0.2)
    assert not np.isfinite(found["static_limit_voltage"]).any()
    assert float(found["recommended_constant"]) == pytest.approx(0.8 * float(found["held_voltage"].max()))


def test_a_film_that_leaks_and_creeps_warms_as_its_settled_motion_does():
    model = TAUT.replace(leakage_time=20.0, film=gelcone.TautCone(branches=1), relaxation_time_1=2.0)
    found = envelope(model, peaks=[0.4, 0.6], frequencies=[0.5, 0.9])
    motion = gelcone.settled(model.replace(drive_frequency=0.9), (float(found["rest_displacement"]), 0.0))
    assert float(motion["heating"]) > 0.005
    assert float(found["driven_heating"][1, 1]) == pytest.approx(float(motion["heating"]), rel=1e-6)
    assert float(found["driven_power"][1, 1]) == pytest.approx(float(motion["power"]), rel=1e-6)
    q = 1.0 + found["static_displacement"] ** 2
    np.testing.assert_allclose(found["static_heating"], found["constant_voltage"] ** 2 * q / 20.0, rtol=1e-12)
    assert (found["window_heating"] > 0.0).all()
    still = TAUT.replace(film=gelcone.TautCone(branches=1), relaxation_time_1=2.0)
    creeping = envelope(still, peaks=[0.4, 0.6], frequencies=[0.5, 0.9])
    assert "static_heating" not in creeping
    assert (creeping["driven_heating"] > 0.0).all()


def test_an_excess_between_samples_is_seen():
    """By the parabola through the largest sample and its neighbours; nothing is known behind the end of a run."""
    t = np.linspace(0.0, 2.0 * np.pi, 33)
    excess = np.stack([np.cos(t - 1.234) - 0.9999, np.cos(t - 1.234) - 1.001, np.where(t < 3.0, -1.0, np.nan)])
    np.testing.assert_array_equal(plane_module._ever(excess), [1.0, 0.0, 0.0])
    assert (excess[0] < 0.0).all()


def test_the_recommended_peak_is_below_the_lowest_known_limit_and_the_peaks_examined():
    low = np.array([[0.8, np.nan], [np.nan, np.nan], [np.inf, 5.0], [0.0, 2.0]])
    found = envelope_module.recommended_peaks(low, 1.5, np.array([0.1, 9.0]), 0.25)
    np.testing.assert_allclose(found, 0.75 * np.array([0.8, 1.5, 1.5, 0.0]))
    np.testing.assert_allclose(envelope_module.recommended_peaks(low, 9.0, np.array([0.1, 0.4])), [0.32] * 3 + [0.0])


@pytest.fixture
def made_up(monkeypatch):
    """An envelope of `Straight`, at four frequencies of which one was added, and what its parts were asked for."""
    asked = {}

    def limits(plane, omegas, volts, **options):
        asked["driven"] = omegas, volts, options
        table = {name: 100.0 * k + OMEGAS[:, None] + VOLTS for k, name in enumerate((*YIELDS, "regime", "outcome"))}
        return table | {"low": LOW, "high": LOW + 0.01, "frequency": OMEGAS}

    def others(members, start, *, threads, progress):
        asked["others"] = members, start
        each = np.array([[1.0, 2.0], [3.0, np.nan]]) if members.size == 2 else np.zeros((0, 2))
        kinds = ("stroke", "lowest", "highest", "period", "regime", "outcome", "motion_kick_low", "motion_kick_high")
        found = {name: each + 10.0 * k for k, name in enumerate(kinds)}
        found |= {name: k + each[:, 0] for k, name in enumerate(("motions", "kick_low", "kick_high", "kick_tried"))}
        return found | {"validity": np.arange(each.size)[:, None].reshape(*each.shape, 1) + unknown(1) * 0.0}

    monkeypatch.setattr(envelope_module, "plane_of", lambda model, threads, from_="rest": straight(model, jump=1.2))
    monkeypatch.setattr(envelope_module, "driven", limits)
    monkeypatch.setattr(envelope_module, "coexisting", others)
    return asked


def test_an_envelope_says_of_each_number_what_was_found(made_up):
    found = envelope(TAUT, peaks=VOLTS, frequencies=OMEGAS[[0, 1, 3]], margin=0.25)
    omegas, volts, options = made_up["driven"]
    np.testing.assert_array_equal(omegas, OMEGAS[[0, 1, 3]])
    np.testing.assert_array_equal(volts, VOLTS)
    static = found["static_limit_voltage"].values
    lowest = np.nanmin(static)
    assert (options["ceiling"], options["pull_in"], options["refine"]) == (lowest, static[-1], False)
    for k, name in enumerate((*YIELDS, "regime", "outcome")):
        name = name if name in ("regime", "outcome") else f"driven_{name}"
        if name != "driven_heating":
            np.testing.assert_array_equal(found[name], 100.0 * k + OMEGAS[:, None] + VOLTS, err_msg=name)
    np.testing.assert_array_equal(found["limit_low"].T, LOW)
    np.testing.assert_array_equal(found["limit_high"].T, LOW + 0.01)
    assert found["first_limit"].values.tolist() == [3, 2, -1, 4]
    edge = 0.75 * np.minimum([0.5, 1.3, np.inf, 0.0], lowest)
    np.testing.assert_allclose(found["recommended_peak"], edge)
    assert float(found["recommended_constant"]) == pytest.approx(0.75 * min(lowest, 1.4))
    for k, name in enumerate((*YIELDS, "regime")):
        if f"window_{name}" in found:
            expected = np.where(edge > 0.0, 10.0 * k + OMEGAS + 0.1 * edge, np.nan)
            np.testing.assert_allclose(found[f"window_{name}"], expected, err_msg=name)
    assert float(found["rest_displacement"]) == 0.1
    assert (float(found["operating_peak_voltage"]), float(found["operating_frequency"])) == (0.6, 1.0)
    np.testing.assert_array_equal(found["peak_voltage"], VOLTS)
    pure = {"code", "count", "flag", "parameter", "share"}
    assert {own.attrs["quantity"] for own in found.variables.values()} <= {*MEASURES, *pure}


def test_coexisting_motions_are_sought_at_given_frequencies_with_a_window_alone(made_up):
    """From the envelope's rest, at the recommended peaks."""
    found = envelope(TAUT, peaks=VOLTS, frequencies=OMEGAS[[0, 1, 3]])
    members, start = made_up["others"]
    np.testing.assert_array_equal(members.number("drive_frequency"), OMEGAS[:2])
    np.testing.assert_allclose(2.0 * members.number("voltage"), found["recommended_peak"][:2])
    np.testing.assert_allclose(start, [[0.101, 0.0]] * 2)
    nothing = np.full((2, 2), np.nan)
    each = np.concatenate([[[1.0, 2.0], [3.0, np.nan]], nothing])
    kinds = ("stroke", "lowest", "highest", "period", "regime", "outcome", "kick_low", "kick_high")
    for k, name in enumerate(kinds):
        np.testing.assert_array_equal(found[f"motion_{name}"], each + 10.0 * k, err_msg=name)
    for k, name in enumerate(("coexisting_motions", "kick_low", "kick_high", "kick_tried")):
        np.testing.assert_array_equal(found[name], each[:, 0] + k, err_msg=name)


@pytest.mark.parametrize("duration", [None, 30.0])
def test_a_voltage_that_is_held_bounds_the_envelope_in_place_of_the_relaxed_film(monkeypatch, made_up, duration):
    """Levels are held up to the highest constant voltage examined; without a duration both thresholds are given."""
    limits = np.array([np.nan, 0.7, 0.9, np.inf, np.nan, 1.1])
    held = SimpleNamespace(levels=numbers(3, at=5.0), asked="the run")
    scalar = {
        name: ((), value, name, "voltage")
        for name, value in (("instantaneous_pull_in_voltage", 1.25), ("holding_voltage", 0.875))
    }
    planes = []

    def plane(model, threads, from_="rest"):
        planes.append((threads, from_))
        return straight(model, jump=1.2, threads=threads, limits_from=from_)

    monkeypatch.setattr(envelope_module, "plane_of", plane)
    asked = record(
        monkeypatch, envelope_module, check_holds=None, holding=held, held_limits=limits, _held_variables=scalar,
        thresholds={"instantaneous_pull_in_voltage": scalar["instantaneous_pull_in_voltage"]},
    )  # fmt: skip
    shares = []
    found = envelope(
        TAUT, peaks=VOLTS, frequencies=OMEGAS[[0, 1, 3]], limits_from="both", duration=duration, threads=5,
        progress=shares.append,
    )  # fmt: skip
    assert planes == [(5, "both")]
    options = {"margin": 0.2, "limits_from": "both", "duration": duration}
    assert json.loads(found.attrs["options"]) == options
    assert float(found["instantaneous_pull_in_voltage"]) == 1.25
    if duration is None:
        assert not asked["holding"]
        assert "held_voltage" not in found
        return
    (call,), (of_limits,) = asked["holding"], asked["held_limits"]
    assert (call["duration"], call["up_to"]) == (30.0, pytest.approx(1.212))
    assert (call["model"], call["count"], call["threads"]) == (TAUT, 32, 5)
    assert of_limits["held"] is asked["_held_variables"][0]["held"] is held
    assert of_limits["relaxed"][-1] == 1.2
    assert asked["_held_variables"][0]["duration"] == 30.0
    np.testing.assert_array_equal(found["static_limit_voltage"], limits)
    np.testing.assert_array_equal(found["held_voltage"], held.levels)
    assert float(found["holding_voltage"]) == 0.875
    assert (made_up["driven"][2]["ceiling"], made_up["driven"][2]["pull_in"]) == (0.7, 1.1)
    assert float(found["recommended_constant"]) == pytest.approx(0.8 * 0.7)


def test_a_constant_voltage_above_those_of_the_drive_is_recommended(made_up, monkeypatch):
    """A limit is met above the peaks of drives, of which 1.4 is the highest."""
    static = np.array([np.nan, 1.75, np.inf, np.inf, np.nan, np.inf])
    monkeypatch.setattr(envelope_module, "static_limits_of", lambda plane: static)
    found = envelope(TAUT, peaks=VOLTS, frequencies=OMEGAS[[0, 1, 3]], margin=0.25)
    assert float(found["recommended_constant"]) == pytest.approx(0.75 * 1.75)
    assert float(found["constant_voltage"][-1]) == 3.5


def test_what_is_held_ends_at_the_last_sample_for_the_duration():
    run = SimpleNamespace(states=numbers(3, 4, 2, at=2.0))
    held = Holding(1.8, numbers(3), (None, run), None, {"holding_voltage": ((), 0.5, "", "voltage")})
    found = envelope_module._held_variables(held, 30.0)
    np.testing.assert_array_equal(found["held_displacement"][1], numbers(3, 4, 2, at=2.0)[:, -1, 0])
    assert (found["holding_time"][1], found["holding_voltage"][1]) == (30.0, 0.5)


def test_kicks_are_tried_with_the_threads_of_the_plane(made_up, monkeypatch):
    asked = []
    others = envelope_module.coexisting
    monkeypatch.setattr(
        envelope_module, "coexisting",
        lambda members, start, **options: asked.append(options["threads"]) or others(members, start, **options),
    )  # fmt: skip
    plane = straight(TAUT)
    object.__setattr__(plane, "threads", 5)
    envelope_module._coexisting(plane, OMEGAS, np.full(4, 0.3), np.array([True, True, False, False]), None)
    assert asked == [5]


def test_thresholds_of_creep_of_films_in_opposite_phase_are_in_proportion_as_the_limits():
    """Without a membrane the long-time threshold is the quasi-static pull-in; creep has that at the own bias."""
    soft = {"law": "neo-hookean", "hoop_prestretch": 1.05, "spring_stiffness": 0.1, "second_film": "taut"}
    creeps = {
        "viscous_modulus_1": 0.5,
        "relaxation_time_1": 10.0,
        "second_drive": "opposite",
        "second_flat_height": 0.8,
    }
    model = gelcone.ConeModel(**soft, **creeps, damping_ratio=0.3, voltage=0.1, voltage_bias=0.3)
    found = gelcone.envelope(model, peaks=[0.1, 0.2], frequencies=[1.0, 1.1])
    late, at_once = (float(found[f"proportional_{name}_pull_in_voltage"]) for name in ("long_term", "instantaneous"))
    assert late == float(found["static_limit_voltage"][STATIC_LIMITS.index("pull-in")]) < at_once
    assert late > 1.01 * float(gelcone.limits(model)["pull_in_voltage"])
    assert "long_term_pull_in_voltage" not in found
    recommended = float(found["recommended_constant"])
    assert float(found["recommended_second_voltage"]) == pytest.approx(0.5 * recommended)
    meaning = "peak voltage at which the drive is held, bias and amplitude in proportion"
    assert found["constant_voltage"].attrs["long_name"] == meaning
    assert found["peak_voltage"].attrs["long_name"] == "peak voltage, bias and amplitude in proportion"
    draws = gelcone.draw({"spring_stiffness": gelcone.Uniform(0.1, 0.11)}, 2)
    drawn = gelcone.over_draws(model, draws, "envelope", peaks=[0.1, 0.2], frequencies=[1.0, 1.1])
    np.testing.assert_allclose(drawn["recommended_second_voltage"], 0.5 * drawn["recommended_constant"])
    for name in ("recommended_constant", "static_limit_voltage", "recommended_peak"):
        assert drawn[name].attrs["long_name"].endswith(", bias and amplitude in proportion")

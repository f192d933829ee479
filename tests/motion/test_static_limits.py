"""Limits on a slow ramp and of a voltage that is held: where formulas pass them, of made-up planes and of runs."""

from types import SimpleNamespace

import numpy as np
import pytest

import gelcone
from gelcone.motion import static_limits
from gelcone.motion.creep import Holding, holding
from gelcone.motion.plane import Plane
from gelcone.motion.static_limits import STATIC_LIMITS
from gelcone.physics.model import ConeModel
from tests.motion.planes import BEAM, FLAT, TAUT, WRINKLING, Curve, passes, straight


def test_the_membranes_static_pull_in_is_found_above_the_voltages_of_the_drive():
    membrane = Curve((0.0, 2.0), (0.45, 0.45), 0.01)
    limits = static_limits.static_limits_of(Plane.of(WRINKLING, None, membrane))
    assert limits[STATIC_LIMITS.index("pull-in")] == pytest.approx(0.45, abs=2e-3)


@pytest.mark.parametrize(("voltages", "expected"), [((np.inf, np.inf), np.inf), ((np.inf, 0.9), None)])
def test_a_membrane_that_pulls_in_at_no_voltage_or_only_higher_up_has_a_static_limit(voltages, expected):
    """Of a film with a low stretch limit, whose cone never pulls in."""
    model = WRINKLING.replace(stretch_limit=5.0, rest_height=0.8, spring_stiffness=0.5)
    membrane = Curve((0.0, 0.5, 2.0), (voltages[0], *voltages[1:] * 2), 0.01)
    limits = static_limits.static_limits_of(Plane.of(model, None, membrane))
    found = limits[STATIC_LIMITS.index("pull-in")]
    assert found == expected if expected is not None else 0.9 <= found <= 1.8


def test_the_bias_of_films_in_opposite_phase_rises_with_the_ramp():
    """At each constant peak both films have their share of it: the disc is where their forces balance there, whatever
    the device's own amplitude; breakdown is that of either film, the natural frequency that of small motions."""
    films = {"second_film": "taut", "second_drive": "opposite", "second_flat_height": 0.8, "second_prestretch": 1.3}
    films |= {"stretch_limit": 9.0, "dielectric_strength": 0.9}
    model = ConeModel(damping_ratio=0.1, voltage=0.1, voltage_bias=0.3, **films)
    plane = Plane.of(model, None)
    assert plane.shape.bias == pytest.approx(0.75)
    curves, limits = static_limits.static_curves(plane, 1.2), static_limits.static_limits_of(plane)
    twice = Plane.of(model.replace(voltage=0.2, voltage_bias=0.6), None)
    doubled, same = static_limits.static_curves(twice, 1.2), static_limits.static_limits_of(twice)
    for name, values in curves.items():
        np.testing.assert_allclose(values, doubled[name], rtol=1e-12, err_msg=name)
    np.testing.assert_array_equal(limits, same)
    peak, x, n = curves["constant_voltage"], curves["static_displacement"], model.own_numbers
    force, slope = model.system.force_under(x, [peak**2, (0.5 * peak) ** 2], n)
    np.testing.assert_allclose(force, 0.0, atol=1e-12)
    np.testing.assert_allclose(curves["natural_frequency"], np.sqrt(slope), rtol=1e-12)

    def fields(v):
        x = float(plane.ramp(np.array([v])).displacement[0])
        return max(v * np.sqrt(1.0 + x**2), 0.75 * v * np.sqrt(1.0 + (0.8 - x) ** 2))

    expected = passes(lambda v: fields(v) - 0.9, 0.1, 1.2)
    assert limits[STATIC_LIMITS.index("dielectric breakdown")] == pytest.approx(expected, rel=1e-6)
    level, omega = 0.4, plane.natural_frequency(0.4)
    drive = model.replace(voltage=0.25 * level, voltage_bias=0.75 * level, damping_ratio=1e-3, drive_frequency=omega)
    response = gelcone.motion.linear.linear_response(drive, omega * np.array([0.97, 1.0, 1.03])).stroke
    assert response.argmax() == 1


PAIR = ConeModel(
    damping_ratio=0.1, voltage=0.1, voltage_bias=0.3, second_film="taut", second_drive="opposite",
    second_flat_height=0.8,
)  # fmt: skip
"""Equal films; the first has up to 0.4."""


@pytest.mark.parametrize(("bias", "expected"), [(0.3, 0.45), (0.6, 0.6)])
def test_pull_in_at_the_own_bias_is_searched_from_there_up(bias, expected):
    """Below the bias the disc is at heights at which the membrane pulls in at any voltage."""
    model = PAIR.replace(voltage_bias=bias)
    low = float(gelcone.stroke_and_blocked_force(model, [0.5 * bias])["displacement"][0])
    membrane = Curve((0.0, low, low + 1e-9, 2.0), (0.0, 0.0, 0.45, 0.45), 0.01)
    plane = Plane.of(model, None, membrane)
    assert static_limits.membrane_pull_in_at_own_bias(plane) == pytest.approx(expected, rel=1e-6)
    assert static_limits.static_limits_of(plane)[-1] == pytest.approx(0.45, rel=1e-6)  # both rise from 0


def test_pull_in_of_a_membrane_is_unknown_without_one_and_where_the_way_to_the_bias_is_lost():
    soft = PAIR.replace(law="neo-hookean", hoop_prestretch=1.05, spring_stiffness=0.1)
    assert float(gelcone.limits(soft)["pull_in_voltage"]) < 2.0
    assert np.isnan(static_limits.membrane_pull_in_at_own_bias(Plane.of(soft, None)))
    lost = soft.replace(voltage_bias=3.0)
    assert np.isnan(gelcone.limits(lost)["pull_in_voltage"])
    assert np.isnan(static_limits.membrane_pull_in_at_own_bias(Plane.of(lost, None)))


def test_the_other_limits_of_a_held_voltage_are_those_of_the_run():
    """Breakdown between the thresholds, where the relaxed film has no state: that of the run at the end of the time."""
    model = BEAM.replace(dielectric_strength=1.45)
    plane = Plane.of(model, None)
    relaxed = static_limits.static_limits_of(plane)
    held = holding(model, 60.0, 1.0, count=32, threads=None)
    found = dict(zip(STATIC_LIMITS, static_limits.held_limits(plane, held, relaxed), strict=True))
    volts = found["dielectric breakdown"]
    assert np.isinf(relaxed[0]) or relaxed[0] < volts
    end = float(gelcone.creep(model, [volts], duration=60.0)["final_displacement"].item())
    assert (1.0 - 2e-4) * 1.45 < volts * np.sqrt(1.0 + end * end) <= 1.45
    assert found["pitchfork"] != found["pitchfork"]


def test_quasi_static_limits_are_where_stresses_field_and_stretch_pass_them():
    """Of a disc that rises in proportion to the voltage, by the formulas of the taut cone."""
    lm, lh, strength = 1.2, 1.5, 1.3
    plane = straight(TAUT.replace(dielectric_strength=strength, stretch_limit=6.0), jump=3.7)
    curves, limits = static_limits.static_curves(plane, 4.0), static_limits.static_limits_of(plane)

    def q(v):
        return 1.0 + (0.1 + 0.5 * v) ** 2

    def strain(v):
        return lm**2 * q(v) + lh**2 + 1.0 / (lm**2 * lh**2 * q(v)) - 3.0

    def slack(flat):
        return lambda v: v * v * q(v) - (flat(v) - 1.0 / (lm**2 * lh**2 * q(v))) / (1.0 - strain(v) / 6.0)

    expected = (
        passes(lambda v: v * np.sqrt(q(v)) - strength, 0.1, 3.0),
        passes(slack(lambda v: lh**2), 0.1, 3.0),
        passes(slack(lambda v: lm**2 * q(v)), 0.1, 3.0),
        passes(lambda v: strain(v) - 0.99 * 6.0, 0.1, 4.0),
        np.nan,
        3.7,
    )
    np.testing.assert_allclose(limits, expected, rtol=1e-4)
    levels = np.linspace(0.0, 4.0, 401)
    for name, values in {
        "constant_voltage": levels,
        "static_displacement": 0.1 + 0.5 * levels,
        "stroke": 2.0 * levels,
        "blocked_force": 3.0 * levels,
        "natural_frequency": np.sqrt(1.0 - 0.25 * levels),
        "static_field": levels * np.sqrt(q(levels)),
    }.items():
        np.testing.assert_allclose(curves[name], values, rtol=1e-12, err_msg=name)
    for name, flat in (("hoop", lambda v: lh**2), ("meridional", lambda v: lm**2 * q(v))):
        inside = strain(levels) < 6.0
        stress = -slack(flat)(levels)
        np.testing.assert_allclose(curves[f"static_{name}_stress"][inside], stress[inside], rtol=1e-9, err_msg=name)
    assert "static_heating" not in curves
    unknown = static_limits.static_limits_of(straight(TAUT, jump=3.7))
    assert np.isnan(unknown[0])


@pytest.mark.parametrize("share", [0.3, 2.5])
def test_the_first_film_to_meet_a_limit_counts(share):
    """Field and heat of either film, at its own voltage and from its own flat height."""
    films = {"second_film": "taut", "second_drive": "opposite", "second_flat_height": 0.8, "leakage_time": 7.0}
    plane = straight(TAUT.replace(**films, dielectric_strength=0.9), share=share)
    curves, limits = static_limits.static_curves(plane, 2.0), static_limits.static_limits_of(plane)
    first = passes(lambda v: v * np.sqrt(1.0 + (0.1 + 0.5 * v) ** 2) - 0.9, 0.0, 2.0)
    second = passes(lambda v: share * v * np.sqrt(1.0 + (0.7 - 0.5 * v) ** 2) - 0.9, 0.0, 4.0)
    assert limits[0] == pytest.approx(min(first, second), rel=1e-4)
    v, x = curves["constant_voltage"], curves["static_displacement"]
    squares = v**2 * (1.0 + x**2), (share * v) ** 2 * (1.0 + (0.8 - x) ** 2)
    np.testing.assert_allclose(curves["static_heating"], (squares[0] + squares[1]) / 2.0 / 7.0, rtol=1e-12)
    np.testing.assert_allclose(curves["static_field"], np.sqrt(squares[0]), rtol=1e-12)


def test_a_flat_film_alone_has_a_pitchfork():
    for model, expected in ((FLAT, np.sqrt(FLAT.stiffness(0.0, 0.0))), (TAUT, np.nan)):
        limits = static_limits.static_limits_of(Plane.of(model, None))
        np.testing.assert_array_equal(limits[STATIC_LIMITS.index("pitchfork")], expected)


@pytest.mark.parametrize(("strength", "jump"), [(1.3, 5.0), (9.0, 5.0), (9.0, 2.5), (1.3, np.inf), (9.0, np.inf)])
def test_quasi_static_limits_are_searched_up_to_pull_in_or_the_stretch_limit_whatever_the_own_drive(strength, jump):
    model = TAUT.replace(dielectric_strength=strength, stretch_limit=6.0)
    found = [
        static_limits.static_limits_of(straight(model.replace(voltage=own, voltage_bias=own), jump=jump))
        for own in (0.01, 0.3, 4.0)
    ]
    for own in found[1:]:
        np.testing.assert_array_equal(own, found[0])
    breakdown = passes(lambda v: v * np.sqrt(1.0 + (0.1 + 0.5 * v) ** 2) - strength, 0.1, 9.0)
    expected = breakdown if breakdown < jump else np.inf
    assert found[0][0] == pytest.approx(expected, rel=1e-6)


def test_a_film_without_pull_in_is_examined_up_to_its_stretch_limit():
    """The disc comes to it far above the unit of voltage."""
    model = ConeModel(voltage=0.1, voltage_bias=0.1, rest_height=0.8, hoop_prestretch=1.4)
    limits = dict(zip(STATIC_LIMITS, static_limits.static_limits_of(Plane.of(model, None)), strict=True))
    assert limits["pull-in"] == np.inf
    x = gelcone.stroke_and_blocked_force(model, [limits["stretch limit"]])["displacement"].item()
    q = 1.0 + x * x
    assert (q + 1.4**2 + 1.0 / (1.4**2 * q) - 3.0) / 50.0 == pytest.approx(0.99, rel=1e-6)


def test_a_film_without_tension_is_slack_from_no_voltage_on_and_one_without_pull_in_or_limit_has_none():
    """The search ends, however far it would go."""
    flat = Plane.of(ConeModel(voltage=0.1, law="neo-hookean", film="taut"), None)
    assert static_limits.static_limits_of(flat)[1] == 0.0
    stiff = {"law": "yeoh", "yeoh_c2": 0.05, "yeoh_c3": 0.0, "rest_height": 0.5, "hoop_prestretch": 1.4}
    model = ConeModel(voltage=0.1, film="taut", **stiff)
    limits = dict(zip(STATIC_LIMITS, static_limits.static_limits_of(Plane.of(model, None)), strict=True))
    assert (limits["pull-in"], limits["stretch limit"]) == (np.inf, np.inf)
    assert np.isnan(limits["dielectric breakdown"])
    for name, flag in (("hoop slack", "hoop_slack"), ("meridional slack", "meridional_slack")):
        near = gelcone.static(model, limits[name] * np.array([1.0 - 1e-6, 1.0 + 1e-6]))
        x = (near["rest_displacement"] + near["stroke"]).values
        at = np.nanargmin(np.abs(near["equilibrium_displacement"].values - x[:, None]), axis=1)
        assert near[f"validity_{flag}"].values[[0, 1], at].tolist() == [0.0, 1.0]


@pytest.mark.parametrize(
    ("limits", "top"),
    [
        ((np.nan, np.inf, np.inf, np.inf, np.nan, 3.0), 3.03),
        ((2.0, np.inf, np.inf, np.inf, np.nan, 3.0), 3.03),
        ((1.25, 0.0, np.inf, np.inf, np.nan, 3.0), 2.5),
        ((np.nan, 0.75, 0.5, 12.0, 0.625, np.inf), 1.0),
        ((np.nan, 0.0, np.inf, 12.0, np.nan, np.nan), 24.0),
    ],
)
def test_peaks_are_examined_up_to_pull_in_or_to_twice_the_lowest_limit(limits, top):
    peaks = static_limits.peaks_of(None, np.array(limits))
    np.testing.assert_allclose(peaks, top * np.arange(1.0, 21.0) / 20.0)


@pytest.mark.parametrize("leakage_time", [4.0, 40.0])
def test_a_film_that_gets_no_more_voltage_is_examined_up_to_twice_that_command(leakage_time):
    """The film of the capacitance 1 leaks v/te through the resistance, up to the limit of the current."""
    leak = {"series_resistance": 2.0, "leakage_time": leakage_time, "current_limit": 0.4 / leakage_time}
    plane = Plane.of(ConeModel(voltage=0.1, hoop_prestretch=1.4, **leak), None)
    static = static_limits.static_limits_of(plane)
    assert not np.isfinite(static).any()
    command = 0.4 + 2.0 * 0.4 / leakage_time
    assert static_limits.peaks_of(plane, static)[-1] == pytest.approx(2.0 * command, rel=0.04)


def made_up_holding(highest, levels, model, displacement):
    """Held voltages with a ``displacement`` (levels, samples) of the levels."""

    def at(levels):
        x = displacement(levels)
        times = np.tile(np.linspace(0.0, 1.0, x.shape[1]), (len(levels), 1))
        run = SimpleNamespace(times=times, states=np.stack([x, 0.0 * x], axis=-1))
        return model.replace(voltage=0.0, voltage_bias=levels).members(), run

    return Holding(highest, levels, at(levels), at, {})


def test_the_limits_of_a_held_voltage_are_the_first_that_its_run_meets_at_any_time():
    """The disc rises and sinks again while the voltage is held."""
    levels, times = np.linspace(0.0, 2.0, 21), np.linspace(0.0, 1.0, 11)
    model = TAUT.replace(dielectric_strength=1.3)
    held = made_up_holding(1.8, levels, model, lambda v: v[:, None] * 4.0 * times * (1.0 - times) * 0.5)
    relaxed = np.array([0.1, 0.2, 0.3, 0.4, 0.77, 0.5])
    plane = straight(TAUT.replace(dielectric_strength=1.3))
    found = static_limits.held_limits(plane, held, relaxed)
    breakdown = passes(lambda v: v * np.sqrt(1.0 + (0.5 * v) ** 2) - 1.3, 0.1, 2.0)
    hoop = static_limits.static_limits_of(straight(plane.model, rest=0.0))[1]
    thin = 1.0 / (1.2**2 * 1.5**2)
    low = np.sqrt((1.2**2 - thin) / (1.0 - (1.2**2 + 1.5**2 + thin - 3.0) / 50.0))  # flat, before the disc has risen
    expected = np.array([breakdown, hoop, low, np.inf, 0.77, 1.8])
    np.testing.assert_allclose(found, expected, rtol=1e-4)
    assert (found[:3] <= expected[:3] * (1.0 + 1e-12)).all()
    assert np.isnan(static_limits.held_limits(straight(TAUT), held, relaxed)[0])
    curve = Curve((0.0, 2.0), (1.5, 0.5), 0.01)  # at 0.5 v: 1.5 - 0.25 v = v
    over = static_limits.held_limits(straight(TAUT, membrane=curve), held, relaxed)
    assert over[-1] == pytest.approx(1.2, rel=1e-4)
    none = static_limits.held_limits(plane, held._replace(highest=0.0), relaxed)
    np.testing.assert_array_equal(none, relaxed)


@pytest.mark.parametrize("flat", [0.3, 0.9])
def test_the_first_film_to_meet_a_limit_counts_while_a_voltage_is_held_too(flat):
    """Both at one voltage: of the field it is the film that is farther from its flat height."""
    levels = np.linspace(0.0, 1.2, 25)
    films = {"second_film": "taut", "second_drive": "same", "second_flat_height": flat, "dielectric_strength": 0.9}
    model = TAUT.replace(**films)
    held = made_up_holding(1.1, levels, model, lambda v: np.tile(0.2 + 0.1 * v[:, None], (1, 3)))
    found = static_limits.held_limits(straight(model), held, np.full(len(STATIC_LIMITS), 9.0))
    first, second = (
        passes(lambda v, own=own: v * np.sqrt(1.0 + own(0.2 + 0.1 * v) ** 2) - 0.9, 0.0, 2.0)
        for own in (lambda x: x, lambda x: flat - x)
    )
    assert abs(first - second) > 0.01
    assert found[0] == pytest.approx(min(first, second), rel=1e-4)


def test_limits_above_a_begin_are_searched_from_there_up(monkeypatch):
    """Between 1.2 and 2.0 all assumptions hold."""

    def excess(plane, members, motion, voltages):
        return np.tile(np.abs(voltages[0] - 1.6) - 0.4, (len(static_limits._FAILING), 1, 1))

    monkeypatch.setattr(static_limits, "_violations", excess)
    np.testing.assert_allclose(static_limits._met(straight(TAUT), 10.0, 1.5), 2.0, rtol=1e-8)

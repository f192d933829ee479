"""Stability of rest: Mathieu's tongues, the product of the multipliers, onset against the motion itself."""

import numpy as np
import pytest
import xarray as xr
from scipy.special import mathieu_a, mathieu_b

from gelcone import (
    ConeModel,
    InputError,
    Onset,
    floquet_multipliers,
    integrate,
    load,
    onset_voltage,
    pitchfork_voltage,
    save,
    tongues,
)
from gelcone.motion import floquet
from gelcone.motion.monodromy import Options
from gelcone.plots.floquet import tongues_figure

BASE = ConeModel(drive_frequency=0.1, spring_stiffness=0.9, damping_ratio=0.01)
FAST = ConeModel(drive_frequency=0.3, spring_stiffness=0.5, damping_ratio=0.01)


def characteristic_values(stiffness, omega, voltage, count=8):
    """How far the undamped rest is from the borders of Mathieu's tongues, and the tongues' index.

    x'' + (k - v^2/2 + (v^2/2) cos 2 omega t) x = 0 is, in t' = omega t, y'' + (a - 2 q cos 2 t') y = 0 with
    a = (k - v^2/2)/omega^2 and q = -v^2/(4 omega^2); a_n and b_n as a set do not depend on the sign of q.
    """
    a, q = (stiffness - voltage**2 / 2.0) / omega**2, voltage**2 / (4.0 * omega**2)
    orders = [(n, mathieu_a(n, q)) for n in range(count)] + [(n, mathieu_b(n, q)) for n in range(1, count)]
    order, value = min(orders, key=lambda pair: abs(pair[1] - a))
    return abs(value - a) / max(1.0, abs(a)), order


# --- known answers ------------------------------------------------------------------------------------------------


def test_borders_of_the_tongues_are_mathieus_characteristic_values():
    model = ConeModel(damping_ratio=0.0, spring_stiffness=1.5)
    result = tongues(model, np.linspace(0.5, 3.0, 11), np.linspace(0.0, 2.5, 101))
    checked = 0
    for omega, borders in zip(result.drive_frequency.values, result.boundary_voltage.values, strict=True):
        for voltage in borders[np.isfinite(borders)]:
            distance, _ = characteristic_values(1.5, omega, voltage)
            assert distance < 1e-11
            checked += 1
    assert checked > 15


@pytest.mark.parametrize("omega", [0.4, 0.7, 1.0, 1.2, 2.0])
def test_the_undamped_onset_is_the_lowest_border_and_its_multiplier_that_of_the_tongue(omega):
    """Even tongues carry motions of one repeat, odd ones of two."""
    model = ConeModel(damping_ratio=0.0, spring_stiffness=1.5, drive_frequency=omega)
    result = onset_voltage(model)
    distance, order = characteristic_values(1.5, omega, float(result.onset_voltage))
    assert distance < 1e-11
    assert Onset(int(result.onset_kind)) == (Onset.MINUS_ONE if order % 2 else Onset.PLUS_ONE)
    assert float(result.onset_error) < 1e-6


# --- against the motion -------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    "model",
    [
        BASE,
        FAST,
        ConeModel(),
        ConeModel(voltage_bias=0.5),
        ConeModel(drive_frequency=4.0, prestretch=1.3, prestretch_mode="equibiaxial"),
        ConeModel(law="neo-hookean", drive_frequency=0.6, damping_ratio=0.2),
    ],
    ids=["base", "fast", "default", "bias", "biaxial", "neo-hookean"],
)
def test_one_per_cent_below_onset_motions_die_and_above_they_grow(model):
    onset = onset_voltage(model)
    voltage = float(onset.onset_voltage) * np.array([0.99, 1.01])
    pair = model.replace(voltage=voltage)
    expected = floquet_multipliers(pair).growth_rate.values
    # Long enough to tell, short enough to stay small.
    repeats = 10 * int(np.clip(1.5 / np.abs(expected).max() / model.forcing_period, 3, 12))
    times = float(model.forcing_period) * np.arange(1, repeats + 1)
    states = integrate(pair, (1e-9, 0.0), times).states
    size = np.log(np.hypot(states[..., 0], states[..., 1]).reshape(2, -1, 10).max(axis=2))
    growth = (size[:, -1] - size[:, 1]) / (times[-1] - times[19])
    assert growth[0] < 0.0 < growth[1]
    assert growth[1] == pytest.approx(expected[1], rel=0.02)
    # What grows repeats with the drive, or with every second one.
    sign = -1.0 if int(onset.onset_kind) == Onset.MINUS_ONE else 1.0
    assert np.sign(states[1, -1, 0] * states[1, -2, 0]) == sign


# --- searching ----------------------------------------------------------------------------------------------------


def test_a_tongue_between_two_points_of_the_scan_is_found():
    """At omega = 0.2 the first tongue is 0.020 wide, a step of the coarse scan 0.037, and no point falls inside."""
    model = ConeModel(damping_ratio=0.05, spring_stiffness=1.5, drive_frequency=0.2)
    scan = model.replace(voltage=np.linspace(0.0, 3.0 * float(pitchfork_voltage(model)), 101))
    unstable = floquet_multipliers(scan).growth_rate.values > 0.0
    fine, coarse = onset_voltage(model, steps=2048), onset_voltage(model, steps=100)
    assert scan.voltage[unstable.argmax() - 1] > float(fine.onset_voltage) + 0.02
    assert float(coarse.onset_voltage) == pytest.approx(float(fine.onset_voltage), abs=1e-10)


def test_onset_is_none_where_rest_stays_stable_and_zero_where_it_never_was():
    stable = onset_voltage(ConeModel(), highest=0.5)
    assert np.isnan(stable.onset_voltage)
    assert Onset(int(stable.onset_kind)) == Onset.NONE
    assert stable.searched.values.tolist() == [0.0, 0.5]
    buckled = onset_voltage(ConeModel(prestretch=0.6, spring_stiffness=0.1))
    assert (float(buckled.onset_voltage), Onset(int(buckled.onset_kind))) == (0.0, Onset.AT_START)


def test_by_default_three_times_the_pitchfork_is_searched():
    model = ConeModel(spring_stiffness=[0.5, 1.5])
    np.testing.assert_allclose(onset_voltage(model).searched[:, 1], 3.0 * pitchfork_voltage(model))


def test_tongues_agree_with_their_parts():
    omega, volts = np.array([0.3, 0.9, 1.6]), np.linspace(0.0, 2.0, 41)
    result = tongues(ConeModel(), omega, volts)
    apart = floquet_multipliers(ConeModel(drive_frequency=omega[:, None], voltage=volts))
    np.testing.assert_array_equal(result.growth_rate, apart.growth_rate)
    np.testing.assert_array_equal(result.spectral_radius, apart.spectral_radius)
    np.testing.assert_array_equal(
        result.onset_voltage, onset_voltage(ConeModel(drive_frequency=omega), highest=2.0).onset_voltage
    )
    first = result.boundary_voltage[:, 0]
    np.testing.assert_allclose(first[1:], result.onset_voltage[1:], atol=1e-10)
    # Every border lies between two grid points of different stability.
    changes = (np.diff((result.margin > 0.0).astype(int), axis=1) != 0).sum(axis=1)
    assert np.isfinite(result.boundary_voltage).sum("boundary").values.tolist() == changes.tolist()


# --- ensembles, files, figures, bad input -------------------------------------------------------------------------


def test_ensembles_equal_their_members_to_the_last_bit_on_any_number_of_threads():
    model = ConeModel(drive_frequency=np.geomspace(0.03, 4.0, 13), voltage=1.1)
    together = floquet_multipliers(model, threads=2)
    xr.testing.assert_identical(together, floquet_multipliers(model, threads=1))
    onsets = onset_voltage(model)
    for i in range(0, model.size, 3):
        alone = floquet_multipliers(model.take(i))
        for name in alone:
            np.testing.assert_array_equal(together[name][i], alone[name])
        np.testing.assert_array_equal(onsets.onset_voltage[i], onset_voltage(model.take(i)).onset_voltage)


def test_a_member_whose_flat_film_is_beyond_its_limit_is_marked():
    model = ConeModel(prestretch=[0.2, 1.0], stretch_limit=2.0)
    result = floquet_multipliers(model)
    assert result.outcome.values.tolist() == [1, 0]
    assert np.isnan(result.growth_rate).values.tolist() == [True, False]
    onset = onset_voltage(model)
    assert onset.outcome.values.tolist() == [1, 0]
    assert np.isnan(onset.onset_voltage).values.tolist() == [True, False]


def test_progress_adds_up_to_one():
    shares = []
    tongues(ConeModel(), [0.5, 1.0], [0.0, 1.0, 2.0], progress=shares.append)
    assert sum(shares) == pytest.approx(1.0, abs=1e-6)


def test_results_are_written_and_read_back_equal(tmp_path):
    for name, result in {
        "multipliers": floquet_multipliers(FAST),
        "onset": onset_voltage(FAST),
        "tongues": tongues(FAST, [0.3, 0.9], [0.0, 1.0, 2.0]),
    }.items():
        save(result, tmp_path / f"{name}.nc")
        xr.testing.assert_identical(load(tmp_path / f"{name}.nc"), result)


def test_the_figure_shows_onset_and_pitchfork():
    result = tongues(ConeModel(), np.linspace(0.3, 2.0, 12), np.linspace(0.0, 2.0, 21))
    figure = tongues_figure(result)
    axes = figure.axes[0]
    assert {line.get_label() for line in axes.lines} == {"onset", "static pitchfork at the peak"}
    stable = tongues_figure(tongues(ConeModel(), [2.0, 3.0], [0.0, 0.5]))
    assert [text.get_text() for text in stable.axes[0].texts] == ["rest is stable everywhere"]


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda: floquet_multipliers(ConeModel(rest_height=0.1)), "rest_height = 0.1: must be 0"),
        (lambda: onset_voltage(ConeModel(rest_height=[0.0, 0.2])), "rest_height = 0.2: must be 0"),
        (lambda: floquet_multipliers(ConeModel(prestretch=0.2, stretch_limit=1.0)), "stretch_limit = 1: must exceed"),
        (lambda: onset_voltage(ConeModel(), highest=0.0), "highest = 0: must be greater than 0"),
        (lambda: onset_voltage(ConeModel(), highest=[1.0, 2.0]), "highest has the shape"),
        (lambda: onset_voltage(ConeModel(), steps=1), "steps = 1: must be at least 2"),
        (lambda: tongues(ConeModel(voltage=[0.0, 1.0]), [0.5, 1.0], [0.0, 1.0]), "one actuator"),
        (lambda: tongues(ConeModel(), [1.0], [0.0, 1.0]), "drive_frequency: must be at least two increasing"),
        (lambda: tongues(ConeModel(), [0.5, 1.0], [1.0, 0.0]), "voltage: must be at least two increasing"),
        (lambda: tongues(ConeModel(), [0.0, 1.0], [0.0, 1.0]), "drive_frequency = 0: must be greater than 0"),
    ],
)
def test_bad_input_is_refused_with_the_bound_and_the_remedy(call, message):
    with pytest.raises(InputError, match=message):
        call()


def test_without_a_spring_a_rest_height_does_not_matter():
    free = ConeModel(spring_stiffness=0.0, prestretch=1.3)
    assert floquet_multipliers(free.replace(rest_height=0.3)).growth_rate == floquet_multipliers(free).growth_rate


# --- tongues and onsets: kinds, bounds and errors ---------------------------------------------------------------------


def test_the_principal_tongue_doubles_the_forcing_period_and_the_next_one_does_not():
    """The force has twice the drive's frequency: at w = sqrt(k) a motion of two forcing periods grows, at half of that
    one of a single period (Mathieu). The mean of the squared voltage softens k = 1 to 1 - v^2/2."""
    free = float(np.sqrt(1.0 - 0.08))
    model = ConeModel(spring_stiffness=1.0, damping_ratio=0.001)
    found = floquet.tongues(model, [0.5 * free, free], [0.2, 0.4])
    assert float(found["growth_rate"][1, 1]) > 0.0
    assert found["doubles"].values[:, 1].tolist() == [False, True]


def test_a_bias_is_taken_off_the_amplitude_whose_peak_reaches_the_pitchfork():
    model = ConeModel(spring_stiffness=1.44, voltage_bias=-0.3)
    found = floquet.tongues(model, [0.7, 1.1], [0.1, 0.2])
    assert float(found["pitchfork_amplitude"]) == pytest.approx(1.2 - 0.3, rel=1e-12)


def test_the_search_goes_up_to_three_times_the_pitchfork():
    model = ConeModel(spring_stiffness=[1.44, 0.25], damping_ratio=0.2)
    searched = floquet.onset_voltage(model)["searched"].values
    np.testing.assert_allclose(searched, [[0.0, 3.6], [0.0, 1.5]], rtol=1e-12)


def test_the_error_of_an_onset_is_the_whole_width_of_its_last_bracket():
    members = ConeModel(damping_ratio=[0.05]).members()
    onset = float(floquet.onset_voltage(members)["onset_voltage"][0])
    low, high = np.array([onset - 0.04]), np.array([onset + 0.05])
    voltage, width = floquet._refine(members, low, high, np.ones(1), Options(1e-15, 1))
    assert voltage[0] == pytest.approx(onset, abs=1e-9)
    assert width[0] == pytest.approx(0.09 / (floquet.SECTIONS + 1) ** floquet.ROUNDS, rel=1e-6)

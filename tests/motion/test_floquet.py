"""Stability of rest: Mathieu's tongues, the product of the multipliers, onset against the motion itself."""

import json
from types import SimpleNamespace

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
from gelcone.motion.monodromy import Monodromy
from gelcone.plots.floquet import tongues_figure
from tests.recorded import numbers, record

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
    scan = model.replace(voltage=np.linspace(0.0, 3.0 * float(pitchfork_voltage(model).pitchfork_voltage), 101))
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
    np.testing.assert_allclose(onset_voltage(model).searched[:, 1], 3.0 * pitchfork_voltage(model).pitchfork_voltage)


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
    half = floquet.tongues(model.replace(waveform="half_wave"), [0.7, 1.1], [0.1, 0.2])
    assert float(half["pitchfork_amplitude"]) == pytest.approx(1.2 + 0.3, rel=1e-12)  # it has no voltage below 0


def test_the_search_goes_up_to_three_times_the_pitchfork():
    model = ConeModel(spring_stiffness=[1.44, 0.25], damping_ratio=0.2)
    searched = floquet.onset_voltage(model)["searched"].values
    np.testing.assert_allclose(searched, [[0.0, 3.6], [0.0, 1.5]], rtol=1e-12)


def test_the_error_of_an_onset_is_the_whole_width_of_its_last_bracket():
    members = ConeModel(damping_ratio=[0.05]).members()
    onset = float(floquet.onset_voltage(members)["onset_voltage"][0])
    low, high = np.array([onset - 0.04]), np.array([onset + 0.05])
    voltage, width = floquet._refine(members, low, high, np.ones(1), {"tolerance": 1e-15, "threads": 1})
    assert voltage[0] == pytest.approx(onset, abs=1e-9)
    assert width[0] == pytest.approx(0.09 / (floquet.SECTIONS + 1) ** floquet.ROUNDS, rel=1e-6)


# --- what is handed on ------------------------------------------------------------------------------------------------


def maps_of(count, outcome=0):
    """Made-up maps: real multipliers of both signs, and all numbers different."""
    half = 1.0 + 0.01 * np.arange(count)
    return Monodromy(
        trace=np.where(np.arange(count) % 3 == 1, -2.0, 2.0) * half, log_scale=0.1 * np.arange(count),
        log_product=-0.2 - 0.01 * np.arange(count), product_error=numbers(count, at=7.0), repeat=numbers(count, at=3.0),
        outcome=np.full(count, outcome, dtype=np.int8),
    )  # fmt: skip


def test_multipliers_are_those_of_the_maps_and_the_growth_is_that_of_the_larger(monkeypatch):
    maps = maps_of(3)
    asked = record(monkeypatch, floquet, monodromy=maps)
    shares = []
    found = floquet_multipliers(
        BASE.replace(voltage=[0.1, 0.2, 0.3]), tolerance=2e-9, threads=5, progress=shares.append
    )
    ((call,),) = asked.values()
    assert (call["options"], call["progress"]) == ({"tolerance": 2e-9, "threads": 5}, shares.append)
    assert call["members"].number("voltage").tolist() == [0.1, 0.2, 0.3]
    real, imag, log_modulus = maps.multipliers()
    np.testing.assert_array_equal(found["multiplier_real"], real)
    np.testing.assert_array_equal(found["multiplier_imag"], imag)
    np.testing.assert_array_equal(found["log_modulus"], log_modulus)
    np.testing.assert_allclose(found["growth_rate"], log_modulus.max(axis=1) / maps.repeat)
    np.testing.assert_allclose(found["spectral_radius"], np.exp(log_modulus.max(axis=1)))
    np.testing.assert_array_equal(found["margin"], maps.margin())
    np.testing.assert_array_equal(found["forcing_period"], maps.repeat)
    np.testing.assert_array_equal(found["product_error"], maps.product_error)
    assert json.loads(found.attrs["options"]) == {"tolerance": 2e-9}


def made_up_onsets(asked):
    def onsets(model, *, highest=None, tolerance, threads, progress=None):
        asked.append((np.ravel(model.drive_frequency).tolist(), highest, tolerance, threads, progress is None))
        at = 10.0 * len(asked)
        values = {"onset_voltage": numbers(*model.shape, at=at), "onset_kind": np.full(model.shape, len(asked))}
        names = {name: (tuple("abc"[: len(model.shape)]), value, {"units": name}) for name, value in values.items()}
        return xr.Dataset(names | {"searched": ("bound", [at, at + 1.0])})

    return onsets


def test_tongues_are_those_of_the_grid_and_the_onsets_those_of_each_frequency_and_of_the_own_one(monkeypatch):
    """The growth is per time of the repeat of each frequency; the own onset is searched up to what was asked for, those
    of the rows up to the highest voltage."""
    asked, parts, omegas, volts = [], {}, np.array([0.3, 0.5]), np.array([0.1, 0.2, 0.4])
    parts = record(
        monkeypatch, floquet, monodromy=maps_of(6), _boundaries=numbers(2, 1, at=50.0), pitchfork_voltages=[0.9]
    )
    monkeypatch.setattr(floquet, "onset_voltage", made_up_onsets(asked))
    model = BASE.replace(voltage_bias=-0.25)
    found = tongues(model, omegas, volts, highest=0.75, tolerance=2e-9, threads=5)
    assert asked == [([0.1], 0.75, 2e-9, 5, True), ([0.3, 0.5], 0.4, 2e-9, 5, True)]
    (grid,), (boundary,), maps = parts["monodromy"], parts["_boundaries"], maps_of(6)
    assert grid["members"].number("drive_frequency").tolist() == [0.3] * 3 + [0.5] * 3
    assert grid["members"].number("voltage").tolist() == [0.1, 0.2, 0.4] * 2
    assert grid["options"] == boundary["options"] == {"tolerance": 2e-9, "threads": 5}
    assert boundary["rows"].number("drive_frequency").tolist() == [0.3, 0.5]
    np.testing.assert_array_equal(boundary["margin"], maps.margin().reshape(2, 3))
    np.testing.assert_array_equal(boundary["volts"], volts)
    larger = maps.multipliers()[2].max(axis=1)
    np.testing.assert_allclose(found["growth_rate"], (larger / maps.repeat).reshape(2, 3))
    np.testing.assert_allclose(found["spectral_radius"], np.exp(larger).reshape(2, 3))
    np.testing.assert_array_equal(found["margin"], maps.margin().reshape(2, 3))
    np.testing.assert_array_equal(found["doubles"], [[False, True, False]] * 2)
    np.testing.assert_array_equal(found["boundary_voltage"], numbers(2, 1, at=50.0))
    np.testing.assert_array_equal(found["onset_voltage"], numbers(2, at=20.0))
    assert (found["onset_kind"].values.tolist(), int(found["operating_onset_kind"])) == ([2, 2], 1)
    assert found["operating_onset_voltage"].item() == 10.0 + 1.0 / 1024.0
    assert found["operating_searched"].values.tolist() == [10.0, 11.0]
    assert float(found["pitchfork_amplitude"]) == pytest.approx(0.65)
    assert json.loads(found.attrs["options"]) == {"highest": 0.75, "tolerance": 2e-9}


def test_the_onset_is_the_first_bracket_also_where_a_tongue_hides_before_it(monkeypatch):
    """A member that fails at any voltage of the scan says so; each is refined in its own bracket, the kind is by the
    sign of the trace there."""
    margin = np.array([[-1.0, -0.5, 0.5, 1.0], [-1.0, -0.9, -0.8, -0.7], [0.5, 1.0, 1.0, 1.0], [-1.0, -0.2, -0.1, 0.3]])
    outcome = np.array([[0, 0, 0, 4], [0] * 4, [0] * 4, [0] * 4], dtype=np.int8)
    ends, calls = np.array([3.0, 6.0, 3.0, 3.0]), []

    def at_voltages(members, voltages, options, progress=None):
        calls.append((voltages, options))
        blank = maps_of(voltages.size)
        if len(calls) > 1:
            return SimpleNamespace(trace=np.array([-1.0, 1.0]))
        return SimpleNamespace(margin=lambda: margin.ravel(), outcome=outcome.ravel(), trace=blank.trace)

    monkeypatch.setattr(floquet, "_at_voltages", at_voltages)
    hidden = np.array([3]), np.array([0.25]), np.array([0.75])
    asked = record(
        monkeypatch, floquet, _hidden_brackets=hidden, _refine=(np.array([1.5, 0.5]), np.array([1e-3, 2e-3]))
    )
    members = BASE.replace(voltage=[0.1, 0.2, 0.3, 0.4]).members()
    monkeypatch.setattr(
        floquet, "_first_brackets", lambda scan, margin: tuple(map(np.array, ([0, 3], [1.0, 2.0], [2.0, 3.0])))
    )
    found, ended = floquet._onsets(members, ends, 3, {"tolerance": 2e-9, "threads": 5}, None)
    np.testing.assert_allclose(calls[0][0], ends[:, None] * [0.0, 1 / 3, 2 / 3, 1.0])
    assert calls[1][0].tolist() == [[1.5], [0.5]]
    (refined,) = asked["_refine"]
    assert (refined["low"].tolist(), refined["high"].tolist(), refined["rising"].tolist()) == (
        [1, 0.25],
        [2, 0.75],
        [1, 1],
    )
    assert refined["members"].number("voltage").tolist() == [0.1, 0.4]
    assert [options for _, options in calls] + [refined["options"]] == [{"tolerance": 2e-9, "threads": 5}] * (
        len(calls) + 1
    )
    np.testing.assert_array_equal(found[0], [1.5, np.nan, 0.0, 0.5])
    assert found[1].tolist() == [Onset.MINUS_ONE, Onset.NONE, Onset.AT_START, Onset.PLUS_ONE]
    np.testing.assert_array_equal(found[2], [1e-3, np.nan, 0.0, 2e-3])
    assert ended.tolist() == [4, 0, 0, 0]


def test_a_hidden_tongue_is_in_the_bracket_from_the_scan_below_it_to_where_its_margin_peaks(monkeypatch):
    """Of a margin 0.05 - 100 (v - 0.53)^2, which is above 0 between 0.508 and 0.552, in a scan of steps of 0.1."""
    scan = np.linspace(0.0, 1.0, 11)[None]

    def margin(v):
        return 0.05 - 100.0 * (v - 0.53) ** 2

    monkeypatch.setattr(floquet, "NEAR_ONSET", -1.0)
    monkeypatch.setattr(
        floquet, "_at_voltages", lambda members, v, options: SimpleNamespace(margin=lambda: margin(v).ravel())
    )
    members = BASE.replace(voltage=[0.1]).members()
    rows, low, high = floquet._hidden_brackets(members, scan, margin(scan), {"tolerance": 1e-9, "threads": 1})
    assert rows.tolist() == [0]
    assert low.tolist() == [pytest.approx(0.4)]
    assert margin(low[0]) < 0.0 < margin(high[0])
    assert high[0] == pytest.approx(0.53, abs=0.01)


def test_every_integration_has_the_tolerance_and_the_threads_of_the_call(integrations):
    onset_voltage(FAST, steps=2, highest=0.5, tolerance=2e-15, threads=2)
    floquet_multipliers(FAST, tolerance=2e-15, threads=2)
    assert integrations == {(2e-15, 2)}

"""Spectra: calibrated amplitudes, lines, flatness, no folding, ensembles to the last bit, contracts."""

import json

import numpy as np
import pytest
from matplotlib.figure import Figure

from gelcone.codes import Outcome
from gelcone.dataset import load, save
from gelcone.errors import InputError
from gelcone.motion import settle as settle_module
from gelcone.motion import spectrum as module
from gelcone.motion.flow import integrate
from gelcone.motion.spectrum import analyse, spectrum
from gelcone.physics.model import ConeModel
from gelcone.physics.waveforms import Chirp
from gelcone.plots.spectrum import spectrum_figure
from tests import recorded
from tests.recorded import numbers

PERIODIC = ConeModel(damping_ratio=0.1, spring_stiffness=1.0, voltage=0.8, drive_frequency=1.0, rest_height=0.3)
CHAOTIC = ConeModel(damping_ratio=0.01, spring_stiffness=0.9, voltage=1.7, drive_frequency=0.1)
FREE = ConeModel(damping_ratio=0.0, spring_stiffness=1.5, voltage=0.0, drive_frequency=1.0, law="neo-hookean")


def varied():
    """Members with and without a bias, of different speeds, one at rest, one that starts outside, one that escapes."""
    return ConeModel(
        damping_ratio=[0.01, 0.1, 0.05, 0.5, 0.05, 0.1],
        spring_stiffness=[0.9, 1.0, 1.5, 1.0, 1.0, 0.1],
        voltage=[1.7, 0.8, 0.5, 0.1, 0.5, 2.6],
        voltage_bias=[0.0, 0.0, 0.3, 0.0, 0.0, 0.0],
        drive_frequency=[0.5, 1.0, 0.8, 1.0, 1.0, 1.0],
        stretch_limit=[50.0, 50.0, 10.0, 20.0, 0.04, np.inf],
        rest_height=[0.0, 0.3, 0.1, 0.0, 0.0, 0.0],
    )


def tones(size, periods, *lines):
    """An even record over whole periods with lines given as (frequency, amplitude, phase)."""
    t = np.arange(size) / size * periods
    return sum(a * np.cos(2.0 * np.pi * f * t + phase) for f, a, phase in lines)


# --- one record -------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("offset", [0.0, 0.1, 0.25, 0.4999, 0.5, 0.7])
def test_a_line_between_bins_has_its_frequency_and_amplitude(offset):
    frequency = (200 + offset) / 64
    found = analyse(0.4 + tones(4096, 64, (frequency, 0.03, 1.1)), 64, 8.0)
    assert found.lines.shape == (1, 3)
    assert found.lines[0, 0] == pytest.approx(frequency, abs=1e-9)
    assert found.lines[0, 1] == pytest.approx(0.03, rel=1e-8)
    assert found.lines[0, 2] > 100.0
    assert found.mean == pytest.approx(0.4, rel=1e-8)
    assert found.rms == pytest.approx(0.03 / np.sqrt(2.0), rel=1e-6)
    assert found.power_in_lines > 0.9999
    assert found.flatness < 1e-10


def test_a_line_on_a_bin_shows_with_its_height_there():
    found = analyse(tones(4096, 64, (2.0, 0.3, 0.2), (5.0, 1e-6, 0.0)), 64, 8.0)
    assert found.amplitude[128] == pytest.approx(0.3, rel=1e-13)
    assert found.amplitude[320] == pytest.approx(1e-6, rel=1e-8)
    np.testing.assert_allclose(found.lines[:, 0], [2.0, 5.0], rtol=1e-9)


def test_a_line_at_the_end_of_the_band_is_seen():
    found = analyse(tones(4096, 64, (2.0, 0.3, 0.2), (8.0, 0.1, 0.0)), 64, 8.0)
    np.testing.assert_allclose(found.lines[:, 0], [2.0, 8.0], rtol=1e-9)
    assert found.amplitude.size == 8 * 64 + 1


def test_weak_lines_show_beside_strong_ones():
    """A line 80 dB down, 16 bins away from one between bins, stands clear of its sidelobes."""
    found = analyse(tones(8192, 64, (3.007, 1.0, 0.3), (3.25, 1e-4, 1.0)), 64, 8.0)
    assert found.lines[1, 0] == pytest.approx(3.25, abs=1e-3)
    assert found.lines[1, 1] == pytest.approx(1e-4, rel=0.05)


@pytest.mark.parametrize("seed", range(5))
def test_white_noise_is_flat_and_has_no_lines(seed):
    noise = np.random.default_rng(seed).normal(size=65536)
    found = analyse(noise, 256, 16.0)
    assert found.flatness == pytest.approx(np.exp(-np.euler_gamma), abs=0.03)
    assert found.lines.size == 0
    assert found.power_in_lines == 0.0


def test_the_share_of_lines_is_that_of_their_variance():
    noise = np.random.default_rng(3).normal(size=65536) * 0.02
    lines = tones(65536, 256, (3.1, 1.0, 0.0))
    found = analyse(lines + noise, 256, 32.0)
    in_band = noise.var() * 32.0 * 256 / (65536 / 2)
    assert found.power_in_lines == pytest.approx(0.5 / (0.5 + in_band), abs=1e-5)


def test_what_stands_still_has_no_spectrum():
    for record in (np.zeros(1024), 0.3 + 1e-16 * np.random.default_rng(0).normal(size=1024)):
        found = analyse(record, 16, 8.0)
        assert found.lines.size == 0
        assert np.isnan([found.flatness, found.power_in_lines, found.aliasing_bound]).all()
        assert not found.folds


# --- motions ----------------------------------------------------------------------------------------------------------


def test_a_free_small_oscillation_is_one_line_at_the_square_root_of_the_stiffness():
    result = spectrum(FREE, (1e-3, 0.0), periods=128, discard=10)
    assert float(result.line_frequency[0]) == pytest.approx(np.sqrt(1.5), rel=1e-6)
    assert float(result.line_ratio[0]) == float(result.line_frequency[0])
    assert float(result.line_amplitude[0]) == pytest.approx(1e-3, rel=1e-6)
    assert float(result.power_in_lines) > 0.9999
    assert float(result.flatness) < 1e-9


def test_the_ratio_is_over_the_frequency_of_the_voltage():
    slow = spectrum(FREE.replace(drive_frequency=0.25), (1e-3, 0.0), periods=64, discard=0)
    assert float(slow.line_frequency[0]) == pytest.approx(np.sqrt(1.5), rel=1e-6)
    assert float(slow.line_ratio[0]) == pytest.approx(4.0 * np.sqrt(1.5), rel=1e-6)
    np.testing.assert_allclose(slow.frequency, 0.25 * slow.frequency_ratio)


def test_a_forced_motion_has_its_lines_at_twice_the_drive_and_multiples():
    result = spectrum(PERIODIC, periods=64)
    np.testing.assert_allclose(result.line_ratio[:3], [2.0, 4.0, 6.0], rtol=1e-9)
    times = (200 + np.arange(64) / 64) * np.pi
    x = integrate(PERIODIC, (1.0, 0.0), times).states[0, :, 0]
    harmonics = 2.0 * np.abs(np.fft.rfft(x)) / x.size
    np.testing.assert_allclose(result.line_amplitude[:3], harmonics[1:4], rtol=1e-8)
    assert float(result.mean_displacement) == pytest.approx(x.mean(), rel=1e-12)
    assert float(result.rms) == pytest.approx(x.std(), rel=1e-9)


def test_a_bias_brings_a_line_at_the_drive_itself():
    result = spectrum(PERIODIC.replace(voltage_bias=0.3), periods=64)
    assert float(result.line_ratio[0]) == pytest.approx(1.0, rel=1e-9)
    assert (abs(result.line_ratio - 3.0) < 1e-6).any()


def test_chaos_is_broadband():
    chaos = spectrum(CHAOTIC, periods=64, discard=50)
    periodic = spectrum(PERIODIC, periods=64)
    assert float(chaos.flatness) > 1e-4
    assert float(chaos.power_in_lines) < 0.5
    assert float(periodic.flatness) < 1e-12
    assert float(periodic.power_in_lines) > 1.0 - 1e-9


def test_sampling_is_refined_until_nothing_folds(monkeypatch):
    """A large free motion kinks as it passes x = 0: coarse samples show harmonics of it aliasing_bound back as false
    lines."""
    model = ConeModel(damping_ratio=0.0, spring_stiffness=0.9, voltage=0.0, drive_frequency=0.1)
    fine = spectrum(model, (3.0, 0.0), periods=32, discard=0)
    monkeypatch.setattr(module, "FOLDED", 1.0)
    coarse = spectrum(model, (3.0, 0.0), periods=32, discard=0)
    assert float(fine.aliasing_bound) < 1e-5 * float(fine.amplitude.max()) < float(coarse.aliasing_bound)
    difference = abs(fine.amplitude - coarse.amplitude)[1:].max()
    assert 1e-6 < float(difference) < float(coarse.aliasing_bound)
    fundamental = float(fine.line_ratio[0])
    found = fine.line_ratio.values / fundamental
    np.testing.assert_allclose(found, np.rint(found), rtol=0.0, atol=1e-4)
    assert (np.rint(found) % 2 == 1).all()


# --- ensembles, outcomes, contracts -----------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def many():
    return spectrum(varied(), (0.5, 0.0), periods=32, discard=100)


def test_an_ensemble_equals_its_members_one_by_one_to_the_last_bit(many):
    model = varied()
    for i in (0, 1, 2, 3, 5):
        alone = spectrum(model.take(i), (0.5, 0.0), periods=32, discard=100)
        for name, variable in alone.data_vars.items():
            inside = many[name].isel(member=i).values
            if variable.ndim == 1 and name != "initial":
                count = variable.size
                assert np.isnan(inside[count:]).all()
                inside = inside[:count]
            np.testing.assert_array_equal(variable.values, inside, err_msg=str(name))


def test_threads_and_blocks_do_not_change_a_bit(many, monkeypatch):
    monkeypatch.setattr(settle_module, "BLOCK_SAMPLES", 1)
    assert many.identical(spectrum(varied(), (0.5, 0.0), periods=32, discard=100, threads=1))


def test_members_that_fail_or_stand_still_hold_nothing(many):
    assert many.outcome.values.tolist() == [0, 0, 0, 0, Outcome.OUTSIDE, Outcome.NOT_FINITE]
    assert many.amplitude[4:].isnull().all()
    assert many.line_amplitude[3:].isnull().all()
    assert many.flatness.isnull().values.tolist() == [False, False, False, True, True, True]
    assert (many.flatness[:3] >= 0.0).all()
    assert (many.flatness[:3] <= 1.0).all()


def test_each_member_has_its_own_angular_frequencies(many):
    omega = varied().drive_frequency
    np.testing.assert_allclose(many.frequency, np.outer(omega, many.frequency_ratio))
    np.testing.assert_allclose(many.line_frequency, many.line_ratio * omega[:, None])


def test_results_read_back_equal_and_name_their_units(many, tmp_path):
    save(many, tmp_path / "spectrum.nc")
    assert load(tmp_path / "spectrum.nc").identical(many)
    assert many.line_prominence.attrs["units"] == "dB"
    assert {many[n].attrs["quantity"] for n in ("frequency", "line_frequency")} == {"frequency"}
    assert {many[n].attrs["quantity"] for n in ("amplitude", "line_amplitude", "rms", "aliasing_bound")} == {"length"}


def test_progress_adds_up_to_one():
    shares = []
    spectrum(varied(), (0.5, 0.0), periods=16, discard=10, progress=shares.append)
    assert sum(shares) == pytest.approx(1.0)


def test_the_band_is_what_was_asked_for():
    result = spectrum(PERIODIC, periods=30, discard=0, highest=2.1)
    assert float(result.frequency_ratio[-1]) == pytest.approx(2.1)
    assert result.sizes["frequency_ratio"] == 64


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"periods": 0}, "periods = 0: must be at least 16"),
        ({"periods": 20.5}, "periods = 20.5: must be a whole number"),
        ({"discard": -5}, "discard = -5: must be at least 0"),
        ({"highest": 0.0}, "highest = 0: must be from 1 to 16384 times the drive frequency"),
        ({"highest": np.inf}, "highest = inf: must be from 1"),
        ({"highest": np.nan}, "highest = nan: must be from 1"),
        ({"highest": "all"}, "highest = 'all': must be a number"),
        ({"initial": (9.0, 0.0)}, "start lower or raise it"),
    ],
)
def test_bad_input_is_refused(options, message):
    with pytest.raises(InputError, match=message):
        spectrum(PERIODIC, **options)


# --- pictures ---------------------------------------------------------------------------------------------------------


def test_a_figure_marks_and_names_the_lines():
    figure = spectrum_figure(spectrum(PERIODIC, periods=32))
    assert isinstance(figure, Figure)
    (axes,) = figure.axes
    assert axes.get_yscale() == "log"
    assert axes.get_xlabel() == "frequency / drive frequency"
    assert [text.get_text() for text in axes.texts] == ["2", "4", "6", "8"]


def test_an_ensemble_has_a_panel_a_member_with_its_verdict(many):
    figure = spectrum_figure(many)
    verdicts = [axes.get_title(loc="right") for axes in figure.axes]
    assert verdicts[3:] == ["stands still", "failed: outside", "failed: not finite"]
    assert all("flatness" in v for v in verdicts[:3])
    limits = {axes.get_ylim() for axes in figure.axes}
    assert len(limits) == 1


# --- runs of drives that do not repeat --------------------------------------------------------------------------------

CHIRP = ConeModel(
    waveform=Chirp(), voltage=0.3, voltage_bias=0.4, rest_height=0.5, drive_frequency=0.05, damping_ratio=0.1,
    start_frequency=[0.5, 0.7], end_frequency=[2.0, 3.0],
)  # fmt: skip


@pytest.fixture(scope="module")
def chirped():
    return spectrum(CHIRP, (0.5, 0.0), tolerance=1e-10)


def test_the_spectrum_of_a_chirp_is_that_of_its_run(chirped):
    """The Fourier sum of the run as `integrate` samples it, with ends that a cosine tapers, written out."""
    count = 8192
    share = np.arange(count) / count
    run = integrate(CHIRP, (0.5, 0.0), share * 2.0 * np.pi / 0.05, tolerance=1e-10)
    window = np.sin(np.pi * np.clip(np.minimum(share, 1.0 - share) / 0.1, 0.0, 0.5)) ** 2
    aliasing_bound = chirped["aliasing_bound"].values
    for x, found, least in zip(run.states[..., 0], chirped["amplitude"].values, aliasing_bound, strict=True):
        mean = np.average(x, weights=window)
        assert found[0] == pytest.approx(mean, rel=1e-7)
        for cycles in (3, 10, 20, 40, 60):
            wave = np.exp(-2j * np.pi * cycles * share)
            exact = 2.0 * abs(np.average((x - mean) * wave, weights=window))
            assert found[cycles] == pytest.approx(exact, rel=1e-7, abs=least)
    np.testing.assert_allclose(chirped["frequency"], 0.05 * np.arange(chirped.sizes["frequency_ratio"]))
    assert json.loads(chirped.attrs["options"]) | {"tolerance": 0} == {
        "periods": 1, "discard": 0, "highest": None, "tolerance": 0,
    }  # fmt: skip


def test_it_has_no_lines(chirped):
    for name in ("power_in_lines", "line_ratio", "line_frequency", "line_amplitude", "line_prominence"):
        assert chirped[name].isnull().all(), name
    assert (chirped["flatness"] > 0.0).all()
    assert (chirped["rms"] > 0.01).all()
    assert (chirped["aliasing_bound"] <= 1e-5 * chirped["amplitude"][:, 1:].max("frequency_ratio")).all()


def test_its_band_holds_twice_the_fastest_swing_of_the_drive():
    """The end frequency of 9 is 180 cycles in the length of the drive, and the film is slower."""
    fast = CHIRP.replace(end_frequency=9.0, start_frequency=0.5)
    assert spectrum(fast, (0.5, 0.0), tolerance=1e-8).sizes["frequency_ratio"] == 512 + 1


def test_a_longer_record_holds_what_rings_on_behind_it():
    """A small free oscillation rings at the square root of the stiffness, 1.5: resolved to half a bin of the record."""
    free = FREE.replace(waveform="chirp", drive_frequency=0.2)
    for lengths in (1, 8):
        result = spectrum(free, (1e-3, 0.0), periods=lengths, highest=20)
        assert result.sizes["frequency_ratio"] == 20 * lengths + 1
        highest = int(result["amplitude"].values[1:].argmax()) + 1
        assert float(result["frequency"][highest]) == pytest.approx(np.sqrt(1.5), abs=0.1 / lengths)
    assert float(result["amplitude"][highest]) == pytest.approx(1e-3, rel=0.1)


def test_it_has_nothing_to_discard():
    with pytest.raises(InputError, match=r"discard = 5: waveform = chirp does not repeat.*leave discard out"):
        spectrum(CHIRP, discard=5)
    with pytest.raises(InputError, match="periods = 0"):
        spectrum(CHIRP, periods=0)
    with pytest.raises(InputError, match=r"highest = 1e[+]07: must be from 1 to 524288"):
        spectrum(CHIRP, highest=1e7)


# --- one record by hand -----------------------------------------------------------------------------------------------


def test_the_first_bin_is_the_mean():
    turns = 2.0 * np.pi * np.arange(4096) / 128.0
    found = analyse(-0.7 + 0.2 * np.sin(turns), 32, 8.0)
    assert found.amplitude[0] == pytest.approx(0.7, rel=1e-12)
    assert found.mean == pytest.approx(-0.7, rel=1e-12)
    assert found.amplitude[32] == pytest.approx(0.2, rel=1e-12)


def test_a_slow_drift_is_no_line():
    """Half a swing of a slow oscillation over the record leaves a slope next to the mean, and one line of the rest."""
    share = np.arange(4096) / 4096.0
    drift = np.cos(np.pi * share) + 0.05 * np.random.default_rng(1).normal(size=4096)
    found = analyse(drift, 32, 8.0)
    assert (found.lines[:, 0] > 3.0 / 32.0).all()
    with_line = analyse(drift + 0.5 * np.sin(2.0 * np.pi * 64.0 * share), 32, 8.0)
    assert with_line.lines[0, 0] == pytest.approx(2.0, abs=1e-3)


# --- what is handed on ------------------------------------------------------------------------------------------------


def test_records_begin_where_motions_have_settled_and_are_refined_while_they_fold_up_to_the_most_samples(monkeypatch):
    """Of three members the second folds once, and the third always, until it may not be sampled more finely."""
    model = ConeModel(damping_ratio=0.1, drive_frequency=[0.5, 1.0, 2.0], voltage_bias=0.3)
    settled, ended, shares = numbers(3, 2, at=3.0), np.array([0, 4, 0], dtype=np.int8), []
    ends = {0: 0, 1: 4, 2: 5}

    def settling(members, states, repeats, *, progress, tolerance, threads):
        progress(1.0)
        return settled, ended

    def records(members, states, outcome, periods, samples, progress, **flow):
        progress(1.0)
        which = [int(np.flatnonzero(model.drive_frequency == omega)[0]) for omega in members.number("drive_frequency")]
        return [(i, (row, samples[i]), ends[row]) for i, row in enumerate(which)]

    def analysed(record, periods, band):
        row, samples = record
        folds = {0: False, 1: samples < 64, 2: True}[row]
        return module.Spectrum(
            numbers(4, at=10.0 * row),
            np.array([[2.0, 3.0, 4.0]]) + row,
            5.0 + row,
            6.0 + row,
            1e9 * folds,
            7.0 + row,
            8.0 + row,
        )

    sampling = np.array([32, 32, 32]), np.array([256, 256, 128])
    asked = recorded.record(
        monkeypatch, module, settle=settling, _records=records, analyse=analysed, _sampling=sampling,
        _bands=np.array([8.0, 16.0, 32.0]),
    )  # fmt: skip
    found = spectrum(
        model, (0.25, 0.5), periods=20, discard=10, highest=1.5, tolerance=2e-9, threads=5, progress=shares.append
    )
    flow, (before,) = {"tolerance": 2e-9, "threads": 5}, asked["settle"]
    assert (before["repeats"], {name: before[name] for name in flow}) == (10, flow)
    np.testing.assert_array_equal(before["states"], [[0.25, 0.5]] * 3)
    assert shares[:2] == pytest.approx([0.2, 0.4])  # half of what is left for each round
    assert sum(shares) == pytest.approx(1.0)
    assert (asked["_bands"][0]["highest"], asked["_bands"][0]["periods"]) == (1.5, 20)
    rounds = [([0, 1, 2], 32, [0, 4, 0]), ([1, 2], 128, [4, 5])]
    for call, (rows, samples, outcome) in zip(asked["_records"], rounds, strict=True):
        np.testing.assert_array_equal(call["states"], settled[rows])
        assert call["outcome"].tolist() == outcome
        assert call["samples"].tolist() == [samples] * len(rows)
        assert (call["periods"], {name: call[name] for name in flow}) == (20, flow)
    assert [call["highest"] for call in asked["analyse"]] == [8.0, 16.0, 32.0, 16.0, 32.0]
    assert {call["periods"] for call in asked["analyse"]} == {20}
    rows, omega = np.arange(3.0)[:, None], np.asarray(model.drive_frequency)[:, None]
    assert found["amplitude"].shape == (3, 31)  # up to 1.5 times the drive in steps of a twentieth
    np.testing.assert_array_equal(found["amplitude"][:, :4], [numbers(4, at=10.0 * k) for k in range(3)])
    np.testing.assert_allclose(found["frequency_ratio"], np.arange(31) / 20.0)
    np.testing.assert_allclose(found["frequency"], np.arange(31) / 20.0 * omega)
    np.testing.assert_allclose(found["line_ratio"], 2.0 + rows)
    np.testing.assert_allclose(found["line_frequency"], (2.0 + rows) * omega)
    np.testing.assert_allclose(found["line_amplitude"], 3.0 + rows)
    np.testing.assert_allclose(found["line_prominence"], 4.0 + rows)
    for name, value in (("power_in_lines", 5.0), ("flatness", 6.0), ("mean_displacement", 7.0), ("rms", 8.0)):
        np.testing.assert_array_equal(found[name], value + np.arange(3.0), name)
    assert found["aliasing_bound"].values.tolist() == [0.0, 0.0, 1e9]
    assert found["outcome"].values.tolist() == [0, 4, 5]
    options = {"periods": 20, "discard": 10, "highest": 1.5, "tolerance": 2e-9}
    assert json.loads(found.attrs["options"]) == options


def test_every_integration_has_the_tolerance_and_the_threads_of_the_call(integrations):
    spectrum(PERIODIC, periods=16, discard=2, highest=1.0, tolerance=2e-15, threads=2)
    assert integrations == {(2e-15, 2)}

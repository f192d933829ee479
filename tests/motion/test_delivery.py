"""What a source has to give over a run: root mean squares of its second half, peaks of all of it."""

from types import SimpleNamespace

import numpy as np
import pytest

import gelcone
from gelcone.motion import delivery, peaks
from gelcone.motion.flow import integrate
from gelcone.motion.jumps import jumps_between
from gelcone.motion.natural import frequency_of, natural_frequency
from gelcone.physics.model import ConeModel
from tests.motion.made_up import MadeUp

NAMES = ("rms_voltage", "rms_current", "apparent_power", "peak_current", "peak_slew_rate")


def test_a_root_mean_square_is_of_the_second_half_whatever_its_spacing():
    times = np.concatenate([np.linspace(0.0, 1.0, 50, endpoint=False), np.linspace(1.0, 3.0, 4001)])[None]
    half = delivery.halfway(times)
    assert times[0, half] == 1.5
    values = np.where(np.arange(times.shape[1]) < half, 100.0, 2.0 + np.sin(2.0 * np.pi * times))
    begin, end = times[0, half], times[0, -1]
    expected = np.sqrt(
        np.trapezoid((2.0 + np.sin(2.0 * np.pi * times[0, half:])) ** 2, times[0, half:]) / (end - begin)
    )
    assert delivery._root_mean_squares(times, values)[0] == pytest.approx(expected, rel=1e-12)


@pytest.mark.parametrize("films", [1, 2])
def test_a_held_disc_takes_the_current_of_its_capacitors(films):
    """V0 + V sin: of two equal films on one source twice the current of one."""
    second = {"second_film": "taut"} if films == 2 else {}
    model = gelcone.ConeModel(
        film="taut", spring_stiffness=1e8, rest_height=0.5, voltage=0.3, voltage_bias=0.4, drive_frequency=0.7, **second
    )
    times = np.linspace(0.0, 8.0 * np.pi / 0.7, 4001)
    run = gelcone.simulate(model, (0.5, 0.0), times=times)
    capacitance = films * 1.25
    expected = {
        "rms_voltage": np.sqrt(0.4**2 + 0.3**2 / 2.0),
        "rms_current": capacitance * 0.3 * 0.7 / np.sqrt(2.0),
        "peak_current": capacitance * 0.3 * 0.7,
        "peak_slew_rate": 0.3 * 0.7,
    }
    expected["apparent_power"] = expected["rms_voltage"] * expected["rms_current"]
    for name in NAMES:
        assert float(run[name]) == pytest.approx(expected[name], rel=2e-3), name


def test_a_charge_that_stays_takes_no_current_and_a_small_current_is_one():
    """Of an open circuit, to rounding; a drive a million times smaller than the charge is no rounding."""
    held = gelcone.ConeModel(circuit="charge", voltage=0.0, voltage_bias=0.4, rest_height=0.8)
    run = gelcone.simulate(held, (0.5, 0.0), periods=10.0)
    assert [float(run[name]) for name in ("peak_current", "rms_current", "apparent_power")] == [0.0, 0.0, 0.0]
    assert float(run["peak_slew_rate"]) > 0.01
    driven = held.replace(voltage=4e-7, drive_frequency=0.7)
    assert float(gelcone.simulate(driven, (0.5, 0.0), periods=10.0)["peak_current"]) == pytest.approx(2.8e-7, rel=1e-3)


def test_the_natural_frequency_is_the_root_of_the_stiffness_about_the_ramps_end():
    model = gelcone.ConeModel(rest_height=0.6, hoop_prestretch=1.3)
    volts = np.array([0.0, 0.3])
    x = gelcone.stroke_and_blocked_force(model, volts)["displacement"].values
    np.testing.assert_allclose(natural_frequency(model, volts), np.sqrt(model.stiffness(x, volts)), rtol=1e-12)
    assert natural_frequency(model, 0.3) == pytest.approx(float(natural_frequency(model, volts)[1]), rel=1e-12)
    at = np.array([0.2, 0.4])
    np.testing.assert_allclose(natural_frequency(model, volts, at) ** 2, model.stiffness(at, volts), rtol=1e-12)
    np.testing.assert_array_equal(frequency_of(np.array([4.0, -1e-10, -1.0])), [2.0, 0.0, np.nan])


def test_each_source_has_its_own_numbers(monkeypatch):
    """The second source is constant, and nothing of it jumps."""
    monkeypatch.setattr(delivery, "_limited", lambda *_: {})
    times = np.linspace(0.0, 4.0 * np.pi, 4001)[None]
    lines = (
        SimpleNamespace(films=(0, 2), prefix="", circuit=SimpleNamespace(jumps=True), drive="same"),
        SimpleNamespace(films=(1,), prefix="second_", circuit=SimpleNamespace(jumps=True), drive="constant"),
    )
    other = 5.0
    system = SimpleNamespace(
        lines=lines,
        waveform=SimpleNamespace(pieced=False),
        source_currents=lambda times, *_: [3.0 * np.cos(times), 3.0 * np.sin(times)],
        source_voltages=lambda times, *_: [2.0 + np.sin(times), other, 2.0 + np.sin(times)],
        source_rates=lambda times, *_: [np.cos(times), 0.0, np.cos(times)],
        source_charges=lambda times, *_: [-7.0 * np.sin(times), 4.0],
    )
    monkeypatch.setattr(
        peaks, "integrate", lambda members, begin, times, **_: SimpleNamespace(states=np.zeros((*times.shape, 2)))
    )
    members = MadeUp(system=system)
    members.take = lambda rows: members
    for jump, infinite in ((0.0, False), (1.0, True)):
        lost = np.where(times > 3.0 * np.pi, jump, 0.0)
        found = delivery.delivered(members, times, np.zeros((1, 4001, 2)), lost)
        expected = {
            "rms_voltage": np.sqrt(4.5), "rms_current": 3.0 / np.sqrt(2.0), "peak_charge": 7.0, "peak_current": 3.0,
            "peak_slew_rate": 1.0, "second_rms_voltage": 5.0, "second_rms_current": 3.0 / np.sqrt(2.0),
            "second_peak_charge": 4.0, "second_peak_current": 3.0, "second_peak_slew_rate": 0.0,
        }  # fmt: skip
        if infinite:
            expected |= dict.fromkeys(("rms_current", "peak_current", "peak_slew_rate"), np.inf)
        expected["apparent_power"] = sum(
            expected[f"{prefix}rms_voltage"] * expected[f"{prefix}rms_current"] for prefix in ("", "second_")
        )
        assert set(found) == set(expected)
        for name, value in expected.items():
            assert float(found[name][1][0]) == pytest.approx(value, rel=1e-4), name
            assert ("second film" in found[name][2]) == name.startswith("second_")
            assert ("first film" in found[name][2]) == (not name.startswith("second_") and name != "apparent_power")
    early = np.where(times > 0.5 * np.pi, 1.0, 0.0)  # a jump in the first half alone leaves the rms of the second
    found = delivery.delivered(members, times, np.zeros((1, 4001, 2)), early)
    assert float(found["rms_current"][1][0]) == pytest.approx(3.0 / np.sqrt(2.0), rel=1e-4)
    assert float(found["peak_current"][1][0]) == np.inf


# --- jumps of the voltage ---------------------------------------------------------------------------------------------

HELD = {"film": "taut", "spring_stiffness": 1e8, "rest_height": 0.5, "damping_ratio": 1.0}
"""A disc that does not move: the film is a capacitor of 1 + 0.5^2."""
SQUARE = HELD | {"waveform": "square", "rise": 0.0, "duty": 0.3, "voltage": 0.4, "voltage_bias": 0.25}
C = 1.25


def test_what_is_lost_late_in_the_permittivity_is_not_lost_in_the_jump():
    """Of a share that follows late the charge does not jump."""
    whole = ConeModel(**SQUARE).members()
    part = ConeModel(**SQUARE, dielectric_share=0.25, dielectric_time=3.0).members()
    end = np.array([[1.5 * float(whole.drive_period[0])]])
    for members, share in ((whole, 1.0), (part, 0.75)):
        states = members.start_states((0.5, 0.0))
        work, lost = delivery.switched(members, states, end)
        swing = 2.0 * 0.4
        count = round(float(lost[0, 0]) / (share * 0.5 * C * swing**2))
        assert count in (2, 3)
        assert lost[0, 0] == pytest.approx(share * count * 0.5 * C * swing**2, rel=1e-6)
        assert abs(work[0, 0]) > 0.0


def test_a_jump_at_the_time_itself_has_happened():
    members = ConeModel(**SQUARE).members()
    corner = float(jumps_between(members, np.zeros(1), members.drive_period).times[0, 0])
    lost = delivery.switched(
        members, members.start_states((0.5, 0.0)), np.array([[0.999 * corner, corner, 1.001 * corner]])
    )[1]
    assert lost[0, 0] == 0.0
    assert lost[0, 1] == lost[0, 2] > 0.0


DRIVEN = HELD | {"voltage": 0.1, "voltage_bias": 0.4, "drive_frequency": 0.7}


def test_a_short_rise_between_two_samples_is_in_the_peaks_of_a_run():
    """C v' of a disc that is held, while the voltage rises within 0.1 % of a period."""
    period, rise = 2.0 * np.pi / 0.7, 1e-3
    model = gelcone.ConeModel(**DRIVEN, waveform="square", duty=0.5, rise=rise)
    run = gelcone.simulate(model, (0.5, 0.0), times=period * np.array([0.01, 15.7]))
    slope = 0.2 / (rise * period)
    assert float(run["peak_slew_rate"]) == pytest.approx(slope, rel=1e-6)
    assert float(run["peak_current"]) == pytest.approx(1.25 * slope, rel=1e-3)


def test_both_halves_of_a_run_are_followed_between_corners():
    members = gelcone.ConeModel(**DRIVEN, waveform="triangle").members()
    times = float(members.drive_period[0]) * np.array([[0.0, 0.2, 0.5, 1.0, 1.1]])
    states = integrate(members, (0.5, 0.0), times).states
    ((rows, (first, second)),) = delivery._between_corners(members, times, states, 2)
    assert rows.tolist() == [0]
    for path, begin, end in ((first, 0, 2), (second, 2, 4)):
        np.testing.assert_array_equal(path.begin, states[:, begin])
        np.testing.assert_array_equal([path.start, path.end], [times[:, begin], times[:, end]])
        assert (path.times[path.weights > 0.0] > times[0, begin]).all()
        assert (path.times[path.weights > 0.0] < times[0, end]).all()
    smooth = gelcone.ConeModel(**DRIVEN).members()
    assert delivery._between_corners(smooth, times, states, 2) == []
    many = delivery.MOST_CORNERS * times
    assert delivery._between_corners(members, many, states, 2) == []


def test_what_a_source_delivers_does_not_depend_on_the_other_members(monkeypatch):
    """Three with some 90 corners each have more together than are followed at a time; a faster one has more than are
    followed at all."""
    monkeypatch.setattr(delivery, "MOST_CORNERS", 100)
    model = gelcone.ConeModel(**DRIVEN, waveform="triangle")
    three = model.replace(voltage=np.array([0.1, 0.15, 0.2]))
    together, alone = (gelcone.simulate(some, (0.5, 0.0), periods=40) for some in (three, three.take([1])))
    for name in (*NAMES, "peak_charge"):
        assert float(together[name][1]) == pytest.approx(float(np.ravel(alone[name])[0]), rel=1e-14), name
    faster = three.replace(drive_frequency=np.array([0.7, 0.7, 7.0])).members()
    times = np.linspace(0.0, 1.0, 5) * 20.0 * float(three.members().drive_period[0]) * np.ones((3, 1))
    corners = faster.system.waveform.corner_count(times[:, 0], times[:, -1], faster.own_numbers)
    assert (corners > 100).tolist() == [False, False, True]
    states = np.full((3, 5, 2), [0.5, 0.0])
    assert [rows.tolist() for rows, _ in delivery._between_corners(faster, times, states, 2)] == [[0, 1]]


def test_a_peak_between_the_samples_of_either_half_counts(monkeypatch):
    """Of each source the largest value over the samples and over both halves between corners."""
    model = gelcone.ConeModel(**DRIVEN, waveform="triangle")
    members = model.members()
    times = float(members.drive_period[0]) * np.array([[0.0, 0.2, 0.5, 1.0, 1.1]])
    states = integrate(members, (0.5, 0.0), times).states
    for highest in ([7.0, 1.0, 1.0], [1.0, 7.0, 1.0], [1.0, 1.0, 7.0]):
        values = iter(highest)
        monkeypatch.setattr(delivery, "largest", lambda *_, values=values: np.full((3, 1), next(values)))
        found = delivery.delivered(members, times, states, np.zeros_like(times))
        assert [found[name][1].tolist() for name in ("peak_charge", "peak_current", "peak_slew_rate")] == [[7.0]] * 3


def test_a_double_cone_takes_one_apparent_power_from_both_sources():
    device = gelcone.find_device("double-cone")
    run, settled = gelcone.simulate(device, periods=60), gelcone.settled(device)
    assert "second_apparent_power" not in run
    assert float(run["apparent_power"]) == pytest.approx(float(settled["apparent_power"]), rel=1e-3)

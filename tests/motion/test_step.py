"""Steps of the voltage: a linear oscillator's numbers, creep, pull-in, and what the commands for one run give."""

import importlib
import json
import re
from types import SimpleNamespace

import numpy as np
import pytest
import xarray as xr

import gelcone
from gelcone import InputError, Outcome
from gelcone.motion.step import _duration, _measured
from gelcone.motion.validity import VALIDITY, invalid
from tests.recorded import numbers, record

module = importlib.import_module("gelcone.motion.step")

PUMP = gelcone.find_device("biased-pump").replace(film="wrinkling")


@pytest.mark.parametrize("damping", [0.1, 0.4])
def test_the_numbers_are_those_of_a_damped_oscillator(damping):
    """1 - exp(-zeta t) (cos w t + zeta/w sin w t), with its overshoot exp(-pi zeta/w)."""
    omega = np.sqrt(1.0 - damping**2)

    def answer(times):
        return 1.0 - np.exp(-damping * times) * (np.cos(omega * times) + damping / omega * np.sin(omega * times))

    times = np.linspace(0.0, 200.0, 637)  # twenty samples an oscillation, as those of a run
    speed = np.exp(-damping * times) * np.sin(omega * times) / omega
    way = np.stack([answer(times), speed, 1.0 - answer(times) - 2.0 * damping * speed], axis=-1)
    found = _measured(times, np.array([2.0, 0.0, 0.0]) + np.stack([3.0 * way, -3.0 * way]), 2.0)
    np.testing.assert_allclose(found["final_displacement"], [5.0, -1.0], atol=1e-6)
    np.testing.assert_allclose(found["overshoot"], np.exp(-np.pi * damping / omega), rtol=1e-6)
    fine = np.linspace(0.0, 100.0, 1_000_001)
    first, last = (fine[np.argmax(answer(fine) >= level)] for level in (0.1, 0.9))
    np.testing.assert_allclose(found["rise_time"], last - first, atol=2e-4)
    outside = fine[np.abs(answer(fine) - 1.0) > 0.02].max()
    np.testing.assert_allclose(found["settling_time"], outside, atol=2e-4)
    np.testing.assert_allclose(found["drift"], 0.0, atol=1e-6)


def test_what_has_not_settled_by_the_end_of_the_run_has_no_settling_time():
    """Ramps: the one leaves the range of 2 % about the mean of its last tenth, the other stays within at its end."""
    times = np.linspace(0.0, 1.0, 1001)
    x = np.stack([times, np.where(times < 0.4995, 2.001 * times, 1.0)])
    x = np.stack([x, np.stack([np.ones(1001), np.where(times < 0.4995, 2.001, 0.0)]), 0.0 * x], axis=-1)
    found = _measured(times, x, 0.0)
    np.testing.assert_allclose(found["final_displacement"], [0.95, 1.0])
    np.testing.assert_allclose(found["settling_time"], [np.nan, 0.98 / 2.001], atol=1e-9)
    np.testing.assert_allclose(found["rise_time"], [0.95 * 0.8, 0.8 / 2.001], rtol=1e-9)
    np.testing.assert_allclose(found["overshoot"], [1.0 / 19.0, 0.0], atol=1e-12)
    np.testing.assert_allclose(found["drift"], [0.1 / 0.95, 0.0], atol=1e-12)
    np.testing.assert_allclose(_measured(times, -x, 0.0)["drift"], [0.1 / 0.95, 0.0], atol=1e-12)  # on the way down


def test_a_disc_that_does_not_move_has_no_times():
    still = np.zeros((1, 101, 3)) + np.array([0.3, 0.0, 0.0])
    found = _measured(np.linspace(0.0, 1.0, 101), still, 0.3)
    assert np.isnan([found[name][0] for name in ("rise_time", "overshoot", "settling_time", "drift")]).all()


def test_a_step_ends_where_a_slow_ramp_does_and_is_a_run_of_simulate():
    found = gelcone.step(PUMP, ["0.5 kV", "1 kV"])
    assert found["final_displacement"].attrs["units"] == "mm"
    assert found["rise_time"].attrs["units"] == "ms"
    np.testing.assert_allclose(found["final_displacement"], found["equilibrium_displacement"], rtol=1e-4)
    static = gelcone.static(PUMP, ["0.5 kV", "1 kV"])
    np.testing.assert_allclose(found["final_displacement"] - found["initial_displacement"], static["stroke"], rtol=2e-3)
    held = PUMP.replace(voltage_amplitude=0.0, voltage_offset="1 kV")
    times = 1e-3 * found["time"].values[:200]
    alone = gelcone.simulate(held, times=times)["displacement"]
    np.testing.assert_allclose(found["displacement"].isel(constant_voltage=1)[:200], alone, rtol=1e-9)
    from_half = gelcone.step(PUMP, ["1 kV"], before="0.5 kV")
    assert float(from_half["initial_displacement"][0]) == pytest.approx(
        float(found["equilibrium_displacement"][0]), rel=1e-9
    )


def test_a_resistance_slows_the_rise_and_a_film_that_creeps_drifts():
    plain = gelcone.step(PUMP, ["1 kV"])
    behind = gelcone.step(PUMP.replace(series_resistance="100 MOhm"), ["1 kV"])
    assert float(behind["overshoot"][0]) < 0.5 * float(plain["overshoot"][0])
    branch = {"material.viscous_modulus_1": "4 kPa", "material.relaxation_time_1": "2 s"}
    creeping = gelcone.step(PUMP.replace(branch), ["1 kV"], duration="8 s")
    assert float(creeping["drift"][0]) > 0.001 > abs(float(plain["drift"][0]))
    assert float(creeping["final_displacement"][0]) < float(creeping["equilibrium_displacement"][0])


@pytest.mark.parametrize(("damping", "slowest", "lasts"), [(0.2, 1.0, 40.0), (0.2, 30.0, 240.0), (4.0, 1.0, 8.0)])
def test_a_run_lasts_eight_of_its_slowest_times(damping, slowest, lasts):
    assert _duration(damping, slowest, None) == pytest.approx(lasts)
    assert _duration(damping, slowest, 3.0) == 3.0


def test_a_step_that_pulls_in_says_so():
    found = gelcone.step(PUMP, ["1 kV", "4 kV"])
    assert found["outcome"].values.tolist() == [Outcome.OK, Outcome.PULLED_IN]
    assert np.isnan(found["final_displacement"][1])
    assert np.isnan(found["equilibrium_displacement"][1])


@pytest.mark.parametrize("film", ["taut", "wrinkling"])
def test_the_model_holds_for_the_share_of_a_step_for_which_it_holds_in_simulate(film):
    """Slack, breakdown, membranes that have pulled in, and steps that pull in."""
    device = PUMP.replace(film=film)
    levels = ["1 kV", "2.4 kV", "2.8 kV"]
    found = gelcone.step(device, levels, duration="0.5 s")
    for k, level in enumerate(levels):
        held = device.replace(voltage_amplitude=0.0, voltage_offset=level)
        alone = gelcone.simulate(held, times=["0.5 s"])
        shares = [name for name in alone if str(name).startswith(("validity_", "film_state_"))]
        assert {str(name) for name in found} >= set(shares)
        for name in shares:
            np.testing.assert_allclose(found[name][k], alone[name], atol=1e-8, err_msg=f"{level} {name}")
    assert invalid(found).values.tolist() == [False, True, True]
    assert 0.1 < float(found["validity_beyond_membrane"][1]) < 0.9
    if film == "taut":
        assert all(0.1 < float(found[f"validity_{name}"][2]) < 0.9 for name in ("breakdown", "hoop_slack"))
    else:
        assert float(found["validity_pulled_in"][2]) == 1.0


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"before": "9 kV"}, "before = .*: beyond pull-in"),
        ({"duration": 0.0}, "duration = 0.*: must be positive"),
        ({"voltages": [-5.0]}, "voltages"),
    ],
)
def test_bad_steps_are_refused(options, message):
    with pytest.raises(InputError, match=message):
        gelcone.step(PUMP, **options)
    with pytest.raises(InputError, match="takes one actuator"):
        gelcone.step(PUMP.replace(frequency=[8.0, 9.0]))


@pytest.mark.parametrize(
    ("model", "message"),
    [
        (
            gelcone.ConeModel(rest_height=0.8, damping_ratio=1e-10),
            "damping_ratio = 1e-10: 8 decay times last 8e+10, longer than 1e+09; give it more damping, or a duration",
        ),
        (
            gelcone.ConeModel(
                rest_height=0.8,
                damping_ratio=0.1,
                film=gelcone.TautCone(branches=1),
                viscous_modulus_1=0.5,
                relaxation_time_1=3e8,
            ),
            "duration: 8 time constants of the slowest state last 3.6e+09, longer than 1e+09; give a duration",
        ),
    ],
)
def test_a_default_duration_that_is_too_long_is_refused_by_its_cause(model, message):
    with pytest.raises(InputError, match=f"^{re.escape(message)}$"):
        gelcone.step(model, [0.3])


def test_a_default_duration_of_a_device_is_refused_in_seconds():
    with pytest.raises(InputError, match=r"^damping_\w+: 8 decay times last \S+ \w+, longer than \S+ \w+; give"):
        gelcone.step(PUMP.replace(damping_coefficient=1e-12))


def test_a_step_is_from_the_rest_before_to_each_level_and_holds_what_its_parts_gave(monkeypatch):
    """The second level fails: all but where it begins is then unknown."""
    ramps = {0.5: [0.25, 0.375]}

    def ramp(model, voltages, start=None):
        return {"displacement": xr.DataArray(ramps[voltages[0]]), "stroke": xr.DataArray([9.0] * len(voltages))}

    def runs(members, states, times, **options):
        return SimpleNamespace(states=numbers(2, times.size, 2, at=5.0), outcome=np.array([0, 4], dtype=np.int8))

    names = ("final_displacement", "rise_time", "overshoot", "settling_time", "drift")
    measured = {name: numbers(2, at=10.0 + k) for k, name in enumerate(names)}
    lasted = numbers(2, VALIDITY, at=30.0)
    asked = record(
        monkeypatch, module, stroke_and_blocked_force=ramp, integrate=runs, _measured=measured, validity_of_run=lasted,
        equilibrium_under_bias=0.75, acceleration_at=lambda members, times, states: states[..., 0] - 1.0,
    )  # fmt: skip
    model, shares = gelcone.ConeModel(rest_height=0.8, hoop_prestretch=1.4, damping_ratio=0.2), []
    found = gelcone.step(
        model, [0.5, 0.625], before=0.125, duration=30.0, tolerance=2e-9, threads=5, progress=shares.append
    )
    assert asked["equilibrium_under_bias"] == [{"model": model, "bias": 0.125, "given": "before ="}]
    (run,), (numbers_of,) = asked["integrate"], asked["_measured"]
    assert run["initial"].tolist() == [[0.75, 0.0]] * 2
    assert run["model"].number("voltage_bias").tolist() == [0.5, 0.625]
    assert run["model"].number("voltage").tolist() == [0.0, 0.0]
    assert (run["times"][0], run["times"][-1], run["tolerance"], run["threads"]) == (0.0, 30.0, 2e-9, 5)
    run["progress"](1.0)
    assert shares == [0.5, 0.5]
    assert numbers_of["start"] == 0.75
    np.testing.assert_array_equal(numbers_of["times"], run["times"])
    motion = numbers(2, run["times"].size, 2, at=5.0)
    np.testing.assert_array_equal(numbers_of["motion"][..., :2], motion)
    np.testing.assert_array_equal(numbers_of["motion"][..., 2], motion[..., 0] - 1.0)
    for name in names:
        np.testing.assert_array_equal(found[name], [measured[name][0], np.nan], name)
    assert found["initial_displacement"].values.tolist() == [0.75, 0.75]
    assert found["equilibrium_displacement"].values.tolist() == [0.25, 0.375]
    np.testing.assert_array_equal(found["displacement"], motion[..., 0])
    assert found["outcome"].values.tolist() == [0, 4]
    np.testing.assert_array_equal(found["validity_hoop_slack"], lasted[:, 0])
    assert float(found["before_voltage"]) == 0.125
    assert json.loads(found.attrs["options"]) == {"before": 0.125, "duration": 30.0, "tolerance": 2e-9}
    units = {
        found[name].attrs["quantity"]
        for name in ("final_displacement", "initial_displacement", "equilibrium_displacement", "displacement")
    }
    assert units == {"length"}
    assert {found[name].attrs["quantity"] for name in ("rise_time", "settling_time", "time")} == {"time"}


@pytest.mark.parametrize("circuit", [{}, {"filter_time": 0.5}, {"series_resistance": 0.2}])
@pytest.mark.parametrize("drive", ["same", "opposite", "constant"])
def test_a_double_cone_ends_where_a_slow_ramp_does_and_stays_where_it_rests(drive, circuit):
    """Films in opposite phase had the bias of the voltage after the step, and rested nowhere before it."""
    films = {"second_film": "taut", "second_drive": drive, "second_flat_height": 1.2, "second_prestretch": 1.2}
    own = {"second_voltage": 0.5} if drive == "constant" else {}
    command = {"voltage": 0.2, "voltage_bias": 0.4, "damping_ratio": 0.2}
    model = gelcone.ConeModel(**films, **own, **circuit, **command, hoop_prestretch=1.4)
    found = gelcone.step(model, [0.0, 0.1, 0.6], before=0.2)
    ramp = gelcone.static(model, [0.0, 0.1, 0.2, 0.6]).equilibrium_displacement.values[:, 0]
    np.testing.assert_allclose(found.final_displacement, ramp[[0, 1, 3]], rtol=1e-4)
    np.testing.assert_allclose(found.initial_displacement, ramp[2], rtol=1e-12)
    if not circuit:  # which are off before the step
        still = gelcone.step(model, [0.2], before=0.2, duration=10.0)
        np.testing.assert_allclose(still.displacement, ramp[2], rtol=1e-9)

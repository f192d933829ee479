"""What the source gives: against the balance of the run, against formulas, and the same from every command."""

from types import SimpleNamespace

import numpy as np
import pytest

import gelcone
from gelcone.analyses.request import Subject
from gelcone.codes import Regime
from gelcone.motion import electrical as module
from gelcone.motion.corners import sampled_evenly
from gelcone.motion.electrical import apparent_power, electrical
from gelcone.motion.flow import integrate
from gelcone.motion.response import heats
from gelcone.physics.system import ConeSystem
from gelcone.presets import find_preset
from gelcone.studio import settled
from tests.motion.made_up import MadeUp
from tests.recorded import record

PUMP = gelcone.find_device("biased-pump").replace(film="wrinkling")
DOUBLE = gelcone.find_device("double-cone").replace(film="taut", second_film="taut")


@pytest.mark.parametrize("device", [PUMP, DOUBLE], ids=["one film", "two films"])
def test_the_settled_power_is_that_of_the_energy_balance_of_a_run(device):
    """Mean of voltage times current over whole periods: the energies of `simulate` over the last ten of them."""
    found = gelcone.settled(device)
    assert int(found["period"]) >= 1
    period = 1.0 / float(device.frequency)
    run = gelcone.simulate(device, times=np.linspace(0.0, 400.0 * period, 401))
    supplied = run["supplied_energy"].values[-1] - run["supplied_energy"].values[-11]
    assert run["supplied_energy"].attrs["units"] == "mJ"
    assert found["power"].attrs["units"] == "mW"
    assert float(found["power"]) == pytest.approx(supplied / (10.0 * period), rel=1e-5)


def test_a_disc_held_by_a_stiff_spring_takes_the_current_of_a_capacitor():
    """C v' and rms of both; no power, for nothing moves or is lost."""
    model = find_preset("base").model.replace(spring_stiffness=1e8, rest_height=0.5, damping_ratio=0.5)
    members = model.replace(voltage=0.3, drive_frequency=0.7).members()
    period = float(members.drive_period[0])
    times = period * np.arange(1, 257)[None] / 256
    states = np.tile([0.5, 0.0], (1, 256, 1))
    found = electrical(members, times, states, states[:, -1])
    capacitance = 1.0 + 0.5**2
    assert found["current"][0] == pytest.approx(capacitance * 0.3 * 0.7, rel=1e-12)
    assert found["apparent_power"][0] == pytest.approx(capacitance * 0.3**2 * 0.7 / 2.0, rel=1e-12)
    assert found["power"][0] == 0.0
    states[:, 100:] = np.nan
    assert all(np.isnan(values[0]) for values in electrical(members, times, states, states[:, 0]).values())


def test_two_equal_films_on_one_source_take_twice_what_one_takes():
    """Both flat together: apparent power and current of the source double; the field does not. The disc is held: two
    films have twice the force."""
    one = gelcone.ConeModel(film="taut", voltage=0.3, voltage_bias=0.4, rest_height=0.5, spring_stiffness=1e9)
    pair = one.replace(second_film="taut")
    members = [model.replace(drive_frequency=0.7, damping_ratio=0.1).members() for model in (one, pair)]
    times = members[0].drive_period[:, None] * np.arange(1, 65) / 64
    states = np.tile([0.5, 0.0], (1, 64, 1))
    single, double = (electrical(own, times, states, states[:, 0]) for own in members)
    assert single["apparent_power"][0] > 0.01
    for name, factor in (("apparent_power", 2.0), ("current", 2.0), ("field", 1.0)):
        assert double[name][0] == pytest.approx(factor * single[name][0], rel=1e-4), name


def test_the_page_envelope_and_settled_give_one_power_and_one_field():
    found = gelcone.settled(PUMP)
    subject = Subject(PUMP.to_model(), PUMP, PUMP.initial_state())
    kind = settled.kind(subject)
    assert kind.words["regime"] == Regime.PERIODIC
    shown = {row["name"]: row["value"] for row in settled.electrical(subject, kind.run).words["numbers"]}
    assert shown["power"] == pytest.approx(float(found["power"]), rel=1e-4)
    assert shown["current"] == pytest.approx(float(found["current"]), rel=1e-2)
    own = PUMP.voltage_offset + PUMP.voltage_amplitude, PUMP.frequency
    plane = gelcone.envelope(PUMP, peaks=[0.5 * own[0], own[0]], frequencies=[own[1], 1.1 * own[1]])
    at = plane.sel(drive_frequency=own[1], method="nearest").sel(peak_voltage=own[0], method="nearest")
    for name, share in (("power", 1e-4), ("apparent_power", 1e-4), ("field", 1e-3)):
        assert at[f"driven_{name}"].attrs["units"] == found[name].attrs["units"]
        assert float(at[f"driven_{name}"]) == pytest.approx(float(found[name]), rel=share)


def test_losses_between_samples_count():
    """Behind a small resistance the current of a triangle turns within a fraction of a sample."""
    device = gelcone.find_device("snap-cone").replace(
        film="taut", waveform="triangle", frequency=6.3, voltage_offset=281.0, voltage_amplitude=255.0,
        series_resistance="0.5 MOhm",
    )  # fmt: skip
    found, period = gelcone.settled(device), 1.0 / float(device.frequency)
    run = gelcone.simulate(device, times=period * np.arange(121.0))
    for name in ("resistor", "damper"):
        lost = run[f"{name}_dissipation"].values
        expected = (lost[-1] - lost[-11]) / (10.0 * period)
        assert float(found[f"{name}_power"]) == pytest.approx(expected, rel=1e-5)


JUMPING = {"waveform": "square", "duty": 0.4, "rise": 0.0, "film": "taut", "rest_height": 0.3}


def test_the_mean_power_of_a_voltage_that_jumps_is_that_of_simulate():
    """Of a motion that settled: all that the source gives in the last ten periods, and what it loses where it jumps."""
    model = gelcone.ConeModel(
        **JUMPING, voltage=0.3, voltage_bias=0.3, drive_frequency=0.4, prestretch=1.2, damping_ratio=0.1
    )
    period = float(model.drive_period)
    found = gelcone.settled(model)
    # a little after each period's last jump; samples of 1/128 of a period average a power with kinks to 1e-5
    run = gelcone.simulate(model, times=period * (1e-6 + np.arange(61)))
    supplied, lost = (run[name].values for name in ("supplied_energy", "resistor_dissipation"))
    assert float(found["power"]) == pytest.approx((supplied[-1] - supplied[-11]) / (10.0 * period), rel=1e-5)
    assert float(found["resistor_power"]) == pytest.approx((lost[-1] - lost[-11]) / (10.0 * period), rel=1e-6)
    assert float(found["damper_power"]) == pytest.approx(float(found["power"] - found["resistor_power"]), rel=1e-9)
    assert 0.5 < float(found["resistor_power"] / found["power"]) < 1.0
    assert np.isinf(found["current"])
    assert np.isinf(run["peak_current"])
    plane = gelcone.envelope(model, peaks=[0.3, 0.6], frequencies=[0.4, 0.5])
    for name in ("power", "damper_power"):
        assert float(plane[f"driven_{name}"][0, 1]) == pytest.approx(
            float(found[name]), abs=1e-5 * float(found["power"])
        )


def test_a_disc_held_still_loses_at_each_jump_what_a_capacitor_does():
    """C (dv)^2/2 twice a period, also of two films and with a share of the permittivity that does not jump."""
    for more, films, share in (
        ({}, 1.0, 1.0),
        ({"second_film": "taut", "second_flat_height": 1.0}, 2.0, 1.0),
        ({"dielectric_share": 0.3, "dielectric_time": 1e6}, 1.0, 0.7),
    ):
        given = JUMPING | {"rest_height": 0.5, "spring_stiffness": 1e8, "damping_ratio": 0.5}
        model = gelcone.ConeModel(**given, **more, voltage=0.2, voltage_bias=0.1, drive_frequency=0.7)
        members = model.members()
        period = float(members.drive_period[0])
        times = period * np.arange(1, 129)[None] / 128
        begin = members.start_states((0.5, 0.0))
        states = np.repeat(begin[:, None], 128, axis=1)
        found = electrical(members, times, states, begin)
        lost = films * share * 1.25 * 0.5 * 0.4**2 * 2.0 / period
        assert found["resistor_power"][0] == pytest.approx(lost, rel=1e-6)


def test_a_settled_power_is_split_by_what_takes_it():
    """As the energies of a run: damper, film, resistance and leak; an elastic film behind an ideal source has one."""
    device = gelcone.find_device("biased-pump").replace(
        {
            "film": "taut",
            "material.viscous_modulus_1": "4 kPa",
            "material.relaxation_time_1": "50 ms",
            "material.resistivity": "2 Gohm m",
            "series_resistance": "1 MOhm",
        }
    )
    settled = gelcone.settled(device, tolerance=1e-10)
    period = 1.0 / float(device.frequency)
    run = gelcone.simulate(device, times=period * np.arange(61.0), tolerance=1e-10)
    causes = ("damper", "film", "resistor", "leak")
    for cause in causes:
        lost = run[f"{cause}_dissipation"].values
        assert float(settled[f"{cause}_power"]) == pytest.approx((lost[-1] - lost[-11]) / (10.0 * period), rel=1e-3)
    total = sum(float(settled[f"{cause}_power"]) for cause in causes)
    assert total == pytest.approx(float(settled["power"]), rel=1e-9)
    assert "damper_power" not in gelcone.settled(PUMP, tolerance=1e-8)


def test_the_sheet_gives_the_numbers_of_the_settled_motion():
    found, sheet = gelcone.settled(PUMP), gelcone.datasheet(PUMP)
    for name, own in (("stroke", "drive_stroke"), ("current", "peak_current"), ("power", "mean_power")):
        assert sheet[own].attrs["units"] == found[name].attrs["units"]
        assert float(sheet[own]) == pytest.approx(float(found[name]), rel=1e-5)
    assert float(sheet["apparent_power"]) == pytest.approx(float(found["apparent_power"]), rel=1e-5)


def test_two_films_each_take_their_apparent_power():
    """Equal films in the middle: twice that of one, which sees the same voltage."""
    model = DOUBLE.to_model()
    both = model.members()
    times = float(both.drive_period[0]) * np.arange(1, 129)[None] / 128
    run = integrate(both, [[0.1, 0.0]], times)
    found = electrical(both, run.times, run.states, run.states[:, -1])
    z = list(np.moveaxis(run.states, -1, 0))
    n = both.numbers(trailing=1)
    expected = sum(
        np.sqrt(np.mean(v**2) * np.mean(i**2))
        for v, i in zip(both.voltages(run.times, run.states), both.system.currents(run.times, z, n), strict=True)
    )
    assert found["apparent_power"][0] == pytest.approx(expected, rel=1e-12)


def test_heat_in_the_film_is_what_creep_and_leaks_lose():
    """Of a settled motion, in a run and over its periods; the damper and the resistance heat no film."""
    device = gelcone.find_device("biased-pump").replace(
        {
            "film": "taut",
            "material.viscous_modulus_1": "4 kPa",
            "material.relaxation_time_1": "50 ms",
            "material.resistivity": "2 Gohm m",
            "series_resistance": "1 MOhm",
        }
    )
    settled = gelcone.settled(device, tolerance=1e-10)
    run = gelcone.simulate(device, periods=60, tolerance=1e-10)
    volume = np.pi * (0.03**2 - 0.008**2) * 2e-4
    lost = sum(run[f"{cause}_dissipation"].values for cause in ("film", "leak")) * 1e-3
    half = lost.size // 2
    time = run["time"].values * 1e-3
    mean = (lost[-1] - lost[half]) / (time[-1] - time[half]) / volume
    assert float(run["heat"]) == pytest.approx(mean, rel=1e-2)
    assert float(settled["heat"]) == pytest.approx(float(run["heat"]), rel=1e-3)
    assert settled["heat"].attrs["units"] == "W/m^3"
    assert settled["heating"].attrs["units"] == "mK/s"
    assert float(settled["heating"]) == pytest.approx(1e3 * float(settled["heat"]) / 1.8e6, rel=1e-12)
    warmer = device.replace({"material.heat_capacity": "0.9 MJ/(m^3 K)"})
    assert warmer.scales.size("heating") == pytest.approx(2.0 * device.scales.size("heating"))
    assert not heats(PUMP.to_model().system)


class Sources:
    """Three films on two lines: 1 and 3 on the first, 2 on the second, whose source is constant."""

    lines = (SimpleNamespace(films=(0, 2)), SimpleNamespace(films=(1,)))
    waveform = SimpleNamespace(pieced=False)

    source_currents = ConeSystem.source_currents

    def currents(self, times, z, n):
        return [np.cos(times), 2.0 + np.sin(times), 3.0 * np.cos(times)]

    def source_voltages(self, times, z, n):
        first, second = 1.0 + 3.0 * np.sin(times), 5.0
        return [first, second, first]


def test_each_source_has_the_current_of_all_its_films_and_its_own_voltage():
    """The sum over the sources of the products of two root mean squares, one of them a constant."""
    times = 2.0 * np.pi * np.arange(64)[None] / 64
    members = MadeUp(system=Sources())
    found = apparent_power(
        members, sampled_evenly(times, np.zeros((1, 64, 2)), np.zeros((1, 2)), np.zeros(1), np.full(1, 7.0))
    )
    expected = np.sqrt(1.0 + 4.5) * 4.0 / np.sqrt(2.0) + 5.0 * np.sqrt(4.0 + 0.5)
    np.testing.assert_allclose(found, [expected], rtol=1e-12)


class Films:
    """Two films on one source, of which all is made up: of four members the second and the third lose next to nothing,
    and the voltage of the last jumps."""

    causes = ("source", "damper", "leak")
    films = (None, None)
    lines = (SimpleNamespace(films=(0, 1)),)
    waveform = SimpleNamespace(pieced=False)
    damper = np.array([[2.0], [1e-16], [-1e-16], [2.0]])

    source_currents = ConeSystem.source_currents

    def currents(self, times, z, n):
        return [3.0 * np.cos(times), -5.0 * np.cos(times)]

    def work(self, spans):
        return spans[:, None] * np.hstack([9.0 + 0.0 * self.damper, self.damper, 0.5 * self.damper])

    def source_voltages(self, times, z, n):
        return [np.sin(times), np.sin(times)]


def test_power_is_what_is_lost_heat_that_in_both_films_and_the_field_the_largest_of_either(monkeypatch):
    """Next to voltage times current a loss that is rounding is none."""
    times, system = 2.0 * np.pi * np.tile(np.arange(1, 65), (4, 1)) / 64, Films()
    field = np.where(np.arange(64) == 7, 8.0, 0.25) + 0.0 * times
    members = MadeUp(
        system=system, voltages=lambda times, states: [np.sin(times), np.sin(times)],
        film_states=lambda states, voltages: [SimpleNamespace(true_field=one) for one in (0.5 * field, field)],
    )  # fmt: skip
    lost = np.array([0.0, 0.0, 0.0, 4.0])
    asked = record(
        monkeypatch, module, lost_in_jumps=lost,
        largest=lambda members, path, value, **flow: value(members, path.times, path.states).max(axis=1),
        integrate=lambda members, begin, ends, **flow: SimpleNamespace(work=system.work(ends[:, 0])[:, None]),
    )  # fmt: skip
    found = module.electrical(members, times, np.zeros((4, 64, 2)), "begin", tolerance=2e-9)
    (ran,) = asked["integrate"]
    assert (ran["initial"], ran["keep"], ran["tolerance"]) == ("begin", "work", 2e-9)
    np.testing.assert_allclose(ran["times"], 2.0 * np.pi * np.ones((4, 1)))
    (call,) = asked["lost_in_jumps"]
    np.testing.assert_allclose(call["spans"], 2.0 * np.pi)
    assert (call["begin"], call["tolerance"]) == ("begin", 2e-9)
    assert [call["tolerance"] for call in asked["largest"]] == [2e-9, 2e-9]
    assert [call["path"].begin for call in asked["largest"]] == ["begin", "begin"]
    np.testing.assert_allclose(asked["largest"][0]["path"].end, 2.0 * np.pi)
    np.testing.assert_allclose(found["power"], [3.0, 0.0, 0.0, 3.0 + 4.0 / (2.0 * np.pi)])
    np.testing.assert_allclose(found["damper_power"], system.damper[:, 0])
    np.testing.assert_allclose(found["leak_power"], 0.5 * system.damper[:, 0], atol=1e-17)
    np.testing.assert_allclose(found["resistor_power"], lost / (2.0 * np.pi))
    np.testing.assert_allclose(found["film_power"], 0.0)
    np.testing.assert_allclose(found["heat"], 0.25 * system.damper[:, 0], atol=1e-17)
    np.testing.assert_allclose(found["heating"], found["heat"])
    np.testing.assert_allclose(found["field"], 8.0)
    np.testing.assert_allclose(found["current"], [2.0, 2.0, 2.0, np.inf])
    np.testing.assert_allclose(found["apparent_power"], [0.5 * 2.0, 1.0, 1.0, np.inf])


def test_the_size_of_currents_and_charges_counts_and_that_of_the_largest_source():
    times = np.array([[0.0, 1.0]])
    system = SimpleNamespace(
        source_currents=lambda *_: [np.array([[-3.0, 1.0]]), np.array([[2.0, 2.0]])],
        source_charges=lambda *_: [np.array([[1.0, -4.0]]), 0.5],
    )
    members = MadeUp(system=system)
    assert module.current_of(members, times, np.zeros((1, 2, 2))).tolist() == [[3.0, 2.0]]
    assert module.charge_of(members, times, np.zeros((1, 2, 2))).tolist() == [[1.0, 4.0]]


def test_a_source_without_voltage_gives_no_power():
    """What a free motion loses comes from no source: it was said to give -3e-19 pW."""
    model = gelcone.ConeModel(voltage=0.0, voltage_bias=0.0, damping_ratio=0.1, spring_stiffness=0.5, rest_height=0.4)
    begin = np.array([[0.6, 0.0]])
    times = np.linspace(0.0, 4.0 * np.pi, 65)[None]
    run = integrate(model.members(), begin, times)
    found = electrical(model.members(), times[:, 1:], run.states[:, 1:], begin)
    assert found["damper_power"][0] > 1e-4
    assert found["power"][0] == found["apparent_power"][0] == found["current"][0] == 0.0


def test_the_data_sheet_settled_and_a_run_give_one_current_of_a_source_with_two_films():
    device = gelcone.find_device("double-cone").replace(
        film="taut", second_film="taut", voltage_offset="800 V", second_hoop_prestretch=1.6, second_drive="same"
    )
    run, sheet = gelcone.simulate(device, periods=40), gelcone.datasheet(device)
    for name in ("peak_current", "apparent_power"):
        assert float(sheet[name]) == pytest.approx(float(run[name]), rel=0.01), name
    assert float(gelcone.settled(device)["current"]) == pytest.approx(float(sheet["peak_current"]), rel=1e-12)

"""The amplifier that ships, and films that leak: certified motions, powers, exponents; tangents; limits; SI fields."""

from types import SimpleNamespace

import numpy as np
import pytest

from gelcone.codes import FilmPullIn, Outcome
from gelcone.devices.device import Device, find_device
from gelcone.errors import InputError
from gelcone.motion.flow import integrate
from gelcone.motion.linear import linear_response
from gelcone.motion.lyapunov import lyapunov
from gelcone.motion.orbit import Kind, Shooting
from gelcone.motion.response import simulate
from gelcone.motion.settled import settled
from gelcone.motion.state_space import small_signal_response, state_space
from gelcone.physics.amplifier import ABSENT, ELECTRICS, Amplifier, with_electrics
from gelcone.physics.circuit import IdealSource, Port
from gelcone.physics.model import ConeModel
from tests.physics.film.test_branches import CERTIFIED, model_of

NAMES = {"rho": "series_resistance", "leak_time": "leakage_time", "leak_field": "leakage_field"}
NAMES |= {"chi": "dielectric_share", "debye_time": "dielectric_time"}
CASES = [case for case in CERTIFIED["cases"] if case["kind"] == "circuit"]
WRINKLED = {
    "film": "wrinkling",
    "series_resistance": 0.5,
    "voltage": 0.6,
    "drive_frequency": 0.4,
    "rest_height": 0.5,
    "damping_ratio": 0.02,
    "spring_stiffness": 0.9,
}
"""Crosses the borders of three states of tension in each period."""


def of_case(case):
    """The model of a certified case, with its circuit."""
    circuit = case["circuit"]
    given = {NAMES.get(name, name): value for name, value in circuit.items() if name not in ("kind", "limit")}
    if "limit" in circuit:
        given["slew_rate" if circuit["kind"] == "filter" else "current_limit"] = circuit["limit"]
    if circuit["kind"] == "charge":
        given["circuit"] = "charge"
    return model_of(case).replace(**given, **{"film": "wrinkling"} if case["film"]["wrinkles"] else {})


@pytest.mark.parametrize(
    "case",
    [pytest.param(case, marks=[pytest.mark.slow] * ("viscous" in case["name"])) for case in CASES],
    ids=[case["name"] for case in CASES],
)
def test_motions_and_works_are_the_certified_ones(case):
    rows = case["rows"]
    run = simulate(of_case(case), case["start"], times=[row["tau"] for row in rows])
    for name, of in {"displacement": "x", "velocity": "u", "film_voltage": "film_voltage"}.items():
        np.testing.assert_allclose(run[name], [row[of] for row in rows], atol=1e-12)
    works = [name for name in rows[0] if name.endswith("_dissipation") and name in run]
    for name, of in ({"supplied_energy": "source"} | {work: work for work in works}).items():
        np.testing.assert_allclose(run[name], [row[of] for row in rows], atol=2e-12)
    np.testing.assert_allclose(
        run["dissipated_energy"],
        [sum(v for k, v in row.items() if k.endswith("_dissipation")) for row in rows],
        atol=2e-12,
    )
    assert float(abs(run["energy_residual"]).max()) < 1e-12


@pytest.mark.parametrize("which", ["current_limit", "slew_rate"])
def test_times_at_a_limit_are_those_between_the_certified_borders(which):
    (case,) = (
        c for c in CASES if "limit" in c["circuit"] and (which == "slew_rate") == (c["circuit"]["kind"] == "filter")
    )
    end, borders = case["rows"][-1]["tau"], np.array([b[0] for b in case["borders"]])
    inside = borders[borders < end]
    edges = np.concatenate([[0.0], inside, [end]])
    states = ["unsaturated", *(b[1] for b in case["borders"][: inside.size])]
    at = sum(length for length, state in zip(np.diff(edges), states, strict=True) if state != "unsaturated")
    run = simulate(of_case(case), case["start"], times=[end])
    assert float(run["slew_limited" if which == "slew_rate" else "current_limited"]) == pytest.approx(
        at / end,
        abs=2e-4,  # between samples states are cubics, which do not know of the limit
    )
    peak = {"current_limit": "peak_current", "slew_rate": "peak_slew_rate"}[which]
    assert float(run[peak]) == pytest.approx(case["circuit"]["limit"], rel=1e-12)


def test_exponents_behind_a_resistance_are_the_certified_ones():
    case = CERTIFIED["exponents"][1]
    model = of_case(case | {"branches": [branch | {"c": 1.0} for branch in case["branches"]]})
    found = lyapunov(model, case["start"])
    np.testing.assert_allclose(found["lyapunov"], case["exponents"], atol=1e-9)
    assert abs(float(found["sum_residual"])) < 1e-12


def test_transfer_functions_are_the_certified_ones():
    found = CERTIFIED["transfer"][1]
    case, rows = found["case"], found["rows"]
    given = {f"viscous_modulus_{k}": modulus for k, (modulus, _) in enumerate(case["br"], 1)}
    given |= {f"relaxation_time_{k}": time for k, (_, time) in enumerate(case["br"], 1)}
    model = ConeModel(
        meridional_prestretch=case["lm"],
        hoop_prestretch=case["lh"],
        stretch_limit=case["J"],
        damping_ratio=case["zeta"],
        spring_stiffness=case["kappa"],
        rest_height=case["x0"],
        series_resistance=case["circ"]["rho"],
        leakage_time=case["circ"]["leak_time"],
        voltage_bias=case["v0"],
        voltage=1e-4,
        **given,
    )
    omega = np.array([row["omega"] for row in rows])
    gain = np.array([complex(*row["gain"]) for row in rows])
    small = small_signal_response(model, omega)
    np.testing.assert_allclose(small["gain"] * np.exp(1j * np.radians(small["phase"])), gain, atol=1e-11)
    np.testing.assert_allclose(linear_response(model, omega).harmonics[0] / 1e-4, gain, rtol=1e-7)


@pytest.mark.parametrize("modulus", [0.0, pytest.param(0.5, marks=pytest.mark.slow)])
def test_a_slack_film_pulls_in_where_its_voltage_turns(modulus):
    """A flat film lp = 1 without tension, V = (R + g) (t - t^-2)/t^2 and Q = v t^2, is charged through a resistance: it
    pulls in at the largest V, which the voltage touches and does not cross, after rho int dQ/(v_s - v). The branch g is
    as mounted."""
    resistance, command, begin = 0.4, 0.75 + 0.3 * modulus, 0.5
    t = np.linspace(1.0, 2.0, 400_001)
    squared = (t - t**-2) / t**2 * (1.0 / (1.0 - (2.0 * t + t**-2 - 3.0) / 50.0) + modulus)
    end = int(np.argmax(squared))
    voltage = np.sqrt(np.maximum(squared[: end + 1], 0.0))
    first = int(np.searchsorted(voltage, begin))
    assert voltage[first] == pytest.approx(begin, abs=1e-5)
    v, charge = voltage[first:], voltage[first:] * t[first : end + 1] ** 2
    wanted = resistance * float((np.diff(charge) / (command - 0.5 * (v[1:] + v[:-1]))).sum())
    model = ConeModel(film="wrinkling", voltage=0.0, voltage_bias=command, series_resistance=resistance)
    if modulus:
        model = model.replace(viscous_modulus_1=modulus, relaxation_time_1=1e9)
    run = integrate(model, [0.0, 0.0, *[1.0] * 2 * model.film.branches, v[0]], [1.5 * wanted])
    assert (run.outcome[0], run.pull_in[0, 0]) == (Outcome.PULLED_IN, FilmPullIn.MINIMUM)
    assert run.end_times[0] == pytest.approx(wanted, abs=2e-5)
    assert run.end_states[0, -1] == pytest.approx(voltage[-1], abs=1e-9)


# --- tangents ---------------------------------------------------------------------------------------------------------


def test_tangents_cross_the_borders_of_a_film_behind_a_resistance():
    """Where the film begins to wrinkle the rate of its voltage jumps; deviations are those of differences all the same,
    and their determinant is that of the mean trace."""
    model, times, start, step = ConeModel(**WRINKLED), np.array([3.0, 12.0]), np.array([1.0, 0.0, 0.0]), 1e-5
    run = integrate(model, start, times, keep="tangents")
    assert (run.film_times[0, 0, [0, 1, 3]] > 1.0).all()
    product = run.tangents[0, 1] @ run.tangents[0, 0]
    moved = [integrate(model, start + sign * step * row, times).states[0, -1] for row in np.eye(3) for sign in (1, -1)]
    difference = np.stack(
        [(up - down) / (2.0 * step) for up, down in zip(moved[::2], moved[1::2], strict=True)], axis=1
    )
    np.testing.assert_allclose(product, difference, atol=1e-7)
    assert run.divergence[0].sum() == pytest.approx(np.linalg.slogdet(product)[1], abs=1e-9)


def test_shooting_crosses_them_too():
    members = ConeModel(**WRINKLED).members()
    shooting = Shooting(members, ("voltage", "prestretch"), Kind(1), 4, 2.0 * np.pi)
    nodes, values, step = np.tile([1.0, 0.0, 0.1], (4, 1)), np.array([0.6, 1.0]), 1e-6
    found = shooting.run(nodes, values)
    tangents, slopes = found.tangents.copy(), found.slopes.copy()
    for k, row in enumerate(step * np.eye(2)):
        ahead, behind = (shooting.run(nodes, values + sign * row).ends.copy() for sign in (1.0, -1.0))
        np.testing.assert_allclose(slopes[..., k], (ahead - behind) / (2.0 * step), atol=1e-8)
    for k, row in enumerate(step * np.eye(3)):
        ahead, behind = (shooting.run(nodes + sign * row, values).ends.copy() for sign in (1.0, -1.0))
        np.testing.assert_allclose(tangents[..., k], (ahead - behind) / (2.0 * step), atol=1e-8)


# --- no circuit -------------------------------------------------------------------------------------------------------


def test_numbers_that_stand_for_none_give_the_ideal_source():
    plain = ConeModel()
    none = {"series_resistance": 0.0, "filter_time": 0, "leakage_time": np.inf, "leakage_field": np.inf}
    assert ConeModel(**none).system is plain.system
    one = plain.replace(series_resistance=0.2, leakage_time=9.0)
    assert one.system.circuit == Amplifier(("series_resistance", "leakage_time"))
    assert one.replace(series_resistance=0.0, leakage_time=np.inf).system is plain.system
    assert one.replace(circuit="ideal").parameters() == plain.parameters()
    again = ConeModel.from_parameters(one.parameters())
    assert again.system is one.system
    assert again.parameters() == one.parameters()
    assert ConeModel(circuit="amplifier").series_resistance == 0.03
    assert ConeModel(circuit="amplifier", filter_time=0.2).system.circuit.takes == ("filter_time",)
    assert isinstance(plain.system.circuit, IdealSource)


def test_a_small_resistance_comes_to_the_ideal_source():
    drive = {"voltage": 0.4, "drive_frequency": 0.6, "rest_height": 0.5}
    ideal = integrate(ConeModel(**drive), (0.6, 0.0), [20.0]).states[0, 0, 0]
    errors = []
    for rho in (0.02, 0.01):
        model = ConeModel(**drive, series_resistance=rho)
        errors.append(abs(integrate(model, (0.6, 0.0), [20.0]).states[0, 0, 0] - ideal))
    assert errors[0] / errors[1] == pytest.approx(2.0, abs=0.05)


def test_a_film_that_leaks_on_an_ideal_source_moves_as_one_that_does_not():
    drive = {"voltage": 0.4, "voltage_bias": 0.2, "drive_frequency": 0.6, "rest_height": 0.5}
    leaky, dry = (simulate(ConeModel(**drive, **more), (0.6, 0.0)) for more in ({"leakage_time": 7.0}, {}))
    assert (leaky["displacement"].values == dry["displacement"].values).all()
    leak = leaky["film_voltage"] * (1.0 + leaky["displacement"] ** 2) / 7.0
    np.testing.assert_allclose(leaky["current"] - dry["current"], leak, atol=1e-13)
    power = float((leaky["film_voltage"] * leak).integrate("time"))
    assert float(leaky["leak_dissipation"][-1]) == pytest.approx(power, rel=1e-3)
    assert float(abs(leaky["energy_residual"]).max()) < 1e-13


def test_both_films_of_a_double_cone_leak():
    given = {"voltage": 0.3, "voltage_bias": 0.4, "second_film": "taut", "series_resistance": 0.4, "leakage_time": 9.0}
    for drive in ("same", "opposite", "constant"):
        more = {"second_voltage": 0.5} if drive == "constant" else {}
        run = simulate(ConeModel(**given, second_drive=drive, **more), (0.3, 0.0), periods=2)
        assert float(abs(run["energy_residual"]).max()) < 1e-13
        assert float(run["second_current"].mean()) != 0.0
        assert ("second_peak_current" in run) == (drive != "same")


# --- what is refused --------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ({"current_limit": 0.3}, "current_limit: there is no series_resistance; give series_resistance, or leave"),
        ({"slew_rate": 0.3}, "slew_rate: there is no filter_time"),
        ({"leakage_field": 0.3}, "leakage_field: there is no leakage_time"),
        ({"series_resistance": [0.0, 0.1]}, "series_resistance = 0: must be greater than 0"),
        ({"series_resistance": -1.0}, "series_resistance = -1: must be greater than 0"),
        ({"series_resistance": 1.0, "current_limit": [np.inf, 1.0]}, "current_limit = inf: must be finite"),
        ({"series_resistance": np.nan}, "series_resistance = nan: must be a number"),
        ({"circuit": "charge", "series_resistance": 1.0}, "series_resistance"),
        ({"circuit": {"component": "amplifier", "takes": ["voltage"]}}, "'voltage' is not a parameter of an amplifier"),
    ],
)
def test_what_an_amplifier_cannot_be_is_refused(given, message):
    with pytest.raises(InputError, match=message):
        ConeModel(**given)


# --- devices ----------------------------------------------------------------------------------------------------------

FIELDS = {
    "filter_frequency": "1 kHz",
    "slew_rate": "10 V/us",
    "series_resistance": "1 MOhm",
    "current_limit": "0.5 mA",
    "material.resistivity": "1 GOhm m",
    "material.resistivity_field": "17 MV/m",
}


def test_a_device_has_an_amplifier_in_si_units():
    device = find_device("biased-pump").replace(FIELDS, film="wrinkling")
    model, scales = device.to_model(), device.scales
    capacitance, permittivity = scales.size("capacitance"), 4.77 * 8.8541878188e-12
    assert model.series_resistance == pytest.approx(1e6 * capacitance / scales.time, rel=1e-12)
    assert model.filter_time == pytest.approx(1.0 / (2.0 * np.pi * 1e3) / scales.time, rel=1e-12)
    assert model.slew_rate == pytest.approx(1e7 * scales.time / scales.voltage, rel=1e-12)
    assert model.current_limit == pytest.approx(5e-4 / (capacitance * scales.voltage / scales.time), rel=1e-12)
    assert model.leakage_time == pytest.approx(permittivity * 1e9 / scales.time, rel=1e-9)
    assert model.leakage_field == pytest.approx(17e6 / scales.field, rel=1e-12)
    assert Device.from_text(device.to_toml()) == device
    run = simulate(device, periods=5)
    assert float(run["peak_current"]) <= 0.5 * (1.0 + 1e-12)
    assert run["peak_current"].units == "mA"
    assert run["peak_slew_rate"].units == "V/ms"
    swept = simulate(device.replace(series_resistance=["1 MOhm", "3 MOhm"]), periods=5)
    assert float(swept["peak_current"][0]) == float(run["peak_current"])


def test_a_device_without_electric_fields_is_as_it_was():
    device = find_device("biased-pump")
    assert device.replace(series_resistance=0.0).to_model().parameters() == device.to_model().parameters()


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"current_limit": "1 mA"}, "current_limit: there is no series_resistance"),
        ({"slew_rate": "1 V/us"}, "slew_rate: there is no filter_frequency"),
        ({"material.resistivity_field": "17 MV/m"}, "resistivity_field: there is no resistivity"),
        ({"series_resistance": "1 kV"}, "kV is a unit of voltage, not of resistance"),
        ({"series_resistance": "-1 MOhm"}, "series_resistance = '-1 MOhm': must be at least 0 ohm"),
        ({"circuit": "charge", "series_resistance": "1 MOhm"}, "series_resistance: the circuit 'charge' does not take"),
        ({"bandwidth": "1 kHz"}, "did you mean 'filter_frequency'"),
    ],
)
def test_wrong_fields_are_refused_in_a_line(changes, message):
    with pytest.raises(InputError, match=message) as raised:
        find_device("biased-pump").replace(changes)
    assert len(str(raised.value).splitlines()) == 1


def test_the_membrane_behind_a_resistance_balances_to_the_fit_of_its_charge():
    """Its charge in a program is a fit: the balance is what that leaves, and the leak is that of the same charge."""
    run = simulate(find_device("biased-pump").replace(series_resistance="1 MOhm"), periods=10)
    assert 0.0 < float(abs(run["energy_residual"]).max()) < 1e-3 * float(run["supplied_energy"][-1])


def test_settled_motion_and_linear_theory_of_a_device_with_an_amplifier():
    device = find_device("biased-pump").replace(FIELDS, film="wrinkling", voltage_amplitude="10 V")
    found = settled(device)
    assert float(found["stroke"]) == pytest.approx(float(found["linear_stroke"]), rel=0.01)
    ideal = find_device("biased-pump").replace(film="wrinkling", voltage_amplitude="10 V")
    assert float(found["stroke"]) < 0.995 * float(settled(ideal)["stroke"])


# --- a permittivity that follows late ---------------------------------------------------------------------------------

LATE = {"dielectric_share": 0.4, "dielectric_time": 3.0, "voltage": 0.7, "voltage_bias": 0.2, "rest_height": 0.4}


def test_the_field_of_what_follows_late_pulls_with_its_own_voltage():
    """Stresses under (1 - chi) v^2 + chi w^2, the field under v; and without the delay those of the film."""
    run = simulate(ConeModel(**LATE, damping_ratio=0.1), times=[7.0, 20.0])
    q = 1.0 + run["displacement"] ** 2
    v, w = run["film_voltage"], run["slow_charge"] / q
    assert float(abs(v - w).min()) > 0.05
    elastic = simulate(ConeModel(damping_ratio=0.1), times=[7.0])
    assert "slow_charge" not in elastic
    film = ConeModel().film
    expected = film.state(
        run["displacement"].values, np.sqrt(0.6 * v**2 + 0.4 * w**2).values, [], ConeModel().numbers()
    )
    np.testing.assert_allclose(run["meridional_stress"], expected.meridional_stress, atol=1e-13)
    np.testing.assert_allclose(run["true_field"], abs(v) * np.sqrt(q), atol=1e-13)
    assert np.isfinite(run["energy_residual"]).all()
    assert np.abs(run["energy_residual"]).max() < 1e-12


def test_jumps_charge_only_what_follows_at_once():
    square = {"waveform": "square", "rise": 0.0, "drive_frequency": 0.5, "damping_ratio": 0.1}
    run = simulate(ConeModel(**LATE, **square), times=np.linspace(0.0, 40.0, 41))
    assert float(np.abs(run["energy_residual"]).max()) < 1e-11
    assert float(run["resistor_dissipation"][-1]) > 0.1


def test_exponents_with_a_late_permittivity_add_up_to_the_trace():
    found = lyapunov(ConeModel(**LATE, damping_ratio=0.1, series_resistance=0.4), (0.4, 0.0))
    assert found.sizes["exponent"] == 4
    assert abs(float(found["sum_residual"])) < 1e-9


def test_the_gain_of_a_flat_film_is_that_of_its_linear_model():
    """Filter, resistance, leak and a late permittivity; a small voltage does not raise a flat disc."""
    numbers = {"filter_time": 0.2, "series_resistance": 0.4, "leakage_time": 5.0, **LATE, "rest_height": 0.0}
    model = ConeModel(damping_ratio=0.1, **numbers)
    found = state_space(model, outputs=("film_voltage",))
    for omega in (0.0, 0.05, 0.7, 6.0):
        inside = np.linalg.solve(1j * omega * np.eye(len(found.A)) - found.A, found.B)
        linear = (found.C @ inside + found.D)[0, 0]
        assert model.system.circuit.gain(omega, model.numbers()) == pytest.approx(linear, rel=1e-9)


def test_a_number_that_stands_for_none_is_none():
    nothing = {name: ABSENT.get(name, np.inf) for name in ELECTRICS}
    assert set(ABSENT.values()) == {0.0}
    assert set(ABSENT) == {"filter_time", "series_resistance", "dielectric_share"}
    assert ConeModel(**nothing).system.circuit == IdealSource()


def test_a_film_at_a_voltage_of_its_own_leaks_as_the_other_does():
    takes = ("series_resistance", "leakage_time", "leakage_field")
    assert Amplifier(takes).held == Amplifier(takes[1:])
    assert Amplifier(takes[:1]).held == IdealSource()


def test_a_late_permittivity_has_si_fields():
    pump = find_device("biased-pump").replace(film="taut")
    late = pump.replace({"material.dielectric_share": 0.3, "material.dielectric_time": "0.1 s"}).to_model()
    assert late.values["dielectric_share"] == 0.3
    assert late.values["dielectric_time"] == pytest.approx(0.1 / pump.scales.time, rel=1e-12)
    assert pump.replace({"material.dielectric_share": None}).to_model().system.circuit == IdealSource()


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ({"dielectric_share": 1.0, "dielectric_time": 2.0}, "must be below 1"),
        ({"dielectric_share": 0.3}, "there is no dielectric_time"),
        ({**LATE, "film": "wrinkling"}, "only a single taut film"),
        ({**LATE, "second_film": "taut"}, "only a single taut film"),
    ],
)
def test_a_late_permittivity_that_cannot_be_is_refused(given, message):
    with pytest.raises(InputError, match=message):
        ConeModel(**given)


# --- the amplifier by its formulas ------------------------------------------------------------------------------------

ELECTRIC = {
    "filter_time": 0.4, "slew_rate": 1.5, "series_resistance": 0.3, "current_limit": 0.8, "leakage_time": 5.0,
    "leakage_field": 0.9, "dielectric_share": 0.35, "dielectric_time": 2.5,
}  # fmt: skip
TAKEN = [
    ("series_resistance",),
    ("filter_time",),
    ("filter_time", "series_resistance", "leakage_time"),
    ("filter_time", "slew_rate", "series_resistance", "current_limit", "leakage_time"),
    ("series_resistance", "dielectric_share", "dielectric_time"),
    ("filter_time", "series_resistance", "leakage_time", "dielectric_share", "dielectric_time"),
    ("leakage_time", "leakage_field"),
    tuple(ELECTRIC),
]


class Plain:
    """A film of the capacitance 1 + x^2."""

    film, words = SimpleNamespace(linear_charge=True, borders=(), name="plain"), "the film"

    def capacitance(self, x, squared, y, n, xp):
        return 1.0 + x * x + 0.0 * squared

    def fitted_capacitance(self, x, squared, y, n):
        return self.capacitance(x, squared, y, n, np)

    def rates(self, x, velocity, squared, y, n, xp):
        return []


def port_of(command=0.7, x=0.0, u=0.0, rate=0.0):
    return Port(command, np.asarray(x), np.asarray(u), lambda: rate, ((Plain(), []),), {}, np)


def amplifier(takes, reduced=False):
    """It, and its numbers for values of `ELECTRIC`; what is within its limits has its switches at 1."""
    circuit = Amplifier(takes, reduced)
    given = {name: ELECTRIC[name] for name in takes} | ({"series_resistance": 0.004} if reduced else {})
    return circuit, circuit.numbers(circuit.complete(given))


@pytest.mark.parametrize("takes", TAKEN, ids="+".join)
def test_rates_of_an_amplifier_are_those_of_its_parts(takes):
    """v' follows from (1 - chi) (C v)' + chi (C w)' = i - leak with i and y' within their limits, by hand."""
    circuit, n = amplifier(takes)
    x, u, command = 0.6, 0.4, 1.3
    area, by_x = 1.0 + x * x, 2.0 * x
    y = [0.5, 0.25, 0.9][: len(circuit.states)]
    known = dict(zip([state.name for state in circuit.states], y, strict=True))
    port = port_of(command, x, u)
    own = {**n, **circuit.switches(port, y, n)}
    source = known.get("amplifier_voltage", command)
    v = known.get("film_voltage", source)
    assert circuit.source_voltage(port, y, own) == source
    assert circuit.voltage(port, y, own) == v
    wanted = {}
    if "filter_time" in takes:
        wanted["amplifier_voltage"] = (command - source) / 0.4
        if "slew_rate" in takes:
            wanted["amplifier_voltage"] = np.clip(wanted["amplifier_voltage"], -1.5, 1.5)
    leak = 0.0
    if "leakage_time" in takes:
        field = v * np.sqrt(area)
        volts = 0.9 * np.sinh(field / 0.9) / np.sqrt(area) if "leakage_field" in takes else v
        leak = area * volts / 5.0
    assert circuit.leaks(port, y, own) == [pytest.approx(leak)]
    slow = (area * v - known["slow_charge"]) / 2.5 if circuit.delays else 0.0
    share = 0.35 if circuit.delays else 0.0
    if circuit.delays:
        wanted["slow_charge"] = slow
        late = known["slow_charge"] / area
        assert circuit.squared(port, v, y, own) == pytest.approx((1.0 - share) * v * v + share * late * late)
        assert circuit.stored(port, v, y, own) == pytest.approx((1.0 - share) * area * v + share * known["slow_charge"])
    through = (source - v) / 0.3
    if "current_limit" in takes:
        through = np.clip(through, -0.8, 0.8)
    if circuit.carries_voltage:
        at_once = (through - leak - share * slow) / (1.0 - share)
        wanted["film_voltage"] = (at_once - by_x * u * v) / area
    rates = dict(zip(known, circuit.rates(port, y, own), strict=True))
    assert {name: float(rate) for name, rate in rates.items()} == {k: pytest.approx(w) for k, w in wanted.items()}
    current = through - leak if circuit.carries_voltage else 0.2
    through = through if circuit.carries_voltage else 0.2 + leak
    lost = {"resistor": (source - v) * through, "leak": v * leak, "dielectric": share * 2.5 * slow**2 / area}
    powers = circuit.powers(port, current, y, own)
    assert {k: float(p) for k, p in powers.items()} == {
        "source": pytest.approx(source * through), **{k: pytest.approx(lost[k]) for k in circuit.losses}
    }  # fmt: skip


@pytest.mark.parametrize(
    ("takes", "reduced"), [*((takes, False) for takes in TAKEN[:-2]), *((TAKEN[k], True) for k in (0, 2))]
)
def test_the_gain_of_an_amplifier_is_that_of_its_linear_rates(takes, reduced):
    """H = c (i w - A)^-1 (b + i w b') + d + i w d' of a flat film within the limits."""
    takes = tuple(name for name in takes if name not in ("slew_rate", "current_limit"))
    circuit, n = amplifier(takes, reduced)
    size = len(circuit.states)

    def at(command, rate, y):
        port = port_of(command, rate=rate)
        return np.array([float(value) for value in [*circuit.rates(port, y, n), circuit.voltage(port, y, n)]])

    unit = np.eye(size)
    by_command, by_rate = at(1.0, 0.0, [0.0] * size), at(0.0, 1.0, [0.0] * size)
    by_states = np.array([at(0.0, 0.0, list(row)) for row in unit]).reshape(size, size + 1).T
    for w in (0.0, 0.3, 2.0):
        states = np.linalg.solve(1j * w * unit - by_states[:size], by_command[:size] + 1j * w * by_rate[:size])
        exact = by_states[size] @ states + by_command[size] + 1j * w * by_rate[size]
        assert complex(circuit.gain(w, n)) == pytest.approx(exact, rel=1e-12)


def test_borders_and_excess_of_an_amplifier_say_on_which_side_of_its_limits_it_is():
    circuit, n = amplifier(TAKEN[3])
    sides = {"slew_rate_above": 1.0, "slew_rate_below": 1.0, "current_limit_above": 1.0, "current_limit_below": 1.0}
    rows = [
        (1.3, [0.9, 0.8], {}),
        (1.6, [0.9, 0.8], {"slew_rate_above": -1.0}),
        (0.2, [0.9, 0.8], {"slew_rate_below": -1.0}),
    ]
    rows += [(0.9, [0.9, 0.6], {"current_limit_above": -1.0}), (0.9, [0.9, 1.2], {"current_limit_below": -1.0})]
    for command, y, changed in rows:
        port = port_of(command)
        assert circuit.switches(port, y, n) == sides | changed
        own = {**n, **sides, **changed}
        values = {str(border.switch): border.value(port, y, own, np) for border in circuit.borders}
        assert all(value > 0.0 for value in values.values())
        wanted = {"slew_rate": (command - y[0]) / 0.4, "current_limit": (y[0] - y[1]) / 0.3}
        limits = {"slew_rate": 1.5, "current_limit": 0.8}
        excess = {name: pytest.approx(abs(wanted[name]) - limits[name]) for name in limits}
        assert dict(circuit.saturations(port, y, own)) == excess
        scale = {"slew_rate": 0.4, "current_limit": 0.3}
        for name in limits:
            assert abs(values[f"{name}_above"]) == pytest.approx(scale[name] * abs(limits[name] - wanted[name]))
            assert abs(values[f"{name}_below"]) == pytest.approx(scale[name] * abs(limits[name] + wanted[name]))


def test_an_amplifier_is_as_slow_as_its_slowest_state_and_jumps_where_nothing_filters():
    for takes, slowest, jumps in [
        (TAKEN[0], 0.3, False), (TAKEN[1], 0.4, False), (TAKEN[4], 2.5, False), (TAKEN[6], 0.0, True),
    ]:  # fmt: skip
        circuit, n = amplifier(takes)
        assert (float(circuit.time_constant(n)), circuit.jumps) == (slowest, jumps)
    reduced, n = amplifier(("series_resistance",), reduced=True)
    assert (float(reduced.time_constant(n)), reduced.jumps, reduced.states) == (0.0, True, ())
    assert Amplifier(tuple(ELECTRIC)).held == Amplifier(("leakage_time", "leakage_field"))
    assert Amplifier(("series_resistance",)).held == IdealSource()
    with pytest.raises(InputError, match=r"dielectric_share = 1: must be below 1"):
        Amplifier(TAKEN[4]).complete({**ELECTRIC, "dielectric_share": np.array([0.2, 1.0])})
    with pytest.raises(InputError, match=r"series_resistance = 0.02 \(times C0 Omega0\): without a state"):
        Amplifier(reduced=True).complete({"series_resistance": np.array([0.001, 0.02])})


def test_what_stands_for_none_takes_the_parameter_away_and_with_it_what_is_reduced():
    """A number of an array that stands for none does not: the others are a value of each member."""
    given = {"series_resistance": 0.0, "voltage": 0.3}
    assert with_electrics("ideal", given, True) == (IdealSource(), {"voltage": 0.3})
    assert with_electrics("amplifier", given) == (IdealSource(), {"voltage": 0.3})
    assert with_electrics("amplifier", {"voltage": 0.3}) == (Amplifier(), {"voltage": 0.3})
    assert with_electrics("ideal", {"voltage": 0.3}) == (IdealSource(), {"voltage": 0.3})
    circuit, rest = with_electrics("ideal", {"leakage_time": np.array([np.inf, 3.0])})
    assert circuit == Amplifier(("leakage_time",))
    np.testing.assert_array_equal(rest["leakage_time"], [np.inf, 3.0])
    given = Amplifier(("series_resistance", "leakage_time"))
    assert with_electrics(given, {"series_resistance": 0.0}) == (Amplifier(("leakage_time",)), {})
    assert with_electrics(given, {}) == (given, {})
    small = Amplifier(reduced=True)
    assert with_electrics(small, {"leakage_time": 3.0})[0] == Amplifier(("series_resistance", "leakage_time"), True)
    assert with_electrics(small, {"series_resistance": 0.001}, False)[0] == Amplifier()
    table = {"component": "amplifier", "takes": ["filter_time"]}
    assert with_electrics(table, {"series_resistance": 0.2})[0] == Amplifier(("filter_time", "series_resistance"))
    with pytest.raises(InputError, match="reduced: the circuit 'charge' has no series_resistance"):
        with_electrics("charge", {}, True)


def test_what_takes_the_voltage_on_the_film_as_a_state_is_refused_without_that_state():
    for more in (("current_limit",), ("dielectric_share", "dielectric_time")):
        with pytest.raises(
            InputError, match=rf"^{more[0]}: takes the voltage on the film as a state; leave it or reduced out"
        ):
            Amplifier(("series_resistance", *more), reduced=True)

"""Maxwell branches: certified motions, works, exponents and transfer functions; one energy; limits; what is refused."""

import json
from pathlib import Path

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from gelcone.codes import FilmPullIn, Outcome
from gelcone.devices.device import find_device
from gelcone.errors import InputError
from gelcone.motion.flow import integrate
from gelcone.motion.linear import linear_response
from gelcone.motion.lyapunov import lyapunov
from gelcone.motion.response import simulate
from gelcone.motion.start import start_states
from gelcone.motion.state_space import small_signal_response, state_space
from gelcone.physics.film.branches import Branches, branches_of
from gelcone.physics.film.taut import TautCone
from gelcone.physics.model import ConeModel
from gelcone.physics.statics import rest_displacement
from tests.toys import PowerFilm, SeriesResistor

CERTIFIED = json.loads((Path(__file__).parents[2] / "reference" / "viscous.json").read_text())
TAUT = [case for case in CERTIFIED["cases"] if case["kind"] == "film" and not case["film"]["wrinkles"]]


def model_of(case):
    """The model of a certified case."""
    film, bias, wave = case["film"], case["bias"], case["wave"]
    given = {"damping_ratio": case["zeta"], "meridional_prestretch": film["lm"], "hoop_prestretch": film["lh"]}
    if film["law"] == "yeoh":
        given |= {"law": "yeoh", "yeoh_c2": film["c2"], "yeoh_c3": film["c3"]}
    else:
        given["stretch_limit"] = film["J"]
    for k, branch in enumerate(case["branches"], 1):
        given |= {f"viscous_modulus_{k}": branch["g"], f"relaxation_time_{k}": branch["tau"]}
        given |= {f"viscous_limit_{k}": branch["J"], "flow_exponent": int(branch["c"])}
        given |= {"flow_stress": branch["s0"]} if branch["c"] > 1 else {}
    if "b1" in bias:
        given |= {"bias": "beam", "beam_stiffness": bias["b1"], "beam_cubic": bias["b3"], "beam_height": bias["xb"]}
    else:
        given |= {"spring_stiffness": bias["kappa"], "rest_height": bias["x0"]}
    if wave["kind"] == "constant":
        return ConeModel(**given, voltage=0.0, voltage_bias=wave["v"])
    return ConeModel(**given, voltage=wave["v"], voltage_bias=wave["v0"], drive_frequency=wave["omega"])


# --- certified numbers ------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("case", TAUT, ids=[case["name"] for case in TAUT])
def test_motions_and_works_are_the_certified_ones(case):
    rows = case["rows"]
    run = simulate(model_of(case), case["start"], times=[row["tau"] for row in rows])
    for name, of in (("displacement", "x"), ("velocity", "u")):
        np.testing.assert_allclose(run[name], [row[of] for row in rows], atol=3e-11)
    for k in range(len(case["branches"])):
        for name, of, pre in (("meridional", "ln_xi1", "lm"), ("hoop", "ln_xi2", "lh")):
            own = -0.5 * np.log(run[f"viscous_{name}_{k + 1}"].values) + np.log(case["film"][pre])
            np.testing.assert_allclose(own, [row[f"{of}_{k}"] for row in rows], atol=1e-12)
    np.testing.assert_allclose(run["supplied_energy"], [row["source"] for row in rows], atol=3e-12)
    works = ("film_dissipation", "damper_dissipation") if case["zeta"] else ("film_dissipation",)
    for name in works:
        np.testing.assert_allclose(run[name], [row[name] for row in rows], atol=3e-12)
    assert float(abs(run["energy_residual"]).max()) < 1e-12


def test_the_linear_flow_of_the_published_vhb_is_the_certified_one():
    found = CERTIFIED["linear_flow"][0]
    case, rows = found["case"], found["rows"]
    amplitude, omega, bias = case["wave"]
    given = {"voltage": amplitude, "drive_frequency": omega, "voltage_bias": bias, "flow": "linear"}
    for k, (modulus, time) in enumerate(case["br"], 1):
        given |= {f"viscous_modulus_{k}": modulus, f"relaxation_time_{k}": time}
    model = ConeModel(
        meridional_prestretch=case["lm"],
        hoop_prestretch=case["lh"],
        stretch_limit=case["J"],
        damping_ratio=case["zeta"],
        spring_stiffness=case["kappa"],
        rest_height=case["x0"],
        **given,
    )
    run = simulate(model, case["start"], times=case["times"])
    names = {"displacement": "x", "velocity": "u", "viscous_meridional_1": "a1_0", "viscous_thickness_3": "a3_2"}
    for name, of in {**names, "film_dissipation": "film_dissipation"}.items():
        np.testing.assert_allclose(run[name], [row[of] for row in rows], atol=1e-11)
    assert float(abs(run["energy_residual"]).max()) < 1e-12


@pytest.mark.parametrize("film", ["taut", "wrinkling"])
def test_steps_heed_what_linear_flow_loses(film):
    """D holds 1/E, whose poles the motion does not have: at a fast branch of a film let go from a height they are near,
    and the balance of energies, in which the loss is an integral of its own, does not close where steps pass them."""
    model = ConeModel(film=film, flow="linear", viscous_modulus_1=1.2, relaxation_time_1=0.08, rest_height=0.5)
    run = simulate(model, (1.2, 0.0), times=[0.5, 4.0])
    assert float(run["film_dissipation"][0]) > 0.3
    assert float(abs(run["energy_residual"]).max()) < 1e-12


def test_exponents_of_a_periodic_motion_are_the_certified_ones():
    case = CERTIFIED["exponents"][1]
    circuit = {"circuit": SeriesResistor(), "series_resistance": 0.5, "leakage_time": 8.0}
    model = model_of(case | {"branches": [branch | {"c": 1.0} for branch in case["branches"]]}).replace(**circuit)
    found = lyapunov(model, case["start"])
    assert int(found["cycle"]) == 1
    np.testing.assert_allclose(found["lyapunov"], case["exponents"], atol=1e-9)
    assert abs(float(found["sum_residual"])) < 1e-12


@pytest.mark.parametrize("flow", ["log", "linear"])
@pytest.mark.parametrize("which", [0, 1])
def test_transfer_functions_are_the_certified_ones(which, flow):
    found = CERTIFIED["transfer"][which]
    case, rows = found["case"], found["rows"]
    given = {"voltage_bias": case["v0"], "voltage": 1e-4, "flow": flow}
    for k, (modulus, time) in enumerate(case["br"], 1):
        given |= {f"viscous_modulus_{k}": modulus, f"relaxation_time_{k}": time}
    if case["circ"]:
        given |= {"circuit": SeriesResistor(), "series_resistance": case["circ"]["rho"]}
        given |= {"leakage_time": case["circ"]["leak_time"]}
    model = ConeModel(
        meridional_prestretch=case["lm"],
        hoop_prestretch=case["lh"],
        stretch_limit=case["J"],
        damping_ratio=case["zeta"],
        spring_stiffness=case["kappa"],
        rest_height=case["x0"],
        **given,
    )
    omega = np.array([row["omega"] for row in rows])
    gain = np.array([complex(*row["gain"]) for row in rows])
    small = small_signal_response(model, omega)
    np.testing.assert_allclose(small["gain"] * np.exp(1j * np.radians(small["phase"])), gain, atol=1e-11)
    # of a drive with an amplitude of 1e-4 the mean squares differ by its square
    np.testing.assert_allclose(linear_response(model, omega).harmonics[0] / 1e-4, gain, rtol=1e-7)
    own = np.linalg.eigvals(state_space(model).A)
    for eigenvalue in found["eigenvalues"]:
        assert np.abs(own - complex(*eigenvalue)).min() < 1e-8


STATICS = [row for row in CERTIFIED["statics"] if any(row[at]["state"] == "taut" for at in ("settled", "at_once"))]


@pytest.mark.parametrize("row", STATICS, ids=[f"x={row['x']}, v={row['v']}" for row in STATICS])
def test_static_forces_are_the_certified_ones(row):
    given = {f"viscous_modulus_{k}": branch["g"] for k, branch in enumerate(row["branches"], 1)}
    given |= {f"viscous_limit_{k}": float(branch["J"]) for k, branch in enumerate(row["branches"], 1)}
    stretches = {"meridional_prestretch": row["lm"], "hoop_prestretch": row["lh"]}
    model = ConeModel(spring_stiffness=0.0, stretch_limit=row["J"], **stretches, **given)
    if row["settled"]["state"] == "taut":
        assert model.force(row["x"], row["v"]) == pytest.approx(float(row["settled"]["force"]), abs=1e-14)
    if row["at_once"]["state"] == "taut":
        at_once = model.film.force(row["x"], row["v"] ** 2, [1.0] * len(model.film.states), model.own_numbers)[0]
        assert at_once == pytest.approx(float(row["at_once"]["force"]), abs=1e-14)


# --- one energy -------------------------------------------------------------------------------------------------------

EVERY = pytest.mark.parametrize(
    "choice", [{}, {"flow_exponent": 3, "flow_stress": 0.4}, {"flow": "linear"}], ids=["log", "exponent 3", "linear"]
)


def film_of(choice):
    """A film of two branches, its numbers, and states away from rest."""
    limits = {} if choice.get("flow") == "linear" else {"viscous_limit_1": 6.0}
    moduli = {"viscous_modulus_1": 0.6, "viscous_modulus_2": 1.1, "relaxation_time_1": 0.7}
    model = ConeModel(prestretch=1.2, stretch_limit=9.0, **moduli, **limits, **choice)
    return model.film, model.own_numbers, [0.7, 1.15, 0.9, 1.3]


@EVERY
def test_force_stress_and_dissipation_are_those_of_one_energy(choice):
    film, n, y = film_of(choice)
    x, h = 0.8, 1e-5

    def stored(x, y):
        return float(film.work(x, 0.0, y, n))

    force, slope = film.force(x, 0.0, y, n)
    assert force == pytest.approx((stored(x + h, y) - stored(x - h, y)) / (2.0 * h), rel=1e-9)
    ahead, behind = (film.force(x + s * h, 0.0, y, n)[0] for s in (1.0, -1.0))
    assert slope == pytest.approx((ahead - behind) / (2.0 * h), rel=1e-8)
    assert film.state(x, 0.0, y, n).meridional_stress * x / (1.0 + x * x) == pytest.approx(force, rel=1e-13)
    lost = 0.0
    for i, rate in enumerate(film.rates(x, 0.3, 0.0, y, n)):
        step = h * np.eye(4)[i]
        lost -= rate * (stored(x, list(y + step)) - stored(x, list(y - step))) / (2.0 * h)
    assert film.dissipation(x, 0.3, 0.0, y, n) == pytest.approx(lost, rel=1e-8)
    assert lost > 0.0


@EVERY
def test_the_relaxed_film_is_the_elastic_one(choice):
    """Statics, and the states p1 = 1/q, p2 = 1 (linear: a1 = 1/q, a3 = q) at which nothing flows."""
    film, n, _ = film_of(choice)
    x = 0.8
    q = 1.0 + x * x
    relaxed = [1.0 / q, q if choice.get("flow") == "linear" else 1.0] * 2
    elastic = ConeModel(prestretch=1.2, stretch_limit=9.0)
    for y in ([], relaxed):
        assert film.force(x, 0.3, y, n)[0] == pytest.approx(elastic.film.force(x, 0.3, [], n)[0], rel=1e-14)
        assert film.state(x, 0.5, y, n).hoop_stress == pytest.approx(elastic.film_state(x, 0.5).hoop_stress, rel=1e-14)
    np.testing.assert_allclose(film.rates(x, 0.0, 0.3, relaxed, n), 0.0, atol=1e-15)
    assert film.dissipation(x, 0.0, 0.3, relaxed, n) == pytest.approx(0.0, abs=1e-30)


def test_fast_branches_are_a_kelvin_voigt_film():
    """Force 4 g tau x^2 x'/q^2, with an error of second order in tau at a fixed modulus."""
    base = ConeModel(rest_height=0.5, voltage=0.3, drive_frequency=0.6, damping_ratio=0.02)
    n, times = base.own_numbers, np.linspace(1.0, 10.0, 10)

    errors = []
    for tau in (0.02, 0.01):
        model = base.replace(viscous_modulus_1=0.5, relaxation_time_1=tau)
        x = integrate(model, (0.6, 0.0, 1.0 / 1.36, 1.0), times).states[0, :, 0]

        def right(t, z, n=n, tau=tau):
            q = 1.0 + z[0] ** 2
            h = base.law.film_stiffness(q, n["A"], n["B"], n["G"], n)[0] - (0.3 * np.sin(0.6 * t)) ** 2
            drag = 4.0 * 0.5 * tau * z[0] ** 2 * z[1] / q**2
            return [z[1], -0.04 * z[1] - z[0] * h - 1.5 * (z[0] - 0.5) - drag]

        found = solve_ivp(right, (0.0, 10.0), [0.6, 0.0], method="DOP853", t_eval=times, rtol=1e-11, atol=1e-13)
        errors.append(np.abs(found.y[0] - x).max())
    assert errors[1] < 0.35 * errors[0] < 1e-4


def test_slow_branches_stay_as_they_were_mounted():
    slow = ConeModel(rest_height=0.5, viscous_modulus_1=0.8, relaxation_time_1=1e9, viscous_limit_1=20.0)
    x = integrate(slow, (0.9, 0.0), [30.0]).states[0]
    np.testing.assert_allclose(x[0, 2:], 1.0, atol=1e-7)


# --- what components see ----------------------------------------------------------------------------------------------


def test_slack_sees_the_stress_of_the_branches():
    """A film let go from a height is slack along its meridian once it has crept there, at rising voltage or none."""
    model = ConeModel(rest_height=0.0, spring_stiffness=0.9, viscous_modulus_1=2.0, relaxation_time_1=0.5, voltage=0.0)
    run = simulate(model, (1.2, 0.0), times=np.linspace(0.0, 2.0, 201))
    q = 1.0 + run["displacement"].values ** 2
    p1, p2 = run["viscous_meridional_1"].values, run["viscous_hoop_1"].values
    own = 2.0 * (p1 * q - 1.0 / (p1 * p2 * q))
    elastic = model.film.ring_state(q, 1.0, 0.0, model.own_numbers).meridional_stress
    np.testing.assert_allclose(run["meridional_stress"], elastic + own, atol=1e-13)
    slack = run["meridional_slack"].values
    assert (slack == (elastic + own < 0.0)).all()
    assert 0.1 < float(run["validity_meridional_slack"]) < 0.9
    assert (elastic >= 0.0).all()


def test_the_limit_of_a_branch_counts():
    film, n, _ = film_of({})
    y = [1.0, 1.0, 1.0, 1.0]
    x = 1.5
    q = 1.0 + x * x
    assert film.limit_share(x, 0.0, y, n) == pytest.approx(
        max((q + 1.0 / q - 2.0) / 6.0, film.limit_share(x, 0.0, [], n))
    )
    assert film.limit_share(x, 0.0, y, n) > film.limit_share(x, 0.0, [], n)


def test_a_start_beyond_the_limit_of_a_branch_is_refused():
    model = ConeModel(viscous_modulus_1=0.5, viscous_limit_1=0.9, stretch_limit=9.0)
    with pytest.raises(
        InputError, match=r"initial displacement 1\.5: stretches a Maxwell branch beyond its viscous_limit"
    ):
        simulate(model, (1.5, 0.0), periods=1)
    both = integrate(model, [1.5, 0.0, 1.0, 1.0], [1.0]).outcome[0], integrate(model, (0.6, 0.0), [1.0]).outcome[0]
    assert both == (Outcome.OUTSIDE, Outcome.OK)
    assert integrate(model, [1.5, 0.0, 0.4, 1.0], [1.0]).outcome[0] == Outcome.OK
    mixed = model.replace(viscous_limit_1=[0.9, 9.0])
    assert simulate(mixed, (1.5, 0.0), periods=1)["outcome"].values.tolist() == [Outcome.OUTSIDE, Outcome.OK]


def test_both_films_of_a_double_cone_creep():
    model = ConeModel(
        viscous_modulus_1=0.5, relaxation_time_1=3.0, second_film="taut", second_flat_height=0.4, voltage=0.2
    )
    names = [state.name for state in model.system.states][2:]
    assert names == ["viscous_meridional_1", "viscous_hoop_1", "second_viscous_meridional_1", "second_viscous_hoop_1"]
    run = simulate(model, (0.3, 0.0), periods=2)
    assert float(abs(run["energy_residual"]).max()) < 1e-13
    assert float(run["film_dissipation"][-1]) > 1e-4


# --- names ------------------------------------------------------------------------------------------------------------


def test_a_model_has_the_branches_of_which_it_has_numbers():
    assert ConeModel().film.branches == 0
    one = ConeModel(viscous_modulus_1=0.5)
    three = one.replace(relaxation_time_3=20.0)
    assert (one.film.branches, three.film.branches, three.viscous_modulus_1) == (1, 3, 0.5)
    again = ConeModel.from_parameters(three.replace(flow="linear").parameters())
    assert again.film == TautCone(branches=3, flow="linear")
    assert three.replace(law="yeoh").film.branches == 3
    assert three.replace(branches=0).system == ConeModel().system


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ({"branches": 4}, "branches = 4: must be a whole number from 0 to 3"),
        ({"branches": 1, "flow": "exp"}, "'exp' is not a flow; known: log, linear"),
        ({"branches": 1, "flow_exponent": 2}, "flow_exponent = 2: must be an odd whole number"),
        ({"branches": 1, "flow_exponent": 3, "flow": "linear"}, "only the logarithmic flow takes one"),
        ({"viscous_modulus_1": 0.5, "film": PowerFilm(1.1)}, "branches: the film 'power film' does not take it"),
        ({"viscous_modulus_1": -0.5}, "viscous_modulus_1 = -0.5: must be at least 0"),
    ],
)
def test_what_branches_cannot_be_is_refused(given, message):
    with pytest.raises(InputError, match=message):
        ConeModel(**given)
    assert Branches(0, "log", 1, True).states == ()


@pytest.mark.parametrize("film", ["taut", "wrinkling"])
@pytest.mark.parametrize("flow", ["log", "linear"])
def test_a_film_that_has_rested_where_it_starts_stays_there(film, flow):
    """The rest of a device: relaxed branches do not flow, and the disc does not move; one mounted flat creeps."""
    given = {"viscous_modulus_1": 0.8, "relaxation_time_1": 2.0, "flow": flow, "film": film}
    model = ConeModel(rest_height=0.6, prestretch=1.2, voltage=0.0, **given)
    place = rest_displacement(model)
    moved = integrate(model, (place, 0.0), [3.0]).states[0, 0, 0] - place
    held = integrate(model.replace(rested="raised"), (place, 0.0), [3.0]).states[0, 0, 0] - place
    assert abs(held) < 1e-12 < 1e-4 < abs(moved)


def test_a_device_creeps_in_si_units_and_has_rested_where_it_waits():
    film = {"component": "taut", "branches": 2, "viscous_modulus_1": 0.5, "relaxation_time_1": "0.6 s"}
    device = find_device("biased-pump").replace(film=film)
    model = device.to_model()
    assert model.relaxation_time_1 == pytest.approx(0.6 / device.scales.time, rel=1e-12)
    assert (model.film.branches, model.film.rested) == (2, "raised")
    assert "it creeps: 2 Maxwell branches, logarithmic flow" in model.film.describe()
    x = device.initial_state()[0]
    assert start_states(model, (x, 0.0))[0, 2] == pytest.approx(1.0 / (1.0 + x * x))


# --- a film that wrinkles ---------------------------------------------------------------------------------------------


def test_the_energy_of_a_long_run_across_borders_balances_behind_a_resistance():
    model = ConeModel(film="wrinkling", rest_height=0.4, hoop_prestretch=1.1, voltage=0.3, voltage_bias=0.2).replace(
        damping_ratio=0.05, viscous_modulus_1=0.5, relaxation_time_1=8.0, series_resistance=0.1
    )
    run = simulate(model, (0.8, 0.0), times=np.linspace(0.0, 1000.0, 501))
    assert int(run["outcome"]) == Outcome.OK
    assert len(np.unique(run["film_state"])) > 1
    assert float(run["supplied_energy"][-1]) > 0.1
    assert float(abs(run["energy_residual"]).max()) < 1e-11


WRINKLING = [case for case in CERTIFIED["cases"] if case["kind"] == "film" and case["film"]["wrinkles"]]


@pytest.mark.parametrize("case", WRINKLING, ids=[case["name"] for case in WRINKLING])
def test_motions_across_borders_are_the_certified_ones(case):
    """Through all four states of tension, with the lengths of the film, its losses and what the source gives."""
    rows, film = case["rows"], case["film"]
    run = simulate(model_of(case).replace(film="wrinkling"), case["start"], times=[row["tau"] for row in rows])
    for name, of in (("displacement", "x"), ("velocity", "u")):
        np.testing.assert_allclose(run[name], [row[of] for row in rows], atol=1e-11)
    for name, of, pre in (("meridional_stretch", "m", "lm"), ("hoop_stretch", "n", "lh")):
        np.testing.assert_allclose((run[name] / film[pre]) ** 2, [row[of] for row in rows], atol=1e-11)
    for name, of in (("supplied_energy", "source"), *[(f"{of}_dissipation",) * 2 for of in ("film", "damper")]):
        np.testing.assert_allclose(run[name], [row[of] for row in rows], atol=1e-11)
    assert float(abs(run["energy_residual"]).max()) < 1e-12
    kinds = {"hoop": "hoop_slack", "meridional": "meridional_slack"}
    states = [run["film_state"].attrs["flag_meanings"].split()[int(k)] for k in run["film_state"].values]
    assert states == [kinds.get(row["state"], row["state"]) for row in rows]


def test_times_in_each_state_are_those_between_the_certified_borders():
    case = WRINKLING[0]
    end = case["rows"][-1]["tau"]
    run = simulate(model_of(case).replace(film="wrinkling"), case["start"], times=[end])
    kinds = {"taut": "taut", "hoop": "hoop_slack", "meridional": "meridional_slack", "crumpled": "crumpled"}
    spent, last, state = dict.fromkeys(kinds, 0.0), 0.0, "taut"
    for tau, before, after in [*case["borders"], [end, None, None]]:
        if tau > end:
            break
        assert before in (state, None)
        spent[state] += tau - last
        last, state = tau, after
    if state is not None:
        spent[state] += end - last
    for name, kind in kinds.items():
        assert float(run[f"film_state_{kind}"]) == pytest.approx(spent[name] / end, abs=1e-10)


@pytest.mark.parametrize("case", [case for case in WRINKLING if "end" in case], ids=lambda case: case["name"])
def test_a_raised_disc_localises_late(case):
    model = model_of(case).replace(film="wrinkling")
    run = integrate(model, case["start"], [2.0 * case["end"][0]])
    assert run.end_times[0] == pytest.approx(case["end"][0], abs=1e-9)
    np.testing.assert_allclose(run.end_states[0, :2], [case["end_state"]["x"], case["end_state"]["u"]], atol=1e-10)
    assert (run.outcome[0], run.pull_in[0, 0]) == (Outcome.PULLED_IN, FilmPullIn.LOCALISATION)


@pytest.mark.parametrize("case", CERTIFIED["delays"], ids=lambda case: f"{case['prestretch']}, {case['v']}")
def test_between_two_thresholds_a_film_at_rest_pulls_in_late(case):
    """Certified by a quadrature with 34 digits; the run ends less than 1e-6 before."""
    given = {"prestretch": float(case["prestretch"]), "prestretch_mode": "equibiaxial", "film": "wrinkling"}
    for k, branch in enumerate(case["branches"], 1):
        given |= {f"viscous_modulus_{k}": float(branch["g"]), f"relaxation_time_{k}": float(branch["tau"])}
        given |= {f"viscous_limit_{k}": float(branch["J"])}
    model = ConeModel(stretch_limit=float(case["J"]), voltage=0.0, voltage_bias=float(case["v"]), **given)
    run = integrate(model, (0.0, 0.0), [2.0 * float(case["time"])])
    assert run.end_times[0] == pytest.approx(float(case["time"]), abs=1e-7, rel=1e-8)
    assert (run.outcome[0], run.pull_in[0, 0]) == (Outcome.PULLED_IN, FilmPullIn.MINIMUM)


@pytest.mark.parametrize("row", CERTIFIED["statics"], ids=lambda row: f"x={row['x']}, v={row['v']}")
def test_lengths_and_forces_at_once_are_the_certified_ones(row):
    given = {f"viscous_modulus_{k}": branch["g"] for k, branch in enumerate(row["branches"], 1)}
    given |= {f"viscous_limit_{k}": float(branch["J"]) for k, branch in enumerate(row["branches"], 1)}
    stretches = {"meridional_prestretch": row["lm"], "hoop_prestretch": row["lh"]}
    model = ConeModel(film="wrinkling", spring_stiffness=0.0, stretch_limit=row["J"], **stretches, **given)
    film, n, at_once = model.film, model.own_numbers, row["at_once"]
    y = [1.0] * len(film.states)
    assert film.force(row["x"], row["v"] ** 2, y, n)[0] == pytest.approx(float(at_once["force"]), abs=1e-13)
    state = film.state(row["x"], row["v"], y, n)
    assert (state.meridional_stretch / row["lm"]) ** 2 == pytest.approx(float(at_once["m"]), rel=1e-13)
    assert (state.hoop_stretch / row["lh"]) ** 2 == pytest.approx(float(at_once["n"]), rel=1e-13)
    settled = row["settled"]
    if settled["state"] in ("taut", "hoop", "meridional"):
        assert model.force(row["x"], row["v"]) == pytest.approx(float(settled["force"]), abs=1e-13)


@pytest.mark.slow
def test_exponents_of_a_wrinkling_film_add_up_to_the_mean_trace():
    case = WRINKLING[0]
    found = lyapunov(model_of(case).replace(film="wrinkling"), case["start"], budget=2000.0, tolerance=1e-10)
    assert abs(float(found["sum_residual"])) < 1e-8
    assert found["lyapunov"].size == 4


def test_the_slowest_creep_of_a_soft_film_is_slower_than_its_slowest_relaxation():
    """A weight on an element of springs 1 and g and a dashpot g tau creeps with (1 + g) tau; so does the film flat."""
    model = ConeModel(film=TautCone(branches=2), **{"viscous_modulus_1": 3.0, "relaxation_time_1": 2.0})
    two = model.replace(viscous_modulus_2=0.5, relaxation_time_2=5.0)
    assert float(two.members().time_constant[0]) == pytest.approx(8.0)


# --- formulas ---------------------------------------------------------------------------------------------------------


def numbers(branches, **given):
    own = {name: given.get(name, quantity.default) for name, quantity in branches.parameters.items()}
    return branches.numbers(own)


THREE = {
    "viscous_modulus_1": 0.5, "viscous_modulus_2": 0.9, "viscous_modulus_3": 0.2, "relaxation_time_1": 0.01,
    "relaxation_time_2": 4.0, "relaxation_time_3": 0.015,
}  # fmt: skip


@pytest.mark.parametrize("taut", [True, False])
@pytest.mark.parametrize("flow", ["log", "linear"])
def test_nothing_flows_and_nothing_is_lost_where_branches_have_relaxed(flow, taut):
    branches = Branches(2, flow, 1, taut)
    n = numbers(branches, viscous_modulus_1=0.5, viscous_modulus_2=0.3, relaxation_time_2=1.0)
    m, width = 1.7, 1.0 if taut else 1.3
    y = branches.relaxed(m, width)
    assert len(y) == len(branches.states)
    np.testing.assert_allclose(branches.rates(m, width, y, n), 0.0, atol=1e-15)
    np.testing.assert_allclose(branches.stresses(m, width, y, n), 0.0, atol=1e-15)
    assert branches.dissipation(m, width, y, n) == pytest.approx(0.0, abs=1e-30)
    assert branches.energy(m, width, y, n) == pytest.approx(0.0, abs=1e-15)


@pytest.mark.parametrize("flow", ["log", "linear"])
def test_the_free_length_is_the_longest_at_which_a_branch_carries_nothing_along_it(flow):
    branches = Branches(2, flow, 1, True)
    n = numbers(branches, viscous_modulus_1=0.5, viscous_modulus_2=0.3)
    y = [0.6, 1.2, 0.8, 0.9]
    longest = branches.free_length(y)
    each = []
    for k in (0, 1):
        one = Branches(1, flow, 1, True)
        own, of = y[2 * k : 2 * k + 2], numbers(one, viscous_modulus_1=0.5)
        each.append(one.free_length(own))
        assert one.stresses(each[-1], 1.0, own, of)[0] == pytest.approx(0.0, abs=1e-14)
        assert one.stresses(1.01 * each[-1], 1.0, own, of)[0] > 0.0
    assert longest == max(each)
    assert branches.stresses(1.01 * longest, 1.0, y, n)[0] > 0.0


def test_reduced_branches_drag_and_have_neither_states_nor_stiffness():
    """4 g tau x^2/q^2 of each; those with states count for stiffness and for the time to settle."""
    branches = Branches(3, "log", 1, True, (1, 3))
    n = numbers(branches, **THREE)
    x = np.array([-0.7, 0.3, 1.4])
    viscosity = 0.5 * 0.01 + 0.2 * 0.015
    np.testing.assert_allclose(branches.drag(x, n), 4.0 * viscosity * x**2 / (1.0 + x**2) ** 2, rtol=1e-14)
    assert branches.modulus(n) == 0.9
    assert branches.time_constant(n) == pytest.approx(1.9 * 4.0)
    assert [state.name for state in branches.states] == ["viscous_meridional_2", "viscous_hoop_2"]
    assert Branches(2, "log", 1, True, (1, 2)).time_constant(n) == 0.0
    assert len(branches.relaxed(1.3, 1.0)) == 2
    assert "3 Maxwell branches, logarithmic flow, 2 of them without states as damper" in branches.words


def test_a_reduced_branch_relaxes_faster_than_its_bound_in_every_member():
    branches = Branches(3, "log", 1, True, (1, 3))
    branches.check(THREE)
    for name, times in (("relaxation_time_1", [0.001, 0.02]), ("relaxation_time_3", [0.03, 0.001])):
        with pytest.raises(InputError, match=rf"^{name} = {max(times)} \(times Omega0\): .* below 0\.02"):
            branches.check(THREE | {name: np.array(times)})
    branches.check(THREE | {"relaxation_time_2": 100.0})


def test_a_number_of_a_branch_is_one_by_its_whole_name():
    assert branches_of(["viscous_modulus_2", "relaxation_time_1", "voltage"]) == 2
    assert branches_of(["viscous_modulus_2_of", "second_relaxation_time_1", "viscous_modulus_0", "flow_stress"]) == 0


def test_a_branch_without_states_is_fast_where_its_time_is_not_given():
    model = ConeModel(film="taut", viscous_modulus_1=0.5, reduced="relaxation_time_1")
    assert (model.relaxation_time_1, len(model.system.states)) == (0.01, 2)
    assert ConeModel(film="taut", viscous_modulus_1=0.5).relaxation_time_1 == 10.0

"""The cone model: its equation of motion proved from its energy, certified numbers, exact facts, and its contracts."""

import json
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
import sympy
from cone_energy import dissipation, electric_energy, lagrangian
from heyoka_backend import functions
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

from gelcone.errors import InputError
from gelcone.physics import model
from gelcone.physics.amplifier import ELECTRICS, NEEDS
from gelcone.physics.bias import BIASES
from gelcone.physics.drive import VOLTAGE
from gelcone.physics.film.taut import TautCone
from gelcone.physics.laws import LAWS, Gent
from gelcone.physics.model import PARAMETERS, ConeModel
from gelcone.physics.waveforms import WAVEFORMS
from tests.toys import PowerFilm

SYMBOLIC = SimpleNamespace(log1p=lambda z: sympy.log(1 + z), sqrt=sympy.sqrt, sin=sympy.sin, cos=sympy.cos)
REFERENCE = json.loads((Path(__file__).parents[1] / "reference" / "trajectories.json").read_text())
every_law = pytest.mark.parametrize("law", LAWS.values(), ids=LAWS)
every_case = pytest.mark.parametrize("case", REFERENCE, ids=[f"case{i}" for i in range(len(REFERENCE))])


def exact(expression):
    """The expression over one denominator, multiplied out, its decimal numbers taken as fractions."""
    numerator, denominator = sympy.fraction(sympy.together(sympy.nsimplify(expression, rational=True)))
    return sympy.expand(numerator) / denominator


def symbols_of(system):
    """A symbol for each number that the formulas take."""
    return {name: sympy.Symbol(name, positive=True) for name in system.numbers}


# --- the equation of motion follows from the energy -------------------------------------------------------------------


@every_law
def test_euler_lagrange_of_the_energy_is_the_acceleration_exactly(law):
    """d/dt dL/dx' - dL/dx + dD/dx' = 0, solved for x'', with a biased drive and a rest height; and its slope in x."""
    t = sympy.Symbol("t", positive=True)
    x, u = sympy.symbols("x u", real=True)
    path = sympy.Function("X")(t)
    system = ConeModel(law=law).system
    n = symbols_of(system)
    voltage = n["voltage_bias"] + n["voltage"] * sympy.sin(n["drive_frequency"] * t)
    L = lagrangian(x, u, voltage, n, system.film, system.bias, SYMBOLIC)
    along = {x: path, u: path.diff(t)}
    momentum = sympy.diff(L, u).subs(along)
    forces = sympy.diff(L, x) - sympy.diff(dissipation(u, n), u)
    equation = sympy.nsimplify(sympy.diff(momentum, t) - forces.subs(along), rational=True)
    assert sympy.diff(equation, path.diff(t, 2)) == 1
    motion = (path.diff(t, 2) - equation).subs(path.diff(t), u).subs(path, x)
    assert not motion.has(path.func, sympy.Derivative)
    rates, jacobian = system.flow(t, [x, u], n, SYMBOLIC)
    assert rates[0] == u
    assert exact(motion - rates[1]) == 0
    assert exact(sympy.diff(motion, x) - jacobian[1][0]) == 0
    assert exact(sympy.diff(motion, u) - jacobian[1][1]) == 0
    assert jacobian[0] == [0.0, 1.0]


@every_law
def test_heyokas_euler_lagrange_agrees_with_the_compiled_closed_form(law):
    hk = pytest.importorskip("heyoka")
    x, u = hk.make_vars("x", "u")
    system = ConeModel(law=law).system
    xp = functions()
    n = {name: hk.par[i] for i, name in enumerate(system.numbers)}
    voltage = system.waveform.voltage(hk.time, n, xp)
    energy = lagrangian(x, u, voltage, n, system.film, system.bias, xp)
    equations = hk.lagrangian(energy, [x], [u], dissipation(u, n))
    velocity, motion = (right for _, right in equations)
    rates, jacobian = system.flow(hk.time, [x, u], n, xp)
    acceleration, slope = rates[1], jacobian[1][0]
    function = hk.cfunc([velocity, motion, hk.diff(motion, x), acceleration, slope], vars=[x, u])

    rng = np.random.default_rng(6)
    for _ in range(200):
        m, displacement = random_model(rng, law)
        n = m.own_numbers
        point = np.array([displacement, rng.normal()])
        pars = np.array([n[name] for name in m.system.numbers], dtype=float)
        time = rng.uniform(0.0, 50.0)
        out = function(point, pars=pars, time=time)
        volts = m.system.waveform.voltage(time, n)
        rates, jacobian = m.system.flow(time, point, n)
        # Terms cancel: compare on the scale of the largest one.
        h, h_slope = law.film_stiffness(1.0 + displacement**2, n["A"], n["B"], n["G"], n)
        kappa, rest, zeta = n["spring_stiffness"], n["rest_height"], n["damping_ratio"]
        stiffness_scale = abs(h) + kappa + volts**2 + 2.0 * displacement**2 * abs(h_slope) + 1.0
        force_scale = stiffness_scale * (abs(displacement) + abs(rest)) + 2.0 * zeta * abs(point[1])
        assert out[0] == point[1]
        assert abs(out[1] - out[3]) <= 1e-13 * force_scale
        assert abs(out[2] - out[4]) <= 2e-13 * stiffness_scale
        assert abs(out[3] - rates[1]) <= 1e-13 * force_scale
        assert abs(out[4] - jacobian[1][0]) <= 2e-13 * stiffness_scale


def random_model(rng, law):
    """A member drawn at random and a displacement within 80 % of its stretch limit."""
    x = rng.uniform(-2.0, 2.0)
    stretch = {"meridional_prestretch": rng.uniform(0.7, 1.5), "hoop_prestretch": rng.uniform(0.7, 1.5)}
    reached = ConeModel(law="neo-hookean", **stretch).strain(np.array([0.0, x])).max()
    own = {
        name: reached / rng.uniform(0.02, 0.8) if name == "stretch_limit" else rng.uniform(0.0, 0.3)
        for name in law.parameters
    }
    return ConeModel(
        damping_ratio=rng.uniform(0.0, 0.5),
        spring_stiffness=rng.uniform(0.0, 3.0),
        voltage=rng.uniform(0.0, 3.0),
        voltage_bias=rng.uniform(-1.0, 1.0),
        drive_frequency=rng.uniform(0.2, 5.0),
        rest_height=rng.uniform(-1.0, 1.0),
        law=law,
        **own,
        **stretch,
    ), x


def test_gents_equation_of_motion_is_the_papers_exactly():
    """x'' + 2 zeta x' + kappa (x - x0) + x (A - G/q^2)/(1 - (I1-3)/J) - v^2 x = 0, and its form with one division."""
    x, u, v, J = sympy.symbols("x u v J", positive=True)
    law = LAWS["gent"]
    system = ConeModel(law=law).system
    n = symbols_of(system) | law.numbers({"stretch_limit": J})
    kappa, rest, A, B, G = (n[name] for name in ("spring_stiffness", "rest_height", "A", "B", "G"))
    acceleration = system.under(v, [x, u], n).rates()[1]
    q = 1 + x**2
    film = x * (A - G / q**2) / (1 - system.film.strain(x, n) / J)
    assert exact(acceleration + 2 * n["damping_ratio"] * u + kappa * (x - rest) + film - v**2 * x) == 0
    M = q * (J + 3 - B) - A * q**2 - G
    one_division = x * J * (A * q**2 - G) / (q * M)
    assert exact(film - one_division) == 0


def test_the_strain_is_that_of_the_stretches():
    """I1 - 3 of l1 = lm sqrt(q), l2 = lh, l3 = 1/(l1 l2), in symbols and through the model's own pre-stretches."""
    x, lm, lh = sympy.symbols("x lm lh", positive=True)
    l1, l2 = lm * sympy.sqrt(1 + x**2), lh
    stretched = l1**2 + l2**2 + 1 / (l1 * l2) ** 2 - 3
    n = {"A": lm**2, "B": lh**2, "G": 1 / (lm * lh) ** 2}
    assert exact(ConeModel().film.strain(x, n) - stretched) == 0
    for kwargs, pair in (
        ({}, (1.0, 1.0)),
        ({"prestretch": 1.2}, (1.0, 1.2)),
        ({"prestretch": 1.2, "prestretch_mode": "equibiaxial"}, (1.2, 1.2)),
        ({"meridional_prestretch": 0.8, "hoop_prestretch": 1.3}, (0.8, 1.3)),
        ({"meridional_prestretch": 0.8}, (0.8, 1.0)),
        ({"hoop_prestretch": 1.3}, (1.0, 1.3)),
    ):
        m = ConeModel(**kwargs)
        assert m.stretches == pair
        expected = float(stretched.subs({x: 0.7, lm: pair[0], lh: pair[1]}))
        assert m.strain(0.7) == pytest.approx(expected, rel=1e-14, abs=1e-15)


# --- elimination of the electric displacement -------------------------------------------------------------------------


def test_the_stationary_electric_displacement_leaves_the_voltage_term():
    x, v, D = sympy.symbols("x v D", real=True)
    q = 1 + x**2
    energy = sympy.nsimplify(electric_energy(x, v, SYMBOLIC, displacement=D), rational=True)
    stationary = sympy.solve(sympy.diff(energy, D), D)
    assert len(stationary) == 1
    assert sympy.simplify(stationary[0] - v * sympy.sqrt(q)) == 0
    assert sympy.diff(energy, D, 2) == 1  # a minimum, and the only stationary point
    assert sympy.simplify(energy.subs(D, stationary[0]) + v**2 * q / 2) == 0
    assert exact(electric_energy(x, v, SYMBOLIC) + v**2 * q / 2) == 0


def test_the_electric_energy_is_that_of_the_si_device():
    """D^2/(2 eps) over the film's volume less the work Phi Q, Q = D * (deformed area), in units of mu Vol."""
    x = sympy.Symbol("x", real=True)
    d, phi, eps, mu, H, area = sympy.symbols("d Phi epsilon mu H S", positive=True)
    slant = sympy.sqrt(1 + x**2)
    volume = area * H
    D = d * sympy.sqrt(eps * mu)
    si = (D**2 / (2 * eps) * volume - phi * D * area * slant) / (mu * volume)
    v = phi * sympy.sqrt(eps / mu) / H
    assert exact(electric_energy(x, v, SYMBOLIC, displacement=d) - si) == 0
    deformed_thickness = volume / (area * slant)
    assert sympy.simplify((v * slant) * sympy.sqrt(eps * mu) - eps * phi / deformed_thickness) == 0


@settings(deadline=None)
@given(st.floats(-3.0, 3.0), st.floats(-3.0, 3.0), st.floats(-2.0, 2.0))
def test_no_other_displacement_has_less_energy(x, v, away):
    lowest = electric_energy(x, v)
    other = electric_energy(x, v, displacement=v * np.sqrt(1.0 + x * x) + away)
    assert other - lowest == pytest.approx(0.5 * away * away, rel=1e-9, abs=1e-12)


# --- certified numbers ------------------------------------------------------------------------------------------------


def reference_model(case):
    p = {name: float(value) for name, value in case["parameters"].items()}
    return ConeModel(
        damping_ratio=p["zeta"],
        spring_stiffness=p["k"],
        voltage=p["v"],
        drive_frequency=p["omega"],
        stretch_limit=p["J"],
        meridional_prestretch=p["meridional"],
        hoop_prestretch=p["hoop"],
        rest_height=p["rest"],
    )


@every_case
def test_static_force_and_energy_have_the_certified_values(case):
    m = reference_model(case)
    x, force, energy = np.array(case["static"], dtype=float).T
    np.testing.assert_allclose(m.force(x), force, rtol=1e-12)
    np.testing.assert_allclose(m.energy(x) - m.energy(0.0), energy, rtol=1e-12)


@every_case
def test_the_acceleration_integrates_to_the_certified_trajectory(case):
    m = reference_model(case)

    def flow(tau, state):
        return m.system.rates(tau, state, m.own_numbers)

    tau, x, u = np.array(case["trajectory"]).T
    initial = np.array(case["initial"], dtype=float)
    run = solve_ivp(flow, (0.0, tau[-1]), initial, "DOP853", t_eval=tau, rtol=1e-13, atol=1e-14)
    assert run.success
    np.testing.assert_allclose(run.y, [x, u], rtol=1e-9)


def test_the_certified_cases_cover_pre_stretch_and_voltage():
    assert len(REFERENCE) >= 4
    assert {case["parameters"]["meridional"] for case in REFERENCE} > {"1"}
    assert len({case["parameters"]["v"] for case in REFERENCE}) >= 3


# --- force, energy and stiffness --------------------------------------------------------------------------------------


@st.composite
def members(draw, **fixed):
    """A random member of any law, with a displacement at which its film is below 90 % of the stretch limit."""
    law = draw(st.sampled_from(sorted(LAWS)))
    x = draw(st.floats(-3.0, 3.0))
    stretch = {name: draw(st.floats(0.5, 2.0)) for name in ("meridional_prestretch", "hoop_prestretch")}
    neo = ConeModel(law="neo-hookean", **stretch)
    if law == "gent":
        reached = max(float(neo.strain(np.array([0.0, x])).max()), 1e-3)
        own = {"stretch_limit": draw(st.one_of(st.just(np.inf), st.floats(1.1, 1e4).map(lambda r: r * reached)))}
    else:
        own = {name: draw(st.floats(0.0, 0.5)) for name in LAWS[law].parameters}
    numbers = {"spring_stiffness": draw(st.floats(0.0, 5.0)), "rest_height": draw(st.floats(-1.0, 1.0))}
    return ConeModel.from_parameters({"law": law, **own, **stretch, **numbers, **fixed}), x


def potential(m, x, volts):
    """Energy written without the model's methods, so that it takes a complex x."""
    n = m.own_numbers
    film = m.law.energy(m.film.strain(x, n), n)
    return film + m.system.bias.energy(x, n) + electric_energy(x, volts)


def scale(m, x):
    """Size of the terms that add up to the force and the stiffness, to judge their difference by.

    The strain is a difference of numbers of order A q + B + G/q + 3, which the wall magnifies.
    """
    n = m.own_numbers
    q = 1.0 + x * x
    response = float(m.law.response(m.strain(x), n))
    size = float(n["A"] * q + n["B"] + n["G"] + 3.0)
    near_wall = 1.0 + size / float(m.strain_limit()) * response
    return (size * response * (1.0 + size) * near_wall + float(m.spring_stiffness) + 9.0) * (1.0 + abs(x))


@settings(max_examples=100, deadline=None)
@given(members(), st.floats(0.0, 3.0))
def test_the_force_is_the_slope_of_the_energy_and_the_stiffness_the_slope_of_the_force(member, volts):
    m, x = member
    step = 1e-30
    tolerance = 1e-13 * scale(m, x)
    assert abs(m.energy(x) - potential(m, x, 0.0).real - electric_energy(x, 0.0)) <= tolerance
    assert abs(m.force(x, volts) - np.imag(potential(m, x + 1j * step, volts)) / step) <= tolerance
    force = -m.system.under(volts, [x + 1j * step, 0.0], m.own_numbers).rates()[1]
    assert abs(m.force(x, volts) - force.real) <= tolerance
    assert abs(m.stiffness(x, volts) - force.imag / step) <= 30.0 * tolerance


@every_law
def test_the_force_is_the_central_difference_of_the_energy(law):
    """Through the public methods alone: the difference quotient's error falls with the square of its step."""
    rng = np.random.default_rng(7)
    for _ in range(20):
        m, x = random_model(rng, law)
        error = []
        for h in (2e-3, 1e-3):
            error.append((m.energy(x + h) - m.energy(x - h)) / (2.0 * h) - m.force(x))
        extrapolated = (4.0 * error[1] - error[0]) / 3.0
        assert abs(extrapolated) <= 1e-6 * (1.0 + abs(m.force(x)))


@settings(deadline=None)
@given(members(rest_height=0.0), st.floats(0.0, 3.0))
def test_without_rest_height_the_cone_is_symmetric(member, volts):
    m, x = member
    assert m.force(-x, volts) == -m.force(x, volts)
    assert m.force(0.0, volts) == 0.0
    assert m.energy(-x) == m.energy(x)
    assert m.stiffness(-x, volts) == m.stiffness(x, volts)


@settings(deadline=None)
@given(members(), st.floats(-3.0, 3.0))
def test_the_rest_height_adds_a_constant_force(member, volts):
    m, x = member
    flat = m.replace(rest_height=0.0)
    expected = flat.force(x, volts) - m.spring_stiffness * m.rest_height
    assert m.force(x, volts) == pytest.approx(expected, rel=1e-12, abs=1e-14 * scale(m, x))
    assert m.stiffness(x, volts) == flat.stiffness(x, volts)


@settings(deadline=None)
@given(members(rest_height=0.0), st.floats(0.0, 3.0))
def test_the_small_signal_stiffness(member, volts):
    """kappa + (A - G)/(1 - (A + B + G - 3)/J) - v^2; other laws have their response in place of the fraction."""
    m, _ = member
    A, B = m.meridional_prestretch**2, m.hoop_prestretch**2
    G = 1.0 / (A * B)
    e = A + B + G - 3.0
    if m.law.name == "gent":
        response = 1.0 / (1.0 - e / m.stretch_limit)
    else:
        c2, c3 = (m.values.get(name, 0.0) for name in ("yeoh_c2", "yeoh_c3"))
        response = 1.0 + 2.0 * c2 * e + 3.0 * c3 * e * e
    expected = m.spring_stiffness + (A - G) * response - volts**2
    assert abs(m.stiffness(0.0, volts) - expected) <= 1e-13 * scale(m, 0.0)


@settings(deadline=None)
@given(st.floats(0.01, 9.0), st.floats(0.5, 1e3), st.sampled_from(["gent", "neo-hookean"]))
def test_without_pre_stretch_the_pitchfork_is_at_the_root_of_the_spring_stiffness(kappa, limit, law):
    own = {"stretch_limit": limit} if law == "gent" else {}
    m = ConeModel(spring_stiffness=kappa, law=law, **own)
    threshold = np.sqrt(kappa)
    assert m.stiffness(0.0, threshold * (1.0 - 1e-9)) > 0.0 > m.stiffness(0.0, threshold * (1.0 + 1e-9))


@pytest.mark.parametrize("kwargs", [{}, {"prestretch": 1.2}, {"prestretch": 1.1, "prestretch_mode": "equibiaxial"}])
def test_beyond_the_pitchfork_a_double_well_appears_and_no_other_equilibrium(kwargs):
    m = ConeModel(stretch_limit=5.0, **kwargs)
    threshold = float(np.sqrt(m.stiffness(0.0)))
    x = np.linspace(1e-3, 2.0, 4001)
    x = x[m.strain(x) < m.stretch_limit]
    assert (m.force(x, 0.99 * threshold) > 0.0).all()
    beyond = 1.05 * threshold
    assert np.count_nonzero(np.diff(np.sign(m.force(x, beyond)))) == 1
    well = brentq(lambda at: m.force(at, beyond), x[0], x[-1])
    assert m.stiffness(well, beyond) > 0.0 > m.stiffness(0.0, beyond)
    assert m.force(-well, beyond) == pytest.approx(0.0, abs=1e-11)
    total = [m.energy(at) + electric_energy(at, beyond) for at in (0.0, well)]
    assert total[1] < total[0]


def test_compression_gives_two_wells_without_voltage():
    """The certified case with lm = lh = 0.8: the flat cone is unstable because A - G < -kappa there."""
    m = ConeModel(meridional_prestretch=0.8, hoop_prestretch=0.8)
    assert m.stiffness(0.0) < 0.0
    well = brentq(m.force, 0.05, 0.9)
    assert m.stiffness(well) > 0.0
    assert m.energy(well) < m.energy(0.0)


def test_the_linear_limit_is_the_spring_alone():
    m = ConeModel(spring_stiffness=1.7, stretch_limit=np.inf)
    x = 1e-4
    assert m.force(x) == pytest.approx(1.7 * x + 2.0 * x**3, rel=1e-11)


def test_the_energy_is_not_a_number_beyond_the_stretch_limit():
    m = ConeModel(stretch_limit=np.array([0.5, 50.0, np.inf]))
    energy = m.energy(np.full(3, 1.5))
    assert np.isnan(energy[0])
    assert np.isfinite(energy[1:]).all()
    x = np.linspace(-4.0, 4.0, 401)
    wall = ConeModel(stretch_limit=2.0)
    np.testing.assert_array_equal(np.isfinite(wall.energy(x)), wall.strain(x) < wall.strain_limit())


# --- ensembles --------------------------------------------------------------------------------------------------------


def grid():
    """An ensemble of shape (2, 3) in which each of the parameters varies along one axis or not at all."""
    return ConeModel(
        spring_stiffness=np.array([[0.5], [2.0]]),
        stretch_limit=np.array([5.0, 20.0, np.inf]),
        prestretch=np.array([[1.0], [1.1]]),
        rest_height=0.2,
        voltage=np.array([0.1, 0.2, 0.3]),
        voltage_bias=[0.0, 0.0, 0.4],
    )


def test_arrays_broadcast_into_an_ensemble():
    m = grid()
    assert (m.shape, m.size) == ((2, 3), 6)
    assert (ConeModel().shape, ConeModel().size) == ((), 1)
    assert ConeModel(voltage=[0.3]).shape == (1,)
    assert ConeModel(law="yeoh", yeoh_c2=[0.1, 0.2], voltage=np.ones((4, 1))).shape == (4, 2)


@pytest.mark.parametrize("samples", [(), (5,), (4, 5)])
@pytest.mark.parametrize("quantity", ["strain", "energy", "force", "stiffness"])
def test_an_ensemble_has_the_values_of_its_members(quantity, samples):
    m = grid()
    x = np.random.default_rng(8).uniform(-0.8, 0.8, m.shape + samples)
    together = getattr(m, quantity)(x)
    assert together.shape == x.shape
    for member in np.ndindex(m.shape):
        alone = m.take(np.ravel_multi_index(member, m.shape))
        assert alone.shape == ()
        np.testing.assert_allclose(getattr(alone, quantity)(x[member]), together[member], rtol=1e-14)


def test_an_ensemble_takes_a_voltage_for_each_member():
    m = grid()
    x = np.full((2, 3, 4), 0.3)
    force = m.force(x, np.asarray(m.voltage)[:, None])
    assert force.shape == x.shape
    np.testing.assert_allclose(m.force(x) - force, np.broadcast_to(m.voltage[:, None] ** 2 * 0.3, x.shape), rtol=1e-13)


def test_numbers_make_room_for_samples():
    n = grid().numbers(trailing=2)
    assert n["spring_stiffness"].shape == (2, 3, 1, 1)
    assert n["inverse_stretch_limit"].shape == (2, 3, 1, 1)
    assert np.shape(n["damping_ratio"]) == ()
    assert grid().numbers()["spring_stiffness"].shape == (2, 3)
    assert np.broadcast_shapes(grid().strain_limit(1).shape, (2, 3, 7)) == (2, 3, 7)


def test_take_gives_a_flat_ensemble_of_the_chosen_members():
    m = grid()
    chosen = m.take([5, 0, 4])
    assert chosen.shape == (3,)
    np.testing.assert_array_equal(chosen.spring_stiffness, [2.0, 0.5, 2.0])
    np.testing.assert_array_equal(chosen.stretch_limit, [np.inf, 5.0, 20.0])
    np.testing.assert_array_equal(chosen.prestretch, [1.1, 1.0, 1.1])
    np.testing.assert_array_equal(chosen.rest_height, [0.2, 0.2, 0.2])
    assert m.take(slice(None)).shape == (6,)
    assert m.take(np.arange(6) % 2 == 0).shape == (3,)
    assert ConeModel().take([0, 0]).shape == (2,)
    with pytest.raises(IndexError):
        m.take(6)


@pytest.mark.parametrize(
    "kwargs",
    [
        {"prestretch": [1.0, 1.2], "prestretch_mode": "equibiaxial"},
        {"meridional_prestretch": [0.9, 1.1]},
        {"law": "neo-hookean", "voltage": [0.1, 0.2]},
        {"law": "yeoh", "yeoh_c2": [0.1, 0.2], "yeoh_c3": 0.01},
    ],
)
def test_take_keeps_law_and_pre_stretch(kwargs):
    m = ConeModel(**kwargs)
    second = m.take(1)
    x = np.array([0.4, 0.4])
    for quantity in ("energy", "force", "stiffness"):
        assert getattr(second, quantity)(0.4) == np.broadcast_to(getattr(m, quantity)(x), 2)[1]
    assert second.law == m.law
    assert second.prestretch_mode == m.prestretch_mode


def test_the_model_does_not_change_with_the_arrays_it_was_made_from():
    volts = np.array([0.1, 0.2])
    c2 = np.array([0.1, 0.2])
    m = ConeModel(voltage=volts, law="yeoh", yeoh_c2=c2)
    volts[0] = c2[0] = 9.0
    np.testing.assert_array_equal(m.voltage, [0.1, 0.2])
    np.testing.assert_array_equal(m.yeoh_c2, [0.1, 0.2])
    with pytest.raises(AttributeError):
        m.voltage = 1.0


# --- parameters in and out --------------------------------------------------------------------------------------------

ROUND_TRIPS = [
    {},
    {"damping_ratio": 0.0, "spring_stiffness": 0.0, "voltage": 0.0, "voltage_bias": -0.3, "rest_height": -0.1},
    {"stretch_limit": np.inf},
    {"prestretch": 1.3, "prestretch_mode": "equibiaxial"},
    {"meridional_prestretch": 0.9},
    {"meridional_prestretch": 0.9, "hoop_prestretch": np.array([1.0, 1.4])},
    {"law": "neo-hookean", "drive_frequency": [0.5, 2.0]},
    {"law": "yeoh", "yeoh_c2": -0.02, "yeoh_c3": [[0.1], [0.2]]},
]


def assert_same(one, other):
    assert one.keys() == other.keys()
    for name, value in one.items():
        np.testing.assert_array_equal(value, other[name], err_msg=name)


@pytest.mark.parametrize("given_parameters", ROUND_TRIPS, ids=[" ".join(p) or "defaults" for p in ROUND_TRIPS])
def test_parameters_give_the_model_back(given_parameters):
    m = ConeModel.from_parameters(given_parameters)
    parameters = m.parameters()
    assert_same(ConeModel.from_parameters(parameters).parameters(), parameters)
    for name, value in given_parameters.items():
        np.testing.assert_array_equal(parameters[name], value)
    again = ConeModel.from_parameters(parameters)
    assert again.law == m.law
    assert again.system == m.system
    assert_same(again.own_numbers, m.own_numbers)
    assert set(parameters) <= set(model.parameter_names())


def test_the_defaults_are_those_of_the_table():
    parameters = ConeModel().parameters()
    unused = ("meridional_prestretch", "hoop_prestretch", "dielectric_strength")
    expected = {name: q.default for name, q in PARAMETERS.items() if name not in unused}
    expected |= {"stretch_limit": 50.0, "prestretch_mode": "radial", "law": "gent"}
    expected |= {"film": "taut", "bias": "spring", "waveform": "sine", "circuit": "ideal"}
    others = [name for kind in (LAWS, BIASES, WAVEFORMS) for part in kind.values() for name in part.parameters]
    others += [name for name in PARAMETERS if name.startswith("second_")] + ["radius_ratio", *ELECTRICS]
    own = {*LAWS["gent"].parameters, *VOLTAGE, *BIASES["spring"].parameters}
    assert parameters == {name: value for name, value in expected.items() if name in own or name not in others}


def test_every_parameter_name_is_known_once_and_accepts_its_default():
    names = model.parameter_names()
    assert len(names) == len(set(names))
    for name in names:
        if name in model.KINDS:
            with pytest.raises(InputError, match="is not a numeric model parameter"):
                model.parameter_quantity(name)
            continue
        quantity = model.parameter_quantity(name)
        assert quantity.meaning
        law = next((law.name for law in LAWS.values() if name.removeprefix("second_") in law.parameters), "gent")
        bias = next((bias.name for bias in BIASES.values() if name in bias.parameters), "spring")
        wave = next((wave.name for wave in WAVEFORMS.values() if name in wave.parameters), "sine")
        film = "membrane" if name.endswith("radius_ratio") else "taut"
        second = {"second_film": film, "second_drive": "constant"} if name.startswith("second_") else {"film": film}
        owner = {NEEDS[name]: model.parameter_quantity(NEEDS[name]).default} if name in NEEDS else {}
        m = ConeModel.from_parameters(
            {name: quantity.default, "law": law, "bias": bias, "waveform": wave} | second | owner
        )
        assert m.parameters()[name] == quantity.default


def test_a_parameter_of_a_bias_that_the_model_has_not_says_how_to_have_it():
    with pytest.raises(InputError) as error:
        ConeModel(weight=0.1)
    text = "weight: is a parameter of the bias 'weight', which this model has not; give bias = 'spring+weight'"
    assert str(error.value) == text
    with pytest.raises(InputError, match=r"give bias = 'weight\+spring'"):
        ConeModel(bias="weight", rest_height=0.1)


def law_values(m):
    return {name: m.values[name] for name in m.law.parameters}


def test_replace_changes_what_it_is_given_and_nothing_else():
    m = ConeModel(voltage=[0.1, 0.2], rest_height=0.3, stretch_limit=7.0)
    changed = m.replace(voltage=0.9, stretch_limit=np.inf)
    assert_same(changed.parameters(), m.parameters() | {"voltage": 0.9, "stretch_limit": np.inf})
    np.testing.assert_array_equal(m.voltage, [0.1, 0.2])
    yeoh = ConeModel(law="yeoh", yeoh_c2=0.1, yeoh_c3=0.2)
    assert law_values(yeoh.replace(yeoh_c2=0.5)) == {"yeoh_c2": 0.5, "yeoh_c3": 0.2}
    assert law_values(yeoh.replace(voltage=1.0)) == law_values(yeoh)
    assert law_values(yeoh) == {"yeoh_c2": 0.1, "yeoh_c3": 0.2}


def test_replace_moves_between_the_two_ways_to_give_a_pre_stretch():
    both = ConeModel(prestretch=1.2, prestretch_mode="equibiaxial")
    assert both.replace(prestretch_mode="radial").stretches == (1.0, 1.2)
    assert both.replace(prestretch=1.3).stretches == (1.3, 1.3)
    direct = both.replace(meridional_prestretch=0.9, hoop_prestretch=1.1)
    assert direct.stretches == (0.9, 1.1)
    assert direct.replace(hoop_prestretch=1.4).stretches == (0.9, 1.4)
    assert direct.replace(prestretch=1.5).prestretch == 1.5


def test_the_forcing_period_is_half_that_of_the_voltage_unless_biased():
    m = ConeModel(drive_frequency=np.array([1.0, 1.0, 4.0]), voltage_bias=np.array([0.0, 0.1, -0.1]))
    np.testing.assert_allclose(m.drive_period / np.pi, [2.0, 2.0, 0.5], rtol=1e-15)
    np.testing.assert_allclose(m.forcing_period / np.pi, [1.0, 2.0, 0.5], rtol=1e-15)
    assert ConeModel(drive_frequency=4.0).forcing_period == pytest.approx(np.pi / 4.0)
    assert ConeModel(drive_frequency=4.0, voltage_bias=0.2).forcing_period == pytest.approx(np.pi / 2.0)


# --- bad input --------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("kwargs", "message"),
    [
        ({"damping_ratio": -0.1}, "damping_ratio = -0.1: must be at least 0"),
        ({"spring_stiffness": [1.0, -2.0]}, "spring_stiffness = -2: must be at least 0"),
        ({"spring_stiffness": np.inf}, "spring_stiffness = inf: must be finite"),
        ({"voltage": -1}, "voltage = -1: must be at least 0"),
        ({"voltage": np.nan}, "voltage = nan: must be a number; leave it out to take its default 0.5"),
        ({"voltage": "0.5"}, "voltage = '0.5': must be a number or an array of numbers"),
        ({"voltage": True}, "voltage = True: must be a number or an array of numbers"),
        ({"voltage": []}, "voltage = []: is empty; give at least one value"),
        ({"voltage_bias": -np.inf}, "voltage_bias = -inf: must be finite"),
        ({"drive_frequency": 0.0}, "drive_frequency = 0: must be greater than 0"),
        ({"stretch_limit": 0.0}, "stretch_limit = 0: must be greater than 0"),
        ({"stretch_limit": -np.inf}, "stretch_limit = -inf: must be greater than 0"),
        (
            {"stretch_limit": np.nan},
            "stretch_limit = nan: must be a number; leave it out to take its default",
        ),
        ({"prestretch": 0.0}, "prestretch = 0: must be greater than 0"),
        ({"meridional_prestretch": -1.0}, "meridional_prestretch = -1: must be greater than 0"),
        ({"hoop_prestretch": np.inf}, "hoop_prestretch = inf: must be finite"),
        ({"rest_height": 1j}, "rest_height = 1j: must be a number or an array of numbers"),
        ({"prestretch": 1.0, "hoop_prestretch": 1.0}, "are both given; give one or the other"),
        ({"prestretch_mode": "biaxial"}, "'biaxial' is not a prestretch_mode; did you mean 'equibiaxial'?"),
        ({"prestretch_mode": "both"}, "'both' is not a prestretch_mode; known: radial, equibiaxial"),
        ({"law": "gnt"}, "'gnt' is not a strain-energy law; did you mean 'gent'?"),
        ({"yeoh_c2": 0.1}, "yeoh_c2: the gent law does not take it; it takes stretch_limit"),
        ({"law": "yeoh", "stretch_limit": 5.0}, "the yeoh law does not take it; it takes yeoh_c2, yeoh_c3"),
        ({"law": "neo-hookean", "stretch_limit": 5.0}, "the neo-hookean law does not take it; it takes no parameters"),
        ({"law": "yeoh", "yeoh_c2": np.nan}, "yeoh_c2 = nan: must be a number"),
        (
            {"voltage": [1, 2], "spring_stiffness": [1, 2, 3], "rest_height": 0.1},
            "the parameter arrays do not broadcast together: spring_stiffness (3,), voltage (2,)",
        ),
        (
            {"law": "yeoh", "yeoh_c2": [1, 2], "voltage": [1, 2, 3]},
            "the parameter arrays do not broadcast together: voltage (3,), yeoh_c2 (2,)",
        ),
    ],
)
def test_bad_input_is_refused_in_one_line(kwargs, message):
    with pytest.raises(InputError) as error:
        ConeModel(**kwargs)
    assert message in str(error.value)
    assert "\n" not in str(error.value)


@pytest.mark.parametrize("make", [lambda p: ConeModel.from_parameters(p), lambda p: ConeModel().replace(**p)])
@pytest.mark.parametrize(
    ("name", "near"),
    [("spring_stifness", "spring_stiffness"), ("volage", "voltage"), ("stretchlimit", "stretch_limit")],
)
def test_a_misspelt_parameter_suggests_the_near_one(make, name, near):
    with pytest.raises(InputError) as error:
        make({name: 1.0})
    assert str(error.value) == f"{name!r} is not a model parameter; did you mean {near!r}?"


def test_a_name_like_no_other_lists_them_all():
    with pytest.raises(InputError) as error:
        ConeModel.from_parameters({"zzz": 1.0})
    own = [*ConeModel().system.parameters, *model.KINDS]
    assert "stretch_limit" in own
    assert all(name in str(error.value) for name in own)
    with pytest.raises(InputError, match="is not a numeric model parameter; did you mean 'voltage'"):
        model.parameter_quantity("voltages")


def test_replace_checks_the_new_values():
    with pytest.raises(InputError, match=r"^voltage = -1: must be at least 0"):
        ConeModel().replace(voltage=-1.0)
    with pytest.raises(InputError, match="do not broadcast together"):
        ConeModel(voltage=[1, 2, 3]).replace(rest_height=[0.1, 0.2])


# --- changes and refusals --------------------------------------------------------------------------------------------

YEOH = {"law": "yeoh", "yeoh_c2": 0.1}


@pytest.mark.parametrize(
    ("start", "changes"),
    [
        ({}, {"law": "neo-hookean"}),
        ({}, {"law": "yeoh", "yeoh_c2": 0.3}),
        (YEOH, {"law": "gent", "stretch_limit": 9.0}),
    ],
)
def test_replace_can_change_the_law(start, changes):
    changed = ConeModel(**start).replace(**changes)
    assert_same(changed.parameters(), ConeModel.from_parameters(changes).parameters())


def test_replace_says_that_the_law_does_not_take_a_parameter_of_another():
    with pytest.raises(InputError, match="yeoh_c2: the gent law does not take it"):
        ConeModel().replace(yeoh_c2=0.1)


@pytest.mark.parametrize("name", ["damping_ratio", "spring_stiffness", "voltage", "voltage_bias", "drive_frequency"])
def test_a_parameter_that_is_none_is_refused(name):
    with pytest.raises(InputError, match=f"^{name} = None: must be a number"):
        ConeModel(**{name: None})


@pytest.mark.parametrize("law", [3, b"gent", ("gent",)])
def test_what_is_not_a_law_is_refused(law):
    with pytest.raises(InputError, match="strain-energy law"):
        ConeModel(law=law)


@pytest.mark.parametrize("limit", [np.full(2, np.inf), np.array([5.0, np.inf])])
def test_an_array_of_stretch_limits_for_a_law_without_one_is_judged_as_a_number_is(limit):
    if np.isinf(limit).all():
        assert ConeModel(law="neo-hookean", stretch_limit=limit).stretch_limit == np.inf
    else:
        with pytest.raises(InputError, match="stretch_limit: the neo-hookean law does not take it"):
            ConeModel(law="neo-hookean", stretch_limit=limit)


@pytest.mark.parametrize("quantity", ["force", "stiffness"])
def test_beyond_the_stretch_limit_there_is_no_force(quantity):
    m = ConeModel(stretch_limit=2.0)
    x = np.linspace(-4.0, 4.0, 401)
    np.testing.assert_array_equal(np.isfinite(getattr(m, quantity)(x)), np.isfinite(m.energy(x)))


def test_an_array_of_the_wrong_type_is_refused_in_one_line():
    with pytest.raises(InputError) as error:
        ConeModel(voltage=np.array([["1", "2"], ["3", "4"]]))
    assert "\n" not in str(error.value)


def test_a_second_film_takes_what_the_first_one_chose():
    """Its law and pre-stretch mode, its branches, and where it wrinkles what happens at pull-in."""
    chosen = {"film": "wrinkling", "pull_in": "minimum", "law": "neo-hookean", "prestretch_mode": "equibiaxial"}
    first, second = (placed.film for placed in ConeModel(**chosen, second_film="wrinkling").system.films)
    assert second == first
    assert (second.pull_in, second.law.name, second.prestretch_mode) == ("minimum", "neo-hookean", "equibiaxial")
    viscous = {"viscous_modulus_1": 0.5, "flow": "linear", "rested": "raised"}
    first, second = (placed.film for placed in ConeModel(film="taut", second_film="taut", **viscous).system.films)
    assert second == first
    assert (second.branches, second.flow, second.rested) == (1, "linear", "raised")
    other = ConeModel(film="taut", second_film="wrinkling", **viscous).system.films[1].film
    assert (other.name, other.branches, other.flow, other.pull_in) == ("wrinkling", 1, "linear", "first")
    fast = {"viscous_modulus_1": 0.5, "relaxation_time_1": 0.01, "reduced": "relaxation_time_1"}
    first, second = (placed.film for placed in ConeModel(film="taut", second_film="taut", **fast).system.films)
    assert second == first
    assert second.reduced == (1,)


def test_a_double_cone_without_its_second_film_lacks_that_films_drive_too():
    pair = ConeModel(film="taut", second_film="taut", second_drive="opposite", voltage=0.3)
    for none in ("none", None):
        assert_same(pair.replace(second_film=none).parameters(), ConeModel(film="taut", voltage=0.3).parameters())
    with pytest.raises(InputError, match="second_drive = opposite: there is no second film"):
        pair.replace(second_film="none", second_drive="opposite")


class OtherGent(Gent):
    name = "other gent"


def test_another_law_starts_from_its_own_defaults_on_both_films():
    """Though it takes a parameter of the same name."""
    pair = ConeModel(film="taut", second_film="taut", stretch_limit=9.0, second_stretch_limit=7.0, voltage=0.3)
    other = pair.replace(law=OtherGent())
    assert (other.stretch_limit, other.second_stretch_limit, other.voltage) == (50.0, 50.0, 0.3)
    same = pair.replace(law="gent")
    assert (same.stretch_limit, same.second_stretch_limit) == (9.0, 7.0)


def test_nothing_is_reduced_of_a_film_that_knows_of_no_such_choice():
    model = ConeModel(film=PowerFilm(), reduced="none")
    assert (model.reduced, model.film) == ((), PowerFilm())
    with pytest.raises(InputError, match="reduced: the film 'power film' does not take it; take the film taut"):
        ConeModel(film=PowerFilm(), reduced="relaxation_time_1")


def test_what_is_reduced_is_listed_the_resistance_first():
    fast = {"viscous_modulus_1": 0.5, "relaxation_time_1": 0.01, "series_resistance": 0.003}
    for names in ((), ("series_resistance",), ("relaxation_time_1",), ("series_resistance", "relaxation_time_1")):
        assert ConeModel(film="taut", reduced="+".join(names[::-1]) or "none", **fast).reduced == names


def test_a_whole_number_of_branches_may_come_as_a_float():
    found = ConeModel(film="taut", branches=2.0).film.branches
    assert (found, type(found)) == (2, int)


def test_a_second_film_that_does_not_ship_stays_where_something_else_changes():
    pair = ConeModel(film="taut", second_film=PowerFilm(1.3), second_drive="opposite")
    assert pair.replace(voltage=0.2).system.films == pair.system.films
    assert pair.take([0]).system.films == pair.system.films


def test_what_was_reduced_has_states_again_where_nothing_is_to_be():
    small = ConeModel(film="taut", circuit="amplifier", series_resistance=0.003, reduced="series_resistance")
    assert small.system.states == ConeModel().system.states
    again = small.replace(reduced="none")
    assert (again.reduced, again.series_resistance) == ((), 0.003)
    assert [state.name for state in again.system.states[2:]] == ["film_voltage"]
    assert small.replace(voltage=0.2).reduced == ("series_resistance",)


@pytest.mark.parametrize("film", ["wrinkling", "membrane", "taut"])
def test_a_film_by_its_name_takes_over_law_meaning_of_the_pre_stretch_and_branches(film):
    """Whichever it is replaced by; an instance has its own law, and a meaning that is given is taken."""
    model = ConeModel(
        law="yeoh", yeoh_c2=0.03, prestretch=1.2, prestretch_mode="equibiaxial", viscous_modulus_1=0.4, flow="linear",
        rested="raised",
    )  # fmt: skip
    found = model.replace(film=film)
    assert (found.film.name, found.law, found.yeoh_c2) == (film, LAWS["yeoh"], 0.03)
    assert (found.prestretch_mode, found.stretches) == ("equibiaxial", (1.2, 1.2))
    assert (found.film.branches, found.film.flow, found.film.rested) == (1, "linear", "raised")
    other = model.replace(film=film, prestretch_mode="radial")
    assert (other.prestretch_mode, other.stretches) == ("radial", (1.0, 1.2))
    assert ConeModel(prestretch_mode="equibiaxial").replace(film=TautCone(Gent(), "radial")).film == TautCone(
        Gent(), "equibiaxial"
    )


def test_a_film_has_as_many_branches_as_it_was_given_and_as_have_numbers():
    film = TautCone(branches=2)
    for own, count in (({}, 2), ({"viscous_modulus_1": 0.3}, 2), ({"relaxation_time_3": 4.0}, 3)):
        assert ConeModel(film=film, **own).film.branches == count


def test_what_could_do_without_states_is_listed():
    """What is below its bound and of the taut film, and is not reduced yet."""
    fast = {"film": "taut", "viscous_modulus_1": 0.4, "relaxation_time_1": 0.01}
    both = ConeModel(**fast, series_resistance=0.005, relaxation_time_2=3.0)
    assert both.stiff == ("series_resistance", "relaxation_time_1")
    assert both.replace(reduced="series_resistance").stiff == ("relaxation_time_1",)
    assert ConeModel(**fast, series_resistance=0.02).stiff == ("relaxation_time_1",)
    assert ConeModel().stiff == ()


@pytest.mark.parametrize(("first", "second"), [("membrane", "taut"), ("taut", "wrinkling"), ("wrinkling", "membrane")])
def test_a_second_film_is_of_the_gel_of_the_first(first, second):
    model = ConeModel(film=first, second_film=second, law="yeoh", prestretch_mode="equibiaxial", yeoh_c2=0.02)
    other = model.system.films[1].film
    assert (other.name, other.law, other.prestretch_mode) == (second, LAWS["yeoh"], "equibiaxial")
    assert model.values["second_yeoh_c2"] == 0.02


def test_a_pre_stretch_of_the_second_film_may_be_given_in_the_other_way():
    pair = ConeModel(second_film="taut", prestretch=1.1, second_prestretch=1.3)
    found = pair.replace(second_hoop_prestretch=1.2)
    assert (found.second_prestretch, found.second_hoop_prestretch, found.second_meridional_prestretch) == (
        None,
        1.2,
        1.0,
    )
    assert found.prestretch == 1.1
    again = found.replace(second_prestretch=1.4)
    assert (again.second_prestretch, again.second_hoop_prestretch) == (1.4, None)


def test_a_film_without_a_law_is_named_where_one_is_needed():
    with pytest.raises(InputError, match=r"^film = power film: has no strain-energy law, which this needs"):
        ConeModel(film=PowerFilm()).gel_law()
    assert ConeModel(law="yeoh").gel_law() == LAWS["yeoh"]


def test_a_number_of_branches_that_is_given_is_not_raised_by_a_number_of_a_further_one():
    with pytest.raises(InputError, match="'relaxation_time_2' is not a model parameter"):
        ConeModel(branches=1, relaxation_time_2=3.0)
    assert ConeModel(branches=3, relaxation_time_2=3.0).film.branches == 3

"""Every law of `LAWS` against its own energy: exactly in SymPy, and in floating point over random strains."""

from types import SimpleNamespace

import mpmath
import numpy as np
import pytest
import sympy
from scipy.integrate import solve_ivp

import gelcone
from gelcone.errors import InputError
from gelcone.physics.laws import LAWS, Gent, NeoHookean, StrainEnergyLaw, Yeoh
from gelcone.physics.model import ConeModel
from gelcone.quantity import Quantity

SYMBOLIC = SimpleNamespace(log1p=lambda z: sympy.log(1 + z), sqrt=sympy.sqrt, sin=sympy.sin, cos=sympy.cos)
E, Q, A, B, G = sympy.symbols("e q A B G", positive=True)
every_law = pytest.mark.parametrize("law", LAWS.values(), ids=LAWS)


def exact(expression):
    """The expression in lowest terms, its decimal numbers taken as fractions."""
    return sympy.simplify(sympy.nsimplify(expression, rational=True))


def symbols(law):
    """A symbol for each number that the law's formulas take."""
    defaults = {name: quantity.default for name, quantity in law.parameters.items()}
    return {name: sympy.Symbol(name, positive=True) for name in law.numbers(defaults)}


def draw(law, rng, size):
    """Random numbers of the law, and strains below its limit."""
    values = {
        name: rng.lognormal(1.0, 1.0, size) if quantity.positive else rng.normal(0.0, 0.3, size)
        for name, quantity in law.parameters.items()
    }
    c = law.numbers(values)
    return c, rng.uniform(0.0, 0.97, size) * np.minimum(law.strain_limit(c), 20.0)


def certified(expression, arguments, rows):
    """The expression's values at rows of floats, in 34-digit arithmetic."""
    function = sympy.lambdify(arguments, sympy.nsimplify(expression, rational=True), "mpmath")
    with mpmath.workdps(34):
        return np.array([float(function(*map(mpmath.mpf, map(float, row)))) for row in rows])


def assert_close(actual, expected, rtol=1e-12):
    np.testing.assert_allclose(actual, expected, rtol=rtol, atol=rtol * np.max(np.abs(expected)) * 1e-3)


# --- response, from the energy ----------------------------------------------------------------------------------------


@every_law
def test_the_response_is_twice_the_slope_of_the_energy_exactly(law):
    c = symbols(law)
    energy = law.energy(E, c, SYMBOLIC)
    assert exact(2 * sympy.diff(energy, E) - law.response(E, c)) == 0
    assert exact(2 * sympy.diff(energy, E, 2) - law.response_slope(E, c)) == 0


@every_law
def test_the_numbers_agree_with_the_differentiated_energy_in_34_digits(law):
    c_symbols = symbols(law)
    c, strain = draw(law, np.random.default_rng(1), 60)
    rows = np.column_stack([strain, *(np.broadcast_to(c[name], strain.shape) for name in c_symbols)])
    energy = law.energy(E, c_symbols, SYMBOLIC)
    arguments = (E, *c_symbols.values())
    assert_close(law.energy(strain, c), certified(energy, arguments, rows))
    assert_close(law.response(strain, c), certified(2 * sympy.diff(energy, E), arguments, rows))
    assert_close(law.response_slope(strain, c), certified(2 * sympy.diff(energy, E, 2), arguments, rows))


@every_law
def test_numpy_energy_response_and_slope_follow_one_another_by_complex_step(law):
    c, strain = draw(law, np.random.default_rng(2), 5_000)
    step = 1e-30
    assert_close(law.response(strain, c), 2.0 * law.energy(strain + 1j * step, c).imag / step)
    assert_close(law.response_slope(strain, c), np.imag(law.response(strain + 1j * step, c)) / step)


@every_law
def test_compliance_is_one_over_the_response_and_stiffening_how_fast_it_falls(law):
    """Of the closed forms and of the defaults that they stand for."""
    n = law.numbers(law.complete({}) | ({"yeoh_c2": 0.1, "yeoh_c3": 0.02} if law.name == "yeoh" else {}))
    strain, h = np.array([0.0, 0.7, 3.0, 9.0]), 1e-5
    compliance = [1.0 / law.response(strain + s * h, n) for s in (1.0, -1.0, 0.0)]
    falls = (compliance[1] - compliance[0]) / (2.0 * h)
    for own in (law.compliance, lambda *at: StrainEnergyLaw.compliance(law, *at)):
        assert_close(own(strain, n) + 0.0 * strain, compliance[2])
    for own in (law.stiffening, lambda *at: StrainEnergyLaw.stiffening(law, *at)):
        np.testing.assert_allclose(own(strain, n) + 0.0 * strain, falls, rtol=1e-8, atol=1e-10)


@every_law
def test_the_film_starts_with_the_shear_modulus_and_no_energy(law):
    c = symbols(law)
    assert exact(law.response(sympy.Integer(0), c) - 1) == 0
    assert exact(law.energy(sympy.Integer(0), c, SYMBOLIC)) == 0
    numbers, _ = draw(law, np.random.default_rng(3), 20)
    np.testing.assert_array_equal(law.response(np.zeros(20), numbers), np.ones(20))
    np.testing.assert_array_equal(law.energy(np.zeros(20), numbers), np.zeros(20))


# --- film stiffness ---------------------------------------------------------------------------------------------------


@every_law
def test_the_film_stiffness_equals_the_generic_form_exactly(law):
    c = symbols(law)
    own = law.film_stiffness(Q, A, B, G, c)
    generic = StrainEnergyLaw.film_stiffness(law, Q, A, B, G, c)
    assert exact(own[0] - generic[0]) == 0
    assert exact(own[1] - generic[1]) == 0


@every_law
def test_the_film_stiffness_is_the_energys_slope_over_x_exactly(law):
    c = symbols(law)
    x = sympy.Symbol("x", positive=True)
    q = 1 + x**2
    energy = law.energy(A * q + B + G / q - 3, c, SYMBOLIC)
    h, h_slope = law.film_stiffness(Q, A, B, G, c)
    assert exact(sympy.diff(energy, x) / x - h.subs(Q, q)) == 0
    assert exact(sympy.diff(h, Q) - h_slope) == 0


@every_law
def test_the_film_stiffness_is_accurate_in_floating_point(law):
    """Over pre-stretches and displacements, at strains up to 90 % of the limit."""
    rng = np.random.default_rng(4)
    n = 60
    q = 1.0 + rng.uniform(0.0, 3.0, n) ** 2
    a, b = rng.uniform(0.5, 2.0, (2, n)) ** 2
    g = 1.0 / (a * b)
    strain = a * q + b + g / q - 3.0
    values = {
        name: strain / rng.uniform(0.01, 0.9, n) if name == "stretch_limit" else rng.uniform(0.0, 0.5, n)
        for name in law.parameters
    }
    c = law.numbers(values)
    c_symbols = symbols(law)
    rows = np.column_stack([q, a, b, g, *(np.broadcast_to(c[name], n) for name in c_symbols)])
    W = law.energy(A * Q + B + G / Q - 3, c_symbols, SYMBOLIC)
    h, h_slope = law.film_stiffness(q, a, b, g, c)
    arguments = (Q, A, B, G, *c_symbols.values())
    assert_close(h, certified(2 * sympy.diff(W, Q), arguments, rows), rtol=1e-11)
    assert_close(h_slope, certified(2 * sympy.diff(W, Q, 2), arguments, rows), rtol=1e-11)


# --- the laws as the literature writes them ---------------------------------------------------------------------------


def test_gent_energy_is_the_textbook_formula():
    J = sympy.Symbol("J", positive=True)
    energy = LAWS["gent"].energy(E, LAWS["gent"].numbers({"stretch_limit": J}), SYMBOLIC)
    assert exact(energy + J / 2 * sympy.log(1 - E / J)) == 0


def test_neo_hookean_energy_is_the_textbook_formula():
    assert exact(LAWS["neo-hookean"].energy(E, {}, SYMBOLIC) - E / 2) == 0


def test_yeoh_energy_is_the_textbook_formula():
    """W = C10 e + C20 e^2 + C30 e^3 with mu = 2 C10."""
    c10, c20, c30 = sympy.symbols("C10 C20 C30", positive=True)
    law = LAWS["yeoh"]
    energy = law.energy(E, law.numbers({"yeoh_c2": c20 / c10, "yeoh_c3": c30 / c10}), SYMBOLIC)
    assert exact(energy - (c10 * E + c20 * E**2 + c30 * E**3) / (2 * c10)) == 0


# --- limits between laws ----------------------------------------------------------------------------------------------


def test_gent_without_a_limit_is_neo_hookean_exactly():
    gent, neo = LAWS["gent"], LAWS["neo-hookean"]
    s = sympy.Symbol("s", positive=True)
    energy = sympy.nsimplify(gent.energy(E, {"inverse_stretch_limit": s}, SYMBOLIC), rational=True)
    assert sympy.simplify(sympy.limit(energy, s, 0) - neo.energy(E, {})) == 0
    zero = {"inverse_stretch_limit": sympy.Integer(0)}
    assert exact(gent.response(E, zero) - neo.response(E, {})) == 0
    assert exact(gent.response_slope(E, zero) - neo.response_slope(E, {})) == 0
    for own, other in zip(gent.film_stiffness(Q, A, B, G, zero), neo.film_stiffness(Q, A, B, G, {}), strict=True):
        assert exact(own - other) == 0


def test_yeoh_without_its_further_terms_is_neo_hookean_exactly():
    zero = {"yeoh_c2": sympy.Integer(0), "yeoh_c3": sympy.Integer(0)}
    assert exact(LAWS["yeoh"].energy(E, zero, SYMBOLIC) - LAWS["neo-hookean"].energy(E, {}, SYMBOLIC)) == 0


def test_gent_approaches_neo_hookean_as_one_over_the_stretch_limit():
    """W = e/2 + e^2/(4 J) + ...: no cancellation may spoil large J."""
    strain = 0.7
    limit = 10.0 ** np.arange(2, 15)
    excess = LAWS["gent"].energy(strain, LAWS["gent"].numbers({"stretch_limit": limit})) - 0.5 * strain
    np.testing.assert_allclose(excess, strain**2 / (4.0 * limit), rtol=0.01, atol=1e-16)


@pytest.mark.parametrize("limit", [1e16, 1e100, 1e300, np.inf])
def test_gent_with_a_huge_or_infinite_limit_has_the_neo_hookean_energy(limit):
    law = LAWS["gent"]
    c = law.numbers({"stretch_limit": np.asarray(limit)})
    np.testing.assert_allclose(law.energy(np.array([0.0, 0.3, 40.0]), c), [0.0, 0.15, 20.0], rtol=1e-14)
    np.testing.assert_allclose(law.response(np.array([0.0, 0.3, 40.0]), c), 1.0, rtol=1e-14)


def test_gent_mixes_finite_and_infinite_limits_in_one_array():
    law = LAWS["gent"]
    limits = np.array([np.inf, 5.0, 0.5, np.inf, 2.0])
    strains = np.array([0.3, 0.3, 0.3, 40.0, 0.0])
    together = law.energy(strains, law.numbers({"stretch_limit": limits}))
    expected = [0.15, -2.5 * np.log(1.0 - 0.06), -0.25 * np.log(0.4), 20.0, 0.0]
    np.testing.assert_allclose(together, expected, rtol=1e-14)
    outer = law.energy(strains[:, None], law.numbers({"stretch_limit": limits}))
    assert outer.shape == (5, 5)
    np.testing.assert_array_equal(np.diag(outer), together)


# --- the wall ---------------------------------------------------------------------------------------------------------


@every_law
def test_the_energy_is_finite_up_to_the_limit_and_not_beyond(law):
    c, _ = draw(law, np.random.default_rng(5), 50)
    limit = np.broadcast_to(law.strain_limit(c), 50)
    bounded = np.isfinite(limit)
    assert np.isfinite(law.energy(np.where(bounded, limit * (1.0 - 1e-14), 1e6), c)).all()
    for factor in (1.0 + 1e-14, 1.1, 2.0, 10.0, 1e6):
        beyond = np.where(bounded, limit * factor, 1.0)
        np.testing.assert_array_equal(np.isfinite(law.energy(beyond, c)), ~bounded)


def test_gent_alone_has_a_limit_and_it_is_the_stretch_limit():
    values = np.array([0.3, 2.0, 50.0, np.inf])
    law = LAWS["gent"]
    np.testing.assert_allclose(law.strain_limit(law.numbers({"stretch_limit": values})), values, rtol=1e-15)
    assert LAWS["neo-hookean"].strain_limit({}) == np.inf
    assert LAWS["yeoh"].strain_limit({"yeoh_c2": 0.1, "yeoh_c3": 0.2}) == np.inf


def test_gent_energy_at_and_beyond_the_limit():
    law = LAWS["gent"]
    c = law.numbers({"stretch_limit": np.array(0.5)})
    energy = law.energy(np.array([0.25, 0.5, 0.75, 50.0]), c)
    assert energy[0] == pytest.approx(0.25 * np.log(2.0))
    assert energy[1] == np.inf
    assert np.isnan(energy[2:]).all()


@every_law
def test_a_film_at_work_stiffens_up_to_the_limit(law):
    """For these laws with non-negative parameters the response never falls with strain."""
    values = {name: 5.0 if name == "stretch_limit" else 0.2 for name in law.parameters}
    c = law.numbers({name: np.asarray(value) for name, value in values.items()})
    strain = np.linspace(0.0, 4.99, 200)
    assert (np.diff(law.response(strain, c)) >= 0.0).all()
    assert (law.response_slope(strain, c) >= 0.0).all()


# --- the interface ----------------------------------------------------------------------------------------------------


def test_the_table_of_laws():
    assert set(LAWS) >= {"gent", "neo-hookean", "yeoh"}
    for name, law in LAWS.items():
        assert law.name == name
        for parameter, quantity in law.parameters.items():
            assert quantity.check(parameter, quantity.default) == quantity.default
    assert isinstance(LAWS["gent"], Gent)
    assert isinstance(LAWS["neo-hookean"], NeoHookean)
    assert isinstance(LAWS["yeoh"], Yeoh)


@pytest.mark.parametrize(("name", "near"), [("gnt", "gent"), ("neohookean", "neo-hookean"), ("Yeoh", "yeoh")])
def test_a_misspelt_law_suggests_the_near_one(name, near):
    with pytest.raises(InputError, match=f"^{name!r} is not a strain-energy law; did you mean {near!r}\\?$"):
        ConeModel(law=name)


def test_an_unknown_law_lists_all():
    with pytest.raises(InputError, match=r"^'arruda' is not a strain-energy law; known: gent, neo-hookean, yeoh"):
        ConeModel(law="arruda")


def test_a_law_that_lacks_a_function_cannot_be_made():
    class Unfinished(StrainEnergyLaw):
        name = "unfinished"
        parameters = {}

    with pytest.raises(TypeError, match="energy"):
        Unfinished()


class Quadratic(StrainEnergyLaw):
    """W = (e + b e^2)/2 with only what the interface asks for: the Yeoh law with c3 = 0."""

    name = "quadratic"
    parameters = {"quadratic_b": Quantity("b", "second coefficient", 0.1)}

    def energy(self, strain, n, xp=np):
        return 0.5 * (strain + n["quadratic_b"] * strain * strain)

    def response(self, strain, n, xp=np):
        return 1.0 + 2.0 * n["quadratic_b"] * strain

    def response_slope(self, strain, n, xp=np):
        return 2.0 * n["quadratic_b"]


def test_a_law_of_ones_own_needs_no_more_than_the_interface():
    x = np.linspace(-2.0, 2.0, 9)
    stretch = {"meridional_prestretch": 0.9, "hoop_prestretch": 1.3}
    own = ConeModel(law=Quadratic(), quadratic_b=0.3, **stretch)
    yeoh = ConeModel(law="yeoh", yeoh_c2=0.3, **stretch)
    for quantity in ("strain", "energy", "force", "stiffness"):
        np.testing.assert_allclose(getattr(own, quantity)(x), getattr(yeoh, quantity)(x), rtol=1e-13, atol=1e-15)
    assert ConeModel(law=Quadratic()).quadratic_b == 0.1
    assert own.replace(quadratic_b=0.4).quadratic_b == 0.4
    assert own.replace(quadratic_b=np.array([0.3, 0.4])).take([1]).quadratic_b == 0.4


class Fung(StrainEnergyLaw):
    """W = (exp(b e) - 1)/(2 b). Fung, Am. J. Physiol. 213 (1967) 1532."""

    name = "fung"
    parameters = {"fung_b": Quantity("b", "exponent of Fung's law", 0.4, positive=True)}

    def energy(self, strain, n, xp=np):
        return (xp.exp(n["fung_b"] * strain) - 1.0) / (2.0 * n["fung_b"])

    def response(self, strain, n, xp=np):
        return xp.exp(n["fung_b"] * strain)

    def response_slope(self, strain, n, xp=np):
        return n["fung_b"] * xp.exp(n["fung_b"] * strain)


FUNG = ConeModel(law=Fung(), fung_b=0.3, prestretch=1.1, voltage=0.7, rest_height=0.2, damping_ratio=0.03)


def test_a_law_with_an_exponential_has_the_force_of_its_energy():
    x = np.linspace(-1.5, 1.5, 7)
    np.testing.assert_allclose(FUNG.force(x), fung_force(x), rtol=1e-12)
    h = 1e-5
    np.testing.assert_allclose(FUNG.force(x), (FUNG.energy(x + h) - FUNG.energy(x - h)) / (2.0 * h), rtol=1e-8)


def fung_force(x):
    """x (A - G/q^2) exp(b e) + kappa (x - x0), by hand."""
    q, g = 1.0 + x**2, 1.0 / 1.21
    strain = q + 1.21 + g / q - 3.0
    return x * (1.0 - g / q**2) * np.exp(0.3 * strain) + 1.5 * (x - 0.2)


def test_a_law_with_an_exponential_runs_in_the_compiled_program():
    """Against SciPy's integrator, and the energy balance of a simulated response."""
    pytest.importorskip("heyoka")
    times = np.linspace(0.0, 20.0, 201)
    result = gelcone.simulate(FUNG, (0.6, 0.2), times=times)

    def rates(tau, z):
        volts = 0.7 * np.sin(tau)
        return z[1], -0.06 * z[1] - fung_force(z[0]) + volts**2 * z[0]

    run = solve_ivp(rates, (0.0, 20.0), (0.6, 0.2), "DOP853", t_eval=times, rtol=1e-12, atol=1e-13)
    np.testing.assert_allclose(result["displacement"], run.y[0], atol=1e-9)
    np.testing.assert_allclose(result["velocity"], run.y[1], atol=1e-9)
    assert float(abs(result["energy_residual"]).max()) < 1e-12
    assert float(result["supplied_energy"][-1]) > 0.01


def test_a_law_whose_response_exceeds_all_numbers_is_asked_for_its_limit():
    class Walled(Fung):
        def strain_limit(self, n):
            return 20.0 / np.asarray(n["fung_b"])

    model = FUNG.replace(film="wrinkling", fung_b=0.1, rest_height=1.1)
    with pytest.raises(InputError, match=r"law = fung: its response overflows within 1000 times .* a strain_limit"):
        gelcone.limits(model)
    assert gelcone.limits(model.replace(law=Walled())).pull_in_voltage > model.voltage


def test_a_law_with_an_exponential_has_tangents():
    pytest.importorskip("heyoka")
    from gelcone.motion.flow import integrate

    times, h = [3.0], 1e-5
    tangent = integrate(FUNG, (0.6, 0.2), times, keep="tangents").tangents[0, 0]
    for column, shift in enumerate(h * np.eye(2)):
        ahead, behind = (integrate(FUNG, [0.6, 0.2] + s * shift, times).states[0, 0] for s in (1.0, -1.0))
        np.testing.assert_allclose(tangent[:, column], (ahead - behind) / (2.0 * h), rtol=1e-7, atol=1e-8)


def test_a_result_of_an_own_law_comes_back_from_its_file(tmp_path):
    """The class is found by module and name; another process needs nothing else."""
    pytest.importorskip("heyoka")
    result = gelcone.simulate(FUNG, (0.6, 0.2), periods=1)
    gelcone.save(result, tmp_path / "fung.nc")
    again = gelcone.model_of(gelcone.load(tmp_path / "fung.nc"))
    assert again.law == Fung()
    assert again.system == FUNG.system
    assert again.parameters() == FUNG.parameters()
    assert FUNG.parameters()["law"] == f"{__name__}:Fung"


class TwiceAsStiff(Fung):
    def response(self, strain, n, xp=np):
        return 2.0 * xp.exp(n["fung_b"] * strain)


class WrongSlope(Fung):
    def response_slope(self, strain, n, xp=np):
        return xp.exp(n["fung_b"] * strain)


class NotQuite(Fung):
    def response_slope(self, strain, n, xp=np):
        return 1.0001 * super().response_slope(strain, n, xp)


class WrongFarOut(Fung):
    """Its slope is right but for a term that only large strains show."""

    def response_slope(self, strain, n, xp=np):
        return super().response_slope(strain, n, xp) + 1e-6 * strain**8


class StifferFromTheStart(Fung):
    def energy(self, strain, n, xp=np):
        return 1.5 * super().energy(strain, n, xp)

    def response(self, strain, n, xp=np):
        return 1.5 * super().response(strain, n, xp)

    def response_slope(self, strain, n, xp=np):
        return 1.5 * super().response_slope(strain, n, xp)


class OfNumPy(Fung):
    def energy(self, strain, n, xp=np):
        return (np.exp(n["fung_b"] * strain) - 1.0) / (2.0 * n["fung_b"])


class Hyperbolic(Fung):
    def energy(self, strain, n, xp=np):
        return xp.sinh(strain)


@pytest.mark.parametrize(
    ("law", "words"),
    [
        (TwiceAsStiff(), "TwiceAsStiff.response, twice .* it is 2 at 0, and must be 1; correct"),
        (WrongSlope(), "response_slope, .* it is 1 at 0, and must be 0.4"),
        (NotQuite(), "response_slope, .* and must be 0.4"),
        (WrongFarOut(), r"response_slope, .* at 1\.\d+, and must be"),
        (StifferFromTheStart(), "response at zero strain, .* it is 1.5 at 0, and must be 1"),
        (OfNumPy(), "cannot be differentiated and compiled .*; take .* xp.exp, .* not those of NumPy"),
        (Hyperbolic(), "cannot be differentiated and compiled .*sinh"),
    ],
)
def test_a_law_whose_formulas_contradict_one_another_is_refused(law, words):
    with pytest.raises(InputError, match=words):
        ConeModel(law=law)

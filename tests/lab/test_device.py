"""What may be free in a fit of a device, and what a fit says it leaves."""

import re
from types import SimpleNamespace

import numpy as np
import pytest
import xarray as xr

from gelcone.errors import DoubtfulInput, InputError
from gelcone.lab import device as module
from gelcone.lab.bench import DeviceTest
from gelcone.lab.device import GEL, WIDE, read_free
from gelcone.lab.device_fit import NoStateError
from gelcone.lab.device_tests import DeviceTests
from tests.lab.made_up_fit import COVARIANCE, FREE, POWERS, PUMP, by_powers, made_up_problem
from tests.toys import STATED


def test_priors_are_shares_of_the_value_and_wide_where_none_is_given():
    found = read_free(["spring_rate~3%", "film_thickness ~ 5 um"], PUMP)
    assert found == {"spring_rate": pytest.approx(0.03), "film_thickness": pytest.approx(5e-6 / 2e-4)}
    with pytest.warns(DoubtfulInput, match="spring_rate: has no prior"):
        assert read_free(["spring_rate"], PUMP) == {"spring_rate": WIDE}


def test_priors_in_python_are_numbers_or_texts(monkeypatch):
    own = DeviceTests((), {})
    problem = module._problem(PUMP, own, {"spring_rate": "3%", "film_thickness": "5 um", "moving_mass": 0.1}, None)
    assert problem.free == {
        "spring_rate": pytest.approx(0.03),
        "film_thickness": pytest.approx(0.025),
        "moving_mass": 0.1,
    }
    for given in ("0%", "3 V", -0.1, 0.0, float("nan"), "much", None):
        with pytest.raises(InputError, match="free spring_rate"):
            module._problem(PUMP, own, {"spring_rate": given}, None)


@pytest.mark.parametrize(
    ("texts", "message"),
    [
        (["spring_rate~3%", "spring_rate~4%"], "spring_rate: is given twice"),
        (["spring_rate~0%"], "spring_rate"), (["spring_rate~5 V"], "spring_rate"), (["spring~3%"], "spring"),
        (["film_thickness~-5 um"], "film_thickness"),
    ],
)  # fmt: skip
def test_priors_that_cannot_be_are_refused(texts, message):
    with pytest.raises(InputError, match=message):
        read_free(texts, PUMP)


# --- a made-up problem: predictions are powers of the fields ----------------------------------------------------------


def a_plan(*_):
    return SimpleNamespace(
        singular=np.array([3.0, 0.2]), directions=np.array([[1.0, 2.0]]), learnt=1, left=np.ones(3),
        covariance=COVARIANCE,
    )  # fmt: skip


@pytest.fixture
def powers(monkeypatch):
    return by_powers(monkeypatch)


@pytest.mark.parametrize(("p_value", "wider"), [(0.5, 1.0), (1e-6, 3.0)])
def test_a_fit_says_what_it_leaves_and_more_where_chi2_refuses_it(monkeypatch, powers, p_value, wider):
    """Standard deviations are the roots of the diagonal, by the root of chi2 over the readings wider; of two
    structures the one with the smaller objective counts."""
    logs = np.array([0.1, -0.05, 0.7])
    problem = made_up_problem()
    fits = [
        SimpleNamespace(objective=one, p_value=p_value, chi2=72.0, covariance=COVARIANCE, logs=logs * one,
                        problem=problem, device=PUMP.replace(film="tests.toys:StatedCone")) for one in (2.0, 1.0)
    ]  # fmt: skip
    monkeypatch.setattr(module, "_fitted", lambda problems: (dict(zip(problems, fits, strict=True)), {}))
    monkeypatch.setattr(module, "_problem", lambda *_: problem)
    monkeypatch.setattr(module, "plan_of", a_plan)
    for name in ("_check_signs", "_checked"):
        monkeypatch.setattr(module, name, lambda own: own)
    for name in ("_readings", "_others"):
        monkeypatch.setattr(module, name, lambda *_: xr.Dataset())
    settings = {"voltage": np.array([-900.0, 300.0]), "load": np.array([5000.0])}
    lower = {"voltage_offset": np.array([100.0]), "frequency": np.array([8.0])}
    tests = DeviceTests(tuple(SimpleNamespace(set=own, values=np.zeros(2)) for own in (lower, settings)), {})
    found = module.fit_device(PUMP, tests, FREE, films=["taut", "wrinkling"], predict=["stroke@1 kV"])
    np.testing.assert_allclose(found["posterior"], wider * np.sqrt([0.04, 0.01, 9.0]))
    np.testing.assert_allclose(found["covariance"], wider**2 * COVARIANCE)
    np.testing.assert_allclose(found["prior"], [0.1, 0.2, 5.0])
    np.testing.assert_allclose(found["deviation"], logs)
    nominal = np.array([PUMP.spring_rate, PUMP.film_thickness])
    np.testing.assert_allclose(found["nominal"], nominal)
    np.testing.assert_allclose(found["value"], nominal * np.exp(logs[:2]))
    own = POWERS["stroke"]
    spread = wider * float(found["predicted_value"][0]) * np.sqrt(own @ COVARIANCE[:2, :2] @ own)
    assert float(found["predicted_spread"][0]) == pytest.approx(spread, rel=0.02)
    attrs = found.attrs
    assert (attrs["chosen"], attrs["refused"], attrs["highest_voltage"]) == ("wrinkling film", int(wider > 1.0), 900.0)
    assert (attrs["chi2"], attrs["p_value"], attrs["readings"]) == (72.0, p_value, 8)
    assert {name: attrs[name] for name in STATED} == STATED


def test_the_ends_of_a_profile_are_those_of_the_unknown_that_was_asked_for(monkeypatch):
    monkeypatch.setattr(module, "profiled", lambda best, name: (-0.25, 0.5))
    found = module._profiles(SimpleNamespace(problem=SimpleNamespace(names=["a", "b"])), ["b"])
    for name, end in (("profile_low", -0.25), ("profile_high", 0.5)):
        np.testing.assert_array_equal(found[name][1], [np.nan, end])


@pytest.mark.parametrize(
    ("kind", "given", "along", "name"),
    [
        ("stroke over voltage", {"voltage": [0.0, 1.0, 2.0]}, [0.0, 1.0, 2.0], "voltage (V)"),
        ("stroke over voltage", {"voltage": [1.0, 1.0, 1.0]}, [0.0, 1.0, 2.0], "row"),
        ("blocked force", {"voltage": [0.0, 1.0, 2.0], "height": [3.0, 4.0, 5.0]}, [3.0, 4.0, 5.0], "height (m)"),
        ("blocked force", {"voltage": [0.0, 1.0, 2.0], "height": [3.0, 3.0, 3.0]}, [0.0, 1.0, 2.0], "voltage (V)"),
    ],
)
def test_a_test_is_drawn_over_the_first_of_what_is_set_that_varies(kind, given, along, name):
    one = DeviceTest(kind, kind, {k: np.array(v) for k, v in given.items()}, {kind: np.zeros(3)}, {kind: np.ones(3)})
    found, words = module._along(one)
    np.testing.assert_array_equal(found, along)
    assert words == name


def test_a_structure_of_the_loss_has_a_damper_a_branch_or_both():
    """What is not there begins with a tenth of the modulus and the drive's time; what is not free of these is."""
    creeping = PUMP.replace({"material.viscous_modulus_1": 500.0, "material.relaxation_time_1": 0.2})
    own, free = module._with_loss(creeping, FREE, "damper")
    assert own.material.branches == 0
    assert own.damping_coefficient == PUMP.damping_coefficient
    assert free == {**FREE, "damping_coefficient": module.ANY}
    own, free = module._with_loss(PUMP, {**FREE, "damping_coefficient": 0.3}, "branch")
    assert own.damping_coefficient == 0.0
    assert own.material.viscous_modulus_1 == pytest.approx(0.1 * PUMP.material.shear_modulus)
    assert own.material.relaxation_time_1 == pytest.approx(1.0 / (2.0 * np.pi * PUMP.frequency))
    branch = dict.fromkeys(("material.viscous_modulus_1", "material.relaxation_time_1"), module.ANY)
    assert free == {**FREE, **branch}
    own, free = module._with_loss(creeping, {**FREE, "damping_coefficient": 0.3}, "both")
    assert (own.material.viscous_modulus_1, own.damping_coefficient) == (500.0, PUMP.damping_coefficient)
    assert free == {**FREE, "damping_coefficient": 0.3, **branch}


def test_structures_that_all_have_no_state_are_refused_with_the_reason_of_the_first(monkeypatch):
    def lost(problem):
        raise NoStateError(f"no state of {problem}")

    monkeypatch.setattr(module, "fit_problem", lost)
    with pytest.raises(InputError, match=r"^no state of a cone$"):
        module._fitted({"taut film": "a cone", "membrane film": "a membrane"})
    monkeypatch.setattr(module, "fit_problem", lambda problem: lost(problem) if problem == "a cone" else problem)
    found = module._fitted({"taut film": "a cone", "membrane film": "a membrane"})
    assert found == ({"membrane film": "a membrane"}, {"taut film": "no state of a cone"})


@pytest.mark.parametrize(
    ("moved", "said"),
    [
        (
            {*GEL, "film_thickness"},
            "free film_thickness: with material.shear_modulus and material.relative_permittivity",
        ),
        ({"spring_rate"}, "free spring_rate: it changes without changing any reading"),
        ({"spring_rate", "moving_mass"}, "free moving_mass: with spring_rate free and no prior, these change together"),
    ],
)
def test_a_field_too_many_is_to_be_given_a_prior(moved, said):
    """The field that is asked to have one is among those that change together."""
    message = module._one_too_many(moved)
    assert message.startswith(said)
    (field,) = re.findall(r"such as 3 %(?: of ([\w.]+))?$", message)
    assert (field or message.split()[1].rstrip(":")) in moved

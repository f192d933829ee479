"""What a fit of a material takes and gives, without fits: permittivity, intervals, errors, what is predicted."""

import numpy as np
import pytest

from gelcone.devices.materials import Material
from gelcone.errors import InputError
from gelcone.lab import material as module
from gelcone.lab.coupons import Coupon, Spectrum


def coupon(name="a", stress=(0.0, 3.0, -4.0), **more):
    stress = np.array(stress, dtype=float)
    nothing = np.full(stress.size, np.nan)
    more = {"file": f"{name}.csv"} | more
    return Coupon(name=name, mode="uniaxial", kind="quasi-static", time=nothing, stretch=1.0 + 0.1 * stress,
                  stress=stress, history=(np.empty(0),) * 2, **more)  # fmt: skip


@pytest.mark.parametrize(
    ("own", "predicted"),
    [
        ({}, True), ({"voltage": 100.0}, False), ({"voltage": 100.0, "thickness": 5e-4}, True),
        ({"voltage": 100.0, "thickness": 0.0}, False), ({"use": "check"}, True), ({"use": "leave out"}, False),
        ({"voltage": -100.0}, False), ({"thickness": 5e-4, "use": "leave out"}, False),
    ],
)  # fmt: skip
def test_a_test_is_predicted_unless_it_is_left_out_or_its_voltage_has_no_thickness(own, predicted):
    assert module._predictable(coupon(**own)) is predicted
    assert "no thickness: not predicted" in module._unpredictable(coupon(**own, notes=("one",))).notes[1]


def spectrum(name, temperature, frequency, permittivity, notes=()):
    return Spectrum(name, f"{name}.csv", np.array(frequency), np.array(permittivity), temperature, notes)


def test_the_permittivity_is_that_at_10_hertz_of_the_spectrum_nearest_to_the_temperature():
    """Linear in the logarithm of the frequency; a given one counts first."""
    warm, cold = spectrum("warm", 303.15, [1.0, 100.0], [8.0, 6.0]), spectrum("cold", 283.15, [1.0, 1e3], [5.0, 2.0])
    value, words = module._permittivity({}, [cold, warm], 300.0)
    assert value == pytest.approx(7.0)
    assert words == "warm at 10 Hz, 30 degC (6 to 8 over 1 to 1e+02 Hz)"
    assert module._permittivity({}, [warm, cold], 285.0)[0] == pytest.approx(4.0)
    assert module._permittivity({}, [cold, warm], np.nan)[0] == pytest.approx(4.0)
    assert module._permittivity({"relative_permittivity": 3.0}, [warm], 300.0) == (3.0, "")
    empty = spectrum("empty", 300.0, [], [])
    assert module._permittivity({}, [empty, cold], 300.0)[0] == pytest.approx(4.0)
    with pytest.raises(InputError, match="relative_permittivity: is missing"):
        module._permittivity({}, [empty], 300.0)


def test_an_interval_is_that_of_the_central_draws_on_a_line_or_in_the_logarithm():
    """1.96 standard deviations of what is normal to either side, whatever a few draws do."""
    rng = np.random.default_rng(4)
    normal = rng.normal(size=(20000, 3))
    drawn = np.stack([np.exp(1.0 + 0.2 * normal[:, 0]), -3.0 + 0.5 * normal[:, 1], 0.1 + 0.5 * normal[:, 2]], axis=1)
    drawn[:50] = 1e6
    drawn[:50, 1:] *= -1.0
    values = np.array([np.e, -3.0, 0.1])
    low, high = module._intervals(values, drawn)
    half = 1.96 * np.array([0.2, 0.5, 0.5])
    np.testing.assert_allclose(low, [np.exp(1.0 - half[0]), -3.0 - half[1], 0.1 - half[2]], rtol=0.02, atol=0.02)
    np.testing.assert_allclose(high, [np.exp(1.0 + half[0]), -3.0 + half[1], 0.1 + half[2]], rtol=0.02, atol=0.02)
    assert np.isnan(module._intervals(values, drawn[:1])).all()


def test_an_error_is_the_root_mean_square_over_the_largest_stress():
    assert module._error(coupon(), np.array([1.0, 1.0, -4.0])) == pytest.approx(np.sqrt(5.0 / 3.0) / 4.0)


def test_numbers_of_branches_are_counted_once_and_bounded():
    assert module._checked_counts(None) == [0, 1, 2, 3, 4]
    assert module._checked_counts([2, 0, 2, 4]) == [0, 2, 4]
    for given, message in (([4], "at most 3"), ([5, 1], "branches = 5: must be at most 4"), ([], "at most 3"),
                           ([-1], "branches = -1: must be at least 0")):  # fmt: skip
        with pytest.raises(InputError, match=message):
            module._checked_counts(given)
    assert module._checked_laws(["gent", "yeoh", "gent"]) == ["gent", "yeoh"]
    assert module._checked_laws("yeoh") == ["yeoh"]
    with pytest.raises(InputError, match="did you mean 'gent'"):
        module._checked_laws(["gant"])


def test_a_fit_takes_over_what_it_does_not_replace():
    """With the sources of that alone."""
    known = Material(
        name="gel", shear_modulus=9e3, relative_permittivity=5.0, dielectric_strength=3e7, law="gent",
        stretch_limit=20.0, viscous_modulus_1=1e3, relaxation_time_1=2.0,
        sources={"shear_modulus": "a", "relative_permittivity": "b", "viscous_modulus_1": "c"},
    )  # fmt: skip
    found = module._known_fields(known)
    assert found["sources"] == {"relative_permittivity": "b"}
    assert (found["name"], found["relative_permittivity"], found["dielectric_strength"]) == ("gel", 5.0, 3e7)
    replaced = {"shear_modulus", "law", "stretch_limit", "viscous_modulus_1", "relaxation_time_1", "young_modulus"}
    assert not replaced & set(found)
    assert module._known_fields(None) == {"sources": {}}
    with pytest.raises(InputError, match="dielectric_strength"):
        module._known_fields({"dielectric_strength": "3 N"})


def test_a_note_is_said_once_of_the_files_or_tests_that_it_is_about():
    tests = [
        coupon("a1", file="a.csv", notes=("thinned", "warm")), coupon("a2", file="a.csv", notes=("thinned",)),
        coupon("b", notes=("warm",)),
    ]  # fmt: skip
    assert module._reading(tests) == [("thinned", ["a.csv"]), ("warm", ["a1", "b.csv"])]


def test_units_are_those_of_the_fields_of_a_material():
    assert [module.unit_of(name) for name in ("shear_modulus", "relaxation_time_1", "yeoh_c2")] == ["Pa", "s", "1"]

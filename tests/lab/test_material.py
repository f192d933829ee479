"""What a fit of a material takes and gives, without fits: permittivity, intervals, errors, what is predicted."""

import dataclasses
import json

import numpy as np
import pytest
import xarray as xr

from gelcone.devices.materials import Material
from gelcone.errors import InputError
from gelcone.lab import material as module
from gelcone.lab.coupons import Coupon, Spectrum
from gelcone.lab.material import fit_material, fitted_material, fitted_text
from gelcone.lab.material_fit import Band, errors_of
from gelcone.lab.measured import Measured
from gelcone.physics.laws import LAWS


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
    assert errors_of([coupon()], np.array([1.0, 1.0, -4.0])) == pytest.approx(np.sqrt(5.0 / 3.0) / 4.0)


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


def test_units_are_those_of_the_fields_of_a_material():
    assert [module.unit_of(name) for name in ("shear_modulus", "relaxation_time_1", "yeoh_c2")] == ["Pa", "s", "1"]


class Best:
    """A candidate with a branch, fitted with an error of 1 % and of 2 % of tests left out."""

    law, count, predicted, theta = LAWS["gent"], 1, np.arange(6.0), np.array([np.log(8e3), 0.0])

    @property
    def fitted(self):
        return self

    @property
    def candidate(self):
        return self

    def branches(self, theta):
        return np.array([5e3]), np.array([1.5])

    def numbers(self, theta):
        return {"stretch_limit": 20.0}

    def error(self, left_out):
        return 0.02 if left_out else 0.01


def test_a_material_says_where_its_numbers_come_from(monkeypatch):
    tests = [coupon("a"), coupon("b", file="a.csv"), coupon("c")]
    band = Band(0.125, 0.9, 0.5)
    known = {"name": "gel", "sources": {"dielectric_strength": "d"}, "dielectric_strength": 3e7}
    found = module._material(known, (4.56789, "a spectrum"), Best(), tests, "log", band)
    assert (found.shear_modulus, found.stretch_limit, found.law) == (8e3, 20.0, "gent")
    assert (found.viscous_modulus_1, found.relaxation_time_1, found.flow) == (5e3, 1.5, "log")
    assert (found.relative_permittivity, found.dielectric_strength, found.name) == (4.568, 3e7, "gel")
    source = found.sources["shear_modulus"]
    assert source.startswith("fit of 3 uniaxial tests (a.csv, c.csv): gent with 1 branches, log flow; mean error 1.00%")
    assert "tests left out 2.00%, band +-12.5%" in source
    others = {name: found.sources[name] for name in found.sources if name != "shear_modulus"}
    same = dict.fromkeys(("stretch_limit", "viscous_modulus_1", "relaxation_time_1"), "same fit")
    assert others == same | {"dielectric_strength": "d", "relative_permittivity": "a spectrum"}
    alone = module._material({"relative_permittivity": 3.0}, (3.0, ""), Best(), tests, "log", Band(np.nan, 1.0, 1.0))
    assert "left out" not in alone.sources["shear_modulus"]
    assert (alone.relative_permittivity, alone.name) == (3.0, "fitted material")


@pytest.mark.parametrize(("count", "draws"), [(2, 0), (3, 7)])
def test_a_fit_hands_tests_and_options_to_its_parts(monkeypatch, count, draws):
    """Of two tests no draws are made and no band; the permittivity is that of the field in the tests."""
    asked = {}

    class Data:
        grid = np.array([1.0])

        def __init__(self, tests, flow, permittivity, progress):
            asked.update(tests=[test.name for test in tests], flow=flow, permittivity=permittivity)

    def result(coupons, predicted, data, compared, key, spread, band):
        ends = np.cumsum([test.stress.size for test in coupons])[:-1]
        asked.update(
            uses=[test.use for test in coupons], predicted=np.split(predicted, ends), key=key, spread=spread, band=band
        )
        return xr.Dataset()

    best, kept = Best(), Band(0.1, 0.9, 0.8)
    monkeypatch.setattr(module, "Tabulated", Data)
    monkeypatch.setattr(module, "compare", lambda data, laws, counts, progress: asked.update(
        laws=laws, counts=counts) or {("gent", 1): best})  # fmt: skip
    monkeypatch.setattr(module, "choose", lambda compared, most: asked.update(most=most) or ("gent", 1))
    monkeypatch.setattr(module, "bootstrap", lambda fitted, draws, seed, progress: ("draws", draws, seed))
    monkeypatch.setattr(module, "band_of", lambda data, predicted: asked.update(left_out=predicted) or kept)
    monkeypatch.setattr(module, "stress_of", lambda test, gel: np.full(3, gel.shear_modulus))
    monkeypatch.setattr(module, "_result", result)
    tests = [coupon(str(k)) for k in range(count)]
    more = [coupon("v", voltage=100.0, use="check"), coupon("w", use="leave out")]
    measured = Measured((*tests, *more), (), ("a.csv", "b.csv"))
    known = {"relative_permittivity": 3.5, "name": "own"}
    found = fit_material(measured, known, laws=["gent"], branches=[1], draws=7, seed=4)
    assert (asked["tests"], asked["flow"], asked["permittivity"]) == ([str(k) for k in range(count)], "log", 3.5)
    assert (asked["laws"], asked["counts"], asked["key"]) == (["gent"], [1], ("gent", 1))
    assert asked["spread"] == ("draws", draws, 4)
    assert asked["uses"] == ["fit"] * count + ["check", "leave out"]
    assert [np.isfinite(one).all() for one in asked["predicted"]] == [True] * count + [False, False]
    assert np.isnan(asked["band"].width) if count == 2 else asked["band"] is kept
    if count == 3:
        np.testing.assert_array_equal(asked["left_out"], np.arange(6.0))
        assert asked["most"] == 3
    spectra = (spectrum("eps", 293.15, [1.0, 100.0], [8.0, 6.0]),)
    fit_material(Measured(measured.coupons, spectra, ("a.csv",)), laws=["gent"], branches=[1], draws=0)
    assert asked["permittivity"] == pytest.approx(7.0)
    options = {"laws": ["gent"], "branches": [1], "flow": "log", "draws": 7, "seed": 4}
    assert json.loads(found.attrs["options"]) == options
    assert json.loads(found.attrs["files"]) == ["a.csv", "b.csv"]
    assert (found.attrs["title"], fitted_material(found).shear_modulus) == ("material fit: own", 8e3)
    assert "v.csv" in found.attrs["reading"]


def test_the_errors_of_a_test_are_those_of_the_fit_to_all_and_of_that_to_the_others():
    stretch, rng = np.linspace(1.1, 2.0, 7), np.random.default_rng(1)
    curve = 8e3 * (stretch - stretch**-2)
    tests = [
        dataclasses.replace(coupon(name, curve), stretch=stretch, stress=curve * gain * (1.0 + rng.normal(0, 0.02, 7)))
        for name, gain in (("a", 0.9), ("b", 1.0), ("c", 1.2))
    ]
    known = {"relative_permittivity": 5.0}
    found = fit_material(Measured(tuple(tests), (), ()), known, laws=["neo-hookean"], branches=[0], draws=0)
    for k in range(3):
        own = found.isel(sample=found["sample_test"].values == k)
        for name, of in (("error", "predicted"), ("left_out_error", "left_out")):
            error = np.sqrt(np.mean((own[of] - own["stress"]).values ** 2)) / own["stress"].values.max()
            assert float(found[name][k]) == pytest.approx(error, rel=1e-12)
        assert float(found["left_out_error"][k]) > 1.02 * float(found["error"][k])
    for of_all, of_tests in (("fit_error", "error"), ("prediction_error", "left_out_error")):
        assert found[of_all].item() == pytest.approx(float(found[of_tests].mean()), rel=1e-4)
    for name, variable in found.variables.items():
        assert {"long_name", "units", "quantity"} <= set(variable.attrs), name


def test_a_table_of_a_fit_has_its_intervals_as_comments():
    gel = Material(name="own", shear_modulus=8e3, relative_permittivity=3.0, law="gent", stretch_limit=20.0)
    result = xr.Dataset(
        {"low": ("parameter", [7e3, np.nan]), "high": ("parameter", [9.5e3, 3.0])},
        coords={"parameter": ["shear_modulus", "stretch_limit"]},
        attrs={"material": json.dumps(gel.parameters()), "title": "material fit: own", "gelcone_version": "9.9"},
    )
    lines = fitted_text(result).splitlines()
    assert lines[0] == "# material fit: own, made by gelcone 9.9. Paste it into a device file."
    (modulus,) = (line for line in lines if line.startswith("shear_modulus"))
    assert modulus.startswith('shear_modulus = "8 kPa"')
    assert modulus.endswith("# 95 %: 7 to 9.5 kPa")
    (limit,) = (line for line in lines if line.startswith("stretch_limit"))
    assert "95 %" not in limit

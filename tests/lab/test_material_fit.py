"""A material from coupons: what is known comes out, and what is measured is chosen as certified."""

import json
import pickle
import tomllib
from pathlib import Path

import numpy as np
import pytest

import gelcone
from gelcone.devices.device import Device, find_device
from gelcone.devices.materials import Material
from gelcone.errors import InputError
from gelcone.lab import material_fit
from gelcone.lab.coupons import Coupon, Spectrum
from gelcone.lab.material import _intervals, fit_material, fitted_material, fitted_text
from gelcone.lab.material_fit import Candidate, Tabulated, band_of, bootstrap, choose, compare, errors_of
from gelcone.lab.measured import Measured, read_tests
from gelcone.lab.stress import stress_of

VHB = Path(__file__).parents[2] / "docs" / "measured" / "vhb"
TRUE = Material(
    shear_modulus=2e4,
    relative_permittivity=5.0,
    law="yeoh",
    yeoh_c2=-0.01,
    yeoh_c3=2e-4,
    viscous_modulus_1=5e4,
    relaxation_time_1=1.5,
    viscous_modulus_2=1.5e4,
    relaxation_time_2=200.0,
)


def once(function):
    """A function of a test that does not read its stresses: the same path is integrated once."""
    known = {}

    def of(test, *given):
        key = pickle.dumps((vars(test) | {"name": "", "stress": None}, given))
        if key not in known:
            known[key] = function(test, *given)
        return known[key]

    return of


pulling, branches_pulling = once(stress_of), once(material_fit.branch_stresses)


@pytest.fixture(autouse=True)
def _paths_integrated_once(monkeypatch):
    monkeypatch.setattr(material_fit, "branch_stresses", branches_pulling)


def pulled(name, rate, top, gel=TRUE, gain=1.0, noise=0.0, rng=None):
    """Loading and unloading of a known material."""
    up = np.linspace(1.0, top, 16)[1:]
    stretch = np.concatenate([up, up[::-1][1:12]])
    path = np.concatenate([[1.0], stretch])
    times = np.concatenate([[0.0], np.cumsum(np.abs(np.diff(path))) / rate])
    test = Coupon(name, "made.csv", "uniaxial", "cyclic", times[1:], stretch, 0.0 * stretch, (times, path))
    return measured(test, gel, gain, noise, rng)


def held(name, top, gel=TRUE, gain=1.0, noise=0.0, rng=None):
    """Relaxation of a known material."""
    times = np.concatenate([[0.0, (top - 1.0) / 0.1], (top - 1.0) / 0.1 + np.geomspace(1.0, 1e4, 14)])
    stretch = np.concatenate([[1.0], np.full(15, top)])
    test = Coupon(name, "made.csv", "uniaxial", "relaxation", times[1:], stretch[1:], 0.0 * times[1:], (times, stretch))
    return measured(test, gel, gain, noise, rng)


def measured(test, gel, gain, noise, rng):
    stress = pulling(test, gel) * gain
    if noise:
        stress = stress + noise * np.abs(stress).max() * rng.standard_normal(stress.size)
    return Coupon(**{**vars(test), "stress": stress})


def program(rng=None, noise=0.0, gain_sd=0.0, gel=TRUE):
    gains = np.exp(gain_sd * rng.standard_normal(7)) if gain_sd else np.ones(7)
    return [
        pulled("a", 0.01, 2.0, gel, gains[0], noise, rng),
        pulled("b", 0.1, 3.0, gel, gains[1], noise, rng),
        pulled("c", 1.0, 4.0, gel, gains[2], noise, rng),
        pulled("d", 0.05, 6.0, gel, gains[3], noise, rng),
        held("e", 1.5, gel, gains[4], noise, rng),
        held("f", 3.0, gel, gains[5], noise, rng),
        held("g", 5.0, gel, gains[6], noise, rng),
    ]


@pytest.fixture(scope="module")
def shares():
    """The shares of its work that the fit of VHB reported."""
    return []


@pytest.fixture(scope="module")
def vhb(shares):
    return fit_material(read_tests(VHB / "tests.toml"), {"name": "VHB 4905"}, draws=8, progress=shares.append)


def test_a_known_material_comes_out():
    tests = Measured(tuple(program()), (), ("made.csv",))
    laws, shares = {"laws": ["gent", "yeoh"], "branches": [1, 2, 3]}, []
    result = fit_material(tests, {"relative_permittivity": 5.0}, **laws, draws=0, progress=shares.append)
    assert np.sum(shares) == pytest.approx(1.0)  # with the part of the draws
    assert (result.attrs["chosen_law"], result.attrs["chosen_branches"]) == ("yeoh", 2)
    gel = fitted_material(result)
    for name, value in TRUE:
        if isinstance(value, float):
            assert getattr(gel, name) == pytest.approx(value, rel=2e-3), name
    assert float(result["fit_error"].sel(law="yeoh", branch_count=2)) < 1e-4
    assert float(result["fit_error"].sel(law="gent", branch_count=2)) > 5e-3


def test_the_linear_rule_comes_out_of_its_own_tests_and_not_of_others():
    gel = TRUE.replace(flow="linear")
    tests = Measured(tuple(program(gel=gel)), (), ("made.csv",))
    options = {"laws": ["yeoh"], "branches": [2], "draws": 0}
    right = fit_material(tests, {"relative_permittivity": 5.0}, flow="linear", **options)
    wrong = fit_material(tests, {"relative_permittivity": 5.0}, flow="log", **options)
    assert fitted_material(right).relaxation_time_1 == pytest.approx(1.5, rel=2e-3)
    assert fitted_material(right).flow == "linear"
    assert float(right["fit_error"].min()) < 1e-4 < 3e-3 < float(wrong["fit_error"].min())


def test_tables_comparison_and_draws_make_up_the_whole_of_the_work(vhb, shares):
    assert np.sum(shares) == pytest.approx(1.0)
    assert shares[-1] <= 0.1 / 8  # nothing is left at the end


def test_measured_vhb_is_fitted_as_certified(vhb):
    """Mean errors and parameters of a fit by other programs (shared reference), with laws and branches compared."""
    out = 100.0 * vhb["prediction_error"]
    np.testing.assert_allclose(out.sel(law="yeoh").values[1:], [10.68, 5.20, 4.15, 4.15], atol=0.02)
    np.testing.assert_allclose(out.sel(law="gent").values[1:], [12.14, 7.29, 6.49, 6.54], atol=0.02)
    np.testing.assert_allclose(out.sel(law="neo-hookean").values[2:4], [7.57, 6.99], atol=0.02)
    assert (vhb.attrs["chosen_law"], vhb.attrs["chosen_branches"]) == ("yeoh", 3)
    assert 100.0 * float(vhb["fit_error"].sel(law="yeoh", branch_count=3)) == pytest.approx(3.29, abs=0.02)
    gel = fitted_material(vhb)
    known = [17131.0, 81950.0, 0.958, 20450.0, 48.55, 9757.0, 10405.0]
    names = ["shear_modulus", *(f"{n}_{k}" for k in (1, 2, 3) for n in ("viscous_modulus", "relaxation_time"))]
    np.testing.assert_allclose([getattr(gel, name) for name in names], known, rtol=0.006)


@pytest.mark.parametrize("name", ["VHB 4905", "VHB 4910"])
def test_the_library_holds_what_is_fitted(vhb, name):
    own, fitted = gelcone.load_materials()[name], fitted_material(vhb)
    assert (own.law, own.flow) == (fitted.law, fitted.flow)
    for field, value in fitted:
        if isinstance(value, float):
            assert getattr(own, field) == pytest.approx(value, rel=1e-4), field
    assert list(own.relative_permittivity_range) == [3.59, 4.73]


def test_the_band_of_measured_vhb(vhb):
    assert vhb.attrs["band"] == pytest.approx(0.098, abs=0.001)
    assert 0.90 <= vhb.attrs["band_mean"] <= 0.96
    assert vhb.attrs["band_least"] == pytest.approx(0.68, abs=0.02)


def test_gent_with_three_branches_as_certified():
    tests = read_tests(VHB / "tests.toml")
    result = fit_material(tests, {}, laws=["gent"], branches=[3], draws=0)
    gel = fitted_material(result)
    names = ["shear_modulus", "stretch_limit", "viscous_modulus_1", "relaxation_time_1", "viscous_modulus_2"]
    np.testing.assert_allclose([getattr(gel, n) for n in names], [12876.0, 293.6, 82360.0, 0.925, 22895.0], rtol=0.01)


def test_the_permittivity_is_that_of_the_spectrum_at_the_temperature_of_the_tests(vhb):
    assert fitted_material(vhb).relative_permittivity == pytest.approx(4.71, abs=0.005)
    assert vhb.attrs["permittivity_note"].startswith("vhb-dielectric 2002 at 10 Hz, 20 degC (3.59 to 4.73")


def test_intervals_are_two_deviations_to_either_side_in_the_logarithm_of_what_is_positive(vhb):
    rng = np.random.default_rng(5)
    drawn = np.stack([np.exp(rng.normal(2.0, 0.3, 4000)), rng.normal(-1.0, 0.5, 4000)], axis=1)
    low, high = _intervals(np.array([np.exp(2.0), -1.0]), drawn)
    np.testing.assert_allclose(np.log([low[0], high[0]]), [2.0 - 0.588, 2.0 + 0.588], atol=0.03)
    np.testing.assert_allclose([low[1], high[1]], [-1.98, -0.02], atol=0.05)
    assert np.isnan(_intervals(np.ones(2), drawn[:1])).all()
    assert (vhb["low"] < vhb["value"]).all()
    assert (vhb["value"] < vhb["high"]).all()


def test_what_is_read_and_done_is_in_the_result(vhb):
    reading = dict(map(tuple, ((note, tuple(where)) for note, where in json.loads(vhb.attrs["reading"]))))
    assert reading["at 50 degC, not at 20 degC as most: left out"] == ("vhb-cyclic-0kV 702",)
    commas = [where for note, where in reading.items() if note.startswith("decimals are written with commas: ")]
    assert any("vhb-dielectric.csv" in where for where in commas)
    assert reading["column 'vel' has no unit: taken as 1/s"] == ("vhb-loading-20C.csv", "vhb-cyclic-0kV.csv")
    assert list(vhb["test_use"].values).count("leave out") == 3
    for k in range(vhb.sizes["test"]):
        own = vhb.isel(sample=np.flatnonzero(vhb["sample_test"].values == k))
        largest = float(vhb["largest_stress"][k])
        for error, name in (("error", "predicted"), ("left_out_error", "left_out")):
            gap = np.sqrt(np.mean((own[name] - own["stress"]).values ** 2)) / largest
            np.testing.assert_allclose(vhb[error][k], gap, rtol=1e-9)


def test_a_device_takes_the_table_as_it_is(vhb):
    text = fitted_text(vhb)
    assert tomllib.loads(text)["material"]["viscous_modulus_3"] == "9.7573 kPa"
    assert "# 95 %: " in text
    pump = find_device("biased-pump").replace(film="taut")
    lines = [line for line in pump.to_toml().splitlines() if not line.startswith("material =")]
    device = Device.from_text("\n".join([*lines, text]))
    assert device.material == fitted_material(vhb)
    assert set(device.material.sources) >= {"shear_modulus", "relaxation_time_3", "relative_permittivity"}
    assert "13 uniaxial tests" in device.material.sources["shear_modulus"]
    assert len(device.to_model().system.states) == 2 + 2 * 3
    decays = np.linalg.eigvals(gelcone.state_space(device, voltage=500.0).A).real
    assert ((decays < 0.0) & (decays > -1e3)).all()


def test_a_result_is_saved_and_read(vhb, tmp_path):
    gelcone.save(vhb, tmp_path / "fit.nc")
    assert fitted_material(gelcone.load(tmp_path / "fit.nc")) == fitted_material(vhb)


def test_intervals_cover_with_a_gain_in_every_test():
    """True parameters lie within their intervals, which are of a useful width, with gains of 3 % and noise of 1 %."""
    covered, widths = [], []
    for seed in range(8):
        data = Tabulated(program(np.random.default_rng(seed), 0.01, 0.03), "log", 5.0)
        candidate = Candidate("yeoh", 2, data)
        begin = np.log([2e4, 1.0, 1.0, 5e4, 1.5e4, 1.5, 200.0])
        begin[1:3] = np.array([-0.01, 2e-4]) / candidate.sizes
        fitted = candidate.refine(begin, np.ones(7))
        low, high = _intervals(np.exp(fitted.theta), np.exp(bootstrap(fitted, 30, seed)))
        covered.append((low <= np.exp(begin)) & (np.exp(begin) <= high))
        widths.append(np.log(high / low)[[0, 3, 5]])
    assert np.mean(covered) > 0.9
    assert (np.median(widths, axis=0) < [0.4, 0.6, 1.2]).all()


def test_a_band_covers_what_it_says_on_tests_alike():
    data = Tabulated(program(np.random.default_rng(5), 0.02), "log", 5.0)
    compared = compare(data, ["yeoh"], [2])
    band = band_of(data, compared["yeoh", 2].predicted)
    assert 0.03 < band.width < 0.06
    assert band.mean > 0.88


def test_the_fewest_branches_within_3_percent_are_chosen():
    class Made:
        def __init__(self, error):
            self.own = error

        def error(self, left_out):
            assert left_out
            return self.own

    errors = {("gent", 1): 9.0, ("gent", 2): 5.1, ("yeoh", 2): 5.05, ("yeoh", 3): 5.0, ("yeoh", 4): 2.0}
    compared = {key: Made(error) for key, error in errors.items()}
    assert choose(compared, 3) == ("yeoh", 2)
    assert choose(compared, 4) == ("yeoh", 4)


def test_errors_weigh_all_tests_alike():
    data = Tabulated([pulled("a", 0.1, 2.0), held("b", 3.0)], "log", 5.0)
    largest = [np.abs(test.stress).max() for test in data.tests]
    shifted = data.curves.stress + 0.1 * np.array(largest)[data.curves.test]
    np.testing.assert_allclose(errors_of(data.tests, shifted), 0.1)


def refusal(tests, material=None, **options):
    with pytest.raises(InputError) as error:
        fit_material(Measured(tuple(tests), (), ("made.csv",)), material, **options)
    assert "\n" not in str(error.value)
    return str(error.value)


def test_what_cannot_be_fitted_is_refused_in_one_line():
    known = {"relative_permittivity": 5.0}
    one = [pulled("a", 0.1, 2.0)]
    assert "relative_permittivity: is missing; give it in the material's file" in refusal(one)
    assert "laws: of 1 tests, fewer than 3, none can be left out" in refusal(one, known)
    assert "give one law and one number of branches" in refusal(one * 2, known, laws=["yeoh", "gent"], branches=[1])
    assert "give one law and one number of branches" in refusal(one * 2, known, laws=["yeoh"], branches=[0, 1])
    assert "no test is to be fitted" in refusal([one[0].with_use("check", "")], known)
    assert "'mooney' is not a law" in refusal(one, known, laws=["mooney"])
    assert "branches = 5: must be at most 4" in refusal(one, known, branches=[5])
    assert "a material takes at most 3" in refusal(one, known, branches=[4])
    assert "'exp' is not a flow" in refusal(one, known, flow="exp")
    assert "draws = -1: must be at least 0" in refusal(one, known, draws=-1)
    assert "'density' is not a material field" in refusal(one, {"density": 1.0})
    free = Coupon(**{**vars(one[0]), "voltage": 3e3, "thickness": 5e-4})
    assert 'it can be predicted, not fitted; set use = "check"' in refusal([free], known)
    still = Coupon(**{**vars(one[0]), "stress": 0.0 * one[0].stress})
    assert "all stresses are 0; leave it out" in refusal([still], known)


def test_one_test_is_fitted_where_the_law_is_given():
    result = fit_material(
        Measured((pulled("a", 0.1, 4.0),), (), ("made.csv",)),
        {"relative_permittivity": 5.0},
        laws=["neo-hookean"],
        branches=[1],
    )
    assert np.isnan(result.attrs["band"])
    assert fitted_material(result).branches == 1


def test_tests_under_voltage_are_predicted_and_not_fitted():
    gel = TRUE
    base = pulled("v", 0.2, 2.0)
    test = Coupon(**{**vars(base), "voltage": 4e3, "thickness": 5e-4, "use": "check"})
    test = Coupon(**{**vars(test), "stress": stress_of(test, gel)})
    thin = Coupon(**{**vars(test), "name": "thin", "thickness": np.nan})
    tests = Measured((*program(), test, thin), (), ("made.csv",))
    result = fit_material(tests, {"relative_permittivity": 5.0}, laws=["yeoh"], branches=[2], draws=0)
    assert float(result["error"][-2]) < 2e-3
    assert result["voltage"].values.tolist() == [0.0] * (result.sizes["test"] - 2) + [4000.0] * 2
    assert np.isnan(float(result["error"][-1]))
    assert "no thickness: not predicted" in result.attrs["reading"]


def test_a_spectrum_without_a_temperature_serves():
    spectrum = Spectrum("s", "s.csv", np.array([1.0, 100.0]), np.array([6.0, 4.0]), np.nan)
    tests = Measured((pulled("a", 0.1, 4.0),), (spectrum,), ("made.csv",))
    result = fit_material(tests, laws=["neo-hookean"], branches=[0])
    assert fitted_material(result).relative_permittivity == pytest.approx(5.0)


class Own:
    """Curves of two made-up tests, of 4 and of 1 samples, whose law has the shape 1 and whose branches are ``rows``."""

    def __init__(self, stress, field=0.0, rows=()):
        count = len(stress)
        one, test = np.ones(count), np.array([0] * (count - 1) + [1])
        self.curves = material_fit.Curves(one, one, np.array(stress, dtype=float), field * one, one, test)
        self.tests = [
            Coupon("a", "a", "uniaxial", "loading", one, one, np.array([-4.0, 1.0]), (one, one)),
            Coupon("b", "b", "uniaxial", "loading", one, one, np.array([2.0]), (one, one)),
        ]
        self.spline = lambda times: np.array(rows)
        self.data = self

    def shape(self, own):
        return np.ones(self.curves.stress.size)


def test_moduli_fit_best_without_the_field_and_are_not_negative():
    """Of the law, the same in all samples, and of a branch: 3 + 2 k above a field of 5; and the norm of the rest."""
    k = np.arange(5.0)
    own = Own(8.0 + 2.0 * k, field=5.0, rows=[k])
    found, left = material_fit._moduli(own, np.zeros(1), np.array([1.0]), np.ones(2))
    np.testing.assert_allclose(found, [3.0, 2.0])
    assert left == pytest.approx(0.0, abs=1e-9)
    own = Own(8.0 - 2.0 * k, field=5.0, rows=[k])
    found, left = material_fit._moduli(own, np.zeros(1), np.array([1.0]), np.ones(2))
    np.testing.assert_allclose(found, [0.0, 0.0], atol=1e-12)
    assert left == pytest.approx(np.linalg.norm(3.0 - 2.0 * k - found[0]))
    found, _ = material_fit._moduli(own, np.zeros(1), np.empty(0), np.array([0.0, 1.0]))  # the last sample alone
    np.testing.assert_allclose(found, [0.0])


def test_a_quantile_gives_each_test_the_same_weight():
    """19 small residuals of one test and one large one of another: half of the weight is that of the large one."""
    sizes, test = np.array([*np.linspace(0.0, 1.0, 19), 5.0]), np.array([0] * 19 + [1])
    assert material_fit._quantile(sizes, test) == 5.0
    assert material_fit._quantile(sizes[:19], test[:19]) == 1.0
    hundred = np.arange(1.0, 101.0)
    assert material_fit._quantile(hundred[::-1], np.zeros(100, dtype=int)) == 95.0


def test_a_band_is_over_the_largest_stress_of_each_test_and_is_tried_on_each_by_the_others():
    """Residuals of 1, 2, 3 and 4 over 4 of the first test, and of 1.5 over 2 of the second."""
    own = Own([0.0, 0.0, 0.0, 0.0, 0.0])
    band = band_of(own, np.array([1.0, -2.0, 3.0, -4.0, 1.5]))
    assert band.width == 1.0
    assert (band.mean, band.least) == (pytest.approx(0.875), 0.75)


def test_a_stretch_limit_lies_beyond_where_the_law_must_be_stiff_and_times_lie_in_the_table():
    data = Tabulated([pulled("a", 0.1, 2.0), held("b", 3.0)], "log", 5.0)
    low, high = np.exp(Candidate("gent", 1, data).bounds())
    assert 1.0 < low[1] / (material_fit.BEYOND * data.farthest) < 1.1
    np.testing.assert_allclose([low[-1], high[-1]], data.grid[[0, -1]])


def test_residuals_are_over_three_per_cent_of_the_largest_stress_and_the_root_of_their_number():
    data = Tabulated([pulled("a", 0.1, 2.0), held("b", 3.0)], "log", 5.0)
    for k, test in enumerate(data.tests):
        own = data.curves.scale[data.curves.test == k]
        np.testing.assert_allclose(own, 0.03 * np.abs(test.stress).max() * np.sqrt(test.stress.size))
    np.testing.assert_array_equal(np.bincount(data.curves.test), [len(test.stress) for test in data.tests])
    assert data.farthest == pytest.approx(9.0 + 2.0 / 3.0 - 3.0)


def test_draws_have_weights_that_sum_to_the_tests_and_a_gain_for_each(monkeypatch):
    seen = []

    class Candidate:
        data = Own([0.0] * 5)

        def refine(self, theta, weight, gain):
            seen.append((theta, weight, gain))
            return material_fit.Fitted(self, theta + len(seen), 0.0)

    fitted = material_fit.Fitted(Candidate(), np.array([1.0, 2.0, 3.0]), 0.0)
    found = bootstrap(fitted, 40, 5)
    np.testing.assert_array_equal(found[:, 0], 2.0 + np.arange(40))
    assert all(weight.sum() == 2.0 for _, weight, _ in seen)
    gains = np.log([gain for *_, gain in seen])
    assert (gains[:, 0] != gains[:, 1]).all()
    assert 0.02 < gains.std() < 0.04
    again = bootstrap(fitted, 3, 5)
    np.testing.assert_array_equal(seen[40][2], seen[0][2])
    assert again.shape == (3, 3)
    bootstrap(fitted, 1, 6)
    assert (seen[-1][2] != seen[0][2]).all()
    assert bootstrap(fitted, 0, 5).shape == (0, 3)

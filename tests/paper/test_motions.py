"""Studies behind figures 3 to 12, computed once with little effort."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
import xarray as xr

import gelcone
from gelcone.atlas.hysteresis import BRANCHES
from gelcone.codes import Outcome, Regime
from gelcone.paper.effort import QUICK
from gelcone.paper.studies import continuum, practical, resonance, spectra, statics, triples
from gelcone.presets import find_preset

TINY = replace(QUICK, section_points=40, frequencies=10, spectrum_periods=16, window=100.0)
STUDIES = (
    *(study for module in (statics, triples, spectra, practical, resonance) for study in module.STUDIES),
    next(study for study in continuum.STUDIES if study.name == "continuum"),
)
TRIPLES = tuple(triples.TRIPLES)
MOTIONS = (*TRIPLES, "frequency-responses")


class TinyStudies(dict):
    """All studies by name, each computed when it is first asked for."""

    def __missing__(self, name):
        shares: list[float] = []
        (study,) = (study for study in STUDIES if study.name == name)
        with pytest.MonkeyPatch.context() as patch:
            patch.setattr(resonance, "STIFFNESSES", (0.1, 1.0, 20.0))
            self[name] = study.compute(TINY, shares.append)
        assert sum(shares) == pytest.approx(1.0, abs=1e-6), name
        return self[name]


@cache
def tiny_studies():
    """Once for the tests of the figures as well."""
    return TinyStudies()


@pytest.fixture
def studies():
    return tiny_studies()


@pytest.mark.parametrize("name", [study.name for study in STUDIES])
def test_every_study_says_what_it_is_and_comes_back_from_netcdf_as_it_was(studies, name, tmp_path):
    study = studies[name]
    assert {"title", "model", "options", "gelcone_version", "preset"} <= set(study.attrs)
    for variable in study.variables.values():
        assert variable.attrs.get("long_name") or variable.dims in (("sweep",), ("set",))
    if name not in MOTIONS[1:]:  # all of which hold the same variables
        gelcone.save(study, tmp_path / "study.nc")
        assert gelcone.load(tmp_path / "study.nc").identical(study)


@pytest.mark.parametrize("name", MOTIONS)
def test_motions_are_finite_and_inside_their_extent(studies, name):
    study = studies[name]
    assert (study["outcome"] == Outcome.OK).all()
    exempt = {"zero_one", "finite_time", "finite_exponent"}
    for variable in (str(v) for v in study.data_vars if str(v) not in exempt):
        if variable.startswith(("late_", "window_", "section_", "early_", "displacement", "velocity", "finite")):
            known = np.isfinite(study[variable].values)
            # a taut cone does not stand for a membrane, which could pull in before it
            assert known.all() or (variable.endswith("beyond_membrane") and not known.any()), variable
    for window, prefix in (("window", ""), ("late", "late_")):
        x = study[f"{prefix}displacement"]
        assert (x.max(f"{prefix}time") == study[f"{window}_highest"]).all()
        assert (x.min(f"{prefix}time") == study[f"{window}_lowest"]).all()
        slack = study[f"{window}_validity_slack"]
        assert ((slack >= study[f"{window}_validity_hoop_slack"] - 0.02) & (slack <= 1.0)).all()


@pytest.mark.parametrize("name", MOTIONS)
def test_the_long_run_goes_on_where_the_section_ends(studies, name):
    study = studies[name]
    for quantity in ("displacement", "velocity"):
        ends, starts = study[f"section_{quantity}"].isel(repeat=-1), study[f"late_{quantity}"].isel(late_time=0)
        np.testing.assert_array_equal(ends, starts)
        np.testing.assert_allclose(study[f"early_section_{quantity}"][:, 0], study[quantity].isel(time=0))


@pytest.mark.parametrize("name", TRIPLES)
def test_the_model_of_a_study_is_the_one_of_its_parameter_set(studies, name):
    preset, parameter, values, changes = triples.TRIPLES[name]
    expected = find_preset(preset).model.replace(**changes, **{parameter: np.array(values)}).parameters()
    found = gelcone.model_of(studies[name]).parameters()
    for key, value in expected.items():
        np.testing.assert_array_equal(found[key], value)
    assert studies[name].attrs["parameter"] == parameter
    assert list(studies[name][parameter].values) == list(values)


def test_exponents_add_up_to_the_damping(studies):
    for name in TRIPLES:
        study = studies[name]
        zeta = np.broadcast_to(gelcone.model_of(study).damping_ratio, 3)
        np.testing.assert_allclose(study["lyapunov"].sum("exponent"), -2.0 * zeta, atol=1e-6)
        np.testing.assert_allclose(study["finite"].sum("exponent"), -2.0 * zeta, atol=1e-6)


def test_rest_attracts_all_motions_of_the_damping_study(studies):
    study = studies["damping"]
    assert (study["regime"] == Regime.REST).all()
    assert float(np.abs(study["late_displacement"]).max()) < 1e-5
    np.testing.assert_allclose(study["lyapunov"][:, 0], -study["damping_ratio"], rtol=0.02)


# --- statics and energies ---------------------------------------------------------------------------------------------


def test_three_equilibria_above_the_pitchfork_alone(studies):
    study = studies["static"]
    assert list(study["equilibria"].values) == [1, 1, 3]
    assert float(study["pitchfork_voltage"]) == pytest.approx(np.sqrt(1.5), rel=1e-12)
    np.testing.assert_array_equal(np.sign(study["slope"].values[-1]), [1, -1, 1])


def test_a_film_without_prestretch_is_slack_under_voltage_alone(studies):
    slack = studies["static"]["slack"]
    assert not slack.sel(constant_voltage=0.0).any()
    assert slack.sel(constant_voltage=[1.0, 1.5]).all()


@pytest.mark.parametrize("voltage", [0.3, 0.9])
def test_slack_agrees_with_the_time_response(voltage):
    model = gelcone.ConeModel(voltage=0.0, voltage_bias=voltage, prestretch=1.2, damping_ratio=0.0)
    run = gelcone.simulate(model, (1.0, 0.0), periods=2.0)
    expected = np.minimum(run["hoop_stress"], run["meridional_stress"]).values < 0.0
    np.testing.assert_array_equal(statics._slack(model, run["displacement"].values, voltage), expected)


def test_energies_end_at_the_stretch_limit_and_give_the_force(studies):
    study = studies["energy"]
    x = study["displacement"]
    inside = np.isfinite(study["film_energy"])
    assert (inside == (np.abs(x) < study["reach"])).all()
    assert (np.isfinite(study["film_force"]) == inside).all()
    own = study.sel(stretch_limit=10.0, displacement=np.linspace(-2.0, 2.0, 801), method="nearest")
    slope = np.gradient(own["film_energy"].values, own["displacement"].values)
    np.testing.assert_allclose(slope[1:-1], own["film_force"].values[1:-1], atol=1e-4)


def test_surfaces_hold_the_energy_of_the_model(studies):
    surface = studies["energy"]["surface_energy"].sel(surface_limit=100.0)
    model = find_preset("fast").model.replace(stretch_limit=100.0)
    here = surface.sel(surface_displacement=1.0, surface_velocity=2.0, method="nearest")
    assert float(here) == pytest.approx(float(model.energy(1.0)) + 2.0, rel=1e-12)
    assert np.isnan(studies["energy"]["surface_energy"].sel(surface_limit=1.0).values).any()


# --- spectra ----------------------------------------------------------------------------------------------------------


def test_spectra_hold_both_sets_at_both_times(studies):
    study = studies["spectra"]
    assert study["amplitude"].dims == ("set", "voltage", "frequency_ratio")
    assert study["early_amplitude"].dims == ("set", "voltage", "early_frequency_ratio")
    assert (study["early_rms"] > 1e-3).all()
    assert (study["rms"].sel(voltage=0.5) < 1e-6).all()
    model = gelcone.model_of(study)
    np.testing.assert_array_equal(model.drive_frequency, [[0.1] * 3, [0.3] * 3])
    np.testing.assert_array_equal(model.spring_stiffness, [[0.9] * 3, [0.5] * 3])


def test_a_member_of_the_spectra_is_that_of_its_own_model(studies):
    one = find_preset("fast").model.replace(voltage=1.04)
    early = gelcone.spectrum(one, (1.0, 0.0), periods=16, discard=0)
    own = studies["spectra"].sel(set="fast", voltage=1.04)
    np.testing.assert_array_equal(own["early_amplitude"].values[: early.sizes["frequency_ratio"]], early["amplitude"])


# --- the device -------------------------------------------------------------------------------------------------------


def test_the_device_is_in_volts_and_millimetres(studies):
    study = studies["practical"]
    assert study["displacement"].attrs["units"] == study["late_amplitude"].attrs["units"] == "mm"
    assert study["onset_voltage"].attrs["units"] == study["voltage_amplitude"].attrs["units"] == "V"
    np.testing.assert_allclose(study["displacement"].isel(time=0), 40.0)
    np.testing.assert_array_equal(study["voltage_amplitude"], np.arange(10.0, 51.0, 5.0))


def test_practical_voltages_do_next_to_nothing(studies):
    study = studies["practical"]
    for amplitude in study["window_amplitude"].values:
        assert np.ptp(amplitude) < 1e-3 * amplitude.mean()
    flat, raised = study["late_amplitude"].values
    assert (flat < 1e-9).all()
    # A small force moves a tilted film in proportion to it, and it goes with the square of the voltage.
    np.testing.assert_allclose(raised / raised[0], (study["voltage_amplitude"].values / 10.0) ** 2, rtol=1e-3)
    assert float(np.nanmin(study["onset_voltage"])) > 100.0 * 50.0
    assert float(study["largest_field"].max()) < float(study["dielectric_strength"].min())


# --- sweeps of the drive frequency ------------------------------------------------------------------------------------


def test_sweeps_are_finite_and_hold_every_resonance(studies):
    study = studies["frequency"]
    assert (study["outcome"] == Outcome.OK).all()
    assert np.isfinite(study["amplitude"].values).all()
    assert (np.diff(study["swept_frequency"].values, axis=1) > 0.0).all()
    lowest, highest = study["swept_frequency"].min("step"), study["swept_frequency"].max("step")
    assert ((0.5 * study["natural_frequency"] > lowest) & (study["natural_frequency"] < highest)).all()


def test_peaks_are_narrowed_down_to_an_interval(studies):
    study = studies["frequency"]
    inside = (study["peak_low"] < study["peak_frequency"]) & (study["peak_frequency"] < study["peak_high"])
    assert inside.all()
    assert (study["peak_amplitude"] >= study["amplitude"].max("step")).all()
    assert (study["peak_amplitude_error"] > 0.0).all()


def test_a_stiff_spring_resonates_at_half_its_natural_frequency_as_linear_theory_has_it(studies):
    study = studies["frequency"].sel(spring_stiffness=20.0)
    model = find_preset("spring").model
    zeta, v = float(model.damping_ratio), float(model.voltage)
    natural = float(study["natural_frequency"])
    middle = 20.0 * 0.1 / (20.0 - v * v / 2.0)
    omega = 2.0 * study["swept_frequency"]
    linear = 0.5 * v * v * middle / np.hypot(natural**2 - omega**2, 2.0 * zeta * omega)
    np.testing.assert_allclose(study["amplitude"].sel(sweep="up"), linear, rtol=0.03)
    np.testing.assert_allclose(study["amplitude"].sel(sweep="down"), linear, rtol=0.03)
    assert float(study["peak_frequency"].sel(sweep="up")) == pytest.approx(0.5 * natural, rel=2e-3)


def test_the_softest_spring_jumps_and_is_hysteretic(studies):
    own = studies["frequency"].sel(spring_stiffness=0.1)
    up, down = (own["amplitude"].sel(sweep=s).values for s in BRANCHES)
    assert np.abs(up - down).max() > 0.2 * up.max()


def test_motions_of_a_member_that_cannot_start_are_nan():
    preset = find_preset("fast")
    model = preset.model.replace(stretch_limit=np.array([0.3, 50.0]))
    study = triples.motions(preset, model, "stretch_limit", TINY, lambda share: None)
    assert isinstance(study, xr.Dataset)
    assert list(study["outcome"].values) == [Outcome.OUTSIDE, Outcome.OK]
    assert np.isnan(study["late_displacement"].values[0]).all()
    assert np.isfinite(study["late_displacement"].values[1]).all()


def test_the_long_run_of_a_member_that_failed_on_the_way_is_nan_and_not_its_start_again(monkeypatch):
    model, preset = gelcone.ConeModel(voltage=[0.3, 0.4], drive_frequency=3.0), find_preset("base")
    late = gelcone.section(model, preset.initial, repeats=3, discard=0)
    late["outcome"].values[1] = Outcome.PULLED_IN
    for name in ("displacement", "velocity"):
        late[name].values[1, -1] = np.nan
    monkeypatch.setattr(triples, "LATE_REPEATS", 1)
    run = triples._long_run(model, late, preset, None)
    for name in ("late_displacement", "late_lowest", "late_highest", "late_validity_slack"):
        assert np.isfinite(run[name].values[0]).all()
        assert np.isnan(run[name].values[1]).all(), name
    assert float(run["late_displacement"][0, 0]) == float(late["displacement"][0, -1])


def test_the_one_voltage_that_the_papers_text_names_is_in_the_middle():
    assert triples.TRIPLES["voltage"][1:3] == ("voltage", (0.5, 1.04, 1.7))

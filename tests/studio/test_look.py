"""The numbers of the live panels are those of the analyses."""

import numpy as np
import pytest

import gelcone
from gelcone.analyses.answer import in_si
from gelcone.studio import look
from gelcone.studio.setting import Setting, Shelf


@pytest.fixture(scope="module")
def shelf():
    shelf = Shelf()
    return shelf


def test_the_run_is_that_of_simulate(shelf):
    subject = shelf.subject(Setting(device="biased-pump"))
    shown = in_si(gelcone.simulate(subject.model, subject.initial, periods=5), subject)
    found = look.response(subject, 5)
    for name, variable in (("t", "time"), ("x", "displacement"), ("u", "velocity"), ("v", "drive_voltage")):
        np.testing.assert_allclose(found.arrays[name], shown[variable].values, rtol=1e-11, atol=1e-12)
    assert found.words["shares"] == [{"code": look.TAUT, "share": 1.0}]


def test_shares_of_the_film_are_those_of_simulate(shelf):
    subject = shelf.subject(Setting(preset="base", values={"voltage": "1.04"}))
    result = gelcone.simulate(subject.model, subject.initial, periods=3)
    found = look.response(subject, 3)
    shares = {entry["code"]: entry["share"] for entry in found.words["shares"]}
    slack = sum(shares.get(code, 0.0) for code in (look.HOOP_SLACK, look.CRUMPLED))
    assert slack == pytest.approx(float(result.validity_hoop_slack), abs=2e-3)
    assert 0.5 < slack < 1.0


def test_breakdown_is_told(shelf):
    subject = shelf.subject(Setting(device="biased-pump", values={"dielectric_strength": "8 kV/mm"}))
    shares = {entry["code"]: entry["share"] for entry in look.response(subject, 3).words["shares"]}
    assert 0.0 < shares[look.BREAKDOWN] < 1.0


def test_the_kind_is_that_of_regime(shelf):
    subject = shelf.subject(Setting(device="biased-pump"))
    found, result = look.kind(subject), gelcone.regime(subject.model, subject.initial)
    assert found.words["regime"] == int(result.regime) == gelcone.Regime.PERIODIC
    assert found.words["lines"][0] == "periodic, period 1"
    assert "per second" in found.words["lines"][1]
    section = in_si(result, subject)["section"].values
    np.testing.assert_allclose(found.arrays["px"], section[:, 0], rtol=1e-12)


def test_a_first_impression_is_no_verdict(shelf):
    regular = shelf.subject(Setting(device="biased-pump", values={"damping_coefficient": "0.2 N s/m"}))
    assert look.response(regular, 20).words["seems"] == "seems to repeat"
    wild = shelf.subject(Setting(preset="base", values={"voltage": "1.7"}))
    assert look.response(wild, 20).words["seems"] == "does not repeat yet"


def test_statics_are_those_of_static(shelf):
    subject = shelf.subject(Setting(preset="base"))
    found = look.statics(subject)
    assert found.words["marks"]["pitchfork"] == pytest.approx(np.sqrt(0.9))
    assert set(found.arrays["stable"].tolist()) == {0, 1}


def test_statics_lead_to_pull_in_and_are_found_once_for_all_drives(shelf):
    body = {"film": "wrinkling", "rest_height": "1"}
    one, other, stiffer = (
        look.statics(shelf.subject(Setting(preset="base", values=body | own)))
        for own in ({"voltage": "0.3", "drive_frequency": "0.5"}, {"voltage": "0.4"}, {"spring_stiffness": "1"})
    )
    reached, pull_in = np.nanmax(one.arrays["voltage"]), one.words["marks"]["pull_in"]
    assert 0.99 * pull_in < reached <= pull_in
    np.testing.assert_array_equal(one.arrays["voltage"], other.arrays["voltage"])
    assert one.words["swing"] == [-0.3, 0.3]
    assert stiffer.words["marks"]["pull_in"] != pull_in


def test_a_run_that_ends_is_shown_up_to_its_end(shelf):
    subject = shelf.subject(Setting(preset="base", values={"film": "wrinkling", "voltage": "1.2"}))
    found = look.response(subject, 20)
    run = gelcone.integrate(subject.model, subject.initial, 20.0 * float(subject.model.drive_period))
    assert found.words["ended"]
    assert found.arrays["t"][-1] == pytest.approx(float(run.end_times[0]), rel=1e-6)
    assert np.isfinite(found.arrays["x"]).all()


def test_each_film_of_two_has_its_own_state(shelf):
    found = look.response(shelf.subject(Setting(device="double-cone")), 2)
    assert found.arrays["film1"].shape == found.arrays["film2"].shape == found.arrays["film"].shape
    assert "film1" not in look.response(shelf.subject(Setting(device="biased-pump")), 2).arrays


def test_a_run_that_pulls_in_says_when_and_where(shelf):
    subject = shelf.subject(Setting(device="biased-pump", values={"voltage_offset": "2500 V"}))
    found = look.response(subject, 3)
    assert found.words["ended"] == "pulled in"
    assert found.words["seems"].startswith("the film pulls in after ")
    assert f"at the height {found.arrays['x'][-1]:.4g} mm" in found.words["seems"]

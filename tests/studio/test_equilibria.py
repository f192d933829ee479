"""Equilibria and pull-in of the live panels are those of the analyses, and are stored for many drives."""

import numpy as np
import pytest

import gelcone
from gelcone.analyses.answer import in_si
from gelcone.studio import equilibria
from gelcone.studio.setting import Setting, Shelf


@pytest.fixture(scope="module")
def shelf():
    shelf = Shelf()
    return shelf


def test_statics_are_those_of_static(shelf):
    subject = shelf.subject(Setting(preset="base"))
    found = equilibria.statics(subject)
    assert found.words["marks"]["pitchfork"] == pytest.approx(np.sqrt(0.9))
    assert set(found.arrays["stable"].tolist()) == {0, 1}


def test_statics_lead_to_pull_in_and_are_found_once_for_all_drives(shelf):
    body = {"film": "wrinkling", "rest_height": "1"}
    one, other, stiffer = (
        equilibria.statics(shelf.subject(Setting(preset="base", values=body | own)))
        for own in ({"voltage": "0.3", "drive_frequency": "0.5"}, {"voltage": "0.4"}, {"spring_stiffness": "1"})
    )
    reached, pull_in = np.nanmax(one.arrays["voltage"]), one.words["marks"]["pull_in"]
    assert 0.99 * pull_in < reached <= pull_in
    np.testing.assert_array_equal(one.arrays["voltage"], other.arrays["voltage"])
    assert one.words["swing"] == [-0.3, 0.3]
    assert stiffer.words["marks"]["pull_in"] != pull_in


def test_statics_have_the_branches_marks_and_swing_of_static(subject):
    found = equilibria.statics(subject)
    highest = 2.0 ** np.ceil(np.log2(float(subject.model.peak_voltage)))
    shown = in_si(gelcone.static(subject.model, np.linspace(0.0, highest, 2)), subject)
    np.testing.assert_allclose(found.arrays["voltage"], shown["branch_voltage"].values, rtol=1e-12)
    np.testing.assert_allclose(found.arrays["x"], shown["branch_displacement"].values, rtol=1e-12)
    slope = gelcone.static(subject.model, np.linspace(0.0, highest, 2))["branch_slope"].values
    np.testing.assert_array_equal(found.arrays["stable"], slope > 0.0)
    marks = {name: float(shown[f"{name}_voltage"]) for name in ("pitchfork", "pull_in")}
    assert found.words["marks"] == pytest.approx({n: v for n, v in marks.items() if np.isfinite(v)}, rel=1e-12)
    run = in_si(gelcone.simulate(subject.model, subject.initial, periods=3), subject)["drive_voltage"].values
    assert found.words["swing"] == pytest.approx([run.min(), run.max()], rel=2e-3)


@pytest.mark.parametrize("film", ["taut", "wrinkling"])
def test_equilibria_are_found_again_for_every_parameter_that_they_depend_on(shelf, monkeypatch, film):
    values = {"film": film, "bias": "spring+beam+weight+force"}
    model = shelf.subject(Setting(preset="base", values=values | {"voltage": "0.4"})).model
    counted = []
    monkeypatch.setattr(
        equilibria, "static", lambda model, voltages: counted.append((model.parameters(), voltages[-1]))
    )
    monkeypatch.setattr(equilibria.STATICS, "stored", {})
    equilibria.STATICS.of(model)
    numbers = [name for name, value in model.values.items() if np.ndim(value) == 0 and np.isfinite(value)]
    assert len(numbers) > 10
    for name in numbers:
        before = len(counted)
        equilibria.STATICS.of(model.replace(**{name: 1.01 * float(model.values[name]) + 1e-3}))
        assert len(counted) == before + (name not in equilibria.DRIVEN), name
    for changed in ({"law": "neo-hookean"}, {"film": "wrinkling" if film == "taut" else "taut"}, {"bias": "spring"}):
        before = len(counted)
        equilibria.STATICS.of(model.replace(**changed) if "bias" not in changed else gelcone.ConeModel(film=film))
        assert len(counted) == before + 1
    before = len(counted)
    equilibria.STATICS.of(model.replace(voltage=3.0))  # beyond what was looked at
    assert counted[before:]
    assert counted[-1][1] >= 3.0
    equilibria.STATICS.of(model.replace(voltage_bias=4.0))  # the peak is that of amplitude and offset
    assert counted[-1][1] >= 4.4


def test_equilibria_do_not_depend_on_what_is_left_out_of_their_key(shelf):
    model = shelf.subject(Setting(preset="base")).model
    levels = np.linspace(0.0, 0.5, 3)
    expected = gelcone.static(model, levels)
    for name in equilibria.DRIVEN:
        changed = {"waveform": "triangle", "circuit": "ideal"}.get(name)
        other = model.replace(**{name: 1.1 * float(model.values[name]) + 0.1 if changed is None else changed})
        assert gelcone.static(other, levels).branch_displacement.equals(expected.branch_displacement), name


# --- what the numbers mean -------------------------------------------------------------------------------------------


def test_answers_are_stored_for_so_many_models_and_no_more():
    found = []
    answers = equilibria.Answers(str, lambda model: found.append(model) or f"of {model}")
    for model in range(equilibria.MOST_STATICS):
        assert answers.of(model) == f"of {model}"
    assert answers.of(0) == "of 0"
    assert len(found) == len(answers.stored) == equilibria.MOST_STATICS
    answers.keep("more", "kept")
    assert (answers.has("more"), answers.has(0), len(answers.stored)) == (True, False, 1)
    assert answers.of("more") == "kept"

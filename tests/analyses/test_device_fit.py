"""The text of a fitted device: deviations with their sign, what lies far from its prior, and what is refused."""

import json

import numpy as np

import gelcone
from gelcone.analyses import (
    device_fit,
)  # fmt: skip
from gelcone.analyses.device_fit import _left_out_lines, _unknown_lines
from gelcone.devices.device import find_device
from tests.analyses.said import NAN
from tests.edited import edited, made
from tests.plots.made_up import result


def fit():
    return result(
        {
            "prior": ("unknown", [0.1, 0.02]),
            "posterior": ("unknown", [0.01, 0.01]),
            "deviation": ("unknown", [np.log(1.15), np.log(0.95)]),
            "value": ("field", [17.25]),
            "left_out_chi2": ("test", [9.5, 40.0]),
            "left_out_points": ("test", [10, 12]),
            "left_out_p_value": ("test", [0.6, 0.001]),
        },
        {
            "unknown": ("unknown", ["spring_rate", "gain of the laser"]),
            "field": ("field", ["spring_rate"]),
            "test": ("test", ["stroke", "force"]),
        },
    )


def test_deviations_have_their_sign_and_are_measured_by_the_prior():
    _, spring, laser = _unknown_lines(fit(), find_device("biased-pump"))
    assert spring.split() == ["spring_rate", "17.25", "N/m", "+15.0", "%", "1", "%", "10", "%", "0.10"]
    assert laser.split()[4:10] == ["-5.0", "%", "1", "%", "2", "%"]
    assert laser.endswith("more than 2 standard deviations from its prior")


def test_a_test_that_the_others_contradict_is_refused():
    _, stroke, force = _left_out_lines(fit())
    assert stroke.endswith("chi2 9.5 of 10, p = 0.6")
    assert force.endswith("chi2 40 of 12, p = 0.001: refused")


def fit_of_device(**changes):
    own = {
        "prior": ("unknown", [0.1, 10.0]), "posterior": ("unknown", [0.01, 0.02]),
        "deviation": ("unknown", [-0.25, 0.125]),
        "value": ("field", [17.25]), "profile_low": ("unknown", [-0.5, NAN]), "profile_high": ("unknown", [0.25, NAN]),
        "structure_objective": ("structure", [12.0, 11.0, 99.0]), "exponent": (("invariant", "field"), [[1.0]]),
        "predicted_value": ("prediction", [0.004, NAN]), "predicted_spread": ("prediction", [0.0001, NAN]),
        "predicted_prior": ("prediction", [0.001, NAN]),
    }  # fmt: skip
    coords = {"unknown": ("unknown", ["spring_rate", "gain of the laser"]), "field": ("field", ["spring_rate"]),
              "structure": ("structure", ["taut", "wrinkling", "membrane"]),
              "prediction": ("prediction", ["stroke@1.5 kV", "pull-in"])}  # fmt: skip
    shown = made(own, coords, readings=120, chosen="wrinkling, damper", chi2=118.5, refused=0, p_value=0.5,
                 film="wrinkling", learnt=1, impossible='{"both": "no rest: anywhere"}', tests='["a", "b"]',
                 next=json.dumps([[["a step to 1 kV", 0.75], ["a ramp", 0.875]], []]))  # fmt: skip
    return edited(shown, **changes)


def test_the_first_of_many_next_experiments_are_those_that_leave_the_least():
    shown = made({"predicted_value": ("prediction", [1.0])}, {"prediction": ("prediction", ["pull-in"])},
                 next=json.dumps([[[f"test {k}", 0.1 * k] for k in range(1, 10)]]))  # fmt: skip
    _, *lines = device_fit._next_lines(shown)
    assert lines == [f"  0.{k}0  test {k}" for k in range(1, 1 + device_fit.MOST_NEXT)]


def test_a_fitted_device():
    pump = gelcone.find_device("biased-pump").replace(film="taut")
    lines = device_fit.device_fit_words(fit_of_device(), pump).splitlines()
    assert lines[:2] == [
        "biased pumping cone: fitted to 120 readings, wrinkling, damper",
        "chi2 = 118.5 of 120 points (p = 0.5): the structure is not refused",
    ]
    undecided = "these tests cannot distinguish wrinkling from taut" if device_fit.UNDECIDED > 1.0 else ""
    assert lines[2:4] == [
        "structure both: no rest",
        "structures compared, chi2 with priors: wrinkling 11; taut 12; membrane 99",
    ]
    assert (lines[4] == undecided) == bool(undecided)
    at = lines.index(next(line for line in lines if line.startswith("  spring_rate")))
    assert lines[at].split() == ["spring_rate", "17.25", "N/m", "-22.1", "%", "1", "%", "10", "%", "0.10", "more",
    "than",
                                 "2", "standard", "deviations", "from", "its", "prior"]  # fmt: skip
    assert lines[at + 1] == "    95 % by profile: -39.35 to +28.40 %; by curvature -23.63 to -20.58 %"
    assert lines[at + 2].split() == ["gain", "of", "the", "laser", "+13.3", "%", "2", "%", "none", "0.00"]
    assert lines[at + 3 :] == [
        "1 of 1 directions of the fields are learnt from the tests, the others from the priors",
        "changes that leave every reading as it is (s: any factor):", "  spring_rate x s",
        "stroke@1.5 kV: 4 mm +- 100 um (2.5 %; from the priors alone 25 %)", "pull-in: none",
        "next for stroke@1.5 kV, what it would leave of the standard deviation:", "  0.75  a step to 1 kV",
        "  0.88  a ramp",
    ]  # fmt: skip
    for film, other in (("wrinkling", "taut"), ("taut", "wrinkling"), ("membrane", "wrinkling")):
        refused = device_fit.verdict(fit_of_device().assign_attrs(refused=1, film=film))
        assert refused.endswith(f"the intervals below are not to be relied on; try --films {other}")
        assert "no device of this structure makes these data" in refused
    plan = device_fit.device_plan_words(fit_of_device(), pump).splitlines()
    assert plan[0] == "biased pumping cone: plan of 120 readings in 2 tests, wrinkling film"


def test_a_plan_says_how_the_files_of_its_tests_were_read(tmp_path):
    text = '[[test]]\nkind = "ring-down"\nfile = "ringing.csv"\nnoise = {frequency = "0.02 Hz", decay = "0.05 1/s"}\n'
    (tmp_path / "tests.toml").write_text(text)
    (tmp_path / "ringing.csv").write_text("frequency/Hz;decay (1/s)\n9,1;1,5\n9,2;1,25\n")
    device = find_device("soft-film").replace(film="taut")
    plan = gelcone.plan_device(device, gelcone.read_device_tests(tmp_path / "tests.toml"), {"moving_mass": 0.03})
    notes = ["cells are separated by semicolons", "decimals are written with commas: 9,1 is 9.1"]
    lines = device_fit.device_plan_words(plan, device).splitlines()
    assert lines[-3:] == ["read as:", *(f"  ring-down, ringing.csv: {note}" for note in notes)]
    assert device_fit.device_fit_json(plan)["reading"] == [[note, ["ring-down, ringing.csv"]] for note in notes]

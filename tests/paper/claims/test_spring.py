"""Verdicts on the claims about pre-stretch and spring, on made-up studies."""

import numpy as np
import pytest
import xarray as xr

from gelcone.codes import Regime
from gelcone.paper.truths import Share
from gelcone.paper.verdicts import Verdict, judge
from tests.paper.made_up import CHAOTIC, PERIODIC, REST, cells, found, number, verdict

ORDER = [int(CHAOTIC), int(PERIODIC), int(REST)]
UNSETTLED = int(Regime.TRANSIENT)


def prestretch(kinds=ORDER, finite=(1.0, 0.0, -1.0), others=18, of=20, other=ORDER, window=500.0):
    """The paper's own set, and ``of`` others of which some have the order of motions ``other``."""
    study = cells({"prestretch": [0.8, 1.0, 1.5]}, [1, 0, 0], kinds=kinds, finite=finite)
    near = np.array([other] * others + [ORDER[::-1]] * (of - others))
    study = study.assign_attrs(window=window)
    return {
        "prestretch": study.assign(late_validity_slack=("prestretch", [0.9, 0.8, 0.0])),
        "neighbours": xr.Dataset({"prestretch_kind": (("point", "prestretch"), near)}),
    }


@pytest.mark.parametrize(
    ("expected", "changed"),
    [
        (Verdict.REPRODUCED, {}),
        (Verdict.CHOSEN, {"others": 2}),
        (Verdict.UNDECIDED, {"others": 10}),
        (Verdict.UNDECIDED, {"kinds": [*ORDER[:2], UNSETTLED]}),
        (Verdict.TRANSIENT, {"kinds": ORDER[::-1]}),
        (Verdict.TRANSIENT, {"kinds": [UNSETTLED, *ORDER[:2]]}),  # the others tell that it is not this order
        (Verdict.CHOSEN, {"kinds": ORDER[::-1], "finite": (-1.0, 0.0, -1.0)}),
        (Verdict.CHOSEN, {"kinds": ORDER[::-1], "finite": (0.012, 0.0, -1.0)}),  # log(500)/500 is 0.0124
        (Verdict.CHOSEN, {"kinds": ORDER[::-1], "finite": (1.0, 0.013, -1.0)}),
        (Verdict.CHOSEN, {"kinds": [3, 1, 1], "finite": (1.0, 0.0, 1.0)}),
        (Verdict.NOT_REPRODUCED, {"kinds": ORDER[::-1], "finite": (1.0, 0.0, 1.0), "others": 0}),
    ],
)
def test_the_order_of_motions_with_prestretch(expected, changed):
    assert verdict("prestretch-order", **prestretch(**changed)) is expected


def test_each_prestretch_is_named_with_its_motion_and_exponent():
    finding = found("prestretch-order", **prestretch(others=5, other=[*ORDER[:2], UNSETTLED]))
    assert finding.share == Share(0, 15, open=5)
    assert [one.meaning for one in finding.numbers[:3]] == [
        f"largest exponent at pre-stretch {at} ({kind})"
        for at, kind in ((0.8, "chaotic"), (1, "periodic"), (1.5, "rest"))
    ]
    assert [(one.value, one.error) for one in finding.numbers[:3]] == [(0.1, 0.01), (-0.1, 0.01), (-0.1, 0.01)]
    assert [one.value for one in finding.slack] == [0.9]


def response(peaks=(1.0, 2.0, 3.0), reach=0.4, amplitudes=(3.0, 2.0, 1.0), error=0.4, up=None, down=None):
    """Sweeps at three stiffnesses; that down has other peaks, which count for nothing."""
    peaks, amplitudes = np.array(peaks), np.array(amplitudes)
    up = np.ones((3, 4)) if up is None else np.asarray(up, dtype=float)
    down = up if down is None else np.asarray(down, dtype=float)
    each = ("spring_stiffness", "sweep")

    def both(values):
        return each, np.stack([values, values[::-1]], axis=1)

    return xr.Dataset(
        {
            "peak_frequency": both(peaks),
            "peak_low": both(peaks - reach),
            "peak_high": both(peaks + reach),
            "peak_amplitude": both(amplitudes),
            "peak_amplitude_error": both(np.full(3, error)),
            "amplitude": ((*each, "step"), np.stack([up, down], axis=1)),
        },
        coords={"spring_stiffness": [0.1, 1.0, 20.0], "sweep": ["up", "down"]},
    )


@pytest.mark.parametrize(
    ("expected", "changed"),
    [
        (Verdict.REPRODUCED, {}),
        (Verdict.UNDECIDED, {"reach": 0.51, "peaks": (1.0, 2.0, 4.0)}),
        (Verdict.UNDECIDED, {"reach": 0.5}),  # intervals that touch say nothing
        (Verdict.NOT_REPRODUCED, {"peaks": (3.0, 2.0, 1.0)}),
        (Verdict.CHOSEN, {"peaks": (1.0, 3.0, 2.0)}),
    ],
)
def test_the_resonance_rises_with_the_stiffness(expected, changed):
    assert verdict("spring-frequency", frequency=response(**changed)) is expected


def test_resonances_in_random_order_do_not_pass():
    """Of six stiffnesses in any order fewer than one in fifty rises but for the first or the last."""
    rng = np.random.default_rng(2)
    passed = 0
    for _ in range(100):
        peaks = xr.DataArray(rng.permutation(6.0 + np.arange(6.0)), dims="spring_stiffness")
        both = peaks.expand_dims(sweep=["up"])
        names = {"peak_frequency": 0.0, "peak_low": -0.1, "peak_high": 0.1}
        study = xr.Dataset({name: both + off for name, off in names.items()})
        study = study.assign_coords(spring_stiffness=[0.1, 0.5, 1.0, 5.0, 10.0, 20.0])
        passed += verdict("spring-frequency", frequency=study) is not Verdict.NOT_REPRODUCED
    assert passed <= 5


def test_resonances_have_their_intervals():
    finding = found("spring-frequency", frequency=response(peaks=(1.0, 3.0, 2.0)))
    assert finding.share == Share(1, 1, sample=False)
    assert [(one.value, one.low, one.high) for one in finding.numbers] == [
        (1.0, 0.6, 1.4),
        (3.0, 2.6, 3.4),
        (2.0, 1.6, 2.4),
    ]
    assert finding.numbers[2].meaning == "resonance at spring stiffness 20"


def spring(start=(1.0, 1.0, 1.0), late=(0.4, 0.2, 0.1)):
    at = "spring_stiffness"
    start, late = np.array(start), np.array(late)
    return xr.Dataset(
        {
            "window_highest": (at, 5.0 + start),
            "window_lowest": (at, 5.0 - start),
            "late_highest": (at, 5.0 + late),
            "late_lowest": (at, 5.0 - late),
        }
    )


SAME = (0.4, 0.4, 0.4)


@pytest.mark.parametrize(
    ("expected", "changed", "motions"),
    [
        (Verdict.REPRODUCED, {}, {"late": SAME}),
        (Verdict.TRANSIENT, {}, {}),  # not affected over the window alone
        (Verdict.NOT_REPRODUCED, {}, {"start": (1.0, 1.0, 1.1)}),
        (Verdict.UNDECIDED, {"amplitudes": (3.0, 2.0, 2.0)}, {}),
        (Verdict.UNDECIDED, {"amplitudes": (4.0, 2.9, 2.2)}, {}),  # the errors of the second pair overlap
        (Verdict.NOT_REPRODUCED, {"amplitudes": (1.0, 2.0, 3.0)}, {"late": SAME}),
        (Verdict.NOT_REPRODUCED, {"amplitudes": (3.0, 1.0, 2.0)}, {"late": SAME}),
    ],
)
def test_the_peak_falls_and_the_amplitude_is_not_affected(expected, changed, motions):
    assert verdict("spring-amplitude", frequency=response(**changed), spring=spring(**motions)) is expected


@pytest.mark.parametrize(
    ("start", "said"), [((1.0, 1.02, 1.04), "that of the release, and not affected"), ((1.0, 1.0, 1.06), "as well")]
)
def test_the_two_statements_about_the_amplitude_are_told_apart(start, said):
    finding = found("spring-amplitude", frequency=response(), spring=spring(start))
    assert said in finding.why
    assert number(finding, "figure 11").value == pytest.approx(start[-1])
    assert number(finding, "long run").value == pytest.approx(0.25)
    assert [(one.value, one.error) for one in finding.numbers[:3]] == [(3.0, 0.4), (2.0, 0.4), (1.0, 0.4)]


def test_the_two_statements_about_the_amplitude_have_verdicts_of_their_own():
    """The peak falls in the long run; only the release from the start is not affected."""
    parts = found("spring-amplitude", frequency=response(), spring=spring()).parts
    assert {name: judge(part) for name, part in parts.items()} == {
        "peak falls": Verdict.REPRODUCED,
        "amplitude not affected": Verdict.TRANSIENT,
    }


@pytest.mark.parametrize("seed", range(12))
def test_shuffled_responses_do_not_pass(seed):
    rng = np.random.default_rng(seed)
    shuffled = {
        "frequency": response(peaks=rng.permutation([1.0, 2.0, 3.0]), amplitudes=rng.uniform(1.0, 3.0, 3), error=0.01),
        "spring": spring(*rng.uniform(1.0, 3.0, (2, 3))),
    }
    noise = rng.uniform(0.0, 1.0, (2, 3, 4))
    assert verdict("spring-amplitude", **shuffled) is Verdict.NOT_REPRODUCED
    assert verdict("spring-no-jump", frequency=response(up=noise[0], down=noise[1])) is Verdict.NOT_REPRODUCED


UP = np.array([[1.0, 2.0, 1.0, np.nan], [1.0, 2.0, 1.0, 0.5], [1.0, 2.0, 1.0, 0.5]])


@pytest.mark.parametrize(
    ("expected", "gaps"),
    [
        (Verdict.REPRODUCED, (0.0, 0.04, 0.04)),
        (Verdict.CHOSEN, (0.06, 0.04, 0.04)),
        (Verdict.NOT_REPRODUCED, (0.06, -0.06, 0.06)),
    ],
)
def test_sweeps_up_and_down_are_one_within_a_twentieth_of_the_peak(expected, gaps):
    down = UP.copy()
    down[:, 0] -= 2.0 * np.array(gaps)
    finding = found("spring-no-jump", frequency=response(up=UP, down=down))
    assert verdict("spring-no-jump", frequency=response(up=UP, down=down)) is expected
    assert [one.value for one in finding.numbers] == pytest.approx(np.abs(gaps))
    assert finding.share.value == pytest.approx(np.mean(np.abs(gaps) < 0.05))

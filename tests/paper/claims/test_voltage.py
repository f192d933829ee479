"""Verdicts on the claims about the voltage, on made-up studies."""

import numpy as np
import pytest
import xarray as xr

from gelcone.codes import Regime
from gelcone.paper.claims.voltage import _at, _extent
from gelcone.paper.effort import FULL, QUICK
from gelcone.paper.numbers import Number
from gelcone.paper.truths import Share
from gelcone.paper.verdicts import Verdict, judge
from tests.paper.made_up import checked, found, triple, verdict
from tests.paper.worlds import World, studies_in


@pytest.mark.parametrize("effort", [QUICK, FULL], ids=["quick", "full"])
def test_numbers_of_the_threshold(effort):
    """The base set and those with a soft spring are chaotic from 1.2 on but for a window."""

    def chaos(n):
        near = np.isclose(n["spring_stiffness"], 0.9, rtol=1e-9) | (n["spring_stiffness"] < 0.8)
        return (n["voltage"] >= 1.2) & ~((n["voltage"] > 1.5) & (n["voltage"] < 1.7)) & near

    studies = studies_in(World(chaos), "voltage-threshold", effort)
    finding = checked("voltage-threshold", studies)
    first = finding.numbers[0]
    assert first.meaning == "smallest voltage at which chaos was seen"
    assert first.low < 1.2 <= first.value == first.high
    assert first.high - first.low == pytest.approx(2.0 / (2 * effort.diagram_values - 2) / 2**effort.bisections)
    above = number(finding, "share of voltages in 1.04 to 2 with a positive exponent")
    assert above.low <= 0.6 / 0.96 <= above.high
    assert number(finding, "below 1.04").value == 1.0
    assert finding.share.value == 0.0  # nine of ten voltages are not chaotic in any set
    assert number(finding, "pitchfork").value == pytest.approx(0.9**0.5)
    assert [one.value for one in finding.slack] == [0.0]
    none = checked("voltage-threshold", studies_in(World(lambda n: n["voltage"] > 9.0), "voltage-threshold", effort))
    assert len(none.numbers) == len(finding.numbers) - 2


def test_voltages_above_the_threshold_are_chaotic_and_those_below_are_not():
    finding = checked(
        "voltage-threshold", studies_in(World(lambda n: n["voltage"] >= 1.04), "voltage-threshold", QUICK)
    )
    assert [number(finding, part).value for part in ("1.04 to 2 with a positive", "below 1.04", "set fast")] == [
        1.0
    ] * 3
    assert (finding.holds, finding.holds_finite, finding.share.value) == (True, True, 1.0)


def test_chaos_below_the_threshold_that_a_diagram_steps_over_is_enough_against_it():
    """Between two values of the diagram, 0.025 apart: its threshold stays, and the sample finds what lies below."""

    def chaos(n):
        return (n["voltage"] >= 1.04) | ((n["voltage"] > 0.705) & (n["voltage"] < 0.72))

    finding = checked("voltage-threshold", studies_in(World(chaos), "voltage-threshold", QUICK))
    assert finding.numbers[0].low < 1.04 <= finding.numbers[0].high
    assert 0.9 < number(finding, "below 1.04").value < 1.0
    assert (finding.holds, finding.holds_finite) == (False, False)


def number(finding, part):
    """The first number of a finding whose meaning begins so or holds it."""
    return next(one for one in finding.numbers if part in one.meaning)


@pytest.mark.parametrize(
    ("low", "high", "truth"),
    [
        (1.039, 1.04, True),
        (1.035, 1.0449, True),
        (1.03, 1.034, False),
        (1.045, 1.05, False),
        (1.03, 1.035, None),
        (1.044, 1.046, None),
        (1.04, 1.045, None),
        (1.035, 1.035, True),
    ],
)
def test_a_threshold_is_at_1_04_when_its_bracket_rounds_to_it(low, high, truth):
    assert _at(Number("threshold", high, low=low, high=high)) is truth
    assert _at(None) is False
    assert _at(Number("chaos at the end of the range", 0.0)) is False


def reach(base, spread=0.0, extent=6.0, window=4.0):
    """Largest displacements in chaos: of the base set, of the sets near, and over the window."""

    def size(n):
        own = n["drive_frequency"] == 0.1
        return np.where(own, base, extent)

    studies = studies_in(World(lambda n: n["voltage"] > 1.0, extent=size), "voltage-amplitude", QUICK)
    near = studies["neighbours"]
    offsets = np.linspace(-0.5, 0.5, near.sizes["start"]) * spread
    studies["neighbours"] = near.assign(own_extent=near["own_extent"] + xr.DataArray(offsets, dims="start"))
    ends = {"window_highest": window, "window_lowest": -window}
    studies["voltage"] = studies["voltage"].assign({name: ("voltage", [9.0, v, v]) for name, v in ends.items()})
    return studies


@pytest.mark.parametrize(
    ("expected", "changed"),
    [
        (Verdict.REPRODUCED, {"base": 6.0}),
        (Verdict.REPRODUCED, {"base": 5.5}),
        (Verdict.UNDECIDED, {"base": 6.4, "spread": 0.3}),  # nearby starts lie on both sides of 6.5
        (Verdict.TRANSIENT, {"base": 7.0, "window": 6.0}),  # at rest before the chaos it reached farther
        (Verdict.CHOSEN, {"base": 7.0}),
        (Verdict.CHOSEN, {"base": 6.0, "extent": 4.7}),
        (Verdict.NOT_REPRODUCED, {"base": 5.4, "extent": 7.0}),
    ],
)
def test_about_six_is_what_rounds_to_six(expected, changed):
    assert judge(checked("voltage-amplitude", reach(**changed))) is expected


def test_the_amplitude_is_that_of_chaos_with_the_error_of_nearby_starts():
    finding = checked("voltage-amplitude", reach(4.0, spread=0.25))
    assert (finding.numbers[0].value, finding.numbers[0].error) == pytest.approx((4.0, 0.25))
    assert finding.share.value == 1.0
    assert finding.numbers[1].value == 4.0


@pytest.mark.parametrize(("lowest", "highest"), [(-6.0, 2.0), (-2.0, 6.0), (2.0, 6.0), (-6.0, -2.0)])
def test_an_extent_is_that_of_the_farther_side(lowest, highest):
    assert _extent(xr.Dataset({"low": ("at", [lowest]), "high": ("at", [highest])}), "low", "high").tolist() == [6.0]


def test_nearby_starts_that_are_not_chaotic_count_for_nothing():
    """A periodic motion that reaches farther is no chaos; where none is chaotic the error is not known."""
    studies = reach(6.0)
    near = studies["neighbours"]
    far = near["own_extent"].values + 0.0
    far[0, 0] = 9.0
    for kind, error in ((Regime.PERIODIC, 0.0), (Regime.QUASI_PERIODIC, 0.0), (Regime.CHAOTIC, 3.0)):
        kinds = near["own_regime"].values + 0
        kinds[0, 0] = int(kind)
        own = near.assign(own_extent=(near["own_extent"].dims, far), own_regime=(near["own_regime"].dims, kinds))
        assert checked("voltage-amplitude", studies | {"neighbours": own}).numbers[0].error == pytest.approx(error)
    none = near.assign(own_regime=near["own_regime"] * 0)
    assert checked("voltage-amplitude", studies | {"neighbours": none}).numbers[0].error == np.inf


# --- spectra ----------------------------------------------------------------------------------------------------------


def spectra(late=(1.0, 0.9, 3, 0.02), early=(1.0, 0.9, 3, 0.02), fast=(1.0, 0.9, 3, 0.02)):
    """Both sets at three voltages; each (strongest line, power in lines at low, lines in the middle, flatness)."""

    def one(strongest, power, lines, flatness):
        ratio = np.array([[0.5, strongest, 3.0]] + [[0.3, 1.0, 2.0]] * 2)
        amplitude = np.array([[0.1, 1.0, 0.2], [0.1] * lines + [np.nan] * (3 - lines), [np.nan] * 3])
        return ratio, amplitude, np.array([power, 0.3, 0.0]), np.array([1e-6, 1e-4, flatness])

    each = ("set", "voltage")
    variables = {}
    for prefix, sets in (("", (fast, late)), ("early_", (fast, early))):
        parts = [np.stack(part) for part in zip(*(one(*values) for values in sets), strict=True)]
        for name, values in zip(("line_ratio", "line_amplitude", "power_in_lines", "flatness"), parts, strict=True):
            variables[prefix + name] = ((*each, "line") if "line_" in name else each, values)
    amplitude = np.broadcast_to(np.array([9.0, 1.0, 1.0, 2.0, np.nan]), (2, 3, 5))
    variables |= {
        "amplitude": ((*each, "bin"), amplitude),
        "rms": (each, [[5.0, 6.0, 7.0], [1e-9, 2.0, 3.0]]),
        "early_frequency_ratio": ("early_bin", [0.0, 0.0625, 0.125]),
    }
    return xr.Dataset(variables, coords={"set": ["fast", "base"], "voltage": [0.5, 1.04, 1.7]})


GOOD = (1.0, 0.9, 3, 0.02)


@pytest.mark.parametrize(
    ("expected", "late"),
    [
        (Verdict.REPRODUCED, GOOD),
        (Verdict.REPRODUCED, (2.05, 0.51, 2, 0.011)),
        (Verdict.REPRODUCED, (0.91, 0.9, 2, 0.011)),
        (Verdict.TRANSIENT, (1.5, 0.9, 3, 0.02)),
        (Verdict.TRANSIENT, (1.12, 0.9, 3, 0.02)),
        (Verdict.TRANSIENT, (1.0, 0.49, 3, 0.02)),
        (Verdict.TRANSIENT, (1.0, 0.9, 1, 0.02)),
        (Verdict.TRANSIENT, (1.0, 0.9, 3, 0.009)),
    ],
)
def test_spectra_go_from_a_driven_line_over_split_lines_to_broadband(expected, late):
    assert verdict("voltage-spectra", **of(spectra(late))) is expected


def of(study):
    return {"spectra": study, "voltage": triple("voltage")}


def test_spectra_of_neither_set_at_neither_time():
    bad = (1.5, 0.9, 3, 0.02)
    assert verdict("voltage-spectra", **of(spectra(bad, bad))) is Verdict.CHOSEN
    assert verdict("voltage-spectra", **of(spectra(bad, bad, bad))) is Verdict.NOT_REPRODUCED
    assert verdict("voltage-spectra", **of(spectra(GOOD, GOOD, bad))) is Verdict.CHOSEN
    assert found("voltage-spectra", **of(spectra(GOOD, GOOD, bad))).share == Share(0, 1, sample=False)


def test_numbers_of_the_spectra():
    finding = found(
        "voltage-spectra",
        voltage=triple("voltage"),
        spectra=spectra(late=(2.0, 0.9, 3, 0.02), early=(1.3, 0.9, 3, 0.02)),
    )
    line, swing, flatness = finding.numbers
    assert (line.value, line.error) == (1.3, 0.0625)
    assert swing.value == 1e-9
    assert flatness.value == 0.02
    # powers 1, 1, 4: pi^2/6/3 from the logarithms and 18/36 from their mean, over 1.94 bins of the window
    assert flatness.error == pytest.approx(0.02 * np.sqrt(1.94 * (np.pi**2 / 18.0 + 0.5)))
    assert list(finding.details.values()) == ["0.3"]
    still = spectra()
    still["early_line_amplitude"][:] = np.nan
    assert np.isnan(found("voltage-spectra", **of(still)).numbers[0].value)


# --- the device -------------------------------------------------------------------------------------------------------


def practical(
    amplitude=((1.0, 1.0, 1.0), (2.0, 2.0, 2.0)),
    onset=(6000.0, np.nan),
    pitchfork=(5500.0, 5600.0),
    pull_in=(7000.0, np.inf),
):
    each = ("initial_height", "voltage_amplitude")
    return xr.Dataset(
        {
            "window_amplitude": (each, np.array(amplitude)),
            "late_amplitude": (each, [[1e-9, 2e-9, 3e-9], [0.1, 0.2, 0.3]]),
            "onset_voltage": ("initial_height", list(onset)),
            "pitchfork_voltage": ("initial_height", list(pitchfork)),
            "pull_in_voltage": ("initial_height", list(pull_in)),
        },
        coords={"initial_height": [0.0, 20.0], "voltage_amplitude": [10.0, 30.0, 50.0]},
    )


@pytest.mark.parametrize(
    ("expected", "changed"),
    [
        (Verdict.REPRODUCED, {}),
        (Verdict.REPRODUCED, {"amplitude": ((1.0, 1.02, 1.04), (2.0, 2.0, 2.0))}),
        (Verdict.NOT_REPRODUCED, {"amplitude": ((1.0, 1.0, 1.0), (2.0, 2.0, 2.2))}),
        (Verdict.NOT_REPRODUCED, {"onset": (4900.0, np.nan)}),
        (Verdict.NOT_REPRODUCED, {"pitchfork": (9000.0, 4900.0)}),
        (Verdict.NOT_REPRODUCED, {"pull_in": (4900.0, np.inf)}),
        (Verdict.REPRODUCED, {"onset": (np.nan, np.nan), "pitchfork": (np.nan, np.nan)}),
    ],
)
def test_practical_voltages_are_a_hundredth_of_any_threshold(expected, changed):
    assert verdict("practical-voltage", practical=practical(**changed)) is expected


def test_numbers_of_the_device():
    finding = found("practical-voltage", practical=practical(amplitude=((1.0, 1.0, 1.03), (2.0, 2.0, 2.0))))
    ratio, spread, flat, raised = finding.numbers
    assert ratio.value == pytest.approx(110.0)
    assert spread.value == pytest.approx(0.03 / 1.01)
    assert (flat.value, raised.value) == (3e-9, 0.3)
    assert raised.meaning.endswith("initial height 20 mm")
    assert raised.unit == "mm"
    assert "flat rest at constant voltage" in ratio.meaning
    flatless = practical(onset=(np.nan, np.nan), pitchfork=(np.nan, np.nan))
    lowest = found("practical-voltage", practical=flatless).numbers[0]
    assert (lowest.value, "(pull-in on a slow ramp)" in lowest.meaning) == (140.0, True)

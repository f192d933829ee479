"""Verdicts on the claims about the voltage, on made-up studies."""

import numpy as np
import pytest
import xarray as xr

from gelcone.paper.truths import Share
from gelcone.paper.verdicts import Verdict
from tests.paper.made_up import CHAOTIC, cells, diagram, found, number, triple, verdict

VOLTAGES = np.concatenate([np.linspace(0.0, 1.03, 40), np.linspace(1.04, 2.0, 60)])
ABOVE = VOLTAGES >= 1.04
WINDOW = np.where(ABOVE, 1.0, -1.0)


def near(rows, of=20, across=40, extent=6.0, own=6.0, spread=0.0):
    """Parameter sets near the base set: ``rows`` of them chaotic at all voltages, the others at none."""
    chaos = np.repeat(np.arange(of)[:, None] < rows, across, axis=1)
    study = cells({"set": np.arange(of), "voltage": np.linspace(1.04, 2.0, across)}, chaos)
    starts = own + np.linspace(-0.5, 0.5, 8)[:, None] * spread * np.ones(across)
    return study.assign(
        extent=(("set", "voltage"), np.full(chaos.shape, extent)),
        own_extent=(("start", "voltage"), starts),
        own_regime=(("start", "voltage"), np.full(starts.shape, int(CHAOTIC))),
    )


def threshold(chaos=ABOVE, finite=WINDOW, second=ABOVE, rows=18, **more):
    return {
        "diagram_base_voltage": diagram("voltage", VOLTAGES, chaos, finite=finite, **more),
        "diagram_fast_voltage": diagram("voltage", VOLTAGES, second),
        "neighbours": near(rows),
        "voltage": triple("voltage"),
    }


def flipped(values, *places):
    changed = np.array(values)
    changed[list(places)] = ~changed[list(places)] if changed.dtype == bool else -changed[list(places)]
    return changed


WINDOWS = range(45, 60)


@pytest.mark.parametrize(
    ("expected", "changed"),
    [
        (Verdict.REPRODUCED, {}),
        (Verdict.REPRODUCED, {"chaos": flipped(ABOVE, 45)}),  # 59 of 60 are certain to be nearly all
        (Verdict.UNDECIDED, {"chaos": flipped(ABOVE, 45, 46, 47)}),
        (Verdict.CHOSEN, {"rows": 2}),
        (Verdict.UNDECIDED, {"rows": 10}),
        (Verdict.TRANSIENT, {"chaos": flipped(ABOVE, *WINDOWS)}),
        (Verdict.TRANSIENT, {"chaos": flipped(ABOVE, 39)}),  # one below is one too many
        (Verdict.CHOSEN, {"chaos": flipped(ABOVE, 39), "finite": flipped(WINDOW, *range(20, 39))}),
        (Verdict.CHOSEN, {"chaos": flipped(ABOVE, 39), "finite": flipped(WINDOW, *WINDOWS)}),
        (Verdict.UNDECIDED, {"chaos": flipped(ABOVE, 39), "finite": flipped(WINDOW, 45, 46, 47)}),
        (Verdict.NOT_REPRODUCED, {"chaos": ~ABOVE, "finite": -WINDOW, "rows": 0}),
    ],
)
def test_the_threshold_of_the_voltage(expected, changed):
    assert verdict("voltage-threshold", **threshold(**changed)) is expected


def test_numbers_of_the_threshold():
    chaos, second = flipped(ABOVE, *WINDOWS, 0), flipped(ABOVE, 40, 50)
    finding = found("voltage-threshold", **threshold(chaos=chaos, second=second, rows=5))
    first = finding.numbers[0]
    assert first.meaning.startswith("chaos at the end")
    assert finding.share == Share(5, 15)
    assert number(finding, "below 1.04").value == pytest.approx(0.975)
    assert finding.numbers[1].value == pytest.approx(0.75)
    assert number(finding, "positive exponent, set fast").value == pytest.approx(58.0 / 60.0)
    other = number(finding, "chaos, set fast")
    assert (other.low, other.high) == (VOLTAGES[40], VOLTAGES[41])
    assert number(finding, "pitchfork").value == pytest.approx(0.9**0.5)
    assert [one.value for one in finding.slack] == [0.8, 0.7]
    none = found("voltage-threshold", **threshold(chaos=~ABOVE & ABOVE, second=~ABOVE & ABOVE))
    assert len(none.numbers) == len(finding.numbers) - 2


def reach(base, spread=0.0, rows=18, extent=6.0):
    """Chaos at the last three values; the regular motions before reach farther."""
    chaos = np.array([0, 0, 1, 1, 1])
    lowest, highest = np.array([-9.0, -1.0, -base, -1.0, -2.0]), np.array([9.0, 1.0, 0.5 * base, 2.0, 1.0])
    own = diagram("voltage", [0.5, 1.0, 1.2, 1.6, 2.0], chaos, lowest=lowest, highest=highest)
    return {
        "diagram_base_voltage": own,
        "neighbours": near(rows, extent=extent, own=base, spread=spread),
        "voltage": triple("voltage"),
    }


@pytest.mark.parametrize(
    ("expected", "changed"),
    [
        (Verdict.REPRODUCED, {"base": 6.0}),
        (Verdict.REPRODUCED, {"base": 7.1}),
        (Verdict.REPRODUCED, {"base": 4.9}),
        (Verdict.UNDECIDED, {"base": 7.1, "spread": 0.2}),  # nearby starts lie on both sides of 7.2
        (Verdict.CHOSEN, {"base": 7.3}),
        (Verdict.CHOSEN, {"base": 6.0, "extent": 4.7}),
        (Verdict.NOT_REPRODUCED, {"base": 4.7, "extent": 7.3, "rows": 20}),
        (Verdict.CHOSEN, {"base": 6.0, "rows": 0}),  # without chaos nothing reaches 6 in chaos
    ],
)
def test_about_six_is_within_a_fifth(expected, changed):
    assert verdict("voltage-amplitude", **reach(**changed)) is expected


def test_the_amplitude_is_that_of_chaos_with_the_error_of_nearby_starts():
    finding = found("voltage-amplitude", **reach(4.0, spread=0.25))
    assert (finding.numbers[0].value, finding.numbers[0].error) == pytest.approx((4.0, 0.25))
    assert finding.share == Share(18, 2)


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


def practical(amplitude=((1.0, 1.0, 1.0), (2.0, 2.0, 2.0)), onset=(6000.0, np.nan), pitchfork=(5500.0, 5600.0)):
    each = ("initial_height", "voltage_amplitude")
    return xr.Dataset(
        {
            "window_amplitude": (each, np.array(amplitude)),
            "late_amplitude": (each, [[1e-9, 2e-9, 3e-9], [0.1, 0.2, 0.3]]),
            "onset_voltage": ("initial_height", list(onset)),
            "pitchfork_voltage": ("initial_height", list(pitchfork)),
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

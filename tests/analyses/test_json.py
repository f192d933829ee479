"""Every number that a command prints as JSON is that of the variable in its netCDF file, every name that of its code.

What `--out` would write is taken from memory; that files read back equal is tested with the files.
"""

import json

import numpy as np
import pytest

import gelcone
from gelcone.atlas.tolerances import tolerances
from gelcone.dataset import FILM_ERRORS
from gelcone.register.analyses import ANALYSES
from tests.answers import answer

BASE = ("--preset", "base")
AT = (*BASE, "--set", "voltage=0.5,0.97,1.04", "--budget", "600")
CREEPING = [f"--set={own}" for own in ("rest_height=0.4", "damping_ratio=0.2", "film=taut", "viscous_modulus_1=0.5")]
DOUBLING = (*BASE, "--over", "voltage=0.95:1.15", "--over", "drive_frequency=0.08:0.11")
COMMANDS = {
    "simulate": [(*BASE, "--film", "wrinkling", "--set", "voltage=0.5,1.3", "--periods", "3")],
    "section": [(*BASE, "--set", "voltage=0.5,0.97", "--repeats", "5", "--discard", "20")],
    "extrema": [(*BASE, "--set", "voltage=1.04", "--repeats", "5", "--discard", "20")],
    "spectrum": [(*BASE, "--set", "voltage=1.04,0.97")],
    "lyapunov": [(*AT, "--window", "50"), (*BASE, "--set", "voltage=1.04", "--budget", "600", "--window", "50")],
    "regime": [AT, (*BASE, "--set", "voltage=1.02", "--budget", "600")],
    "step": [("--set", "rest_height=0.4", "--set", "damping_ratio=0.2", "--over", "constant_voltage=0.3,0.6")],
    "creep": [(*CREEPING, "--over", "constant_voltage=0.3,0.6")],
    "transfer": [(*CREEPING, "--bias", "0.4", "--over", "drive_frequency=0.5,1.5", "--over", "amplitude=0.01,0.2")],
    "triptych": [(*BASE, "--set", "voltage=0.5,1.04", "--periods", "2", "--budget", "600")],
    "static": [
        ("--set", "spring_stiffness=1.5", "--over", "constant_voltage=0,1,1.5"),
        (*BASE, "--film", "wrinkling", "--set", "voltage=0.5,0.9", "--set", "rest_height=0.4"),
    ],
    "film": [(*BASE, "--film", "membrane", "--over", "displacement=0.3,0.9", "--over", "constant_voltage=0,0.5,0.9")],
    "validate": [
        ("--over", "displacement=0.5,1", "--over", "constant_voltage=0,0.6", "--wrinkles", way, "--elements", "20")
        for way in ("mark", "relax")
    ],
    "limits": [(*BASE, "--set", "prestretch=0.8:1.2:3")],
    "settled": [(*BASE, "--set", "voltage=0.5,0.97,1.04")],
    "operating-limits": [("--preset", "spring", "--set", "voltage=0.1")],
    "tongues": [(*BASE, "--over", "drive_frequency=0.1:2:5", "--over", "voltage=0.1:1.9:4")],
    "bifurcation": [(*BASE, "--over", "voltage=0.9:1.04:3", "--sweeps", "up", "--branches", "--budget", "600")],
    "continue": [("voltage", "0.9", "1.02", *BASE, "--checks", "2")],
    "locus": [("fold", *DOUBLING)],
    "map": [(*BASE, "--over", "voltage=0.9:1.1:3", "--over", "damping_ratio=0.01:0.02:2", "--budget", "600")],
    "sweep": [(*BASE, "--over", "damping_ratio=0.01:0.02:2", "--uncertain", "voltage=0.9:1.1", "--count", "4")],
    "basin": [(*BASE, "--set", "voltage=1.2", "--over", "displacement=-1:1:3", "--over", "velocity=-1:1:2")],
    "frequency": [
        *(("--preset", "spring", "--set", f"voltage={v}", "--over", "drive_frequency=0.3:0.9:7") for v in (0.1, 0.4)),
    ],
    "datasheet": [("--preset", "spring", "--set", "voltage=0.1", "--over", "constant_voltage=0.2,0.3")],
    "drive": [("--preset", "spring", "--lowest-frequency", "0.3", "--highest-frequency", "0.6")],
    "envelope": [
        ("--preset", "spring", "--over", "drive_frequency=0.3:0.6:2", "--over", "peak_voltage=0.1:0.9:3"),
        ("--preset", "spring", "--set", "spring_stiffness=1.5", "--over", "drive_frequency=0.3:0.5:3"),
    ],
}
NAMES = {analysis.command: name for name, analysis in ANALYSES.items()}
SHOWN_BY_COUNT = ("rest", "periodic", "quasi-periodic", "chaotic", "transient", "left the domain", "transient chaos")
WORDS = {
    "regime": SHOWN_BY_COUNT,
    "outcome": ("ok", "outside", "stretch_limit", "step_limit", "not_finite", "error", "pulled_in"),
    "sign": {-1: "negative", 0: "uncertain", 1: "positive"},
}
"""Words of codes, where they differ from the variable's own ``flag_meanings`` or it has none."""
YES_OR_NO = ("symmetric", "doubtful", "coexisting", "stable", "resting", "resolved", "supercritical", "cascade")
ATTRIBUTES = {"title", "model", "options", "gelcone_version", "device", "device_fields", *FILM_ERRORS}
"""Attributes of a file for which the JSON object has other places."""


def own_words(variable):
    """The values of a variable, words for its codes, as the file's own attributes say."""
    none = "none" if str(variable.name).startswith("fate") else "unknown"
    name = str(variable.name).replace("threshold_from", "regime").replace("threshold_to", "regime")
    kind = next((kind for kind in WORDS if name == kind or name.endswith(f"_{kind}")), None)
    if kind:
        known = WORDS[kind]
        return each(variable, lambda code: known[int(code)] if kind == "sign" or code >= 0 else none)
    if "flag_meanings" in variable.attrs:
        meanings = variable.attrs["flag_meanings"].split()
        known = dict(zip(map(int, variable.attrs["flag_values"]), meanings, strict=True))
        return each(variable, lambda code: known.get(int(code), none))
    if name.endswith(("period", "cycle")):
        return each(variable, lambda period: int(period) if period > 0 else "none")
    if name.endswith(YES_OR_NO) and variable.dtype.kind == "i":
        return each(variable, lambda code: none if code < 0 else bool(code))
    return variable


def each(codes, word):
    return np.vectorize(word, otypes=[object])(codes.values if hasattr(codes, "values") else codes).tolist()


def equal(printed, there, where):
    """Whether printed JSON is exactly what is there; not a number and infinity are words of the variable."""
    attrs = getattr(there, "attrs", {})
    words = [attrs.get(name, word) for name, word in (("nan_means", "unknown"), ("infinite_means", "infinite"))]
    there = own_words(there) if hasattr(there, "attrs") else there
    there = there.values if hasattr(there, "dims") else there
    if (isinstance(there, np.ndarray) and there.dtype.kind == "f") or isinstance(there, float | np.floating):
        there = each(np.asarray(there, dtype=float), lambda v: float(v) if np.isfinite(v) else words[int(np.isinf(v))])
    there = there.tolist() if isinstance(there, np.ndarray | np.generic) else there
    assert printed == there, where


@pytest.mark.parametrize(
    ("command", "typed"), [(command, typed) for command, ways in COMMANDS.items() for typed in ways]
)
def test_the_answer_is_the_data(command, typed, command_line, delivered):
    code, out, err = command_line(command, *typed, "--json", "--out", "results")
    assert code == 0, err
    content, result = answer(out), delivered[-1]
    found, analysis = content["result"], ANALYSES[NAMES[command]]
    if command == "sweep":
        same(found.pop("probability"), gelcone.probability(result))
        same(found.pop("tolerances"), tolerances(result))
    left_out = {n for n in map(str, result.variables) if n.startswith(("validity_", "film_state_"))}
    same(found, result, {"outcome", "initial", *analysis.file_only, *left_out})
    equal(content["outcome"], result["outcome"], "outcome")
    for name in FILM_ERRORS:
        assert content["subject"][name] == result.attrs.get(name)
    for kind in ("validity", "film_state"):
        for name, share in (content[kind] or {}).items():
            equal(share, result[f"{kind}_{name}"], name)
    assert left_out - {f"film_state_{name}" for name in content["film_state"] or ()} == {
        f"validity_{name}" for name in content["validity"] or ()
    }
    assert content["dims"] == {str(n): list(v.dims) for n, v in result.variables.items() if v.dims}
    rising(found)


def same(found, result, left_out=()):
    """Whether a JSON object holds all of a result: its attributes and variables by their names."""
    attributes = {name: own for name, own in result.attrs.items() if name not in ATTRIBUTES}
    if "totals" in attributes:
        attributes["totals"] = json.loads(attributes["totals"])
    assert set(found) == {*map(str, result.variables), *attributes} - set(left_out)
    for name, value in found.items():
        equal(value, result[name] if name in result.variables else attributes[name], name)


def rising(found):
    """Intervals rise."""
    ends = [name.removesuffix("_low") for name in found if name.endswith("_low") and f"{name[:-4]}_high" in found]
    for end in ends:
        low, high = (numbers(found[f"{end}_{side}"]) for side in ("low", "high"))
        known = np.isfinite(low) & np.isfinite(high)
        assert (low[known] <= high[known]).all(), end


def numbers(values):
    """Nested lists as an array, NaN for words."""
    return np.vectorize(lambda v: np.nan if v is None or isinstance(v, str) else v, otypes=[float])(values)


def test_every_command_is_asked():
    assert {analysis.command for analysis in ANALYSES.values()} - {"show"} == set(COMMANDS)


def test_a_device_answers_in_its_units(command_line, delivered):
    """Results, units and options are those of the file, and the dimensionless ones times the scales of the device."""
    code, out, err = command_line("regime", "soft-film", "--budget", "60 ms", "--json", "--out", "results")
    assert code == 0, err
    content, shown = answer(out), delivered[-1]
    device = gelcone.find_device("soft-film")
    times = {"budget": 0.06 / device.scales.time}
    alone = gelcone.regime(device.to_model(), device.initial_state(), **times)
    equal(content["result"]["highest"], shown["highest"], "highest")
    assert content["result"]["highest"] == pytest.approx(1e3 * device.scales.length * float(alone["highest"]))
    assert content["options"]["budget"] == pytest.approx(60.0)
    assert content["subject"]["initial"] == pytest.approx([2.0, 0.0])
    units = {str(n): v.attrs["units"] for n, v in shown.variables.items() if v.attrs.get("units", "1") != "1"}
    assert content["units"] == units

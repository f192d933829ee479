"""Every number that a command prints as JSON is that of the variable in its netCDF file, every name that of its code.

What `--out` would write is taken from memory; that files read back equal is tested with the files.
"""

import json

import numpy as np
import pytest
import xarray as xr

import gelcone
from gelcone.atlas.tolerances import tolerances
from gelcone.register.analyses import ANALYSES
from tests.answers import answer

BASE = ("--preset", "base")
AT = (*BASE, "--set", "voltage=0.5,0.97,1.04", "--budget", "600")
DOUBLING = (*BASE, "--over", "voltage=0.95:1.15", "--over", "drive_frequency=0.08:0.11")
COMMANDS = {
    "simulate": [(*BASE, "--film", "wrinkling", "--set", "voltage=0.5,1.3", "--periods", "3")],
    "section": [(*BASE, "--set", "voltage=0.5,0.97", "--repeats", "5", "--discard", "20")],
    "extrema": [(*BASE, "--set", "voltage=1.04", "--repeats", "5", "--discard", "20")],
    "spectrum": [(*BASE, "--set", "voltage=1.04,0.97")],
    "lyapunov": [(*AT, "--window", "50"), (*BASE, "--set", "voltage=1.04", "--budget", "600", "--window", "50")],
    "regime": [AT, (*BASE, "--set", "voltage=1.02", "--budget", "600")],
    "static": [
        ("--set", "spring_stiffness=1.5", "--voltages", "0,1,1.5"),
        (*BASE, "--film", "wrinkling", "--set", "voltage=0.5,0.9", "--set", "rest_height=0.4"),
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
    "drive": [("--preset", "spring", "--lowest", "0.3", "--highest", "0.6")],
    "envelope": [
        ("--preset", "spring", "--over", "drive_frequency=0.3:0.6:2", "--over", "voltage=0.1:0.9:3"),
        ("--preset", "spring", "--set", "spring_stiffness=1.5", "--over", "drive_frequency=0.3:0.5:3"),
    ],
}
RATE = "per unit dimensionless time"
SHOWN_BY_COUNT = ("rest", "periodic", "quasi-periodic", "chaotic", "transient", "left the domain", "transient chaos")
WORDS = {
    "regime": SHOWN_BY_COUNT,
    "outcome": ("ok", "outside", "stretch_limit", "step_limit", "not_finite", "error", "pulled in"),
    "sign": {-1: "negative", 0: "uncertain", 1: "positive"},
}
"""Words of codes, where they differ from the variable's own ``flag_meanings`` or it has none."""
YES_OR_NO = ("symmetric", "doubtful", "coexisting", "stable")


def own_words(variable):
    """The values of a variable, words for its codes, as the file's own attributes say."""
    name = str(variable.name)
    kind = next((kind for kind in WORDS if name == kind or name.endswith(f"_{kind}")), None)
    if kind:
        known = WORDS[kind]
        return each(variable, lambda code: known[int(code)] if kind == "sign" or code >= 0 else None)
    if "flag_meanings" in variable.attrs:
        meanings = variable.attrs["flag_meanings"].split()
        known = dict(zip(map(int, variable.attrs["flag_values"]), meanings, strict=True))
        return each(variable, lambda code: known.get(int(code)))
    if name.endswith(("period", "cycle")):
        return each(variable, lambda period: int(period) if period > 0 else None)
    if name in YES_OR_NO:
        return variable.values.astype(bool).tolist()
    return variable


def each(codes, word):
    return np.vectorize(word, otypes=[object])(codes.values if hasattr(codes, "values") else codes).tolist()


def spaced(kind):
    """A kind of event or contradiction in words."""
    return own_words(kind).replace("_", " ")


def equal(printed, there, where):
    """Whether printed JSON is exactly what is there; not a number and infinity are words of the variable, or null."""
    attrs = getattr(there, "attrs", {})
    words = [attrs.get(name) for name in ("nan_means", "infinite_means")]
    there = own_words(there) if hasattr(there, "attrs") else there
    there = there.values if hasattr(there, "values") else there
    if (isinstance(there, np.ndarray) and there.dtype.kind == "f") or isinstance(there, float | np.floating):
        there = each(np.asarray(there, dtype=float), lambda v: float(v) if np.isfinite(v) else words[int(np.isinf(v))])
    there = there.tolist() if isinstance(there, np.ndarray | np.generic) else there
    assert printed == there, where


def interval(result, name):
    ends = [own_words(result[f"{name}_{end}"]) for end in ("low", "high")]
    values = np.stack([end.values for end in ends], axis=-1)
    return xr.DataArray(values, dims=(*ends[0].dims, "end"), attrs=ends[0].attrs)


def one_branch(r, k, *path):
    own, there = r.isel(branch=k), np.isfinite(r["value"].values[k])
    match path:
        case ("number",):
            return k
        case ("born_at_event",):
            return None if int(own["born"]) < 0 else int(own["born"])
        case ("rest",):
            return bool(own["resting"])
        case ("symmetric",):
            return bool(own["symmetric"])
        case ("ended",):
            return [gelcone_words(code) for code in own_words(own["ended"])]
        case ("values",):
            return own["value"].values[there]
        case ("stable",):
            return own["stable"].values[there].astype(bool)
        case (("lowest" | "highest" | "lyapunov") as name,):
            return own[name].values[there]
        case (name,):
            return own[name]
    raise KeyError(path)


def gelcone_words(code):
    return {"limit": "the end of the interval", "merged": "a branch of half its period or a symmetric one"}.get(
        code, {"wall": "the stretch limit", "pulled_in": "pulls in", "step": "the shortest step"}.get(code, code)
    )


def one_event(r, k, of, *path):
    own = r.isel(event=k)
    home = int(own[f"event_{of}"])
    if of == "curve" and path[0] in ("parameter", "value", "value_error"):
        first, second = r.attrs["parameters"].split(",")
        ends = {"parameter": None, "value": "", "value_error": "_error"}[path[0]]
        if ends is None:
            return [first, second]
        return [float(own[f"event_{place}{ends}"]) for place in ("first", "second")]
    match path:
        case ("kind",):
            return spaced(own["event_kind"])
        case ("parameter",):
            return r.attrs["parameter"]
        case ("value",):
            return own["event_value"]
        case ("value_error",):
            return own["event_error"]
        case ("branch",):
            return home
        case ("period",):
            return int(r["period"][home])
        case ("symmetric",):
            return bool(r["symmetric"][home])
        case ("supercritical",):
            code = -1 if of == "curve" else int(own["event_supercritical"])
            return None if code < 0 else bool(code)
        case ("born_branch",):
            born = -1 if of == "curve" else int(own["event_born_branch"])
            return None if born < 0 else born
        case ("multipliers",):
            return np.stack([own["event_multiplier_real"], own["event_multiplier_imag"]], axis=-1)
    raise KeyError(path)


def followed(r, *path):
    """A variable of the branches that a diagram or response has beside it."""
    from gelcone.atlas.branches.attached import attached_branches

    beside = attached_branches(r)
    return None if beside is None and not path else continued(beside, *path)


def continued(r, *path):
    match path:
        case ("parameter",):
            return r.attrs["parameter"]
        case ("branches", k, *rest):
            return one_branch(r, k, *rest)
        case ("events", k, *rest):
            return one_event(r, k, "branch", *rest)
        case ("check", "flags", *rest):
            return a_flag(r, *rest)
        case ("check", "seeded"):
            return r["seeded"]
        case ("check", name):
            return r[f"checked_{name}"]
    raise KeyError(path)


def a_flag(r, *path):
    if not path:
        assert r.sizes["flag"] == 0
        return []
    k, name = path
    match name:
        case "kind":
            return spaced(r["flag_kind"][k])
        case "explanation":
            return str(r["flag_explanation"][k].values) or None
        case "branch":
            return None if int(r["flag_branch"][k]) < 0 else int(r["flag_branch"][k])
    return r[f"flag_{name}"][k]


def of_cells(r, *path):
    """A member of maps, basins and diagrams that all their cells have."""
    match path:
        case ("axes", dim):
            return r[dim]
        case ("counts", word):
            return int((r["regime"].values == SHOWN_BY_COUNT.index(word)).sum())
        case ("chaotic_share",):
            return float((r["regime"] == gelcone.Regime.CHAOTIC).mean())
        case ("lyapunov", "unit") | ("unit",):
            return RATE
        case ("lyapunov", name):
            return r["lyapunov" if name == "values" else name][..., 0]
        case ("totals", *rest):
            totals = json.loads(r.attrs["totals"])
            return totals[rest[0]]
        case ((("failed" | "doubtful") as kind), *rest):
            failed = r["outcome"].values != 0
            which = np.argwhere(failed if kind == "failed" else (r["doubtful"].values != 0) & ~failed)
            if not rest:
                assert len(which) == 0
                return []
            at = dict(zip(r["outcome"].dims, which[rest[0]], strict=True))
            cell = r.isel(at)
            return cell[rest[1]]
    (name,) = path
    return r[name]


def place(command, r, path):
    """What stands in the result ``r`` for a member of the JSON object of a command."""
    match (command, *path):
        case ("simulate", "largest_energy_residual"):
            return float(np.nanmax(abs(r["energy_residual"].values)))
        case ("simulate", "film_state", name):
            return r[f"film_state_{name}"]
        case ("simulate", "pull_in", "kind"):
            return each(r["pull_in_kind"], lambda code: (None, "minimum", "localisation")[int(code)])
        case ("simulate", "pull_in", name):
            return r[f"pull_in_{name}"]
        case ("lyapunov", "lyapunov", "unit") | ("regime", "regime", "evidence", "lyapunov", "unit"):
            return RATE
        case ("lyapunov", "lyapunov", name) | ("regime", "regime", "evidence", "lyapunov", name):
            return r["lyapunov" if name == "values" else name]
        case ("regime", "regime", "evidence", "section", name):
            return r["section"].isel(state=("displacement", "velocity").index(name))
        case ("regime", "regime", "name"):
            return r["regime"]
        case ("regime", "regime", "lasting", "lifetime_interval"):
            return interval(r, "lifetime")
        case ("regime", "regime", "fates", "share_interval"):
            return interval(r, "fate_share")
        case ("regime", "regime", "fates", name):
            return r[f"fate_{name}"]
        case ("regime", "regime", *_, name):
            return r[name]
        case ("tongues", "tongues", "onset_kind"):
            return own_words(r["onset_kind"])
        case ("tongues", "tongues", "boundary_voltages", *_):
            return [row[np.isfinite(row)].tolist() for row in r["boundary_voltage"].values]
        case ("tongues", "tongues", "unstable_share"):
            return float((r["margin"] > 0.0).mean())
        case ("tongues", "tongues", name):
            return r[name]
        case ("tongues", "pitchfork_amplitude"):
            return r["pitchfork_amplitude"]
        case ("tongues", name):
            return r[f"own_{name}"]
        case ("bifurcation", "parameter"):
            return r.attrs["parameter"]
        case ("bifurcation", "values"):
            return r[r.attrs["parameter"]]
        case ("bifurcation", "thresholds", k, name):
            return a_threshold(r, k, name)
        case (("bifurcation" | "frequency"), "followed", *rest):
            return followed(r, *rest)
        case ("bifurcation", "branches", branch, (("lyapunov" | "standard_error") as name)):
            return r[name].sel(branch=branch)[..., 0]
        case ("bifurcation", "branches", branch, name):
            return r[name].sel(branch=branch)
        case ("continue", *rest):
            return continued(r, *rest)
        case ("locus", "parameters"):
            return r.attrs["parameters"].split(",")
        case ("locus", "events", k, *rest):
            return one_event(r, k, "curve", *rest)
        case ("locus", "events"):
            assert r.sizes["event"] == 0
            return []
        case ("locus", "curves", k, "kind"):
            return r.attrs["event"]
        case ("locus", "curves", k, "ended"):
            return [gelcone_words(code) for code in own_words(r["ended"].isel(curve=k))]
        case ("locus", "curves", k, "number"):
            return k
        case ("locus", "curves", k, "symmetric"):
            return bool(r["symmetric"][k])
        case ("locus", "curves", k, "period"):
            return int(r["period"][k])
        case ("locus", "curves", k, name):
            there = np.isfinite(r[r.attrs["parameters"].split(",")[0]].values[k])
            return r[name].values[k][there]
        case ("sweep", "draws", name):
            return r[f"drawn_{name}"]
        case ("sweep", "probability", name):
            return gelcone.probability(r)[name]
        case ("sweep", "tolerances", name):
            return tolerances(r)[name]
        case ("sweep", "dims"):
            return list(r["regime"].dims)
        case ("basin", "attractors", k, name):
            own = r.isel(attractor_number=k)
            return k if name == "number" else own[f"attractor_{name}"]
        case ("frequency", "branches", branch, "peak", (("stroke" | "stroke_error") as name)):
            return 2.0 * r[f"peak_{name.replace('stroke', 'amplitude')}"].sel(branch=branch)
        case ("frequency", "branches", branch, "peak", name):
            return r[f"peak_{name}"].sel(branch=branch)
        case ("frequency", "branches", branch, name):
            return r[name].sel(branch=branch)
        case ("frequency", "linear", name):
            return r[f"linear_{name}"]
        case ("frequency", "jumps", *rest):
            return a_jump(r, *rest)
        case ("drive", (("largest" | "limit") as name)):
            return r.attrs[name]
        case ("drive", "sensitivity", name):
            return r["sensitivity"].values[r["field"].values.tolist().index(name)]
        case ("envelope", *rest):
            return of_envelope(r, *rest)
        case ("static", *rest):
            return of_statics(r, *rest)
        case ("sweep", (("axes" | "counts" | "totals") as kind), name):
            return of_cells(r, kind, name)
        case (("map" | "basin" | "bifurcation"), *rest):
            return of_cells(r, *rest)
    (name,) = path
    return r[name]


def a_threshold(r, k, name):
    own = {"parameter": r.attrs["parameter"]}
    if name in own:
        return own[name]
    return gelcone.thresholds_of(r)[k][name]


def a_jump(r, *path):
    if not path:
        assert r.sizes["jump"] == 0
        return []
    k, name = path
    jump = r.isel(jump=k)
    if name == "branch":
        return str(jump["jump_branch"].values)
    if name == "event_kind":
        return None if int(jump["jump_event_kind"]) < 0 else spaced(jump["jump_event_kind"])
    return jump[name.replace("stroke", "jump") if name.startswith("stroke") else f"jump_{name}"]


def status(name, voltage):
    if np.isnan(voltage):
        return "unknown" if name == "dielectric breakdown" else "not applicable"
    return "met" if np.isfinite(voltage) else "not reached"


def of_envelope(r, *path):
    match path:
        case ("static_limits", name, what):
            voltage = r["static_limit_voltage"].sel(static_limit=name)
            return voltage if what == "voltage" else status(name, voltage)
        case ("driven_limits", name, (("low" | "high") as end)):
            return r[f"limit_{end}"].sel(driven_limit=name)
        case ("driven_limits", name, "status"):
            return [status(name, v) for v in r["limit_low"].sel(driven_limit=name).values]
        case ("pull_in", name):
            return r.attrs[f"pull_in_{name}"]
        case ("first_limit",):
            return [None if i < 0 else str(r["driven_limit"][int(i)].values) for i in r["first_limit"].values]
        case ("window_motion",):
            return [None if np.isnan(code) else SHOWN_BY_COUNT[int(code)] for code in r["window_regime"].values]
        case ("kick", name):
            return r[f"kick_{name}"]
        case ("coexisting",):
            assert not (r["coexisting"] > 0).any()
            return []
        case ("coexisting", k, *rest):
            one = r.isel(drive_frequency=int(np.flatnonzero(r["coexisting"].values > 0)[k]))
            return of_coexisting(one, *rest)
    (name,) = path
    return r[name]


def of_coexisting(one, *path):
    match path:
        case ("peak",):
            return one["recommended_peak"]
        case ("kick", end):
            return one[f"kick_{end}"]
        case ("motions", n, "kind"):
            return SHOWN_BY_COUNT[int(one["motion_regime"][n])]
        case ("motions", n, "outcome"):
            return WORDS["outcome"][int(one["motion_outcome"][n])]
        case ("motions", n, *names):
            value = one["motion_" + "_".join(names)][n]
            return value if names != ["period"] else (int(value) if value > 0 else None)
    (name,) = path
    return one[name]


def of_statics(r, *path):
    """A member of the statics of one actuator; an ensemble's are told apart before."""
    match path:
        case (("fold_voltages" | "fold_displacements") as name,):
            found = r[name.removesuffix("s")].values
            return found[np.isfinite(found)]
        case ("pull_in", "kind"):
            return own_words(r["pull_in_kind"])
        case ("pull_in", name):
            return r[f"pull_in_{name}"]
        case ("equilibria", *rest):
            return of_equilibria(r, r.attrs["own_level"], *rest)
        case ("curves", i, "voltage"):
            return r["constant_voltage"][i]
        case ("curves", i, "equilibria", *rest):
            return of_equilibria(r, i, *rest)
        case ("curves", i, name):
            return r[name][i]
    (name,) = path
    return r[name]


def of_equilibria(r, level, *path):
    one = r.isel(constant_voltage=level)
    match path:
        case ():
            assert int(one["equilibria"]) == 0
            return []
        case (k, "displacement"):
            return one["equilibrium_displacement"][k]
        case (k, "stable"):
            return bool(one["stable"][k])
        case (k, "validity", name):
            return one[f"validity_{name}"][k]
        case (k, name):
            return one[name][k]
    raise KeyError(path)


def leaves(value, path=()):
    """Every member of a JSON object that holds no other, with where it stands."""
    if isinstance(value, dict) and value:
        for name, own in value.items():
            yield from leaves(own, (*path, name))
    elif isinstance(value, list) and value and isinstance(value[0], dict):
        for k, own in enumerate(value):
            yield from leaves(own, (*path, k))
    elif value != {}:
        yield path, value


def members(command, content, result):
    """Pairs of JSON object and result; the statics of an ensemble are lists over its members."""
    if command != "static" or not result["outcome"].dims:
        return [(content, result)]
    pairs = []
    for i in range(result["outcome"].size):
        own = result.isel(member=i)
        level = int(np.searchsorted(result["constant_voltage"].values, float(own["voltage"])))
        pairs.append(({name: values[i] for name, values in content.items()}, own.assign_attrs(own_level=level)))
    return pairs


@pytest.mark.parametrize(
    ("command", "typed"), [(command, typed) for command, ways in COMMANDS.items() for typed in ways]
)
def test_the_answer_is_the_data(command, typed, command_line, delivered):
    code, out, err = command_line(command, *typed, "--json", "--out", "results")
    assert code == 0, err
    content, result = answer(out), delivered[-1]
    checked = 0
    for own, data in members(command, content["result"], result):
        for path, value in leaves(own):
            equal(value, place(command, data, path), path)
            checked += 1
    assert checked >= 4
    equal(content["outcome"], result["outcome"], "outcome")
    for kind in ("validity", "film_state"):
        for name, share in (content[kind] or {}).items():
            equal(share, result[f"{kind}_{name}"], name)
    known = {n for n in map(str, result) if n.startswith("validity_")}
    assert known == {f"validity_{name}" for name in content["validity"] or ()}
    rising(content["result"])


def rising(value, name=""):
    """Intervals rise: pairs whose name says so, and ends that are called low and high."""
    if isinstance(value, dict):
        if {"low", "high"} <= value.keys():
            compare(value["low"], value["high"])
        for key, own in value.items():
            rising(own, key)
        ends = [name.removesuffix("_low") for name in value if str(name).endswith("_low")]
        for end in ends:
            compare(value[f"{end}_low"], value[f"{end}_high"])
    elif isinstance(value, list) and value and isinstance(value[0], dict):
        for own in value:
            rising(own, name)
    elif name.endswith("interval"):
        pairs = numbers(value).reshape(-1, 2)
        compare(pairs[:, 0], pairs[:, 1])


def numbers(values):
    """Nested lists as an array, NaN for words."""
    return np.vectorize(lambda v: np.nan if v is None or isinstance(v, str) else v, otypes=[float])(values)


def compare(low, high):
    low, high = (numbers(end) for end in (low, high))
    known = np.isfinite(low) & np.isfinite(high)
    assert (low[known] <= high[known]).all()


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
    evidence = content["result"]["regime"]["evidence"]
    equal(evidence["highest"], shown["highest"], "highest")
    assert evidence["highest"] == pytest.approx(1e3 * device.scales.length * float(alone["highest"]))
    assert content["options"]["budget"] == pytest.approx(60.0)
    assert content["subject"]["initial"] == pytest.approx([2.0, 0.0])
    units = {str(n): v.attrs["units"] for n, v in shown.variables.items() if v.attrs.get("units", "1") != "1"}
    assert content["units"] == units

"""Diagrams, maps, sweeps, stores and basins in words, of made-up cells."""

import json

import numpy as np
import pytest
import xarray as xr

import gelcone
from gelcone.amounts import with_error
from gelcone.analyses import (
    answer,
    grids,
)  # fmt: skip
from gelcone.atlas import probability as probability_module
from gelcone.atlas import tolerances as tolerances_module
from gelcone.codes import Outcome, Regime
from tests.analyses.said import INF, NAN, SUBJECT, said
from tests.analyses.test_motions import HOLDS
from tests.edited import edited, made
from tests.recorded import record

TOTALS = {"computed": 5, "computed_before": 0, "cells": 6, "inferred": 0, "failed": 0, "integrator_steps": 12345,
          "wall_time_s": 2.5, "checked": 0, "missed": 0, "border_dimension": None}  # fmt: skip


def test_what_a_run_of_cells_says_of_itself():
    assert grids.totals_text(TOTALS) == "5 of 6 cells computed; 12,345 steps in 2.5 s"
    more = TOTALS | {"computed_before": 2, "inferred": 1, "failed": 3, "border_dimension": [1.25, 0.125]}
    assert grids.totals_text(more).splitlines() == [
        "5 of 6 cells computed, 2 of them before, 1 inferred, 3 failed; 12,345 steps in 2.5 s",
        "borders between regimes: dimension 1.25 ± 0.12 (the work of refining grows with that power of the cells a "
        "side)",
    ]
    checked = grids.totals_text(TOTALS | {"checked": 200, "missed": 1}).splitlines()[1]
    head, _, share = checked.partition(": 0.5 % [")
    assert head.endswith("of 200 inferred cells, drawn at random and computed, 1 had another regime or sign")
    low, high = (float(end) for end in share.rstrip("]").split(", "))
    assert 0.0 < low < 0.5 < high < 5.0


def map_of(**changes):
    over = ("voltage", "damping_ratio")
    own = {
        "regime": (over, [[1, 3], [0, 3]]), "outcome": (over, [[0, 0], [0, 0]]), "doubtful": (over, [[0, 1], [0, 0]]),
        "lyapunov": ((*over, "exponent"), [[[-0.25, -1.0], [0.5, -2.0]], [[-0.75, -3.0], [0.125, -4.0]]], "1/s"),
        "standard_error": ((*over, "exponent"), np.zeros((2, 2, 2))),
    }  # fmt: skip
    coords = {"voltage": ("voltage", [800.0, 900.0], "V"), "damping_ratio": ("damping_ratio", [0.25, 0.5])}
    return edited(made(own, coords, totals=json.dumps(TOTALS)), **changes)


def test_a_map():
    head = len(answer.heading(SUBJECT, ["voltage", "damping_ratio"]))
    lines = grids.map_words(map_of(), SUBJECT).splitlines()[head:]
    assert lines == [
        "voltage 800 to 900 V, 2 values; damping_ratio 0.25 to 0.5, 2 values",
        "rest 1, periodic 1, chaotic 2 (50 % chaotic)",
        "5 of 6 cells computed; 12,345 steps in 2.5 s",
        "highest exponent +0.5 per second at voltage 800 V, damping_ratio 0.5",
        "lowest exponent -0.75 per second at voltage 900 V, damping_ratio 0.25",
        "1 of 4 doubtful: the evidence disagrees, check before you rely on it",
    ]
    alike = grids.map_words(map_of(lyapunov=-0.25), SUBJECT).splitlines()[head:]
    assert [line for line in alike if "exponent" in line] == ["exponent -0.25 per second everywhere"]
    unknown = grids.map_words(map_of(lyapunov=NAN, doubtful=0), SUBJECT).splitlines()[head:]
    assert unknown == lines[:3]


def test_cells_that_are_counted_and_missing():
    left = int(Regime.LEFT_THE_DOMAIN)
    pulled = map_of(regime=[[1, left], [left, 3]], outcome=[[0, 6], [2, 0]])
    assert answer.counts_text(pulled) == "periodic 1, chaotic 1, left the domain 1, pulled in 1"
    alone = map_of(regime=[[1, left], [left, 3]], outcome=[[0, 6], [6, 0]])
    assert answer.counts_text(alone) == "periodic 1, chaotic 1, pulled in 2"
    shown = map_of().assign(status=(("voltage", "damping_ratio"), [[1, 2], [0, 0]]))
    shown.attrs["totals"] = json.dumps(TOTALS | {"computed": 1, "inferred": 1, "cells": 4})
    assert "1 cells computed, 1 inferred, 2 missing of 4" in grids.show_words(shown, SUBJECT).splitlines()
    names = answer.outcome_names(shown)
    assert names == [["ok", "ok"], ["unknown", "unknown"]]


def thresholds(rows):
    columns = {"low": (1.25, "V"), "high": (1.5, "V"), "from": (1, "1"), "to": (3, "1"), "cascade": (1, "1")}
    own = {f"threshold_{n}": ("threshold", [v] * rows, unit) for n, (v, unit) in columns.items()}
    own["threshold_branch"] = ("threshold", ["up"] * rows)
    return made(own, parameter="voltage")


def test_changes_of_regime():
    assert grids._threshold_lines(thresholds(1)) == [
        "changes of regime:", "  up: periodic -> chaotic at voltage 1.25 to 1.5 V, by a cascade of period doublings",
    ]  # fmt: skip
    assert grids._threshold_lines(edited(thresholds(1), threshold_cascade=0))[1].endswith("1.25 to 1.5 V")
    once = grids._threshold_lines(thresholds(1).assign(threshold_of_one_path=("threshold", [1])))
    assert once[1].endswith(", by a cascade of period doublings, of one path")
    assert once[2:] == ["  of one path: another, as one from a start 1e-12 away, may have another range"]
    assert grids._threshold_lines(thresholds(0)) == ["no change of regime"]


def tolerances(**changes):
    sobol = ("parameter", "end")
    own = {
        "probability": ("risk", [0.25, NAN]), "low": ("risk", [0.125, NAN]), "high": ("risk", [0.5, NAN]),
        "decided": ("risk", [16, 0]), "stroke": ("quantile", [1.0, 2.0, 3.0], "mm"),
        "stroke_low": ("quantile", [NAN, 1.5, 2.5]), "stroke_high": ("quantile", [1.25, 2.25, INF]),
        "first_order": (sobol, [[0.25, 0.125, 0.375], [0.5, 0.375, 0.625]]),
        "total_order": (sobol, [[0.375, 0.25, 0.5], [0.75, 0.625, 0.875]]),
    }  # fmt: skip
    coords = {"risk": ("risk", ["chaos", "pull-in"]), "quantile": ("quantile", [0.05, 0.5, 0.95]),
              "parameter": ("parameter", ["prestretch", "damping_ratio"]), "end": ("end", ["value", "low",
              "high"])}  # fmt: skip
    return edited(made(own, coords), **changes)


def test_tolerances():
    lines = [
        "probability of chaos 0.25 [0.125, 0.5] of 16 draws",
        "quantiles of the stroke in mm: 5 % 1 [unknown, 1.25], 50 % 2 [1.5, 2.25], 95 % 3 [2.5, unknown]",
        "share of the stroke's variance by each parameter (Sobol indices: alone; with interactions):",
        "  damping_ratio: 0.50 [0.38, 0.62]; 0.75 [0.62, 0.88]",
        "  prestretch: 0.25 [0.12, 0.38]; 0.38 [0.25, 0.50]",
    ]
    assert grids.tolerance_lines(tolerances()) == lines
    for total in (NAN, [[NAN, 0.25, 0.5], [0.75, 0.625, 0.875]]):
        assert grids.tolerance_lines(tolerances(total_order=total))[2:] == [
            "Sobol indices of the stroke: none, for some draw has no stroke or all have the same one"
        ]
    assert grids.tolerance_lines(tolerances(stroke=NAN)) == lines[:1]
    assert grids.tolerance_lines(tolerances().drop_vars(["first_order", "total_order"])) == lines[:2]
    over = xr.concat([tolerances(), tolerances(probability=[0.75, NAN], stroke=[4.0, 5.0, 6.0])], "voltage")
    over = over.assign_coords(voltage=("voltage", [800.0, 900.0], {"units": "V"}))
    assert grids.tolerance_lines(over)[0] == f"  voltage 800 V: {'; '.join(lines[:2])}"
    assert grids.tolerance_lines(over)[1].startswith("  voltage 900 V: probability of chaos 0.75 [0.125, 0.5] of 16 ")
    assert "; quantiles of the stroke in mm: 5 % 4 [" in grids.tolerance_lines(over)[1]
    assert grids.tolerance_lines(over)[2:] == [lines[2].replace(" (Sobol", " at voltage 900 V (Sobol"), *lines[3:]]
    lower = over.assign(total_order=over["total_order"].where(over["voltage"] < 850.0))
    assert grids.tolerance_lines(lower)[2] == lines[2].replace(" (Sobol", " at voltage 800 V (Sobol")
    lost = over.assign(stroke=over["stroke"].where(over["voltage"] < 850.0))
    assert grids.tolerance_lines(lost)[1].endswith("of 16 draws")


def test_membranes_between_which_voltages_were_interpolated():
    assert grids.membranes_lines(made({})) == []
    between = made({}, membranes=json.dumps({"made": 7, "films": 64, "error": 0.00125}))
    assert grids.membranes_lines(between) == [
        "pull-in of the membrane: 7 membranes made for 64 films, the voltages of the others interpolated to 0.12 % "
        "(root "
        "mean square)"
    ]


def after_heading(function, shown, swept):
    head = len(answer.heading(SUBJECT, swept))
    return function(shown, SUBJECT).splitlines()[head:]


def test_the_texts_of_a_sweep_and_of_a_store():
    over = ("voltage", "damping_ratio")
    shown = map_of().assign(status=(over, [[1, 1], [2, 1]]), validity_near_limit=(over, [[0.0, 0.5], [0.0, 0.0]]))
    shown = shown.assign(validity_breakdown=(over, np.zeros((2, 2))))
    grid = "voltage 800 to 900 V, 2 values; damping_ratio 0.25 to 0.5, 2 values"
    counts = "rest 1, periodic 1, chaotic 2"
    holds = "of 4 motions the model does not hold in: near the stretch limit in 1 (up to 50 % of the motion)"
    total = "5 of 6 cells computed; 12,345 steps in 2.5 s"
    assert after_heading(grids.sweep_words, shown, over) == [grid, counts, holds, total]
    stored = shown.assign_attrs(totals=json.dumps(TOTALS | {"inferred": 1}))
    assert after_heading(grids.show_words, stored, over) == [
        grid, "5 cells computed, 1 inferred, 0 missing of 6", counts, holds,
    ]  # fmt: skip
    failed = edited(shown, outcome=[[0, int(Outcome.OUTSIDE)], [0, 0]])
    assert after_heading(grids.sweep_words, failed, over)[1] == f"1 of 4 runs failed: {Outcome.OUTSIDE.meaning}"
    missing = edited(failed, status=[[1, 0], [0, 1]])  # a failed cell that is not there yet does not count
    assert after_heading(grids.sweep_words, missing, over)[1] == counts
    others = shown.drop_vars(["regime", "validity_near_limit", "validity_breakdown"])
    assert after_heading(grids.sweep_words, others, over) == [grid, total]  # exponents are over another dim, too


def test_a_sweep_says_the_range_of_each_number_that_it_asked_for():
    """With the place of both ends, of the cells that are there, and words for what is not a number."""
    over = ("voltage", "damping_ratio")
    own = {
        "status": (over, [[1, 1], [1, 0]]), "outcome": (over, [[0, 0], [0, 0]]),
        "stroke": (over, [[2.0, 3.0], [1.5, 99.0]], "mm"), "pull_in_voltage": (over, [[NAN, 900.0], [INF, 1.0]], "V"),
        "onset_voltage": (over, np.full((2, 2), NAN), "V"), "onset_error": (over, np.ones((2, 2)), "V"),
        "validity_near_limit": (over, np.zeros((2, 2))), "field": (over, np.full((2, 2), 4.0), "V/um"),
        "harmonic_amplitude": ((*over, "harmonic"), np.ones((2, 2, 4)), "mm"),
    }  # fmt: skip
    axes = {"voltage": ("voltage", [800.0, 900.0], "V"), "damping_ratio": ("damping_ratio", [0.25, 0.5])}
    shown = made(own, axes)
    for name in ("pull_in_voltage", "onset_voltage"):
        shown[name].attrs.update(nan_means="not applicable", infinite_means="not reached")
    assert [line.replace("_", " ") for line in grids.number_lines(shown)] == [
        "stroke: 1.5 mm (voltage 900 V, damping ratio 0.25) to 3 mm (voltage 800 V, damping ratio 0.5)",
        "pull in voltage: 900 V; not applicable in 1 of 3 cells; not reached in 1 of 3 cells",
        "onset voltage: not applicable in 3 of 3 cells",
        "field: 4 V/um in all",
    ]
    assert grids.number_lines(shown.assign(regime=(over, np.zeros((2, 2))))) == []


def test_cells_that_are_impossible_are_counted_once():
    """Among the outcomes, neither among the failed ones nor as lost values of any number, of cells as of draws."""
    own = {"status": ("voltage", [1, 1, 1]), "outcome": ("voltage", [0, int(Outcome.IMPOSSIBLE), int(Outcome.OUTSIDE)]),
           "stroke": ("voltage", [2.0, NAN, NAN], "mm"), "current": ("voltage", [1.0, NAN, 2.0], "A")}  # fmt: skip
    shown = made(own, {"voltage": ("voltage", [700.0, 800.0, 900.0], "V")}, totals=json.dumps(TOTALS | {"failed": 2}))
    shown["current"].attrs["nan_means"] = "not applicable"
    assert after_heading(grids.sweep_words, shown, ["voltage"])[1:] == [
        f"1 of 3 runs failed: {Outcome.OUTSIDE.meaning}",
        f"1 of 3 runs cannot be made: {Outcome.IMPOSSIBLE.meaning}",
        "5 of 6 cells computed, 1 failed; 12,345 steps in 2.5 s",
        "stroke: 2 mm; unknown in 1 of 2 cells",
        "current: 1 A (voltage 700 V) to 2 A (voltage 900 V)",
    ]
    drawn = shown.rename(voltage="draw").drop_vars("draw")
    assert grids.spread_lines(drawn, ["stroke"]) == ["stroke: 2 mm, 95 % within 2 mm; none in 1 of 2 draws"]


def test_the_text_of_a_sweep_over_draws():
    own = {"status": ("draw", [1, 1, 0]), "outcome": ("draw", [0, 0, 0]), "stroke": ("draw", [2.0, 2.0, 9.0], "mm"),
           "stroke_error": ("draw", [1.0, 1.0, 1.0])}  # fmt: skip
    shown = made(own, totals=json.dumps(TOTALS), membranes=json.dumps({"made": 2, "films": 3, "error": 0.5}))
    shown = shown.assign_coords(drawn_prestretch=("draw", [1.0, 1.1, 1.2]))
    shown["stroke"].attrs["long_name"] = "free stroke"
    lines = after_heading(grids.sweep_words, shown, ["prestretch"])
    assert lines[0].startswith("3 draws of prestretch")
    assert lines[1:] == [
        "5 of 6 cells computed; 12,345 steps in 2.5 s", "free stroke: 2 mm, 95 % within 2 mm",
        "pull-in of the membrane: 2 membranes made for 3 films, the voltages of the others interpolated to 50 % "
        "(root mean "
        "square)",
    ]  # fmt: skip


def test_a_sweep_over_a_grid_of_draws_says_the_spread_where_it_is_smallest_and_largest():
    """Of the draws that are there, not of those for Sobol indices alone; the others' points are counted."""
    over = ("voltage", "draw")
    own = {
        "status": (over, [[1, 1, 0], [1, 1, 1]]), "outcome": (over, np.zeros((2, 3))),
        "stroke": (over, [[3.0, 3.0, 99.0], [1.0, 2.0, NAN]], "mm"), "stroke_error": (over, np.ones((2, 3)), "mm"),
        "validity_near_limit": (over, np.zeros((2, 3))), "validity_breakdown": (over, np.zeros((2, 3))),
        "field": (over, np.full((2, 3), 4.0), "V/um"), "onset_voltage": (over, np.full((2, 3), NAN), "V"),
        "rise": (over, [[NAN, NAN, NAN], [5.0, 5.0, 5.0]], "ms"),
        "pull_in_voltage": (over, [[900.0, 900.0, 1.0], [INF, INF, INF]], "V"),
        "lost": (over, [[NAN, NAN, NAN], [5.0, NAN, NAN]], "mm"),
    }  # fmt: skip
    shown = made(own, {"voltage": ("voltage", [800.0, 900.0], "V")}, totals=json.dumps(TOTALS))
    shown = shown.assign_coords(drawn_prestretch=("draw", [1.0, 1.1, 1.2]))
    shown["pull_in_voltage"].attrs.update(infinite_means="not reached")
    lines = [
        "stroke: 1.5 mm, 95 % within 1.025 to 1.975 mm; none in 1 of 3 draws (voltage 900 V) up to 3 mm, 95 % "
        "within 3 mm (voltage 800 V)",
        "field: 4 V/um, 95 % within 4 V/um at all points",
        "rise: 5 ms, 95 % within 5 ms; none in more than half of the draws at 1 of 2 points",
        "pull_in_voltage: 900 V, 95 % within 900 V (voltage 800 V) up to not reached in 3 of 3 draws (voltage 900 V)",
        "lost: none in more than half of the draws at 2 of 2 points",
    ]
    heading = ["voltage", "prestretch"]
    assert after_heading(grids.sweep_words, shown, heading)[-5:] == lines
    assert after_heading(grids.show_words, shown, heading)[-5:] == lines


def test_the_text_of_a_diagram():
    both = ("branch", "voltage")
    own = {"outcome": (both, [[0, 0], [0, 6]]), "regime": (both, [[0, 1], [3, 5]]), "doubtful": (both, [[1, 0], [0,
    0]]),
           "validity_near_limit": (both, [[0.0, 0.25], [0.0, 0.0]]), "validity_breakdown": (both, np.zeros((2,
           2)))}  # fmt: skip
    shown = made(own, {"branch": ("branch", ["up", "down"]), "voltage": ("voltage", [1.0, 2.0], "V")})
    shown = shown.merge(thresholds(1)).assign_attrs(parameter="voltage")
    assert after_heading(grids.bifurcation_words, shown, ["voltage"]) == [
        "voltage 1 to 2 V, 2 values",
        f"1 of 4 runs failed: {Outcome.PULLED_IN.meaning}",
        "  up: rest 1, periodic 1",
        "    of 2 motions the model does not hold in: near the stretch limit in 1 (up to 25 % of the motion)",
        "  down: chaotic 1, pulled in 1",
        f"    {HOLDS}",
        "1 of 4 doubtful: the evidence disagrees, check before you rely on it",
        "changes of regime:",
        "  up: periodic -> chaotic at voltage 1.25 to 1.5 V, by a cascade of period doublings",
    ]


def test_the_text_of_basins():
    over = ("displacement", "velocity")
    own = {
        "attractor": (over, [[0, 1], [0, -1]]),
        "outcome": (over, [[0, 0], [0, 2]]),
        "doubtful": (over, [[0, 0], [1, 0]]),
    }
    kinds = {"regime": [0, 1], "period": [0, 2], "share": [0.5, 0.25], "lyapunov": [-0.5, -0.5], "lowest": [1.0, -2.0],
             "highest": [1.0, 3.0]}  # fmt: skip
    own |= {f"attractor_{n}": ("attractor_number", v, "mm" if n.endswith("est") else "1") for n, v in kinds.items()}
    shown = made(
        own, {"displacement": ("displacement", [-5.0, 5.0], "mm"), "velocity": ("velocity", [0.0, 1.0], "m/s")}
    )
    lines = [
        "initial displacement -5 to 5 mm, 2 values; velocity 0 to 1 m/s, 2 values",
        f"1 of 4 runs failed: {Outcome.STRETCH_LIMIT.meaning}", "2 attractor(s):", "  0: rest: 50 %, at 1 mm",
        "  1: periodic, period 2: 25 %, from -2 to 3 mm", "  none: 25 % (failed or not settled)",
        "1 of 4 doubtful: the evidence disagrees, check before you rely on it",
    ]  # fmt: skip
    assert said(grids.basin_words, shown) == lines
    all_ = edited(shown, attractor=[[0, 1], [0, 1]], outcome=0, doubtful=0)
    assert said(grids.basin_words, all_) == [lines[0], *lines[2:5]]


@pytest.mark.parametrize(
    ("text", "found"),
    [
        ("up", ["up"]),
        ("down, up", ["down", "up"]),
        ("none", []),
        ("up,up", None),
        ("sideways", None),
        ("up,none", None),
    ],
)
def test_sweeps_of_a_diagram_as_they_are_typed(text, found):
    if found is None:
        with pytest.raises(gelcone.InputError, match="must be up, down, up,down or none"):
            grids.read_sweeps(text)
    else:
        assert grids.read_sweeps(text) == found


def test_the_extreme_exponents_of_a_map_have_their_own_errors():
    errors = np.array([[[0.01, 9.0], [0.02, 9.0]], [[0.03, 9.0], [0.04, 9.0]]])
    lines = grids._exponent_lines(map_of(standard_error=errors))
    assert lines[0].startswith("highest exponent +0.500 ± 0.020 per second at voltage 800 V")
    assert lines[1].startswith("lowest exponent -0.750 ± 0.030 per second at voltage 900 V")


@pytest.mark.parametrize(("apart", "extremes"), [(0.99e-6, False), (3e-6, True)])
def test_exponents_that_differ_by_less_than_their_errors_are_one(apart, extremes):
    values = -4.4 + apart * np.array([[0.0, 1.0], [0.5, 0.5]])
    found = map_of(lyapunov=np.stack([values, values - 1.0], axis=-1), standard_error=5e-7)
    lines = grids._exponent_lines(found)
    one = [f"exponent {with_error(-4.4 + apart, 5e-7)} per second everywhere"]
    assert [line.split()[0] for line in lines] == ["highest", "lowest"] if extremes else lines == one
    failed = found.assign(lyapunov=found["lyapunov"].where(found["voltage"] > 800.0))
    if not extremes:
        assert grids._exponent_lines(failed)[0].endswith("wherever it is known")


def test_numbers_that_read_the_same_have_no_places():
    at = ("voltage",)
    shown = made(
        {"status": (at, [1, 1]), "outcome": (at, [0, 0]), "stroke": (at, [2.0, 2.0 + 1e-9], "mm")},
        {"voltage": (at, [800.0, 900.0], "V")},
    )
    assert grids.number_lines(shown) == ["stroke: 2 mm in all"]


def test_draws_that_stand_for_sobol_indices_alone_are_left_out_of_spreads_and_probabilities(monkeypatch):
    """Of four draws two; the tolerances are made of all, for the indices need them."""
    own = {
        "status": ("draw", [1, 1, 1, 1]),
        "outcome": ("draw", [0] * 4),
        "stroke": ("draw", [2.0, 2.0, 7.0, 9.0], "mm"),
    }
    shown = made(own, totals=json.dumps(TOTALS)).assign_coords(drawn_prestretch=("draw", [1.0, 1.1, 1.2, 1.3]))
    asked = record(
        monkeypatch, tolerances_module, base_draws=lambda cells: cells.isel(draw=slice(2)), tolerances="the tolerances"
    )
    lines = after_heading(grids.sweep_words, shown, ["prestretch"])
    assert "2 draws of prestretch, and 2 for Sobol indices" in lines
    lost = shown.assign(outcome=("draw", [0, 0, int(Outcome.PULLED_IN), 0]))
    (line,) = [one for one in grids._grid_heading(lost, SUBJECT) if "failed" in one]
    assert line.startswith("of the draws for Sobol indices 1 of 2 runs failed: ")
    assert lines[-1] == "stroke: 2 mm, 95 % within 2 mm"
    given = record(monkeypatch, probability_module, probability="the probability")
    monkeypatch.setattr(grids, "result_json", lambda result: {"of": result} if isinstance(result, str) else {})
    kinds = shown.assign(regime=("draw", [1, 2, 3, 3]))
    found = grids.sweep_json(kinds)
    assert found == {"probability": {"of": "the probability"}, "tolerances": {"of": "the tolerances"}}
    assert given["probability"][0]["cells"].sizes["draw"] == 2
    assert asked["tolerances"][0]["cells"].sizes["draw"] == 4
    assert grids.sweep_json(shown) == {}

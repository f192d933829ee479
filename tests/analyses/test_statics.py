"""Constant voltages in words, of made-up numbers."""

import xarray as xr

import gelcone
from gelcone import words
from gelcone.analyses import statics
from gelcone.analyses.request import Subject
from gelcone.codes import Outcome
from gelcone.physics.balance import PullIn
from tests.analyses.said import INF, NAN, said
from tests.edited import coded, edited, made


def statics_of(**changes):
    over = ("constant_voltage", "equilibrium")
    own = {
        "outcome": 0, "displacement": ("displacement", [0.0], "mm"), "pitchfork_voltage": (None, NAN, "V"),
        "pitchfork_displacement": (None, 4.0, "mm"),
        "fold_voltage": ("fold", [NAN, 1300.0], "V"), "fold_displacement": ("fold", [NAN, 16.0], "mm"),
        "pull_in_kind": int(PullIn.FOLD), "pull_in_voltage": (None, 1300.0, "V"), "pull_in_from": (None, 16.0, "mm"),
        "pull_in_to": (None, 22.0, "mm"), "equilibria": ("constant_voltage", [2, 0]),
        "equilibrium_displacement": (over, [[13.0, 21.0], [NAN, NAN]], "mm"), "stable": (over, [[1, 0], [0, 0]]),
        "film_state": coded(over, [[1, 0], [0, 0]], ("taut", "hoop_slack")),
        "second_film_state": coded(over, [[0, 2], [0, 0]], ("taut", "hoop_slack", "crumpled")),
        "stroke": ("constant_voltage", [3.0, NAN], "mm"), "blocked_force": ("constant_voltage", [0.5, NAN], "N"),
        "cycle_work": ("constant_voltage", [NAN, NAN], "mJ"),
        **{f"validity_{n}": (over, [[0.0, 1.0 * (n == "near_limit")]] * 2) for n in words.FAILINGS},
    }  # fmt: skip
    return edited(made(own, {"constant_voltage": ("constant_voltage", [800.0, 1400.0], "V")}), **changes)


RAMP = f"slow voltage ramp from 0: at 1300 V the disc {PullIn.FOLD.meaning}"


def test_equilibria_at_constant_voltages():
    lines = [
        "constant voltage:",
        "  800 V: equilibria at 13 mm (stable, film hoop slack), 21 mm (unstable, second film crumpled, near the "
        "stretch limit); stroke 3 mm, blocked force 0.5 N",
        "  1400 V: no equilibrium; beyond pull-in",
        "fold at 1300 V, displacement 16 mm",
        f"{RAMP} (moves to 22 mm)",
    ]
    assert said(statics.static_words, statics_of()) == lines
    never = statics_of(pull_in_voltage=NAN, fold_voltage=NAN, pitchfork_voltage=900.0)
    assert said(statics.static_words, never)[2:] == [
        "  1400 V: no equilibrium; no slow ramp leads there",
        "pitchfork at 900 V, displacement 4 mm",
        "slow voltage ramp from 0: no stable equilibrium to start from",
    ]
    stays = statics_of(pull_in_kind=int(PullIn.NEVER), pull_in_voltage=INF)
    assert said(statics.static_words, stays)[-1] == f"slow voltage ramp from 0: {PullIn.NEVER.meaning}"
    assert said(statics.static_words, statics_of(pull_in_to=INF))[-1] == RAMP
    unreached = statics_of(stroke=[NAN, NAN])
    assert said(statics.static_words, unreached)[1].endswith("; blocked force 0.5 N, no slow ramp leads there")
    lost = statics_of(outcome=int(Outcome.OUTSIDE))
    assert said(statics.static_words, lost) == [
        f"failed: {Outcome.OUTSIDE.meaning}", "nothing can be reached inside the stretch limit",
    ]  # fmt: skip


def test_each_device_of_an_ensemble_has_all_that_a_single_one_has():
    alone = said(statics.static_words, statics_of())
    both = xr.concat([statics_of(), statics_of(pull_in_voltage=NAN)], dim="member")
    both = both.assign_coords(spring_rate=("member", [10.0, 15.0], {"units": "N/m", "quantity": "device field"}))
    lines = said(statics.static_words, both)
    at = [k for k, line in enumerate(lines) if not line.startswith(" ")]
    assert [lines[k] for k in at] == ["spring_rate 10 N/m:", "spring_rate 15 N/m:"]
    assert [line.removeprefix("  ") for line in lines[1 : at[1]]] == alone


def test_of_two_films_it_says_whose_voltage_it_is_and_how_the_ramp_goes():
    model = gelcone.ConeModel(second_film="taut", second_drive="opposite")
    begun = statics_of().assign(ramp_begin_voltage=((), 500.0, {"units": "V", "quantity": "voltage"}))
    begun = begun.assign(rest_displacement=((), 10.0, {"units": "mm", "quantity": "length"}))
    both, then = "slow voltage ramp of both films from 0 to 500 V", ", then of the first up and of the second down"
    lines = said(statics.static_words, begun, Subject(model))
    assert "constant voltage of the first film:" in lines
    assert lines[-1] == f"{both}{then}: at 1300 V the disc {PullIn.FOLD.meaning} (moves to 22 mm)"
    lost = edited(begun, pull_in_voltage=NAN)
    assert said(statics.static_words, lost, Subject(model))[-1] == f"{both}: pull-in on the way"
    never = edited(lost, rest_displacement=NAN)
    assert said(statics.static_words, never, Subject(model))[-1] == f"{both}{then}: no stable equilibrium to start from"
    together = edited(begun, ramp_begin_voltage=0.0)
    assert said(statics.static_words, together, Subject(model))[-1] == f"{RAMP} (moves to 22 mm)"
    held = said(statics.static_words, statics_of(), Subject(model.replace(second_drive="constant")))
    assert held[-1].startswith("slow voltage ramp of the first film from 0: at 1300 V")

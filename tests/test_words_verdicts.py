"""Words by verdict: made-up results for each of them, with both sides of every condition."""

import json

import numpy as np
import pytest
import xarray as xr

from gelcone import words
from gelcone.codes import Outcome, Regime, meanings
from tests.edited import coded, edited, made

NAN = np.nan


@pytest.mark.parametrize(
    ("period", "end"), [(0, "transient chaos, ends at rest"), (3, "transient chaos, ends periodic, period 3")]
)
def test_chaos_that_ends_says_in_what(period, end):
    assert words.motion_in_words(Regime.TRANSIENT_CHAOS, period) == end


@pytest.mark.parametrize(
    ("starts", "text"),
    [
        (16, "persisted for at least 700 time units; mean lifetime above 20 time units"),
        (1, "persisted for at least 700 time units"),
    ],
)
def test_chaos_that_did_not_end(starts, text):
    own = {"lifetime": 50.0, "lifetime_low": 20.0, "lifetime_high": 90.0, "chaotic_until": 700.0}
    member = made({**own, "starts": starts, "share_chaotic": 1.0})
    assert words.lasting_in_words(member) == [text]
    assert words.lasting_in_words(edited(member, lifetime=NAN)) == []


def test_chaos_in_which_one_of_many_starts_ended_did_end():
    own = {"lifetime": 50.0, "lifetime_low": 20.0, "lifetime_high": 90.0, "chaotic_until": 700.0}
    none = {"fate_regime": ("fate", [-1]), "fate_period": ("fate", [0])}
    none |= {f"fate_share{end}": ("fate", [0.0]) for end in ("", "_low", "_high")}
    member = made({**own, **none, "starts": 16, "share_chaotic": 15.0 / 16.0})
    assert words.lasting_in_words(member) == [
        "chaos lasts 50 [20, 90] time units in the mean; 15 of 16 nearby starts are still chaotic"
    ]


@pytest.mark.parametrize(
    ("regimes", "periods", "text"),
    [
        ([1, 3, -1], [2, 0, 0],
         ["starts within 1e-9 end as: periodic, period 2 75% [50%, 90%]; chaotic 25% [10%, 40%]"]),
        ([1, -1, -1], [2, 0, 0], []),
        ([1, 1, -1], [32, 32, 0],
         ["starts within 1e-9 end as: periodic, period 32 75% [50%, 90%]; another periodic, period 32 25% [10%, 40%]"]),
        ([0, 1, 2], [0, 1, 0], ["starts within 1e-9 end as: rest 75% [50%, 90%]; periodic, period 1 25% [10%, 40%]; "
                               "quasi-periodic 0% [0%, 5%]"]),
    ],
)  # fmt: skip
def test_where_nearby_starts_end(regimes, periods, text):
    shares = zip(("", "_low", "_high"), ([0.75, 0.25, 0.0], [0.5, 0.1, 0.0], [0.9, 0.4, 0.05]), strict=True)
    member = made({"fate_regime": ("fate", regimes), "fate_period": ("fate", periods)}
                  | {f"fate_share{end}": ("fate", own) for end, own in shares})  # fmt: skip
    assert words._fates_in_words(member) == text


def motion(**more):
    """The evidence for one motion: settled, unless edited."""
    own = {"outcome": 0, "period": 2, "symmetric": 1, "regime": int(Regime.PERIODIC), "zero_one": NAN,
           "cycle_distance": 2e-10, "return_distance": 3e-4, "doubtful": 0, "lifetime": NAN}  # fmt: skip
    return made(own | {"lyapunov": ("exponent", [-0.25, -0.5]), "standard_error": ("exponent", [0.01, 0.02])} | more)


@pytest.mark.parametrize(
    ("changes", "lines"),
    [
        ({}, ["settled (within 2e-10 of its size)"]),
        ({"cycle_distance": NAN}, ["points return to within 3e-04 of its size"]),
        ({"cycle_distance": NAN, "period": 0}, []),
        ({"zero_one": 0.125}, ["0-1 test 0.12", "settled (within 2e-10 of its size)"]),
        ({"doubtful": 4}, ["settled (within 2e-10 of its size)", "! the evidence disagrees"]),
    ],
)
def test_the_evidence_of_one_motion(changes, lines):
    period = changes.get("period", 2)
    kind = f"periodic, period {period}, symmetric"
    assert words.evidence_in_words(motion(**changes)) == [kind, "largest exponent -0.250 ± 0.010 per unit time", *lines]
    failed = motion(outcome=int(Outcome.PULLED_IN))
    assert words.evidence_in_words(failed) == ["failed: pulled in"]


def test_the_axes_of_a_member_have_their_own_names():
    member = xr.Dataset(
        {"a": ("sample", [1.0, 2.0]), "b": ("second_sample", [3.0, 4.0])},
        {"time": ("sample", [0.0, 1.0]), "place": ("second_sample", [5.0, 6.0]), "voltage": ("level", [1.0])},
    )
    found = words.with_own_axes(member)
    assert found["b"].dims == ("place",)
    assert found["a"].dims == ("sample",)  # whose time is its own
    assert found["voltage"].dims == ("level",)


@pytest.mark.parametrize(
    ("outcomes", "shares", "line"),
    [
        (0, 0.5, "share of the motion in which the model does not hold: near the stretch limit 50 %"),
        ([0, 0, 0], [0.0, 0.25, 0.5],
         "of 3 motions the model does not hold in: near the stretch limit in 2 (up to 50 % of the motion)"),
        ([0, 0, 0], [0.0, NAN, 0.0], "the model holds: film taut, away from its limits"),
        ([0, 0, 0], [0.5, NAN, 0.0],
         "of 2 motions the model does not hold in: near the stretch limit in 1 (up to 50 % of the motion)"),
    ],
)  # fmt: skip
def test_in_how_many_motions_the_model_does_not_hold(outcomes, shares, line):
    dims = "member" if isinstance(shares, list) else None
    found = made({"validity_near_limit": (dims, shares), "validity_breakdown": (dims, np.multiply(shares, 0.0))})
    assert words.validity_in_words(found) == [line]


@pytest.mark.parametrize(
    ("outcomes", "text"),
    [
        ([0, int(Outcome.PULLED_IN)], "pulled in"), ([int(Outcome.PULLED_IN)], "pulled in"),
        ([int(Outcome.PULLED_IN), int(Outcome.ERROR)], "run failed"), ([0, int(Outcome.OUTSIDE)], "run failed"),
        ([0, int(Outcome.IMPOSSIBLE)], "impossible"),
        ([int(Outcome.IMPOSSIBLE), int(Outcome.PULLED_IN)], "run failed"),
    ],
)  # fmt: skip
def test_runs_that_failed_are_pulled_in_or_impossible_where_all_of_them_are(outcomes, text):
    assert words.failed_in_words(outcomes) == text


@pytest.mark.parametrize(
    ("changes", "text"),
    [
        ({}, "rest: 25 %\nat 0.5 mm"),
        ({"lyapunov": 0.5}, "rest, unstable: 25 %\nat 0.5 mm"),
        ({"lyapunov": 1e-12}, "rest, unstable: 25 %\nat 0.5 mm"),
        ({"lyapunov": 0.0}, "rest: 25 %\nat 0.5 mm"),
        ({"regime": 1, "period": 1, "lyapunov": 1e-12}, "periodic, period 1, unstable: 25 %\nfrom 0 to 0.5 mm"),
        ({"regime": 2, "lyapunov": 0.5}, "quasi-periodic: 25 %\nfrom 0 to 0.5 mm"),
        ({"highest": 1.6e-6, "lowest": -0.7e-6}, "rest: 25 %\nat 2e-06 mm"),
        ({"regime": 1, "period": 2}, "periodic, period 2: 25 %\nfrom -0 to 0.5 mm".replace("-0", "0")),
        ({"regime": 3, "lyapunov": 0.5}, "chaotic: 25 %\nfrom 0 to 0.5 mm"),
    ],
)
def test_an_attractor(changes, text):
    own = {"regime": 0, "period": 0, "share": 0.25, "lyapunov": -0.5, "lowest": -1e-9, "highest": 0.5} | changes
    found = made({f"attractor_{n}": (None, v, "mm" if n.endswith("est") else "1") for n, v in own.items()})
    assert words.attractor_in_words(found) == text


def test_the_single_numbers_of_a_data_sheet_with_and_without_draws():
    units = {"drive_stroke": ("mm", "length"), "peak_current": ("mA", "current"), "apparent_power": ("mVA", "power"),
             "mean_power": ("mW", "power"), "rest_displacement": ("mm", "length")}  # fmt: skip
    values = dict(zip(units, (3.0, 1.5, 80.0, 6.0, 13.0), strict=True))
    sheet = made({n: (None, values[n], units[n][0]) for n in units}
                 | {"stiffness_at_rest": ("constant_voltage", [25.0, 15.0], "N/m")})  # fmt: skip
    pairs = [("rest height", "13 mm"), ("stiffness at rest", "25 N/m"), ("stroke of the drive", "3 mm"),
             ("peak current", "1.5 mA"), ("apparent power", "80 mVA"), ("mean power supplied", "6 mW")]  # fmt: skip
    assert words.sheet_single(sheet) == pairs
    assert words.sheet_single(edited(sheet, apparent_power=NAN)) == pairs[:2]
    ends = {f"{n}_{end}": v * f for n, v in values.items() for end, f in (("low", 0.5), ("high", 2.0))}
    toleranced = sheet.assign({n: ((), v, {"units": units[n.rpartition("_")[0]][0]}) for n, v in ends.items()})
    for end, own in (("low", [20.0, 1.0]), ("high", [30.0, 2.0])):
        toleranced[f"stiffness_at_rest_{end}"] = ("constant_voltage", own, {"units": "N/m"})
    toleranced.attrs["drawn"] = "{}"
    assert words.sheet_single(toleranced) == [
        ("rest height", "13 mm (6.5 to 26 mm)"), ("stiffness at rest", "25 N/m (20 to 30 N/m)"),
        ("stroke of the drive", "3 mm (1.5 to 6 mm)"), ("peak current", "1.5 mA (0.75 to 3 mA)"),
        ("apparent power", "80 mVA (40 to 160 mVA)"), ("mean power supplied", "6 mW (3 to 12 mW)"),
    ]  # fmt: skip


def test_the_rows_of_a_data_sheet_over_its_voltages_with_and_without_draws():
    """Rest, at 0 V, is not among the columns; the interval is that at the highest voltage."""
    units = {"constant_voltage": ("V", "voltage"), "stroke": ("mm", "length"), "capacitance": ("nF", "capacitance")}
    names = ("constant_voltage", *words.SHEET_ROWS)
    sheet = made({n: ("constant_voltage", [0.0, 500.0, 1500.0], units.get(n, ("1",))[0]) for n in names[1:]},
                 {"constant_voltage": ("constant_voltage", [0.0, 500.0, 1500.0], "V")})  # fmt: skip
    for name, (_, quantity) in units.items():
        sheet[name].attrs["quantity"] = quantity
    rows = dict(words.sheet_rows(sheet))
    assert list(rows) == ["constant voltage", *words.SHEET_ROWS.values()]
    assert rows["constant voltage"] == ["500 V", "1.5 kV"]
    assert rows["free stroke"] == ["500 mm", "1.5 m"]
    assert rows["capacitance"] == ["500 nF", "1.5 uF"]
    ends = {f"{name}_{end}": sheet[name] * factor for name in names[1:] for end, factor in (("low", 0.5), ("high", 2))}
    for name, own in ends.items():
        own.attrs = sheet[name.rpartition("_")[0]].attrs
    drawn = dict(words.sheet_rows(sheet.assign(ends).assign_attrs(drawn="{}")))
    assert drawn["constant voltage"] == [*rows["constant voltage"], "95 % at 1.5 kV"]
    assert drawn["capacitance"] == ["500 nF", "1.5 uF", "0.75 to 3 uF"]


@pytest.mark.parametrize(
    ("count", "most", "picked"),
    [(5, 20, [0, 1, 2, 3, 4]), (20, 20, list(range(20))), (9, 3, [0, 4, 8]), (10, 4, [0, 3, 6, 9]), (1, 3, [0])],
)
def test_things_are_picked_evenly_with_the_first_and_the_last(count, most, picked):
    assert words.evenly(count, most).tolist() == picked


def test_an_interval_has_one_unit_where_both_ends_have_it_and_one_number_where_they_agree():
    def of(low, high):
        attrs = {"units": "mW", "quantity": "power"}
        return words.interval_in_words(xr.Dataset({"a_low": ((), low, attrs), "a_high": ((), high, attrs)}), "a")

    assert of(2.0, 3.0) == "2 to 3 mW"
    assert of(0.5, 3.0) == "0.5 to 3 mW"
    assert of(3.0, 3.0) == "3 mW"
    assert of(NAN, 3.0) == "unknown to 3 mW"


def edited_limits(sheet):
    """The lines of a sheet none of whose limits is met."""
    return words.sheet_limits(
        sheet.assign(first_limit_voltage=((), np.inf)).assign_attrs(first_limit="none up to the voltages examined")
    )


def test_the_limits_of_a_data_sheet_of_draws():
    volts = {"pull_in_voltage": 1700.0, "first_limit_voltage": 1500.0, "safe_peak_voltage": 1200.0,
             "dielectric_breakdown_voltage": 4000.0}  # fmt: skip
    ends = {f"{n}_{end}": v + d for n, v in volts.items() for end, d in (("low", -100.0), ("high", 200.0))}
    sheet = made({n: (None, v, "V") for n, v in (volts | ends).items()}, first_limit="driven chaos", failed=0, draws=64,
                 drawn=json.dumps({"film_thickness": [0.2, 0.0125], "moving_mass": 0.03}))  # fmt: skip
    for name in sheet.data_vars:
        sheet[name].attrs["quantity"] = "voltage"
    lines = [
        "pull-in under constant voltage: 1.7 kV, 95 % within 1.6 to 1.9 kV",
        "first limit: chaos of the drive, at a peak of 1.5 kV, 95 % within 1.4 to 1.7 kV",
        "below every limit: peaks up to 1.2 kV, 95 % within 1.1 to 1.4 kV",
    ]
    rest = "tolerances: within these intervals lie 95 % of 64 draws, of film_thickness 0.2 ± 0.013, moving_mass 3 %"
    found = words.sheet_limits(sheet)
    assert found[:3] == lines
    assert " ".join(line.strip() for line in found[3:]) == rest.replace("0.013", f"{0.0125:.2g}")
    none = edited_limits(sheet)
    assert none[1] == "first limit: none up to the voltages examined"
    assert ", of which 5 have no state, of film" in " ".join(words.sheet_limits(sheet.assign_attrs(failed=5)))
    long = sheet.assign_attrs(drawn=json.dumps({f"parameter_{k}": 0.03 for k in range(12)}))
    wrapped = words.sheet_limits(long)[3:]
    assert max(map(len, wrapped)) <= 104
    assert min(map(len, wrapped[:-1])) > 104 - len("parameter_10 3 %, ")
    assert all(line.startswith("  p") for line in wrapped[1:])


def test_the_sign_of_an_exponent_in_words():
    assert words.SIGNS == {
        -1: "certainly negative", 0: "sign uncertain within the budget", 1: "certainly positive",
    }  # fmt: skip


def shares(**changes):
    own = {"hoop_slack": 0.0, "meridional_slack": 0.0, "breakdown": 0.0, "near_limit": 0.0, "beyond_membrane": NAN}
    return made({f"validity_{name}": value for name, value in (own | changes).items()})


@pytest.mark.parametrize(
    ("changes", "lines"),
    [
        ({}, ["the model holds: film taut, away from its limits"]),
        ({"breakdown": NAN}, ["the model holds: film taut, away from its limits", words.UNKNOWN_STRENGTH]),
        *(
            ({name: 0.125}, [f"share of the motion in which the model does not hold: {text} 12.5 %"])
            for name, text in {
                "hoop_slack": "hoop slack", "meridional_slack": "meridional slack", "breakdown": "above breakdown",
                "near_limit": "near the stretch limit", "beyond_membrane": "above membrane pull-in",
            }.items()
        ),
        (
            {"hoop_slack": 0.5, "near_limit": 0.25},
            ["share of the motion in which the model does not hold: hoop slack 50 %, near the stretch limit 25 %"],
        ),
        (dict.fromkeys(("hoop_slack", "meridional_slack", "breakdown", "near_limit"), NAN), []),
    ],
)  # fmt: skip
def test_where_the_model_holds(changes, lines):
    assert words.validity_in_words(shares(**changes)) == lines


def test_a_film_that_wrinkles_may_be_slack():
    film = shares().assign(film_state_taut=0.75, film_state_crumpled=0.25, second_film_state_hoop_slack=1.0)
    assert words.validity_in_words(film) == [
        "film (share of the time): taut 75.0 %, crumpled 25.0 %",
        "second film (share of the time): hoop slack 100.0 %",
        "the model holds: film away from its limits",
    ]
    many = xr.concat([film, film.assign(film_state_taut=0.25, film_state_crumpled=0.75)], "member")
    assert words.film_state_in_words(many)[0] == "film (mean share of the time): taut 50.0 %, crumpled 50.0 %"
    uneven = many.assign(film_state_crumpled=("member", [0.75, NAN]))  # known of one of them
    assert words.film_state_in_words(uneven)[0] == "film (mean share of the time): taut 50.0 %, crumpled 75.0 %"
    assert words.film_state_in_words(film.assign(film_state_taut=NAN, film_state_crumpled=NAN)) == [
        "second film (share of the time): hoop slack 100.0 %"
    ]


def test_endings_and_events_of_branches():
    said = {
        "limit": "the end of the interval", "rest": "rest", "closed": "closed", "wall": "the stretch limit",
        "pulled_in": "pulls in", "step": "the shortest step",
        "merged": "a branch of half its period or a symmetric one", "points": "the most points",
        "impossible": "no actuator",
    }  # fmt: skip
    assert said == words.ENDINGS
    for k, (_, text) in enumerate(said.items()):
        branch = made({"ended": coded("end", [k, 0], tuple(said))})
        assert words.branch_endings(branch) == [text, "the end of the interval"]
    assert words.event_label(coded(None, 1, ("fold", "period_doubling"))) == "period doubling"
    codes = coded(None, 4, ("a", "b")).assign_attrs(flag_values=[2, 4])
    assert (words.event_label(codes), meanings(codes)) == ("b", {2: "a", 4: "b"})


def test_which_motions_of_a_sweep_do_not_follow_the_drive():
    own = {"period": ("f", [1, 2, 0, 0, 0]), "outcome": ("f", [0, 0, 0, int(Outcome.PULLED_IN), 0])}
    kinds = words.kinds_of_motion(made(own | {"resting": ("f", [0, 0, 0, 0, 1])}))
    assert {kind: where.values.tolist() for kind, where in kinds.items()} == {
        "subharmonic": [False, True, False, False, False], "not periodic": [False, False, True, False, False],
    }  # fmt: skip
    earlier = words.kinds_of_motion(made(own))["not periodic"]  # files that do not state which motions rest
    assert earlier.values.tolist() == [False, False, True, False, True]
    cells = made({"regime": ("c", [int(Regime.CHAOTIC), 0, 0, int(Regime.TRANSIENT)])})
    assert words.regime_counts(cells) == {"rest": 2, "chaotic": 1, "transient": 1}


def test_lists_are_cut_at_their_length_and_members_named_by_what_varies():
    lines = [f"{k}" for k in range(words.MOST_LINES + 1)]
    assert words.shortened(lines) == [*lines[:-1], "  and 1 more (all with --json or --out)"]
    assert words.shortened(lines[:-1]) == lines[:-1]
    members = made({"outcome": ("k", [0, 0])}, {"voltage": ("k", [1.5, 2.5], "V"), "frequency": ("k", [9.0, 8.0], "Hz"),
                   "other": ("k", [7.0, 7.0])})  # fmt: skip
    for name, quantity in (("voltage", "parameter"), ("frequency", "device field"), ("other", "number")):
        members[name].attrs["quantity"] = quantity
    assert [name for name, _ in words.members_of(members)] == [
        "voltage 1.5 V, frequency 9 Hz",
        "voltage 2.5 V, frequency 8 Hz",
    ]
    assert [float(one["frequency"]) for _, one in words.members_of(members, [0])] == [9.0]
    assert [name for name, _ in words.members_of(made({"outcome": 0}))] == [""]
    gels = members.assign_coords({"material": ("k", ["a", "b"]), "material.law": ("k", [1.0, 2.0])})
    gels["material.law"].attrs["quantity"] = "parameter"
    assert words.members_of(gels)[1][0] == "material b, voltage 2.5 V, frequency 8 Hz"
    gels = gels.assign_coords({"moving_mass": ("k", [5.0, 6.0], {"units": "g", "quantity": "device field"})})
    assert words.members_of(gels)[0][0] == "material a, voltage 1.5 V, frequency 9 Hz, moving_mass 5 g"


def test_a_list_may_stand_for_more_than_its_lines():
    lines = [f"{k}" for k in range(30)]
    assert words.shortened(lines, 100) == [*lines[: words.MOST_LINES], "  and 80 more (all with --json or --out)"]
    assert words.shortened(lines[:5], words.MOST_LINES) == lines[:5]
    assert words.shortened(lines[:5], words.MOST_LINES + 1)[-1] == "  and 1 more (all with --json or --out)"


@pytest.mark.parametrize(
    ("limit", "text"), [("driven chaos", "chaos of the drive"), ("hoop slack", "hoop slack on a slow ramp")]
)
def test_the_first_limit_of_a_data_sheet(limit, text):
    volts = {"pull_in_voltage": 1700.0, "first_limit_voltage": 1500.0, "safe_peak_voltage": 1200.0,
             "dielectric_breakdown_voltage": NAN}  # fmt: skip
    sheet = made({n: (None, v, "V") for n, v in volts.items()}, first_limit=limit)
    for name in sheet.data_vars:
        sheet[name].attrs["quantity"] = "voltage"
    lines = [
        "pull-in under constant voltage: 1.7 kV", f"first limit: {text}, at a peak of 1.5 kV",
        "below every limit: peaks up to 1.2 kV",
    ]  # fmt: skip
    unknown = "dielectric strength: unknown, breakdown is not accounted for"
    assert words.sheet_limits(sheet) == [*lines, unknown]
    assert words.sheet_limits(edited(sheet, dielectric_breakdown_voltage=4e3)) == lines
    assert words.sheet_limits(sheet[["pull_in_voltage"]]) == lines[:1]


@pytest.mark.parametrize(
    ("held", "field", "lines"), [(0.0, NAN, [words.UNKNOWN_STRENGTH]), (0.0, 0.5, []), (NAN, NAN, []), (NAN, 0.5, [])]
)
def test_that_the_strength_is_missing_is_said_where_the_film_is_known(held, field, lines):
    assert words.strength_in_words(shares(near_limit=held, breakdown=field)) == lines

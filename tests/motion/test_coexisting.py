"""Motions beside the one that grows out of rest, and the kick that leads to them."""

from types import SimpleNamespace

import numpy as np
import pytest

import gelcone
from gelcone import ConeModel, Outcome, Regime
from gelcone.motion import coexisting as module
from gelcone.motion.coexisting import Motions, _narrow, coexisting
from gelcone.motion.start import start_states
from gelcone.motion.swing import Swing, settled_swing
from gelcone.motion.validity import unknown
from tests.recorded import numbers, record

WELLS = ConeModel(damping_ratio=0.3, spring_stiffness=0.5, rest_height=0.0, voltage=0.05, voltage_bias=1.6)
"""Two wells, mirror images of each other, and next to no drive: a kick over the hill leads from one to the other."""
PUMP = gelcone.find_device("biased-pump").replace(film="taut")


def pump(hertz, volts):
    model, scales = PUMP.to_model(), PUMP.scales
    peak = volts / scales.voltage / float(model.voltage + model.voltage_bias)
    drive = {"voltage": peak * float(model.voltage), "voltage_bias": peak * float(model.voltage_bias)}
    model = model.replace(drive_frequency=np.atleast_1d(hertz) / scales.frequency, **drive)
    return model, start_states(model, (PUMP.initial_state()[0] + 1e-3, 0.0))


@pytest.fixture(scope="module")
def wells():
    model = WELLS.replace(drive_frequency=np.array([3.0]))
    start = np.array([[float(gelcone.settled(WELLS.replace(drive_frequency=3.0))["highest"]), 0.0]])
    return model, start, coexisting(model.members(), start)


def test_the_mirror_image_coexists_and_the_kick_over_the_hill_leads_there(wells):
    model, start, found = wells
    assert found["motions"].tolist() == [1]
    own = settled_swing(model.members(), start)
    assert found["highest"][0, 0] == pytest.approx(-float(own.lowest[0]), abs=1e-6)
    assert found["regime"][0, 0] == Regime.PERIODIC
    # without damping the kick that just climbs the hill at x = 0 would do; with it more is needed
    held = WELLS.replace(voltage=0.0)
    energy = [float(held.energy(x)) - 0.5 * 1.6**2 * x * x for x in (0.0, float(own.highest[0]))]
    assert found["kick_high"][0] > np.sqrt(2.0 * (energy[0] - energy[1]))


def test_below_the_interval_kicks_lead_back_and_above_they_lead_away(wells):
    model, start, found = wells
    own = settled_swing(model.members(), start)
    kicked = np.repeat(own.final, 2, axis=0)
    members = model.members().take([0, 0])
    kicked[:, 1] -= [0.95 * found["kick_low"][0], 0.0]
    assert settled_swing(members, kicked).highest[0] == pytest.approx(own.highest[0], abs=1e-4)
    assert found["kick_low"][0] < found["kick_high"][0] < found["kick_tried"][0]
    assert found["motion_kick_low"][0, 0] <= found["kick_high"][0] <= found["motion_kick_high"][0, 0]


@pytest.mark.slow
def test_other_phases_give_an_interval_that_overlaps(wells):
    model, start, found = wells
    for shift in (0.3, 0.5):
        again = coexisting(model.members(), start, shift=shift)
        assert again["kick_low"][0] <= found["kick_high"][0]
        assert found["kick_low"][0] <= again["kick_high"][0]


def test_one_well_has_no_other_motion():
    alone = WELLS.replace(voltage_bias=0.2, drive_frequency=np.array([1.0, 1.5]))
    found = coexisting(alone.members(), start_states(alone, (0.01, 0.0)))
    assert found["motions"].tolist() == [0, 0]
    assert np.isinf(found["kick_low"]).all()
    assert found["stroke"].shape == (2, 0)


def test_the_pump_can_be_kicked_into_a_motion_beyond_breakdown():
    """Between 1.8 and 2.25 kV at 29.75 Hz it moves by half a millimetre, and by 250 mm after (0 mm, 10 m/s)."""
    model, start = pump(29.75, 2027.0)
    found = coexisting(model.members(), start)
    millimetres, speed = 1e3 * PUMP.scales.length, PUMP.scales.velocity
    assert found["motions"].tolist() == [1]
    assert found["stroke"][0, 0] * millimetres == pytest.approx(250.0, rel=0.02)
    assert 0.4 < found["validity"][0, 0, 2] < 0.55
    assert 5.0 < found["kick_low"][0] * speed < found["kick_high"][0] * speed < 10.3
    thrown = settled_swing(model.members(), np.array([[0.0, 10.0 / speed]]))
    assert thrown.outcome.tolist() == [Outcome.OK]
    assert 2.0 * thrown.amplitude[0] * millimetres == pytest.approx(250.0, rel=0.02)


class MadeUpKicks:
    """Kicks that lead from one motion to another when they exceed a least size, which has a sharp valley at a phase."""

    def __init__(self, valley):
        self.valley = valley

    def least(self, phases):
        off = np.abs(np.asarray(phases) - self.valley) % 1.0
        return 1.0 + 20.0 * np.minimum(off, 1.0 - off)

    def after(self, rows, phases, kicks):
        return [motion(1.0 if leads else 0.1) for leads in np.abs(kicks) > self.least(phases)]


def motion(size):
    made = Swing.blank(1)
    made.lowest[:], made.highest[:], made.period[:] = -size, size, 1
    return made


@pytest.mark.parametrize("valley", [0.01, 0.172, 0.49])
def test_the_interval_of_the_smallest_kick_holds_that_between_the_phases_tried(valley):
    kicks, phases = MadeUpKicks(valley), np.arange(6) / 6.0
    found = [Motions([motion(0.1)], [(np.nan, np.nan)])]
    sizes = 2.0 ** np.ceil(np.log2(kicks.least(phases)))
    _narrow(kicks, np.array([0]), found, {0: list(zip(phases, sizes, strict=True))})
    low, high = found[0].smallest
    assert low <= 1.0 <= high < 1.5


def test_a_kick_to_one_side_is_narrowed_down_on_that_side():
    """Those to the other side lead nowhere, at no phase."""

    class Kicks(MadeUpKicks):
        def after(self, rows, phases, kicks):
            return [motion(1.0 if leads else 0.1) for leads in -np.asarray(kicks) > self.least(phases)]

    kicks, phases = Kicks(0.01), np.arange(6) / 6.0
    found = [Motions([motion(0.1)], [(np.nan, np.nan)])]
    sizes = -(2.0 ** np.ceil(np.log2(kicks.least(phases))))
    _narrow(kicks, np.array([0]), found, {0: list(zip(phases, sizes, strict=True))})
    low, high = found[0].smallest
    assert low <= 1.0 <= high < 1.5


def test_kicks_stay_within_what_a_disc_does_where_the_stretch_limit_is_far():
    model = ConeModel(stretch_limit=1e6, damping_ratio=0.1, voltage=0.3)
    assert module._farthest(model.members(), 0) == module.FARTHEST_KICKED
    assert module._farthest(model.replace(stretch_limit=10.0).members(), 0) < module.FARTHEST_KICKED


# --- made-up motions --------------------------------------------------------------------------------------------------


def failed(outcome):
    made = motion(np.nan)
    made.outcome[:] = outcome
    return made


@pytest.mark.parametrize(
    ("one", "other", "same"),
    [
        (motion(1.0), motion(1.0009), True),
        (motion(1.0), motion(1.0012), False),
        (motion(1e-6), motion(9e-6), True),  # of at least a hundredth
        (motion(1.0), failed(Outcome.PULLED_IN), False),
        (failed(Outcome.PULLED_IN), failed(Outcome.STEP_LIMIT), True),
    ],
)
def test_motions_are_one_where_both_ends_agree_and_all_that_fail_are(one, other, same):
    assert module._same(one, other) is same
    assert module._same(other, one) is same
    for period in (0, 2):  # without a period, or of another, they agree to a hundredth
        loose = motion(1.009)
        loose.period[:] = period
        assert module._same(motion(1.0), loose) is True
    shifted = motion(1.0)
    shifted.lowest[:] += 0.02
    assert module._same(motion(1.0), shifted) is False


def test_a_climb_doubles_its_kicks_and_notes_the_first_that_leads_away():
    """At each phase and to either side; to motions of two sizes."""
    asked = []

    class Kicks:
        phases, signs, largest = np.array([0.0, 0.5]), np.array([1.0, -1.0]), np.array([8.0, 8.0])

        def after(self, rows, phases, kicks):
            asked.extend(zip(rows.tolist(), phases.tolist(), kicks.tolist(), strict=True))
            size = np.where(kicks >= 2.0, np.where(phases == 0.5, 3.0, 1.0), 0.1)
            return [motion(s if row == 0 else 0.1) for row, s in zip(rows, size, strict=True)]

    found, shares = [Motions([motion(0.1)], [(np.nan, np.nan)]) for _ in range(2)], []
    leading = module._try_kicks(Kicks(), np.array([0, 1]), found, shares.append)
    assert leading == {0: [(0.0, 2.0), (0.5, 2.0)], 1: []}
    assert sorted({abs(size) for _, _, size in asked}) == [8.0 / 2**k for k in range(module.LEVELS - 1, -1, -1)]
    assert len(asked) == 2 * 4 * module.LEVELS
    assert [float(one.highest[0]) for one in found[0].kinds] == [0.1, 1.0, 3.0]
    assert found[0].kick[1:] == [(1.0, 2.0)] * 2
    assert len(found[1].kinds) == 1
    assert sum(shares) == pytest.approx(0.7)


def test_a_first_kick_that_leads_away_has_no_lower_end():
    class Kicks:
        phases, signs, largest = np.array([0.0]), np.array([1.0]), np.array([1.0])

        def after(self, rows, phases, kicks):
            return [motion(1.0) for _ in rows]

    found = [Motions([motion(0.1)], [(np.nan, np.nan)])]
    module._try_kicks(Kicks(), np.array([0]), found, lambda share: None)
    assert found[0].kick[1] == (0.0, 2.0 ** (1 - module.LEVELS))
    assert module._smallest([(0.1, 0.5), (0.3, -0.25), (0.7, 0.25)]) == [(0.3, -0.25), (0.7, 0.25)]


@pytest.fixture
def settling(monkeypatch):
    """Where discs begin decides which motion they settle on; rows are told by their voltage."""
    asked = []

    def settle(members, states, **options):
        volts = members.values["voltage"]
        asked.extend(zip(volts.tolist(), states[:, 0].tolist(), strict=True))
        made = Swing.blank(members.size)
        size = np.where(np.abs(states[:, 0]) > 1.0, 3.0, np.where(states[:, 0] > 0.3, 1.0, 0.1))
        made.lowest[:], made.highest[:], made.period[:] = -size, size, 1
        made.final[:, 0] = states[:, 0]
        made.outcome[:] = np.where(states[:, 0] < -1.0, Outcome.PULLED_IN, Outcome.OK)
        return made

    monkeypatch.setattr(module, "settled_swing", settle)
    return asked


def test_the_disc_is_let_go_on_both_sides_up_to_its_reach(settling, monkeypatch):
    monkeypatch.setattr(module, "_farthest", lambda members, k: 2.0 if k else 0.8)
    members = ConeModel(voltage=[0.1, 0.2]).members()
    found = [Motions([motion(0.1)], [(np.nan, np.nan)]) for _ in range(2)]
    module._try_releases(members, np.array([0, 1]), found, {})
    assert sorted(settling) == [(0.1, -0.8), (0.1, -0.4), (0.1, 0.4), (0.1, 0.8), *[(0.2, x) for x in (-2, -1, 1, 2)]]
    assert [float(one.highest[0]) for one in found[0].kinds] == [0.1, 1.0]
    assert [float(one.highest[0]) for one in found[1].kinds] == [0.1, 1.0, 3.0]  # -2 fails and counts for nothing


def test_motions_are_handed_on_to_both_neighbours_that_run_until_none_is_new(settling):
    members = ConeModel(voltage=[0.1, 0.2, 0.3, 0.4]).members()
    found = [Motions([motion(0.1)], [(np.nan, np.nan)]) for _ in range(4)]
    for own in found:
        own.kinds[0].final[:] = 0.0
    new = motion(1.0)
    new.final[:] = 0.5
    found[1].number_of(new)
    module._try_neighbours(members, np.array([0, 1, 2]), found, {})
    assert [[float(one.highest[0]) for one in own.kinds] for own in found] == [[0.1, 1.0]] * 3 + [[0.1]]
    large = [volts for volts, state in settling if state == 0.5]
    assert sorted(large) == [0.1, 0.2, 0.2, 0.3]
    assert 0.4 not in {volts for volts, _ in settling}


def test_results_list_the_others_by_rising_kick(monkeypatch):
    classes = SimpleNamespace(regime=np.array([Regime.CHAOTIC, Regime.PERIODIC, Regime.REST]))
    monkeypatch.setattr(module, "classify", lambda members, states, **flow: classes)
    monkeypatch.setattr(
        module,
        "swing",
        lambda members, states, **flow: SimpleNamespace(validity=np.arange(3)[:, None] + unknown(3) * 0),
    )
    members = ConeModel(voltage=[0.1, 0.2]).members()
    first = Motions(
        [motion(k) for k in (0.1, 1.0, 2.0, 3.0)], [(np.nan,) * 2, (np.nan,) * 2, (4.0, 8.0), (1.0, 2.0)], (1.5, 1.6)
    )
    second = Motions([motion(0.1), failed(Outcome.PULLED_IN)], [(np.nan,) * 2, (0.5, 1.0)], (0.7, 0.8))
    found = module._as_arrays(members, [first, second], np.array([9.0, 8.0]), {})
    np.testing.assert_array_equal(found["stroke"], [[6.0, 4.0, 2.0], [np.nan] * 3])
    np.testing.assert_array_equal(found["motion_kick_low"], [[1.0, 4.0, np.nan], [0.5, np.nan, np.nan]])
    np.testing.assert_array_equal(found["motion_kick_high"], [[2.0, 8.0, np.nan], [1.0, np.nan, np.nan]])
    np.testing.assert_array_equal(
        found["regime"],
        [[Regime.CHAOTIC, Regime.PERIODIC, Regime.REST], [Regime.LEFT_THE_DOMAIN, np.nan, np.nan]],
    )
    np.testing.assert_array_equal(found["outcome"], [[0, 0, 0], [Outcome.PULLED_IN, np.nan, np.nan]])
    assert found["motions"].tolist() == [3, 1]
    assert (found["kick_low"].tolist(), found["kick_high"].tolist()) == ([1.5, 0.7], [1.6, 0.8])
    assert found["kick_tried"].tolist() == [9.0, 8.0]


def test_the_largest_kick_carries_the_disc_from_rest_to_nine_tenths_of_its_reach():
    """By its energy without voltage; the velocity is the root of twice what it gains."""
    members = ConeModel(stretch_limit=[5.0, 50.0], voltage=1.3).members()
    reach = np.array([float(members.system.film.reach(members.numbers_at(k))[1]) for k in range(2)])
    gained = np.asarray(members.energy(0.9 * reach)) - np.asarray(members.energy(np.zeros(2)))
    np.testing.assert_allclose(module._largest_kicks(members), np.sqrt(2.0 * gained), rtol=1e-12)


def test_kicks_of_a_double_cone_stay_within_the_reach_of_both_films():
    """The second film ends before the first, and beyond it there is no energy."""
    members = gelcone.find_device("double-cone").replace(film="taut").to_model().members()
    first, second = (film.reach(members.numbers_at(0))[1] for film in members.system.films)
    assert module._farthest(members, 0) == pytest.approx(0.9 * second)
    assert second < 0.9 * first
    assert np.isfinite(module._largest_kicks(members)).all()


def test_a_kick_gives_what_the_energy_has_more_there_than_at_rest(monkeypatch):
    """A spring whose energy at the rim is not zero: from 10 to 12 is 2 more, and the velocity 2."""
    record(monkeypatch, module, _farthest=lambda members, k: [1.0, 2.0][k])
    springs = SimpleNamespace(size=2, energy=lambda x: 10.0 + 2.0 * np.asarray(x) ** 2)
    np.testing.assert_allclose(module._largest_kicks(springs), [2.0, 4.0])


# --- what is handed on ------------------------------------------------------------------------------------------------

FLOW = {"threads": 5, "tolerance": 2e-9}


def kicks_of(count, **changes):
    members = ConeModel(damping_ratio=0.1, voltage=0.1 + 0.1 * np.arange(count), voltage_bias=0.3).members()
    own = Swing.blank(count)
    own.final[:], own.period[:] = numbers(count, 2, at=2.0), 1
    own.lowest[:], own.highest[:] = -0.5, 0.75
    return module._Kicks(members, Swing(**(vars(own) | changes)), np.full(count, 8.0), 0.5, FLOW)


def test_a_kick_strikes_at_its_phase_and_the_motion_that_it_leaves_is_settled_anew(monkeypatch):
    """Of four kicks the second is at phase 0, which is that of the end of a period; the third motion ends, the fourth
    comes back at once, and the others are looked for again before they are settled."""
    kicks = kicks_of(2)
    assert kicks.phases.tolist() == ((np.arange(module.PHASES) + 0.5) / module.PHASES).tolist()
    rows, phases, sizes = np.array([0, 1, 1, 0]), np.array([0.25, 1.0, 0.5, 0.75]), np.array([0.5, -0.25, 1.0, 2.0])
    whole, runs = 2.0 * np.pi / np.ravel(kicks.members.number("drive_frequency"))[0], []

    def integrated(members, states, times, *, start=0.0, **flow):
        runs.append((members.number("voltage").tolist(), np.array(states), times[:, 0], start, flow))
        outcome = np.array([0, 0, 4, 0][: len(states)], dtype=np.int8)
        return SimpleNamespace(states=numbers(len(states), 1, 2, at=10.0 * len(runs)), outcome=outcome)

    final = Swing.blank(2)
    final.final[:] = numbers(2, 2, at=90.0)
    asked = record(
        monkeypatch, module, integrate=integrated, settled_swing=final,
        settle=lambda members, states, repeats, **flow: (states + 100.0, np.zeros(len(states), dtype=np.int8)),
        repeats_lasting=lambda members, duration: np.full(members.size, 7), transient_of_the_disc=np.array([3.0, 4.0]),
    )  # fmt: skip
    back = iter([np.array([False, False, True]), *[np.array([False, False])] * (module.EARLY_CHECKS - 1)])
    monkeypatch.setattr(module._Kicks, "_back", lambda own, rows, states: next(back))
    found = kicks.after(rows, phases, sizes)
    (volts, states, times, _, flow), (more, struck, until, clock, flow_too) = runs
    assert volts == more == [0.1, 0.2, 0.2, 0.1]
    np.testing.assert_array_equal(states, kicks.own.final[rows])
    np.testing.assert_allclose(times, whole * np.array([0.25, 1.0, 0.5, 0.75]))
    np.testing.assert_allclose(struck, numbers(4, 1, 2, at=10.0)[:, 0] + np.column_stack([np.zeros(4), sizes]))
    np.testing.assert_allclose(until, whole)
    np.testing.assert_allclose(clock, whole * np.array([0.25, 0.0, 0.5, 0.75]))
    assert flow == flow_too == FLOW
    assert [call["members"].size for call in asked["settle"]] == [3] + [2] * (module.EARLY_CHECKS - 1)
    for call in (*asked["settle"], *asked["settled_swing"]):
        assert {name: call[name] for name in FLOW} == FLOW
    (settled,) = asked["settled_swing"]
    assert settled["only_extent"] is True
    assert settled["members"].number("voltage").tolist() == [0.1, 0.2]
    begun = numbers(4, 1, 2, at=20.0)[:2, 0] + 100.0 * module.EARLY_CHECKS
    np.testing.assert_allclose(settled["states"], begun)
    np.testing.assert_array_equal([one.final[0] for one in found[:2]], numbers(2, 2, at=90.0))
    assert [int(one.outcome[0]) for one in found] == [0, 0, 4, 0]
    np.testing.assert_array_equal(found[3].final[0], kicks.own.final[0])


def test_a_motion_is_back_where_it_is_closer_to_its_own_cycle_than_another_could_be():
    """Velocities are measured by 2 pi over the forcing period, half that of the drive without a bias; sizes count from
    a hundredth on; no other than one that repeats with the forcing is ever back."""
    members = ConeModel(damping_ratio=0.1, voltage=0.3, drive_frequency=np.full(4, 0.5)).members()
    kicks = kicks_of(4, period=np.array([1, 1, 1, 2]))
    kicks.members = members
    rows, scale = np.arange(4), 2.0 * np.pi / (np.pi / 0.5)
    near = module.ARRIVED * 0.75
    off = np.array([[0.9 * near, 0.0], [0.0, 0.9 * near * scale], [0.0, 1.1 * near * scale], [0.0, 0.0]])
    assert kicks._back(rows, kicks.own.final + off).tolist() == [True, True, False, False]
    small = kicks_of(1, lowest=np.array([-1e-4]), highest=np.array([1e-4]))
    assert small._back(np.array([0]), small.own.final + np.array([0.9e-2 * module.ARRIVED, 0.0])).tolist() == [True]


def test_motions_are_sought_with_the_options_and_each_step_has_what_the_one_before_found(monkeypatch):
    own = Swing.blank(3)
    own.outcome[:] = 0, 4, 0
    asked = record(
        monkeypatch, module, settled_swing=own, _largest_kicks=np.array([7.0, 8.0, 9.0]), _try_kicks="leading",
        _try_releases=None, _try_neighbours=None, _narrow=None, _as_arrays={"found": 1},
    )  # fmt: skip
    members, states, shares = ConeModel(voltage=[0.1, 0.2, 0.3]).members(), numbers(3, 2), []
    assert coexisting(members, states, threads=5, progress=shares.append, shift=0.25) == {"found": 1}
    flow = {"threads": 5, "tolerance": module.TOLERANCE}
    names = "settled_swing", "_try_kicks", "_narrow", "_as_arrays"
    (first,), (tried,), (narrow,), (arrays,) = (asked[name] for name in names)
    assert {name: first[name] for name in flow} == flow
    np.testing.assert_array_equal(first["states"], states)
    assert tried["kicks"] is narrow["kicks"]
    assert tried["kicks"].flow == arrays["flow"] == flow
    assert asked["_try_releases"][0]["flow"] == asked["_try_neighbours"][0]["flow"] == flow
    assert tried["kicks"].phases[0] == 0.25 / module.PHASES
    assert tried["kicks"].own is own
    for name in ("_try_kicks", "_try_releases", "_try_neighbours", "_narrow"):
        assert asked[name][0]["alive"].tolist() == [0, 2]
        assert asked[name][0]["found"] is arrays["found"]
    assert narrow["leading"] == "leading"
    assert arrays["largest"].tolist() == tried["kicks"].largest.tolist() == [7.0, 8.0, 9.0]
    assert sum(shares) == pytest.approx(1.0)

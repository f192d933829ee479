"""Every verdict that a claim about ranges can have is given in a made-up world, in quick and full runs."""

from dataclasses import replace

import numpy as np
import pytest

from gelcone.codes import Regime
from gelcone.paper.effort import FULL, QUICK
from gelcone.paper.verdicts import Verdict, judge
from gelcone.presets import find_preset
from tests.paper.made_up import checked
from tests.paper.worlds import LEFT, World, studies_in, verdict_in

RUNS = pytest.mark.parametrize("effort", [QUICK, FULL], ids=["quick", "full"])
BASE = find_preset("base").model
REST, PERIODIC, CHAOS = int(Regime.REST), int(Regime.PERIODIC), int(Regime.CHAOTIC)


def own_set(n):
    """Whether the drive frequency is that of the base set, which no drawn set has."""
    return n["drive_frequency"] == float(BASE.drive_frequency)


def from_voltage(edge):
    return lambda n: n["voltage"] >= edge


def order(n, shift=0.0):
    low = n["prestretch"] < 0.9 + shift
    return np.where(low, CHAOS, np.where(n["prestretch"] < 1.2 + shift, PERIODIC, REST))


def pocket(n):
    """Chaos above the voltage 0.5 but for a hole, narrow against the map."""
    hole = (abs(n["voltage"] - 1.25) < 0.15) & (abs(n["prestretch"] - 1.0) < 0.12)
    return (n["voltage"] > 0.5) & ~hole


def only(mode, rule):
    return lambda n: rule(n) & (n["mode"] == mode)


def grows_but_at(voltage):
    """An extent that grows with the stretch limit, but at one voltage."""
    return lambda n: np.where(n["voltage"] == voltage, 1.0, n["stretch_limit"])


NEVER, ALWAYS = World(lambda n: n["voltage"] < -1.0), World(lambda n: n["voltage"] > -1.0)
LOW_J = World(lambda n: n["stretch_limit"] < 1.5)
SAFE = World(lambda n: (n["prestretch"] < 1.5) & (n["voltage"] > 1.0))

TABLE = [
    ("voltage-threshold", Verdict.REPRODUCED, World(from_voltage(1.04))),
    ("voltage-threshold", Verdict.NOT_REPRODUCED, NEVER),
    ("voltage-threshold", Verdict.NOT_REPRODUCED, World(from_voltage(1.6))),
    ("voltage-threshold", Verdict.CHOSEN, World(lambda n: from_voltage(1.04)(n) & own_set(n))),
    ("voltage-threshold", Verdict.CHOSEN, World(lambda n: from_voltage(1.04)(n) & ~own_set(n))),
    ("voltage-threshold", Verdict.CHOSEN, World(from_voltage(1.01))),  # near the threshold is not at it
    ("voltage-threshold", Verdict.TRANSIENT, World(NEVER.kind, finite=from_voltage(1.04))),
    ("voltage-amplitude", Verdict.REPRODUCED, ALWAYS),
    ("voltage-amplitude", Verdict.NOT_REPRODUCED, NEVER),
    ("voltage-amplitude", Verdict.NOT_REPRODUCED, World(ALWAYS.kind, extent=lambda n: 7.1)),  # the wall
    ("voltage-amplitude", Verdict.CHOSEN, World(ALWAYS.kind, extent=lambda n: np.where(own_set(n), 6.0, 4.0))),
    ("voltage-amplitude", Verdict.CHOSEN, World(ALWAYS.kind, extent=lambda n: np.where(own_set(n), 4.0, 6.0))),
    ("prestretch-order", Verdict.REPRODUCED, World(order)),
    ("prestretch-order", Verdict.NOT_REPRODUCED, World(lambda n: order(n, 9.0))),
    ("prestretch-order", Verdict.CHOSEN, World(lambda n: np.where(own_set(n), order(n), REST))),
    ("prestretch-order", Verdict.CHOSEN, World(lambda n: np.where(own_set(n), REST, order(n)))),
    ("damping-never-chaotic", Verdict.REPRODUCED, NEVER),
    ("damping-never-chaotic", Verdict.NOT_REPRODUCED, ALWAYS),
    ("damping-never-chaotic", Verdict.CHOSEN, World(from_voltage(0.7))),
    ("damping-never-chaotic", Verdict.CHOSEN, World(lambda n: n["voltage"] == 0.5)),
    ("damping-never-chaotic", Verdict.TRANSIENT, World(ALWAYS.kind, finite=lambda n: n["voltage"] < -1.0)),
    ("limit-threshold", Verdict.REPRODUCED, LOW_J),
    ("limit-threshold", Verdict.NOT_REPRODUCED, NEVER),
    ("limit-threshold", Verdict.NOT_REPRODUCED, World(lambda n: n["stretch_limit"] < 15.0)),
    ("limit-threshold", Verdict.CHOSEN, World(lambda n: LOW_J._kind(n) & (n["voltage"] == 1.005))),
    ("limit-threshold", Verdict.CHOSEN, World(lambda n: LOW_J._kind(n) & (n["voltage"] != 1.005))),
    ("limit-threshold", Verdict.TRANSIENT, World(NEVER.kind, finite=LOW_J._kind)),
    ("map-high-voltage", Verdict.REPRODUCED, World(from_voltage(1.6))),
    ("map-high-voltage", Verdict.NOT_REPRODUCED, World(lambda n: n["voltage"] < 1.6)),
    ("map-high-voltage", Verdict.CHOSEN, World(only("radial", from_voltage(1.6)))),
    ("map-high-voltage", Verdict.CHOSEN, World(only("equibiaxial", from_voltage(1.6)))),
    ("map-high-voltage", Verdict.CHOSEN, World(lambda n: n["prestretch"] < 1.6)),
    ("map-low-prestretch", Verdict.REPRODUCED, World(lambda n: (n["prestretch"] < 0.9) & (n["voltage"] > 0.5))),
    ("map-low-prestretch", Verdict.NOT_REPRODUCED, World(from_voltage(1.2))),
    ("map-low-prestretch", Verdict.CHOSEN, World(only("radial", lambda n: n["prestretch"] < 0.9))),
    ("map-low-prestretch", Verdict.CHOSEN, World(only("equibiaxial", lambda n: n["prestretch"] < 0.9))),
    ("map-low-prestretch", Verdict.CHOSEN, ALWAYS),  # at large pre-stretch as well: not "already"
    ("map-safe-prestretch", Verdict.REPRODUCED, SAFE),
    ("map-safe-prestretch", Verdict.NOT_REPRODUCED, World(from_voltage(1.9))),
    ("map-safe-prestretch", Verdict.CHOSEN, World(lambda n: SAFE._kind(n) | only("equibiaxial", from_voltage(1.0))(n))),
    ("map-safe-prestretch", Verdict.CHOSEN, World(lambda n: SAFE._kind(n) | only("radial", from_voltage(1.0))(n))),
    ("map-safe-prestretch", Verdict.TRANSIENT, World(from_voltage(1.9), finite=SAFE._kind)),
    ("stable-pocket", Verdict.REPRODUCED, World(pocket)),
    ("stable-pocket", Verdict.NOT_REPRODUCED, World(from_voltage(0.5))),
    ("stable-pocket", Verdict.CHOSEN, World(lambda n: pocket(n) | (n["mode"] != "radial"))),
    ("stable-pocket", Verdict.CHOSEN, World(lambda n: pocket(n) | (n["mode"] == "radial"))),
    ("limit-large-same", Verdict.REPRODUCED, NEVER),
    ("limit-large-same", Verdict.CHOSEN, World(NEVER.kind, extent=grows_but_at(1.005))),
    ("limit-large-same", Verdict.NOT_REPRODUCED, World(ALWAYS.kind, extent=lambda n: n["stretch_limit"])),
]  # fmt: skip


def with_window(studies):
    """Time series over the window for the study of large limits: those of J = 100 and 1000 differ."""
    if "large-limits" in studies:
        time = np.linspace(0.0, 6.0, studies["large-limits"].sizes["time"])
        waves = np.array([2.0, 1.0, 1.0])[:, None] * np.sin(time)
        studies["large-limits"] = studies["large-limits"].assign(displacement=(("limit", "time"), waves))
    return studies


@RUNS
@pytest.mark.parametrize(("claim", "verdict", "world"), TABLE, ids=[f"{k}-{row[0]}" for k, row in enumerate(TABLE)])
def test_each_world_gives_its_verdict(claim, verdict, world, effort):
    studies = with_window(studies_in(world, claim, effort))
    assert judge(checked(claim, studies)) is verdict


CLAIMS_IN_WORLDS = sorted({claim for claim, *_ in TABLE})


@RUNS
@pytest.mark.parametrize("claim", CLAIMS_IN_WORLDS)
def test_a_world_in_which_every_run_ends_by_pull_in_has_no_motion_to_judge(claim, effort):
    world = World(lambda n: np.full(n["voltage"].shape, LEFT), extent=lambda n: np.nan)
    assert verdict_in(world, claim, effort) in (Verdict.NOT_REPRODUCED, Verdict.UNDECIDED)


def noise(seed, share):
    """Motions that are chaotic by chance, with exponents over the window and extents by chance: no order in any."""

    def chance(salt, n):
        drawn = ("voltage", "prestretch", "stretch_limit", "damping_ratio", "drive_frequency")
        mixed = sum(np.sin(1e5 * (k + salt) * n[name]) for k, name in enumerate(drawn, start=1))
        return np.mod(1e4 * mixed, 1.0)

    return World(
        lambda n: chance(seed, n) < share,
        finite=lambda n: chance(seed + 0.25, n) < share,
        extent=lambda n: 4.0 + 4.0 * chance(seed + 0.5, n),
    )


@pytest.mark.parametrize("share", [0.3, 0.7])
@pytest.mark.parametrize("claim", CLAIMS_IN_WORLDS)
def test_noise_does_not_pass(claim, share):
    # one number over the window meets a band by chance: that of the amplitude, a quarter of the extents
    passing = {Verdict.REPRODUCED, Verdict.ARTEFACT} | ({Verdict.TRANSIENT} - {CLAIMS_WITH_ONE_NUMBER.get(claim)})
    effort = replace(QUICK, samples=64)
    for seed in range(2):
        studies = with_window(studies_in(noise(seed, share), claim, effort))
        assert judge(checked(claim, studies)) not in passing


CLAIMS_WITH_ONE_NUMBER = {"voltage-amplitude": Verdict.TRANSIENT}

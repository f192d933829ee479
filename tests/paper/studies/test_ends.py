"""What ends the chaos: cases, and their motions in made-up worlds and in certified ones."""

import json
from pathlib import Path

import numpy as np
import pytest

from gelcone.paper.effort import FULL, QUICK
from gelcone.paper.figures.ends import rows_of
from gelcone.paper.studies.ends import COUNTED, VOLTAGES, Case, cases, ends
from gelcone.presets import find_preset
from tests.paper.made_up import CHAOTIC
from tests.paper.worlds import World, made_up

CERTIFIED = json.loads((Path(__file__).parents[2] / "reference" / "viscous.json").read_text())
CHAOS = [case for case in CERTIFIED["exponents"] if case["kind"] == "chaotic"]


def counted(world):
    """Chaotic and undecided voltages of each case of the study in a made-up world."""
    with made_up(world):
        return {case: (chaos.holding, chaos.open) for case, chaos, *_ in rows_of(ends(QUICK, lambda share: None))}


def test_every_run_has_the_cases_that_were_counted_before_and_two_decades_of_each_number():
    for effort in (QUICK, FULL):
        every = cases(effort)
        assert set(COUNTED) <= set(every)
        assert len(set(every)) == len(every)
        assert every[0] == Case()
        for values in (
            {case.resistance for case in every if case.resistance},
            {case.modulus for case in every if case.time == 50.0},
            {case.time for case in every if case.modulus == 0.5},
        ):
            assert max(values) / min(values) == pytest.approx(100.0)
    assert set(cases(QUICK)) < set(cases(FULL))


def test_the_numbers_of_a_case_reach_the_motions():
    """A world that is chaotic from a voltage on that grows with what is added."""

    def kind(n):
        added = sum(n.get(name, 0.0) for name in ("series_resistance", "viscous_modulus_1"))
        return n["voltage"] > 1.0 + added + 0.01 * n.get("relaxation_time_1", 0.0)

    found = counted(World(kind))
    for case, chaos in found.items():
        edge = 1.0 + case.resistance + case.modulus + 0.01 * case.time
        assert chaos == (int((edge < VOLTAGES).sum()), 0)
    assert len(set(found.values())) > 5


def test_a_branch_has_the_stretch_limit_of_the_film():
    def kind(n):
        return n.get("viscous_limit_1", n["stretch_limit"]) == n["stretch_limit"]

    found = counted(World(kind))
    assert set(found.values()) == {(VOLTAGES.size, 0)}


def test_voltages_that_are_not_decided_count_to_the_uncertainty():
    def kind(n):
        transient = np.where(n["voltage"] > 1.72, 4, 1)
        return np.where(n["voltage"] < 1.28, int(CHAOTIC), transient if "series_resistance" in n else 1)

    found = counted(World(kind))
    assert found.pop(Case()) == (6, 0)
    for case, chaos in found.items():
        assert chaos == (6, 6 if case.resistance else 0)


@pytest.mark.slow
@pytest.mark.parametrize("case", CHAOS, ids=[case["name"] for case in CHAOS])
def test_certified_chaos_has_its_exponent(case):
    """One motion with a branch and one behind a resistance, of the fast set, by the study's own classification."""
    from gelcone.paper.sampling import observed

    circuit, wave = case["circuit"], case["wave"]
    added = {"series_resistance": circuit["rho"]} if "rho" in circuit else {}
    for branch in case["branches"]:
        added |= {"viscous_modulus_1": branch["g"], "relaxation_time_1": branch["tau"], "viscous_limit_1": branch["J"]}
    preset = find_preset("fast")
    model = preset.model.replace(voltage=np.array([wave["v"]]), **added)
    assert float(model.drive_frequency) == wave["omega"]
    found = observed(model, preset.initial, QUICK)
    largest, error = float(found["lyapunov"][0, 0]), float(found["standard_error"][0, 0])
    assert int(found["regime"][0]) == int(CHAOTIC)
    assert abs(largest - case["exponents"][0]) < 3.0 * np.hypot(error, case["standard_error"][0])


def test_a_study_names_the_numbers_of_its_cases_and_says_how_far_it_is():
    shares = []
    with made_up(World(lambda n: n["voltage"] > 1.5)):
        found = ends(QUICK, shares.append)
    every = cases(QUICK)
    assert (sum(shares), len(shares)) == (pytest.approx(1.0), len(every))
    assert found["series_resistance"].values.tolist() == [case.resistance for case in every]
    assert found["viscous_modulus_1"].values.tolist() == [case.modulus for case in every]
    assert found["relaxation_time_1"].values.tolist() == [case.time for case in every]
    np.testing.assert_array_equal(found["counted"], [COUNTED.get(case, np.nan) for case in every])
    meanings = {
        "series_resistance": "series resistance", "viscous_modulus_1": "modulus of the branch",
        "relaxation_time_1": "relaxation time", "counted": "positive exponents, counted before",
    }  # fmt: skip
    for name, words in meanings.items():
        assert found[name].attrs["long_name"].startswith(words)
    np.testing.assert_allclose(found["voltage"], np.linspace(1.0, 2.0, 21))
    assert found["lyapunov"].sizes["exponent"] == 1
    assert (found.attrs["preset"], found.attrs["window"]) == ("base", QUICK.window)

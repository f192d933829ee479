"""The search for chaos in a whole device: what is drawn, what counts as found, and that it goes on where it stopped."""

import numpy as np
import pytest
import whole_chaos
import xarray as xr
from whole_chaos import RANGES, around, best, drawn, is_chaotic, is_whole, main

from gelcone.codes import Outcome, Regime


@pytest.mark.parametrize("family", whole_chaos.FAMILIES)
def test_draws_lie_within_the_ranges_also_around_others(family):
    draws = drawn(family, 50)
    for values in (draws, around(draws, np.arange(4), 50)):
        for name, (low, high) in RANGES.items():
            assert name not in values or ((values[name] >= low - 1e-12) & (values[name] <= high + 1e-12)).all()
    assert ("beam_stiffness" in draws) == (family == "beam")


def findings(**changes):
    """Four draws: chaotic and whole twice, chaotic beyond the dielectric strength, and periodic."""
    columns = {
        "regime": [Regime.CHAOTIC, Regime.CHAOTIC, Regime.CHAOTIC, Regime.PERIODIC],
        "validity_breakdown": [0.0, 0.0, 0.1, 0.0],
        "validity_near_limit": [0.0] * 4,
        "validity_pulled_in": [0.0] * 4,
        "outcome": [Outcome.OK] * 4,
        "doubtful": [0] * 4,
        "share_chaotic": [1.0, 1.0, 1.0, np.nan],
    } | changes
    found = xr.Dataset({name: ("draw", np.array(values)) for name, values in columns.items()})
    return found.assign(
        lyapunov=(("draw", "exponent"), np.array([[0.1, -0.2], [0.2, -0.3], [0.4, -0.5], [-0.1, -0.1]]))
    )


def test_found_is_what_is_whole_and_lasts():
    found = findings()
    assert is_whole(found).tolist() == [True, True, False, True]
    assert is_chaotic(found).tolist() == [True, True, True, False]
    assert best(found, 8).tolist() == [1, 0]
    assert not is_chaotic(findings(share_chaotic=[0.9] * 4)).any()
    assert not is_whole(findings(outcome=[Outcome.PULLED_IN] * 4)).any()
    # where none is chaotic and whole, it looks on around what is whole and attracts the least
    assert best(findings(regime=[Regime.PERIODIC] * 4), 1).tolist() == [1]


def test_a_search_goes_on_and_ends_alike(tmp_path, monkeypatch, capsys):
    monkeypatch.setattr(whole_chaos, "FAMILIES", {"beam": whole_chaos.FAMILIES["beam"]})
    main(4, tmp_path)
    first, table = capsys.readouterr().out, (tmp_path / "whole-chaos.csv").read_text()
    assert "beam, random: 4 draws" in first
    monkeypatch.setattr("gelcone.atlas.sweep.compute", None)  # what lies there is not computed again
    main(4, tmp_path)
    assert (capsys.readouterr().out, (tmp_path / "whole-chaos.csv").read_text()) == (first, table)

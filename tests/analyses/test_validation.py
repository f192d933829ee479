"""The lines of `validate` about pull-in: continuum, cone and membrane each with its own voltage."""

import numpy as np

from gelcone.analyses.validation import _limit_lines, _pull_in_lines
from tests.plots.made_up import result


def test_each_film_pulls_in_at_its_own_voltage():
    member = result(
        {
            "pull_in_voltage": ("displacement", [np.nan, 900.0]),
            "cone_pull_in_voltage": ("displacement", [1200.0, 1100.0]),
            "membrane_pull_in_voltage": ("displacement", [950.0, 910.0]),
            "limit_displacement": ("share", [np.nan, 30.0]),
            "cone_limit_displacement": ("share", [20.0, 40.0]),
        },
        {"displacement": ("displacement", [5.0, 10.0]), "share": ("share", [0.1, 0.5])},
        {"pull_in_voltage": "V", "displacement": "mm", "limit_displacement": "mm"},
    )
    assert _pull_in_lines(member) == [
        "the continuum has pulled in above:",
        "  at 10 mm: 900 V, the cone above 1100 V, the membrane above 910 V",
    ]
    assert _limit_lines(member)[1:] == ["  50% of the stretch limit at 30 mm, the cone at 40 mm"]

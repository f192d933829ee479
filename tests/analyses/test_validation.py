"""The lines of `validate` about pull-in: continuum, cone and membrane each with its own voltage."""

import numpy as np

import gelcone
from gelcone.analyses import (
    validation,
)  # fmt: skip
from gelcone.analyses.validation import _limit_lines, _pull_in_lines
from tests.analyses.said import NAN
from tests.edited import edited, made
from tests.plots.made_up import result


def test_each_film_pulls_in_at_its_own_voltage():
    member = result(
        {
            "pull_in_film_voltage": ("displacement", [np.nan, 900.0]),
            "cone_pull_in_film_voltage": ("displacement", [1200.0, 1100.0]),
            "membrane_pull_in_film_voltage": ("displacement", [950.0, 910.0]),
            "limit_displacement": ("share", [np.nan, 30.0]),
            "cone_limit_displacement": ("share", [20.0, 40.0]),
        },
        {"displacement": ("displacement", [5.0, 10.0]), "share": ("share", [0.1, 0.5])},
        {"pull_in_film_voltage": "V", "displacement": "mm", "limit_displacement": "mm"},
    )
    assert _pull_in_lines(member) == [
        "the continuum has pulled in above:",
        "  at 10 mm: 900 V, the cone above 1100 V, the membrane above 910 V",
    ]
    assert _limit_lines(member)[1:] == ["  50% of the stretch limit at 30 mm, the cone at 40 mm"]


def validated(**changes):
    along = ("constant_voltage", "displacement")
    own = {
        "outcome": 0, "radius_ratio": 0.25, "deviation": (along, [[0.125, -0.25, 0.0625]]),
        "membrane_deviation": (along, [[NAN, 0.0125, -0.025]]), "hoop_slack": (along, [[False, True, False]]),
        "ending": (along, [[0, 0, 4]]), "mesh_force": ("mesh_elements", [1.0, 1.0]), "mesh_displacement": (None, 6.0,
        "mm"),
        "mesh_force_error": ("mesh_elements", [1e-3, 2.5e-4]), "mesh_force_order": ("mesh_elements", [NAN, 2.0]),
        "mesh_shape_error": ("mesh_elements", [3e-3, 1.5e-3]), "mesh_shape_order": ("mesh_elements", [NAN, 1.0]),
        "share": ("share", []), "limit_displacement": ("share", []), "cone_limit_displacement": ("share", []),
    }  # fmt: skip
    coords = {"constant_voltage": ("constant_voltage", [700.0], "V"), "displacement": ("displacement", [4.0, 6.0, 8.0],
    "mm"),
              "mesh_elements": ("mesh_elements", [10, 20])}  # fmt: skip
    return edited(made(own, coords), **changes)


def test_a_cone_against_a_continuum():
    from gelcone.continuum.path import Ending

    taut = validation._voltage_lines(validated())
    assert taut == [
        "radius of the disc over that of the film, a/b: 0.25",
        "relative difference of the cone's force from finite elements where these are taut:",
        "  700 V: +6.2% at 8 mm to +12.5% at 4 mm",
        f"    1 of 3: {validation.HOOP_SLACK}",
        f"    1 of 3: {Ending.PULLED_IN.meaning}",
    ]
    lost = edited(validated(), hoop_slack=[[False, True, True]])  # what was not found is not wrinkled, too
    assert validation._voltage_lines(lost)[3] == taut[3]
    wrinkles = validated().assign(pull_in_film_voltage=1.0)
    assert validation._voltage_lines(wrinkles)[1:3] == [
        "relative difference of the cone's force from finite elements, both wrinkling:",
        "  700 V: -25.0% at 6 mm to +12.5% at 4 mm; the membrane -2.50% at 8 mm to +1.25% at 6 mm",
    ]
    assert validation._voltage_lines(edited(validated(), deviation=NAN))[2] == "  700 V: the film is taut nowhere"
    assert validation._voltage_lines(edited(wrinkles, deviation=NAN))[2] == "  700 V: no film in tension"
    assert validation._mesh_lines(validated()) == [
        "mesh at 6 mm: elements, error of the force (order), of the shape (order)", "    10  1.00e-03  3.00e-03",
        "    20  2.50e-04 (2.00)  1.50e-03 (1.00)",
    ]  # fmt: skip
    assert validation._mesh_lines(edited(validated(), mesh_force=NAN)) == []
    assert validation._pull_in_lines(validated()) == []
    assert validation._limit_lines(validated()) == []


def test_two_devices_are_each_named_and_have_their_own_voltages():
    """One voltage of the model is another in volts for each, so that it is no axis of the result."""
    device = gelcone.find_device("biased-pump").replace(film_thickness=[1.8e-4, 2e-4])
    found = gelcone.validate(device, displacements=["5 mm"])
    lines = found.gelcone.words().splitlines()
    assert [line for line in lines if line.startswith("film_thickness")] == [
        "film_thickness 0.18 mm:",
        "film_thickness 0.2 mm:",
    ]
    assert sum(line.startswith("  0 V: ") for line in lines) == 2
    titles = [axes.get_title(loc="left") for axes in found.gelcone.plot().axes[::3]]
    assert titles == ["film_thickness 0.18 mm", "film_thickness 0.2 mm"]

"""The text of designs: limits and what binds under their own names, and the side of the resonance."""

import json

from gelcone.analyses import (
    design,
)  # fmt: skip
from gelcone.analyses.design import design_words, device_text
from tests.analyses.said import NAN
from tests.edited import edited, made
from tests.plots.made_up import result

MEASURED = {
    "stroke": ("mm", "length"), "apparent_power": ("mVA", "apparent power"),
}  # fmt: skip
"""Units and quantities of numbers that are read in the unit that suits them."""


def test_a_design_names_its_limit_and_what_binds_it():
    designs = result(
        {
            "stroke": ("design", [5.1]), "peak_voltage": ("design", [1500.0]),
            "apparent_power": ("design", [3.2]), "recommended": ("design", [1600.0]), "probability": ("design", [0.96]),
            "probability_low": ("design", [0.95]), "probability_high": ("design", [0.97]),
            "distance": ("design", [-2.5]),
            "relaxed": ("design", [0.12]), "spring_rate": ("design", [15.0]),
            "first_limit": ("design", ["pull-in on a ramp"]), "binding_requirement": ("design", ["stroke"]),
        },
        {"design": ("design", [1])},
        {"spring_rate": "N/m"} | {name: unit for name, (unit, _) in MEASURED.items()},
        {
            "title": "designs: pump", "frequency": 10.0, "margin": 0.2, "free": json.dumps(["spring_rate"]),
            "left_out": "[]", "nominal_probability": 0.4, "nominal_probabilities": '{"current": 0.4}',
            "devices": json.dumps(["a device"]), "film": "membrane",
        },
    )  # fmt: skip
    for name, (_, quantity) in MEASURED.items():
        designs[name].attrs["quantity"] = quantity
    text = design_words(designs)
    assert "96.0% (95.0% to 97.0%)" in text
    assert "pull-in on a ramp, 1600 V recommended" in text
    assert "design 1: spring_rate 15 N/m" in text
    assert "natural frequency 2.5 half widths below that of the drive; bound by stroke" in text
    assert "weakening that by 10 % improves the first objective by 12%" in text
    assert text.endswith(
        "the best designs meet all in 40.0% (38.5% to 41.5%) (best current) of the devices within them"
    )
    said = device_text(designs, 0).splitlines()
    assert said[0] == "# design 1 of pump, found by gelcone design"
    assert said[1] == "# settled stroke 5.1 mm at 10 Hz with the film membrane, 3.2 mVA"
    assert device_text(edited(designs, apparent_power=3200.0), 0).splitlines()[1].endswith(", 3.2 VA")
    assert said[3:5] == [
        "# first limit: pull-in on a ramp; recommended up to 1600 V, 20% below it",
        "# bound by stroke",
    ]
    assert said[-1] == "a device"
    assert said[2] == "# 96.0% of the devices within the tolerances meet all (95.0% to 97.0%)"
    drawn = designs.assign_attrs(samples='{"names": ["film_thickness"]}')
    assert "96.0% of the draws meet all" in device_text(drawn, 0).splitlines()[2]
    words = "where nothing is uncertain the best designs meet all in 40.0% (38.5% to 41.5%) (best current) of the draws"
    assert design_words(drawn).endswith(words)


def test_designs_in_the_plural_and_what_was_left_out():
    own = {"stroke": 5.0, "peak_voltage": 1500.0, "apparent_power": 3.0, "recommended": 1600.0,
           "probability": 0.96, "probability_low": 0.95, "probability_high": 0.97, "distance": 2.5, "relaxed": 0.0,
           "spring_rate": 15.0}  # fmt: skip
    units = {"spring_rate": "N/m"} | {name: unit for name, (unit, _) in MEASURED.items()}
    found = made({n: ("design", [v, v], units.get(n, "1")) for n, v in own.items()}
                 | {"first_limit": ("design", ["pull-in"] * 2), "binding_requirement": ("design", ["stroke"] * 2)},
                 {"design": ("design", [1, 2])}, title="designs: pump", frequency=10.0, margin=0.2,
                 free='["spring_rate"]', film="membrane",
                 left_out='["design 3: no rest"]', nominal_probabilities="{}")  # fmt: skip
    lines = design.design_words(edited(found, stroke=[5.0, NAN])).splitlines()
    assert lines[0] == "pump: 2 designs at 10 Hz, 20% below all limits"
    heads = ["design", "stroke", "peak", "apparent", "probability", "first limit"]
    row = "1 5 mm 1500 V 3 mVA 96.0% (95.0% to 97.0%) pull-in, 1600 V recommended"
    assert [lines[1].split(), lines[2].split(), lines[3].split()] == [
        " ".join(heads).split(), row.split(), row.replace("1 5 mm", "2 unknown").split(),
    ]  # fmt: skip
    assert lines[4] == (
        "all numbers are of the film membrane; the probability is that of draws of the homogeneous cone, times what "
        "the film has over the cone at nominal values"
    )
    assert lines[5:] == [
        "design 1: spring_rate 15 N/m", "  natural frequency 2.5 half widths above that of the drive; bound by stroke",
        "design 2: spring_rate 15 N/m", "  natural frequency 2.5 half widths above that of the drive; bound by stroke",
        "left out: design 3: no rest",
    ]  # fmt: skip
    assert design.design_words(found.isel(design=[0])).startswith("pump: 1 design at 10 Hz")
    alone = found.drop_vars(["probability", "probability_low", "probability_high"])
    assert "probability" not in design.design_words(alone)
    assert design.design_words(alone).splitlines()[2] == "1       5 mm       1500 V      3 mVA          " + (
        "pull-in, 1600 V recommended"
    )

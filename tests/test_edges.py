"""Every registered analysis at the edges of what it takes: without a drive, at 0 V, and at one point. It refuses in the
words of the input, or its result is printed, and drawn."""

import pytest

from gelcone.register.analyses import ANALYSES

DEVICE = ["biased-pump", "--film", "taut", "--set", "damping_coefficient=0.2 N s/m"]
UNDRIVEN = ["--set", "voltage_amplitude=0 V", "--set", "voltage_offset=0 V"]
IN_TIME = ["--transient", "1 s", "--budget", "1 s"]
FEW = ["--repeats", "3", "--discard", "20"]
SMALL = {
    "section": FEW,
    "extrema": FEW,
    "lyapunov": [*IN_TIME, "--window", "0.2 s"],
    "regime": IN_TIME,
    "triptych": [*IN_TIME, "--periods", "3", "--late-periods", "2"],
    "bifurcation": ["--bisections", "0", *IN_TIME],
    "continue_branch": ["--checks", "2", "--points", "40"],
    "locus": ["--checks", "2", "--points", "40"],
    "map": IN_TIME,
    "basin": IN_TIME,
    "sweep": ["--analysis", "settled"],
    "validate": ["--elements", "8"],
}
"""What keeps the work small."""
GEL = {
    "creep": ["--set", "material.viscous_modulus_1=20 kPa", "--set", "material.relaxation_time_1=1 s"],
    "film": ["--film", "membrane"],
    "tongues": ["--set", "initial_height=0 mm"],
}
TWO = "frequency=9 Hz,9.2 Hz"
"""Two points, of what takes no fewer."""
NEEDED = {
    "film": ["displacement=8 mm", "constant_voltage=0 V"],
    "tongues": [TWO, "voltage_amplitude=0 V,100 V"],
    "bifurcation": [TWO],
    "map": [TWO, "spring_rate=14 N/m,15 N/m"],
    "sweep": [TWO],
    "basin": ["displacement=5 mm,6 mm", "velocity=0 m/s,0.1 m/s"],
    "frequency": [TWO],
    "envelope": [TWO, "peak_voltage=100 V,200 V"],
    "locus": ["frequency=9 Hz:9.2 Hz", "voltage_amplitude=0 V:120 V"],
}
POINT = {
    "step": ["constant_voltage={}"],
    "creep": ["constant_voltage={}"],
    "transfer": ["frequency=9 Hz", "amplitude={}"],
    "static": ["constant_voltage={}", "displacement=8 mm"],
    "film": ["constant_voltage={}", "displacement=8 mm"],
    "validate": ["constant_voltage={}", "displacement=8 mm"],
    "datasheet": ["constant_voltage={}"],
    "tongues": ["frequency=9 Hz", "voltage_amplitude={}"],
    "bifurcation": ["voltage_amplitude={}"],
    "map": ["voltage_amplitude={}", "frequency=9 Hz"],
    "sweep": ["voltage_amplitude={}"],
    "basin": ["displacement=5 mm", "velocity=0 m/s"],
    "frequency": ["frequency=9 Hz"],
    "envelope": ["peak_voltage={}", "frequency=9 Hz"],
}
"""One point of an analysis over axes; {} is its voltage."""
POSITIONS = {"continue_branch": ["frequency", "9 Hz", "9.2 Hz"], "locus": ["fold"]}
EDGES = {"no drive": UNDRIVEN, "0 V": [], "one point": []}
ONE, UNSCALED = (
    "has one point; ",
    "voltage_amplitude = 0 V: here the device's drive is scaled; give it an amplitude or a bias",
)
NO_VOLTAGE = ": a data sheet takes one above 0; give --over constant_voltage=..., or a drive"
REFUSED = {
    (
        "locus",
        "no drive",
    ): "event = fold: none lies on frequency from 9 Hz to 9.2 Hz at voltage_amplitude = 0 V; take a wider",
    ("transfer", "no drive"): "bias = 0 V: give a bias (--bias), or voltage_offset, since about no voltage a",
    ("datasheet", "no drive"): NO_VOLTAGE,
    ("datasheet", "0 V"): NO_VOLTAGE,
    **{(name, "no drive"): UNSCALED for name in ("operating_limits", "drive", "envelope")},
    **{
        (name, edge): ONE
        for name in ("tongues", "bifurcation", "map", "sweep", "basin", "frequency", "envelope")
        for edge in ("0 V", "one point")
    },
}
"""What an analysis and an edge are refused with."""
CASES = [
    (name, edge) for name in ANALYSES for edge in EDGES if name != "show" and (edge == "no drive" or name in POINT)
]
"""A store is shown by the tests of stores."""


@pytest.mark.parametrize(("name", "edge"), CASES)
def test_an_analysis_at_an_edge_refuses_in_words_or_is_printed_and_drawn(name, edge, command_line, undrawn, tmp_path):
    axes = NEEDED.get(name, []) if edge == "no drive" else POINT.get(name, NEEDED.get(name, []))
    typed = [text.format("0 V" if edge == "0 V" else "300 V") for axis in axes for text in ("--over", axis)]
    arguments = [*DEVICE, *POSITIONS.get(name, []), *GEL.get(name, []), *EDGES[edge], *typed, *SMALL.get(name, [])]
    code, out, err = command_line(ANALYSES[name].command, *arguments, "--out", "results")
    if (name, edge) in REFUSED:
        assert (code, out) == (2, "")
        assert REFUSED[name, edge] in err
        return
    assert code == 0, err
    (figure,) = (tmp_path / "results").glob("*.png")
    assert int(figure.read_text().split()[0]) > 0

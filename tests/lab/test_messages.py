"""Messages of files that cannot be used, whole: what is wrong with which value of which file, and what helps."""

import re

import pytest

from gelcone.errors import InputError
from gelcone.lab.device_tests import read_device_tests
from gelcone.lab.measured import read_tests
from gelcone.lab.page import compare_measured
from gelcone.lab.predictions import read_predictions
from gelcone.lab.wish import FIRST_WISH, read_wish
from tests.lab.test_page import PUMP

PAGE = 'title = "Cone"\nsource = "made up"\n'
COUPON = "\n".join(["stretch,stress (kPa)", *(f"{1.0 + 0.25 * k},{10.0 * k}" for k in range(8))])
LISTED = '[[test]]\nfile = "a.csv"\n'
STROKE = '[[test]]\nkind = "stroke over voltage"\nfile = "a.csv"\nnoise = "10 um"\n'
SPECTRUM = "frequency (Hz),permittivity\n1,{}\n10,4\n"
WISH = FIRST_WISH.replace("{file}", "wish.toml")


def in_wish(old, new):
    assert WISH.count(old) >= 1
    return WISH.replace(old, new, 1)


def number(**keys):
    said = ", ".join(f"{key} = {value}" for key, value in ({"kind": '"stated"', "sentence": '"s"'} | keys).items())
    return f"{PAGE}[device]\ndisc_radius = {{{said}}}"


PAGES = {
    "no title": PAGE.replace('"Cone"', '""'),
    "missing": f'{PAGE}missing = "all"',
    "nothing": PAGE,
    "not tables": PUMP.replace("[device]", "measured = 3\n[device]"),
    "no device": f"{PAGE}device = 3",
    "unknown field": f"{PAGE}[device]\nradius = 3",
    "no table": f"{PAGE}[device]\ndisc_radius = 3",
    "no sentence": number(value=3, sentence='" "'),
    "another kind": number(value=3, kind='"said"'),
    "assumed": number(value=3, kind='"assumed"'),
    "no number": number(value="true"),
    "another unit": number(value=3, unit='"kV"'),
    "another film": f'{PAGE}[device]\nfilm = {{value = "thick", kind = "stated", sentence = "s"}}',
    "no quantity": f"{PUMP}[[measured]]\nvalue = 3\n",
    "no coupons": f"{PAGE}coupons = 3",
    "branches": f'{PAGE}[coupons]\ntests = "a.csv"\nbranches = true',
    "no tests": f'{PAGE}[coupons]\nlaw = "gent"',
}
WISHES = {
    "two sizes": in_wish("[free]", 'film_radius = "30 mm"\n[free]'),
    "given and free": in_wish("[free]", 'disc_radius = "5 mm"\n[free]'),
    "one bound": in_wish('"1:2"', '"1.5"'),
    "falling bounds": in_wish('"1:2"', '"1.5:1.2"'),
    "no number": in_wish("[free]", '[free]\nwaveform = "1:2"'),
    "not set": in_wish("[tolerances]", '[tolerances]\nbeam_rate = "5 %"'),
    "no names": in_wish("[free]", "largest = 3\n[free]"),
    "many objectives": in_wish("[free]", 'largest = ["stroke", "blocked_force", "probability"]\n[free]'),
    "objective twice": in_wish("[free]", 'largest = ["stroke", "stroke"]\n[free]').replace("smallest", "# smallest"),
    "no share": in_wish("margin = 0.2", "margin = 0.95"),
    "nothing free": in_wish("[free]", "[other]"),
    "another film": in_wish("[free]", 'film = "creeping"\n[free]'),
    "another wave": in_wish("[free]", 'waveform = "square"\n[free]'),
    "a beam": in_wish("[free]", 'beam_rate = "1 N/m"\n[free]').replace("\nspring_rate", "\n# spring_rate"),
}
COUPONS = {
    "a file twice": (LISTED + LISTED, COUPON),
    "no file": ('[[test]]\nmode = "uniaxial"', COUPON),
    "elsewhere": (LISTED.replace("a.csv", "../a.csv"), COUPON),
    "a number": (LISTED + "stress = 3.5", COUPON),
    "no column": (LISTED + 'stress = ""', COUPON),
    "another setting": (LISTED + "stres = 3", COUPON),
    "no ids": (LISTED + "only = 3", COUPON),
    "no unit": (LISTED + "temperature = 20", COUPON),
    "another unit": (LISTED + 'thickness = "1 kV"', COUPON),
    "another mode": (LISTED + 'mode = "sideways"', COUPON),
    "another kind": (LISTED + 'kind = "slow"', COUPON),
    "alike": (LISTED, COUPON.replace("(kPa)", "(kPa),nominal stress (MPa)").replace(".0\n", ".0,1\n") + ",1"),
    "Fahrenheit": (LISTED, "frequency (Hz),permittivity,temperature (F)\n1,3,70\n10,4,70\n"),
    "below 1": (LISTED, "frequency (Hz),permittivity\n1,0.5\n10,4\n"),
    "with a unit": (LISTED, "frequency (Hz),permittivity (F/m)\n1,3\n10,4\n"),
    "strain": (LISTED, COUPON.replace("stretch", "strain (mm)")),
    "stretch": (LISTED, COUPON.replace("stretch", "stretch (%)")),
    "few": (LISTED, "\n".join(COUPON.split("\n")[:3])),
    "no rate": (LISTED + 'rate = "0 1/s"', COUPON),
    "a clock that stops": (
        LISTED,
        "time (s),stretch,stress (kPa)\n" + "\n".join(f"{k % 5},1.{k},{k}" for k in range(8)),
    ),
    "no time": (LISTED + 'kind = "creep"', COUPON),
    "another list": ('title = "x"\n' + LISTED, COUPON),
}
RINGING = STROKE.replace("stroke over voltage", "ring-down").replace('"10 um"', '{frequency = "1 Hz", decay = "1 1/s"}')
DEVICES = {
    "kilovolts": (STROKE, "voltage,stroke (um)\n1,1\n2,2\n"),
    "no unit": (STROKE, "voltage (V),stroke\n1000,1\n2000,2\n"),
    "another unit": (STROKE, "voltage (mm),stroke (um)\n1000,1\n2000,2\n"),
    "decay": (RINGING, "frequency (Hz),decay (Hz)\n9,1\n9,1\n"),
    "no number": (STROKE + "voltage = true\n", "stroke (um)\n1\n2\n"),
    "no file": (STROKE.replace('file = "a.csv"\n', "") + 'voltage = "U"\nstroke = "1 mm"\n', ""),
    "lengths": (STROKE + 'voltage = ["1 kV", "2 kV", "3 kV"]\n', "stroke (um)\n1\n2\n"),
    "no voltage": (STROKE, "stroke (um)\n1\n2\n"),
    "another kind": (STROKE.replace("stroke over", "stroke on"), "stroke (um)\n1\n2\n"),
    "no noise": (STROKE.replace('"10 um"', '"0 um"'), "voltage (V),stroke (um)\n1000,1\n2000,2\n"),
}
ASKED = ("stroke", "pull-in@1 kV", "strok@1 kV", "stroke@1 mm", "stroke@0 V")

CASES = {
    **{f"page: {case}": (compare_measured, {"page.toml": text}) for case, text in PAGES.items()},
    **{f"wish: {case}": (read_wish, {"wish.toml": text}) for case, text in WISHES.items()},
    **{f"coupon: {case}": (read_tests, {"tests.toml": text, "a.csv": own}) for case, (text, own) in COUPONS.items()},
    **{f"device: {case}": (read_device_tests, {"tests.toml": text, "a.csv": own})
       for case, (text, own) in DEVICES.items()},
}  # fmt: skip
WHOLE = """
page: no title ->
    page.toml: title or source is missing; give a TOML file as docs/measured holds them
page: missing ->
    page.toml: missing must be a list of texts
page: nothing ->
    page.toml: has no [device] and no [coupons], and does not say what is missing; give a TOML file as
    docs/measured holds them
page: not tables ->
    page.toml: measured must be tables [[measured]], at most 200
page: no device ->
    page.toml: [device] must be a table of at most 200 fields
page: unknown field ->
    page.toml: [device] 'radius' is not a device field; did you mean 'film_radius'?
page: no table ->
    page.toml: device.disc_radius: must be a table {value = ..., unit = ..., sentence = ..., kind = ...}
page: no sentence ->
    page.toml: device.disc_radius: the sentence that states it is missing
page: another kind ->
    page.toml: device.disc_radius: 'said' is not a kind of number; did you mean 'stated'?
page: assumed ->
    page.toml: device.disc_radius: is assumed; say how far off it may be, deviation = "20 %"
page: no number ->
    page.toml: device.disc_radius: value = 'True': must be a number, with its unit in unit
page: another unit ->
    page.toml: device.disc_radius: value = '3 kV': kV is a unit of voltage, not of length; give a number in m
    or a string such as '50 mm' (units m, cm, mm, um, nm)
page: another film ->
    page.toml: device.film: 'thick' is not a film; known: taut, wrinkling, membrane
page: no quantity ->
    page.toml: measured 1: quantity is missing; give one of stroke, blocked force, natural frequency, pull-in,
    such as "stroke@1 kV"
page: no coupons ->
    page.toml: [coupons] must be a table; give a TOML file as docs/measured holds them
page: branches ->
    page.toml: coupons.branches = 'True': must be a whole number
page: no tests ->
    page.toml: coupons: file is missing; give a list of tests: a table [[test]] for each file, with file =
    "tension.csv"
wish: two sizes ->
    wish.toml: footprint and film_radius are both given; give one: a footprint is twice the radius
wish: given and free ->
    wish.toml: disc_radius: is given and free; give it once
wish: one bound ->
    wish.toml: [free] hoop_prestretch = '1.5': must be two bounds, such as "4 mm:15 mm"
wish: falling bounds ->
    wish.toml: [free] hoop_prestretch = '1.5:1.2': the first bound must be the smaller one
wish: no number ->
    wish.toml: [free] waveform: is not a number, and cannot be free
wish: not set ->
    wish.toml: [tolerances] beam_rate: is not set; give it a value, or make it free
wish: no names ->
    wish.toml: largest = '3': must be a list of names, such as ["stroke"]
wish: many objectives ->
    wish.toml: 5 objectives: give at most 3
wish: objective twice ->
    wish.toml: stroke: is an objective twice; give it once
wish: no share ->
    wish.toml: margin = 0.95: must be a share from 0 to 0.9, such as 0.2
wish: nothing free ->
    wish.toml: [free]: is missing; give fields and their bounds, disc_radius = "4 mm:15 mm"
wish: another film ->
    wish.toml: 'creeping' is not a film of a design; known: taut, wrinkling, membrane
wish: another wave ->
    wish.toml: design: takes a sine; leave waveform out
wish: a beam ->
    wish.toml: spring_rate: is missing; give the stiffness of the spring in N/m
coupon: a file twice ->
    a.csv: is listed twice; list it once, with only = [...] for some of its tests
coupon: no file ->
    tests.toml, test 1: file is missing; give a list of tests: a table [[test]] for each file, with file =
    "tension.csv"
coupon: elsewhere ->
    tests.toml, test 1: file = '../a.csv': must lie in the folder of the list; put it there
coupon: a number ->
    tests.toml, test 1: stress = 3.5: must name a column, stress = "COLUMN, UNIT"
coupon: no column ->
    tests.toml, test 1: stress = '': must name a column, stress = "COLUMN, UNIT"
coupon: another setting ->
    tests.toml, test 1: 'stres' is not a setting of a test; did you mean 'stress'?
coupon: no ids ->
    tests.toml, test 1: only = 3: must be a list of ids, such as [101, 102]
coupon: no unit ->
    tests.toml, test 1: temperature = 20: has no unit; write '20 degC' or '293 K'
coupon: another unit ->
    tests.toml, test 1: thickness = '1 kV': kV is a unit of voltage, not of length; give a number in m or a
    string such as '50 mm' (units m, cm, mm, um, nm)
coupon: another mode ->
    tests.toml, test 1: 'sideways' is not a mode; known: uniaxial, equi-biaxial, pure shear
coupon: another kind ->
    tests.toml, test 1: 'slow' is not a kind; known: quasi-static, loading, cyclic, relaxation, creep
coupon: alike ->
    a.csv: columns 'stress' and 'nominal stress' both look like stress; name one in tests.toml: stress =
    "nominal stress"
coupon: Fahrenheit ->
    a.csv: column 'temperature': 'F' is not K or degC; write one of them
coupon: below 1 ->
    a.csv: a relative permittivity of 0.5 is below 1; give it over that of vacuum
coupon: with a unit ->
    a.csv: column 'permittivity': permittivity has no unit; 'F/m' is one
coupon: strain ->
    a.csv: column 'strain': 'mm' is not a unit of a strain; write it in %
coupon: stretch ->
    a.csv: column 'stretch': stretch has no unit; '%' is one
coupon: few ->
    a.csv, line 2: test 'a' has 2 rows; give at least 4
coupon: no rate ->
    tests.toml, test 1: rate = '0': must be greater than 0; give a larger one, such as 1.2
coupon: a clock that stops ->
    a.csv, line 7: the time does not increase; one test a file, or give ids
coupon: no time ->
    a.csv: has neither time nor rate; add rate = "0.1 1/s" in tests.toml
coupon: another list ->
    tests.toml: 'title' is not known; give a list of tests: a table [[test]] for each file, with file =
    "tension.csv"
device: kilovolts ->
    a.csv: 2 of 2 voltages are below 20 V: kilovolts? write the unit
device: no unit ->
    a.csv, line 1: column "stroke" has no unit; write "stroke (m)", or name it in tests.toml: stroke =
    "stroke, mm"
device: another unit ->
    a.csv, line 1: column 'voltage': 'mm' is not a unit of voltage; write one of V, kV, mV, MV
device: decay ->
    a.csv, line 1: column 'decay': 'Hz' is not a unit of decay; write it in 1/s
device: no number ->
    tests.toml, test 1: voltage = True: must be a number or a string, not bool; give a number in V or a string
    such as '1.2 kV' (units V, kV, mV, MV)
device: no file ->
    tests.toml, test 1: voltage = 'U': names a column, but no file is given
device: lengths ->
    tests.toml, test 1: stroke has 2 values and others 3; give one for each row
device: no voltage ->
    tests.toml, test 1: a stroke over voltage test needs voltage; name a column, or give voltage = "1 kV"
device: another kind ->
    tests.toml, test 1: 'stroke on voltage' is not a kind of test on a device; did you mean 'stroke over
    voltage'?
device: no noise ->
    tests.toml, test 1: noise of stroke = '0 um': must be greater than 0 m; give a larger one, such as 50 mm
asked: stroke ->
    predict 'stroke': give a voltage, stroke@1 kV
asked: pull-in@1 kV ->
    predict 'pull-in@1 kV': takes no voltage
asked: strok@1 kV ->
    'strok' is not a prediction; did you mean 'stroke'?
asked: stroke@1 mm ->
    predict stroke = '1 mm': mm is a unit of length, not of voltage; give a number in V or a string such as
    '1.2 kV' (units V, kV, mV, MV)
asked: stroke@0 V ->
    predict stroke = '0 V': must be greater than 0 V; give a larger one, such as 1.2 kV
"""
MESSAGES = {
    case: " ".join(message.split())
    for case, message in (own.split(" ->\n") for own in re.split(r"\n(?=\w)", WHOLE.strip()))
}


@pytest.mark.parametrize("case", CASES)
def test_a_message_says_what_is_wrong_and_what_helps(case, tmp_path):
    read, files = CASES[case]
    for name, text in ({"a.csv": COUPON} | files).items():
        (tmp_path / name).write_text(text, encoding="utf-8")
    with pytest.raises(InputError) as error:
        read(tmp_path / next(iter(files)))
    assert str(error.value).replace(f"{tmp_path / 'x'}"[:-1], "") == MESSAGES[case]


@pytest.mark.parametrize("asked", ASKED)
def test_a_prediction_that_cannot_be_asked_for_is_refused_whole(asked):
    with pytest.raises(InputError) as error:
        read_predictions([asked])
    assert str(error.value) == MESSAGES[f"asked: {asked}"]

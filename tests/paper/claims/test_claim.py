"""A claim is what its check, statement and studies make of it."""

import inspect
import re

import pytest

from gelcone.paper.claims import CLAIMS
from gelcone.paper.claims.claim import Claim, claim
from gelcone.paper.figures import FIGURES
from gelcone.paper.reading import LIMIT_THRESHOLD, SIX
from gelcone.paper.studies import STUDIES
from gelcone.paper.studies.practical import VOLTS
from gelcone.paper.studies.resonance import STIFFNESSES
from gelcone.paper.studies.samples import HIGHEST, SAMPLES, VOLTAGE_THRESHOLD


def test_a_claim_holds_all_that_it_is_declared_with():
    def check(studies):
        return studies

    found = claim("slack", "the film is slack", 7, "static", "energy", without=("wrinkling",))(check)
    assert found == Claim("slack", "the film is slack", 7, ("static", "energy"), check, ("wrinkling",))
    assert claim("slack", "the film is slack", 7, "static")(check).without == ()
    assert found.check({"static": 1}) == {"static": 1}


SHOWN = {
    3: ("static-bistable", "fem-agreement"),
    4: ("damping-order",),
    5: ("limit-large-same",),
    6: ("linear-limit", "energy-steepening"),
    7: ("voltage-amplitude",),
    8: ("voltage-spectra",),
    9: ("practical-voltage",),
    10: ("prestretch-order",),
    12: ("spring-frequency", "spring-amplitude", "spring-no-jump"),
    13: ("damping-never-chaotic", "limit-threshold", "limit-tiny-negative", "voltage-threshold"),
    14: ("map-high-voltage", "map-low-prestretch", "map-safe-prestretch", "stable-pocket"),
}
"""Figures of the paper and the claims that it makes about each."""


def test_each_claim_is_about_its_figure_and_its_studies():
    claimed = {name: figure for figure, names in SHOWN.items() for name in names}
    assert {name: own.figure for name, own in CLAIMS.items()} == claimed
    assert set(SHOWN) <= set(FIGURES)
    assert len({own.statement for own in CLAIMS.values()}) == len(CLAIMS)
    for own in CLAIMS.values():
        assert set(own.studies) <= set(STUDIES)
        assert len(set(own.studies)) == len(own.studies)


IN_STATEMENTS = {
    "damping-never-chaotic": (0.0, HIGHEST),
    "limit-threshold": (LIMIT_THRESHOLD,),
    "voltage-threshold": (VOLTAGE_THRESHOLD,),
    "voltage-amplitude": (round(sum(SIX) / 2.0),),
    "practical-voltage": (VOLTS[0], VOLTS[-1]),
    "spring-frequency": (STIFFNESSES[0], STIFFNESSES[-1]),
    "spring-amplitude": (12.0, 11.0),
    "energy-steepening": (1.0,),
}


def numbers_in(text):
    return tuple(float(number) for number in re.findall(r"\d+(?:\.\d+)?", text))


@pytest.mark.parametrize("name", CLAIMS)
def test_the_numbers_of_a_statement_are_those_that_the_studies_compute(name):
    assert numbers_in(CLAIMS[name].statement) == IN_STATEMENTS.get(name, ())


SAID = {
    "static-bistable": ("highest of three", "three times", "+, -, +"),
    "fem-agreement": ("agrees closely", "finite elements", "all three voltages"),
    "linear-limit": ("Without damping and voltage", "infinity", "linear oscillator"),
    "damping-never-chaotic": ("no motion is chaotic", "slightly positive only towards zero"),
    "damping-order": ("Small damping gives slow decay", "large damping an overdamped return"),
    "limit-threshold": ("Chaos for stretch limits below", "stable motion above"),
    "limit-large-same": ("Large", "indistinguishable"),
    "limit-tiny-negative": ("goes to zero", "largest exponent is locally negative"),
    "energy-steepening": ("steepen as the stretch limit falls", "rises sharply near the limit"),
    "voltage-threshold": ("at most zero below", "positive from there on"),
    "voltage-amplitude": ("In the chaotic range", "reaches about"),
    "voltage-spectra": (
        "low voltage one line",
        "excitation frequency",
        "splits at the threshold",
        "above",
        "broadband",
    ),
    "practical-voltage": ("nearly constant", "orders of magnitude below any threshold"),
    "prestretch-order": ("small pre-stretch gives chaos", "moderate one a small limit cycle", "larger one decays"),
    "spring-frequency": ("Raising the spring stiffness", "moves the resonance up"),
    "spring-amplitude": ("peak amplitude falls monotonically", "is not affected"),
    "spring-no-jump": ("no jump or hysteresis", "whole range of drive frequency"),
    "map-high-voltage": ("At high voltage", "predominantly positive whatever the pre-stretch"),
    "map-low-prestretch": ("At small pre-stretch", "chaotic already at moderate voltage"),
    "map-safe-prestretch": ("Above some pre-stretch", "periodic over the whole range of voltage"),
    "stable-pocket": ("narrow pocket of negative exponents", "surrounded"),
}
"""What each check judges: the words of a statement without which it would be another."""


def test_a_statement_says_what_its_check_judges():
    assert list(SAID) == list(CLAIMS)
    for name, words in SAID.items():
        assert [word for word in words if word not in CLAIMS[name].statement] == [], name


def ends_of(study, parameter):
    return tuple(SAMPLES[study][0].drawn[parameter])


@pytest.mark.parametrize(
    ("name", "beginning", "drawn"),
    [
        ("damping-never-chaotic", "other drive voltages", ends_of("other-voltages-damping", "voltage")),
        ("limit-threshold", "other drive voltages", ends_of("other-voltages-limit", "voltage")),
        ("limit-large-same", "other drive voltages", (0.5, 1.7)),
        ("map-low-prestretch", "equi-biaxial pre-stretches", ends_of("share-prestretch", "prestretch")),
    ],
)
def test_the_other_parameters_of_a_claim_are_those_of_its_sample(name, beginning, drawn):
    """Their range stands in the source of the check, as a text of the report."""
    check = inspect.getsource(CLAIMS[name].check)
    (words,) = re.findall(rf'neighbourhood="{beginning} from ([\d.]+) to ([\d.]+)', check)
    assert tuple(map(float, words)) == drawn

"""What the report says of every claim: the reasons, what the paper could not see, and the meaning of each number.

Each text stands here once more, with its numbers from where they are defined, so that a word cannot change unnoticed;
what it says of the mechanics is computed in `FACTS`.
"""

import numpy as np
import pytest
import xarray as xr

from gelcone.motion.attractor.search import NEARBY
from gelcone.paper.claims import CLAIMS
from gelcone.paper.claims.agreement import CLOSE
from gelcone.paper.claims.maps import CHANCE, SURE, WIDEST
from gelcone.paper.claims.statics import LINEAR
from gelcone.paper.effort import QUICK
from gelcone.paper.reading import LIMIT_THRESHOLD, SAME, SIX
from gelcone.paper.studies.diagrams import PANELS
from gelcone.paper.studies.limits import LARGE as LARGE_LIMITS
from gelcone.paper.studies.practical import HEIGHTS, VOLTS
from gelcone.paper.studies.resonance import STIFFNESSES
from gelcone.paper.studies.samples import ABOUT, BANDS, HIGH, HIGHEST, LARGE, SMALL, STRETCHES, VOLTAGE_THRESHOLD
from gelcone.paper.studies.samples import VOLTAGES as EVEN_VOLTAGES
from gelcone.paper.studies.study import reach_of
from gelcone.paper.studies.triples import TRIPLES
from gelcone.paper.verdicts import NEARLY_ALL
from gelcone.presets import find_preset
from tests.paper.claims import (
    test_agreement,
    test_damping,
    test_limit,
    test_maps,
    test_spring,
    test_statics,
    test_voltage,
)
from tests.paper.made_up import checked
from tests.paper.worlds import World, studies_in

BASE, TABLE1 = (find_preset(name).model for name in ("base", "table1"))
WORLD = World(lambda n: (n["voltage"] >= 1.04) & (n["stretch_limit"] < 60.0))
IN_A_WORLD = (
    "damping-never-chaotic",
    "limit-threshold",
    "limit-large-same",
    "voltage-threshold",
    "voltage-amplitude",
    "map-high-voltage",
    "map-low-prestretch",
)


def cascade(study):
    """A diagram with the end of the period doublings that lead to chaos."""
    born = xr.DataArray(1.0625, attrs={"born": "pitchfork"})
    return study.assign(cascade_end=1.125, cascade_end_error=0.001, cascade_born=born)


def studies_of(name):
    """Made-up studies of a claim, by the makers of the other tests."""
    spring = {"frequency": test_spring.response(), "spring": test_spring.spring()}
    maps = {f"map-{mode}": test_maps.plane(test_maps.BELOW) for mode in ("radial", "equibiaxial")}
    pockets = {name: test_maps.with_pockets(test_maps.POCKET) for name in maps}
    if name in IN_A_WORLD:
        studies = studies_in(WORLD, name, QUICK)
        if name == "voltage-threshold":
            studies |= {key: cascade(studies[key]) for key in ("diagram-base-voltage", "diagram-fast-voltage")}
        if name == "limit-large-same":
            waves = np.ones((3, studies["large-limits"].sizes["time"]))
            studies["large-limits"] = studies["large-limits"].assign(displacement=(("limit", "time"), waves))
        return studies
    return {
        "static-bistable": lambda: {"static": test_statics.static()},
        "fem-agreement": lambda: {"continuum": test_agreement.made_up(), "corrected": test_agreement.thresholds()},
        "linear-limit": lambda: {"linear-limit": test_statics.oscillator([1.0, 1.005, 1.015])},
        "damping-order": lambda: {"diagram-base-damping-ratio": test_damping.order()["diagram_base_damping_ratio"]},
        "limit-tiny-negative": lambda: {"beyond": test_limit.beyond()},
        "energy-steepening": lambda: {"energy": test_limit.energies()},
        "voltage-spectra": lambda: test_voltage.of(test_voltage.spectra()),
        "practical-voltage": lambda: {"practical": test_voltage.practical()},
        "prestretch-order": test_spring.prestretch,
        "spring-frequency": lambda: spring,
        "spring-amplitude": lambda: spring,
        "spring-no-jump": lambda: spring,
        "map-safe-prestretch": lambda: maps,
        "stable-pocket": lambda: pockets,
    }[name]()


def in_words(name, *values):
    """The meanings of numbers that differ in a value."""
    return tuple(name.format(value) for value in values)


def slack(*values, parameter="voltage"):
    return in_words(f"share of the time that the film is slack in the chaos at {parameter} {{:g}}", *values)


AT_1_04 = f"{VOLTAGE_THRESHOLD:g}"
DRAWN = f"{TRIPLES['damping'][2][-1]:g}"
ALL = f"{NEARLY_ALL:.0%}"
FEW = f"{1.0 - NEARLY_ALL:.0%}"
NUMBER = {4: "four", 6: "six", 10: "ten"}
OTHER_PRESTRETCH = "equi-biaxial pre-stretch instead of radial"

WHY = {
    "static-bistable": "Above the pitchfork voltage the flat state is unstable between two buckled ones.",
    "fem-agreement": f"Both forces lie within {CLOSE:.0%} of each other at all voltages.",
    "linear-limit": "The film's force x (1 - 1/q^2) is cubic at the flat state: only small motions are linear, at any "
    "stretch limit.",
    "damping-never-chaotic": "At this voltage rest is stable and attracts every motion; at a higher one little damping "
    f"leaves chaos. Needed: no chaos at any damping ratio of a sample that bounds its share by {FEW}.",
    "damping-order": f"The order is right where the larger damping is large enough; the largest drawn ({DRAWN}) is.",
    "limit-threshold": "A low stretch limit stiffens the film within reach of the motion; how low it must be follows "
    f"the voltage. Needed: chaos at {ALL} of the stretch limits below {LIMIT_THRESHOLD / ABOUT:g}, and regular motion "
    f"at {ALL} of those above {LIMIT_THRESHOLD * ABOUT:g}; about {LIMIT_THRESHOLD:g} is any limit between them.",
    "limit-large-same": "While I1 - 3 stays far below J, Gent's film is neo-Hookean to the order (I1 - 3)/J. The "
    f"extents count as the same when each of 4 starts within {NEARBY:.0e} of one another has one at the other limit "
    f"within {SAME:.0%} (in chaos, when two agree), and as different when no two agree; else the start decides, and "
    "nothing is said.".replace("e-09", "e-9"),
    "limit-tiny-negative": "The initial displacement 1 strains the film to I1 - 3 = 0.5: for any smaller stretch limit "
    "there is no such motion, so that the limit of zero cannot be reached from there. A fixed-step integrator starts "
    "on the unphysical side all the same. From inside, some stretch limits have a negative exponent: periodic windows, "
    "of which a finer search would find more.",
    "energy-steepening": "The film's force is x (A - G/q^2) over 1 - (I1 - 3)/J, which grows as J falls at every "
    "displacement.",
    "voltage-threshold": "Chaos sets in near the stated voltage, above the loss of stability of rest, but windows of "
    f"periodic motion interrupt it all the way up. Needed: chaos first at what rounds to {AT_1_04}, no positive "
    f"exponent below, and positive ones above at {ALL} of the voltages.",
    "voltage-amplitude": f"What rounds to {sum(SIX) / 2.0:g} counts as about 6; the error is how far starts within "
    "1e-9 of one another differ. The bound is the stretch limit: at J = 50 the film ends at x = 7.1, and a motion that "
    "only the limit stops is not about 6.",
    "voltage-spectra": "Needed: a strongest line at the frequency of the voltage or of its force (twice that) with "
    "most of the power at low voltage, several lines at the threshold, and a flatness above 0.01 at high voltage.",
    "practical-voltage": "The electric force goes with the square of the voltage: at 50 V it is smaller than at the "
    "threshold by the square of the ratio.",
    "prestretch-order": "Pre-stretch raises the small-signal stiffness of the flat film and with it the voltage at "
    "which rest is lost.",
    "spring-frequency": "Between neighbouring stiffnesses the resonance moves up or down where the intervals of the "
    "peaks do not overlap; where they do, nothing is said.",
    "spring-amplitude": "Both halves are needed: peaks that fall from each stiffness to the next, and an amplitude "
    f"that stays within {SAME:.0%}. Of one motion they cannot both be true. Over the window from the start the "
    "amplitude is that of the release, and not affected; in the long run it is.",
    "spring-no-jump": f"The sweeps up and down count as one while they differ by less than {100.0 * SAME:g} % of the "
    "peak.",
    "map-high-voltage": f"Predominantly means at more than half of the points above v = {HIGH:g}; whatever the "
    f"pre-stretch, in each quarter of its range from {STRETCHES[0]:g} to {STRETCHES[1]:g}.",
    "map-low-prestretch": f"Needed: chaos at one or more of {NUMBER[EVEN_VOLTAGES]} even voltages below {AT_1_04}, the "
    f"threshold of the film without pre-stretch, at more than half of the pre-stretches up to {SMALL:g} and not of "
    f"those from {LARGE:g} on. Below 0.73 the compressed film buckles out of plane, so that the motion has two sides "
    "to choose from without any voltage.",
    "map-safe-prestretch": "Needed: from some pre-stretch up to the largest of the map regular motion at all voltages, "
    f"over enough points to bound the share of others by {FEW}. A run that ends by pull-in is not a motion.",
    "stable-pocket": "A pocket is a connected set of cells with a certainly negative exponent that touches neither the "
    f"edge of the map nor the large regular domain; narrow, if at most {WIDEST:.0%} of the map. It must be larger than "
    f"chance makes it: at most {SURE:.0%} of the maps whose cells inside the chaotic domain are shuffled have one as "
    f"large. Above {CHANCE:.0%} it is chance.",
}
CONSEQUENCE = {
    "static-bistable": "The force of a flat, symmetric device is odd in the displacement, grows with it at large ones "
    "and softens with the voltage: three zeros with these slopes follow at any voltage above the pitchfork.",
    "linear-limit": "Any smooth oscillator is linear for small enough motions; the number is how small.",
    "damping-order": "Any damped oscillator is overdamped beyond critical damping; the number is where that lies.",
    "energy-steepening": "It follows from Gent's energy alone, for any parameters and any motion.",
}
UNSEEN = {
    "static-bistable": "The flat film is slack at these voltages: with pre-stretch 1 the hoop stress is compressive.",
    "fem-agreement": "Without voltage the cone overestimates the force everywhere, by up to 10%. The continuum's "
    "meridian is not straight, but steep next to the disc: there the film reaches half of its stretch limit at a "
    "displacement of 3, the cone only at 5. Below: the paper's threshold voltages when the continuum replaces the "
    "cone.",
    "linear-limit": "How small the motion must be; at the paper's initial state the oscillator is not linear.",
    "damping-never-chaotic": "That the statement concerns the chosen voltage: it lies below the loss of stability of "
    "rest. Without damping the exponent over a window T falls like log(T)/T, which looks slightly positive in any "
    "window.",
    "damping-order": "Where overdamping begins: at the root of the small-signal stiffness, reduced by the voltage.",
    "limit-threshold": "The largest stretch limit at which chaos was seen, over the voltage.",
    "limit-large-same": "In chaos no two stretch limits give the same time series, however large they are. The verdict "
    f"is that of v = {PANELS['fast', 'stretch_limit']:g}.",
    "limit-tiny-negative": "That the initial state lies beyond the stretch limit, where the energy is not defined.",
    "energy-steepening": "The energy grows only like a logarithm at the limit: an integrator without a guard can step "
    "across.",
    "voltage-threshold": "The periodic windows: over a short window their transients look chaotic. Instability of rest "
    "comes first and is not chaos.",
    "voltage-amplitude": "An amplitude of 6 is six film widths out of plane; the strain is 70% of the stretch limit "
    "and the hoop slack.",
    "voltage-spectra": "At low voltage the device comes to rest: what its spectrum shows is the free vibration from "
    "the start, at its natural frequency and not at that of the drive.",
    "practical-voltage": "The amplitude is that of the release, not of the drive: in the long run the drive hardly "
    "moves the disc.",
    "prestretch-order": "Which of the thresholds does it: rest at the largest pre-stretch is stable by Floquet theory.",
    "spring-frequency": "The force goes with the square of the voltage: the peak lies near half the natural frequency, "
    "except where a soft spring allows a large, strongly nonlinear motion.",
    "spring-amplitude": "Figure 11 shows the free decay from the initial state, figure 12 the driven motion.",
    "spring-no-jump": "Two sweeps are needed to see hysteresis at all.",
    "map-high-voltage": "Which pre-stretch was meant: stretched in both directions the film stiffens, and less of the "
    "map is chaotic.",
    "map-low-prestretch": "Below 1 the film is compressed when flat, and the membrane model does not hold.",
    "map-safe-prestretch": "That the answer depends on what pre-stretch means; the paper's wording fits the radial "
    "reading.",
    "stable-pocket": "How many there are: periodic windows riddle the chaotic domain, and finer maps show more of "
    "them.",
}
NEIGHBOURHOOD = {
    "fem-agreement": "radius ratio a/b = 0.5",
    "linear-limit": "smaller initial displacements than the paper's own, 1",
    "damping-never-chaotic": f"other drive voltages from 0.5 to {HIGHEST:g}, each at damping ratios from 0.02 to 2",
    "damping-order": f"larger damping ratios than the largest drawn, {DRAWN}, up to 2",
    "limit-threshold": "other drive voltages from 0.7 to 1.6, chaos at most of the lower stretch limits and at none of "
    "the higher",
    "limit-large-same": "other drive voltages from 0.5 to 1.7",
    "limit-tiny-negative": "starts at half the displacement that the stretch limit allows, for limits from 0.02 to 0.5 "
    "that do not allow the paper's start",
    "voltage-threshold": f"16 parameter sets near the base set, a positive exponent over voltages from {AT_1_04} to "
    f"{HIGHEST:g}",
    "voltage-amplitude": "16 parameter sets near the base set",
    "voltage-spectra": "the other parameter set",
    "prestretch-order": "20 parameter sets near the base set",
    "spring-frequency": "the stiffnesses without the smallest or without the largest",
    "spring-no-jump": f"single spring stiffnesses of the {NUMBER[len(STIFFNESSES)]}",
    "map-high-voltage": f"{OTHER_PRESTRETCH}, each quarter of the range from {STRETCHES[0]:g} to {STRETCHES[1]:g} for "
    "itself",
    "map-low-prestretch": f"equi-biaxial pre-stretches from {STRETCHES[0]:g} to {SMALL:g}",
    "map-safe-prestretch": OTHER_PRESTRETCH,
    "stable-pocket": OTHER_PRESTRETCH,
}
POSITIVE = f"share of voltages in {AT_1_04} to {HIGHEST:g} with a positive exponent"
DOUBLINGS = "end of the period doublings of the branch from the pitchfork at v = 1.0625, set {}"
SPRINGS = (0.1, 1.0, 20.0)
MEANINGS = {
    "static-bistable": (
        "equilibria at the highest voltage",
        *in_words("slope at x = {}", 0, 1, 2),
        "pitchfork voltage, the square root of the small-signal stiffness",
    ),
    "fem-agreement": (
        *in_words("largest deviation of the cone's force at v = 0, a/b = {}", 0.2, 0.5),
        *in_words("share of the displacements with a film in tension, v = {}, a/b = 0.2", 0, 1, 1.5),
        *in_words("share of the displacements with a film in tension, v = {}, a/b = 0.5", 0, 1, 1.5),
        "displacement at 10% of the stretch limit next to the disc (cone 2)",
        "displacement at 50% of the stretch limit next to the disc (cone 5)",
    ),
    "linear-limit": (
        f"largest displacement with the period within {100.0 * LINEAR:g} % of the linear one",
        "period at the displacement 1 over the linear period",
    ),
    "damping-never-chaotic": (
        "share of damping ratios in (0, 2] without chaos",
        "largest exponent without damping",
        "largest drive voltage up to which no chaos was seen at any damping ratio",
    ),
    "damping-order": (
        "smallest overdamped damping ratio that was seen",
        "square root of the small-signal stiffness: critical damping without voltage",
    ),
    "limit-threshold": (
        f"share of stretch limits below {LIMIT_THRESHOLD / ABOUT:g} with chaos",
        f"share of stretch limits above {LIMIT_THRESHOLD * ABOUT:g} with regular motion",
    ),
    "limit-large-same": (
        "largest difference of the extents in the long run, J = 100 and 300 against 1000",
        "share of other voltages from 0.5 to 1.7 with the same extent in the long run",
        f"largest difference of the time series over the window, v = {PANELS['fast', 'stretch_limit']:g}",
    ),
    "limit-tiny-negative": (
        "smallest stretch limit that the paper's initial state allows",
        "share of smaller ones with a negative exponent, from inside the limit",
        "exponent at the smallest limit from inside",
        "exponent of the fixed-step run there, beyond the limit",
    ),
    "energy-steepening": (
        "share of neighbouring stretch limits of which the smaller is steeper everywhere",
        "displacement at which the film with J = 1 ends",
        "slope for J = 1 over that for J = 100, at 95 % of that displacement",
    ),
    "voltage-threshold": (
        "smallest voltage at which chaos was seen",
        POSITIVE,
        f"share of voltages below {AT_1_04} with an exponent at most zero",
        f"{POSITIVE}, set fast",
        "smallest voltage at which chaos was seen, set fast",
        "static pitchfork voltage, where rest loses its stability at constant voltage",
        *in_words(DOUBLINGS, "base", "fast"),
        *slack(1.04, 1.7),
    ),
    "voltage-amplitude": (
        f"largest displacement in chaos up to v = {HIGHEST:g}, set base",
        f"largest displacement from the start up to v = {max(TRIPLES['voltage'][2]):g}, set base",
        "share of parameter sets near the base set for which it rounds to 6",
        *slack(1.04, 1.7),
    ),
    "voltage-spectra": (
        "strongest line at low voltage from the start, over the drive's",
        "swing left at low voltage in the long run (rms)",
        "spectral flatness at high voltage, long run",
        *slack(2, 3),
    ),
    "practical-voltage": (
        "lowest threshold (loss of stability of flat rest at constant voltage) over 50 V",
        "largest relative change of the amplitude over 10 to 50 V",
        *in_words("amplitude left in the long run at 50 V, initial height {} mm", 0, 20),
    ),
    "prestretch-order": (
        "largest exponent at pre-stretch 0.8 (chaotic)",
        "largest exponent at pre-stretch 1 (periodic)",
        "largest exponent at pre-stretch 1.5 (rest)",
        "share of parameter sets near the base set with the same order",
        *slack(0.8, parameter="prestretch"),
    ),
    "spring-frequency": in_words("resonance at spring stiffness {:g}", *SPRINGS),
    "spring-amplitude": (
        *in_words("peak amplitude at spring stiffness {:g}", *SPRINGS),
        "amplitude from the start at stiffness 10 over that at 1 (figure 11)",
        "the same in the long run",
    ),
    "spring-no-jump": in_words("largest difference of the sweeps over the peak, spring stiffness {:g}", *SPRINGS),
    "map-high-voltage": (
        f"smallest share of a quarter of the radial pre-stretches with a positive exponent above v = {HIGH:g}",
        "the same, equi-biaxial",
        *slack(1.04, 1.7),
    ),
    "map-low-prestretch": (
        f"share of radial pre-stretches up to {SMALL:g} with chaos below v = {AT_1_04}",
        f"the same from {LARGE:g} on",
        f"the same up to {SMALL:g}, equi-biaxial",
    ),
    "map-safe-prestretch": (
        "share of the map's radial pre-stretches with regular motion up to v = 2",
        "the same, equi-biaxial",
        "smallest equi-biaxial pre-stretch of the map from which on all motions up to v = 2 are regular",
    ),
    "stable-pocket": (
        "cells in the largest narrow pocket of the radial map",
        "share of shuffled maps with a pocket as large",
        "cells in the largest narrow pocket of the equi-biaxial map",
        "share of shuffled maps with a pocket as large, equi-biaxial",
    ),
}
DETAILS = {
    "fem-agreement": ["pitchfork"],
    "limit-threshold": [
        f"largest stretch limit at which chaos was seen, v = {v:.3g}" for v in np.linspace(0.7, 1.6, QUICK.limit_map[0])
    ],
    "voltage-spectra": ["share of power in lines at the threshold, long run"],
}


@pytest.mark.parametrize("name", CLAIMS)
def test_the_words_of_a_claim_are_these(name):
    """Each text in its own place, and no other text anywhere."""
    finding = checked(name, studies_of(name))
    assert finding.why == WHY[name]
    assert finding.consequence == CONSEQUENCE.get(name, "")
    assert finding.unseen == UNSEEN[name]
    assert finding.neighbourhood == NEIGHBOURHOOD.get(name, "")
    assert tuple(one.meaning for one in (*finding.numbers, *finding.slack)) == MEANINGS[name]
    assert list(finding.details) == DETAILS.get(name, [])


def test_the_parts_of_a_claim_say_where_they_are_judged():
    parts = checked("spring-amplitude", studies_of("spring-amplitude")).parts
    assert {name: part.why for name, part in parts.items()} == {
        "peak falls": "from each stiffness to the next where the errors of the peaks do not overlap",
        "amplitude not affected": "in the long run",
    }


def test_numbers_of_the_words_are_those_of_the_studies():
    assert BANDS == 4  # quarters
    assert (VOLTS[0], VOLTS[-1], tuple(1e3 * np.array(HEIGHTS))) == (10.0, 50.0, pytest.approx((0.0, 20.0)))
    assert tuple(LARGE_LIMITS) == (100.0, 300.0, 1000.0)


# --- what is said of the mechanics ------------------------------------------------------------------------------------

X = np.linspace(0.05, 3.0, 60)
Q = 1.0 + X**2


def gent(limit):
    return BASE.replace(stretch_limit=limit, spring_stiffness=0.0)


def the_flat_state_is_unstable_above_the_pitchfork():
    pitchfork = np.sqrt(TABLE1.stiffness(0.0))
    below, above = (np.diff(np.sign(TABLE1.force(np.linspace(-3.0, 3.0, 601), r * pitchfork))) for r in (0.99, 1.1))
    flat = [float(TABLE1.stiffness(0.0, r * pitchfork)) for r in (0.99, 1.1)]
    return (np.abs(below).sum(), np.abs(above).sum()) == (2, 6) and flat[0] > 0.0 > flat[1]


def the_force_is_odd_grows_and_softens():
    force = TABLE1.force(X, 1.5)
    return bool(
        (TABLE1.force(-X, 1.5) == -force).all()
        and (np.diff(force[-20:]) > 0.0).all()
        and (force < TABLE1.force(X, 1.0)).all()
    )


def the_flat_film_is_compressed_around_under_any_voltage():
    return all(TABLE1.film_state(0.0, v).hoop_stress < 0.0 for v in (0.5, 1.5)) and TABLE1.prestretch_mode == "radial"


def the_force_is_cubic():
    film = gent(np.inf)
    small = np.array([1e-4, 2e-4])
    np.testing.assert_allclose(film.film_force(X), X * (1.0 - 1.0 / Q**2), rtol=1e-12)
    return bool(np.isclose(np.divide(*film.film_force(small)), 0.125, rtol=1e-6))


def the_force_is_that_of_gent_and_grows_as_the_limit_falls():
    excess = Q + 1.0 / Q - 2.0
    for limit in (50.0, 100.0):
        np.testing.assert_allclose(gent(limit).film_force(X), X * (1.0 - 1.0 / Q**2) / (1.0 - excess / limit))
    return bool((gent(50.0).film_force(X) > gent(100.0).film_force(X)).all())


def the_energy_grows_like_a_logarithm_at_the_limit():
    film = gent(1.0)
    steps = np.diff([float(film.energy(float(reach_of(film)) * (1.0 - 10.0**-k))) for k in (3, 5, 7)])
    return bool(np.isclose(*steps, rtol=1e-2))


def the_film_is_neo_hookean_to_the_order_of_the_strain_over_the_limit():
    apart = gent(1000.0).film_force(X) / gent(np.inf).film_force(X) - 1.0
    return bool(np.allclose(apart, gent(1000.0).strain(X) / 1000.0, rtol=0.02))


def the_energy_is_not_defined_beyond_the_limit():
    start = find_preset("fast").initial[0]
    strain = float(BASE.strain(start))
    ends = [bool(np.isfinite(gent(limit).energy(start))) for limit in (0.99 * strain, 1.01 * strain)]
    return (start, strain, ends) == (1.0, 0.5, [False, True])


def the_film_ends_at_7_1():
    return (
        f"J = {float(BASE.stretch_limit):g} the film ends at x = {float(reach_of(BASE)):.1f}"
        in WHY["voltage-amplitude"]
    )


def at_an_amplitude_of_six_the_hoop_is_slack():
    state = BASE.film_state(6.0, VOLTAGE_THRESHOLD)
    return f"{float(state.limit_share):.0%}" == "70%" and state.hoop_stress < 0.0


def prestretch_stiffens_the_flat_film():
    stiffness = [float(BASE.replace(prestretch=lp).stiffness(0.0)) for lp in (0.8, 1.0, 1.5)]
    both = float(BASE.replace(prestretch=1.5, prestretch_mode="equibiaxial").stiffness(0.0))
    return sorted(stiffness) == stiffness and both > stiffness[-1]


def below_0_73_the_film_buckles_without_voltage():
    below, above = (float(BASE.replace(prestretch=lp).stiffness(0.0)) for lp in (0.72, 0.73))
    return below < 0.0 < above


def below_one_the_flat_film_is_compressed():
    return all(BASE.replace(prestretch=lp).film_state(0.0, 0.0).meridional_stress < 0.0 for lp in (STRETCHES[0], 0.99))


def the_force_goes_with_the_square_of_the_voltage():
    pull = [TABLE1.force(X, 0.0) - TABLE1.force(X, v) for v in (0.5, 1.0)]
    return bool(np.allclose(pull[1], 4.0 * pull[0]))


def the_voltage_reduces_the_damping_at_which_motion_is_overdamped():
    return float(BASE.stiffness(0.0, 0.5)) < float(BASE.stiffness(0.0))


FACTS = [
    (
        WHY,
        "static-bistable",
        "unstable between two",
        the_flat_state_is_unstable_above_the_pitchfork,
    ),
    (CONSEQUENCE, "static-bistable", "odd in the displacement, grows", the_force_is_odd_grows_and_softens),
    (UNSEEN, "static-bistable", "compressive", the_flat_film_is_compressed_around_under_any_voltage),
    (WHY, "linear-limit", "x (1 - 1/q^2) is cubic", the_force_is_cubic),
    (WHY, "energy-steepening", "x (A - G/q^2) over", the_force_is_that_of_gent_and_grows_as_the_limit_falls),
    (WHY, "limit-threshold", "low stretch limit stiffens", the_force_is_that_of_gent_and_grows_as_the_limit_falls),
    (UNSEEN, "energy-steepening", "like a logarithm", the_energy_grows_like_a_logarithm_at_the_limit),
    (WHY, "limit-large-same", "neo-Hookean", the_film_is_neo_hookean_to_the_order_of_the_strain_over_the_limit),
    (UNSEEN, "limit-tiny-negative", "not defined", the_energy_is_not_defined_beyond_the_limit),
    (WHY, "voltage-amplitude", "ends at x = 7.1", the_film_ends_at_7_1),
    (UNSEEN, "voltage-amplitude", "70% of the stretch limit", at_an_amplitude_of_six_the_hoop_is_slack),
    (WHY, "prestretch-order", "raises the small-signal stiffness", prestretch_stiffens_the_flat_film),
    (UNSEEN, "map-high-voltage", "in both directions the film stiffens", prestretch_stiffens_the_flat_film),
    (WHY, "map-low-prestretch", "Below 0.73", below_0_73_the_film_buckles_without_voltage),
    (UNSEEN, "map-low-prestretch", "Below 1 the film is compressed", below_one_the_flat_film_is_compressed),
    (WHY, "practical-voltage", "the square of the voltage", the_force_goes_with_the_square_of_the_voltage),
    (UNSEEN, "damping-order", "reduced by the voltage", the_voltage_reduces_the_damping_at_which_motion_is_overdamped),
]


@pytest.mark.parametrize(
    ("texts", "name", "words", "fact"), FACTS, ids=[f"{name}: {words}" for _, name, words, _ in FACTS]
)
def test_what_is_said_of_the_mechanics_is_so(texts, name, words, fact):
    assert words in texts[name]
    assert fact()

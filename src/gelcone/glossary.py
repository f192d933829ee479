"""The terms of figures, tables and messages, explained once; `docs/glossary.md` and `gelcone help` print them."""

from __future__ import annotations

import textwrap

from gelcone.codes import Regime

WIDTH = 100
"""Columns of the text."""
GLOSSARY: dict[str, str] = {
    "above membrane pull-in": "A run on a cone is at a voltage at which the membrane, for which the cone stands, has "
    "pulled in: its film would be lost.",
    "amplitude": "Half the peak-to-peak size of an oscillating quantity; of the drive, voltage = offset + amplitude "
    "sin(2 pi frequency t).",
    "apparent power": "Root mean square voltage times root mean square current: what the amplifier must be rated for. "
    "The mean power is far smaller, for the film is a capacitor.",
    "attractor": "A motion that nearby motions approach: a rest, a periodic orbit, a torus or chaos. Several may "
    "coexist; the start decides which is approached.",
    "bifurcation": "A value of a parameter at which the kind or the number of motions changes.",
    "blocked force": "Force of the disc on a stop that holds it where it rests without voltage.",
    "branch": "A family of motions that changes continuously with a parameter, stable or not.",
    "breakdown": "The true electric field in the film exceeds its dielectric strength.",
    "chaotic": Regime.CHAOTIC.meaning,
    "crumpled": "A film compressed along hoop and meridian: wrinkled in both directions, without tension.",
    "displacement": "Distance of the disc from the flat film along the axis, of either sign: with a device its height "
    "in mm, else divided by the width of the film from disc to rim, x = h/(b-a).",
    "doubtful": "A result whose pieces of evidence disagree, or whose name a start next to it may change; run it "
    "longer or examine it before relying on it.",
    "equilibrium": "A displacement at which the forces on the disc cancel under a constant voltage: the disc rests "
    "there where it is stable, and leaves it where it is unstable.",
    "tangent stiffness": "Slope of the meridional tension of a ring of the membrane by its stretch; the ring localises "
    "where it falls to zero.",
    "fold": "A value of a parameter at which a stable and an unstable state meet and vanish; a jump follows.",
    "forcing period": "Period of the force on the disc, which follows the squared voltage: half the period of the "
    "voltage where there is no offset and no circuit that limits or delays the voltage; with one, periods are those of "
    "the voltage.",
    "held at its peak": "Of a drive of two films in opposite phase: their voltages at its peak, raised slowly, bias "
    "and amplitude in proportion; constant voltages in statics keep the device's bias.",
    "height": "The displacement of the disc in units of length; 0 is flat.",
    "hoop": "The direction around the cone, along circles.",
    "hoop slack": "The film is compressed along the hoop, and wrinkles along the meridians. A taut film bears the "
    "compression, a real one does not.",
    "kick": "A sudden change of the disc's velocity, which may lead to another attractor.",
    "left the domain": Regime.LEFT_THE_DOMAIN.meaning,
    "linear theory": "The response of the model linearised about its equilibrium under the mean square of the drive.",
    "localisation": "A way to pull in: the strain of a stretched film runs into one ring, which thins without limit, "
    "because the tension of the ring falls as it lengthens.",
    "Lyapunov exponent": "Mean rate at which neighbouring motions part (positive: chaos) or approach each other.",
    "margin": "The share by which a voltage is below a limit: 1 - voltage/limit, of creep and maps below pull-in.",
    "membrane": "The film with a stretch that varies from disc to rim, as opposed to the cone, whose stretch is "
    "the same everywhere.",
    "meridian": "The direction from the disc to the rim, along the straight lines of the cone.",
    "meridional slack": "The film is compressed along the meridians, and pulls no longer.",
    "minimum": "A way to pull in: a slack film loses the minimum of its energy, and thins without limit.",
    "near the stretch limit": "The strain is within 1 % of the stretch limit, where the film is almost rigid.",
    "onset of rest": "The amplitude at which a flat film under a periodic voltage begins to move (parametric "
    "resonance); the regions above it are the tongues.",
    "outcome": "How the computation of a motion ended: ok, or the reason why it did not reach its end.",
    "peak voltage": "The largest absolute value of the voltage of a drive: |offset| + amplitude for a sine.",
    "period": "The number of forcing periods after which a motion repeats; more than 1 is subharmonic.",
    "periodic": Regime.PERIODIC.meaning,
    "pitchfork": "The constant voltage at which the flat film, or a raised pair of equal films in its middle, loses "
    "its stability and buckles to either side. It is a pull-in where the disc jumps there, and none where it rises "
    "gradually.",
    "Poincare section": "Displacement and velocity once every forcing period; a periodic motion is a few points.",
    "pull-in": "The film loses its equilibrium under the voltage: it thins without limit, or the disc jumps to "
    "another equilibrium or away. A run ends there.",
    "pull-in at a constant voltage": "Pull-in on a slow ramp to a constant voltage; it bounds a window where no "
    "driven motion pulls in at a lower peak voltage.",
    "quasi-periodic": Regime.QUASI_PERIODIC.meaning,
    "regime": "The kind of a motion: rest, periodic, quasi-periodic, chaotic, transient, transient chaos, or one that "
    "left the domain of the model.",
    "rest": Regime.REST.meaning,
    "settled": "After the transient: the motion that is approached.",
    "stretch limit": "The largest strain I1 - 3 that the law of the film allows (Gent's J).",
    "stroke": "Peak-to-peak displacement of a motion; in statics the displacement from the rest without voltage.",
    "taut": "In tension along hoop and meridian.",
    "transient": Regime.TRANSIENT.meaning,
    "transient chaos": Regime.TRANSIENT_CHAOS.meaning,
    "validity": "The share of a motion in which an assumption of the model does not hold.",
    "work of a cycle": "Largest work that a load can take up in a cycle that pushes it out under a constant voltage "
    "and back without one: the area between the two forces over the stroke.",
    "work of a stroke": "Work on a load that takes the disc slowly from a stop at its rest without voltage to its rest "
    "under the voltage; about half that of a cycle.",
    "window": "The drives recommended at a frequency: peak voltages below all limits by the margin.",
}
"""Term -> meaning."""


def explain(term: str) -> str:
    """The explanation of a term, as a block of lines."""
    return "\n".join([term, *textwrap.wrap(GLOSSARY[term], WIDTH, initial_indent="  ", subsequent_indent="  ")])


def find_term(text: str) -> str | None:
    """The term that a text names, ignoring case, hyphens and underscores; None without one."""
    known = {_plain(term): term for term in GLOSSARY}
    return known.get(_plain(text))


def _plain(text: str) -> str:
    return text.lower().replace("-", " ").replace("_", " ")

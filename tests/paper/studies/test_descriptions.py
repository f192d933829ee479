"""What the variables of the studies are called in their files, and their quantities."""

from tests.descriptions import described_in

DESCRIBED = """
continuum: cone: threshold in the homogeneous cone: voltage
continuum: corrected: threshold with the continuum film: voltage
continuum: lost: voltage at which the continuum film has no state any more: voltage
diagrams: rest_growth: growth rate of deviations from rest under the drive: rate
diagrams: static_stiffness: small-signal stiffness of rest at the peak voltage: stiffness
ends: counted: positive exponents, counted before: count
ends: relaxation_time_1: relaxation time of the branch, 0 without: parameter
ends: series_resistance: series resistance, 0 without: parameter
ends: viscous_modulus_1: modulus of the branch, 0 without: parameter
limits: amplitude: initial displacement: length
limits: extent: largest displacement in the long run, nearby starts: length
limits: fixed_step_beyond: share of its steps beyond the stretch limit: share
limits: fixed_step_exponent: largest exponent of the fixed-step run over the window: rate
limits: initial_strain: I1 - 3 at the start: share
limits: inside_start: displacement from which the true motion starts: length
limits: lyapunov: Lyapunov exponents of the true motion: rate
limits: period_ratio: period over that of the linear oscillator: share
limits: regime: kind of motion in the long run: code
limits: regime: kind of motion of the true motion: code
limits: standard_error: standard error of the exponents: rate
practical: dielectric_strength: dielectric strength (assumed): field
practical: largest_field: largest true field from the start: field
practical: late_amplitude: half the swing in the long run: length
practical: late_middle: middle of the swing in the long run: length
practical: onset_voltage: drive voltage at which flat rest is lost (Floquet): voltage
practical: pitchfork_voltage: constant voltage at which flat rest is lost: voltage
practical: pull_in_voltage: voltage at which a slow ramp is lost: voltage
practical: rest_displacement: rest without voltage: length
practical: window_amplitude: half the swing from the start: length
resonance: natural_frequency: frequency of small swings at the mean-square voltage: frequency
sampling: extent: largest displacement in the long run: length
sampling: finite: Lyapunov exponents over the window from the start: rate
sampling: lifetime_high: largest mean lifetime of chaos: time
sampling: lyapunov: Lyapunov exponents of the long run: rate
sampling: regime: kind of motion in the long run: code
sampling: share_chaotic: share of nearby starts that are chaotic: share
sampling: standard_error: standard error of the exponents: rate
statics: displacement: displacement x = h/(b-a): length
statics: film_energy: strain energy of the film, NaN beyond the stretch limit: energy
statics: film_force: force of the film: the slope of its strain energy: force
statics: reach: displacement at which the film reaches its stretch limit: length
triples: finite: Lyapunov exponents per unit time over the window: rate
triples: finite_exponent: largest exponent over that window: rate
triples: finite_time: window length, from the start: time
triples: {name}_highest: highest displacement: length
triples: {name}_lowest: lowest displacement: length
triples: {name}_validity_slack: share of slack film: share
"""


def test_each_variable_has_its_words_and_its_quantity():
    """Readers of a file know a variable by these alone; its name is short."""
    assert described_in("paper") == DESCRIBED.split("\n")[1:-1]

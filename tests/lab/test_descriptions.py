"""What the variables of fits, plans and designs are called in their files, and their quantities."""

from tests.descriptions import described_in

DESCRIBED = """
datasheet: drive_frequency: drive frequency: frequency
datasheet: gain: small-signal stroke over the static one: share
datasheet: ramp_voltage: constant voltage: voltage
design: binding_requirement: requirement that binds: code
design: design: number of the design: count
design: first_limit: limit that comes first: code
device: covariance: covariance of the logarithms of the factors: share
device: deviation: logarithm of the factor on the nominal value: share
device: exponent: change that leaves every reading: share
device: left_out_chi2: chi2 of a test predicted from the others: share
device: left_out_p_value: probability of a larger one: share
device: left_out_points: number of its readings: count
device: measured: measured value in SI: share
device: noise: standard deviation of its noise: share
device: nominal: nominal value in SI: share
device: posterior: relative standard deviation that the tests leave: share
device: predicted: value of the fitted device: share
device: prior: relative standard deviation of the prior: share
device: profile_high: upper end of the profile interval, as a logarithm: share
device: profile_low: lower end of the profile interval, as a logarithm: share
device: reading_along: voltage, height or frequency of the reading, in SI: share
device: reading_axis: what it is drawn over: code
device: reading_name: what is read: code
device: reading_test: number of its test: count
device: reading_unit: unit of the reading: code
device: singular_value: what is learnt along it, over the priors: share
device: structure_objective: chi2 with priors and gains: share
device: structure_p_value: probability of a larger chi2: share
device: value: value in SI: share
material: branch_count: number of Maxwell branches: count
material: draws: {words}: share
material: error: {_ERROR}: share
material: fit_error: mean {_ERROR}: share
material: high: upper end of the 95 % interval of the fitted value: share
material: law: strain-energy law: code
material: left_out_error: {_ERROR_OUT}: share
material: low: lower end of the 95 % interval of the fitted value: share
material: parameter: parameter of the material: code
material: prediction_error: mean {_ERROR} of tests left out: share
material: sample_test: number of its test: count
material: stretch: stretch along the coupon: share
material: value: fitted value in SI: share
predictions: predicted_prior: standard deviation of the prediction from the priors alone, in SI: share
predictions: predicted_spread: standard deviation of the prediction, in SI: share
predictions: predicted_value: prediction in SI: share
"""


def test_each_variable_has_its_words_and_its_quantity():
    """Readers of a file know a variable by these alone; its name is short."""
    assert described_in("lab") == DESCRIBED.split("\n")[1:-1]

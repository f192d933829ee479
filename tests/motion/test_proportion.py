"""Names of two questions, where they are two."""

import pytest
import xarray as xr

from gelcone.motion import proportion
from gelcone.physics.model import ConeModel


@pytest.mark.parametrize("drive", [None, "same", "constant", "opposite"])
def test_names_and_meanings_differ_for_films_in_opposite_phase_alone(drive):
    films = {} if drive is None else {"second_film": "taut", "second_drive": drive}
    system = ConeModel(**films).system
    found = [
        proportion.at_own_bias(system), proportion.in_proportion(system), proportion.proportional("a_voltage", system),
    ]  # fmt: skip
    differ = [", at the actuator's bias", ", bias and amplitude in proportion", "proportional_a_voltage"]
    assert found == (differ if drive == "opposite" else ["", "", "a_voltage"])


def test_limits_are_of_a_drive_held_at_its_peak_where_they_say_so():
    """Recommendations name the second voltage, thresholds of creep their proportion; one of them is enough."""
    told = [("recommended_second_voltage",), ("proportional_pull_in_voltage",), ("recommended_constant",), ()]
    found = [proportion.held_at_peak(xr.Dataset(dict.fromkeys(names, 0.4))) for names in told]
    assert found == [True, True, False, False]

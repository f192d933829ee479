"""Numbers are written to the digits that their errors support."""

import numpy as np
import pytest

from gelcone.paper.numbers import Number


@pytest.mark.parametrize(
    ("number", "text"),
    [
        (Number("n", 1.0234567), "1.023"),
        (Number("n", 1.0234567, error=0.0021), "1.0235 ± 0.0021"),
        (Number("n", 1.0234567, error=0.21), "1.02 ± 0.21"),
        (Number("n", 1.0234567, error=1e-9), "1.023"),
        (Number("n", 120.0, error=13.0), "120 ± 13"),
        (Number("n", 1.0, low=0.95, high=1.15, unit="kV"), "1.00 [0.95, 1.15] kV"),
        (Number("n", 1.0, error=np.inf), "1 (error unknown)"),
        (Number("n", np.nan), "none"),
        (Number("n", 1.0, error=4.9e-5), "1"),
        (Number("n", 1.0, error=5.1e-5), "1.000000 ± 0.000051"),
        (Number("n", -1.0, low=-1.00002, high=-0.99998), "-1"),
        (Number("n", 2e-8, error=1e-8, unit="V"), "2e-08 ± 1e-08 V"),
        (Number("n", 2e-5, error=1.5e-6), "0.0000200 ± 0.0000015"),
        (Number("n", 2e-6, error=1.5e-7), "2e-06 ± 1.5e-07"),
        (Number("n", 1.0, low=0.95), "1"),
        (Number("n", 1.0, error=0.3, low=0.9, high=1.1), "1.00 ± 0.30"),
        (Number("n", 1.0, error=np.inf, unit="mm"), "1 mm (error unknown)"),
    ],
)
def test_a_number_is_written_with_its_error(number, text):
    assert str(number) == text

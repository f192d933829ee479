"""Made-up settled motions."""

import numpy as np

from gelcone.motion.swing import Swing
from tests.recorded import numbers


def swings(count, **changes):
    """Settled motions in which no two numbers are equal."""
    blank = Swing.blank(count)
    own = {name: numbers(*values.shape, at=k + 1.0) for k, (name, values) in enumerate(vars(blank).items())}
    own |= {"period": 2 + np.arange(count), "resting": np.arange(count) == 1, "outcome": np.zeros(count, dtype=np.int8)}
    return Swing(**(own | {"harmonics": own["harmonics"] * np.exp(0.5j)} | changes))

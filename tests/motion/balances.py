"""Models with folds and pitchforks, and a made-up balance whose numbers are known."""

import numpy as np

from gelcone import (
    ConeModel,
    PullIn,
    integrate,
)
from gelcone.physics.balance import Equilibrium, Loss

TABLE1 = ConeModel(spring_stiffness=1.5, stretch_limit=50.0)
# Softens and then stiffens: folds on both sides, and a jump on the ramp.
SOFTENING = ConeModel(law="yeoh", **{"yeoh_c2": -0.2, "yeoh_c3": 0.02}, spring_stiffness=1.5, rest_height=0.1)


def random_model(rng):
    law = rng.choice(["gent", "yeoh", "neo-hookean"])
    own = {
        "gent": {"stretch_limit": 10.0 ** rng.uniform(-0.3, 2.0)},
        "yeoh": {"yeoh_c2": rng.normal(0.0, 0.5), "yeoh_c3": rng.normal(0.0, 0.1)},
        "neo-hookean": {},
    }[law]
    return ConeModel.from_parameters(
        {
            "law": law,
            "spring_stiffness": rng.uniform(0.0, 3.0),
            "rest_height": rng.choice([0.0, rng.normal(0.0, 0.3)]),
            "prestretch": rng.uniform(0.7, 1.4),
            "prestretch_mode": rng.choice(["radial", "equibiaxial"]),
            **own,
        }
    )


def settled(model, voltages, start):
    """A slow ramp by the equation of motion: let come to rest at each constant voltage, from the last state."""
    states = [np.array([start, 0.0])]
    for voltage in voltages:
        held = model.replace(voltage=0.0, voltage_bias=voltage, damping_ratio=0.7, drive_frequency=1.0)
        states.append(integrate(held, states[-1] + [1e-7, 0.0], [500.0]).states[0, -1])
    return np.array(states[1:])[:, 0]


class Balance:
    """A made-up balance, all of whose numbers are its own."""

    reachable, flat, free_height, highest, highest_squared = True, True, 0.25, 2.0, 9.0
    system, n = ConeModel().system, {}

    def __init__(self, at):
        self.at = at

    def equilibria(self, squared):
        return [[Equilibrium(self.at + w + k, 1.0 + k, k == 0) for k in range(1 + (w > 0.5))] for w in squared]

    def whole(self, x, squared):
        return np.broadcast_to(np.asarray(x) < 1.5, np.broadcast_shapes(np.shape(x), np.shape(squared)))

    def inside(self, x):
        return x < 1.5

    def force(self, x, squared):
        return self.at + 3.0 * x + squared

    def slope(self, x, squared):
        return self.at + 4.0 * x - squared

    def force_and_slope(self, x, squared):
        return self.force(x, squared), self.slope(x, squared)

    def stiffness(self, x, squared):
        return np.where(self.whole(x, squared), self.slope(x, squared), np.nan)

    def films(self, x, squared):
        return [np.broadcast_to(squared, np.broadcast_shapes(np.shape(x), np.shape(squared)))]

    def folds(self):
        return [(0.3 * self.at, 5.0 + self.at)]

    def curves(self, highest):
        return [np.array([[self.at], [highest], [7.0 + self.at]])]

    def pitchfork(self):
        return 0.25 * self.at**2

    def along_ramp(self, rest, squared):
        return rest + squared, np.arange(squared.size) + self.at

    def voltage_force(self, x, squared):
        return x * squared

    flat_height = 1.5

    def jump(self, rest):
        return Loss(0.625 * self.at, PullIn.FOLD, 8.0 + rest, 9.0 + rest)


MODEL = ConeModel(damping_ratio=[0.1, 0.2])

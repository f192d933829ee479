"""Steps of a millisecond that a learning environment makes per second on one core, with 1,024 devices at once."""

from __future__ import annotations

import time

import numpy as np

import gelcone

COUNT, STEPS, REPEATS = 1024, 300, 5
UNCERTAIN = {
    "film_thickness": gelcone.Uniform("0.19 mm", "0.21 mm"),
    "moving_mass": gelcone.Normal("5 g", "0.2 g"),
}


def rate(film: str) -> float:
    """Steps of a device in a second of processor time, actions drawn at random; the best of some runs."""
    device = gelcone.find_device("biased-pump").replace(film=film)
    environment = gelcone.environment(device, COUNT, uncertain=UNCERTAIN)
    environment.reset(seed=0)
    actions = np.random.default_rng(0).uniform(-1.0, 1.0, (STEPS, COUNT, 1))
    best = np.inf
    for _ in range(REPEATS):
        begin = time.process_time()
        for action in actions:
            environment.step(action)
        best = min(best, time.process_time() - begin)
    return COUNT * STEPS / best


if __name__ == "__main__":
    for film in ("taut", "wrinkling", "membrane"):
        print(f"{film}: {rate(film) / 1e6:.1f} million steps a second")

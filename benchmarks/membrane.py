"""Time of a force-displacement curve of the membrane: 50 displacements on 200 elements, one core.

    OMP_NUM_THREADS=1 python benchmarks/membrane.py

Times are those of the processor. A curve is to take less than 5 s. Where the film pulls in, its path is followed past
the folds of the voltage, which takes longer. Then forces and pull-in voltages of the film that wrinkles, on two meshes.
"""

from __future__ import annotations

import time

import numpy as np

from gelcone.continuum.membrane import membrane
from gelcone.continuum.path import Ending
from gelcone.physics.model import ConeModel

DISPLACEMENTS = np.linspace(0.04, 2.0, 50)
FILMS = {
    "as mounted": ConeModel(),
    "equi-biaxial pre-stretch 1.2": ConeModel(prestretch=1.2, prestretch_mode="equibiaxial"),
}


def main() -> None:
    """Prints a line for each film and voltage."""
    membrane(ConeModel(), displacements=1.0)  # imports count once, not here
    for name, model in FILMS.items():
        for voltage in (0.0, 0.3, 0.5, 1.0):
            begin = time.process_time()
            result = membrane(model, 0.2, displacements=DISPLACEMENTS, voltages=voltage)
            seconds = time.process_time() - begin
            held = int((result["ending"] == Ending.CONVERGED).sum())
            error = float((result["force_error"] / abs(result["force"])).max())
            print(
                f"{name}, voltage {voltage:g}: {seconds:.2f} s, {held} of 50 in tension, mesh error up to {error:.1e}"
            )
    for elements in (40, 200):
        wrinkling(elements)


def wrinkling(elements: int) -> None:
    """Prints forces and pull-in voltages of the film as mounted, which wrinkles."""
    begin = time.process_time()
    found = membrane(
        ConeModel(),
        0.2,
        displacements=[0.25, 0.5, 0.75, 1.0, 1.25],
        voltages=[0.0, 0.25, 0.4, 0.5, 0.6],
        wrinkles="relax",
        elements=elements,
    )
    print(f"wrinkling, {elements} elements: {time.process_time() - begin:.1f} s")
    for k, v in enumerate(found["constant_voltage"].values):
        points = zip(*(found[name].values[k] for name in ("force", "ending", "reached_voltage")), strict=True)
        told = (
            f"{Ending(code).name.lower()} at {reached:.4f}" if code else f"{force:.5f}"
            for force, code, reached in points
        )
        print(f"  v = {v:g}: " + ", ".join(told))


if __name__ == "__main__":
    main()

"""How long a force-displacement curve of the film as a membrane takes: 50 displacements on 200 elements, one core.

    OMP_NUM_THREADS=1 python benchmarks/membrane.py
    OMP_NUM_THREADS=1 python benchmarks/membrane.py fit [equibiaxial|radial PRESTRETCH LIMIT]

Times are those of the processor. A curve is to take less than 5 s. Where the film pulls in, its path is followed past
the folds of the voltage, which takes longer. Then forces and pull-in voltages of the film that wrinkles, on two meshes.

The second line fits films of several pre-stretches and stretch limits, or one, and prints their errors between what was
fitted, against a membrane of twice the elements, up to 0.95 of the voltage at which it pulls in.
"""

from __future__ import annotations

import sys
import time

import numpy as np

from gelcone.continuum.charged import charged, slack_limit, slack_squared
from gelcone.continuum.fit import ELEMENTS, FLOOR, LOOSE_ELEMENTS, SEARCHED, WEAKEST, fit_film
from gelcone.continuum.membrane import membrane, raised_film
from gelcone.continuum.mesh import mesh_film
from gelcone.continuum.path import Ending
from gelcone.physics.film.wrinkling import NEVER
from gelcone.physics.model import ConeModel

DISPLACEMENTS = np.linspace(0.04, 2.0, 50)
FILMS = {
    "as mounted": ConeModel(),
    "equi-biaxial pre-stretch 1.2": ConeModel(prestretch=1.2, prestretch_mode="equibiaxial"),
}
FITTED = [
    (mode, prestretch, limit)
    for limit in (50.0, 8.0, 5.0)
    for mode, prestretch in (
        ("equibiaxial", 1.0),
        ("equibiaxial", 1.2),
        ("equibiaxial", 1.5),
        ("radial", 1.2),
        ("radial", 1.5),
    )
]
BETWEEN = 20
"""Heights at which a fit is compared, between 2 and 97 % of its reach."""
LEAST = 0.05
SHARE = 0.95
"""Of the voltage at which the membrane pulls in."""
WEAK = 0.01
"""Share of the force without voltage, below which an error is told over that and not over the force."""


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


def fits(films: list[tuple[str, float, float]]) -> None:
    """Prints the errors of fitted films at heights and voltages between those fitted."""
    print("pre-stretch, limit: largest error of the force over (force + 2 %), over the force, and of a weak force over")
    print("that without voltage; of the pull-in voltage; as the film states its own; seconds")
    for mode, prestretch, limit in films:
        model = ConeModel(prestretch=prestretch, prestretch_mode=mode, stretch_limit=limit)
        begin = time.process_time()
        film = fit_film(model, 0.2)
        seconds = time.process_time() - begin
        own = mesh_film(
            model.replace(spring_stiffness=0.0),
            0.2,
            2 * (LOOSE_ELEMENTS if mode == "radial" else ELEMENTS),
            relaxed=True,
        )
        highest = slack_limit(own.model)
        highest = highest if highest < NEVER else SEARCHED / float(own.coefficients["G"])
        heights = np.unique(np.maximum(np.geomspace(0.02, 0.97, BETWEEN) * film.largest, LEAST))
        worst, pull_in = np.zeros(3), 0.0
        for x, start in raised_film(own, heights.tolist()).items():
            if start.force < WEAKEST * x:
                continue  # the net that holds slack rings is felt
            near = min(highest, slack_squared(own, x), 1.2 * float(film.highest_squared_at(x * x)))
            found = charged(own, start, highest, near / 12.0)
            if found.ending == Ending.PULLED_IN:
                highest = found.end
                pull_in = max(pull_in, abs(float(np.sqrt(film.highest_squared_at(x * x) / found.end)) - 1.0))
            end = found.end * (1.0 if found.ending == Ending.SLACK else SHARE**2)
            points = [point for point in found.points if point.squared <= end]
            force = np.array([point.force for point in points])
            off = np.abs(x * film.pull(x * x, np.array([point.squared for point in points])) - force)
            weak = force < WEAK * start.force
            errors = off / (force + FLOOR * start.force), (off / force)[~weak], (off / start.force)[weak]
            worst = np.maximum(worst, [np.max(values, initial=0.0) for values in errors])
        told = ", ".join(f"{name} {error:.2%}" for name, error in film.errors)
        print(
            f"{mode} {prestretch:g}, {limit:g}: {worst[0]:.2%}, {worst[1]:.2%}, {worst[2]:.3%}; {pull_in:.2%}; "
            f"{told}; {seconds:.0f} s",
            flush=True,
        )


if __name__ == "__main__":
    if sys.argv[1:2] == ["fit"]:
        one = sys.argv[2:]
        fits([(one[0], float(one[1]), float(one[2]))] if one else FITTED)
    else:
        main()

"""The three pictures of docs/branches.md.

python docs/branches.py
"""

from pathlib import Path

import numpy as np

import gelcone
from gelcone.plots.style import save_figure
from gelcone.presets import find_preset

HERE = Path(__file__).parent


def main() -> None:
    """Computes and draws them."""
    base = find_preset("base").model
    cascade = gelcone.continue_branch(base, "voltage", 0.92, 1.04, switch=4)
    save_figure(gelcone.plot(cascade), HERE / "branches-cascade.png", force=True)
    spring = find_preset("spring").model.replace(damping_ratio=0.01)
    response = gelcone.frequency(spring, np.linspace(0.4, 1.1, 57), branches=True)
    save_figure(gelcone.plot(response), HERE / "branches-frequency.png", force=True)
    folds = gelcone.locus(base, "fold", {"voltage": (0.95, 1.5), "drive_frequency": (0.07, 0.13)}, switch=0)
    save_figure(gelcone.plot(folds), HERE / "branches-locus.png", force=True)


if __name__ == "__main__":
    main()

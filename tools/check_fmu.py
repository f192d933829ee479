"""Whether an FMU gives on this machine what it gave where it was made: ``write`` a motion, then ``compare`` with it.

    python tools/check_fmu.py write pump.fmu motion.csv
    python tools/check_fmu.py compare pump.fmu motion.csv

It needs FMPy and NumPy, and not gelcone.
"""

from __future__ import annotations

import sys

import numpy as np
from fmpy import simulate_fmu
from fmpy.validation import validate_fmu

CLOSE = 1e-12
"""Share of the range to which two machines agree."""


def motion(path: str) -> np.ndarray:
    """Time and displacement under 900 V switched on at once."""
    options = {"start_values": {"voltage": 900.0}, "stop_time": 0.3, "output_interval": 2e-3}
    found = simulate_fmu(path, fmi_type="CoSimulation", output=["displacement"], **options)
    return np.column_stack([found["time"], found["displacement"]])


def main() -> None:
    what, path, place = sys.argv[1:]
    if problems := validate_fmu(path):
        sys.exit("\n".join(problems))
    found = motion(path)
    if what == "write":
        np.savetxt(place, found, delimiter=",", fmt="%.17g")
        return
    right = np.loadtxt(place, delimiter=",")
    if found.shape != right.shape:
        sys.exit(f"{path}: {len(found)} samples here, {len(right)} there")
    apart = np.abs(found - right).max(axis=0) / np.ptp(right, axis=0)
    print(f"{path}: displacements differ by {apart[1]:.1e} of their range")
    if not apart[1] <= CLOSE:
        sys.exit(1)


if __name__ == "__main__":
    main()

"""At which frequencies does a voltage shake a flat film out of rest? The tongues of parametric resonance."""

import numpy as np

import gelcone

model = gelcone.ConeModel(damping_ratio=0.05, spring_stiffness=0.5, drive_frequency=0.5)
found = gelcone.tongues(model, np.linspace(0.3, 1.2, 46), np.linspace(0.1, 1.2, 23))
figure = found.gelcone.plot()

lowest = float(found.onset_voltage.min())
at = float(found.drive_frequency[found.onset_voltage.values.argmin()])
print(f"lowest onset {lowest:.4f} at the frequency {at:.2f}")

assert abs(at - np.sqrt(0.5 - 0.5 * lowest**2)) < 0.03  # the natural frequency under the mean square voltage

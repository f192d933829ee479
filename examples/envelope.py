"""How high may a pump be driven, what does it yield there, and which linear system does a controller see?"""

import numpy as np
from scipy import signal

import gelcone

device = gelcone.find_device("biased-pump").replace(film="taut")
shown = gelcone.envelope(device, peaks=[1100.0, 2000.0, 2900.0], frequencies=[8.0, 10.0])
figure = shown.gelcone.plot()
columns = ("drive_frequency", "recommended_peak", "window_stroke", "window_power")
for frequency, peak, stroke, power in zip(*(shown[name].values for name in columns), strict=True):
    print(f"{frequency:.0f} Hz: up to {peak:.0f} V, stroke {stroke:.1f} mm, mean power supplied {power:.2f} mW")

# about the bias of 790 V, in metres, seconds and volts; python-control takes it as control.ss(*...)
system = signal.StateSpace(*gelcone.state_space(device))
time, height = signal.step(system, T=np.linspace(0.0, 12.0, 6001))
natural = float(np.abs(np.linalg.eigvals(system.A)[0])) / (2.0 * np.pi)
print(f"natural frequency {natural:.2f} Hz; 10 V more lift the disc by {1e4 * height[-1]:.4f} mm")

lifted = 1e-3 * float(np.diff(gelcone.stroke_and_blocked_force(device, [785.0, 795.0])["displacement"])[0])
assert abs(float(shown["recommended_peak"][1]) - 1510.0) < 5.0
assert abs(10.0 * height[-1] / lifted - 1.0) < 1e-3

"""How high may a pump be driven, what does it yield there, and which linear system does a controller see?"""

import numpy as np
from scipy import signal

import gelcone

device = gelcone.find_device("biased-pump")
safe = gelcone.envelope(
    device.to_model(),
    peaks=np.array([1000.0, 1800.0, 2600.0]) / device.scales.voltage,
    frequencies=np.array([8.0, 10.0]) / device.scales.frequency,
)
shown = gelcone.to_si(safe, device)
columns = ("drive_frequency", "recommended_peak", "window_stroke", "window_power")
for frequency, peak, stroke, power in zip(*(shown[name].values for name in columns), strict=True):
    print(f"{frequency:.0f} Hz: up to {peak:.0f} V, stroke {stroke:.1f} mm, mean power {power:.2f} mW")

# about the bias of 1 kV, in metres, seconds and volts; python-control takes it as control.ss(*...)
system = signal.StateSpace(*gelcone.state_space(device.to_model(), device))
time, height = signal.step(system, T=np.linspace(0.0, 12.0, 6001))
natural = float(np.abs(np.linalg.eigvals(system.A)[0])) / (2.0 * np.pi)
print(f"natural frequency {natural:.2f} Hz; 10 V more lift the disc by {1e4 * height[-1]:.4f} mm")

model = device.to_model()
volts = np.array([995.0, 1005.0]) / device.scales.voltage
lifted = float(np.diff(gelcone.stroke_and_blocked_force(model, volts)["displacement"])[0]) * device.scales.length
assert abs(float(shown["recommended_peak"][1]) - 1690.0) < 5.0
assert abs(10.0 * height[-1] / lifted - 1.0) < 1e-3

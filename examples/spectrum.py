"""Which frequencies are in the motion? The lines of a settled response, over the frequency of the drive."""

import gelcone

model = gelcone.ConeModel(voltage=0.3, voltage_bias=0.6, rest_height=0.8, hoop_prestretch=1.4, drive_frequency=0.7)
lines = gelcone.spectrum(model)
figure = lines.gelcone.plot()

ratios = lines.line_frequency.values[:3] / 0.7
print("lines at", ", ".join(f"{ratio:.4f}" for ratio in ratios), "times the drive's frequency, the strongest first")

assert abs(ratios - ratios.round()).max() < 1e-3

"""What do tolerances do to a stroke? Quantiles and sensitivities from drawn damping and pre-stretch."""

import gelcone

model = gelcone.ConeModel(voltage=0.2, voltage_bias=0.6, rest_height=0.8, hoop_prestretch=1.4)
uncertain = {"damping_ratio": gelcone.Normal(0.05, 0.01), "hoop_prestretch": gelcone.Normal(1.4, 0.03)}
draws = gelcone.draw(uncertain, 32, indices=True)
cells = gelcone.sweep(gelcone.Plan(model, {"drive_frequency": [1.0, 1.2, 1.4, 1.6]}, draws=draws))
found = gelcone.tolerances(cells)
figure = found.gelcone.plot()

middle = found.stroke.sel(quantile=0.5).values
print("median stroke", ", ".join(f"{value:.3f}" for value in middle))

assert middle.argmax() == 2  # resonance is near 1.4

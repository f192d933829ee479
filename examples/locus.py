"""Over which voltages and frequencies do two motions coexist? The folds of a biased cone in two parameters."""

import gelcone

model = gelcone.ConeModel(
    damping_ratio=0.01, voltage=0.06, voltage_bias=0.6, rest_height=0.8, hoop_prestretch=1.4, law="neo-hookean"
)
curves = gelcone.locus(model, "fold", {"drive_frequency": (1.39, 1.44), "voltage": (0.03, 0.08)}, checks=2)
figure = curves.gelcone.plot()

cusps = curves.event_second.values
print(f"{curves.sizes['curve']} curves of folds; cusps at the voltages {cusps.round(4).tolist()}")

assert curves.sizes["curve"] >= 1

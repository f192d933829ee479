"""What kind of motion is it? The same actuator at two voltages, with the largest Lyapunov exponent and its error."""

import gelcone

model = gelcone.ConeModel(damping_ratio=0.05, spring_stiffness=0.5, drive_frequency=0.3, voltage=[0.9, 1.9])
found = gelcone.regime(model, budget=4000.0)
figure = found.gelcone.plot()

for k, voltage in enumerate(model.voltage):
    kind = gelcone.Regime(int(found.regime[k]))
    exponent, error = float(found.lyapunov[k, 0]), float(found.standard_error[k, 0])
    print(f"voltage {voltage}: {kind.label}, largest exponent {exponent:+.4f} +- {error:.4f} per unit time")

assert [gelcone.Regime(int(code)).label for code in found.regime] == ["periodic", "chaotic"]

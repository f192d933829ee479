"""How does the disc answer a step of the voltage? Rise, overshoot and settling time, at three voltages."""

import gelcone

model = gelcone.ConeModel(rest_height=0.8, hoop_prestretch=1.4, damping_ratio=0.1)
answer = gelcone.step(model, [0.4, 0.6, 0.8])
figure = answer.gelcone.plot()

print("overshoot", ", ".join(f"{value:.2f}" for value in answer.overshoot.values))

assert all(0.6 < value < 0.9 for value in answer.overshoot.values)  # exp(-pi zeta) at small steps

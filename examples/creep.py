"""Does a gel that creeps keep its stroke? A constant voltage on a cone with one Maxwell branch."""

import gelcone

gel = {"viscous_modulus_1": 0.5, "relaxation_time_1": 40.0}
model = gelcone.ConeModel(rest_height=0.8, hoop_prestretch=1.4, damping_ratio=0.3, **gel)
answer = gelcone.step(model, [0.8], duration=200.0)
figure = answer.gelcone.plot()

begin, end = answer.initial_displacement.values.item(), answer.final_displacement.values.item()
print(f"from {begin:.4f} to {end:.4f}, where a slow ramp leads to {answer.equilibrium_displacement.item():.4f}")

assert abs(end - answer.equilibrium_displacement.item()) < 5e-3

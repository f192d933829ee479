"""How does chaos begin? Branches of periodic orbits whose period doubles again and again, at shrinking distances."""

import gelcone
from gelcone.presets import find_preset

preset = find_preset("fast")
branches = gelcone.continue_branch(preset.model, "voltage", 0.96, 1.045, start="settled", switch=3, checks=2)
figure = branches.gelcone.plot()

doublings = sorted(float(value) for value in branches.event_value.values)[:4]
print("period doublings at", ", ".join(f"{value:.7f}" for value in doublings))

assert abs(doublings[0] - 0.9764654866) < 1e-9
assert abs(doublings[1] - 1.0323903437) < 1e-9

"""How far does a pump stroke? A device that ships, at another frequency, in millimetres."""

import gelcone

device = gelcone.find_device("biased-pump").replace(frequency="9 Hz")
response = gelcone.simulate(device.to_model(), device.initial_state(), periods=60)
shown = gelcone.to_si(response, device)

height = shown.displacement[-500:]  # the last periods, after it has settled
stroke = float(height.max() - height.min())
power = float(shown.dissipated_power[-500:].mean())
print(f"stroke {stroke:.2f} {height.units}, {power:.3f} {shown.dissipated_power.units} into the damper")

assert abs(stroke - 7.7) < 0.05

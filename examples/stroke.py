"""How far does a pump stroke? A device that ships, at another frequency, in millimetres."""

import gelcone

device = gelcone.find_device("biased-pump").replace(frequency="9 Hz")
shown = gelcone.simulate(device, periods=60)
figure = shown.gelcone.plot()

height = shown.displacement[-500:]  # the last periods, after it has settled
stroke = float(height.max() - height.min())
power = float(shown.dissipated_power[-500:].mean())
print(f"stroke {stroke:.2f} {height.units}, {power:.3f} {shown.dissipated_power.units} into the damper")

assert abs(stroke - 3.02) < 0.02

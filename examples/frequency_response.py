"""Where is the resonance of a pump at a small drive? Stroke over frequency, swept up and down."""

import gelcone

device = gelcone.find_device("biased-pump").replace(film="taut", voltage_amplitude="50 V")
response = gelcone.frequency(device, [f"{9 + 0.25 * k} Hz" for k in range(13)])
figure = response.gelcone.plot()

up = response.stroke.sel(branch="up")
peak = float(up.drive_frequency[up.values.argmax()])
print(f"largest stroke {float(up.max()):.2f} {up.units} at {peak:.2f} Hz")

assert 9.5 < peak < 11.5

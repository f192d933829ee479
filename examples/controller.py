"""How does a controller hold the disc of a pump where it is wanted? A PI controller around the pump's FMU."""

import tempfile
from pathlib import Path

import fmpy
import numpy as np
from fmpy.fmi2 import FMU2Slave
from matplotlib.figure import Figure

import gelcone

device = gelcone.find_device("biased-pump").replace(film="taut")
folder = Path(tempfile.mkdtemp())
(path,) = gelcone.export(device, folder / "pump.fmu")
description = fmpy.read_model_description(str(path))
reference = {variable.name: variable.valueReference for variable in description.modelVariables}
place = fmpy.extract(str(path), str(folder / "pump"))
pump = FMU2Slave(guid=description.guid, unzipDirectory=place, modelIdentifier="pump", instanceName="pump")
pump.instantiate()
pump.setupExperiment()
pump.enterInitializationMode()
pump.exitInitializationMode()
# the force goes with the squared voltage: its integral and a proportional part, in V^2 per metre
step, integral, wanted, heights = 1e-3, 0.0, 13e-3, []
for k in range(10000):
    height = pump.getReal([reference["displacement"]])[0]
    error = wanted - height
    integral = np.clip(integral + 1e9 * error * step, 0.0, 1.6e6)
    pump.setReal([reference["voltage"]], [np.sqrt(np.clip(integral + 2e6 * error, 0.0, 1.6e6))])
    pump.doStep(currentCommunicationPoint=k * step, communicationStepSize=step)
    heights.append(height)
pump.terminate()
pump.freeInstance()
figure = Figure(figsize=(7.0, 3.0))
figure.subplots().plot(1e3 * np.array(heights))

print(f"from {1e3 * heights[0]:.2f} mm to {1e3 * heights[-1]:.4f} mm, wanted {1e3 * wanted:.1f} mm")
assert abs(heights[-1] - wanted) < 2e-6

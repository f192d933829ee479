"""How does a run end when the film pulls in? At a voltage that a homogeneous film that wrinkles cannot bear."""

import gelcone

model = gelcone.ConeModel(film="wrinkling", voltage=1.04, spring_stiffness=0.9, drive_frequency=0.1, damping_ratio=0.01)
run = gelcone.simulate(model)
figure = run.gelcone.plot()

print(f"{gelcone.Outcome(int(run.outcome)).label} at time {float(run.pull_in_time):.4f}")

assert int(run.outcome) == gelcone.Outcome.PULLED_IN
assert abs(float(run.pull_in_time) - 7.2728) < 1e-4

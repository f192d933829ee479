"""Can a controller be learned? The cross-entropy method on a linear policy, 1,024 different pumps at once."""

import numpy as np

import gelcone

device = gelcone.find_device("biased-pump").replace(film="taut")
uncertain = {"film_thickness": gelcone.Uniform("0.19 mm", "0.21 mm"), "moving_mass": gelcone.Normal("5 g", "0.2 g")}
candidates, each, steps = 64, 16, 200
pumps = gelcone.environment(device, candidates * each, uncertain=uncertain, episode="0.2 s")


def run(policies, seed=0):
    """Mean reward of a step of each policy, and the errors of the height at the end, m."""
    seen, _ = pumps.reset(seed=seed)
    total = np.zeros(len(policies))
    for _ in range(steps):
        seen_by = np.concatenate([seen[:, :3], np.ones((len(seen), 1))], axis=1).reshape(len(policies), -1, 4)
        actions = np.clip(np.einsum("pmk,pk->pm", seen_by, policies), -1.0, 1.0)
        seen, reward, *_ = pumps.step(actions.reshape(-1, 1))
        total += reward.reshape(len(policies), -1).mean(axis=1)
    return total / steps, np.abs(pumps.episodes.displacement - pumps.episodes.target)


rng = np.random.default_rng(0)
mean, spread = np.zeros(4), np.full(4, 2.0)
for _ in range(15):
    policies = mean + spread * rng.normal(size=(candidates, 4))
    best = policies[np.argsort(run(policies)[0])[-8:]]
    mean, spread = best.mean(axis=0), best.std(axis=0) + 0.02

before, after = run(np.zeros((1, 4)), seed=1), run(mean[None], seed=1)  # other pumps and heights
print(f"policy {mean.round(2)}: mean reward of a step {before[0][0]:.3f} before, {after[0][0]:.3f} after")
errors = [1e6 * np.median(found[1]) for found in (before, after)]
print(f"error of the height at the end: {errors[0]:.0f} um before, {errors[1]:.0f} um after")
assert errors[1] < 0.25 * errors[0]

"""Every id for many random steps: nothing is ever NaN or out of its range."""

import gymnasium
import numpy as np
import pytest

from regionslam_env.registration import ENVIRONMENTS
from regionslam_env.tasks.metrics import ALWAYS, METRICS, RANGES

EPISODE = 250


def check_metrics(info):
    """Every metric is there, and None or finite and in its range."""
    assert set(METRICS) <= set(info)
    for name, (low, high) in RANGES.items():
        value = info[name]
        assert value is None or (np.isfinite(value) and low <= value <= high), f"{name} is {value}"
    assert not any(info[name] is None for name in ALWAYS)


@pytest.mark.compiled
@pytest.mark.parametrize(
    ("steps", "dynamics"),
    [(1_500, None), *(pytest.param(10_000, what, marks=pytest.mark.slow) for what in (None, "all"))],
)
@pytest.mark.parametrize("env_id", tuple(ENVIRONMENTS))
def test_random_steps_stay_finite_and_metrics_in_their_range(env_id, steps, dynamics):
    env = gymnasium.make(env_id, max_steps=EPISODE, dynamics=dynamics)
    rng = np.random.default_rng(0)
    env.reset(seed=0)
    episodes = 0
    for step in range(steps):
        action = rng.uniform(-1, 1, env.action_space.shape).astype(np.float32)
        action[2:] = 1 if rng.random() < 0.002 else -1
        observation, reward, terminated, truncated, info = env.step(action)
        assert np.isfinite(reward) and all(np.isfinite(value).all() for value in observation.values())
        assert step % 50 or observation in env.observation_space
        if terminated or truncated:
            check_metrics(info)
            env.reset(options={"keep_map": True} if episodes % 2 else None)
            episodes += 1
    assert episodes >= steps // EPISODE

"""Every id for 10,000 random steps."""

import gymnasium
import numpy as np
import pytest

from regionslam_env.registration import ENVIRONMENTS
from regionslam_env.tasks.metrics import METRICS

SHARES = (
    *("spl", "soft_spl", "belief_spl", "region_precision", "region_recall", "region_iou", "type_accuracy", "link_f1"),
    *("explored", "closed_edges"),
)
LENGTHS = ("distance_to_goal", "path_length", "collisions", "ape_rmse", "ape_max", "ape_end", "pose_nees")


@pytest.mark.slow
@pytest.mark.parametrize("env_id", tuple(ENVIRONMENTS))
def test_random_steps_stay_finite_and_metrics_in_their_range(env_id):
    env = gymnasium.make(env_id, max_steps=500)
    rng = np.random.default_rng(0)
    env.reset(seed=0)
    episodes = 0
    for step in range(10_000):
        action = rng.uniform(-1, 1, env.action_space.shape).astype(np.float32)
        action[2:] = 1 if rng.random() < 0.002 else -1
        observation, reward, terminated, truncated, info = env.step(action)
        assert np.isfinite(reward) and all(np.isfinite(value).all() for value in observation.values())
        assert step % 50 or observation in env.observation_space
        if terminated or truncated:
            assert set(METRICS) <= set(info)
            assert all(info[name] is None or 0 <= info[name] <= 1 for name in SHARES)
            assert all(info[name] is None or 0 <= info[name] < np.inf for name in LENGTHS)
            env.reset(options={"keep_map": True} if episodes % 2 else None)
            episodes += 1
    assert episodes >= 20

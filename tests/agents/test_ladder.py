"""What the filter is worth to an agent that has to find its way back."""

import gymnasium
import pytest

from agents.evaluate import evaluate, scripted_agent

SEEDS = 6


def success(env_id):
    env = gymnasium.make(env_id, max_steps=3000)
    results = evaluate(env, scripted_agent(env.unwrapped), SEEDS)
    return sum(result["success"] for result in results) / SEEDS


@pytest.mark.slow
def test_a_mission_out_and_back_fails_without_the_filter():
    assert success("RegionSLAM/Mission-v0") - success("RegionSLAM/Mission-Odometry-v0") >= 0.2

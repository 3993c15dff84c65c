from __future__ import annotations

import gymnasium
import numpy as np
import pytest
from gymnasium import spaces

from agents.progress import PATIENCE, Progress
from agents.scripted import CONFIRMATIONS, FIRST_LOOK, ScriptedAgent
from regionslam_env.config import SEMANTIC_TYPES, RobotConfig
from regionslam_env.observations import observation_space
from slam.rows import Row
from tests.agents.belief import SLOTS, Room, observe
from tests.control.room import box, clearance, move, scan

SPACE = observation_space(SLOTS, len(SEMANTIC_TYPES), RobotConfig(), 180, 10.0)
ROOM = Room("kitchen", Row.from_parameters(0, 0, 6, 6), contains_me=1.0)
WALLS = np.array(box(-3, -3, 3, 3), float)


def agent(components: int = 3) -> ScriptedAgent:
    return ScriptedAgent(SPACE, spaces.Box(-1, 1, (components,), np.float32))


def declared(*rooms: Room, pose: tuple[float, float, float] = (0, 0, 0), sigma: float = 0.05) -> int | None:
    """Return after how many steps the agent declares, None within 20 after the first look."""
    scripted = agent()
    lidar = scan(np.array(pose), WALLS)
    for step in range(FIRST_LOOK + 20):
        action = scripted.act(observe(pose, rooms, "kitchen", lidar, sigma))
        assert SPACE is not None and action.shape == (3,) and action.dtype == np.float32 and np.all(np.abs(action) <= 1)
        if action[2] > 0:
            return step + 1
    return None


def test_declares_when_surely_inside() -> None:
    assert declared(ROOM) == CONFIRMATIONS


@pytest.mark.parametrize(
    "room",
    [
        ROOM._replace(contains_me=0.9),
        ROOM._replace(existence=0.6),
        ROOM._replace(type_p=0.6),
        ROOM._replace(type="office"),
    ],
)
def test_declares_nothing_in_doubt(room: Room) -> None:
    assert declared(room) is None


def test_declares_nothing_just_across_the_edge() -> None:
    assert declared(ROOM, pose=(-2.8, 0, 0)) is None


def test_declares_nothing_when_lost() -> None:
    assert declared(ROOM, sigma=0.8) is None


def test_a_break_in_the_belief_starts_the_count_anew() -> None:
    scripted, lidar = agent(), scan(np.zeros(3), WALLS)
    doubts = {3}
    for step in range(3 + CONFIRMATIONS + 1):
        room = ROOM._replace(contains_me=0.5) if step in doubts else ROOM
        action = scripted.act(observe((0, 0, 0), [room], "kitchen", lidar))
        assert (action[2] > 0) == (step == 3 + CONFIRMATIONS)
    assert scripted.say() == "arrived in the kitchen"


def test_without_declaration_it_stays() -> None:
    scripted, pose = agent(2), np.zeros(3)
    for _ in range(FIRST_LOOK + 60):
        action = scripted.act(observe(tuple(pose), [ROOM], "kitchen", scan(pose, WALLS)))
        assert action.shape == (2,)
        pose = move(pose, action)
    assert np.hypot(*pose[:2]) < 2.0


def test_passes_a_door_into_the_room_it_looks_for() -> None:
    walls = np.array([*box(-6, -3, 6, 3), (0, -3, 0, -0.45), (0, 0.45, 0, 3)], float)
    office = Room("office", Row.from_parameters(-3, 0, 6, 6))
    kitchen = Room("kitchen", Row.from_parameters(3, 0, 6, 6))
    scripted, pose, rng = agent(), np.array([-4.0, -2.0, 2.0]), np.random.default_rng(0)
    for step in range(FIRST_LOOK + 150):
        inside = kitchen.row.contains(pose[None, :2])[0]
        rooms = [office, kitchen._replace(contains_me=float(inside))]
        action = scripted.act(observe(tuple(pose), rooms, "kitchen", scan(pose, walls, rng.normal(0, 0.02, 180))))
        if action[2] > 0:
            break
        moving = ("driving to the kitchen", "looking for the way to the kitchen")
        assert scripted.say() in (("taking a first look",) if step < FIRST_LOOK else moving)
        pose = move(pose, action.astype(float))
        assert clearance(pose[:2], walls) > 0.25
    assert action[2] > 0 and pose[0] > 0.4


@pytest.mark.parametrize("components", [2, 3])
def test_explores_until_nothing_is_left_to_be_seen(components: int) -> None:
    walls = np.array([*box(-6, -3, 6, 3), (0, -3, 0, -0.45), (0, 0.45, 0, 3)], float)
    office = Room("office", Row.from_parameters(-3, 0, 6, 6), visited=True, contains_me=1.0)
    kitchen = Row.from_parameters(3, 0, 6, 6)
    scripted, pose, entered = agent(components), np.array([-4.0, -2.0, 2.0]), False
    for _ in range(FIRST_LOOK + 600):
        entered = entered or bool(kitchen.contains(pose[None, :2])[0])
        rooms = [office, Room("kitchen", kitchen, visited=True)] if entered else [office]
        action = scripted.act(observe(tuple(pose), rooms, "", scan(pose, walls)))
        if components == 3 and action[2] > 0:
            break
        pose = move(pose, action.astype(float))
    assert entered and scripted.say() == ("done exploring" if components == 3 else "looking around")


def test_same_observations_same_actions() -> None:
    one, two = agent(), agent()
    two.act(observe((5, 5, 1), [], "office"))
    two.reset()
    pose = np.array([0.5, 0.5, 0.3])
    for _ in range(FIRST_LOOK + 20):
        observation = observe(tuple(pose), [ROOM._replace(type="office")], "kitchen", scan(pose, WALLS))
        action = one.act(observation)
        assert np.array_equal(action, two.act(observation))
        pose = move(pose, action.astype(float))


def test_other_types_than_the_observation_has_are_refused() -> None:
    with pytest.raises(ValueError, match=rf"2 names.*{len(SEMANTIC_TYPES)}"):
        ScriptedAgent(SPACE, spaces.Box(-1, 1, (2,)), ["hallway", "office"])


def test_progress_backs_off_first_and_then_gives_up() -> None:
    progress = Progress()
    assert not any(progress.stuck(5.0 - 0.1 * k, False) for k in range(3 * PATIENCE // 2))
    assert not progress.recovering
    progress.restart()
    assert not any(progress.stuck(5.0, False) for _ in range(PATIENCE + 1))
    assert progress.recovering
    assert any(progress.stuck(5.0, False) for _ in range(PATIENCE + 1))


def test_progress_gives_up_at_once_beside_the_target() -> None:
    progress = Progress()
    assert any(progress.stuck(0.5, False) for _ in range(PATIENCE + 1))
    progress.restart()
    assert any(progress.stuck(0.5, True) for _ in range(PATIENCE // 3 + 1))


@pytest.mark.slow
@pytest.mark.parametrize("goal", ["hallway", "kitchen", "meeting room"])
def test_succeeds_in_the_institute(goal: str) -> None:
    distance = 2.0 if goal == "hallway" else 20.0
    env = gymnasium.make("RegionSLAM/GoTo-Declare-v0", goal=goal, start_distance=distance, max_steps=6000)
    base = env.unwrapped
    for seed in range(2):
        observation, _ = env.reset(seed=seed)
        scripted = ScriptedAgent(base.observation_space, base.action_space, base.semantic_types, base.robot)
        ended = False
        while not ended:
            observation, _, terminated, truncated, info = env.step(scripted.act(observation))
            ended = terminated or truncated
        assert info["success"] and not info["false_arrival"]
        assert info["collisions"] == 0


@pytest.mark.slow
def test_maps_the_institute() -> None:
    env = gymnasium.make("RegionSLAM/Explore-v0")
    base = env.unwrapped
    observation, _ = env.reset(seed=0)
    scripted = ScriptedAgent(base.observation_space, base.action_space, base.semantic_types, base.robot)
    ended, total = False, 0.0
    while not ended:
        observation, reward, terminated, truncated, info = env.step(scripted.act(observation))
        ended, total = terminated or truncated, total + reward
    assert info["success"] and info["explored"] >= 0.9 and info["collisions"] == 0
    assert 20 < total < 40

"""Simulations in which things move, for exact assertions."""

from __future__ import annotations

import numpy as np

from regionslam_env.config import DynamicsConfig, RobotConfig
from regionslam_env.simulation.dynamic import DynamicSimulation
from regionslam_env.simulation.movers import Movers
from regionslam_env.simulation.people import PERSON
from regionslam_env.worlds.world import World


def lively(world: World, start: tuple[float, float, float], seed: int = 0, **dynamics: float) -> DynamicSimulation:
    """Return a robot at a start among what moves, drawn by a seed."""
    robot = RobotConfig()
    movers = Movers(world, DynamicsConfig(**dynamics), robot)  # type: ignore[arg-type]
    simulation = DynamicSimulation(movers, robot)
    movers.draw(np.random.default_rng(seed), start[:2])
    simulation.reset(*start)
    return simulation


def put_people(simulation: DynamicSimulation, *ways: tuple[float, float, float, float]) -> None:
    """Replace everybody by people on straight ways from (x, y) to (x, y), and put the robot where it is."""
    people = simulation.movers.people
    people.records = np.zeros(len(ways), PERSON)
    people._routes = [[] for _ in ways]
    for person, (x, y, to_x, to_y) in zip(people.records, ways, strict=True):
        person["x"], person["y"], person["to_x"], person["to_y"] = x, y, to_x, to_y
        person["nearest"], person["patience"] = np.inf, 10**6
    simulation.movers.moved()
    simulation.reset(*simulation.pose)


def places(simulation: DynamicSimulation) -> np.ndarray:
    """Return where people are, shape (N, 2), m."""
    return simulation.movers.people.places

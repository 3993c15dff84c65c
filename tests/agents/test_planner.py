from __future__ import annotations

import numpy as np
import pytest

from agents.frontiers import DOORWAY, find_frontiers
from agents.planner import Planner, Target
from agents.terrain import Terrain
from slam.rows import Row
from tests.agents.belief import Room, view
from tests.control.room import scan

# A hallway along y = 0, 2 m wide, closed in the west (x = -4), going on in the east; an office to its north,
# x in [-2, 2], y in [1, 5], with a door at x in [-0.5, 0.5].
WALLS = np.array(
    [
        (-4, -1, 30, -1),
        (-4, -1, -4, 1),
        (-4, 1, -0.5, 1),
        (0.5, 1, 30, 1),
        (-2, 1, -2, 5),
        (2, 1, 2, 5),
        (-2, 5, 2, 5),
    ],
    float,
)
HALLWAY = Room("hallway", Row.from_parameters(2.0, 0, 12, 2), ("r",), visited=True, contains_me=1.0)
OFFICE = Room("office", Row.from_parameters(0, 3, 4, 4))
START = (-3.0, 0.0, 0.0)


def terrain_from(*poses: tuple[float, float, float]) -> Terrain:
    terrain = Terrain(180, 10.0, 7.0, 0.25)
    for pose in poses:
        terrain.insert(np.array(pose), scan(np.array(pose), WALLS))
    return terrain


def test_frontiers_are_the_end_of_the_hallway_and_the_door_never_passed() -> None:
    terrain = terrain_from(START)
    frontiers = find_frontiers(terrain, view(START, [HALLWAY], "kitchen"))
    end = max(frontiers, key=lambda f: f.size)
    assert end.place == "the end of the hallway"
    assert end.point == pytest.approx((4.0, 0.0), abs=0.4)
    assert end.way == pytest.approx(7.0, rel=0.2)
    assert end.worth == 0
    assert any(np.hypot(*(f.point - (0.0, 1.1))) < 0.8 for f in frontiers)


def test_what_is_left_of_a_known_room_is_worth_less() -> None:
    terrain = terrain_from(START, (0.0, 0.0, 0.0))
    seen = view((0.0, 0.0, 0.0), [HALLWAY, OFFICE], "kitchen")
    rest = [f for f in find_frontiers(terrain, seen) if f.place == "the rest of the office"]
    assert rest and all(f.worth >= 30 for f in rest)
    wanted = view((0.0, 0.0, 0.0), [HALLWAY, OFFICE], "office")
    assert any(f.worth < 0 for f in find_frontiers(terrain, wanted) if f.place == "the rest of the office")


def test_the_unseen_rest_of_an_open_room_leads_on_where_it_may_hide_a_door_or_nobody_was() -> None:
    terrain, here = terrain_from(START, (0.0, 0.0, 0.0)), (0.0, 0.0, 0.0)
    leads_on = {}
    for visited in (False, True):
        office = OFFICE._replace(open_edges=("t",), visited=visited)
        frontiers = find_frontiers(terrain, view(here, [HALLWAY, office], "kitchen"))
        leads_on[visited] = {(f.size >= DOORWAY, f.leads_on) for f in frontiers if f.place == "the rest of the office"}
    assert leads_on[False] and all(leads for _, leads in leads_on[False])
    assert leads_on[True] and all(leads == is_long for is_long, leads in leads_on[True])


def test_regions_are_remembered_after_their_eviction() -> None:
    terrain = terrain_from(START, (0.0, 0.0, 0.0))
    find_frontiers(terrain, view((0.0, 0.0, 0.0), [HALLWAY, OFFICE], "kitchen"))
    later = find_frontiers(terrain, view((0.0, 0.0, 0.0), [HALLWAY], "kitchen"))
    assert "the rest of the office" in {f.place for f in later}


def test_waits_before_a_shut_door_where_nothing_else_is_left() -> None:
    ends, shut = [(8, -1, 8, 1)], [(-0.5, 1.05, 0.5, 1.05)]
    poses = [(x, y, 0.0) for x in (-3.0, 0.0, 4.0) for y in (-0.5, 0.0, 0.5)]
    terrain = Terrain(180, 10.0, 7.0, 0.25)
    for pose in poses:
        terrain.insert(np.array(pose), scan(np.array(pose), np.array([*WALLS.tolist(), *ends, *shut])))
    hallway = HALLWAY._replace(row=Row.from_parameters(2.0, 0, 12, 2), open_edges=())
    door = Room("door", Row.from_parameters(0, 1.05, 1.0, 0.2))
    seen = view((4.0, 0.5, 0.0), [hallway, door], "kitchen")
    planner = Planner(terrain)
    target = planner.decide(seen)
    assert target is not None and target.kind == "door" and planner.leads_on
    assert target.point == pytest.approx((0.0, 0.45), abs=1e-6)
    assert not planner.resolved(target, view((0.0, 0.45, 0.0), [hallway, door], "kitchen"))
    planner.avoid(target, radius=0.4, for_good=True)
    given_up = planner.decide(seen)
    assert (given_up is None or given_up.kind != "door") and not planner.leads_on
    for _ in range(8):
        terrain.insert(np.array((0.0, 0.3, 1.6)), scan(np.array((0.0, 0.3, 1.6)), np.array([*WALLS.tolist(), *ends])))
    through = Planner(terrain).decide(seen)
    assert through is not None and through.kind == "explore" and through.point[1] > 1


def test_explores_while_no_goal_is_known() -> None:
    terrain = terrain_from(START, (0.0, 0.0, 0.0))
    target = Planner(terrain).decide(view((0.0, 0.0, 0.0), [HALLWAY, OFFICE], "kitchen"))
    assert target is not None and target.kind == "explore" and target.place == "the end of the hallway"


def test_goes_well_inside_a_goal_region() -> None:
    terrain = terrain_from(START, (0.0, 0.0, 0.0))
    target = Planner(terrain).decide(view((0.0, 0.0, 0.0), [HALLWAY, OFFICE], "office"))
    assert target is not None and target.kind == "goal" and target.place == "the office"
    assert target.point[1] > 1.5 and abs(target.point[0]) < 1.45


def test_doubtful_regions_are_no_goals() -> None:
    terrain = terrain_from(START, (0.0, 0.0, 0.0))
    for doubt in (OFFICE._replace(existence=0.3), OFFICE._replace(type_p=0.3)):
        target = Planner(terrain).decide(view((0.0, 0.0, 0.0), [HALLWAY, doubt], "office"))
        assert target is not None and target.kind == "explore"


def test_approaches_a_goal_it_knows_no_way_into() -> None:
    terrain = terrain_from(START)
    far = Room("kitchen", Row.from_parameters(15, 3, 4, 4))
    target = Planner(terrain).decide(view(START, [HALLWAY, far], "kitchen"))
    assert target is not None and target.kind == "approach"
    assert target.point == pytest.approx((4.0, 0.0), abs=0.4)


def test_avoids_a_target_for_a_while() -> None:
    terrain = terrain_from(START, (0.0, 0.0, 0.0))
    planner, seen = Planner(terrain, patience=3), view((0.0, 0.0, 0.0), [HALLWAY, OFFICE], "kitchen")
    first = planner.decide(seen)
    assert first is not None
    planner.avoid(first)
    second = planner.decide(seen)
    assert second is not None and np.hypot(*(second.point - first.point)) > 0.8
    for _ in range(3):
        again = planner.decide(seen)
    assert again is not None and again.point == pytest.approx(first.point)


def test_a_frontier_is_resolved_once_seen_through() -> None:
    terrain = terrain_from(START)
    planner, target = Planner(terrain), Target(np.array([4.0, 0.0]), "explore", "the end of the hallway")
    seen = view(START, [HALLWAY], "kitchen")
    assert not planner.resolved(target, seen)
    terrain.insert(np.array([0.0, 0.0, 0.0]), scan(np.array([0.0, 0.0, 0.0]), WALLS))
    assert planner.resolved(target, seen)
    assert planner.resolved(Target(np.array(START[:2]), "explore", "here"), seen)


def test_visits_believed_rooms_once_no_frontier_is_left() -> None:
    terrain = Terrain(180, 10.0, 7.0, 0.25)
    closed = np.array([(-2, -2, 2, -2), (2, -2, 2, 2), (2, 2, -2, 2), (-2, 2, -2, -2)], float)
    terrain.insert(np.zeros(3), scan(np.zeros(3), closed))
    here = Room("office", Row.from_parameters(0, 0, 4, 4), visited=True)
    target = Planner(terrain).decide(view((0, 0, 0), [here, OFFICE._replace(type="storage")], "kitchen"))
    assert target is not None and target.place == "the storage"
    assert Planner(terrain).decide(view((0, 0, 0), [here], "kitchen")) is None

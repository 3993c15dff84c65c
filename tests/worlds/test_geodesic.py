import itertools

import numpy as np
import pytest

from regionslam_env.errors import WorldError
from regionslam_env.worlds.clearance import exact_clearance, rolls_straight
from regionslam_env.worlds.flooding import foot
from regionslam_env.worlds.floorplan import Opening, assemble
from regionslam_env.worlds.geodesic import Geodesic
from regionslam_env.worlds.reachability import unreachable
from regionslam_env.worlds.world import Region, World
from slam.rows import Row
from tests.floors import bent_hallway, furnished_room, long_hallway, single_room, two_rooms


def rooms_in_a_row(*widths, doors, height=4.0):
    """Return rooms beside each other with doors of 1 m at given heights in the walls between them."""
    edges = np.cumsum([0, *widths])
    rooms = [
        Region(f"room {i}", "office", "", Row.from_parameters((a + b) / 2, height / 2, b - a, height))
        for i, (a, b) in enumerate(itertools.pairwise(edges))
    ]
    openings = [
        Opening(f"door {i}", (f"room {i}", f"room {i + 1}"), x, y - 0.5, x, y + 0.5)
        for i, (x, y) in enumerate(zip(edges[1:-1], doors, strict=True))
        if y is not None
    ]
    return assemble("row", rooms, openings)


def around(start, circle, radius, end, long_way=False):
    """Return the length of a string from start around a circle to end; `long_way` by more than half a turn."""
    start, circle, end = map(np.asarray, (start, circle, end))
    total = 0.0
    angles = []
    for point in (start, end):
        offset = point - circle
        distance = np.hypot(*offset)
        total += np.sqrt(distance**2 - radius**2)
        angles.append((np.arctan2(offset[1], offset[0]), np.arccos(radius / distance)))
    between = abs((angles[0][0] - angles[1][0] + np.pi) % (2 * np.pi) - np.pi)
    between = 2 * np.pi - between if long_way else between
    return total + radius * (between - angles[0][1] - angles[1][1])


def test_clearance_is_exact():
    geodesic = Geodesic(furnished_room(), 0.2)
    assert geodesic.clearance(-2, 0) == pytest.approx(1 - 0.05 - 0.2)  # of the wall at x = -3
    assert geodesic.clearance(0, 0) == pytest.approx(0.5 - 0.2)  # of the desk
    assert geodesic.clearance(1, 0) == pytest.approx(-0.5 - 0.2)  # inside it
    assert geodesic.clearance(0.2, 0.9) == pytest.approx(0.5 - 0.2)  # of its corner
    assert geodesic.free(0, 0) and not geodesic.free(0.31, 0)
    assert geodesic.free(0, 0, margin=0.29) and not geodesic.free(0, 0, margin=0.31)


def test_the_grid_agrees_with_the_exact_clearance():
    geodesic = Geodesic(furnished_room(), 0.2)
    grid = geodesic.grid
    for i in range(0, grid.clearance.shape[0], 3):
        for j in range(0, grid.clearance.shape[1], 3):
            exact = exact_clearance(grid.x0 + i * grid.step, grid.y0 + j * grid.step, geodesic.shapes, 0.2)
            assert grid.clearance[i, j] == pytest.approx(min(exact, 1.0))


def test_a_free_straight_line_is_its_length():
    geodesic = Geodesic(two_rooms(), 0.2)
    assert geodesic.distance((2.0, 2.0), ["kitchen"]) == pytest.approx(4.0)
    assert geodesic.distance((2.0, 2.0), ["door"]) == pytest.approx(3.9)
    assert geodesic.distance((2.0, 2.0), [0]) == 0


def test_an_oblique_line_has_no_staircase():
    goal = Region("desk", "desk", "", Row.from_parameters(5, 3, 0.2, 0.2))
    world = World("w", (*long_hallway().regions, goal), np.array([(-9, -9, 15, -9), (-9, 9, 15, 9)]))
    assert Geodesic(world, 0.2).distance((-3.0, -1.0), ["desk"]) == pytest.approx(np.hypot(7.9, 3.9), rel=1e-3)


@pytest.mark.parametrize("start", [(1.0, 0.5), (3.0, 3.5), (5.5, 0.4), (4.0, 1.3)])
def test_the_way_through_a_door_bends_around_its_jamb(start):
    geodesic = Geodesic(two_rooms(), 0.2)
    x, y = start
    jamb = (6.0, 1.5) if y < 1.75 else (6.0, 2.5)
    tip = jamb[1] + (0.25 if y < 1.75 else -0.25)
    exact = around(start, jamb, 0.25, (6.0, tip))
    assert exact > np.hypot(6 - x, tip - y)  # the straight line cuts into the circle around the jamb
    assert geodesic.distance(start, ["kitchen"]) == pytest.approx(exact, rel=0.02)


def test_the_way_around_an_inner_corner_is_a_taut_string():
    world = bent_hallway()
    goal = Region("desk", "desk", "", Row.from_parameters(7, 4.6, 1.9, 0.2))
    world = World("w", (*world.regions, goal), world.walls)
    tangent = around((1.0, 0.0), (6.0, 1.0), 0.25, (6.25, 3.0), long_way=True)
    exact = tangent + 1.5  # rolls around the corner (6, 1), then straight up to y = 4.5
    assert Geodesic(world, 0.2).distance((1.0, 0.0), ["desk"]) == pytest.approx(exact, rel=0.01)


def test_the_way_around_a_desk_is_the_shorter_side():
    world = furnished_room()
    goal = Region("spot", "table", "", Row.from_parameters(2.7, 0.3, 0.2, 0.2))
    world = World("w", (*world.regions, goal), world.walls, obstacles=world.obstacles)
    geodesic = Geodesic(world, 0.2)
    over = around((0.0, 0.3), (0.5, 0.5), 0.2, (1.0, 0.7)) + around((1.0, 0.7), (1.5, 0.5), 0.2, (2.6, 0.4))
    assert geodesic.distance((0.0, 0.3), ["spot"]) == pytest.approx(over, rel=0.01)


def test_two_doors_far_apart_sum_up():
    world = rooms_in_a_row(4, 6, 4, doors=[1.0, 3.0])
    first = around((1.0, 3.5), (4.0, 1.5), 0.25, (4.2, 1.1))  # bounds from either side of the exact way
    distance = Geodesic(world, 0.2).distance((1.0, 3.5), ["room 2"])
    lower = np.hypot(3, 2.25) + np.hypot(6, 1.5)
    assert lower < distance < 1.02 * (first + np.hypot(6, 1.9) + 0.1)


def test_a_thicker_disc_goes_a_longer_way_or_none():
    world = two_rooms()
    ways = [Geodesic(world, radius).distance((5.0, 0.8), ["kitchen"]) for radius in (0.1, 0.2, 0.3)]
    assert ways == sorted(ways) and ways[0] < ways[2]
    assert Geodesic(world, 0.5).distance((5.0, 0.8), ["kitchen"]) == np.inf


def test_what_no_door_leads_to_is_unreachable():
    world = rooms_in_a_row(4, 4, 4, doors=[2.0, None])
    geodesic = Geodesic(world)
    assert geodesic.distance((1.0, 1.0), ["room 2"]) == np.inf
    assert geodesic.distance((1.0, 2.0), ["room 1", "room 2"]) == pytest.approx(3.0)
    assert unreachable(world) == ("room 2",)
    assert unreachable(rooms_in_a_row(4, 4, doors=[2.0])) == ()
    assert unreachable(rooms_in_a_row(4, 4, doors=[2.0]), radius=0.6) == ("room 1", "door 0")


def test_every_node_has_the_best_root_that_it_sees():
    world = rooms_in_a_row(3, 5, 3, doors=[0.9, 3.0])
    geodesic = Geodesic(world, 0.2)
    field = geodesic.field(["room 2"])
    grid, corners = geodesic.grid, geodesic.corners
    rng = np.random.default_rng(0)
    for i, j in rng.permutation(np.argwhere(grid.clearance >= 0))[:150]:
        x, y = grid.x0 + i * grid.step, grid.y0 + j * grid.step
        ways = []
        for point, beyond in zip(corners.points, field.roots.distance, strict=True):
            if rolls_straight(grid, x, y, point[0], point[1]):
                ways.append(beyond + np.hypot(*(point - (x, y))))
        fx, fy, straight = foot(field.roots.goals[0], x, y)
        if rolls_straight(grid, x, y, fx, fy):
            ways.append(straight)
        naive = min(ways, default=np.inf)
        assert field.nodes[i, j] == (naive if np.isinf(naive) else pytest.approx(naive, abs=0.03))


def test_a_path_is_as_long_as_the_distance_and_free():
    geodesic = Geodesic(rooms_in_a_row(3, 5, 3, doors=[0.9, 3.0]), 0.2)
    field = geodesic.field(["room 2"])
    path = field.path(0.6, 3.4)
    assert path[0].tolist() == [0.6, 3.4]
    assert np.hypot(*np.diff(path, axis=0).T).sum() == pytest.approx(field.at(0.6, 3.4))
    assert path[-1][0] == pytest.approx(8)
    for start, end in itertools.pairwise(path):
        for f in np.linspace(0, 1, 20):
            assert geodesic.clearance(*(start + f * (end - start))) > -0.03
    with pytest.raises(WorldError, match="no path"):
        field.path(50, 50)


def test_touching_a_wall_still_has_a_distance():
    geodesic = Geodesic(two_rooms(), 0.2)
    assert geodesic.distance((2.0, 0.22), ["kitchen"]) == pytest.approx(
        geodesic.distance((2.0, 0.26), ["kitchen"]), abs=0.1
    )


def test_fields_are_kept_and_goals_are_sets():
    geodesic = Geodesic(two_rooms())
    assert geodesic.field(["kitchen", 2]) is geodesic.field([2, "kitchen", 1])


def test_unknown_goals_are_named():
    geodesic = Geodesic(two_rooms())
    with pytest.raises(WorldError, match="did you mean 'kitchen'"):
        geodesic.distance((1, 1), ["kitchn"])
    with pytest.raises(WorldError, match="region index 9: expected 0 to 2"):
        geodesic.distance((1, 1), [9])


def test_samples_are_free_inside_and_as_far_as_asked():
    geodesic = Geodesic(two_rooms(), 0.2)
    field = geodesic.field(["kitchen"])
    rng = np.random.default_rng(5)
    points = [geodesic.sample_free(rng, field, at_least=2.0, at_most=4.0, margin=0.1) for _ in range(60)]
    for x, y in points:
        assert geodesic.clearance(x, y) >= 0.1
        assert 2.0 <= field.at(x, y) <= 4.0
    assert np.ptp([y for _, y in points]) > 2
    again = np.random.default_rng(5)
    assert [geodesic.sample_free(again, field, at_least=2.0, at_most=4.0, margin=0.1) for _ in range(60)] == points
    assert all(x > 6 for x, _ in (geodesic.sample_free(rng, regions=["kitchen"]) for _ in range(20)))


def test_no_sample_is_an_error():
    geodesic = Geodesic(single_room(), 0.2)
    with pytest.raises(WorldError, match="no free place between 5 and inf m"):
        geodesic.sample_free(np.random.default_rng(0), geodesic.field(["office"]), at_least=5.0)


def test_a_route_is_as_long_as_the_distance_to_a_spot():
    world = bent_hallway()
    geodesic, tiny = Geodesic(world, 0.2), Row.from_parameters(7, 4, 1e-3, 1e-3)
    route = geodesic.route((0.5, 0.0), (7.0, 4.0))
    field = Geodesic(World("spot", (Region("spot", "office", "", tiny),), world.walls), 0.2).field(["spot"])
    assert np.hypot(*np.diff(route, axis=0).T).sum() == pytest.approx(field.at(0.5, 0.0), abs=2e-3)
    assert route[0] == pytest.approx((0.5, 0)) and route[-1] == pytest.approx((7, 4))
    for start, end in itertools.pairwise(route):
        assert rolls_straight(geodesic.grid, *start, *end)


def test_a_route_within_sight_is_straight_and_there_may_be_none():
    geodesic = Geodesic(bent_hallway(), 0.2)
    assert geodesic.route((0.5, 0.0), (5.0, 0.3)) == pytest.approx(np.array([(0.5, 0), (5, 0.3)]))
    assert Geodesic(two_rooms(), 0.48).route((3, 2), (9, 2)) is None

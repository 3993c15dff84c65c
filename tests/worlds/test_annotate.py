import numpy as np
import pytest
import shapely
from shapely.affinity import rotate, translate

from regionslam_env.errors import WorldError
from regionslam_env.worlds.annotate import annotate

BOX = shapely.box(1, 2, 6, 5)
BENT = shapely.Polygon([(0, 0), (10, 0), (10, 2), (2, 2), (2, 8), (0, 8)])
TEE = shapely.Polygon([(0, 0), (9, 0), (9, 2), (6, 2), (6, 7), (4, 7), (4, 2), (0, 2)])
ZED = shapely.Polygon([(0, 0), (4, 0), (4, 3), (8, 3), (8, 6), (3, 6), (3, 2), (0, 2)])
CROSS = shapely.Polygon(
    [(2, 0), (4, 0), (4, 2), (9, 2), (9, 4), (4, 4), (4, 5), (2, 5), (2, 4), (0, 4), (0, 2), (2, 2)]
)


def covered(row):
    return shapely.union_all([shapely.Polygon(r) for r in row.rectangles()])


@pytest.mark.parametrize("turn", [0, 17, 90, 133])
@pytest.mark.parametrize(("shape", "count"), [(BOX, 1), (BENT, 2), (TEE, 2), (ZED, 3), (CROSS, 3)])
def test_rows_are_found_exactly(shape, count, turn):
    polygon = translate(rotate(shape, turn, origin=(0, 0)), 7, -3)
    row, iou = annotate(polygon)
    assert iou == pytest.approx(1, abs=1e-9)
    assert row.n == count
    assert covered(row).symmetric_difference(polygon).area < 1e-6
    areas = np.diff(row.u) * (row.t - row.b)
    assert row.main == 1 if count == 3 else areas[row.main] == pytest.approx(areas.max())
    assert -np.pi / 2 < row.phi <= np.pi / 2


def test_a_box_lies_along_its_longer_side():
    row, _ = annotate(BOX)
    assert row.parameters() == pytest.approx(
        {"x": 3.5, "y": 3.5, "w": 5, "h": 3, "phi": 0, "left": None, "right": None}, abs=1e-9
    )


def test_a_corner_cut_off_costs_no_rectangle():
    row, iou = annotate(shapely.Polygon([(0, 0), (6, 0), (6, 3.8), (5.8, 4), (0, 4)]))
    assert row.n == 1
    assert iou == pytest.approx(23.98 / 24, abs=1e-3)


def test_the_best_single_rectangle_of_an_el_balances_both_errors():
    row, iou = annotate(BENT, most=1)
    exact = max(20 / 32, 16 / 32, 32 / 80)  # bar, stem, box
    assert row.n == 1
    assert iou == pytest.approx(exact)


def test_a_disc_is_covered_well():
    assert annotate(shapely.Point(0, 0).buffer(3))[1] > 0.85


def test_annotation_is_the_same_every_time():
    rng = np.random.default_rng(3)
    polygon = shapely.concave_hull(shapely.MultiPoint(rng.uniform(0, 8, (40, 2))), ratio=0.3)
    first, second = annotate(polygon), annotate(polygon)
    assert first[0].parameters() == second[0].parameters()
    assert first[1] == second[1]


def test_given_directions_are_kept():
    row, iou = annotate(rotate(BOX, 10), directions=[0.0])
    assert row.phi in (pytest.approx(0), pytest.approx(np.pi / 2))
    assert iou < 0.9


def test_thousands_of_corners_are_no_trouble():
    angles = np.linspace(0, 2 * np.pi, 20001)[:-1]
    radius = 5 + 0.01 * np.sin(400 * angles)
    polygon = shapely.Polygon(np.stack([radius * np.cos(angles), radius * np.sin(angles)], axis=1))
    assert annotate(polygon)[1] > 0.85


@pytest.mark.parametrize(
    "polygon",
    [shapely.Polygon(), shapely.Polygon([(0, 0), (2, 2), (2, 0), (0, 2)]), shapely.Polygon([(0, 0), (1, 1), (2, 2)])],
)
def test_what_is_no_area_is_refused(polygon):
    with pytest.raises(WorldError, match="expected a simple polygon"):
        annotate(polygon)

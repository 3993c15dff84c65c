"""Real buildings, where the folder with them is at hand: every one imports, or is refused with a reason."""

import pytest

from regionslam_env.errors import WorldError
from regionslam_env.worlds.importers.formats import import_plan, plans_in
from regionslam_env.worlds.importers.realise import ImportOptions
from tests.worlds.plans import MISSING, PLANS

FOUND = list(plans_in(PLANS)) if PLANS.is_dir() else []
FURNITURE = "example_location_data"

pytestmark = [pytest.mark.skipif(not FOUND, reason=MISSING), pytest.mark.slow]


@pytest.fixture(scope="module")
def reports():
    pytest.importorskip("ifcopenshell")
    return [import_plan(path, ImportOptions()).report for path in FOUND if FURNITURE not in path.name]


def test_files_of_furniture_alone_are_refused_with_what_to_do():
    for path in FOUND:
        if FURNITURE in path.name:
            with pytest.raises(WorldError, match="import the world's own file"):
                import_plan(path, ImportOptions())


def test_nearly_all_rooms_are_described_well(reports):
    rooms = [room for report in reports if not report.file.endswith(".osm") for room in report.rooms]
    assert len(rooms) > 350
    assert sum(room.iou > 0.95 for room in rooms) / len(rooms) > 0.95
    assert sum(room.aligned_iou > 0.9 for room in rooms) / len(rooms) > 0.95


def test_all_buildings_but_two_hang_together(reports):
    apart = {report.name for report in reports if report.components > 1}
    assert apart == {"LargeBuilding", "caserne"}  # two houses; a mall with wings that no corridor was drawn for


def test_sizes_are_believable(reports):
    for report in reports:
        areas = sorted(room.area for room in report.rooms)
        assert 2 < areas[len(areas) // 2] < 160, report.file

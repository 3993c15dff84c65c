"""One small floor of our own in every format: a hallway, and above it an office, a kitchen and a storage room."""

from pathlib import Path

from regionslam_env.worlds.importers.formats import import_plan
from regionslam_env.worlds.importers.realise import ImportOptions

DATA = Path(__file__).parent / "data"

ROOMS = {"hallway": (0, 0, 10, 2), "office": (0, 2, 4, 5), "kitchen": (4, 2, 7, 5), "storage": (7, 2, 10, 5)}
HOUSE = {"living room": (0, 0, 10, 2), "bedroom": (0, 2, 4, 5), "kitchen": (4, 2, 7, 5), "toilet": (7, 2, 10, 5)}

EXAMPLES = {
    "imdf": "imdf",
    "azure": "azure",
    "osm": "floor.osm.geojson",
    "osm xml": "floor.osm",
    "procthor": "house.json",
    "houseexpo": "home.json",
    "luperto": "cottage.xml",
    "rmf": "shop.building.yaml",
    "pyrobosim": "flat.yaml",
    "rosmap": "floor.yaml",
    "ifc": "pavilion.ifc",
}


def imported(name, **options):
    """Import an example of ours."""
    return import_plan(DATA / EXAMPLES[name], ImportOptions(**options))

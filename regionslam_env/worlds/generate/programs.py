"""What buildings of each kind are made of: rooms with their usual sizes and shares, corridors, storey depths.

Lengths in decimetres. Room sizes follow usual planning values: offices of 12 to 25 m², classrooms of 60 to 75 m²,
two-bed wards of 25 to 35 m², corridors of 1.8 m (offices) to 3.2 m (schools).
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

Range = tuple[int, int]


@dataclass(frozen=True)
class RoomPlan:
    """One sort of room.

    Parameters
    ----------
    type, title
        Semantic type, and a name where it has one.
    width
        Along the corridor, smallest and largest, dm.
    share
        Weight among the rooms that are drawn.
    every
        One is planned for so many rooms; 0: drawn only.
    layout
        How it is furnished (`furniture.LAYOUTS`), or "flat" for a dwelling of several rooms.
    door
        Width of its door, dm.
    depth
        Its own depth, where the room next to it may reach around its back; 0: as deep as its neighbours.
    wraps
        Whether it may reach around its neighbours.
    bath
        Whether it has a bathroom of its own in a corner.
    """

    type: str
    width: Range
    share: float = 0.0
    every: int = 0
    layout: str = ""
    title: str = ""
    door: int = 9
    depth: int = 0
    wraps: bool = False
    bath: bool = False


@dataclass(frozen=True)
class Program:
    """One kind of building.

    Parameters
    ----------
    rooms
        Its sorts of room; the first is the most usual one.
    corridor, band
        Width of corridors and depth of the rooms along them, dm.
    ends
        What may stand at the end of a corridor.
    courtyard
        Depth of the courtyards between wings, dm, and how often there is one.
    niche
        Share of corridors with a place to wait or to meet.
    """

    rooms: tuple[RoomPlan, ...]
    corridor: Range
    band: Range
    ends: tuple[RoomPlan, ...]
    courtyard: Range
    courtyards: float
    niche: float


TOILET = RoomPlan("toilet", (20, 30), every=11, depth=42)
ELEVATOR = RoomPlan("elevator", (20, 24), every=40, door=10, depth=24)
STAIRS = RoomPlan("stairs", (28, 34), every=32, door=10)
STORAGE = RoomPlan("storage", (20, 32), share=0.3, every=20, layout="shelves", depth=34)
SERVICE = RoomPlan("service room", (20, 30), every=26, layout="shelves", depth=34)
KITCHEN = RoomPlan("kitchen", (34, 52), every=15, layout="kitchen")
LOBBY = RoomPlan("lobby", (60, 90), every=40, layout="lobby", door=18)

PROGRAMS: Mapping[str, Program] = {
    "office": Program(
        rooms=(
            RoomPlan("office", (28, 44), share=6.0, layout="office", wraps=True),
            RoomPlan("office", (44, 60), share=2.0, layout="office", wraps=True),
            RoomPlan("office", (84, 140), share=0.7, layout="open plan", title="open-plan office"),
            RoomPlan("meeting room", (42, 72), share=0.5, every=12, layout="meeting", wraps=True),
            RoomPlan("laboratory", (56, 84), share=0.3, layout="laboratory", door=10, wraps=True),
            TOILET,
            KITCHEN,
            STORAGE,
            SERVICE,
            STAIRS,
            ELEVATOR,
            LOBBY,
        ),
        corridor=(18, 24),
        band=(46, 60),
        ends=(STAIRS, RoomPlan("meeting room", (50, 66), layout="meeting"), LOBBY),
        courtyard=(60, 120),
        courtyards=0.15,
        niche=0.4,
    ),
    "school": Program(
        rooms=(
            RoomPlan("classroom", (78, 104), share=6.0, layout="classroom", door=10, wraps=True),
            RoomPlan("laboratory", (84, 112), share=0.8, every=12, layout="laboratory", door=10, title="science room"),
            RoomPlan("office", (30, 48), share=0.8, every=10, layout="office"),
            RoomPlan("meeting room", (56, 76), every=16, layout="meeting", title="staff room"),
            RoomPlan("lobby", (110, 160), every=22, layout="lobby", door=20, title="hall"),
            RoomPlan("kitchen", (70, 110), every=26, layout="canteen", door=12, title="canteen"),
            RoomPlan("toilet", (26, 38), every=7, depth=52),
            RoomPlan("storage", (22, 36), share=0.3, every=12, layout="shelves", depth=44),
            RoomPlan("service room", (22, 32), every=22, layout="shelves", depth=44),
            STAIRS,
        ),
        corridor=(26, 34),
        band=(64, 80),
        ends=(STAIRS, RoomPlan("lobby", (70, 100), layout="lobby", door=18, title="entrance hall")),
        courtyard=(100, 180),
        courtyards=0.5,
        niche=0.3,
    ),
    "hospital": Program(
        rooms=(
            RoomPlan("ward", (38, 50), share=5.0, layout="ward", door=12, bath=True),
            RoomPlan("ward", (52, 72), share=2.0, layout="ward", door=12, bath=True),
            RoomPlan("office", (30, 42), share=0.5, every=12, layout="office", wraps=True, title="doctor's office"),
            RoomPlan("laboratory", (48, 76), share=0.2, every=24, layout="laboratory", door=12, wraps=True),
            RoomPlan("service room", (30, 48), every=14, layout="office", title="nurses' station", door=10),
            RoomPlan("lobby", (60, 90), every=28, layout="lobby", door=18, title="waiting area"),
            RoomPlan("kitchen", (32, 46), every=24, layout="kitchen"),
            RoomPlan("toilet", (22, 30), every=16, depth=36),
            RoomPlan("storage", (22, 36), share=0.3, every=14, layout="shelves", depth=34),
            STAIRS,
            RoomPlan("elevator", (26, 32), every=30, door=14, depth=30),
        ),
        corridor=(24, 30),
        band=(54, 68),
        ends=(STAIRS, RoomPlan("lobby", (56, 80), layout="lobby", door=16, title="day room")),
        courtyard=(60, 140),
        courtyards=0.4,
        niche=0.6,
    ),
    "apartment": Program(
        rooms=(
            RoomPlan("living room", (72, 86), share=2.0, layout="flat"),
            RoomPlan("living room", (86, 116), share=3.0, layout="flat"),
            RoomPlan("living room", (48, 60), share=0.5, layout="flat"),
            RoomPlan("stairs", (28, 34), every=10, door=10, depth=54),
            RoomPlan("elevator", (20, 24), every=16, door=10, depth=24),
            RoomPlan("storage", (22, 34), every=10, layout="shelves", depth=40),
            RoomPlan("service room", (22, 30), every=30, layout="shelves", depth=40),
        ),
        corridor=(16, 20),
        band=(82, 104),
        ends=(STAIRS,),
        courtyard=(80, 160),
        courtyards=0.8,
        niche=0.0,
    ),
}
"""Programs of single buildings by kind; a campus is made of several."""

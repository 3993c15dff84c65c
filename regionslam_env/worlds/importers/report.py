"""What an import did: regions and how well they fit, doors, what was dropped and why."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass
from typing import Any

GOOD = 0.95
"""IoU above which a region counts as a good fit."""

POOR = 0.9
"""IoU below which a region is flagged."""


@dataclass(frozen=True)
class RoomReport:
    """One room: IoU of its rectangles with the drawn outline, before and after edges were moved onto common walls."""

    id: str
    name: str
    label: str
    type: str
    area: float
    iou: float
    aligned_iou: float


@dataclass(frozen=True)
class ImportReport:
    """An import in numbers.

    `components` are groups of rooms that no door joins; `assumed` are doors that the file does not have.
    """

    file: str
    format: str
    name: str
    level: str
    levels: tuple[str, ...]
    scale: float | None
    rooms: tuple[RoomReport, ...]
    doors: int
    assumed: int
    passages: int
    furniture: int
    components: int
    dropped: tuple[tuple[str, str], ...]
    notes: tuple[str, ...]

    @property
    def good_share(self) -> float:
        """Share of rooms with an IoU above `GOOD`."""
        return sum(room.iou > GOOD for room in self.rooms) / len(self.rooms)

    @property
    def poor(self) -> tuple[RoomReport, ...]:
        """Rooms that three rectangles cannot describe well."""
        return tuple(room for room in self.rooms if room.iou < POOR)

    def lines(self) -> list[str]:
        """Return the report as text."""
        scale = "" if self.scale is None else f", {self.scale:.4g} m per unit"
        others = [level for level in self.levels if level != self.level]
        more = f" (others: {', '.join(others)})" if others else ""
        lines = [
            f"{self.file}: {self.format}, level {self.level}{more}{scale}",
            f"{amount(len(self.rooms), 'room')} ({100 * self.good_share:.0f} % with IoU > {GOOD}), "
            f"{amount(self.doors, 'door')} ({self.assumed} assumed), {amount(self.passages, 'open border')}, "
            f"{amount(self.furniture, 'piece')} of furniture",
            "every room can be reached by doors"
            if self.components == 1
            else f"{self.components} parts without a door between them",
        ]
        lines += [f"flag: {room.id} ({room.name}): IoU {room.iou:.2f}" for room in self.poor]
        for (what, why), count in _counted(self.dropped):
            lines.append(f"dropped: {what}: {why}" if count == 1 else f"dropped: {count} x {what.split()[0]}: {why}")
        return lines + [f"note: {note}" for note in self.notes]

    def as_dict(self) -> dict[str, Any]:
        """Return the report as plain data."""
        return {
            "file": self.file,
            "format": self.format,
            "name": self.name,
            "level": self.level,
            "levels": list(self.levels),
            "scale": self.scale,
            "rooms": [
                {**vars(room), "iou": round(room.iou, 4), "aligned_iou": round(room.aligned_iou, 4)}
                for room in self.rooms
            ],
            "good_share": round(self.good_share, 4),
            "flagged": [room.id for room in self.poor],
            "doors": self.doors,
            "assumed": self.assumed,
            "passages": self.passages,
            "furniture": self.furniture,
            "components": self.components,
            "connected": self.components == 1,
            "dropped": [{"what": what, "why": why} for what, why in self.dropped],
            "notes": list(self.notes),
        }


def amount(number: int, noun: str) -> str:
    """Return a number of things, e.g. "1 room" or "2 rooms"."""
    return f"{number} {noun}" if number == 1 else f"{number} {noun}s"


def _counted(dropped: tuple[tuple[str, str], ...]) -> list[tuple[tuple[str, str], int]]:
    """Return what was dropped, things of one kind for one reason together."""
    kinds = [(what.partition(" ")[0], why) for what, why in dropped]
    counts, first = Counter(kinds), dict(zip(reversed(kinds), reversed(dropped), strict=True))
    return [(first[key], count) for key, count in counts.items()]

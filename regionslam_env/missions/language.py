"""Words to missions: "go to the hallway" becomes ``Mission((GoTo("hallway"),))``.

The grammar knows the sentence, the vocabulary of places comes from the caller: whatever types the environment uses.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from functools import cache

from lark import Lark, Token, Tree
from lark.exceptions import UnexpectedInput

from regionslam_env.errors import unknown
from regionslam_env.missions.mission import GoTo, Mission

GRAMMAR = r"""
start: PLEASE? _motion DETERMINER? place PLEASE?
_motion: (MOVE | FIND) | MOVE TO | TAKE ME TO
place: (WORD | TO)+

PLEASE.2: /(please|robot)\b/
MOVE.2: /(go|drive|move|head|navigate|travel|walk|come|get|return)\b/
FIND.2: /(find|visit|reach|enter)\b/
TAKE.2: /(take|bring|guide|lead)\b/
ME.2: /(me|us|yourself)\b/
TO.2: /(into|inside|to|towards|toward|in)\b/
DETERMINER.2: /(the\s+nearest|the\s+next|the\s+closest|the|an|a|any|some|one\s+of\s+the|nearest|our|your)\b/
WORD: /[^\W_]+(['-][^\W_]+)*/

%ignore /[\s,.!_]+/
"""

SYNONYMS = {
    "hallway": ("corridor", "hall", "passage", "passageway", "aisle", "gang"),
    "office": ("bureau", "study", "workroom"),
    "kitchen": ("kitchenette", "pantry", "tea kitchen", "coffee kitchen"),
    "laboratory": ("lab",),
    "meeting room": ("conference room", "boardroom", "seminar room", "meeting"),
    "toilet": ("wc", "restroom", "bathroom", "washroom", "lavatory", "loo", "men's room", "ladies' room"),
    "storage": ("storeroom", "storage room", "store room", "store", "closet", "depot"),
    "classroom": ("class", "class room", "lecture room", "school room"),
    "lobby": ("foyer", "reception", "atrium"),
    "stairs": ("stair", "staircase", "stairway", "stairwell"),
    "elevator": ("lift",),
    "entrance": ("entry", "exit", "entrance hall"),
    "service room": ("utility room", "technical room", "machine room"),
    "living room": ("lounge", "sitting room", "parlour"),
    "bedroom": ("bed room", "sleeping room"),
    "ward": ("sickroom", "patient room", "hospital room"),
    "outdoor": ("outdoors", "outside", "path"),
    "door": ("doorway",),
    "cupboard": ("cabinet", "shelf", "wardrobe"),
    "sofa": ("couch", "settee"),
}
"""Everyday words for the types of the default vocabulary."""


class MissionError(ValueError):
    """A sentence that is no mission, or that names an unknown place."""


def parse(text: str, known_types: Iterable[str]) -> Mission:
    """Read one instruction in plain English.

    Parameters
    ----------
    text
        For example "go to the hallway", "Please drive to a meeting room!", "find the lab".
    known_types
        Semantic types that a place may have. A plural or a synonym of one of them is understood.

    Raises
    ------
    MissionError
        If the sentence is none of the known forms, or its place none of the known types (the nearest are named).
    """
    try:
        tree = _grammar().parse(text.casefold())
    except UnexpectedInput:
        raise MissionError(f"cannot read the mission {text!r}; expected for example 'go to the hallway'") from None
    return Mission((GoTo(place_type(" ".join(_place(tree)), known_types)),))


def place_type(name: str, known_types: Iterable[str]) -> str:
    """Return the known type that a name, its singular or a synonym stands for, or raise `MissionError`."""
    known = tuple(known_types)
    types = {_key(kind): kind for kind in known}
    for form in _forms(_key(name)):
        if form in types:
            return types[form]
        for kind, words in SYNONYMS.items():
            if form in map(_key, words) and kind in types:
                return types[kind]
    raise MissionError(unknown("place", name, known))


def _key(name: str) -> str:
    return " ".join(name.casefold().replace("_", " ").replace("-", " ").split())


def _forms(name: str) -> Iterator[str]:
    """Yield the name and what it may be the plural of: kitchens, laboratories, classes, shelves."""
    yield name
    for ending, singular in (("ies", "y"), ("ves", "f"), ("es", ""), ("s", "")):
        if name.endswith(ending):
            yield name[: -len(ending)] + singular


def _place(tree: Tree[Token]) -> list[str]:
    (place,) = tree.find_data("place")
    return [str(token) for token in place.children]


@cache
def _grammar() -> Lark:
    return Lark(GRAMMAR, parser="lalr")

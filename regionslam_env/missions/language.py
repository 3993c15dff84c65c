"""Words to missions: "go to the hallway, then return" becomes ``Mission((GoTo("hallway"), Return()))``.

The grammar knows the sentences, the vocabulary of places comes from the caller: whatever types the environment uses.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from functools import cache

from lark import Lark, Token, Tree
from lark.exceptions import UnexpectedInput

from regionslam_env.errors import ConfigError, listed, short, unknown
from regionslam_env.missions.mission import Explore, GoTo, Instruction, Mission, Return

_VERBS = "|".join(
    (
        *("then", "please", "afterwards", "finally", "lastly", "go", "drive", "move", "head", "navigate", "travel"),
        *(
            "walk",
            "come",
            "get",
            "return",
            "find",
            "visit",
            "reach",
            "enter",
            "search",
            "take",
            "bring",
            "guide",
            "lead",
        ),
        *("explore", "map", "survey", "scout", "look", "back", "to", "the"),
    )
)
"""What may follow an "and" that joins two instructions; any other one belongs to the name of a place."""

_HOMES = r"(start|starting\s+(point|place|position)|beginning|origin|home|where\s+(you|we)\s+(started|began))\b"
"""Where the map was begun, if it ends an instruction: a home office is a place."""

GRAMMAR = r"""
start: FIRST? PLEASE? FIRST? _instruction (PLEASE? _THEN+ PLEASE? (_instruction | shortened))* PLEASE?
_instruction: goto | explore | return
goto: (MOVE | RETURN) BACK? TO? DETERMINER? place
    | FIND DETERMINER? place
    | TAKE ME BACK? TO DETERMINER? place
shortened: (BACK? TO)? DETERMINER? place -> goto
         | BACK -> return
         | BACK? TO? DETERMINER? HOME -> return
explore: EXPLORE (DETERMINER | SCOPE)*
return: RETURN BACK? | MOVE BACK | TAKE ME BACK
      | (MOVE | RETURN) BACK? TO? DETERMINER? HOME
      | TAKE ME BACK? TO? DETERMINER? HOME
place: WORD (WORD | TO)*

_THEN.4: /[,;.!&\n](?=\s*[^\W_])|(then|afterwards|after\s+that|finally|lastly)\b|and(?=\s+(VERBS)\b)/
PLEASE.5: /[\s,]*\b(please|robot)\b[\s,]*/
MOVE.2: /(go|drive|move|head|navigate|travel|walk|come|get)\b/
RETURN.2: /return\b/
FIND.2: /(find|visit|reach|enter|look\s+for|search\s+for)\b/
FIRST.2: /(first|firstly)\b/
TAKE.2: /(take|bring|guide|lead)\b/
EXPLORE.2: /(explore|map|survey|scout|look\s+around)\b/
SCOPE.2: /(everything|everywhere|all|whole|entire|rest|of|floor|storey|building|house|apartment|flat|area|place)\b/
ME.2: /(me|us|yourself)\b/
BACK.2: /back\b/
TO.2: /(into|inside|to|towards|toward|in)\b/
HOME.3: /HOMES(?=\W*((then|and|afterwards|finally|please)\b|$)|\s*[,;.!])/
DETERMINER.2: /(the\s+nearest|the\s+next|the\s+closest|the|an|a|any|some|one\s+of\s+the|nearest|our|your)\b/
WORD: /[^\W_]+(['-][^\W_]+)*/

%ignore /[^\S\n]+|[,;.!_&\n]/
""".replace("VERBS", _VERBS).replace("HOMES", _HOMES)

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


class MissionError(ConfigError):
    """A sentence that is no mission, or that names an unknown place."""


def parse(text: str, known_types: Iterable[str]) -> Mission:
    """Read instructions in plain English.

    Parameters
    ----------
    text
        For example "go to the hallway", "Please find a meeting room!", "explore, then go to the lab and return".
    known_types
        Semantic types that a place may have. A plural or a synonym of one of them is understood.

    Raises
    ------
    MissionError
        If the words are none of the known forms, or a place none of the known types (the nearest are named, or, where
        everybody knows what is meant, those that there are).
    """
    try:
        tree = _grammar().parse(text.casefold())
    except UnexpectedInput:
        raise MissionError(
            f"cannot read the mission {text!r}; expected for example 'go to the hallway, then return'"
        ) from None
    types = tuple(known_types)
    return Mission(tuple(_instruction(part, types) for part in tree.find_pred(_is_instruction)))


def place_type(name: str, known_types: Iterable[str]) -> str:
    """Return the known type that a name, its singular or a synonym stands for, or raise `MissionError`."""
    known = tuple(known_types)
    types = {_key(kind): kind for kind in known}
    for form in _forms(_key(name)):
        if form in types:
            return types[form]
        for kind in _meant(form):
            if kind in types:
                return types[kind]
    for form in _forms(_key(name)):
        for kind in _meant(form):
            meant = "" if kind == name else f" ({short(kind)})"
            raise MissionError(f"no {short(name)}{meant} here: expected one of {listed(known)}")
    raise MissionError(unknown("place", name, known))


def _meant(form: str) -> Iterator[str]:
    """Yield the types of the default vocabulary that a name stands for."""
    return (kind for kind, words in SYNONYMS.items() if form == kind or form in map(_key, words))


def _key(name: str) -> str:
    return " ".join(name.casefold().replace("_", " ").replace("-", " ").split())


def _forms(name: str) -> Iterator[str]:
    """Yield the name and what it may be the plural of: kitchens, laboratories, classes, shelves."""
    yield name
    for ending, singular in (("ies", "y"), ("ves", "f"), ("es", ""), ("s", "")):
        if name.endswith(ending):
            yield name[: -len(ending)] + singular


def _is_instruction(tree: Tree[Token]) -> bool:
    return tree.data in ("goto", "explore", "return")


def _instruction(tree: Tree[Token], types: tuple[str, ...]) -> Instruction:
    if tree.data == "explore":
        return Explore()
    if tree.data == "return":
        return Return()
    (place,) = tree.find_data("place")
    return GoTo(place_type(" ".join(map(str, place.children)), types))


@cache
def _grammar() -> Lark:
    return Lark(GRAMMAR, parser="lalr")

"""Damage to what a file says: JSON, YAML and XML stay well formed, but their values are not what is expected."""

from __future__ import annotations

import copy
import json
import random
import xml.etree.ElementTree as ElementTree
from collections.abc import Iterator
from typing import Any

import yaml

Place = tuple[Any, Any]
"""A list or dictionary and an index or key in it."""

MANY = 3000
"""Copies of an item where there is to be a flood of them."""

LARGEST = 1e290
"""Numbers beyond cannot be multiplied by a float any more: an earlier change has put a huge integer there."""

ODD_TEXTS = ("", " ", "nan", "-1", "0", "1e309", "x" * 10_000, "\x00", "😀", "../../etc/passwd", "/dev/zero", "None")


def odd_value(rng: random.Random) -> Any:
    """Return a value that is hardly ever the right one."""
    nested: Any = []
    for _ in range(200):
        nested = [nested]
    numbers = [0, -1, 1e-300, 1e6, 1e18, 1e308, 10**400, float("nan"), float("inf"), float("-inf"), 0.5, 3]
    others = [None, True, False, [], {}, [[]], [None, None], nested, {"type": "x"}]
    return rng.choice([*numbers, *others, *ODD_TEXTS])


def change_json(content: bytes, rng: random.Random) -> bytes:
    """Return JSON with one value changed; `ValueError` where there is none to begin with."""
    return json.dumps(_changed(json.loads(content.decode("utf-8-sig")), rng)).encode()


def change_yaml(content: bytes, rng: random.Random) -> bytes:
    """Return YAML with one value changed; `ValueError` where there is none to begin with."""
    try:
        return yaml.safe_dump(_changed(yaml.safe_load(content.decode("utf-8-sig")), rng)).encode()
    except yaml.YAMLError as error:
        raise ValueError(str(error)) from None


def change_xml(content: bytes, rng: random.Random) -> bytes:
    """Return XML with one element changed; `ValueError` where there is none to begin with."""
    try:
        root = ElementTree.fromstring(content)
    except (ElementTree.ParseError, LookupError) as error:  # an encoding that there is not
        raise ValueError(str(error)) from None
    pairs = [(parent, k) for parent in root.iter() for k in range(len(parent))]
    if not pairs:
        return content
    parent, k = rng.choice(pairs)
    element = parent[k]
    change = rng.randrange(7)
    if change == 0:
        del parent[k]
    elif change == 1:
        parent.extend([copy.deepcopy(element) for _ in range(rng.choice([1, 1, 1, MANY]))])
    elif change == 2:
        other, j = rng.choice(pairs)
        parent[k] = copy.deepcopy(other[j])
    elif change == 3 and element.attrib:
        name = rng.choice(sorted(element.attrib))
        element.attrib[name] = _xml_text(rng)
    elif change == 4 and element.attrib:
        del element.attrib[rng.choice(sorted(element.attrib))]
    elif change == 5:
        element.text = _xml_text(rng)
    else:
        element.tag = rng.choice(pairs)[0].tag
    return ElementTree.tostring(root)


def _xml_text(rng: random.Random) -> str:
    return rng.choice([text for text in ODD_TEXTS if "\x00" not in text] + ["1e18", "-1e6", "3,5", "0x10"])


def _changed(root: Any, rng: random.Random) -> Any:
    """Change one value of a tree of lists and dictionaries in place; return the tree."""
    holder = [root]
    places = list(_places(holder))
    container, key = rng.choice(places)
    change = rng.randrange(8)
    value = container[key]
    if change == 0 and container is not holder:
        del container[key]
    elif change == 1 and isinstance(value, int | float) and not isinstance(value, bool) and abs(value) < LARGEST:
        container[key] = value * rng.choice([-1, 0, 1e-9, 0.5, 1.001, 10, 1000, 1e9])
    elif change == 2:
        other, j = rng.choice(places)
        container[key] = copy.deepcopy(other[j])
    elif change == 3 and isinstance(value, list) and value:
        item = rng.choice(value)
        value.extend(copy.deepcopy(item) for _ in range(rng.choice([1, 1, 1, 30, MANY])))
    elif change == 4 and isinstance(value, list):
        rng.shuffle(value)
    elif change == 5 and isinstance(container, dict):
        container[rng.choice(["type", "id", "name", "x", "", str(key) + "s"])] = container.pop(key)
    elif change == 6 and isinstance(value, str):
        container[key] = rng.choice(ODD_TEXTS)
    else:
        container[key] = odd_value(rng)
    return holder[0]


def _places(value: Any) -> Iterator[Place]:
    """Yield every place below a list or dictionary."""
    keys = range(len(value)) if isinstance(value, list) else list(value) if isinstance(value, dict) else ()
    for key in keys:
        yield value, key
        yield from _places(value[key])

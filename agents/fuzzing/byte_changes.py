"""Damage to the bytes of a file: what a person, a program or a disk may do to it."""

from __future__ import annotations

import random
import re

NUMBER = re.compile(rb"-?\d+(?:\.\d+)?")
WORD = re.compile(rb"[A-Za-z_]{3,}")
ODD = b"nan NaN -1 0 1e308 -1e999 1e6 99999999999999999999 null true \"x\" [] {} '' 0x1F 1.5.2".split()
JUNK = (
    *b"\x00 \xff\xfe < > { } [[[[ ] \" ' # ; ( $ <<: :".split(),
    *(b"&a ", b"*a ", b"- ", b": ", b"\n", b"\t", b"!!python/name:os "),
)
LONGEST = 60
"""Bytes of what is cut out."""


def change_bytes(content: bytes, rng: random.Random) -> bytes:
    """Return a file's content with one change."""
    return rng.choice(CHANGES)(content, rng)


def add_bomb(content: bytes, rng: random.Random) -> bytes:
    """Return a file's content with what grows, or nests without end, when it is read."""
    aliases = b"".join(b"k%d: &a%d [%s]\n" % (k, k, b", ".join([b"*a%d" % (k - 1)] * 9)) for k in range(1, 9))
    entities = b"".join(b'<!ENTITY e%d "%s">' % (k, b"&e%d;" % (k - 1) * 9) for k in range(1, 9))
    return rng.choice(
        [
            b"k0: &a0 [1]\n" + aliases + content,
            b'<!DOCTYPE x [<!ENTITY e0 "x">' + entities + b"]>" + content,
            b"[" * 100_000 + content,
            b'{"a":' * 100_000 + content,
            b"<a>" * 100_000 + content,
            b"\x1f\x8b" + content,
            content + b"\x00" * 1_000_000,
        ]
    )


def _other_number(content: bytes, rng: random.Random) -> bytes:
    found = list(NUMBER.finditer(content))
    if not found:
        return content
    place = rng.choice(found)
    old = place.group()
    new = rng.choice([*ODD, rng.choice(found).group(), old + b"0", b"-" + old, old[:1]])
    return content[: place.start()] + new + content[place.end() :]


def _cut(content: bytes, rng: random.Random) -> bytes:
    begin = rng.randrange(len(content) + 1)
    return content[:begin] + content[begin + rng.randint(1, LONGEST) :]


def _junk(content: bytes, rng: random.Random) -> bytes:
    place = rng.randrange(len(content) + 1)
    return content[:place] + rng.choice(JUNK) * rng.choice([1, 1, 1, 200]) + content[place:]


def _copied(content: bytes, rng: random.Random) -> bytes:
    begin, place = rng.randrange(len(content) + 1), rng.randrange(len(content) + 1)
    return content[:place] + content[begin : begin + rng.randint(1, 4 * LONGEST)] + content[place:]


def _line(content: bytes, rng: random.Random) -> bytes:
    lines = content.split(b"\n")
    k = rng.randrange(len(lines))
    lines[k : k + 1] = rng.choice([[], [lines[k], lines[k]], [lines[rng.randrange(len(lines))]]])
    return b"\n".join(lines)


def _word(content: bytes, rng: random.Random) -> bytes:
    words = list(WORD.finditer(content))
    if not words:
        return content
    place, other = rng.choice(words), rng.choice(words)
    return content[: place.start()] + rng.choice([other.group(), b"", b"x"]) + content[place.end() :]


def _short(content: bytes, rng: random.Random) -> bytes:
    return content[: rng.randrange(len(content) + 1)]


def _flipped(content: bytes, rng: random.Random) -> bytes:
    """Flip single bits, which makes text that is no UTF-8 as well."""
    flipped = bytearray(content)
    for _ in range(rng.choice([1, 3, 20]) if content else 0):
        flipped[rng.randrange(len(flipped))] ^= 1 << rng.randrange(8)
    return bytes(flipped)


def _encoded(content: bytes, rng: random.Random) -> bytes:
    """Write the text in another encoding, or with a byte order mark."""
    text = content.decode("utf-8", "replace")
    return text.encode(rng.choice(["utf-16", "utf-32", "utf-8-sig", "cp037"]), "replace")


CHANGES = (
    *(_other_number, _other_number, _other_number, _cut, _junk, _copied, _line, _word, _word, _short),
    *(_flipped, _encoded),
)

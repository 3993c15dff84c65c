"""Damage to the image of a map: headers that promise too much, noise, and sizes that no building has."""

from __future__ import annotations

import random
import re

HEADER = re.compile(rb"^(P[1-6])\s+(\d+)\s+(\d+)\s+(\d+)\s")


def change_image(content: bytes, rng: random.Random) -> bytes:
    """Return a PGM image with another header or other pixels; `ValueError` for anything else."""
    header = HEADER.match(content)
    if header is None:
        raise ValueError("no PGM image")
    kind, width, height, white = header.groups()
    pixels = content[header.end() :]
    change = rng.randrange(5)
    if change == 0:
        width = rng.choice([b"0", b"1", b"-3", b"20000", b"999999999", width + b"0"])
    elif change == 1:
        height = rng.choice([b"0", b"1", b"-3", b"20000", b"999999999", height + b"0"])
    elif change == 2:
        white = rng.choice([b"0", b"1", b"65535", b"99999"])
    elif change == 3:
        kind = rng.choice([b"P1", b"P2", b"P3", b"P4", b"P6", b"P9"])
    else:
        share = rng.choice([0.01, 0.5])
        pixels = bytes(rng.choice((0, 205, 254)) if rng.random() < share else pixel for pixel in pixels)
    return b"%s\n%s %s\n%s\n" % (kind, width, height, white) + pixels

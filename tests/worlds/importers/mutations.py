"""Damage to example files: what a person, a program or a disk may do to them."""

from __future__ import annotations

import random
import re
import shutil
import signal
from contextlib import contextmanager
from pathlib import Path

from regionslam_env.errors import WorldError
from regionslam_env.worlds.loading import load
from tests.worlds.importers.examples import DATA, EXAMPLES

NUMBER = re.compile(rb"-?\d+(?:\.\d+)?")
ODD = b"nan NaN -1 0 1e308 -1e999 1e6 99999999999999999999 null true \"x\" [] {} '' 0x1F 1.5.2".split()
JUNK = [
    *b"\x00 \xff\xfe < > { } [[[[ ] \" ' # ; ( $ <<: :".split(),
    b"&a ",
    b"*a ",
    b"- ",
    b": ",
    b"\n",
    b"\t",
    b"!!python/name:os ",
]
FILES = {**EXAMPLES, "ours": "ours.geojson"}
LONGEST = 60


def mutated(content: bytes, rng: random.Random) -> bytes:
    """Return a file's content with one to four changes."""
    for _ in range(rng.choice([1, 1, 2, 4])):
        content = rng.choice(CHANGES)(content, rng)
    return content


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
    words = list(re.finditer(rb"[A-Za-z_]{3,}", content))
    if not words:
        return content
    place, other = rng.choice(words), rng.choice(words)
    return content[: place.start()] + rng.choice([other.group(), b"", b"x"]) + content[place.end() :]


def _short(content: bytes, rng: random.Random) -> bytes:
    return content[: rng.randrange(len(content) + 1)]


CHANGES = (_other_number, _other_number, _other_number, _cut, _junk, _copied, _line, _word, _word, _short)


@contextmanager
def guarded(seconds: int):
    """Fail where something takes much longer than any small file may."""

    def expired(number, frame):
        raise AssertionError(f"no answer within {seconds} s")

    before = signal.signal(signal.SIGALRM, expired)
    signal.alarm(seconds)
    try:
        yield
    finally:
        signal.alarm(0)
        signal.signal(signal.SIGALRM, before)


def attempt(name: str, seed: int, folder: Path) -> bool:
    """Damage one file of an example and load it; whether it still gave a world. Anything but `WorldError` escapes."""
    rng = random.Random(f"{name} {seed}")
    shutil.rmtree(folder, ignore_errors=True)
    shutil.copytree(DATA, folder)
    target = folder / FILES[name]
    companions = [folder / "floor.rooms.yaml", folder / "floor.pgm"] if name == "rosmap" else []
    companions += [folder / "flat_furniture.yaml"] if name == "pyrobosim" else []
    files = sorted(target.iterdir()) if target.is_dir() else [target, target, *companions]
    damaged = rng.choice(files)
    damaged.write_bytes(mutated(damaged.read_bytes(), rng))
    try:
        with guarded(60):
            load(target, scale=rng.choice([None, None, None, 0.01]))
    except WorldError as error:
        assert str(folder) in str(error), f"the file is not named: {error}"
        assert len(str(error)) < 2000
        return False
    return True

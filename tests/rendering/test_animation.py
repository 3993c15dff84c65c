from __future__ import annotations

import numpy as np
import pytest
from PIL import Image

from regionslam_env.rendering import GifWriter


def frame(red: int) -> np.ndarray:
    image = np.zeros((20, 30, 3), np.uint8)
    image[:, :15, 0], image[:, 15:, 2] = 255, red
    return image


def test_every_frame_is_written(tmp_path):
    path = tmp_path / "new" / "x.gif"
    with GifWriter(path, frame_ms=50, last_ms=900) as gif:
        for k in range(4):
            gif.add(frame(60 * k))
    with Image.open(path) as image:
        assert (image.n_frames, image.size) == (4, (30, 20))
        image.seek(3)
        assert image.info["duration"] == 900
    assert [p.name for p in path.parent.iterdir()] == ["x.gif"]


def test_an_error_leaves_nothing_behind(tmp_path):
    with pytest.raises(RuntimeError), GifWriter(tmp_path / "x.gif") as gif:
        gif.add(frame(0))
        raise RuntimeError
    assert list(tmp_path.iterdir()) == []


def test_an_old_file_survives_a_failed_write(tmp_path, monkeypatch):
    path = tmp_path / "x.gif"
    path.write_bytes(b"old")
    writer = GifWriter(path)
    writer.add(frame(0))

    def fail(*args: object, **kwargs: object) -> None:
        raise OSError("disk full")

    monkeypatch.setattr(Image.Image, "save", fail)
    with pytest.raises(OSError, match="disk full"):
        writer.write()
    assert path.read_bytes() == b"old" and len(list(tmp_path.iterdir())) == 1

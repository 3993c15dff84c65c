"""A drawing surface in metres: geometry is drawn at twice the size and reduced, text is set on the result."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike
from PIL import Image, ImageDraw

from regionslam_env.rendering.palette import Colour, text_halo, text_mask, text_width
from slam.rows import Floats

SUPERSAMPLING = 2

Pixels = list[tuple[float, float]]
_Text = tuple[float, float, str, Colour, int, Colour | None]


@dataclass(frozen=True, eq=False)
class Viewport:
    """Affine map from metres to pixels, y upwards.

    Parameters
    ----------
    matrix, offset
        ``pixel = matrix @ point + offset``, shapes (2, 2) and (2,).
    scale
        Pixels per metre.
    """

    matrix: Floats
    offset: Floats
    scale: float

    @classmethod
    def fit(cls, bounds: tuple[float, float, float, float], size: tuple[int, int], margin: float = 10.0) -> Viewport:
        """Show all of `bounds` (x0, y0, x1, y1 in m) centred in `size` pixels, with a margin in pixels."""
        x0, y0, x1, y1 = bounds
        width, height = max(x1 - x0, 1e-6), max(y1 - y0, 1e-6)
        scale = min((size[0] - 2 * margin) / width, (size[1] - 2 * margin) / height)
        return cls.centred((x0 + x1) / 2, (y0 + y1) / 2, scale, size)

    @classmethod
    def centred(cls, x: float, y: float, scale: float, size: tuple[int, int]) -> Viewport:
        """Show the point (x, y) in the middle of `size` pixels, `scale` pixels to the metre."""
        offset = np.array([size[0] / 2 - scale * x, size[1] / 2 + scale * y])
        return cls(np.diag([scale, -scale]), offset, scale)

    def seen_from(self, pose: ArrayLike) -> Viewport:
        """Return the viewport for points that are given in the frame of `pose` (x, y, theta)."""
        x, y, theta = np.asarray(pose, dtype=np.float64)
        c, s = np.cos(theta), np.sin(theta)
        rotation = np.array([[c, -s], [s, c]])
        return Viewport(self.matrix @ rotation, self.matrix @ np.array([x, y]) + self.offset, self.scale)

    def pixels(self, points: ArrayLike) -> Pixels:
        """Return points, shape (k, 2) in m, as a list of pixel pairs."""
        moved = np.asarray(points, dtype=np.float64) @ self.matrix.T + self.offset
        return list(map(tuple, moved.tolist()))  # type: ignore[arg-type]


class Panel:
    """One picture in the making; coordinates are pixels of the finished picture.

    Parameters
    ----------
    size
        Width and height, px.
    background
        Colour of the empty panel, or a panel to go on from; that one stays as it is.
    """

    def __init__(self, size: tuple[int, int], background: Colour | Panel) -> None:
        self.size = size
        self._texts: list[_Text] = []
        self._clear: list[tuple[float, float, float]] = []  # discs that no text may cover
        if isinstance(background, Panel):
            self._image: Image.Image = background._image.copy()
            self._texts += background._texts
            self._clear += background._clear
        else:
            self._image = Image.new("RGB", (size[0] * SUPERSAMPLING, size[1] * SUPERSAMPLING), background)
        self._draw = ImageDraw.Draw(self._image)
        self._glaze = ImageDraw.Draw(self._image, "RGBA")  # blends translucent colours, and takes longer

    def polygon(self, points: Pixels, fill: Colour, alpha: float = 1.0) -> None:
        """Fill a polygon."""
        if alpha < 1:
            self._glaze.polygon(_double(points), fill=(*fill, round(255 * alpha)))
        else:
            self._draw.polygon(_double(points), fill=fill)

    def shows(self, start: tuple[float, float], end: tuple[float, float]) -> bool:
        """Return whether the box around a segment meets the panel."""
        return (
            max(start[0], end[0]) >= 0
            and min(start[0], end[0]) <= self.size[0]
            and max(start[1], end[1]) >= 0
            and min(start[1], end[1]) <= self.size[1]
        )

    def line(self, points: Pixels, colour: Colour, width: float = 1.0) -> None:
        """Draw an open line."""
        if len(points) > 1:
            joint = "curve" if len(points) > 2 and width >= 2 else None
            self._draw.line(_double(points), colour, _thick(width), joint=joint)

    def dashes(self, start: tuple[float, float], end: tuple[float, float], colour: Colour, width: float = 1.0) -> None:
        """Draw a dashed segment; it begins and ends with a dash."""
        dash, gap = 4.0, 3.5
        length = float(np.hypot(end[0] - start[0], end[1] - start[1]))
        count = max(1, round((length + gap) / (dash + gap)))
        period = (length + gap) / count
        for k in range(count):
            low, high = k * period / max(length, 1e-9), min(1.0, (k * period + period - gap) / max(length, 1e-9))
            a = (start[0] + low * (end[0] - start[0]), start[1] + low * (end[1] - start[1]))
            b = (start[0] + high * (end[0] - start[0]), start[1] + high * (end[1] - start[1]))
            self._draw.line(_double([a, b]), colour, _thick(width))

    def disc(self, centre: tuple[float, float], radius: float, colour: Colour) -> None:
        """Fill a disc."""
        x, y = (SUPERSAMPLING * v for v in centre)
        r = SUPERSAMPLING * radius
        self._draw.ellipse((x - r, y - r, x + r, y + r), fill=colour)

    def dots(self, centres: Pixels, colour: Colour) -> None:
        """Draw small dots, about 2.5 px across, all in one call."""
        offsets = ((0, 0), (1, 0), (-1, 0), (0, 1), (0, -1), (2, 0), (-2, 0), (0, 2), (0, -2))
        corners = ((1, 1), (1, -1), (-1, 1), (-1, -1))
        middles = [(round(SUPERSAMPLING * x), round(SUPERSAMPLING * y)) for x, y in centres]
        self._draw.point([(x + i, y + j) for x, y in middles for i, j in (*offsets, *corners)], colour)

    def text(self, x: float, y: float, text: str, colour: Colour, size: int = 11, halo: Colour | None = None) -> None:
        """Set a text with its middle at (x, y) on the finished picture, above whatever is drawn before or after.

        Parameters
        ----------
        halo
            Colour around the letters, so that they can be read on lines.
        """
        self._texts.append((x, y, text, colour, size, halo))

    def text_beside(
        self, mark: tuple[float, float], radius: float, text: str, colour: Colour, size: int, halo: Colour
    ) -> None:
        """Set a text below, above, right or left of a disc: the first place free of other texts and clear discs."""
        (x, y), half = mark, text_width(text, size) / 2
        up, aside = radius + 0.5 * size + 2, radius + half + 4
        places = [(x, y + up), (x, y - up), (x + aside, y), (x - aside, y)]
        place = next((p for p in places if self._is_free(p, half, size)), places[0])
        self.text(*place, text, colour, size, halo)

    def _is_free(self, place: tuple[float, float], half: float, size: int) -> bool:
        """Return whether a text of this half width would lie in the panel, beside all others and off clear discs."""
        taken = [(x, y, text_width(text, other) / 2 + 2, other / 2 + 2) for x, y, text, _, other, _ in self._texts]
        taken += [(x, y, radius, radius) for x, y, radius in self._clear]
        return (
            half < place[0] < self.size[0] - half
            and size / 2 < place[1] < self.size[1] - size / 2
            and all(abs(x - place[0]) >= half + a or abs(y - place[1]) >= size / 2 + b for x, y, a, b in taken)
        )

    def keep_clear(self, centre: tuple[float, float], radius: float) -> None:
        """Move the texts set so far aside that would cover a disc."""
        self._clear.append((*centre, radius))
        self._texts = [(*self._aside(text, centre, radius), *text[2:]) for text in self._texts]

    def finish(self) -> Image.Image:
        """Return the finished picture."""
        image = self._image.reduce(SUPERSAMPLING)
        for x, y, text, colour, size, halo in self._texts:
            if halo is not None:
                _paste(image, (x, y), text_halo(text, size), halo)
            _paste(image, (x, y), text_mask(text, size), colour)
        return image

    def _aside(self, text: _Text, centre: tuple[float, float], radius: float) -> tuple[float, float]:
        """Return where a text is off a disc: of the places beside, above and below it, the nearest in the panel."""
        x, y, words, _, size, _ = text
        (cx, cy), half = centre, text_width(words, size) / 2
        wide, high = half + radius + 4, 0.5 * size + radius + 3
        if abs(x - cx) >= wide or abs(y - cy) >= high:
            return x, y
        places = [(x, cy - high), (x, cy + high), (cx + wide, y), (cx - wide, y)]
        inside = [p for p in places if half < p[0] < self.size[0] - half and size < p[1] < self.size[1] - size]
        return min(inside or places, key=lambda place: abs(place[0] - x) + abs(place[1] - y))


def _paste(image: Image.Image, middle: tuple[float, float], mask: Image.Image, colour: Colour) -> None:
    image.paste(colour, (round(middle[0] - mask.width / 2), round(middle[1] - mask.height / 2)), mask)


def _double(points: Pixels) -> Pixels:
    return [(SUPERSAMPLING * x, SUPERSAMPLING * y) for x, y in points]


def _thick(width: float) -> int:
    return max(1, round(SUPERSAMPLING * width))

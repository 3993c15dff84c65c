"""The shortest way into pymunk's engine.

A substep through pymunk's own methods costs three times the engine's own work, and an environment step takes ten.
"""

from __future__ import annotations

from collections.abc import Callable

import pymunk

Push = Callable[[float, float, float], None]
"""Apply a force (N, N) to the body and let the space advance by a time (s)."""


def fast_push(space: pymunk.Space, body: pymunk.Body) -> Push:
    """Return a function that pushes `body` and steps `space` by direct calls of Chipmunk, or `plain_push` without them.

    The space must hold the body already, and nothing may be added or removed while the function is in use.
    """
    try:
        from pymunk._chipmunk_cffi import lib

        set_force, advance = lib.cpBodySetForce, lib.cpSpaceStep
        body_pointer, space_pointer = body._body, space._space
    except (ImportError, AttributeError):  # another release of pymunk may keep its engine elsewhere
        return plain_push(space, body)

    def push(force_x: float, force_y: float, dt: float) -> None:
        set_force(body_pointer, (force_x, force_y))
        advance(space_pointer, dt)

    return push


def plain_push(space: pymunk.Space, body: pymunk.Body) -> Push:
    """Return a function that pushes `body` and steps `space` by pymunk's public methods alone."""

    def push(force_x: float, force_y: float, dt: float) -> None:
        body.force = (force_x, force_y)
        space.step(dt)

    return push

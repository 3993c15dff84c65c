"""The shortest way into pymunk's engine.

A substep through pymunk's own methods costs three times the engine's own work, and an environment step takes ten.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

import pymunk

Push = Callable[[float, float, float], None]
"""Apply a force (N, N) to the body and let the space advance by a time (s)."""

Read = Callable[[], list[tuple[float, float, float]]]
"""Return x, y (m) and angle (rad) of every body, and drop what contacts would still push it next."""


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


def fast_crowd_push(
    space: pymunk.Space, body: pymunk.Body, crowd: Sequence[pymunk.Body], forces: list[tuple[float, float]]
) -> Push:
    """Return a `Push` that also applies the `forces` that stand in the list then, one for each body of the crowd."""
    push = fast_push(space, body)
    try:
        from pymunk._chipmunk_cffi import lib

        set_force, pointers = lib.cpBodySetForce, [one._body for one in crowd]
    except (ImportError, AttributeError):
        return plain_crowd_push(space, body, crowd, forces)

    def push_all(force_x: float, force_y: float, dt: float) -> None:
        for pointer, force in zip(pointers, forces, strict=True):
            set_force(pointer, force)
        push(force_x, force_y, dt)

    return push_all


def plain_crowd_push(
    space: pymunk.Space, body: pymunk.Body, crowd: Sequence[pymunk.Body], forces: list[tuple[float, float]]
) -> Push:
    """Return the same by pymunk's public methods alone."""
    push = plain_push(space, body)

    def push_all(force_x: float, force_y: float, dt: float) -> None:
        for one, force in zip(crowd, forces, strict=True):
            one.force = force
        push(force_x, force_y, dt)

    return push_all


def fast_read(bodies: Sequence[pymunk.Body]) -> Read:
    """Return a function that tells where bodies are, by direct calls of Chipmunk, or `plain_read` without them."""
    try:
        from pymunk._chipmunk_cffi import lib

        update, position, angle = lib.cpBodyUpdatePosition, lib.cpBodyGetPosition, lib.cpBodyGetAngle
        pointers = [body._body for body in bodies]
    except (ImportError, AttributeError):
        return plain_read(bodies)

    def read() -> list[tuple[float, float, float]]:
        found = []
        for pointer in pointers:
            update(pointer, 0.0)
            place = position(pointer)
            found.append((place.x, place.y, angle(pointer)))
        return found

    return read


def plain_read(bodies: Sequence[pymunk.Body]) -> Read:
    """Return the same by pymunk's public methods alone."""

    def read() -> list[tuple[float, float, float]]:
        found = []
        for body in bodies:
            pymunk.Body.update_position(body, 0.0)
            found.append((*body.position, body.angle))
        return found

    return read

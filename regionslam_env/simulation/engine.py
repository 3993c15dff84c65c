"""Chipmunk called from inside a compiled kernel, by the addresses of its functions.

From Python, ten substeps take several times as long as the engine itself works.
"""

from __future__ import annotations

import platform
import sys
from typing import Any

import numba
import numpy as np
import pymunk
from llvmlite import ir
from numba.core import types
from numba.extending import intrinsic
from numpy.typing import NDArray

from slam.jit import njit

SET_FORCE, ADVANCE, SET_POSITION, SET_VELOCITY, POSITION, VELOCITY, UPDATE, SPACE, BODY = range(9)
"""Places of the addresses in an engine: functions, then the space and the body."""

_FUNCTIONS = (
    "cpBodySetForce",
    "cpSpaceStep",
    "cpBodySetPosition",
    "cpBodySetVelocity",
    "cpBodyGetPosition",
    "cpBodyGetVelocity",
    "cpBodyUpdatePosition",
)

Engine = NDArray[np.int64]
"""Addresses, shape (9,), or none, shape (0,)."""

NO_ENGINE: Engine = np.zeros(0, np.int64)
"""Says that the engine is to be called from Python."""


def engine_of(space: pymunk.Space, body: pymunk.Body) -> Engine:
    """Return the addresses of a space and a body in it, or `NO_ENGINE` where a kernel cannot call them.

    The space must hold the body already, and both must outlive the addresses.
    """
    # Two numbers by value go in registers there, as two arguments do.
    in_registers = sys.platform != "win32" and platform.machine().lower() in ("x86_64", "amd64", "aarch64", "arm64")
    if numba.config.DISABLE_JIT or not in_registers:
        return NO_ENGINE
    try:
        from pymunk._chipmunk_cffi import ffi, lib

        pointers = [*(ffi.addressof(lib, name) for name in _FUNCTIONS), space._space, body._body]
    except (ImportError, AttributeError):  # another release of pymunk may keep its engine elsewhere
        return NO_ENGINE
    return np.array([int(ffi.cast("uintptr_t", pointer)) for pointer in pointers], np.int64)


@intrinsic
def _give_time(typing_context: Any, function: Any, thing: Any, seconds: Any) -> Any:
    """Call ``void function(thing *, double)``."""

    def generate(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        kind = ir.FunctionType(ir.VoidType(), [ir.IntType(8).as_pointer(), ir.DoubleType()])
        _call(builder, kind, arguments)
        return context.get_dummy_value()

    return types.void(types.int64, types.int64, types.float64), generate


@intrinsic
def _give_pair(typing_context: Any, function: Any, thing: Any, first: Any, second: Any) -> Any:
    """Call ``void function(thing *, cpVect)``."""

    def generate(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        kind = ir.FunctionType(ir.VoidType(), [ir.IntType(8).as_pointer(), ir.DoubleType(), ir.DoubleType()])
        _call(builder, kind, arguments)
        return context.get_dummy_value()

    return types.void(types.int64, types.int64, types.float64, types.float64), generate


@intrinsic
def _take_pair(typing_context: Any, function: Any, thing: Any) -> Any:
    """Call ``cpVect function(thing *)``."""
    pair = types.UniTuple(types.float64, 2)

    def generate(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        both = ir.LiteralStructType([ir.DoubleType(), ir.DoubleType()])
        found = _call(builder, ir.FunctionType(both, [ir.IntType(8).as_pointer()]), arguments)
        return context.make_tuple(builder, pair, [builder.extract_value(found, k) for k in range(2)])

    return pair(types.int64, types.int64), generate


def _call(builder: Any, kind: Any, arguments: Any) -> Any:
    """Call the function at the first argument with a pointer, the second one, and the rest."""
    function = builder.inttoptr(arguments[0], kind.as_pointer())
    return builder.call(function, [builder.inttoptr(arguments[1], kind.args[0]), *arguments[2:]])


@njit
def put(engine: Engine, x: float, y: float, speed_x: float, speed_y: float) -> None:
    """Put the body at a position (m) with a velocity (m/s)."""
    _give_pair(engine[SET_POSITION], engine[BODY], x, y)
    _give_pair(engine[SET_VELOCITY], engine[BODY], speed_x, speed_y)


@njit
def push(engine: Engine, force_x: float, force_y: float, dt: float) -> None:
    """Apply a force (N, N) to the body and let the space advance by a time (s)."""
    _give_pair(engine[SET_FORCE], engine[BODY], force_x, force_y)
    _give_time(engine[ADVANCE], engine[SPACE], dt)


@njit
def read(engine: Engine) -> tuple[float, float, float, float]:
    """Return position (m) and velocity (m/s) of the body, and drop what contacts would still push it next."""
    x, y = _take_pair(engine[POSITION], engine[BODY])
    speed_x, speed_y = _take_pair(engine[VELOCITY], engine[BODY])
    _give_time(engine[UPDATE], engine[BODY], 0.0)
    return x, y, speed_x, speed_y

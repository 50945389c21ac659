"""Calls of foreign functions by address, in compiled code.

numba can call a function of ctypes, but writes its address into the code, which then cannot be kept for the next start.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, cast

from llvmlite import ir
from numba.core import cgutils, types
from numba.extending import intrinsic


def _call(typing_context: Any, function: Any, *arguments: Any) -> Any:  # noqa: ANN401  numba's own types
    """Call the C function at the address `function` with integers and addresses; what it returns is dropped."""
    signature = types.void(types.uint64, types.StarArgTuple([types.uint64] * len(arguments)))

    def generate(context: Any, builder: Any, signature: Any, given: Any) -> Any:  # noqa: ANN401
        integer = ir.IntType(64)
        values = cgutils.unpack_tuple(builder, given[1])
        kind = ir.FunctionType(ir.VoidType(), [integer] * len(values))
        builder.call(builder.inttoptr(given[0], kind.as_pointer()), values)
        return context.get_dummy_value()

    return signature, generate


def _pointer(typing_context: Any, address: Any) -> Any:  # noqa: ANN401
    """Return an address as the pointer that `numba.carray` takes."""

    def generate(context: Any, builder: Any, signature: Any, given: Any) -> Any:  # noqa: ANN401
        return builder.inttoptr(given[0], context.get_value_type(types.voidptr))

    return types.voidptr(types.uint64), generate


# The type checker is to see them as they are called: without numba's context.
call = cast("Callable[..., None]", intrinsic(_call))
pointer = cast("Callable[[Any], Any]", intrinsic(_pointer))

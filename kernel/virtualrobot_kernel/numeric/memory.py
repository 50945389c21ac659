"""Arrays at addresses, in compiled code: one table of numbers names many arrays of different shapes.

A call takes a table in place of the arrays, which costs it nothing for each of them. Whoever puts an address into a
table keeps the memory there for as long as the table is used.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numba import types
from numba.extending import intrinsic
from numba.np.numpy_support import carray
from virtualrobot_sdk.compiled.cache import inlined

Floats = np.ndarray[Any, np.dtype[np.float64]]
Integers = np.ndarray[Any, np.dtype[np.int64]]


def _pointer(kind: Any) -> tuple[Any, Any]:  # noqa: ANN401  numba's own types
    """Return signature and code of what makes an address a pointer to numbers of a kind."""

    def code(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:  # noqa: ANN401
        return builder.inttoptr(arguments[0], context.get_value_type(signature.return_type))

    return types.CPointer(kind)(types.int64), code


def _to_floats(typing: Any, address: Any) -> tuple[Any, Any]:  # noqa: ANN401
    return _pointer(types.float64)


def _to_integers(typing: Any, address: Any) -> tuple[Any, Any]:  # noqa: ANN401
    return _pointer(types.int64)


def _fence(typing: Any) -> tuple[Any, Any]:  # noqa: ANN401
    def code(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:  # noqa: ANN401
        builder.fence("release")
        return context.get_dummy_value()

    return types.void(), code


_float_pointer: Any = intrinsic(_to_floats)
_integer_pointer: Any = intrinsic(_to_integers)
fence: Any = intrinsic(_fence)
"""Function by which all that was written before is seen by other processes before all that is written after."""


@inlined
def floats_at(address: int, count: int) -> Floats:
    """Return the floats (count,) at an address."""
    return carray(_float_pointer(address), (count,))


@inlined
def integers_at(address: int, count: int) -> Integers:
    """Return the integers (count,) at an address."""
    return carray(_integer_pointer(address), (count,))


def address_of(array: Floats | Integers) -> int:
    """Return where the numbers of an array are, which must follow each other as in C."""
    if not array.flags.c_contiguous:
        raise ValueError("only of a contiguous array one address tells where all numbers are")
    return array.__array_interface__["data"][0]


def read_only(array: Any) -> Any:  # noqa: ANN401  an array of any type
    """Return an array as one that nobody writes by: compiled code takes such ones in tuples."""
    view = array.view()
    view.setflags(write=False)
    return view

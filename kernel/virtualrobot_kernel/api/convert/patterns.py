"""Places of patterns, as on a pallet: how many there are, and where each is."""

from __future__ import annotations

from collections.abc import Callable, Iterator

import numpy as np
from numpy.typing import NDArray
from virtualrobot.v1 import motion_pb2

from virtualrobot_kernel.errors import KernelError
from virtualrobot_kernel.messages.values import check_enum, finite, pose, vector
from virtualrobot_kernel.units import degrees_question, millimetres_question


def place_count(pattern: motion_pb2.Pattern, what: str) -> int:
    """Return the number of places of a pattern; raise KernelError that names the field that is wrong."""
    for name in ("columns", "rows"):
        if not getattr(pattern, name):
            raise KernelError(f"{what}.{name} must be at least 1", field=f"{what}.{name}")
    return pattern.columns * pattern.rows * (pattern.layers or 1)


def places(pattern: motion_pb2.Pattern, what: str) -> Iterator[NDArray[np.float64]]:
    """Yield reference_t_place (4, 4) of each place in order; raise KernelError that names the field that is wrong."""
    check_enum(pattern, "order")
    pitches = ("column_pitch_meters", "row_pitch_meters", "layer_pitch_meters")
    across, along, up = (_meant(getattr(pattern, name), f"{what}.{name}", millimetres_question) for name in pitches)
    turn = _meant(pattern.layer_turn_radians, f"{what}.layer_turn_radians", degrees_question)
    offset = np.array(vector(pattern.layer_offset, f"{what}.layer_offset"))
    for value in offset:
        _meant(value, f"{what}.layer_offset", millimetres_question)
    base = np.eye(4)
    if pattern.HasField("reference_t_pattern"):
        base = pose(pattern.reference_t_pattern, f"{what}.reference_t_pattern")
    rotation = np.eye(4)
    rotation[:2, :2] = [[np.cos(turn), -np.sin(turn)], [np.sin(turn), np.cos(turn)]]
    for layer in range(pattern.layers or 1):
        frame = base.copy()
        if layer % 2:
            shift = np.eye(4)
            shift[:3, 3] = offset
            frame = base @ shift @ rotation
        for column, row in _in_order(pattern):
            place = np.eye(4)
            place[:3, 3] = (
                (column - (pattern.columns - 1) / 2) * across,
                (row - (pattern.rows - 1) / 2) * along,
                layer * up,
            )
            yield frame @ place


def _meant(value: float, what: str, question: Callable[[float], str]) -> float:
    """Return a finite number; raise KernelError where its size asks whether it is in another unit."""
    if asked := question(finite(value, what)):
        raise KernelError(f"{what} is too large{asked}", field=what)
    return value


def _in_order(pattern: motion_pb2.Pattern) -> Iterator[tuple[int, int]]:
    """Yield column and row of each place of a layer in order."""
    by_row = pattern.order in (motion_pb2.PATTERN_ORDER_ROW_BY_ROW, motion_pb2.PATTERN_ORDER_ROWS_TO_AND_FRO)
    returns = pattern.order in (
        motion_pb2.PATTERN_ORDER_COLUMNS_TO_AND_FRO,
        motion_pb2.PATTERN_ORDER_ROWS_TO_AND_FRO,
    )
    outer, inner = (pattern.rows, pattern.columns) if by_row else (pattern.columns, pattern.rows)
    for one in range(outer):
        for other in reversed(range(inner)) if returns and one % 2 else range(inner):
            yield (other, one) if by_row else (one, other)

"""Joint positions that are told: arrays that can only be read, since changing one would move nothing."""

from __future__ import annotations

from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from virtualrobot.errors import InvalidArgumentError


class ReadOnlyPositions(np.ndarray[Any, np.dtype[np.float64]]):
    """Positions of joints as they are told; what is computed of them, and a copy, are arrays as any others.

    Example:
        >>> goal = robot.positions.copy()
        >>> goal[0] += 0.1
    """

    def __setitem__(self, key: Any, value: Any) -> None:  # noqa: ANN401 as NumPy has it
        """Refuse, and say what moves the joints."""
        if not self.flags.writeable:
            _refuse()
        super().__setitem__(key, value)

    def __array_ufunc__(
        self,
        ufunc: np.ufunc,
        method: Literal["__call__", "reduce", "reduceat", "accumulate", "outer", "at"],
        *inputs: Any,  # noqa: ANN401 as NumPy has it
        **options: Any,  # noqa: ANN401
    ) -> Any:  # noqa: ANN401
        """Compute with plain arrays; refuse to write the result here, as `positions += 0.1` would."""
        out = options.pop("out", ())
        if any(isinstance(one, ReadOnlyPositions) and not one.flags.writeable for one in out):
            _refuse()
        if out:
            options["out"] = tuple(map(_plain, out))
        return getattr(ufunc, method)(*map(_plain, inputs), **options)

    def copy(self, order: Literal["K", "A", "C", "F"] | None = "C") -> NDArray[np.float64]:
        """Return a plain array that can be changed."""
        return np.array(self, order=order)

    def __repr__(self) -> str:
        """Return what a plain array shows."""
        return repr(np.asarray(self))


def read_only(values: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return values by whose change nobody should think to change anything."""
    values.flags.writeable = False
    return values.view(ReadOnlyPositions)


def _plain(value: Any) -> Any:  # noqa: ANN401
    return np.asarray(value) if isinstance(value, ReadOnlyPositions) else value


def _refuse() -> None:
    raise InvalidArgumentError(
        "these positions only tell where the joints are: set_positions puts joints elsewhere, move_joints moves them, "
        "and positions.copy() is an array to compute with"
    )

"""Numbers in the JSON of pages."""

from __future__ import annotations

import math

from virtualrobot.errors import InvalidArgumentError


def numbers(said: object, name: str, *counts: int) -> list[float]:
    """Return the finite numbers of a list of one of these lengths; raise InvalidArgumentError with the field's name."""
    if isinstance(said, list) and len(said) in counts and all(_is_finite(one) for one in said):
        return [float(one) for one in said]
    wanted = f"{' or '.join(map(str, counts))} finite number{'' if counts == (1,) else 's'}"
    raise InvalidArgumentError(f"{name!r} is {wanted}, not {said!r:.80}")


def _is_finite(said: object) -> bool:
    return isinstance(said, int | float) and not isinstance(said, bool) and math.isfinite(said)

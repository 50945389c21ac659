"""Seed of a suite or a grade that names none."""

from __future__ import annotations

import os
import secrets


def seed_or_drawn(seed: int | None) -> int:
    """Return the seed, or that of VIRTUALROBOT_TEST_SEED where there is none, or one drawn anew."""
    if seed is not None:
        return seed
    return int(os.environ.get("VIRTUALROBOT_TEST_SEED") or secrets.randbits(32))

"""Rays by Embree: scenes that a thread poses and casts rays into, against shapes that all threads share."""

from virtualrobot_sdk.embree.availability import unavailable
from virtualrobot_sdk.embree.library import EmbreeError
from virtualrobot_sdk.embree.top import TopScene, Traced

__all__ = ["EmbreeError", "TopScene", "Traced", "unavailable"]

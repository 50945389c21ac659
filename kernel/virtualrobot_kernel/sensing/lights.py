"""The lights of a world as one table."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from virtualrobot_sdk.srgb import to_linear

from virtualrobot_kernel.numeric.illumination import LIGHT_FIELDS
from virtualrobot_kernel.world.sensing import Light
from virtualrobot_kernel.world.state import Snapshot
from virtualrobot_kernel.world.structure import Kind
from virtualrobot_kernel.world.visibility import inherited_visibility

CONE = 0.5
"""Between axis and edge of a spot's cone where it is not said, in radians."""
FADING = 0.9
"""From this part of the angle on a spot fades, smoothly, to nothing at the edge."""


@dataclass(frozen=True, slots=True, eq=False)
class Lights:
    """The k lights of a world.

    Attributes:
        table: (k, LIGHT_FIELDS) as `numeric.illumination` has it, in the world's frame.
        shadowing: (k,) whether things in a light's way keep what is behind them dark.
    """

    table: NDArray[np.float32]
    shadowing: NDArray[np.bool_]


NONE = Lights(np.zeros((0, LIGHT_FIELDS), np.float32), np.zeros(0, np.bool_))
"""Light of each camera where a scene has none."""


def lights_of(snapshot: Snapshot) -> Lights:
    """Return the lights of a world; a hidden one is off."""
    structure = snapshot.structure
    nodes = [node for node in structure.nodes.values() if node.kind is Kind.LIGHT]
    if not nodes:
        return NONE
    hidden, _ = inherited_visibility(structure, snapshot.state.tool_states)
    lit = [
        light_row(node.data, snapshot.world_t_node[structure.rows[node.uid]])
        for node in nodes
        if isinstance(node.data, Light) and not hidden[node.uid]
    ]
    shadowing = [not node.data.shadowless for node in nodes if isinstance(node.data, Light) and not hidden[node.uid]]
    if not lit:  # all are off, and the camera's own does not come on for that
        return Lights(np.zeros((1, LIGHT_FIELDS), np.float32), np.zeros(1, np.bool_))
    return Lights(np.array(lit, np.float32), np.array(shadowing, np.bool_))


def light_row(light: Light, world_t_light: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the row (LIGHT_FIELDS,) of one light at a place."""
    red, green, blue = (light.intensity or 1.0) * to_linear((light.color or (1.0, 1.0, 1.0))[:3])
    angle = light.cone_angle_radians or CONE
    return np.array(
        [
            light.kind.value,
            *world_t_light[:3, 3],
            *world_t_light[:3, 2],
            *(red, green, blue),
            *(math.cos(angle), math.cos(FADING * angle)),
        ]
    )

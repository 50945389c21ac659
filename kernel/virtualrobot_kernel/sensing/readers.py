"""Readers of each kind of sensor, and what they are made of."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field

from virtualrobot_kernel.collision.geometry import CollisionShapes
from virtualrobot_kernel.components.catalog import Catalog
from virtualrobot_kernel.sensing.appearance import AppearanceLibrary
from virtualrobot_kernel.sensing.camera_reader import CameraReader
from virtualrobot_kernel.sensing.contact_reader import ContactReader
from virtualrobot_kernel.sensing.motion_reader import MotionReader
from virtualrobot_kernel.sensing.range_reader import RangeReader
from virtualrobot_kernel.sensing.reading import Reader
from virtualrobot_kernel.sensing.settings import Presets
from virtualrobot_kernel.shapes.shape_library import ShapeLibrary
from virtualrobot_kernel.world.state import Snapshot
from virtualrobot_kernel.world.structure import Kind, Node


@dataclass(frozen=True, slots=True, eq=False)
class SensingRoom:
    """Parts that readers are made of.

    Attributes:
        catalog: the components that are installed.
        shapes: figures for rays.
        looks: what figures look like.
        solids: figures that touch.
        presets: devices that range sensors may be set as.
    """

    catalog: Catalog
    shapes: ShapeLibrary
    looks: AppearanceLibrary
    solids: CollisionShapes
    presets: Presets = field(default_factory=dict)


READERS: dict[Kind, Callable[[Snapshot, Node, SensingRoom], Reader]] = {
    Kind.CAMERA_SENSOR: lambda snapshot, node, room: CameraReader(node, room.shapes, room.looks),
    Kind.CONTACT_SENSOR: lambda snapshot, node, room: ContactReader(snapshot, node, room.solids),
    Kind.MOTION_SENSOR: lambda snapshot, node, room: MotionReader(snapshot, node),
    Kind.RANGE_SENSOR: lambda snapshot, node, room: RangeReader(node, room.catalog, room.shapes, room.presets),
}
"""Makes the reader of a sensor from its node and the world as it is; raises KernelError when it cannot be made."""

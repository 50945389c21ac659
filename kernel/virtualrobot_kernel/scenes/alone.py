"""A known model in a world of its own, of which nobody else knows."""

from __future__ import annotations

from virtualrobot.v1 import scene_pb2

from virtualrobot_kernel.formats.mesh_library import MeshLibrary
from virtualrobot_kernel.scenes.assets import files_of
from virtualrobot_kernel.scenes.models import read_model
from virtualrobot_kernel.world import index
from virtualrobot_kernel.world.apply import apply
from virtualrobot_kernel.world.change import Change, Forward
from virtualrobot_kernel.world.commands import Command, CreateNodes, SetJointPositions
from virtualrobot_kernel.world.state import Snapshot, empty_state
from virtualrobot_kernel.world.structure import RobotData

TICK_SECONDS = 0.004
"""Length of a tick of a world in which no time passes."""


def model_alone(uri: str, meshes: MeshLibrary, forward: Forward) -> Snapshot:
    """Return a world with nothing but a model, its robots in the posture `home`, or else their first, if they have any.

    Raises:
        KernelError: the model can't be read.
    """
    model = read_model(meshes, scene_pb2.ModelSource(uri=uri), files_of(meshes, ()), ())
    change = Change(index.empty(), empty_state())
    change = _after(change, CreateNodes(model.nodes), forward)
    for spec in model.nodes:
        if isinstance(spec.data, RobotData) and (postures := spec.data.postures):
            posture = postures.get("home") or next(iter(postures.values()))
            change = _after(change, SetJointPositions(spec.name, posture), forward)
    world_t_node = forward(change.structure, change.state)
    return Snapshot(change.structure, change.state, world_t_node, 1, 0.0, TICK_SECONDS)


def _after(change: Change, command: Command, forward: Forward) -> Change:
    return apply(change.structure, change.state, [command], forward)

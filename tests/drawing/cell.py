"""A world without a thread, for pictures of it: commands are applied at once and make a new snapshot."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from virtualrobot.files.resolver import Resolver
from virtualrobot_kernel.formats.assets import AssetStore
from virtualrobot_kernel.formats.files import Files
from virtualrobot_kernel.formats.mesh_library import MeshLibrary
from virtualrobot_kernel.formats.models import ImportedModel, import_model
from virtualrobot_kernel.numeric.forest import forward_forest
from virtualrobot_kernel.shapes.submesh import Submesh
from virtualrobot_kernel.world import index
from virtualrobot_kernel.world.apply import apply
from virtualrobot_kernel.world.commands import Command, CreateNodes
from virtualrobot_kernel.world.figures import Figure, Mesh, Pose
from virtualrobot_kernel.world.state import Snapshot, State, empty_state
from virtualrobot_kernel.world.structure import Kind, NodeData, NodeSpec, RobotData, Structure

from tests.pybullet_models import pybullet_data

TICK_SECONDS = 0.004


def forward(structure: Structure, state: State) -> np.ndarray:
    """Return world_t_node (N, 4, 4) of a state."""
    world_t_node = np.empty((len(structure.nodes), 4, 4))
    forest = structure.forest
    forward_forest(
        forest.order,
        forest.parent,
        forest.joint_type,
        forest.axis,
        forest.q_index,
        forest.multiplier,
        forest.offset,
        state.parent_t_node,
        state.q,
        world_t_node,
    )
    return world_t_node


def at(x: float, y: float, z: float) -> Pose:
    """Return a pose (4, 4) that shifts only, in meters."""
    pose = np.eye(4)
    pose[:3, 3] = x, y, z
    return pose


class Cell:
    """Holds the newest snapshot, which a viewer may read at any time."""

    def __init__(self) -> None:
        """Begin with an empty world."""
        self.library = MeshLibrary(AssetStore())
        self.told: dict[str, tuple[Submesh, ...]] = {}
        self._files = Files(self.library.store, resolver=Resolver())
        structure = index.empty()
        self.snapshot = self._pictured(structure, empty_state())

    def do(self, *commands: Command) -> None:
        """Apply commands."""
        change = apply(self.snapshot.structure, self.snapshot.state, commands, forward)
        self.snapshot = self._pictured(change.structure, change.state)

    def add(
        self,
        name: str,
        *figures: Figure,
        parent: str = "world",
        pose: Pose | None = None,
        kind: Kind = Kind.OBJECT,
        data: NodeData = None,
    ) -> None:
        """Add a node."""
        pose = np.eye(4) if pose is None else pose
        data = RobotData() if data is None and kind is Kind.ROBOT else data
        self.do(CreateNodes((NodeSpec(name, kind, parent, pose, figures=figures, data=data),)))

    def load(self, path: str, name: str, pose: Pose | None = None, parent: str = "world") -> None:
        """Add a model of pybullet_data."""
        uri = str(Path(pybullet_data.getDataPath()) / path)
        model = import_model(
            uri,
            self._files,
            self.library,
            name=name,
            parent=parent,
            parent_t_node=pose,
            taken=self.snapshot.structure.uid_by_name,
        )
        assert isinstance(model, ImportedModel)
        self.do(CreateNodes(model.nodes))

    def meshes(self, mesh: Mesh) -> tuple[Submesh, ...]:
        """Return the triangles of a mesh: those in `told` by URI, or those of its file."""
        return self.told.get(mesh.uri) or self.library.load(mesh)

    def uid(self, name: str) -> int:
        """Return the uid of a node."""
        return self.snapshot.structure.node(name).uid

    def _pictured(self, structure: Structure, state: State) -> Snapshot:
        return Snapshot(structure, state, forward(structure, state), 0, 0.0, TICK_SECONDS)

"""World in the memory of a program, without server, clock and threads: for studies, which ask of thousands of cells.

Nobody watches it, so nothing of it is kept but one snapshot. Who goes back to its beginning takes the first one again.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from virtualrobot_kernel.api.convert.presets import presets
from virtualrobot_kernel.collision.allowed import Pair
from virtualrobot_kernel.collision.arm_contacts import ArmContacts
from virtualrobot_kernel.collision.built import built_pairs
from virtualrobot_kernel.collision.geometry import CollisionShapes
from virtualrobot_kernel.collision.scene import CollisionScene
from virtualrobot_kernel.components.catalog import Catalog
from virtualrobot_kernel.components.importing import Importers
from virtualrobot_kernel.errors import KernelError, MissingFileError, UnknownNameError
from virtualrobot_kernel.formats import scene_file
from virtualrobot_kernel.formats.assets import AssetStore
from virtualrobot_kernel.formats.mesh_cache import MeshCache
from virtualrobot_kernel.formats.mesh_library import MeshLibrary
from virtualrobot_kernel.formats.xml import FileWarning
from virtualrobot_kernel.planning.branches import branches, without_turns
from virtualrobot_kernel.planning.kinematic_errors import KinematicErrors
from virtualrobot_kernel.planning.robots import Arm, arm_of, tcp_frame, tip_t_tcp, with_state, world_poses
from virtualrobot_kernel.planning.solvers import Solvers
from virtualrobot_kernel.scenes.assets import files_of
from virtualrobot_kernel.scenes.reading import read_scene
from virtualrobot_kernel.sensing.sight import Sight
from virtualrobot_kernel.shapes.shape_library import ShapeLibrary
from virtualrobot_kernel.world import index
from virtualrobot_kernel.world.apply import apply
from virtualrobot_kernel.world.commands import (
    Command,
    SetAllowedPairs,
    SetJointPositions,
    SetKinematics,
    UpdateNode,
)
from virtualrobot_kernel.world.state import Snapshot, empty_state
from virtualrobot_kernel.world.structure import Kind, RobotData

Floats = NDArray[np.float64]

_TICK_SECONDS = 0.004
TABLE = "dh"
"""Component by which robots of Denavit-Hartenberg tables are solved where nothing else is chosen."""
NO_MODELS: Mapping[str, str] = {}


class Postures(NamedTuple):
    """Postures of a robot at n poses, m together.

    Attributes:
        target: (m,) which pose each is for, ascending.
        positions: (m, k) of the joints, rad or m.
        free: (m,) which touch nothing.
        touching: (m) two names of nodes that touch, or None.
    """

    target: NDArray[np.int64]
    positions: Floats
    free: NDArray[np.bool_]
    touching: tuple[tuple[str, str] | None, ...]


class EmbeddedWorld:
    """World of a scene file; used by one thread at a time."""

    def __init__(self, scene: Path, models: Mapping[str, str] = NO_MODELS) -> None:
        """Load a scene file; robots that `models` has by name are made of other models, such as `model://ur10e`.

        Raises:
            KernelError: when something in it, or in a file that it names, is wrong or missing; for a name in `models`
                that is none of the scene's models.
        """
        catalog = Catalog()
        self._solvers, self._importers = Solvers(catalog), Importers(catalog)
        meshes = MeshLibrary(AssetStore(), self._importers, cache=MeshCache())
        shapes = CollisionShapes(meshes.load)
        structure, state = index.empty(), empty_state()
        self._now = Snapshot(structure, state, world_poses(structure, state), 0, 0.0, _TICK_SECONDS)
        self._scene, self._sight = CollisionScene(shapes), Sight(catalog, ShapeLibrary(meshes.load), presets())
        self._arms: dict[str, _Standing] = {}
        self._apply(scene_commands(scene, meshes, self._now, shapes, models)[0])
        # A table is a search's too, which knows one posture; the tree that it has made has a closed form perhaps.
        robots = (self._now.structure.nodes[uid] for uid in self._now.structure.robots)
        tables = [one.name for one in robots if isinstance(one.data, RobotData) and one.data.kinematics == TABLE]
        self._apply([SetKinematics(name, "", {}) for name in tables])
        self._begin = self._now

    def restore(self) -> None:
        """Go back to the world as it was loaded."""
        self._now = self._begin

    def place(self, node: str, parent_t_node: ArrayLike) -> None:
        """Put a node, such as a robot's base, elsewhere on its parent: parent_t_node (4, 4), m.

        Raises:
            KernelError: when there is no such node, or this is no pose.
        """
        pose = np.array(parent_t_node, np.float64)
        if pose.shape != (4, 4) or not np.isfinite(pose).all():
            raise KernelError(f"the pose of {node!r} is (4, 4) and finite, not {pose.tolist()}", field="parent_t_node")
        self._apply([UpdateNode(node, parent_t_node=pose)])

    def set_joints(self, robot: str, positions: Mapping[str, float]) -> None:
        """Put joints elsewhere, by name, rad or m; raise KernelError for others, or beyond limits."""
        self._apply([SetJointPositions(robot, dict(positions))])

    def pose(self, node: str) -> Floats:
        """Return world_t_node (4, 4); raise KernelError when there is no such node."""
        return self._now.world_t(self._now.structure.node(node).uid).copy()

    def parent_pose(self, node: str) -> Floats:
        """Return parent_t_node (4, 4); raise KernelError when there is no such node."""
        return self._now.state.parent_t_node[self._now.structure.rows[self._now.structure.node(node).uid]].copy()

    def tool_pose(self, robot: str) -> Floats:
        """Return world_t_tcp (4, 4) of the chosen tool centre point, without a tool the flange."""
        return tcp_frame(self._now, self._now.structure.node(robot, Kind.ROBOT)).copy()

    def joints(self, robot: str) -> dict[str, float]:
        """Return where the joints are that lead the tool centre point, by name (rad or m)."""
        arm = arm_of(self._now, self._now.structure.node(robot, Kind.ROBOT))
        return dict(zip(arm.joint_names, self._now.state.q[arm.q_index].tolist(), strict=True))

    def joint_limits(self, robot: str) -> Floats:
        """Return the limits (k, 2) of the joints that lead the tool centre point (rad or m)."""
        chain = arm_of(self._now, self._now.structure.node(robot, Kind.ROBOT)).serial()
        return np.stack([chain.lower, chain.upper], axis=1)

    def postures(self, robot: str, world_t_tcp: ArrayLike) -> Postures:
        """Return all postures that bring the tool centre point to poses (n, 4, 4), and which touch nothing.

        Each branch is there once, without full turns. Seven joints have endlessly many: there a search gives some.
        Asked is what touches while the arm alone moves, of pairs that it moves against each other; all others are
        `contacts`.

        Raises:
            KernelError: when there is no such robot, no component solves it, or these are no poses.
        """
        poses = np.array(world_t_tcp, np.float64)
        if poses.ndim != 3 or poses.shape[1:] != (4, 4) or not np.isfinite(poses).all():
            raise KernelError(f"poses are (n, 4, 4) and finite, not {poses.shape}", field="world_t_tcp")
        at = self._standing(robot)
        found = branches(self._now, at.arm, poses, self._solvers.of)
        touching = tuple(map(self._names, at.contacts.contacts(found.positions)))
        free = np.array([pair is None for pair in touching], np.bool_)
        return Postures(found.target, found.positions, free, touching)

    def contacts(self, robot: str) -> list[tuple[str, str]]:
        """Return the names of what touches and may not wherever the arm is, such as a robot's base and a wall."""
        return [self._named(pair) for pair in self._standing(robot).contacts.standing()]

    def touching(self, robot: str, joints: ArrayLike) -> tuple[str, str] | None:
        """Return the names of two nodes that touch and may not with the arm's joints (k,) there (rad or m), or None.

        Asked is what `postures` asks; nothing is moved.

        Raises:
            KernelError: when there is no such robot, or these are no such joints.
        """
        at, positions = self._standing(robot), np.array(joints, np.float64)
        if positions.shape != at.arm.q_index.shape or not np.isfinite(positions).all():
            said = f"the {len(at.arm.q_index)} joints of {robot!r} are finite numbers, not {positions.tolist()}"
            raise KernelError(said, field="joints")
        return self._names(at.contacts.contact(positions))

    def kinematic_errors(self, robot: str) -> KinematicErrors:
        """Return a robot's chain up to its tool centre point, with errors to plant and to find, in its base's frame."""
        arm = arm_of(self._now, self._now.structure.node(robot, Kind.ROBOT))
        return KinematicErrors(arm.serial(), tip_t_tcp(self._now, arm))

    def seen(self, sensor: str, points: ArrayLike, within: float = 0.0) -> NDArray[np.bool_]:
        """Return which of points (n, 3), m in the world, a sensor sees, with nothing before them: (n,).

        A pinhole camera sees what is in its picture, a range sensor what one of its beams passes within so many meters.

        Raises:
            KernelError: when there is no such sensor, or these are no points.
        """
        places = np.array(points, np.float64)
        if places.ndim != 2 or places.shape[1] != 3 or not np.isfinite(places).all():
            raise KernelError(f"points are (n, 3) and finite, not {places.shape}", field="points")
        return self._sight.seen(self._now, self._now.structure.node(sensor), places, within)

    def close(self) -> None:
        """End the processes of components that have any."""
        self._sight.close()
        self._solvers.close()
        self._importers.close()

    def _apply(self, commands: list[Command]) -> None:
        now = self._now
        change = apply(now.structure, now.state, commands, world_poses)
        self._now = with_state(now, change.state, change.structure)

    def _standing(self, robot: str) -> _Standing:
        at = self._arms.get(robot)
        if at is None or not at.still_holds(self._now):
            now = self._now
            arm = without_turns(arm_of(now, now.structure.node(robot, Kind.ROBOT)))
            at = self._arms[robot] = _Standing(now, arm, ArmContacts(self._scene, now, arm.q_index))
        return at

    def _names(self, pair: Pair | None) -> tuple[str, str] | None:
        return None if pair is None else self._named(pair)

    def _named(self, pair: Pair) -> tuple[str, str]:
        first, second = (self._now.structure.nodes[uid].name for uid in pair)
        return first, second


@dataclass(frozen=True, slots=True, eq=False)
class _Standing:
    """Arm where all else stands as in a snapshot."""

    snapshot: Snapshot
    arm: Arm
    contacts: ArmContacts

    def still_holds(self, now: Snapshot) -> bool:
        """Return whether at most the arm's own joints are elsewhere by now."""
        if now is self.snapshot:
            return True
        before, state = self.snapshot.state, now.state
        if now.structure is not self.snapshot.structure or state.allowed_pairs is not before.allowed_pairs:
            return False
        others = np.ones(len(state.q), np.bool_)
        others[self.arm.q_index] = False
        return np.array_equal(state.q[others], before.q[others]) and np.array_equal(
            state.parent_t_node, before.parent_t_node
        )


def scene_commands(
    path: Path,
    meshes: MeshLibrary,
    begin: Snapshot,
    shapes: CollisionShapes,
    models: Mapping[str, str] = NO_MODELS,
) -> tuple[list[Command], list[FileWarning]]:
    """Return the commands that make the world of a scene file on the disk, and what is odd about it.

    Robots that `models` has by name are made of these models.

    Raises:
        KernelError: for what is wrong in the file; MISSING_FILE when it, or one that it names, isn't there.
    """
    try:
        text = path.read_text("utf-8")
    except (OSError, UnicodeDecodeError) as error:
        raise MissingFileError(f"cannot read the scene file {path}: {error}", file=path) from error
    if models:
        text = _with_models(text, str(path), models)
    commands, warnings, of_models = read_scene(text, str(path.resolve()), files_of(meshes, ()), meshes)
    pairs = built_pairs(begin, commands, shapes, of_models)
    return commands + ([SetAllowedPairs(built=pairs)] if pairs else []), warnings


def _with_models(text: str, uri: str, models: Mapping[str, str]) -> str:
    """Return the text of a scene file whose robots of these names are other models."""
    scene = scene_file.parse(text, uri)
    found = {model.name: model for model in scene.models}
    for name, wanted in models.items():
        if name not in found:
            raise UnknownNameError("model of the scene", name, found)
        found[name].ClearField("denavit_hartenberg")
        found[name].uri = wanted
    return scene_file.format(scene)

"""The scene: its nodes, its changes, and its files."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, TypedDict, Unpack

import numpy as np
from google.protobuf.field_mask_pb2 import FieldMask

from virtualrobot._wire.arguments import PoseLike, Text, checked
from virtualrobot._wire.messages import Stamp, array_of, stamp_of, value_or_default, vector_message
from virtualrobot._wire.names import unknown_name
from virtualrobot._wire.options import check_options
from virtualrobot._wire.services import Services
from virtualrobot._wire.showing import listed, shown, told
from virtualrobot.collisions.allowed_pairs import AllowedPair, built_pairs
from virtualrobot.files import scene_files
from virtualrobot.files.assets import Assets
from virtualrobot.files.scene_files import Export
from virtualrobot.geometry import Matrix, poses_from_rows
from virtualrobot.scene.editor import Batch, Editor
from virtualrobot.scene.node import Node, NodeInfo
from virtualrobot.scene.target import Target
from virtualrobot.scene.viewpoint import Viewpoint
from virtualrobot.tables import scene_tree
from virtualrobot.v1 import nodes_pb2, scene_pb2

if TYPE_CHECKING:
    from virtualrobot.robots.robot import Robot


@shown
@dataclass(frozen=True, slots=True)
class SceneChange:
    """Change of a scene, from `Scene.watch`: the first holds everything.

    Attributes:
        stamp: the instant of this state.
        nodes: nodes that are new or changed.
        removed: the names of nodes that are gone.
        poses: `world_t_node`, 4x4, of the nodes that moved, by name.
        ghosts: `world_t_node`, 4x4, by name, of what robots move that are elsewhere, too: where motions command them,
            if their joints are measured, or where their real ones are; None where that is as before.
    """

    stamp: Stamp
    nodes: tuple[NodeInfo, ...]
    removed: tuple[str, ...]
    poses: dict[str, Matrix]
    ghosts: dict[str, Matrix] | None = None


class LoadOptions(TypedDict, total=False):
    """Options of models that are loaded.

    Attributes:
        name: the node's name; by default the one that the file gives, with a number if that is taken.
        pose: `parent_t_node`, 4x4.
        parent: the node that it is fixed to; the world by default.
        packages: folders by package name, for `package://` names.
        base: for robots: `fixed` (the default), or `floating` or `planar` for vehicles and legged robots.
        settings: those of the importer that reads the file; for xacro `{"arguments": {"prefix": "left_"}}`.
        srdf: for robots: a file with groups, postures and pairs of links that may touch, found as `file` is.
        strict: whether to refuse a file that there is a warning about.
        text: the file's content; `file` only names it then: its ending tells the format, and what the text names is
            looked for as if it lay there.
        request_id: a name of this call, as of `motions.motion.StartOptions`: made again with it, it loads nothing.
    """

    name: str | None
    pose: PoseLike | None
    parent: str | None
    packages: Mapping[str, str | Path] | None
    base: str | None
    settings: Mapping[str, object] | None
    srdf: str | Path | None
    strict: bool | None
    text: str | None
    request_id: str | None


@checked
class Scene(Editor[Node]):
    """The tree of nodes of one kernel. Each change here is applied at once; `batch` applies several as one.

    Example:
        >>> scene = client.scene
        >>> table = scene.add_object("table", virtualrobot.box(1, 1, 0.1, color="grey"))
        >>> print(scene.tree())
    """

    def __init__(self, services: Services) -> None:
        """Handle the scene of one kernel."""
        self._services = services
        self._assets = Assets(services)
        self._warnings: tuple[scene_files.FileWarning, ...] = ()
        self._allowed_pairs: tuple[AllowedPair, ...] = ()

    # Reading.

    def _read(self, names: Sequence[str] = (), fields: Sequence[str] = ()) -> tuple[list[nodes_pb2.Node], Matrix]:
        """Return nodes (all, or these) with the wanted fields (all, or these), and `world_t_node` (n, 4, 4)."""
        mask = FieldMask(paths=fields) if fields else None
        response = self._services.scene.GetScene(scene_pb2.GetSceneRequest(names=names, read_mask=mask))
        return list(response.nodes), poses_from_rows(array_of(response.world_t_node))

    def nodes(self, kind: str | None = None, *, tag: str | None = None) -> list[Node]:
        """Return all nodes, parents before children, or those of a kind such as `part`, or with a tag, or both."""
        messages, _ = self._read(fields=("uid", "name", "tags", *_KINDS))
        return [
            Node(self, message)
            for message in messages
            if (kind is None or message.WhichOneof("kind") == kind) and (tag is None or tag in message.tags)
        ]

    def node(self, name: str) -> Node:
        """Return the node of this name; raises UnknownNameError when there is none."""
        return Node(self, self._read([name])[0][0])

    def targets(self) -> dict[str, Target]:
        """Return all targets by name: places that were taught, or added by `add_target`."""
        messages, _ = self._read(fields=("uid", "name", *_KINDS))
        return {message.name: Target(self, message) for message in messages if message.WhichOneof("kind") == "target"}

    def target(self, name: str) -> Target:
        """Return the target of this name; raises UnknownNameError when there is none."""
        targets = self.targets()
        if name not in targets:
            raise unknown_name("no target", name, targets)
        return targets[name]

    def viewpoints(self) -> dict[str, Viewpoint]:
        """Return all viewpoints by name: views that people have saved, or added by `add_viewpoint`."""
        messages, _ = self._read(fields=("uid", "name", *_KINDS))
        return {one.name: Viewpoint(self, one) for one in messages if one.WhichOneof("kind") == "viewpoint"}

    def viewpoint(self, name: str) -> Viewpoint:
        """Return the viewpoint of this name; raises UnknownNameError when there is none."""
        viewpoints = self.viewpoints()
        if name not in viewpoints:
            raise unknown_name("no viewpoint", name, viewpoints)
        return viewpoints[name]

    def pose(self, name: str) -> Matrix:
        """Return `world_t_node`, 4x4: where a node is in the world now."""
        return self._read([name], ("name",))[1][0]

    def poses(self, names: Sequence[str] = ()) -> dict[str, Matrix]:
        """Return `world_t_node`, 4x4, by name, of all nodes or of these, all of the same instant."""
        nodes, poses = self._read(names, ("name",))
        return {node.name: world_t_node for node, world_t_node in zip(nodes, poses, strict=True)}

    def bounds(self, name: str) -> Matrix | None:
        """Return the box about a node and all below it, (2, 3): least and greatest x, y, z in its own frame (m).

        It goes by what is visible of them; None where nothing is.

        Example:
            >>> least, greatest = client.scene.bounds("table")
            >>> greatest - least
            array([1. , 1. , 0.1])
        """
        request = scene_pb2.GetNodeBoundsRequest(names=[name])
        rows = array_of(self._services.scene.GetNodeBounds(request).bounds)
        return None if np.isnan(rows).any() else rows[0].reshape(2, 3)

    def twists(self, *names: str) -> dict[str, Matrix]:
        """Return how fast nodes are now, (6,) by name, all of the same instant.

        Velocity of the origin (m/s), then angular velocity (rad/s), along and about the axes of the world.

        Example:
            >>> client.scene.twists("box")["box"][:3]
            array([ 0.  ,  0.  , -0.98])
        """
        request = scene_pb2.GetNodeTwistsRequest(names=names)
        return dict(zip(names, array_of(self._services.scene.GetNodeTwists(request).twists), strict=True))

    @property
    def revision(self) -> int:
        """The revision of the structure, for `batch(expected_structure_revision=...)`."""
        request = scene_pb2.GetSceneRequest(names=["world"], read_mask=FieldMask(paths=["name"]))
        return self._services.scene.GetScene(request).stamp.structure_revision

    def tree(self, links: bool = True) -> str:
        """Return the scene as a drawn tree; without `links` what hangs there is shown at the robot."""
        return scene_tree(self._read(fields=("name", "parent", "hidden", *_KINDS))[0], links)

    def watch(self, names: Sequence[str] = (), max_rate: float | None = None) -> Iterator[SceneChange]:
        """Yield the whole scene and then what changes, at most `max_rate` (30 by default) times a second."""
        rate = value_or_default(max_rate, "max_rate")
        request = scene_pb2.WatchSceneRequest(names=names, max_rate_hertz=rate)
        name_of: dict[int, str] = {}
        with self._services.scene.WatchScene(request) as stream:
            for response in stream:
                removed = tuple(name_of.pop(uid) for uid in response.removed_uids if uid in name_of)
                name_of |= {node.uid: node.name for node in response.nodes}
                rows = poses_from_rows(array_of(response.world_t_node)) if response.moved_uids else np.empty((0, 4, 4))
                moved = zip(response.moved_uids, rows, strict=True)
                poses = {name_of[uid]: world_t_node for uid, world_t_node in moved}
                ghosts = None
                if response.HasField("twin_ghosts"):
                    ghosts = {
                        name_of[uid]: world_t_node
                        for ghost in response.twin_ghosts.ghosts
                        for uid, world_t_node in zip(
                            ghost.node_uids, poses_from_rows(array_of(ghost.world_t_node)), strict=True
                        )
                    }
                nodes = tuple(map(NodeInfo.of, response.nodes))
                yield SceneChange(stamp_of(response.stamp), nodes, removed, poses, ghosts)

    # Changing; the other changes are those of Editor.

    def _submit(self, command: scene_pb2.Command) -> None:
        self._services.apply([command])

    def _created(self, node: nodes_pb2.Node) -> Node:
        created = self._services.apply([scene_pb2.Command(create_node=scene_pb2.CreateNode(node=node))]).created[0]
        message = nodes_pb2.Node()
        message.CopyFrom(node)
        message.uid, message.name = created.uid, created.name
        return Node(self, message)

    @contextmanager
    def batch(
        self, expected_structure_revision: int | None = None, *, request_id: str | None = None
    ) -> Iterator[Batch]:
        """Collect changes and apply them as one at the end of the block, all or none.

        With `expected_structure_revision` the change is refused with StaleRevisionError when somebody else has changed
        the structure since. With `request_id`, a name of this change as of `motions.motion.StartOptions`, the same
        batch may be applied again, since its answer was lost, and changes nothing twice. When the block fails nothing
        is applied.

        Example:
            >>> with scene.batch() as batch:
            ...     batch.add_part("box", virtualrobot.box(0.1, 0.1, 0.1))
            ...     batch.attach("box", "table", virtualrobot.pose(z=0.1))
        """
        batch = Batch()
        yield batch
        if batch._commands:
            self._services.apply(batch._commands, expected_structure_revision, request_id)

    # Files.

    def load(
        self,
        file: str | Path,
        *,
        as_part: bool = False,
        scale: float | Sequence[float] = 1.0,
        **options: Unpack[LoadOptions],
    ) -> Node:
        """Load a model (URDF, a mesh, or what an importer reads) and return its node: a robot, an object or a part.

        A file of this machine is sent with all that it names, so the kernel may run elsewhere; other names are looked
        for on the kernel's machine. What is odd about a file but does no harm to how it moves is logged (`logging`,
        level WARNING), shown by the viewer and kept in `warnings`.

        Args:
            file: a path, a URI such as `package://pybullet_data/kuka_iiwa/model.urdf`, or `model://` with a name of
                `client.models()`.
            as_part: for meshes: whether robots handle it; else it belongs to the environment.
            scale: for meshes: one factor or three.
            options: name, place and others; see `LoadOptions`.

        Raises:
            MissingFileError: when the file or one that it names is nowhere; the message lists the places tried.
            MalformedFileError: when the file says something impossible.
            PluginFailedError: when the importer raised, hung or died.
        """
        factors = (scale,) * 3 if isinstance(scale, int | float) else tuple(scale)
        check_options(options, LoadOptions, "a model")
        self._warnings, self._allowed_pairs = (), ()
        where = options.get("name"), options.get("pose"), options.get("parent") or "world"
        request = scene_files.model_request(*where, options.get("base") or "fixed")
        request.as_part, request.strict = as_part, options.get("strict") or False
        request.scale.CopyFrom(vector_message(factors, "a scale"))
        sources = options.get("srdf"), options.get("packages") or {}, options.get("settings"), options.get("request_id")
        text = options.get("text")
        response = scene_files.load_model(self._services, self._assets, request, file, *sources, text=text)
        self._warnings = scene_files.file_warnings(response.warnings)
        self._allowed_pairs = built_pairs(response.allowed_pairs)
        return self.node(response.created[0].name)

    @property
    def warnings(self) -> tuple[scene_files.FileWarning, ...]:
        """Warnings about the model or scene file that was loaded last, and about what it names.

        Empty for none, and after a load that was refused: its error says why.
        """
        return self._warnings

    @property
    def allowed_pairs(self) -> tuple[AllowedPair, ...]:
        """Pairs that touch as the model that was loaded last is built or stands, and so may touch from then on.

        Those of a scene file are of the models that it names. `client.collisions.allowed` has all pairs that may touch,
        and its `forbid_built` undoes these.

        Example:
            >>> client.load_robot("model://kr6_r700", pose=virtualrobot.pose(z=0.8))
            >>> [(pair.second, pair.reason) for pair in client.scene.allowed_pairs]
            [('table', "stands on 'table'")]
        """
        return self._allowed_pairs

    def export(self, node: Text | Node | Robot, file: str | Path, *, tolerance: float = 0.0) -> Export:
        """Write a robot as URDF (`.urdf`), or whatever hangs below a node as binary glTF or USDZ, to this machine.

        USDZ (`.usdz`) is for phones and headsets of Apple: the scene as it stands, without points and lines. An empty
        `node` means the whole world. Meshes that the file names go beside it. With a `tolerance` (m) a `.glb` has fewer
        triangles, and its surfaces are nowhere farther away than that from where they are.

        Raises:
            InvalidArgumentError: when the ending is no such format, or none with a tolerance, a file cannot be written,
                or one beside it is there already and belongs to another export.

        Example:
            >>> client.scene.export("iiwa", "iiwa.urdf").warnings
            ()
        """
        name = node if isinstance(node, str) else node.name
        return scene_files.export_model(self._services, self._assets, name, Path(file), tolerance)

    def load_scene(
        self,
        file: str | Path,
        *,
        add: bool = False,
        packages: Mapping[str, str | Path] | None = None,
        strict: bool = False,
        request_id: str | None = None,
    ) -> list[str]:
        """Replace the world by a scene file of this machine, or `add` it; return the names of the created nodes.

        What is odd about its files goes the way that `load` tells.

        Args:
            file: the scene file.
            add: adds to the world instead of replacing it.
            packages: folders by package name, for `package://` names.
            strict: refuses files that there is a warning about.
            request_id: a name of this call, as of `LoadOptions`.

        Raises:
            MissingFileError: when the file or one that it names is nowhere.
            MalformedFileError: when the file says something impossible; the message has file and line.
        """
        self._warnings, self._allowed_pairs = (), ()
        response = scene_files.load_scene(
            self._services, self._assets, Path(file), add, packages or {}, strict, request_id
        )
        self._warnings = scene_files.file_warnings(response.warnings)
        self._allowed_pairs = built_pairs(response.allowed_pairs)
        return [created.name for created in response.created]

    def clear(self) -> None:
        """Take everything out of the world: all nodes and signals; motions end."""
        self._services.scene.LoadScene(scene_pb2.LoadSceneRequest(text="schema_version: 1\n"))

    def save(self, file: str | Path, *, bundle: bool = False) -> list[Path]:
        """Write the world to a scene file; with `bundle` put the files that it names beside it, under `assets/`.

        Returns the files that were written.
        """
        return scene_files.save_scene(self._services, self._assets, Path(file), bundle)

    def __getitem__(self, name: str) -> Node:
        """Return the node of this name; raises UnknownNameError, a KeyError, when there is none."""
        return self.node(name)

    def __iter__(self) -> Iterator[str]:
        """Yield the names of all nodes, parents before children."""
        return iter([node.name for node in self.nodes()])

    def __contains__(self, name: object) -> bool:
        """Return whether there is a node of this name."""
        return name in list(self)

    def _ipython_key_completions_(self) -> list[str]:
        """Return the names that IPython completes."""
        return list(self)

    def __repr__(self) -> str:
        """Return a line for people."""

        def say() -> str:
            kinds = Counter(node.kind for node in self.nodes() if node.kind not in ("world", "link"))
            return listed((f"{count} {kind}{'s' * (count != 1)}" for kind, count in kinds.items()), "empty")

        return told("Scene", say)

    def _repr_html_(self) -> str:
        """Return the tree for notebooks."""
        from html import escape

        return f"<pre>{escape(self.tree(links=False))}</pre>"


_KINDS = tuple(field.name for field in nodes_pb2.Node.DESCRIPTOR.oneofs_by_name["kind"].fields)

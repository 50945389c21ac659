"""SceneService: the tree, changes of it, models and scene files."""

from __future__ import annotations

import asyncio
from collections.abc import AsyncIterator, Mapping, Sequence
from functools import partial

import numpy as np
from numpy.typing import NDArray
from virtualrobot.v1 import nodes_pb2, scene_pb2, scene_pb2_grpc
from virtualrobot_sdk.models import Model

from virtualrobot_kernel.api.convert.commands import world_commands
from virtualrobot_kernel.api.kernel_services import KernelServices
from virtualrobot_kernel.api.message_parts import TOGETHER_BYTES, parts
from virtualrobot_kernel.api.repeats import Repeats
from virtualrobot_kernel.collision.built import Named, built_pairs, mounted_pairs
from virtualrobot_kernel.collision.readiness import is_to_be_ready, make_ready
from virtualrobot_kernel.crafts.crafts import crafts_made
from virtualrobot_kernel.drawing.extent import node_box
from virtualrobot_kernel.drawing.ghosts import moved_parts
from virtualrobot_kernel.drawing.twin_ghosts import ghost_poses, twin_ghosts
from virtualrobot_kernel.errors import KernelError, Reason
from virtualrobot_kernel.formats.export.model import export_model
from virtualrobot_kernel.formats.models import ImportedModel
from virtualrobot_kernel.formats.xml import FileWarning, refuse_warnings
from virtualrobot_kernel.messages.nodes import node_message
from virtualrobot_kernel.messages.table import Table
from virtualrobot_kernel.messages.values import array_message, expected_revision, mask_fields, poses_array, stamp
from virtualrobot_kernel.scenes.assets import files_of, with_assets
from virtualrobot_kernel.scenes.models import mounting, read_model
from virtualrobot_kernel.scenes.reading import read_scene
from virtualrobot_kernel.scenes.writing import write_scene
from virtualrobot_kernel.sensing.choices import check_choices
from virtualrobot_kernel.sensing.elements import elements_of
from virtualrobot_kernel.world.commands import Command, CreateNodes, MountTool, SetAllowedPairs, UpdateNode
from virtualrobot_kernel.world.node_twists import node_twists
from virtualrobot_kernel.world.physics_commands import SetPhysics
from virtualrobot_kernel.world.state import Snapshot, unchanged
from virtualrobot_kernel.world.store import Applied
from virtualrobot_kernel.world.structure import Kind, Node, Structure

OWN = ("scene", "srdf", "touching", "tool", "craft", "settings", "installed")
"""Fields of a model and of its message that are the kernel's matter."""

MODEL = Table(Model, scene_pb2.KnownModel, without=OWN)

MOST_COMMANDS = 20_000
"""Greatest number of commands of a batch: they are applied between two ticks."""

FEW = 100
"""Number of commands up to which the API's thread converts them, in a millisecond or two; more go to a worker."""


class SceneServicer(scene_pb2_grpc.SceneServiceServicer):
    """Servicer of SceneService."""

    def __init__(self, kernel: KernelServices) -> None:
        """Serve from the kernel."""
        self._kernel = kernel
        self._repeats = Repeats()

    async def GetScene(self, request: scene_pb2.GetSceneRequest, context: object) -> scene_pb2.GetSceneResponse:
        """Tell nodes and where they are."""
        snapshot = self._kernel.world.snapshot
        fields = mask_fields(request.read_mask, nodes_pb2.Node)
        structure = snapshot.structure
        nodes = [structure.node(name) for name in request.names] or _parents_first(structure)
        rows = [structure.rows[node.uid] for node in nodes]
        return scene_pb2.GetSceneResponse(
            stamp=stamp(snapshot),
            nodes=[node_message(snapshot, node, fields) for node in nodes],
            world_t_node=poses_array(snapshot.world_t_node[rows]),
        )

    async def WatchScene(
        self, request: scene_pb2.WatchSceneRequest, context: object
    ) -> AsyncIterator[scene_pb2.WatchSceneResponse]:
        """Tell all nodes, then changes."""
        fields = mask_fields(request.read_mask, nodes_pb2.Node)
        wanted = {self._kernel.world.snapshot.structure.node(name).uid for name in request.names}
        before: Snapshot | None = None
        told = scene_pb2.TwinGhosts()
        if request.every_tick:
            async for ticks in self._kernel.publications.every_tick(request.max_rate_hertz):
                messages = []
                for lost, snapshot in ticks:
                    ghosts = _twin_ghosts(snapshot, self._kernel.links.measured(snapshot), wanted)
                    message = scene_pb2.WatchSceneResponse(stamp=stamp(snapshot))
                    if before is None or not _quiet(before, snapshot):
                        message = _difference(before, snapshot, wanted, fields)
                    if ghosts != told:
                        message.twin_ghosts.CopyFrom(ghosts)
                        told = ghosts
                    message.lost_ticks = lost
                    messages.append(message)
                    before = snapshot
                for part in parts(messages, TOGETHER_BYTES):
                    yield scene_pb2.WatchSceneResponse(stamp=part[-1].stamp, ticks=part)
            return
        async for snapshot in self._kernel.publications.snapshots(request.max_rate_hertz):
            ghosts = _twin_ghosts(snapshot, self._kernel.links.measured(snapshot), wanted)
            if before is None or ghosts != told or not _quiet(before, snapshot):
                message = _difference(before, snapshot, wanted, fields)
                if ghosts != told:
                    message.twin_ghosts.CopyFrom(ghosts)
                    told = ghosts
                changed = message.nodes or message.removed_uids or message.moved_uids
                if before is None or changed or message.HasField("twin_ghosts"):
                    yield message
            before = snapshot

    async def GetNodeBounds(
        self, request: scene_pb2.GetNodeBoundsRequest, context: object
    ) -> scene_pb2.GetNodeBoundsResponse:
        """Tell boxes about nodes."""
        snapshot = self._kernel.world.snapshot
        uids = _named(snapshot, request.names)

        def work() -> scene_pb2.GetNodeBoundsResponse:
            elements = elements_of(snapshot, self._kernel.sensing.shapes)
            boxes = [node_box(elements, snapshot, uid) for uid in uids]
            rows = np.array([np.full(6, np.nan) if box is None else box.ravel() for box in boxes])
            return scene_pb2.GetNodeBoundsResponse(stamp=stamp(snapshot), bounds=array_message(rows))

        return await self._kernel.in_worker(work)

    async def GetNodeTwists(
        self, request: scene_pb2.GetNodeTwistsRequest, context: object
    ) -> scene_pb2.GetNodeTwistsResponse:
        """Tell velocities of nodes."""
        snapshot = self._kernel.world.snapshot
        uids = _named(snapshot, request.names)

        def work() -> scene_pb2.GetNodeTwistsResponse:
            return scene_pb2.GetNodeTwistsResponse(
                stamp=stamp(snapshot),
                twists=array_message(node_twists(snapshot, uids)),
                world_t_node=poses_array(snapshot.world_t_node[[snapshot.structure.rows[uid] for uid in uids]]),
            )

        return await self._kernel.in_worker(work)

    async def Apply(self, request: scene_pb2.ApplyRequest, context: object) -> scene_pb2.ApplyResponse:
        """Change the world by all commands or by none."""
        return await self._repeats.once(request, lambda: self._apply(request, context))

    async def _apply(self, request: scene_pb2.ApplyRequest, context: object) -> scene_pb2.ApplyResponse:
        if (count := len(request.commands)) > MOST_COMMANDS:
            raise KernelError(
                f"a batch may have {MOST_COMMANDS:,} commands, not {count:,}",
                reason=Reason.TOO_LARGE,
                commands=count,
                limit=MOST_COMMANDS,
            )
        if count > FEW:
            commands = await self._kernel.in_worker(world_commands, request.commands)
        else:
            commands = world_commands(request.commands)
        if any(isinstance(command, (CreateNodes, UpdateNode)) for command in commands):
            commands = await self._kernel.in_worker(with_assets, self._kernel.meshes, commands)
        pairs: tuple[Named, ...] = ()
        if any(isinstance(command, MountTool) for command in commands):
            shapes, snapshot = self._kernel.collisions.shapes, self._kernel.world.snapshot
            pairs = await self._kernel.in_worker(mounted_pairs, snapshot, commands, shapes)
        expected = expected_revision(request)
        try:
            allow = [SetAllowedPairs(built=pairs)] if pairs else []
            applied = await self._submit([*commands, *allow], context, expected)
        except KernelError as error:
            if not pairs or error.reason is not Reason.UNKNOWN_NAME:
                raise
            # Another command of the batch, or another client, has renamed or removed what they name.
            pairs, applied = (), await self._submit(commands, context, expected)
        nodes = applied.snapshot.structure.nodes
        return scene_pb2.ApplyResponse(
            stamp=stamp(applied.snapshot),
            created=created_nodes(applied),
            picked_parts=[nodes[uid].name for uid in applied.picked if uid in nodes],
            allowed_pairs=map(pair_message, pairs),
        )

    async def ImportModel(
        self, request: scene_pb2.ImportModelRequest, context: object
    ) -> scene_pb2.ImportModelResponse:
        """Read a model in a worker thread, then add it as one change."""
        return await self._repeats.once(request, lambda: self._import(request.model, context))

    async def _import(self, source: scene_pb2.ModelSource, context: object) -> scene_pb2.ImportModelResponse:
        meshes = self._kernel.meshes
        files = files_of(meshes, source.files)
        shapes = self._kernel.collisions.shapes

        def read(snapshot: Snapshot) -> tuple[ImportedModel, tuple[Named, ...]]:
            model = read_model(meshes, source, files, snapshot.structure.uid_by_name)
            return model, built_pairs(snapshot, [CreateNodes(model.nodes), *mounting(source, model)], shapes)

        while True:
            snapshot = self._kernel.world.snapshot
            structure = snapshot.structure
            model, pairs = await self._kernel.in_worker(read, snapshot)
            allow = [SetAllowedPairs(built=pairs)] if pairs else []
            try:
                made = [CreateNodes(model.nodes), *mounting(source, model), *allow]
                applied = await self._submit(made, context)
                break
            except KernelError as error:
                if pairs and error.reason is Reason.UNKNOWN_NAME:
                    continue  # what it stands on may be gone
                # Another client took the free name that was found; only a name that was asked for is refused.
                found = model.nodes[0].name not in structure.uid_by_name
                if error.reason is not Reason.NAME_TAKEN or source.name or not found:
                    raise
        return scene_pb2.ImportModelResponse(
            stamp=stamp(applied.snapshot),
            created=created_nodes(applied),
            mesh_count=model.mesh_count,
            warnings=self._told(model.warnings),
            allowed_pairs=map(pair_message, pairs),
        )

    async def ListModels(self, request: scene_pb2.ListModelsRequest, context: object) -> scene_pb2.ListModelsResponse:
        """Tell the models that plugins know by name."""
        models = self._kernel.catalog.models.values()
        return scene_pb2.ListModelsResponse(models=[MODEL.write(one, installed=one.installed) for one in models])

    async def LoadScene(self, request: scene_pb2.LoadSceneRequest, context: object) -> scene_pb2.LoadSceneResponse:
        """Read a scene file in a worker thread, then replace the world by it, as one change."""
        return await self._repeats.once(request, lambda: self._load(request, context))

    async def _load(self, request: scene_pb2.LoadSceneRequest, context: object) -> scene_pb2.LoadSceneResponse:
        meshes = self._kernel.meshes
        files = files_of(meshes, request.files)
        known = self._kernel.world.snapshot.structure.uid_by_name if request.add else None
        read = partial(read_scene, request.text, request.uri, files, meshes, known)
        commands, warnings, of_models = await self._kernel.read(read)
        if request.strict:
            refuse_warnings(warnings)
        built = partial(built_pairs, self._kernel.world.snapshot, commands, self._kernel.collisions.shapes, of_models)
        pairs = await self._kernel.in_worker(built) if of_models else ()
        commands += [SetAllowedPairs(built=pairs)] if pairs else []
        applied = await self._submit(commands, context)
        if not request.add:
            self._kernel.view.reset()
        return scene_pb2.LoadSceneResponse(
            stamp=stamp(applied.snapshot),
            created=created_nodes(applied),
            warnings=self._told(warnings),
            allowed_pairs=map(pair_message, pairs),
        )

    async def SaveScene(self, request: scene_pb2.SaveSceneRequest, context: object) -> scene_pb2.SaveSceneResponse:
        """Write the world as a scene file's text."""
        snapshot = self._kernel.world.snapshot
        text, files = await self._kernel.in_worker(write_scene, snapshot, request.bundle)
        return scene_pb2.SaveSceneResponse(
            stamp=stamp(snapshot),
            text=text,
            files=[nodes_pb2.AssetFile(uri=path, sha256=sha256) for path, sha256 in files],
        )

    async def ExportModel(
        self, request: scene_pb2.ExportModelRequest, context: object
    ) -> scene_pb2.ExportModelResponse:
        """Write a node as a model file in a worker thread."""
        snapshot = self._kernel.world.snapshot
        written = await self._kernel.in_worker(
            export_model,
            *(snapshot, self._kernel.meshes, request.node, request.format, request.tolerance_meters),
        )
        return scene_pb2.ExportModelResponse(
            stamp=stamp(snapshot),
            files=[nodes_pb2.AssetFile(uri=path, sha256=sha256) for path, sha256 in written.files],
            warnings=written.warnings,
        )

    def _told(self, warnings: Sequence[FileWarning]) -> list[scene_pb2.FileWarning]:
        """Tell who looks at the viewer of warnings, and return them as messages."""
        self._kernel.view.tell(warnings)
        return [scene_pb2.FileWarning(file=one.file, line=one.line, text=one) for one in warnings]

    async def _submit(
        self, commands: Sequence[Command], context: object, expected_revision: int | None = None
    ) -> Applied:
        limits, meshes = self._kernel.limits, self._kernel.meshes
        if any(isinstance(command, (CreateNodes, UpdateNode)) for command in commands):
            await self._kernel.in_worker(limits.check_triangles, self._kernel.world.snapshot, commands, meshes)
        self._kernel.solvers.check_choices(commands)
        if crafts_made(commands):
            await self._kernel.in_worker(self._kernel.crafts.check, commands)
        check_choices(commands, self._kernel.sensing)
        if any(isinstance(command, SetPhysics) for command in commands):
            await self._kernel.in_worker(self._kernel.forces.check, commands)
        snapshot = self._kernel.world.snapshot
        if is_to_be_ready(snapshot, commands):
            await self._kernel.in_worker(make_ready, self._kernel.collisions.shapes, snapshot, commands)
        return await asyncio.wrap_future(self._kernel.submit(commands, context, expected_revision))


def pair_message(pair: Named) -> nodes_pb2.NodePair:
    """Return a pair that an import has found as a message."""
    first, second, reason = pair
    return nodes_pb2.NodePair(first=first, second=second, reason=reason, built=True)


def created_nodes(applied: Applied) -> list[scene_pb2.CreatedNode]:
    """Return the nodes that a batch created and did not remove again."""
    nodes = applied.snapshot.structure.nodes
    uids = [uid for uid in applied.created if isinstance(uid, int) and uid in nodes]
    return [scene_pb2.CreatedNode(uid=uid, name=nodes[uid].name) for uid in uids]


def _named(snapshot: Snapshot, names: Sequence[str]) -> list[int]:
    """Return nodes (uids) by name; raise KernelError for none at all, and UnknownNameError."""
    if not names:
        raise KernelError("names is empty: of which nodes?", field="names")
    return [snapshot.structure.node(name).uid for name in names]


def _parents_first(structure: Structure) -> list[Node]:
    uids = list(structure.nodes)
    return [structure.nodes[uids[row]] for row in structure.forest.order.tolist()]


def _quiet(before: Snapshot, after: Snapshot) -> bool:
    """Return whether nothing that WatchScene tells has changed between two snapshots."""
    return unchanged(*((one.structure, one.world_t_node, one.state.running_sensors) for one in (before, after)))


def _difference(
    before: Snapshot | None, after: Snapshot, wanted: set[int], fields: frozenset[str] | None
) -> scene_pb2.WatchSceneResponse:
    """Return the changes between two snapshots, or everything when there is none before."""
    structure = after.structure
    changed, removed = [], []
    if before is None:
        changed = moved = _chosen(_parents_first(structure), wanted)
    else:
        old = before.structure
        moved = _chosen(_moved(before, after), wanted)
        running = before.state.running_sensors.keys() ^ after.state.running_sensors.keys()
        if old is not structure or running:
            nodes = _chosen(_parents_first(structure), wanted)
            changed = [node for node in nodes if node.uid in running or _differs(old, structure, node)]
            removed = [uid for uid in old.nodes if uid not in structure.nodes and (not wanted or uid in wanted)]
    rows = [structure.rows[node.uid] for node in moved]
    return scene_pb2.WatchSceneResponse(
        stamp=stamp(after),
        nodes=[node_message(after, node, fields) for node in changed],
        removed_uids=removed,
        moved_uids=[node.uid for node in moved],
        world_t_node=poses_array(after.world_t_node[rows]) if rows else None,
    )


def _twin_ghosts(
    snapshot: Snapshot, measured: Mapping[int, NDArray[np.float64]], wanted: set[int]
) -> scene_pb2.TwinGhosts:
    """Return the ghosts of twins, as far as their nodes are wanted."""
    message, structure = scene_pb2.TwinGhosts(), snapshot.structure
    ghosts = twin_ghosts(snapshot, measured)
    if not ghosts:
        return message
    world_t_node = ghost_poses(snapshot, ghosts)
    for ghost in ghosts:
        uids = dict.fromkeys(uid for uid, _ in moved_parts(snapshot, ghost.robot) if not wanted or uid in wanted)
        if uids:
            message.ghosts.add(
                robot_uid=ghost.robot,
                kind=scene_pb2.TwinGhostKind.Value(f"TWIN_GHOST_KIND_{ghost.kind.name}"),
                node_uids=uids,
                world_t_node=poses_array(world_t_node[[structure.rows[uid] for uid in uids]]),
            )
    return message


def _chosen(nodes: list[Node], wanted: set[int]) -> list[Node]:
    return [node for node in nodes if node.uid in wanted] if wanted else nodes


def _differs(before: Structure, after: Structure, node: Node) -> bool:
    """Return whether a node's message has changed: by itself, by its parent's name, or by a robot's links."""
    uid, parent = node.uid, node.parent
    if before.nodes.get(uid) is not node or (parent and before.nodes[parent].name != after.nodes[parent].name):
        return True
    return node.kind is Kind.ROBOT and before.robots[uid].joint_names != after.robots[uid].joint_names


def _moved(before: Snapshot, after: Snapshot) -> list[Node]:
    """Return the nodes that are new or elsewhere in the world, parents first."""
    structure, old = after.structure, before.structure.rows
    if before.world_t_node is after.world_t_node and old is structure.rows:
        return []
    uids = list(structure.rows)
    known = np.arange(len(uids)) if old is structure.rows else np.array([old.get(uid, -1) for uid in uids])
    elsewhere = (before.world_t_node[known] != after.world_t_node).any(axis=(1, 2)) | (known < 0)
    order = structure.forest.order
    return [structure.nodes[uids[row]] for row in order[elsewhere[order]].tolist()]

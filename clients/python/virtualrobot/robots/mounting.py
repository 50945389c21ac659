"""Tools and grippers that robots get: loaded from a model or taken as they are."""

from __future__ import annotations

from pathlib import Path

from virtualrobot._wire.arguments import ArrayLike, PoseLike
from virtualrobot._wire.messages import pose_message
from virtualrobot._wire.services import Services
from virtualrobot.errors import VirtualRobotError
from virtualrobot.files.assets import Assets
from virtualrobot.files.scene_files import load_model, model_request
from virtualrobot.motions.steps import Named, name_of
from virtualrobot.scene.editor import Batch, Direct


def mount(
    services: Services,
    robot: str,
    what: Named | Path,
    name: str | None,
    adapter: str | None,
    pose: PoseLike | None,
    tcp: str | ArrayLike | None,
) -> None:
    """Mount a model or a node on a robot; the arguments are those of `Robot.mount`."""
    node = str(what) if isinstance(what, Path) else name_of(what)
    if isinstance(what, Path) or "/" in node:
        request = model_request(name, None, "", "fixed")
        if tcp is None or isinstance(tcp, str):
            request.mount_on, request.parent, request.tool_center_point = robot, adapter or "", tcp or ""
            if pose is not None:
                request.parent_t_node.CopyFrom(pose_message(pose))
            load_model(services, Assets(services), request, node, None, {}, None)
            return
        node = load_model(services, Assets(services), request, node, None, {}, None).created[0].name
        try:
            _mount_node(services, robot, node, adapter, pose, tcp)
        except VirtualRobotError:
            Direct(services).remove(node)
            raise
        return
    _mount_node(services, robot, node, adapter, pose, tcp)


def _mount_node(
    services: Services,
    robot: str,
    node: str,
    adapter: str | None,
    pose: PoseLike | None,
    tcp: str | ArrayLike | None,
) -> None:
    """Mount a node that is there; a tool centre point given as a pose makes a tool of it first."""
    if tcp is None or isinstance(tcp, str):
        Direct(services).mount_tool(robot, node, adapter, pose, tcp)
        return
    batch, own = Batch(), f"{node}.tcp"
    batch.add_tool(own, node, tool_center_points={"tcp": tcp})
    batch.mount_tool(robot, node, adapter, pose)
    batch.select_tool(robot, own)
    services.apply(batch._commands)

"""Robot as URDF can say it: a tree of named links, each with the joint before it and its shapes.

Links and joints keep their names but for signs that other programs stumble over. Tools and adapters become links that
are fixed where they are mounted, tool centre points empty links below them. The links of a gripper hang below one
of its name, which is fixed, too. Where the robot's own frame is more than the frame of its one fixed root link, an
empty link with the robot's name stands for it.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass

import numpy as np

from virtualrobot_kernel.errors import KernelError
from virtualrobot_kernel.formats.export.names import legal, unique
from virtualrobot_kernel.formats.export.robot_joints import joint_names, urdf_joint
from virtualrobot_kernel.formats.export.robot_losses import losses
from virtualrobot_kernel.world.figures import Figure, Frame, Label, Lines, Points, Pose
from virtualrobot_kernel.world.state import Snapshot
from virtualrobot_kernel.world.structure import Inertial, Joint, JointType, Kind, LinkData, Node, Structure, ToolData
from virtualrobot_kernel.world.visibility import inherited_visibility

MOUNTED = (Kind.ADAPTER, Kind.TOOL)


@dataclass(frozen=True, slots=True, eq=False)
class Mount:
    """Mount of a link on another one; `parent_t_joint` is the joint's frame, which is the link's at zero."""

    parent: str
    joint: Joint
    parent_t_joint: Pose


@dataclass(frozen=True, slots=True, eq=False)
class TreeLink:
    """Link of the tree; the root has no mount."""

    name: str
    mount: Mount | None = None
    inertial: Inertial | None = None
    figures: tuple[Figure, ...] = ()


@dataclass(frozen=True, slots=True, eq=False)
class RobotTree:
    """Links of a robot, parents first, and what URDF cannot say of it."""

    name: str
    links: tuple[TreeLink, ...]
    warnings: tuple[str, ...]


def robot_tree(snapshot: Snapshot, robot: Node) -> RobotTree:
    """Return the tree of a robot with what is mounted; raise KernelError when it has neither link nor figure."""
    structure = snapshot.structure
    nodes, left_out = _written(structure, robot)
    if not nodes and not robot.figures:
        raise KernelError(f"the robot {robot.name!r} has no link: there is nothing to write", robot=robot.name)
    _, states = inherited_visibility(structure, snapshot.state.tool_states)
    figures = {
        node.uid: tuple(figure for figure in node.figures if figure.tool_state in ("", states[node.uid]))
        for node in (robot, *nodes)
    }
    warnings = losses(robot, nodes, left_out, figures, states)
    names = _link_names(robot, nodes)
    joint_of, moving = joint_names(nodes, structure.robot_of)
    links: list[TreeLink] = []
    if _needs_own_link(snapshot, robot, nodes):
        names[robot.uid] = unique(legal(robot.name), names.values())
        links.append(TreeLink(names[robot.uid], figures=_shapes(figures[robot.uid])))
    for node in nodes:
        mount = None
        if node.parent in names:
            if isinstance(node.data, LinkData):
                owner = structure.robot_of(node.uid)
                joint, oddities = urdf_joint(node.data.joint, joint_of[node.uid], moving.get(owner, {}))
                warnings.extend(oddities)
            else:
                joint = _fixed(names[node.uid], joint_of, node.uid)
            mount = Mount(names[node.parent], joint, snapshot.state.parent_t_node[structure.rows[node.uid]])
        inertial = node.data.inertial if isinstance(node.data, LinkData | ToolData) else None
        links.append(TreeLink(names[node.uid], mount, inertial, _shapes(figures[node.uid])))
    taken = {link.name for link in links}
    for node in nodes:
        if isinstance(node.data, ToolData):
            for point, tool_t_tcp in node.data.tool_center_points.items():
                name = unique(legal(f"{names[node.uid]}_{point}"), taken)
                taken.add(name)
                joint = _fixed(name, joint_of, -len(taken))
                links.append(TreeLink(name, Mount(names[node.uid], joint, tool_t_tcp)))
    return RobotTree(legal(robot.name), tuple(links), (*warnings, *_renamed(robot, nodes, names, joint_of)))


def _written(structure: Structure, robot: Node) -> tuple[list[Node], list[Node]]:
    """Return links (in the order of creation), adapters, tools and grippers of a robot, and what else hangs on them."""
    grippers = structure.grippers_of(robot.uid)
    own = {robot.uid, *structure.robots[robot.uid].links}
    mounted: list[Node] = []
    left_out: list[Node] = []
    for node in structure.below(robot.uid):
        if node.parent in own and node.uid not in own:
            written = node.kind in MOUNTED or node.uid in grippers
            (mounted if written else left_out).append(node)
            own.update([node.uid] if written else [])
            if node.uid in grippers:
                links = structure.robots[node.uid].links
                mounted.extend(structure.nodes[uid] for uid in links)
                own.update(links)
    return [*(structure.nodes[uid] for uid in structure.robots[robot.uid].links), *mounted], left_out


def _needs_own_link(snapshot: Snapshot, robot: Node, nodes: Iterable[Node]) -> bool:
    """Return whether the robot's frame is more than that of one root link fixed at it."""
    roots = [node for node in nodes if node.parent == robot.uid]
    if robot.figures or len(roots) != 1 or not isinstance(roots[0].data, LinkData):
        return True
    place = snapshot.state.parent_t_node[snapshot.structure.rows[roots[0].uid]]
    return roots[0].data.joint.type is not JointType.FIXED or not np.allclose(place, np.eye(4), rtol=0.0, atol=1e-12)


def _link_names(robot: Node, nodes: Iterable[Node]) -> dict[int, str]:
    """Return names by uid, no two alike; a link `robot.link` is called `link`."""
    names: dict[int, str] = {}
    for node in nodes:
        names[node.uid] = unique(legal(_plain(robot, node)), names.values())
    return names


def _plain(robot: Node, node: Node) -> str:
    return node.name.removeprefix(f"{robot.name}.") if node.kind is Kind.LINK else node.name


def _fixed(link: str, joint_of: dict[int, str], key: int) -> Joint:
    """Return a fixed joint for a link that has none of its own, and note its name under `key`."""
    joint_of[key] = unique(f"{link}_mount", joint_of.values())
    return Joint(joint_of[key])


def _shapes(figures: Iterable[Figure]) -> tuple[Figure, ...]:
    """Return the figures that URDF has something for."""
    return tuple(figure for figure in figures if not isinstance(figure.geometry, (Points, Lines, Frame, Label)))


def _renamed(robot: Node, nodes: Iterable[Node], names: dict[int, str], joint_of: dict[int, str]) -> Iterator[str]:
    """Yield a sentence that tells which names had to change, if any."""
    pairs = [(robot.name, legal(robot.name))]
    for node in nodes:
        pairs.append((_plain(robot, node), names[node.uid]))
        if isinstance(node.data, LinkData):
            pairs.append((node.data.joint.name, joint_of[node.uid]))
    changed = [f"{before!r} to {after!r}" for before, after in dict.fromkeys(pairs) if before and before != after]
    if changed:
        more = f" and {len(changed) - 5} more" if len(changed) > 5 else ""
        yield f"names changed so that they are plain and no two alike: {', '.join(changed[:5])}{more}"

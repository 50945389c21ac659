"""Commands about the tree: create, update, remove, attach, clear."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from dataclasses import replace

from virtualrobot_sdk.poses import inverse

from virtualrobot_kernel.errors import KernelError, Reason, UnknownNameError
from virtualrobot_kernel.world import index
from virtualrobot_kernel.world.about import NOTHING_SAID, check_about, or_none, refuse_locked
from virtualrobot_kernel.world.actuators import check_actuators
from virtualrobot_kernel.world.apply_sensors import with_sensors_running
from virtualrobot_kernel.world.change import Change, Forward, extended, rebuilt, refuse_while_moving, single_joint
from virtualrobot_kernel.world.collisions import NOTHING_SET
from virtualrobot_kernel.world.commands import AttachNode, ClearWorld, CreateNodes, RemoveNode, UpdateNode
from virtualrobot_kernel.world.consistency import (
    check_count,
    check_figures,
    check_names,
    check_robot,
    check_tool_in_use,
    refuse_while_robot_moves,
    refuse_while_tools_move,
)
from virtualrobot_kernel.world.figures import Pose
from virtualrobot_kernel.world.motored import is_dynamic, left
from virtualrobot_kernel.world.renaming import with_joint_renamed, with_nodes_renamed
from virtualrobot_kernel.world.sensing import CameraSensor, ContactSensor, Light, MotionSensor, RangeSensor
from virtualrobot_kernel.world.state import Cancellation, EndCause, Motion, Selection, State
from virtualrobot_kernel.world.structure import (
    WORLD_UID,
    Kind,
    LinkData,
    Node,
    PartData,
    RobotData,
    Structure,
    TargetData,
    ToolData,
    ViewpointData,
    robots_of_tool,
)
from virtualrobot_kernel.world.targets import check_target, without_gone

DATA = {
    Kind.PART: PartData,
    Kind.ROBOT: RobotData,
    Kind.LINK: LinkData,
    Kind.TOOL: ToolData,
    Kind.RANGE_SENSOR: RangeSensor,
    Kind.CAMERA_SENSOR: CameraSensor,
    Kind.CONTACT_SENSOR: ContactSensor,
    Kind.MOTION_SENSOR: MotionSensor,
    Kind.LIGHT: Light,
    Kind.TARGET: TargetData,
    Kind.VIEWPOINT: ViewpointData,
}
"""Class of the data that a kind of node must have; other kinds have none."""


PLACE = "place"
"""Metadata key of an error for the place of the refused one among the nodes to create; `apply` makes an index of it."""


def create_nodes(change: Change, command: CreateNodes, forward: Forward) -> Change:
    """Add nodes; tools get their first state, and become the tool of a robot that has none."""
    check_count(len(change.structure.nodes) + len(command.specs))
    nodes: dict[int, Node] = {}
    uids = dict(change.structure.uid_by_name)
    poses: dict[int, Pose] = {}
    uid = change.structure.next_uid
    for place, spec in enumerate(command.specs):
        with _about(place):
            if spec.kind is Kind.WORLD:
                raise KernelError("there is one world already; create other kinds of nodes", node=spec.name)
            parent = uids.get(spec.parent)
            if parent is None:
                raise UnknownNameError(f"parent for {spec.name!r}", spec.parent, uids)
            if spec.name in uids:
                raise KernelError(
                    f"the name {spec.name!r} is taken by another node; choose another one",
                    reason=Reason.NAME_TAKEN,
                    name=spec.name,
                )
            data = (
                spec.data
                if spec.data is not None
                else DATA[spec.kind]()
                if spec.kind in DATA and spec.kind is not Kind.LINK
                else None
            )
            _check_data(spec.name, spec.kind, data)
            check_figures(spec.name, data, spec.figures)
            check_about(spec.about or NOTHING_SAID, spec.name)
            nodes[uid] = Node(uid, spec.name, spec.kind, parent, spec.hidden, spec.figures, data, spec.about)
            uids[spec.name] = uid
            poses[uid] = spec.parent_t_node
            uid += 1
    created = tuple(poses)
    after = extended(change, nodes, uid, poses)
    for place, new in enumerate(created):
        with _about(place):
            check_names(after.structure, after.structure.nodes[new])
    for new in created:
        if nodes[new].kind is Kind.TOOL:
            after = _mounted(after, nodes[new])
    running = [new for new, spec in zip(created, command.specs, strict=True) if spec.running]
    return replace(with_sensors_running(after, running, True), created=change.created + created)


def update_node(change: Change, command: UpdateNode, forward: Forward) -> Change:
    """Change a node's name, pose, visibility, figures, data or what is said of it.

    Renaming a robot renames its links' prefix. What is locked changes only where it is unlocked as well.
    """
    node = change.structure.node(command.name)
    if node.kind is Kind.WORLD:
        raise KernelError("the world's root cannot be changed", reason=Reason.WRONG_STATE, node=node.name)
    given = {
        "name": command.new_name,
        "hidden": command.hidden,
        "figures": command.figures,
        "data": command.data,
    }
    changes = {field: value for field, value in given.items() if value is not None}
    is_moved_or_made_anew = changes.keys() - {"hidden"} or command.parent_t_node is not None
    if is_moved_or_made_anew and command.locked is not False:
        refuse_locked([(node.name, node.about)])
    said = {"description": command.description, "tags": command.tags, "icon": command.icon, "locked": command.locked}
    if said := {field: value for field, value in said.items() if value is not None}:
        about = replace(node.about or NOTHING_SAID, **said)
        check_about(about, node.name)
        changes["about"] = or_none(about)
    new = replace(node, **changes)
    _check_data(node.name, node.kind, new.data)
    check_figures(node.name, new.data, new.figures)
    before, renamed = change.structure, new.name != node.name
    rejointed = command.data is not None and node.kind in (Kind.LINK, Kind.ROBOT, Kind.TOOL)
    if rejointed or (command.parent_t_node is not None and node.kind is Kind.LINK):
        refuse_while_robot_moves(change, node)
    if node.kind in (Kind.LINK, Kind.ROBOT) and (renamed or rejointed):
        nodes = {**change.structure.nodes, node.uid: new}
        if renamed:
            nodes.update(_renamed_with(change.structure, node, new))
        if rejointed and isinstance(new.data, LinkData):
            nodes = with_joint_renamed(change.structure, node, new.data.joint, nodes)
        change = rebuilt(change, nodes, change.structure.next_uid, {})
    elif changes:
        change = replace(change, structure=(index.renamed if renamed else index.replaced)(change.structure, new))
    if renamed:
        now = change.structure.nodes
        refuse_while_named(change.state, [old for uid, old in before.nodes.items() if now[uid].name != old.name])
        change = replace(change, structure=with_nodes_renamed(before, change.structure))
    if rejointed and (robot := change.structure.robot_of(node.uid)):
        change = change if is_dynamic(robot) else left(change, (robot.uid,))
        check_robot(change, robot.uid)
    if command.data is not None and node.kind is Kind.TARGET:
        check_target(change.structure, new)
    if rejointed and node.kind is Kind.TOOL:
        check_names(change.structure, new)
        check_tool_in_use(change, new)
        change = _mounted(change, new)
    if command.parent_t_node is not None:
        change = replace(change, state=_placed(change.structure, change.state, node.uid, command.parent_t_node))
    if command.running is not None and command.running != (node.uid in change.state.running_sensors):
        change = with_sensors_running(change, (node.uid,), command.running)
    return change


def remove_node(change: Change, command: RemoveNode, forward: Forward) -> Change:
    """Take a node and all below it away; refused while a robot among them moves."""
    node = change.structure.node(command.name)
    if node.kind is Kind.WORLD:
        raise KernelError("the world's root cannot be removed", reason=Reason.WRONG_STATE, node=node.name)
    below = tuple(change.structure.below(node.uid))
    refuse_locked((other.name, other.about) for other in below)
    gone = {other.uid for other in below}
    refuse_while_robot_moves(change, node)
    refuse_while_tools_move(change, below)
    refuse_while_named(change.state, below)
    for uid in gone & change.structure.robots.keys():
        refuse_while_robot_moves(change, change.structure.nodes[uid])
    nodes = {uid: kept for uid, kept in change.structure.nodes.items() if uid not in gone}
    robot = change.structure.robot_of(node.uid)
    change = rebuilt(change, without_gone(nodes, (other.name for other in below)), change.structure.next_uid, {})
    if node.kind is Kind.LINK and robot is not None:
        check_robot(change, robot.uid)
    return change


def refuse_while_named(state: State, nodes: Iterable[Node]) -> None:
    """Raise KernelError (WRONG_STATE) for nodes that a running program looks up by name when it is there."""
    names = {node.uid: node.name for node in nodes}
    for motion in state.motions:
        for uid in motion.nodes & names.keys():
            raise KernelError(
                f"the program {motion.id!r} names the node {names[uid]!r}; wait for its end or cancel it",
                reason=Reason.WRONG_STATE,
                node=names[uid],
                motion=motion.id,
            )


def attach_node(change: Change, command: AttachNode, forward: Forward) -> Change:
    """Give a node another parent; without a pose it stays where it is in the world."""
    node = change.structure.node(command.name)
    parent = change.structure.node(command.parent)
    if node.kind in (Kind.WORLD, Kind.LINK):
        raise KernelError(
            f"{node.kind.value} nodes such as {node.name!r} cannot be attached elsewhere",
            reason=Reason.WRONG_STATE,
            node=node.name,
        )
    return attached(change, node, parent, command.parent_t_node, forward)


def attached(change: Change, node: Node, parent: Node, parent_t_node: Pose | None, forward: Forward) -> Change:
    """Return the world with a node under another parent, at a pose or where it is in the world."""
    refuse_locked([(node.name, node.about)])
    structure = index.reparented(change.structure, node.uid, parent.uid)
    if parent_t_node is None:
        world = forward(change.structure, change.state)
        rows = change.structure.rows
        place: Pose = inverse(world[rows[parent.uid]]) @ world[rows[node.uid]]
    else:
        place = parent_t_node
    before = change.structure
    after = replace(change, structure=structure, state=_placed(structure, change.state, node.uid, place))
    for tool in structure.below(node.uid):
        if tool.kind is Kind.TOOL and _robots(before, tool) != _robots(structure, tool):
            refuse_while_tools_move(change, [tool])
            check_names(structure, tool)
            after = _mounted(_dismounted(_parted(after, node), tool), tool)
    return after


def _parted(change: Change, node: Node) -> Change:
    """Return the world in which what hangs below a node may touch nothing else because it did as it was mounted."""
    below, pairs = {one.uid for one in change.structure.below(node.uid)}, change.state.allowed_pairs
    kept = {pair: why for pair, why in pairs.items() if not why.built or len(below.intersection(pair)) != 1}
    return change if len(kept) == len(pairs) else replace(change, state=replace(change.state, allowed_pairs=kept))


def clear_world(change: Change, command: ClearWorld, forward: Forward) -> Change:
    """Take everything away but the root; running motions end where they are."""
    root = {WORLD_UID: change.structure.nodes[WORLD_UID]}
    ended = (*change.state.ended, *all_ended(change.state, EndCause.WORLD_CLEARED, "the world was cleared"))
    state = replace(
        change.state,
        motions=(),
        ended=ended,
        signals={},
        speed_factor=1.0,
        collisions=NOTHING_SET,
        physics=None,
        twists={},
        epoch=change.state.epoch + 1,
    )
    return rebuilt(replace(change, state=state), root, change.structure.next_uid, {})


def all_ended(state: State, cause: EndCause, reason: str) -> tuple[Motion, ...]:
    """Return the running motions, ended where they are."""
    cancellation = Cancellation(cause, reason)
    return tuple(
        replace(motion, running=motion.running.abort(), cancellation=cancellation, end_tick=state.tick)
        for motion in state.motions
    )


@contextmanager
def _about(place: int) -> Iterator[None]:
    """Note in errors which of the nodes to create they are about."""
    try:
        yield
    except KernelError as error:
        error.metadata[PLACE] = str(place)
        raise


def _renamed_with(structure: Structure, old: Node, new: Node) -> dict[int, Node]:
    """Return the nodes, by uid, whose names or data follow when a node gets another name."""
    robot = structure.robot_of(old.uid)
    if old.kind is Kind.ROBOT:
        prefix = old.name + "."
        links = (structure.nodes[uid] for uid in structure.robots[old.uid].links)
        result = {
            link.uid: replace(link, name=f"{new.name}.{link.name.removeprefix(prefix)}")
            for link in links
            if link.name.startswith(prefix)
        }
        if isinstance(new.data, RobotData) and new.data.flange.startswith(prefix):
            flange = f"{new.name}.{new.data.flange.removeprefix(prefix)}"
            result[new.uid] = replace(new, data=replace(new.data, flange=flange))
        return result
    if old.kind is Kind.LINK and robot is not None and isinstance(robot.data, RobotData):
        data = _with_link_renamed(robot.data, robot.name, old.name, new.name)
        return {} if data is robot.data else {robot.uid: replace(robot, data=data)}
    return {}


def _with_link_renamed(data: RobotData, robot: str, old: str, new: str) -> RobotData:
    """Return a robot's data with a link's other name wherever it names the link."""
    if old in (data.flange, f"{robot}.{data.flange}"):
        data = replace(data, flange=new)
    if data.groups or data.allowed_collisions:
        before, after = old.removeprefix(f"{robot}."), new.removeprefix(f"{robot}.")

        def named(name: str) -> str:
            return after if name == before else name

        data = replace(
            data,
            groups=tuple(
                replace(group, base_link=named(group.base_link), tip_link=named(group.tip_link))
                for group in data.groups
            ),
            allowed_collisions=tuple(
                replace(pair, first=named(pair.first), second=named(pair.second)) for pair in data.allowed_collisions
            ),
        )
    return data


def _placed(structure: Structure, state: State, uid: int, pose: Pose) -> State:
    poses = state.parent_t_node.copy()
    poses[structure.rows[uid]] = pose
    return replace(state, parent_t_node=poses)


def _check_data(name: str, kind: Kind, data: object) -> None:
    wanted = DATA.get(kind)
    given = next((one.value for one, of in DATA.items() if isinstance(data, of)), "")
    if given and given != kind.value:
        raise KernelError(f"{name!r} is no {given.replace('_', ' ')} but {_a(kind)}: it has no such fields", node=name)
    if (wanted is None and data is not None) or (wanted is not None and not isinstance(data, wanted)):
        raise KernelError(
            f"the {kind.value} {name!r} needs the fields of {_a(kind)}, not {type(data).__name__}", node=name
        )


def _a(kind: Kind) -> str:
    """Return a kind of node with its article."""
    word = kind.value.replace("_", " ")
    return f"an {word}" if word[0] in "aeiou" else f"a {word}"


def _mounted(change: Change, tool: Node) -> Change:
    """Give a tool its first state, and make it the tool of its robots where they have none."""
    state, structure = change.state, change.structure
    assert isinstance(tool.data, ToolData)
    owner = structure.robot_of(tool.uid)
    if tool.data.states and tool.uid not in state.tool_states:
        name, positions = next(iter(tool.data.states.items()))
        q = state.q.copy()
        if owner is not None and owner.uid not in state.commanded:
            refuse_while_moving(change, owner, {(owner.uid, joint) for joint in positions})
            for joint, value in positions.items():
                q[single_joint(structure, owner, joint)[1]] = value
            check_actuators(structure, owner, q)
        state = replace(state, q=q, tool_states={**state.tool_states, tool.uid: name})
    chosen = Selection(tool.uid, next(iter(tool.data.tool_center_points), ""))
    free = (uid for uid in _robots(structure, tool) if not state.selections.get(uid, Selection()).tool)
    state = replace(state, selections={**state.selections, **dict.fromkeys(free, chosen)})
    return replace(change, state=state)


def _dismounted(change: Change, tool: Node) -> Change:
    mounted = _robots(change.structure, tool)
    selections = {
        robot: Selection() if selection.tool == tool.uid and robot not in mounted else selection
        for robot, selection in change.state.selections.items()
    }
    return replace(change, state=replace(change.state, selections=selections))


def _robots(structure: Structure, tool: Node) -> list[int]:
    return [*robots_of_tool(structure.nodes, tool.uid)]

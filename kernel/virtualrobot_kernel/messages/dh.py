"""Denavit-Hartenberg tables: messages to tables and joints, every refusal naming row and field."""

from __future__ import annotations

from collections.abc import Sequence

from virtualrobot.v1 import geometry_pb2, nodes_pb2, scene_pb2
from virtualrobot_sdk.denavit_hartenberg import GREATEST, Convention, PoseNumbers, Row, Table
from virtualrobot_sdk.poses import quaternion

from virtualrobot_kernel.errors import KernelError, Reason
from virtualrobot_kernel.messages.nodes import INERTIAL, JOINT_TYPES, LIMITS
from virtualrobot_kernel.messages.values import pose
from virtualrobot_kernel.units import degrees_question
from virtualrobot_kernel.world.structure import Inertial, Joint, JointType

FIELD = "denavit_hartenberg"
CONVENTIONS: dict[int, Convention] = {
    scene_pb2.DENAVIT_HARTENBERG_CONVENTION_STANDARD: "standard",
    scene_pb2.DENAVIT_HARTENBERG_CONVENTION_MODIFIED: "modified",
}
NUMBERS = ("a_meters", "alpha_radians", "d_meters", "theta_radians")
MOVING = (JointType.REVOLUTE, JointType.CONTINUOUS, JointType.PRISMATIC)
FOR_FILES = ("uri", "files", "as_part", "scale", "settings", "srdf_uri")
"""Fields of ModelSource that have no meaning for a table."""


def refuse_file_fields(request: scene_pb2.ModelSource) -> None:
    """Raise KernelError when a request with a table also says how to read a file."""
    given = [field.name for field, _ in request.ListFields() if field.name in FOR_FILES]
    if given:
        raise KernelError(
            f"{given[0]} belongs to a model that is read from a file, and {FIELD} is given too; give one or the other",
            field=given[0],
        )


def denavit_hartenberg(message: scene_pb2.DenavitHartenberg) -> tuple[Table, tuple[Joint, ...]]:
    """Return the table, and a joint about or along z for each row; raise KernelError that names row and field."""
    convention = CONVENTIONS.get(message.convention)
    if convention is None:
        names = ", ".join(scene_pb2.DenavitHartenbergConvention.Name(number) for number in CONVENTIONS)
        raise KernelError(f"{FIELD}.convention must be one of {names}", field=f"{FIELD}.convention", valid=names)
    if not message.rows:
        raise KernelError(f"{FIELD}.rows is empty; a table has a row for each joint", field=f"{FIELD}.rows")
    joints = tuple(_joint(row, place) for place, row in enumerate(message.rows))
    _check_names(joints)
    rows = tuple(_row(row, joint, place) for place, (row, joint) in enumerate(zip(message.rows, joints, strict=True)))
    first, flange = (
        _numbers(getattr(message, name), f"{FIELD}.{name}") if message.HasField(name) else None
        for name in ("base_t_first", "last_t_flange")
    )
    return Table(convention, rows, first, flange), joints


def row_inertials(message: scene_pb2.DenavitHartenberg) -> tuple[Inertial | None, ...]:
    """Return for each row the mass of its link, told in the row's frame, or None; raise KernelError that names it."""
    return tuple(
        INERTIAL.read(row.inertial, f"{FIELD}.rows[{place}].inertial") if row.HasField("inertial") else None
        for place, row in enumerate(message.rows)
    )


def _joint(row: scene_pb2.DenavitHartenbergRow, place: int) -> Joint:
    where = f"{FIELD}.rows[{place}]"
    limits = LIMITS.read(row.limits, f"{where}.limits")
    bounded = row.limits.HasField("lower") or row.limits.HasField("upper")
    kind = JOINT_TYPES.read(row.type, f"{where}.type")
    if row.type == nodes_pb2.JOINT_TYPE_UNSPECIFIED:
        kind = JointType.REVOLUTE if bounded else JointType.CONTINUOUS
    if kind not in MOVING:
        valid = ", ".join(one.value[0] for one in MOVING)
        raise KernelError(f"{where}.type is {kind.value[0]}; a row can be {valid}", field=f"{where}.type", valid=valid)
    if kind is JointType.CONTINUOUS and bounded:
        raise KernelError(
            f"{where}.limits: a continuous joint turns without end; leave lower and upper out, or make it revolute",
            field=f"{where}.limits",
        )
    return Joint(row.name or f"joint_{place + 1}", kind, (0.0, 0.0, 1.0), limits)


def _check_names(joints: Sequence[Joint]) -> None:
    first: dict[str, int] = {}
    for place, joint in enumerate(joints):
        if joint.name in first:
            raise KernelError(
                f"{FIELD}.rows[{place}].name: the joint {joint.name!r} is that of rows[{first[joint.name]}] already; "
                "names must differ",
                reason=Reason.NAME_TAKEN,
                name=joint.name,
            )
        first[joint.name] = place


def _row(row: scene_pb2.DenavitHartenbergRow, joint: Joint, place: int) -> Row:
    for name in NUMBERS:
        value = getattr(row, name)
        if not abs(value) <= GREATEST:
            field = f"{FIELD}.rows[{place}].{name}"
            raise KernelError(f"{field} is {value:g}; it must be a finite number of at most {GREATEST:g}", field=field)
        if name.endswith("_radians") and (question := degrees_question(value)):
            field = f"{FIELD}.rows[{place}].{name}"
            raise KernelError(f"{field} is {value:g}{question}", field=field, value=value)
    kind = "prismatic" if joint.type is JointType.PRISMATIC else "revolute"
    return Row(kind, *(getattr(row, name) for name in NUMBERS))


def _numbers(message: geometry_pb2.Pose, what: str) -> PoseNumbers:
    """Return a pose as x y z qx qy qz qw."""
    matrix = pose(message, what)
    x, y, z = matrix[:3, 3].tolist()
    return x, y, z, *quaternion(matrix[:3, :3])

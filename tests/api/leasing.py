"""Clients that hold leases, and who has leased what."""

from __future__ import annotations

import threading
from typing import Any

from google.protobuf.field_mask_pb2 import FieldMask
from virtualrobot.v1 import lease_pb2, motion_pb2, nodes_pb2, scene_pb2

from tests.api.asking import IIWA, apply, box, create, joints, load
from tests.kernels import KernelProcess, Stubs

CONTINUE = motion_pb2.DISCONNECT_POLICY_CONTINUE


class Holder:
    """A client of its own that leases robots, and keeps the lease until it lets go or is closed."""

    def __init__(self, kernel: KernelProcess, *robots: str, owner: str = "Ada", take: bool = False) -> None:
        """Lease, or take, the robots."""
        self.stubs = kernel.stubs()
        ask = lease_pb2.TakeLeaseRequest if take else lease_pb2.AcquireLeaseRequest
        call = self.stubs.lease.TakeLease if take else self.stubs.lease.AcquireLease
        self.given: Any = call(ask(robots=robots, owner=owner))
        self.metadata = (("virtualrobot-lease", self.given.token),)
        self.told: Any = self.stubs.lease.KeepLeaseAlive(lease_pb2.KeepLeaseAliveRequest(token=self.given.token))
        assert next(self.told).lease == self.given.lease

    def start(self, move: motion_pb2.Move, **fields: Any) -> str:  # noqa: ANN401 fields of the request
        """Start a move and return the motion's id."""
        request = motion_pb2.StartMotionRequest(
            spec=motion_pb2.MotionSpec(moves=[move]), on_disconnect=CONTINUE, **fields
        )
        return self.stubs.motion.StartMotion(request, metadata=self.metadata).motion.id

    def apply(self, *commands: scene_pb2.Command) -> None:
        """Apply commands as one batch."""
        self.stubs.scene.Apply(scene_pb2.ApplyRequest(commands=commands), metadata=self.metadata)

    def release(self) -> None:
        """Give the robots back."""
        self.stubs.lease.ReleaseLease(lease_pb2.ReleaseLeaseRequest(token=self.given.token))

    def vanish(self) -> None:
        """Close the connection without a word."""
        self.stubs.channel.close()


def leases(stubs: Stubs) -> list[lease_pb2.Lease]:
    return list(stubs.lease.ListLeases(lease_pb2.ListLeasesRequest()).leases)


def free(stubs: Stubs) -> None:
    """Wait until nothing is leased any more."""
    waiting = threading.Event()
    for _ in range(3000):
        if not leases(stubs):
            return
        waiting.wait(0.01)
    raise AssertionError(f"still leased: {leases(stubs)}")


def slow(robot: str) -> motion_pb2.Move:
    """Return a move that takes more than a minute."""
    return joints(robot, 0.003, lbr_iiwa_joint_1=2.0)


def update(name: str, node: nodes_pb2.Node, *fields: str) -> scene_pb2.Command:
    return scene_pb2.Command(
        update_node=scene_pb2.UpdateNode(name=name, node=node, update_mask=FieldMask(paths=fields))
    )


def two_arms(stubs: Stubs) -> None:
    """Load the arms `left` and `right`; `left` holds the part `box` by its tool `cup`, and `loose` lies on it."""
    for name in ("left", "right"):
        load(stubs, IIWA, name)
    tool = nodes_pb2.Tool(states=[nodes_pb2.ToolState(name="on"), nodes_pb2.ToolState(name="off")])
    apply(
        stubs,
        create(nodes_pb2.Node(name="cup", parent="left.lbr_iiwa_link_7", tool=tool)),
        create(box("box", z=1.3)),
        scene_pb2.Command(pick_part=scene_pb2.PickPart(robot="left", part="box")),
        create(box("loose", parent="left.lbr_iiwa_link_0")),
    )


def all_free(stubs: Stubs) -> None:
    """Take what is leased from whoever has it, and release it."""
    for lease in leases(stubs):
        taken = stubs.lease.TakeLease(lease_pb2.TakeLeaseRequest(robots=lease.robots)) if lease.robots else None
        if taken:
            stubs.lease.ReleaseLease(lease_pb2.ReleaseLeaseRequest(token=taken.token))
    free(stubs)

"""Clients of a kernel that come, lease, and vanish, and a look at all that can be read of a world."""

from __future__ import annotations

from collections.abc import Callable
from copy import deepcopy
from dataclasses import dataclass, field
from typing import Any

import grpc
import numpy as np
from google.protobuf.message import Message
from virtualrobot.v1 import lease_pb2, motion_pb2, nodes_pb2, robot_pb2, scene_pb2, signal_pb2

from tests.api.reading import matrices, matrix
from tests.kernels import Stubs

FAULTS = (grpc.StatusCode.INTERNAL, grpc.StatusCode.UNKNOWN, grpc.StatusCode.DEADLINE_EXCEEDED)
SECONDS = 120.0
"""Guard against a call that has no end."""

MOVED_BY_JOINTS = ("link",)
"""Kinds of nodes whose place in their parent a joint tells."""


@dataclass
class Client:
    """Client with a connection of its own, and perhaps a lease."""

    connect: Callable[[], Stubs]
    stubs: Stubs = field(init=False)
    token: str = ""
    lease: str = ""
    _kept: Any = None

    def __post_init__(self) -> None:
        """Connect."""
        self.stubs = self.connect()

    def ask(self, call: Callable[..., Any], request: Message) -> tuple[Any, grpc.StatusCode]:
        """Return the answer (None: refused) and the code of a call that carries the lease; a fault fails."""
        metadata = (("virtualrobot-lease", self.token),) if self.token else ()
        try:
            return call(request, metadata=metadata, timeout=SECONDS), grpc.StatusCode.OK
        except grpc.RpcError as error:
            refused: Any = error
            assert refused.code() not in FAULTS, f"{refused.code()}: {refused.details()} for {request}"
            return None, refused.code()

    def acquire(self, robots: list[str], take: bool) -> grpc.StatusCode:
        """Lease robots, or take them from whoever has them, and keep the lease."""
        request = (lease_pb2.TakeLeaseRequest if take else lease_pb2.AcquireLeaseRequest)(robots=robots, owner="x")
        answer, code = self.ask(self.stubs.lease.TakeLease if take else self.stubs.lease.AcquireLease, request)
        if answer is not None:
            self.token, self.lease = answer.token, answer.lease.id
            self._kept = self.stubs.lease.KeepLeaseAlive(lease_pb2.KeepLeaseAliveRequest(token=self.token))
            next(self._kept)
        return code

    def release(self) -> None:
        """Give the lease back, whoever has the robots meanwhile."""
        self.ask(self.stubs.lease.ReleaseLease, lease_pb2.ReleaseLeaseRequest(token=self.token))
        self.token = self.lease = ""

    def vanish(self) -> None:
        """Close the connection without a word."""
        self.stubs.channel.close()


@dataclass(frozen=True)
class Look:
    """All that can be read of a world, but for leases, motions and the clock."""

    scene: scene_pb2.GetSceneResponse
    robots: robot_pb2.GetRobotStatesResponse
    signals: signal_pb2.GetSignalsResponse

    @staticmethod
    def at(stubs: Stubs) -> Look:
        """Look."""
        return Look(
            stubs.scene.GetScene(scene_pb2.GetSceneRequest()),
            stubs.robot.GetRobotStates(robot_pb2.GetRobotStatesRequest()),
            stubs.signal.GetSignals(signal_pb2.GetSignalsRequest()),
        )

    def content(self) -> tuple[bytes, ...]:
        """Return it as bytes, without stamps: equal worlds have equal ones."""
        parts = []
        for message in (self.scene, self.robots, self.signals):
            bare = deepcopy(message)
            bare.ClearField("stamp")
            parts.append(bare.SerializeToString(deterministic=True))
        return tuple(parts)

    def by_name(self) -> dict[str, nodes_pb2.Node]:
        """Return the nodes by name."""
        return {node.name: node for node in self.scene.nodes}

    def of_kind(self, *kinds: str) -> list[str]:
        """Return the names of nodes of these kinds, in order."""
        return sorted(node.name for node in self.scene.nodes if node.WhichOneof("kind") in kinds)

    def edited(self) -> list[object]:
        """Return what undo covers: all but where joints are, values of signals, and which sensors run."""
        nodes = []
        for node in self.scene.nodes:
            bare = deepcopy(node)
            if bare.WhichOneof("kind") == "link":
                bare.ClearField("parent_t_node")
            if bare.WhichOneof("kind") == "range_sensor":
                bare.range_sensor.ClearField("running")
            nodes.append((bare.uid, bare.SerializeToString(deterministic=True)))
        tools = [(one.name, one.tool, one.tool_center_point, one.speed_factor) for one in self.robots.robots]
        signals = [(one.name, one.owner, one.description, one.value.WhichOneof("kind")) for one in self.signals.signals]
        return [*nodes, *tools, *sorted(signals)]

    def check_tree(self) -> None:
        """Fail unless the nodes are one tree with names of their own, and each is where its parent says."""
        nodes = self.by_name()
        assert len(nodes) == len(self.scene.nodes), "two nodes have one name"
        assert len({node.uid for node in self.scene.nodes}) == len(nodes), "two nodes have one uid"
        roots = [node.name for node in self.scene.nodes if not node.parent]
        assert roots == ["world"], f"roots: {roots}"
        above: set[str] = {""}
        for node in self.scene.nodes:  # parents come first, so there is no circle
            assert node.parent in above, f"{node.name!r} comes before its parent {node.parent!r}"
            above.add(node.name)
        places = dict(zip(nodes, matrices(self.scene.world_t_node), strict=True))
        for name, node in nodes.items():
            assert np.isfinite(places[name]).all(), f"{name!r} is nowhere"
            if node.parent and node.WhichOneof("kind") not in MOVED_BY_JOINTS:
                expected = places[node.parent] @ matrix(node.parent_t_node)
                assert np.allclose(places[name], expected, atol=1e-9), f"{name!r} has left {node.parent!r}"

    def places(self) -> dict[str, tuple[str, bytes]]:
        """Return parent and place in it of each node that no joint moves, by name."""
        return {
            node.name: (node.parent, node.parent_t_node.SerializeToString(deterministic=True))
            for node in self.scene.nodes
            if node.WhichOneof("kind") not in MOVED_BY_JOINTS
        }


def running(stubs: Stubs) -> list[motion_pb2.Motion]:
    """Return the motions that run."""
    return list(stubs.motion.ListMotions(motion_pb2.ListMotionsRequest(running_only=True)).motions)

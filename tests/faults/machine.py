"""World of faults as a machine of rules: hypothesis draws what clients do next, and shrinks what has failed."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import grpc
from google.protobuf.field_mask_pb2 import FieldMask
from hypothesis import strategies as st
from hypothesis.stateful import RuleBasedStateMachine, initialize, invariant, precondition, rule
from virtualrobot._wire.signal_values import set_command, value_message
from virtualrobot.v1 import (
    collision_pb2,
    geometry_pb2,
    history_pb2,
    kernel_pb2,
    lease_pb2,
    motion_pb2,
    nodes_pb2,
    scene_pb2,
    sensing_pb2,
    sensor_pb2,
    signal_pb2,
)

from tests.api.asking import box, create
from tests.faults.clients import Client, Look, running
from tests.kernels import EMPTY_SCENE, Stubs

MOST_CLIENTS = 3
ARMS = ("left", "right")
LEASED = grpc.StatusCode.PERMISSION_DENIED

numbers = st.integers(0, 1000)
"""Numbers by which one of several is chosen, whatever there is: small ones are simpler."""

meters = st.integers(-10, 10).map(lambda tenths: tenths / 10.0)
angles = st.integers(-4, 4).map(lambda quarters: quarters / 4.0)
Command = scene_pb2.Command


def some(names: list[str], number: int) -> str:
    """Return one of several names; a name that nothing has when there is none."""
    return names[number % len(names)] if names else "nobody"


def pose(x: float, y: float, z: float, turned: bool = False) -> geometry_pb2.Pose:
    """Return a pose, turned by 90 degrees about z or not."""
    turn = geometry_pb2.Quaternion(z=0.5**0.5, w=0.5**0.5) if turned else geometry_pb2.Quaternion(w=1.0)
    return geometry_pb2.Pose(position=geometry_pb2.Vector3(x=x, y=y, z=z), orientation=turn)


class WorldOfFaults(RuleBasedStateMachine):
    """Clients at one kernel, whose time stands unless one steps it; `connect` and `arm` are set by who runs it."""

    connect: Callable[[], Stubs]
    """Makes a connection of its own for each client."""
    arm: Path
    """URDF of the arms, without meshes: none of this is about shapes."""

    def __init__(self) -> None:
        """Connect an observer, who changes nothing but the end and the beginning."""
        super().__init__()
        self.watcher = Client(self.connect)
        self.clients: list[Client] = []
        self.seen: Look | None = None
        self.count = 0
        self.joints: list[str] = []
        self.kept: dict[str, tuple[Look, bool]] = {}
        """What was seen when a checkpoint was made, and whether something moved then."""
        self.restored = False
        self.start: list[object] = []
        self.first_step = 0

    @initialize()
    def begin(self) -> None:
        """Put two arms with a suction cup each and two parts into an empty world, and a client beside it."""
        self._free()
        stubs = self.watcher.stubs
        stubs.scene.LoadScene(scene_pb2.LoadSceneRequest(text=EMPTY_SCENE))
        for kept in stubs.history.ListCheckpoints(history_pb2.ListCheckpointsRequest()).checkpoints:
            stubs.history.RemoveCheckpoint(history_pb2.RemoveCheckpointRequest(name=kept.name))
        for place, name in enumerate(ARMS):
            model = scene_pb2.ModelSource(uri=str(self.arm), name=name, parent_t_node=pose(2.0 * place, 0.0, 0.0))
            stubs.scene.ImportModel(scene_pb2.ImportModelRequest(model=model))
        cups = [
            create(nodes_pb2.Node(name=f"{name}.cup", parent=f"{name}.panda_link7", tool=nodes_pb2.Tool()))
            for name in ARMS
        ]
        chosen = [Command(select_tool=scene_pb2.SelectTool(robot=name, tool=f"{name}.cup")) for name in ARMS]
        parts = [create(box(f"part {number}", x=0.5 * number, z=0.5)) for number in (1, 2)]
        stubs.scene.Apply(scene_pb2.ApplyRequest(commands=[*cups, *chosen, *parts]))
        self.joints = [f"panda_joint{number}" for number in range(1, 8)]
        self.clients = [Client(self.connect)]
        self.seen = Look.at(stubs)
        self.start, self.first_step = self.seen.edited(), self._edits()[0].number

    # Clients that come and go.

    @precondition(lambda self: len(self.clients) < MOST_CLIENTS)
    @rule()
    def come(self) -> None:
        """Let another client connect."""
        self.clients.append(Client(self.connect))

    @precondition(lambda self: len(self.clients) > 1)
    @rule(who=numbers)
    def vanish(self, who: int) -> None:
        """Let a client vanish without a word: its lease ends some time later."""
        self.clients.pop(who % len(self.clients)).vanish()

    @rule(who=numbers, which=st.sampled_from([["left"], ["right"], ["left", "right"]]), take=st.booleans())
    def lease(self, who: int, which: list[str], take: bool) -> None:
        """Lease arms: refused exactly when another one has them, unless they are taken."""
        client = self._client(who)
        if client.token:
            client.release()
        held = self._leased_by_others(client)
        code = client.acquire(which, take)
        if take:
            assert code is grpc.StatusCode.OK, code
        elif code is grpc.StatusCode.OK:
            assert not held & set(which) & self._leased_by_others(client), "two have leased one arm"

    @rule(who=numbers)
    def release(self, who: int) -> None:
        """Give arms back."""
        self._client(who).release()

    # Edits.

    @rule(who=numbers, on=numbers, x=meters, y=meters, turned=st.booleans(), part=st.booleans())
    def create(self, who: int, on: int, x: float, y: float, turned: bool, part: bool) -> None:
        """Create a part or an object, on anything."""
        self.count += 1
        node = box(f"box {self.count}", parent=some(self._all(), on))
        node.parent_t_node.CopyFrom(pose(x, y, 0.1, turned))
        if not part:
            node.object.SetInParent()
        self._edit(who, create(node))

    @rule(who=numbers, which=numbers)
    def remove(self, who: int, which: int) -> None:
        """Remove something with all that hangs on it."""
        self._edit(who, Command(remove_node=scene_pb2.RemoveNode(name=some(self._things(), which))))

    @rule(who=numbers, which=numbers, to=numbers, place=st.none() | st.tuples(meters, meters))
    def attach(self, who: int, which: int, to: int, place: tuple[float, float] | None) -> None:
        """Hang something on something else, where it is or at a place: never below itself."""
        attach = scene_pb2.AttachNode(name=some(self._things(), which), parent=some(self._all(), to))
        if place is not None:
            attach.parent_t_node.CopyFrom(pose(*place, 0.0))
        self._edit(who, Command(attach_node=attach))

    @rule(who=numbers, which=numbers, field=st.sampled_from(["name", "parent_t_node", "hidden"]), x=meters)
    def update(self, who: int, which: int, field: str, x: float) -> None:
        """Rename, move or hide something."""
        self.count += 1
        node = nodes_pb2.Node(name=f"named {self.count}", parent_t_node=pose(x, 0.0, 0.0), hidden=x > 0.0)
        name = some(self._things(), which)
        self._edit(
            who,
            Command(update_node=scene_pb2.UpdateNode(name=name, node=node, update_mask=FieldMask(paths=[field]))),
        )

    @rule(who=numbers, robot=st.sampled_from(ARMS), new=st.sampled_from(["left", "right", "middle"]))
    def rename_robot(self, who: int, robot: str, new: str) -> None:
        """Rename an arm, and its links with it, and back."""
        for old, name in ((robot, new), (new, robot)):
            node = nodes_pb2.Node(name=name)
            command = scene_pb2.UpdateNode(name=old, node=node, update_mask=FieldMask(paths=["name"]))
            if not self._edit(who, Command(update_node=command)):
                break

    @rule(who=numbers, first=numbers, second=numbers, allow=st.booleans())
    def allow(self, who: int, first: int, second: int, allow: bool) -> None:
        """Allow two things to touch, or no longer."""
        pair = nodes_pb2.NodePair(first=some(self._all(), first), second=some(self._all(), second), reason="so")
        pairs = collision_pb2.SetAllowedPairs(**{"allow" if allow else "forbid": [pair]})
        self._edit(who, Command(set_allowed_pairs=pairs))

    @rule(who=numbers, first=numbers, second=numbers)
    def batch_that_fails(self, who: int, first: int, second: int) -> None:
        """Ask for two edits that could be, and one that can't: none is made."""
        self.count += 1
        made = create(box(f"box {self.count}", parent=some(self._all(), first)))
        gone = Command(remove_node=scene_pb2.RemoveNode(name=some(self._things(), second)))
        wrong = Command(remove_node=scene_pb2.RemoveNode(name="nobody"))
        assert not self._edit(who, made, gone, wrong)

    @rule(who=numbers, which=st.integers(0, 3), kind=st.sampled_from(["create", "set", "remove"]), on=st.booleans())
    def signal(self, who: int, which: int, kind: str, on: bool) -> None:
        """Create, set or remove a signal."""
        name = f"signal {which}"
        if kind == "create":
            signal = signal_pb2.Signal(name=name, value=value_message(on), owner=ARMS[which] if which < 2 else "")
            command = Command(create_signal=scene_pb2.CreateSignal(signal=signal))
        elif kind == "remove":
            command = Command(remove_signal=scene_pb2.RemoveSignal(name=name))
        else:
            command = set_command(name, on)
        self._edit(who, command)

    @rule(who=numbers, on=numbers)
    def add_sensor(self, who: int, on: int) -> None:
        """Hang a range sensor with a few rays on something."""
        self.count += 1
        fan = sensing_pb2.Fan(count=3, start_angle_radians=-0.1, end_angle_radians=0.1)
        sensor = sensing_pb2.RangeSensor(
            pattern=sensing_pb2.ScanPattern(fan=fan), rate_hertz=25.0, max_range_meters=5.0
        )
        node = nodes_pb2.Node(name=f"sensor {self.count}", parent=some(self._all(), on), range_sensor=sensor)
        self._edit(who, create(node))

    @rule(who=numbers, start=st.booleans())
    def run_sensors(self, who: int, start: bool) -> None:
        """Start or stop all sensors."""
        names = self._look().of_kind("range_sensor")
        command = (
            Command(start_sensors=sensor_pb2.StartSensors(sensors=names))
            if start
            else Command(stop_sensors=sensor_pb2.StopSensors(sensors=names))
        )
        self._edit(who, command)

    # Arms.

    @rule(who=numbers, robot=st.sampled_from(ARMS), joint=st.integers(0, 6), angle=angles)
    def jump(self, who: int, robot: str, joint: int, angle: float) -> None:
        """Put a joint somewhere at once: what the arm holds keeps its place."""
        jump = scene_pb2.SetJointPositions(robot=robot, joint_positions={self.joints[joint]: angle})
        self._on_arm(who, robot, Command(set_joint_positions=jump))

    @rule(who=numbers, robot=st.sampled_from(ARMS), which=numbers)
    def pick(self, who: int, robot: str, which: int) -> None:
        """Pick a part: it stays where it is in the world."""
        part = some(self._look().of_kind("part"), which)
        self._on_arm(who, robot, Command(pick_part=scene_pb2.PickPart(robot=robot, part=part, max_distance_meters=9)))

    @rule(who=numbers, robot=st.sampled_from(ARMS), on=st.none() | numbers)
    def place(self, who: int, robot: str, on: int | None) -> None:
        """Let go of all parts."""
        parent = "" if on is None else some(self._all(), on)
        self._on_arm(who, robot, Command(place_part=scene_pb2.PlacePart(robot=robot, parent=parent)))

    @rule(who=numbers, robot=st.sampled_from(ARMS), mount=st.booleans())
    def tool(self, who: int, robot: str, mount: bool) -> None:
        """Choose the cup, or none."""
        chosen = scene_pb2.SelectTool(robot=robot, tool=f"{robot}.cup" if mount else "")
        self._on_arm(who, robot, Command(select_tool=chosen))

    @rule(who=numbers, robot=st.sampled_from(ARMS), joint=st.integers(0, 6), angle=angles, dwell=st.booleans())
    def move(self, who: int, robot: str, joint: int, angle: float, dwell: bool) -> None:
        """Start a move of a joint, or a program of it."""
        goal = motion_pb2.JointGoal(joint_positions={self.joints[joint]: angle})
        move = motion_pb2.Move(robot=robot, point_to_point=motion_pb2.PointToPoint(joints=goal))
        steps = [
            motion_pb2.ProgramStep(move=motion_pb2.MoveStep(moves=[move])),
            motion_pb2.ProgramStep(dwell=motion_pb2.DwellStep(seconds=0.1)),
        ]
        spec = motion_pb2.MotionSpec(steps=steps) if dwell else motion_pb2.MotionSpec(moves=[move])
        request = motion_pb2.StartMotionRequest(spec=spec, on_disconnect=motion_pb2.DISCONNECT_POLICY_CONTINUE)
        client = self._client(who)
        self._leasing(client, {robot}, client.stubs.motion.StartMotion, request)

    @rule(who=numbers, which=numbers, what=st.sampled_from(["Pause", "Resume", "Cancel"]))
    def steer(self, who: int, which: int, what: str) -> None:
        """Pause, resume or cancel a motion."""
        id = some([motion.id for motion in running(self.watcher.stubs)], which)
        request = getattr(motion_pb2, f"{what}MotionRequest")(id=id)
        client = self._client(who)
        client.ask(getattr(client.stubs.motion, f"{what}Motion"), request)

    @rule(ticks=st.integers(1, 60))
    def step(self, ticks: int) -> None:
        """Let time go on: joints may move, and nothing else changes its place in its parent."""
        before = self._look()
        stamp = self.watcher.stubs.kernel.StepClock(kernel_pb2.StepClockRequest(ticks=ticks)).stamp
        assert stamp.tick == before.scene.stamp.tick + ticks
        after = self._look()
        assert after.places() == before.places(), "time has moved what no joint moves"

    # History.

    @rule(who=numbers, mine=st.booleans(), which=st.none() | numbers, again=st.booleans())
    def undo(self, who: int, mine: bool, which: int | None, again: bool) -> None:
        """Take back the newest edit, or any; redone, all is as before."""
        client, before = self._client(who), self._look()
        request = history_pb2.UndoRequest(only_mine=mine)
        steps = self._edits()
        if which is not None:
            request.number = steps[which % len(steps)].number if steps else 1_000_000
        elif not mine and all(step.undone for step in steps):
            return  # what the world began with stays
        undone, _ = client.ask(client.stubs.history.Undo, request)
        if undone is None:
            assert self._look().content() == before.content(), "a refused undo has changed the world"
        elif again:
            redone, code = client.ask(client.stubs.history.Redo, history_pb2.RedoRequest(number=undone.step.number))
            assert redone is not None, code
            assert self._look().edited() == before.edited(), "an undo that was undone has left something"

    @rule(who=numbers, mine=st.booleans())
    def redo(self, who: int, mine: bool) -> None:
        """Take back the newest undo."""
        client, before = self._client(who), self._look()
        redone, _ = client.ask(client.stubs.history.Redo, history_pb2.RedoRequest(only_mine=mine))
        if redone is None:
            assert self._look().content() == before.content(), "a refused redo has changed the world"

    @precondition(lambda self: len(self.kept) < 3)
    @rule(who=numbers)
    def keep(self, who: int) -> None:
        """Keep the world under a name."""
        client, name = self._client(who), f"kept {len(self.kept)}"
        answer, code = client.ask(client.stubs.history.CreateCheckpoint, history_pb2.CreateCheckpointRequest(name=name))
        assert answer is not None, code
        self.kept[name] = self._look(), bool(running(self.watcher.stubs))

    @precondition(lambda self: self.kept)
    @rule(who=numbers, which=numbers)
    def restore(self, who: int, which: int) -> None:
        """Go back to a world that was kept, unless somebody else has leased an arm."""
        client, before = self._client(who), self._look()
        name = some(list(self.kept), which)
        request = history_pb2.RestoreCheckpointRequest(name=name)
        answer, _ = client.ask(client.stubs.history.RestoreCheckpoint, request)
        after = self._look()
        if answer is None:
            assert after.content() == before.content(), "a refused return has changed the world"
            return
        self.restored = True
        look, moved = self.kept[name]
        assert not running(self.watcher.stubs)
        assert after.scene.stamp.tick == before.scene.stamp.tick
        assert after.edited() == look.edited()
        if not moved:
            assert after.content() == look.content(), "the world is not as it was kept"

    # Files.

    @rule()
    def save_and_load(self) -> None:
        """Save the world, load it, and save it again: both files are the same, and nothing is elsewhere."""
        stubs = self.watcher.stubs
        self._free()
        before = self._look()
        saved = stubs.scene.SaveScene(scene_pb2.SaveSceneRequest()).text
        stubs.scene.LoadScene(scene_pb2.LoadSceneRequest(text=saved))
        again = stubs.scene.SaveScene(scene_pb2.SaveSceneRequest()).text
        assert again == saved
        after = self._look()
        assert after.places() == before.places()

    # What holds always.

    @invariant()
    def whole(self) -> None:
        """Look: the world is a tree, and counters only grow."""
        if self.seen is None:
            return
        look = Look.at(self.watcher.stubs)
        look.check_tree()
        for field in ("tick", "state_revision", "structure_revision"):
            before, after = (getattr(one.scene.stamp, field) for one in (self.seen, look))
            assert after >= before, f"{field} was {before} and is {after}"
        self.seen = look

    def teardown(self) -> None:
        """Undo all, and let everybody go."""
        if self.seen is not None:
            self._free()
            if not self.restored:
                self._undo_all()
        for client in (*self.clients, self.watcher):
            client.vanish()

    def _edits(self) -> list[history_pb2.Step]:
        """Return the edits since the start, newest first."""
        request = history_pb2.ListStepsRequest(kinds=[history_pb2.STEP_KIND_EDIT], page_size=1000)
        steps = self.watcher.stubs.history.ListSteps(request).steps
        return [step for step in steps if step.number > self.first_step]

    def _undo_all(self) -> None:
        """Take back all edits that stand, newest first: the world is as it was at the start."""
        stubs = self.watcher.stubs
        stubs.motion.Stop(motion_pb2.StopRequest())
        while running(stubs):
            stubs.kernel.StepClock(kernel_pb2.StepClockRequest(ticks=200))
        for step in self._edits():
            if not step.undone:
                stubs.history.Undo(history_pb2.UndoRequest(number=step.number))
        left = self._look().edited()
        assert left == self.start, f"undo of everything is not the start: {set(left) ^ set(self.start)}"

    def _free(self) -> None:
        """Take all leases and give them back, so that the observer may do what it wants."""
        stubs = self.watcher.stubs
        for lease in stubs.lease.ListLeases(lease_pb2.ListLeasesRequest()).leases:
            if lease.robots:
                taken = stubs.lease.TakeLease(lease_pb2.TakeLeaseRequest(robots=lease.robots))
                stubs.lease.ReleaseLease(lease_pb2.ReleaseLeaseRequest(token=taken.token))
        for client in self.clients:
            client.token = client.lease = ""

    def _client(self, number: int) -> Client:
        return self.clients[number % len(self.clients)]

    def _look(self) -> Look:
        return Look.at(self.watcher.stubs)

    def _all(self) -> list[str]:
        return sorted(self._look().by_name())

    def _things(self) -> list[str]:
        return self._look().of_kind("object", "part", "range_sensor")

    def _leases(self) -> dict[str, set[str]]:
        told = self.watcher.stubs.lease.ListLeases(lease_pb2.ListLeasesRequest()).leases
        return {lease.id: set(lease.robots) for lease in told}

    def _leased_by_others(self, client: Client) -> set[str]:
        return {robot for id, robots in self._leases().items() if id != client.lease for robot in robots}

    def _edit(self, who: int, *commands: Command) -> bool:
        """Ask for a batch, and return whether it was applied: when it is refused nothing has changed."""
        client, before = self._client(who), self._look()
        answer, _ = client.ask(client.stubs.scene.Apply, scene_pb2.ApplyRequest(commands=commands))
        after = self._look()
        if answer is None:
            assert after.content() == before.content(), "a refused batch has changed the world"
        else:
            assert answer.stamp.state_revision > before.scene.stamp.state_revision
        return answer is not None

    def _on_arm(self, who: int, robot: str, command: Command) -> None:
        """Ask for a command that moves or changes an arm."""
        client, before = self._client(who), self._look()
        request = scene_pb2.ApplyRequest(commands=[command])
        done = self._leasing(client, {robot}, client.stubs.scene.Apply, request)
        after = self._look()
        if not done:
            assert after.content() == before.content(), "a refused command has changed the world"
        elif command.WhichOneof("command") == "set_joint_positions":
            assert after.places() == before.places(), "a jump of joints has moved something in its parent"

    def _leasing(self, client: Client, robots: set[str], call: Any, request: Any) -> bool:  # noqa: ANN401 any call
        """Make a call that moves arms, and return whether it was done: never when another one has leased them."""
        before = self._leased_by_others(client)
        answer, code = client.ask(call, request)
        if robots & before & self._leased_by_others(client):
            assert code is LEASED or (client.token and code is grpc.StatusCode.FAILED_PRECONDITION), code
        return answer is not None

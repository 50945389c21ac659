"""A world on a hub: what it tells and hears, under conventional names, kept up as robots and sensors come and go."""

from __future__ import annotations

import asyncio
import tempfile
import threading
from collections.abc import Callable, Iterable, Mapping
from contextlib import suppress
from dataclasses import dataclass
from functools import partial
from pathlib import Path

from virtualrobot import Client
from virtualrobot.errors import VirtualRobotError
from virtualrobot.streams.table import IN, Stream
from virtualrobot.tables import aligned

from virtualrobot_apps.bridges.ros import actions
from virtualrobot_apps.bridges.ros.actions import TRAJECTORY
from virtualrobot_apps.bridges.ros.bridge_file import TWISTS, Choice
from virtualrobot_apps.bridges.ros.commands import TwistCommands
from virtualrobot_apps.bridges.ros.feed import Feed
from virtualrobot_apps.bridges.ros.hub import Action, Hub, HubError, Refused, Run, Topic
from virtualrobot_apps.bridges.ros.mapping.basics import RosValue
from virtualrobot_apps.bridges.ros.mapping.names import FrameNames, topic_name
from virtualrobot_apps.bridges.ros.mapping.outputs import Naming, Output, outputs_of
from virtualrobot_apps.bridges.ros.mapping.robots import commanded_twist
from virtualrobot_apps.bridges.ros.messages.message import Message
from virtualrobot_apps.bridges.ros.messages.types import make
from virtualrobot_apps.bridges.ros.planning_scene import COLLISION_OBJECT, OBJECTS, PlanningScene
from virtualrobot_apps.bridges.ros.proposals import TOLD, ProposalServices
from virtualrobot_apps.bridges.ros.proposals import TYPE as PROPOSALS
from virtualrobot_apps.bridges.ros.signals import TYPES, SignalTopics, kind_of, topics_of

DESCRIPTION = "std_msgs/msg/String"


@dataclass(frozen=True)
class Plan:
    """Contents of a world now.

    Attributes:
        outputs: what it tells, by the watch that tells it.
        twists: streams of twists by the names of their topics.
        robots: names of robots by the topics of their descriptions.
        grippers: robots and their tools that have widths.
    """

    outputs: Mapping[str, list[Output]]
    twists: Mapping[str, str]
    robots: Mapping[str, str]
    grippers: tuple[tuple[str, str], ...] = ()


class World:
    """A kernel's world on a hub. `update` is called from time to time, all else by the hub's loop."""

    def __init__(
        self,
        client: Client,
        hub: Hub,
        choice: Choice,
        *,
        bare: bool = False,
        say: Callable[[str], None] = print,
    ) -> None:
        """Tell and hear nothing yet; `bare` calls links as in the URDF."""
        self._client, self._hub, self._choice, self._bare, self._say = client, hub, choice, bare, say
        self._loop = asyncio.get_running_loop()
        self._revision: tuple[int, int] | None = None
        self._feeds: dict[str, tuple[list[tuple[str, str, str]], Feed]] = {}
        self._twists: dict[str, TwistCommands] = {}
        self._descriptions: set[str] = set()
        self._said: set[str] = set()
        self._actions: dict[str, Action] = {}
        self._trajectories: dict[str, str] = {}
        # What is said comes from threads; the hub's loop says it.
        self._signals = SignalTopics(client, hub, self._tell, self._soon) if choice.auto else None
        self._proposals = ProposalServices(client, hub, self._soon, bare=bare) if choice.auto else None
        if choice.auto:
            take = PlanningScene(client, self._tell, bare=bare).take
            self._declare(Topic(OBJECTS, COLLISION_OBJECT, take=take))

    async def update(self) -> None:
        """Look whether robots, sensors or links are others, and then declare what there is now.

        Raises:
            KernelGoneError: when the kernel has gone.
        """
        stamp = (await asyncio.to_thread(self._client.clock.read)).stamp
        revision = stamp.epoch, stamp.structure_revision
        if revision != self._revision:
            self._hub.now = round(stamp.simulation_time * 1e9)
            self._apply(await asyncio.to_thread(self._plan))
            self._revision = revision
        if self._signals:
            self._signals.open()
        if self._proposals:
            self._proposals.open()

    async def lines(self, more: Iterable[tuple[str, str, str]] = ()) -> list[str]:
        """Return what there is now, a line for each topic; `more` are others: name, type, and what it is of."""
        plan = await asyncio.to_thread(self._plan)
        found = [(one.topic, one.type, f"from {one.stream}") for outputs in plan.outputs.values() for one in outputs]
        found += [
            (topic, self._choice.type_of(stream, TWISTS[0]), f"to {stream}") for topic, stream in plan.twists.items()
        ]
        found += [(topic, DESCRIPTION, f"of {robot}") for topic, robot in plan.robots.items()]
        found += [(name, type, f"action of {robot}") for name, (type, robot, _) in self._wanted_actions(plan).items()]
        found += [(topic_name(one, "joint_trajectory"), TRAJECTORY, f"to {one}") for one in plan.robots.values()]
        found += [(OBJECTS, COLLISION_OBJECT, "to the scene")] if self._choice.auto else []
        found += [(TOLD, PROPOSALS, "proposals")] if self._choice.auto else []
        for one in await asyncio.to_thread(self._client.signals.read) if self._choice.auto else ():
            for name, way in zip(topics_of(one.name), ("from", "to"), strict=True):
                found.append((name, TYPES[kind_of(one.value)], f"{way} the signal {one.name}"))
        found += more
        return aligned([["topic", "type", "stream"], *map(list, sorted(found))], left=3)

    def close(self) -> None:
        """Tell and hear no more; crafts that follow twists stop."""
        if self._signals:
            self._signals.close()
        if self._proposals:
            self._proposals.close()
        self._apply(Plan({}, {}, {}))
        self._revision = None

    def _plan(self) -> Plan:
        table = self._client.streams.table()
        self._choice.check(table)
        robots = [one.about for one in table if one.content == "joint_states"]
        frames = FrameNames(robots, bare=self._bare)
        naming = Naming(frames, self._client.streams.scan_geometry, self._bases(table, frames))
        # The readings of a sensor end with it; one that takes its place under its name is watched anew.
        uids = {one.name: one.uid for one in self._client.scene.nodes()}
        found: dict[str, list[Output]] = {}
        for stream in table:
            if stream.direction != IN:
                for output in self._choice.outputs(stream, outputs_of(stream, naming)):
                    key = uids.get(stream.about) if stream.watch == "readings" else ""
                    found.setdefault(f"{stream.watch} {key}", []).append(output)
        for words in self._choice.missing([one.name for one in table]):
            if words not in self._said:
                self._tell(words)
            self._said.add(words)
        twists = {
            name: one.name
            for one in table
            if one.content == "twist" and (name := self._choice.heard(one, topic_name(one.about, "cmd_vel")))
        }
        described = {topic_name(one, "robot_description"): one for one in robots} if self._choice.auto else {}
        grippers: list[tuple[str, str]] = []
        for robot in described.values():
            tools = self._client.robots[robot].tools
            grippers += [(robot, tool) for tool in tools if self._client.robot(robot).tool(tool).widths]
        return Plan(found, twists, described, tuple(grippers))

    def _wanted_actions(self, plan: Plan) -> dict[str, tuple[str, str, Run]]:
        """Return type, robot and work of each action by its name."""
        found: dict[str, tuple[str, str, Run]] = {}
        for robot in plan.robots.values():
            run = partial(actions.follow_trajectory, self._client, robot)
            found[topic_name(robot, "follow_joint_trajectory")] = actions.FOLLOW, robot, run
        for robot, tool in plan.grippers:
            name = tool.removesuffix(".tool")
            grip, grip_parallel = (
                partial(one, self._client, robot, tool) for one in (actions.grip, actions.grip_parallel)
            )
            found[topic_name(name, "gripper_cmd")] = actions.GRIP, robot, grip
            found[topic_name(name, "parallel_gripper_cmd")] = actions.GRIP_PARALLEL, robot, grip_parallel
        return found

    def _bases(self, table: list[Stream], frames: FrameNames) -> dict[str, tuple[str, str]]:
        """Return in which frame the base of each robot moves, and which one moves with it."""
        found: dict[str, tuple[str, str]] = {}
        for stream in table:
            if stream.content == "base":
                links = self._client.robots[stream.about].links
                found[stream.about] = frames(stream.about), frames(links[0])
        return found

    def _apply(self, plan: Plan) -> None:
        hub = self._hub
        signs = {key: [(one.stream, one.topic, one.type) for one in outputs] for key, outputs in plan.outputs.items()}
        for key in [key for key, (sign, _) in self._feeds.items() if signs.get(key) != sign]:
            _, feed = self._feeds.pop(key)
            feed.close()
            for topic in feed.topics:
                hub.withdraw(topic)
        for key, outputs in plan.outputs.items():
            if key not in self._feeds:
                self._feeds[key] = signs[key], self._feed(outputs)
        for topic in [one for one in self._twists if one not in plan.twists]:
            hub.withdraw(topic)
            threading.Thread(target=self._twists.pop(topic).close, daemon=True).start()
        for topic, stream in plan.twists.items():
            if topic not in self._twists:
                commands = self._twists[topic] = TwistCommands(self._client, stream, self._tell)
                take = partial(_take_twist, commands)
                self._declare(Topic(topic, self._choice.type_of(stream, TWISTS[0]), take=take))
        for topic in [one for one in self._descriptions if one not in plan.robots]:
            self._descriptions.discard(topic)
            hub.withdraw(topic)
        for topic, robot in plan.robots.items():
            self._descriptions.add(topic)
            wanted = partial(self._describe, topic, robot)
            self._declare(Topic(topic, DESCRIPTION, latched=True, wanted=wanted, is_told=True))

        self._apply_actions(plan)

    def _apply_actions(self, plan: Plan) -> None:
        wanted = self._wanted_actions(plan)
        for name in [one for one in self._actions if one not in wanted]:
            self._hub.end(self._actions.pop(name))
        for name, (type, _, run) in wanted.items():
            if name not in self._actions:
                self._actions[name] = Action(name, type, run)
                self._hub.act(self._actions[name])
        heard = {topic_name(one, "joint_trajectory"): one for one in plan.robots.values()}
        for topic in [one for one in self._trajectories if one not in heard]:
            del self._trajectories[topic]
            self._hub.withdraw(topic)
        for topic, robot in heard.items():
            if topic not in self._trajectories:
                self._trajectories[topic] = robot
                take = actions.TrajectoryTopic(self._client, robot, self._tell).take
                self._declare(Topic(topic, TRAJECTORY, take=take))

    def _feed(self, outputs: list[Output]) -> Feed:
        feed = Feed(self._client, outputs, self._publish, self._tell)
        for one in outputs:
            wanted = partial(feed.want, one.topic)
            self._declare(
                Topic(one.topic, one.type, one.latched, one.reliable, wanted if one.lazy else None, is_told=True)
            )
            if not one.lazy:
                wanted(True)
        return feed

    def _declare(self, topic: Topic) -> None:
        try:
            self._hub.declare(topic)
        except HubError as error:
            self._say(str(error))

    def _publish(self, topic: str, message: Message) -> None:
        self._soon(self._publish_here, topic, message)

    def _publish_here(self, topic: str, message: Message) -> None:
        self._hub.now = max(self._hub.now, message.time)
        self._hub.publish(topic, message)

    def _tell(self, words: str) -> None:
        self._soon(self._say, words)

    def _soon(self, call: Callable[..., object], *arguments: object) -> None:
        """Let the hub's loop call something, from any thread; where it has ended meanwhile nobody hears it."""
        with suppress(RuntimeError):
            self._loop.call_soon_threadsafe(call, *arguments)

    def _describe(self, topic: str, robot: str, wanted: bool) -> None:
        """Publish the description of a robot as it is now, once somebody reads it."""
        if not wanted:
            return

        def work() -> None:
            try:
                with tempfile.TemporaryDirectory() as folder:
                    file = Path(folder) / "robot.urdf"
                    self._client.scene.export(robot, file)
                    text = file.read_text("utf-8")
            except (VirtualRobotError, OSError) as error:
                return self._tell(f"{topic}: {error}")
            self._publish(topic, Message(DESCRIPTION, make(DESCRIPTION, data=text), self._hub.now))

        threading.Thread(target=work, name=f"description of {robot}", daemon=True).start()


def _take_twist(commands: TwistCommands, value: RosValue, refused: Refused) -> None:
    commands.send(commanded_twist(value), refused)

"""One run of the demo in a kernel of its own, watched from outside."""

from __future__ import annotations

import io
import threading
from contextlib import redirect_stdout, suppress
from dataclasses import dataclass, field

import numpy as np
import virtualrobot
from numpy.typing import NDArray
from virtualrobot.kernel_process import KernelProcess
from virtualrobot.robots.values import JointLimits, RobotState
from virtualrobot.v1 import nodes_pb2, robot_pb2, signal_pb2
from virtualrobot_apps.demos.palletizing import palletize

SPEED = 15.0
"""Simulated seconds for each second of the wall clock."""

Poses = dict[str, NDArray[np.float64]]


@dataclass
class Record:
    """What was seen while the demo ran, and the world after it."""

    text: str = ""
    limits: dict[str, dict[str, JointLimits]] = field(default_factory=dict)
    states: dict[str, list[RobotState]] = field(default_factory=dict)
    signals: list[tuple[int, dict[str, bool]]] = field(default_factory=list)
    moved: list[Poses] = field(default_factory=list)
    nodes: dict[str, nodes_pb2.Node] = field(default_factory=dict)
    poses: Poses = field(default_factory=dict)


def watched_run(layers: int) -> Record:
    """Run the demo with so many layers of boxes; return what was seen."""
    record = Record()
    with KernelProcess(headless=True) as kernel, virtualrobot.connect(kernel.address) as client:
        client.clock.speed_factor = SPEED
        with virtualrobot.connect(kernel.address) as watcher:
            watches = [_watch_robots, _watch_signals, _watch_scene]
            threads = [threading.Thread(target=_until_closed, args=(watch, watcher, record)) for watch in watches]
            for thread in threads:
                thread.start()
            with redirect_stdout(io.StringIO()) as text:
                palletize.main(client, headless=True, layers=layers)
        for thread in threads:
            thread.join()
        record.text = text.getvalue()
        record.limits = {robot.name: robot.limits for robot in client.robots()}
        nodes, poses = client.scene._read()
        record.nodes = {node.name: node for node in nodes}
        record.poses = {node.name: world_t_node for node, world_t_node in zip(nodes, poses, strict=True)}
    return record


def _until_closed(watch, watcher: virtualrobot.Client, record: Record) -> None:  # noqa: ANN001 one of the functions below
    with suppress(virtualrobot.VirtualRobotError):  # the watcher was closed: the run is over
        watch(watcher, record)


def _watch_robots(watcher: virtualrobot.Client, record: Record) -> None:
    for response in watcher.services.robot.WatchRobotStates(robot_pb2.WatchRobotStatesRequest(max_rate_hertz=200)):
        for robot in response.robots:
            record.states.setdefault(robot.name, []).append(RobotState.of(robot, response.stamp))


def _watch_signals(watcher: virtualrobot.Client, record: Record) -> None:
    for response in watcher.services.signal.WatchSignals(signal_pb2.WatchSignalsRequest()):
        record.signals.append((response.stamp.tick, {signal.name: signal.value.boolean for signal in response.signals}))


def _watch_scene(watcher: virtualrobot.Client, record: Record) -> None:
    for change in watcher.scene.watch(max_rate=60):
        record.moved.append(change.poses)

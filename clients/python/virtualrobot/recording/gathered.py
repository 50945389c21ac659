"""Changes that a watch has told one after the other, as one change."""

from __future__ import annotations

import threading
from typing import Any

import numpy as np

from virtualrobot._wire.messages import array_message, array_of
from virtualrobot.v1 import geometry_pb2, nodes_pb2, robot_pb2, scene_pb2


class Gathered:
    """States of robots and changes of the scene since they were taken last."""

    def __init__(self) -> None:
        """Begin with none."""
        self._lock = threading.Lock()
        self._robots: dict[str, robot_pb2.RobotState | None] = {}
        self._nodes: dict[int, nodes_pb2.Node | None] = {}
        self._rows: dict[int, Any] = {}

    def add(self, watch: str, message: Any) -> None:  # noqa: ANN401 what the watch tells
        """Take what the watch `robots` or `scene` has told."""
        with self._lock:
            if watch == "robots":
                self._robots.update({name: None for name in message.removed_names})
                self._robots.update({state.name: state for state in message.robots})
                return
            for uid in message.removed_uids:
                self._nodes[uid] = None
                self._rows.pop(uid, None)
            # Parents come before their children, also where they were told of before.
            for node in message.nodes:
                self._nodes.pop(node.uid, None)
                self._nodes[node.uid] = node
            self._rows.update(zip(message.moved_uids, array_of(message.world_t_node).reshape(-1, 7), strict=True))

    def taken(self, stamp: geometry_pb2.Stamp) -> dict[str, Any]:
        """Return what has changed, by watch, as if it had all changed at a stamp."""
        with self._lock:
            robots, nodes, rows = self._robots, self._nodes, self._rows
            self._robots, self._nodes, self._rows = {}, {}, {}
        found: dict[str, Any] = {}
        if robots:
            found["robots"] = robot_pb2.WatchRobotStatesResponse(
                stamp=stamp,
                robots=filter(None, robots.values()),
                removed_names=[name for name, state in robots.items() if state is None],
            )
        if nodes or rows:
            found["scene"] = scene_pb2.WatchSceneResponse(
                stamp=stamp,
                nodes=filter(None, nodes.values()),
                removed_uids=[uid for uid, node in nodes.items() if node is None],
                moved_uids=rows,
                world_t_node=array_message(np.stack(list(rows.values()))) if rows else None,
            )
        return found

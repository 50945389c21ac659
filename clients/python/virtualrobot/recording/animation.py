"""Animated scenes: the world and how it moved, as binary glTF that viewers and modellers play (`.glb`)."""

from __future__ import annotations

import math
import threading
from collections import Counter
from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, BinaryIO

import numpy as np
from numpy.typing import NDArray

from virtualrobot._wire.messages import array_of
from virtualrobot._wire.services import Services
from virtualrobot.files.assets import Assets
from virtualrobot.recording.gltf import Export, Parts, Taking
from virtualrobot.recording.looks import above, exported, look_of, topmost
from virtualrobot.v1 import robot_pb2, scene_pb2

Row = NDArray[np.float64]

RATE_HERTZ = 60.0
"""Poses a second where no rate is given: between them viewers go straight, 0.1 mm beside an arm that turns fast."""

_SAME = 1e-9
"""Difference of poses that stand still, in meters or parts of a quaternion."""


@dataclass(slots=True)
class Look:
    """Figures of a node, and the times (s) from and until which it looks so."""

    figures: tuple[int, ...]
    begin: float
    end: float = math.inf


@dataclass(slots=True)
class Track:
    """A node that is watched: its places in the world (x, y, z and a quaternion) by times (s), and its looks."""

    name: str
    parent: str
    look: bytes
    times: list[float] = field(default_factory=list)
    rows: list[Row] = field(default_factory=list)
    looks: list[Look] = field(default_factory=list)

    def add(self, time: float, before: float, row: Row) -> None:
        """Take a place at a time; until the time that was told `before` it was where it was."""
        if self.rows:
            # A quaternion and its negative are the same turn, but not the same way there.
            if row[3:] @ self.rows[-1][3:] < 0.0:
                row = np.concatenate([row[:3], -row[3:]])
            if np.abs(row - self.rows[-1]).max() <= _SAME:
                return
            if before > self.times[-1]:
                self.times.append(before)
                self.rows.append(self.rows[-1])
        if self.times and time <= self.times[-1]:
            self.rows[-1] = row
            return
        self.times.append(time)
        self.rows.append(row)


class AnimationOutput:
    """A recording as an animated scene. Its methods take what watches tell, one at a time.

    Nodes that come later and go, and tools that look different in another state, are there as long as they were.

    Attributes:
        watches: the watches that it wants.
        counts: how many nodes, looks and places the file has, when it is closed.
        notes: none; nothing is left out.
    """

    watches = frozenset({"robots", "scene"})
    idle = True
    notes: Sequence[str] = ()

    def __init__(self, services: Services, write: Callable[[bytes, Mapping[str, str]], None]) -> None:
        """Begin with no node; `write` takes the whole file at the end, and what is known of the recording."""
        self.counts: Counter[str] = Counter()
        self._services, self._write = services, write
        self._lock = threading.Lock()
        self._parts = Parts()
        self._exports: dict[str, tuple[Export, Taking]] = {}
        self._upright = [0.0, 0.0, 0.0, 1.0]
        self._begin: float | None = None
        self._now = 0.0
        self._tracks: dict[int, Track] = {}
        self._gone: list[Track] = []
        self._tool_states: dict[str, dict[str, str]] = {}

    def take(self, watch: str, message: Any) -> None:  # noqa: ANN401 what the watch tells
        """Take what one of the watches tells, each of which has a thread of its own."""
        with self._lock:
            (self._robots if watch == "robots" else self._scene)(message)

    def _robots(self, message: robot_pb2.WatchRobotStatesResponse) -> None:
        changed: list[str] = []
        for state in message.robots:
            now = dict(state.tool_states)
            before = self._tool_states.get(state.name, now)
            self._tool_states[state.name] = now
            changed += [tool for tool in now if before.get(tool) != now[tool]]
        if changed:
            self._look_again(changed, self._time(message.stamp.simulation_time_seconds))

    def _time(self, simulation_time: float) -> float:
        """Return the time in the file of a simulation time: it begins with what was told first."""
        if self._begin is None:
            self._begin = simulation_time
        return max(simulation_time - self._begin, 0.0)

    def _scene(self, message: scene_pb2.WatchSceneResponse) -> None:
        time = self._time(message.stamp.simulation_time_seconds)
        for uid in message.removed_uids:
            if (track := self._tracks.pop(uid, None)) is not None:
                _end(track, time)
                self._gone.append(track)
        different = []
        for node in message.nodes:
            look = look_of(node)
            known = self._tracks.get(node.uid)
            if known is None or (known.look, known.name) != (look, node.name):
                different.append(node.name)
            if known is None:
                self._tracks[node.uid] = Track(node.name, node.parent, look)
            else:
                known.name, known.parent, known.look = node.name, node.parent, look
        rows = array_of(message.world_t_node).reshape(-1, 7)
        for uid, row in zip(message.moved_uids, rows, strict=True):
            if (track := self._tracks.get(uid)) is not None:
                track.add(time, self._now, row)
        if different:
            self._look_again(different, time)
        self._now = max(self._now, time)

    def _look_again(self, names: Collection[str], time: float) -> None:
        """Ask for the looks of nodes and of all below them, which are so from a time on."""
        parents = {track.name: track.parent for track in self._tracks.values()}
        by_name = {track.name: track for track in self._tracks.values()}
        for root in topmost(names, parents):
            for name in parents:
                if name == root or root in above(name, parents):
                    _end(by_name[name], time)
            for name, figures in self._exported(root):
                if name in by_name:
                    by_name[name].looks.append(Look(figures, time))

    def _exported(self, root: str) -> list[tuple[str, tuple[int, ...]]]:
        """Return the figures of a node and of those below it, by name, taken into the file."""
        if (sha256 := exported(self._services, root)) is None:
            return []
        if sha256 not in self._exports:
            export = Export(Assets(self._services).download(sha256))
            self._upright = export.upright
            self._exports[sha256] = export, export.taking(self._parts)
        export, taking = self._exports[sha256]
        return [(name, tuple(map(taking.figure, figures))) for name, figures in export.figures()]

    def close(self, about: Mapping[str, str]) -> None:
        """Write the file."""
        with self._lock:
            tracks = [*self._gone, *self._tracks.values()]
            end = max(self._now, self._time(float(about["end_seconds"])))
            channels: list[dict[str, Any]] = []
            samplers: list[dict[str, Any]] = []
            shown = [
                place
                for track in tracks
                if track.rows
                for look in track.looks
                if look.begin < look.end
                for place in [self._node(track, look, end, channels, samplers)]
            ]
            root = self._parts.add("nodes", {"name": "world", "rotation": self._upright, "children": shown})
            if samplers:
                self._parts.add("animations", {"name": "run", "channels": channels, "samplers": samplers})
            self.counts.update(nodes=len({track.name for track in tracks if track.looks}), looks=len(shown))
            self.counts["places"] = sum(len(track.rows) for track in tracks if track.looks)
            extras = {"duration": end, **about}
            self._parts.kept.setdefault("asset", {"version": "2.0", "generator": "VirtualRobot"})
            self._write(self._parts.file(scene=0, scenes=[{"nodes": [root], "extras": extras}]), about)

    def _node(
        self, track: Track, look: Look, end: float, channels: list[dict[str, Any]], samplers: list[dict[str, Any]]
    ) -> int:
        """Add a node that is there and looks so for its time, and goes its way; return its place."""
        times, rows = np.array(track.times), np.stack(track.rows)
        node = {"name": track.name, "children": list(look.figures)}
        place = self._parts.add("nodes", node)

        def animate(path: str, at: NDArray[np.float64], values: NDArray[np.float64], law: str = "LINEAR") -> None:
            given = {"input": self._parts.add_values(at[:, None]), "output": self._parts.add_values(values)}
            samplers.append({**given, "interpolation": law})
            channels.append({"sampler": len(samplers) - 1, "target": {"node": place, "path": path}})

        node["translation"], node["rotation"] = rows[0, :3].tolist(), rows[0, 3:].tolist()
        if len(rows) > 1:
            animate("translation", times, rows[:, :3])
            animate("rotation", times, rows[:, 3:])
        changes = [(0.0, 0.0 if look.begin > 0.0 else 1.0)]
        changes += [(look.begin, 1.0)] if look.begin > 0.0 else []
        changes += [(look.end, 0.0)] if look.end <= end else []
        if len(changes) > 1:
            at, sizes = np.array(changes).T
            animate("scale", at, np.repeat(sizes[:, None], 3, axis=1), "STEP")
        return place


def _end(track: Track, time: float) -> None:
    """Let a node look as it did only until a time."""
    if track.looks and track.looks[-1].end == math.inf:
        track.looks[-1].end = time


def glb_file(stream: BinaryIO) -> Callable[[bytes, Mapping[str, str]], None]:
    """Return what writes an animated scene to a file as it is."""

    def write(data: bytes, _: Mapping[str, str]) -> None:
        stream.write(data)

    return write

"""Bags as lines, which `rosbag` for MATLAB and Octave reads: those of ROS 1 and of ROS 2."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from click.testing import CliRunner
from mcap.writer import Writer
from rosbags.rosbag1 import Writer as Writer1
from rosbags.rosbag2 import StoragePlugin
from rosbags.rosbag2 import Writer as Writer2
from rosbags.typesys import Stores, get_typestore
from virtualrobot_apps.bridges.ros.bag import main

from tests.apps.ros.octave import needs_octave, octave
from tests.tiers import Draws

SECOND = 1_000_000_000


def ros1(path: Path) -> Path:
    """Write a bag of ROS 1 with a scan a second and a text, and return it."""
    store = get_typestore(Stores.ROS1_NOETIC)
    path = path.with_suffix(".bag")
    with Writer1(path) as writer:
        write(store, writer, lambda message, type: store.serialize_ros1(message, type), seq=7)
    return path


def ros2(plugin: StoragePlugin) -> Callable[[Path], Path]:
    """Return what writes the same bag of ROS 2."""

    def written(path: Path) -> Path:
        store = get_typestore(Stores.ROS2_JAZZY)
        with Writer2(path, version=9, storage_plugin=plugin) as writer:
            write(store, writer, lambda message, type: store.serialize_cdr(message, type))
        return path

    return written


def write(store: Any, writer: Any, packed: Callable[[Any, str], bytes | memoryview], **more: int) -> None:  # noqa: ANN401
    """Write the messages of a bag: at 1, 2 and 3 s a scan whose first range is its time, at 2 s a text."""
    types = store.types
    scans = writer.add_connection("/scan", "sensor_msgs/msg/LaserScan", typestore=store)
    texts = writer.add_connection("/talk", "std_msgs/msg/String", typestore=store)
    for second in (1, 2, 3):
        stamp = types["builtin_interfaces/msg/Time"](sec=second, nanosec=5)
        header = types["std_msgs/msg/Header"](stamp=stamp, frame_id="lidar", **more)
        ranges = np.array([second, 2.0, np.inf], np.float32)
        none = np.array([], np.float32)
        scan = types["sensor_msgs/msg/LaserScan"](header, 0.0, 1.0, 0.5, 0.0, 0.1, 0.2, 10.0, ranges, none)
        writer.write(scans, second * SECOND, packed(scan, scans.msgtype))
        if second == 2:
            writer.write(texts, second * SECOND, packed(types["std_msgs/msg/String"](data="two Ω"), texts.msgtype))


BAGS = {"ROS 1": ros1, "ROS 2 mcap": ros2(StoragePlugin.MCAP), "ROS 2 sqlite3": ros2(StoragePlugin.SQLITE3)}
kinds = pytest.mark.parametrize("kind", sorted(BAGS))


def lines_of(*arguments: str) -> list[dict[str, Any]]:
    """Return the lines that the program writes."""
    done = CliRunner().invoke(main, arguments)
    assert done.exit_code == 0, done.output
    return [json.loads(line) for line in done.output.splitlines()]


@kinds
def test_lines_tell_topics_types_and_messages(kind: str, tmp_path: Path) -> None:
    path = BAGS[kind](tmp_path / "run")
    (head,) = lines_of(str(path))
    assert head["first"] == 1.0 and head["last"] == pytest.approx(3.0)
    assert [(one["topic"], one["type"], one["count"]) for one in head["topics"]] == [
        ("/scan", "sensor_msgs/msg/LaserScan", 3),
        ("/talk", "std_msgs/msg/String", 1),
    ]
    scan = head["types"][0]["typedefs"][0]
    assert dict(zip(scan["fieldnames"], scan["fieldarraylen"], strict=True))["ranges"] == 0
    assert [one["type"] for one in head["types"][0]["typedefs"]][1:] == [
        *("std_msgs/msg/Header", "builtin_interfaces/msg/Time")
    ]
    _, *messages = lines_of(str(path), "--topic", "/scan", "--topic", "/talk", "--start", "1.5", "--end", "2.5")
    assert sorted((one["topic"], one["time"]) for one in messages) == [("/scan", 2.0), ("/talk", 2.0)]
    told = {one["topic"]: one["msg"] for one in messages}
    assert told["/talk"] == {"data": "two Ω"}
    assert told["/scan"]["ranges"] == [2.0, 2.0, None]  # JSON has no infinity
    assert told["/scan"]["header"]["stamp"] == {"sec": 2, "nanosec": 5}


def test_what_is_no_bag_or_has_no_such_topic_is_told(tmp_path: Path) -> None:
    for name in ("run.bag", "run.mcap", "run.txt"):
        (tmp_path / name).write_text("no bag")
        done = CliRunner().invoke(main, [str(tmp_path / name)])
        assert done.exit_code == 1 and f"{name} can't be read as a bag: " in done.output
    with (tmp_path / "run.mcap").open("wb") as file:
        writer = Writer(file)
        writer.start(profile="", library="test")
        writer.finish()
    done = CliRunner().invoke(main, [str(tmp_path / "run.mcap")])
    assert "it is not of ROS 2; recordings of `virtualrobot record` are for" in done.output
    path = ros1(tmp_path / "whole")
    done = CliRunner().invoke(main, [str(path), "--topic", "/scann"])
    assert done.exit_code == 2 and "has no topic /scann; it has /scan, /talk" in done.output.replace("\n", " ")
    path.write_bytes(path.read_bytes()[:-40])
    done = CliRunner().invoke(main, [str(path)])
    assert done.exit_code == 1 and "can't be read as a bag" in done.output


@kinds
def test_a_damaged_bag_is_one_line_or_read_as_far_as_it_goes(
    kind: str, tmp_path: Path, rng: np.random.Generator, draws: Draws
) -> None:
    path = BAGS[kind](tmp_path / "run")
    file = next(one for one in sorted(path.iterdir()) if one.suffix != ".yaml") if path.is_dir() else path
    whole = file.read_bytes()
    for number in range(draws(50)):
        damaged = bytearray(whole)
        if number % 2:
            del damaged[rng.integers(len(whole)) :]
        else:
            for place in rng.integers(len(whole), size=5):
                damaged[place] = rng.integers(256)
        file.write_bytes(damaged)
        done = CliRunner().invoke(main, [str(path), "--topic", "/scan"])
        last = done.output.strip().splitlines()[-1]
        assert isinstance(done.exception, SystemExit | None) and (not done.exit_code or "rror: " in last), last


@pytest.mark.long
@needs_octave
def test_octave_reads_each_kind(tmp_path: Path) -> None:
    for number, kind in enumerate(sorted(BAGS)):
        folder = tmp_path / f"it's {number}"  # a name that a shell has to be told with care
        folder.mkdir()
        path = BAGS[kind](folder / "run")
        said = octave(
            folder,
            f"""
bag = rosbag('{path.name}');
fprintf('%d %g %g\\n', bag.NumMessages, bag.StartTime, round(bag.EndTime));
scans = select(bag, 'Topic', '/scan', 'Time', [2 9]);
messages = readMessages(scans);
fprintf('%g', messages{{1}}.Ranges); fprintf(' %d %d', messages{{2}}.Header.Stamp.Sec, numel(messages));
fprintf(' %g', scans.Times, readScanAngles(messages{{1}}));
talk = readMessages(select(bag, 'Topic', {{'/talk'}}), 1);
fprintf(' %s\\n', talk{{1}}.Data);
try
  select(bag, 'Topic', '/scann');
catch problem
  disp(problem.message);
end
""",
        ).splitlines()
        missing = f"{path.name} has no topic '/scann'; it has /scan, /talk"
        assert said == ["4 1 3", "22NaN 3 2 2 3 0 0.5 1 two Ω", missing]

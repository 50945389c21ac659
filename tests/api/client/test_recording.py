"""Recordings of a real kernel, read back by the libraries of their formats."""

from __future__ import annotations

import csv
import errno
import io
import json
import subprocess
import sys
from collections import defaultdict
from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import virtualrobot
from foxglove_schemas_protobuf.JointStates_pb2 import JointStates
from mcap.exceptions import EndOfFile
from mcap.reader import NonSeekingReader, make_reader
from mcap_protobuf.decoder import DecoderFactory
from pyarrow import parquet
from virtualrobot import Client
from virtualrobot._wire.messages import array_of
from virtualrobot.recording import start
from virtualrobot.recording.mcap_file import McapFile
from virtualrobot.v1 import sensor_pb2

from tests.api.client.conftest import Run
from tests.kernels import KernelProcess, StartKernel, Stubs

ROWS = [{"a": 0.4, "limits": (-2.0, 2.0)}, {"a": 0.3, "limits": (-2.0, 2.0)}, {"type": "prismatic", "limits": (0, 0.2)}]
TICKS = 12

Messages = dict[str, list[tuple[int, Any]]]


@pytest.fixture
def cell(stepped_kernel: KernelProcess, stepped: Stubs) -> Iterator[Client]:
    """Return a client of a kernel in STEPPED mode with an arm, a table, a scanner, a camera and two signals."""
    with virtualrobot.connect(stepped_kernel.address) as client:
        client.load_denavit_hartenberg(ROWS, convention="standard", name="arm")
        scene = client.scene
        scene.add_object("table", virtualrobot.box(1.0, 1.0, 0.1, color="#336699"), pose=virtualrobot.pose(2.0))
        fan = virtualrobot.range_sensor(pattern=virtualrobot.fan(31, -1.2, 1.2), rate=250.0, running=True)
        scene.add_range_sensor("scanner", fan, pose=virtualrobot.pose(1.0))
        raster = virtualrobot.raster(4, 3, 0.5, 0.2)
        scene.add_range_sensor("cloud", virtualrobot.range_sensor(pattern=raster, rate=250.0, running=True))
        images = ["color", "depth", "segmentation"]
        camera = virtualrobot.camera(16, 12, rate=50.0, images=images, running=True)
        scene.add_camera("camera", camera, pose=virtualrobot.pose(0.0, 0.0, 0.3, 0.0, np.pi / 2, 0.0))
        scene.add_motion_sensor("encoders", virtualrobot.encoders(rate=250.0, running=True), parent="arm")
        client.signals.create("pressure", 1.5, unit="bar")
        client.signals.create("open", False)
        yield client


def read(path: Path) -> Messages:
    """Return the messages of an MCAP file by topic, each with its time (ns)."""
    found: Messages = defaultdict(list)
    with path.open("rb") as stream:
        for _, channel, message, decoded in make_reader(
            stream, decoder_factories=[DecoderFactory()]
        ).iter_decoded_messages():
            assert message.publish_time == message.log_time
            found[channel.topic].append((message.log_time, decoded))
    return found


def given(array: np.ndarray | None) -> np.ndarray:
    """Return an array that was asked for."""
    assert array is not None
    return array


def placed(messages: Messages) -> dict[str, np.ndarray]:
    """Return where all frames are in the world after the last message, 4x4 by name."""
    local = {"world": (None, np.eye(4))}
    for topic in ("/transforms/fixed", "/transforms"):
        for one in messages[topic][-1][1].transforms if messages[topic] else ():
            t, q = one.translation, one.rotation
            pose = virtualrobot.pose_from_quaternion((t.x, t.y, t.z), (q.x, q.y, q.z, q.w))
            assert one.child_frame_id not in local
            local[one.child_frame_id] = (one.parent_frame_id, pose)

    def world(name: str) -> np.ndarray:
        parent, pose = local[name]
        return pose if parent is None else world(parent) @ pose

    return {name: world(name) for name in local}


def test_each_tick_is_in_the_file_as_it_was(cell: Client, tmp_path: Path) -> None:
    arm = cell.robots["arm"]
    path = tmp_path / "run.mcap"
    seen = []
    with cell.start_recording(path) as recording:
        motion = arm.move_joints([0.5, -0.4, 0.1], wait=False, on_disconnect="continue")
        for _ in range(TICKS):
            recording.step()
            seen.append(arm.state)
        cell.signals["pressure"] = 2.5
        cell.scene.add_part("ball", virtualrobot.sphere(0.1), parent="arm", pose=virtualrobot.pose(0.0, 1.0))
        poses = cell.scene.poses()
        recorded = recording.finish()
    messages = read(path)
    assert {topic: len(told) for topic, told in messages.items()} == dict(recorded.counts)
    assert recorded.missed_ticks == recorded.missed_readings == 0 and not recorded.end_reason

    joints = {time: told for time, told in messages["/robots/arm/joint_states"]}
    for state in seen:
        told = joints[round(1e9 * state.stamp.simulation_time)].joints
        assert [one.name for one in told] == ["joint_1", "joint_2", "joint_3"]
        np.testing.assert_array_equal([one.position for one in told], state.positions)
        np.testing.assert_array_equal([one.velocity for one in told], state.velocities)
    assert len(joints) == TICKS + 1  # as it stood before
    tcp = messages["/robots/arm/tcp"][-1][1].pose.position
    np.testing.assert_array_equal([tcp.x, tcp.y, tcp.z], seen[-1].world_t_tcp[:3, 3])

    where = placed(messages)
    assert where.keys() == poses.keys()
    for name, world_t_node in poses.items():
        np.testing.assert_allclose(where[name], world_t_node, atol=1e-12)
    assert len(messages["/transforms"]) == TICKS + 1  # again with the part
    assert [one.child_frame_id for one in messages["/transforms"][-1][1].transforms] == [
        f"arm.link_{n}" for n in (1, 2, 3)
    ]

    assert "table" in [entity.id for entity in messages["/scene"][0][1].entities]
    assert ["ball"] == [entity.id for entity in messages["/scene/later"][0][1].entities]
    assert messages["/signals/pressure"][-1][1].value.number == 2.5
    assert messages["/motions"][-1][1].id == motion.id
    # Motions that ended before are told, too.
    words = [told.message for _, told in messages["/log"] if told.message.startswith(f"{motion.id}: ")]
    assert words[0] == f"{motion.id}: running"
    for told in messages.values():
        assert [time for time, _ in told] == sorted(time for time, _ in told)


def test_readings_are_those_that_sensors_give(cell: Client, tmp_path: Path) -> None:
    path = tmp_path / "run.mcap"
    with cell.start_recording(path, topics=["/sensors/*"]) as recording:
        recording.step(10)
        fan, cloud, picture = (
            cell.sensors[name].read(points=True, intensities=True) for name in ("scanner", "cloud", "camera")
        )
    messages = read(path)
    assert not [topic for topic in messages if not topic.startswith("/sensors/")]
    assert len(messages["/sensors/scanner/scan"]) == 10 and len(messages["/sensors/encoders/reading"]) == 10
    scan = messages["/sensors/scanner/scan"][-1][1]
    valid = fan.range.valid[0]
    assert valid.any() and not valid.all()
    np.testing.assert_array_equal(np.array(scan.ranges), np.where(valid, fan.range.distances[0], np.nan))
    np.testing.assert_array_equal(np.array(scan.intensities, np.float32), given(fan.range.intensities)[0])
    assert (scan.frame_id, scan.start_angle, scan.end_angle) == ("scanner", -1.2, 1.2)
    points = messages["/sensors/cloud/points"][-1][1]
    rows = np.frombuffer(points.data, "<f4").reshape(-1, points.point_stride // 4)
    np.testing.assert_array_equal(rows[:, :3], given(cloud.range.points)[cloud.range.valid])
    assert [field.name for field in points.fields] == ["x", "y", "z", "intensity"]
    for kind, dtype, pixels in (
        ("color", "u1", given(picture.camera.color)),
        ("depth", "<f4", given(picture.camera.depth)),
        ("segmentation", "<u2", given(picture.camera.segmentation) + 1),
    ):
        image = messages[f"/sensors/camera/{kind}"][-1][1]
        np.testing.assert_array_equal(np.frombuffer(image.data, dtype).reshape(pixels.shape), pixels)
        assert (image.width, image.height, image.step) == (16, 12, pixels.astype(dtype).strides[0])
    info = messages["/sensors/camera/camera_info"][-1][1]
    np.testing.assert_array_equal(np.reshape(info.K, (3, 3)), picture.camera.camera_matrix)


@pytest.mark.parametrize("ending", ["csv", "parquet"])
def test_a_table_has_a_row_for_each_tick(cell: Client, tmp_path: Path, ending: str) -> None:
    arm = cell.robots["arm"]
    path = tmp_path / f"run.{ending}"
    seen = []
    with cell.start_recording(path, topics=["arm/joint_*", "/signals/*"]) as recording:
        arm.move_joints([0.5, -0.4, 0.1], wait=False, on_disconnect="continue")
        for tick in range(TICKS):
            cell.signals.set({"pressure": float(tick), "open": tick > 5})
            recording.step()
            seen.append(arm.state)
        cell.signals.create("late")
    recorded = recording.finish()
    joints = [f"arm/joint_{number}/{what}" for number in (1, 2, 3) for what in ("position", "velocity")]
    names = ["time", "tick", *joints, "signals/pressure", "signals/open"]
    units = ["s", "", *["rad", "rad/s"] * 2, "m", "m/s", "bar", ""]
    if ending == "parquet":
        names, units = [*names, "signals/late"], [*units, ""]
    if ending == "csv":
        header, *lines = csv.reader(path.read_text().splitlines())
        assert header == [f"{name} [{unit}]" if unit else name for name, unit in zip(names, units, strict=True)]
        rows = [[json.loads(cell) for cell in line] for line in lines]
    else:
        table = parquet.read_table(path)
        assert table.column_names == names
        assert [(table.schema.field(name).metadata or {})[b"unit"].decode() for name in names] == units
        rows = [list(row.values()) for row in table.to_pylist()]
        assert parquet.read_metadata(path).metadata[b"missed_ticks"] == b"0"
    assert recorded.counts == {"columns": len(names), "rows": len(rows)}
    assert recorded.notes == (("/signals/late came when the table had its columns already",) if ending == "csv" else ())
    by_tick = {row[1]: row for row in rows}
    assert list(by_tick) == sorted(by_tick) and len(by_tick) == len(rows)
    for tick, state in enumerate(seen):
        row = by_tick[state.stamp.tick]
        assert row[0] == state.stamp.simulation_time
        assert row[2:8:2] == state.positions.tolist() and row[3:9:2] == state.velocities.tolist()
        assert row[8:10] == ([tick + 1.0, tick + 1 > 5] if tick + 1 < TICKS else [float(tick), tick > 5])


def test_one_of_so_many_ticks_holds_what_changed_in_all_of_them(cell: Client, tmp_path: Path) -> None:
    arm = cell.robots["arm"]
    path = tmp_path / "run.mcap"
    with cell.start_recording(path, topics=["/robots/*", "/transforms*"]) as recording:
        motion = arm.move_joints([0.5, -0.4, 0.1], wait=False, on_disconnect="continue")
        recording.step(10, every=4)
        begin = arm.state.stamp.tick - 10
        poses = cell.scene.poses()
    motion.cancel()
    messages = read(path)
    times = [time for time, _ in messages["/robots/arm/joint_states"]]
    assert sorted({time // 4_000_000 - begin for time in times}) == [0, 4, 8, 10]
    assert recording.finish().missed_ticks == 0
    where = placed(messages)
    for name, world_t_node in poses.items():
        np.testing.assert_allclose(where[name], world_t_node, atol=1e-12)


def test_looks_follow_their_nodes(cell: Client, tmp_path: Path) -> None:
    path = tmp_path / "run.mcap"
    scene = cell.scene
    with cell.start_recording(path, topics=["/scene*"]) as recording:
        scene.add_part("ball", virtualrobot.sphere(0.1))
        recording.step()
        scene.node("table").hide()
        recording.step()
        scene.node("table").hide(False)
        recording.step()
        scene.rename("table", "desk")
        recording.step()
        scene.remove("ball")
    messages = read(path)
    told = {topic: [[one.id for one in update.entities] for _, update in messages[topic]] for topic in messages}
    links = [name for name in told["/scene"][0] if name != "table"]
    assert told["/scene"] == [[*links, "table"], links]
    assert told["/scene/later"] == [["ball"], ["ball"], ["ball", "table"], ["ball", "desk"], ["desk"]]
    desk = messages["/scene/later"][-1][1]
    model = desk.entities[0].models[0]
    assert model.data[:4] == b"glTF" and model.media_type == "model/gltf-binary"
    assert desk.entities[0].frame_id == "desk" and desk.entities[0].frame_locked
    assert [one.type for one in desk.deletions] == [desk.deletions[0].ALL]


def test_what_a_killed_program_has_written_can_be_read() -> None:
    stream = io.BytesIO()
    file = McapFile(stream, {})
    for number in range(100):
        file.write("/joints", JointStates(), number)
    file.flush()
    whole = stream.tell()
    file.write("/joints", JointStates(), 100)
    file.flush()
    for end in (whole, whole + 1, stream.tell() - 1):
        messages = NonSeekingReader(io.BytesIO(stream.getvalue()[:end])).iter_messages(log_time_order=False)
        assert [next(messages)[2].log_time for _ in range(100)] == list(range(100))


class _Full(io.BytesIO):
    """A file on a disk that is full."""

    def write(self, data: Any) -> int:  # noqa: ANN401 bytes
        if self.tell() + len(data) > 4096:
            raise OSError(errno.ENOSPC, "No space left on device")
        return super().write(data)


def test_a_full_disk_ends_it_with_a_word(cell: Client, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(start, "_opened", lambda path, overwrite: _Full())
    recording = cell.start_recording(tmp_path / "run.mcap")
    recording.step()
    with pytest.raises(virtualrobot.WrongStateError, match=r"run\.mcap could not be written after .*No space left on"):
        recording.finish()


def test_what_cannot_be_recorded_is_refused(cell: Client, tmp_path: Path) -> None:
    (tmp_path / "there.mcap").touch()
    refused: list[tuple[str, dict[str, Any], str]] = [
        ("run.mp3", {}, r"let its name end with \.mcap, \.csv, \.parquet, \.glb or \.html"),
        ("missing/run.mcap", {}, "cannot be written: No such file or directory"),
        ("there.mcap", {}, "is there already"),
        ("run.mcap", {"topics": ["/robots/arm/joint_sates"]}, "did you mean '/robots/arm/joint_states'"),
        ("run.mcap", {"topics": ["/scenes"]}, "did you mean '/scene'"),
        ("run.csv", {"topics": ["arm/joint_4/position"]}, "did you mean 'arm/joint_"),
        ("run.mcap", {"rate": 0.0}, "rate is above 0, not 0"),
        ("run.mcap", {"duration": -1.0}, "duration is above 0, not -1"),
        ("run.mcap", {"pictures": "jpeg"}, "pictures are raw or png, not 'jpeg'"),
    ]
    for name, options, message in refused:
        with pytest.raises(virtualrobot.VirtualRobotError, match=message):
            cell.start_recording(tmp_path / name, **options)
    assert [path.name for path in tmp_path.iterdir()] == ["there.mcap"]
    assert not (tmp_path / "there.mcap").stat().st_size


def test_a_missing_package_is_named(client: Client, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    for name in [name for name in sys.modules if name.startswith("virtualrobot.recording.")]:
        if name.endswith(("_file", "mcap_output")):
            monkeypatch.delitem(sys.modules, name)
    for ending, package, extra in (("mcap", "mcap", "record"), ("parquet", "pyarrow", "parquet")):
        monkeypatch.setitem(sys.modules, package, None)
        monkeypatch.setitem(sys.modules, f"{package}.writer", None)
        said = rf"needs the package {package}: pip install 'virtualrobot\[{extra}\]'"
        with pytest.raises(virtualrobot.WrongStateError, match=said):
            client.start_recording(tmp_path / f"run.{ending}")


def test_the_command_records_in_real_time(run: Run, client: Client, tmp_path: Path) -> None:
    client.load_denavit_hartenberg(ROWS, convention="standard", name="arm")
    path = tmp_path / "run.mcap"
    said = run("record", str(path), "--seconds", "0.1", "--topics", "/robots/*")
    assert said.startswith(f"{path}: 0.100 s from ") and "/robots/arm/joint_states  1" in said
    assert "is there already" in run("record", str(path), code=1)
    run("record", str(path), "--seconds", "0.004", "--overwrite")
    assert "--fps is not for .mcap" in run("record", str(path), "--fps", "25", code=2)
    assert "--rate is not for .gif" in run("record", "run.gif", "--rate", "25", code=2)


def test_sensor_kinds_that_are_no_pictures_keep_their_message(cell: Client, tmp_path: Path) -> None:
    path = tmp_path / "run.mcap"
    with cell.start_recording(path, topics=["/sensors/encoders/*"]) as recording:
        recording.step()
    ((_, told),) = read(path)["/sensors/encoders/reading"]
    reading = cell.services.sensor.ReadSensor(sensor_pb2.ReadSensorRequest(sensor="encoders")).reading
    assert list(told.encoders.positions) == list(reading.encoders.positions)
    assert told.number == 1 and array_of(reading.range.distances).size == 0


@pytest.mark.long
def test_a_file_is_whole_when_the_kernel_ends(start_kernel: StartKernel, tmp_path: Path) -> None:
    kernel = start_kernel("--stepped")
    with virtualrobot.connect(kernel.address) as client:
        client.signals.create("pressure", 1.5)
        recording = client.start_recording(tmp_path / "run.mcap")
        recording.step(3)
        assert kernel.end() == 0
        assert recording.wait(60.0)
        recorded = recording.finish()
    assert "ending" in recorded.end_reason and recorded.end - recorded.start == pytest.approx(0.012)
    assert read(tmp_path / "run.mcap")["/signals/pressure"][0][1].value.number == 1.5


@pytest.mark.long
def test_a_recorder_that_is_killed_leaves_what_it_had_flushed(
    kernel: KernelProcess, client: Client, tmp_path: Path
) -> None:
    client.signals.create("count", 0)
    path = tmp_path / "run.mcap"
    command = [sys.executable, "-m", "virtualrobot", "record", str(path), "--address", kernel.address]
    recorder = subprocess.Popen([*command, "--topics", "/signals/*"])

    def told() -> list[int]:
        try:
            with path.open("rb") as stream:
                reader = NonSeekingReader(stream, decoder_factories=[DecoderFactory()])
                messages = reader.iter_decoded_messages(log_time_order=False)
                values = []
                with suppress(EndOfFile):
                    values.extend(one[3].value.integer for one in messages)
        except (FileNotFoundError, EndOfFile):
            return []
        return values

    count = 0
    while not told():  # it writes what it has each second
        count += 1
        client.signals["count"] = count
    recorder.kill()
    recorder.wait()
    values = told()
    assert values == list(range(values[0], values[-1] + 1))

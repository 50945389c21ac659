"""Streams of a world: the table, samples of each kind, what is published, and the command line."""

from __future__ import annotations

import math
import xml.etree.ElementTree as ElementTree
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
import virtualrobot
from virtualrobot import Client
from virtualrobot.errors import InvalidArgumentError, UnknownNameError
from virtualrobot.geometry import poses_from_rows
from virtualrobot.streams.sample import Sample
from virtualrobot.streams.statistics import bandwidth, rate
from virtualrobot.streams.streams import told_streams
from virtualrobot.streams.watch import StreamWatch

from tests.api.client.conftest import IIWA, Run
from tests.waiting import until

TICK = 0.004
LINK = "arm.lbr_iiwa_link_7"


@pytest.fixture
def world(client: Client) -> Iterator[Client]:
    """Return a client of a stepped world with an arm, a UGV, a camera, a force sensor and a signal."""
    client.clock.set_stepped()
    client.load_robot(IIWA, name="arm", pose=virtualrobot.pose(y=3.0))
    client.load_robot("model://ugv", base="planar")
    client.scene.add_camera("eye", virtualrobot.camera(64, 48, images=["color", "depth"], rate=10.0))
    client.scene.add_contact_sensor("near", virtualrobot.contact_sensor("arm", rate=20.0))
    client.scene.add_object("wall", virtualrobot.box(0.1, 2.0, 0.5), pose=virtualrobot.pose(x=1.0, z=0.25))
    client.signals.create("pressure", 1.5, unit="bar")
    yield client
    client.clock.set_realtime()


def taken(watch: StreamWatch, count: int) -> list[Sample]:
    """Return so many samples."""
    found: list[Sample] = []
    while len(found) < count:
        sample = watch.next(60.0)
        assert sample is not None
        found.append(sample)
    return found


def test_the_table_names_what_a_world_tells_and_hears(world: Client) -> None:
    table = world.streams
    joints = table["/robots/arm/joint_states"]
    assert (joints.type, joints.rate, joints.unit, joints.direction) == ("RobotState", 250.0, "rad", "out")
    assert (table["/robots/arm/tcp"].unit, table["/robots/arm/tcp"].frame) == ("m", "world")
    assert (table["/signals/pressure"].unit, table["/signals/pressure"].rate) == ("bar", None)
    lidar = table["/sensors/ugv.lidar/scan"]  # the paper's LDS-01: 5 Hz
    assert (lidar.type, lidar.rate, lidar.frame) == ("RangeReading", 5.0, "ugv.lidar")
    assert table["/sensors/ugv.imu/reading"].type == "ImuReading"
    assert {"/sensors/eye/color", "/sensors/eye/depth", "/sensors/eye/camera_info"} <= set(table)
    assert {"/clock", "/motions", "/collisions", "/robots/ugv/base", f"/nodes/{LINK}/pose"} <= set(table)
    assert (table["/robots/ugv/command/twist"].direction, "/robots/arm/command/twist" in table) == ("in", False)
    assert "/robots/arm/base" not in table and "/nodes/world/pose" not in table
    with pytest.raises(UnknownNameError, match=r"no stream named '/robots/amr/tcp'; did you mean '/robots/arm/tcp'"):
        table["/robots/amr/tcp"]


def test_each_tick_has_a_sample_of_joints_poses_and_the_clock(world: Client) -> None:
    arm = world.robot("arm")
    arm.move_joints({"lbr_iiwa_joint_1": 0.9}, wait=False)
    with world.streams.watch("/robots/arm/*", f"/nodes/{LINK}/pose", "/clock") as watch:
        world.clock.step(100)
        streams = [one.name for one in watch.streams]
        samples = taken(watch, len(streams) * 101)
    by_name = {name: [one for one in samples if one.stream == name] for name in streams}
    for name in streams:
        of = by_name[name]
        assert np.diff([one.tick for one in of]).tolist() == [1] * 100, name
        measured = rate(of)
        assert (measured.mean, measured.lost) == (pytest.approx(1.0 / TICK), 0)
        assert measured.longest == pytest.approx(TICK) and measured.deviation < 1e-9
    joints = by_name["/robots/arm/joint_states"][-1]
    assert joints.values["lbr_iiwa_joint_1/position"] == arm.positions[0]
    assert joints.values["lbr_iiwa_joint_1/velocity"] == arm.state.velocities[0] != 0.0
    np.testing.assert_array_equal([by_name["/robots/arm/tcp"][-1].values[axis] for axis in "xyz"], arm.tcp[:3, 3])
    pose = world.scene.poses()[LINK]
    told = by_name[f"/nodes/{LINK}/pose"][-1].values
    np.testing.assert_allclose([told[axis] for axis in "xyz"], pose[:3, 3], atol=1e-12)
    assert by_name["/clock"][-1].values["time"] == pytest.approx(joints.time) == joints.tick * TICK


def test_sensors_read_while_their_streams_are_watched(world: Client) -> None:
    names = [
        "/sensors/ugv.lidar/scan",
        "/sensors/ugv.imu/reading",
        "/sensors/ugv.encoders/reading",
        "/sensors/near/reading",
    ]
    assert world.sensors["ugv.lidar"].status.state == "stopped"
    with world.streams.watch(*names, "/sensors/eye/*") as watch:
        world.clock.step(250)
        samples = taken(watch, 5 + 100 + 50 + 20 + 3 * 10)  # the rates of all, in a second
        assert world.sensors["ugv.lidar"].status.state == "running"
    seen = {one.stream: one.values for one in samples}
    scan = [one for one in samples if one.stream == names[0]]
    assert len(scan) == 5 and scan[0].values["distances"].size == 360  # the lidar's data sheet: 5 Hz, 360 beams
    assert 0.5 < scan[0].values["nearest"] < 1.0
    assert rate(scan).mean == pytest.approx(5.0) and bandwidth(scan).mean > 360 * 4 * 4.0
    assert seen["/sensors/eye/color"]["color"].shape == (48, 64, 3)
    assert seen["/sensors/eye/depth"]["depth"].shape == (48, 64)
    assert seen["/sensors/eye/camera_info"]["width"] == 64


def test_inertial_units_encoders_and_contacts_tell_their_numbers(world: Client) -> None:
    world.clock.step(10)
    with world.streams.watch(
        "/sensors/ugv.imu/reading", "/sensors/ugv.encoders/reading", "/sensors/near/reading"
    ) as watch:
        world.clock.step(50)
        seen: dict[str, Sample] = {}
        while len(seen) < 3:
            seen |= {one.stream: one for one in taken(watch, 1)}
    # At rest an accelerometer feels gravity: 9.81 m/s^2 upwards, within the noise of the device.
    assert seen["/sensors/ugv.imu/reading"].values["linear_acceleration/z"] == pytest.approx(9.81, abs=0.5)
    assert {name.rpartition("/")[2] for name in seen["/sensors/ugv.encoders/reading"].values} == {
        "position",
        "velocity",
    }
    assert seen["/sensors/near/reading"].values["count"] == 0


def test_signals_and_motions_tell_their_changes(world: Client) -> None:
    with world.streams.watch("/signals/*", "/motions") as watch:
        assert taken(watch, 1)[0].values == {"value": 1.5}
        world.signals["pressure"] = 2.5
        world.robot("arm").move_joints({"lbr_iiwa_joint_1": 0.1}, wait=False)
        told = taken(watch, 2)
    found = {one.stream: one.values for one in told}
    assert found["/signals/pressure"] == {"value": 2.5}
    assert found["/motions"]["phase"] == "RUNNING"


def test_a_base_tells_its_pose_and_its_twist_in_its_own_axes(world: Client) -> None:
    """A circle of v / omega: after a quarter turn the heading is pi / 2 and the place (r, r)."""
    speed, omega = 0.3, 0.6
    with world.streams.watch("/robots/ugv/base") as watch:
        # Five seconds at full twist and the ways in and out of it; the twist is told in the base's axes all the time.
        for _ in range(50):
            world.clock.step(10, twists={"ugv": (speed, 0.0, omega)})
        last = taken(watch, 501)[-1].values
    assert (last["vx"], last["vy"], last["omega"]) == pytest.approx((speed, 0.0, omega), abs=1e-9)
    assert math.hypot(last["x"], last["y"]) > 0.3


def test_what_the_world_hears_is_published(world: Client) -> None:
    world.signals.create("valve", False)
    with world.streams.publisher("/signals/valve") as valve:
        valve.send(True)
    assert world.signals["valve"] is True
    with world.streams.publisher("/robots/ugv/command/twist", timeout=100.0) as twist:
        twist.send([0.2, 0.0, 0.0])
        world.clock.set_realtime()
    assert world.robot("ugv").tcp[0, 3] >= 0.0
    with pytest.raises(InvalidArgumentError, match="told by the world"):
        world.streams.publisher("/robots/ugv/base")
    with pytest.raises(InvalidArgumentError, match="only heard"):
        world.streams.watch("/robots/ugv/base", "/robots/ugv/command/*")
    with pytest.raises(UnknownNameError, match="did you mean '/robots/ugv/base'"):
        world.streams.watch("/robots/ugv/bass")


def test_commands_list_and_show(run: Run, world: Client) -> None:
    lines = run("topic", "list", "/robots/arm/*").splitlines()
    assert lines[0].split() == ["stream", "type", "rate", "unit", "frame", "direction"]
    assert any(line.split()[:4] == ["/robots/arm/joint_states", "RobotState", "250", "Hz"] for line in lines)
    told = run("topic", "info", "/robots/arm/tcp")
    assert "unit       m" in told and "    qw = " in told
    assert "/signals/pressure  value=1.5" in run("topic", "echo", "/signals/pressure", "--count", "1")
    assert '"values": {"value": 1.5}' in run("topic", "echo", "/signals/pressure", "--count", "1", "--lines")
    assert "no stream named '/robots/arm/joint_state'" in run("topic", "info", "/robots/arm/joint_state", code=1)


@pytest.mark.long
def test_commands_measure(run: Run, client: Client) -> None:
    client.load_robot(IIWA, name="arm")
    told = run("topic", "hz", "/robots/arm/joint_states", "--seconds", "0.5")
    # Each of 250 ticks a second of simulation time, however busy the machine is.
    assert told.startswith("/robots/arm/joint_states: 250.000 Hz, period 4.000 to 4.000 ms") and "0 lost" in told
    client.signals.create("pressure", 1.5)
    # It ends with the time, though the signal tells nothing after its first value.
    assert run("topic", "echo", "/signals/pressure", "--seconds", "0.1").count("\n") == 1
    assert "too few for a rate" in run("topic", "hz", "/signals/pressure", "--seconds", "0.1")
    assert "bytes each" in run("topic", "bw", "/robots/arm/joint_states", "--seconds", "0.2")
    assert "in the mean" in run("topic", "delay", "/robots/arm/joint_states", "--seconds", "0.2")


@pytest.mark.long
def test_commands_plot_live_and_from_files(run: Run, client: Client, tmp_path: Path) -> None:
    client.load_robot("model://ugv", base="planar")
    svg, png, way = tmp_path / "speed.svg", tmp_path / "speed.png", tmp_path / "way.svg"
    base = "/robots/ugv/base"
    run("topic", "plot", f"{base}:vx", f"{base}:x - {base}:y", "--seconds", "0.3", "--out", str(svg))
    drawn = ElementTree.parse(svg).getroot()
    lines = [one for one in drawn.iter() if one.tag.endswith("polyline")]
    assert len(lines) == 2
    run("topic", "plot", base, "--seconds", "0.2", "--out", str(png))
    assert png.read_bytes().startswith(b"\x89PNG")
    run("topic", "plot", "/nodes/ugv.base/pose", "--trail", "--seconds", "0.2", "--out", str(way))
    assert "polyline" in way.read_text()
    told = run("topic", "plot", f"{base}:x", "--seconds", "0.2")
    assert f"o {base}:x" in told and "0.2 s" in told
    table = tmp_path / "run.csv"
    with client.start_recording(table):
        client.robot("ugv").drive(0.2, seconds=0.3)
    told = run("topic", "plot", "ugv/*/position", "--file", str(table), "--out", str(tmp_path / "file.svg"))
    assert "file.svg" in told
    assert "no number is called 'arm/x'" in run("topic", "plot", "arm/x", "--file", str(table), code=1)
    assert "ends with .svg or .png, not '.jpg'" in run("topic", "plot", "x", "--out", "x.jpg", code=1)
    assert "there is no folder" in run("topic", "plot", "x", "--out", str(tmp_path / "no" / "x.svg"), code=1)
    run("topic", "plot", base, "--trail", code=2)


@pytest.mark.long
@pytest.mark.parametrize("ending", [".csv", ".mcap"])
def test_a_recording_is_played_again(run: Run, world: Client, tmp_path: Path, ending: str) -> None:
    file = tmp_path / f"run{ending}"
    arm = world.robot("arm")
    with world.start_recording(file) as recording:
        arm.move_joints({"lbr_iiwa_joint_2": 0.3}, wait=False)
        recording.step(200)
        world.signals["pressure"] = 3.5
        recording.step(2)
    end, time = arm.positions.copy(), world.clock.simulation_time
    arm.set_positions([0.0] * 7)
    world.signals["pressure"] = 0.0
    told = run("topic", "play", str(file), "--only", "arm/*", "--only", "signals/*")
    np.testing.assert_allclose(arm.positions, end, atol=1e-12)
    assert world.signals["pressure"] == 3.5
    assert "of arm, pressure" in told or "of pressure, arm" in told
    # As long as it was recorded: 0.8 s, to what is played of it together.
    assert world.clock.simulation_time - time == pytest.approx(0.8, abs=0.05)
    assert "no recording" in run("topic", "play", str(tmp_path / "run.txt"), code=1)
    assert "no file" in run("topic", "play", str(tmp_path / "gone.csv"), code=1)


@pytest.mark.long
def test_commands_publish(run: Run, client: Client) -> None:
    client.load_robot("model://ugv", base="planar")
    client.signals.create("count", 0)
    run("topic", "pub", "/signals/count", "7")
    assert client.signals["count"] == 7
    client.signals.create("program", "idle")
    run("topic", "pub", "/signals/program", "on")
    assert client.signals["program"] == "on"
    run("topic", "pub", "/signals/count", "many", code=2)
    run("topic", "pub", "/robots/ugv/command/twist", "0.3", "0", "0", "--seconds", "0.5")
    assert 0.01 < client.robot("ugv").tcp[0, 3] < 0.3
    run("topic", "pub", "/robots/ugv/base", "1", "--seconds", "1", code=2)
    run("topic", "pub", "/robots/ugv/command/twist", "fast", "--seconds", "1", code=2)
    assert "vx, vy, omega" in run("topic", "pub", "/robots/ugv/command/twist", "0.3", "--seconds", "1", code=1)


def test_frames_are_told_with_their_parents(world: Client) -> None:
    with world.streams.watch("/transforms*") as watch:
        still, moving = sorted(taken(watch, 2), key=lambda one: one.stream, reverse=True)
        world.robot("arm").set_positions([0.3] * 7)
        now = taken(watch, 1)[0]
    assert still.stream == "/transforms/fixed" and now.stream == moving.stream == "/transforms"
    assert "ugv.lidar" in still.values["children"] and LINK in moving.values["children"]
    world_t_node = {"world": np.eye(4)}
    rows = {}
    for sample in (still, now):
        for child, parent, row in zip(*(sample.values[one] for one in ("children", "parents", "poses")), strict=True):
            rows[child] = parent, row

    def placed(node: str) -> np.ndarray:
        if node not in world_t_node:
            parent, row = rows[node]
            world_t_node[node] = placed(parent) @ poses_from_rows(row)[0]
        return world_t_node[node]

    assert np.allclose(placed(LINK), world.scene[LINK].pose, rtol=0.0, atol=1e-12)


def test_a_function_gets_samples_of_what_is_wanted_as_they_are_read(world: Client) -> None:
    """Whoever takes them is called by the thread that reads; what ends the watch comes by the usual way."""
    names, came = ("/clock", "/robots/ugv/joint_states"), []
    wanted = {"/clock"}
    streams = told_streams(world.services, names)
    with StreamWatch(world.services, streams, take=came.append, wanted=lambda name: name in wanted) as watch:
        world.clock.step(5)
        until(lambda: len(came) >= 5)
        assert {sample.stream for sample in came} == {"/clock"}
        wanted.add("/robots/ugv/joint_states")
        world.clock.step(5)
        until(lambda: came[-1].tick == world.clock.read().stamp.tick and len(came) >= 15)
        assert {sample.stream for sample in came} == set(names)
        assert watch.next(0.0) is None

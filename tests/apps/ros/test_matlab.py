"""The functions for MATLAB and Octave, run by Octave at a bridge; the programs of docs/tutorial-matlab.md, too."""

from __future__ import annotations

import json
import math
import re
import sys
from collections.abc import Iterator
from contextlib import closing
from pathlib import Path

import numpy as np
import pytest
import roslibpy
import virtualrobot
from virtualrobot import Client
from virtualrobot_apps.bridges.ros.recorder import Recorder
from virtualrobot_apps.bridges.ros.rosbridge.server import RosbridgeServer
from virtualrobot_apps.lockstep.exchange import Lockstep
from virtualrobot_apps.lockstep.wire import ProgramWire, SocketWire, Wire, listen

from tests.api.client.conftest import IIWA
from tests.api.test_docs_snippets import compare
from tests.apps.ros.bridges import GUARD, bridge, roslibpy_client
from tests.apps.ros.octave import needs_octave, octave, octave_process
from tests.waiting import repeated, until

pytestmark = [pytest.mark.long, needs_octave]

PAGE = Path(__file__).parents[3] / "docs" / "tutorial-matlab.md"
BASE = "/robots/ugv/base"
PYTHON = Path(__file__).parents[3] / "docs" / "lockstep.md"


def section(title: str, kind: str) -> str:
    """Return the block of one kind of a section of the page."""
    (_, found) = PAGE.read_text("utf-8").split(f"## {title}\n")
    return re.findall(rf"```{kind}\n(.*?)```", found, re.DOTALL)[0]


@pytest.fixture
def cell(client: Client) -> Client:
    """Return a client of the world of the page."""
    client.load_robot("model://ugv", base="planar")
    client.load_robot("model://kr6_r700", name="arm", pose=virtualrobot.pose(y=2.0))
    client.scene.add_object("wall", virtualrobot.box(0.1, 2.0, 0.5), pose=virtualrobot.pose(x=1.5, z=0.25))
    return client


@pytest.fixture
def sights(client: Client) -> Iterator[Client]:
    """Return a client of a stepped world with an arm, a scanner and a cloud before a wall, and a camera."""
    client.clock.set_stepped()
    client.load_robot(IIWA, name="arm", pose=virtualrobot.pose(y=3.0))
    flat = virtualrobot.fan(5, -0.4, 0.4)
    client.scene.add_range_sensor("scanner", virtualrobot.range_sensor(pattern=flat, rate=10.0))
    raster = virtualrobot.raster(4, 3, 0.4, 0.2)
    client.scene.add_range_sensor("cloud", virtualrobot.range_sensor(pattern=raster, rate=10.0))
    ahead = virtualrobot.pose(pitch=math.pi / 2)  # cameras look along z
    client.scene.add_camera("eye", virtualrobot.camera(8, 6, images=["color", "depth"], rate=10.0), pose=ahead)
    client.scene.add_object("wall", virtualrobot.box(0.2, 6.0, 4.0), pose=virtualrobot.pose(x=2.1))
    yield client
    client.clock.set_realtime()


def test_the_programs_of_the_page_print_what_it_says(cell: Client, tmp_path: Path) -> None:
    titles = ("From nothing to a vehicle that drives", "An arm's trajectory", "Services and parameters")
    with bridge(cell) as (url, _):
        program = "".join(section(title, "matlab") for title in titles)
        program = program.replace("addpath('clients/matlab')\nrosinit\n", f"rosinit('{url}')\n")
        assert url in program
        said = octave(tmp_path, program)
    page = "".join(section(title, "text") for title in titles)
    # How far beyond 0.3 m depends on how soon Octave looks, on a busy machine.
    compare(PAGE, 1, page.replace("driven: 0.3 m", "driven: ... m"), said)
    ugv = cell.robot("ugv")
    until(lambda: not ugv.state.velocities.any())
    assert ugv.tcp[0, 3] > 0.3


def test_joints_are_those_of_the_kernels_own_client_bit_by_bit(
    sights: Client, tmp_path: Path, rng: np.random.Generator
) -> None:
    positions = rng.uniform(-1.0, 1.0, 7)
    sights.robot("arm").set_positions(positions)
    sights.clock.step(1)
    program = "joints = receive(rossubscriber('/arm/joint_states'), 60); fprintf('%.17g\\n', joints.Position);"
    with bridge(sights) as (url, _), repeated(lambda: sights.clock.step(1), 0.02):
        said = octave(tmp_path, f"rosinit('{url}')\n{program}")
    assert [float(line) for line in said.splitlines()[1:]] == positions.tolist()


def test_scans_clouds_and_pictures_show_the_wall(sights: Client, tmp_path: Path) -> None:
    program = """
scans = rossubscriber('/scanner/scan'); clouds = rossubscriber('/cloud/points');
colors = rossubscriber('/eye/image_raw'); depths = rossubscriber('/eye/depth/image_raw');
scan = receive(scans, 60);
told.angles = readScanAngles(scan);
told.ends = readCartesian(scan);
told.near = readCartesian(scan, 'RangeLimits', [0 2.05]);
told.points = readXYZ(receive(clouds, 60));
told.color = size(readImage(receive(colors, 60)));
told.depth = readImage(receive(depths, 60));
fprintf('%s\\n', jsonencode(told));
"""
    with bridge(sights) as (url, _), repeated(lambda: sights.clock.step(5), 0.02):
        said = octave(tmp_path, f"rosinit('{url}', 'FieldNames', 'ros')\n{program}")
    told = json.loads(said.splitlines()[-1])
    # Planes at right angles to x: the wall's surface is 2 m away.
    assert told["angles"] == pytest.approx([-0.4, -0.2, 0.0, 0.2, 0.4])
    ends = [[2.0, 2.0 * np.tan(angle)] for angle in told["angles"]]
    np.testing.assert_allclose(told["ends"], ends, atol=1e-5)
    np.testing.assert_allclose(told["near"], ends[1:4], atol=1e-5)
    np.testing.assert_allclose(np.array(told["points"])[:, 0], np.full(12, 2.0), atol=1e-5)
    assert told["color"] == [6, 8, 3]
    np.testing.assert_allclose(told["depth"], np.full((6, 8), 2.0), atol=1e-5)


def test_a_service_of_ones_own_answers_and_refuses(client: Client, tmp_path: Path) -> None:
    program = """
function response = answer(server, request, response)
  if ~request.Data
    error('the lamp has no switch');
  end
  response.Success = true;
  response.Message = 'it is lit: Ω';
end
server = rossvcserver('/lamp', 'std_srvs/SetBool', @answer);
fprintf('serving\\n'); fflush(stdout);
rosspin(600);
"""
    with bridge(client) as (url, _), octave_process(tmp_path, f"rosinit('{url}')\n{program}") as process:
        assert process.stdout is not None
        assert "serving\n" in iter(process.stdout.readline, "")
        with roslibpy_client(url) as ros:
            lamp = roslibpy.Service(ros, "/lamp", "std_srvs/SetBool")
            lit = lamp.call(roslibpy.ServiceRequest({"data": True}), timeout=GUARD)
            assert dict(lit or {}) == {"success": True, "message": "it is lit: Ω"}
            with pytest.raises(roslibpy.core.ServiceException, match="the lamp has no switch"):
                lamp.call(roslibpy.ServiceRequest({"data": False}), timeout=GUARD)


def test_a_goal_is_followed_and_cancelled_and_functions_hear(cell: Client, tmp_path: Path) -> None:
    program = """
function count(varargin)
  global heard
  heard = heard + 1;
end
global heard
heard = 0;
[arm, goal] = rosactionclient('/arm/follow_joint_trajectory');
waitForServer(arm, 60);
point = rosmessage('trajectory_msgs/JointTrajectoryPoint');
point.Positions = [0.5; -1.5];
point.TimeFromStart.Sec = 500;
goal.Trajectory.JointNames = {'joint_a1', 'joint_a2'};
goal.Trajectory.Points = point;
arm.FeedbackFcn = @count;
sendGoal(arm, goal);
while heard == 0
  rosspin(0.05);
end
cancelGoal(arm);
[result, state] = waitForResult(arm, 60);
disp(state);
goal.Trajectory.JointNames = {'elbow', 'joint_a2'};
[result, state, text] = sendGoalAndWait(arm, goal, 60);
fprintf('%s %d\\n', state, result.ErrorCode);
heard = 0;
clock = rossubscriber('/clock', @count);
while heard < 3
  rosspin(0.05);
end
unsubscribe(clock);
latest = clock.LatestMessage;
disp(class(latest.Clock.Sec));
"""
    with bridge(cell) as (url, _):
        said = octave(tmp_path, f"rosinit('{url}')\n{program}").splitlines()[1:]
    # control_msgs/FollowJointTrajectory: INVALID_JOINTS is -2.
    assert said == ["canceled", "aborted -2", "double"]


BAD = {
    "rossubscriber('/nope')": "service: /rosapi/topic_type: there is no '/nope'",
    "rosmessage('geometry_msgs/Twisst')": "service: .*'geometry_msgs/Twisst' is not known; did you mean",
    "m.Linear.Q = 1; send(p, m)": "message: geometry_msgs/msg/Twist.Linear has no field 'Q'; it has X, Y, Z",
    "m.Linear.X = 'a'; send(p, m)": "message: geometry_msgs/msg/Twist.Linear.X: float64 belongs here, not char",
    "m.Linear.X = [1 2]; send(p, m)": "message: geometry_msgs/msg/Twist.Linear.X: float64 belongs here",
    "m.Linear = 3; send(p, m)": "message: geometry_msgs/msg/Twist.Linear: a struct belongs here",
    "receive(rossubscriber('/late', 'std_msgs/String'), 0.05)": "timeout: nothing came on /late within 0.05 s",
    "call(rossvcclient('/nope'))": "service: .*there is no",
    "rosaction('type', '/nope')": "(name|service): .*there is no",
    "rostopic('info')": "usage: rostopic list, or rostopic info",
    "get(rosparam, '/nope')": "service: /rosapi/get_param: there is no parameter '/nope'",
    "rosinit": "connection: there is a connection to ws://.* already",
    "rosbag('program.m')": "bag: program.m can't be read as a bag",
    "rosbag('none.bag')": "bag: Invalid value for 'FILE': Path 'none.bag' does not exist.",
    "m.Linear.X = NaN; send(p, m); rosspin(60)": "refused: /ugv/cmd_vel does not take this: a twist has finite",
    "readCartesian(m)": "message: a message sensor_msgs/LaserScan belongs here",
}


def test_what_is_wrong_is_one_error_that_names_it(cell: Client, tmp_path: Path) -> None:
    tried = "".join(
        f"try\n m = blank; {line}; disp('nothing');\ncatch problem\n"
        " fprintf('%s: %s\\n', problem.identifier, problem.message);\nend\n"
        for line in BAD
    )
    server = RosbridgeServer(port=0, token="sesame")
    with bridge(cell, server=server) as (url, _):
        port = url.rpartition(":")[2]
        said = octave(
            tmp_path,
            f"""
try
  rosinit({port}, 'Token', 'open')
catch problem
  disp(problem.message);
end
rosinit({port})
try
  rosnode list
catch problem
  disp(problem.message);
end
rosshutdown
rosinit({port}, 'Token', 'sesame')
[p, blank] = rospublisher('/ugv/cmd_vel');
{tried}
rosshutdown
try
  rostopic list
catch problem
  disp(problem.message);
end
try
  rosinit(99999)
catch problem
  disp(problem.message);
end
""",
        ).splitlines()
    assert "refuses" in said[0] and "401" in said[0]
    assert said[2].startswith("say the token first")
    for (line, wanted), told in zip(BAD.items(), said[5:-3], strict=True):
        assert re.match(f"virtualrobot:{wanted}", told), f"{line}: {told}"
    assert said[-2:] == ["there is no connection; call rosinit first", "a port is a whole number from 1 to 65535"]
    nobody = octave(tmp_path, f"try\n rosinit({port})\ncatch problem\n disp(problem.message);\nend")
    assert nobody == f"nobody serves at 127.0.0.1:{port}\n"


def test_the_controller_of_the_page_drives_as_that_in_python(steps: Client, tmp_path: Path) -> None:
    """The same law in two languages: the same way, to what their arithmetic differs by."""
    (python,) = re.findall(r"```python\n(import json.*?)```", PYTHON.read_text("utf-8"), re.DOTALL)
    (tmp_path / "controller.py").write_text(python, "utf-8")
    ways: list[list[np.ndarray]] = []

    def drive(wire: Wire) -> None:
        steps.scene.clear()
        ugv = steps.load_robot("model://ugv", name="ugv", base="planar")
        ways.append([])
        run = Lockstep(steps, "ugv", 0.05).run(wire, GUARD, None, lambda _: ways[-1].append(ugv.tcp[:2, 3]))
        wire.close()
        assert run.end == "the controller is done"

    drive(ProgramWire([sys.executable, str(tmp_path / "controller.py")]))
    with closing(listen(0)) as server:
        program = section("A controller in lockstep", "matlab").replace("5600", str(server.getsockname()[1]))
        with octave_process(tmp_path, program) as process:
            drive(SocketWire(server, GUARD))
            said, _ = process.communicate(timeout=GUARD)
            assert process.returncode == 0 and "warning:" not in said, said
    assert len(ways[0]) == len(ways[1]) > 300
    np.testing.assert_allclose(ways[0], ways[1], atol=1e-9)


def test_the_bag_of_the_page_is_what_was_recorded(steps: Client, tmp_path: Path) -> None:
    ugv = steps.load_robot("model://ugv", base="planar")
    with bridge(steps, more=[Recorder(tmp_path / "run.mcap")]) as (_, said), steps.streams.watch(BASE) as watch:
        until(lambda: f"recording to {tmp_path / 'run.mcap'}" in said)
        steps.clock.step(250, twists={"ugv": (0.3, 0.0, 0.0)})
        last = round(steps.clock.simulation_time * 1e9)
        while (sample := watch.next(GUARD)) is not None and sample.nanoseconds < last:
            pass
    told = octave(tmp_path, section("Bags", "matlab")).splitlines()
    assert re.fullmatch(r"\d+ messages in \d\.\d s", told[0])
    place = re.fullmatch(r"\d+ of odometry in the first second, x = (\S+) m in the last", told[1])
    assert place is not None and 0.0 < float(place[1]) <= ugv.tcp[0, 3] + 5e-4

"""The worst that components do to a real kernel: odd errors and answers, clients that leave, hangs while it ends."""

from __future__ import annotations

import threading
from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np
import psutil
import pytest
import virtualrobot
from virtualrobot import Client, InvalidArgumentError, PluginFailedError, Robot, VirtualRobotError, pose
from virtualrobot.v1 import robot_pb2, scene_pb2

from tests.api.asking import IIWA
from tests.kernels import EMPTY_SCENE, KernelProcess, StartKernel
from tests.plugins.install import environment, install
from tests.tiers import every_fifth
from tests.waiting import until

pytestmark = pytest.mark.long

REACHED = pose(0.5, 0.1, 0.5, roll=np.pi)
COMPONENTS = ("odd_inside", "odd")

FAULTS = {
    "exit": "SystemExit: licence missing",
    "files": r"asks for files \(a\.stl\); only an importer",
    "plugin": "write it otherwise",
    "surrogate": r"ValueError: odd \\udcff text",
}
"""What is raised, and what is said of it."""

ANSWERS = {
    "configurations": "a int as a configuration",
    "position_error": "a str as position_error",
    "reason": "a int as the reason",
    "status": "a str as status",
}
"""Fields of an answer that are wrong, and what is said of them."""


@pytest.fixture(scope="module")
def site(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return install(tmp_path_factory.mktemp("site"), "odd")


@pytest.fixture(scope="module")
def odd_kernel(start_kernel: StartKernel, site: Path) -> KernelProcess:
    return start_kernel(environment=environment(site))


@pytest.fixture
def client(odd_kernel: KernelProcess) -> Iterator[Client]:
    with virtualrobot.connect(odd_kernel.address) as client:
        client.services.scene.LoadScene(scene_pb2.LoadSceneRequest(text=EMPTY_SCENE))
        yield client


@pytest.fixture
def arm(client: Client) -> Robot:
    return client.load_robot(IIWA, name="arm")


def processes(kernel: KernelProcess) -> list[psutil.Process]:
    """Return the processes that the kernel has started."""
    return psutil.Process(kernel.process.pid).children(recursive=True)


def hanging(kernel: KernelProcess) -> Callable[[], int]:
    """Return what tells how many components have begun to hang from now on."""
    before = len(kernel.lines)
    return lambda: sum(line.endswith("hangs") for line in kernel.lines[before:])


def in_background(ask: Callable[[], object], count: int = 1) -> list[threading.Thread]:
    """Ask in threads of their own; refusals and the kernel's end are expected."""

    def quietly() -> None:
        with pytest.raises(VirtualRobotError):
            ask()

    threads = [threading.Thread(target=quietly) for _ in range(count)]
    for thread in threads:
        thread.start()
    return threads


@pytest.mark.parametrize("component", COMPONENTS)
@pytest.mark.parametrize("error", FAULTS)
def test_whatever_is_raised_is_the_component_s_fault(arm: Robot, component: str, error: str) -> None:
    for stage in ("make", "inverse"):
        with pytest.raises(PluginFailedError, match=FAULTS[error]) as raised:
            arm.set_kinematics(component, {stage: error})
        assert raised.value.metadata["fault"] == "RAISED"
    assert arm.solve_inverse(REACHED).solved


@pytest.mark.parametrize("component", COMPONENTS)
def test_refusals_of_any_length_and_with_any_metadata_arrive(arm: Robot, component: str) -> None:
    with pytest.raises(InvalidArgumentError, match="too far") as raised:
        arm.set_kinematics(component, make="refusal")
    assert raised.value.metadata == {"reason": "reach", "kind": "pose"}
    with pytest.raises(InvalidArgumentError, match="\N{SNOWMAN}" * 100):
        arm.set_kinematics(component, make="long")


@pytest.mark.parametrize("component", COMPONENTS)
@pytest.mark.parametrize("field", ANSWERS)
def test_an_answer_of_wrong_types_is_the_component_s_fault(arm: Robot, component: str, field: str) -> None:
    with pytest.raises(PluginFailedError, match=ANSWERS[field]) as raised:
        arm.set_kinematics(component, inverse=field)
    assert raised.value.metadata["fault"] == "NONSENSE"


def test_a_client_that_leaves_while_a_component_is_tried_leaves_no_process(
    odd_kernel: KernelProcess, client: Client, arm: Robot
) -> None:
    stubs = odd_kernel.stubs()
    request = robot_pb2.SetKinematicsRequest(choice=robot_pb2.KinematicsChoice(robot="arm", kinematics="odd"))
    asked = [stubs.robot.SetKinematics.future(request) for _ in range(3)]
    until(lambda: len(processes(odd_kernel)) == 3)
    for call in asked:
        call.cancel()
    stubs.channel.close()
    until(lambda: len(processes(odd_kernel)) <= 1)
    arm.set_kinematics("chain")
    until(lambda: not processes(odd_kernel))


def test_calls_that_wait_for_one_robot_hold_up_no_other(
    odd_kernel: KernelProcess, client: Client, arm: Robot, tmp_path: Path
) -> None:
    other = client.load_robot(IIWA, name="other", pose=pose(2.0))
    trigger = tmp_path / "now"
    arm.set_kinematics("odd", inverse="hang", trigger=str(trigger))
    trigger.touch()
    count = hanging(odd_kernel)
    waiting = in_background(lambda: arm.solve_inverse(REACHED), 12)
    until(lambda: count() == 1)
    # Clients that go away and come again take no thread each time.
    for _ in range(70):
        with pytest.raises(VirtualRobotError):
            client.services.robot.SolveInverse(robot_pb2.SolveInverseRequest(robot="arm"), timeout=0.01)
    other.move_pose(pose(2.0) @ REACHED)
    arm.move_joints(arm.positions + 0.01)  # this needs no component
    client.load_robot(IIWA, name="third", pose=pose(4.0))
    assert len(list(client.plugins)) > 1
    assert arm.kinematics == "odd"
    for process in processes(odd_kernel):
        process.kill()
    for thread in waiting:
        thread.join()
    assert "ended with SIGKILL" in arm.kinematics_fault


@pytest.mark.parametrize("stage", every_fifth(["inverse", "make", "trigger"]))
def test_the_kernel_ends_while_components_hang(
    start_kernel: StartKernel, site: Path, tmp_path: Path, stage: str
) -> None:
    kernel = start_kernel(environment=environment(site))
    with virtualrobot.connect(kernel.address) as client:
        arm = client.load_robot(IIWA, name="arm")
        count = hanging(kernel)
        if stage == "trigger":
            arm.set_kinematics("odd", inverse="hang", trigger=str(tmp_path / "now"))
            (tmp_path / "now").touch()
            waiting = in_background(lambda: arm.solve_inverse(REACHED), 3)
            until(lambda: count() == 1)
        else:
            waiting = in_background(lambda: arm.set_kinematics("odd", {stage: "hang"}), 3)
            until(lambda: count() == 3)
        left = processes(kernel)
        assert left
        assert kernel.end(15.0) == 0  # the deadline of a call is 300 s, that of making a component 20 s
        for thread in waiting:
            thread.join()
    _, alive = psutil.wait_procs(left, timeout=10)
    assert alive == []


def test_settings_of_a_component_cross_the_wire_as_they_are(arm: Robot) -> None:
    """Deep and large ones are refused by name and not by the kernel's own limits."""
    for settings in ({"make": [[["x"]]] * 1000}, {"x" * 100_000: 1}, {"make": {"a": {"b": {}}}}):
        with pytest.raises(InvalidArgumentError, match="setting"):
            arm.set_kinematics("odd", settings)
    assert arm.kinematics == "arm_angle"

"""Wrong plugins are named and contained by real kernels, while everybody else goes on; good ones are swapped in."""

from __future__ import annotations

import os
import re
import subprocess
import sys
import threading
import time
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import psutil
import pytest
import virtualrobot
from virtualrobot import (
    Client,
    InvalidArgumentError,
    PluginFailedError,
    Robot,
    UnknownNameError,
    VirtualRobotError,
    pose,
)
from virtualrobot.plugins import ComponentUse
from virtualrobot.v1 import scene_pb2

from tests.api.asking import IIWA
from tests.kernels import EMPTY_SCENE, KernelProcess, StartKernel
from tests.plugins.install import WRONG, environment, install

pytestmark = pytest.mark.long

NOT_LOADED = {
    "raises_on_import": r"'raises_on_import' cannot be imported: RuntimeError: the licence of this plugin has expired "
    r"\(__init__\.py:3\)",
    "crashes_on_import": r"SIGSEGV",
    "misspelt_hook": r"no hook virtualrobot_register_kinematic; did you mean virtualrobot_register_kinematics\?",
    "other_api": r"written for API 2\.0; this kernel has 1\.0",
    "no_api": r"has no api_version",
    "name_taken": r"component 'chain' .* plugin 'kinematics'",
}
"""Plugins that offer nothing, and what is said about them."""

REFUSED = {
    "raises_at_work": r"inverse: KeyError: 'elbow up' \(__init__\.py:\d+ in inverse\)|KeyError: 'elbow up'",
    "hangs": r"inverse gave no answer within 2 s",
    "crashes": r"SIGSEGV",
    "returns_nan": r"inverse returned nan at \[0, 6\]; all values must be finite",
    "wrong_shape": r"inverse returned solutions of shape \(7,\); they must be \(m, 7\)",
    "wrong_frame": r"forward puts the tip 0\.1 m and \S+ rad from where the robot's tree has it",
}
"""Components that are wrong at once, and what is said when a robot is to have them."""

AT_WORK = REFUSED | {"wrong_frame": r"misses its target by 0\.1 m", "leaks": r"grew by \d+ MiB"}
"""Components that go wrong at work, and what is said when they are asked."""

REACHED = pose(0.5, 0.1, 0.5, roll=np.pi)


@pytest.fixture(scope="module")
def site(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return the folder that plugins are installed in."""
    return install(tmp_path_factory.mktemp("site"), "good", "in_process", *WRONG, *NOT_LOADED)


@pytest.fixture(scope="module", autouse=True)
def strict_kernel(tmp_path_factory: pytest.TempPathFactory) -> Iterator[subprocess.Popen[str]]:
    """Return a kernel that must not start; it waits long for a plugin that hangs, so it begins before all tests."""
    site = install(tmp_path_factory.mktemp("strict"), "good", "raises_on_import", "hangs_on_import")
    command = [sys.executable, "-m", "virtualrobot_kernel.serve", "--port", "0", "--headless", "--no-token"]
    process = subprocess.Popen(
        [*command, "--strict-plugins"],
        env={**os.environ, **environment(site)},
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )
    with process:
        yield process
        process.kill()


@pytest.fixture(scope="module")
def plugin_kernel(start_kernel: StartKernel, site: Path) -> Iterator[KernelProcess]:
    """Return a kernel with all these plugins; at its end no process of it may be left."""
    process = start_kernel(environment=environment(site))
    yield process
    children = psutil.Process(process.process.pid).children(recursive=True)
    assert process.end() == 0
    _, alive = psutil.wait_procs(children, timeout=10)
    assert alive == []


@pytest.fixture
def client(plugin_kernel: KernelProcess) -> Iterator[Client]:
    """Return a client of that kernel with an empty world."""
    with virtualrobot.connect(plugin_kernel.address) as client:
        client.services.scene.LoadScene(scene_pb2.LoadSceneRequest(text=EMPTY_SCENE))
        yield client


@pytest.fixture
def arm(client: Client) -> Robot:
    """Return an arm with seven joints."""
    return client.load_robot(IIWA, name="arm")


@pytest.fixture
def other(client: Client) -> Robot:
    """Return another one, which has nothing to do with it."""
    return client.load_robot(IIWA, name="other", pose=pose(2.0))


def processes(kernel: KernelProcess) -> list[psutil.Process]:
    """Return the processes that the kernel has started."""
    return psutil.Process(kernel.process.pid).children(recursive=True)


def ended(kernel: KernelProcess, count: int = 0) -> bool:
    """Return whether the kernel comes to have `count` processes at most: those of nobody end behind the calls."""
    for _ in range(600):
        if len(processes(kernel)) <= count:
            return True
        time.sleep(0.05)
    return False


def use_of(client: Client, component: str) -> ComponentUse:
    """Return how the only user of a component does."""
    (found,) = [one for one in client.plugins.components("kinematics") if one.name == component]
    (use,) = found.uses
    return use


def test_each_plugin_is_listed_with_its_reason(client: Client) -> None:
    plugins = {plugin.name: plugin for plugin in client.plugins}
    for name, reason in NOT_LOADED.items():
        assert plugins[name].state == "failed"
        assert re.search(reason, plugins[name].reason), plugins[name].reason
        assert plugins[name].components == ()
    loaded = {"good", *WRONG} - {*NOT_LOADED}
    assert {name: plugins[name].reason for name in loaded} == dict.fromkeys(loaded, "")
    assert all(plugins[name].version == "1.0" and plugins[name].package == name for name in loaded)


@pytest.mark.parametrize("name", REFUSED)
def test_a_component_that_is_wrong_at_once_is_refused(
    plugin_kernel: KernelProcess, client: Client, arm: Robot, name: str
) -> None:
    before = arm.solve_inverse(REACHED).solutions
    with pytest.raises(PluginFailedError, match=REFUSED[name]) as refused:
        arm.set_kinematics(name)
    assert refused.value.metadata["component"] == name
    assert refused.value.code == "FAILED_PRECONDITION"
    assert arm.kinematics == "arm_angle"
    assert arm.kinematics_fault == ""
    np.testing.assert_array_equal(arm.solve_inverse(REACHED).solutions, before)
    assert ended(plugin_kernel)


def test_what_a_component_refuses_is_no_fault(plugin_kernel: KernelProcess, arm: Robot) -> None:
    with pytest.raises(InvalidArgumentError, match="made for 3 joints; this robot has 7"):
        arm.set_kinematics("good", joints=3)
    with pytest.raises(InvalidArgumentError, match="'restrats'; did you mean 'restarts'"):
        arm.set_kinematics("good", restrats=3)
    with pytest.raises(InvalidArgumentError, match="setting 'restarts' is -1"):
        arm.set_kinematics("good", restarts=-1)
    assert arm.kinematics == "arm_angle"
    assert ended(plugin_kernel)


@pytest.mark.parametrize("name", AT_WORK)
def test_a_fault_at_work_is_named_and_contained(
    plugin_kernel: KernelProcess, client: Client, arm: Robot, other: Robot, name: str, tmp_path: Path
) -> None:
    trigger = tmp_path / "now"
    arm.set_kinematics(name, trigger=str(trigger))
    solved = arm.solve_inverse(REACHED)
    assert solved.solved
    arm.speed_factor = other.speed_factor = 0.02  # so that motions last
    own = arm.move_joints([0.5] * 7, wait=False)
    others = other.move_joints([0.5] * 7, wait=False)

    trigger.touch()
    with pytest.raises(PluginFailedError, match=AT_WORK[name]) as failed:
        for _ in range(20):  # one that leaks goes wrong after some calls
            arm.solve_inverse(REACHED)
    assert failed.value.metadata["component"] == name
    assert failed.value.metadata["fault"] in ("RAISED", "HUNG", "DIED", "NONSENSE", "GREW")
    assert re.search(AT_WORK[name], arm.kinematics_fault), arm.kinematics_fault
    assert re.search(AT_WORK[name], use_of(client, name).fault)
    goes_on = failed.value.metadata["fault"] in ("RAISED", "NONSENSE")
    assert ended(plugin_kernel, int(goes_on))

    # Nobody else notices, not even the robot's own motion.
    assert other.solve_inverse(pose(2.0) @ REACHED).solved
    assert own.phase.name == others.phase.name == "RUNNING"
    arm.speed_factor = other.speed_factor = 1.0
    own.wait()
    others.wait()
    np.testing.assert_allclose(arm.positions, 0.5, atol=1e-9)
    with pytest.raises(PluginFailedError, match=AT_WORK[name]):
        for _ in range(20):
            arm.solve_inverse(REACHED)

    trigger.unlink()
    if goes_on:
        assert arm.solve_inverse(REACHED).solved  # without being chosen again
    arm.set_kinematics("chain")
    assert arm.kinematics_fault == ""
    again = arm.solve_inverse(REACHED, seed=[0.0] * 7)
    np.testing.assert_allclose(again.solutions, solved.solutions, atol=1e-9)


def test_a_fault_costs_one_robot_and_not_all_that_have_the_component(
    plugin_kernel: KernelProcess, arm: Robot, other: Robot, tmp_path: Path
) -> None:
    trigger = tmp_path / "now"
    arm.set_kinematics("crashes", trigger=str(trigger))
    other.set_kinematics("crashes", trigger=str(tmp_path / "never"))
    assert ended(plugin_kernel, 2)
    assert len(processes(plugin_kernel)) == 2
    trigger.touch()
    with pytest.raises(PluginFailedError, match="SIGSEGV"):
        arm.solve_inverse(REACHED)
    assert other.solve_inverse(pose(2.0) @ REACHED).solved
    assert other.kinematics_fault == ""
    assert ended(plugin_kernel, 1)


def test_a_fault_in_the_kernels_own_process_is_contained(
    plugin_kernel: KernelProcess, client: Client, arm: Robot, tmp_path: Path
) -> None:
    trigger = tmp_path / "now"
    arm.set_kinematics("in_process", trigger=str(trigger))
    assert arm.solve_inverse(REACHED).solved
    assert use_of(client, "in_process").process_id == 0
    assert ended(plugin_kernel)
    trigger.touch()
    for _ in range(2):
        with pytest.raises(PluginFailedError, match=r"ZeroDivisionError: .*\(__init__\.py:\d+ in inverse\)"):
            arm.solve_inverse(REACHED)
    assert "ZeroDivisionError" in arm.kinematics_fault
    trigger.unlink()
    arm.set_kinematics("in_process", trigger=str(trigger))
    assert arm.solve_inverse(REACHED).solved


def test_a_component_of_a_plugin_that_failed_is_told_with_the_reason(client: Client, arm: Robot) -> None:
    with pytest.raises(UnknownNameError, match=r"'raises_on_import' .*the licence of this plugin has expired"):
        arm.set_kinematics("raises_on_import")
    assert arm.kinematics == "arm_angle"


def test_a_kernel_ends_though_a_component_in_its_own_process_never_returns(
    start_kernel: StartKernel, tmp_path: Path
) -> None:
    kernel = start_kernel(environment=environment(install(tmp_path / "site", "hangs")))
    with virtualrobot.connect(kernel.address) as client:
        arm = client.load_robot(IIWA, name="arm")
        arm.set_kinematics("hangs_inside", trigger=str(tmp_path / "now"))
        (tmp_path / "now").touch()
        asking = threading.Thread(target=pytest.raises, args=(VirtualRobotError, arm.solve_inverse, REACHED))
        asking.start()
        while "hangs" not in kernel.lines:
            assert asking.is_alive()
            time.sleep(0.01)
        assert kernel.end() == 0
        asking.join()
    assert re.search(r"ended by force after \d s, while these threads ran: .*solver_\d", kernel.lines[-1])


def test_others_are_answered_while_a_component_hangs(
    plugin_kernel: KernelProcess, client: Client, arm: Robot, other: Robot, tmp_path: Path
) -> None:
    trigger = tmp_path / "now"
    arm.set_kinematics("hangs", trigger=str(trigger))
    trigger.touch()
    said: list[str] = []

    def ask() -> None:
        with virtualrobot.connect(plugin_kernel.address) as another:
            try:
                another.robot("arm").solve_inverse(REACHED)
            except PluginFailedError as error:
                said.append(str(error))

    asking = threading.Thread(target=ask)
    asking.start()
    time.sleep(0.1)
    answered = 0
    while asking.is_alive():
        assert other.solve_inverse(pose(2.0) @ REACHED).solved
        other.move_joints(other.positions + 0.001)
        answered += 1
        time.sleep(0.05)
    asking.join()
    assert answered >= 2
    assert len(said) == 1
    assert re.search(REFUSED["hangs"], said[0])


def test_a_good_component_solves_as_it_would_in_process(
    plugin_kernel: KernelProcess, client: Client, arm: Robot, rng: np.random.Generator
) -> None:
    limits = list(arm.limits.values())
    seeds = rng.uniform([one.lower for one in limits], [one.upper for one in limits], (5, 7))
    targets = [arm.solve_forward(q).world_t_tcp for q in seeds[::-1]]
    arm.set_kinematics("chain")
    bundled = [arm.solve_inverse(target, seed=q).solutions for target, q in zip(targets, seeds, strict=True)]
    check = arm.set_kinematics("good", restarts=500)
    assert arm.kinematics == "good"
    assert arm.kinematics_settings == {"restarts": 500}
    assert check.postures > 0
    assert check.forward_position_error < 1e-9
    assert check.inverse_position_error < 1e-6
    found = [arm.solve_inverse(target, seed=q).solutions for target, q in zip(targets, seeds, strict=True)]
    np.testing.assert_array_equal(np.array(found), np.array(bundled))
    assert ended(plugin_kernel, 1)
    (process,) = processes(plugin_kernel)
    use = use_of(client, "good")
    assert (use.robot, use.fault, use.process_id) == ("arm", "", process.pid)
    assert use.calls >= 10
    arm.move_pose(REACHED)
    arm.move_linear(REACHED @ pose(z=0.05))
    np.testing.assert_allclose(arm.tcp, REACHED @ pose(z=0.05), atol=1e-6)
    client.scene.clear()
    assert not any(one.uses for one in client.plugins.components("kinematics"))
    assert ended(plugin_kernel)


def test_a_swap_leaves_the_running_motion_as_it_was_planned(client: Client, arm: Robot) -> None:
    arm.speed_factor = 0.02  # so that the motion lasts
    motion = arm.move_joints([0.4] * 7, wait=False)
    arm.set_kinematics("good")
    assert motion.phase.name == "RUNNING"
    arm.speed_factor = 1.0
    motion.wait()
    np.testing.assert_allclose(arm.positions, 0.4, atol=1e-9)
    arm.move_pose(REACHED)
    np.testing.assert_allclose(arm.tcp, REACHED, atol=1e-6)


def test_a_scene_keeps_component_and_settings(client: Client, arm: Robot, tmp_path: Path) -> None:
    arm.set_kinematics("good", restarts=7)
    client.scene.save(tmp_path / "cell.yaml")
    client.scene.clear()
    client.scene.load_scene(tmp_path / "cell.yaml")
    again = client.robot("arm")
    assert (again.kinematics, again.kinematics_settings) == ("good", {"restarts": 7})
    assert again.solve_inverse(REACHED).solved
    assert use_of(client, "good").process_id > 0


def test_edited_code_is_taken_up(client: Client, arm: Robot, site: Path) -> None:
    arm.set_kinematics("good")
    source = site / "good" / "__init__.py"
    code = source.read_text()
    try:
        source.write_text(code.replace("super().__init__(chain)", "raise ArgumentError('edited: no robot is right')"))
        assert arm.solve_inverse(REACHED).solved  # what works goes on
        with pytest.raises(InvalidArgumentError, match="edited: no robot is right"):
            arm.set_kinematics("good")
        assert arm.solve_inverse(REACHED).solved
    finally:
        source.write_text(code)
    arm.set_kinematics("good")


def test_strict_plugins_refuses_to_start(strict_kernel: subprocess.Popen[str]) -> None:
    printed, said = strict_kernel.communicate(timeout=100)
    assert strict_kernel.returncode == 1
    assert "listening" not in printed
    (line,) = [line for line in said.splitlines() if line.startswith("virtualrobot serve: ")]
    assert "'raises_on_import' of raises_on_import: 'raises_on_import' cannot be imported: RuntimeError" in line
    assert re.search(r"'hangs_on_import' of hangs_on_import: importing \w+ gave no answer within \d+ s", line)

"""Cycle times of studies: the ticks of a kernel that is stepped tick by tick, and reasons where there are none."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import pytest
import virtualrobot
from virtualrobot.errors import InvalidArgumentError, MalformedFileError
from virtualrobot.kernel_process import KernelProcess
from virtualrobot_apps.studies.cycle import RunningKernel, open_kernel, run_program
from virtualrobot_apps.studies.funnel import Both, sift
from virtualrobot_apps.studies.parameters import generator
from virtualrobot_apps.studies.work import Cell
from virtualrobot_apps.studies.worlds import open_world

pytestmark = pytest.mark.long

SCENE = """
schema_version: 1
nodes:
- name: post
  object: {}
  parent_t_node: {position: {x: 0.5, y: 0.1, z: 0.3}}
  figures: [{box: {size: {x: 0.1, y: 0.1, z: 0.6}}}]
- {name: goal, object: {}, parent_t_node: {position: {x: 0.4, y: -0.3, z: 0.3}, orientation: {x: 1}}}
signals: [{name: gripper, value: {boolean: false}}]
models: [{uri: "model://ur5e", name: arm}]
"""


@pytest.fixture(scope="module")
def scene(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return a UR5e beside a post."""
    file = tmp_path_factory.mktemp("scene") / "cell.yaml"
    file.write_text(SCENE)
    return file


@pytest.fixture(scope="module")
def kernel(scene: Path) -> Iterator[RunningKernel]:
    """Return a kernel with the scene."""
    made = open_kernel(scene)
    yield made
    made.client.close()
    made.process.close()


def answered(kernel: RunningKernel, **parameters: object) -> dict[str, object]:
    return dict(run_program(Cell(0, parameters, generator(1, 0), kernel, kernel.scene)))


def test_it_takes_as_many_ticks_as_in_a_kernel_of_its_own(kernel: RunningKernel, scene: Path) -> None:
    """The other kernel is stepped by single ticks until it is done; and again, whatever was run and moved meanwhile."""
    home, away = [0.0, -1.5, 1.5, -1.6, -1.5, 0.0], [0.8, -1.2, 1.2, -1.6, -1.5, 0.5]
    arm = kernel.client.robot("arm")
    program = kernel.client.program().move(arm.ptp(home)).set("gripper", True).dwell(0.2).move(arm.ptp(away))
    (scene.parent / "there.yaml").write_text(program.text)
    found = answered(kernel, program="there.yaml")
    assert (found["stage"], found["reason"]) == ("done", None)
    assert found["duration"] == pytest.approx(float(str(found["ticks"])) * kernel.tick)
    elsewhere = answered(kernel, program="there.yaml", robot="arm", x=-0.2, yaw=1.0)
    # Joint moves take as long wherever the base is.
    assert elsewhere["ticks"] == found["ticks"]
    assert answered(kernel, program="there.yaml") == found
    with KernelProcess(headless=True) as process, virtualrobot.connect(process.address) as client:
        client.clock.set_stepped()
        client.scene.load_scene(scene)
        motion, ticks = client.read_program(scene.parent / "there.yaml").start(wait=False), 0
        while not motion.state.phase.ended:
            client.clock.step()
            ticks += 1
    assert ticks == found["ticks"]


def test_where_it_fails_is_told_with_the_step(kernel: RunningKernel, scene: Path) -> None:
    kernel.restore()
    arm = kernel.client.robot("arm")
    home = [0.0, -1.5, 1.5, -1.6, -1.5, 0.0]
    programs = {
        "far.yaml": kernel.client.program().dwell(0.1).move(arm.linear(virtualrobot.pose(x=3.0))),
        "waits.yaml": kernel.client.program().wait("gripper", True),
        "home.yaml": kernel.client.program().move(arm.ptp(home)).move(arm.ptp([1.5, *home[1:]])),
    }
    for name, program in programs.items():
        (scene.parent / name).write_text(program.text)
    far = answered(kernel, program="far.yaml")
    assert far["ticks"] is None and "step 1: " in str(far["reason"])
    waits = answered(kernel, program="waits.yaml", most_seconds=1.0)
    assert (waits["stage"], waits["reason"]) == ("running", "it is not done after 1 s")
    # Stretched to -x along the table it begins beside the post, and lifts the forearm through it; far away it doesn't.
    touches = [answered(kernel, program="home.yaml", robot="arm", x=x, y=0.0) for x in (0.8, -3.0)]
    assert touches[0]["stage"] == "collision" and "post" in str(touches[0]["reason"])
    assert touches[1]["stage"] == "done"


def test_a_funnel_runs_only_what_came_through_all_before(kernel: RunningKernel, scene: Path) -> None:
    """Four places, each of which fails one stage later; a kernel is asked for by the last two alone."""
    kernel.restore()
    arm = kernel.client.robot("arm")
    home = [0.0, -1.5, 1.5, -1.6, -1.5, 0.0]
    (scene.parent / "home.yaml").write_text(kernel.client.program().move(arm.ptp(home)).text)
    (scene.parent / "waits.yaml").write_text(kernel.client.program().move(arm.ptp(home)).wait("gripper", True).text)
    asked: list[int] = []

    def opened() -> RunningKernel:
        asked.append(1)
        return kernel

    both = Both(open_world(scene), opened)

    def sifted(x: float, y: float, program: str = "home.yaml") -> tuple[object, ...]:
        parameters = {"robot": "arm", "targets": "goal", "x": x, "y": y, "program": program, "most_seconds": 20.0}
        found = dict(sift(Cell(0, parameters, generator(1, 0), both, scene)))
        assert (found["reason"] is None) == (found["stage"] == "done") == (found["ticks"] is not None)
        return (*(found[name] for name in ("kinematics", "collision", "planning", "simulation")), found["stage"])

    assert sifted(-3.0, 0.0) == (0, 0, 0, 0, "reach")
    # Its base is in the post.
    assert sifted(0.5, 0.1) == (1, 0, 0, 0, "collision") and not asked
    assert sifted(0.0, -0.4, "waits.yaml") == (1, 1, 1, 0, "running")
    assert sifted(0.0, -0.4) == (1, 1, 1, 1, "done") and len(asked) == 1
    # Stretched along the table it begins beside the post, and lifts the forearm through it.
    assert sifted(0.8, 0.0) == (1, 1, 0, 0, "collision")
    both.world.close()


def test_bad_input_is_told(kernel: RunningKernel, scene: Path) -> None:
    with pytest.raises(InvalidArgumentError, match="this study needs a scene"):
        open_kernel(None)
    (scene.parent / "none.yaml").write_text("schema_version: 1\nstep: []\n")
    with pytest.raises(MalformedFileError, match=r"none.yaml:2"):
        answered(kernel, program="none.yaml")
    (scene.parent / "dwells.yaml").write_text(kernel.client.program().dwell(0.1).text)
    with pytest.raises(ValueError, match=r"most_seconds is a tick of .* or more, not 0"):
        answered(kernel, program="dwells.yaml", most_seconds=0.0)

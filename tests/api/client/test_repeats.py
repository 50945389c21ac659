"""Calls that are made again with their request id because the answer was lost: nothing is done twice."""

from __future__ import annotations

from pathlib import Path

import pytest
import virtualrobot
from virtualrobot import Client, InvalidArgumentError, Phase, Robot

from tests.api.client.conftest import IIWA
from tests.api.client.test_motion import BENT


def test_a_start_that_is_repeated_is_the_first_ones_motion(client: Client, iiwa: Robot) -> None:
    goal = {"lbr_iiwa_joint_1": 0.1}
    first = iiwa.move_joints(goal, request_id="to the left")
    again = iiwa.move_joints(goal, request_id="to the left")
    assert (first.id, first.phase) == (again.id, again.phase) == (first.id, Phase.SUCCEEDED)
    together = [client.move_together([iiwa.ptp(BENT)], request_id="bend").id for _ in range(2)]
    program = client.program().move(iiwa.ptp(goal))
    ran = [program.start(request_id="program").id for _ in range(2)]
    assert len({first.id, *together, *ran}) == 3
    with pytest.raises(InvalidArgumentError, match="'to the left' belongs to another request"):
        iiwa.move_joints(BENT, request_id="to the left")
    with pytest.raises(InvalidArgumentError, match="200 characters"):
        iiwa.move_joints(BENT, request_id=201 * "a")


def test_steps_are_appended_once_and_only_to_the_program_that_is_meant(client: Client, iiwa: Robot) -> None:
    motion = client.program().dwell(0.01).start(open=True)
    more = client.program().dwell(0.01).dwell(0.01)
    for _ in range(2):
        motion.append(more, request_id="more", expected_step_count=1)
    assert motion.step_count == 3
    with pytest.raises(virtualrobot.WrongStateError, match=r"expected_step_count|3 steps"):
        motion.append(more, expected_step_count=1)
    with pytest.raises(virtualrobot.StaleRevisionError):
        motion.append(more, expected_structure_revision=client.scene.revision - 1)
    motion.append(last=True, expected_step_count=3, expected_structure_revision=client.scene.revision)
    assert (motion.wait().phase, motion.step_count) == (Phase.SUCCEEDED, 3)


def test_a_batch_and_files_are_applied_once(client: Client, tmp_path: Path) -> None:
    def change() -> None:
        with client.scene.batch(request_id="a box and a table") as batch:
            batch.add_part("box", virtualrobot.box(0.1, 0.1, 0.1))
            batch.add_object("table")

    change()
    revision = client.scene.revision
    change()
    arms = [client.load_robot(IIWA, request_id="arm").name for _ in range(2)]
    rows = [(0.0, 0.0, 0.1, 0.0)]
    tables = [client.load_denavit_hartenberg(rows, convention="standard", request_id="dh").name for _ in range(2)]
    assert client.scene.revision == revision + 2
    assert len({*arms, *tables}) == 2
    (file := tmp_path / "scene.yaml").write_text("schema_version: 1\nnodes:\n- name: fence\n  object: {}\n")
    assert [client.scene.load_scene(file, add=True, request_id="fence") for _ in range(2)] == [["fence"], ["fence"]]

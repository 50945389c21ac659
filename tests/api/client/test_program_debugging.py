"""Programs that decide on their way, stand before chosen steps, and go on by one step, by a stepped clock."""

from __future__ import annotations

import numpy as np
import pytest
import virtualrobot
from virtualrobot import Client, Motion, Phase, Program, Robot

BENT = [0.0, 0.5, 0.0, -1.2, 0.0, 1.4, 0.0]
JOINT = "lbr_iiwa_joint_1"
MOST_STEPS = 3000


@pytest.fixture
def arm(client: Client, iiwa: Robot) -> Robot:
    """Return an arm, where time goes on by steps, and three signals."""
    client.clock.set_stepped()
    client.scene.set_joint_positions("iiwa", BENT)
    for name in ("full", "a", "b"):
        client.signals.create(name)
    client.signals.create("count", 0)
    return iiwa


def turned(client: Client, arm: Robot, angle: float) -> Program:
    """Return a program that turns the first joint."""
    return client.program().move(arm.ptp({JOINT: angle}))


def until(client: Client, motion: Motion, *phases: Phase) -> Motion:
    """Return a motion once it is in one of some phases."""
    for _ in range(MOST_STEPS):
        if motion.phase in phases:
            return motion
        client.clock.step(5)
    raise AssertionError(f"{motion.id} is {motion.phase.name} at {motion.step_path}")


def paused(client: Client, motion: Motion) -> str:
    """Return the step before which a motion pauses next, or at which it ends."""
    return until(client, motion, Phase.PAUSED, Phase.SUCCEEDED).step_path


def test_a_program_stands_before_its_breakpoints(client: Client, arm: Robot) -> None:
    one = turned(client, arm, 0.1).set("a")
    program = client.program().repeat(3, one).dwell(0.1)
    options = {"wait": False, "on_disconnect": "continue"}
    motion = program.start(breakpoints=["0[1].0", "0.1", "1"], **options)  # type: ignore[arg-type]
    seen = []
    while (step := paused(client, motion)) and not motion.phase.ended:
        seen.append(step)
        motion.resume()
        client.clock.step()
    assert seen == ["0[0].1", "0[1].0", "0[1].1", "0[2].1", "1"]
    with pytest.raises(virtualrobot.VirtualRobotError, match=r"no step '0\.7' to pause before"):
        program.start(breakpoints=["0.7"], wait=False)


def test_a_zone_ends_at_a_breakpoint(client: Client, arm: Robot) -> None:
    program = client.program()
    for angle in (0.3, 0.1, 0.4):
        program.move(arm.ptp({JOINT: angle, "lbr_iiwa_joint_2": angle}), zone_percent=30)
    motion = program.start(breakpoints=["1"], wait=False, on_disconnect="continue")
    assert "the program pauses before step 1" in motion.notes[0].message
    assert paused(client, motion) == "1"
    assert arm.positions[0] == pytest.approx(0.3, abs=1e-9)
    motion.resume()
    until(client, motion, Phase.SUCCEEDED)


def test_a_program_goes_on_step_by_step(client: Client, arm: Robot) -> None:
    box = client.program().attach("thing").pick(arm, "thing")
    client.scene.add_part("thing", [virtualrobot.box(0.02, 0.02, 0.02)], pose=arm.tcp)
    client.scene.add_tool("cup", parent="iiwa.lbr_iiwa_link_7", tool_center_points={"tip": np.eye(4)}, states={})
    program = turned(client, arm, 0.1).set("a").repeat(1, box).dwell(0.1)
    motion = program.start(breakpoints=["0"], wait=False, on_disconnect="continue")
    seen = [paused(client, motion)]
    assert arm.positions[0] == 0.0
    while not motion.phase.ended:
        motion.run_step()
        client.clock.step()
        seen.append(paused(client, motion))
    assert seen == ["0", "1", "2[0].0", "2[0].1", "3", "3"]
    assert motion.phase is Phase.SUCCEEDED


@pytest.mark.parametrize("pauses", [True, False])
def test_what_is_resumed_within_a_step_goes_on_past_its_end(client: Client, arm: Robot, pauses: bool) -> None:
    program = client.program().dwell(0.1).dwell(0.1).dwell(0.1).dwell(0.1)
    motion = program.start(breakpoints=["0", "3"], wait=False, on_disconnect="continue")
    paused(client, motion)
    motion.run_step()
    client.clock.step(2)
    if pauses:
        motion.pause()
        until(client, motion, Phase.PAUSED)
        assert motion.step_path == "0"
    motion.resume()
    client.clock.step()
    assert paused(client, motion) == "3"
    motion.resume()
    client.clock.step()
    until(client, motion, Phase.SUCCEEDED)


def test_nothing_is_appended_before_the_last_decision(client: Client, arm: Robot) -> None:
    program = client.program().dwell(0.1).if_("full", then=turned(client, arm, 0.2))
    motion = program.start(open=True, wait=False, on_disconnect="continue")
    with pytest.raises(virtualrobot.WrongStateError, match="before its text has come to its last decision"):
        motion.append(client.program().dwell(1.0))


@pytest.mark.parametrize("full", [True, False])
def test_a_signal_decides_when_the_step_is_reached(client: Client, arm: Robot, full: bool) -> None:
    one, other = turned(client, arm, 0.2), turned(client, arm, -0.2)
    program = client.program().dwell(0.05).if_("full", then=one, otherwise=other).set("a")
    motion = program.start(wait=False, on_disconnect="continue")
    assert [(note.kind, note.step_path) for note in motion.notes] == [("DEFERRED", "1")]
    assert motion.step_count == 2
    client.signals["full"] = full
    until(client, motion, Phase.SUCCEEDED)
    assert arm.positions[0] == pytest.approx(0.2 if full else -0.2, abs=1e-9)
    assert (motion.step_count, motion.step_path, client.signals["a"]) == (4, "2", True)


def test_a_loop_goes_on_as_long_as_its_signal_says(client: Client, arm: Robot) -> None:
    body = turned(client, arm, 0.05).move(arm.ptp({JOINT: 0.0}))
    program = client.program().while_(body, "count", 3, "<").set("a")
    motion = program.start(breakpoints=["0.1"], wait=False, on_disconnect="continue")
    seen = []
    for count in (1, 2, 3):
        seen.append(paused(client, motion))
        client.signals["count"] = count
        motion.resume()
        client.clock.step()
    until(client, motion, Phase.SUCCEEDED)
    assert seen == ["0[0].1", "0[1].1", "0[2].1"]
    assert client.signals["a"]


def test_a_loop_without_an_end_goes_on_until_it_is_cancelled(client: Client, arm: Robot) -> None:
    """Each round is planned while the one before is done."""
    program = client.program().while_(turned(client, arm, 0.1).move(arm.ptp({JOINT: 0.0})))
    motion = program.start(wait=False, on_disconnect="continue")
    with pytest.raises(virtualrobot.WrongStateError, match="it was not started as an open one"):
        motion.append(client.program().dwell(1.0))
    for _ in range(MOST_STEPS):
        if motion.step_path.startswith("0[4]"):
            break
        client.clock.step(10)
    assert motion.step_path.startswith("0[4]")
    motion.cancel()
    assert until(client, motion, Phase.CANCELLED).state.end_cause == "call"


def test_what_a_decision_may_need_stays_until_the_program_ends(client: Client, arm: Robot) -> None:
    arm.teach("there")
    client.scene.add_object("shelf")
    client.scene.add_object("box", parent="shelf")
    away = client.program().move(arm.ptp("there")).attach("box", "world").set("b")
    program = client.program().dwell(0.05).if_("full", then=away)
    motion = program.start(wait=False, on_disconnect="continue")
    for name in ("there", "box", "shelf"):
        with pytest.raises(virtualrobot.WrongStateError, match=rf"the program '{motion.id}' names the node"):
            client.scene.remove(name)
    with pytest.raises(virtualrobot.WrongStateError, match="names the node 'there'"):
        client.scene.rename("there", "elsewhere")
    for name in ("full", "b"):
        with pytest.raises(virtualrobot.WrongStateError, match=rf"names the signal '{name}'"):
            client.scene.remove_signal(name)
    client.scene.rename("shelf", "rack")
    until(client, motion, Phase.SUCCEEDED)
    client.scene.remove("there")
    with pytest.raises(virtualrobot.UnknownNameError, match=r"step 1\.then\.0: .*'there'"):
        program.start(wait=False)
    client.scene.remove("box")
    client.scene.remove_signal("b")


def test_what_can_not_be_done_is_told_when_it_is_reached_and_names_at_once(client: Client, arm: Robot) -> None:
    away = client.program().move(arm.ptp(virtualrobot.pose(5.0)))
    motion = client.program().dwell(0.05).if_("a", False, then=away).start(wait=False, on_disconnect="continue")
    state = until(client, motion, Phase.ABORTED).state
    assert (state.end_cause, state.end_reason[:15]) == ("step_refused", "step 1.then.0: ")
    for wrong, words in (
        (client.program().if_("a", then=client.program().pick("nobody")), "step 0.then.0: .*'nobody'"),
        (client.program().if_("nothing", then=away), "'nothing'"),
        (client.program().if_("a", then=client.program().wait("nothing")), "'nothing'"),
        (client.program().if_("a", then=client.program()), "then is empty"),
    ):
        with pytest.raises(virtualrobot.VirtualRobotError, match=words):
            wrong.start(wait=False)

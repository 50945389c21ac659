"""Programs of the kernel in the languages of controllers, read back from them: RAPID, URScript, KRL and TP."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
import virtualrobot
from click.testing import CliRunner
from virtualrobot import Client, Program, Robot
from virtualrobot.errors import InvalidArgumentError, TooLargeError
from virtualrobot_apps.emulators.body import SimulatedArm
from virtualrobot_apps.emulators.ur.controller import Controller
from virtualrobot_apps.emulators.ur.scripts import run_script
from virtualrobot_apps.languages.core.source import Source
from virtualrobot_apps.languages.rapid.recording import recorded
from virtualrobot_apps.languages.rapid.task import load
from virtualrobot_apps.languages.writers import fanuc, krl, rapid, urscript
from virtualrobot_apps.languages.writers.command import program as command
from virtualrobot_apps.languages.writers.resolve import robot_program
from virtualrobot_apps.languages.writers.statements import Arc, Goal, Line, PointToPoint, RobotProgram, UseTool
from virtualrobot_apps.languages.writers.words import Language

from tests.apps.languages.controllers import read_krl, read_tp
from tests.kernels import KernelProcess

pytestmark = pytest.mark.long

pose = virtualrobot.pose
TOOL_SIGNALS = {"closed": ("gripper", True), "open": ("gripper", False)}


@pytest.fixture
def arm(steps: Client) -> Robot:
    """Return an IRB 120 with a gripper before a tray, and signals, in a stepped world."""
    arm = steps.load_robot("model://irb120", name="arm", pose=pose(0.5, -0.3, 0.2, yaw=0.4))
    return ready(steps, arm, [0.0, 0.0, 0.0, 0.0, 0.5, 0.0])


def ready(client: Client, arm: Robot, joints: list[float]) -> Robot:
    """Return an arm with a gripper at a posture, before a tray."""
    arm.set_positions(joints)
    point = pose(0.01, 0.0, 0.1, pitch=0.2, yaw=0.3)
    states = {"open": dict[str, float](), "closed": dict[str, float]()}
    client.scene.add_tool("grip", arm.flange, tool_center_points={"tip": point}, states=states)
    client.scene.select_tool("arm", "grip", "tip")
    client.scene.add_object("tray", pose=arm.tcp @ pose(x=0.05, z=0.02, yaw=0.5))
    for name in ("gripper", "part"):
        client.signals.create(name)
    client.signals.create("level", 0.5)
    return arm


def picking(client: Client, arm: Robot, zones: bool = True) -> Program:
    """Return a program with each kind of step, with zones after two moves or without."""
    down = client.program().move(arm.linear(pose(x=0.06, z=-0.03), reference="tray"))
    down.move(arm.linear(pose(x=0.06), reference="tray", velocity=0.4, acceleration=0.5))
    first = arm.joint_names[0]
    program = client.program()
    program.move(arm.ptp({first: arm.positions[0] + 0.3}), zone=0.015 if zones else None)
    program.move(arm.ptp(arm.tcp @ pose(z=-0.05), speed_factor=0.5))
    program.speed(0.5)
    program.move(arm.linear(pose(z=-0.05), reference="tray", velocity=0.2), zone=0.02 if zones else None)
    program.set("gripper", False)
    program.move(arm.linear(pose(roll=0.2), reference="tray", velocity=0.2))
    program.tool_state(arm, "closed")
    program.wait("part", True, timeout=2)
    program.dwell(0.2)
    program.move(arm.circular([0.03, 0.03, -0.02], pose(x=0.06), reference="tray", velocity=0.1))
    program.repeat(2, down)
    return program


def resolved(client: Client, arm: Robot, program: Program) -> RobotProgram:
    """Return what a program has the arm do."""
    return robot_program(client, program, arm, "picking", TOOL_SIGNALS)


def moves(program: RobotProgram) -> list[PointToPoint | Line | Arc]:
    """Return the moves of a program."""
    return [one for _, one in program.statements if isinstance(one, PointToPoint | Line | Arc)]


def goals(move: PointToPoint | Line | Arc) -> list[Goal]:
    """Return the places that a move names."""
    return [move.via, move.goal] if isinstance(move, Arc) else [move.goal]


def test_a_program_in_rapid_is_the_same_motion(arm: Robot, steps: Client) -> None:
    """Each tick's joints of both plans are the same to 1e-6 rad, and so are the steps between; zones become radii."""
    notes: list[str] = []

    def both(zones: bool) -> tuple[Program, Program]:
        program = picking(steps, arm, zones)
        text = rapid.write(resolved(steps, arm, program), Language({}))
        again = recorded(steps, "arm", load([Source(text, "picking.mod")], steps.signals), say=notes.append)
        assert not notes
        return program, again

    _, again = both(True)
    radii = [step["move"]["blend_radius"] for step in json.loads(again.text)["steps"] if "blend_radius" in str(step)]
    assert [one["radius_meters"] for one in radii] == [0.015, 0.02]
    program, again = both(False)
    plans = [one.plan().robots["arm"] for one in (program, again)]
    np.testing.assert_allclose(plans[1].positions, plans[0].positions, rtol=0.0, atol=1e-6)
    said = json.loads(again.text)["steps"]
    kinds = [kind for step in said for kind in step]
    wanted = ["move"] * 3 + ["set_signal", "move", "set_signal", "wait_signal", "dwell"] + ["move"] * 5
    assert kinds == wanted
    wait = {"signal": "part", "value": {"boolean": True}, "comparison": "COMPARISON_EQUAL"}
    assert said[6]["wait_signal"] == {"condition": wait, "timeout_seconds": 2.0}


def test_numbers_of_signals_come_back_from_rapid(arm: Robot, steps: Client) -> None:
    steps.signals.create("count", 3)
    program = steps.program().set("level", 0.25).set("count", 7).wait("level", 0.5, comparison=">")
    program.wait("count", 4, comparison="!=").wait("count", 5)
    text = rapid.write(resolved(steps, arm, program), Language({}))
    again = recorded(steps, "arm", load([Source(text, "signals.mod")], steps.signals))
    said = [json.loads(one.text.replace(', "comparison": "COMPARISON_EQUAL"', "")) for one in (again, program)]
    assert said[0] == said[1]


def test_krl_says_the_same(arm: Robot, steps: Client) -> None:
    program = resolved(steps, arm, picking(steps, arm))
    signs = (-1.0, 1.0, 1.0, -1.0, 1.0, -1.0)
    found = read_krl(krl.write(program, Language({"gripper": "$OUT[1]", "part": "$IN[2]"}, signs)))
    given = [one for one in found.steps if one[0] in ("PTP", "LIN", "CIRC")]
    kinds = {PointToPoint: "PTP", Line: "LIN", Arc: "CIRC"}
    assert [one[0] for one in given] == [kinds[type(one)] for one in moves(program)]
    tool = program.tools["grip"]
    for (kind, places, speed, corner, with_tool), move in zip(given, moves(program), strict=True):
        np.testing.assert_allclose(with_tool, tool, atol=1e-9)
        if isinstance(move, PointToPoint):
            np.testing.assert_allclose(signs * places[0], move.goal.joints, atol=1e-9)
            assert speed == pytest.approx(move.share)
            assert corner is None or (kind, corner[0], move.zone is not None) == ("PTP", "CPTP", True)
            assert corner is None or move.zone is None or corner[1] == pytest.approx(200.0 * move.zone.share, rel=1e-5)
        else:
            for place, goal in zip(places, goals(move), strict=True):
                np.testing.assert_allclose(place, goal.base_t_tcp, atol=1e-8)
            assert speed == pytest.approx(move.speed)
            assert (corner is None) == (move.zone is None)
            assert move.zone is None or corner == ("CDIS", pytest.approx(1000.0 * move.zone.meters))
    others = [one for one in found.steps if one[0] in ("set", "wait")]
    assert others == [
        ("set", "$OUT[1]", "FALSE"),
        ("set", "$OUT[1]", "TRUE"),
        ("set", "$TIMER[1]", "-2000"),
        ("set", "$TIMER_STOP[1]", "FALSE"),
        ("wait", "FOR", "($IN[2] == TRUE) OR $TIMER_FLAG[1]"),
        ("wait", "SEC", "0.2"),
    ]


@pytest.mark.parametrize("coupling", [0.0, 1.0])
def test_tp_says_the_same(arm: Robot, steps: Client, coupling: float) -> None:
    program = resolved(steps, arm, picking(steps, arm))
    where = {"gripper": "DO[1]", "part": "DI[2]"}
    found = read_tp(fanuc.write(program, Language(where, coupling=coupling)), coupling)
    given = [one for one in found.steps if one[0] in "JLC"]
    kinds = {PointToPoint: "J", Line: "L", Arc: "C"}
    assert [one[0] for one in given] == [kinds[type(one)] for one in moves(program)]
    for (_, places, speed, corner, tool), move in zip(given, moves(program), strict=True):
        np.testing.assert_allclose(found.tools[tool], program.tools["grip"], atol=1e-9)
        np.testing.assert_allclose(places, [goal.joints for goal in goals(move)], atol=2e-8)  # 1e-6 degrees
        assert speed == pytest.approx(move.share if isinstance(move, PointToPoint) else move.speed)
        assert (corner is None) == (move.zone is None)
        if move.zone is not None and corner is not None:
            sized = 200.0 * move.zone.share if corner[0] == "CNT" else 1000.0 * move.zone.meters
            assert corner[1] == pytest.approx(sized, abs=0.5 if corner[0] == "CNT" else 1e-6)
    others = [one for one in found.steps if one[0] in ("set", "wait")]
    assert others == [
        ("set", "DO[1]", "OFF"),
        ("set", "DO[1]", "ON"),
        ("wait", "DI[2]=ON TIMEOUT,LBL[99]"),
        ("wait", "0.2(sec)"),
    ]


def test_a_trajectory_is_told_as_lines_beside_which_the_tool_never_is(arm: Robot, steps: Client) -> None:
    """An arc as joints at times, as a tool path is: read back from RAPID the tool is within 0.1 mm of it and its end.

    Lines are 0.05 mm beside it at the most, and zones of 0.4 of a line cut off 0.04 mm of a corner between two of them.
    """
    middle, end = arm.tcp @ pose(x=0.03, y=0.02), arm.tcp @ pose(x=0.06)
    arc = arm.circular(middle[:3, 3], end, velocity=0.05)
    there = steps.program().move(arc).plan()
    rows = there.robots["arm"]
    program = steps.program().move(arm.trajectory(there.times, rows.positions)).move(arm.ptp({arm.joint_names[0]: 0.1}))
    found = resolved(steps, arm, program)
    first, *lines, last = moves(found)
    assert isinstance(first, PointToPoint) and isinstance(last, PointToPoint)
    assert len(lines) > 4 and all(isinstance(one, Line) and one.zone is not None for one in lines[:-1])
    assert lines[-1].zone is None and max(one.speed for one in lines if isinstance(one, Line)) == pytest.approx(
        0.05, rel=0.01
    )
    assert f"step 0: its joint trajectory is told as {len(lines)} lines, within 0.05 mm" in found.notes[-2]
    again = recorded(steps, "arm", load([Source(rapid.write(found, Language({})), "arc.mod")], steps.signals))
    goes = again.plan().robots["arm"].world_t_tcp[:, :3, 3]
    points = rows.world_t_tcp[:, :3, 3]
    inside = goes[: int(np.linalg.norm(goes - end[:3, 3], axis=1).argmin()) + 1]
    off = np.linalg.norm(inside[:, None] - points, axis=2).min(axis=1)
    # Samples of the arc are 0.2 mm apart: half of that is along it.
    assert np.sqrt(np.maximum(off**2 - 1e-8, 0.0)).max() < 1e-4
    np.testing.assert_allclose(inside[-1], end[:3, 3], atol=1e-6)
    for writer in (krl, fanuc, urscript):
        assert len(writer.write(found, Language({})).splitlines()) > len(lines)


def test_a_trajectory_that_turns_on_the_spot_is_no_line(arm: Robot, steps: Client) -> None:
    steps.scene.select_tool("arm", None)
    positions = np.tile(arm.positions, (3, 1))
    positions[:, -1] += [0.0, 0.3, 0.6]
    program = steps.program().move(arm.trajectory([0.0, 1.0, 2.0], positions))
    with pytest.raises(InvalidArgumentError, match=r"step 0 .* it turns its tool on the spot, which no line tells"):
        resolved(steps, arm, program)


def test_a_script_moves_the_controller_of_a_ur_through_the_same_places(steps: Client) -> None:
    """Its kinematics are of Universal Robots' table; so the joints that it finds for poses are ours to 1e-4 rad."""
    arm = ready(steps, steps.load_robot("model://ur5e", name="arm"), [0.2, -1.4, 1.6, -1.8, -1.5, 0.3])
    program = resolved(steps, arm, picking(steps, arm))
    text = urscript.write(program, Language({"gripper": "standard_out[3]", "part": "standard_in[2]"}))
    controller = Controller(SimulatedArm(arm.positions.copy()))
    controller.digital_inputs = 0b100
    run_script(controller, text)
    targets = []
    while controller.program is not None and len(targets) < 20_000:
        controller.cycle()
        targets.append(controller.target.copy())
    assert not controller.words
    way = np.array(targets)
    for move in moves(program):
        if move.zone is None:
            assert np.abs(way - move.goal.joints).max(axis=1).min() < 1e-4
    np.testing.assert_allclose(way[-1], moves(program)[-1].goal.joints, atol=1e-4)
    assert controller.digital_outputs == 0b1000


def test_tools_and_places_where_a_program_begins_are_told(arm: Robot, steps: Client) -> None:
    """A first line begins somewhere: the program goes there first. Zones that lead to no move are fine."""
    steps.scene.select_tool("arm", None)
    line = arm.linear(arm.tcp @ pose(z=-0.02))
    program = steps.program().move(line, zone_percent=20).dwell(0.1)
    program.select_tool(arm, "grip").move(arm.ptp({arm.joint_names[0]: 0.1})).pick(arm).place(arm)
    found = resolved(steps, arm, program)
    first, second, third = moves(found)
    assert isinstance(first, PointToPoint) and isinstance(second, Line) and isinstance(third, PointToPoint)
    np.testing.assert_allclose(first.goal.joints, [0.0, 0.0, 0.0, 0.0, 0.5, 0.0], atol=1e-9)
    assert second.zone is None
    tools = [one.tool for _, one in found.statements if isinstance(one, UseTool)]
    assert tools == ["", "grip"]
    np.testing.assert_allclose(found.tools["grip"], pose(0.01, 0.0, 0.1, pitch=0.2, yaw=0.3), atol=1e-12)
    said = [note.partition(":")[0] for note in found.notes]
    dropped, foreseen = "the corner after step 0 is reached exactly and at rest", "can't be done in the world as it is"
    assert said[0] == dropped and foreseen in said[1] and said[-4:] == ["step 0", "step 4", "step 5", "step 0"]
    text = rapid.write(found, Language({}))
    assert text.count("tool0;") == 2 and text.count(", grip;") == 1 and text.count("simulator") == 2


def test_rapid_names_are_words_of_rapid(arm: Robot, steps: Client) -> None:
    steps.signals.create("gripper/1.close")
    program = steps.program().set("gripper/1.close", True).set("gripper", True)
    found = robot_program(steps, program, arm, "2nd program, with a name that is very long", {})
    text = rapid.write(found, Language({"gripper": "doGrip"}))
    assert text.startswith("MODULE n2nd_program__with_a_name_that_i\n")
    assert "SetDO gripper_1_close, 1;" in text and "SetDO doGrip, 1;" in text
    load([Source(text, "names.mod")], ["gripper_1_close", "doGrip"])  # each name is a word


@pytest.mark.parametrize(
    ("step", "words"),
    [
        ("spline", "step 1 can't be written for a robot: a spline"),
        ("jog", "step 1 .* a jog is for a person's hand"),
        ("search", "step 1 .* a move that searches"),
        ("part", "step 1 .* a robot does not know where parts are"),
        ("state", "step 1 .* which signal brings the tool into the state 'open'. Give --tool-state open=SIGNAL"),
        ("circle", "step 1 .* an arc of a whole turn"),
        ("disc", "step 1 .* a tool that turns with its arc"),
        ("text", "step 1 .* a signal of text"),
        ("round", r"step 1\[0\].0 .* a move that searches"),
        ("decision", r"step 1.then.0 .* a move that searches"),
        ("elsewhere", "step 2 .* it goes elsewhere after one decision than after another; give a goal"),
        ("slower", r"step 2 .* what is decided before it changes what it does"),
        ("beyond", r"step 1\[0\].0: "),
        ("other", "step 1 .* it moves 'other', and the program is for 'arm'"),
        ("frame", "step 3 .* its frame 'tray' moves while the program runs"),
        ("far", "step 1: "),
    ],
)
def test_what_no_controller_has_is_refused_by_its_place(arm: Robot, steps: Client, step: str, words: str) -> None:
    new = steps.program
    there = arm.tcp @ pose(z=-0.03)
    side = (arm.tcp @ pose(x=0.01, z=-0.01))[:3, 3]
    search = new().move(arm.linear(there, until="part"))
    other = new().move(arm.ptp({arm.joint_names[1]: 0.2}))
    if step == "other":
        steps.load_robot("model://irb120", name="other", pose=pose(y=2.0))
    steps.signals.create("words", "a")
    programs = {
        "spline": lambda: new().move(arm.spline([there, arm.tcp])),
        "jog": lambda: new().move(arm.joint_jog(arm.joint_names[0], 0.1, 0.1)),
        "search": lambda: search,
        "part": lambda: new().wait_part("tray"),
        "state": lambda: new().tool_state(arm, "open"),
        "circle": lambda: new().move(arm.circular(center=there[:3, 3], axis=arm.tcp[:3, 1], angle=2 * np.pi)),
        "disc": lambda: new().move(arm.circular(side, there, turn_with_arc=True)),
        "text": lambda: new().set("words", "b"),
        "round": lambda: new().repeat(1, search),
        "decision": lambda: new().if_("part", then=search),
        "elsewhere": lambda: new().if_("part", then=other).move(arm.ptp({arm.joint_names[0]: 0.2})),
        "slower": lambda: new().if_("part", then=new().speed(0.5)).move(arm.ptp({arm.joint_names[0]: 0.2})),
        "beyond": lambda: new().while_(new().move(arm.linear(pose(x=9.0))), "part"),
        "other": lambda: new().move(steps.robot("other").ptp({"joint_1": 0.1})),
        "frame": lambda: (
            new()
            .attach("tray", "arm.link_1")
            .move(arm.ptp({arm.joint_names[0]: 0.2}))
            .move(arm.linear(np.linalg.inv(steps.scene.pose("tray")) @ there, reference="tray"))
        ),
        "far": lambda: new().move(arm.linear(pose(x=9.0))),
    }
    spec = json.loads(new().move(arm.ptp({arm.joint_names[0]: 0.0})).text)
    spec["steps"] += json.loads(programs[step]().text)["steps"]
    with pytest.raises(virtualrobot.VirtualRobotError, match=words):
        robot_program(steps, new(json.dumps(spec)), arm, "refused", {})


@pytest.mark.parametrize(
    ("writer", "signals", "words"),
    [
        (krl, {}, r"step 0: the signal 'level' has no address on the controller; give --signal level=\$OUT\[1\]"),
        (krl, {"level": "DO[1]"}, r"the signal 'level' can't be at 'DO\[1\]'; an address is as \$OUT\[1\]"),
        (krl, {"level": "$OUT[1]"}, r"step 0: 0.5 as a value of \$OUT\[1\] can't be said in KRL"),
        (fanuc, {"level": "DO[1]"}, r"step 0: 0.5 as a value of DO\[1\] can't be said in TP"),
        (urscript, {"level": "standard_out[8]"}, "an address is as standard_out"),
        (urscript, {"level": "standard_out[1]"}, "step 0: a digital signal of 0.5 can't be said in URScript"),
        (urscript, {"level": "standard_in[1]"}, "step 0: an input that is set, 'level', can't be said in URScript"),
    ],
)
def test_signals_need_the_addresses_of_their_controller(
    arm: Robot, steps: Client, writer: object, signals: dict[str, str], words: str
) -> None:
    found = resolved(steps, arm, steps.program().set("level", 0.5))
    with pytest.raises(InvalidArgumentError, match=words):
        writer.write(found, Language(signals))  # type: ignore[attr-defined] a module


def test_an_arm_of_seven_joints_is_refused(steps: Client) -> None:
    arm = steps.load_robot("model://iiwa7", name="arm")
    found = robot_program(steps, steps.program().dwell(0.1), arm, "seven", {})
    for writer in (rapid, urscript, krl, fanuc):
        with pytest.raises(InvalidArgumentError, match=r"'arm' has 7 joints; .* arms with six that turn"):
            writer.write(found, Language({}))


@pytest.mark.parametrize(
    ("statement", "words"),
    [
        ("IF part = 1 TPWrite a;", "reads the signal part"),
        ("SearchL part, p, [[0, 0, 0], [1, 0, 0, 0], [0, 0, 0, 0], AXES], v100, tool0;", "3: "),
        ("StopMove;", "stops its own motion"),
        ("PulseDO gripper;", "reads the signal gripper"),
        ("MoveAbsJ [[0, 0, 0, 0, 30, 0], AXES], v100, fine, grip;", "this tool's centre point is not that of"),
    ],
)
def test_rapid_that_looks_at_the_world_is_refused_at_its_line(
    arm: Robot, steps: Client, statement: str, words: str
) -> None:
    axes = "[9E9, 9E9, 9E9, 9E9, 9E9, 9E9]"
    steps.scene.select_tool("arm", None)
    tool = "PERS tooldata grip := [TRUE, [[0, 0, 9], [1, 0, 0, 0]], [1, [0, 0, 1], [1, 0, 0, 0], 0, 0, 0]];"
    lines = ["MODULE M", "PROC main()", statement.replace("AXES", axes), "ENDPROC", "VAR robtarget p;VAR string a;"]
    text = "\n".join([*lines, tool, "ENDMODULE", ""])
    with pytest.raises(virtualrobot.VirtualRobotError, match=rf"looks.mod:3: .*{words}|looks.mod:{words}"):
        recorded(steps, "arm", load([Source(text, "looks.mod")], steps.signals))


def test_the_command_writes_and_reads(arm: Robot, steps: Client, stepped_kernel: KernelProcess, tmp_path: Path) -> None:
    """It writes for the robot that the program moves, of two; what is read needs its name."""
    steps.load_robot("model://irb120", name="other")
    (tmp_path / "cell.yaml").write_text(
        "schema_version: 1\nsteps:\n"
        "  - move: {moves: [{robot: arm, point_to_point: {joints: {joint_positions: {joint_1: 0.3}}}}]}\n"
        "  - set_signal: {signal: gripper, value: {boolean: true}}\n"
        "  - move: {moves: [{robot: arm, tool_state: {state: closed}}]}\n"
    )
    address = ["--address", stepped_kernel.address]

    def run(*arguments: str) -> tuple[int, str]:
        done = CliRunner().invoke(command, [*arguments, *address], standalone_mode=False)
        return (done.return_value, done.output) if done.exception is None else (1, str(done.exception))

    cell, closed = str(tmp_path / "cell.yaml"), ("--tool-state", "closed=gripper:false")
    code, said = run("export", cell, "--as", "rapid", *closed)
    assert (code, said) == (0, f"4 statements in {tmp_path / 'cell.mod'}\n")
    assert "SetDO gripper, 0;" in (tmp_path / "cell.mod").read_text()
    assert run("import", str(tmp_path / "cell.mod"))[1] == "name the arm by --robot; there are arm, other"
    code, said = run("import", str(tmp_path / "cell.mod"), "--robot", "arm", "-o", str(tmp_path / "again.yaml"))
    assert (code, said) == (0, f"3 steps in {tmp_path / 'again.yaml'}\n")
    plans = [steps.read_program(tmp_path / one) for one in ("cell.yaml", "again.yaml")]
    ends = [one.plan().robots["arm"] for one in plans]
    assert [one.positions[-1][one.joint_names.index("joint_1")] for one in ends] == pytest.approx([0.3, 0.3])
    code, said = run("export", cell, "--as", "fanuc", *closed)
    assert code == 1 and "give --signal gripper=DO[1]" in said
    code, said = run("export", cell, "--as", "krl", "--signs", "1,x")
    assert code == 1 and "--signs takes numbers" in said
    code, said = run("export", cell, "--as", "krl", "--signs", "1,2", *closed, "--signal", "gripper=$OUT[1]")
    assert code == 1 and "six numbers, each 1 or -1" in said
    code, said = run("export", cell, "--as", "rapid", "--tool-state", "closed")
    assert code == 1 and "gripper=DO[1], not 'closed'" in said
    code, said = run("export", cell, "--as", "rapid", "--tool-state", "closed=gripper:on")
    assert code == 1 and "a signal's value is true, false or a number, not 'on'" in said


def test_a_program_of_more_than_140_seconds_is_refused_and_one_of_two_minutes_is_written(
    arm: Robot, steps: Client
) -> None:
    """An answer of the kernel holds 59 s of six joints at each tick; of longer ones it holds as many samples."""
    ends = []
    for seconds in (1.0, 100.0):
        program = steps.program().dwell(seconds).move(arm.linear(pose(z=-0.05), reference="tray", velocity=0.02))
        ends.append(goals(moves(resolved(steps, arm, program))[-1])[0])
    np.testing.assert_allclose(ends[1].base_t_tcp, ends[0].base_t_tcp, atol=1e-9)
    np.testing.assert_allclose(ends[1].joints, ends[0].joints, atol=1e-9)
    with pytest.raises(TooLargeError, match="and 140 s are written at once: write it in parts"):
        resolved(steps, arm, steps.program().dwell(150.0).move(arm.linear(arm.tcp @ pose(x=0.05))))

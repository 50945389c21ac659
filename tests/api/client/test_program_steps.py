"""Steps of programs that change the world, and steps made of steps, on a real kernel by a stepped clock."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
import virtualrobot
from virtualrobot import Client, Motion, Phase, Robot

BENT = [0.0, 0.5, 0.0, -1.2, 0.0, 1.4, 0.0]
DOWN = virtualrobot.pose(roll=np.pi)
PALLET = virtualrobot.pose(0.45, 0.35, 0.1)
MOST_TICKS = 60_000

FILE = """\
schema_version: 1
programs:
  one: {steps: [{pick: {robot: iiwa, part: part}}, {place: {robot: iiwa, parent: pallet}}]}
steps:
  - repeat: {count: 2, steps: [{call: {program: one}}]}
  - pattern:
      name: place
      reference: pallet
      pattern: {columns: 1, rows: 2, row_pitch_meters: 0.1}
      steps:
        - move:
            moves:
              - robot: iiwa
                point_to_point:
                  pose:
                    reference: place
                    reference_t_tcp: {position: {z: 0.2}, orientation: {x: 1.0}}
  - set_speed: {factor: 0.5}
"""


@pytest.fixture
def arm(client: Client, iiwa: Robot) -> Robot:
    """Return an arm with a suction cup over a table without figures, where time goes on by steps."""
    client.clock.set_stepped()
    client.scene.add_tool(
        "cup",
        parent="iiwa.lbr_iiwa_link_7",
        tool_center_points={"tip": virtualrobot.pose(z=0.08)},
        states={"off": {}, "on": {}},
    )
    client.scene.set_joint_positions("iiwa", BENT)
    client.scene.add_object("table")
    client.scene.add_object("pallet", pose=PALLET)
    for name in ("go", "there"):
        client.signals.create(name)
    return iiwa


def box(client: Client, name: str, x: float, y: float, z: float) -> None:
    """Put a part of 4 cm there."""
    client.scene.add_part(name, [virtualrobot.box(0.04, 0.04, 0.04)], pose=virtualrobot.pose(x, y, z))


def ended(client: Client, motion: Motion, ticks: int = 50) -> Motion:
    """Return a motion after its end, with time going on for so many ticks at once."""
    for _ in range(MOST_TICKS // ticks):
        if motion.phase.ended:
            return motion
        client.clock.step(ticks)
    raise AssertionError(f"{motion.id} has not ended")


def test_a_part_is_carried_by_a_program_alone(client: Client, arm: Robot) -> None:
    box(client, "part", 0.5, 0.0, 0.1)
    program = client.program()
    program.pick_at(arm, virtualrobot.pose(0.5, 0.0, 0.12) @ DOWN, approach=0.1, state="on")
    program.place_at(
        arm, virtualrobot.pose(z=0.02) @ DOWN, reference="pallet", approach=0.1, state="off", parent="pallet"
    )
    motion = program.start(wait=False, on_disconnect="continue")
    assert not motion.notes
    assert ended(client, motion).phase is Phase.SUCCEEDED
    assert client.scene.node("part").parent == "pallet"
    np.testing.assert_allclose(client.scene.pose("part"), PALLET, atol=1e-5)


@pytest.mark.long
def test_parts_of_a_pallet_are_where_the_formula_has_them(client: Client, arm: Robot) -> None:
    """A layer of 2 x 3 places and a turned one, each place the frame of the goals."""
    columns, rows, layers, across, along, up, turn = 2, 3, 2, 0.09, 0.06, 0.05, np.pi / 2
    wanted = [
        PALLET
        @ virtualrobot.pose(yaw=layer % 2 * turn)
        @ virtualrobot.pose((column - 0.5) * across, (row - 1) * along, layer * up)
        for layer in range(layers)
        for column in range(columns)
        for row in range(rows)
    ]
    pallet = virtualrobot.Pattern(columns, rows, layers, across, along, up, layer_turn=turn)
    box(client, "part", 0.5, 0.0, 0.1)
    home = client.program().move(arm.ptp(virtualrobot.pose(0.5, 0.0, 0.12) @ DOWN))
    one = client.program().call(home, "home").attach("part", pose=virtualrobot.pose(0.5, 0.0, 0.1)).pick(arm, "part")
    one.move(arm.ptp(virtualrobot.pose(z=0.02) @ DOWN, reference="place")).place(arm, parent="pallet")
    motion = (
        client.program().pattern("place", pallet, one, reference="pallet").start(wait=False, on_disconnect="continue")
    )
    assert motion.step_count == 12 * 5
    seen, paths = [], [motion.step_path]
    while not motion.phase.ended:
        client.clock.step(10)  # the way home takes longer
        if motion.step_path != paths[-1]:
            paths.append(motion.step_path)
            if paths[-1].endswith("].0.0"):
                seen.append(client.scene.pose("part"))
    seen.append(client.scene.pose("part"))
    assert motion.phase is Phase.SUCCEEDED
    assert (paths[0], paths[-1]) == ("0[0].0.0", "0[11].4")
    np.testing.assert_allclose(seen, wanted, atol=1e-5)


def test_a_pick_of_nothing_aborts_and_names_its_place_in_the_text(client: Client, arm: Robot) -> None:
    picks = client.program().dwell(0.02).pick(arm)
    motion = client.program().dwell(0.01).repeat(2, picks).start(wait=False, on_disconnect="continue")
    first, second = motion.notes
    assert (first.kind, first.step, first.step_path, second.step_path) == ("UNFORESEEN", 2, "1[0].1", "1[1].1")
    state = ended(client, motion).state
    assert (state.phase, state.end_cause, state.step, state.step_path) == (Phase.ABORTED, "step_refused", 2, "1[0].1")
    assert state.end_reason == "step 1[0].1: there is no part that could be picked"
    np.testing.assert_allclose(arm.positions, BENT, atol=1e-12)


def test_what_comes_later_is_picked_though_it_was_not_foreseen(client: Client, arm: Robot) -> None:
    point = arm.tcp[:3, 3]
    program = client.program().wait_part(position=point, max_distance=0.05, timeout=2.0).place(arm).pick(arm)
    motion = program.start(wait=False, on_disconnect="continue")
    assert [(note.kind, note.step) for note in motion.notes] == [("UNFORESEEN", 1), ("UNFORESEEN", 2)]
    motion.cancel()
    client.clock.step(1)
    program = client.program().wait_part(position=point, max_distance=0.05, timeout=2.0).pick(arm)
    motion = program.start(wait=False, on_disconnect="continue")
    assert [note.kind for note in motion.notes] == ["UNFORESEEN"]
    client.clock.step(100)
    assert motion.phase is Phase.WAITING
    box(client, "part", *(point + virtualrobot.pose(y=0.06)[:3, 3]))
    client.clock.step(10)
    assert motion.phase is Phase.WAITING
    client.scene.attach("part", pose=virtualrobot.pose(*(point + virtualrobot.pose(y=0.04)[:3, 3])))
    client.clock.step(3)
    assert motion.phase is Phase.SUCCEEDED
    assert client.scene.node("part").parent == "cup"


def test_a_part_that_does_not_come_ends_the_wait(client: Client, arm: Robot) -> None:
    program = client.program().dwell(0.01).wait_part("part", reference="table", max_distance=0.05, timeout=0.1)
    with pytest.raises(virtualrobot.UnknownNameError, match=r"step 1: .*part.* named 'part'"):
        program.start(wait=False)
    box(client, "part", 0.5, 0.0, 0.1)
    state = ended(client, program.start(wait=False, on_disconnect="continue"), 5).state
    assert (state.phase, state.end_cause) == (Phase.ABORTED, "part_timeout")
    assert state.end_reason.startswith(
        "step 1: no part 'part' was within 0.05 m of x 0, y 0, z 0 m in the frame of 'table'"
    )


def test_what_is_held_counts_in_checks(client: Client, arm: Robot) -> None:
    """The way is free for the arm alone, and a box that it holds meets a wall on it."""
    point = arm.tcp[:3, 3]
    client.scene.add_part("long", [virtualrobot.box(0.02, 0.02, 0.6)], pose=virtualrobot.pose(*point - [0, 0, 0.31]))
    client.scene.add_object(
        "wall", [virtualrobot.box(0.4, 0.02, 0.05)], pose=virtualrobot.pose(point[0], point[1] + 0.15, point[2] - 0.5)
    )
    away = arm.linear(virtualrobot.pose(y=0.3) @ arm.tcp)
    assert client.program().move(away).check().ok
    found = client.program().dwell(0.1).repeat(1, client.program().pick(arm, "long").move(away)).check().first_violation
    assert found is not None
    assert {found.first, found.second} == {"long", "wall"}
    assert (found.kind.name, found.step, found.step_path) == ("COLLISION", 2, "1[0].1")
    assert client.program().pick(arm, "long").place(arm, "long").move(away).check().ok


def test_steps_are_appended_to_what_holds_a_part(client: Client, arm: Robot) -> None:
    """The appended step is planned from the world as the steps before will have made it."""
    box(client, "part", *(arm.tcp[:3, 3] - [0, 0, 0.02]))
    there = virtualrobot.pose(y=0.1) @ arm.tcp
    program = client.program().repeat(1, client.program().dwell(0.1).pick(arm, "part"))
    motion = program.start(open=True, wait=False, on_disconnect="continue")
    more = client.program().move(arm.linear(there)).place(arm, parent="pallet").set("there")
    assert motion.append(more, last=True) == ()
    client.clock.step(27)
    assert (motion.step, motion.step_path, motion.step_count) == (2, "1", 5)
    assert ended(client, motion).phase is Phase.SUCCEEDED
    assert client.scene.node("part").parent == "pallet"
    np.testing.assert_allclose(arm.tcp, there, atol=1e-6)


def test_a_speed_holds_for_the_moves_after_it(client: Client, arm: Robot) -> None:
    there, back = arm.ptp({"lbr_iiwa_joint_1": 0.4}), arm.ptp({"lbr_iiwa_joint_1": 0.0})
    once, slow = (arm.plan(arm.ptp({"lbr_iiwa_joint_1": 0.4}, speed_factor=one)).duration for one in (1.0, 0.5))
    program = client.program().move(there).speed(0.5).move(back).speed(1.0).move(there)
    assert program.plan().duration == pytest.approx(2 * once + slow, abs=0.005)
    motion = client.program().speed(0.5, arm).start(open=True, wait=False, on_disconnect="continue")
    motion.append(client.program().move(there), last=True)
    assert motion.planned_duration == pytest.approx(slow, abs=0.005)
    motion.cancel()


def test_a_chosen_tool_counts_for_the_moves_after_it(client: Client, arm: Robot) -> None:
    client.scene.add_tool(
        "pin", parent="iiwa.lbr_iiwa_link_7", tool_center_points={"tip": virtualrobot.pose(z=0.2)}, states={}
    )
    client.scene.select_tool("iiwa", "cup")
    goal = virtualrobot.pose(0.5, 0.0, 0.3) @ DOWN
    program = client.program().move(arm.ptp(goal)).select_tool(arm, "pin").move(arm.ptp(goal)).select_tool(arm, "cup")
    np.testing.assert_allclose(
        program.plan().robots["iiwa"].world_t_tcp[-1], goal @ virtualrobot.pose(z=-0.12), atol=1e-5
    )
    assert ended(client, program.start(wait=False, on_disconnect="continue")).phase is Phase.SUCCEEDED
    np.testing.assert_allclose(arm.tcp, goal @ virtualrobot.pose(z=-0.12), atol=1e-5)


def test_the_robots_of_orders_are_held_by_leases_and_stopped(client: Client, arm: Robot) -> None:
    motion = client.program().dwell(5.0).pick(arm).start(wait=False, on_disconnect="continue")
    client.clock.step(5)
    assert motion.robots == ("iiwa",)
    client.stop("iiwa")
    client.clock.step(1)
    assert motion.phase is Phase.CANCELLED


@pytest.mark.parametrize(
    ("wrong", "words"),
    [
        ("loop", r"'a' calls 'b' calls 'a'"),
        ("huge", r"stand for 1000000000"),
        ("power", r"at most 10000 steps"),
        ("empty", r"steps is empty"),
        ("program", r"no program named 'nobody'"),
        ("rows", r"steps\[0\].pattern.pattern.rows must be at least 1"),
        ("nan", r"column_pitch_meters must be a finite number"),
        ("turn", r"layer_turn_radians is too large; 90 rad is 14.3 turns: degrees"),
        ("pitch", r"row_pitch_meters is too large; 120 m: millimetres"),
        ("open", r"step 1: the tool 'cup' has no widths"),
        ("speed", r"set_speed.factor must be above 0 and at most 1, not 0"),
        ("robot", r"step 0: .*robot named 'nobody'"),
        ("place", r"step 1: the tool 'cup' holds no part"),
        ("parent", r"step 1: .*node named 'nobody'"),
        ("width", r"steps\[0\].pick_at has state and width_meters; give one of them"),
        ("approach", r"steps\[0\].pick_at.approach_meters must be 0 or above"),
        ("deep", r"in more than 30 other steps"),
    ],
)
def test_what_makes_no_sense_is_refused_at_once(client: Client, arm: Robot, wrong: str, words: str) -> None:
    def new() -> virtualrobot.Program:
        return client.program()

    one, deep = new().dwell(0.1), new().dwell(0.1)
    for _ in range(32):
        deep = new().repeat(1, deep)
    doubled = new().dwell(0.1)
    for number in range(20):
        doubled = new().call(doubled, f"p{number}").call(doubled, f"p{number}")
    loop = new().call(one, "a").call(one, "b")
    for name, other in (("a", "b"), ("b", "a")):
        loop._spec.programs[name].steps[0].call.program = other
    nobody = new().call(one, "somebody")
    nobody._spec.steps[0].call.program = "nobody"
    goal = virtualrobot.pose(0.5, 0.0, 0.3) @ DOWN
    programs = {
        "loop": loop,
        "huge": new().repeat(10**9, one),
        "power": doubled,
        "empty": new().repeat(10**9, new()),
        "program": nobody,
        "rows": new().pattern("place", virtualrobot.Pattern(2, 0), one),
        "nan": new().pattern("place", virtualrobot.Pattern(2, 2, column_pitch=float("nan")), one),
        "turn": new().pattern("place", virtualrobot.Pattern(2, 2, 2, layer_turn=90.0), one),
        "pitch": new().pattern("place", virtualrobot.Pattern(2, 2, row_pitch=120.0), one),
        "open": new().dwell(0.1).tool_width(arm, 5.0),
        "speed": new().speed(0.0),
        "robot": new().pick("nobody"),
        "place": new().move(arm.ptp({"lbr_iiwa_joint_1": 0.1})).place(arm),
        "parent": new().dwell(0.1).place(arm, parent="nobody"),
        "width": new().pick_at(arm, goal, state="on", width=0.05),
        "approach": new().pick_at(arm, goal, approach=-1.0),
        "deep": deep,
    }
    with pytest.raises(virtualrobot.VirtualRobotError, match=words):
        programs[wrong].start(wait=False)
    assert not client.motions()


def test_a_file_says_what_python_says(client: Client, arm: Robot, tmp_path: Path) -> None:
    (file := tmp_path / "program.yaml").write_text(FILE)
    one = client.program().pick(arm, "part").place(arm, parent="pallet")
    program = client.program().repeat(2, client.program().call(one, "one"))
    turn = client.program().move(arm.ptp(virtualrobot.pose(z=0.2) @ DOWN, reference="place"))
    program.pattern("place", virtualrobot.Pattern(1, 2, row_pitch=0.1), turn, reference="pallet").speed(0.5)
    box(client, "part", *arm.tcp[:3, 3])
    plans = [each.plan() for each in (client.read_program(file), program)]
    np.testing.assert_allclose(plans[0].robots["iiwa"].positions, plans[1].robots["iiwa"].positions, atol=1e-9)
    flat, paths = program.flat()
    assert paths == ("0[0].0.0", "0[0].0.1", "0[1].0.0", "0[1].0.1", "1[0].0", "1[1].0", "2")
    same = client.program(flat.text).plan()
    np.testing.assert_array_equal(same.robots["iiwa"].positions, plans[1].robots["iiwa"].positions)
    with pytest.raises(virtualrobot.MalformedFileError, match="program:1: the program: there is no field 'step'"):
        client.program('{"schema_version": 1, "step": []}')
    decides = client.program().dwell(0.1).while_(client.program().repeat(2, client.program().if_("part", then=program)))
    client.signals.create("part")
    flat, paths = decides.flat()
    inner = [f"{path}{step}" for path in ("1[0].0[0].0.then.", "1[0].0[1].0.then.") for step in program.flat()[1]]
    assert paths == ("0", "1", "1[0].0[0].0", *inner[:7], "1[0].0[1].0", *inner[7:])
    (loop,) = [step["while_signal"] for step in json.loads(flat.text)["steps"] if "while_signal" in step]
    assert [len(step["if_signal"]["then"]) for step in loop["steps"]] == [7, 7]
    assert flat.flat()[0].text == flat.text
    motion = client.read_program(file).start(wait=False, on_disconnect="continue")
    assert (motion.step_count, ended(client, motion).step_path) == (7, "2")
    assert client.scene.node("part").parent == "pallet"


def test_a_guarded_arm_carries_what_stood_on_the_table_and_nothing_is_put_into_it(client: Client, arm: Robot) -> None:
    """Touches from before a pick may come apart; a step that would make one is refused, changing nothing."""
    point = arm.tcp[:3, 3]
    client.scene.add_object(
        "board", [virtualrobot.box(0.2, 0.2, 0.02)], pose=virtualrobot.pose(*(point - [0.0, 0.0, 0.05]))
    )
    box(client, "part", *(point - [0.0, 0.0, 0.02]))
    client.scene.add_object("lump", [virtualrobot.box(0.1, 0.1, 0.1)], pose=virtualrobot.pose(5.0))
    client.collisions.set(robots={"iiwa": "guard"})
    up = virtualrobot.pose(z=0.1) @ arm.tcp
    program = (
        client.program().pick(arm, "part").move(arm.linear(up)).attach("lump", "cup", pose=virtualrobot.pose(z=-0.1))
    )
    state = ended(client, program.start(wait=False, on_disconnect="continue")).state
    assert (state.end_cause, state.step) == ("step_refused", 2)
    assert "would touch" in state.end_reason
    np.testing.assert_allclose(arm.tcp, up, atol=1e-6)
    assert client.scene.node("lump").parent == "world"

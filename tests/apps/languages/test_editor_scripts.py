"""Debug adapter of URScript: scripts on the emulated controller, by a client that compares messages with the schema."""

from __future__ import annotations

import ast
import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import virtualrobot

from tests.apps.languages.debugging import Editor, Failed
from tests.waiting import until

pytestmark = pytest.mark.long

SCRIPT = """\
def count():
  global total = 0
  places = [[1, 2], [3, 4]]
  tool = p[0, 0, 0.1, 0, 0, 0]
  kept = struct(name="a", size=2)

  def squared(x, more=1):
    local y = x * x + more - 1
    sync()
    return y
  end

  thread beside():
    while True:
      sync()
      ticks = get_steptime()
    end
  end

  i = 0
  while i < 3:
    i = i + 1
    total = total + squared(i)
  end
  textmsg("total ", total)
  handle = run beside()
  movej([0.1, -1.4, 1.6, -1.8, -1.5, 0], a=10, v=3)
  kill handle
  set_standard_digital_out(2, True)
  textmsg("there ", get_standard_digital_out(2))
end
"""


def line(piece: str) -> int:
    """Return the line of the one place where a piece of the script stands."""
    assert SCRIPT.count(piece) == 1
    return SCRIPT[: SCRIPT.index(piece)].count("\n") + 1


@pytest.fixture
def file(tmp_path: Path) -> Path:
    """Return the file of the script."""
    found = tmp_path / "count.script"
    found.write_text(SCRIPT)
    return found


def test_a_script_is_stepped_through_to_its_end(editor: Editor, file: Path) -> None:
    """Waits and moves are steps as others are; a thread that runs beside is stepped into alone."""
    loop, body, call, first = line("while i < 3"), line("i = i + 1"), line("total = total"), line("local y")
    editor.launch(file, loop, stopOnEntry=True)
    assert editor.stops("entry") == [("count", 2)]
    editor.ask("continue", threadId=1)
    assert editor.stops("breakpoint") == [("count", loop)]
    editor.breakpoints(file)
    assert editor.step("next") == [("count", body)]
    assert editor.step("next") == [("count", call)]
    assert editor.step("stepIn") == [("squared", first), ("count", call)]
    assert editor.step("next") == [("squared", line("sync()\n    return")), ("count", call)]
    assert editor.step("stepOut") == [("count", loop)]
    editor.breakpoints(file, {"line": line("movej")}, {"line": line("handle =")})
    editor.ask("continue", threadId=1)
    assert editor.stops("breakpoint") == [("count", line("handle ="))]
    assert editor.lines == ["total 14"]
    editor.breakpoints(file)
    assert editor.step("next") == [("count", line("movej"))]
    assert [one["name"] for one in editor.ask("threads")["threads"]] == ["count"]
    assert editor.step("next") == [("count", line("kill handle"))]
    editor.ask("continue", threadId=1)
    assert editor.ends() == ["total 14", "there True"]


def test_breakpoints_stop_each_round_and_by_their_conditions(editor: Editor, file: Path) -> None:
    (moved,) = editor.launch(file, line("def squared"))
    assert (moved["verified"], moved["line"]) == (True, line("local y"))
    for number in ("1", "2"):
        assert editor.stops("breakpoint")[0] == ("squared", line("local y"))
        assert (editor.value("x"), editor.value("total + i", 1)) == (number, str(int(number) + int(number == "2")))
        editor.ask("continue", threadId=1)
    editor.stops("breakpoint")
    found = editor.breakpoints(
        file,
        {"line": line("return y"), "condition": "y == 9 and norm([3, 4]) == 5"},
        {"line": line("sync()\n    return"), "condition": "z > 1"},
        {"line": line("i = i + 1"), "condition": "i +"},
        {"line": line("total = total"), "condition": "squared(2) > 1"},
        {"line": 999},
    )
    assert [one["verified"] for one in found] == [True, False, False, False, False]
    assert [one.get("message", "").partition(": ")[2] for one in found[1:4]] == [
        "there is no variable 'z' here",
        "a value is expected here, not the end of the line",
        "functions and threads of the script are not begun where it stands",
    ]
    editor.ask("continue", threadId=1)
    assert editor.stops("breakpoint") == [("squared", line("return y")), ("count", line("total = total"))]
    editor.ask("disconnect")


def test_variables_are_shown_and_edited(editor: Editor, file: Path) -> None:
    editor.launch(file, line("return y"))
    editor.stops("breakpoint")
    scopes = editor.scopes()
    assert list(scopes) == ["Function", "Script"] and list(editor.scopes(1)) == ["Script"]
    assert editor.variables(scopes["Function"]) == {"x": "1", "more": "1", "y": "1"}
    script = editor.ask("variables", variablesReference=scopes["Script"])["variables"]
    assert [(one["name"], one["value"], one["type"]) for one in script] == [
        ("total", "0", "a number"),
        ("places", "[[1, 2], [3, 4]]", "a list"),
        ("tool", "p[0, 0, 0.1, 0, 0, 0]", "a pose"),
        ("kept", "struct(name=a, size=2)", "a struct"),
        ("i", "1", "a number"),
    ]
    places, kept = (editor.ask("variables", variablesReference=script[one]["variablesReference"]) for one in (1, 3))
    assert [one["name"] for one in places["variables"]] == ["[0]", "[1]"]
    assert [one["value"] for one in kept["variables"]] == ['"a"', "2"]

    def change(number: int, name: str, value: str) -> str:
        return editor.ask("setVariable", variablesReference=number, name=name, value=value)["value"]

    assert change(places["variables"][1]["variablesReference"], "[0]", "x + 40") == "41"
    assert editor.value("places[1, 0]") == "41"
    assert change(scopes["Function"], "y", "10 * y") == "10"
    assert change(scopes["Script"], "i", "3") == "3"
    for number, name, value, told in [
        (scopes["Function"], "y", "True", "the value must be a number, as it is, not a truth"),
        (scopes["Function"], "y", "1 / 0", "division by zero"),
        (scopes["Function"], "none", "1", "there is no variable 'none' here"),
        (scopes["Script"], "tool", "pose_trans(tool)", "'pose_trans' takes p_from, p_from_to"),
        (scopes["Script"], "i", "sleep(1)", "'sleep' takes time"),
        (scopes["Script"], "i", "slep(1)", "there is no function 'slep'"),
        (scopes["Script"], "i", "1 1", "the end of the expression is expected here"),
        (scopes["Script"], "i", "(" * 99, "this is nested deeper than 90 levels"),
    ]:
        with pytest.raises(Failed, match=re.escape(told)):
            change(number, name, value)
    editor.breakpoints(file)
    editor.ask("continue", threadId=1)
    assert editor.ends()[0] == "total 10"


def test_an_error_is_looked_at_where_it_was(editor: Editor, file: Path) -> None:
    file.write_text(SCRIPT.replace("x * x + more", "x * x / (x - 2)"))
    editor.ask("initialize", adapterID="urscript")
    editor.ask("launch", program=str(file))
    editor.event("initialized")
    editor.ask("setExceptionBreakpoints", filters=["uncaught"])
    editor.ask("configurationDone")
    found = editor.event("stopped")
    assert found["reason"] == "exception" and "division by zero" in found["text"]
    assert editor.stack() == [("squared", line("local y")), ("count", line("total = total"))]
    assert editor.value("x") == "2"
    editor.ask("continue", threadId=1)
    assert f"count.script:{line('local y')}" in editor.ends(1)[-1]


def test_a_pause_stops_a_loop_and_the_end_of_the_session_ends_it(editor: Editor, file: Path) -> None:
    file.write_text("def forever():\n  while True:\n    sync()\n  end\nend\n")
    editor.launch(file)
    editor.ask("pause", threadId=1)
    assert editor.stops("pause")[0][0] == "forever"
    editor.ask("continue", threadId=1)
    editor.ask("terminate")
    assert editor.ends(130) == []


MOVES = """\
def moves():
  thread beside():
    while True:
      sync()
    end
  end
  handle = run beside()
  movej([1.2, -1.4, 1.4, -1.5, -1.4, 0.1], a=3, v=0.5)
  textmsg(get_actual_tcp_pose())
end
"""


def test_a_script_moves_a_robot_of_a_kernel_which_rests_while_it_stands(
    editor: Editor, client: virtualrobot.Client, file: Path
) -> None:
    """The controller has the lengths that the robot has: what it tells of the tool is where the kernel has it."""
    arm = client.load_robot("model://ur10e", name="arm")
    arm.set_positions([0.0, -1.4, 1.4, -1.5, -1.4, 0.1])
    file.write_text(MOVES)
    editor.launch(file, robot="arm", address=client.address)
    until(lambda: arm.positions[0] > 0.05)
    editor.breakpoints(file, {"line": 4})
    assert editor.stops("breakpoint") == [("beside", 4)]
    until(lambda: not arm.state.motion_ids)
    assert 0.0 < arm.positions[0] < 1.19
    editor.breakpoints(file)
    editor.ask("continue", threadId=1)
    (pose,) = editor.ends()
    np.testing.assert_allclose(arm.positions[0], 1.2, atol=1e-3)
    np.testing.assert_allclose(ast.literal_eval(pose.removeprefix("p"))[:3], arm.tcp[:3, 3], atol=3e-3)


@pytest.mark.parametrize(
    ("launched", "told"),
    [
        ({"routine": "count"}, "'routine' is for programs in RAPID"),
        ({"model": "ur7"}, "'model' is one of ur3, "),
        ({"model": 5}, "'model' of a launch is a str, not 5"),
        ({"text": "sec a():\n  x = 1\nend\n"}, "'a' is a secondary program (sec)"),
        ({"text": "def a():\n  slep(1)\nend\n"}, "count.script:2:3: "),
        ({"program": "none.script"}, "none.script can't be read"),
    ],
)
def test_a_launch_that_is_wrong_is_refused(editor: Editor, file: Path, launched: dict[str, Any], told: str) -> None:
    given = {"program": str(file), **launched}
    if "text" in given:
        file.write_text(given.pop("text"))
    editor.ask("initialize", adapterID="urscript")
    with pytest.raises(Failed, match=re.escape(told)):
        editor.ask("launch", **given)

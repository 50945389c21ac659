"""Debug adapter of RAPID: programs debugged over TCP by a client that compares messages with the protocol's schema."""

from __future__ import annotations

import json
import math
import re
import subprocess
from contextlib import suppress
from pathlib import Path
from typing import Any

import pytest
import virtualrobot
from jsonschema import ValidationError
from virtualrobot_apps.languages.core.source import Source
from virtualrobot_apps.languages.rapid.task import RapidTask, load

from tests.apps.languages.debugging import COMMAND, Editor, Failed, schema
from tests.waiting import PATIENCE_SECONDS, repeated, until

pytestmark = pytest.mark.long

SUMS = r"""MODULE Sums
  VAR num total := 0;
  RECORD box
    pos size;
    bool full;
  ENDRECORD
  VAR box boxes{2};
  CONST num most := 9;
  FUNC num squared(num x)
    VAR num y;
    y := x * x;
    RETURN y;
  ENDFUNC
  PROC add(INOUT num sum, num x \string why)
    sum := sum + squared(x);
  ENDPROC
  PROC main()
    FOR i FROM 1 TO 3 DO
      add total, i;
    ENDFOR
    TPWrite "total" \Num:=total;
    divide;
    TPWrite "end" \Num:=total;
  ENDPROC
  PROC divide()
    VAR num zero;
    total := total / zero;
  ERROR
    total := -1;
    TRYNEXT;
  ENDPROC
  PROC forever()
    VAR num rounds;
    WHILE TRUE DO
      rounds := rounds + 1;
    ENDWHILE
  UNDO
    TPWrite "undone";
  ENDPROC
  FUNC num leaves()
    EXIT;
  ENDFUNC
  FUNC num deep(num x)
    RETURN deep(x + 1);
  ENDFUNC
  FUNC num endless()
    WHILE TRUE DO
    ENDWHILE
  ENDFUNC
ENDMODULE
"""


def line(piece: str) -> int:
    """Return the line of the one place where a piece of the program stands."""
    assert SUMS.count(piece) == 1
    return SUMS[: SUMS.index(piece)].count("\n") + 1


@pytest.fixture
def file(tmp_path: Path) -> Path:
    """Return the file of the program."""
    found = tmp_path / "sums.mod"
    found.write_text(SUMS)
    return found


def test_the_schema_refuses_what_is_no_message() -> None:
    event = {"seq": 1, "type": "event", "event": "stopped", "body": {"reason": "step"}}
    schema("StoppedEvent").validate(event)
    with pytest.raises(ValidationError):
        schema("StoppedEvent").validate({**event, "body": {"threadId": 1}})


def test_a_program_runs_to_its_end(editor: Editor, file: Path) -> None:
    editor.launch(file)
    assert editor.ends() == ["total14", "end-1"]


def test_steps_go_in_over_and_out(editor: Editor, file: Path) -> None:
    editor.launch(file, stopOnEntry=True)
    loop, call, body, inner = line("FOR i"), line("add total"), line("sum := "), line("y := x")
    assert editor.stops("entry") == [("main", loop)]
    assert editor.step("next") == [("main", call)]
    assert editor.step("stepIn") == [("add", body), ("main", call)]
    assert editor.step("stepIn") == [("squared", inner), ("add", body), ("main", call)]
    assert editor.step("stepOut") == [("main", loop)]
    assert editor.step("next") == [("main", call)]
    assert editor.step("next") == [("main", loop)]
    editor.ask("continue", threadId=1)
    assert editor.ends() == ["total14", "end-1"]


def test_a_step_enters_the_error_handler_of_its_routine(editor: Editor, file: Path) -> None:
    editor.launch(file, line("total := total /"))
    assert editor.stops("breakpoint") == [("divide", line("total := total /")), ("main", line("    divide;"))]
    assert editor.step("next")[:2] == [("divide ERROR", line("total := -1")), ("divide", line("total := total /"))]
    assert editor.variables(editor.scopes()["Routine"]) == {"zero": "0"}
    assert editor.step("next")[0] == ("divide ERROR", line("TRYNEXT"))
    assert editor.step("stepOut") == [("main", line('"end"'))]
    editor.ask("continue", threadId=1)
    editor.ends()


def test_breakpoints_stop_each_time_and_go_to_the_next_statement(editor: Editor, file: Path) -> None:
    (moved,) = editor.launch(file, line("VAR num y"))
    assert (moved["verified"], moved["line"]) == (True, line("y := x"))
    for _ in range(3):
        assert editor.stops("breakpoint")[0] == ("squared", line("y := x"))
        editor.ask("continue", threadId=1)
    assert editor.ends() == ["total14", "end-1"]


def test_a_condition_decides_whether_a_breakpoint_stops(editor: Editor, file: Path) -> None:
    editor.launch(file, stopOnEntry=True)
    editor.stops("entry")
    found = editor.breakpoints(
        file,
        {"line": line("add total"), "condition": "i = 2 AND squared(i) > 3"},
        {"line": line("sum := "), "condition": "sum + "},
        {"line": line("y := x"), "condition": "nothing > 1"},
        {"line": line("RETURN y"), "condition": "x"},
        {"line": 999},
    )
    assert [one.get("message", "") for one in found] == [
        "",
        "the condition can't be used: a value is expected here, not the end of the file",
        "the condition can't be used: 'nothing' is not declared",
        "the condition can't be used: the value must be a bool, not a num",
        "there is no statement in this line or after it",
    ]
    assert [one["verified"] for one in found] == [True, False, False, False, False]
    editor.ask("continue", threadId=1)
    assert editor.stops("breakpoint") == [("main", line("add total"))]
    assert (editor.value("i"), editor.value("total")) == ("2", "1")
    editor.breakpoints(file, {"line": line("divide;"), "condition": "1 / (total - total) > 1"})
    editor.ask("continue", threadId=1)
    found = editor.event("stopped")
    assert found["text"] == "the condition can't be computed: ERR_DIVZERO: a division by zero"
    editor.ask("continue", threadId=1)
    editor.ends()


def test_variables_are_shown_and_edited(editor: Editor, file: Path) -> None:
    editor.launch(file, line("RETURN y"))
    editor.stops("breakpoint")
    scopes = editor.scopes()
    assert list(scopes) == ["Routine", "Module Sums"]
    assert editor.variables(scopes["Routine"]) == {"x": "1", "y": "1"}
    assert editor.variables(editor.scopes(1)["Routine"]) == {"sum": "0", "x": "1"}
    assert editor.variables(editor.scopes(2)["Routine"]) == {"i": "1"}
    module = editor.ask("variables", variablesReference=scopes["Module Sums"])["variables"]
    assert [(one["name"], one["value"], one["type"]) for one in module] == [
        ("total", "0", "num"),
        ("boxes", "[[[0,0,0],FALSE],[[0,0,0],FALSE]]", "box{*}"),
        ("most", "9", "num"),
    ]
    boxes = editor.ask("variables", variablesReference=module[1]["variablesReference"])["variables"]
    assert [one["name"] for one in boxes] == ["{1}", "{2}"]
    second = boxes[1]["variablesReference"]
    assert editor.variables(second) == {"size": "[0,0,0]", "full": "FALSE"}

    def change(number: int, name: str, value: str) -> str:
        return editor.ask("setVariable", variablesReference=number, name=name, value=value)["value"]

    assert change(second, "size", "[1, 2, squared(3)]") == "[1,2,9]"
    assert change(second, "full", "total = 0") == "TRUE"
    assert editor.value("boxes{2}") == "[[1,2,9],TRUE]"
    assert change(scopes["Routine"], "y", "x + 10") == "11"
    assert change(editor.scopes(1)["Routine"], "sum", "100") == "100"
    for number, name, value, told in [
        (second, "full", "1", "the value must be a bool, not a num"),
        (scopes["Routine"], "y", "1/0", "ERR_DIVZERO: a division by zero"),
        (scopes["Routine"], "none", "1", "there is no variable 'none' here"),
        (scopes["Module Sums"], "most", "1", "'most' can't be changed"),
        (editor.scopes(2)["Routine"], "i", "1", "'i' can't be changed"),
        (9999, "i", "1", "the program has gone on; ask for its variables again"),
    ]:
        with pytest.raises(Failed, match=re.escape(told)):
            change(number, name, value)
    editor.breakpoints(file)
    editor.ask("continue", threadId=1)
    # The sum was read before it was set to 100, as RAPID computes from left to right.
    assert editor.ends() == [f"total{0 + 11 + 4 + 9}", "end-1"]


def test_expressions_are_those_of_rapid(editor: Editor, file: Path) -> None:
    editor.launch(file, line("RETURN y"))
    editor.stops("breakpoint")
    for expression, value in [
        ("x + squared(3) DIV 2", "5"),
        ("boxes{2}.size", "[0,0,0]"),
        ("Abs(-2.5)", "2.5"),
        ('"a" + "b"', '"ab"'),
        ("NOT boxes{1}.full", "TRUE"),
    ]:
        assert editor.value(expression) == value
    assert editor.value("Present(why)", 1) == "FALSE"
    for expression, told in [
        ("x +", "a value is expected here"),
        ("x x", "the end of the expression is expected here, not 'x'"),
        ("boxes{3}", "the index 3 is outside 1 to 2"),
        ("[1,2]", "what these values are of is not clear here"),
        ("leaves()", "this would end the program"),
        ("deep(1)", "maximum recursion depth"),
        ("endless()", "this takes longer than 1 s"),
        ("(" * 5000, "nested deeper than"),
    ]:
        with pytest.raises(Failed, match=re.escape(told)):
            editor.value(expression)
    assert editor.value("x") == "1"


def test_a_pause_stops_a_loop_and_the_end_of_the_session_ends_it(editor: Editor, file: Path) -> None:
    editor.launch(file, routine="forever")
    with pytest.raises(Failed, match="the program runs"):
        editor.stack()
    editor.ask("pause", threadId=1)
    assert editor.stops("pause")[0][0] == "forever"
    editor.ask("continue", threadId=1)
    editor.ask("pause", threadId=1)
    editor.stops("pause")
    editor.ask("terminate")
    assert editor.ends(130) == ["undone"]


def test_what_the_pendant_asks_is_answered_in_the_console(editor: Editor, file: Path) -> None:
    asks = (
        'MODULE a\nPROC main()\nVAR num n;\nTPReadNum n, "How many?";\nTPReadNum n, "Really?";\nTPWrite "n" \\Num:=n;\n'
    )
    file.write_text(f"{asks}ENDPROC\nENDMODULE\n")
    editor.launch(file, answers=["3"])
    until(lambda: "Really?" in editor.lines)

    def answered() -> bool:
        with suppress(Failed):  # it has shown its question, and doesn't wait yet
            return editor.ask("evaluate", expression="5", context="repl") == {"result": "", "variablesReference": 0}
        return False

    until(answered)
    assert editor.ends()[-1] == "n5"


def test_an_error_ends_the_program_with_its_place(editor: Editor, file: Path) -> None:
    file.write_text(SUMS.replace("TRYNEXT;", "total := 1 / zero;"))
    editor.launch(file)
    written = editor.ends(1)
    assert written[0] == "total14"
    assert "in an error handler, whose own errors nothing handles" in written[1]
    assert f"sums.mod:{line('total := total /')}: ERR_DIVZERO" in written[1]


def test_an_error_that_nothing_handles_is_looked_at_where_it_was(editor: Editor, file: Path) -> None:
    file.write_text(SUMS.replace("y := x * x", "y := 1 / (x - 2)"))
    editor.ask("initialize", adapterID="rapid")
    editor.ask("launch", program=str(file))
    editor.event("initialized")
    editor.ask("setExceptionBreakpoints", filters=["uncaught"])
    editor.ask("configurationDone")
    found = editor.event("stopped")
    assert (found["reason"], found["text"]) == ("exception", "ERR_DIVZERO: a division by zero")
    assert editor.stack() == [("squared", line("y := x")), ("add", line("sum := ")), ("main", line("add total"))]
    assert editor.variables(editor.scopes()["Routine"]) == {"x": "2", "y": "0"}
    assert editor.value("i * 10", 2) == "20"
    editor.ask("next", threadId=1)
    assert "ERR_DIVZERO" in editor.ends(1)[-1]


def test_an_endless_recursion_has_a_stack_of_a_thousand(editor: Editor, file: Path) -> None:
    file.write_text(SUMS.replace("y := x * x", "y := squared(x)"))
    editor.ask("initialize", adapterID="rapid")
    editor.ask("launch", program=str(file))
    editor.event("initialized")
    editor.ask("setExceptionBreakpoints", filters=["uncaught"])
    editor.ask("configurationDone")
    assert editor.event("stopped")["reason"] == "exception"
    found = editor.ask("stackTrace", threadId=1, startFrame=5, levels=2)
    assert len(found["stackFrames"]) == 2 and 100 < found["totalFrames"] <= 1000
    editor.ask("continue", threadId=1)
    assert "ERR_STACK" in editor.ends(1)[-1]


def test_tasks_are_threads_that_stop_by_themselves(editor: Editor, file: Path, tmp_path: Path) -> None:
    first, second = tmp_path / "first.mod", tmp_path / "second.mod"
    first.write_text(
        'MODULE A\nPERS bool go := FALSE;\nPROC main()\nWaitUntil go;\nTPWrite "went";\nENDPROC\nENDMODULE\n'
    )
    second.write_text('MODULE B\nPERS bool go;\nPROC main()\ngo := TRUE;\nTPWrite "said";\nENDPROC\nENDMODULE\n')
    editor.ask("initialize", adapterID="rapid")
    editor.ask("launch", program=str(first), tasks=[{"name": "T_OTHER", "program": str(second)}])
    editor.event("initialized")
    editor.breakpoints(second, {"line": 4})
    editor.ask("configurationDone")
    found = editor.event("stopped")
    assert (found["threadId"], found["allThreadsStopped"]) == (2, False)
    assert [one["name"] for one in editor.ask("threads")["threads"]] == ["T_ROB1", "T_OTHER"]
    assert editor.lines == []
    editor.ask("continue", threadId=2)
    assert sorted(editor.ends()) == ["T_OTHER: said", "T_ROB1: went"]


MOVES = r"""MODULE Moves
  VAR num count;
  CONST jointtarget low := [[0,0,0,0,30,0],[9E9,9E9,9E9,9E9,9E9,9E9]];
  CONST jointtarget high := [[40,0,0,0,30,0],[9E9,9E9,9E9,9E9,9E9,9E9]];
  PROC main()
    MoveAbsJ low, v100, z50, tool0;
    MoveAbsJ high, v100, z50, tool0;
    count := count + 1;
    MoveAbsJ low, v1000, fine, tool0;
    SetDO doDone, 1;
  ENDPROC
ENDMODULE
"""


def test_the_motion_pointer_is_where_the_robot_is(editor: Editor, steps: virtualrobot.Client, tmp_path: Path) -> None:
    """In a world whose time stands still the program is two moves ahead of the robot; then the robot does one."""
    arm = steps.load_robot("model://irb120", name="arm")
    file = tmp_path / "moves.mod"
    file.write_text(MOVES)
    with pytest.raises(Failed, match="doDone"):
        editor.ask("launch", program=str(file), robot="arm", address=steps.address)
    editor.launch(file, 8, robot="arm", address=steps.address, createSignals=True)
    assert editor.stops("breakpoint") == [("main", 8), ("motion pointer", 6)]
    pointer = editor.ask("stackTrace", threadId=1)["stackFrames"][1]
    assert (pointer["presentationHint"], pointer["source"]["name"]) == ("subtle", "moves.mod")
    assert editor.ask("scopes", frameId=pointer["id"]) == {"scopes": []}
    with pytest.raises(Failed, match="not where the robot is"):
        editor.ask("evaluate", expression="count", frameId=pointer["id"])

    def second() -> bool:
        steps.clock.step(50)
        return editor.stack() == [("main", 8), ("motion pointer", 7)]

    until(second)

    # The robot ends the moves that it has, and the program still stands.
    def ended() -> bool:
        steps.clock.step(200)
        return editor.stack() == [("main", 8)]

    until(ended)
    assert arm.state.positions[0] == pytest.approx(math.radians(40.0), abs=1e-6)
    editor.ask("continue", threadId=1)
    with repeated(lambda: steps.clock.step(50)):
        assert editor.ends() == []
    assert arm.state.positions[0] == pytest.approx(0.0, abs=1e-6)
    assert steps.signals["doDone"] is True


def test_a_robot_that_is_not_there_is_refused(editor: Editor, steps: virtualrobot.Client, file: Path) -> None:
    editor.ask("initialize", adapterID="rapid")
    with pytest.raises(Failed, match="there is no robot named 'arn'"):
        editor.ask("launch", program=str(file), robot="arn", address=steps.address)
    with pytest.raises(Failed, match="no kernel answers at"):
        editor.ask("launch", program=str(file), robot="arm", address="127.0.0.1:1")


@pytest.mark.parametrize(
    ("launched", "told"),
    [
        ({}, "'program' is the file of program, or a list of its files, not None"),
        ({"program": 3}, "'program' of a launch is a str or list, not 3"),
        ({"program": "none.mod"}, "none.mod can't be read"),
        ({"program": "{file}", "tasks": [{"name": "t_rob1", "program": "{file}"}]}, "each task has a name of its own"),
        ({"program": "{file}", "tasks": [3]}, "each of 'tasks' has a 'name'"),
        ({"program": "{wrong}"}, "wrong.mod:3:1: there is no procedure 'nothing'"),
    ],
)
def test_a_launch_that_is_wrong_is_refused(
    editor: Editor, file: Path, tmp_path: Path, launched: dict[str, Any], told: str
) -> None:
    wrong = tmp_path / "wrong.mod"
    wrong.write_text("MODULE a\nPROC main()\nnothing;\nENDPROC\nENDMODULE\n")
    text = json.dumps(launched).replace("{file}", str(file)).replace("{wrong}", str(wrong))
    editor.ask("initialize", adapterID="rapid")
    with pytest.raises(Failed, match=re.escape(told)):
        editor.ask("launch", **json.loads(text))


def test_requests_at_the_wrong_time_are_refused(editor: Editor, file: Path) -> None:
    for command, arguments, told in [
        ("configurationDone", {}, "no program is launched"),
        ("threads", {}, "no program is launched"),
        ("attach", {}, "there is no request 'attach'"),
        ("initialize", {"adapterID": "rapid", "linesStartAt1": False}, "'linesStartAt1' is true here"),
        ("setBreakpoints", {}, "KeyError: 'source'"),
    ]:
        with pytest.raises(Failed, match=told):
            editor.ask(command, **arguments)
    editor.send(b"{no json")
    editor.send(b"[]")
    editor.launch(file, line("RETURN y"))
    editor.stops("breakpoint")
    for command, arguments, told in [
        ("launch", {"program": str(file)}, "a program is launched already"),
        ("configurationDone", {}, "the program runs already"),
        ("next", {"threadId": 7}, "threads are 1 to 1, not 7"),
        ("next", {}, "KeyError: 'threadId'"),
        ("evaluate", {"expression": "x"}, "choose an entry of its call stack"),
        ("scopes", {"frameId": 99}, "the program has gone on"),
    ]:
        with pytest.raises(Failed, match=told):
            editor.ask(command, **arguments)
    editor.ask("disconnect")


def test_an_adapter_on_the_standard_streams_keeps_them_clean(file: Path) -> None:
    process = subprocess.Popen(COMMAND, stdin=subprocess.PIPE, stdout=subprocess.PIPE)
    try:
        editor = Editor(process.stdout, process.stdin)
        editor.launch(file)
        assert editor.ends() == ["total14", "end-1"]
        editor.ask("disconnect")
        assert process.wait(PATIENCE_SECONDS) == 0
    finally:
        process.kill()
        process.wait()
        for stream in (process.stdin, process.stdout):
            assert stream is not None
            with suppress(OSError):
                stream.close()


def test_a_program_that_is_not_debugged_has_nothing_of_a_debugger() -> None:
    """The code of a program is that of before, and `flags` is the task's own list, empty while nobody asks."""
    task = RapidTask(load([Source(SUMS, "sums.mod")]), write=lambda line: None)
    assert task._names["flags"] is task.flags and task.flags == []
    assert task._names["poll"] == task.poll

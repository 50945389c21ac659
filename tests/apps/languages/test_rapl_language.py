"""RAPL-II without a robot: lines, arithmetic, flow, strings, refusals; where each command of the manual stands.

The commands are those of the published table that docs/rapl.md tells; what the page says is assumed is tested as that.
"""

from __future__ import annotations

from pathlib import Path

import pytest
from click.testing import CliRunner
from virtualrobot.errors import WrongStateError
from virtualrobot_apps.languages.core.task import TaskStopped
from virtualrobot_apps.languages.rapl.command import rapl
from virtualrobot_apps.languages.rapl.faults import RaplStopped
from virtualrobot_apps.languages.rapl.locations import listed, pose_of, values_of
from virtualrobot_apps.languages.rapl.table import COMMANDS, REFUSED
from virtualrobot_apps.languages.rapl.task import RaplTask

from tests.apps.languages.rapl import faults, loaded, shown

PUBLISHED = """
; ! ++ -- ABORT ACTUAL ALIGN ALLOC AOUT APPRO ARM AXSTATUS CIRCLE CLOSE CONFIG CPATH CTPATH CUT DECODE DELAY DELETE
DEPART DEVICE DIR DISABLE DLOCN DVAR EDIT ELBOW ENABLE ENCODE EXECUTE FINISH FLASH FREE GAIN GOPATH GOSUB GOTO GRIP
HALT HELP HERE HIMEM HOME IF IFAUX IFPOWER IFSIG IFSTART IFSTRING IGNORE INPUT INVERT IORD IOWR JOG JOINT LIMP LISTL
LISTP LISTV LOCK MA MAGGRIP MANUAL MEMRD MEMWR MI MOTOR OPEN OUTPUT PASSWORD PASTE PAUSE POINT PRINT PRINTI PRINTV
PROCEED REACH READY REMOTE RENAME RETRY RETURN RTCLOCK RUN SERIAL SET SHIFT SHIFTA SPEED STATUS STOP STRPOS TEACH TIME
TOOL TRACE TRIGGER TYPE TYPEI TYPEV UNLOCK VIA W1 W2 W3 W4 W5 WAIT WE1 WE3 WE5 HLIM WRIST XCAL XHOME XREADY XZERO W0
""".split()
"""Commands of the published table (its WO is W0); MOVE, NOLIMP, NOHELP and ONSIG are named in others' texts there."""


def test_each_command_of_the_manual_works_or_is_refused_by_name() -> None:
    refused = [name for names in REFUSED.values() for name in names]
    assert len(refused) == len(set(refused))
    assert not COMMANDS.keys() & set(refused)
    assert {*COMMANDS, *refused} == {*PUBLISHED, "MOVE", "NOLIMP", "NOHELP", "ONSIG"}
    assert all(one.text.endswith(".") for one in COMMANDS.values())
    for reason, names in REFUSED.items():
        for name in names:
            assert faults(f"10 {name}") == [f"1:4: {name} can't be used here: {reason}"]


def test_variables_expressions_conditions_and_lines() -> None:
    assert shown(
        """
        10 ; a comment
        20 ! N = 1
        30 ! M = (N + 2) * SQRT(9) / 2 - -1
        40 TYPE 'M is ', M
        50 ++ N
        60 IF N <= 3 THEN 50
        70 TYPEI N
        80 -- N
        90 if n ne 3 then 110
        100 TYPEV N, M
        110 ! H = DEG(ATAN(1)) + INT(-2.7) + ABS(-1) + RAD(180) - 2 * ASIN(1)
        120 TYPEV H
        130 DVAR H
        140 LISTV
        150 PRINT 'x'
        160 PRINTI N
        170 PRINTV N
        """
    ) == ["M is 5.5", "4", "3.0000 5.5000", "44.0000", "M 5.5000", "N 3.0000", "x", "3", "3.0000"]


@pytest.mark.parametrize(
    ("relation", "expected"),
    [("==", "ab"), ("EQ", "ab"), ("<>", "cd"), ("NE", "cd"), ("<", "c"), ("GT", "d"), (">=", "abd"), ("LE", "abc")],
)
def test_the_six_relations(relation: str, expected: str) -> None:
    """By hand: of a: 2 and 2, b: -1 and -1, c: 1 and 2, d: 2 and 1."""
    pairs = {"a": (2, 2), "b": (-1, -1), "c": (1, 2), "d": (2, 1)}
    lines = [
        f"{10 * i + 1} IF {x} {relation} {y} THEN {10 * i + 3}\n{10 * i + 2} GOTO {10 * i + 4}\n"
        f"{10 * i + 3} TYPE '{name}'\n{10 * i + 4} ;"
        for i, (name, (x, y)) in enumerate(pairs.items(), 1)
    ]
    assert "".join(shown("\n".join(lines))) == expected


def test_strings() -> None:
    assert shown(
        """
        10 ! &1 = 'hello'
        20 PASTE ' world', &1, 6
        30 TYPE &1
        40 IFSTRING &1 == 'hello world' THEN 60
        50 STOP never
        60 STRPOS 'o w', &1, P
        70 CUT &1, 1, 6
        80 ! &2 = &1
        90 ! N = 12.5
        100 ENCODE N, &3
        110 ENCODE N, &4, I
        120 TYPE &3
        130 TYPE &4
        140 ! &5 = 'x= 42 end'
        150 DECODE &5, 3, N
        160 TYPEV N, P
        170 IFSTRING &2 EQ 'world' THEN 190
        180 STOP never
        190 STRPOS 'z', &2, P
        200 TYPEI P
        """
    ) == ["hello world", "12.5000", "12", "42.0000 5.0000", "0"]


def test_programs_call_each_other_with_parameters_and_skip_lines() -> None:
    assert shown(
        """
        10 ! N = 4
        20 GOSUB SUB 3, N, -1.5
        30 TYPE 'left out'
        40 TYPEV P
        50 GOSUB LAST
        60 TYPE 'back'
        70 STOP 'bye'
        80 TYPE 'never'
        """,
        sub="10 ! P = %0 * %1 + %2\n20 GOSUB INNER %1\n30 RETURN 1\n40 TYPE 'never'",
        inner="10 TYPE 'N is ', %0",
        last="10 TYPE 'last'",
    ) == ["N is 4", "10.5000", "last", "back", "bye"]


def test_questions_pauses_and_the_trace() -> None:
    asked: list[str] = []
    lines: list[str] = []

    def ask(question: str) -> str:
        asked.append(question)
        return "7"

    RaplTask(
        loaded("10 INPUT N\n20 TRACE\n30 PAUSE put a part in\n40 TYPEI N\n50 ABORT\n60 ;"), None, lines.append, ask
    ).run()
    assert asked == ["N?", "put a part in: Enter goes on"]
    assert lines == ["MAIN#00030 30 PAUSE put a part in", "MAIN#00040 40 TYPEI N", "7", "MAIN#00050 50 ABORT"]


@pytest.mark.parametrize(
    ("line", "expected"),
    [
        ("10 MOVE A,T", "1:11: S is expected here, not 'T'; it is MOVE location [S]"),
        ("10 MOV A", "1:4: there is no command 'MOV'; did you mean 'MOVE'?"),
        ("MOVE A", "1:1: a line begins with its number, as 10 MOVE A"),
        ("10 ;\n10 MOVE A", "2:1: the number 10 must be above that of the line before, 10"),
        ("40000 MOVE A", "1:1: a line has a number up to 32767"),
        ("10", "1:3: a command is expected after the number of the line"),
        ("10 MOVE D", "1:9: there is no location 'D'; no file of locations has it, and no HERE or SET"),
        ("10 IF N < 3 THEN 10", "1:7: nothing gives 'N' a value"),
        ("10 GOTO 45", "1:9: there is no line 45 in MAIN"),
        ("10 GOSUB MAN", "1:10: there is no program 'MAN'; did you mean 'MAIN'?; there are: MAIN"),
        ("10 ! X = (3 + 4", "1:16: ')' is missing here; it is ! assignment"),
        ("10 ! #X = 3", "1:6: a location gets its value by SET or HERE, not by !; it is ! assignment"),
        ("10 ! X = SINE(3)", "1:10: there is no function 'SINE'; did you mean 'SIN'?; there are ABS, ACOS,"),
        (f"10 ! X = {'(' * 10}1", "1:19: parentheses may be 9 deep, and not more"),
        ("10 TYPE hello", "1:9: a text in quotes, or a string, as &1 is expected here, not 'HELLO'"),
        ("10 TYPE 'hello", "1:9: this text has no closing quote"),
        ("10 OUTPUT #A", "1:11: the number of an input or output, with - where it is off is expected here, not '#A'"),
        ("10 ELBOW UPP", "1:10: UP or DOWN is expected here, not 'UPP'; it is ELBOW UP|DOWN"),
        ("10 APPRO A", "1:11: a number or a variable is expected here, and the line ends"),
        ("10 FINISH 1", "1:11: '1' is too much here"),
        ("10 IFSIG 1, 2 GOTO 10", "1:15: THEN is expected here, not 'GOTO'"),
        ("10 IF 1 = 1 THEN 10", "1:9: a relation, as == or LT is expected here, not '='"),
        ("10 TYPE \0", "1:9: '\\x00' can't stand here"),
    ],
)
def test_one_fault_is_one_message_at_its_line_and_column(line: str, expected: str) -> None:
    first = faults(f"{line}\n30000 TYPEI NOTHING" if not line.startswith("40000") else line)[0]
    assert first.startswith(expected)


def test_the_next_line_is_still_checked_and_programs_have_one_name() -> None:
    assert [one.partition(":")[0] for one in faults("10 MOV A\n20 MOVE A\n30 GOTO 99\n40 TYPE")] == ["1", "3", "4"]
    assert "there is no line in this program" in faults("\n")[0]
    assert "there are two programs 'MAIN'" in faults("10 ;", MAIN="10 ;")[0]


@pytest.mark.parametrize(
    ("line", "expected"),
    [
        ("MOVE A", "main.loc:1:1: a location is told as POINT A 300, 0, 200, 0, 90, 0 (mm, degrees) or POINT #A"),
        ("POINT A 1, 2, 3", "main.loc:1:1: A takes x, y, z, yaw, pitch, roll, six numbers, and has 3"),
        ("POINT A 1 2 3 4 5 nan", "main.loc:1:1: the values of A must be numbers"),
        ("POINT #A", "main.loc:1:1: a location is told as"),
        ("POINT #A 1\n  point #a 2", "main.loc:2:3: #A is there twice"),
    ],
)
def test_files_of_locations_are_checked(line: str, expected: str) -> None:
    assert faults("10 FINISH", line)[0].startswith(expected)


def test_locations_are_written_as_they_are_read_and_poses_come_back() -> None:
    program = loaded("10 FINISH")
    assert loaded("10 FINISH", listed(program.locations)).locations == program.locations
    for values in (
        (1.0, 2, 3, 10, 20, 30),
        (0.0, 0, 0, 170, -80, -100),
        (5.0, 5, 5, 30, 90, 0),
        (5.0, 5, 5, -120, -90, 0),
    ):
        assert values_of(pose_of(values)) == pytest.approx(values)
    # Yaw 90: the tool's x axis is y of the base; pitch 90 turns it downwards.
    assert pose_of((0, 0, 0, 90, 0, 0))[:3, 0] == pytest.approx([0, 1, 0])
    assert pose_of((0, 0, 0, 0, 90, 0))[:3, 0] == pytest.approx([0, 0, -1])


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("10 ! N = 0\n20 ! M = 1 / N", "main.rpl:2: line 20: a division by zero"),
        ("10 ! M = SQRT(-1)", "main.rpl:1: line 10: SQRT(-1) has no value"),
        ("10 GOTO 30\n20 ! N = 1\n30 TYPEI N", "main.rpl:3: line 30: the variable 'N' has no value yet"),
        ("10 DLOCN A\n20 LISTL A", "main.rpl:2: line 20: the location 'A' is not there"),
        ("10 SHIFT #C 1, 2, 3", "main.rpl:1: line 10: #C is a precision point, and only cartesian locations are"),
        ("10 SET A = #C", "main.rpl:1: line 10: A and #C must both be cartesian, or both precision points"),
        ("10 MOVE A", "main.rpl:1: line 10: this program was started without a robot, and can't do that"),
        ("10 GOSUB MAIN", "main.rpl:1: line 10: programs call each other without an end"),
        ("10 GOSUB MAIN 1,2,3,4,5,6,7,8,9", "main.rpl:1: line 10: GOSUB gives up to 8 parameters, and not 9"),
        ("10 TYPE 'a', %1", "main.rpl:1: line 10: MAIN was given 0 parameters, and not %1"),
        ("10 ! &1 = 'a'\n20 DECODE &1, 1, N", "main.rpl:2: line 20: &1 has no number from character 1 on: 'a'"),
        ("10 GOPATH 3", "main.rpl:1: line 10: there is no path 3; CTPATH makes one"),
    ],
)
def test_faults_of_a_running_program_have_their_line(text: str, expected: str) -> None:
    with pytest.raises(RaplStopped) as caught:
        shown(text)
    assert str(caught.value).startswith(expected)
    assert caught.value.metadata["file"] == "main.rpl"


def test_locations_are_set_shifted_and_listed() -> None:
    assert shown(
        """
        10 SET D = A
        20 SHIFT D, 0, 10, -5
        30 SHIFTA D, 1, 0, 0, 10, -20, 30
        40 LISTL D
        50 DLOCN B, #C
        60 LISTL
        """
    ) == [
        "POINT D 301.000, 10.000, 170.000, 10.000, 70.000, 30.000",
        "POINT A 300.000, 0.000, 175.000, 0.000, 90.000, 0.000",
        "POINT D 301.000, 10.000, 170.000, 10.000, 70.000, 30.000",
    ]


def test_a_loop_without_an_end_is_stopped() -> None:
    task = RaplTask(loaded("10 GOTO 10"))
    task.stop("by hand")
    with pytest.raises(TaskStopped, match="by hand"):
        task.run()
    with pytest.raises(WrongStateError, match="there is no program 'other'; there are: MAIN"):
        task.run("other")


def test_the_command_tells_faults_with_places_and_exit_code_1(tmp_path: Path) -> None:
    program, locations = tmp_path / "pallet.rpl", tmp_path / "pallet.loc"
    program.write_text("10 MOVE A\n20 LOCK 1\n")
    locations.write_text("POINT A 300 0 200 0 90 0\n")
    runner = CliRunner()
    one = runner.invoke(rapl, ["check", str(program), "--locations", str(locations)], standalone_mode=False)
    assert one.return_value == 1
    assert one.output.startswith(f"{program}:2:4: LOCK can't be used here: it works on motors")
    program.write_text("10 MOVE A\n")
    two = runner.invoke(rapl, ["check", str(program), "--locations", str(locations)], standalone_mode=False)
    assert (two.return_value, two.output) == (0, "no fault in 1 lines of 1 program: PALLET\n")

"""RAPID's own meaning: data, control flow, routines, error handlers, strings and places, by what programs print."""

from __future__ import annotations

import math
import threading

import pytest
from virtualrobot.errors import WrongStateError
from virtualrobot_apps.languages.core.task import TaskStopped
from virtualrobot_apps.languages.rapid.faults import RapidStopped
from virtualrobot_apps.languages.rapid.task import RapidTask

from tests.apps.languages.rapid import fault_of, loaded, main_prints, printed


def test_records_and_arrays_are_values() -> None:
    assert main_prints(
        r"""
        VAR pos a := [1, 2, 3];
        VAR pos b;
        VAR pos list{2} := [[1, 1, 1], [2, 2, 2]];
        b := a;
        b.x := 9;
        list{2} := b;
        b.y := 7;
        TPWrite ValToStr(a) + ValToStr(b) + ValToStr(list);
        TPWrite "" \Bool:=a = [1, 2, 3];
        TPWrite "" \Pos:=a + 2 * b - [1, 1, 1];
        TPWrite "" \Pos:=a * [0, 0, 1];
        """
    ) == ["[1,2,3][9,7,3][[1,1,1],[9,2,3]]", "TRUE", "[18,15,8]", "[2,-1,0]"]


def test_parameters_by_value_and_by_reference() -> None:
    more = r"""
    VAR num grid{2,2} := [[1, 2], [3, 4]];
    PROC change(num a, INOUT num b, INOUT pos c, VAR num d{*})
      a := 10; b := 20; c.z := 30; d{1} := 40;
    ENDPROC
    PROC through(INOUT num b)
      Incr b;
    ENDPROC
    """
    assert main_prints(
        r"""
        VAR num a := 1;
        VAR num b := 2;
        VAR pos c := [1, 2, 3];
        VAR num d{2} := [5, 6];
        change a, b, c, d;
        through b;
        through c.x;
        through grid{2, 1};
        TPWrite ValToStr(a) + " " + ValToStr(b) + " " + ValToStr(c) + ValToStr(d) + ValToStr(grid);
        """,
        more,
    ) == ["1 21 [2,2,30][40,6][[1,2],[4,4]]"]


def test_optional_and_conditional_arguments_are_passed_on() -> None:
    more = r"""
    PROC outer(\num a | string b \switch loud)
      inner \a?a \b?b \loud?loud;
    ENDPROC
    PROC inner(\num a \string b \switch loud)
      TPWrite "a:" \Bool:=Present(a);
      IF Present(b) TPWrite b;
      IF Present(loud) TPWrite "loud";
    ENDPROC
    """
    assert main_prints(r'outer \a:=3; outer \b:="text" \loud;', more) == ["a:TRUE", "a:FALSE", "text", "loud"]


def test_loops_and_tests() -> None:
    assert main_prints(
        r"""
        FOR i FROM 3 TO 1 DO TPWrite "" \Num:=i; ENDFOR
        FOR i FROM 0 TO 1 STEP 0.5 DO TPWrite "" \Num:=i; ENDFOR
        FOR i FROM 1 TO 0 STEP 1 DO TPWrite "never"; ENDFOR
        TEST "b" CASE "a": TPWrite "a"; CASE "c", "b": TPWrite "b or c"; DEFAULT: TPWrite "other"; ENDTEST
        reg1 := 0;
        again:
        reg1 := reg1 + 1;
        WHILE TRUE DO
          IF reg1 < 3 GOTO again;
          IF reg1 = 3 GOTO out;
        ENDWHILE
        out:
        TPWrite "" \Num:=reg1;
        """
    ) == ["3", "2", "1", "0", "0.5", "1", "b or c", "3"]


@pytest.mark.parametrize("handler", ["", "ERROR RETRY;"])
def test_conditions_and_tests_have_any_number_of_arms(handler: str) -> None:
    arms = "".join(f'ELSEIF reg1 = {number} THEN TPWrite "arm {number}"; ' for number in range(300))
    cases = "".join(f'CASE {number}, -{number + 1}: TPWrite "case {number}"; ' for number in range(300))
    test = f"TEST reg1 {cases} DEFAULT: TPWrite ValToStr(reg1); ENDTEST"
    choice = f'IF reg1 = -1 THEN TPWrite "no"; {arms} ELSE TPWrite "none"; ENDIF {test}'
    said = main_prints(f"one 299; one 300; {handler}", f"PROC one(num n) reg1 := n; {choice} {handler} ENDPROC")
    assert said == ["arm 299", "case 299", "none", "300"]


def test_a_condition_whose_second_arm_fails_is_left_out_whole() -> None:
    arms = 'IF reg1 = 1 THEN TPWrite "a"; ELSEIF 1 / reg1 = 1 THEN TPWrite "b"; ELSE TPWrite "c"; ENDIF'
    assert main_prints(f'{arms} TPWrite "after"; ERROR TRYNEXT;') == ["after"]


def test_late_binding_finds_procedures_by_name() -> None:
    more = r"""
    PROC job1(num a) TPWrite "one" \Num:=a; ENDPROC
    PROC job2(INOUT num a) Incr a; ENDPROC
    """
    assert main_prints(r'reg1 := 5; %"JOB"+ValToStr(1)% 3; %"job2"% reg1; TPWrite "" \Num:=reg1;', more) == [
        "one3",
        "6",
    ]


ERRORS = r"""
PROC risky()
  VAR num z := 0;
  VAR num tries := 0;
  TPWrite "begin";
  z := 1 / z;
  TPWrite "z" \Num:=z;
  IF 1 / (z - 1) > 2 TPWrite "never";
  inner;
  TPWrite "end";
ERROR
  IF ERRNO = ERR_DIVZERO THEN
    tries := tries + 1;
    IF tries > 1 TRYNEXT;
    z := 1;
    RETRY;
  ENDIF
  TPWrite "error" \Num:=ERRNO;
  RETURN;
ENDPROC
PROC inner()
  RAISE 7;
  TPWrite "never";
ERROR
  TPWrite "inner";
  RAISE;
ENDPROC
"""


def test_error_handlers_retry_go_on_return_and_pass_on() -> None:
    """RETRY repeats the statement, TRYNEXT goes on after it, RAISE calls the handler of the caller (8-RAISE-1)."""
    assert main_prints("risky;", ERRORS) == ["begin", "z1", "inner", "error7"]


def test_an_error_without_a_handler_ends_the_program_with_its_line_and_the_way_there() -> None:
    with pytest.raises(RapidStopped) as caught:
        printed(
            """
            MODULE Tried
              PROC main()
                deeper 0;
              ENDPROC
              PROC deeper(num x)
                reg1 := 1 / x;
              ENDPROC
            ENDMODULE
            """
        )
    assert str(caught.value) == "test.mod:6: ERR_DIVZERO: a division by zero\ncalled from main (test.mod:3)"
    assert caught.value.metadata == {"file": "test.mod", "line": "6"}


@pytest.mark.parametrize(
    ("statements", "expected"),
    [
        ("VAR num a{3}; a{4} := 1;", "ERR_OUTOFBND: the index 4 is outside 1 to 3"),
        ("VAR num a{3}; reg1 := a{0};", "ERR_OUTOFBND: the index 0 is outside 1 to 3"),
        ("VAR num a{1000000 + 1};", "ERR_INVDIM: an array has 1 to 1,000,000 elements, not 1000001"),
        ("VAR num a{10000,1E4 * 1};", "ERR_INVDIM: an array has 1 to 1,000,000 elements, not 10000 times 10000"),
        ("RAISE 91;", "ERR_ILLRAISE: RAISE takes a number from 1 to 90, or one of BookErrNo, not 91"),
        ('%"nowhere"%;', "ERR_REFUNKPRC: there is no procedure 'nowhere'"),
        ("reg1 := Sqrt(-1);", "ERR_ARGVALERR: -1 is outside its domain"),
        ("FOR i FROM 1 TO 2 STEP 0 DO ENDFOR", "ERR_ARGVALERR: the step of FOR is 0"),
        ("WHILE TRUE DO reg1 := Exp(reg1) + 1; ENDWHILE", "ERR_ARGVALERR: a number is too large"),
    ],
)
def test_faults_of_a_running_program_have_names(statements: str, expected: str) -> None:
    with pytest.raises(RapidStopped, match="test") as caught:
        main_prints(statements)
    assert str(caught.value).partition(": ")[2] == expected


def test_a_fault_in_the_first_values_has_its_line() -> None:
    program = loaded("MODULE Tried\n  VAR num a{1000 * 1001};\n  PROC main()\n  ENDPROC\nENDMODULE")
    task = RapidTask(program)
    with pytest.raises(RapidStopped) as caught:
        task.cell.run()
    assert str(caught.value) == "test.mod:2: ERR_INVDIM: an array has 1 to 1,000,000 elements, not 1001000"


def test_a_string_has_80_characters_at_most() -> None:
    with pytest.raises(RapidStopped, match="ERR_STRTOOLNG: a string has at most 80 characters, and this has 81"):
        main_prints(f'VAR string s := "{"x" * 80}"; s := s + "y";')


def test_routines_that_call_each_other_without_an_end_are_told() -> None:
    with pytest.raises(RapidStopped, match="routines call each other without an end"):
        main_prints("again;", "PROC again() again; ENDPROC")


def test_errors_of_a_handler_itself_end_the_program() -> None:
    """ABB, RAPID Reference Manual 5-34: one can't recover from errors that occur within an error clause."""
    more = "PROC inner() RAISE 3; ERROR reg1 := 1 / 0; RETURN; ENDPROC"
    with pytest.raises(
        RapidStopped, match="division by zero, in an error handler, whose own errors nothing handles"
    ) as it:
        main_prints("inner; ERROR TRYNEXT;", more)
    assert str(it.value).startswith("test.mod:2: ")


JUMPS = r"""
CONST num lost := 77;
PROC outer()
  between;
ERROR
  TPWrite "outer";
  RAISE;
ENDPROC
PROC between()
  deep;
ENDPROC
PROC deep()
  RAISE lost;
ERROR
  TPWrite "deep";
  RAISE;
ENDPROC
PROC numbered()
  deep;
ERROR (78, lost)
  TPWrite "numbered";
  RAISE;
ENDPROC
"""


@pytest.mark.parametrize(
    ("call", "handler", "lines"),
    [
        ("outer;", "ERROR", ["deep", "outer", "main77", "next"]),
        ("outer;", "ERROR (78, lost)", ["deep", "main77", "next"]),
        ("outer;", "ERROR (LONG_JMP_ALL_ERR)", ["deep", "main77", "next"]),
        ("numbered;", "ERROR (lost)", ["deep", "numbered", "main77", "next"]),
        ("numbered;", "ERROR", ["deep", "numbered", "main77", "next"]),
        ("RAISE lost;", "ERROR (lost)", ["main77", "next"]),
    ],
)
def test_raise_in_a_handler_is_a_long_jump_to_a_handler_for_its_number(
    call: str, handler: str, lines: list[str]
) -> None:
    """ABB, RAPID reference manual part 1a, RAISE: a long jump propagates an error from a handler to a higher level."""
    tail = r'TPWrite "next"; HANDLER TPWrite "main" \Num:=ERRNO; TRYNEXT;'.replace("HANDLER", handler)
    assert main_prints(f"{call} {tail}", JUMPS) == lines


def test_a_handler_with_numbers_leaves_other_errors_alone() -> None:
    with pytest.raises(RapidStopped, match="ERR_DIVZERO"):
        main_prints("reg1 := 1 / 0; ERROR (ERR_OUTOFBND, 7) TRYNEXT;")
    assert fault_of('ERROR ("seven") TRYNEXT;') == "the number of an error must be a num, not a string"


def test_a_handler_that_comes_to_its_end_ends_the_program() -> None:
    with pytest.raises(RapidStopped, match="came to its end without RETRY, TRYNEXT, RETURN or RAISE"):
        main_prints("RAISE 3; ERROR reg1 := 0;")


def test_a_function_without_return_and_an_argument_that_was_left_out() -> None:
    with pytest.raises(RapidStopped, match="ERR_NORETURN: the function 'f' came to its end without RETURN"):
        main_prints("reg1 := f();", "FUNC num f() ENDFUNC")
    with pytest.raises(RapidStopped, match=r"ERR_NOTPRES: the optional argument 'x' was left out; ask Present\(x\)"):
        main_prints("p;", r"PROC p(\num x) reg1 := x; ENDPROC")


def test_exit_ends_the_program() -> None:
    assert main_prints('TPWrite "a"; EXIT; TPWrite "b";') == ["a"]


def test_a_loop_without_an_end_can_be_stopped() -> None:
    task = RapidTask(loaded("MODULE T\nPROC main()\nWHILE TRUE DO ENDWHILE\nENDPROC\nENDMODULE"))
    threading.Timer(0.05, task.stop, ["by hand"]).start()
    with pytest.raises(TaskStopped, match="by hand"):
        task.run()


def test_a_program_begins_with_its_first_values_each_time() -> None:
    lines: list[str] = []
    program = loaded('MODULE T\nVAR num n := 1;\nPROC main()\nIncr n;\nTPWrite "" \\Num:=n;\nENDPROC\nENDMODULE')
    for _ in range(2):
        RapidTask(program, write=lines.append).run()
    assert lines == ["2", "2"]


def test_only_a_procedure_without_arguments_can_be_begun_with() -> None:
    task = RapidTask(loaded("MODULE T\nPROC start()\nENDPROC\nPROC other(num x)\nENDPROC\nENDMODULE"))
    with pytest.raises(WrongStateError, match="there is no procedure 'stat'; did you mean 'start'"):
        task.run("stat")
    with pytest.raises(WrongStateError, match="'other' takes arguments"):
        task.run("other")
    task.run("start")


def test_strings_are_taken_apart_and_read() -> None:
    assert main_prints(
        r"""
        VAR num value := 1;
        VAR pos place;
        VAR bool read;
        TPWrite StrPart("Robotics", 1, 5) + NumToStr(0.38521, 3) + ValToStr(1E10);
        TPWrite "" \Num:=StrFind("Robotics", 1, "aeiou");
        TPWrite "" \Num:=StrMatch("Robotics", 1, "bo");
        TPWrite "" \Num:=StrMatch("Robotics", 1, "xx");
        TPWrite StrMap("Robotics", "aeiou", "AEIOU");
        read := StrToVal("3.85", value);
        read := StrToVal("[600, 500, 225.3]", place);
        TPWrite ValToStr(value) + ValToStr(place) + ValToStr(StrToVal("no", value));
        """
    ) == ["Robot0.3851E+10", "2", "3", "9", "RObOtIcs", "3.85[600,500,225.3]FALSE"]


def test_places_are_moved_and_turned_as_the_manual_says() -> None:
    """Offs is along the work object, RelTool along the tool; RelTool turns about x, then y, then z of the tool."""
    lines = main_prints(
        r"""
        VAR robtarget p := [[100, 0, 0], [0, 0, 1, 0], [0, 0, 0, 0], [9E9, 9E9, 9E9, 9E9, 9E9, 9E9]];
        VAR robtarget q;
        p := Offs(p, 1, 2, 3);
        TPWrite ValToStr(p.trans);
        q := RelTool(p, 0, 0, 100);
        TPWrite ValToStr(q.trans);
        q := RelTool(p, 0, 0, 0 \Rx:=90 \Rz:=90);
        TPWrite ValToStr(q.rot);
        TPWrite "" \Num:=Round(EulerZYX(\Z, OrientZYX(30, 20, 10)) \Dec:=3);
        TPWrite "" \Num:=Round(EulerZYX(\Y, OrientZYX(30, 20, 10)) \Dec:=3);
        TPWrite "" \Num:=Round(EulerZYX(\X, OrientZYX(30, 20, 10)) \Dec:=3);
        TPWrite ValToStr(PoseMult([[1, 2, 3], [0, 0, 0, 1]], PoseInv([[1, 2, 3], [0, 0, 0, 1]])));
        """
    )
    assert lines[:2] == ["[101,2,3]", "[101,2,-97]"]
    turned = product(product((0, 0, 1, 0), QUARTER_X), QUARTER_Z)
    assert [float(one) for one in lines[2].strip("[]").split(",")] == pytest.approx(turned, abs=1e-6)
    assert lines[3:6] == ["30", "20", "10"]
    assert lines[6] == "[[0,0,0],[1,0,0,0]]"


C = math.sqrt(0.5)
QUARTER_X, QUARTER_Z = (C, C, 0, 0), (C, 0, 0, C)


def test_products_of_vectors_are_those_of_geometry() -> None:
    """By hand: (1, 2, 3) x (4, 5, 6), which is across both, and the volume of a cube."""
    assert main_prints(
        r"""
        VAR pos a := [1, 2, 3];
        TPWrite "" \Pos:=CrossProd(a, [4, 5, 6]);
        TPWrite "" \Num:=DotProd(a, CrossProd(a, [4, 5, 6]));
        TPWrite "" \Num:=DotProd([0, 0, 2], CrossProd([2, 0, 0], [0, 2, 0]));
        """
    ) == ["[-3,6,-3]", "0", "8"]


def product(p: tuple[float, ...], q: tuple[float, ...]) -> tuple[float, ...]:
    """Return the product of two quaternions, real part first, by Hamilton's rule written out."""
    a, b, c, d = p
    w, x, y, z = q
    return (
        a * w - b * x - c * y - d * z,
        a * x + b * w + c * z - d * y,
        a * y - b * z + c * w + d * x,
        a * z + b * y - c * x + d * w,
    )


def test_a_quaternion_that_is_far_from_length_1_is_refused_and_one_that_is_rounded_is_not() -> None:
    assert main_prints("reg1 := EulerZYX(\\X, [0.707, 0, 0, 0.707]);") == []
    with pytest.raises(RapidStopped, match=r"the orientation \[1.001, 0, 0, 0\] has the length 1.001 and not 1"):
        main_prints("reg1 := EulerZYX(\\X, [1.001, 0, 0, 0]);")
    with pytest.raises(
        RapidStopped, match=r"the orientation \[1.1, 0, 0, 0\] has the length 1.1 and not 1; use NOrient"
    ):
        main_prints("reg1 := EulerZYX(\\X, [1.1, 0, 0, 0]);")

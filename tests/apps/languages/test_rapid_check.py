"""Check of RAPID: names, types, arguments, and what doesn't work here, before anything moves."""

from __future__ import annotations

from pathlib import Path

import pytest
from click.testing import CliRunner
from virtualrobot.cli.program import run
from virtualrobot_apps.languages.rapid.command import rapid
from virtualrobot_apps.languages.rapid.predefined import CONSTANTS
from virtualrobot_apps.languages.rapid.table import BUILTINS, lacking_names

from tests.apps.languages.rapid import fault_of, faults, loaded, main_prints


@pytest.mark.parametrize(
    ("statements", "expected"),
    [
        ('TPWrit "";', "there is no procedure 'TPWrit'; did you mean 'TPWrite'?"),
        ("reg1 := redg1 + 1;", "'redg1' is not declared; did you mean 'reg1'?"),
        ("reg1 := TRUE;", "what is assigned must be a num, not a bool"),
        ('reg1 := "a" + 1;', "+ can't take a string and a num"),
        ("IF 1 THEN ENDIF", "the condition of IF must be a bool, not a num"),
        ("WHILE reg1 DO ENDWHILE", "the condition of WHILE must be a bool, not a num"),
        ("v100 := v200;", "'v100' can't be assigned to: it is a constant"),
        ("FOR i FROM 1 TO 2 DO i := 3; ENDFOR", "'i' can't be assigned to: it is the variable of a loop"),
        ("Incr 3;", "Name of Incr must be a variable, not a value"),
        ("Incr pi;", "Name of Incr must be a variable, and 'pi' can't be changed"),
        ("Incr reg1, 2;", "Incr takes 1 arguments and no more; it takes Name"),
        ("Add reg1;", "Add lacks 'AddValue'; it takes Name, AddValue"),
        ('TPWrite "" \\Numm:=1;', "TPWrite has no argument 'Numm'; did you mean 'Num'?; it takes String, \\Num"),
        ('TPWrite "" \\Num:=1 \\Bool:=TRUE;', "TPWrite gets 'Bool', or what stands for it, twice"),
        ('TPWrite "" \\Num;', "Num of TPWrite needs a value, as \\Num:=num"),
        ("reg1 := EulerZYX(\\X:=1, [1,0,0,0]);", "X of EulerZYX is a switch, and takes no value"),
        ("Abs 3;", "Abs is a function, whose value is lost"),
        ("reg1 := Incr(reg1);", "Incr is an instruction, and has no value"),
        ("reg1 := v100.v_tpc;", "a speeddata has no component 'v_tpc'; it has v_tcp, v_ori, v_leax, v_reax"),
        ("reg1 := reg2.x;", "a num has no components"),
        ("reg1 := reg2{1};", "this has 1 indices, and what it is taken of is no array"),
        ("VAR pos p := [1,2];", "a pos has 3 components (x, y, z), and 2 are given"),
        ("VAR pos p := [1,2,TRUE];", "z of a pos must be a num, not a bool"),
        ("VAR positon p;", "there is no type 'positon' here"),
        ("GOTO nowhere;", "there is no label 'nowhere' here"),
        (
            "MoveJ [[1,2,3],[1,0,0,0],[0,0,0,0],[0,0,0,0,0,0]], v100, fine, tGrip;",
            "'tGrip' is not declared",
        ),
        ('TPWrite "a\0b";', "the character '\\x00' can't stand in a text"),
        ("\0\0\0", "the character '\\x00' can't stand here, nor can the 2 after it"),
        ("reg1 := 1E400;", "the number 1E400 is too great"),
        ("RETRY;", "RETRY stands in error handlers alone"),
        ("RAISE;", "RAISE needs the number of an error here"),
        ("RETURN 3;", "RETURN of a PROC takes no value"),
        ("SearchExtJ reg1;", "SearchExtJ can't be used here yet; see the table of what works"),
        ("PERS num p := 1;", "the persistent 'p' must be declared in the module"),
        ("VAR num reg{1000,1001};", "an array has 1 to 1,000,000 elements, not 1000 times 1001"),
        ("VAR num reg{0};", "an array has 1 to 1,000,000 elements, not 0"),
        ("VAR num reg{1,2,3,4};", "an array has at most 3 dimensions, and 'reg' has 4"),
        ("main := 3;", "'main' is a routine; a function is called with parentheses"),
        ("TPWrite GetTaskName(\\TaskNo:=reg1);", "\\TaskNo of GetTaskName can't be used here yet"),
    ],
)
def test_one_fault_is_one_message_that_names_what_is_wrong(statements: str, expected: str) -> None:
    assert fault_of(statements).startswith(expected)


def test_a_hint_is_of_the_type_that_is_wanted_or_nearly_the_same() -> None:
    assert fault_of("MoveJ CRobT(), v100, fine, tGripper;") == "'tGripper' is not declared"
    assert fault_of("MoveJ CRobT(), v100, fine, tool1;") == "'tool1' is not declared; did you mean 'tool0'?"


@pytest.mark.parametrize(
    ("statements", "expected"),
    [
        ("reg1 := " + "(" * 5000 + "1" + ")" * 5000 + "; TPWrite 1;", "this is nested deeper than 90 levels"),
        ("reg1 := " + "1+" * 5000 + "1; TPWrite 1;", "more than 200 operators are in a row here"),
        ("reg1 := " + "reg1" + "{1}" * 5000 + "; TPWrite 1;", "this is nested deeper than 90 levels"),
        ("IF TRUE " * 100 + 'TPWrite "x"; TPWrite 1;', "this is nested deeper than 90 levels"),
    ],
)
def test_what_is_nested_too_deeply_is_told_and_the_next_statement_is_looked_at(statements: str, expected: str) -> None:
    first, second = faults(f"MODULE Tried PROC main() {statements} ENDPROC ENDMODULE")
    assert first.endswith(expected)
    assert second.endswith("String of TPWrite must be a string, not a num")


def test_loops_within_each_other_that_are_too_many_have_a_line() -> None:
    lines = "WHILE TRUE DO\n" * 40 + "ENDWHILE\n" * 40
    (fault,) = faults(f"MODULE Tried PROC main()\n{lines} ENDPROC ENDMODULE")
    assert fault == "22:1: too many loops and conditions are nested within each other here"


def test_declarations_are_looked_at_in_all_modules() -> None:
    found = faults(
        """
        MODULE One
          CONST num a := b;
          CONST num b := a;
          CONST num c;
          VAR num d;
          RECORD loop
            loop inner;
          ENDRECORD
          PROC twice()
          ENDPROC
        ENDMODULE
        MODULE Two
          VAR num D;
          LOCAL PROC twice(num x, num X)
          ENDPROC
          FUNC num f()
            RETURN;
          ENDFUNC
          PROC p()
            f;
          ENDPROC
        ENDMODULE
        """
    )
    assert [one.partition(":")[0] + ": " + one.partition(": ")[2] for one in found] == [
        "2: the first value of 'a' needs itself",
        "4: the constant 'c' needs a value",
        "6: the record 'loop' would hold itself, by 'inner'",
        "13: 'D' is declared twice",
        "14: two parameters of 'twice' are called 'X'",
        "17: RETURN of the function 'f' needs a value",
        "20: 'f' is a function, whose value is lost; only a procedure is called so",
    ]


def test_local_names_are_those_of_their_module() -> None:
    found = faults(
        """
        MODULE One
          LOCAL VAR num spare;
        ENDMODULE
        MODULE Two
          PROC main()
            spare := 1;
          ENDPROC
        ENDMODULE
        """
    )
    assert found == ["6:5: 'spare' is not declared"]


def test_the_command_for_programs_leaves_those_in_other_languages_to_them(tmp_path: Path) -> None:
    file = tmp_path / "job.mod"
    file.write_text("MODULE Job\nPROC main()\nreg1 := redg1;\nENDPROC\nENDMODULE")
    for arguments in ([str(file), "--check"], ["--task", f"T_OTHER={file}", "--check"]):
        result = CliRunner().invoke(run, arguments)
        assert (result.exit_code, result.output.partition(": ")[2]) == (
            *(0, "'redg1' is not declared; did you mean 'reg1'?\n1 fault\n"),
        )
    assert "No such option" in CliRunner().invoke(run, [str(file), "--preempt"]).output
    script = tmp_path / "spin.script"
    script.write_text("def spin():\n  sleep(\nend\n")
    assert "spin.script:" in CliRunner().invoke(run, [str(script), "--check"]).output
    told = CliRunner().invoke(run, [str(script)])
    assert told.exit_code == 2 and "runs where it is sent to" in told.output.replace("\n", " ")


def test_modules_see_each_other_and_data_may_be_told_later() -> None:
    program = loaded(
        """
        MODULE One
          CONST num twice := 2 * once;
          PROC main()
            say;
          ENDPROC
        ENDMODULE
        MODULE Two
          CONST num once := 4;
          PROC say()
            TPWrite "" \\Num:=twice;
          ENDPROC
        ENDMODULE
        """
    )
    assert program.signals == {}


def test_zones_and_speeds_are_those_of_the_manual() -> None:
    """ABB, Technical reference manual RAPID Instructions, Functions and Data types: zonedata, speeddata."""
    assert CONSTANTS["z0"][1] == [False, 0.3, 0.3, 0.3, 0.03, 0.3, 0.03]
    assert CONSTANTS["z10"][1] == [False, 10.0, 15.0, 15.0, 1.5, 15.0, 1.5]
    assert CONSTANTS["z200"][1] == [False, 200.0, 300.0, 300.0, 30.0, 300.0, 30.0]
    assert CONSTANTS["v1000"][1] == [1000.0, 500.0, 5000.0, 1000.0]
    assert main_prints(r'TPWrite "" \Num:=z50.pzone_ori; TPWrite "" \Bool:=fine.finep;') == ["75", "TRUE"]


def test_what_works_is_not_among_what_is_refused() -> None:
    assert not BUILTINS.keys() & lacking_names().keys()
    assert all(one.text.endswith(".") for one in BUILTINS.values())


def test_the_command_tells_faults_with_places_and_exit_code_1(tmp_path: Path) -> None:
    good, bad = tmp_path / "good.mod", tmp_path / "bad.mod"
    good.write_text("MODULE Good\nPROC main()\nhelp;\nENDPROC\nENDMODULE\n")
    bad.write_text("MODULE Bad\nPROC help()\nTPWrit 3;\nENDPROC\nENDMODULE\n")
    runner = CliRunner()
    one = runner.invoke(rapid, ["check", str(good), str(bad)], standalone_mode=False)
    assert one.return_value == 1
    assert one.output == f"{bad}:3:1: there is no procedure 'TPWrit'; did you mean 'TPWrite'?\n1 fault\n"
    bad.write_text('MODULE Bad\nPROC help()\nTPWrite "";\nENDPROC\nENDMODULE\n')
    two = runner.invoke(rapid, ["check", str(good), str(bad)], standalone_mode=False)
    assert (two.return_value, two.output) == (0, "no fault in 2 routines\n")


def test_an_orientation_that_is_none_is_told_where_it_is_written_for_good() -> None:
    """Four zeros stand for a place that is not known yet, and a variable may be normalized before it is used."""
    said = "the orientation [1.001, 0, 0, 0] has the length 1.001 and not 1; use NOrient"
    rest = "[0, 0, 0, 0], [9E9, 9E9, 9E9, 9E9, 9E9, 9E9]"
    wrong = f"CONST robtarget far := [[0, 0, 0], [1.001, 0, 0, 0], {rest}];"
    assert fault_of("", wrong) == said
    for fine in (
        f"VAR robtarget far := [[0, 0, 0], [1.001, 0, 0, 0], {rest}];",
        f"CONST robtarget far := [[0, 0, 0], [0, 0, 0, 0], {rest}];",
        f"CONST robtarget far := [[0, 0, 0], [-0.707, 0, 0, 0.707], {rest}];",
        "CONST orient raw := [1.001, 0, 0, 0];",
    ):
        loaded(f"MODULE T\n{fine}\nPROC main()\nENDPROC\nENDMODULE")
    moved = f"MoveJ [[0, 0, 500], [1, 0, 0, -0.1], {rest}], v100, fine, tool0;"
    assert fault_of(moved) == "the orientation [1, 0, 0, -0.1] has the length 1.00499 and not 1; use NOrient"

"""Parser of RAPID: each fault at its line and column, and what comes after it is looked at as ever."""

from __future__ import annotations

import pytest
from virtualrobot_apps.languages.core.diagnostics import Diagnostics
from virtualrobot_apps.languages.core.source import Source, decoded
from virtualrobot_apps.languages.rapid import tree
from virtualrobot_apps.languages.rapid.parser import parse

from tests.apps.languages.rapid import faults, main_prints


def test_each_fault_has_its_place_and_the_next_statement_is_still_looked_at() -> None:
    found = faults(
        """
        MODULE Tried
          PROC main()
            VAR num x
            x = 3;
            WHLE x DO
            IF x > 3 THEN
              x := ;
            ELSE
              y := 1;
            ENDIF
            x := 3 +* 4;
            ENDWHILE
            MoveL p1, v100 z10, tool0;
            x := 1;
          ENDFUNC
          PROC other()
            nowhere;
          ENDPROC
        ENDMODULE
        """
    )
    assert found == [
        "3:14: ';' is missing here",
        "4:7: ':=' is expected here, not '='",
        "5:12: ',' or ';' is expected here, not 'DO'",
        "7:12: a value is expected here, not ';'",
        "9:7: 'y' is not declared",
        "11:13: a value is expected here, not '*'",
        "12:5: 'ENDWHILE' stands here without its WHILE",
        "13:20: ',' or ';' is expected here, not 'z10'",
        "15:3: ENDPROC of 'main' is missing before 'ENDFUNC'",
        "17:5: there is no procedure 'nowhere'",
    ]


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("", ["1:1: MODULE is expected here, not the end of the file"]),
        ("PROC main() ENDPROC", ["1:1: MODULE is expected here, not 'PROC'"]),
        ("MODULE A", ["1:9: ENDMODULE of 'A' is missing"]),
        (
            "MODULE A PROC main()",
            ["1:21: ENDPROC of 'main' is missing before the end"],
        ),
        ("MODULE A VAR num x := 1 2; ENDMODULE", ["1:25: ';' is expected here, not '2'"]),
        ("MODULE A VAR num \0x; ENDMODULE", ["1:18: the character '\\x00' can't stand here"]),
        ('MODULE A VAR string s := "open;\nENDMODULE', ["1:26: this text has no closing quote on its line"]),
        ("MODULE A PROC <ID>() ENDPROC ENDMODULE", ["1:15: <ID> is a place that nobody has filled"]),
        (
            "MODULE A PROC Connect() ENDPROC ENDMODULE",
            ["1:15: 'Connect' is a reserved word, and no name: the routine's name is expected here"],
        ),
        ("MODULE A(NOVUEW) ENDMODULE", ["1:1: 'NOVUEW' is no attribute of modules; did you mean 'NOVIEW'?"]),
    ],
)
def test_what_is_no_module_is_told(text: str, expected: list[str]) -> None:
    found = faults(text)
    assert len(found) >= 1
    for one in expected:
        assert any(said.startswith(one) for said in found), found


def test_priorities_are_those_of_the_manual() -> None:
    """ABB, Basic Characteristics RAPID 7.7: `* / DIV MOD`, `+ -`, comparisons, AND, and weakest XOR OR NOT."""
    assert main_prints(
        r"""
        TPWrite "" \Num:=2 + 3 * 4 - 10 DIV 4;
        TPWrite "" \Num:=-2 + 7 MOD 4;
        TPWrite "" \Bool:=NOT 1 = 2 AND 3 < 4;
        TPWrite "" \Bool:=NOT FALSE AND FALSE;
        TPWrite "" \Bool:=TRUE OR FALSE AND FALSE;
        TPWrite "" \Num:=-2 * -(3 - 5);
        """
    ) == ["12", "1", "TRUE", "TRUE", "TRUE", "-4"]


def test_commas_before_optional_arguments_may_miss_and_names_have_no_case() -> None:
    more = r"proc Say(string text \num a, \num b) IF Present(A) tpwrite TEXT \Num:=a; ENDPROC"
    assert main_prints(r'say "one", \A:=1; SAY "two"\a:=2\B:=3; Say "none" \b:=3;', more) == ["one1", "two2"]


def test_numbers_texts_and_comments_are_read() -> None:
    assert main_prints(
        r"""
        TPWrite "say ""hi"" \\ \41"; ! a comment; TPWrite "never";
        TPWrite "" \Num:=0xFF + 0b101 + 0o17 + .5 + 2. + 1E2;
        """
    ) == ['say "hi" \\ A', "377.5"]


def test_a_head_of_old_files_is_left_out() -> None:
    diagnostics = Diagnostics()
    (module,) = parse(Source("%%%\nVERSION:1\nLANGUAGE:ENGLISH\n%%%\nMODULE A\nENDMODULE", "a.mod"), diagnostics)
    assert (module.name, module.source.line(module.at), len(diagnostics)) == ("A", 5, 0)


@pytest.mark.parametrize(
    ("data", "text"),
    [
        ("Größe".encode(), "Größe"),
        ("\ufeffä".encode(), "ä"),
        ("! Größe: 3 µm".encode("latin-1"), "! Größe: 3 µm"),
        ("! 机器人".encode("gb18030"), "! 机器人"),
        ("! Grüß".encode("latin-1"), "! Grüß"),
        ("\ufeff! 机器人".encode("utf-16-le"), "! 机器人"),
        ("\ufeff! 机器人".encode("utf-16-be"), "! 机器人"),
    ],
)
def test_files_of_several_codes_are_read(data: bytes, text: str) -> None:
    assert decoded(data) == text


def test_lines_and_columns_count_from_one_whatever_ends_a_line() -> None:
    source = Source("a\r\nbc\rd\n", "x")
    assert [(source.line(at), source.column(at)) for at in range(6)] == [(1, 1), (1, 2), (2, 1), (2, 2), (2, 3), (3, 1)]


def test_a_routine_with_a_fault_in_its_header_is_still_known() -> None:
    diagnostics = Diagnostics()
    (module,) = parse(
        Source('MODULE A\nPROC one(num)\nTPWrite "";\nENDPROC\nPROC two()\nENDPROC\nENDMODULE'), diagnostics
    )
    names = [one.name for one in module.declarations if isinstance(one, tree.Routine)]
    assert names == ["one", "two"]
    assert [str(one) for one in diagnostics.sorted()] == [
        "program:2:13: the name of a parameter is expected here, not ')'"
    ]

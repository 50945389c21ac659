"""Texts in RAPID and URScript as an editor has them: hover, definitions, completion, symbols, positions."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from virtualrobot_apps.languages.core.source import Source
from virtualrobot_apps.languages.editor.lsp import symbol_message
from virtualrobot_apps.languages.editor.rapid import RapidAnalysis, together
from virtualrobot_apps.languages.editor.text import Positions
from virtualrobot_apps.languages.editor.urscript import UrscriptAnalysis

from tests.tiers import Draws

CELL = r"""MODULE Cell
  CONST robtarget home := [[1,2,3],[1,0,0,0],[0,0,0,0],[9e9,9e9,9e9,9e9,9e9,9e9]];
  RECORD box
    pos size;
    num weight;
  ENDRECORD
  VAR box boxes{3};
  ! Adds up,
  ! and multiplies.
  LOCAL FUNC num summed(num x \switch More)
    VAR num y;
    FOR i FROM 1 TO 3 DO
      y := y + i;
    ENDFOR
    RETURN y * x;
  ENDFUNC
  PROC main()
    boxes{1}.size.x := summed(2 \More);
    MoveL home, v100, fine, tool0;
    TPWrite "home" \Num:=boxes{2}.weight; ! about it
    helped 3;
    GOTO over;
    over:
    CONNECT no_such WITH came;
  ENDPROC
  TRAP came
  ENDTRAP
ENDMODULE
"""
ENDS = ["ENDFUNC", "ENDPROC", "ENDTRAP"]
BESIDE = "MODULE Other\n  PROC helped(num a)\n  ENDPROC\nENDMODULE\n"

SCRIPT = """global speed = 0.5
# Moves up.
def up(by, a=1.2):
  local place = get_actual_tcp_pose()
  def inner():
    return speed
  end
  movel(pose_add(place, p[0, 0, by, 0, 0, 0]), a, inner())
end
thread watch():
  sync()
end
up(0.1)
"""


def at(text: str, marked: str) -> int:
    """Return the place in a text that a bar marks in a piece of it."""
    before, _, after = marked.partition("|")
    assert text.count(before + after) == 1
    return text.index(before + after) + len(before)


def rapid(text: str = CELL, *others: str) -> RapidAnalysis:
    """Return what a module means beside others."""
    return RapidAnalysis(Source(text, "0.mod"), [Source(one, f"{n}.mod") for n, one in enumerate(others, 1)])


# RAPID.


@pytest.mark.parametrize(
    ("marked", "told"),
    [
        ("MoveL ho|me", ["CONST robtarget home := [[1,2,3]", "trans.x (mm)", "Module Cell."]),
        ("v1|00", ["CONST speeddata v100 := [100,500,5000,1000]", "v_tcp 100 mm/s, v_ori 500 degrees/s", "language."]),
        ("Move|L", ["MoveL ", "robtarget ToPoint", "Moves the tool centre point along a line to a place."]),
        (":= su|mmed(2", [r"FUNC num summed(num x \switch More)", "Adds up,\nand multiplies.", "Module Cell."]),
        (r"2 \Mo|re", [r"\switch More", "Parameter."]),
        ("{2}.weig|ht", ["num weight", "Component of box."]),
        ("{1}.size.x|", ["num x", "Component of pos, in mm."]),
        ("y + |i", ["num i", "Variable of the loop."]),
        ("y * |x", ["num x", "Parameter."]),
        (r"\Nu|m", ["num Num"]),
        ("help|ed", ["PROC helped(num a)", "Module Other."]),
        ("po|s size", ["pos: num x, num y, num z"]),
    ],
)
def test_a_word_of_rapid_is_told_of(marked: str, told: list[str]) -> None:
    found = rapid(CELL, BESIDE).hover(at(CELL, marked))
    assert [one for one in told if one not in found] == []


@pytest.mark.parametrize("marked", ["! ab|out", '"ho|me"', "ENDMOD|ULE", "[[1,|2,3]"])
def test_what_is_no_name_is_told_nothing_of(marked: str) -> None:
    assert rapid(CELL, BESIDE).hover(at(CELL, marked)) == ""


def test_an_argument_is_known_after_others() -> None:
    text = CELL.replace("{2}.weight", r"{2}.weight DIV 2 + summed(1 \More) \Bool:=NOT TRUE \Dnum:=1")
    assert "bool Bool" in rapid(text).hover(at(text, r"\Bo|ol"))
    assert "dnum Dnum" in rapid(text).hover(at(text, r"\Dn|um"))
    assert r"\switch More" in rapid(text).hover(at(text, r"summed(1 \Mo|re"))


def test_an_instruction_that_is_refused_is_told_so() -> None:
    text = "MODULE a\nPROC main()\n SoftAct 1, 20;\nENDPROC\nENDMODULE\n"
    assert rapid(text).hover(at(text, "Soft|Act")) == "SoftAct can't be used here yet."


@pytest.mark.parametrize(
    ("marked", "file", "line", "name"),
    [
        ("MoveL ho|me", "0.mod", 2, "home"),
        (":= su|mmed(2", "0.mod", 10, "summed"),
        (r"2 \Mo|re", "0.mod", 10, "More"),
        ("y + |i", "0.mod", 12, "i"),
        ("RETURN |y", "0.mod", 11, "y"),
        ("VAR b|ox", "0.mod", 3, "box"),
        ("GOTO ov|er", "0.mod", 23, "over"),
        ("WITH ca|me", "0.mod", 26, "came"),
        ("help|ed", "1.mod", 2, "helped"),
    ],
)
def test_a_name_of_rapid_leads_to_its_declaration(marked: str, file: str, line: int, name: str) -> None:
    found = rapid(CELL, BESIDE).definition(at(CELL, marked))
    assert found is not None
    source = found.source
    assert (source.file, source.line(found.begin), source.text[found.begin : found.end]) == (file, line, name)


def test_what_comes_with_the_language_has_no_declaration() -> None:
    assert rapid().definition(at(CELL, "v1|00")) is None
    assert rapid().definition(at(CELL, "Move|L")) is None


def test_names_are_those_of_the_place() -> None:
    words = {one.label for one in rapid(CELL, BESIDE).completion(at(CELL, "RETURN |y"))}
    assert {"x", "y", "More", "home", "summed", "helped", "MoveL", "v100", "WHILE"} <= words
    assert "i" not in words
    assert "i" in {one.label for one in rapid().completion(at(CELL, "y := |y"))}
    assert "y" not in {one.label for one in rapid().completion(at(CELL, "MoveL |home"))}


@pytest.mark.parametrize(
    ("marked", "words"),
    [
        ("boxes{1}.|size", ["size", "weight"]),
        ("{1}.size.|x", ["x", "y", "z"]),
        (r"2 \|More", ["More"]),
        (r"\Nu|m:=", ["Num", "Bool", "Pos", "Orient", "Dnum"]),
        ("! about| it", []),
        ('"ho|me"', []),
    ],
)
def test_what_can_stand_here_is_completed(marked: str, words: list[str]) -> None:
    assert [one.label for one in rapid(CELL, BESIDE).completion(at(CELL, marked))] == words


def test_types_are_completed_after_var() -> None:
    words = [one.label for one in rapid().completion(at(CELL, "VAR b|ox"))]
    assert {"box", "num", "robtarget", "intnum"} <= set(words)
    assert "MoveL" not in words


def test_a_statement_that_is_being_written_is_completed() -> None:
    text = CELL.replace("MoveL home, v100, fine, tool0;", "boxes{1}.size.")
    assert [one.label for one in rapid(text).completion(at(text, "boxes{1}.size.|\n"))] == ["x", "y", "z"]


def test_the_symbols_of_rapid_are_a_tree() -> None:
    (module,) = rapid().symbols()
    assert (module.name, module.kind.name) == ("Cell", "MODULE")
    assert [(one.name, one.kind.name, one.detail) for one in module.within] == [
        ("home", "CONSTANT", "robtarget"),
        ("box", "STRUCT", ""),
        ("boxes", "VARIABLE", "box"),
        ("summed", "FUNCTION", "FUNC num"),
        ("main", "FUNCTION", "PROC"),
        ("came", "EVENT", "TRAP"),
    ]
    ends = [CELL[one.begin : one.end].split()[-1] for one in module.within]
    assert ends == ["[[1,2,3],[1,0,0,0],[0,0,0,0],[9e9,9e9,9e9,9e9,9e9,9e9]];", "ENDRECORD", "boxes{3};", *ENDS]


def test_a_program_is_the_modules_that_declare_what_it_uses() -> None:
    def module(name: str, declared: str, used: str = "") -> Source:
        return Source(f"MODULE {name}\nPROC {declared}()\n{used}\nENDPROC\nENDMODULE\n", f"{name}.mod")

    first, second = module("a", "main", "one;"), module("b", "one", "two;")
    third, other, again = module("c", "two"), module("d", "main", "two;"), module("e", "three", "main;")
    assert together(first, [third, second, other, again]) == [first, second, third]


def test_modules_that_use_each_other_have_no_fault_alone_some() -> None:
    assert [one.message for one in rapid(CELL.replace("no_such", "boxes{1}.weight"), BESIDE).diagnostics] == []
    (alone,) = rapid(CELL.replace("no_such", "boxes{1}.weight")).diagnostics
    assert (alone.line, alone.column, alone.message) == (21, 5, "there is no procedure 'helped'")


def test_every_beginning_of_a_program_can_be_asked_about() -> None:
    for end in range(0, len(CELL), 7):
        text = CELL[:end]
        analysis = rapid(text)
        analysis.hover(end)
        analysis.definition(end)
        analysis.completion(end)
        analysis.symbols()


# URScript.


def script(text: str = SCRIPT) -> UrscriptAnalysis:
    """Return what a script means."""
    return UrscriptAnalysis(Source(text, "a.script"))


@pytest.mark.parametrize(
    ("marked", "told"),
    [
        ("pose_ad|d", ["pose_add(p_1, p_2)"]),
        ("\nu|p(0.1)", ["def up(by, a=1.2)", "Moves up."]),
        ("(pla|ce,", ["local place = get_actual_tcp_pose()", "Variable of up."]),
        ("return spe|ed", ["global speed = 0.5", "Global variable."]),
        ("0, b|y,", ["def up(by, a=1.2):", "Variable of up."]),
    ],
)
def test_a_word_of_urscript_is_told_of(marked: str, told: list[str]) -> None:
    found = script().hover(at(SCRIPT, marked))
    assert [one for one in told if one not in found] == []


@pytest.mark.parametrize(
    ("marked", "line", "name"),
    [
        ("\nu|p(0.1)", 3, "up"),
        ("(pla|ce,", 4, "place"),
        ("return spe|ed", 1, "speed"),
        (" inn|er()\n", 5, "inner"),
        ("0, b|y,", 3, "by"),
    ],
)
def test_a_name_of_urscript_leads_to_its_declaration(marked: str, line: int, name: str) -> None:
    text = SCRIPT.replace("a, inner())", "a, 1)\n  x = inner()")
    found = script(text).definition(at(text, marked))
    assert found is not None
    assert (found.source.line(found.begin), found.source.text[found.begin : found.end]) == (line, name)


def test_urscript_is_completed_and_has_symbols() -> None:
    words = [one.label for one in script().completion(at(SCRIPT, "movel(|pose"))]
    assert {"by", "place", "speed", "up", "movel", "while"} <= set(words)
    assert script().completion(at(SCRIPT, "# Mo|ves")) == []
    up, watch, speed = script().symbols()
    assert [(one.name, one.kind.name) for one in (up, watch, speed)] == [
        ("up", "FUNCTION"),
        ("watch", "EVENT"),
        ("speed", "VARIABLE"),
    ]
    assert [one.name for one in up.within] == ["inner"]


def test_every_beginning_of_a_script_can_be_asked_about() -> None:
    for end in range(0, len(SCRIPT), 5):
        analysis = script(SCRIPT[:end])
        analysis.hover(end)
        analysis.definition(end)
        analysis.completion(end)
        analysis.symbols()


def contained(symbols: list[dict[str, Any]]) -> bool:
    """Return whether the names of symbols are in their ranges, as the protocol has it."""

    def at(place: dict[str, int]) -> tuple[int, int]:
        return place["line"], place["character"]

    for one in symbols:
        whole, name = one["range"], one["selectionRange"]
        if not at(whole["start"]) <= at(name["start"]) <= at(name["end"]) <= at(whole["end"]):
            return False
    return all(contained(one["children"]) for one in symbols)


def test_a_damaged_text_can_be_asked_about(rng: np.random.Generator, draws: Draws) -> None:
    for _ in range(draws(250)):
        whole = str(rng.choice([CELL, SCRIPT]))
        text = whole
        for _ in range(rng.integers(1, 5)):
            begin, place = (int(one) for one in rng.integers(0, len(text), 2))
            end = begin + int(rng.choice([1, 3, 10, 60]))
            letter = str(rng.choice(list('()[]{}.\\;:="! a1')))
            changed = [text[:begin] + text[end:], text[:place] + text[begin:end] + text[place:]]
            text = str(rng.choice([*changed, text[:begin] + letter + text[end:]])) or ";"
        analysis, positions = (script if whole == SCRIPT else rapid)(text), Positions(Source(text))
        for at_place in rng.integers(0, len(text) + 1, 20):
            analysis.hover(int(at_place))
            analysis.definition(int(at_place))
        analysis.completion(int(rng.integers(0, len(text) + 1)))
        assert contained([symbol_message(one, positions) for one in analysis.symbols()])
        for one in analysis.diagnostics:
            positions.word(one.line, one.column)


# Positions.


def test_columns_are_units_of_utf_16() -> None:
    """A letter beyond the first plane is two units (Unicode 15, 3.9, D91)."""
    positions = Positions(Source("! 𝄞é\nab"))
    assert positions.position(3) == {"line": 0, "character": 4}
    assert positions.place({"line": 0, "character": 4}) == 3
    assert positions.place({"line": 0, "character": 99}) == 4
    assert positions.place({"line": 1, "character": 1}) == 6
    assert positions.place({"line": 9, "character": 0}) == 7
    assert [positions.place(positions.position(one)) for one in range(8)] == list(range(8))

"""Programs in RAPID that are damaged at random: each is refused in words, with places in the text, or is one still."""

from __future__ import annotations

import random
import re
from collections.abc import Callable

import pytest
from virtualrobot_apps.languages.core.diagnostics import ProgramError

from tests.apps.languages.rapid import loaded

WHOLE = r"""
MODULE Whole(SYSMODULE, NOSTEPIN)
  RECORD part
    string name;
    robtarget place;
  ENDRECORD
  ALIAS num length;
  CONST num many := 2 * 3;
  LOCAL VAR length sizes{2, 3} := [[1, 2, 3], [4, 5, 6]];
  PERS tooldata grip := [TRUE, [[0, 0, 100], [1, 0, 0, 0]], [1, [0, 0, 50], [1, 0, 0, 0], 0, 0, 0]];
  PERS wobjdata table := [FALSE, TRUE, "", [[350, 0, 200], [1, 0, 0, 0]], [[0, 0, 0], [1, 0, 0, 0]]];
  VAR part parts{2};
  VAR intnum pressed;

  PROC main()
    VAR num i := 0;
    CONNECT pressed WITH on_button;
    ISignalDI diButton, 1, pressed;
    again:
    FOR j FROM 1 TO many STEP 2 DO
      MoveJ Offs(parts{1}.place, 0, 0, 10 * j), v500 \V:=20, z20, grip \WObj:=table;
      parts{2}.place.trans.x := sizes{1, j MOD 3 + 1} - 1;
    ENDFOR
    WHILE i < 3 AND NOT (i = 2 OR di2 = 1) DO
      Incr i;
    ENDWHILE
    TEST i
    CASE 1, 2:
      SetDO doGrip, high;
    DEFAULT:
      show "three" \loud \number:=f(i);
    ENDTEST
    IF i > 5 THEN
      GOTO again;
    ELSEIF i = 4 THEN
      %"show"% "late";
    ELSE
      WaitUntil TestDI(di2) \MaxTime:=2;
    ENDIF
    IF i > 5 RAISE 7;
  ERROR
    IF ERRNO = ERR_WAIT_MAXTIME THEN
      RETRY;
    ENDIF
    TRYNEXT;
  ENDPROC

  LOCAL FUNC num f(num x)
    RETURN -x / 2 + StrLen("text") DIV 3;
  ENDFUNC

  PROC show(string text \switch loud, \num number | bool flag, INOUT num count)
    inner text \number?number;
  ENDPROC

  PROC inner(string text \num number)
    TPWrite text \Num:=number;
  ENDPROC

  TRAP on_button
    IDelete pressed;
  ENDTRAP
ENDMODULE
"""
WORD = re.compile(r"\w+|:=|<>|<=|>=|\"[^\"]*\"|[^\w\s]")


def test_the_whole_program_has_the_one_fault_that_it_is_to_have() -> None:
    """An argument by reference can't be left out, and the call of `show` does so."""
    with pytest.raises(ProgramError) as caught:
        loaded(WHOLE)
    assert [one.message.partition(";")[0] for one in caught.value.diagnostics] == ["show lacks 'count'"]
    loaded(WHOLE.replace(", INOUT num count", ""))


def test_damaged_programs_are_refused_in_words_or_are_programs_still(
    rng_words: random.Random, draws: Callable[[int], int]
) -> None:
    whole = WHOLE.replace(", INOUT num count", "").strip()
    lines = whole.count("\n") + 2
    words = [(match.start(), match.end()) for match in WORD.finditer(whole)]
    refused = 0
    for _ in range(draws(400)):
        text = whole
        for _ in range(rng_words.randint(1, 3)):
            begin, end = rng_words.choice(words)
            other = whole[slice(*rng_words.choice(words))]
            text = text[:begin] + rng_words.choice(["", f" {other} ", text[begin:end] * 2]) + text[end:]
        try:
            loaded(text)
        except ProgramError as error:
            refused += 1
            for one in error.diagnostics:
                assert 1 <= one.line <= lines
                assert one.column >= 1
                assert one.message
    assert refused > 0


def test_the_statement_after_a_fault_is_looked_at(rng_words: random.Random, draws: Callable[[int], int]) -> None:
    """Whatever is wrong in a line of its own, an unknown name in the next statement is still told."""
    wrong = [
        "reg1 := ;",
        "reg1 = 2;",
        "MoveL p10 v100;",
        "reg1 := (1 + ;",
        "reg1 := 1 + 2)",
        "%;",
        "a b c;",
        "x{;",
        "[1];",
    ]
    for _ in range(draws(50)):
        body = "\n".join(rng_words.choice(wrong) for _ in range(rng_words.randint(1, 4)))
        with pytest.raises(ProgramError) as caught:
            loaded(f"MODULE T\nPROC main()\n{body}\nIF TRUE THEN\nnowhere;\nENDIF\nENDPROC\nENDMODULE")
        assert "there is no procedure 'nowhere'" in [one.message for one in caught.value.diagnostics], body


@pytest.fixture
def rng_words(seed: int) -> random.Random:
    """Return a source of random numbers for words."""
    return random.Random(seed)

"""Parser and check of URScript: each fault at its line and column, and what comes after it is looked at as ever."""

from __future__ import annotations

import numpy as np
import pytest
from virtualrobot_apps.languages.core.diagnostics import ProgramError
from virtualrobot_apps.languages.urscript.lexer import KEYWORDS
from virtualrobot_apps.languages.urscript.pieces import pieces
from virtualrobot_apps.languages.urscript.table import BUILTINS, lacking_names
from virtualrobot_apps.languages.urscript.task import load

from tests.apps.languages.urscript import fault_of, faults, loaded, said


def test_each_fault_has_its_place_and_the_next_statement_is_still_looked_at() -> None:
    assert faults(
        """
        def tried():
          a = 3 +* 4
          while a
            b = 1
          end
          if a == 1:
            textmsg([1, 2,
          else:
            c = nowhere
          end
          d = p[1, 2, 3]
          e = "open
          f = 1 $ label
          ? 3
          3 + 4
          5 = a
          elif
          def g(x:
            textmsg(x)
          end
          break
        end
        """
    ) == [
        "2:10: a value is expected here, not '*'",
        "3:10: ':' is expected here, not the end of the line",
        "7:19: a value is expected here, not the end of the line",
        "9:9: 'nowhere' is never given a value",
        "11:7: a pose has 6 numbers (x, y, z, rx, ry, rz), not 3",
        "12:7: this text has no closing quote on its line",
        "14:3: the character '?' can't stand here",
        "14:6: a call is expected here, not the end of the line",
        "15:8: a call is expected here, not the end of the line",
        "16:3: only a variable, its element or component can be assigned to",
        "17:3: 'elif' stands here without its begin",
        "18:10: ',' or ')' is expected here, not ':'",
        "21:3: 'break' stands in loops alone",
    ]


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("", "1:1: a program (def, sec) or a statement is expected here"),
        ("def a():", "1:1: this 'def' has no 'end'"),
        ("def a():\n  while True:\n    sync()\nend", "1:1: this 'def' has no 'end'"),
        ("def a():\nend\nend", "3:1: 'end' stands here without its begin"),
        ("def a():\nend\ntextmsg(1)", "3:1: nothing can stand after the end of 'a'"),
        ("def a(b):\nend", "1:7: the program 'a' can't have parameters"),
        ("def ():\nend", "1:5: the name of this 'def' is expected here, not '('"),
        ("textmsg(\0)", "1:9: the character '\\x00' can't stand here"),
        ("a = " + "(" * 10_000, "1:94: this is nested deeper than 90 levels"),
        ("a = 1" + " + 1" * 10_000, "1:357: this is nested deeper than 90 levels"),
        ("a = [1]\nb = a" + "[0]" * 10_000, "2:268: this is nested deeper than 90 levels"),
        (
            "if True:\n" + "elif True:\nsync()\n" * 3000 + "end",
            "1:1: a choice in this program has too many arms, or too much is within them",
        ),
        ("a = " + "9" * 5000, f"1:5: the number {'9' * 5000} is too large"),
        ("while True:\n" * 16 + "sync()\n" + "end\n" * 16, "16:1: more than 15 loops are within each other here"),
        ("while True:\n" * 1000, "90:7: this is nested deeper than 90 levels"),
    ],
)
def test_what_is_no_program_is_told(text: str, expected: str) -> None:
    found = faults(text)
    assert expected in found, found


@pytest.mark.parametrize(
    ("statements", "expected"),
    [
        ("textmsgs(1)", "there is no function 'textmsgs'; did you mean 'textmsg'?"),
        ("a = 1\ntextmsg(b)", "'b' is never given a value"),
        ("speed = 1\ntextmsg(sped)", "'sped' is never given a value; did you mean 'speed'?"),
        ("textmsg(sin)", "'sin' is a function, which is called with parentheses"),
        ("a = 1e999", "the number 1e999 is too large"),
        ("sleep()", "'sleep' lacks 't'; it takes t"),
        ("sleep(1, 2)", "'sleep' gets 2 arguments; it takes t"),
        ("sleep(s=1)", "'sleep' has no parameter 's'; it takes t"),
        ("sleep(1, t=2)", "'sleep' gets 't' twice"),
        ("textmsg(s1=1, 2)", "an argument without a name stands before those of 'textmsg' with names"),
        ("sync(1)", "'sync' gets 1 arguments; it takes none"),
        ("textmsg(p[1, 2])", "'p' is never given a value; a pose p[x, y, z, rx, ry, rz] has 6 numbers"),
        ("run nothing()", "there is no thread 'nothing'"),
        ("thread t():\nend\nt()", "'t' is a thread, which is started by 'run t()'"),
        ("def f():\nend\nh = run f()", "there is no thread 'f'"),
        ("def f():\nend\ndef f():\nend", "'f' is defined twice"),
        ("def sin():\nend", "'sin' is a function of the language, and can't be defined anew"),
        ("def f(a, a):\nend", "two parameters of 'f' are called 'a'"),
        ("def f(a=1, b):\nend", "'b' needs a value, since the parameter before it has one"),
        ("sec f():\nend", "a secondary program (sec) can't stand in another one"),
        ("a = struct(1)", "a struct has components with names, as struct(a=1)"),
        ("a = [1]\na.append(2)", "'.append()' can't be used here yet: methods of lists and structs don't work"),
    ],
)
def test_one_fault_is_one_message_that_names_what_is_wrong(statements: str, expected: str) -> None:
    assert fault_of(statements) == expected


def test_a_program_may_be_called_or_run_after_its_end_and_lines_are_one_without_a_name() -> None:
    for end in ("", "run program", "mine()"):
        assert loaded(f"def mine():\n  sync()\nend\n{end}").name == "mine"
    lines = loaded("# a comment\ntextmsg(1)\ntextmsg(2)")
    assert (lines.name, lines.secondary) == ("line", False)
    assert loaded("sec mine():\n  textmsg(1)\nend").secondary


def test_names_are_those_of_the_language_whatever_python_calls_so() -> None:
    assert said(
        """
        async = 1
        lambda = 2
        None = 3
        class = [async, lambda, None]
        textmsg(class)
        """
    ) == ["[1, 2, 3]"]


def test_brackets_go_over_lines_and_labels_and_comments_are_left_out() -> None:
    assert said(
        """
        $ 1 "Robot Program"
        a = [1, # one
             2,

             3]
        textmsg(
          "a: ",
          a
        )
        """
    ) == ["a: [1, 2, 3]"]


def test_a_value_may_stand_below_its_assignment_and_reserved_words_begin_a_statement_on_a_line() -> None:
    """The script of ur-rtde has both, where its library puts numbers into it."""
    assert said("global a = # a number\n1    global b = # another one\n2  textmsg(a, b)".replace("2  ", "2\n")) == [
        "12"
    ]
    assert said("a = 1 if a == 1: textmsg(a) end") == ["1"]


def test_p_is_a_pose_or_a_variable() -> None:
    assert said("p = p[1, 2, 3, 0, 0, 0]\np[0] = p[1] + p [2]\ntextmsg(p)") == ["p[5, 2, 3, 0, 0, 0]"]


def test_programs_are_whole_with_their_last_end_and_lines_with_their_newline() -> None:
    program = 'def one():\n  if True: sync() end # end\n  textmsg("end")\nend\n'
    cases = [
        ("", [], ""),
        ("sync()", [], "sync()"),
        ("sync()\nsync()\n", ["sync()\nsync()\n"], ""),
        (program, [program], ""),
        (program + "one()\n", [program + "one()\n"], ""),
        ("# head\n" + program, ["# head\n" + program], ""),
        (program * 2 + "sec two():\n", [program, program], "sec two():\n"),
        ("sync()\n" + program, ["sync()\n", program], ""),
        ("end\n" + program[:-4], ["end\n"], program[:-4]),
    ]
    for text, whole, rest in cases:
        assert pieces(text) == (whole, rest), text
    for cut in range(len(program)):
        assert pieces(program[:cut]) == ([], program[:cut])


def test_what_works_is_not_among_what_is_refused() -> None:
    assert not BUILTINS.keys() & lacking_names()
    assert not BUILTINS.keys() & KEYWORDS
    assert all(one.text.endswith(".") for one in BUILTINS.values())


def test_scripts_with_any_fault_are_refused_or_run(rng: np.random.Generator) -> None:
    """Mutations of a script by words that are left out, doubled or exchanged never end in another exception."""
    words = """def a ( ) : \n b = [ 1 , 2.5 ] \n while b [ 0 ] < 3 and not False : \n b [ 0 ] = b [ 0 ] + 1 \n
    if b == p[1,2,3,4,5,6] : \n sleep ( t = 0.1 ) \n elif True xor 1 : \n local c = "x" \n else : \n halt \n end
    \n end \n     thread d ( ) : \n return - 1 \n end \n e = run d ( ) \n join e \n end""".split(" ")
    load(" ".join(words))
    for _ in range(300):
        changed: list[str] = list(words)
        for _ in range(rng.integers(1, 4)):
            one, other = rng.integers(0, len(changed)), rng.integers(0, len(words))
            changed[one : one + rng.integers(0, 2)] = [words[other]] * int(rng.integers(0, 3))
        try:
            load(" ".join(changed))
        except ProgramError as error:
            assert error.diagnostics


def test_what_is_nested_too_deeply_costs_its_statement_alone() -> None:
    deep = "if True:\n" * 200 + "sync()\n" + "end\n" * 200
    assert faults(deep + "movj(1)\n") == [
        "90:4: this is nested deeper than 90 levels",
        "402:1: there is no function 'movj'; did you mean 'movej'?",
    ]

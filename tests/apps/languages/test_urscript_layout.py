"""Layout of scripts in URScript: the same words on the same lines, whatever spaces were before them."""

from __future__ import annotations

import os
import random
from collections.abc import Callable
from pathlib import Path

import pytest
from click.testing import CliRunner
from virtualrobot.errors import MissingFileError
from virtualrobot_apps.languages.core.diagnostics import Diagnostics, ProgramError
from virtualrobot_apps.languages.core.source import Source
from virtualrobot_apps.languages.urscript.command import urscript
from virtualrobot_apps.languages.urscript.layout import formatted
from virtualrobot_apps.languages.urscript.lexer import words_of

LAID = """# A script.
def work():
  global count = 0
  thread watch():
    while True:
      sync()
    end
  end
  handle = run watch()
  while count < 3:
    if count == 1:
      textmsg("one", # of them
        [1, 2,
          3]
      )
    elif count == 2:
      pass # two

    else:
      movej([0, 0, 0, 0, 0, 0])
    end
    if count > 5: break end
    count = count + 1
  end
  kill handle
end
"""


def laid(text: str) -> str:
    """Return a text, laid out."""
    return formatted(Source(text))


def test_a_script_that_is_laid_out_stays_so() -> None:
    assert laid(LAID) == LAID


def test_lines_get_their_levels(seed: int, draws: Callable[[int], int]) -> None:
    dice = random.Random(seed)
    for _ in range(draws(100)):
        lines = [
            dice.choice(["", " ", "\t", " " * 7]) + line.strip() + " " * dice.randrange(3) for line in LAID.split("\n")
        ]
        assert laid("\n".join(lines)) == LAID


def test_words_stay_what_they_were() -> None:
    def words(text: str) -> list[str]:
        return words_of(Source(text), Diagnostics()).values

    text = 'def  a( x ) :\nif  x  ==  "a  b" : return  [ 1,2 ]   # it  is\nend end'
    assert laid(text) == 'def  a( x ) :\n  if  x  ==  "a  b" : return  [ 1,2 ]   # it  is\nend end\n'
    assert words(laid(text)) == words(text)


def test_empty_lines_are_one_and_none_at_the_begin() -> None:
    assert laid("\n\ntextmsg(1)\n\n\n\ntextmsg(2)\n\n\n") == "textmsg(1)\n\ntextmsg(2)\n"


def test_a_script_with_faults_is_left_as_it_is() -> None:
    with pytest.raises(ProgramError, match="script:1:1"):
        formatted(Source("def a():\n  textmsg(1)\n", "script"))


def test_layout_twice_is_layout_once() -> None:
    once = laid("while True:\nif a: b() elif c: d()\nelse:\ne()\nend\nend\n")
    assert once == "while True:\n  if a: b() elif c: d()\n  else:\n    e()\n  end\nend\n"
    assert laid(once) == once


def test_the_command_checks_scripts_and_lays_them_out(tmp_path: Path) -> None:
    good, bad = tmp_path / "good.script", tmp_path / "bad.script"
    good.write_text("def a():\ntextmsg(1)\nend\n", "utf-8")
    bad.write_text("def b():\n  movel(p[0, 0], a=1)\n  textmsgs(1)\nend\n", "utf-8")

    def told(*arguments: str) -> tuple[int, str]:
        done = CliRunner().invoke(urscript, arguments, standalone_mode=False)
        assert done.exception is None, done.output
        return done.return_value, done.output.replace(f"{tmp_path}{os.sep}", "")

    assert told("check", str(good), str(good)) == (0, "no fault in 2 scripts: a, a\n")
    faults = "bad.script:2:9: 'p' is never given a value; a pose p[x, y, z, rx, ry, rz] has 6 numbers\n"
    faults += "bad.script:3:3: there is no function 'textmsgs'; did you mean 'textmsg'?\n2 faults\n"
    assert told("check", str(good), str(bad)) == (1, faults)
    assert told("format", str(good), str(bad)) == (0, "good.script changed\n1 of 2 files changed\n")
    assert good.read_text("utf-8") == "def a():\n  textmsg(1)\nend\n"
    done = CliRunner().invoke(urscript, ["check", str(tmp_path / "none")], standalone_mode=False)
    assert isinstance(done.exception, MissingFileError) and "can't be read" in str(done.exception)

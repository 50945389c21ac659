"""Layout of scripts in URScript: the same words on the same lines, whatever spaces were before them."""

from __future__ import annotations

import random
from collections.abc import Callable

import pytest
from virtualrobot_apps.languages.core.diagnostics import Diagnostics, ProgramError
from virtualrobot_apps.languages.core.source import Source
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

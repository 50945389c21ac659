"""Layout of programs in RAPID: the same words on the same lines, whatever spaces were between them."""

from __future__ import annotations

import random
import re
import textwrap
from pathlib import Path

import pytest
from click.testing import CliRunner
from virtualrobot_apps.languages.core.diagnostics import Diagnostics, ProgramError
from virtualrobot_apps.languages.core.source import Source, decoded, encoded_like
from virtualrobot_apps.languages.rapid.command import rapid
from virtualrobot_apps.languages.rapid.layout import formatted
from virtualrobot_apps.languages.rapid.lexer import KEYWORDS, pieces_of, words_of

from tests.apps.languages.test_rapid_mutations import WHOLE

LAID = textwrap.dedent(WHOLE).lstrip("\n")


def laid(text: str) -> str:
    """Return a text, laid out."""
    return formatted(Source(text, "test.mod"))


def words(text: str) -> list[str]:
    """Return the words of a text, reserved ones in small letters."""
    found = words_of(Source(text), Diagnostics())
    return [value.lower() if kind in KEYWORDS else value for kind, value in zip(found.kinds, found.values, strict=True)]


def comments(text: str) -> list[str]:
    """Return the comments of a text."""
    return [value.rstrip() for kind, value, _ in pieces_of(Source(text)) if kind == "comment"]


def test_words_and_levels_get_their_spaces() -> None:
    text = r"""
    %%%
      VERSION:1
    %%%

    module a( SYSMODULE )
    ! of the module

    const robtarget p{2}:=[
    [[1,2],[3,
    -4]],
    [[1,2],[ 3,4 ]]
    ];
    local proc   main( )   ! begins


    if a=1 and
    b=-2-c then
    Tpwrite("x"+"y")\num:=-3 ;!say
    elseif not b then incr  x; %"job"+s% 1 ;
    endif
        endproc
    endmodule"""
    assert laid(textwrap.dedent(text)) == textwrap.dedent(r"""
    %%%
      VERSION:1
    %%%

    MODULE a(SYSMODULE)
      ! of the module

      CONST robtarget p{2} := [
        [[1, 2], [3,
            -4]],
        [[1, 2], [3, 4]]
      ];
      LOCAL PROC main() ! begins

        IF a = 1 AND
          b = -2 - c THEN
          Tpwrite ("x" + "y") \num:=-3; !say
        ELSEIF NOT b THEN incr x; %"job" + s% 1;
        ENDIF
      ENDPROC
    ENDMODULE
    """).lstrip("\n")


def test_what_is_laid_out_stays_so_whatever_the_spaces_were(seed: int) -> None:
    rng = random.Random(seed)
    assert laid(LAID) == LAID
    for _ in range(20):
        lines = []
        for line in LAID.splitlines():
            parts = re.split(r'("[^"]*")', line.strip())  # spaces within texts are the program's own
            drawn = [one if one[:1] == '"' else re.sub(" ", lambda _: " " * rng.randint(1, 3), one) for one in parts]
            lines.append(" " * rng.randint(0, 9) + "".join(drawn) + " " * rng.randint(0, 2))
        assert laid("\n".join(lines)) == LAID


def test_words_and_comments_stay_wherever_lines_end(seed: int) -> None:
    rng = random.Random(seed)
    for _ in range(20):
        text, before = "", ""
        for kind, value, _ in pieces_of(Source(LAID)):
            spaces = [value, "  "] if before in ("return", "raise") else [value, "\n", "  ", " ! a comment \n"]
            text += rng.choice(spaces) if kind == "space" else value
            before = kind
        once = laid(text)
        assert words(once) == words(text)
        assert comments(once) == comments(text)
        assert laid(once) == once


def test_what_can_not_be_parsed_is_told() -> None:
    with pytest.raises(ProgramError, match=r"^test\.mod:2:1: "):
        laid("MODULE A\nENDPROC\nENDMODULE")


@pytest.mark.parametrize("code", ["utf-8", "utf-8-sig", "utf-16", "latin-1", "gb18030"])
@pytest.mark.parametrize("end", ["\n", "\r\n"])
def test_a_file_keeps_its_code_and_its_line_ends(code: str, end: str) -> None:
    text = "! 机器人\n! 3\n" if code == "gb18030" else "! Größe\n! 3\n"
    data = text.replace("\n", end).encode(code)
    assert encoded_like(Source(decoded(data)).text, data) == data


def test_the_command_changes_files_or_tells_which_it_would(tmp_path: Path) -> None:
    good, bad, ugly = (tmp_path / name for name in ("good.mod", "bad.mod", "ugly.mod"))
    good.write_text(LAID, "utf-8")
    bad.write_text("MODULE A\n", "utf-8")
    ugly.write_bytes("module A ! Größe\r\nendmodule".encode("latin-1"))
    files = [str(good), str(bad), str(ugly)]

    def told(*options: str) -> tuple[int, str]:
        done = CliRunner().invoke(rapid, ["format", *files, *options], standalone_mode=False)
        assert done.exception is None, done.output
        return done.return_value, done.output

    fault = f"{bad}:1:9: ENDMODULE of 'A' is missing\n"
    assert told("--check") == (1, f"{fault}{ugly} would be changed\n1 of 3 files would be changed; 1 left as it is\n")
    assert ugly.read_bytes().startswith(b"module")
    assert told() == (1, f"{fault}{ugly} changed\n1 of 3 files changed; 1 left as it is\n")
    assert ugly.read_bytes() == "MODULE A ! Größe\r\nENDMODULE\r\n".encode("latin-1")
    files.remove(str(bad))
    assert told("--check") == (0, "0 of 2 files would be changed\n")

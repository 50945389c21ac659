"""Persistents that a program changes, in its files: what is written, what stays, and what is not written."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from virtualrobot.errors import WrongStateError
from virtualrobot_apps.languages.core.source import read_source
from virtualrobot_apps.languages.rapid.saving import Persistents, exact_text
from virtualrobot_apps.languages.rapid.task import RapidTask, load

MODULE = """MODULE Kept
  ! how often
  PERS num count:=3 ;  ! of parts
  LOCAL PERS num third := 1/3;
  PERS num same := 2 * 3;
  TASK PERS string name := "a;b";
  PERS bool full{2} := [FALSE,
    FALSE];
  PERS pose at := [[1, 2, 3], [1, 0, 0, 0]];
  PERS num none;
  VAR num other := 1;
  PROC main()
    count := count + 1;
    third := third / 3;
    name := "say ""Grüß Gott"" \\\\ \\0A";
    full{2} := TRUE;
    at.trans.y := -9E9;
    none := 5;
    other := 5;
  ENDPROC
ENDMODULE
"""


def kept(file: Path) -> tuple[Persistents, RapidTask]:
    """Return the persistents of a file's program, which has not run, and its task."""
    task = RapidTask(load([read_source(file)]))
    task.prepare_alone()
    return Persistents([task]), task


@pytest.mark.parametrize(("code", "end"), [("utf-8", "\n"), ("utf-8-sig", "\r\n"), ("latin-1", "\n")])
def test_values_that_have_changed_are_written_and_all_else_stays(tmp_path: Path, code: str, end: str) -> None:
    file = tmp_path / "kept.mod"
    file.write_bytes(MODULE.replace("\n", end).encode(code))
    persistents, task = kept(file)
    task.run()
    assert persistents.save() == [(file, 5)]
    expected = MODULE.replace("count:=3 ;", "count:=4;").replace(":= 1/3;", f":= {1 / 9!r};")
    expected = expected.replace('"a;b"', '"say ""Grüß Gott"" \\\\ \\0A"').replace("[FALSE,\n    FALSE]", "[FALSE,TRUE]")
    expected = expected.replace("[[1, 2, 3], [1, 0, 0, 0]]", "[[1,-9E+09,3],[1,0,0,0]]")
    assert file.read_bytes() == expected.replace("\n", end).encode(code)
    persistents, task = kept(file)
    assert persistents.save() == []
    values = {datum.name: holder[0] for datum, holder in task.persistents()}
    assert values["third"] == 1 / 9 and values["name"] == 'say "Grüß Gott" \\ \n'


def test_a_file_that_somebody_has_changed_meanwhile_is_left_alone(tmp_path: Path) -> None:
    file = tmp_path / "kept.mod"
    file.write_text(MODULE, encoding="utf-8")
    persistents, task = kept(file)
    task.run()
    file.write_text(MODULE + "\n! mine\n", encoding="utf-8")
    with pytest.raises(WrongStateError, match="was changed while the program ran, and persistents are not saved"):
        persistents.save()
    assert file.read_text(encoding="utf-8") == MODULE + "\n! mine\n"


def test_numbers_have_all_their_digits(rng: np.random.Generator) -> None:
    for number in [0.0, -1.5, 9e9, 0.1, 1e-30, *rng.normal(size=50).tolist(), *(10.0 ** rng.uniform(-300, 300, 50))]:
        assert float(exact_text(float(number))) == number

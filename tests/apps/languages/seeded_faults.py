"""Programs in RAPID with a fault each, and where a trial of them in the world of `build` tells it."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import virtualrobot

HEAD = r"""MODULE Tried
  CONST jointtarget ready := [[0, 0, 0, 0, 60, 0], [9E9, 9E9, 9E9, 9E9, 9E9, 9E9]];
  CONST jointtarget beyond := [[0, 0, 0, 0, 170, 0], [9E9, 9E9, 9E9, 9E9, 9E9, 9E9]];
  CONST robtarget left := [[350, 200, 200], [0, 0, 1, 0], [0, 0, 0, 0], [9E9, 9E9, 9E9, 9E9, 9E9, 9E9]];
  CONST robtarget right := [[350, -200, 200], [0, 0, 1, 0], [-1, 0, -1, 0], [9E9, 9E9, 9E9, 9E9, 9E9, 9E9]];
  CONST robtarget over := [[350, 0, 400], [0, 0, 1, 0], [0, 0, 0, 0], [9E9, 9E9, 9E9, 9E9, 9E9, 9E9]];
  CONST robtarget far := [[900, 0, 200], [0, 0, 1, 0], [0, 0, 0, 0], [9E9, 9E9, 9E9, 9E9, 9E9, 9E9]];
  PERS robtarget crooked := [[350, 200, 200], [0, 0, 1.1, 0], [0, 0, 0, 0], [9E9, 9E9, 9E9, 9E9, 9E9, 9E9]];
  CONST orient forward := [0.70710678, 0, 0.70710678, 0];
  CONST robtarget ahead := [[374, -100, 630], forward, [-1, 0, 0, 0], [9E9, 9E9, 9E9, 9E9, 9E9, 9E9]];
  PERS tooldata long := [TRUE, [[0, 0, 160], [1, 0, 0, 0]], [1, [0, 0, 50], [1, 0, 0, 0], 0, 0, 0]];
  PERS wobjdata shelf := [FALSE, TRUE, "", [[0, 0, 200], [1, 0, 0, 0]], [[0, 0, 0], [1, 0, 0, 0]]];
  VAR num nothing := 0;
  VAR num three{3} := [1, 2, 3];
  PROC main()
    MoveAbsJ ready, v1000, fine, tool0;
    ConfL \Off;
    ConfJ \Off;
"""
"""Begin of all programs. `ahead` is 100 mm beside (374, 0, 630), where an IRB 120 at its zeros has its flange."""
FIRST = HEAD.count("\n") + 1
"""Line of the first statement after the head."""


@dataclass(frozen=True, slots=True)
class Seeded:
    """A program with a fault.

    Attributes:
        name: what is wrong.
        statements: what follows the head.
        line: the fault's line, counted from the first one after the head, 0; its column is that of the first word.
        said: words that the fault is told by.
        on: the input with which it is there; with all off the program has no fault.
    """

    name: str
    statements: str
    line: int
    said: str
    on: str = ""

    @property
    def column(self) -> int:
        """Column of the fault, from 1."""
        line = self.statements.split("\n")[self.line]
        return len(line) - len(line.lstrip()) + 1


DOWN = "MoveJ Offs(over, 0, 0, -200), v1000, fine, tool0;"
"""Move of the flange to 50 mm below the post's top."""
UNDER_AN_INPUT = "    IF TestDI(diShort) THEN\n      MoveL far, v500, fine, tool0;\n    ENDIF"
FREE = r"""    MoveJ over, v1000, fine, long;
    MoveL Offs(over, 0, 0, -170), v500, z10, long;
    MoveL over, v500, fine, long;
    MoveJ left, v1000, fine, tool0;
    MoveL Offs(left, 0, 0, 50), v500, fine, tool0;
    MoveJ over, v1000, fine, tool0;
    MoveL Offs(over, 0, 0, -200), v500, fine, tool0 \WObj:=shelf;
    WaitTime 0.1;"""
"""Program without a fault; some of the others are it with a word left out."""

SEEDED = (
    # Collisions.
    Seeded(
        "a line across the post",
        "    MoveJ left, v1000, fine, tool0;\n    MoveL right, v500, fine, tool0;",
        1,
        "'post'",
    ),
    Seeded(
        "the same with zones", "    MoveJ left, v1000, z20, tool0;\n    MoveL right, v500, z20, tool0;", 1, "'post'"
    ),
    Seeded("a joint move into the post", f"    {DOWN}", 0, "'post'"),
    Seeded(
        "a work object left out",
        "    MoveJ over, v1000, fine, tool0;\n    MoveL Offs(over, 0, 0, -200), v500, fine, tool0;",
        1,
        "'post'",
    ),
    Seeded(
        "an arc through the post",
        "    MoveJ left, v1000, fine, tool0;\n    MoveC Offs(over, 20, 0, -200), right, v500, fine, tool0;",
        1,
        "'post'",
    ),
    Seeded(
        "tool0 in place of another tool",
        "    MoveJ over, v1000, fine, long;\n    MoveL Offs(over, 0, 0, -170), v500, fine, tool0;",
        1,
        "'post'",
    ),
    Seeded(
        "a displacement that stays",
        "    PDispSet [[0, 0, -200], [1, 0, 0, 0]];\n    MoveJ over, v1000, fine, tool0;",
        1,
        "'post'",
    ),
    Seeded(
        "the third round of a loop",
        "    FOR i FROM 0 TO 4 DO\n      MoveJ Offs(left, 0, -100 * i, 0), v1000, fine, tool0;\n    ENDFOR",
        1,
        "'post'",
    ),
    Seeded("a procedure that is called", f"    down;\n  ENDPROC\n  PROC down()\n    {DOWN}", 3, "'post'"),
    Seeded(
        "a move of an error handler",
        f"    MoveL far, v500, fine, tool0;\n  ERROR\n    {DOWN}\n    TRYNEXT;",
        2,
        "'post'",
    ),
    # Out of reach, limits, singularities.
    Seeded("a line out of reach", "    MoveL far, v500, fine, tool0;", 0, "ERR_ROBLIMIT"),
    Seeded("a joint move out of reach", "    MoveJ far, v500, fine, tool0;", 0, "ERR_ROBLIMIT"),
    Seeded(
        "an arc out of reach",
        "    MoveJ left, v1000, fine, tool0;\n    MoveC over, far, v500, fine, tool0;",
        1,
        "ERR_ROBLIMIT",
    ),
    Seeded("a joint beyond its limit", "    WaitTime 0.1;\n    MoveAbsJ beyond, v500, fine, tool0;", 1, "ERR_ROBLIMIT"),
    Seeded(
        "a line through a singular posture of the wrist",
        "    MoveJ ahead, v1000, fine, tool0;\n    MoveL Offs(ahead, 0, 200, 0), v500, fine, tool0;",
        1,
        "singular",
    ),
    Seeded("a line out of reach under an input", UNDER_AN_INPUT, 1, "ERR_ROBLIMIT", on="diShort"),
    # Waiting for what does not come.
    Seeded(
        "an input that does not come",
        "    MoveJ left, v1000, fine, tool0;\n    WaitDI diReady, 1;",
        1,
        "has not ended after",
    ),
    Seeded("an input that does not come in time", "    WaitDI diReady, 1 \\MaxTime:=0.5;", 0, "ERR_WAIT_MAXTIME"),
    Seeded("a question without an answer", '    TPReadNum nothing, "How many?";', 0, "'How many?'"),
    # Values.
    Seeded("a division by zero", "    three{1} := 1 / nothing;", 0, "ERR_DIVZERO"),
    Seeded("an index too large", "    FOR i FROM 1 TO 4 DO\n      nothing := three{i};\n    ENDFOR", 1, "ERR_OUTOFBND"),
    Seeded("a quaternion that is none", "    MoveJ crooked, v500, fine, tool0;", 0, "has the length 1.1 and not 1"),
    Seeded("a speed of 0", r"    MoveJ left, v500 \V:=0, fine, tool0;", 0, "the speed 0 mm/s is not above 0"),
    Seeded("a procedure that is not there", '    %"nowhere"%;', 0, "'nowhere'"),
    Seeded("a procedure that calls itself", "    down;\n  ENDPROC\n  PROC down()\n    down;", 3, "ERR_STACK"),
)


def build(client: virtualrobot.Client) -> None:
    """Put an IRB 120 and a post before it into a world, 250 mm high, and inputs that are off."""
    client.load_robot("model://irb120", name="arm")
    client.scene.add_part("post", virtualrobot.box(0.05, 0.05, 0.25), pose=virtualrobot.pose(0.35, 0.0, 0.125))
    client.signals.create("diShort", False)
    client.signals.create("diReady", False)


def program(folder: Path, statements: str) -> Path:
    """Write a program whose statements begin in the line FIRST."""
    file = folder / "tried.mod"
    file.write_text(f"{HEAD}{statements}\n  ENDPROC\nENDMODULE\n")
    return file

"""RAPID: how fast programs are parsed, checked and translated, how fast statements are, and how soon a robot moves."""

from __future__ import annotations

import ast
import statistics
import threading
import time
from collections.abc import Callable

from virtualrobot_apps.languages.core.diagnostics import Diagnostics
from virtualrobot_apps.languages.core.source import Source
from virtualrobot_apps.languages.editor.rapid import RapidAnalysis
from virtualrobot_apps.languages.rapid.check import check
from virtualrobot_apps.languages.rapid.debugger import DebuggedTask
from virtualrobot_apps.languages.rapid.parser import parse
from virtualrobot_apps.languages.rapid.task import RapidTask, load, load_tasks

from benchmarks import rapid_motion
from benchmarks.rows import Row, row

TRIES = 5
LINES = 2_000
MEGABYTE = 1e6
ROUNDS = 200_000
STATEMENTS = 5 * ROUNDS + 2
STEPS = 500

MOTION = """MODULE Motion
PROC main()
{lines}ENDPROC
ENDMODULE
"""
LINE = "  MoveL Offs(here, {number}, 0, 10.5), v100, z10, tool0 \\WObj:=wobj0; ! line {number}\n"
LOOP = f"""MODULE Loop
PROC main()
  VAR num sum := 0;
  FOR i FROM 1 TO {ROUNDS} DO
    sum := sum + i;
    IF sum > 1000 THEN
      sum := sum - 1000;
    ENDIF
    sum := sum * 0.5;
    sum := sum + 1;
  ENDFOR
ENDPROC
ENDMODULE
"""


def motion() -> str:
    """Return a program of `LINES` moves."""
    text = MOTION.format(lines="".join(LINE.format(number=number) for number in range(LINES)))
    return text.replace("PROC main", "PERS robtarget here := [[0,0,0],[1,0,0,0],[0,0,0,0],[0,0,0,0,0,0]];\nPROC main")


def loop_by_hand(flags: list[str]) -> float:
    """Return what the loop comes to, as somebody would write it who looks at a flag before each statement."""
    total, i = 0.0, 1.0
    while i <= ROUNDS:
        if flags:
            raise InterruptedError
        total = total + i
        if flags:
            raise InterruptedError
        if total > 1000.0:
            if flags:
                raise InterruptedError
            total = total - 1000.0
        if flags:
            raise InterruptedError
        total = total * 0.5
        if flags:
            raise InterruptedError
        total = total + 1.0
        i += 1.0
    return total


def seconds(work: Callable[[], object]) -> float:
    """Return the median time of a core of some tries."""
    times = []
    for _ in range(TRIES):
        start = time.process_time()
        work()
        times.append(time.process_time() - start)
    return statistics.median(times)


def debugged() -> DebuggedTask:
    """Return the loop as a task that a debugger looks at."""
    return DebuggedTask(load_tasks({"": [Source(LOOP, "loop.mod")]}, debugged=True)[""])


def step_seconds() -> float:
    """Return the median time of the wall clock from a step to the next stop."""
    task, stood = debugged(), threading.Semaphore(0)
    task.stops_first, task.stopped = True, lambda reason, told: stood.release()
    thread = threading.Thread(target=task.run, daemon=True)
    thread.start()
    stood.acquire()
    times = []
    for _ in range(STEPS):
        start = time.perf_counter()
        task.go_on("over")
        stood.acquire()
        times.append(time.perf_counter() - start)
    task.go_on()
    thread.join()
    return statistics.median(times)


def run() -> list[Row]:
    """Return the rows; budgets: a megabyte and four million statements a second, 2,000 lines in 150 ms, a step 50."""
    text = motion()
    python = "def main():\n" + "".join(
        f"  move_l(offs(here, {number}, 0, 10.5), v100, z10, tool0, wobj=wobj0)  # line {number}\n"
        for number in range(LINES)
    )
    size = len(text) / MEGABYTE
    parsed = seconds(lambda: parse(Source(text), Diagnostics())) / size
    checked = seconds(lambda: check(parse(Source(text), Diagnostics()), Diagnostics()))
    loaded = seconds(lambda: load([Source(text)]))
    by_python = seconds(lambda: ast.parse(python)) / (len(python) / MEGABYTE)
    by_compiler = seconds(lambda: compile(python, "lines", "exec"))
    task = RapidTask(load([Source(LOOP)]))
    spent = seconds(task.run)
    edited = seconds(lambda: RapidAnalysis(Source(text, "motion.mod"), []))
    watched = debugged()
    watched.set_breakpoints("loop.mod", {1000: ""})
    looked = seconds(watched.run)
    by_hand = seconds(lambda: loop_by_hand(task.flags))
    note = f"{STATEMENTS / spent / 1e6:.2g} million statements a second"
    return [
        row("a megabyte is parsed", parsed, 1.0, "a megabyte a second", "s", 1.0),
        row("a megabyte is parsed, beside Python", parsed, by_python, "ast.parse of as much Python", "s", None),
        row(f"{LINES} lines are checked", checked, 0.15, "150 ms", "s", 1.0),
        row(f"{LINES} lines are checked and translated", loaded, by_compiler, "compile() of Python", "s", None),
        row("a million statements", spent / STATEMENTS * 1e6, 0.25, "four million a second", "s", 1.0, note),
        row(f"{LINES} lines are told an editor", edited, 0.15, "150 ms", "s", 1.0),
        row("a step of the debugger", step_seconds(), 0.05, "50 ms", "s", 1.0),
        row(
            "a million statements that are debugged",
            looked / STATEMENTS * 1e6,
            spent / STATEMENTS * 1e6,
            "not",
            "s",
            None,
        ),
        row("the same loop", spent, by_hand, "Python by hand, with a check each", "s", None),
        *rapid_motion.run(),
    ]


if __name__ == "__main__":
    for result in run():
        print(result)

"""What the documentation tells the reader to type works: Python and console blocks run against a real kernel.

The rules for those who write pages:

- Blocks of one page run from top to bottom, as a reader would type them: Python in one namespace, in a new folder, with
  a kernel whose world is empty at the usual address.
- A `text` block right after a Python block is what that block prints; in a `console` block, what follows a line with
  `$ ` is what the command prints. `...` stands for anything, and spaces don't count.
- A block with `<!-- file: NAME -->` on the line above it is written to that file in the folder.
- A block that cannot run here has `<!-- not run: reason -->` on the line above it.
- What `pip install` of the page's own packages installs goes to a folder of the page's own, without asking an index.
"""

from __future__ import annotations

import contextlib
import doctest
import io
import os
import re
import subprocess
import sys
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import zip_longest
from pathlib import Path
from textwrap import dedent

import psutil
import pytest
from _pytest.mark import ParameterSet
from virtualrobot.v1 import kernel_pb2

from tests.kernels import emptied

ROOT = Path(__file__).resolve().parent.parent.parent
PAGES = (ROOT / "README.md", *sorted((ROOT / "docs").rglob("*.md")))
FENCE = re.compile(
    r"^(?P<indent> *)(?:<!-- (?P<mark>not run|file): (?P<about>[^\n]+) -->\n *)?"
    r"```(?P<kind>\w+)\n(?P<body>.*?)^(?P=indent)```$",
    re.MULTILINE | re.DOTALL,
)
LIKE = doctest.ELLIPSIS | doctest.NORMALIZE_WHITESPACE
OWN_KERNEL = re.compile(r"pip install|motion-1\b")
"""In pages that install something or that count motions; others share a kernel."""
LONG = {
    "boebot.md",
    "calibration.md",
    "cell-io.md",
    "command-line.md",
    "crafts.md",
    "curves.md",
    "exercises.md",
    "external-axes.md",
    "history.md",
    "kinematics.md",
    "marine.md",
    "modeller.md",
    "own-kernel.md",
    "physics.md",
    "pictures-and-films.md",
    "processes.md",
    "programs.md",
    "rays.md",
    "recording.md",
    "registration.md",
    "sensor-models.md",
    "streaming.md",
    "studies.md",
    "tool-paths.md",
    "topics.md",
    "tracking.md",
    "tutorial-controllers.md",
    "tutorial-driver.md",
    "tutorial-first-cell.md",
    "tutorial-navigation.md",
    "tutorial-plugin.md",
    "tutorial-processes.md",
    "tutorial-rapid.md",
    "rapl.md",
    "tutorial-rapl.md",
    "tutorial-ros.md",
    "tutorial-seeing.md",
    "tutorial-studies.md",
    "tutorial-teacher.md",
    "tutorial-urscript.md",
    "walkers.md",
    "walls.md",
    "writers.md",
}
COMMAND_SECONDS = 300
SPEED = 5.0
"""How much faster than the wall clock the kernels run, so that nobody waits for motions."""


@dataclass(frozen=True)
class Block:
    """A block: its language (or `file`), its text, the line where that starts, what it prints, the file that it is."""

    kind: str
    body: str
    line: int
    output: str | None = None
    file: str | None = None


def blocks(text: str) -> Iterator[Block]:
    """Yield the blocks of a page that can be run."""
    found = list(FENCE.finditer(text))
    for match, after in zip_longest(found, found[1:]):
        file = match["about"] if match["mark"] == "file" else None
        if match["mark"] == "not run" or not (file or match["kind"] in ("python", "console")):
            continue
        line = text.count("\n", 0, match.start("body")) + 1
        said = after is not None and after["kind"] == "text" and not text[match.end() : after.start()].strip()
        output = dedent(after["body"]) if after is not None and said else None
        yield Block("file" if file else match["kind"], dedent(match["body"]), line, output, file)


RUNNABLE = [page for page in PAGES if any(blocks(page.read_text("utf-8")))]


def tiered(page: Path) -> ParameterSet:
    """Return a page as the parameter of a test, long for tutorials whose programs take their time."""
    marks = [pytest.mark.long, pytest.mark.patient] if page.name in LONG else []
    return pytest.param(page, id=page.relative_to(ROOT).as_posix(), marks=marks)


@pytest.mark.parametrize("page", [tiered(page) for page in RUNNABLE])
def test_blocks_run(
    page: Path, request: pytest.FixtureRequest, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    if any(OWN_KERNEL.search(block.body) for block in blocks(page.read_text("utf-8"))):
        installed = installing_into(tmp_path / "installed")
        kernel = request.getfixturevalue("start_kernel")(environment=installed)
        for name, value in installed.items():
            monkeypatch.setenv(name, value)
    else:
        kernel = request.getfixturevalue("kernel")
    (tmp_path / "here").mkdir()
    monkeypatch.chdir(tmp_path / "here")
    monkeypatch.setenv("VIRTUALROBOT_ADDRESS", kernel.address)
    monkeypatch.setenv("PATH", str(Path(sys.executable).parent), prepend=os.pathsep)
    with emptied(kernel) as stubs:
        clock = kernel_pb2.SetClockRequest(mode=kernel_pb2.CLOCK_MODE_REALTIME, speed_factor=SPEED)
        stubs.kernel.SetClock(clock)
        run_page(page)


def installing_into(folder: Path) -> dict[str, str]:
    """Return an environment in which pip installs into `folder`, and in which processes find what is there."""
    folder.mkdir()
    # Python reads the .pth files of editable installations only where it is told that packages are.
    (folder / "sitecustomize.py").write_text(f"import site\nsite.addsitedir({str(folder)!r})\n", "utf-8")
    pip = {"PIP_TARGET": str(folder), "PIP_NO_DEPS": "1", "PIP_NO_INDEX": "1", "PIP_DISABLE_PIP_VERSION_CHECK": "1"}
    # By what is installed here, without a download; pip reads this variable as that of --build-isolation.
    pip["PIP_NO_BUILD_ISOLATION"] = "0"
    # pip would warn of the bytecode that an earlier installation has left there.
    pip["PYTHONDONTWRITEBYTECODE"] = "1"
    paths = [str(folder), *filter(None, [os.environ.get("PYTHONPATH")])]
    return {**pip, "PYTHONPATH": os.pathsep.join(paths)}


@contextlib.contextmanager
def nothing_left_running() -> Iterator[None]:
    """End what a page has started, whose later blocks would have: the next try needs its ports."""
    before = set(psutil.Process().children())
    try:
        yield
    finally:
        for process in set(psutil.Process().children()) - before:
            with contextlib.suppress(psutil.NoSuchProcess):
                for one in (*process.children(recursive=True), process):
                    one.kill()
                process.wait()


def run_page(page: Path) -> None:
    """Run the blocks of a page in order; an error's traceback and a wrong output name the line of the page."""
    namespace: dict[str, object] = {"__name__": "__main__"}
    for block in blocks(page.read_text("utf-8")):
        if block.file:
            Path(block.file).write_text(block.body, "utf-8")
        elif block.kind == "python":
            run_python(page, block, namespace)
        else:
            run_console(page, block)


def run_python(page: Path, block: Block, namespace: dict[str, object]) -> None:
    """Run a Python block and compare what it prints, where the page says it."""
    printed = io.StringIO()
    code = compile("\n" * (block.line - 1) + block.body, str(page), "exec")
    with contextlib.redirect_stdout(printed):
        exec(code, namespace)
    if block.output is not None:
        compare(page, block.line, block.output, printed.getvalue())


def run_console(page: Path, block: Block) -> None:
    """Run the commands of a console block and compare what each prints."""
    commands: list[tuple[int, str, list[str]]] = []
    for number, line in enumerate(block.body.splitlines(keepends=True)):
        if line.startswith("$ "):
            commands.append((block.line + number, line[2:], []))
        else:
            assert commands, f"{page}:{block.line}: a console block begins with a line that begins with `$ `"
            commands[-1][2].append(line)
    for line, command, expected in commands:
        done = subprocess.run(
            ["bash", "-c", command],
            stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            text=True,
            timeout=COMMAND_SECONDS,
        )
        compare(page, line, "".join(expected), done.stdout)


def compare(page: Path, line: int, expected: str, printed: str) -> None:
    """Fail unless what was printed is like what the page says."""
    same = doctest.OutputChecker().check_output(expected, printed, LIKE)
    assert same, f"{page.name}:{line}: the page says\n{expected}\nbut this was printed:\n{printed}"


def test_the_tutorials_have_blocks() -> None:
    names = {page.name for page in RUNNABLE}
    assert {"README.md", "tutorial-client.md", "tutorial-teacher.md", "tutorial-plugin.md", "command-line.md"} <= names


def test_a_wrong_block_is_found(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    page = tmp_path / "page.md"
    page.write_text(
        "<!-- file: a.yaml -->\n```yaml\na: 1\n```\n1. x:\n\n   ```console\n   $ cat a.yaml\n   a: 1\n   ```\n"
    )
    assert [block.kind for block in blocks(page.read_text())] == ["file", "console"]
    run_page(page)
    page.write_text("# A\n\n```python\nx = 1\nprint(x)\n```\n\n```text\n1\n```\n\n```console\n$ echo a b\na ...\n```\n")
    run_page(page)
    page.write_text("```python\nprint(1)\n```\n```text\n2\n```\n")
    with pytest.raises(AssertionError, match=r"page\.md:2: the page says"):
        run_page(page)
    page.write_text("```console\n$ echo a\nb\n```\n")
    with pytest.raises(AssertionError, match=r"page\.md:2: the page says"):
        run_page(page)
    page.write_text("<!-- not run: it fails -->\n```python\n1 / 0\n```\n")
    run_page(page)
    page.write_text("\n```python\n1 / 0\n```\n")
    with pytest.raises(ZeroDivisionError):
        run_page(page)

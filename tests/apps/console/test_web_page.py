"""The page docs/web.md: its curl lines, its page and its Octave calls, run at a kernel that wants its token."""

from __future__ import annotations

import functools
import os
import shutil
import subprocess
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from http.server import SimpleHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path
from textwrap import dedent

import pytest
import virtualrobot
from playwright.sync_api import Page, expect
from virtualrobot_apps.console.page_files import is_built

from tests.api.asking import IIWA
from tests.api.test_docs_snippets import FENCE, Block, compare, run_console
from tests.apps.console.browsing import browsers, needs_browser
from tests.apps.console.consoles import Console, consoles
from tests.kernels import KernelProcess, StartKernel

PAGE = Path(__file__).parents[3] / "docs" / "web.md"
OCTAVE = shutil.which("octave-cli")
ADDRESS = "http://127.0.0.1:8090"

pytestmark = pytest.mark.long  # kernels and consoles of its own, and browsers


@dataclass(frozen=True)
class Served:
    """A kernel that wants its token, with an arm, and its console, which lets pages of one origin call."""

    kernel: KernelProcess
    console: Console
    origin: str
    folder: Path

    def here(self, text: str) -> str:
        """Return a text of the page with the console's own address."""
        return text.replace(ADDRESS, self.console.url)


@contextmanager
def serving(folder: Path) -> Iterator[str]:
    """Serve the files of a folder, and give the address."""

    class Quiet(SimpleHTTPRequestHandler):
        def log_message(self, *_: object) -> None:
            pass

    with ThreadingHTTPServer(("127.0.0.1", 0), functools.partial(Quiet, directory=str(folder))) as server:
        thread = threading.Thread(target=server.serve_forever)
        thread.start()
        yield f"http://localhost:{server.server_address[1]}"
        server.shutdown()
        thread.join()


@pytest.fixture(scope="module")
def served(start_kernel: StartKernel, tmp_path_factory: pytest.TempPathFactory) -> Iterator[Served]:
    kernel, folder = start_kernel(token=True), tmp_path_factory.mktemp("web")
    with (
        virtualrobot.connect(kernel.address, kernel.token) as client,
        serving(folder) as origin,
        consoles(kernel.address, "--origin", origin, token=kernel.token) as console,
    ):
        client.load_robot(IIWA, name="arm")
        yield Served(kernel, console, origin, folder)


def blocks(kind: str) -> list[str]:
    """Return the blocks of the page of one kind; a test fails where there is none."""
    found = [dedent(match["body"]) for match in FENCE.finditer(PAGE.read_text("utf-8")) if match["kind"] == kind]
    assert found
    return found


@contextmanager
def browser() -> Iterator[Page]:
    """Give a page of a fresh browser; what it complains of fails the test."""
    complaints: list[str] = []
    with browsers() as fresh:
        page = fresh.new_page()
        page.on("pageerror", lambda error: complaints.append(str(error)))
        yield page
    assert complaints == []


def test_curl_lines(served: Served, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("VIRTUALROBOT_TOKEN", served.kernel.token)
    ran = 0
    for body in blocks("console"):
        if "curl" in body:
            run_console(PAGE, Block("console", served.here(body), 1))
            ran += body.count("$ curl")
    assert ran == 4


@needs_browser
def test_a_page_of_ten_lines(served: Served) -> None:
    (text,) = blocks("html")
    assert len(text.splitlines()) <= 11
    (served.folder / "panel.html").write_text(served.here(text), "utf-8")
    with virtualrobot.connect(served.kernel.address, served.kernel.token) as client, browser() as page:
        page.goto(f"{served.origin}/panel.html#{served.kernel.token}")
        expect(page.locator("#joints")).to_contain_text("arm 0,0,0,0,0,0,0")
        client.robot("arm").move_joints([0.25] * 7)
        expect(page.locator("#joints")).to_contain_text("arm 0.25,0.25,0.25")
        page.click("#halt")
        expect(page.locator("#halt")).to_contain_text("stopped at")
        # The same page of an origin that nobody has allowed hears nothing.
        page.goto(f"{served.origin.replace('localhost', '127.0.0.1')}/panel.html#{served.kernel.token}")
        assert (
            page.evaluate(f"fetch('{served.console.url}/calls.js').then(() => 'heard', () => 'nothing')") == "nothing"
        )


@needs_browser
@pytest.mark.skipif(not is_built(), reason="the console's page is not built: make console")
def test_the_link_opens_the_page_once(served: Served) -> None:
    with browser() as page:
        page.goto(served.console.link)
        assert page.url == f"{served.console.url}/"
        # Opened again where it was used it leads to the same session; another browser is told where the next one is.
        page.goto(served.console.link)
        expect(page.locator("#connection")).to_have_text("connected")
        page.context.clear_cookies()
        page.goto(served.console.link)
        assert page.url == f"{served.console.url}/"
        expect(page.get_by_role("alert")).to_contain_text("Open the link that was printed last")
    assert "a link for another browser" in served.console.line()


@pytest.mark.skipif(OCTAVE is None, reason="no Octave: install the package octave to run the calls of docs/web.md")
def test_octave_calls(served: Served, tmp_path: Path) -> None:
    assert OCTAVE is not None
    (program,) = blocks("octave")
    (tmp_path / "cell.m").write_text(served.here(program), "utf-8")
    with virtualrobot.connect(served.kernel.address, served.kernel.token) as client:
        client.robot("arm").move_joints([0.0] * 7)
    done = subprocess.run(
        [OCTAVE, "--norc", "--quiet", "cell.m"],
        cwd=tmp_path,
        env={**os.environ, "VIRTUALROBOT_TOKEN": served.kernel.token},
        capture_output=True,
        text=True,
    )
    (said,) = blocks("text")
    compare(PAGE, 1, said, done.stdout)

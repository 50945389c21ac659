"""Editor of a page, in this process: both protocols by one channel, and texts that are on another machine."""

from __future__ import annotations

import queue
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import pytest
from virtualrobot.cli.options import Target
from virtualrobot_apps.languages.editor.page import PageEditor

from tests.waiting import PATIENCE_SECONDS

ASKS = """MODULE Asks
  PROC main()
    VAR num key;
    TPReadFK key, "which?", "", "left", "right", "", "";
    TPWrite "key" \\Num:=key;
    WHILE TRUE DO
    ENDWHILE
  ENDPROC
ENDMODULE
"""


class Page:
    """The page's side, and the channel."""

    def __init__(self) -> None:
        """Begin without a message."""
        self._put: queue.SimpleQueue[Any] = queue.SimpleQueue()
        self.told: queue.SimpleQueue[dict[str, Any]] = queue.SimpleQueue()
        self._count = 0

    def read(self) -> Any | None:  # noqa: ANN401 JSON
        return self._put.get()

    def send(self, message: dict[str, Any]) -> None:
        self.told.put(message)

    def put(self, **message: Any) -> None:  # noqa: ANN401 JSON
        self._put.put(message)

    def go(self) -> None:
        self._put.put(None)

    def ask(self, command: str, **arguments: Any) -> dict[str, Any]:  # noqa: ANN401 JSON
        """Return the answer of the debug adapter; events before it are left out."""
        self._count += 1
        self.put(dap={"type": "request", "seq": self._count, "command": command, "arguments": arguments})
        while (found := self.next("dap")).get("request_seq") != self._count:
            pass
        return found

    def next(self, lane: str) -> dict[str, Any]:
        """Return the next message of a protocol."""
        while lane not in (found := self.told.get(timeout=PATIENCE_SECONDS)):
            pass
        return found[lane]

    def output(self) -> dict[str, Any]:
        """Return the next output of the program."""
        while (found := self.next("dap")).get("event") != "output":
            pass
        return found["body"]


@contextmanager
def pages(refusal: str = "") -> Iterator[Page]:
    """Give a page; at the end it is gone, and so are the servers, within the patience of tests."""
    page = Page()
    codes: list[int] = []
    editor = PageEditor(page, Target(), refusal)
    serving = threading.Thread(target=lambda: codes.append(editor.run()), daemon=True)
    serving.start()
    try:
        yield page
    finally:
        page.go()
        serving.join(PATIENCE_SECONDS)
        assert codes == [0]


def test_a_program_asks_and_ends_with_its_page_although_it_never_waits() -> None:
    with pages() as page:
        page.ask("initialize")
        assert page.ask("launch", program="asks.mod", texts={"asks.mod": ASKS})["success"]
        told = page.ask("setBreakpoints", source={"path": "asks.mod"}, breakpoints=[{"line": 5}])
        assert told["body"]["breakpoints"][0]["verified"]
        page.ask("configurationDone")
        assert page.output()["output"].startswith("which?")
        assert page.output()["data"] == {"asks": {"text": "which?", "choices": ["left", "right"]}}
        where = {"threadId": 1, "stands": False, "program": {"path": "asks.mod", "line": 4}}
        assert page.ask("virtualrobot/where")["body"] == {"tasks": [where]}
        page.ask("evaluate", expression="right", context="repl")
        frame = page.ask("stackTrace", threadId=1)
        while not frame["success"]:  # it is on its way to the breakpoint
            frame = page.ask("stackTrace", threadId=1)
        assert frame["body"]["stackFrames"][0]["source"] == {"name": "asks.mod", "path": "asks.mod"}
        page.ask("continue", threadId=1)
        assert page.output()["output"] == "key3\n"


def test_a_question_that_nobody_answers_any_more_is_taken_back() -> None:
    text = ASKS.replace('"", "";', '"", ""\\MaxTime:=0.01;')
    with pages() as page:
        for _ in range(2):  # the next program begins when the one before has ended
            page.ask("initialize")
            assert page.ask("launch", program="asks.mod", texts={"asks.mod": text})["success"]
            page.ask("configurationDone")
            assert page.output()["output"].startswith("which?")
            assert page.output()["data"]["asks"]["choices"] == ["left", "right"]
            assert page.output()["data"] == {"asks": None}
            assert "ERR_TP_MAXTIME" in page.output()["output"]
            page.ask("disconnect")


@pytest.mark.parametrize(
    ("more", "words"),
    [
        ({"files": "/tmp"}, "'files' is for editors on this machine"),
        ({"listen": "0.0.0.0"}, "'listen' is for editors on this machine"),
        ({"address": "10.0.0.1"}, "'address' is for editors on this machine"),
        ({"texts": None}, "'texts' are the texts of the program's files by their names"),
        ({"texts": {"a.mod": 1}}, "'texts' are the texts of the program's files by their names"),
        ({"program": "/etc/passwd"}, "'texts' has no '/etc/passwd'"),
        ({"program": "x.script"}, "'texts' has no 'x.script'"),
    ],
)
def test_a_page_reaches_nothing_of_this_machine(more: dict[str, Any], words: str) -> None:
    with pages() as page:
        page.ask("initialize")
        refused = page.ask("launch", **{"program": "asks.mod", "texts": {"asks.mod": ASKS}, **more})
        assert (refused["success"], refused["message"]) == (False, words)


def test_whoever_may_run_nothing_may_write() -> None:
    with pages("this needs the role operator") as page:
        page.ask("initialize")
        refused = page.ask("launch", program="asks.mod", texts={"asks.mod": ASKS})
        assert (refused["success"], refused["message"]) == (False, "this needs the role operator")
        page.put(lsp={"jsonrpc": "2.0", "id": 1, "method": "initialize", "params": {}})
        assert page.next("lsp")["result"]["capabilities"]["hoverProvider"]


def test_modules_beside_a_text_are_not_read(tmp_path: Path) -> None:
    (tmp_path / "beside.mod").write_text("MODULE Beside\n  PROC helps()\n  ENDPROC\nENDMODULE\n")
    uri = (tmp_path / "main.mod").as_uri()
    text = "MODULE Main\n  PROC main()\n    helps;\n  ENDPROC\nENDMODULE\n"
    with pages() as page:
        page.put(lsp={"jsonrpc": "2.0", "id": 1, "method": "initialize", "params": {}})
        opened = {"textDocument": {"uri": uri, "languageId": "rapid", "version": 1, "text": text}}
        page.put(lsp={"jsonrpc": "2.0", "method": "textDocument/didOpen", "params": opened})
        while (found := page.next("lsp")).get("method") != "textDocument/publishDiagnostics":
            pass
        (fault,) = found["params"]["diagnostics"]
        assert "helps" in fault["message"]

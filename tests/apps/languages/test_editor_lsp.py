"""Language server: RAPID and URScript as an editor sees them, by the client of pygls, which others have written.

pygls takes the types of messages from the protocol's own metamodel, and refuses what is not of them.
"""

from __future__ import annotations

import asyncio
import io
import json
import sys
from collections.abc import Awaitable, Callable, Coroutine
from contextlib import suppress
from pathlib import Path
from typing import Any

import pytest
from lsprotocol import types
from pygls.exceptions import JsonRpcException
from pygls.lsp.client import LanguageClient
from virtualrobot_apps.languages.core.source import Source
from virtualrobot_apps.languages.editor.channel import Streams
from virtualrobot_apps.languages.editor.lsp import LanguageServer
from virtualrobot_apps.languages.editor.text import Positions

from tests.apps.languages.test_editor_texts import BESIDE, CELL, at
from tests.waiting import PATIENCE_SECONDS

pytestmark = pytest.mark.long

COMMAND = [sys.executable, "-m", "virtualrobot", "editor", "lsp"]

WRONG = "an interrupt must be a variable (intnum)"
"""The fault of the module, where no_such stands."""


class Editor(LanguageClient):
    """An editor that keeps what it is told."""

    def __init__(self) -> None:
        """Begin without diagnostics."""
        super().__init__("tests", "1")
        self.told: asyncio.Queue[types.PublishDiagnosticsParams] = asyncio.Queue()

    async def diagnostics(self, uri: str, version: int | None) -> list[types.Diagnostic]:
        """Return the diagnostics of a text in a version."""
        while True:
            found = await asyncio.wait_for(self.told.get(), PATIENCE_SECONDS)
            if found.uri == uri and found.version == version:
                return list(found.diagnostics)

    def open(self, uri: str, text: str, language: str = "rapid") -> None:
        """Open a text, in version 1."""
        self.text_document_did_open(types.DidOpenTextDocumentParams(types.TextDocumentItem(uri, language, 1, text)))

    def change(self, uri: str, version: int, text: str) -> None:
        """Give a text anew."""
        self.text_document_did_change(
            types.DidChangeTextDocumentParams(
                types.VersionedTextDocumentIdentifier(version=version, uri=uri),
                [types.TextDocumentContentChangeWholeDocument(text)],
            )
        )


def edited(*works: Callable[[Editor], Coroutine[Any, Any, None]]) -> None:
    """Do something with an editor that has begun a server, and end that."""

    async def session() -> None:
        editor = Editor()

        @editor.feature(types.TEXT_DOCUMENT_PUBLISH_DIAGNOSTICS)
        def told(found: types.PublishDiagnosticsParams) -> None:
            editor.told.put_nowait(found)

        await editor.start_io(*COMMAND)
        try:
            begun = await answered(
                editor.initialize_async(types.InitializeParams(capabilities=types.ClientCapabilities()))
            )
            assert begun.server_info is not None and begun.server_info.name == "virtualrobot"
            editor.initialized(types.InitializedParams())
            for work in works:
                await work(editor)
            await answered(editor.shutdown_async(None))
            editor.exit(None)
            process = editor._server
            assert process is not None and await asyncio.wait_for(process.wait(), PATIENCE_SECONDS) == 0
        finally:
            with suppress(ProcessLookupError):
                if editor._server is not None and editor._server.returncode is None:
                    editor._server.kill()
            await editor.stop()

    asyncio.run(session())


async def answered(call: Awaitable[Any]) -> Any:  # noqa: ANN401 as pygls has it
    """Return the answer of a call."""
    return await asyncio.wait_for(call, PATIENCE_SECONDS)


async def broken(editor: Editor) -> None:
    """Open a script and modules with faults: they are told, and such texts are not laid out."""
    editor.open("untitled:a", "def a():\n  movel(1\n  b()\nend\n", "urscript")
    found = await editor.diagnostics("untitled:a", 1)
    assert found and found[0].source == "urscript"
    editor.change("untitled:a", 2, "def a():\nsync()\nend\n")
    assert await editor.diagnostics("untitled:a", 2) == []
    options = types.FormattingOptions(tab_size=4, insert_spaces=True)
    here = types.TextDocumentIdentifier("untitled:a")
    (edit,) = await answered(editor.text_document_formatting_async(types.DocumentFormattingParams(here, options)))
    assert edit.new_text == "def a():\n  sync()\nend\n"
    editor.open("untitled:b", "MODULE a\nPROC\nENDMODULE\n")
    assert await editor.diagnostics("untitled:b", 1)
    with pytest.raises(JsonRpcException, match="a text with faults is left as it is: untitled:b:3:"):
        here = types.TextDocumentIdentifier("untitled:b")
        await answered(editor.text_document_formatting_async(types.DocumentFormattingParams(here, options)))
    editor.open("untitled:c", "MODULE a\nVAR num x:=" + "(" * 20000 + "\nENDMODULE\n")
    (deep,) = await editor.diagnostics("untitled:c", 1)
    assert "nested deeper than" in deep.message


def test_an_editor_is_served(tmp_path: Path) -> None:
    file, other = tmp_path / "cell.mod", tmp_path / "other.mod"
    other.write_text(BESIDE)
    uri, here = file.as_uri(), types.TextDocumentIdentifier(file.as_uri())

    def position(marked: str) -> types.Position:
        found = Positions(Source(CELL)).position(at(CELL, marked))
        return types.Position(found["line"], found["character"])

    async def work(editor: Editor) -> None:
        editor.open(uri, CELL)
        (fault,) = await editor.diagnostics(uri, 1)
        assert (fault.message, fault.severity) == (WRONG, types.DiagnosticSeverity.Error)
        assert (fault.range.start, fault.range.end) == (position("CONNECT |no"), position("no_such| WITH"))
        hover = await answered(editor.text_document_hover_async(types.HoverParams(here, position("MoveL ho|me"))))
        assert "CONST robtarget home" in hover.contents.value
        nothing = await answered(editor.text_document_hover_async(types.HoverParams(here, position("! ab|out"))))
        assert nothing is None
        where = await answered(editor.text_document_definition_async(types.DefinitionParams(here, position("hel|ped"))))
        assert (where.uri, where.range.start) == (other.as_uri(), types.Position(1, 7))
        words = await answered(
            editor.text_document_completion_async(types.CompletionParams(here, position("boxes{1}.|size")))
        )
        assert [one.label for one in words.items] == ["size", "weight"]
        (module,) = await answered(editor.text_document_document_symbol_async(types.DocumentSymbolParams(here)))
        assert [one.name for one in module.children] == ["home", "box", "boxes", "summed", "main", "came"]
        options = types.FormattingOptions(tab_size=4, insert_spaces=True)
        (edit,) = await answered(editor.text_document_formatting_async(types.DocumentFormattingParams(here, options)))
        assert edit.range.start == types.Position(0, 0)
        assert edit.new_text.splitlines()[0] == "MODULE Cell"
        # A module that another one needs, changed in the editor, counts before its file.
        editor.open(other.as_uri(), BESIDE.replace("helped", "gone"))
        assert [one.message for one in await editor.diagnostics(uri, 1)] == [
            "there is no procedure 'helped'",
            WRONG,
        ]
        editor.text_document_did_close(types.DidCloseTextDocumentParams(types.TextDocumentIdentifier(other.as_uri())))
        assert [one.message for one in await editor.diagnostics(uri, 1)] == [WRONG]
        # Of texts that come fast the newest is checked.
        for version in range(2, 60):
            editor.change(uri, version, CELL)
        editor.change(uri, 60, CELL.replace("no_such", "boxes{1}.weight"))
        assert await editor.diagnostics(uri, 60) == []
        with pytest.raises(JsonRpcException, match="is open in one of"):
            await answered(
                editor.text_document_hover_async(
                    types.HoverParams(types.TextDocumentIdentifier("file:///none.mod"), types.Position(0, 0))
                )
            )

    edited(work, broken)


def served(sent: bytes) -> tuple[int, bytes]:
    """Return the exit code of a server that gets bytes, and what it has answered."""
    answers = io.BytesIO()
    return LanguageServer(Streams(io.BytesIO(sent), answers)).run(), answers.getvalue()


def test_messages_that_are_none_are_refused_by_their_codes() -> None:
    """Codes of errors: JSON-RPC 2.0, 5.1, and Language Server Protocol 3.17, ErrorCodes."""

    def message(**fields: object) -> bytes:
        text = json.dumps({"jsonrpc": "2.0", **fields}).encode()
        return (
            b"Content-Length: %d\r\nContent-Type: application/vscode-jsonrpc; charset=utf-8\r\n\r\n" % len(text) + text
        )

    sent = [
        message(id=1, method="textDocument/hover", params={}),
        b"Content-Length: 3\r\n\r\n{a}",
        message(id=2, method="initialize", params={}),
        message(id=3, method="initialize", params={}),
        message(id=4, method="no/such"),
        message(id=5, method="textDocument/hover", params={"textDocument": 3}),
        message(id=6, method="textDocument/hover", params=[]),
        message(method="textDocument/didOpen", params={"textDocument": {}}),
        message(method="textDocument/didOpen", params={"textDocument": {"uri": "untitled:a.mod", "text": ""}}),
        message(id=10, method="textDocument/hover", params={"textDocument": {"uri": "untitled:a.mod"}, "position": 1}),
        message(method="no/such"),
        message(id=7),
        message(id=8, method="shutdown"),
        message(id=9, method="textDocument/hover", params={}),
        message(method="exit"),
    ]
    ended, answers = served(b"".join(sent))
    assert ended == 0
    found = [json.loads(one[: one.rindex(b"}") + 1]) for one in answers.split(b"\r\n\r\n")[1:]]
    codes = [(one.get("id"), one["error"]["code"]) for one in found if "error" in one]
    # The text that is no JSON is answered by whoever reads, as soon as it comes.
    assert sorted(codes, key=str) == sorted(
        {
            (1, -32002),
            (3, -32600),
            (4, -32601),
            (5, -32602),
            (6, -32602),
            (10, -32602),
            (9, -32600),
            (None, -32600),
            (None, -32700),
        },
        key=str,
    )
    assert [one["params"]["type"] for one in found if one.get("method") == "window/logMessage"] == [1]


@pytest.mark.parametrize(
    "sent", [b"", b"hello\r\n\r\n", b"Content-Length: -3\r\n\r\n", b"Content-Length: 99999999999\r\n\r\n"]
)
def test_a_channel_without_an_editor_ends(sent: bytes) -> None:
    assert served(sent) == (1, b"")

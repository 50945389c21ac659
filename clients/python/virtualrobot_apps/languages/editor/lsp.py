"""Language server of RAPID and URScript, by the Language Server Protocol 3.17.

Messages are handled in their order by one thread; a text is checked when no message waits, so that only the newest of
texts that come fast is.
"""

from __future__ import annotations

import queue
import threading
import traceback
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import Any
from urllib.parse import urlparse
from urllib.request import url2pathname

from virtualrobot_apps.languages.core.diagnostics import ProgramError
from virtualrobot_apps.languages.core.source import Source, decoded
from virtualrobot_apps.languages.editor.channel import Channel, ChannelError
from virtualrobot_apps.languages.editor.language import Analysis, Language, Symbol
from virtualrobot_apps.languages.editor.rapid import RAPID
from virtualrobot_apps.languages.editor.text import Positions
from virtualrobot_apps.languages.editor.urscript import URSCRIPT

LANGUAGES = (RAPID, URSCRIPT)

MOST_BESIDE = 200
"""Number of files of a folder that are looked at for modules of the same program."""
LARGEST_BESIDE = 2_000_000
"""Size (bytes) of the largest of them."""


_PARSE_ERROR, _INVALID_REQUEST, _METHOD_NOT_FOUND, _INVALID_PARAMS, _INTERNAL = -32700, -32600, -32601, -32602, -32603
_NOT_INITIALIZED, _REQUEST_FAILED = -32002, -32803


class Refused(Exception):
    """A request that can't be answered, with the code of its error."""

    def __init__(self, code: int, message: str) -> None:
        """Keep the code and say why."""
        super().__init__(message)
        self.code = code


@dataclass(frozen=True, slots=True)
class Document:
    """A text that an editor has open, in one of its versions."""

    uri: str
    language: Language
    version: int | None
    source: Source
    positions: Positions


class LanguageServer:
    """Language server of one editor."""

    def __init__(self, channel: Channel, *, reads_files: bool = True) -> None:
        """Begin without a text; `reads_files`: the texts of a file's folder count, too, that aren't open."""
        self._channel, self._reads_files = channel, reads_files
        self._documents: dict[str, Document] = {}
        self._analyses: dict[str, Analysis] = {}
        self._due: dict[str, None] = {}
        self._files: dict[Path, tuple[tuple[int, int], Source]] = {}
        self._initialized = self._ended = False
        self._code = 1
        self._requests: dict[str, Callable[[Mapping[str, Any]], Any]] = {
            "textDocument/hover": self._hover,
            "textDocument/definition": self._definition,
            "textDocument/completion": self._completion,
            "textDocument/documentSymbol": self._symbols,
            "textDocument/formatting": self._formatting,
        }
        self._notices: dict[str, Callable[[Mapping[str, Any]], None]] = {
            "textDocument/didOpen": self._opened,
            "textDocument/didChange": self._changed,
            "textDocument/didClose": self._closed,
            "workspace/didChangeWatchedFiles": self._files_changed,
        }

    def run(self) -> int:
        """Serve until the editor ends; return the exit code, which is 0 after a shutdown."""
        come: queue.SimpleQueue[Any] = queue.SimpleQueue()
        reader = threading.Thread(target=self._read, args=(come,), name="language server input", daemon=True)
        reader.start()
        while not self._ended:
            if self._due and come.empty():
                self._publish(next(iter(self._due)))
                continue
            message = come.get()
            if message is None:
                break
            self._handle(message)
        reader.join()
        return self._code

    def _read(self, come: queue.SimpleQueue[Any]) -> None:
        while True:
            try:
                message = self._channel.read()
            except ValueError as error:
                self._answer_error(None, _PARSE_ERROR, f"this is no JSON: {error}")
                continue
            except (ChannelError, OSError):
                message = None
            come.put(message)
            if message is None or (isinstance(message, dict) and message.get("method") == "exit"):
                return

    # Messages.

    def _handle(self, message: Any) -> None:  # noqa: ANN401 JSON
        method = message.get("method") if isinstance(message, dict) else None
        if not isinstance(method, str):
            if not isinstance(message, dict) or ("result" not in message and "error" not in message):
                self._answer_error(None, _INVALID_REQUEST, "a message has a method")
            return
        parameters = message.get("params")
        given = parameters if isinstance(parameters, dict) else {}
        if "id" not in message:
            self._notified(method, given)
            return
        try:
            result = self._requested(method, given)
        except Refused as error:
            self._answer_error(message["id"], error.code, str(error))
        except Exception as error:  # the editor goes on with its other requests
            self._answer_error(message["id"], _INTERNAL, _log(method, error))
        else:
            self._channel.send({"jsonrpc": "2.0", "id": message["id"], "result": result})

    def _answer_error(self, number: Any, code: int, told: str) -> None:  # noqa: ANN401 JSON
        self._channel.send({"jsonrpc": "2.0", "id": number, "error": {"code": code, "message": told}})

    def _requested(self, method: str, given: Mapping[str, Any]) -> Any:  # noqa: ANN401 JSON
        if method == "initialize":
            if self._initialized:
                raise Refused(_INVALID_REQUEST, "the server is initialized already")
            self._initialized = True
            return _capabilities()
        if not self._initialized:
            raise Refused(_NOT_INITIALIZED, f"{method} comes before initialize")
        if self._code == 0:
            raise Refused(_INVALID_REQUEST, f"{method} comes after shutdown")
        if method == "shutdown":
            self._code = 0
            return None
        if method not in self._requests:
            raise Refused(_METHOD_NOT_FOUND, f"there is no request {method!r}")
        return self._requests[method](given)

    def _notified(self, method: str, given: Mapping[str, Any]) -> None:
        if method == "exit":
            self._ended = True
        elif self._initialized and method in self._notices:
            try:
                self._notices[method](given)
            except Exception as error:  # a notification has no answer
                self._tell_log(_log(method, error))

    def _tell_log(self, told: str) -> None:
        self._channel.send({"jsonrpc": "2.0", "method": "window/logMessage", "params": {"type": 1, "message": told}})

    # Texts.

    def _opened(self, given: Mapping[str, Any]) -> None:
        one = given["textDocument"]
        uri = str(one["uri"])
        language = _language(str(one.get("languageId", "")), uri)
        if language is not None:
            self._take(uri, language, one.get("version"), str(one["text"]))

    def _changed(self, given: Mapping[str, Any]) -> None:
        one = given["textDocument"]
        before = self._documents[str(one["uri"])]
        self._take(before.uri, before.language, one.get("version"), str(given["contentChanges"][-1]["text"]))

    def _take(self, uri: str, language: Language, version: int | None, text: str) -> None:
        source = Source(text, _file(uri))
        self._documents[uri] = Document(uri, language, version, source, Positions(source))
        self._renew(uri)

    def _closed(self, given: Mapping[str, Any]) -> None:
        uri = str(given["textDocument"]["uri"])
        if self._documents.pop(uri, None) is not None:
            self._analyses.pop(uri, None)
            self._due.pop(uri, None)
            self._tell(uri, None, [])
            self._renew(uri)

    def _files_changed(self, given: Mapping[str, Any]) -> None:
        for one in given["changes"]:
            self._renew(str(one["uri"]))

    def _renew(self, uri: str) -> None:
        """Have a text checked, and those beside it."""
        folder = Path(_file(uri)).parent
        for other in self._documents.values():
            if other.uri == uri or (other.language.beside and Path(other.source.file).parent == folder):
                self._analyses.pop(other.uri, None)
                self._due[other.uri] = None

    def _beside(self, document: Document) -> list[Source]:
        """Return the other sources of a text's folder; of one that is open, as it is there."""
        if not document.language.beside:
            return []
        path = Path(document.source.file)
        found = {
            one.source.file: one.source
            for one in self._documents.values()
            if one.uri != document.uri
            and one.language is document.language
            and Path(one.source.file).parent == path.parent
        }
        if self._reads_files and document.uri.startswith("file:"):
            try:
                files = sorted(one for one in path.parent.iterdir() if one.suffix.lower() in document.language.endings)
            except OSError:
                files = []
            for file in files[:MOST_BESIDE]:
                if file != path and str(file) not in found and (source := self._read_file(file)) is not None:
                    found[str(file)] = source
        return list(found.values())

    def _read_file(self, file: Path) -> Source | None:
        """Return the text of a file, as long as that stays the same; None where it can't be read or is too large."""
        try:
            state = file.stat()
            stamp = (state.st_mtime_ns, state.st_size)
            if state.st_size > LARGEST_BESIDE:
                return None
            if file not in self._files or self._files[file][0] != stamp:
                self._files[file] = (stamp, Source(decoded(file.read_bytes()), str(file)))
        except OSError:
            return None
        return self._files[file][1]

    def _analysis(self, document: Document) -> Analysis:
        if document.uri not in self._analyses:
            self._analyses[document.uri] = document.language.analyze(document.source, self._beside(document))
        return self._analyses[document.uri]

    def _publish(self, uri: str) -> None:
        """Check a text, and tell what is wrong in it."""
        del self._due[uri]
        document = self._documents[uri]
        try:
            diagnostics = self._analysis(document).diagnostics
        except Exception as error:  # other texts are served still
            self._tell_log(_log(f"check of {uri}", error))
            return
        found = [
            {
                "range": document.positions.word(one.line, one.column),
                "severity": 1,
                "source": document.language.name,
                "message": one.message,
            }
            for one in diagnostics
        ]
        self._tell(uri, document.version, found)

    def _tell(self, uri: str, version: int | None, found: list[dict[str, Any]]) -> None:
        told: dict[str, Any] = {"uri": uri, "diagnostics": found}
        if version is not None:
            told["version"] = version
        self._channel.send({"jsonrpc": "2.0", "method": "textDocument/publishDiagnostics", "params": told})

    # Requests.

    def _document(self, given: Mapping[str, Any]) -> Document:
        try:
            uri = str(given["textDocument"]["uri"])
        except (KeyError, TypeError):
            raise Refused(_INVALID_PARAMS, "the parameters have a 'textDocument' with its 'uri'") from None
        if uri not in self._documents:
            raise Refused(_INVALID_PARAMS, f"no text {uri!r} is open in one of the languages that are served")
        return self._documents[uri]

    def _at(self, given: Mapping[str, Any], document: Document) -> int:
        """Return the place that a request is about."""
        try:
            return document.positions.place(given["position"])
        except (KeyError, TypeError, ValueError):
            raise Refused(_INVALID_PARAMS, "the parameters have a 'position' with 'line' and 'character'") from None

    def _hover(self, given: Mapping[str, Any]) -> Any:  # noqa: ANN401 JSON
        document = self._document(given)
        told = self._analysis(document).hover(self._at(given, document))
        return {"contents": {"kind": "markdown", "value": told}} if told else None

    def _definition(self, given: Mapping[str, Any]) -> Any:  # noqa: ANN401 JSON
        document = self._document(given)
        found = self._analysis(document).definition(self._at(given, document))
        if found is None:
            return None
        if found.source is document.source:
            return {"uri": document.uri, "range": document.positions.range(found.begin, found.end)}
        opened = [one.uri for one in self._documents.values() if one.source is found.source]
        uri = opened[0] if opened else Path(found.source.file).as_uri()
        return {"uri": uri, "range": Positions(found.source).range(found.begin, found.end)}

    def _completion(self, given: Mapping[str, Any]) -> Any:  # noqa: ANN401 JSON
        document = self._document(given)
        items = []
        for one in self._analysis(document).completion(self._at(given, document)):
            item: dict[str, Any] = {"label": one.label, "kind": int(one.kind)}
            if one.detail:
                item["detail"] = one.detail
            if one.told:
                item["documentation"] = one.told
            items.append(item)
        return {"isIncomplete": False, "items": items}

    def _symbols(self, given: Mapping[str, Any]) -> Any:  # noqa: ANN401 JSON
        document = self._document(given)
        return [symbol_message(one, document.positions) for one in self._analysis(document).symbols()]

    def _formatting(self, given: Mapping[str, Any]) -> Any:  # noqa: ANN401 JSON
        document = self._document(given)
        try:
            text = document.language.formatted(document.source)
        except ProgramError as error:
            first = replace(error.diagnostics[0], file=Path(document.source.file).name)
            raise Refused(_REQUEST_FAILED, f"a text with faults is left as it is: {first}") from error
        return [] if text == document.source.text else [{"range": document.positions.whole(), "newText": text}]


def _log(method: str, error: Exception) -> str:
    """Return what is told of a fault of the server itself, whose traceback goes to standard error."""
    traceback.print_exception(error)
    return f"{method}: {type(error).__name__}: {error}"


def symbol_message(one: Symbol, positions: Positions) -> dict[str, Any]:
    """Return a symbol as the protocol has it."""
    name_end = one.name_begin + len(one.name)
    found: dict[str, Any] = {
        "name": one.name,
        "kind": int(one.kind),
        "range": positions.range(one.begin, max(one.end, name_end)),  # it has the name, in a broken text, too
        "selectionRange": positions.range(one.name_begin, name_end),
        "children": [symbol_message(inner, positions) for inner in one.within],
    }
    if one.detail:
        found["detail"] = one.detail
    return found


def _capabilities() -> dict[str, Any]:
    try:
        own = version("virtualrobot")
    except PackageNotFoundError:
        own = "unknown"
    return {
        "capabilities": {
            "positionEncoding": "utf-16",
            "textDocumentSync": {"openClose": True, "change": 1},
            "hoverProvider": True,
            "definitionProvider": True,
            "completionProvider": {"triggerCharacters": [".", "\\"]},
            "documentSymbolProvider": True,
            "documentFormattingProvider": True,
        },
        "serverInfo": {"name": "virtualrobot", "version": own},
    }


def _language(name: str, uri: str) -> Language | None:
    """Return a language by its name, or by the ending of a file; None where none is served."""
    suffix = Path(_file(uri)).suffix.lower()
    return next(
        (one for one in LANGUAGES if one.name == name.lower()),
        next((one for one in LANGUAGES if suffix in one.endings), None),
    )


def _file(uri: str) -> str:
    """Return the file of a URI; of one that is no file itself."""
    parsed = urlparse(uri)
    return url2pathname(parsed.path) if parsed.scheme == "file" else uri

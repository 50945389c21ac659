"""Xacro files expanded to URDF by the library xacro, which is kept from the disk: every file comes from the caller."""

from __future__ import annotations

import io
import os
import posixpath
import threading
import xml.dom.minidom
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, field
from difflib import get_close_matches
from types import ModuleType
from typing import Annotated, Any
from xml.parsers.expat import ExpatError

import xacro
from msgspec import Meta
from virtualrobot_sdk.errors import ArgumentError, FilesNeeded
from virtualrobot_sdk.importers import Translation
from xacro import substitution_args

from virtualrobot_plugins.importers.uris import join_uri

_OLD_WORDS = ("include", "property", "macro", "if", "unless")

_ONE_AT_A_TIME = threading.Lock()
"""The library keeps its state in module variables."""


@dataclass(frozen=True, slots=True)
class XacroSettings:
    """Settings of the xacro importer.

    Attributes:
        arguments: values of the file's `<xacro:arg>`, by name.
    """

    arguments: Annotated[Mapping[str, str], Meta(description="Values of the file's <xacro:arg>, by name.")] = field(
        default_factory=dict
    )


class Xacro:
    """Reads xacro files: macros, properties, conditions and includes become one plain URDF."""

    def __init__(self, settings: XacroSettings) -> None:
        """Take the values of the file's arguments."""
        self.settings = settings

    def translate(self, data: bytes, uri: str, files: Mapping[str, bytes | None], /) -> Translation:
        """Return the URDF that a xacro file expands to.

        Names of files are joined to the file that names them; `$(find package)/x` is asked for as `package://package/x`
        and stays so in the URDF. `$(env NAME)` and `$(optenv NAME default)` read the environment of this process,
        `$(cwd)` is the folder of the main file.

        Raises:
            FilesNeeded: for a file that is included or loaded and not in `files`.
            ArgumentError: for whatever xacro refuses, with the file that it was in, the macro that it was in, and the
                line where it is not XML. `missing` in the metadata names an included file that is nowhere.
        """
        run = _Run(uri, files)
        with _ONE_AT_A_TIME, _library(run):
            text = run.expand(data, self.settings.arguments)
        # Written by `file://$(find package)/x`, as many models do for simulators that know no packages.
        return Translation(".urdf", text.replace("file://package://", "package://").encode(), run.warnings())


class _Missing(OSError):
    """A file that is nowhere; an OSError, since xacro passes over those in an optional include."""


class _Arguments(dict[str, str]):
    """Values of arguments, which notes the names that the file declares: xacro asks for each whether it has a value."""

    def __init__(self, values: Mapping[str, str]) -> None:
        super().__init__(values)
        self.declared: dict[str, None] = {}

    def __contains__(self, name: object) -> bool:
        self.declared[str(name)] = None
        return super().__contains__(name)


class _Run:
    """One expansion: what takes the place of the library's access to disk and console."""

    def __init__(self, uri: str, files: Mapping[str, bytes | None]) -> None:
        self.uri = uri
        self.files = files
        self._warnings: dict[str, None] = {}

    def expand(self, data: bytes, arguments: Mapping[str, str]) -> str:
        """Return the document as it is after all macros; the library is ours meanwhile."""
        given = _Arguments(arguments)
        xacro.init_stacks(self.uri)
        try:
            document = self._parsed(data)
            xacro.process_doc(document, mappings=given)
        except FilesNeeded:
            raise
        except Exception as error:  # expressions of a file may run into anything
            if (needed := _caused_by(error, FilesNeeded)) is not None:
                raise needed from None
            raise self._refusal(error) from error
        for name in arguments.keys() - given.declared.keys():
            near = get_close_matches(name, given.declared, n=1)
            meant = f"; did you mean {near[0]!r}?" if near else f"; it has {', '.join(given.declared) or 'none'}"
            self.warn(f"the file has no argument {name!r}{meant}")
        return document.toprettyxml(indent="  ")  # line by line as the command xacro prints it

    def warnings(self) -> tuple[str, ...]:
        """Return what the library warned of, each once."""
        return tuple(self._warnings)

    def warn(self, *words: object, **_: object) -> str:
        """Note a warning; the empty text is for expressions that warn."""
        self._warnings[f"{posixpath.basename(self._file())}: {' '.join(map(str, words))}"] = None
        return ""

    def open(self, name: str, *_: object) -> io.BytesIO:
        """Return the content of a file whose name is joined already."""
        if name not in self.files:
            raise FilesNeeded([name])
        content = self.files[name]
        if content is None:
            raise _Missing(2, "there is no such file", name)
        return io.BytesIO(content)

    def parse(self, _: None, name: str) -> xml.dom.minidom.Document:
        """Return an included file, which is on the library's stack of files by now."""
        try:
            data = self.open(name).getvalue()
        except _Missing as error:
            xacro.filestack.pop()
            raise xacro.XacroException(exc=error) from error
        return self._parsed(data)

    def join(self, name: str) -> str:
        """Return a name joined to that of the file that is being read."""
        return join_uri(self._file(), name)

    def folder(self, _: object = None) -> str:
        """Return the folder of the file that is being read."""
        return self._file().replace("\\", "/").rpartition("/")[0] or "."

    def extension(self, text: str) -> str:
        """Return what `$(...)` stands for."""
        if text == "$(cwd)":
            return self.uri.replace("\\", "/").rpartition("/")[0] or "."
        try:
            return substitution_args.resolve_args(text, context=xacro.substitution_args_context)
        except substitution_args.ArgException as error:
            raise xacro.XacroException(
                f"{text}: no argument of that name is declared or given; there are "
                f"{', '.join(sorted(xacro.substitution_args_context['arg'])) or 'none'}"
            ) from error
        except substitution_args.SubstitutionException as error:
            raise xacro.XacroException(f"{text}: {error}") from error

    @staticmethod
    def refuse_pattern(pattern: str) -> list[str]:
        """Refuse an include by wildcards: which files there are, only the disk knows."""
        raise xacro.XacroException(f"{pattern!r} has wildcards: name the files one by one")

    def _parsed(self, data: bytes) -> xml.dom.minidom.Document:
        """Return a document in which the words of xacro have their prefix.

        Files from before 2014 (ROS Jade) leave it out; what stands in the root of a robot is xacro's or URDF's, so
        there it can be told.
        """
        document = xml.dom.minidom.parseString(data.lstrip())
        root: Any = document.documentElement
        for element in list(root.childNodes):
            if element.nodeName in _OLD_WORDS:
                self.warn(f"<{element.nodeName}> without the prefix xacro: is read as <xacro:{element.nodeName}>")
                element.tagName = element.nodeName = f"xacro:{element.nodeName}"
        return document

    def _file(self) -> str:
        return (xacro.filestack or [self.uri])[-1] or self.uri

    def _refusal(self, error: Exception) -> ArgumentError:
        file, parse_error = posixpath.basename(self._file()), _caused_by(error, ExpatError)
        if isinstance(parse_error, ExpatError):
            return ArgumentError(f"{file}:{parse_error.lineno}: not XML: {parse_error}", file=self._file())
        text = str(error).replace(os.linesep, " ").strip() or repr(error)
        macros = " in ".join(str(macro.body.getAttribute("name")) for macro in reversed(xacro.macrostack or []))
        included = "".join(f", included by {posixpath.basename(name)}" for name in reversed(xacro.filestack[:-1]))
        place = f"{file}{included}" + (f": in macro {macros}" if macros else "")
        metadata = {"file": self._file()}
        if (missing := _caused_by(error, _Missing)) is not None:
            metadata["missing"] = text = str(missing.filename)
            text = f"{text!r} is nowhere"
        return ArgumentError(f"{place}: {text}", **metadata)


def _caused_by(error: BaseException | None, kind: type) -> Any:  # noqa: ANN401  an exception of that kind, or None
    """Return the first exception of a kind among an exception and what it was made of."""
    while error is not None and not isinstance(error, kind):
        error = getattr(error, "exc", None) or error.__cause__ or error.__context__
    return error


@contextmanager
def _library(run: _Run) -> Iterator[None]:
    """Give the library's module variables to one run, and put them back as they were."""
    before: list[tuple[ModuleType, str, Any]] = []

    def put(module: ModuleType, name: str, value: object) -> None:
        before.append((module, name, module.__dict__.get(name, _ABSENT)))
        setattr(module, name, value)

    def quiet(name: str, function: Callable[..., object]) -> Callable[..., object]:
        def call(*words: object, **options: object) -> object:
            return function(*words, **options)

        call.__name__ = name  # under which expressions find it
        return call

    try:
        put(xacro, "open", run.open)
        put(xacro, "parse", run.parse)
        put(xacro, "abs_filename_spec", run.join)
        put(xacro, "eval_extension", run.extension)
        put(xacro, "glob", _Glob(run))
        put(xacro, "warning", quiet("warning", run.warn))
        put(xacro, "error", quiet("error", run.warn))
        put(xacro, "message", quiet("message", _nothing))
        put(xacro, "print_location", quiet("print_location", _nothing))
        put(substitution_args, "_eval_find", _find)
        put(substitution_args, "_eval_dirname", run.folder)
        put(substitution_args, "_eval_dict", {**substitution_args._eval_dict, "find": _find})
        # One node that the library moves from document to document, and with it keeps the last document in memory.
        put(xacro, "_empty_text_node", xml.dom.minidom.Document().createTextNode("\n\n"))
        put(xacro, "_global_symbols", xacro.create_global_symbols())
        for name in ("filestack", "macrostack"):
            put(xacro, name, None)
        put(xacro, "all_includes", [])
        put(xacro, "substitution_args_context", {})
        yield
    finally:
        for module, name, value in reversed(before):
            if value is _ABSENT:
                delattr(module, name)
            else:
                setattr(module, name, value)


_ABSENT = object()


@dataclass(frozen=True, slots=True)
class _Glob:
    """Stands for the module `glob`."""

    run: _Run

    def glob(self, pattern: str) -> list[str]:
        return self.run.refuse_pattern(pattern)


def _find(package: str) -> str:
    return f"package://{package}"


def _nothing(*_: object, **__: object) -> str:
    return ""

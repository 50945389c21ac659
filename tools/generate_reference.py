"""Write the reference of the contract from its comments: `python tools/generate_reference.py [directory]`.

Each proto file becomes one page of docs/reference: its services and calls, then its messages and enums, every one with
the words that stand above it in the proto file. The page of errors.proto also says which Python exception a reason
becomes.
"""

from __future__ import annotations

import subprocess
import sys
import tempfile
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from pathlib import Path

from generate_stubs import PROTO, ROOT, generator_python
from google.protobuf.descriptor_pb2 import (
    DescriptorProto,
    EnumDescriptorProto,
    FieldDescriptorProto,
    FileDescriptorProto,
    FileDescriptorSet,
    ServiceDescriptorProto,
)
from virtualrobot.errors import BY_REASON
from virtualrobot.v1 import lease_pb2, token_pb2

REFERENCE = ROOT / "docs" / "reference"
PACKAGE = "virtualrobot.v1"
NOTE = "<!-- Written by tools/generate_reference.py from {source}; change the comments there, not this page. -->"

WELL_KNOWN = {
    "google.protobuf.Struct": "https://protobuf.dev/reference/protobuf/google.protobuf/#struct",
    "google.protobuf.FieldMask": "https://protobuf.dev/reference/protobuf/google.protobuf/#field-mask",
    "google.protobuf.Timestamp": "https://protobuf.dev/reference/protobuf/google.protobuf/#timestamp",
}

# Where the parts of a file are in the paths of its source info (descriptor.proto: FileDescriptorProto and below it).
SYNTAX, MESSAGE, ENUM, SERVICE = 12, 4, 5, 6
PART = 2  # fields of a message, values of an enum, methods of a service


@dataclass
class Page:
    """One proto file: what it declares, and the comment of each declaration by its path."""

    file: FileDescriptorProto
    comments: dict[tuple[int, ...], str] = field(default_factory=dict)

    @property
    def name(self) -> str:
        """Return the file name of the page."""
        return f"{Path(self.file.name).stem}.md"

    @property
    def title(self) -> str:
        """Return the name of the page's service, or of its proto file."""
        return self.file.service[0].name if self.file.service else Path(self.file.name).name

    def comment(self, *path: int) -> str:
        """Return the comment above a declaration as one line; raise ValueError when there is none."""
        if path not in self.comments:
            raise ValueError(f"{self.file.name}: the declaration at {path} has no comment")
        return self.comments[path]


def descriptors() -> FileDescriptorSet:
    """Return what the contract declares, comments included."""
    sources = sorted(str(path.relative_to(PROTO)) for path in PROTO.rglob("*.proto"))
    with tempfile.TemporaryDirectory() as folder:
        image = Path(folder) / "image.bin"
        options = [f"--proto_path={PROTO}", "--include_source_info", f"--descriptor_set_out={image}"]
        subprocess.run([generator_python(), "-m", "grpc_tools.protoc", *options, *sources], check=True)
        return FileDescriptorSet.FromString(image.read_bytes())


def page_of(file: FileDescriptorProto) -> Page:
    """Return a file with its comments, each on one line; paragraphs stay apart."""
    comments = {}
    for location in file.source_code_info.location:
        # Above `syntax` stands the comment of the file; a blank line may set it apart from the line itself.
        text = location.leading_comments or "\n\n".join(location.leading_detached_comments)
        if text:
            paragraphs = text.strip().split("\n\n")
            comments[tuple(location.path)] = "\n\n".join(" ".join(part.split()) for part in paragraphs)
    return Page(file, comments)


def reference(files: Sequence[FileDescriptorProto]) -> dict[str, str]:
    """Return the text of each page by file name."""
    pages = [page_of(file) for file in files]
    homes: dict[str, str] = {}
    for page in pages:
        for thing in (*page.file.message_type, *page.file.enum_type):
            homes[f".{PACKAGE}.{thing.name}"] = page.name
    texts = {page.name: "\n".join(text_of(page, homes)) for page in pages}
    return {**texts, "README.md": "\n".join(index_of(pages))}


def index_of(pages: Sequence[Page]) -> Iterator[str]:
    """Yield the lines of the page that lists all others."""
    yield NOTE.format(source="proto/virtualrobot/v1")
    yield "# Reference of the contract\n"
    yield f"Every call, message, field and value of `{PACKAGE}`, with the words of the proto files.\n"
    yield "Units, frames, names, revisions and time are explained once, in [conventions](../conventions.md).\n"
    yield "| service | what for | calls |\n|---|---|---|"
    for page in pages:
        for at, service in enumerate(page.file.service):
            calls = ", ".join(f"[{method.name}]({page.name}#{anchor(method.name)})" for method in service.method)
            yield f"| [{service.name}]({page.name}) | {cell(page.comment(SERVICE, at))} | {calls} |"
    yield "\n| shared by the services | what it holds |\n|---|---|"
    for page in pages:
        if not page.file.service:
            things = (thing.name for thing in (*page.file.message_type, *page.file.enum_type))
            yield f"| [{page.title}]({page.name}) | {', '.join(f'`{name}`' for name in things)} |"
    yield ""


def text_of(page: Page, homes: dict[str, str]) -> Iterator[str]:
    """Yield the lines of one page."""
    file = page.file
    yield NOTE.format(source=f"proto/{file.name}")
    yield f"# {page.title}\n"
    yield f"{page.comment(SYNTAX)}\n"
    for at, service in enumerate(file.service):
        yield from service_lines(page, at, service, homes)
    yield "## Messages and enums\n"
    for at, message in enumerate(file.message_type):
        yield from message_lines(page, at, message, homes)
    for at, enum in enumerate(file.enum_type):
        yield from (error_lines if enum.name == "ErrorReason" else enum_lines)(page, at, enum)


def service_lines(page: Page, at: int, service: ServiceDescriptorProto, homes: dict[str, str]) -> Iterator[str]:
    """Yield a section for each call of a service."""
    yield f"## Calls\n\n{page.comment(SERVICE, at)}\n"
    for place, method in enumerate(service.method):
        given = ("stream of " if method.client_streaming else "") + link(method.input_type, homes)
        answer = ("stream of " if method.server_streaming else "") + link(method.output_type, homes)
        yield f"### {method.name}\n\n{page.comment(SERVICE, at, PART, place)}\n"
        yield f"`/{PACKAGE}.{service.name}/{method.name}`: {given} → {answer}\n"
        role = role_of(method.options.Extensions[token_pb2.needs_role])  # pyright: ignore[reportArgumentType] its stub
        yield f"For the [role](../access.md) {role} and those above it.\n"
        if method.options.Extensions[lease_pb2.needs_lease]:  # pyright: ignore[reportArgumentType] its stub
            yield "Robots that somebody has leased are touched [with that lease](lease.md) only.\n"


def role_of(number: int) -> str:
    """Return a role as people say it."""
    return token_pb2.Role.Name(number).removeprefix("ROLE_").lower()


def message_lines(page: Page, at: int, message: DescriptorProto, homes: dict[str, str]) -> Iterator[str]:
    """Yield the section of a message: a row for each field."""
    yield f"### {message.name}\n\n{page.comment(MESSAGE, at)}\n"
    if not message.field:
        yield "No fields.\n"
        return
    entries = {f".{PACKAGE}.{message.name}.{nested.name}": nested for nested in message.nested_type}
    yield "| field | type | meaning |\n|---|---|---|"
    for place, entry in enumerate(message.field):
        words = cell(page.comment(MESSAGE, at, PART, place))
        needed = entry.options.Extensions[token_pb2.command_needs_role]  # pyright: ignore[reportArgumentType] its stub
        words += f" For the role {role_of(needed)}." if needed else ""
        if entry.HasField("oneof_index") and not entry.proto3_optional:
            oneof = message.oneof_decl[entry.oneof_index].name
            words += f" (One of `{oneof}`.)"
        yield f"| `{entry.name}` | {type_of(entry, entries, homes)} | {words} |"
    yield ""


def enum_lines(page: Page, at: int, enum: EnumDescriptorProto) -> Iterator[str]:
    """Yield the section of an enum: a row for each value."""
    yield f"### {enum.name}\n\n{page.comment(ENUM, at)}\n"
    yield "| value | number | meaning |\n|---|---|---|"
    for place, value in enumerate(enum.value):
        yield f"| `{value.name}` | {value.number} | {cell(page.comment(ENUM, at, PART, place))} |"
    yield ""


def error_lines(page: Page, at: int, enum: EnumDescriptorProto) -> Iterator[str]:
    """Yield the section of the reasons: gRPC's code, which each comment begins with, and the Python exception."""
    yield f"### {enum.name}\n\n{page.comment(ENUM, at)}\n"
    yield "In Python each is an exception of `virtualrobot`, below `virtualrobot.VirtualRobotError`.\n"
    yield "| reason | number | gRPC code | Python exception | meaning |\n|---|---|---|---|---|"
    for place, value in enumerate(enum.value):
        code, colon, words = cell(page.comment(ENUM, at, PART, place)).partition(": ")
        if not colon:
            yield f"| `{value.name}` | {value.number} | | | {code} |"
            continue
        exception = BY_REASON[value.name.removeprefix("ERROR_REASON_")].__name__
        yield f"| `{value.name}` | {value.number} | `{code}` | `{exception}` | {words[0].upper()}{words[1:]} |"
    yield ""


def type_of(entry: FieldDescriptorProto, entries: dict[str, DescriptorProto], homes: dict[str, str]) -> str:
    """Return the type of a field in words, with a link where it is one of ours."""
    if entry.type_name in entries:
        key, value = entries[entry.type_name].field
        return f"map from {type_of(key, {}, homes)} to {type_of(value, {}, homes)}"
    scalar = FieldDescriptorProto.Type.Name(entry.type).removeprefix("TYPE_").lower()
    name = link(entry.type_name, homes) if entry.type_name else f"`{scalar}`"
    if entry.label == FieldDescriptorProto.LABEL_REPEATED:
        return f"list of {name}"
    return f"optional {name}" if entry.proto3_optional else name


def link(type_name: str, homes: dict[str, str]) -> str:
    """Return a link to where a message or enum is described."""
    name = type_name.removeprefix(".")
    if name in WELL_KNOWN:
        return f"[`{name}`]({WELL_KNOWN[name]})"
    short = name.removeprefix(f"{PACKAGE}.")
    return f"[`{short}`]({homes[type_name]}#{anchor(short)})"


def anchor(heading: str) -> str:
    """Return the anchor of a heading that is one word."""
    return heading.lower()


def cell(text: str) -> str:
    """Return text that fits one cell of a table."""
    return text.replace("\n\n", " ").replace("|", "\\|")


def main() -> None:
    """Write the pages into docs/reference, or into the directory that the command line names."""
    output = Path(sys.argv[1]).resolve() if len(sys.argv) > 1 else REFERENCE
    files = (file for file in descriptors().file if file.package == PACKAGE)
    pages = reference(sorted(files, key=lambda file: file.name))
    output.mkdir(parents=True, exist_ok=True)
    for old in output.glob("*.md"):
        old.unlink()
    for name, text in pages.items():
        (output / name).write_text(text, encoding="utf-8", newline="\n")
    print(f"{len(pages)} pages written below {output}")


if __name__ == "__main__":
    main()

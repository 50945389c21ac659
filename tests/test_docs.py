"""What the documentation says is there: reference, links, rooms, commands and targets. Snippets: tests/api."""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path
from urllib.parse import unquote

import click
import pytest
from google.protobuf.descriptor import Descriptor, FileDescriptor
from virtualrobot.cli import cli
from virtualrobot.cli.options import target_options
from virtualrobot.errors import VirtualRobotError
from virtualrobot.v1 import (
    asset_pb2,
    collision_pb2,
    errors_pb2,
    geometry_pb2,
    history_pb2,
    kernel_pb2,
    lease_pb2,
    motion_pb2,
    nodes_pb2,
    path_pb2,
    plugin_pb2,
    proposal_pb2,
    ray_pb2,
    record_pb2,
    robot_pb2,
    scene_pb2,
    sensing_pb2,
    sensor_pb2,
    signal_pb2,
    token_pb2,
    view_pb2,
)
from virtualrobot_kernel.api.status import CODES
from virtualrobot_kernel.serve import _parser, _replay_parser
from virtualrobot_sdk.testing.grade import command as grade

ROOT = Path(__file__).resolve().parent.parent
REFERENCE = ROOT / "docs" / "reference"
KERNEL = ROOT / "kernel" / "virtualrobot_kernel"
PAGES = (*sorted(ROOT.glob("[CR]*.md")), *sorted((ROOT / "docs").rglob("*.md")))
MODULES = (
    asset_pb2,
    collision_pb2,
    errors_pb2,
    geometry_pb2,
    history_pb2,
    kernel_pb2,
    lease_pb2,
    motion_pb2,
    nodes_pb2,
    path_pb2,
    plugin_pb2,
    proposal_pb2,
    ray_pb2,
    record_pb2,
    robot_pb2,
    scene_pb2,
    sensing_pb2,
    sensor_pb2,
    signal_pb2,
    token_pb2,
    view_pb2,
)
FENCED = re.compile(r"^(```|~~~).*?^\1", re.MULTILINE | re.DOTALL)
LINK = re.compile(r"!?\[[^\]]*\]\(<?([^)\s>]+)>?[^)]*\)")


def prose(page: Path) -> str:
    """Return the text of a page without its fenced blocks."""
    return FENCED.sub("", page.read_text("utf-8"))


def anchors(page: Path) -> set[str]:
    """Return the anchors that GitHub gives to the headings of a page."""
    found: set[str] = set()
    for heading in re.findall(r"^#+ +(.+?) *$", prose(page), re.MULTILINE):
        words = re.sub(r"\[([^\]]*)\]\([^)]*\)", r"\1", heading).lower()
        stem = re.sub(r"[^\w\- ]", "", words).replace(" ", "-")
        number, anchor = 0, stem
        while anchor in found:
            number += 1
            anchor = f"{stem}-{number}"
        found.add(anchor)
    return found


def broken_links(page: Path) -> Iterator[str]:
    """Yield each link of a page whose file or heading is not there; addresses on the web are not visited."""
    for target in LINK.findall(prose(page)):
        if re.match(r"[a-z]+:", target):
            continue
        path, _, anchor = target.partition("#")
        file = page if not path else (page.parent / unquote(path)).resolve()
        if not file.exists():
            yield f"{target}: no such file"
        elif anchor and anchor not in anchors(file):
            yield f"{target}: no such heading; there are {', '.join(sorted(anchors(file)))}"


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.relative_to(ROOT).as_posix())
def test_links_lead_somewhere(page: Path) -> None:
    assert list(broken_links(page)) == []


def test_a_planted_broken_link_is_found(tmp_path: Path) -> None:
    (tmp_path / "other.md").write_text("# One: `two` three\n\n```sh\n# no heading\n```\n")
    page = tmp_path / "page.md"
    page.write_text("# Here\n[a](other.md#one-two-three) [b](#here) [c](https://x.org/#y) ![d](none.png)\n")
    assert list(broken_links(page)) == ["none.png: no such file"]
    page.write_text("[a](other.md#no-heading)")
    assert list(broken_links(page)) == ["other.md#no-heading: no such heading; there are one-two-three"]


def test_the_page_of_a_package_index_links_to_nothing_beside_it() -> None:
    assert LINK.findall(prose(ROOT / "docs" / "package-index.md")) == []


def test_every_page_is_reached_from_the_readme() -> None:
    reached, waiting = set(), [ROOT / "README.md"]
    while waiting:
        page = waiting.pop()
        if page in reached or page.suffix != ".md" or not page.exists():
            continue
        reached.add(page)
        targets = (target.partition("#")[0] for target in LINK.findall(prose(page)) if ":" not in target)
        waiting.extend((page.parent / target).resolve() for target in targets if target)
    assert sorted(set(PAGES) - reached - {ROOT / "CHANGELOG.md"}) == []


@pytest.mark.parametrize("file", [module.DESCRIPTOR for module in MODULES], ids=lambda file: Path(file.name).stem)
def test_reference_names_everything(file: FileDescriptor) -> None:
    """Compared with the stubs, which another program makes of the same proto files."""
    text = (REFERENCE / f"{Path(file.name).stem}.md").read_text("utf-8")
    missing = [
        f"/{service.full_name}/{method.name}"
        for service in file.services_by_name.values()
        for method in service.methods
        if f"`/{service.full_name}/{method.name}`: " not in text
    ]
    things = {**file.message_types_by_name, **file.enum_types_by_name}
    for name, thing in things.items():
        section = text.partition(f"### {name}\n")[2].partition("\n### ")[0]
        members = thing.fields if isinstance(thing, Descriptor) else thing.values
        missing += [name] if not section else []
        missing += [f"{name}.{one.name}" for one in members if f"| `{one.name}` |" not in section]
    assert things
    assert missing == []


def test_reference_tells_the_codes_that_the_kernel_sends() -> None:
    rows = re.findall(
        r"^\| `ERROR_REASON_(\w+)` \| \d+ \| `(\w+)` ", (REFERENCE / "errors.md").read_text(), re.MULTILINE
    )
    assert dict(rows) == {reason.name: code.name for reason, code in CODES.items()}


def test_the_scene_file_is_described() -> None:
    text = (ROOT / "docs" / "scene-file.md").read_text("utf-8")
    fields = [field.name for field in scene_pb2.SceneFile.DESCRIPTOR.fields]
    assert re.findall(r"^\| `(\w+)` \|", text, re.MULTILINE) == fields
    kinds = {field.name for field in nodes_pb2.Node.DESCRIPTOR.oneofs_by_name["kind"].fields} - {"world"}
    geometries = {field.name for field in nodes_pb2.Figure.DESCRIPTOR.oneofs_by_name["geometry"].fields}
    assert kinds | geometries <= set(re.findall(r"`(\w+)`", text))


def test_every_exception_of_the_client_is_described() -> None:
    text = "".join((ROOT / "docs" / page).read_text("utf-8") for page in ("reference/errors.md", "tutorial-client.md"))
    assert [error.__name__ for error in VirtualRobotError.__subclasses__() if f"`{error.__name__}`" not in text] == []


def rooms() -> set[str]:
    """Return the packages of the kernel that hold code."""
    return {folder.name for folder in KERNEL.iterdir() if (folder / "__init__.py").exists()}


def test_the_picture_shows_every_room() -> None:
    picture = (ROOT / "docs" / "pictures" / "house.svg").read_text("utf-8")
    assert set(re.findall(r">(\w+)/<", picture)) == rooms()


def test_architecture_has_a_row_for_every_room() -> None:
    text = (ROOT / "docs" / "architecture.md").read_text("utf-8")
    assert [room for room in sorted(rooms()) if f"\n| `{room}/` |" not in text] == []


def test_files_that_the_architecture_names_are_there() -> None:
    """A word in backticks that looks like a source file or a folder is one, below the root or the kernel."""
    text = prose(ROOT / "docs" / "architecture.md")
    named = re.findall(r"`([\w.*-]+(?:/[\w.*-]*)*(?:\.(?:py|proto|svg)|/))`", text)
    assert len(named) > 40
    assert [name for name in named if not any(list(place.glob(name)) for place in (ROOT, KERNEL))] == []


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.relative_to(ROOT).as_posix())
def test_make_targets_that_a_page_names_are_there(page: Path) -> None:
    targets = set(re.findall(r"^([\w-]+):", (ROOT / "Makefile").read_text("utf-8"), re.MULTILINE))
    named = re.findall(r"(?:^|`)make ([a-z][\w-]*)", page.read_text("utf-8"), re.MULTILINE)
    assert [name for name in named if name not in targets] == []


def test_docstrings_open_with_a_noun_or_a_verb() -> None:
    """A docstring that opens with a question word evades what the thing is."""
    evasive = re.compile(r'^ *r?"""(?:What|Where|How|Which|Who|Whose|When|Whether|Why)\b.*', re.MULTILINE)
    files = (file for folder in ("kernel", "plugins", "clients/python") for file in (ROOT / folder).rglob("*.py"))
    told = {file: evasive.findall(file.read_text("utf-8")) for file in files if file.parent.name != "v1"}
    assert {str(file): found for file, found in told.items() if found} == {}


def sections(page: Path) -> dict[str, str]:
    """Return the text below each second-level heading of a page."""
    parts = re.split(r"^## (.+)$", page.read_text("utf-8"), flags=re.MULTILINE)
    return dict(zip(parts[1::2], parts[2::2], strict=True))


def long_options(command: click.Command) -> set[str]:
    """Return the long options of a command and of those below it, but for --help."""
    below = command.commands.values() if isinstance(command, click.Group) else ()
    options = {option for parameter in command.params for option in (*parameter.opts, *parameter.secondary_opts)}
    return {option for option in options if option.startswith("--")}.union(*map(long_options, below)) - {"--help"}


COMMANDS = {name: cli.get_command(click.Context(cli), name) for name in cli.list_commands(click.Context(cli))}
TARGET = long_options(click.command()(target_options(lambda target: None)))


@pytest.mark.parametrize("name", COMMANDS)
def test_command_line_tells_each_option(name: str) -> None:
    """The table of a command names its options and no others; those that say which kernel have their own section."""
    command = COMMANDS[name]
    assert command is not None
    if name == "serve":
        options = {option for action in _parser()._actions for option in action.option_strings} - {"-h", "--help"}
    elif name == "replay":
        options = {option for action in _replay_parser()._actions for option in action.option_strings}
        options -= {"-h", "--help"}
    elif name == "grade":
        options = long_options(grade)
    elif name in ("marker", "new", "repair", "study"):
        options = long_options(command)
    else:
        assert long_options(command) >= TARGET
        options = long_options(command) - TARGET
    table = re.findall(r"^\|([^|]*`--[^|]*)\|", sections(ROOT / "docs" / "command-line.md")[name], re.MULTILINE)
    assert {option for row in table for option in re.findall(r"`(--[\w-]+)", row)} == options


def test_command_line_tells_which_kernel_and_each_command() -> None:
    text = sections(ROOT / "docs" / "command-line.md")
    assert set(re.findall(r"^\| `(--[\w-]+)", text["Which kernel"], re.MULTILINE)) == TARGET
    assert list(text) == ["Which kernel", *COMMANDS, "Commands of your own"]
    contents = re.findall(
        r"^\| \[(\w+)\]\(#\w+\) \|", (ROOT / "docs" / "command-line.md").read_text("utf-8"), re.MULTILINE
    )
    assert contents == list(COMMANDS)
    for name in COMMANDS:
        assert re.search(rf"^\$ virtualrobot {name}\b", text[name], re.MULTILINE), f"{name} has no example"

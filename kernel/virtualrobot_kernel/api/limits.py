"""Limits of a kernel: each with a name, set by `virtualrobot serve --limit NAME=VALUE`, told by GetInfo.

What is over one is refused with its name and its value. The table is the fields of `Limits`; there is no other.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, field, fields
from difflib import get_close_matches
from typing import TYPE_CHECKING

from virtualrobot_kernel.errors import KernelError, Reason
from virtualrobot_kernel.world.commands import ClearWorld, Command, CreateNodes, UpdateNode
from virtualrobot_kernel.world.consistency import MOST_NODES
from virtualrobot_kernel.world.figures import Figure, meshes_of
from virtualrobot_kernel.world.state import Snapshot

if TYPE_CHECKING:
    from virtualrobot_kernel.formats.mesh_library import MeshLibrary

MEBIBYTE = 1024 * 1024
HIGHEST = 2**40
"""Greatest value of a limit that says no other."""


def _limit(default: int, text: str, least: int = 1, most: int = HIGHEST) -> int:
    return field(default=default, metadata={"text": text, "least": least, "most": most})


@dataclass(frozen=True, slots=True)
class Limits:
    """Limits by name, each at least 1."""

    nodes: int = _limit(20_000, "nodes of the world; each change of the tree takes about 10 µs for each", 1, MOST_NODES)
    triangles: int = _limit(20_000_000, "triangles of all meshes in the world, each mesh counted once")
    message_bytes: int = _limit(16 * MEBIBYTE, "bytes of a message to the kernel", 64 * 1024, 2**31 - 1)
    asset_bytes: int = _limit(256 * MEBIBYTE, "bytes of one file")
    assets_bytes: int = _limit(4096 * MEBIBYTE, "bytes of all files together")
    connections: int = _limit(1000, "connections at a time; half of the process's descriptors where those are fewer")
    streams: int = _limit(1000, "streams of one client at a time, such as watches")
    calls_per_second: int = _limit(10_000, "calls and opened streams of one client in a second")

    @staticmethod
    def of(given: Iterable[str]) -> Limits:
        """Return the limits with some set as `NAME=VALUE`; raise KernelError for a name or a value that is none."""
        known = {one.name: one for one in fields(Limits)}
        values: dict[str, int] = {}
        for text in given:
            name, _, value = (part.strip() for part in text.partition("="))
            if name not in known:
                near = get_close_matches(name, known, n=1)
                hint = f"did you mean {near[0]!r}?" if near else f"there are {', '.join(known)}"
                raise KernelError(f"there is no limit named {name!r}; {hint}", reason=Reason.UNKNOWN_NAME, name=name)
            least, most = known[name].metadata["least"], known[name].metadata["most"]
            digits = value.replace("_", "").replace(",", "")
            number = int(digits) if digits.isascii() and digits.isdigit() and len(digits) < 20 else 0
            if not least <= number <= most:
                raise KernelError(
                    f"the limit {name!r} is a whole number from {least:,} to {most:,}, not {value!r}",
                    limit=name,
                    value=value,
                )
            values[name] = number
        return Limits(**values)

    def refusal(self, name: str, asked: int, what: str, reason: Reason = Reason.TOO_LARGE) -> KernelError:
        """Return the error of something that may have as many as a limit allows, and would have `asked`.

        `what` says so, such as "a world may have {limit:,} nodes, not {asked:,}".
        """
        limit = getattr(self, name)
        return KernelError(
            f"{what.format(limit=limit, asked=asked)}: the limit {name!r} of this kernel",
            reason=reason,
            limit_name=name,
            limit=limit,
            asked=asked,
        )

    def check_nodes(self, snapshot: Snapshot, commands: Sequence[Command]) -> None:
        """Raise KernelError when commands would make too many nodes; what they remove one by one stays counted."""
        created = sum(len(command.specs) for command in commands if isinstance(command, CreateNodes))
        if not created:
            return
        cleared = any(isinstance(command, ClearWorld) for command in commands)
        nodes = created + (1 if cleared else len(snapshot.structure.nodes))
        if nodes > self.nodes:
            raise self.refusal("nodes", nodes, "a world may have {limit:,} nodes, not {asked:,}")

    def check_triangles(self, snapshot: Snapshot, commands: Sequence[Command], meshes: MeshLibrary) -> None:
        """Raise KernelError when the meshes of the world and of commands would have too many triangles."""
        new = {mesh for command in commands for mesh in meshes_of(_figures(command))}
        if not new:
            return
        if not any(isinstance(command, ClearWorld) for command in commands):
            new.update(meshes_of(snapshot.structure.figures))
        triangles = sum({meshes.content(mesh): meshes.triangles(mesh) for mesh in new}.values())
        if triangles > self.triangles:
            raise self.refusal(
                "triangles", triangles, "all meshes of a world may have {limit:,} triangles, not {asked:,}"
            )


def _figures(command: Command) -> Iterator[Figure]:
    """Yield the figures that a command gives to nodes."""
    if isinstance(command, CreateNodes):
        yield from (figure for spec in command.specs for figure in spec.figures)
    elif isinstance(command, UpdateNode):
        yield from command.figures or ()


def described() -> list[tuple[str, int, str]]:
    """Return the name, the default and the meaning of each limit."""
    return [(one.name, one.default, one.metadata["text"]) for one in fields(Limits)]  # pyright: ignore[reportReturnType]

"""Options and values that commands share: which kernel, poses, joints."""

from __future__ import annotations

import functools
import io
import json
import math
import re
import sys
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager, redirect_stdout
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any, TextIO

import click

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from virtualrobot.connection import Client
    from virtualrobot.leases import Lease

GO_ON = "'virtualrobot step --realtime' lets it go on by itself again"


@dataclass(slots=True)
class Session:
    """Connection that the commands of a shell share, and the leases that it holds."""

    client: Client
    leases: list[Lease] = field(default_factory=list)

    def release(self) -> None:
        """Give all leased robots back."""
        while self.leases:
            self.leases.pop().release()


@dataclass(frozen=True, slots=True)
class Target:
    """Kernel that a command talks to: address, and files of token and certificate; in a shell its session.

    answers: where the kernel's answers are written as JSON, in place of the command's own words.
    """

    address: str | None = None
    token_file: Path | None = None
    certificate: Path | None = None
    debug: bool = False
    json: bool = False
    session: Session | None = None
    answers: TextIO | None = None

    @contextmanager
    def connect(self, program: str = "command line") -> Iterator[Client]:
        """Connect to it for the length of a block; a session stays connected.

        In the history `program` stands beside the user: what commands do is one's own from any of them, and what an
        application does is its own.
        """
        from virtualrobot.connecting import connect
        from virtualrobot.leases import user_name

        if self.session is not None:
            with self._heard(self.session.client) as client:
                yield client
            return
        client = connect(
            self.address,
            token_file=self.token_file,
            root_certificate=self.certificate,
            name=f"{user_name()}, {program}",
        )
        with client, self._heard(client):
            yield client

    @contextmanager
    def _heard(self, client: Client) -> Iterator[Client]:
        channel = client.services.channel
        channel.listener = None if self.answers is None else functools.partial(_write_answer, self.answers)
        try:
            yield client
        finally:
            channel.listener = None


def _write_answer(out: TextIO, method: str, message: Any) -> None:  # noqa: ANN401 a message of the contract
    """Write an answer of the kernel as a line of JSON, with the contract's names."""
    from google.protobuf.json_format import MessageToDict

    said = MessageToDict(message, preserving_proto_field_name=True, always_print_fields_with_no_presence=True)
    out.write(json.dumps({"rpc": method.rpartition("/")[2], "answer": said}) + "\n")
    out.flush()


class WholeRange(click.IntRange):
    """A whole number in a range."""

    name = "number"

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> int:  # noqa: ANN401
        """Return the number; raise click.BadParameter for words that are none."""
        try:
            int(value)
        except ValueError:
            self.fail(f"{value!r} is no whole number", param, ctx)
        return super().convert(value, param, ctx)


class FiniteRange(click.FloatRange):
    """A number in a range; NaN, which is neither below nor above it, is none."""

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> float:  # noqa: ANN401
        """Return the number."""
        number = super().convert(value, param, ctx)
        if not math.isfinite(number):
            self.fail(f"{value!r} is no finite number", param, ctx)
        return number


def target_options(function: Callable[..., Any]) -> Callable[..., Any]:
    """Give a command the options that say which kernel, as one argument `target`; they may also stand before it."""

    @click.option("--address", metavar="HOST:PORT", help="The kernel [$VIRTUALROBOT_ADDRESS, or 127.0.0.1:50500].")
    @click.option(
        "--token-file",
        type=click.Path(path_type=Path),
        help="The file that holds its token [else $VIRTUALROBOT_TOKEN is the token itself, or else the file that a "
        "kernel of this user wrote holds it].",
    )
    @click.option(
        "--certificate",
        type=click.Path(exists=True, dir_okay=False, path_type=Path),
        help="A root certificate (PEM) for TLS.",
    )
    @click.option("--json", "as_json", is_flag=True, help="Print the kernel's answers, a line of JSON each.")
    @click.option("--debug", is_flag=True, help="Show tracebacks.")
    @functools.wraps(function)
    def command(
        *arguments: Any,  # noqa: ANN401 those of the command
        address: str | None,
        token_file: Path | None,
        certificate: Path | None,
        as_json: bool,
        debug: bool,
        **options: Any,  # noqa: ANN401
    ) -> Any:  # noqa: ANN401
        before = click.get_current_context().find_object(Target) or Target()
        other = address or token_file or certificate
        target = Target(
            address or before.address,
            token_file or before.token_file,
            certificate or before.certificate,
            debug or before.debug,
            as_json or before.json,
            None if other else before.session,
            sys.stdout if as_json or before.json else None,
        )
        if target.answers is None:
            return function(*arguments, target=target, **options)
        with redirect_stdout(io.StringIO()):
            return function(*arguments, target=target, **options)

    return command


degrees_option = click.option("--degrees", is_flag=True, help="Angles are given and shown in degrees.")


class Numbers(click.ParamType):
    """Numbers with commas or spaces between them, of one of the given counts."""

    name = "numbers"

    def __init__(self, *counts: int) -> None:
        """Accept one of these counts; none means any."""
        self.counts = counts

    def convert(
        self,
        value: object,
        param: click.Parameter | None,
        ctx: click.Context | None,
    ) -> tuple[float, ...]:
        """Return the numbers."""
        if isinstance(value, tuple):
            return value
        try:
            numbers = tuple(float(word) for word in re.split(r"[\s,]+", str(value).strip(" ,")))
        except ValueError:
            self.fail(f"{value!r} is not numbers with commas between them, such as 0.5,0,0.3", param, ctx)
        if self.counts and len(numbers) not in self.counts:
            wanted = " or ".join(map(str, self.counts))
            self.fail(f"{value!r} has {len(numbers)} numbers; {wanted} are wanted", param, ctx)
        if not all(map(math.isfinite, numbers)):
            self.fail(f"{value!r} has a number that is not finite", param, ctx)
        return numbers


def pose_of_numbers(numbers: Sequence[float], degrees: bool, turned_as: NDArray[np.float64] | None = None) -> Any:  # noqa: ANN401
    """Return a 4x4 pose from x, y, z and roll, pitch, yaw; without angles it is turned as `turned_as` (or not)."""
    import virtualrobot

    angles = [math.radians(angle) if degrees else angle for angle in numbers[3:]]
    pose = virtualrobot.pose(*numbers[:3], *angles)
    if not angles and turned_as is not None:
        pose[:3, :3] = turned_as[:3, :3]
    return pose


def named_folders(ctx: click.Context, param: click.Parameter, values: Sequence[str]) -> dict[str, Path]:
    """Return folders by package name from `name=folder` words."""
    folders = {}
    for value in values:
        name, separator, folder = value.partition("=")
        if not name or not separator or not Path(folder).is_dir():
            raise click.BadParameter(f"{value!r} is not name=folder with an existing folder", ctx, param)
        folders[name] = Path(folder).absolute()
    return folders

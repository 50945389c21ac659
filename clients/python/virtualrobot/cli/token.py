"""`virtualrobot token`: who is let in, and what for."""

from __future__ import annotations

import os
from pathlib import Path

import click

from virtualrobot.cli.options import Target, target_options

_EXAMPLES = """
\b
Examples:
  virtualrobot token create night-shift operator --out night-shift.token
  virtualrobot --token-file night-shift.token state
  virtualrobot token list
  virtualrobot token revoke night-shift
"""


@click.group(epilog=_EXAMPLES)
def token() -> None:
    """Make, show or withdraw tokens with roles; for admins, such as whoever has the kernel's own token."""


@token.command()
@click.argument("name")
@click.argument("role", type=click.Choice(["observer", "operator", "engineer", "admin"]))
@click.option("--out", type=click.Path(path_type=Path), help="A new file for it, for --token-file; else it is printed.")
@target_options
def create(target: Target, name: str, role: str, out: Path | None) -> None:
    """Make the token NAME with ROLE and print it. It is told once: the kernel does not keep it."""
    # Before there is a token that would be lost.
    try:
        descriptor = None if out is None else os.open(out, os.O_WRONLY | os.O_CREAT | os.O_EXCL, 0o600)
    except FileExistsError:
        raise click.ClickException(f"{out} is there already; a token is written to a new file only") from None
    except OSError as error:
        raise click.ClickException(f"cannot write {out}: {error.strerror}") from None
    try:
        with target.connect() as client:
            made = client.tokens.create(name, role)
    except BaseException:
        if out is not None and descriptor is not None:
            os.close(descriptor)
            out.unlink()
        raise
    if descriptor is None:
        click.echo(made.secret)
        return
    with os.fdopen(descriptor, "w", encoding="utf-8") as file:
        file.write(made.secret)
    click.echo(f"the token of the {role} {name} is in {out}")


@token.command("list")
@target_options
def list_tokens(target: Target) -> None:
    """Show the tokens, oldest first, without what they are."""
    from virtualrobot.tables import aligned

    with target.connect() as client:
        tokens = client.tokens.list()
    if not tokens:
        click.echo("there is no token but the kernel's own")
        return
    rows = [[one.name, one.role, f"{one.created:%Y-%m-%d %H:%M} UTC", f"by {one.created_by}"] for one in tokens]
    click.echo("\n".join(aligned(rows, left=4)))


@token.command()
@click.argument("name")
@target_options
def revoke(target: Target, name: str) -> None:
    """Withdraw the token NAME: its streams and leases end, and the robots that it has leased stop."""
    with target.connect() as client:
        gone = client.tokens.revoke(name)
    click.echo(f"withdrawn: {gone.name}, {gone.role}")

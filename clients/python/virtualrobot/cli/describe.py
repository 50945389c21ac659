"""`virtualrobot describe`: what people say of nodes, and their locks."""

from __future__ import annotations

import click

from virtualrobot.cli.names import NODE
from virtualrobot.cli.options import Target, target_options

_EXAMPLES = """
\b
Examples:
  virtualrobot describe bench "Where boxes wait" --tag fixture --tag station-2
  virtualrobot describe bench --lock
  virtualrobot describe --tagged fixture
"""


@click.command(epilog=_EXAMPLES)
@click.argument("node", type=NODE, required=False)
@click.argument("text", required=False)
@click.option("--tag", "tags", multiple=True, metavar="WORD", help="A tag, in place of those that it has; repeatable.")
@click.option("--no-tags", is_flag=True, help="Take its tags away.")
@click.option("--icon", metavar="NAME", help="The icon that pages show for it, of the library Lucide; '': its kind's.")
@click.option("--lock/--unlock", default=None, help="Keep its name, parent, pose and figures, or let go of them.")
@click.option("--tagged", metavar="WORD", help="Tell the nodes with this tag; without NODE.")
@target_options
def describe(
    target: Target,
    node: str | None,
    text: str | None,
    tags: tuple[str, ...],
    no_tags: bool,
    icon: str | None,
    lock: bool | None,
    tagged: str | None,
) -> None:
    """Say what NODE is for, in the words of TEXT; or show what is said of it."""
    if (node is None) == (tagged is None):
        raise click.UsageError("give a NODE, or --tagged")
    if tags and no_tags:
        raise click.UsageError("give either --tag or --no-tags")
    with target.connect() as client:
        if node is None:
            for one in client.scene.nodes(tag=tagged):
                click.echo(f"{one.name} ({one.kind})")
            return
        with client.scene.batch() as batch:
            if lock is False:
                batch.lock(node, False)
            if text is not None or tags or no_tags or icon is not None:
                batch.describe(node, text, tags=tags if tags or no_tags else None, icon=icon)
            if lock:
                batch.lock(node)
        info = client.scene.node(node).info
    said = [info.description, f"tags: {', '.join(info.tags)}" if info.tags else "", f"icon: {info.icon}"]
    lines = [*said[: 3 if info.icon else 2], "locked" if info.locked else ""]
    click.echo("\n".join((f"{node} ({info.kind})", *(f"  {line}" for line in lines if line))))

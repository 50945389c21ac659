"""Description, tags and icon of a node, as people say them, and its lock."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

from virtualrobot_kernel.errors import KernelError, Reason

LONGEST_DESCRIPTION = 2000
LONGEST_WORD = 64
"""Of a tag or the name of an icon, in characters."""
MOST_TAGS = 32


@dataclass(frozen=True, slots=True)
class About:
    """Words of people about a node: `description`, `tags` without repeats, the name of an `icon`; and its lock.

    The name, parent, pose, figures and data of one that is `locked` stay, and it isn't removed.
    """

    description: str = ""
    tags: tuple[str, ...] = ()
    icon: str = ""
    locked: bool = False


NOTHING_SAID = About()


def or_none(about: About) -> About | None:
    """Return what is said, or None where that is nothing, as nodes keep it."""
    return None if about == NOTHING_SAID else about


def check_about(about: About, node: str) -> None:
    """Raise KernelError, which names the field, for words that are too long, and for tags that are none."""
    if len(about.description) > LONGEST_DESCRIPTION:
        raise _refusal(node, "description", f"has {len(about.description)} characters; at most {LONGEST_DESCRIPTION}")
    if len(about.icon) > LONGEST_WORD:
        raise _refusal(node, "icon", f"has {len(about.icon)} characters; at most {LONGEST_WORD}")
    if len(about.tags) > MOST_TAGS:
        raise _refusal(node, "tags", f"are {len(about.tags)}; at most {MOST_TAGS}")
    for place, tag in enumerate(about.tags):
        field = f"tags[{place}]"
        if not tag or tag != tag.strip() or not tag.isprintable() or len(tag) > LONGEST_WORD:
            raise _refusal(node, field, f"is {tag!r}; give 1 to {LONGEST_WORD} characters without spaces around them")
        if tag in about.tags[:place]:
            raise _refusal(node, field, f"is {tag!r} again; give each tag once")


def refuse_locked(nodes: Iterable[tuple[str, About | None]]) -> None:
    """Raise KernelError (WRONG_STATE) for the first locked one of some nodes, each its name and what is said of it."""
    for name, about in nodes:
        if about is not None and about.locked:
            raise KernelError(
                f"{name!r} is locked; unlock it first, by an update of `locked`", reason=Reason.WRONG_STATE, node=name
            )


def _refusal(node: str, field: str, what: str) -> KernelError:
    return KernelError(f"{node}.{field} {what}", node=node, field=field)

"""Table of the resources of Robot Web Services: what a method of a path does, with an action where it has one."""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import TypeAlias

from virtualrobot_apps.emulators.abb.answers import Answer, Item
from virtualrobot_apps.emulators.abb.controller import Controller
from virtualrobot_apps.emulators.abb.refused import Refused


@dataclass(frozen=True, slots=True)
class Call:
    """A call of a client.

    Attributes:
        controller: what it is about.
        path: values of the names in the path.
        query: values after the question mark.
        form: values in the body.
        body: the body itself.
    """

    controller: Controller
    path: Mapping[str, str]
    query: Mapping[str, str] = field(default_factory=dict)
    form: Mapping[str, str] = field(default_factory=dict)
    body: bytes = b""

    def needs(self, name: str) -> str:
        """Return a value of the body, or after the question mark."""
        value = self.form.get(name, self.query.get(name))
        if value is None:
            raise Refused("INVALIDARG", f"{name!r} is missing")
        return value


Handled: TypeAlias = Sequence[Item] | Answer | None
"""Items, another answer, or nothing to tell."""


@dataclass(frozen=True, slots=True)
class Resource:
    """A resource: method, path with names in braces (`{name*}` takes slashes, too), action, text, and what does it."""

    method: str
    template: str
    action: str
    text: str
    run: Callable[[Call], Handled]
    pattern: re.Pattern[str]
    room: str


RESOURCES: list[Resource] = []
"""All resources, in the order in which they are looked at."""


def resource(method: str, template: str, action: str = "") -> Callable[[Callable[[Call], Handled]], Callable]:
    """Enter a function as a resource; its docstring says what it does."""
    written = re.escape(template).replace(r"\*\}", r"*}").replace(r"\{", "{").replace(r"\}", "}")
    pattern = re.sub(r"\{(\w+)\*\}", r"(?P<\1>.*)", written)
    pattern = re.compile(re.sub(r"\{(\w+)\}", r"(?P<\1>[^/]+)", pattern) + "/?")

    def enter(run: Callable[[Call], Handled]) -> Callable[[Call], Handled]:
        room = run.__module__.rpartition(".")[2]
        RESOURCES.append(Resource(method, template, action, (run.__doc__ or "").rstrip("."), run, pattern, room))
        return run

    return enter


def find(method: str, path: str, action: str) -> tuple[Resource, dict[str, str]]:
    """Return the resource of a call, and the values of the names in its path."""
    found = [(one, match.groupdict()) for one in RESOURCES if (match := one.pattern.fullmatch(path))]
    if not found:
        raise Refused("UNRESOLVED_URL", f"there is no resource {path!r}", 404)
    of_method = [(one, names) for one, names in found if one.method == method]
    if not of_method:
        methods = ", ".join(sorted({one.method for one, _ in found}))
        raise Refused("UNRESOLVED_URL", f"{path} takes {methods}, not {method}", 405)
    for one, names in of_method:
        if one.action == action:
            return one, names
    if method == "GET" and action in ("", "show"):
        return of_method[0]
    known = ", ".join(one.action or "none" for one, _ in of_method)
    raise Refused("INVALIDARG", f"{method} {path} takes the actions {known}, not {action or 'none'}")

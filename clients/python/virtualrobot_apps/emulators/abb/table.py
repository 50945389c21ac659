"""Table of the resources of Robot Web Services: what a method of a path does, with an action where it has one.

Paths of 2.0 are those that public clients of RobotWare 7 use. An action of 1.0 (`?action=stop`) is the last part of the
path there (`/stop`), unless a resource says otherwise.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import TypeAlias

from virtualrobot_apps.emulators.abb.answers import Answer, Item
from virtualrobot_apps.emulators.abb.controller import Controller
from virtualrobot_apps.emulators.abb.disk import place
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
        second: whether it came by Robot Web Services 2.0.
    """

    controller: Controller
    path: Mapping[str, str]
    query: Mapping[str, str] = field(default_factory=dict)
    form: Mapping[str, str] = field(default_factory=dict)
    body: bytes = b""
    second: bool = False

    def name(self, name: str) -> str:
        """Return a name in the path, or else as `needs` does: not all versions have it in the same place."""
        return self.path[name] if name in self.path else self.needs(name)

    def file(self, name: str) -> Path:
        """Return the file of a name on one of the controller's disks."""
        return place(self.controller.files, name, bare=self.second)

    def needs(self, name: str) -> str:
        """Return a value of the body, or after the question mark."""
        value = self.form.get(name, self.query.get(name))
        if value is None:
            raise Refused("INVALIDARG", f"{name!r} is missing")
        return value


Handled: TypeAlias = Sequence[Item] | Answer | None
"""Items, another answer, or nothing to tell."""


@dataclass(frozen=True, slots=True)
class Form:
    """Place of a resource: a path with names in braces (`{name*}` takes slashes, too), and an action, mostly none."""

    template: str
    action: str
    pattern: re.Pattern[str]


@dataclass(frozen=True, slots=True)
class Resource:
    """A resource: method, where it is in Robot Web Services 1.0 and 2.0 (None: not there), text, and what does it."""

    method: str
    first: Form | None
    second: Form | None
    text: str
    run: Callable[[Call], Handled]

    def form(self, second: bool) -> Form | None:
        """Return where it is in 2.0 (`second`) or 1.0."""
        return self.second if second else self.first


RESOURCES: list[Resource] = []
"""All resources, in the order in which they are looked at."""


def resource(
    method: str, template: str, action: str = "", *, second: str | None = None, only: str = ""
) -> Callable[[Callable[[Call], Handled]], Callable]:
    """Enter a function as a resource; its docstring says what it does.

    Args:
        method: the method of HTTP.
        template: its path in 1.0.
        action: its action there.
        second: its path in 2.0, with `?action=` where it has one there, too; None: that of 1.0 and its action behind.
        only: the version that alone has it, `1.0` or `2.0`; empty: both.
    """
    path, _, kept = (f"{template}{action and f'/{action}'}" if second is None else second).partition("?action=")

    def enter(run: Callable[[Call], Handled]) -> Callable[[Call], Handled]:
        first = None if only == "2.0" else _form(template, action)
        other = None if only == "1.0" else _form(path, kept)
        RESOURCES.append(Resource(method, first, other, (run.__doc__ or "").rstrip("."), run))
        return run

    return enter


def _form(template: str, action: str) -> Form:
    written = re.escape(template).replace(r"\*\}", r"*}").replace(r"\{", "{").replace(r"\}", "}")
    pattern = re.sub(r"\{(\w+)\*\}", r"(?P<\1>.*)", written)
    return Form(template, action, re.compile(re.sub(r"\{(\w+)\}", r"(?P<\1>[^/]+)", pattern) + "/?"))


def find(method: str, path: str, action: str, *, second: bool = False) -> tuple[Resource, dict[str, str]]:
    """Return the resource of a call by 1.0, or 2.0 (`second`), and the values of the names in its path."""
    forms = [(one, form) for one in RESOURCES if (form := one.form(second)) is not None]
    found = [(one, form, match.groupdict()) for one, form in forms if (match := form.pattern.fullmatch(path))]
    if not found:
        raise Refused("UNRESOLVED_URL", f"there is no resource {path!r}", 404)
    of_method = [(one, form, names) for one, form, names in found if one.method == method]
    if not of_method:
        methods = ", ".join(sorted({one.method for one, _, _ in found}))
        raise Refused("UNRESOLVED_URL", f"{path} takes {methods}, not {method}", 405)
    for one, form, names in of_method:
        if form.action == action:
            return one, names
    if method == "GET" and action in ("", "show"):
        return of_method[0][0], of_method[0][2]
    known = ", ".join(form.action or "none" for _, form, _ in of_method)
    raise Refused("INVALIDARG", f"{method} {path} takes the actions {known}, not {action or 'none'}")

"""Answers of Robot Web Services: items with a class, a title and values, as XHTML or as JSON; JSON of 2.0 is HAL."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any
from xml.sax.saxutils import escape, quoteattr

XHTML, JSON, BYTES = "application/xhtml+xml", "application/json", "application/octet-stream"
"""Types of contents; that of JSON has no character set, since clients compare it."""
SECOND = ";v=2.0"
"""End of the types of Robot Web Services 2.0."""
HAL = f"application/hal+json{SECOND}"
DONE = 294912
"""Code of an answer of 2.0 to what was done."""
PLAIN_LISTS = ("rap-module-info-li",)
"""Classes of items of lists that 2.0 tells in `state`, where others stand in `_embedded.resources`."""


@dataclass(frozen=True, slots=True)
class Item:
    """A part of an answer.

    Attributes:
        kind: its class, such as `rap-task-li`.
        title: its title.
        values: its values, by name; a list is that of the words of a message.
        href: where it is.
    """

    kind: str
    title: str
    values: Mapping[str, Any] = field(default_factory=dict)
    href: str = ""


@dataclass(frozen=True, slots=True)
class Answer:
    """A status, and a body of some type; `headers` go along."""

    status: int
    body: bytes = b""
    kind: str = XHTML
    headers: tuple[tuple[str, str], ...] = ()


def state(items: Sequence[Item], base: str, as_json: bool) -> Answer:
    """Return the answer that items make."""
    if as_json:
        told = [
            {"_links": {"self": {"href": one.href}}, "_type": one.kind, "_title": one.title, **_json_values(one.values)}
            for one in items
        ]
        return _json(200, {"_links": {"base": {"href": base}}, "_embedded": {"_state": told}})
    return Answer(200, page("".join(map(xhtml, items)), base))


def hal_state(items: Sequence[Item], base: str) -> Answer:
    """Return the answer that items make in 2.0: those of a list are its resources, others its state.

    Source: answers of a virtual OmniCore controller with RobotWare 7.21 that the tests of abb-rws-client (Apache-2.0)
    have kept.
    """
    told: dict[str, Any] = {"_links": {"base": {"href": base}, "self": {"href": ""}}, "status": {"code": DONE}}
    listed = [one for one in items if one.kind.endswith("-li") and one.kind not in PLAIN_LISTS]
    if listed:
        links = [{"_links": {"self": {"href": one.href}}, **_hal(one)} for one in listed]
        return _json(200, told | {"_embedded": {"resources": links}}, HAL)
    return _json(200, told | {"state": [_hal(one) for one in items]}, HAL)


def hal_failed(status: int, code: int, words: str, base: str) -> Answer:
    """Return the answer of 2.0 to what is refused: a return code and words."""
    return _json(status, {"_links": {"base": {"href": base}}, "status": {"code": code, "msg": words}}, HAL)


def _hal(item: Item) -> dict[str, str]:
    return {"_type": item.kind, "_title": item.title, **{name: str(value) for name, value in _flat(item.values)}}


def failed(status: int, code: int, words: str, base: str, as_json: bool) -> Answer:
    """Return the answer to what is refused: a return code and words."""
    if as_json:
        told = {"status": {"code": code, "msg": words}}
        return _json(status, {"_links": {"base": {"href": base}}, "_embedded": told})
    said = f'<span class="code">{code}</span><span class="msg">{escape(words)}</span>'
    return Answer(status, _document(f'<div class="status">{said}</div>', base))


def page(items: str, base: str, links: str = "") -> bytes:
    """Return a page of items, which are XHTML already, after links."""
    listed = f"<ul>{items}</ul>" if items else ""
    return _document(f'<div class="state">{links}{listed}</div>', base)


def xhtml(item: Item) -> str:
    """Return an item as XHTML."""
    link = f'<a href={quoteattr(item.href)} rel="self"/>' if item.href else ""
    spans = "".join(f'<span class="{name}">{escape(str(value))}</span>' for name, value in _flat(item.values))
    return f'<li class="{item.kind}" title={quoteattr(item.title)}>{link}{spans}</li>'


def _json_values(values: Mapping[str, Any]) -> dict[str, Any]:
    return {
        name: [{"type": "string", "value": one} for one in value] if isinstance(value, list) else str(value)
        for name, value in values.items()
    }


def _flat(values: Mapping[str, Any]) -> list[tuple[str, Any]]:
    flat: list[tuple[str, Any]] = []
    for name, value in values.items():
        listed = isinstance(value, list)
        flat += [(f"arg{number}", one) for number, one in enumerate(value, 1)] if listed else [(name, value)]
    return flat


def _json(status: int, told: object, kind: str = JSON) -> Answer:
    return Answer(status, json.dumps(told).encode(), kind)


def _document(body: str, base: str) -> bytes:
    head = f"<head><title>Robot Web Services</title><base href={quoteattr(base)}/></head>"
    return (
        '<?xml version="1.0" encoding="UTF-8"?>'
        f'<html xmlns="http://www.w3.org/1999/xhtml">{head}<body>{body}</body></html>'
    ).encode("utf-8", "replace")

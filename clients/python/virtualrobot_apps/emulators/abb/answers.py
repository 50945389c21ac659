"""Answers of Robot Web Services 1.0: items with a class, a title and values, as XHTML or as JSON."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any
from xml.sax.saxutils import escape, quoteattr

XHTML, JSON, BYTES = "application/xhtml+xml", "application/json", "application/octet-stream"
"""Types of contents; that of JSON has no character set, since clients compare it."""


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


def _json(status: int, told: object) -> Answer:
    return Answer(status, json.dumps(told).encode(), JSON)


def _document(body: str, base: str) -> bytes:
    head = f"<head><title>Robot Web Services</title><base href={quoteattr(base)}/></head>"
    return (
        '<?xml version="1.0" encoding="UTF-8"?>'
        f'<html xmlns="http://www.w3.org/1999/xhtml">{head}<body>{body}</body></html>'
    ).encode("utf-8", "replace")

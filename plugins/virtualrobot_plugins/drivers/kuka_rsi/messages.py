"""Messages of KUKA's Robot Sensor Interface: one line of XML in each direction and cycle.

What is read is a small part of XML, so that nothing in it can unfold: one element `Rob`, and in it elements that have
attributes or a text, and none within them. Entities, comments, declarations and sections are refused.
"""

from __future__ import annotations

import re
from collections.abc import Mapping

LONGEST = 16384
"""Longest message (bytes) that is read."""

_ATTRIBUTES = r'(?:\s+[\w.]+\s*=\s*"[^"<&]*")*'
_ROOT = re.compile(rf"\s*<Rob({_ATTRIBUTES})\s*>(.*)</Rob\s*>\s*", re.DOTALL)
_ELEMENT = re.compile(rf"\s*<([A-Za-z_][\w.]*)({_ATTRIBUTES})\s*(?:/>|>([^<&]*)</\1\s*>)\s*")
_ATTRIBUTE = re.compile(r'([\w.]+)\s*=\s*"([^"]*)"')


class MessageError(ValueError):
    """Bytes that are no such message."""


def read_robot(data: bytes) -> dict[str, dict[str, str]]:
    """Return attributes of each element of a `<Rob>` by name; its text is the attribute "".

    Raises:
        MessageError: the bytes are no such message.
    """
    if len(data) > LONGEST:
        raise MessageError(f"no <Rob>: it has {len(data)} bytes, and may have {LONGEST}")
    try:
        text = data.decode("utf-8")
    except UnicodeDecodeError as error:
        raise MessageError(f"no <Rob>: {error.reason}") from error
    root = _ROOT.fullmatch(text)
    if root is None:
        raise MessageError(f"no <Rob>: it begins with {text[:40]!r}")
    inside, at, found = root[2], 0, {}
    while at < len(inside):
        element = _ELEMENT.match(inside, at)
        if element is None:
            if not inside[at:].strip():
                break
            raise MessageError(f"no <Rob>: no plain element is at {inside[at : at + 40]!r}")
        found[element[1]] = {name: value for name, value in _ATTRIBUTE.findall(element[2])} | {"": element[3] or ""}
        at = element.end()
    return found


def number(said: Mapping[str, Mapping[str, str]], tag: str, attribute: str = "") -> float:
    """Return a number of a message; raises MessageError where it is missing, or is none."""
    name = f"{tag}.{attribute}" if attribute else tag
    try:
        return float(said[tag][attribute])
    except KeyError as error:
        raise MessageError(f"<Rob> has no {name}; the sensor's configuration must send it") from error
    except ValueError as error:
        raise MessageError(f"{name} is {said[tag][attribute]!r}, and no number") from error


def whole(said: Mapping[str, Mapping[str, str]], tag: str, attribute: str = "") -> int:
    """Return a whole number of a message; raises MessageError where it is missing, or is none."""
    value = number(said, tag, attribute)
    if not value.is_integer():
        raise MessageError(f"{tag} is {value}, and no whole number")
    return int(value)


def write_sensor(
    sentype: str, corrections: Mapping[str, Mapping[str, float]], outputs: Mapping[str, int], stamp: int
) -> bytes:
    """Return a `<Sen>`: corrections by tag and axis, outputs by tag, and the robot's own stamp (IPOC)."""
    parts = [f'<Sen Type="{sentype}">']
    for tag, axes in corrections.items():
        attributes = " ".join(f'{axis}="{value:.6f}"' for axis, value in axes.items())
        parts.append(f"<{tag} {attributes} />")
    parts += [f"<{tag}>{value}</{tag}>" for tag, value in outputs.items()]
    return ("".join(parts) + f"<IPOC>{stamp}</IPOC></Sen>").encode()

"""Messages of the protocol as bytes: what comes in is read within limits, what goes out is packed as asked."""

from __future__ import annotations

import base64
import io
import json
import math
from typing import Any

import cbor2
import numpy as np
from PIL import Image

from virtualrobot_apps.bridges.ros.hub import HubError

MOST_BYTES = 64 << 20
"""Greatest message that is read."""

_TYPED = {
    **{64: "u1", 69: "<u2", 70: "<u4", 71: "<u8", 72: "i1", 77: "<i2", 78: "<i4", 79: "<i8", 85: "<f4", 86: "<f8"},
    **{65: ">u2", 66: ">u4", 67: ">u8", 68: "u1", 73: ">i2", 74: ">i4", 75: ">i8", 81: ">f4", 82: ">f8"},
}
"""Tags of typed arrays; source: RFC 8746, table 1."""


def decoded(data: str | bytes) -> dict[str, Any]:
    """Return a message that came in: JSON, in text or bytes, or CBOR.

    Raises:
        HubError: for what is neither, and for what is no object.
    """
    # Clients such as ROS# send JSON in binary frames; no object in CBOR begins with a brace or a space.
    is_text = isinstance(data, str) or data[:1] in (b"{", b" ", b"\n", b"\t", b"\r")
    try:
        value = json.loads(data) if isinstance(data, str) or is_text else cbor2.loads(data, tag_hook=_tagged)
    except RecursionError as error:
        raise HubError("a message is nested too deep") from error
    except Exception as error:  # a decoder of bad bytes raises whatever it likes
        what = "JSON" if is_text else "CBOR"
        raise HubError(f"a message is no {what}: {type(error).__name__}: {str(error)[:120]}") from error
    if not isinstance(value, dict):
        raise HubError("a message is an object with an 'op'")
    return value


def _tagged(decoder: Any, tag: Any = None) -> Any:  # noqa: ANN401 the arguments differ between cbor2's versions
    tag = decoder if tag is None or not hasattr(tag, "tag") else tag
    if tag.tag in _TYPED and isinstance(tag.value, bytes):
        kind = np.dtype(_TYPED[tag.tag])
        if len(tag.value) % kind.itemsize:
            raise ValueError(f"{len(tag.value)} bytes are no typed array of {kind.name}")
        return np.frombuffer(tag.value, kind).astype(kind.newbyteorder("="))
    raise ValueError(f"the tag {tag.tag} has no meaning here")


def png(text: str) -> str:
    """Return a text as the bytes of a PNG picture, in base64; lines of it are filled with line feeds."""
    data = text.encode()
    width = max(1, math.isqrt(len(data) // 3))
    height = max(1, math.ceil(len(data) / (3 * width)))
    out = io.BytesIO()
    Image.frombytes("RGB", (width, height), data.ljust(3 * width * height, b"\n")).save(out, "png")
    return base64.b64encode(out.getvalue()).decode()


def text_of_png(data: str) -> str:
    """Return the text that a PNG picture in base64 holds.

    Raises:
        HubError: for what is no such picture, and for one that would be larger than any message may be.
    """
    try:
        with Image.open(io.BytesIO(base64.b64decode(data, validate=True)), formats=["PNG"]) as picture:
            size = picture.width * picture.height * len(picture.getbands())
            if size > MOST_BYTES:
                raise HubError(f"a picture of {size} bytes is larger than a message may be, {MOST_BYTES}")
            return picture.convert("RGB").tobytes().rstrip(b"\n\0").decode()
    except HubError:
        raise
    except Exception as error:  # a decoder of bad bytes raises whatever it likes
        raise HubError(f"'data' is no text in a PNG picture in base64: {type(error).__name__}") from error


def fragments(text: str, size: int, number: str) -> list[str]:
    """Return a text as messages of fragments, each with at most `size` letters of it."""
    total = math.ceil(len(text) / size)
    return [
        json.dumps({"op": "fragment", "id": number, "data": text[i * size : (i + 1) * size], "num": i, "total": total})
        for i in range(total)
    ]


class Fragments:
    """Fragments of a client, until each message of them is whole; what is never finished is bounded."""

    MOST_PARTS, MOST_BEGUN = 10_000, 16

    def __init__(self) -> None:
        """Begin with none."""
        self._begun: dict[str, dict[int, str]] = {}
        self._size = 0

    def add(self, op: dict[str, Any]) -> str | None:
        """Take a fragment; return the text that is whole with it, or None.

        Raises:
            HubError: for a fragment that is none, and when too much has begun and was not finished: all is dropped.
        """
        number, place, total, data = op.get("id"), op.get("num"), op.get("total"), op.get("data")
        if not (
            isinstance(number, str) and isinstance(data, str) and isinstance(place, int) and isinstance(total, int)
        ):
            raise HubError("a fragment has the texts 'id' and 'data', and the whole numbers 'num' and 'total'")
        if not 0 <= place < total <= self.MOST_PARTS:
            raise HubError(f"'num' is from 0 to 'total' - 1, and 'total' at most {self.MOST_PARTS}")
        parts = self._begun.setdefault(number[:100], {})
        self._size += len(data) - len(parts.get(place, ""))
        parts[place] = data
        if len(self._begun) > self.MOST_BEGUN or self._size > MOST_BYTES:
            self._begun.clear()
            self._size = 0
            raise HubError("too many fragments without an end: all are dropped")
        if len(parts) < total or any(one not in parts for one in range(total)):
            return None
        del self._begun[number[:100]]
        self._size -= sum(map(len, parts.values()))
        return "".join(parts[one] for one in range(total))

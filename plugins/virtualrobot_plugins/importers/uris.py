"""Names of files that files name."""

from __future__ import annotations

import re

_ABSOLUTE = re.compile(r"^([A-Za-z][A-Za-z0-9+.-]*:|[/\\])")


def join_uri(referrer: str, uri: str) -> str:
    """Return the name of a file that `referrer` (a path or URI) names as `uri`.

    A relative `uri` counts from the referrer's folder: `package://a/x.wrl` naming `y.png` gives `package://a/y.png`;
    others stand for themselves. Backslashes become slashes; `.` and `..` are worked out.
    """
    uri = uri.replace("\\", "/")
    if _ABSOLUTE.match(uri):
        return uri
    scheme, separator, path = referrer.replace("\\", "/").rpartition("://")
    parts: list[str] = []
    for part in [*path.split("/")[:-1], *uri.split("/")]:
        if part == ".." and parts and parts[-1] not in ("", ".."):
            parts.pop()
        elif part != "." and (part or not parts):
            parts.append(part)
    return scheme + separator + "/".join(parts)

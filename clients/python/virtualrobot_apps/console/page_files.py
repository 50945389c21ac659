"""Files of the console's page: what the build has made of web/, and what pages of others load."""

from __future__ import annotations

from dataclasses import dataclass
from importlib import resources
from importlib.resources.abc import Traversable
from pathlib import Path

TYPES = {
    ".css": "text/css; charset=utf-8",
    ".html": "text/html; charset=utf-8",
    ".js": "text/javascript; charset=utf-8",
    ".svg": "image/svg+xml",
    ".woff2": "font/woff2",
}
"""Types by ending; files of other endings are not served."""

FOREVER = "public, max-age=31536000, immutable"
"""Caching of files whose names change with their content."""


@dataclass(frozen=True, slots=True)
class PageFile:
    """A file that browsers may have: its bytes, its type, and how long they may keep it."""

    data: bytes
    type: str
    caching: str


AUTHORITY = "/authority.crt"
"""Path of the certificate of the installation's own authority, of a console that has one."""


def page_files(authority: Path | None = None) -> dict[str, PageFile]:
    """Return the files by path, with an authority's certificate; without a built page `/` says how it is built."""
    folder = resources.files("virtualrobot_apps.console") / "page"
    found = {"/calls.js": _file(folder / "calls.js", "no-cache")}
    if authority is not None:
        found[AUTHORITY] = PageFile(authority.read_bytes(), "application/x-x509-ca-cert", "no-cache")
    built = folder / "app"
    if not (built / "index.html").is_file():
        return {**found, "/": _file(folder / "unbuilt.html", "no-cache")}
    assets = [one for one in (built / "assets").iterdir() if _ending(one) in TYPES]
    found |= {f"/assets/{one.name}": _file(one, FOREVER) for one in assets}
    return {**found, "/": _file(built / "index.html", "no-cache")}


def is_built() -> bool:
    """Return whether the page itself is there."""
    return (resources.files("virtualrobot_apps.console") / "page" / "app" / "index.html").is_file()


def _file(path: Traversable, caching: str) -> PageFile:
    return PageFile(path.read_bytes(), TYPES[_ending(path)], caching)


def _ending(path: Traversable) -> str:
    return f".{path.name.rpartition('.')[2]}"

"""Links for one more browser as codes that a phone or a headset reads from a screen (QR codes, ISO/IEC 18004)."""

from __future__ import annotations

import io
from dataclasses import dataclass
from importlib.util import find_spec
from urllib.parse import urlsplit

from virtualrobot.errors import InvalidArgumentError
from virtualrobot.session import is_loopback

from virtualrobot_apps.console.page_files import AUTHORITY

ALONE = (
    "The console listens to this machine alone: `virtualrobot console --listen 0.0.0.0 --own-certificate` is reached "
    "by others, by https; where they know this machine by IPv6 alone, --listen ::"
)
NAMELESS = (
    "This machine has no private address that the authority signs for, so the link says localhost, by which no other "
    "one gets here: --host-name NAME.local is a name that they know it by, and where they know one of the Internet, "
    "--tls-certificate and --tls-key are for that"
)
MISSING = "a code needs segno: pip install 'virtualrobot[console]'"
QUIET = 4
"""Modules of white around a code, which readers want (ISO/IEC 18004, section 9.1)."""


@dataclass(frozen=True, slots=True)
class Reach:
    """Address by which other machines reach a console.

    base: address of the console's port as others have it, such as `https://192.168.1.4:8090`.
    signed: whether devices get the certificate of the installation's own authority there.
    fault: why others don't get here where the address is of this machine alone.
    """

    base: str
    signed: bool = False
    fault: str = ALONE

    @property
    def is_alone(self) -> bool:
        """True where the address is one of this machine alone."""
        return is_loopback(urlsplit(self.base).hostname or "")

    def invited(self, host: str, key: str) -> dict[str, str]:
        """Return a link with its code (SVG), the authority's where devices trust one, and why others don't get here.

        Args:
            host: what the browser that asks calls the console, with its port; others call it so, too, unless it is a
                name of the browser's own machine.
            key: what the link lets in by.

        Raises:
            InvalidArgumentError: without the library that makes codes.
        """
        own = urlsplit(self.base)
        here = urlsplit(f"//{host}").hostname or ""
        base = self.base if is_loopback(here) else f"{own.scheme}://{host}"
        if self.is_alone and is_loopback(here):
            return {"fault": self.fault}
        url = f"{base}/?key={key}"
        told = {"url": url, "code": code(url)}
        return {**told, "trust": base + AUTHORITY, "trust_code": code(base + AUTHORITY)} if self.signed else told


def code(text: str) -> str:
    """Return a QR code of a text as SVG, dark on white, of the least size.

    Raises:
        InvalidArgumentError: without the library that makes codes.
    """
    if find_spec("segno") is None:
        raise InvalidArgumentError(MISSING)
    import segno

    drawn = io.BytesIO()
    segno.make_qr(text).save(drawn, kind="svg", border=QUIET, light="white", omitsize=True, xmldecl=False)
    return drawn.getvalue().decode()

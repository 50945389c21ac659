"""TLS of the console's port, which answers who speaks plain HTTP to it with the address that is right."""

from __future__ import annotations

import ssl
from pathlib import Path


class TlsContext(ssl.SSLContext):
    """A context of a server that knows by which address it is reached, set as `base` once it is known."""

    base = ""

    def wrap_bio(
        self,
        incoming: ssl.MemoryBIO,
        outgoing: ssl.MemoryBIO,
        server_side: bool = False,
        server_hostname: str | bytes | None = None,
        session: ssl.SSLSession | None = None,
    ) -> ssl.SSLObject:
        """Return TLS between these ends, which knows them."""
        made = super().wrap_bio(incoming, outgoing, server_side, server_hostname, session)
        assert isinstance(made, _Tls)
        made.incoming, made.outgoing = incoming, outgoing
        return made


class _Tls(ssl.SSLObject):
    incoming: ssl.MemoryBIO
    outgoing: ssl.MemoryBIO
    _is_plain = False

    def do_handshake(self) -> None:
        """Shake hands; who speaks HTTP in place of it is answered, and waited for until the connection is closed."""
        try:
            if not self._is_plain:
                super().do_handshake()
        except ssl.SSLError as error:
            if error.reason != "HTTP_REQUEST" or not isinstance(self.context, TlsContext):
                raise
            self._is_plain = True
            self.outgoing.write(_answer(self.context.base))
        if self._is_plain:
            self.incoming.read()
            raise ssl.SSLWantReadError


def tls_context(certificate: Path, key: Path | None, base: str) -> TlsContext:
    """Return a server's context with a certificate, whose file may have its key, for who is told to come by `base`.

    Raises:
        OSError: for files that are no certificate and its key.
    """
    context = TlsContext(ssl.PROTOCOL_TLS_SERVER)
    context.sslobject_class = _Tls
    context.load_cert_chain(certificate, key)
    context.base = base
    return context


def _answer(base: str) -> bytes:
    said = f"this port speaks https, and http came: the address begins with https, as in {base}\n".encode()
    head = f"HTTP/1.1 400 Bad Request\r\ncontent-type: text/plain; charset=utf-8\r\ncontent-length: {len(said)}\r\n"
    return f"{head}connection: close\r\n\r\n".encode() + said

"""A broker of MQTT 3.1.1 for tests, as small as the standard allows: retained messages, quality 0 and 1, no patterns.

The brokers on the package index ask for other versions of what the kernel serves browsers with.
"""

from __future__ import annotations

import socket
import struct
import threading


class Broker:
    """Broker at a port of its own, until it is closed; `freeze` leaves all connections open and says nothing."""

    def __init__(self, port: int = 0) -> None:
        """Begin to serve."""
        self._listening = socket.create_server(("127.0.0.1", port))
        self.port: int = self._listening.getsockname()[1]
        self.frozen = False
        self._lock = threading.Lock()
        self._retained: dict[bytes, bytes] = {}
        self._subscribed: dict[socket.socket, set[bytes]] = {}
        threading.Thread(target=self._accept, daemon=True).start()

    def freeze(self) -> None:
        """Say nothing any more."""
        self.frozen = True

    def close(self) -> None:
        """End, and drop all connections."""
        self._listening.shutdown(socket.SHUT_RDWR)
        self._listening.close()
        with self._lock:
            for connection in self._subscribed:
                connection.shutdown(socket.SHUT_RDWR)

    def _accept(self) -> None:
        while True:
            try:
                connection, _ = self._listening.accept()
            except OSError:
                return
            with self._lock:
                self._subscribed[connection] = set()
            threading.Thread(target=self._serve, args=(connection,), daemon=True).start()

    def _serve(self, connection: socket.socket) -> None:
        stream = connection.makefile("rb")
        try:
            while head := stream.read(1):
                length = shift = 0
                while True:
                    (byte,) = stream.read(1)
                    length |= (byte & 127) << shift
                    shift += 7
                    if byte < 128:
                        break
                body = stream.read(length)
                if not self.frozen:
                    with self._lock:
                        self._take(connection, head[0], body)
        except (OSError, ValueError):
            pass
        finally:
            with self._lock:
                self._subscribed.pop(connection, None)
            stream.close()
            connection.close()

    def _take(self, connection: socket.socket, head: int, body: bytes) -> None:
        kind = head >> 4
        if kind == 1:  # CONNECT
            connection.sendall(b"\x20\x02\x00\x00")
        elif kind == 12:  # PINGREQ
            connection.sendall(b"\xd0\x00")
        elif kind == 8:  # SUBSCRIBE
            at, topics = 2, []
            while at < len(body):
                (size,) = struct.unpack_from(">H", body, at)
                topics.append(body[at + 2 : at + 2 + size])
                at += size + 3
            connection.sendall(bytes([0x90, 2 + len(topics)]) + body[:2] + bytes([0] * len(topics)))
            self._subscribed[connection].update(topics)
            for topic in topics:
                if topic in self._retained:
                    connection.sendall(_publish(topic, self._retained[topic]))
        elif kind == 3:  # PUBLISH
            (size,) = struct.unpack_from(">H", body)
            topic, at = body[2 : 2 + size], 2 + size
            if head & 6:
                connection.sendall(b"\x40\x02" + body[at : at + 2])
                at += 2
            if head & 1:
                self._retained[topic] = body[at:]
            for other, topics in self._subscribed.items():
                if topic in topics:
                    other.sendall(_publish(topic, body[at:]))


def _publish(topic: bytes, payload: bytes) -> bytes:
    body = struct.pack(">H", len(topic)) + topic + payload
    assert len(body) < 128
    return bytes([0x30, len(body)]) + body

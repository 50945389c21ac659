"""Logins at Mosquitto, a broker of others, which lets in nobody without a password."""

from __future__ import annotations

import shutil
import socket
import subprocess
from collections.abc import Iterator
from pathlib import Path

import pytest
import virtualrobot
from virtualrobot_apps.bridges.mqtt import MqttClient

from tests.apps.bridging import GUARD, check_values, create_signals, entries, free_port, mapping, running
from tests.kernels import KernelProcess, Stubs
from tests.waiting import until

MOSQUITTO = shutil.which("mosquitto", path="/usr/sbin:/usr/local/sbin:/opt/homebrew/sbin") or shutil.which("mosquitto")
USER, PASSWORD = "cell", "p@ss:w/rd"
WRITTEN = "p%40ss%3Aw%2Frd"
"""The password as an URL has it (RFC 3986, section 2.1)."""

pytestmark = [
    pytest.mark.long,
    pytest.mark.skipif(MOSQUITTO is None, reason="needs Mosquitto (the package mosquitto)"),
]


@pytest.fixture
def client(kernel: KernelProcess, stubs: Stubs) -> Iterator[virtualrobot.Client]:
    """Return a client of a kernel with the signals of these tests."""
    with virtualrobot.connect(kernel.address) as client:
        create_signals(client)
        yield client


@pytest.fixture
def place(tmp_path: Path) -> Iterator[str]:
    """Return host and port of a broker that knows one user."""
    assert MOSQUITTO is not None
    port, users, settings = free_port(), tmp_path / "users", tmp_path / "mosquitto.conf"
    subprocess.run(["mosquitto_passwd", "-b", "-c", str(users), USER, PASSWORD], check=True)
    lines = (f"listener {port} 127.0.0.1", "allow_anonymous false", f"password_file {users}", "user root")
    settings.write_text("\n".join(lines), "utf-8")
    with subprocess.Popen([MOSQUITTO, "-c", str(settings)]) as broker:
        try:
            until(lambda: is_served(port))
            yield f"127.0.0.1:{port}"
        finally:
            broker.terminate()


def is_served(port: int) -> bool:
    """Return whether somebody listens at a port."""
    with socket.socket() as asking:
        return asking.connect_ex(("127.0.0.1", port)) == 0


@pytest.mark.parametrize(
    ("login", "who"),
    [
        (f"{USER}:wrong@", f"the login of {USER!r}"),
        (f"nobody:{WRITTEN}@", "the login of 'nobody'"),
        ("", "a login without a user"),
    ],
)
def test_a_login_that_is_refused_is_told_once_and_changes_nothing(
    client: virtualrobot.Client, place: str, login: str, who: str
) -> None:
    read = mapping("mqtt", entries("mqtt", True), more="connected: there\n")
    client.signals["read speed"] = 1.5
    url = f"mqtt://{login}{place}"
    with running(client, read, MqttClient(read, url)) as said:
        until(lambda: bool(said))
        client.signals.wait_for("there", False, timeout=GUARD)
    (line,) = said
    assert line.startswith(f"mqtt://{place}: the broker refuses {who}: Not authorized"), line
    assert "mqtt://USER:PASSWORD@HOST:PORT" in line
    assert "wrong" not in line and WRITTEN not in line, "a password is no word for a log"
    assert client.signals["read speed"] == 1.5


def test_who_is_known_is_let_in_and_values_go_both_ways(client: virtualrobot.Client, place: str) -> None:
    url = f"mqtt://{USER}:{WRITTEN}@{place}"
    out = mapping("mqtt", entries("mqtt", False))
    read = mapping("mqtt", entries("mqtt", True), more="connected: there\n")
    with running(client, read, MqttClient(read, url)), running(client, out, MqttClient(out, url)):
        check_values(client)

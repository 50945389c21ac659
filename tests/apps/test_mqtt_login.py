"""Logins and access lists of Mosquitto, a broker of others: who may come in, and what they may hear."""

from __future__ import annotations

import json
import shutil
import socket
import subprocess
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest
import virtualrobot
from virtualrobot_apps.bridges.mqtt import MqttClient

from tests.apps.bridging import GUARD, check_values, create_signals, entries, free_port, mapping, running
from tests.kernels import KernelProcess, Stubs
from tests.waiting import until

MOSQUITTO = shutil.which("mosquitto", path="/usr/sbin:/usr/local/sbin:/opt/homebrew/sbin") or shutil.which("mosquitto")
RULES = next(iter(sorted(Path("/usr").glob("lib*/**/mosquitto_dynamic_security.so"))), None)
"""Mosquitto's dynamic security, which comes with it."""
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


@contextmanager
def serving(folder: Path, *lines: str) -> Iterator[str]:
    """Run a broker with these settings for the length of a block; give its host and port."""
    assert MOSQUITTO is not None
    port, settings = free_port(), folder / "mosquitto.conf"
    settings.write_text("\n".join((f"listener {port} 127.0.0.1", *lines, "user root")), "utf-8")
    with subprocess.Popen([MOSQUITTO, "-c", str(settings)]) as broker:
        try:
            until(lambda: is_served(port))
            yield f"127.0.0.1:{port}"
        finally:
            broker.terminate()


@pytest.fixture
def place(tmp_path: Path) -> Iterator[str]:
    """Return host and port of a broker that knows one user."""
    users = tmp_path / "users"
    subprocess.run(["mosquitto_passwd", "-b", "-c", str(users), USER, PASSWORD], check=True)
    with serving(tmp_path, "allow_anonymous false", f"password_file {users}") as place:
        yield place


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


@pytest.mark.parametrize("heard", [["cell/a", "cell/b", "cell/c"], ["cell/b"], []])
def test_topics_that_may_not_be_heard_are_told_by_name(
    client: virtualrobot.Client, tmp_path: Path, heard: list[str]
) -> None:
    """By the answer 0x80 to a subscription (MQTT 3.1.1, 3.9.3), which Mosquitto's dynamic security gives."""
    assert RULES is not None
    acls = [{"acltype": "subscribeLiteral", "topic": topic, "priority": 0, "allow": True} for topic in heard]
    access = {"publishClientSend": True, "publishClientReceive": True, "subscribe": False, "unsubscribe": True}
    whole = {
        "defaultACLAccess": access,
        "anonymousGroup": "all",
        "groups": [{"groupname": "all", "roles": [{"rolename": "hears"}], "clients": []}],
        "roles": [{"rolename": "hears", "acls": acls}],
        "clients": [],
    }
    rules = tmp_path / "rules.json"
    rules.write_text(json.dumps(whole), "utf-8")
    settings = "allow_anonymous true", f"plugin {RULES}", f"plugin_opt_config_file {rules}"
    client.signals["read speed"] = 1.5
    read = mapping("mqtt", entries("mqtt", True), more="connected: there\n")
    out = mapping("mqtt", entries("mqtt", False))
    with serving(tmp_path, *settings) as place:
        url = f"mqtt://{place}"
        with running(client, read, MqttClient(read, url)) as said, running(client, out, MqttClient(out, url)):
            if len(heard) == 3:
                check_values(client)
                assert said == [f"{url}: connected"]
                return
            until(lambda: bool(said))
            client.signals.wait_for("there", False, timeout=GUARD)
    which = "topics 'cell/a', 'cell/c'" if heard else "topics 'cell/a', 'cell/b', 'cell/c'"
    assert said == [
        f"{url}: the broker does not let whoever logs in without a user hear the {which}; its access list says who "
        "may; it is tried again each 1 s"
    ]
    assert client.signals["read speed"] == 1.5

"""Who gets in: tokens, roles, links and their sessions, TLS; and a kernel that ends and comes again."""

from __future__ import annotations

import http.client
import json
import re
import socket
import ssl
import subprocess
import sys
from pathlib import Path
from urllib.parse import urlsplit

import pytest
import trustme
import virtualrobot
from virtualrobot import InvalidArgumentError
from virtualrobot.kernel_process import KernelProcess
from virtualrobot.session import token_path
from virtualrobot_apps.console.door import MOST_LINKS, Door
from virtualrobot_apps.console.serving import listen

from tests.api.asking import IIWA
from tests.apps.console.consoles import Console, PageRefused, consoles
from tests.kernels import StartKernel
from tests.waiting import until

CLOCK = "KernelService/GetClock"
HOST = {"host": "127.0.0.1:8090"}


def test_a_link_is_good_once_and_its_session_is_for_the_own_page_alone() -> None:
    door = Door([], [], 8090, secure=False)
    key = door.new_link(lambda: "secret")
    cookie = door.enter(key)
    assert cookie is not None and "secret" not in cookie and "HttpOnly; SameSite=Strict" in cookie
    assert door.enter(key) is None and door.enter("") is None
    headers = HOST | {"cookie": cookie.partition(";")[0]}
    for own in (headers, headers | {"origin": "http://127.0.0.1:8090"}):
        token = door.token(own)
        assert token and token() == "secret"
    assert door.token(headers | {"origin": "http://127.0.0.1:9000"}) is None
    assert door.token(HOST | {"cookie": "virtualrobot-8090=other"}) is None
    assert door.token(HOST | {"cookie": "virtualrobot-8090"}) is None
    assert "Secure" in (Door([], [], 1, secure=True).enter(door.new_link(lambda: "x")) or "Secure")


def test_links_are_not_kept_without_end() -> None:
    door = Door([], [], 8090, secure=False)
    first = door.new_link(lambda: "secret")
    newer = [door.new_link(lambda: "secret") for _ in range(MOST_LINKS)]
    assert door.enter(first) is None and door.enter(newer[0]) is not None


@pytest.mark.parametrize(
    ("headers", "fault"),
    [
        ({"host": "127.0.0.1:8090"}, ""),
        ({"host": "[::1]:8090"}, ""),
        ({"host": "LOCALHOST:8090"}, ""),
        ({"host": "cell.example:8090"}, ""),
        ({}, "--host-name"),
        ({"host": "["}, "--host-name"),
        ({"host": "elsewhere.example"}, "--host-name"),
        ({"host": "127.0.0.1.elsewhere.example"}, "--host-name"),
        (HOST | {"origin": "http://127.0.0.1:8090"}, ""),
        (HOST | {"origin": "http://panel.example"}, ""),
        (HOST | {"origin": "https://127.0.0.1:8090"}, "--origin"),
        (HOST | {"origin": "http://127.0.0.1"}, "--origin"),
        (HOST | {"origin": "null"}, "--origin"),
    ],
)
def test_names_and_origins(headers: dict[str, str], fault: str) -> None:
    door = Door(["cell.example"], ["http://panel.example"], 8090, secure=False)
    said = door.fault(headers)
    assert fault in said and bool(said) == bool(fault)


@pytest.mark.parametrize(
    ("options", "said"),
    [
        (["--listen", "0.0.0.0"], "give --tls-certificate and --tls-key"),
        (["--tls-key", __file__], "--tls-certificate and --tls-key go together"),
        (
            ["--own-certificate", "--tls-certificate", __file__, "--tls-key", __file__],
            "--own-certificate goes without --tls-certificate and --tls-key",
        ),
        (["--origin", "panel.example"], "is no origin, such as https://panel.example"),
        (["--address", "127.0.0.1:1"], "no kernel answers at 127.0.0.1:1"),
    ],
)
@pytest.mark.long
def test_options_that_do_not_fit(options: list[str], said: str) -> None:
    done = subprocess.run([sys.executable, "-m", "virtualrobot", "console", *options], capture_output=True, text=True)
    assert done.returncode and said in done.stdout + done.stderr and "Traceback" not in done.stderr


def bearer(token: str) -> str:
    return f"Bearer {token}"


def cookie_of(link: str) -> str:
    """Open a link and return the browser's cookie."""
    parts = urlsplit(link)
    connection = http.client.HTTPConnection(parts.hostname or "", parts.port)
    connection.request("GET", f"{parts.path}?{parts.query}")
    response = connection.getresponse()
    response.read()
    connection.close()
    assert response.status == 303 and response.getheader("location") == "/"
    return (response.getheader("set-cookie") or "").partition(";")[0]


@pytest.mark.long
def test_the_kernel_judges_each_call_by_its_token(start_kernel: StartKernel) -> None:
    kernel = start_kernel(token=True)
    with (
        virtualrobot.connect(kernel.address, kernel.token) as client,
        consoles(kernel.address, token=kernel.token) as console,
    ):
        client.load_robot(IIWA, name="arm")
        assert console.ask(CLOCK).status == 401 and console.ask(CLOCK, authorization=bearer("wrong")).status == 401
        assert console.ask(CLOCK, authorization=bearer(kernel.token)).status == 200
        with console.page() as page, pytest.raises(PageRefused, match="unauthenticated"):
            page.ask(CLOCK)

        visitor = client.tokens.create("visitor", "observer").secret
        refused = console.ask("SceneService/LoadScene", authorization=bearer(visitor))
        assert refused.status == 403 and refused.reason == "ROLE_TOO_LOW" and refused.metadata["needs"] == "engineer"

        # The printed link is for what the console's own token may, one that a visitor asks for, what he may.
        for link, role in (
            (console.link, "ROLE_ADMIN"),
            (console.ask("/link", authorization=bearer(visitor)).json["url"], "ROLE_OBSERVER"),
        ):
            cookie = cookie_of(link)
            assert console.ask("KernelService/GetInfo", cookie=cookie).json["role"] == role
            assert "listens to this machine alone" in console.ask("/invitation", cookie=cookie).json["fault"]
            with console.page(Cookie=cookie) as page:
                assert page.ask("KernelService/GetInfo")["role"] == role
            # A token of the call's own goes before the session's.
            assert console.ask(CLOCK, cookie=cookie, authorization=bearer("wrong")).status == 401
        still = console.ask("/cell.usdz", verb="GET", authorization=bearer(visitor))
        assert (still.headers["content-type"], still.body[:2]) == ("model/vnd.usdz+zip", b"PK")
        assert console.ask("/cell.usdz", verb="GET").status == console.ask("/invitation").status == 401
        assert console.ask("/link").status == 401 and console.ask("/link", verb="GET").status == 404

        # Both watch the same, and the one whose token is withdrawn hears no more of it.
        with (
            console.page(Authorization=f"Bearer {visitor}") as his,
            console.page(Authorization=f"Bearer {kernel.token}") as mine,
        ):
            watches = [page.answers(page.open("RobotService/WatchRobotStates", {})) for page in (his, mine)]
            for watch in watches:
                assert next(watch)["robots"][0]["name"] == "arm"
            client.tokens.revoke("visitor")
            with pytest.raises(PageRefused, match="unauthenticated"):
                list(watches[0])
            client.robot("arm").move_joints([0.1] * 7)
            assert next(watches[1])["robots"]

        command = {"commands": [{"create_signal": {"signal": {"name": "lamp", "value": {"boolean": True}}}}]}
        assert (
            console.ask("SceneService/Apply", command, client_name="panel", authorization=bearer(kernel.token)).status
            == 200
        )
        assert "panel on 127.0.0.1" in client.history.list()[0].author


@pytest.mark.long
def test_a_page_goes_on_with_the_new_token_of_a_kernel_that_was_started_again(start_kernel: StartKernel) -> None:
    kernel = start_kernel(no_token=False)
    file = token_path(int(kernel.address.rpartition(":")[2]))
    token = file.read_text()
    with consoles(kernel.address) as console:
        cookie = cookie_of(console.link)
        other = cookie_of(console.ask("/link", cookie=cookie).json["url"])
        with console.page(Cookie=cookie) as page:
            assert page.ask(CLOCK)
            assert kernel.end() == 0
            start_kernel("--port", kernel.address.rpartition(":")[2], no_token=False)
            assert file.read_text() != token
            until(lambda: console.ask(CLOCK, cookie=cookie).status == 200)
            assert console.ask(CLOCK, cookie=other).status == 200
            assert page.ask(CLOCK)
        assert console.ask(CLOCK, authorization=bearer(token.strip())).status == 401


@pytest.mark.long
def test_a_kernel_that_ends_is_told_and_one_that_comes_again_is_found(start_kernel: StartKernel) -> None:
    kernel = start_kernel()
    port = kernel.address.rpartition(":")[2]
    with consoles(kernel.address) as console, console.page() as page:
        watch = page.answers(page.open("SceneService/WatchScene", {}))
        next(watch)
        kernel.end()
        with pytest.raises(PageRefused, match="unavailable"):
            list(watch)
        gone = console.ask(CLOCK)
        assert gone.status == 503 and "no kernel answers at" in gone.json["message"]
        start_kernel("--port", port)
        until(lambda: console.ask(CLOCK).status == 200)
        assert next(page.answers(page.open("SceneService/WatchScene", {})))["nodes"]


@pytest.mark.long
def test_tls_on_a_lan(start_kernel: StartKernel, tmp_path: Path) -> None:
    authority = trustme.CA()
    issued = authority.issue_cert("127.0.0.1", "cell.example")
    issued.cert_chain_pems[0].write_to_path(str(tmp_path / "certificate.pem"))
    issued.private_key_pem.write_to_path(str(tmp_path / "key.pem"))
    tls = ["--tls-certificate", str(tmp_path / "certificate.pem"), "--tls-key", str(tmp_path / "key.pem")]
    kernel = start_kernel(token=True)
    with consoles(kernel.address, *tls, "--host-name", "cell.example", token=kernel.token) as console:
        assert console.link.startswith("https://cell.example:")
        trusting = ssl.create_default_context()
        authority.configure_trust(trusting)
        connection = http.client.HTTPSConnection("127.0.0.1", console.port, context=trusting)
        key = urlsplit(console.link).query
        connection.request("GET", f"/?{key}", headers={"host": f"cell.example:{console.port}"})
        response = connection.getresponse()
        assert response.status == 303 and "; Secure" in (response.getheader("set-cookie") or "")
        response.read()
        headers = {"content-type": "application/json", "authorization": f"Bearer {kernel.token}"}
        connection.request("POST", "/virtualrobot.v1.KernelService/GetClock", b"{}", headers)
        assert json.loads(connection.getresponse().read())["clock"]
        connection.close()


@pytest.mark.long
def test_tls_by_an_authority_of_its_own(
    start_kernel: StartKernel, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("XDG_STATE_HOME", str(tmp_path))
    kernel = start_kernel(token=True)
    options = ["--own-certificate", "--host-name", "cell.local"]
    with consoles(kernel.address, *options, token=kernel.token) as console:
        assert console.link.startswith("https://cell.local:")
        assert "trusts" in console.line()
        trusting_anybody = ssl.create_default_context()
        trusting_anybody.check_hostname, trusting_anybody.verify_mode = False, ssl.CERT_NONE
        got = http.client.HTTPSConnection("127.0.0.1", console.port, context=trusting_anybody)
        got.request("GET", "/authority.crt")
        authority = got.getresponse()
        assert authority.status == 200 and authority.getheader("content-type") == "application/x-x509-ca-cert"
        trusting = ssl.create_default_context(cadata=authority.read().decode())
        got.close()
        connection = http.client.HTTPSConnection("127.0.0.1", console.port, context=trusting)
        connection.request("GET", "/")
        assert connection.getresponse().status == 200
        connection.close()


@pytest.mark.long
@pytest.mark.parametrize("body", [None, b"0" * 100_000])
def test_plain_http_to_a_port_of_tls_is_told_the_address(
    start_kernel: StartKernel, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, body: bytes | None
) -> None:
    monkeypatch.setenv("XDG_STATE_HOME", str(tmp_path))
    kernel = start_kernel(token=True)
    options = ["--own-certificate", "--host-name", "cell.local"]
    with consoles(kernel.address, *options, token=kernel.token) as console:
        plain = http.client.HTTPConnection("127.0.0.1", console.port)
        plain.request("GET" if body is None else "POST", "/?key=none", body)
        answer = plain.getresponse()
        assert answer.status == 400 and answer.getheader("connection") == "close"
        assert f"https://cell.local:{console.port}" in answer.read().decode()
        # Others go on, also while that one stays connected.
        trusting = ssl.create_default_context(cafile=str(tmp_path / "virtualrobot" / "authority" / "authority.pem"))
        other = http.client.HTTPSConnection("127.0.0.1", console.port, context=trusting)
        other.request("GET", "/")
        assert other.getresponse().status == 200
        other.close()
        plain.close()


def test_small_frames_are_not_held_back() -> None:
    """Without TCP_NODELAY each second frame waits for the other side's delayed acknowledgement, about 40 ms."""
    with listen("127.0.0.1", 0) as listening, socket.create_connection(listening.getsockname()):
        connection, _ = listening.accept()
        with connection:
            assert connection.getsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY)
        with pytest.raises(InvalidArgumentError, match="--port takes another one"):
            listen(*listening.getsockname())


def test_files_of_the_page(console: Console) -> None:
    page = console.ask("/", verb="GET")
    assert page.status == 200 and "default-src 'self'" in page.headers["content-security-policy"]
    assert page.headers["cache-control"] == "no-cache"
    assert console.ask("/calls.js", verb="GET").headers["content-type"].startswith("text/javascript")
    for path in re.findall(r'(?:src|href)="(/assets/[^"]+)"', page.body.decode()):
        file = console.ask(path, verb="GET")
        assert file.status == 200 and "immutable" in file.headers["cache-control"] and file.body
    for path in ("/../server.py", "/assets/../../server.py", "/assets/", "/app/index.html"):
        assert console.ask(path, verb="GET").status == 404
    used = console.ask("/?key=none", verb="GET")
    assert (used.status, used.headers["location"]) == (303, "/") and "set-cookie" not in used.headers


@pytest.mark.long
def test_serve_starts_it_and_ends_it() -> None:
    said: list[str] = []
    with KernelProcess("--no-token", say=said.append):
        until(lambda: any(line.startswith("console at ") for line in said))
        (link,) = [line.removeprefix("console at ") for line in said if line.startswith("console at ")]
        port = urlsplit(link).port or 0
        connection = http.client.HTTPConnection("127.0.0.1", port)
        connection.request(
            "POST", "/virtualrobot.v1.KernelService/GetClock", b"{}", {"content-type": "application/json"}
        )
        assert connection.getresponse().status == 200
        connection.close()

    def is_gone() -> bool:
        with socket.socket() as asking:
            return asking.connect_ex(("127.0.0.1", port)) != 0

    until(is_gone)
    said.clear()
    with KernelProcess("--no-token", "--no-console", say=said.append) as kernel:
        assert kernel.viewer_url
    assert not any("console" in line for line in said)

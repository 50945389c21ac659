"""Tools of the console beside the contract, asked by HTTP: who may, and what is refused."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path

import pytest
import virtualrobot
from websockets.exceptions import ConnectionClosed
from websockets.sync.client import connect

from tests.apps.console.consoles import Console, Reply, consoles
from tests.kernels import KernelProcess, StartKernel, Stubs
from tests.waiting import PATIENCE_SECONDS, until


def ask(console: Console, path: str, said: dict[str, object] | None = None, token: str = "", **headers: str) -> Reply:
    """Ask as a page does, with a token."""
    headers = {**headers, **({"authorization": f"Bearer {token}"} if token else {})}
    verb = "GET" if said is None else "POST"
    return console.ask(path, said or {}, verb, **headers)


@pytest.mark.long
def test_who_may_use_them(start_kernel: StartKernel) -> None:
    kernel = start_kernel(token=True)
    with (
        virtualrobot.connect(kernel.address, kernel.token) as client,
        consoles(kernel.address, token=kernel.token) as console,
    ):
        observer = client.tokens.create("looks", "observer").secret
        operator = client.tokens.create("works", "operator").secret
        client.signals.create("eye")
        client.signals.create("run")
        wire = {"target": "run", "source": {"not": "eye"}}

        # Nobody without a token, though the console has one; a page of others not at all.
        assert ask(console, "/connections").status == 401
        assert ask(console, "/connections/set", wire).status == 401
        assert ask(console, "/connections", token=kernel.token, origin="http://elsewhere.example").status == 403
        assert client.signals["run"] is False

        # Who looks may not change; what an operator connects runs with the operator's token.
        assert ask(console, "/connections", token=observer).status == 200
        refused = ask(console, "/connections/set", wire, observer)
        assert refused.status == 403
        assert refused.json["message"] == "this needs the role operator, and the token is one of the role observer"
        assert ask(console, "/connections/set", wire, operator).json == {}
        assert client.signals["run"] is True
        state = ask(console, "/connections", token=observer).json
        assert state["running"] and state["file"]["connections"] == {"run": {"not": "eye"}}

        # So it is with programs of pages: without a token there is no editor, and who looks may run nothing.
        editor = f"{console.url.replace('http', 'ws')}/editor"
        with connect(editor) as page, pytest.raises(ConnectionClosed) as closed:
            page.recv(PATIENCE_SECONDS)
        assert closed.value.rcvd is not None and closed.value.rcvd.code == 1008
        launch = {"type": "request", "seq": 1, "command": "launch", "arguments": {}}
        with connect(editor, additional_headers={"authorization": f"Bearer {observer}"}) as page:
            page.send(json.dumps({"dap": launch}))
            told = json.loads(page.recv(PATIENCE_SECONDS))["dap"]
        assert told["message"] == "this needs the role operator, and the token is one of the role observer"

        # A signal that an operator may not make: the kernel's words, and what runs goes on.
        made = "schema_version: 1\nsignals: [{name: new}]\nconnections: {run: eye}\n"
        refused = ask(console, "/connections/open", {"text": made, "name": "made.yaml"}, operator)
        assert refused.status == 403
        assert ask(console, "/connections", token=observer).json["file"]["connections"] == {"run": {"not": "eye"}}
        client.signals["eye"] = True
        until(lambda: client.signals["run"] is False)


@pytest.mark.long
def test_it_begins_with_a_file(stepped: Stubs, stepped_kernel: KernelProcess, tmp_path: Path) -> None:
    file = tmp_path / "cell.yaml"
    file.write_text("schema_version: 1\nsignals: [{name: eye}, {name: run}]\nconnections: {run: {not: eye}}\n")
    with (
        virtualrobot.connect(stepped_kernel.address) as client,
        consoles(stepped_kernel.address, "--connections", str(file)) as console,
    ):
        until(lambda: client.signals["run"] is True)
        assert ask(console, "/connections").json["name"] == "cell.yaml"
    file.write_text("schema_version: 1\nconnections: {run: {nod: eye}}\n")
    command = [sys.executable, "-m", "virtualrobot", "console", "--address", stepped_kernel.address, "--port", "0"]
    ended = subprocess.run([*command, "--connections", file], capture_output=True, text=True, timeout=300)
    assert (ended.returncode, ended.stdout) == (1, "")
    assert "cell.yaml:2: connections.run.nod: there is no operator 'nod'; did you mean 'not'?" in ended.stderr


@pytest.mark.parametrize(
    ("path", "said", "words"),
    [
        ("/connections/set", {"target": "a"}, "needs its 'source'"),
        ("/connections/set", {"target": "", "source": "b"}, "needs the signal that it drives"),
        ("/connections/set", {"target": "a", "source": ["b"]}, "a list needs an operator before it"),
        ("/connections/set", {"target": "a", "source": {"and": ["b"]}}, "takes two or more"),
        ("/connections/set", {"target": "a", "source": None}, "there is no signal"),
        ("/connections/remove", {"target": "a"}, "no connection of this console drives 'a'"),
        ("/connections/open", {"text": "- 1", "name": "x.yaml"}, "x.yaml:1: "),
        ("/connections/open", {"text": "#" * 1_000_001, "name": "x.yaml"}, "at most 1000000"),
        ("/connections/open", {"text": 5}, "'text' is a text, not 5"),
        ("/curves", {}, "'curves' is a list of 1 to 16 texts"),
        ("/curves", {"curves": ["/clock:time"] * 17}, "'curves' is a list of 1 to 16 texts"),
        ("/curves", {"curves": [5]}, "'curves' is a list of 1 to 16 texts"),
        ("/curves", {"curves": ["/nobody:x"]}, "'/nobody'"),
        ("/curves", {"curves": ["/robots/*/command/position"]}, "/robots/*/command/position"),
        ("/mapping", {}, "a device is gamepad or space-mouse or keyboard, not ''"),
        ("/mapping", {"device": "gamepad", "text": "hold: x", "name": "a.yaml"}, "a.yaml: schema_version is None"),
        ("/mapping", {"device": "gamepad", "text": "a: &a [1]\nb: [*a, *a]"}, "aliases (*name) are not read"),
        ("/mapping", {"device": "space-mouse", "text": "[" * 9_999}, "mapping.yaml is not YAML"),
        ("/mapping", {"device": "space-mouse", "text": "#" * 100_001}, "at most 100000"),
    ],
)
def test_what_is_wrong_is_told_in_words(console: Console, path: str, said: dict[str, object], words: str) -> None:
    refused = ask(console, path, said)
    assert 400 <= refused.status < 500, refused.body
    assert words in refused.json["message"]


def test_a_mapping_is_told_as_the_command_line_reads_it(console: Console) -> None:
    keys = ask(console, "/mapping", {"device": "keyboard"}).json
    assert (keys["hold"], keys["jog"]["1"]["buttons"]) == ("shift", ["1", "q"])
    usual = ask(console, "/mapping", {"device": "space-mouse"}).json
    assert usual["camera"]["right"] == {"axis": "x", "sign": -1.0, "buttons": ["", ""]}
    assert (usual["hold"], usual["dead_zone"], usual["frame"], usual["jog"]) == ("left", 0.1, "base", {})
    assert usual["tool"]["vx"] == {"axis": "y", "sign": -1.0, "buttons": ["", ""]}
    mine = "{schema_version: 1, hold: a, jog: {2: [x, b]}}"
    said = ask(console, "/mapping", {"device": "gamepad", "text": mine}).json
    assert (said["hold"], said["dead_zone"]) == ("a", 0.15)
    assert said["jog"] == {"2": {"axis": "", "sign": 1.0, "buttons": ["x", "b"]}}


def test_what_is_no_object_is_refused(console: Console) -> None:
    for body in (b"[]", b"{", b"\xff", b"[" * 100_000):
        refused = console.ask("/connections/set", body)
        assert refused.status == 400, body[:10]
        assert "one object as JSON" in refused.json["message"]
    assert console.ask("/connections/set", verb="GET").status == 405
    assert console.ask("/connections", {}).status == 405

"""Robot Web Services 2.0 of the emulated ABB controller: rwswrap, unmodified, and the forms that its clients take."""

from __future__ import annotations

import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any
from urllib.parse import quote
from xml.etree import ElementTree

import numpy as np
import pytest
import requests
import trustme
import virtualrobot
from click.testing import CliRunner
from requests.auth import HTTPBasicAuth, HTTPDigestAuth
from rwswrap.RWS import RWS
from virtualrobot_apps.emulators.abb.digest import Basic
from virtualrobot_apps.emulators.abb.table import RESOURCES
from virtualrobot_apps.emulators.command import emulate
from websocket import create_connection

from tests.apps.abb import PASSWORD, USER, Served, served
from tests.kernels import KernelProcess
from tests.waiting import PATIENCE_SECONDS, until

pytestmark = pytest.mark.long

MODULE = """MODULE arrs_mod
  PERS num count := 0;
  PERS string words := "a";
  PROC main()
    MoveAbsJ [[0,0,0,0,30,0],[9E9,9E9,9E9,9E9,9E9,9E9]], vmax, fine, tool0;
    SetDO doDone, 1;
    count := count + 1;
  ENDPROC
ENDMODULE
"""
HAL, XHTML = "application/hal+json;v=2.0", "application/xhtml+xml;v=2.0"
FORM, TEXT = "application/x-www-form-urlencoded;v=2.0", "text/plain;v=2.0"


@pytest.fixture(scope="module")
def certificate(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, Path, Path]:
    """Return files of a certificate, its key, and the authority that has issued it."""
    folder, authority = tmp_path_factory.mktemp("tls"), trustme.CA()
    issued = authority.issue_cert("127.0.0.1")
    files = folder / "certificate.pem", folder / "key.pem", folder / "authority.pem"
    issued.cert_chain_pems[0].write_to_path(str(files[0]))
    issued.private_key_pem.write_to_path(str(files[1]))
    authority.cert_pem.write_to_path(str(files[2]))
    return files


@pytest.fixture
def abb(client: virtualrobot.Client, certificate: tuple[Path, Path, Path], tmp_path: Path) -> Iterator[Served]:
    client.clock.speed_factor = 5.0
    client.load_robot("model://irb120", name="arm")
    with served(client, ["arm"], tmp_path, certificate[:2]) as one:
        yield one


@pytest.fixture
def session(certificate: tuple[Path, Path, Path]) -> Iterator[requests.Session]:
    """Give what asks as clients do: by Basic, for HAL."""
    with requests.Session() as one:
        one.auth, one.verify = HTTPBasicAuth(USER, PASSWORD), str(certificate[2])
        one.headers["Accept"] = HAL
        one.trust_env = False  # its variables would say whom to trust
        yield one


def put_module(abb: Served, session: requests.Session) -> None:
    """Write the file of the module."""
    url = f"{abb.url}/fileservice/HOME/arrs_mod.modx"
    assert session.put(url, data=MODULE, headers={"Content-Type": TEXT}).status_code == 201


def told(answer: requests.Response) -> list[dict[str, Any]]:
    """Return the items of an answer."""
    assert (answer.status_code, answer.headers["content-type"]) == (200, HAL), answer.text
    found = answer.json()
    assert found["status"] == {"code": 294912}
    return found["state"] if "state" in found else found["_embedded"]["resources"]


def test_a_client_of_robotware_7_loads_starts_and_reads_a_program(
    abb: Served, session: requests.Session, certificate: tuple[Path, Path, Path], client: virtualrobot.Client
) -> None:
    put_module(abb, session)
    trusted: Any = str(certificate[2])  # which it gives to requests
    rws: Any = RWS(abb.url, USER, PASSWORD, verify=trusted)
    assert rws.load_module().status_code == 204
    assert rws.get_modules() == ["arrs_mod"]
    assert rws.set_rapid_variable("count", 5).status_code == 204
    assert rws.set_rapid_variable("words", '"b"').status_code == 204
    assert (rws.get_rapid_variable("count"), rws.get_rapid_variable("words")) == ("5", '"b"')
    assert rws.toggle_motors(0).status_code == 204 and rws.start_RAPID().status_code == 400  # without motors
    assert not rws.is_running() and rws.get_rapid_variable("count") == "5"
    assert rws.toggle_motors(1).status_code == 204
    rws.start_RAPID()
    until(lambda: client.signals["doDone"])
    until(lambda: not rws.is_running())
    assert rws.get_rapid_variable("count") == "6" and rws.stop_RAPID().status_code == 204
    answer = rws.session.get(f"{abb.url}/rw/rapid/tasks/T_ROB9", headers={"Accept": HAL}, verify=trusted)
    assert answer.status_code == 404
    assert answer.json()["status"] == {"code": -1073445879, "msg": "there is no task 'T_ROB9'; there are: T_ROB1"}


def test_answers_have_the_shape_that_virtual_controllers_give(
    abb: Served, session: requests.Session, client: virtualrobot.Client
) -> None:
    """The shapes are those that the tests of abb-rws-client have kept of RobotWare 7.21."""
    put_module(abb, session)
    form = {"Content-Type": FORM}
    load = session.post(f"{abb.url}/rw/rapid/tasks/T_ROB1/loadmod", "modulepath=HOME/arrs_mod.modx", headers=form)
    assert load.status_code == 204, load.text
    answer = session.get(f"{abb.url}/rw/panel/ctrl-state")
    assert answer.json() == {
        "_links": {"base": {"href": f"{abb.url}/rw/panel/"}, "self": {"href": ""}},
        "status": {"code": 294912},
        "state": [{"_type": "pnl-ctrlstate", "_title": "ctrl-state", "ctrlstate": "motoron"}],
    }
    (task,) = session.get(f"{abb.url}/rw/rapid/tasks").json()["_embedded"]["resources"]
    assert (task["_links"], task["_type"], task["type"], task["name"], task["taskstate"], task["active"]) == (
        {"self": {"href": "tasks/T_ROB1"}},
        "rap-task-li",
        "normal",
        "T_ROB1",
        "linked",
        "On",
    )
    (module,) = session.get(f"{abb.url}/rw/rapid/tasks/T_ROB1/modules").json()["state"]
    assert module == {
        "_type": "rap-module-info-li",
        "_title": "T_ROB1/arrs_mod",
        "name": "arrs_mod",
        "type": "ProgMod",
    }
    (joints,) = told(session.get(f"{abb.url}/rw/motionsystem/mechunits/ROB_1/jointtarget"))
    np.testing.assert_allclose(float(joints["rax_5"]), np.degrees(client.robot("arm").positions[4]))
    (system,) = told(session.get(f"{abb.url}/rw/system"))
    assert system["major"] == "7"
    session.post(f"{abb.url}/rw/iosystem/signals/Local/DRV_1/doDone/set-value", "lvalue=1", headers=form)
    assert client.signals["doDone"] is True
    session.post(f"{abb.url}/rw/panel/speedratio?action=setspeedratio", "speed-ratio=50", headers=form)
    assert client.robot("arm").speed_factor == 0.5
    found = session.post(f"{abb.url}/rw/rapid/symbols/search", "regexp=count", headers=form)
    assert [one["_links"]["self"]["href"] for one in told(found)] == ["symbol/RAPID/T_ROB1/count/data"]
    assert session.post(f"{abb.url}/rw/rapid/tasks/deactivate", "task=T_ROB1", headers=form).status_code == 204
    (task,) = told(session.get(f"{abb.url}/rw/rapid/tasks/T_ROB1"))
    assert task["active"] == "Off"
    assert session.post(f"{abb.url}/fileservice/HOME/create", "fs-newname=new", headers=form).status_code == 204
    listed = [one["_title"] for one in session.get(f"{abb.url}/fileservice/HOME").json()["state"]]
    assert listed == ["arrs_mod.modx", "new"]
    page = ElementTree.fromstring(session.get(f"{abb.url}/rw/panel/ctrl-state", headers={"Accept": XHTML}).content)
    assert [one.text for one in page.iter("{http://www.w3.org/1999/xhtml}span")] == ["motoron"]


def test_every_resource_that_is_read_tells_the_same_in_xhtml_and_hal(abb: Served, session: requests.Session) -> None:
    put_module(abb, session)
    form = {"Content-Type": FORM}
    session.post(f"{abb.url}/rw/rapid/tasks/T_ROB1/loadmod", "modulepath=$HOME/arrs_mod.modx", headers=form)
    session.post(f"{abb.url}/rw/dipc", "dipc-queue-name=q", headers=form)
    names = {"task": "T_ROB1", "module": "arrs_mod", "unit": "ROB_1", "domain": "0", "number": "1", "queue": "q"}
    paths = {"/fileservice/{path*}": "HOME", "/rw/iosystem/signals/{path*}": "doDone"}
    read = 0
    for one in RESOURCES:
        if one.method != "GET" or one.second is None:
            continue
        template = one.second.template
        path = template.replace("{path*}", paths.get(template, "T_ROB1/arrs_mod/words")).format(**names)
        as_hal, as_xhtml = (session.get(f"{abb.url}{path}", headers={"Accept": kind}) for kind in (HAL, XHTML))
        assert as_xhtml.headers["content-type"] == XHTML, path
        items = ElementTree.fromstring(as_xhtml.content).findall(".//{http://www.w3.org/1999/xhtml}li")
        for item, same in zip(items, told(as_hal), strict=True):
            spans = {str(span.get("class")): span.text or "" for span in item if span.tag.endswith("span")}
            values = {name: value for name, value in same.items() if name != "_links"}
            assert {**spans, "_type": item.get("class"), "_title": item.get("title")} == values, path
        read += 1
    assert read > 15


def test_changes_are_told_by_a_websocket(
    abb: Served, session: requests.Session, certificate: tuple[Path, Path, Path], client: virtualrobot.Client
) -> None:
    client.signals.create("doDone")
    body = "resources=1&1=/rw/panel/ctrl-state;ctrlstate&1-p=1&resources=2&2=/rw/iosystem/signals/doDone;state&2-p=2"
    made = session.post(f"{abb.url}/subscription", body, headers={"Content-Type": FORM})
    assert made.status_code == 201, made.text
    location = made.headers["location"]
    assert location.startswith(f"wss://127.0.0.1:{abb.port}/poll/")
    cookie = "; ".join(f"{name}={value}" for name, value in session.cookies.items())
    socket: Any = create_connection(
        location,
        subprotocols=["rws_subscription"],
        cookie=cookie,
        sslopt={"ca_certs": str(certificate[2])},
        timeout=PATIENCE_SECONDS,
    )
    try:
        assert socket.subprotocol == "rws_subscription"
        first, second = socket.recv(), socket.recv()
        assert 'class="ctrlstate">motoron<' in first and 'class="lvalue">0<' in second
        client.signals["doDone"] = True
        assert 'class="lvalue">1<' in socket.recv()
    finally:
        socket.close()
    wrong = session.post(f"{abb.url}/subscription", "resources=1&1=/rw/panel/ctrlstate", headers={"Content-Type": FORM})
    assert wrong.status_code == 400 and "/rw/panel/ctrl-state, " in wrong.json()["status"]["msg"]


def test_who_may_come_in_and_with_what(
    abb: Served, session: requests.Session, certificate: tuple[Path, Path, Path]
) -> None:
    path, trusted = f"{abb.url}/rw/panel/opmode", str(certificate[2])
    for auth in (None, HTTPBasicAuth(USER, "wrong"), HTTPDigestAuth(USER, PASSWORD)):
        answer = requests.get(path, auth=auth, verify=trusted)
        assert answer.status_code == 401 and answer.headers["www-authenticate"].startswith("Basic realm=")
    session.get(path)
    assert session.cookies["-http-session-"] and session.cookies["ABBCX"]
    assert requests.get(path, cookies=session.cookies, verify=trusted).status_code == 200
    for method, headers, body, status, words in (
        ("GET", {"Accept": "application/json"}, "", 406, "Accept is application/hal+json;v=2.0 or application/xhtml"),
        ("POST", {"Content-Type": "application/x-www-form-urlencoded"}, "a=1", 415, "each with ';v=2.0' behind"),
        ("POST", {"Content-Type": FORM}, "a=1", 405, "takes GET, not POST"),
    ):
        answer = session.request(method, path, data=body, headers=headers)
        assert answer.status_code == status and words in answer.text.replace("&#x27;", "'"), answer.text
    door = Basic({USER: PASSWORD, "ä": "ö"})
    assert door.accepts("Basic w6Q6w7Y=", "GET", "/") == "yes"
    for header in ("", "Basic", "Basic !", "Basic w6Q6w7Y", "Basic ä", "Digest w6Q6w7Y="):
        assert door.accepts(header, "GET", "/") == "no"


def test_malformed_requests_break_nothing(abb: Served, session: requests.Session, rng: np.random.Generator) -> None:
    names = {"task": "T_ROB1", "path*": "x", "module": "Cell", "unit": "ROB_1", "domain": "0", "number": "1"}
    names |= {"queue": "q"}
    forms = [(one.method, one.second) for one in RESOURCES if one.second is not None]
    body = b"cycle=once&task=T_ROB1&lvalue=1&value=[1,2]&modulepath=HOME/a&dipc-data=x&fs-newname=b&speed-ratio=5"
    done = 0
    for number in range(300):
        method, form = forms[number % len(forms)]
        path, data = bytearray(form.template.format_map(names).encode()), bytearray(body)
        for text in (path, data):
            for _ in range(rng.integers(0, 3)):
                place = int(rng.integers(1, len(text)))
                text[place : place + int(rng.integers(0, 3))] = rng.bytes(int(rng.integers(0, 3)))
        url = f"{abb.url}{quote(bytes(path))}"
        answer = session.request(method, url, data=bytes(data), headers={"Content-Type": FORM})
        assert answer.status_code < 500, (method, url, answer.text)
        done += answer.status_code < 300
    assert done > 50


def test_the_command_serves_it(
    kernel: KernelProcess, client: virtualrobot.Client, certificate: tuple[Path, Path, Path]
) -> None:
    client.load_robot("model://irb120", name="arm")
    file, key, authority = map(str, certificate)
    trusted: Any = authority
    command = [sys.executable, "-m", "virtualrobot", "emulate", "abb", "arm", "--port", "0", "--rws", "2.0"]
    command += ["--tls-certificate", file, "--tls-key", key, "--until-input-ends", "--address", kernel.address]
    with subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True) as process:
        try:
            assert process.stdout is not None
            url = process.stdout.readline().split()[4].rstrip(";")
            assert url.startswith("https://127.0.0.1:")
            rws: Any = RWS(url, USER, PASSWORD, verify=trusted)
            assert rws.get_exec_state() == "stopped"
        finally:
            process.kill()
    for arguments in (["--rws", "2.0"], ["--tls-key", key], ["--tls-certificate", file, "--tls-key", key]):
        done = CliRunner().invoke(emulate, ["abb", "arm", *arguments, "--address", kernel.address])
        assert done.exit_code != 0 and "go with --rws 2.0, which is HTTPS and needs both" in done.output
    wrong = ["--rws", "2.0", "--tls-certificate", key, "--tls-key", key, "--port", "0", "--address", kernel.address]
    done = CliRunner().invoke(emulate, ["abb", "arm", *wrong])
    assert done.exit_code != 0 and "are no certificate and its key" in done.output

"""The emulated ABB controller: abb-robot-client, unmodified, loads, starts, watches and stops RAPID in a kernel."""

from __future__ import annotations

import asyncio
import socket
import subprocess
import sys
import threading
import time
import tracemalloc
from collections.abc import Iterator
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import numpy as np
import pytest
import requests
import virtualrobot
from abb_robot_client.rws import (
    ABBException,
    JointTarget,
    SubscriptionResourcePriority,
    SubscriptionResourceRequest,
    SubscriptionResourceType,
)
from click.testing import CliRunner
from requests.auth import HTTPBasicAuth, HTTPDigestAuth
from virtualrobot_apps.emulators.abb.digest import Digest
from virtualrobot_apps.emulators.abb.server import MOST_SESSIONS
from virtualrobot_apps.emulators.abb.table import RESOURCES
from virtualrobot_apps.emulators.command import emulate
from virtualrobot_kernel.serve import SWITCH_INTERVAL_SECONDS

from tests.apps.abb import PASSWORD, USER, Served, load, run, served, stands
from tests.kernels import KernelProcess
from tests.waiting import until

pytestmark = pytest.mark.long

MODULE = """MODULE Cell
  PERS num count := 0;
  PERS num speeds{3} := [100, 200, 300];
  PERS string words := "a ""quoted"" word";
  PERS bool go := FALSE;
  PERS jointtarget there := [[10,0,0,0,30,0],[9E9,9E9,9E9,9E9,9E9,9E9]];
  TASK PERS tooldata grip := [TRUE,[[0,0,100],[1,0,0,0]],[1,[0,0,50],[1,0,0,0],0,0,0]];
  VAR num rounds := 0;
  CONST jointtarget ready := [[0,0,0,0,30,0],[9E9,9E9,9E9,9E9,9E9,9E9]];
  PROC main()
    MoveAbsJ ready, vmax, fine, tool0;
    MoveAbsJ there, vmax, fine, tool0;
    SetDO doDone, 1;
    count := count + 1;
    rounds := rounds + 1;
  ENDPROC
ENDMODULE
"""
SLOW = """MODULE Cell
  PERS num count := 0;
  PERS num far := 0;
  PROC main()
    MoveAbsJ [[0,0,0,0,30,0],[9E9,9E9,9E9,9E9,9E9,9E9]], vmax, fine, tool0;
    count := 1;
    MoveAbsJ [[90,0,0,0,30,0],[9E9,9E9,9E9,9E9,9E9,9E9]], v200, fine, tool0;
    count := 2;
  ENDPROC
ENDMODULE
"""
FOREVER = """MODULE Cell
  PERS num count := 0;
  PERS num more := 1;
  PROC main()
    count := count + more;
    WaitTime 0.01;
  ENDPROC
ENDMODULE
"""
SUBSCRIBED, HIGH = SubscriptionResourceType, SubscriptionResourcePriority.High


@pytest.fixture
def arm(client: virtualrobot.Client) -> virtualrobot.Robot:
    """Return an IRB 120 that stands somewhere in a world whose time goes five times as fast."""
    client.clock.speed_factor = 5.0
    return client.load_robot("model://irb120", name="arm", pose=virtualrobot.pose(0.5, -0.3, 0.2, yaw=0.4))


@pytest.fixture
def abb(client: virtualrobot.Client, arm: virtualrobot.Robot, tmp_path: Path) -> Iterator[Served]:
    with served(client, ["arm"], tmp_path) as one:
        yield one


def asked(abb: Served, path: str, method: str = "GET", **more: Any) -> requests.Response:  # noqa: ANN401
    """Return the answer to a request of its own, with Digest."""
    answer = requests.request(method, f"{abb.url}{path}", auth=HTTPDigestAuth(USER, PASSWORD), **more)
    number = answer.cookies.get("-http-session-")
    if number is not None:
        requests.get(f"{abb.url}/logout", cookies={"-http-session-": number})
    return answer


def test_a_program_is_loaded_started_watched_and_read(abb: Served, client: virtualrobot.Client) -> None:
    rws, events = abb.client(), []
    assert rws.get_execution_state() == ("stopped", "forever")
    assert (rws.get_controller_state(), rws.get_operation_mode(), rws.get_speedratio()) == ("motoron", "AUTO", 100.0)
    load(rws, MODULE)
    assert rws.list_files("$HOME") == ["tried.mod"] and rws.read_file("$HOME/tried.mod") == MODULE.encode()
    rws.set_rapid_variable_num("count", 5)
    kinds = [(SUBSCRIBED.ExecutionState, None), (SUBSCRIBED.PersVar, "count"), (SUBSCRIBED.Signal, "doDone")]
    kinds += [(SUBSCRIBED.Elog, None), (SUBSCRIBED.ControllerState, None), (SUBSCRIBED.OperationalMode, None)]
    watched = rws.subscribe([SubscriptionResourceRequest(kind, HIGH, what) for kind, what in kinds], events.append)
    until(lambda: len(events) == 5)  # the states that there are; the log has no state
    rws.resetpp()
    rws.start(cycle="once")
    until(lambda: client.signals["doDone"])
    until(stands(rws))
    until(lambda: [type(one).__name__ for one in events].count("RAPIDExecutionState") == 3)
    watched.close()
    told = {name: [one for one in events if type(one).__name__ == name] for name in {type(e).__name__ for e in events}}
    assert [one.ctrlexecstate for one in told["RAPIDExecutionState"]] == ["stopped", "running", "stopped"]
    assert [one.value for one in told["VariableValue"]] == ["5", "6"]
    assert [one.lvalue for one in told["Signal"]] == ["0", "1"]
    assert [one.state for one in told["ControllerState"]] == ["motoron"]
    codes = {one.seqnum: (one.code, one.title) for one in rws.read_event_log()}
    assert [codes[int(one.seqnum)][0] for one in told["EventLogEntryEvent"]] == [10002, 10150, 10125]
    np.testing.assert_allclose(rws.get_jointtarget().robax, [10.0, 0.0, 0.0, 0.0, 30.0, 0.0], atol=1e-6)
    # It is run again: persistents and variables go on; after resetpp variables begin anew, and persistents stay.
    rws.start(cycle="once")
    until(stands(rws))
    assert (rws.get_rapid_variable("count"), rws.get_rapid_variable("rounds")) == ("7", "2")
    rws.resetpp()
    assert (rws.get_rapid_variable("count"), rws.get_rapid_variable("rounds")) == ("7", "0")
    task = rws.get_tasks()["T_ROB1"]
    assert task == ("T_ROB1", "norm", "linked", "ready", True, True)


def test_a_stopped_program_stands_on_its_path_and_goes_on(abb: Served) -> None:
    rws = abb.client()
    load(rws, SLOW)
    rws.resetpp()
    rws.start(cycle="once")
    until(lambda: rws.get_jointtarget().robax[0] > 10.0)
    rws.stop()
    until(stands(rws))
    there = rws.get_jointtarget().robax
    assert 10.0 < there[0] < 89.0 and rws.get_rapid_variable("count") == "1"
    pointer = rws._do_get("rw/rapid/tasks/T_ROB1/pcp")["_embedded"]["_state"][0]
    assert (pointer["modulename"], pointer["routinename"], pointer["beginposition"]) == (
        "Cell",
        "main",
        "8,1",
    )  # it waits there
    assert rws.get_tasks()["T_ROB1"].excstate == "stopped"
    np.testing.assert_array_equal(rws.get_jointtarget().robax, there)
    rws.start()
    until(stands(rws))
    np.testing.assert_allclose(rws.get_jointtarget().robax[0], 90.0, atol=1e-6)
    assert rws.get_rapid_variable("count") == "2"
    assert [one.code for one in rws.read_event_log()][:3] == [10125, 10151, 10150]
    # What was stopped is given up by resetpp, and by another module.
    for give_up in (rws.resetpp, lambda: load(rws, FOREVER, replace="true")):
        rws.start(cycle="once") if give_up is rws.resetpp else (rws.resetpp(), rws.start(cycle="once"))
        until(lambda: rws.get_jointtarget().robax[0] < 80.0)
        rws.stop()
        until(stands(rws))
        give_up()
        assert rws.get_execution_state().ctrlexecstate == "stopped"


def test_data_of_programs(abb: Served) -> None:
    rws = abb.client()
    load(rws, MODULE)
    texts = {"count": "0", "speeds": "[100,200,300]", "words": '"a ""quoted"" word"', "go": "FALSE", "rounds": "0"}
    assert {name: rws.get_rapid_variable(name) for name in texts} == texts
    assert rws.get_rapid_variable("Cell/COUNT") == "0" and rws.get_rapid_variable("user/reg1") == "0"
    rws.set_rapid_variable_num_array("speeds", [1.5, 2, 3])
    np.testing.assert_array_equal(rws.get_rapid_variable_num_array("speeds"), [1.5, 2.0, 3.0])
    rws.set_rapid_variable("words", '"say ""it"""')
    assert rws.get_rapid_variable("words") == '"say ""it"""'
    joints = JointTarget(np.radians([1.0, 2.0, 3.0, 4.0, 5.0, 6.0]), np.zeros(6))
    rws.set_rapid_variable_jointtarget("there", joints)
    np.testing.assert_allclose(rws.get_rapid_variable_jointtarget("there").robax, joints.robax, atol=1e-6)
    names = [one["symburl"] for one in rws.get_rapid_variables()]
    assert names[:6] == [f"RAPID/T_ROB1/{one}" for one in ("count", "speeds", "words", "go", "there", "grip")]
    found = asked(abb, "/rw/rapid/symbol/properties/RAPID/T_ROB1/Cell/speeds?json=1").json()["_embedded"]["_state"][0]
    assert (found["dattyp"], found["ndim"], found["dim"], found["symtyp"]) == ("num", "1", "3", "per")
    for name, value, words in (
        ("count", "many", "'many' is no value of 'count', a num"),
        ("speeds", "[1,2]", "'[1,2]' is no value of 'speeds', a num{*}"),
        ("go", "1", "'1' is no value of 'go', a bool"),
        ("ready", "[]", "'ready' is a constant; a persistent is set at any time"),
        ("lost", "1", "there is no datum 'lost' in T_ROB1"),
    ):
        with pytest.raises(ABBException) as caught:
            rws.set_rapid_variable(name, value)
        assert str(caught.value) == words


def test_places_are_those_of_the_kernel(abb: Served, client: virtualrobot.Client, arm: virtualrobot.Robot) -> None:
    rws = abb.client()
    load(rws, MODULE)
    arm.move_joints([0.3, 0.2, -0.1, 0.4, 0.7, -0.5])
    flange, base = client.scene.pose(arm.flange), virtualrobot.pose(0.5, -0.3, 0.2, yaw=0.4)
    np.testing.assert_allclose(np.radians(rws.get_jointtarget().robax), arm.state.positions, atol=1e-8)
    target = rws.get_robtarget()
    np.testing.assert_allclose(target.trans, 1e3 * (np.linalg.inv(base) @ flange)[:3, 3], atol=1e-3)
    np.testing.assert_array_equal(target.robconf, [0.0, 0.0, -1.0, 0.0])
    np.testing.assert_allclose(np.linalg.norm(target.rot), 1.0)
    np.testing.assert_allclose(rws.get_robtarget(coordinate="World").trans, 1e3 * flange[:3, 3], atol=1e-3)
    tip = flange @ virtualrobot.pose(0.0, 0.0, 0.1)
    np.testing.assert_allclose(rws.get_robtarget(tool="grip", coordinate="World").trans, 1e3 * tip[:3, 3], atol=1e-3)
    for names, words in (
        ({"mechunit": "ROB_2"}, "no mechanical unit 'ROB_2'; there are: ROB_1"),
        ({"tool": "count"}, "'count' is a num, and no tooldata"),
        ({"coordinate": "Room"}, "no coordinate system 'Room'; there are: Base, World, Wobj"),
    ):
        with pytest.raises(ABBException, match=words):
            rws.get_robtarget(**names)


def test_signals_speed_and_motors(abb: Served, client: virtualrobot.Client) -> None:
    rws = abb.client()
    client.signals.create("pressure", 0.5)
    client.signals.create("doGripper")
    client.signals.create("group", 3)
    client.signals.create("text", "no signal of a controller")
    rws.set_digital_io("doGripper", 1)
    rws.set_analog_io("pressure", 2.25)
    rws.set_analog_io("group", 7)
    assert client.signals["doGripper"] is True
    assert (rws.get_digital_io("DOGRIPPER"), rws.get_analog_io("pressure"), rws.get_digital_io("group")) == (1, 2.25, 7)
    listed = asked(abb, "/rw/iosystem/signals?json=1").json()["_embedded"]["_state"]
    listed = sorted((one["name"], one["type"], one["lvalue"]) for one in listed)
    assert listed == [("doGripper", "DO", "1"), ("group", "GO", "7"), ("pressure", "AO", "2.25")]
    for change, words in (
        (lambda: rws.get_digital_io("text"), "the signal 'text' is a text or a group"),
        (lambda: rws.get_digital_io("none"), "there is no signal 'none'"),
        (lambda: rws.set_analog_io("doGripper", 2), "the signal 'doGripper' takes 0 or 1, not 2"),
        (lambda: rws.set_analog_io("group", 0.5), "the signal 'group' takes a whole number, not 0.5"),
        (lambda: rws.set_analog_io("pressure", float("nan")), "'nan' is no number"),
        (lambda: rws.set_speedratio(0), "speed-ratio is above 0 and at most 100, not 0"),
        (lambda: rws.set_controller_state("off"), "no controller state that can be set 'off'"),
    ):
        with pytest.raises(ABBException, match=words):
            change()
    rws.set_speedratio(25)
    assert (client.robot("arm").speed_factor, client.speed_factor, rws.get_speedratio()) == (0.25, 1.0, 25.0)
    load(rws, FOREVER)
    rws.resetpp()
    rws.start()
    until(lambda: float(rws.get_rapid_variable("count")) > 2)
    rws.set_controller_state("motoroff")
    until(stands(rws))
    with pytest.raises(ABBException, match="the motors are off"):
        rws.start()
    rws.set_controller_state("motoron")
    rws.start()
    assert rws.get_execution_state().ctrlexecstate == "running"


def test_a_module_that_does_not_load_is_told_with_its_line_and_changes_nothing(abb: Served) -> None:
    rws = abb.client()
    load(rws, MODULE)
    for text, replace, code, words in (
        (MODULE.replace("count + 1;", "count + ;"), "true", -1073442803, "tried.mod:14:"),
        (MODULE.replace("count := count", "count := cuont"), "true", -1073442803, "tried.mod:14:14: .*mean 'count'"),
        (MODULE.replace("MODULE Cell", "MODULE Other"), "false", -1073442803, "tried.mod:2:"),
        (MODULE, "false", -1073445839, "T_ROB1 has a module 'Cell' already; say replace=true"),
        (MODULE, "perhaps", -1073445879, "no value of replace 'perhaps'"),
        ("", "false", -1073442803, "tried.mod:1:1: MODULE is expected here, not the end of the file"),
        (f"MODULE One ENDMODULE {MODULE}", "false", -1073442803, "tried.mod has 2 modules, and a file has one"),
        ("\x00\xff", "false", -1073442803, "tried.mod:1:1"),
    ):
        with pytest.raises(ABBException, match=words) as caught:
            load(rws, text, replace=replace)
        assert caught.value.code == code
    with pytest.raises(ABBException, match=r"there is no file '\$HOME/none.mod'"):
        rws._do_post("rw/rapid/tasks/T_ROB1?action=loadmod", {"modulepath": "$HOME/none.mod"})
    with pytest.raises(ABBException, match="there is no task 'T_ROB9'; there are: T_ROB1"):
        load(rws, MODULE, task="T_ROB9")
    assert rws.get_rapid_variable("count") == "0"
    rws._do_post("rw/rapid/tasks/T_ROB1?action=unloadmod", {"module": "cell"})
    with pytest.raises(ABBException, match="the modules of T_ROB1 have no procedure main"):
        rws.resetpp()


def test_an_error_of_a_program_is_in_the_log_with_its_line(abb: Served) -> None:
    rws = abb.client()
    run(rws, MODULE.replace("SetDO doDone, 1;", 'ErrWrite \\W, "low", "air" \\RL2:="6 bar"; count := 1 / rounds;'))
    stopped, error, warning, *_ = rws.read_event_log()
    assert (stopped.code, stopped.args) == (10125, ["an error has occurred"])
    assert (error.code, error.msgtype) == (10020, 3) and error.args[0].startswith("tried.mod:13: ERR_DIVZERO")
    assert (warning.code, warning.msgtype, warning.args) == (80002, 2, ["low", "air", "6 bar"])
    with pytest.raises(ABBException, match="the program pointer is nowhere: set it to main") as caught:
        rws.start()
    assert caught.value.code == -1073442783
    rws.resetpp()
    rws.start(cycle="once")
    until(stands(rws))


def test_who_may_come_in(abb: Served) -> None:
    path = "/rw/panel/ctrlstate"
    for auth in (
        None,
        HTTPBasicAuth(USER, PASSWORD),
        HTTPDigestAuth(USER, "wrong"),
        HTTPDigestAuth("nobody", PASSWORD),
    ):
        answer = requests.get(f"{abb.url}{path}", auth=auth)
        assert answer.status_code == 401 and not answer.cookies
        assert answer.headers["www-authenticate"].startswith('Digest realm="validusers@robapi.abb", qop="auth"')
    assert asked(abb, path).status_code == 200
    session = requests.Session()
    session.auth = HTTPDigestAuth(USER, PASSWORD)
    session.get(f"{abb.url}{path}")
    key = str(session.cookies["-http-session-"])
    assert requests.get(f"{abb.url}{path}", cookies={"-http-session-": key}).status_code == 200
    # The number of a session lets nobody in, nor does a signature for another path.
    assert requests.get(f"{abb.url}{path}", cookies={"ABBCX": str(session.cookies["ABBCX"])}).status_code == 401
    signed = session.get(f"{abb.url}{path}").request.headers["Authorization"]
    assert requests.get(f"{abb.url}/rw/panel/opmode", headers={"Authorization": signed}).status_code == 401
    assert requests.get(f"{abb.url}/logout", cookies={"-http-session-": key}).status_code == 204
    assert requests.get(f"{abb.url}{path}", cookies={"-http-session-": key}).status_code == 401


def test_sessions_are_counted(abb: Served) -> None:
    signs = HTTPDigestAuth(USER, PASSWORD)
    for _ in range(MOST_SESSIONS):
        assert requests.get(f"{abb.url}/rw/panel/opmode", auth=signs).status_code == 200
    answer = requests.get(f"{abb.url}/rw/panel/opmode", auth=signs)
    assert answer.status_code == 503 and "keep the cookies, or end one by GET /logout" in answer.text


def test_a_signature_that_is_too_old_is_asked_for_anew(monkeypatch: pytest.MonkeyPatch) -> None:
    digest, other = Digest({USER: PASSWORD}), Digest({USER: PASSWORD})
    signs = HTTPDigestAuth(USER, PASSWORD)
    signs.init_per_thread_state()
    parts = requests.utils.parse_dict_header(digest.challenge().removeprefix("Digest "))
    signs._thread_local.chal = parts
    header = str(signs.build_digest_header("GET", "http://robot/rw/panel?json=1"))
    assert digest.accepts(header, "GET", "/rw/panel?json=1") == "yes"
    assert digest.accepts(header, "POST", "/rw/panel?json=1") == "no"
    assert other.accepts(header, "GET", "/rw/panel?json=1") == "stale"  # its own server has ended
    later = time.time() + 301.0
    monkeypatch.setattr(time, "time", lambda: later)
    assert digest.accepts(header, "GET", "/rw/panel?json=1") == "stale"
    assert digest.challenge(stale=True).endswith("stale=true")
    strange = header.replace('nonce="', 'nonce="\udcff')  # a byte that is no UTF-8, as the server reads it
    for header in (
        *("", "Digest", 'Digest username="a"', "Digest " + "," * 50, 'Digest nonce="', "Digest ä=ö"),
        *("Digest response=,,", strange),
    ):
        assert digest.accepts(header, "GET", "/rw/panel?json=1") == "no"


def test_two_clients(abb: Served) -> None:
    first, second = abb.client(), abb.client()
    load(first, FOREVER)
    second.resetpp()
    first.start()
    for change, words in (
        (second.start, "the program runs already"),
        (second.resetpp, "the program runs: stop it before the pointer is set to main"),
        (lambda: load(second, FOREVER), "the program runs: stop it before a module is loaded"),
    ):
        with pytest.raises(ABBException, match=words) as caught:
            change()
        assert caught.value.code == -1073442809
    seen: list[Any] = []
    watched = first.subscribe([SubscriptionResourceRequest(SUBSCRIBED.PersVar, HIGH, "count")], seen.append)
    second.set_rapid_variable_num("more", 5000)
    until(lambda: seen and float(seen[-1].value) > 5000)
    second.stop()
    until(stands(first))
    first.close()  # its subscription goes on: it is a connection of its own
    watched.close()
    until(lambda: not abb.controller.listeners)
    assert second.get_rapid_variable_num("count") > 5000


def test_messages_between_clients(abb: Served) -> None:
    first, second, seen = abb.client(), abb.client(), []
    assert first.try_create_ipc_queue("mine") and not second.try_create_ipc_queue("mine")
    second.send_ipc_message("mine", "num;5", "theirs", cmd=7, userdef=3)
    (message,) = first.read_ipc_message("mine")
    assert message == ("num;5", "3", "1", "7", "mine") and first.read_ipc_message("mine") == []
    watched = first.subscribe([SubscriptionResourceRequest(SUBSCRIBED.IpcQueue, HIGH, "mine")], seen.append)
    second.send_ipc_message("mine", "string;<a>", "theirs")
    until(lambda: seen)
    watched.close()
    assert seen[0].queue_name == "mine" and seen[0].data == "string;&lt;a&gt;"  # as XML has it; the client leaves it
    with pytest.raises(ABBException, match="there is no queue 'T_ROB1'; there are: mine"):
        second.send_ipc_message("T_ROB1", "num;5", "theirs")


def test_files_stay_below_their_folder(abb: Served, tmp_path: Path) -> None:
    rws = abb.client()
    rws.upload_file("RAMDISK:/logs/day.bin", bytes(range(256)))
    assert rws.read_file("$TEMP/logs/day.bin") == bytes(range(256)) == (tmp_path / "logs" / "day.bin").read_bytes()
    assert rws.list_files("HOME:/logs") == ["day.bin"] and rws.get_ramdisk_path() == "RAMDISK:"
    assert (
        asked(abb, "/fileservice/$HOME", "POST", data={"fs-action": "create", "fs-newname": "new"}).status_code == 204
    )
    assert rws.list_files("$HOME") == ["logs", "new"]
    (tmp_path.parent / "secret").write_text("no")
    for path in ("$HOME/../secret", "$HOME/%2e%2e/secret", "HOME:/logs/../../secret", "a%00b", "c:/$HOME/d:e"):
        answer = requests.Request("GET", "http://x").prepare()
        answer.url = f"{abb.url}/fileservice/{path}"
        with requests.Session() as session:
            session.auth = HTTPDigestAuth(USER, PASSWORD)
            session.get(f"{abb.url}/rw/panel/opmode")
            answer.prepare_cookies(session.cookies)
            status = session.send(answer).status_code
            session.get(f"{abb.url}/logout")
        assert status in (400, 403, 404), path
    rws.delete_file("$HOME/logs")
    assert rws.list_files("$HOME") == ["new"]
    assert asked(abb, "/fileservice/$HOME/", "DELETE").status_code == 404
    assert asked(abb, "/fileservice/$HOME/x", "PUT", data=b"0" * (17 * 1024 * 1024)).status_code == 413


def test_a_body_that_is_too_long_is_refused_before_it_comes(abb: Served) -> None:
    with socket.create_connection(("127.0.0.1", abb.port), timeout=60.0) as connection:
        connection.sendall(b"POST /rw/rapid HTTP/1.1\r\nHost: x\r\nContent-Length: 99999999999\r\n\r\nstate=")
        assert connection.makefile("rb").readline().startswith(b"HTTP/1.1 413 ")


def test_every_resource_that_is_read_tells_the_same_in_xhtml_and_json(abb: Served) -> None:
    rws = abb.client()
    load(rws, MODULE)
    rws.upload_file("$HOME/disk/a", b"")
    rws.try_create_ipc_queue("q")
    names = {"task": "T_ROB1", "module": "Cell", "unit": "ROB_1", "domain": "0", "number": "1", "variable": "HOME"}
    paths = {"/fileservice/{path*}": "$HOME/disk", "/rw/iosystem/signals/{path*}": "doDone"}
    with requests.Session() as session:
        session.auth = HTTPDigestAuth(USER, PASSWORD)
        for one in RESOURCES:
            if one.method == "GET" and one.first is not None:
                template = one.first.template
                path = template.replace("{path*}", paths.get(template, "T_ROB1/Cell/words"))
                path = path.replace("{queue}", "q").replace("${variable}", "$HOME").format(**names)
                query = f"?task=T_ROB1&action={one.first.action}"
                as_json = session.get(f"{abb.url}{path}{query}&json=1")
                as_xhtml = session.get(f"{abb.url}{path}{query}")
                assert (as_json.status_code, as_xhtml.status_code) == (200, 200), path
                told = as_json.json()["_embedded"]["_state"]
                items = ElementTree.fromstring(as_xhtml.content).findall(".//{http://www.w3.org/1999/xhtml}li")
                assert [one["_type"] for one in told] == [item.get("class") for item in items], path
                for one_told, item in zip(told, items, strict=True):
                    spans = {span.get("class"): span.text or "" for span in item if span.tag.endswith("span")}
                    values = {name: value for name, value in one_told.items() if isinstance(value, str)}
                    assert {**spans, "_type": item.get("class"), "_title": item.get("title")} == values, path


def test_what_is_asked_wrongly_is_told(abb: Served) -> None:
    for method, path, status, words in (
        ("GET", "/rw/nothing", 404, "there is no resource '/rw/nothing'"),
        ("DELETE", "/rw/rapid/tasks", 405, "/rw/rapid/tasks takes GET, not DELETE"),
        (
            "POST",
            "/rw/rapid/execution?action=dance",
            400,
            "takes the actions start, stop, resetpp, setcycle, not dance",
        ),
        ("POST", "/rw/rapid/execution?action=setcycle", 400, "'cycle' is missing"),
        (
            "POST",
            "/rw/rapid/execution?action=setcycle&cycle=two",
            404,
            "there is no cycle 'two'; there are: once, forever",
        ),
        ("GET", "/rw/rapid/modules", 400, "'task' is missing"),
        ("GET", "/rw/rapid/symbol/data/RAPID/T_ROB1", 404, "a datum is TASK/NAME or TASK/MODULE/NAME, not 'T_ROB1'"),
        ("POST", "/subscription", 400, "'resources' names 1 to 1000 identifiers, each with its URI"),
        ("POST", "/rw/rapid/symbols?action=search-symbols", 200, "RAPID/T_ROB1/user/tool0"),
        ("DELETE", "/subscription/5", 404, "there is no subscription 5"),
        ("PUT", "/subscription/x", 404, "there is no subscription 'x'"),
    ):
        answer = asked(abb, path, method)
        assert answer.status_code == status and words in answer.text.replace("&#x27;", "'"), (path, answer.text)
    for action, form, words in (
        ("start", {"execmode": "stepin"}, "there is no execution mode 'stepin'; there are: continue"),
        ("stop", {"stopmode": "cycle"}, "there is no stop mode 'cycle'; there are: stop, qstop"),
    ):
        answer = asked(abb, f"/rw/rapid/execution?action={action}", "POST", data=form)
        assert answer.status_code == 404 and words in answer.text, answer.text
    for form, words in (
        ({"resources": "1", "1": "/rw/dance"}, "'/rw/dance' can't be subscribed to; there are: /rw/rapid/execution"),
        (
            {"resources": "1", "1": "/rw/panel/opmode", "1-p": "9"},
            "the priority 1-p is 0 (low), 1 (medium), 2 (high), not",
        ),
        ({"resources": "1", "1": "/rw/iosystem/signals/none;state"}, "there is no signal 'none'"),
        ({"resources": ["1", "2"], "1": "/rw/panel/opmode", "2": "/rw/dipc/none"}, "there is no queue 'none'"),
        (b"\xff=\xff", "this is no form in UTF-8"),
        ({f"a{number}": "1" for number in range(3001)}, "of at most 3000 fields"),
    ):
        answer = asked(abb, "/subscription", "POST", data=form)
        assert answer.status_code in (400, 404) and words in answer.text, answer.text
    assert not abb.controller.listeners


def test_malformed_requests_break_nothing(abb: Served, rng: np.random.Generator) -> None:
    rws = abb.client()
    rws.get_execution_state()
    key = rws._session.cookies["-http-session-"]
    body = b"cycle=once&resources=1&1=/rw/panel/opmode;x&lvalue=1&value=[1,2]&modulepath=$HOME/a&dipc-data=x"
    forms = [(one.method, one.first) for one in RESOURCES if one.first is not None and one.first.action != "start"]
    calls = [(method, f"{form.template}?action={form.action}") for method, form in forms]
    calls += [("POST", "/subscription"), ("GET", "/poll/1"), ("DELETE", "/subscription/1"), ("HEAD", "/rw/system")]
    names = {"task": "T_ROB1", "path*": "x", "module": "Cell", "unit": "ROB_1", "domain": "0", "number": "1"}
    names |= {"queue": "q", "variable": "HOME"}
    served_ones = 0
    for _ in range(2000):
        method, path = calls[rng.integers(len(calls))]
        lines = [f"{method} {path.format_map(names)} HTTP/1.1", "Host: x", f"Cookie: -http-session-={key}"]
        lines += [f"Content-Length: {len(body)}", "Connection: close", *["Upgrade: websocket"] * int(rng.integers(2))]
        data = bytearray("\r\n".join(lines).encode() + b"\r\n\r\n" + body)
        for _ in range(rng.integers(0, 6)):
            place = int(rng.integers(len(data)))
            data[place : place + int(rng.integers(0, 3))] = rng.bytes(int(rng.integers(0, 4)))
        answer = abb.raw(bytes(data))
        served_ones += answer.startswith(b"HTTP/1.1 2")
        assert not answer.startswith(b"HTTP/1.1 5"), (bytes(data), answer)
    assert served_ones > 0 and rws.get_execution_state().ctrlexecstate == "stopped"


def test_ten_thousand_malformed_requests_take_no_memory(abb: Served, rng: np.random.Generator) -> None:
    """They come in as whole requests that are none of a controller's; a client that was there before is served."""
    rws, statuses, grown = abb.client(), set(), []
    rws.get_execution_state()
    cookie = f"-http-session-={rws._session.cookies['-http-session-']}"
    forms = [(one.method, one.first) for one in RESOURCES if one.first is not None and one.first.action != "start"]

    async def sent(event: dict[str, Any]) -> None:
        statuses.add(event.get("status", 200))

    async def flood(count: int) -> None:
        for _ in range(count):
            method, form = forms[rng.integers(len(forms))]
            path, query, body = (
                bytearray(one)
                for one in (
                    form.template.encode(),
                    b"action=" + form.action.encode(),
                    b"lvalue=1&value=[1,2]&dipc-data=x&1=/rw/panel/opmode",
                )
            )
            for data in (path, query, body):
                for _ in range(rng.integers(0, 3)):
                    place = int(rng.integers(1, len(data) + 1))
                    data[place : place + int(rng.integers(0, 3))] = rng.bytes(int(rng.integers(0, 4)))
            headers = [(b"cookie", bytes(rng.choice([cookie.encode(), rng.bytes(20)]))), (b"host", b"x")]
            scope = {
                "type": "http",
                "method": method,
                "scheme": "http",
                "path": path.decode(errors="replace"),
                "raw_path": bytes(path),
                "query_string": bytes(query),
                "headers": headers,
            }
            events = iter(
                (
                    {"type": "http.request", "body": bytes(body), "more_body": bool(rng.integers(2))},
                    {"type": str(rng.choice(["http.request", "http.disconnect"])), "body": b""},
                )
            )

            async def received(events: Iterator[dict[str, Any]] = events) -> dict[str, Any]:
                return next(events)

            await abb.application(scope, received, sent)

    tracemalloc.start()
    try:
        for _ in range(10):
            asyncio.run(flood(1000))
            assert rws.get_execution_state().ctrlexecstate == "stopped"
            grown.append(tracemalloc.get_traced_memory()[0])
    finally:
        tracemalloc.stop()
    assert {400, 401, 404} < statuses and max(statuses) < 500
    assert grown[9] - grown[4] < 200_000


def test_two_robots_have_a_task_each(client: virtualrobot.Client, tmp_path: Path) -> None:
    client.clock.speed_factor = 5.0
    client.load_robot("model://irb120", name="left", pose=virtualrobot.pose(0.0, 1.0, 0.0))
    client.load_robot("model://irb120", name="right", pose=virtualrobot.pose(0.0, -1.0, 0.0))
    with served(client, ["left", "right"], tmp_path) as abb:
        rws = abb.client()
        turn = FOREVER.replace(
            "WaitTime 0.01;", "MoveAbsJ [[{},0,0,0,30,0],[9E9,9E9,9E9,9E9,9E9,9E9]],vmax,fine,tool0;"
        )
        load(rws, turn.format(20))
        load(rws, turn.format(-20).replace("MODULE Cell", "MODULE Other"), task="T_ROB2")
        rws.resetpp()
        rws.start(cycle="once", tasks=["T_ROB1", "T_ROB2"])
        until(stands(rws))
        for number, angle in ((1, 20.0), (2, -20.0)):
            np.testing.assert_allclose(rws.get_jointtarget(f"ROB_{number}").robax[0], angle, atol=1e-6)
        assert rws.get_rapid_variable("count") == "2" == rws.get_rapid_variable("count", "T_ROB2")  # one for both
        rws.start(cycle="once", tasks=["T_ROB2"])
        until(stands(rws))
        assert rws.get_rapid_variable("count") == "3" and not rws.get_tasks()["T_ROB1"].active


SYNCHRONIZED = """MODULE Moves{0}
  PERS tasks both{{2}} := [["T_ROB1"], ["T_ROB2"]];
  VAR syncident begin;
  VAR syncident end;
  PROC main()
    MoveAbsJ [[0,0,0,0,30,0],[9E9,9E9,9E9,9E9,9E9,9E9]], vmax, fine, tool0;
    SyncMoveOn begin, both;
    MoveAbsJ [[{1},0,0,0,30,0],[9E9,9E9,9E9,9E9,9E9,9E9]] \\ID:=10, v200, fine, tool0;
    SyncMoveOff end;
  ENDPROC
ENDMODULE
"""


def test_robots_that_move_together_stop_and_go_on_together(client: virtualrobot.Client, tmp_path: Path) -> None:
    client.clock.speed_factor = 2.0
    client.load_robot("model://irb120", name="left", pose=virtualrobot.pose(0.0, 1.0, 0.0))
    client.load_robot("model://irb120", name="right", pose=virtualrobot.pose(0.0, -1.0, 0.0))
    with served(client, ["left", "right"], tmp_path) as abb:
        rws, both = abb.client(), ["T_ROB1", "T_ROB2"]
        load(rws, SYNCHRONIZED.format(1, 90))
        load(rws, SYNCHRONIZED.format(2, -90), task="T_ROB2")
        for give_up in (False, True):
            rws.resetpp()
            rws.start(cycle="once", tasks=both)
            until(lambda: abs(rws.get_jointtarget().robax[0]) < 5.0)
            until(lambda: rws.get_jointtarget().robax[0] > 10.0)
            rws.stop()
            until(stands(rws))
            left, right = (rws.get_jointtarget(f"ROB_{number}").robax for number in (1, 2))
            assert 10.0 < left[0] < 89.0
            np.testing.assert_allclose(left[0], -right[0], atol=1e-6)  # the same way, turned the other way round
            if give_up:
                rws.resetpp()
                assert abb.written == []
            else:
                rws.start(tasks=both)
                until(stands(rws))
                np.testing.assert_allclose(rws.get_jointtarget("ROB_2").robax[0], -90.0, atol=1e-6)


def test_the_command_serves_until_its_input_ends(
    kernel: KernelProcess, arm: virtualrobot.Robot, tmp_path: Path
) -> None:
    module = tmp_path / "cell.mod"
    module.write_text(MODULE)
    command = [sys.executable, "-m", "virtualrobot", "emulate", "abb", "arm", "--port", "0", "--until-input-ends"]
    command += ["--module", str(module), "--create-signals", "--address", kernel.address, "--password", "other"]
    with subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True) as process:
        try:
            assert process.stdin is not None and process.stdout is not None
            line = process.stdout.readline()
            assert line.startswith("Robot Web Services at http://127.0.0.1:") and line.endswith("; Ctrl-C ends it\n")
            url = line.split()[4].rstrip(";")
            answer = requests.get(f"{url}/rw/rapid/modules?task=T_ROB1&json=1", auth=HTTPDigestAuth(USER, "other"))
            assert [one["name"] for one in answer.json()["_embedded"]["_state"]] == ["Cell"]
            process.stdin.close()
            assert process.wait(60) == 0
        finally:
            process.kill()


def test_programs_that_compute_let_calls_come_between(kernel: KernelProcess, monkeypatch: pytest.MonkeyPatch) -> None:
    """The command's threads take turns ten times as often as Python's do, as those of the kernel do."""
    turns: list[float] = []
    monkeypatch.setattr(sys, "setswitchinterval", turns.append)
    CliRunner().invoke(emulate, ["abb", "leg", "--port", "0", "--address", kernel.address])
    assert turns == [SWITCH_INTERVAL_SECONDS] and turns[0] < 0.2 * sys.getswitchinterval()


def test_the_command_tells_what_is_wrong(kernel: KernelProcess, arm: virtualrobot.Robot, tmp_path: Path) -> None:
    module = tmp_path / "cell.mod"
    module.write_text(MODULE.replace("ENDPROC", ""))
    for more, words in (
        (["arm", "--module", str(module)], f"{module}:"),
        (["arm", "--module", f"T_ROB2={module}"], "there is no task 'T_ROB2'; there are: T_ROB1"),
        (["arm", "--module", str(tmp_path / "none.mod")], "none.mod can't be read"),
        (["leg"], "leg"),
        ([], "Missing argument 'ROBOT...'"),
    ):
        result = CliRunner().invoke(emulate, ["abb", *more, "--port", "0", "--address", kernel.address])
        assert result.exit_code != 0 and words in (result.output + str(result.exception)), result.output
    assert not [one for one in threading.enumerate() if one.name == "RAPID"]

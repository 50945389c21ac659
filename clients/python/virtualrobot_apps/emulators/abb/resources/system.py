"""The system: log, files, message queues, users."""

from __future__ import annotations

import shutil
from collections import deque
from datetime import UTC, datetime
from pathlib import Path

from virtualrobot_apps.emulators.abb.answers import BYTES, Answer, Item
from virtualrobot_apps.emulators.abb.controller import Queued
from virtualrobot_apps.emulators.abb.disk import DISKS
from virtualrobot_apps.emulators.abb.log import Message
from virtualrobot_apps.emulators.abb.refused import Refused, unknown
from virtualrobot_apps.emulators.abb.table import Call, resource

MOST_QUEUES, MOST_QUEUED = 32, 1000
VERSIONS = {False: ("6", "15", "6.15.0"), True: ("7", "8", "7.8.0")}
"""RobotWare that is told by Robot Web Services 1.0, and by 2.0 (True)."""


@resource("GET", "/rw/system")
def _system(call: Call) -> list[Item]:
    """Name and version: RobotWare 6, by Robot Web Services 2.0 RobotWare 7; virtual."""
    values = {
        **dict(zip(("major", "minor", "rwversion"), VERSIONS[call.second], strict=True)),
        "name": "VirtualRobot",
        "ctrltype": "Virtual Controller",
    }
    return [Item("sys-system", "system", values)]


@resource("GET", "/rw/elog/{domain}")
def _log(call: Call) -> list[Item]:
    """Messages of the log, the newest first; all domains are the common one, 0."""
    return [_message_item(one, "elog-message-li") for one in reversed(call.controller.log.since(0))]


@resource("GET", "/rw/elog/{domain}/{number}")
def _message(call: Call) -> list[Item]:
    """A message of the log by its number."""
    number = call.path["number"]
    found = [one for one in call.controller.log.since(0) if str(one.number) == number]
    if not found:
        raise Refused("UNRESOLVED_URL", f"the log has no message {number}", 404)
    return [_message_item(found[0], "elog-message")]


def _message_item(one: Message, kind: str) -> Item:
    values = {
        "msgtype": one.kind,
        "code": one.code,
        "src-name": "MC0",
        "tstamp": one.time.strftime("%Y-%m-%d T  %H:%M:%S"),
        "title": one.title,
        "desc": "; ".join(one.words),
        "conseqs": "",
        "causes": "",
        "actions": "",
        "argc": len(one.words),
        "argv": list(one.words),
    }
    return Item(kind, f"/rw/elog/0/{one.number}", values, f"0/{one.number}")


# Files.


@resource("GET", "/ctrl/${variable}", only="1.0")
def _variable(call: Call) -> list[Item]:
    """The disk that HOME, TEMP or RAMDISK stands for; all are the same folder."""
    name = call.path["variable"]
    if name.lower() not in DISKS:
        raise unknown("variable", name, tuple(one.upper() for one in DISKS))
    return [Item("ctrl-envvar", name, {"_value": DISKS[name.lower()]})]


@resource("GET", "/fileservice/{path*}")
def _read(call: Call) -> list[Item] | Answer:
    """A file, or what is in a folder."""
    found = call.file(call.path["path"])
    if found.is_dir():
        return [_file_item(one) for one in sorted(found.iterdir())]
    if not found.is_file():
        raise Refused("FILE_NOT_FOUND", f"there is no file {call.path['path']!r}", 404)
    return Answer(200, found.read_bytes(), BYTES)


@resource("PUT", "/fileservice/{path*}")
def _write(call: Call) -> Answer:
    """Writes a file, whose folder is made where it isn't there."""
    file = call.file(call.path["path"])
    if file.is_dir():
        raise Refused("INVALIDARG", f"{call.path['path']!r} is a folder")
    new = not file.exists()
    try:
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_bytes(call.body)
    except OSError as error:
        raise Refused("INVALIDARG", f"{call.path['path']!r} can't be written: {error.strerror}") from None
    return Answer(201 if new else 200)


@resource("DELETE", "/fileservice/{path*}")
def _delete(call: Call) -> None:
    """Deletes a file, or a folder with what is in it."""
    found = call.file(call.path["path"])
    if not found.exists() or found == call.controller.files.resolve():
        raise Refused("FILE_NOT_FOUND", f"there is nothing to delete at {call.path['path']!r}", 404)
    shutil.rmtree(found) if found.is_dir() else found.unlink()


@resource("POST", "/fileservice/{path*}", second="/fileservice/{path*}/create")
def _make(call: Call) -> None:
    """Makes the folder `fs-newname`, in 1.0 by `fs-action=create`."""
    action = "create" if call.second else call.needs("fs-action")
    if action != "create":
        raise unknown("fs-action", action, ("create",))
    folder = call.file(f"{call.path['path']}/{call.needs('fs-newname')}")
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise Refused("INVALIDARG", f"{folder.name!r} can't be made: {error.strerror}") from None


def _file_item(one: Path) -> Item:
    told = one.stat()
    changed = datetime.fromtimestamp(told.st_mtime, UTC).strftime("%Y-%m-%d T  %H:%M:%S")
    values = {"fs-mdate": changed, "fs-readonly": "false"}
    values |= {} if one.is_dir() else {"fs-size": str(told.st_size)}
    return Item("fs-dir" if one.is_dir() else "fs-file", one.name, values, one.name)


# Message queues.


@resource("POST", "/rw/dipc", "dipc-create", second="/rw/dipc")
def _create_queue(call: Call) -> None:
    """Makes the queue `dipc-queue-name`, for messages from other clients; tasks of RAPID have none here."""
    name, queues = call.needs("dipc-queue-name"), call.controller.queues
    if name in queues:
        raise Refused("INVALIDARG", f"there is a queue {name!r} already")
    if len(queues) >= MOST_QUEUES:
        raise Refused("MAX_LIMIT_REACHED", f"there are {MOST_QUEUES} queues already")
    queues[name] = deque()


@resource("POST", "/rw/dipc/{queue}", "dipc-send", second="/rw/dipc/{queue}")
def _send(call: Call) -> None:
    """Adds a message to a queue."""
    queue = _queue(call)
    if len(queue) >= MOST_QUEUED:
        raise Refused("QUEUEFULL", f"{call.path['queue']!r} has {MOST_QUEUED} messages that nobody reads")
    parts = (call.form.get(f"dipc-{name}", "") for name in ("userdef", "msgtype", "cmd"))
    queue.append(Queued(call.needs("dipc-data"), *parts))


@resource("GET", "/rw/dipc/{queue}", "dipc-read", second="/rw/dipc/{queue}")
def _receive(call: Call) -> list[Item]:
    """Takes all messages out of a queue."""
    queue, items = _queue(call), []
    while queue:
        items.append(message_item(call.path["queue"], queue.popleft(), "dipc-read-li"))
    return items


def message_item(queue: str, one: Queued, kind: str, href: str = "") -> Item:
    """Return a message of a queue as an item."""
    values = {"dipc-data": one.data, "dipc-userdef": one.user_defined, "dipc-msgtype": one.kind}
    return Item(kind, queue, values | {"dipc-cmd": one.command, "queue-name": queue}, href)


def _queue(call: Call) -> deque[Queued]:
    name, queues = call.path["queue"], call.controller.queues
    if name not in queues:
        raise unknown("queue", name, list(queues))
    return queues[name]


# Users.


@resource("POST", "/users/rmmp")
def _request(call: Call) -> None:
    """Asks for the right to write in manual mode, which is granted at once."""


@resource("GET", "/users/rmmp/poll")
def _granted(call: Call) -> list[Item]:
    """`status` of that: GRANTED."""
    return [Item("user-rmmp-poll", "rmmp", {"status": "GRANTED"})]


@resource("POST", "/rw/mastership/request", only="2.0")
@resource("POST", "/rw/mastership/release", only="2.0")
@resource("POST", "/rw/mastership/{domain}/request", only="2.0")
@resource("POST", "/rw/mastership/{domain}/release", only="2.0")
def _mastership(call: Call) -> None:
    """Asks for the right to write, or gives it back: it is granted at once, to everybody."""

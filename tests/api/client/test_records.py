"""Records and tasks from the client library, from tasks of asyncio, and from the command line."""

from __future__ import annotations

import asyncio
import math
import threading
from typing import Any

import pytest
import virtualrobot
import virtualrobot.aio
from virtualrobot import Client, Record

from tests.api.client.conftest import Run
from tests.kernels import KernelProcess
from tests.waiting import until

CONTENT = {
    **{"language": "RAPID", "robot": "arm", "files": ["sort.mod"], "program_pointer": "sort.mod:7"},
    **{"motion_pointer": "sort.mod:5", "lines": ["hello"], "question": "Go on?", "choices": ["Yes", "No"]},
}


def test_a_record_is_made_changed_watched_and_forgotten(client: Client) -> None:
    records = client.records
    made = records.create("note", {"text": "it sticks", "mass": 1.5, "tags": [None, True]}, title="arm")
    assert made.content == {"text": "it sticks", "mass": 1.5, "tags": [None, True]}
    assert records.get(made.id).title == "arm" and made.id in repr(records)
    with records.watch("note") as watch:
        changes = iter(watch)
        assert made.id in [one.id for one in next(changes).records]
        changed = records.update(made, {"text": "oiled"}, state="done")
        (told,) = next(changes).records
        assert (told.revision, told.content, told.state, told.title) == (2, {"text": "oiled"}, "done", "arm")
        with pytest.raises(virtualrobot.StaleRevisionError, match=f"'{made.id}' has the revision 2, not 1"):
            records.update(made, state="late")
        records.forget(changed)
        assert next(changes).removed == (made.id,)
    with pytest.raises(virtualrobot.UnknownNameError, match="no record named"):
        records.get(made.id)


@pytest.mark.parametrize("content", [math.nan, {"mass": math.inf}, {1, 2}, [object()]])
def test_a_content_that_is_no_json_is_refused(client: Client, content: Any) -> None:  # noqa: ANN401
    with pytest.raises(virtualrobot.InvalidArgumentError, match="content is made of dictionaries, lists"):
        client.records.create("note", content)
    with pytest.raises(virtualrobot.TooLargeError, match="at most 32768 bytes"):
        client.records.create("note", "x" * 40_000)


def job(client: Client) -> Record:
    """Return the record of a task that asks, kept alive by nobody yet."""
    return client.records.create("task", CONTENT, title="T_ROB1", state="asking", wishes=["stop", "answer"], keep=False)


def test_tasks_are_seen_stopped_and_answered(client: Client, run: Run) -> None:
    with client.records.hold(job(client)) as hold:
        one = client.tasks.get("T_ROB1")
        assert (one.state, one.language, one.robot, one.program_pointer) == ("asking", "RAPID", "arm", "sort.mod:7")
        assert one.is_held and one.choices == ("Yes", "No") and "T_ROB1 asking" in repr(client.tasks)
        with pytest.raises(virtualrobot.WrongStateError, match="another call holds"):
            client.records.hold(one.id)
        client.tasks.answer("T_ROB1", "Yes")
        assert "was told to stop" in run("tasks", "stop", one.id)
        assert "was answered 'No'" in run("tasks", "answer", "T_ROB1", "No")
        heard = [wish for _, wish in zip(range(3), hold, strict=False)]
        assert [(one.word, one.text) for one in heard] == [("answer", "Yes"), ("stop", ""), ("answer", "No")]
        table = run("tasks")
        assert "T_ROB1" in table and "sort.mod:7" in table and "RAPID" in table
        told = run("tasks", "show", "T_ROB1")
        for words in ("program pointer: sort.mod:7; motion pointer: sort.mod:5", "| hello", "asks: Go on? [Yes, No]"):
            assert words in told
        twin = job(client)
        assert "2 tasks are called 'T_ROB1'; name one by its record" in run("tasks", "stop", "T_ROB1", code=1)
        client.records.forget(twin)
        client.records.update(one.id, state="ended", is_over=True)
        assert f"no task T_ROB1 runs: {one.id} is over (ended)" in run("tasks", "stop", "T_ROB1", code=1)
        assert "there is no task named 'T_ROB2'; there are: T_ROB1 (" in run("tasks", "stop", "T_ROB2", code=1)
    until(lambda: not client.tasks.list())
    assert run("tasks") == "no program is at work\n"


def test_a_content_of_another_schema_is_a_task_that_tells_nothing(client: Client) -> None:
    for content in ("words", {"files": 7, "lines": {"a": 1}}, [1, 2], None):
        record = client.records.create("task", content, title="odd")
        one = client.tasks.get(record.id)
        assert (one.files, one.lines, one.program_pointer) == ((), (), "")
        client.records.forget(record)


def test_tasks_of_asyncio_hold_records(kernel: KernelProcess, client: Client) -> None:
    async def day() -> list[tuple[str, str]]:
        async with virtualrobot.aio.connect(kernel.address) as other:
            made = await other.records.create("job", wishes=["stop"])
            async with other.records.hold(made) as wishes:
                threading.Timer(0.0, client.records.wish, (made.id, "stop", "please")).start()
                async for wish in wishes:
                    await other.records.update(made.id, is_over=True)
                    await other.records.forget(made.id)
                    return [(wish.word, wish.text)]
        return []

    assert asyncio.run(day()) == [("stop", "please")]

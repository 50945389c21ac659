"""Programs of robots' languages at work, whoever runs them, are seen at the page, answered and stopped there."""

from __future__ import annotations

import pytest
import virtualrobot
from playwright.sync_api import expect

from tests.apps.console.browsing import PLAIN, browsers, needs_page, opened
from tests.apps.console.consoles import consoles
from tests.kernels import StartKernel

pytestmark = [*needs_page, pytest.mark.long]

CONTENT = {"language": "RAPID", "robot": "arm", "program_pointer": "/programs/sort.mod:7", "lines": ["part 1"]}


def test_a_program_at_work_is_seen_answered_and_stopped(start_kernel: StartKernel) -> None:
    kernel = start_kernel("--stepped")
    with (
        virtualrobot.connect(kernel.address) as client,
        consoles(kernel.address) as console,
        browsers() as browser,
        opened(browser, console.url + PLAIN) as page,
    ):
        page.get_by_role("tab", name="Program").click()
        task = page.get_by_role("listitem", name="Program T_ROB1")
        made = client.records.create("task", CONTENT, title="T_ROB1", state="running", wishes=["stop"], keep=False)
        with client.records.hold(made) as wishes:
            heard = iter(wishes)
            for words in ("T_ROB1", "arm", "sort.mod:7", "part 1"):
                expect(task).to_contain_text(words)
            asking = {**CONTENT, "question": "Go on?", "choices": ["Yes", "No"]}
            client.records.update(made.id, asking, state="asking", wishes=["stop", "answer"])
            task.get_by_role("button", name="No", exact=True).click()
            answer = next(heard)
            assert (answer.word, answer.text) == ("answer", "No")
            client.records.update(made.id, {**asking, "choices": []})
            field = task.get_by_label("Answer T_ROB1")
            field.fill("7.5")
            field.press("Enter")
            assert next(heard).text == "7.5"
            task.get_by_role("button", name="Stop T_ROB1").click()
            assert next(heard).word == "stop"
            client.records.update(made.id, state="stopped", is_over=True)
            expect(task).to_have_count(0)
            odd = client.records.create("task", "no content of a task", title="odd")
            expect(page.get_by_role("listitem", name="Program odd")).to_contain_text("odd")
            client.records.forget(odd)

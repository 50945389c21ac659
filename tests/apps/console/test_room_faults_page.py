"""Faults in a room: a robot that somebody has leased, two hands at one goal, a controller that is not seen."""

from __future__ import annotations

import re
from collections.abc import Iterator
from contextlib import ExitStack

import numpy as np
import pytest
import virtualrobot
from playwright.sync_api import Browser, expect
from virtualrobot import Client

from tests.api.asking import IIWA
from tests.api.reading import state, step
from tests.apps.console.browsing import browsers, needs_page, row
from tests.apps.console.consoles import Console, consoles
from tests.apps.console.headsets import UNDRAWN, Person
from tests.apps.console.test_xr_page import (
    FLOAT32,
    PAUSED,
    SUCCEEDED,
    WAY,
    in_room,
    is_in,
    motions,
    needs_iwer,
    propose,
    runs,
)
from tests.apps.console.test_xr_page import client as client
from tests.kernels import KernelProcess, StartKernel, Stubs
from tests.waiting import until

pytestmark = [*needs_page, needs_iwer, pytest.mark.long]

LEFT = "([x, y, z]) => headset.controllers.left.position.set(x, y, z)"
CLOSE = "(value) => headset.controllers.left.updateButtonValue('squeeze', value)"
SEEN = "(seen) => { headset.controllers.right.connected = seen; }"
"""Has the right controller seen, or not."""


@pytest.fixture(scope="module")
def browser() -> Iterator[Browser]:
    with browsers() as one:
        yield one


@pytest.fixture
def person(browser: Browser, console: Console, client: Client) -> Iterator[Person]:
    with in_room(browser, console, "arm") as one:
        yield one


def test_a_robot_that_somebody_has_leased_does_not_run(
    person: Person, stepped: Stubs, stepped_kernel: KernelProcess, client: Client
) -> None:
    with virtualrobot.connect(stepped_kernel.address) as other, other.robot("arm").lease():
        goal = propose(person, client)
        person.point("hold")
        before = len(motions(stepped))
        person.pull()
        expect(person.told).to_contain_text(re.compile("Not so.*is leased by"))
        person.pull(0)
        step(stepped, 20)
        assert len(motions(stepped)) == before and not any(state(stepped, "arm").velocities)
    person.pull()
    expect(person.told).to_contain_text("Hold to run")  # looked at anew
    person.pull(0)
    person.pull()
    until(lambda: is_in(stepped, SUCCEEDED, person))
    np.testing.assert_allclose(client.robot("arm").tcp[:3, 3], goal, atol=FLOAT32)


def test_a_goal_is_of_the_hand_that_took_it_first(person: Person, client: Client) -> None:
    """The other one, which closes at the ball and goes elsewhere, changes neither goal nor size."""
    tool = client.robot("arm").tcp[:3, 3]
    person.reach(tool)
    person.squeeze(1)
    person.page.evaluate(LEFT, person.room(tool))
    person.page.evaluate(CLOSE, 1)
    person.frames()
    person.page.evaluate(LEFT, person.room(tool + np.array([0.4, 0.0, 0.1])))
    person.frames()
    person.move(WAY)
    person.page.evaluate("still", 120)
    person.squeeze(0)
    expect(person.told).to_contain_text("Hold to run")
    expect(person.told).not_to_contain_text("1:")
    (seen,) = [one for one in client.proposals.list() if one.state == "proposed"]
    assert seen.undo_count == 0
    person.page.evaluate(CLOSE, 0)
    person.frames()
    plan = client.proposals.get(seen.id)
    assert plan.revision == seen.revision
    motion = client.proposals.approve(plan, wait=False)
    client.clock.run(motion)
    np.testing.assert_allclose(client.robot("arm").tcp[:3, 3], tool + WAY, atol=FLOAT32)


def test_a_controller_that_is_not_seen_holds_nothing(person: Person, stepped: Stubs, client: Client) -> None:
    propose(person, client)
    person.point("hold")
    person.pull()
    until(lambda: runs(stepped, person))
    person.page.evaluate(SEEN, False)
    until(lambda: is_in(stepped, PAUSED, person))
    person.page.evaluate(SEEN, True)  # its trigger was pulled all the time
    person.frames(5)
    assert is_in(stepped, PAUSED, person)
    expect(person.told).to_contain_text("Paused")
    person.pull(0)
    person.pull()
    until(lambda: is_in(stepped, SUCCEEDED, person))


def test_a_robot_that_is_gone_is_told(person: Person, client: Client) -> None:
    """Proposals for it go with it; when it is there again it is chosen at the page."""
    propose(person, client)
    client.scene.remove("arm")
    expect(person.told).to_contain_text("No robot is chosen")
    person.press("hold")
    expect(person.told).to_contain_text("No robot is chosen")
    client.history.undo()
    row(person.page, "arm").dispatch_event("click")
    expect(person.told).to_contain_text("Take the ball")


def test_a_console_that_goes_and_begins_anew_is_told_in_the_room(browser: Browser, start_kernel: StartKernel) -> None:
    """The new one knows none of the old one's sessions."""
    kernel = start_kernel(token=True)
    with virtualrobot.connect(kernel.address, kernel.token) as client:
        client.load_robot(IIWA, name="arm")
        with ExitStack() as stack:
            with consoles(kernel.address, token=kernel.token) as console:
                person = stack.enter_context(in_room(browser, console, "arm", script=UNDRAWN, link=console.link))
                port = console.port
            expect(person.told).to_contain_text("No connection")
            expect(person.told).to_contain_text("trying again")
            with consoles(kernel.address, "--port", str(port), token=kernel.token):
                expect(person.told).to_contain_text("This page may not come in")
                expect(person.told).to_contain_text("leave the room, and open a new link or code")

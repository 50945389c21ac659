"""A whole day in a guarded cell, by https and with tokens: an engineer's by controllers, an operator's by hands.

Both wear emulated headsets, and an observer looks on at the page. What has happened is read by a client of its own.
"""

from __future__ import annotations

import re
import ssl
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
import virtualrobot
from playwright.sync_api import Browser, Page, expect
from virtualrobot import Client
from virtualrobot.v1 import motion_pb2

from tests.api.asking import IIWA
from tests.apps.console.browsing import PLAIN, browsers, needs_page, opened
from tests.apps.console.consoles import Console, consoles
from tests.apps.console.headsets import AHEAD, UNDRAWN, in_room
from tests.apps.console.test_xr_page import (
    FLOAT32,
    FREE,
    HANG,
    HERE,
    PAUSED,
    SLOW,
    WAY,
    check_rests,
    hold_to_the_end,
    is_in,
    motions,
    needs_iwer,
    propose,
    runs,
)
from tests.kernels import KernelProcess, StartKernel, Stubs
from tests.waiting import until

pytestmark = [*needs_page, needs_iwer, pytest.mark.long]

TOUCHED = {"touch-1": (0.5, 0.4, 0.2), "touch-2": (0.5, -0.5, 0.0), "touch-3": (-0.4, 0.3, 0.6)}
TURNED = 0.4
"""Angle (rad) by which the real cell is turned from where the page puts it at first."""
BESIDE = np.array([0.3, 0.3, 0.0])
"""Distance (m) of it from there."""
Y_UP = np.array([[1.0, 0.0, 0.0, 0.0], [0.0, 0.0, -1.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 0.0, 1.0]])
DOWN = np.array([0.0, 0.0, -0.35])
"""A way (m) into the table."""
ASIDE = np.array([0.0, 0.3, 0.0])

HOLD = "#hold-proposal"


@pytest.fixture(scope="module")
def browser() -> Iterator[Browser]:
    with browsers() as one:
        yield one


@pytest.fixture
def kernel(start_kernel: StartKernel) -> KernelProcess:
    return start_kernel("--stepped", token=True)


@pytest.fixture
def stubs(kernel: KernelProcess) -> Stubs:
    return kernel.stubs()


@pytest.fixture
def client(kernel: KernelProcess) -> Iterator[Client]:
    """Return the second client, in a cell whose arm is guarded."""
    with virtualrobot.connect(kernel.address, kernel.token) as client:
        arm = client.load_robot(IIWA, name="arm")
        arm.set_positions(HERE)
        arm.speed_factor = SLOW
        below = arm.tcp[:3, 3] + DOWN
        client.scene.add_object("table", virtualrobot.box(0.2, 0.2, 0.1), pose=virtualrobot.pose(*below))
        for name, place in TOUCHED.items():
            client.scene.add_frame(name, pose=virtualrobot.pose(*place))
        client.collisions.set(robots={"arm": "guard"})
        yield client


@pytest.fixture
def console(
    kernel: KernelProcess, client: Client, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> Iterator[Console]:
    """Return a console by https, whose authority is new."""
    monkeypatch.setenv("XDG_STATE_HOME", str(tmp_path))
    with consoles(kernel.address, "--own-certificate", token=kernel.token) as console:
        trusted = re.search(r"trusts (\S+) once", console.line())
        assert trusted and console.link.startswith("https://")
        console.tls = ssl.create_default_context(cafile=trusted[1])
        yield console


def link_of(console: Console, client: Client, role: str) -> str:
    token = client.tokens.create(role, role).secret
    return console.ask("/link", authorization=f"Bearer {token}").json["url"]


def lease(page: Page) -> None:
    page.get_by_role("button", name="Lease", exact=True).click()
    expect(page.get_by_role("button", name="Give back")).to_be_visible()


def check_looks_on(page: Page, words: str) -> None:
    """Fail unless an observer sees what is proposed, and may do nothing about it."""
    expect(page.get_by_role("listitem", name=re.compile("^Proposal")).first).to_contain_text(re.compile(words))
    for name in ("Change", "Plan anew", "Reject"):
        expect(page.get_by_role("button", name=name, exact=True)).to_be_disabled()
    expect(page.locator(HOLD)).to_have_attribute("aria-disabled", "true")


def test_a_whole_day(browser: Browser, console: Console, stubs: Stubs, client: Client) -> None:
    with opened(browser, console.url + PLAIN, link=link_of(console, client, "observer")) as page:
        page.get_by_role("tab", name="Proposals").click()
        engineers_day(browser, console, stubs, client, page)
        operators_day(browser, console, stubs, client, page)


def engineers_day(browser: Browser, console: Console, stubs: Stubs, client: Client, watched: Page) -> None:
    arm = client.robot("arm")
    with in_room(browser, console, "arm", script=UNDRAWN, link=link_of(console, client, "engineer")) as person:
        # The cell stands where the real one is, and the world keeps that.
        world_t_room = virtualrobot.pose(*(BESIDE - [0.0, AHEAD, 0.0]), yaw=TURNED) @ Y_UP
        person.register(TOUCHED, world_t_room)
        until(lambda: "headset" in client.scene)
        np.testing.assert_allclose(client.scene.pose("headset"), world_t_room, atol=FLOAT32)
        person.base, person.heading = BESIDE, TURNED

        # A goal is dragged, and another one, which the table is in the way of.
        begin = arm.tcp[:3, 3]
        goal = propose(person, client)
        (seen,) = client.proposals.list()
        assert (seen.state, seen.robots, seen.check.ok) == ("proposed", ("arm",), True)
        assert seen.changed_by.startswith("engineer with ")
        check_looks_on(watched, "free.*engineer")
        person.take(goal, DOWN - WAY)
        expect(person.told).to_contain_text(re.compile("Not so.*table"))
        until(lambda: client.proposals.get(seen.id).undo_count == 1)
        assert not client.proposals.get(seen.id).check.ok
        person.press("undo")
        expect(person.told).to_contain_text(FREE)
        until(lambda: client.proposals.get(seen.id).check.ok)
        person.back()
        until(lambda: client.proposals.get(seen.id).state == "rejected")
        check_rests(stubs)
        assert motions(stubs) == [] and client.proposals.get(seen.id).reason == "rejected in the room"

        # What is approved runs while it is held: let go, it stands, and goes on when it is held again.
        goal = propose(person, client)
        person.point("hold")
        person.pull()
        until(lambda: runs(stubs, person))
        person.pull(0)
        until(lambda: is_in(stubs, PAUSED, person))
        check_rests(stubs)
        assert 0.0 < motions(stubs)[-1].progress < 1.0
        hold_to_the_end(person, stubs)
        np.testing.assert_allclose(arm.tcp[:3, 3], goal, atol=FLOAT32)
        assert np.linalg.norm(goal - begin) > 0.1
        until(lambda: client.proposals.list()[-1].state == "executed")
        check_looks_on(watched, "done")

        # Where it stands is taught, taken back, and taught for good.
        person.press("teach")
        until(lambda: "P1" in client.scene)
        np.testing.assert_allclose(client.scene.pose("P1"), arm.tcp, atol=FLOAT32)
        assert client.history.list()[0].author.startswith("engineer with ")
        person.press("undo")
        until(lambda: "P1" not in client.scene)
        person.press("teach")
        until(lambda: "P1" in client.scene)
        person.leave()


def operators_day(browser: Browser, console: Console, stubs: Stubs, client: Client, watched: Page) -> None:
    arm = client.robot("arm")
    arm.set_positions(HERE)
    before = len(motions(stubs))
    link = link_of(console, client, "operator")
    with in_room(browser, console, "arm", by_hand=True, script=UNDRAWN, link=link, prepare=lease) as person:
        # A page that hangs lets go, however long the fingers stay together.
        tool = arm.tcp[:3, 3]
        person.take(tool, ASIDE)
        expect(person.told).to_contain_text(FREE)
        made = client.proposals.list()[-1]
        check_looks_on(watched, "free.*operator")
        person.point("hold")
        person.pull()
        until(lambda: runs(stubs, person))
        person.page.evaluate(HANG, 1400)
        until(lambda: is_in(stubs, PAUSED, person))
        person.frames(10)
        check_rests(stubs)
        assert motions(stubs)[-1].phase == PAUSED
        person.pull(0)

        # Something is put in its way while it runs: it stands before that.
        person.pull()
        until(lambda: runs(stubs, person))
        client.scene.add_object(
            "crate", virtualrobot.box(0.3, 0.01, 0.3), pose=virtualrobot.pose(*(tool + 0.7 * ASIDE))
        )
        until(lambda: is_in(stubs, motion_pb2.MOTION_PHASE_ABORTED, person))
        assert motions(stubs)[-1].end_cause == motion_pb2.END_CAUSE_COLLISION
        assert not client.collisions.check() and len(motions(stubs)) == before + 1
        expect(person.told).to_contain_text(re.compile("Not so.*crate"))
        person.pull(0)
        assert client.proposals.get(made.id).state == "stopped"

        # The cell is not an operator's to change.
        person.press("teach")
        expect(person.told).to_contain_text("engineer")
        assert "P2" not in client.scene
        person.leave()
        check_rests(stubs)
    until(lambda: not client.leases())

"""A page by plain http from another address: browsers keep things from it, which it says; all else works."""

from __future__ import annotations

import asyncio
import ipaddress
import re
from collections.abc import Iterator
from contextlib import contextmanager
from threading import Thread

import pytest
import virtualrobot
from playwright.sync_api import expect
from virtualrobot import Phase
from virtualrobot_apps.console.authority import local_addresses

from tests.api.asking import IIWA
from tests.apps.console.browsing import PLAIN, browsers, needs_page, opened, row
from tests.apps.console.consoles import Console
from tests.apps.console.test_loader_page import give, refused
from tests.apps.console.test_proposals_page import HOLD, runs
from tests.kernels import KernelProcess, Stubs
from tests.waiting import until

ADDRESSES = [one for one in local_addresses() if not ipaddress.ip_address(one).is_loopback]
"""Addresses by which other machines reach this one."""

pytestmark = [
    *needs_page,
    pytest.mark.long,
    pytest.mark.skipif(not ADDRESSES, reason="no other address than those of the machine itself"),
]


@contextmanager
def forwarded(host: str, port: int) -> Iterator[int]:
    """Give a port at an address of this machine from which all goes on to a port of the machine alone."""

    async def pump(source: asyncio.StreamReader, sink: asyncio.StreamWriter) -> None:
        try:
            while said := await source.read(65536):
                sink.write(said)
                await sink.drain()
        except ConnectionError:
            pass
        finally:
            sink.close()

    async def serve(source: asyncio.StreamReader, sink: asyncio.StreamWriter) -> None:
        further = await asyncio.open_connection("127.0.0.1", port)
        await asyncio.gather(pump(source, further[1]), pump(further[0], sink))

    loop = asyncio.new_event_loop()
    server = loop.run_until_complete(asyncio.start_server(serve, host, 0))
    thread = Thread(target=loop.run_forever, daemon=True)
    thread.start()
    try:
        yield server.sockets[0].getsockname()[1]
    finally:
        loop.call_soon_threadsafe(loop.stop)
        thread.join()
        server.close()
        for task in asyncio.all_tasks(loop):
            task.cancel()
        loop.run_until_complete(asyncio.sleep(0))
        loop.close()


def test_it_says_what_browsers_keep_from_it_and_works(
    console: Console, stepped: Stubs, stepped_kernel: KernelProcess
) -> None:
    address = ADDRESSES[0]
    host = f"[{address}]" if ":" in address else address
    with (
        virtualrobot.connect(stepped_kernel.address) as client,
        forwarded(address, console.port) as port,
        browsers() as browser,
        opened(browser, f"http://{host}:{port}{PLAIN}") as page,
    ):
        arm = client.load_robot(IIWA, name="arm")
        arm.speed_factor = 0.2
        row(page, "arm").click()
        assert not page.evaluate("isSecureContext")
        page.get_by_role("tab", name="Views").click()
        section = page.get_by_role("region", name="In the room")
        expect(section).to_contain_text("by http from another machine")
        expect(section).to_contain_text("virtualrobot console --listen 0.0.0.0 --own-certificate")
        expect(section).to_contain_text("all else works here")
        section.get_by_role("button", name="Over the camera").click()
        expect(section).to_contain_text("show a camera only by https")
        expect(page.get_by_title(re.compile("^(Augmented|Virtual) reality"))).to_have_count(0)

        # Files are known by their digests, which browsers take by https alone.
        page.get_by_role("tab", name="Library").click()
        give(page, ("part.obj", b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n"))
        assert "part.obj is not sent: browsers let pages send files" in refused(page)

        # What is proposed runs while it is held there, too.
        made = client.proposals.create([arm.ptp({"lbr_iiwa_joint_1": 0.6})], title="to the press")
        page.get_by_role("tab", name="Proposals").click()
        page.get_by_label("Look at to the press").click()
        expect(page.locator(HOLD)).to_have_attribute("aria-disabled", "false")
        page.locator(HOLD).hover()
        page.mouse.down()
        until(lambda: runs(client))
        page.mouse.up()
        (motion,) = client.motions()

        def stands() -> bool:
            client.clock.step(20)
            return motion.phase is Phase.PAUSED

        until(stands)
        assert client.proposals.get(made.id).state == "approved"

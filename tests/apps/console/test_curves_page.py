"""A person draws numbers of streams over time at the console's page, and asks for them by HTTP."""

from __future__ import annotations

import numpy as np
import pytest
import virtualrobot
from playwright.sync_api import expect

from tests.api.asking import IIWA
from tests.api.reading import step
from tests.apps.console.browsing import PLAIN, browsers, needs_page, opened
from tests.apps.console.consoles import Console
from tests.apps.console.test_tools import ask
from tests.kernels import KernelProcess, Stubs
from tests.waiting import until

pytestmark = [*needs_page, pytest.mark.long]


def test_curves_are_those_of_the_streams(console: Console, stepped: Stubs, stepped_kernel: KernelProcess) -> None:
    """A motion's joint goes as the motion has it; what is told seldom is held, and null before it was told first."""

    def read(*curves: str) -> dict:
        answer = ask(console, "/curves", {"page": "a", "curves": list(curves)})
        assert answer.status == 200, answer.body
        return answer.json

    with virtualrobot.connect(stepped_kernel.address) as client:
        arm = client.load_robot(IIWA, name="arm")
        joint = arm.joint_names[0]
        client.signals.create("load", 1.5)
        first, difference = f"/robots/arm/joint_states:{joint}/position", "/clock:time - /clock:time"
        names = {one["name"] for one in ask(console, "/streams").json}
        assert {"/robots/arm/tcp", "/signals/load", "/clock"} <= names
        assert "/robots/arm/command/position" not in names
        wanted = (first, difference, "/signals/load")
        read(*wanted)
        arm.start(arm.ptp({joint: 0.5}), wait=False)

        def gone() -> bool:
            step(stepped, 25)
            said = read(*wanted)
            values = {one["name"]: one["values"] for one in said["curves"]}
            return first in values and values[first][-1] == pytest.approx(0.5, abs=1e-6)

        until(gone)
        client.signals["load"] = 2.5

        def told() -> bool:
            step(stepped, 1)
            return read(*wanted)["curves"][-1]["values"][-1] == 2.5

        until(told)
        said = read(*wanted)
        values = {one["name"]: one["values"] for one in said["curves"]}
        times = np.array(said["times"])
        assert (np.diff(times) > 0.0).all() and times[-1] - times[0] <= 61.0
        going = np.array(values[first], float)
        known = np.isfinite(going)
        assert (np.diff(going[known]) >= -1e-9).all(), "a joint that goes to 0.5 rad rises"
        assert {one for one in values[difference] if one is not None} == {0.0}
        assert set(values["/signals/load:value"]) <= {None, 1.5, 2.5}
        assert f"/robots/arm/joint_states:{joint}/velocity" in said["known"]


def test_a_person_draws_curves(console: Console, stepped: Stubs, stepped_kernel: KernelProcess) -> None:
    with virtualrobot.connect(stepped_kernel.address) as client, browsers() as browser:
        client.load_robot(IIWA, name="arm")
        with opened(browser, console.url + PLAIN, 1280, 720) as page:
            page.get_by_role("tab", name="Curves").click()
            field = page.get_by_label("Curve: a stream")
            field.fill("/robots/arm/tcp:z")
            field.press("Enter")
            plot = page.get_by_role("group", name="Curves over time")

            def drawn() -> bool:
                step(stepped, 25)
                return plot.get_by_title("/robots/arm/tcp:z").count() == 1

            until(drawn)
            z = client.robots["arm"].tcp[2, 3]
            expect(plot.get_by_title("/robots/arm/tcp:z")).to_contain_text(f"{z:.5g}".rstrip("0"))

            # What there is not is told in words; without it the rest goes on.
            field.fill("/robots/nobody/tcp")
            field.press("Enter")
            expect(page.get_by_role("region", name="What happens").get_by_role("alert")).to_contain_text("nobody")
            page.get_by_title("Draw /robots/nobody/tcp no more").click()
            expect(page.get_by_role("region", name="What happens").get_by_role("alert")).to_have_count(0)
            page.get_by_title("Draw /robots/arm/tcp:z no more").click()
            expect(plot.get_by_title("/robots/arm/tcp:z")).to_have_count(0)


def test_joints_are_drawn_over_the_last_minute(console: Console, stepped: Stubs, stepped_kernel: KernelProcess) -> None:
    """A robot that has stood for long and moves again is not a spike at the plot's edge."""
    with virtualrobot.connect(stepped_kernel.address) as client:
        arm = client.load_robot(IIWA, name="arm")
        with browsers() as browser, opened(browser, console.url + PLAIN) as page:
            drawn, begin = page.locator("[data-from]"), client.clock.simulation_time
            drawn.wait_for()

            def is_drawn_from(seconds: float) -> bool:
                return float(drawn.get_attribute("data-from") or "nan") == pytest.approx(begin + seconds, abs=0.06)

            until(lambda: is_drawn_from(-1.0))
            for _ in range(5):
                step(stepped, 5_000)  # 20 s
            until(lambda: is_drawn_from(40.0))
            arm.start(arm.ptp([0.1] * 7), wait=False)
            step(stepped, 250)
            until(lambda: is_drawn_from(41.0))

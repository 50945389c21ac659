"""External axes of programs in RAPID: an IRB 120 on a rail, and a positioner under its tool, in a real kernel."""

from __future__ import annotations

import numpy as np
import pytest
import virtualrobot
from virtualrobot.errors import WrongStateError
from virtualrobot_apps.languages.rapid.faults import RapidStopped
from virtualrobot_apps.languages.rapid.task import RapidTask
from virtualrobot_apps.languages.rapid.world import World

from tests.apps.languages.rapid import loaded, numbers
from tests.apps.languages.tracing import traced

pytestmark = pytest.mark.long

DATA = r"""
PERS wobjdata plate := [FALSE, FALSE, "STN1", [[0, 0, 0], [1, 0, 0, 0]], [[0, 0, 100], [1, 0, 0, 0]]];
CONST jointtarget ready := [[0, 0, 0, 0, 60, 0], [300, 0, 0, 9E9, 9E9, 9E9]];
VAR robtarget p;
"""


def run_on(client: virtualrobot.Client, statements: str, external: dict[str, str] | None) -> list[str]:
    """Run statements on the arm, and return its pendant."""
    program = loaded(f"MODULE Tried\n{DATA.strip()}\nPROC main()\n{statements}\nENDPROC\nENDMODULE")
    printed: list[str] = []
    RapidTask(program, World(client, "arm", external=external), printed.append).run()
    return printed


def test_a_rail_and_a_positioner_are_driven_by_external_axes(client: virtualrobot.Client) -> None:
    """Places are in RAPID's world frame, that of the base where the rail is at 0; on the positioner in its plate's.

    That an axis which is there needs a value is assumed, as the page says: no manual was at hand.
    """
    client.clock.speed_factor = 5.0
    rail = client.load_robot("model://rail", name="rail")
    table = client.load_robot("model://positioner", name="table", pose=virtualrobot.pose(0.4, 0.3, -0.2))
    arm = client.load_robot("model://irb120", name="arm", parent="rail.carriage")
    world_t_rapid = client.scene.pose("arm")  # the rail is at 0
    axes = {"track": "rail", "STN1": "table"}
    way = r"""
        MoveAbsJ ready, v1000, fine, tool0;
        p := CRobT(\Tool:=tool0);
        TPWrite ValToStr(p.trans);
        p.trans.y := p.trans.y + 500;
        p.extax.eax_a := 800;
        MoveL p, v500, z10, tool0;
        p.extax.eax_a := 700;
        MoveJ p, v500, fine, tool0;
        TPWrite ValToStr(CPos(\Tool:=tool0));
        TPWrite ValToStr(CJointT());
        p := CalcRobT(CJointT(), tool0);
        TPWrite ValToStr(p.trans);
        TPWrite "" \Num:=p.extax.eax_a;
        TPWrite ValToStr(CalcJointT(p, tool0));
    """
    printed: list[str] = []
    places = traced(client, lambda: printed.extend(run_on(client, way, axes)))[:, 1:]
    first, last = numbers(printed[0]), numbers(printed[1])
    assert last == pytest.approx([first[0], first[1] + 500.0, first[2]], abs=1e-2)
    assert numbers(printed[2])[6:9] == pytest.approx([700.0, 0.0, 0.0], abs=1e-6)
    assert rail.positions == pytest.approx([0.7])
    assert numbers(printed[3]) == pytest.approx(last, abs=1e-2)
    assert numbers(printed[4]) == pytest.approx([700.0], abs=1e-6)
    assert numbers(printed[5])[:9] == pytest.approx(numbers(printed[2])[:9], abs=1e-2)
    end = world_t_rapid @ np.array([last[0] / 1000.0, last[1] / 1000.0, last[2] / 1000.0, 1.0])
    np.testing.assert_allclose(arm.tcp[:, 3], end, atol=1e-6)
    begin = (world_t_rapid @ np.array([0.0, first[1] / 1000.0, 0.0, 1.0]))[1]
    line = places[: np.argmax(places[:, 1] > end[1] - 1e-5)]
    line = line[line[:, 1] > begin + 1e-3]
    assert len(line) > 20
    assert np.abs(line[:, [0, 2]] - arm.tcp[[0, 2], 3]).max() < 2e-5  # straight in the world while the rail goes

    printed = run_on(
        client,
        r"""
        MoveAbsJ ready, v1000, fine, tool0;
        p := CRobT(\Tool:=tool0 \WObj:=plate);
        p.trans.x := p.trans.x + 40;
        p.extax.eax_c := 30;
        MoveL p, v200, fine, tool0 \WObj:=plate;
        TPWrite ValToStr(p.trans);
        TPWrite ValToStr(CPos(\Tool:=tool0 \WObj:=plate));
        """,
        axes,
    )
    assert numbers(printed[1]) == pytest.approx(numbers(printed[0]), abs=1e-2)
    assert table.positions == pytest.approx([0.0, np.radians(30.0)])
    place = np.linalg.inv(client.scene.pose("table.plate")) @ arm.tcp
    np.testing.assert_allclose(1000.0 * place[:3, 3] - [0.0, 0.0, 100.0], numbers(printed[0]), atol=1e-2)

    for statement, said in [
        ("300, 0, 9E9", r"the place says nothing \(9E9\) of the external axis c, 'turn' of 'table'"),
        ("1E6, 0, 0", r"ERR_ROBLIMIT: the external axis a can't be at 1e\+06; its limits are"),
    ]:
        with pytest.raises(RapidStopped, match=said):
            run_on(client, f"MoveAbsJ [[0, 0, 0, 0, 60, 0], [{statement}, 9E9, 9E9, 9E9]], v100, fine, tool0;", axes)
    with pytest.raises(WrongStateError, match=r"^test\.mod:2: a work object is on the mechanical unit 'STN1'; say by"):
        run_on(client, r"MoveL p, v200, fine, tool0 \WObj:=plate;", None)
    assert rail.positions == pytest.approx([0.3])

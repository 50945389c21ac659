"""Registrations that pages ask the console for, over HTTP: what is found, what is kept and by whom, what is refused."""

from __future__ import annotations

import base64

import numpy as np
import pytest
import virtualrobot
from virtualrobot_apps.registration.marker_pose import EDGE, bits_of
from virtualrobot_apps.registration.marker_sheet import as_png, sheet

from tests.apps.console.consoles import Console, consoles
from tests.apps.console.test_tools import ask
from tests.kernels import StartKernel

pytestmark = pytest.mark.long

POINTS = np.array([[0.4, 0.3, 0.0], [0.4, -0.5, 0.0], [-0.3, 0.1, 0.25]])
LEVEL = {"model": [0, 0, 0], "touched": [0, 0, 0]}
SHEET = base64.b64encode(as_png(sheet(bits_of(5), EDGE, 5))).decode()


def test_what_is_found_is_kept_by_those_who_may_change_the_cell(start_kernel: StartKernel) -> None:
    kernel = start_kernel(token=True)
    with (
        virtualrobot.connect(kernel.address, kernel.token) as client,
        consoles(kernel.address, token=kernel.token) as console,
    ):
        client.scene.add_frame("plate", pose=virtualrobot.pose(0.5, 0.2, 0.3, yaw=0.7))
        device = virtualrobot.pose(1.5, -0.3, 0.2, yaw=-1.1)
        # WebXR has y up.
        world_t_headset = device @ np.array([[1, 0, 0, 0], [0, 0, -1, 0], [0, 1, 0, 0], [0, 0, 0, 1.0]])
        seen = np.linalg.inv(world_t_headset) @ client.scene.pose("plate")
        points = [{"model": one.tolist(), "touched": (seen @ [*one, 1.0])[:3].tolist()} for one in POINTS]
        said = {"relative_to": "plate", "up": "y", "points": points, "tools": ["plate"], "frame": "headset"}

        observer = client.tokens.create("looks", "observer").secret
        found = ask(console, "/registration/touched", {**said, "frame": ""}, observer)
        assert found.status == 200
        assert np.abs(np.reshape(found.json["world_t_device"], (4, 4)) - world_t_headset).max() < 1e-9
        assert found.json["errors"]["plate"] > 0.002
        assert ask(console, "/registration/touched", said, observer).status == 403
        assert "headset" not in {node.name for node in client.scene.nodes()}
        assert ask(console, "/registration/touched", said).status == 401

        assert ask(console, "/registration/touched", said, kernel.token).status == 200
        with virtualrobot.connect(kernel.address, kernel.token) as other:
            assert np.abs(other.scene.pose("headset") - world_t_headset).max() < 1e-9
            assert other.scene.node("headset").parent == "plate"

        # The sheet as a scanner sees it: straight from before, as far away as its size says.
        asked = {"pictures": [SHEET], "marker": "plate", "field": 1.0, "frame": "phone"}
        picture = ask(console, "/registration/pictures", asked, kernel.token)
        assert picture.status == 200
        assert picture.json["number"] == 5
        focal, edge_pixels = 2480 / (2.0 * np.tan(0.5)), EDGE / 0.0254 * 300
        expected = client.scene.pose("plate") @ virtualrobot.pose(z=focal * EDGE / edge_pixels, roll=np.pi)
        assert np.abs(client.scene.pose("phone") - expected).max() < 0.002


@pytest.mark.parametrize(
    ("path", "said", "words"),
    [
        ("touched", {}, "the field 'points' is missing"),
        ("touched", {"points": 5}, "points: a list belongs here"),
        ("touched", {"pts": []}, "there is no field 'pts'; known: relative_to, up, noise, tilt, points, tools"),
        ("touched", {"points": [LEVEL], "up": "q"}, "'q' is not known; it is one of z, y"),
        ("touched", {"points": [LEVEL]}, "1 points were touched; touch 3 at least"),
        ("touched", {"points": [LEVEL] * 3}, "lie on a line"),
        ("touched", {"points": [LEVEL], "tools": 5}, "'tools' are names of nodes, not 5"),
        ("touched", {"points": [LEVEL], "frame": "a", "robot": "b"}, "give one of them"),
        ("touched", {"points": [LEVEL], "least_apart": "far"}, "'least_apart' is 1 finite number, not ['far']"),
        ("touched", {"points": [LEVEL], "relative_to": "nowhere"}, "'nowhere'"),
        ("pictures", {}, "'pictures' are 1 to 10 files in base64"),
        ("pictures", {"pictures": ["%"]}, "a picture is a file in base64"),
        ("pictures", {"pictures": ["AAAA"]}, "picture 1 is no PNG and no JPEG"),
        ("pictures", {"pictures": [SHEET]}, "the camera's field of view or its matrix is needed"),
        ("pictures", {"pictures": [SHEET], "field": 70}, "the field of view is 70 rad; it lies between 0 and pi"),
        ("pictures", {"pictures": [SHEET], "field": 1, "number": True}, "'number' is a whole number, not True"),
        ("pictures", {"pictures": [SHEET], "field": 1, "number": 7}, "doesn't show marker 7 once: it shows 5"),
        ("pictures", {"pictures": [SHEET], "matrix": [1, 2, 3]}, "'matrix' is 4 finite numbers, not [1, 2, 3]"),
        ("pictures", {"pictures": [SHEET], "field": 1, "marker": "nowhere"}, "'nowhere'"),
    ],
)
def test_what_is_wrong_is_told_in_words(console: Console, path: str, said: dict[str, object], words: str) -> None:
    refused = ask(console, f"/registration/{path}", said)
    assert 400 <= refused.status < 500, refused.body
    assert words in refused.json["message"]

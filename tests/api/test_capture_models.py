"""ViewService.CaptureModel: pictures of known models, in worlds of their own."""

from __future__ import annotations

import io

import numpy as np
import pytest
from PIL import Image
from virtualrobot.v1 import scene_pb2, view_pb2

from tests.api.asking import refusal
from tests.kernels import Stubs

BACKGROUND = (230, 235, 240)
"""Of pictures of models: 0.90, 0.92, 0.94 of 255."""


def picture_of(stubs: Stubs, name: str) -> np.ndarray:
    """Return a model's picture (h, w, 3) as signed numbers."""
    answer = stubs.view.CaptureModel(view_pb2.CaptureModelRequest(name=name))
    picture = np.asarray(Image.open(io.BytesIO(answer.image)).convert("RGB"), int)
    assert picture.shape == (answer.height, answer.width, 3)
    return picture


def test_a_model_is_seen_whole_and_the_world_is_as_it_was(stepped: Stubs) -> None:
    before = stepped.scene.GetScene(scene_pb2.GetSceneRequest())
    pictures = [picture_of(stepped, name) for name in ("ur5e", "parallel_gripper")]
    for picture in pictures:
        shown = np.abs(picture - np.array(BACKGROUND)).max(axis=2) > 12
        rows, columns = np.nonzero(shown)
        assert 0.02 < shown.mean() < 0.6, "a part of the picture, and not all of it"
        # It is framed: nothing of it is cut off, and it is in the middle.
        height, width = shown.shape
        assert 0 < rows.min() and rows.max() < height - 1 and 0 < columns.min() and columns.max() < width - 1
        assert abs(0.5 * (rows.min() + rows.max()) - 0.5 * height) < 0.2 * height
    assert np.abs(pictures[0] - pictures[1]).max() > 50
    np.testing.assert_array_equal(picture_of(stepped, "ur5e"), pictures[0])
    assert stepped.scene.GetScene(scene_pb2.GetSceneRequest()).nodes == before.nodes


@pytest.mark.parametrize(("name", "nearest"), [("ur5ee", "ur5e"), ("", "")])
def test_what_is_no_model_is_refused(stepped: Stubs, name: str, nearest: str) -> None:
    refused = refusal(lambda: stepped.view.CaptureModel(view_pb2.CaptureModelRequest(name=name)))
    assert refused.reason == "UNKNOWN_NAME"
    assert nearest in refused.message

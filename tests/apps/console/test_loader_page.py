"""A person loads and saves at the console's page: library, files, archives, scenes; the kernel is asked each time."""

from __future__ import annotations

import io
import zipfile
from pathlib import Path

import pytest
import virtualrobot
from playwright.sync_api import FilePayload, Page, expect
from virtualrobot.v1 import kernel_pb2, scene_pb2

from tests.api.reading import scene
from tests.apps.console.browsing import PLAIN, browsers, needs_page, opened, row
from tests.apps.console.consoles import Console
from tests.kernels import KernelProcess, Stubs
from tests.waiting import until

pytestmark = [*needs_page, pytest.mark.long]

ARM = b"""<robot name="crane">
  <link name="base"><visual><geometry><mesh filename="package://crane/meshes/mast.obj"/></geometry></visual></link>
  <link name="boom"/>
  <joint name="slew" type="revolute"><parent link="base"/><child link="boom"/><axis xyz="0 0 1"/>
    <limit lower="-1" upper="1" velocity="1" effort="1"/></joint>
</robot>"""
TETRAHEDRON = b"v 0 0 0\nv 100 0 0\nv 0 100 0\nv 0 0 100\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n"
TABLE = b"schema_version: 1\nnodes:\n- name: table\n  object: {}\n  figures:\n  - box: {size: {x: 1, y: 1, z: 0.1}}\n"

DROP = """([name, text]) => {
    const data = new DataTransfer();
    data.items.add(new File([text], name));
    const view = document.querySelector(".view canvas").getBoundingClientRect();
    const at = {clientX: view.x + view.width / 2, clientY: view.y + view.height * 0.7};
    for (const kind of ["dragover", "drop"]) {
        const options = {dataTransfer: data, bubbles: true, cancelable: true, ...at};
        document.querySelector(".view canvas").dispatchEvent(new DragEvent(kind, options));
    }
}"""


def give(page: Page, *files: tuple[str, bytes], field: str = "#files") -> None:
    """Choose files as in the dialog of the browser, once the page has done with those before."""
    expect(page.locator("#loading")).to_have_count(0)
    payloads: list[FilePayload] = [{"name": name, "mimeType": "", "buffer": data} for name, data in files]
    page.set_input_files(field, payloads)


def archive(**files: bytes) -> bytes:
    """Return a zip archive; `__` in a name stands for a slash."""
    data = io.BytesIO()
    with zipfile.ZipFile(data, "w") as written:
        for name, content in files.items():
            written.writestr(name.replace("__", "/").replace("_dot_", "."), content)
    return data.getvalue()


def refused(page: Page) -> str:
    """Return the words of what is refused, and close them."""
    said = page.get_by_role("alert")
    expect(said).to_be_visible()
    words = said.inner_text()
    said.get_by_title("Close").click()
    return words


def test_a_person_loads_a_cell(console: Console, stepped: Stubs, stepped_kernel: KernelProcess, tmp_path: Path) -> None:
    with browsers() as browser, opened(browser, console.url + PLAIN) as page:
        expect(page.locator("#connection")).to_have_text("connected")

        # The library: found by words, placed by a click in the view, and taken back.
        page.get_by_role("button", name="Show the library").click()
        page.get_by_label("Filter models").fill("iiwa")
        page.get_by_label("Place iiwa7", exact=True).click()
        page.get_by_label("Name of the new model").fill("arm")
        view = page.locator(".view canvas").bounding_box()
        assert view
        page.mouse.click(view["x"] + 0.5 * view["width"], view["y"] + 0.7 * view["height"])
        until(lambda: "arm" in scene(stepped))
        expect(page.get_by_text("Nothing is here yet")).to_have_count(0)
        x, y, z = scene(stepped)["arm"][:3, 3]
        assert z == pytest.approx(0.0, abs=1e-6) and abs(x) + abs(y) > 0.0
        page.get_by_role("tab", name="Scene").click()
        expect(row(page, "arm")).to_have_attribute("aria-selected", "true")

        # A name that is taken: the kernel's words, and the person may choose another.
        page.get_by_role("tab", name="Library").click()
        page.get_by_label("Place iiwa7", exact=True).click()
        page.get_by_label("Name of the new model").fill("arm")
        place = """async (button) => {
            button.click();
            for (let turn = 0; turn < 9; turn++) await null;
            return document.querySelectorAll(".placing").length;
        }"""
        # Nobody is asked for a place while the model is read: a second click would place a second one.
        assert page.get_by_role("button", name="At the origin").evaluate(place) == 0
        assert "arm" in refused(page)
        page.get_by_label("Name of the new model").fill("second")
        there = page.get_by_label("Where it stands: x y z, mm")
        there.fill("500 -1250")
        expect(page.get_by_role("button", name="Place it there")).to_be_disabled()
        there.fill("500 -1250 0,5")
        there.press("Enter")
        until(lambda: "second" in scene(stepped))
        assert scene(stepped)["second"][:3, 3] == pytest.approx([0.5, -1.25, 0.0005])
        page.get_by_title("Undo (Ctrl-Z)").click()
        until(lambda: "second" not in scene(stepped))

        # A zip archive: the URDF names its mesh by a package that this machine doesn't have.
        give(page, ("crane.zip", archive(crane__crane_dot_urdf=ARM, crane__meshes__mast_dot_obj=TETRAHEDRON)))
        until(lambda: "crane.boom" in scene(stepped))
        page.get_by_title("Undo (Ctrl-Z)").click()
        until(lambda: "crane" not in scene(stepped))

        # A mesh that is dropped stands where it was dropped, in the unit that the person says: 100 mm are 0.1 m.
        page.evaluate(DROP, ["wedge.obj", TETRAHEDRON.decode()])
        page.get_by_role("button", name="Millimeters").click()
        until(lambda: "wedge" in scene(stepped))
        (node,) = stepped.scene.GetScene(scene_pb2.GetSceneRequest(names=["wedge"])).nodes
        assert node.figures[0].mesh.scale.x == pytest.approx(0.001)

        # Saved, replaced by another scene, and opened again.
        with page.expect_download() as saved:
            page.locator("#save").click()
        file = tmp_path / saved.value.suggested_filename
        saved.value.save_as(file)
        give(page, ("table.yaml", TABLE), field="#open-scene")
        page.get_by_role("button", name="Add to it").click()
        until(lambda: {"table", "arm"} <= scene(stepped).keys())
        give(page, ("table.yaml", TABLE.replace(b"table", b"desk")), field="#open-scene")
        page.get_by_role("button", name="Replace it").click()
        until(lambda: "desk" in scene(stepped) and "arm" not in scene(stepped))
        give(page, (file.name, file.read_bytes()), field="#open-scene")
        page.get_by_role("button", name="Replace it").click()
        until(lambda: {"arm", "wedge"} <= scene(stepped).keys())
        assert "desk" not in scene(stepped)

        # What can't be loaded is named, and changes nothing.
        before = scene(stepped).keys()
        give(page, ("notes.foo", b"?"))
        words = refused(page)
        assert "notes.foo" in words and ".urdf" in words
        give(page, ("crane.urdf", ARM))
        words = refused(page)
        assert "mast.obj" in words and "zip" in words
        give(page, ("broken.urdf", b"<robot name='x'><link name='a'>"))
        assert "broken.urdf" in refused(page)
        give(page, ("broken.zip", b"no archive"))
        assert "broken.zip is no zip archive" in refused(page)
        page.evaluate("Object.defineProperty(File.prototype, 'size', {get: () => 1e12})")
        give(page, ("huge.stl", b"solid"))
        limit = stepped.kernel.GetInfo(kernel_pb2.GetInfoRequest()).max_asset_bytes
        assert f"{limit // 2**20} MiB (limit asset_bytes)" in refused(page)
        assert scene(stepped).keys() == before


def test_an_upload_that_is_cancelled_or_cut_off_changes_nothing(
    console: Console, stepped: Stubs, stepped_kernel: KernelProcess
) -> None:
    with virtualrobot.connect(stepped_kernel.address) as client, browsers() as browser:
        client.scene.add_object("table", virtualrobot.box(1.0, 1.0, 0.1))
        before = scene(stepped).keys()
        with opened(browser, console.url + PLAIN) as page:
            expect(row(page, "table")).to_be_visible()
            page.get_by_role("tab", name="Library").click()
            # The request waits until the person cancels it.
            page.route("**/UploadAsset", lambda route: None)
            give(page, ("wedge.obj", TETRAHEDRON + b"# a file which the kernel hasn't from another test"))
            page.locator("#loading").get_by_title("Cancel: nothing changes").click()
            expect(page.locator("#loading")).to_have_count(0)
            expect(page.locator("#last")).to_contain_text("cancelled; nothing has changed")
            page.unroute("**/UploadAsset")
            page.route("**/UploadAsset", lambda route: route.abort("connectionreset"))
            give(page, ("wedge.obj", TETRAHEDRON + b"# another file, which the kernel can't have already"))
            assert "the connection was lost" in refused(page)
        assert scene(stepped).keys() == before

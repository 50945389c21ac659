"""The asset store: by content, within limits, from any thread."""

import hashlib
import threading
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from virtualrobot_kernel.errors import KernelError, Reason
from virtualrobot_kernel.formats.assets import AssetStore
from virtualrobot_kernel.scenes.assets import check_assets
from virtualrobot_kernel.world.commands import CreateNodes
from virtualrobot_kernel.world.figures import Figure, Mesh

from tests.unit.world.builders import after, empty, part


def refused(call: object, *arguments: object) -> KernelError:
    with pytest.raises(KernelError) as caught:
        call(*arguments)  # pyright: ignore[reportCallIssue]
    return caught.value


def test_bytes_are_found_by_their_sha256() -> None:
    store = AssetStore()
    sha256 = store.put(b"abc")
    assert sha256 == "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad"  # FIPS 180-2, appendix B.1
    assert store.get(sha256) == b"abc" and store.get(sha256.upper()) == b"abc"
    assert store.has(sha256) and not store.has("0" * 64)
    assert store.put(b"abc", sha256.upper()) == sha256


def test_what_is_kept_does_not_change_with_the_callers_buffer() -> None:
    store, buffer = AssetStore(), bytearray(b"abc")
    sha256 = store.put(buffer)  # pyright: ignore[reportArgumentType]  a caller may hold a buffer all the same
    buffer[0] = 0
    assert store.get(sha256) == b"abc"


def test_bytes_that_are_not_what_they_should_be_are_refused() -> None:
    store = AssetStore()
    error = refused(store.put, b"abc", "0" * 64)
    assert error.reason is Reason.MALFORMED_ASSET and error.metadata["stated_sha256"] == "0" * 64
    assert not store.has(hashlib.sha256(b"abc").hexdigest())


@pytest.mark.parametrize("sha256", ["", "abc", "g" * 64, "0" * 63, "../../etc/passwd"])
def test_what_is_no_sha256_is_refused(sha256: str) -> None:
    assert refused(AssetStore().get, sha256).reason is Reason.MALFORMED_ASSET


def test_an_unknown_asset_is_refused() -> None:
    error = refused(AssetStore().get, "0" * 64)
    assert error.reason is Reason.UNKNOWN_ASSET and error.metadata["sha256"] == "0" * 64


def test_limits_of_one_asset_and_of_all() -> None:
    store = AssetStore(limit_bytes=10, total_limit_bytes=25)
    error = refused(store.put, bytes(11))
    assert error.reason is Reason.TOO_LARGE
    assert (error.metadata["size_bytes"], error.metadata["limit_bytes"]) == ("11", "10")
    first = store.put(bytes(10))
    store.put(b"1" * 10)
    assert refused(store.put, b"2" * 10).metadata["limit_bytes"] == "25"
    assert store.put(bytes(10)) == first  # again: costs nothing
    store.put(b"3" * 5)
    assert refused(store.put, b"4").reason is Reason.TOO_LARGE


def test_many_threads_put_and_get() -> None:
    store = AssetStore(total_limit_bytes=200 * 8)
    failures: list[BaseException] = []

    def work() -> None:
        try:
            for i in range(200):
                assert store.get(store.put(i.to_bytes(8, "little"))) == i.to_bytes(8, "little")
        except BaseException as error:
            failures.append(error)

    threads = [threading.Thread(target=work) for _ in range(8)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert not failures
    assert refused(store.put, b"one more").reason is Reason.TOO_LARGE  # each was counted once


def test_what_is_put_into_a_folder_is_there_for_the_next_store(tmp_path: Path) -> None:
    first = AssetStore(folder=tmp_path / "assets")
    sha256 = first.put(b"mesh")
    again = AssetStore(folder=tmp_path / "assets")
    assert again.has(sha256) and again.has(sha256.upper()) and not again.has("0" * 64)
    assert again.get(sha256) == b"mesh"
    assert [file.name for file in (tmp_path / "assets").iterdir()] == [sha256]


def test_a_damaged_file_of_the_folder_is_named_and_not_taken(tmp_path: Path) -> None:
    sha256 = AssetStore(folder=tmp_path).put(b"mesh")
    (tmp_path / sha256).write_bytes(b"mess")
    error = refused(AssetStore(folder=tmp_path).get, sha256)
    assert error.reason is Reason.MALFORMED_ASSET and str(tmp_path / sha256) in str(error)


def test_a_name_that_leads_out_of_the_folder_is_no_asset(tmp_path: Path) -> None:
    (tmp_path / "secret").write_bytes(b"x")
    store = AssetStore(folder=tmp_path / "assets")
    assert not store.has("../secret")
    assert refused(store.get, "../secret").reason is Reason.MALFORMED_ASSET


def test_a_world_whose_mesh_is_gone_is_refused_by_node_and_file(tmp_path: Path) -> None:
    store = AssetStore(folder=tmp_path / "assets")
    origin = tmp_path / "cup.stl"
    origin.write_bytes(b"solid cup")
    mesh = Mesh(str(origin), store.put(b"solid cup"))
    world = after(empty(), CreateNodes((replace(part("cup", np.eye(4)), figures=(Figure(mesh),)),))).structure
    (tmp_path / "assets" / mesh.sha256).unlink()
    check_assets(world, AssetStore(folder=tmp_path / "assets"))
    assert (tmp_path / "assets" / mesh.sha256).read_bytes() == b"solid cup", "taken anew from where it came from"
    (tmp_path / "assets" / mesh.sha256).unlink()
    origin.write_bytes(b"another cup")
    error = refused(check_assets, world, AssetStore(folder=tmp_path / "assets"))
    assert "'cup'" in str(error) and "cup.stl" in str(error) and mesh.sha256 in str(error)
    cups = [replace(part(f"cup{i}", np.eye(4)), figures=(Figure(Mesh("", f"{i:064x}")),)) for i in range(12)]
    error = refused(check_assets, after(empty(), CreateNodes(tuple(cups))).structure, store)
    assert f"{tmp_path / 'assets'} lacks 12 files of meshes, copy them back: " in str(error)
    assert "'cup9'" in str(error) and "'cup10'" not in str(error) and str(error).endswith(" and 2 more")

"""The asset store: by content, within limits, from any thread."""

import hashlib
import threading

import pytest
from virtualrobot_kernel.errors import KernelError, Reason
from virtualrobot_kernel.formats.assets import AssetStore


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

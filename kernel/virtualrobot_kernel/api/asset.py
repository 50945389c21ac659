"""AssetService: files in chunks, by content."""

from __future__ import annotations

from collections.abc import AsyncIterator

from virtualrobot.v1 import asset_pb2, asset_pb2_grpc, nodes_pb2

from virtualrobot_kernel.api.kernel_services import KernelServices
from virtualrobot_kernel.errors import KernelError, Reason
from virtualrobot_kernel.formats.references import list_references
from virtualrobot_kernel.messages.structs import settings

CHUNK_BYTES = 1024 * 1024


class AssetServicer(asset_pb2_grpc.AssetServiceServicer):
    """Servicer of AssetService."""

    def __init__(self, kernel: KernelServices) -> None:
        """Serve from the kernel."""
        self._kernel = kernel

    async def UploadAsset(
        self, request_iterator: AsyncIterator[asset_pb2.UploadAssetRequest], context: object
    ) -> asset_pb2.UploadAssetResponse:
        """Take a file; nothing is kept of one that breaks off or does not have the stated SHA-256."""
        store = self._kernel.assets
        stated, data = "", bytearray()
        async for request in request_iterator:
            stated = stated or request.sha256
            if not stated:
                raise KernelError(
                    "the first message of an upload must state the SHA-256", reason=Reason.MALFORMED_ASSET
                )
            if len(request.chunk) > CHUNK_BYTES:
                raise KernelError(
                    f"a chunk may have {CHUNK_BYTES} bytes, not {len(request.chunk)}", reason=Reason.TOO_LARGE
                )
            store.check_size(len(data) + len(request.chunk), "the upload")
            data += request.chunk
        if not stated:
            raise KernelError(
                "the upload has no message; the first must state the SHA-256", reason=Reason.MALFORMED_ASSET
            )
        sha256 = await self._kernel.in_worker(store.put, bytes(data), stated)
        return asset_pb2.UploadAssetResponse(sha256=sha256, size_bytes=len(data))

    async def DownloadAsset(
        self, request: asset_pb2.DownloadAssetRequest, context: object
    ) -> AsyncIterator[asset_pb2.DownloadAssetResponse]:
        """Give a file."""
        data = self._kernel.assets.get(request.sha256)
        for start in range(0, len(data), CHUNK_BYTES):
            yield asset_pb2.DownloadAssetResponse(chunk=data[start : start + CHUNK_BYTES])

    async def FindAssets(self, request: asset_pb2.FindAssetsRequest, context: object) -> asset_pb2.FindAssetsResponse:
        """Tell which files are here already."""
        store = self._kernel.assets
        return asset_pb2.FindAssetsResponse(sha256s=[sha256 for sha256 in request.sha256s if store.has(sha256)])

    async def ListReferences(
        self, request: asset_pb2.ListReferencesRequest, context: object
    ) -> asset_pb2.ListReferencesResponse:
        """Tell which other files a file names."""
        store = self._kernel.assets
        data = store.get(request.sha256)
        known = {file.uri: store.get(file.sha256) for file in request.files}
        given = settings(request.settings, "settings")
        found = await self._kernel.in_worker(list_references, data, request.uri, self._kernel.importers, known, given)
        files = [nodes_pb2.AssetFile(uri=uri, sha256=sha256) for uri, sha256 in found.items()]
        return asset_pb2.ListReferencesResponse(files=files)

"""Servers of HTTP and WebSockets: one configuration for all that listen."""

from __future__ import annotations

from typing import Any

import uvicorn


def server_config(application: Any, most_bytes: int, **more: Any) -> uvicorn.Config:  # noqa: ANN401 as uvicorn has it
    """Return how an ASGI application is served: HTTP by h11, and WebSockets, whose messages have `most_bytes`.

    What a request says of proxies before it is believed by nobody, and the server says nothing of itself. `more` are
    settings of uvicorn's own, such as `ssl_certfile`.
    """
    return uvicorn.Config(
        application,
        interface="asgi3",
        lifespan="off",
        http="h11",
        ws="websockets-sansio",
        ws_max_size=most_bytes,
        # It would hold back small answers.
        ws_per_message_deflate=False,
        proxy_headers=False,
        server_header=False,
        log_config=None,
        log_level="critical",
        access_log=False,
        timeout_graceful_shutdown=1,
        **more,
    )

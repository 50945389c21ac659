"""Note on the page that tells what the kernel is busy with, in every browser, for as long as it is."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import viser


class WorkNote:
    """Note in each browser; used by the drawing thread."""

    def __init__(self) -> None:
        """Begin with nothing shown."""
        self._told: dict[int, tuple[str, viser.NotificationHandle]] = {}

    def show(self, clients: Mapping[int, viser.ClientHandle], work: Sequence[str]) -> None:
        """Show in browsers, by their numbers, what is under way; nothing takes the note away."""
        words = ", ".join(work)
        for number in [number for number in self._told if number not in clients]:
            del self._told[number]
        for number, client in clients.items():
            shown, note = self._told.get(number, ("", None))
            if words == shown:
                continue
            if note is not None:
                note.remove()
                del self._told[number]
            if words:
                note = client.add_notification("Working", words, loading=True, with_close_button=False)
                self._told[number] = words, note

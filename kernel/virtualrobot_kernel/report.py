"""Report of a fault, as one zip archive: scene, journal, versions, plugins and log; never a token.

Unpacked it is a project folder, which `virtualrobot replay` shows.
"""

from __future__ import annotations

import json
import sqlite3
import time
import zipfile
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory

from virtualrobot_kernel.components.catalog import Plugin
from virtualrobot_kernel.errors import KernelError
from virtualrobot_kernel.formats.assets import AssetStore
from virtualrobot_kernel.history.folder import ASSETS, JOURNAL, LAST_TICK, LOG, PROJECT, Project, project_text, versions
from virtualrobot_kernel.history.last_tick import LastTick
from virtualrobot_kernel.history.past import PastFolder
from virtualrobot_kernel.history.store import Store
from virtualrobot_kernel.planning.robots import world_poses
from virtualrobot_kernel.recent_log import HIDDEN, kept_log
from virtualrobot_kernel.scenes.writing import write_scene
from virtualrobot_kernel.world.figures import meshes_of
from virtualrobot_kernel.world.state import Snapshot

MOST_BYTES = 100 * 1000 * 1000
"""Greatest size of the journal's entries in a report where nobody says another one."""


@dataclass(frozen=True, slots=True, eq=False)
class Reported:
    """Parts of a report.

    Attributes:
        store: the journal.
        project: how it was written; its seed is that of the store.
        world: how the world is now, or was at last.
        assets: where the files of meshes are.
        plugins: those that were found.
        log: gives the newest lines of the log.
        secrets: words that are hidden.
    """

    store: Store
    project: Project
    world: Snapshot
    assets: AssetStore
    plugins: tuple[Plugin, ...] = ()
    log: Callable[[], str] = str
    secrets: tuple[str, ...] = ()


def write_report(target: Path, about: Reported, most_bytes: int = MOST_BYTES) -> None:
    """Write a report as a file; of the journal the newest part, about `most_bytes` of entries.

    Raises KernelError when it can't be written.
    """
    secrets = [secret for secret in about.secrets if secret]

    def clean(text: str) -> str:
        for secret in secrets:
            text = text.replace(secret, HIDDEN)
        return text

    try:
        with (
            TemporaryDirectory(prefix="virtualrobot-report-") as place,
            zipfile.ZipFile(target, "w", zipfile.ZIP_DEFLATED) as archive,
        ):
            copy = Path(place)
            first, last = _journal(copy / JOURNAL, about, most_bytes)
            last_tick = LastTick(copy / LAST_TICK, about.project.seed)
            last_tick.write(about.world.state.tick)
            last_tick.close()
            archive.write(copy / JOURNAL, JOURNAL)
            archive.write(copy / LAST_TICK, LAST_TICK)
            archive.writestr(PROJECT, clean(project_text(about.project)))
            archive.writestr("scene.yaml", clean(write_scene(about.world, bundled=False)[0]))
            archive.writestr(LOG, clean(about.log()))
            archive.writestr("report.json", clean(json.dumps(_told(about, first, last), indent=2)) + "\n")
            meshes = meshes_of(about.world.structure.figures)
            for sha256 in dict.fromkeys(sha256 for mesh in meshes for _, sha256 in mesh.all_files):
                if about.assets.has(sha256):
                    archive.writestr(f"{ASSETS}/{sha256}", about.assets.get(sha256))
    except (OSError, sqlite3.Error) as error:
        raise KernelError(f"the report {target} can't be written: {error}", path=target) from error


def report_of_folder(path: Path, target: Path) -> None:
    """Write the report of a project folder, whether a kernel uses it or not.

    Raises KernelError when it is no such folder, or damaged.
    """
    past = PastFolder(path)
    try:
        cursor = past.replay(world_poses).at(past.store.last_tick)
        structure, state = cursor.structure, cursor.state
        world = Snapshot(structure, state, world_poses(structure, state), 0, 0.0, past.tick_seconds)
        assets = AssetStore(folder=past.assets, read_only=True)
        write_report(target, Reported(past.store, past.project, world, assets, log=lambda: kept_log(path / LOG)))
    finally:
        past.close()


def _journal(path: Path, about: Reported, most_bytes: int) -> tuple[int, int]:
    """Write a copy of the newest part of the journal; return the numbers of its first and last entry."""
    about.store.copy(path)
    store = Store(path, about.project.seed)
    try:
        if not about.store.warnings:  # all that a tail has is written here, and no copy needs it
            store.note_life(0)
        heads = store.checkpoints()
        if store.entry_bytes(0) > most_bytes and heads:
            begin = next((one for one in heads if store.entry_bytes(one.seq) <= most_bytes), heads[-1])
            store.remove_checkpoints([one.id for one in store.begin_with(begin)])
        numbers = store.forgotten + 1, store.last_seq
    finally:
        store.close()
    database = sqlite3.connect(path)
    database.execute("VACUUM")
    database.close()
    return numbers


def _told(about: Reported, first: int, last: int) -> dict[str, object]:
    state = about.world.state
    return {
        "written": time.strftime("%Y-%m-%d %H:%M:%S %z"),
        "tick": state.tick,
        "simulation_seconds": about.world.simulation_time,
        "first_entry": first,
        "last_entry": last,
        "versions": versions(),
        "versions_that_wrote_the_journal": dict(about.project.versions or {}),
        "plugins": [
            {"name": one.name, "package": one.package, "version": one.version, "fault": one.reason}
            for one in about.plugins
        ],
    }

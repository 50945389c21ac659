"""Studies whose results are in a bucket: moto's server (Apache 2.0) plays S3 in a process of its own."""

from __future__ import annotations

import importlib.util
import io
import json
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from unittest import mock

import boto3
import pytest
from click.testing import CliRunner
from pyarrow import parquet
from virtualrobot.errors import WrongStateError
from virtualrobot_apps.studies.command import study as command
from virtualrobot_apps.studies.engines import Here, Local
from virtualrobot_apps.studies.parts import Parts
from virtualrobot_apps.studies.running import CANCEL, open_job, run
from virtualrobot_apps.studies.stores import store_of

from tests.apps.studies import CELLS, FAILED, STUDY, done, written

pytestmark = pytest.mark.long


@contextmanager
def served(monkeypatch: pytest.MonkeyPatch) -> Iterator[subprocess.Popen[str]]:
    """Start a server with a bucket `cells`, to which the environment leads."""
    with subprocess.Popen(
        [sys.executable, "-m", "moto.server", "-H", "127.0.0.1", "-p", "0"], stderr=subprocess.PIPE, text=True
    ) as server:
        try:
            assert server.stderr is not None
            line = next(line for line in server.stderr if "Running on http" in line)
            monkeypatch.setenv("AWS_ENDPOINT_URL", line.split()[-1])
            for name, value in (("ACCESS_KEY_ID", "k"), ("SECRET_ACCESS_KEY", "s"), ("DEFAULT_REGION", "us-east-1")):
                monkeypatch.setenv(f"AWS_{name}", value)
            boto3.client("s3").create_bucket(Bucket="cells")
            yield server
        finally:
            server.kill()


@pytest.fixture(scope="module", autouse=True)
def server() -> Iterator[None]:
    """Serve a bucket to all tests of this file."""
    with pytest.MonkeyPatch.context() as monkeypatch, served(monkeypatch):
        yield


def test_a_study_in_a_bucket_is_the_one_in_a_folder(tmp_path: Path) -> None:
    """Cancelled, resumed by worker processes that write each by itself, looked at by commands and by boto3."""
    study, url = written(tmp_path / "in"), "s3://cells/whole/out"
    _, expected = done(study, tmp_path / "out")
    told = run(open_job(study, url, False), Here(), lambda progress: store_of(url).write(CANCEL, b""))
    assert 0 < told.done < CELLS
    with pytest.raises(WrongStateError, match=f"{url} has {told.done} of {CELLS} cells already"):
        open_job(study, url, False)
    progress = run(open_job(study, url, True), Local(2))
    assert (progress.done, progress.failed) == (CELLS, FAILED)
    file = str(study.file)
    shown = CliRunner().invoke(command, ["status", file, "--folder", f"{url}/", "--json"])
    assert json.loads(shown.output) == {"cells": CELLS, "done": CELLS, "failed": FAILED, "killed": 0} | {
        "sha256": expected.digest()
    }
    assert CliRunner().invoke(command, ["report", file, "--folder", url]).output.strip().endswith("study-report.html")
    found = boto3.client("s3").list_objects_v2(Bucket="cells", Prefix="whole/out/cells/")["Contents"]
    assert len(found) == -(-CELLS // study.block)
    part = boto3.client("s3").get_object(Bucket="cells", Key=found[1]["Key"])["Body"].read()
    assert parquet.read_table(io.BytesIO(part)).column("cell").to_pylist() == list(range(7, 14))


def test_of_two_writers_of_a_part_the_first_ones_stays(tmp_path: Path) -> None:
    parts = Parts("s3://cells/twice", written(tmp_path / "in"))
    row = {"cell": 0, "status": "ok", "error": "", "x": 0.0, "u": 0.0, "y": 1.0, "odd": None}
    for worker in ("first", "second"):
        parts.write([row | {"seconds": 0.1, "worker": worker}])
    assert parts.table().column("worker").to_pylist() == ["first"]


def test_what_cannot_be_written_is_said(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    study = written(tmp_path / "in", STUDY.replace("block: 7", "block: 20"))
    with pytest.raises(WrongStateError, match="s3://nobody/out cannot be written: there is no bucket 'nobody'"):
        open_job(study, "s3://nobody/out", False)
    with pytest.raises(WrongStateError, match="'s3:///out' names no bucket: s3://BUCKET/FOLDER belongs here"):
        open_job(study, "s3:///out", False)
    shown = CliRunner().invoke(command, ["status", str(study.file), "--folder", "s3://cells/nothing"])
    assert "s3://cells/nothing has no results yet" in str(shown.exception)
    with (
        mock.patch.object(importlib.util, "find_spec", lambda name: None),
        pytest.raises(WrongStateError, match=r"need obstore: pip install 'virtualrobot\[s3\]'"),
    ):
        open_job(study, "s3://cells/out", False)
    with served(monkeypatch) as gone:
        job = open_job(study, "s3://cells/gone", False)
        with pytest.raises(WrongStateError, match=r"s3://cells/gone cannot be written: .*what is done stays"):
            run(job, Here(), lambda progress: gone.kill())

"""Parts of a study: a folder of Parquet files, one for each block of cells that is done. They are the truth."""

from __future__ import annotations

import hashlib
import io
import json
import re
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import pyarrow
from pyarrow import parquet
from virtualrobot.errors import MalformedFileError

from virtualrobot_apps.studies.parameters import Floats
from virtualrobot_apps.studies.stores import store_of
from virtualrobot_apps.studies.study_file import NUMBER, RESERVED, Study

_ABOUT = {
    **{"cell": pyarrow.int64(), "status": pyarrow.string(), "error": pyarrow.string()},
    **{"seconds": pyarrow.float64(), "worker": pyarrow.string()},
}
_COUNTED = ("failed", "killed")
_PART = re.compile(r"(\d+)-(\d+)\.parquet")


class Counts(NamedTuple):
    """Numbers of cells that are done, and of those among them that failed or killed their workers."""

    done: int
    failed: int
    killed: int


class Parts:
    """Folder of a study's results: the files that blocks have become, and the table that they make together."""

    def __init__(self, folder: Path | str, study: Study) -> None:
        """Name the folder, a path or `s3://BUCKET/FOLDER`; nothing is read or made yet."""
        self.store = store_of(folder)
        self._study = study
        kinds = {one.name: not one.is_text for one in study.cells.parameters}
        kinds |= {name: kind == NUMBER for name, kind in study.results}
        values = {name: pyarrow.float64() if number else pyarrow.string() for name, number in kinds.items()}
        self._schema = pyarrow.schema(list((_ABOUT | values).items()))

    def make(self) -> None:
        """Make the folders, without what killed workers have left unwritten; raise OSError where that can't be."""
        self.store.make()

    def trace(self, first: int, last: int) -> Path:
        """Return the file in which a worker that dies in a block leaves where it was."""
        return self.store.scratch() / f"{_name(first, last)}.txt"

    def write(self, rows: Sequence[Mapping[str, Any]]) -> None:
        """Keep the rows of a block, which lie side by side; raise OSError where that can't be."""
        columns = [column([row.get(one.name) for row in rows], one.type) for one in self._schema]
        counts = {name: str(sum(row["status"] == name for row in rows)) for name in _COUNTED}
        table = pyarrow.Table.from_arrays(columns, schema=self._schema.with_metadata(counts))
        content = io.BytesIO()
        parquet.write_table(table, content, compression="zstd")
        self.store.add(f"cells/{_name(rows[0]['cell'], rows[-1]['cell'] + 1)}.parquet", content.getvalue())

    def missing(self) -> list[tuple[int, int]]:
        """Return the cells that are in no part, as blocks (first, last) without the last."""
        found, next_cell = [], 0
        for first, last, _ in self._files():
            if first > next_cell:
                found.append((next_cell, first))
            next_cell = max(next_cell, last)
        return found + ([(next_cell, self._study.cells.count)] if next_cell < self._study.cells.count else [])

    def counts(self) -> Counts:
        """Return how many cells are done, and how many of these failed or killed their workers."""
        done = self._study.cells.count - sum(last - first for first, last in self.missing())
        found = [self._file(part).metadata.metadata or {} for _, _, part in self._files()]
        return Counts(done, *(sum(int(one.get(name.encode(), b"0")) for one in found) for name in _COUNTED))

    def table(self) -> pyarrow.Table:
        """Return the rows of all cells that are done, by their numbers, each once.

        Raises:
            MalformedFileError: when a part is damaged.
        """
        tables, next_cell = [self._schema.empty_table()], 0
        for first, last, part in self._files():
            if last > next_cell:
                tables.append(self._rows(part).slice(max(0, next_cell - first)))
                next_cell = last
        return pyarrow.concat_tables(tables)

    def numbers(self, name: str, first: int, last: int) -> Floats:
        """Return a result of the cells from `first` up to but not with `last`, NaN where there is none.

        Raises:
            MalformedFileError: when a part is damaged.
        """
        found = np.full(last - first, np.nan)
        for begin, end, part in self._files():
            if begin < last and end > first:
                values = np.asarray(self._rows(part).column(name).to_numpy(), dtype=np.float64)
                here, there = max(begin, first), min(end, last)
                found[here - first : there - first] = values[here - begin : there - begin]
        return found

    def digest(self) -> str:
        """Return the SHA-256 (hexadecimal) of the cells that are done: numbers, states, parameters and results.

        It is the same for the same cells, whatever order, blocks and workers they had: times, workers and the words of
        errors don't count.
        """
        table, total = self.table(), hashlib.sha256()
        for name in ["cell", "status", *(one for one in self._schema.names if one not in RESERVED)]:
            column = table.column(name).combine_chunks()
            total.update(name.encode())
            if pyarrow.types.is_string(column.type):
                total.update(json.dumps(column.to_pylist()).encode())
            else:
                # What there is not is NaN here, which no result is.
                total.update(np.ascontiguousarray(column.to_numpy(zero_copy_only=False)).tobytes())
        return total.hexdigest()

    def _files(self) -> Iterator[tuple[int, int, str]]:
        """Yield first cell, the one after the last, and name of each part, in order."""
        for name in self.store.names("cells"):
            if found := _PART.fullmatch(name):
                yield int(found[1]), int(found[2]) + 1, f"cells/{name}"

    def _rows(self, part: str) -> pyarrow.Table:
        file = self._file(part)
        try:
            rows = file.read().replace_schema_metadata(None)
        except (OSError, pyarrow.ArrowException) as error:
            raise self._damaged(part, error) from error
        if not rows.schema.equals(self._schema):
            raise MalformedFileError(
                f"{self.store.where(part)} has other columns than the parameters and results of {self._study.file}"
            )
        return rows

    def _file(self, part: str) -> parquet.ParquetFile:
        content = self.store.open(part)
        try:
            return parquet.ParquetFile(content)
        except (OSError, pyarrow.ArrowException) as error:
            raise self._damaged(part, error) from error

    def _damaged(self, part: str, error: Exception) -> MalformedFileError:
        return MalformedFileError(f"{self.store.where(part)} is damaged ({error}): delete it and resume the study")


def column(values: Sequence[Any], kind: pyarrow.DataType) -> pyarrow.Array:
    """Return values, None for those that there are not, as a column: `pyarrow.array`, which would import pandas."""
    there = np.packbits([value is not None for value in values], bitorder="little")
    if pyarrow.types.is_string(kind):
        texts = [b"" if value is None else str(value).encode(errors="backslashreplace") for value in values]
        ends = np.cumsum([0, *(len(text) for text in texts)], dtype=np.int32)
        parts = [ends, np.frombuffer(b"".join(texts), np.uint8)]
    else:
        parts = [np.array([0 if value is None else value for value in values], kind.to_pandas_dtype())]
    return pyarrow.Array.from_buffers(kind, len(values), [pyarrow.py_buffer(part) for part in (there, *parts)])


def _name(first: int, last: int) -> str:
    return f"{first:010d}-{last - 1:010d}"

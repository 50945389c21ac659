"""Parquet files of rows, by Apache Arrow."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, BinaryIO

import pyarrow
from pyarrow import parquet

from virtualrobot.recording.table_output import Cell, Column

_TYPES: dict[type, Any] = {
    float: pyarrow.float64(),
    int: pyarrow.int64(),
    bool: pyarrow.bool_(),
    str: pyarrow.string(),
}
_ROWS = 10_000
"""Number of rows that are written together."""


class ParquetFile:
    """A Parquet file; each column has its unit as metadata. It can be read once it is closed."""

    def __init__(self, stream: BinaryIO, columns: Sequence[Column], about: Mapping[str, str]) -> None:
        """Begin a file in `stream`."""
        fields = [pyarrow.field(one.name, _TYPES[one.type], metadata={"unit": one.unit}) for one in columns]
        self._schema = pyarrow.schema(fields, metadata=dict(about))
        self._writer = parquet.ParquetWriter(stream, self._schema)
        self._rows: list[list[Cell]] = []

    def write(self, row: Sequence[Cell]) -> None:
        """Add a row."""
        self._rows.append(list(row))
        if len(self._rows) >= _ROWS:
            self._flush()

    def _flush(self) -> None:
        columns = zip(*self._rows, strict=True) if self._rows else [()] * len(self._schema)
        arrays = [pyarrow.array(list(cells), field.type) for cells, field in zip(columns, self._schema, strict=True)]
        self._writer.write_table(pyarrow.Table.from_arrays(arrays, schema=self._schema))
        self._rows = []

    def close(self, about: Mapping[str, str]) -> None:
        """Write the last rows and what describes the file."""
        self._flush()
        self._writer.add_key_value_metadata(dict(about))
        self._writer.close()

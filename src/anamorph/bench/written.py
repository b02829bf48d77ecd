"""Measurements as tables of comma-separated values."""

from __future__ import annotations

import csv
import io
from collections.abc import Sequence
from dataclasses import astuple, fields
from typing import Any


def as_csv(rows: Sequence[Any], adapter: str, cores: int) -> str:
    """Rows, dataclasses of one kind, each with the machine that they were measured on."""
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow([*(column.name for column in fields(rows[0])), "adapter", "cores"])
    for row in rows:
        cells = (f"{value:.6g}" if isinstance(value, float) else value for value in astuple(row))
        writer.writerow([*cells, adapter, cores])
    return text.getvalue()

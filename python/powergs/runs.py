"""Runs that another simulator made, for machines with ``dataflow = "recorded"``."""

from __future__ import annotations

import csv
import os
import tempfile
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

from .errors import InputError

__all__ = ["write_run"]

_COLUMNS = ("frame", "what", "count", "cycle", "needed", "address", "phase")
_REQUESTS = {"what", "bytes", "cycle", "needed", "address", "phase"}
_NEEDED = {"what", "bytes", "cycle", "address"}


def write_run(
    path: str | os.PathLike[str],
    frames: Mapping[str, Mapping[str, Any]],
    *,
    overwrite: bool = False,
) -> None:
    """Writes the file of a run, which ``[recorded] file`` of a machine file names.

    Parameters
    ----------
    path : str or path
        The CSV file; one that is there is refused unless ``overwrite`` says so.
    frames : mapping
        By the id of a frame (``trace.ids()``), what is said of it: ``"cycles"``, the keys of actions
        (``"alpha"``, ``"sram-read.raster-in"``), ``"busy.raster"``, each with a count; and
        ``"requests"``, a mapping of columns of one length, arrays or lists: ``what`` (``"dram-read"``
        or ``"dram-write"``), ``bytes``, ``cycle``, ``address``, and where they are known ``needed``
        (negative: nothing waits for it) and ``phase``. ``what`` and ``phase`` may be one word for
        all.

    >>> powergs.write_run("mine.csv", {trace.ids()[0]: {                            # doctest: +SKIP
    ...     "cycles": 170184, "alpha": 10374189, "blend": 10374189,
    ...     "requests": {"what": "dram-read", "bytes": sizes, "cycle": times, "address": places},
    ... }})

    Raises ``InputError`` for columns that are missing, unknown or of different lengths, and
    ``FileExistsError``. What is in them is checked when a machine reads the file.
    """
    target = Path(path)
    if target.exists() and not overwrite:
        raise FileExistsError(f"{target} is there already: overwrite=True replaces it")
    handle, draft = tempfile.mkstemp(dir=target.parent, prefix=target.name, suffix=".tmp")
    try:
        with os.fdopen(handle, "w", newline="") as file:
            rows = csv.writer(file, lineterminator="\n")
            rows.writerow(_COLUMNS)
            for frame, said in frames.items():
                rows.writerows(_rows(frame, said))
        os.chmod(draft, 0o666 & ~_umask())
        os.replace(draft, target)
    except BaseException:
        os.unlink(draft)
        raise


def _umask() -> int:
    mask = os.umask(0)
    os.umask(mask)
    return mask


def _rows(frame: str, said: Mapping[str, Any]) -> Iterable[tuple[Any, ...]]:
    for what, count in said.items():
        if what != "requests":
            yield (frame, what, int(count))
    columns = dict(said.get("requests", {}))
    if not columns:
        return
    unknown, missing = sorted(columns.keys() - _REQUESTS), sorted(_NEEDED - columns.keys())
    if unknown or missing:
        raise InputError(
            f"requests of frame {frame}: "
            + "; ".join(
                f"{word} {', '.join(names)}"
                for word, names in (("no column", unknown), ("missing", missing))
                if names
            )
        )
    values = {
        name: column.tolist() if hasattr(column, "tolist") else column
        for name, column in columns.items()
    }
    lengths = {name: len(column) for name, column in values.items() if not isinstance(column, str)}
    if len(set(lengths.values())) != 1:
        raise InputError(f"requests of frame {frame}: columns of different lengths: {lengths}")
    count = next(iter(lengths.values()))

    def column(name: str) -> Iterable[Any]:
        value = values.get(name, "")
        return [value] * count if isinstance(value, str) else value

    for what, size, cycle, needed, address, phase in zip(
        *(column(name) for name in ("what", "bytes", "cycle", "needed", "address", "phase")),
        strict=True,
    ):
        waits = "" if needed == "" or needed is None or needed < 0 else needed
        yield (frame, what, size, cycle, waits, address, phase)

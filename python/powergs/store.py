"""What a sweep with functions has found, on disk: one line of JSON per design, whole or not there."""

from __future__ import annotations

import hashlib
import json
import os
import pickle
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from types import CellType, CodeType, FunctionType
from typing import Any

from ._powergs import Machine, Trace, __model_version__, __version__
from .errors import ConfigError, InputError

_FILE = "designs.jsonl"
_HEAD = {"kind": "powergs designs", "version": 2}
# A function that encloses itself has no bottom.
_DEEP = 8


class DesignStore:
    """Rows of designs by what decides them: machine, frames, model version, functions.

    For one process at a time: a line that another one is writing may look cut short.
    """

    def __init__(
        self,
        folder: str | os.PathLike[str],
        traces: Sequence[Trace],
        dram: str | None,
        fps: float,
        objectives: Mapping[str, Callable[..., Any]],
    ) -> None:
        self._path = Path(folder) / _FILE
        self._of = [
            __version__,
            __model_version__,
            [trace._key for trace in traces],
            dram,
            fps,
            {name: _code(function) for name, function in objectives.items()},
        ]
        self._rows: dict[str, dict[str, Any]] = {}
        text = self._read()
        lines = text.splitlines(keepends=True)
        # A line that a kill cut short is made again.
        if lines and not lines[-1].endswith("\n"):
            lines.pop()
        try:
            parsed = [json.loads(line) for line in lines]
            if parsed and parsed[0] != _HEAD:
                raise ValueError("another kind of file, or another version")
            self._rows = {str(line["key"]): dict(line["row"]) for line in parsed[1:]}
        except (ValueError, KeyError, TypeError) as error:
            raise InputError(
                f"{self._path}: no store of designs, or damaged ({error}); name another folder",
                str(self._path),
            ) from None
        if not lines:
            lines = [json.dumps(_HEAD) + "\n"]
        if "".join(lines) != text:
            fresh = self._path.with_suffix(".tmp")
            fresh.write_text("".join(lines), encoding="utf-8")
            os.replace(fresh, self._path)

    def _read(self) -> str:
        folder = self._path.parent
        if folder.exists() and not self._path.exists() and any(folder.iterdir()):
            raise ConfigError(
                f"store: {folder} has other files and no {_FILE}; name an empty or a new folder"
            )
        folder.mkdir(parents=True, exist_ok=True)
        if not self._path.exists():
            return ""
        try:
            return self._path.read_text(encoding="utf-8")
        except UnicodeDecodeError:
            raise InputError(f"{self._path}: no text", str(self._path)) from None

    def key(self, machine: Machine) -> str:
        """What decides a row."""
        text = json.dumps([self._of, machine._key], sort_keys=True)
        return hashlib.sha256(text.encode()).hexdigest()

    def get(self, key: str) -> dict[str, Any] | None:
        """What a design was found to have."""
        return self._rows.get(key)

    def put(self, key: str, row: Mapping[str, Any]) -> None:
        """Keeps a row, at once."""
        line = json.dumps({"key": key, "row": row}) + "\n"
        with open(self._path, "a", encoding="utf-8") as file:
            file.write(line)
        self._rows[key] = dict(row)


def _code(function: Callable[..., Any]) -> str:
    """What a function does, as far as it can be seen: its code, defaults and enclosed values."""
    return hashlib.sha256(repr(_seen(function)).encode()).hexdigest()


def _seen(value: Any, depth: int = 0) -> Any:
    """A value without what differs between two runs: files, lines, addresses, order of sets."""
    if value is None or isinstance(value, (bool, int, float, complex, str, bytes)):
        return value
    if depth < _DEEP:
        if isinstance(value, (list, tuple)):
            return [_seen(item, depth + 1) for item in value]
        if isinstance(value, (set, frozenset)):
            return sorted(repr(_seen(item, depth + 1)) for item in value)
        if isinstance(value, CodeType):
            return [value.co_code.hex(), value.co_names, _seen(value.co_consts, depth + 1)]
        if isinstance(value, FunctionType):
            parts = [value.__code__, value.__defaults__, value.__kwdefaults__]
            parts += [_content(cell) for cell in value.__closure__ or ()]
            return [_seen(part, depth + 1) for part in parts]
    # Arrays, dictionaries and objects by their contents, as far as they can be pickled.
    try:
        return hashlib.sha256(pickle.dumps(value, 4)).hexdigest()
    except Exception:  # whatever an object of somebody's class does here
        return f"{type(value).__module__}.{type(value).__qualname__}"


def _content(cell: CellType) -> Any:
    try:
        return cell.cell_contents
    except ValueError:  # not filled yet
        return None

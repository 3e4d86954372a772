"""The program ``powergs-sim`` in a process of its own, and the folders that it writes."""

from __future__ import annotations

import difflib
import json
import keyword
import os
import shutil
import signal
import subprocess
import sys
import tempfile
from collections.abc import Iterable, Iterator, Mapping
from pathlib import Path
from typing import Any

from ._powergs import Table, _csv
from .errors import ConfigError, GoalMissed, InputError, InternalError

__all__ = ["Folder", "Outcome", "near", "python_name", "run"]


class Folder:
    """A folder that the program wrote: a report, a sweep, a run.

    >>> powergs.Folder("reports/units").tables["results"]                            # doctest: +SKIP
    """

    def __init__(self, path: str | os.PathLike[str]) -> None:
        self.path = Path(path)
        if not self.path.is_dir():
            raise FileNotFoundError(f"{self.path}: no such folder")

    @property
    def files(self) -> dict[str, Path]:
        """All files by their path in the folder."""
        found = (path for path in self.path.rglob("*") if path.is_file())
        return {path.relative_to(self.path).as_posix(): path for path in sorted(found)}

    @property
    def tables(self) -> Mapping[str, Table]:
        """The CSV files as tables, by name without the ending; each is read when asked for."""
        return _Tables(
            {name[:-4]: path for name, path in self.files.items() if name.endswith(".csv")}
        )

    @property
    def text(self) -> str:
        """The page of the report as Markdown or plain text; empty without one."""
        for name in ("summary.md", "summary.txt", "analysis/summary.md"):
            if (self.path / name).is_file():
                return (self.path / name).read_text(encoding="utf-8")
        return ""

    @property
    def page(self) -> Path | None:
        """The report for a browser."""
        pages = (self.path / name for name in ("report.html", "analysis/report.html"))
        return next((page for page in pages if page.is_file()), None)

    def save(self, path: str | os.PathLike[str]) -> Folder:
        """Copies the folder; raises ``FileExistsError`` where something is."""
        shutil.copytree(self.path, path)
        return Folder(path)

    def __fspath__(self) -> str:
        return os.fspath(self.path)

    def __repr__(self) -> str:
        return f"<Folder {self.path}: {', '.join(self.files)}>"

    def __str__(self) -> str:
        return self.text


class _Tables(Mapping[str, Table]):
    """Tables that are read when they are asked for."""

    def __init__(self, paths: dict[str, Path]) -> None:
        self._paths = paths

    def __getitem__(self, name: str) -> Table:
        if name not in self._paths:
            raise KeyError(f"no table {name!r}{near(name, self._paths)}")
        return _csv(self._paths[name])

    def __iter__(self) -> Iterator[str]:
        return iter(self._paths)

    def __len__(self) -> int:
        return len(self._paths)

    def __repr__(self) -> str:
        return f"<tables: {', '.join(self._paths)}>"


class Outcome:
    """What a command said and wrote."""

    def __init__(self, words: list[str], result: Any, notes: str, folder: Folder | None) -> None:
        #: The command as it would be typed.
        self.command = ["powergs-sim", *words]
        #: What it prints with ``--json``, as Python has it; ``None`` where it prints nothing.
        self.result = result
        #: Notes and warnings.
        self.notes = notes
        self._folder = folder
        self._kept: tempfile.TemporaryDirectory[str] | None = None

    @property
    def folder(self) -> Folder:
        """The folder that it wrote; raises ``ValueError`` for a command that writes none."""
        if self._folder is None:
            raise ValueError(f"{' '.join(self.command)}: it wrote no folder")
        return self._folder

    @property
    def text(self) -> str:
        """The page of its report; without a folder what it printed."""
        if self._folder is not None:
            return self._folder.text
        return self.result if isinstance(self.result, str) else json.dumps(self.result, indent=2)

    def __repr__(self) -> str:
        where = f" in {self._folder.path}" if self._folder is not None else ""
        return f"<Outcome of {' '.join(self.command)}{where}>"

    def __str__(self) -> str:
        return self.text


def near(name: str, names: Iterable[str]) -> str:
    """What was probably meant, as the end of a message."""
    found = difflib.get_close_matches(name, list(names), 1)
    return f"; did you mean {found[0]!r}?" if found else ""


def python_name(name: str) -> str:
    """A flag or a word of a command in Python."""
    name = name.replace("-", "_").lower()
    return f"{name}_" if keyword.iskeyword(name) else name


def _text(value: Any) -> str:
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, (str, int, float)):
        return str(value)
    if hasattr(value, "__index__"):  # whole numbers of NumPy
        return str(int(value))
    # A trace of this package is its file.
    path = getattr(value, "path", value)
    if path is None:
        raise ConfigError("the program reads files: extract the trace with a path")
    return str(os.fspath(path))


def _values(value: Any) -> list[str]:
    if isinstance(value, Mapping):
        return [f"{key}={_toml(item)}" for key, item in value.items()]
    if isinstance(value, (list, tuple, set, frozenset, range)):
        return [_text(item) for item in value]
    return [_text(value)]


def _toml(value: Any) -> str:
    if isinstance(value, (list, tuple)):
        return f"[{', '.join(map(_toml, value))}]"
    return _text(value)


def _words(command: dict[str, Any], bound: Mapping[str, Any]) -> list[str]:
    words = list(command["path"])
    places: list[str] = []
    for argument in command["arguments"]:
        value = bound.get(python_name(argument["name"]))
        if value is None or value is False:
            continue
        if not argument["is_flag"]:
            places += _values(value)
        elif value is True and argument["at_least"] == 0:
            words.append(f"--{argument['name']}")
        elif argument["at_least"] > 1:
            words += [f"--{argument['name']}", *_values(value)]
        else:
            values = _values(value)
            if len(values) > 1 and not argument["is_list"]:
                raise TypeError(f"{python_name(argument['name'])}: one value, not {len(values)}")
            words += [f"--{argument['name']}={one}" for one in values]
    # A file whose name begins with a dash is a file.
    return [*words, "--", *places] if places else words


def _raise(code: int, message: str, outcome: Outcome) -> None:
    text = message.strip()
    text = text.rpartition("error: ")[2] if "error: " in text else text
    # With progress the program has said it where that is shown.
    text = text or f"{' '.join(outcome.command)}: ended with {code}, as it says above"
    if code == 1:
        missed = GoalMissed(text)
        missed.outcome = outcome
        raise missed
    if code == 2:
        raise ConfigError(text)
    if code == 3:
        raise InputError(text)
    if code == 130:
        raise KeyboardInterrupt
    raise InternalError(text)


def run(command: dict[str, Any], progress: bool, bound: dict[str, Any]) -> Outcome:
    """Runs a command with arguments by their name in Python."""
    kept = None
    folders = [a for a in command["arguments"] if a["name"] == "out" and a["is_folder"]]
    if folders and bound.get("out") is None:
        kept = tempfile.TemporaryDirectory(prefix="powergs-")
        bound = {**bound, "out": os.path.join(kept.name, "-".join(command["path"]))}
    words = _words(command, bound)
    at = len(command["path"])
    call = [sys.executable, "-m", "powergs", *words[:at], "--json", *words[at:]]
    with subprocess.Popen(
        call, stdout=subprocess.PIPE, stderr=None if progress else subprocess.PIPE, text=True
    ) as process:
        try:
            printed, notes = process.communicate()
        except KeyboardInterrupt:
            # A notebook's kernel is told alone; a terminal tells both, and twice would end it.
            if process.poll() is None and not sys.stdin.isatty():
                process.send_signal(signal.SIGINT)
            process.wait()
            raise
    notes = notes or ""
    try:
        result = json.loads(printed) if printed.strip() else None
    except ValueError:
        result = printed
    path = Path(bound["out"]) if folders else None
    folder = Folder(path) if path is not None and path.is_dir() else None
    outcome = Outcome(words, result, notes, folder)
    outcome._kept = kept
    if process.returncode != 0:
        _raise(process.returncode, notes, outcome)
    return outcome

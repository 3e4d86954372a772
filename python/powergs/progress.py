"""Progress of long calls: a bar of tqdm where it is installed, else a plain one."""

from __future__ import annotations

import sys
import time
from typing import Any, Callable, Protocol


class Meter(Protocol):
    """What a long call tells how far it is."""

    def show(self, done: int, total: int) -> None: ...

    def close(self) -> None: ...


class _Call:
    """Calls a function with ``(done, total)``."""

    def __init__(self, function: Callable[[int, int], object]) -> None:
        self._function = function

    def show(self, done: int, total: int) -> None:
        self._function(done, total)

    def close(self) -> None:
        pass


class _Tqdm:
    """Moves a bar of tqdm, or anything with ``total``, ``n`` and ``refresh``."""

    def __init__(self, bar: Any, owned: bool) -> None:
        self._bar, self._owned = bar, owned

    def show(self, done: int, total: int) -> None:
        self._bar.total = total
        step = done - self._bar.n
        if step < 0:
            self._bar.reset(total)
            step = done
        self._bar.update(step)

    def close(self) -> None:
        if self._owned:
            self._bar.close()


class _Plain:
    """A line on standard error, where that is a terminal, after a second."""

    WIDTH = 24

    def __init__(self, unit: str) -> None:
        self._unit, self._started, self._shown = unit, time.monotonic(), False

    def show(self, done: int, total: int) -> None:
        if not sys.stderr.isatty() or time.monotonic() - self._started < 1:
            return
        full = self.WIDTH * done // max(total, 1)
        bar = "#" * full + "." * (self.WIDTH - full)
        sys.stderr.write(f"\r{bar} {done}/{total} {self._unit}")
        sys.stderr.flush()
        self._shown = True

    def close(self) -> None:
        if self._shown:
            sys.stderr.write("\r\033[K")
            sys.stderr.flush()


def meter(progress: Any, unit: str) -> Meter | None:
    """The meter of an argument ``progress``: ``True``, a function, or a bar."""
    if progress is None or progress is False:
        return None
    if progress is True:
        try:
            from tqdm.auto import tqdm
        except ImportError:
            return _Plain(unit)
        return _Tqdm(tqdm(unit=" " + unit, delay=1, leave=False), owned=True)
    if hasattr(progress, "update") and hasattr(progress, "n"):
        return _Tqdm(progress, owned=False)
    if callable(progress):
        return _Call(progress)
    raise TypeError("progress: True, a function of (done, total), or a bar of tqdm")

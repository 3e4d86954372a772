"""Sweeps over machines: files, dictionaries of axes, lists of machines, and ask/tell."""

from __future__ import annotations

import math
import os
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, Any, TypeAlias

from ._powergs import Front, Machine, Report, SweepResult, Table, Trace
from ._powergs import _front, _sweep_axes, _sweep_file, _table
from .errors import ConfigError
from .progress import meter
from .store import DesignStore

if TYPE_CHECKING:
    from ._powergs import Progress

Value: TypeAlias = "int | float | str | bool"
Traces: TypeAlias = "Trace | str | os.PathLike[str] | Sequence[Trace | str | os.PathLike[str]]"
Objective: TypeAlias = Callable[[Report], "float | None"]

#: What a table of replayed machines has of each report, with unit and definition.
_METRICS = {
    "frame_time_ms": ("ms", "Mean time of a frame."),
    "throughput_fps": ("1/s", "Frames per second when frames run back to back."),
    "energy_pj": ("pJ", "Mean energy of a frame."),
    "power_w": ("W", "Power at the display rate."),
    "area_mm2": ("mm²", "Area of the chip."),
}


def sweep(
    space: str | os.PathLike[str] | Mapping[str, Iterable[Value]] | Iterable[Machine],
    traces: Traces = (),
    *,
    base: Machine | str = "gscore",
    constraints: Sequence[str] = (),
    minimize: Sequence[str] = (),
    maximize: Sequence[str] = (),
    objectives: Mapping[str, Objective] | None = None,
    sampling: Mapping[str, Value] | None = None,
    keys: Mapping[str, Value] | None = None,
    points: int | None = None,
    fps: float = 60.0,
    dram: str | None = None,
    store: str | os.PathLike[str] | None = None,
    memory: int | str | None = None,
    progress: Progress = None,
) -> SweepResult | Designs:
    """Simulates every design of a space on every trace.

    Parameters
    ----------
    space
        A sweep file (a name of ``names("sweep")`` or a path); a dictionary of keys with their
        values, the last of which counts fastest; or machines, from a list or a generator.
    traces
        A trace or several; for a sweep file paths or patterns, in place of its own.
    base
        The machine that a dictionary varies.
    constraints
        Expressions that every design of a dictionary fulfils: ``"vru.cores * ccu.units <= 32"``.
    minimize, maximize
        Columns that ``pareto()`` makes small and large unless it is told others.
    objectives
        Functions of a ``Report``, each a column of the table and made small by ``pareto()``; with
        several traces the mean of their values. Every design is then replayed by itself, which
        takes longer than a sweep without functions.
    sampling
        ``{"method": "lhs", "points": 64, "seed": 1}``, as in a sweep file.
    keys
        Keys of the base machine of a sweep file to be changed.
    points
        At most so many designs of a sweep file.
    fps
        Display rate, frames per second; a sweep file has its own.
    dram
        Model of the DRAM; without one that of the machine, whatever the space is.
        ``"calibrated"`` in place of ``"banked"`` is many times faster and within some percent,
        which may bend trends: confirm what you choose.
    store
        Folder where results are kept: a sweep that was interrupted goes on there. With functions
        and machines it keeps a row per design, of the same machine, frames and functions; a
        function is told by its code and what it encloses, not by the globals that it uses. One
        process at a time.
    memory
        What binned frames may take, bytes or a text such as ``"2 GiB"``.
    progress
        As for ``Trace.replay``; counts frames on machines.

    Returns a ``SweepResult``, or ``Designs`` for functions and machines. Both have ``table``,
    ``designs`` and ``pareto(...)``. Ctrl-C raises at once; what is done is in the store.
    """
    if isinstance(space, (str, os.PathLike)):
        if objectives or constraints or minimize or maximize or sampling:
            raise ConfigError(
                "a sweep file has constraints, objectives and sampling itself; functions as "
                "objectives need a dictionary of keys, or machines"
            )
        paths = _paths(traces)
        return _sweep_file(
            space, paths, keys=dict(keys or {}), points=points, dram=dram, store=store,
            memory=memory, progress=progress,
        )  # fmt: skip
    if keys or points is not None:
        raise ConfigError("keys and points are for sweep files: change the base, or use sampling")
    if isinstance(space, Mapping) and not space:
        raise ConfigError("a space has at least one key")
    opened = _opened(traces)
    if isinstance(space, Mapping) and not objectives:
        machine = base if isinstance(base, Machine) else Machine(base)
        return _sweep_axes(
            machine, dict(space), opened, constraints=list(constraints), minimize=list(minimize),
            maximize=list(maximize), sampling=dict(sampling) if sampling else None, fps=fps,
            dram=dram, store=store, memory=memory, progress=progress,
        )  # fmt: skip
    if constraints or minimize or maximize or sampling:
        raise ConfigError(
            "constraints, minimize, maximize and sampling are for dictionaries without functions "
            "as objectives"
        )
    asked = Space(space, base) if isinstance(space, Mapping) else None
    found = Designs(objectives or {})
    kept = None
    if store is not None:
        kept = DesignStore(store, opened, dram, fps, objectives or {})
    candidates: Iterable[Candidate]
    if asked is not None:
        candidates = asked
    else:
        candidates = (Candidate(i, {}, m) for i, m in enumerate(_machines(space)))
    total = len(asked) if asked is not None else 0
    bar = meter(progress, "designs")
    try:
        for done, candidate in enumerate(candidates, start=1):
            key = kept.key(candidate.machine) if kept is not None else ""
            values = kept.get(key) if kept is not None else None
            if values is None:
                replays = (trace.replay(candidate.machine, dram=dram, fps=fps) for trace in opened)
                values = found.measure(list(replays))
                if kept is not None:
                    kept.put(key, values)
            found.add(candidate, values)
            if bar is not None:
                bar.show(done, max(total, done))
    finally:
        if bar is not None:
            bar.close()
    return found


def _machines(space: object) -> Iterator[Machine]:
    if not isinstance(space, Iterable):
        raise TypeError("a space is a sweep file, a dictionary of keys, or machines")
    for machine in space:
        if not isinstance(machine, Machine):
            raise TypeError(f"machines are powergs.Machine, not {type(machine).__name__}")
        yield machine


def _listed(traces: Traces) -> list[Any]:
    if isinstance(traces, (Trace, str, os.PathLike)):
        return [traces]
    return list(traces)


def _paths(traces: Traces) -> list[str]:
    paths = []
    for trace in _listed(traces):
        path = trace.path if isinstance(trace, Trace) else os.fspath(trace)
        if path is None:
            raise ConfigError("a sweep file needs traces in files: extract with a path")
        paths.append(path)
    return paths


def _opened(traces: Traces) -> list[Trace]:
    opened = [t if isinstance(t, Trace) else Trace.open(t) for t in _listed(traces)]
    names = [trace.name for trace in opened]
    if not opened or len(set(names)) < len(names):
        raise ConfigError("traces: at least one, each with a name of its own")
    return opened


class Candidate:
    """A design that is to be tried: ``machine``, and the ``settings`` that make it."""

    def __init__(self, number: int, settings: dict[str, Value], machine: Machine) -> None:
        #: Its number in the space.
        self.number = number
        #: Its keys.
        self.settings = settings
        #: The machine.
        self.machine = machine

    def __repr__(self) -> str:
        settings = ", ".join(f"{key}={value}" for key, value in self.settings.items())
        return f"<Candidate #{self.number}: {settings or self.machine.name}>"


class Space:
    """Every combination of the values of some keys, tried by whoever asks.

    An optimiser chooses (``ask`` with settings, or with a position from 0 to 1 on each axis) or the
    space does (``ask()``: the next one in order); ``tell`` keeps what came out.

    >>> space = powergs.Space({"vru.cores": [2, 4, 8], "ccu.units": [2, 4]})
    >>> candidate = space.ask({"vru.cores": 8, "ccu.units": 2})
    >>> space.tell(candidate, {"frame_time_ms": 0.25})
    """

    def __init__(
        self, axes: Mapping[str, Iterable[Value]], base: Machine | str = "gscore"
    ) -> None:
        #: The keys and their values.
        self.axes = {key: list(values) for key, values in axes.items()}
        if not self.axes or not all(self.axes.values()):
            raise ConfigError("a space has at least one key, and each key a value")
        #: The machine that the keys are of.
        self.base = base if isinstance(base, Machine) else Machine(base)
        self._next = 0
        self._told: dict[int, tuple[dict[str, Value], dict[str, float]]] = {}
        # A key that is misspelt, or a value that it does not take, is found now.
        for key, values in self.axes.items():
            for value in values:
                self.base.with_({key: value})

    def __len__(self) -> int:
        return math.prod(map(len, self.axes.values()))

    def __iter__(self) -> Iterator[Candidate]:
        for number in range(len(self)):
            yield self._candidate(number)

    def _candidate(self, number: int) -> Candidate:
        settings: dict[str, Value] = {}
        rest = number
        for key, values in reversed(self.axes.items()):
            rest, digit = divmod(rest, len(values))
            settings[key] = values[digit]
        settings = {key: settings[key] for key in self.axes}
        return Candidate(number, settings, self.base.with_(settings))

    def ask(self, at: Mapping[str, Value] | Sequence[float] | None = None) -> Candidate:
        """The design at some settings, at positions from 0 to 1, or the next one.

        Raises ``ConfigError`` for settings that are not in the space, ``StopIteration`` when
        ``ask()`` has given all designs.
        """
        if at is None:
            if self._next >= len(self):
                raise StopIteration("every design of the space was asked for")
            self._next += 1
            return self._candidate(self._next - 1)
        number = 0
        if isinstance(at, Mapping):
            if set(at) != set(self.axes):
                raise ConfigError(f"settings: one value for each of {', '.join(self.axes)}")
            digits = []
            for key, values in self.axes.items():
                if at[key] not in values:
                    raise ConfigError(f"{key}: {at[key]!r} is not one of {values}")
                digits.append(values.index(at[key]))
        else:
            positions = [float(x) for x in at]
            if len(positions) != len(self.axes) or not all(0 <= x <= 1 for x in positions):
                raise ConfigError(f"{len(self.axes)} positions from 0 to 1, one for each key")
            sizes = map(len, self.axes.values())
            digits = [min(int(x * n), n - 1) for x, n in zip(positions, sizes)]
        for digit, values in zip(digits, self.axes.values()):
            number = number * len(values) + digit
        return self._candidate(number)

    def tell(self, candidate: Candidate, values: Mapping[str, float | None] | float) -> None:
        """Keeps the objectives of a design; ``None`` and NaN are kept as not a number."""
        named = values if isinstance(values, Mapping) else {"value": values}
        plain = {key: math.nan if x is None else float(x) for key, x in named.items()}
        told = next(iter(self._told.values()), None)
        if not plain or (told is not None and set(told[1]) != set(plain)):
            raise ConfigError("every design is told the same objectives, at least one")
        self._told[candidate.number] = (candidate.settings, plain)

    @property
    def table(self) -> Table:
        """What was told: a row per design, in the order of the space."""
        rows = [(n, *self._told[n]) for n in sorted(self._told)]
        columns: dict[str, list[Any]] = {"point": [n for n, _, _ in rows]}
        for key in self.axes:
            columns[key] = [settings[key] for _, settings, _ in rows]
        for name in rows[0][2] if rows else ():
            columns[name] = [values[name] for _, _, values in rows]
        return _columns(columns, {})

    def pareto(
        self, *, minimize: Sequence[str] = (), maximize: Sequence[str] = ()
    ) -> Table:
        """The designs that no other beats; without columns all that was told is made small."""
        told = next(iter(self._told.values()), None)
        if told is None:
            raise ConfigError("nothing was told yet")
        return _best(self.table, minimize or ([] if maximize else list(told[1])), maximize)


class Designs:
    """Machines that were replayed one by one, with functions as objectives."""

    def __init__(self, objectives: Mapping[str, Objective]) -> None:
        self._objectives = dict(objectives)
        self._rows: list[dict[str, Any]] = []
        #: The machines, in the order of the table.
        self.machines: list[Machine] = []

    def measure(self, reports: Sequence[Report]) -> dict[str, float | None]:
        """The means of a machine's reports, one per trace, and of the functions of them."""
        values = {name: _mean([getattr(r, name) for r in reports]) for name in _METRICS}
        for name, function in self._objectives.items():
            values[name] = _mean([function(report) for report in reports])
        return values

    def add(self, candidate: Candidate, values: Mapping[str, float | None]) -> None:
        """Adds a machine with what was measured."""
        row: dict[str, Any] = {"point": candidate.number, "machine": candidate.machine.name}
        self._rows.append({**row, **candidate.settings, **values})
        self.machines.append(candidate.machine)

    @property
    def table(self) -> Table:
        """A row per machine: settings, means over the traces, objectives."""
        names = list(self._rows[0]) if self._rows else ["point"]
        return _columns({name: [row[name] for row in self._rows] for name in names}, _METRICS)

    @property
    def designs(self) -> Table:
        """The same as ``table``."""
        return self.table

    def pareto(
        self, *, minimize: Sequence[str] = (), maximize: Sequence[str] = ()
    ) -> Table:
        """The rows that no other beats; without columns all objectives are made small."""
        if not minimize and not maximize:
            minimize = list(self._objectives) or ["frame_time_ms", "energy_pj", "area_mm2"]
        return _best(self.table, minimize, maximize)

    def __len__(self) -> int:
        return len(self._rows)

    def __repr__(self) -> str:
        return f"<Designs: {len(self)}>"

    def _repr_html_(self) -> str:
        return self.table._repr_html_()


def _mean(values: Sequence[float | None]) -> float | None:
    known = [float(value) for value in values if value is not None]
    return sum(known) / len(values) if len(known) == len(values) and known else None


def _columns(columns: dict[str, list[Any]], known: Mapping[str, tuple[str, str]]) -> Table:
    kinds, values = [], {}
    for name, cells in columns.items():
        filled = [cell for cell in cells if cell is not None]
        if filled and all(isinstance(cell, bool) for cell in filled):
            kind = "flag"
        elif filled and all(isinstance(cell, int) for cell in filled):
            kind = "integer"
        elif all(isinstance(cell, (int, float)) for cell in filled):
            kind, cells = "real", [None if c is None else float(c) for c in cells]
        else:
            kind, cells = "text", [None if c is None else str(c) for c in cells]
        kinds.append(kind)
        values[name] = cells
    units = {name: unit for name, (unit, _) in known.items()}
    definitions = {name: text for name, (_, text) in known.items()}
    return _table(list(columns), kinds, units, definitions, values)


def _best(table: Table, minimize: Sequence[str], maximize: Sequence[str]) -> Table:
    costs = [table[name] for name in minimize]
    costs += [[None if x is None else -x for x in table[name]] for name in maximize]
    rows = [[math.nan if x is None else float(x) for x in row] for row in zip(*costs)]
    kept = sorted(_front(rows), key=lambda i: rows[i])
    columns = {name: [cells[i] for i in kept] for name, cells in table.to_dict().items()}
    known = {name: (table.units[name], table.definitions[name]) for name in table.columns}
    return _columns(columns, known)


__all__ = ["Candidate", "Designs", "Front", "Space", "SweepResult", "sweep"]

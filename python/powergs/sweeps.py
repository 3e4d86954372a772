"""Sweeps over machines: files, dictionaries of axes, lists of machines, and ask/tell."""

from __future__ import annotations

import math
import os
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Any, TypeAlias

from ._powergs import Front, Machine, Report, SweepResult, Table, Trace
from ._powergs import _front, _gathered, _Space, _sweep_axes, _sweep_file, _table
from .errors import ConfigError, InvalidDesign
from .progress import meter
from .store import DesignStore

if TYPE_CHECKING:
    from ._powergs import Progress

Value: TypeAlias = "int | float | str | bool"
Traces: TypeAlias = "Trace | str | os.PathLike[str] | Sequence[Trace | str | os.PathLike[str]]"
Objective: TypeAlias = Callable[[Report], "float | None"]

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
) -> SweepResult:
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
        Functions of a ``Report``, each a column of the table and made small by ``pareto()``. Every
        design of whatever space is then replayed by itself, which takes longer than a sweep
        without functions.
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

    Returns a ``SweepResult``. The base machine is its first row; of a list of machines that is the
    first of them, and columns say what differs. A design that is no machine is counted in
    ``tally``, with its reason in ``table``. Ctrl-C raises at once; what is done is in the store.
    """
    is_file = isinstance(space, (str, os.PathLike))
    if is_file and (constraints or minimize or maximize or sampling):
        raise ConfigError("a sweep file has constraints, objectives and sampling itself")
    if not is_file and (keys or points is not None):
        raise ConfigError("keys and points are for sweep files: change the base, or use sampling")
    if isinstance(space, Mapping) and not space:
        raise ConfigError("a space has at least one key")
    if isinstance(space, (str, os.PathLike)) and not objectives:
        return _sweep_file(
            space, _paths(traces), keys=dict(keys or {}), points=points, dram=dram, store=store,
            memory=memory, progress=progress,
        )  # fmt: skip
    opened = _opened(traces)
    if isinstance(space, Mapping) and not objectives:
        machine = base if isinstance(base, Machine) else Machine(base)
        return _sweep_axes(
            machine, dict(space), opened, constraints=list(constraints), minimize=list(minimize),
            maximize=list(maximize), sampling=dict(sampling) if sampling else None, fps=fps,
            dram=dram, store=store, memory=memory, progress=progress,
        )  # fmt: skip
    if minimize or maximize:
        raise ConfigError("minimize and maximize: tell pareto() of functions as objectives")
    if isinstance(space, (str, os.PathLike, Mapping)):
        asked = Space(space, base, constraints=constraints, sampling=sampling, keys=keys)
        machines, total = asked._designs(points), asked._count(points)
        if is_file:
            tables = asked._space.energy_tables()
            if len(tables) > 1:
                raise ConfigError(
                    f"functions see one energy table, and the sweep file has {', '.join(tables)}: "
                    "leave one, or sweep without functions"
                )
            fps = asked._space.display_fps()
    elif constraints or sampling:
        raise ConfigError("constraints and sampling are for dictionaries of keys")
    else:
        machines, total = _listed_machines(space), 0
    functions = dict(objectives or {})
    kept = DesignStore(store, opened, dram, fps, functions) if store is not None else None
    bar = meter(progress, "designs")
    rows: list[_Tried] = []
    try:
        for done, tried in enumerate(machines, start=1):
            if tried.machine is not None:
                key = kept.key(tried.machine) if kept is not None else ""
                row = kept.get(key) if kept is not None else None
                if row is None:
                    row = _replayed(tried.machine, opened, dram, fps, functions)
                    if kept is not None:
                        kept.put(key, row)
                tried = replace(tried, outcomes=row["outcomes"], values=row["values"])
            rows.append(tried)
            if bar is not None:
                bar.show(done, max(total, done))
    finally:
        if bar is not None:
            bar.close()
    if not isinstance(space, (str, os.PathLike, Mapping)):
        # The first of a list is what the others are compared with, and one of them.
        rows = [replace(row, point=None) for row in rows[:1]] + rows
    return _gathered(rows, [trace.name for trace in opened], list(functions), fps)


def _replayed(
    machine: Machine,
    traces: Sequence[Trace],
    dram: str | None,
    fps: float,
    functions: Mapping[str, Objective],
) -> dict[str, Any]:
    """What a sweep keeps of a machine: an outcome per trace, and per function a value per trace."""
    reports = [trace.replay(machine, dram=dram, fps=fps) for trace in traces]
    values: list[list[float | None]] = []
    for function in functions.values():
        found = [function(report) for report in reports]
        values.append([None if x is None or math.isnan(x) else float(x) for x in found])
    return {"outcomes": [report._outcome() for report in reports], "values": values}


@dataclass(frozen=True)
class _Tried:
    """A design of a space: its number (the base has none), its settings, the machine or why there is
    none, and what came out."""

    point: int | None
    settings: dict[str, Value]
    machine: Machine | None
    reason: str = ""
    outcomes: list[str] = field(default_factory=list)
    values: list[list[float | None]] = field(default_factory=list)


def _listed_machines(space: object) -> Iterator[_Tried]:
    if not isinstance(space, Iterable):
        raise TypeError("a space is a sweep file, a dictionary of keys, or machines")
    for point, machine in enumerate(space):
        if not isinstance(machine, Machine):
            raise TypeError(f"machines are powergs.Machine, not {type(machine).__name__}")
        yield _Tried(point, {}, machine)


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
    """Every design of a space, tried by the caller.

    The space is what ``sweep`` takes: a dictionary of keys with their values, with ``constraints``
    and ``sampling``, or a sweep file with ``keys`` to change. An optimiser chooses (``ask`` with
    settings, or with a position from 0 to 1 on each axis) or the space does (``ask()``: the next one
    in order); ``tell`` keeps what came out.

    >>> space = powergs.Space({"vru.cores": [2, 4, 8], "ccu.units": [2, 4]})
    >>> candidate = space.ask({"vru.cores": 8, "ccu.units": 2})
    >>> space.tell(candidate, {"frame_time_ms": 0.25})

    A point that is no machine, or that a constraint leaves out, raises ``InvalidDesign``.
    """

    def __init__(
        self,
        axes: str | os.PathLike[str] | Mapping[str, Iterable[Value]],
        base: Machine | str = "gscore",
        *,
        constraints: Sequence[str] = (),
        sampling: Mapping[str, Value] | None = None,
        keys: Mapping[str, Value] | None = None,
    ) -> None:
        if isinstance(axes, Mapping):
            named = {key: list(values) for key, values in axes.items()}
            if not named or not all(named.values()):
                raise ConfigError("a space has at least one key, and each key a value")
            machine = base if isinstance(base, Machine) else Machine(base)
            given = dict(sampling) if sampling else None
            self._space = _Space.of_axes(machine, named, list(constraints), given)
        else:
            self._space = _Space.of_file(axes, dict(keys) if keys else None)
        #: The axes and their values.
        self.axes: dict[str, list[Value]] = dict(self._space.axes())
        if isinstance(axes, Mapping):
            # As they were given: what is asked for is looked up among them.
            self.axes = named
        #: The machine that designs differ from.
        self.base = self._space.base()
        self._points: list[int] | None = None
        self._next = 0
        self._told: dict[int, tuple[dict[str, Value], dict[str, float]]] = {}

    def __len__(self) -> int:
        return len(self._selected())

    def __iter__(self) -> Iterator[Candidate]:
        for point in self._selected():
            settings, machine, _ = self._space.candidate(point)
            if settings is not None and machine is not None:
                yield Candidate(point, settings, machine)

    def _selected(self) -> list[int]:
        if self._points is None:
            self._points = self._space.points_of_sweep()
        return self._points

    def _count(self, points: int | None) -> int:
        return 1 + len(self._selected()[:points])

    def _designs(self, points: int | None) -> Iterator[_Tried]:
        own: dict[str, Value] = {}
        for key in self.axes:
            try:
                own[key] = self.base[key]
            except KeyError:  # a name for several keys
                pass
        yield _Tried(None, own, self.base)
        for point in self._selected()[:points]:
            settings, machine, reason = self._space.candidate(point)
            if settings is not None:
                yield _Tried(point, settings, machine, reason)

    def _candidate(self, point: int) -> Candidate:
        settings, machine, reason = self._space.candidate(point)
        if settings is None or machine is None:
            raise InvalidDesign(f"design #{point}: {reason}")
        return Candidate(point, settings, machine)

    def ask(self, at: Mapping[str, Any] | Sequence[float] | None = None) -> Candidate:
        """The design at some settings, at positions from 0 to 1, or the next one.

        Raises ``ConfigError`` for settings that are not in the space, ``InvalidDesign`` for those
        that make no machine, ``StopIteration`` when ``ask()`` has given all designs.
        """
        if at is None:
            if self._next >= len(self):
                raise StopIteration("every design of the space was asked for")
            self._next += 1
            return self._candidate(self._selected()[self._next - 1])
        digits: list[int] = []
        if isinstance(at, Mapping):
            if set(at) != set(self.axes):
                raise ConfigError(f"settings: one value for each of {', '.join(self.axes)}")
            for key, values in self.axes.items():
                if at[key] not in values:
                    raise ConfigError(f"{key}: {at[key]!r} is not one of its values, {values}")
                digits.append(values.index(at[key]))
        else:
            positions = list(at)
            if len(positions) != len(self.axes) or not all(0 <= x <= 1 for x in positions):
                raise ConfigError(f"positions: {len(self.axes)} numbers from 0 to 1, one per key")
            sizes = map(len, self.axes.values())
            digits = [min(int(x * n), n - 1) for x, n in zip(positions, sizes)]
        return self._candidate(self._space.point(digits))

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


__all__ = ["Candidate", "Front", "Space", "SweepResult", "sweep"]

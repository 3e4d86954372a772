"""Sweeps: the program's table row by row, fronts, functions as objectives, ask and tell."""

from __future__ import annotations

import csv
import math

import numpy as np
import pytest

import powergs

AXES = {"vru.cores": [2, 4, 8], "ccu.units": [2, 4]}

FILE = """
question = "Which units?"
base = "gscore"

[[axes]]
key = "vru.cores"
values = [2, 4, 8]

[[axes]]
key = "ccu.units"
values = [2, 4]
"""


@pytest.fixture(scope="module")
def swept(demo) -> powergs.SweepResult:
    return powergs.sweep(AXES, powergs.Trace.open(demo))


def as_written(value: object) -> str:
    """A cell as CSV has it."""
    if value is None:
        return ""
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, float):
        return f"{value:.17g}"
    return str(value)


def same_cells(ours: list[object], its: list[str]) -> bool:
    def same(value: object, text: str) -> bool:
        if isinstance(value, float):
            return text != "" and float(text) == value
        return as_written(value) == text

    return len(ours) == len(its) and all(map(same, ours, its))


@pytest.mark.parametrize("by", ["file", "dictionary"])
def test_rows_are_those_of_results_csv(by, demo, run, tmp_path) -> None:
    file = tmp_path / "units.toml"
    file.write_text(FILE)
    run("sweep", file, "--traces", demo, "--out", tmp_path / "its", "--quiet")
    if by == "file":
        result = powergs.sweep(file, demo)
    else:
        result = powergs.sweep(AXES, powergs.Trace.open(demo))
    table = result.table
    with open(tmp_path / "its" / "results.csv", newline="") as lines:
        rows = list(csv.DictReader(lines))
    assert list(rows[0]) == table.columns and len(rows) == len(table) == 7 * 3
    skipped = set()
    if by == "dictionary":
        # The identity of a design holds the display, which this machine has and the file's has not.
        skipped = {"id"} | {name for name in table.columns if "display" in name}
    for name in set(table.columns) - skipped:
        assert same_cells(table[name], [row[name] for row in rows]), name


def test_columns_know_units_and_definitions(swept) -> None:
    table = swept.table
    assert table.units["frame_time_ms.mean"] == "ms"
    assert all(table.definitions[name] for name in table.columns)
    assert swept.designs["scope"] == ["mean"] * 7
    assert swept.tally == {"ok": 6, "invalid": 0, "failed": 0, "missing": 0}


def test_pareto_is_the_front(swept) -> None:
    front = swept.pareto(minimize=["frame_time_ms.mean", "area_mm2"])
    rows = swept.designs
    points = list(zip(rows["point"], rows["frame_time_ms.mean"], rows["area_mm2"]))[1:]
    best = {
        p
        for p, t, a in points
        if not any(t2 <= t and a2 <= a and (t2, a2) != (t, a) for _, t2, a2 in points)
    }
    assert set(front.table["point"]) <= best and len(front) >= 2
    assert front.table["is_knee"].count(True) == 1
    assert front.knee in front.table["point"]
    assert front.charts() and all(c.svg.startswith("<svg") for c in front.charts().values())
    assert "<table" in front._repr_html_()


def test_a_condition_that_nothing_meets_is_a_goal_missed(swept) -> None:
    with pytest.raises(powergs.GoalMissed):
        swept.pareto(where="area_mm2 < 0.001")
    small = swept.pareto(where="area_mm2.core < 4")
    assert max(small.table["area_mm2.core"]) < 4
    for wrong in [{"where": "area_mm2 <"}, {"minimize": ["area"]}, {"scope": "nosuch"}]:
        with pytest.raises(powergs.ConfigError):
            swept.pareto(**wrong)


def test_a_store_continues(demo, tmp_path) -> None:
    trace = powergs.Trace.open(demo)
    seen: list[tuple[int, int]] = []

    def stop(done: int, total: int) -> None:
        seen.append((done, total))
        if done:
            raise KeyboardInterrupt

    store = tmp_path / "store"
    try:
        powergs.sweep(AXES, trace, store=store, progress=stop)
    except KeyboardInterrupt:
        pass
    result = powergs.sweep(AXES, trace, store=store)
    assert result.table.to_dict() == powergs.sweep(AXES, trace).table.to_dict()
    known: list[tuple[int, int]] = []
    powergs.sweep(AXES, trace, store=store, progress=lambda *at: known.append(at))
    assert all(done == total for done, total in known)
    with pytest.raises((powergs.PowergsError, OSError)):
        powergs.sweep({"vru.cores": [1, 2]}, trace, store=store)


def test_several_traces(demo, tmp_path) -> None:
    scene, cameras = powergs.synth("lego", points=2000)
    other = scene.extract(cameras.select(every=64, size=(64, 48)))
    table = powergs.sweep({"vru.cores": [2, 4]}, [demo, other]).table
    assert table["trace"][:3] == ["demo", "lego", ""] and len(table) == 3 * 4
    times = table["frame_time_ms.mean"]
    assert times[2] == pytest.approx((times[0] + times[1]) / 2)


def test_functions_as_objectives(demo) -> None:
    trace = powergs.Trace.open(demo)
    edp = {"edp": lambda r: r.energy_pj * 1e-12 * r.frame_time_ms * 1e-3}
    found = powergs.sweep(AXES, trace, objectives=edp)
    assert len(found) == 7 and found.tally["ok"] == 6
    for row in found:
        machine = found.machine(row["point"])
        assert machine["vru.cores"] == row["vru.cores"]
        report = trace.replay(machine)
        assert row["edp"] == report.energy_pj * 1e-12 * report.frame_time_ms * 1e-3
        assert row["frame_time_ms.mean"] == pytest.approx(report.frame_time_ms, rel=1e-14)
    # The columns of a sweep without functions, with the same numbers, and the function.
    plain = powergs.sweep(AXES, trace)
    assert found.table.columns == [*plain.table.columns, "edp"]
    for name in set(plain.table.columns) - {"id"}:
        assert found.table[name] == plain.table[name], name
    best = found.pareto()
    assert best.table["edp"] == [min(found.designs["edp"])]
    front = found.pareto(minimize=["area_mm2"], maximize=["fps.mean"], where="edp < 1")
    assert front.table["area_mm2"] == sorted(front.table["area_mm2"])
    assert "edp" in found._repr_html_() and front.charts()


def test_a_store_of_functions_continues(demo, trace, gscore, tmp_path) -> None:
    class Counted:
        calls = 0

        def __call__(self, report: powergs.Report) -> float:
            self.calls += 1
            return report.energy_pj

    def value(scale: float):
        return lambda report: scale * report.energy_pj

    def machines():
        return (gscore.with_({"vru.cores": n}) for n in (2, 4, 8))

    def interrupted(done: int, total: int) -> None:
        if done == 2:
            raise KeyboardInterrupt

    store = tmp_path / "designs"
    with pytest.raises(KeyboardInterrupt):
        powergs.sweep(
            machines(), trace, objectives={"e": value(2.0)}, store=store, progress=interrupted
        )
    file = store / "designs.jsonl"
    whole = file.read_text().splitlines(keepends=True)
    assert len(whole) == 1 + 2
    assert all(line.endswith("\n") for line in whole)
    file.write_text("".join(whole[:2]) + whole[2][: len(whole[2]) // 2])
    fresh = powergs.sweep(machines(), trace, objectives={"e": value(2.0)})
    again = powergs.sweep(machines(), trace, objectives={"e": value(2.0)}, store=store)
    assert again.table.to_dict() == fresh.table.to_dict()
    assert len(file.read_text().splitlines()) == 1 + 3
    powergs.sweep(machines(), trace, objectives={"e": value(2.0)}, store=store)
    powergs.sweep(AXES, trace, objectives={"e": value(2.0)}, store=store)
    # Half of those have the CCUs of the base: they are known already, and so is the base.
    assert len(file.read_text().splitlines()) == 1 + 3 + 3
    # Another function, other frames, another rate: not what was kept.
    other = powergs.sweep(machines(), trace, objectives={"e": value(3.0)}, store=store)
    assert other.table["e"] == [1.5 * e for e in fresh.table["e"]]
    part = powergs.sweep(machines(), trace[:1], objectives={"e": value(2.0)}, store=store)
    assert part.table["e"] != fresh.table["e"]
    slower = powergs.sweep(machines(), trace, store=store, fps=30.0)
    assert slower.table["power_w.mean"] != fresh.table["power_w.mean"]
    # What a function encloses counts, and one that encloses itself has an end.
    weights = np.array([1.0, 2.0])

    def weighted(report: powergs.Report) -> float:
        return float(weights.sum()) * report.energy_pj if weighted else 0.0

    def total() -> float:
        found = powergs.sweep(machines(), trace, objectives={"e": weighted}, store=store)
        return sum(found.table["e"])

    first = total()
    weights[0] = 4.0
    assert total() == 2 * first
    # A design in the store is not run again.
    counted = Counted()
    for _ in range(2):
        powergs.sweep(machines(), trace, objectives={"e": counted}, store=tmp_path / "other")
    assert counted.calls == 3


@pytest.mark.parametrize("text", ['{"kind": "other"}\n', "\x00\x01\n", '{"kind"\n', "[]\n"])
def test_a_damaged_store_of_functions_is_refused(text, trace, gscore, tmp_path) -> None:
    (tmp_path / "designs.jsonl").write_text(text)
    with pytest.raises(powergs.InputError, match="another folder"):
        powergs.sweep([gscore], trace, store=tmp_path)
    (tmp_path / "designs.jsonl").rename(tmp_path / "notes.txt")
    with pytest.raises(powergs.ConfigError, match="other files"):
        powergs.sweep([gscore], trace, store=tmp_path)


def test_machines_of_a_generator(trace, gscore) -> None:
    seen: list[tuple[int, int]] = []
    machines = (gscore.with_({"vru.cores": n}) for n in (2, 4))
    found = powergs.sweep(machines, trace, progress=lambda *at: seen.append(at))
    assert found.designs["frame_time_ms.mean"] == [
        trace.replay(gscore.with_({"vru.cores": n})).frame_time_ms for n in (2, 2, 4)
    ]
    assert seen == [(1, 1), (2, 2)]
    # What differs says which is which; the first is what others are compared with.
    assert found.designs["point"] == [None, 0, 1] and found.designs["vru.cores"] == [2, 2, 4]
    assert found.machine(1) == gscore.with_({"vru.cores": 4}) and found.machine() == found.machine(0)
    with pytest.raises(KeyError):
        found.machine(2)


def test_spaces_with_points_that_are_no_machines(trace) -> None:
    # A feature buffer of this size has no banks for so many cores.
    axes = {"buffers.feature.capacity": ["16 KiB", "64 KiB"], "vru.cores": [1, 4, 16]}
    plain = powergs.sweep(axes, trace)
    assert plain.tally["invalid"] > 0 and plain.tally["ok"] > 0
    found = powergs.sweep(axes, trace, objectives={"ms": lambda r: r.frame_time_ms})
    assert found.tally == plain.tally
    assert found.table["reason"] == plain.table["reason"]
    space = powergs.Space(axes)
    invalid = 0
    for capacity in axes["buffers.feature.capacity"]:
        for cores in axes["vru.cores"]:
            try:
                space.ask({"buffers.feature.capacity": capacity, "vru.cores": cores})
            except powergs.InvalidDesign:
                invalid += 1
    assert invalid == plain.tally["invalid"] and len(list(space)) == plain.tally["ok"]


def test_spaces_of_constraints_samples_and_files(trace, demo, tmp_path) -> None:
    ms = {"ms": lambda r: r.frame_time_ms}
    few = powergs.sweep(AXES, trace, constraints=["vru.cores > ccu.units"], objectives=ms)
    assert few.tally["ok"] == 3
    space = powergs.Space(AXES, constraints=["vru.cores > ccu.units"])
    with pytest.raises(powergs.InvalidDesign, match="does not hold"):
        space.ask({"vru.cores": 2, "ccu.units": 4})
    sampling = {"method": "random", "points": 4, "seed": 3}
    some = powergs.sweep(AXES, trace, sampling=sampling, objectives=ms)
    assert some.designs["point"] == powergs.sweep(AXES, trace, sampling=sampling).designs["point"]
    file = tmp_path / "units.toml"
    file.write_text(FILE)
    of_file = powergs.sweep(file, demo, objectives=ms)
    assert of_file.designs["ms"] == pytest.approx(of_file.designs["frame_time_ms.mean"], rel=1e-14)
    assert of_file.designs["frame_time_ms.mean"] == powergs.sweep(file, demo).designs[
        "frame_time_ms.mean"
    ]
    asked = powergs.Space(file)
    assert asked.axes == AXES and asked.ask([1.0, 1.0]).machine["vru.cores"] == 8
    # The display rate of the file, and no energy table left out without a word.
    file.write_text(FILE.replace("[[axes]]", "display-fps = 90.0\n\n[[axes]]", 1))
    faster = powergs.sweep(file, demo, objectives=ms)
    assert faster.designs["power_w.mean"] == powergs.sweep(file, demo).designs["power_w.mean"]
    tables = '[[energy]]\nlabel = "own"\ntable = "gscore-28nm"\n\n[[energy]]\nlabel = "paper"\ntable = "paper"\n\n'
    file.write_text(FILE.replace("[[axes]]", tables + "[[axes]]", 1))
    with pytest.raises(powergs.ConfigError, match="own, paper"):
        powergs.sweep(file, demo, objectives=ms)
    with pytest.raises(powergs.ConfigError, match="adaptive"):
        powergs.sweep(AXES, trace, sampling={"method": "nsga2"}, objectives=ms)


def test_a_finished_store_opens(trace, demo, tmp_path, run) -> None:
    kept = powergs.sweep(AXES, trace, store=tmp_path / "ours")
    opened = powergs.SweepResult.open(tmp_path / "ours")
    assert opened.table.to_dict() == kept.table.to_dict() and opened.tally == kept.tally
    wanted = {"minimize": ["frame_time_ms.mean", "area_mm2"]}
    assert opened.pareto(**wanted).table["point"] == kept.pareto(**wanted).table["point"]
    file = tmp_path / "units.toml"
    file.write_text(FILE)
    run("sweep", file, "--traces", demo, "--out", tmp_path / "its", "--quiet")
    its = powergs.SweepResult.open(tmp_path / "its")
    assert its.table["frame_time_ms.mean"] == kept.table["frame_time_ms.mean"]
    with pytest.raises(powergs.ConfigError, match="sweep_show"):
        its.machine(0)
    with pytest.raises(FileNotFoundError):
        powergs.SweepResult.open(tmp_path)
    (tmp_path / "its" / "results.csv").write_text("a,b\n1,2\n")
    with pytest.raises(powergs.InputError, match="point"):
        powergs.SweepResult.open(tmp_path / "its")


def test_ask_and_tell(trace) -> None:
    space = powergs.Space(AXES)
    assert len(space) == 6
    candidate = space.ask()
    assert candidate.settings == {"vru.cores": 2, "ccu.units": 2} and candidate.number == 0
    by_name = space.ask({"ccu.units": 4, "vru.cores": 8})
    assert by_name.number == 5 and space.ask([1.0, 0.5]).number == 5
    assert by_name.machine["vru.cores"] == 8
    for candidate in space:
        report = trace.replay(candidate.machine)
        space.tell(candidate, {"ms": report.frame_time_ms, "mm2": report.area_mm2})
    assert space.table["point"] == list(range(6))
    front = space.pareto()
    assert front["ms"] == sorted(front["ms"])
    again = powergs.sweep(AXES, trace, objectives={"ms": lambda r: r.frame_time_ms})
    assert space.table["ms"] == again.designs["ms"][1:]
    for _ in range(5):
        space.ask()
    with pytest.raises(StopIteration):
        space.ask()


def test_spaces_and_settings_that_are_wrong(trace) -> None:
    for axes in [{}, {"vru.cores": []}]:
        with pytest.raises(powergs.ConfigError):
            powergs.Space(axes)
    with pytest.raises(powergs.ConfigError, match="did you mean `(vru.)?cores`"):
        powergs.Space({"vru.coers": [1]})
    with pytest.raises(powergs.ConfigError):
        powergs.Space({"vru.cores": [0]})
    space = powergs.Space(AXES)
    for at in [{"vru.cores": 3, "ccu.units": 2}, {"vru.cores": 2}, [0.5], [2.0, 0.0], [math.nan, 0]]:
        with pytest.raises(powergs.ConfigError):
            space.ask(at)
    with pytest.raises(powergs.ConfigError, match="nothing was told"):
        space.pareto()
    space.tell(space.ask(), 1.0)
    with pytest.raises(powergs.ConfigError, match="same objectives"):
        space.tell(space.ask(), {"other": 1.0})
    space.tell(space.ask(), None or math.nan)
    assert len(space.pareto()) == 1


def test_sweeps_that_are_wrong(trace, demo, tmp_path) -> None:
    for axes in [{"vru.coers": [1]}, {"vru.cores": [0.5]}, {"vru.cores": []}, {}, {3: [1]}]:
        with pytest.raises((powergs.ConfigError, TypeError)):
            powergs.sweep(axes, trace)
    with pytest.raises(TypeError):
        powergs.sweep({"vru.cores": 4}, trace)
    with pytest.raises(powergs.ConfigError, match="coers"):
        powergs.sweep({"vru.cores": [2]}, trace, constraints=["vru.coers > 1"])
    with pytest.raises(powergs.ConfigError):
        powergs.sweep({"vru.cores": [2, 4]}, trace, constraints=["vru.cores > 8"])
    with pytest.raises(powergs.ConfigError, match="sampling"):
        powergs.sweep(AXES, trace, sampling={"method": "best"})
    for traces in [[], [trace, trace]]:
        with pytest.raises(powergs.ConfigError, match="traces"):
            powergs.sweep(AXES, traces)
    with pytest.raises(powergs.ConfigError, match="gscore-units"):
        powergs.sweep("gscore-unitz", demo)
    with pytest.raises(powergs.ConfigError, match="itself"):
        powergs.sweep("gscore-units", demo, minimize=["area_mm2"])
    with pytest.raises(TypeError, match="machines"):
        powergs.sweep([3], trace)
    with pytest.raises(TypeError):
        powergs.sweep(3, trace)
    bad = tmp_path / "bad.toml"
    bad.write_text(FILE.replace("ccu.units", "ccu.unitz"))
    with pytest.raises(powergs.ConfigError, match="did you mean") as raised:
        powergs.sweep(bad, demo)
    assert raised.value.file == str(bad) and raised.value.line == 10
    trace.close()
    with pytest.raises(ValueError, match="closed"):
        powergs.sweep(AXES, trace)

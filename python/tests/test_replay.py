"""Machines, traces, reports: the same numbers as the program."""

from __future__ import annotations

import json
import math
import pickle
import threading
from pathlib import Path

import pytest

import powergs


def test_demo_is_the_programs_report_byte_for_byte(demo, run, tmp_path) -> None:
    words = ("replay", demo, "--json", "--what-if", "0", "--out")
    for name, keys in [("gscore", {}), ("neo", {}), ("gscore", {"vru.cores": 8})]:
        sets = [f"--set={key}={value}" for key, value in keys.items()]
        printed = run(*words, tmp_path / f"{name}{len(keys)}", "--arch", name, *sets)
        machine = powergs.Machine(name).with_(keys)
        assert powergs.Trace.open(demo).replay(machine).to_json() == printed


def test_other_files_and_rates_are_the_programs_too(trace, demo, run, tmp_path) -> None:
    words = ("replay", demo, "--json", "--what-if", "0", "--out")
    printed = run(
        *words, tmp_path / "a", "--energy", "gscore-7nm", "--dram-model", "calibrated", "--fps", "90"
    )
    report = trace.replay("gscore", energy="gscore-7nm", dram="calibrated", fps=90)
    assert report.to_json() == printed
    printed = run(*words, tmp_path / "b", "--model", "paper", "--display", "oled-d22")
    assert trace.replay("paper", display="oled-d22").to_json() == printed
    printed = run(*words, tmp_path / "c", "--frames", "1..3")
    assert trace[1:3].replay("gscore").to_json() == printed


def test_what_if_is_the_programs(report, demo, run, tmp_path) -> None:
    printed = run("replay", demo, "--json", "--out", tmp_path / "a")
    doubled = json.loads(printed)["what_if"]["doubled"]
    table = report.what_if()
    assert table["resource"] == [step["resource"] for step in doubled]
    for name in ["frame_time_ms", "area_change_frac", "fps_per_mm2_change_frac"]:
        assert table[name] == [step[name] for step in doubled]


def test_frames_hold_every_statistic_of_the_json(report) -> None:
    def flat(value, path=()):
        for key, inner in value.items():
            if isinstance(inner, dict):
                yield from flat(inner, (*path, key))
            else:
                yield ".".join((*path, key)), inner

    table = report.frames
    for position, frame in enumerate(report.to_dict()["frames"]):
        assert dict(flat(frame)) == table.row(position)


def test_summary_and_attributes(report) -> None:
    summary = report.summary
    row = dict(zip(summary["statistic"], summary["mean"]))
    assert row["frame_time_ms"] == report.frame_time_ms == report["frame_time_ms"]
    assert row["power_w.total"] == report.power_w == report["power_w.total.mean"]
    assert report["frame_time_ms.max"] == max(report.frames["frame_time_ms"])
    assert report.machine == "gscore" and report.trace == "demo" and report.model == "cycle"
    assert report.fps == 60.0 and report.deadline_misses == 0
    assert report["cache.hits"] is None


def test_bottleneck_reads_well(report) -> None:
    found = report.bottleneck
    assert found.limit == "vru"
    assert str(found).startswith("VRU-bound")
    assert found.bounds[0][0] == "vru" and 0 < found.bounds[0][1] < 1
    assert sum(s for _, s in found.bounds + found.waits) + found.without_work == pytest.approx(1)


def test_the_paper_model_has_no_time(trace) -> None:
    paper = trace.replay("paper")
    assert paper.model == "paper" and math.isnan(paper.frame_time_ms)
    with pytest.raises(powergs.ConfigError, match="without time"):
        assert paper.bottleneck
    with pytest.raises(powergs.ConfigError, match="paper model"):
        paper.what_if()


def test_charts_are_svg_and_png_and_saved_whole(report, tmp_path) -> None:
    charts = report.charts()
    assert {"energy", "cycles", "roofline"} <= set(charts)
    chart = charts["energy"]
    assert chart.svg.startswith("<svg") and chart.png.startswith(b"\x89PNG")
    assert "max-width: 100%" in chart._repr_svg_()
    for ending in ["svg", "png", "pdf"]:
        chart.save(tmp_path / f"energy.{ending}")
    assert (tmp_path / "energy.svg").read_text() == chart.svg
    with pytest.raises(ValueError, match=".svg, .png or .pdf"):
        chart.save(tmp_path / "energy.gif")
    with pytest.raises(OSError):
        chart.save(tmp_path / "nowhere" / "energy.svg")


def test_notebooks_get_html_without_a_page_around_it(report, gscore) -> None:
    for shown in [report, report.frames, report.summary, gscore, powergs.explain("vru.cores")]:
        html = shown._repr_html_()
        assert "<" in html and "<html" not in html and "<style" not in html


def test_machines_change_and_compare(gscore) -> None:
    eight = gscore.with_({"vru.cores": 8, "clock": "1.2 GHz"})
    assert eight["vru.cores"] == 8 and eight["clock"] == "1.2 GHz" and gscore["vru.cores"] == 4
    assert eight == gscore.with_(vru__cores=8, clock="1.2 GHz") != gscore
    assert hash(eight) == hash(gscore.with_(vru__cores=8, clock="1.2 GHz"))
    assert eight.clock_hz == 1.2e9 and eight.area_mm2 > gscore.area_mm2
    assert "cores = 8" in eight.to_toml()
    assert sum(filter(None, eight.area()["area_mm2"])) == pytest.approx(eight.area_mm2)
    assert "vru.cores" in gscore.keys()["key"] and "static" in gscore.keys("display")["key"]


def test_a_missing_area_is_not_a_number_and_never_zero(trace) -> None:
    machine = powergs.Machine("gscore", energy="paper")
    assert math.isnan(machine.area_mm2) and "mm²" not in repr(machine)
    report = trace.replay(machine)
    assert math.isnan(report.area_mm2)
    # What is not known beats nothing.
    space = powergs.Space({"vru.cores": [2, 4]})
    for candidate, area in zip(space, (report.area_mm2, 3.0)):
        space.tell(candidate, {"ms": report.frame_time_ms, "mm2": area})
    assert space.pareto(minimize=["mm2"])["point"] == [1]


def test_parts_that_a_machine_does_not_have(gscore) -> None:
    cached = gscore.with_({"cache.capacity": "32 KiB", "cache.ways": 8})
    assert (cached["cache.ways"], gscore["cache.capacity"]) == (8, "0 B")
    with pytest.raises(KeyError, match="give `cache.capacity`"):
        gscore["cache.ways"]
    value = dict(zip(gscore.keys()["key"], gscore.keys()["value"]))
    assert value["cache.ways"] is None and value["vru.cores"] == "4"
    assert "[cache]" in cached.to_toml() and "[cache]" not in gscore.to_toml()


def test_a_machine_from_a_file(gscore, tmp_path, demo) -> None:
    path = tmp_path / "mine.toml"
    path.write_text(gscore.with_(vru__cores=2).to_toml())
    mine = powergs.Machine(path)
    assert mine.name == "mine" and mine["vru.cores"] == 2
    assert powergs.Trace.open(demo).replay(path).machine == "mine"


def test_pickles(gscore, report, demo, tmp_path) -> None:
    path = tmp_path / "mine.toml"
    path.write_text(gscore.to_toml())
    for machine in [
        gscore,
        gscore.with_(vru__cores=8, energy="gscore-7nm"),
        powergs.Machine(path, energy="gscore-16nm", display="oled-d22"),
        gscore.with_({"dram.model": "bandwidth"}),
    ]:
        again = pickle.loads(pickle.dumps(machine))
        assert again == machine and again.name == machine.name
        trace = powergs.Trace.open(demo)[:1]
        assert trace.replay(again).to_json() == trace.replay(machine).to_json()
    again = pickle.loads(pickle.dumps(report))
    assert again.to_json() == report.to_json() and str(again) == str(report)
    assert again.charts()["energy"].svg == report.charts()["energy"].svg
    assert again.frames.to_dict() == report.frames.to_dict()
    table = pickle.loads(pickle.dumps(report.frames))
    assert table.units == report.frames.units and table.to_dict() == report.frames.to_dict()
    error = pytest.raises(powergs.ConfigError, powergs.Machine, "gscor").value
    again = pickle.loads(pickle.dumps(error))
    assert (str(again), again.suggestion) == (str(error), "gscore")


def test_a_loaded_trace_and_its_parts_give_the_same(trace, report) -> None:
    loaded = trace.load()
    assert loaded.loaded and not trace.loaded
    assert loaded.replay("gscore").to_json() == report.to_json()
    assert len(loaded[1:]) == 2 and loaded[-1].replay("gscore").frames["frame"] == [2]


def test_threads_share_a_trace(trace, report) -> None:
    found: list[str] = []

    def replay() -> None:
        found.append(trace.replay("gscore").to_json())

    threads = [threading.Thread(target=replay) for _ in range(4)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert found == [report.to_json()] * 4


def test_progress_is_told_from_beginning_to_end(trace) -> None:
    seen: list[tuple[int, int]] = []
    trace.replay("gscore", progress=lambda done, total: seen.append((done, total)))
    assert seen[-1] == (3, 3) and seen == sorted(seen)


def test_a_bar_of_tqdm_moves(trace) -> None:
    tqdm = pytest.importorskip("tqdm")
    with tqdm.tqdm(disable=False, file=open("/dev/null", "w")) as bar:
        trace.replay("gscore", progress=bar)
        assert (bar.n, bar.total) == (3, 3)
    trace.replay("gscore", progress=True)
    with pytest.raises(TypeError, match="progress"):
        trace.replay("gscore", progress=3)


def test_an_error_of_a_progress_function_is_raised(trace) -> None:
    def fails(done: int, total: int) -> None:
        raise RuntimeError("my own")

    with pytest.raises(RuntimeError, match="my own"):
        trace.replay("gscore", progress=fails)


def test_explain_defines_names(report) -> None:
    (entry,) = powergs.explain("vru.cores").entries
    assert entry["kind"] == "key of machine files" and entry["unit"] == "cores"
    for name in ["frame_time_ms", "A26", "gscore", "dram", "FPS per W"]:
        assert powergs.explain(name).entries
    known = {entry["name"] for entry in powergs.explain("frame_time_ms").entries}
    assert known == {"frame_time_ms"}
    definition = report.frames.definitions["frame_time_ms"]
    assert powergs.explain("frame_time_ms").entries[0]["definition"] == definition


def test_names_lists_what_comes_with_the_package() -> None:
    assert "gscore" in powergs.names() and "oled-powergs" in powergs.names("display")
    with pytest.raises(powergs.ConfigError, match="kind"):
        powergs.names("machines")

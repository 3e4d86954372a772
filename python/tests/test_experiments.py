"""Comparison, validation, a memory alone: the program's numbers."""

from __future__ import annotations

import json

import pytest

import powergs


def test_compare_is_the_programs(trace, demo, run, tmp_path) -> None:
    printed = run("compare", "gscore", "edge", demo, "--json", "--out", tmp_path / "its")
    ours = powergs.compare(["gscore", powergs.Machine("edge")], trace)
    assert ours.to_dict() == json.loads(printed)
    assert ours.labels == ["gscore", "edge"] and "edge / gscore" in ours.table.columns
    row = dict(zip(ours.table["measure"], ours.table["edge / gscore"]))
    assert row["throughput_fps"] == ours.least_speedup
    assert ours.charts() and "<table" in ours._repr_html_()


def test_a_goal_of_a_comparison(trace) -> None:
    with pytest.raises(powergs.GoalMissed, match="times the frame rate"):
        powergs.compare(["gscore", "gscore"], trace, at_least=1.5)
    powergs.compare(["gscore", "gscore"], trace, at_least=1.0)
    for wrong in [{"at_least": 0.0}, {"at_least": float("nan")}, {"fps": 0}]:
        with pytest.raises(powergs.ConfigError):
            powergs.compare(["gscore", "edge"], trace, **wrong)
    for machines in [[], ["gscore"], ["gscore", "nosuch"]]:
        with pytest.raises(powergs.ConfigError):
            powergs.compare(machines, trace)


def test_validate_is_the_programs(run) -> None:
    printed = json.loads(run("validate", "--quick", "--only", "area", "--json"))
    table = powergs.validate(only=["area"], check=True)
    for name in ["id", "published", "ours", "verdict"]:
        assert table[name] == [row[name] for row in printed["rows"]]
    with pytest.raises(powergs.ConfigError):
        powergs.validate(only=["nosuch"])


def test_dram_is_the_programs(run, tmp_path) -> None:
    requests = [("R" if i % 3 else "W", 4096 * (i % 7) + 64 * i, 64) for i in range(500)]
    file = tmp_path / "a.trace"
    file.write_text("".join(f"{k} {a:#x} {n}\n" for k, a, n in requests))
    printed = json.loads(run("dram", file, "--json", "--mode", "mlp8"))
    assert powergs.dram(file, mode="mlp8") == printed
    assert powergs.dram(requests, mode="mlp8") == printed
    faster = powergs.dram(requests, keys={"controller.read-queue": 64})
    assert faster["requests"] == 500


def test_memories_and_requests_that_are_wrong(tmp_path) -> None:
    one = [("R", 0, 64)]
    for wrong in [{"mode": "fast"}, {"device": "nosuch"}, {"keys": {"a": 1}}]:
        with pytest.raises(powergs.ConfigError):
            powergs.dram(one, **wrong)
    with pytest.raises(powergs.InputError):
        powergs.dram([("X", 0, 64)])
    with pytest.raises(powergs.InputError):
        powergs.dram(tmp_path / "nosuch")
    for requests in [3, [1], [("R", -1, 64)]]:
        with pytest.raises(TypeError):
            powergs.dram(requests)

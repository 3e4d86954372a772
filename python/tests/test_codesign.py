"""Co-design: a tiny space, kept models, and what cannot be."""

from __future__ import annotations

from pathlib import Path

import pytest

import powergs

SPACE = {
    "model": {
        "rho": [0.0, 0.4],
        "formats": [{"name": "short", "scale": "e5m8", "colour-rest": "e4m5"}],
    },
    "machine": {
        "set": {"display:scale": 0.3},
        "axes": [{"key": "vru.cores", "values": [1, 2]}, {"key": "dram.channels", "values": [4, 8]}],
        "derived": {"buffers.sorting.capacity": "16 KiB * vru.cores"},
    },
}


@pytest.fixture(scope="module")
def scene() -> powergs.Scene:
    return powergs.synth("demo", points=300, seed=3)[0]


@pytest.fixture(scope="module")
def views() -> powergs.Cameras:
    return powergs.synth("demo", points=1)[1].select(every=8, size=(40, 30))


def test_the_joint_pair_is_a_scene_and_a_machine_that_replay_together(
    scene: powergs.Scene, views: powergs.Cameras, tmp_path: Path
) -> None:
    seen: list[tuple[int, int]] = []
    found = powergs.codesign(
        scene,
        views,
        SPACE,
        quality=22.0,
        iterations=20,
        store=tmp_path / "kept",
        progress=lambda *at: seen.append(at),
    )
    ways = found.ways
    assert ways["way"] == ["a", "b", "c", "d", "e"]
    watts = ways["total_w"]
    assert watts[4] == min(watts)
    assert found.gain_w == pytest.approx(min(watts[:4]) - watts[4])
    assert found.models["model"][0] == "dense" and found.models["rho"][-1] >= 0.0
    pairs = found.pairs
    assert len(pairs) == 5 * sum(found.models["passed"])
    assert min(pairs["total_w"]) <= ways["total_w"][1]
    # The pair as objects: the report of its trace has the frame time of the pair.
    report = found.model.extract(views).replay(found.machine)
    assert max(report.frames["frame_time_ms"]) == pytest.approx(ways["frame_time_ms_max"][4])
    assert {"front", "breakdown"} <= set(found.charts())
    assert "(e)" in str(found) and "<table" in found._repr_html_()
    assert seen and all(done <= total for done, total in seen)
    # What is kept is not made again, and says the same.
    again = powergs.codesign(
        scene, views, SPACE, quality=22.0, iterations=20, store=tmp_path / "kept"
    )
    assert str(again) == str(found)


def test_what_cannot_be_is_told(scene: powergs.Scene, views: powergs.Cameras) -> None:
    with pytest.raises(powergs.GoalMissed, match="no model of space reaches the quality"):
        powergs.codesign(scene, views, SPACE, quality=80.0, iterations=4)
    tight = {**SPACE, "budget": {"area": "0.1 mm2"}}
    with pytest.raises(powergs.GoalMissed, match="the nearest miss is"):
        powergs.codesign(scene, views, tight, quality=20.0, iterations=4)
    with pytest.raises(powergs.ConfigError, match="rho"):
        powergs.codesign(scene, views, {"model": {"rho": [1.5]}})
    with pytest.raises(powergs.ConfigError, match="nowhere.toml"):
        powergs.codesign(scene, views, "nowhere.toml")

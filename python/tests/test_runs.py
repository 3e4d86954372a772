"""Runs of other simulators."""

from __future__ import annotations

import csv
from pathlib import Path

import pytest

import powergs

MACHINE = (Path(__file__).parents[2] / "examples/elsewhere/elsewhere.toml").read_text()


def test_a_run_from_arrays_is_a_machine_like_others(trace, tmp_path) -> None:
    np = pytest.importorskip("numpy")
    pa = pytest.importorskip("pyarrow")
    splats = pa.table(trace[0].splats())
    assert splats.column_names[:3] == ["rank", "index", "depth_world"]
    index = splats["index"].to_numpy()
    ids = trace.ids()
    assert len(ids) == len(trace) and trace[1].ids() == ids[1:2]
    began = np.arange(len(index)) * 10
    frames = {
        name: {
            "cycles": 10 * len(index) + 1,
            "alpha": 640 * len(index),
            "busy.raster": 5 * len(index),
            "requests": {
                "what": "dram-read",
                "bytes": np.full(len(index), 32),
                "cycle": began,
                "needed": began + 10,
                "address": index * 32,
            },
        }
        for name in ids
    }
    powergs.write_run(tmp_path / "demo.csv", frames)
    with pytest.raises(FileExistsError):
        powergs.write_run(tmp_path / "demo.csv", frames)
    powergs.write_run(tmp_path / "demo.csv", frames, overwrite=True)
    assert [file.name for file in tmp_path.iterdir()] == ["demo.csv"]
    (tmp_path / "elsewhere.toml").write_text(MACHINE)
    machine = powergs.Machine(str(tmp_path / "elsewhere.toml"))
    assert "run" in machine._key
    report = trace[0].replay(machine, dram="bandwidth")
    assert report.frames.to_dict()["actions.alpha"][0] == 640 * len(index)
    with pytest.raises(powergs.ConfigError, match="run was made with"):
        machine.with_({"recorded.units.raster.count": 2})
    rows = list(csv.DictReader((tmp_path / "demo.csv").open()))
    assert rows[-1]["needed"] and rows[-1]["phase"] == ""


def test_what_does_not_fit_together_is_said(tmp_path) -> None:
    for requests, wanted in [
        ({"what": "dram-read", "bytes": [1], "cycle": [0]}, "missing address"),
        ({"what": "dram-read", "bytes": [1], "cycle": [0], "addres": [0]}, "no column addres"),
        ({"what": "dram-read", "bytes": [1], "cycle": [0, 1], "address": [0]}, "different lengths"),
    ]:
        with pytest.raises(powergs.InputError, match=wanted):
            powergs.write_run(tmp_path / "run.csv", {"00": {"cycles": 1, "requests": requests}})
    assert list(tmp_path.iterdir()) == []

"""Every command and flag of the program has a name in Python, and folders open as tables."""

from __future__ import annotations

import inspect
import json
import subprocess
import sys

import pytest

import powergs
from powergs import _powergs, commands


def described() -> list[dict]:
    return json.loads(_powergs._commands())


def test_every_flag_has_a_name_or_a_reason() -> None:
    unused = set(commands.WITHOUT_NAME)
    for command in described():
        first = command["path"][0]
        if first in commands.WITHOUT_NAME:
            unused.discard(first)
            continue
        name = "_".join(word.replace("-", "_") for word in command["path"])
        parameters = inspect.signature(getattr(commands, name)).parameters
        for argument in command["arguments"]:
            flag = f"--{argument['name']}" if argument["is_flag"] else argument["name"]
            if flag in commands.WITHOUT_NAME:
                unused.discard(flag)
                continue
            python = argument["name"].replace("-", "_").lower()
            assert python in parameters or f"{python}_" in parameters, (name, flag)
            assert argument["help"], (name, flag)
    assert unused <= {"--version"}, "reasons for what is not there"


def test_the_description_is_what_help_prints(run) -> None:
    """Commands are those of the program that was built from the same tree."""
    for command in described():
        text = run(*command["path"], "--help")
        for argument in command["arguments"]:
            if argument["is_flag"]:
                assert f"--{argument['name']}" in text, (command["path"], argument["name"])


def test_a_report_opens_as_tables(demo, tmp_path, run) -> None:
    done = commands.replay(demo, arch="gscore", set={"vru.cores": 8}, what_if=0)
    assert done.folder.path.is_dir()
    assert done.result["machine"]["name"] == "gscore"
    results = done.folder.tables["results"]
    report = powergs.Trace.open(demo).replay(powergs.Machine("gscore").with_({"vru.cores": 8}))
    assert results["frame_time_ms"][: len(report.frames)] == report.frames["frame_time_ms"]
    assert "energy.png" in done.folder.files and done.folder.page is not None
    assert "FPS" in str(done)
    assert results.units and done.command[:2] == ["powergs-sim", "replay"]
    with pytest.raises(KeyError, match="did you mean 'results'"):
        done.folder.tables["result"]
    kept = done.folder.save(tmp_path / "kept")
    path = done.folder.path
    with pytest.raises(FileExistsError):
        done.folder.save(tmp_path / "kept")
    del done
    assert not path.exists() and kept.files
    # Its record runs again, with the program and here.
    run("again", kept.path)
    assert commands.again(kept.path).result


def test_commands_without_an_object_of_their_own(demo, tmp_path) -> None:
    shifted = commands.sensitivity("gscore", demo, keys="vru.cores,ccu.units")
    assert shifted.folder.tables
    scene = commands.synth("demo", points=500, output=tmp_path / "a.ply")
    assert (tmp_path / "a.ply").is_file()
    with pytest.raises(ValueError, match="no folder"):
        assert scene.folder
    info = commands.scene_info(tmp_path / "a.ply")
    assert info.result["points"] == 500 or info.result
    file = tmp_path / "units.toml"
    text = 'question = "Cores?"\nbase = "gscore"\n[[axes]]\nkey = "vru.cores"\nvalues = [2, 4, 8]\n'
    file.write_text(text)
    swept = commands.sweep(file, traces=[demo], out=tmp_path / "units")
    assert swept.folder.text
    opened = powergs.SweepResult.open(tmp_path / "units")
    assert opened.tally["ok"] == 3 and opened.pareto().table["point"]
    assert powergs.Folder(tmp_path / "units").tables["results"]["point"][0] is None


def test_a_file_of_a_trace_is_its_path(trace) -> None:
    verified = commands.trace_verify(trace)
    assert verified.command[-1] == trace.path


def test_mistakes_are_exceptions(demo, tmp_path) -> None:
    with pytest.raises(TypeError, match="did you mean 'arch'"):
        commands.replay(demo, arche="gscore")
    with pytest.raises(TypeError):
        commands.replay()
    with pytest.raises(powergs.ConfigError, match="gscore"):
        commands.replay(demo, arch="gscorr")
    with pytest.raises(powergs.InputError):
        commands.replay(__file__)
    with pytest.raises(TypeError, match="one value"):
        commands.replay(demo, arch=["gscore", "gcc"])
    with pytest.raises(powergs.GoalMissed) as missed:
        commands.compare(["gscore", "gscore", demo], at_least=1.5)
    assert missed.value.outcome.folder.tables["compare"]
    with pytest.raises(powergs.ConfigError, match="ended with 2"):
        commands.replay(demo, arch="gscorr", progress=True)
    memory = powergs.synth("demo", points=200)
    frames = memory[0].extract(memory[1][:1])
    with pytest.raises(powergs.ConfigError, match="path"):
        commands.replay(frames)
    with pytest.raises(FileNotFoundError):
        powergs.Folder(tmp_path / "none")


def test_the_program_is_in_the_package(demo, tmp_path) -> None:
    call = [sys.executable, "-m", "powergs"]
    version = subprocess.run([*call, "--version"], capture_output=True, text=True, check=True)
    assert powergs.__version__ in version.stdout
    out = tmp_path / "report"
    done = subprocess.run([*call, "replay", demo, "--out", out, "--quiet"], check=False)
    assert done.returncode == 0 and (out / "run.toml").is_file()
    wrong = subprocess.run([*call, "replay"], capture_output=True, text=True, check=False)
    assert wrong.returncode == 2 and "--help" in wrong.stderr

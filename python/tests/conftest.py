"""Where things are, and what several tests need."""

from __future__ import annotations

import os
import subprocess
from pathlib import Path

import pytest

import powergs

ROOT = Path(__file__).resolve().parents[2]


@pytest.fixture(scope="session")
def demo() -> Path:
    return ROOT / "traces" / "demo.bin"


@pytest.fixture()
def trace(demo: Path) -> powergs.Trace:
    return powergs.Trace.open(demo)


@pytest.fixture(scope="session")
def gscore() -> powergs.Machine:
    return powergs.Machine("gscore")


@pytest.fixture(scope="session")
def report(demo: Path) -> powergs.Report:
    return powergs.Trace.open(demo).replay("gscore")


@pytest.fixture(scope="session")
def program() -> Path:
    """The command-line program, for comparisons: POWERGS_SIM, or the release build of this tree."""
    path = Path(os.environ.get("POWERGS_SIM", ROOT / "target" / "release" / "powergs-sim"))
    if not path.exists():
        pytest.skip(f"{path} is not there: `cargo build --release`, or set POWERGS_SIM")
    return path


@pytest.fixture(scope="session")
def run(program: Path):  # type: ignore[no-untyped-def]
    """Runs the program and returns what it printed."""

    def call(*words: object) -> str:
        command = [str(program), *map(str, words)]
        done = subprocess.run(command, capture_output=True, text=True, cwd=ROOT)
        assert done.returncode == 0, done.stderr
        return done.stdout

    return call

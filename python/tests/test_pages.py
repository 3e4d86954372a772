"""The Python blocks of the documentation run in the order of their page, and type checkers take them."""

from __future__ import annotations

import importlib.util
import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from conftest import ROOT

PAGE = ROOT / "docs" / "python.md"

#: Packages that a block may need and that are large: their blocks run where they are installed.
LARGE = ("dask", "ray")


def blocks(page: Path) -> list[str]:
    return re.findall(r"^```python\n(.*?)^```", page.read_text(encoding="utf-8"), re.S | re.M)


def wanted(block: str) -> str | None:
    """The package that a block needs and that is not installed."""
    names = (name for name in LARGE if re.search(rf"^import {name}\b", block, re.M))
    return next((name for name in names if importlib.util.find_spec(name) is None), None)


def test_the_blocks_of_the_page_run(demo, tmp_path) -> None:
    (tmp_path / "traces").mkdir()
    shutil.copy(demo, tmp_path / "traces")
    (tmp_path / "photo.png").write_bytes(b"")
    code = ["import powergs", "scene, cameras = powergs.synth('lego', points=2000)"]
    code.append("powergs.quality = lambda *pictures: None")  # the page has no photo
    for block in blocks(PAGE):
        if wanted(block) is None:
            # Everything smaller than the page says: it is about what can be called.
            for large, small in [
                ("points=50_000", "points=2000"),
                ("size=(800, 800)", "size=(64, 64)"),
                ("size=(1920, 1080)", "size=(64, 64)"),
                ("path(24)", "path(2)"),
                ("quality=35.0, callback=print", "quality=20.0, iterations=20, size=(64, 64)"),
            ]:
                block = block.replace(large, small)
            code.append(block)
    file = tmp_path / "page.py"
    # Workers of other processes import the file.
    body = "\n".join(code).replace("\n", "\n    ")
    file.write_text(f"def main():\n    {body}\n\n\nif __name__ == '__main__':\n    main()\n")
    done = subprocess.run(
        [sys.executable, file], cwd=tmp_path, capture_output=True, text=True, timeout=600
    )
    assert done.returncode == 0, done.stderr[-3000:]
    assert (tmp_path / "study.db").is_file() and (tmp_path / "final.ply").is_file()


def test_type_checkers_take_the_page(tmp_path) -> None:
    file = tmp_path / "page.py"
    code = "\n".join(block for block in blocks(PAGE) if not re.search(r"^import (dask|ray)", block))
    file.write_text(code, encoding="utf-8")
    loose = ["joblib", "pandas", "polars", "pyarrow", "duckdb", "optuna"]
    ini = tmp_path / "mypy.ini"
    parts = "\n".join(f"[mypy-{name}.*]\nignore_missing_imports = True" for name in loose)
    ini.write_text(f"[mypy]\nstrict = True\n{parts}\n")
    call = [sys.executable, "-m", "mypy", "--config-file", ini, file]
    done = subprocess.run(call, capture_output=True, text=True, cwd=tmp_path)
    assert done.returncode == 0, done.stdout


@pytest.mark.skipif(
    importlib.util.find_spec("snakemake") is None, reason="snakemake is not installed"
)
def test_snakemake_makes_the_results_of_one_process(demo, program, tmp_path) -> None:
    page = (ROOT / "docs" / "cluster.md").read_text(encoding="utf-8")
    (tmp_path / "Snakefile").write_text(re.search(r"^```python\n(# the Snakefile.*?)^```", page, re.S | re.M)[1])
    shutil.copy(demo, tmp_path)
    path = os.pathsep.join([str(program.parent), os.environ["PATH"]])
    call = [sys.executable, "-m", "snakemake", "--cores", "2"]
    env = {**os.environ, "PATH": path}
    subprocess.run(call, cwd=tmp_path, env=env, check=True, capture_output=True)
    whole = ["sweep", "gscore-units", "--traces", "demo.bin", "--out", "whole", "--quiet"]
    subprocess.run([program, *whole], cwd=tmp_path, check=True)
    ours = (tmp_path / "whole" / "results.csv").read_bytes()
    assert (tmp_path / "units" / "results.csv").read_bytes() == ours

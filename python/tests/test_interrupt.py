"""Ctrl-C, processes that are forked, and interpreters that end meanwhile."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import textwrap
import time

import pytest

POSIX = pytest.mark.skipif(os.name != "posix", reason="signals of POSIX")

# A long call: one frame on as many machines as what_if doubles, again and again in one list.
LONG = """
    import powergs, sys, time
    trace = powergs.Trace.open(sys.argv[1])
    report = trace.replay("gscore")
    print("ready", flush=True)
    try:
        while True:
            report.what_if()
    except KeyboardInterrupt:
        print("stopped", time.monotonic(), flush=True)
    assert trace.replay("gscore").to_json() == report.to_json()
    print("usable", flush=True)
"""


def started(code: str, *words: object) -> subprocess.Popen[str]:
    command = [sys.executable, "-c", textwrap.dedent(code), *map(str, words)]
    process = subprocess.Popen(command, stdout=subprocess.PIPE, text=True)
    assert process.stdout is not None and process.stdout.readline() == "ready\n"
    return process


@POSIX
def test_ctrl_c_raises_at_once_and_the_trace_is_usable(demo) -> None:
    process = started(LONG, demo)
    time.sleep(0.3)
    sent = time.monotonic()
    process.send_signal(signal.SIGINT)
    out, _ = process.communicate(timeout=60)
    words = out.split()
    assert words[0] == "stopped" and words[2] == "usable" and process.returncode == 0
    # 0.2 s are asked for; what follows leaves room for a loaded machine.
    assert float(words[1]) - sent < 2


@POSIX
def test_an_interpreter_that_ends_meanwhile_ends(demo) -> None:
    code = """
        import powergs, sys, threading, time
        trace = powergs.Trace.open(sys.argv[1])
        def forever():
            while True:
                trace.replay("gscore")
        threading.Thread(target=forever, daemon=True).start()
        print("ready", flush=True)
        time.sleep(0.2)
    """
    process = started(code, demo)
    assert process.wait(timeout=60) == 0


@POSIX
@pytest.mark.skipif(not hasattr(os, "fork"), reason="no fork")
def test_a_forked_process_can_replay(demo) -> None:
    code = """
        import multiprocessing, powergs, sys
        trace = powergs.Trace.open(sys.argv[1])
        expected = trace.replay("gscore").to_json()
        print("ready", flush=True)
        def again(_):
            return powergs.Trace.open(sys.argv[1]).replay("gscore").to_json()
        with multiprocessing.get_context("fork").Pool(2) as pool:
            assert pool.map(again, range(2)) == [expected] * 2
    """
    process = started(code, demo)
    assert process.wait(timeout=120) == 0

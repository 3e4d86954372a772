"""Hostile input: every mistake is a Python exception that says what to do."""

from __future__ import annotations

import gc
import math
import pickle
import threading

import pytest

import powergs


@pytest.mark.parametrize(
    ("keys", "message"),
    [
        ({"vru.coers": 8}, "did you mean `cores`"),
        ({"vru.cores": -1}, "at least 1"),
        ({"vru.cores": 0}, "at least 1"),
        ({"vru.cores": 2.5}, "cores"),
        ({"vru.cores": float("nan")}, "NaN is not a number"),
        ({"vru.cores": float("inf")}, "inf is not a number"),
        ({"vru.cores": 1 << 70}, "64-bit"),
        ({"vru.cores": "many"}, "cores"),
        ({"vru.cores": [1, 2]}, "cores"),
        ({"clock": "fast"}, "frequency"),
        ({"": 1}, "KEY=VALUE"),
        ({"cache.ways": 8}, "give `cache.capacity`"),
        ({"energy": "nosuch"}, "no energy table `nosuch`"),
        ({"energy:foo": 1}, "foo"),
        ({"nosuch:foo": 1}, "nosuch"),
        ({"\0\n": 1}, "unknown key"),
    ],
)
def test_invalid_keys_and_values(gscore, keys, message) -> None:
    with pytest.raises(powergs.ConfigError, match=message):
        gscore.with_(keys)


@pytest.mark.parametrize("value", [None, object(), b"8", {"a": 1}, 1j])
def test_values_of_wrong_types(gscore, value) -> None:
    with pytest.raises(TypeError):
        gscore.with_({"vru.cores": value})


def test_errors_know_file_line_and_suggestion(gscore, tmp_path) -> None:
    path = tmp_path / "mine.toml"
    lines = gscore.to_toml().splitlines()
    at = lines.index("cores = 4")
    lines[at] = "coers = 4"
    path.write_text("\n".join(lines))
    with pytest.raises(powergs.ConfigError) as raised:
        powergs.Machine(path)
    error = raised.value
    assert (error.file, error.line, error.suggestion) == (str(path), at + 1, "cores")
    assert isinstance(error, powergs.PowergsError) and isinstance(error, ValueError)
    with pytest.raises(powergs.ConfigError, match="did you mean `gscore`") as raised:
        powergs.Machine("gscor")
    assert raised.value.suggestion == "gscore" and raised.value.line is None


def test_things_that_are_no_machine(trace) -> None:
    for thing in [3, None, object(), ["gscore"]]:
        with pytest.raises(TypeError):
            trace.replay(thing)
        with pytest.raises(TypeError):
            powergs.Machine(thing)
    with pytest.raises(powergs.ConfigError):
        trace.replay("nosuch")


def test_files_that_are_no_trace(demo, tmp_path) -> None:
    broken = tmp_path / "broken.bin"
    whole = demo.read_bytes()
    for damage in [b"", b"hello", whole[: len(whole) // 2], whole[:-1]]:
        broken.write_bytes(damage)
        with pytest.raises(powergs.InputError) as raised:
            powergs.Trace.open(broken)
        assert raised.value.file == str(broken)
    for place in [tmp_path, tmp_path / "nosuch", "/dev/null", "a\0b"]:
        with pytest.raises((powergs.InputError, ValueError)):
            powergs.Trace.open(place)
    for thing in [3, None, b"\xff", []]:
        with pytest.raises((TypeError, powergs.InputError)):
            powergs.Trace.open(thing)


def test_a_damaged_frame_is_found_when_it_is_read(demo, tmp_path) -> None:
    broken = tmp_path / "broken.bin"
    whole = bytearray(demo.read_bytes())
    whole[len(whole) // 3] ^= 0x55
    broken.write_bytes(bytes(whole))
    with pytest.raises(powergs.InputError):
        powergs.Trace.open(broken).replay("gscore")


@pytest.mark.parametrize("fps", [0, -1, float("nan"), float("inf"), 1e9])
def test_rates_out_of_range(trace, fps) -> None:
    with pytest.raises(powergs.ConfigError, match="1 to 1000"):
        trace.replay("gscore", fps=fps)


def test_other_arguments_out_of_range(trace, report, demo) -> None:
    with pytest.raises(powergs.ConfigError, match="dram"):
        trace.replay("gscore", dram="fast")
    with pytest.raises(powergs.ConfigError, match="paper"):
        trace.replay("paper", dram="banked")
    with pytest.raises(TypeError):
        trace.replay("gscore", 60)
    with pytest.raises(powergs.ConfigError):
        report.what_if(0)
    with pytest.raises(OverflowError):
        report.what_if(-1)
    for memory in ["much", "0 B", -1, 0, "-3 GiB"]:
        with pytest.raises((powergs.ConfigError, OverflowError)):
            powergs.Trace.open(demo, memory=memory)
    with pytest.raises(powergs.InputError, match="memory="):
        powergs.Trace.open(demo, memory="10 kB").replay("gscore")


def test_frames_that_are_not_there(trace) -> None:
    for position in [3, -4, 1 << 40]:
        with pytest.raises(IndexError):
            trace[position]
    for part in [slice(None, None, 2), slice(3, None), slice(2, 1)]:
        with pytest.raises(ValueError, match="in a row"):
            trace[part]
    with pytest.raises(TypeError):
        trace["a"]


def test_a_closed_trace_says_so(demo) -> None:
    with powergs.Trace.open(demo) as trace:
        report = trace.replay("gscore")
        part = trace[1:]
    assert trace.closed and "closed" in repr(trace)
    for use in [trace.load, lambda: trace.replay("gscore"), lambda: trace[0], report.what_if]:
        with pytest.raises(ValueError, match="closed"):
            use()
    with pytest.raises(ValueError, match="closed"):
        part.replay("gscore")
    trace.close()
    assert report.frames.shape[0] == 3


def test_closing_while_another_thread_replays(demo) -> None:
    trace = powergs.Trace.open(demo)
    outcomes: list[object] = []

    def replay() -> None:
        try:
            for _ in range(50):
                outcomes.append(trace.replay("gscore"))
        except (ValueError, powergs.PowergsError) as error:
            outcomes.append(error)

    thread = threading.Thread(target=replay)
    thread.start()
    while not outcomes and thread.is_alive():
        pass
    trace.close()
    thread.join()
    assert "closed" in str(outcomes[-1])


def test_what_is_not_pickled_says_so(trace) -> None:
    with pytest.raises(TypeError, match="pickle its path"):
        pickle.dumps(trace)


def test_columns_and_statistics_that_are_not_there(report) -> None:
    with pytest.raises(KeyError, match="did you mean `frame_time_ms`"):
        report["frame_time_mss"]
    with pytest.raises(KeyError):
        report["frame_time_ms.p12"]
    with pytest.raises(KeyError, match="did you mean `name`"):
        report.frames["nam"]
    with pytest.raises(AttributeError, match="report\\["):
        report.frame_time
    with pytest.raises(IndexError):
        report.frames.row(3)
    with pytest.raises(powergs.ConfigError, match="did you mean"):
        powergs.explain("vru.cors")


def test_classes_are_not_made_by_hand_and_do_not_change(gscore, report) -> None:
    for kind in [powergs.Report, powergs.Table, powergs.Trace, powergs.Chart, powergs.Bottleneck]:
        with pytest.raises(TypeError):
            kind()
    with pytest.raises(AttributeError):
        gscore.name = "mine"
    with pytest.raises(AttributeError):
        report.power_w = 0
    with pytest.raises(TypeError):
        gscore < gscore  # noqa: B015


def test_a_forged_pickle_is_an_error() -> None:
    from powergs import _powergs

    for call in [
        lambda: _powergs._report("{", [], "", ""),
        lambda: _powergs._machine("gscore", {"machine": ("a", None, "=", "=", [])}),
        lambda: _powergs._table(["a"], ["real"], {}, {}, {}),
        lambda: _powergs._table(["a", "b"], ["real"] * 2, {}, {}, {"a": [1.0], "b": []}),
    ]:
        with pytest.raises(powergs.PowergsError):
            call()
    empty = _powergs._report("{}", [], "", "")
    assert empty.frames.shape[0] == 0 and math.isnan(empty.power_w)
    repr(empty)


def test_exceptions_leave_nothing_behind(gscore) -> None:
    gc.collect()
    before = len(gc.get_objects())
    for _ in range(200):
        with pytest.raises(powergs.ConfigError):
            gscore.with_({"vru.coers": 8})
    gc.collect()
    assert len(gc.get_objects()) < before + 2000

"""What a replay costs from Python beside the same from Rust, and on two threads beside one.

    cargo build --release --example many_replays
    pip install ./python
    python benches/python.py [TRACE] [COUNT] [ROUNDS]

The first frame of the trace is replayed COUNT times, from memory. Rounds alternate; the ratio is that
of the medians. Two threads share the work and the trace.
"""

import subprocess
import sys
import time
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from statistics import median

import powergs

ROOT = Path(__file__).resolve().parents[1]
RUST = ROOT / "target/release/examples/many_replays"


def main() -> None:
    trace = sys.argv[1] if len(sys.argv) > 1 else str(ROOT / "traces/demo.bin")
    count = int(sys.argv[2]) if len(sys.argv) > 2 else 1000
    rounds = int(sys.argv[3]) if len(sys.argv) > 3 else 5
    frames = powergs.Trace.open(trace)[:1].load()
    machine = powergs.Machine("gscore")

    def one(times: int) -> None:
        for _ in range(times):
            frames.replay(machine)

    def seconds(threads: int) -> float:
        start = time.perf_counter()
        with ThreadPoolExecutor(threads) as pool:
            list(pool.map(one, [count // threads] * threads))
        return time.perf_counter() - start

    rust, single, double = [], [], []
    for _ in range(rounds):
        done = subprocess.run([RUST, trace, str(count)], check=True, capture_output=True, text=True)
        rust.append(float(done.stdout.split()[-2]))
        single.append(seconds(1))
        double.append(seconds(2))
    print(f"{count} replays of a frame of {trace}, {rounds} rounds, medians")
    print(f"Rust {median(rust):.3f} s, Python {median(single):.3f} s, two threads {median(double):.3f} s")
    print(f"Python over Rust {median(single) / median(rust):.3f}")
    print(f"two threads {median(single) / median(double):.2f} times as fast as one")


if __name__ == "__main__":
    main()

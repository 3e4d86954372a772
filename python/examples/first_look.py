"""A trace on a machine: what limits it, and what would help."""

from __future__ import annotations

import sys

import powergs


def main(path: str) -> None:
    trace = powergs.Trace.open(path)
    report = trace.replay("gscore")
    print(report)
    print(f"make faster first: {report.bottleneck.limit}")
    for step in report.what_if():
        print(f"{step['resource']:26} {100 * step['frame_time_change_frac']:+6.1f} % time")


if __name__ == "__main__":
    main(sys.argv[1] if len(sys.argv) > 1 else "traces/demo.bin")

"""The program ``powergs-sim`` of the package: ``python -m powergs replay traces/demo.bin``."""

from __future__ import annotations

import os
import signal
import sys
import sysconfig
from pathlib import Path

from ._powergs import _main


def main() -> int:
    """Runs the program with the words of this process."""
    name = "powergs-sim.exe" if os.name == "nt" else "powergs-sim"
    # What starts the program again: `again` and jobs of a cluster do.
    places = (Path(sys.argv[0]).parent, Path(sysconfig.get_path("scripts")))
    script = next((place / name for place in places if (place / name).is_file()), Path(name))
    # The program says itself what happens at Ctrl-C.
    signal.signal(signal.SIGINT, signal.SIG_DFL)
    return _main([os.fspath(script), *sys.argv[1:]])


if __name__ == "__main__":
    sys.exit(main())

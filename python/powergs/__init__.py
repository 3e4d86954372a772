"""powergs: a cycle-approximate simulator of 3D Gaussian Splatting accelerators.

>>> import powergs
>>> trace = powergs.Trace.open("traces/demo.bin")
>>> report = trace.replay(powergs.Machine("gscore").with_({"vru.cores": 8}))
>>> print(report.bottleneck)                                                    # doctest: +SKIP

``powergs.explain(name)`` defines every statistic, key, assumption and word; ``powergs.names(kind)``
lists the machines, tables, displays, devices, sweeps and scenes that come with the package.
"""

from ._powergs import (
    Bottleneck,
    Camera,
    Cameras,
    Chart,
    Explanation,
    Machine,
    Report,
    Scene,
    Table,
    Trace,
    __version__,
    display_power,
    explain,
    names,
    quality,
    synth,
)
from .errors import ConfigError, GoalMissed, InputError, InternalError, PowergsError

__all__ = [
    "Bottleneck",
    "Camera",
    "Cameras",
    "Chart",
    "ConfigError",
    "Explanation",
    "GoalMissed",
    "InputError",
    "InternalError",
    "Machine",
    "PowergsError",
    "Report",
    "Scene",
    "Table",
    "Trace",
    "__version__",
    "display_power",
    "explain",
    "names",
    "quality",
    "synth",
]

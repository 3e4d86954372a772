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
    Codesigned,
    Comparison,
    Explanation,
    Front,
    Machine,
    Optimized,
    Report,
    Scene,
    SweepResult,
    Table,
    Trace,
    __build__,
    __model_version__,
    __version__,
    codesign,
    compare,
    display_power,
    dram,
    explain,
    names,
    optimize,
    png,
    quality,
    synth,
    validate,
)
from . import commands
from .errors import (
    ConfigError,
    GoalMissed,
    InputError,
    InternalError,
    InvalidDesign,
    MissingFileError,
    PowergsError,
)
from .program import Folder
from .runs import write_run
from .sweeps import Candidate, Space, sweep

__all__ = [
    "Bottleneck",
    "Camera",
    "Cameras",
    "Candidate",
    "Chart",
    "Codesigned",
    "Comparison",
    "ConfigError",
    "Explanation",
    "Folder",
    "Front",
    "GoalMissed",
    "InputError",
    "InternalError",
    "InvalidDesign",
    "Machine",
    "MissingFileError",
    "Optimized",
    "PowergsError",
    "Report",
    "Scene",
    "Space",
    "SweepResult",
    "Table",
    "Trace",
    "__build__",
    "__model_version__",
    "__version__",
    "codesign",
    "commands",
    "compare",
    "display_power",
    "dram",
    "explain",
    "names",
    "optimize",
    "png",
    "quality",
    "sweep",
    "synth",
    "validate",
    "write_run",
]

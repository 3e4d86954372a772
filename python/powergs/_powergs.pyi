"""What is compiled of powergs. Docstrings are written by ``python python/stubs.py``."""

import os
from collections.abc import Callable, Iterator, Mapping, Sequence
from types import TracebackType
from typing import Any, Literal, Protocol, TypeAlias, TypedDict, final, overload

import numpy as np
import numpy.typing as npt
from typing_extensions import Unpack

__version__: str
__model_version__: int
__build__: str

class _Bar(Protocol):
    """A bar of tqdm, or whatever moves as one."""

    n: Any
    total: Any
    def update(self, n: Any = ..., /) -> Any: ...
    def reset(self, total: Any = ..., /) -> Any: ...

Progress: TypeAlias = bool | Callable[[int, int], object] | _Bar | None
_Path: TypeAlias = str | os.PathLike[str]
_Value: TypeAlias = int | float | str | bool | Sequence[int | float | str | bool]
_Size: TypeAlias = tuple[int, int]
_Background: TypeAlias = Literal["black", "white"] | tuple[float, float, float]
_Picture: TypeAlias = npt.NDArray[np.floating[Any]] | npt.NDArray[np.uint8] | _Path
_Memory: TypeAlias = int | str
_Sheet: TypeAlias = Literal["slide", "page", "column"] | str

class _Quality(TypedDict):
    psnr_db: float | None
    ssim: float
    flip: float
    l1: float
    mse: float

class _FitSettings(TypedDict, total=False):
    iterations: int | None
    interval: int
    seed: int
    checkpoint_every: int

class _Settings(_FitSettings, total=False):
    first_effort: float
    held_out_iterations: int
    final_iterations: int | None
    level_effort: float
    adjust_share: float
    display_weight: float
    level_display_weight: float
    dimming: Literal["gains", "damped", "published"]
    epsilon_db: float
    opacity_cap: float
    rate_scale: float
    rate_end: float
    gate: Literal["validation", "test"]
    gate_size: Literal["priced", "trained"]

class _Arrays(TypedDict):
    means: npt.NDArray[np.floating[Any]]
    quats: npt.NDArray[np.floating[Any]]
    scales: npt.NDArray[np.floating[Any]]
    opacities: npt.NDArray[np.floating[Any]]
    sh: npt.NDArray[np.floating[Any]]

class _DisplayPower(TypedDict):
    power_w: float
    red_w: float
    green_w: float
    blue_w: float
    static_w: float
    mean_linear_rgb: list[float]

@final
class Table:
    """A table of results: columns with units and definitions.

    pandas, polars, pyarrow and DuckDB read it through the Arrow PyCapsule interface without a copy:
    ``pandas.DataFrame.from_arrow(t)``, ``polars.DataFrame(t)``, ``pyarrow.table(t)``. Each column's
    Arrow metadata has ``unit`` and ``definition``.
    """
    @property
    def columns(self) -> list[str]:
        """Names of the columns."""
    @property
    def shape(self) -> tuple[int, int]:
        """Number of rows and columns."""
    @property
    def units(self) -> dict[str, str]:
        """Units by column; ``1`` for counts and ratios, empty for words."""
    @property
    def definitions(self) -> dict[str, str]:
        """Definitions by column."""
    def __len__(self) -> int: ...
    @overload
    def __getitem__(self, which: str, /) -> list[Any]: ...
    @overload
    def __getitem__(self, which: int, /) -> dict[str, Any]: ...
    @overload
    def __getitem__(self, which: slice, /) -> Table: ...
    def __iter__(self) -> Iterator[dict[str, Any]]: ...
    def __contains__(self, name: str, /) -> bool: ...
    def head(self, rows: int = 5) -> Table:
        """The first rows."""
    def to_pandas(self) -> Any:
        """The table as a ``pandas.DataFrame``; needs pandas 3, or pyarrow beside an older one."""
    def to_polars(self) -> Any:
        """The table as a ``polars.DataFrame``."""
    def row(self, position: int) -> dict[str, Any]:
        """One row as a dictionary; negative positions count from the end."""
    def to_dict(self) -> dict[str, list[Any]]:
        """All columns as a dictionary of lists."""
    def __arrow_c_schema__(self) -> object: ...
    def __arrow_c_stream__(self, requested_schema: object | None = None) -> object: ...
    def _repr_html_(self) -> str: ...

@final
class Chart:
    """A chart. Notebooks show it; ``svg``, ``png`` and ``pdf`` give its bytes."""
    @property
    def name(self) -> str:
        """File name without its ending."""
    @property
    def title(self) -> str:
        """What it shows."""
    @property
    def svg(self) -> str:
        """The chart as SVG."""
    @property
    def png(self) -> bytes:
        """The chart as PNG."""
    @property
    def pdf(self) -> bytes:
        """The chart as PDF of one page."""
    def styled(self, size: _Sheet = "slide", *, title: bool = True) -> Chart:
        """The same chart in another size: ``"slide"`` (1920 x 1080 pixels), ``"page"`` (7 in wide),
        ``"column"`` (3.33 in), or a width such as ``"3.5in"``, ``"88mm"`` or ``"252pt"``, with or
        without its title.
        """
    def save(self, path: _Path) -> None:
        """Writes the chart; the ending of ``path`` (``.svg``, ``.png``, ``.pdf``) says how."""
    def _repr_svg_(self) -> str: ...

@final
class Explanation:
    """What a name means: ``str(x)`` is the text, ``x.entries`` a list of dictionaries."""
    @property
    def entries(self) -> list[dict[str, Any]]:
        """The definitions: dictionaries with ``kind``, ``name``, ``unit``, ``definition``, ``value``
        and what else is known.
        """
    def _repr_html_(self) -> str: ...

@final
class Machine:
    """A machine: its file, the energy table and the DRAM device that it names, and a display.

    Parameters
    ----------
    name : str or path
        A machine that comes with the package (``powergs.names("machine")``), or a TOML file.
    energy : str or path, optional
        Energy table in place of the machine's: a name, a TOML file, or a table of Accelergy.
    display : str or path
        Display whose power is counted beside that of the machine.

    A machine never changes; ``with_`` gives another one.

    >>> eight = powergs.Machine("gscore").with_({"vru.cores": 8, "clock": "1.2 GHz"})
    >>> eight["vru.cores"]
    8
    """
    def __new__(
        cls, name: _Path, /, *, energy: _Path | None = None, display: _Path | None = None
    ) -> Machine: ...
    def with_(self, keys: Mapping[str, _Value] | None = None, /, **named: _Value) -> Machine:
        """The same machine with some keys changed.

        Keys have dots (``"vru.cores"``); as keyword arguments they have ``__`` for the dots and
        ``_`` for ``-``. Values are numbers, texts with a unit (``"1.2 GHz"``), truth values or
        lists. ``energy:``, ``dram:`` and ``display:`` in front of a key name the other files.

        Raises ``ConfigError`` for a key that the file does not have, with a suggestion, for one of
        a part that the machine does not have, and for values that do not fit together.
        """
    @property
    def name(self) -> str:
        """Name of the machine."""
    @property
    def description(self) -> str:
        """What it is, in a sentence."""
    @property
    def _key(self) -> dict[str, str]: ...
    @property
    def energy_table(self) -> str:
        """Name of its energy table."""
    @property
    def clock_hz(self) -> float:
        """Clock, hertz."""
    @property
    def dram_peak_gb_s(self) -> float:
        """Peak rate of its DRAM, 10⁹ bytes per second."""
    @property
    def area_mm2(self) -> float:
        """Area of the chip, mm²; NaN where the energy table has no areas."""
    def area(self) -> Table:
        """Area and peak power of its blocks: ``block``, ``area_mm2``, ``peak_power_w``."""
    def keys(self, file: Literal["machine", "energy", "dram", "display"] = "machine") -> Table:
        """Every key with its value, unit and definition.

        ``file`` is ``"machine"``, ``"energy"``, ``"dram"`` or ``"display"``.
        """
    def __getitem__(self, key: str, /) -> Any: ...
    @staticmethod
    def from_toml(
        text: str, /, *, energy: _Path | None = None, display: _Path | None = None
    ) -> Machine:
        """A machine file as a text, such as that of ``to_toml``; it may name a ``base``. ``energy``
        and ``display`` are as for ``Machine(...)``.
        """
    @staticmethod
    def from_dict(
        keys: dict[str, Any], /, *, energy: _Path | None = None, display: _Path | None = None
    ) -> Machine:
        """A machine file as a dictionary of tables: ``{"base": "gscore", "vru": {"cores": 8}}``."""
    def to_toml(self) -> str:
        """The machine file as TOML, with every key and all changes."""
    def __eq__(self, other: object, /) -> bool: ...
    def __ne__(self, other: object, /) -> bool: ...
    def __hash__(self) -> int: ...
    def _repr_html_(self) -> str: ...

@final
class Camera:
    """One view: a pinhole camera.

    Parameters
    ----------
    intrinsics : array of shape (3, 3)
        ``[[fx, 0, cx], [0, fy, cy], [0, 0, 1]]``, pixels from the left and top edges, as gsplat's
        ``Ks``.
    world_to_camera : array of shape (4, 4)
        The pose, as gsplat's ``viewmats``: x to the right, y down, z forward.
    size : (int, int)
        Width and height, pixels.
    name : str
        Name of the view.

    Raises ``InputError`` for matrices of another shape, skew and poses that are no rotations.
    """
    def __new__(
        cls,
        intrinsics: npt.ArrayLike,
        world_to_camera: npt.ArrayLike,
        size: _Size,
        *,
        name: str = "view",
    ) -> Camera: ...
    @property
    def intrinsics(self) -> npt.NDArray[np.float64]:
        """Focal lengths and principal point, pixels from the left and top edges: an array of shape
        (3, 3), float64.
        """
    @property
    def world_to_camera(self) -> npt.NDArray[np.float64]:
        """Pose: x to the right, y down, z forward; an array of shape (4, 4), float64."""
    @property
    def name(self) -> str:
        """Name of the view, usually its photo."""
    @property
    def size(self) -> _Size:
        """Width and height, pixels."""
    @property
    def focal(self) -> tuple[float, float]:
        """Focal lengths in x and y, pixels."""
    @property
    def position(self) -> list[float]:
        """Place of the camera, world units: x, y, z."""
    @property
    def split(self) -> Literal["train", "test"] | None:
        """``"train"`` or ``"test"``, where the file says so."""
    def resized(self, width: int, height: int) -> Camera:
        """The same view with another size of its picture; another aspect keeps the vertical field of
        view.
        """

@final
class Cameras:
    """Views of a scene, at least one: a list of ``Camera``, or from a file, a circle, or a path."""
    def __new__(cls, views: Sequence[Camera], /) -> Cameras: ...
    @property
    def warnings(self) -> list[str]:
        """What was left out or taken on trust, one sentence each."""
    @staticmethod
    def open(path: _Path, /, *, size: _Size | None = None) -> Cameras:
        """Opens a camera file: INRIA ``cameras.json``, NeRF ``transforms.json``, or a folder of
        COLMAP. ``size`` is for files that do not say it, pixels.

        Raises ``InputError``.
        """
    @staticmethod
    def orbit(
        scene: Scene,
        views: int,
        *,
        elevation: float | None = None,
        radius: float | None = None,
        fov: float | None = None,
        up: Literal["x", "y", "z", "-x", "-y", "-z"] = "-y",
        size: _Size | None = None,
    ) -> Cameras:
        """Views on a circle around a scene, evenly spaced.

        ``elevation`` (20) and the vertical ``fov`` (50) are degrees; ``radius`` is world units, by
        default such that the scene fills the picture; ``up`` is an axis such as ``"-y"``.
        """
    def path(self, frames: int) -> Cameras:
        """A smooth path of so many frames through the views."""
    def select(
        self,
        *,
        split: Literal["train", "test"] | None = None,
        every: int | None = None,
        size: _Size | None = None,
        stereo: float | None = None,
        fov: str | None = None,
    ) -> Cameras:
        """A part of the views, in this order: those of a ``split`` (``"train"``, ``"test"``), every
        K-th, with another ``size`` (pixels), in pairs ``stereo`` world units apart, with another
        field of view ``fov`` (degrees: ``"90x96"``, or ``"52+45x48+50"`` for the outer, inner,
        upper and lower edge of each eye).
        """
    def save(self, path: _Path) -> None:
        """Writes the views as an INRIA ``cameras.json``."""
    def __len__(self) -> int: ...
    @overload
    def __getitem__(self, which: int, /) -> Camera: ...
    @overload
    def __getitem__(self, which: slice, /) -> Cameras: ...
    def __iter__(self) -> Iterator[Camera]: ...

@final
class Scene:
    """A trained model: Gaussians in memory.

    ``Scene.open(path)`` reads every known format; ``powergs.synth`` makes one.
    """
    @property
    def format(self) -> str:
        """Format of the file, such as ``"ply"`` or ``"spz v4"``."""
    @property
    def warnings(self) -> list[str]:
        """Oddities of the file that do not prevent its use, one sentence each."""
    @property
    def name(self) -> str:
        """Name of the scene: its file without ending."""
    @property
    def sh_degree(self) -> int:
        """Degree of its spherical harmonics, 0 to 3."""
    @staticmethod
    def open(
        path: _Path,
        /,
        *,
        detail: int | None = None,
        level: int | None = None,
        axes: str | None = None,
    ) -> Scene:
        """Opens a model: INRIA PLY, compressed PLY, ``.splat``, ``.spz``, glTF, SOG, streamed SOG
        (with its ``detail``, 0 is the finest), the folder of a training run, or a foveated model
        (its ``level``, 1 to 4; 1 by default). ``axes`` are those of the file where they are not
        those of its format: ``"ply"`` for SPZ and glTF files with the axes of a PLY, or three
        letters for where x, y and z point to (``"rdf"``, ``"rub"``).

        Raises ``InputError``.
        """
    @staticmethod
    def from_arrays(
        *,
        means: npt.ArrayLike,
        quats: npt.ArrayLike,
        scales: npt.ArrayLike,
        opacities: npt.ArrayLike,
        sh: npt.ArrayLike,
        name: str = "arrays",
        antialiased: bool = False,
    ) -> Scene:
        """A model of arrays, in the layout of ``gsplat.rasterization``.

        Parameters
        ----------
        means : array of shape (N, 3)
            Centres, world units.
        quats : array of shape (N, 4)
            Rotations (w, x, y, z), of any length but zero.
        scales : array of shape (N, 3)
            Standard deviations along the axes, world units, above 0: after ``exp``.
        opacities : array of shape (N,)
            0 to 1: after ``sigmoid``.
        sh : array of shape (N, K, 3)
            Spherical harmonics, K = 1, 4, 9 or 16.
        name : str
            Name of the scene.
        antialiased : bool
            Whether it was trained with the 2D filter of Mip-Splatting.

        Arrays are of NumPy or PyTorch, with any strides. Raises ``InputError`` for other shapes and
        for values that are no numbers.
        """
    @staticmethod
    def from_gsplat(
        splats: Mapping[str, npt.ArrayLike],
        /,
        *,
        name: str = "gsplat",
        antialiased: bool = False,
    ) -> Scene:
        """The parameters of a model in training with gsplat: its ``splats``, or the ``splats`` of a
        checkpoint of ``simple_trainer.py``.

        Parameters
        ----------
        splats : dict
            ``means`` (N, 3), ``scales`` (N, 3) before ``exp``, ``quats`` (N, 4) as w, x, y, z,
            ``opacities`` (N,) before ``sigmoid``, ``sh0`` (N, 1, 3), and ``shN`` (N, K, 3) with
            K = 0, 3, 8 or 15 if it is there. Other keys are left alone.
        name : str
            Name of the scene.
        antialiased : bool
            Whether it was trained with ``rasterize_mode="antialiased"``.

        Raises ``InputError`` for missing keys, other shapes and values that are no numbers.
        """
    @staticmethod
    def from_points(
        positions: npt.ArrayLike,
        /,
        colours: npt.ArrayLike | None = None,
        *,
        name: str = "points",
    ) -> Scene:
        """Gaussians around points, as the published training of 3DGS begins: round, as large as the
        root of the mean squared distance to the three nearest neighbours, of opacity 0.1 and SH
        degree 0.

        Parameters
        ----------
        positions : array of shape (N, 3)
            Places, world units.
        colours : array of shape (N, 3), optional
            sRGB, 0 to 1; middle grey without.
        name : str
            Name of the scene.

        Raises ``InputError`` for other shapes and for values that are no numbers.
        """
    def to_arrays(self) -> _Arrays:
        """The model as arrays: a dictionary with the names of ``from_arrays``, each float32 and owned
        by Python.
        """
    def __len__(self) -> int: ...
    def stats(self) -> dict[str, Any]:
        """Count, bounds, percentiles of position, opacity, scale (world units) and axis ratio, as a
        dictionary with the names of ``powergs-sim scene info --json``.
        """
    def render(
        self,
        camera: Camera,
        *,
        size: _Size | None = None,
        background: _Background | None = None,
        memory: _Memory | None = None,
    ) -> npt.NDArray[np.float32]:
        """The picture of a view: an array of shape (height, width, 3), float32, sRGB. Values may
        exceed 1, where a display clamps them. The array owns the memory that was rendered to.

        ``size`` is (width, height) in pixels, in place of the view's; ``background`` is
        ``"black"``, ``"white"`` or three numbers.
        """
    def extract(
        self,
        cameras: Cameras,
        *,
        size: _Size | None = None,
        background: _Background | None = None,
        path: _Path | None = None,
        memory: _Memory | None = None,
        progress: Progress = None,
        order: str = "storage",
    ) -> Trace:
        """Renders the views with all counters: a trace, in memory or, with ``path``, in a file.

        Parameters
        ----------
        cameras : Cameras
            The views.
        size : (int, int), optional
            Width and height in pixels, in place of the views' own.
        background : str or (float, float, float)
            ``"black"``, ``"white"``, or sRGB values from 0 to 1.
        path : str or path, optional
            The trace file; it appears whole or not at all, with the bytes of ``powergs-sim
            extract``.
        memory : int or str, optional
            What a frame (in memory: all frames) may take, such as ``"2 GiB"``.
        progress : bool, function or bar, optional
            As for ``Trace.replay``.
        order : str
            How the Gaussians are sorted first: ``"storage"`` (not), ``"morton"``, ``"hilbert"`` or
            ``"opacity"``. Pictures stay, addresses follow.
        """
    def save(self, path: _Path, *, format: str | None = None) -> dict[str, Any]:
        """Writes the model in the format that the name says, as ``powergs-sim scene convert`` does:
        ``.ply``, ``.compressed.ply``, ``.spz``, ``.gltf``, ``.glb`` or ``.sog``; or as ``format``,
        such as ``"glb-spz"``.

        Returns what the file holds of every field (``exact``, ``largest``, ``rms``, ``clamped``),
        as ``kept`` of ``powergs-sim scene convert --json``.

        Raises ``ConfigError`` where the name says no format that is written, or the format cannot
        hold the model.
        """
    def close(self) -> None:
        """Frees the memory of the model. Whoever uses the scene afterwards gets a ``ValueError``."""
    def __enter__(self) -> Scene: ...
    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        traceback: TracebackType | None,
        /,
    ) -> None: ...

@final
class Trace:
    """Frames of a scene, independent of any machine: made by ``Scene.extract`` or the command
    ``powergs-sim extract``.

    ``Trace.open(path)`` opens a file; ``trace[2:5]`` is a part of it, ``trace.load()`` keeps the
    decoded frames in memory. Any number of threads may use a trace at the same time.
    """
    @staticmethod
    def open(path: _Path, /, *, memory: _Memory | None = None) -> Trace:
        """Opens a trace.

        ``memory`` is what a frame may take, bytes or a text such as ``"2 GiB"``.

        Raises ``InputError`` for a file that is damaged or no trace.
        """
    @property
    def _key(self) -> tuple[str, int, int]: ...
    @property
    def name(self) -> str:
        """Name in reports: the file name without its ending."""
    @property
    def path(self) -> str | None:
        """The file; ``None`` for frames that were never in one."""
    @property
    def size(self) -> _Size:
        """Width and height of the first frame, pixels."""
    @property
    def loaded(self) -> bool:
        """Whether the decoded frames are in memory."""
    @property
    def closed(self) -> bool:
        """Whether the trace is closed."""
    def __len__(self) -> int: ...
    def __getitem__(self, which: int | slice, /) -> Trace: ...
    def load(self, *, progress: Progress = None) -> Trace:
        """The same trace with its frames decoded in memory, for many replays.

        Raises ``InputError`` where they take more than the memory allowed.
        """
    def ids(self, *, progress: Progress = None) -> list[str]:
        """What each frame goes by in the file of a run (``write_run``): a hash of what is in it."""
    def to_arrays(self) -> dict[str, npt.NDArray[Any]]:
        """The visible splats of one frame in depth order as arrays: ``trace[3].to_arrays()``.

        ``indices`` (N,) in the scene, uint32; ``depths`` (N,) in world units; ``means`` (N, 2) in
        pixels, whose centres are whole numbers; ``covariances`` (N, 3), xx, xy and yy in pixels²,
        low-pass included; ``opacities`` (N,): float32.
        """
    def splats(self) -> Table:
        """The visible splats of one frame in depth order, as ``powergs-sim trace dump`` writes them:
        ``trace[3].splats()``.
        """
    def replay(
        self,
        machine: Machine | _Path,
        /,
        *,
        energy: _Path | None = None,
        dram: str | None = None,
        display: _Path | None = None,
        fps: float = 60.0,
        progress: Progress = None,
    ) -> Report:
        """Runs the frames on a machine.

        Parameters
        ----------
        machine : Machine, str or path
            The machine; ``"paper"`` is the published closed-form model, which has no time.
        energy : str or path, optional
            Energy table in place of the machine's.
        dram : str, optional
            Model of the DRAM: ``"banked"``, ``"calibrated"``, ``"bandwidth"``.
        display : str or path, optional
            Display in place of the machine's.
        fps : float
            Display rate, frames per second, for power and deadlines.
        progress : bool, function or bar, optional
            ``True`` shows a bar; a function is called with ``(done, total)`` frames.

        The numbers are those of ``powergs-sim replay --json``, bit for bit. Ctrl-C raises
        ``KeyboardInterrupt`` at once.
        """
    def close(self) -> None:
        """Closes the file. Whoever uses the trace afterwards gets a ``ValueError``."""
    def __enter__(self) -> Trace: ...
    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        traceback: TracebackType | None,
        /,
    ) -> None: ...

@final
class Bottleneck:
    """What limits a machine, and why."""
    @property
    def limit(self) -> str:
        """What to make faster first: a unit, ``"colour"`` or ``"dram"``."""
    @property
    def sentence(self) -> str:
        """The same as a sentence."""
    @property
    def bounds(self) -> list[tuple[str, float]]:
        """Leading units at work: name and share of the frame, largest first."""
    @property
    def waits(self) -> list[tuple[str, float]]:
        """Leading units that wait: cause and share of the frame, largest first."""
    @property
    def without_work(self) -> float:
        """Share of the frame in which leading units have no work."""

@final
class Report:
    """What frames did on a machine: times, energies, powers, what limits it.

    ``frames`` and ``summary`` are tables; ``report["power_w.total"]`` is the mean of a statistic,
    ``report["frame_time_ms.p99"]`` another part of it (``mean``, ``p50``, ``p95``, ``p99``,
    ``max``). ``powergs.explain(name)`` defines every statistic.
    """
    @property
    def frames(self) -> Table:
        """Every statistic of every frame: a row per frame. Units and definitions are in the metadata
        of the columns.
        """
    @property
    def summary(self) -> Table:
        """Every statistic over the frames: a row per statistic, with ``unit``, ``mean``, ``p50``,
        ``p95``, ``p99``, ``max`` and ``definition``.
        """
    @property
    def machine(self) -> str:
        """Name of the machine."""
    @property
    def trace(self) -> str:
        """Name of the trace."""
    @property
    def model(self) -> Literal["cycle", "paper"]:
        """``"cycle"`` or ``"paper"``."""
    @property
    def fps(self) -> float:
        """Display rate, frames per second."""
    @property
    def throughput_fps(self) -> float:
        """Frames per second when frames run back to back; NaN in the ``paper`` model, which has no
        time.
        """
    @property
    def throughput_power_w(self) -> float:
        """Power at that rate, watts; NaN in the ``paper`` model."""
    @property
    def frame_time_ms(self) -> float:
        """Mean time of a frame, milliseconds; NaN in the ``paper`` model."""
    @property
    def energy_pj(self) -> float:
        """Mean energy of a frame, picojoules; NaN where the energy table lacks a price."""
    @property
    def power_w(self) -> float:
        """Power at the display rate, watts; NaN where the energy table lacks a price."""
    @property
    def display_power_w(self) -> float | None:
        """Power of the display, watts, where the trace has the means of its pictures."""
    @property
    def area_mm2(self) -> float:
        """Area of the chip, mm²; NaN where the energy table has no areas."""
    @property
    def deadline_misses(self) -> int | None:
        """Frames that took longer than a period of the display; ``None`` in the ``paper`` model."""
    @property
    def bottleneck(self) -> Bottleneck:
        """What limits the machine. Raises ``ConfigError`` in the ``paper`` model, which has no time."""
    def what_if(self, frames: int = 3, *, progress: Progress = None) -> Table:
        """What doubling each resource would buy, by simulation of ``frames`` frames spread over the
        trace: ``resource``, ``set`` (what to give to ``with_``) and relative changes.
        """
    def charts(self) -> dict[str, Chart]:
        """The charts of the report by name."""
    def save(
        self,
        folder: _Path,
        *,
        overwrite: bool = False,
        size: _Sheet = "slide",
        title: bool = True,
        formats: list[str] | None = None,
    ) -> None:
        """Writes the report folder that ``powergs-sim replay --what-if 0`` writes: pages, tables,
        charts (``size``, ``title`` as for ``Chart.styled``; ``formats`` of ``"svg"``, ``"png"``,
        ``"pdf"``, by default the first two) and the record. It appears whole or not at all.

        Raises ``OSError`` where something is there; ``overwrite`` replaces a finished report.
        """
    def _outcome(self) -> str: ...
    def to_json(self) -> str:
        """The report as JSON, as ``powergs-sim replay --json --what-if 0`` prints it."""
    def to_dict(self) -> dict[str, Any]:
        """The report as a dictionary with the structure of ``to_json``."""
    def __getitem__(self, name: str, /) -> float | None: ...
    def _repr_html_(self) -> str: ...

@final
class SweepResult:
    """What a sweep found, whatever it was made from: ``table`` has the rows of ``results.csv``,
    ``designs`` those of the means.
    """
    @staticmethod
    def open(folder: _Path, /) -> SweepResult:
        """A finished sweep in a folder: of the program, or a ``store`` that is complete.

        Raises ``InputError`` where there is none, or it is unfinished.
        """
    def machine(self, point: int | None = None) -> Machine:
        """The machine of a design by its number in ``point``; without one the base. Raises
        ``ConfigError`` for a sweep of a file or a folder: ``powergs.commands.sweep_show`` has it.
        """
    def __iter__(self) -> Iterator[dict[str, Any]]: ...
    @property
    def table(self) -> Table:
        """Every row of ``results.csv``: per design, energy table and trace, and the ``mean`` and the
        ``worst`` over the traces (column ``scope``); the base machine first.
        """
    @property
    def designs(self) -> Table:
        """The rows of the means over the traces: one per design and energy table."""
    @property
    def tally(self) -> dict[str, int]:
        """How many designs there are by fate: ``ok``, ``invalid``, ``failed``, ``missing``."""
    def pareto(
        self,
        *,
        minimize: list[str] | None = None,
        maximize: list[str] | None = None,
        where: str | None = None,
        scope: str = "mean",
        energy_table: str | None = None,
        include_misses: bool | None = None,
    ) -> Front:
        """The designs that no other beats.

        Parameters
        ----------
        minimize, maximize : list of str, optional
            Columns of the table, or expressions of them; those of the sweep without any.
        where : str, optional
            Condition: ``"frame_time_ms.p99 <= 16.67 && area_mm2.core <= 4"``.
        scope : str
            ``"mean"``, ``"worst"``, or the label of a trace.
        energy_table : str, optional
            Label of the energy table; the first without it.
        include_misses : bool, optional
            Whether designs that miss the display rate are ranked like all others.

        Raises ``GoalMissed`` where no design meets the condition.
        """
    def __len__(self) -> int: ...
    def _repr_html_(self) -> str: ...

@final
class Front:
    """The best designs of a sweep, the best in the first objective first."""
    @property
    def table(self) -> Table:
        """A row per design, as in the sweep's table, and ``is_knee``."""
    @property
    def knee(self) -> int | None:
        """Number of the design from which no objective gains much without another losing more."""
    def charts(self) -> dict[str, Chart]:
        """The charts of the analysis by name."""
    def __len__(self) -> int: ...
    def _repr_html_(self) -> str: ...

@final
class Comparison:
    """Machines beside each other on the same frames; the first is what the others are compared with."""
    @property
    def table(self) -> Table:
        """A row per trace and measure: ``trace``, ``measure``, a column per machine, and ``MACHINE /
        FIRST`` per other.
        """
    @property
    def speedup(self) -> Table | None:
        """With several traces: frame rates over those of the first machine, a row per trace and the
        geometric mean; ``None`` with one.
        """
    @property
    def labels(self) -> list[str]:
        """Names of the machines; those of one name are numbered."""
    @property
    def least_speedup(self) -> float | None:
        """Frames per second of the slowest other machine over those of the first."""
    def to_dict(self) -> dict[str, Any]:
        """The comparison with the names of ``powergs-sim compare --json``."""
    def charts(self) -> dict[str, Chart]:
        """The charts by name."""
    def _repr_html_(self) -> str: ...

@final
class Codesigned:
    """What a co-design found.

    ``model`` and ``machine`` are the pair that needs the fewest watts together; ``ways`` puts it
    beside what searching one half after the other finds. Notebooks show the page of the run.
    """
    @property
    def model(self) -> Scene:
        """The model of the joint pair, as a machine reads it."""
    @property
    def machine(self) -> Machine:
        """The machine of the joint pair, with the record of the model."""
    @property
    def ways(self) -> Table:
        """The five ways (a) to (e), confirmed with the banked model of the DRAM: model, machine (its
        point of the space, nothing for the base machine, and what it has on the axes), watts, area,
        slowest frame. What a way does not find is nothing.
        """
    @property
    def models(self) -> Table:
        """All models, the dense one first: what they are, and whether they reach the quality."""
    @property
    def pairs(self) -> Table:
        """Every pair that was priced, under the first energy table, with the calibrated model of the
        DRAM.
        """
    @property
    def gain_w(self) -> float | None:
        """Watts that the joint pair saves against the best of (a) to (d), confirmed."""
    def charts(self) -> dict[str, Chart]:
        """The charts of the run by name."""
    def _repr_html_(self) -> str: ...

@final
class Optimized:
    """What an optimisation found.

    ``model`` is the scene with the fewest watts that reached the quality; ``models`` all that were
    made, ``history`` every iteration. Notebooks show the page of the run.
    """
    @property
    def reached(self) -> bool:
        """Whether a model reached the quality."""
    @property
    def model(self) -> Scene:
        """The model with the fewest watts. Raises ``GoalMissed`` where none reached the quality."""
    @property
    def models(self) -> Table:
        """All models in the order in which they were made: what for, the share that was pruned,
        quality over gate and test views, watts.
        """
    @property
    def history(self) -> Table:
        """Every iteration of every job: ``job``, ``iteration``, ``view``, ``gaussians``, ``loss``,
        ``psnr_db`` of its training view, ``lambda_per_w``, ``display_w``, and ``gate_psnr_db``
        where the quality was checked after it.
        """
    @property
    def notes(self) -> list[str]:
        """What people should know, one sentence each."""
    @property
    def pictures(self) -> tuple[npt.NDArray[np.uint8], npt.NDArray[np.uint8]] | None:
        """The first test view with the dense and with the final model: two arrays of shape (height,
        width, 3), uint8; ``None`` where no model reached the quality.
        """
    def to_dict(self) -> dict[str, Any]:
        """Everything that was found, with the names of ``results.json``."""
    def charts(self) -> dict[str, Chart]:
        """The charts of the run by name."""
    def _repr_html_(self) -> str: ...

def explain(name: str) -> Explanation:
    """What is called ``name``: a statistic (``"frame_time_ms"``), a key (``"vru.cores"``), the start
    of several (``"dram"``), an assumption (``"A26"``), a source (``"gscore"``) or a word.

    Raises ``ConfigError`` with a suggestion where nothing is.
    """
def names(
    kind: Literal["machine", "energy", "display", "dram", "sweep", "synth"] = "machine",
) -> list[str]:
    """Names of files that come with the package.

    ``kind`` is ``"machine"``, ``"energy"``, ``"display"``, ``"dram"``, ``"sweep"`` or ``"synth"``.
    """
def synth(
    preset: _Path, *, points: int | None = None, seed: int = 1
) -> tuple[Scene, Cameras]:
    """Makes a synthetic scene that behaves like a trained one, and the views of its preset.

    ``preset`` is a name of ``powergs.names("synth")`` or a TOML file; ``points`` the number of
    Gaussians, whose sizes follow so that the look stays; the same ``seed`` gives the same bytes.

    >>> scene, cameras = powergs.synth("demo", points=2000)
    """
def quality(
    a: _Picture, b: _Picture, *, pixels_per_degree: float | None = None
) -> _Quality:
    """How like two pictures of one size are.

    ``a`` is compared with the reference ``b``: arrays of shape (height, width, 3), sRGB values from
    0 to 1 or uint8, or paths of pictures. Returns ``psnr_db`` (``None`` for equal pictures),
    ``ssim``, ``flip``, ``l1`` and ``mse``; ``docs/metrics.md`` defines them. ``pixels_per_degree``
    of sight is for FLIP.

    Raises ``InputError`` for arrays of another shape or type and for values that are no numbers.
    """
def display_power(image: _Picture, display: _Path | None = None) -> _DisplayPower:
    """What a picture costs to show: ``power_w`` and its parts ``red_w``, ``green_w``, ``blue_w``,
    ``static_w``, and ``mean_linear_rgb``.

    ``image`` is an array of shape (height, width, 3), sRGB values from 0 to 1 or uint8, or a path;
    ``display`` the name or path of a panel.
    """
def png(image: _Picture) -> bytes:
    """A picture as PNG of 8 bits a channel, as a display gets it: values are clamped to 0..1.

    ``image`` is an array of shape (height, width, 3), sRGB values from 0 to 1 or uint8, or a path.
    """
def compare(
    machines: Sequence[Machine | _Path],
    trace: Trace | Sequence[Trace],
    *,
    fps: float = 60.0,
    at_least: float | None = None,
    across_nodes: bool = False,
    across_tasks: bool = False,
    budget_w: float | None = None,
    latency_ms: float | None = None,
    where: str | None = None,
    progress: Progress = None,
) -> Comparison:
    """Runs the frames of one trace or of several on machines, and compares them with the first.

    ``machines`` are ``Machine``s, names or paths, two at least; ``fps`` is the display rate. With
    ``at_least`` the others must have that many times the frame rate of the first. Areas and
    energies of different technology nodes have ratios only with ``across_nodes``, times and
    energies of different tasks only with ``across_tasks``. ``budget_w``, ``latency_ms`` and
    ``where`` (a condition such as ``"area_mm2.total <= 4"``) are what machines must meet besides
    the display rate.

    Raises ``GoalMissed`` where they have not.
    """
def validate(
    *,
    only: Sequence[str] | None = None,
    quick: bool = True,
    check: bool = False,
    memory: _Memory | None = None,
    progress: Progress = None,
) -> Table:
    """Published numbers beside ours: a row per number, with ``published``, ``ours``, ``deviation``,
    ``tolerance``, ``status`` and ``verdict``; ``evidence/validation.md`` explains them.

    ``only`` are parts of row names; ``quick`` leaves rows out whose scenes take long (a minute is
    left). With ``check`` a row that must hold and does not raises ``GoalMissed``.
    """
def dram(
    requests: _Path | Sequence[tuple[Literal["R", "W"], int, int]],
    *,
    device: str = "lpddr4-3200-x16x8",
    keys: Mapping[str, _Value] | None = None,
    mode: str = "sat",
) -> dict[str, Any]:
    """A memory device alone on a list of requests: time, bandwidth, row hits, latencies, commands and
    energies, as a dictionary with the names of ``powergs-sim dram --json``.

    ``requests`` is the path of an address trace, or a list of ``("R" or "W", address, bytes)``;
    ``device`` a name of ``names("dram")`` or a TOML file, ``keys`` changes of it; ``mode`` says how
    requests arrive (``"sat"``, ``"idle"``, ``"mlp32"``, ``"look16"``, ``"rate20"``).
    """
def optimize(
    scene: Scene,
    cameras: Cameras,
    *,
    photos: Sequence[_Picture] | None = None,
    quality: Literal["H", "M", "L"] | float | None = None,
    machine: Machine | _Path | None = None,
    display: _Path | None = None,
    display_ratio: float | None = None,
    fps: float = 60.0,
    size: _Size | None = None,
    power_size: _Size | None = None,
    rhos: Sequence[float] | None = None,
    baselines: bool = False,
    store: _Path | None = None,
    memory: _Memory | None = None,
    callback: Callable[[dict[str, Any]], object] | None = None,
    progress: Progress = None,
    **settings: Unpack[_Settings],
) -> Optimized:
    """The fewest watts of rendering and display at a given quality: Gaussians are pruned and colours
    dimmed, and the model is fine-tuned until it sits just above the quality.

    Parameters
    ----------
    scene : Scene
        The trained model.
    cameras : Cameras
        Its views; some train, some decide, some are only reported.
    photos : list, optional
        What the views should look like: an array of shape (height, width, 3) or a path for each.
        Another size than that of the camera is averaged down to it, or the camera is scaled to a
        smaller photo; lenses that the camera file names are taken out of them. Without photos the
        model is compared with its own renders.
    quality : str or float, optional
        ``"H"``, ``"M"`` (the default) or ``"L"``, decibels, or with photos a share below 1 of the
        dense model's.
    machine : Machine, str or path
        What rendering costs: a machine, or ``"paper"``, the published closed form.
    display : str or path, optional
        The panel.
    display_ratio : float, optional
        The panel is scaled so that the dense model's display power is so many times that of the
        accelerator.
    fps : float
        Frames shown per second.
    size : (int, int), optional
        Width and height that models train at, pixels, in place of those of the views.
    power_size : (int, int), optional
        Width and height that power is counted and quality measured at, pixels: that of the screen.
        Without it, that of the views, whatever ``size`` says. Where it is larger than ``size``,
        power is a mean over at most 16 views, and at most 24 decide, evenly spaced.
        ``gate_size="trained"`` measures quality at ``size``.
    rhos : list of float, optional
        Shares to prune that are tried, ascending.
    baselines : bool
        Whether the comparisons of the publication are trained as well.
    store : path, optional
        Folder of checkpoints: a run that was interrupted goes on there, bit for bit.
    memory : int or str, optional
        What a frame may take.
    callback : function, optional
        Called with a dictionary for every iteration (``event`` is ``"iteration"``) and every model
        that is made (``"model"``), in their order. An exception of it ends the run.
    progress : bool, function or bar, optional
        As for ``Trace.replay``; counts iterations.
    **settings : int, float or str, optional
        ``iterations`` of a sample, ``final_iterations`` (twice as many), the ``seed`` of the order
        of views; ``first_effort``, ``held_out_iterations``, ``level_effort``, ``interval``,
        ``adjust_share``, ``display_weight`` (the flag ``--lambda``), ``level_display_weight``
        (``--level-lambda``), ``dimming``, ``epsilon_db``, ``opacity_cap``, ``rate_scale``,
        ``rate_end``, ``checkpoint_every``, ``gate``, ``gate_size``. ``powergs-sim optimize
        --help`` says what they are.
    """
def codesign(
    scene: Scene,
    cameras: Cameras,
    space: _Path | Mapping[str, Any],
    *,
    quality: Literal["H", "M", "L"] | float | None = None,
    rounds: int = 5,
    halving: bool = False,
    size: _Size | None = None,
    store: _Path | None = None,
    memory: _Memory | None = None,
    progress: Progress = None,
    **settings: Unpack[_FitSettings],
) -> Codesigned:
    """The model and the machine that need the fewest watts together: every model of a space is
    fine-tuned to the quality once and priced on every machine of it.

    Parameters
    ----------
    scene : Scene
        The trained model. It is compared with its own renders.
    cameras : Cameras
        Its views; some train, some decide, some are only reported.
    space : path or dict
        The space, as a TOML file or the same as a dictionary: axes of the model, axes of the
        machine, the budget.
    quality : str or float, optional
        ``"H"``, ``"M"`` or ``"L"``, or decibels; that of the space's budget, else ``"M"``.
    rounds : int
        Rounds at most in which the machine that was found gives another ratio to try.
    halving : bool
        Fine-tune all models for a part of the iterations first, and only the better ones in full.
    size : (int, int), optional
        Width and height of the views, pixels, in place of their own.
    store : path, optional
        Folder in which models and pairs are kept: a run that was interrupted goes on there, and
        another space makes only what is new.
    memory : int or str, optional
        What binned frames may take.
    progress : bool, function or bar, optional
        As for ``Trace.replay``; counts iterations, then machines times frames.
    **settings : int, optional
        ``iterations`` of a fine-tune at most, ``interval`` between checks of the quality, the
        ``seed`` of the order of views, ``checkpoint_every`` so many iterations.

    Raises ``GoalMissed`` where no model reaches the quality or no pair keeps the budget.
    """
def _sweep_file(
    file: _Path,
    traces: list[str],
    *,
    keys: dict[str, Any] | None = None,
    points: int | None = None,
    dram: str | None = None,
    store: _Path | None = None,
    memory: _Memory | None = None,
    progress: Progress = None,
) -> SweepResult: ...
def _sweep_axes(
    base: Machine,
    axes: dict[str, Any],
    traces: list[Trace],
    *,
    constraints: list[str] | None = None,
    minimize: list[str] | None = None,
    maximize: list[str] | None = None,
    sampling: dict[str, Any] | None = None,
    fps: float = 60.0,
    dram: str | None = None,
    store: _Path | None = None,
    memory: _Memory | None = None,
    progress: Progress = None,
) -> SweepResult: ...
@final
class _Space:
    @staticmethod
    def of_axes(
        base: Machine,
        axes: dict[str, Any],
        constraints: list[str],
        sampling: dict[str, Any] | None,
    ) -> _Space: ...
    @staticmethod
    def of_file(file: _Path, keys: dict[str, Any] | None) -> _Space: ...
    def axes(self) -> list[tuple[str, list[Any]]]: ...
    def point(self, steps: list[int]) -> int: ...
    def points_of_sweep(self) -> list[int]: ...
    def display_fps(self) -> float: ...
    def energy_tables(self) -> list[str]: ...
    def candidate(self, point: int) -> tuple[dict[str, Any] | None, Machine | None, str]: ...
    def base(self) -> Machine: ...
    def __len__(self) -> int: ...

class _Replayed(Protocol):
    """A machine that was replayed by itself."""

    @property
    def point(self) -> int | None: ...
    @property
    def settings(self) -> dict[str, Any]: ...
    @property
    def machine(self) -> Machine | None: ...
    @property
    def outcomes(self) -> list[str]: ...
    @property
    def reason(self) -> str: ...
    @property
    def values(self) -> list[list[float | None]]: ...

def _gathered(
    designs: Sequence[_Replayed], traces: list[str], functions: list[str], fps: float
) -> SweepResult: ...
def _main(words: list[str]) -> int: ...
def _commands() -> str: ...
def _csv(path: _Path) -> Table: ...
def _camera(
    name: str,
    size: list[int],
    intrinsics: list[float],
    rotation: list[float],
    centre: list[float],
    split: str | None,
    eye: str | None,
) -> Camera: ...
def _front(designs: list[list[float]]) -> list[int]: ...
def _table(
    names: list[str],
    kinds: list[str],
    units: dict[str, str],
    definitions: dict[str, str],
    values: dict[str, list[Any]],
) -> Table: ...
def _chart(name: str, title: str, svg: str) -> Chart: ...
def _machine(name: str, files: dict[str, Any]) -> Machine: ...
def _report(json: str, charts: list[Any], html: str, text: str) -> Report: ...

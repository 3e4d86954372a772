"""Every command of the program ``powergs-sim`` as a function.

Written by ``python -P python/stubs.py`` from what the program takes.
"""

import os
from collections.abc import Mapping, Sequence
from typing import Literal, TypeAlias

from ._powergs import Trace
from .program import Folder as Folder
from .program import Outcome as Outcome

_Word: TypeAlias = str | int | float | os.PathLike[str] | Trace
_Value: TypeAlias = int | float | str | bool | Sequence[int | float | str | bool]

WITHOUT_NAME: dict[str, str]

def again(
    folder: _Word,
    *,
    in_: _Word | None = None,
    out: _Word | None = None,
    jobs: _Word | None = None,
    memory: _Word | None = None,
    progress: bool = False,
) -> Outcome:
    """Run the command that made a folder once more, and compare the results."""

def arch_check(
    files: _Word | Sequence[_Word],
    *,
    set: _Word | Sequence[_Word] | Mapping[str, _Value] | None = None,
    jobs: _Word | None = None,
    memory: _Word | None = None,
    progress: bool = False,
) -> Outcome:
    """Check files and report everything that is wrong; exit code 2 if anything is."""

def arch_diff(
    a: _Word,
    b: _Word,
    *,
    jobs: _Word | None = None,
    memory: _Word | None = None,
    progress: bool = False,
) -> Outcome:
    """Print the keys in which two files of one kind differ."""

def arch_list(
    *,
    jobs: _Word | None = None,
    memory: _Word | None = None,
    progress: bool = False,
) -> Outcome:
    """List the machines, tables, displays, DRAM devices, sweeps and synthetic scenes that come with the program."""

def arch_schema(
    kind: Literal["machine", "energy", "display", "dram", "sweep", "synth"] | None = None,
    *,
    report: bool = False,
    jobs: _Word | None = None,
    memory: _Word | None = None,
    progress: bool = False,
) -> Outcome:
    """Print the JSON schema of a kind of file."""

def arch_show(
    arch: _Word,
    *,
    set: _Word | Sequence[_Word] | Mapping[str, _Value] | None = None,
    resolved: bool = False,
    cost: bool = False,
    figure: bool = False,
    output: _Word | None = None,
    force: bool = False,
    chart_size: _Word | None = None,
    no_title: bool = False,
    chart_format: Literal["svg", "png", "pdf"] | Sequence[Literal["svg", "png", "pdf"]] | None = None,
    jobs: _Word | None = None,
    memory: _Word | None = None,
    progress: bool = False,
) -> Outcome:
    """Print a file; with --resolved all of its keys, with --set as a run would use it."""

def camera_convert(
    *,
    output: _Word | None = None,
    force: bool = False,
    cameras: _Word | None = None,
    orbit: _Word | None = None,
    orbit_elevation: _Word | None = None,
    orbit_radius: _Word | None = None,
    orbit_fov: _Word | None = None,
    orbit_up: Literal["x", "y", "z", "-x", "-y", "-z"] | None = None,
    split: Literal["train", "test"] | None = None,
    every: _Word | None = None,
    path_frames: _Word | None = None,
    frames: _Word | None = None,
    size: _Word | None = None,
    stereo: _Word | None = None,
    fov: _Word | None = None,
    headset: _Word | None = None,
    jobs: _Word | None = None,
    memory: _Word | None = None,
    progress: bool = False,
) -> Outcome:
    """Write the views that the camera flags ask for as an INRIA cameras.json."""

def camera_info(
    file: _Word,
    *,
    size: _Word | None = None,
    jobs: _Word | None = None,
    memory: _Word | None = None,
    progress: bool = False,
) -> Outcome:
    """Print how many views a file has, their sizes and fields of view, and warnings."""

def certificate(
    arch: _Word,
    *,
    output: _Word | None = None,
    force: bool = False,
    jobs: _Word | None = None,
    memory: _Word | None = None,
    progress: bool = False,
) -> Outcome:
    """Say what numbers of a machine rest on: files, prices, assumptions, published numbers."""

def codesign(
    model: _Word | None = None,
    *,
    demo: bool = False,
    detail: _Word | None = None,
    axes: _Word | None = None,
    space: _Word | None = None,
    resume: bool = False,
    force: bool = False,
    shard: _Word | None = None,
    slurm: _Word | None = None,
    dry_run: bool = False,
    print: bool = False,
    cameras: _Word | None = None,
    orbit: _Word | None = None,
    every: _Word | None = None,
    background: _Word | None = None,
    validation: _Word | None = None,
    size: _Word | None = None,
    power_size: _Word | None = None,
    power_cameras: _Word | None = None,
    power_stereo: _Word | None = None,
    quality: Literal["h", "m", "l"] | None = None,
    quality_db: _Word | None = None,
    quality_ssim: _Word | None = None,
    iterations: _Word | None = None,
    halving: bool = False,
    rounds: _Word | None = None,
    interval: _Word | None = None,
    seed: _Word | None = None,
    checkpoint_every: _Word | None = None,
    chart_size: _Word | None = None,
    no_title: bool = False,
    chart_format: Literal["svg", "png", "pdf"] | Sequence[Literal["svg", "png", "pdf"]] | None = None,
    out: _Word | None = None,
    jobs: _Word | None = None,
    memory: _Word | None = None,
    progress: bool = False,
) -> Outcome:
    """Search a model and a machine together: the fewest watts at a given quality."""

def compare(
    items: _Word | Sequence[_Word] | None = None,
    *,
    workloads: _Word | Sequence[_Word] | None = None,
    all_machines: bool = False,
    set: _Word | Sequence[_Word] | Mapping[str, _Value] | None = None,
    fps: _Word | None = None,
    latency: _Word | None = None,
    frames: _Word | None = None,
    budget: _Word | None = None,
    where: _Word | None = None,
    across_nodes: bool = False,
    common: bool = False,
    across_tasks: bool = False,
    at_least: _Word | None = None,
    table: Literal["tex", "csv", "md"] | None = None,
    ablate: _Word | Sequence[_Word] | None = None,
    out: _Word | None = None,
    force: bool = False,
    display: _Word | None = None,
    charts: Literal["decision", "power", "cycles", "breakdown", "speedup", "steps"] | Sequence[Literal["decision", "power", "cycles", "breakdown", "speedup", "steps"]] | None = None,
    chart_size: _Word | None = None,
    no_title: bool = False,
    chart_format: Literal["svg", "png", "pdf"] | Sequence[Literal["svg", "png", "pdf"]] | None = None,
    jobs: _Word | None = None,
    memory: _Word | None = None,
    progress: bool = False,
) -> Outcome:
    """Compare machines on the same trace, or finished reports, side by side."""

def display(
    image: _Word,
    *,
    preset: _Word | None = None,
    background: _Word | None = None,
    jobs: _Word | None = None,
    memory: _Word | None = None,
    progress: bool = False,
) -> Outcome:
    """Report the power that a picture takes on a display."""

def dram(
    trace: _Word,
    *,
    device: _Word | None = None,
    mode: _Word | None = None,
    mapping: Literal["RoBaCoCh", "mop", "bg64"] | None = None,
    set: _Word | Sequence[_Word] | Mapping[str, _Value] | None = None,
    jobs: _Word | None = None,
    memory: _Word | None = None,
    progress: bool = False,
) -> Outcome:
    """Run a trace of addresses on a memory device alone."""

def explain(
    name: _Word,
    *,
    jobs: _Word | None = None,
    memory: _Word | None = None,
    progress: bool = False,
) -> Outcome:
    """Define a statistic, key, column, assumption, source or term."""

def extract(
    scene: _Word,
    *,
    output: _Word | None = None,
    force: bool = False,
    detail: _Word | None = None,
    axes: _Word | None = None,
    background: _Word | None = None,
    cameras: _Word | None = None,
    orbit: _Word | None = None,
    orbit_elevation: _Word | None = None,
    orbit_radius: _Word | None = None,
    orbit_fov: _Word | None = None,
    orbit_up: Literal["x", "y", "z", "-x", "-y", "-z"] | None = None,
    split: Literal["train", "test"] | None = None,
    every: _Word | None = None,
    path_frames: _Word | None = None,
    frames: _Word | None = None,
    size: _Word | None = None,
    stereo: _Word | None = None,
    fov: _Word | None = None,
    headset: _Word | None = None,
    gaze: _Word | None = None,
    gaze_cycle: _Word | None = None,
    gaze_stream: _Word | None = None,
    gaze_rate: _Word | None = None,
    gaze_gap: _Word | None = None,
    eye: Literal["left", "right"] | None = None,
    screen: _Word | None = None,
    pooling_rate: _Word | None = None,
    order: Literal["storage", "morton", "hilbert", "opacity"] | None = None,
    jobs: _Word | None = None,
    memory: _Word | None = None,
    progress: bool = False,
) -> Outcome:
    """Render a scene and record a trace of it."""

def filter(
    image: _Word,
    *,
    preset: _Word | None = None,
    background: _Word | None = None,
    gaze: _Word | None = None,
    fov: _Word | None = None,
    output: _Word | None = None,
    force: bool = False,
    jobs: _Word | None = None,
    memory: _Word | None = None,
    progress: bool = False,
) -> Outcome:
    """Apply the foveated colour filter D22 to a picture."""

def fit(
    samples: _Word,
    *,
    output: _Word | None = None,
    force: bool = False,
    chart_size: _Word | None = None,
    no_title: bool = False,
    chart_format: Literal["svg", "png", "pdf"] | Sequence[Literal["svg", "png", "pdf"]] | None = None,
    jobs: _Word | None = None,
    memory: _Word | None = None,
    progress: bool = False,
) -> Outcome:
    """Fit power curves to samples that reach a quality and find their minimum."""

def optimize(
    model: _Word | None = None,
    *,
    demo: bool = False,
    detail: _Word | None = None,
    axes: _Word | None = None,
    out: _Word | None = None,
    resume: bool = False,
    force: bool = False,
    reprice: _Word | None = None,
    realise: bool = False,
    dry_run: bool = False,
    keep: Literal["needed", "all"] | None = None,
    images: _Word | None = None,
    least_likeness: _Word | None = None,
    reference: Literal["self"] | None = None,
    train_on_validation: bool = False,
    least_gate: _Word | None = None,
    cameras: _Word | None = None,
    orbit: _Word | None = None,
    every: _Word | None = None,
    background: _Word | None = None,
    validation: _Word | None = None,
    size: _Word | None = None,
    quality: _Word | None = None,
    quality_db: _Word | None = None,
    quality_ssim: _Word | None = None,
    arch: _Word | None = None,
    set: _Word | Sequence[_Word] | Mapping[str, _Value] | None = None,
    energy: _Word | None = None,
    oracle: Literal["paper", "cycle"] | None = None,
    display: _Word | None = None,
    display_ratio: _Word | None = None,
    fps: _Word | None = None,
    train_on: _Word | None = None,
    power_size: _Word | None = None,
    power_cameras: _Word | None = None,
    power_stereo: _Word | None = None,
    power_views: _Word | None = None,
    path_frames: _Word | None = None,
    rhos: _Word | Sequence[_Word] | None = None,
    schedule: Literal["five", "published"] | None = None,
    lpips_weights: _Word | None = None,
    baselines: bool = False,
    baseline: _Word | Sequence[_Word] | None = None,
    study: Literal["ratio", "lambda"] | Sequence[Literal["ratio", "lambda"]] | None = None,
    foveated: bool = False,
    screen: _Word | None = None,
    pooling_rate: _Word | None = None,
    filter_flops: _Word | None = None,
    iterations: _Word | None = None,
    held_out_iterations: _Word | None = None,
    first_effort: _Word | None = None,
    final_iterations: _Word | None = None,
    level_effort: _Word | None = None,
    interval: _Word | None = None,
    adjust_share: _Word | None = None,
    lambda_: _Word | None = None,
    level_lambda: _Word | None = None,
    dimming: Literal["gains", "damped", "published"] | None = None,
    epsilon_db: _Word | None = None,
    opacity_cap: _Word | None = None,
    rate_scale: _Word | None = None,
    rate_end: _Word | None = None,
    seed: _Word | None = None,
    checkpoint_every: _Word | None = None,
    gate: Literal["validation", "test"] | None = None,
    gate_size: Literal["priced", "trained"] | None = None,
    chart_size: _Word | None = None,
    no_title: bool = False,
    chart_format: Literal["svg", "png", "pdf"] | Sequence[Literal["svg", "png", "pdf"]] | None = None,
    jobs: _Word | None = None,
    memory: _Word | None = None,
    progress: bool = False,
) -> Outcome:
    """Minimise power at a given quality: prune and fine-tune a trained model."""

def pack(
    folder: _Word,
    *,
    output: _Word | None = None,
    in_: _Word | None = None,
    force: bool = False,
    jobs: _Word | None = None,
    memory: _Word | None = None,
    progress: bool = False,
) -> Outcome:
    """Pack a finished folder with the files that its command reads into one archive."""

def pareto(
    folder: _Word,
    *,
    minimize: _Word | Sequence[_Word] | None = None,
    maximize: _Word | Sequence[_Word] | None = None,
    where: _Word | None = None,
    budget: _Word | None = None,
    scope: _Word | None = None,
    energy_table: _Word | None = None,
    colour: _Word | None = None,
    design: _Word | None = None,
    include_misses: bool = False,
    epsilon: _Word | None = None,
    top: _Word | None = None,
    out: _Word | None = None,
    csv: _Word | None = None,
    force: bool = False,
    chart_size: _Word | None = None,
    no_title: bool = False,
    chart_format: Literal["svg", "png", "pdf"] | Sequence[Literal["svg", "png", "pdf"]] | None = None,
    jobs: _Word | None = None,
    memory: _Word | None = None,
    progress: bool = False,
) -> Outcome:
    """Analyse a sweep: Pareto front, knee, marginal values, stability."""

def quality(
    picture: _Word,
    reference: _Word,
    *,
    hvsq: _Word | Sequence[_Word] | None = None,
    gaze: _Word | None = None,
    fov: _Word | None = None,
    pixels_per_degree: _Word | None = None,
    lpips_weights: _Word | None = None,
    background: _Word | None = None,
    jobs: _Word | None = None,
    memory: _Word | None = None,
    progress: bool = False,
) -> Outcome:
    """Compare two pictures: PSNR, SSIM, FLIP, HVSQ."""

def render(
    scene: _Word,
    *,
    output: _Word | None = None,
    force: bool = False,
    detail: _Word | None = None,
    axes: _Word | None = None,
    background: _Word | None = None,
    cameras: _Word | None = None,
    orbit: _Word | None = None,
    orbit_elevation: _Word | None = None,
    orbit_radius: _Word | None = None,
    orbit_fov: _Word | None = None,
    orbit_up: Literal["x", "y", "z", "-x", "-y", "-z"] | None = None,
    split: Literal["train", "test"] | None = None,
    every: _Word | None = None,
    path_frames: _Word | None = None,
    frames: _Word | None = None,
    size: _Word | None = None,
    stereo: _Word | None = None,
    fov: _Word | None = None,
    headset: _Word | None = None,
    gaze: _Word | None = None,
    gaze_cycle: _Word | None = None,
    gaze_stream: _Word | None = None,
    gaze_rate: _Word | None = None,
    gaze_gap: _Word | None = None,
    eye: Literal["left", "right"] | None = None,
    screen: _Word | None = None,
    pooling_rate: _Word | None = None,
    frame: _Word | None = None,
    levels: bool = False,
    order: _Word | None = None,
    pixels: _Word | None = None,
    arch: _Word | None = None,
    set: _Word | Sequence[_Word] | Mapping[str, _Value] | None = None,
    weight_power: _Word | None = None,
    jobs: _Word | None = None,
    memory: _Word | None = None,
    progress: bool = False,
) -> Outcome:
    """Render views of a scene to PNG."""

def replay(
    trace: _Word,
    *,
    arch: _Word | None = None,
    set: _Word | Sequence[_Word] | Mapping[str, _Value] | None = None,
    energy: _Word | None = None,
    model: Literal["paper", "cycle"] | None = None,
    fps: _Word | None = None,
    latency: _Word | None = None,
    frames: _Word | None = None,
    display: _Word | None = None,
    reference_padding: bool = False,
    dram_model: Literal["bandwidth", "calibrated", "banked", "both"] | None = None,
    what_if: _Word | None = None,
    timeline: _Word | None = None,
    dump_dram: _Word | None = None,
    out: _Word | None = None,
    force: bool = False,
    chart_size: _Word | None = None,
    no_title: bool = False,
    chart_format: Literal["svg", "png", "pdf"] | Sequence[Literal["svg", "png", "pdf"]] | None = None,
    jobs: _Word | None = None,
    memory: _Word | None = None,
    progress: bool = False,
) -> Outcome:
    """Simulate a trace on a machine: frame rate, stalls, energy, power."""

def scene_compose(
    levels: _Word | Sequence[_Word],
    *,
    detail: _Word | None = None,
    axes: _Word | None = None,
    output: _Word | None = None,
    force: bool = False,
    jobs: _Word | None = None,
    memory: _Word | None = None,
    progress: bool = False,
) -> Outcome:
    """Combine four levels into one foveated model (.fov)."""

def scene_convert(
    file: _Word,
    output: _Word,
    *,
    format: Literal["ply", "compressed-ply", "spz", "gltf", "glb", "glb-spz", "sog", "sog-folder"] | None = None,
    force: bool = False,
    detail: _Word | None = None,
    axes: _Word | None = None,
    order: Literal["storage", "morton", "hilbert", "opacity"] | None = None,
    jobs: _Word | None = None,
    memory: _Word | None = None,
    progress: bool = False,
) -> Outcome:
    """Write a model of any format as INRIA PLY, compressed PLY, SPZ, glTF or SOG."""

def scene_info(
    file: _Word,
    *,
    detail: _Word | None = None,
    axes: _Word | None = None,
    jobs: _Word | None = None,
    memory: _Word | None = None,
    progress: bool = False,
) -> Outcome:
    """Print count, bounds, percentiles of opacity and scale, and warnings."""

def scene_level(
    file: _Word,
    *,
    level: _Word | None = None,
    output: _Word | None = None,
    force: bool = False,
    jobs: _Word | None = None,
    memory: _Word | None = None,
    progress: bool = False,
) -> Outcome:
    """Write a level of a foveated model as INRIA PLY."""

def sensitivity(
    arch: _Word,
    traces: _Word | Sequence[_Word],
    *,
    set: _Word | Sequence[_Word] | Mapping[str, _Value] | None = None,
    energy: _Word | None = None,
    dram_model: Literal["bandwidth", "calibrated", "banked"] | None = None,
    keys: _Word | Sequence[_Word] | None = None,
    step: _Word | None = None,
    fps: _Word | None = None,
    latency: _Word | None = None,
    frames: _Word | None = None,
    interactions: Literal["morris", "sobol"] | None = None,
    samples: _Word | None = None,
    seed: _Word | None = None,
    assumptions: bool = False,
    only: _Word | Sequence[_Word] | None = None,
    csv: _Word | None = None,
    out: _Word | None = None,
    force: bool = False,
    chart_size: _Word | None = None,
    no_title: bool = False,
    chart_format: Literal["svg", "png", "pdf"] | Sequence[Literal["svg", "png", "pdf"]] | None = None,
    jobs: _Word | None = None,
    memory: _Word | None = None,
    progress: bool = False,
) -> Outcome:
    """Vary every parameter, or every assumption, and report the effect."""

def sweep_merge(
    folder: _Word,
    *,
    from_: _Word | Sequence[_Word] | None = None,
    confirm: _Word | None = None,
    chart_size: _Word | None = None,
    no_title: bool = False,
    chart_format: Literal["svg", "png", "pdf"] | Sequence[Literal["svg", "png", "pdf"]] | None = None,
    jobs: _Word | None = None,
    memory: _Word | None = None,
    progress: bool = False,
) -> Outcome:
    """Put the parts of a sweep together (after --shard)."""

def sweep_show(
    id: _Word,
    folder: _Word,
    *,
    toml: bool = False,
    jobs: _Word | None = None,
    memory: _Word | None = None,
    progress: bool = False,
) -> Outcome:
    """Show one design of a sweep: its values, its machine file."""

def sweep_status(
    folder: _Word,
    *,
    jobs: _Word | None = None,
    memory: _Word | None = None,
    progress: bool = False,
) -> Outcome:
    """Say how much of a sweep is done."""

def sweep(
    file: _Word,
    *,
    traces: _Word | Sequence[_Word] | None = None,
    frames: _Word | None = None,
    set: _Word | Sequence[_Word] | Mapping[str, _Value] | None = None,
    fps: _Word | None = None,
    display: _Word | None = None,
    points: _Word | None = None,
    dram_model: Literal["bandwidth", "calibrated", "banked"] | None = None,
    resume: bool = False,
    force: bool = False,
    dry_run: bool = False,
    shard: _Word | None = None,
    store: _Word | None = None,
    confirm: _Word | None = None,
    slurm: _Word | None = None,
    print: bool = False,
    chart_size: _Word | None = None,
    no_title: bool = False,
    chart_format: Literal["svg", "png", "pdf"] | Sequence[Literal["svg", "png", "pdf"]] | None = None,
    out: _Word | None = None,
    jobs: _Word | None = None,
    memory: _Word | None = None,
    progress: bool = False,
) -> Outcome:
    """Simulate many designs on some traces: a table of results."""

def synth(
    preset: _Word | None = None,
    *,
    list: bool = False,
    output: _Word | None = None,
    cameras: _Word | None = None,
    force: bool = False,
    points: _Word | None = None,
    seed: _Word | None = None,
    check: bool = False,
    check_views: _Word | None = None,
    jobs: _Word | None = None,
    memory: _Word | None = None,
    progress: bool = False,
) -> Outcome:
    """Make a synthetic scene that behaves like a trained one."""

def trace_dump(
    file: _Word,
    *,
    frame: _Word | None = None,
    what: Literal["splats", "pixels", "facts"] | None = None,
    output: _Word | None = None,
    force: bool = False,
    jobs: _Word | None = None,
    memory: _Word | None = None,
    progress: bool = False,
) -> Outcome:
    """Write one frame as CSV."""

def trace_info(
    file: _Word,
    *,
    all: bool = False,
    jobs: _Word | None = None,
    memory: _Word | None = None,
    progress: bool = False,
) -> Outcome:
    """Print header, frames, and what a visible splat and a pixel take on disk."""

def trace_repair(
    file: _Word,
    *,
    output: _Word | None = None,
    force: bool = False,
    jobs: _Word | None = None,
    memory: _Word | None = None,
    progress: bool = False,
) -> Outcome:
    """Write the intact frames of a damaged or unfinished trace as a new one."""

def trace_verify(
    file: _Word,
    *,
    jobs: _Word | None = None,
    memory: _Word | None = None,
    progress: bool = False,
) -> Outcome:
    """Check every byte and every value; list what is damaged."""

def train(
    photos: _Word,
    *,
    output: _Word | None = None,
    force: bool = False,
    cameras: _Word | None = None,
    size: _Word | None = None,
    hold_out: _Word | None = None,
    background: _Word | None = None,
    points: _Word | None = None,
    init: _Word | None = None,
    cube: _Word | None = None,
    iterations: _Word | None = None,
    seed: _Word | None = None,
    max_points: _Word | None = None,
    sh_degree: _Word | None = None,
    sh_every: _Word | None = None,
    position_rate: _Word | None = None,
    position_rate_end: _Word | None = None,
    sh_rate: _Word | None = None,
    opacity_rate: _Word | None = None,
    scale_rate: _Word | None = None,
    rotation_rate: _Word | None = None,
    densify_from: _Word | None = None,
    densify_until: _Word | None = None,
    densify_every: _Word | None = None,
    densify_slope: _Word | None = None,
    split_scale: _Word | None = None,
    prune_opacity: _Word | None = None,
    prune_scale: _Word | None = None,
    prune_radius: _Word | None = None,
    reset_every: _Word | None = None,
    trace_every: _Word | None = None,
    traces: _Word | None = None,
    trace_views: _Word | None = None,
    checkpoint: _Word | None = None,
    resume: bool = False,
    report_every: _Word | None = None,
    jobs: _Word | None = None,
    memory: _Word | None = None,
    progress: bool = False,
) -> Outcome:
    """Train a model from photos with poses, by the published rules of 3DGS."""

def validate(
    *,
    only: _Word | Sequence[_Word] | None = None,
    quick: bool = False,
    rows: _Word | None = None,
    scenes: _Word | None = None,
    write: _Word | None = None,
    check: _Word | None = None,
    force: bool = False,
    bless: bool = False,
    jobs: _Word | None = None,
    memory: _Word | None = None,
    progress: bool = False,
) -> Outcome:
    """Check the simulator against published numbers."""

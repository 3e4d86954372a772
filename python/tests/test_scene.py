"""Scenes, cameras, pictures, extraction: the same bytes as the program."""

from __future__ import annotations

import json
import pickle

import numpy as np
import pytest

import powergs


@pytest.fixture(scope="module")
def made() -> tuple[powergs.Scene, powergs.Cameras]:
    scene, cameras = powergs.synth("demo", points=3000, seed=7)
    return scene, cameras.select(every=12, size=(96, 64))


@pytest.fixture(scope="module")
def picture(made) -> np.ndarray:
    return made[0].render(made[1][0])


def test_synth_writes_the_programs_files(run, tmp_path) -> None:
    scene, cameras = powergs.synth("demo", points=3000, seed=7)
    scene.save(tmp_path / "ours.ply")
    cameras.save(tmp_path / "ours.json")
    run(
        *("synth", "demo", "--points", 3000, "--seed", 7, "-o", tmp_path / "its.ply"),
        *("--cameras", tmp_path / "its.json", "--quiet"),
    )
    for ending in ["ply", "json"]:
        its = (tmp_path / f"its.{ending}").read_bytes()
        assert (tmp_path / f"ours.{ending}").read_bytes() == its


@pytest.mark.parametrize("preset", ["demo", "lego"])
def test_two_scenes_from_file_to_report(preset, run, tmp_path) -> None:
    """Extraction and replay, byte for byte."""
    scene, cameras = powergs.synth(preset, points=4000)
    scene.save(tmp_path / "scene.ply")
    cameras.save(tmp_path / "cameras.json")
    scene = powergs.Scene.open(tmp_path / "scene.ply")
    views = powergs.Cameras.open(tmp_path / "cameras.json").select(every=50, size=(160, 120))
    order = {"demo": "hilbert", "lego": "storage"}[preset]
    ours = scene.extract(views, path=tmp_path / "scene.bin", progress=True, order=order)
    its = tmp_path / "its" / "scene.bin"
    its.parent.mkdir()
    run(
        *("extract", tmp_path / "scene.ply", "--cameras", tmp_path / "cameras.json"),
        *("--every", 50, "--size", "160x120", "-o", its, "--quiet"),
        *("--order", order),
    )
    assert (tmp_path / "scene.bin").read_bytes() == its.read_bytes()
    printed = run("replay", its, "--json", "--what-if", 0, "--out", tmp_path / "report")
    assert ours.replay("gscore").to_json() == printed
    memory = scene.extract(views, order=order).replay("gscore")
    for name in ["frame_time_ms", "energy_pj.total", "display_power_w", "frame_cycles"]:
        assert memory.frames[name] == ours.replay("gscore").frames[name]


def test_a_render_is_an_array_that_owns_its_pixels(picture) -> None:
    assert picture.shape == (64, 96, 3) and picture.dtype == np.float32
    assert picture.flags.c_contiguous and picture.flags.writeable
    assert 0.05 < picture.max() and np.isfinite(picture).all()
    # The memory is the renderer's: the array's base is what frees it, and no other array.
    base = picture.base
    while isinstance(base, np.ndarray):
        base = base.base
    assert "Container" in type(base).__name__


@pytest.mark.parametrize("name", ["a.ply", "a.compressed.ply", "a.spz", "a.gltf", "a.glb", "a.sog"])
def test_save_writes_what_the_name_says(name, made, run, tmp_path) -> None:
    """The bytes of `scene convert`, and never another format under a name."""
    scene, _ = made
    scene.save(tmp_path / "model.ply")
    kept = scene.save(tmp_path / name)
    its = tmp_path / "its" / name
    its.parent.mkdir()
    printed = json.loads(run("scene", "convert", tmp_path / "model.ply", its, "--json"))
    assert (tmp_path / name).read_bytes() == its.read_bytes()
    assert kept == printed["kept"]
    assert kept["position"]["exact"] == (name in {"a.ply", "a.gltf", "a.glb"})


def test_save_refuses_other_names(made, tmp_path) -> None:
    scene, _ = made
    for name in ["a.ksplat", "a", "meta.json", "a.png"]:
        with pytest.raises(powergs.ConfigError, match="no format that is written"):
            scene.save(tmp_path / name)
    with pytest.raises(powergs.ConfigError, match="one of ply"):
        scene.save(tmp_path / "a.ply", format="sog-folder")
    scene.save(tmp_path / "a.bin", format="spz")
    assert powergs.Scene.open(tmp_path / "a.bin").format == "spz v3"
    assert [path.name for path in tmp_path.iterdir()] == ["a.bin"]


def test_a_render_is_the_programs_png(made, run, tmp_path) -> None:
    scene, cameras = made
    scene.save(tmp_path / "scene.ply")
    cameras.save(tmp_path / "cameras.json")
    run(
        *("render", tmp_path / "scene.ply", "--cameras", tmp_path / "cameras.json"),
        *("--background", "white", "--frame", 1, "-o", tmp_path / "its.png", "--quiet"),
    )
    ours = scene.render(cameras[1], background="white")
    rounded = np.floor(np.clip(ours, 0, 1) * 255 + 0.5).astype(np.uint8)
    assert powergs.quality(rounded, tmp_path / "its.png")["psnr_db"] is None


def test_stats_are_the_programs(made, run, tmp_path) -> None:
    made[0].save(tmp_path / "scene.ply")
    scene = powergs.Scene.open(tmp_path / "scene.ply")
    its = json.loads(run("scene", "info", tmp_path / "scene.ply", "--json"))
    ours = scene.stats()
    assert len(scene) == ours["points"] == 3000 and scene.sh_degree == 3
    del its["warnings"], ours["warnings"]
    assert its.pop("format") == scene.format and its == ours


def test_cameras_orbit_and_path(made) -> None:
    scene, cameras = made
    orbit = powergs.Cameras.orbit(scene, 8, elevation=30, size=(40, 30))
    assert len(orbit) == 8 and orbit[0].size == (40, 30) and orbit[-1].name == orbit[7].name
    assert len(orbit[::3]) == 3 and len(orbit[::-1]) == 8 and len(list(orbit)) == 8
    assert len(cameras.path(20)) == 20
    pairs = orbit.select(stereo=0.06)
    assert [c.name.rsplit("_")[-1] for c in pairs[:2]] == ["left", "right"]
    distance = np.linalg.norm(np.subtract(pairs[0].position, pairs[1].position))
    assert distance == pytest.approx(0.06)
    assert orbit[0].resized(10, 10).size == (10, 10)


def test_quality_and_display_power_are_the_programs(made, run, tmp_path) -> None:
    scene, cameras = made
    scene.save(tmp_path / "scene.ply")
    cameras.save(tmp_path / "cameras.json")
    words = ("render", tmp_path / "scene.ply", "--cameras", tmp_path / "cameras.json", "--quiet")
    for frame in [0, 1]:
        run(*words, "--frame", frame, "-o", tmp_path / f"{frame}.png")
    a, b = tmp_path / "0.png", tmp_path / "1.png"
    its = json.loads(run("quality", a, b, "--json"))
    ours = powergs.quality(a, b)
    assert ours == {name: its[name] for name in ours}
    its = json.loads(run("display", a, "--json"))
    ours = powergs.display_power(a)
    assert {**ours, "mean_linear_rgb": list(ours["mean_linear_rgb"])} == {
        name: its[name] for name in ours
    }


def test_arrays_of_any_layout(picture) -> None:
    flipped = picture[:, ::-1]
    assert powergs.quality(picture, picture.astype(np.float64))["psnr_db"] is None
    assert powergs.quality(flipped, np.ascontiguousarray(flipped))["psnr_db"] is None
    assert powergs.quality(np.asfortranarray(picture), picture)["psnr_db"] is None
    eight = np.floor(np.clip(picture, 0, 1) * 255 + 0.5).astype(np.uint8)
    assert powergs.quality(eight, picture)["psnr_db"] > 45
    assert powergs.display_power(eight)["power_w"] == powergs.display_power(picture)["power_w"]


@pytest.mark.parametrize(
    "array",
    [
        np.zeros((4, 4)),
        np.zeros((4, 4, 4)),
        np.zeros((3, 4, 4)),
        np.zeros((0, 4, 3)),
        np.zeros((4, 0, 3)),
        np.full((4, 4, 3), np.nan),
        np.full((4, 4, 3), np.inf),
        np.zeros((4, 4, 3), np.int32),
        np.zeros((4, 4, 3), complex),
        np.zeros((4, 4, 3), object),
        np.zeros((4, 4, 3), "U3"),
        np.lib.stride_tricks.as_strided(np.zeros(3, np.float32), (1 << 16, 4, 3), (0, 0, 4)),
    ],
)
def test_arrays_that_are_no_picture(array) -> None:
    with pytest.raises(powergs.InputError):
        powergs.display_power(array)
    with pytest.raises(powergs.InputError):
        powergs.quality(array, np.zeros((4, 4, 3)))


def test_things_that_are_no_picture(picture, tmp_path) -> None:
    for thing in [3, None, [1, 2], b"png"]:
        with pytest.raises(TypeError):
            powergs.display_power(thing)
    with pytest.raises(powergs.InputError, match="one size"):
        powergs.quality(picture, picture[1:])
    (tmp_path / "a.png").write_bytes(b"\x89PNG\r\n\x1a\n")
    for path in [tmp_path / "a.png", tmp_path, tmp_path / "nosuch.png"]:
        with pytest.raises(powergs.InputError) as raised:
            powergs.display_power(path)
        assert raised.value.file == str(path)
    with pytest.raises(powergs.ConfigError, match="oled-powergs"):
        powergs.display_power(picture, "oled-powergz")
    with pytest.raises(powergs.ConfigError):
        powergs.quality(picture, picture, pixels_per_degree=float("nan"))


def test_scenes_and_views_out_of_range(made, tmp_path) -> None:
    scene, cameras = made
    for size in [(0, 4), (4, 0), (1 << 20, 4)]:
        with pytest.raises(powergs.ConfigError, match="size"):
            scene.render(cameras[0], size=size)
        with pytest.raises(powergs.ConfigError, match="size"):
            scene.extract(cameras, size=size)
    for size in [(-1, 4), (1 << 40, 4)]:
        with pytest.raises((OverflowError, TypeError)):
            scene.render(cameras[0], size=size)
    for colour in ["red", (2, 0, 0), (0, 0, float("nan")), (0, -1, 0)]:
        with pytest.raises(powergs.ConfigError, match="background"):
            scene.render(cameras[0], background=colour)
    with pytest.raises(powergs.ConfigError, match="memory="):
        scene.render(cameras[0], size=(9000, 9000))
    with pytest.raises(powergs.ConfigError, match="memory"):
        scene.extract(cameras, memory="1 kB")
    with pytest.raises(powergs.ConfigError, match="storage, morton, hilbert, opacity"):
        scene.extract(cameras, order="random")
    for orbit in [{"views": 0}, {"views": 1 << 40}, {"fov": 180.0}, {"elevation": float("nan")}]:
        with pytest.raises(powergs.ConfigError):
            powergs.Cameras.orbit(scene, **{"views": 2, **orbit})
    for orbit in [{"radius": -1.0}, {"radius": float("nan")}, {"up": "w"}]:
        with pytest.raises(powergs.ConfigError):
            powergs.Cameras.orbit(scene, 2, **orbit)
    for part in [{"split": "x"}, {"every": 0}, {"stereo": -1.0}]:
        with pytest.raises(powergs.ConfigError):
            cameras.select(**part)
    with pytest.raises(powergs.ConfigError, match="frames"):
        cameras.path(0)
    with pytest.raises(IndexError):
        cameras[len(cameras)]
    with pytest.raises(powergs.ConfigError, match="no view"):
        cameras[5:5]
    with pytest.raises(powergs.ConfigError, match="points"):
        powergs.synth("demo", points=0)
    with pytest.raises(powergs.ConfigError, match="lego"):
        powergs.synth("legos")
    (tmp_path / "a.ply").write_bytes(b"ply\nformat ascii 1.0\n")
    for path in [tmp_path / "a.ply", tmp_path / "nosuch.ply", tmp_path]:
        for opens in [powergs.Scene.open, powergs.Cameras.open]:
            with pytest.raises(powergs.InputError) as raised:
                opens(path)
            assert str(path) in str(raised.value)


def test_a_closed_scene_says_so(tmp_path) -> None:
    with powergs.synth("demo", points=100)[0] as scene:
        cameras = powergs.Cameras.orbit(scene, 2, size=(16, 16))
        trace = scene.extract(cameras)
    uses = [scene.stats, lambda: scene.render(cameras[0]), lambda: scene.extract(cameras)]
    for use in [*uses, lambda: scene.save(tmp_path / "a.ply"), lambda: len(scene)]:
        with pytest.raises(ValueError, match="closed"):
            use()
    assert len(trace) == 2 and trace.path is None
    with pytest.raises(TypeError, match="pickle"):
        pickle.dumps(scene)


def test_files_that_cannot_be_written_leave_nothing(made, tmp_path) -> None:
    scene, cameras = made
    place = tmp_path / "nowhere" / "a.ply"
    writes = [lambda: scene.save(place), lambda: cameras.save(place)]
    for write in [*writes, lambda: scene.extract(cameras, path=place)]:
        with pytest.raises(OSError):
            write()
    assert list(tmp_path.iterdir()) == []

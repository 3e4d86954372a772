"""Scenes and cameras of arrays: what trainers have in memory."""

from __future__ import annotations

import pickle

import numpy as np
import pytest

import powergs


@pytest.fixture(scope="module")
def made():  # type: ignore[no-untyped-def]
    return powergs.synth("lego", points=2000)


def test_arrays_there_and_back(made) -> None:
    scene, cameras = made
    arrays = scene.to_arrays()
    assert {name: array.shape for name, array in arrays.items()} == {
        "means": (2000, 3),
        "quats": (2000, 4),
        "scales": (2000, 3),
        "opacities": (2000,),
        "sh": (2000, (scene.sh_degree + 1) ** 2, 3),
    }
    again = powergs.Scene.from_arrays(**arrays)
    assert len(again) == 2000 and again.sh_degree == scene.sh_degree
    view = cameras[0].resized(96, 96)
    assert np.abs(again.render(view) - scene.render(view)).max() < 1e-4
    for name, array in again.to_arrays().items():
        np.testing.assert_allclose(array, arrays[name], rtol=1e-5, atol=1e-6)


def test_the_colour_of_a_coefficient_goes_to_its_channel() -> None:
    sh = np.zeros((1, 1, 3))
    sh[0, 0] = [1.0, -1.0, 0.5]
    scene = powergs.Scene.from_arrays(
        means=[[0.0, 0.0, 2.0]], quats=[[1, 0, 0, 0]], scales=[[0.5] * 3], opacities=[1.0], sh=sh
    )
    camera = powergs.Camera([[50, 0, 16], [0, 50, 16], [0, 0, 1]], np.eye(4), (32, 32))
    pixel = scene.render(camera)[16, 16]
    # 3DGS: colour = 0.5 + C0 times the coefficient, at an opacity of 0.99 at most.
    expected = 0.5 + 0.28209479 * np.array([1.0, -1.0, 0.5])
    np.testing.assert_allclose(pixel, 0.99 * expected, atol=0.01)


def test_any_strides_and_kinds(made) -> None:
    arrays = made[0].to_arrays()
    odd = {name: np.asfortranarray(array.astype(np.float64)) for name, array in arrays.items()}
    odd["means"] = np.repeat(arrays["means"], 2, axis=0)[::2]
    odd["opacities"] = arrays["opacities"][:, None]
    same = powergs.Scene.from_arrays(**odd).to_arrays()
    np.testing.assert_array_equal(same["means"], arrays["means"])


@pytest.mark.parametrize(
    ("name", "change", "message"),
    [
        ("means", lambda a: a[:, :2], r"\(N, 3\)"),
        ("means", lambda a: a[:0], "1 to"),
        ("quats", lambda a: a[:-1], "means have"),
        ("quats", lambda a: a * 0, "zero"),
        ("scales", lambda a: np.log(a), "exp"),
        ("opacities", lambda a: a * 100 + 2, "sigmoid"),
        ("sh", lambda a: a[:, :3], "1, 4, 9 or 16"),
        ("means", lambda a: np.where(a == a[3, 0], np.nan, a), "#3"),
    ],
)
def test_arrays_that_do_not_fit(made, name, change, message) -> None:
    arrays = made[0].to_arrays()
    with pytest.raises(powergs.InputError, match=message):
        powergs.Scene.from_arrays(**{**arrays, name: change(arrays[name])})


def test_splats_of_gsplat_are_those_before_activations(made) -> None:
    arrays = made[0].to_arrays()
    splats = {
        "means": arrays["means"],
        "quats": arrays["quats"],
        "scales": np.log(arrays["scales"]),
        "opacities": np.log(arrays["opacities"] / (1 - arrays["opacities"])),
        "sh0": arrays["sh"][:, :1],
        "shN": arrays["sh"][:, 1:],
    }
    again = powergs.Scene.from_gsplat(splats, name="trained")
    assert again.name == "trained" and again.sh_degree == 3
    for name, array in again.to_arrays().items():
        np.testing.assert_allclose(array, arrays[name], rtol=1e-3, atol=1e-5)
    del splats["shN"]
    assert powergs.Scene.from_gsplat(splats).sh_degree == 0
    with pytest.raises(powergs.InputError, match=r"sh0 has the shape \(N, 1, 3\)"):
        powergs.Scene.from_gsplat({**splats, "sh0": arrays["sh"]})
    del splats["sh0"]
    with pytest.raises(powergs.InputError, match="no `sh0`"):
        powergs.Scene.from_gsplat(splats)


def test_points_become_round_gaussians() -> None:
    places = [[0.0, 0.0, 0.0], [2.0, 0.0, 0.0], [0.0, 2.0, 0.0], [0.0, 0.0, 2.0]]
    scene = powergs.Scene.from_points(places, [[0.5, 1.0, 0.0]] * 4)
    arrays = scene.to_arrays()
    assert len(scene) == 4 and scene.sh_degree == 0
    np.testing.assert_allclose(arrays["scales"][0], 2.0, rtol=1e-5)
    np.testing.assert_allclose(arrays["opacities"], 0.1, rtol=1e-5)
    np.testing.assert_allclose(arrays["sh"][0, 0], np.array([0, 0.5, -0.5]) / 0.28209479, atol=1e-5)
    assert len(powergs.Scene.from_points(np.zeros((2, 3)))) == 2
    with pytest.raises(powergs.InputError, match="0 to 1"):
        powergs.Scene.from_points(places, np.full((4, 3), 255.0))
    with pytest.raises(powergs.InputError, match="1 to"):
        powergs.Scene.from_points(np.zeros((0, 3)))


def test_no_numbers_at_all(made) -> None:
    arrays = made[0].to_arrays()
    with pytest.raises(TypeError, match="means"):
        powergs.Scene.from_arrays(**{**arrays, "means": "three"})


def test_cameras_of_matrices(made) -> None:
    scene, cameras = made
    camera = cameras[3]
    again = powergs.Camera(camera.intrinsics, camera.world_to_camera, camera.size, name="again")
    np.testing.assert_allclose(again.position, camera.position, atol=1e-9)
    size = (64, 64)
    assert np.abs(scene.render(again, size=size) - scene.render(camera, size=size)).max() < 1e-5
    both = powergs.Cameras([camera, again])
    assert len(both) == 2 and both[1].name == "again"
    assert len(scene.extract(both, size=size)) == 2
    with pytest.raises(powergs.ConfigError):
        powergs.Cameras([])


@pytest.mark.parametrize(
    ("k", "pose", "size", "message"),
    [
        (np.eye(2), np.eye(4), (8, 8), r"\(3, 3\)"),
        ([[9, 1, 4], [0, 9, 4], [0, 0, 1]], np.eye(4), (8, 8), "skew"),
        ([[9, 0, 4], [0, 9, 4], [0, 0, 1]], 2 * np.eye(4), (8, 8), "0 0 0 1"),
        ([[9, 0, 4], [0, 9, 4], [0, 0, 1]], np.diag([2, 2, 2, 1]), (8, 8), "rotation"),
        ([[9, 0, 4], [0, 9, 4], [0, 0, 1]], np.diag([1, 1, -1, 1]), (8, 8), "reflection"),
        ([[9, 0, 4], [0, 9, 4], [0, 0, 1]], np.eye(4), (0, 8), "size"),
        ([[-9, 0, 4], [0, 9, 4], [0, 0, 1]], np.eye(4), (8, 8), "focal"),
    ],
)
def test_matrices_that_are_no_camera(k, pose, size, message) -> None:
    with pytest.raises(powergs.InputError, match=message):
        powergs.Camera(k, pose, size)


def test_machines_of_texts_and_dictionaries(gscore) -> None:
    assert powergs.Machine.from_toml(gscore.to_toml()) == gscore
    eight = gscore.with_({"vru.cores": 8})
    same = powergs.Machine.from_dict({"base": "gscore", "vru": {"cores": 8}})
    assert same["vru.cores"] == 8 and same.area_mm2 == eight.area_mm2
    with pytest.raises(powergs.ConfigError, match="did you mean"):
        powergs.Machine.from_dict({"base": "gscore", "vru": {"coers": 8}})
    with pytest.raises(powergs.ConfigError, match="from_toml"):
        powergs.Machine(gscore.to_toml())
    with pytest.raises(powergs.ConfigError):
        powergs.Machine.from_toml("clock = [")


def test_a_frame_as_arrays(trace) -> None:
    arrays, table = trace[1].to_arrays(), trace[1].splats()
    assert arrays["means"].shape == (len(table), 2) and arrays["covariances"].shape[1] == 3
    assert arrays["indices"].tolist() == table["index"]
    assert arrays["opacities"].tolist() == table["opacity"]
    with pytest.raises(ValueError, match="one frame"):
        trace.to_arrays()


def test_cameras_are_pickled(made) -> None:
    _, cameras = made
    again = pickle.loads(pickle.dumps(cameras))
    assert len(again) == len(cameras)
    for one, other in zip(again, cameras):
        assert (one.name, one.size, one.focal, one.split) == (
            other.name, other.size, other.focal, other.split
        )  # fmt: skip
        assert one.position == other.position

"""The optimiser: callbacks, checkpoints, goals that are missed."""

from __future__ import annotations

import numpy as np
import pytest

import powergs

SMALL = {
    "machine": "paper",
    "quality": 28.0,
    "display_ratio": 2.0,
    "rhos": [0.0, 0.3],
    "iterations": 30,
    "final_iterations": 40,
}


@pytest.fixture(scope="module")
def scene() -> powergs.Scene:
    return powergs.synth("demo", points=500, seed=3)[0]


@pytest.fixture(scope="module")
def views() -> powergs.Cameras:
    return powergs.synth("demo", points=1)[1].select(every=4, size=(48, 40))


@pytest.fixture(scope="module")
def found(scene, views) -> powergs.Optimized:
    return powergs.optimize(scene, views, **SMALL)


def test_the_result_has_model_tables_pictures_and_charts(found, scene, views) -> None:
    assert found.reached and "reached" in repr(found)
    model = found.model
    assert 0 < len(model) <= len(scene)
    assert model.render(views[0]).shape == (40, 48, 3)
    models = found.models
    assert models["name"][0] == "dense" and models["gaussians"][0] == 500
    record = found.to_dict()["models"][0]
    assert models["render_w"][0] == record["render_w"]
    history = found.history
    assert len(history) == sum(models["iterations"])
    before, after = found.pictures
    assert before.shape == after.shape == (40, 48, 3) and before.dtype == np.uint8
    assert found.charts() and all(c.svg.startswith("<svg") for c in found.charts().values())
    assert "<table" in found._repr_html_() and "dB" in str(found)


def test_power_is_counted_at_the_size_that_is_shown(scene, views) -> None:
    few = {**SMALL, "iterations": 2, "final_iterations": 2, "rhos": [0.1], "quality": 10.0}
    trained = powergs.optimize(scene, views, **few, size=(24, 20))
    assert trained.to_dict()["priced"]["size"] == [48, 40]
    shown = powergs.optimize(scene, views, **few, size=(24, 20), power_size=(96, 80))
    assert shown.to_dict()["priced"]["size"] == [96, 80]
    assert shown.models["render_w"][0] > trained.models["render_w"][0]


def test_callbacks_hear_every_iteration_in_order(found, scene, views) -> None:
    heard: list[dict[str, object]] = []
    seen: list[tuple[int, int]] = []
    again = powergs.optimize(
        scene, views, **SMALL, callback=heard.append, progress=lambda *at: seen.append(at)
    )
    assert again.to_dict() == found.to_dict()
    history = again.history
    told = [e for e in heard if e["event"] == "iteration"]
    for name in ["job", "iteration", "gaussians", "loss", "psnr_db", "gate_psnr_db"]:
        assert [e[name] for e in told] == history[name]
    assert [e["job"] for e in heard if e["event"] == "model"] == again.models["name"]
    assert seen[-1][0] == seen[-1][1]


def test_a_callback_that_raises_ends_the_run_and_a_store_goes_on(
    found, scene, views, tmp_path
) -> None:
    def stop(event: dict[str, object]) -> None:
        if event["event"] == "model":
            raise RuntimeError("enough")

    with pytest.raises(RuntimeError, match="enough"):
        powergs.optimize(scene, views, **SMALL, callback=stop, store=tmp_path / "run")
    again = powergs.optimize(scene, views, **SMALL, store=tmp_path / "run")
    assert again.to_dict() == found.to_dict()
    with pytest.raises(powergs.PowergsError):
        powergs.optimize(scene, views, **{**SMALL, "quality": 20.0}, store=tmp_path / "run")


def test_settings_by_keyword(found, scene, views) -> None:
    usual = powergs.optimize(scene, views, **SMALL, rate_end=0.1, gate="validation", seed=1)
    assert usual.to_dict() == found.to_dict()
    other = powergs.optimize(scene, views, **SMALL, rate_end=1, dimming="damped")
    assert other.history["loss"] != found.history["loss"]


def test_a_goal_that_is_missed(scene, views) -> None:
    few = {**SMALL, "quality": 110.0, "rhos": [0.5], "iterations": 2, "final_iterations": 2}
    found = powergs.optimize(scene, views, **few)
    assert not found.reached and len(found.models) >= 1
    with pytest.raises(powergs.GoalMissed):
        found.model


def test_photos_and_a_machine(scene, views) -> None:
    photos = [scene.render(view) for view in views]
    few = {**SMALL, "iterations": 2, "final_iterations": 2, "rhos": [0.1], "quality": 0.9}
    found = powergs.optimize(scene, views, **{**few, "machine": "gscore"}, photos=photos)
    assert found.to_dict()["reference"] == "photos" and found.to_dict()["oracle"] == "gscore"


def test_photos_of_another_size_scale_the_cameras(scene, views) -> None:
    few = {**SMALL, "iterations": 2, "final_iterations": 2, "rhos": [0.1], "quality": 0.5}
    for size, width in [((24, 20), 24), ((96, 80), 48)]:
        photos = [scene.render(view.resized(*size)) for view in views]
        found = powergs.optimize(scene, views, **few, photos=photos)
        assert found.to_dict()["width_px"] == width


def test_arguments_that_are_wrong(scene, views) -> None:
    for wrong in [
        {"quality": "X"},
        {"quality": 1000.0},
        {"quality": 0.9},
        {"quality": float("nan")},
        {"rhos": [0.5, 0.2]},
        {"rhos": [float("nan")]},
        {"rhos": [1.0]},
        {"iterations": 0},
        {"iterations": -1},
        {"iterations": 2.5},
        {"iterations": "many"},
        {"rate_end": 2},
        {"gate": "tset"},
        {"fps": 0.0},
        {"display": "nosuch"},
        {"machine": "nosuch"},
        {"display_ratio": -1.0},
        {"display_ratio": float("nan")},
        {"size": (0, 4)},
    ]:
        with pytest.raises(powergs.ConfigError):
            powergs.optimize(scene, views, **{**SMALL, **wrong})
    with pytest.raises(TypeError):
        powergs.optimize(scene, views, callback=3)
    with pytest.raises(TypeError, match="'rate_ends'; did you mean 'rate_end'"):
        powergs.optimize(scene, views, rate_ends=1)
    with pytest.raises(powergs.InputError, match="photos"):
        powergs.optimize(scene, views, photos=[np.zeros((4, 4, 3))])
    with pytest.raises(powergs.InputError, match="aspect"):
        powergs.optimize(scene, views, photos=[np.zeros((9, 4, 3))] * len(views))

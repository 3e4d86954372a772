"""Optuna looks for the Pareto front of a space; ask and tell beside the whole grid."""

from __future__ import annotations

import sys

import optuna

import powergs

AXES: dict[str, list[int]] = {"vru.cores": [2, 4, 8], "ccu.units": [2, 4, 8]}


def main(path: str, trials: int = 20) -> None:
    trace = powergs.Trace.open(path).load()
    space = powergs.Space(AXES)

    def objective(trial: optuna.Trial) -> tuple[float, float]:
        settings = {key: trial.suggest_categorical(key, values) for key, values in AXES.items()}
        candidate = space.ask(settings)
        report = trace.replay(candidate.machine)
        space.tell(candidate, {"ms": report.frame_time_ms, "mm2": report.area_mm2})
        # What is not known is NaN, which Optuna takes for no result: a zero would win.
        return report.frame_time_ms, report.area_mm2

    sampler = optuna.samplers.NSGAIISampler(population_size=6, seed=1)
    optuna.logging.set_verbosity(optuna.logging.WARNING)
    study = optuna.create_study(directions=["minimize", "minimize"], sampler=sampler)
    study.optimize(objective, n_trials=trials)
    print(space.pareto(minimize=["ms", "mm2"]))


if __name__ == "__main__":
    main(sys.argv[1] if len(sys.argv) > 1 else "traces/demo.bin")

"""A planned experiment as files: a table of commanded poses for each run, scenarios and promises as JSON."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np

from hexathermal.learn.hexapod_data import AXES, PLATES
from hexathermal.learn.machine_diagnosis.planning import MachineExperiment

FORMAT = "hexathermal-machine-experiment/1"
COLUMNS = ("time_s", *(f"{axis}_{unit}" for axis, unit in zip(AXES, ["mm"] * 3 + ["deg"] * 3, strict=True)))
"""Of a table of poses: as a hexapod campaign's, with the time since the run's first row."""


def experiment_facts(experiment: MachineExperiment) -> dict[str, Any]:
    """Return what an experiment is, ready for JSON.

    Separations are natural logarithms of Bayes factors, on average; rises of temperature are those at the end of a
    run, which they reach evenly from its first row.
    """
    view = experiment.view
    return {
        "format": FORMAT,
        "words": experiment.words,
        "tells_apart": list(experiment.wanted),
        "separation": round(experiment.separation, 3),
        "separation_of_random_plans": round(experiment.random, 3),
        "separations": [
            {"true": one.true, "rival": one.rival, "before": round(one.before, 3), "after": round(one.after, 3)}
            for one in experiment.promises
        ],
        "runs": [
            {
                "name": name,
                "poses": poses_file(name),
                "rows": int((view.run == k).sum()),
                "scenario": way.name,
                "words": way.words,
                "rise_K": {
                    **{f"leg{leg + 1}": round(rise, 3) for leg, rise in enumerate(way.legs)},
                    **{part: round(getattr(way, part), 3) for part in PLATES},
                    "air": round(way.air, 3),
                },
            }
            for k, (name, way) in enumerate(zip(view.runs, experiment.scenarios, strict=True))
        ],
    }


def planned_facts(experiment: MachineExperiment) -> dict[str, Any]:
    """Return what an experiment is with its commanded poses [mm, deg], which stand in no file of their own then."""
    told = experiment_facts(experiment)
    for run in told["runs"]:
        del run["poses"]
    run_of = experiment.view.run
    poses = [[round(float(value), 4) for value in pose] for pose in experiment.coordinates]
    for k, run in enumerate(told["runs"]):
        run["poses_mm_deg"] = [pose for pose, own in zip(poses, run_of == k, strict=True) if own]
    return told


def poses_file(run: str) -> str:
    """Return the name of a run's table of poses.

    Examples
    --------
    >>> poses_file("run-1")
    'poses-run-1.csv'
    """
    return f"poses-{run}.csv"


def write_experiment(experiment: MachineExperiment, folder: str | Path) -> tuple[Path, ...]:
    """Write an experiment into a folder, whole or not at all; returns the paths of its files.

    ``poses-<run>.csv`` holds a run's commanded poses from home in order, with the columns of a hexapod campaign;
    ``experiment.json`` the scenario of each run and what is promised.

    Parameters
    ----------
    experiment : MachineExperiment
    folder : str or Path
        Made where it is missing; files of the same names are replaced.

    Raises
    ------
    ArgumentError
        The folder cannot be made or written.
    """
    from hexathermal.predict.table_writing import written_folder

    place, names = Path(folder), list[str]()
    with written_folder(place) as part:
        for k, name in enumerate(experiment.view.runs):
            own = experiment.view.run == k
            rows = np.column_stack([experiment.view.time[own], experiment.coordinates[own]])
            lines = [",".join(COLUMNS), *(",".join([f"{row[0]:.1f}", *(f"{x:.4f}" for x in row[1:])]) for row in rows)]
            names.append(poses_file(name))
            (part / names[-1]).write_text("\n".join(lines) + "\n", encoding="utf-8")
        names.append("experiment.json")
        text = json.dumps(experiment_facts(experiment), indent=2, allow_nan=False, ensure_ascii=False)
        (part / names[-1]).write_text(text + "\n", encoding="utf-8")
    return tuple(place / name for name in names)

"""What ``hexathermal budget`` answers with: tables, texts, plain values and files, put together piece by piece."""

from __future__ import annotations

import csv
from pathlib import Path
from typing import Any

import numpy as np

from hexathermal.poses import FloatArray, pose_from_coordinates
from hexathermal.predict.budget import AXES, Budget, error_budget
from hexathermal.predict.budget_map import BudgetMap
from hexathermal.predict.budget_maps import budget_map, grid_coordinates, pose_grid
from hexathermal.predict.montecarlo import LEAST_TOLERANCE, monte_carlo
from hexathermal.predict.sources import HALF_WIDTH
from hexathermal.predict.table_writing import written_whole
from hexathermal.predict.trajectory import POSE_COLUMNS
from hexathermal.show.budget_figures import contributions_figure, day_figure, map_figure
from hexathermal.show.budget_options import Grid, Request, path_with_temperatures, table
from hexathermal.show.budget_tables import (
    bias_table,
    contribution_rows,
    contributions_table,
    coordinates_of,
    map_rows,
    map_table,
    place_text,
    simulation_table,
)
from hexathermal.show.commands import Answer, Progress
from hexathermal.show.figures import save_figure
from hexathermal.show.options import in_millimetres

RULING = 0.5
"""Part of an axis' variance above which one bounded value gives its distribution away."""


def _ruled(budget: Budget) -> str:
    """Return the axes that one bounded value rules, and its source, for people; empty where there is none."""
    variance = np.diag(budget.covariance)
    found = {
        item.label: [axis for axis, own, whole in zip(AXES, item.largest_single, variance, strict=True)
                     if own > RULING * whole]
        for item in budget.contributions if item.distribution in HALF_WIDTH
    }  # fmt: skip
    return "; ".join(f"{', '.join(axes)} ({label})" for label, axes in found.items() if axes)


class Report:
    """An answer being put together; files are written as their parts are added."""

    def __init__(self, request: Request, folder: Path | None) -> None:
        self.request, self.folder = request, folder
        self.shown: list[Any] = [self._head()]
        self.data: dict[str, Any] = {"format": "hexathermal-budget/1"}
        self.warnings: list[str] = []
        self.files: list[Path] = []
        self.place: tuple[FloatArray, FloatArray, Any, Any] = (request.pose, request.temps[0], *self._here(0))

    def _here(self, k: int) -> tuple[Any, Any]:
        """Return plates and air of a row of temperatures."""
        plates = self.request.plates[k] if isinstance(self.request.plates, list) else self.request.plates
        air = self.request.air_degC
        return plates, None if air is None else float(np.broadcast_to(air, len(self.request.temps))[k])

    def _head(self) -> str:
        """Return what the budget is of."""
        request = self.request
        six = ", ".join(f"{value:g}" for value in request.coordinates)
        low, high = request.temps.min(), request.temps.max()
        heat = request.scenario or (f"{low:g} degC" if low == high else f"{low:g} to {high:g} degC")
        how = "corrected" if request.settings["correction"] else "nominal, uncorrected"
        return (
            f"Machine {request.hexapod.name}, pose ({six}) mm and deg from home, {heat}; {how} lengths are commanded.\n"
            "Errors are reached minus wanted: shift of the point, and rotation vector of the platform."
        )

    def budget(self) -> Budget:
        """Return the budget at the pose, or at the worst place of a map or a day."""
        pose, temps, plates, air = self.place
        return error_budget(
            self.request.hexapod, pose, temps, self.request.sources, plates=plates, air_degC=air,
            **self.request.settings,
        )  # fmt: skip

    def add_budget(self, title: str = "") -> None:
        """Add the budget of one place: tables, values, a CSV file and a picture."""
        budget, p = self.budget(), self.request.probability
        point = ", ".join(f"{value * 1e3:g}" for value in budget.point)
        self.shown.append(f"{title}Point: ({point}) mm from the platform's origin.")
        self.shown.append(lambda pretty, _width: bias_table(budget, p, pretty))
        self.shown.append(lambda pretty, width: contributions_table(budget, pretty, width))
        self.shown.append(self._advice(budget))
        if note := budget.region_note(p):
            self.warnings.append(note)
        self.data["budget"] = budget.as_dict(p)
        self._save_rows("budget.csv", *contribution_rows(budget))
        self._save_figure("contributions.png", lambda: contributions_figure(budget, p))

    def _advice(self, budget: Budget) -> str:
        """Return what weighs most, and what was assumed."""
        lines = []
        if budget.contributions:
            top = budget.contributions[0]
            lines.append(f"Largest contribution: {top.label} ({top.basis or 'no basis stated'}).")
        if ruled := _ruled(budget):
            lines.append(
                f"One bounded value rules {ruled}: there the expanded uncertainty is too large; --monte-carlo tells "
                "the interval."
            )
        assumed = [item.label for item in budget.contributions if item.basis.startswith("engineering value")]
        if assumed:
            lines.append(f"Engineering values, to be replaced by what is known of the machine: {', '.join(assumed)}.")
        model = self.request.hexapod.thermal
        plates = () if model is None else (("platform", model.platform), ("base", model.base))
        for part, plate in plates:
            if plate is None:
                lines.append(f"The {part} has no thermal law: its expansion is not in this budget.")
            elif plate.sensor is None:
                plates_given = self.place[2]
                told = getattr(plates_given, f"{part}_degC")
                warm = "the legs' mean temperature" if told is None else f"{told:z.2f} degC"
                lines.append(f"No thermometer on the {part}: taken at {warm}; its expansion is not corrected.")
        return "\n".join(lines)

    def add_simulation(self, seed: int, tolerance: float, most_draws: int, progress: Progress) -> None:
        """Add a Monte Carlo at the same place; `tolerance` in percent of each axis' standard uncertainty."""
        pose, temps, plates, air = self.place
        here = {"plates": plates, "air_degC": air, **self.request.settings}
        u = error_budget(self.request.hexapod, pose, temps, self.request.sources, **here).uncertainty
        found = monte_carlo(
            self.request.hexapod, pose, temps, self.request.sources, probability=self.request.probability, seed=seed,
            tolerance=np.maximum(0.01 * tolerance * u, LEAST_TOLERANCE), most_draws=most_draws,
            progress=lambda done, most: progress(done, most, "Monte Carlo"), **here,
        )  # fmt: skip
        self.shown.append(lambda pretty, _width: simulation_table(found, pretty))
        self.shown.append(f"Monte Carlo: {found.verdict}.")
        if found.note:
            self.warnings.append(f"Monte Carlo: {found.note}.")
        self.data["monte_carlo"] = found.as_dict()

    def add_map(self, grids: list[Grid], progress: Progress) -> None:
        """Add a map over a grid of poses at the first set of temperatures."""
        request = self.request
        if request.many:
            self.warnings.append(f"the map takes the first of {len(request.temps)} rows of temperatures")
        spans = {one.name: (one.low, one.high, one.count) for one in grids}
        poses = pose_grid(request.hexapod, convention=request.convention, around=request.coordinates, **spans)
        plates, air = self._here(0)
        found = budget_map(
            request.hexapod, poses, request.temps[0], request.sources, probability=request.probability, plates=plates,
            air_degC=air, progress=lambda done, total: progress(done, total, "map"), **request.settings,
        )  # fmt: skip
        self._add_places(found, grid_coordinates(request.coordinates, spans), None, "map")
        if len(grids) <= 2:
            self._save_figure("map.png", lambda: map_figure(found, [(one.name, one.values) for one in grids]))
        elif self.folder is not None:
            self.warnings.append("no picture of a map over more than two coordinates; map.csv holds all numbers")
        self._worst_budget(found, plates, air)

    def add_path(self, file: Path, progress: Progress) -> None:
        """Add budgets along the poses of a file; those of a file of temperatures belong to them as in `correct`."""
        request = self.request
        temps = request.temps[0]
        if request.heat is None:
            coordinates, time_s = table(file, POSE_COLUMNS, "poses")
        else:
            coordinates, time_s, temps, pairing = path_with_temperatures(request.hexapod, file, request.heat)
            self.shown.append(f"Temperatures of {request.heat}: {pairing}.")
            self.data["pairing"] = pairing
        poses = pose_from_coordinates(coordinates, request.convention, request.hexapod)
        plates, air = self._here(0)
        found = budget_map(
            request.hexapod, poses, temps, request.sources,
            probability=request.probability, plates=plates, air_degC=air,
            progress=lambda done, total: progress(done, total, "path"), **request.settings,
        )  # fmt: skip
        self._add_places(found, coordinates, time_s, "path")
        along = ("pose", np.arange(1.0, len(poses) + 1.0)) if time_s is None else ("time (s)", time_s)
        self._save_figure("path.png", lambda: map_figure(found, [along]))
        self._worst_budget(found, plates, air)

    def add_day(self, progress: Progress) -> None:
        """Add budgets of one pose over many temperatures."""
        request = self.request
        view = dict(request.settings)
        if isinstance(request.plates, list):
            view |= {"each_plates": request.plates, "each_air_degC": request.air_degC}
        else:
            view |= {"plates": request.plates, "air_degC": request.air_degC}
        found = budget_map(
            request.hexapod, request.pose, request.temps, request.sources, probability=request.probability,
            progress=lambda done, total: progress(done, total, "day"), **view,
        )  # fmt: skip
        coordinates = coordinates_of(found, request.convention, request.hexapod)
        time_s = np.arange(float(len(found.poses))) if request.time_s is None else request.time_s
        if request.time_s is None:
            self.warnings.append("the temperatures have no time_s: rows are taken as one second apart")
        self._add_places(found, coordinates, time_s, "day")
        self._save_figure("day.png", lambda: day_figure(found, time_s))
        worst = found.worst().index
        self._worst_budget(found, *self._here(worst))

    def _worst_budget(self, found: BudgetMap, plates: Any, air: Any) -> None:
        """Add the budget of the worst place."""
        worst = found.worst().index
        self.place = (found.poses[worst], found.temps[worst], plates, air)
        self.add_budget("The worst place in shift. ")

    def _add_places(self, found: BudgetMap, coordinates: FloatArray, time_s: FloatArray | None, kind: str) -> None:
        """Add the table of a map or a day, its worst places, and its CSV file."""
        self.shown.append(lambda pretty, _width: map_table(found, pretty))
        lines, worst_of = [], {}
        for measure, unit in (("shift", "um"), ("turn", "urad")):
            worst = found.worst(measure)
            place = place_text(found, worst.index, coordinates, time_s)
            lines.append(f"Worst {measure}: {worst.value * 1e6:z.3f} {unit} at {place}: {worst.reason}.")
            worst_of[measure] = {
                "place": place, "coordinates": coordinates[worst.index].tolist(), "axis": worst.axis,
                f"worst_case_{unit}": worst.value * 1e6, "reason": worst.reason, "source": worst.source,
            }  # fmt: skip
        if found.refused:
            lines.append(
                f"Out of reach: {len(found.refused)} of {len(found.poses)}; the first: "
                f"{in_millimetres(found.refused[0][1])}."
            )
        self.shown.append("\n".join(lines))
        header, rows = map_rows(found, coordinates, time_s, self.request.hexapod.sensor_names)
        self._save_rows(f"{kind}.csv", header, rows)
        self.data[kind] = {"columns": header, "rows": rows, "worst": worst_of}

    def _save_rows(self, name: str, header: list[str], rows: list[list[Any]]) -> None:
        """Write a CSV file into the folder."""
        if self.folder is None:
            return
        with (
            written_whole(self.folder / name) as part,
            part.open("w", newline="", encoding="utf-8") as file,
        ):
            writer = csv.writer(file, lineterminator="\n")
            writer.writerow(header)
            writer.writerows(rows)
        self.files.append(self.folder / name)

    def _save_figure(self, name: str, make: Any) -> None:
        """Write a picture into the folder."""
        if self.folder is not None:
            self.files.append(save_figure(make(), self.folder / name))

    def finished(self) -> Answer:
        """Return the answer."""
        if self.files:
            self.shown.append("Written:\n" + "\n".join(f"  {file}" for file in self.files))
        return Answer(tuple(self.shown), self.data, tuple(self.warnings))

"""Tables and plain values of hexapod identifications, observability, designs and validations."""

from __future__ import annotations

from typing import Any

import numpy as np
from rich.table import Table

from hexathermal.learn.coverage import TWO_SIDED
from hexathermal.learn.hexapod_data import AXES
from hexathermal.learn.hexapod_design import PoseDesign
from hexathermal.learn.hexapod_identification import HexapodIdentification
from hexathermal.learn.hexapod_observability import Observability
from hexathermal.learn.hexapod_scores import QUANTITIES, PoseScore
from hexathermal.learn.hexapod_validation import HexapodValidation
from hexathermal.learn.validation import Figure
from hexathermal.show.campaign_tables import number
from hexathermal.show.identification_tables import plain
from hexathermal.show.tables import framed


def hexapod_laws_table(found: HexapodIdentification, pretty: bool) -> Table:
    """Return the free coefficients of the chosen laws with their uncertainties."""
    table = framed(pretty, "coefficient", "value\num/m/K>", "standard\nuncertainty>", "95 % interval", "by rows>",
                   "between runs>")  # fmt: skip
    fit = found.fit
    u = np.sqrt(np.diagonal(fit.covariance)) * 1e6
    for k, word in enumerate(fit.model.words):
        if word.startswith("frame "):
            continue
        value = fit.theta[k] * 1e6
        runs = fit.by_runs[k] * 1e6
        half = TWO_SIDED * u[k]
        table.add_row(word, f"{value:z.4f}", f"{u[k]:z.4f}", f"{value - half:z.4f} to {value + half:z.4f}",
                      f"{fit.by_rows[k] * 1e6:z.4f}", f"{runs:z.4f}" if np.isfinite(runs) else "-")  # fmt: skip
    if not fit.model.words:
        table.add_row("none is free: laws as given", "", "", "", "", "")
    return table


def kinds_table(found: HexapodIdentification, pretty: bool) -> Table:
    """Return the kinds of laws side by side."""
    table = framed(pretty, "laws", "chosen", "free\ncoefficients>", "left out:\ntranslation um>", "rotation\nurad>",
                   "fitted:\ntranslation um>", "rotation\nurad>", "weighted RMS\nleft out>")  # fmt: skip
    for name, fit in found.fits.items():
        free = sum(not word.startswith("frame ") for word in fit.model.words)
        pairs = [f"{value * 1e6:z.3f}" if np.isfinite(value) else "-"
                 for pair in (found.left_out_rmse[name], found.fit_rmse[name]) for value in pair]  # fmt: skip
        weights = np.array([run.freedom for run in found.equations.runs])
        known = np.isfinite(fit.left_out).all()
        weighted = f"{np.sqrt(weights @ fit.left_out / weights.sum()):z.3f}" if known else "-"
        table.add_row(name, "yes" if name == found.chosen else "", str(free), *pairs, weighted)
    return table


def observability_table(found: Observability, pretty: bool) -> Table:
    """Return what the data tell of each coefficient."""
    table = framed(pretty, "coefficient", "uncertainty\num/m/K>", "others known\num/m/K>", "inflation>", "told apart")
    for one in found.coefficients:
        if not one.moved:
            table.add_row(one.name, "-", "-", "-", "no: its temperature never changes")
            continue
        table.add_row(one.name, number(one.uncertainty * 1e6, 4), number(one.alone * 1e6, 4),
                      number(one.inflation, 1), "yes" if one.told_apart else "no")  # fmt: skip
    return table


def design_table(found: PoseDesign, pretty: bool) -> Table:
    """Return what designed poses gain over random ones."""
    table = framed(pretty, "coefficient", "proposed poses\num/m/K>", "random poses\num/m/K>", "ratio>")
    for word, u, random in zip(found.words, found.uncertainty, found.random, strict=True):
        table.add_row(word, f"{u * 1e6:z.4f}", f"{random * 1e6:z.4f}", f"{u / random:z.2f}")
    return table


def hexapod_validation_table(found: HexapodValidation, pretty: bool) -> Table:
    """Return errors before and after correction: per axis over all runs, then distances of each run."""
    table = framed(pretty, "run", "error", "RMS\nbefore>", "RMS\nafter>", "95 % interval", "largest\nbefore>",
                   "largest\nafter>", "reduction>", "95 % interval", "unit")  # fmt: skip

    def row(run: str, name: str, one: PoseScore) -> None:
        """Add a quantity."""
        part = one.reduction
        table.add_row(run, name, f"{one.before.value * 1e6:z.2f}", f"{one.after.value * 1e6:z.2f}",
                      _interval(one.after, 1e6, 2), f"{one.largest_before * 1e6:z.2f}",
                      f"{one.largest_after * 1e6:z.2f}", f"{100.0 * part.value:z.1f} %",
                      f"{_interval(part, 100.0, 1)} %", unit_of(name))  # fmt: skip

    some = 0 < len(found.fitted) < len(found.runs)
    for name in QUANTITIES:
        row("all never fitted" if some else "all", name, found.total[name])
    for run, scores in found.runs.items():
        for name in ("translation", "rotation"):
            row(f"{run} (fitted)" if run in found.fitted else run, name, scores[name])
    return table


def _interval(one: Figure, scale: float, digits: int) -> str:
    """Return an interval in words; a dash where there are too few rows for one."""
    if not np.isfinite(one.low) or not np.isfinite(one.high):
        return "-"
    return f"{one.low * scale:z.{digits}f} to {one.high * scale:z.{digits}f}"


def unit_of(quantity: str) -> str:
    """Return the unit in which a quantity is shown."""
    return "um" if quantity in ("x", "y", "z", "translation") else "urad"


def hexapod_identification_facts(found: HexapodIdentification, seen: Observability) -> dict[str, Any]:
    """Return an identification as plain values: um/m/K, um, urad."""

    def kind(name: str) -> dict[str, Any]:
        """Return one kind of laws."""
        fit = found.fits[name]
        u = np.sqrt(np.diagonal(fit.covariance))
        return {
            "coefficients": [
                {"name": word, "value": float(value * 1e6), "standard_uncertainty": float(sd * 1e6),
                 "by_rows": float(rows * 1e6), "between_runs": plain(runs * 1e6), "unit": "um/m/K"}
                for word, value, sd, rows, runs in zip(
                    fit.model.words, fit.theta, u, fit.by_rows, fit.by_runs, strict=True)
                if not word.startswith("frame ")
            ],
            "covariance_um2_per_m2_K2": (fit.covariance * 1e12).tolist(),
            "left_out_rmse": {"translation_um": plain(found.left_out_rmse[name][0] * 1e6),
                              "rotation_urad": plain(found.left_out_rmse[name][1] * 1e6)},
            "fit_rmse": {"translation_um": plain(found.fit_rmse[name][0] * 1e6),
                         "rotation_urad": plain(found.fit_rmse[name][1] * 1e6)},
            "left_out_weighted_mean_square": [plain(value) for value in fit.left_out],
        }  # fmt: skip

    return {
        "kind": "hexapod",
        "machine": found.rows.hexapod.name,
        "sensors": list(found.sensors),
        "chosen": found.chosen,
        "reason": found.reason,
        "laws": {name: kind(name) for name in found.fits},
        "rows": len(found.rows),
        "rows_left_out": dict(found.rows.left_out),
        "runs": list(found.rows.runs),
        "noise": {name: float(value * 1e6) for name, value in zip(
            ("x_um", "y_um", "z_um", "rx_urad", "ry_urad", "rz_urad"), found.noise, strict=True)},
        "noise_given": found.noise_given,
        "spread_between_legs": [
            {"name": name, "value": plain(value * 1e6), "unit": "um/m/K"} for name, value in zip(
                (f"{letter} {name}" for letter in "AB" for name in found.sensors), found.spread, strict=True)
        ],
        "leg_noise_um": found.leg_noise * 1e6,
        "frame": found.frame,
        "frames": {run: (found.frames[k] * 1e6).tolist() for k, run in enumerate(found.rows.runs)},
        "observability": observability_facts(seen),
        "notes": list(found.notes),
    }  # fmt: skip


def observability_facts(found: Observability) -> dict[str, Any]:
    """Return what can be told apart as plain values."""
    return {
        "coefficients": [
            {"name": one.name, "uncertainty_um_per_m_K": plain(one.uncertainty * 1e6),
             "alone_um_per_m_K": plain(one.alone * 1e6), "inflation": plain(one.inflation),
             "told_apart": one.told_apart}
            for one in found.coefficients
        ],
        "singular_values": found.singular_values.tolist(),
        "directions": list(found.directions),
        "condition_number": plain(found.condition),
        "groups": list(found.groups),
        "likeness": [[plain(value) for value in row] for row in found.likeness],
        "words": list(found.words),
    }  # fmt: skip


def design_facts(found: PoseDesign) -> dict[str, Any]:
    """Return a design as plain values."""
    return {
        "criterion": found.criterion,
        "poses": found.coordinates.tolist(),
        "coefficients": list(found.words),
        "proposed_um_per_m_K": (found.uncertainty * 1e6).tolist(),
        "random_um_per_m_K": (found.random * 1e6).tolist(),
    }


def hexapod_validation_facts(found: HexapodValidation) -> dict[str, Any]:
    """Return a validation as plain values."""

    def figure(one: Figure, scale: float = 1.0) -> dict[str, float | None]:
        """Return a number with its interval."""
        return {"value": plain(one.value * scale), "low": plain(one.low * scale), "high": plain(one.high * scale)}

    def scores(all_of: dict[str, PoseScore]) -> dict[str, Any]:
        """Return the quantities of a run."""
        return {
            name: {"unit": unit_of(name), "rms_before": figure(one.before, 1e6), "rms_after": figure(one.after, 1e6),
                   "largest_before": one.largest_before * 1e6, "largest_after": one.largest_after * 1e6,
                   "reduction": figure(one.reduction)}
            for name, one in all_of.items()
        }  # fmt: skip

    return {
        "kind": "hexapod",
        "machine": found.rows.hexapod.name,
        "verdict": {name: one.value for name, one in found.verdict.items()},
        "poses": len(found.rows),
        "total": scores(found.total),
        "runs": {run: scores(one) for run, one in found.runs.items()},
        "best_factor_of_predicted_drift": figure(found.gain),
        "mean_error_after_as_one_motion": {
            run: dict(zip(AXES, (found.frames[k] * 1e6).tolist(), strict=True)) for k, run in enumerate(found.rows.runs)
        },
        "fitted_runs": found.fitted,
        "fitted_runs_known": found.fits_known,
        "rows_left_out": dict(found.rows.left_out),
        "before_without_mean_motion": {"translation_um": found.framed_before[0] * 1e6,
                                       "rotation_urad": found.framed_before[1] * 1e6},
        "after_without_mean_motion": {"translation_um": found.framed[0] * 1e6, "rotation_urad": found.framed[1] * 1e6},
        "notes": list(found.notes),
    }  # fmt: skip

"""Tables of an identification and a validation: for the command line, and as CSV for a report."""

from __future__ import annotations

import csv
from pathlib import Path
from typing import Any

import numpy as np
from rich.table import Table

from hexathermal.learn.coverage import TWO_SIDED
from hexathermal.learn.identification import Identification
from hexathermal.learn.law import IdentifiedLaw
from hexathermal.learn.selection import RankedSets
from hexathermal.learn.validation import Validation
from hexathermal.learn.validation_gain import Gain, RunGain
from hexathermal.learn.validation_scores import Figure, Scores
from hexathermal.predict.table_writing import written_whole
from hexathermal.show.shares import bounded
from hexathermal.show.tables import framed

SHOWN_SETS = 6


def _um(value: float, digits: int = 3) -> str:
    """Return metres as micrometres."""
    return f"{value * 1e6:z.{digits}f}" if np.isfinite(value) else "-"


def _ends(part: Figure) -> str:
    """Return the ends of a part's interval; one landing alone gives none."""
    return f"{_part(part.low)} to {_part(part.high)}" if bounded(part) else "none"


def _part(value: float) -> str:
    """Return a part in percent."""
    return f"{100.0 * value:z.1f} %" if np.isfinite(value) else "-"


def coefficient_rows(law: IdentifiedLaw) -> list[tuple[str, float, float, str]]:
    """Return name, value, standard uncertainty and unit of each coefficient."""
    each = (("A", "um/m/K"), ("B", "um/m/K")) if law.kind == "leg" else (("C", "um/K"), ("D", "um/m/K"))
    names = [(f"{symbol} {sensor}", unit) for symbol, unit in each[: 1 + law.stroked] for sensor in law.sensors]
    values, u = law.coefficients * 1e6, law.standard_uncertainty * 1e6
    return [(name, float(v), float(s), unit) for (name, unit), v, s in zip(names, values, u, strict=True)]


def law_formula(law: IdentifiedLaw) -> str:
    """Return what the coefficients multiply, to be summed over sensors."""
    if law.kind == "leg":
        return "A q0 dT + B q dT"
    return "C dT + D q dT" if law.stroked else "C dT"


def law_table(found: Identification, pretty: bool) -> Table:
    """Return the law's coefficients with their uncertainties and what other ways of fitting give."""
    table = framed(pretty, "coefficient", "value>", "standard\nuncertainty>", "95 % interval", "least\nsquares>",
                   "robust>", "unit")  # fmt: skip
    fit = found.fit
    for k, (name, value, u, unit) in enumerate(coefficient_rows(found.law)):
        half = TWO_SIDED * u
        table.add_row(name, f"{value:z.4f}", f"{u:z.4f}", f"{value - half:z.4f} to {value + half:z.4f}",
                      f"{fit.least_squares[k] * 1e6:z.4f}", f"{fit.robust[k] * 1e6:z.4f}", unit)  # fmt: skip
    return table


def sets_table(found: Identification, pretty: bool) -> Table:
    """Return the best sets of each size on runs left out, and the chosen one."""
    ranked = found.ranked
    judged = ranked.left_out if np.isfinite(ranked.left_out.rmse).any() else ranked.fit
    what = "left out" if judged is ranked.left_out else "fit"
    table = framed(pretty, "sensors", "chosen", "RMSE fit\num>", "RMSE left out\num>", "largest left out\num>",
                   f"mean reduction\n{what}>", f"largest reduction\n{what}>", "condition>")  # fmt: skip
    rows: list[int] = []
    for size in sorted(set(ranked.sizes.tolist())):
        here = np.flatnonzero((ranked.sizes == size) & np.isfinite(judged.rmse))
        rows += here[np.argsort(judged.rmse[here])][:SHOWN_SETS].tolist()
    if found.chosen >= 0 and found.chosen not in rows:
        rows.append(found.chosen)
    for k in rows:
        table.add_row(
            " + ".join(ranked.names[k]), "yes" if k == found.chosen else "", _um(ranked.fit.rmse[k]),
            _um(ranked.left_out.rmse[k]), _um(ranked.left_out.linf[k], 2), _part(judged.mean_reduction[k]),
            _part(judged.largest_reduction[k]), f"{ranked.condition[k]:z.1f}",
        )  # fmt: skip
    return table


def ranking_csv(ranked: RankedSets, file: Path) -> Path:
    """Write every set with its criteria, best first; returns the path."""
    judged = ranked.left_out if np.isfinite(ranked.left_out.rmse).any() else ranked.fit
    front_fit, front_left = set(ranked.front()), set(ranked.front(left_out=True))
    head = ["sensors", "size", "condition", "largest_vif", "rmse_um", "linf_um", "mean_um", "mean_reduction",
            "largest_reduction", "left_out_rmse_um", "left_out_linf_um", "left_out_mean_um",
            "left_out_mean_reduction", "left_out_largest_reduction", "pareto", "left_out_pareto"]  # fmt: skip
    with written_whole(file) as part, part.open("w", encoding="utf-8", newline="") as stream:
        out = csv.writer(stream, lineterminator="\n")
        out.writerow(head)
        for k in np.argsort(np.where(np.isnan(judged.rmse), np.inf, judged.rmse)):
            row: list[Any] = [
                "+".join(ranked.names[k]),
                ranked.sizes[k],
                _cell(ranked.condition[k]),
                _cell(ranked.vif[k]),
            ]
            for one in (ranked.fit, ranked.left_out):
                row += [_cell(value[k] * 1e6) for value in (one.rmse, one.linf, one.mean)]
                row += [_cell(one.mean_reduction[k]), _cell(one.largest_reduction[k])]
            out.writerow([*row, int(k in front_fit), int(k in front_left)])
    return file


def _cell(value: float) -> str:
    """Return a number for a CSV, empty where there is none."""
    return f"{value:.6g}" if np.isfinite(value) else ""


def matrix_of(ranked: RankedSets, by: str, left_out: bool = False) -> tuple[tuple[str, ...], np.ndarray[Any, Any]]:
    """Return the sensors and the symmetric matrix of a criterion [m]: singles on the diagonal, pairs beside it."""
    values = getattr(ranked.left_out if left_out else ranked.fit, by)
    sensors = tuple(names[0] for names in ranked.names if len(names) == 1)
    number = {name: k for k, name in enumerate(sensors)}
    matrix = np.full((len(sensors), len(sensors)), np.nan)
    for names, value in zip(ranked.names, values, strict=True):
        if len(names) <= 2:
            i, j = number[names[0]], number[names[-1]]
            matrix[i, j] = matrix[j, i] = value
    return sensors, matrix


def matrix_csv(ranked: RankedSets, by: str, file: Path) -> Path:
    """Write the matrix of a criterion in micrometres; returns the path."""
    sensors, matrix = matrix_of(ranked, by)
    with written_whole(file) as part, part.open("w", encoding="utf-8", newline="") as stream:
        out = csv.writer(stream, lineterminator="\n")
        out.writerow([f"{by}_um", *sensors])
        for name, row in zip(sensors, matrix * 1e6, strict=True):
            out.writerow([name, *(_cell(value) for value in row)])
    return file


def identification_facts(found: Identification) -> dict[str, Any]:
    """Return an identification as plain values."""
    law, fit, choice, ranked = found.law, found.fit, found.choice, found.ranked

    def one(k: int) -> dict[str, Any]:
        return {"sensors": list(ranked.names[k]), "rmse_um": plain(ranked.fit.rmse[k] * 1e6),
                "linf_um": plain(ranked.fit.linf[k] * 1e6), "left_out_rmse_um": plain(ranked.left_out.rmse[k] * 1e6),
                "left_out_linf_um": plain(ranked.left_out.linf[k] * 1e6),
                "mean_reduction": plain(ranked.fit.mean_reduction[k]),
                "largest_reduction": plain(ranked.fit.largest_reduction[k]),
                "left_out_mean_reduction": plain(ranked.left_out.mean_reduction[k]),
                "left_out_largest_reduction": plain(ranked.left_out.largest_reduction[k])}  # fmt: skip

    single = ranked.best(1, left_out=False)
    off = ranked.off_front(single)
    fitted, judged = (sorted(set(ranked.sizes[np.isfinite(by.rmse)].tolist())) for by in (ranked.fit, ranked.left_out))
    check = found.check
    return {
        "kind": law.kind,
        "sensors": list(law.sensors),
        "coefficients": [
            {"name": name, "value": value, "standard_uncertainty": u,
             "interval_95": [value - TWO_SIDED * u, value + TWO_SIDED * u], "unit": unit,
             "generalised": fit.generalised[k] * 1e6,
             "uncorrected": fit.uncorrected[k] * 1e6, "least_squares": fit.least_squares[k] * 1e6,
             "robust": fit.robust[k] * 1e6, "uncertainty_by_run": plain(np.sqrt(fit.by_run[k, k]) * 1e6)}
            for k, (name, value, u, unit) in enumerate(coefficient_rows(law))
        ],
        "choice": {"reason": choice.reason, "gain_um": plain(choice.gain * 1e6),
                   "gain_uncertainty_um": plain(choice.gain_uncertainty * 1e6),
                   "nested_gain_um": plain(choice.nested_gain * 1e6),
                   "nested_gain_uncertainty_um": plain(choice.nested_gain_uncertainty * 1e6),
                   "nested_rmse_um": plain(choice.nested_rmse * 1e6),
                   "nested_runs": [{"run": run.run, "sensors": list(run.sensors), "rmse_um": run.rmse * 1e6}
                                   for run in choice.nested_runs]},
        "method": law.origin.method,
        "reliability": fit.reliability,
        "corrected_for_sensor_errors": fit.corrected,
        "noise_um": {"row": law.noise.row * 1e6, "landing": law.noise.landing * 1e6, "slow": law.noise.slow * 1e6,
                     "slow_time_s": law.noise.slow_time, "offset": law.noise.offset * 1e6},
        "sensor_noise_K": law.errors.noise.tolist(),
        "sensor_slow_bias_K": law.errors.slow.tolist(),
        "interval_factor": law.factor,
        "rows": int(found.grams.rows.sum()),
        "rows_left_out": int(found.grams.rows_left_out.sum()),
        "runs": list(law.origin.runs),
        "sets": len(ranked.names),
        "chosen": one(found.chosen) if found.chosen >= 0 else None,
        "best": [one(ranked.best(size, left_out=False)) for size in fitted],
        "best_left_out": [one(ranked.best(size)) for size in judged],
        "pareto_front": [one(k) for k in ranked.front()],
        "best_single_off_front_um": {"sensor": ranked.names[single][0], "criterion": "fitted rows",
                                     "rmse": off[0] * 1e6, "linf": off[1] * 1e6},
        "physical": None if check is None else {
            "expansion_um_per_m_K": check.expansion * 1e6, "uncertainty": check.expansion_uncertainty * 1e6,
            "rod_um_per_m_K": check.rod * 1e6, "rod_uncertainty": check.rod_uncertainty * 1e6,
            "like": list(check.like)},
        "notes": list(found.notes),
        "warnings": list(found.warnings),
    }  # fmt: skip


def plain(value: float) -> float | None:
    """Return a number for JSON, None where there is none."""
    return float(value) if np.isfinite(value) else None


def validation_table(found: Validation, pretty: bool) -> Table:
    """Return the scores of each run and of all."""
    table = framed(pretty, "run", "drift largest\num>", "residual largest\num>", "RMSE\num>", "mean |residual|\num>",
                   "mean\nreduction>", "95 % interval", "largest\nreduction>", "inside 95 %>")  # fmt: skip
    rows = [(f"{name} (fitted)" if name in found.fitted else name, one, found.run_coverage[name])
            for name, one in found.runs.items()]  # fmt: skip
    some = 0 < len(found.fitted) < len(found.runs)
    for name, one, inside in (*rows, ("all never fitted" if some else "all", found.total, found.coverage)):
        mean = one.mean_reduction
        table.add_row(name, _um(one.drift_largest, 2), _um(one.linf.value, 2), _um(one.rmse.value),
                      _um(one.mean.value), _part(mean.value), _ends(mean),
                      _part(one.largest_reduction.value), _part(inside))  # fmt: skip
    return table


def gain_table(found: Gain, pretty: bool) -> Table:
    """Return what a law leaves of each run and of all, before and after."""
    table = framed(pretty, "run", "RMSE before\num>", "RMSE after\num>", "RMSE\ngain>", "95 % interval",
                   "largest before\num>", "largest after\num>", "largest\ngain>", "95 % interval")  # fmt: skip
    for name, one in (*found.runs.items(), ("all", found.total)):
        table.add_row(name, _um(one.rmse_before), _um(one.rmse_after.value), _part(one.rmse_gain.value),
                      _ends(one.rmse_gain), _um(one.linf_before, 2),
                      _um(one.linf_after.value, 2), _part(one.linf_gain.value),
                      _ends(one.linf_gain))  # fmt: skip
    return table


def figure_facts(one: Figure, scale: float = 1.0) -> dict[str, float | None]:
    """Return a number with its interval as plain values, null where there is no end."""
    return {"value": one.value * scale, "low": plain(one.low * scale), "high": plain(one.high * scale)}


def gain_facts(found: Gain) -> dict[str, Any]:
    """Return a gain as plain values."""

    def told(one: RunGain) -> dict[str, Any]:
        return {
            "rmse_before_um": one.rmse_before * 1e6, "rmse_after_um": one.rmse_after.value * 1e6,
            "linf_before_um": one.linf_before * 1e6, "linf_after_um": one.linf_after.value * 1e6,
            "rmse_gain": figure_facts(one.rmse_gain), "linf_gain": figure_facts(one.linf_gain),
            "mean_gain": figure_facts(one.mean_gain),
        }  # fmt: skip

    return {"total": told(found.total), "runs": {name: told(one) for name, one in found.runs.items()},
            "proven": found.proven, "skipped": list(found.skipped)}  # fmt: skip


def validation_facts(found: Validation) -> dict[str, Any]:
    """Return a validation as plain values."""

    def scores(one: Scores) -> dict[str, Any]:
        return {
            "rmse_um": figure_facts(one.rmse, 1e6), "linf_um": figure_facts(one.linf, 1e6),
            "mean_um": figure_facts(one.mean, 1e6),
            "drift_rms_um": one.drift_rms * 1e6, "drift_largest_um": one.drift_largest * 1e6,
            "drift_mean_um": one.drift_mean * 1e6, "mean_reduction": figure_facts(one.mean_reduction),
            "largest_reduction": figure_facts(one.largest_reduction), "rms_reduction": figure_facts(one.rms_reduction),
        }  # fmt: skip

    return {
        "verdict": found.verdict.value,
        "rows": found.rows,
        "total": scores(found.total),
        "runs": {name: scores(one) | {"coverage": found.run_coverage[name]} for name, one in found.runs.items()},
        "coverage": found.coverage,
        "mean_half_width_um": found.half_width * 1e6,
        "fitted_runs": found.fitted,
        "fitted_runs_known": found.fits_known,
        "beyond_range": found.outside,
        "motion": [
            {"what": one.name, "landings": one.landings, "mean_um": one.mean * 1e6,
             "standard_uncertainty_um": one.uncertainty * 1e6, "notable": one.notable}
            for one in found.motion
        ],
        "notes": list(found.notes),
    }  # fmt: skip

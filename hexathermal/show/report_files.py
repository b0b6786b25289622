"""The figures of a report as files: each as PNG, SVG and CSV, all or none."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from hexathermal.predict.table_writing import written_folder
from hexathermal.show.figures import draw, laid_out
from hexathermal.show.report_chart import columns_of, csv_text
from hexathermal.show.report_page import Report
from hexathermal.show.report_still import still_figure

ENDINGS = (".png", ".svg", ".csv")


def write_figures(report: Report, folder: Path, progress: Callable[[int, int, str], None]) -> list[Path]:
    """Write each figure of a report as PNG, SVG and CSV into a folder; returns the paths.

    Parameters
    ----------
    report : Report
    folder : Path
        Made where it is missing; files of the same name are replaced.
    progress : callable
        Called as ``progress(done, total, label)``.

    Raises
    ------
    ArgumentError
        The folder is none, or cannot be made.
    """
    names: list[str] = []
    with written_folder(folder, force=True) as part:  # asked before
        for k, chart in enumerate(report.charts):
            progress(k, len(report.charts), f"writing {chart.name}")
            figure = laid_out(still_figure(chart))
            draw(figure, part / f"{chart.name}.svg", "svg")
            draw(figure, part / f"{chart.name}.png", "png")
            (part / f"{chart.name}.csv").write_text(csv_text(columns_of(chart)), encoding="utf-8")
            names += [f"{chart.name}{ending}" for ending in ENDINGS]
    return [folder / name for name in names]

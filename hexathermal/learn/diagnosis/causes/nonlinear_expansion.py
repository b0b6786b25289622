"""Expansion that is not proportional to the temperature."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import product
from typing import Any

import numpy as np

from hexathermal.learn.diagnosis.along_leg import parts_along
from hexathermal.learn.diagnosis.trials import Cause, Parameter, Trial, Workbench
from hexathermal.learn.diagnosis.view import View

CAUSE = Cause(
    name="nonlinear-expansion",
    physics=(
        "The coefficient of expansion changes with the temperature (Invar, polymers), or the thermometer is not "
        "linear; a stroke that was right at 20 degC is then wrong already at the zero."
    ),
    signature="The residual bends smoothly with the temperature in degC; heating and cooling look alike.",
    parameters=(
        Parameter("curvature", "1/K^2", "visible effect of 0.25 to 4 times the noise"),
        Parameter("cubic", "1/K^3", "in its place; likewise"),
    ),
    confused_with=(
        "missing-sensor",
        "thermal-lag",
    ),
    experiment="Soak at three or more temperatures, at rest.",
    words="the expansion is not proportional to the temperature at {target}",
    thermal=True,
    readings=6,
)

STANDARD_DEGC = 20.0
"""Temperature at which lengths are stated (ISO 1): a stroke that was calibrated there is wrong by now."""

FEWEST_PLACES = 3
"""Places along the leg whose squares together say more than those of the law's thermometers."""

MIDDLES, WIDTHS = (0.15, 0.4, 0.65), (0.3, 0.7)
"""Middles of bends, quantiles of the temperature, and their widths over its range."""


def trials(bench: Workbench) -> Iterator[Trial]:
    """Give square and cube of each of the law's temperatures, and bends in its range; the bench's zero is in degC."""
    view = bench.view
    yield from _all_along(bench)
    for sensor in view.base:
        told = view.degC(sensor)
        span = 0.0 if told is None else float(np.ptp(told[0]))
        # the retracted length, the law's own mixture, or the whole length
        for ratio in sorted({0.0, bench.ratios[sensor], *([1.0] if view.kind == "leg" else [])}):
            # of the warming since the zero, by which the law was identified; then of the temperature itself
            yield bench.term(CAUSE.name, "square", sensor, quick=True, sensor=sensor, ratio=ratio)
            yield bench.term(CAUSE.name, "cube", sensor, quick=True, sensor=sensor, ratio=ratio)
            if told is not None and np.ptp(told[1]) > 0.0:  # else both are the same
                yield bench.term(CAUSE.name, "square", sensor, quick=True, sensor=sensor, ratio=ratio,
                                 reference_degC=float(np.median(told[1])))  # fmt: skip
            if told is not None and _measured(view, ratio):
                yield bench.term(CAUSE.name, "square", sensor, quick=True, sensor=sensor, ratio=ratio,
                                 reference_degC=STANDARD_DEGC, calibration_degC=STANDARD_DEGC)  # fmt: skip
        for place, width in product(MIDDLES, WIDTHS):
            if told is None or span <= 0.0:
                break
            middle = float(np.quantile(told[0], place))
            for ratio in sorted({0.0, bench.ratios[sensor]}):
                bent = {"sensor": sensor, "ratio": ratio, "middle_degC": middle, "width_K": width * span}
                yield bench.term(CAUSE.name, "bend", sensor, quick=True, **bent)
                if _measured(view, ratio):
                    yield bench.term(CAUSE.name, "bend", sensor, quick=True, calibration_degC=STANDARD_DEGC, **bent)


def _measured(view: View, ratio: float) -> bool:
    """Return whether part of a length ``q0 + ratio q`` was measured when the scale was; a part's q may count down."""
    return view.moves and (ratio > 0.0 if view.kind == "leg" else ratio != 0.0)


def _all_along(bench: Workbench) -> Iterator[Trial]:
    """Give the squares of all places of a leg together, each for the part of the length that is nearest to it.

    The law's thermometers stand for what goes with the temperature; the square of a leg's does not go with theirs where
    one place is much warmer than others.
    """
    view = bench.view
    placed = [name for name in view.sensors if name in view.positions and view.degC(name) is not None]
    weights = parts_along({name: view.positions[name] for name in placed}, view.length)
    if view.kind != "leg" or len(weights) < FEWEST_PLACES:
        return
    for ratio in sorted({0.0, bench.ratios[bench.main], 1.0}):
        whole: dict[str, Any] = {"sensor": bench.main, "ratio": ratio, "weights": weights}
        yield bench.term(CAUSE.name, "square", None, quick=True, **whole)
        yield bench.term(CAUSE.name, "square", None, quick=True, reference_degC=STANDARD_DEGC, **whole)

"""Figures of the report of a machine: its drawing, its workspace, its law, a simulated day."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from hexathermal.kinematics.workspace import margins
from hexathermal.learn.coverage import TWO_SIDED
from hexathermal.machine.hexapod import Hexapod
from hexathermal.poses import FloatArray, pose_from_coordinates
from hexathermal.predict.budget import AXES
from hexathermal.show.figures import BLACK, BLUE, GREEN, GREY, PURPLE, VERMILION, day_figure, working_hours
from hexathermal.show.report_chart import SIDES, Chart, Curve, Panel
from hexathermal.show.report_thinning import MOST_POINTS, kept_of, thinned_words
from hexathermal.simulate.day import HOUR_S
from hexathermal.simulate.demonstration import Demonstration, largest

TRAVEL_STEPS = 24
"""Halvings by which the end of a travel is found."""

STEPS = 1000
"""Into which the way to the farthest place is parted, to find the first that is out of reach."""

LARGEST_TURN_DEG = 90.0
"""To which turns are looked at."""

SAME = 0.01
"""Joints nearer to each other than this part of the plate are seen at one place."""

LOOKS = ("line", "dashed", "dashdot", "dotted")
LEGS = (BLACK, BLUE, VERMILION, GREEN, PURPLE, GREY)


def drawing_chart(hexapod: Hexapod) -> Chart:
    """Return the machine at home, from above and from the front: joints and legs."""
    base = hexapod.base_joints * 1e3
    platform = (hexapod.platform_joints @ hexapod.home[:3, :3].T + hexapod.home[:3, 3]) * 1e3
    panels = []
    for title, (right, up) in (("From above", (0, 1)), ("From the front", (0, 2))):
        marks: list[Curve] = []
        for joints, name, colour in ((base, "base joints", GREY), (platform, "platform joints", BLUE)):
            order = _around(joints)
            ring = joints[[*order, order[0]]]
            others = platform if joints is base else base
            marks.append(Curve(f"{name.split()[0]} plate", ring[:, right], ring[:, up], colour, "dotted"))
            marks.append(Curve(name, joints[:, right], joints[:, up], colour, "dots",
                               labels=_numbers(joints[:, [right, up]]),
                               places=_sides(joints[:, [right, up]], others[:, [right, up]], order)))  # fmt: skip
        gap = np.full((6, 1, 3), np.nan)
        legs = np.concatenate([base[:, None], platform[:, None], gap], axis=1).reshape(-1, 3)
        marks.append(Curve("legs", legs[:, right], legs[:, up], BLACK))
        axes = "xyz"
        panels.append(Panel(title, tuple(marks), axes[right], axes[up], "mm", "mm", equal=True))
    lengths = hexapod.inverse_kinematics(hexapod.home) * 1e3
    origin = ", ".join(f"{value * 1e3:g}" for value in hexapod.home[:3, 3])
    return Chart(
        "drawing", "The machine at home",
        f"Joints and legs at home, from above and from the front; legs from {lengths.min():.1f} to "
        f"{lengths.max():.1f} mm, platform origin at ({origin}) mm.",
        "Base frame. Numbers are those of the legs.", tuple(panels),
    )  # fmt: skip


def _numbers(seen: FloatArray) -> tuple[str, ...]:
    """Return the numbers of six joints as they are seen: those behind one another share the first one's place.

    Examples
    --------
    >>> _numbers(np.array([[0.0, 0], [1, 0], [0, 0], [2, 0], [3, 0], [1, 0]]))
    ('1, 3', '2, 6', '', '4', '5', '')
    """
    near = np.hypot(*(seen[:, None] - seen).transpose(2, 0, 1)) < SAME * np.ptp(seen, axis=0).max()
    first = near.argmax(axis=1)
    return tuple(", ".join(str(j + 1) for j in np.flatnonzero(first == k)) for k in range(len(seen)))


def _sides(joints: FloatArray, others: FloatArray, order: npt.NDArray[np.int64]) -> tuple[str, ...]:
    """Return where the numbers of six joints stand, as they are seen: farthest from the legs and edges that end there.

    Parameters
    ----------
    joints, others : array, shape (6, 2)
        Of this plate, and of the other one at the same legs.
    order : array, shape (6,)
        Joints round the plate.
    """
    turns = np.arange(len(SIDES)) * np.pi / 4.0
    sides = np.stack([np.cos(turns), np.sin(turns)], axis=1)
    neighbours = np.empty((6, 2), dtype=np.int64)
    neighbours[order] = np.stack([np.roll(order, 1), np.roll(order, -1)], axis=1)
    near = np.hypot(*(joints[:, None] - joints).transpose(2, 0, 1)) < SAME * np.ptp(joints, axis=0).max()
    found = []
    for k in range(len(joints)):
        here = np.flatnonzero(near[k])
        ends = np.concatenate([others[here], joints[neighbours[here].ravel()]]) - joints[k]
        length = np.hypot(*ends.T)
        seen = length > SAME * length.max()
        ends, outward = ends[seen] / length[seen, None], joints[k] - joints.mean(axis=0)
        free = -(sides @ ends.T).max(axis=1, initial=-1.0)
        # where two sides are as free, the one away from the middle
        free += 1e-3 * (sides @ outward) / max(float(np.hypot(*outward)), 1e-9)
        found.append(SIDES[int(free.argmax())])
    return tuple(found)


def _around(joints: FloatArray) -> npt.NDArray[np.int64]:
    """Return the order of joints round their centre."""
    offset = joints - joints.mean(axis=0)
    return np.asarray(np.argsort(np.arctan2(offset[:, 1], offset[:, 0])), dtype=np.int64)


def travels(hexapod: Hexapod) -> dict[str, tuple[float, float]]:
    """Return how far each coordinate goes from home, the others kept there [mm, deg]; 0 where home cannot be held.

    The first end that is met on the way out, in steps of a thousandth of `farthest`, which then are halved; where none
    is met, `farthest`.
    """
    return {axis: (_end(hexapod, k, -1.0), _end(hexapod, k, 1.0)) for k, axis in enumerate(AXES)}


def farthest(hexapod: Hexapod, k: int) -> float:
    """Return how far a coordinate's travel is looked for: twice the longest leg [mm], or a right angle [deg]."""
    if k >= 3:
        return LARGEST_TURN_DEG
    return 2e3 * float(np.max(hexapod.inverse_kinematics(hexapod.home)) + np.ptp(np.asarray(hexapod.stroke)))


def _end(hexapod: Hexapod, k: int, sign: float) -> float:
    """Return where a coordinate's travel ends on one side."""

    def reached(values: FloatArray) -> FloatArray:
        six = np.zeros((len(values), 6))
        six[:, k] = values
        return np.atleast_1d(margins(hexapod, pose_from_coordinates(six, hexapod=hexapod)).reachable)

    far = sign * farthest(hexapod, k)
    steps = np.linspace(0.0, far, STEPS + 1)
    held = reached(steps)
    if not held[0]:
        return 0.0
    if held.all():
        return far
    first = int(np.argmin(held))
    low, high = steps[first - 1], steps[first]
    for _halving in range(TRAVEL_STEPS):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if reached(np.array([middle]))[0] else (low, middle)
    return float(low)


def workspace_chart(hexapod: Hexapod, found: dict[str, tuple[float, float]]) -> Chart:
    """Return what is left to the nearest limit and the condition number along each coordinate from home."""
    panels, words = [], []
    for names, unit in ((("x", "y", "z"), "mm"), (("rx", "ry", "rz"), "deg")):
        shares, conditions = [], []
        for j, axis in enumerate(names):
            along = np.linspace(*found[axis], 81)
            six = np.zeros((81, 6))
            six[:, list(found).index(axis)] = along
            left = margins(hexapod, pose_from_coordinates(six, hexapod=hexapod))
            look = (LEGS[1 + j], LOOKS[j])
            shares.append(Curve(axis, along, 100.0 * np.asarray(left.share), *look))
            conditions.append(Curve(axis, along, np.asarray(left.condition_number), *look))
            words.append(f"{axis} {found[axis][0]:.1f} to {found[axis][1]:.1f} {unit}")
        what = "shift from home" if unit == "mm" else "turn from home"
        shown = unit.replace("deg", "°")
        panels.append(Panel(f"Left of the nearest limit: {what.split()[0]}", tuple(shares), what, "left", shown, "%"))
        panels.append(Panel(f"Condition number: {what.split()[0]}", tuple(conditions), what, "condition number", shown))
    return Chart(
        "workspace", "Along each coordinate from home",
        f"What is left to the nearest limit along each coordinate; travel: {'; '.join(words)}.",
        "One coordinate moves, the others stay at home. 100 % is mid-range, 0 % on a limit of stroke, cone or travel.",
        tuple(panels),
    )  # fmt: skip


def law_chart(hexapod: Hexapod) -> Chart | None:
    """Return the drift of each leg for 1 K of its thermometers, against displacement; None without q0 and stroke."""
    model = hexapod.thermal
    if model is None or hexapod.retracted_length is None or hexapod.stroke is None:
        return None
    q0 = np.broadcast_to(np.asarray(hexapod.retracted_length), 6)
    stroke = np.broadcast_to(np.asarray(hexapod.stroke), (6, 2))
    curves, sizes, seen = list[Curve](), list[tuple[float, float]](), list[tuple[bytes, ...]]()
    for k, law in enumerate(model.legs):
        key = (law.A.tobytes(), law.B.tobytes(), q0[k].tobytes(), stroke[k].tobytes(),
               b"" if law.covariance is None else law.covariance.tobytes())  # fmt: skip
        if key in seen:
            continue
        seen.append(key)
        q = np.linspace(float(stroke[k, 0]), float(stroke[k, 1]), 41)
        columns = np.concatenate([np.full((41, len(law.A)), q0[k]), np.repeat(q[:, None], len(law.B), axis=1)], axis=1)
        drift = columns @ np.concatenate([law.A, law.B]) * 1e6
        low = high = None
        if law.covariance is not None:
            half = 1e6 * TWO_SIDED * np.sqrt(np.einsum("ni,ij,nj->n", columns, law.covariance, columns))
            low, high = drift - half, drift + half
        curves.append(Curve(f"leg {k + 1}", q * 1e3, drift, LEGS[k], LOOKS[len(curves) % 4], low, high))
        sizes.append((float(drift.min()), float(drift.max())))
    shared = len(curves) == 1
    if shared:
        one = curves[0]
        curves = [Curve("legs 1 to 6", one.x, one.y, BLUE, "line", one.low, one.high)]
    known = any(one.low is not None for one in curves)
    band = "Band: 95 %, by the covariance that the machine's file states." if known else \
        "The file states no covariance: how well the coefficients are known is not told."  # fmt: skip
    terms = " Terms that extend the law are not in it." if any(law.terms for law in model.legs) else ""
    panel = Panel("Drift for 1 K", tuple(curves), "displacement q", "drift", "mm", "µm/K", height=1.3)
    return Chart(
        "law", "Drift of a leg that is 1 K warmer",
        f"Drift for 1 K against the displacement of the leg, from {min(low for low, _ in sizes):.3f} to "
        f"{max(high for _, high in sizes):.3f} µm/K{', the same for all legs' if shared else ''}.",
        f"All thermometers of the leg 1 K above the reference. {band}{terms}", (panel,),
    )  # fmt: skip


def day_chart(day: Demonstration) -> Chart:
    """Return a simulated day: temperatures, and the platform's error with and without correction."""
    truth, without, with_ = day.truth, largest(day.errors_without), largest(day.errors_with)
    plates = np.stack([truth.platform, truth.base, truth.room], axis=1)
    errors = (np.stack([without[k], with_[k]], axis=1) for k in range(2))
    rows = kept_of(len(truth.time), MOST_POINTS, np.concatenate([truth.legs, plates], axis=1), *errors)
    hours = day.truth.time[rows] / HOUR_S
    shaded = working_hours(day)
    heat = [Curve(f"leg {k + 1}", hours, truth.legs[rows, k], BLACK) for k in range(truth.legs.shape[1])]
    heat += [Curve("platform plate", hours, truth.platform[rows], GREEN),
             Curve("base plate", hours, truth.base[rows], PURPLE, "dashdot"),
             Curve("room", hours, truth.room[rows], GREY, "dotted")]  # fmt: skip
    panels = [Panel("True temperatures (shaded: the machine works)", tuple(heat), "time", "temperature", "h", "°C",
                    height=1.25, shaded=shaded)]  # fmt: skip
    words = []
    for k, (what, unit) in enumerate((("shift", "µm"), ("turn", "µrad"))):
        marks = (Curve("without correction", hours, without[k][rows], VERMILION, "dashed"),
                 Curve("with correction", hours, with_[k][rows], BLUE))  # fmt: skip
        panels.append(Panel(f"Largest {what} of the platform", marks, "time", what, "h", unit, shaded=shaded))
        words.append(f"{what} {without[k].max():.2f} to {with_[k].max():.2f} {unit}")
    return Chart(
        "day", "A warm day",
        f"Temperatures and errors over {truth.time[-1] / HOUR_S:.0f} hours. Largest error of {len(day.poses)} work "
        f"poses without and with correction: {'; '.join(words)}.",
        f"Errors are the largest of {len(day.poses)} work poses.{thinned_words(len(rows), len(truth.time))}",
        tuple(panels),
        lambda: day_figure(day), True,
    )  # fmt: skip

"""Draw each bundled machine at home: models/<name>/picture.png.

Run from the repository's root: ``python tools/draw_models.py``, or with names to draw only those.  Orthographic views
with equal scales; legs have the diameters of `hexathermal.machine.pinocchio_loads.machine_shapes`, which are derived
where a machine states none.
"""

from __future__ import annotations

import sys
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import matplotlib as mpl
import numpy as np

import hexathermal as ht
from hexathermal.machine.library import models_folder
from hexathermal.machine.pinocchio_loads import machine_shapes
from hexathermal.poses import FloatArray

mpl.use("Agg")

import matplotlib.pyplot as plt

INK, BASE, PLATFORM, BODY, ROD = "#1f2937", "#475569", "#1d6fb8", "#9aa5b4", "#dbe1e8"
AXES = ("#c2362b", "#2f8f46", "#2b5fc7")
SIZE_IN, DPI = (10.0, 6.4), 110


@dataclass(frozen=True)
class View:
    """An orthographic view: unit vectors of the base frame that point right, up and towards the eye."""

    right: FloatArray
    up: FloatArray

    @property
    def towards(self) -> FloatArray:
        """From the scene to the eye."""
        return np.asarray(np.cross(self.right, self.up))

    def flat(self, points: FloatArray) -> FloatArray:
        """Return points (..., 3) [m] on the sheet (..., 2) [mm]."""
        return np.asarray(1e3 * points @ np.column_stack([self.right, self.up]))


def oblique(azimuth_deg: float, elevation_deg: float) -> View:
    """Return the view from an azimuth about z and an elevation above the plane."""
    a, e = np.radians([azimuth_deg, elevation_deg])
    right = np.array([-np.sin(a), np.cos(a), 0.0])
    eye = np.array([np.cos(e) * np.cos(a), np.cos(e) * np.sin(a), np.sin(e)])
    return View(right, np.asarray(np.cross(eye, right)))


ABOVE = View(np.array([1.0, 0.0, 0.0]), np.array([0.0, 1.0, 0.0]))
FRONT = View(np.array([1.0, 0.0, 0.0]), np.array([0.0, 0.0, 1.0]))


def planes_of(joints: FloatArray) -> list[FloatArray]:
    """Return the joints of each level (to 1 mm) that holds three or more, in order round their centre."""
    levels = np.round(joints[:, 2], 3)
    rings = []
    for level in np.unique(levels):
        ring = joints[levels == level]
        if len(ring) >= 3:
            offset = ring[:, :2] - ring[:, :2].mean(axis=0)
            rings.append(ring[np.argsort(np.arctan2(offset[:, 1], offset[:, 0]))])
    return rings


class Sheet:
    """One view of one machine: solids are collected, then drawn from back to front."""

    def __init__(self, ax: Any, view: View, hexapod: ht.Hexapod) -> None:
        self.ax, self.view, self.hexapod = ax, view, hexapod
        self.base = hexapod.base_joints
        self.platform = hexapod.platform_joints @ hexapod.home[:3, :3].T + hexapod.home[:3, 3]
        self.shapes = machine_shapes(hexapod)
        self.solids: list[tuple[float, Any]] = []

    def add(self, point: FloatArray, patch: Any) -> None:
        """Keep a patch and how near it is to the eye."""
        self.solids.append((float(point @ self.view.towards), patch))

    def plates(self) -> None:
        """Add the plates: the polygons of joints that lie level."""
        for joints, colour in ((self.base, BASE), (self.platform, PLATFORM)):
            for ring in planes_of(joints):
                corners = self.view.flat(ring)
                patch = mpl.patches.Polygon(
                    corners, closed=True, facecolor=mpl.colors.to_rgba(colour, 0.16), edgecolor=colour, linewidth=1.1
                )
                self.add(ring.mean(axis=0), patch)

    def tube(self, start: FloatArray, end: FloatArray, diameter: float, colour: str) -> None:
        """Add a tube between two points [m]."""
        a, b = self.view.flat(start), self.view.flat(end)
        along = b - a
        length = float(np.linalg.norm(along))
        across = np.array([-along[1], along[0]]) / length if length > 1e-6 else np.array([1.0, 0.0])
        half = 500.0 * diameter * across
        patch = mpl.patches.Polygon(
            np.array([a + half, b + half, b - half, a - half]),
            closed=True,
            facecolor=colour,
            edgecolor=INK,
            linewidth=0.7,
        )
        self.add(0.5 * (start + end), patch)

    def legs(self) -> None:
        """Add body and rod of each leg."""
        bodies = self.shapes.bodies
        for leg, (start, end) in enumerate(zip(self.base, self.platform, strict=True)):
            unit = (end - start) / np.linalg.norm(end - start)
            middle = start + self.shapes.body_lengths[leg] * unit
            self.tube(middle, end, bodies.leg_rod_diameter, ROD)
            self.tube(start, middle, bodies.leg_body_diameter, BODY)

    def draw(self) -> None:
        """Draw all solids, the farthest first."""
        for k, (_depth, patch) in enumerate(sorted(self.solids, key=lambda item: item[0])):
            patch.set_zorder(2 + 0.001 * k)
            self.ax.add_patch(patch)

    def joints(self) -> None:
        """Draw the joints as numbered discs, the nearer ones above."""
        for joints, colour in ((self.base, BASE), (self.platform, PLATFORM)):
            for leg, point in enumerate(joints):
                z = 6.0 + 0.1 * float(point @ self.view.towards)
                flat = self.view.flat(point)
                self.ax.plot(
                    *flat, "o", color=colour, markersize=12.5, markeredgecolor="white", markeredgewidth=0.9, zorder=z
                )
                self.ax.annotate(
                    str(leg + 1), flat, (0, -0.4), textcoords="offset points", zorder=z, color="white", fontsize=8,
                    fontweight="bold", ha="center", va="center",
                )  # fmt: skip

    def circles(self) -> None:
        """Draw the circles on which joints lie, with their radii, where all six do to 0.5 mm."""
        bodies = ((self.base, BASE, 60.0, 1.0, "left"), (self.platform, PLATFORM, 0.0, -1.0, "right"))
        for joints, colour, angle_deg, side, anchor in bodies:
            centre = joints.mean(axis=0)
            radii = 1e3 * np.linalg.norm((joints - centre)[:, :2], axis=1)
            if np.ptp(radii) > 0.5:
                continue
            radius, middle = float(radii.mean()), self.view.flat(centre)
            x, y = middle.tolist()
            circle = mpl.patches.Circle(
                (x, y), radius, fill=False, edgecolor=colour, linewidth=0.8, linestyle=(0, (5, 4)), zorder=1
            )
            self.ax.add_patch(circle)
            a = np.radians(angle_deg)
            place = middle + (radius + side * 0.05 * radius) * np.array([np.cos(a), np.sin(a)])
            self.ax.text(
                *place, f"R {radius:.1f} mm", color=colour, fontsize=8.5, ha=anchor, va="center", zorder=5,
                bbox={"boxstyle": "round,pad=0.15", "facecolor": "white", "edgecolor": "none", "alpha": 0.75},
            )  # fmt: skip

    def frame(self, pose: FloatArray, name: str, length: float, offset: tuple[float, float]) -> None:
        """Draw a frame's axes [m] and its name."""
        origin = self.view.flat(pose[:3, 3])
        for axis, (letter, colour) in enumerate(zip("xyz", AXES, strict=True)):
            tip = self.view.flat(pose[:3, 3] + length * pose[:3, axis])
            if np.linalg.norm(tip - origin) < 0.2 * 1e3 * length:
                continue
            self.ax.annotate(
                "",
                tip,
                origin,
                zorder=5,
                arrowprops={"arrowstyle": "-|>", "color": colour, "lw": 1.6, "shrinkA": 0, "shrinkB": 0},
            )
            self.ax.text(
                *(tip + 0.16 * (tip - origin)), letter, color=colour, fontsize=9, ha="center", va="center", zorder=9
            )
        self.ax.plot(*origin, "o", color=INK, markersize=3.2, zorder=9)
        self.ax.annotate(
            name,
            origin,
            offset,
            textcoords="offset points",
            color=INK,
            fontsize=8.5,
            style="italic",
            ha="right",
            va="center",
            zorder=9,
        )


def scale_bar(ax: Any, length_mm: float) -> None:
    """Draw a scale bar into the lower left corner."""
    (left, right), (bottom, top) = ax.get_xlim(), ax.get_ylim()
    x, y, tick = left + 0.03 * (right - left), bottom + 0.035 * (top - bottom), 0.008 * (top - bottom)
    ax.plot(
        [x, x, x, x + length_mm, x + length_mm, x + length_mm],
        [y - tick, y + tick, y, y, y + tick, y - tick],
        color=INK,
        lw=1.2,
    )
    ax.text(x + length_mm / 2, y + 1.6 * tick, f"{length_mm:g} mm", ha="center", va="bottom", fontsize=8.5, color=INK)


def limits(ax: Any, sheet: Sheet, frames: list[FloatArray], margin: float) -> None:
    """Give both axes one scale and room for all joints and frames."""
    tips = [frame[:3, 3] + 1.2e-3 * margin * np.vstack([np.zeros(3), frame[:3, :3].T]) for frame in frames]
    points = [sheet.base, sheet.platform, *tips]
    if sheet.view is ABOVE:
        for joints in (sheet.base, sheet.platform):
            radius = np.linalg.norm((joints - joints.mean(axis=0))[:, :2], axis=1).mean()
            points.append(joints.mean(axis=0) + radius * np.array([[1, 0, 0], [-1, 0, 0], [0, 1, 0], [0, -1, 0]]))
    flat = sheet.view.flat(np.concatenate(points))
    low, high = flat.min(axis=0) - margin, flat.max(axis=0) + 0.7 * margin
    ax.set_xlim(low[0], high[0])
    ax.set_ylim(low[1] - 0.6 * margin, high[1])
    ax.set_aspect("equal")
    ax.axis("off")


def picture(hexapod: ht.Hexapod, file: Path) -> None:
    """Draw one machine at home: oblique view, from above, from the front."""
    size = 1e3 * float(np.linalg.norm(hexapod.base_joints - hexapod.base_joints.mean(axis=0), axis=1).mean())
    frames = [np.eye(4), np.array(hexapod.home)]
    same = bool(np.abs(frames[0] - frames[1]).max() < 1e-9)
    heights = np.concatenate([hexapod.base_joints[:, 2], [0.0, hexapod.home[2, 3]]])
    tall = 1e3 * float(np.ptp(heights)) > 2.2 * size
    figure = plt.figure(figsize=SIZE_IN, dpi=DPI, facecolor="white")
    grid = figure.add_gridspec(
        2, 2, width_ratios=(1.45, 1.0), height_ratios=(1.0, 1.15) if tall else (1.25, 1.0), wspace=0.02, hspace=0.09,
        left=0.01, right=0.99, top=0.92, bottom=0.02,
    )  # fmt: skip
    places = (grid[0, 0], grid[1, 0], grid[:, 1]) if tall else (grid[:, 0], grid[0, 1], grid[1, 1])
    nice = 10.0 ** np.floor(np.log10(size))
    bar = float(nice * max(n for n in (1, 2, 5) if n * nice <= 0.7 * size))
    views = (
        ("oblique", oblique(-62.0, 24.0)),
        ("from above: x right, y up", ABOVE),
        ("from the front: x right, z up", FRONT),
    )
    for place, (name, view) in zip(places, views, strict=True):
        ax = figure.add_subplot(place)
        sheet = Sheet(ax, view, hexapod)
        shown = [] if view is ABOVE or (tall and view is not FRONT) or (same and view is FRONT) else frames
        limits(ax, sheet, shown, 0.33 * size)
        sheet.plates()
        sheet.legs()
        sheet.draw()
        if view is ABOVE:
            sheet.circles()
        sheet.joints()
        if same and shown:
            sheet.frame(frames[0], "base and platform", 0.3e-3 * size, (30, -17))
        elif shown:
            sheet.frame(frames[0], "base", 0.3e-3 * size, (-6, 7 if tall else -9))
            sheet.frame(frames[1], "platform (pivot)", 0.3e-3 * size, (-6, -9))
        scale_bar(ax, bar)
        ax.set_title(name, fontsize=9.5, color=INK, pad=2)
    lengths = 1e3 * hexapod.inverse_kinematics(hexapod.home)
    spread = f"{lengths.min():.1f}" if np.ptp(lengths) < 0.05 else f"{lengths.min():.1f} to {lengths.max():.1f}"
    figure.text(
        0.015,
        0.965,
        f"{hexapod.name} at home, legs {spread} mm",
        fontsize=12,
        color=INK,
        fontweight="bold",
        va="center",
    )
    figure.legend(
        handles=[mpl.lines.Line2D([], [], color=colour, marker="o", markersize=8, linestyle="none", label=label)
                 for colour, label in ((BASE, "base joints"), (PLATFORM, "platform joints"))],
        loc="upper right", fontsize=8.5, frameon=False, ncols=2, bbox_to_anchor=(0.995, 0.99),
    )  # fmt: skip
    # no date, no version: the same machine gives the same file
    figure.savefig(file, metadata={"Software": None}, pil_kwargs={"optimize": True})
    plt.close(figure)


if __name__ == "__main__":
    for name in sys.argv[1:] or ht.bundled_hexapods():
        target = models_folder() / name / "picture.png"
        picture(ht.load_hexapod(name), target)
        print(f"{target}: {target.stat().st_size / 1e3:.0f} kB")

"""A machine at home as a small drawing for notebooks, in the colours of the page around it."""

from __future__ import annotations

import numpy as np

from hexathermal.machine.hexapod import Hexapod
from hexathermal.poses import FloatArray
from hexathermal.show.diagnosis_page import text

WIDTH, HEIGHT, MARGIN = 340.0, 250.0, 22.0
AZIMUTH_DEG, ELEVATION_DEG = -60.0, 20.0
BODY_SHARE = 0.55
"""Part of a leg that is drawn as its thick body."""


def machine_drawing(hexapod: Hexapod) -> str:
    """Return the machine at home as SVG: plates, numbered legs, and a length to compare with."""
    base, platform = hexapod.base_joints, hexapod.platform_joints @ hexapod.home[:3, :3].T + hexapod.home[:3, 3]
    flat, scale = _flat(np.concatenate([base, platform]))
    feet, heads = flat[:6], flat[6:]
    legs, names = "", ""
    for k, (foot, head) in enumerate(zip(feet, heads, strict=True)):
        middle = foot + BODY_SHARE * (head - foot)
        legs += _line(foot, middle, 6.0) + _line(middle, head, 2.5) + _dot(foot) + _dot(head)
        outward = foot + 12.0 * np.sign(foot[0] - feet[:, 0].mean()) * np.array([1.0, 0.0])
        names += f'<text x="{outward[0]:.1f}" y="{outward[1] + 4.0:.1f}" text-anchor="middle">{k + 1}</text>'
    bar = _round_length(0.25 * WIDTH / scale)
    start, end = np.array([MARGIN, HEIGHT - 6.0]), np.array([MARGIN + bar * scale, HEIGHT - 6.0])
    label = f'<text x="{end[0] + 6.0:.1f}" y="{end[1] + 3.0:.1f}">{bar * 1e3:g} mm</text>'
    name = text(f"Hexapod {hexapod.name} at home, seen from the side and a little above; legs 1 to 6")
    return (
        f'<svg role="img" aria-label="{name}" viewBox="0 0 {WIDTH:g} {HEIGHT:g}" width="{WIDTH:g}" height="{HEIGHT:g}" '
        'fill="none" stroke="currentColor" stroke-linecap="round" stroke-linejoin="round">'
        f"{_plate(feet)}{legs}{_plate(heads)}{_line(start, end, 2.0)}"
        f'<g fill="currentColor" stroke="none" font-size="11">{names}{label}</g></svg>'
    )


def _flat(points: FloatArray) -> tuple[FloatArray, float]:
    """Return points (n, 3) [m] on the sheet (n, 2), and how many units of the sheet a metre has."""
    a, e = np.radians([AZIMUTH_DEG, ELEVATION_DEG])
    right = np.array([-np.sin(a), np.cos(a), 0.0])
    up = np.array([-np.sin(e) * np.cos(a), -np.sin(e) * np.sin(a), np.cos(e)])
    seen = np.column_stack([points @ right, -(points @ up)])
    low, high = seen.min(axis=0), seen.max(axis=0)
    room = np.array([WIDTH, HEIGHT - 16.0]) - 2.0 * MARGIN
    scale = float((room / np.maximum(high - low, 1e-9)).min())
    return np.asarray((seen - low) * scale + MARGIN + 0.5 * (room - (high - low) * scale)), scale


def _plate(joints: FloatArray) -> str:
    """Return the outline of a plate: its joints on the sheet, in their order around the middle."""
    away = joints - joints.mean(axis=0)
    around = joints[np.argsort(np.arctan2(away[:, 1], away[:, 0]))]
    corners = " ".join(f"{x:.1f},{y:.1f}" for x, y in around)
    return f'<polygon points="{corners}" fill="currentColor" fill-opacity="0.12" stroke-width="2"/>'


def _line(start: FloatArray, end: FloatArray, width: float) -> str:
    """Return a line."""
    ends = f'x1="{start[0]:.1f}" y1="{start[1]:.1f}" x2="{end[0]:.1f}" y2="{end[1]:.1f}"'
    return f'<line {ends} stroke-width="{width:g}"/>'


def _dot(centre: FloatArray) -> str:
    """Return a joint."""
    return f'<circle cx="{centre[0]:.1f}" cy="{centre[1]:.1f}" r="4" fill="currentColor" stroke="none"/>'


def _round_length(length: float) -> float:
    """Return 1, 2 or 5 times a power of ten that is no longer than a length.

    Examples
    --------
    >>> _round_length(0.13), _round_length(0.049)
    (0.1, 0.02)
    """
    power = 10.0 ** np.floor(np.log10(length))
    return float(max(step for step in (1.0, 2.0, 5.0) if step * power <= length) * power)

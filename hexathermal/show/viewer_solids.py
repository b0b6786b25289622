"""The solids of a machine for the viewer: derived from its geometry, or read from its folder's own meshes.

Each part hangs on one of four frames: the base, the platform, a leg's body (origin at the base joint, z along the leg)
or a leg's rod (origin at the platform joint, the same z). A folder's own meshes stand in ``meshes/`` beside its
hexapod.toml, in millimetres in these frames: ``base``, ``platform``, ``body`` and ``rod`` for all legs or ``leg1_body``
for one of them, with the ending .stl, .obj, .ply, .off or .glb. What is not there is derived.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from hexathermal.errors import ArgumentError, FileFormatError, Problem
from hexathermal.machine.hexapod import Hexapod
from hexathermal.poses import FloatArray

FOLDER, ENDINGS = "meshes", (".stl", ".obj", ".ply", ".off", ".glb")
LARGEST_MESHES = 60_000
"""Triangles of all own meshes together: some 3 MB of page."""

SHARP_RAD = 0.6
"""Edges between faces that turn by more stay edges; others are drawn smooth."""

NAMES = ("base", "platform", *(f"leg{leg}_{part}" for leg in range(1, 7) for part in ("body", "rod")))
"""Parts of a machine; joints belong to the plate they sit on."""


@dataclass(frozen=True, eq=False)
class Part:
    """A solid to draw.

    Attributes
    ----------
    name : str
        One of `NAMES`; joints are called after their plate, ``base_joints``.
    frame : str
        One of `NAMES`: what it hangs on.
    vertices : array, shape (v, 3) [m]
    faces : array, shape (f, 3), int
    colour : (float, float, float)
        Red, green, blue, 0 to 1.
    """

    name: str
    frame: str
    vertices: FloatArray
    faces: npt.NDArray[np.int64]
    colour: tuple[float, float, float]


def machine_parts(hexapod: Hexapod, folder: Path | None = None) -> tuple[Part, ...]:
    """Return the solids of a machine.

    Parameters
    ----------
    hexapod : Hexapod
        Sizes come from its geometry and its `bodies`.
    folder : Path, optional
        The machine's own, for `meshes/` in it.

    Raises
    ------
    FileFormatError
        A mesh cannot be read, or holds no triangles.
    ArgumentError
        A name in `meshes/` is none of a part, a part is there twice, or meshes are too large for a page.
    """
    own = _own_meshes(folder)
    parts: dict[str, Part] = {}
    for name, frame, mesh in _derived(hexapod):
        colour = _colour(mesh)
        # a plate that was drawn brings its joints along
        if frame in own and name != frame:
            continue
        chosen = own.get(name, mesh)
        before = parts.get(name)
        part = _part(name, frame, chosen, colour)
        parts[name] = part if before is None else _joined(before, part)
    return tuple(parts.values())


def _derived(hexapod: Hexapod) -> list[tuple[str, str, Any]]:
    """Return name, frame and mesh in that frame of every solid, from the machine's geometry at home."""
    from hexathermal.machine.pinocchio_model import PinocchioMachine

    home = hexapod.home
    found = []
    for solid in PinocchioMachine(hexapod).geometry(home):
        name = solid.name
        if name.endswith("_joint"):
            frame = name.split("_")[1]
            name = f"{frame}_joints"
        else:
            frame = name
        mesh = solid.mesh.copy()
        mesh.apply_transform(np.linalg.inv(_frame_at_home(hexapod, frame)) @ solid.pose)
        found.append((name, frame, mesh))
    return found


def _frame_at_home(hexapod: Hexapod, frame: str) -> FloatArray:
    """Return a part's frame in the base at home (4, 4)."""
    if frame == "base":
        return np.eye(4)
    if frame == "platform":
        return hexapod.home
    leg = int(frame[3]) - 1
    low = hexapod.base_joints[leg]
    high = hexapod.home[:3, :3] @ hexapod.platform_joints[leg] + hexapod.home[:3, 3]
    pose = np.eye(4)
    z = (high - low) / np.linalg.norm(high - low)
    x = np.cross(np.eye(3)[np.abs(z).argmin()], z)
    x /= np.linalg.norm(x)
    pose[:3, :3] = np.column_stack([x, np.cross(z, x), z])
    pose[:3, 3] = low if frame.endswith("body") else high
    return pose


def _part(name: str, frame: str, mesh: Any, colour: tuple[float, float, float]) -> Part:
    """Return a mesh as a part whose sharp edges stay sharp."""
    from trimesh.graph import smooth_shade

    drawn = smooth_shade(mesh, angle=SHARP_RAD)
    return Part(name, frame, np.asarray(drawn.vertices), np.asarray(drawn.faces, dtype=np.int64), colour)


def _joined(one: Part, other: Part) -> Part:
    """Return two solids on one frame as one."""
    return Part(
        one.name, one.frame, np.concatenate([one.vertices, other.vertices]),
        np.concatenate([one.faces, other.faces + len(one.vertices)]), one.colour,
    )  # fmt: skip


def _colour(mesh: Any) -> tuple[float, float, float]:
    """Return the colour of a mesh's first face."""
    red, green, blue = (float(value) / 255.0 for value in np.asarray(mesh.visual.face_colors)[0, :3])
    return red, green, blue


def _own_meshes(folder: Path | None) -> dict[str, Any]:
    """Return the meshes of a machine's folder by part, in metres."""
    place = None if folder is None else folder / FOLDER
    if place is None or not place.is_dir():
        return {}
    files: dict[str, Path] = {}
    for file in sorted(item for item in place.iterdir() if item.suffix.lower() in ENDINGS):
        if file.stem not in (*NAMES, "body", "rod"):
            raise ArgumentError(
                f"{file} is named after no part; use base, platform, body, rod, or leg1_body, leg1_rod .."
            )
        if file.stem in files:
            raise ArgumentError(f"{place} holds {files[file.stem].name} and {file.name}: keep one of them")
        files[file.stem] = file
    read = {name: _read_mesh(file) for name, file in files.items()}
    meshes = {}
    for name in NAMES:
        chosen = read.get(name, read.get(name.split("_")[-1]))
        if chosen is not None:
            meshes[name] = chosen
    count = sum(len(mesh.faces) for mesh in meshes.values())
    if count > LARGEST_MESHES:
        raise ArgumentError(
            f"the meshes in {place} make {count} triangles, {LARGEST_MESHES} may be drawn (body and rod count six "
            "times); simplify them"
        )
    return meshes


def _read_mesh(file: Path) -> Any:
    """Return one mesh, millimetres turned into metres."""
    import trimesh

    try:
        mesh = trimesh.load_mesh(str(file))
        if isinstance(mesh, trimesh.Scene):
            mesh = mesh.to_mesh()
        count = len(mesh.faces)
    except Exception as error:  # each format fails in its own way
        raise FileFormatError(str(file), (Problem(1, 1, f"cannot be read as a mesh: {error}"),)) from None
    if not count or not np.isfinite(mesh.vertices).all():
        raise FileFormatError(str(file), (Problem(1, 1, "holds no triangles, or vertices that are not finite"),))
    mesh.apply_scale(1e-3)
    return mesh

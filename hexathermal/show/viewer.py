"""The viewer: a machine in three dimensions, coloured by temperature, on a page that needs nothing from elsewhere.

meshcat draws. Its program, the solids in its own messages, the frames as JSON and the page's own controls stand in one
HTML file; the live page is the same file, served to this computer alone. A drift is drawn magnified: with error
``[e, w]`` of the tool point the platform is drawn turned by ``exp(m w)`` and its tool point shifted by ``m e``; legs
run between the joints as drawn.
"""

from __future__ import annotations

import base64
import json
import threading
import webbrowser
from collections.abc import Callable
from http import HTTPStatus
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path
from typing import Any

import numpy as np

from hexathermal.errors import ArgumentError
from hexathermal.poses import FloatArray
from hexathermal.show.viewer_course import ORIGIN, Course
from hexathermal.show.viewer_page import page
from hexathermal.show.viewer_solids import Part, machine_parts

DRAWN_SHARE, LARGEST_TURN_RAD = 0.15, 0.35
"""Of a magnification that is chosen: largest drawn shift against the mean leg, and largest drawn turn."""

SCALE, STOPS = "plasma", 32
"""Colours of temperatures, of matplotlib's perceptually uniform ones, which colour-blind readers can follow."""

COLDEST_SHARE, HOTTEST_SHARE = 0.05, 0.95
"""Part of the scale that is used: its ends are too dark and too light on the page."""

SMALLEST_SPAN_K = 0.5
"""Least range of the legend: noise of a thermometer shall not look like heat."""


def magnification(course: Course) -> float:
    """Return how many times a course's drift is drawn larger so that it can be seen: 1, 2 or 5 times a power of ten.

    Examples
    --------
    >>> import hexathermal as ht
    >>> from hexathermal.show.viewer_course import still_course
    >>> hexapod = ht.load_hexapod("rubin-m2")
    >>> magnification(still_course(hexapod, hexapod.home, np.zeros(3)))
    1.0
    """
    shift, turn = float(course.shift.max()), float(course.turn.max())
    size = float(course.hexapod.home_lengths.mean())
    most = min(DRAWN_SHARE * size / max(shift, 1e-12), LARGEST_TURN_RAD / max(turn, 1e-12))
    if most >= 1e9 or most < 1.0:
        return 1.0
    power = 10.0 ** np.floor(np.log10(most))
    return float(power * max(step for step in (1.0, 2.0, 5.0) if step * power <= most * (1.0 + 1e-9)))


def temperature_range(course: Course) -> tuple[float, float] | None:
    """Return the legend's range [degC], to tenths outwards; None where no temperature is known."""
    known = course.legs_degC[np.isfinite(course.legs_degC)]
    if not known.size:
        return None
    low, high = float(known.min()), float(known.max())
    missing = max(0.0, SMALLEST_SPAN_K - (high - low)) / 2.0
    return float(np.floor((low - missing) * 10.0) / 10.0), float(np.ceil((high + missing) * 10.0) / 10.0)


def viewer_page(course: Course, *, folder: Path | None = None, magnify: float | None = None) -> str:
    """Return the page of a course: one HTML document that works offline.

    Parameters
    ----------
    course : Course
    folder : Path, optional
        The machine's own, for its meshes.
    magnify : float, optional
        How many times the drift is drawn larger at first; default `magnification`.

    Raises
    ------
    ArgumentError
        The magnification is no number from 1 to 1e7; meshes as `machine_parts`.
    """
    drawn = magnification(course) if magnify is None else float(magnify)
    if not 1.0 <= drawn <= 1e7:
        raise ArgumentError(f"magnify must be a number from 1 to 1e7, found {drawn:g}")
    parts = machine_parts(course.hexapod, folder)
    program, licences = _meshcat_program()
    data = json.dumps(_frames(course, parts, drawn), allow_nan=False, separators=(",", ":"))
    scene = json.dumps([base64.b64encode(one).decode() for one in _scene(course, parts)])
    return page(course, program=program, licences=licences, data=data, scene=scene)


def _meshcat_program() -> tuple[str, str]:
    """Return meshcat's program for browsers, and the licences of what is in it."""
    import meshcat

    folder = Path(meshcat.__file__).parent / "viewer" / "dist"
    program = (folder / "main.min.js").read_text(encoding="utf-8")
    return program, (folder / "main.min.js.LICENSE.txt").read_text(encoding="utf-8")


def _scene(course: Course, parts: tuple[Part, ...]) -> list[bytes]:
    """Return meshcat's messages that make the objects; the page moves and colours them."""
    from meshcat import geometry as g
    from meshcat.commands import SetObject
    from meshcat.geometry import umsgpack
    from meshcat.path import Path as TreePath

    root = TreePath(("meshcat", "machine"))

    def message(name: str, thing: Any, material: Any = None) -> bytes:
        return bytes(umsgpack.packb(SetObject(thing, material, root.append(name)).lower()))

    made = []
    for part in parts:
        solid = g.TriangularMeshGeometry(part.vertices, part.faces)
        made.append(message(part.name, solid, g.MeshPhongMaterial(color=_number(part.colour), shininess=40)))
        if part.frame == "platform":
            ghost = g.MeshPhongMaterial(color=0x2F6FB0, opacity=0.28, depthWrite=False)
            made.append(message(f"ghost_{part.name}", solid, ghost))
    shell = g.MeshPhongMaterial(color=0x009E73, opacity=0.35, depthWrite=False, depthTest=False)
    made.append(message("ellipsoid", g.Sphere(1.0), shell))
    ball = g.MeshPhongMaterial(color=0xD55E00, depthTest=False, transparent=True)
    made.append(message("tool", g.Sphere(1.0), ball))
    made.append(message("wanted_tool", g.Sphere(1.0), g.MeshPhongMaterial(color=0x2F6FB0, depthTest=False,
                                                                          transparent=True)))  # fmt: skip
    for name, count in (("trail", len(course)), ("drift", 2), ("arm", 2), ("wanted_arm", 2)):
        points = g.PointsGeometry(np.zeros((3, max(2, count)), dtype=np.float32))
        hidden = name.endswith("arm")  # what stands before it
        made.append(message(name, g.Line(points, g.LineBasicMaterial(color=0xD55E00, depthTest=hidden))))
    dots = g.Points(g.PointsGeometry(np.zeros((3, max(2, len(course))), dtype=np.float32)),
                    g.PointsMaterial(size=0.02, color=0xD55E00))  # fmt: skip
    made.append(message("trail_dots", dots))
    return made


def _number(colour: tuple[float, float, float]) -> int:
    """Return a colour as meshcat's number."""
    red, green, blue = (round(255.0 * value) for value in colour)
    return red << 16 | green << 8 | blue


def _frames(course: Course, parts: tuple[Part, ...], drawn: float) -> dict[str, Any]:
    """Return the frames as plain values: metres and radians for poses, um and urad for errors."""
    from scipy.spatial.transform import Rotation

    hexapod, span = course.hexapod, temperature_range(course)
    turned = Rotation.from_matrix(course.ideal[:, :3, :3]).as_quat()
    low, high = _bounds(course, parts)
    return {
        "machine": hexapod.name,
        "labels": list(course.labels),
        "group": course.group.tolist(),
        "smooth": course.smooth,
        "known": hexapod.thermal is not None,
        "base_joints": _rounded(hexapod.base_joints, 7),
        "platform_joints": _rounded(hexapod.platform_joints, 7),
        "tool": _rounded(course.tool, 7),
        "ideal": _rounded(np.hstack([course.ideal[:, :3, 3], turned]), 8),
        "errors": _rounded(course.errors * 1e6, 4),
        "legs_degC": _rounded(course.legs_degC, 3),
        "centres": _rounded(course.centres * 1e6, 4),
        "regions": _rounded(np.swapaxes(course.regions, -1, -2).reshape(2, len(course), 9) * 1e6, 4),
        "range_degC": None if span is None else list(span),
        "palette": palette(),
        "parts": {part.name: {"frame": part.frame, "colour": list(part.colour)} for part in parts},
        "bounds": [_rounded(low, 6), _rounded(high, 6)],
        "magnify": drawn,
        "start": int(course.shift[0].argmax()),
        "words": list(course.words),
    }


def palette() -> list[list[float]]:
    """Return the colours of the legend from cold to hot, red, green, blue from 0 to 1.

    Examples
    --------
    >>> len(palette()), palette()[0][2] > palette()[-1][2]
    (32, True)
    """
    from matplotlib import colormaps

    shades = colormaps[SCALE](np.linspace(COLDEST_SHARE, HOTTEST_SHARE, STOPS))[:, :3]
    return [[round(float(value), 4) for value in shade] for shade in shades]


def _bounds(course: Course, parts: tuple[Part, ...]) -> tuple[FloatArray, FloatArray]:
    """Return the corners of the box [m] that the machine fills at home, and its tool point."""
    corners, home = [], course.hexapod.home
    for part in parts:
        if part.frame == "base":
            corners.append(part.vertices)
        elif part.frame == "platform":
            corners.append(part.vertices @ home[:3, :3].T + home[:3, 3])
    corners.append((home[:3, :3] @ course.tool + home[:3, 3])[None])
    points = np.concatenate(corners)
    return points.min(axis=0), points.max(axis=0)


def _rounded(values: FloatArray, digits: int) -> Any:
    """Return an array as nested lists with None for what is not known."""
    numbers = np.round(np.asarray(values, dtype=np.float64), digits) + 0.0
    plain = numbers.astype(object)
    plain[~np.isfinite(numbers)] = None
    return plain.tolist()


class PageServer:
    """One page, served to this computer alone until it is stopped.

    Parameters
    ----------
    html : str
    port : int
        0: any that is free.

    Attributes
    ----------
    address : str
        What to open in a browser.

    Raises
    ------
    ArgumentError
        The port is taken or not allowed.
    """

    def __init__(self, html: str, port: int = 0) -> None:
        try:
            self._server = ThreadingHTTPServer(("127.0.0.1", port), _answering(html.encode()))
        except OSError as error:
            raise ArgumentError(
                f"port {port} cannot be used: {error.strerror or error}; give another --port, or 0 for any"
            ) from None
        self._server.daemon_threads = True
        self.address = f"http://127.0.0.1:{self._server.server_address[1]}/"

    def serve(self, open_browser: bool = True) -> None:
        """Serve until `stop`, or until Ctrl-C, which is the way to end it and no error."""
        if open_browser:  # beside: some browsers come back only when they are closed
            threading.Thread(target=webbrowser.open, args=(self.address,), daemon=True).start()
        try:
            self._server.serve_forever(poll_interval=0.2)
        except KeyboardInterrupt:
            pass
        finally:
            self._server.server_close()

    def stop(self) -> None:
        """End `serve`, from another thread."""
        self._server.shutdown()


def _answering(content: bytes) -> Callable[..., BaseHTTPRequestHandler]:
    """Return what answers requests with one page."""

    class Answers(BaseHTTPRequestHandler):
        """The page for ``/``, nothing else."""

        def do_GET(self) -> None:
            """Answer."""
            there = self.path.split("?")[0] == "/"
            self.send_response(HTTPStatus.OK if there else HTTPStatus.NOT_FOUND)
            self.send_header("Content-Type", "text/html; charset=utf-8")
            self.send_header("Content-Length", str(len(content) if there else 0))
            self.end_headers()
            if there:
                self.wfile.write(content)

        def log_message(self, format: str, *args: Any) -> None:
            """Say nothing."""

    return Answers


def machine_folder(name: str) -> Path | None:
    """Return the folder of a machine that was named, for its own meshes."""
    from hexathermal.machine.library import bundled_hexapods, models_folder

    if name in bundled_hexapods():
        return models_folder() / name
    place = Path(name)
    return place if place.is_dir() else place.parent


def tool_point(tool: tuple[float, ...] | None) -> FloatArray:
    """Return the tool point [m] from millimetres; by default the platform's origin."""
    return np.array(ORIGIN if tool is None else tool) * 1e-3

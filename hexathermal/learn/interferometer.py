"""From the readings of three or more interferometer beams to the change of the leg's length, and its uncertainty.

A beam counts the change of its optical path and shows it divided by a nominal index ``n_nom``::

    D = (n L - n_0 L_0) / n_nom,      L_0 = dead_path + q_0,      L = dead_path + q (+ drift)

``L`` is the path in air between the interferometer and its reflector, ``n`` the index of air, 0 the row of the zero;
`dead_path` is that path at ``q = 0``. With ``n_nom = n_0`` (an uncompensated laser whose index was entered at the
zero)::

    L - L_0 = D - L (n - n_0) / n_0 = D - (L_0 + D) (n - n_0) / n                                              (1)

so that the whole zeroed path is dead path, ``E_dead = -L_0 (n - n_0) / n``, and the movement since adds its own part. A
front of 20 hPa on 0.8 m of path is 4.3 um. The mean of the beams is the measured change of length; of beams that stand
evenly around the axis it is free of tilt.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from hexathermal.errors import ArgumentError, DataError
from hexathermal.learn.air import RED_HELIUM_NEON, refractive_index
from hexathermal.learn.campaign import BeamLayout
from hexathermal.learn.campaign_columns import AIR
from hexathermal.poses import FloatArray, as_array, finite_array

SMALLEST_SPREAD = 1e-3
"""Least ratio of the singular values of ``[1, sin a, -cos a]`` with which two tilts are told apart."""


def index_along_run(
    air: npt.ArrayLike, *, wavelength: float = RED_HELIUM_NEON, co2: float = 450e-6, run: str = "the run"
) -> FloatArray:
    """Return the index of air of every row, or say which weather is missing.

    Parameters
    ----------
    air : array, shape (n, 3)
        Air temperature [degC], pressure [Pa] and relative humidity [1], as `Block.air`.
    wavelength : float [m]
        In vacuum.
    co2 : float [1]
    run : str
        Named in messages.

    Returns
    -------
    index : array, shape (n,)

    Raises
    ------
    DataError
        A reading is missing (NaN) or outside the range of Ciddor's equation: without it there is no correction.
    """
    weather = as_array(air, "air")
    if weather.ndim != 2 or weather.shape[1] != 3:
        raise ArgumentError(f"air has shape {weather.shape}; expected (n, 3): {', '.join(AIR)}")
    missing = ~np.isfinite(weather)
    if missing.any():
        parts = [
            f"{name} in {count} of {len(weather)} rows (the first is row {first + 1})"
            for name, count, first in zip(AIR, missing.sum(axis=0), missing.argmax(axis=0), strict=True)
            if count
        ]
        raise DataError(
            f"{run}: the beams were not compensated for the index of air, and they cannot be corrected without "
            f"{'; '.join(parts)}; record the weather, leave those rows out, or say index_compensated = true where "
            "the laser's electronics did it"
        )
    try:
        return refractive_index(wavelength, weather[:, 0], weather[:, 1], weather[:, 2], co2)
    except ArgumentError as error:
        raise DataError(f"{run}: {error}") from None


def corrected_beams(
    beams: npt.ArrayLike,
    q: npt.ArrayLike,
    index: npt.ArrayLike,
    *,
    zero_index: float,
    zero_q: float,
    dead_path: float,
    nominal_index: float | None = None,
) -> FloatArray:
    """Return beams corrected for the index of air over the whole path that was zeroed.

    ``corrected = D n_nom / n - (dead_path + zero_q) (n - n_0) / n``, which is eq. 1 of this module and exact; the
    second part follows the weather alone. Rows stand on their own, so a run may be given block by block.

    Parameters
    ----------
    beams : array, shape (..., b) [m]
        Readings less those of the zero. NaN stays NaN.
    q : array, shape (...) [m]
        Rod displacement of the same rows. Eq. 1 takes the beams' own; where `q` is NaN there is no drift, and NaN.
    index : array, shape (...)
        Index of air of the same rows, see `index_along_run`; NaN likewise.
    zero_index, zero_q : float
        Index of air and rod displacement [m] of the row where the beams were zeroed.
    dead_path : float [m]
        Path between interferometer and reflector at ``q = 0``.
    nominal_index : float, optional
        Index by which the laser divided: 1 where it shows vacuum lengths; by default `zero_index`. A wrong one scales
        the movement: 1e-6 of it is 0.25 um on 250 mm.

    Returns
    -------
    beams : array, shape (..., b) [m]

    Raises
    ------
    ArgumentError
        Shapes differ, an index is not that of air, or a path is negative.

    Examples
    --------
    A front of 20 hPa makes a resting leg of 0.8 m seem 4.3 um longer; the correction takes it back:

    >>> zero, now = refractive_index(633e-9, 20.0, [101325.0, 103325.0], 0.5)
    >>> seen = 0.8 * (now - zero) / zero
    >>> back = corrected_beams([seen] * 3, 0.0, now, zero_index=zero, zero_q=0.0, dead_path=0.8)
    >>> round(float(seen) * 1e6, 1), bool((abs(back) < 1e-15).all())
    (4.3, True)
    """
    readings, rod, n = as_array(beams, "beams"), as_array(q, "q"), as_array(index, "index")
    if readings.ndim < 1 or not readings.shape[:-1] == rod.shape == n.shape:
        found = f"beams {readings.shape}, q {rod.shape} and index {n.shape}"
        raise ArgumentError(f"{found} do not belong together; expected (..., b), (...) and (...)")
    nominal = zero_index if nominal_index is None else nominal_index
    for name, value in (("index", n), ("zero_index", zero_index), ("nominal_index", nominal)):
        _refuse_no_air(np.asarray(value), name)
    zeroed_path = _zeroed_path(float(dead_path), float(zero_q))
    known = np.where(np.isnan(rod), np.nan, n)[..., None]
    return np.asarray(readings * (nominal / known) - zeroed_path * (known - zero_index) / known)


def _zeroed_path(dead_path: float, zero_q: float) -> float:
    """Return the path in air at the zero [m]; raise `ArgumentError` where there is none."""
    zeroed = dead_path + zero_q
    if not (np.isfinite(zeroed) and dead_path >= 0.0 and zeroed >= 0.0):
        raise ArgumentError(
            f"dead_path {dead_path:g} m and zero_q {zero_q:g} m leave {zeroed:g} m of path in air at the zero; "
            "dead_path is the path between interferometer and reflector at q = 0, in metres, 0 or more"
        )
    return zeroed


def _refuse_no_air(index: FloatArray, name: str) -> None:
    """Raise `ArgumentError` where an index is not that of air or of vacuum."""
    wrong = (index < 1.0) | (index > 1.001)
    if wrong.any() or (name != "index" and not np.isfinite(index).all()):
        found = index[wrong].flat[0] if wrong.any() else float("nan")
        raise ArgumentError(f"{name} {found:g} is not an index of air, 1 to 1.001; see hexathermal.learn.air")


@dataclass(frozen=True, eq=False)
class BeamReading:
    """What several beams say together.

    Attributes
    ----------
    mean : array, shape (...) [m]
        Mean of the beams: the measured change of length, as the format of campaigns defines it.
    centre : array, shape (...) [m]
        Change on the leg's axis, tilt taken out. Equal to `mean` where the beams stand evenly around the axis.
    tilt_x, tilt_y : array, shape (...) [rad]
        Right-handed turns of the reflectors' plane about x (azimuth 0) and y (azimuth 90 degrees); z points the way in
        which readings grow.
    residual : array, shape (...) [m]
        Root mean square of what a plane leaves of the beams; 0 with three beams, which have no redundancy: one
        drifting beam cannot be told from a tilt.
    """

    mean: FloatArray
    centre: FloatArray
    tilt_x: FloatArray
    tilt_y: FloatArray
    residual: FloatArray


def read_beams(beams: npt.ArrayLike, layout: BeamLayout) -> BeamReading:
    """Return mean, centre and the two tilts of three or more beams, by least squares.

    Beam ``i`` at azimuth ``a_i`` and radius ``r`` reads ``D_i = centre + r (tilt_x sin a_i - tilt_y cos a_i)``; exact
    with three beams. The mean less the centre is ``r (tilt_x mean(sin a) - tilt_y mean(cos a))``, 0 at 120 degrees.

    Parameters
    ----------
    beams : array, shape (..., b) [m]
        Corrected readings. A row with NaN gives NaN.
    layout : BeamLayout

    Returns
    -------
    reading : BeamReading

    Raises
    ------
    ArgumentError
        Fewer than three beams, another number than the layout has, or azimuths that leave a tilt undetermined.

    Examples
    --------
    >>> third = 2.0 * np.pi / 3.0
    >>> layout = BeamLayout(radius=0.06, azimuths=(0.0, third, 2.0 * third), dead_path=0.75, index_compensated=True)
    >>> reading = read_beams([1e-6, 4e-6, 4e-6], layout)
    >>> round(float(reading.mean) * 1e6, 3), round(float(reading.tilt_y) * 1e6, 2)
    (3.0, 33.33)
    """
    readings = as_array(beams, "beams")
    count = len(layout.azimuths)
    if readings.ndim < 1 or readings.shape[-1] != count:
        raise ArgumentError(f"beams have shape {readings.shape}; expected (..., {count}), one for each azimuth")
    if not (np.isfinite(layout.radius) and layout.radius > 0.0):
        raise ArgumentError(f"the beams' radius must be above 0 m, found {layout.radius:g}")
    azimuths = finite_array(layout.azimuths, (count,), "azimuths")
    design = np.column_stack([np.ones(count), np.sin(azimuths), -np.cos(azimuths)])
    spread = np.linalg.svd(design, compute_uv=False)
    if count < 3 or spread[-1] < SMALLEST_SPREAD * spread[0]:
        shown = ", ".join(f"{value:g}" for value in np.degrees(azimuths))
        raise ArgumentError(
            f"beams at azimuths {shown} degrees do not determine a length and two tilts; at least three different "
            "azimuths are needed"
        )
    fitted = readings @ np.linalg.pinv(design).T
    residual = np.sqrt(np.mean(np.square(readings - fitted @ design.T), axis=-1))
    tilts = fitted[..., 1:] / layout.radius
    return BeamReading(readings.mean(axis=-1), fitted[..., 0], tilts[..., 0], tilts[..., 1], residual)


@dataclass(frozen=True, eq=False)
class BeamZero:
    """The row from which a run counts.

    Attributes
    ----------
    beams : array, shape (b,) [m]
    q : float [m]
    index : float or None
        Index of air; None where the laser compensated it.
    """

    beams: FloatArray
    q: float
    index: float | None = None


def length_change(
    beams: npt.ArrayLike,
    q: npt.ArrayLike,
    layout: BeamLayout,
    *,
    index: npt.ArrayLike | None = None,
    zero: BeamZero | None = None,
) -> BeamReading:
    """Return the measured change of length since the zero, corrected for the index of air where the laser did not.

    ``drift = mean - (q - zero.q)``.

    Parameters
    ----------
    beams : array, shape (n, b) [m]
    q : array, shape (n,) [m]
    layout : BeamLayout
    index : array, shape (n,), optional
        Index of air; needed where ``layout.index_compensated`` is false, not used where it is true.
    zero : BeamZero, optional
        By default the first row; give it for the later blocks of a run.

    Raises
    ------
    ArgumentError
        The index is needed and missing, there is no row, or as `corrected_beams` and `read_beams`.
    """
    readings, rod = as_array(beams, "beams"), as_array(q, "q")
    if readings.ndim != 2 or len(readings) == 0:
        raise ArgumentError(f"beams have shape {readings.shape}; expected (n, b) with at least one row")
    n = None if index is None or layout.index_compensated else as_array(index, "index")
    if n is None and not layout.index_compensated:
        raise ArgumentError(
            "index_compensated is false: the index of air along the run is needed to correct the beams, and none was "
            "given; compute it with index_along_run from the weather"
        )
    if zero is None:
        zero = BeamZero(readings[0], float(rod.flat[0]), None if n is None else float(n.flat[0]))
    moved = readings - zero.beams
    if n is not None:
        if zero.index is None:
            raise ArgumentError("index_compensated is false: the zero needs the index of air at its row")
        moved = corrected_beams(moved, rod, n, zero_index=zero.index, zero_q=zero.q, dead_path=layout.dead_path)
    return read_beams(moved, layout)

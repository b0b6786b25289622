"""From beams to a change of length: the index of air on the whole path, tilts, and missing weather."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from hexathermal.errors import ArgumentError
from hexathermal.learn.air import RED_HELIUM_NEON, refractive_index
from hexathermal.learn.campaign import BeamLayout
from hexathermal.learn.interferometer import BeamZero, corrected_beams, index_along_run, length_change, read_beams
from hexathermal.poses import FloatArray

AZIMUTHS = (0.0, 2.0 * np.pi / 3.0, 4.0 * np.pi / 3.0)
LAYOUT = BeamLayout(radius=0.06, azimuths=AZIMUTHS, dead_path=0.75, index_compensated=False)
PICOMETRE = 1e-12
FINE = settings(deadline=None, max_examples=50)


def _run(seed: int, rows: int = 200) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return rod displacement, drift [m] and weather (n, 3) of a run through a pressure front of 30 hPa."""
    generator = np.random.default_rng(seed)
    q = np.round(np.repeat(generator.uniform(0.0, 0.25, rows // 10), 10), 3)
    drift = np.cumsum(generator.normal(0.0, 1e-7, rows))
    s = np.linspace(0.0, 1.0, rows)
    air = np.column_stack([20.0 + 2.0 * np.sin(4.0 * s), 101325.0 - 3000.0 * s, 0.5 + 0.2 * np.cos(7.0 * s)])
    return q, drift - drift[0], air


def _counted(q: FloatArray, drift: FloatArray, air: FloatArray, nominal: float | None = None) -> FloatArray:
    """Return what a laser shows: fringes of half a vacuum wavelength, each taken for half a nominal one in air."""
    n = refractive_index(RED_HELIUM_NEON, air[:, 0], air[:, 1], air[:, 2])
    fringes = 2.0 * n * (LAYOUT.dead_path + q + drift) / RED_HELIUM_NEON
    shown = (fringes - fringes[0]) * RED_HELIUM_NEON / (2.0 * (n[0] if nominal is None else nominal))
    return np.repeat(shown[:, None], 3, axis=1)


@pytest.mark.parametrize("seed", range(5))
@pytest.mark.parametrize("nominal", [None, 1.0, 1.00027])
def test_a_simulated_count_gives_the_true_length(seed: int, nominal: float | None) -> None:
    """Counted fringes through changing air give back the change of length within a picometre, dead path included."""
    q, drift, air = _run(seed)
    n = index_along_run(air)
    found = corrected_beams(_counted(q, drift, air, nominal), q, n, zero_index=n[0], zero_q=q[0],
                            dead_path=LAYOUT.dead_path, nominal_index=nominal)  # fmt: skip
    true = q + drift - q[0] - drift[0]
    assert np.abs(found - true[:, None]).max() < PICOMETRE
    assert np.abs(_counted(q, drift, air)[:, 0] - true).max() > 5e-6


def test_the_dead_path_error_has_its_published_sign() -> None:
    """At rest ``E_dead = -L (n - n0) / n`` is added to the reading: rising pressure made the leg seem longer."""
    n0, n = refractive_index(633e-9, 20.0, [101325.0, 103325.0], 0.5)
    found = corrected_beams(np.zeros(3), 0.1, n, zero_index=n0, zero_q=0.1, dead_path=0.7)
    assert found == pytest.approx(-0.8 * (n - n0) / n, rel=1e-12)
    assert found[0] == pytest.approx(-4.3e-6, abs=0.05e-6)


def test_unchanged_air_changes_nothing() -> None:
    """With the index of the zero the readings come back as they were."""
    q, _, air = _run(1)
    air[:] = air[0]
    n = index_along_run(air)
    beams = np.random.default_rng(0).normal(0.0, 1e-3, (len(q), 3))
    found = corrected_beams(beams, q, n, zero_index=n[0], zero_q=q[0], dead_path=0.75)
    assert np.array_equal(found, beams)


def test_nominal_indices_differ_by_a_scale() -> None:
    """Two nominal indices differ only in a factor on the displacement: 1e-6 of index is 0.25 um on 250 mm."""
    n0 = 1.00027
    one, other = (
        corrected_beams(np.full(3, 0.25), 0.25, n0 + 5e-6, zero_index=n0, zero_q=0.0, dead_path=0.7, nominal_index=nom)
        for nom in (n0, n0 + 1e-6)
    )
    assert (other - one)[0] == pytest.approx(0.25e-6, rel=1e-3)


def test_blocks_give_what_the_whole_run_gives() -> None:
    """A run cut into blocks, the zero handed on, gives the same change of length, bit by bit."""
    q, drift, air = _run(2)
    beams, n = _counted(q, drift, air), index_along_run(air)
    whole = length_change(beams, q, LAYOUT, index=n)
    zero = BeamZero(beams[0], float(q[0]), float(n[0]))
    for at in (slice(0, 70), slice(70, 71), slice(71, 200)):
        part = length_change(beams[at], q[at], LAYOUT, index=n[at], zero=zero)
        assert np.array_equal(part.mean, whole.mean[at])
    assert np.abs(whole.mean - (q - q[0]) - drift).max() < PICOMETRE


def test_a_compensated_laser_is_not_corrected_again() -> None:
    """Where the electronics applied the index, readings are only averaged, with or without an index at hand."""
    q, drift, air = _run(3)
    beams = (q + drift)[:, None] * np.ones(3)
    layout = replace(LAYOUT, index_compensated=True)
    plain, offered = length_change(beams, q, layout), length_change(beams, q, layout, index=index_along_run(air))
    assert np.abs(plain.mean - (q + drift - q[0] - drift[0])).max() < 1e-15
    assert np.array_equal(plain.mean, offered.mean)


@FINE
@given(
    st.floats(-1e-3, 1e-3), st.floats(-1e-4, 1e-4), st.floats(-1e-4, 1e-4), st.floats(0.0, 6.3),
    st.integers(3, 6), st.floats(0.01, 0.2),
)  # fmt: skip
def test_a_tilted_plane_is_found(
    centre: float, tilt_x: float, tilt_y: float, first: float, count: int, radius: float
) -> None:
    """Evenly spaced beams return the plane that they were laid on; their mean is the centre, whatever the tilt."""
    azimuths = first + 2.0 * np.pi * np.arange(count) / count
    layout = BeamLayout(radius, tuple(azimuths), 0.75, True)
    beams = centre + radius * (tilt_x * np.sin(azimuths) - tilt_y * np.cos(azimuths))
    found = read_beams(beams, layout)
    assert found.mean == pytest.approx(centre, abs=1e-15)
    assert found.centre == pytest.approx(centre, abs=1e-15)
    assert (found.tilt_x, found.tilt_y) == pytest.approx((tilt_x, tilt_y), abs=1e-12)
    assert found.residual < 1e-15


def test_uneven_beams_leak_tilt_into_the_mean() -> None:
    """At 0, 90 and 180 degrees the mean of the beams moves with tilt_x by r/3; the centre does not."""
    layout = replace(LAYOUT, azimuths=(0.0, np.pi / 2.0, np.pi))
    tilt_x = 30e-6
    found = read_beams(0.06 * tilt_x * np.sin(layout.azimuths), layout)
    assert found.mean == pytest.approx(0.06 * tilt_x / 3.0)
    assert found.centre == pytest.approx(0.0, abs=1e-18)
    assert found.tilt_x == pytest.approx(tilt_x)


def test_turning_a_plane_about_x_lifts_positive_y() -> None:
    """The sign of the tilts is that of a right-handed turn: ``z = tilt_x y - tilt_y x`` at the reflectors."""
    turn_x, turn_y = 2e-5, -3e-5
    places = 0.06 * np.column_stack([np.cos(AZIMUTHS), np.sin(AZIMUTHS), np.zeros(3)])
    found = read_beams(np.cross([turn_x, turn_y, 0.0], places)[:, 2], LAYOUT)
    assert (found.tilt_x, found.tilt_y) == pytest.approx((turn_x, turn_y))


def test_a_fourth_beam_shows_a_fault() -> None:
    """Three beams are met exactly even where one drifts; four leave a residual."""
    four = replace(LAYOUT, azimuths=(0.0, np.pi / 2.0, np.pi, 1.5 * np.pi))
    assert read_beams([1e-6, 0.0, 0.0], LAYOUT).residual < 1e-18
    assert read_beams([1e-6, 0.0, 0.0, 0.0], four).residual == pytest.approx(0.25e-6)


def test_a_missing_beam_spoils_its_row_only() -> None:
    """NaN in a beam, in the displacement or in the index gives NaN in that row and nowhere else."""
    q, drift, air = _run(4)
    beams, n = _counted(q, drift, air), index_along_run(air)
    beams[3, 1], q[5], n[7] = np.nan, np.nan, np.nan
    found = length_change(beams, q, LAYOUT, index=n)
    assert np.flatnonzero(np.isnan(found.mean)).tolist() == [3, 5, 7]
    assert np.flatnonzero(np.isnan(found.centre)).tolist() == [3, 5, 7]


def test_missing_weather_is_named() -> None:
    """What is missing is said by column, count and first row, with the way out."""
    _, _, air = _run(0, 50)
    air[:, 1], air[10:12, 2] = np.nan, np.nan
    with pytest.raises(ArgumentError, match="cannot be corrected") as refused:
        index_along_run(air, run="run-03")
    said = str(refused.value)
    assert said.startswith("run-03: ")
    assert "air_pressure_hPa in 50 of 50 rows (the first is row 1)" in said
    assert "air_humidity_percent in 2 of 50 rows (the first is row 11)" in said
    assert "air_temperature_degC" not in said


def test_weather_in_a_wrong_unit_is_named() -> None:
    """Pressure in hectopascals where pascals are meant is refused with the run, the row and the range."""
    _, _, air = _run(0, 50)
    air[4:, 1] /= 100.0
    with pytest.raises(ArgumentError, match=r"run-03: pressure 10.1\d+ hPa at index \(4,\) is outside 100 to 1400 hPa"):
        index_along_run(air, run="run-03")


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"q": np.zeros(3)}, "do not belong together"),
        ({"index": np.full(4, 271.0)}, "not an index of air"),
        ({"zero_index": float("nan")}, "not an index of air"),
        ({"nominal_index": 0.0}, "not an index of air"),
        ({"dead_path": -0.75}, "of path in air"),
        ({"dead_path": float("nan")}, "of path in air"),
        ({"zero_q": -0.8}, "leave -0.05 m"),
        ({"zero_q": float("inf")}, "of path in air"),
    ],
)
def test_wrong_arguments_are_refused(change: dict[str, object], message: str) -> None:
    """Shapes, indices and paths that cannot be are refused."""
    right: dict[str, object] = {"beams": np.zeros((4, 3)), "q": np.zeros(4), "index": np.full(4, 1.00027),
                                "zero_index": 1.00027, "zero_q": 0.0, "dead_path": 0.75}  # fmt: skip
    with pytest.raises(ArgumentError, match=message):
        corrected_beams(**{**right, **change})  # type: ignore[arg-type]


def test_layouts_that_determine_no_tilt_are_refused() -> None:
    """Two beams, three at one azimuth, no radius, another number of beams, and a run without rows are refused."""
    for azimuths in ((0.0, np.pi), (0.5, 0.5, 0.5), (0.0, np.pi, 0.0)):
        with pytest.raises(ArgumentError, match="three different azimuths"):
            read_beams(np.zeros(len(azimuths)), replace(LAYOUT, azimuths=azimuths))
    with pytest.raises(ArgumentError, match="radius"):
        read_beams(np.zeros(3), replace(LAYOUT, radius=0.0))
    with pytest.raises(ArgumentError, match="one for each azimuth"):
        read_beams(np.zeros(4), LAYOUT)
    with pytest.raises(ArgumentError, match="at least one row"):
        length_change(np.zeros((0, 3)), np.zeros(0), LAYOUT)
    with pytest.raises(ArgumentError, match="index_along_run"):
        length_change(np.zeros((2, 3)), np.zeros(2), LAYOUT)
    with pytest.raises(ArgumentError, match="zero needs the index"):
        length_change(np.zeros((2, 3)), np.zeros(2), LAYOUT, index=[1.00027] * 2, zero=BeamZero(np.zeros(3), 0.0))
    with pytest.raises(ArgumentError, match=r"expected \(n, 3\)"):
        index_along_run(np.zeros((4, 2)))

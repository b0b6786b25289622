"""Arbitrary arguments: an answer or one of the package's own errors, never anything else."""

from __future__ import annotations

from functools import partial

import numpy as np
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import array_shapes, arrays

import hexathermal as ht
from hexathermal.errors import HexathermalError

REFERENCE = ht.load_hexapod("reference")
FREE = ht.Hexapod(REFERENCE.base_joints, REFERENCE.platform_joints, home=REFERENCE.home)

odd_floats = st.one_of(
    st.floats(allow_nan=True, allow_infinity=True),
    st.sampled_from([0.0, -0.0, 1e308, -1e308, 5e-324, 1e160, np.nan, np.inf, -np.inf, 0.7, 725.0, 20.0, 293.15]),
)
shapes = array_shapes(min_dims=0, max_dims=3, min_side=0, max_side=7)
odd_arrays = st.one_of(
    arrays(np.float64, shapes, elements=odd_floats),
    arrays(np.float64, st.sampled_from([(6,), (2, 6), (0, 6), (4, 4), (3, 4, 4), (0, 4, 4)]), elements=odd_floats),
    arrays(np.int64, shapes, elements=st.integers(-(2**60), 2**60)),
    arrays(np.complex128, (6,), elements=st.complex_numbers()),
    arrays(np.float32, (6,), elements=st.floats(width=32)),
    st.none(), st.booleans(), st.text(max_size=5), st.lists(st.text(max_size=2), max_size=6), st.integers(),
    st.dictionaries(st.sampled_from(REFERENCE.sensor_names), odd_floats), st.binary(max_size=4),
    st.just(object()), st.just([[1.0], [1.0, 2.0]]),
)  # fmt: skip


def answers(call: object) -> object:
    """Return the answer, or the package's own error."""
    try:
        return call()  # type: ignore[operator]
    except HexathermalError as error:
        assert str(error)
        return error


def calls(hexapod: ht.Hexapod, first: object, second: object) -> tuple[object, ...]:
    """Return every public call on a machine with two odd arguments."""
    return (
        lambda: hexapod.inverse_kinematics(first),
        lambda: hexapod.forward_kinematics(first),
        lambda: hexapod.forward_kinematics(np.full(6, 0.72), first),
        lambda: hexapod.jacobian(first),
        lambda: hexapod.corrected_leg_lengths(first, second),
        lambda: hexapod.corrected_leg_lengths(hexapod.home, second),
        lambda: hexapod.corrected_pose(hexapod.home, second),
        lambda: hexapod.predicted_pose(first, second),
        lambda: hexapod.strokes(first),
        lambda: ht.pose_from_coordinates(first),
        lambda: ht.coordinates_from_pose(first),
    )


@given(odd_arrays, odd_arrays)
def test_any_argument_gives_an_answer_or_a_clear_error(first: object, second: object) -> None:
    """Every public call survives every argument; what comes back is finite."""
    for call in (*calls(REFERENCE, first, second), *calls(FREE, first, second)):
        got = answers(call)
        assert isinstance(got, HexathermalError) or np.isfinite(got).all()


@given(odd_arrays)
def test_solve_forward_never_calls_a_wrong_pose_ok(lengths: object) -> None:
    """Whatever the lengths: a status OK comes with lengths that are met."""
    for solve in (REFERENCE.solve_forward, FREE.solve_forward):
        result = answers(partial(solve, lengths))
        if not isinstance(result, HexathermalError):
            ok = np.asarray(result.ok)
            size = np.maximum(np.asarray(lengths)[ok], 1.0).max(axis=-1)
            assert (np.asarray(result.residual)[ok] < 1e-12 * size).all()


@given(odd_arrays, odd_arrays, odd_arrays, odd_arrays)
def test_any_machine_is_made_or_refused(base: object, platform: object, q0: object, stroke: object) -> None:
    """The constructors of machine, frames and laws refuse clearly what they cannot use."""
    for call in (
        lambda: ht.Hexapod(base, platform),
        lambda: ht.Hexapod(REFERENCE.base_joints, REFERENCE.platform_joints, q0, stroke),
        lambda: ht.Hexapod(REFERENCE.base_joints, REFERENCE.platform_joints, home=base),
        lambda: ht.Hexapod(REFERENCE.base_joints, REFERENCE.platform_joints, base_cone=base),
        lambda: ht.Frames(base, platform),
        lambda: ht.LegLaw(("T1",), base, platform),
        lambda: ht.LegLaw(("T1",), [1e-6], [1e-6], base),
        lambda: ht.PlateLaw(base),
        lambda: ht.ThermalModel(ht.LegLaw(("T1",), [1e-6], [1e-6]), None, None, base, platform),
        lambda: ht.ThermalModel(base),
        lambda: ht.load_hexapod(base),
    ):
        assert answers(call) is not None

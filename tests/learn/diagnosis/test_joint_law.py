"""Coefficients of an extended law are as sure as runs that are left out bear out."""

from __future__ import annotations

import numpy as np
import pytest

from hexathermal.learn.diagnosis.extension import joint_law
from hexathermal.learn.diagnosis.stage import Stage
from hexathermal.poses import FloatArray
from tests.learn.diagnosis.campaigns import viewed


@pytest.fixture(name="stage")
def the_stage() -> Stage:
    """The law of a campaign with nothing hidden, before anything joined."""
    return Stage(viewed("finite_volume", 13, (), 1.0)[0])


def test_fits_without_each_run_are_those_of_the_rest(stage: Stage) -> None:
    """Each row is the posterior mean by the windows of all other runs, solved by itself."""
    channel, (X, sd) = stage.channel, stage._plain
    table, _ = channel.whitened(np.column_stack([channel.y, X]), stage.levels)
    for row, k in zip(stage.without_each, np.unique(channel.run), strict=True):
        y, of = table[channel.run != k, 0], table[channel.run != k, 1:]
        expected = np.linalg.solve(of.T @ of + np.diag(1.0 / sd**2), of.T @ y)
        assert row == pytest.approx(expected, rel=1e-6)


def test_runs_that_agree_leave_the_covariance_and_others_widen_it(
    stage: Stage, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Where each run moves nothing it is that of the noise; where runs disagree it is theirs, in the mean direction."""
    mean, covariance = stage.law
    p, runs = len(mean), len(stage.without_each)

    def told(apart: FloatArray) -> FloatArray:
        monkeypatch.setattr(Stage, "without_each", property(lambda _stage: mean + apart))
        found, wide = joint_law(stage)
        assert np.array_equal(found, mean)
        return wide

    assert np.array_equal(told(np.zeros((runs, p))), covariance)
    way = np.linalg.cholesky(covariance)
    signs = np.where(np.arange(runs) % 2, 1.0, -1.0)[:, None] - np.mean(np.where(np.arange(runs) % 2, 1.0, -1.0))
    apart = 3.0 * signs * way[:, 0]
    moved = (runs - 1) / runs * float(((3.0 * signs) ** 2).sum()) / p
    assert told(apart) == pytest.approx(covariance * moved, rel=1e-9)

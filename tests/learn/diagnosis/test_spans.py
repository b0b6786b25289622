"""What stays of columns beside others: fast ways to it are as good as the plain one."""

from __future__ import annotations

import numpy as np
import pytest

from hexathermal.learn.diagnosis.spans import orthonormal, products, products_beside, sizes_beside, without


@pytest.mark.parametrize("count", [1, 2, 3])
def test_products_of_what_stays_are_those_of_the_columns_that_stay(count: int, rng: np.random.Generator) -> None:
    """Also of columns of which a millionth stays, where a difference of products would be one of their rounding."""
    base = rng.standard_normal((200, 4))
    Q, _keep = orthonormal(base)
    apart = np.repeat(10.0 ** -np.arange(7.0), count)
    columns = base @ rng.standard_normal((4, 7 * count)) + apart * rng.standard_normal((200, 7 * count))
    along, left = Q.T @ columns, without(columns, Q)
    found = products_beside(columns, Q, along, count)
    for own, wanted in zip(found, products(left, count), strict=True):
        np.testing.assert_allclose(own, wanted, atol=1e-7 * np.diag(wanted).max())
    rms, stays = sizes_beside(columns, Q, along)
    np.testing.assert_allclose(rms, np.sqrt((columns**2).mean(axis=0)))
    np.testing.assert_allclose(stays, np.sqrt((left**2).mean(axis=0)), rtol=1e-7)

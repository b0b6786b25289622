"""Compiled means over windows: gathering rows, taking a zero away and summing are one pass.

The module is imported on first use: it needs the compiler.
"""

from __future__ import annotations

import numpy as np

from hexathermal.kinematics.compiled import loop


@loop
def window_means(rows, used, edges, counts, zeros, zeroed):
    """Return means over windows of some rows (n, k), shape (w, k).

    Windows begin at `edges` (w,) among the rows `used` (u,) and have `counts` (w,) rows; where `zeroed`, the row
    ``used[zeros[i]]`` is taken from row ``used[i]`` first.
    """
    k, last = rows.shape[1], len(edges) - 1
    out = np.zeros((last + 1, k))
    for w in range(last + 1):
        end = edges[w + 1] if w < last else len(used)
        for i in range(edges[w], end):
            row, zero = used[i], used[zeros[i]]
            if zeroed:
                for c in range(k):
                    out[w, c] += rows[row, c] - rows[zero, c]
            else:
                for c in range(k):
                    out[w, c] += rows[row, c]
        for c in range(k):
            out[w, c] /= counts[w]
    return out

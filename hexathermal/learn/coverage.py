"""How far an interval of 95 % reaches."""

from __future__ import annotations

TWO_SIDED = 1.96
"""Standard uncertainties to either side that hold 95 % of a normal law (GUM G.1.3)."""

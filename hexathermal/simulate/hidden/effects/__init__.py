"""Effects that can be hidden in a campaign, one module each; a module of this folder with an ``EFFECT`` is one.

Their formulas are forms of nature, not those that a diagnosis would fit: lags of several stages, gaps that engage step
by step, jumps that take minutes.
"""

from __future__ import annotations

from hexathermal.simulate.hidden.effect import Effect
from hexathermal.simulate.hidden.found_modules import chosen, modules_of

OUTSIDE = "outside: "


def found() -> dict[str, Effect]:
    """Return the effects of this folder by their name.

    Examples
    --------
    >>> names = list(found())
    >>> sum(name.startswith(OUTSIDE) for name in names), "backlash" in names
    (10, True)
    """
    effects = [module.EFFECT for module in modules_of(__name__, __file__)]
    return {effect.name: effect for effect in effects}


def named(name: str) -> Effect:
    """Return the effect of a name.

    Raises
    ------
    UnknownNameError
        There is none.
    """
    return chosen(name, found(), "effect")

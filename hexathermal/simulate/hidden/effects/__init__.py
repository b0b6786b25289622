"""Effects that can be hidden in a campaign, one module each; a module of this folder with an ``EFFECT`` is one.

Their formulas are forms of nature, not those that a diagnosis would fit: lags of several stages, gaps that engage step
by step, jumps that take minutes.
"""

from __future__ import annotations

from importlib import import_module
from pathlib import Path
from pkgutil import iter_modules

from hexathermal.errors import UnknownNameError
from hexathermal.simulate.hidden.effect import Effect

OUTSIDE = "outside: "


def found() -> dict[str, Effect]:
    """Return the effects of this folder by their name.

    Examples
    --------
    >>> names = list(found())
    >>> sum(name.startswith(OUTSIDE) for name in names), "backlash" in names
    (8, True)
    """
    names = sorted(item.name for item in iter_modules([str(Path(__file__).parent)]))
    effects = [import_module(f"{__name__}.{name}").EFFECT for name in names]
    return {effect.name: effect for effect in effects}


def named(name: str) -> Effect:
    """Return the effect of a name.

    Raises
    ------
    UnknownNameError
        There is none.
    """
    effects = found()
    if name not in effects:
        raise UnknownNameError(f"no effect is called {name!r}; there are {', '.join(effects)}", tuple(effects))
    return effects[name]

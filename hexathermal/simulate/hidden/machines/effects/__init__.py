"""Effects that can be hidden in a campaign of a hexapod, one module each; a module of this folder with an ``EFFECT``.

Those of the catalogue for machines bear its names. Some are of the catalogue for a leg and sit on one leg of six. What
no catalogue has begins with ``"outside: "``.
"""

from __future__ import annotations

from hexathermal.simulate.hidden.found_modules import chosen, modules_of
from hexathermal.simulate.hidden.machines.effect import MachineEffect

OUTSIDE = "outside: "

CATALOGUE = (
    "leg-coefficient", "platform-expansion", "base-expansion", "swapped-legs", "payload-compliance", "joint-offset",
    "tracker-drift", "leg-backlash",
)  # fmt: skip
"""The causes of a machine; the others of this folder sit on a leg or are outside."""


def found() -> dict[str, MachineEffect]:
    """Return the effects of this folder by their name.

    Examples
    --------
    >>> names = list(found())
    >>> set(CATALOGUE) <= set(names), sum(name.startswith(OUTSIDE) for name in names)
    (True, 5)
    """
    return {module.EFFECT.name: module.EFFECT for module in modules_of(__name__, __file__)}


def named(name: str) -> MachineEffect:
    """Return the effect of a name.

    Raises
    ------
    UnknownNameError
        There is none.
    """
    return chosen(name, found(), "effect on a machine")

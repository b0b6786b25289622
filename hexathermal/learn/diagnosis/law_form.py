"""Whether the law of a part that is diagnosed reads where it stands, `hexathermal.learn.stroke_choice` beside effects.

Errors on runs left out tell the form of a law plainly where the law is all that is there. An effect that is hidden in
the data makes them larger under either form; evidence beside what goes with the displacement tells both apart.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from hexathermal.learn.diagnosis.stage import Stage
from hexathermal.learn.diagnosis.view import View
from hexathermal.learn.diagnosis.wandering import powers_of_place
from hexathermal.learn.stroke_choice import LEAST_STROKE

ALONG = 15.0
"""Log evidence by which ``C dT + D q dT`` must be likelier than ``C dT``.

Of 60 simulated parts whose drift knows no place, effects hidden in most of them, the largest had 6; of 40 of which it
does the smallest had 47.
"""


def grows_along(view: View) -> bool:
    """Return whether the drift of a part that is no leg goes as ``C dT + D q dT``, by its evidence over ``C dT``.

    Beside either stand powers of the displacement, `hexathermal.learn.diagnosis.wandering.POWERS` of them: an error of
    the scale, or a bump, is there at any temperature, and would else pass for D where temperatures rise.

    Parameters
    ----------
    view : View
        Of a component; its `placed` does not matter.
    """
    if view.kind == "leg" or np.ptp(view.q) <= LEAST_STROKE:
        return False
    powers, said = powers_of_place(view), []
    for placed in (False, True):
        own = replace(view, placed=placed)
        base = Stage(own).base.extended(powers, own.channel.loose(powers))
        said.append(own.channel.fitted(base.X, base.sd)[1])
    return said[1] > said[0] + ALONG

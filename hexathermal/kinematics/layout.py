"""Where a machine's numbers stand in the arrays that the compiled loops read, the loops' tolerances and codes."""

from __future__ import annotations

# --- machine constants, one array of LENGTH numbers (m, unit vectors, cosines)
PLATFORM = 0
BASE = 18
Q0 = 36
SHORTEST = 42
LONGEST = 48
BASE_AXES = 54
BASE_COSINES = 72
PLATFORM_AXES = 78
PLATFORM_COSINES = 96
SIZE = 102
LARGEST_LENGTH = 103
HAS_CONES = 104
FIRST_SENSOR = 105
SENSORS = 113
LAST_SENSOR = 114
MACHINE_LENGTH = 122

# --- forward constants: joints with the legs in elimination order, home, and the inverse of Newton's matrix at home.
# The solver's origins are the centroids of the joints (F_CENTRE in the platform frame, F_ORIGIN in the base frame), so
# that a far pivot or a far base frame costs no accuracy.
F_PLATFORM = 0
F_BASE = 18
F_T = 36
F_Q = 39
F_INVERSE = 43
F_DETERMINANT = 79
F_INVERSE_SIZE = 80
F_ORDER = 81
F_CENTRE = 87
F_BASE_AXES = 90
F_BASE_COSINES = 108
F_PLATFORM_AXES = 114
F_PLATFORM_COSINES = 132
F_ORIGIN = 138
F_SHIFT = 141
"""Squared distance from home [m^2] within which, and `F_COSINE` of half a turn, no singular pose is near."""
F_COSINE = 142
FORWARD_LENGTH = 143

# --- rows of the thermal law, one column a sensor, as temperatures are recorded: leg 1 .. leg 6, platform, base; the
# machine's constants from FIRST_SENSOR and LAST_SENSOR on tell which columns are whose, up to but not with the last
LAW_A = 0
"""Coefficient of the retracted length; the expansion for a plate's sensor."""
LAW_B = 1
LAW_REFERENCE = 2
LAW_LOWEST = 3
LAW_HIGHEST = 4
LAW_ROWS = 5
PLATFORM_PART, BASE_PART = 6, 7

BLOCK = 64
"""Poses that are worked on together, by coordinate."""

ROTATION_TOLERANCE = 1e-9
"""Largest ``|R^T R - I|`` of an accepted rotation: less than 1 nm at a joint 1 m from the origin."""

STEP_TOLERANCE = 3e-8
"""Newton stops after a step below this (rad, or fractions of the machine's size): the error left is its square."""

CONTRACTION = 0.03
"""Largest Newton step (same unit) after the two chord steps for which the branch is taken as certain."""

DETERMINANT_RATIO = 0.25
"""Smallest determinant, as a part of home's, for which the branch is taken as certain."""

OK, OUT_OF_STROKE, OUT_OF_CONE, SINGULAR, NOT_CONVERGED, OTHER_BRANCH = 0, 1, 2, 3, 4, 5
"""Outcomes of forward kinematics: the values of `ForwardStatus`."""

UNSURE = 6
"""The fast loop asks for the careful solver."""

NEAR_SINGULAR, SINGULAR_START = 10, 11
"""The careful solver found a pose, or was given a start, whose determinant asks for its condition number."""

BAD_POSE, BAD_TEMPERATURE, BAD_SHAPE = 7, 8, 9
"""Outcomes of the loops that start from a pose."""

"""Write the tables of docs/diagnosis.md from the code: ``python tools/write_diagnosis_tables.py``."""

from __future__ import annotations

import sys
from importlib import import_module
from pathlib import Path

from hexathermal.learn.diagnosis.causes import catalogue

PAGE = Path(__file__).resolve().parents[1] / "docs" / "diagnosis.md"

CONSTANTS = {
    "pieces": ("EDGES_S", "LONGEST_S", "MOST_WINDOWS"),
    "view": ("LONGER_S",),
    "smoothing": ("SMOOTHED_S",),
    "channels": ("SLOW_TIMES",),
    "whitening_loops": ("LOWEST", "SPREAD", "OFFSET_SPREAD"),
    "sensor_model": (
        "FEWEST_OTHERS",
        "FEWEST_DOUBTING",
        "MOST_PROFILES",
        "MOST_LOOSE",
        "BIAS_K",
        "AIR_SHARE",
        "WIDER",
        "SLOW_PARITY_S",
    ),
    "parity_windows": ("PARITY_WINDOW_S",),
    "common_error": (
        "WARMING_S",
        "RESTING_S",
        "SLOWER_S",
        "MOST_SHARED_K",
        "LARGEST_PART",
        "LEAST_DIRECTION",
        "MOST_DIRECTIONS",
    ),
    "along_leg": ("NEAREST", "NEIGHBOURS", "LEAST_PART"),
    "search": ("LEADERS", "TIMED", "LEAST_SURE", "SURE", "MOST_WITNESSED"),
    "witnesses": (
        "IN_DRIFT",
        "BYSTANDERS",
        "USUAL",
        "UNUSUAL",
        "WHOLE",
        "PARTLY",
        "FEWEST_BYSTANDERS",
        "MOST_PARITY",
        "FOLLOWED",
        "LEAST_WITNESS",
        "AGREED",
        "LEAST_AGREED",
    ),
    "trials": ("STEEPEST", "USUAL_BIAS_K", "DRAWN_OUT", "QUICKLY"),
    "feigning": ("FEIGNED", "FEIGNED_NOISE", "MOST_FEIGNED", "ERRING"),
    "recorded": ("NOISY",),
    "base_choice": ("FEWEST_WINDOWS", "MOST_TURNS", "CLOSER"),
    "places": ("OFF", "OFF_M", "MOST_ON", "SHARES", "LEAST_STEP_M"),
    "next_experiments": ("DECIDED", "SUPPOSED"),
    "evidence": ("LEAST", "RHO", "TOLERATED", "START"),
    "rivals": (
        "SHAPE_ERROR",
        "LITTLE",
        "LEAST_PART",
        "MOST_PART",
        "UNLIKELY",
        "MOST_INDEX",
        "SHIFTED",
        "IMITATED",
        "SURELY",
        "NEARLY",
        "ORDERED",
        "DRIFTED",
        "LINE",
        "MEASURED",
        "STEPS",
    ),
    "doubtful": ("SCATTERED", "APART_K"),
    "causes.sensor_detached": ("SHARES",),
    "unlike_runs": ("FAR", "FARTHER"),
    "borne_out": ("STEP_ALONE", "FADED"),
    "stand_offs": ("FADES_S",),
    "order": ("PROFILES", "FEWEST", "HEAVY", "MOST", "UNSURE", "FEIGNED"),
    "timing": ("TIMES_S", "STEP_S", "GRID_STEPS", "PROFILES", "SHARE", "TOLERANCE_S", "MOST"),
    "chance": ("DRAWS", "FALSE_ALARMS", "LEAST_THRESHOLD"),
    "replugged": ("OFF", "ALIKE", "SURE", "RIDGE"),
    "deciding": (
        "NAMED_PRIOR",
        "NAME_LEAD",
        "NAME_SHARE",
        "NAME_AHEAD",
        "AHEAD_SHARE",
        "AHEAD_OF_WEAR",
        "LEAST_NAMED",
        "SOUND",
        "IMITATED",
        "ALIKE",
        "CLEAR",
        "SECONDED",
        "DENIED",
        "EQUIVALENT",
    ),
    "forms": ("ALIKE",),
    "course": (
        "LATER_PART",
        "APART",
        "MOST_EFFECTS",
        "LATER",
        "TWO_LEAD",
        "UNSEEN",
        "FEWEST_WINDOWS",
        "FEWEST_RUNS",
    ),
    "foresight": (
        "LEAST_SHARE",
        "MOST_LOSS",
        "FAINT",
        "FORESEEN",
        "CLEARLY_FORESEEN",
        "REPEATS",
        "BY_CHANCE",
        "FEWEST_ALIKE",
        "LEAST_SCATTER",
    ),
    "exchange": ("RIVAL", "AHEAD"),
    "pruning": ("LEAST_HARM",),
    "stage": ("CONTACT", "DISBELIEVED", "FIRST_ROW", "LARGEST", "TAKEN_BACK", "OWN_READING", "MOST_OWN", "LARGE_SHARE"),
    "wandering": ("LIKELIER", "POWERS"),
    "limits": ("CLOSE", "SOUND_CAMPAIGNS", "WEAKEST", "STRONGEST"),
}
"""Numbers of the method that a reader may want to know, by their module."""


def _told(value: object) -> str:
    """Return a number, or several."""
    items = list(value) if hasattr(value, "__iter__") else [value]
    return ", ".join(f"{item:g}" for item in items)


def constants_table() -> str:
    """Return the numbers of the method."""
    lines = ["| module | numbers |", "|---|---|"]
    for name, wanted in CONSTANTS.items():
        module = import_module(f"hexathermal.learn.diagnosis.{name}")
        lines.append(f"| `{name}` | " + " · ".join(f"`{one}` {_told(getattr(module, one))}" for one in wanted) + " |")
    return "\n".join(lines) + "\n"


def catalogue_table() -> str:
    """Return the catalogue: physics, signature, parameters, what it is confused with, and the experiment."""
    head = (
        "| cause | physics | signature | parameters: what is known before | confused with | what decides | readings |"
    )
    lines = [head, "|---|---|---|---|---|---|---|"]
    for name, module in catalogue().items():
        cause = module.CAUSE
        known = "; ".join(f"`{one.name}` [{one.unit}]: {one.prior}" for one in cause.parameters)
        alike = ", ".join(cause.confused_with)
        decides = f"{cause.experiment} | {cause.readings or 'the fault itself'}"
        lines.append(f"| `{name}` | {cause.physics} | {cause.signature} | {known} | {alike} | {decides} |")
    return "\n".join(lines) + "\n"


def written(text: str) -> str:
    """Return the page with its tables as the code has them."""
    for name, table in (("catalogue", catalogue_table()), ("constants", constants_table())):
        begin, end = f"<!-- {name}: tools/write_diagnosis_tables.py -->\n", f"<!-- end of {name} -->"
        before, rest = text.split(begin, 1)
        text = f"{before}{begin}{table}{end}{rest.split(end, 1)[1]}"
    return text


if __name__ == "__main__":
    PAGE.write_text(written(PAGE.read_text(encoding="utf-8")), encoding="utf-8")
    sys.stdout.write(f"{PAGE} written\n")

"""What a report reads of a diagnosis's JSON: every field that is missing, or of another kind, is told by its name."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from hexathermal.show.diagnosis_words import VERDICTS

NUMBER, TEXT, ANYTHING = "a number", "text", "anything"
NULL = " or null"
"""Behind a kind: the field may be null."""

Shape = Any
"""A kind in words, a tuple of words of which it is one, ``[shape]``: a list, or ``{name: shape}``: an object.

In an object ``"*"`` stands for every name that is there; a name that ends in ``?`` may lack, or be null.
"""

SHOWN = 40
"""Letters of a wrong value that are shown."""

_SCORES = {"rmse_before_um": NUMBER, "rmse_after_um": NUMBER}
_ENDS = {"rmse_gain?": NUMBER, "rmse_gain_95?": [NUMBER + NULL], "linf_gain?": NUMBER, "linf_gain_95?": [NUMBER + NULL]}
_MACHINE_SCORES = {
    f"{key}_rmse_{when}_{unit}": NUMBER
    for key, unit in (("translation", "um"), ("rotation", "urad"))
    for when in ("before", "after")
} | {
    f"{key}_{name}": shape
    for key in ("translation", "rotation")
    for name, shape in (("reduction?", NUMBER), ("reduction_95?", [NUMBER + NULL]))
}
_AXES = {f"{axis}_{'urad' if axis.startswith('r') else 'um'}": NUMBER for axis in ("x", "y", "z", "rx", "ry", "rz")}
_PARAMETER = {"value": NUMBER + NULL, "std": NUMBER + NULL, "unit": TEXT}
_EFFECT = {"cause": TEXT, "target": TEXT + NULL, "probability": NUMBER, "equivalent": [TEXT], "sentence": TEXT,
           "parameters": {"*": _PARAMETER}}  # fmt: skip
_CANDIDATE = {"cause": TEXT, "target": TEXT + NULL, "evidence": NUMBER, "probability": NUMBER,
              "settings": {"*": ANYTHING}}  # fmt: skip

_ALL: dict[str, Shape] = {
    "title": TEXT, "verdict": tuple(VERDICTS), "cause": TEXT + NULL, "target": TEXT + NULL, "probability": NUMBER,
    "sentence": TEXT, "effects": [_EFFECT], "candidates": [_CANDIDATE], "follows": TEXT + NULL, "threshold": NUMBER,
    "notes": [TEXT],
}  # fmt: skip

LEG: dict[str, Shape] = _ALL | {
    "unlike?": [TEXT],
    "given?": {"sentence": TEXT},
    "gain?": _SCORES | _ENDS | {"runs?": {"*": _SCORES | _ENDS}},
    "sensors": [TEXT],
    "detection_limits_um": {"*": NUMBER},
    "experiments": [{"words": TEXT, "causes": [TEXT], "separation": NUMBER}],
    "confusions?": [{"causes": [TEXT], "separation": NUMBER}],
    "noise_um": {"white": NUMBER, "landing": NUMBER, "readings?": NUMBER, "slow": NUMBER, "offset": NUMBER},
}
"""Fields of the diagnosis of a leg or a component."""

MACHINE: dict[str, Shape] = _ALL | {
    "gain?": _MACHINE_SCORES | {"runs?": {"*": _MACHINE_SCORES}, "without_frame_of_each_run?": _MACHINE_SCORES},
    "detection_limits": [{"cause": TEXT, "target": TEXT + NULL, "strength": NUMBER + NULL,
                          "translation_um": NUMBER + NULL, "rotation_urad": NUMBER + NULL}],
    "advice?": [{"words": TEXT, "causes": [TEXT], "places?": [TEXT]}],
    "next_experiment?": {"words": TEXT},
    "alike?": [TEXT],
    "disturbances": {"noise": _AXES, "campaign_frame": _AXES, "frame_of_each_run": _AXES, "slow_frame": _AXES},
}  # fmt: skip
"""Fields of the diagnosis of a whole machine."""


def wrong_fields(told: dict[str, Any]) -> tuple[str, ...]:
    """Return what is wrong with the fields of a diagnosis's JSON that a report reads, one sentence each.

    Examples
    --------
    >>> wrong_fields({"kind": "hexapod", "title": 3})[:2]
    ("'title' is 3, expected text", "'verdict' is missing")
    """
    return tuple(_wrong(told, MACHINE if told.get("kind") == "hexapod" else LEG, ""))


def _wrong(value: Any, shape: Shape, path: str) -> Iterator[str]:
    """Give what is wrong with one value and all in it."""
    if isinstance(shape, dict):
        if not isinstance(value, dict):
            yield _unlike(value, "an object", path)
            return
        for name, inner in shape.items():
            key = name.removesuffix("?")
            if name == "*":
                for own, item in value.items():
                    yield from _wrong(item, inner, _within(path, own))
            elif key in value and not (name.endswith("?") and value[key] is None):
                yield from _wrong(value[key], inner, _within(path, key))
            elif not name.endswith("?"):
                yield f"'{_within(path, key)}' is missing"
    elif isinstance(shape, list):
        if not isinstance(value, list):
            yield _unlike(value, "a list", path)
            return
        for k, item in enumerate(value):
            yield from _wrong(item, shape[0], f"{path}[{k}]")
    elif not _is(value, shape):
        yield _unlike(value, " or ".join(map(repr, shape)) if isinstance(shape, tuple) else shape, path)


def _within(path: str, name: str) -> str:
    """Return the path of a field in an object."""
    return f"{path}.{name}" if path else name


def _is(value: Any, kind: str | tuple[str, ...]) -> bool:
    """Whether a value is of a kind."""
    if isinstance(kind, tuple):
        return value in kind
    if value is None:
        return kind.endswith(NULL) or kind == ANYTHING
    kind = kind.removesuffix(NULL)
    if kind == NUMBER:
        return isinstance(value, int | float) and not isinstance(value, bool)
    return kind == ANYTHING or isinstance(value, str)


def _unlike(value: Any, wanted: str, path: str) -> str:
    """Return that a value is not of the kind that is wanted."""
    shown = "null" if value is None else repr(value)
    return f"'{path}' is {shown if len(shown) <= SHOWN else f'{shown[: SHOWN - 3]}...'}, expected {wanted}"

"""Which coefficients of a hexapod a set of poses and temperatures can tell apart, in numbers and in words.

With the information ``M`` of the coefficients (frames of the positioning system eliminated) and columns scaled to
length 1, ``S = M_ij / sqrt(M_ii M_jj)``: its eigenvalues are the squared singular values of the scaled columns. A small
one is a direction that the data hardly see. Two groups of coefficients that change together, ``g`` and ``h``, look
alike by ``r = g' M h / sqrt(g' M g  h' M h)``.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from hexathermal.errors import DataError
from hexathermal.learn.hexapod_fit import HexapodModel, without_frame
from hexathermal.poses import FloatArray

ALIKE = 0.9
"""Groups that look alike by more are named."""

INFLATED = 10.0
"""A coefficient whose uncertainty is more times larger than if all others were known is not told apart."""

SHOWN_SHARE = 0.1


@dataclass(frozen=True)
class Coefficient:
    """What the data tell of one coefficient [1/K].

    Attributes
    ----------
    name : str
    uncertainty : float
        Standard uncertainty that the measurement's noise leaves.
    alone : float
        The same if all other coefficients were known.
    """

    name: str
    uncertainty: float
    alone: float

    @property
    def inflation(self) -> float:
        """``uncertainty / alone``: 1 where nothing looks like it."""
        return self.uncertainty / self.alone if 0.0 < self.alone < float("inf") else float("inf")

    @property
    def moved(self) -> bool:
        """Whether anything in the data depends on it: its temperature leaves its zero."""
        return self.alone < float("inf")

    @property
    def told_apart(self) -> bool:
        """Whether the data tell it from all others."""
        return bool(self.inflation <= INFLATED)


@dataclass(frozen=True)
class Likeness:
    """Two groups of coefficients that look alike by r."""

    first: str
    second: str
    r: float

    def __str__(self) -> str:
        return f"{self.first} against {self.second}: r = {self.r:+.2f}"


@dataclass(frozen=True, eq=False)
class Observability:
    """What a set of poses and temperatures can tell apart.

    Attributes
    ----------
    coefficients : tuple of Coefficient
    singular_values : array, shape (k,)
        Of the scaled columns that are not zero, falling; all 1 where nothing looks alike.
    directions : tuple of str
        Each singular value's direction in words.
    groups : tuple of str
        Coefficients that change together: six equal legs, differences between legs, plates.
    likeness : array, shape (g, g)
        ``r`` of each two groups that are a direction; NaN for differences.
    alike : tuple of Likeness
        Those beyond `ALIKE`, largest first.
    """

    coefficients: tuple[Coefficient, ...]
    singular_values: FloatArray
    directions: tuple[str, ...]
    groups: tuple[str, ...]
    likeness: FloatArray
    alike: tuple[Likeness, ...]

    @property
    def condition(self) -> float:
        """Largest over smallest singular value."""
        least = self.singular_values[-1]
        return float(self.singular_values[0] / least) if least > 0.0 else float("inf")

    @property
    def words(self) -> tuple[str, ...]:
        """What is to be said: the weakest direction, groups that look alike, coefficients not told apart."""
        lines = [
            f"weakest direction (singular value {self.singular_values[-1]:.3g} of 1): {self.directions[-1]}",
            *(str(one) for one in self.alike),
        ]
        still = [one.name for one in self.coefficients if not one.moved]
        lost = [f"{one.name} ({one.inflation:.0f} times)" for one in self.coefficients
                if one.moved and not one.told_apart]  # fmt: skip
        if lost:
            lines.append("not told apart from the rest, uncertainty inflated: " + ", ".join(lost))
        if still:
            lines.append("nothing depends on, for the temperature never leaves its zero: " + ", ".join(still))
        return tuple(lines)


def observability(information: FloatArray, model: HexapodModel) -> Observability:
    """Return what rows can tell apart.

    Parameters
    ----------
    information : array, shape (p, p)
        ``X' V^-1 X`` of all coefficients, as `HexapodEquations.S`.
    model : HexapodModel
        Which coefficients are free; the motions of a campaign's frame are eliminated.

    Raises
    ------
    DataError
        The rows depend on no coefficient.

    Examples
    --------
    Two sensors that always read the same cannot be told apart:

    >>> from hexathermal.learn.hexapod_fit import HexapodModel
    >>> model = HexapodModel("x", np.zeros(2), np.eye(2), ("A T1", "A T2"))
    >>> found = observability(np.array([[1.0, 0.999], [0.999, 1.0]]), model)
    >>> [one.told_apart for one in found.coefficients], round(float(found.singular_values[-1]), 3)
    ([False, False], 0.032)
    """
    kept = [k for k, word in enumerate(model.words) if not word.startswith("frame ")]
    words = tuple(model.words[k] for k in kept)
    p = len(model.fixed) - (len(model.words) - len(kept))
    C = model.C[:p][:, kept]
    M = C.T @ without_frame(information, p) @ C
    size = np.sqrt(np.maximum(np.diagonal(M), 0.0))
    live = np.flatnonzero(size > 0.0)
    if not live.size:
        raise DataError("no temperature of legs and plates leaves its zero: nothing tells of any law")
    scaled = M[np.ix_(live, live)] / np.outer(size[live], size[live])
    values, vectors = np.linalg.eigh(scaled)
    order = np.argsort(-values)
    values, vectors = np.maximum(values[order], 0.0), vectors[:, order]
    uncertainty, alone = np.full(len(words), np.inf), np.full(len(words), np.inf)
    with np.errstate(divide="ignore", invalid="ignore"):
        spread = np.where(vectors == 0.0, 0.0, vectors**2 / values).sum(axis=1)
    uncertainty[live], alone[live] = np.sqrt(spread) / size[live], 1.0 / size[live]
    seen = tuple(words[k] for k in live)
    coefficients = tuple(
        Coefficient(word, float(u), float(a)) for word, u, a in zip(words, uncertainty, alone, strict=True)
    )
    groups, G = _groups(words)
    gram = G.T @ M @ G
    diagonal = np.sqrt(np.maximum(np.diagonal(gram), 0.0))
    with np.errstate(divide="ignore", invalid="ignore"):
        likeness = gram / np.outer(diagonal, diagonal)
    pairs = [
        Likeness(groups[i], groups[j], float(likeness[i, j]))
        for i in range(len(groups)) for j in range(i) if abs(likeness[i, j]) > ALIKE
    ]  # fmt: skip
    return Observability(
        coefficients, np.sqrt(values), tuple(_direction(seen, vectors[:, k]) for k in range(len(values))),
        groups, likeness, tuple(sorted(pairs, key=lambda pair: -abs(pair.r))),
    )  # fmt: skip


def _blocks(words: tuple[str, ...]) -> dict[str, list[int]]:
    """Return coefficients that are the same thing on different legs, and single ones."""
    found: dict[str, list[int]] = {}
    for k, word in enumerate(words):
        found.setdefault(word.partition(" ")[2] if word.startswith("leg") else word, []).append(k)
    return found


def _groups(words: tuple[str, ...]) -> tuple[tuple[str, ...], FloatArray]:
    """Return the names of groups that change together, and their directions, shape (k, g)."""
    names, directions = list[str](), list[FloatArray]()
    for name, places in _blocks(words).items():
        column = np.zeros(len(words))
        column[places] = 1.0
        names.append(_called(name))
        directions.append(column)
    matrix = np.column_stack(directions) if directions else np.zeros((len(words), 0))
    return tuple(names), matrix


def _called(name: str) -> str:
    """Return what a group is called."""
    if name in ("platform", "base"):
        return f"the {name}"
    return f"six equal legs ({name})"


def _direction(words: tuple[str, ...], v: FloatArray) -> str:
    """Return a direction of the scaled columns in words, each part with its share of the whole."""
    parts: list[tuple[float, str]] = []
    for name, places in _blocks(words).items():
        x = v[places]
        equal = float(x.sum() / np.sqrt(len(x)))
        parts.append((equal * abs(equal), _called(name)))
        if len(x) > 1:
            unequal = x - x.mean()
            leg = words[places[int(np.abs(unequal).argmax())]].partition(" ")[0].replace("leg", "leg ")
            parts.append((float(unequal @ unequal), f"differences between legs ({name}), {leg} most"))
    parts = sorted((part for part in parts if abs(part[0]) >= SHOWN_SHARE), key=lambda part: -abs(part[0]))
    signs = [f"{share:+.2f} {word}" for share, word in parts]
    return ", ".join(signs) or "a mixture of many coefficients"

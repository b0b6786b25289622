"""A picture's SVG text in few letters: short names, steps in place of coordinates, many dots as one path."""

from __future__ import annotations

import re
from urllib.parse import quote

FEWEST_STEPS = 12
"""Paths and rows of dots of fewer points stay as they are."""

TENTHS = 10.0
"""Steps count in tenths of a point: 0.035 mm on paper."""

_LINE = re.compile(r' d="(M[-\d.]+ [-\d.]+(?:[ML][-\d.]+ [-\d.]+)+)\s*"')
_AT = r'x="[-\d.]+" y="[-\d.]+"'
_DOTS = re.compile(rf'<use href="#(\w+)" {_AT}/>(?:<use href="#\1" {_AT}/>)+')
_LONG = re.compile(r"\d+\.\d{3,}")
_PLACE = re.compile(r'x="([-\d.]+)" y="([-\d.]+)"')


def compact_svg(text: str) -> str:
    """Return an SVG text for browsers with short names, short paths, and without spaces that nobody needs.

    Examples
    --------
    >>> compact_svg('<path id="m0123456789" d="M 1 2 L 3 4 "/>   <use xlink:href="#m0123456789" x="1" y="2"/>')
    '<path id="k0" d="M1 2L3 4 "/><use href="#k0" x="1" y="2"/>'
    """
    names = {name: f"k{k}" for k, name in enumerate(dict.fromkeys(re.findall(r'id="([mp][0-9a-f]{10})"', text)))}
    text = re.sub(r"\b[mp][0-9a-f]{10}\b", lambda found: names.get(found[0], found[0]), text)
    text = text.replace("xlink:href", "href")
    text = re.sub(r'(?<= d=")[^"]*', lambda path: re.sub(r"\s*([A-Za-z])\s*", r"\1", path[0]), text)
    text = re.sub(r">\s+<", "><", re.sub(r"<!--.*?-->", "", text, flags=re.DOTALL))
    text = re.sub(r'(?<= style=")[^"]*', lambda style: re.sub(r"([:;])\s+", r"\1", style[0]), text)
    text = re.sub(r'(?<= transform=")[^"]*', lambda move: _LONG.sub(lambda one: f"{float(one[0]):.4g}", move[0]), text)
    text = _DOTS.sub(_as_one, _LINE.sub(_stepped, text))
    meant = set(re.findall(r"#([^\")]+)", text))
    return re.sub(r' id="([^"]+)"', lambda name: name[0] if name[1] in meant else "", text)


def _stepped(found: re.Match[str]) -> str:
    """Return a path of lines as its steps."""
    lines = [[(float(x), float(y)) for x, y in re.findall(r"([-\d.]+) ([-\d.]+)", line)]
             for line in found[1].split("M")[1:]]  # fmt: skip
    if sum(map(len, lines)) < FEWEST_STEPS:
        return found[0]
    return f' d="{"".join(map(steps, lines))}"'


def steps(points: list[tuple[float, float]]) -> str:
    """Return a line from its first point in steps of tenths; no rounding adds up.

    Examples
    --------
    >>> steps([(1.0, 2.0), (1.24, 2.0), (1.24, 2.0), (2.0, -0.52)])
    'M1,2l.2,0l.8-2.5'
    """
    tenths = [(round(x * TENTHS), round(y * TENTHS)) for x, y in points]
    said, before = [], tenths[0]
    for x, y in tenths[1:]:
        if (x, y) != before:
            said.append(f"l{_pair(x - before[0], y - before[1])}")
            before = (x, y)
    return f"M{_pair(*tenths[0])}{''.join(said) or 'l0 0'}"


def _pair(x: int, y: int) -> str:
    """Return two numbers of tenths, parted where they must be."""
    first, second = _tenth(x), _tenth(y)
    return first + second if second.startswith("-") else f"{first},{second}"


def _tenth(value: int) -> str:
    """Return a number of tenths in few letters.

    Examples
    --------
    >>> _tenth(-5), _tenth(10), _tenth(0), _tenth(123)
    ('-.5', '1', '0', '12.3')
    """
    return re.sub(r"^(-?)0\.", r"\1.", f"{value / TENTHS:.1f}".removesuffix(".0"))


def _as_one(found: re.Match[str]) -> str:
    """Return many equal dots as marks on one path that is not drawn."""
    points = [(float(x), float(y)) for x, y in _PLACE.findall(found[0])]
    if len(points) < FEWEST_STEPS:
        return found[0]
    mark, path = f"{found[1]}-{found.start()}", steps(points)
    return (
        f'<marker id="{mark}" overflow="visible" markerUnits="userSpaceOnUse"><use href="#{found[1]}"/></marker>'
        f'<path d="{path}" marker-start="url(#{mark})" marker-mid="url(#{mark})" marker-end="url(#{mark})" '
        'fill="none" stroke="none"/>'
    )


def svg_address(text: str) -> str:
    """Return an SVG text as an address that holds it, to stand between double quotes.

    Examples
    --------
    >>> svg_address('<svg fill="#fff"><g/></svg>')
    "data:image/svg+xml;charset=utf-8,<svg%20fill='%23fff'><g/></svg>"
    """
    plain = text if "'" in text else text.replace('"', "'")
    return "data:image/svg+xml;charset=utf-8," + quote(plain, safe="<>'=/:;,()!?@{}[]|*+$")

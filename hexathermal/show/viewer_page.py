"""The page of the viewer: header, drawing, controls, legend; style and program stand beside this file."""

from __future__ import annotations

import re
from importlib.resources import files

from hexathermal.show.diagnosis_page import text
from hexathermal.show.viewer_course import PROBABILITY, Course


def page(course: Course, *, program: str, licences: str, data: str, scene: str) -> str:
    """Return the whole page.

    Parameters
    ----------
    course : Course
    program, licences : str
        Of meshcat.
    data, scene : str
        Frames and meshcat's messages, JSON.
    """
    name = course.hexapod.name or "machine without a name"
    known = course.hexapod.thermal is not None
    stands = " and, with its drift magnified, where it stands" if known else ""
    place = ", ".join(f"{value * 1e3:g}" for value in course.tool)
    notes = "".join(f"<li>{text(note)}</li>" for note in course.notes)
    comment = re.sub(r"--+", "-", licences)
    return (
        '<!DOCTYPE html>\n<html lang="en"><head><meta charset="utf-8">'
        '<meta name="viewport" content="width=device-width, initial-scale=1"><meta name="color-scheme" '
        f'content="light dark"><link rel="icon" href="data:,"><title>{text(name)}: {text(course.title)}</title>'
        f"<style>{_beside('viewer.css')}</style></head><body>\n<!-- The drawing is made by meshcat and what it holds:\n"
        f"{comment}-->\n<header><h1>{text(name)}</h1><p>{text(course.title)}; tool point ({place}) mm from the "
        "platform's origin</p></header>"
        f'<main><div id="pane" role="img" aria-label="The machine, its platform drawn where it is wanted{stands}; '
        'drag to turn, wheel or pinch to zoom"></div>'
        f'<p id="no-drawing" hidden></p>{_controls(course)}{_side(notes, known)}</main>'
        f'<script id="data" type="application/json">{_inside(data)}</script>'
        f'<script id="scene" type="application/json">{_inside(scene)}</script>'
        f"<script>{_inside(program)}</script><script>{_inside(_beside('viewer.js'))}</script></body></html>\n"
    )


def _beside(name: str) -> str:
    """Return a file that stands beside this module."""
    return (files("hexathermal.show") / name).read_text(encoding="utf-8")


def _inside(script: str) -> str:
    """Return a script that cannot end the element it stands in."""
    return re.sub(r"</(script)", r"<\\/\1", script, flags=re.IGNORECASE)


def _controls(course: Course) -> str:
    """Return play, slider, and what they tell of the frame."""
    still = " hidden" if len(course) == 1 else ""
    return (
        f'<section class="time" aria-label="Time"><div class="run"{still}><button id="play" type="button">Play</button>'
        f'<input id="time" type="range" min="0" max="{len(course) - 1}" step="1" value="0" aria-label="Time"></div>'
        '<p class="now"><output id="label"></output><span id="stated"></span></p>'
        '<dl><div><dt>shift of the tool point</dt><dd id="shift"></dd></div>'
        '<div><dt>turn of the platform</dt><dd id="turn"></dd></div></dl></section>'
    )


def _side(notes: str, known: bool) -> str:
    """Return switch, magnification, legend and notes; `known`: there is a drift to show."""
    boxes = (
        ("show-ideal", "ghost", "where the platform is wanted"),
        ("show-trail", "trail", "trail of the tool point's drift"),
        ("show-ellipsoid", "shell", f"{100 * PROBABILITY:g} % region of the error budget"),
    )
    shown = "".join(
        f'<label><input id="{name}" type="checkbox" checked><span class="key {key}"></span>{text(words)}</label>'
        for name, key, words in boxes
    )
    stands = "platform where it stands, drift magnified" if known else "the machine as it is drawn"
    return (
        '<aside><fieldset><legend>Leg lengths</legend><label><input type="radio" name="way" value="0" checked>'
        '<span><b>uncorrected</b> <small id="words-0"></small></span></label><label><input type="radio" name="way" '
        'value="1"><span><b>corrected</b> <small id="words-1"></small></span></label></fieldset>'
        '<section aria-labelledby="legend-title" class="legend"><h2 id="legend-title">Temperature of the legs (°C)</h2>'
        '<div id="scale" role="img"></div><div id="ticks" aria-hidden="true"></div>'
        '<ul id="legs" aria-label="Temperature of each leg"></ul></section>'
        '<section><label class="magnify">Magnify drift <input id="magnify" type="number" min="1" max="10000000" '
        'step="any"></label><p class="factor" id="factor"></p></section>'
        f'<fieldset><legend>Shown</legend>{shown}<label class="plain"><span class="key true"></span>{stands}</label>'
        f"</fieldset><details><summary>What is shown</summary><ul>{notes}</ul></details></aside>"
    )

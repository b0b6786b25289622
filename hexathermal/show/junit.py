"""JUnit XML of an acceptance, for systems that collect test results.

Each limit at each pose is a test case.  What fails is a ``failure``; what is not decided is an ``error``, so that no
system shows it as passed.
"""

from __future__ import annotations

import re
from collections import Counter
from pathlib import Path
from xml.etree import ElementTree as ET

from hexathermal.predict.acceptance import FAIL, NOT_DECIDED, Acceptance, Result
from hexathermal.show.acceptance_tables import label, place, sentence

_NOT_XML = re.compile("[^\t\n\r\u0020-\ud7ff\ue000-\ufffd\U00010000-\U0010ffff]")


_HEAD = re.compile(rb"\A(?:\xef\xbb\xbf)?(?:\s|<\?.*?\?>|<!--.*?-->)*<testsuites?[\s/>]", re.DOTALL)
"""How a file of JUnit XML begins."""

_HEAD_BYTES = 65536


def is_junit(path: Path) -> bool:
    """Whether a file is JUnit XML, by how it begins.

    Parameters
    ----------
    path : Path
        Of a plain file.
    """
    try:
        with path.open("rb") as file:
            return _HEAD.match(file.read(_HEAD_BYTES)) is not None
    except OSError:
        return False


def junit(acceptance: Acceptance) -> bytes:
    """Return an acceptance as JUnit XML in UTF-8."""
    title = _plain(acceptance.specification.title)
    verdicts = [result.decision.verdict for result in acceptance.results]
    counts = {"tests": str(len(verdicts)), "failures": str(verdicts.count(FAIL)),
              "errors": str(verdicts.count(NOT_DECIDED)), "time": "0"}  # fmt: skip
    top = ET.Element("testsuites", {"name": "hexathermal accept", **counts})
    suite = ET.SubElement(top, "testsuite", {"name": title, **counts})
    properties = ET.SubElement(suite, "properties")
    stated = {
        "verdict": acceptance.verdict,
        "measured": str(acceptance.measured.path),
        "specification": acceptance.specification.path,
    }
    for name, value in stated.items():
        ET.SubElement(properties, "property", {"name": name, "value": _plain(value)})
    names: Counter[str] = Counter()
    for result in acceptance.results:
        name = f"{label(result)} {place(result)}"
        names[name] += 1
        _case(suite, title, name if names[name] == 1 else f"{name} ({names[name]})", result)
    if acceptance.notes:
        ET.SubElement(suite, "system-out").text = _plain("\n".join(acceptance.notes))
    ET.indent(top)
    return bytes(ET.tostring(top, encoding="utf-8", xml_declaration=True)) + b"\n"


def _case(suite: ET.Element, title: str, name: str, result: Result) -> None:
    """Add one limit at one pose."""
    # dots in a class name make folders in many systems
    group = "acceptance." + title.replace(".", "_")
    case = ET.SubElement(suite, "testcase", {"classname": group, "name": _plain(name), "time": "0"})
    said = _plain(sentence(result))
    verdict = result.decision.verdict
    if verdict in (FAIL, NOT_DECIDED):
        kind = "failure" if verdict == FAIL else "error"
        ET.SubElement(case, kind, {"type": verdict, "message": said}).text = said
    else:
        ET.SubElement(case, "system-out").text = said


def _plain(text: str) -> str:
    """Return a text without characters that XML cannot hold: each is written out."""
    return _NOT_XML.sub(lambda found: f"\\x{ord(found.group()):02x}", text)

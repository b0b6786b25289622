"""The command line as a program: ``python -m hexathermal``, and what the script ``hexathermal`` may start.

Loading takes a moment: an interrupt in it ends as quietly as a later one.
"""

from __future__ import annotations

import sys

from hexathermal.loading import INTERRUPTED, WORDS, release


def main() -> int:
    """Load the command line, run it and return its exit code."""
    try:
        from hexathermal.cli import main as command_line

        release()
        return command_line()
    except KeyboardInterrupt:
        sys.stderr.write(f"{WORDS}\n")
        return INTERRUPTED


if __name__ == "__main__":
    sys.exit(main())

"""``python -m hexathermal``: the command line."""

from __future__ import annotations

import sys

from hexathermal.cli import main

sys.exit(main())

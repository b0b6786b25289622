"""``hexathermal completion``: the shell completes commands, options, files and machines."""

from __future__ import annotations

import argparse
from typing import Any

from hexathermal.machine.library import bundled_hexapods
from hexathermal.show.commands import Answer, Progress
from hexathermal.show.options import EXIT_CODES, STYLE, path

SHELLS = ("bash", "zsh", "tcsh")

FOLDERS = ("DIR", "CAMPAIGN")
"""What arguments are called that are folders."""

COMPLETION = """\
Prints what teaches a shell to complete hexathermal: commands, options, choices, names of files and folders, and the
bundled machines. Made from the commands themselves; make it anew after an update.
"""

EPILOG = f"""\
once, for all shells to come:
  bash   hexathermal completion bash > ~/.local/share/bash-completion/completions/hexathermal
         (create the folder first: mkdir -p ~/.local/share/bash-completion/completions)
  zsh    hexathermal completion zsh > ~/.zfunc/_hexathermal
         (with 'fpath+=~/.zfunc; autoload -Uz compinit; compinit' in ~/.zshrc)
  tcsh   hexathermal completion tcsh > ~/.hexathermal.csh
         (with 'source ~/.hexathermal.csh' in ~/.tcshrc)

examples:
  eval "$(hexathermal completion bash)"
  hexathermal completion zsh > ~/.zfunc/_hexathermal

{EXIT_CODES}"""

MACHINES = {
    "bash": """\
_hexathermal_machines() {{
  compgen -W '{names}' -- "$1"
  compgen -f -- "$1"
}}
""",
    "zsh": """\
_hexathermal_machines() {{
  _alternative 'machines:bundled machine:({names})' 'files:machine file:_files'
}}
""",
}
"""How shells complete a machine: a bundled one, or a file."""


def add(commands: Any) -> None:
    """Declare the command."""
    one = commands.add_parser("completion", help="let the shell complete commands and files", description=COMPLETION,
                              epilog=EPILOG, **STYLE)  # fmt: skip
    one.add_argument("shell", choices=SHELLS, metavar="SHELL", help="bash, zsh or tcsh")


def run(arguments: argparse.Namespace, _progress: Progress) -> Answer:
    """Print the script."""
    script = completion_script(arguments.shell)
    return Answer((script,), {"shell": arguments.shell, "script": script})


def completion_script(shell: str) -> str:
    """Return what teaches a shell to complete the command line.

    Parameters
    ----------
    shell : str
        ``"bash"``, ``"zsh"`` or ``"tcsh"``.

    Examples
    --------
    >>> "-F _shtab_hexathermal hexathermal" in completion_script("bash")
    True
    """
    import shtab

    import hexathermal
    from hexathermal.show.usage import parser

    top = parser(hexathermal.__version__)
    _name_files(top)
    preamble = MACHINES.get(shell, "").format(names=" ".join(bundled_hexapods()))
    script: str = shtab.complete(top, shell, preamble=preamble)
    return script.rstrip()


def _name_files(parser: argparse.ArgumentParser) -> None:
    """Say of every argument of a parser whether it is a file, a folder or a machine."""
    import shtab

    machines = dict.fromkeys(MACHINES, "_hexathermal_machines") | {"tcsh": "f"}
    for action in parser._actions:
        if isinstance(action, argparse._SubParsersAction):
            for one in action.choices.values():
                _name_files(one)
        elif action.dest == "machine":
            action.complete = machines  # type: ignore[attr-defined]
        elif action.type is path or action.dest in ("json", "temps"):
            action.complete = shtab.DIRECTORY if action.metavar in FOLDERS else shtab.FILE  # type: ignore[attr-defined]

"""``rosic completion``: a script that makes a shell complete ``rosic``."""

from __future__ import annotations

import argparse
import io
import re
from contextlib import redirect_stderr, redirect_stdout, suppress
from typing import TYPE_CHECKING

from rosic.cli.main import COMMANDS

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator, Sequence

ABOUT = """Print what makes a shell complete the commands of rosic and their options. In this shell:
eval "$(rosic completion bash)"; in every one: that line in ~/.bashrc. The same with zsh."""

_OPTION = re.compile(r"(?<![\w-])--[a-z][a-z0-9-]*")
_SCRIPT = """\
_rosic() {{
    local word="${{COMP_WORDS[COMP_CWORD]}}" before="${{COMP_WORDS[*]:1:$((COMP_CWORD-1))}}" found=
    case "$before" in
{cases}
    esac
    # Options where a dash begins one; otherwise what the shell knows itself: names of files.
    case "$found" in --*) case "$word" in -*) ;; *) found= ;; esac ;; esac
    COMPREPLY=($(compgen -W "$found" -- "$word"))
}}
complete -o bashdefault -o default -F _rosic rosic
"""
_ZSH = "autoload -U +X compinit && compinit\nautoload -U +X bashcompinit && bashcompinit\n"
_SHELLS = {"bash": "", "zsh": _ZSH}


def run(arguments: Sequence[str]) -> int:
    """Print the script."""
    parser = argparse.ArgumentParser(prog="rosic completion", description=ABOUT)
    parser.add_argument("shell", choices=tuple(_SHELLS))
    options = parser.parse_args(arguments)
    script = _SCRIPT.format(cases="\n".join(_cases()))
    print(f"{_SHELLS[options.shell]}{script}", end="")
    return 0


def _cases() -> Iterator[str]:
    """Yield what may follow each beginning of a line."""
    firsts = dict.fromkeys(name.partition(" ")[0] for name in COMMANDS)
    yield _case('""', firsts)
    for first in firsts:
        seconds = [name.partition(" ")[2] for name in COMMANDS if name.startswith(f"{first} ")]
        if seconds:
            yield _case(f'"{first}"', seconds)
    yield _case('"completion"', _SHELLS)
    for name in COMMANDS:
        yield _case(f'"{name}"|"{name} "*', _options(name))


def _case(pattern: str, words: Iterable[str]) -> str:
    return f'        {pattern}) found="{" ".join(words)}" ;;'


def _options(name: str) -> list[str]:
    """Return the options of a command, as its own help has them."""
    said = io.StringIO()
    with redirect_stdout(said), redirect_stderr(said), suppress(SystemExit):
        COMMANDS[name].run(["--help"])
    return sorted({*_OPTION.findall(said.getvalue()), "--help"})

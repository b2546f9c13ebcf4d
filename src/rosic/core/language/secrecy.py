"""What is kept of a message: nothing that is read as a secret in it."""

from __future__ import annotations

from typing import TYPE_CHECKING

from rosic.core.language.ast import Do
from rosic.core.language.keywords import POLITE
from rosic.core.language.line_words import past_fillers, words_of
from rosic.core.language.sanitise import clean, normalised

if TYPE_CHECKING:
    from rosic.core.language.ast import Line
    from rosic.core.language.command import CommandTable


def kept_of(line: Line, text: str, commands: CommandTable) -> str:
    """Return what is kept of a message of which a line was refused: no code that stands in it."""
    return line.text if isinstance(line, Do) else without_codes(text, commands)


def without_codes(text: str, commands: CommandTable, instead: str = "") -> str:
    """Return a message without what stands behind a word that takes a code, in each of its lines.

    The word is looked for where `understand` does: behind words that mean nothing, whatever letters
    it is written with, and with signs that cannot be seen. A code on the next line that has words
    is taken out, too.

    Args:
        text: As it was written.
        commands: Knows behind which words a code stands.
        instead: What is put there.
    """
    read = normalised(clean(text)).casefold()
    if not any(word in read for word in commands.secret):
        return text
    kept: list[str] = []
    awaited = False
    lines = text.splitlines()
    for line in lines:
        seen = clean(line).strip()
        if not seen:
            kept.append(line)
            continue
        low = words_of(seen).low
        at = past_fillers(low, 0)
        while at < len(low) and low[at] in POLITE:
            at = past_fillers(low, at + 1)
        word = low[at] if at < len(low) else ""
        opens = commands.secret.get(word)
        behind = low[at + 1 :]
        secret = awaited or (opens is not None and behind != [] and behind[0] != opens)
        awaited = opens is not None and not behind
        head = " ".join(seen.split()[: at + 1]).partition("=")[0] if opens is not None else ""
        kept.append(f"{head} {instead}".strip() if secret else line)
    return text if kept == lines else "\n".join(kept)

"""What Telegram would make a link of by itself, marked so that it makes none.

Telegram looks for links, mentions and addresses in every text, whoever wrote it
(https://core.telegram.org/bots/api#messageentity). Robots and people are quoted in what ROSIC says,
so these stand as ``code``, within which Telegram finds nothing. Commands stay: ROSIC offers them.
"""

from __future__ import annotations

import re
from typing import Final

from telegram import MessageEntity

from rosic.messengers.telegram.text import units

_FOUND: Final = re.compile(
    r"""
    (?: https? | tg | ton ) : // [^\s<>]{1,2000}       # anything with a scheme
    | (?<! [\w@.+-] ) [\w.+-]{1,64} @ (?: [\w-]{1,63} \. ){1,8} [^\W\d_]{2,24}   # an address
    | (?<! [\w@] ) @ [A-Za-z] \w{1,64}                 # somebody's account
    | (?<! [\w@.-] ) (?: [\w-]{1,63} \. ){1,8} [^\W\d_]{2,24} (?! \w )          # a host, and
      (?: [/?:\#] [^\s<>]{0,2000} )?                    # what may follow it
    """,
    re.VERBOSE | re.IGNORECASE,
)
_INVITATION: Final = re.compile(r"https://t\.me/\w{5,32}\?start=[\w-]{1,64}", re.ASCII)
"""What ROSIC says to be tapped; it opens a bot of Telegram and nothing else."""


def inert(text: str) -> tuple[MessageEntity, ...] | None:
    """Return the marks of a text that make it lead nowhere; None where there is nothing to mark."""
    if "." not in text and "@" not in text and "://" not in text:
        return None
    return tuple(
        MessageEntity(MessageEntity.CODE, units(text[: found.start()]), units(found[0]))
        for found in _FOUND.finditer(text)
        if not _INVITATION.fullmatch(found[0].rstrip(".,;:!?)"))
    ) or None  # fmt: skip

"""Codes that let somebody in: made, read, and kept as a keyed digest only.

A code is 40 unguessable bits in eight characters, shown as ``XXXX-XXXX``. The alphabet is
Crockford's: digits and capitals without I, L, O and U; whoever types an O or an l is understood.
"""

from __future__ import annotations

import hmac
import re
from hashlib import blake2b
from typing import TYPE_CHECKING, Final

from rosic.authoriser.wordlist import WORDS
from rosic.core.language.stopping import hears_stop
from rosic.core.secret import Secret

if TYPE_CHECKING:
    from rosic.contracts.entropy import Entropy
    from rosic.core.identity import Address

ALPHABET: Final = "0123456789ABCDEFGHJKMNPQRSTVWXYZ"
CODE_BYTES: Final = 5
PEPPER_BYTES: Final = 32
DIGEST_BYTES: Final = 16
HALF: Final = 4
READ_AT_MOST: Final = 512
"""So much is read of what hands a code in."""
SEARCHED_AT_MOST: Final = 4_096
"""So much is searched for codes that do not belong there: as much as a message may hold."""

_LOOKALIKES = str.maketrans("ILO", "110")
_SYMBOL = r"[0-9A-Za-z]"
_DASH = r"[-\u2013\u2014\u2212]"  # phones turn a hyphen into a longer line
_BARE = re.compile(rf"(?<![\w-]){_SYMBOL}{{4}}{_DASH}{_SYMBOL}{{4}}(?![\w-])")
_SAID = re.compile(
    rf"(?:\A\s*/?(?:start|join)(?:@\w+)?\s+|[?&](?:start|join)=)"
    rf"({_SYMBOL}{{4}}{_DASH}?{_SYMBOL}{{4}})(?![\w-])",
    re.IGNORECASE,
)


def new_code(entropy: Entropy) -> Secret:
    """Return a code as it is shown, once: ``7K3M-Q0ZD``."""
    number = int.from_bytes(entropy.token(CODE_BYTES), "big")
    symbols = "".join(ALPHABET[number >> shift & 31] for shift in range(35, -1, -5))
    return Secret(f"{symbols[:HALF]}-{symbols[HALF:]}")


def reads_as_stop(code: Secret) -> bool:
    """Whether handing a code in would be heard as a stop: robots would stop, nobody would be in.

    One in a hundred thousand is: ``4GS5-PARA``. A stop is heard before anything else.
    """
    shown = code.reveal()
    typed = shown.replace("-", " ")
    ways = (shown, typed, join_text(code), f"/start {shown}", f"/start {typed}")
    return any(hears_stop(said) is not None for said in ways)


def normal(code: str) -> str | None:
    """Return the eight characters of a code however it was typed, or None if it cannot be one."""
    if len(code) > READ_AT_MOST:
        return None
    symbols = re.sub(rf"{_DASH}|\s", "", code).upper().translate(_LOOKALIKES)
    if len(symbols) != 2 * HALF or any(symbol not in ALPHABET for symbol in symbols):
        return None
    return symbols


def digest(pepper: bytes, symbols: str) -> bytes:
    """Return what is kept of a code.

    Keyed: without the pepper, which is sealed, a copy of the record does not tell which codes
    are good, although there are only 2**40 of them.
    """
    return hmac.digest(pepper, symbols.encode(), "sha256")[:DIGEST_BYTES]


def code_said(text: str) -> str | None:
    """Return the code that a message hands in: ``/start CODE``, ``join CODE``, a link, or alone."""
    text = text[:READ_AT_MOST]
    said = _SAID.search(text)
    if said is not None:
        return said.group(1)
    alone = text.strip()
    return alone if _BARE.fullmatch(alone) else None


def codes_in(text: str) -> tuple[str, ...]:
    """Return whatever looks like a code anywhere in a message: for groups, where none belongs."""
    text = text[:SEARCHED_AT_MOST]
    said = code_said(text)
    found = ([] if said is None else [said]) + _SAID.findall(text) + _BARE.findall(text)
    return tuple(dict.fromkeys(found))


def telegram_link(bot: str, code: Secret) -> str:
    """Return the link that opens a private chat with the bot and hands the code in.

    Args:
        bot: The bot's name, with or without the @.
        code: Within Telegram's alphabet and its 64 characters.
    """
    return f"https://t.me/{bot.lstrip('@')}?start={code.reveal()}"


def join_text(code: Secret) -> str:
    """Return what to type where no link can carry a code: on every messenger."""
    return f"join {code.reveal()}"


def shared_words(pending: str, invitation: str, address: Address) -> str:
    """Return the two words that the person and the admin both see: 16 bits of this redemption."""
    seen = ascii((pending, invitation, address.platform, address.account)).encode()
    first, second = blake2b(seen, digest_size=2).digest()
    return f"{WORDS[first]} {WORDS[second]}"

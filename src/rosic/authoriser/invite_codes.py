"""Codes that let somebody in: made, read, and kept as a keyed digest only.

A code is 40 unguessable bits in eight characters, shown as ``XXXX-XXXX``. The alphabet is
Crockford's: digits and capitals without I, L, O and U; whoever types an O or an l is understood.
"""

from __future__ import annotations

import hmac
import re
import unicodedata
from functools import lru_cache
from hashlib import blake2b
from io import BytesIO
from typing import TYPE_CHECKING, Final

import segno

from rosic.core.identity import DIGEST_BYTES, PROGRAM, ROBOT
from rosic.core.language.stop_detection import hears_stop
from rosic.core.secret import Secret

if TYPE_CHECKING:
    from collections.abc import Collection

    from rosic.contracts.clock import Entropy
    from rosic.core.identity import Address

TERMINAL: Final = "terminal"
"""A platform of which there is one account at a gateway: whoever sits there."""


# ---- words to compare ----
# Compared by eye or by ear: no two sound or look alike, none offends.

# fmt: off
WORDS: Final = (
    "acorn", "almond", "amber", "anchor", "apple", "arrow", "atlas", "autumn", "badge",
    "bamboo", "banana", "banjo", "barley", "barn", "basket", "beach", "beaver", "berry",
    "bicycle", "biscuit", "bison", "blossom", "bonus", "bottle", "boulder", "bread", "breeze",
    "brick", "brush", "bubble", "butter", "cabin", "cactus", "camel", "candle", "canvas",
    "carpet", "cashew", "cedar", "cello", "chalk", "cherry", "chess", "circus", "clock",
    "clover", "cobalt", "cobweb", "coconut", "coffee", "cookie", "copper", "cotton", "crane",
    "crayon", "cricket", "crown", "crystal", "cushion", "cycle", "daisy", "desert", "diamond",
    "dolphin", "domino", "dove", "drawer", "drizzle", "drum", "eagle", "easel", "echo",
    "emerald", "engine", "falcon", "feather", "fern", "fiddle", "finch", "flame", "flannel",
    "forest", "fossil", "fridge", "furrow", "galaxy", "gallery", "garden", "garlic", "gecko",
    "ginger", "giraffe", "glacier", "glitter", "globe", "gondola", "granite", "grape",
    "guitar", "hammer", "harp", "hazel", "hedge", "helmet", "heron", "hill", "hippo",
    "hollow", "honey", "igloo", "indigo", "insect", "iris", "island", "ivory", "jacket",
    "jaguar", "jelly", "jewel", "jigsaw", "juice", "jungle", "kayak", "kettle", "kite",
    "koala", "ladder", "lagoon", "larch", "lemon", "lentil", "lilac", "lime", "lizard",
    "lotus", "lunar", "lynx", "magnet", "magpie", "mango", "marble", "meadow", "melon",
    "meteor", "mint", "mirror", "mitten", "mosaic", "moss", "muffin", "museum", "napkin",
    "nectar", "needle", "nest", "nickel", "nugget", "nutmeg", "oasis", "ocean", "olive",
    "onion", "opal", "orange", "orbit", "orchid", "otter", "paddle", "palace", "panda",
    "papaya", "paper", "parcel", "parrot", "pear", "pebble", "pencil", "piano", "picnic",
    "pigeon", "pillow", "planet", "plum", "pocket", "pony", "potato", "puzzle", "quartz",
    "quilt", "quiver", "rabbit", "radio", "raft", "raisin", "raven", "reef", "ribbon",
    "robin", "rope", "ruby", "salad", "salmon", "sandal", "satin", "saucer", "scarf", "shell",
    "shovel", "silver", "skate", "sketch", "snow", "soap", "spider", "sponge", "spoon",
    "squid", "stable", "storm", "summer", "syrup", "teapot", "temple", "tennis", "ticket",
    "tiger", "toast", "tomato", "topaz", "train", "trout", "tulip", "tundra", "tunnel",
    "turtle", "twig", "valley", "vase", "velvet", "violin", "waffle", "wagon", "wallet",
    "walrus", "water", "whale", "wheat", "whisk", "window", "wool", "yacht", "yellow",
    "zebra", "zenith", "zigzag", "zinnia",
)
# fmt: on


# ---- codes ----
# Kept as a keyed digest only.

ALPHABET: Final = "0123456789ABCDEFGHJKMNPQRSTVWXYZ"
CODE_BYTES: Final = 5
PEPPER_BYTES: Final = 32
HALF: Final = 4
READ_AT_MOST: Final = 512
"""So much is read of what hands a code in."""
SEARCHED_AT_MOST: Final = 5_120
"""So much is searched for codes that do not belong there: as a message may hold, and its links."""

_LOOKALIKES = str.maketrans("ILO", "110")
_SYMBOL = r"[0-9A-Za-z]"
_DASH = r"[-\u2013\u2014\u2212]"  # phones turn a hyphen into a longer line
_BARE = re.compile(rf"(?<![\w-]){_SYMBOL}{{4}}{_DASH}{_SYMBOL}{{4}}(?![\w-])")
_SAID = re.compile(
    rf"(?:\A\s*/?(?:start|join|link|verbinden)(?:@\w+)?\s+|[?&](?:start|join)=)"
    rf"({_SYMBOL}{{4}}{_DASH}?{_SYMBOL}{{4}})(?![\w-])",
    re.IGNORECASE,
)
_IN_LINKS = re.compile("%2d|%20", re.IGNORECASE)
"""A dash and a blank, as a link writes them."""


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
    """Return the code that a message hands in.

    It says ``/start CODE``, ``join CODE``, ``link CODE``, a link with it, or the code alone.
    """
    text = text[:READ_AT_MOST]
    said = _SAID.search(text)
    if said is not None:
        return said.group(1)
    alone = text.strip()
    return alone if _BARE.fullmatch(alone) else None


def codes_in(text: str) -> tuple[str, ...]:
    """Return whatever can be read as a code anywhere in a text, as `normal` returns it.

    Each eight symbols that follow one another where dashes, blanks, marks and markup are left out:
    much of that is ordinary words, so whoever asks has to look up whether it is a code.
    """
    read = "".join(_signs(text[:SEARCHED_AT_MOST]))
    length = 2 * HALF
    runs = (read[at : at + length] for at in range(len(read) - length + 1))
    return tuple(dict.fromkeys(run for run in runs if " " not in run))


def without_these(text: str, codes: tuple[str, ...], instead: str) -> str:
    """Return a text without some codes of those that `codes_in` returns for it.

    Args:
        text: As it was written.
        codes: What to take out, wherever and however it is written.
        instead: What is put there.
    """
    if not codes:
        return text
    signs = _signs(text)
    read = "".join(signs)
    places = [at for at, sign in enumerate(signs) if sign]
    taken: set[int] = set()
    for code in codes:
        at = read.find(code)
        while at >= 0:
            taken.update(range(places[at], places[at + 2 * HALF - 1] + 1))
            at = read.find(code, at + 1)
    return "".join(
        (instead if at - 1 not in taken else "") if at in taken else character
        for at, character in enumerate(text)
    )


def _signs(text: str) -> list[str]:
    """Return what each character of a text is in a code."""
    return [_sign(character) for character in _IN_LINKS.sub("---", text)]


@lru_cache(maxsize=4_096)
def _sign(character: str) -> str:
    """Return a character's symbol; a blank for another letter, nothing for what is no letter."""
    plain = unicodedata.normalize("NFKC", character).upper().translate(_LOOKALIKES)
    if len(plain) == 1 and plain in ALPHABET:
        return plain
    return " " if plain.isalnum() else ""


def only_here(platforms: Collection[str]) -> bool:
    """Whether nobody could hand a code in: all there is to talk by is a terminal of ours.

    Without any messenger it is not known yet by which one a code will come.
    """
    return bool(platforms) and {TERMINAL, ROBOT, PROGRAM}.issuperset(platforms)


def join_text(code: Secret) -> str:
    """Return what to type where no link can carry a code: on every messenger."""
    return f"join {code.reveal()}"


def shared_words(pending: str, invitation: str, address: Address) -> str:
    """Return the two words that the person and the admin both see: 16 bits of this redemption."""
    seen = ascii((pending, invitation, address.platform, address.account)).encode()
    first, second = blake2b(seen, digest_size=2).digest()
    return f"{WORDS[first]} {WORDS[second]}"


# ---- QR codes ----

QUIET: Final = 4  # modules of light border that a reader expects
SCALE: Final = 8  # pixels a module
# A terminal is mostly dark, so the light modules are what is printed.
_HALVES: Final = {(0, 0): "█", (0, 1): "▀", (1, 0): "▄", (1, 1): " "}


def qr_png(text: str) -> bytes:
    """Return a PNG picture, black on white, with its border."""
    return drawn(qr_code(text))


def drawn(code: segno.QRCode) -> bytes:
    """Return the picture of a code that was made."""
    picture = BytesIO()
    code.save(picture, kind="png", scale=SCALE, border=QUIET, dark="#000", light="#fff")
    return picture.getvalue()


def qr_text(text: str) -> str:
    """Return lines for a terminal that shows light characters on dark: two modules a character."""
    rows = [tuple(row) for row in qr_code(text).matrix_iter(border=QUIET)]
    if len(rows) % 2:
        rows.append((0,) * len(rows[0]))
    return "\n".join(
        "".join(_HALVES[bool(upper), bool(lower)] for upper, lower in zip(*pair, strict=True))
        for pair in zip(rows[::2], rows[1::2], strict=True)
    )


def qr_code(text: str) -> segno.QRCode:
    """Return the code of a text: the longer half of making a picture."""
    return segno.make(text, micro=False, error="m")

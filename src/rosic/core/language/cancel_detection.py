"""Does somebody end what they have under way? Asked of every message, right after `hears_stop`.

It ends orders of one's own and latches nothing. As with a stop, what is not understood in it makes
it mean more and not less: everything of theirs.
"""

from __future__ import annotations

import re
from string import ascii_lowercase
from typing import TYPE_CHECKING

from rosic.core.language.sanitise import is_plain
from rosic.core.language.stop_detection import (
    LONGEST_LINE,
    LONGEST_SHOUT,
    hears_stop,
    lines_of,
    words_of,
)
from rosic.core.language.stop_words import ALONG, EVERYTHING, UNSAID, fold_stop, folded_words

if TYPE_CHECKING:
    from collections.abc import Container

_CANCEL = """
    cancel abort
    abbrechen abbruch abbreche abbrich brich
    annuler annule annulez annulé abandonner abandonne abandonnez interrompre interromps
    cancelar cancela cancele cancelen abortar aborta aborte
    cancélalo cancélala cancélalos anula anular anúlalo abórtalo
    annulla annullare annullate annulli interrompi interrompere interrompete
    abortem cancelem interrompa
    annuleren annuleer afbreken avbryt avbryta annuller annullér afbryd afbryde avbryte
    peruuta peruuttakaa keskeytä keskeyttäkää
    zrušit zruš zrušte zrušiť přerušit přeruš přerušte anuluj anulować przerwij przerwać
    otkaži otkazati otkažite prekini prekinite prekliči
    отмена отмени отменить отмените отменяй прервать прерви прервите
    скасувати скасуй скасуйте перерви перервіть откажи откажете прекрати прекини прекъсни
    iptal vazgeç ακύρωση ακύρωσε ακυρώστε
    mégse mégsem megszakít megszakítás anulează anulați
    إلغاء الغاء ألغ ألغي ألغوا الغي لغو لغوش منسوخ
    בטל בטלי בטלו ביטול לבטל
    रद्द বাতিল ரத்து రద్దు
    取消 取消吧 请取消 請取消 撤销 撤銷 中断 中斷 中止
    キャンセル キャンセルして キャンセルしてください 取り消し 取り消して 取消し 中止して 中断して
    취소 취소해 취소해줘 취소해요 취소하세요 중단 중단해
    hủy huỷ ยกเลิก batal batalkan ghairi kanselahin
"""

# Goes along with one of them, and is no name: ``brich ab``, ``iptal et``, ``рद्द करो``.
_WITH = """
    ab abe et edin bo bỏ करो करें करो कीजिए করো করুন செய் చేయి ठीक کرو کریں کن کنید
    my mine meine meinen mein mes mon ma mi mis order orders command commands motion motions
    movement move moves drive run job that what under way auftrag aufträge befehl fahrt ordre
"""

# What speaks of something that is kept, and not of a robot at work.
_KEPT = """
    booking bookings booked reservation reservations slot slots time times appointment appointments
    wish wishes invitation invitations planned geplant geplante geplanten geplantes
    tomorrow mon tue wed thu fri sat sun monday tuesday wednesday thursday friday saturday sunday
    buchung buchungen termin termine zeit zeiten wunsch
    réservation réservations reserva reservas prenotazione prenotazioni
"""


# By its number or its name it is one of several; alone, it is what somebody has under way.
_TASKS = "task tasks mission missions aufgabe aufgaben missionen"


def _slips(word: str) -> frozenset[str]:
    """Return what one slip of a finger makes of a word: a letter too few, too many, or swapped."""
    places = range(len(word))
    left_out = {word[:i] + word[i + 1 :] for i in places}
    swapped = {word[:i] + word[i + 1] + word[i] + word[i + 2 :] for i in places[:-1]}
    doubled = {word[:i] + word[i] + word[i:] for i in places}
    other = {word[:i] + letter + word[i + 1 :] for i in places for letter in ascii_lowercase}
    return frozenset((left_out | swapped | doubled | other) - {word})


CANCEL = folded_words(_CANCEL)
WITH = folded_words(_WITH)
KEPT = folded_words(_KEPT)
TASKS = folded_words(_TASKS)
MISSPELT = _slips("cancel") - CANCEL - {"chancel", "cancer"}


# So much of a text is looked at; a cancel further behind is read in its turn.
LOOKED_AT = 512
# The number of a booking, or a time of day.
_NUMBERED = re.compile(r"\b(?:[0-9a-f]{8,}|\d{1,2}[:.]\d\d)\b")


def is_cancel_word(word: str) -> bool:
    """Whether a word ends what somebody has under way, so that nothing else may be called so."""
    return fold_stop(word) in CANCEL


def hears_cancel(text: str, known: Container[str] = ()) -> tuple[str, ...] | None:
    """Return of whom a text ends what its author has under way, or None if it ends nothing.

    One line that does makes the whole text do so. Takes time linear in the first 512 characters and
    none for the rest.

    Args:
        text: Raw, as received; any ``str``.
        known: Names of robots, groups, skills, verbs and choices in small letters.

    Returns:
        The words said beside it, in small letters; ``()`` means everything of theirs.
    """
    head = text[:LOOKED_AT]
    if is_plain(head):
        words = words_of(head, known)
        if CANCEL.isdisjoint(words) and MISSPELT.isdisjoint(words):
            return None
    heard = [_heard(line, known) for line in lines_of(head)]
    found = [names for names in heard if names is not None]
    if not found:
        return None
    return () if () in found else tuple(dict.fromkeys([name for names in found for name in names]))


def is_urgent(text: str) -> bool:
    """Whether a text overtakes what was received before it: it stops something, or ends it."""
    return hears_stop(text) is not None or hears_cancel(text) is not None


def _heard(line: str, known: Container[str]) -> tuple[str, ...] | None:
    if len(line) > LONGEST_SHOUT or _NUMBERED.search(line):
        return None
    words = words_of(line, known)
    folded = [fold_stop(word) for word in words]
    at = [n for n, (w, f) in enumerate(zip(words, folded, strict=True)) if _ends(w, f, known)]
    unsaid = bool(at) and at[0] > 0 and folded[at[0] - 1] in UNSAID
    if not at or unsaid or not KEPT.isdisjoint(folded):
        return None
    others = tuple(w for w, f in zip(words, folded, strict=True) if not _is_aside(w, f, known))
    if not others or " ".join(others) in known or all(word in known for word in others):
        return others
    if not TASKS.isdisjoint(folded):
        return () if TASKS.issuperset(others) else None
    leads = all(_is_aside(w, f, known) for w, f in zip(words[: at[0]], folded, strict=False))
    if not leads or len(line.strip()) > LONGEST_LINE:
        return None
    return others if EVERYTHING.isdisjoint(folded) else ()


def _ends(word: str, folded: str, known: Container[str]) -> bool:
    return folded in CANCEL or (folded in MISSPELT and word not in known)


def _is_aside(word: str, folded: str, known: Container[str]) -> bool:
    if folded in CANCEL or folded in ALONG or folded in EVERYTHING:
        return True
    return (folded in WITH or folded in MISSPELT) and word not in known

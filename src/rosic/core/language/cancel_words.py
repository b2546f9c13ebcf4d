"""The words by which people end what they have under way, in every language that has a stop word.

Ending one's own orders latches nothing, so a word that may mean it does mean it; only what speaks
of bookings, tasks or missions is left to those who keep them.
"""

from __future__ import annotations

from string import ascii_lowercase

from rosic.core.language.stop_words import fold_stop

_CANCEL = """
    cancel abort
    abbrechen abbruch abbreche abbrich brich
    annuler annule annulez annulé abandonner abandonne abandonnez interrompre interromps
    cancelar cancela cancele cancelen abortar aborta aborte
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
    wish wishes invitation invitations
    tomorrow mon tue wed thu fri sat sun monday tuesday wednesday thursday friday saturday sunday
    buchung buchungen termin termine zeit zeiten wunsch
    réservation réservations reserva reservas prenotazione prenotazioni
"""


# By its number or its name it is one of several; alone, it is what somebody has under way.
_TASKS = "task tasks mission missions aufgabe aufgaben missionen"


def _folded(words: str) -> frozenset[str]:
    return frozenset(fold_stop(word) for word in words.split())


def _slips(word: str) -> frozenset[str]:
    """Return what one slip of a finger makes of a word: a letter too few, too many, or swapped."""
    places = range(len(word))
    left_out = {word[:i] + word[i + 1 :] for i in places}
    swapped = {word[:i] + word[i + 1] + word[i] + word[i + 2 :] for i in places[:-1]}
    doubled = {word[:i] + word[i] + word[i:] for i in places}
    other = {word[:i] + letter + word[i + 1 :] for i in places for letter in ascii_lowercase}
    return frozenset((left_out | swapped | doubled | other) - {word})


CANCEL = _folded(_CANCEL)
WITH = _folded(_WITH)
KEPT = _folded(_KEPT)
TASKS = _folded(_TASKS)
MISSPELT = _slips("cancel") - CANCEL - {"chancel", "cancer"}

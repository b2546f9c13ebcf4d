"""The words of a time in other languages, each to the English one that the grammar reads."""

from __future__ import annotations

from types import MappingProxyType
from typing import TYPE_CHECKING, Final

from rosic.core.i18n import joined, said

if TYPE_CHECKING:
    from collections.abc import Mapping

_GERMAN: Final = {
    "yesterday": "gestern",
    "today": "heute",
    "tomorrow": "morgen",
    "now": "jetzt sofort",
    "every": "jeden jede jedes",
    "daily": "täglich",
    "weekdays": "werktags",
    "until": "bis",
    "for": "für um uhr ab von",
    "and": "und",
    "times": "mal",
    "noon": "mittag mittags",
    "hour": "stunde std",
    "hours": "stunden",
    "minutes": "minuten",
    "day": "tag",
    "days": "tage tagen",
    "weeks": "wochen",
    "monday": "montag montags mo",
    "tuesday": "dienstag dienstags di",
    "wednesday": "mittwoch mittwochs mi",
    "thursday": "donnerstag donnerstags do",
    "friday": "freitag freitags fr",
    "saturday": "samstag samstags sonnabend sa",
    "sunday": "sonntag sonntags so",
    "january": "januar jänner",
    "february": "februar",
    "march": "märz",
    "may": "mai",
    "june": "juni",
    "july": "juli",
    "october": "oktober okt",
    "december": "dezember dez",
}

_SHOWN: Final = {
    "today": said("today"),
    "tomorrow": said("tomorrow"),
    "now": said("now"),
    "every": said("every"),
    "times": said("times"),
    "mon": said("mon"),
    "tue": said("tue"),
    "for": said("for"),
    "until": said("until"),
    "to": said("to"),
    "min": said("min"),
    "Mon": said("Mon"),
    "Tue": said("Tue"),
    "Wed": said("Wed"),
    "Thu": said("Thu"),
    "Fri": said("Fri"),
    "Sat": said("Sat"),
    "Sun": said("Sun"),
}


def shown_when(text: str) -> str:
    """Return words of a time as the reader types them."""
    return joined(" ", (_SHOWN.get(word) or word for word in text.split(" ")))


OTHERWISE: Final[Mapping[str, str]] = MappingProxyType(
    {word: english for english, words in _GERMAN.items() for word in words.split()}
)

"""The words of a time, one after another: what was said, before it is worked out when that is.

Total and linear: each word is looked at by a fixed number of rules, each of which looks at a fixed
number of words after it.
"""

from __future__ import annotations

import re
from math import isfinite
from typing import TYPE_CHECKING, TypeAlias

from rosic.core.i18n import said
from rosic.core.language.numbers import read_numeral
from rosic.core.language.sanitise import clean, fold_word, quote
from rosic.core.language.time_words import OTHERWISE
from rosic.core.local_time import MONTHS, WEEKDAYS
from rosic.core.time_units import DAY_S, HOUR_S, MINUTES_A_DAY

if TYPE_CHECKING:
    from collections.abc import Callable


# ---- single words of a time ----

LONGEST_TEXT = 200

_CLOCK = re.compile(r"(\d{1,2})(?::(\d{2}))?(am|pm|a\.m\.|p\.m\.)?\Z", re.ASCII)


class UnclearTime(Exception):
    """The words say no time. ``str()`` is the sentence, ``offers`` what would be understood."""

    def __init__(self, sentence: str, *offers: str) -> None:
        super().__init__(sentence)
        self.sentence = sentence
        self.offers = offers


def words_of(text: str) -> list[str]:
    """Split into folded lower-case words; a comma is a word of its own."""
    if len(text) > LONGEST_TEXT:
        raise UnclearTime(
            said(
                "That is longer than any time: I read at most {longest_text} characters.",
                longest_text=LONGEST_TEXT,
            )
        )
    folded = (fold_word(word).casefold() for word in clean(text).split())
    words: list[str] = []
    for word in folded:
        words.extend(_at_commas(word))
    return words


def _at_commas(word: str) -> list[str]:
    """``tue,thu`` is three words; ``1,5h`` and a rule are one."""
    if "," not in word or "=" in word or (word[0].isdigit() and word[-1] != ","):
        return [word]
    return word.replace(",", " , ").split()


def clock_of(word: str, after: str) -> tuple[int, str, int] | None:
    """Read a time of day: minutes since midnight, am or pm if said, how many words."""
    if word in {"noon", "midday"}:
        return MINUTES_A_DAY // 2, "pm", 1
    match = _CLOCK.match(word)
    if match is None:
        return None
    apart = not match[3] and after in {"am", "pm", "a.m.", "p.m."}
    half = (after if apart else match[3] or "").replace(".", "")
    hour, minute = int(match[1]), int(match[2] or 0)
    if half:
        if not 1 <= hour <= 12:  # noqa: PLR2004
            raise _no_such(f"{word} {after}" if apart else word)
        hour = hour % 12 + 12 * (half == "pm")
    if (hour, minute) == (24, 0):
        return MINUTES_A_DAY, half, 1 + apart
    if hour > 23 or minute > 59:  # noqa: PLR2004
        raise _no_such(word)
    return hour * 60 + minute, half, 1 + apart


def _no_such(word: str) -> UnclearTime:
    return UnclearTime(said("There is no {quote} on a clock.", quote=quote(word)))


Date: TypeAlias = tuple[int | None, int, int]
"""Year, if it was said, month and day; perhaps no such day."""

LONGEST_S = 1e9

FILLERS = frozenset({"a", "an", "at", "from", "the", "on", "please", "of", ",", "/book", "o'clock"})
JOINTS = frozenset({"-", "to", "till", "until", "til"})
UNITS: dict[str, int] = {
    # Longer than any time may be: read so that they are refused for what they are.
    **dict.fromkeys(("year", "years"), 365 * DAY_S),
    **dict.fromkeys(("month", "months"), 30 * DAY_S),
    **dict.fromkeys(("week", "weeks"), 7 * DAY_S),
    **dict.fromkeys(("d", "day", "days"), DAY_S),
    **dict.fromkeys(("h", "hr", "hrs", "hour", "hours"), HOUR_S),
    **dict.fromkeys(("m", "min", "mins", "minute", "minutes"), 60),
    **dict.fromkeys(("s", "sec", "secs", "second", "seconds"), 1),
}
WORKDAYS = (0, 1, 2, 3, 4)

_FULL_DAYS = ("monday", "tuesday", "wednesday", "thursday", "friday", "saturday", "sunday")
_DAYS_AWAY = {"yesterday": -1, "today": 0, "tonight": 0, "tomorrow": 1, "übermorgen": 2}
_OTHER_DAYS = {"tues": 1, "weds": 2, "thur": 3, "thurs": 3}
_DAYS: dict[str, int] = {
    **{name.lower(): number for number, name in enumerate(WEEKDAYS)},
    **{name: number for number, name in enumerate(_FULL_DAYS)},
    **{f"{name}s": number for number, name in enumerate(_FULL_DAYS)},
    **_OTHER_DAYS,
}
_FULL_MONTHS = (
    "january",
    "february",
    "march",
    "april",
    "may",
    "june",
    "july",
    "august",
    "september",
    "october",
    "november",
    "december",
)
_MONTHS: dict[str, int] = {
    **{name.lower(): number for number, name in enumerate(MONTHS, 1)},
    **{name: number for number, name in enumerate(_FULL_MONTHS, 1)},
    "sept": 9,
}

_ISO = re.compile(r"(\d{4})-(\d{1,2})-(\d{1,2})\Z", re.ASCII)
_DOTTED = re.compile(r"(\d{1,2})\.(\d{1,2})\.(\d{4}|\d{2})?\Z", re.ASCII)
_SLASHED = re.compile(r"\d{1,4}/\d{1,2}(?:/\d{1,4})?\Z", re.ASCII)
_DAY_OF_MONTH = re.compile(r"(\d{1,2})(?:\.|st|nd|rd|th)?\Z", re.ASCII)
_YEAR = re.compile(r"(?:19|20|21)\d\d\Z", re.ASCII)
_HOURS_AND_MINUTES = re.compile(r"(\d{1,3})h(\d{1,2})(?:m|min)?\Z", re.ASCII)
_ZONE = re.compile(r"(?:[a-z_]+/[a-z_/]+|utc|gmt|ce?s?t|[ecmp][sd]t|bst|jst|(?:utc|gmt)[+-].*)\Z")
_TIMES = re.compile(r"(\d{1,6})(?:x|times)?\Z", re.ASCII)


class TimeTokens:
    """What the words say, each thing at most once.

    Attributes:
        day: Days from today, from -1 to 2.
        weekdays: Monday is 0. Several only if it comes again.
        start: Minutes since midnight; ``end`` as well.
        delay_s: ``in 20 min``; 0 for ``now``.
        every: 0 once, 1 every, 2 every other.
        rrule: A rule as RFC 5545 writes it, unread.
    """

    def __init__(self, text: str) -> None:
        self.day: int | None = None
        self.weekdays: tuple[int, ...] = ()
        self.date: Date | None = None
        self.start: int | None = None
        self.end: int | None = None
        self.delay_s: float | None = None
        self.length_s: float | None = None
        self.every = 0
        self.until: Date | None = None
        self.count: int | None = None
        self.rrule = ""
        self._words = [OTHERWISE.get(word, word) for word in words_of(text)]
        self._at = 0
        self._told: set[str] = set()
        self._read()

    def _read(self) -> None:
        rules: tuple[Callable[[], bool], ...] = (
            self._filler,
            self._day_word,
            self._repeating,
            self._ending,
            self._delay,
            self._length,
            self._a_date,
            self._a_rule,
            self._time,
        )
        while self._at < len(self._words):
            if not any(rule() for rule in rules):
                raise self._unread()

    def _unread(self) -> UnclearTime:
        """Return what cannot be read: what stands after ``until``, and not that word itself."""
        word = self._word()
        if _ZONE.match(word):
            return UnclearTime(
                said(
                    "I read times on your own clock, so leave {quote} out. /settings zone says "
                    "which clock that is.",
                    quote=quote(word),
                )
            )
        following = self._word(1) if word in JOINTS else ""
        return UnclearTime(said("I cannot read {quote} as a time.", quote=quote(following or word)))

    def _word(self, ahead: int = 0) -> str:
        at = self._at + ahead
        return self._words[at] if at < len(self._words) else ""

    def _once(self, name: str, value: object) -> None:
        """Keep what was said; saying it twice says nothing."""
        if name in self._told:
            raise UnclearTime(said("That says two times at once."))
        self._told.add(name)
        setattr(self, name, value)

    # ---- one word ----

    def _filler(self) -> bool:
        if self._word() not in FILLERS and self._word() not in {"for", "am"}:
            return False  # ``am dienstag``; after an hour it was read with it
        self._at += 1
        return True

    def _day_word(self) -> bool:
        word = self._word()
        if word in _DAYS_AWAY:
            self._once("day", _DAYS_AWAY[word])
        elif word in _DAYS:
            self._once("weekdays", (_DAYS[word],))
        elif word == "now":
            self._once("delay_s", 0.0)
        else:
            return False
        self._at += 1
        return True

    # ---- it comes again ----

    def _repeating(self) -> bool:
        word = self._word()
        if word in {"daily", "weekdays"}:
            self._once("every", 1)
            self.weekdays = WORKDAYS if word == "weekdays" else tuple(range(7))
            self._at += 1
            return True
        if word not in {"every", "each"}:
            return False
        other = self._word(1) == "other"
        self._once("every", 2 if other else 1)
        self._at += 2 if other else 1
        self._repeated_days()
        return True

    def _repeated_days(self) -> None:
        """Read ``day``, ``weekday``, or one or more days of the week."""
        if self._word() in {"day", "weekday"} and self.every == 1:
            self.weekdays = WORKDAYS if self._word() == "weekday" else tuple(range(7))
            self._at += 1
            return
        days: set[int] = set()
        while self._word() in _DAYS or (days and self._word() in {"and", ",", "&"}):
            if self._word() in _DAYS:
                days.add(_DAYS[self._word()])
            self._at += 1
        if not days:
            raise UnclearTime(said("Every which day?"), "every tue 14:00 1h 10 times")
        self.weekdays = tuple(sorted(days))

    def _ending(self) -> bool:
        """Read ``until 2027-02-01``, ``until 16:00``, ``10 times``."""
        if self._word() in {"until", "till", "til"}:
            found = self._date_at(1)
            if found is not None:
                date, used = found
                self._once("until", date)
                self._at += 1 + used
                return True
            return self._end_time(1)
        match = _TIMES.match(self._word())
        apart = self._word(1) in {"times", "x"}
        if match is None or not (apart or self._word()[-1] in "xs"):
            return False
        self._once("count", int(match[1]))
        self._at += 1 + apart
        return True

    def _a_rule(self) -> bool:
        if not self._word().startswith(("rrule:", "freq=")):
            return False
        rule = self._word().upper().removeprefix("RRULE:")
        if not rule:
            raise UnclearTime(said("A rule says how often."), "every tue 14:00 1h 10 times")
        self._once("rrule", rule)
        self._at += 1
        return True

    # ---- days ----

    def _a_date(self) -> bool:
        found = self._date_at(0)
        if found is None:
            return False
        self._once("date", found[0])
        self._at += found[1]
        return True

    def _date_at(self, ahead: int) -> tuple[Date, int] | None:
        """Read a date, some words ahead; return it and how many words it has."""
        word = self._word(ahead)
        if _SLASHED.match(word):
            raise UnclearTime(said("{quote} is one day here and another there.", quote=quote(word)))
        if match := _ISO.match(word):
            return (int(match[1]), int(match[2]), int(match[3])), 1
        if match := _DOTTED.match(word):
            year = int(match[3]) if match[3] else None
            if year is not None and year < 100:  # noqa: PLR2004 - two digits
                year += 2000
            return (year, int(match[2]), int(match[1])), 1
        return self._named_month(ahead)

    def _named_month(self, ahead: int) -> tuple[Date, int] | None:
        """Read ``24 Nov``, ``Nov 24``, each perhaps with a year."""
        one, two = self._word(ahead), self._word(ahead + 1)
        month, day = (one, two) if one in _MONTHS else (two, one)
        match = _DAY_OF_MONTH.match(day)
        if month not in _MONTHS or match is None:
            return None
        year = int(self._word(ahead + 2)) if _YEAR.match(self._word(ahead + 2)) else None
        return (year, _MONTHS[month], int(match[1])), 2 if year is None else 3

    # ---- lengths ----

    def _delay(self) -> bool:
        """Read ``in 20 min``. After ``in 1 h 30 min`` nobody knows which of them is the length."""
        if self._word() != "in":
            return False
        found = self._length_at(1)
        if found is None:
            raise UnclearTime(said("In how long?"), "in 20 min 1h")
        seconds, used, terms = found
        self._once("delay_s", seconds)
        self._at += 1 + used
        if terms > 1 and self._at == len(self._words):
            start, length = "".join(self._words[1:-1]), self._words[-1]
            raise UnclearTime(
                said("In how long, and for how long?"),
                f"in {start} for {length}",
            )
        return True

    def _length(self) -> bool:
        found = self._length_at(0)
        if found is None:
            return False
        self._once("length_s", found[0])
        self._at += found[1]
        return True

    def _length_at(self, ahead: int) -> tuple[float, int, int] | None:
        """Read a length: seconds, how many words, how many terms. Its units grow smaller."""
        total, used, terms, smaller_than = 0.0, 0, 0, LONGEST_S
        while (found := self._term_at(ahead + used)) is not None and found[1] < smaller_than:
            seconds, smaller_than, words = found
            total, used, terms = total + seconds, used + words, terms + 1
        if not terms:
            return None
        if not (isfinite(total) and total < LONGEST_S):
            raise UnclearTime(
                said("{quote} is no length I can read.", quote=quote(self._word(ahead)))
            )
        return total, used, terms

    def _term_at(self, ahead: int) -> tuple[float, float, int] | None:
        """Read ``90min``, ``1.5 h`` or ``1h30``: seconds, its unit in seconds, how many words."""
        word = self._word(ahead)
        if match := _HOURS_AND_MINUTES.match(word):
            return int(match[1]) * float(HOUR_S) + int(match[2]) * 60.0, 60, 1
        if word == "half" and self._word(ahead + 1) in {"a", "an", "hour"}:
            apart = self._word(ahead + 1) != "hour"
            return (1800.0, 60, 2 + apart) if self._word(ahead + 1 + apart) == "hour" else None
        if word == "hour":
            return float(HOUR_S), HOUR_S, 1
        numeral = read_numeral(word)
        if numeral is None:
            return None
        apart = not numeral.rest
        unit = UNITS.get(self._word(ahead + 1) if apart else numeral.rest)
        if unit is None:
            return None
        if numeral.value < 0:
            raise UnclearTime(said("A time cannot be shorter than nothing."))
        return numeral.value * unit, unit, 1 + apart

    # ---- times of day ----

    def _time(self) -> bool:
        """Read ``14:00``, ``2 pm``, ``9-10``, ``9 to 10``, ``9-10pm``."""
        first, dash, second = self._word().partition("-")
        clock = clock_of(first, "" if dash else self._word(1))
        if clock is None:
            return self._end_time(1) if self._word() in JOINTS else False
        minute, half, used = clock
        self._once("start", minute)
        if dash:
            self._words[self._at] = second  # the rest of the word is a word of its own
            if not self._end_time(0, half):
                raise UnclearTime(
                    said(
                        "I cannot read {quote} as a time.",
                        quote=quote(f"{first}-{second}"),
                    )
                )
            return True
        self._at += used
        if self._word() in JOINTS and self._date_at(1) is None:
            self._end_time(1, half)
        return True

    def _end_time(self, ahead: int, half: str = "?") -> bool:
        """Read when it ends. ``9-10pm`` begins in the evening, ``11-1pm`` in the morning.

        Args:
            ahead: How many words before it.
            half: ``am`` or ``pm`` if the start said so; ``?``: no start stands right before.
        """
        clock = clock_of(self._word(ahead), self._word(ahead + 1))
        if clock is None:
            return False
        minute, ends_in, used = clock
        self._once("end", minute)
        self._at += ahead + used
        start, noon = self.start, MINUTES_A_DAY // 2
        if not half and ends_in == "pm" and start is not None and start < noon:
            self.start = start + noon if start + noon < minute else start
        late = minute + noon
        if half == "pm" and not ends_in and start is not None and start < late <= MINUTES_A_DAY:
            self.end = late
        return True


# ---- lengths of time ----

_NEXT_OPTION = frozenset({"for", "code"})
"""What begins the next length of the same line."""


def length_said(low: list[str]) -> tuple[float, int]:
    """Return the length that the first words say, and how many words: as many as go."""
    ends = next((at for at, word in enumerate(low) if word in _NEXT_OPTION), len(low))
    for used in range(ends, 0, -1):
        try:
            tokens = TimeTokens(" ".join(low[:used]))
        except UnclearTime:
            continue
        other = (
            tokens.start,
            tokens.end,
            tokens.day,
            tokens.date,
            tokens.delay_s,
            tokens.count,
            tokens.until,
        )
        if tokens.length_s is not None and not tokens.weekdays and all(o is None for o in other):
            return tokens.length_s, used
    return 0.0, 0

"""Sentences that are English by themselves and remember how to be said in another language.

A sentence *is* its English text, so whoever does not care about languages handles a ``str``. Only
the edge, which knows who will read it, asks a catalogue for it in that person's language:

    refusal = NotPermitted(said("{robot} is not for you.", robot=profile.shown))
    in_language(refusal.sentence, catalogue)       # "Omni ist nichts für dich."

The template is the key into the catalogue, as gettext has it. It stands in the call as a literal,
so that whoever collects the templates finds it.
"""

from __future__ import annotations

import re
from gettext import NullTranslations
from typing import TYPE_CHECKING, Protocol, final

if TYPE_CHECKING:
    from collections.abc import Iterable, Mapping

_COMMAS = frozenset({"de"})
_THOUSANDS = re.compile(r"(?<=\d),(?=\d{3}(?!\d))")


class Catalogue(Protocol):
    """Templates in one language. ``gettext.NullTranslations`` and its descendants are such."""

    def gettext(self, message: str, /) -> str:
        """Return the template in this language, or the same when it is not known."""

    def __hash__(self) -> int:
        """Hash it, so that what was made with it can be kept."""

    def ngettext(self, msgid1: str, msgid2: str, n: int, /) -> str:
        """Return the form of a template that goes with ``n``."""


@final
class Sentence(str):
    """English text and what it was made from.

    ``str(sentence)`` and every method of ``str`` give plain text, in English for good.

    Attributes:
        template: What the catalogue knows it by.
        many: The template for other numbers than one, when ``n`` matters.
        n: The number that chooses between the two.
        parts: What fills the template; may hold sentences.
    """

    __slots__ = ("many", "n", "parts", "template")

    template: str
    many: str
    n: int
    parts: Mapping[str, object]

    @classmethod
    def of(cls, template: str, parts: Mapping[str, object], many: str = "", n: int = 1) -> Sentence:
        """Make one; the English text is put together here and now."""
        form = many if many and n != 1 else template
        sentence = cls(form.format(**parts) if parts else form)
        sentence.template, sentence.parts = template, parts
        sentence.many, sentence.n = many, n
        return sentence


@final
class Sentences(str):
    """Several in a row, as ``separator.join`` puts them."""

    __slots__ = ("rest", "separator")

    separator: str
    rest: tuple[str, ...]


@final
class MeasuredQuantity(str):
    """A quantity, as it stands in a profile, and as somebody reads it who thinks in feet."""

    __slots__ = ("imperial",)

    imperial: str

    def read_in(self, catalogue: Catalogue) -> str:
        """Return it as whoever reads this catalogue reads it."""
        text = self.imperial if isinstance(catalogue, ImperialCatalogue) else str(self)
        if not writes_commas(catalogue):
            return text
        return _THOUSANDS.sub("\u202f", text).replace(".", ",")


def figure(text: str, imperial: str = "") -> MeasuredQuantity:
    """Return a number, with its unit perhaps, whose decimals everybody reads as they write them.

    Args:
        text: ``0.50 m``.
        imperial: How it reads to whoever thinks in feet; empty: the same.
    """
    shown = MeasuredQuantity(text)
    shown.imperial = imperial or text
    return shown


@final
class _Comma(float):
    """A number that a template shows with a comma."""

    def __format__(self, spec: str, /) -> str:
        return float.__format__(self, spec).replace(".", ",")


@final
class LocalisedName(str):
    """What somebody has named in several languages; as it stands, in those it has no name in."""

    __slots__ = ("titles",)

    titles: Mapping[str, str]

    def read_in(self, catalogue: Catalogue) -> str:
        """Return it as whoever reads this catalogue reads it."""
        return self.titles.get(language_of(catalogue), str(self))


def titled(text: str, titles: Mapping[str, str]) -> str:
    """Return a name that reads differently by language code: ``{"de": "Abheben"}``."""
    if not titles:
        return text
    named = LocalisedName(text)
    named.titles = titles
    return named


@final
class ImperialCatalogue:
    """A catalogue for whoever reads feet and pounds; its words are another's, or English."""

    def __init__(self, words: Catalogue | None) -> None:
        self._words = words

    @property
    def language(self) -> str:
        """Code of the language; empty for English."""
        return "" if self._words is None else language_of(self._words)

    def gettext(self, message: str) -> str:
        """Return the template in this language."""
        return message if self._words is None else self._words.gettext(message)

    def ngettext(self, msgid1: str, msgid2: str, n: int) -> str:
        """Return the form of a template that goes with ``n``."""
        if self._words is not None:
            return self._words.ngettext(msgid1, msgid2, n)
        return msgid1 if n == 1 else msgid2


@final
class Capitalised(str):
    """A sentence that begins with a capital letter, in whatever language."""

    __slots__ = ("text",)

    text: str


def said(template: str, /, **parts: object) -> Sentence:
    """Say something; fields as ``str.format`` has them."""
    return Sentence.of(template, parts)


def said_n(one: str, many: str, n: int, /, **parts: object) -> Sentence:
    """Say something of which there are ``n``; both templates may use ``{n}``."""
    return Sentence.of(one, {"n": n, **parts}, many, n)


def filled(form: Sentence, /, **parts: object) -> Sentence:
    """Fill the fields of a sentence that was made without them, in a table of sentences."""
    return Sentence.of(form.template, parts)


def joined(separator: str, texts: Iterable[str | int]) -> str:
    """Join sentences, each keeping its own languages; ``separator`` may be a sentence, too."""
    rest = tuple([text if isinstance(text, str) else str(text) for text in texts])
    row = Sentences(separator.join(rest))
    row.separator, row.rest = separator, rest
    return row


def capital(text: str) -> str:
    """Begin a sentence with a capital letter, in whatever language."""
    begun = Capitalised(f"{text[:1].upper()}{text[1:]}")
    begun.text = text
    return begun


def in_language(text: str, catalogue: Catalogue | None) -> str:
    """Return the text as this catalogue says it, plain. What is no sentence comes back as it is."""
    if catalogue is None:
        return str(text)
    if isinstance(text, Sentence):
        return _translated(text, catalogue)
    if isinstance(text, Sentences):
        separator = in_language(text.separator, catalogue)
        return separator.join([in_language(part, catalogue) for part in text.rest])
    if isinstance(text, (MeasuredQuantity, LocalisedName)):
        return text.read_in(catalogue)
    if isinstance(text, Capitalised):
        plain = in_language(text.text, catalogue)
        return f"{plain[:1].upper()}{plain[1:]}"
    return text


def language_of(catalogue: Catalogue) -> str:
    """Return the code of a catalogue's language; empty where it does not say."""
    if isinstance(catalogue, ImperialCatalogue):
        return catalogue.language
    return catalogue.info().get("language", "") if isinstance(catalogue, NullTranslations) else ""


def writes_commas(catalogue: Catalogue) -> bool:
    """Whether decimals have a comma before them where this catalogue is read."""
    return language_of(catalogue) in _COMMAS


def plain(text: object) -> str:
    """Return a sentence as plain English; for an encoder, which takes nothing but ``str`` itself.

    Raises:
        NotImplementedError: It is no text at all.
    """
    if isinstance(text, str):
        return str(text)
    raise NotImplementedError


def _translated(text: Sentence, catalogue: Catalogue) -> str:
    form = (
        catalogue.ngettext(text.template, text.many, text.n)
        if text.many
        else catalogue.gettext(text.template)
    )
    if not text.parts:
        return form
    return form.format(**{name: _part(part, catalogue) for name, part in text.parts.items()})


def _part(part: object, catalogue: Catalogue) -> object:
    if isinstance(part, str):
        return in_language(part, catalogue)
    return _Comma(part) if isinstance(part, float) and writes_commas(catalogue) else part

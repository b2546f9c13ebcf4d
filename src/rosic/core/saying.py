"""Sentences that are English by themselves and remember how to be said in another language.

A sentence *is* its English text, so whoever does not care about languages handles a ``str``. Only
the edge, which knows who will read it, asks a catalogue for it in that person's language:

    refusal = NotPermitted(said("{robot} is not for you.", robot=profile.shown))
    in_language(refusal.sentence, catalogue)       # "Omni ist nichts für dich."

The template is the key into the catalogue, as gettext has it. It stands in the call as a literal,
so that whoever collects the templates finds it.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Protocol, final

if TYPE_CHECKING:
    from collections.abc import Iterable, Mapping


class Catalogue(Protocol):
    """Templates in one language. ``gettext.NullTranslations`` and its descendants are such."""

    def gettext(self, message: str, /) -> str:
        """Return the template in this language, or the same when it is not known."""

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


def said(template: str, /, **parts: object) -> Sentence:
    """Say something; fields as ``str.format`` has them."""
    return Sentence.of(template, parts)


def said_n(one: str, many: str, n: int, /, **parts: object) -> Sentence:
    """Say something of which there are ``n``; both templates may use ``{n}``."""
    return Sentence.of(one, {"n": n, **parts}, many, n)


def joined(separator: str, texts: Iterable[str]) -> str:
    """Join sentences, each keeping its own languages; ``separator`` is the same in all of them."""
    rest = tuple(texts)
    row = Sentences(separator.join(rest))
    row.separator, row.rest = separator, rest
    return row


def in_language(text: str, catalogue: Catalogue | None) -> str:
    """Return the text as this catalogue says it, plain. What is no sentence comes back as it is."""
    if catalogue is None:
        return str(text)
    if isinstance(text, Sentence):
        return _translated(text, catalogue)
    if isinstance(text, Sentences):
        return text.separator.join([in_language(part, catalogue) for part in text.rest])
    return text


def _translated(text: Sentence, catalogue: Catalogue) -> str:
    form = (
        catalogue.ngettext(text.template, text.many, text.n)
        if text.many
        else catalogue.gettext(text.template)
    )
    if not text.parts:
        return form
    return form.format(
        **{
            name: in_language(part, catalogue) if isinstance(part, str) else part
            for name, part in text.parts.items()
        }
    )

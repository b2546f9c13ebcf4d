"""Names that many profiles use, as people read and type them in their own language.

A profile's own words stay what they are: in a command, in a binding and in the record. This is how
the common ones among them read, and what else may be typed for them where a profile says nothing
of it. None of these words is reserved.
"""

from __future__ import annotations

from types import MappingProxyType
from typing import TYPE_CHECKING, Final

from rosic.core.i18n import said, titled

if TYPE_CHECKING:
    from collections.abc import Mapping

_SHOWN: Final = {
    # Choices.
    "forward": said("forward"),
    "back": said("back"),
    "backward": said("backward"),
    "left": said("left"),
    "right": said("right"),
    "up": said("up"),
    "down": said("down"),
    "home": said("home"),
    "reach": said("reach"),
    "carry": said("carry"),
    "line": said("line"),
    "triangle": said("triangle"),
    "column": said("column"),
    "open": said("open"),
    "closed": said("closed"),
    "on": said("on"),
    "off": said("off"),
    "fast": said("fast"),
    "slow": said("slow"),
    # Parameters, and what a robot measures.
    "direction": said("direction"),
    "distance": said("distance"),
    "speed": said("speed"),
    "angle": said("angle"),
    "yaw": said("yaw"),
    "pose": said("pose"),
    "joint": said("joint"),
    "force": said("force"),
    "height": said("height"),
    "shape": said("shape"),
    "spacing": said("spacing"),
    "leader": said("leader"),
    "bearing": said("bearing"),
    "linear": said("linear"),
    "lateral": said("lateral"),
    "angular": said("angular"),
    "duration": said("duration"),
    "place": said("place"),
    "state": said("state"),
    "text": said("text"),
    "battery": said("battery"),
    "temperature": said("temperature"),
    "heat": said("heat"),
    "width": said("width"),
    "power": said("power"),
    "voltage": said("voltage"),
    "load": said("load"),
    # Things.
    "cube": said("cube"),
    "part": said("part"),
}

LANGUAGE: Final = "de"
TYPED: Final[Mapping[str, tuple[str, ...]]] = MappingProxyType(
    {
        # Choices.
        "forward": ("vor", "vorwärts", "geradeaus"),
        "back": ("zurück", "rückwärts"),
        "backward": ("zurück", "rückwärts"),
        "left": ("links",),
        "right": ("rechts",),
        "up": ("hoch", "aufwärts", "oben"),
        "down": ("runter", "abwärts", "unten"),
        "home": ("grundstellung", "heim"),
        "reach": ("ausgestreckt",),
        "carry": ("transport", "tragen"),
        "line": ("linie", "reihe"),
        "triangle": ("dreieck",),
        "column": ("säule", "turm"),
        "open": ("offen", "öffnen", "öffne"),
        "closed": ("geschlossen",),
        "fast": ("schnell",),
        "slow": ("langsam",),
        # Parameters.
        "direction": ("richtung",),
        "distance": ("strecke", "entfernung", "abstand"),
        "speed": ("tempo", "geschwindigkeit"),
        "angle": ("winkel",),
        "yaw": ("ausrichtung",),
        "pose": ("haltung",),
        "joint": ("gelenk",),
        "force": ("kraft",),
        "height": ("höhe",),
        "shape": ("form",),
        "spacing": ("abstand",),
        "leader": ("leitdrohne",),
        "bearing": ("seitenwinkel",),
        "linear": ("längs",),
        "lateral": ("quer",),
        "angular": ("drehung",),
        "duration": ("dauer",),
        "place": ("ort",),
        # Skills.
        "move": ("fahre", "fahr", "fahren", "bewege", "bewegen"),
        "turn": ("drehe", "dreh", "drehen"),
        "goto": ("fahre zu", "fahr zu", "fliege zu", "flieg zu"),
        "takeoff": ("abheben", "heb ab", "hebe ab"),
        "land": ("landen", "lande"),
        "grasp": ("greifen", "greife", "greif"),
        "release": ("loslassen", "lass los"),
        "follow": ("folgen", "folge", "folg"),
        "say": ("sage", "sag"),
        # What a robot measures.
        "battery": ("akku", "batterie"),
        "temperature": ("temperatur",),
        "heat": ("hitze",),
    }
)
"""A profile's word to what is typed for it in `LANGUAGE`, in small letters; the first is shown."""


def known_name(name: str) -> str:
    """Return a common name in the reader's language, and any other text as it is."""
    return _SHOWN.get(name) or name


def shown_name(name: str) -> str:
    """Return a name of a profile as people read it; a common one in their language."""
    return _SHOWN.get(name) or name.replace("_", " ")


def shown_command(name: str, spoken: str, titles: Mapping[str, str]) -> str:
    """Return a skill's name as it is typed, in the reader's language where one is known.

    Args:
        name: Its id.
        spoken: How it is typed anywhere.
        titles: Its title in other languages, which may be typed, too.
    """
    typed = TYPED.get(name)
    return titled(spoken, {**titles, LANGUAGE: typed[0]} if typed else titles)


def typed_names(name: str) -> tuple[str, ...]:
    """Return what else is typed for a name of a profile, where it leaves no doubt."""
    return TYPED.get(name, ())

"""Names on a ROS 2 graph, checked before anything is imported, opened or matched."""

from __future__ import annotations

import re
from dataclasses import dataclass
from difflib import get_close_matches
from typing import TYPE_CHECKING, Literal, TypeAlias, cast

from rosic.robots.ros2.errors import BadName

if TYPE_CHECKING:
    from collections.abc import Iterable

Kind: TypeAlias = Literal["msg", "srv", "action"]

_MAX_LENGTH = 200
_TYPE = re.compile(r"([a-z][a-z0-9]*(?:_[a-z0-9]+)*)/(msg|srv|action)/([A-Z][A-Za-z0-9]*)")
_GRAPH = re.compile(r"/?[A-Za-z_][A-Za-z0-9_]*(?:/[A-Za-z_][A-Za-z0-9_]*)*")
_NODE = re.compile(r"[A-Za-z_][A-Za-z0-9_]*")


@dataclass(frozen=True)
class TypeName:
    """The name of an interface, such as ``geometry_msgs/msg/Twist``, taken apart."""

    package: str
    kind: Kind
    name: str

    def __str__(self) -> str:
        return f"{self.package}/{self.kind}/{self.name}"


def parse_type_name(text: str, kind: Kind | None = None) -> TypeName:
    """Take a type's name apart.

    Args:
        text: As written in a profile.
        kind: What it has to be, when only one will do.

    Raises:
        BadName: It is not ``package/msg/Type``, or is of another kind.
    """
    match = _TYPE.fullmatch(text) if len(text) <= _MAX_LENGTH else None
    if match is None:
        raise BadName(
            f"{_shown(text)} is not the name of a ROS type; one looks like geometry_msgs/msg/Twist."
        )
    name = TypeName(match[1], cast("Kind", match[2]), match[3])
    if kind is not None and name.kind != kind:
        raise BadName(f"{name} is of kind {name.kind}, and one of kind {kind} is needed here.")
    return name


def check_graph_name(text: str) -> str:
    """Return the name of a topic, a service, an action or a namespace, made absolute.

    Raises:
        BadName: ROS would not take it, or it holds a substitution.
    """
    if len(text) > _MAX_LENGTH or not _GRAPH.fullmatch(text):
        raise BadName(f"{_shown(text)} is not a ROS name; one looks like /omni/cmd_vel.")
    return text if text.startswith("/") else f"/{text}"


def check_node_name(text: str) -> str:
    """Return the name of a node.

    Raises:
        BadName: It holds more than letters, digits and underscores, or starts with a digit.
    """
    if len(text) > _MAX_LENGTH or not _NODE.fullmatch(text):
        raise BadName(f"{_shown(text)} cannot be a node: letters, digits and underscores only.")
    return text


def is_under(name: str, namespace: str) -> bool:
    """Tell whether an absolute name lies in a namespace; ``/kuka10`` is not in ``/kuka1``."""
    prefix = namespace.rstrip("/")
    return name == prefix or name.startswith(f"{prefix}/")


def did_you_mean(wrong: str, known: Iterable[str], *, have: str = "it has") -> str:
    """Return the closing half of a sentence that offers the nearest name, or lists a few."""
    names = sorted(known)
    near = get_close_matches(wrong, names, n=1)
    if near:
        return f"did you mean {near[0]}?"
    if not names:
        return f"{have} none."
    return f"{have} {', '.join(names[:8])}{' and more' if len(names) > 8 else ''}."  # noqa: PLR2004 - a line's worth


def _shown(text: str) -> str:
    return repr(text if len(text) <= 80 else f"{text[:80]}...")  # noqa: PLR2004 - a line's worth

"""A client of the API: for programs that ask a gateway from elsewhere."""

from __future__ import annotations

from rosic.client.client import RosicClient
from rosic.client.errors import (
    ApiProblem,
    ClientError,
    GatewayFault,
    GatewayUnreachable,
    NotAGateway,
    NotAllowed,
    NotAnswered,
    NotKnown,
    NotNow,
    NotRecognised,
    NotThere,
    NotTrusted,
    TooManyCalls,
    WrongRequest,
)
from rosic.client.events import Connected, Disconnected

__all__ = [
    "ApiProblem",
    "ClientError",
    "Connected",
    "Disconnected",
    "GatewayFault",
    "GatewayUnreachable",
    "NotAGateway",
    "NotAllowed",
    "NotAnswered",
    "NotKnown",
    "NotNow",
    "NotRecognised",
    "NotThere",
    "NotTrusted",
    "RosicClient",
    "TooManyCalls",
    "WrongRequest",
]

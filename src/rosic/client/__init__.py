"""A client of the API: for programs that ask a gateway from elsewhere."""

from __future__ import annotations

from rosic.client.client import RosicClient
from rosic.client.errors import ApiProblem, ClientError, NotAnswered

__all__ = ["ApiProblem", "ClientError", "NotAnswered", "RosicClient"]

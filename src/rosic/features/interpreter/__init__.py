"""What is not understood, shown to an interpreter that may only propose; off by default."""

from __future__ import annotations

from typing import TYPE_CHECKING

from rosic.features.interpreter.client import InterpreterClient, InterpreterParts
from rosic.features.interpreter.commands import InterpreterCommands
from rosic.features.interpreter.proposals import ProposalReader
from rosic.gateway.feature import Feature

if TYPE_CHECKING:
    from rosic.gateway.feature import Kernel

__all__ = ["InterpreterFeature", "setup"]


class InterpreterFeature(Feature):
    """Asks an interpreter about what was refused because it could not be read.

    Attributes:
        client: Asks.
    """

    def __init__(self, client: InterpreterClient) -> None:
        self.client = client

    @property
    def quiet(self) -> bool:
        """Whether nothing is being asked."""
        return self.client.quiet

    async def each_minute(self) -> None:
        """Log what came of asking, in numbers."""
        self.client.note()

    async def close(self) -> None:
        """Cut off what is being asked. Nobody is heard any more."""
        self.client.close()


def setup(kernel: Kernel) -> Feature:
    """Hear of what is not understood, where an interpreter is configured.

    Where the record cannot keep what people have said to it, nobody is asked: a no would be lost.
    """
    client = _client(kernel) if kernel.containers is not None else None
    InterpreterCommands(client, kernel.preferences, kernel.changes).register(kernel.commands)
    if client is None:
        return Feature()
    kernel.pipeline.hooks.not_understood.connect(client.hear)
    kernel.erasure.join(end=client.erase)
    return InterpreterFeature(client)


def _client(kernel: Kernel) -> InterpreterClient | None:
    if kernel.interpreter is None:
        return None
    parts = InterpreterParts(
        rooms=kernel.rooms,
        pipeline=kernel.pipeline,
        proposals=ProposalReader(kernel.rooms, kernel.pipeline.agreements),
        preferences=kernel.preferences,
        changes=kernel.changes,
        codes_in=kernel.access.enrolment.invitations.shown_in,
        clock=kernel.machine_clock,
    )
    return InterpreterClient(kernel.interpreter, parts)

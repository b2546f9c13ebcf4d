"""What a client of the API meets, sorted by whether the gateway has answered.

ClientError
|-- ApiProblem              the gateway has answered: no, and why. Nothing was done
|   |-- NotRecognised       the key is none, or is not good any more
|   |-- NotAllowed          the key does not give this right
|   |-- NotThere            no such robot, skill or order, as far as the key may see
|   |-- WrongRequest        not understood, or outside the bounds; offers says what would do
|   |-- NotNow              taken, busy, stopped, void: another time, or after something else
|   |-- TooManyCalls        wait for retry_after_s
|   `-- GatewayFault        the gateway could not; its operator has to look
`-- NotAnswered             the gateway has not answered
    |-- GatewayUnreachable  nobody listens there, or the network is away. Nothing was done
    |-- NotTrusted          its certificate is trusted by nobody here. Nothing was done
    |-- NotAGateway         something answers there that is no ROSIC. Nothing was done by ROSIC
    `-- NotKnown            it was asked, and has not said what became of it

``str(error)`` is one sentence that a person may read.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, ClassVar, Final

from rosic.errors import RosicError

if TYPE_CHECKING:
    from collections.abc import Mapping

    from rosic.api.schemas import Problem


class ClientError(RosicError):
    """The root. Never raised itself."""

    code: ClassVar[str] = "client"


class ApiProblem(ClientError):
    """The gateway has answered, and it is a refusal. No robot has moved by it.

    Attributes:
        problem: All that it says.
    """

    code: ClassVar[str] = "refused"

    def __init__(self, problem: Problem) -> None:
        super().__init__(problem.detail)
        self.problem = problem

    @property
    def kind(self) -> str:
        """Stable name of the kind: ``robot-busy``."""
        return self.problem.code

    @property
    def offers(self) -> tuple[str, ...]:
        """Lines that would be accepted instead."""
        return self.problem.offers

    @property
    def retry_after_s(self) -> float | None:
        """Seconds until trying again may succeed; None: it is not said."""
        return self.problem.retry_after_s


class NotRecognised(ApiProblem):
    """The key is none, or is not good any more."""

    code = "unrecognised"


class NotAllowed(ApiProblem):
    """The key does not give this right, or not from here."""

    code = "not-permitted"


class NotThere(ApiProblem):
    """There is no such thing, as far as the key may see."""

    code = "not-found"


class WrongRequest(ApiProblem):
    """It is not understood, or outside the bounds."""

    code = "not-understood"


class NotNow(ApiProblem):
    """The robot is taken, busy or stopped; or the order is void, or stands for another."""

    code = "not-now"


class TooManyCalls(ApiProblem):
    """Wait, then ask again."""

    code = "too-many-requests"


class GatewayFault(ApiProblem):
    """The gateway could not. Unlike other problems it may have done a part; please look."""

    code = "gateway-fault"


class NotAnswered(ClientError):
    """The gateway has not answered.

    Attributes:
        url: Whom was asked.
    """

    code: ClassVar[str] = "no-answer"

    def __init__(self, sentence: str, *, url: str) -> None:
        super().__init__(sentence)
        self.url = url


class GatewayUnreachable(NotAnswered):
    """Nobody listens there, or the network is away. Nothing was done."""

    code = "gateway-unreachable"


class NotTrusted(NotAnswered):
    """Its certificate is signed by nobody who is trusted here, or for another name."""

    code = "not-trusted"


class NotAGateway(NotAnswered):
    """Something answers there that is no ROSIC, or ROSIC is not at that path."""

    code = "not-a-gateway"


class NotKnown(NotAnswered):
    """It was asked, and its answer did not come: it may have been done."""

    code = "not-known"


_BY_STATUS: Final[Mapping[int, type[ApiProblem]]] = {
    400: WrongRequest,
    401: NotRecognised,
    403: NotAllowed,
    404: NotThere,
    405: NotThere,
    413: WrongRequest,
    421: NotAllowed,
    422: WrongRequest,
    429: TooManyCalls,
}
SERVER_FAULTS: Final = 500


def raised_for(problem: Problem) -> ApiProblem:
    """Return the error that stands for a problem."""
    kind = GatewayFault if problem.status >= SERVER_FAULTS else NotNow
    return _BY_STATUS.get(problem.status, kind)(problem)

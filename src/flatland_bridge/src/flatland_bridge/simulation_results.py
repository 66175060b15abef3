"""Results of the services of simulation_interfaces."""

from typing import Any, Dict, Optional

from flatland_bridge import simulation_types
from flatland_server.exceptions import FlatlandError
from flatland_server.hub import Action, told

Result = simulation_types.message("Result")


class Failure(FlatlandError):
    """A result other than RESULT_OK.

    Args:
        code: result code of simulation_interfaces.
        text: message for the client.
    """

    def __init__(self, code: int, text: str) -> None:
        super().__init__(text)
        self.code = code


def with_result(action: Action) -> Action:
    """An action that returns a result in its response, also when it fails.

    Args:
        action: may raise a Failure, or what fails without a code of its own.
    """

    def answer(request: Any) -> Optional[Dict[str, Any]]:
        try:
            fields = action(request) or {}
        except Failure as failure:
            return {"result": Result(failure.code, str(failure))}
        except (FlatlandError, ValueError) as error:
            return {"result": Result(Result.RESULT_OPERATION_FAILED, told(error))}
        return {"result": Result(Result.RESULT_OK, ""), **fields}

    return answer


def path_of(uri: str) -> str:
    """The path of a file, which clients may write as a URI."""
    return uri[len("file://") :] if uri.startswith("file://") else uri

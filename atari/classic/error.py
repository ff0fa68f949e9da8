"""Gymnasium's errors, and those that only Gym had."""

from typing import Any

from gymnasium.error import *  # noqa: F403
from gymnasium.error import Error, UnregisteredEnv

Unregistered = UnregisteredEnv
"""Gym's name for what is not in a registry, an environment or a benchmark."""


class UnregisteredBenchmark(Unregistered):
    """There is no benchmark of this ID."""


class UnseedableEnv(Error):
    """The environment cannot be seeded."""


class ResetNotAllowed(Error):
    """The episode is not over, and the monitor does not allow a reset within."""


class VideoRecorderError(Error):
    """A video cannot be recorded."""


class InvalidFrame(Error):
    """The recorded value is no frame of a video."""


class DoubleWrapperError(Error):
    """A wrapper is around another one of its kind."""


class WrapAfterConfigureError(Error):
    """The environment was wrapped too late."""


class RetriesExceededError(Error):
    """It was tried too often."""


class APIError(Error):
    """A failed request to Gym's site for results, which is closed; nothing here raises it."""

    def __init__(
        self,
        message: str | None = None,
        http_body: Any = None,
        http_status: int | None = None,
        json_body: Any = None,
        headers: dict[str, str] | None = None,
    ) -> None:
        super().__init__(message)
        self.http_body = http_body
        self.http_status = http_status
        self.json_body = json_body
        self.headers = headers or {}
        self.request_id = self.headers.get("request-id")


class APIConnectionError(APIError):
    """The site did not answer."""


class InvalidRequestError(APIError):
    """The site did not accept the request; `param` is the wrong parameter."""

    def __init__(
        self,
        message: str,
        param: str,
        http_body: Any = None,
        http_status: int | None = None,
        json_body: Any = None,
        headers: dict[str, str] | None = None,
    ) -> None:
        super().__init__(message, http_body, http_status, json_body, headers)
        self.param = param


class AuthenticationError(APIError):
    """The site did not accept the key."""


class RateLimitError(APIError):
    """There were too many requests."""

"""`gym.configuration`: the set-up of Python's logging by Gym, until 2017."""


def undo_logger_setup() -> None:
    """Return without a change: this package does not set up Python's logging."""

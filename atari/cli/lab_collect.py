"""`atari lab collect`: another name of `atari collect`."""

from typing import TYPE_CHECKING

from atari.cli import collect

if TYPE_CHECKING:
    from atari.cli.arguments import Commands


def register(commands: "Commands") -> None:
    """Add `atari lab collect`."""
    collect.register(commands, "lab collect")

"""Games of two to four players: PettingZoo's Atari environments on the native emulator."""

from atari.multiplayer.core import MultiplayerCore

__all__ = ["MultiplayerCore"]

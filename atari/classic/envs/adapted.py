"""`Adapted`: the environment classes that scripts import from `gym.envs`, construct, subclass and recognise.

Each is an `Adapter` of one class of Gymnasium or of this package. `make` returns the same classes, so that
`isinstance(env.unwrapped, gym.envs.atari.AtariEnv)` holds.
"""

from typing import Any, ClassVar

import gymnasium

from atari.classic.adapter import CLASSES, Adapter, old_metadata, quiet_options
from atari.classic.core import Env


class Adapted(Adapter):
    """An environment of the class `original`; a direct subclass sets it.

    A user's subclass may replace methods and constants of the class `original`, except the methods of `Env`: they are
    replaced in the adapted environment too, whose `step` uses them.
    """

    original: ClassVar[type[gymnasium.Env[Any, Any]]]
    _replaced: ClassVar[frozenset[str]] = frozenset()
    """The names in the class `original` that a user's subclass replaces."""

    def __init_subclass__(cls, **options: Any) -> None:
        super().__init_subclass__(**options)
        if "original" in vars(cls):
            CLASSES[cls.original] = cls
            cls.metadata = old_metadata(cls.original)
        elif hasattr(cls, "original"):
            names = (name for name in vars(cls) if hasattr(cls.original, name) and not hasattr(Adapter, name))
            cls._replaced = cls._replaced.union(names)

    def __init__(self, **options: Any) -> None:
        super().__init__(self.original(**quiet_options(self.original), **options))
        for name in self._replaced:
            setattr(self.modern, name, getattr(self, name))

    def __setattr__(self, name: str, value: Any) -> None:
        super().__setattr__(name, value)
        if "modern" in self.__dict__ and name in self._replaced:
            setattr(self.modern.unwrapped, name, value)

    def __str__(self) -> str:
        return Env.__str__(self)

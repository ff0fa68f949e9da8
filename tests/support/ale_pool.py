"""ale-py's interface for the tests, which uses loaded interfaces again: a load of a ROM takes 0.2 CPU seconds.

A load takes an interface of the pool if one has the same ROM and settings, and if an interface has loaded this ROM with
this seed and frame skip before. It restores the state after that load, which has the random generator, the mode and the difficulty.
ale-py's states leave out the framebuffer, the held action, and the sound generator, of which a reset sets the first two.
So an interface of the pool is used only if a reset comes before the first frame and the first read, and the pool has no
interfaces with sound, and none of games whose rules keep variables over a reset.
`tests/cores/test_ale_pool.py` compares it with ale-py's.
"""

from functools import partial, partialmethod
from pathlib import Path
from types import ModuleType
from typing import Any

import ale_py
import ale_py.env

from atari.cores import ale
from atari.games.catalog import games

ROMS = Path(ale_py.__file__).parent / "roms"
KEPT_OVER_RESET = {game.id for game in games.playable() if game.rules is not None and game.rules.kept_over_reset}

_unused: list[tuple[Any, ale_py.ALEInterface]] = []
"""The interfaces that no test has, each after its ROM and settings; the oldest first, and at most `_MOST`."""
_MOST = 30
_loaded: dict[Any, ale_py.ALEState] = {}
"""The state after a load, by ROM, seed and `_OF_LOADING`."""
_OF_LOADING = ("frame_skip", "repeat_action_probability")
"""Settings on which the reset inside a load depends, in games whose mode is selected by playing."""
_CHANGES = ("setMode", "setDifficulty", "restoreState", "restoreSystemState")
_FACTS = ("cloneState", "cloneSystemState", "getMinimalActionSet", "getLegalActionSet")
_FACTS += ("getAvailableModes", "getAvailableDifficulties", "getScreenDims", "getRAMSize", "getAudioSize")
_PLAY = ("act", "reset_game", "lives", "game_over", "game_truncated", "getRAM", "getScreen", "getScreenRGB", "getAudio")


class PooledInterface:
    """An interface that takes settings, then a ROM, and then has the methods of ale-py's."""

    setLoggerMode = ale_py.ALEInterface.setLoggerMode
    isSupportedROM = ale_py.ALEInterface.isSupportedROM

    def __init__(self) -> None:
        self._settings: dict[str, tuple[str, Any]] = {}
        self._ale: ale_py.ALEInterface | None = None
        self._keep = False
        """Whether the pool gets the interface back."""
        self._before_reset: list[tuple[str, tuple[Any, ...]]] | None = None
        """The calls on an interface of the pool, until its reset."""

    def _set(self, setter: str, name: str, value: Any) -> None:
        self._settings[name] = setter, value
        self._keep &= name == "random_seed"
        if self._ale is not None:
            getattr(self._ale, setter)(name, value)

    setInt = partialmethod(_set, "setInt")
    setFloat = partialmethod(_set, "setFloat")
    setBool = partialmethod(_set, "setBool")
    setString = partialmethod(_set, "setString")

    def loadROM(self, rom: Any) -> None:
        """Load a game, or take an interface that has loaded it."""
        self._give_back()
        settings = dict(self._settings)
        _, seed = settings.pop("random_seed", ("setInt", None))
        self._start = (str(rom), seed, *(settings.get(name) for name in _OF_LOADING))
        self._like = (str(rom), *sorted(settings.items()))
        path, (_, sound) = Path(str(rom)), settings.get("sound_obs", ("setBool", False))
        known = path.parent == ROMS and path.stem not in KEPT_OVER_RESET
        self._keep = known and not sound and seed not in (None, -1)  # -1 is the clock
        found = next((pair for pair in reversed(_unused) if pair[0] == self._like), None)
        if self._keep and self._start in _loaded and found is not None:
            _unused.remove(found)
            self._ale, self._before_reset = found[1], []
            self._ale.restoreSystemState(_loaded[self._start])
        else:
            self._load(rom)

    def _load(self, rom: Any) -> None:
        loading = ale_py.ALEInterface()
        for name, (setter, value) in self._settings.items():
            getattr(loading, setter)(name, value)
        loading.loadROM(rom)
        self._ale, self._before_reset = loading, None
        _loaded.setdefault(self._start, loading.cloneSystemState())

    def __setattr__(self, name: str, value: Any) -> None:
        if not name.startswith("_"):
            raise AttributeError(f"an interface has no attribute {name!r} that can be set")
        super().__setattr__(name, value)

    def __getattr__(self, name: str) -> Any:
        if name.startswith("_") or self._ale is None:
            raise AttributeError(name)
        if name in _CHANGES:
            return partial(self._change, name)
        if self._before_reset is None or name in _FACTS:
            return getattr(self._ale, name)
        if name != "reset_game":
            changes = self._before_reset
            self._give_back()
            self._load(self._start[0])
            for change, arguments in changes:
                getattr(self._ale, change)(*arguments)
        self._before_reset = None
        vars(self).update({method: getattr(self._ale, method) for method in _PLAY})
        return getattr(self, name)

    def _change(self, name: str, *arguments: Any) -> Any:
        keep, self._keep = self._keep, False
        result = getattr(self._ale, name)(*arguments)
        if self._before_reset is not None:
            self._before_reset.append((name, arguments))
        self._keep = keep and (self._before_reset is not None or not name.startswith("restore"))
        return result

    def _give_back(self) -> None:
        if self._keep and self._ale is not None:
            _unused.append((self._like, self._ale))
            del _unused[:-_MOST]
        self._ale = None
        for method in _PLAY:
            vars(self).pop(method, None)

    __del__ = _give_back


def use_pool() -> None:
    """Let `AleCore` and ale-py's `AtariEnv` load their games from the pool in this process."""
    ale.ALEInterface = PooledInterface
    ale_py.env.ale_py = ModuleType("ale_py")
    vars(ale_py.env.ale_py).update(vars(ale_py), ALEInterface=PooledInterface)

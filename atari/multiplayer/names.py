"""`PettingZooNames`: the attributes and methods of PettingZoo's Atari environments, for `MultiplayerEnv`."""

from collections.abc import Callable
from operator import attrgetter
from typing import Any

import atari._emulator as _emulator
from atari.base.validation import check_integer
from atari.cores import ByteArray
from atari.multiplayer.ale import MultiplayerAle
from atari.roms import find
from atari.task import Task
from atari.task.checks import NO_LIMIT

OBS_TYPES = {"rgb_image": "rgb", "grayscale_image": "grayscale"}
"""The values of `obs_type` by PettingZoo's names."""


class PettingZooNames:
    """The names of PettingZoo's environments, as views of the task and the core.

    States are those of the emulator alone, as in PettingZoo: the agents that play, `frame` and stacked images stay.
    `MultiplayerEnv.snapshot` has these too.
    """

    core: Any
    possible_agents: list[str]
    _task: Task
    _ale: MultiplayerAle
    _episode: _emulator.Episode
    _continued: Callable[[bytes], _emulator.Episode]

    @property
    def task(self) -> Task:
        """The task, with the later settings of the core."""
        played = self.core.task
        return self._task.with_checked(**{name: getattr(played, name) for name in _OF_CORE})

    ale = property(attrgetter("_ale"), doc="The core under the names of Multi-Agent-ALE's `ALEInterface`.")
    frame = property(attrgetter("_episode.steps"), doc="Steps of the episode.")
    num_players = property(attrgetter("core.players"), doc="The number of players.")
    full_action_space = property(lambda self: self._task.actions == "full", doc="Whether all 18 actions can be taken.")
    rom_path = property(lambda self: str(find(self.core.game, self.core.rom)), doc="The path of the ROM file.")

    @property
    def obs_type(self) -> str:
        """The kind of observations: "rgb_image", "grayscale_image", or the task's name of another one."""
        kind = self._task.obs_type
        return next((name for name, field in OBS_TYPES.items() if field == kind), kind)

    @property
    def mode(self) -> int:
        """The mode, by Multi-Agent-ALE's number. It can be set to one for the same players, from the next reset on."""
        return int(self.core.mode)

    @mode.setter
    def mode(self, mode: int) -> None:
        self.core.set_mode(mode)

    @property
    def max_cycles(self) -> int | None:
        """The most steps of an episode; it can be set at any time."""
        return self._task.max_episode_steps

    @max_cycles.setter
    def max_cycles(self, steps: int) -> None:
        self._task = self._task.with_checked(max_episode_steps=check_integer("max_cycles", steps, 1, NO_LIMIT))
        self._episode = self._continued(self._episode.save())

    @property
    def terminations(self) -> dict[str, bool]:
        """Whether the game of each agent has ended by its rules."""
        outs = self._episode.out
        return {agent: self.core.game_over or out for agent, out in zip(self.possible_agents, outs, strict=True)}

    def clone_state(self) -> ByteArray:
        """The emulator's state, uint8, without the generator of sticky actions."""
        return self._ale.encodeState(self._ale.cloneState())

    def restore_state(self, state: ByteArray) -> None:
        """Continue from a result of `clone_state`; the generator goes on.

        Raises:
            TypeError, ValueError: it is no such result, or is of another game.
        """
        self._ale.restoreState(self._ale.decodeState(state))

    def clone_full_state(self) -> ByteArray:
        """The emulator's state, uint8, with the generator of sticky actions."""
        return self._ale.encodeState(self._ale.cloneSystemState())

    restore_full_state = restore_state


_OF_CORE = ("mode", "difficulty", "repeat_action_probability", "max_num_frames_per_episode")
"""The fields of the task that can be set in a core."""

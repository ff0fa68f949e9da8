"""`EnvState`: the state of an `AtariEnv`, its snapshots and pickles."""

import copy
from collections.abc import Mapping
from typing import Any, get_args

import gymnasium
import numpy as np

import atari._emulator as _emulator
from atari.cores import ByteArray, Core, snapshot
from atari.cores.ale_interface import AleSettings
from atari.cores.ale_random import AleRandom
from atari.env.driver import Driver, Phase, Played
from atari.env.lane_snapshot import LaneSnapshot, LaneState, new_episode, split
from atari.games.game import Game
from atari.task import Task
from atari.task.fields import GROUPS
from atari.task.json_form import identity, require_same


class EnvState(gymnasium.Env[Any, Any]):
    """The methods of `AtariEnv` that save and restore it."""

    game: Game

    driver: Driver
    """The object that plays the frames, for wrappers and recorders."""

    whole_task: Task
    """The task played together with the wrappers that `atari.make` has put around this; `task` also has the later
    settings."""

    _task: Task  # the task without wrappers, before any setting of `ale`
    _frames: list[ByteArray]
    _begin: Any
    _made_with: dict[str, Any]  # the arguments of `_begin`

    @property
    def core(self) -> Core:
        """The emulator core; with an assigned `ale`, a core that plays and reads through that object."""
        return self.driver.core

    @property
    def ale_settings(self) -> AleSettings:
        """The settings of `ale`, as `ale.setFloat` and the other setters change them."""
        return self.driver.ale_settings

    @property
    def np_random(self) -> np.random.Generator:
        """The generator of no-ops and frame skips."""
        return self.driver.np_random

    @np_random.setter
    def np_random(self, generator: np.random.Generator) -> None:
        self.driver.np_random = generator
        self._np_random_seed = -1

    @property
    def task(self) -> Task:
        """The task played with the wrappers that `atari.make` has put around this, with the settings of `ale`."""
        return self._as_set(self.whole_task)

    def _as_set(self, task: Task) -> Task:
        """A task with the settings that `ale` has made since."""
        own, settings, core = self._task, self.driver.core_options, self.core
        fields = {
            "repeat_action_probability": settings["repeat_action_probability"],
            "max_num_frames_per_episode": settings["max_num_frames_per_episode"] or None,
            "mode": core.mode,
            "difficulty": core.difficulty,
        }
        return task.with_checked(**{name: value for name, value in fields.items() if value != getattr(own, name)})

    def clone_state(self, include_rng: bool = False) -> Any:
        """The emulator's state, in memory; like ale-py's, it leaves out the framebuffer. `snapshot` is complete."""
        return self.core.clone_state(include_rng=include_rng)

    def restore_state(self, state: Any) -> None:
        """Continue from a state that `clone_state` returned.

        Raises:
            TypeError, ValueError: it is no such state, or belongs to another game or kind of core.
        """
        self.driver.restore_state(state)

    def snapshot(self) -> bytes:
        """The whole environment as portable bytes: task, game, framebuffer, sound, held action, all generators.

        An environment of the same task, also in another process, continues from it exactly. The `snapshot` of a wrapper
        of `atari.wrappers` also has the wrapper's own state, such as stacked frames. The writes of `Freeze` and `Poke`
        belong to an environment, and not to its snapshots.
        """
        driver = self.driver
        return self._pack(self.core.snapshot(), driver.phase, driver.played, driver.np_random, driver.ale_random)

    def _pack(
        self, core: bytes, phase: Phase, played: Played, np_random: np.random.Generator, ale_random: AleRandom | None
    ) -> bytes:
        facts = {
            "of": "AtariEnv",
            "phase": phase,
            "np_random": np_random.bit_generator.state,
            "game": [played.score, played.steps, played.first_frame],
            "task": identity(self._as_set(self._task)),
        }
        more_facts, more_blobs = _ale_seeding(ale_random)
        return snapshot.pack(facts | more_facts, {"core": core, **more_blobs})

    def _snapshot_of(self, lane: LaneState, episode: _emulator.Episode) -> bytes:
        """The snapshot of this environment that continues a lane, whose `Episode` is given."""
        played = Played(float(episode.score), episode.steps, episode.first_frame)
        phase: Phase = "over" if episode.ended else "playing"
        return self._pack(lane.core, phase, played, lane.np_random or self.np_random, lane.ale_random)

    def _of_lane(self, lane: LaneSnapshot) -> bytes:
        if self.whole_task.preprocessed:
            raise ValueError(
                "the snapshot is of a lane, with its stack and counters; pass it to restore of the outermost wrapper"
            )
        require_same(lane.task, self.task)
        state, episode = split(lane, self.task, self.driver), new_episode(self.task, self.driver)
        episode.load(state.episode)
        return self._snapshot_of(state, episode)

    def restore(self, data: bytes | LaneSnapshot) -> None:
        """Continue from a snapshot of the same task; only the kind of observations may differ.

        `data` may also be the content of a file that F5 in `atari play` has saved. Its game, mode and difficulty must
        equal those of this environment, which keeps its own sticky actions, sound and limit of frames. `data`
        may also be an element of what `AtariVectorEnv.snapshot` returned, of an equal task.

        Wrappers are not restored; a wrapper of `atari.wrappers` that has a state warns at its next step. Call `restore`
        of the outermost wrapper instead, with what its `snapshot` returned.

        Raises:
            TypeError, ValueError: `data` is no snapshot, is damaged, or belongs to another task or core; the message
                lists each field that differs. The environment has not changed.
        """
        facts, blobs = snapshot.unpack(self._of_lane(data) if isinstance(data, LaneSnapshot) else data)
        saved_in_play = facts.get("of") == "play"
        if saved_in_play:
            facts, blobs = self._of_play(blobs)
        facts.setdefault("seeding", "gymnasium")
        own, own_blobs = _ale_seeding(self.driver.ale_random)
        if facts.get("of") == "wrappers":
            raise ValueError(
                "the snapshot is of an environment with its wrappers; pass it to restore of the outermost wrapper"
            )
        snapshot.require(facts, {"of": "AtariEnv", "seeding": own.get("seeding", "gymnasium")})
        if not saved_in_play:
            require_same(facts.get("task"), self._as_set(self._task), ignored=GROUPS["observation"])
            blobs = {**blobs, "core": self._as_made(blobs.get("core", b""))}
        self._continue(facts, blobs, own_blobs)

    def _as_made(self, data: bytes) -> bytes:
        """A core's snapshot, changed to this environment's mode and difficulty at its making, which `ale` may have
        changed there."""
        facts, blobs = snapshot.unpack(data)
        made = {"mode": self._task.set_mode, "difficulty": self._task.set_difficulty}
        return data if facts.items() >= made.items() else snapshot.pack({**facts, **made}, blobs)

    def _continue(self, facts: Mapping[str, Any], blobs: Mapping[str, bytes], own_blobs: Mapping[str, bytes]) -> None:
        snapshot.require_blobs(blobs, "core", *own_blobs)
        phase: Any = facts.get("phase")
        if phase not in get_args(Phase):
            raise ValueError(f"the snapshot is damaged: its phase is none of {', '.join(get_args(Phase))}")
        generator = self.np_random.bit_generator
        state = snapshot.check_generator(facts.get("np_random"), type(generator))
        game = _read_game(facts.get("game", [0.0, 0, 0]))
        ale_random = AleRandom.of_state(blobs["ale_random"]) if own_blobs else None
        driver = self.driver
        driver.core.restore(blobs["core"])
        generator.state = state
        driver.ale_random = ale_random
        driver.phase = phase
        driver.played, driver.ended = game, None
        driver.restored = True
        self._frames.clear()

    def _of_play(self, blobs: Mapping[str, bytes]) -> tuple[dict[str, Any], dict[str, bytes]]:
        """The facts and blobs of a snapshot from a state of `atari play`, with the options of this environment."""
        facts, blobs = snapshot.unpack(blobs.get("env", b""))
        own, _ = snapshot.unpack(self.core.snapshot())
        options = {name: own[name] for name in ("sound", "repeat_action_probability", "max_num_frames_per_episode")}
        more_facts, more_blobs = _ale_seeding(self.driver.ale_random)
        core = snapshot.with_options(blobs.get("core", b""), **options)
        return {**facts, **more_facts}, {**blobs, "core": core, **more_blobs}

    def __getstate__(self) -> dict[str, Any]:
        """Pickling and copying keep the position in the game, all generators, and the writes of `Freeze` and `Poke`.

        Raises:
            TypeError: `ale` was assigned.
        """
        if self.core is not self.driver.emulated:
            raise TypeError(
                "env.ale was assigned, and that object plays this environment alone; assign the former env.ale before "
                "you copy or pickle the environment"
            )
        return {
            "made_with": self._made_with,
            "whole_task": self.whole_task,
            **self.driver.settings_state(),
            "spec": copy.deepcopy(self.spec),
            "action_space": copy.deepcopy(self.action_space),
            "restored": self.driver.restored,
            "ale_random": self.driver.ale_random,
            "actions": self.driver.actions,
            "np_random_seed": self._np_random_seed,
            "snapshot": self.snapshot(),
        }

    def __setstate__(self, state: dict[str, Any]) -> None:
        self._begin(**state["made_with"])
        self.whole_task = state["whole_task"]
        self.driver.restore_settings(state)
        self.driver.ale_random = state["ale_random"]
        self.driver.actions = state["actions"]
        self._continue(*snapshot.unpack(state["snapshot"]), _ale_seeding(state["ale_random"])[1])
        self._np_random_seed = state["np_random_seed"]
        self.driver.restored = state["restored"]
        self.spec, self.action_space = state["spec"], state["action_space"]


def _ale_seeding(generator: AleRandom | None) -> tuple[dict[str, Any], dict[str, bytes]]:
    """The fact and the blob of a snapshot that say how episodes are seeded; none if Gymnasium's seeding applies."""
    return ({}, {}) if generator is None else ({"seeding": "ale"}, {"ale_random": generator.state()})


def _read_game(values: Any) -> Played:
    kinds = [type(value) for value in values] if isinstance(values, list) else []
    if kinds != [float, int, int] or min(values[1:]) < 0:
        raise ValueError(f"the snapshot is damaged: a game's score, steps and first frame cannot be {values!r}")
    return Played(*values)

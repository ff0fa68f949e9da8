"""`EpisodeEnv`: the preprocessing of a task around a single `AtariEnv`, as one wrapper.

It plays the rules of `atari.wrappers` (no-ops, FIRE, lives, frame skip, stack, reward) by `_emulator.Episode`, as a
lane of `AtariVectorEnv` does, on the `AtariEnv`'s own core. The nested wrappers give the same bytes, more slowly.
"""

from collections.abc import Sequence
from os import PathLike
from typing import Any

import numpy as np
from gymnasium import logger
from gymnasium.wrappers import OrderEnforcing, PassiveEnvChecker

import atari._emulator as _emulator
from atari.base.gymnasium_versions import adds_episode
from atari.base.validation import check_integer
from atari.cores.ale_random import AleRandom
from atari.env.env import AtariEnv, options_of_reset
from atari.env.lane_snapshot import LaneSnapshot, LaneState, join, new_episode
from atari.env.restorable import Environment, RestorableWrapper, State, layers, warn_of_restore
from atari.env.settings import observation_space
from atari.task import Task
from atari.task.json_form import identity

STEPS_WITHOUT_PROGRESS = 2250  # 9,000 frames, two and a half minutes of play

Result = tuple[Any, float, bool, bool, dict[str, Any]]


class EpisodeEnv(RestorableWrapper):
    """A task's preprocessing around an `AtariEnv`; `atari.make` returns it for every preset.

    Observations, rewards, ends and `info` are described in `atari.Task` and `atari.wrappers.preset`.

    Args:
        env: an `AtariEnv` for which `can_play` is true.
        task: the task, or its JSON.

    Raises:
        TypeError, ValueError: `task` is no task.

    Example:
        >>> import atari
        >>> env = atari.make("breakout", preset="dqn2015")
        >>> type(env).__name__
        'EpisodeEnv'
        >>> observation, info = env.reset(seed=0)
        >>> observation, reward, terminated, truncated, info = env.step(1)
        >>> observation.shape, info["elapsed_step"]
        ((4, 84, 84), 1)
    """

    def __init__(self, env: Environment, task: Task | str) -> None:
        task = Task.from_json(task) if isinstance(task, str) else task
        super().__init__(env, task=_recorded(task))
        self._atari: AtariEnv = env.unwrapped  # type: ignore[assignment]  # as `can_play` says
        self.preprocessing = task
        """The task whose preprocessing this object plays."""
        self.frame_skip = task.frameskip
        if task.seeding == "ale":  # the AtariEnv keeps the generator, for its snapshots and copies
            self._atari.driver.ale_random = AleRandom()
        self._episode = self._make_episode()
        self.observation_space = observation_space(task)
        self._shows = self._atari.render_mode in ("human", "rgb_array_list")
        names = [] if self._atari.continuous else self._atari.get_action_meanings()
        self._waiting = WaitingCheck(self._atari, names)

    def reset(self, *, seed: int | None = None, options: dict[str, Any] | None = None) -> tuple[Any, dict[str, Any]]:
        """Begin an episode. After a lost life, the task decides whether it continues the game.

        Args:
            seed: the seed of the environment; a seed begins a new game.
            options: "noops", a number of no-ops in place of the drawn one; "fire" false leaves FIRE out; "new_game"
                true begins a new game. A task without no-ops or FIRE does not have the first two.

        Raises:
            gymnasium.error.Error: the seed is no integer of 0 or more.
            TypeError, ValueError: there is no such option, or a value is out of range; nothing is reset.
        """
        task, rest = self.preprocessing, options_of_reset(options)
        noops = rest.pop("noops", None) if task.noops[1] or task.seeding == "ale" else None
        if noops is not None:
            noops = check_integer("noops", noops, 0, 1_000_000)
        fire = bool(rest.pop("fire", True)) if task.fire != "never" else True
        new_game = self._atari.reopen() or seed is not None or bool(rest.get("new_game"))
        begun: dict[str, Any] = {}

        def begin() -> Any:
            begun.clear()
            begun.update(self.env.reset(seed=seed, options=rest or None)[1])
            return self._atari.driver.core

        driver, before = self._atari.driver, self._episode.score
        on_frame = self._frame_played if driver.observers or self._shows else None
        observation, info = self._episode.reset(
            driver.core, begin, new_game=new_game, noops=noops, fire=fire, on_frame=on_frame
        )
        self._count(self._episode.score - (0 if begun else before))
        return observation, self._finished({**begun, **info})

    def step(self, action: Any) -> Result:
        """Play the action until the skip or the episode ends.

        Raises:
            gymnasium.error.ResetNeeded: before the first reset.
            TypeError, ValueError: the action is not in the action space.
        """
        driver = self._atari.driver
        if driver.restored:
            warn_of_restore(self._atari, "EpisodeEnv")
        number, strength = driver.ale_action(action)
        was_over = driver.phase != "playing" and driver.check_phase()
        on_frame = self._frame_played if driver.observers or self._shows else None
        result: Result = self._episode.step(driver.core, number, strength, on_frame)
        game, info = driver.played, result[4]
        game.steps += 1
        info["elapsed_step"] = game.steps
        if reward := info["reward"]:
            self._count(reward)
        if game.steps % STEPS_WITHOUT_PROGRESS == 0:
            self._waiting.warn(action)
        if result[2] or result[3]:
            core = driver.core
            if not was_over and (core.game_over or core.truncated):
                driver.phase = "over"
            if "episode" in info:
                if was_over and not result[3]:
                    del info["episode"]  # which the step that ended the game had
                else:
                    info["episode"] = game.statistics(core)
            self._finished(info)
        return result

    def _frame_played(self, action: int, reward: int) -> None:
        for observer in self._atari.driver.observers:
            observer.frame_played(action, reward)
        if self._shows:
            self._atari.show()

    def _count(self, reward: float) -> None:
        game = self._atari.driver.played
        game.score += reward
        game.rewards += bool(reward)

    def _finished(self, info: dict[str, Any]) -> dict[str, Any]:
        """Set what the record of the game has, and leave out the game that Gymnasium's recorder adds."""
        info["elapsed_step"] = self._atari.driver.played.steps
        if "episode" in info:
            info["episode"]["t"] = round(info["episode"]["t"], 6)
            if adds_episode(self):
                del info["episode"]
        return info

    def _make_episode(self) -> _emulator.Episode:
        return new_episode(self.preprocessing, self._atari.driver)

    @property
    def snapshot_arguments(self) -> dict[str, Any]:
        """The arguments that a snapshot must have in common with this wrapper, beside the task's fields."""
        return {"images": self.preprocessing.kind.image or self.preprocessing.obs_type}

    def _save_state(self) -> State:
        return {"episode": np.frombuffer(self._episode.save(), np.uint8)}

    def _state_of_lane(self, lane: LaneState) -> State:
        return {"episode": np.frombuffer(lane.episode, np.uint8)}

    def _load_state(self, state: State) -> dict[str, Any]:
        episode = self._make_episode()
        episode.load(state["episode"].tobytes())
        return {"_episode": episode}

    def __getstate__(self) -> dict[str, Any]:
        """Pickling and copying keep the state of the episode."""
        return {**vars(self), "_episode": self._episode.save()}

    def __setstate__(self, state: dict[str, Any]) -> None:
        vars(self).update(state)
        self._episode = self._make_episode()
        self._episode.load(state["_episode"])


class WaitingCheck:
    """Warns once about a game in which nothing happens, because it may wait for FIRE.

    Args:
        atari: the environment.
        meanings: the names of the actions, by index.
    """

    def __init__(self, atari: AtariEnv, meanings: Sequence[str]) -> None:
        self._atari = atari
        self._fires = [index for index, name in enumerate(meanings) if "FIRE" in name]
        self._progress: Any = None  # the game, its rewards and its lives at the last call

    def warn(self, action: Any) -> None:
        """Warn if rewards and lives equal those `STEPS_WITHOUT_PROGRESS` steps ago, unless the action is FIRE."""
        game = self._atari.driver.played
        progress = game, game.rewards, self._atari.core.lives
        before, self._progress = self._progress, progress
        same = before is not None and before[0] is game and before[1:] == progress[1:]
        if same and self._fires and not any(action == fire for fire in self._fires):
            self._fires = []
            logger.warn(
                f"{self._atari.game.id} gave no reward and took no life for {STEPS_WITHOUT_PROGRESS} steps; it may "
                "wait for FIRE, which the agent must press: presets press it in resets at most. With "
                "preset='baselines', episodic_life=True, they do so after each lost life, and info['episode'] has "
                "whole games"
            )


def can_play(env: Environment, task: Task) -> bool:
    """Whether an `EpisodeEnv` plays a task around an environment; otherwise wrappers of `atari.wrappers` do.

    Those play around wrappers and subclasses with steps of their own, and refuse an environment that skips frames or
    does not show what the task needs.
    """
    atari = env.unwrapped
    if not isinstance(atari, AtariEnv) or atari.has_own_step or atari.game != task.definition:
        return False
    checks = all(type(layer) in (OrderEnforcing, PassiveEnvChecker) for layer in layers(env) if layer is not atari)
    if task.episodic_life and task.frameskip == 1:
        return False  # a `DqnPreprocessing` around it needs the inner `EpisodicLife`
    shows = not atari.sound_obs and (task.kind.image is None or atari.task.kind.image is not None)
    return checks and shows and atari.task.frameskip == 1


def single_env(task: Task, rom: str | PathLike[str] | None) -> AtariEnv | EpisodeEnv:
    """The single environment of the task of a lane.

    Raises:
        ValueError: several wrappers play it, whose state is not a lane's.
    """
    atari = AtariEnv(task.emulator_task() if task.preprocessed else task.replace(max_episode_steps=None), rom=rom)
    playable = can_play(atari, task)  # by the task without wrappers
    env = EpisodeEnv(atari, task) if task.preprocessed and playable else atari
    if task.preprocessed and not playable:
        raise ValueError(
            "with episodic_life and frameskip=1, wrappers play a single environment, and its snapshots do not continue "
            "in a vector; take the snapshot of a vector"
        )
    atari.whole_task = task
    return env


def lane_of(env: AtariEnv | EpisodeEnv) -> LaneSnapshot:
    """The snapshot of a lane that continues an environment of `single_env`."""
    atari = env.unwrapped
    assert isinstance(atari, AtariEnv)
    if isinstance(env, EpisodeEnv):
        episode = env._episode
    else:
        game, episode = atari.driver.played, new_episode(atari.task, atari.driver)
        episode.go_on(atari.core, int(game.score), game.steps, game.first_frame)
    return LaneSnapshot(join(episode, atari.driver), identity(atari.task))


def _recorded(task: Task) -> Task | str:
    """A task in the form in which the environment's spec has it."""
    try:
        return task.to_json()
    except ValueError:  # of a game that was made in memory
        return task

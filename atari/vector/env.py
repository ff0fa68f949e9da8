"""`AtariVectorEnv`: many Atari games as one Gymnasium vector environment, played in C++ by a pool of threads.

The threads also skip, pool, resize and stack frames, and write results straight into the arrays that the user gets.
Options, their defaults and their effects are those of ale-py's environment of the same name; equality to the byte is a
test. Options that ale-py does not have are marked "(added)".
"""

import os
import sys
from collections.abc import Mapping, Sequence
from functools import cached_property
from os import PathLike
from typing import Any, Literal

import gymnasium
import numpy as np
import numpy.typing as npt
from gymnasium import spaces
from gymnasium.vector.utils import batch_space
from typing_extensions import Unpack

import atari._emulator as _emulator
from atari.base.gymnasium_versions import AutoresetMode, VectorEnv, adds_episode
from atari.base.validation import FirstResetNeeded, check_known, check_name, check_probability
from atari.cores import ByteArray
from atari.games.game import Game
from atari.task.checks import check_bool
from atari.task.fields import VectorTaskOptions
from atari.task.task import GameLike
from atari.vector.lanes import AddedWrites, Lane
from atari.vector.options import VectorOptions, resolve_lanes
from atari.vector.results import Results, SequenceResults, indexed, pick_rows, with_played, zero_sum
from atari.vector.seeds import seed_words
from atari.vector.state import VectorState

IntArray = npt.NDArray[np.int64]
_OF_TASKS = ("self", "game", "num_envs", "preset", "options")
"""The arguments of `AtariVectorEnv` that decide the tasks, or are no options."""

_RESET_OPTIONS = ("reset_mask", "new_game")
_RAM_OF = {"now": _emulator.RamOf.NOW, "result": _emulator.RamOf.RESULT, "final": _emulator.RamOf.FINAL}


class AtariVectorEnv(VectorState, VectorEnv):
    """Environments of one game, or of several, played together in C++.

    `game` is an environment ID or an `atari.Task`, which decide the whole task, or a name. A name with a preset plays
    ALE's v5 with that preset. A name without a preset has the defaults of ale-py's class of this name, which
    docs/vector.md lists. `envs.task` is the result. `step` documents observations, rewards and `info`.

    Threads may share the object: one call runs at a time. In a forked process all methods but `close` raise
    RuntimeError.

    Args:
        game: an ID, a game's name, the path of a game file, a `Game` or a `Task`; a sequence has one for each
            environment (added). Games whose actions differ get all 18 as their common action space;
            `info["action_mask"]`, bool (batch, 18), says which of them a game uses.
        num_envs: number of environments; may be left out if `game` is a sequence.
        preset: name of a preprocessing, one of `atari.PRESETS` (added); "multiplayer_dqn" with `players`.
        batch_size: number of results in a batch; 0 means all. With fewer than all, `recv` returns the first ready
            ones, and `info["env_id"]` has their numbers.
        num_threads: greatest number of threads, the caller's included; 0 is the number of cores.
        thread_affinity_offset: if 0 or more, bind thread i to core offset + i, but not the caller's own (Linux).
        autoreset_mode: `gymnasium.vector.AutoresetMode`, its value or its name. With DISABLED (added), environments
            that are done ignore actions, with reward 0, until `reset(options={"reset_mask": ...})`.
        channels_last: images are (batch, img_height, img_width, stack_num), in RGB (batch, img_height, img_width,
            3 * stack_num). Gray images are then a transposed view, RGB images a copy (added).
        dtype: "uint8", or "float32" with the same values 0..255, which is a copy of four times the size (added).
        render_mode: "rgb_array" for `render` (added).
        rom: path of the ROM file; None searches (see `atari.roms`) (added).
        game_info: `info` has the statistics of whole games; None means True with a preset or with a task that has
            preprocessing (added).
        **options: fields of `atari.Task`, which describes them, and ale-py's other names of some fields, which
            docs/vector.md lists. `mode` and `difficulty` may be sequences with one for each environment.

    Raises:
        TypeError, ValueError: there is no such option (the nearest is suggested), or its value is wrong.
        FileNotFoundError: no ROM file of a game was found.

    Example:
        >>> import atari
        >>> atari.AtariVectorEnv("breakout", 8, preset="dqn2015").reset(seed=0)[0].shape
        (8, 4, 84, 84)
    """

    _process = 0  # the process that made the threads
    _port: _emulator.XlaPort | None = None  # for compiled functions

    def __init__(
        self,
        game: GameLike | Sequence[GameLike],
        num_envs: int | None = None,
        *,
        preset: str | None = None,
        batch_size: int = 0,
        num_threads: int = 0,
        thread_affinity_offset: int = -1,
        autoreset_mode: AutoresetMode | str = AutoresetMode.NEXT_STEP,
        channels_last: bool = False,
        dtype: npt.DTypeLike = "uint8",
        render_mode: Literal["rgb_array"] | None = None,
        rom: str | PathLike[str] | None = None,
        game_info: bool | None = None,
        **options: Unpack[VectorTaskOptions],
    ) -> None:
        self._given = {name: value for name, value in locals().items() if name not in _OF_TASKS}
        tasks, bare = resolve_lanes(game, num_envs, preset, options, self._given)
        self._begin(VectorOptions.check(tasks, bare, self._given))

    def _begin(self, options: VectorOptions) -> None:
        self._options = options
        self.num_envs = len(options.tasks)
        self.batch_size = options.batch_size
        self.games: tuple[Game, ...] = options.games
        self.render_mode = self._given["render_mode"]
        frames = sum(options.task.frames) - 1
        self.metadata = {
            "autoreset_mode": options.autoreset_mode,
            "render_modes": ["rgb_array"],
            "render_fps": max(1, round(options.games[0].screen.frame_rate / frames * 2)),
        }
        self._engine: _emulator.VectorEngine | None = options.make_engine()
        self._process = os.getpid()
        # Guards all attributes that change, and the engine between a send and its results.
        self._lock = _emulator.CallLock("vector environment")
        self._added = tuple(AddedWrites() for _ in self.games)
        self._singles = {}
        self.single_action_space = options.action_space()
        self.single_observation_space = options.layout.space(options.observation_space())
        self.action_space = options.batched_action_space()
        self._buffers = [Results(self._engine, options) for _ in range(2)]
        self._out_results: Results | None = None  # the results of the last step with `out`
        self._flying: Results | None = None  # the results that the environments are writing
        self._chosen: IntArray | None = None  # the numbers of the environments being played, unless all are
        self._phase: Literal["new", "idle", "sent"] = "new"
        self._masks = options.action_masks()
        self._closed_states: list[bytes] | None = None  # the lanes at `close`; `reset` continues from them

    @cached_property
    def observation_space(self) -> spaces.Space[Any]:  # type: ignore[override]
        """The space of a batch, made at the first use, because it holds four arrays of its shape."""
        return batch_space(self.single_observation_space, self.batch_size)

    def reset(
        self,
        *,
        seed: int | Sequence[int | None] | IntArray | None = None,
        options: dict[str, Any] | None = None,
    ) -> tuple[Any, dict[str, Any]]:
        """Reset all environments, or some, and return a batch of first observations. Reopens after `close`.

        Args:
            seed: the k-th environment that is reset, from 0 on, gets seed + k. If all are reset, environment i gets
                seed + i. An array has a seed for each environment that is reset; if it is negative or None, the
                environment keeps its generator. Seeds are within 0..2**32-1.
            options: {"reset_mask": bool (num_envs,)} resets only these; the others show their last results.
                {"new_game": True} begins new games, even if a lost life has ended the episode and the preset would
                continue the game.

        Raises:
            TypeError, ValueError: the seeds or the mask are of the wrong kind or length.
        """
        with self._lock:
            engine = self._begin_reset(seed, options)
            observation, _, _, _, info = self._receive(engine)
            return observation, info

    def reset_async(
        self, *, seed: int | Sequence[int | None] | IntArray | None = None, options: dict[str, Any] | None = None
    ) -> None:
        """Begin a reset; `recv` returns its results, with rewards of zero. Arguments and errors are those of `reset`.

        With `batch_size` less than `num_envs`, the first `recv` returns the environments that are ready first.
        """
        with self._lock:
            self._begin_reset(seed, options)
            self._phase = "sent"

    def _begin_reset(self, seed: Any, options: dict[str, Any] | None) -> _emulator.VectorEngine:
        if self._engine is None and _dict(options).get("reset_mask") is None:
            self._reopen()
        engine = self._open()
        mask = self.reset_mask(options)
        seeded, seeds = seed_words(seed, mask, ale=self._options.task.seeding == "ale")
        self._phase = "new"  # until the reset succeeds
        results = self._take_buffer(engine, None)
        batch = results.batch if self.batch_size == self.num_envs else None
        engine.reset(mask, seeded, seeds, batch, bool(_dict(options).get("new_game")))
        results.of_reset = True
        self._flying, self._chosen = results, None
        return engine

    def step(self, actions: Any, out: Any = None, env_id: Any = None) -> tuple[Any, Any, Any, Any, dict[str, Any]]:
        """Play a step of the environments of the last batch, or of some of all environments.

        Args:
            actions: integers (batch,), with `continuous` floats (batch, 3); row i is for the environment of row i of
                the last batch, which is environment i unless `batch_size` is less than `num_envs`.
            out: the array for the observations, instead of a buffer: a C-contiguous uint8 array of their shape, or
                with obs_type="dict" a dict of two.
            env_id: integers (rows,), the number of the environment for each row of `actions`, each once. Only these are
                played, and the results have only their rows, in this order, as copies. If `batch_size` is less than
                `num_envs`, they must be the environments of the last batch, in any order.

        Returns:
            Observations, rewards (int32, or float64 if the task has a `reward`), terminations and truncations (bool),
            (batch,) each, and info. Observations are uint8 (batch, stack_num, img_height, img_width), in RGB with a
            last axis of 3, the oldest frame first. **They do not change while you hold them**, or a view or a tensor of
            them. The step after the next, or a later one, writes to their memory again after the last reference has
            gone. To keep many, pass `out`.

            `info` has, (batch,) int32 each, `env_id`, `lives`, `frame_number`, `episode_frame_number`, with
            Gymnasium's masks (`_lives`, ...). In SAME_STEP, when an episode has ended, it also has `final_obs`, zero
            where nothing ended, `final_info` and their masks. A lost life that `life_loss_info` reports ends no
            episode: the observation is its last one, and its row of `final_obs` is zero. With `game_info`, `info` also
            has `reward` (int32, not clipped), `elapsed_step` (int32, the steps of the game) and `terminated` (bool,
            whether the game is over). When a whole game has ended, with all its lives, `episode` has the arrays `r`
            (float64, the sum of the game's rewards, not clipped), `l` (int64, its frames, no-ops included) and `t`
            (float64, seconds), and a mask (added). In SAME_STEP, a game that the step ended is in
            `final_info["episode"]`, and one that ended inside the reset in `episode`. Masks, and in batches of all
            environments `env_id`, are read-only.

            With several players, actions are integers (batch, players); rewards (float64), terminations, truncations,
            and `lives` and the scores `r` of `info` are (batch, players). All players see one observation. A player
            whose lives are negative is out: terminated in this and all later steps, with reward 0, while the others
            play on. The episode ends for all players at once, when the game is over or all are out (added).

        Raises:
            gymnasium.error.ResetNeeded: before the first reset, or after an error in an environment.
            TypeError, ValueError: the actions are not in the action space, or `out` or `env_id` does not fit; nothing
                is played.
            IndexError: a number in `env_id` has no environment; nothing is played.
        """
        with self._lock:
            engine = self._open()
            self._send(engine, actions, out, env_id)
            return self._receive(engine)

    def play(
        self, actions: Any, *, discount: float = 1.0, stop: bool = True, every: bool = False, env_id: Any = None
    ) -> tuple[Any, Any, Any, Any, dict[str, Any]]:
        """Play several steps of all environments, or of some, in one call (added).

        The threads play each environment's steps one after another, with the results, to the byte, of as many calls of
        `step`. Images are drawn only for the steps that the returned observations contain.

        An environment stops after the step that ends its episode, if `stop` is true: in NEXT_STEP its next step begins
        an episode, in SAME_STEP it has already begun one, and `info` has the final observation, and in DISABLED it
        waits for a reset. An environment whose episode had ended before begins one by its first step, as in `step`; in
        DISABLED it plays nothing.

        Args:
            actions: integers (rows, steps), with `continuous` floats (rows, steps, 3), with several players integers
                (rows, steps, players).
            discount: the factor of a step's reward from one step to the next; the k-th reward, counted from 0, counts
                discount**k.
            stop: False goes on after an end, as calls of `step` do, until all steps are played.
            every: return the results of every step, not of the last one.
            env_id: the environments that play, as in `step`.

        Returns:
            The values that `step` returns, with these differences: rewards, float64 (rows,), or (rows, players), are
            the discounted sums of the steps' rewards; observations, terminations, truncations and `info` are those of
            the last step played. `info` also has `steps`, int32 (rows,), the number of steps played, and `ram`, uint8
            (rows, 128), the RAM after the last one.

            With `every`, all arrays but `steps` have a second axis of the steps: rewards, as `step` returns them, are
            (rows, steps), observations (rows, steps, ...), and `info["ram"]` (rows, steps, 128). Steps that were not
            played are zeros, and masks such as `info["_lives"]` are false there.

        Raises:
            gymnasium.error.ResetNeeded, AlreadyPendingCallError: see `step` and `send`.
            TypeError, ValueError, IndexError: an argument is of the wrong kind, shape or range; `discount` is given
                with `every`; batches are smaller than the number of environments. Nothing is played.

        Example:
            >>> import atari, numpy as np
            >>> envs = atari.AtariVectorEnv("breakout", 4, preset="dqn2015")
            >>> observations, info = envs.reset(seed=0)
            >>> plans = np.random.default_rng(0).integers(4, size=(4, 50))
            >>> observations, rewards, terminations, truncations, info = envs.play(plans)
            >>> observations.shape, rewards.shape, info["steps"].tolist()
            ((4, 4, 84, 84), (4,), [50, 50, 43, 50])
        """
        discount = check_probability("discount", discount)
        stop, every = check_bool("stop", stop), check_bool("every", every)
        if every and discount != 1.0:
            raise ValueError(f"every=True returns each step's reward, and no sum: leave discount={discount} out")
        with self._lock:
            engine = self._open()
            self._check_idle()
            if self.batch_size != self.num_envs:
                raise ValueError("play needs batches of all environments (batch_size=0), not batch_size < num_envs")
            chosen = None if env_id is None else _check_env_id(env_id, None)
            rows = self.num_envs if chosen is None else len(chosen)
            indices, strengths, steps = self._options.moves_of_sequences(actions, rows)
            results = SequenceResults(engine, self._options, steps) if every else self._take_buffer(engine, None)
            sequence = engine.play(indices, strengths, results.batch, chosen, steps, discount, stop, every)
            self._sent(results, chosen)
            batch = self._receive(engine)
        sums, played, ram = sequence.results if chosen is None else indexed(sequence.results, chosen)
        observations, rewards, *ends, info = with_played(batch, played, ram, every=every)
        if not every:
            rewards = zero_sum(sums) if self.task.zero_sum else sums
        return observations, rewards, *ends, info

    def send(self, actions: Any, out: Any = None, env_id: Any = None) -> None:
        """Begin a step; `recv` returns its results. Arguments and errors are those of `step`.

        With one thread the environments are played in `recv`.

        Raises:
            gymnasium.error.AlreadyPendingCallError: the last step has not been received.
        """
        with self._lock:
            self._send(self._open(), actions, out, env_id)

    def _send(self, engine: _emulator.VectorEngine, actions: Any, out: Any, env_id: Any) -> None:
        self._check_idle()
        chosen = None if env_id is None else _check_env_id(env_id, out)
        indices, strengths = self._options.moves(actions, None if chosen is None else len(chosen))
        self._start(engine, indices, strengths, out, chosen)

    def _check_idle(self) -> None:
        if self._phase == "new":
            if self._engine is None:  # A signal handler has closed the engine after `_open`.
                raise _closed()
            raise gymnasium.error.ResetNeeded("call reset() before the first step, and after an error in one")
        if self._is_sent():
            raise gymnasium.error.AlreadyPendingCallError("call recv() before the next send()", "send")

    def _start(
        self, engine: _emulator.VectorEngine, indices: IntArray, strengths: Any, out: Any, chosen: Any = None
    ) -> None:
        results = self._take_buffer(engine, out)
        all_together = self.batch_size == self.num_envs
        engine.start(indices, strengths, results.batch if all_together else None, chosen)
        self._sent(results, chosen if all_together else None)

    def _sent(self, results: Results, chosen: IntArray | None) -> None:
        results.of_reset = False
        self._flying, self._chosen = results, chosen
        self._phase = "sent"

    def _is_sent(self) -> bool:
        if self._phase == "sent" and not self._open().sent:  # A compiled function has received the step.
            self._phase = "idle"
        return self._phase == "sent"

    def recv(self) -> tuple[Any, Any, Any, Any, dict[str, Any]]:
        """Wait for a batch of results, as `step` returns them.

        Raises:
            gymnasium.error.NoAsyncCallError: nothing has been sent.
        """
        with self._lock:
            engine = self._open()
            if not self._is_sent():
                raise gymnasium.error.NoAsyncCallError("call send() before recv()", "recv")
            return self._receive(engine)

    def _receive(self, engine: _emulator.VectorEngine) -> tuple[Any, Any, Any, Any, dict[str, Any]]:
        results = self._flying
        if results is None:
            raise _closed()
        self._phase = "new"  # stays if an environment has failed
        try:
            ended = engine.receive(results.batch)
        except RuntimeError:
            if self._engine is None:  # A signal handler's `close` received the step after this method read `_flying`.
                raise _closed() from None
            raise
        self._phase = "idle"
        batch = results.read(self._masks, ended)
        if "episode" in batch[4] and adds_episode(self):
            del batch[4]["episode"], batch[4]["_episode"]
        return batch if self._chosen is None else pick_rows(batch, self._chosen)

    def observe(self) -> tuple[Any, dict[str, Any]]:
        """The present observations and info in `reset`'s form, for example after `restore`; nothing is played."""
        none = np.zeros(self.num_envs, np.bool_)
        return self.reset(options={"reset_mask": none})

    def ram(self, env_id: IntArray | None = None, *, of: Literal["now", "result", "final"] = "now") -> ByteArray:
        """The RAM of all environments, (num_envs, 128) uint8, or of those in `env_id`, (rows, 128); a copy (added).

        With of="result" it is the RAM of the last results, despite later writes and restores, and is read faster. With
        of="final" it is the RAM of the final observation if an episode has ended in SAME_STEP.

        Raises:
            RuntimeError: environments are being played (between `send` and `recv`).
            TypeError, ValueError, IndexError: `env_id` is not integers (rows,), or has a number without an environment.
        """
        chosen = np.arange(self.num_envs, dtype=np.int64) if env_id is None else _check_env_id(env_id, None)
        rams = np.empty((len(chosen), 128), np.uint8)
        with self._lock:
            self._open().copy_rams(chosen, rams, _RAM_OF[check_name("of", of, _RAM_OF)])
        return rams

    @property
    def options(self) -> VectorOptions:
        """The checked options (added)."""
        return self._options

    @property
    def autoreset_mode(self) -> AutoresetMode:
        """The way in which environments that are done begin again."""
        return self._options.autoreset_mode

    @property
    def continuous(self) -> bool:
        """Whether actions are (radius, angle, fire)."""
        return self._options.task.continuous

    @property
    def continuous_action_threshold(self) -> float:
        """The least deflection of the stick, or pressure on fire, that counts."""
        return float(np.float32(self._options.task.continuous_action_threshold))

    @property
    def grayscale(self) -> bool:
        """Whether images are gray, not RGB."""
        return self.task.kind.is_gray

    @property
    def lanes(self) -> tuple[Lane, ...]:
        """The environments one by one: their counters, RAM, mode and difficulty."""
        self._open()
        return tuple(Lane(self, index) for index in range(self.num_envs))

    def call(self, name: str, *args: Any, **kwargs: Any) -> tuple[Any, ...]:
        """The attribute of this name of each lane, or the result of calling it with these arguments."""
        values = [getattr(lane, name) for lane in self.lanes]
        return tuple(value(*args, **kwargs) if callable(value) else value for value in values)

    def get_attr(self, name: str) -> tuple[Any, ...]:
        """The attribute of this name of each lane."""
        return self.call(name)

    def set_attr(self, name: str, values: Any) -> None:
        """Set an attribute of each lane, to one value or to a list or tuple with a value for each.

        Raises:
            AttributeError: the lanes have no attribute of this name that can be set.
            TypeError, ValueError: a value is of the wrong kind or out of range; nothing has been set.
        """
        if not isinstance(values, (list, tuple)):
            values = [values] * self.num_envs
        if len(values) != self.num_envs:
            raise ValueError(f"there must be a value for each of the {self.num_envs} environments, got {len(values)}")
        if name not in ("mode", "difficulty"):
            raise AttributeError(f"'mode' and 'difficulty' can be set, {name!r} cannot")
        checked = [lane.checked(name, value) for lane, value in zip(self.lanes, values, strict=True)]
        for lane, value in zip(self.lanes, checked, strict=True):
            setattr(lane, name, value)

    def close_extras(self, **kwargs: Any) -> None:
        """Join the threads and release the environments, after the calls of other threads.

        As in ale-py, a later `reset` continues with all generators.
        """
        if self._process != os.getpid() or sys.is_finalizing():
            self._release()
            # In a forked process, a thread that no longer exists may hold the lock.
            self._process, self._lock = os.getpid(), _emulator.CallLock("vector environment")
            return
        with self._lock:
            if self._engine is not None:
                self._keep_states(self._engine)
            self._release()

    def _release(self) -> None:
        self._engine = self._port = None
        self._phase = "new"
        self._flying = self._out_results = None
        self._buffers = []
        self._singles = {}

    def _open(self) -> _emulator.VectorEngine:
        if self._engine is None:
            raise _closed()
        return self._engine

    def _take_buffer(self, engine: _emulator.VectorEngine, out: Any) -> Results:
        if out is not None:
            if not self._options.layout.is_engines:
                given = self._options.layout.given()
                raise ValueError(f"out is filled as the engine writes: leave out= or {given} out")
            if self._out_results is None or self._out_results.lent():
                self._out_results = Results(engine, self._options, out)
            else:
                self._out_results.aim(out)
            return self._out_results
        if not (buffers := self._buffers):  # A signal handler may close the environment during a step.
            raise _closed()
        older, newer = buffers
        if not older.lent():
            older, newer = newer, older
        elif newer.lent():
            older, newer = newer, Results(engine, self._options)
        self._buffers = [older, newer]
        return newer

    @property
    def started(self) -> bool:
        """Whether the environments were reset, and none has failed since then (added)."""
        return self._phase != "new"

    def reset_mask(self, options: dict[str, Any] | None) -> npt.NDArray[np.bool_]:
        """The environments that a `reset` with these options resets, (num_envs,) bool (added).

        Raises:
            TypeError, ValueError: the mask among the options is of the wrong kind or length.
        """
        mask = _dict(options).get("reset_mask")
        if mask is None:
            return np.ones(self.num_envs, np.bool_)
        if not isinstance(mask, np.ndarray) or mask.dtype != np.bool_:
            raise TypeError(f"reset_mask must be a boolean numpy array ({self.num_envs},), got {mask!r}")
        if mask.shape != (self.num_envs,):
            raise ValueError(f"reset_mask must have shape ({self.num_envs},), got {mask.shape}")
        if self.batch_size != self.num_envs:
            raise ValueError("reset_mask needs batches of all environments (batch_size=0), not batch_size < num_envs")
        if self._phase == "new" and not mask.all():
            raise FirstResetNeeded("the first reset() must reset every environment, without reset_mask")
        return np.ascontiguousarray(mask)


def is_vector(env: Any) -> bool:
    """Whether `env` is a vector environment, in any wrappers."""
    return isinstance(env, VectorEnv) or isinstance(getattr(env, "unwrapped", None), AtariVectorEnv)


def vector_of(envs: Any, num_envs: int | None, options: Mapping[str, Any], **defaults: Any) -> Any:
    """A vector environment: `envs` if it is one, else a new one of a game.

    Args:
        envs: a vector environment, or a game for `AtariVectorEnv`.
        num_envs, options: arguments of `AtariVectorEnv`, for a game.
        defaults: options of a game that are not given.

    Raises:
        TypeError, ValueError: see `AtariVectorEnv`; or an option is given for an existing vector.
    """
    if not hasattr(envs, "single_action_space"):
        return AtariVectorEnv(envs, num_envs, **{**defaults, **options})
    given = {**options, **({} if num_envs is None else {"num_envs": num_envs})}
    if given:
        raise TypeError(f"{next(iter(given))} is an option of new environments, and these exist; leave it out")
    return envs


def _dict(options: Any) -> Mapping[str, Any]:
    """The options of a reset; {} if there are none."""
    if options is not None and not isinstance(options, Mapping):
        raise TypeError(f"the options of a reset are a dict, got {options!r}")
    given = options or {}
    check_known("reset", [str(name) for name in given if name not in _RESET_OPTIONS], _RESET_OPTIONS)
    return given


def _closed() -> gymnasium.error.ClosedEnvironmentError:
    return gymnasium.error.ClosedEnvironmentError("this vector environment is closed; call reset() to go on")


def _check_env_id(env_id: Any, out: Any) -> IntArray:
    """The numbers of environments, (rows,) int64; the engine checks that they exist."""
    array = np.asarray(env_id)
    if array.dtype.kind not in "iu" and array.size:
        raise TypeError(f"env_id must be integers of shape (rows,), got {array.dtype}")
    if array.ndim != 1:
        raise ValueError(f"env_id must have the shape (rows,), got {array.shape}")
    if out is not None:
        raise ValueError("out is for the observations of a whole batch; leave it or env_id out")
    return np.array(array, np.int64)

"""`EnvState`: the state of an `AtariEnv`, its snapshots and pickles."""

import copy
import time
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, Literal, get_args

import gymnasium

from atari.cores import ByteArray, Core, snapshot, writes
from atari.cores.ale_interface import AleSettings
from atari.cores.ale_random import AleRandom
from atari.games.game import Game
from atari.task import Task
from atari.task.fields import GROUPS
from atari.task.storage import identity, require_same

Phase = Literal["new", "playing", "over", "warned"]


@dataclass(slots=True)
class Played:
    """The score and the counters of a game since the emulator's reset."""

    score: float = 0.0
    steps: int = 0  # counted by wrappers, for which a step is several frames
    first_frame: int = 0  # the episode frame number after the reset
    began: float = field(default_factory=time.perf_counter)
    rewards: int = 0  # other than zero; counted again from a restored snapshot

    def statistics(self, core: Core) -> dict[str, Any]:
        """The sum of the rewards, the frames and the seconds of the game, as `RecordEpisodeStatistics` names them."""
        seconds = round(time.perf_counter() - self.began, 6)
        return {"r": self.score, "l": core.episode_frame_number - self.first_frame, "t": seconds}


class EnvState(gymnasium.Env[Any, Any]):
    """The methods of `AtariEnv` that save and restore it."""

    core: Core
    """The emulator core."""

    game: Game

    whole_task: Task
    """The task played together with the wrappers that `atari.make` has put around this; `task` also has what was set
    since."""

    ale_settings: AleSettings
    """The settings of `ale`, as `ale.setFloat` and the other setters change them."""

    _task: Task  # what is played without wrappers, as it was made
    _phase: Phase
    _game: Played
    _ended_game: dict[str, Any] | None  # until `GameStatistics` takes it
    _restored: bool  # since the last reset, without the wrappers
    _ale_random: AleRandom | None  # of episodes that are seeded as by ale-py's vector environment
    _core_options: dict[str, Any]
    _frames: list[ByteArray]
    _begin: Any
    _made_with: dict[str, Any]  # the arguments of `_begin`
    _make_core: Any
    make_sound: Any

    @property
    def task(self) -> Task:
        """The task played with the wrappers that `atari.make` has put around this, and with what `ale` has set."""
        return self._as_set(self.whole_task)

    def _as_set(self, task: Task) -> Task:
        """A task with what `ale` has set since."""
        own, settings = self._task, self._core_options
        fields = {
            "repeat_action_probability": settings["repeat_action_probability"],
            "max_num_frames_per_episode": settings["max_num_frames_per_episode"] or None,
            "mode": self.core.mode,
            "difficulty": self.core.difficulty,
        }
        return task.with_set(**{name: value for name, value in fields.items() if value != getattr(own, name)})

    def clone_state(self, include_rng: bool = False) -> Any:
        """The emulator's state, in memory; like ale-py's, it leaves out the framebuffer. `snapshot` is complete."""
        return self.core.clone_state(include_rng=include_rng)

    def restore_state(self, state: Any) -> None:
        """Continue from a state that `clone_state` returned.

        Raises:
            TypeError, ValueError: not such a state, or of another game or kind of core.
        """
        self.core.restore_state(state)
        self._phase = "playing"
        self._restored = True

    def snapshot(self) -> bytes:
        """The whole environment as portable bytes: task, game, framebuffer, sound, held action, all generators.

        An environment of the same task, also in another process, continues from it exactly. What wrappers remember,
        such as stacked frames, is in the `snapshot` of the wrappers of `atari.wrappers`. The writes of `Freeze` and
        `Poke` belong to an environment, and not to its snapshots.
        """
        facts = {
            "of": "AtariEnv",
            "phase": self._phase,
            "np_random": self.np_random.bit_generator.state,
            "game": [self._game.score, self._game.steps, self._game.first_frame],
            "task": identity(self._as_set(self._task)),
        }
        more_facts, more_blobs = self._ale_seeding()
        return snapshot.pack(facts | more_facts, {"core": self.core.snapshot(), **more_blobs})

    def restore(self, data: bytes) -> None:
        """Continue from a snapshot of the same task; only the kind of observations may be another one.

        `data` may also be the content of a file that F5 in `atari play` has saved. Its game, mode and difficulty must
        be those of this environment, which keeps its own sticky actions, sound and limit of frames.

        Wrappers are not restored; a wrapper of `atari.wrappers` that has a state warns at its next step. Call `restore`
        of the outermost wrapper instead, with what its `snapshot` returned.

        Raises:
            TypeError, ValueError: not a snapshot, damaged, or of another task or core; the message says each field
                that differs. The environment is as it was.
        """
        facts, blobs = snapshot.unpack(data)
        if facts.get("of") == "play":
            facts, blobs = self._of_play(blobs)
        facts.setdefault("seeding", "gymnasium")
        own, own_blobs = self._ale_seeding()
        snapshot.require(facts, {"of": "AtariEnv", "seeding": own.get("seeding", "gymnasium")})
        require_same(facts.get("task"), self._as_set(self._task), leave_out=GROUPS["observation"])
        if facts.get("task") is not None:
            blobs = {**blobs, "core": self._as_made(blobs.get("core", b""))}
        self._continue(facts, blobs, own_blobs)

    def _as_made(self, data: bytes) -> bytes:
        """A core's snapshot as if its core was made with this environment's mode and difficulty, which `ale` may have
        set there."""
        facts, blobs = snapshot.unpack(data)
        made = {"mode": self._task.set_mode, "difficulty": self._task.set_difficulty}
        return data if facts.items() >= made.items() else snapshot.pack({**facts, **made}, blobs)

    def _continue(self, facts: Mapping[str, Any], blobs: Mapping[str, bytes], own_blobs: Mapping[str, bytes]) -> None:
        """Continue from the facts and blobs of a snapshot of the same task."""
        snapshot.require_blobs(blobs, "core", *own_blobs)
        phase: Any = facts.get("phase")
        if phase not in get_args(Phase):
            raise ValueError(f"the snapshot is damaged: its phase is none of {', '.join(get_args(Phase))}")
        generator = self.np_random.bit_generator
        state = snapshot.check_generator(facts.get("np_random"), type(generator))
        game = _read_game(facts.get("game", [0.0, 0, 0]))
        ale_random = AleRandom.of_state(blobs["ale_random"]) if own_blobs else None
        self.core.restore(blobs["core"])
        generator.state = state
        self._ale_random = ale_random
        self._phase = phase
        self._game, self._ended_game = game, None
        self._restored = True
        self._frames.clear()

    def _of_play(self, blobs: Mapping[str, bytes]) -> tuple[dict[str, Any], dict[str, bytes]]:
        """The facts and blobs of the snapshot in a state of `atari play`, with the options of this environment."""
        facts, blobs = snapshot.unpack(blobs.get("env", b""))
        own, _ = snapshot.unpack(self.core.snapshot())
        options = {name: own[name] for name in ("sound", "repeat_action_probability", "max_num_frames_per_episode")}
        more_facts, more_blobs = self._ale_seeding()
        core = snapshot.with_options(blobs.get("core", b""), **options)
        return {**facts, "task": None, **more_facts}, {**blobs, "core": core, **more_blobs}

    def _ale_seeding(self) -> tuple[dict[str, Any], dict[str, bytes]]:
        """The fact and the blob of a snapshot that say how episodes are seeded; none where they are as Gymnasium's."""
        if self._ale_random is None:
            return {}, {}
        return {"seeding": "ale"}, {"ale_random": self._ale_random.state()}

    def __getstate__(self) -> dict[str, Any]:
        """Pickling and copying keep the position in the game, and the writes of `Freeze` and `Poke`."""
        return {
            "made_with": self._made_with,
            "whole_task": self.whole_task,
            "ale_settings": copy.deepcopy(self.ale_settings),
            "core_options": self._core_options,
            "sound": self.core.sound,
            "mode": self.core.mode,
            "difficulty": self.core.difficulty,
            "spec": copy.deepcopy(self.spec),
            "restored": self._restored,
            "ale_random": self._ale_random,
            "writes": writes.definitions(slots(self.core)),
            "np_random_seed": self._np_random_seed,
            "snapshot": self.snapshot(),
        }

    def __setstate__(self, state: dict[str, Any]) -> None:
        self._begin(**state["made_with"])
        self.whole_task = state["whole_task"]
        self.ale_settings = state["ale_settings"]
        if self._core_options != state["core_options"]:
            self._core_options = state["core_options"]
            self.core = self._make_core()
        if state["sound"]:
            self.make_sound()
        if state["mode"] != self.core.mode:
            self.core.set_mode(state["mode"])
        if state["difficulty"] != self.core.difficulty:
            self.core.set_difficulty(state["difficulty"])
        if writes.definitions(slots(self.core)) != state["writes"]:
            self.core.writes = writes.writes_of(self.game, state["writes"])  # type: ignore[attr-defined]
        self._ale_random = state["ale_random"]
        self._continue(*snapshot.unpack(state["snapshot"]), self._ale_seeding()[1])
        self._np_random_seed = state["np_random_seed"]
        self._restored = state["restored"]
        self.spec = state["spec"]


def slots(core: Core) -> list[Any]:
    """The writes of a core by slot; ale-py's has none."""
    return getattr(core, "writes", [])


def _read_game(values: Any) -> Played:
    """The counts of a game in a snapshot.

    Raises:
        ValueError: they are none.
    """
    if not (isinstance(values, list) and [type(value) for value in values] == [float, int, int]):
        raise ValueError(f"the snapshot is damaged: a game's score, steps and first frame cannot be {values!r}")
    return Played(*values)

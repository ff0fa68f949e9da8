"""`RecordVectorVideo`: videos of one environment of a vector, or of all in a mosaic.

An `AtariVectorEnv` plays its games in C++ and returns only the last frame of a frame skip. So each recorded environment
has a `ShadowCore`: a second core that starts from the same state and gets the same inputs frame by frame, with the same
result to the byte. The frames of a reset (no-ops, FIRE) are not repeated; the video continues with the screen
after the reset.
"""

import math
import os
from collections.abc import Callable, Iterable, Sequence
from operator import attrgetter
from typing import Any

import numpy as np
import numpy.typing as npt
from gymnasium.utils import RecordConstructorArgs

from atari.base.gymnasium_versions import AutoresetMode, VectorWrapper
from atari.base.validation import check_integer
from atari.cores import ByteArray, NativeCore
from atari.env.rendering import tile
from atari.recording.recordable import recorded_vector
from atari.recording.video.record_video_base import RecordVideoBase, Trigger, VideoSettings, make_folder
from atari.recording.video.writer import video_rate
from atari.vector import AtariVectorEnv

Moves = Sequence[tuple[int, float]]
"""The ALE action and its strength in each frame of one environment in one step."""


class ShadowCore:
    """A native core with sound that repeats the frames of environment `index` of a vector.

    `synchronize` before a step copies the environment's state. After the step `moves` returns what the environment's
    console got, and `play` repeats it frame by frame.
    """

    def __init__(self, vector: AtariVectorEnv, index: int) -> None:
        self.index = index
        self._lane = vector.lanes[index]
        options = vector.options
        self.core = NativeCore(
            self._lane.game,
            repeat_action_probability=options.task.repeat_action_probability,  # type: ignore[arg-type]
            max_num_frames_per_episode=options.task.max_num_frames_per_episode or 0,
            sound=True,
            rom=options.rom,
            interventions=options.tasks[index].interventions,
        )
        self.screen: ByteArray = self.core.screen_rgb()
        """The core's current screen, (height, 160, 3) uint8."""
        self.is_new = True
        """Whether the environment has been seeded or reset, which may change its generator alone."""
        self.played: tuple[int, int] | None = None
        """Action and reward of the frame of the last `play`; None if that call played no frame."""
        self._ended = False  # whether the next step plays no action

    def synchronize(self) -> bool:
        """Copy the environment's state if it differs, and return whether the copy is from another episode.

        Equal states are not copied, because the environment has no sound.
        """
        core, lane = self.core, self._lane
        self._ended = lane.ended
        lane.record_moves()
        if not self.is_new and core.frame_number == lane.frame_number and (core.ram() == lane.ram()).all():
            return False
        before = core.episode_frame_number
        lane.copy_to(core)
        self.is_new, self.screen = False, core.screen_rgb()
        return core.episode_frame_number < before

    def moves(self, info: dict[str, Any]) -> Moves:
        """The actions and strengths that the console got in each frame since `synchronize`, in a step with these infos.

        A step that only resets the environment has no frames.
        """
        moves = self._lane.take_moves()
        ended = "_final_info" in info and bool(info["_final_info"][self.index])
        frame = int((info["final_info"] if ended else info)["frame_number"][self.index])
        return moves[: 0 if self._ended else max(0, frame - self.core.frame_number)]

    def play(self, moves: Moves, frame: int) -> None:
        """Play frame number `frame` of a step; after its last frame, do nothing."""
        self.played = None
        if frame < len(moves):
            action, strength = moves[frame]
            reward = self.core.act(action, strength)
            self.played = action, reward
            self.screen = self.core.screen_rgb()


class RecordVectorVideo(RecordVideoBase, VectorWrapper, RecordConstructorArgs):
    """Records videos of an `AtariVectorEnv`: `RecordVideo(envs, video_folder, ...)` makes it, and documents the rest.

    The arguments, the file names and the recorded episodes equal those of `gymnasium.wrappers.vector.RecordVideo`. In a
    mosaic, an environment whose episode ends inside a frame skip shows its last frame until the skip is over.

    Args:
        env: an `AtariVectorEnv` with batches of all environments, in any wrappers.
        video_aspect_ratio: (width, height), the approximate ratio of the mosaic's sides.
        record_first_only: record only environment `index`, instead of a mosaic of all.
        index: the environment whose episodes are counted and whose sound and overlay are recorded.

    Raises:
        TypeError, ValueError, OSError: see `RecordVideo`.
    """

    def __init__(
        self,
        env: Any,
        video_folder: str | os.PathLike[str],
        video_aspect_ratio: tuple[int, int] = (1, 1),
        record_first_only: bool = False,
        episode_trigger: Trigger | None = None,
        step_trigger: Trigger | None = None,
        video_length: int = 0,
        name_prefix: str = "rl-video",
        fps: float | None = None,
        disable_logger: bool = True,
        gc_trigger: Callable[[int], bool] | None = None,
        *,
        index: int = 0,
        format: str = "mp4",
        speed: float = 1,
        scale: int = 2,
        sound: bool = True,
        overlay: tuple[str, ...] | None = None,
        keep: str = "all",
    ) -> None:
        given = {name: value for name, value in locals().items() if name not in ("self", "env", "__class__")}
        RecordConstructorArgs.__init__(self, **given)
        inner = recorded_vector(env, "RecordVideo")
        super().__init__(env)
        self._vector = inner
        self._index = check_integer("index", index, 0, inner.num_envs - 1)
        filmed = [self._index] if record_first_only else list(range(inner.num_envs))
        self._columns = _columns([inner.games[i].screen.shape for i in filmed], video_aspect_ratio)
        game = inner.games[self._index]
        rate = video_rate(game, f".{format}", fps, speed)
        size = tile([np.zeros((*inner.games[i].screen.shape, 3), np.uint8) for i in filmed], self._columns).shape
        self._settings = VideoSettings(format, game, (size[0], size[1]), rate, scale, sound, overlay, keep)
        self._plan(episode_trigger, step_trigger, video_length, name_prefix)
        self.disable_logger, self.gc_trigger = disable_logger, gc_trigger
        self.record_first_only, self.video_aspect_ratio = record_first_only, video_aspect_ratio
        self.video_folder = make_folder(video_folder, name_prefix)
        self._watch()
        self._shadows = [ShadowCore(inner, i) for i in filmed]
        self._sound_shadow = next(shadow for shadow in self._shadows if shadow.index == self._index)
        self._done = np.zeros(inner.num_envs, np.bool_)

    frame_cols = property(attrgetter("_columns"), doc="The columns of the mosaic.")
    frame_rows = property(lambda self: math.ceil(len(self._shadows) / self._columns), doc="The rows of the mosaic.")
    autoreset_mode = property(attrgetter("_vector.autoreset_mode"), doc="The autoreset mode of the environments.")
    render_history: list[Any] = []  # noqa: RUF012 - Gymnasium's, for render modes that a vector does not have

    @property
    def has_autoreset(self) -> bool:
        """Whether the next step begins an episode of environment `index`."""
        return self.autoreset_mode == AutoresetMode.NEXT_STEP and bool(self._done[self._index])

    def _watch(self) -> None:
        inner, index = self._vector, self._index  # the recorder must not refer to this wrapper
        self._make_recorder(lambda: inner.options.tasks[index])

    def reset(self, *, seed: Any = None, options: dict[str, Any] | None = None) -> tuple[Any, dict[str, Any]]:
        """Reset the environments; if environment `index` is among them, its episode ends."""
        self._recorder.raise_deferred_error()
        mask = (options or {}).get("reset_mask")
        chosen = np.ones(self.num_envs, np.bool_) if mask is None else mask
        ends = bool(chosen[self._index])
        if ends:
            self._before_episode()
        result = self.env.reset(seed=seed, options=options)
        self._done = self._done & ~chosen
        for shadow in self._shadows:
            shadow.is_new = shadow.is_new or bool(chosen[shadow.index])
        if ends:
            self.episode_id += 1
            self._record_resets()
        self._count()
        return result

    def step(self, actions: Any) -> tuple[Any, Any, Any, Any, dict[str, Any]]:
        """Play a step of all environments and record their frames."""
        self._recorder.raise_deferred_error()
        mode = self._vector.metadata["autoreset_mode"]
        resets = self._done if mode == AutoresetMode.NEXT_STEP else np.zeros(self.num_envs, np.bool_)
        begins = bool(resets[self._index])
        if begins:
            self._before_episode()
        self._before_step()
        if self.recording:
            self._synchronize(self._shadows)
        result = self.env.step(actions)
        _, _, terminations, truncations, info = result
        self._done = terminations | truncations
        self._record_step(resets, info)
        if mode == AutoresetMode.SAME_STEP and self._done[self._index]:
            begins = True
            self._before_episode()
            self._record_resets()
        self.step_id += 1
        self.episode_id += begins
        self._count()
        return result

    def _record_step(self, resets: npt.NDArray[np.bool_], info: dict[str, Any]) -> None:
        """Repeat the environments' step on the shadow cores and record each frame."""
        if not self.recording:
            return
        steps = [shadow.moves(info) for shadow in self._shadows]
        self._synchronize(shadow for shadow, moves in zip(self._shadows, steps, strict=True) if not moves)
        for frame in range(max(int(resets.any()), *map(len, steps))):
            for shadow, moves in zip(self._shadows, steps, strict=True):
                shadow.play(moves, frame)
            self._write_frame(self._sound_shadow.played)
        self._synchronize(self._shadows)

    def _record_resets(self) -> None:
        """Record one frame of the environments after a reset."""
        if self.recording:
            self._synchronize(self._shadows)
            self._write_frame(None)

    def _write_frame(self, played: tuple[int, int] | None) -> None:
        action, reward = (None, 0) if played is None else played
        image = tile([shadow.screen for shadow in self._shadows], self._columns)
        self._recorder.write_frame(self._sound_shadow.core, action, reward, image)

    def _synchronize(self, shadows: Iterable[ShadowCore]) -> None:
        for shadow in shadows:
            if shadow.synchronize() and shadow is self._sound_shadow:
                self._recorder.begin_game()


def _columns(shapes: Sequence[tuple[int, int]], aspect_ratio: Any) -> int:
    """Return the number of columns whose mosaic of these screens is nearest to the aspect ratio."""
    try:
        wanted = float(aspect_ratio[0]) / float(aspect_ratio[1])
    except (TypeError, IndexError, ValueError, ZeroDivisionError):
        wanted = 0.0
    if not 0.0 < wanted < math.inf:
        raise ValueError(f"video_aspect_ratio is (width, height), two numbers above 0, got {aspect_ratio!r}")
    count, height, width = len(shapes), max(shape[0] for shape in shapes), 2 * shapes[0][1]

    def distance(columns: int) -> float:
        return abs(math.log(columns * width / (math.ceil(count / columns) * height) / wanted))

    return min(range(1, count + 1), key=distance)

"""`ShadowCore`: a core that repeats the actions of one environment of a vector, frame by frame."""

from dataclasses import dataclass
from typing import Any

from atari.cores import ByteArray, NativeCore
from atari.vector import AtariVectorEnv


@dataclass(frozen=True)
class ActionRepeat:
    """The frames of one environment in one step: an ALE action, its strength, and the number of frames."""

    action: int
    strength: float
    frames: int


class ShadowCore:
    """A native core with sound that repeats the frames of environment `index` of a vector.

    `synchronize` before a step copies the environment's state. After the step `action_repeat` returns what the
    environment has played, `play` repeats it frame by frame, and `check` compares the two states.
    """

    def __init__(self, vector: AtariVectorEnv, index: int) -> None:
        self.index = index
        self._lane = vector.lanes[index]
        self._options = vector._options
        self.core = NativeCore(
            self._lane.game,
            repeat_action_probability=self._options.task.repeat_action_probability,  # type: ignore[arg-type]
            max_num_frames_per_episode=self._options.task.max_num_frames_per_episode or 0,
            sound=True,
            rom=self._options.rom,
            interventions=self._options.tasks[index].interventions,
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
        if not self.is_new and core.frame_number == lane.frame_number and (core.ram() == lane.ram()).all():
            return False
        before = core.episode_frame_number
        lane.copy_to(core)
        self.is_new, self.screen = False, core.screen_rgb()
        return core.episode_frame_number < before

    def check(self) -> None:
        """Check after a step that the environment has the same RAM as this core.

        Raises:
            RuntimeError: it differs, because the environment got another action.
        """
        core, lane = self.core, self._lane
        numbers = (core.frame_number, core.episode_frame_number)
        if numbers == (lane.frame_number, lane.episode_frame_number) and (core.ram() != lane.ram()).any():
            raise RuntimeError(
                f"environment {self.index} was given another action than the recorder; put RecordVideo inside the "
                "wrappers that change actions"
            )

    def action_repeat(self, actions: Any, info: dict[str, Any]) -> ActionRepeat:
        """The frames that the environment has played since `synchronize`, in a step with these actions and results.

        A step that only resets the environment has none.

        Args:
            actions: the actions of all environments, as passed to `step`.
            info: the infos that `step` returned.
        """
        indices, strengths = self._options.moves(actions)
        action = int(self._options.actions[self.index][int(indices[self.index])])
        strength = 1.0 if strengths is None else float(strengths[self.index])
        ended = "_final_info" in info and bool(info["_final_info"][self.index])
        frame = int((info["final_info"] if ended else info)["frame_number"][self.index])
        return ActionRepeat(action, strength, 0 if self._ended else max(0, frame - self.core.frame_number))

    def play(self, repeat: ActionRepeat, frame: int) -> None:
        """Play frame number `frame` of an action repeat; after its last frame, do nothing."""
        self.played = None
        if frame < repeat.frames:
            reward = self.core.act(repeat.action, repeat.strength)
            self.played = repeat.action, reward
            self.screen = self.core.screen_rgb()

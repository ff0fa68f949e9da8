"""`ShadowCore`: a core that repeats the inputs of one environment of a vector, frame by frame."""

from collections.abc import Sequence
from typing import Any

from atari.cores import ByteArray, NativeCore
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

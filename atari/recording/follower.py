"""`Follower`: a core that plays along with one environment of a vector, frame by frame."""

from dataclasses import dataclass
from typing import Any

from atari.cores import ByteArray, NativeCore
from atari.vector import AtariVectorEnv


@dataclass(frozen=True)
class Move:
    """What an environment has played in a step: an ALE action, and for how many frames."""

    action: int
    strength: float
    frames: int


class Follower:
    """Follows environment `index` of a vector on a core of its own, which makes sound.

    `catch_up` before a step brings it to where the environment is, `move` after the step says what was played, and
    `play` plays it again.
    """

    def __init__(self, vector: AtariVectorEnv, index: int) -> None:
        self.index = index
        self._member = vector.members[index]
        self._options = vector._options
        self.core = NativeCore(
            self._member.game,
            repeat_action_probability=self._options.protocol.repeat_action_probability,
            max_num_frames_per_episode=self._options.protocol.episode_limit,
            sound=True,
            rom=self._options.rom,
        )
        self.screen: ByteArray = self.core.screen_rgb()
        """What it shows."""
        self.played: tuple[int, int] | None = None
        """The action and the reward of this frame, None if it has not played one."""

    def catch_up(self) -> bool:
        """Go to where the environment is, should it be elsewhere, and return whether that is in another game."""
        core, member = self.core, self._member
        if core.frame_number == member.frame_number and (core.ram() == member.ram()).all():
            return False
        before = core.episode_frame_number
        member.copy_to(core)
        self.screen = core.screen_rgb()
        return core.episode_frame_number < before

    def check(self) -> None:
        """Make sure after a step that the environment has played what this has played.

        Raises:
            RuntimeError: it was given other actions.
        """
        core, member = self.core, self._member
        numbers = (core.frame_number, core.episode_frame_number)
        if numbers == (member.frame_number, member.episode_frame_number) and (core.ram() != member.ram()).any():
            raise RuntimeError(
                f"environment {self.index} was given another action than the recorder; put RecordVectorVideo beneath "
                "the wrappers that change actions"
            )

    def move(self, actions: Any, was_reset: bool, info: dict[str, Any]) -> Move:
        """What the environment has played since `catch_up`, in a step with these actions and results.

        Args:
            actions: of all environments, as given to `step`.
            was_reset: the step was to begin an episode, unless only a life had been told as the end of one.
            info: what `step` returned.
        """
        indices, strengths = self._options.moves(actions)
        action = int(self._options.actions[self.index][int(indices[self.index])])
        strength = 1.0 if strengths is None else float(strengths[self.index])
        ended = "_final_info" in info and bool(info["_final_info"][self.index])
        numbers = info["final_info"] if ended else info
        frame, episode_frame = (int(numbers[name][self.index]) for name in ("frame_number", "episode_frame_number"))
        if was_reset and (not self._options.protocol.life_loss_info or episode_frame < self.core.episode_frame_number):
            return Move(action, strength, 0)
        return Move(action, strength, max(0, frame - self.core.frame_number))

    def play(self, move: Move, frame: int) -> None:
        """Play a frame of a move, if it has so many."""
        self.played = None
        if frame < move.frames:
            reward = self.core.act(move.action, move.strength)
            self.played = move.action, reward
            self.screen = self.core.screen_rgb()

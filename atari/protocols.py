"""`Protocol`: how episodes begin, are played, shown and ended, declared once.

`atari.wrappers.presets` makes wrappers around single environments of a protocol, and `atari.vector.settings` makes the
settings of the vector engine of the same one.
"""

from dataclasses import dataclass
from typing import Literal


@dataclass(frozen=True)
class Protocol:
    """How episodes begin, are played, shown and ended. The defaults are those of ale-py's vector environment.

    Attributes:
        order: in which order the parts below are applied. "ale": as in ale-py's vector environment; "frames": no-ops,
            FIRE and lost lives are wrappers of single frames, inside of the frame skip; "baselines": FIRE and lost
            lives are outside of the frame skip, as in OpenAI's Baselines.
        repeat_action_probability: of sticky actions.
        full_action_space: whether all legal actions are used, not only those that the game uses.
        max_num_frames_per_episode: a limit on all frames of an episode, no-ops included; 0 is none.
        frame_skip: frames for each action, drawn from low..high-1.
        noops: an episode begins with so many no-ops, drawn from low..high; (0, 0) is none.
        fire_counts: whether FIRE is one of the no-ops.
        fire: whether an episode begins with FIRE, before or after the no-ops, in games that have it.
        third_action: whether the action with index 2 follows FIRE; "baselines" only.
        episodic_life: whether a lost life ends the episode.
        life_loss_info: whether a lost life is reported as a termination, without a reset.
        on_reset: what a reset after a lost life does: play a NOOP, continue, or begin a new game.
        last_life: whether losing the last life counts in games that continue after it.
        seamless_lives: a lost life neither cuts a skip short nor clears the stack.
        clip_reward: whether rewards are clipped to -1..1.
        max_frames: a limit on the frames of an episode after its no-ops; None is none.
        end_frames: what is observed when an episode ends inside a skip; see `DqnPreprocessing`.
        padding: what fills the stack at the start of an episode: "zero", or "reset", the first frame.
        max_pool: whether the last two frames of a skip are pooled.
        pool_rgb: whether colours are pooled, and then made gray.

    Example:
        >>> from dataclasses import replace
        >>> import atari
        >>> from atari.wrappers import PRESETS
        >>> protocol = replace(PRESETS["dopamine"].protocol, frame_skip=(3, 4))
        >>> envs = atari.AtariVectorEnv("breakout", 8, preset=protocol)
        >>> envs.reset(seed=0)[0].shape
        (8, 4, 84, 84)
        >>> envs.close()
    """

    order: Literal["ale", "frames", "baselines"] = "ale"
    repeat_action_probability: float = 0.0
    full_action_space: bool = False
    max_num_frames_per_episode: int = 0
    frame_skip: tuple[int, int] = (4, 5)
    noops: tuple[int, int] = (0, 29)
    fire_counts: bool = True
    fire: Literal["never", "before_noops", "after_noops"] = "before_noops"
    third_action: bool = False
    episodic_life: bool = False
    life_loss_info: bool = False
    on_reset: Literal["noop", "continue", "new_game"] = "new_game"
    last_life: bool = False
    seamless_lives: bool = False
    clip_reward: bool = True
    max_frames: int | None = None
    end_frames: Literal["last", "gymnasium", "baselines", "envpool"] = "gymnasium"
    padding: Literal["zero", "reset"] = "zero"
    max_pool: bool = True
    pool_rgb: bool = False

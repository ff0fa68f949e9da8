"""`TaskOptions`: the options of a task with their types, for editors and type checkers. `Task` describes each."""

from collections.abc import Mapping, Sequence
from typing import Any, TypedDict

from atari.actions import Action
from atari.games.interventions import Intervention
from atari.task.fields import EndFrames, Fire, OnReset, Padding, Seeding, Unit
from atari.task.kinds import ObsType

Interventions = Sequence[str | Mapping[str, Any] | Intervention] | None


# Begin of what scripts/generate/options.py writes.
class AddedOptions(TypedDict, total=False):
    """The options that `AtariEnv` does not name."""

    players: int | None
    actions: str | Sequence[str | Action] | None
    noops: tuple[int, int]
    fire: Fire
    fire_counts: bool
    third_action: bool
    fire_unit: Unit
    fire_again: bool
    seeding: Seeding
    episodic_life: bool | None
    lives_unit: Unit
    on_reset: OnReset
    last_life: bool
    seamless_lives: bool
    life_loss_info: bool
    max_frames: int | None
    max_episode_steps: int | None
    img_height: int | None
    img_width: int | None
    stack_num: int | None
    maxpool: bool
    pool_rgb: bool
    padding: Padding
    end_frames: EndFrames
    agent_indicator: bool
    reward: str | None
    reward_clipping: bool | None
    zero_sum: bool
    clip_reward: bool | None


class _Shared(AddedOptions, total=False):
    """The options that have one type in all functions."""

    continuous: bool
    continuous_action_threshold: float
    repeat_action_probability: float | tuple[float, ...] | None
    frameskip: int | tuple[int, int]
    interventions: Interventions
    max_num_frames_per_episode: int | None
    obs_type: ObsType | None
    sound_obs: bool
    full_action_space: bool | None


# End of what scripts/generate/options.py writes.


class TaskOptions(_Shared, total=False):
    """The options of `Task.of`."""

    mode: int | None
    difficulty: int | None


class VectorTaskOptions(_Shared, total=False):
    """The options of a task by `AtariVectorEnv`: modes and difficulties may be lists, and ale-py's names are added."""

    mode: int | Sequence[int | None] | None
    difficulty: int | Sequence[int | None] | None
    noop_max: int | None
    use_fire_reset: bool | None
    grayscale: bool | None


class MakeOptions(TaskOptions, total=False):
    """The options of `atari.make`: the options of a task, of an environment and of `gymnasium.make`."""

    render_mode: str | None
    core: str
    rom: Any
    disable_env_checker: bool | None

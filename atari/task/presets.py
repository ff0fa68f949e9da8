"""`PRESETS`: the preprocessing of well-known implementations and protocols. A preset is a task without its game.

All presets follow Mnih et al. 2015; "multiplayer_dqn" is for games of several players. They differ in the no-ops, in
FIRE, in the effect of a lost life, in the pooling of frames, and in the observation when an episode ends inside a skip.
Such details change scores.
"""

import difflib
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from atari.base.frozen import FrozenDict


@dataclass(frozen=True)
class Preset:
    """The preprocessing of an implementation or of a publication.

    Attributes:
        source: the implementation or the publication.
        fields: fields of `Task` with their values. The game, or a task, decides the others.
        required: the names in `fields` that no option may change.

    Example:
        >>> import atari
        >>> preset = atari.PRESETS["dopamine"]
        >>> preset.fields["repeat_action_probability"], preset.fields["reward_clipping"], "noops" in preset.fields
        (0.25, True, False)
    """

    source: str
    fields: Mapping[str, Any]
    required: tuple[str, ...] = ()


_MAX_FRAMES = 108_000  # half an hour of play


def _preset(source: str, required: tuple[str, ...] = (), **fields: Any) -> Preset:
    """A preset of stacks of four pooled gray images of 84 x 84, with four frames for each action."""
    images = {"obs_type": "grayscale", "img_height": 84, "img_width": 84, "stack_num": 4, "maxpool": True}
    return Preset(source, FrozenDict({"frameskip": 4, **images, **fields}), required)


_PLAY = ("repeat_action_probability", "actions")

PRESETS: Mapping[str, Preset] = FrozenDict(
    {
        "dqn2015": _preset(
            "Mnih et al. 2015, and its code, alewrap: RGB pooled, then luminance, averaged to 84x84",
            required=_PLAY,
            repeat_action_probability=0.0,
            actions="minimal",
            max_num_frames_per_episode=_MAX_FRAMES,
            noops=(1, 30),
            episodic_life=True,
            on_reset="continue",
            last_life=True,
            pool_rgb=True,
            padding="zero",
            end_frames="last",
            reward_clipping=True,
        ),
        "machado2018": _preset(
            "Machado et al. 2018, with the 4 frames a step and 108,000 frames that later users of it take",
            required=_PLAY,
            repeat_action_probability=0.25,
            actions="full",
            max_num_frames_per_episode=_MAX_FRAMES,
            episodic_life=False,
            on_reset="continue",
            last_life=True,
            padding="zero",
            end_frames="last",
            reward_clipping=False,
        ),
        "baselines": _preset(
            "Stable-Baselines3 2: AtariWrapper, VecFrameStack(4); after OpenAI's Baselines",
            repeat_action_probability=0.0,
            max_num_frames_per_episode=_MAX_FRAMES,
            noops=(1, 30),
            fire="after_noops",
            third_action=True,
            fire_unit="skip",
            episodic_life=True,
            lives_unit="skip",
            on_reset="noop",
            pool_rgb=True,
            padding="zero",
            end_frames="baselines",
            reward_clipping=True,
        ),
        "gymnasium": _preset(
            "Gymnasium 1: AtariPreprocessing, FrameStackObservation(4)",
            noops=(1, 30),
            episodic_life=False,
            on_reset="new_game",
            last_life=True,
            padding="reset",
            end_frames="gymnasium",
            reward_clipping=False,
        ),
        "dopamine": _preset(
            "Dopamine 4: AtariPreprocessing, with the stack, the clipping and the 27,000 steps of its runner",
            required=_PLAY,
            repeat_action_probability=0.25,
            actions="minimal",
            max_num_frames_per_episode=_MAX_FRAMES,
            episodic_life=False,
            on_reset="continue",
            last_life=True,
            padding="zero",
            end_frames="baselines",
            reward_clipping=True,
        ),
        "atari100k": _preset(
            "the Atari 100k benchmark as in Dopamine's data-efficient Rainbow",
            required=_PLAY,
            repeat_action_probability=0.0,
            actions="minimal",
            max_num_frames_per_episode=_MAX_FRAMES,
            episodic_life=True,
            on_reset="continue",
            last_life=True,
            padding="zero",
            end_frames="last",
            reward_clipping=True,
        ),
        "envpool": _preset(
            "EnvPool 1.2, its Atari environments with their defaults",
            repeat_action_probability=0.0,
            max_num_frames_per_episode=None,
            noops=(1, 30),
            fire="after_noops",
            fire_counts=True,
            episodic_life=False,
            on_reset="continue",
            seamless_lives=True,
            max_frames=_MAX_FRAMES,
            padding="reset",
            end_frames="envpool",
            reward_clipping=False,
        ),
        "ale_vector": _preset(
            "ale-py 0.12, its AtariVectorEnv with one environment and its defaults",
            repeat_action_probability=0.0,
            max_num_frames_per_episode=None,
            noops=(0, 29),
            fire="before_noops",
            fire_counts=True,
            episodic_life=False,
            on_reset="new_game",
            max_frames=_MAX_FRAMES,
            padding="zero",
            end_frames="gymnasium",
            reward_clipping=True,
        ),
        "multiplayer_dqn": _preset(
            "SuperSuit's wrappers for PettingZoo's Atari environments, in the order of their documentation",
            repeat_action_probability=0.0,
            max_num_frames_per_episode=None,
            seeding="ale",
            episodic_life=False,
            on_reset="continue",
            last_life=True,
            max_frames=_MAX_FRAMES,
            padding="reset",
            end_frames="last",
            reward_clipping=False,
        ),
    }
)
"""Every preset by name."""

# Other projects' names of a preset or an evaluation protocol, for the suggestion in an error.
OTHER_NAMES = {
    "nature": "dqn2015",
    "mnih": "dqn2015",
    "machado": "machado2018",
    "sticky": "machado2018",
    "openai": "baselines",
    "cleanrl": "baselines",
    "sb3": "baselines",
    "zoo": "baselines",
    "deepmind": "baselines",
    "rainbow": "dopamine",
    "iqn": "dopamine",
    "100k": "atari100k",
    "spr": "atari100k",
    "ale": "ale_vector",
    "dqn": "dqn2015",
}


def find_preset(name: Any) -> Preset:
    """The preset of a name.

    Raises:
        ValueError: there is no such preset; the message suggests the nearest.
    """
    if isinstance(name, str) and name in PRESETS:
        return PRESETS[name]
    wanted = str(name).lower()
    known = next((preset for other, preset in OTHER_NAMES.items() if other in wanted), None)
    near = [known] if known else difflib.get_close_matches(wanted, PRESETS, n=1)
    hint = f"did you mean {near[0]!r}?" if near else "see the list"
    if wanted == "dqn":
        hint += " Several players have 'multiplayer_dqn'"
    raise ValueError(f"there is no preset {name!r}; {hint} ({', '.join(PRESETS)})")

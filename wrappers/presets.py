"""The preprocessing of well-known implementations and protocols, by name.

All presets follow Mnih et al. 2015. They differ in the no-ops, in FIRE, in the effect of a lost life, in the pooling of
frames, and in the observation when an episode ends inside a skip. Such details change scores. The table `PRESETS` has
them.
"""

import difflib
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from types import MappingProxyType
from typing import Any

import gymnasium

from atari.protocols import Protocol
from atari.validation import check_clip_reward
from atari.wrappers._checks import Environment, require_atari
from atari.wrappers._game_statistics import GameStatistics
from atari.wrappers.clip_reward import ClipReward
from atari.wrappers.dqn_preprocessing import DqnPreprocessing
from atari.wrappers.episodic_life import EpisodicLife
from atari.wrappers.fire_reset import FireReset
from atari.wrappers.frame_stack import FrameStack
from atari.wrappers.noop_reset import NoopReset

Layer = tuple[type[gymnasium.Wrapper[Any, Any, Any, Any]], Mapping[str, Any]]


@dataclass(frozen=True)
class Preset:
    """The preprocessing of an implementation or of a publication.

    `options` are the options of `AtariEnv` that go with it; those in `required` must have these values. `protocol` is
    the rest.

    Example:
        >>> from atari.wrappers import PRESETS
        >>> preset = PRESETS["dopamine"]
        >>> preset.options["repeat_action_probability"], preset.clip_reward, preset.protocol.noops
        (0.25, True, (0, 0))
    """

    source: str
    options: Mapping[str, Any]
    protocol: Protocol
    required: tuple[str, ...] = ()

    @property
    def episodic_life(self) -> bool:
        """Whether a lost life ends the episode, unless the user chooses."""
        return self.protocol.episodic_life

    @property
    def clip_reward(self) -> bool:
        """Whether rewards are clipped, unless the user chooses."""
        return self.protocol.clip_reward


_MAX_FRAMES = 108_000  # half an hour of play


def _frames(**parts: Any) -> Protocol:
    """A protocol of order "frames", which has no-ops and FIRE only if `parts` has them."""
    return Protocol(**{"order": "frames", "noops": (0, 0), "fire_counts": False, "fire": "never", **parts})


PRESETS: Mapping[str, Preset] = MappingProxyType(
    {
        "dqn2015": Preset(
            source="Mnih et al. 2015, and its code, alewrap: RGB pooled, then luminance, averaged to 84x84",
            options={
                "frameskip": 1,
                "repeat_action_probability": 0.0,
                "full_action_space": False,
                "max_num_frames_per_episode": _MAX_FRAMES,
            },
            required=("repeat_action_probability", "full_action_space"),
            protocol=_frames(
                noops=(1, 30),
                episodic_life=True,
                on_reset="continue",
                last_life=True,
                pool_rgb=True,
                padding="zero",
                end_frames="last",
                clip_reward=True,
            ),
        ),
        "machado2018": Preset(
            source="Machado et al. 2018, with the 4 frames a step and 108,000 frames that later users of it take",
            options={
                "frameskip": 1,
                "repeat_action_probability": 0.25,
                "full_action_space": True,
                "max_num_frames_per_episode": _MAX_FRAMES,
            },
            required=("repeat_action_probability", "full_action_space"),
            protocol=_frames(
                episodic_life=False,
                on_reset="continue",
                last_life=True,
                padding="zero",
                end_frames="last",
                clip_reward=False,
            ),
        ),
        "baselines": Preset(
            source="Stable-Baselines3 2: AtariWrapper, VecFrameStack(4); after OpenAI's Baselines",
            options={"frameskip": 1, "repeat_action_probability": 0.0, "max_num_frames_per_episode": _MAX_FRAMES},
            protocol=Protocol(
                order="baselines",
                noops=(1, 30),
                fire_counts=False,
                fire="after_noops",
                third_action=True,
                episodic_life=True,
                on_reset="noop",
                pool_rgb=True,
                padding="zero",
                end_frames="baselines",
                clip_reward=True,
            ),
        ),
        "gymnasium": Preset(
            source="Gymnasium 1: AtariPreprocessing, FrameStackObservation(4)",
            options={"frameskip": 1},
            protocol=_frames(
                noops=(1, 30),
                episodic_life=False,
                on_reset="new_game",
                last_life=True,
                padding="reset",
                end_frames="gymnasium",
                clip_reward=False,
            ),
        ),
        "dopamine": Preset(
            source="Dopamine 4: AtariPreprocessing, with the stack, the clipping and the 27,000 steps of its runner",
            options={
                "frameskip": 1,
                "repeat_action_probability": 0.25,
                "full_action_space": False,
                "max_num_frames_per_episode": _MAX_FRAMES,
            },
            required=("repeat_action_probability", "full_action_space"),
            protocol=_frames(
                episodic_life=False,
                on_reset="continue",
                last_life=True,
                padding="zero",
                end_frames="baselines",
                clip_reward=True,
            ),
        ),
        "atari100k": Preset(
            source="the Atari 100k benchmark as in Dopamine's data-efficient Rainbow",
            options={
                "frameskip": 1,
                "repeat_action_probability": 0.0,
                "full_action_space": False,
                "max_num_frames_per_episode": _MAX_FRAMES,
            },
            required=("repeat_action_probability", "full_action_space"),
            protocol=_frames(
                episodic_life=True,
                on_reset="continue",
                last_life=True,
                padding="zero",
                end_frames="last",
                clip_reward=True,
            ),
        ),
        "envpool": Preset(
            source="EnvPool 1.2, its Atari environments with their defaults",
            options={"frameskip": 1, "repeat_action_probability": 0.0, "max_num_frames_per_episode": None},
            protocol=_frames(
                noops=(1, 30),
                fire_counts=True,
                fire="after_noops",
                episodic_life=False,
                on_reset="continue",
                seamless_lives=True,
                max_frames=_MAX_FRAMES,
                padding="reset",
                end_frames="envpool",
                clip_reward=False,
            ),
        ),
        "ale_vector": Preset(
            source="ale-py 0.12, its AtariVectorEnv with one environment and its defaults",
            options={"frameskip": 1, "repeat_action_probability": 0.0, "max_num_frames_per_episode": None},
            protocol=_frames(
                noops=(0, 29),
                fire_counts=True,
                fire="before_noops",
                episodic_life=False,
                on_reset="new_game",
                max_frames=_MAX_FRAMES,
                padding="zero",
                end_frames="gymnasium",
                clip_reward=True,
            ),
        ),
    }
)
"""Every preset by name."""


def preset(
    env: Environment,
    name: str,
    *,
    episodic_life: bool | None = None,
    clip_reward: bool | None = None,
    reward_clipping: bool | None = None,
) -> Environment:
    """Put the preprocessing of an implementation or a protocol around an `AtariEnv`.

    Observations are (4, 84, 84) uint8, the oldest image first; actions are played for 4 frames.

    ============= ============= ============= ============ ============= ===== ======= ===================
    name          no-ops        FIRE          lost life    gray          clip  padding end inside a skip
    ============= ============= ============= ============ ============= ===== ======= ===================
    dqn2015       1-30          no            continues    of pooled RGB yes   zero    last frame
    machado2018   no            no            (continues)  ALE's         no    zero    last frame
    baselines     1-30          after, and 2  a NOOP step  of pooled RGB yes   zero    as Baselines
    gymnasium     1-30          no            (new game)   ALE's         no    first   previous frames
    dopamine      no            no            (continues)  ALE's         yes   zero    as Baselines
    atari100k     no            no            continues    ALE's         yes   zero    last frame
    envpool       1-30, FIRE in after         (continues)  ALE's         no    first   as EnvPool
    ale_vector    0-29, FIRE in before        (new game)   ALE's         yes   zero    previous frames
    ============= ============= ============= ============ ============= ===== ======= ===================

    "lost life" is what the reset after a lost life does. In brackets: by default a lost life does not end the episode.
    "clip" is clipping the reward to -1..1.

    baselines, gymnasium, dopamine, envpool and ale_vector give the same bytes as these implementations, from the same
    start (`reset(options={"noops": n})` chooses one) and with the same seeds of sticky actions, but in two corners: if
    FIRE at the start ends an episode, Stable-Baselines3 shows that end and this the start of the next; and EnvPool
    calls a game over in the last step of its limit a truncation. The other three are protocols; no one program defines
    them, and they are built from the publications (`PRESETS[name].source`).

    `info` has what `AtariEnv` gives, and of the whole game, lost lives do not matter:

    - "reward", a float: the step's reward before clipping;
    - "elapsed_step", an int: the agent's steps in this game; "episode_frame_number" are its frames;
    - "terminated", a bool: whether the game is over;
    - "episode", when the game has ended, over or truncated, in this step or inside this reset: what
      `RecordEpisodeStatistics` and Stable-Baselines3's `Monitor` record directly around the `AtariEnv`. "r" is the sum
      of all rewards, not clipped, no-ops and FIRE included; "l" the emulated frames since the emulator's reset; "t" the
      seconds since then. So neither is needed around a preset, and Gymnasium's refuses to write "episode" again: leave
      it out, or give it another `stats_key`.

    Args:
        env: made with the options `preset_options(name)`: `frameskip=1` always, and, where a protocol prescribes them,
            its sticky actions and its action set.
        name: one of the names above.
        episodic_life: whether a lost life ends the episode; None is as the implementation does by default. For
            evaluation: False, or True for an agent that never presses FIRE, which games such as Breakout wait for
            after each lost life; the environment warns if a game seems to wait.
        clip_reward: whether rewards are clipped; None is as the implementation does by default. For evaluation: False.
        reward_clipping: another name of `clip_reward`, that of ale-py's vector environment.

    Raises:
        TypeError: `env` is no `AtariEnv`, or both names of an option are given.
        ValueError: there is no such preset (the nearest is suggested), or the environment does not fit; the text says
            how to make it.

    Example:
        >>> import atari
        >>> from atari.wrappers import preset, preset_options
        >>> env = preset(atari.AtariEnv("breakout", **preset_options("dopamine")), "dopamine")
        >>> observation, info = env.reset(seed=0)
        >>> observation.shape, observation.dtype
        ((4, 84, 84), dtype('uint8'))
        >>> observation, reward, terminated, truncated, info = env.step(1)
        >>> info["elapsed_step"], info["lives"]
        (1, 5)
    """
    clips = check_clip_reward(clip_reward, reward_clipping)
    _require_options(env, name)
    return wrap(env, preset_protocol(name, episodic_life=episodic_life, clip_reward=clips))


def wrap(env: Environment, protocol: Protocol) -> Environment:
    """Put the wrappers of a protocol of 4 frames a step around an `AtariEnv`, which must have its other options.

    Raises:
        ValueError: the protocol plays another number of frames.
    """
    if protocol.frame_skip != (4, 5) or protocol.order == "ale":
        raise ValueError("single environments play protocols of 4 frames a step, in another order than 'ale'")
    for wrapper, arguments in _layers(protocol):
        env = wrapper(env, **arguments)
    return env


def preset_protocol(
    name: str,
    *,
    episodic_life: bool | None = None,
    clip_reward: bool | None = None,
    repeat_action_probability: float | None = None,
    full_action_space: bool | None = None,
) -> Protocol:
    """The protocol of a preset with the options of its environment. None is what the preset has.

    Raises:
        ValueError: there is no such preset (the nearest is suggested), or it requires another option than the given.
    """
    chosen = _find(name)
    given: dict[str, Any] = {
        "repeat_action_probability": repeat_action_probability,
        "full_action_space": full_action_space,
    }
    given = {option: value for option, value in given.items() if value is not None}
    for option, value in given.items():
        if option in chosen.required and value != chosen.options[option]:
            raise ValueError(f"preset {name!r} needs {option}={chosen.options[option]!r}, got {value!r}; leave it out")
    options = {"repeat_action_probability": 0.25, "full_action_space": False, **chosen.options, **given}
    return replace(
        chosen.protocol,
        repeat_action_probability=options["repeat_action_probability"],
        full_action_space=options["full_action_space"],
        max_num_frames_per_episode=options.get("max_num_frames_per_episode") or 0,
        episodic_life=chosen.episodic_life if episodic_life is None else episodic_life,
        clip_reward=chosen.clip_reward if clip_reward is None else clip_reward,
    )


def _layers(protocol: Protocol) -> Iterator[Layer]:
    """The wrappers of a protocol and their arguments, from the inside out."""
    lives: list[Layer] = []
    if protocol.episodic_life:
        lives = [(EpisodicLife, {"on_reset": protocol.on_reset, "last_life": protocol.last_life})]
    fire: list[Layer] = [(FireReset, {"then_action_2": protocol.third_action})] if protocol.fire != "never" else []
    low, high = protocol.noops
    noops: list[Layer] = []
    if high > 0:
        noops = [(NoopReset, {"noop_max": high, "noop_min": low, "fire_counts": protocol.fire_counts})]
    dqn = {
        "pool_rgb": protocol.pool_rgb,
        "end_frames": protocol.end_frames,
        "seamless_lives": protocol.seamless_lives,
        "max_frames": protocol.max_frames,
    }
    if protocol.order == "baselines":  # FireReset plays whole skips there, which NoopReset does not
        yield from noops
        yield DqnPreprocessing, {**dqn, "stack_size": None}
        yield from lives + fire
        yield FrameStack, {"stack_size": 4, "padding_type": protocol.padding}
    else:
        yield from lives
        yield from fire + noops if protocol.fire == "before_noops" else noops + fire
        yield DqnPreprocessing, {**dqn, "padding_type": protocol.padding}
    yield GameStatistics, {}
    if protocol.clip_reward:
        yield ClipReward, {}


# What users of other projects call a preset or a protocol of evaluation, for the suggestion in an error.
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


def preset_options(name: str) -> dict[str, Any]:
    """The options of `AtariEnv` with which to make an environment for a preset.

    Raises:
        ValueError: there is no such preset; the nearest is suggested.

    Example:
        >>> from atari.wrappers import preset_options
        >>> preset_options("dopamine")["repeat_action_probability"]
        0.25
    """
    return dict(_find(name).options)


def _find(name: Any) -> Preset:
    if name in PRESETS:
        return PRESETS[name]
    wanted = str(name).lower()
    known = next((preset for other, preset in OTHER_NAMES.items() if other in wanted), None)
    near = [known] if known else difflib.get_close_matches(wanted, PRESETS, n=1)
    hint = f"did you mean {near[0]!r}?" if near else "see the list"
    raise ValueError(f"there is no preset {name!r}; {hint} ({', '.join(PRESETS)})")


def _require_options(env: Environment, name: str) -> None:
    atari = require_atari(env, f"preset {name!r}")
    chosen = _find(name)
    wanted_actions = "legal_actions" if chosen.options.get("full_action_space") else "minimal_actions"
    fits = {
        "frameskip": atari._frameskip == 1,
        "repeat_action_probability": atari._options["repeat_action_probability"]
        == chosen.options.get("repeat_action_probability"),
        # The set counts, not the option: in some games both sets are the same.
        "full_action_space": atari._action_set == getattr(atari.game, wanted_actions),
    }
    for option in ("frameskip", *chosen.required):
        if not fits[option]:
            arguments = ", ".join(f"{key}={value!r}" for key, value in chosen.options.items())
            raise ValueError(
                f"preset {name!r} needs an environment made with {option}={chosen.options[option]!r}, and this one has "
                f"{atari._options[option]!r}; make it with atari.AtariEnv({atari.game.id!r}, {arguments})"
            )

"""`preset`: the wrappers of a preset of `atari.PRESETS`, around an `AtariEnv`.

All presets follow Mnih et al. 2015. They differ in the no-ops, in FIRE, in the effect of a lost life, in the pooling of
frames, and in the observation when an episode ends inside a skip. Such details change scores.
"""

from typing import Any

from atari.env import AtariEnv
from atari.task.presets import find_preset
from atari.task.task import FoundGame
from atari.wrappers._checks import Environment, require_atari
from atari.wrappers.layers import wrap


def preset(
    env: Environment,
    name: str,
    *,
    episodic_life: bool | None = None,
    clip_reward: bool | None = None,
    reward_clipping: bool | None = None,
) -> Environment:
    """Put the preprocessing of an implementation or an evaluation protocol around an `AtariEnv`.

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

    "lost life" is the effect of the reset after one. In brackets: by default a lost life does not end the episode.
    "clip" says whether the reward is clipped to -1..1.

    baselines, gymnasium, dopamine, envpool and ale_vector give the same bytes as these implementations, from the same
    start (`reset(options={"noops": n})` chooses one) and with the same seeds of sticky actions. Tests compare each in
    six or seven games, EnvPool in games of 210 lines, as its screens have. There are two exceptions. If FIRE at the
    start ends an episode, Stable-Baselines3 returns that end, this preset the start of the next. EnvPool calls a game
    over in the last step of its limit a truncation. The other three are protocols: no one program defines them, and
    they follow the publications (`PRESETS[name].source`).

    `info` has the items of `AtariEnv`, and the following about the whole game, despite lost lives:

    - "reward", a float: the step's reward before clipping;
    - "elapsed_step", an int: the agent's steps in this game; "episode_frame_number" are its frames;
    - "terminated", a bool: whether the game is over;
    - "episode", when the game has ended, over or truncated, in this step or inside this reset: the record of
      `RecordEpisodeStatistics` and of Stable-Baselines3's `Monitor` directly around the `AtariEnv`. "r" is the sum of
      all rewards, not clipped, no-ops and FIRE included; "l" the emulated frames since the emulator's reset; "t" the
      seconds since then. So neither is needed around a preset. Around one, `RecordEpisodeStatistics` records what it
      sees, clipped rewards and single lives, and "episode" of a step is its record, not the game's.

    Args:
        env: made with the options `preset_options(name)`: always `frameskip=1`, and, if an evaluation protocol
            prescribes them, its sticky actions and its action set.
        name: one of the names above.
        episodic_life: whether a lost life ends the episode; None means the implementation's default. For evaluation use
            False, or True for an agent that never presses FIRE: games such as Breakout wait for it after each lost
            life. The environment warns if a game seems to wait.
        clip_reward: whether rewards are clipped; None means the implementation's default. For evaluation use False.
        reward_clipping: another name of `clip_reward`, used by ale-py's vector environment.

    Raises:
        TypeError: `env` is no `AtariEnv`, or both names of an option are given.
        ValueError: there is no such preset (the message suggests the nearest), or the environment does not fit; the
            message says how to make it.

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
    given = {"episodic_life": episodic_life, "clip_reward": clip_reward, "reward_clipping": reward_clipping}
    given = {option: value for option, value in given.items() if value is not None}
    atari = require_atari(env, f"preset {name!r}")
    _require_options(atari, name)
    own = atari.task
    played = {option: getattr(own, option) for option in _OF_EMULATOR}
    task = FoundGame(own).task(name, {**played, **given}, owner="preset")
    env = wrap(env, task)
    atari.whole_task = task
    return env


_OF_EMULATOR = ("repeat_action_probability", "actions", "max_num_frames_per_episode")
"""Fields of presets that an `AtariEnv` honours."""


def preset_options(name: str) -> dict[str, Any]:
    """The options of `AtariEnv` with which to make an environment for a preset.

    Raises:
        ValueError: there is no such preset; the message suggests the nearest.

    Example:
        >>> from atari.wrappers import preset_options
        >>> preset_options("dopamine")["repeat_action_probability"]
        0.25
    """
    fields = find_preset(name).fields
    options = {"frameskip": 1, **{option: fields[option] for option in _OF_EMULATOR if option in fields}}
    return {
        "full_action_space" if option == "actions" else option: value == "full" if option == "actions" else value
        for option, value in options.items()
    }


def _require_options(atari: AtariEnv, name: str) -> None:
    chosen, wanted = find_preset(name), preset_options(name)
    minimal, full = atari.game.minimal_actions, atari.game.legal_actions
    fits = {
        "frameskip": atari.task.frameskip == 1,
        "repeat_action_probability": atari.task.repeat_action_probability == wanted.get("repeat_action_probability"),
        # The set is compared, not the option: in some games both sets are the same.
        "full_action_space": atari.task.action_set == (full if wanted.get("full_action_space") else minimal),
    }
    required = ("full_action_space" if option == "actions" else option for option in chosen.required)
    for option in ("frameskip", *required):
        if not fits[option]:
            arguments = ", ".join(f"{key}={value!r}" for key, value in wanted.items())
            raise ValueError(
                f"preset {name!r} needs an environment made with {option}={wanted[option]!r}, and this one has "
                f"{atari.ale_options()[option]!r}; make it with atari.AtariEnv({atari.game.id!r}, {arguments})"
            )

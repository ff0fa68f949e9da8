"""How an episode is begun, played and shown, for the engine of the vector environment: by ale-py's options, or by a
preset, whose wrappers `atari.wrappers.PRESETS` lists."""

from dataclasses import dataclass
from typing import Any, Literal

from atari.game import Game

NEVER = 2**31 - 1


@dataclass(frozen=True)
class Protocol:
    """What the engine is told; the names are those of the wrappers' arguments."""

    protocol: Literal["ale", "frames", "baselines"] = "ale"
    seeds: Literal["ale", "gymnasium"] = "ale"
    repeat_action_probability: float = 0.0
    full_action_space: bool = False
    episode_limit: int = 0
    frame_skip: tuple[int, int] = (4, 5)
    noops: tuple[int, int] = (0, 29)
    fire_counts: bool = True
    fire: Literal["never", "before", "after"] = "before"
    episodic_life: bool = False
    life_loss_info: bool = False
    on_reset: str = "new_game"
    last_life: bool = False
    seamless_lives: bool = False
    clip_reward: bool = True
    max_frames: int = NEVER
    end_frames: str = "gymnasium"
    pads_zero: bool = True
    max_pool: bool = True
    pool_rgb: bool = False


def of_preset(
    name: str,
    *,
    episodic_life: bool | None,
    clip_reward: bool | None,
    repeat_action_probability: float | None,
    full_action_space: bool | None,
) -> Protocol:
    """The protocol of a preset, put together from its wrappers. None is as the preset has it.

    Raises:
        ValueError: there is no such preset, or it prescribes something else than what is asked for.
    """
    from atari import wrappers  # here, because it takes OpenCV along

    options = wrappers.preset_options(name)
    chosen = wrappers.PRESETS[name]
    layers: dict[Any, dict[str, Any]] = {layer: dict(arguments) for layer, arguments in chosen.layers}
    order = list(layers)
    asked = {"repeat_action_probability": repeat_action_probability, "full_action_space": full_action_space}
    for option, value in asked.items():
        if value is not None and option in chosen.required and value != options[option]:
            raise ValueError(f"preset {name!r} needs {option}={options[option]!r}, got {value!r}; leave it out")
    given = {option: value for option, value in asked.items() if value is not None}
    options = {"repeat_action_probability": 0.25, "full_action_space": False, **options, **given}
    life = layers.get(wrappers.EpisodicLife, {})
    noops = layers.get(wrappers.NoopReset, {})
    dqn = layers[wrappers.DqnPreprocessing]
    fire: Literal["never", "before", "after"] = "never"
    if wrappers.FireReset in layers:
        after = order.index(wrappers.FireReset) > order.index(wrappers.NoopReset)
        fire = "after" if after else "before"
    outside = order.index(wrappers.EpisodicLife) > order.index(wrappers.DqnPreprocessing)
    padding = layers.get(wrappers.FrameStack, dqn).get("padding_type", "reset")
    return Protocol(
        protocol="baselines" if outside else "frames",
        seeds="gymnasium",
        repeat_action_probability=options["repeat_action_probability"],
        full_action_space=options["full_action_space"],
        episode_limit=options.get("max_num_frames_per_episode") or 0,
        noops=(noops.get("noop_min", 1) if noops else 0, noops.get("noop_max", 30) if noops else 0),
        fire_counts=noops.get("fire_counts", False),
        fire=fire,
        episodic_life=chosen.episodic_life if episodic_life is None else episodic_life,
        on_reset=life.get("on_reset", "noop"),
        last_life=life.get("last_life", False),
        seamless_lives=dqn.get("seamless_lives", False),
        clip_reward=chosen.clip_reward if clip_reward is None else clip_reward,
        max_frames=dqn.get("max_frames") or NEVER,
        end_frames=dqn.get("end_frames", "last"),
        pads_zero=padding == "zero",
        pool_rgb=dqn.get("pool_rgb", False),
    )


def gray_of_pairs(game: Game) -> bytes:
    """For `pool_rgb`: the gray value of the maximum of two colours, by their palette indices, 256 x 256."""
    from atari.wrappers._rgb_pool import gray_of_pairs

    return gray_of_pairs(game.screen.format).tobytes()

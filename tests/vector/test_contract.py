"""`AtariVectorEnv` in all its kinds, and vectors around it, keep the contract of `atari.testing.check_vector`."""

from functools import partial
from typing import Any

import gymnasium
import pytest
from env_tools import needs_gymnasium_1

import atari
from atari.base.gymnasium_versions import AutoresetMode
from atari.lab import RamLabels
from atari.testing import check_vector

SHORT: dict[str, Any] = {"max_episode_steps": 10}
check = partial(check_vector, steps=24)

KINDS: dict[str, tuple[Any, dict[str, Any]]] = {
    "RGB, drawn skips, sticky": (
        "pong",
        {"obs_type": "rgb", "stack_num": 2, "maxpool": False, "frameskip": (2, 5), "repeat_action_probability": 0.25},
    ),
    "float32, channels last": ("pong", {"dtype": "float32", "channels_last": True}),
    "dict": ("pong", {"obs_type": "dict"}),
    "continuous": ("pong", {"continuous": True}),
    "lost lives, channels last": (
        "breakout",
        {
            "episodic_life": True,
            "use_fire_reset": True,
            "channels_last": True,
            "frameskip": 16,
            "max_episode_steps": 20,
        },
    ),
    "several games": (["pong", "breakout"], {}),
    "two players": ("pong", {"players": 2}),
    "a preset of players": ("pong", {"preset": "multiplayer_dqn", "players": 2}),
    "one thread": ("pong", {"num_threads": 1}),
    "a reward of its own": (
        "breakout",
        {"reward": "reward - 5 * lives_lost + 0.1 * player_x", "reward_clipping": False},
    ),
}


@pytest.fixture(params=[mode.value for mode in AutoresetMode])
def mode(request: pytest.FixtureRequest) -> str:
    return str(request.param)


@pytest.mark.parametrize("kind", KINDS)
def test_kinds_of_vectors(kind: str, mode: str) -> None:
    game, options = KINDS[kind]
    check(lambda: atari.AtariVectorEnv(game, 2, autoreset_mode=mode, **{**SHORT, **options}))


@pytest.mark.parametrize("preset", [name for name in atari.PRESETS if name != "multiplayer_dqn"])
def test_every_preset_plays_as_single_environments(preset: str, mode: str) -> None:
    options = {"preset": preset, **SHORT}
    check(
        lambda: atari.AtariVectorEnv("ALE/Breakout-v5", 2, autoreset_mode=mode, **options),
        single=lambda: atari.make("ALE/Breakout-v5", **options),
    )


@pytest.mark.parametrize("env_id", ["ALE/Pong-v5", "Pong-ramDeterministic-v4", "SeaquestNoFrameskip-v4"])
def test_ids_play_as_single_environments(env_id: str, mode: str) -> None:
    check(
        lambda: atari.AtariVectorEnv(env_id, 3, autoreset_mode=mode, **SHORT),
        single=lambda: atari.make(env_id, **SHORT),
    )


@needs_gymnasium_1  # 0.29 cannot make "sync" vectors of environments with wrappers
def test_ids_by_gymnasium() -> None:
    for how in ("sync", "vector_entry_point"):
        make = partial(gymnasium.make_vec, "ALE/Pong-v5", 2, how, obs_type="ram", **SHORT)
        check(make, copies=False, atomic=how != "sync")


def test_wrappers_of_vectors(mode: str) -> None:
    wrappers = pytest.importorskip("gymnasium.wrappers.vector", reason="added in Gymnasium 1.0")
    envs = partial(atari.AtariVectorEnv, "pong", 2, autoreset_mode=mode, **SHORT)
    check(lambda: RamLabels(envs()), copies=False)
    check(lambda: wrappers.RecordEpisodeStatistics(envs()), copies=False)

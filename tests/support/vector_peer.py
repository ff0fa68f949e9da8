"""Compares a vector environment with ale-py's of the same name: same options, seeds and actions, and every array."""

from typing import Any

import ale_py
import numpy as np

import atari
from atari.base.gymnasium_versions import AutoresetMode

ale_py.ALEInterface.setLoggerMode(ale_py.LoggerMode.Error)

NUMBERS = ("env_id", "lives", "frame_number", "episode_frame_number")


def compare(game: str, steps: int, seed: int = 0, num_envs: int = 2, **options: Any) -> int:
    """Assert equality for some steps of random actions; returns the number of episodes that ended."""
    theirs = ale_py.AtariVectorEnv(game, num_envs, num_threads=1, **options)
    ours = atari.AtariVectorEnv(game, num_envs, num_threads=1, **options)
    assert ours.single_action_space == theirs.single_action_space
    assert ours.single_observation_space == theirs.single_observation_space
    assert ours.action_space == theirs.action_space
    assert ours.observation_space == theirs.observation_space
    where = f"{game} {options} seed {seed}"
    observations, infos = zip(*(envs.reset(seed=seed) for envs in (ours, theirs)), strict=True)
    same("observation", *observations, f"{where} reset")
    for name in NUMBERS:
        same(name, infos[0][name], infos[1][name], f"{where} reset")
    generator = np.random.default_rng(seed)
    ended = 0
    for step in range(steps):
        actions = choose(generator, ours, num_envs)
        tag = f"{where} step {step}"
        results = [envs.step(actions) for envs in (ours, theirs)]
        for name, index in (("observation", 0), ("reward", 1), ("terminated", 2), ("truncated", 3)):
            same(name, results[0][index], results[1][index], tag)
        mine, other = results[0][4], results[1][4]
        for name in NUMBERS:
            same(name, mine[name], other[name], tag)
        assert ("final_obs" in mine) == ("final_obs" in other), tag
        if "final_obs" in mine:
            rows = mine["_final_obs"]
            same("final_obs", mine["final_obs"][rows], other["final_obs"][rows], tag)
            assert not mine["final_obs"][~rows].any(), tag
        ended += int((results[0][2] | results[0][3]).sum())
    ours.close()
    theirs.close()
    return ended


def choose(generator: np.random.Generator, envs: Any, num_envs: int) -> Any:
    """Random actions: indices, or radius, angle and fire."""
    if hasattr(envs.single_action_space, "n"):
        return generator.integers(0, envs.single_action_space.n, num_envs)
    low, high = envs.single_action_space.low, envs.single_action_space.high
    return generator.uniform(low, high, (num_envs, 3)).astype(np.float32)


def same(name: str, mine: Any, other: Any, where: str) -> None:
    """Assert that two arrays are equal in dtype, shape and every value."""
    assert mine.dtype == other.dtype, f"{where}: {name} is {mine.dtype}, ale-py's {other.dtype}"
    assert mine.shape == other.shape, f"{where}: {name} is {mine.shape}, ale-py's {other.shape}"
    assert np.array_equal(mine, other), f"{where}: {name} differs"


def option_sets(count: int, seed: int) -> list[tuple[str, dict[str, Any]]]:
    """Games with random options."""
    generator = np.random.default_rng(seed)
    games = [game.id for game in atari.games.playable() if game.id not in ("skiing", "lost_luggage")]

    def one_of(*values: Any) -> Any:
        return values[generator.integers(len(values))]

    sets = []
    for _ in range(count):
        height, width = one_of(
            (84, 84), (84, 84), (84, 84), (96, 72), (105, 80), (64, 64), (210, 160), (70, 32), (100, 11)
        )
        sets.append(
            (
                games[generator.integers(len(games))],
                _with_effect(
                    {
                        "img_height": height,
                        "img_width": width,
                        "grayscale": one_of(True, True, False),
                        "stack_num": one_of(1, 2, 4, 4, 5),
                        "frameskip": one_of(1, 2, 3, 4, 4, 7),
                        "maxpool": one_of(True, True, False),
                        "noop_max": one_of(0, 1, 7, 30, 30),
                        "episodic_life": one_of(True, False),
                        "life_loss_info": one_of(True, False),
                        "reward_clipping": one_of(True, False),
                        "use_fire_reset": one_of(True, True, False),
                        "max_num_frames_per_episode": one_of(37, 101, 402, 108000),
                        "repeat_action_probability": one_of(0.0, 0.25, 0.5),
                        "full_action_space": one_of(True, False),
                        "continuous": one_of(True, False, False),
                        "continuous_action_threshold": one_of(0.3, 0.5),
                        "autoreset_mode": one_of(AutoresetMode.NEXT_STEP, AutoresetMode.SAME_STEP),
                    }
                ),
            )
        )
    return sets


def _with_effect(options: dict[str, Any]) -> dict[str, Any]:
    """The options that have an effect together: ale-py ignores the others, and ours raises errors for them."""
    without = {
        "continuous_action_threshold": not options["continuous"],
        "life_loss_info": options["episodic_life"],
    }
    return {name: value for name, value in options.items() if not without.get(name, False)}

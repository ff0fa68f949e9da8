"""`RecordReplay` of a vector: the replay equals what the environment played, with every option of the vector."""

import itertools
from pathlib import Path
from typing import Any

import gymnasium
import numpy as np
import pytest
from gymnasium.vector import SyncVectorEnv

import atari
from atari.recording import RecordReplay, Replay

MODES = ["NextStep", "SameStep", "Disabled"]


def play(envs: Any, steps: int, index: int, seed: Any = 3) -> list[np.ndarray[Any, Any]]:
    """Play at random; the RAM of an environment after each step."""
    generator = np.random.default_rng(0)
    count = envs.num_envs
    continuous = isinstance(envs.single_action_space, gymnasium.spaces.Box)
    envs.reset(seed=seed)
    rams = []
    for _ in range(steps):
        if continuous:
            actions: Any = generator.random((count, 3), np.float32) * np.float32([1, 3, 1])
        else:
            actions = generator.integers(0, envs.single_action_space.n, count)
        _, _, terminated, truncated, _ = envs.step(actions)
        rams.append(envs.unwrapped.lanes[index].ram())
        done = terminated | truncated
        if done.any() and envs.metadata["autoreset_mode"].value == "Disabled":
            envs.reset(options={"reset_mask": done})
    return rams


def check(path: Path, rams: list[np.ndarray[Any, Any]], core: str = "ale") -> Replay:
    """The replay verifies, and has the recorded RAM in order."""
    replay = Replay.load(path)
    result = replay.verify(core)
    assert result, result.divergence
    env = replay.make_env()
    states = iter([env.core.ram().tobytes() for _, calls in replay.walk(env.core) for _ in calls])
    for before, after in itertools.pairwise(ram.tobytes() for ram in rams):
        assert before == after or after in states
    return replay


def recorded(path: Path, game: Any, steps: int, index: int = 1, count: int = 2, **options: Any) -> Replay:
    """A replay of an environment of a vector, which has what the environment has played."""
    envs = RecordReplay(atari.AtariVectorEnv(game, count, num_threads=1, **options), path, index=index)
    rams = play(envs, steps, index)
    found, actions = envs.env.unwrapped.games[index], envs.unwrapped.options.actions[index]
    envs.close()
    replay = check(path, rams, "ale" if options.get("autoreset_mode") == "NextStep" else "native")
    assert (replay.game, replay.header["source"]) == (found, "AtariEnv")
    assert len(replay.make_env().driver.actions) == len(actions) or options.get("continuous")
    return replay


GAMES = ["pong", "breakout", "ms_pacman"]
LIFE: dict[str, Any] = {"episodic_life": False, "life_loss_info": True}


@pytest.mark.parametrize("mode", MODES)
@pytest.mark.parametrize(
    ("game", "options"),
    [
        ("breakout", {}),
        ("ms_pacman", {"life_loss_info": True, "repeat_action_probability": 0.25, "frameskip": (2, 5)}),
        ("breakout", {"episodic_life": True, "noop_max": 1, "use_fire_reset": False}),
        ("breakout", {"episodic_life": True, "on_reset": "noop"}),
        ("breakout", {"episodic_life": True, "on_reset": "continue", "lives_unit": "skip"}),
        ("pong", {"max_num_frames_per_episode": 90, "mode": 1, "difficulty": [0, 1, 0]}),
        ("breakout", {"continuous": True}),
        (["pong", "breakout", "seaquest"], {"full_action_space": None}),
        *[("breakout", {"preset": preset, **LIFE}) for preset in (None, "dqn2015", "envpool")],
    ],
)
def test_every_rule_of_ale_py(mode: str, game: Any, options: dict[str, Any], tmp_path: Path) -> None:
    recorded(tmp_path / "a.a26r", game, 110, count=3, autoreset_mode=mode, **options)


@pytest.mark.parametrize(
    ("preset", "game", "index", "mode"),
    [
        *[(name, "breakout", 1, MODES[len(name) % 3]) for name in atari.PRESETS],
        *[(name, GAMES, i, mode) for name in ("dqn2015", "baselines", "ale_vector") for i, mode in enumerate(MODES)],
    ],
)
def test_every_preset(preset: str, game: Any, index: int, mode: str, tmp_path: Path) -> None:
    count = 2 if game == "breakout" else 3
    replay = recorded(tmp_path / "a.a26r", game, 100, index, count, preset=preset, autoreset_mode=mode)
    assert len(replay.make_env().driver.actions) == 18 or game == "breakout"


def test_continuous_actions_of_a_preset(tmp_path: Path) -> None:
    recorded(tmp_path / "a.a26r", "breakout", 60, preset="dqn2015", continuous=True)


def test_new_game_after_a_lost_life(tmp_path: Path) -> None:
    envs: Any = RecordReplay(
        atari.AtariVectorEnv("breakout", 2, preset="baselines", autoreset_mode="Disabled"), tmp_path / "a.a26r"
    )
    envs.reset(seed=0)
    while not envs.unwrapped.lanes[0].ended:
        envs.step(np.array([1, 1]))
    assert envs.unwrapped.lanes[0].lives == 4
    envs.reset(options={"new_game": True})
    assert envs.unwrapped.lanes[0].lives == 5
    envs.close()
    assert len(Replay.load(tmp_path / "a.a26r").episodes) == 2


@pytest.mark.parametrize("seeding", ["ale", "gymnasium"])
def test_the_limit_of_the_emulator_may_end_a_game_in_the_no_ops(seeding: Any, tmp_path: Path) -> None:
    task = atari.Task("breakout", seeding=seeding, noops=(40, 140), max_num_frames_per_episode=90)
    replay = recorded(tmp_path / "a.a26r", task, 60, index=0, count=1)
    assert replay.verify("ale")
    assert replay.options["max_num_frames_per_episode"] == 90
    assert {episode.end for episode in replay.episodes[:-1]} == {"truncated"}


def test_without_a_seed_all_get_random_ones(tmp_path: Path) -> None:
    seeds = set()
    for name in ("a.a26r", "b.a26r"):
        envs = RecordReplay(atari.AtariVectorEnv("seaquest", 2, num_threads=1), tmp_path / name)
        rams = play(envs, 40, 0, seed=None)
        envs.reset()
        envs.close()
        seeds.add(check(tmp_path / name, rams).seeds)
    assert len(seeds) == 2  # not the RAM, which is equal after 40 steps for one pair of seeds in thirty


def test_several_seeds_and_resets(tmp_path: Path) -> None:
    envs = RecordReplay(atari.AtariVectorEnv("pong", 2, num_threads=1), tmp_path / "a.a26r", 1)
    for seed in ([1, 2], None, [5, None], 9):
        play(envs, 10, 1, seed=seed)
    envs.close()
    replay = check(tmp_path / "a.a26r", [])
    assert len(replay.episodes) == 4


def test_results_are_those_of_the_vector(tmp_path: Path) -> None:
    plain = atari.AtariVectorEnv("breakout", 2, num_threads=1)
    envs = RecordReplay(atari.AtariVectorEnv("breakout", 2, num_threads=1), tmp_path / "a.a26r")
    assert np.array_equal(plain.reset(seed=2)[0], envs.reset(seed=2)[0])
    for _ in range(20):
        actions = np.array([3, 1])
        for ours, theirs in zip(envs.step(actions)[:4], plain.step(actions)[:4], strict=True):
            assert np.array_equal(ours, theirs)
    envs.close()


def test_what_is_changed_from_outside_ends_the_recording(tmp_path: Path) -> None:
    envs: Any = RecordReplay(atari.AtariVectorEnv("breakout", 2, num_threads=1), tmp_path / "a.a26r")
    play(envs, 10, 0)
    envs.unwrapped.fork(1, [0])
    with pytest.raises(RuntimeError, match="environment 0 differs from its recording"):
        envs.step(np.array([1, 1]))
    envs.step(np.array([1, 1]))
    envs.close()
    assert Replay.load(tmp_path / "a.a26r").frames_total >= 40


def test_a_vector_that_was_reset_needs_a_seed(tmp_path: Path) -> None:
    vector = atari.AtariVectorEnv("breakout", 2, num_threads=1)
    vector.reset()
    envs = RecordReplay(vector, tmp_path / "a.a26r")
    with pytest.raises(ValueError, match="give this first reset a seed"):
        envs.reset()
    play(envs, 10, 0, seed=4)
    envs.reset()
    envs.close()
    assert Replay.load(tmp_path / "a.a26r").verify("ale")


def test_a_step_before_the_first_reset(tmp_path: Path) -> None:
    envs = RecordReplay(atari.AtariVectorEnv("pong", 2), tmp_path / "a.a26r")
    with pytest.raises(gymnasium.error.ResetNeeded):
        envs.step(np.zeros(2, int))
    envs.close()


def test_single_environments_of_gymnasiums_vectors_are_recorded_by_the_other_wrapper(tmp_path: Path) -> None:
    makers = [lambda i=i: RecordReplay(atari.make("pong"), tmp_path / f"{i}.a26r") for i in range(2)]  # type: ignore[misc]
    envs = SyncVectorEnv(makers)
    envs.reset(seed=0)
    for _ in range(10):
        envs.step(envs.action_space.sample())
    envs.close()
    assert all(Replay.load(tmp_path / f"{i}.a26r").verify() for i in range(2))


def test_a_task_of_ones_own(tmp_path: Path) -> None:
    own = {"noops": (3, 9), "pool_rgb": False, "end_frames": "envpool", "padding": "reset", "frameskip": (2, 5)}
    replay = recorded(tmp_path / "a.a26r", "breakout", 300, preset="baselines", **own)
    assert replay.verify().frames == replay.frames_total > 800

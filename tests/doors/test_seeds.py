"""Seeds have one range, 0..2**32-1, at every door; single environments also take larger ones, as Gymnasium's do.

Environment i of a vector has the seed plus i, also above the range.
"""

import subprocess
import sys
from collections.abc import Callable, Mapping
from contextlib import closing
from dataclasses import replace
from pathlib import Path
from typing import Any

import gymnasium
import numpy as np
import pytest

import atari
import atari.classic as gym
from atari import cores
from atari.integrations import envpool
from atari.lab import causes
from atari.lab.probes import play_episodes
from atari.learning import PROTOCOLS, ReplayMemory, compare, evaluate, record_games
from atari.learning.frame_agent import FrameAgent
from atari.multiplayer import MultiplayerCore, MultiplayerEnv
from atari.play import Session
from atari.recording import RecordReplay

SHORT = replace(PROTOCOLS["dopamine"], max_frames=400)
SEEDS = (2**31 - 1, 2**31, 3_000_000_000, 2**32 - 1)
OUTSIDE = (-1, 2**32)


def single(env: Any, seed: int) -> Any:
    with closing(env):
        env.reset(seed=seed)
        return [np.asarray(env.step(0)[0]).tobytes() for _ in range(3)]


def vector(seed: Any, **options: Any) -> Any:
    with closing(atari.AtariVectorEnv("pong", 3, **options)) as envs:
        envs.reset(seed=seed)
        return envs.ram().tolist()


def core(kind: Any, seed: int) -> Any:
    made = kind("pong", seed=seed)
    made.reset()
    again = kind("pong")
    again.seed(seed)
    again.reset()
    assert again.ram().tolist() == made.ram().tolist()
    return made.ram().tolist()


def pooled(seed: int) -> Any:
    envs = envpool.make_gymnasium("Pong-v5", num_envs=2, seed=seed)
    first = envs.reset()[1]["ram"].tolist()
    envs.seed(seed)
    assert envs.reset()[1]["ram"].tolist() == first
    return first


def classic(seed: int) -> Any:
    env = gym.make("Pong-ram-v0")
    env.seed(seed)
    return env.reset().tolist()


def several(seed: int) -> Any:
    first = MultiplayerEnv("pong", obs_type="ram", seed=seed).reset()[0]["first_0"].tolist()
    assert MultiplayerEnv("pong", obs_type="ram").reset(seed=seed)[0]["first_0"].tolist() == first
    return first


def session(seed: int, **options: Any) -> Any:
    with closing(Session("pong", seed=seed, **options)) as made:
        for _ in range(40):
            made.play(made.legal_actions[0])
        return made.screen.tobytes()


def memory(seed: int) -> Any:
    made = ReplayMemory(50, 1, (4,), seed=seed)
    made.reset(np.zeros((1, 4), np.uint8))
    for _ in range(40):
        made.add(
            np.zeros(1, int), np.zeros(1), np.zeros(1, bool), np.zeros(1, bool), observations=np.zeros((1, 4), "u1")
        )
    return made.sample(16).indices.tolist()


def agent(seed: int) -> Any:
    made, played = FrameAgent("random", seed=seed), cores.NativeCore("pong")
    played.reset()
    made.begin(played, seed)
    return [made.act(played) for _ in range(3)] and seed


def evaluated(seed: int) -> Any:
    return evaluate("noop", "pong", SHORT, episodes=1, seed=seed)["pong"].seeds


def probed(seed: int) -> Any:
    return [episode.ram.tolist() for episode in play_episodes("pong", 60, seed=seed, num_envs=2)]


def replayed(seed: int, folder: Path) -> Any:
    path = folder / f"{seed}.a26"
    with RecordReplay(atari.AtariEnv("pong"), path) as env:
        env.reset(seed=seed)
        env.step(2)
    with RecordReplay(atari.AtariVectorEnv("pong", 2), folder / f"vector-{seed}.a26", index=1) as envs:
        envs.reset(seed=seed)
        envs.step(np.zeros(2, int))
    replays = [atari.recording.Replay.load(folder / name) for name in (path.name, f"vector-{seed}.a26")]
    assert all(replay.verify() for replay in replays)
    return [replay.seeds for replay in replays]


DOORS: Mapping[str, Callable[[int], Any]] = {
    "AtariEnv": lambda seed: single(atari.AtariEnv("pong", obs_type="ram"), seed),
    "make": lambda seed: single(atari.make("pong", preset="baselines"), seed),
    "make, seeding 'ale'": lambda seed: single(atari.make("pong", preset="ale_vector"), seed),
    "gymnasium.make": lambda seed: single(gymnasium.make("Pong-ram-v4"), seed),
    "AtariVectorEnv": lambda seed: vector(seed),
    "AtariVectorEnv, a preset": lambda seed: vector(seed, preset="baselines"),
    "AtariVectorEnv, an array": lambda seed: vector([seed, None, seed - 1], preset="dqn2015"),
    "NativeCore": lambda seed: core(cores.NativeCore, seed),
    "PlainCore": lambda seed: core(cores.PlainCore, seed),
    "AleCore": lambda seed: core(cores.AleCore, seed),
    "MultiplayerCore": lambda seed: core(MultiplayerCore, seed),
    "MultiplayerEnv": several,
    "envpool": pooled,
    "classic": classic,
    "Session": session,
    "Session of several players": lambda seed: session(seed, players=2, policies={1: "random"}),
    "ReplayMemory": memory,
    "FrameAgent": agent,
    "evaluate": evaluated,
    "play_episodes": probed,
    "causes": lambda seed: str(causes("pong", states=2, values=1, frames=2, seed=seed)) and seed,
}
"""By door: a function of a seed that returns what the seed decides."""

REFUSES = (
    "AtariVectorEnv",
    "AtariVectorEnv, a preset",
    "NativeCore",
    "PlainCore",
    "AleCore",
    "MultiplayerCore",
    "ReplayMemory",
    "evaluate",
)
"""Doors that refuse seeds outside of the range. The others take Gymnasium's, EnvPool's, PettingZoo's or Gym's seeds."""


@pytest.mark.parametrize("door", DOORS)
def test_every_seed_of_the_range_is_taken(door: str) -> None:
    results = [DOORS[door](seed) for seed in SEEDS]
    assert all(result != results[0] for result in results[1:])
    assert DOORS[door](SEEDS[-1]) == results[-1]


@pytest.mark.parametrize("door", REFUSES)
@pytest.mark.parametrize("seed", OUTSIDE)
def test_the_range_is_named(door: str, seed: int) -> None:
    with pytest.raises(ValueError, match=rf"seed must be within 0\.\.(2\*\*32-1|4294967295), got {seed}"):
        DOORS[door](seed)


@pytest.mark.parametrize("seed", SEEDS)
def test_a_replay_has_the_seed(seed: int, tmp_path: Path) -> None:
    replayed(seed, tmp_path)


@pytest.mark.parametrize("seed", SEEDS)
def test_environments_of_a_vector_have_the_seeds_that_follow(seed: int) -> None:
    for preset in ("baselines", "ale_vector"):
        envs = vector(seed, preset=preset)
        for index in range(3):
            env = atari.make("pong", preset=preset)
            env.reset(seed=seed + index)
            assert env.unwrapped.core.ram().tolist() == envs[index]


@pytest.mark.parametrize("seed", SEEDS)
def test_compare_and_recorded_games(seed: int, tmp_path: Path) -> None:
    first = evaluate("noop", "pong", SHORT, episodes=1, seed=seed)
    second = evaluate("random", "pong", SHORT, episodes=1, seed=seed)
    assert str(compare([first, second], seed=seed, repetitions=20))
    assert len(record_games("noop", "pong", SHORT, [seed], tmp_path / "a.a26")) == 1


COMMANDS = (
    "record pong --policy random --steps 2 -o {out}.a26 --seed {seed}",
    "causes pong --states 2 --values 1 --frames 2 --seed {seed}",
    "evaluate noop pong --protocol dopamine --episodes 1 --seed {seed}",
    "collect noop pong --episodes 1 -o {out}.npz --seed {seed}",
    "verify pong --frames 5 --jobs 1 --seeds {seed}",
)


@pytest.mark.parametrize("command", COMMANDS)
def test_commands(command: str, tmp_path: Path) -> None:
    for seed in SEEDS[1::2]:
        words = command.format(out=tmp_path / str(seed), seed=seed).split()
        done = subprocess.run([sys.executable, "-m", "atari", *words], capture_output=True, text=True, timeout=200)
        assert done.returncode == 0, done.stderr


@pytest.mark.parametrize("seed", OUTSIDE)
def test_commands_name_the_range(seed: int, tmp_path: Path) -> None:
    words = ["record", "pong", "--policy", "random", "--steps", "1", "-o", "a.a26", f"--seed={seed}"]
    done = subprocess.run([sys.executable, "-m", "atari", *words], cwd=tmp_path, capture_output=True, text=True)
    assert done.returncode == 2
    assert f"a seed must be within 0..4294967295, got {seed}" in done.stderr

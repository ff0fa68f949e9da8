"""Seeds have one range, 0..2**32-1, at every door; single environments also take larger ones, as Gymnasium's do.

Environment i of a vector has the seed plus i, also above the range.
"""

import hashlib
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
from atari import cores, multiplayer
from atari.cli import main
from atari.integrations import envpool
from atari.lab import causes
from atari.lab.probes import play_episodes
from atari.learning import PROTOCOLS, ReplayMemory, compare, evaluate, record_games
from atari.learning.frame_agent import FrameAgent
from atari.multiplayer import MultiplayerCore
from atari.play import Session
from atari.recording import RecordReplay

SHORT = replace(PROTOCOLS["dopamine"], name="short", max_frames=400)
SEEDS = (2**31 - 1, 2**31, 3_000_000_000, 2**32 - 1)
OUTSIDE = (-1, 2**32)


STICKY: dict[str, Any] = {"repeat_action_probability": 0.5}
"""With it, the generator of the emulator decides what is played."""


def single(env: Any, seed: int) -> Any:
    with closing(env):
        env.reset(seed=seed)
        for step in range(60):
            env.step(2 + step % 2)
        return env.unwrapped.core.ram().tolist()


def vector(seed: Any, **options: Any) -> Any:
    with closing(atari.AtariVectorEnv("pong", 2, **STICKY, **options)) as envs:
        envs.reset(seed=seed)
        for step in range(60):
            envs.step(np.full(2, 2 + step % 2))
        return envs.ram().tolist()


def core(kind: Any, seed: int) -> Any:
    rams = []
    for made in (kind("pong", seed=seed, **STICKY), kind("pong", **STICKY)):
        if rams:
            made.seed(seed)
        made.reset()
        seen = hashlib.sha256()
        for frame in range(100):
            made.act_players([2 + frame % 2, 3]) if made.name == "multiplayer" else made.act(2 + frame % 2)
            seen.update(made.ram())
        rams.append(seen.hexdigest())
    assert rams[0] == rams[1]
    return rams[0]


def pooled(seed: int) -> Any:
    rams = []
    for given in ({"seed": seed}, {}):
        envs = envpool.make_gymnasium("Pong-v5", num_envs=2, **STICKY, **given)
        if not given:
            envs.seed(seed)
        envs.reset()
        rams.append([envs.step(np.full(2, 2 + step % 2))[4]["ram"] for step in range(40)][-1].tolist())
    assert rams[0] == rams[1]
    return rams[0]


def classic(seed: int) -> Any:
    env = gym.make("Pong-ram-v0")
    env.seed(seed)
    env.reset()
    return [env.step(2 + step % 2)[0] for step in range(40)][-1].tolist()


def several(seed: int) -> Any:
    rams = []
    for given in ({"seed": seed}, {}):
        env = multiplayer.MultiplayerEnv("pong", obs_type="ram", **STICKY, **given)
        env.reset(seed=None if given else seed)
        rams.append(
            [env.step({"first_0": 2 + step % 2, "second_0": 3})[0] for step in range(80)][-1]["first_0"].tolist()
        )
    assert rams[0] == rams[1]
    return rams[0]


def session(seed: int, **options: Any) -> Any:
    with closing(Session("pong", seed=seed, **options)) as made:
        seen = hashlib.sha256()
        for step in range(80):
            made.play(*[made.legal_actions[2 + step % 2]] * len(made.humans))
            seen.update(made.screen)
        return seen.hexdigest()


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
    path = folder / f"{seed}.a26r"
    with RecordReplay(atari.AtariEnv("pong"), path) as env:
        env.reset(seed=seed)
        env.step(2)
    with closing(RecordReplay(atari.AtariVectorEnv("pong", 2), folder / f"vector-{seed}.a26r", index=1)) as envs:
        envs.reset(seed=seed)
        envs.step(np.zeros(2, int))
    replays = [atari.recording.Replay.load(folder / name) for name in (path.name, f"vector-{seed}.a26r")]
    assert all(replay.verify() for replay in replays)
    return [replay.seeds for replay in replays]


DOORS: Mapping[str, Callable[[int], Any]] = {
    "AtariEnv": lambda seed: single(atari.AtariEnv("pong", **STICKY), seed),
    "make": lambda seed: single(atari.make("pong", preset="baselines", **STICKY), seed),
    "make, seeding 'ale'": lambda seed: single(atari.make("pong", preset="ale_vector", **STICKY), seed),
    "gymnasium.make": lambda seed: single(gymnasium.make("Pong-ram-v4"), seed),
    "AtariVectorEnv": lambda seed: vector(seed),
    "AtariVectorEnv, a preset": lambda seed: vector(seed, preset="baselines"),
    "AtariVectorEnv, an array": lambda seed: vector([seed, 2**32 - 1], preset="baselines"),
    "NativeCore": lambda seed: core(cores.NativeCore, seed),
    "PlainCore": lambda seed: core(cores.PlainCore, seed),
    "AleCore": lambda seed: core(cores.AleCore, seed),
    "MultiplayerCore": lambda seed: core(MultiplayerCore, seed),
    "MultiplayerEnv": several,
    "envpool": pooled,
    "classic": classic,
    "Session": lambda seed: session(seed, **STICKY),
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
    with pytest.raises(ValueError, match=rf"seeds? must be within 0\.\.(2\*\*32-1|4294967295), got {seed}"):
        DOORS[door](seed)


@pytest.mark.parametrize("seed", SEEDS)
def test_a_replay_has_the_seed(seed: int, tmp_path: Path) -> None:
    replayed(seed, tmp_path)


@pytest.mark.parametrize("seed", SEEDS)
def test_environments_of_a_vector_have_the_seeds_that_follow(seed: int) -> None:
    for preset in ("baselines", "ale_vector"):
        envs = vector(seed, preset=preset)
        for index in range(2):
            assert single(atari.make("pong", preset=preset, **STICKY), seed + index) == envs[index]


@pytest.mark.parametrize("seed", SEEDS)
def test_compare_and_recorded_games(seed: int, tmp_path: Path) -> None:
    first = evaluate("noop", "pong", SHORT, episodes=1, seed=seed)
    second = evaluate("random", "pong", SHORT, episodes=1, seed=seed)
    assert str(compare([first, second], seed=seed, repetitions=20, mixed=True))
    assert len(record_games("noop", "pong", SHORT, [seed], tmp_path / "a.a26r")) == 1


COMMANDS = (
    "record pong --policy random --steps 2 -o {out}.a26r --seed {seed}",
    "causes pong --states 2 --values 1 --frames 2 --seed {seed} -o {out}",
    "evaluate noop pong --protocol dopamine --episodes 1 --seed {seed}",
    "collect breakout --policy noop --episodes 1 --observations grayscale -o {out}.h5 --seed {seed}",
    "verify pong --frames 5 --jobs 1 --seeds {seed}",
)


@pytest.mark.parametrize("command", COMMANDS)
def test_commands(command: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    if ".h5" in command:
        pytest.importorskip("h5py")
    words = command.format(out=tmp_path / "out", seed=SEEDS[-1]).split()
    assert main(words) == 0, capsys.readouterr().err


@pytest.mark.parametrize("seed", OUTSIDE)
def test_commands_name_the_range(seed: int, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    words = ["record", "pong", "--policy", "random", "--steps", "1", "-o", str(tmp_path / "a.a26r"), f"--seed={seed}"]
    assert main(words) == 2
    assert f"'{seed}' is not a whole number within 0..4294967295" in capsys.readouterr().err

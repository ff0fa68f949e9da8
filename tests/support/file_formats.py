"""Every format that this package writes and reads again: how a small file of it is made, and what is read from one.

`tests/formats` has a file of each, which every later release must read (docs/stability.md). When a format gets a new
version, its older file is kept as NAME-VERSION, and `python tests/support/file_formats.py` makes the missing files.
"""

import argparse
import json
from collections.abc import Callable
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import gymnasium
import numpy as np

import atari
from atari.cores import verify
from atari.lab import causes
from atari.lab.causal.files import load, save
from atari.learning import ReplayMemory, Result, evaluate
from atari.learning.frontier import read_frontier, write_frontier
from atari.multiplayer import MultiplayerCore
from atari.recording import RecordReplay, Replay
from atari.recording.replay.players import RecordMatch

FILES = Path(__file__).parents[1] / "formats/files"
TASK = atari.Task.of("pong", preset="envpool", img_height=10, img_width=12, action_delay=2)
STEPS = 40


@dataclass(frozen=True)
class Format:
    """A format.

    Attributes:
        file: the name of a file of it in `tests/formats/files`.
        write: writes such a file.
        read: opens one with what this package offers for it, and returns facts of its content.
    """

    file: str
    write: Callable[[Path], None]
    read: Callable[[Path], Any]


def _played(env: gymnasium.Env[Any, Any], steps: int = STEPS) -> list[float]:
    """The sum of each observation and reward of a random, constant plan of actions."""
    plan = np.random.default_rng(7).integers(0, env.action_space.n, steps)  # type: ignore[attr-defined]
    seen = []
    for action in plan.tolist():
        observation, reward, terminated, truncated, _ = env.step(action)
        seen.append(float(np.sum(observation, dtype=np.float64)) + float(reward))
        if terminated or truncated:
            env.reset()
    return seen


def _write_task(path: Path) -> None:
    path.write_text(TASK.to_json(), encoding="utf-8")


def _write_replay(path: Path) -> None:
    with RecordReplay(atari.make(TASK), path) as env:
        env.reset(seed=3)
        _played(env)


def _read_replay(path: Path) -> Any:
    replay = Replay.load(path)
    verification = replay.verify()
    return [bool(verification), verification.frames, replay.game.id, replay.players, replay.seeds]


def _write_players(path: Path) -> None:
    with RecordMatch(MultiplayerCore("boxing", seed=3), path) as core:
        for number in range(STEPS):
            core.act_players([number % 6, 3])


def _write_snapshot(path: Path) -> None:
    env = atari.make(TASK)
    env.reset(seed=3)
    _played(env)
    path.write_bytes(env.snapshot())  # type: ignore[attr-defined]


def _write_lane(path: Path) -> None:
    envs = atari.AtariVectorEnv(TASK, 2)
    envs.reset(seed=3)
    path.write_bytes(envs.snapshot([1], packed=True)[0])


def _read_snapshot(path: Path) -> Any:
    """What both kinds of environments play from a snapshot."""
    env, envs = atari.make(TASK), atari.AtariVectorEnv(TASK, 1)
    env.restore(path.read_bytes())  # type: ignore[attr-defined]
    envs.reset(seed=0)
    envs.restore([0], [path.read_bytes()])
    return [_played(env), envs.ram()[0].tolist()]


def _write_players_snapshot(path: Path) -> None:
    core = MultiplayerCore("boxing", seed=3)
    core.act_players([1, 2])
    path.write_bytes(core.snapshot())


def _read_players_snapshot(path: Path) -> Any:
    core = MultiplayerCore("boxing")
    core.restore(path.read_bytes())
    return [core.frame_number, core.ram().tolist()]


def _write_states(path: Path) -> None:
    envs = atari.AtariVectorEnv(TASK, 2)
    envs.reset(seed=3)
    write_frontier(path, TASK, envs.snapshot(), [0.0, 1.0])


def _read_states(path: Path) -> Any:
    frontier = read_frontier(path, TASK)
    envs = atari.AtariVectorEnv(TASK, 2)
    envs.reset(seed=0)
    envs.restore([0, 1], frontier.snapshots)
    return [frontier.scores, envs.ram().tolist()]


def _write_memory(path: Path) -> None:
    with ReplayMemory(8, 1, (4,), stack_num=1, margin=2, seed=1, path=path) as memory:
        memory.reset(np.zeros((1, 4), np.uint8))
        for number in range(6):
            seen = np.full((1, 4), number, np.uint8)
            ends = np.array([[number == 4], [False]])
            memory.add(np.array([number]), np.ones(1), *ends, observations=seen)
        memory.flush()


def _read_memory(path: Path) -> Any:
    with ReplayMemory.open(path) as memory:
        return [len(memory), memory.capacity, memory.sample(4).actions.tolist()]


def _write_causes(path: Path) -> None:
    save(causes("pong", states=4, frames=8, seed=1, threads=1), path)


def _read_causes(path: Path) -> Any:
    found = load(path)
    return [found.game, found.height, sum(int(each.pixels.sum()) for each in found.bytes), len(found.suggestions)]


def _write_evaluation(path: Path) -> None:
    evaluate("random", "pong", episodes=1, protocol="atari100k", seed=1).save(path)


def _read_evaluation(path: Path) -> Any:
    result = Result.load(path)
    return [result.protocol.name, result["pong"].scores, result["pong"].frames]


def _write_difference(path: Path) -> None:
    found = verify.Difference(verify.VerificationRun("pong", frames=9), 3, ("ram 4: 1, 2",))
    found.write(path.parent).rename(path)


FORMATS = (
    Format("task.json", _write_task, lambda path: atari.Task.from_json(path.read_text("utf-8")) == TASK),
    Format("replay.a26r", _write_replay, _read_replay),
    Format("players.a26r", _write_players, _read_replay),
    Format("environment.snapshot", _write_snapshot, _read_snapshot),
    Format("lane.snapshot", _write_lane, _read_snapshot),
    Format("players.snapshot", _write_players_snapshot, _read_players_snapshot),
    Format("frontier.states", _write_states, _read_states),
    Format("memory.replay", _write_memory, _read_memory),
    Format("causes.npz", _write_causes, _read_causes),
    Format("evaluation.json", _write_evaluation, _read_evaluation),
    Format("difference.json", _write_difference, lambda path: asdict(verify.read(path))),
)
"""All formats, but for data sets (tests/lab/data), run folders (examples) and links of the page (tests/browser)."""


if __name__ == "__main__":
    argparse.ArgumentParser(description=(__doc__ or "").split("\n")[0]).parse_args()
    facts = FILES / "facts.json"
    known = json.loads(facts.read_text("utf-8")) if facts.exists() else {}
    for each in FORMATS:
        if each.file not in known:
            each.write(FILES / each.file)
            known[each.file] = each.read(FILES / each.file)
    lines = ",\n".join(f"{json.dumps(name)}: {json.dumps(value)}" for name, value in known.items())
    facts.write_text(f"{{\n{lines}\n}}\n", "utf-8")

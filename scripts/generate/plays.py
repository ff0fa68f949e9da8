#!/usr/bin/env python
"""Makes the replays of the games' pages: docs/games/replays/GAME.a26r, and index.toml with their facts.

    scripts/generate/plays.py                        # every game that has none yet
    scripts/generate/plays.py venture --frames 9000  # again, and keep the better one; more options: examples/plan.py
    scripts/generate/plays.py --check                # plays every file: score and hashes

The plays are planned with snapshots by examples/plan.py. Two games have a script of their own: play_bowling.py,
play_tetris.py. `random_score` in the index is the mean score of three random plays (seeds 0, 1, 2) of as many frames or
to the end of their game.
"""

import argparse
import random
import shutil
import statistics
import sys
import tempfile
from collections.abc import Callable, Iterable, Sequence
from pathlib import Path
from typing import Any

sys.path.insert(0, str(Path(__file__).parents[2] / "examples"))
from plan import HOLD, Effort, add_arguments, chosen_effort, play, record

import atari
from atari.cores import NativeCore
from atari.games.toml_file import tomllib
from atari.recording import Replay

FOLDER = Path(__file__).parents[2] / "docs" / "games" / "replays"
INDEX = FOLDER / "index.toml"

HEAD = """\
# The plays shown on the games' pages: made by scripts/generate/plays.py, which keeps this file sorted.
# frames: emulated, without those of the reset; random_score: mean of three random plays of as many frames.
"""


def read_index() -> dict[str, dict[str, Any]]:
    """The facts of each play, by game."""
    return tomllib.loads(INDEX.read_text(encoding="utf-8")) if INDEX.exists() else {}


def write_index(index: dict[str, dict[str, Any]]) -> None:
    """Write the index, whole or not at all."""
    tables = []
    for game, facts in sorted(index.items()):
        lines = [f'{key} = "{value}"' if isinstance(value, str) else f"{key} = {value}" for key, value in facts.items()]
        tables.append("\n".join([f"[{game}]", *lines, ""]))
    new = INDEX.with_suffix(".new")
    new.write_text("\n".join([HEAD, *tables]), encoding="utf-8")
    new.replace(INDEX)


def random_score(game: str, frames: int, **options: Any) -> float:
    """The mean score of three random plays."""
    scores = []
    for seed in range(3):
        core = NativeCore(game, seed=seed, frame_skip=HOLD, repeat_action_probability=0.0, **options)
        core.reset()
        choose = random.Random(seed)
        actions = [int(action) for action in core.game.minimal_actions]
        score = 0
        for _ in range(frames // HOLD):
            score += core.act(choose.choice(actions))
        scores.append(score)
    return round(statistics.mean(scores), 1)


def make(game: str, *, seconds: float, effort: Effort, method: str, seed: int, **options: Any) -> dict[str, Any]:
    """Make a play of a game, keep it if it is better than the present one, and return its facts."""
    actions = play(game, seconds=seconds, effort=effort, method=method, seed=seed, **options)
    first = "went back to the places it had reached and explored from them, then " if method == "explore" else ""
    how = (
        f"A search with snapshots (examples/plan.py): it {first}tried some {effort.frames // HOLD // effort.horizon} "
        f"plans of {effort.horizon * HOLD / 60:.1f} s before each action, and played the best."
    )
    return keep(game, actions, policy="search", how=how, **options)


def keep_best_ways(
    game: str, ways: Iterable[Any], attempt: Callable[[NativeCore, Any], tuple[list[int], float]], how: str
) -> dict[str, Any]:
    """Try all ways from a state with snapshots, play the best, and so on for a minute; then `keep` the play.

    `attempt` plays a way, and returns its actions and its quality.
    """
    env = atari.make(game, frameskip=HOLD, repeat_action_probability=0.0)
    env.reset(seed=0)
    core = NativeCore(game, frame_skip=HOLD, repeat_action_probability=0.0)
    core.restore_state(env.unwrapped.core.clone_state())
    played: list[int] = []
    while len(played) * HOLD < 60 * 60 and not core.game_over:
        state, tried = core.clone_state(), []
        for way in ways:
            core.restore_state(state)
            tried.append(attempt(core, way))
        actions, _ = max(tried, key=lambda each: each[1])
        core.restore_state(state)
        for action in actions:
            core.act(action)
        played += actions
    numbers = [int(action) for action in core.game.minimal_actions]
    return keep(game, [numbers.index(action) for action in played], policy="script", how=how)


def keep(game: str, actions: Sequence[int], *, policy: str, how: str, **options: Any) -> dict[str, Any]:
    """Record the actions, replace the game's file if the score is higher, and return the facts of the new play."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / f"{game}.a26r"
        score = int(record(game, actions, path, **options))
        replay = Replay.load(path)
        described = atari.games[game]
        facts = {
            "policy": policy,
            "score": score,
            "random_score": random_score(game, replay.frames_total, **options),
            "frames": replay.frames_total,
            "seed": 0,
            "mode": described.default_mode if options.get("mode") is None else options["mode"],
            "difficulty": options.get("difficulty") or 0,
            "how": how,
        }
        index = read_index()
        if game not in index or score > index[game]["score"]:
            shutil.copy(path, FOLDER / path.name)
            write_index({**index, game: facts})
    return facts


def check(game: str, facts: dict[str, Any]) -> bool:
    """Whether the file agrees with the index, and plays with the recorded result."""
    replay = Replay.load(FOLDER / f"{game}.a26r")
    score = sum(episode.score for episode in replay.episodes)
    same = (score, replay.frames_total) == (facts["score"], facts["frames"]) and bool(replay.verify())
    print(f"{game:20} {score:8} random {facts['random_score']:9} {facts['policy']:7} {'' if same else 'DIFFERS'}")
    return same


def main() -> None:
    """The command line."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("games", nargs="*", help="default: all that have no play")
    parser.add_argument("--check", action="store_true", help="check the files instead")
    parser.add_argument("--seconds", type=float, default=40.0)
    parser.add_argument("--method", choices=("plan", "explore"), default="plan")
    parser.add_argument("--seed", type=int, default=0, help="of the search")
    add_arguments(parser, Effort(frames=2500))
    chosen = parser.parse_args()
    if chosen.check:
        results = [check(game, facts) for game, facts in read_index().items()]
        sys.exit(not all(results))
    FOLDER.mkdir(parents=True, exist_ok=True)
    single = [game for game in atari.games if atari.games[game].rules is not None]
    for game in chosen.games or [game for game in single if game not in read_index()]:
        settings = {"mode": chosen.mode, "difficulty": chosen.difficulty}
        effort = chosen_effort(chosen)
        facts = make(game, seconds=chosen.seconds, effort=effort, method=chosen.method, seed=chosen.seed, **settings)
        print(f"{game:20} {facts['score']:8} random {facts['random_score']:9} in {facts['frames']} frames", flush=True)


if __name__ == "__main__":
    main()

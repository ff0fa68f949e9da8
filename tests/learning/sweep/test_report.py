"""The results of a sweep beside published agents."""

from pathlib import Path
from typing import Any

import pytest

torch = pytest.importorskip("torch")

from atari.learning import PROTOCOLS, Result  # noqa: E402
from atari.learning.agents.ppo import PPO  # noqa: E402
from atari.learning.evaluation.results import GameResult  # noqa: E402
from atari.learning.sweep.plan import TrainingRun, plan  # noqa: E402
from atari.learning.sweep.report import comparable_agents, compare_runs, planned_frames  # noqa: E402


def runs_of(games: list[str], seeds: list[int], total_steps: int, **options: Any) -> list[TrainingRun]:
    def resolve(game: str, seed: int, chosen: Any) -> Any:
        return PPO.options_class.of(game, seed=seed, total_steps=total_steps, **options, **chosen)

    return plan(games, seeds, Path("runs"), resolve)


def results_of(runs: list[TrainingRun], protocol: str, frames: list[int]) -> list[Result]:
    found = []
    for number, (run, each) in enumerate(zip(runs, frames, strict=True)):
        game = GameResult(run.options.task.game, (10.0 + number,), (1000,), (False,), (3,))
        found.append(Result(f"ppo ({run.name})", PROTOCOLS[protocol], 0, (game,), each))
    return found


def test_the_frames_are_those_of_the_planned_steps() -> None:
    for options, frames in (({}, 4000), ({"frameskip": (2, 5)}, 3000), ({"stop_score": 18.0}, None)):
        (run,) = runs_of(["pong"], [0], 1000, **options)
        assert planned_frames([run]) == frames


def test_agents_have_all_games_of_the_sweep_at_its_frames() -> None:
    runs = runs_of(["pong", "breakout"], [0], 2_500_000)
    assert "dopamine/rainbow" in comparable_agents(runs, PROTOCOLS["dopamine"])
    assert comparable_agents(runs, PROTOCOLS["baselines"]) == []
    assert comparable_agents(runs_of(["pong"], [0], 2_500_000, stop_score=18.0), PROTOCOLS["dopamine"]) == []
    found = comparable_agents(runs_of(["pong", "venture"], [0], 10_000_000), PROTOCOLS["baselines"])
    assert "cleanrl/ppo_atari_envpool_xla_jax" in found  # 57 games, at 40 million frames
    assert "cleanrl/ppo_atari" not in found  # three games


def test_the_runs_of_all_seeds_are_an_agent() -> None:
    runs = runs_of(["pong", "breakout"], [0, 1], 2_500_000)
    results = results_of(runs, "dopamine", [10_001_408] * 4)  # the last update ends a little later
    comparison = compare_runs("ppo (runs)", runs, results, ["dopamine/rainbow"], mixed=False)
    assert comparison is not None
    row, rainbow = comparison.rows
    assert (row.name, row.runs, row.frames, rainbow.frames) == ("ppo (runs)", 2, 10_000_000, 10_000_000)
    assert row.scores == {"breakout": (12.0, 13.0), "pong": (10.0, 11.0)}
    assert row.iqm.low is not None
    assert not comparison.mixed


def test_trainings_that_stopped_at_a_score_are_mixed_and_a_game_without_a_human_score_is_not_compared() -> None:
    runs = runs_of(["pong"], [0, 1], 2_500_000, stop_score=18.0)
    comparison = compare_runs("ppo", runs, results_of(runs, "dopamine", [4000, 8000]), [], mixed=False)
    assert comparison is not None
    assert comparison.mixed
    assert comparison.notes[-1].endswith("has scores of these games at other numbers of frames")
    runs = runs_of(["carnival"], [0], 1000)
    assert compare_runs("ppo", runs, results_of(runs, "dopamine", [4000]), [], mixed=False) is None

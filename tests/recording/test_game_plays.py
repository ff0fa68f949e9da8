"""The plays of the games' pages (docs/games/replays): each plays as it did, with the score in the index."""

import importlib
from pathlib import Path
from types import ModuleType
from typing import Any

import pytest

import atari
from atari.games.toml_file import tomllib
from atari.recording import Replay

ROOT = Path(__file__).parents[2]
FOLDER = ROOT / "docs" / "games" / "replays"
INDEX: dict[str, dict[str, Any]] = tomllib.loads((FOLDER / "index.toml").read_text(encoding="utf-8"))
KEYS = {"policy", "score", "random_score", "frames", "seed", "mode", "difficulty", "how"}


def test_every_game_of_one_player_has_a_play() -> None:
    assert {game for game in atari.games if atari.games[game].rules is not None} <= set(INDEX)
    assert {path.stem for path in FOLDER.glob("*.a26r")} == set(INDEX)
    for facts in INDEX.values():
        assert set(facts) >= KEYS
        assert facts["policy"] in ("search", "agent", "script", "random")


def test_every_play_plays_as_it_did_with_the_score_of_the_index() -> None:
    for game, facts in INDEX.items():
        replay = Replay.load(FOLDER / f"{game}.a26r")
        assert sum(episode.score for episode in replay.episodes) == facts["score"], game
        assert replay.frames_total == facts["frames"], game
        mode, difficulty = replay.options["mode"], replay.options["difficulty"]
        assert facts["mode"] == (atari.games[game].default_mode if mode is None else mode), game
        assert facts["difficulty"] == (difficulty or 0), game
        assert replay.path.stat().st_size < 12_000, game
        assert replay.verify(), game  # RAM, screens, rewards and ends


@pytest.fixture
def plan(monkeypatch: pytest.MonkeyPatch) -> ModuleType:
    monkeypatch.syspath_prepend(ROOT / "examples")
    return importlib.import_module("plan")


def test_planning_is_repeatable_and_recorded_as_planned(plan: ModuleType, tmp_path: Path) -> None:
    effort = plan.Effort(horizon=20, frames=600, bonus={"player_x": 0.01})
    actions = plan.play("space_invaders", seconds=3, effort=effort)
    assert actions == plan.play("space_invaders", seconds=3, effort=effort)
    score = plan.record("space_invaders", actions, tmp_path / "plan.a26r")
    assert score > 0
    assert Replay.load(tmp_path / "plan.a26r").episodes[0].score == score


def test_exploring_goes_on_from_what_it_found(plan: ModuleType, tmp_path: Path) -> None:
    effort = plan.Effort(horizon=20, frames=200)
    actions = plan.play("berzerk", seconds=5, effort=effort, method="explore")
    assert 0 < len(actions) <= 75
    plan.record("berzerk", actions, tmp_path / "explore.a26r")
    assert Replay.load(tmp_path / "explore.a26r").verify()

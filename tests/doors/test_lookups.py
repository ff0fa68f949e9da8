"""Each public function looks GAME up once, and passes on the task or the game that it names."""

import ast
import functools
import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from doors import DOORS, STABLE_BASELINES, TRAIN, Door
from env_tools import needs_gymnasium_1
from package_modules import SOURCES

from atari.games.catalog import Games
from atari.games.game import Game
from atari.lab import causes
from atari.lab.interventions import check
from atari.lab.probes import play_episodes
from atari.learning import diagnose, evaluate, load_policy, record_games
from atari.learning.options import TrainingOptions
from atari.play import Session
from atari.testing import check_policy

GAMES = {"name": "Pong", "ID": "ALE/Pong-v5"}

LOOKUPS = {"atari.make": 2}
"""The lookups of doors that call another door: `gymnasium.make` finds the game of the ID that is in the spec."""

NEEDS = {TRAIN.name: "torch", STABLE_BASELINES.name: "stable_baselines3"}
"""The packages that doors need."""


@pytest.fixture
def looked_up(monkeypatch: pytest.MonkeyPatch) -> list[object]:
    """The names and paths of games that have been looked up, in order."""
    found: list[object] = []
    resolve = Games.resolve

    @functools.wraps(resolve)
    def noted(self: Games, game: Any) -> Game:
        if not isinstance(game, Game):
            found.append(game)
        return resolve(self, game)

    monkeypatch.setattr(Games, "resolve", noted)
    return found


@pytest.mark.parametrize("form", GAMES)
@pytest.mark.parametrize("door", [*DOORS, TRAIN, STABLE_BASELINES], ids=lambda door: door.name)
@needs_gymnasium_1
def test_a_door_looks_a_game_up_once(door: Door, form: str, looked_up: list[object]) -> None:
    if door.name in NEEDS:
        pytest.importorskip(NEEDS[door.name])
    if door.games == "ids" and form != "ID":
        pytest.skip("it takes IDs alone")
    door.task(GAMES[form], **({"players": 2} if door.games == "several" else {}))
    assert looked_up == ["pong"] * LOOKUPS.get(door.name, 1)


CALLS: dict[str, Callable[[str, Path], object]] = {
    "evaluate": lambda game, _: evaluate("noop", game, episodes=1),
    "diagnose": lambda game, _: diagnose("noop", game, games=1, frontiers=0),
    "record_games": lambda game, folder: record_games("noop", game, "machado2018", [1], folder / "games.a26r"),
    "TrainingOptions.of": lambda game, _: TrainingOptions.of(game),
    "causes": lambda game, _: causes(game, states=1, values=1, frames=1),
    "interventions.check": lambda game, _: check(game, "lazy_enemy"),
    "play_episodes": lambda game, _: play_episodes(game, 8),
    "check_policy": lambda game, _: check_policy(load_policy("random"), game, steps=2),
    "Session": lambda game, _: Session(game).close(),
}
"""The functions that play GAME and return no task."""


@pytest.mark.parametrize("form", GAMES)
@pytest.mark.parametrize("name", CALLS)
def test_a_function_looks_a_game_up_once(name: str, form: str, looked_up: list[object], tmp_path: Path) -> None:
    CALLS[name](GAMES[form], tmp_path)
    assert looked_up == ["pong"]


DOORS_WITH_GAME = {
    "atari.cores.ale": {"AleCore.__init__"},
    "atari.cores.native": {"NativeCore.__init__"},
    "atari.env.env": {"AtariEnv.__init__"},
    "atari.env.episode_env": {"EpisodeEnv.__init__"},
    "atari.games.catalog": {"Games.resolve", "Games.find"},
    "atari.games.interventions.file": {"load"},
    "atari.integrations.envpool.pool": {"make", "make_dm", "make_gym", "make_gymnasium", "_made"},
    "atari.integrations.envpool.spec": {"make_spec", "_look_up"},
    "atari.integrations.ray.collection": {"collect"},
    "atari.integrations.ray.rllib": {"config"},
    "atari.integrations.ray.rollout_actors": {"RolloutActors.__init__"},
    "atari.integrations.sb3": {"AtariVecEnv.__init__"},
    "atari.lab.causal.explore": {"causes"},
    "atari.lab.causal.files": {"shipped_causes"},
    "atari.lab.interventions.check": {"check"},
    "atari.lab.probes.data": {"play_episodes"},
    "atari.learning.diagnosis.diagnosis": {"diagnose", "_game_of"},
    "atari.learning.evaluation.evaluate": {"evaluate", "record_games"},
    "atari.learning.evaluation.played": {"resolve_games"},
    "atari.learning.options": {"TrainingOptions.of"},
    "atari.learning.restarts": {"RestartOptions.of"},
    "atari.multiplayer": {"raw_env", "env", "parallel_env"},
    "atari.multiplayer.core": {"MultiplayerCore.__init__"},
    "atari.multiplayer.parallel": {"MultiplayerEnv.__init__"},
    "atari.multiplayer.resolution": {"resolve_several", "_environment"},
    "atari.play.multiplayer_session": {"MultiplayerSession.__init__"},
    "atari.play.session": {"Session.__new__", "Session.__init__", "_task"},
    "atari.recording.replay.header": {"game_of_header"},
    "atari.recording.replay.replay": {"Replay.load"},
    "atari.registry.making": {"make", "make_AtariEnv"},
    "atari.roms.search": {"verify", "find"},
    "atari.task.resolution": {"catalogue_name"},
    "atari.task.task": {"Task.of", "look_up", "resolve_frames"},
    "atari.testing.game_file": {"check_game_file"},
    "atari.testing.policy": {"check_policy"},
    "atari.vector.env": {"AtariVectorEnv.__init__"},
    "atari.vector.options": {"resolve_lanes", "_listed"},
}
"""The functions that take a game by its name or an ID: those that users call, and the first that these call.

Each other function takes a `Task`, a `Game`, or what `look_up` returns.
"""


def _takes_game(parameter: ast.arg) -> bool:
    """Whether a parameter may be a game's name: by its type, or by its name if its type says nothing."""
    parts = ast.walk(parameter.annotation) if parameter.annotation else ()
    types = {
        word for part in parts for word in re.findall(r"\w+", str(getattr(part, "id", getattr(part, "value", ""))))
    }
    named = parameter.arg in ("game", "games", "game_or_id", "task_id") and types <= {"Any", "object"}
    return named or "GameLike" in types or bool({"Game", "Task"} & types and {"str", "PathLike"} & types)


def functions_with_game(source: str) -> set[str]:
    """The functions of a module, with their classes, that take a game by its name."""
    found: set[str] = set()

    def visit(node: ast.AST, owner: str) -> None:
        for child in ast.iter_child_nodes(node):
            if isinstance(child, (ast.ClassDef, ast.FunctionDef)):
                if isinstance(child, ast.FunctionDef):
                    arguments = child.args
                    every = (*arguments.posonlyargs, *arguments.args, *arguments.kwonlyargs)
                    found.update([f"{owner}{child.name}"] if any(map(_takes_game, every)) else [])
                visit(child, f"{owner}{child.name}.")
            else:
                visit(child, owner)

    visit(ast.parse(source), "")
    return found


def test_the_functions_behind_the_doors_take_no_name_of_a_game() -> None:
    found = {name: functions_with_game(file.read_text(encoding="utf-8")) for name, file in SOURCES.items()}
    assert {file: functions for file, functions in found.items() if functions} == DOORS_WITH_GAME


@pytest.mark.parametrize("kind", ["GameLike", "str | Task", "'PathLike[str] | Game'", "Any", "Sequence[GameLike]"])
def test_a_name_behind_a_door_is_found(kind: str) -> None:
    assert functions_with_game(f"class Needs:\n    def of(self, policy: str, game: {kind}) -> Task: ...") == {
        "Needs.of"
    }
    assert not functions_with_game("def needs_of(policy: str | Path, game: Game) -> Task: ...")

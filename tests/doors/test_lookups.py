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

import atari
from atari.games.catalog import Games
from atari.games.game import Game
from atari.lab import causes
from atari.lab.interventions import check
from atari.lab.probes import play_episodes
from atari.learning import evaluate, load_policy, record_games
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
    "cores/ale.py": {"AleCore.__init__"},
    "cores/native.py": {"NativeCore.__init__"},
    "env/env.py": {"AtariEnv.__init__"},
    "env/episode_env.py": {"EpisodeEnv.__init__"},
    "games/catalog.py": {"Games.resolve", "Games.find"},
    "games/interventions/file.py": {"load"},
    "integrations/envpool/pool.py": {"make", "make_dm", "make_gym", "make_gymnasium", "_made"},
    "integrations/envpool/spec.py": {"make_spec", "_look_up"},
    "integrations/ray/collection.py": {"collect"},
    "integrations/ray/rllib.py": {"config"},
    "integrations/ray/rollout_actors.py": {"RolloutActors.__init__"},
    "integrations/sb3.py": {"AtariVecEnv.__init__"},
    "lab/causal/explore.py": {"causes"},
    "lab/causal/files.py": {"shipped_causes"},
    "lab/interventions/check.py": {"check"},
    "lab/probes/data.py": {"play_episodes"},
    "learning/evaluation/evaluate.py": {"evaluate", "record_games"},
    "learning/evaluation/played.py": {"resolve_games"},
    "learning/options.py": {"TrainingOptions.of"},
    "registry/making.py": {"make", "make_AtariEnv"},
    "multiplayer/__init__.py": {"raw_env", "env", "parallel_env"},
    "multiplayer/core.py": {"MultiplayerCore.__init__"},
    "multiplayer/parallel.py": {"MultiplayerEnv.__init__"},
    "multiplayer/resolution.py": {"resolve_several", "_environment"},
    "play/multiplayer_session.py": {"MultiplayerSession.__init__"},
    "play/session.py": {"Session.__new__", "Session.__init__", "_task"},
    "recording/replay/header.py": {"game_of_header"},
    "recording/replay/replay.py": {"Replay.load"},
    "roms/search.py": {"verify", "find"},
    "task/resolution.py": {"catalogue_name"},
    "task/task.py": {"Task.of", "look_up", "resolve_frames"},
    "testing/game_file.py": {"check_game_file"},
    "testing/policy.py": {"check_policy"},
    "vector/env.py": {"AtariVectorEnv.__init__"},
    "vector/options.py": {"resolve_lanes", "_listed"},
}
"""The functions that take a game by its name or an ID: those that users call, and the first that these call.

Each other function takes a `Task`, a `Game`, or what `look_up` returns.
"""

PARTS = {"": atari, "roms/": atari.roms, "wrappers/": atari.wrappers}  # in the sources, two are beside the first
FILES = {
    prefix + str(file.relative_to(folder)): file
    for prefix, part in PARTS.items()
    for folder in [Path(str(part.__file__)).parent]
    for file in sorted(folder.rglob("*.py"))
}


def _takes_game(parameter: ast.arg) -> bool:
    """Whether a parameter may be a game's name: by its type, or by its name if its type says nothing."""
    types = set(re.findall(r"\w+", "" if parameter.annotation is None else ast.unparse(parameter.annotation)))
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
    found = {name: functions_with_game(file.read_text(encoding="utf-8")) for name, file in FILES.items()}
    assert {file: functions for file, functions in found.items() if functions} == DOORS_WITH_GAME


@pytest.mark.parametrize("kind", ["GameLike", "str | Task", "'PathLike[str] | Game'", "Any", "Sequence[GameLike]"])
def test_a_name_behind_a_door_is_found(kind: str) -> None:
    assert functions_with_game(f"class Needs:\n    def of(self, policy: str, game: {kind}) -> Task: ...") == {
        "Needs.of"
    }
    assert not functions_with_game("def needs_of(policy: str | Path, game: Game) -> Task: ...")

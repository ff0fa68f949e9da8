"""The runs of a sweep: games, seeds, and folders that hold other runs."""

from contextlib import nullcontext
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any

import pytest

pytest.importorskip("torch")

from atari.base.frozen import FrozenDict
from atari.learning import GAME_SETS, PROTOCOLS
from atari.learning.agent import agent_code
from atari.learning.agents.ppo import PPO
from atari.learning.options import option_from_text
from atari.learning.sweep.plan import check_folder, check_protocol, find_games, find_seeds, keep_programs, plan
from atari.learning.training import Training

NO_GRID: Any = FrozenDict()


def resolve(game: str, seed: int, chosen: Any = NO_GRID, **options: Any) -> Any:
    return PPO.options_class.of(game, seed=seed, **{"num_envs": 4, "minibatch": 64, "horizon": 16, **options, **chosen})


@pytest.mark.parametrize(
    ("text", "seeds"), [("0", [0]), ("0-2", [0, 1, 2]), ("7,0-1", [7, 0, 1]), ("4294967295", [2**32 - 1])]
)
def test_seeds(text: str, seeds: list[int]) -> None:
    assert find_seeds(text) == seeds


@pytest.mark.parametrize(
    ("text", "error"),
    [
        ("", "as in 0-2,7, got ''"),
        ("2-0", "got '2-0'"),
        ("-1", "got '-1'"),
        ("0,,1", "got '0,,1'"),
        ("1.5", "got '1.5'"),
        ("4294967296", r"below 2\*\*32"),
        ("0-4294967295", "at most 1,000 seeds"),
        ("0-2,1", "seed 1 is named twice in '0-2,1'; leave one of them out"),
    ],
)
def test_wrong_seeds(text: str, error: str) -> None:
    with pytest.raises(ValueError, match=error):
        find_seeds(text)


def test_games_are_those_of_sets_and_names() -> None:
    assert find_games("pong") == ["pong"]
    assert find_games("atari26,surround") == [*GAME_SETS["atari26"], "surround"]
    with pytest.raises(ValueError, match="games are named with commas between"):
        find_games("pong,,breakout")


def test_a_run_has_a_folder_and_the_options_of_its_seed(tmp_path: Path) -> None:
    runs = plan(["pong", "Breakout-ram-v4"], [3, 5], tmp_path, resolve)
    assert [run.name for run in runs] == ["pong-seed3", "pong-seed5", "breakout-seed3", "breakout-seed5"]
    assert [run.options.seed for run in runs] == [3, 5, 3, 5]
    assert runs[2].options.from_ram
    assert not any(tmp_path.iterdir())


@pytest.mark.parametrize(
    ("games", "error"),
    [
        (["pong", "pong"], "pong is named twice, as 'pong' and 'pong'; leave one of them out"),
        (["pong", "ALE/Pong-v5"], "pong is named twice, as 'pong' and 'ALE/Pong-v5'"),
        ([*GAME_SETS["atari26"], "pong"], "pong is named twice"),
        (["pong", "breakuot"], "breakout"),
    ],
)
@pytest.mark.parametrize("seeds", [[0], [0, 1]])
def test_wrong_games(games: list[str], error: str, seeds: list[int], tmp_path: Path) -> None:
    with pytest.raises(ValueError, match=error):
        plan(games, seeds, tmp_path, resolve)


def test_a_protocol_that_does_not_fit_is_refused_before_the_first_training(tmp_path: Path) -> None:
    runs = plan(["pong"], [0], tmp_path, lambda game, seed, chosen: resolve(game, seed, frameskip=3))
    with pytest.raises(ValueError, match="protocol 'dopamine' plays 4 frames an action, the policy 3"):
        check_protocol(runs, PROTOCOLS["dopamine"])
    check_protocol(runs, replace(PROTOCOLS["dopamine"], name="mine", frame_skip=3))


def begun(path: Path, agent: Any, options: Any) -> None:
    Training.begin(agent, options, path).close()


@pytest.mark.parametrize(
    ("name", "other", "error"),
    [
        ("pong-seed0", {"gamma": 0.9}, r"pong-seed0 has gamma=0.9, and this sweep 0.99; give another folder"),
        ("pong-seed0", {"noops": (0, 3)}, r"pong-seed0 has noops=\(0, 3\), and this sweep \(1, 30\)"),
        ("pong-seed0", {"network": "small"}, "pong-seed0 has network='small', and this sweep 'nature'; give another"),
        ("pong-seed0", {"seed": 4}, r"pong-seed0 has seed=4, and this sweep 0"),
        ("else", {"seed": 9, "gamma": 0.9}, r"else has gamma=0.9, and this sweep 0.99"),
        ("else", {"seed": 9}, None),
        ("pong-seed0", {}, None),
    ],
)
def test_a_folder_with_runs_of_other_options_is_refused(
    name: str, other: dict[str, Any], error: str | None, tmp_path: Path
) -> None:
    runs = plan(["pong"], [0], tmp_path, resolve)
    begun(tmp_path / name, "ppo", resolve("pong", **{"seed": 0, **other}))
    if error is None:
        check_folder(tmp_path, agent_code("ppo"), runs, resolve)
        return
    with pytest.raises(ValueError, match=error):
        check_folder(tmp_path, agent_code("ppo"), runs, resolve)


def test_programs_are_kept_as_copies(tmp_path: Path) -> None:
    for name in ("a", "b", "folder"):
        (tmp_path / name).mkdir()
        (tmp_path / name / "mine.py").write_text(f"# {name}")
    (tmp_path / "net.py").write_text("# net")
    folder, mine, net = tmp_path / "folder", tmp_path / "a" / "mine.py", tmp_path / "net.py"
    words = [f"{mine}:Mine", "--network", f"{net}:Net", f"--network={net}:Net", "--gamma", "0.9", "--seed=3"]
    copy = folder / "net.py"
    expected = [f"{folder / 'mine.py'}:Mine", "--network", f"{copy}:Net", f"--network={copy}:Net", *words[4:]]
    assert keep_programs(folder, words) == expected
    assert ((folder / "mine.py").read_text(), copy.read_text()) == ("# a", "# net")
    with pytest.raises(ValueError, match="have one name, and a sweep keeps both"):
        keep_programs(folder, [str(mine), str(tmp_path / "b" / "mine.py")])
    with pytest.raises(FileNotFoundError, match=r"none\.py"):
        keep_programs(folder, [str(tmp_path / "none.py")])


def test_a_run_of_another_agent_or_a_damaged_one_is_refused(tmp_path: Path) -> None:
    begun(tmp_path / "pong-seed0", "ppo", resolve("pong", 0))
    with pytest.raises(ValueError, match="pong-seed0 is a run of ppo, and this sweep is of pqn"):
        check_folder(tmp_path, agent_code("pqn"), [], resolve)
    (tmp_path / "pong-seed0" / "config.json").write_text("{}")
    with pytest.raises(ValueError, match=r"config\.json"):
        check_folder(tmp_path, agent_code("ppo"), [], resolve)


def test_a_run_of_another_program_is_refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("atari.learning.programs.user_data_path", lambda *_, **__: tmp_path / "data")
    (tmp_path / "runs").mkdir()
    source = "from atari.learning.agents.ppo import PPO\n\nclass Mine(PPO):\n    pass\n"
    for name in ("first", "second"):
        (tmp_path / name).mkdir()
        (tmp_path / name / "mine.py").write_text(f"# {name}\n{source}")
    first, second = (agent_code(tmp_path / name / "mine.py") for name in ("first", "second"))
    begun(tmp_path / "runs" / "pong-seed0", first, resolve("pong", 0))
    check_folder(tmp_path / "runs", first, [], resolve)
    with pytest.raises(ValueError, match=r"pong-seed0 is a run of another program than .*second.mine\.py"):
        check_folder(tmp_path / "runs", second, [], resolve)


def test_a_run_with_another_intrinsic_reward_is_refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("atari.learning.programs.user_data_path", lambda *_, **__: tmp_path / "data")
    (tmp_path / "runs").mkdir()
    source = "class Bonus:\n    def __init__(self, *_): ...\n    __call__ = state = restore = lambda *_: None\n"
    made = []
    for name in ("first", "second"):
        (tmp_path / f"{name}.py").write_text(f"# {name}\n{source}")
        made.append(option_from_text(PPO.options_class, "intrinsic_reward", f"{tmp_path / name}.py:Bonus"))
    begun(tmp_path / "runs" / "pong-seed0", "ppo", resolve("pong", 0, intrinsic_reward=made[0]))
    for given, refusal in (
        (made[0], nullcontext()),
        (
            made[1],
            pytest.raises(ValueError, match="pong-seed0 has another program as intrinsic_reward than this sweep"),
        ),
        (None, pytest.raises(ValueError, match=r"pong-seed0 has intrinsic_reward=.*Bonus.*, and this sweep None")),
    ):
        with refusal:
            resolved = partial(resolve, intrinsic_reward=given)
            check_folder(tmp_path / "runs", agent_code("ppo"), [], resolved)

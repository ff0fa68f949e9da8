"""`examples/self_play.py`: the observations of both sides, and a short training, table and match."""

import importlib.util
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest

pytest.importorskip("torch")

from atari.multiplayer import MultiplayerCore
from atari.recording import Replay


@pytest.fixture(scope="module")
def example() -> Any:
    path = Path(__file__).parents[2] / "examples" / "self_play.py"
    spec = importlib.util.spec_from_file_location("self_play", path)
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    sys.modules["self_play"] = module
    spec.loader.exec_module(module)
    return module


def test_the_second_player_sees_the_game_in_a_mirror(example: Any) -> None:
    ram = np.zeros((1, 128), np.uint8)
    ram[0, example.BYTES] = 60, 100, 120, 90
    sight = example.Sight(1)
    first, second = sight.push(ram, True)[0, :, -1].tolist()
    assert first == [60, 100, 120, 90, 128 - 20, 128, 128, 0]
    assert second == [256 - 60, 100, 90, 120, 128 + 10, 128, 128, 255]
    ram[0, example.BYTES[:2]] = 64, 98
    first, second = sight.push(ram, False)[0]
    assert first[:, 0].tolist() == [60, 64]
    assert [side[-1, 5:7].tolist() for side in (first, second)] == [[128 + 16, 128 - 8], [128 - 16, 128 - 8]]
    assert sight.push(ram, np.array([True]))[0, 0, :, 0].tolist() == [64, 64]


def test_the_same_actions_move_both_paddles_alike(example: Any) -> None:
    for action in (3, 4):
        core = MultiplayerCore("pong")
        core.reset()
        for _ in range(20):
            core.act_players([action, action])
        _, _, first, second = (int(core.ram()[byte]) for byte in example.BYTES)
        assert first != 109
        assert np.sign(first - 109) == np.sign(second - 109)


def test_a_seat_of_each_game_learns(example: Any) -> None:
    games = example.SelfPlayGames(8, 2, seed=0)
    seats = sorted(zip(*(part.tolist() for part in games.learners), strict=True))
    others = sorted((int(game), int(game) % 2) for group in games.others for game in group)
    assert sorted(seats + others) == [(game, side) for game in range(8) for side in range(2)]
    assert len(seats) == 12
    assert [envs.num_envs for envs in games.envs] == [4, 4]


def test_a_short_training_a_table_and_a_match(
    example: Any, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    folder = tmp_path / "run"
    monkeypatch.setattr(example, "score_built_in", lambda network: -21.0)
    options: dict[str, Any] = {"games": 8, "opponents": 2, "horizon": 16, "minibatch": 48}
    example.train(folder, example.Options(steps=250, checkpoints=1, **options))
    example.train(folder, example.Options(steps=500, checkpoints=1, **options))  # goes on, and keeps its end
    curve = (folder / "curve.csv").read_text().splitlines()
    assert len(curve) == 1 + len(list(folder.glob("step-*.pt"))) == 4
    steps, networks = example.load(folder)
    assert steps[0] == 0
    first, *_, last = (network.state_dict() for network in networks)
    assert any(not np.array_equal(first[name], last[name]) for name in first)
    wins = example.round_robin(networks, games=1, max_frames=200)
    assert (wins + wins.T == 2 * (1 - np.eye(3))).all()
    monkeypatch.setattr(example, "round_robin", lambda networks, games: np.array([[0, 1, 0], [3, 0, 2], [4, 2, 0]]))
    assert example.rank(folder, 1) == [steps[2], steps[1], steps[0]]
    pytest.importorskip("av")
    example.match(folder, 120, seed=0)
    assert Replay.load(folder / "best.a26").verify()
    assert (folder / "best.mp4").stat().st_size > 1000
    assert f"{steps[2]} steps on the right, {steps[1]} on the left" in capsys.readouterr().out


def test_an_untrained_policy_loses_to_the_cartridge(example: Any) -> None:
    assert -21 <= example.score_built_in(example.make_network(), games=2, max_frames=1500) < 0

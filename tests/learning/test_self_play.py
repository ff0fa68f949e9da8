"""`examples/self_play.py`: the observations of both sides, and a short training, table and match."""

import importlib
from pathlib import Path
from typing import Any

import numpy as np
import pytest

torch = pytest.importorskip("torch")

from atari.learning import RunFolder  # noqa: E402
from atari.multiplayer import MultiplayerCore  # noqa: E402
from atari.recording import Replay  # noqa: E402


@pytest.fixture(scope="module")
def example() -> Any:
    with pytest.MonkeyPatch.context() as patch:
        patch.syspath_prepend(Path(__file__).parents[2] / "examples")
        return importlib.import_module("self_play")


def test_the_second_player_sees_the_game_in_a_mirror(example: Any) -> None:
    ram = np.zeros((1, 128), np.uint8)
    ram[0, example.BYTES] = 60, 100, 120, 90
    sight = example.Sight(ram)
    first, second = sight.seen[0, :, -1].tolist()
    assert first == [60, 100, 120, 90, 128 - 20, 128, 128, 0]
    assert second == [256 - 60, 100, 90, 120, 128 + 10, 128, 128, 255]
    ram[0, example.BYTES[:2]] = 64, 98
    first, second = sight.push(ram)[0]
    assert first[:, 0].tolist() == [60, 64]
    assert [side[-1, 5:7].tolist() for side in (first, second)] == [[128 + 16, 128 - 8], [128 - 16, 128 - 8]]
    assert sight.begin(ram, np.array([True]))[0, 0, :, 0].tolist() == [64, 64]


def test_a_new_game_does_not_touch_the_sight_of_others(example: Any) -> None:
    ram = np.zeros((2, 128), np.uint8)
    ram[:, example.BYTES] = 60, 100, 120, 90
    sight = example.Sight(ram)
    ram[:, example.BYTES[0]] = 62
    sight.push(ram)
    ram[1, example.BYTES[0]] = 200
    seen = sight.begin(ram, np.array([False, True]))
    assert seen[:, 0, :, 0].tolist() == [[60, 62], [200, 200]]
    assert seen[1, 0, -1, 5] == 128  # a ball of a new game has not moved
    ram[:, example.BYTES[0]] += 2
    assert sight.push(ram)[:, 0, -1, 5].tolist() == [128 + 8, 128 + 8]


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


def test_nothing_follows_a_termination_and_a_truncation_cuts_a_game_off(example: Any) -> None:
    options = example.Options(gamma=0.5, gae_lambda=1.0)
    rewards, values = torch.ones(3, 3), torch.full((3, 3), 10.0)
    following = torch.full((3, 3), 10.0)
    following[1, 1:] = 40.0  # of the step in which games 1 and 2 end
    terminations, truncations = torch.zeros(3, 3), torch.zeros(3, 3)
    terminations[1, 2] = truncations[1, 1] = 1
    found = example.advantages_of(rewards, values, following, terminations, truncations, options)
    last = 1 + 0.5 * 10 - 10
    goes_on = [last * 1.75, last * 1.5, last]
    cut_off = [last + 0.5 * (1 + 0.5 * 40 - 10), 1 + 0.5 * 40 - 10, last]
    over = [last + 0.5 * (1 - 10), 1 - 10, last]
    assert found.T.tolist() == [goes_on, cut_off, over]


def test_a_truncated_game_is_worth_what_would_have_followed(example: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    """Games of 16 steps are cut off. With a value of 7 everywhere, all returns are 7 * 0.99 plus the reward."""
    monkeypatch.setattr(example, "TASK", example.TASK.replace(max_num_frames_per_episode=64))
    learner = example.Learner(example.Options(games=8, opponents=1, horizon=20, gae_lambda=0.0))
    learner.games.pool = [example.make_network()]
    for part in (learner.network.value, *learner.network.value.modules()):
        if isinstance(part, torch.nn.Linear):
            torch.nn.init.zeros_(part.weight)
            torch.nn.init.constant_(part.bias, 7.0)
    seen, steps = [], learner.games.step

    def step(actions: Any) -> Any:
        seen.append(steps(actions))
        return seen[-1]

    monkeypatch.setattr(learner.games, "step", step)
    *_, returns = learner._play()
    assert [index for index, part in enumerate(seen) if part[2].any()] == [15]
    assert not any(part[1].any() for part in seen)
    rewards = torch.stack([part[0] for part in seen]).flatten()
    assert torch.allclose(returns, rewards + 0.99 * 7, atol=1e-5)
    last = seen[15][3]  # what was seen at the end, not of the next game, whose ball does not move yet
    assert not torch.equal(last, learner.games.observations)
    assert torch.equal(last[:, 0], seen[14][3][:, 1])


SHORT: dict[str, Any] = {"games": 8, "opponents": 2, "horizon": 16, "minibatch": 48}


def test_a_training_that_is_stopped_ends_with_the_same_weights(
    example: Any, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    options = example.Options(steps=1200, checkpoints=3, **SHORT)
    scored: list[float] = []

    def score(network: Any) -> float:
        scored.append(-21.0)
        if len(scored) == 3:
            raise KeyboardInterrupt
        return -21.0

    monkeypatch.setattr(example, "score_built_in", score)
    with pytest.raises(KeyboardInterrupt):
        example.train(tmp_path / "stopped", options)
    steps = RunFolder.open(tmp_path / "stopped").rows()[-1]["step"]
    assert 0 < steps < 1200
    for name in ("stopped", "whole"):
        example.train(tmp_path / name, options)
    stopped, whole = (RunFolder.open(tmp_path / name) for name in ("stopped", "whole"))
    weights = whole.load_weights()
    assert all(torch.equal(value, weights[name]) for name, value in stopped.load_weights().items())
    assert [row["step"] for row in stopped.rows()] == [row["step"] for row in whole.rows()]
    assert whole.config["ended"] == "steps"
    example.train(tmp_path / "whole", options)  # nothing is left to do
    with pytest.raises(SystemExit, match="give the same --steps and --seed"):
        example.train(tmp_path / "whole", example.Options(steps=5000, checkpoints=3, **SHORT))


def test_a_short_training_a_table_and_a_match(
    example: Any, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    folder = tmp_path / "run"
    monkeypatch.setattr(example, "score_built_in", lambda network: -21.0)
    example.train(folder, example.Options(steps=500, checkpoints=2, **SHORT))
    steps, networks = example.load(folder)
    assert [row["step"] for row in RunFolder.open(folder).rows()] == steps
    assert len(steps) == 3
    assert steps[0] == 0
    first, *_, last = (network.state_dict() for network in networks)
    assert any(not np.array_equal(first[name], last[name]) for name in first)
    wins = example.round_robin(networks, games=1, max_frames=200)
    assert (wins + wins.T == 2 * (1 - np.eye(3))).all()
    monkeypatch.setattr(example, "round_robin", lambda networks, games: np.array([[0, 1, 0], [3, 0, 2], [4, 2, 0]]))
    assert example.rank(folder, 1) == [steps[2], steps[1], steps[0]]
    pytest.importorskip("av")
    example.match(folder, 120, seed=0)
    assert Replay.load(folder / "best.a26r").verify()
    assert (folder / "best.mp4").stat().st_size > 1000
    assert f"{steps[2]} steps on the right, {steps[1]} on the left" in capsys.readouterr().out


def test_an_untrained_policy_loses_to_the_cartridge(example: Any) -> None:
    assert -21 <= example.score_built_in(example.make_network(), games=2, max_frames=1500) < 0

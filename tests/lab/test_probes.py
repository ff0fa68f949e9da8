"""Linear probes: the protocol on made-up states whose answer is known, and on a game."""

import sys
from collections.abc import Callable, Iterator
from typing import Any

import gymnasium
import numpy as np
import pytest

import atari
from atari.lab.probes import majority, play_episodes, probe, probe_table, ridge_probe, split_episodes
from atari.lab.probes.data import EpisodeStates, ProbeData
from atari.lab.probes.results import weighted_f1
from atari.learning import load_policy

LABELS = {"player_x": 3, "ball_x": 4, "score": 0x85, "never": 6}


def made_up(count: int = 20, length: int = 70, seed: int = 0) -> list[EpisodeStates]:
    """Episodes whose observation is RAM; byte 3 has 8 values, 4 has 4, 5 is random and not seen, 6 is nearly fixed."""
    rng = np.random.default_rng(seed)
    episodes = []
    for _ in range(count):
        ram = np.zeros((length, 128), np.uint8)
        for index, count_of_values in ((3, 8), (4, 4), (5, 256)):
            ram[:, index] = rng.integers(count_of_values, size=length)
        ram[0, 6] = 1
        seen = np.zeros((length, 14), np.uint8)
        seen[np.arange(length), ram[:, 3]] = 255
        seen[np.arange(length), 8 + ram[:, 4]] = 255
        seen[:, 12:] = rng.integers(256, size=(length, 2))
        episodes.append(EpisodeStates(seen, ram))
    return episodes


@pytest.fixture(scope="module")
def data() -> ProbeData:
    return split_episodes(made_up(), LABELS)


def test_the_split(data: ProbeData) -> None:
    assert [len(data.train), len(data.validation)] == [14 * 70, 2 * 70]
    assert len(data.test) + data.duplicates == 4 * 70
    assert data.names == ("player_x", "ball_x", "score")
    assert data.entropies["never"] < 0.1
    assert data.entropies["player_x"] == pytest.approx(np.log(8), abs=0.02)
    assert data.train.labels.shape == (980, 3)
    again = split_episodes(made_up(), LABELS, seed=1)
    assert not np.array_equal(again.train.labels, data.train.labels)


def test_short_episodes_are_left_out() -> None:
    short = made_up(5, 64)
    assert len(split_episodes([*short, *made_up(10)], LABELS).train) == 7 * 70


def test_test_states_that_training_has_are_removed() -> None:
    episodes = made_up(10)
    same = [
        EpisodeStates(np.concatenate([episode.observations, episodes[0].observations]), np.tile(episode.ram, (2, 1)))
        for episode in episodes
    ]
    assert split_episodes(same, LABELS).duplicates >= 2 * 70
    split_episodes(made_up(9), LABELS)  # enough


def test_f1_is_weighted_by_the_true_classes() -> None:
    assert weighted_f1(np.array([1, 1, 2]), np.array([1, 1, 2])) == 1
    # Class 1: precision 2/3, recall 1; class 2: 0.
    assert weighted_f1(np.array([1, 1, 1]), np.array([1, 1, 2])) == pytest.approx(0.8 * 2 / 3)


@pytest.fixture
def torch() -> Iterator[Any]:
    """PyTorch with one thread, which is faster for small layers."""
    module = pytest.importorskip("torch", reason="torch is not installed")
    threads = module.get_num_threads()
    module.set_num_threads(1)
    yield module
    module.set_num_threads(threads)


def test_a_probe_finds_what_is_there_and_no_more(data: ProbeData, torch: Any) -> None:
    result = probe(lambda seen: seen / np.float32(255), data, learning_rate=0.1, epochs=8)
    assert result.f1["player_x"] == result.f1["ball_x"] == 1
    assert result.f1["score"] < 0.1
    assert result.category_f1["agent_localization"] == result.f1["player_x"]
    assert result.category_f1["small_object_localization"] == result.f1["ball_x"]
    assert result.mean_f1 == pytest.approx((1 + 1 + result.f1["score"]) / 3)
    assert "small_object_localization" in str(result)
    assert "<table>" in result._repr_html_()
    again = [probe(lambda seen: seen / np.float32(255), data, epochs=1).f1 for _ in range(2)]
    assert again[0] == again[1]


def test_training_stops_early_and_keeps_the_best(data: ProbeData, torch: Any) -> None:
    calls = []
    best = probe(
        lambda seen: calls.append(1) or seen / np.float32(255), data, learning_rate=0.05, epochs=40, patience=2
    )  # type: ignore[func-returns-value]
    assert best.f1["player_x"] == 1
    assert len(calls) == sum(-(-len(split) // 256) for split in (data.train, data.validation, data.test))


def numbers(seen: Any) -> Any:
    """Features in which player_x is linear, and ball_x is not."""
    player, ball = seen[:, :8].argmax(1), seen[:, 8:12].argmax(1)
    return np.stack([3.0 * player - 5, (ball - 1.5) ** 2], 1)


def test_a_ridge_probe_reads_numbers_and_classes(data: ProbeData) -> None:
    pytest.importorskip("sklearn", reason="scikit-learn is not installed")
    result = ridge_probe(lambda seen: seen, data)
    assert result.r2["player_x"] > 0.999
    assert result.r2["ball_x"] > 0.999
    assert result.f1["player_x"] == result.f1["ball_x"] == result.accuracy["ball_x"] == 1
    assert abs(result.r2["score"]) < 0.1
    assert result.f1["score"] < 0.1
    assert result == ridge_probe(lambda seen: seen, data)
    linear = ridge_probe(numbers, data)
    assert linear.r2["player_x"] > 0.999
    assert abs(linear.r2["ball_x"]) < 0.1
    assert linear.f1["player_x"] < 1  # a line of one feature is highest at the first or the last value


def test_a_table_of_several_probes(data: ProbeData) -> None:
    pytest.importorskip("sklearn", reason="scikit-learn is not installed")
    results = {"all": ridge_probe(lambda seen: seen, data), "<numbers>": ridge_probe(numbers, data)}
    table = probe_table(results)
    assert table.columns == ("label", "category", "R2 all", "R2 <numbers>", "F1 all", "F1 <numbers>")
    assert table.rows[0][:3] == ("player_x", "agent_localization", "1.000")
    assert table.rows[-1][1] == "all categories"
    assert table.note == "left out, because their bytes hardly change: never"
    assert table.note in str(table)
    assert "F1 &lt;numbers&gt;" in table._repr_html_()
    assert str(results["all"]) == str(probe_table({"": results["all"]}))
    with pytest.raises(ValueError, match="results must be of the same data"):
        probe_table({"all": results["all"], "other": majority(split_episodes(made_up(), {"ball_x": 4}))})
    with pytest.raises(ValueError, match="at least one"):
        probe_table({})


def test_the_majority_baseline(data: ProbeData) -> None:
    result = majority(data)
    assert result.accuracy["player_x"] == pytest.approx(1 / 8, abs=0.05)
    assert result.f1["player_x"] < result.accuracy["player_x"]


def test_episodes_of_a_game() -> None:
    episodes = play_episodes("pong", 400, seed=1, num_envs=4)
    assert sum(len(episode.ram) for episode in episodes) == 400
    assert episodes[0].observations.shape == (100, 1, 210, 160)
    again = play_episodes(
        "pong", 400, lambda seen, lanes: np.zeros(len(lanes), np.int64), seed=1, num_envs=4, stack_num=4
    )
    assert again[0].observations.shape == (100, 4, 84, 84)
    many = play_episodes("breakout", 6000, img_height=42, img_width=42, stack_num=1)
    assert len(many) > 8
    lives = [episode.ram[:, 57] for episode in many[:4]]
    assert all(part[0] == 5 and (np.diff(part.astype(int)) <= 0).all() for part in lives)
    split = split_episodes(many, "breakout")
    assert {"ball_x", "player_x"} <= set(split.names)


@pytest.mark.parametrize(
    ("game", "shape"),
    [
        ("ALE/Pong-v5", (210, 160, 3)),
        (atari.Task.of("pong", preset="dqn2015", img_height=42, img_width=42), (4, 42, 42)),
    ],
)
def test_an_id_or_a_task_says_what_is_seen(game: Any, shape: tuple[int, ...]) -> None:
    episode = play_episodes(game, 32, num_envs=2)[0]
    task = atari.Task.of(game)
    assert episode.task == task.replace(obs_type="rgb_dict" if task.obs_type == "rgb" else "dict")
    assert episode.observations.shape[1:] == shape


@pytest.mark.parametrize("seamless", [False, True])
def test_policies_hear_of_games_and_new_stacks(seamless: bool) -> None:
    class Listens:
        begun: list[Any]

        def begin(self, *arguments: Any) -> None:
            self.begun = [arguments]

        def begin_episodes(self, lanes: Any) -> None:
            self.begun.append(lanes.tolist())

        def __call__(self, observations: Any, lanes: Any) -> Any:
            return np.ones(len(lanes), np.int64)

    policy = Listens()
    task = atari.Task.of("breakout", episodic_life=True, on_reset="continue", seamless_lives=seamless)
    episodes = play_episodes(task, 1200, policy, num_envs=2)
    (game, actions, lanes, seeds), *begun = policy.begun
    assert (game, actions, lanes.tolist()) == ("breakout", ["NOOP", "FIRE", "RIGHT", "LEFT"], [0, 1])
    assert (seeds.shape, seeds.dtype) == ((2,), np.int64)
    games = sum(int(episode.ram[0, 57] == 5) for episode in episodes)
    assert 2 < games < len(episodes)
    assert sum(map(len, begun)) == (games if seamless else len(episodes)) - 2  # the first are begun by `begin`


def test_what_load_policy_loads_plays() -> None:
    chosen = [play_episodes("pong", 64, load_policy("random"), num_envs=2, epsilon=0.0) for _ in range(2)]
    assert all(np.array_equal(one.ram, other.ram) for one, other in zip(*chosen, strict=True))
    assert not np.array_equal(chosen[0][0].ram, chosen[0][1].ram)


@pytest.mark.parametrize(
    ("use", "error", "text"),
    [
        (lambda: split_episodes(made_up(2), LABELS), ValueError, "too few"),
        (lambda: split_episodes(made_up(), {"never": 6}), ValueError, "no label has an entropy"),
        (lambda: split_episodes(made_up(), {"a": 300}), ValueError, "0..127"),
        (lambda: split_episodes(made_up(), "amidar"), ValueError, "AtariARI has no names for amidar"),
        (lambda: split_episodes([made_up(10)[0]] * 10, LABELS), ValueError, "all states of the test"),
        (lambda: split_episodes([*made_up(), 5], LABELS), TypeError, "episodes are what play_episodes returns, got 5"),
        (lambda: split_episodes(made_up(), ["a"]), TypeError, "labels must be a game's id, or places in RAM"),
        (
            lambda: split_episodes(play_episodes("frostbite", 8, img_height=21, img_width=21), "breakout"),
            ValueError,
            "the labels are of breakout, and the episodes of frostbite",
        ),
        (lambda: play_episodes("pong", 8, "random"), TypeError, "policy must be a function"),
        (lambda: play_episodes("pong", 32, obs_type="ram"), ValueError, "'dict' or 'rgb_dict', not 'ram'"),
        (lambda: majority(made_up()), TypeError, "data must be a ProbeData"),
        (lambda: probe(lambda seen: seen, made_up()), TypeError, "data must be a ProbeData"),
        (lambda: ridge_probe(lambda seen: seen, made_up()), TypeError, "data must be a ProbeData"),
    ],
)
def test_what_is_refused(use: Callable[[], object], error: type[Exception], text: str) -> None:
    with pytest.raises(error, match=text):
        use()


@pytest.mark.parametrize(
    ("encoder", "options", "text"),
    [
        (lambda seen: np.zeros((1, 5)), {}, "256 rows"),
        (lambda seen: np.full((len(seen), 5), np.nan), {}, "not finite"),
        (lambda seen: seen, {"patience": 0}, "patience"),
    ],
)
def test_wrong_features(data: ProbeData, torch: Any, encoder: Any, options: dict[str, Any], text: str) -> None:
    with pytest.raises(ValueError, match=text):
        probe(encoder, data, **options)


def test_without_scikit_learn_the_error_names_it(data: ProbeData, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "sklearn.linear_model", None)
    with pytest.raises(
        gymnasium.error.DependencyNotInstalled, match=r"ridge_probe needs scikit-learn: .* install scikit-learn"
    ):
        ridge_probe(lambda seen: seen, data)


def test_without_torch_the_error_names_the_extra(data: ProbeData, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "torch", None)
    with pytest.raises(gymnasium.error.DependencyNotInstalled, match=r"pip install 'torch>=2\.2'"):
        probe(lambda seen: seen, data)

"""Datasets: Minari's own loader reads what the environment returned."""

from pathlib import Path
from typing import Any

import gymnasium
import numpy as np
import pytest

import atari
from atari.recording import RecordReplay, Replay, to_minari

pytestmark = pytest.mark.peers

FIELDS = ("observations", "actions", "rewards", "terminations", "truncations")


@pytest.fixture(autouse=True)
def datasets(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.setenv("MINARI_DATASETS_PATH", str(tmp_path / "datasets"))
    return tmp_path


def play(env: gymnasium.Env[Any, Any], steps: int, seed: int = 0) -> list[dict[str, list[Any]]]:
    """Play at random and return the episodes, as a dataset has them."""
    env.action_space.seed(seed)
    episodes: list[dict[str, list[Any]]] = []
    over = True
    for _ in range(steps):
        if over:
            observation, info = env.reset(seed=None if episodes else seed)
            episodes.append({**{name: [] for name in FIELDS}, "observations": [observation], "infos": [info]})
        action = env.action_space.sample()
        observation, reward, terminated, truncated, info = env.step(action)
        values = (observation, action, reward, terminated, truncated)
        for name, value in zip(FIELDS, values, strict=True):
            episodes[-1][name].append(value)
        episodes[-1]["infos"].append(info)
        over = terminated or truncated
    return episodes


def assert_same(dataset: Any, episodes: list[dict[str, list[Any]]]) -> None:
    loaded = list(dataset)
    assert len(loaded) == dataset.total_episodes == len(episodes)
    assert dataset.total_steps == sum(len(episode["rewards"]) for episode in episodes)
    for got, expected in zip(loaded, episodes, strict=True):
        expected["truncations"][-1] = not expected["terminations"][-1]  # Minari's mark of an unfinished episode
        for name in FIELDS:
            values = getattr(got, name)
            if isinstance(values, dict):
                for part, array in values.items():
                    assert np.array_equal(array, [value[part] for value in expected[name]]), (name, part)
            else:
                assert np.array_equal(values, np.array(expected[name])), name
        for name in ("lives", "frame_number", "episode_frame_number"):
            assert np.array_equal(got.infos[name], [info[name] for info in expected["infos"]])


@pytest.mark.parametrize(
    ("game", "options", "steps"),
    [
        ("breakout", {"obs_type": "ram"}, 400),
        ("pong", {"max_num_frames_per_episode": 90, "frameskip": (2, 5)}, 60),
        ("seaquest", {"obs_type": "grayscale", "sound_obs": True}, 25),
        ("breakout", {"continuous": True, "obs_type": "ram", "mode": 4}, 60),
        ("skiing", {"full_action_space": True, "repeat_action_probability": 0.0, "core": "ale"}, 20),
    ],
)
def test_the_loader_reads_what_was_returned(game: str, options: dict[str, Any], steps: int, datasets: Path) -> None:
    import minari

    env = RecordReplay(atari.AtariEnv(game, **options), datasets / "a.a26r")
    episodes = play(env, steps)
    env.close()
    made = to_minari(env.path, f"atari/{game}/test-v0", author="nobody")
    dataset = minari.load_dataset(f"atari/{game}/test-v0")
    for each in (made, dataset):
        assert_same(each, episodes)
    assert dataset.observation_space == env.observation_space
    assert dataset.action_space == env.action_space
    recovered = dataset.recover_environment()
    assert recovered.unwrapped.game.id == game
    assert recovered.observation_space == env.observation_space


def test_several_replays_and_another_kind_of_observation(datasets: Path) -> None:
    episodes = []
    for name in ("a.a26r", "b.a26r"):
        env = RecordReplay(atari.make("ms_pacman", obs_type="ram"), datasets / name)
        episodes += play(env, 30, seed=ord(name[0]))
        env.close()
    paths = [datasets / "a.a26r", datasets / "b.a26r"]
    assert_same(to_minari([Replay.load(path) for path in paths], "ms_pacman/ram-v0"), episodes)
    pixels = to_minari(paths, "ms_pacman/pixels-v0", obs_type="grayscale")
    assert pixels[0].observations.shape == (31, 210, 160)
    assert np.array_equal(pixels[1].actions, episodes[1]["actions"])


def test_what_wrappers_play_is_the_environments(datasets: Path) -> None:
    env = RecordReplay(atari.make("breakout", preset="dqn2015"), datasets / "a.a26r")
    env.action_space.seed(0)
    env.reset(seed=0)
    for _ in range(60):
        _, _, terminated, truncated, _ = env.step(env.action_space.sample())
        if terminated or truncated:
            env.reset()
    env.close()
    (episode,) = to_minari(env.path, "breakout/dqn-v0", obs_type="ram")
    replay = Replay.load(env.path)
    last = [frame.ram for frame in replay.frames() if frame.ends_step]
    assert len(episode.rewards) == 60
    assert np.array_equal(episode.observations[1:], last)
    assert episode.infos["frame_number"][0] < 31  # the no-ops come before the first observation
    assert episode.rewards.sum() == sum(frame.reward for frame in replay.frames())
    dataset = to_minari(env.path, "breakout/dqn-v1", obs_type="ram")
    metadata = dataset.storage.metadata
    assert atari.Task.from_json(metadata["task"]) == atari.Task.of("breakout", preset="dqn2015")
    assert metadata["core_seeds"] == str(list(replay.seeds))
    assert dataset.recover_environment().unwrapped.task.frameskip == 4


def test_replays_of_several_tasks_are_refused(datasets: Path) -> None:
    for name, options in (("a.a26r", {"frameskip": 3}), ("b.a26r", {"frameskip": 4, "noops": (1, 30)})):
        env = RecordReplay(atari.make("pong", **options), datasets / name)
        env.reset(seed=0)
        env.step(0)
        env.close()
    with pytest.raises(ValueError, match=r"differ in frameskip: 3 and 4; noops: \(0, 0\) and \(1, 30\)"):
        to_minari([datasets / "a.a26r", datasets / "b.a26r"], "pong/a-v0")


def test_going_back_begins_another_episode(datasets: Path) -> None:
    env = RecordReplay(atari.AtariEnv("breakout", obs_type="ram"), datasets / "a.a26r")
    play(env, 20)
    inner: Any = env.unwrapped
    data, ram = inner.snapshot(), inner.core.ram()
    for action in range(3):
        env.step(action)
    inner.restore(data)
    env.step(1)
    env.close()
    first, second = to_minari(env.path, "breakout/back-v0")
    assert (len(first.rewards), len(second.rewards)) == (23, 1)
    assert np.array_equal(second.observations[0], ram)


def test_wrong_uses(datasets: Path) -> None:
    for name, game in (("a.a26r", "pong"), ("b.a26r", "breakout")):
        env = RecordReplay(atari.AtariEnv(game, obs_type="ram"), datasets / name)
        play(env, 5)
        env.close()
    with pytest.raises(ValueError, match="at least one replay"):
        to_minari([], "pong/a-v0")
    with pytest.raises(ValueError, match=r"a.a26r and .*b.a26r differ in game: pong and breakout"):
        to_minari([datasets / "a.a26r", datasets / "b.a26r"], "pong/a-v0")
    to_minari(datasets / "a.a26r", "pong/a-v0")
    with pytest.raises(ValueError, match="there is a dataset 'pong/a-v0' already"):
        to_minari(datasets / "a.a26r", "pong/a-v0")
    env = RecordReplay(atari.AtariEnv("pong"), datasets / "c.a26r")
    env.reset()
    env.close()
    with pytest.raises(ValueError, match="have no steps of an environment"):
        to_minari(env.path, "pong/b-v0")


@pytest.mark.parametrize("options", [{"obs_type": "ram"}, {"obs_type": "grayscale", "sound_obs": True}, {}])
def test_dict_observations(options: dict[str, Any], datasets: Path) -> None:
    import minari

    env = RecordReplay(atari.AtariEnv("breakout", **options), datasets / "a.a26r")
    (episode,) = play(env, 20)
    env.close()
    to_minari(env.path, "breakout/dict-v0", obs_type="dict")
    dataset = minari.load_dataset("breakout/dict-v0")
    (loaded,) = dataset
    replayed = Replay.load(env.path).make_env(obs_type=options.get("obs_type", "rgb").replace("ram", "rgb"))
    expected = play(atari.wrappers.RamObservation(replayed), 20)[0]["observations"]
    assert set(loaded.observations) == set(expected[0])
    for part, array in loaded.observations.items():
        assert np.array_equal(array, [row[part] for row in expected])
    assert np.array_equal(loaded.actions, episode["actions"])
    recovered = dataset.recover_environment()
    assert (
        recovered.observation_space
        == dataset.observation_space
        == atari.wrappers.RamObservation(replayed).observation_space
    )
    assert recovered.reset(seed=0)[0]["ram"].shape == (128,)

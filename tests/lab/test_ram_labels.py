"""`RamLabels`: values of labels in `info`, of single environments and of vectors."""

import copy
import pickle
from dataclasses import replace

import gymnasium
import numpy as np
import pytest
from env_tools import needs_gymnasium_1
from gymnasium.vector import SyncVectorEnv

import atari
from atari import AtariEnv, AtariVectorEnv
from atari.base.frozen import FrozenDict
from atari.lab import Ram, RamLabels
from atari.lab.ram_labels import LabelValues, VectorRamLabels
from atari.wrappers import FrameStack


def labels_of(ram, game="pong"):
    """The values by `Ram`, whose tests compare them with the game files."""

    class Core:
        def set_ram(self, index, value): ...

        def ram(self):
            return ram

    core = Core()
    core.game = atari.games[game]
    return dict(Ram(core).items())


def row(labels, index, names):
    return {name: int(labels[name][index]) if labels[f"_{name}"][index] else None for name in names}


def test_of_an_environment():
    env = RamLabels(AtariEnv("pong"))
    _, info = env.reset(seed=0)
    assert info["labels"]["ball_x"] is None
    assert "ball_x" not in info["labels"]
    hidden = 0
    for step in range(80):
        info = env.step(step % 6)[-1]
        names = list(env.unwrapped.game.ram_labels)
        assert {name: info["labels"][name] for name in names} == labels_of(env.unwrapped.core.ram())
        hidden += info["labels"]["ball_x"] is None
    assert 0 < hidden < 80
    assert {"lives", "frame_number"} <= set(info)
    with pytest.raises(KeyError, match="no label 'bal_x'; did you mean 'ball_x'"):
        info["labels"]["bal_x"]


def test_of_chosen_labels():
    env = RamLabels(AtariEnv("pong"), labels=["score_player", "player_x"])
    assert env.reset(seed=0)[1]["labels"] == {"score_player": 0, "player_x": 140}
    with pytest.raises(KeyError):
        env.labels()["ball_x"]


def test_copies_snapshots_and_specs():
    env = RamLabels(FrameStack(AtariEnv("pong"), 2), labels=["player_y"])
    env.reset(seed=0)
    other = copy.deepcopy(env)
    data = env.snapshot()
    after = [env.step(action)[-1]["labels"] for action in (2, 3, 2, 2)]
    assert [other.step(action)[-1]["labels"] for action in (2, 3, 2, 2)] == after
    env.restore(data)
    assert [env.step(action)[-1]["labels"] for action in (2, 3, 2, 2)] == after
    values = LabelValues([("a", 1)], ["b"])
    again = pickle.loads(pickle.dumps(values))
    assert again == {"a": 1}
    assert again["b"] is None
    made = gymnasium.make(RamLabels(atari.make("ALE/Pong-v5"), labels=["player_y"]).spec)
    assert made.reset(seed=0)[1]["labels"].keys() == {"player_y"}


@needs_gymnasium_1
def test_under_gymnasiums_vector():
    envs = SyncVectorEnv([lambda: RamLabels(AtariEnv("pong"))] * 2)
    envs.reset(seed=[0, 1])
    seen = set()
    for step in range(60):
        info = envs.step(np.array([2, step % 6]))[-1]["labels"]
        for index, env in enumerate(envs.envs):
            visible = {name for name in env.labels() if info[f"_{name}"][index]}
            assert visible == set(env.labels())
            seen.add("ball_x" in visible)
    assert seen == {True, False}


@pytest.mark.parametrize("mode", ["NextStep", "SameStep", "Disabled"])
def test_of_a_vector_they_are_of_the_observation(mode):
    envs = RamLabels(
        AtariVectorEnv("pong", num_envs=3, obs_type="ram", autoreset_mode=mode, max_num_frames_per_episode=100)
    )
    assert type(envs) is VectorRamLabels
    assert envs.unwrapped.num_envs == 3
    names = list(atari.games["pong"].ram_labels)
    observation, info = envs.reset(seed=0)
    ends = 0
    for step in range(60):
        labels = info["labels"]
        assert labels["ball_x"].dtype == np.int32
        assert labels["_ball_x"].dtype == np.bool_
        assert set(labels) == {*names, *(f"_{name}" for name in names)}
        assert info["_labels"].all()
        for index in range(3):
            assert row(labels, index, names) == labels_of(observation[index])
        if "final_info" in info:
            ends += 1
            final = info["final_info"]["labels"]
            for index in range(3):
                ended = bool(info["_final_info"][index])
                expected = labels_of(info["final_obs"][index]) if ended else dict.fromkeys(names)
                assert row(final, index, names) == expected
        observation, _, terminated, truncated, info = envs.step(np.array([2, 3, step % 6]))
        if mode == "Disabled" and (done := terminated | truncated).any():
            observation, info = envs.reset(options={"reset_mask": done})
    assert (ends > 0) == (mode == "SameStep")


def test_of_a_lost_life_and_restored_states():
    envs = RamLabels(AtariVectorEnv("breakout", num_envs=2, obs_type="ram"), labels=["lives", "ball_y"])
    envs.reset(seed=0)
    saved = envs.snapshot()
    for step in range(40):
        envs.step(np.array([step % 4, 1]))
    envs.restore(None, saved)
    observation, info = envs.observe()
    for index in range(2):
        expected = labels_of(observation[index], "breakout")
        assert row(info["labels"], index, ["lives", "ball_y"]) == {name: expected[name] for name in ("lives", "ball_y")}


def test_of_batches_and_rows():
    envs = RamLabels(AtariVectorEnv("pong", num_envs=4, batch_size=2, num_threads=2, obs_type="ram"), ["player_y"])
    observation, info = envs.reset(seed=0)
    for _ in range(20):
        expected = [labels_of(ram)["player_y"] for ram in observation]
        assert row(info["labels"], 0, ["player_y"])["player_y"] == expected[0]
        assert row(info["labels"], 1, ["player_y"])["player_y"] == expected[1]
        envs.send(np.array([2, 3]))
        observation, _, _, _, info = envs.recv()
    envs.close()
    envs = RamLabels(AtariVectorEnv("pong", num_envs=4, obs_type="ram"), ["player_y"])
    envs.reset(seed=0)
    observation, _, _, _, info = envs.step(np.array([2, 3]), env_id=[3, 1])
    assert info["labels"]["player_y"].tolist() == [labels_of(ram)["player_y"] or 0 for ram in observation]


def test_of_several_games():
    envs = RamLabels(AtariVectorEnv(["pong", "breakout"], obs_type="ram"))
    observation, info = envs.reset(seed=0)
    for index, game in enumerate(("pong", "breakout")):
        names = [name for name in info["labels"] if not name.startswith("_")]
        expected = {**dict.fromkeys(names), **labels_of(observation[index], game)}
        assert row(info["labels"], index, names) == expected
    both = RamLabels(AtariVectorEnv(["pong", "breakout"]), labels=["lives"]).reset(seed=0)[1]["labels"]
    assert both["lives"].tolist() == [0, 5]
    assert both["_lives"].tolist() == [False, True]


def test_names_of_atari_ari():
    env = RamLabels(AtariEnv("seaquest"), names="atari_ari")
    labels = env.reset(seed=0)[1]["labels"]
    ram = env.unwrapped.core.ram()
    assert labels["num_lives"] == ram[59]
    assert labels["score_1"] == ram[58]
    assert labels["enemy_obstacle_x_3"] == ram[33]
    assert len(labels) == 18
    envs = RamLabels(AtariVectorEnv("seaquest", num_envs=2), ["player_x"], names="atari_ari")
    assert envs.reset(seed=0)[1]["labels"]["player_x"].tolist() == envs.ram()[:, 70].tolist()


@needs_gymnasium_1
def test_what_cannot_be_labelled_is_refused():
    unnamed = replace(atari.games["pong"], ram_labels=FrozenDict())
    for make in (lambda game: AtariEnv(game), lambda game: AtariVectorEnv(game, num_envs=2)):
        with pytest.raises(KeyError, match="pong has no label 'bal_x'; did you mean 'ball_x'"):
            RamLabels(make("pong"), labels=["bal_x"])
        with pytest.raises(ValueError, match="there are no labels of pong"):
            RamLabels(make(unnamed))
        with pytest.raises(ValueError, match="AtariARI has no names for alien; it has asteroids"):
            RamLabels(make("alien"), names="atari_ari")
        with pytest.raises(ValueError, match="names must be one of 'game', 'atari_ari', got 'ari'"):
            RamLabels(make("pong"), names="ari")
        for wrong in ("ball_x", [], [3]):
            with pytest.raises(TypeError, match="labels must be a list of names"):
                RamLabels(make("pong"), labels=wrong)
    with pytest.raises(TypeError, match="RamLabels reads the RAM of an AtariEnv or an AtariVectorEnv, got"):
        RamLabels(gymnasium.make("CartPole-v1"))
    with pytest.raises(TypeError, match="in another vector, wrap each environment"):
        RamLabels(SyncVectorEnv([lambda: AtariEnv("pong")]))

"""The preset `multiplayer_dqn` in environments; the forms of GAME and old names."""

from pathlib import Path
from typing import Any

import gymnasium
import numpy as np
import pytest

pytest.importorskip("pettingzoo")
from pettingzoo.test import api_test, parallel_api_test

import atari
import atari.multiplayer
from atari import Task
from atari.multiplayer import MultiplayerCore, env, parallel_env, raw_env
from atari.multiplayer.parallel import MultiplayerEnv

DQN = "multiplayer_dqn"


def test_without_an_indicator_all_agents_see_the_stack() -> None:
    game = MultiplayerEnv("boxing", preset=DQN, frameskip=1, stack_num=2, img_height=110, img_width=80)
    observations, _ = game.reset(seed=1)
    assert observations["first_0"].shape == (110, 80, 2) == game.observation_space("second_0").shape
    assert np.array_equal(observations["first_0"], observations["second_0"])


def test_a_snapshot_of_another_task_is_refused() -> None:
    game = MultiplayerEnv("boxing", preset=DQN, frameskip=(2, 5))
    game.reset(seed=1)
    before = game.core.save()
    for options in ({"frameskip": 4}, {"frameskip": (2, 5), "stack_num": 3}):
        with pytest.raises(ValueError, match=r"the snapshot was taken with (frameskip|stack_num) = "):
            game.restore(MultiplayerEnv("boxing", preset=DQN, **options).snapshot())
    assert game.core.save() == before


def test_pettingzoos_tests_pass_with_the_preset() -> None:
    parallel_api_test(parallel_env("warlords", preset=DQN, agent_indicator=True), num_cycles=100)
    api_test(env("joust", preset=DQN, stack_num=3), num_cycles=30)


@pytest.mark.parametrize("options", [{"preset": DQN}, {"frameskip": 4}])
def test_max_cycles_counts_the_steps_of_agents(options: dict[str, Any]) -> None:
    game = MultiplayerEnv("boxing", max_cycles=6, **options)
    game.reset(seed=1)
    first = game.core.frame_number
    ends = [all(game.step({})[3].values()) for _ in range(6)]
    assert ends == [False] * 5 + [True]
    assert game.core.frame_number == first + 24
    assert game.task.max_episode_steps == game.frame == 6


def test_a_limit_of_frames_truncates() -> None:
    game = MultiplayerEnv("pong", max_num_frames_per_episode=100)
    game.reset(seed=1)
    for _ in range(200):
        _, _, over, cut, _ = game.step({})
        if any(over.values()) or any(cut.values()):
            break
    assert (set(over.values()), set(cut.values())) == ({False}, {True})


FORMS: dict[str, Any] = {
    "pong": "pong",
    "pong_v3": "pong_v3",
    "pettingzoo": "atari/pong-v3",
    "game": atari.games["pong"],
    "task": Task.of("pong", players=2),
    "id": "ALE/Pong-v5",
    "old id": "PongNoFrameskip-v4",
}
ALIKE = {"frameskip": 3, "repeat_action_probability": 0.1, "max_num_frames_per_episode": 500, "seeding": "ale"}


@pytest.mark.parametrize("form", FORMS)
def test_every_form_of_a_game_is_taken_at_every_door(form: str) -> None:
    task = Task.of("pong", players=2, mode=4, **ALIKE)
    several = {"players": 2} if "id" in form else {}
    for made in (MultiplayerEnv, raw_env, env, parallel_env):
        assert made(FORMS[form], **several, **ALIKE, max_episode_steps=None).task == task
    del (alike := dict(ALIKE))["seeding"]
    core = MultiplayerCore(FORMS[form], **several, **alike)
    assert core.task == task.replace(seeding="gymnasium")
    assert (core.mode, core.players, core.frame_skip) == (4, 2, 3)


def test_none_is_what_a_task_says() -> None:
    task = Task.of("pong", players=4, mode=6, difficulty=3, frameskip=1)
    nothing = {"mode": None, "players": None, "difficulty": None}
    assert parallel_env(task, **nothing).task == task
    assert MultiplayerCore(task, **nothing).task == task
    assert MultiplayerCore(task, mode=5).task == task.replace(mode=5)
    assert MultiplayerCore(task, players=2).mode == 4


def test_a_game_file_is_taken(tmp_path: Path) -> None:
    file = tmp_path / "own.toml"
    file.write_text((Path(atari.__file__).parent / "games" / "data" / "pong.toml").read_text())
    for game in (file, str(file)):
        made = parallel_env(game, obs_type="ram", mode=10)
        assert (made.task.definition.file, made.task.mode) == (file, 10)
        made.reset(seed=1)


@pytest.mark.parametrize("game", ["pong", "space_invaders", "maze_craze", "boxing", "warlords", "combat", "joust"])
def test_the_mode_of_a_name_is_one_at_every_door(game: str) -> None:
    task = parallel_env(game).task
    players = task.players
    envs = atari.AtariVectorEnv(game, 1, players=players)
    assert envs.task.mode == envs.lanes[0].mode == task.mode
    assert Task.of(game, players=players).mode == MultiplayerCore(game).mode == task.mode
    assert MultiplayerCore(game).players == players


def test_a_versioned_name_is_a_task() -> None:
    for name, mode, players in (("pong_v3", 4, 2), ("volleyball_pong_v3", 41, 4), ("quadrapong_v4", 33, 4)):
        task = Task.of(name)
        assert (task.game, task.mode, task.players) == ("pong", mode, players)
        assert atari.AtariVectorEnv(name, 1).task.mode == mode
    assert Task.of("pong_v3", players=4).mode == 6
    with pytest.raises(ValueError, match="quadrapong_v4 is for 4 players, got players=2"):
        Task.of("quadrapong_v4", players=2)


def test_unfit_tasks_are_refused() -> None:
    with pytest.raises(ValueError, match="the task of pong is for one player; add players=2"):
        parallel_env(Task.of("pong"))
    with pytest.raises(gymnasium.error.NameNotFound, match="Pong-v5"):
        parallel_env("ALE/Pnog-v5", players=2)
    for options, words in (
        ({"stack_num": 4}, "MultiplayerCore plays frames, and stack_num=4 is of an environment"),
        ({"frameskip": (2, 5)}, "an equal number of frames in each step"),
        ({"max_episode_steps": 5}, "max_episode_steps=5 is of an environment"),
        ({"full_action_space": True}, "actions='full' is of an environment"),
    ):
        with pytest.raises(ValueError, match=words):
            MultiplayerCore("pong", **options)


def test_probabilities_by_player_are_in_the_task() -> None:
    game = parallel_env("boxing", repeat_action_probability=[0.25, 0.5])
    assert game.task.repeat_action_probability == (0.25, 0.5)
    assert Task.from_json(game.task.to_json()) == game.task
    assert "of each player repeats with probability 0.25, 0.5" in str(game.task)
    assert Task.of("boxing", players=2, repeat_action_probability=(0.5, 0.5)).repeat_action_probability == 0.5
    with pytest.raises(ValueError, match="a vector has one for all players"):
        atari.AtariVectorEnv(game.task, 1)


def test_interventions_are_played_and_recorded(tmp_path: Path) -> None:
    from atari.recording import RecordReplay, Replay

    frozen = [{"name": "held", "description": "-", "source": "-", "writes": [{"to": "ball_x", "value": 80}]}]
    core, plain = (MultiplayerCore("pong", **options) for options in ({"interventions": frozen}, {}))
    with RecordReplay(core, tmp_path / "a.a26r") as match:
        match.reset()
        for _ in range(100):
            match.act_players([1, 2])
    assert core.ram()[0x31] == 129
    assert bool(Replay.load(tmp_path / "a.a26r").verify())
    plain.reset()
    with pytest.raises(ValueError, match="was taken with interventions"):
        plain.restore(core.snapshot())

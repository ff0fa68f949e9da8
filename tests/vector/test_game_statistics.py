"""`info` of presets has the whole games' returns, lengths and ends: vector, single and Gymnasium's recorder agree."""

from collections.abc import Callable
from typing import Any

import gymnasium
import numpy as np
import pytest
from env_tools import needs_autoreset_modes
from gymnasium.vector import SyncVectorEnv
from gymnasium.wrappers import RecordEpisodeStatistics

import atari
from atari import wrappers
from atari.base.gymnasium_versions import AutoresetMode

vector: Any = pytest.importorskip("gymnasium.wrappers.vector", reason="Gymnasium 0.29 has no wrappers of vectors")

Game = tuple[float, int]


def single(name: str, game: str, **options: Any) -> gymnasium.Env[Any, Any]:
    """A preset around Gymnasium's recorder around the emulator's frames."""
    raw = atari.AtariEnv(game, **{**wrappers.preset_options(name), **options})
    return wrappers.preset(RecordEpisodeStatistics(raw), name, episodic_life=True, clip_reward=True)


def recorded(env: gymnasium.Env[Any, Any]) -> list[Game]:
    """The games of the recorder in an environment."""
    while not isinstance(env, RecordEpisodeStatistics):
        env = env.env  # type: ignore[attr-defined]
    return list(zip(env.return_queue, env.length_queue, strict=True))


@pytest.mark.parametrize("game", ["breakout", "frogger", "ms_pacman", "space_invaders"])
@pytest.mark.parametrize("name", atari.PRESETS)
def test_single_is_what_the_recorder_records_beneath(name: str, game: str) -> None:
    env = single(name, game, max_num_frames_per_episode=1800)
    rng = np.random.default_rng(1)
    games: list[Game] = []
    score = 0.0
    _, info = env.reset(seed=1)
    for _ in range(500):
        assert ("episode" in info) <= (info["terminated"] or info["episode_frame_number"] >= 1800)
        *_, terminated, truncated, info = env.step(int(rng.integers(env.action_space.n)))
        score += info["reward"]
        assert info["terminated"] == env.unwrapped.core.game_over
        assert info["elapsed_step"] <= info["episode_frame_number"]
        if "episode" in info:
            games.append((info["episode"]["r"], info["episode"]["l"]))
            assert 0 < info["episode"]["t"] < 60
            assert terminated or truncated
        if terminated or truncated:
            _, info = env.reset()
    assert games == recorded(env)
    assert games or name in ("gymnasium", "ale_vector")  # where a lost life begins a new game
    assert score >= sum(points for points, _ in games) - 100 * len(games)


def played(envs: Any, mode: AutoresetMode, actions: Any) -> tuple[list[list[Game]], list[list[tuple[Any, ...]]]]:
    """By environment, the games of `info`, and reward before clipping, steps and game over of each step."""
    games: list[list[Game]] = [[] for _ in range(envs.num_envs)]
    numbers: list[list[tuple[Any, ...]]] = [[] for _ in range(envs.num_envs)]
    envs.reset(seed=5)
    for row in actions:
        _, _, terminated, truncated, info = envs.step(row)
        done = terminated | truncated
        holder = info.get("final_info", {}) if mode == AutoresetMode.SAME_STEP else info
        for index in range(envs.num_envs):
            if "episode" in holder and holder["_episode"][index]:
                assert holder["episode"]["_r"][index]
                games[index].append((holder["episode"]["r"][index], holder["episode"]["l"][index]))
            if not (done[index] and mode == AutoresetMode.SAME_STEP):  # there Gymnasium has those of the reset
                numbers[index].append(tuple(info[key][index] for key in ("reward", "elapsed_step", "terminated")))
        if mode == AutoresetMode.DISABLED and done.any():
            envs.reset(options={"reset_mask": done})
    return games, numbers


@needs_autoreset_modes
@pytest.mark.parametrize("mode", AutoresetMode)
@pytest.mark.parametrize("name", atari.PRESETS)
def test_vector_is_what_gymnasium_makes_of_singles(name: str, mode: AutoresetMode) -> None:
    game = ["breakout", "frogger", "bank_heist"][list(atari.PRESETS).index(name) % 3]

    def make() -> gymnasium.Env[Any, Any]:
        return atari.make(game, preset=name, episodic_life=True, clip_reward=True)

    ours = atari.AtariVectorEnv(
        game, 2, preset=name, episodic_life=True, clip_reward=True, autoreset_mode=mode, num_threads=1
    )
    steps = 900 if game == "bank_heist" else 500  # whole games are played
    actions = np.random.default_rng(2).integers(0, ours.single_action_space.n, (steps, 2))  # type: ignore[attr-defined]
    games, numbers = played(ours, mode, actions)
    assert (games, numbers) == played(SyncVectorEnv([make, make], autoreset_mode=mode), mode, actions)
    assert any(games) or name in ("gymnasium", "ale_vector")


def test_batches_of_fewer() -> None:
    envs = atari.AtariVectorEnv("breakout", 4, batch_size=2, preset="envpool", num_threads=2, obs_type="ram")
    _, info = envs.reset(seed=5)
    rng = np.random.default_rng(0)
    returns, ended = np.zeros(4), 0
    for _ in range(900):
        _, _, terminated, _, info = envs.step(rng.integers(0, 4, 2))
        returns[info["env_id"]] += info["reward"]
        for row in np.flatnonzero(info.get("_episode", [])):
            assert terminated[row]
            assert info["episode"]["r"][row] == returns[info["env_id"][row]]
            returns[info["env_id"][row]], ended = 0, ended + 1
    assert ended >= 4


def test_a_game_that_ends_inside_a_reset() -> None:
    """The last frog has no life left, which ends the episode; the no-ops of DQN's reset then play the game's end."""
    env = single("dqn2015", "frogger")
    _, info = env.reset(seed=0)
    while info["lives"] > 0:
        *_, terminated, _, info = env.step(1)
        assert "episode" not in info
        if terminated and info["lives"] > 0:
            _, info = env.reset(options={"noops": 1})
    assert not info["terminated"]
    _, info = env.reset(options={"noops": 2500})
    assert (info["episode"]["r"], info["episode"]["l"]) == recorded(env)[-1]
    assert (info["elapsed_step"], info["terminated"]) == (0, False)


def test_a_loop_in_the_manner_of_cleanrl() -> None:
    envs = atari.AtariVectorEnv("breakout", 3, autoreset_mode="SameStep", episodic_life=False, num_threads=1)
    envs.reset(seed=0)
    rng = np.random.default_rng(0)
    printed = []
    for _ in range(500):
        _, _, terminated, _, infos = envs.step(rng.integers(0, 4, 3))
        assert "episode" not in infos
        if "final_info" in infos:
            mask = infos["final_info"]["_episode"]
            assert mask.tolist() == terminated.tolist()
            printed += infos["final_info"]["episode"]["r"][mask].tolist()
            frames = infos["final_info"]["episode"]["l"][mask]
            assert frames.tolist() == infos["final_info"]["episode_frame_number"][mask].tolist()
    assert len(printed) >= 3
    assert max(printed) >= 1


def test_a_truncated_game_and_a_lost_life() -> None:
    options: dict[str, Any] = {"autoreset_mode": "SameStep", "num_threads": 1}
    envs = atari.AtariVectorEnv("pong", 2, max_num_frames_per_episode=40, **options)
    envs.reset(seed=0)
    for _ in range(10):
        *_, truncated, info = envs.step(np.zeros(2, int))
    assert truncated.all()
    assert info["final_info"]["_episode"].all()
    assert (info["final_info"]["episode"]["l"] >= 40).all()
    envs = atari.AtariVectorEnv("breakout", 1, life_loss_info=True, **options)
    envs.reset(seed=0)
    terminated = np.zeros(1, bool)
    while not terminated[0]:
        _, _, terminated, _, info = envs.step(np.full(1, 1))
    assert "_episode" not in info["final_info"]  # the game goes on


def short_games(mode: str, num_envs: int = 1) -> atari.AtariVectorEnv:
    """Games of at most 33 frames, with no-ops in which a second one may end; steps of four frames."""
    task = atari.Task.of("pong", noops=(40, 40), max_num_frames_per_episode=33, max_episode_steps=2, obs_type="ram")
    return atari.AtariVectorEnv(task, num_envs, num_threads=1, autoreset_mode=mode)


@needs_autoreset_modes
def test_a_game_that_ends_inside_the_reset_of_a_step_hides_no_other() -> None:
    envs = short_games("SameStep")
    _, info = envs.reset(seed=0)
    assert (info["episode"]["l"].tolist(), info["_episode"].tolist()) == ([33], [True])
    begun = info["episode_frame_number"][0]
    *_, info = envs.step(np.zeros(1, int))
    assert "episode" not in info
    *_, truncated, info = envs.step(np.zeros(1, int))
    assert truncated[0]
    assert info["final_info"]["episode"]["l"].tolist() == [begun + 8]  # the game of the two steps
    assert info["episode"]["l"].tolist() == [33]  # the game of the no-ops after it


@needs_autoreset_modes
def test_a_masked_reset_shows_its_games_and_no_end() -> None:
    envs = short_games("SameStep", 2)
    envs.reset(seed=0)
    for _ in range(2):
        *_, truncated, info = envs.step(np.zeros(2, int))
    assert truncated.all()
    assert info["_final_info"].all()
    _, info = envs.reset(options={"reset_mask": np.array([False, True])})
    assert (info["episode"]["l"].tolist(), info["_episode"].tolist()) == ([0, 33], [False, True])
    assert not {"final_obs", "final_info", "_final_obs", "_final_info"} & {*info}


def test_modes_that_begin_with_the_end_of_a_game_say_so() -> None:
    task = atari.Task("demon_attack", mode=3, obs_type="ram", reward_clipping=True)
    envs, env = atari.AtariVectorEnv(task, 1, num_threads=1), atari.make(task)
    assert envs.reset(seed=0)[1]["terminated"].tolist() == [env.reset(seed=0)[1]["terminated"]] == [True]
    terminated = envs.step(np.zeros(1, int))[2]
    assert terminated[0]
    assert envs.step(np.zeros(1, int))[4]["terminated"].tolist() == [True]  # the reset of the next step


def test_an_observed_end_is_not_counted_again() -> None:
    envs = atari.AtariVectorEnv("breakout", 1, preset="envpool", autoreset_mode="Disabled", num_threads=1)
    _, info = envs.reset(seed=0)
    while "episode" not in info:
        *_, info = envs.step(np.zeros(1, int)) if info["elapsed_step"][0] % 9 else envs.step(np.ones(1, int))
    for _ in range(2):
        *_, info = envs.step(np.zeros(1, int))
        assert "episode" not in info
        assert (info["reward"][0], info["terminated"][0]) == (0, True)
    assert "episode" not in envs.observe()[1]


def test_a_snapshot_of_a_single_environment_has_the_score() -> None:
    env = atari.AtariEnv("pong", frameskip=4)
    env.reset(seed=0)
    for _ in range(100):
        env.step(2)
    state, score = env.snapshot(), env.driver.played.score
    assert score < 0
    other = atari.AtariEnv("pong", frameskip=4)
    other.restore(state)
    assert (other.driver.played.score, other.driver.played.first_frame) == (score, env.driver.played.first_frame)


@pytest.mark.parametrize(
    ("make", "record"),
    [
        (lambda: atari.make("breakout", preset="envpool"), RecordEpisodeStatistics),
        (lambda: atari.AtariVectorEnv("breakout", 1, preset="envpool"), vector.RecordEpisodeStatistics),
    ],
)
def test_gymnasiums_recorder_around_a_preset(make: Callable[[], Any], record: Any) -> None:
    """With another key, as around any environment that has recorded already."""
    env = record(make(), stats_key="seen")
    _, info = env.reset(seed=0)
    step = 0
    while "seen" not in info:
        step += 1
        action = int(step % 9 == 0)
        *_, info = env.step(action if record is RecordEpisodeStatistics else np.array([action]))
    assert info["seen"]["r"] == info["episode"]["r"]
    assert info["seen"]["l"] == info["elapsed_step"] == step


@pytest.mark.parametrize("name", [name for name in atari.PRESETS if name != "multiplayer_dqn"])
def test_gymnasiums_recorder_around_a_preset_has_its_own_record(name: str) -> None:
    env = RecordEpisodeStatistics(atari.make("breakout", preset=name))
    env.action_space.seed(0)
    env.reset(seed=0)
    score, steps, ends = 0.0, 0, 0
    while ends < 3:
        _, reward, terminated, truncated, info = env.step(env.action_space.sample())
        score, steps = score + reward, steps + 1
        assert ("episode" in info) == (terminated or truncated)
        if terminated or truncated:
            assert (info["episode"]["r"], info["episode"]["l"]) == (score, steps)
            score, steps, ends = 0.0, 0, ends + 1
            env.reset()
    assert len(env.length_queue) == 3


@needs_autoreset_modes
@pytest.mark.parametrize("mode", ["NextStep", "SameStep", "Disabled"])
@pytest.mark.parametrize("preset", ["baselines", "dqn2015"])
def test_gymnasiums_recorder_around_a_vector_with_a_preset(mode: str, preset: str) -> None:
    envs = vector.RecordEpisodeStatistics(atari.AtariVectorEnv("breakout", 2, preset=preset, autoreset_mode=mode))
    envs.action_space.seed(0)
    envs.reset(seed=0)
    scores, lengths, ends = np.zeros(2), np.zeros(2, int), 0
    begins = np.zeros(2, bool)
    for _ in range(500):
        _, rewards, terminations, truncations, info = envs.step(envs.action_space.sample())
        skipped = begins if mode == "NextStep" else np.zeros(2, bool)
        scores, lengths = np.where(skipped, 0, scores + rewards), np.where(skipped, 0, lengths + 1)
        done = begins = terminations | truncations
        assert ("episode" in info) == done.any()
        if done.any():
            ends += 1
            np.testing.assert_array_equal(info["episode"]["r"][done], scores[done])
            np.testing.assert_array_equal(info["episode"]["l"][done], lengths[done])
            scores[done], lengths[done] = 0, 0
            if mode == "SameStep" and "episode" in info["final_info"]:
                assert info["final_info"]["episode"]["l"].max() > 100  # whole games, in frames
            if mode == "Disabled":
                envs.reset(options={"reset_mask": done})
    assert ends > 5


def test_whole_games_are_in_info_as_the_option_says() -> None:
    for given, has in ((None, False), (True, True), (False, False)):
        envs = atari.AtariVectorEnv("ALE/Pong-v5", 1, game_info=given)
        assert ("elapsed_step" in envs.reset(seed=0)[1]) == has
    assert "elapsed_step" not in atari.AtariVectorEnv("pong", 1, preset="dqn2015", game_info=False).reset(seed=0)[1]
    with pytest.raises(TypeError, match="game_info must be True or False, got 'yes'"):
        atari.AtariVectorEnv("pong", 1, game_info="yes")  # type: ignore[arg-type]

"""`ReplayMemory` beside environments that make the stacks themselves."""

from typing import Any

import gymnasium
import numpy as np
import pytest
from env_tools import needs_autoreset_modes

import atari
from atari import Task
from atari.base.gymnasium_versions import AutoresetMode
from atari.learning import ReplayMemory

MODES = [AutoresetMode.NEXT_STEP, AutoresetMode.SAME_STEP, AutoresetMode.DISABLED]


def play(
    memory: ReplayMemory, envs: Any, stacked: Any, steps: int, mode: AutoresetMode, copied: bool = False
) -> dict[int, dict[str, Any]]:
    """Play the same in both, and return the transitions of the stacked environments by index."""
    random = np.random.default_rng(0)
    lanes = envs.num_envs
    observations, _ = envs.reset(seed=7)
    before, _ = stacked.reset(seed=7)
    memory.reset(observations)
    waiting = np.zeros(lanes, bool)
    wanted: dict[int, dict[str, Any]] = {}
    for step in range(steps):
        assert np.array_equal(memory.observations().reshape(before.shape), before)
        actions = random.integers(0, envs.single_action_space.n, lanes)
        observations, rewards, terminated, truncated, info = envs.step(
            actions, **({} if copied else {"out": memory.frames()})
        )
        memory.add(actions, rewards, terminated, truncated, info, observations=observations if copied else None)
        after, _, _, _, stacked_info = stacked.step(actions)
        ended = terminated | truncated
        for lane in np.flatnonzero(~waiting):
            final = mode == AutoresetMode.SAME_STEP and ended[lane]
            wanted[step * lanes + lane] = {
                "observations": before[lane],
                "actions": actions[lane],
                "rewards": np.float32(rewards[lane]),
                "next_observations": stacked_info["final_obs"][lane] if final else after[lane],
                "terminations": terminated[lane],
                "truncations": truncated[lane],
            }
        before = np.array(after)
        waiting = ended & (mode == AutoresetMode.NEXT_STEP)
        if mode == AutoresetMode.DISABLED and ended.any():
            reset, _ = envs.reset(options={"reset_mask": ended})
            memory.reset(reset, ended)
            before = np.array(stacked.reset(options={"reset_mask": ended})[0])
    return wanted


def compare(memory: ReplayMemory, wanted: dict[int, dict[str, Any]]) -> None:
    assert len(memory) == len(wanted)
    rows = {index: row for row, index in enumerate(wanted)}
    columns = {name: np.stack([each[name] for each in wanted.values()]) for name in next(iter(wanted.values()))}
    seen = set()
    for _ in range(5):
        batch = memory.sample(len(wanted) // 2)
        chosen = [rows[index] for index in batch.indices.tolist()]
        for name, values in columns.items():
            expected = values[chosen]
            wrong = (getattr(batch, name).reshape(expected.shape) != expected).reshape(len(chosen), -1).any(axis=1)
            assert not wrong.any(), (batch.indices[wrong], name)
        seen.update(chosen)
    assert len(seen) > 0.8 * len(wanted)


@pytest.mark.parametrize("mode", MODES)
@pytest.mark.parametrize("preset", [None, "dqn2015", "machado2018", "gymnasium", "envpool", "ale_vector"])
def test_stacks_are_those_of_the_preset(preset: str | None, mode: AutoresetMode) -> None:
    options = {"num_threads": 1, "autoreset_mode": mode}
    options |= {"episodic_life": True} if preset is None else {"preset": preset}
    envs = atari.AtariVectorEnv("breakout", 3, stack_num=1, **options)
    stacked = atari.AtariVectorEnv("breakout", 3, **options)
    memory = ReplayMemory.for_env(envs, 3000, seed=0)
    wanted = play(memory, envs, stacked, 300, mode)
    assert sum(row["terminations"] for row in wanted.values()) >= 3
    compare(memory, wanted)


@needs_autoreset_modes
@pytest.mark.parametrize("mode", MODES[:2])
def test_a_vector_environment_of_gymnasium(mode: AutoresetMode) -> None:
    def make(stack: int) -> gymnasium.vector.VectorEnv:
        def one() -> gymnasium.Env:
            env = atari.AtariEnv("breakout", frameskip=4, obs_type="grayscale", max_num_frames_per_episode=200)
            return gymnasium.wrappers.FrameStackObservation(env, stack, padding_type="zero")

        return gymnasium.vector.SyncVectorEnv([one, one], autoreset_mode=mode)

    envs, stacked = make(1), make(4)
    memory = ReplayMemory.for_env(envs, 500, seed=0, compress=True)
    compare(memory, play(memory, envs, stacked, 110, mode, copied=True))


def test_a_dict_of_image_and_ram() -> None:
    envs = atari.AtariVectorEnv("pong", 2, stack_num=1, obs_type="dict", autoreset_mode="SameStep")
    memory = ReplayMemory.for_env(envs, 100)
    observations, _ = envs.reset(seed=0)
    memory.reset(observations)
    rams = [observations["ram"].copy()]
    for _ in range(20):
        observations, *rest = envs.step(np.zeros(2, np.int64), out=memory.frames())
        memory.add(np.zeros(2, np.int64), *rest)
        rams.append(observations["ram"].copy())
    batch = memory.sample(50)
    assert batch.observations["image"].shape == (50, 4, 84, 84)
    for i, index in enumerate(batch.indices):
        assert np.array_equal(batch.observations["ram"][i], rams[index // 2][index % 2])
        assert np.array_equal(batch.next_observations["ram"][i], rams[index // 2 + 1][index % 2])


TASKS = [Task.of("pong", preset="dqn2015", stack_num=3), Task.of("pong", preset="envpool", obs_type="ram", stack_num=3)]


@pytest.mark.parametrize("game", ["pong", "ALE/Pong-v5", *TASKS])
def test_a_game_instead_of_environments(game: Any) -> None:
    memory = ReplayMemory.for_env(game, 200, num_envs=2, seed=0)
    task = atari.AtariVectorEnv(game, 2).task
    envs = atari.AtariVectorEnv(task.replace(stack_num=None if task.obs_type == "ram" else 1), 2)
    memory.reset(envs.reset(seed=0)[0])
    for _ in range(30):
        actions = np.zeros(2, np.int64)
        _, rewards, terminations, truncations, info = envs.step(actions, out=memory.frames())
        memory.add(actions, rewards, terminations, truncations, info)
    stacks = atari.AtariVectorEnv(task, 2)
    stacks.reset(seed=0)
    for _ in range(30):
        expected = stacks.step(np.zeros(2, np.int64))[0]
    assert np.array_equal(memory.observations().reshape(expected.shape), expected)
    with pytest.raises(TypeError, match="num_envs is needed"):
        ReplayMemory.for_env(game, 200)
    with pytest.raises(TypeError, match="num_envs is an option of new environments, and these exist"):
        ReplayMemory.for_env(envs, 200, num_envs=2)


def test_environments_that_do_not_fit() -> None:
    for options, text in (
        ({}, "stack_num=1"),
        ({"stack_num": 1, "channels_last": True}, "channels_last"),
        ({"stack_num": 1, "life_loss_info": True}, "life_loss_info"),
        ({"stack_num": 1, "preset": "envpool", "episodic_life": True}, "episodic_life"),
        ({"stack_num": 1, "batch_size": 1}, "batch_size"),
        ({"stack_num": 2, "obs_type": "ram"}, "stack_num=None, not 2"),
    ):
        with pytest.raises(ValueError, match=text):
            ReplayMemory.for_env(atari.AtariVectorEnv("pong", 2, **options), 100)
    with pytest.raises(TypeError, match="uint8"):
        ReplayMemory.for_env(gymnasium.make_vec("CartPole-v1", 2), 100)


@pytest.mark.parametrize("name", ["RecordEpisodeStatistics", "DictInfoToList", "TransformReward"])
def test_behind_a_wrapper_the_memory_stores_the_same(name: str) -> None:
    needs_autoreset_modes()
    wrapper: Any = getattr(gymnasium.wrappers.vector, name)
    given = [lambda reward: reward] if name == "TransformReward" else []
    options: Any = {"preset": "dqn2015", "max_num_frames_per_episode": 120, "autoreset_mode": "SameStep"}
    wrapped = wrapper(atari.AtariVectorEnv("breakout", 3, stack_num=1, **options), *given)
    stacked = atari.AtariVectorEnv("breakout", 3, **options)
    memory = ReplayMemory.for_env(wrapped, 400, final_frames=20)
    wanted = play(memory, wrapped, stacked, 100, AutoresetMode.SAME_STEP, copied=True)
    assert any(each["truncations"] or each["terminations"] for each in wanted.values())
    compare(memory, wanted)


def test_rows_say_their_environment() -> None:
    games = ["pong", "breakout", "freeway"]
    envs = atari.AtariVectorEnv(games, stack_num=1, preset="machado2018")
    memory = ReplayMemory.for_env(envs, 300)
    memory.reset(envs.reset(seed=0)[0])
    for _ in range(40):
        memory.add(np.arange(3), *envs.step(np.zeros(3, np.int64), out=memory.frames())[1:])
    batch, sequences = memory.sample(50), memory.sample_sequences(50, 2)
    assert np.array_equal(batch.env_id, batch.actions)  # each environment has its own action
    assert np.array_equal(sequences.env_id, sequences.actions[:, 0])
    assert set(batch.env_id.tolist()) == {0, 1, 2}

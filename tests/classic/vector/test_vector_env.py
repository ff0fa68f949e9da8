"""Several environments at once: in this process, and in processes of their own."""

import gc
import multiprocessing
import sys
import threading
from collections.abc import Callable, Iterator
from contextlib import closing
from typing import Any

import gymnasium
import numpy as np
import pytest

import atari.classic as gym
from atari.classic.vector import AsyncVectorEnv, SyncVectorEnv, VectorEnv, VectorEnvWrapper
from atari.classic.vector.utils import write_to_shared_memory


class Counter(gym.Env):
    """Counts to `end`; a negative action is an error."""

    metadata = {"render.modes": ["ansi"]}  # noqa: RUF012
    action_space = gym.spaces.Discrete(3)
    observation_space = gym.spaces.Dict({"n": gym.spaces.Box(0, 9, (1,)), "odd": gym.spaces.Discrete(2)})

    def __init__(self, end: int = 2) -> None:
        self.end, self.begin = end, 0

    def seed(self, seed: int | None = None) -> list[int]:
        self.begin = seed or 0
        return [self.begin]

    def reset(self) -> Any:
        self.n = self.begin
        return self._see()

    def step(self, action: Any) -> Any:
        if action < 0:
            raise ZeroDivisionError(f"no action {action}")
        self.n += int(action)
        return self._see(), self.n, self.n >= self.end, {"n": self.n}

    def twice(self, number: int) -> int:
        return 2 * number

    def _see(self) -> Any:
        return {"n": np.array([self.n], np.float32), "odd": self.n % 2}


@pytest.fixture(params=[SyncVectorEnv, AsyncVectorEnv])
def kind(request: pytest.FixtureRequest) -> Iterator[Callable[..., VectorEnv]]:
    return request.param  # type: ignore[no-any-return]


def test_steps_begin_new_episodes(kind: Any) -> None:
    with closing(kind([lambda: Counter(2), lambda: Counter(9)])) as envs:
        assert (envs.num_envs, envs.is_vector_env, envs.metadata) == (2, True, Counter.metadata)
        assert envs.single_observation_space == Counter.observation_space
        assert repr(envs.action_space) == "Tuple(Discrete(3), Discrete(3))"
        assert envs.seed([1, 0]) == [[1], [0]]
        first = envs.reset()
        assert (first["n"].tolist(), first["odd"].tolist()) == ([[1], [0]], [1, 0])
        observations, rewards, dones, infos = envs.step([1, 2])
        assert (rewards.dtype, rewards.tolist()) == (np.float64, [2, 2])
        assert (dones.dtype, dones.tolist()) == (np.bool_, [True, False])
        assert observations["n"].tolist() == [[1], [2]]
        assert infos[0]["terminal_observation"]["n"].tolist() == [2]
        assert infos[1] == {"n": 2}


def test_both_kinds_play_the_same_games() -> None:
    functions = [lambda: gym.make("PongNoFrameskip-v4"), lambda: gym.make("Pong-v4")]
    with closing(SyncVectorEnv(functions)) as here, closing(AsyncVectorEnv(functions)) as there:
        for envs in (here, there):
            envs.seed(3)
        np.testing.assert_array_equal(here.reset(), there.reset())
        for actions in ([2, 3], np.array([0, 5])):
            for ours, theirs in zip(here.step(actions)[:3], there.step(actions)[:3], strict=True):
                np.testing.assert_array_equal(ours, theirs)


def test_methods_and_attributes(kind: Any) -> None:
    with closing(kind([Counter, lambda: Counter(5)])) as envs:
        assert (envs.get_attr("end"), envs.call("twice", 4), envs.call("twice", number=5)) == ([2, 5], [8, 8], [10, 10])


def test_given_spaces(kind: Any) -> None:
    space = gym.spaces.Box(0, 5, (1,))
    with closing(kind([lambda: gym.make("CartPole-v1")] * 2, action_space=space, copy=False)) as envs:
        assert envs.single_action_space is space
        assert envs.single_observation_space.shape == (4,)


def test_statistics_of_a_vector(kind: Any) -> None:
    envs: Any = gym.wrappers.RecordEpisodeStatistics(kind([lambda: Counter(2), lambda: Counter(9)]), deque_size=3)
    envs.reset()
    ended = [info["episode"] for _ in range(4) for info in envs.step([2, 1])[3] if "episode" in info]
    assert [(each["r"], each["l"]) for each in ended] == [(2.0, 1)] * 4
    assert (list(envs.return_queue), list(envs.length_queue), envs.episode_count) == ([2.0] * 3, [1] * 3, 4)
    assert (envs.episode_returns.tolist(), envs.episode_lengths.tolist()) == ([0, 1 + 2 + 3 + 4], [0, 4])
    envs.close()


def test_an_error_of_an_environment_is_raised(kind: Any) -> None:
    with closing(kind([Counter, Counter])) as envs:
        envs.reset()
        with pytest.raises(ZeroDivisionError, match=r"^no action -1$"):
            envs.step([1, -1])


def test_wrong_numbers(kind: Any) -> None:
    with pytest.raises(ValueError, match=r"^a vector has one environment or more, got no function that makes one$"):
        kind([])
    with closing(kind([Counter, Counter])) as envs:
        envs.reset()
        with pytest.raises(ValueError, match=r"^there are 2 environments, got 3 actions$"):
            envs.step([0, 1, 1])
        with pytest.raises(ValueError, match=r"^there are 2 environments, got 1 seeds$"):
            envs.seed([0])
        with pytest.raises(gymnasium.error.Error, match=r"^step_wait\(\) came before step_async\(actions\)"):
            envs.step_wait()


def test_a_failed_construction_is_raised() -> None:
    def fail() -> gym.Env:
        raise LookupError("no such environment")

    for kind in (SyncVectorEnv, AsyncVectorEnv):
        with pytest.raises(LookupError, match=r"^no such environment$"):
            kind([Counter, fail])
    assert multiprocessing.active_children() == []


@pytest.mark.parametrize("asynchronous", [False, True])
def test_make(asynchronous: bool) -> None:
    def shorten(env: gym.Env) -> gym.Env:
        return gym.wrappers.TimeLimit(env, 2)

    with closing(gym.vector.make("CartPole-v1", 2, asynchronous, wrappers=[shorten])) as envs:
        assert isinstance(envs, AsyncVectorEnv if asynchronous else SyncVectorEnv)
        assert envs.spec is not None
        assert envs.spec.id == "CartPole-v1"
        envs.seed(0)
        assert envs.reset().shape == (2, 4)
        assert [envs.step([0, 1])[2].tolist() for _ in range(2)] == [[False, False], [True, True]]


def test_closing_twice_ends_the_processes() -> None:
    envs = AsyncVectorEnv([Counter] * 2)
    processes = list(envs.processes)
    envs.close()
    envs.close()
    assert [process.exitcode for process in processes] == [0, 0]


def test_a_killed_process_is_an_error() -> None:
    with closing(AsyncVectorEnv([Counter] * 2)) as envs:
        envs.reset()
        envs.processes[1].kill()
        envs.processes[1].join()
        with pytest.raises(gymnasium.error.Error, match=r"^the vector is closed, or one of its processes has ended; "):
            envs.get_attr("end")


def test_a_closed_vector_of_processes_is_an_error() -> None:
    envs = AsyncVectorEnv([Counter] * 2)
    envs.close(terminate=True)
    with pytest.raises(gymnasium.error.Error, match=r"^the vector is closed, or one of its processes has ended; "):
        envs.reset()


def test_an_ended_process_leaves_no_buffer_to_the_garbage_collector(monkeypatch: pytest.MonkeyPatch) -> None:
    """CPython 3.13 reports the buffer of a pipe that is found in a cycle, as the error and the local variables of a caller are."""
    reports: list[Any] = []
    monkeypatch.setattr(sys, "unraisablehook", reports.append)
    envs = AsyncVectorEnv([Counter, Counter])
    envs.reset()
    for process in envs.processes:
        process.kill()
        process.join()
    cycle: list[Any] = []
    try:
        envs.step([0, 0])
    except gymnasium.error.Error as error:
        cycle += [cycle, error]
    assert len(cycle) == 2
    envs.close(terminate=True)
    del cycle
    gc.collect()
    assert reports == []


def test_a_wrapper_of_vectors(kind: Any) -> None:
    class Doubled(VectorEnvWrapper):
        def step_wait(self, **options: Any) -> Any:
            observations, rewards, dones, infos = self.env.step_wait(**options)
            return observations, 2 * rewards, dones, infos

    with closing(Doubled(kind([Counter, lambda: Counter(5)]))) as envs:
        assert (envs.num_envs, envs.seed(1), envs.get_attr("end")) == (2, [[1], [2]], [2, 5])
        assert envs.reset()["n"].tolist() == [[1], [2]]
        assert envs.step([0, 1])[1].tolist() == [2, 6]
        envs.set_attr("end", [7, 8])
        assert envs.get_attr("end") == [7, 8]
        with pytest.raises(ValueError, match=r"^there are 2 environments, got 1 values$"):
            envs.set_attr("end", [7])
    assert envs.env.closed
    with pytest.raises(TypeError, match=r"^a VectorEnvWrapper goes around a vector"):
        VectorEnvWrapper(Counter())  # type: ignore[arg-type]


def test_a_pending_step() -> None:
    with closing(AsyncVectorEnv([Counter] * 2)) as envs:
        envs.reset()
        envs.step_async([0, 1])
        with pytest.raises(gymnasium.error.AlreadyPendingCallError, match=r"^step_async\(\) is not finished"):
            envs.reset_async()
        assert envs.step_wait(timeout=60)[1].tolist() == [0, 1]
        with pytest.raises(gymnasium.error.NoAsyncCallError, match=r"^reset_wait\(\) came before reset_async\(\)"):
            envs.reset_wait()


def test_a_step_that_takes_too_long() -> None:
    class Slow(Counter):
        def step(self, action: Any) -> Any:
            if action == 2:
                threading.Event().wait()  # for ever
            return super().step(action)

    envs = AsyncVectorEnv([Slow, Slow])
    envs.reset()
    envs.step_async([0, 2])
    with pytest.raises(multiprocessing.TimeoutError, match=r"^step_wait\(\) took longer than 0.01 seconds$"):
        envs.step_wait(timeout=0.01)
    envs.close(terminate=True)
    assert not any(process.is_alive() for process in envs.processes)


@pytest.mark.parametrize("is_shared", [False, True])
def test_a_worker_of_a_script(is_shared: bool) -> None:
    with closing(AsyncVectorEnv([Counter] * 2, worker=_worker, shared_memory=is_shared)) as envs:
        envs.seed(1)
        assert envs.reset()["n"].tolist() == [[1], [2]]
        observations, rewards, dones, _ = envs.step([1, 2])
        assert (observations["n"].tolist(), rewards.tolist(), dones.tolist()) == ([[2], [4]], [2, 4], [True, True])
        with pytest.raises(ZeroDivisionError, match=r"^no action -1$"):
            envs.step([-1, 0])


def _worker(index: int, env_fn: Any, pipe: Any, parent_pipe: Any, shared_memory: Any, error_queue: Any) -> None:
    """As in scripts for Gym 0.17 to 0.26; it does not begin new episodes."""
    env = env_fn()
    parent_pipe.close()

    def shown(observation: Any) -> Any:
        if shared_memory is None:
            return observation
        write_to_shared_memory(index, observation, shared_memory, env.observation_space)
        return None

    try:
        while True:
            command, data = pipe.recv()
            if command == "close":
                pipe.send((None, True))
                break
            if command == "step":
                observation, *others = env.step(data)
                pipe.send(((shown(observation), *others), True))
            else:
                pipe.send((shown(env.reset()) if command == "reset" else env.seed(data), True))
    except Exception:
        error_queue.put((index, *sys.exc_info()[:2]))
        pipe.send((None, False))

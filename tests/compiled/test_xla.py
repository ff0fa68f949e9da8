"""`atari.integrations.jax.xla`: inside compiled functions environments play as `step` does, to the byte."""

import gc
import os
import threading
from collections.abc import Iterator
from contextlib import suppress
from typing import Any

import numpy as np
import pytest

import atari
import atari.integrations.envpool as envpool
from atari.integrations.jax import xla

os.environ.setdefault("JAX_PLATFORMS", "cpu")
jax = pytest.importorskip("jax", reason="needs JAX, which scripts/test --jax installs")

Failure = jax.errors.JaxRuntimeError
QUICK_ENDS = {"max_num_frames_per_episode": 60}


def make(game: Any = "breakout", num_envs: int | None = 2, **options: Any) -> atari.AtariVectorEnv:
    return atari.AtariVectorEnv(game, num_envs, **{**QUICK_ENDS, **options})


def started(**options: Any) -> tuple[Any, ...]:
    """Environments with observations of RAM after a reset, and their handle, `recv`, `send` and `step`."""
    envs = make(**{"obs_type": "ram", **options})
    envs.reset(seed=0)
    return envs, *xla(envs, callback=False)


def fails(text: str, call: Any, *arguments: Any) -> None:
    with pytest.raises(Failure, match=text):
        jax.block_until_ready(call(*arguments))


def rollout(step: Any, handle: Any, actions: Any) -> Any:
    return jax.jit(lambda handle, actions: jax.lax.scan(step, handle, actions))(handle, actions)


def leaves(value: Any, prefix: str = "") -> Iterator[tuple[str, Any]]:
    pairs = value.items() if isinstance(value, dict) else enumerate(value) if isinstance(value, tuple) else None
    if pairs is None:
        yield prefix, np.asarray(value)
    else:
        for name, part in pairs:
            yield from leaves(part, f"{prefix}.{name}")


def assert_rows_equal(twin: Any, actions: Any, results: Any) -> int:
    """That the results of a scan are those of the twin's steps; returns how many of its episodes ended."""
    ends = 0
    got = dict(leaves(results))
    for row, action in enumerate(actions):
        expected = twin.step(action)
        ends += int((expected[2] | expected[3]).sum())
        own = dict(leaves(expected))
        for name, array in got.items():
            if name in own:
                np.testing.assert_array_equal(array[row], own[name], name)
            else:  # of final observations, when none ended
                assert ".final_" in name or "._final_" in name
                assert not array[row].any(), name
    return ends


CASES: dict[str, dict[str, Any]] = {
    "disabled": {"autoreset_mode": "Disabled"},
    "image and RAM": {"obs_type": "dict", "autoreset_mode": "SameStep"},
    "preset": {"preset": "envpool", "max_num_frames_per_episode": 108_000},
    "preset, same step": {"preset": "dqn2015", "autoreset_mode": "SameStep", "max_num_frames_per_episode": 108_000},
    "RGB, channels last": {"grayscale": False, "channels_last": True},
    "channels last": {"channels_last": True, "autoreset_mode": "SameStep"},
    "float32": {"dtype": "float32"},
    "life loss": {"life_loss_info": True, "autoreset_mode": "SameStep"},
    "games": {"game": ["breakout", "pong"], "num_envs": None},
    "players": {"game": "pong", "players": 2},
    "threads": {"num_threads": 2},
    "reward": {"reward": "0.25 * ram[0x90] - 5 * lives_lost", "reward_clipping": False, "autoreset_mode": "SameStep"},
    **{
        f"{obs_type} of {num_envs}, {mode}": {"obs_type": obs_type, "num_envs": num_envs, "autoreset_mode": mode}
        for obs_type in ("ram", "grayscale")
        for num_envs in (1, 64)
        for mode in ("NextStep", "SameStep")
    },
}


@pytest.mark.parametrize("callback", [False, True], ids=["ffi", "callback"])
@pytest.mark.parametrize("case", CASES)
def test_a_scan_is_as_many_steps(case: str, callback: bool) -> None:
    envs, twin = (make(**CASES[case]) for _ in range(2))
    handle, _, _, step = xla(envs, callback=callback)
    actions = np.random.default_rng(0).integers(3, size=(100, *envs.action_space.shape))
    for env in (envs, twin):
        env.reset(seed=3)
    handle, results = rollout(step, handle, actions)
    ends = assert_rows_equal(twin, actions, results)
    assert ends >= 5 * envs.num_envs or "preset" in CASES[case] or case == "disabled"
    if case != "disabled" and not isinstance(results[0], dict):  # Python goes on from there
        assert_rows_equal(twin, actions[:1], tuple(np.asarray(part)[None] for part in envs.step(actions[0])[:4]))


@pytest.mark.parametrize("callback", [False, True], ids=["ffi", "callback"])
@pytest.mark.parametrize("batch_size", [0, 2])
def test_send_and_recv(batch_size: int, callback: bool) -> None:
    envs, twin = (make(num_envs=4, batch_size=batch_size, num_threads=1, obs_type="ram") for _ in range(2))
    handle, recv, send, step = xla(envs, callback=callback)
    for env in (envs, twin):
        env.reset_async(seed=0)
    handle, results = jax.jit(recv)(handle)
    np.testing.assert_array_equal(results[0], twin.recv()[0])
    for i in range(20):
        env_id = results[4]["env_id"][::-1]
        actions = np.arange(len(env_id)) % 4
        if i % 2:
            handle, results = recv(send(handle, actions, env_id))
        else:
            handle, results = jax.jit(step)(handle, actions, env_id)
        expected = twin.step(actions, env_id=np.asarray(env_id))
        np.testing.assert_array_equal(results[0], expected[0])
        np.testing.assert_array_equal(results[4]["env_id"], expected[4]["env_id"])
    envs.step(np.zeros(len(env_id), int))  # not refused: all has been received


def test_what_one_begins_the_other_does_not_disturb() -> None:
    envs, handle, recv, send, step = started()
    handle = send(handle, np.zeros(2, int))
    jax.block_until_ready(handle)
    with pytest.raises(RuntimeError, match="receive it first"):
        envs.step(np.zeros(2, int))
    fails("receive it first", step, handle, np.zeros(2, int))
    with pytest.raises(RuntimeError, match="being played"):
        envs.snapshot()
    handle, _ = recv(handle)
    jax.block_until_ready(handle)
    assert envs.snapshot()
    fails("nothing has been sent", recv, handle)
    envs.send(np.zeros(2, int))
    handle, results = recv(handle)
    np.testing.assert_array_equal(results[0], envs.ram())
    envs.step(np.zeros(2, int))


class TestRefusals:
    def test_a_handle_of_a_closed_environment(self) -> None:
        envs, handle, _, _, step = started()
        step, actions = jax.jit(step), np.zeros(2, int)
        step(handle, actions)
        envs.close()
        fails("no environment of this handle", step, handle, actions)
        envs.reset(seed=0)
        handle, *_ = xla(envs, callback=False)
        jax.block_until_ready(step(handle, actions))
        del envs
        gc.collect()
        fails("no environment of this handle", step, handle, actions)

    @pytest.mark.parametrize("handle", [np.zeros(8, np.uint8), np.full(8, 255, np.uint8)])
    def test_an_unknown_handle(self, handle: Any) -> None:
        _, recv, send, step = xla(make(), callback=False)
        for call, *actions in ((step, np.zeros(2, int)), (send, np.zeros(2, int)), (recv,)):
            fails("no environment of this handle", call, handle, *actions)

    @pytest.mark.parametrize("handle", [np.zeros(8, np.int32), np.zeros(7, np.uint8), 3])
    def test_no_handle(self, handle: Any) -> None:
        _, recv, _, _ = xla(make(), callback=False)
        with pytest.raises((TypeError, ValueError, Failure)):
            jax.block_until_ready(recv(handle))

    def test_a_handle_of_another_kind_of_environment(self) -> None:
        _, _, _, step = xla(make(obs_type="ram"), callback=False)
        for options in ({"num_envs": 3}, {"obs_type": "grayscale"}, {"autoreset_mode": "SameStep"}):
            other, handle, *_ = started(**options)
            before = other.ram()
            fails(r"result|action", step, handle, np.zeros(2, int))
            np.testing.assert_array_equal(other.ram(), before)

    @pytest.mark.parametrize("callback", [False, True])
    @pytest.mark.parametrize(
        ("actions", "error"),
        [
            (np.zeros(2), TypeError),
            ("no", TypeError),
            (np.zeros(3, int), ValueError),
            (np.zeros((2, 1), int), ValueError),
        ],
    )
    def test_actions_of_another_kind(self, actions: Any, error: type[Exception], callback: bool) -> None:
        envs = make(obs_type="ram")
        handle, _, send, step = xla(envs, callback=callback)
        envs.reset(seed=0)
        before = envs.ram()
        for function in (send, step, jax.jit(step)):
            with pytest.raises(error):
                function(handle, actions)
        np.testing.assert_array_equal(envs.ram(), before)

    @pytest.mark.parametrize("dtype", [np.int8, np.uint8, np.int16, np.uint16, np.int32, np.uint32])
    def test_actions_out_of_range_of_every_integer_dtype(self, dtype: Any) -> None:
        envs, handle, _, _, step = started()
        before = envs.ram()
        for wrong in (4, np.iinfo(dtype).max, np.iinfo(dtype).min or 100):
            fails(r"is not within 0\.\.3", step, handle, np.array([1, wrong], dtype))
        np.testing.assert_array_equal(envs.ram(), before)
        jax.block_until_ready(step(handle, np.array([1, 3], dtype)))

    def test_env_id(self) -> None:
        envs, handle, _, send, _ = started(num_envs=3)
        for env_id in ([0, 1, 3], [0, 1, 1], [0, 1, -1]):
            fails(r"does not exist|given twice", send, handle, np.zeros(3, int), np.array(env_id))
        envs.step(np.zeros(3, int))

    def test_before_the_first_reset(self) -> None:
        envs = make()
        handle, _, _, step = xla(envs, callback=False)
        fails(r"call envs\.reset", step, handle, np.zeros(2, int))

    @pytest.mark.parametrize(
        ("options", "callback", "error", "text"),
        [
            ({"continuous": True}, None, ValueError, "continuous"),
            ({"game": "pong", "players": 2, "agent_indicator": True}, None, ValueError, "agent_indicator"),
            ({}, 1, TypeError, "callback"),
        ],
    )
    def test_options_of_no_compiled_function(
        self, options: Any, callback: Any, error: type[Exception], text: str
    ) -> None:
        with pytest.raises(error, match=text):
            xla(make(**options), callback=callback)

    def test_a_port_that_goes_with_a_step_in_flight(self) -> None:
        envs, handle, _, send, _ = started(num_envs=8, num_threads=2)
        jax.block_until_ready(send(handle, np.zeros(8, int)))
        envs._port = None
        for call in (
            lambda: envs.step(np.zeros(8, int)),
            lambda: envs.reset(options={"reset_mask": np.arange(8) < 7}),
            envs.observe,
        ):
            with pytest.raises(RuntimeError, match=r"reset all environments|must reset every environment"):
                call()
        envs.reset(seed=0)
        envs.step(np.zeros(8, int))


def test_python_waits_for_a_function_that_runs() -> None:
    envs, twin = (make(num_envs=16, num_threads=1) for _ in range(2))
    handle, _, _, step = xla(envs, callback=False)
    actions = np.zeros((50, 16), int)
    for env in (envs, twin):
        env.reset(seed=0)
    compiled = jax.jit(lambda handle: jax.lax.scan(step, handle, actions)).lower(handle).compile()
    results = compiled(handle)  # perhaps returns before its end
    for _ in range(20):
        envs.ram()
        envs.get_attr("lives")
    jax.block_until_ready(results)
    for row in actions:
        twin.step(row)
    np.testing.assert_array_equal(envs.ram(), twin.ram())


def test_a_chain_runs_once_and_in_order_though_results_are_unused() -> None:
    envs, twin = (make(obs_type="ram") for _ in range(2))
    handle, _, _, step = xla(envs, callback=False)

    @jax.jit
    def play(handle: Any) -> Any:
        for action in (1, 2, 3, 1):
            handle, _ = step(handle, np.full(2, action))
        return handle

    for env in (envs, twin):
        env.reset(seed=0)
    jax.block_until_ready(play(handle))
    for action in (1, 2, 3, 1):
        twin.step(np.full(2, action))
    np.testing.assert_array_equal(envs.ram(), twin.ram())


@pytest.mark.parametrize("env_type", ["gym", "gymnasium"])
def test_envpool(env_type: str) -> None:
    options = {"num_envs": 4, "episodic_life": True, "reward_clip": True, "seed": 1}
    envs, twin = (envpool.make("Breakout-v5", env_type, **options) for _ in range(2))
    handle, _, _, step = envs.xla()
    for env in (envs, twin):
        env.reset()
    actions = np.random.default_rng(0).integers(4, size=(200, 4))
    _, results = rollout(step, handle, actions)
    got = dict(leaves(results))
    for row, action in enumerate(actions):
        expected = dict(leaves(twin.step(action)))
        assert set(got) == set(expected)
        for name, array in expected.items():
            np.testing.assert_array_equal(got[name][row], array, name)
            assert got[name].dtype == array.dtype


def test_a_page_locked_array_is_written_in_place() -> None:
    from atari.integrations.jax.callback import pinned_arrays

    arrays = pinned_arrays(jax.ShapeDtypeStruct((2, 4, 84, 84), np.uint8))
    if arrays is None:
        pytest.skip("JAX's default device has no memory of the kind 'pinned_host'")
    envs = make()
    envs.reset(seed=0)
    observation, *_ = envs.step(np.zeros(2, int), out=arrays[0])
    assert observation is arrays[0]
    assert observation.any()
    assert not arrays[1].any()


def test_an_environment_closed_while_a_function_runs() -> None:
    actions = np.zeros((200, 8), int)
    for wait in range(6):
        envs, handle, _, _, step = started(num_envs=8, num_threads=2)
        compiled = jax.jit(
            lambda handle, step=step: jax.lax.scan(lambda h, a: (step(h, a)[0], None), handle, actions)[0]
        )
        closer = threading.Timer(0.003 * wait, envs.close)
        closer.start()
        with suppress(Failure):  # or it has ended before
            jax.block_until_ready(compiled(handle))
        closer.join()
        fails("no environment of this handle", compiled, handle)

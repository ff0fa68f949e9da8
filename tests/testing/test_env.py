"""`check_env`: environments with one fault each, and the sentence that each gets.

`tests/wrappers/test_contract.py` has our wrappers and presets, `test_atari_env.py` `AtariEnv` itself.
"""

import warnings
from collections.abc import Callable
from typing import Any

import gymnasium
import numpy as np
import pytest
from env_tools import needs_gymnasium_1
from gymnasium import spaces

import atari
from atari.testing import ContractError, check_env

Step = tuple[Any, Any, bool, bool, dict[str, Any]]


def pong(**options: Any) -> gymnasium.Env[Any, Any]:
    return atari.make("ALE/Pong-v5", obs_type="ram", max_episode_steps=25, **options)


class Faulty(gymnasium.Wrapper[Any, Any, Any, Any], gymnasium.utils.RecordConstructorArgs):
    """The base of wrappers with a fault; without one it passes."""

    def __init__(self, env: gymnasium.Env[Any, Any]) -> None:
        gymnasium.utils.RecordConstructorArgs.__init__(self)
        super().__init__(env)


class IgnoresSeed(Faulty):
    def reset(self, *, seed: int | None = None, options: Any = None) -> Any:
        self.offset = np.random.default_rng().integers(1000)
        observation, info = self.env.reset(seed=seed, options=options)
        return observation, {**info, "offset": self.offset}


class KeepsCounting(Faulty):
    count = 0

    def step(self, action: Any) -> Step:
        self.count += 1
        *result, info = self.env.step(action)
        return (*result, {**info, "count": self.count})  # type: ignore[return-value]


def stepping(name: str, step: Callable[..., Any]) -> type[Faulty]:
    """The class of wrappers with another `step`, a function of the wrapper and the action; specs find it by its name."""
    return type(name, (Faulty,), {"step": step})


def changed(name: str, change: Callable[..., Any]) -> type[Faulty]:
    """The class of wrappers whose `step` returns what a function makes of the environment's results."""
    return stepping(name, lambda self, action: change(*self.env.step(action)))


OtherShape = changed("OtherShape", lambda seen, *rest: (seen[:127], *rest))
OtherFinalDtype = changed("OtherFinalDtype", lambda seen, *rest: (seen.astype(np.int64) if rest[2] else seen, *rest))
ArrayOfReward = changed("ArrayOfReward", lambda seen, reward, *rest: (seen, np.array([reward]), *rest))
InfiniteReward = changed("InfiniteReward", lambda seen, reward, *rest: (seen, float("inf"), *rest))
HidesTheEnd = changed(
    "HidesTheEnd", lambda seen, reward, terminated, truncated, info: (seen, reward, False, False, info)
)
TakesAnyAction = stepping(
    "TakesAnyAction", lambda self, action: self.env.step(action if action in self.action_space else 0)
)
OldLives = changed("OldLives", lambda *results: (*results[:4], {**results[4], "lives": 7}))


class OtherDtype(Faulty):
    def __init__(self, env: gymnasium.Env[Any, Any]) -> None:
        super().__init__(env)
        self.observation_space = spaces.Box(0, 255, (128,), np.float32)


class ReusesArray(Faulty):
    def __init__(self, env: gymnasium.Env[Any, Any]) -> None:
        super().__init__(env)
        self.kept = np.zeros(128, np.uint8)
        self.turn = 0

    def step(self, action: Any) -> Step:
        observation, *rest = self.env.step(action)
        self.turn += 1
        if self.turn % 5:  # Gymnasium compares two results, one after the other
            return (observation, *rest)  # type: ignore[return-value]
        self.kept[:] = observation
        return (self.kept, *rest)  # type: ignore[return-value]


class PlaysBeforeItChecks(atari.AtariEnv):
    def step(self, action: Any) -> Step:
        if self.driver.phase == "playing" and action not in self.action_space:
            super().step(0)
        return super().step(action)


class ResetsItself(Faulty):
    def reset(self, *, seed: int | None = None, options: Any = None) -> Any:
        self.begun = True
        return self.env.reset(seed=seed, options=options)

    def step(self, action: Any) -> Step:
        if not vars(self).get("begun"):
            self.reset()
        return self.env.step(action)


class HasLambda(Faulty):
    def __init__(self, env: gymnasium.Env[Any, Any]) -> None:
        super().__init__(env)
        self.function = lambda: 0


class ForgetsCount(KeepsCounting):
    """Its copies begin to count again, as resets do."""

    def reset(self, *, seed: int | None = None, options: Any = None) -> Any:
        self.count = 0
        return self.env.reset(seed=seed, options=options)

    def __getstate__(self) -> dict[str, Any]:
        return {**vars(self), "count": 0}


class ForgetsInSnapshot(ForgetsCount):
    def __getstate__(self) -> dict[str, Any]:
        return vars(self)

    def snapshot(self) -> bytes:
        return self.env.unwrapped.snapshot()  # type: ignore[attr-defined, no-any-return]

    def restore(self, data: bytes) -> None:
        self.env.unwrapped.restore(data)  # type: ignore[attr-defined]


class NoArguments(gymnasium.Wrapper[Any, Any, Any, Any]):
    """Without `RecordConstructorArgs`, a spec does not describe it."""


FAULTS: dict[type[gymnasium.Env[Any, Any]], str] = {
    IgnoresSeed: "reset(seed=3) must give the same episode in two environments; results[0][1]['offset'] is",
    KeepsCounting: "gymnasium.utils.env_checker.check_env(env) raised AssertionError: Deterministic step info",
    OtherDtype: "reset() must return an observation float32 (128,), got uint8 (128,)",
    OtherShape: "number 1 after reset(seed=4), must return an observation uint8 (128,), got uint8 (127,)",
    OtherFinalDtype: "at the end of an episode must return an observation uint8 (128,), got int64 (128,)",
    ArrayOfReward: "must return a finite number as reward, got array([0.])",
    InfiniteReward: "must return a finite number as reward, got inf",
    ReusesArray: "a later step must not change an observation that was returned",
    TakesAnyAction: "step(None) must raise an error, but raised nothing",
    PlaysBeforeItChecks: "step(None) must change nothing, but the snapshot of the environment is another one",
    ResetsItself: "step() before the first reset() must raise an error, but raised nothing",
    OldLives: "must return info['lives']=0 of the game, got 7",
    HasLambda: "(copies=False leaves this check out) raised",
    ForgetsCount: "must continue where the environment is; results[0][4]['count'] is 1 instead of",
    ForgetsInSnapshot: "restore() in the same environment must continue exactly; results",
    NoArguments: "(spec=False leaves this check out) raised ValueError: NoArguments wrapper does not inherit",
}


def maker(env_type: type[Any]) -> Callable[[], Any]:
    if issubclass(env_type, atari.AtariEnv):
        return lambda: env_type("pong", obs_type="ram")
    return lambda: env_type(pong())


OTHER_IN_GYMNASIUM_0 = (KeepsCounting, NoArguments)
"""The checker of Gymnasium 0.29 does not compare `info`, and needs a spec itself."""


@pytest.mark.parametrize(
    "env_type",
    [pytest.param(each, marks=needs_gymnasium_1) if each in OTHER_IN_GYMNASIUM_0 else each for each in FAULTS],
    ids=lambda each: next(name for name, kind in globals().items() if kind is each),
)
@pytest.mark.filterwarnings("ignore:.*WARN")
def test_an_environment_with_a_fault_gets_its_sentence(env_type: type[Any]) -> None:
    with pytest.raises(ContractError) as caught:
        check_env(maker(env_type))
    assert FAULTS[env_type] in str(caught.value)


def test_an_end_that_is_hidden_gets_its_sentence() -> None:
    with warnings.catch_warnings(), pytest.raises(ContractError, match=r"must end the episode: the game is over"):
        check_env(lambda: HidesTheEnd(atari.make("ALE/Pong-v5", obs_type="ram", max_num_frames_per_episode=60)))


def test_what_is_no_fault_passes() -> None:
    check_env(lambda: Faulty(pong()))
    check_env(lambda: HasLambda(pong()), copies=False)
    check_env(lambda: gymnasium.make("FrozenLake-v1"))


@needs_gymnasium_1
def test_spec_false_leaves_the_spec_out() -> None:
    check_env(lambda: NoArguments(pong()), spec=False)


def test_only_a_function_that_makes_environments_is_taken() -> None:
    with pytest.raises(TypeError, match=r"takes a function that makes MyEnv\(\), got .*; write lambda: MyEnv"):
        check_env(pong())  # type: ignore[arg-type]
    with pytest.raises(ContractError, match=r"^make\(\) must return a gymnasium.Env, got 3"):
        check_env(lambda: 3)  # type: ignore[arg-type, return-value]
    with pytest.raises(ContractError, match=r"^make\(\) raised ValueError: there is no game 'pnog'"):
        check_env(lambda: atari.make("pnog"))

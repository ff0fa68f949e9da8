"""`check_vector`: vectors with one fault each, and the sentence that each gets. `tests/vector/test_contract.py` has ours."""

from collections.abc import Callable
from functools import partial
from typing import Any

import numpy as np
import pytest
from env_tools import needs_gymnasium_1

import atari
from atari.base.gymnasium_versions import AutoresetMode, VectorWrapper
from atari.testing import ContractError, check_vector

OPTIONS: dict[str, Any] = {"obs_type": "ram", "max_episode_steps": 15}
N = 2


def vector(mode: str = "NextStep", **options: Any) -> atari.AtariVectorEnv:
    return atari.AtariVectorEnv("ALE/Pong-v5", N, autoreset_mode=mode, **{**OPTIONS, **options})


def single(**options: Any) -> Any:
    return atari.make("ALE/Pong-v5", **{**OPTIONS, **options})


class Faulty(VectorWrapper):
    """The base of wrappers of vectors with a fault; without one it passes."""


def faulty(**methods: Callable[..., Any]) -> type[Faulty]:
    """The class of wrappers with other methods, functions of the wrapper and of the arguments."""
    return type("WithFault", (Faulty,), methods)


def changed(change: Callable[..., Any]) -> type[Faulty]:
    """The class of wrappers whose `step` returns what a function makes of the vector's results."""
    return faulty(step=lambda self, actions: change(*self.env.step(actions)))


def with_info(change: Callable[[Any, dict[str, Any]], dict[str, Any]]) -> type[Faulty]:
    """The class of wrappers with another info at ends: that of a function of the observations and the info."""
    return changed(lambda *each: (*each[:4], change(each[0], each[4]) if "final_obs" in each[4] else each[4]))


ShowsResetsObservation = with_info(lambda seen, info: {**info, "final_obs": seen.copy()})
NoFinalObservation = with_info(lambda _, info: {name: value for name, value in info.items() if "final" not in name})
HidesFinalMask = with_info(lambda _, info: {**info, "_final_obs": np.zeros(N, bool)})
FinalOfOtherDtype = with_info(lambda _, info: {**info, "final_obs": info["final_obs"].astype(np.float32)})
ListOfRewards = changed(lambda seen, reward, *rest: (seen, reward.tolist(), *rest))
NumbersForEnds = changed(lambda seen, reward, ends, *rest: (seen, reward, ends.astype(np.uint8), *rest))
NoMask = changed(lambda *each: (*each[:4], {name: part for name, part in each[4].items() if name != "_lives"}))
OtherDtype = changed(lambda seen, *rest: (seen.astype(np.int32), *rest))
ResetsEverything = faulty(reset=lambda self, *, seed=None, options=None: self.env.reset(seed=seed))
NoSeed = faulty(reset=lambda self, *, seed=None, options=None: self.env.reset(options=options))
IgnoresOut = faulty(step=lambda self, actions, out=None: self.env.step(actions))
TakesTooFewActions = faulty(
    step=lambda self, actions: self.env.step(actions if isinstance(actions, str) else np.resize(actions, N))
)
SwapsLanes = faulty(
    step=lambda self, actions: self.env.step(actions[::-1] if isinstance(actions, np.ndarray) else actions)
)


class ShowsResetTwice(Faulty):
    """In NEXT_STEP, the observation of the step that ends an episode is that of the reset."""

    def step(self, actions: Any) -> Any:
        observation, reward, terminated, truncated, info = self.env.step(actions)
        if truncated.any():
            observation = observation.copy()
            for lane in np.flatnonzero(truncated):
                state = self.env.unwrapped.snapshot()  # type: ignore[attr-defined]
                self.env.step(actions)
                observation[lane] = self.env.unwrapped.ram()[lane]  # type: ignore[attr-defined]
                self.env.unwrapped.restore(None, state)  # type: ignore[attr-defined]
        return observation, reward, terminated, truncated, info


class PaysForResets(Faulty):
    ended = False

    def step(self, actions: Any) -> Any:
        observation, reward, terminated, truncated, info = self.env.step(actions)
        reward = reward + 1 if self.ended else reward
        self.ended = bool((terminated | truncated).any())
        return observation, reward, terminated, truncated, info


class OneSeed(Faulty):
    def reset(self, *, seed: Any = None, options: Any = None) -> Any:
        if isinstance(seed, int):
            seed = [seed] * N
        return self.env.reset(seed=seed, options=options)


class ReusesArray(Faulty):
    kept: Any = None

    def step(self, actions: Any) -> Any:
        observation, *rest = self.env.step(actions)
        if self.kept is None:
            self.kept = np.zeros_like(observation)
        self.kept[:] = observation
        return (self.kept, *rest)


class PlaysBeforeItChecks(Faulty):
    def step(self, actions: Any) -> Any:
        if isinstance(actions, str):
            self.env.step(np.zeros(N, int))
        return self.env.step(actions)


class NoPlace(Faulty):
    """A copy begins a new game."""

    def __reduce__(self) -> Any:
        return _begun, (self.metadata["autoreset_mode"].value,)


def _begun(mode: str) -> Any:
    envs = NoPlace(vector(mode))
    envs.reset(seed=1)
    return envs


class WrongSpace(Faulty):
    def __init__(self, env: Any) -> None:
        super().__init__(env)
        self.observation_space = env.single_observation_space


class ForgetfulVector(atari.AtariVectorEnv):
    """A snapshot has one environment alone."""

    def restore(self, indices: Any, snapshots: Any) -> None:
        super().restore([0], snapshots[:1])


class AnyRecv(atari.AtariVectorEnv):
    def recv(self) -> Any:
        return super().recv() if self._phase == "sent" else self.step(np.zeros(N, int))


FAULTS: dict[Any, tuple[str, str]] = {
    ShowsResetsObservation: ("SameStep", "info['final_obs'] must be the last one of the episode, but it is that of"),
    ShowsResetTwice: ("NextStep", "the observation of the step that ended it must be the last one of the episode, but"),
    NoFinalObservation: ("SameStep", "ended an episode and must return info['final_obs'], got ['_env_id'"),
    HidesFinalMask: ("SameStep", "ended the episodes of [0, 1], and '_final_obs' is False there"),
    FinalOfOtherDtype: ("SameStep", "info['final_obs'][0] must return an observation uint8 (128,), got float32 (128,)"),
    PaysForResets: ("NextStep", "the step after an end resets and must pay 0, but environment 0 got 1"),
    ResetsEverything: ("Disabled", "reset() with a reset_mask must leave other environments as they are"),
    OneSeed: ("NextStep", "reset(seed=3) must give environment i the seed 3 + i, as seed=[3, 4]; results"),
    NoSeed: ("NextStep", "reset(seed=3) must give the same results in two vectors; results"),
    ListOfRewards: ("NextStep", "must return an array of 2 rewards, got [0, 0]"),
    NumbersForEnds: ("NextStep", "must return terminations bool (2,), got uint8 (2,)"),
    NoMask: ("NextStep", "must return info['lives'] with the mask '_lives', bool (2,), got None"),
    OtherDtype: ("NextStep", "must return an observation uint8 (2, 128), got int32 (2, 128)"),
    ReusesArray: ("NextStep", "a later step must not change an observation that was returned; the observation is"),
    TakesTooFewActions: ("NextStep", "step(array([0])) must raise an error, but raised nothing"),
    PlaysBeforeItChecks: ("NextStep", "a step or a reset that was refused must change nothing; results"),
    SwapsLanes: ("NextStep", "must give environment 0 what a single one of seed 3 gets"),
    NoPlace: ("NextStep", "copy.deepcopy of the vector must continue where the vector is; results"),
    IgnoresOut: ("NextStep", "step(actions, out=out) must fill out; out is"),
    WrongSpace: ("NextStep", "observation_space must be single_observation_space for 2 environments, got Box"),
    ForgetfulVector: ("NextStep", "restore() in the same vector must continue exactly; results"),
    AnyRecv: ("NextStep", "recv() without send() must raise an error, but raised nothing"),
}


def make(envs_type: Any, mode: str) -> Any:
    if issubclass(envs_type, atari.AtariVectorEnv):
        return envs_type("ALE/Pong-v5", N, autoreset_mode=mode, **OPTIONS)
    options = {"frameskip": (2, 5)} if envs_type is ResetsEverything else {}
    if options:  # environments that end at other times
        options |= {"max_episode_steps": None, "max_num_frames_per_episode": 61}
    return envs_type(vector(mode, **options))


@pytest.mark.parametrize(
    "envs_type", FAULTS, ids=lambda each: next(name for name, kind in globals().items() if kind is each)
)
@needs_gymnasium_1
def test_a_vector_with_a_fault_gets_its_sentence(envs_type: Any) -> None:
    mode, sentence = FAULTS[envs_type]
    copies, one = envs_type is NoPlace, None if envs_type is ResetsEverything else single
    with pytest.raises(ContractError) as caught:
        check_vector(partial(make, envs_type, mode), single=one, copies=copies, steps=40)
    assert sentence in str(caught.value)


@pytest.mark.parametrize("mode", [mode.value for mode in AutoresetMode])
@needs_gymnasium_1
def test_a_wrapper_without_a_fault_passes(mode: str) -> None:
    check_vector(lambda: Faulty(vector(mode)), single=single, copies=False)


def test_a_vector_that_cannot_be_checked_is_refused() -> None:
    with pytest.raises(ValueError, match="no episode ended within 10 steps, so check_vector cannot check the ends"):
        check_vector(vector, steps=10)
    with pytest.raises(ValueError, match="check_vector needs batches of all 2 environments, got batch_size=1"):
        check_vector(lambda: vector(batch_size=1))
    with pytest.raises(TypeError, match=r"check_vector takes a function that makes MyVectorEnv\(...\), got"):
        check_vector(vector())  # type: ignore[arg-type]
    with pytest.raises(ContractError, match=r"^make\(\) must return a gymnasium.vector.VectorEnv, got"):
        check_vector(single)

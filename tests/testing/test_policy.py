"""`check_policy`: policies with one fault each, and the sentence that each gets, and the policies of this package."""

import os
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

import atari
from atari.learning import ScoresPolicy, load_policy
from atari.testing import ContractError, check_policy

RAM = {"obs_type": "ram"}


class Drawing:
    """A policy that draws numbers, with a generator for each lane; without a fault it passes."""

    def __init__(self) -> None:
        self.generators: dict[int, np.random.Generator] = {}
        self.count = 6

    def begin(self, game: str, actions: Any, lanes: Any, seeds: Any) -> None:
        self.count = len(actions)
        self.generators.update(
            {int(lane): np.random.default_rng(seed) for lane, seed in zip(lanes, seeds, strict=True)}
        )

    def __call__(self, observations: Any, lanes: Any) -> Any:
        return [int(self.generators[int(lane)].integers(self.count)) for lane in lanes]

    def state(self) -> Any:
        return self.generators

    def restore(self, state: Any) -> None:
        self.generators = state


def drawing(**attributes: Any) -> type[Drawing]:
    """The class of such policies with other attributes and methods."""
    return type("Faulty", (Drawing,), attributes)


ForgetsState = drawing(restore=lambda self, state: None)
StateOfLambdas = drawing(state=lambda self: lambda: self.generators)
HalfState = drawing(restore=property())
OtherGame = drawing(game="pnog")
FramesAsText = drawing(training_frames="10M")
OtherEnvironment = drawing(environment={"obs_typ": "ram"})


class IgnoresSeeds(Drawing):
    def begin(self, game: str, actions: Any, lanes: Any, seeds: Any) -> None:
        super().begin(game, actions, lanes, np.frombuffer(os.urandom(8 * len(lanes)), np.uint64))


class OneGenerator(Drawing):
    def begin(self, game: str, actions: Any, lanes: Any, seeds: Any) -> None:
        generator = np.random.default_rng(int(seeds[0]))
        self.generators = {int(lane): generator for lane in range(3)}


class RaisesInBegin(Drawing):
    def begin(self, game: str, actions: Any, lanes: Any, seeds: Any) -> None:
        raise RuntimeError("no memory")


class ThreeArguments:
    def __call__(self, observations: Any, lanes: Any, infos: Any) -> Any:
        return [0] * len(lanes)


def blank(observations: Any) -> Any:
    observations[:] = 0
    return [0] * len(observations)


def extras(observations: Any) -> Any:
    return [0] * len(observations), {"values": np.zeros(1)}


def three_scores(observations: Any) -> Any:
    return np.eye(3, dtype=np.float32)[[1] * len(observations)]


FAULTS: dict[str, tuple[Any, str]] = {
    "3 scores in a game of 6 actions": (ScoresPolicy(three_scores), "scores of 3 actions, and in pong it has 6 (NOOP"),
    "scores as actions": (three_scores, "must return integers of shape (3,), one for each observation, got float32"),
    "an action that the game lacks": (lambda o: [6] * len(o), "returned action 6; in pong it has 6 actions, 0..5"),
    "one action for all": (
        lambda o: [0],
        "must return integers of shape (3,), one for each observation, got int64 (1,)",
    ),
    "nothing": (lambda o: None, "must return integers of shape (3,), one for each observation, got array(None"),
    "actions by row": (lambda o: np.arange(len(o)), "for lane 1 alone as in a batch of 3, got 0 alone and 1 in the"),
    "writes": (blank, "must not write to the observations; the observation is 0 at"),
    "extras": (extras, "must return a row of 'values' for each lane, got (1,)"),
    "an error": (lambda o: o["image"], "policy(uint8 (3, 128), [0, 1, 2]) raised IndexError: only integers"),
    "seeds": (IgnoresSeeds, "after begin() with the same seeds must return the same actions; the policy is"),
    "one generator": (OneGenerator, "must return the same action for lane 0 alone as in a batch of 3"),
    "no restore": (ForgetsState, "restore(state()) must continue exactly (call"),
    "no pickle": (StateOfLambdas, "pickle.dumps(policy.state()) raised"),
    "half": (HalfState, "a policy has state() and restore(state), or neither of them"),
    "begin": (RaisesInBegin, "begin(game, actions, lanes, seeds) raised RuntimeError: no memory"),
    "arguments": (ThreeArguments, "a policy takes (observations, lanes) or (observations), got"),
    "game": (OtherGame, "game must be the id of a game, got 'pnog'"),
    "frames": (FramesAsText, "training_frames must be an integer within 0..1000000000000000, got '10M'"),
    "environment": (OtherEnvironment, "the environment of the policy: it has no option 'obs_typ'; did you mean 'obs_t"),
}


@pytest.mark.parametrize("name", FAULTS)
def test_a_policy_with_a_fault_gets_its_sentence(name: str) -> None:
    policy, sentence = FAULTS[name]
    with pytest.raises(ContractError) as caught:
        check_policy(policy, "pong", **RAM)  # type: ignore[arg-type]
    assert sentence in str(caught.value)


def bright(observations: Any) -> Any:
    """Scores of 6 actions, by the brightness of the observation."""
    brightness = observations.reshape(len(observations), -1).sum(1, dtype=np.int64)
    return np.eye(6, dtype=np.float32)[brightness % 6]


@pytest.mark.parametrize("policy", ["random", "noop"])
@pytest.mark.parametrize("options", [{"preset": "dqn2015"}, {"obs_type": "ram"}, {"obs_type": "dict"}])
def test_the_policies_of_this_package_pass(policy: str, options: dict[str, Any]) -> None:
    check_policy(load_policy(policy), "pong", **options)


@pytest.mark.parametrize("sample", [False, True])
def test_policies_that_say_what_they_see_pass(sample: bool) -> None:
    check_policy(ScoresPolicy(bright, sample=sample, environment={"preset": "dqn2015"}, game="pong"))
    check_policy(ScoresPolicy(bright, sample=sample, task=atari.Task.of("pong", preset="dqn2015")))
    check_policy(ScoresPolicy(bright, sample=sample, task=atari.Task.of("pong", preset="dqn2015")), "space_invaders")
    with pytest.raises(ContractError, match="policy has the actions RIGHTFIRE, LEFTFIRE, and breakout has NOOP, FIRE"):
        check_policy(ScoresPolicy(bright, sample=sample, task=atari.Task.of("pong", preset="dqn2015")), "breakout")
    names = ["NOOP", "RIGHT", "LEFT"]
    check_policy(ScoresPolicy(three_scores, sample=sample, environment={"actions": names}, game="pong"))


def test_functions_classes_and_objects_pass() -> None:
    check_policy(Drawing, "breakout", **RAM)  # type: ignore[arg-type]
    check_policy(Drawing(), atari.Task.of("ALE/Pong-v5", obs_type="ram"))
    check_policy(lambda observations: bright(observations).argmax(1), "pong", preset="dqn2015")


def test_what_cannot_be_checked_is_refused() -> None:
    with pytest.raises(TypeError, match="check_policy takes a function of observations and lanes, got 3"):
        check_policy(3, "pong")
    network = SimpleNamespace(state_dict=dict)
    with pytest.raises(TypeError, match=r"for a network, a file or a name, pass atari.learning.load_policy\(...\)"):
        check_policy(network, "pong")
    with pytest.raises(TypeError, match="check_policy needs a game, for a policy without the attributes game and task"):
        check_policy(Drawing)
    policy = ScoresPolicy(bright, task=atari.Task.of("pong", preset="dqn2015"))
    with pytest.raises(ValueError, match="says what it sees, by its task or environment; leave out obs_type"):
        check_policy(policy, "pong", **RAM)  # type: ignore[arg-type]
    with pytest.raises(ValueError, match="did you mean 'pong'"):
        check_policy(Drawing, "pnog")

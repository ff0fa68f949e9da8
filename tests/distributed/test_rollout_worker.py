"""What a worker of `RolloutActors` plays, without Ray: its observations, and that positions continue it to the bit."""

from typing import Any

import numpy as np
import pytest

import atari

pytest.importorskip("ray", reason="Ray requires a Gymnasium of its own; run ./scripts/test --ray")
pytestmark = pytest.mark.ray

from atari.integrations.ray.rollout import Rollout  # noqa: E402
from atari.integrations.ray.rollout_worker import Played, Position, RolloutWorker, WorkerSettings  # noqa: E402
from atari.learning import ScoresPolicy  # noqa: E402
from atari.vector.options import OF_TASKS, resolve_lanes  # noqa: E402


class Drawn:
    """Random actions, with a counter as its state and as an extra, and weights that are added to it."""

    def __init__(self) -> None:
        self.count = 0

    def __call__(self, observations: Any, lanes: Any) -> Any:
        self.count += 1
        return self.random.integers(3, size=len(observations)), {"count": np.full(len(observations), self.count)}

    def begin(self, game: str, actions: Any, lanes: Any, seeds: Any) -> None:
        self.random = np.random.default_rng(seeds)

    def load(self, weights: int) -> None:
        self.count += weights

    def state(self) -> Any:
        return self.count, self.random

    def restore(self, state: Any) -> None:
        self.count, self.random = state


def settings(steps: int = 100, unstacked: bool = True, **options: Any) -> WorkerSettings:
    running = options or {"preset": "dqn2015"}
    fields = {name: running.pop(name) for name in OF_TASKS if name in running}
    tasks, _ = resolve_lanes("breakout", 3, running.pop("preset", None), fields)
    return WorkerSettings(tasks, steps, seed=5, unstacked=unstacked, options=running)


def copied(played: Played) -> Rollout:
    rollout = played.rollout
    values = {name: value.copy() if value is not None else None for name, value in vars(rollout).items()
              if isinstance(value, np.ndarray)}  # fmt: skip
    return Rollout(**{**vars(rollout), **values})


def same(a: Rollout, b: Rollout) -> bool:
    names = ("observations", "actions", "rewards", "terminations", "truncations", "valid", "scores", "lengths")
    pairs = [*((getattr(a, name), getattr(b, name)) for name in names), (a.extras["count"], b.extras["count"])]
    return all(np.array_equal(one, other) for one, other in pairs)


@pytest.mark.parametrize(
    "options",
    [
        {"preset": "dqn2015"},  # lost lives end episodes
        {"preset": "baselines"},
        {"max_num_frames_per_episode": 100, "frameskip": 2},
        {"grayscale": False, "img_height": 42, "img_width": 42},
        {"obs_type": "ram"},
        {"stack_num": 1},
    ],
)
@pytest.mark.parametrize("unstacked", [True, False])
def test_a_rollout_has_what_the_environments_show(options: Any, unstacked: bool) -> None:
    worker = RolloutWorker(settings(unstacked=unstacked, **options), 1, Drawn, Position())
    envs = atari.AtariVectorEnv("breakout", 3, **options)
    observations, _ = envs.reset(seed=5 + 3)
    ended = np.zeros(3, bool)
    ends = 0
    for number in range(3):
        rollout = worker.play(None, 0, False).rollout
        assert (rollout.actor, rollout.number) == (1, number)
        seen = rollout.observations
        for step in range(100):
            np.testing.assert_array_equal(seen[step], observations)
            assert (rollout.valid[step] == ~ended).all()
            observations, rewards, terminations, truncations, _ = envs.step(rollout.actions[step])
            assert (rollout.rewards[step] == rewards).all()
            assert (rollout.terminations[step] == terminations).all()
            assert (rollout.truncations[step] == truncations).all()
            ended = terminations | truncations
            ends += ended.sum()
        np.testing.assert_array_equal(seen[100], observations)
        rows = np.nonzero(rollout.valid)
        np.testing.assert_array_equal(rollout.observations_at(*rows), seen[:-1][rows])
    assert ends or "preset" not in options


def test_single_frames_take_a_quarter() -> None:
    sizes = [
        RolloutWorker(settings(unstacked=unstacked), 0, Drawn, Position()).play(None, 0, False).rollout.nbytes
        for unstacked in (True, False)
    ]
    assert sizes[0] < 0.3 * sizes[1]


@pytest.mark.parametrize("case", range(4))
def test_a_position_continues_to_the_bit(case: int) -> None:
    """From the reset, a snapshot, a snapshot and actions after it, and from actions after the reset alone."""
    worker = RolloutWorker(settings(), 2, Drawn, Position())
    played, rollouts = [], []
    for number in range(4):
        played.append(worker.play(3 if number == 1 else None, 0, number == 0))
        rollouts.append(copied(played[-1]))
    position = [
        Position(),
        Position(1, played[0].environments, (), played[0].policy),
        Position(2, played[0].environments, (rollouts[1].actions,), played[1].policy),
        Position(1, None, (rollouts[0].actions,), played[0].policy),
    ][case]
    other = RolloutWorker(settings(), 2, Drawn, position)
    for number in range(position.number, 4):
        again = other.play(3 if number == 1 else None, 0, False).rollout
        assert again.number == number
        assert same(again, rollouts[number])


@pytest.mark.parametrize("source", ["random", "noop", ScoresPolicy(lambda seen: np.zeros((len(seen), 4)), sample=True)])
def test_a_worker_plays_what_load_policy_loads(source: Any) -> None:
    worker = RolloutWorker(settings(), 0, source, Position())
    first = worker.play(None, 0, True)
    actions = first.rollout.actions.copy()
    assert (len({*actions.ravel().tolist()}) == 1) == (source == "noop")
    second = worker.play(None, 0, False).rollout.actions.copy()
    other = RolloutWorker(settings(), 0, source, Position(1, first.environments, (), first.policy))
    assert np.array_equal(other.play(None, 0, False).rollout.actions, second)
    assert not np.array_equal(actions, second) or source == "noop"


@pytest.mark.parametrize(
    ("options", "weights", "text"),
    [
        ({"obs_type": "ram"}, None, "needs obs_type='ram', and the environments"),
        ({"frameskip": 3}, None, "needs frameskip=3, and the environments have 4"),
        ({"channels_last": True}, None, "mine needs channels_last, which rollouts do not"),
        ({"rom": "pong.bin"}, None, "mine needs rom, which rollouts do not have"),
        ({}, 1, r"policy mine has no load\(weights\), which set_weights needs"),
        ({}, None, "mine gives scores of 3 actions, and in breakout it has 4"),
    ],
)
def test_a_policy_of_other_environments_is_refused(options: Any, weights: Any, text: str) -> None:
    environment = {"preset": "dqn2015", **options}
    policy = ScoresPolicy(lambda seen: np.zeros((len(seen), 3)), name="mine", environment=environment)
    with pytest.raises(ValueError, match=text):
        RolloutWorker(settings(), 0, policy, Position()).play(weights, 0, False)


@pytest.mark.parametrize("seamless", [False, True])
def test_a_policy_hears_of_new_stacks(seamless: bool) -> None:
    class Listens(Drawn):
        def __init__(self) -> None:
            super().__init__()
            self.begun: list[tuple[int, int]] = []

        def begin_episodes(self, lanes: Any) -> None:
            self.begun += [(self.count - 1, lane) for lane in lanes.tolist()]

    made: list[Listens] = []
    played = settings(steps=900, episodic_life=True, on_reset="continue", seamless_lives=seamless)
    worker = RolloutWorker(played, 0, lambda: made.append(Listens()) or made[0], Position())
    rollout = worker.play(None, 0, False).rollout
    episodes = [tuple(place) for place in np.argwhere(~rollout.valid).tolist()]
    assert len(episodes) > len(rollout.scores) > 0
    assert set(made[0].begun) <= set(episodes)
    assert len(made[0].begun) == (len(rollout.scores) if seamless else len(episodes))


class Ordered(Drawn):
    """Records the order of calls; its memory is made by `load` if `needs_weights`."""

    needs_weights = False

    def __init__(self) -> None:
        super().__init__()
        self.calls: list[str] = []

    def __call__(self, observations: Any, lanes: Any) -> Any:
        self.calls.append("act")
        return super().__call__(observations, lanes)

    def load(self, weights: int) -> None:
        self.calls.append("load")

    def restore(self, state: Any) -> None:
        if self.needs_weights and "load" not in self.calls:
            raise AttributeError("no network")
        self.calls.append("restore")
        super().restore(state)


def test_a_successor_restores_before_it_loads() -> None:
    first = RolloutWorker(settings(), 0, Drawn, Position()).play(1, 1, True)
    position, made = Position(1, first.environments, (), first.policy), []
    successor = RolloutWorker(settings(), 0, lambda: made.append(Ordered()) or made[0], position)
    successor.play(1, 1, False)
    assert made[0].calls[:3] == ["restore", "load", "act"]
    assert made[0].calls.count("restore") == 1

    class NeedsWeights(Ordered):
        needs_weights = True

    successor = RolloutWorker(settings(), 0, NeedsWeights, position)
    with pytest.raises(RuntimeError, match=r"NeedsWeights failed .*no network.* before load\(weights\)"):
        successor.play(1, 1, False)


@pytest.mark.parametrize(
    "options",
    [
        {"dtype": "float32"}, {"channels_last": True}, {"obs_type": "dict"}, {"autoreset_mode": "SameStep"},
        {"batch_size": 2}, {"life_loss_info": True},
    ],
)  # fmt: skip
def test_options_that_rollouts_do_not_have_are_refused(options: Any) -> None:
    with pytest.raises(ValueError, match="leave it out"):
        settings(**options).make()


def test_a_policy_that_returns_nonsense_is_refused() -> None:
    def make(answer: Any) -> Any:
        return lambda: lambda observations, lanes: answer

    for answer in (np.zeros(2, int), (np.zeros(3, int), [1]), np.full(3, 99)):
        with pytest.raises(ValueError):  # noqa: PT011
            RolloutWorker(settings(), 0, make(answer), Position()).play(None, 0, False)


@pytest.mark.parametrize(
    "later", [np.full(3, 0.5), np.zeros((3, 2), int), np.zeros((), int)], ids=["float", "wide", "one"]
)
def test_extras_keep_their_shape_and_type(later: Any) -> None:
    answers = iter([np.zeros(3, int)])

    def policy(observations: Any, lanes: Any) -> Any:
        return np.zeros(3, int), {"value": next(answers, later)}

    with pytest.raises(ValueError, match="and before as int64"):
        RolloutWorker(settings(), 0, lambda: policy, Position()).play(None, 0, False)

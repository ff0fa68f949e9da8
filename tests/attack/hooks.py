"""Subclasses of Gym's classes that replace methods: each replaced method that Gym's class calls is called here, too.

The classes and their hooks are those of Gym's interface (`tests/interfaces/data/gym.txt`). A seed draws a class, an
environment and a play; the subclass notes the calls of all hooks.
"""

import inspect
import random
import tempfile
from collections import defaultdict
from typing import Any

import numpy as np
from interfaces.peers.gym import OURS, facts
from interfaces.reasons import reasons

import atari.classic as gym


class Dictionaries(gym.Env):
    """Observations of several parts, and texts or images; an episode ends at random."""

    action_space = gym.spaces.Discrete(2)
    observation_space = gym.spaces.Dict(a=gym.spaces.Box(-1, 1, (2,)), b=gym.spaces.Discrete(3))

    def __init__(self, draws: random.Random) -> None:
        self.draws = draws
        self.metadata = {"render.modes": [draws.choice(("ansi", "rgb_array"))]}

    def reset(self) -> Any:
        return self.observation_space.sample()

    def step(self, action: Any) -> Any:
        return self.observation_space.sample(), 1.0, self.draws.random() < 0.2, {}

    def render(self, mode: str = "human") -> Any:
        return "a frame\n" if mode == "ansi" else np.zeros((8, 8, 3), np.uint8)


class OneInfo(gym.vector.SyncVectorEnv):
    """A vector with one dictionary of infos, as in Gym 0.26."""

    def step_wait(self, **options: Any) -> Any:
        *results, listed = super().step_wait(**options)
        infos: dict[str, Any] = {}
        for lane, info in enumerate(listed):
            infos = self._add_info(infos, {**info, "episode": {"r": 1.0, "l": 2, "t": 0.5}}, lane)
        infos["episode"] = {key: np.array([each[key] for each in infos["episode"]]) for key in "rlt"}
        return *results, infos


def environments(draws: random.Random) -> list[Any]:
    """Functions that make environments of all kinds, in random order."""
    game = draws.choice(("Pong", "Breakout", "Seaquest"))
    several = [lambda: gym.make("CartPole-v1")] * draws.randint(1, 3)
    made = [
        lambda: gym.make(f"{game}NoFrameskip-v4"),
        lambda: gym.make("Pendulum-v1"),
        lambda: gym.make("CartPole-v1"),
        lambda: Dictionaries(draws),
        lambda: OneInfo(several),
    ]
    draws.shuffle(made)
    return made


def arguments(draws: random.Random, folder: str) -> dict[str, Any]:
    """Values of the parameters of classes, by name; without `env`."""
    return {
        "directory": folder,
        "video_folder": folder,
        "num_stack": draws.randint(1, 4),
        "shape": draws.randint(1, 30),
        "f": lambda value: value,
        "min_action": -1.0,
        "max_action": 1.0,
        "env_fns": [lambda: gym.make("CartPole-v1")] * draws.randint(1, 3),
        "dict_keys": ["a"],
        "mode": draws.choice(("training", "evaluation")),
        "write_upon_reset": draws.random() < 0.5,
        "copy": draws.random() < 0.5,
    }


def hooks() -> dict[str, list[str]]:
    """The methods that each of Gym's wrappers and vectors calls on itself, by the path of the class."""
    found: dict[str, list[str]] = defaultdict(list)
    excused = reasons("gym")
    for fact in facts():
        is_here = fact.kind == "hook" and fact.module.startswith(("gym.wrappers.", "gym.vector."))
        if is_here and not any(reason.excuses(fact) for reason in excused):
            path, _, name = fact.path.rpartition(".")
            found[path].append(name)
    return dict(found)


def attack(seed: int) -> None:
    """Play with a subclass of a class that the seed draws; AssertionError for a hook that is not called."""
    draws = random.Random(seed)
    path, names = draws.choice(sorted(hooks().items()))
    kind = OURS.find(path)
    if not hasattr(kind, "step"):  # it is no environment
        return
    called: set[str] = set()
    with tempfile.TemporaryDirectory() as folder:
        made = make(draws, kind, names, called, folder)
        if made is None:
            return
        try:
            play(draws, made)
        except NotImplementedError:  # a vector has no images
            return
    missing = sorted(set(names) - called)
    assert not missing, f"{path} does not call the method {', '.join(missing)} of a subclass, which Gym's class calls"


def make(draws: random.Random, kind: Any, names: list[str], called: set[str], folder: str) -> Any:
    """An instance of a subclass that notes the calls of its hooks; None if no environment fits the class."""

    def noted(name: str) -> Any:
        def call(self: Any, *given: Any, **options: Any) -> Any:
            called.add(name)
            return getattr(super(subclass, self), name)(*given, **options)  # type: ignore[arg-type]

        return call

    subclass = type("Subclass", (kind,), {name: noted(name) for name in names})
    values = arguments(draws, folder)
    parameters = inspect.signature(kind).parameters.values()
    required = {
        each.name
        for each in parameters
        if each.default is each.empty and each.kind not in (each.VAR_POSITIONAL, each.VAR_KEYWORD)
    }
    if not required <= {"env", *values}:  # a base that has no use by itself
        return None
    given = {each.name: values[each.name] for each in parameters if each.name in values}
    for make_env in environments(draws) if "env" in required else [lambda: None]:
        env = make_env()
        try:
            return subclass(**given, **({"env": env} if "env" in required else {}))
        except (TypeError, ValueError, NotImplementedError):  # the class is for another kind of environment
            continue
    return None


def play(draws: random.Random, env: Any) -> None:
    for _ in range(draws.randint(2, 4)):
        env.reset()
        for _ in range(draws.randint(20, 40)):
            _, _, done, *_ = env.step(env.action_space.sample())
            if np.all(done):
                break
    env.close()

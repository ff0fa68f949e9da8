"""Every ID of OpenAI Gym: the environment it makes today and its limits, or the error."""

import sys
from collections.abc import Callable
from typing import Any

import gymnasium
import pytest
from env_tools import needs_gymnasium_1

import atari.classic as gym
from atari.classic import gym_ids, modern
from atari.classic import logger as classic_logger
from atari.task import env_ids

LIMITS = {  # Gym 0.20
    "Pong-v0": 10_000,
    "Pong-ram-v0": 10_000,
    "Pong-v4": 100_000,
    "Pong-ram-v4": 100_000,
    "PongDeterministic-v0": 100_000,
    "Pong-ramDeterministic-v4": 100_000,
    "PongNoFrameskip-v0": 400_000,
    "Pong-ramNoFrameskip-v4": 400_000,
    "SpaceInvadersNoFrameskip-v4": 300_000,
    "SpaceInvaders-ramNoFrameskip-v0": 300_000,
    "SpaceInvadersDeterministic-v4": 100_000,
    "ALE/Pong-v5": 27_000,  # ale-py 0.7
    "CartPole-v0": 200,
    "CartPole-v1": 500,
    "MountainCar-v0": 200,
    "Acrobot-v1": 500,
}


@pytest.mark.parametrize("env_id", LIMITS)
def test_time_limits_are_those_of_gym(env_id: str) -> None:
    env = gym.make(env_id)
    assert env.spec is not None
    assert (env.spec.id, env.spec.max_episode_steps, env.spec.timestep_limit) == (
        env_id,
        LIMITS[env_id],
        LIMITS[env_id],
    )
    assert env.spec.tags == {"wrapper_config.TimeLimit.max_episode_steps": LIMITS[env_id]}
    assert env._max_episode_steps == LIMITS[env_id]  # type: ignore[attr-defined]  # by which scripts change it


def test_an_atari_game_is_cut_off_by_its_steps_alone() -> None:
    """The limit counts steps, not the frames that today's registration counts."""
    env = gym.make("ALE/Pong-v5")
    assert env.unwrapped.modern.unwrapped.ale_options()["max_num_frames_per_episode"] is None  # type: ignore[attr-defined]
    assert gymnasium.spec("ALE/Pong-v5").kwargs["max_num_frames_per_episode"] == 108_000


def test_thresholds_and_nondeterminism() -> None:
    assert [gym.spec(f"CartPole-v{i}").reward_threshold for i in (0, 1)] == [195.0, 475.0]
    assert gym.spec("Pong-v0").reward_threshold is None
    flagged = {spec.id for spec in gym.envs.registry.all() if spec.nondeterministic and spec.id in env_ids.ids()}
    assert flagged == {
        f"ElevatorAction-ram{speed}-v{version}" for speed in ("", "Deterministic", "NoFrameskip") for version in (0, 4)
    }


def test_the_spec_has_the_options_of_make() -> None:
    env = gym.make("FrozenLake-v1", map_name="8x8")
    assert env.spec is not None
    assert (env.spec.kwargs, env.observation_space.n) == ({"map_name": "8x8"}, 64)  # type: ignore[attr-defined]
    assert gym.spec("FrozenLake-v1").kwargs == {"map_name": "4x4"}


def test_every_atari_id_has_a_spec_and_makes() -> None:
    for env_id in env_ids.ids():
        assert repr(gym.spec(env_id)) == f"EnvSpec({env_id})"
    for env_id in ("MsPacman-v0", "ALE/Tetris-ram-v5", "QbertNoFrameskip-v4"):
        with gym.make(env_id) as env:
            assert env.observation_space.contains(env.reset())


@pytest.mark.parametrize(
    ("old", "new"),
    [
        ("FrozenLake-v0", "FrozenLake-v1"),
        ("FrozenLake8x8-v0", "FrozenLake8x8-v1"),
        ("Pendulum-v0", "Pendulum-v1"),
        ("Acrobot-v0", "Acrobot-v1"),
        ("Blackjack-v0", "Blackjack-v1"),
        ("Pong-v3", "Pong-v4"),
        ("PongNoFrameskip-v2", "PongNoFrameskip-v4"),
    ],
)
def test_an_old_version_becomes_the_newest_with_a_warning(
    old: str, new: str, capsys: pytest.CaptureFixture[str]
) -> None:
    classic_logger.warn_once.cache_clear()
    env = gym.make(old)
    assert env.spec is not None
    assert env.spec.id == new
    assert env.observation_space.contains(env.reset())
    said = capsys.readouterr().err.splitlines()
    assert said[-1] == f"atari.classic: {old} is no longer there; this is {new}, its newest version"
    gym.make(old)
    assert capsys.readouterr().err == ""  # once


def test_the_logger_level_suppresses_warnings(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(gymnasium.logger, "min_level", gymnasium.logger.min_level)
    gym.logger.set_level(40)
    classic_logger.warn_once.cache_clear()
    gym.make("Pendulum-v0")
    assert capsys.readouterr().err == ""


@pytest.mark.parametrize(
    ("wrong", "cure"),
    [
        ("CartPoel-v0", "did you mean 'CartPole-v0'?"),
        ("cartpole-v1", "did you mean 'CartPole-v1'?"),
        ("CartPole", "did you mean 'CartPole-v1'?"),
        ("CartPole-v7", "did you mean 'CartPole-v1'?"),
        ("Breakout-v5", "did you mean 'ALE/Breakout-v5'?"),
        ("Brekout-v4", "did you mean 'Breakout-v4'?"),
        ("", "gym.envs.registry.all() lists what there is"),
        ("DoomBasic-v0", "the package that had it is no longer maintained, and no other has it"),
        ("Go9x9-v0", "the package that had it is no longer maintained, and no other has it"),
        ("NChain-v0", "Gym dropped it, and no maintained package has it"),
        (
            "RoboschoolHopper-v1",
            "Roboschool is no longer maintained, the nearest that is are Gymnasium's MuJoCo environments, "
            "such as 'Hopper-v5'",
        ),
    ],
)
def test_the_error_for_an_unknown_id_says_what_to_do(wrong: str, cure: str) -> None:
    for function in (gym.make, gym.spec):
        with pytest.raises(gym.error.UnregisteredEnv) as error:
            function(wrong)
        assert str(error.value) == f"there is no environment {wrong!r}; {cure}"


def test_the_error_for_robotics_names_its_package(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(gym_ids, "load_robotics", lambda: None)
    kept = {i: s for i, s in gymnasium.registry.items() if "gymnasium_robotics" not in str(s.entry_point)}
    monkeypatch.setattr(gymnasium, "registry", kept)
    for env_id in ("FetchPickAndPlace-v1", "HandManipulateEgg-v0", "HandReach-v0"):
        with pytest.raises(gym.error.UnregisteredEnv, match=r"pip install gymnasium-robotics"):
            gym.make(env_id)


@needs_gymnasium_1
@pytest.mark.parametrize(
    ("env_id", "package", "extra"),
    [("Ant-v2", "mujoco", "mujoco"), ("LunarLander-v2", "Box2D", "box2d"), ("phys2d/CartPole-v1", "jax", "jax")],
)
def test_the_error_for_a_missing_package_names_its_extra(
    env_id: str, package: str, extra: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    families = (package, *(f"gymnasium.envs.{family}" for family in ("box2d", "functional_jax", "mujoco", "phys2d")))
    for name in [name for name in sys.modules if name.startswith(families)]:
        monkeypatch.delitem(sys.modules, name)
    monkeypatch.setitem(sys.modules, package, None)
    with pytest.raises(gym.error.DependencyNotInstalled, match=rf"pip install [\"']gymnasium\[{extra}\][\"']"):
        gym.make(env_id)


def test_the_error_for_rendering_without_pygame_names_the_extra(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("SDL_VIDEODRIVER", "dummy")
    monkeypatch.setitem(sys.modules, "pygame", None)
    env = gym.make("Pong-v0")
    env.reset()
    assert env.render(mode="rgb_array").shape == (210, 160, 3)
    with pytest.raises(
        gym.error.DependencyNotInstalled,
        match=r"^env.render\(\) needs pygame-ce: pip install pygame-ce; env.render\(mode='rgb_array'\) needs nothing$",
    ):
        env.render()


# register()


class Corridor(gym.Env):
    metadata = {"render.modes": []}  # noqa: RUF012
    action_space = gym.spaces.Discrete(2)
    observation_space = gym.spaces.Discrete(10)

    def __init__(self, length: int = 3) -> None:
        self.length = length

    def reset(self) -> int:
        self.at = 0
        return 0

    def step(self, action: int) -> Any:
        self.at += action
        return self.at, 0.0, self.at >= self.length, {}


@pytest.fixture(autouse=True)
def _registry_as_it_was(monkeypatch: pytest.MonkeyPatch) -> None:
    for where in (gymnasium, gymnasium.envs.registration):
        monkeypatch.setattr(where, "registry", dict(gymnasium.registry))


def test_register_and_make() -> None:
    gym.register(
        id="Corridor-v3", entry_point=Corridor, max_episode_steps=5, reward_threshold=0.5, kwargs={"length": 4}
    )
    spec = gym.spec("Corridor-v3")
    assert (spec.entry_point, spec.kwargs, spec.reward_threshold) == (Corridor, {"length": 4}, 0.5)
    env = gym.make("Corridor-v3")
    assert str(env) == "<TimeLimit<Checked<Corridor<Corridor-v3>>>>"
    assert env.unwrapped.spec == env.spec == spec
    assert env.unwrapped.length == 4  # type: ignore[attr-defined]
    assert gym.make("Corridor-v3", length=9).unwrapped.length == 9  # type: ignore[attr-defined]
    assert spec.make().unwrapped.length == 4  # type: ignore[attr-defined]
    assert spec in gym.envs.registry.all()


def test_the_limits_of_2016() -> None:
    gym.register("A-v0", entry_point=Corridor, timestep_limit=7)
    gym.register("B-v0", entry_point=Corridor, tags={"wrapper_config.TimeLimit.max_episode_steps": 8})
    gym.register("C-v0", entry_point=Corridor, trials=10)
    assert [gym.spec(f"{name}-v0").max_episode_steps for name in "ABC"] == [7, 8, None]


def test_a_taken_id_is_refused_until_it_is_deleted() -> None:
    gym.register("Corridor-v0", entry_point=Corridor)
    gym.register("Corridor-v0", entry_point=Corridor, max_episode_steps=3)  # a notebook's cell, run again
    assert gym.spec("Corridor-v0").max_episode_steps == 3
    with pytest.raises(gym.error.Error, match=r"the ID 'Corridor-v0' is taken by .*Corridor; choose another name"):
        gym.register("Corridor-v0", entry_point="elsewhere:Corridor")
    with pytest.raises(gym.error.Error, match=r"the ID 'CartPole-v0' is taken by gymnasium\."):
        gym.register("CartPole-v0", entry_point=Corridor)
    if "Corridor-v0" in gym.envs.registry.env_specs:  # as scripts do
        del gym.envs.registry.env_specs["Corridor-v0"]
    gym.register("Corridor-v0", entry_point="elsewhere:Corridor")


ID = "an ID is a name, '-v' and a version, such as 'Corridor-v0', got "


@pytest.mark.parametrize(
    ("call", "kind", "text"),
    [
        *(
            (lambda wrong=wrong: gym.make(wrong), TypeError, r"make\(\) takes an ID such as")
            for wrong in (None, 3, b"a-v0")
        ),
        *(
            (lambda wrong=wrong: gym.register(wrong, entry_point=Corridor), gym.error.Error, ID)
            for wrong in ("Corridor", "Corridor-v", "Corridor v0", "-v0", "", None)
        ),
        *(
            (lambda wrong=wrong: gym.register("A-v0", entry_point=wrong), gym.error.Error, "entry_point is a class, or")
            for wrong in (None, "Corridor", 3)
        ),
    ],
)
def test_wrong_ids_and_entry_points(call: Callable[[], Any], kind: type[Exception], text: str) -> None:
    with pytest.raises(kind, match=text):
        call()


def test_an_entry_point_makes_an_environment() -> None:
    gym.register("Nothing-v0", entry_point=dict)
    with pytest.raises(TypeError, match="dict is no environment; derive the class from Env"):
        gym.make("Nothing-v0")


def test_a_module_may_be_named_with_an_id(monkeypatch: pytest.MonkeyPatch, tmp_path: Any) -> None:
    (tmp_path / "own_corridors.py").write_text(
        "import atari.classic as gym\n"
        "class Long(gym.Env):\n"
        "    action_space = observation_space = gym.spaces.Discrete(2)\n"
        "gym.register('Long-v0', entry_point='own_corridors:Long')\n"
    )
    monkeypatch.syspath_prepend(tmp_path)
    assert type(gym.make("own_corridors:Long-v0").unwrapped).__name__ == "Long"


# The registry


def test_the_registry_prints_as_it_did() -> None:
    specs = gym.envs.registry.all()
    assert repr(specs).startswith("dict_values([EnvSpec(")
    assert {"EnvSpec(DoubleDunk-v0)", "EnvSpec(CartPole-v0)"} <= set(map(repr, specs))
    env_specs = gym.envs.registry.env_specs
    assert env_specs["Pong-v0"] == gym.spec("Pong-v0") == gym.envs.registry.spec("Pong-v0")
    assert len(env_specs) == len(specs) == len(list(env_specs))
    assert sum(env_id in env_ids.ids() for env_id in env_specs) == 952
    with pytest.raises(KeyError):
        env_specs["Pong-v7"]


@needs_gymnasium_1
def test_ids_that_only_say_that_they_are_gone_are_not_listed() -> None:
    listed = set(gym.envs.registry.env_specs)
    every = ("Ant-v2", "Hopper-v3", "GymV21Environment-v0")
    gone = {
        env_id for env_id in every if callable(gymnasium.registry[env_id].entry_point)
    }  # older releases have MuJoCo's
    assert "GymV21Environment-v0" in gone
    assert not listed & gone
    assert {"Ant-v5", "Hopper-v4"} <= listed
    old = modern.EntryPoint("gymnasium_robotics.envs.mujoco.ant_v2:AntEnv").entry_point
    gymnasium.registry["Ant-v2"] = gymnasium.envs.registration.EnvSpec("Ant-v2", entry_point=old)
    assert not gym_ids.is_alive("Ant-v2")


def test_environments_that_are_gone_have_a_fate() -> None:
    assert gym_ids.fate("CartPole-v0") is None
    assert gym_ids.fate("RoboschoolHumanoidFlagrun-v1") == (
        "the package that had it is no longer maintained, and no other has it"
    )


def test_kinds_of_environments() -> None:
    """Baselines finds the kind of an environment by the module of its class."""
    kinds = {spec.id: str(spec._entry_point).split(":")[0].split(".")[-1] for spec in gym.envs.registry.all()}
    ids = ("PongNoFrameskip-v4", "Breakout-ram-v0", "CartPole-v0", "Acrobot-v1", "FrozenLake-v1")
    assert [kinds[env_id] for env_id in ids] == ["atari", "atari", *["classic_control"] * 2, "toy_text"]


@pytest.mark.parametrize("env_id", ["PongNoFrameskip-v4", "Pong-ram-v0", "MountainCar-v0", "FrozenLake8x8-v1"])
def test_the_class_of_a_spec(env_id: str) -> None:
    spec: Any = gym.envs.registry.env_specs[env_id]
    env, made = gym.envs.registration.load(spec.entry_point)(**spec._kwargs), gym.make(env_id)
    assert type(env) is type(made.unwrapped)
    assert spec.nondeterministic is False
    assert (env.observation_space, env.action_space) == (made.observation_space, made.action_space)

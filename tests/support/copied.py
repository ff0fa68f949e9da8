"""Objects of the public classes, the ways to copy them, and their play: a copy must play on as the object does."""

import copy
import multiprocessing
import pickle
import shutil
import tempfile
from collections.abc import Callable, Mapping
from functools import partial
from pathlib import Path
from typing import Any

import cloudpickle
import gymnasium
import numpy as np

import atari
import atari.classic as gym
from atari import ale_py, wrappers
from atari.games.actions import Action
from atari.integrations import envpool
from atari.lab import Freeze, Poke, Ram, RamLabels, Search, Watch
from atari.learning import (
    PROTOCOLS,
    Published,
    ReplayMemory,
    RestartOptions,
    Result,
    TrainingEnvironments,
    TrainingOptions,
)
from atari.learning.evaluation.results import GameResult
from atari.multiplayer import MultiplayerCore
from atari.play import Session
from atari.recording import RecordReplay, RecordSearch, RecordVideo, Replay
from atari.testing import ContractError

FOLDER = Path(tempfile.gettempdir()) / "atari-copies"
"""A folder of this test, at the same place in all its processes."""

WAYS: Mapping[str, Callable[[Any], Any]] = {
    "pickle": lambda one: pickle.loads(pickle.dumps(one)),
    "pickle protocol 2": lambda one: pickle.loads(pickle.dumps(one, 2)),
    "cloudpickle": lambda one: pickle.loads(cloudpickle.dumps(one)),
    "deepcopy": copy.deepcopy,
}
"""The ways to copy an object in one process."""


def plain(value: Any) -> Any:
    """Results without the seconds that an episode took, in types that `==` compares."""
    if isinstance(value, np.ma.MaskedArray):
        return value.tolist()
    if isinstance(value, (np.ndarray, np.generic)):
        return str(value.dtype), value.shape, value.tobytes()
    if hasattr(value, "__array__"):  # stacks that are made when they are read
        return plain(np.asarray(value))
    if isinstance(value, Mapping):
        return {name: plain(part) for name, part in value.items() if name not in ("t", "_t")}
    if isinstance(value, (list, tuple)):
        return [plain(part) for part in value]
    return value


def steps(env: Any, count: int = 40) -> list[Any]:
    """All results of actions that the environment's own space draws."""
    results = []
    for _ in range(count):
        result = env.step(env.action_space.sample())
        results.append(plain(result))
        if np.ndim(result[2]) == 0 and any(result[2:-1]):
            results.append(plain(env.reset()))
    return [*results, plain(env.reset())]


def frames(core: Any, count: int = 200) -> list[Any]:
    """Rewards, RAM, screens and sound of a core's random frames, over a reset."""
    rng = np.random.default_rng(1)
    results = []
    for number in range(count):
        if core.game_over or core.truncated or number == count // 2:
            core.reset()
        several = isinstance(core, MultiplayerCore)
        action = rng.integers(18, size=core.players if several else None).tolist()
        results.append(core.act_players(action) if several else core.act(action))
        results.append([plain(array()) for array in (core.ram, core.screen, core.audio)])
    return [*results, core.lives, core.frame_number, core.mode, core.difficulty]


def raw_program() -> Any:
    """An `ALEInterface` in the middle of a game."""
    ale = ale_py.ALEInterface()
    ale.setInt("random_seed", 5)
    ale.loadROM(ale_py.roms.get_rom_path("breakout"))
    raw_frames(ale, 50)
    return ale


def raw_frames(ale: Any, count: int = 200) -> list[Any]:
    """Rewards, RAM and screens of the actions in turn."""
    actions = ale.getMinimalActionSet()
    played = ((ale.act(actions[number % len(actions)]), ale) for number in range(count))
    return [(reward, ale.lives(), plain(ale.getRAM()), plain(ale.getScreenRGB())) for reward, ale in played]


def raw_vector() -> Any:
    envs = ale_py.ALEVectorInterface(ale_py.roms.get_rom_path("breakout"), 2)
    envs.reset([0, 1], [3, 4])
    return envs


def raw_steps(envs: Any, count: int = 40) -> list[Any]:
    """The results of steps of ale-py's interface of a vector."""
    results = []
    for number in range(count):
        envs.send([number % 4, 1], [1.0, 1.0])
        results.append(plain(envs.recv()))
    return results


def raw_match() -> Any:
    ale = atari.multiplayer.ALEInterface()
    ale.setInt(b"random_seed", 3)
    ale.loadROM(ale_py.roms.get_rom_path("pong"))
    ale.reset_game()
    return ale


def raw_turns(ale: Any, count: int = 100) -> list[Any]:
    """Rewards, RAM and screens of Multi-Agent-ALE's interface."""
    return [
        plain((ale.act([number % 6, number % 5]), ale.allLives(), ale.getRAM(), ale.getScreenRGB()))
        for number in range(count)
    ]


def match(env: Any, count: int = 40) -> list[Any]:
    """All results of a parallel environment of PettingZoo's, over a reset."""
    results = []
    for number in range(count):
        if not env.agents or number == count // 2:
            results.append(plain(env.reset()))
        results.append(plain(env.step({agent: env.action_space(agent).sample() for agent in env.agents})))
    return results


def turns(env: Any, count: int = 60) -> list[Any]:
    """All results of an AEC environment of PettingZoo's."""
    results = []
    for agent in env.agent_iter(count):
        last = env.last()
        results.append((agent, plain(last)))
        env.step(None if last[2] or last[3] else env.action_space(agent).sample())
    return results


def watched(env: Any) -> list[Any]:
    return [*steps(env), {str(name): plain(column) for name, column in env.history.items()}]


def drawn(memory: ReplayMemory) -> list[Any]:
    """Batches, the observations, and what is drawn after further steps."""
    fill(memory, 10, seed=5)
    names = ("observations", "actions", "rewards", "next_observations", "indices", "weights")
    batches = [memory.sample(8, n=2, beta=0.5) for _ in range(3)]
    return [len(memory), plain(memory.observations()), [plain(getattr(batch, n)) for batch in batches for n in names]]


def shown(session: Session) -> list[Any]:
    results = []
    for number in range(60):
        session.play(session.legal_actions[number % len(session.legal_actions)])
        results.append((session.scores, session.frames, plain(session.screen), plain(session.samples)))
    return results


def fill(memory: ReplayMemory, count: int, seed: int = 0) -> None:
    rng = np.random.default_rng(seed)
    for _ in range(count):
        memory.add(
            rng.integers(6, size=2),
            rng.random(2),
            rng.random(2) < 0.1,
            np.zeros(2, bool),
            observations=rng.integers(0, 256, (2, 6, 5), dtype=np.uint8),
        )


def started(env: Any, count: int = 25) -> Any:
    """An environment in the middle of an episode, with generators that were seeded."""
    env.action_space.seed(3)
    env.reset(seed=1)
    for _ in range(count):
        env.step(env.action_space.sample())
    return env


def core(kind: type[Any], game: str = "breakout", **options: Any) -> Any:
    made = kind(game, seed=3, **options)
    made.reset()
    for number in range(30):
        made.act_players([number % 18] * made.players) if made.name == "multiplayer" else made.act(number % 18)
    return made


def parallel(make: Callable[..., Any], game: str = "pong_v3", **options: Any) -> Any:
    env = make(game, **options)
    env.reset(seed=2)
    for number, agent in enumerate(env.possible_agents):
        env.action_space(agent).seed(number)
    return env


def memory(**options: Any) -> ReplayMemory:
    given = options or {"stack_num": 3, "priority_exponent": 0.6, "autoreset_mode": "next_step"}
    made = ReplayMemory(60, 2, (6, 5), seed=4, **given)
    made.reset(np.zeros((2, 6, 5), np.uint8))
    fill(made, 40)
    return made


def replay(name: str = "a") -> Replay:
    FOLDER.mkdir(exist_ok=True)
    with RecordReplay(atari.AtariEnv("pong"), FOLDER / f"{name}.a26r") as env:
        started(env, 20)
    return Replay.load(FOLDER / f"{name}.a26r")


def pooled() -> Any:
    envs = envpool.make_gymnasium("Pong-v5", num_envs=2, seed=1)
    envs.reset()
    for number in range(5):
        envs.step(np.full(2, number))
    return envs


def pool_steps(envs: Any) -> list[Any]:
    return [plain(envs.step(np.array([number % 6, 2]))) for number in range(20)] + [plain(envs.reset())]


class Reversed(gym.ActionWrapper):
    """The actions in the other order."""

    def action(self, action: int) -> int:
        return self.action_space.n - 1 - action


class Halved(gym.RewardWrapper):
    """Rewards by half."""

    def reward(self, reward: float) -> float:
        return reward / 2


class Inverted(gym.ObservationWrapper):
    """Observations with all bits inverted."""

    def observation(self, observation: Any) -> Any:
        return ~observation


class Reached(gym.GoalEnv):
    """A goal that every step reaches."""

    def __init__(self) -> None:
        space = gym.spaces.Box(0, 1, (1,), np.float32)
        self.observation_space = gym.spaces.Dict({"observation": space, "achieved_goal": space, "desired_goal": space})
        self.action_space = gym.spaces.Discrete(2)
        self.count = 0

    def reset(self) -> Any:
        self.count = 0
        return self._seen()

    def step(self, action: int) -> Any:
        self.count += int(action)
        return self._seen(), 1.0, False, {}

    def compute_reward(self, achieved_goal: Any, desired_goal: Any, info: Any) -> float:
        return 1.0

    def _seen(self) -> dict[str, Any]:
        place = np.full(1, self.count, np.float32)
        return {"observation": place, "achieved_goal": place, "desired_goal": place}


def classic(wrapper: Callable[[Any], Any] = lambda env: env) -> Any:
    env = wrapper(gym.make("Pong-ram-v0"))
    env.seed(3)
    env.action_space.seed(3)
    env.reset()
    env.step(1)
    return env


def task(name: str) -> Any:
    return started(gymnasium.make(name), 0)


def unframed(env: Any = "pong", **options: Any) -> atari.AtariEnv:
    return atari.AtariEnv(env, frameskip=1, repeat_action_probability=0.0, **options)


def never(_: int) -> bool:
    return False


def video(make: Callable[[], Any]) -> Any:
    shutil.rmtree(FOLDER / "videos", ignore_errors=True)
    return started(RecordVideo(make(), FOLDER / "videos", step_trigger=never))


def itself(value: Any) -> Any:
    return value


def facts(published: Published) -> list[Any]:
    return [published.name, published.protocol, published.games, plain(published.final("pong"))]


def text(error: Exception) -> list[Any]:
    return [type(error), error.args]


def together(pair: tuple[Any, Any]) -> list[Any]:
    """The play of an environment with bytes that are held, and after their release."""
    env, held = pair
    before = steps(env)
    held.release()
    return [*before, *steps(env)]


def read(pair: tuple[Any, Ram]) -> list[Any]:
    env, ram = pair
    before = steps(env)
    ram["ball_x"] = 100
    return [*before, ram["ball_x"], ram[5], *steps(env)]


def narrowed(pair: tuple[Any, Search]) -> list[Any]:
    env, search = pair
    steps(env, 5)
    return [search.changed().candidates, plain(search.history)]


def with_(make: Callable[[Any], Any], env: Any) -> tuple[Any, Any]:
    return env, make(env)


def vector(**options: Any) -> Any:
    return started(atari.AtariVectorEnv("breakout", 3, **options))


def changed(one: Any, mode: int = 4) -> Any:
    one.set_mode(mode)
    one.set_difficulty(1)
    return one


def vector_of(game: str) -> Any:
    return started(atari.AtariVectorEnv(game, 2))


def plays(session: Any) -> list[Any]:
    return [(session.play(session.legal_actions[n % 18]), session.scores, plain(session.screen))[1:] for n in range(60)]


Case = tuple[Callable[[], Any], Callable[[Any], Any]]


def training_environments() -> TrainingEnvironments:
    """Environments in the middle of a game."""
    made = TrainingEnvironments(TrainingOptions.of("pong", img_height=20, img_width=20), 2)
    made.reset(3)
    made.step(np.array([2, 3]))
    return made


def played(environments: TrainingEnvironments) -> list[Any]:
    """The results of steps with actions of a fixed order, and the games that ended."""
    results = [plain(environments.step(np.array([n % 6, n // 2 % 6]))) for n in range(60)]
    return [*results, environments.take_games()]


WRAPPERS: Mapping[str, Callable[[Any], Any]] = {
    "action_delay.ActionDelay": lambda env: wrappers.ActionDelay(env, 3),
    "clip_reward.ClipReward": wrappers.ClipReward,
    "dqn_preprocessing.DqnPreprocessing": lambda env: wrappers.DqnPreprocessing(env, (2, 5)),
    "episodic_life.EpisodicLife": lambda env: wrappers.EpisodicLife(env, "continue"),
    "expression_reward.ExpressionReward": lambda env: wrappers.ExpressionReward(
        env, "reward + player_x - before.lives"
    ),
    "fire_reset.FireReset": wrappers.FireReset,
    "frame_skip.FrameSkip": wrappers.FrameSkip,
    "frame_stack.FrameStack": lambda env: wrappers.FrameStack(env, lazy=True),
    "grayscale.Grayscale": wrappers.Grayscale,
    "life_loss_info.LifeLossInfo": lambda env: wrappers.LifeLossInfo(wrappers.DqnPreprocessing(env)),
    "noop_reset.NoopReset": wrappers.NoopReset,
    "observation_delay.ObservationDelay": lambda env: wrappers.ObservationDelay(env, 3),
    "ram_observation.RamObservation": wrappers.RamObservation,
    "resize.Resize": lambda env: wrappers.Resize(env, (42, 42)),
    "sticky_actions.StickyActions": lambda env: wrappers.StickyActions(env, 0.5),
}
"""The wrappers by their path, as functions of an environment that plays frames."""


def wrapped(wrap: Callable[[Any], Any]) -> Any:
    """An environment in a wrapper, after a lost life."""
    return started(wrap(unframed("breakout")), 200)


CASES: Mapping[str, Case] = {
    "atari.games.actions.Action": (lambda: Action.UPFIRE, itself),
    "atari.env.env.AtariEnv": (lambda: started(atari.AtariEnv("seaquest", frameskip=(2, 5), sound_obs=True)), steps),
    "atari.vector.env.AtariVectorEnv": (lambda: vector(preset="baselines", interventions=["infinite_lives"]), steps),
    "atari.games.game.Game": (lambda: atari.games["ms_pacman"], itself),
    "atari.task.task.Task": (lambda: atari.Task.of("pong", preset="dqn2015"), itself),
    **{f"atari.wrappers.{name}": (partial(wrapped, wrap), steps) for name, wrap in WRAPPERS.items()},
    "atari.multiplayer.core.MultiplayerCore": (
        lambda: core(
            MultiplayerCore,
            "tennis",
            mode=3,
            difficulty=1,
            repeat_action_probability=(0.25, 0.5),
            parameters={"max_turn_time": 100},
            mode_numbers="ale_py",
            end_of_reset="ale_py",
            sound=True,
        ),
        frames,
    ),
    "atari.multiplayer.parallel.MultiplayerEnv": (
        lambda: parallel(atari.multiplayer.MultiplayerEnv, "joust", preset="multiplayer_dqn", noops=(1, 9)),
        match,
    ),
    "atari.cores.ale.AleCore": (lambda: core(atari.cores.AleCore, mode=4, repeat_action_probability=0.5), frames),
    "atari.cores.native.NativeCore": (
        lambda: core(atari.cores.NativeCore, "breakout", sound=True, interventions=()),
        frames,
    ),
    "atari.ale_py.interface.ALEInterface": (raw_program, raw_frames),
    "atari.ale_py.interface.LoggerMode": (lambda: ale_py.LoggerMode.Error, itself),
    "atari.ale_py.env.AtariEnvStepMetadata": (
        lambda: ale_py.AtariEnvStepMetadata(lives=5, episode_frame_number=1, frame_number=2),
        itself,
    ),
    "atari.ale_py.vector_env.ALEVectorInterface": (raw_vector, raw_steps),
    "atari.multiplayer.ale.ALEInterface": (raw_match, raw_turns),
    "atari.cores.native.PlainCore": (lambda: core(atari.cores.PlainCore, "breakout", difficulty=1), frames),
    "atari.testing.contract.ContractError": (lambda: ContractError("a sentence"), text),
    "atari.recording.replay.record_search.RecordSearch": (
        lambda: started(RecordSearch(atari.AtariVectorEnv("breakout", 2))),
        lambda envs: [steps(envs), *map(plain, map(envs.trajectory, envs.snapshot()))],
    ),
    "atari.recording.video.record_video.RecordVideo": (lambda: video(lambda: atari.AtariEnv("pong")), steps),
    "atari.recording.replay.replay.Replay": (replay, lambda one: [one.verify(), one.frames_total, one.seeds]),
    "atari.play.session.Session": (lambda: Session("pong", seed=3), shown),
    "atari.lab.writes.Freeze": (lambda: with_(lambda env: Freeze(env, ball_x=90), started(unframed())), together),
    "atari.lab.writes.Poke": (lambda: with_(lambda env: Poke(env, {"ball_x": 90}), started(unframed())), together),
    "atari.lab.ram.Ram": (lambda: with_(Ram, started(unframed())), read),
    "atari.lab.ram_labels.RamLabels": (lambda: started(RamLabels(unframed())), steps),
    "atari.lab.search.Search": (lambda: with_(Search, started(unframed())), narrowed),
    "atari.lab.watch.Watch": (lambda: started(Watch(atari.AtariEnv("pong"), "ball_x", 5, each="frame")), watched),
    "atari.learning.environments.TrainingEnvironments": (training_environments, played),
    "atari.learning.options.TrainingOptions": (lambda: TrainingOptions.of("pong", seed=3), itself),
    "atari.learning.restarts.RestartOptions": (lambda: RestartOptions.of("pong", restart_share=0.5), itself),
    "atari.learning.evaluation.protocols.EvaluationProtocol": (lambda: PROTOCOLS["dopamine"], itself),
    "atari.learning.evaluation.published.Published": (lambda: Published("dopamine/rainbow"), facts),
    "atari.learning.memory.replay_memory.ReplayMemory": (memory, drawn),
    "atari.learning.evaluation.results.Result": (
        lambda: Result("mine", PROTOCOLS["dopamine"], 3, (GameResult("pong", (1.0,), (60,), (False,), (8,)),)),
        itself,
    ),
    "atari.integrations.envpool.pool.EnvPool": (pooled, pool_steps),
    "atari.integrations.envpool.pool.GymnasiumEnvPool": (pooled, pool_steps),
    "atari.integrations.envpool.spec.ArraySpec": (
        lambda: envpool.make_spec("Pong-v5").state_array_spec["obs"],
        itself,
    ),
    "atari.integrations.envpool.spec.EnvPoolSpec": (
        lambda: envpool.make_spec("Pong-v5", num_envs=3),
        lambda spec: [spec.config, spec.played, str(spec.observation_space)],
    ),
    "atari.classic.core.Env": (classic, steps),
    "atari.classic.core.Wrapper": (lambda: classic(gym.Wrapper), steps),
    "atari.classic.core.ActionWrapper": (lambda: classic(Reversed), steps),
    "atari.classic.core.ObservationWrapper": (lambda: classic(Inverted), steps),
    "atari.classic.core.RewardWrapper": (lambda: classic(Halved), steps),
    "atari.classic.core.GoalEnv": (Reached, lambda env: [plain(env.step(1)[0]) for _ in range(3)]),
    **{
        f"atari.classic.algorithmic.tasks.{name}Env": (partial(task, f"{name}-v0"), steps)
        for name in ("Copy", "DuplicatedInput", "RepeatCopy", "ReversedAddition", "Reverse")
    },
}
"""By the path of a public class: a function that makes an object, and one that plays it and returns the results."""

OTHERS: Mapping[str, Case] = {
    "AtariEnv with core='ale'": (lambda: started(atari.AtariEnv("breakout", core="ale")), steps),
    "AtariEnv with core='plain'": (lambda: started(atari.AtariEnv("breakout", core="plain")), steps),
    "AtariEnv before its first reset": (lambda: atari.AtariEnv("pong"), lambda env: steps(started(env))),
    "a core with held bytes": (
        lambda: with_(lambda one: Freeze(one, {0x31: 80}), core(atari.cores.NativeCore, "pong")),
        lambda pair: frames(pair[0]),
    ),
    "a core with another mode": (lambda: changed(core(atari.cores.NativeCore, "breakout")), frames),
    "a core of several players with another mode": (lambda: changed(core(MultiplayerCore, "pong", mode=4), 10), frames),
    "AleCore with sound": (lambda: core(atari.cores.AleCore, "pong", sound=True), frames),
    "parallel_env": (lambda: parallel(atari.multiplayer.parallel_env), match),
    "env": (lambda: parallel(atari.multiplayer.env), turns),
    "raw_env": (lambda: parallel(atari.multiplayer.raw_env), turns),
    "preset of several players": (
        lambda: parallel(atari.multiplayer.parallel_env, preset="multiplayer_dqn", agent_indicator=True),
        match,
    ),
    "preset": (lambda: started(atari.make("breakout", preset="baselines")), steps),
    "vector of a name": (lambda: vector(render_mode="rgb_array"), steps),
    "lane": (
        lambda: vector().lanes[1],
        lambda lane: [lane.lives, lane.frame_number, plain(lane.ram()), plain(lane.screen_rgb()), lane.index],
    ),
    "labels of a vector": (lambda: started(RamLabels(atari.AtariVectorEnv("pong", 2))), steps),
    "log of a vector": (lambda: started(Watch(atari.AtariVectorEnv("pong", 2), "ball_x")), watched),
    "video of a vector": (lambda: video(lambda: atari.AtariVectorEnv("pong", 2)), steps),
    "held bytes of a vector": (lambda: with_(lambda env: Freeze(env, ball_x=90), vector_of("pong")), together),
    "session of several players": (lambda: Session("combat", players=2, policies={1: "random"}, seed=3), plays),
    "batch": (lambda: memory().sample(4), lambda batch: [plain(part) for part in vars(batch).values()]),
    "compressed memory": (
        lambda: memory(stack_num=2, compress=True),
        lambda one: [len(one), plain(one.sample(8).observations)],
    ),
}
"""Further objects that the public names return or accept."""


def play_there(name: str, data: bytes) -> Any:
    """Play a pickled object in this process; for a process that was started for it."""
    return {**CASES, **OTHERS}[name][1](pickle.loads(data))


def in_new_process(pickles: Mapping[str, bytes]) -> dict[str, Any]:
    """The play of pickled objects, by name, in a process that has never seen them."""
    with multiprocessing.get_context("spawn").Pool(1) as pool:
        return {name: pool.apply(play_there, (name, data)) for name, data in pickles.items()}

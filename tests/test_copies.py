"""Every public class can be copied, in every way, and a copy plays on equally; or it refuses with a sentence.

A class refuses that holds an open file, window, socket or process. REFUSED has all of these.
"""

import copy
import pickle
import shutil
import subprocess
import sys
from collections.abc import Callable, Mapping
from functools import cache
from importlib import import_module
from pathlib import Path
from typing import Any

import cloudpickle
import gymnasium
import numpy as np
import pytest
import site_modules
from copied import CASES, FOLDER, OTHERS, WAYS, in_new_process, plain, started

import atari
from atari.learning import ReplayMemory
from atari.multiplayer import MultiplayerCore
from atari.recording import RecordReplay, VideoWriter

ABSTRACT = {
    "atari.cores.core.Core": "atari.cores.native.NativeCore",
    "atari.learning.agent.Agent": None,
    "atari.learning.agent.TrainingLoop": None,
    "atari.policy.Policy": None,
    "atari.policy.ScoresPolicy": None,
    "atari.classic.algorithmic.environment.AlgorithmicEnv": "atari.classic.algorithmic.tasks.CopyEnv",
    "atari.classic.algorithmic.tasks.GridEnv": "atari.classic.algorithmic.tasks.ReversedAdditionEnv",
    "atari.classic.algorithmic.tasks.TapeEnv": "atari.classic.algorithmic.tasks.CopyEnv",
}
"""Classes without objects of their own, and a class here that stands for them. Policies and agents are the user's own objects."""

ELSEWHERE = {
    "atari.cores.ale_actions.Action": "tests/ale_py/test_interface.py",
    "atari.learning.networks.Encoder": "tests/learning/test_networks.py",
    "atari.learning.replicas.Replicas": "tests/learning/test_agents.py",
    "atari.integrations.sb3.AtariVecEnv": "tests/peers/test_copies.py",
    "atari.integrations.sb3.RecordReplay": "tests/peers/test_copies.py",
    "atari.integrations.sb3.RecordVideo": "tests/peers/test_copies.py",
    "atari.integrations.ray.rllib.GameScores": "tests/distributed/test_rllib_config.py",
    "atari.integrations.ray.rollout_actors.RolloutActors": "tests/distributed/test_rollout_actors.py",
}
"""Classes that need an optional library, and the file that copies them."""


def played_through_another(folder: Path) -> Any:
    env = atari.AtariEnv("pong")
    env.ale = type("Ale", (), {"__getattr__": lambda self, name: getattr(env.driver.emulated, name)})()
    return env


def locked_run(folder: Path) -> Any:
    pytest.importorskip("torch")
    from atari.learning import RunFolder

    return RunFolder.begin(folder / "run", "mine", atari.Task.of("pong"), {})


def training(folder: Path) -> Any:
    pytest.importorskip("torch")
    from atari.learning import Training
    from atari.learning.agents.ppo import PPOOptions

    options = PPOOptions.of("pong", num_envs=1, horizon=4, minibatch=4, total_steps=4)
    return Training.begin("ppo", options, folder / "run")


_OF_REPLAY = "RecordReplay writes a file and cannot be copied or pickled; close it, or copy what it records"
_OF_RUN = (
    r"a RunFolder that is locked for a training cannot be copied or pickled: .*; pass the path, and use "
    r"RunFolder\.open\(path\) there"
)

REFUSED: Mapping[str, tuple[Callable[[Path], Any], str]] = {
    "atari.recording.replay.record_replay.RecordReplay": (
        lambda folder: RecordReplay(atari.AtariEnv("pong"), folder / "a.a26r"),
        _OF_REPLAY,
    ),
    "RecordReplay of a vector": (
        lambda folder: RecordReplay(atari.AtariVectorEnv("pong", 2), folder / "b.a26r"),
        _OF_REPLAY,
    ),
    "RecordReplay of a core": (lambda folder: RecordReplay(MultiplayerCore("pong"), folder / "c.a26r"), _OF_REPLAY),
    "atari.recording.video.writer.VideoWriter": (
        lambda folder: VideoWriter(folder / "a.gif", atari.games["pong"]),
        r"VideoWriter writes .*a\.gif and cannot be copied or pickled; make a new one",
    ),
    "AtariEnv with an assigned ale": (
        played_through_another,
        r"env\.ale was assigned, and that object plays this environment alone; assign the former env\.ale before you copy "
        "or pickle the environment",
    ),
    "ReplayMemory with a file": (
        lambda folder: ReplayMemory(10, 1, (4, 4), path=folder / "a.replay"),
        r"a ReplayMemory with a file cannot be copied or pickled: .*a\.replay is open for one object; close it and pass "
        r"the path to ReplayMemory\.open, or restore its state\(\) in a memory without a file",
    ),
    "atari.learning.run_folder.RunFolder": (locked_run, _OF_RUN),
    "atari.learning.training.Training": (training, _OF_RUN),
}
"""By class: a function that makes an object with an open file, and its refusal."""

OPTIONAL = ("atari.integrations.jax", "atari.integrations.ray", "atari.learning", "atari.sb3")
"""Pages of the reference with modules that need libraries which these tests lack."""


def test_every_public_class_is_copied_or_refuses() -> None:
    public = site_modules.load("public")
    classes = {found.path for module in public.MODULES for found in public.definitions(module) if found.kind == "class"}
    assert len(classes) > 50
    assert classes == ({*CASES, *REFUSED, *ABSTRACT, *ELSEWHERE} & classes)
    assert {*CASES, *ABSTRACT, *ELSEWHERE} <= classes
    assert {stand_in for stand_in in ABSTRACT.values() if stand_in} <= {*CASES}
    root = Path(__file__).parent
    for path, file in ELSEWHERE.items():
        assert path.rpartition(".")[2] in (root.parent / file).read_text(encoding="utf-8")


def test_every_public_constant_and_function_is_copied() -> None:
    public = site_modules.load("public")
    found = {one.path: one for module in public.MODULES for one in public.definitions(module) if one.kind != "class"}
    copied = 0
    for path, one in found.items():
        module, _, name = path.rpartition(".")
        try:
            value = getattr(import_module(module), name)
        except (ImportError, gymnasium.error.DependencyNotInstalled):
            assert one.page in OPTIONAL, path
            continue
        for way, duplicate in WAYS.items():
            assert duplicate(value) == value, (path, way)
        copied += 1
    assert copied > 60


@cache
def played(name: str) -> tuple[bytes, Any]:
    """The pickle of an object, and its play, which is that of its copies, too."""
    make, play = {**CASES, **OTHERS}[name]
    one = make()
    data, copies = cloudpickle.dumps(one), {way: duplicate(one) for way, duplicate in WAYS.items()}
    expected = play(one)
    for way, copied in copies.items():
        assert play(copied) == expected, way
    return data, expected


@pytest.mark.parametrize("name", [*CASES, *OTHERS])
def test_a_copy_plays_on_equally(name: str) -> None:
    played(name)


def test_copies_play_on_equally_in_a_new_process() -> None:
    there = in_new_process({name: played(name)[0] for name in (*CASES, *OTHERS)})
    for name, seen in there.items():
        assert seen == played(name)[1], name


@pytest.mark.parametrize("name", REFUSED)
def test_what_holds_an_open_file_refuses(name: str, tmp_path: Path) -> None:
    make, sentence = REFUSED[name]
    one = make(tmp_path)
    for duplicate in WAYS.values():
        with pytest.raises(TypeError, match=sentence):
            duplicate(one)
    one.close()


@pytest.mark.parametrize(
    "name",
    [
        "atari.env.env.AtariEnv",
        "atari.vector.env.AtariVectorEnv",
        "atari.cores.native.NativeCore",
        "atari.cores.ale.AleCore",
        "atari.multiplayer.core.MultiplayerCore",
        "atari.multiplayer.parallel.MultiplayerEnv",
    ],
)
def test_a_shallow_copy_has_an_emulator_of_its_own(name: str) -> None:
    make, play = CASES[name]
    one = make()
    other, third = copy.copy(one), copy.copy(one)
    assert play(one) == play(other) == play(third)


def test_a_folder_that_is_open_for_reading_is_copied(tmp_path: Path) -> None:
    run = locked_run(tmp_path)
    run.close()
    opened = type(run).open(tmp_path / "run")
    assert pickle.loads(pickle.dumps(opened)).config == opened.config


@pytest.mark.parametrize("duplicate", [copy.deepcopy, lambda batch: pickle.loads(pickle.dumps(batch))])
@pytest.mark.parametrize("stack", [1, 3])
@pytest.mark.parametrize("named", [False, True])
def test_a_copied_batch_shares_its_frames_and_can_be_filled(duplicate: Any, stack: int, named: bool) -> None:
    shape = {"image": (6, 5)} if named else (6, 5)
    memory = ReplayMemory(60, 2, shape, stack_num=3, seed=4)
    frames = np.arange(60, dtype=np.uint8).reshape(2, 6, 5)
    memory.reset({"image": frames} if named else frames)
    for number in range(20):
        seen = {"image": frames + number} if named else frames + number
        memory.add(np.zeros(2, int), np.zeros(2), np.zeros(2, bool), np.zeros(2, bool), observations=seen)
    batch = memory.make_batch(8, stack_num=stack, share=True)
    memory.sample(8, out=batch)
    other = duplicate(batch)
    assert plain(vars(other)["observations"]) == plain(batch.observations)
    memory.sample(8, out=other)
    again = memory.sample(8, stack_num=stack)
    for name in ("frames", "observations", "next_observations"):
        part, first = (getattr(each, name)["image"] if named else getattr(each, name) for each in (other, batch))
        assert not np.shares_memory(part, first)
        assert np.shares_memory(part, other.frames["image"] if named else other.frames)
    assert again.indices.shape == other.indices.shape


def test_a_core_with_a_cloned_state_of_ale_py_says_why_it_has_no_copy() -> None:
    core = atari.cores.AleCore("pong")
    core.reset()
    core.restore_state(core.clone_state())
    with pytest.raises(RuntimeError, match=r"a complete snapshot is possible again only after reset\(\)"):
        copy.deepcopy(core)


def test_a_copy_has_a_window_of_its_own(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("SDL_VIDEODRIVER", "dummy")
    env = atari.multiplayer.MultiplayerEnv("pong", render_mode="human")
    env.reset(seed=0)
    env.render()
    other = pickle.loads(pickle.dumps(env))
    other.close()
    env.step({})
    env.close()


def test_an_environment_of_old_gyms_class_is_copied(tmp_path: Path) -> None:
    """The class of such an environment is made when `gym` is there."""
    program = """
import copy, pickle
import gym
import numpy as np
import atari.integrations.envpool as envpool
envs = envpool.make_gym("Pong-v5", num_envs=2)
envs.reset()
copies = [copy.deepcopy(envs), pickle.loads(pickle.dumps(envs))]
assert all(isinstance(one, gym.Env) for one in copies)
assert len({one.step(np.array([2, 3]))[0].tobytes() for one in (envs, *copies)}) == 1
print("copied")
"""
    (tmp_path / "script.py").write_text(program)
    command = [sys.executable, "-m", "atari.classic", "script.py"]
    done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, timeout=120)
    assert done.stdout == "copied\n", done.stderr


def test_the_spaces_of_a_copy_draw_the_same(tmp_path: Path) -> None:
    envs = started(atari.AtariVectorEnv("pong", 2))
    other = copy.deepcopy(envs)
    envs.single_action_space.seed(5)
    third = pickle.loads(pickle.dumps(envs))
    assert plain(other.action_space.sample()) == plain(envs.action_space.sample())
    assert third.single_action_space.sample() == envs.single_action_space.sample()


@pytest.fixture(scope="module", autouse=True)
def folder() -> Any:
    FOLDER.mkdir(exist_ok=True)
    yield FOLDER
    shutil.rmtree(FOLDER, ignore_errors=True)

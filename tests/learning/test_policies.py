"""`load_policy`: the sources that it accepts, and its errors for all others."""

import json
import pickle
import sys
import zipfile
from dataclasses import replace

import gymnasium
import numpy as np
import pytest

from atari.cores import NativeCore
from atari.learning import PROTOCOLS, ScoresPolicy, evaluate, load_policy
from atari.learning.frame_agent import FrameAgent


def archive(file, **members):
    with zipfile.ZipFile(file, "w") as written:
        for name, content in members.items():
            written.writestr(name, content)
    return file


def sb3(file, **facts):
    return archive(file, data=json.dumps(facts), _stable_baselines3_version="2.9.2")


MODULE = """
def one(o): return [1] * len(o)
def two(o, lanes): return lanes
class Three:
    name = "three"
    def __call__(self, o, lanes): return lanes + 1
four = 4
class Five:
    def __init__(self, size): pass
"""


def test_functions_of_modules(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    monkeypatch.delitem(sys.modules, "mine", raising=False)  # another test may have imported it
    (tmp_path / "mine.py").write_text(MODULE)
    observations, lanes = np.zeros((2, 128), np.uint8), np.array([3, 4])
    assert load_policy("mine:one")(observations, lanes).tolist() == [1, 1]
    assert load_policy("mine:two")(observations, lanes).tolist() == [3, 4]
    assert load_policy("mine:Three")(observations, lanes).tolist() == [4, 5]
    assert load_policy("mine:two")(observations).tolist() == [0, 1]
    assert load_policy("mine:Three").name == "three"
    for name, text in [
        ("mine.py:one", "policy mine.py:one is named by its module: mine:one"),
        ("mine:five", "five"),
        ("nosuch:one", "nosuch"),
        (":one", "imported"),
        ("mine:four", "is a function of observations"),
        ("mine:Five", "Five cannot be made without arguments, give an instance"),
    ]:
        with pytest.raises(ValueError, match=text):
            load_policy(name)
    assert "" not in sys.path[:1]


@pytest.mark.parametrize(
    ("make", "error", "text"),
    [
        (lambda file: file, FileNotFoundError, "there is no file"),
        (lambda file: file.mkdir() or file, ValueError, "no run folder"),
        (lambda file: file.touch() or file, ValueError, "is no policy"),
        (lambda file: file.write_bytes(b"PK\3\4 damaged") and file, ValueError, "is no policy"),
        (lambda file: archive(file, picture="x"), ValueError, "neither a model"),
        (lambda file: archive(file, **{"a/data.pkl": "x"}), ValueError, "weights"),
        (lambda file: archive(file, data="{", _stable_baselines3_version="2"), ValueError, "is damaged"),
        (lambda file: archive(file, _stable_baselines3_version="2"), ValueError, "is damaged"),
        (lambda file: archive(file, data="[]", _stable_baselines3_version="2"), ValueError, "must be a table"),
    ],
)
def test_what_is_no_policy(tmp_path, make, error, text):
    with pytest.raises(error, match=text) as caught:
        load_policy(make(tmp_path / "policy.zip"))
    assert "policy.zip" in str(caught.value)


@pytest.mark.parametrize(
    ("name", "module", "content", "install"),
    [
        ("a.zip", "stable_baselines3", lambda file: sb3(file, clip_range=0.1), "pip install 'stable-baselines3>=2.9'"),
        ("a.pt", "torch", lambda file: archive(file, **{"a/code/a.py": ""}), "pip install 'torch>=2.2'"),
        ("a.onnx", "onnxruntime", lambda file: file.write_bytes(b"x"), "pip install onnxruntime"),
    ],
)
def test_a_missing_package_is_named(tmp_path, monkeypatch, name, module, content, install):
    content(tmp_path / name)
    monkeypatch.setitem(sys.modules, module, None)
    with pytest.raises(gymnasium.error.DependencyNotInstalled, match=install):
        load_policy(tmp_path / name)


def test_random_and_noop():
    policy, lanes = load_policy("random"), np.arange(3)
    policy.begin("pong", ("NOOP", "FIRE"), lanes, np.array([1, 2, 3]))
    actions = np.stack([policy(np.zeros((3, 128)), lanes) for _ in range(50)])
    assert set(actions.ravel()) == {0, 1}
    policy.begin("pong", ("NOOP", "FIRE"), lanes, np.array([1, 2, 3]))
    assert (actions == np.stack([policy(np.zeros((3, 128)), lanes) for _ in range(50)])).all()
    noop = load_policy("noop")
    with pytest.raises(ValueError, match="has no NOOP"):
        noop.begin("mine", ("FIRE",), lanes, lanes)


@pytest.mark.parametrize(
    "policy",
    ["random", "noop", ScoresPolicy(lambda observations: np.zeros((len(observations), 6), np.float32), sample=True)],
)
def test_what_has_not_begun_says_so(policy):
    with pytest.raises(ValueError, match=r"call begin\(game, actions, lanes, seeds\) before"):
        load_policy(policy)(np.zeros((3, 128)), np.arange(3))


def test_objects_are_loaded_as_they_are():
    class Mine:
        game = "pong"

        def __call__(self, observations, lanes):
            return lanes + 1

    for source in (Mine, Mine()):
        policy = load_policy(source)
        assert (policy.name, policy.game) == ("Mine", "pong")
        assert not hasattr(policy, "task")
        assert policy(np.zeros((2, 1)), np.arange(2)).tolist() == [1, 2]
        assert load_policy(policy) is policy
        policy.begin("pong", ("NOOP", "FIRE"), np.arange(2), np.arange(2))  # accepted, though it draws nothing
        policy.begin_episodes(np.arange(2))
        with pytest.raises(ValueError, match=r"policy Mine returned action 2; in pong it has 2 actions, 0\.\.1 \(NOOP"):
            policy(np.zeros((2, 1)), np.arange(2))
    assert load_policy(lambda: Mine()).game == "pong"
    assert pickle.loads(pickle.dumps(load_policy("noop"))).name == "noop"


@pytest.mark.parametrize(
    ("returned", "got"),
    [
        (np.zeros((2, 6), np.float32), r"float32 \(2, 6\)"),
        (np.zeros(2), r"float64 \(2,\)"),
        (np.zeros(3, int), r"int64 \(3,\)"),
        (None, r"array\(None"),
        (["UP", "DOWN"], "<U4"),
    ],
)
def test_what_a_policy_must_return(returned, got):
    policy = load_policy(lambda observations: returned)
    with pytest.raises(ValueError, match=rf"must return integers of shape \(2,\), .*, got {got}"):
        policy(np.zeros((2, 1)), np.arange(2))


def test_what_is_no_function_or_has_no_probabilities():
    for source in (None, 3, [], ("random",), {}):
        with pytest.raises(TypeError, match="a policy is a function of observations and lanes, got"):
            load_policy(source)
    for source in ("random", "noop", len, load_policy("random")):
        with pytest.raises(ValueError, match="sample=True draws actions with the probabilities of a network, and"):
            load_policy(source, sample=True)


def play(agent, core):
    while True:
        core.act(agent.act(core))


def test_scores_of_another_number_of_actions_are_refused():
    three = ScoresPolicy(lambda observations: np.zeros((len(observations), 3)), name="three")
    text = r"three gives scores of 3 actions, and in pong it has 6 \(NOOP, FIRE, RIGHT, .*name them by index"
    with pytest.raises(ValueError, match=text):
        evaluate(three, "pong", "baselines", episodes=1)
    agent, core = FrameAgent(three), NativeCore("pong")
    agent.begin(core)
    with pytest.raises(ValueError, match=text):
        play(agent, core)
    three.environment = {"actions": ["NOOP", "RIGHT", "LEFT"]}
    protocol = replace(PROTOCOLS["baselines"], name="short", max_frames=60)
    assert evaluate(three, "pong", protocol, episodes=1).games[0].frames == (60,)

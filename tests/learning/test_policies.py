"""`load_policy`: what it accepts, and what it says about everything else."""

import json
import sys
import zipfile

import gymnasium
import numpy as np
import pytest

from atari.learning import load_policy


def archive(file, **members):
    with zipfile.ZipFile(file, "w") as written:
        for name, content in members.items():
            written.writestr(name.replace("__", "/"), content)
    return file


def sb3(file, **facts):
    return archive(file, data=json.dumps(facts), _stable_baselines3_version="2.9.2")


def test_functions_of_modules(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "mine.py").write_text(
        "def one(o): return [1] * len(o)\n"
        "def two(o, lanes): return lanes\n"
        "class Three:\n"
        "    name = 'three'\n"
        "    def __call__(self, o, lanes): return lanes + 1\n"
        "four = 4\n"
    )
    observations, lanes = np.zeros((2, 128), np.uint8), np.array([3, 4])
    assert load_policy("mine:one")(observations, lanes) == [1, 1]
    assert load_policy("mine:two")(observations, lanes).tolist() == [3, 4]
    assert load_policy("mine:Three")(observations, lanes).tolist() == [4, 5]
    assert load_policy("mine:Three").name == "three"
    for name, text in [
        ("mine:five", "five"),
        ("nosuch:one", "nosuch"),
        (":one", "imported"),
        ("mine:four", "is a function of observations"),
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
        (
            lambda file: archive(file, archive__data__pkl="x") and archive(file, **{"a/data.pkl": "x"}),
            ValueError,
            "weights",
        ),
        (lambda file: archive(file, data="{", _stable_baselines3_version="2"), ValueError, "is damaged"),
        (lambda file: archive(file, _stable_baselines3_version="2"), ValueError, "is damaged"),
        (lambda file: archive(file, data="[]", _stable_baselines3_version="2"), ValueError, "neither a model"),
    ],
)
def test_what_is_no_policy(tmp_path, make, error, text):
    with pytest.raises(error, match=text) as caught:
        load_policy(make(tmp_path / "policy.zip"))
    assert "policy.zip" in str(caught.value)


@pytest.mark.parametrize(
    ("name", "module", "content", "install"),
    [
        ("a.zip", "stable_baselines3", lambda file: sb3(file, clip_range=0.1), r"atari-envs\[sb3\]"),
        ("a.pt", "torch", lambda file: archive(file, **{"a/code/a.py": ""}), r"atari-envs\[learn\]"),
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

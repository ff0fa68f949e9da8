"""Interventions: their files, and the same play in single environments, vectors, snapshots and replays."""

import copy
import json
import pickle
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any

import gymnasium
import numpy as np
import pytest

import atari
from atari.cores import AleCore, NativeCore, PlainCore
from atari.games.interventions import resolve
from atari.lab.interventions import check, load
from atari.recording.replay.record_replay import RecordReplay
from atari.recording.replay.replay import Replay
from atari.task.json_form import to_short_json

RANDOM = {
    "name": "shaky",
    "description": "The ball jumps at random, and the opponent stands still.",
    "source": "own",
    "writes": [
        {"to": "ball_x", "value": "old + random(-3, 3)", "if": "ball_x > 20 and frame % 7 == 0"},
        {"to": "enemy_y", "value": "old"},
        {"to": 3, "mask": 0x0F, "value": "random(0, 15)", "when": [0, 5, 90]},
        {"to": 0xFE, "value": "frame", "when": "reset"},
    ],
}
"""In Pong, one of each kind of write."""

GOOD = """
[one]
description = "d"
source = "own"
writes = [{to = "ball_x", value = 3}]
check = {frames = 10, holds = "ball_x == 3"}
"""


def played(core: Any, frames: int = 400) -> list[tuple[int, bytes]]:
    core.reset()
    return [(core.act(frame // 5 % 6), core.ram().tobytes()) for frame in range(frames)]


def file_of(folder: Path, text: str) -> Path:
    path = folder / "mine.toml"
    path.write_text(text)
    return path


@pytest.mark.parametrize(
    "make_vector",
    [partial(gymnasium.make_vec, "ALE/Pong-v5"), partial(atari.AtariVectorEnv, "pong")],
    ids=["ID", "class"],
)
def test_every_environment_takes_a_name(make_vector: Any) -> None:
    if gymnasium.__version__ < "1" and make_vector.func is gymnasium.make_vec:
        pytest.skip("Gymnasium 0.29's make_vec makes a vector of single environments")
    single = gymnasium.make("ALE/Pong-v5", interventions=["lazy_enemy"])
    vector = make_vector(num_envs=2, interventions=["lazy_enemy"])
    preset = atari.make("pong", preset="dqn2015", interventions=["lazy_enemy"])
    for env in (single, preset):
        assert [one.name for one in env.unwrapped.interventions] == ["lazy_enemy"]
        env.reset(seed=0)
        for _ in range(20):
            env.step(env.action_space.sample())
    vector.reset(seed=0)
    for _ in range(20):
        vector.step(vector.action_space.sample())
    enemies = {int(lane.ram()[50]) for lane in vector.unwrapped.lanes}
    enemies |= {int(env.unwrapped.core.ram()[50]) for env in (single, preset)}
    assert len(enemies) == 1


def test_fast_and_reference_core_play_the_same() -> None:
    interventions = resolve(atari.games["pong"], [RANDOM])
    fast, plain = (played(kind("pong", seed=5, interventions=interventions)) for kind in (NativeCore, PlainCore))
    assert fast == plain
    assert fast != played(NativeCore("pong", seed=5))


def test_a_vector_plays_as_single_environments() -> None:
    options: dict[str, Any] = {"interventions": [RANDOM], "repeat_action_probability": 0.25}
    envs = atari.AtariVectorEnv("pong", 3, frameskip=4, noop_max=1, use_fire_reset=False, **options)
    singles = [atari.AtariEnv("pong", frameskip=4, **options) for _ in range(3)]
    envs.reset(seed=[11, 12, 13])
    for seed, env in zip((11, 12, 13), singles, strict=True):
        env.core.seed(seed)
        env.core.reset()
        env.driver.phase = "playing"
    for step in range(100):
        actions = np.array([step, step // 2, step // 3]) % 6
        rewards = envs.step(actions)[1]
        for lane, env, action, reward in zip(envs.lanes, singles, actions, rewards, strict=True):
            assert env.step(int(action))[1] == reward
            assert env.core.ram().tobytes() == lane.ram().tobytes()


def test_random_numbers_follow_the_seed_and_leave_sticky_actions_alone() -> None:
    def repeats(*interventions: Any) -> list[int]:
        env = atari.AtariEnv("pong", frameskip=1, interventions=list(interventions))
        env.reset(seed=4)
        held = []
        for step in range(200):
            env.step(step % 6)
            held.append(int(env.core.clone_state(include_rng=True).serialize()[24 + 4 * 624]))  # the generator's place
        return held

    unused = {**RANDOM, "writes": [{"to": 100, "value": "random(0, 255)"}]}
    assert repeats(unused) == repeats()
    runs = []
    for seed in (1, 1, 2):
        core = NativeCore("pong", seed=seed, interventions=resolve(atari.games["pong"], [unused]))
        runs.append([ram[100] for _, ram in played(core, 50)])
    assert runs[0] == runs[1] != runs[2]
    assert len(set(runs[0])) > 30


def test_random_stays_within_its_bounds() -> None:
    dice = {**RANDOM, "writes": [{"to": 100, "value": "random(3, 6)"}, {"to": 101, "value": "random(9, 2)"}]}
    core = NativeCore("pong", interventions=resolve(atari.games["pong"], [dice]))
    rams = [ram for _, ram in played(core, 300)]
    assert {ram[100] for ram in rams} == {3, 4, 5, 6}
    assert {ram[101] for ram in rams} == {9}


def test_when() -> None:
    def values(**write: Any) -> list[int]:
        table = {**RANDOM, "writes": [{"to": 100, "value": "old + 1", **write}]}
        core = NativeCore("pong", interventions=resolve(atari.games["pong"], [table]))
        core.reset()
        start = NativeCore("pong")
        start.reset()
        first = int(start.ram()[100])
        return [int(core.ram()[100]) - first, *(int(ram[100]) - first for _, ram in frames(core))]

    def frames(core: Any) -> list[tuple[int, bytes]]:
        return [(core.act(0), core.ram().tobytes()) for _ in range(6)]

    assert values() == [0, 1, 2, 3, 4, 5, 6]
    assert values(when="reset") == [1] * 7
    assert values(when=0) == [1] * 7
    assert values(when=3) == [0, 0, 0, 1, 1, 1, 1]
    assert values(when=[0, 2, 5]) == [1, 1, 2, 2, 2, 3, 3]
    assert values(**{"if": "frame % 2 == 0"}) == [0, 0, 1, 1, 2, 2, 3]


def test_a_reset_write_pays_nothing_and_is_seen_at_once() -> None:
    lives = {**RANDOM, "writes": [{"to": "lives", "value": 2, "when": "reset"}]}
    env = atari.AtariEnv("breakout", interventions=[lives])
    assert env.reset(seed=0)[1]["lives"] == 2
    score = {**RANDOM, "writes": [{"to": "score_player", "value": 5, "when": "reset"}]}
    env = atari.AtariEnv("pong", interventions=[score])
    env.reset(seed=0)
    assert env.step(0)[1] == 0.0
    assert env.core.ram()[14] == 5


def test_snapshots_continue_exactly() -> None:
    env = atari.AtariEnv("pong", interventions=[RANDOM])
    env.reset(seed=3)
    for step in range(30):
        env.step(step % 6)
    data, state = env.snapshot(), env.clone_state(include_rng=True)
    other = atari.AtariEnv("pong", interventions=[RANDOM])
    other.restore(data)
    copies = [other, copy.deepcopy(env), pickle.loads(pickle.dumps(env))]
    played_on = [(*env.step(step % 6)[1:3], env.core.ram().tobytes()) for step in range(60)]
    for one in copies:
        assert [(*one.step(step % 6)[1:3], one.core.ram().tobytes()) for step in range(60)] == played_on
    env.restore_state(state)
    assert [(*env.step(step % 6)[1:3], env.core.ram().tobytes()) for step in range(60)] == played_on
    with pytest.raises(ValueError, match=r"interventions = 'shaky \(.*\)', but this environment has None"):
        atari.AtariEnv("pong").restore(data)


def test_vector_snapshots_and_forks() -> None:
    envs = atari.AtariVectorEnv("pong", 2, interventions=[RANDOM])
    envs.reset(seed=0)
    for _ in range(20):
        envs.step(np.array([2, 3]))
    saved = pickle.loads(pickle.dumps(envs.snapshot()))
    runs = []
    for _ in range(2):
        runs.append([envs.step(np.array([2, 3]))[0].tobytes() for _ in range(20)])
        envs.restore(None, saved)
    assert runs[0] == runs[1]
    envs.fork(0, [1])
    for _ in range(20):
        observations = envs.step(np.array([2, 2]))[0]
        assert (observations[0] == observations[1]).all()


def recorded(folder: Path, *interventions: Any) -> tuple[Replay, bytes]:
    """A replay of 200 steps, and the RAM at its end."""
    env = RecordReplay(atari.AtariEnv("pong", interventions=list(interventions)), folder / "x.a26r")
    env.reset(seed=1)
    for step in range(200):
        env.step(step % 6)
    ram = env.unwrapped.core.ram().tobytes()  # type: ignore[attr-defined]
    env.close()
    return Replay.load(folder / "x.a26r"), ram


@pytest.mark.parametrize("interventions", [["lazy_enemy"], [RANDOM]])
def test_replays_have_them_and_verify(tmp_path: Path, interventions: list[Any]) -> None:
    replay, ram = recorded(tmp_path, *interventions)
    assert replay.verify()
    assert replay.verify("plain")
    assert replay.seek(replay.frames_total).ram().tobytes() == ram
    assert [one.name for one in replay.make_env().interventions] == [
        one if isinstance(one, str) else one["name"] for one in interventions
    ]
    with pytest.raises(ValueError, match="use interventions with core='native'"):
        replay.verify("ale")


def test_a_replay_of_other_writes_differs(tmp_path: Path) -> None:
    replay, _ = recorded(tmp_path, RANDOM)
    replay.header["options"]["interventions"][0]["writes"][0]["value"] = "old + random(-3, 4)"
    assert not replay.verify()


@pytest.mark.parametrize("wrong", [["lazy_enemy"], ["x.toml#y"], 3, [{"name": "x"}], {"a": 1}])
def test_a_replay_chooses_no_files(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, wrong: Any) -> None:
    env = atari.AtariEnv("pong")
    options, text = env.ale_options(), to_short_json(env.task)
    forged = json.dumps({**json.loads(text), "interventions": wrong})
    with monkeypatch.context() as patch:
        patch.setattr(env, "ale_options", lambda: {**options, "interventions": wrong})
        RecordReplay(env, tmp_path / "options.a26r").close()
    env = atari.AtariEnv("pong")
    with monkeypatch.context() as patch:
        patch.setattr("atari.recording.replay.recorded_core.to_short_json", lambda task: forged)
        RecordReplay(env, tmp_path / "task.a26r").close()
    for name in ("options", "task"):
        with pytest.raises(ValueError, match="its header is wrong"):
            Replay.load(tmp_path / f"{name}.a26r")


def test_a_replay_without_them_has_no_such_option(tmp_path: Path) -> None:
    assert "interventions" not in recorded(tmp_path)[0].options


def test_a_vector_is_recorded_with_them(tmp_path: Path) -> None:
    envs = RecordReplay(atari.AtariVectorEnv("pong", 2, interventions=["lazy_enemy"]), tmp_path / "x.a26r", 1)
    envs.reset(seed=0)
    for step in range(50):
        envs.step(np.full(2, step % 6))
    envs.close()
    assert Replay.load(tmp_path / "x.a26r").verify()


def test_a_check_that_fails(tmp_path: Path) -> None:
    path = file_of(tmp_path, GOOD.replace('holds = "ball_x == 3"', 'holds = "ball_x == 4"'))
    result = check("pong", f"{path}#one")
    assert not result
    assert (result.with_it, result.first_failure) == (0.0, 1)
    assert "pong one: FAILED: true on 'ball_x == 4' 0.0% with it" in str(result)
    always = file_of(tmp_path, GOOD.replace('holds = "ball_x == 3"', 'holds = "ball_x < 300"'))
    assert not check("pong", f"{always}#one")  # it holds without the intervention too


@pytest.mark.parametrize(
    ("expression", "passed"),
    [
        ('more = "pixels"', True),
        ('more = "pixels", by = 1000000', True),
        ('less = "pixels"', False),
        ('less = "changes(ball_x)"', True),
        ('more = "changes(ball_x)"', False),
        ('holds = "reward < 100 and lives == 0 and frame > 0 and first(ball_x) == 3 and ram[49] == 52"', True),
        ('holds = "3 <= ball_x < 4 and bcd(0xB1) != count(0x80, 0x81, 3, 4) - 9"', True),
    ],
)
def test_what_checks_measure(tmp_path: Path, expression: str, passed: bool) -> None:
    text = GOOD.replace("frames = 10", "frames = 200, after = 20").replace('holds = "ball_x == 3"', expression)
    assert bool(check("pong", f"{file_of(tmp_path, text)}#one")) is passed


def test_a_file_of_ones_own(tmp_path: Path) -> None:
    path = file_of(tmp_path, GOOD)
    env = atari.AtariEnv("pong", obs_type="ram", interventions=[f"{path}#one"])
    env.reset(seed=0)
    assert env.step(0)[0][49] == 52
    assert check("pong", {**load("pong", path)["one"].definition(), "check": {"frames": 200, "holds": "ball_x == 3"}})
    path.write_text(GOOD.replace("value = 3", "value = 5"))
    assert load("pong", path)["one"].writes[0].value == 5


@pytest.mark.parametrize(
    ("before", "after", "text"),
    [
        ("[one]", "one = 3\n[two]", r"\[one\] must be a table"),
        ("[one]", "[one", "mine.toml: "),
        ('source = "own"', "", r"\[one\] needs the key 'source'"),
        ('source = "own"', "sauce = 1\nsource = 'own'", r"\[one\] has no key 'sauce'; did you mean 'source'"),
        ('source = "own"', "source = 3", r"\[one\]: 'source' must be a text"),
        ('source = "own"', "source = 'own'\npaid = 3", r"\[one\]: 'paid' must be true or false"),
        ('"ball_x", value', '"bal_x", value', r"writes\[0\], to: pong has no label 'bal_x'; did you mean 'ball_x'"),
        ('"ball_x", value', "true, value", r"writes\[0\]: 'to' must be a text or a whole number, got True"),
        ('"ball_x", value', "256, value", r"writes\[0\], to must be within 0..255, got 256"),
        ('"ball_x", value', "5, mask = 0, value", r"writes\[0\], mask must be within 1..255"),
        ('"ball_x", value', '5, mask = "x", value', r"writes\[0\], mask must be an integer"),
        ('"ball_x", value', '"ball_x", mask = 3, value', r"writes\[0\], mask: the label 'ball_x' has its own"),
        ("value = 3", "value = 3.5", r"writes\[0\]: 'value' must be a text or a whole number, got 3.5"),
        ("value = 3", 'value = "new"', r"writes\[0\], value: in 'new', pong has no label 'new'"),
        ("value = 3", 'value = "random(1)"', r"writes\[0\], value: in 'random\(1\)', random\(\) has 1 arguments"),
        ("value = 3", "value = 3, when = 'never'", r"writes\[0\], when: must be 'frame', 'reset', a frame"),
        ("value = 3", "value = 3, when = [-1]", r"writes\[0\], when: must be"),
        ("value = 3", "value = 3, when = []", r"writes\[0\], when: must be"),
        ("value = 3", 'value = 3, if = "=="', r"writes\[0\], if: '==' is not an expression"),
        ("value = 3", "value = 3, if = 3", r"writes\[0\]: 'if' must be a text or none, got 3"),
        ('[{to = "ball_x", value = 3}]', "[]", r"\[one\], writes: must be a list of 1..64 tables"),
        ("frames = 10, ", "", "check needs the key 'frames'"),
        ("frames = 10", "frames = 0", "check, frames must be within 1.."),
        ("frames = 10", 'frames = "x"', "check: 'frames' must be a whole number, got 'x'"),
        ("frames = 10", "frames = 10, after = 10", "check, after must be within 0..9"),
        ("frames = 10", 'frames = 10, actions = ["JUMP"]', "check, actions: must be 'random', 'noop' or a list"),
        ("frames = 10", "frames = 10, by = 2", "check, by: is the factor of 'more' and 'less'"),
        ("frames = 10", 'frames = 10, more = "1"', "check: needs one of 'holds', 'more' and 'less', got holds, more"),
        ("ball_x == 3", "first(bal) == 3", "check, holds: pong has no label 'bal'; did you mean 'ball_y'"),
        ("ball_x == 3", "scores == 3", "check, holds: in 'scores == 3', pong has no label 'scores'"),
    ],
)
def test_wrong_files(tmp_path: Path, before: str, after: str, text: str) -> None:
    assert before in GOOD
    path = file_of(tmp_path, GOOD.replace(before, after, 1))
    with pytest.raises(ValueError, match=text) as error:
        atari.AtariEnv("pong", interventions=[f"{path}#one"])
    assert str(path) in str(error.value)


@pytest.mark.parametrize(
    ("make", "error", "text"),
    [
        (lambda: atari.AtariEnv("pong", interventions=["lasy_enemy"]), ValueError, "did you mean 'lazy_enemy'"),
        (
            lambda: atari.AtariEnv("seaquest", interventions=["infinite_oxygen"]),
            ValueError,
            r"did you mean 'infinite_lives'\? It has endless_oxygen, fast_submarine",
        ),
        (lambda: atari.AtariEnv("pong", interventions="lazy_enemy"), TypeError, "must be a list of names"),
        (lambda: atari.AtariEnv("pong", interventions=[3]), TypeError, "an intervention is a name"),
        (
            lambda: atari.AtariEnv("pong", interventions=["x.toml#y"]),
            FileNotFoundError,
            r"there is no file of interventions x\.toml; \. has no file 'x\.toml'",
        ),
        (lambda: atari.AtariEnv("pong", interventions=["/dev/null#y"]), ValueError, "null"),
        (lambda: atari.AtariEnv("pong", interventions=[{"writes": []}]), ValueError, "needs its name"),
        (lambda: atari.AtariEnv("pong", intervention=["lazy_enemy"]), TypeError, "did you mean 'interventions'"),
        (lambda: atari.AtariEnv("pong", core="ale", interventions=["lazy_enemy"]), ValueError, "core='native'"),
        (lambda: atari.AtariEnv("pong", interventions=[RANDOM] * 17), ValueError, "64 writes together, these have 68"),
        (lambda: atari.AtariVectorEnv("pong", 2, interventions=["lasy"]), ValueError, "did you mean 'lazy_enemy'"),
        (
            lambda: atari.AtariVectorEnv(["pong", "wizard_of_wor"], interventions=["lazy_enemy"]),
            ValueError,
            "wizard_of_wor has no",
        ),
        (lambda: AleCore("pong", interventions=resolve(atari.games["pong"], [RANDOM])), ValueError, "core='native'"),
        (lambda: check("pong", RANDOM), ValueError, "'shaky' of pong has no check"),
        (lambda: check("pong", "x"), ValueError, "pong has no intervention 'x'"),
    ],
)
def test_wrong_options(make: Callable[[], Any], error: type[Exception], text: str) -> None:
    with pytest.raises(error, match=text):
        make()


def test_a_value_that_a_label_cannot_have() -> None:
    constant = {**RANDOM, "writes": [{"to": "ball_x", "value": 500}]}
    with pytest.raises(ValueError, match=r"writes\[0\], value: ball_x cannot be 500; its values are -49..206"):
        atari.AtariEnv("pong", interventions=[constant])
    computed = {**RANDOM, "writes": [{"to": "ball_x", "value": "500 + frame"}]}
    env, twin = atari.AtariEnv("pong", interventions=[computed]), atari.AtariEnv("pong")
    for one in (env, twin):
        one.reset(seed=0)
        for step in range(20):
            one.step(step % 6)
    assert (env.core.ram() == twin.core.ram()).all()  # it is not written


def test_a_file_that_does_not_exist_suggests_the_nearest(tmp_path: Path) -> None:
    (tmp_path / "calm_sea.toml").touch()
    with pytest.raises(FileNotFoundError, match=r"there is no file .*cam_sea\.toml; .* did you mean 'calm_sea\.toml'"):
        atari.AtariEnv("pong", interventions=[f"{tmp_path / 'cam_sea.toml'}#calm"])


def test_a_write_to_a_derived_byte_alone_does_not_pass_the_check_of_its_effect() -> None:
    lazy = load("pong")["lazy_enemy"].definition()
    assert check("pong", lazy).passed
    alone = {**lazy, "writes": [write for write in lazy["writes"] if write["to"] == "enemy_y"]}
    assert not check("pong", alone).passed


def test_a_byte_that_the_game_does_not_use_does_not_pass_although_it_holds() -> None:
    rules = {"description": "nothing", "source": "own", "writes": [{"to": 120, "value": 77}]}
    result = check("pong", {"name": "idle", **rules, "check": {"frames": 60, "holds": "ram[120] == 77"}})
    assert (result.with_it, result.without, result.ram, result.picture) == (1, 0, 0, 0)
    assert not result


def test_a_check_takes_a_task_with_its_mode() -> None:
    result = check(atari.Task.of("pong", mode=1), "lazy_enemy")
    assert (result.game, result.task.mode, result.passed) == ("pong", 1, True)
    assert check("ALE/Pong-v5", "lazy_enemy", mode=1) == result
    with pytest.raises(ValueError, match="check has no place for interventions="):
        check(atari.Task.of("pong", interventions=["lazy_enemy"]), "lazy_enemy")
    with pytest.raises(ValueError, match="pong has no mode 9"):
        check("pong", "lazy_enemy", mode=9)

"""`Freeze` holds bytes at every emulated frame, in single environments, cores and vectors."""

from collections.abc import Callable
from typing import Any

import gymnasium
import numpy as np
import pytest
from env_tools import Observer, playing, started

import atari
from atari.cores import AleCore, NativeCore, PlainCore
from atari.lab import Freeze, Poke, Ram

RIGHT, BALL_X, PLAYER_Y, SCORE = 2, 49, 51, 14


@pytest.fixture
def env() -> atari.AtariEnv:
    return playing()


@pytest.mark.parametrize("core", ["native", "plain"])
def test_a_frozen_byte_stays_at_every_frame_of_a_skip_and_in_the_observation(core: str) -> None:
    env = playing(obs_type="ram", core=core)
    frames = Observer(env, lambda *frame: int(env.core.ram()[BALL_X]))
    with Freeze(env, {BALL_X: 120}):
        assert env.core.ram()[BALL_X] == 120  # at once
        observations = [env.step(RIGHT)[0] for _ in range(20)]
    assert frames.seen == [120] * 80
    assert {int(observation[BALL_X]) for observation in observations} == {120}
    env.step(RIGHT)
    assert env.core.ram()[BALL_X] != 120


def test_set_ram_alone_would_not_hold_it(env: atari.AtariEnv) -> None:
    env.core.set_ram(BALL_X, 120)
    env.step(RIGHT)
    assert env.core.ram()[BALL_X] == 124


def test_a_label_is_held_by_its_value_and_an_address_is_a_place(env: atari.AtariEnv) -> None:
    with Freeze(env, ball_x=71), Freeze(env, {0x80 + PLAYER_Y: 90}):
        env.step(RIGHT)
        assert env.core.ram()[BALL_X] == 71 + 49
        assert env.core.ram()[PLAYER_Y] == 90


def test_the_values_of_digits_are_digits() -> None:
    env = started()
    with Freeze(env, score_1=35):
        env.step(0)
        assert env.core.ram()[77] == 0x35


def test_a_mask_keeps_the_other_bits() -> None:
    label = next(
        (game, label) for game in atari.games.playable() for label in game.ram_labels.values()
        if label.mask == 15 and label.transform is None and label.encoding is None
    )  # fmt: skip
    game, found = label
    core = NativeCore(game)
    core.set_ram(found.index, 0xA3)
    with Freeze(core, {found.name: 9}):
        assert core.ram()[found.index] == 0xA9


def test_a_reset_keeps_a_freeze(env: atari.AtariEnv) -> None:
    with Freeze(env, {BALL_X: 99}):
        env.reset()
        assert env.core.ram()[BALL_X] == 99
        env.reset(seed=1)
        assert env.core.ram()[BALL_X] == 99
        env.step(RIGHT)
        assert env.core.ram()[BALL_X] == 99


def test_old_holds_what_is_there(env: atari.AtariEnv) -> None:
    here = env.core.ram()[PLAYER_Y]
    with Freeze(env, {PLAYER_Y: "old"}):
        for action in [2, 3] * 5:
            env.step(action)
        assert env.core.ram()[PLAYER_Y] == here


@pytest.mark.parametrize(("paid", "rewards"), [(True, [7.0, 0.0]), (False, [0.0, 0.0])])
def test_a_frozen_score_is_rewarded_unless_it_is_not_paid(paid: bool, rewards: list[float]) -> None:
    env = playing()
    with Freeze(env, {SCORE: 7}, paid=paid):
        assert [env.step(0)[1] for _ in range(2)] == rewards
        assert env.core.ram()[SCORE] == 7


def test_without_pay_the_program_is_still_rewarded() -> None:
    rewards = []
    for frozen in (False, True):
        env = started("space_invaders", repeat_action_probability=0.0)
        if frozen:
            Freeze(env, {0x80 + 104: "old"}, paid=False)  # a byte of the score does not count on
        rewards.append([env.step(action)[1] for action in [1, 2, 1, 3] * 40])
    first = next(index for index, reward in enumerate(rewards[0]) if reward)
    assert rewards[0][: first + 1] == rewards[1][: first + 1]


def test_both_cores_play_the_same() -> None:
    played = []
    for kind in (NativeCore, PlainCore):
        core = kind("seaquest", seed=3)
        core.reset()
        Freeze(core, {70: "old + random(0, 3)", 0xB0: "ram[12] ^ frame"}, paid=False)
        played.append([(core.act(action % 18), core.ram().tobytes()) for action in range(300)])
    assert played[0] == played[1]


def test_lanes_of_a_vector() -> None:
    envs = atari.AtariVectorEnv("pong", 3)
    envs.reset(seed=0)
    with Freeze(envs, {BALL_X: np.array([100, 110, 120])}), Freeze(envs, {PLAYER_Y: 66}, index=1):
        for _ in range(5):
            envs.step(np.full(3, RIGHT))
        assert [lane.ram()[BALL_X] for lane in envs.lanes] == [100, 110, 120]
        assert [bool(lane.ram()[PLAYER_Y] == 66) for lane in envs.lanes] == [False, True, False]
    envs.lanes[2].set_ram(BALL_X, 60)
    envs.step(np.full(3, RIGHT))
    assert envs.lanes[2].ram()[BALL_X] != 120


def test_a_vector_that_is_closed_and_reset_is_still_frozen() -> None:
    envs = atari.AtariVectorEnv("pong", 2)
    envs.reset(seed=0)
    freeze = Freeze(envs, {BALL_X: 100}, index=1)
    for _ in range(2):
        envs.close()
        envs.reset()
        envs.step(np.full(2, RIGHT))
        assert (envs.ram()[:, BALL_X] == 100).tolist() == [False, True]
    freeze.release()
    envs.lanes[1].set_ram(BALL_X, 60)
    envs.step(np.full(2, RIGHT))
    assert envs.ram()[1, BALL_X] != 100


def test_a_vector_that_is_closed_inside_is_not_frozen_later() -> None:
    envs = atari.AtariVectorEnv("pong", 2)
    envs.reset(seed=0)
    other = Freeze(envs, {PLAYER_Y: 66})
    with Freeze(envs, {BALL_X: 100}):
        envs.close()
    envs.reset()
    envs.step(np.full(2, RIGHT))
    assert (envs.ram()[:, BALL_X] != 100).all()
    assert (envs.ram()[:, PLAYER_Y] == 66).all()
    envs.close()
    other.release()
    other.release()


def test_a_snapshot_does_not_end_it_and_a_restore_does_not_begin_it(env: atari.AtariEnv) -> None:
    before = env.snapshot()
    freeze = Freeze(env, {BALL_X: 120})
    frozen = env.snapshot()
    env.restore(before)
    env.step(RIGHT)
    assert env.core.ram()[BALL_X] == 120
    freeze.release()
    freeze.release()
    env.restore(frozen)
    env.step(RIGHT)
    assert env.core.ram()[BALL_X] != 120


def test_sound_keeps_it(env: atari.AtariEnv) -> None:
    freeze = Freeze(env, {BALL_X: 120})
    env.driver.make_sound()
    env.step(RIGHT)
    assert env.core.ram()[BALL_X] == 120
    assert freeze is not None


def test_it_ends_with_the_environment(env: atari.AtariEnv) -> None:
    freeze = Freeze(env, {BALL_X: 120})
    env.close()
    freeze.release()
    env.reset()
    env.step(RIGHT)
    assert env.core.ram()[BALL_X] != 120


def test_at_most_64(env: atari.AtariEnv) -> None:
    for index in range(64):
        Freeze(env, {index: "old"})
    with pytest.raises(ValueError, match="at most 64 writes"):
        Freeze(env, {64: "old"})


@pytest.mark.parametrize(
    ("freeze", "error", "text"),
    [
        (lambda env: Freeze(env, ballx=3), ValueError, "pong has no label 'ballx'; did you mean 'ball_x'"),
        (lambda env: Freeze(env, ball_x=900), ValueError, "ball_x cannot be 900; its values are -49..206"),
        (lambda env: Freeze(env, {256: 3}), ValueError, "a place in RAM must be within 0..255, got 256"),
        (lambda env: Freeze(env, {1.5: 3}), TypeError, "a place in RAM must be an integer"),
        (lambda env: Freeze(env, {3: 256}), ValueError, "value must be within 0..255, got 256"),
        (lambda env: Freeze(env, {3: 1.5}), TypeError, "the value of 3 must be an integer"),
        (lambda env: Freeze(env, {3: "v"}), ValueError, "pong has no label 'v'"),
        (lambda env: Freeze(env, {3: "print(1)"}), ValueError, r"print\(\) is not one of the helpers"),
        (lambda env: Freeze(env, {3: "ram[256]"}), ValueError, "an address is a number within 0x0..0xff"),
        (lambda env: Freeze(env, {3: "-" * 120 + "1"}), ValueError, "nested too deeply"),
        (lambda env: Freeze(env, {3: np.array([1, 2])}), ValueError, "needs a value for each of 1 lanes"),
        (lambda env: Freeze(env, ["ball_x"]), TypeError, "Freeze needs values by label or by place"),
        (lambda env: Freeze(env), ValueError, "Freeze needs a label or a place"),
        (lambda env: Freeze(env, {3: 1}, index=0), ValueError, "index is for an AtariVectorEnv"),
        (lambda env: Freeze(gymnasium.make("CartPole-v1"), {3: 1}), TypeError, "an AtariEnv, a core"),
        (lambda env: Freeze(AleCore("pong"), {3: 1}), ValueError, "use core='native'"),
        (lambda env: Freeze(env, {3: "1" + "+ (1" * 40 + ")" * 40}), ValueError, "is too large to compile"),
        (lambda env: Poke(env, {3: 1}, when="ball_q > 3"), ValueError, "'ball_q'; did you mean 'ball_y'"),
        (lambda env: Poke(env, {3: 1}, when="("), ValueError, "is not an expression"),
        (lambda env: Poke(env, {3: 1}, when=3), TypeError, "when must be a condition"),
        (lambda env: Poke(env, {3: 1}, frame=0), ValueError, "frame must be within 1.."),
        (lambda env: Poke(env, {3: 1}, frame="x"), TypeError, "frame must be an integer"),
    ],
)
def test_wrong_arguments(freeze: Callable[[atari.AtariEnv], Any], error: type[Exception], text: str) -> None:
    env = playing()
    before = env.core.ram().tobytes()
    with pytest.raises(error, match=text):
        freeze(env)
    assert env.core.ram().tobytes() == before


@pytest.mark.parametrize(
    ("values", "text"),
    [
        ({"temperature": -1}, "temperature cannot be -1; its values are 0..99"),
        ({"lives": 0}, "lives cannot be 0; its values are 1..16"),  # another byte decides that the game is over
        ({"lives": 17}, "lives cannot be 17; its values are 1..16"),
    ],
)
@pytest.mark.parametrize("kind", [Freeze, Poke])
def test_a_value_that_no_byte_of_the_label_has(kind: Any, values: dict[str, int], text: str) -> None:
    env = atari.make("frostbite")
    env.reset(seed=0)
    with pytest.raises(ValueError, match=text):
        kind(env, values)


def test_no_digit_above_nine_is_written() -> None:
    env = started("frostbite", frameskip=1)
    with Freeze(env, temperature="-1"):
        env.step(0)
    assert Ram(env)["temperature"] == 45

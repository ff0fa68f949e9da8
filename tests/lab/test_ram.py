"""`Ram`: values by name and bytes by place, of environments, cores, vectors and their lanes."""

from dataclasses import replace

import gymnasium
import numpy as np
import pytest

import atari
from atari import AtariEnv, AtariVectorEnv
from atari.base.frozen import FrozenDict
from atari.base.text_table import Table
from atari.cores import NativeCore
from atari.games.objects import GameObject
from atari.lab import Ram
from atari.wrappers import DqnPreprocessing

UNNAMED = replace(atari.games["pong"], ram_labels=FrozenDict())


@pytest.fixture
def pong():
    env = AtariEnv("pong", repeat_action_probability=0.0)
    env.reset(seed=0)
    for _ in range(60):
        env.step(2)
    yield env
    env.close()


@pytest.fixture
def envs():
    envs = AtariVectorEnv("pong", num_envs=3)
    envs.reset(seed=0)
    for step in range(60):
        envs.step(np.array([2, 3, step % 4]))
    yield envs
    envs.close()


def test_values_and_bytes_of_an_environment(pong):
    ram, bytes_ = Ram(pong), pong.core.ram()
    assert ram["ball_x"] == int(bytes_[49]) - 49
    assert type(ram["ball_x"]) is type(ram[49]) is int
    assert [ram[index] for index in range(128)] == [ram[0x80 + index] for index in range(128)] == bytes_.tolist()
    assert ram.byte("ball_x") == 49
    assert ram.label("ball_x").kind == "position_x"
    assert dict(ram.items()) == {name: ram[name] for name in ram}
    assert ram.keys() == list(ram) == list(pong.game.ram_labels)
    assert len(ram) == 8
    assert "ball_x" in ram
    assert 0xB1 in ram
    assert "ball" not in ram
    assert 256 not in ram
    assert 1.5 not in ram
    assert repr(ram) == "Ram(pong, 8 labels)"


def test_a_value_is_signed_and_a_hidden_one_is_none(pong):
    ram = Ram(pong)
    ram[46] = 0
    assert ram["player_x"] == -48
    ram[49] = 0
    assert ram["ball_x"] is None


def test_an_assignment_writes_the_byte_that_has_the_value(pong):
    ram = Ram(pong)
    before = pong.core.ram()
    ram["ball_x"] = 80
    assert (ram["ball_x"], ram[49]) == (80, 129)
    ram[0xB1] = 130
    assert (ram["ball_x"], ram[49]) == (81, 130)
    assert np.flatnonzero(pong.core.ram() != before).tolist() == [49]
    score = Ram(AtariEnv("breakout"))
    score["score_100"], score["score_1"] = 700, np.int64(42)
    assert (score[76], score[77]) == (0x07, 0x42)
    assert score["score_100"] + score["score_1"] == 742


@pytest.mark.parametrize(
    ("place", "value", "error", "message"),
    [
        ("ball_x", 300, ValueError, r"'ball_x' of pong cannot be 300; possible values are -49\.\.206"),
        ("ball_x", 2**40, ValueError, r"possible values are -49\.\.206"),
        ("ball_x", 1.5, TypeError, "the value of 'ball_x' must be an integer, got 1.5"),
        ("ball_x", None, TypeError, "must be an integer, got None"),
        ("ball_x", True, TypeError, "must be an integer, got True"),
        ("bal_x", 3, KeyError, "pong has no label 'bal_x'; did you mean 'ball_x'"),
        (49, 256, ValueError, r"a byte must be within 0\.\.255, got 256"),
        (49, "x", TypeError, r"a byte must be an integer"),
        (256, 0, ValueError, r"an index 0\.\.127 or an address 0x80\.\.0xFF, got 256"),
        (None, 0, TypeError, r"an index 0\.\.127 or an address 0x80\.\.0xFF, got None"),
    ],
)
def test_a_wrong_write_changes_nothing(pong, place, value, error, message):
    before = pong.core.ram()
    with pytest.raises(error, match=message):
        Ram(pong)[place] = value
    assert (pong.core.ram() == before).all()


@pytest.mark.parametrize(
    ("use", "error", "text"),
    [
        (lambda env: Ram(env)["bal_x"], KeyError, "did you mean 'ball_x'"),
        (lambda env: Ram(env).byte("bal_x"), KeyError, "did you mean 'ball_x'"),
        (lambda env: Ram(env).label("bal_x"), KeyError, "did you mean 'ball_x'"),
        (lambda env: Ram(env)[1.5], TypeError, "a place in RAM is"),
        (lambda env: Ram(AtariEnv(UNNAMED))["ball_x"], KeyError, "no labels of pong, so no 'ball_x'; give an index"),
        (lambda env: Ram(3), TypeError, "RAM is read from an AtariEnv"),
        (lambda env: Ram(np.zeros(128, np.uint8)), TypeError, r"take Ram\(replay.seek\(number of frames\)\)"),
        (lambda env: Ram(env, index=0), TypeError, "index is the number of a lane of an AtariVectorEnv"),
    ],
)
def test_what_is_not_there_is_refused(pong, use, error, text):
    with pytest.raises(error, match=text):
        use(pong)


def test_it_works_over_resets_and_replaced_cores_and_says_when_closed(pong):
    ram = Ram(DqnPreprocessing(AtariEnv("pong", frameskip=1)))
    assert ram["player_x"] is not None
    ram = Ram(pong)
    pong.driver.make_sound()
    pong.step(0)
    assert ram[49] == pong.core.ram()[49]
    pong.close()
    for use in (lambda: ram["ball_x"], lambda: ram[3], ram.items, ram.objects, ram.table):
        with pytest.raises(gymnasium.error.ClosedEnvironmentError, match=r"closed; call reset\(\) to go on"):
            use()
    with pytest.raises(gymnasium.error.ClosedEnvironmentError):
        ram[3] = 4
    pong.reset()
    assert ram[3] == pong.core.ram()[3]


def test_a_core():
    core = NativeCore("pong")
    ram = Ram(core)
    ram["score_player"] = 3
    assert core.ram()[14] == ram["score_player"] == 3
    core.close()
    with pytest.raises(RuntimeError, match="closed"):
        ram[3]


def test_a_lane_of_a_vector(envs):
    ram = Ram(envs, index=1)
    assert ram["ball_y"] == Ram(envs.lanes[1])["ball_y"]
    before = [int(lane.ram()[13]) for lane in envs.lanes]
    ram["score_enemy"] = 7
    assert [int(lane.ram()[13]) for lane in envs.lanes] == [before[0], 7, before[2]]
    for index in (3, -1):
        with pytest.raises(IndexError, match=r"index must be within 0\.\.2, got"):
            Ram(envs, index=index)
    with pytest.raises(TypeError, match="index must be an integer"):
        Ram(envs, index="1")


def test_a_whole_vector(envs):
    ram, rams = Ram(envs), envs.ram()
    assert rams.tolist() == [lane.ram().tolist() for lane in envs.lanes]
    values = ram["ball_x"]
    assert isinstance(values, np.ma.MaskedArray)
    assert values.dtype == np.int32
    assert values.tolist() == [Ram(envs, index=index)["ball_x"] for index in range(3)]
    assert ram[49].dtype == np.uint8
    assert ram[0xB1].tolist() == rams[:, 49].tolist()
    ram["score_enemy"] = 3
    ram["score_player"] = [4, 5, 6]
    ram[49] = np.ma.MaskedArray([60, 0, 61], [False, True, False])
    assert ram["score_enemy"].tolist() == [3, 3, 3]
    assert ram["score_player"].tolist() == [4, 5, 6]
    assert ram[49].tolist() == [60, rams[1, 49], 61]
    ram[49] = [0, 50, 51]
    assert ram["ball_x"].mask.tolist() == [True, False, False]
    assert ram.objects() == [Ram(envs, index=index).objects() for index in range(3)]
    assert repr(ram) == "Ram(pong, 8 labels, 3 lanes)"


@pytest.mark.parametrize(
    ("value", "error", "message"),
    [
        ([1, 2], ValueError, r"a value for each of the 3 lanes, got the shape \(2,\)"),
        ([1.0, 2.0, 3.0], TypeError, "values must be integers, got float64"),
        ([1, 2, 300], ValueError, "cannot be 300"),
    ],
)
def test_a_wrong_write_to_a_vector_changes_nothing(envs, value, error, message):
    before = envs.ram()
    with pytest.raises(error, match=message):
        Ram(envs)["score_player"] = value
    assert (envs.ram() == before).all()


def test_a_vector_between_send_and_recv_and_closed(envs):
    ram = Ram(envs)
    envs.send(np.zeros(3, np.int64))
    with pytest.raises(RuntimeError, match=r"call recv\(\) first"):
        ram["ball_x"]
    envs.recv()
    assert ram[3].shape == (3,)
    envs.close()
    with pytest.raises(gymnasium.error.ClosedEnvironmentError):
        ram["ball_x"]


def test_the_ram_of_some_environments(envs):
    assert envs.ram([2, 0]).tolist() == envs.ram()[[2, 0]].tolist()
    for wrong in ([3], [-1], [2**32]):
        with pytest.raises(IndexError, match="there is no environment"):
            envs.ram(wrong)
    with pytest.raises(TypeError, match="env_id must be integers"):
        envs.ram([0.5])


def test_a_vector_of_several_games():
    envs = AtariVectorEnv(["pong", "breakout", "pong"])
    envs.reset(seed=0)
    ram = Ram(envs)
    assert ram["score_1"].mask.tolist() == [True, False, True]
    assert ram["player_x"].tolist() == [Ram(envs, index=index)["player_x"] for index in range(3)]
    assert {"score_enemy", "score_100"} <= set(ram.keys())
    with pytest.raises(KeyError, match="pong has no label 'lives'"):
        ram["lives"] = 3
    ram["lives"] = np.ma.MaskedArray([0, 3, 0], [True, False, True])
    assert ram["lives"].tolist() == [None, 3, None]
    with pytest.raises(ValueError, match=r"'ball_x' is at different places in these games, \[49, 99\]"):
        ram.byte("ball_x")
    assert ram.byte("lives") == 57


def test_objects_are_where_they_are_drawn():
    pong = AtariEnv("pong", repeat_action_probability=0.0)
    pong.reset(seed=0)
    for _ in range(32):
        pong.step(0)
    objects = {thing.name: thing for thing in Ram(pong).objects()}
    assert objects["ball"] == GameObject("ball", "ball", Ram(pong)["ball_x"], Ram(pong)["ball_y"], 2, 4)
    assert (objects["player"].width, objects["player"].height) == (4, 16)
    screen = pong.core.screen_rgb()
    for thing, colour in (("ball", (236, 236, 236)), ("player", (92, 186, 92))):
        thing = objects[thing]
        rows, columns = np.nonzero((screen[34:194, 10:150] == colour).all(-1))
        corner = columns.min() + 10, rows.min() + 34
        assert abs(corner[0] - thing.x) <= 2, thing
        assert abs(corner[1] - thing.y) <= 4, thing
        assert (columns.max() - columns.min() + 1, rows.max() - rows.min() + 1) == (thing.width, thing.height)
    Ram(pong)[49] = 0
    assert "ball" not in {thing.name for thing in Ram(pong).objects()}


def test_objects_with_one_byte_have_their_constant_row_or_column():
    freeway = AtariEnv("freeway")
    freeway.reset(seed=0)
    things = {thing.name: thing for thing in Ram(freeway).objects()}
    assert [things[f"car_{lane}"].y for lane in range(10)] == list(range(27, 187, 16))
    assert things["car_3"].x == Ram(freeway)["car_3_x"]
    assert (things["player"].x, things["player"].y) == (44, Ram(freeway)["player_y"])


def test_the_table(pong, envs):
    table = Ram(pong).table()
    lines = str(table).splitlines()
    assert lines[0].split() == ["name", "index", "address", "byte", "value", "kind", "evidence", "note"]
    assert len(lines) == 9
    ball = lines[5].split()
    assert ball[:5] == ["ball_x", "49", "0xB1", str(Ram(pong)[49]), str(Ram(pong)["ball_x"])]
    assert table._repr_html_().count("<tr>") == 9
    assert "value 2" in str(Ram(envs).table())
    assert len(Ram(AtariEnv(UNNAMED)).table().rows) == 128


def test_a_table_escapes_and_aligns():
    table = Table.of(("a", "bb"), [("<x>", 1), (None, 200)])
    assert str(table) == "a     bb\n<x>    1\n     200"
    assert "&lt;x&gt;" in table._repr_html_()
    assert str(Table.of(("a", "b"), [])) == "a  b"

"""Labels of RAM bytes, against an independent interpreter of their expressions."""

import copy
import pickle
from dataclasses import replace

import numpy as np
import pytest
from rules_interpreter import evaluate

import atari
import atari._emulator as _emulator
from atari.games.game import parse_game
from atari.lab.labels import Labels, byte_index

NAMED = [game for game in atari.games.values() if game.ram_labels]
RAMS = np.random.default_rng(0).integers(0, 256, (6, 128), np.uint8)


def own_game(**labels):
    screen = {"format": "NTSC", "height": 210, "first_line": 34}
    controllers = {"left": "joystick", "right": "none"}
    ram = {name: {"kind": "other", "sources": [], "evidence": "", **label} for name, label in labels.items()}
    return parse_game(
        "own", {"title": "", "players": 1, "notes": [], "screen": screen, "controllers": controllers, "ram": ram}
    )


def reference(label, ram):
    """The value of a label, None if it is not visible."""
    byte = int(ram[label.index])
    if label.visible and not evaluate(label.visible, ram, {"v": byte}, base=0):
        return None
    if label.transform:
        value = evaluate(label.transform, ram, {"v": byte}, base=0)
    else:
        value = byte & (255 if label.mask is None else label.mask)
        if label.encoding == "bcd":
            value = 10 * (value >> 4) + (value & 15)
    return value * (label.weight or 1)


def shown(label):
    return replace(label, visible=None)


@pytest.mark.parametrize("game", NAMED, ids=lambda game: game.id)
def test_equals_the_reference_in_every_game(game):
    labels = Labels(game)
    values, visible = labels.evaluate(RAMS)
    assert values.shape == visible.shape == (len(game.ram_labels), len(RAMS))
    assert (values.dtype, visible.dtype) == (np.int32, np.bool_)
    for row, label in enumerate(game.ram_labels.values()):
        expected = [reference(label, ram) for ram in RAMS]
        assert [value if seen else None for value, seen in zip(values[row], visible[row], strict=True)] == expected


@pytest.mark.parametrize("game", NAMED, ids=lambda game: game.id)
def test_the_inverse_of_a_value_has_it_again(game):
    labels = Labels(game)
    for name, label in game.ram_labels.items():
        mask, ram = 255 if label.mask is None else label.mask, RAMS[0].copy()
        for byte in (0, 9, 0x42, 200, 255):
            if label.encoding == "bcd" and (byte & 15 > 9 or byte >> 4 > 9):
                continue
            ram[label.index] = 0x55 & ~mask | byte & mask
            value = reference(shown(label), ram)
            ram[label.index] = 0x55
            written = labels.byte_of(name, ram, value)
            assert (written ^ 0x55) & ~mask == 0, "bits outside of the mask have changed"
            ram[label.index] = written
            assert reference(shown(label), ram) == value


def test_a_value_is_signed_and_a_hidden_one_is_zero_and_masked():
    values, visible = Labels(atari.games["pong"], ["player_x", "ball_x"]).evaluate(np.zeros((2, 128), np.uint8))
    assert values.tolist() == [[-48, -48], [0, 0]]
    assert visible.tolist() == [[True, True], [False, False]]


def test_the_inverse_keeps_other_bits_and_changes_few():
    game = own_game(
        low={"index": 3, "mask": 0x0F},
        high={"index": 3, "mask": 0x70, "transform": "(v & 0x70) >> 4"},
        three={"index": 4, "transform": "v % 3"},
        points={"index": 5, "encoding": "bcd", "weight": 100},
        digit={"index": 5, "encoding": "bcd", "mask": 0x0F},
        self={"index": 6, "transform": "ram[6] + ram[7]"},
        bits={"index": 0, "mask": 0x80},
        squares={"index": 1, "transform": "v * v"},
        none={"index": 2, "transform": "5"},
    )
    labels = Labels(game)
    ram = np.zeros(128, np.uint8)
    ram[[3, 4, 5, 7]] = 0xA5, 0b1010, 0x12, 50
    assert labels.byte_of("low", ram, 9) == 0xA9
    assert labels.byte_of("high", ram, 7) == 0xF5
    assert labels.byte_of("three", ram, 1) == 0b1010  # it has the value already
    assert labels.byte_of("three", ram, 0) == 0b101010  # one bit, as 0b10001010, and the lowest
    assert labels.byte_of("points", ram, 4200) == 0x42
    assert labels.byte_of("digit", ram, 7) == 0x17
    assert labels.byte_of("self", ram, 60) == 10
    for name, value, possible in (
        ("low", 16, r"0\.\.15$"),
        ("high", 8, r"0\.\.7$"),
        ("three", 3, r"0\.\.2$"),
        ("points", 450, r"0\.\.9900 in steps of 100$"),
        ("digit", 10, r"0\.\.9$"),
        ("self", 49, r"50\.\.305$"),
        ("bits", 2, "0, 128$"),
        ("squares", 2, r"256 within 0\.\.65025, such as 0, 1, 4,"),
        ("none", 2, "5$"),
    ):
        with pytest.raises(ValueError, match=f"'{name}' of own cannot be {value}; possible values are {possible}"):
            labels.byte_of(name, ram, value)


def test_a_place_is_an_index_or_an_address():
    assert [byte_index(place) for place in (0, 127, 0x80, 0xFF, np.uint8(49))] == [0, 127, 0, 127, 49]
    for place, error in ((-1, ValueError), (256, ValueError), (True, TypeError), (1.0, TypeError)):
        with pytest.raises(error, match=r"an index 0\.\.127 or an address 0x80\.\.0xFF, got"):
            byte_index(place)


@pytest.mark.parametrize(
    ("game", "name", "message"),
    [
        ("pong", "bal_x", r"^pong has no label 'bal_x'; did you mean 'ball_x'\?$"),
        ("breakout", "zzz", r"breakout has no label 'zzz'; it has player_x, ball_x, .*, \.\.\.$"),
        ("seaquest", "score", "seaquest has no label 'score'; it has score_10000, score_100, score_1$"),
        (None, "x", "there are no labels of own, so no 'x'; give an index"),
    ],
)
def test_a_wrong_name_suggests_the_nearest(game, name, message):
    with pytest.raises(KeyError, match=message):
        Labels(atari.games[game] if game else own_game(), [name])


@pytest.mark.parametrize(
    ("label", "message"),
    [
        ({"transform": "rng()"}, r"\[ram\] it: in 'rng\(\)', rng cannot be used in a label"),
        ({"visible": "xram[3]"}, r"\[ram\] it: in 'xram\[3\]', xram cannot be used in a label"),
        ({"transform": "ram[200]"}, r"\[ram\] it: in 'ram\[200\]', an address is a number within 0x0\.\.0x7f"),
        ({"transform": "__import__('os')"}, "is not one of the helpers"),
        ({"mask": 256}, r"\[ram\] it: mask 256 is not within 1\.\.255"),
        ({"width": 0}, r"\[ram\] it: width 0 is not within 1\.\.160"),
        ({"encoding": "gray"}, r"\[ram\] it: encoding must be 'bcd' or 'plain', got 'gray'"),
    ],
)
def test_a_wrong_label_is_refused_with_its_place(label, message):
    with pytest.raises(ValueError, match=message):
        own_game(it={"index": 0, **label})


def test_too_complex_an_expression_is_refused():
    deep = "(" * 40 + "v" + " + 1)" * 40
    Labels(own_game(it={"index": 0, "transform": deep}))  # a chain needs no deep stack
    wide = "1 + (" * 40 + "v" + ")" * 40
    with pytest.raises(ValueError, match=r"the label 'it' of own cannot be compiled: .* too deep a stack"):
        Labels(own_game(it={"index": 0, "transform": wide}))


def test_wrong_arrays_are_refused():
    labels = Labels(atari.games["pong"])
    with pytest.raises(TypeError, match="must be uint8"):
        labels.evaluate(np.zeros((2, 128)))
    with pytest.raises(ValueError, match=r"got the shape \(128,\)"):
        labels.evaluate(np.zeros(128, np.uint8))
    assert labels.evaluate(np.zeros((0, 128), np.uint8))[0].shape == (8, 0)
    assert labels.evaluate(RAMS[::2])[0].tolist() == labels.evaluate(RAMS)[0][:, ::2].tolist()


def test_the_extension_checks_what_it_gets():
    end = [_emulator.END, 0]
    for parts in [(128, 255, False, end, end), (0, 256, False, end, end), (0, -1, False, end, end)]:
        with pytest.raises(ValueError, match="of a label is within"):
            _emulator.Labels([parts])
    with pytest.raises(ValueError, match="variable that does not exist"):
        _emulator.Labels([(0, 255, False, [1, 2, *end], end)])
    compiled = _emulator.Labels([(0, 255, False, end, end)])
    ram, values, visible = np.zeros((2, 128), np.uint8), np.zeros((1, 2), np.int32), np.zeros((1, 2), np.bool_)
    compiled.evaluate(ram, values, visible)
    for wrong in [(ram[:1], values, visible), (ram[:, :127].copy(), values, visible), (ram, values[:0], visible)]:
        with pytest.raises(ValueError, match="must be of shape"):
            compiled.evaluate(*wrong)
    with pytest.raises(IndexError):
        compiled.byte_of(1, ram[0], 0)
    with pytest.raises(ValueError, match="must be of shape"):
        compiled.byte_of(0, ram[0, :5], 0)


def test_copies_are_equal():
    labels = Labels(atari.games["breakout"], ["ball_x", "score_1"])
    for other in (copy.deepcopy(labels), pickle.loads(pickle.dumps(labels))):
        assert other.names == labels.names
        assert other.evaluate(RAMS)[0].tolist() == labels.evaluate(RAMS)[0].tolist()

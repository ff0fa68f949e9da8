"""The text of `render`."""

import re

import gymnasium
import pytest

from atari.classic.algorithmic import AlgorithmicEnv, CopyEnv, ReversedAdditionEnv

GREEN, RED, END = "\x1b[42m", "\x1b[41m", "\x1b[0m"


def shown(env: AlgorithmicEnv) -> str:
    text = env.render()
    assert text is not None
    return text


def plain(text: str) -> list[str]:
    return [line.rstrip() for line in re.sub(r"\x1b\[\d+m", "", text).splitlines()]


def test_a_tape_before_the_first_step() -> None:
    env = CopyEnv(render_mode="ansi")
    env.reset(options={"input": "CAB"})
    text = shown(env)
    assert plain(text) == [
        "Total length of input instance: 3, step: 0",
        "==========================================",
        "Observation Tape    :   CAB",
        "Output Tape         :",
        "Targets             :   CAB",
        "",
    ]
    assert f"  {GREEN}C{END}AB  \n" in text


def test_a_tape_after_a_right_and_a_wrong_character() -> None:
    env = CopyEnv(render_mode="ansi")
    env.reset(options={"input": "CAB"})
    env.step((1, 1, 2))
    text = shown(env)
    assert f"Observation Tape    :   C{GREEN}A{END}B  \nOutput Tape         :   {GREEN}C{END}\n" in text
    env.step((0, 1, 3))
    text = shown(env)
    assert f"Observation Tape    :   {GREEN}C{END}AB  \nOutput Tape         :   C{RED}D{END}\n" in text
    assert plain(text)[-5:] == [
        "Current reward      : -0.500",
        "Cumulative reward   : 0.500",
        "Action              : Tuple(move over input: left,",
        "                            write to the output tape: True,",
        "                            prediction: D)",
    ]


def test_a_head_far_off_is_not_shown() -> None:
    env = CopyEnv(render_mode="ansi")
    env.reset(options={"input": "AAAAAAAA"})
    heads = []
    for _ in range(4):
        env.step((0, 0, 0))
        text = shown(env)
        heads.append(text.count(GREEN))
    assert heads == [1, 1, 0, 0]


def test_a_grid() -> None:
    env = ReversedAdditionEnv(render_mode="ansi")
    env.reset(options={"input": "122\n002"})
    env.step((2, 0, 1))
    text = shown(env)
    assert text.splitlines()[2:6] == [
        f"Observation Grid    :   {GREEN} {END}    ",
        "                        122  ",
        "                        002  ",
        "                             ",
    ]
    assert plain(text)[6:8] == ["Output Tape         :", "Targets             :   1211"]
    assert "move over input: up," in text


def test_human_prints_each_state_once(capsys: pytest.CaptureFixture[str]) -> None:
    env = CopyEnv(render_mode="human")
    env.reset(options={"input": "AB"})
    env.step((1, 1, 0))
    assert env.render() is None
    printed = capsys.readouterr().out
    assert re.findall(r"step: (\d+)", printed) == ["0", "1"]
    shown = CopyEnv(render_mode="ansi")
    shown.reset(options={"input": "AB"})
    shown.step((1, 1, 0))
    assert printed.endswith(f"{shown.render()}\n")


def test_without_a_mode_it_says_what_to_do() -> None:
    env = CopyEnv()
    env.reset()
    with pytest.raises(gymnasium.error.Error, match="make the environment with render_mode='ansi' or 'human'"):
        env.render()

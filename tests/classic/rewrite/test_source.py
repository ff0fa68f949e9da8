"""Edits of ranges: what is not edited stays, byte for byte."""

import ast

import pytest
from old_scripts import rewritten

from atari.classic.rewrite.source import Source


def test_edits_in_other_alphabets_and_line_breaks() -> None:
    text = 'a = "ü€😀"; b = f(1,  2)  # ñ\r\n\tx\n'.replace("\tx\n", "")
    source = Source(text)
    call = next(node for node in ast.walk(ast.parse(text)) if isinstance(node, ast.Call))
    assert source.segment(call) == "f(1,  2)"
    source.add_argument(call, "c=3")
    source.drop_argument(call, call.args[0])
    source.mark(call, "see")
    assert source.result() == '# atari.classic: see\r\na = "ü€😀"; b = f(2, c=3)  # ñ\r\n'


def test_an_edit_in_a_replaced_range_has_no_effect() -> None:
    source = Source("abcdef")
    source.replace(1, 5, "X")
    source.replace(2, 3, "Y")
    source.replace(1, 1, "<")
    source.replace(6, 6, ">")
    assert source.result() == "a<Xf>"


@pytest.mark.parametrize("newline", ["\n", "\r\n"])
def test_formatting_stays(newline: str) -> None:
    old = (
        "import gym\nenv   =  gym.make( 'CartPole-v1' , )\nif True :\n\tobs,reward,done,info  =  env.step(\n\t\t0 ,   # left\n"
        "\t)   # after\n\tstate = ( env.reset( ) )\nx = {  'é':1 }\n"
    ).replace("\n", newline)
    new = (
        "import gymnasium as gym\nenv   =  gym.make( 'CartPole-v1' , )\nif True :\n\tobs,reward,terminated, truncated,info  =  env.step(\n"
        "\t\t0 ,   # left\n\t)   # after\n\tdone = terminated or truncated\n\tstate, _ = ( env.reset( ) )\nx = {  'é':1 }\n"
    ).replace("\n", newline)
    assert rewritten(old) == new


def test_a_mark_of_a_statement_that_begins_inside_a_line() -> None:
    old = "import gym\nenv = gym.make('CartPole-v1')\nif a and \\\n   b: f(env.step(0))\n"
    new = rewritten(old)
    assert new.index("# atari.classic") < new.index("if a and")
    ast.parse(new)

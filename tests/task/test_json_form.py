"""A task as JSON: strict, with a version, bounded."""

import contextlib
import json
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from atari.task import Task
from atari.task.fields import FIELDS
from atari.task.json_form import to_short_json

TEXT = Task.of("breakout", preset="envpool", interventions=[]).to_json()


def changed(**values: Any) -> str:
    return json.dumps({**json.loads(TEXT), **values})


def test_a_value_that_a_label_cannot_have_is_refused_by_every_door() -> None:
    write = {"to": "lives", "value": 300}
    forged = {"name": "many_lives", "description": "-", "source": "-", "writes": [write]}
    message = r"intervention 'many_lives', writes\[0\], value: lives cannot be 300; its values are 0..255"
    with pytest.raises(ValueError, match=message):
        Task.from_json(changed(interventions=[forged]))
    with pytest.raises(ValueError, match=message):
        Task("breakout", interventions=(forged,))  # type: ignore[arg-type]
    with pytest.raises(ValueError, match=message):
        Task.of("breakout", interventions=[forged])


def test_has_every_field() -> None:
    assert set(json.loads(TEXT)) == {*FIELDS, "format", "file"}


def test_the_short_form_leaves_defaults_out() -> None:
    task = Task.of("breakout", preset="envpool")
    text = to_short_json(task)
    assert len(text) < len(task.to_json()) * 2 / 3
    assert Task.from_json(text, task.definition) == task
    with pytest.raises(ValueError, match="of the game 'breakout', not of 'pong'"):
        Task.from_json(text, Task("pong").definition)


def test_a_missing_key_has_the_default_of_the_format() -> None:
    assert Task.from_json('{"format": 1, "game": "pong"}') == Task("pong")


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (changed(format=2), "format 2, and this release of atari-envs reads up to 1"),
        (changed(format="1"), '"format" must be an integer'),
        (changed(format=True), '"format" must be an integer'),
        (changed(frame_skip=4), "no key 'frame_skip'"),
        (changed(episodic_life="no"), "episodic_life must be True or False, got 'no'"),
        (changed(noops=[1]), "noops must be"),
        (changed(noops=None), "noops must be"),
        (changed(reward=5), "reward must be None, for the game's own, or an expression"),
        (changed(reward="lives_lst"), "column 1, at 'lives_lst': there is no such name; did you mean 'lives_lost'"),
        (changed(game=3), "'game' must be a text, got 3"),
        (changed(game="brekout"), "did you mean 'breakout'"),
        (changed(file="/etc/passwd"), "'file' must be a game file"),
        (changed(file="/nonexistent.toml"), "is gone"),
        (changed(interventions=["nothing"]), "'interventions' must be a list of tables"),
        ('{"format": 1}', "needs the key 'game'"),
        ("[]", "a task must be a table"),
        ("{", "the task is damaged: Expecting"),
        ('{"format": 1, "game": "pong", "game": "pong"}', "twice"),
        ('{"format": 1, "game": "pong", "max_frames": NaN}', "NaN is no number"),
        ("[" * 100 + "]" * 100, "32 deep"),
        (" " * (1 << 21), "and 1,048,576 are allowed"),
    ],
)
def test_a_wrong_text_is_refused(text: str, message: str) -> None:
    with pytest.raises(ValueError, match=message.replace("(", r"\(")):
        Task.from_json(text)


@pytest.mark.parametrize("text", [None, b"{}", {"format": 1}])
def test_is_read_from_a_string(text: Any) -> None:
    with pytest.raises(TypeError, match="a string of JSON"):
        Task.from_json(text)


@given(st.integers(0, len(TEXT) - 1), st.characters())
@settings(max_examples=200, deadline=None)
def test_a_damaged_text_is_refused_or_a_task(place: int, character: str) -> None:
    with contextlib.suppress(ValueError):
        Task.from_json(TEXT[:place] + character + TEXT[place + 1 :])

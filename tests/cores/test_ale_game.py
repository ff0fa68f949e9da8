"""`AleGame`: when settings apply, and how a game closes and opens again."""

import pytest

from atari.cores import AleCore, NativeCore, PlainCore
from atari.cores.ale_game import AleGame
from atari.cores.ale_interface import AleSettings
from atari.games.catalog import games


def loaded(kind: type, **settings: object) -> AleGame:
    game = AleGame(
        kind,
        games["pong"],
        AleSettings(random_seed=5, **settings),
        mode=None,
        difficulty=1,
        rom=None,
        interventions=(),
    )
    game.core.reset()
    return game


@pytest.mark.parametrize("kind", [NativeCore, PlainCore, AleCore])
def test_a_closed_game_goes_on(kind: type) -> None:
    closed, open_ = loaded(kind), loaded(kind)
    for game in (closed, open_):
        for _ in range(30):
            game.core.act(2)
    closed.close()
    closed.close()
    assert closed.closed
    closed.reopen()
    assert not closed.closed
    for _ in range(30):
        assert closed.core.act(3) == open_.core.act(3)
    assert closed.core.ram().tolist() == open_.core.ram().tolist()


def test_settings_apply_at_the_next_load() -> None:
    game = loaded(NativeCore)
    before = game.core
    game.ale_settings.set("repeat_action_probability", float, 0.5)
    assert game.core_options["repeat_action_probability"] == 0.25
    game.load_game()
    assert game.core is not before
    assert (game.core_options["repeat_action_probability"], game.core.difficulty) == (0.5, 1)


def test_a_load_without_new_settings_keeps_the_core_and_plays_the_first_mode() -> None:
    game = loaded(NativeCore)
    before = game.core
    game.core.set_mode(1)
    game.ale_settings.stale = True  # as AleInterface.setMode does
    game.load_game()
    assert game.core is before
    assert game.core.mode == 0


def test_a_core_of_another_class_is_not_replaced() -> None:
    game = loaded(NativeCore)
    game.core = PlainCore("pong")
    game.ale_settings.set("frame_skip", int, 2)
    with pytest.raises(RuntimeError, match="close the recorder first"):
        game.load_game()
    assert game.core_options["frame_skip"] == 1


def test_settings_are_carried_to_a_copy() -> None:
    game, copy = loaded(NativeCore), loaded(NativeCore)
    game.ale_settings.set("max_num_frames_per_episode", int, 100)
    game.load_game()
    game.make_sound()
    game.core.set_mode(1)
    copy.restore_settings(game.settings_state())
    assert (copy.core.sound, copy.core.mode, copy.core_options) == (True, 1, game.core_options)


def test_other_settings_are_refused_and_change_nothing() -> None:
    game = loaded(NativeCore)
    before = game.settings_state()
    with pytest.raises(ValueError, match="takes a result of settings_state, and 'core_options' is missing"):
        game.restore_settings({"ale_settings": before["ale_settings"], "sound": True})
    assert game.settings_state()["core_options"] == before["core_options"]
    assert not game.core.sound

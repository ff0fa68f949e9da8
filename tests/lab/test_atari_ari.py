"""AtariARI's names and categories."""

import atari
from atari.lab import atari_ari


def test_the_places_are_those_of_the_game_files():
    for game, names in atari_ari.INDICES.items():
        known = {label.index for label in atari.games[game].ram_labels.values() if "AtariARI" in label.sources}
        # The game files leave out a byte that is not what its name says.
        assert set(names.values()) - known <= ({64} if game == "berzerk" else set()), game


def test_lists_are_numbered():
    names = atari_ari.indices(atari.games["qbert"])
    assert [names[f"score_{number}"] for number in range(3)] == [89, 90, 91]
    assert "score" not in names
    assert names["tile_color_20"] == 42


CATEGORIES = {
    "player_x player_column": ["agent_localization"],
    "ball_y player_missile_x1": ["small_object_localization"],
    "enemy_skull_x": ["other_localization"],
    "clock_ms oxygen_meter_value frame_number_display": ["score_clock_lives_display"],
    "num_lives_direction": ["score_clock_lives_display", "misc_keys"],
    "room_number pin_existence_3": ["misc_keys"],
    "tile_color_0": [],
}


def test_categories():
    for names, categories in CATEGORIES.items():
        assert [list(atari_ari.categories(name)) for name in names.split()] == [categories] * len(names.split())
        assert set(categories) <= set(atari_ari.CATEGORIES)

"""AtariARI's names of RAM bytes and their categories.

AtariARI is from Anand et al. 2019, "Unsupervised State Representation Learning in Atari". Its `AtariARIWrapper` returns
`info["labels"]`, raw bytes by these names, and so does `RamLabels(env, names="atari_ari")`. The source of the
facts is https://github.com/mila-iqia/atari-representation-learning (MIT licence). The game files say which were
confirmed; the labels have names of this package there.
"""

from collections.abc import Mapping, Sequence
from dataclasses import replace

from atari.base.frozen import FrozenDict
from atari.games.game import Game, RamLabel

CATEGORIES = (
    "agent_localization",
    "small_object_localization",
    "other_localization",
    "score_clock_lives_display",
    "misc_keys",
)
"""AtariARI's categories. Its benchmark reports an F1 score for each."""

# Indices by game and name. Several indices are several names, with _0, _1, ... appended.
_INDICES: dict[str, dict[str, int | Sequence[int]]] = {
    "asteroids": {
        "player_x": 73, "player_y": 74, "num_lives_direction": 60, "player_score_high": 61, "player_score_low": 62,
        "player_missile_x1": 83, "player_missile_x2": 84, "player_missile_y1": 86, "player_missile_y2": 87,
        "player_missile1_direction": 89, "player_missile2_direction": 90,
        "enemy_asteroids_y": [*range(3, 10), *range(12, 20)], "enemy_asteroids_x": [*range(21, 28), *range(30, 38)],
    },
    "battle_zone": {
        "blue_tank_facing_direction": 46, "blue_tank_size_y": 47, "blue_tank_x": 48, "blue_tank2_facing_direction": 52,
        "blue_tank2_size_y": 53, "blue_tank2_x": 54, "num_lives": 58, "missile_y": 105, "compass_needles_angle": 84,
        "angle_of_tank": 4, "left_tread_position": 59, "right_tread_position": 60, "crosshairs_color": 108, "score": 29,
    },
    "berzerk": {
        "player_x": 19, "player_y": 11, "player_direction": 14, "player_missile_x": 22, "player_missile_y": 23,
        "player_missile_direction": 21, "robot_missile_direction": 26, "robot_missile_x": 29, "robot_missile_y": 30,
        "num_lives": 90, "robots_killed_count": 91, "game_level": 92, "enemy_evilOtto_x": 46, "enemy_evilOtto_y": 89,
        "enemy_robots_x": range(65, 73), "enemy_robots_y": range(56, 65), "player_score": range(93, 96),
    },
    "bowling": {
        "ball_x": 30, "ball_y": 41, "player_x": 29, "player_y": 40, "frame_number_display": 36, "score": 33,
        "pin_existence": range(57, 67),
    },
    "boxing": {
        "player_x": 32, "player_y": 34, "enemy_x": 33, "enemy_y": 35, "enemy_score": 19, "clock": 17,
        "player_score": 18,
    },
    "breakout": {
        "ball_x": 99, "ball_y": 101, "player_x": 72, "blocks_hit_count": 77, "score": 84, "block_bit_map": range(30),
    },
    "demon_attack": {
        "level": 62, "player_x": 22, "enemy_x1": 17, "enemy_x2": 18, "enemy_x3": 19, "missile_y": 21, "enemy_y1": 69,
        "enemy_y2": 70, "enemy_y3": 71, "num_lives": 114,
    },
    "freeway": {"player_y": 14, "score": 103, "enemy_car_x": range(108, 118)},
    "frostbite": {
        "top_row_iceflow_x": 34, "second_row_iceflow_x": 33, "third_row_iceflow_x": 32, "fourth_row_iceflow_x": 31,
        "enemy_bear_x": 104, "num_lives": 76, "igloo_blocks_count": 77, "player_x": 102, "player_y": 100,
        "player_direction": 4, "enemy_x": range(84, 88), "score": range(72, 75),
    },
    "hero": {
        "player_x": 27, "player_y": 31, "power_meter": 43, "room_number": 28, "level_number": 117, "dynamite_count": 50,
        "score": range(56, 58),
    },
    "montezuma_revenge": {
        "room_number": 3, "player_x": 42, "player_y": 43, "player_direction": 52, "enemy_skull_x": 47,
        "enemy_skull_y": 46, "key_monster_x": 44, "key_monster_y": 45, "level": 57, "num_lives": 58,
        "items_in_inventory_count": 61, "room_state": 62, "score_0": 19, "score_1": 20, "score_2": 21,
    },
    "ms_pacman": {
        "enemy_sue_x": 6, "enemy_inky_x": 7, "enemy_pinky_x": 8, "enemy_blinky_x": 9, "enemy_sue_y": 12,
        "enemy_inky_y": 13, "enemy_pinky_y": 14, "enemy_blinky_y": 15, "player_x": 10, "player_y": 16, "fruit_x": 11,
        "fruit_y": 17, "ghosts_count": 19, "player_direction": 56, "dots_eaten_count": 119, "player_score": 120,
        "num_lives": 123,
    },
    "pitfall": {
        "player_x": 97, "player_y": 105, "enemy_logs_x": 98, "enemy_scorpion_x": 99, "bottom_of_rope_y": 18,
        "clock_sec": 89, "clock_min": 88,
    },
    "pong": {
        "player_y": 51, "player_x": 46, "enemy_y": 50, "enemy_x": 45, "ball_x": 49, "ball_y": 54, "enemy_score": 13,
        "player_score": 14,
    },
    "private_eye": {
        "player_x": 63, "player_y": 86, "room_number": 92, "player_direction": 58, "dove_x": 48, "dove_y": 39,
        "clock": (67, 69), "score": (73, 74),
    },
    "qbert": {
        "player_x": 43, "player_y": 67, "player_column": 35, "red_enemy_column": 69, "green_enemy_column": 105,
        "score": range(89, 92), "tile_color": (
            21, 52, 54, 83, 85, 87, 98, 100, 102, 104, 1, 3, 5, 7, 9, 32, 34, 36, 38, 40, 42,
        ),
    },
    "riverraid": {"player_x": 51, "missile_x": 117, "missile_y": 50, "fuel_meter_high": 55, "fuel_meter_low": 56},
    "seaquest": {
        "player_x": 70, "player_y": 97, "player_direction": 86, "player_missile_direction": 87,
        "oxygen_meter_value": 102, "player_missile_x": 103, "num_lives": 59, "divers_collected_count": 62,
        "enemy_obstacle_x": range(30, 34), "diver_or_enemy_missile_x": range(71, 75), "score": range(57, 59),
    },
    "skiing": {
        "player_x": 25, "clock_m": 104, "clock_s": 105, "clock_ms": 106, "score": 107, "object_y": range(87, 94),
    },
    "space_invaders": {
        "invaders_left_count": 17, "player_score": 104, "num_lives": 73, "player_x": 28, "enemies_x": 26,
        "missiles_y": 9, "enemies_y": 24,
    },
    "tennis": {
        "enemy_x": 27, "enemy_y": 25, "enemy_score": 70, "ball_x": 16, "ball_y": 17, "player_x": 26, "player_y": 24,
        "player_score": 69,
    },
    "venture": {
        **{f"sprite{number}_y": 20 + number for number in range(6)},
        **{f"sprite{number}_x": 79 + number for number in range(6)},
        "player_x": 85, "player_y": 26, "current_room": 90, "num_lives": 70, "score_1_2": 71, "score_3_4": 72,
    },
    "video_pinball": {
        "ball_x": 67, "ball_y": 68, "player_left_paddle_y": 98, "player_right_paddle_y": 102, "score_1": 48,
        "score_2": 50,
    },
    "yars_revenge": {
        "player_x": 32, "player_y": 31, "player_missile_x": 38, "player_missile_y": 37, "enemy_x": 43, "enemy_y": 42,
        "enemy_missile_x": 47, "enemy_missile_y": 46,
    },
}  # fmt: skip


def _split(indices: Mapping[str, int | Sequence[int]]) -> Mapping[str, int]:
    single = {name: index for name, index in indices.items() if isinstance(index, int)}
    several = {
        f"{name}_{number}": one
        for name, index in indices.items()
        if not isinstance(index, int)
        for number, one in enumerate(index)
    }
    return FrozenDict({**single, **several})


INDICES: Mapping[str, Mapping[str, int]] = FrozenDict({game: _split(names) for game, names in _INDICES.items()})
"""The index 0..127 of each name, by game."""


def indices(game: Game) -> Mapping[str, int]:
    """AtariARI's names in a game, with the index 0..127 of each.

    Raises:
        ValueError: AtariARI does not have the game.
    """
    if game.id not in INDICES:
        raise ValueError(f"AtariARI has no names for {game.id}; it has {', '.join(INDICES)}")
    return INDICES[game.id]


def with_names(game: Game) -> Game:
    """The game with AtariARI's names instead of its own labels; the value of each is the byte.

    Raises:
        ValueError: AtariARI does not have the game.
    """
    labels = {name: RamLabel(name, index, "other", ("AtariARI",), "") for name, index in indices(game).items()}
    return replace(game, ram_labels=FrozenDict(labels))


def categories(name: str) -> tuple[str, ...]:
    """The categories of a name, by AtariARI's rules; few have two, some none.

    The rules look for words anywhere in the name: "_x" and the like make it a place; "player" makes that the place of
    the agent, "ball" or "missile" the place of a small object.
    """
    found = []
    if _has(name, "_x", "_y", "_z", "_column"):
        small = _has(name, "ball", "missile")
        agent = _has(name, "agent", "player")
        found.append(CATEGORIES[1] if small else CATEGORIES[0] if agent else CATEGORIES[2])
    if _has(name, "score", "clock", "lives", "lifes", "meter", "display"):
        found.append(CATEGORIES[3])
    if _has(name, "count", "bit_map", "existence", "level", "room", "game_state", "direction"):
        found.append(CATEGORIES[4])
    return tuple(found)


def _has(name: str, *words: str) -> bool:
    return any(word in name for word in words)

"""A task in words and bytes: `repr`, the text in snapshots, and what `print` shows, compared with stored ones.

`python tests/task/test_words.py` writes `words.txt` anew, after a change that is meant.
"""

import json
from pathlib import Path

from atari.task import Task
from atari.task.json_form import identity

FILE = Path(__file__).with_name("words.txt")

STILL = {"name": "still", "description": "-", "source": "-", "writes": [{"to": "enemy_y", "value": 105}]}

TASKS = (
    Task("breakout"),
    Task.of("breakout", preset="dqn2015"),
    Task.of("pong", preset="baselines", actions=("RIGHT", "NOOP"), reward="reward - 5 * lives_lost"),
    Task.of("breakout", preset="envpool", episodic_life=True, obs_type="dict", max_episode_steps=900),
    Task.of("pong", preset="ale_vector", seeding="ale", fire_again=False, interventions=[STILL]),
    Task.of("ALE/Breakout-ram-v5", stack_num=4, padding="reset", life_loss_info=True, max_num_frames_per_episode=None),
    Task.of("breakout", continuous=True, frameskip=(2, 5), sound_obs=True),
    Task.of("pong", preset="multiplayer_dqn", players=2, zero_sum=True, agent_indicator=True),
)
"""Each field that has words of its own differs from its default in one of these."""


def words() -> str:
    """The texts of all tasks. The fingerprint of a game's rules is left out: it changes with the game's definition."""
    parts = []
    for task in TASKS:
        fields = json.loads(identity(task))
        del fields["rules"]
        parts.append(f"{task!r}\n{json.dumps(fields)}\n{task}\n")
    return "\n".join(parts)


def test_words_are_those_of_the_file() -> None:
    assert words() == FILE.read_text(encoding="utf-8")


if __name__ == "__main__":
    FILE.write_text(words(), encoding="utf-8")

"""The facts in the comment of a video: the task that was played, seeds and versions, as JSON."""

import json
from os import PathLike
from pathlib import Path
from typing import Any

from atari.base import json_text
from atari.base.validation import check_file
from atari.base.version import VERSION
from atari.recording.video.encoder import import_av
from atari.task import Task
from atari.task.json_form import to_short_json

PACKAGE = f"atari-envs {VERSION}"


def facts_of(task: Task) -> dict[str, Any]:
    """The facts that recordings of a task carry: `task`, its fields that do not have their defaults, and `package`."""
    return {"task": json.loads(to_short_json(task)), "package": PACKAGE}


def video_facts(path: str | PathLike[str]) -> dict[str, Any]:
    """The facts that a video of this package carries: `task` and `package`; a rendered replay adds `core_seeds`.

    Interventions that were switched on during the game are in `switched_on`, by name. Of replays beside each other each
    has a `name`, and `beside` has the facts of the others.

    Games of several players and old replays have no `task`; their facts are `game`, `players` and `options`.
    `atari.Task.from_json(json.dumps(facts["task"]))` makes the task, unless the game is your own.

    Raises:
        FileNotFoundError: there is no such file.
        ValueError: the file is no video, or has no facts: videos of other programs, GIF and PNG have none.
        gymnasium.error.DependencyNotInstalled: PyAV is not installed.

    Example:
        >>> import atari
        >>> from atari.recording import RecordVideo, video_facts
        >>> with RecordVideo(atari.make("pong", frameskip=3), "videos") as env:
        ...     observation, info = env.reset(seed=0)
        ...     observation = env.step(0)[0]
        >>> task = video_facts("videos/rl-video-episode-0.mp4")["task"]
        >>> task["game"], task["frameskip"]
        ('pong', 3)
    """
    av = import_av("reading")
    try:
        with av.open(f"file:{check_file(Path(path))}") as container:
            tags = {name.lower(): text for name, text in container.metadata.items()}
        facts = json_text.parse(tags.get("comment", "null"), "its comment")
    except (av.FFmpegError, ValueError) as error:
        raise ValueError(f"{path} has no facts of a video of atari-envs: {error}") from None
    if not isinstance(facts, dict) or not str(facts.get("package", "")).startswith("atari-envs "):
        raise ValueError(
            f"{path} has no facts about the game; MP4, MKV and WebM of RecordVideo, Replay.render and the "
            "commands have them"
        )
    return facts

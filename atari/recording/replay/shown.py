"""A replay on a page in a browser, where it is played again: with its film, and in a notebook; and as a video there."""

import base64
import html
import math
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, field
from itertools import islice
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Protocol

from atari.base.notebook import image
from atari.base.png import png
from atari.games.game import Game
from atari.recording.replay.results import EpisodeSummary, Frame
from atari.web.bundle import one_file
from atari.web.film import film
from atari.web.shelf import Shown, page_files

_WIDTH, _HEIGHT = 640, 512  # pixels of a notebook's frame, in which the page is compact
_MOST_PLAYERS = 2
MAX_VIDEO_SIZE = 20_000_000
"""The most bytes of a video in a notebook, whose file then has a third more."""


class ShownReplay(Protocol):
    """The part of a `Replay` that a page needs."""

    path: Path
    game: Game
    players: int
    complete: bool
    frames_total: int

    @property
    def episodes(self) -> Sequence[EpisodeSummary]:
        """The episodes."""

    def frames(self, start: int = 0, stop: int | None = None, *, sound: bool = False) -> Iterator[Frame]:
        """The frames."""


def on_page(
    replay: ShownReplay, seconds: float, *, name: str | None = None, progress: Callable[[int], object] | None = None
) -> Shown:
    """A replay as a page shows it.

    Args:
        replay: the replay. Only a film needs its ROM.
        seconds: the length of the film; with 0 there is none.
        name: its name in links; None is the name of the file.
        progress: called with 1 after each frame of the film.

    Raises:
        ValueError: the replay has no frames, or more than two players; or it cannot be played, see `Replay.frames`.
    """
    if replay.players > _MOST_PLAYERS:
        raise ValueError(f"{replay.path} has {replay.players} players; a page plays games of one or two")
    if not replay.frames_total:
        raise ValueError(f"{replay.path} has no frames")
    rate = replay.game.screen.frame_rate
    taken = None
    if frames := math.ceil(seconds * rate):
        played = replay.frames(0, frames, sound=True)
        taken = film(_reported(played, progress), replay.frames_total, rate, replay.players)
    episodes = replay.episodes if replay.complete or taken else ()
    return Shown(name or replay.path.stem, title(replay.game, episodes), replay.game, replay.path.read_bytes(), taken)


def title(game: Game, episodes: Sequence[EpisodeSummary]) -> str:
    """The title of a replay: the game, and its score."""
    if not episodes:
        return game.title
    best = max(episodes, key=lambda episode: episode.score)
    score = " : ".join(map(str, best.scores)) if best.scores else f"{best.score:,} point{'s' * (best.score != 1)}"
    return f"{game.title}: " + (score if len(episodes) == 1 else f"{len(episodes)} games, best {score}")


def in_notebook(replay: ShownReplay, seconds: float) -> str:
    """HTML of a frame with the page, which shows the replay alone and knows its game alone.

    The frame has an origin of its own. So its page reaches neither the notebook nor the pages of other replays, and the
    browser keeps nothing for it. Under the frame is a picture, which readers see where frames are removed, as on
    GitHub.

    Raises:
        FileNotFoundError, ValueError: see `on_page` and `page_files`.
    """
    shown = on_page(replay, seconds)
    page = one_file(page_files([shown], [])).replace("&", "&amp;").replace("'", "&#39;")
    page = page.replace("\n", "&#10;")  # one line: Markdown may change others, and the page's hashes would be wrong
    (first,) = islice(replay.frames(min(60, replay.frames_total - 1)), 1)
    below = image(png(first.screen), shown.title, first.screen.shape)
    style = "position:absolute;inset:0;width:100%;height:100%;border:0"
    frame = (
        f"<iframe sandbox='allow-scripts allow-downloads' allow='autoplay; gamepad' style='{style}' srcdoc='{page}'>"
    )
    return (
        f"<div style='position:relative;max-width:{_WIDTH}px;height:{_HEIGHT}px;overflow:hidden'>"
        f"{below}{frame}</iframe></div><p>{html.escape(shown.title)}, {replay.frames_total:,} frames</p>"
    )


@dataclass(frozen=True)
class ShownVideo:
    """A video with sound that a cell of a notebook shows: the bytes of an MP4 file, and the caption below it."""

    data: bytes = field(repr=False)
    caption: str

    @classmethod
    def of(cls, game: Game, render: Callable[[Path, Callable[[int], object]], Path]) -> "ShownVideo":
        """A video of a game, which `render(path, progress)` writes; it calls `progress` with 1 after each frame.

        Raises:
            ValueError: the video has more than `MAX_VIDEO_SIZE` bytes; the rest is then not rendered.
        """
        frames = 0
        with TemporaryDirectory() as folder:

            def count(more: int) -> None:
                nonlocal frames
                frames += more
                size = sum(file.stat().st_size for file in Path(folder).iterdir())
                if size > MAX_VIDEO_SIZE:
                    raise ValueError(
                        f"the first {frames:,} frames of the video have {size / 1e6:.1f} MB, and a notebook takes up "
                        f"to {MAX_VIDEO_SIZE / 1e6:.0f} MB; choose a part with start and stop, or an episode, or write "
                        "a file with render"
                    )

            data = render(Path(folder, "video.mp4"), count).read_bytes()
        return cls(data, f"{game.title}: {frames:,} frames, {len(data) / 1e6:.1f} MB")

    def _repr_html_(self) -> str:
        source = f"data:video/mp4;base64,{base64.b64encode(self.data).decode()}"
        return (
            f'<figure style="margin:0"><video controls loop playsinline style="max-width:100%" src="{source}"></video>'
            f"<figcaption>{html.escape(self.caption)}</figcaption></figure>"
        )


def _reported(frames: Iterable[Frame], progress: Callable[[int], object] | None) -> Iterator[Frame]:
    for frame in frames:
        yield frame
        if progress is not None:
            progress(1)

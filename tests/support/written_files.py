"""Every file that the package writes: how each is written, and how it is read to its end.

`WRITTEN` is the one table. A test compares it with the options of all commands, and with the modules that write.
"""

import contextlib
import importlib.util
import io
import json
import os
import struct
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from inspector_tools import new_inspection
from inspector_tools import play as play_session
from replay_tools import record

import atari
import atari.cli
from atari.cores import snapshot, verify
from atari.lab import check_dataset, write_dataset
from atari.lab.causal import files as causal_files
from atari.lab.causal.explore import causes
from atari.lab.causal.picture import write_png
from atari.lab.inspector import export
from atari.play import Session
from atari.recording import RecordReplay, RecordVideo, Replay, VideoWriter, to_minari
from atari.recording.replay.file_format import SUFFIX

Write = Callable[[Path], object]


class Written(NamedTuple):
    """A kind of file."""

    name: str
    """The name of the file, or of the folder with the files."""
    prepare: Callable[[int], Write]
    """Makes the function that writes, in a folder for what it reads. The argument is the size: steps, frames, rows."""
    needs: tuple[str, ...] = ()
    """The packages."""
    keeps: bool = False
    """Whether it keeps its readable beginning on a full disk: a recording, a folder of several files, a log."""
    replaces: bool = True
    """Whether an older file of the name is replaced."""
    command: tuple[str, str] = ("", "")
    """The command and its option that names the file."""


class CommandFailed(Exception):
    """A command ended with another status than 0."""

    def __init__(self, code: int, errors: str) -> None:
        super().__init__(f"status {code}: {errors}")
        self.code, self.errors = code, errors


def command(*words: object) -> None:
    """Run a command in this process."""
    errors = io.StringIO()
    with contextlib.redirect_stderr(errors), contextlib.redirect_stdout(io.StringIO()):
        code = atari.cli.main([str(word) for word in words])
    if code != 0:
        raise CommandFailed(code, errors.getvalue())


def replay_of(steps: int) -> Path:
    return record(Path(f"source{SUFFIX}").absolute(), "pong", max(1, steps))


def data_set(steps: int) -> Write:
    replay = replay_of(steps)
    return lambda path: write_dataset(replay, path, observations=("screen", "grayscale")[steps % 2])


def minari(write: Callable[[Path, str], object], steps: int) -> Write:
    """A dataset of Minari in a folder of all datasets, which is `path`."""
    replay = replay_of(steps)

    def to(path: Path) -> None:
        os.environ["MINARI_DATASETS_PATH"] = str(path)
        write(replay, "pong/mine-v0")

    return to


def video(frames: int, scale: int = 1) -> Write:
    source = np.random.default_rng(frames)

    def to(path: Path) -> None:
        with VideoWriter(path, (32, 32), 60, scale=scale, sound=path.suffix in (".mp4", ".mkv", ".webm")) as writer:
            for _ in range(1 if path.name == "picture.png" else max(1, frames)):
                writer.write(source.integers(0, 255, (32, 32, 3), np.uint8))

    return to


def steps_of(wrap: Callable[[Any, Path], Any], steps: int) -> Write:
    """A wrapper that records some steps."""

    def to(path: Path) -> None:
        with wrap(atari.AtariEnv("pong"), path) as env:
            env.reset(seed=0)
            for _ in range(max(1, steps)):
                env.step(env.action_space.sample())

    return to


def session(do: Callable[[Session, int], object], frames: int, **files: str) -> Write:
    def to(path: Path) -> None:
        playing = Session("pong", **{name: path / file if file else path for name, file in files.items()})
        try:
            do(playing, max(1, frames))
        finally:
            playing.close()

    return to


def play_on(playing: Session, frames: int) -> None:
    for _ in range(frames):
        playing.play(atari.Action.NOOP)


def film(playing: Session, frames: int) -> None:
    playing.toggle_video()
    play_on(playing, frames)
    playing.toggle_video()


def exported(name: str, frames: int) -> Write:
    lab = new_inspection()
    play_session(lab, max(2, frames))
    lab.freeze(57)
    lab.name(3, "mine")
    return lambda path: export.write(lab, name, path)


def clip(frames: int) -> Write:
    lab = new_inspection()
    play_session(lab, max(2, frames))
    return lambda path: export.write_clip(lab, path, 0, max(2, frames))


def screen(_: int) -> Write:
    env = atari.AtariEnv("breakout")
    env.reset(seed=0)
    return lambda path: env.ale.saveScreenPNG(path)


def causal(write: Callable[[Any, Path], object], _: int) -> Write:
    found = causes("breakout", 1, 1, 1, threads=1)
    return lambda path: write(found, path)


def result(runs: int) -> Any:
    from atari.learning import PROTOCOLS, Result
    from atari.learning.evaluation.results import GameResult

    count = max(2, runs)
    scores = tuple(float(number) for number in range(count))
    games = [
        GameResult(one, scores, (9,) * count, (False,) * count, tuple(range(count))) for one in ("pong", "breakout")
    ]
    return Result("mine", PROTOCOLS["dopamine"], 0, tuple(games))


def comparison(do: str, runs: int) -> Write:
    from atari.learning import compare

    return getattr(compare(result(runs)), do)  # type: ignore[no-any-return]


def monitor(steps: int) -> Write:
    from atari import classic
    from atari.classic.wrappers import Monitor

    def to(path: Path) -> None:
        with Monitor(classic.make("PongDeterministic-v4"), path, force=True) as env:
            env.reset()
            for _ in range(max(1, steps)):
                env.step(0)

    return to


def imported(_: int) -> Write:
    from atari import roms

    source = Path("cartridge.bin").absolute()
    source.write_bytes(roms.find("pong").read_bytes())

    def to(path: Path) -> None:
        os.environ.update(XDG_DATA_HOME=str(path))
        command("roms", "import", source)

    return to


def trusted(_: int) -> Write:
    from atari.learning import trust

    def to(path: Path) -> None:
        os.environ.update(XDG_DATA_HOME=str(path))
        trust.trust("0" * 64)

    return to


def run_log(rows: int) -> Write:
    from atari.learning.run_log import RunLog

    def to(path: Path) -> None:
        path.mkdir(exist_ok=True)
        log = RunLog(path)
        for step in range(max(1, rows)):
            log.add({"step": step, "score": 1.5})

    return to


def trained(steps: int) -> Write:
    words = ["train", "ppo", "pong", "--obs-type", "ram", "--network", "mlp", "--num-envs", 4, "--horizon", 16]
    words += ["--minibatch", 32, "--total-steps", 64 * (1 + steps % 2), "--games", 0]
    return lambda path: command(*words, "-o", path)


def report(rows: int) -> Write:
    """The report of a training, in a folder with links to the training's files."""
    from atari.learning.report import write_report
    from atari.learning.run_folder import RunFolder

    run = Path("trained").absolute()
    with RunFolder.begin(run, "mine", atari.Task.of("pong"), {"rate": 0.5}) as folder:
        for step in range(max(1, rows)):
            folder.log({"step": step, "frames": step, "seconds": 1, "episodes": 1, "score": 2})

    def to(path: Path) -> None:
        path.mkdir(exist_ok=True)
        for file in run.iterdir():
            if not (path / file.name).exists():
                (path / file.name).symlink_to(file)
        write_report(RunFolder.open(path), result(2))

    return to


def of_command(option: str, *words: object, replay: bool = False) -> Callable[[int], Write]:
    """A command that writes to the path after its option; `replay` adds a replay to its words."""

    def prepare(steps: int) -> Write:
        added = [replay_of(steps)] if replay else []
        return lambda path: command(*words, *added, option, path)

    return prepare


def played(steps: int) -> Write:
    """`atari evaluate`, whose games are short."""
    words = ["evaluate", "random", "pong", "--episodes", 1 + steps % 2]
    return lambda path: command(*words, "-o", path)


AV, PLOT, LEARN = ("av",), ("matplotlib",), ("torch", "tensorboard")
WRITTEN: dict[str, Written] = {
    "HDF5": Written("data.h5", data_set, ("h5py",), replaces=False),
    "Parquet": Written("data.parquet", data_set, ("pyarrow",), replaces=False),
    "Minari": Written("sets", partial(minari, write_dataset), ("minari", "h5py"), replaces=False),
    "to_minari": Written("sets", partial(minari, to_minari), ("minari", "h5py"), replaces=False),
    "MP4": Written("a.mp4", video, AV, keeps=True),
    "MKV": Written("a.mkv", video, AV, keeps=True),
    "WebM": Written("a.webm", video, AV, keeps=True),
    "GIF": Written("a.gif", video, AV, keeps=True),
    "large video": Written("a.mp4", partial(video, scale=8), AV, keeps=True),
    "picture": Written("picture.png", video),
    "numbered pictures": Written("%06d.png", video, keeps=True),
    "RecordVideo": Written("videos", partial(steps_of, lambda env, path: RecordVideo(env, str(path))), AV, keeps=True),
    "RecordReplay": Written(f"a{SUFFIX}", partial(steps_of, RecordReplay), keeps=True),
    "state of a play session": Written(
        "a.state", partial(session, lambda one, _: one.save(), state=""), command=("play", "--state")
    ),
    "replay of a play session": Written(
        f"a{SUFFIX}", partial(session, play_on, replay=""), keeps=True, command=("play", "--replay")
    ),
    "video of a play session": Written("videos", partial(session, film, videos=""), AV, keeps=True),
    "labels of the lab": Written("labels.toml", partial(exported, "labels.toml")),
    "interventions of the lab": Written("interventions.toml", partial(exported, "interventions.toml")),
    "replay of the lab": Written(
        f"a{SUFFIX}", partial(exported, next(n for n in export.NAMES if n.startswith("replay"))), keeps=True
    ),
    "clip of the lab": Written("clip.mp4", clip, AV, keeps=True),
    "screen": Written("screen.png", screen),
    "causal map": Written("map.npz", partial(causal, causal_files.save)),
    "picture of a causal map": Written("map.png", partial(causal, write_png)),
    "difference": Written(
        "differences",
        lambda _: verify.Difference(verify.VerificationRun("pong"), 3).write,
        keeps=True,
        command=("verify", "-o"),
    ),
    "result": Written("result.json", lambda runs: result(runs).save),
    "comparison": Written("comparison.json", partial(comparison, "save")),
    "plot": Written("comparison.svg", partial(comparison, "plot"), PLOT, command=("evaluate", "--plot")),
    "plot in PDF": Written("comparison.pdf", partial(comparison, "plot"), PLOT),
    "classic Monitor": Written("monitor", monitor, AV, keeps=True),
    "imported ROM": Written("own", imported, keeps=True),
    "trusted programs": Written("own", trusted, keeps=True),
    "log of a training": Written("log", run_log, LEARN, keeps=True),
    "report": Written("report", report, (*LEARN, "matplotlib"), keeps=True),
    "atari train": Written("run", trained, LEARN, True, False, ("train", "-o")),
    "atari collect": Written(
        "data.h5",
        of_command("-o", "collect", "pong", "--policy", replay=True),
        ("h5py",),
        replaces=False,
        command=("collect", "-o"),
    ),
    "atari record": Written(
        "a.mp4", of_command("-o", "record", "pong", "--seconds", 2), AV, keeps=True, command=("record", "-o")
    ),
    "atari record of a replay": Written(f"a{SUFFIX}", of_command("-o", "record", "pong", "--seconds", 20), keeps=True),
    "atari record of a picture": Written("a.png", of_command("-o", "record", "pong", "--seconds", 1)),
    "atari record of a GIF": Written("a.gif", of_command("-o", "record", "pong", "--seconds", 2), AV, True),
    "atari replay render": Written(
        "a.mp4", of_command("-o", "replay", "render", replay=True), AV, keeps=True, command=("replay render", "-o")
    ),
    "atari causes": Written(
        "maps",
        of_command("-o", "causes", "pong", "--states", 1, "--values", 1, "--frames", 1),
        keeps=True,
        command=("causes", "-o"),
    ),
    "atari diagnose": Written(
        "diagnosis",
        of_command("-o", "diagnose", "random", "breakout", "--episodes", 1, "--frontiers", 1, "--seconds", 0.05),
        AV,
        keeps=True,
        command=("diagnose", "-o"),
    ),
    "atari evaluate": Written("result.json", played, command=("evaluate", "-o")),
    "atari web": Written(
        "page",
        of_command("-o", "web", "--seconds", 0.2, replay=True),
        ("atari.web.page",),  # the folder of the page, if it was built
        command=("web", "-o"),
    ),
}


def missing(name: str) -> tuple[str, ...]:
    """The packages that a writer lacks here."""
    return tuple(one for one in WRITTEN[name].needs if importlib.util.find_spec(one) is None)


def read(path: Path) -> None:
    """Read a file to its end, or all files of a folder.

    Raises:
        Exception: it is not whole, or it is a file that only its writer could know.
    """
    if path.is_dir():
        for one in path.rglob("*"):
            if one.is_file():
                read(one)
    elif path.name.endswith(".part") or path.name.startswith("."):
        raise ValueError(f"{path} is a partial file")
    elif path.name.startswith("events.out.tfevents"):
        read_events(path)
    elif path.suffix in READERS:
        READERS[path.suffix](path)


def read_replay(path: Path) -> None:
    import warnings

    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # it was cut
        assert Replay.load(path).verify()


def read_video(path: Path) -> None:
    import av

    with av.open(str(path)) as container:
        assert any(True for _ in container.decode(video=0)), f"{path} has no frame"


def read_picture(path: Path) -> None:
    import cv2

    assert cv2.imread(str(path)) is not None, f"{path} is no picture"


def read_minari(path: Path) -> None:
    os.environ["MINARI_DATASETS_PATH"] = str(path.parents[3])
    import minari

    if len(minari.list_local_datasets()):
        dataset = minari.load_dataset("pong/mine-v0")
        assert dataset.total_steps == sum(len(episode.rewards) for episode in dataset)


def read_events(path: Path) -> None:
    data = path.read_bytes()
    while data:
        (size,) = struct.unpack("<Q", data[:8])
        assert len(data) >= size + 16, f"{path} has half an event"
        data = data[size + 16 :]


def ends_with(text: str) -> Callable[[Path], None]:
    def check(path: Path) -> None:
        assert path.read_text(errors="replace").rstrip(" \n" if text.strip() else "").endswith(text), (
            f"{path} has no end"
        )

    return check


READERS: dict[str, Callable[[Path], object]] = {
    ".h5": check_dataset,
    ".parquet": check_dataset,
    ".hdf5": read_minari,
    SUFFIX: read_replay,
    **dict.fromkeys((".mp4", ".mkv", ".webm", ".gif"), read_video),
    ".png": read_picture,
    ".json": lambda path: json.loads(path.read_text()),
    ".npz": causal_files.load,
    ".state": lambda path: snapshot.unpack(path.read_bytes()),
    ".svg": ends_with("</svg>"),
    ".html": ends_with("</html>"),
    ".pdf": ends_with("%%EOF"),
    ".csv": lambda path: path.stat().st_size == 0 or ends_with("\n")(path),  # rows can wait in memory
    ".toml": ends_with("\n"),
    ".bin": lambda path: path.stat().st_size in (2048, 4096) or 1 / 0,
}

"""`write_dataset` and `atari collect`: the files hold what the environment returned, and the labels of it."""

import importlib
import json
import random
import sys
from pathlib import Path
from typing import Any

import gymnasium
import numpy as np
import pytest
from own_process import run_program

import atari
from atari.cli import main
from atari.lab import Ram, check_dataset, dataset, write_dataset
from atari.recording import RecordReplay

STEPS = 40


def recorded(folder: Path, game: str = "breakout", **options: Any) -> tuple[Path, dict[str, list[Any]]]:
    """A replay, and what the environment returned while it was recorded."""
    env = RecordReplay(atari.AtariEnv(game, **options), folder / f"{game}.a26r")
    ram = Ram(env)
    columns: dict[str, list[Any]] = {"frames": [], "ram": [], "actions": [], "rewards": [], "ball_x": []}

    def see() -> None:
        core = env.unwrapped.core  # type: ignore[attr-defined]
        columns["frames"].append(core.screen_rgb())
        columns["ram"].append(core.ram())
        if "ball_x" in ram:
            columns["ball_x"].append(ram["ball_x"])

    env.reset(seed=0)
    env.action_space.seed(0)
    see()
    for step in range(STEPS):
        action = 1 if step == 5 and not options else env.action_space.sample()
        _, reward, *_ = env.step(action)
        columns["actions"].append(action)
        columns["rewards"].append(reward)
        see()
    env.close()
    return env.path, columns


@pytest.fixture
def h5py() -> Any:
    return pytest.importorskip("h5py", reason="h5py is not installed")


@pytest.fixture
def parquet() -> Any:
    return pytest.importorskip("pyarrow.parquet", reason="pyarrow is not installed")


def test_hdf5(tmp_path: Path, h5py: Any) -> None:
    replay, expected = recorded(tmp_path)
    done: list[int] = []
    result = write_dataset(replay, tmp_path / "new" / "a.h5", progress=done.append)
    assert (result["format"], result["episodes"], result["steps"], done) == ("hdf5", 1, STEPS, [STEPS])
    with h5py.File(tmp_path / "new" / "a.h5") as root:
        group = root["episode_0"]
        for name in ("frames", "ram", "actions", "rewards"):
            assert np.array_equal(group[name], expected[name]), name
        visible = group["visible/ball_x"][:]
        assert [int(x) if seen else None for x, seen in zip(group["labels/ball_x"], visible, strict=True)] == expected[
            "ball_x"
        ]
        assert 0 < visible.sum() < len(visible)
        assert group["truncations"][:].tolist() == [False] * (STEPS - 1) + [True]
        assert not group["terminations"][:].any()
        assert root.attrs["game"] == "breakout"
        assert set(json.loads(root.attrs["labels"])) == set(result["labels"]) == set(group["labels"])


def test_parquet(tmp_path: Path, parquet: Any) -> None:
    import cv2

    replay, expected = recorded(tmp_path)
    write_dataset([replay, replay], tmp_path / "a.parquet", labels=["ball_x"])
    table = parquet.read_table(tmp_path / "a.parquet")
    assert table.schema.metadata[b"game"] == b"breakout"
    rows = table.to_pylist()
    assert [(row["episode"], row["step"]) for row in rows] == [(e, s) for e in range(2) for s in range(STEPS + 1)]
    for row, frame, ram, ball in zip(rows, expected["frames"], expected["ram"], expected["ball_x"], strict=False):
        shown = cv2.imdecode(np.frombuffer(row["frame"], np.uint8), cv2.IMREAD_COLOR)[..., ::-1]
        assert np.array_equal(shown, frame)
        assert row["ram"] == ram.tobytes()
        assert row["label.ball_x"] == ball
    assert [row["action"] for row in rows[: STEPS + 1]] == [*expected["actions"], None]
    assert [row["reward"] for row in rows[: STEPS + 1]] == [*expected["rewards"], None]


def test_continuous_actions_and_gray_frames(tmp_path: Path, h5py: Any, parquet: Any) -> None:
    replay, expected = recorded(tmp_path, continuous=True)
    write_dataset(replay, tmp_path / "a.parquet", observations="grayscale", labels=[])
    write_dataset(replay, tmp_path / "a.h5", observations="grayscale", labels=[])
    column = parquet.read_table(tmp_path / "a.parquet")["action"].to_pylist()
    assert np.array_equal(np.array(column[:-1], np.float32), expected["actions"])
    with h5py.File(tmp_path / "a.h5") as root:
        assert root["episode_0/frames"].shape == (STEPS + 1, 210, 160)
        assert np.array_equal(root["episode_0/actions"], expected["actions"])


def content(file: Path) -> dict[str, Any]:
    """Everything in a file, read without `check_dataset`."""
    if file.suffix == ".parquet":
        with importlib.import_module("pyarrow.parquet").ParquetFile(file) as opened:
            table = opened.read()
            return {**table.to_pydict(), "schema": str(table.schema), "metadata": table.schema.metadata}
    h5py = importlib.import_module("h5py")
    found: dict[str, Any] = {}
    with h5py.File(file) as root:
        found["attributes"] = dict(root.attrs)
        root.visititems(
            lambda name, item: found.update({name: item[()].tolist() if isinstance(item, h5py.Dataset) else None})
        )
    return found


@pytest.mark.parametrize("ending", [".h5", ".parquet"])
def test_check_dataset_finds_flipped_bits(tmp_path: Path, ending: str) -> None:
    pytest.importorskip("h5py" if ending == ".h5" else "pyarrow.parquet")
    file = tmp_path / f"a{ending}"
    write_dataset(recorded(tmp_path)[0], file, observations="grayscale", labels=["ball_x"])
    check_dataset(file)
    # Other seeds: HDF5 never returns from reading some flipped sizes in its heap of attributes.
    good, data, generator = content(file), file.read_bytes(), random.Random(1)
    text = len(data) // 3  # facts and tables are at one end, and frames fill most of the rest
    ends = [*range(text), *range(len(data) - text, len(data))]
    refused = 0
    for _ in range(120):
        flipped = bytearray(data)
        flipped[generator.choice([generator.choice(ends), generator.randrange(len(data))])] ^= 1 << generator.randrange(
            8
        )
        file.write_bytes(flipped)
        try:
            check_dataset(file)
        except ValueError:
            refused += 1
        else:
            assert content(file) == good
    assert refused > 40


def test_check_dataset_refuses_other_files(tmp_path: Path) -> None:
    with pytest.raises(FileNotFoundError):
        check_dataset(tmp_path / "a.h5")
    (tmp_path / "a-v0").touch()
    with pytest.raises(ValueError, match=r"must end in one of \.parquet, \.h5, \.hdf5"):
        check_dataset(tmp_path / "a-v0")


def test_minari(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    minari = pytest.importorskip("minari", reason="minari is not installed")
    monkeypatch.setenv("MINARI_DATASETS_PATH", str(tmp_path / "datasets"))
    replay, expected = recorded(tmp_path)
    write_dataset(replay, "breakout/lab-v0", observations="grayscale", labels=["ball_x", "lives"])
    (episode,) = minari.load_dataset("breakout/lab-v0")
    assert episode.observations["image"].shape == (STEPS + 1, 210, 160)
    assert np.array_equal(episode.observations["ram"], expected["ram"])
    visible = episode.infos["visible"]["ball_x"]
    assert np.array_equal(visible, [ball is not None for ball in expected["ball_x"]])
    assert episode.infos["labels"]["lives"].shape == (STEPS + 1,)
    with pytest.raises(ValueError, match="there is a dataset"):
        write_dataset(replay, "breakout/lab-v0")


@pytest.mark.parametrize(
    ("output", "options", "error", "text"),
    [
        ("data", {}, ValueError, "'data' says no format"),
        ("a.csv", {}, ValueError, "says no format"),
        ("a.h5", {"format": "json"}, ValueError, "format must be one of"),
        ("a.h5", {"observations": "rgb"}, ValueError, "observations must be one of"),
        ("a.h5", {"labels": ["balls_x"]}, KeyError, "ball_x"),
    ],
)
@pytest.mark.usefixtures("h5py")
def test_what_is_refused_writes_nothing(
    output: str, options: Any, error: type[Exception], text: str, tmp_path: Path
) -> None:
    replay, _ = recorded(tmp_path)
    with pytest.raises(error, match=text):
        write_dataset(replay, tmp_path / output if "." in output else output, **options)
    assert [path.name for path in tmp_path.iterdir()] == ["breakout.a26r"]


@pytest.mark.usefixtures("h5py")
def test_an_existing_file_stays(tmp_path: Path) -> None:
    (tmp_path / "a.h5").write_bytes(b"mine")
    with pytest.raises(ValueError, match="already"):
        write_dataset(recorded(tmp_path)[0], tmp_path / "a.h5")
    assert (tmp_path / "a.h5").read_bytes() == b"mine"


def test_a_missing_package_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    for name in ("pyarrow.parquet", "h5py"):
        monkeypatch.setitem(sys.modules, name, None)
    with pytest.raises(gymnasium.error.DependencyNotInstalled, match="pip install pyarrow"):
        dataset.check_output("a.parquet")
    with pytest.raises(gymnasium.error.DependencyNotInstalled, match="pip install h5py"):
        dataset.check_output("a.h5")


def test_the_command(
    h5py: Any, tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    Path("own_policy.py").write_text(
        "import numpy as np\ndef right(observations):\n    return np.full(len(observations), 2)\n"
    )
    words = ["collect", "pong", "--observations", "grayscale", "--labels", "ball_x,ball_y", "-o"]
    assert main([*words, "a.h5", "--policy", "own_policy:right", "--json"]) == 0
    result = json.loads(capsys.readouterr().out)
    assert result["labels"] == ["ball_x", "ball_y"]
    with h5py.File("a.h5") as root:
        group = root["episode_0"]
        assert len(group["actions"]) == result["steps"]
        assert group["rewards"][:].sum() == result["scores"][0] < 0
        assert group["terminations"][-1]
        right = [*atari.AtariEnv("pong").get_action_meanings()].index("RIGHT")
        assert (group["actions"][:] == right).mean() > 0.9
    assert main([*words, "a.h5"]) == 1
    assert "already" in capsys.readouterr().err
    assert main([*words, "data"]) == 1
    assert "says no format" in capsys.readouterr().err


FULL_DISK = """
    import resource, sys
    from pathlib import Path
    from atari.lab import check_dataset, write_dataset

    replay, file = map(Path, {words!r})
    resource.setrlimit(resource.RLIMIT_FSIZE, (20_000, resource.RLIM_INFINITY))
    for output in (file, file.with_suffix(".parquet")):
        try:
            write_dataset(replay, output)
        except OSError as error:
            print(error.strerror, error.filename == str(output))
    print(*[path.name for path in file.parent.iterdir()])
    resource.setrlimit(resource.RLIMIT_FSIZE, (resource.RLIM_INFINITY, resource.RLIM_INFINITY))
    write_dataset(replay, file)
    check_dataset(file)
"""


@pytest.mark.skipif(sys.platform == "win32", reason="Windows has no limit of a file's size")
@pytest.mark.usefixtures("h5py", "parquet")
def test_a_full_disk_is_an_error_and_leaves_no_file(tmp_path: Path) -> None:
    replay, _ = recorded(tmp_path)
    (tmp_path / "out").mkdir()
    printed = run_program(FULL_DISK.format(words=(str(replay), str(tmp_path / "out" / "a.h5"))))
    assert printed == "File too large True\nFile too large True\n\n"

"""`collect`: the same rows for any number of workers, and a run that was stopped goes on."""

import hashlib
import json
import os
import shutil
import signal
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from cli_tools import read_json

from atari.cli import main
from atari.lab import check_dataset, write_dataset
from atari.learning import load_policy, record_games
from atari.policy.choice import Choice
from atari.task import Task

ray = pytest.importorskip("ray", reason="Ray requires a Gymnasium of its own; run ./scripts/test --ray")
parquet = pytest.importorskip("pyarrow.parquet", reason="pyarrow is not installed")
pytestmark = pytest.mark.ray

from atari.integrations.ray import collect  # noqa: E402 - it needs Ray

GAME, SEEDS = "breakout", [3, 4, 6]
OPTIONS: dict[str, Any] = {"observations": "grayscale", "labels": ["ball_x"]}
WORDS = ["--observations", "grayscale", "--labels", "ball_x"]


def digests(folder: Path) -> dict[str, str]:
    """By file, the hash of its content."""
    return {path.name: hashlib.sha256(path.read_bytes()).hexdigest() for path in sorted(folder.glob("*.parquet"))}


@pytest.fixture(scope="module")
def dataset(cluster: Any, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A data set of three games."""
    folder = tmp_path_factory.mktemp("data") / "games.parquet"
    done: list[int] = []
    result = collect(GAME, folder, seeds=[*SEEDS, 4], progress=done.append, **OPTIONS)
    assert (result["episodes"], result["played"], done) == (3, 3, [0, 1, 1, 1])
    assert len(result["scores"]) == 3
    return folder


def test_the_rows_are_those_of_one_process(dataset: Path, tmp_path: Path) -> None:
    record_games(load_policy("random"), GAME, "baselines", SEEDS, tmp_path / "games.a26r")
    task = Task.of(GAME, preset="baselines", reward_clipping=False)
    facts = {"task": json.loads(task.to_json()), "policy": "random"}
    drawn = {"chosen": lambda episode, steps: np.full(steps, Choice.SAMPLED, np.uint8)}
    here = write_dataset(tmp_path / "games.a26r", tmp_path / "here.parquet", facts=facts, **OPTIONS, **drawn)
    expected, rows = parquet.read_table(tmp_path / "here.parquet"), parquet.read_table(dataset)
    assert rows.drop_columns("episode").equals(expected.drop_columns("episode"))
    assert rows["episode"].to_pylist() == [SEEDS[number] for number in expected["episode"].to_pylist()]
    assert here["steps"] == rows.num_rows - len(SEEDS)
    of_one, of_all = (dict(table.schema.metadata) for table in (rows, expected))
    del of_one[b"core_seeds"], of_one[b"seeds"], of_one[b"sha256"], of_all[b"sha256"]
    seeds = [
        json.loads(parquet.read_schema(path).metadata[b"core_seeds"]) for path in sorted(dataset.glob("*.parquet"))
    ]
    assert json.loads(of_all.pop(b"core_seeds")) == [seed for several in seeds for seed in several]
    assert of_one == of_all


def test_a_stopped_run_goes_on(dataset: Path, tmp_path: Path) -> None:
    """The last line of the manifest is torn, a file is cut, a part is left over; another file was moved."""
    folder = tmp_path / "games.parquet"
    assert collect(GAME, folder, seeds=SEEDS[1:], **OPTIONS)["played"] == 2
    manifest = folder / "_manifest.jsonl"
    manifest.write_text(manifest.read_text()[:-20])
    (folder / "_seed-0000000003.parquet.part").write_bytes(b"torn")
    result = collect(GAME, folder, seeds=SEEDS, **OPTIONS)
    assert (result["played"], result["episodes"]) == (2, 3)
    assert digests(folder) == digests(dataset)
    file = folder / "seed-0000000006.parquet"
    file.write_bytes(file.read_bytes()[:-1])
    assert collect(GAME, folder, seeds=SEEDS, **OPTIONS)["played"] == 1
    assert collect(GAME, folder, seeds=SEEDS, **OPTIONS)["played"] == 0
    assert digests(folder) == digests(dataset)


def test_a_killed_worker_changes_nothing(
    dataset: Path, cluster: Any, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    from atari.integrations.ray import collection

    play, driver = collection._play, os.getpid()

    def deadly(task: Any) -> Any:
        if not (tmp_path / "killed").exists() and os.getpid() != driver:
            (tmp_path / "killed").touch()
            os.kill(os.getpid(), signal.SIGKILL)
        return play(task)

    monkeypatch.setattr(collection, "_play", deadly)
    collect(GAME, tmp_path / "games.parquet", seeds=SEEDS, **OPTIONS)
    assert (tmp_path / "killed").exists()
    assert digests(tmp_path / "games.parquet") == digests(dataset)


def test_an_id_and_seeds_below_two_to_the_32(cluster: Any, tmp_path: Path) -> None:
    folder, last = tmp_path / "games.parquet", 2**32 - 1
    result = collect("BreakoutNoFrameskip-v4", folder, seeds=[1, last], **OPTIONS)
    assert Task.from_json(json.dumps(result["task"])) == Task.of("BreakoutNoFrameskip-v4")
    assert set(parquet.read_table(folder)["episode"].to_pylist()) == {1, last}
    with pytest.raises(ValueError, match="has data of task"):
        collect("Breakout-v0", folder, seeds=[1], **OPTIONS)


@pytest.mark.parametrize("name", ["seen.parquet", "seen.h5"])
def test_what_the_agent_saw(cluster: Any, tmp_path: Path, name: str) -> None:
    pytest.importorskip("torch", reason="PyTorch is not installed")
    pytest.importorskip("h5py", reason="h5py is not installed")
    policy = str(Path(__file__).parents[2] / "examples" / "breakout-pqn")
    result = collect(GAME, tmp_path / name, policy=policy, seeds=[1, 2], labels=[])
    agreement = check_dataset(tmp_path / name, load_policy(policy))
    assert agreement is not None
    assert sum(agreement.steps.values()) == result["steps"]
    assert agreement.equal[Choice.GREEDY] == agreement.steps[Choice.GREEDY] > 0.99 * result["steps"]


def test_ray_data_reads_the_folder(dataset: Path) -> None:
    data = pytest.importorskip("ray.data")
    assert data.read_parquet(str(dataset)).count() == parquet.read_table(dataset).num_rows


def test_one_file_is_that_of_one_process(cluster: Any, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    h5py = pytest.importorskip("h5py", reason="h5py is not installed")
    monkeypatch.chdir(tmp_path)
    result = collect(GAME, "games.h5", seeds=range(2), **OPTIONS)
    assert main(["collect", GAME, "--episodes", "2", "-o", "here.h5", *WORDS]) == 0
    assert sorted(path.name for path in tmp_path.iterdir()) == ["games.h5", "here.h5"]
    with h5py.File("games.h5") as games, h5py.File("here.h5") as here:
        assert games["episode_1/frames"][:].tobytes() == here["episode_1/frames"][:].tobytes()
        assert games["episode_0/ram"][:].tobytes() == here["episode_0/ram"][:].tobytes()
        assert dict(games.attrs) == dict(here.attrs)
    assert (result["episodes"], result["played"]) == (2, 2)


@pytest.mark.parametrize(
    ("changes", "error", "text"),
    [
        ({"policy": "noop"}, ValueError, "has data of policy 'random'"),
        ({"labels": []}, ValueError, "has data of labels"),
        ({"seeds": []}, ValueError, "at least one seed"),
        ({"seeds": [-1]}, ValueError, "a seed must be"),
        ({"seeds": [2**32]}, ValueError, "a seed must be within 0..4294967295"),
        ({"observations": "rgb"}, ValueError, "observations must be one of"),
        ({"labels": ["balls_x"]}, KeyError, "ball_x"),
        ({"policy": "nothing.zip"}, FileNotFoundError, "nothing.zip"),
    ],
)
def test_what_is_refused_changes_nothing(
    changes: dict[str, Any], error: type[Exception], text: str, dataset: Path
) -> None:
    before = digests(dataset)
    with pytest.raises(error, match=text):
        collect(GAME, dataset, **{"seeds": SEEDS, **OPTIONS, **changes})
    assert digests(dataset) == before


def test_another_folder_stays(cluster: Any, tmp_path: Path) -> None:
    (tmp_path / "own.parquet").mkdir()
    (tmp_path / "own.parquet" / "mine").touch()
    with pytest.raises(ValueError, match="without a manifest"):
        collect(GAME, tmp_path / "own.parquet")


@pytest.mark.parametrize(
    "line",
    [
        b"null", b"[]", b"{", b"[" * 100_000, b'{"seed": 1, "seed": 1}', b"\xff", b'{"seed": NaN}', b'{"seed": 1}',
        b'{"seed": [], "file": "a", "bytes": 1, "score": 1}', b'{"seed": 1, "file": null, "bytes": 1, "score": 1}',
    ],
)  # fmt: skip
def test_a_damaged_manifest_is_refused(dataset: Path, tmp_path: Path, line: bytes) -> None:
    folder = shutil.copytree(dataset, tmp_path / "games.parquet")
    with (folder / "_manifest.jsonl").open("ab") as manifest:
        manifest.write(line + b"\n")
    with pytest.raises(ValueError, match=r"_manifest\.jsonl"):
        collect("breakout", folder, seeds=SEEDS, **OPTIONS)


def test_planted_links_are_not_followed(dataset: Path, tmp_path: Path) -> None:
    folder, victim = shutil.copytree(dataset, tmp_path / "games.parquet"), tmp_path / "victim"
    victim.write_bytes((folder / "_manifest.jsonl").read_bytes() + b"half a line")
    (folder / "_manifest.jsonl").unlink()
    (folder / "_manifest.jsonl").symlink_to(victim)
    before = victim.read_bytes()
    collect("breakout", folder, seeds=SEEDS, **OPTIONS)
    assert victim.read_bytes() == before


def test_the_command(cluster: Any, dataset: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: Any) -> None:
    monkeypatch.chdir(tmp_path)
    words = ["collect", GAME, "--seed", "3", "--episodes", "2", *WORDS, "--ray", cluster.address, "-o", "games.parquet"]
    for played in (2, 0):
        assert read_json(capsys, *words)["played"] == played
    expected = digests(dataset)
    assert digests(Path("games.parquet")) == {name: expected[name] for name in list(expected)[:2]}
    assert main([*words, "--policy", "a.a26r"]) == 1
    assert "leave out --ray" in capsys.readouterr().err

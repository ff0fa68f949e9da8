"""`check_dataset` with a policy: its actions are chosen again from the stored observations."""

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from atari.lab import check_dataset, write_dataset
from atari.lab.dataset_check import Agreement
from atari.learning import ScoresPolicy, load_policy
from atari.learning.evaluation.evaluate import EvaluatedPolicy
from atari.policy.choice import Choice
from atari.task import Task

pytest.importorskip("h5py", reason="h5py is not installed")

TASK = Task.of("breakout", preset="baselines", max_num_frames_per_episode=900, reward_clipping=False)
SEEDS = [4, 9]


def scores_of(observations: Any, gap: float = 1.0) -> Any:
    """Scores that depend on each pixel of all images of a stack, and on its place."""
    pixels = np.asarray(observations, np.int64).reshape(len(observations), -1)
    best = pixels @ (np.arange(pixels.shape[1]) % 97 + 1) % 4
    return (np.eye(4) * gap)[best].astype(np.float32)


class Remembering:
    """A policy whose actions depend on the seed and on the steps since the episode began."""

    name, task, sample = "remembering", TASK, False

    def begin(self, game: str, actions: Any, lanes: Any, seeds: Any) -> None:
        self.steps, self.seed = 0, int(seeds[0])

    def begin_episodes(self, lanes: Any) -> None:
        self.steps = 0

    def __call__(self, observations: Any, lanes: Any) -> Any:
        self.steps += 1
        return np.array([(self.seed + self.steps // 3) % 4])


def policy_of(scores: Any = scores_of, **options: Any) -> Any:
    return load_policy(ScoresPolicy(scores, task=TASK, name="mine", **options))


def collected(policy: Any, file: Path, epsilon: float = 0.0, task: Task = TASK, **options: Any) -> Path:
    """A data set of games of the policy."""
    player = EvaluatedPolicy(load_policy(policy), task, epsilon)
    player.record(SEEDS, file.with_suffix(".a26r"))
    facts = {"task": json.loads(task.to_json()), "policy": "mine", "seeds": SEEDS}
    kept: dict[str, Any] = {"observations": "seen", "labels": [], "facts": facts, **options}
    kept["chosen"] = lambda episode, steps: player.choices(SEEDS[episode], steps)
    write_dataset(file.with_suffix(".a26r"), file, **kept)
    return file


def checked(file: Any, policy: Any) -> Agreement:
    agreement = check_dataset(file, policy)
    assert agreement is not None
    return agreement


def test_greedy_steps_and_exploration(tmp_path: Path) -> None:
    agreement = checked(collected(policy_of(), tmp_path / "a.h5", epsilon=0.2), policy_of())
    assert agreement.agrees
    assert agreement.steps[Choice.GREEDY] == agreement.equal[Choice.GREEDY] > 100
    assert agreement.steps[Choice.EXPLORATION] > 20
    assert agreement.equal[Choice.EXPLORATION] < agreement.steps[Choice.EXPLORATION]  # other actions than the policy's
    assert str(agreement).splitlines()[0].split() == ["chosen", "steps", "equal", "near", "ties", "different"]


def test_sampled_steps_are_drawn_again(tmp_path: Path) -> None:
    file = collected(policy_of(sample=True), tmp_path / "a.h5")
    with pytest.raises(ValueError, match="no greedy step that could be compared") as error:
        check_dataset(file, policy_of(sample=True))
    _, row = str(error.value).splitlines()[-2:]
    name, steps, same, ties, different = row.split()
    assert (name, steps, ties, different) == ("sampled", same, "0", "0")


def test_a_policy_with_a_memory(tmp_path: Path) -> None:
    agreement = checked(collected(Remembering(), tmp_path / "a.h5"), Remembering())
    assert agreement.equal[Choice.GREEDY] == agreement.steps[Choice.GREEDY] > 100


def test_another_policy_is_found(tmp_path: Path) -> None:
    file = collected(policy_of(), tmp_path / "a.h5")
    with pytest.raises(ValueError, match="has other actions than the policy chooses"):
        check_dataset(file, policy_of(lambda observations: scores_of(observations[:, ::-1, ::-1])))


def test_screens_in_place_of_observations_are_found(tmp_path: Path) -> None:
    """The frames of a data set that says that they are what the agent saw, but are unpooled ones."""
    import h5py

    file = collected(policy_of(), tmp_path / "a.h5")
    with h5py.File(file, "r+") as root:
        frames = root["episode_0/frames"]
        frames[:] = np.roll(frames[:], 1, axis=1)
    with pytest.raises(ValueError, match="has other actions"):
        check_dataset(file, policy_of())


@pytest.mark.parametrize(
    ("steps", "equal", "ties", "agrees"),
    [(5000, 5000, 0, True), (5000, 4995, 5, True), (5000, 4994, 6, False), (5000, 4999, 0, False)],
)
def test_agrees(steps: int, equal: int, ties: int, agrees: bool) -> None:
    counts = [{**dict.fromkeys(Choice, 0), Choice.GREEDY: number} for number in (steps, equal, ties)]
    assert Agreement(*counts).agrees is agrees


def test_all_steps_may_be_near_ties_in_no_file(tmp_path: Path) -> None:
    file = collected(policy_of(lambda observations: scores_of(observations, 1e-6)), tmp_path / "a.h5")
    with pytest.raises(ValueError, match="has other actions") as error:
        check_dataset(file, policy_of(lambda observations: scores_of(observations, 1e-6)[:, ::-1]))
    _, steps, same, ties, different = str(error.value).splitlines()[-1].split()
    assert (int(same) + int(ties), different) == (int(steps), "0")


def test_layouts_and_actions_of_policies(tmp_path: Path) -> None:
    """A policy with the channels last, as floats, with three named actions in a game of all actions."""

    def scores(observations: Any) -> Any:
        assert (observations.shape, observations.dtype) == ((1, 84, 84, 4), np.float32)
        return scores_of(observations)[:, :3]

    options = {"preset": "baselines", "actions": ["NOOP", "RIGHT", "LEFT"], "channels_last": True, "dtype": "float32"}
    policy = load_policy(ScoresPolicy(scores, environment=options, name="mine"))
    task = TASK.replace(actions="full")
    agreement = checked(collected(policy, tmp_path / "a.h5", task=task), policy)
    assert agreement.equal[Choice.GREEDY] == agreement.steps[Choice.GREEDY] > 100


@pytest.mark.parametrize("options", [{"obs_type": "grayscale", "maxpool": True}, {"obs_type": "ram"}, {}])
def test_observations_without_stacks(options: dict[str, Any], tmp_path: Path) -> None:
    task = Task.of("breakout", **options, max_num_frames_per_episode=400)
    policy = load_policy(ScoresPolicy(scores_of, task=task, name="mine"))
    agreement = checked(collected(policy, tmp_path / "a.h5", task=task), policy)
    assert agreement.equal[Choice.GREEDY] == agreement.steps[Choice.GREEDY] > 50


def test_folders(tmp_path: Path) -> None:
    pytest.importorskip("pyarrow.parquet", reason="pyarrow is not installed")
    (tmp_path / "games.parquet").mkdir()
    one = checked(collected(policy_of(), tmp_path / "games.parquet" / "a.parquet"), policy_of())
    both = collected(policy_of(), tmp_path / "games.parquet" / "b.parquet").parent
    assert checked(both, policy_of()).steps[Choice.GREEDY] == 2 * one.steps[Choice.GREEDY]
    data = bytearray((both / "b.parquet").read_bytes())
    data[len(data) // 2] ^= 1
    (both / "b.parquet").write_bytes(data)
    with pytest.raises(ValueError, match=r"b\.parquet is damaged"):
        check_dataset(both)


def test_other_observations_are_refused(tmp_path: Path) -> None:
    file = collected(policy_of(), tmp_path / "a.h5", observations="screen")
    assert check_dataset(file) is None
    with pytest.raises(ValueError, match="observations='screen', and a policy chooses from what it saw"):
        check_dataset(file, policy_of())

"""`RecordSearch`: a state that a search found becomes a replay from the game's beginning."""

import copy
import pickle
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import atari
from atari.base.gymnasium_versions import AutoresetMode
from atari.recording import RecordSearch, Replay

LANES = 4


def make(game: Any = "breakout", **options: Any) -> RecordSearch:
    return RecordSearch(atari.AtariVectorEnv(game, LANES, num_threads=1, **options))


def search(envs: RecordSearch, rounds: int = 12, steps: int = 15, seed: int = 0) -> list[Any]:
    """Go on from random snapshots by random plans; returns the archive of snapshots."""
    rng, archive = np.random.default_rng(seed), envs.snapshot([0])
    space = envs.single_action_space
    space.seed(seed)
    for number in range(rounds):
        chosen = [archive[index] for index in rng.integers(len(archive), size=LANES)]
        envs.restore(None, chosen)
        plans = np.array([[space.sample() for _ in range(steps)] for _ in range(LANES)])
        if number % 3:
            envs.play(plans)
        else:
            envs.play(plans[:2], env_id=[3, 1])
            envs.step(plans[:, 0])
            envs.fork(1, [0])
        archive += envs.snapshot()
    return archive


CASES: dict[str, dict[str, Any]] = {
    "dqn2015": {"preset": "dqn2015"},
    "sticky actions": {"preset": "machado2018"},
    "ale-py's seeds, drawn skips": {"repeat_action_probability": 0.25, "frameskip": (2, 5)},
    "lives": {"preset": "baselines", "episodic_life": True},
    "continuous": {"preset": "dqn2015", "continuous": True},
    "delays": {"preset": "dqn2015", "action_delay": (1, 4), "observation_delay": 2},
    "interventions": {"preset": "machado2018", "interventions": ["wind"]},
}


@pytest.mark.parametrize("mode", list(AutoresetMode))
@pytest.mark.parametrize("case", CASES)
def test_a_replay_ends_in_the_state_that_was_found(case: str, mode: AutoresetMode, tmp_path: Path) -> None:
    envs = make(**CASES[case], autoreset_mode=mode)
    envs.reset(seed=3)
    archive = search(envs)
    for number in (5, len(archive) - 1):
        replay = envs.write_replay(archive[number], tmp_path / f"{number}.a26r")
        assert replay.verify("plain")
        envs.restore([2], [archive[number]])
        core = replay.seek(replay.frames_total)
        lane = envs._vector.lanes[2]
        assert core.ram().tolist() == lane.ram().tolist()
        assert core.frame_number == lane.frame_number


def test_the_trajectory_is_what_was_played_up_to_the_snapshot(tmp_path: Path) -> None:
    envs = make(preset="machado2018", autoreset_mode="Disabled")
    envs.reset(seed=3)
    found = search(envs)[-1]
    actions = envs.trajectory(found)
    again = atari.AtariVectorEnv(envs._vector.task, LANES, autoreset_mode="Disabled")
    again.reset(seed=3)
    again.play(actions[None], env_id=[0])
    assert again.snapshot([0])[0].state.__getstate__() == found.state.__getstate__()
    replay = envs.write_replay(found, tmp_path / "found.a26r")
    assert replay.steps == len(actions)
    assert replay.seeds[-1] == int(np.random.SeedSequence(3).generate_state(2)[1])
    assert replay.verify("ale")


def test_a_search_goes_on_over_resets(tmp_path: Path) -> None:
    envs = make(preset="baselines", episodic_life=True, autoreset_mode="Disabled")
    envs.reset()
    for _ in range(3):
        envs.play(np.ones((LANES, 200), int))
        envs.reset(options={"reset_mask": np.array([True, False, True, True])})
    envs.play(np.ones((LANES, 9), int))
    found = envs.snapshot([0])[0]
    assert len(envs.write_replay(found, tmp_path / "lives.a26r").episodes) == 1
    envs.reset(options={"new_game": True})
    assert len(envs.write_replay(envs.snapshot([0])[0], tmp_path / "games.a26r").episodes) == 2


def test_states_from_elsewhere_are_in_the_file(tmp_path: Path) -> None:
    vector = atari.AtariVectorEnv("breakout", LANES, preset="machado2018")
    vector.reset(seed=0)
    vector.play(np.ones((LANES, 30), int))
    envs = RecordSearch(vector)
    envs.play(np.full((LANES, 20), 2))
    replay = envs.write_replay(envs.snapshot([1])[0], tmp_path / "begun.a26r")
    assert replay.steps == 20
    assert len(replay._content.snapshots) == 1
    envs.restore([0, 1], [vector.snapshot([2])[0], vector.snapshot([3], packed=True)[0]])
    envs.step(np.ones(LANES, int))
    for lane in (0, 1):
        assert envs.write_replay(envs.snapshot([lane])[0], tmp_path / f"{lane}.a26r").steps == 1


def test_snapshots_can_be_copied(tmp_path: Path) -> None:
    envs = make(preset="dqn2015")
    envs.reset(seed=0)
    for _ in range(3000):
        envs.step(np.zeros(LANES, int))
    found = envs.snapshot([0])[0]
    for copied in (pickle.loads(pickle.dumps(found)), copy.deepcopy(found)):
        assert np.array_equal(envs.trajectory(copied), envs.trajectory(found))
    envs.restore([1], [copied])
    envs.step(np.ones(LANES, int))
    assert len(envs.trajectory(envs.snapshot([1])[0])) == 3001


def test_several_games(tmp_path: Path) -> None:
    envs = RecordSearch(atari.AtariVectorEnv(["pong", "breakout"], preset="dqn2015", num_threads=1))
    envs.reset(seed=0)
    envs.play(np.array([[2, 3, 4] * 5, [1, 3, 4] * 5]))
    for lane, game in enumerate(("pong", "breakout")):
        replay = envs.write_replay(envs.snapshot([lane])[0], tmp_path / f"{game}.a26r")
        assert replay.game.id == game


def test_snapshots_are_those_of_the_vector() -> None:
    envs, plain = make(preset="dqn2015"), atari.AtariVectorEnv("breakout", LANES, preset="dqn2015")
    envs.reset(seed=0)
    plain.reset(seed=0)
    actions = np.ones((LANES, 12), int)
    assert np.array_equal(envs.play(actions)[0], plain.play(actions)[0])
    plain.restore([0], [envs.snapshot([1])[0]])
    assert plain.ram([0]).tolist() == plain.ram([1]).tolist()


def test_what_is_refused(tmp_path: Path) -> None:
    envs, other = make(preset="dqn2015"), make("pong", preset="dqn2015")
    for one in (envs, other):
        one.reset(seed=0)
    (found,) = envs.snapshot([0])
    path = tmp_path / "x.a26r"
    with pytest.raises(TypeError, match=r"give a snapshot that RecordSearch\.snapshot returned"):
        envs.write_replay(envs._vector.snapshot([0])[0], path)  # type: ignore[arg-type]
    with pytest.raises(ValueError, match="of another task"):
        other.write_replay(found, path)
    with pytest.raises(ValueError, match="a26r"):
        envs.write_replay(found, tmp_path / "x.mp4")
    with pytest.raises(TypeError, match="records an AtariVectorEnv, got AtariEnv; give one of 1 environment"):
        RecordSearch(atari.AtariEnv("pong"))  # type: ignore[arg-type]
    with pytest.raises(TypeError, match="put RecordSearch around it"):
        RecordSearch(envs)
    with pytest.raises(ValueError, match="batches of all"):
        RecordSearch(atari.AtariVectorEnv("pong", 4, batch_size=2))
    envs._vector.lanes[0].set_ram(70, 1)
    envs.step(np.zeros(LANES, int))
    with pytest.raises(RuntimeError, match="ends in another state"):
        envs.write_replay(envs.snapshot([0])[0], path)
    assert Replay.load(path).complete

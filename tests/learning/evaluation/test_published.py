"""Published results: the packed data, its sources, and known figures that it gives."""

import json
import zlib

import numpy as np
import pytest

import atari
from atari.learning import Published
from atari.learning.evaluation import published
from atari.learning.evaluation.published import read_table
from atari.learning.evaluation.statistics import interquartile_mean


def test_every_agent_can_be_read():
    names = Published.names()
    assert len(names) == len(set(names)) == 69
    for name in names:
        agent = Published(name)
        assert agent.name == name
        assert {"repo", "licence", "copyright", "score"} <= set(agent.source), name
        assert {
            "repeat_action_probability",
            "noop_min",
            "noop_max",
            "full_action_space",
            "frame_skip",
            "max_frames",
            "lives",
            "phase",
        } == set(agent.protocol)
        assert set(agent.games) <= set(atari.games)
        for game in agent.games:
            final = agent.final(game)
            assert final.ndim == 1
            assert np.isfinite(final).all()
            if agent.has_curves:
                curve = agent.curve(game)
                assert curve.frames.shape == curve.mean.shape == curve.std.shape
                assert (np.diff(curve.frames) > 0).all()
                assert curve.frames[-1] == agent.final_frames


def test_the_files_are_small_and_their_licences_are_there():
    folder = published._FOLDER
    data = [file.read_bytes() for file in folder.glob("*.json")]
    assert len(data) == 13
    assert sum(len(zlib.compress(each)) for each in data) < 1_000_000  # as they are in a wheel
    licences = (folder / "LICENSES.md").read_text()
    for name in Published.names():
        source = Published(name).source
        assert source["repo"].split(";")[0] in licences
        assert source["licence"] in licences or name.startswith("papers/")
        assert source["copyright"].split(" ", 1)[-1] in licences or name.startswith("papers/")
    assert "Apache License" in (folder / "Apache-2.0.txt").read_text()


@pytest.mark.parametrize("name", [*read_table("index")["agents"], "human"])
def test_a_score_is_on_a_line_of_its_game(name):
    """A change of a score shows in a diff as one line, which begins with the game."""
    content, lines = read_table(name), (published._FOLDER / f"{name}.json").read_text(encoding="utf-8").splitlines()
    entries = content["tables"] if name == "human" else content
    for game in {game for entry in entries.values() for game in entry["games"]}:
        wanted = [entry["games"][game] for entry in entries.values() if game in entry["games"]]
        found = [line.strip().removeprefix(f'"{game}": ').rstrip(",") for line in lines if f'"{game}": ' in line]
        assert [json.loads(each) for each in found] == wanted


@pytest.mark.parametrize(
    ("name", "median"), [("dopamine/rainbow", 1.48), ("pfrl/rainbow", 2.47), ("papers/dqn2015", 0.793)]
)
def test_known_medians(name, median):
    """The medians in docs/evaluation.md, which were computed from the sources."""
    agent, human = Published(name), Published.human_scores()
    scores = [
        (agent.final(game).mean() - human[game][0]) / (human[game][1] - human[game][0])
        for game in agent.games
        if game in human
    ]
    assert np.median(scores) == pytest.approx(median, abs=0.005)


def test_known_iqm():
    """DQN of Dopamine: 0.75."""
    agent, human = Published("dopamine/dqn"), Published.human_scores()
    scores = [
        (agent.final(game) - human[game][0]) / (human[game][1] - human[game][0])
        for game in agent.games
        if game in human
    ]
    assert interquartile_mean(np.concatenate(scores)) == pytest.approx(0.75, abs=0.005)


def test_scores_at_frames():
    agent = Published("dopamine/rainbow")
    assert agent.at("pong", 10_000_000).shape == (5,)
    assert agent.at("pong", 199_000_000).shape == (5,)
    between = agent.at("pong", 30_000_001)  # in the interval that ends at 31 million
    assert between == agent.curve("pong").mean[30]
    assert agent.interval(30_000_001) == (30_000_001, 31_000_000)
    assert agent.interval(10_000_000) == (10_000_000, 10_000_000)
    assert agent.interval(199_000_064) == (199_000_000, 199_000_000)  # the end of a whole update
    with pytest.raises(ValueError, match="until 199,000,000 frames, not at 200,000,000"):
        agent.at("pong", 200_000_000)
    ppo = Published("cleanrl/ppo")
    assert ppo.name == "cleanrl/ppo_atari_envpool_xla_jax"
    assert ppo.at("pong", 40_000_000) == ppo.final("pong")
    with pytest.raises(ValueError, match="only at 40,000,000 frames"):
        ppo.at("pong", 10_000_000)
    with pytest.raises(ValueError, match=r"final\('pong'\)"):
        ppo.curve("pong")


@pytest.mark.parametrize(
    ("name", "near"), [("dopamine/rainbw", "dopamine/rainbow"), ("cleanrl/pqn_atari", "cleanrl/pqn_atari_envpool")]
)
def test_a_wrong_name_suggests_the_nearest(name, near):
    with pytest.raises(ValueError, match=near):
        Published(name)


def test_nothing_is_extrapolated_before_the_first_score():
    agent = Published("dopamine/rainbow")
    assert agent.budgets[:4] == (1_000_000, 2_000_000, 2_500_000, 3_000_000)
    assert agent.at("pong", 1_000_000).mean() == pytest.approx(agent.curve("pong").mean[0], abs=0.01)
    for frames in (1, 262_144, 999_999):
        with pytest.raises(
            ValueError, match=rf"first scores of dopamine/rainbow are at 1,000,000 frames, not at {frames:,}"
        ):
            agent.at("pong", frames)
    coarse = Published("dreamerv3/atari57/ppo")  # its curve has intervals of five million frames
    assert coarse.at("pong", 2_500_000).shape == coarse.at("pong", 1_000_000).shape
    with pytest.raises(ValueError, match="are at 1,000,000, 2,500,000, 5,000,000 frames, not at 3,000,000"):
        coarse.at("pong", 3_000_000)
    assert Published("cleanrl/ppo").budgets == (40_000_000,)


def test_wrong_arguments():
    with pytest.raises(TypeError, match="string"):
        Published(3)
    with pytest.raises(ValueError, match="breakout"):
        Published("dopamine/rainbow").final("breakuot")
    with pytest.raises(ValueError, match="noop57"):
        Published.human_scores("noop")
    with pytest.raises(TypeError, match="string"):
        Published.human_scores(None)


def test_human_tables():
    assert {
        name: len(Published.human_scores(name)) for name in ("noop57", "nature2015", "human_starts", "dqn2013")
    } == {
        "noop57": 57,
        "nature2015": 49,
        "human_starts": 57,
        "dqn2013": 7,
    }
    assert Published.human_scores()["video_pinball"] == (16256.9, 17667.9)
    assert Published.human_scores("nature2015")["beam_rider"] != Published.human_scores()["beam_rider"]

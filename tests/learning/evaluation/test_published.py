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

PROTOCOL = {*"repeat_action_probability noop_min noop_max full_action_space frame_skip max_frames lives phase".split()}


def test_every_agent_can_be_read():
    names = Published.names()
    assert len(names) == len(set(names)) == 69
    for name in names:
        agent = Published(name)
        assert agent.name == name
        assert {"repo", "licence", "copyright", "score"} <= set(agent.source), name
        assert set(agent.protocol) == PROTOCOL
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
    ("name", "median", "iqm"),
    [
        ("dopamine/rainbow", 1.48, None),
        ("pfrl/rainbow", 2.47, None),
        ("papers/dqn2015", 0.793, None),
        ("dopamine/dqn", None, 0.75),
    ],
)
def test_known_summaries(name, median, iqm):
    """The summaries in docs/evaluation.md, which were computed from the sources."""
    agent, human = Published(name), Published.human_scores()
    references = {game: human[game] for game in agent.games if game in human}
    scores = [(agent.final(game) - low) / (high - low) for game, (low, high) in references.items()]
    if median is not None:
        assert np.median([runs.mean() for runs in scores]) == pytest.approx(median, abs=0.005)
    if iqm is not None:
        assert interquartile_mean(np.concatenate(scores)) == pytest.approx(iqm, abs=0.005)


def test_scores_at_frames():
    agent = Published("dopamine/rainbow")
    assert agent.at("pong", 10_000_000).shape == (5,)
    assert agent.at("pong", 199_000_000).shape == (5,)
    between = agent.at("pong", 30_000_001)  # in the interval that ends at 31 million
    assert between == agent.curve("pong").mean[30]
    assert agent.interval(30_000_001) == (30_000_001, 31_000_000)
    assert agent.interval(10_000_000) == (10_000_000, 10_000_000)
    assert agent.interval(199_000_064) == (199_000_000, 199_000_000)  # the end of a whole update
    with pytest.raises(ValueError, match="until 199,000,000 frames, not at 202,000,000"):
        agent.at("pong", 202_000_000)
    ppo = Published("cleanrl/ppo")
    assert ppo.name == "cleanrl/ppo_atari_envpool_xla_jax"
    assert ppo.at("pong", 40_000_000) == ppo.final("pong")
    with pytest.raises(ValueError, match="only at 40,000,000 frames"):
        ppo.at("pong", 10_000_000)
    with pytest.raises(ValueError, match=r"final\('pong'\)"):
        ppo.curve("pong")


def test_nothing_is_extrapolated_before_the_first_score():
    agent = Published("dopamine/rainbow")
    assert agent.budgets[:4] == (1_000_000, 2_000_000, 2_500_000, 3_000_000)
    assert agent.at("pong", 1_000_000).mean() == pytest.approx(agent.curve("pong").mean[0], abs=0.01)
    for frames in (1, 262_144, 999_999):
        with pytest.raises(ValueError, match=f"of dopamine/rainbow are at 1,000,000 frames, not at {frames:,}"):
            agent.at("pong", frames)
    coarse = Published("dreamerv3/atari57/ppo")  # its curve has intervals of five million frames
    assert coarse.at("pong", 2_500_000).shape == coarse.at("pong", 1_000_000).shape
    with pytest.raises(ValueError, match="are at 1,000,000, 2,500,000, 5,000,000 frames, not at 3,000,000"):
        coarse.at("pong", 3_000_000)
    assert Published("cleanrl/ppo").budgets == (40_000_000,)


@pytest.mark.parametrize(
    ("call", "argument", "error", "text"),
    [
        (Published, "dopamine/rainbw", ValueError, "dopamine/rainbow"),
        (Published, "cleanrl/pqn_atari", ValueError, "cleanrl/pqn_atari_envpool"),
        (Published, 3, TypeError, "string"),
        (Published("dopamine/rainbow").final, "breakuot", ValueError, "breakout"),
        (Published.human_scores, "noop", ValueError, "noop57"),
        (Published.human_scores, None, TypeError, "string"),
    ],
)
def test_wrong_arguments(call, argument, error, text):
    with pytest.raises(error, match=text):
        call(argument)


def test_human_tables():
    sizes = {"noop57": 57, "nature2015": 49, "human_starts": 57, "dqn2013": 7}
    assert {name: len(Published.human_scores(name)) for name in sizes} == sizes
    assert Published.human_scores()["video_pinball"] == (16256.9, 17667.9)
    assert Published.human_scores("nature2015")["beam_rider"] != Published.human_scores()["beam_rider"]

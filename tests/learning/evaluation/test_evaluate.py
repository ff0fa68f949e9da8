"""`evaluate`: the games that are played, their environments, and the scores of whole games."""

import json
from dataclasses import replace

import gymnasium
import numpy as np
import pytest
from field_values import CASES

import atari
from atari.learning import PROTOCOLS, EvaluationProtocol, Result, ScoresPolicy, evaluate, load_policy, record_games
from atari.learning.evaluation.evaluate import EvaluatedPolicy, episode_seed
from atari.learning.evaluation.played import resolve_games, usual_protocol
from atari.task import PRESETS, Task
from atari.task.fields import OF_GAME
from atari.wrappers import preset, preset_options


def short(name, frames=1600, **changes):
    return replace(PROTOCOLS[name], **{"name": f"short {name}", "max_frames": frames, "epsilon": 0.0, **changes})


def whole_games(task, episodes=1, epsilon=0.0):
    return EvaluationProtocol.of_task(task, name="mine", source="", epsilon=epsilon, episodes=episodes)


def constant(action=0, **attributes):
    """A policy of one action that keeps its observations."""

    def policy(observations, lanes):
        policy.seen.append(observations.copy())
        return np.full(len(lanes), action)

    vars(policy).update(seen=[], **attributes)
    return policy


def sums(observations):
    """Actions that depend on every pixel."""
    return observations.reshape(len(observations), -1).sum(1, dtype=np.int64) % 4


def single_game(game, protocol, seed, policy=sums):
    """Score and frames of one game, played with the wrappers of single environments."""
    options = {**preset_options(protocol.preset), "max_num_frames_per_episode": protocol.max_frames}
    lives = {"episodic_life": protocol.lives != "continue"}
    noops = (protocol.noop_min, protocol.noop_max)
    if noops == PRESETS[protocol.preset].fields.get("noops", (0, 0)):
        env = preset(atari.AtariEnv(game, **options), protocol.preset, clip_reward=False, **lives)
    else:  # as the preset, after other no-ops
        own = {"noops": noops, "max_num_frames_per_episode": protocol.max_frames, "reward_clipping": False}
        env = atari.make(Task.of(game, preset=protocol.preset, **own, **lives))
    observation, info = env.reset(seed=seed)
    while True:
        observation, _, terminated, truncated, info = env.step(int(policy(observation[None])[0]))
        if (terminated or truncated) and "episode" not in info:
            observation, info = env.reset()
        if "episode" in info:
            return float(info["episode"]["r"]), int(info["episode"]["l"])


OF_PRESETS = {f"lives of {name}": (name, "preset") for name in ("atari100k", "baselines", "dopamine", "dqn2015")}
PLAYED = {name: (name, one.lives) for name, one in PROTOCOLS.items()} | OF_PRESETS


@pytest.mark.parametrize(("name", "lives"), PLAYED.values(), ids=PLAYED)
@pytest.mark.parametrize("game", ["breakout", "ms_pacman"])
def test_games_are_those_of_the_wrappers(name, lives, game):
    protocol = short(name, lives=lives)
    result = evaluate(sums, game, protocol, episodes=3, seed=5, num_envs=2)[game]
    expected = [single_game(game, protocol, episode_seed(5, game, episode)) for episode in range(3)]
    assert list(zip(result.scores, result.frames, strict=True)) == expected
    assert result.truncated == tuple(frames >= protocol.max_frames for _, frames in expected)


def test_a_score_is_that_of_all_lives_and_not_clipped():
    result = evaluate("random", "qbert", "baselines", episodes=2)["qbert"]
    assert max(result.scores) > 100  # the least reward of Q*bert is 25: the sum of clipped rewards would be about 10
    assert min(result.frames) > 800  # a life is about 250


@pytest.mark.parametrize("name", ["dqn2015", "baselines"])
def test_the_number_of_lanes_and_threads_does_not_matter(name):
    protocol = short(name, 800, epsilon=0.3)
    games = ["pong", "breakout"]
    results = [
        evaluate("random", games, protocol, episodes=5, seed=3, num_envs=lanes, num_threads=threads)
        for lanes, threads in [(1, 1), (2, 2), (7, 2), (None, 0)]
    ]
    assert all(result == results[0] for result in results)
    fewer = evaluate("random", "breakout", protocol, episodes=2, seed=3)
    assert fewer["breakout"].scores == results[0]["breakout"].scores[:2]
    assert evaluate("random", games, protocol, episodes=5, seed=4) != results[0]


def test_a_sampling_policy_has_a_generator_for_each_game():
    def logits(observations):
        return np.zeros((len(observations), 4))

    def play(sample, lanes):
        policy = ScoresPolicy(logits, sample=sample)
        return evaluate(policy, "breakout", short("dopamine"), episodes=4, num_envs=lanes)["breakout"]

    assert play(True, 1) == play(True, 3) != play(False, 3)


def test_each_lane_plays_its_own_games_to_their_ends():
    """A batch of 2 lanes plays games 0, 2, 4 and 1, 3, whatever their lengths."""
    begun = []

    class Policy:
        def begin(self, game, actions, lanes, seeds):
            assert actions == ("NOOP", "FIRE", "RIGHT", "LEFT")
            begun.extend(zip(lanes.tolist(), seeds.tolist(), strict=True))

        def __call__(self, observations, lanes):
            assert len(observations) == len(lanes)
            return np.where(lanes == 0, 1, 0)  # lane 1 never presses FIRE

    result = evaluate(Policy(), "breakout", short("dopamine"), episodes=5, num_envs=2)["breakout"]
    seeds = [episode_seed(0, "breakout", episode) for episode in range(5)]
    assert sorted(begun) == sorted((episode % 2, seed) for episode, seed in enumerate(seeds))
    assert result.seeds == tuple(seeds)
    assert result.truncated == (False, True, False, True, False)
    assert [frames == 1600 for frames in result.frames] == [False, True, False, True, False]


def test_epsilon_draws_actions_that_the_policy_does_not_choose():
    """Without random actions no ball is served, and all games are truncated."""
    result, fire = (evaluate("noop", "breakout", short("dopamine", epsilon=one), episodes=4) for one in (0.0, 0.5))
    assert fire["breakout"].truncations < result["breakout"].truncations == 4
    assert str(result).splitlines()[-1] == "4 of 4 games did not end within 1,600 frames"


@pytest.mark.parametrize(
    ("environment", "shape"),
    [
        ({}, (4, 84, 84)),
        ({"preset": "baselines"}, (4, 84, 84)),
        ({"obs_type": "ram"}, (128,)),
        ({"img_height": 42, "img_width": 40, "stack_num": 2}, (2, 42, 40)),
        ({"channels_last": True, "stack_num": 3}, (84, 84, 3)),
        ({"grayscale": False, "stack_num": 1, "noop_max": 7, "episodic_life": True}, (1, 84, 84, 3)),
    ],
)
def test_a_policy_gets_the_observations_that_it_names(environment, shape):
    policy = constant(environment=environment)
    result = evaluate(policy, "breakout", short("dqn2015", 100), episodes=2)
    assert {seen.shape[1:] for seen in policy.seen} == {shape}
    assert result["breakout"].observation["padding"] == "zero"


def test_a_policy_of_the_games_own_actions_is_translated():
    """Index 2 of Breakout's four actions is RIGHT, which is index 3 of all."""
    needed = ((2, {"full_action_space": False}), (3, {"full_action_space": True}), (1, {"actions": ["LEFT", "RIGHT"]}))
    shown = []
    for action, environment in needed:
        policy = constant(action, environment=environment)

        def alone(observations, policy=policy):  # a second argument with a default is not `lanes`
            return policy(observations, range(len(observations)))

        alone.environment = environment
        evaluate(alone, "breakout", short("machado2018", 200), episodes=1)
        shown.append(policy.seen)
    assert len(shown[0]) == 50
    np.testing.assert_array_equal(shown[0], shown[1])
    np.testing.assert_array_equal(shown[0], shown[2])


def returns(actions):
    def policy(observations):
        return actions(len(observations))

    return policy


def needs(**environment):
    policy = returns(np.zeros)
    policy.environment = environment
    return policy


def of_task(task, **environment):
    policy = needs(**environment)
    policy.task = task
    return policy


@pytest.mark.parametrize(
    ("error", "arguments", "text"),
    [
        (ValueError, {"games": "pogn"}, "pong"),
        (TypeError, {"games": []}, "games must be"),
        (TypeError, {"games": 3}, "games must be"),
        (ValueError, {"games": ["pong", "atari27"]}, "atari27"),
        (ValueError, {"protocol": "machado"}, "did you mean 'machado2018'"),
        (TypeError, {"protocol": 5}, "protocol"),
        (ValueError, {"episodes": 0}, "episodes must be within 1"),
        (TypeError, {"episodes": 1.5}, "episodes must be an integer"),
        (ValueError, {"seed": -1}, "seed must be within"),
        (ValueError, {"seed": 2**32}, "seed must be within 0..4294967295, got 4294967296"),
        (ValueError, {"num_envs": 0}, "num_envs must be within"),
        (TypeError, {"policy": 5}, "a policy is a function"),
        (TypeError, {"policy": lambda: 0}, "a policy is a function of observations and lanes, got 0"),
        (TypeError, {"policy": lambda a, b, c: 0}, "a policy takes"),
        (ValueError, {"policy": {"breakout": "random"}}, "there is no policy for pong"),
        (ValueError, {"policy": returns(np.zeros)}, "must return integers"),
        (ValueError, {"policy": returns(lambda n: np.full(n, 18))}, "returned action 18; in pong it has 18 actions"),
        (ValueError, {"policy": returns(lambda n: np.full(n, -1))}, "returned action -1"),
        (ValueError, {"policy": needs(stack=4)}, "has no option 'stack'"),
        (ValueError, {"policy": needs(frameskip="four")}, "frameskip"),
        (ValueError, {"policy": needs(preset=5)}, "there is no preset"),
        (ValueError, {"policy": needs(actions=5)}, "a list of names"),
        (ValueError, {"policy": needs(img_height="84")}, "the environment of the policy"),
        (FileNotFoundError, {"policy": needs(rom="nosuch.bin")}, "nosuch.bin"),
        (ValueError, {"policy": needs(frameskip=5)}, "plays 4 frames an action, the policy 5"),
        (ValueError, {"policy": needs(mode=1)}, "pass atari.Task.of('pong', mode=1) as the game"),
        (ValueError, {"policy": needs(difficulty=1)}, "pass atari.Task.of('pong', difficulty=1) as the game"),
        (ValueError, {"policy": needs(interventions=["lazy_enemy"])}, "interventions=['lazy_enemy']) as the game"),
        (ValueError, {"policy": needs(players=2)}, "plays games with players=1, and the policy has players=2"),
        (ValueError, {"policy": needs(continuous=True)}, "plays games with continuous=False, and the policy"),
        (ValueError, {"policy": needs(continuous_action_threshold=0.25)}, "threshold=0.25 has no effect"),
        (ValueError, {"policy": needs(num_threads=2)}, "num_threads is an option of what plays the policy"),
        (ValueError, {"policy": needs(task=5)}, "task must be an atari.Task"),
        (ValueError, {"policy": needs(task={"format": 1, "game": "pong", "luck": 1})}, "no key 'luck'"),
        (ValueError, {"policy": of_task(Task.of("pong", preset="dqn2015"), stack_num=2)}, "decides stack_num, too"),
        (ValueError, {"policy": of_task(Task.of("pong", frameskip=(2, 5)))}, "4 frames an action, the policy 2 to 4"),
        (ValueError, {"policy": needs(interventions=["lazy_enemy"])}, "give a command --intervention lazy_enemy"),
        (ValueError, {"games": Task.of("pong", players=2)}, "plays games with players=1"),
        (ValueError, {"games": Task.of("pong", continuous=True)}, "plays games with continuous=False"),
        (
            ValueError,
            {"games": "Pong-ram-v0", "policy": needs(preset="dopamine")},
            "shows RAM, and the policy sees obs_",
        ),
        (ValueError, {"games": "ALE/Pong-v5", "policy": needs(obs_type="ram")}, "ALE/Pong-v5 shows images, and the"),
        (ValueError, {"games": "PongNoFrameskip-v4"}, "PongNoFrameskip-v4 has repeat_action_probability=0.0, and prot"),
        (ValueError, {"games": "ALE/Pong-v5", "protocol": "dqn2015"}, "pass 'pong', or another protocol"),
        (ValueError, {"games": ["pong", Task.of("pong", mode=1)]}, "pong is given twice"),
        (
            ValueError,
            {"games": Task.of("pong", frameskip=3, repeat_action_probability=0.1)},
            "the task of pong has repeat_action_probability=0.1, frameskip=3, and protocol 'machado2018' with this policy "
            "plays repeat_action_probability=0.25, frameskip=4; pass 'pong'",
        ),
        (gymnasium.error.NameNotFound, {"games": "ALE/Pog-v5"}, "ALE/Pong-v5"),
        (ValueError, {"policy": needs(preset="dqn15")}, "dqn2015"),
        (ValueError, {"policy": needs(actions=["FLY"])}, "got 'FLY'"),
        (ValueError, {"policy": needs(full_action_space=True), "protocol": "dqn2015"}, "all 18 actions"),
        (ValueError, {"policy": ScoresPolicy(lambda o: np.full((len(o), 6), np.nan))}, "NaN"),
        (ValueError, {"policy": ScoresPolicy(lambda o: np.zeros((len(o), 2, 2)))}, "must return scores"),
    ],
)
def test_wrong_arguments(error, arguments, text):
    with pytest.raises(error) as caught:
        evaluate(**{"policy": "random", "games": "pong", "episodes": 1, **arguments})
    assert text in str(caught.value)


def test_an_error_in_the_policy_is_raised():
    def policy(observations):
        raise ZeroDivisionError("mine")

    with pytest.raises(ZeroDivisionError, match="mine"):
        evaluate(policy, "pong", episodes=1)


def test_progress_and_sources_by_game(tmp_path, monkeypatch):
    (tmp_path / "pong_policy.py").write_text("def act(o):\n    return [0] * len(o)\n")
    (tmp_path / "breakout_policy.py").write_text("class act:\n    def __call__(self, o, lanes): return lanes * 0\n")
    monkeypatch.chdir(tmp_path)
    seen, games = [], ["pong", "breakout"]
    options = {"episodes": 2, "progress": lambda *counts: seen.append(counts)}
    result = evaluate("{game}_policy:act", games, short("dopamine", 100), **options)
    assert seen == [(0, 4), (1, 4), (2, 4), (3, 4), (4, 4)]
    assert result.policy == "{game}_policy:act"
    assert [one.game for one in result.games] == games


def test_a_task_says_what_a_policy_needs():
    task = Task.of("breakout", preset="dqn2015", img_height=42, img_width=40, stack_num=2)
    task = task.replace(actions=["LEFT", "NOOP"])
    policy = constant(task=task, environment={"channels_last": True, "dtype": "float32"})
    one = evaluate(policy, "breakout", short("dopamine", 200), episodes=1)
    assert {(seen.shape, seen.dtype) for seen in policy.seen} == {((1, 42, 40, 2), np.dtype(np.float32))}
    del policy.task
    policy.environment["task"] = json.loads(task.to_json())
    assert evaluate(policy, "breakout", short("dopamine", 200), episodes=1) == one
    played = one["breakout"].task
    assert (played["actions"], played["pool_rgb"], played["episodic_life"]) == ("minimal", True, False)
    assert (played["img_height"], played["repeat_action_probability"], played["noops"]) == (42, 0.25, [0, 0])
    assert one["breakout"].observation["dtype"] == "float32"


def test_the_game_decides_mode_difficulty_and_interventions():
    policy, protocol = constant(1), short("dopamine", 400)
    task = Task.of("pong", mode=1, difficulty=1, interventions=["lazy_enemy"])
    plain, changed = (evaluate(policy, game, protocol, episodes=1)["pong"] for game in ("pong", task))
    assert (plain.task["mode"], changed.task["mode"], changed.task["difficulty"]) == (0, 1, 1)
    assert [one["name"] for one in changed.task["interventions"]] == ["lazy_enemy"]
    assert changed.observation == plain.observation  # both have the images of the protocol's preset
    policy.environment = {"mode": 1, "difficulty": 1, "interventions": ["lazy_enemy"]}
    assert evaluate(policy, task, protocol, episodes=1)["pong"].task["mode"] == 1
    # A policy also meets a mode and interventions that it was not trained in.
    policy.environment = {"preset": "dopamine"}
    assert evaluate(policy, task, protocol, episodes=1)["pong"].task == changed.task


@pytest.mark.parametrize("name", OF_GAME)
@pytest.mark.parametrize("kind", ["named", "of a task"])
def test_the_game_decides_its_fields_alone(name, kind):
    policy, value = constant(1, environment={"preset": "dopamine"}), CASES[name].value
    task = Task.of("breakout", preset="dopamine", **{name: value})
    own = whole_games(task.replace(max_num_frames_per_episode=400))
    protocol = short("dopamine", 400) if kind == "named" else own
    result = evaluate(policy, Task.of("breakout", **{name: value}), protocol, episodes=1)["breakout"]
    assert result.task[name] == json.loads(task.to_json())[name] != json.loads(Task.of("breakout").to_json())[name]
    assert list(result.changes) == [name]
    policy.environment = {"preset": "dopamine", name: value}
    with pytest.raises(ValueError, match=rf"plays breakout with {name}=.*pass atari.Task.of\('breakout', {name}="):
        evaluate(policy, "breakout", short("dopamine", 400), episodes=1)


@pytest.mark.parametrize("game", ["Pong-ram-v0", Task.of("pong", obs_type="ram")])
def test_a_game_of_ram_shows_ram(game):
    policy = constant()
    evaluate(policy, game, short("machado2018", 100), episodes=1)
    assert {seen.shape for seen in policy.seen} == {(1, 128)}


def test_the_games_of_a_task():
    """`EvaluationProtocol.of_task` plays whole games, with scores that are not clipped."""
    task = Task.of("ms_pacman", preset="baselines", frameskip=3, mode=1, max_frames=1500)
    result = evaluate(sums, task, whole_games(task, 3), seed=2)["ms_pacman"]
    env = atari.make(task.replace(reward_clipping=False))
    for seed, score, frames in zip(result.seeds, result.scores, result.frames, strict=True):
        observation, info = env.reset(seed=seed, options={"new_game": True})
        while "episode" not in info:
            observation, _, terminated, truncated, info = env.step(int(sums(observation[None])[0]))
            if (terminated or truncated) and "episode" not in info:
                observation, info = env.reset()
        assert (float(info["episode"]["r"]), int(info["episode"]["l"])) == (score, frames)
    assert Task.from_json(json.dumps(result.task)) == task.replace(reward_clipping=False)


def test_the_games_of_a_task_without_an_end_are_limited():
    task = Task.of("breakout", preset="dopamine", max_num_frames_per_episode=None, obs_type="ram")
    protocol = whole_games(task)
    assert evaluate("noop", "breakout", protocol)["breakout"].frames == (108_000,)
    with pytest.raises(ValueError, match="and the game is pong; pass 'breakout'"):
        evaluate("noop", "pong", protocol)
    with pytest.raises(ValueError, match=r"pass atari.Task.of\('breakout', mode=None\) as the game"):
        evaluate("noop", Task.of("breakout", mode=4), protocol)


@pytest.mark.parametrize(
    ("env_id", "shape", "calls"),
    [
        ("ALE/Pong-v5", (210, 160, 3), (75, 75)),
        ("Pong-ram-v4", (128,), (90, 110)),
        ("PongNoFrameskip-v4", (210, 160, 3), (300, 300)),
    ],
)
def test_a_policy_that_says_nothing_plays_an_id_as_it_is(env_id, shape, calls, tmp_path):
    protocol = usual_protocol(sums, resolve_games(env_id)[0])
    assert protocol.task == Task.of(env_id)
    policy, limited = constant(1), whole_games(protocol.task.replace(max_num_frames_per_episode=300))
    ((_, frames),) = record_games(policy, env_id, limited, [2**32 - 1], tmp_path / "a.a26r")
    assert ({seen.shape[1:] for seen in policy.seen}, frames) == ({shape}, 300)
    assert calls[0] <= len(policy.seen) <= calls[1]


def test_the_frames_of_a_training_are_an_integer(tmp_path):
    policy = constant(training_frames=np.int64(240_000))
    result = evaluate(policy, "pong", short("dqn2015", 400), episodes=1)
    result.save(tmp_path / "r.json")
    assert Result.load(tmp_path / "r.json").training_frames == 240_000
    policy.training_frames = 240_000.0
    with pytest.raises(TypeError, match=r"training_frames must be an integer .* got 240000.0"):
        evaluate(policy, "pong", short("dqn2015", 400), episodes=1)


def test_the_usual_protocol():
    policy = returns(np.zeros)
    (game,) = resolve_games("pong")
    assert usual_protocol(policy, game) == PROTOCOLS["baselines"]
    assert usual_protocol(needs(obs_type="ram"), resolve_games("Pong-ram-v4")[0]) == PROTOCOLS["baselines"]
    policy.task = Task.of("pong", preset="dqn2015")
    assert usual_protocol(policy, game).task == policy.task
    policy.protocol = "dopamine"
    assert usual_protocol(policy, resolve_games("ALE/Pong-v5")[0]) == PROTOCOLS["dopamine"]


def test_a_result_keeps_the_task_of_its_protocol(tmp_path):
    task = Task.of("breakout", preset="envpool", frameskip=(2, 5), actions=["NOOP", "FIRE"], max_frames=60)
    result = evaluate("random", task, whole_games(task, 2, epsilon=0.5))
    result.save(tmp_path / "result.json")
    assert Result.load(tmp_path / "result.json") == result
    assert "the actions NOOP, FIRE, 1-30 no-ops, 2 to 4 frames an action" in str(result)


def test_random_actions_are_those_of_the_task():
    task = Task.of("pong", preset="dopamine", max_num_frames_per_episode=400).replace(actions=["RIGHT", "LEFT"])
    chosen = []
    player = EvaluatedPolicy(load_policy(returns(lambda n: np.zeros(n, int))), task, epsilon=1.0)
    player.begin(np.arange(1), np.arange(1))
    for _ in range(40):
        chosen += player.act(np.zeros(1), np.arange(1)).tolist()
    meanings = [action.name for action in player.make(1).task.action_set]
    assert {meanings[index] for index in chosen} == {"RIGHT", "LEFT"}

"""Snapshots, forks, pickling, and the lanes of a vector."""

import copy
import pickle
from functools import partial
from typing import Any

import gymnasium
import numpy as np
import pytest
import vector_tools
from vector_tools import play

import atari

make = partial(vector_tools.make, repeat_action_probability=0.25)
begun = partial(vector_tools.begun, repeat_action_probability=0.25)

OPTIONS: list[dict[str, Any]] = [
    {},
    {"episodic_life": True, "autoreset_mode": "SameStep"},
    {"maxpool": False, "stack_num": 3, "grayscale": False, "frameskip": (2, 5)},
    {"preset": "baselines", "repeat_action_probability": None},
    {"preset": "envpool", "repeat_action_probability": None},
    {"preset": "dopamine", "episodic_life": True},
]


OF_OPTIONS: Any = pytest.mark.parametrize("options", OPTIONS)


@pytest.mark.parametrize(
    ("game", "options"),
    [
        *(("breakout", options) for options in OPTIONS),
        *((game, {}) for game in ("pitfall2", "elevator_action", "journey_escape", "adventure", "freeway", "pong")),
    ],
)
def test_snapshots_pickles_and_copies_continue(game: str, options: dict[str, Any]) -> None:
    """The games have cartridges with RAM, or rules with variables of their own."""
    envs, other = make(game, 2, **options), make(game, 2, **options)
    other.reset(seed=6)
    envs.reset(seed=1)
    play(envs, 37, seed=1)
    snapshots, copies = envs.snapshot(), [pickle.loads(pickle.dumps(envs)), copy.deepcopy(envs)]
    expected = play(envs, 60, seed=2)
    thawed = pickle.loads(pickle.dumps(snapshots))
    assert pickle.dumps(thawed) == pickle.dumps(snapshots)
    envs.reset(seed=9)
    for one, states in ((envs, snapshots), (other, thawed)):
        one.restore(None, states)
    assert all(play(one, 60, seed=2) == expected for one in (envs, other, *copies))


@pytest.mark.parametrize(
    ("game", "options", "expected"),
    [
        ("beam_rider", {"max_num_frames_per_episode": 40}, (False, True)),
        ("beam_rider", {"preset": "ale_vector", "episodic_life": True, "fire": "never"}, (True, False)),
        ("pong", {"game_info": True}, (True, False)),  # the whole game
    ],
)
def test_a_snapshot_of_an_ended_episode_has_how_it_ended(
    game: str, options: dict[str, Any], expected: tuple[bool, bool]
) -> None:
    envs = atari.AtariVectorEnv(game, 1, autoreset_mode="Disabled", **options)
    envs.reset(seed=0)
    ended = False
    while not ended:
        *_, terminations, truncations, _ = envs.step(np.zeros(1, int))
        ended = bool(terminations[0] or truncations[0])
    assert (terminations[0], truncations[0]) == expected
    snapshots, over = envs.snapshot(), envs.observe()[1].get("terminated")
    assert over is None or over[0] == (game == "pong")
    for taken in (snapshots, pickle.loads(pickle.dumps(snapshots))):  # in memory, and as bytes
        envs.reset(seed=1)
        envs.restore(None, taken)
        assert envs.observe()[1].get("terminated") == over
        *_, terminations, truncations, _ = envs.step(np.zeros(1, int))
        assert (terminations[0], truncations[0]) == expected


def test_a_snapshot_of_one_continues_in_another() -> None:
    envs = begun("seaquest", 3, seed=5)
    play(envs, 20, seed=1)
    (snapshot,) = envs.snapshot([1])
    envs.restore([0, 2], [snapshot, snapshot])
    for action in (3, 1, 11, 4, 0, 12):
        observation, *_, info = envs.step(np.full(3, action))
        assert np.array_equal(observation[0], observation[1])
        assert np.array_equal(observation[2], observation[1])
        assert len(set(info["frame_number"].tolist())) == 1


@OF_OPTIONS
def test_a_restored_environment_can_keep_its_own_generators(options: dict[str, Any]) -> None:
    envs = make("breakout", 4, **{**options, "repeat_action_probability": 0.25})
    envs.reset(seed=1)
    play(envs, 37, seed=1)
    (state,) = envs.snapshot([0])
    envs.fork(1, [2])  # both have the same generators
    envs.restore([1, 2, 3], [state] * 3, own_generators=True)
    kept = envs.snapshot()
    rams = []
    for step in range(60):
        envs.step(np.full(4, step % 4))
        rams.append(envs.ram())
    lanes = np.array(rams).swapaxes(0, 1)
    np.testing.assert_array_equal(lanes[1], lanes[2])
    assert len({lane.tobytes() for lane in lanes}) == 3
    envs.restore(None, kept)  # a snapshot after it has the generators that were kept
    for step in range(60):
        envs.step(np.full(4, step % 4))
        np.testing.assert_array_equal(envs.ram(), rams[step])


def test_fork() -> None:
    envs = begun("seaquest", 40, seed=5)
    envs.fork(7, range(40))
    shown, info = envs.observe()
    assert (shown == shown[7]).all()
    assert set(info["frame_number"].tolist()) == {info["frame_number"][7]}
    observation, *_ = envs.step(np.full(40, 3))
    assert (observation == observation[7]).all()
    for _ in range(40):
        observation, *_ = envs.step(np.arange(40) % 18)
    assert not (observation == observation[7]).all()


def test_a_fork_has_the_state_at_its_call_however_late_it_is_read() -> None:
    """The state is copied later. Calls before the copy must not affect it."""
    envs, twin = make("seaquest", 3, obs_type="ram"), make("seaquest", 3, obs_type="ram")
    for one in (envs, twin):
        one.reset(seed=5)
        play(one, 10, seed=1)
    before, _ = twin.observe()
    envs.fork(0, [1])
    envs.lanes[0].set_ram(3, 99)
    envs.fork(2, [0])  # copied to 0, while 1 still waits for the earlier state of 0
    shown, _ = envs.observe()
    assert np.array_equal(shown, before[[2, 0, 2]])


def test_what_is_done_to_one_after_a_fork_is_done_to_the_fork() -> None:
    envs = begun("breakout", 3, seed=5)
    play(envs, 10, seed=1)
    envs.fork(0, [1, 2])
    envs.lanes[1].set_ram(5, 77)
    assert [ram[5] == 77 for ram in envs.call("ram")] == [False, True, False]
    assert envs.get_attr("frame_number") == (envs.lanes[0].frame_number,) * 3
    kept = envs.snapshot([2])
    envs.reset(seed=9)
    envs.fork(0, [1])
    envs.restore([1], kept)  # before the fork was played
    (again,) = envs.snapshot([1])
    envs.restore([0], [again])
    assert envs.lanes[0].frame_number == envs.lanes[1].frame_number > envs.lanes[2].frame_number


def test_a_forked_environment_can_be_reset_and_pickled() -> None:
    envs, twin = make("pong", 2), make("pong", 2)
    for one in (envs, twin):
        one.reset(seed=3)
        play(one, 10, seed=1)
    envs.fork(0, [1])
    copied = pickle.loads(pickle.dumps(envs))
    assert play(copied, 20, seed=2) == play(envs, 20, seed=2)
    envs.fork(0, [1])
    assert np.array_equal(envs.reset(seed=8)[0], twin.reset(seed=8)[0])


def test_a_pickled_snapshot_is_checked_too() -> None:
    envs = begun(["pong", "breakout"], None, seed=0)
    pong, breakout = pickle.loads(pickle.dumps(envs.snapshot()))
    state, image = pong.state.__getstate__()
    before, _ = envs.observe()
    before = before.copy()
    with pytest.raises(ValueError, match=r"environment 0 cannot continue from it: .* taken with game = 'breakout'"):
        envs.restore([0, 1], [breakout, breakout])
    for bad in (breakout.state, damaged(state[:-1], image), damaged(b"", image), damaged(b"\xff" * len(state), image)):
        with pytest.raises(ValueError, match="snapshot 0 is of another game than environment 0"):
            envs.restore([0, 1], [pong._replace(state=bad), breakout])
        assert np.array_equal(envs.observe()[0], before)
    envs.restore([0, 1], [pong, breakout])


def test_a_refused_snapshot_leaves_those_before_it_unused() -> None:
    envs, twin = begun(num_envs=2, seed=0), begun(num_envs=2, seed=0)
    first, second = pickle.loads(pickle.dumps(envs.snapshot()))
    bad = second._replace(state=damaged(*second.state.__getstate__()[:1], 0))
    play(envs, 5, seed=1), play(twin, 5, seed=1)
    with pytest.raises(ValueError, match="snapshot 1 is of another game than environment 1"):
        envs.restore([0, 1], [first, bad])
    assert play(envs, 5, seed=2) == play(twin, 5, seed=2)


def damaged(state: bytes, image: int) -> Any:
    one: Any = atari._emulator.MemberSnapshot.__new__(atari._emulator.MemberSnapshot)
    one.__setstate__((state, image))
    return one


@pytest.mark.parametrize(
    ("options", "text"),
    [
        ({"repeat_action_probability": 1.0}, r"repeat_action_probability = 0\.25, but this environment has 1\.0"),
        ({"episodic_life": True}, "episodic_life = False, but this environment has True"),
        (
            {"interventions": ["guided_paddle"]},
            r"interventions = None, but this environment has 'guided_paddle \(.*\)'",
        ),
        (
            {"reward_clipping": False, "mode": 4},
            "mode = 0, but this environment has 4; reward_clipping = True, not False",
        ),
    ],
)
def test_a_snapshot_of_another_task_is_refused(options: dict[str, Any], text: str) -> None:
    envs, other = begun(seed=1), begun(seed=1, **options)
    expected = play(copy.deepcopy(other), 10, seed=2)
    with pytest.raises(ValueError, match=f"environment 2 cannot continue from it: the snapshot was taken with {text}"):
        other.restore([2], envs.snapshot([0]))
    assert play(other, 10, seed=2) == expected


def test_environments_of_other_tasks_in_one_vector() -> None:
    plain, changed = (atari.Task.of("breakout", interventions=names) for names in ((), ("guided_paddle",)))
    envs = begun([plain, plain, changed], None, repeat_action_probability=None, seed=1)
    envs.fork(0, [1])
    with pytest.raises(
        ValueError, match=r"environment 2 cannot .* with interventions = None, .* 'guided_paddle \(.*\)'"
    ):
        envs.fork(0, [1, 2])
    first = envs.snapshot()
    envs.lanes[1].mode = 8
    assert [task.mode for task in envs.tasks] == [0, 8, 0]
    with pytest.raises(ValueError, match=r"environment 1 cannot continue from it: .* mode = 0, but this .* 8"):
        envs.restore(None, first)
    envs.lanes[1].mode = 0
    envs.restore(None, first)


def test_observe_changes_nothing() -> None:
    envs, other = make(), make()
    observation, info = envs.reset(seed=3)
    other.reset(seed=3)
    shown, shown_info = envs.observe()
    assert np.array_equal(shown, observation)
    assert np.array_equal(shown_info["frame_number"], info["frame_number"])
    assert play(envs, 20, seed=1) == play(other, 20, seed=1)


def test_what_does_not_fit_is_refused() -> None:
    envs, other = make(["pong", "breakout"], None), make("pong", 1, stack_num=2)
    with pytest.raises(gymnasium.error.ResetNeeded):
        envs.snapshot()
    envs.reset(seed=0)
    other.reset(seed=0)
    single = atari.make("pong", preset="dqn2015")
    single.reset(seed=0)
    of_single: Any = single.snapshot()  # type: ignore[attr-defined]
    pong, breakout = envs.snapshot()
    no_list = r"must be a list that AtariVectorEnv\.snapshot returned"
    before = play(copy.deepcopy(envs), 5, seed=1)
    cases: list[tuple[Any, type[Exception], str]] = [
        (
            lambda: envs.restore([1], [pong]),
            ValueError,
            "environment 1 cannot .* game = 'pong', but this .* 'breakout'",
        ),
        (lambda: other.restore([0], [pong]), ValueError, "with stack_num = 4, but this environment has 2"),
        (lambda: envs.fork(0, [1]), ValueError, "environment 1 cannot continue .* game = 'pong'"),
        (lambda: envs.restore([0, 1], [pong]), ValueError, "a snapshot for each"),
        (lambda: envs.restore([1, 1], [breakout, breakout]), ValueError, r"is given twice: \[1, 1\]"),
        (lambda: envs.fork(0, 1), TypeError, r"by a list of indices, such as \[1, 2\], got 1"),  # type: ignore[arg-type]
        (lambda: envs.fork([0], [1]), TypeError, r"is the index of an environment, such as 0, got \[0\]"),  # type: ignore[arg-type]
        *(
            (lambda wrong=wrong: envs.restore([0], wrong), TypeError, no_list)
            for wrong in (pong, of_single, 5, [None], [3])
        ),
        (lambda: envs.restore([0], [of_single]), ValueError, "environment 0 cannot .* noops"),
        (lambda: envs.restore([0], [b""]), ValueError, "environment 0 cannot .* is empty"),
    ]
    for call, error, text in cases:
        with pytest.raises(error, match=text):
            call()
    assert play(copy.deepcopy(envs), 5, seed=1) == before
    envs.send(np.zeros(2, int))
    with pytest.raises(RuntimeError, match=r"call recv\(\) first"):
        envs.snapshot()
    envs.recv()
    envs.restore(None, [pong, breakout])


def test_pickling_of_one_that_is_new_or_asynchronous() -> None:
    for envs in (make(), make(batch_size=1)):
        twin = pickle.loads(pickle.dumps(envs))
        with pytest.raises(gymnasium.error.ResetNeeded):
            twin.step(np.zeros(twin.batch_size, int))
        twin.reset(seed=0)
        twin.step(np.zeros(twin.batch_size, int))


def test_pickling_while_stepping_is_refused() -> None:
    envs = begun()
    envs.send(np.zeros(3, int))
    with pytest.raises(RuntimeError, match="before pickling"):
        pickle.dumps(envs)


class TestMembers:
    def test_counters_of_lanes(self) -> None:
        envs = make(["pong", "breakout"], None)
        _, info = envs.reset(seed=0)
        *_, info = envs.step(np.array([0, 1]))
        assert envs.get_attr("lives") == tuple(info["lives"].tolist())
        assert envs.get_attr("frame_number") == tuple(info["frame_number"].tolist())
        assert envs.get_attr("episode_frame_number") == tuple(info["episode_frame_number"].tolist())
        assert [game.id for game in envs.get_attr("game")] == ["pong", "breakout"]
        assert envs.call("get_action_meanings")[1] == ["NOOP", "FIRE", "RIGHT", "LEFT"]

    def test_ram(self) -> None:
        envs = make("breakout", 2, obs_type="ram")
        observation, _ = envs.reset(seed=0)
        assert np.array_equal(np.stack(envs.call("ram")), observation)
        envs.lanes[1].set_ram(5, 77)
        assert envs.lanes[1].ram()[5] == 77
        assert envs.lanes[0].ram()[5] != 77
        with pytest.raises(ValueError, match=r"index must be within 0\.\.127"):
            envs.lanes[0].set_ram(128, 0)

    def test_modes_and_difficulties(self) -> None:
        envs = begun("breakout", 2, seed=3)
        envs.set_attr("mode", [0, 20])
        envs.set_attr("difficulty", 1)
        assert envs.get_attr("mode") == (0, 20)
        assert envs.get_attr("difficulty") == (1, 1)
        assert np.array_equal(envs.reset(seed=3)[0], make("breakout", 2, mode=[0, 20], difficulty=1).reset(seed=3)[0])
        with pytest.raises(ValueError, match="breakout has no mode 7"):
            envs.set_attr("mode", [20, 7])
        assert envs.get_attr("mode") == (0, 20)
        with pytest.raises(AttributeError, match=r"'lives' cannot"):
            envs.set_attr("lives", 3)
        with pytest.raises(ValueError, match="a value for each of the 2 environments"):
            envs.set_attr("mode", [0])
        with pytest.raises(TypeError, match="mode must be an integer"):
            envs.set_attr("mode", "0")
        copied = pickle.loads(pickle.dumps(envs))
        assert copied.get_attr("mode") == (0, 20)
        assert np.array_equal(copied.reset()[0], envs.reset()[0])

    def test_render(self) -> None:
        envs = begun(["pong", "pacman", "breakout"], None, render_mode="rgb_array", seed=0)
        screens = envs.render()
        assert screens is not None
        assert [screen.shape for screen in screens] == [(210, 160, 3), (250, 160, 3), (210, 160, 3)]
        mosaic = envs.mosaic()
        assert mosaic.shape == (500, 320, 3)
        assert np.array_equal(mosaic[:210, :160], screens[0])
        assert np.array_equal(mosaic[:250, 160:], screens[1])
        assert np.array_equal(mosaic[250:460, :160], screens[2])
        assert not mosaic[250:, 160:].any()
        assert make().render() is None


@OF_OPTIONS
def test_a_core_takes_over_from_a_lane(options: dict[str, Any]) -> None:
    envs = begun("seaquest", 2, seed=4, **options)
    play(envs, 10, seed=1)
    lane = envs.lanes[1]
    chances = envs.task
    core = atari.cores.NativeCore(
        "seaquest",
        repeat_action_probability=chances.repeat_action_probability,
        max_num_frames_per_episode=chances.max_num_frames_per_episode or 0,
        sound=True,
    )
    for _ in range(20):
        lane.copy_to(core)
        before = lane.episode_frame_number
        assert (core.frame_number, core.episode_frame_number) == (lane.frame_number, before)
        assert np.array_equal(core.ram(), lane.ram())
        assert np.array_equal(core.screen_rgb(), lane.screen_rgb())
        _, _, terminations, truncations, _ = envs.step(np.full(2, 4))
        if (terminations | truncations)[1] or lane.episode_frame_number < before:
            continue
        while core.frame_number < lane.frame_number:
            core.act(int(envs._options.actions[1][4]))
        assert np.array_equal(core.ram(), lane.ram())


def test_a_core_of_another_game_is_refused() -> None:
    envs = begun("seaquest", 2, seed=4)
    core = atari.cores.NativeCore("pong")
    with pytest.raises(ValueError, match="this environment plays seaquest, but the core pong"):
        envs.lanes[0].copy_to(core)


def ready(**options: Any) -> atari.AtariVectorEnv:
    """Batches of two of five environments, of which the others are played or wait to be received."""
    envs = begun("breakout", 5, batch_size=2, render_mode="rgb_array", seed=1, **options)
    for _ in range(7):
        envs.step(np.ones(2, int))
    return envs


@pytest.mark.parametrize("threads", [1, 3])
def test_batches_of_fewer_can_be_read_and_changed_between_receive_and_send(threads: int) -> None:
    envs = ready(num_threads=threads)
    screens = envs.render()
    assert screens is not None
    for lane, screen in zip(envs.lanes, screens, strict=True):
        assert np.array_equal(lane.screen_rgb(), screen)
        assert lane.lives == 5
    envs.set_attr("mode", 4)
    assert envs.get_attr("mode") == (4,) * 5
    copied = pickle.loads(pickle.dumps(envs))
    assert copied.get_attr("frame_number") == envs.get_attr("frame_number")
    assert all(np.array_equal(*pair) for pair in zip(copied.render(), screens, strict=True))
    assert copy.deepcopy(envs).get_attr("frame_number") == envs.get_attr("frame_number")
    copied.reset()
    seen = {int(index) for _ in range(6) for index in envs.step(np.ones(2, int))[4]["env_id"]}
    assert seen == set(range(5))


@pytest.mark.parametrize("threads", [1, 3])
def test_a_result_that_was_not_received_becomes_that_of_the_restored_state(threads: int) -> None:
    envs = ready(num_threads=threads)
    received = envs.step(np.ones(2, int))[4]["env_id"]
    source = int(received[0])
    expected = envs.lanes[source].frame_number
    envs.fork(source, range(5))
    for _ in range(2):  # of all others: each is received before those that are played now
        _, rewards, _, _, info = envs.step(np.ones(2, int))
        others = ~np.isin(info["env_id"], received)
        assert set(info["frame_number"][others]) <= {expected}
        assert not rewards[others].any()


@pytest.mark.parametrize("name", ["render", "snapshot", "__getstate__", "lanes"])
def test_between_send_and_receive_the_error_says_what_to_do(name: str) -> None:
    envs = ready()
    envs.send(np.ones(2, int))
    with pytest.raises(RuntimeError, match=r"environments are being played; call recv\(\)"):
        envs.call("ram") if name == "lanes" else getattr(envs, name)()
    envs.recv()
    envs.call("ram") if name == "lanes" else getattr(envs, name)()


def test_a_lane_has_the_methods_of_ale_pys_interface_for_reading() -> None:
    envs = begun(num_envs=2, seed=0)
    lane = envs.lanes[1]
    ale = lane.ale
    assert (ale.lives(), ale.getFrameNumber(), ale.getRAMSize()) == (5, lane.frame_number, 128)
    ale.setRAM(5, 77)
    assert ale.getRAM()[5] == ale.getRAM(np.empty(128, np.uint8))[5] == 77
    assert np.array_equal(ale.getScreenRGB(), lane.screen_rgb())
    assert ale.getScreenRGB().shape == (*ale.getScreenDims(), 3)
    with pytest.raises(AttributeError, match="act"):
        ale.act(0)
    for out in (np.empty(3, np.uint8), np.empty(128, np.int8), [0] * 128):
        with pytest.raises(ValueError, match=r"it must be a uint8 array of shape \(128,\)"):
            ale.getRAM(out)


@pytest.mark.parametrize("mode", ["NextStep", "SameStep", "Disabled"])
def test_a_lane_has_ended_until_a_reset(mode: str) -> None:
    envs = atari.AtariVectorEnv("breakout", 1, autoreset_mode=mode, max_num_frames_per_episode=20, noop_max=1)
    envs.reset(seed=0)
    ended = []
    for step in range(8):
        if step == 7:
            envs.reset()
        envs.step(np.zeros(1, int))
        ended.append(envs.lanes[0].ended)
    after = {"NextStep": [True, False], "SameStep": [False, False], "Disabled": [True, True]}
    assert ended == [False] * 4 + [*after[mode], mode == "Disabled", False]


def test_a_lost_life_that_is_only_reported_ends_no_episode_of_a_lane() -> None:
    envs = atari.AtariVectorEnv("breakout", 1, life_loss_info=True)
    envs.reset(seed=0)
    while not (result := envs.step(np.ones(1, int)))[2][0]:
        pass
    assert result[4]["lives"][0] == 4
    assert not envs.lanes[0].ended


@pytest.mark.parametrize("lane", [-1, 2, 2**40, 2**70])
def test_a_lane_that_does_not_exist(lane: int) -> None:
    envs = atari.AtariVectorEnv("pong", 2)
    envs.reset(seed=0)
    saved = envs.snapshot([0])
    for call in (
        lambda: envs.snapshot([lane]),
        lambda: envs.restore([lane], saved),
        lambda: envs.fork(0, [lane]),
        lambda: envs.fork(lane, [1]),
    ):
        with pytest.raises(IndexError, match=rf"^there is no environment {lane}; choose within 0\.\.1$"):
            call()

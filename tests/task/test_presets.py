"""What the presets say, written down a second time: a changed value changes scores."""

import inspect

from atari.task import PRESETS

IMAGES = {"frameskip": 4, "obs_type": "grayscale", "img_height": 84, "img_width": 84, "stack_num": 4, "maxpool": True}

DIFFERENT = """
            sticky actions  limit   after   noops   fire          counts  third  unit   lives  unit   on_reset  last   seamless  rgb    padding  end        clip   seeding
dqn2015     0.0    minimal  108000  -       (1,30)  -             -       -      -      True   -      continue  True   -         True   zero     last       True   -
machado2018 0.25   full     108000  -       -       -             -       -      -      False  -      continue  True   -         -      zero     last       False  -
baselines   0.0    -        108000  -       (1,30)  after_noops   -       True   skip   True   skip   noop      -      -         True   zero     baselines  True   -
gymnasium   -      -        -       -       (1,30)  -             -       -      -      False  -      new_game  True   -         -      reset    gymnasium  False  -
dopamine    0.25   minimal  108000  -       -       -             -       -      -      False  -      continue  True   -         -      zero     baselines  True   -
atari100k   0.0    minimal  108000  -       -       -             -       -      -      True   -      continue  True   -         -      zero     last       True   -
envpool     0.0    -        None    108000  (1,30)  after_noops   True    -      -      False  -      continue  -      True      -      reset    envpool    False  -
ale_vector  0.0    -        None    108000  (0,29)  before_noops  True    -      -      False  -      new_game  -      -         -      zero     gymnasium  True   -
multiplayer_dqn 0.0 -    None    108000  -       -             -       -      -      False  -      continue  True   -         -      reset    last       False     ale
"""

COLUMNS = (
    "repeat_action_probability actions max_num_frames_per_episode max_frames noops fire fire_counts third_action "
    "fire_unit episodic_life lives_unit on_reset last_life seamless_lives pool_rgb padding end_frames reward_clipping seeding"
).split()


def test_the_presets_are_those_of_the_table() -> None:
    rows = [line.split() for line in inspect.cleandoc(DIFFERENT).splitlines()[1:]]
    assert [name for name, *_ in rows] == list(PRESETS)
    for name, *values in rows:
        said = {field: value for field, value in zip(COLUMNS, values, strict=True) if value != "-"}
        fields = {field: value for field, value in PRESETS[name].fields.items() if field not in IMAGES}
        assert {field: str(value).replace(" ", "") for field, value in fields.items()} == said, name
        assert {field: PRESETS[name].fields[field] for field in IMAGES} == IMAGES


def test_what_publications_require() -> None:
    required = {name for name, preset in PRESETS.items() if preset.required}
    assert required == {"dqn2015", "machado2018", "dopamine", "atari100k"}
    assert {PRESETS[name].required for name in required} == {("repeat_action_probability", "actions")}

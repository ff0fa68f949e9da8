"""What `import atari` does and does not do: each test runs a new interpreter."""

import subprocess
import sys
from pathlib import Path

import pytest

import atari
from atari.base.extras import pip_install


def run(program: str, folder: Path, *options: str) -> str:
    """The output of a program. Anything on standard error fails; with `-W error`, any warning does."""
    command = [sys.executable, *options, "-c", program]
    result = subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False)
    assert (result.returncode, result.stderr) == (0, "")
    return result.stdout


@pytest.mark.parametrize("imports", ["import atari", "import gymnasium, ale_py; import atari, ale_py"])
def test_importing_prints_and_warns_nothing(imports: str, tmp_path: Path) -> None:
    assert run(imports, tmp_path, "-W", "error") == ""


@pytest.mark.parametrize("imports", ["import ale_py, atari", "import atari, ale_py"])
def test_in_either_order_the_ids_are_ours(imports: str, tmp_path: Path) -> None:
    program = (
        f"{imports}\nimport gymnasium\ngymnasium.register_envs(ale_py)\n"
        "ids = ('ALE/Breakout-v5', 'Breakout-v4', 'BreakoutNoFrameskip-v4')\n"
        "print(*{type(gymnasium.make(env_id).unwrapped).__module__ for env_id in ids})"
    )
    assert run(program, tmp_path, "-W", "error") == "atari.env.env\n"


def test_heavy_packages_stay_out(tmp_path: Path) -> None:
    """`import atari` imports none, and playing a game alone, preprocessed or in a vector neither."""
    program = f"""
import sys, gymnasium
before = set(sys.modules)
def heavy():
    return {HEAVY} & set(sys.modules) - before
import atari
print(heavy() | {UNUSED} & set(sys.modules) - before)
for env in (atari.make("pong"), atari.make("pong", preset="baselines"), atari.make("pong", obs_type="ram")):
    env.reset(seed=0)
    env.step(2)
vector = atari.AtariVectorEnv("pong", 2, preset="dqn2015")
vector.reset(seed=0)
vector.step([0, 2])
print(heavy())
"""
    assert run(program, tmp_path) == "set()\nset()\n"


HEAVY = {"cv2", "ale_py", "av", "pygame", "torch", "matplotlib", "AutoROM", "tqdm", "PIL"}
UNUSED = {"tarfile", "zipfile", "platformdirs", "email"}
"""What a game needs, or the import of its files, and `import atari` not."""


def test_everything_that_plays_works_without_opencv_and_ale_py(tmp_path: Path) -> None:
    """The ROM is in a folder of its own, as without ale-py's wheel."""
    (tmp_path / "pong.bin").write_bytes(atari.roms.find("pong").read_bytes())
    program = f"""
import os, sys
sys.modules["cv2"] = sys.modules["ale_py"] = sys.modules["PIL"] = None
os.environ["ATARI_ROMS"] = os.environ["XDG_DATA_HOME"] = {str(tmp_path)!r}
import gymnasium, atari
print(atari.roms.find("pong"), [path for path in atari.roms.locations.folders() if "ale_py" in str(path)])
for preset in atari.PRESETS:
    env = atari.make("pong", preset=preset)
    env.reset(seed=0)
    env.step(0)
for screen in (None, (300, 100)):
    env = atari.wrappers.DqnPreprocessing(atari.AtariEnv("pong", frameskip=1), screen_size=screen)
    env.reset(seed=0)
resized = atari.wrappers.Resize(atari.wrappers.Grayscale(gymnasium.make("ALE/Pong-v5")))
print(resized.reset(seed=0)[0].shape)
vector = atari.AtariVectorEnv("pong", 2)
print(vector.reset(seed=0)[0].shape)
replay = atari.recording.RecordReplay(atari.make("pong"), "a.a26r")
replay.reset(seed=0)
for _ in range(20):
    replay.step(0)
replay.close()
atari.recording.Replay.load("a.a26r").render("a.png", overlay=("score", "ram", "curve"))
from atari.lab.causal.picture import write_png
write_png(atari.lab.shipped_causes("pong"), "causes.png", atari.games["pong"])
try:
    atari.AtariEnv("pong", core="ale")
except gymnasium.error.DependencyNotInstalled as error:
    print(error)
try:
    atari.make("breakout")
except FileNotFoundError as error:
    print(error)
"""
    found, *shapes, missing_core, missing_rom = run(program, tmp_path).splitlines()
    assert found == f"{tmp_path / 'pong.bin'} []"
    assert shapes == ["(84, 84)", "(2, 4, 84, 84)"]
    assert missing_core == f"core='ale' is ale-py's emulator: {pip_install('ale-py')}; core='native' needs no ale-py"
    assert missing_rom.startswith("no ROM file of Breakout (MD5 ")
    assert missing_rom.endswith("; the files that come with ale-py are missing: " + pip_install("ale-py"))


ANEW = """
import sys
for imports in {imports!r}:
    for name in [name for name in sys.modules if name.partition(".")[0] == "atari"]:
        del sys.modules[name]
    exec(imports)
    {check}
"""
"""Runs several imports, each as if it were the first of the package."""


def test_games_stays_the_mapping_however_it_is_imported(tmp_path: Path) -> None:
    imports = [
        "import atari; games = atari.games",
        "import atari.games; games = atari.games",
        "from atari import games",
        "import atari; import atari.games as games",
        "import importlib; games = importlib.import_module('atari.games')",
        "from atari.games.rules import check_expression; import atari.games as games",
        "import atari.games.data; import atari; games = atari.games",
        "import copy, atari; games = copy.deepcopy(atari.games)",
        "import pickle, atari; games = pickle.loads(pickle.dumps(atari.games))",
    ]
    check = (
        "from collections.abc import Mapping; print(isinstance(games, Mapping), games['pong'].title, len(games), games)"
    )
    printed = run(ANEW.format(imports=imports, check=check), tmp_path).splitlines()
    assert printed == ["True Pong 108 <108 games: adventure ... zaxxon>"] * len(imports)


def test_games_is_a_package_too(tmp_path: Path) -> None:
    imports = [
        "from atari.games.rules import parse_rules",
        "from atari.games import rules; parse_rules = rules.parse_rules",
        "import atari.games.rules as rules; parse_rules = rules.parse_rules",
        "import atari, atari.games.rules; parse_rules = atari.games.rules.parse_rules",
    ]
    program = ANEW.format(imports=imports, check="print(parse_rules.__module__)")
    assert run(program, tmp_path) == "atari.games.rules\n" * len(imports)


def test_the_names_of_a_new_import(tmp_path: Path) -> None:
    """No definition is read yet: to parse all of them would double the time of `import atari`."""
    program = """
import sys, atari
names = "classic integrations lab learning multiplayer recording roms wrappers".split()
print([name for name in ("lab", "learning", "recording", "wrappers") if f"atari.{name}" in sys.modules])
from atari.games import catalog
print(catalog._load.cache_info().currsize)
print([name for name in atari.__all__ if not hasattr(atari, name)])
print([name for name in names if getattr(atari, name).__name__ != f"atari.{name}"])
print(atari.recording.Replay.__name__, atari.lab.Ram.__name__, atari.learning.evaluate.__name__)
import atari.lab, atari.play
print(set(dir(atari)) ^ {*atari.__all__, "__version__"})
try:
    atari.rom
except AttributeError as error:
    print(error)
"""
    expected = ["[]", "0", "[]", "[]", "Replay Ram evaluate", "set()", "module 'atari' has no attribute 'rom'"]
    assert run(program, tmp_path).splitlines() == expected


def test_making_and_playing_by_the_module_prefix_prints_nothing(tmp_path: Path) -> None:
    program = (
        "import gymnasium\nenv = gymnasium.make('atari:Pong-ram-v4')\nassert env.reset(seed=0)[0].shape == (128,)\n"
        "env = gymnasium.make('ALE/Breakout-v5')\nenv.reset(seed=0)\n"
        "for _ in range(50): env.step(env.action_space.sample())\nenv.close()"
    )
    assert run(program, tmp_path, "-W", "error") == ""


def test_a_second_import_after_the_first_was_deleted(tmp_path: Path) -> None:
    """As test runners and notebooks do. Environments of both imports work."""
    program = (
        "import sys, atari\nold = atari.make('pong')\nold.reset(seed=0)\n"
        "for name in [name for name in sys.modules if name.partition('.')[0] == 'atari']: del sys.modules[name]\n"
        "import atari\nnew = atari.make('pong')\nnew.reset(seed=0)\nassert type(new.unwrapped) is not type(old.unwrapped)\n"
        "vector = atari.AtariVectorEnv('pong', 2)\nvector.reset(seed=0)\nvector.close()\n"
        "print(old.step(2)[1:] == new.step(2)[1:], atari.wrappers.__name__, atari.games['pong'].title)"
    )
    assert run(program, tmp_path, "-W", "error") == "True atari.wrappers Pong\n"


ROOT = Path(__file__).parents[1]


def test_the_root_of_the_repository_has_the_installed_package(monkeypatch: pytest.MonkeyPatch) -> None:
    """In the root of the repository, Python finds the sources in `atari/` first, which have no compiled module."""
    monkeypatch.delenv("PYTHONSAFEPATH", raising=False)
    program = (
        "import atari, atari.wrappers, atari.roms\nprint(atari.__file__, atari.wrappers.__file__, atari.env.__file__)\n"
        "print(atari.make('pong').reset(seed=0)[0].shape)"
    )
    modules, shape = run(program, ROOT).splitlines()
    package, wrappers, env = map(Path, modules.split())
    installed = Path(atari.__file__).parent
    assert package.parent in (ROOT / "atari", installed)  # an editable installation comes before the current folder
    assert (wrappers, env) == (Path(atari.wrappers.__file__), installed / "env" / "__init__.py")
    assert shape == "(210, 160, 3)"


def test_the_command_line_runs_in_the_root_of_the_repository(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv("PYTHONSAFEPATH", raising=False)
    command = [sys.executable, "-m", "atari", "info", "Pong-v4"]
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=False)
    assert (done.returncode, done.stderr) == (0, "")
    assert done.stdout.startswith("Pong-v4")


def test_sources_that_are_not_installed_say_what_to_do(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv("PYTHONSAFEPATH", raising=False)
    command = [sys.executable, "-S", "-c", "import atari"]
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=False)
    assert done.returncode == 1
    message = (
        f"{ROOT / 'atari'} is the source folder, and atari is not installed for {sys.executable}; "
        f"run `{sys.executable} -m pip install"
    )
    assert message in done.stderr


def test_an_unknown_name_is_an_attribute_error() -> None:
    assert not hasattr(atari, "Protocols")
    assert not hasattr(atari.wrappers, "preset_protocols")
    with pytest.raises(AttributeError, match="'AtariEnv' object has no attribute 'observer'"):
        getattr(atari.AtariEnv("pong"), "observer")  # noqa: B009

import warnings
from pathlib import Path

import pytest

import atari
from atari.base import namesake


def test_files_of_the_other_package_are_a_warning(tmp_path: Path) -> None:
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        namesake.check([str(tmp_path)])
        namesake.check(atari.__path__)
    (tmp_path / "visualize.py").touch()
    with pytest.warns(UserWarning, match=r"`pip uninstall atari atari-envs`, then `pip install atari-envs`"):
        namesake.check([str(tmp_path)])

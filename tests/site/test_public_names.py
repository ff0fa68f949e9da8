"""`docs/public-names.txt` has the public names of these sources, and the changelog has its digest (docs/stability.md)."""

from pathlib import Path

import site_modules

NAMES = site_modules.load("public_names", "generate")
HOW = "run `python scripts/generate/public_names.py`, and say in CHANGELOG.md what changed, with the digest it prints"


def test_the_file_has_the_names_of_these_sources() -> None:
    written, now = set(NAMES.FILE.read_text("utf-8").splitlines()), set(NAMES.text().splitlines())
    assert (sorted(now - written), sorted(written - now)) == ([], []), f"added, and gone: {HOW}"


def test_the_changelog_has_the_digest() -> None:
    text = NAMES.FILE.read_text("utf-8")
    changelog = (Path(NAMES.ROOT) / "CHANGELOG.md").read_text("utf-8")
    assert f"digest {NAMES.digest(text)}" in changelog, HOW


def test_inherited_members_parameters_and_options_are_among_them() -> None:
    lines = NAMES.FILE.read_text("utf-8").splitlines()
    assert "atari.AtariVectorEnv.fork(source, targets)" in lines  # of a base class
    assert "atari.wrappers.Resize(env, shape=(84, 84))" in lines
    assert "atari evaluate --protocol" in " ".join(lines)
    assert not [line for line in lines if "._" in line]

"""Workflows run with the least rights and fixed releases of actions and tools; the wheel says what is compiled into it."""

import importlib.metadata
import json
import re
from pathlib import Path

import pytest

TOP = Path(__file__).parent.parent
RELEASE = TOP / "scripts" / "release"
WORKFLOWS = sorted((TOP / ".github" / "workflows").glob("*.yml"))


def by_name(path: Path) -> str:
    return path.name


def requirements(file: Path) -> list[str]:
    """The requirements of a file, each with the lines that go on from it."""
    text = re.sub(r"^ *#.*\n", "", file.read_text(encoding="utf-8"), flags=re.MULTILINE)
    return text.replace("\\\n", " ").splitlines()


def test_there_are_workflows() -> None:
    assert {path.name for path in WORKFLOWS} == {"pull-request.yml", "release.yml"}


@pytest.mark.parametrize("workflow", WORKFLOWS, ids=by_name)
def test_a_workflow_can_only_read(workflow: Path) -> None:
    text = workflow.read_text(encoding="utf-8")
    assert re.search(r"^permissions: \{contents: read\}$", text, re.MULTILINE)
    # A workflow that publishes has the right to say so to the index, in one job, and no other.
    rights = re.findall(r"[\w-]+: write", text)
    assert rights == (["id-token: write"] if workflow.name == "release.yml" else [])
    assert text.count("actions/checkout@") == text.count("{persist-credentials: false}")
    assert "secrets." not in text


def test_every_action_is_a_commit() -> None:
    pinned = {}
    for workflow in WORKFLOWS:
        for line in re.findall(r"\buses:.*", workflow.read_text(encoding="utf-8")):
            found = re.fullmatch(r"uses: ([\w.-]+/[\w.-]+)@([0-9a-f]{40})  # (v\d+\.\d+\.\d+)", line)
            assert found, f"{workflow.name}: {line} has no commit with its release"
            assert pinned.setdefault(found[1], found[0]) == found[0]  # one release of an action everywhere
    assert len(pinned) >= 5


@pytest.mark.parametrize("workflow", WORKFLOWS, ids=by_name)
def test_workflows_install_tools_by_their_hashes(workflow: Path) -> None:
    for line in re.findall(r"pip install (.*)", workflow.read_text(encoding="utf-8")):
        assert re.match(r"--require-hashes -r scripts/release/\w+\.txt$|\. |dist/", line), line


@pytest.mark.parametrize("name", ["build", "tools"])
def test_requirements_have_hashes(name: str) -> None:
    lines = requirements(RELEASE / f"{name}.txt")
    for line in lines:
        assert re.match(r"[\w.-]+==\S+ .*--hash=sha256:[0-9a-f]{64}", line), line
    assert not re.search(r"https?:|--(?:extra-)?index|--find-links", "\n".join(lines))
    pinned = {line.partition("==")[0] for line in lines}
    assert {line for line in requirements(RELEASE / f"{name}.in") if line} <= pinned


def test_the_pinned_build_tools_are_those_of_the_project() -> None:
    project = (TOP / "pyproject.toml").read_text(encoding="utf-8")
    pinned = dict(re.match(r"([\w.-]+)==(\S+)", line).groups() for line in requirements(RELEASE / "build.txt"))  # type: ignore[union-attr]
    for package, oldest in re.findall(r'"(scikit-build-core|nanobind)>=([\d.]+)"', project.partition("[project]")[0]):
        assert [*map(int, pinned[package].split("."))] >= [*map(int, oldest.split("."))]
    assert "{project}/scripts/release/build.txt" in project


def check_bill(text: str, version: str) -> None:
    bill = json.loads(text)
    assert (bill["bomFormat"], bill["specVersion"]) == ("CycloneDX", "1.6")
    assert bill["metadata"]["component"]["version"] == version
    parts = {component["bom-ref"]: component for component in bill["components"]}
    assert set(parts) == {"nanobind", "robin-map", "emscripten"}
    assert parts["nanobind"]["purl"] == f"pkg:pypi/nanobind@{parts['nanobind']['version']}"
    assert {entry["ref"] for entry in bill["dependencies"]} == {"atari-envs", *parts}


def test_the_bill_of_materials() -> None:
    template = (RELEASE / "sbom.cdx.json.in").read_text(encoding="utf-8")
    check_bill(re.sub(r"@(\w+)@", lambda found: "1.2" if found[1] else "", template), "1.2")
    cmake = (TOP / "CMakeLists.txt").read_text(encoding="utf-8")
    assert "configure_file(scripts/release/sbom.cdx.json.in" in cmake
    licences = (TOP / "LICENSE-THIRD-PARTY").read_text(encoding="utf-8").lower()
    assert all(name in licences for name in ("nanobind,", "robin-map,", "emscripten,"))


def test_the_installed_wheel_has_its_bill_of_materials() -> None:
    package = importlib.metadata.distribution("atari-envs")
    if json.loads(package.read_text("direct_url.json") or "{}").get("dir_info", {}).get("editable"):
        pytest.skip("an editable installation has none")
    text = package.read_text("sboms/atari-envs.cdx.json")
    assert text is not None
    check_bill(text, package.version)

# Sourced by quickstart and test: finds Python, makes the virtual environment, builds the wheel and installs it.
# Variables: VENV (folder of the environment), EXTRAS (extras to install, for example "video" or "dev"), PYTHONS (commands
# to try, best first), INSTALL (options of pip for the dependencies), TARGETS (what CMake builds beside the wheel, of the
# same objects). It sets BUILD, the folder that CMake builds in.

say() { printf '\n==> %s\n' "$*"; }
fail() { printf '\n!!! %s\n' "$*" >&2; exit 1; }

find_python() {
  for candidate in "${PYTHON:-}" ${PYTHONS:-python3 python3.14 python3.13 python3.12 python3.11 python3.10}; do
    [ -n "$candidate" ] && command -v "$candidate" >/dev/null 2>&1 || continue
    "$candidate" -c 'import sys; sys.exit(sys.version_info < (3, 10))' 2>/dev/null || continue
    echo "$candidate"
    return
  done
  return 1
}

check_compiler() {
  for compiler in "${CXX:-}" c++ g++ clang++; do
    [ -n "$compiler" ] && command -v "$compiler" >/dev/null 2>&1 || continue
    echo 'int main() {}' | "$compiler" -std=c++20 -x c++ -fsyntax-only - 2>/dev/null && return
  done
  fail "A C++20 compiler is missing; install one (tried: GCC 12, Clang 14; Debian: apt install g++)."
}

# Shows the lines of progress, "[12/40] Building atari/emulator/...", so that they fit in 80 columns. The module is linked when
# two steps are left; the compiler then optimises all files at once, and prints nothing until it is done.
show_progress() {
  local line
  while IFS= read -r line; do
    case $line in *" Building CXX object "*) line="${line%% CXX object *} ${line##*.dir/}"; line=${line/__\/__\/__\//} ;; esac
    line=${line%.o}
    echo "${line%.cpython-*}"
    if [[ $line =~ \[\ *([0-9]+)/([0-9]+)\] ]] && [ $((BASH_REMATCH[2] - BASH_REMATCH[1])) = 2 ]; then
      echo "  Linking, with optimisation over all files: about a minute without a line"
    fi
  done
}

# Writes pip's output to build/wheel.log, and shows its lines of progress.
build_wheel() {
  rm -rf build/dist
  BUILD=build/wheel/$("$VENV/bin/python" -c 'import sys; print("cp%d%d" % sys.version_info[:2])')
  mkdir -p "$BUILD"
  SKBUILD_BUILD_DIR=$BUILD SKBUILD_BUILD_TARGETS="all${TARGETS:+;$TARGETS}" \
    "$VENV/bin/python" -m pip wheel --verbose --no-deps --wheel-dir build/dist . 2>&1 | tee build/wheel.log |
    { grep --line-buffered -oE '^ *\[ *[0-9]+(%|/[0-9]+)\].*|Installing build dependencies: started' || true; } |
    show_progress
}

make_venv() {
  local python
  python=$(find_python) || fail "Python 3.10 or newer is missing; install python3 (Debian: apt install python3)."
  [ ! -x "$VENV/bin/python" ] || return 0
  say "Making the virtual environment $VENV with $($python --version)"
  "$python" -m venv "$VENV" ||
    fail "$python cannot make virtual environments; install venv (Debian: apt install python3-venv)."
}

set_up() {
  check_compiler
  make_venv
  say "Building the wheel (first time: one to five minutes; the whole output is in build/wheel.log)"
  build_wheel || { tail -n 40 build/wheel.log >&2
    fail "The wheel could not be built; the lines above say why. It needs network access to PyPI or a mirror."; }
  say "Installing it with its dependencies (first time: a minute or two)"
  local wheel
  wheel=$(echo build/dist/*.whl)
  "$VENV/bin/python" -m pip install --quiet --progress-bar off ${INSTALL:-} "$wheel[$EXTRAS]" &&
    "$VENV/bin/python" -m pip install --quiet --force-reinstall --no-deps "$wheel" ||
    fail "The installation failed; the lines above say why. It needs network access to PyPI or a mirror."
  case "${TARGETS:-}" in
    *inspection*) cp "$BUILD"/tests/emulator/inspection/atari_inspection.*so "$(site_packages)" ;;
  esac
}

site_packages() { "$VENV/bin/python" -c 'import sysconfig; print(sysconfig.get_path("platlib"))'; }

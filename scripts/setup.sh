# Sourced by quickstart and test: finds Python, makes the virtual environment, builds the wheel and installs it.
# Variables: VENV (folder of the environment), EXTRAS (extras to install, for example "video" or "dev").

say() { printf '\n==> %s\n' "$*"; }
fail() { printf '\n!!! %s\n' "$*" >&2; exit 1; }

find_python() {
  for candidate in "${PYTHON:-}" python3 python3.14 python3.13 python3.12 python3.11 python3.10; do
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

set_up() {
  check_compiler
  local python
  python=$(find_python) || fail "Python 3.10 or newer is missing; install python3 (Debian: apt install python3)."
  if [ ! -x "$VENV/bin/python" ]; then
    say "Making the virtual environment $VENV with $($python --version)"
    "$python" -m venv "$VENV" ||
      fail "$python cannot make virtual environments; install venv (Debian: apt install python3-venv)."
  fi
  say "Building the wheel"
  rm -rf build/dist
  "$VENV/bin/python" -m pip wheel --quiet --no-deps --wheel-dir build/dist . ||
    fail "The wheel could not be built; the lines above say why. It needs network access to PyPI or a mirror."
  say "Installing it with its dependencies (first time: a minute or two)"
  local wheel
  wheel=$(echo build/dist/*.whl)
  "$VENV/bin/python" -m pip install --quiet --progress-bar off "$wheel[$EXTRAS]" &&
    "$VENV/bin/python" -m pip install --quiet --force-reinstall --no-deps "$wheel" ||
    fail "The installation failed; the lines above say why. It needs network access to PyPI or a mirror."
}

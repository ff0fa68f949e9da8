# Sourced by the scripts: finds Python, makes the virtual environment, and has quickstart.py build the wheel and install it.
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

# Sets PYTHON_FOUND.
need_python() {
  PYTHON_FOUND=$(find_python) || fail "Python 3.10 or newer is missing; install python3 (Debian: apt install python3)."
}

make_venv() {
  need_python
  quickstart 'make_venv(quickstart.Path(sys.argv[1]))' "$VENV"
}

# Runs a statement of Python in which quickstart.py is imported; what follows it is sys.argv[1:].
quickstart() {
  "$PYTHON_FOUND" -c "import sys; sys.path.insert(0, 'scripts'); import quickstart; quickstart.$1" "${@:2}"
}

check_compiler() { need_python && quickstart 'check_compiler()'; }

set_up() {
  need_python
  quickstart 'set_up(quickstart.Path(sys.argv[1]), *sys.argv[2:])' "$VENV" "$EXTRAS" "${TARGETS:-}" "${INSTALL:-}"
  BUILD=build/wheel/$("$VENV/bin/python" -c 'import sys; print("cp%d%d" % sys.version_info[:2])')
  case "${TARGETS:-}" in
    *inspection*) cp "$BUILD"/tests/emulator/inspection/atari_inspection.*so "$(site_packages)" ;;
  esac
}

site_packages() { "$VENV/bin/python" -c 'import sysconfig; print(sysconfig.get_path("platlib"))'; }

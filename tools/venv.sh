# Sourced by run.sh and test.sh: makes the checkout's virtual environment, once.
#   prepare_venv STAMP REQUIREMENTS...   then "$python" is its interpreter
# Nothing is done while the stamp names the same requirements: a second start runs no pip.

find_python() {
    found_without_venv=
    for candidate in ${PYTHON:-} python3 python3.13 python3.12 python3.11 python3.10; do
        "$candidate" -c 'import sys; sys.exit(not (3, 10) <= sys.version_info[:2] <= (3, 13))' \
            2>/dev/null || continue
        if "$candidate" -c 'import ensurepip, venv' 2>/dev/null; then
            echo "$candidate"
            return 0
        fi
        found_without_venv=$("$candidate" -c 'import sys; print("python3.%d" % sys.version_info[1])')
    done
    if [ -n "$found_without_venv" ]; then
        echo "bristle_ros: $found_without_venv has no venv: apt install python3-venv" \
            "(or $found_without_venv-venv)" >&2
    else
        echo "bristle_ros: needs Python 3.10 to 3.13: apt install python3 python3-venv" \
            "(or set PYTHON to one)" >&2
    fi
    return 1
}

install() {
    # Twice quiet: errors, but not what old versions of pip say about old ways of packaging.
    (cd "$here" && "$python" -m pip install --quiet --quiet --disable-pip-version-check "$@") || {
        echo "bristle_ros: pip could not install $*: is a package index reachable?" >&2
        exit 2
    }
}

prepare_venv() {
    stamp=$here/.venv/$1
    shift
    # A ROS installation or another environment that is active must not mix with the wheels here.
    if [ -n "${AMENT_PREFIX_PATH:-}${_ROS_WHEELS_BOOTSTRAP_COMPLETE:-}" ]; then
        unset LD_LIBRARY_PATH AMENT_PREFIX_PATH _ROS_WHEELS_BOOTSTRAP_COMPLETE
    fi
    unset PYTHONPATH PYTHONHOME
    python=$here/.venv/bin/python
    wanted=$(cat "$@" | cksum)
    # The interpreter is part of the stamp: a system upgrade may put another one behind the link.
    if [ "$(cat "$stamp" 2>/dev/null)" != "$wanted $(readlink -f "$python")" ]; then
        base=$(find_python) || exit 2
        echo "bristle_ros: setting up $here/.venv with $base: downloads some packages," \
            "once; a minute or more" >&2
        began=$(date +%s)
        "$python" -c 'import pip' 2>/dev/null || rm -rf "$here/.venv"
        [ -d "$here/.venv" ] || "$base" -m venv "$here/.venv" || exit 2
        : > "$here/.venv/COLCON_IGNORE"
        options=
        for file in "$@"; do
            options="$options --requirement $file"
        done
        # The default scene compiles (most of a minute of one core, once) while pip fetches ROS;
        # bench steps it as the node does, without the energy accounts that simulate keeps.
        grep -v '^ros-' "$here/requirements.txt" > "$here/.venv/without-ros.txt"
        install --requirement "$here/.venv/without-ros.txt"
        (cd "$here" && "$python" -m bristle_ros bench config/cutting_brush.yaml \
            --duration 0.005 --repeats 1 > /dev/null 2>&1) &
        # Names of requirement files hold no spaces, and are relative to the checkout.
        install $options
        wait
        echo "$wanted $(readlink -f "$python")" > "$stamp"
        echo "bristle_ros: installed and compiled in $(($(date +%s) - began)) s" >&2
    fi
    # What the wheels do not set: where messages lie, and the one middleware there is a wheel of.
    export AMENT_PREFIX_PATH="$here/.venv" RMW_IMPLEMENTATION=rmw_fastrtps_cpp
}

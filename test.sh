#!/bin/sh
# Runs the tests; sets up .venv in this checkout first, where that is missing. A skipped test fails.
#   ./test.sh [pytest arguments]
here=$(cd "$(dirname "$0")" && pwd)
. "$here/tools/venv.sh"
cd "$here" || exit 2
prepare_venv stamp-test requirements.txt requirements-view.txt requirements-test.txt
echo "bristle_ros: running the tests, some minutes; the first time compiles as well" >&2
exec "$python" -m pytest --fail-on-skip "$@"

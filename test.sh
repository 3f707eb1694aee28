#!/bin/sh
# Runs the tests; sets up .venv in this checkout first, where that is missing. A skipped test fails.
#   ./test.sh [--all] [pytest arguments]      --all: those too that need the extra [study], which
#                                             takes 600 MB
here=$(cd "$(dirname "$0")" && pwd)
. "$here/tools/venv.sh"
cd "$here" || exit 2
if [ "${1:-}" = --all ]; then
    shift
    prepare_venv stamp-test-all requirements.txt requirements-view.txt requirements-test.txt \
        requirements-study.txt
else
    prepare_venv stamp-test requirements.txt requirements-view.txt requirements-test.txt
fi
echo "bristle_ros: running the tests, some minutes; the first time compiles as well" >&2
# two processes; -n 0 for one, as a debugger wants it
exec "$python" -m pytest --fail-on-skip -n 2 --dist loadgroup --no-loadscope-reorder "$@"

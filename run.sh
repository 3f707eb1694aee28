#!/bin/sh
# Starts the node on the default scene; sets up .venv in this checkout first, where that is missing.
#   ./run.sh [ROS arguments]      for example: ./run.sh -p run.real_time_factor:=0.5
here=$(cd "$(dirname "$0")" && pwd)
. "$here/tools/venv.sh"
cd_back=$PWD
cd "$here" || exit 2
prepare_venv stamp-run requirements.txt
cd "$cd_back" || exit 2
export PYTHONPATH="$here"
case "${1:-}" in
    -h | --help) exec "$python" -m bristle_ros brush_node --help ;;
esac
# exec: the node gets the signals, not a shell.
exec "$python" -m bristle_ros brush_node --ros-args \
    --params-file "$here/config/cutting_brush.yaml" "$@"

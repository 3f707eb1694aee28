#!/bin/sh
# Starts the node on the default scene, or any verb or script, in an environment of this checkout,
# which is set up first where it is missing.
here=$(cd "$(dirname "$0")" && pwd)
case "${1:-}" in
    -h | --help)
        verbs=$(sed -n "/^VERBS = {/,/^}/s/^    '\([a-z_]*\)'.*/\1/p" "$here/bristle_ros/__main__.py")
        cat <<HELP
usage: ./run.sh [ROS arguments]   the node on config/cutting_brush.yaml, for example
                                  ./run.sh -p log.path:=run1 -p run.real_time_factor:=0.5
       ./run.sh VERB ...          a verb; ./run.sh VERB --help tells its arguments:
                                  $(echo $verbs)
       ./run.sh FILE.py ...       a Python script that may use rclpy and bristle_ros
HELP
        exit 0
        ;;
esac
. "$here/tools/venv.sh"
cd_back=$PWD
cd "$here" || exit 2
case "${1:-}" in
    study | fit | compare) prepare_venv stamp-study requirements.txt requirements-study.txt ;;
    *) prepare_venv stamp-run requirements.txt ;;
esac
cd "$cd_back" || exit 2
export PYTHONPATH="$here"
# exec: what runs gets the signals, not a shell.
case "${1:-}" in
    *.py) exec "$python" "$@" ;;
    '' | -*)
        echo "bristle_ros: starting config/cutting_brush.yaml; Ctrl-C ends it" >&2
        exec "$python" -m bristle_ros brush_node --ros-args \
            --params-file "$here/config/cutting_brush.yaml" "$@"
        ;;
    *) exec "$python" -m bristle_ros "$@" ;;
esac

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
       ./run.sh report --peers   the report beside exudyn and MuJoCo, which it installs first
       ./run.sh FILE.py ...       a Python script that may use rclpy and bristle_ros
HELP
        exit 0
        ;;
esac
. "$here/tools/venv.sh"
cd_back=$PWD
cd "$here" || exit 2
peers=
if [ "${1:-}" = report ]; then
    for word in "$@"; do
        [ "$word" != --peers ] || peers=yes
        # What measures nothing needs no other program.
        [ "$word" != --help ] && [ "$word" != -h ] || peers=no
    done
    if [ -z "$peers" ] && [ -t 0 ] && [ -t 2 ] && [ ! -f "$here/.venv/stamp-report" ]; then
        printf 'bristle_ros: set up exudyn and MuJoCo (100 MB) to compare with? [y/N] ' >&2
        read -r answer
        case "$answer" in [yY]*) peers=yes ;; esac
    fi
fi
if [ "$peers" = yes ]; then
    prepare_venv stamp-report requirements.txt requirements-report.txt
elif [ "${1:-}" = view ]; then
    prepare_venv stamp-view requirements.txt requirements-view.txt
else
    case "${1:-}" in
        study | fit | compare) prepare_venv stamp-study requirements.txt requirements-study.txt ;;
        *) prepare_venv stamp-run requirements.txt ;;
    esac
fi
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

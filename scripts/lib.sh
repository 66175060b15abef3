# Functions and settings of the scripts. To be sourced, not run.
# shellcheck shell=bash

# With a user's CDPATH, `cd` would go elsewhere, and print where: here, and in the setup.sh files of catkin.
unset CDPATH

# The workspace: the folder that holds src/.
root=$(cd -P -- "$(dirname -- "${BASH_SOURCE[0]}")/.." && pwd)

# ROS's Python packages belong to Debian's own interpreter. A `python3` of pyenv or conda that comes
# earlier on PATH has no rospy, and would break the build, roslaunch and every node that starts with
# `#!/usr/bin/env python3`. So the interpreter is named in full, and /usr/bin comes first.
# shellcheck disable=SC2034
python=/usr/bin/python3
export PATH="/usr/bin:$PATH"

# The script that has called this one, if any.
# shellcheck disable=SC2034
called_by=${FLATLAND_SCRIPT-}
export FLATLAND_SCRIPT=${0##*/}

# Output of nodes is not buffered, through a pipe as on a terminal.
export PYTHONUNBUFFERED=1

# Ctrl-C ends the script, also if the program that is running ignores it.
trap 'exit 130' INT

say() { printf '%s: %s\n' "${0##*/}" "$*" >&2; }

die() {
  say "$@"
  exit 1
}

# Print the comment block at the top of the running script.
show_help() { awk 'NR > 1 { if (!/^#/) exit; sub(/^# ?/, ""); print }' "$0"; }

# Compile with ccache, once it is installed: sources that this or another clone has compiled before take
# no time. The settings ignore in which folder a clone lies, and allow precompiled headers.
use_ccache() {
  if [[ -x /usr/bin/ccache ]]; then
    export CMAKE_C_COMPILER_LAUNCHER=/usr/bin/ccache CMAKE_CXX_COMPILER_LAUNCHER=/usr/bin/ccache
    export CCACHE_BASEDIR=$root CCACHE_NOHASHDIR=1 CCACHE_SLOPPINESS=pch_defines,time_macros
  fi
}

# Make a virtual environment with the packages of a requirements file, from PyPI. It is kept until the file changes.
#
#   make_venv FOLDER REQUIREMENTS [option of python -m venv ...]     both below the workspace
make_venv() {
  local folder=$1 requirements=$root/$2 venv=$root/$1
  shift 2
  if cmp --silent "$requirements" "$venv/requirements.txt"; then
    return
  fi
  say "installing ${requirements##*/} into $folder/ ..."
  mkdir -p "${venv%/*}"
  "$python" -m venv --clear "$@" "$venv"
  # Without PYTHONPATH: pip would leave out what is found there today. Few of the modules are imported.
  env -u PYTHONPATH "$venv/bin/python" -m pip install --quiet --disable-pip-version-check --no-compile \
    --requirement "$requirements"
  cp "$requirements" "$venv/requirements.txt"
}

# The tests' packages from PyPI, besides Debian's. A venv, so that pip installs what is missing only.
use_test_packages() {
  make_venv build/test/venv scripts/test-requirements.txt --system-site-packages
  PYTHONPATH="$PYTHONPATH:$(echo "$root"/build/test/venv/lib/python3*/site-packages)"
  export PYTHONPATH
}

# Enter the built workspace. `--extend` keeps the workspaces sourced before, and the plugins in them.
# setup.bash reads variables that may be unset, and the positional parameters of the script that sources it.
# A ROS_ETC_DIR of the caller's stays: scripts/test has a roscore.xml that starts in half the time.
enter_workspace() {
  local etc=${ROS_ETC_DIR-}
  set +u
  # shellcheck source=/dev/null
  source "$root/devel/setup.bash" "$@"
  set -u
  if [[ $etc ]]; then
    export ROS_ETC_DIR=$etc
  fi
}

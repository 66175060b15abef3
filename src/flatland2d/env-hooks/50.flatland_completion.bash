# Bash completion for scripts/run, flatland, rosrun flatland2d flatland, and roslaunch of flatland_server.
# setup.bash sources it. What can be completed is read from the launch file and from `--help`, once.
# shellcheck shell=bash

[[ $- == *i* || -n ${FLATLAND_TEST_COMPLETION:-} ]] || return 0

declare -gA _flatland_known=()

# The options of a command, from its help.
_flatland_options() {
  if [[ -z ${_flatland_known[$*]+set} ]]; then
    _flatland_known[$*]=$("$@" --help 2>/dev/null | grep -oE '(^|[ [,])--?[a-z][a-z-]*' | tr -d ' [,' | sort -u)
  fi
  printf '%s\n' "${_flatland_known[$*]}"
}

# The launch file's arguments, as "name default".
_flatland_arguments() {
  if [[ -z ${_flatland_known[launch]+set} ]]; then
    _flatland_known[launch]=$(sed -nE 's/.*<arg name="([a-z_]+)" default="([^"]*)".*/\1 \2/p' \
      "$(rospack find flatland_server 2>/dev/null)/launch/server.launch" 2>/dev/null)
  fi
  printf '%s\n' "${_flatland_known[launch]}"
}

_flatland_reply() {
  mapfile -t COMPREPLY < <(compgen "${@:2}" -- "$1")
}

_flatland_files() {
  compopt -o filenames
  mapfile -t -O "${#COMPREPLY[@]}" COMPREPLY < <(compgen -o plusdirs -f -X '!*.@(yaml|yml)' -- "$1")
}

# An argument of the launch file, or its value: "name:=", "name:=value". Bash has split words at ":=".
_flatland_launch() {
  local word=${COMP_WORDS[COMP_CWORD]} before=${COMP_WORDS[COMP_CWORD - 1]} name=
  if [[ $word == :* ]]; then
    name=$before word=
  elif [[ $before == :* ]]; then
    name=${COMP_WORDS[COMP_CWORD - 2]}
  fi
  if [[ -z $name ]]; then
    compopt -o nospace
    _flatland_reply "$word" -W "$(_flatland_arguments | sed 's/ .*/:=/')"
  elif [[ $name == world_path ]]; then
    _flatland_files "$word"
  elif _flatland_arguments | grep -qE "^$name (true|false|.*world_path)"; then
    _flatland_reply "$word" -W "true false"
  fi
}

_flatland_complete_run() {
  local word=${COMP_WORDS[COMP_CWORD]}
  if [[ $word == -* ]]; then
    _flatland_reply "$word" -W "-h --help -p --port --screen --log --no-summary"
    return
  fi
  _flatland_launch
  [[ ${COMP_WORDS[COMP_CWORD - 1]} == :* || $word == :* ]] || _flatland_files "$word"
}

# `flatland`, wherever it is: $1 is the index of the first word after it.
_flatland_subcommand() {
  local first=$1 word=${COMP_WORDS[COMP_CWORD]} command=(flatland)
  type -P flatland >/dev/null || command=(rosrun flatland2d flatland)
  if ((COMP_CWORD == first)); then
    if [[ -z ${_flatland_known[commands]+set} ]]; then
      _flatland_known[commands]=$("${command[@]}" --help 2>/dev/null | sed -nE 's/^    ([a-z]+) .*/\1/p')
    fi
    _flatland_reply "$word" -W "${_flatland_known[commands]} --help"
  elif [[ $word == -* ]]; then
    _flatland_reply "$word" -W "$(_flatland_options "${command[@]}" "${COMP_WORDS[first]}")"
  else
    if [[ -z ${_flatland_known[worlds]+set} ]]; then
      _flatland_known[worlds]=$("${command[@]}" worlds 2>/dev/null | sed 's/ .*//')
    fi
    _flatland_reply "$word" -W "${_flatland_known[worlds]}"
    _flatland_files "$word"
  fi
}

_flatland_complete_flatland() { _flatland_subcommand 1; }

_flatland_complete_roslaunch() {
  if [[ ${COMP_WORDS[1]-} == flatland_server && ${COMP_WORDS[2]-} == server.launch ]] &&
    ((COMP_CWORD > 2)) && [[ ${COMP_WORDS[COMP_CWORD]} != -* ]]; then
    _flatland_launch
  elif declare -F _roscomplete_launch >/dev/null; then
    _roscomplete_launch "$@"
  fi
}

_flatland_complete_rosrun() {
  if ((COMP_CWORD > 2)) && [[ ${COMP_WORDS[1]} == flatland2d && ${COMP_WORDS[2]} == flatland ]]; then
    _flatland_subcommand 3 && return
  fi
  if declare -F _roscomplete_exe >/dev/null; then _roscomplete_exe "$@"; fi
}

complete -F _flatland_complete_run scripts/run ./scripts/run
complete -F _flatland_complete_flatland flatland
complete -F _flatland_complete_roslaunch -o filenames roslaunch
complete -F _flatland_complete_rosrun rosrun

# To be sourced by scripts that measure: text by hand and figures by a script in one document.
#
#   marked_block DOCUMENT NAME COMMAND [ARGUMENT...]
#
# Replaces the lines of DOCUMENT between "<!-- figures: NAME -->" and "<!-- end: NAME -->" by what COMMAND prints. Both
# marks must stand in it once, each on a line of its own, in this order. If they do not, if COMMAND fails or prints
# nothing, the document stays as it is and the status is not 0. The document is replaced in one step.
# shellcheck shell=bash
marked_block() {
  local document=$1 name=$2 mark first last new status=0
  shift 2
  local begin="<!-- figures: $name -->" end="<!-- end: $name -->"
  if [[ ! -f $document ]]; then
    echo "marked_block: $document is missing" >&2
    return 2
  fi
  for mark in "$begin" "$end"; do
    if [[ $(grep -cxF -- "$mark" "$document") != 1 ]]; then
      echo "marked_block: $document: accepted: the line \"$mark\" once" >&2
      return 2
    fi
  done
  first=$(grep -nxF -- "$begin" "$document" | cut -d: -f1)
  last=$(grep -nxF -- "$end" "$document" | cut -d: -f1)
  if [[ $first -ge $last ]]; then
    echo "marked_block: $document: \"$end\" stands above \"$begin\"" >&2
    return 2
  fi

  new=$(mktemp "$document.XXXXXX")
  # In a subshell that ends with the first command to fail; outside of a condition, where bash would go on after it.
  local options=$-
  set +e
  (set -e; "$@") >"$new.block"
  status=$?
  [[ $options != *e* ]] || set -e
  if [[ $status == 0 && ! -s $new.block ]]; then
    echo "marked_block: $document: nothing to put between the marks of $name" >&2
    status=2
  fi
  if [[ $status == 0 ]]; then
    { head -n "$first" "$document"; cat "$new.block"; tail -n "+$last" "$document"; } >"$new" || status=$?
  fi
  if [[ $status == 0 ]]; then
    chmod --reference="$document" "$new"
    mv "$new" "$document"
  fi
  rm -f "$new" "$new.block"
  return "$status"
}

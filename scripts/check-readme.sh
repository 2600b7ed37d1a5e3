#!/usr/bin/env bash
# Run every command of the README as typed, one after the other, in a fresh clone. Takes as long as they do: about an hour.
set -euo pipefail
cd "$(dirname "$0")/.."
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
git clone --quiet . "$folder/gilab"
cd "$folder/gilab"
# The lines of the blocks that begin with ```sh.
awk '/^```sh$/ { inside = 1; next } /^```/ { inside = 0 } inside' README.md > ../commands
while IFS= read -r command; do
  echo "\$ $command"
  start=$SECONDS
  bash -c "$command" < /dev/null
  echo "# $((SECONDS - start)) s"
done < ../commands
du -sh target

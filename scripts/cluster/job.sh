#!/usr/bin/env bash
# One step of a run that many machines share. A scheduler calls it; parallel.sh, slurm.sh and the Snakefile are examples.
#
#   job.sh prepare    make the cache or the photon map once, for programs that have one
#   job.sh shard K    make the passes of shard K = 0, 1, ..., or continue them if the shard was interrupted
#   job.sh merge      add up the shards: OUT/PICTURE
#
# Set in the environment:
#   PROGRAM   a program, for example target/release/pathtrace
#   SCENE     the scene
#   OUT       a folder that all machines see
#   SHARDS    number of shards
#   PASSES    number of passes of a shard
#   PICTURE   name of the merged picture; picture.exr (optional)
#   FLAGS     further flags, for example "--size 512x512" (optional)
#   BY_SEED   1: each shard is a run of its own with its own seed, for `ppm --method sppm` and `adaptive` (optional)
set -euo pipefail
: "${PROGRAM:?}" "${SCENE:?}" "${OUT:?}" "${SHARDS:?}" "${PASSES:?}"
read -r -a flags <<<"${FLAGS:-}"
mkdir -p "$OUT"

# How the program saves what it prepares, and reads it.
save=() read=()
case $(basename "$PROGRAM") in
    irrcache | radcache) save=(--cache-out "$OUT/prepared") read=(--cache-in "$OUT/prepared") ;;
    photonmap) save=(--map-out "$OUT/prepared") read=(--map-in "$OUT/prepared") ;;
esac
run() { "$PROGRAM" "$SCENE" -q --preview 0 "${flags[@]}" "$@"; }

case ${1:?prepare, shard or merge} in
    prepare)
        [ ${#save[@]} -eq 0 ] || run -o "$OUT/prepare.exr" --spp 1 "${save[@]}"
        ;;
    shard)
        k=${2:?the number of the shard}
        kept=$OUT/shard-$k.checkpoint
        range=(--first-pass $((k * PASSES)))
        [ "${BY_SEED:-0}" = 0 ] || range=(--seed "$k")
        resume=()
        [ ! -e "$kept" ] || resume=(--resume)
        run -o "$OUT/shard-$k.exr" --spp "$PASSES" --checkpoint "$kept" --checkpoint-interval 10s \
            "${range[@]}" "${resume[@]}" "${read[@]}"
        ;;
    merge)
        shards=()
        for ((k = 0; k < SHARDS; k++)); do shards+=(--merge "$OUT/shard-$k.checkpoint"); done
        run -o "$OUT/${PICTURE:-picture.exr}" "${shards[@]}" "${read[@]}"
        ;;
    *)
        echo "job.sh: unknown step $1: prepare, shard or merge" >&2
        exit 2
        ;;
esac

#!/usr/bin/env bash
# Tries the recipes with the schedulers that are installed, and kills a shard on the way: the merged picture must have the bits of a
# single run. test.sh [FOLDER OF THE PROGRAMS]; by default target/release.
set -euo pipefail
cd "$(dirname "$0")/../.."
export PROGRAM=$PWD/${1:-target/release}/pathtrace
export SCENE=$PWD/scenes/cornell-box.xml SHARDS=4 PASSES=${PASSES:-200} PICTURE=picture.pfm
export FLAGS="--size 128x128 -t 1"
folder=$(mktemp -d)
here=$PWD/scripts/cluster
started_slurm=0
clean() {
    if [ $started_slurm = 1 ]; then
        scontrol shutdown
        sleep 3
    fi
    rm -rf "$folder"
}
trap clean EXIT

# A single run, to compare with. A PFM holds nothing but the pixels.
"$PROGRAM" "$SCENE" -o "$folder/single.pfm" -q --preview 0 --size 128x128 --spp $((SHARDS * PASSES))
check() { # scheduler
    cmp "$OUT/$PICTURE" "$folder/single.pfm"
    echo "$1: the merged picture has the bits of a single run; $2"
}
skip() { echo "$1: skipped, $2 is not installed"; }
# Kill a shard as soon as it has written a checkpoint.
kill_shard() { # number
    for _ in $(seq 600); do
        if [ -e "$OUT/shard-$1.checkpoint" ] && pkill -KILL -f -- "-o $OUT/shard-$1.exr"; then
            killed="shard $1 was killed"
            return
        fi
        sleep 0.1
    done
    killed="no shard was killed: it ended too early"
}

export OUT=$folder/shell
"$here/job.sh" prepare
"$here/job.sh" shard 1 & shard=$!
kill_shard 1
wait $shard || true
for ((k = 0; k < SHARDS; k++)); do "$here/job.sh" shard "$k"; done
"$here/job.sh" merge
check shell "$killed"

export OUT=$folder/parallel
if command -v parallel >/dev/null; then
    "$here/parallel.sh" 2>"$folder/parallel.log" & all=$!
    kill_shard 1
    wait $all
    check "GNU parallel" "$killed"
else
    skip "GNU parallel" parallel
fi

export OUT=$folder/snakemake
if command -v snakemake >/dev/null; then
    snakemake --snakefile "$here/Snakefile" --directory "$folder" --cores 2 --retries 3 \
        >"$folder/snakemake.log" 2>&1 & all=$!
    kill_shard 1
    wait $all
    check Snakemake "$killed"
else
    skip Snakemake snakemake
fi

export OUT=$folder/slurm
if ! command -v sbatch >/dev/null; then
    skip Slurm slurm-wlm
    exit 0
fi
if ! sinfo >/dev/null 2>&1; then
    "$here/one-node-slurm.sh" "$folder/one-node"
    export SLURM_CONF=$folder/one-node/slurm.conf
    started_slurm=1
fi
read -r array last <<<"$("$here/slurm.sh")"
kill_shard 0
# What Slurm does when a node fails.
for _ in $(seq 600); do
    if [ -e "$OUT/shard-1.checkpoint" ] && scontrol requeue "${array}_1"; then break; fi
    sleep 0.1
done
# Slurm waits two minutes before it starts a shard again.
for _ in $(seq 600); do
    state=$(squeue --noheader --jobs "$last" --format %T 2>/dev/null || true)
    [ -n "$state" ] || break
    sleep 1
done
check Slurm "$killed, and Slurm started shard 1 again"

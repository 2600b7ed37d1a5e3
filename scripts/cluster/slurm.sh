#!/usr/bin/env bash
# All steps as Slurm jobs: prepare, an array of shards, and merge. Each waits for the one before. See job.sh for what to set; SBATCH
# holds flags for all jobs, for example "--partition short --cpus-per-task 8". Prints the numbers of the array
# and of the merging job.
#
# A shard whose program is killed is tried again at once, twice. Slurm itself starts it again if its node fails, or after `scontrol
# requeue`. It continues from its checkpoint.
set -euo pipefail
job=$(realpath "$(dirname "$0")/job.sh")
read -r -a flags <<<"${SBATCH:-}"
mkdir -p "$OUT"
submit() { sbatch --parsable --requeue --open-mode append "${flags[@]}" "$@"; }
prepare=$(submit --output "$OUT/prepare.log" "$job" prepare)
shards=$(submit --output "$OUT/shard-%a.log" --dependency "afterok:$prepare" --array "0-$((SHARDS - 1))" \
    --wrap "for try in 1 2 3; do \"$job\" shard \$SLURM_ARRAY_TASK_ID && exit; done; exit 1")
merge=$(submit --output "$OUT/merge.log" --dependency "afterok:$shards" "$job" merge)
echo "$shards $merge"

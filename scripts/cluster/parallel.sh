#!/usr/bin/env bash
# All steps with GNU parallel, on this machine or on those of --sshlogin. See job.sh for what to set; JOBS is the number of shards at
# a time. A shard that fails is tried again, and continues from its checkpoint.
set -euo pipefail
job=$(dirname "$0")/job.sh
"$job" prepare
parallel --jobs "${JOBS:-1}" --retries 3 "$job" shard ::: $(seq 0 $((SHARDS - 1)))
"$job" merge

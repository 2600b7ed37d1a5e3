#!/usr/bin/env bash
# Starts Slurm on this machine alone, to try the recipes: one-node-slurm.sh FOLDER. Needs root and the packages slurmctld, slurmd and
# munge. Then set SLURM_CONF=FOLDER/slurm.conf. Stop it with: scontrol shutdown.
set -euo pipefail
folder=$(realpath "${1:?a folder for its files}")
mkdir -p "$folder/state" "$folder/spool"
[ -e /etc/munge/munge.key ] || mungekey --create
chown munge: /etc/munge/munge.key
mkdir -p /run/munge && chown munge: /run/munge
pgrep -x munged >/dev/null || runuser -u munge -- munged
host=$(hostname -s)
cat >"$folder/slurm.conf" <<CONF
ClusterName=one
SlurmctldHost=$host(127.0.0.1)
SlurmUser=root
StateSaveLocation=$folder/state
SlurmdSpoolDir=$folder/spool
SlurmctldPidFile=$folder/slurmctld.pid
SlurmdPidFile=$folder/slurmd.pid
SlurmctldLogFile=$folder/slurmctld.log
SlurmdLogFile=$folder/slurmd.log
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
SelectType=select/cons_tres
ReturnToService=2
NodeName=$host NodeAddr=127.0.0.1 CPUs=$(nproc)
PartitionName=all Nodes=$host Default=YES State=UP
CONF
export SLURM_CONF=$folder/slurm.conf
slurmctld
slurmd
for _ in $(seq 30); do
    sinfo --noheader --format %T 2>/dev/null | grep -q idle && exit 0
    sleep 1
done
echo "one-node-slurm.sh: the node does not come up; see $folder/*.log" >&2
exit 1

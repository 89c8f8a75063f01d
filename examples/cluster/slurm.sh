#!/bin/sh
#SBATCH --job-name=map --array=1-8 --ntasks=1 --cpus-per-task=1 --time=02:00:00
#SBATCH --requeue --open-mode=append --output=map-%a.log
# The map as a Slurm job array: sbatch slurm.sh, or sbatch --array=1-100 slurm.sh for other numbers of shards. A job
# that is preempted or runs out of its time goes on where it was when it is queued again. Then:
#   cat part.*.csv >map.csv; hooke --check-sweep map.csv
# Some of eight once more: SHARDS=8 sbatch --array=3,5 slurm.sh
# Slurm runs a copy of this file: MAP_FOLDER says where the others are, else they are where sbatch was called.
MAP_FOLDER=${MAP_FOLDER:-$SLURM_SUBMIT_DIR} THREADS=$SLURM_CPUS_PER_TASK
export MAP_FOLDER THREADS
exec sh "$MAP_FOLDER/map-shard" "$SLURM_ARRAY_TASK_ID" "${SHARDS:-$SLURM_ARRAY_TASK_COUNT}"

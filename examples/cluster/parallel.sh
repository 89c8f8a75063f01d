#!/bin/sh
# The map by GNU parallel: parallel.sh [SHARDS]. Started again, it goes on; shards that failed are tried again.
# Other machines: add --sshlogin and a folder that all of them see, or --return with --cleanup.
shards=${1:-8}
seq "$shards" | parallel --joblog map.log --resume-failed sh "$(dirname "$0")/map-shard" {} "$shards" &&
    cat part.*.csv >map.csv && "${HOOKE:-hooke}" --check-sweep map.csv

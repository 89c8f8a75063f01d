#!/usr/bin/env bash
# SPDX-License-Identifier: GPL-3.0-or-later
# examples/cluster: the map by make, by GNU parallel and by Slurm, where these are installed, is the one that a single
# program computes; what failed on the way is gone on with. Slurm has one node here, started and stopped by this script
# as the user who runs it.
set -u
hooke=$(realpath "${HOOKE:-build/hooke}")
examples=$(realpath examples/cluster)
n=0 bad=0
ok() { n=$((n + 1)); if [ "$2" -eq 0 ]; then echo "ok $n - $1"; else bad=1; echo "not ok $n - $1"; tail -n 5 "${3:-err}" 2>/dev/null | sed 's/^/# /'; fi; }
skip() { n=$((n + 1)); echo "ok $n - $1 # SKIP $2"; }
folder=$(mktemp -d) || exit 2
daemons=()
finish() {
    for process in "${daemons[@]}"; do kill "$process" 2>/dev/null; done
    for process in "${daemons[@]}"; do wait "$process" 2>/dev/null; done
    cd / && rm -rf "$folder"
}
trap finish EXIT
cd "$folder" || exit 2
export HOOKE=$hooke SWEEP='omega=5:12:0.1 gamma=0.1:2:0.1 measure=amplitude,period'
sed 's/20 s/3 s/' "$examples/map.hk" >map.hk
cp "$examples"/{map-shard,parallel.sh,slurm.sh,Makefile} .
statement() { "$hooke" -n -q -f map.hk -c "sweep $SWEEP --resume $1" 2>err; }
statement whole.csv
ok "the whole" $?
# the_same WHAT: parts and what was made of them are the whole, byte for byte.
the_same() {
    cmp -s map.csv whole.csv
    ok "$1: shards one after another have the bytes of the whole" $?
    "$hooke" --check-sweep part.*.csv >err && tail -qn 1 part.*.csv | grep -c '^# sweep .*: 1420 points in all' | grep -qx 8
    ok "$1: each is whole, and says so" $?
    rm -f part.*.csv map.csv
}

make -s -j 2 SHARDS=8 map.csv >out 2>err && [ "$(ls part.*.csv | wc -l)" -eq 8 ]
ok "make" $?
head -n 60 part.00003.csv >part && mv part part.00003.csv && rm part.00005.csv map.csv
make -s -j 2 SHARDS=8 map.csv >out 2>err
ok "make again: what is missing is computed" $?
the_same make

if command -v parallel >/dev/null && parallel --version 2>/dev/null | grep -q GNU; then
    # The fifth shard fails at first: a folder is where its file should be.
    mkdir part.00005.csv
    sh ./parallel.sh 8 >out 2>err
    [ $? -ne 0 ] && [ ! -e map.csv ] && [ "$(awk 'NR > 1 && $7 != 0' map.log | wc -l)" -eq 1 ]
    ok "parallel: a shard that failed is in the log, and nothing is put together" $?
    rmdir part.00005.csv && before=$(stat -c %Y.%i part.00004.csv)
    sh ./parallel.sh 8 >out 2>err && [ "$(stat -c %Y.%i part.00004.csv)" = "$before" ] && [ "$(tail -n +2 map.log | wc -l)" -eq 9 ]
    ok "parallel again: only that one" $?
    the_same parallel
else
    skip "parallel" "GNU parallel is not installed"
fi

# ---- one node ----

begin_slurm() {
    local user host port
    user=$(id -un) host=$(hostname -s) port=$((20000 + RANDOM % 20000))
    mkdir state spool
    cat >slurm.conf <<END
ClusterName=one
SlurmctldHost=$host(127.0.0.1)
SlurmUser=$user
SlurmdUser=$user
SlurmctldPort=$port
SlurmdPort=$((port + 1))
AuthType=auth/none
CredType=cred/none
ProctrackType=proctrack/pgid
TaskPlugin=task/none
JobAcctGatherType=jobacct_gather/none
SelectType=select/cons_tres
SelectTypeParameters=CR_CPU
SchedulerParameters=sched_interval=1
ReturnToService=2
StateSaveLocation=$folder/state
SlurmdSpoolDir=$folder/spool
SlurmctldPidFile=$folder/slurmctld.pid
SlurmdPidFile=$folder/slurmd.pid
SlurmctldLogFile=$folder/slurmctld.log
SlurmdLogFile=$folder/slurmd.log
SlurmdParameters=config_overrides
NodeName=$host NodeAddr=127.0.0.1 CPUs=2 State=UNKNOWN
PartitionName=all Nodes=$host Default=YES MaxTime=INFINITE State=UP
END
    printf 'CgroupPlugin=cgroup/v1\n' >cgroup.conf
    export SLURM_CONF=$folder/slurm.conf
    PATH=$PATH:/usr/sbin
    slurmctld -D -f "$SLURM_CONF" >ctld.out 2>&1 &
    daemons+=($!)
    slurmd -D -f "$SLURM_CONF" >slurmd.out 2>&1 &
    daemons+=($!)
    for _ in $(seq 300); do
        sinfo -h -o %t 2>/dev/null | grep -qx idle && return 0
        sleep 0.1
    done
    return 1
}
# Until nothing is queued any more; sbatch --wait looks every ten seconds.
submit() {
    sbatch "$@" slurm.sh >out 2>err || return 1
    for _ in $(seq 1200); do
        queued=$(squeue -h 2>>err) && [ -z "$queued" ] && return 0
        sleep 0.1
    done
    return 1
}
if command -v sbatch >/dev/null && [ -x /usr/sbin/slurmctld ] && [ -x /usr/sbin/slurmd ]; then
    if begin_slurm; then
        submit && cat part.*.csv >map.csv && [ "$(ls part.*.csv | wc -l)" -eq 8 ]
        ok "slurm: eight jobs of an array" $?
        head -n 60 part.00003.csv >part && mv part part.00003.csv
        SHARDS=8 submit --array=3
        the_same slurm
    else
        skip "slurm" "its daemons do not start here: $(tail -qn 1 slurmctld.log slurmd.log 2>/dev/null | tail -n 1 | cut -c1-100)"
    fi
else
    skip "slurm" "without slurm-wlm, an optional judge"
fi
echo "1..$n"
exit $bad

#!/bin/sh
# A real Slurm of one node on the loopback, for trials: one_node.sh start | stop. Needs root, slurm-wlm and munge.
# Jobs look for slurm.conf in its default place only (their environment drops SLURM_CONF), so it is written there, unless
# somebody else's stands there already.
set -eu
conf=/etc/slurm/slurm.conf
mark="# written by benchmarks/slurm/one_node.sh"
state="${EACLUTCH_SLURM_STATE:-/tmp/eaclutch-slurm}"

missing() {
    for program in slurmctld slurmd munged squeue; do
        command -v "$program" > /dev/null || { echo "$program is not installed"; return; }
    done
    [ "$(id -u)" = 0 ] || { echo "root is needed"; return; }
    if [ -e "$conf" ] && ! head -n 1 "$conf" | grep -q "^$mark"; then echo "$conf is somebody else's"; fi
}

start() {
    mkdir -p "$state/state" "$state/spool" /run/munge /etc/slurm
    node=$(hostname -s)
    cat > "$conf" << END
$mark
ClusterName=bench
SlurmctldHost=$node(127.0.0.1)
SlurmUser=root
AuthType=auth/munge
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
MpiDefault=none
ReturnToService=2
SelectType=select/cons_tres
SelectTypeParameters=CR_Core
SlurmdParameters=config_overrides
StateSaveLocation=$state/state
SlurmdSpoolDir=$state/spool
SlurmctldPidFile=$state/slurmctld.pid
SlurmdPidFile=$state/slurmd.pid
SlurmctldLogFile=$state/slurmctld.log
SlurmdLogFile=$state/slurmd.log
SchedulerParameters=sched_interval=5,bf_interval=5
InactiveLimit=0
KillWait=5
OverTimeLimit=0
NodeName=$node NodeAddr=127.0.0.1 CPUs=4 RealMemory=6000 State=UNKNOWN
PartitionName=all Nodes=ALL Default=YES MaxTime=INFINITE State=UP
END
    [ -e /etc/munge/munge.key ] || { dd if=/dev/urandom of=/etc/munge/munge.key bs=1 count=1024 2> /dev/null; }
    chown munge:munge /etc/munge/munge.key /run/munge
    chmod 400 /etc/munge/munge.key
    pgrep -x munged > /dev/null || { setpriv --reuid munge --regid munge --clear-groups munged && touch "$state/munged"; }
    slurmctld
    slurmd
    for _ in $(seq 60); do
        if sinfo -h -o %T 2> /dev/null | grep -q idle; then
            echo "slurm is up: $(sinfo -h)"
            return
        fi
        sleep 1
    done
    echo "slurm did not come up, see $state" >&2
    exit 1
}

stop() {
    scancel --user="$(id -un)" 2> /dev/null || true
    for daemon in slurmd slurmctld; do
        [ -e "$state/$daemon.pid" ] && kill "$(cat "$state/$daemon.pid")" 2> /dev/null || true
    done
    if [ -e "$state/munged" ]; then kill "$(cat /run/munge/munged.pid)" 2> /dev/null || true; fi
    sleep 2
    if [ -e "$conf" ] && head -n 1 "$conf" | grep -q "^$mark"; then rm -f "$conf"; fi
    rm -rf "$state"
}

reason=$(missing)
if [ -n "$reason" ]; then
    echo "no trial of Slurm: $reason" >&2
    exit 77
fi
case "${1:-}" in
    start) start ;;
    stop) stop ;;
    *) echo "one_node.sh start | stop" >&2; exit 2 ;;
esac

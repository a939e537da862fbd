#!/bin/bash
# Runs tools/farm/etendue-farm against a Slurm cluster of one node, made for the test on this machine: farm_slurm.sh ETENDUE SOURCE
# Skipped (77) where munged, slurmctld or slurmd are not installed or do not start.
set -u
export ETENDUE=$1
source=$2
for program in munged slurmctld slurmd sbatch sinfo; do
  PATH=$PATH:/usr/sbin command -v $program >/dev/null || { echo "skipped: $program is not installed (packages munge slurmctld slurmd slurm-client)"; exit 77; }
done
PATH=$PATH:/usr/sbin

folder=$(mktemp -d /tmp/etendue-slurm-XXXXXX)
pids=
finish() {
  code=$?
  for pid in $pids; do kill "$pid" 2>/dev/null; done
  for pid in $pids; do wait "$pid" 2>/dev/null; done
  [ "$code" -eq 0 ] || tail -n 30 "$folder"/*.log "$folder"/jobs/*.log 2>/dev/null
  rm -rf "$folder"
  exit "$code"
}
trap finish EXIT
mkdir -p "$folder"/{state,spool,munge,jobs}
chmod 755 "$folder"
chmod 700 "$folder/munge"
dd if=/dev/urandom of="$folder/munge/key" bs=1 count=1024 status=none
chmod 600 "$folder/munge/key"
host=$(hostname -s)
port=$((20000 + RANDOM % 20000))
cat > "$folder/slurm.conf" <<CONF
ClusterName=etendue
SlurmctldHost=$host(127.0.0.1)
SlurmUser=$(id -un)
SlurmdUser=$(id -un)
AuthType=auth/munge
AuthInfo=socket=$folder/munge.socket
CredType=cred/munge
SlurmctldPort=$port
SlurmdPort=$((port + 1))
StateSaveLocation=$folder/state
SlurmdSpoolDir=$folder/spool
SlurmctldPidFile=$folder/slurmctld.pid
SlurmdPidFile=$folder/slurmd.pid
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
JobAcctGatherType=jobacct_gather/none
AccountingStorageType=accounting_storage/none
MpiDefault=none
SwitchType=switch/none
SchedulerType=sched/backfill
SelectType=select/cons_tres
SelectTypeParameters=CR_Core
SchedulerParameters=sched_min_interval=100000,bf_interval=1
ReturnToService=2
MailProg=/bin/true
MinJobAge=600
NodeName=$host NodeAddr=127.0.0.1 CPUs=$(nproc) State=UNKNOWN
PartitionName=test Nodes=ALL Default=YES MaxTime=INFINITE State=UP OverSubscribe=YES
CONF
export SLURM_CONF=$folder/slurm.conf

munged --foreground --force --key-file="$folder/munge/key" --socket="$folder/munge.socket" --pid-file="$folder/munged.pid" \
  --log-file="$folder/munged.log" --seed-file="$folder/munge/seed" 2>"$folder/munged.out.log" & pids="$pids $!"
for _ in $(seq 50); do [ -S "$folder/munge.socket" ] && break; sleep 0.1; done
slurmctld -D -i -f "$SLURM_CONF" >"$folder/slurmctld.log" 2>&1 & pids="$pids $!"
slurmd -D -N "$host" -f "$SLURM_CONF" >"$folder/slurmd.log" 2>&1 & pids="$pids $!"
up=
for _ in $(seq 200); do
  if [ "$(sinfo -h -o %T 2>/dev/null)" = idle ]; then up=1; break; fi
  sleep 0.1
done
if [ -z "$up" ]; then
  tail -n 5 "$folder"/*.log
  echo 'skipped: slurmctld and slurmd do not start here'
  trap - EXIT
  for pid in $pids; do kill "$pid" 2>/dev/null; done
  rm -rf "$folder"
  exit 77
fi

fail() { echo "FAILED: $*"; exit 1; }
# Waits until no job is left that will ever run.
drain() {
  for _ in $(seq 600); do
    [ -z "$(squeue -h -o %i)" ] && return 0
    sleep 0.2
  done
  squeue
  fail 'jobs do not end'
}
cd "$folder/jobs" || exit 1
scene=$source/scenes/cbox-sphere.xml
options='--size 40x30'
$ETENDUE render "$scene" $options --spp 20 --film -o one.exr -q || { [ $? -eq 4 ] && exit 77; fail 'the render in one go'; }

# Four shards; the third finds its film's place taken by a folder and fails, so the merge must not run.
mkdir -p result.exr.shards/shard-2.part.exr
"$source/tools/farm/etendue-farm" "$scene" 20 4 "$folder/jobs/result.exr" $options || fail 'submitting'
drain
for shard in 0 1 3; do [ -f "result.exr.shards/shard-$shard.exr" ] || fail "shard $shard is missing"; done
[ ! -e result.exr.shards/shard-2.exr ] || fail 'shard 2 was to fail'
[ ! -e result.exr ] || fail 'merged without shard 2'

# Run again: only the failed shard is rendered, then all are merged.
rmdir result.exr.shards/shard-2.part.exr
touch -d @1 result.exr.shards/shard-0.exr
said=$("$source/tools/farm/etendue-farm" "$scene" 20 4 "$folder/jobs/result.exr" $options) || fail 'submitting again'
case $said in "shards 2: "*) ;; *) fail "expected shard 2 alone: $said" ;; esac
drain
cmp one.exr result.exr || fail 'the merged film differs from one render'
[ "$(stat -c %Y result.exr.shards/shard-0.exr)" -eq 1 ] || fail 'a good shard was rendered again'

# A task that gets SIGTERM, as before its time limit, saves a checkpoint and goes on from it when it is submitted again.
"$source/tools/farm/etendue-farm" "$scene" 200000 1 "$folder/jobs/long.exr" $options > submitted || fail 'submitting the long one'
job=$(sed -n 's/^shards 0: job //p' submitted)
for _ in $(seq 300); do [ "$(squeue -h -j "$job" -o %T)" = RUNNING ] && break; sleep 0.1; done
sleep 3
scancel --batch --signal=TERM "$job"
drain
[ -f long.exr.shards/shard-0.checkpoint.exr ] || fail 'no checkpoint after SIGTERM'
[ ! -e long.exr.shards/shard-0.exr ] || fail 'an interrupted shard passes for a whole one'
# Enough was seen; the rest would take a while. The checkpoint is what one render of its samples gives.
$ETENDUE merge long.exr.shards/shard-0.checkpoint.exr -o count.png --json > count.json || fail 'reading the checkpoint'
done_spp=$(sed -n 's/^ *"samples": \([0-9]*\),*$/\1/p' count.json)
$ETENDUE render "$scene" $options --spp "$done_spp" --film -o part.exr -q || fail 'rendering the part'
cmp part.exr long.exr.shards/shard-0.checkpoint.exr || fail 'the checkpoint differs from one render'

# Frames of an asset that moves: an array of three tasks with two frames each, one of which is there already and stays as it is.
asset=$source/tests/fuzz/corpus/fuzz_scene_gltf/animated.gltf
frames="--fps 2 $options --spp 16 -q"
mkdir one many
$ETENDUE render "$asset" --frames 0:6 $frames -o one/f-####.exr || fail 'the frames in one go'
cp one/f-0003.exr many/f-0003.exr
touch -d @1 many/f-0003.exr
sbatch --array=0-2 --requeue --signal=B:TERM@60 --wrap "exec $ETENDUE render $asset \
  --frames \$((2 * SLURM_ARRAY_TASK_ID)):\$((2 * SLURM_ARRAY_TASK_ID + 2)) $frames -o $folder/jobs/many/f-####.exr" || fail 'submitting the frames'
drain
for frame in 0 1 2 3 4 5; do cmp one/f-000$frame.exr many/f-000$frame.exr || fail "frame $frame differs"; done
[ "$(stat -c %Y many/f-0003.exr)" -eq 1 ] || fail 'a frame that was there was rendered again'
cmp -s one/f-0000.exr one/f-0002.exr && fail 'nothing moves'
echo "a Slurm array of 4 shards, one failed and rendered again alone, one interrupted at $done_spp spp, and 6 frames in 3 tasks: all bytes agree"

#!/usr/bin/env bash
# A farm on one machine: starts munged, slurmctld and slurmd without systemd, bakes many tiny shots as a job
# array while a share of the tasks is killed at random (kill -9), bakes the same shots one after another, and
# compares. As root, with the Debian packages slurmctld, slurmd, slurm-client and munge.
#   scripts/bake_farm.sh PATH/TO/pelage-bake [--shots 200] [--kill 20] [--tasks 2] [--seed 1]
# It fails unless all shots are complete and have the bytes of the serial run, and no shot was simulated again
# behind its completion.
set -euo pipefail
bake=$(realpath "$1"); shift
shots=200 kill=20 tasks=2 seed=1
while [ $# -gt 0 ]; do
  case $1 in
    --shots) shots=$2 ;;
    --kill) kill=$2 ;;
    --tasks) tasks=$2 ;;
    --seed) seed=$2 ;;
    *) echo "unknown option $1" >&2; exit 2 ;;
  esac
  shift 2
done
scripts=$(dirname "$(realpath "$0")")
work=$(mktemp -d /tmp/bake-farm-XXXXXX)
daemons=()
cleanup() {
  for process in "${daemons[@]}"; do kill "$process" 2> /dev/null || true; done
  wait 2> /dev/null || true
}
trap cleanup EXIT
host=$(hostname -s)

mkdir -p "$work"/{state,spool,log}
chmod 755 "$work"
dd if=/dev/urandom of="$work/munge.key" bs=1024 count=1 status=none
chmod 600 "$work/munge.key"
munged --foreground --force --key-file="$work/munge.key" --socket="$work/munge.socket" \
  --pid-file="$work/munge.pid" --seed-file="$work/munge.seed" --log-file="$work/log/munge.log" \
  > "$work/log/munged" 2>&1 & daemons+=($!)

cat > "$work/slurm.conf" <<CONF
ClusterName=bake
SlurmctldHost=$host
SlurmctldPort=17817
SlurmdPort=17818
SlurmUser=root
AuthType=auth/munge
AuthInfo=socket=$work/munge.socket,cred_expire=5
CryptoType=crypto/munge
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
JobAcctGatherType=jobacct_gather/none
SelectType=select/cons_tres
SelectTypeParameters=CR_CPU
SlurmdParameters=config_overrides
SchedulerParameters=sched_min_interval=100000
ReturnToService=2
RequeueExit=75
MaxArraySize=100001
MaxJobCount=100000
StateSaveLocation=$work/state
SlurmdSpoolDir=$work/spool
SlurmctldPidFile=$work/slurmctld.pid
SlurmdPidFile=$work/slurmd.pid
SlurmctldLogFile=$work/log/slurmctld.log
SlurmdLogFile=$work/log/slurmd.log
NodeName=$host NodeAddr=127.0.0.1 CPUs=$tasks State=UNKNOWN
PartitionName=bake Nodes=$host Default=YES MaxTime=INFINITE State=UP
CONF
export SLURM_CONF="$work/slurm.conf"
slurmctld -D > "$work/log/slurmctld" 2>&1 & daemons+=($!)
slurmd -D -N "$host" > "$work/log/slurmd" 2>&1 & daemons+=($!)
for _ in $(seq 60); do
  sinfo -h -o %T 2> /dev/null | grep -q idle && break
  sleep 0.5
done
sinfo -h -o %T | grep -q idle || { tail -n 5 "$work"/log/*; exit 1; }

# Every shot has another groom and another beginning of the motion.
python3 - "$work" "$shots" <<'PROJECT'
import json, sys
work, shots = sys.argv[1], int(sys.argv[2])
for output in ("farm", "serial"):
    project = {"version": 1, "output": output, "chunkFrames": 4, "checkpointChunks": 1,
               "defaults": {"collides": False}, "shots": []}
    for i in range(shots):
        project["shots"].append({
            "name": f"s{i:05}", "frames": [1, 24],
            "assets": {"generated": {"kind": "head", "guides": 6, "seed": i + 1}},
            "animation": {"motion": "all", "start": 0.05 * i}})
    with open(f"{work}/{output}.json", "w") as file:
        json.dump(project, file)
PROJECT
for output in farm serial; do "$bake" plan -q "$work/$output.json" "$work/$output.txt"; done

begin=$(date +%s%N)
bash -e "$work/serial.txt" > "$work/log/serial"
serial=$((($(date +%s%N) - begin) / 1000000))
echo "serial: $shots shots in $serial ms"

# Kills a share of the first attempts, at a random time within that of a shot in the serial run, times the
# number of tasks.
cat > "$work/hook.sh" <<HOOK
#!/usr/bin/env bash
RANDOM=\$(( $seed * 7919 + SLURM_ARRAY_TASK_ID ))
[ "\${SLURM_RESTART_COUNT:-0}" = 0 ] && [ \$(( RANDOM % 100 )) -lt $kill ] || exit 0
milliseconds=\$(( RANDOM * $((serial * tasks / shots)) / 32768 ))
sleep "\$(( milliseconds / 1000 )).\$(printf %03d \$(( milliseconds % 1000 )))"
kill -KILL "\$1" 2> /dev/null && echo "\$SLURM_ARRAY_TASK_ID" >> "$work/killed"
HOOK
chmod +x "$work/hook.sh"
touch "$work/killed"
begin=$(date +%s%N)
job=$(sbatch --parsable --array=1-"$shots" --export=ALL,BAKE_ARRAY_HOOK="$work/hook.sh" \
  --output="$work/log/task-%a" "$scripts/bake_array.sh" "$work/farm.txt")
while [ -n "$(squeue -h -j "$job" 2> /dev/null)" ]; do sleep 1; done
echo "farm: $shots tasks on $tasks CPUs in $((($(date +%s%N) - begin) / 1000000)) ms," \
  "$(wc -l < "$work/killed") of them killed"
# A second pass finds everything complete.
bash -e "$work/farm.txt" > "$work/log/again"

"$bake" verify "$work/farm.json" -q
python3 - "$work" "$shots" <<'CHECK'
import json, pathlib, sys
work, shots = pathlib.Path(sys.argv[1]), int(sys.argv[2])
resumed = lost = 0
for i in range(shots):
    name = f"s{i:05}"
    farm, serial = work / "farm" / name, work / "serial" / name
    for file in ("head.pelagecache", "done.json"):
        a, b = (farm / file).read_bytes(), (serial / file).read_bytes()
        if a != b:
            sys.exit(f"{name}: {file} has other bytes than in the serial run")
    extra = {p.name for p in farm.iterdir()} - {"head.pelagecache", "done.json", "log.jsonl"}
    if any(not e.startswith("lock") for e in extra):
        sys.exit(f"{name}: {extra} is left")
    events = [json.loads(line) for line in (farm / "log.jsonl").read_text().splitlines()]
    done = [k for k, e in enumerate(events) if e["event"] == "done"]
    if len(done) > 1:
        sys.exit(f"{name}: completed {len(done)} times")
    if not done:  # killed between done.json and the line in the log
        done = [k for k, e in enumerate(events) if e["event"] == "complete already"]
    if any(e["event"] == "start" for e in events[done[0] + 1:]):
        sys.exit(f"{name}: simulated again behind its completion")
    resumed += events[done[0]].get("resumed", 0) > 0
    lost += sum(e["event"] == "start" for e in events) - 1
print(f"all {shots} shots are complete and have the bytes of the serial run; none was simulated behind its")
print(f"completion; {lost} processes ended while they simulated, {resumed} went on from a checkpoint")
CHECK
rm -rf "$work"

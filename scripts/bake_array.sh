#!/usr/bin/env bash
# A task of a Slurm job array runs one line of a command file of `pelage-bake plan`:
#   sbatch --array=1-$(wc -l < commands.txt) scripts/bake_array.sh commands.txt
# A command that was killed or interrupted ends with 75, for RequeueExit=75 in slurm.conf: the task is
# queued again and goes on from its last chunk.
#SBATCH --job-name=bake --requeue --open-mode=append
set -u
command=$(sed -n "${SLURM_ARRAY_TASK_ID}p" "$1")
[ -n "$command" ] || { echo "$1 has no line $SLURM_ARRAY_TASK_ID" >&2; exit 2; }
# Slurm sends SIGTERM to the processes of the task some seconds before SIGKILL.
trap : TERM
bash -c "exec $command" &
process=$!
[ -z "${BAKE_ARRAY_HOOK:-}" ] || "$BAKE_ARRAY_HOOK" "$process" &
wait "$process"
status=$?
[ "$status" -le 128 ] || { kill -TERM "$process" 2> /dev/null && wait "$process"; status=75; }
exit "$status"

#!/usr/bin/env bash
# SPDX-License-Identifier: GPL-3.0-or-later
# Kills a run that writes checkpoints without pause, at random instants, and checks each time that a
# valid checkpoint not older than the last committed one is left.
# usage: kill_checkpoint.sh <checkpoint_loop> [kills] [seed]
set -u
program=$1
kills=${2:-10}
seed=${3:-$(date +%N | sed 's/^0*//')}
RANDOM=$((seed % 32768))
mpiexec=${MPIEXEC:-mpiexec}
export OMPI_MCA_odls_base_sigkill_timeout=0 # do not wait for ranks that are dead already
echo "kills $kills, seed $seed"

rm -f runtime_backup?.h5* write.log launcher.log
"$mpiexec" -n 2 "$program" write 1 || { echo "FAIL: the first checkpoint was not written"; exit 1; }
newest=1
for ((i = 1; i <= kills; i++)); do
  : > write.log # the lines of the last run must not start this clock
  # The ranks write their lines into the file themselves: a launcher that is late, or killed below, would keep them back.
  "$mpiexec" -n 2 sh -c 'exec "$0" write 100000 >> write.log 2>&1' "$program" > launcher.log 2>&1 &
  launcher=$!
  # The clock starts with the first commit; several follow per second. A busy machine may need long
  # for the start, so that a run is waited for as long as it lives.
  until grep -q committed write.log || ! kill -0 "$launcher" 2> /dev/null; do sleep 0.05; done
  delay=0.$(printf '%03d' $((RANDOM % 700)))
  sleep "$delay"
  part=none
  for f in runtime_backup?.h5.part; do [ -e "$f" ] && part=$f; done
  ranks=$(pgrep -P "$launcher")
  if [ -z "$ranks" ]; then
    echo "FAIL: run $i ended by itself: $(tail -3 write.log launcher.log)"; exit 1
  fi
  kill -9 $ranks
  # The launcher notices and ends. Where it does not, it is no fault of the program under test.
  for ((n = 0; n < 300; n++)); do kill -0 "$launcher" 2> /dev/null || break; sleep 0.1; done
  kill -9 "$launcher" 2> /dev/null
  wait "$launcher" 2> /dev/null
  # The kill may cut the last line in the middle of its number: it is one more commit, of which the line does not tell.
  cut=0
  if [ -n "$(tail -c 1 write.log)" ]; then sed -i '$d' write.log; cut=1; fi
  committed=$(grep -o 'committed [0-9][0-9]*' write.log | tail -1 | cut -d' ' -f2)
  committed=${committed:-$newest}
  if ! result=$(timeout 300 "$mpiexec" -n 2 "$program" verify 2>&1); then
    echo "FAIL: kill $i after $delay s left no valid checkpoint: $result"; exit 1
  fi
  found=$(echo "$result" | grep -o 'newest [0-9]*' | cut -d' ' -f2)
  echo "kill $i after $delay s (unfinished file: $part): committed $committed, newest valid $found"
  if [ -z "$found" ] || [ "$committed" -lt "$newest" ] || [ "$found" -lt "$committed" ] || [ "$found" -gt $((committed + 1 + cut)) ]; then
    echo "FAIL: wrong generation; the newest before was $newest"; exit 1
  fi
  newest=$found
done
echo "pass"

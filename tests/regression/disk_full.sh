#!/usr/bin/env bash
# SPDX-License-Identifier: GPL-3.0-or-later
# A checkpoint that does not fit on the disk is a failure that keeps the earlier one. A limit on the
# size of files takes the part of the full disk.
# usage: disk_full.sh <checkpoint_loop>
set -u
program=$1
mpiexec=${MPIEXEC:-mpiexec}

rm -f runtime_backup?.h5*
"$mpiexec" -n 2 "$program" write 1 || { echo "FAIL: the first checkpoint was not written"; exit 1; }
trap '' XFSZ
# 6 MB: above what Open MPI itself needs, below the 8 MB of a checkpoint.
if output=$(ulimit -f 6144 && "$mpiexec" -n 2 "$program" write 1 2>&1); then
  echo "FAIL: a checkpoint beyond the limit was reported as written"; exit 1
fi
echo "$output"
grep -q 'runtime_backup1.h5.part: ' <<< "$output" || { echo "FAIL: the message names no file"; exit 1; }
[ -e runtime_backup1.h5.part ] && { echo "FAIL: the unfinished file was left"; exit 1; }
"$mpiexec" -n 2 "$program" verify | grep 'newest 1 ' || { echo "FAIL: the earlier checkpoint is lost"; exit 1; }
"$mpiexec" -n 2 "$program" write 2 | grep 'committed 3' || { echo "FAIL: no checkpoint after the failure"; exit 1; }
echo "pass"

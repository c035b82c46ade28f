#!/usr/bin/env bash
# SPDX-License-Identifier: GPL-3.0-or-later
# A checkpoint that does not fit on the disk is a failure that keeps the earlier one and does not crash.
# A limit on the size of files takes the part of the full disk; where it is allowed to mount a small
# disk, that one is filled as well.
# usage: disk_full.sh <checkpoint_loop>
set -u
program=$1
mpiexec=${MPIEXEC:-mpiexec}
if "$mpiexec" --version 2> /dev/null | grep -q 'Open MPI) 5'; then
  # Shared memory is a file, too, of 16 MB by default. Where a collective write fails on one rank, the default (vulcan)
  # leaves the other one waiting for ever; that of Open MPI 4 does not, but there this one crashes.
  export OMPI_MCA_btl_sm_segment_size=4194304 OMPI_MCA_fcoll=dynamic_gen2
fi

fail() { echo "FAIL: $*"; exit 1; }
run() { "$mpiexec" -n 2 "$program" "$@" 2>&1; }

# Tries to write a checkpoint, by the command given, which must fail in good order.
must_fail() {
  if output=$("$@"); then fail "a checkpoint without space was reported as written"; fi
  echo "$output" | grep 'runtime_backup1' || fail "the message names no file: $output"
  grep -v 'IEEE_' <<< "$output" | grep -qi 'segmentation\|signal' && fail "it crashed: $output"
  ls | grep 'part\|reserve' && fail "an unfinished file was left"
  run verify | grep 'newest 1 ' || fail "the earlier checkpoint is lost"
}

limited() { (ulimit -f 6144 && run write 1); } # 6 MB: more than Open MPI needs, less than a checkpoint

if [ "${2:-}" != mounted ]; then
  rm -f runtime_backup?.h5*
  run write 1 || fail "the first checkpoint was not written"
  must_fail limited
  run write 2 | grep 'committed 3' || fail "no checkpoint after the failure"
  mkdir -p small
  if unshare -m mount -t tmpfs -o size=1m tmpfs small 2> /dev/null; then
    unshare -m bash -c "mount -t tmpfs -o size=17m tmpfs small && cd small && exec \"$0\" \"$program\" mounted" || exit 1
  else
    echo "no right to mount a small disk: that part is left out"
  fi
else
  for free in 0 255 300 4000 8060; do # kB
    rm -f filler runtime_backup?.h5*
    run write 1 > /dev/null || fail "the first checkpoint was not written"
    available=$(df --output=avail . | tail -1)
    dd if=/dev/zero of=filler bs=1k count=$((available - free)) 2> /dev/null
    must_fail run write 1
    echo "with $free kB free: in good order"
  done
fi
echo "pass"

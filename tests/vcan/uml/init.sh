#!/bin/bash
# The first process inside User-Mode-Linux: load the CAN modules, run the command, halt.
#
# / is that of the host, read only, under an overlay that is thrown away: whatever the command writes is gone
# afterwards. Started twice, first outside the overlay, then inside. $VEGRIP_JOB is the only folder really written.
halt() { sync; perl -e 'syscall(169, 0xfee1dead, 672274793, 0x4321fedc, 0)'; sleep 5; } # reboot(POWER_OFF)
end() { sync; echo "$1" >"$VEGRIP_JOB/code"; halt; }
load() { # with finit_module, because kmod may not be installed
  perl -e 'my $options = "";
    for (@ARGV) { open(F, "<", $_) && syscall(313, fileno(F), $options, 0) == 0 or die "$_: $!\n" }' \
    "${@/#/$VEGRIP_UML/modules/}"
}

if [ -z "$VEGRIP_INSIDE" ]; then
  mount -t proc proc /proc
  load overlay.ko || halt
  mount -t tmpfs overlay /run && mkdir /run/upper /run/work /run/root || halt
  mount -t overlay overlay -o lowerdir=/,upperdir=/run/upper,workdir=/run/work /run/root || halt
  for folder in proc dev; do mount --move /$folder /run/root/$folder; done
  export VEGRIP_INSIDE=1
  cd /run/root && exec chroot . /bin/bash "$VEGRIP_JOB/init"
  halt
fi

unset VEGRIP_INSIDE
mount -t sysfs sys /sys
mount -t tmpfs -o mode=755 run /run
mkdir -p /dev/pts /dev/shm /run/tmp
chmod 1777 /run/tmp
mount -t devpts -o mode=620,ptmxmode=666 devpts /dev/pts
mount -t tmpfs -o mode=1777 shm /dev/shm
ln -sfn /proc/self/fd /dev/fd
ln -sfn fd/0 /dev/stdin; ln -sfn fd/1 /dev/stdout; ln -sfn fd/2 /dev/stderr
mount -t hostfs -o "$VEGRIP_JOB" none "$VEGRIP_JOB" || halt

# The consoles must be raw, and the kernel makes them non-blocking: cat stands in between.
stty -F /dev/tty1 raw -echo
stty -F /dev/tty2 raw -echo
mkfifo /run/out /run/err
cat </run/out >/dev/tty1 & out=$!
cat </run/err >/dev/tty2 & err=$!
exec 6>/dev/tty2

load can.ko can-raw.ko can-bcm.ko can-dev.ko vcan.ko 2>&6 || end 125
mapfile -d '' arguments <"$VEGRIP_JOB/arguments"
mapfile -d '' environment <"$VEGRIP_JOB/environment"
cd "$(cat "$VEGRIP_JOB/folder")" 2>&6 || end 125
setsid -w env -i "${environment[@]}" TMPDIR=/run/tmp PYTHONDONTWRITEBYTECODE=1 "${arguments[@]}" \
  >/run/out 2>/run/err </dev/null 6>&-
code=$?
for _ in 1 2 3 4 5 6 7 8 9 10; do # let the output run dry; a daemon left over may hold it open
  kill -0 $out 2>/dev/null || kill -0 $err 2>/dev/null || break
  sleep 0.05
done
end $code

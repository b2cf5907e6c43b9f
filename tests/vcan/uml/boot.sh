#!/usr/bin/env bash
# Run a command inside User-Mode-Linux, whose files are those of this machine; what it writes is thrown away.
#
# usage: boot.sh SECONDS COMMAND...
#
# Ends with the code of the command: 128 + n when signal n ended it, 124 when the time was up, 125 when the
# kernel did not start.
set -u
here=$(cd "$(dirname "$0")" && pwd)
uml=$(cd "$here/../../.." && pwd)/build/user-mode-linux
memory=1536 # [MB]
seconds=$1
shift
"$here/fetch.sh" "$uml" || { echo "boot.sh: User-Mode-Linux cannot be fetched; is the Debian mirror reachable?" >&2; exit 125; }

# Where the processor has AMX its registers are larger than this kernel knows.
help=$uml/xstate.so
if ! grep -qw amx_tile /proc/cpuinfo; then
  help=
elif [ "$here/xstate.c" -nt "$help" ]; then
  ${CC:-cc} -O2 -shared -fPIC -o "$help.$$" "$here/xstate.c" -ldl && mv "$help.$$" "$help" ||
    { echo "boot.sh: this processor has AMX, for which a C compiler is needed here; install one or set CC" >&2; exit 125; }
fi

# The guest's memory is a file, mapped executable: of the shared memory if that is large enough.
room() { df --output=avail -m "$1" 2>/dev/null | tail -n 1; }
[ "$(room /dev/shm || echo 0)" -ge $memory ] && place=/dev/shm || place=${TMPDIR:-/tmp}

job=$(mktemp -d /var/tmp/vegrip-uml.XXXXXX)
trap 'rm -rf "$job"' EXIT
printf '%s\0' "$@" >"$job/arguments"
env -0 >"$job/environment"
pwd >"$job/folder"
cp "$here/init.sh" "$job/init"
chmod +x "$job/init"
exec 8> >(exec cat) 9> >(exec cat >&2) # the kernel makes its consoles non-blocking: never the caller's own
env -i PATH="$PATH" TMPDIR="$place" LD_PRELOAD="$help" setpriv --pdeathsig TERM timeout -k 3 "$seconds" "$uml/linux" \
  mem=${memory}M quiet loglevel=4 rootfstype=hostfs rootflags=/ ro panic=-1 \
  init="$job/init" VEGRIP_JOB="$job" VEGRIP_UML="$uml" \
  con=null con0=null,fd:2 con1=null,fd:8 con2=null,fd:9 ssl=null umid=u uml_dir="$job" \
  </dev/null >"$job/kernel.log" 2>&1 &
kernel=$!
told=
trap 'told=1; kill -TERM $kernel 2>/dev/null' TERM INT HUP
wait $kernel
code=$?
while kill -0 $kernel 2>/dev/null; do
  wait $kernel
  code=$?
done
exec 8>&- 9>&-
wait
[ -s "$job/code" ] && exit "$(cat "$job/code")"
[ $told ] && exit 143
if [ $code = 124 ] || [ $code = 137 ]; then
  echo "boot.sh: ended after $seconds s" >&2
  exit 124
fi
echo "boot.sh: the kernel did not start (code $code); it said:" >&2
tail -n 40 "$job/kernel.log" >&2
exit 125

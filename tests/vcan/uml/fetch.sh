#!/usr/bin/env bash
# Fetch and unpack User-Mode-Linux: a Linux kernel that is an ordinary program, with its CAN modules.
# Nothing is installed on this machine and no root is needed; it takes a few seconds, once.
#
# usage: fetch.sh FOLDER
set -euo pipefail
folder=${1:?folder}
version=6.1um4+b13
sha256=0ce700f835c385ab09860ad33137817402403a29e424177510244bd75a81c687
modules=(net/can/can.ko net/can/can-raw.ko net/can/can-bcm.ko drivers/net/can/dev/can-dev.ko
  drivers/net/can/vcan.ko fs/overlayfs/overlay.ko)

complete() { [ "$(cat "$folder/version" 2>/dev/null)" = "$version" ]; }

# From the package lists of this machine, else from lists of Debian 12 kept here. The checksum is what is trusted.
download() {
  apt-get -o APT::Sandbox::User=root download -q "user-mode-linux:amd64=$version" && return
  mkdir -p lists/partial
  echo "deb [trusted=yes arch=amd64] http://deb.debian.org/debian bookworm main" >sources
  local own=(-o APT::Sandbox::User=root -o Dir::State::lists="$PWD/lists" -o Dir::Etc::sourcelist="$PWD/sources" -o Dir::Etc::sourceparts=-
    -o Dir::Cache::pkgcache= -o Dir::Cache::srcpkgcache= -o APT::Architecture=amd64)
  apt-get "${own[@]}" update -q && apt-get "${own[@]}" download -q "user-mode-linux=$version"
}

complete && exit 0
[ "$(uname -m)" = x86_64 ] || { echo "fetch.sh: Debian's User-Mode-Linux is for x86_64, this is $(uname -m)" >&2; exit 1; }
mkdir -p "$(dirname "$folder")"
exec 7>"$folder.lock"
flock 7
complete && exit 0
rm -rf "$folder" "$folder.new"
mkdir -p "$folder.new/modules"
cd "$folder.new"
download >&2
echo "$sha256  $(echo user-mode-linux_*.deb)" | sha256sum -c - >&2
dpkg -x user-mode-linux_*.deb all
mv all/usr/bin/linux.uml linux
for module in "${modules[@]}"; do mv all/usr/lib/uml/modules/*/kernel/"$module" modules/; done
rm -rf all lists sources ./*.deb
echo "$version" >version
mv "$folder.new" "$folder"

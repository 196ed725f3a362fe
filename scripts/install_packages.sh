#!/usr/bin/env bash
# Installs the Debian packages of lists that are missing: install_packages.sh [LIST...], without
# arguments scripts/packages.txt. Needs root only when one is missing.
set -euo pipefail
cd "$(dirname "$0")/.."

[ $# -gt 0 ] || set -- scripts/packages.txt
packages=$(cat -- "$@")
missing=()
while read -r package; do
  case "$package" in ''|'#'*) continue ;; esac
  # Other builds of Node.js bring npm along, and refuse Debian's.
  if [ "$package" = npm ] && command -v npm > /dev/null; then continue; fi
  dpkg-query -W -f '${Status}' "$package" 2>/dev/null | grep -q 'install ok installed' ||
    missing+=("$package")
done <<< "$packages"
[ ${#missing[@]} -gt 0 ] || exit 0

if [ "$(id -u)" -ne 0 ]; then
  echo "pelage: these packages are missing; run as root, or: apt-get install ${missing[*]}" >&2
  exit 1
fi
echo "pelage: installing ${missing[*]}"
export DEBIAN_FRONTEND=noninteractive
apt-get update -q
apt-get install -y -q --no-install-recommends "${missing[@]}"

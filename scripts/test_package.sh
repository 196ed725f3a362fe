#!/usr/bin/env bash
# Tests the Debian package in an empty Debian 12: test_package.sh [PACKAGE.deb], as root. Without a package
# it makes one. lintian checks it; then a new root in a temporary folder installs it with its dependencies by
# apt, and builds and runs programs against it as a project would. PELAGE_MIRROR is the mirror of Debian;
# PELAGE_TEST_ROOT keeps the root and is used again.
set -euo pipefail
cd "$(dirname "$0")/.."
[ "$(id -u)" -eq 0 ] || { echo "test_package.sh: run as root, for chroot" >&2; exit 1; }
step() { printf '\n=== %s (%d s)\n' "$1" "$SECONDS"; }
mirror=${PELAGE_MIRROR:-http://deb.debian.org/debian}

bash scripts/install_packages.sh scripts/packages_deb.txt
if [ $# -eq 0 ]; then
  step "package"
  bash scripts/package.sh -DCMAKE_UNITY_BUILD=ON -DCMAKE_UNITY_BUILD_BATCH_SIZE=12
  set -- build/package/libpelage-dev_*.deb
fi
deb=$1
step "lintian"
lintian --fail-on warning --allow-root "$deb"

if [ -n "${PELAGE_TEST_ROOT:-}" ]; then
  root=$PELAGE_TEST_ROOT
else
  root=$(mktemp -d)
  chmod 755 "$root"  # apt reads as a user of its own
fi
in_root() { chroot "$root" /usr/bin/env -i PATH=/usr/sbin:/usr/bin:/sbin:/bin HOME=/root LC_ALL=C.UTF-8 "$@"; }
cleanup() {
  ! mountpoint -q "$root/proc" || umount "$root/proc"
  [ -n "${PELAGE_TEST_ROOT:-}" ] || rm -rf --one-file-system "$root"
}
trap cleanup EXIT

step "root"
[ -e "$root/etc/debian_version" ] || debootstrap --variant=minbase bookworm "$root" "$mirror" >"$root.log" ||
  { tail "$root.log"; exit 1; }
rm -f "$root.log"
mount -t proc proc "$root/proc"

step "install"
cp "$deb" "$root/tmp/pelage.deb"
in_root DEBIAN_FRONTEND=noninteractive sh -ec 'apt-get update -qq
apt-get install -y -qq --no-install-recommends /tmp/pelage.deb >/tmp/apt.log 2>&1 || { tail /tmp/apt.log; exit 1; }
apt-get install -y -qq --no-install-recommends g++ cmake ninja-build pkg-config >>/tmp/apt.log 2>&1'

step "build and run"
rm -rf "$root/consumer"
cp -r tests/consumer "$root/consumer"
in_root sh -ec 'cd /consumer
pelage-convert --version
pelage-bake --version
pelage-codegen --help >/dev/null
# With only what the package depends on: all components are found.
cmake -S components -B build/components -G Ninja && cmake --build build/components
build/components/kernels_only
cmake -S tutorial -B build/tutorial -G Ninja -DCMAKE_BUILD_TYPE=Release && cmake --build build/tutorial
build/tutorial/print_asset
build/tutorial/print_frame
# A kernel of the project, by the pelage-codegen of the package.
cmake -S project -B build/project -G Ninja -DCMAKE_BUILD_TYPE=Release && cmake --build build/project
build/project/kernels_only
c++ -std=c++20 -o build/kernels_only project/kernels_only.cpp $(pkg-config --cflags --libs pelage-spirv)
build/kernels_only
c++ -std=c++20 -o build/scene pkgconfig/scene.cpp $(pkg-config --cflags --libs pelage-vulkan)
build/scene
cc -std=c99 -o build/c_scene c/main.c $(pkg-config --cflags --libs pelage-c)
build/c_scene
c++ -std=c++20 -o build/authoring pkgconfig/authoring.cpp $(pkg-config --cflags --libs pelage-authoring)
printf "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n" >triangle.obj
build/authoring triangle.obj
DEBIAN_FRONTEND=noninteractive apt-get purge -y -qq libpelage-dev >/dev/null 2>&1
! find /usr -path "*pelage*" | grep .'
step "done"

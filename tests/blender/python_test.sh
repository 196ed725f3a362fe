#!/usr/bin/env bash
# Runs python_test.sh FILE by the first Python that has numpy; exits with 77, "skipped", without one.
set -euo pipefail
for python in python3 /usr/bin/python3; do
  if "$python" -c 'import numpy' 2> /dev/null; then
    exec "$python" -B "$1"
  fi
done
echo "skipped: no python3 with numpy (Debian's package python3-numpy)"
exit 77

#!/usr/bin/env bash
# Runs core_test.py by the first Python that has numpy; exits with 77, "skipped", without one.
set -euo pipefail
for python in python3 /usr/bin/python3; do
  if "$python" -c 'import numpy' 2> /dev/null; then
    exec "$python" -B "$(dirname "$0")/core_test.py"
  fi
done
echo "skipped: no python3 with numpy (Debian's package python3-numpy)"
exit 77

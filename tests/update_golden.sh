#!/usr/bin/env bash
# Rewrites what is generated and kept; review the result as a diff.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."
tests/support/setup sightline
build/compiler/driver/sightline passes --schema > schemas/config.schema.json

# The help of every verb.
mkdir -p tests/golden/help
rm -f tests/golden/help/*.txt
for verb in $(build/compiler/driver/sightline help | sed -n 's/^  \([a-z]*\)  .*/\1/p'); do
  build/compiler/driver/sightline help "$verb" > "tests/golden/help/$verb.txt"
done

#!/usr/bin/env bash
# Rewrites what is generated and kept: the published schema, and the golden texts of tests/golden.
# Says what changed of the golden texts and why; review all of it as a diff.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."
tests/support/setup sightline golden_test
build/compiler/driver/sightline passes --schema > schemas/config.schema.json
towns=build/tests/golden/towns
build/tests/golden/golden_test --write-towns "$towns"
build/tests/golden/golden_test --towns "$towns" --update

# The help of every verb, of families also the list of their verbs: cluster.txt, cluster-plan.txt.
mkdir -p tests/golden/help
rm -f tests/golden/help/*.txt
verbs_in() { build/compiler/driver/sightline help "$@" | sed -n 's/^  \([a-z]*\)  .*/\1/p'; }
for verb in $(verbs_in); do
  build/compiler/driver/sightline help "$verb" > "tests/golden/help/$verb.txt"
done
for family in cluster delta fleet; do
  for verb in $(verbs_in "$family"); do
    build/compiler/driver/sightline help "$family" "$verb" > "tests/golden/help/$family-$verb.txt"
  done
done

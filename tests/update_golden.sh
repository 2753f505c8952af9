#!/usr/bin/env bash
# Rewrites what is generated and kept; review the result as a diff.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."
tests/support/setup sightline
build/compiler/driver/sightline passes --schema > schemas/config.schema.json

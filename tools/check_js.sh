#!/usr/bin/env bash
# Checks the types of the viewer's scripts strictly, with the compiler of TypeScript; part of `make lint`.
# Needs Node, which nothing else of taut does: where it is missing, or the compiler cannot be fetched, this says so and is content.
set -euo pipefail
cd "$(dirname "$0")/page"
typescript=typescript@5.9.3
if ! command -v npx > /dev/null; then
    echo "the viewer's scripts are not checked: there is no npx (Node)"
elif ! npx --yes --package "$typescript" tsc --version > /dev/null 2>&1; then
    echo "the viewer's scripts are not checked: npx cannot fetch $typescript"
else
    npx --yes --package "$typescript" tsc --project tsconfig.json
fi

#!/usr/bin/env bash
# Brings three.js, in the version that tests/viewer/package-lock.json pins, to where the service's page has it. It is served as it
# comes but for the name by which its files import each other, so that the page needs no map of imports.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."
tests/viewer/setup.sh
from=tests/viewer/node_modules/three
to=service/page/three
rm -rf "$to"
mkdir -p "$to"/{controls,loaders,utils}
cp "$from"/build/three.{core,module}.js "$from/LICENSE" "$to/"
for file in controls/OrbitControls loaders/GLTFLoader utils/BufferGeometryUtils utils/SkeletonUtils; do
  sed "s#from 'three'#from '../three.module.js'#" "$from/examples/jsm/$file.js" >"$to/$file.js"
done
echo "three.js $(node -p "require('./$from/package.json').version") in $to"

// Loads a glTF file with three.js as it comes and says what it shows. Nothing in here knows who wrote the file.
import * as THREE from 'three';
import { GLTFLoader } from 'three/addons/loaders/GLTFLoader.js';

const VARIANTS = 'KHR_materials_variants';

// three.js leaves the switching of variants to its user; this is the way its own example goes.
async function choose(gltf, name) {
  const names = (gltf.userData.gltfExtensions?.[VARIANTS]?.variants ?? []).map((v) => v.name);
  const number = names.indexOf(name);
  if (number < 0) throw new Error(`the file has no variant ${name}, but ${names}`);
  const meshes = [];
  gltf.scene.traverse((object) => object.isMesh && meshes.push(object));
  for (const mesh of meshes) {
    const mappings = mesh.userData.gltfExtensions?.[VARIANTS]?.mappings ?? [];
    const mapping = mappings.find((m) => m.variants.includes(number));
    if (mapping) {
      mesh.material = await gltf.parser.getDependency('material', mapping.material);
      gltf.parser.assignFinalMaterial(mesh);
    }
  }
}

function describe(gltf) {
  const textures = new Set();
  const report = { meshes: 0, triangles: 0, unlit: 0, largest: 0 };
  gltf.scene.traverse((object) => {
    if (!object.isMesh) return;
    report.meshes += 1;
    report.triangles += object.geometry.index.count / 3;
    report.unlit += object.material.isMeshBasicMaterial ? 1 : 0;
    if (object.material.map) textures.add(object.material.map);
  });
  for (const map of textures) {
    report.largest = Math.max(report.largest, map.image.width, map.image.height);
  }
  const variants = gltf.userData.gltfExtensions?.[VARIANTS]?.variants ?? [];
  return { ...report, textures: textures.size, variants: variants.map((v) => v.name) };
}

// What is named at a place is what a ray from the eye meets there, so that nobody measures a wall behind.
function read(renderer, scene, camera, point) {
  const place = new THREE.Vector3(...point);
  const seen = place.clone().project(camera);
  const context = renderer.getContext();
  const pixel = new Uint8Array(4);
  const x = Math.floor((0.5 + 0.5 * seen.x) * context.drawingBufferWidth);
  const y = Math.floor((0.5 + 0.5 * seen.y) * context.drawingBufferHeight);
  context.readPixels(x, y, 1, 1, context.RGBA, context.UNSIGNED_BYTE, pixel);
  const ray = new THREE.Raycaster();
  ray.setFromCamera(new THREE.Vector2(seen.x, seen.y), camera);
  const hit = ray.intersectObject(scene, true)[0];
  return {
    colour: [...pixel.slice(0, 3)],
    object: hit?.object.name ?? null,
    distance: hit ? hit.point.distanceTo(place) : null,
  };
}

window.show = async ({ model, variant, width, height, eye, target, angle, points }) => {
  const gltf = await new GLTFLoader().loadAsync(model);
  if (variant) await choose(gltf, variant);
  const renderer = new THREE.WebGLRenderer({ preserveDrawingBuffer: true });
  renderer.setPixelRatio(1);
  renderer.setSize(width, height);
  document.body.replaceChildren(renderer.domElement);
  const camera = new THREE.PerspectiveCamera(angle, width / height, 0.05, 1000);
  camera.position.set(...eye);
  camera.lookAt(...target);
  camera.updateMatrixWorld();
  gltf.scene.updateMatrixWorld(true);
  const scene = new THREE.Scene();
  scene.add(gltf.scene);
  renderer.render(scene, camera);
  const report = {
    ...describe(gltf),
    points: points.map((point) => read(renderer, gltf.scene, camera, point)),
    glError: renderer.getContext().getError(),
    png: renderer.domElement.toDataURL('image/png'),
  };
  renderer.dispose();
  return report;
};
window.ready = true;

// A baked room to walk through: its meshes with their lux maps, mixed by light group, in false colours with isolux lines, and what
// the map says at a place. Nothing is computed here but sums; every number is a lumel of the job's own files.
import * as THREE from './three/three.module.js';
import { OrbitControls } from './three/controls/OrbitControls.js';
import { GLTFLoader } from './three/loaders/GLTFLoader.js';
import { readNpy } from './npy.js';

// Number of the first tile (UDIM).
const FIRST_TILE = 1001;

// Of a walk. [m]
const STEP = 0.12;

const VERTEX = `
varying vec2 place;
void main() {
  // The lowest row is the first of the map, and glTF counts from the top.
  place = vec2(uv.x, 1.0 - uv.y);
  gl_Position = projectionMatrix * modelViewMatrix * vec4(position, 1.0);
}`;

const FRAGMENT = `
uniform sampler2D lux;
uniform sampler2D palette;
uniform float top;
uniform float interval;
uniform bool isLight;
varying vec2 place;

vec3 encode(vec3 value) {
  return mix(12.92 * value, 1.055 * pow(value, vec3(1.0 / 2.4)) - 0.055, step(0.0031308, value));
}

void main() {
  float value = texture2D(lux, place).r;
  float share = clamp(value / top, 0.0, 1.0);
  vec3 colour = isLight ? encode(vec3(share)) : texture2D(palette, vec2(share, 0.5)).rgb;
  if (interval > 0.0) {
    float near = abs(fract(value / interval - 0.5) - 0.5) * interval;
    float width = fwidth(value);
    if (near < 0.75 * width && width < 0.5 * interval) colour = isLight ? vec3(0.9, 0.7, 0.1) : vec3(1.0);
  }
  gl_FragColor = vec4(colour, 1.0);
}`;

const VERDICTS = 'verdicts.json';

const ARRAY = /^(illuminance|standard_error|covered)(?:_(.+))?\.(\d+)\.npy$/;

// Loads what a bake has written; told(share) hears of it.
export async function loadRoom(api, job, told) {
  const { files } = await api.get(`/jobs/${job.id}/files`);
  const names = files.map((file) => file.name);
  const judged = names.filter((name) => name === VERDICTS);
  const fetched = ['lux.glb', 'report.json', ...judged, ...names.filter((name) => ARRAY.test(name))];
  const missing = fetched.filter((name) => !names.includes(name));
  if (missing.length) throw new Error(`the job has no ${missing.join(', ')}`);
  let done = 0;
  const content = {};
  for (const name of fetched) {
    content[name] = await api.file(job.id, name);
    told((done += 1) / fetched.length);
  }
  const parse = (name) => JSON.parse(new TextDecoder().decode(content[name]));
  const report = parse('report.json');
  const verdicts = judged.length ? parse(VERDICTS) : null;
  const gltf = await new GLTFLoader().parseAsync(content['lux.glb'], '');
  const pages = readPages(content);
  return { job, report, verdicts, gltf, pages, groups: [...new Set([...pages.values()].flatMap((page) => [...page.groups.keys()]))] };
}

// Pages by their numbers, with the illuminance that is shown, as computed and by group, its error, and where it was computed.
function readPages(content) {
  const pages = new Map();
  for (const [name, buffer] of Object.entries(content)) {
    const [, kind, group, tile] = ARRAY.exec(name) ?? [];
    if (!kind) continue;
    const number = Number(tile) - FIRST_TILE;
    const { width, height, values } = readNpy(buffer);
    const page = pages.get(number) ?? { number, width, height, groups: new Map() };
    pages.set(number, page);
    if (group) page.groups.set(group, values);
    else page[kind] = values;
  }
  for (const page of pages.values()) page.lux = page.illuminance.slice();
  return pages;
}

export class Room {
  // host: element that is filled; watch(probe) hears of what is under the pointer, moved() of a moved eye.
  constructor(host, loaded, { watch, moved }) {
    this.loaded = loaded;
    this.watch = watch;
    this.host = host;
    this.factors = new Map(loaded.groups.map((name) => [name, 1]));
    this.renderer = new THREE.WebGLRenderer({ antialias: true, preserveDrawingBuffer: true });
    this.renderer.outputColorSpace = THREE.LinearSRGBColorSpace;
    this.renderer.setPixelRatio(Math.min(devicePixelRatio, 2));
    host.append(this.renderer.domElement);
    this.mark = document.createElement('i');
    this.mark.className = 'mark';
    this.mark.hidden = true;
    host.append(this.mark);
    this.shared = { top: { value: 1 }, interval: { value: 0 }, isLight: { value: false }, palette: { value: null } };
    this.scene = new THREE.Scene();
    this.scene.background = new THREE.Color(0x181a1f);
    this.meshes = this.dress();
    this.scene.add(loaded.gltf.scene);
    loaded.gltf.scene.updateMatrixWorld(true);
    this.camera = new THREE.PerspectiveCamera(65, 1, 0.02, 2000);
    this.controls = new OrbitControls(this.camera, this.renderer.domElement);
    this.controls.addEventListener('change', () => {
      this.draw();
      moved(this);
    });
    this.listen();
    this.stand();
    this.fit = new ResizeObserver(() => this.resize());
    this.fit.observe(host);
    this.resize();
  }

  // Gives every mesh the lux map of its page; what stays without has no probe, and its own look.
  dress() {
    const meshes = [];
    const { json } = this.loaded.gltf.parser;
    this.loaded.gltf.scene.traverse((object) => {
      if (!object.isMesh) return;
      const texture = pageTexture(this.loaded.gltf, object, json);
      const page = texture && this.loaded.pages.get(texture.pages[0]);
      if (!page) return;
      if (texture.colours && !this.shared.palette.value) this.shared.palette.value = paletteOf(texture.colours);
      page.texture ??= textureOf(page);
      object.material = new THREE.ShaderMaterial({
        vertexShader: VERTEX,
        fragmentShader: FRAGMENT,
        side: THREE.DoubleSide,
        uniforms: { ...this.shared, lux: { value: page.texture } },
      });
      object.userData.page = page;
      meshes.push(object);
    });
    return meshes;
  }

  get colours() {
    return this.shared.palette.value.userData.colours;
  }

  // The eye stands at a corner of the room, 1.6 m above the floor, and looks through it.
  stand() {
    const box = new THREE.Box3().setFromObject(this.loaded.gltf.scene);
    const size = box.getSize(new THREE.Vector3());
    const eye = Math.min(box.min.y + 1.6, box.max.y - 0.1 * size.y);
    const isFlat = size.y < 0.2 * Math.max(size.x, size.z);
    const height = isFlat ? box.max.y + 0.6 * Math.max(size.x, size.z) : eye;
    this.camera.position.set(box.min.x + 0.12 * size.x, height, box.max.z - 0.12 * size.z);
    this.controls.target.set(box.max.x - 0.4 * size.x, isFlat ? box.min.y : eye - 0.15 * size.y, box.min.z + 0.4 * size.z);
    this.controls.update();
  }

  listen() {
    const canvas = this.renderer.domElement;
    canvas.tabIndex = 0;
    canvas.addEventListener('pointermove', (event) => event.pointerType === 'mouse' && this.watch(this.probe(event)));
    canvas.addEventListener('pointerdown', (event) => {
      canvas.focus();
      this.watch(this.probe(event));
    });
    canvas.addEventListener('keydown', (event) => this.walk(event));
  }

  // Arrow keys and W, A, S, D walk, Q and E go down and up.
  walk(event) {
    const ways = {
      w: [0, 0, 1], arrowup: [0, 0, 1], s: [0, 0, -1], arrowdown: [0, 0, -1], a: [-1, 0, 0], arrowleft: [-1, 0, 0],
      d: [1, 0, 0], arrowright: [1, 0, 0], q: [0, -1, 0], e: [0, 1, 0],
    };
    const way = ways[event.key.toLowerCase()];
    if (!way) return;
    event.preventDefault();
    const ahead = this.controls.target.clone().sub(this.camera.position).setY(0).normalize();
    const right = ahead.clone().cross(this.camera.up);
    const move = right.multiplyScalar(way[0]).addScaledVector(this.camera.up, way[1]).addScaledVector(ahead, way[2]);
    const stride = STEP * (event.shiftKey ? 4 : 1);
    this.camera.position.addScaledVector(move, stride);
    this.controls.target.addScaledVector(move, stride);
    this.controls.update();
  }

  // What the map says under the pointer: the lumel itself, as the file has it, times the levels of the groups.
  probe(event) {
    const frame = this.renderer.domElement.getBoundingClientRect();
    const seen = new THREE.Vector2(
      (2 * (event.clientX - frame.left)) / frame.width - 1,
      1 - (2 * (event.clientY - frame.top)) / frame.height,
    );
    const ray = new THREE.Raycaster();
    ray.setFromCamera(seen, this.camera);
    const hit = ray.intersectObject(this.loaded.gltf.scene, true)[0];
    const page = hit?.object.userData.page;
    if (!page) return null;
    const column = Math.min(Math.floor(hit.uv.x * page.width), page.width - 1);
    // Rows are from the bottom, and glTF counts from the top.
    const row = Math.min(Math.floor((1 - hit.uv.y) * page.height), page.height - 1);
    const at = row * page.width + column;
    return {
      place: hit.point,
      object: (hit.object.parent?.isMesh === false && hit.object.parent.name) || hit.object.name,
      lux: page.lux[at],
      error: page.standard_error[at] * this.largest,
      isCovered: page.covered[at] > 0,
      page: page.number,
      column,
      row,
    };
  }

  // Of the levels: the errors of single groups are not kept, so that of the whole times this is a bound.
  get largest() {
    return Math.max(0, ...(this.factors.size ? this.factors.values() : [1]));
  }

  get isMixed() {
    return [...this.factors.values()].some((factor) => factor !== 1);
  }

  mix(name, factor) {
    this.factors.set(name, factor);
    for (const page of this.loaded.pages.values()) {
      if (this.isMixed) {
        page.lux.fill(0);
        for (const [group, lux] of page.groups) {
          const level = this.factors.get(group);
          if (level) for (let i = 0; i < lux.length; i += 1) page.lux[i] += level * lux[i];
        }
      } else page.lux.set(page.illuminance);
      if (page.texture) page.texture.needsUpdate = true;
    }
    this.draw();
  }

  show({ top, interval, isLight }) {
    this.shared.top.value = top;
    this.shared.interval.value = interval;
    this.shared.isLight.value = isLight;
    this.draw();
  }

  follow(other) {
    this.camera.position.copy(other.camera.position);
    this.camera.quaternion.copy(other.camera.quaternion);
    this.controls.target.copy(other.controls.target);
    this.draw();
  }

  point(place) {
    this.marked = place;
    this.placeMark();
  }

  placeMark() {
    const seen = this.marked?.clone().project(this.camera);
    this.mark.hidden = !seen || seen.z > 1 || Math.abs(seen.x) > 1 || Math.abs(seen.y) > 1;
    if (this.mark.hidden) return;
    this.mark.style.left = `${50 + 50 * seen.x}%`;
    this.mark.style.top = `${50 - 50 * seen.y}%`;
  }

  // The value of a place in this room, for two designs side by side.
  at(place) {
    const frame = this.renderer.domElement.getBoundingClientRect();
    const seen = place.clone().project(this.camera);
    return this.probe({
      clientX: frame.left + (0.5 + 0.5 * seen.x) * frame.width,
      clientY: frame.top + (0.5 - 0.5 * seen.y) * frame.height,
    });
  }

  resize() {
    const { clientWidth: width, clientHeight: height } = this.host;
    if (!width || !height) return;
    this.renderer.setSize(width, height, false);
    this.camera.aspect = width / height;
    this.camera.updateProjectionMatrix();
    this.draw();
  }

  draw() {
    this.renderer.render(this.scene, this.camera);
    this.placeMark();
  }

  close() {
    this.fit.disconnect();
    this.controls.dispose();
    this.renderer.dispose();
    this.host.remove();
  }
}

// What the file says of the texture that a mesh wears: only a page as it is leads from a place to its lumel.
function pageTexture(gltf, mesh, json) {
  const texture = mesh.material.map && gltf.parser.associations.get(mesh.material.map);
  const variants = json.textures ?? [];
  const extras = texture && variants[texture.textures]?.extras;
  if (!extras || extras.pages.length !== 1 || extras.lumels_per_texel !== 1) return null;
  const colours = variants.find((each) => each.extras?.colours)?.extras.colours;
  return { pages: extras.pages, colours };
}

function textureOf(page) {
  const texture = new THREE.DataTexture(page.lux, page.width, page.height, THREE.RedFormat, THREE.FloatType);
  texture.minFilter = texture.magFilter = THREE.LinearFilter;
  texture.flipY = false;
  texture.needsUpdate = true;
  return texture;
}

function paletteOf(colours) {
  const count = 256;
  const data = new Uint8Array(count * 4);
  const stops = colours.map((text) => [1, 3, 5].map((k) => parseInt(text.slice(k, k + 2), 16)));
  for (let i = 0; i < count; i += 1) {
    const at = (i / (count - 1)) * (stops.length - 1);
    const low = Math.min(Math.floor(at), stops.length - 2);
    for (let k = 0; k < 3; k += 1) data[4 * i + k] = stops[low][k] + (at - low) * (stops[low + 1][k] - stops[low][k]);
    data[4 * i + 3] = 255;
  }
  const texture = new THREE.DataTexture(data, count, 1);
  texture.minFilter = texture.magFilter = THREE.LinearFilter;
  texture.needsUpdate = true;
  texture.userData = { colours };
  return texture;
}

// Draws NDs as ellipsoids, the vehicle, returns and a ring of its range in 3D. Metres along map axes from the site that is shown,
// z up. A bundle of its own: it is unpacked when the view is first opened. It draws when something changes, not all the time.

import {
  AmbientLight, BufferGeometry, Color, ConeGeometry, DirectionalLight, Float32BufferAttribute, InstancedMesh, LineBasicMaterial,
  LineLoop, Matrix4, Mesh, MeshBasicMaterial, MeshLambertMaterial, PerspectiveCamera, Points, PointsMaterial, Scene, SphereGeometry,
  WebGLRenderer,
} from "three";
import { OrbitControls } from "three/addons/controls/OrbitControls.js";
import { halfAxes } from "./half_axes.js";

const sphereSides = [8, 6];  // few: thousands of NDs are also drawn without a GPU
const ringSides = 180;
const [first_m, height_m] = [34, 22];  // of the camera behind and above the vehicle, at first

function ellipsoidsOf(nds) {
  const mesh = new InstancedMesh(new SphereGeometry(1, ...sphereSides), new MeshLambertMaterial(), nds.length);
  const matrix = new Matrix4();
  nds.forEach((nd, i) => {
    const [a, b, c] = halfAxes(nd);
    const [x, y, z] = nd.p_m;
    mesh.setMatrixAt(i, matrix.set(a[0], b[0], c[0], x, a[1], b[1], c[1], y, a[2], b[2], c[2], z, 0, 0, 0, 1));
  });
  return mesh;
}

function positions(values) {
  return new BufferGeometry().setAttribute("position", new Float32BufferAttribute(values, 3));
}

function ringOf(range_m) {
  const turns = Array.from({ length: ringSides }, (_, i) => (2 * Math.PI * i) / ringSides);
  return new LineLoop(positions(turns.flatMap((turn) => [range_m * Math.cos(turn), range_m * Math.sin(turn), 0])), new LineBasicMaterial());
}

function vehicleOf(heading_rad) {
  const cone = new Mesh(new ConeGeometry(0.8, 2.6, 16), new MeshBasicMaterial());
  cone.rotation.z = heading_rad - Math.PI / 2;  // a cone's tip is at +y
  return cone;
}

function cameraControls(camera, canvas, render) {
  const controls = new OrbitControls(camera, canvas);
  Object.assign(controls, { enableZoom: false, minDistance: 3, maxDistance: 300, maxPolarAngle: Math.PI / 2 });
  controls.addEventListener("change", render);
  return controls;
}

// turn(azimuth_rad, down_rad) and zoom(factor) move the camera about the vehicle.
function cameraMoves(camera, controls) {
  const from = () => camera.position.clone().sub(controls.target);
  const put = (offset) => {
    camera.position.copy(controls.target).add(offset);
    controls.update();
  };
  return {
    zoom: (factor) => put(from().multiplyScalar(factor)),
    turn: (azimuth_rad, down_rad) => {
      const offset = from();
      const distance_m = offset.length();
      const azimuth = Math.atan2(offset.y, offset.x) + azimuth_rad;
      const polar = Math.min(Math.max(Math.acos(offset.z / distance_m) + down_rad, 0.05), Math.PI / 2);
      put(offset.set(Math.sin(polar) * Math.cos(azimuth), Math.sin(polar) * Math.sin(azimuth), Math.cos(polar)).multiplyScalar(distance_m));
    },
  };
}

function emptyScene() {
  const scene = new Scene();
  const sun = new DirectionalLight(0xffffff, 2);
  sun.position.set(0.5, 0.3, 1);
  scene.add(new AmbientLight(0xffffff, 1.4), sun);
  return scene;
}

// However often it is called, it acts once for each picture of the screen.
function onceAFrame(act) {
  let isDue = false;
  return () => {
    if (!isDue) requestAnimationFrame(() => { isDue = false; act(); });
    isDue = true;
  };
}

// Null where the browser has no WebGL.
export function createScene(canvas) {
  const context = canvas.getContext("webgl2", { alpha: true, antialias: true });
  if (!context) return null;
  const renderer = new WebGLRenderer({ canvas, context, alpha: true });
  const camera = new PerspectiveCamera(50, 1, 0.5, 700);
  camera.up.set(0, 0, 1);
  const scene = emptyScene();
  const drawNow = () => renderer.render(scene, camera);
  const render = onceAFrame(drawNow);
  const controls = cameraControls(camera, canvas, render);
  const shown = {};
  const put = (name, object) => {
    if (shown[name]) {
      scene.remove(shown[name]);
      for (const part of [shown[name].geometry, shown[name].material]) part.dispose();
      shown[name].dispose?.();
    }
    shown[name] = object;
    scene.add(object);
  };
  let kinds = [];
  return {
    ...cameraMoves(camera, controls), drawNow, shown,
    show({ nds, heading_rad, range_m, returns_m }) {
      if (!shown.nds) camera.position.set(-first_m * Math.cos(heading_rad), -first_m * Math.sin(heading_rad), height_m);
      kinds = nds.map((nd) => nd.kind);
      put("nds", ellipsoidsOf(nds));
      put("ring", ringOf(range_m));
      put("vehicle", vehicleOf(heading_rad));
      put("returns", new Points(positions(returns_m), new PointsMaterial({ size: 2.5, sizeAttenuation: false })));
      controls.update();
    },
    // Of each kind of ND, and of the rest.
    paint(ofKind, { ring, vehicle, returns }) {
      const colours = Object.fromEntries(Object.entries(ofKind).map(([kind, colour]) => [kind, new Color(colour)]));
      kinds.forEach((kind, i) => shown.nds.setColorAt(i, colours[kind]));
      if (kinds.length > 0) shown.nds.instanceColor.needsUpdate = true;
      shown.ring.material.color.set(ring);
      shown.vehicle.material.color.set(vehicle);
      shown.returns.material.color.set(returns);
      render();
    },
    resize(width, height) {
      renderer.setPixelRatio(Math.min(devicePixelRatio, 2));
      renderer.setSize(width, height, false);
      camera.aspect = width / height;
      camera.updateProjectionMatrix();
      render();
    },
    letWheelZoom(isOn) { controls.enableZoom = isOn; },
  };
}

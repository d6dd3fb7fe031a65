// Plays body.glb: open player.html?view=... through `play.mjs`, or any static server that also serves three as /three.
//
// view: JSON {centre, seenFrom, shows, width, height}: an orthographic camera in Blender's axes (Z up), in m and pixels.
// Without it, the clip plays repeatedly.

import * as THREE from "three";
import { OrbitControls } from "three/addons/controls/OrbitControls.js";
import { GLTFLoader } from "three/addons/loaders/GLTFLoader.js";

const given = new URLSearchParams(location.search).get("view");
const view = given
  ? JSON.parse(given)
  : { centre: [0, 0, 0.9], seenFrom: [-0.3, -1, 0.1], shows: 2, width: innerWidth, height: innerHeight };
// Y is up in glTF, Z in Blender
const fromBlender = ([x, y, z]) => new THREE.Vector3(x, z, -y);

const renderer = new THREE.WebGLRenderer({ antialias: true, preserveDrawingBuffer: true });
renderer.setSize(view.width, view.height);
document.body.append(renderer.domElement);
document.body.append(Object.assign(document.createElement("p"), { textContent: "three.js in Chromium" }));
const scene = new THREE.Scene();
scene.background = new THREE.Color(0x6e7279);
const sun = new THREE.DirectionalLight(0xffffff, 2.6);
sun.position.copy(fromBlender([-1.5, -2.5, 3]));
scene.add(sun, new THREE.HemisphereLight(0xdfe8ff, 0x554a40, 1.1));

const perPixel = view.shows / Math.max(view.width, view.height) / 2;
const [right, top] = [view.width * perPixel, view.height * perPixel];
const camera = new THREE.OrthographicCamera(-right, right, top, -top, 0.01, 20);
const centre = fromBlender(view.centre);
camera.position.copy(fromBlender(view.seenFrom)).setLength(5).add(centre);
camera.lookAt(centre);

const { scene: body, animations } = await new GLTFLoader().loadAsync("/body.glb");
scene.add(body);
const skins = [];
body.traverse((found) => found.isSkinnedMesh && skins.push(found));
const skinMaterial = new THREE.MeshStandardMaterial({ color: 0xd2a58f, roughness: 0.55 });
for (const skin of skins) {
  skin.material = skinMaterial;
  skin.frustumCulled = false; // three.js knows only the bounds at rest
}
const mixer = new THREE.AnimationMixer(body);
for (const clip of animations) mixer.clipAction(clip).play();

function show(seconds) {
  mixer.setTime(seconds);
  scene.updateMatrixWorld(true);
  renderer.render(scene, camera);
}

// [x, y, z, x, ...] of all vertices at a time, in Blender's axes, morphed and skinned by three.js.
window.pointsAt = (seconds) => {
  show(seconds);
  const points = [];
  const point = new THREE.Vector3();
  for (const skin of skins) {
    skin.skeleton.update();
    for (let vertex = 0; vertex < skin.geometry.attributes.position.count; vertex++) {
      skin.getVertexPosition(vertex, point).applyMatrix4(skin.matrixWorld);
      points.push(point.x, -point.z, point.y);
    }
  }
  return points;
};
window.report = {
  three: THREE.REVISION,
  clips: animations.map((clip) => ({ name: clip.name, seconds: clip.duration, tracks: clip.tracks.length })),
  vertices: skins.reduce((sum, skin) => sum + skin.geometry.attributes.position.count, 0),
  morphs: skins.reduce((sum, skin) => sum + (skin.morphTargetInfluences?.length ?? 0), 0),
  bones: skins.reduce((sum, skin) => sum + skin.skeleton.bones.length, 0),
};
window.show = show;

if (given) show(0);
else {
  const controls = new OrbitControls(camera, renderer.domElement);
  controls.target.copy(centre);
  renderer.setAnimationLoop((milliseconds) => {
    controls.update();
    show(animations.length ? (milliseconds / 1000) % animations[0].duration : 0);
  });
}
window.isReady = true;

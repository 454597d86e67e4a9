// A .glb on bones as three.js plays it, without a browser: what the file says, for those that play it too.
import {readFileSync} from 'node:fs';
import {AnimationMixer, Vector3} from 'three';
import {MeshoptDecoder} from 'three/addons/libs/meshopt_decoder.module.js';
import {GLTFLoader} from 'three/addons/loaders/GLTFLoader.js';

export function readGltf(path) {
  const bytes = new Uint8Array(readFileSync(path));
  return new GLTFLoader().setMeshoptDecoder(MeshoptDecoder).parseAsync(bytes.buffer, '');
}

export function skinsIn(scene) {
  const skins = [];
  scene.traverse((object) => { if (object.isSkinnedMesh) skins.push(object); });
  return skins;
}

// World positions [[x, y, z], …] of all vertices, z up, in the order of the primitives.
export function verticesOf(scene) {
  scene.updateMatrixWorld(true);
  return skinsIn(scene).flatMap((skin) => Array.from({length: skin.geometry.attributes.position.count}, (_, i) => {
    const p = skin.getVertexPosition(i, new Vector3()).applyMatrix4(skin.matrixWorld);
    return [p.x, -p.z, p.y];
  }));
}

export async function openSkin(path) {
  const {scene, animations} = await readGltf(path);
  const skins = skinsIn(scene), mixer = new AnimationMixer(scene);
  const numbers = (name) => skins.flatMap(({geometry}) => Array.from(geometry.attributes[name].array));
  const corners = [];  // of the triangles of bark
  let before = 0;
  for (const {geometry, material} of skins) {
    for (const corner of material.name === 'bark' ? geometry.index.array : []) corners.push(before + corner);
    before += geometry.attributes.position.count;
  }
  return {
    scene, animations, corners,
    joints: skins[0].skeleton.bones.length,
    rest: verticesOf(scene),
    branch: numbers('_branch'),
    along: numbers('_along'),
    // Where everything is at these seconds of a clip.
    pose(name, time) {
      mixer.stopAllAction();
      mixer.clipAction(animations.find((clip) => clip.name === name)).reset().play();
      mixer.setTime(time);
      return verticesOf(scene);
    },
  };
}

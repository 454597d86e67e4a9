// What an application with three.js does with a .glb: loader and mixer, nothing of the viewer's own.
import {AnimationMixer, Mesh, Vector3} from 'three';
import {MeshoptDecoder} from 'three/addons/libs/meshopt_decoder.module.js';
import {GLTFLoader} from 'three/addons/loaders/GLTFLoader.js';

let mixer, meshes;

window.load = async (base64) => {
  const bytes = Uint8Array.from(atob(base64), (character) => character.charCodeAt(0));
  const gltf = await new GLTFLoader().setMeshoptDecoder(MeshoptDecoder).parseAsync(bytes.buffer, '');
  meshes = [];
  gltf.scene.traverse((object) => { if (object instanceof Mesh) meshes.push(object); });
  mixer = new AnimationMixer(gltf.scene);
  for (const clip of gltf.animations) mixer.clipAction(clip).play();
  return {clips: gltf.animations.map(({name, duration}) => ({name, duration})),
          targets: Object.keys(meshes[0].morphTargetDictionary ?? {}), joints: meshes[0].skeleton?.bones.length ?? 0};
};

// World positions of all vertices and their normals, z up. Without a time: as the file shows them where nobody plays it.
window.pose = (time) => {
  if (time !== undefined) mixer.setTime(time);
  const positions = [], normals = [];
  for (const mesh of meshes) {
    mesh.updateWorldMatrix(true, false);
    mesh.skeleton?.bones[0].updateWorldMatrix(true, true);
    for (let i = 0; i < mesh.geometry.attributes.position.count; ++i) {
      const p = mesh.getVertexPosition(i, new Vector3()).applyMatrix4(mesh.matrixWorld);
      positions.push([p.x, -p.z, p.y]);
      const n = new Vector3().fromBufferAttribute(mesh.geometry.attributes.normal, i);
      mesh.morphTargetInfluences?.forEach((weight, t) => {
        n.addScaledVector(new Vector3().fromBufferAttribute(mesh.geometry.morphAttributes.normal[t], i), weight);
      });
      n.normalize();
      normals.push([n.x, -n.z, n.y]);
    }
  }
  return {positions, normals};
};

// What the page holds: the plant with its morph targets, and their weights over one loop.
import {AnimationClip, Mesh, MeshStandardMaterial, Object3D, Vector3} from 'three';
import {MeshoptDecoder} from 'three/addons/libs/meshopt_decoder.module.js';
import {GLTFLoader} from 'three/addons/loaders/GLTFLoader.js';

export interface Facts {
  period_s: number;
  frames_per_second: number;
  wind_speed_m_s: number;
  heading_deg: number;
  seed: number;
  frequencies_hz: number[];  // of the modes
  static_shapes: number;
}

// Of a morph target: under the mean wind; a mode; or what stands for the modes left out.
export type TargetKind = 'lean' | 'mode' | 'static';

export type PlantMesh = Mesh<Mesh['geometry'], MeshStandardMaterial>;

export interface Loop {
  name: string;
  facts: Facts;
  root: Object3D;
  meshes: PlantMesh[];       // the parts of the surface, as bark and leaves, of every instance
  timeShifts: number[];      // [s] for each mesh how far its instance is ahead of the weights below
  targetKinds: TargetKind[];
  targetModes: number[];     // for each morph target its mode from 1, 0 for what is no mode
  times: ArrayLike<number>;  // [s] keys, 0 … period
  weights: ArrayLike<number>;  // keys x targets
}

// From base64 and gzip.
export async function unpack(text: string): Promise<ArrayBuffer> {
  const characters = atob(text);
  const bytes = new Uint8Array(characters.length);
  for (let i = 0; i < bytes.length; ++i) bytes[i] = characters.charCodeAt(i);
  return new Response(new Blob([bytes]).stream().pipeThrough(new DecompressionStream('gzip'))).arrayBuffer();
}

// Of the node that a mesh belongs to: the mesh itself, or where it has several parts the group around them.
function timeShiftOf(mesh: Object3D): number {
  return mesh.userData.tremula?.time_shift_s ?? mesh.parent?.userData.tremula?.time_shift_s ?? 0;
}

export async function readLoop(glb: ArrayBuffer): Promise<Loop> {
  const gltf = await new GLTFLoader().setMeshoptDecoder(MeshoptDecoder).parseAsync(glb, '');
  gltf.scene.updateMatrixWorld(true);  // positions are whole numbers; the scale that makes metres of them stands above
  const meshes: PlantMesh[] = [];
  gltf.scene.traverse((object) => {
    if (object instanceof Mesh) meshes.push(object as PlantMesh);
  });
  const shifts = meshes.map(timeShiftOf);
  const clip: AnimationClip | undefined = gltf.animations[0];
  return {
    name: gltf.scene.name,
    facts: gltf.scene.userData.tremula,
    root: gltf.scene,
    meshes,
    timeShifts: shifts.map((shift) => shift - shifts[0]),
    targetKinds: meshes[0].userData.targetKinds ?? [],
    targetModes: meshes[0].userData.targetModes ?? [],
    times: clip?.tracks[0].times ?? [0],
    weights: clip?.tracks[0].values ?? [],
  };
}

// Linear between keys, as displacement_at() of the library. The loop goes on before its begin and after its end.
export function weightsAt(loop: Loop, anyTime: number): number[] {
  const {times, weights} = loop;
  const period = times[times.length - 1];
  const time = anyTime >= 0 && anyTime <= period ? anyTime : anyTime - period * Math.floor(anyTime / period);
  const count = loop.targetKinds.length;
  let low = 0, high = times.length - 1;
  while (high - low > 1) {
    const middle = (low + high) >> 1;
    if (times[middle] <= time) low = middle;
    else high = middle;
  }
  const part = high > low ? Math.min(Math.max((time - times[low]) / (times[high] - times[low]), 0), 1) : 0;
  return Array.from({length: count}, (_, i) => {
    const before = weights[low * count + i];
    return before + part * (weights[high * count + i] - before);
  });
}

// Finds vertices by one number that runs through all meshes.
export class Vertices {
  readonly count: number;

  constructor(private readonly loop: Loop) {
    this.count = loop.meshes.reduce((sum, mesh) => sum + mesh.geometry.attributes.position.count, 0);
  }

  // World position [m] with z up, as in every other file, under the weights that the meshes have now.
  position(index: number): [number, number, number] {
    const [mesh, i] = this.find(index);
    const p = mesh.getVertexPosition(i, new Vector3()).applyMatrix4(mesh.matrixWorld);
    return [p.x, -p.z, p.y];
  }

  branch(index: number): number { return this.attribute(index, '_branch'); }
  along(index: number): number { return this.attribute(index, '_along'); }

  private attribute(index: number, name: string): number {
    const [mesh, i] = this.find(index);
    return mesh.geometry.attributes[name].getX(i);
  }

  private find(index: number): [Mesh, number] {
    for (const mesh of this.loop.meshes) {
      const count = mesh.geometry.attributes.position.count;
      if (index < count) return [mesh, index];
      index -= count;
    }
    throw new RangeError('no such vertex');
  }
}

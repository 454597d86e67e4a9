// What the page holds: the plant, and how it moves over one loop.
import {Mesh, MeshStandardMaterial, Object3D, SkinnedMesh, Vector3, type Box3, type BufferAttribute, type WebGLRenderer} from 'three';
import {MeshoptDecoder} from 'three/addons/libs/meshopt_decoder.module.js';
import {GLTFLoader, type GLTF} from 'three/addons/loaders/GLTFLoader.js';
import {Bones, ShapeTable, type ClipFacts, type ShapeFacts} from './bones';
import {Morphs} from './morphs';
import type {Movement} from './movement';

export interface Facts {
  period_s: number;
  repeats?: boolean;         // false: a clip with an end
  frames_per_second: number;
  wind_speed_m_s: number;
  heading_deg: number;
  seed: number;
  frequencies_hz: number[];  // of the modes
  scales?: boolean;          // false: the motion does not grow with the wind
  clips?: ClipFacts[];       // on bones
  shapes?: ShapeFacts;
}

export type PlantMesh = Mesh<Mesh['geometry'], MeshStandardMaterial>;

export interface Loop {
  name: string;
  facts: Facts;
  root: Object3D;
  meshes: PlantMesh[];  // the parts of the surface, as bark and leaves, of every instance
  movement: Movement;
  vertices: VertexTable;
  field?: Field;        // of a meadow, what drifts, painted trees
}

// The meshes of these do not say where they are, and most are not to be looked at from aside.
export interface Field {
  extent: Box3;         // [m] y up
  view: 'over' | 'through' | 'beside';
  weather: 'fair' | 'rain' | 'snow';
  textureRows: number;  // of the largest texture
  castsShadow: boolean;
  told: string;         // what it has, in place of modes
}

// Finds vertices by one number that runs through all meshes.
export interface VertexTable {
  readonly count: number;
  // World position [m] with z up, as in every other file, of the plant as it now stands.
  position(index: number, renderer: WebGLRenderer): [number, number, number];
  branch(index: number): number;
  along(index: number): number;
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

async function movementOf(gltf: GLTF, meshes: PlantMesh[], facts: Facts): Promise<Movement> {
  const shifts = meshes.map(timeShiftOf), fromFirst = shifts.map((shift) => shift - shifts[0]);
  const skinned = meshes.filter((mesh): mesh is PlantMesh & SkinnedMesh => mesh instanceof SkinnedMesh);
  if (skinned.length === 0) return new Morphs(meshes, fromFirst, gltf.animations[0], facts);
  const read = (index: number): Promise<BufferAttribute> => gltf.parser.getDependency('accessor', index);
  const table = facts.shapes && await ShapeTable.read(facts.shapes, read);
  return new Bones(gltf.scene, skinned, fromFirst, gltf.animations, facts.clips ?? [], table,
                   facts.repeats ?? true);
}

export async function readLoop(glb: ArrayBuffer): Promise<Loop> {
  const gltf = await new GLTFLoader().setMeshoptDecoder(MeshoptDecoder).parseAsync(glb, '');
  gltf.scene.updateMatrixWorld(true);  // positions are whole numbers; the scale that makes metres of them stands above
  const meshes: PlantMesh[] = [];
  gltf.scene.traverse((object) => {
    if (object instanceof Mesh) meshes.push(object as PlantMesh);
  });
  const facts = gltf.scene.userData.tremula as Facts;
  return {name: gltf.scene.name, facts, root: gltf.scene, meshes, movement: await movementOf(gltf, meshes, facts),
          vertices: new MeshVertices(meshes)};
}

class MeshVertices implements VertexTable {
  readonly count: number;

  constructor(private readonly meshes: PlantMesh[]) {
    this.count = meshes.reduce((sum, mesh) => sum + mesh.geometry.attributes.position.count, 0);
  }

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
    for (const mesh of this.meshes) {
      const count = mesh.geometry.attributes.position.count;
      if (index < count) return [mesh, index];
      index -= count;
    }
    throw new RangeError('no such vertex');
  }
}

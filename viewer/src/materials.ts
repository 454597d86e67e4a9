// How the parts of a surface look, from nothing but the names and colours of their materials and the texture
// coordinates in the file. Parts that have no entry in `dresses` are plain.
import {BufferAttribute, BufferGeometry, Color, MeshStandardMaterial} from 'three';
import type {PlantMesh} from './loop';

// Value noise that closes around the stem: x runs from 0 to `around`.
const barkNoise = /* glsl */ `
  float barkHash(vec2 cell) { return fract(sin(dot(cell, vec2(127.1, 311.7))) * 43758.5453); }
  float barkNoise(vec2 p, float around) {
    vec2 cell = floor(p), t = smoothstep(0.0, 1.0, p - cell);
    vec2 left = vec2(mod(cell.x, around), cell.y), right = vec2(mod(cell.x + 1.0, around), cell.y);
    return mix(mix(barkHash(left), barkHash(right), t.x), mix(barkHash(left + vec2(0, 1)), barkHash(right + vec2(0, 1)), t.x), t.y);
  }
  // Faded where a cell is no larger than a pixel, so that twigs do not shimmer.
  float barkLayer(vec2 scale) {
    vec2 p = vUv * scale, size = fwidth(p);
    return (barkNoise(p, scale.x) - 0.5) * (1.0 - smoothstep(0.3, 1.0, max(size.x, size.y)));
  }
`;

function dressBark(material: MeshStandardMaterial): void {
  material.defines = {...material.defines, USE_UV: ''};
  material.onBeforeCompile = (shader) => {
    shader.fragmentShader = shader.fragmentShader
        .replace('void main() {', `${barkNoise}\nvoid main() {`)
        .replace('#include <color_fragment>', `#include <color_fragment>
          float furrows = barkLayer(vec2(14, 3)) * 0.7 + barkLayer(vec2(33, 9)) * 0.5 + barkLayer(vec2(5, 1.3)) * 0.5;
          diffuseColor.rgb *= (1.0 + furrows) * mix(vec3(0.97, 1.0, 0.94), vec3(1.03, 1.0, 1.05), furrows + 0.5);`);
  };
}

// Leaves let light through; seen from below against the sun they glow.
function dressLeaves(material: MeshStandardMaterial): void {
  material.vertexColors = true;
  material.onBeforeCompile = (shader) => {
    shader.fragmentShader = shader.fragmentShader.replace('#include <opaque_fragment>', `
      #if NUM_DIR_LIGHTS > 0
        float through = max(dot(-normal, directionalLights[0].direction), 0.0);
        outgoingLight += diffuseColor.rgb * vec3(0.32, 0.38, 0.10) * directionalLights[0].color * through;
      #endif
      #include <opaque_fragment>`);
  };
}

// The vertices of a leaf hang together by its triangles. Returns for each vertex the lowest one of its leaf.
function leafOfVertices(geometry: BufferGeometry): Uint32Array {
  const leaf = Uint32Array.from({length: geometry.attributes.position.count}, (_, i) => i);
  const find = (i: number): number => {
    while (leaf[i] !== i) i = leaf[i] = leaf[leaf[i]];
    return i;
  };
  const index = geometry.index!;
  for (let i = 0; i < index.count; i += 3) {
    const corners = [0, 1, 2].map((k) => find(index.getX(i + k)));
    const lowest = Math.min(...corners);
    for (const corner of corners) leaf[corner] = lowest;
  }
  for (let i = 0; i < leaf.length; ++i) leaf[i] = find(i);
  return leaf;
}

// A fixed number between 0 and 1 for every whole number.
function fraction(n: number): number {
  let h = Math.imul(n ^ 0x9e3779b9, 0x85ebca6b);
  h = Math.imul(h ^ (h >>> 13), 0xc2b2ae35);
  return ((h ^ (h >>> 16)) >>> 0) / 2 ** 32;
}

function colorLeaves(geometry: BufferGeometry, base: Color): void {
  const hsl = {h: 0, s: 0, l: 0};
  base.getHSL(hsl);
  const leaf = leafOfVertices(geometry);
  const colors = new Float32Array(3 * leaf.length);
  const color = new Color();
  for (let i = 0; i < leaf.length; ++i) {
    const a = fraction(2 * leaf[i]) - 0.5, b = fraction(2 * leaf[i] + 1) - 0.5;
    color.setHSL(hsl.h + 0.04 * a, hsl.s * (1 + 0.25 * b), hsl.l * (1 + 0.4 * a + 0.35 * b));
    // The material's own colour still stands; this says by how much a leaf differs from it.
    colors.set([color.r / base.r, color.g / base.g, color.b / base.b], 3 * i);
  }
  geometry.setAttribute('color', new BufferAttribute(colors, 3));
}

const dresses: Record<string, (mesh: PlantMesh) => void> = {
  bark: (mesh) => dressBark(mesh.material),
  leaf: (mesh) => {
    // Instances share their geometry.
    if (!mesh.geometry.attributes.color) colorLeaves(mesh.geometry, mesh.material.color);
    dressLeaves(mesh.material);
  },
};

export function dress(meshes: PlantMesh[]): void {
  for (const mesh of meshes) {
    // GLTFLoader may hand out variants of one material; each mesh gets its own.
    mesh.material = mesh.material.clone();
    dresses[mesh.material.name]?.(mesh);
  }
}
